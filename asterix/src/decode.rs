//! Octets to records, items and values, without allocating.

use crate::error::{DecodeError, Fault};
use crate::table::{Category, Field, Item, Kind, MOST_POSITIONS, Part, Structure};
use crate::value::{Value, mask, value};

/// The blocks of a datagram, in order. A damaged header ends them; what came before it counts.
#[must_use]
pub fn blocks(datagram: &[u8]) -> Blocks<'_> {
    Blocks { datagram, at: 0 }
}

/// See [`blocks`].
#[derive(Clone, Debug)]
pub struct Blocks<'a> {
    datagram: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, DecodeError>;

    fn next(&mut self) -> Option<Self::Item> {
        let offset = self.at;
        let rest = &self.datagram[offset..];
        let &[number, high, low, ..] = rest else {
            self.at = self.datagram.len();
            let fault = Fault::HeaderCut { left: rest.len() };
            let category = rest.first().copied();
            return (!rest.is_empty()).then_some(Err(header(offset, category, fault)));
        };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let fault = if length < 3 {
            Fault::LengthTooSmall { length }
        } else if length > rest.len() {
            Fault::LengthBeyond { length, left: rest.len() }
        } else {
            self.at += length;
            let category = crate::category(number);
            return Some(Ok(Block { number, category, offset, octets: &rest[..length] }));
        };
        self.at = self.datagram.len();
        Some(Err(header(offset, Some(number), fault)))
    }
}

fn header(offset: usize, category: Option<u8>, fault: Fault) -> DecodeError {
    DecodeError { offset, category, record: 0, item: None, subitem: None, fault }
}

/// A data block: records of one category.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Category number.
    pub number: u8,
    /// Its table; `None` for a category that this crate does not know.
    pub category: Option<&'static Category>,
    /// Where in the datagram the block begins.
    pub offset: usize,
    octets: &'a [u8],
}

impl<'a> Block<'a> {
    /// The whole block with its header.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// Its records in order, none for an unknown category. A damaged one ends them.
    #[must_use]
    pub fn records(&self) -> Records<'a> {
        Records { block: *self, at: 3, record: 0 }
    }

    /// Whether every record is sound; with their number.
    ///
    /// # Errors
    /// The first damage.
    pub fn check(&self) -> Result<usize, DecodeError> {
        let mut count = 0;
        for record in self.records() {
            record?;
            count += 1;
        }
        Ok(count)
    }
}

/// The records of a block, see [`Block::records`].
#[derive(Clone, Debug)]
pub struct Records<'a> {
    block: Block<'a>,
    at: usize,
    record: usize,
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, DecodeError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let category = self.block.category?;
        let rest = &self.block.octets[self.at..];
        if rest.is_empty() {
            return None;
        }
        self.record += 1;
        let offset = self.block.offset + self.at;
        match Record::read(category, rest, offset) {
            Ok(record) => {
                self.at += record.octets.len();
                Some(Ok(record))
            }
            Err(damage) => {
                self.at = self.block.octets.len();
                Some(Err(DecodeError {
                    offset: offset + damage.at,
                    category: Some(category.number),
                    record: self.record,
                    item: damage.item,
                    subitem: damage.subitem,
                    fault: damage.fault,
                }))
            }
        }
    }
}

/// Damage inside a record: `at` octets after its beginning.
struct Damage {
    at: usize,
    item: Option<&'static str>,
    subitem: Option<&'static str>,
    fault: Fault,
}

impl From<Fault> for Damage {
    fn from(fault: Fault) -> Self {
        Self { at: 0, item: None, subitem: None, fault }
    }
}

/// One record; its items have been found and fit.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    /// The table.
    pub category: &'static Category,
    /// Where in the datagram it begins.
    pub offset: usize,
    octets: &'a [u8],
    /// Bit n: position n is there.
    present: u64,
    /// Beginnings of the items that are there, in order, and the end.
    starts: [u16; MOST_POSITIONS + 1],
}

impl<'a> Record<'a> {
    fn read(category: &'static Category, rest: &'a [u8], offset: usize) -> Result<Self, Damage> {
        let (present, mut at) = specification(category.uap, rest)?;
        let mut starts = [0; MOST_POSITIONS + 1];
        let (mut left, mut count) = (present, 0);
        while left != 0 {
            let position = left.trailing_zeros() as usize;
            left &= left - 1;
            let Some(item) = category.uap[position] else {
                return Err(Fault::SparePosition { position: position + 1 }.into());
            };
            // A block has at most 65535 octets.
            starts[count] = at as u16;
            count += 1;
            at += length(item, &rest[at..]).map_err(|damage| Damage {
                at: at + damage.at,
                item: Some(item.id),
                subitem: damage.item,
                fault: damage.fault,
            })?;
        }
        if count == 0 {
            return Err(Fault::Empty.into());
        }
        starts[count] = at as u16;
        Ok(Self { category, offset, octets: &rest[..at], present, starts })
    }

