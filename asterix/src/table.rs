//! What a table of a category is made of: items, their parts, and fields of bits.
//!
//! The tables themselves stand in [`crate::categories`]; decoder, encoder, dump and checks read nothing else.

/// What the bits of a field mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Nothing: written as zeros.
    Spare,
    /// Whole number or code from 0.
    Unsigned,
    /// `raw · lsb`, from 0.
    Quantity {
        /// Value of the least significant bit.
        lsb: f64,
    },
    /// `raw · lsb`, two's complement.
    SignedQuantity {
        /// Value of the least significant bit.
        lsb: f64,
    },
    /// `raw · lsb` over a full turn: 360 is 0.
    Angle {
        /// Value of the least significant bit, degrees.
        lsb: f64,
    },
    /// Seconds since midnight UTC, LSB 1/128 s; the last half step of the day is midnight.
    TimeOfDay,
    /// Characters of eight bits, padded with spaces.
    Ascii,
    /// Characters of six bits (IA-5 without its top bits), padded with spaces.
    Ident,
    /// Four octal digits of three bits.
    Octal,
}

/// A run of bits with one meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Short name; empty where the item has this field only, and for spare bits.
    pub name: &'static str,
    /// Length, 1 to 56.
    pub bits: u8,
    /// Meaning.
    pub kind: Kind,
    /// Unit of the value, empty for codes and texts.
    pub unit: &'static str,
    /// What decoder and encoder need of the above in their inner loops, worked out by the compiler.
    pub(crate) work: Work,
}

/// A field as plain numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Work {
    pub(crate) class: Class,
    /// 64 minus the length: brings the top bits of a word down to the bottom.
    pub(crate) down: u8,
    /// As `down` where the number is signed, else 0.
    pub(crate) sign: u8,
    /// Value of one step; 1 for codes.
    pub(crate) step: f64,
    /// Least and greatest number of steps that the bits hold; of a code its least and greatest value; the period of what wraps is `most + 1`.
    pub(crate) least: i64,
    pub(crate) most: i64,
    /// ½ − `least`, and `most` − `least`.
    pub(crate) offset: f64,
    pub(crate) range: f64,
}

/// How a field is turned into bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Code,
    Clipped,
    Wrapped,
    Text,
    Spare,
}

impl Work {
    const fn of(bits: u8, kind: Kind) -> Self {
        let down = 64 - bits;
        let (unsigned, half) = ((u64::MAX >> down) as i64, 1_i64 << (bits - 1));
        let (class, sign, step, least, most) = match kind {
            Kind::Spare => (Class::Spare, 0, 1.0, 0, unsigned),
            Kind::Unsigned | Kind::Octal => (Class::Code, 0, 1.0, 0, unsigned),
            Kind::Quantity { lsb } => (Class::Clipped, 0, lsb, 0, unsigned),
            Kind::SignedQuantity { lsb } => (Class::Clipped, down, lsb, -half, half - 1),
            Kind::Angle { lsb } => (Class::Wrapped, 0, lsb, 0, unsigned),
            Kind::TimeOfDay => (Class::Wrapped, 0, 1.0 / 128.0, 0, 86_400 * 128 - 1),
            Kind::Ascii | Kind::Ident => (Class::Text, 0, 1.0, 0, unsigned),
        };
        let (offset, range) = (0.5 - least as f64, (most - least) as f64);
        Self { class, down, sign, step, least, most, offset, range }
    }
}

/// Whole octets of fields. A part of an extended or chained item ends with an extension bit, which is
/// not among the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Length with the extension bit, octets.
    pub octets: u8,
    /// Fields from the most significant bit on.
    pub fields: &'static [Field],
    /// How many of them carry a value.
    count: u8,
    /// Whether those are codes.
    codes: bool,
}

/// How the octets of an item are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Structure {
    /// One part of fixed length.
    Fixed(Part),
    /// One part or more; the last bit of each says whether another follows.
    Extended(&'static [Part]),
    /// One octet with the number of parts, then the parts.
    Counted(Part),
    /// Equal parts; the last bit of each says whether another follows.
    Chained(Part),
    /// A primary subfield like an FSPEC, then the subitems that it names.
    Compound(&'static [Option<&'static Item>]),
    /// One octet of length (itself included), then one octet that names subitems (no extension bit) and
    /// the subitems; with an empty list opaque octets.
    Explicit(&'static [Option<&'static Item>]),
}

/// A row of a category's table: an item, or a subitem of a compound one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Place in the user application profile (or in the primary subfield), from 0.
    pub position: u8,
    /// Three digits of the item, or the short name of a subitem, `RE` or `SP`.
    pub id: &'static str,
    /// What it is.
    pub title: &'static str,
    /// Layout.
    pub structure: Structure,
    /// Octets where they are always as many, else 0.
    pub(crate) octets: u8,
    /// Its bit in a field specification of eight octets, extension bits not set.
    pub(crate) bit: u64,
    /// Unlike in any two rows of all tables.
    pub(crate) key: u64,
    codes: Codes,
}

