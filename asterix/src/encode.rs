//! Values to octets.

use crate::buffer::Buffer;
use crate::table::{Category, Class, Field, Item, Part, Structure};
use crate::value::{FieldValue, ValueError};
use std::fmt;

/// Why a record was not written. Nothing of it remains in the datagram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodeError(Box<Refused>);

/// What an [`EncodeError`] says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Item, and subitem after a slash; empty where the record as a whole is wrong.
    pub item: String,
    /// Field; empty where the item has one field only, or where the item itself is wrong.
    pub field: String,
    /// Why.
    pub reason: Reason,
}

impl std::ops::Deref for EncodeError {
    type Target = Refused;

    fn deref(&self) -> &Refused {
        &self.0
    }
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
    #[cold]
    #[must_use]
    pub fn item(id: &str, reason: Reason) -> Self {
        Self::field(id, "", reason)
    }

    /// An error that concerns a field of an item.
    #[cold]
    #[must_use]
    pub fn field(id: &str, field: &str, reason: Reason) -> Self {
        Self(Box::new(Refused { item: id.to_owned(), field: field.to_owned(), reason }))
    }

    #[cold]
    fn under(mut self, id: &str) -> Self {
        self.0.item = format!("{id}/{}", self.0.item);
        self
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Refused { item, field, reason } = &**self;
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
    out: &'a mut Buffer,
    table: &'static [Option<&'static Item>],
    /// Where the field specification begins, and how many octets it was given.
    start: usize,
    room: usize,
    /// The first position that it has no bit for.
    last: usize,
    /// The field specification so far, without extension bits.
    present: u64,
}

