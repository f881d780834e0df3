//! Tools on files of datagrams: what is in them, what is wrong with them, and parts of them.

use crate::error::{OpenError, Problem};
use crate::reader::{Datagram, Kind, Reader};
use pdu::enumerations::PduType;
use std::collections::BTreeSet;
use std::path::Path;

pub mod check;
pub mod diff;
pub mod dump;
pub mod edit;
pub mod fields;
pub mod json;
pub mod lint;
pub mod stat;

/// Destination ports that carry DIS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ports {
    /// All of them, as in a file of bare PDUs.
    All,
    /// These.
    Only(BTreeSet<u16>),
}

impl Ports {
    /// True if datagrams to `port` are DIS.
    #[must_use]
    pub fn contain(&self, port: u16) -> bool {
        match self {
            Self::All => true,
            Self::Only(ports) => ports.contains(&port),
        }
    }

    /// The ports `given`, or if that is empty, those that DIS goes to in this file: 3000 and every port
    /// to which at least one datagram went that begins with a sound header; all if there is none.
    /// Captures of a whole network hold other traffic too, and what is damaged on a DIS port has to
    /// be told nevertheless.
    ///
    /// # Errors
    /// [`OpenError`], with the path.
    pub fn of(path: &Path, given: &[u16]) -> Result<Self, OpenError> {
        if !given.is_empty() {
            return Ok(Self::Only(given.iter().copied().collect()));
        }
        let mut reader = Reader::open(path)?;
        if reader.kind() == Kind::Bare {
            return Ok(Self::All);
        }
        let mut ports = BTreeSet::new();
        let mut datagram = Datagram::empty();
        while let Some(result) = reader.read(&mut datagram) {
            if result.is_ok() && !ports.contains(&datagram.to.port()) && looks_like_dis(&datagram) {
                ports.insert(datagram.to.port());
            }
        }
        if ports.is_empty() {
            return Ok(Self::All);
        }
        ports.insert(3000);
        Ok(Self::Only(ports))
    }
}

/// A header whose version, type, family and length go together.
fn looks_like_dis(datagram: &Datagram) -> bool {
    let Some(Ok(frame)) = pdu::frames(&datagram.payload).next() else { return false };
    let header = &frame.header;
    (1..=7).contains(&header.version.0)
        && (1..=72).contains(&header.pdu_type.0)
        && header.family == pdu::family_of(header.pdu_type)
}

/// The DIS datagrams of a file.
#[derive(Debug)]
pub struct DisReader {
    reader: Reader,
    ports: Ports,
    others: u64,
}

impl DisReader {
    /// Opens a file; `ports` as for [`Ports::of`].
    ///
    /// # Errors
    /// [`OpenError`], with the path.
    pub fn open(path: impl AsRef<Path>, ports: &[u16]) -> Result<Self, OpenError> {
        let ports = Ports::of(path.as_ref(), ports)?;
        Ok(Self { reader: Reader::open(path)?, ports, others: 0 })
    }

    /// The next DIS datagram into `into`; `None` at the end.
    ///
    /// # Errors
    /// [`Problem`]; reading goes on behind it with the next call.
    pub fn read(&mut self, into: &mut Datagram) -> Option<Result<(), Problem>> {
        loop {
            match self.reader.read(into)? {
                Ok(()) if !self.ports.contain(into.to.port()) => self.others += 1,
                result => return Some(result),
            }
        }
    }

    /// UDP datagrams to other ports that were passed over.
    #[must_use]
    pub fn others(&self) -> u64 {
        self.others
    }

    /// Which ports count as DIS.
    #[must_use]
    pub fn ports(&self) -> &Ports {
        &self.ports
    }
}

/// A PDU type from its number or its name (as SISO-REF-010 has it, any case).
///
/// # Errors
/// The text, if it is neither.
pub fn pdu_type(text: &str) -> Result<PduType, BadType> {
    let plain = |t: &str| t.to_ascii_lowercase().replace(['-', '_', '/', ' '], "");
    let named = |t: &&PduType| t.name().is_some_and(|n| plain(n) == plain(text));
    text.parse::<u8>()
        .ok()
        .map(PduType)
        .or_else(|| PduType::NAMED.iter().find(named).copied())
        .ok_or_else(|| BadType(text.to_owned()))
}

/// A text that is no PDU type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no PDU type: a number (1) or a name (Entity State) is")]
pub struct BadType(pub String);

/// A PDU type for people: its name, or its number where it has none.
#[must_use]
pub fn type_name(t: PduType) -> String {
    t.name().map_or_else(|| format!("type {}", t.0), str::to_owned)
}
