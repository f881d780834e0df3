//! One field: its bits as a number or a text, and back.

use crate::table::{Field, Kind};
use std::fmt;

/// What the bits of a field say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A code or a whole number.
    Integer(i64),
    /// A quantity in the unit of its field.
    Number(f64),
    /// Characters without the spaces that pad them.
    Text(Text),
    /// A code of octal digits.
    Octal(u16),
}

impl Value {
    /// The value as a number; a text has none.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match *self {
            Self::Integer(i) => Some(i as f64),
            Self::Number(n) => Some(n),
            Self::Octal(o) => Some(f64::from(o)),
            Self::Text(_) => None,
        }
    }
}

/// Up to eight characters of at most eight bits each.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Text {
    utf8: [u8; 16],
    length: u8,
}

impl Text {
    fn new(characters: impl Iterator<Item = u8>) -> Self {
        let mut text = Self { utf8: [0; 16], length: 0 };
        for character in characters {
            let character = char::from(character);
            let at = usize::from(text.length);
            character.encode_utf8(&mut text.utf8[at..]);
            text.length += character.len_utf8() as u8;
        }
        while text.length > 0 && text.utf8[usize::from(text.length) - 1] == b' ' {
            text.length -= 1;
        }
        text
    }

    /// A text of at most eight characters, each of at most eight bits; `None` if it is not one.
    #[must_use]
    pub fn of(text: &str) -> Option<Self> {
        let octets: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
        octets.filter(|o| o.len() <= 8).map(|o| Self::new(o.into_iter()))
    }

    /// The characters.
    #[must_use]
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.utf8[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(i) => write!(f, "{i}"),
            Self::Number(n) => write!(f, "{n}"),
            Self::Text(t) => f.write_str(t.as_str()),
            Self::Octal(o) => write!(f, "{o:04o}"),
        }
    }
}

/// Why a value cannot be written into its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// NaN or infinity.
    #[error("not a finite number")]
    NotFinite,
    /// A code with a fraction.
    #[error("a code is a whole number")]
    NotWhole,
    /// A code that its bits cannot hold.
    #[error("does not fit into {0} bits")]
    TooLarge(u8),
    /// A text that is longer than its field.
    #[error("longer than {0} characters")]
    TooLong(u8),
    /// A character that the field cannot carry.
    #[error(
        "has a character that the field cannot carry (six-bit characters: capitals, digits, space)"
    )]
    Character,
    /// A text for a number, or a number for a text.
    #[error("{0} is asked for")]
    Kind(&'static str),
}

/// Seconds of a day.
pub const DAY_S: f64 = 86_400.0;

/// Something that can be written into a field.
pub trait FieldValue: Copy {
    /// The field's bits for this value.
    ///
    /// # Errors
    /// If the field cannot carry it. A quantity beyond its limits is no error: it is clipped.
    fn raw(self, field: &Field) -> Result<u64, ValueError>;
}

impl FieldValue for f64 {
    #[inline]
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        if !self.is_finite() {
            return Err(ValueError::NotFinite);
        }
        let bits = u32::from(field.bits);
        Ok(match field.kind {
            Kind::Quantity { lsb } => clipped(self / lsb, 0, mask(bits) as i64) as u64,
            Kind::SignedQuantity { lsb } => {
                let limit = 1_i64 << (bits - 1);
                clipped(self / lsb, -limit, limit - 1) as u64 & mask(bits)
            }
            Kind::Angle { lsb } => wrapped(self / lsb + 0.5, (1_i64 << bits) as f64) & mask(bits),
            Kind::TimeOfDay => wrapped(self * 128.0 + 0.5, DAY_S * 128.0),
            Kind::Unsigned | Kind::Octal => {
                if self.floor() != self {
                    return Err(ValueError::NotWhole);
                }
                // Saturates far beyond what any field holds.
                return (self as i64).raw(field);
            }
            Kind::Ascii | Kind::Ident => return Err(ValueError::Kind("a text")),
            Kind::Spare => 0,
        })
    }
}

