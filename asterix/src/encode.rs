//! Values to octets.

use crate::table::{Category, Item, MOST_POSITIONS, Part, Structure};
use crate::value::{FieldValue, ValueError};
use std::fmt;

/// Why a record was not written. Nothing of it remains in the datagram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodeError {
    /// Item, and subitem after a slash.
    pub item: String,
    /// Field; empty where the item has one field only, or where the item itself is wrong.
    pub field: String,
    /// Why.
    pub reason: Reason,
}

/// What is wrong with what was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// A value that its field cannot carry.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// More or fewer values than fields.
    #[error("{given} values for {fields} fields")]
    Values {
        /// Values given.
        given: usize,
        /// Fields of the item (of one repetition, where it is repeated).
        fields: usize,
    },
    /// Items go in the order of the profile, each once.
    #[error("comes after an item of a later position, or twice")]
    Order,
    /// The row belongs to another category or item.
    #[error("is not an item of this table")]
    Foreign,
    /// The item has no such field.
    #[error("unknown name")]
    Unknown,
    /// More than 255 repetitions, or more than 254 octets of an explicit item.
    #[error("too long")]
    TooLong,
    /// Compound items are written subitem by subitem, others by values.
    #[error("has another structure")]
    Structure,
    /// A record without items.
    #[error("a record needs an item")]
    Empty,
    /// A record larger than a datagram may be.
    #[error("a record of {octets} octets, a datagram holds {limit}")]
    RecordTooLarge {
        /// Octets of the block with this record alone.
        octets: usize,
        /// Octets of a datagram.
        limit: usize,
    },
}

impl EncodeError {
    /// An error that concerns an item as a whole.
    #[must_use]
    pub fn item(id: &str, reason: Reason) -> Self {
        Self { item: id.to_owned(), field: String::new(), reason }
    }

    fn under(mut self, id: &str) -> Self {
        self.item = format!("{id}/{}", self.item);
        self
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { item, field, reason } = self;
        match (item.is_empty(), field.is_empty()) {
            (true, _) => write!(f, "{reason}"),
            (_, true) => write!(f, "item {item}: {reason}"),
            _ => write!(f, "item {item}, field {field}: {reason}"),
        }
    }
}

impl std::error::Error for EncodeError {}

/// Writes the items of a record, or the subitems of a compound item, in the order of their table.
#[derive(Debug)]
pub struct ItemWriter<'a> {
    out: &'a mut Vec<u8>,
    table: &'static [Option<&'static Item>],
    /// Where the field specification begins, and how many octets it was given.
    start: usize,
    room: usize,
    present: u64,
}

