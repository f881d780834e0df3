//! How long records and items are: what is checked before a record is given out.

use crate::error::Fault;
use crate::table::{Item, Structure};

/// Damage inside a record: `at` octets after its beginning.
pub(crate) struct Damage {
    pub(crate) at: usize,
    pub(crate) item: Option<&'static str>,
    pub(crate) subitem: Option<&'static str>,
    pub(crate) fault: Fault,
}

impl From<Fault> for Damage {
    fn from(fault: Fault) -> Self {
        Self { at: 0, item: None, subitem: None, fault }
    }
}

/// Field specification or primary subfield: bit n for position n, and its octets.
#[inline]
pub(crate) fn specification(table: &[Option<&Item>], octets: &[u8]) -> Result<(u64, usize), Fault> {
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
pub(crate) fn length(item: &'static Item, octets: &[u8]) -> Result<usize, Damage> {
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
        at = item_end(item, octets, at)?;
    }
    Ok(at)
}

/// Where the item that begins at `at` ends.
#[inline]
pub(crate) fn item_end(item: &'static Item, octets: &[u8], at: usize) -> Result<usize, Damage> {
    let end = at + usize::from(item.octets);
    if item.octets != 0 && end <= octets.len() {
        return Ok(end);
    }
    match length(item, &octets[at..]) {
        Ok(length) => Ok(at + length),
        Err(damage) => Err(Damage {
            at: at + damage.at,
            item: Some(item.id),
            subitem: damage.item,
            fault: damage.fault,
        }),
    }
}