impl FieldValue for i64 {
    #[inline]
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        let bits = u32::from(field.bits);
        let fits = match field.kind {
            Kind::Unsigned | Kind::Octal => self >= 0 && self as u64 <= mask(bits),
            _ => return (self as f64).raw(field),
        };
        if fits { Ok(self as u64 & mask(bits)) } else { Err(ValueError::TooLarge(field.bits)) }
    }
}

macro_rules! whole_numbers {
    ($($t:ty),*) => {$(
        impl FieldValue for $t {
            #[inline]
            fn raw(self, field: &Field) -> Result<u64, ValueError> {
                i64::from(self).raw(field)
            }
        }
    )*};
}
whole_numbers!(bool, u8, u16, u32, i8, i16, i32);

impl FieldValue for &str {
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        let (bits, pad) = match field.kind {
            Kind::Ascii => (8, 0x20),
            Kind::Ident => (6, 0x20),
            Kind::Octal => {
                let digits = !self.is_empty() && self.bytes().all(|b| (b'0'..=b'7').contains(&b));
                let code = u16::from_str_radix(self, 8).ok().filter(|_| digits);
                return code.ok_or(ValueError::Kind("a code of octal digits"))?.raw(field);
            }
            _ => return Err(ValueError::Kind("a number")),
        };
        let most = field.bits / bits;
        let (mut raw, mut count) = (0u64, 0);
        for character in self.chars() {
            let code = match field.kind {
                Kind::Ascii => u8::try_from(character).map_err(|_| ValueError::Character)?,
                _ if (' '..='_').contains(&character) => character as u8 & 0x3f,
                _ => return Err(ValueError::Character),
            };
            if count == most {
                return Err(ValueError::TooLong(most));
            }
            raw = raw << bits | u64::from(code);
            count += 1;
        }
        for _ in count..most {
            raw = raw << bits | pad;
        }
        Ok(raw)
    }
}

impl FieldValue for Value {
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        match self {
            Self::Integer(i) => i.raw(field),
            Self::Number(n) => n.raw(field),
            Self::Text(t) => t.as_str().raw(field),
            Self::Octal(o) => o.raw(field),
        }
    }
}

/// `floor(steps + ½)`, not below `least` nor above `most`. Limits have at most 56 bits.
#[inline]
fn clipped(steps: f64, least: i64, most: i64) -> i64 {
    let up = steps + 0.5;
    // Cuts towards zero, and saturates far beyond the limits.
    let whole = up as i64;
    let floor = whole - i64::from((whole as f64) > up);
    floor.clamp(least, most)
}

/// The whole part of `steps` within `0..period`, a turn or a day on.
#[inline]
fn wrapped(steps: f64, period: f64) -> u64 {
    if (0.0..period).contains(&steps) {
        return steps as u64;
    }
    steps.floor().rem_euclid(period) as u64
}

#[inline]
pub(crate) const fn mask(bits: u32) -> u64 {
    u64::MAX >> (64 - bits)
}