impl<'a> ItemWriter<'a> {
    fn new(out: &'a mut Vec<u8>, table: &'static [Option<&'static Item>], room: usize) -> Self {
        let start = out.len();
        out.extend_from_slice(&[0; MOST_POSITIONS / 7][..room]);
        Self { out, table, start, room, present: 0 }
    }

    #[inline]
    fn claim(&mut self, item: &'static Item) -> Result<(), EncodeError> {
        let position = usize::from(item.position);
        if !self.table.get(position).copied().flatten().is_some_and(|own| std::ptr::eq(own, item)) {
            return Err(EncodeError::item(item.id, Reason::Foreign));
        }
        if self.present >> position != 0 {
            return Err(EncodeError::item(item.id, Reason::Order));
        }
        self.present |= 1 << position;
        Ok(())
    }

    /// Writes an item from the values of its fields, in order, spare ones left out.
    ///
    /// A fixed item takes a value for every field, a repetitive one a multiple of them; an extended item has as many
    /// parts as hold the values given (fields after the last one are zero).
    ///
    /// # Errors
    /// If a value does not fit its field, their number is wrong, or the item comes too late.
    #[inline]
    pub fn put<V: FieldValue>(
        &mut self,
        item: &'static Item,
        values: &[V],
    ) -> Result<(), EncodeError> {
        self.claim(item)?;
        let count = |fields| Reason::Values { given: values.len(), fields };
        let wrong = |fields| EncodeError::item(item.id, count(fields));
        let error = |(field, reason)| EncodeError {
            item: item.id.into(),
            field: String::from(field),
            reason: Reason::Value(reason),
        };
        match &item.structure {
            Structure::Fixed(part) => {
                if part.values() != values.len() {
                    return Err(wrong(part.values()));
                }
                write_part(self.out, part, values, false).map_err(error)
            }
            Structure::Extended(parts) => {
                let mut rest = values;
                for (index, part) in parts.iter().enumerate() {
                    let (own, after) = rest.split_at(part.values().min(rest.len()));
                    let more = !after.is_empty() && index + 1 < parts.len();
                    write_part(self.out, part, own, more).map_err(error)?;
                    rest = after;
                    if !more {
                        break;
                    }
                }
                if values.is_empty() || !rest.is_empty() {
                    return Err(wrong(item.fields()));
                }
                Ok(())
            }
            Structure::Counted(part) => {
                let fields = part.values();
                if !values.len().is_multiple_of(fields) {
                    return Err(wrong(fields));
                }
                let count = u8::try_from(values.len() / fields)
                    .map_err(|_| EncodeError::item(item.id, Reason::TooLong))?;
                self.out.push(count);
                for own in values.chunks_exact(fields) {
                    write_part(self.out, part, own, false).map_err(error)?;
                }
                Ok(())
            }
            Structure::Chained(part) => {
                let fields = part.values();
                if values.is_empty() || !values.len().is_multiple_of(fields) {
                    return Err(wrong(fields));
                }
                let last = values.len() / fields - 1;
                for (index, own) in values.chunks_exact(fields).enumerate() {
                    write_part(self.out, part, own, index < last).map_err(error)?;
                }
                Ok(())
            }
            Structure::Compound(_) | Structure::Explicit(_) => {
                Err(EncodeError::item(item.id, Reason::Structure))
            }
        }
    }

    /// Writes a compound item, or an explicit one with a known structure. If `write` writes no subitem, the item is
    /// left out.
    ///
    /// # Errors
    /// Those of `write`, with this item's name before the subitem's.
    pub fn compound(
        &mut self,
        item: &'static Item,
        write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let before = self.present;
        self.claim(item)?;
        let start = self.out.len();
        let (table, explicit) = match item.structure {
            Structure::Compound(table) => (table, false),
            Structure::Explicit(table) if !table.is_empty() => (table, true),
            _ => return Err(EncodeError::item(item.id, Reason::Structure)),
        };
        if explicit {
            self.out.push(0);
        }
        let room = if explicit { 1 } else { table.len().div_ceil(7) };
        let mut inner = ItemWriter::new(self.out, table, room);
        write(&mut inner).map_err(|e| e.under(item.id))?;
        if inner.present == 0 {
            self.out.truncate(start);
            self.present = before;
            return Ok(());
        }
        if explicit {
            inner.out[start + 1] = (inner.present as u8).reverse_bits();
            let length = self.out.len() - start;
            self.out[start] =
                u8::try_from(length).map_err(|_| EncodeError::item(item.id, Reason::TooLong))?;
        } else {
            inner.close();
        }
        Ok(())
    }

    /// Writes a compound item that is there but names no subitem.
    pub(crate) fn compound_of_nothing(&mut self, item: &'static Item) -> Result<(), EncodeError> {
        self.claim(item)?;
        let explicit = matches!(item.structure, Structure::Explicit(_));
        self.out.extend_from_slice(if explicit { &[2, 0] } else { &[0] });
        Ok(())
    }

    /// Writes an explicit item (`RE`, `SP`) from its contents, the length octet not among them.
    ///
    /// # Errors
    /// If the contents are longer than 254 octets or the item is not explicit.
    pub fn explicit(&mut self, item: &'static Item, contents: &[u8]) -> Result<(), EncodeError> {
        self.claim(item)?;
        if !matches!(item.structure, Structure::Explicit(_)) {
            return Err(EncodeError::item(item.id, Reason::Structure));
        }
        let length = u8::try_from(contents.len() + 1)
            .map_err(|_| EncodeError::item(item.id, Reason::TooLong))?;
        self.out.push(length);
        self.out.extend_from_slice(contents);
        Ok(())
    }

    /// Fills in the field specification and closes the gap behind it.
    fn close(self) {
        let used = (64 - self.present.leading_zeros() as usize).div_ceil(7).max(1);
        let mut left = self.present;
        for index in 0..used {
            let more = u8::from(index + 1 < used);
            self.out[self.start + index] = (left as u8 & 0x7f).reverse_bits() | more;
            left >>= 7;
        }
        if used < self.room {
            let end = self.out.len();
            self.out.copy_within(self.start + self.room..end, self.start + used);
            self.out.truncate(end - (self.room - used));
        }
    }
}

/// Writes a part; missing values are zeros. `more`: sets the extension bit.
#[inline]
fn write_part<V: FieldValue>(
    out: &mut Vec<u8>,
    part: &Part,
    values: &[V],
    more: bool,
) -> Result<(), (&'static str, ValueError)> {
    let mut values = values.iter();
    let (mut word, mut bits) = (0u64, 0u32);
    for field in part.fields {
        let width = u32::from(field.bits);
        if bits + width > 64 {
            while bits >= 8 {
                bits -= 8;
                out.push((word >> bits) as u8);
            }
        }
        let raw = match field.kind {
            crate::table::Kind::Spare => 0,
            _ => match values.next() {
                Some(value) => value.raw(field).map_err(|e| (field.name, e))?,
                None => 0,
            },
        };
        word = word << width | raw;
        bits += width;
    }
    if bits % 8 == 7 {
        word = word << 1 | u64::from(more);
        bits += 1;
    }
    // Eight octets at once, of which the first ones stay: cheaper than a copy of some length.
    if bits > 0 {
        let end = out.len() + (bits / 8) as usize;
        out.extend_from_slice(&(word << (64 - bits)).to_be_bytes());
        out.truncate(end);
    }
    Ok(())
}

/// Appends one record (without a block around it).
///
/// # Errors
/// Those of `write`; then `out` is as it was.
#[inline]
pub fn record(
    out: &mut Vec<u8>,
    category: &'static Category,
    write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
) -> Result<(), EncodeError> {
    let start = out.len();
    let mut items = ItemWriter::new(out, category.uap, category.uap.len().div_ceil(7));
    let written = write(&mut items).and_then(|()| match items.present {
        0 => Err(EncodeError { item: String::new(), field: String::new(), reason: Reason::Empty }),
        _ => Ok(()),
    });
    match written {
        Ok(()) => items.close(),
        Err(_) => out.truncate(start),
    }
    written
}

/// Octets of a datagram that every network carries in one piece with room for tunnels.
pub const DATAGRAM_LIMIT: usize = 1400;

/// Packs records into blocks and blocks into datagrams: records of one category share a block, several blocks share a
/// datagram, a record is never split.
#[derive(Debug)]
pub struct Packer {
    limit: usize,
    done: Vec<Vec<u8>>,
    current: Vec<u8>,
    /// Beginning and category of the open block.
    open: Option<(usize, u8)>,
}

impl Packer {
    /// A packer of datagrams of at most `limit` octets (see [`DATAGRAM_LIMIT`]; at most 65 507).
    #[must_use]
    pub fn new(limit: usize) -> Self {
        let limit = limit.min(65_507);
        Self { limit, done: Vec::new(), current: Vec::with_capacity(limit), open: None }
    }

