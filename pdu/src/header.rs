//! The PDU header.

use crate::DisTime;
use crate::enumerations::{PduType, ProtocolFamily, ProtocolVersion};
use crate::wire::Wire;

/// Octets of a header.
pub const HEADER_LEN: usize = 12;

record! {
    /// The header of every PDU, 12 octets. Source: IEEE 1278.1-2012, 6.2.66.
    ///
    /// In versions 5 and 6 the last two octets are padding; they are kept in `status` and `padding`.
    Header {
        /// Protocol version.
        version: ProtocolVersion,
        /// Exercise.
        exercise_id: u8,
        /// Type of the PDU.
        pdu_type: PduType,
        /// Family of the PDU.
        family: ProtocolFamily,
        /// Time past the hour to which the PDU's data belong.
        timestamp: DisTime,
        /// Octets of the PDU, this header included.
        length: u16,
        /// Status bits (DIS 7).
        status: PduStatus,
        /// Unused.
        padding: u8,
    }
}

/// The status octet of a DIS 7 header. Source: IEEE 1278.1-2012, 6.2.67.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PduStatus(
    /// The octet on the wire.
    pub u8,
);

/// Whether the data come from a live, virtual or constructive entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lvc {
    /// The sender does not say.
    NoStatement = 0,
    /// A real entity.
    Live = 1,
    /// A simulated entity with a person in control.
    Virtual = 2,
    /// A simulated entity under a program's control.
    Constructive = 3,
}

impl PduStatus {
    /// Live, virtual or constructive (bits 1 and 2).
    #[must_use]
    pub fn lvc(self) -> Lvc {
        match self.0 >> 1 & 3 {
            0 => Lvc::NoStatement,
            1 => Lvc::Live,
            2 => Lvc::Virtual,
            _ => Lvc::Constructive,
        }
    }
    /// The same with another LVC indicator.
    #[must_use]
    pub fn with_lvc(self, lvc: Lvc) -> Self {
        Self(self.0 & !6 | (lvc as u8) << 1)
    }
    /// True if the entity is simulated by another than its original owner (bit 0).
    #[must_use]
    pub fn is_transferred(self) -> bool {
        self.0 & 1 == 1
    }
    /// True if an Attribute PDU couples more data to this PDU (bit 3).
    #[must_use]
    pub fn is_coupled(self) -> bool {
        self.0 >> 3 & 1 == 1
    }
}

impl Wire for PduStatus {
    const SIZE: usize = 1;
    #[inline(always)]
    fn get(octets: &[u8]) -> Self {
        Self(u8::get(octets))
    }
    #[inline(always)]
    fn put(&self, octets: &mut [u8]) {
        self.0.put(octets);
    }
}

/// The family that a type belongs to. Source: SISO-REF-010, UID 4 and 5.
#[must_use]
pub fn family_of(pdu_type: PduType) -> ProtocolFamily {
    ProtocolFamily(match pdu_type.0 {
        1 | 4 | 66 | 67 | 72 => 1,
        2 | 3 | 68 | 69 => 2,
        5..=10 => 3,
        25..=27 | 31 | 32 => 4,
        11..=22 => 5,
        23 | 24 | 28..=30 => 6,
        33..=36 => 7,
        37..=40 => 8,
        41..=45 => 9,
        51..=65 => 10,
        46..=50 => 11,
        70 | 71 => 13,
        _ => 0,
    })
}
