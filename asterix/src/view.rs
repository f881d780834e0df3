//! Items, parts and fields of a record.

use crate::lengths::{length, specification};
use crate::table::{Class, Field, Item, Part, Structure};
use crate::value::{Value, number, value};

/// A field of an item with its bits, not scaled yet.
#[derive(Clone, Copy, Debug)]
pub struct Datum {
    /// The item, or the subitem of a compound one.
    pub item: &'static Item,
    /// The field.
    pub field: &'static Field,
    /// Its bits.
    pub raw: u64,
}

impl Datum {
    /// What the bits say.
    #[inline]
    #[must_use]
    pub fn value(&self) -> Value {
        value(self.field, self.raw)
    }

    /// As [`Value::number`].
    #[inline]
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        number(self.field, self.raw)
    }
}

/// An item (or subitem) with its octets.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Its row.
    pub item: &'static Item,
    /// From its first octet to the end of the block, and how many of them are its own.
    rest: &'a [u8],
    length: usize,
}

impl<'a> View<'a> {
    #[inline]
    pub(crate) fn new(item: &'static Item, rest: &'a [u8], length: usize) -> Self {
        Self { item, rest, length }
    }

    /// The item's octets.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        &self.rest[..self.length]
    }

    /// The parts: one of a fixed item, those that are there of an extended one, each repetition of
    /// a repetitive one; none of a compound or explicit one.
    #[inline]
    #[must_use]
    pub fn parts(&self) -> Parts<'a> {
        let (rest, left) = (self.rest, self.length);
        match &self.item.structure {
            Structure::Fixed(part) | Structure::Chained(part) => {
                Parts { table: std::slice::from_ref(part), rest, left }
            }
            Structure::Extended(parts) => Parts { table: parts, rest, left },
            Structure::Counted(part) => Parts {
                table: std::slice::from_ref(part),
                rest: rest.get(1..).unwrap_or_default(),
                left: left.saturating_sub(1),
            },
            Structure::Compound(_) | Structure::Explicit(_) => Parts { table: &[], rest, left: 0 },
        }
    }

    /// Every field that carries a value, over all parts, with its bits.
    #[inline]
    pub fn data(&self) -> impl Iterator<Item = Datum> + use<'a> {
        let item = self.item;
        Fields::of(self.parts()).map(move |(field, raw)| Datum { item, field, raw })
    }

    /// Every field that carries a value, over all parts.
    #[inline]
    pub fn values(&self) -> impl Iterator<Item = (&'static Field, Value)> + use<'a> {
        Fields::of(self.parts()).map(|(field, raw)| (field, value(field, raw)))
    }

    /// The value of a field by its name; of a repetitive item that of its first repetition.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<Value> {
        self.data().find(|datum| datum.field.name == name).map(|datum| datum.value())
    }

    /// The text of the first field that is one.
    #[must_use]
    pub fn text(&self) -> Option<crate::value::Text> {
        let text = self.data().find(|datum| datum.field.work.class == Class::Text)?;
        match text.value() {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The subitems of a compound item (or of an explicit one with a known structure) that are there.
    #[inline]
    pub fn subitems(&self) -> impl Iterator<Item = View<'a>> + use<'a> {
        let (table, mut left, from) = subitems(self.item, self.rest);
        let mut octets = self.rest.get(from..).unwrap_or_default();
        std::iter::from_fn(move || {
            if left == 0 {
                return None;
            }
            let position = left.trailing_zeros() as usize;
            let item = (*table.get(position)?)?;
            left &= left - 1;
            let length = length(item, octets).ok()?;
            let view = View::new(item, octets, length);
            octets = octets.get(length..)?;
            Some(view)
        })
    }

    /// A subitem by its row.
    #[must_use]
    pub fn sub(&self, item: &'static Item) -> Option<View<'a>> {
        self.subitems().find(|view| view.item.is(item))
    }
}

type Table = &'static [Option<&'static Item>];

/// Table, presence bits and first octet of the subitems of a sound item.
#[inline]
fn subitems(item: &'static Item, octets: &[u8]) -> (Table, u64, usize) {
    match item.structure {
        Structure::Compound(table) => {
            let (present, from) = specification(table, octets).unwrap_or((0, 0));
            (table, present, from)
        }
        Structure::Explicit(table) if !table.is_empty() && octets.len() >= 2 => {
            (table, u64::from(octets[1].reverse_bits()), 2)
        }
        _ => (&[], 0, 0),
    }
}

/// Gives every field of a sound item to `take`.
#[inline]
pub(crate) fn each(item: &'static Item, octets: &[u8], take: &mut impl FnMut(Datum)) {
    match &item.structure {
        Structure::Fixed(part) => each_field(item, part, octets, take),
        Structure::Compound(_) | Structure::Explicit(_) => {
            let (table, mut left, mut at) = subitems(item, octets);
            while left != 0 {
                let position = left.trailing_zeros() as usize;
                left &= left - 1;
                let (Some(Some(sub)), Some(rest)) = (table.get(position), octets.get(at..)) else {
                    return;
                };
                at += match sub.structure {
                    Structure::Compound(_) | Structure::Explicit(_) => {
                        each(sub, rest, take);
                        length(sub, rest).unwrap_or(rest.len())
                    }
                    _ => each_part(sub, rest, take),
                };
            }
        }
        _ => _ = each_part(item, octets, take),
    }
}

/// As [`each`] of an item that has parts; returns its octets.
#[inline]
fn each_part(item: &'static Item, octets: &[u8], take: &mut impl FnMut(Datum)) -> usize {
    let mut at = 0;
    let (parts, mut more) = match &item.structure {
        Structure::Fixed(part) => {
            each_field(item, part, octets, take);
            return usize::from(part.octets);
        }
        Structure::Extended(parts) => (*parts, usize::MAX),
        Structure::Chained(part) => (std::slice::from_ref(part), usize::MAX),
        Structure::Counted(part) => {
            at = 1;
            (std::slice::from_ref(part), usize::from(octets.first().copied().unwrap_or(0)))
        }
        Structure::Compound(_) | Structure::Explicit(_) => return 0,
    };
    let counted = more != usize::MAX;
    let mut index = 0;
    while more > 0 {
        let (Some(part), Some(rest)) = (parts.get(index), octets.get(at..)) else { break };
        each_field(item, part, rest, take);
        at += usize::from(part.octets);
        if counted {
            more -= 1;
        } else if octets.get(at - 1).is_none_or(|octet| octet & 1 == 0) {
            break;
        }
        // The last part of a table stands for all further ones.
        index = (index + 1).min(parts.len() - 1);
    }
    at
}

#[inline]
fn each_field(item: &'static Item, part: &'static Part, rest: &[u8], take: &mut impl FnMut(Datum)) {
    if part.octets <= 8 {
        let mut window = window(rest);
        for field in part.fields {
            let raw = window.wrapping_shr(u32::from(field.work.down));
            window = window.wrapping_shl(u32::from(field.bits));
            if field.work.class != Class::Spare {
                take(Datum { item, field, raw });
            }
        }
        return;
    }
    let mut bit = 0;
    for field in part.fields {
        let raw = bits(rest, bit, field);
        bit += usize::from(field.bits);
        if field.work.class != Class::Spare {
            take(Datum { item, field, raw });
        }
    }
}

/// The first eight octets, the first one highest; zeros where there are fewer.
#[inline]
fn window(octets: &[u8]) -> u64 {
    match octets.first_chunk::<8>() {
        Some(octets) => u64::from_be_bytes(*octets),
        None => short_window(octets),
    }
}

#[cold]
fn short_window(octets: &[u8]) -> u64 {
    let mut all = [0; 8];
    let length = octets.len().min(8);
    all[..length].copy_from_slice(&octets[..length]);
    u64::from_be_bytes(all)
}

/// The bits of a field that begins at `bit`. No field lies in more than eight octets.
#[inline]
fn bits(octets: &[u8], bit: usize, field: &Field) -> u64 {
    let window = window(octets.get(bit / 8..).unwrap_or_default());
    window.wrapping_shl((bit % 8) as u32).wrapping_shr(u32::from(field.work.down))
}

/// See [`View::parts`].
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    table: &'static [Part],
    rest: &'a [u8],
    left: usize,
}

