//! Which items a record must have, and which it must not.

use crate::cat010 as c010;
use crate::decode::Record;
use crate::table::Item;
use crate::{cat004, cat011, cat019, cat020, cat021, cat034, cat048, cat062, cat065, cat247};
use std::fmt;

/// A rule that a record breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Breach {
    /// Category.
    pub category: u8,
    /// Item.
    pub item: &'static str,
    /// How.
    pub how: How,
}

/// How a record breaks a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// A mandatory item is not there.
    Missing,
    /// An item that has no place in a message of this type.
    OutOfPlace {
        /// Message type; 0 where the category has none.
        message: u8,
    },
    /// A bit that is to be zero is set.
    SpareSet,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { category, item, how } = self;
        match how {
            How::Missing => write!(f, "I{category:03}/{item} is missing"),
            How::OutOfPlace { message: 0 } => write!(f, "I{category:03}/{item} shall not be sent"),
            How::OutOfPlace { message } => {
                write!(f, "I{category:03}/{item} has no place in message type {message}")
            }
            How::SpareSet => write!(f, "I{category:03}/{item} has a spare bit set"),
        }
    }
}

/// The rules of a category.
struct Rules {
    /// In every record.
    always: &'static [&'static Item],
    /// In no record.
    never: &'static [&'static Item],
    /// The item with the message type, if the category has types.
    message: Option<&'static Item>,
    /// Mandatory in messages of these types.
    needed: &'static [(&'static [u8], &'static Item)],
    /// Allowed in messages of these types only.
    only: &'static [(&'static [u8], &'static Item)],
    /// What is neither in `always` nor in `only` is allowed in messages of these types (empty: all).
    rest: &'static [u8],
}

static NONE: Rules = PLAIN;
const PLAIN: Rules =
    Rules { always: &[], never: &[], message: None, needed: &[], only: &[], rest: &[] };

/// Sources: the presence rules of the category specifications.
static RULES: &[(u8, Rules)] = &[
    (
        4,
        Rules {
            always: &[&cat004::I010, &cat004::I000, &cat004::I020],
            message: Some(&cat004::I000),
            ..PLAIN
        },
    ),
    (
        10,
        Rules {
            always: &[&c010::I010, &c010::I000, &c010::I140],
            message: Some(&c010::I000),
            needed: &[(&[1], &c010::I020), (&[3, 4], &c010::I550)],
            only: &[(&[1], &c010::I020), (&[2, 3, 4], &c010::I550)],
            rest: &[1],
            ..PLAIN
        },
    ),
    (
        11,
        Rules {
            always: &[&cat011::I010, &cat011::I000, &cat011::I140],
            message: Some(&cat011::I000),
            needed: &[(&[1], &cat011::I170), (&[7], &cat011::I610)],
            ..PLAIN
        },
    ),
    (
        19,
        Rules {
            always: &[&cat019::I010, &cat019::I000, &cat019::I140],
            message: Some(&cat019::I000),
            needed: &[(&[2, 3], &cat019::I550)],
            ..PLAIN
        },
    ),
    (20, Rules { always: &[&cat020::I010, &cat020::I020, &cat020::I140], ..PLAIN }),
    (21, Rules { always: &[&cat021::I010, &cat021::I040, &cat021::I080], ..PLAIN }),
    (
        34,
        Rules {
            always: &[&cat034::I010, &cat034::I000, &cat034::I030],
            message: Some(&cat034::I000),
            needed: &[(&[2], &cat034::I020)],
            ..PLAIN
        },
    ),
    (48, Rules { always: &[&cat048::I010, &cat048::I140, &cat048::I020], ..PLAIN }),
    (
        62,
        Rules {
            always: &[&cat062::I010, &cat062::I070, &cat062::I040, &cat062::I080],
            never: &[&cat062::I245],
            ..PLAIN
        },
    ),
    (
        65,
        Rules {
            always: &[&cat065::I010, &cat065::I000, &cat065::I015, &cat065::I030],
            message: Some(&cat065::I000),
            needed: &[(&[1], &cat065::I040), (&[2], &cat065::I020), (&[3], &cat065::I050)],
            only: &[(&[1], &cat065::I040), (&[2], &cat065::I020), (&[3], &cat065::I050)],
            ..PLAIN
        },
    ),
    (247, Rules { always: &[&cat247::I010, &cat247::I140, &cat247::I550], ..PLAIN }),
];

/// Every rule that this record breaks.
#[must_use]
pub fn breaches(record: &Record<'_>) -> Vec<Breach> {
    let category = record.category.number;
    let rules = RULES.iter().find(|(number, _)| *number == category).map_or(&NONE, |(_, r)| r);
    let message = rules.message.and_then(|item| record.number(item)).unwrap_or(0.0) as u8;
    let mut found = Vec::new();
    let mut say = |item: &'static Item, how| found.push(Breach { category, item: item.id, how });
    let needed = rules.needed.iter().filter(|(types, _)| types.contains(&message));
    for item in rules.always.iter().copied().chain(needed.map(|(_, item)| *item)) {
        if record.get(item).is_none() {
            say(item, How::Missing);
        }
    }
    for view in record.items() {
        let is = |item: &&&'static Item| item.is(view.item);
        if rules.never.iter().any(|item| is(&item)) {
            say(view.item, How::OutOfPlace { message: 0 });
        } else if let Some((types, _)) = rules.only.iter().find(|(_, item)| is(&item)) {
            if !types.contains(&message) {
                say(view.item, How::OutOfPlace { message });
            }
        } else if !rules.rest.is_empty()
            && !rules.always.iter().any(|item| is(&item))
            && !rules.rest.contains(&message)
        {
            say(view.item, How::OutOfPlace { message });
        }
        if !view.parts().all(|part| part.spares_are_zero()) {
            say(view.item, How::SpareSet);
        }
    }
    found
}