    /// Adds a record.
    ///
    /// # Errors
    /// Those of `write`, or if the record is larger than a datagram; then it is left out.
    pub fn record(
        &mut self,
        category: &'static Category,
        write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let fits = matches!(self.open, Some((_, number)) if number == category.number);
        let before = (self.current.len(), self.open);
        if !fits {
            self.open = Some((self.current.len(), category.number));
            self.current.extend_from_slice(&[category.number, 0, 0]);
        }
        let from = self.current.len();
        if let Err(e) = record(&mut self.current, category, write) {
            self.current.truncate(before.0);
            self.open = before.1;
            return Err(e);
        }
        if self.current.len() > self.limit {
            // The record begins the next datagram.
            let record = self.current.split_off(from);
            self.current.truncate(before.0);
            let octets = 3 + record.len();
            if octets > self.limit {
                self.open = before.1;
                let reason = Reason::RecordTooLarge { octets, limit: self.limit };
                return Err(EncodeError { item: String::new(), field: String::new(), reason });
            }
            self.open = before.1;
            self.close_datagram();
            self.open = Some((0, category.number));
            self.current.extend_from_slice(&[category.number, 0, 0]);
            self.current.extend_from_slice(&record);
        }
        self.close_length();
        Ok(())
    }

    /// The open block's length, as of now.
    fn close_length(&mut self) {
        if let Some((start, _)) = self.open {
            let length = (self.current.len() - start) as u16;
            self.current[start + 1..start + 3].copy_from_slice(&length.to_be_bytes());
        }
    }

    fn close_datagram(&mut self) {
        if !self.current.is_empty() {
            let next = Vec::with_capacity(self.limit);
            self.done.push(std::mem::replace(&mut self.current, next));
        }
        self.open = None;
    }

    /// Ends the open block: the next record begins another one, in the same datagram if it fits.
    pub fn end_block(&mut self) {
        self.open = None;
    }

    /// The datagrams so far, the open one too.
    #[must_use]
    pub fn take(&mut self) -> Vec<Vec<u8>> {
        self.close_datagram();
        std::mem::take(&mut self.done)
    }
}