impl<'a> Iterator for Parts<'a> {
    type Item = PartView<'a>;

    #[inline]
    fn next(&mut self) -> Option<PartView<'a>> {
        let part = self.table.first()?;
        let octets = usize::from(part.octets);
        if octets > self.left {
            return None;
        }
        let view = PartView { part, rest: self.rest };
        self.left -= octets;
        self.rest = self.rest.get(octets..)?;
        if self.table.len() > 1 {
            self.table = &self.table[1..];
        }
        Some(view)
    }
}

/// A part with its octets.
#[derive(Clone, Copy, Debug)]
pub struct PartView<'a> {
    /// Its layout.
    pub part: &'static Part,
    /// From its first octet to the end of the block.
    rest: &'a [u8],
}

impl<'a> PartView<'a> {
    /// Its fields that carry a value.
    #[inline]
    pub fn values(&self) -> impl Iterator<Item = (&'static Field, Value)> + use<'a> {
        PartFields::of(*self).map(|(field, raw)| (field, value(field, raw)))
    }

    /// Whether every spare bit is zero.
    #[must_use]
    pub fn spares_are_zero(&self) -> bool {
        let mut bit = 0;
        self.part.fields.iter().all(|field| {
            let raw = bits(self.rest, bit, field);
            bit += usize::from(field.bits);
            field.work.class != Class::Spare || raw == 0
        })
    }
}

/// Fields of a part with their bits, spare ones left out.
#[derive(Clone, Debug)]
struct PartFields<'a> {
    fields: std::slice::Iter<'static, Field>,
    rest: &'a [u8],
    bit: usize,
}

impl<'a> PartFields<'a> {
    #[inline]
    fn of(part: PartView<'a>) -> Self {
        Self { fields: part.part.fields.iter(), rest: part.rest, bit: 0 }
    }
}

impl Iterator for PartFields<'_> {
    type Item = (&'static Field, u64);

    #[inline]
    fn next(&mut self) -> Option<(&'static Field, u64)> {
        loop {
            let field = self.fields.next()?;
            let from = self.bit;
            self.bit += usize::from(field.bits);
            if field.work.class != Class::Spare {
                return Some((field, bits(self.rest, from, field)));
            }
        }
    }
}

/// Fields of all parts.
struct Fields<'a> {
    parts: Parts<'a>,
    own: PartFields<'a>,
}

impl<'a> Fields<'a> {
    #[inline]
    fn of(parts: Parts<'a>) -> Self {
        Self { parts, own: PartFields { fields: [].iter(), rest: &[], bit: 0 } }
    }
}

impl Iterator for Fields<'_> {
    type Item = (&'static Field, u64);

    #[inline]
    fn next(&mut self) -> Option<(&'static Field, u64)> {
        loop {
            if let Some(found) = self.own.next() {
                return Some(found);
            }
            self.own = PartFields::of(self.parts.next()?);
        }
    }
}