/// An item of codes as one run of bits: of up to eight octets, in one part or in parts of one octet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Codes {
    /// How many; 0 for an item that is not such a run.
    count: u8,
    /// Of each: how far its last bit is from the end of eight octets, and its length.
    places: [(u8, u8); MOST_CODES],
}

/// Most codes of an item (I062/080 has 35).
const MOST_CODES: usize = 40;

impl Codes {
    const fn of(structure: &Structure) -> Self {
        let none = Self { count: 0, places: [(0, 0); MOST_CODES] };
        let (parts, extended) = match structure {
            Structure::Fixed(part) => (std::slice::from_ref(part), false),
            Structure::Extended(parts) => (*parts, true),
            _ => return none,
        };
        let mut codes = none;
        let (mut down, mut p) = (64, 0);
        while p < parts.len() {
            let octets = parts[p].octets;
            if !parts[p].codes || octets > 8 || (extended && octets > 1) || down < 8 * octets {
                return none;
            }
            let mut f = 0;
            while f < parts[p].fields.len() {
                let field = &parts[p].fields[f];
                down -= field.bits;
                if !matches!(field.work.class, Class::Spare) {
                    if codes.count as usize == MOST_CODES {
                        return none;
                    }
                    codes.places[codes.count as usize] = (down, field.bits);
                    codes.count += 1;
                }
                f += 1;
            }
            down -= extended as u8;
            p += 1;
        }
        codes
    }
}

/// A category: its items in the order of the user application profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Category {
    /// Category number.
    pub number: u8,
    /// Edition of the table (main, sub).
    pub edition: (u8, u8),
    /// What it is.
    pub title: &'static str,
    /// Items by position; `None` is a spare position.
    pub uap: &'static [Option<&'static Item>],
}

/// Most positions of a user application profile (category 021 has 49).
pub const MOST_POSITIONS: usize = 56;

impl Item {
    pub(crate) const fn new(
        key: u64,
        position: u8,
        id: &'static str,
        title: &'static str,
        structure: Structure,
    ) -> Self {
        let octets = if let Structure::Fixed(part) = &structure { part.octets } else { 0 };
        let bit = 1 << (63 - (position as u32 / 7 * 8 + position as u32 % 7));
        let codes = Codes::of(&structure);
        Self { position, id, title, structure, octets, bit, key, codes }
    }

    /// Whether both are the same row of the same table. Rows are constants: their addresses say nothing.
    #[inline(always)]
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.key == other.key
    }

    /// Places of its fields if all of them are codes in one run of bits; else none.
    #[inline]
    pub(crate) fn code_places(&self) -> &[(u8, u8)] {
        self.codes.places.get(..usize::from(self.codes.count)).unwrap_or_default()
    }

    /// Number of the field of this name among the fields that carry a value, in order over all parts.
    ///
    /// In a constant this is worked out, and a wrong name refused, by the compiler:
    ///
    /// ```
    /// use asterix::cat062;
    /// const SFC: usize = cat062::I080.field("SFC");
    /// assert_eq!(SFC, 31);
    /// ```
    ///
    /// # Panics
    /// If the item has no field of this name.
    #[must_use]
    pub const fn field(&self, name: &str) -> usize {
        let parts = self.structure.parts();
        let (mut number, mut p) = (0, 0);
        while p < parts.len() {
            let mut f = 0;
            while f < parts[p].fields.len() {
                let field = &parts[p].fields[f];
                if !matches!(field.kind, Kind::Spare) {
                    if equal(field.name.as_bytes(), name.as_bytes()) {
                        return number;
                    }
                    number += 1;
                }
                f += 1;
            }
            p += 1;
        }
        panic!("the item has no field of this name")
    }

    /// How many fields carry a value, over all parts.
    #[must_use]
    pub const fn fields(&self) -> usize {
        let parts = self.structure.parts();
        let (mut number, mut p) = (0, 0);
        while p < parts.len() {
            number += parts[p].values();
            p += 1;
        }
        number
    }
}

impl Structure {
    /// The parts that have fields: all of an extended item, the repeated one of a repetitive item.
    #[must_use]
    pub const fn parts(&self) -> &[Part] {
        match self {
            Self::Fixed(part) | Self::Counted(part) | Self::Chained(part) => {
                std::slice::from_ref(part)
            }
            Self::Extended(parts) => parts,
            Self::Compound(_) | Self::Explicit(_) => &[],
        }
    }
}

