//! `dump`: every PDU, one by one.

use super::fields::Value;
use super::{DisReader, json, type_name};
use crate::error::{OpenError, Problem};
use crate::reader::Datagram;
use crate::tools::edit::Selection;
use crate::utc::Utc;
use pdu::{Body, DecodeError, DisTime, Received};
use std::fmt;
use std::path::Path;

/// One line of a dump.
#[derive(Debug)]
pub enum Item<'a> {
    /// A sound PDU.
    Pdu {
        /// Its datagram.
        datagram: &'a Datagram,
        /// The PDU.
        pdu: &'a Received<'a>,
    },
    /// A damaged one.
    Damaged {
        /// Its datagram.
        datagram: &'a Datagram,
        /// Where and why.
        error: &'a DecodeError,
    },
    /// A damaged place of the file.
    File(&'a Problem),
}

/// Hands out every PDU of a file that `selection` wants, and everything damaged.
///
/// # Errors
/// [`OpenError`], with the path; `take` may stop the dump with an error of its own.
pub fn dump<E: From<OpenError>>(
    path: impl AsRef<Path>,
    ports: &[u16],
    selection: &Selection,
    mut take: impl FnMut(&Item<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut reader = DisReader::open(path, ports)?;
    let mut datagram = Datagram::empty();
    let mut start_ns = None;
    while let Some(result) = reader.read(&mut datagram) {
        if let Err(problem) = result {
            take(&Item::File(&problem))?;
            continue;
        }
        let start_ns = *start_ns.get_or_insert(datagram.utc_ns);
        if !selection.wants_time(datagram.utc_ns, start_ns) {
            continue;
        }
        for frame in pdu::frames(&datagram.payload) {
            let decoded = frame.and_then(|frame| {
                let pdu::Frame { index, offset, octets, .. } = frame;
                let wanted = selection.wants(&frame);
                frame.decode().map(|pdu| (wanted, Received { index, offset, octets, pdu }))
            });
            match &decoded {
                Ok((true, pdu)) => take(&Item::Pdu { datagram: &datagram, pdu })?,
                Ok((false, _)) => {}
                Err(error) => take(&Item::Damaged { datagram: &datagram, error })?,
            }
        }
    }
    Ok(())
}

impl Item<'_> {
    /// The fields of the PDU, header first.
    #[must_use]
    pub fn fields(&self) -> Option<Value> {
        let Self::Pdu { pdu, .. } = self else { return None };
        let body = match Value::of(pdu.body()) {
            // The body's type stands in the header.
            Value::Record(mut fields) if fields.len() == 1 => fields.remove(0).1,
            other => other,
        };
        let all = vec![("header".to_owned(), Value::of(pdu.header())), ("body".to_owned(), body)];
        Some(Value::Record(all))
    }

    /// For programs: one object.
    #[must_use]
    pub fn json(&self) -> String {
        let at = |d: &Datagram| {
            json::Object::default()
                .raw("frame", d.frame)
                .raw("utc_ns", d.utc_ns)
                .text("from", d.from)
                .text("to", d.to)
        };
        match self {
            Self::Pdu { datagram, pdu } => {
                let header = pdu.header();
                let object = at(datagram)
                    .raw("pdu", pdu.index)
                    .raw("offset", pdu.offset)
                    .raw("length", pdu.octets.len())
                    .raw("type", header.pdu_type.0)
                    .text("name", type_name(header.pdu_type))
                    .raw("timestamp_s", seconds_past_hour(header.timestamp));
                match self.fields() {
                    Some(Value::Record(fields)) => fields
                        .iter()
                        .fold(object, |object, (name, value)| object.raw(name, value.json()))
                        .end(),
                    _ => object.end(),
                }
            }
            Self::Damaged { datagram, error } => at(datagram)
                .raw("pdu", error.index)
                .raw("offset", error.pdu_offset + error.offset)
                .text("damaged", error)
                .end(),
            Self::File(problem) => json::Object::default().text("problem", problem).end(),
        }
    }
}

/// To the nanosecond, below 3600.
fn seconds_past_hour(stamp: DisTime) -> String {
    let nanos = stamp.nanos_past_hour();
    format!("{}.{:09}", nanos / 1_000_000_000, nanos % 1_000_000_000)
}

impl fmt::Display for Item<'_> {
    /// One line: time, frame, sender, type, and what matters most.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let start = |f: &mut fmt::Formatter<'_>, d: &Datagram, index: usize| {
            write!(f, "{} {}.{index} {} > {} ", Utc(d.utc_ns), d.frame, d.from, d.to)
        };
        match self {
            Self::File(problem) => write!(f, "{problem}"),
            Self::Damaged { datagram, error } => {
                start(f, datagram, error.index)?;
                write!(f, "DAMAGED {error}")
            }
            Self::Pdu { datagram, pdu } => {
                start(f, datagram, pdu.index)?;
                let h = pdu.header();
                let (name, stamp) = (type_name(h.pdu_type), h.timestamp);
                write!(
                    f,
                    "{name} v{} ex {} at {stamp}, {} bytes",
                    h.version.0,
                    h.exercise_id,
                    pdu.octets.len()
                )?;
                match pdu.body() {
                    Body::EntityState(s) => {
                        let (l, v) = (s.location, s.linear_velocity_mps);
                        write!(f, ": {} `{}` {}", s.entity_id, s.marking.text(), s.entity_type)?;
                        write!(f, " at {:.2} {:.2} {:.2} m", l.x_m, l.y_m, l.z_m)?;
                        write!(f, " moving {:.2} {:.2} {:.2} m/s", v.x, v.y, v.z)?;
                        // Bits 21 and 23 of every appearance word (SISO-REF-010).
                        for (bit, word) in [(21, "frozen"), (23, "deactivated")] {
                            if s.appearance >> bit & 1 == 1 {
                                write!(f, " {word}")?;
                            }
                        }
                        Ok(())
                    }
                    _ => Ok(()),
                }
            }
        }
    }
}
