//! Why octets were refused, and where.

use std::fmt;

/// A refusal: where in the datagram, in which item, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeError {
    /// Octet of the datagram at which the item (or the header) begins.
    pub offset: usize,
    /// Category of the block, when its header could be read.
    pub category: Option<u8>,
    /// Number of the record in its block, from 1; 0 in the header.
    pub record: usize,
    /// The item.
    pub item: Option<&'static str>,
    /// The subitem of a compound item.
    pub subitem: Option<&'static str>,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong with octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Fewer than three octets.
    #[error("the header of a block needs 3 octets, {left} left")]
    HeaderCut {
        /// Octets there are.
        left: usize,
    },
    /// A length that does not even hold the header.
    #[error("a block of length {length}: at least 3")]
    LengthTooSmall {
        /// The length said.
        length: usize,
    },
    /// A length beyond the end of the datagram.
    #[error("a block of length {length}, {left} octets left")]
    LengthBeyond {
        /// The length said.
        length: usize,
        /// Octets there are.
        left: usize,
    },
    /// The FSPEC or a primary subfield goes on after its last possible octet, or after the block's end.
    #[error("the field specification never ends")]
    SpecificationEndless,
    /// A record that names no item.
    #[error("a record without an item")]
    Empty,
    /// A position of the profile that has no item.
    #[error("spare position {position} of the field specification is set")]
    SparePosition {
        /// Position, from 1 (FRN).
        position: usize,
    },
    /// Fewer octets than the item needs.
    #[error("needs {needed} octets, {left} left")]
    Cut {
        /// Octets needed.
        needed: usize,
        /// Octets there are.
        left: usize,
    },
    /// An extended item goes on after its last part.
    #[error("asks for a part after its last one ({parts})")]
    PartsBeyond {
        /// Parts it may have.
        parts: usize,
    },
    /// More repetitions than octets.
    #[error("{count} repetitions of {octets} octets announced, {left} octets left")]
    RepetitionsBeyond {
        /// Repetitions announced.
        count: usize,
        /// Octets of one.
        octets: usize,
        /// Octets there are.
        left: usize,
    },
    /// The length octet of an explicit item is too small for what it holds.
    #[error("explicit length {length}, {needed} octets needed")]
    ExplicitTooShort {
        /// The length said.
        length: usize,
        /// Octets that the contents need.
        needed: usize,
    },
    /// Octets of an explicit item that belong to nothing.
    #[error("{0} octets of the explicit item belong to nothing")]
    ExplicitLeft(usize),
}

impl Fault {
    /// One word for counters: `header`, `length`, `fspec`, `cut`, `item`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::HeaderCut { .. } => "header",
            Self::LengthTooSmall { .. } | Self::LengthBeyond { .. } => "length",
            Self::SpecificationEndless | Self::Empty => "fspec",
            Self::SparePosition { .. } => "unknown item",
            Self::Cut { .. } | Self::RepetitionsBeyond { .. } => "cut",
            Self::PartsBeyond { .. } | Self::ExplicitTooShort { .. } | Self::ExplicitLeft(_) => {
                "item"
            }
        }
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "octet {}: ", self.offset)?;
        if let Some(category) = self.category {
            write!(f, "category {category:03}, ")?;
        }
        if self.record > 0 {
            write!(f, "record {}, ", self.record)?;
        }
        if let Some(item) = self.item {
            write!(f, "item {item}")?;
            if let Some(subitem) = self.subitem {
                write!(f, "/{subitem}")?;
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.fault)
    }
}

impl std::error::Error for DecodeError {}
