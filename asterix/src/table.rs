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
}

/// Whole octets of fields. A part of an extended or chained item ends with an extension bit, which is
/// not among the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Length with the extension bit, octets.
    pub octets: u8,
    /// Fields from the most significant bit on.
    pub fields: &'static [Field],
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
    #[must_use]
    pub const fn values(&self) -> usize {
        let (mut number, mut f) = (0, 0);
        while f < self.fields.len() {
            if !matches!(self.fields[f].kind, Kind::Spare) {
                number += 1;
            }
            f += 1;
        }
        number
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
    Part { octets: bits(fields) / 8, fields }
}

/// Octets of which the last bit is the extension bit.
pub(crate) const fn part(fields: &'static [Field]) -> Part {
    Part { octets: (bits(fields) + 1) / 8, fields }
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
    Field { name, bits, kind, unit }
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

/// Rows of a table: a documented static an item.
macro_rules! items {
    ($($name:ident = $position:literal, $id:literal, $title:literal, $structure:expr;)*) => {$(
        #[doc = concat!($id, ": ", $title, ".")]
        pub static $name: Item =
            Item { position: $position, id: $id, title: $title, structure: $structure };
    )*};
}
pub(crate) use items;
