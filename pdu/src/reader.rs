//! A cursor over one PDU that knows where it is, and the errors of decoding.

use crate::enumerations::PduType;
use crate::wire::{Part, Wire};

/// Why octets are not a sound PDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// The PDU ends inside the field.
    #[error("needs {needs} octets, {left} left")]
    Short {
        /// Octets of the field.
        needs: usize,
        /// Octets that the PDU still has.
        left: usize,
    },
    /// The body is complete before the PDU's length is used up.
    #[error("{octets} octets left over after the body")]
    LeftOver {
        /// How many.
        octets: usize,
    },
    /// The header's length is less than a header.
    #[error("length {length} is less than the header's 12 octets")]
    LengthBelowHeader {
        /// The header's length field.
        length: u16,
    },
    /// The header's length reaches beyond the datagram.
    #[error("length {length} reaches beyond the datagram, {left} octets left")]
    LengthBeyondDatagram {
        /// The header's length field.
        length: u16,
        /// Octets from this header to the end of the datagram.
        left: usize,
    },
    /// Octets at the end of a datagram that are too few for a header.
    #[error("{octets} trailing octets, too few for a header")]
    Trailing {
        /// How many.
        octets: usize,
    },
    /// A length field inside the body contradicts what it counts.
    #[error("length field says {value}, which does not fit its record")]
    BadLength {
        /// The field's value.
        value: u64,
    },
}

/// Where inside one PDU decoding failed, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyError {
    /// Octets from the start of the PDU (its header included).
    pub offset: usize,
    /// The field.
    pub field: &'static str,
    /// The part of the field, where it is a record.
    pub part: Option<&'static str>,
    /// What is wrong.
    pub reason: Reason,
}

/// A damaged PDU (or trailing octets) of a datagram: which, where, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeError {
    /// Number of the PDU in its datagram, from 0.
    pub index: usize,
    /// Octets from the start of the datagram to the PDU.
    pub pdu_offset: usize,
    /// The PDU's type, where its header could be read.
    pub pdu_type: Option<PduType>,
    /// Octets from the start of the PDU to the field.
    pub offset: usize,
    /// The field.
    pub field: &'static str,
    /// The part of the field, where it is a record.
    pub part: Option<&'static str>,
    /// What is wrong.
    pub reason: Reason,
}

impl DecodeError {
    /// True for octets after the last PDU, which are no PDU themselves.
    #[must_use]
    pub fn is_trailing(&self) -> bool {
        matches!(self.reason, Reason::Trailing { .. })
    }
}

impl std::error::Error for DecodeError {}

impl std::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.pdu_type.map(|t| (t, t.name())) {
            Some((_, Some(name))) => write!(f, "{name} PDU")?,
            Some((t, None)) => write!(f, "PDU of type {}", t.0)?,
            None => write!(f, "PDU")?,
        }
        write!(f, " {} at octet {}", self.index, self.pdu_offset)?;
        write!(f, ", octet {}, field `{}", self.offset, self.field)?;
        if let Some(part) = self.part {
            write!(f, ".{part}")?;
        }
        write!(f, "`: {}", self.reason)
    }
}

/// A cursor over one PDU.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    octets: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// A reader of `pdu` that stands at octet `at` (at most the PDU's length).
    #[inline]
    pub(crate) fn new(pdu: &'a [u8], at: usize) -> Self {
        Self { octets: pdu, at: at.min(pdu.len()) }
    }

    /// Octets from the start of the PDU.
    #[must_use]
    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// Octets that are left.
    #[must_use]
    #[inline]
    pub(crate) fn left(&self) -> usize {
        self.octets.len() - self.at
    }

    /// The protocol version of the PDU's header (0 where there is none).
    pub(crate) fn version(&self) -> u8 {
        self.octets.first().copied().unwrap_or(0)
    }

    /// Reads a value of fixed size.
    #[inline(always)]
    pub(crate) fn get<T: Wire>(&mut self, field: &'static str) -> Result<T, BodyError> {
        match self.octets.get(self.at..self.at + T::SIZE) {
            Some(octets) => {
                self.at += T::SIZE;
                Ok(T::get(octets))
            }
            None => Err(self.short_value::<T>(Some(field))),
        }
    }

    /// Reads a record whose parts are the fields of the body.
    #[inline(always)]
    pub(crate) fn record<T: Wire>(&mut self) -> Result<T, BodyError> {
        match self.octets.get(self.at..self.at + T::SIZE) {
            Some(octets) => {
                self.at += T::SIZE;
                Ok(T::get(octets))
            }
            None => Err(self.short_value::<T>(None)),
        }
    }

    #[cold]
    #[inline(never)]
    fn short_value<T: Wire>(&self, field: Option<&'static str>) -> BodyError {
        let left = self.left();
        let whole = Part { name: "body", inner: None, offset: 0, size: T::SIZE };
        let part = T::part_beyond(left);
        let found = part.unwrap_or(whole);
        let (field, part) = match (field, part) {
            (Some(field), part) => (field, part.map(|p| p.name)),
            (None, _) => (found.name, found.inner),
        };
        let reason = Reason::Short { needs: found.size, left: left - found.offset };
        BodyError { offset: self.at + found.offset, field, part, reason }
    }

    /// Takes `count` octets.
    #[inline]
    pub(crate) fn take(
        &mut self,
        count: usize,
        field: &'static str,
    ) -> Result<&'a [u8], BodyError> {
        let left = self.left();
        if count > left {
            let reason = Reason::Short { needs: count, left };
            return Err(BodyError { offset: self.at, field, part: None, reason });
        }
        let octets = &self.octets[self.at..self.at + count];
        self.at += count;
        Ok(octets)
    }

    /// A reader of the next `count` octets alone; offsets stay those of the PDU.
    pub(crate) fn part(
        &mut self,
        count: usize,
        field: &'static str,
    ) -> Result<Reader<'a>, BodyError> {
        let at = self.at;
        self.take(count, field)?;
        Ok(Self { octets: &self.octets[..self.at], at })
    }

    /// An error about the octets read last.
    #[cold]
    pub(crate) fn bad_length(&self, field: &'static str, value: u64) -> BodyError {
        BodyError { offset: self.at, field, part: None, reason: Reason::BadLength { value } }
    }

    /// Refuses octets that the body did not use.
    #[inline]
    pub(crate) fn finish(&self) -> Result<(), BodyError> {
        match self.left() {
            0 => Ok(()),
            octets => Err(BodyError {
                offset: self.at,
                field: "length",
                part: None,
                reason: Reason::LeftOver { octets },
            }),
        }
    }
}