    /// The octets of the record, FSPEC first.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// The items that are there, in order.
    pub fn items(&self) -> impl Iterator<Item = View<'a>> {
        let (uap, octets, starts, mut left) =
            (self.category.uap, self.octets, self.starts, self.present);
        let mut count = 0;
        std::iter::from_fn(move || {
            while left != 0 {
                let position = left.trailing_zeros() as usize;
                left &= left - 1;
                let (from, to) = (usize::from(starts[count]), usize::from(starts[count + 1]));
                count += 1;
                if let Some(item) = uap[position] {
                    return Some(View { item, octets: &octets[from..to] });
                }
            }
            None
        })
    }

    /// The item of this row, if it is there (and the row is of this category).
    #[inline]
    #[must_use]
    pub fn get(&self, item: &'static Item) -> Option<View<'a>> {
        let position = usize::from(item.position);
        let there = self.present >> position & 1 == 1
            && self.category.uap[position].is_some_and(|own| std::ptr::eq(own, item));
        there.then(|| {
            let count = (self.present & ((1 << position) - 1)).count_ones() as usize;
            let (from, to) = (self.starts[count], self.starts[count + 1]);
            View { item, octets: &self.octets[usize::from(from)..usize::from(to)] }
        })
    }

    /// The item of these three digits (or `RE`, `SP`), if it is there.
    #[must_use]
    pub fn find(&self, id: &str) -> Option<View<'a>> {
        self.items().find(|view| view.item.id == id)
    }

    /// First number of an item.
    #[must_use]
    pub fn number(&self, item: &'static Item) -> Option<f64> {
        self.get(item)?.values().next()?.1.number()
    }

    /// The first `N` numbers of an item.
    #[must_use]
    pub fn numbers<const N: usize>(&self, item: &'static Item) -> Option<[f64; N]> {
        let view = self.get(item)?;
        let mut values = view.values();
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = values.next()?.1.number()?;
        }
        Some(numbers)
    }
}

/// An item (or subitem) with its octets.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Its row.
    pub item: &'static Item,
    octets: &'a [u8],
}

impl<'a> View<'a> {
    /// The item's octets.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// The parts: one of a fixed item, those that are there of an extended one, each repetition of
    /// a repetitive one; none of a compound or explicit one.
    #[must_use]
    pub fn parts(&self) -> Parts<'a> {
        let (table, octets) = match &self.item.structure {
            Structure::Fixed(part) | Structure::Chained(part) => {
                (std::slice::from_ref(part), self.octets)
            }
            Structure::Extended(parts) => (*parts, self.octets),
            Structure::Counted(part) => {
                (std::slice::from_ref(part), self.octets.get(1..).unwrap_or_default())
            }
            Structure::Compound(_) | Structure::Explicit(_) => (&[][..], &[][..]),
        };
        Parts { table, octets }
    }

    /// Every field that carries a value, over all parts.
    pub fn values(&self) -> impl Iterator<Item = (&'static Field, Value)> + use<'a> {
        self.parts().flat_map(|part| part.values())
    }

    /// The value of a field by its name; of a repetitive item that of its first repetition.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<Value> {
        self.values().find(|(field, _)| field.name == name).map(|(_, value)| value)
    }

    /// The text of the first field that is one.
    #[must_use]
    pub fn text(&self) -> Option<crate::value::Text> {
        self.values().find_map(|(_, value)| match value {
            Value::Text(text) => Some(text),
            _ => None,
        })
    }

    /// The subitems of a compound item (or of an explicit one with a known structure) that are there.
    pub fn subitems(&self) -> impl Iterator<Item = View<'a>> + use<'a> {
        let (table, mut left, mut octets) = match self.item.structure {
            Structure::Compound(table) => {
                let (present, from) = specification(table, self.octets).unwrap_or((0, 0));
                (table, present, self.octets.get(from..).unwrap_or_default())
            }
            Structure::Explicit(table) if !table.is_empty() && self.octets.len() >= 2 => {
                (table, u64::from(self.octets[1].reverse_bits()), &self.octets[2..])
            }
            _ => (&[][..], 0, &[][..]),
        };
        std::iter::from_fn(move || {
            let position = left.trailing_zeros() as usize;
            let item = (*table.get(position)?)?;
            left &= left - 1;
            let (own, rest) = octets.split_at_checked(length(item, octets).ok()?)?;
            octets = rest;
            Some(View { item, octets: own })
        })
    }

    /// A subitem by its row.
    #[must_use]
    pub fn sub(&self, item: &'static Item) -> Option<View<'a>> {
        self.subitems().find(|view| std::ptr::eq(view.item, item))
    }
}

/// See [`View::parts`].
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    table: &'static [Part],
    octets: &'a [u8],
}

impl<'a> Iterator for Parts<'a> {
    type Item = PartView<'a>;

    #[inline]
    fn next(&mut self) -> Option<PartView<'a>> {
        let part = self.table.first()?;
        let (octets, rest) = self.octets.split_at_checked(usize::from(part.octets))?;
        if self.table.len() > 1 {
            self.table = &self.table[1..];
        }
        self.octets = rest;
        Some(PartView { part, octets })
    }
}

/// A part with its octets.
#[derive(Clone, Copy, Debug)]
pub struct PartView<'a> {
    /// Its layout.
    pub part: &'static Part,
    octets: &'a [u8],
}

