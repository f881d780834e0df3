//! `check`: is every PDU sound, and does it come back octet by octet?

use super::{DisReader, json, type_name};
use crate::error::{OpenError, Problem};
use crate::reader::Datagram;
use pdu::DecodeError;
use pdu::enumerations::PduType;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// What was counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Check {
    /// DIS datagrams.
    pub datagrams: u64,
    /// Sound PDUs.
    pub pdus: u64,
    /// Sound PDUs by type.
    pub by_type: BTreeMap<u8, u64>,
    /// Damaged PDUs.
    pub damaged: u64,
    /// Sound PDUs that are the same octets after decoding and encoding.
    pub reencoded_identical: u64,
    /// Datagrams with octets behind the last PDU that are too few for one.
    pub trailing: u64,
    /// UDP datagrams to other ports.
    pub others: u64,
    /// Places where the file itself is damaged.
    pub problems: u64,
}

/// Something worth telling.
#[derive(Debug)]
pub enum Finding<'a> {
    /// The file is damaged.
    File(&'a Problem),
    /// A PDU is damaged, or octets are left over.
    Damaged {
        /// The datagram.
        datagram: &'a Datagram,
        /// Where and why.
        error: &'a DecodeError,
    },
    /// The capture left out the end of a datagram.
    Missing {
        /// The datagram.
        datagram: &'a Datagram,
    },
    /// Encoding gives other octets than came.
    Changed {
        /// The datagram.
        datagram: &'a Datagram,
        /// Number of the PDU in its datagram, from 0.
        index: usize,
        /// Its type.
        pdu_type: PduType,
        /// The first octet of the PDU that differs.
        octet: usize,
    },
}

/// Decodes and encodes every PDU of a file.
///
/// # Errors
/// [`OpenError`], with the path. What is damaged inside the file is told and counted.
pub fn check(
    path: impl AsRef<Path>,
    ports: &[u16],
    mut tell: impl FnMut(&Finding<'_>),
) -> Result<Check, OpenError> {
    let mut reader = DisReader::open(path, ports)?;
    let mut counts = Check::default();
    let mut datagram = Datagram::empty();
    let mut again = Vec::new();
    while let Some(result) = reader.read(&mut datagram) {
        if let Err(problem) = result {
            counts.problems += 1;
            tell(&Finding::File(&problem));
            continue;
        }
        counts.datagrams += 1;
        if datagram.missing > 0 {
            tell(&Finding::Missing { datagram: &datagram });
        }
        for item in pdu::pdus(&datagram.payload) {
            match item {
                Ok(received) => {
                    counts.pdus += 1;
                    let pdu_type = received.header().pdu_type;
                    *counts.by_type.entry(pdu_type.0).or_default() += 1;
                    again.clear();
                    let encoded = received.append(&mut again).is_ok();
                    if encoded && again == received.octets {
                        counts.reencoded_identical += 1;
                    } else {
                        let same = again.iter().zip(received.octets).take_while(|(a, b)| a == b);
                        let (index, octet) = (received.index, same.count());
                        tell(&Finding::Changed { datagram: &datagram, index, pdu_type, octet });
                    }
                }
                Err(error) => {
                    // A whole datagram too short for a header is a damaged PDU; a few octets behind
                    // sound PDUs are not one.
                    if error.is_trailing() && error.index > 0 {
                        counts.trailing += 1;
                    } else {
                        counts.damaged += 1;
                    }
                    tell(&Finding::Damaged { datagram: &datagram, error: &error });
                }
            }
        }
    }
    counts.others = reader.others();
    Ok(counts)
}

impl Check {
    /// The closing line for programs.
    #[must_use]
    pub fn json(&self) -> String {
        json::Object::default()
            .raw("datagrams", self.datagrams)
            .raw("pdus", self.pdus)
            .raw("by_type", json::counts(self.by_type.iter().map(|(t, n)| (t, *n))))
            .raw("damaged", self.damaged)
            .raw("reencoded_identical", self.reencoded_identical)
            .end()
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:>10} datagrams", self.datagrams)?;
        writeln!(f, "{:>10} sound PDUs", self.pdus)?;
        for (t, n) in &self.by_type {
            writeln!(f, "{n:>10}   {} ({t})", type_name(PduType(*t)))?;
        }
        writeln!(f, "{:>10} identical after decoding and encoding", self.reencoded_identical)?;
        writeln!(f, "{:>10} damaged PDUs", self.damaged)?;
        for (n, what) in [
            (self.trailing, "datagrams with octets behind the last PDU"),
            (self.others, "datagrams to other ports, not looked at"),
            (self.problems, "places where the file is damaged"),
        ] {
            if n > 0 {
                writeln!(f, "{n:>10} {what}")?;
            }
        }
        Ok(())
    }
}

impl Finding<'_> {
    /// For programs: one object.
    #[must_use]
    pub fn json(&self) -> String {
        let at = |kind: &str, d: &Datagram| {
            json::Object::default().text("finding", kind).raw("frame", d.frame)
        };
        match self {
            Self::File(problem) => {
                json::Object::default().text("finding", "file").text("what", problem).end()
            }
            Self::Damaged { datagram, error } => {
                let kind = if error.is_trailing() { "trailing" } else { "damaged" };
                at(kind, datagram)
                    .raw("pdu", error.index)
                    .raw("offset", error.pdu_offset + error.offset)
                    .text("field", error.field)
                    .text("what", error)
                    .end()
            }
            Self::Missing { datagram } => {
                at("missing", datagram).raw("octets", datagram.missing).end()
            }
            Self::Changed { datagram, index, pdu_type, octet } => at("changed", datagram)
                .raw("pdu", index)
                .raw("type", pdu_type.0)
                .raw("octet", octet)
                .end(),
        }
    }
}

impl fmt::Display for Finding<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(problem) => write!(f, "{problem}"),
            Self::Damaged { datagram, error } => write!(f, "frame {}: {error}", datagram.frame),
            Self::Missing { datagram } => {
                let (frame, n) = (datagram.frame, datagram.missing);
                write!(f, "frame {frame}: the capture left out the last {n} bytes")
            }
            Self::Changed { datagram, index, pdu_type, octet } => {
                let (frame, t) = (datagram.frame, type_name(*pdu_type));
                write!(f, "frame {frame}: {t} PDU {index} differs after encoding, octet {octet}")
            }
        }
    }
}