impl<'a> ItemWriter<'a> {
    #[inline]
    fn new(out: &'a mut Buffer, table: &'static [Option<&'static Item>], room: usize) -> Self {
        let start = out.end;
        out.word(0, room);
        Self { out, table, start, room, last: 7 * room, present: 0 }
    }

    /// Notes that the item is there.
    #[inline(always)]
    fn claim(&mut self, item: &'static Item) -> Result<(), EncodeError> {
        let position = usize::from(item.position);
        let own = matches!(self.table.get(position), Some(Some(own)) if own.is(item));
        // Later positions have lower bits.
        if !own || self.present & (item.bit | (item.bit - 1)) != 0 {
            return Err(misplaced(item, own));
        }
        self.present |= item.bit;
        if position >= self.last {
            self.widen(position / 7 + 1);
        }
        Ok(())
    }

    /// More octets for the field specification: what stands behind it moves on.
    #[cold]
    fn widen(&mut self, room: usize) {
        let (from, end) = (self.start + self.room, self.out.end);
        self.out.word(0, room - self.room);
        self.out.octets.copy_within(from..end, self.start + room);
        (self.room, self.last) = (room, 7 * room);
    }

    /// Writes an item from the values of its fields, in order, spare ones left out.
    ///
    /// A fixed item takes a value for every field, a repetitive one a multiple of them; an extended item has as many
    /// parts as hold the values given (fields after the last one are zero).
    ///
    /// # Errors
    /// If a value does not fit its field, their number is wrong, or the item comes too late.
    #[inline(always)]
    pub fn put<V: FieldValue>(
        &mut self,
        item: &'static Item,
        values: &[V],
    ) -> Result<(), EncodeError> {
        self.claim(item)?;
        let places = item.code_places();
        if !places.is_empty() && values.first().is_some_and(|first| first.code().is_some()) {
            return write_codes(self.out, item, values, places);
        }
        match &item.structure {
            Structure::Fixed(part) if part.octets <= 8 => {
                if part.values() != values.len() {
                    return Err(wrong(item, part.values(), values.len()));
                }
                write_short_part(self.out, item, part, values, false)
            }
            _ => self.put_rare(item, values),
        }
    }

    /// Items that are repeated, long, or of parts with more than codes.
    #[inline(never)]
    fn put_rare<V: FieldValue>(
        &mut self,
        item: &'static Item,
        values: &[V],
    ) -> Result<(), EncodeError> {
        match &item.structure {
            Structure::Fixed(part) => {
                if part.values() != values.len() {
                    return Err(wrong(item, part.values(), values.len()));
                }
                write_part(self.out, item, part, values, false)
            }
            Structure::Extended(parts) => {
                let mut rest = values;
                for (index, part) in parts.iter().enumerate() {
                    let (own, after) = rest.split_at(part.values().min(rest.len()));
                    let more = !after.is_empty() && index + 1 < parts.len();
                    write_part(self.out, item, part, own, more)?;
                    rest = after;
                    if !more {
                        break;
                    }
                }
                if values.is_empty() || !rest.is_empty() {
                    return Err(wrong(item, item.fields(), values.len()));
                }
                Ok(())
            }
            Structure::Counted(part) => {
                let fields = part.values();
                if !values.len().is_multiple_of(fields) {
                    return Err(wrong(item, fields, values.len()));
                }
                let count = u8::try_from(values.len() / fields)
                    .map_err(|_| EncodeError::item(item.id, Reason::TooLong))?;
                self.out.extend(&[count]);
                for own in values.chunks_exact(fields) {
                    write_part(self.out, item, part, own, false)?;
                }
                Ok(())
            }
            Structure::Chained(part) => {
                let fields = part.values();
                if values.is_empty() || !values.len().is_multiple_of(fields) {
                    return Err(wrong(item, fields, values.len()));
                }
                let last = values.len() / fields - 1;
                for (index, own) in values.chunks_exact(fields).enumerate() {
                    write_part(self.out, item, part, own, index < last)?;
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
    #[inline]
    pub fn compound(
        &mut self,
        item: &'static Item,
        write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let before = self.present;
        self.claim(item)?;
        let start = self.out.end;
        let (table, explicit) = match item.structure {
            Structure::Compound(table) => (table, false),
            Structure::Explicit(table) if !table.is_empty() => (table, true),
            _ => return Err(EncodeError::item(item.id, Reason::Structure)),
        };
        if explicit {
            self.out.extend(&[0]);
        }
        let mut inner = ItemWriter::new(self.out, table, 1);
        write(&mut inner).map_err(|e| e.under(item.id))?;
        if inner.present == 0 {
            self.out.end = start;
            self.present = before;
            return Ok(());
        }
        if explicit {
            // Eight positions in its one octet, of which the eighth has the place of an extension bit.
            inner.out.octets[start + 1] = (inner.present >> 56 | inner.present >> 55 & 1) as u8;
            let length = self.out.end - start;
            self.out.octets[start] =
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
        self.out.extend(if explicit { &[2, 0] } else { &[0] });
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
        self.out.extend(&[length]);
        self.out.extend(contents);
        Ok(())
    }

    /// Fills in the field specification and closes the gap behind it.
    #[inline]
    fn close(self) -> usize {
        let used = 8 - self.present.trailing_zeros() as usize / 8;
        let word = (self.present | extension_bits(used)).to_be_bytes();
        let octets = &mut self.out.octets[self.start..self.out.end];
        if used < self.room {
            octets.copy_within(self.room.., used);
            self.out.end -= self.room - used;
        }
        if let (1, Some(first)) = (used, octets.first_mut()) {
            *first = word[0];
        } else {
            octets.iter_mut().zip(word).take(used).for_each(|(octet, word)| *octet = word);
        }
        used
    }
}

#[cold]
fn misplaced(item: &Item, own: bool) -> EncodeError {
    EncodeError::item(item.id, if own { Reason::Order } else { Reason::Foreign })
}

#[cold]
fn wrong(item: &Item, fields: usize, given: usize) -> EncodeError {
    EncodeError::item(item.id, Reason::Values { given, fields })
}

#[cold]
fn refused<V: FieldValue>(item: &Item, field: &Field, value: V) -> EncodeError {
    let reason = value.raw(field).err().unwrap_or(ValueError::Kind("another value"));
    EncodeError::field(item.id, field.name, Reason::Value(reason))
}

/// Writes a part; missing values are zeros. `more`: sets the extension bit.
#[inline(always)]
fn write_part<V: FieldValue>(
    out: &mut Buffer,
    item: &Item,
    part: &Part,
    values: &[V],
    more: bool,
) -> Result<(), EncodeError> {
    if part.octets > 8 {
        return write_long_part(out, item, part, values, more);
    }
    write_short_part(out, item, part, values, more)
}

#[inline(always)]
fn write_short_part<V: FieldValue>(
    out: &mut Buffer,
    item: &Item,
    part: &Part,
    values: &[V],
    more: bool,
) -> Result<(), EncodeError> {
    let (mut values, mut word, mut down) = (values.iter(), 0u64, 64u32);
    for field in part.fields {
        down = down.wrapping_sub(u32::from(field.bits));
        if field.work.class == Class::Spare {
            continue;
        }
        let Some(value) = values.next() else { break };
        match value.bits(field) {
            Some(raw) => word |= raw.wrapping_shl(down),
            None => return Err(refused(item, field, *value)),
        }
    }
    // Fields of a part without an extension bit reach its end.
    word |= u64::from(more).wrapping_shl(64 - 8 * u32::from(part.octets));
    out.word(word, usize::from(part.octets));
    Ok(())
}

/// Writes whole numbers into an item of codes, all parts at once.
#[inline(always)]
fn write_codes<V: FieldValue>(
    out: &mut Buffer,
    item: &'static Item,
    values: &[V],
    places: &[(u8, u8)],
) -> Result<(), EncodeError> {
    let (mut word, mut beyond, mut last) = (0u64, 0u64, 64);
    for (value, &(down, bits)) in values.iter().zip(places) {
        let code = value.code().unwrap_or(u64::MAX);
        last = down;
        // Most codes of a status are 0: those have nothing to write.
        if code == 0 {
            continue;
        }
        beyond |= code.wrapping_shr(u32::from(bits));
        word |= code.wrapping_shl(u32::from(down));
    }
    let octets = match &item.structure {
        Structure::Fixed(part) if values.len() == places.len() => usize::from(part.octets),
        // Each part is an octet; up to the one of the last value.
        Structure::Extended(_) if !values.is_empty() && values.len() <= places.len() => {
            let octets = 8 - usize::from(last / 8);
            word |= extension_bits(octets);
            octets
        }
        _ => return Err(wrong(item, places.len(), values.len())),
    };
    if beyond != 0 {
        return Err(first_refused(item, values));
    }
    out.word(word, octets);
    Ok(())
}

/// The lowest bits of all octets but the last one.
#[inline(always)]
fn extension_bits(octets: usize) -> u64 {
    0x0101_0101_0101_0101 & !u64::MAX.wrapping_shr(8 * octets as u32 - 8)
}

#[cold]
fn first_refused<V: FieldValue>(item: &'static Item, values: &[V]) -> EncodeError {
    let fields = item.structure.parts().iter().flat_map(|part| part.fields);
    let carrying = fields.filter(|field| field.work.class != Class::Spare);
    let mut refusals = carrying.zip(values).filter(|(field, value)| value.bits(field).is_none());
    match refusals.next() {
        Some((field, value)) => refused(item, field, *value),
        None => wrong(item, item.fields(), values.len()),
    }
}

#[cold]
fn write_long_part<V: FieldValue>(
    out: &mut Buffer,
    item: &Item,
    part: &Part,
    values: &[V],
    more: bool,
) -> Result<(), EncodeError> {
    let mut values = values.iter();
    let (mut word, mut bits) = (0u64, 0u32);
    for field in part.fields {
        let width = u32::from(field.bits);
        while bits + width > 64 {
            bits -= 8;
            out.extend(&[(word >> bits) as u8]);
        }
        let value = if field.work.class == Class::Spare { None } else { values.next() };
        let raw = match value {
            None => 0,
            Some(value) => value.bits(field).ok_or_else(|| refused(item, field, *value))?,
        };
        word = word << width | raw;
        bits += width;
    }
    if bits % 8 == 7 {
        word = word << 1 | u64::from(more);
        bits += 1;
    }
    while bits > 0 {
        bits -= 8;
        out.extend(&[(word >> bits) as u8]);
    }
    Ok(())
}

/// Appends one record (without a block around it).
///
/// # Errors
/// Those of `write`; then `out` is as it was.
pub fn record(
    out: &mut Vec<u8>,
    category: &'static Category,
    write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
) -> Result<(), EncodeError> {
    let mut buffer = Buffer { end: out.len(), octets: std::mem::take(out) };
    let written = append(&mut buffer, category, &mut 1, write);
    buffer.octets.truncate(buffer.end);
    *out = buffer.octets;
    written
}

/// `room`: octets that the field specification will take, as a guess; then as it was.
#[inline]
pub(crate) fn append(
    out: &mut Buffer,
    category: &'static Category,
    room: &mut usize,
    write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
) -> Result<(), EncodeError> {
    let start = out.end;
    let mut items = ItemWriter::new(out, category.uap, *room);
    let written = write(&mut items).and_then(|()| match items.present {
        0 => Err(EncodeError::item("", Reason::Empty)),
        _ => Ok(()),
    });
    match written {
        Ok(()) => *room = items.close(),
        Err(_) => out.end = start,
    }
    written
}