impl<'a> PartView<'a> {
    /// Its fields that carry a value.
    #[inline]
    pub fn values(&self) -> impl Iterator<Item = (&'static Field, Value)> + use<'a> {
        let octets = self.octets;
        let short = octets.len() <= 8;
        // A short part is one word, its first bit the word's highest.
        let word = if short { word(octets) << (64 - 8 * octets.len()) } else { 0 };
        let mut fields = self.part.fields.iter();
        let mut bit = 0;
        std::iter::from_fn(move || {
            loop {
                let field = fields.next()?;
                let (from, bits) = (bit, u32::from(field.bits));
                bit += bits;
                if matches!(field.kind, Kind::Spare) {
                    continue;
                }
                let raw = if short {
                    word << from >> (64 - bits)
                } else {
                    let (first, end) = ((from / 8) as usize, bit.div_ceil(8) as usize);
                    self::word(&octets[first..end]) >> (8 * end as u32 - bit) & mask(bits)
                };
                return Some((field, value(field, raw)));
            }
        })
    }

    /// Whether every spare bit is zero.
    #[must_use]
    pub fn spares_are_zero(&self) -> bool {
        let mut bit = 0;
        self.part.fields.iter().all(|field| {
            let from = bit;
            bit += usize::from(field.bits);
            let zero = |b: usize| self.octets[b / 8] >> (7 - b % 8) & 1 == 0;
            !matches!(field.kind, Kind::Spare) || (from..bit).all(zero)
        })
    }
}

/// Up to eight octets as a number, the most significant first.
#[inline]
fn word(octets: &[u8]) -> u64 {
    octets.iter().fold(0, |word, &octet| word << 8 | u64::from(octet))
}

/// Field specification or primary subfield: bit n for position n, and its octets.
#[inline]
fn specification(table: &[Option<&Item>], octets: &[u8]) -> Result<(u64, usize), Fault> {
    let mut present = 0;
    for index in 0..table.len().div_ceil(7) {
        let Some(&octet) = octets.get(index) else { break };
        present |= u64::from(octet.reverse_bits() & 0x7f) << (7 * index);
        if octet & 1 == 0 {
            let last = 64 - present.leading_zeros() as usize;
            return if last > table.len() {
                Err(Fault::SparePosition { position: last })
            } else {
                Ok((present, index + 1))
            };
        }
    }
    Err(Fault::SpecificationEndless)
}

/// Octets of the item at the beginning of `octets`.
#[inline]
fn length(item: &'static Item, octets: &[u8]) -> Result<usize, Damage> {
    let left = octets.len();
    let fits = |needed: usize| {
        if needed <= left { Ok(needed) } else { Err(Damage::from(Fault::Cut { needed, left })) }
    };
    match &item.structure {
        Structure::Fixed(part) => fits(usize::from(part.octets)),
        Structure::Extended(parts) => {
            let mut needed = 0;
            for part in *parts {
                needed = fits(needed + usize::from(part.octets))?;
                if octets[needed - 1] & 1 == 0 {
                    return Ok(needed);
                }
            }
            Err(Fault::PartsBeyond { parts: parts.len() }.into())
        }
        Structure::Counted(part) => {
            fits(1)?;
            let (count, size) = (usize::from(octets[0]), usize::from(part.octets));
            let needed = 1 + count * size;
            if needed <= left {
                Ok(needed)
            } else {
                Err(Fault::RepetitionsBeyond { count, octets: size, left: left - 1 }.into())
            }
        }
        Structure::Chained(part) => {
            let mut needed = 0;
            loop {
                needed = fits(needed + usize::from(part.octets))?;
                if octets[needed - 1] & 1 == 0 {
                    return Ok(needed);
                }
            }
        }
        Structure::Compound(table) => {
            let (present, from) = specification(table, octets)?;
            subitems(table, present, octets, from)
        }
        Structure::Explicit(table) => {
            fits(1)?;
            let length = usize::from(octets[0]);
            let least = if table.is_empty() { 1 } else { 2 };
            if length < least {
                return Err(Fault::ExplicitTooShort { length, needed: least }.into());
            }
            fits(length)?;
            if !table.is_empty() {
                let present = u64::from(octets[1].reverse_bits());
                let used = subitems(table, present, &octets[..length], 2)?;
                if used < length {
                    return Err(Fault::ExplicitLeft(length - used).into());
                }
            }
            Ok(length)
        }
    }
}

fn subitems(
    table: &'static [Option<&'static Item>],
    mut present: u64,
    octets: &[u8],
    mut at: usize,
) -> Result<usize, Damage> {
    while present != 0 {
        let position = present.trailing_zeros() as usize;
        present &= present - 1;
        let Some(item) = table.get(position).copied().flatten() else {
            return Err(Fault::SparePosition { position: position + 1 }.into());
        };
        at += length(item, &octets[at..]).map_err(|damage| Damage {
            at: at + damage.at,
            item: Some(item.id),
            subitem: None,
            fault: damage.fault,
        })?;
    }
    Ok(at)
}