/// The value of a field's bits.
#[inline]
pub(crate) fn value(field: &Field, raw: u64) -> Value {
    let bits = u32::from(field.bits);
    let signed = || ((raw << (64 - bits)) as i64) >> (64 - bits);
    match field.kind {
        Kind::Spare | Kind::Unsigned => Value::Integer(raw as i64),
        // At most 56 bits: a signed number is the faster one to convert.
        Kind::Quantity { lsb } | Kind::Angle { lsb } => Value::Number(raw as i64 as f64 * lsb),
        Kind::SignedQuantity { lsb } => Value::Number(signed() as f64 * lsb),
        Kind::TimeOfDay => Value::Number(raw as i64 as f64 / 128.0),
        Kind::Octal => Value::Octal(raw as u16),
        Kind::Ascii => {
            let characters = (0..bits / 8).rev().map(|i| (raw >> (8 * i)) as u8);
            Value::Text(Text::new(characters))
        }
        Kind::Ident => {
            let code = |i| (raw >> (6 * i)) as u8 & 0x3f;
            let character = |code: u8| if code < 0x20 { code | 0x40 } else { code };
            Value::Text(Text::new((0..bits / 6).rev().map(|i| character(code(i)))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{ascii, deg, ident, octal, q, sq, tod, u};

    #[test]
    fn a_quantity_is_rounded_to_the_nearest_step_and_clipped() {
        let deviation = q("", 8, 0.25, "m");
        for (asked, raw) in
            [(0.0, 0), (0.124, 0), (0.125, 1), (63.75, 255), (99.0, 255), (-3.0, 0), (1e300, 255)]
        {
            assert_eq!(asked.raw(&deviation), Ok(raw), "{asked}");
        }
        let velocity = sq("", 16, 0.25, "m/s");
        for (asked, raw) in [
            (-4.13, 0xffef),
            (-0.125, 0), // floor(−0.5 + 0.5)
            (8191.75, 0x7fff),
            (8192.0, 0x7fff),
            (-8192.0, 0x8000),
            (-9e9, 0x8000),
        ] {
            assert_eq!(asked.raw(&velocity), Ok(raw), "{asked}");
        }
        let longitude = sq("", 32, deg(25), "°");
        assert_eq!(180.0.raw(&sq("", 26, deg(25), "°")), Ok(0x1ff_ffff), "+180° is clipped");
        assert_eq!((-180.0).raw(&longitude), Ok(0xfe00_0000));
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(bad.raw(&velocity), Err(ValueError::NotFinite));
        }
    }

    #[test]
    fn a_turn_and_a_day_wrap() {
        let azimuth = q("", 16, deg(15), "°");
        for (asked, raw) in [(359.999, 0), (360.0, 0), (-90.0, 0xc000), (1e3, 50_972)] {
            assert_eq!(asked.raw(&azimuth), Ok(raw), "{asked}");
        }
        for (asked, raw) in [
            (86_399.99, 11_059_199),
            (86_399.996_1, 0),
            (86_400.0, 0),
            (-1.0, 11_059_072),
            (172_800.5, 64),
        ] {
            assert_eq!(asked.raw(&tod("")), Ok(raw), "{asked}");
        }
    }

    #[test]
    fn a_code_that_does_not_fit_is_refused() {
        assert_eq!(4096_i64.raw(&u("", 12)), Err(ValueError::TooLarge(12)));
        assert_eq!((-1_i64).raw(&u("", 12)), Err(ValueError::TooLarge(12)));
        assert_eq!(1.5.raw(&u("", 12)), Err(ValueError::NotWhole));
        assert_eq!("x".raw(&u("", 12)), Err(ValueError::Kind("a number")));
        assert_eq!("1234".raw(&octal("", 12)), Ok(0x29c));
        assert_eq!("1239".raw(&octal("", 12)), Err(ValueError::Kind("a code of octal digits")));
        assert_eq!("+123".raw(&octal("", 12)), Err(ValueError::Kind("a code of octal digits")));
        assert_eq!("12345".raw(&octal("", 12)), Err(ValueError::TooLarge(12)));
    }

    #[test]
    fn texts_are_padded_and_never_cut() {
        let (call_sign, stand) = (ident("", 48), ascii("", 48));
        assert_eq!("AZA1234".raw(&call_sign), Ok(0x05a0_71cb_3d20));
        assert_eq!("B12".raw(&stand), Ok(0x4231_3220_2020));
        assert_eq!("ABCDEFGHI".raw(&call_sign), Err(ValueError::TooLong(8)));
        assert_eq!("aza".raw(&call_sign), Err(ValueError::Character));
        assert_eq!("Ω".raw(&stand), Err(ValueError::Character));
        let Value::Text(text) = value(&call_sign, 0x05a0_71cb_3d20) else { panic!("a text") };
        assert_eq!(text.as_str(), "AZA1234");
        // Every pattern of bits has a text of its own: nothing is lost on the way.
        for raw in [0, 1 << 42, 0xffff_ffff_ffff, 0x8208_2082_0820] {
            assert_eq!(value(&call_sign, raw).raw(&call_sign), Ok(raw), "{raw:x}");
            assert_eq!(value(&stand, raw).raw(&stand), Ok(raw), "{raw:x}");
        }
    }
}