impl Part {
    /// How many of its fields carry a value.
    #[inline]
    #[must_use]
    pub const fn values(&self) -> usize {
        self.count as usize
    }

    const fn new(octets: u8, fields: &'static [Field]) -> Self {
        let (mut count, mut codes, mut f) = (0, true, 0);
        while f < fields.len() {
            let class = fields[f].work.class;
            if !matches!(class, Class::Spare) {
                count += 1;
                codes &= matches!(class, Class::Code);
            }
            f += 1;
        }
        Self { octets, fields, count, codes }
    }
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

pub(crate) use Structure::{Chained, Compound, Counted, Explicit, Extended};

/// Whole octets.
pub(crate) const fn part_of(fields: &'static [Field]) -> Part {
    Part::new(bits(fields) / 8, fields)
}

/// Octets of which the last bit is the extension bit.
pub(crate) const fn part(fields: &'static [Field]) -> Part {
    Part::new((bits(fields) + 1) / 8, fields)
}

pub(crate) const fn fixed(fields: &'static [Field]) -> Structure {
    Structure::Fixed(part_of(fields))
}

const fn bits(fields: &[Field]) -> u8 {
    let (mut sum, mut f) = (0, 0);
    while f < fields.len() {
        sum += fields[f].bits;
        f += 1;
    }
    sum
}

const fn field(name: &'static str, bits: u8, kind: Kind, unit: &'static str) -> Field {
    Field { name, bits, kind, unit, work: Work::of(bits, kind) }
}

pub(crate) const fn spare(bits: u8) -> Field {
    field("", bits, Kind::Spare, "")
}

/// Unsigned number or code.
pub(crate) const fn u(name: &'static str, bits: u8) -> Field {
    field(name, bits, Kind::Unsigned, "")
}

/// Quantity from 0; one whose range is a full turn of degrees is an angle.
pub(crate) const fn q(name: &'static str, bits: u8, lsb: f64, unit: &'static str) -> Field {
    let turn = lsb * (1u64 << bits) as f64 == 360.0;
    field(name, bits, if turn { Kind::Angle { lsb } } else { Kind::Quantity { lsb } }, unit)
}

/// Signed quantity.
pub(crate) const fn sq(name: &'static str, bits: u8, lsb: f64, unit: &'static str) -> Field {
    field(name, bits, Kind::SignedQuantity { lsb }, unit)
}

/// Time of day.
pub(crate) const fn tod(name: &'static str) -> Field {
    field(name, 24, Kind::TimeOfDay, "s")
}

pub(crate) const fn ascii(name: &'static str, bits: u8) -> Field {
    field(name, bits, Kind::Ascii, "")
}

pub(crate) const fn ident(name: &'static str, bits: u8) -> Field {
    field(name, bits, Kind::Ident, "")
}

pub(crate) const fn octal(name: &'static str, bits: u8) -> Field {
    field(name, bits, Kind::Octal, "")
}

/// 180° / 2ⁿ.
pub(crate) const fn deg(n: u32) -> f64 {
    180.0 / (1u64 << n) as f64
}

/// Hash of the name of a row (FNV-1a), for its key.
pub(crate) const fn key(module: &str, name: &str) -> u64 {
    let (mut hash, mut text, mut i) = (0xcbf2_9ce4_8422_2325_u64, module.as_bytes(), 0);
    while i < text.len() {
        hash = (hash ^ text[i] as u64).wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    (text, i) = (name.as_bytes(), 0);
    while i < text.len() {
        hash = (hash ^ text[i] as u64).wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    hash
}

/// Rows of a table: a documented constant an item. What encodes an item knows its layout when it is compiled, in any crate.
macro_rules! items {
    ($($name:ident = $position:literal, $id:literal, $title:literal, $structure:expr;)*) => {$(
        #[doc = concat!($id, ": ", $title, ".")]
        pub const $name: Item =
            Item::new(key(module_path!(), concat!("::", stringify!($name))), $position, $id, $title, $structure);
    )*};
}
pub(crate) use items;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn rows(table: &[Option<&'static Item>], of: &str, keys: &mut BTreeMap<u64, String>) {
        for item in table.iter().flatten() {
            let name = format!("{of}/{}", item.id);
            if let Structure::Compound(inner) | Structure::Explicit(inner) = item.structure {
                rows(inner, &name, keys);
            }
            let before = keys.insert(item.key, name.clone());
            assert_eq!(before, None, "{name}: one key for two rows");
        }
    }

    #[test]
    fn no_two_rows_have_one_key() {
        let mut keys = BTreeMap::new();
        for category in (0..=255).filter_map(crate::category) {
            rows(category.uap, &category.number.to_string(), &mut keys);
        }
        assert!(keys.len() > 300, "{} rows", keys.len());
    }
}
