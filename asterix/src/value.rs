//! One field: its bits as a number or a text, and back.

use crate::table::{Class, Field, Kind, Work};
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
            let at = usize::from(text.length);
            if character < 0x80 {
                text.utf8[at] = character;
                text.length += 1;
            } else {
                let character = char::from(character);
                character.encode_utf8(&mut text.utf8[at..]);
                text.length += character.len_utf8() as u8;
            }
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

    /// The characters without what fills the field up: blanks and zeros, which of six bits read as "@".
    #[must_use]
    pub fn trimmed(&self) -> &str {
        self.as_str().trim_matches([' ', '@', '\0'])
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

    /// The same without the reason: what the encoder asks first, in registers.
    #[inline]
    fn bits(self, field: &Field) -> Option<u64> {
        self.raw(field).ok()
    }

    /// What a whole number is as a code; none where the type has fractions or texts. A negative one is a huge code.
    #[inline]
    fn code(self) -> Option<u64> {
        None
    }
}

impl FieldValue for f64 {
    #[inline]
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        self.bits(field).ok_or_else(|| why_not(self, field))
    }

    #[inline(always)]
    fn bits(self, field: &Field) -> Option<u64> {
        let work = &field.work;
        if work.class == Class::Clipped && self.is_finite() {
            return Some(clipped(self / work.step, work));
        }
        bits_of_a_rare_class(self, field)
    }
}

fn bits_of_a_rare_class(value: f64, field: &Field) -> Option<u64> {
    let work = &field.work;
    if !value.is_finite() {
        return None;
    }
    match work.class {
        Class::Wrapped => Some(wrapped(value / work.step + 0.5, work.most) & mask(work)),
        Class::Code => {
            // Saturates far beyond what any field holds.
            let whole = value as i64;
            if whole as f64 == value { whole.bits(field) } else { None }
        }
        Class::Spare => Some(0),
        Class::Clipped | Class::Text => None,
    }
}

#[cold]
fn why_not(value: f64, field: &Field) -> ValueError {
    if !value.is_finite() {
        ValueError::NotFinite
    } else if field.work.class == Class::Text {
        ValueError::Kind("a text")
    } else if value.floor() != value {
        ValueError::NotWhole
    } else {
        ValueError::TooLarge(field.bits)
    }
}

impl FieldValue for i64 {
    #[inline]
    fn raw(self, field: &Field) -> Result<u64, ValueError> {
        self.bits(field).ok_or_else(|| why_not(self as f64, field))
    }

    #[inline]
    fn bits(self, field: &Field) -> Option<u64> {
        let work = &field.work;
        // A negative one is a huge one here.
        if work.class == Class::Code {
            return (self as u64 <= work.most as u64).then_some(self as u64);
        }
        (self as f64).bits(field)
    }
}

macro_rules! whole_numbers {
    ($($t:ty),*) => {$(
        impl FieldValue for $t {
            #[inline]
            fn raw(self, field: &Field) -> Result<u64, ValueError> {
                i64::from(self).raw(field)
            }

            #[inline]
            fn bits(self, field: &Field) -> Option<u64> {
                i64::from(self).bits(field)
            }

            #[inline]
            fn code(self) -> Option<u64> {
                Some(i64::from(self) as u64)
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
        if most <= 8 && self.len() <= usize::from(most) && self.is_ascii() {
            return short_text(self.as_bytes(), field.bits, bits);
        }
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

/// Up to eight ASCII characters, all at once: padded with spaces, of six bits those of them that a table of 64 has.
#[inline]
fn short_text(text: &[u8], field_bits: u8, bits: u8) -> Result<u64, ValueError> {
    const SIX: u64 = 0x3f3f_3f3f_3f3f_3f3f;
    const ONES: u64 = 0x0101_0101_0101_0101;
    let mut octets = [b' '; 8];
    octets.iter_mut().zip(text).for_each(|(octet, character)| *octet = *character);
    let word = u64::from_be_bytes(octets);
    if bits == 8 {
        return Ok(word >> (64 - field_bits));
    }
    // Space to underline: bit 5 or bit 6, not both.
    if (word >> 6 ^ word >> 5) & ONES != ONES {
        return Err(ValueError::Character);
    }
    let pairs = word & SIX;
    let pairs = pairs & 0x003f_003f_003f_003f | (pairs & 0x3f00_3f00_3f00_3f00) >> 2;
    let fours = pairs & 0x0000_0fff_0000_0fff | (pairs & 0x0fff_0000_0fff_0000) >> 4;
    let all = fours & 0xff_ffff | (fours & 0x00ff_ffff_0000_0000) >> 8;
    Ok(all >> (48 - field_bits))
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

/// `floor(steps + ½)`, not below the least nor above the most, in the field's bits. Limits have at most 56 bits: their
/// distances are exact.
#[inline(always)]
fn clipped(steps: f64, work: &Work) -> u64 {
    // Counted from the least on nothing is negative, and to cut is to round down.
    let up = steps + work.offset;
    let up = if up > 0.0 { up } else { 0.0 };
    let up = if up < work.range { up } else { work.range };
    (up as i64).wrapping_add(work.least) as u64 & mask(work)
}

/// The whole part of `steps` within `0..=most`, a turn or a day on.
#[inline]
fn wrapped(steps: f64, most: i64) -> u64 {
    let period = (most + 1) as f64;
    if (0.0..period).contains(&steps) {
        return steps as i64 as u64;
    }
    steps.floor().rem_euclid(period) as u64
}

#[inline]
const fn mask(work: &Work) -> u64 {
    u64::MAX.wrapping_shr(work.down as u32)
}

/// The number that a field's bits are; none of a text.
#[inline]
pub(crate) fn number(field: &Field, raw: u64) -> Option<f64> {
    let work = &field.work;
    if work.class == Class::Text {
        return None;
    }
    // At most 56 bits: what has no sign is not changed by it.
    let sign = u32::from(work.sign);
    let steps = (raw.wrapping_shl(sign) as i64).wrapping_shr(sign);
    Some(steps as f64 * work.step)
}

/// The value of a field's bits.
#[inline]
pub(crate) fn value(field: &Field, raw: u64) -> Value {
    match field.kind {
        Kind::Spare | Kind::Unsigned => Value::Integer(raw as i64),
        Kind::Octal => Value::Octal(raw as u16),
        Kind::Ascii | Kind::Ident => Value::Text(text(field, raw)),
        _ => Value::Number(number(field, raw).unwrap_or_default()),
    }
}

fn text(field: &Field, raw: u64) -> Text {
    let bits = u32::from(field.bits);
    if field.kind == Kind::Ascii {
        let characters = (0..bits / 8).rev().map(|i| (raw >> (8 * i)) as u8);
        return Text::new(characters);
    }
    let code = |i| (raw >> (6 * i)) as u8 & 0x3f;
    let character = |code: u8| if code < 0x20 { code | 0x40 } else { code };
    Text::new((0..bits / 6).rev().map(|i| character(code(i))))
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
