//! `cut` and `merge`: parts of files, and several in one.

use super::DisReader;
use crate::bytes::be16;
use crate::error::{OpenError, Problem};
use crate::reader::Datagram;
use crate::recorder::{RecordError, Recorder};
use crate::rewrite::{Rewrite, identifiers};
use crate::utc::When;
use pdu::Frame;
use pdu::enumerations::PduType;
use pdu::records::EntityId;
use std::fs::File;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Entities by their numbers; 65535 (`*`) stands for any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntityPattern(pub EntityId);

/// A text that names no entities.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` names no entities: SITE:APPLICATION:ENTITY does (1:3:42, or 1:3:* for all of 1:3)")]
pub struct BadEntity(pub String);

impl std::str::FromStr for EntityPattern {
    type Err = BadEntity;

    fn from_str(text: &str) -> Result<Self, BadEntity> {
        let bad = || BadEntity(text.to_owned());
        let number = |t: &str| match t {
            "*" => Ok(0xffff),
            t => t.parse::<u16>().map_err(|_| bad()),
        };
        let parts: Vec<&str> = text.split(':').collect();
        let [site, application, entity] = parts[..] else { return Err(bad()) };
        Ok(Self(EntityId::new(number(site)?, number(application)?, number(entity)?)))
    }
}

/// What is wanted of a file. The default is everything.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// From this time on.
    pub from: Option<When>,
    /// Up to and with this time.
    pub to: Option<When>,
    /// These exercises (all if empty).
    pub exercises: Vec<u8>,
    /// These types (all if empty).
    pub types: Vec<PduType>,
    /// PDUs that name one of these entities (all if empty).
    pub entities: Vec<EntityPattern>,
}

impl Selection {
    /// True if the time is wanted; `start_ns` is that of the first datagram.
    #[must_use]
    pub fn wants_time(&self, utc_ns: i64, start_ns: i64) -> bool {
        self.from.is_none_or(|t| utc_ns >= t.utc_ns(start_ns))
            && self.to.is_none_or(|t| utc_ns <= t.utc_ns(start_ns))
    }

    /// True if the PDU is wanted, whatever its time.
    #[must_use]
    pub fn wants(&self, frame: &Frame<'_>) -> bool {
        let header = &frame.header;
        (self.exercises.is_empty() || self.exercises.contains(&header.exercise_id))
            && (self.types.is_empty() || self.types.contains(&header.pdu_type))
            && (self.entities.is_empty() || self.names_an_entity(frame.octets))
    }

    fn names_an_entity(&self, pdu: &[u8]) -> bool {
        identifiers(pdu).into_iter().any(|at| {
            let id = match (be16(pdu, at), be16(pdu, at + 2), be16(pdu, at + 4)) {
                (Some(site), Some(application), Some(entity)) => {
                    EntityId::new(site, application, entity)
                }
                _ => return false,
            };
            self.entities.iter().any(|wanted| wanted.0.addresses(id))
        })
    }

    /// True if PDUs are chosen by more than their time.
    #[must_use]
    pub fn looks_inside(&self) -> bool {
        !(self.exercises.is_empty() && self.types.is_empty() && self.entities.is_empty())
    }
}

/// What is changed on the way.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Identifiers in PDUs.
    pub rewrite: Rewrite,
    /// Sender of every datagram.
    pub from: Option<SocketAddr>,
    /// Receiver of every datagram.
    pub to: Option<SocketAddr>,
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Edited {
    /// Datagrams read.
    pub read: u64,
    /// Datagrams written.
    pub written: u64,
    /// PDUs written.
    pub pdus: u64,
    /// Damaged PDUs left out: because the selection looks inside PDUs, or because in a file of bare PDUs
    /// nothing behind them could be found again.
    pub damaged_left_out: u64,
    /// Damaged places of the files.
    pub problems: u64,
}

/// Why nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// An input.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The output.
    #[error("{path}: {cause}")]
    Write {
        /// The output as named by the caller.
        path: String,
        /// What the system said.
        cause: io::Error,
    },
    /// The output.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Writes what `selection` wants of all `inputs`, in the order of time, to `output`: pcapng, or bare
/// PDUs where its name ends in `.raw`, `.bin` or `.dis`. Several inputs are merged: within each file
/// the order stays. The output appears only when it is whole. `tell` gets what is wrong with inputs.
///
/// # Errors
/// [`EditError`]; no output then.
pub fn edit(
    inputs: &[PathBuf],
    output: &Path,
    ports: &[u16],
    selection: &Selection,
    change: &Change,
    mut tell: impl FnMut(&Path, &Problem),
) -> Result<Edited, EditError> {
    let mut done = Edited::default();
    let mut heads = Vec::new();
    for path in inputs {
        let mut head = Head {
            path,
            reader: DisReader::open(path, ports)?,
            datagram: Datagram::empty(),
            open: true,
        };
        head.advance(&mut done, &mut tell);
        heads.push(head);
    }
    let start_ns = heads.iter().filter(|h| h.open).map(|h| h.datagram.utc_ns).min().unwrap_or(0);
    // A link stays a link; a device or a pipe is written to, never replaced by a file.
    let place = std::fs::canonicalize(output).unwrap_or_else(|_| output.to_path_buf());
    if std::fs::metadata(&place).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        write_all(&mut heads, output, &place, selection, change, start_ns, &mut done, &mut tell)?;
        return Ok(done);
    }
    let mut part = place.clone().into_os_string();
    part.push(".part");
    let part = PathBuf::from(part);
    let result =
        write_all(&mut heads, output, &part, selection, change, start_ns, &mut done, &mut tell);
    let renamed = result.and_then(|()| {
        std::fs::rename(&part, &place)
            .map_err(|cause| EditError::Write { path: output.display().to_string(), cause })
    });
    if let Err(error) = renamed {
        let _ = std::fs::remove_file(&part);
        return Err(error);
    }
    Ok(done)
}

#[expect(clippy::too_many_arguments, reason = "the body of one function, apart for its `?`")]
fn write_all(
    heads: &mut [Head<'_>],
    output: &Path,
    part: &Path,
    selection: &Selection,
    change: &Change,
    start_ns: i64,
    done: &mut Edited,
    tell: &mut dyn FnMut(&Path, &Problem),
) -> Result<(), EditError> {
    let failed = |cause| EditError::Write { path: output.display().to_string(), cause };
    // A tool that ends at the first fault does not stand still and wait for room, as a recording does.
    let of_record = |error| match error {
        RecordError::Write { cause, .. } => failed(cause),
        other => EditError::Record(other),
    };
    let bare = output
        .extension()
        .and_then(|e| e.to_str())
        .is_some_and(|e| ["raw", "bin", "dis"].contains(&e.to_ascii_lowercase().as_str()));
    let mut writer = if bare {
        Writer::Bare(io::BufWriter::new(File::create(part).map_err(failed)?))
    } else {
        Writer::Recording(Recorder::create(part).map_err(failed)?)
    };
    let mut payload = Vec::new();
    // The earliest of the files' next datagrams; of equal ones, the first file's.
    while let Some(i) =
        (0..heads.len()).filter(|i| heads[*i].open).min_by_key(|i| heads[*i].datagram.utc_ns)
    {
        let datagram = &heads[i].datagram;
        done.read += 1;
        if selection.wants_time(datagram.utc_ns, start_ns)
            && pick(datagram, selection, &mut payload, done)
        {
            change.rewrite.apply(&mut payload);
            let from = change.from.unwrap_or(datagram.from);
            let to = change.to.unwrap_or(datagram.to);
            match &mut writer {
                Writer::Bare(file) => {
                    let sound = keep_sound(&mut payload);
                    done.damaged_left_out += sound.left_out;
                    if sound.pdus == 0 {
                        heads[i].advance(done, tell);
                        continue;
                    }
                    file.write_all(&payload).map_err(failed)?;
                }
                Writer::Recording(recorder) => recorder
                    .record_with(datagram.utc_ns, from, to, &payload, datagram.comment.as_deref())
                    .map_err(of_record)?,
            }
            done.written += 1;
        }
        heads[i].advance(done, tell);
    }
    match writer {
        Writer::Bare(mut file) => file.flush().map_err(failed),
        Writer::Recording(recorder) => recorder.close(0).map(drop).map_err(of_record),
    }
}

enum Writer {
    Bare(io::BufWriter<File>),
    Recording(Recorder),
}

/// A file and its next datagram.
struct Head<'a> {
    path: &'a Path,
    reader: DisReader,
    datagram: Datagram,
    open: bool,
}

impl Head<'_> {
    fn advance(&mut self, done: &mut Edited, tell: &mut dyn FnMut(&Path, &Problem)) {
        loop {
            match self.reader.read(&mut self.datagram) {
                None => {
                    self.open = false;
                    return;
                }
                Some(Ok(())) => return,
                Some(Err(problem)) => {
                    done.problems += 1;
                    tell(self.path, &problem);
                }
            }
        }
    }
}

/// What of a payload can stand in a file of bare PDUs.
struct Sound {
    pdus: u64,
    left_out: u64,
}

/// Leaves what a reader of bare PDUs finds its way through: it has nothing but the lengths in the headers,
/// where a datagram has an end of its own.
fn keep_sound(payload: &mut Vec<u8>) -> Sound {
    let mut kept = Vec::with_capacity(payload.len());
    let mut sound = Sound { pdus: 0, left_out: 0 };
    let mut frames = pdu::frames(payload);
    for frame in frames.by_ref() {
        match frame {
            Ok(frame) => {
                kept.extend_from_slice(frame.octets);
                sound.pdus += 1;
            }
            Err(_) => sound.left_out += 1,
        }
    }
    // Octets behind the last PDU.
    if sound.left_out == 0 && !frames.rest().is_empty() {
        sound.left_out = 1;
    }
    *payload = kept;
    sound
}

/// What is wanted of a datagram, into `payload`; false if nothing is. A datagram of which everything
/// is wanted stays as it is, damaged or not.
fn pick(
    datagram: &Datagram,
    selection: &Selection,
    payload: &mut Vec<u8>,
    done: &mut Edited,
) -> bool {
    payload.clear();
    if !selection.looks_inside() {
        payload.extend_from_slice(&datagram.payload);
        done.pdus += pdu::frames(payload).filter(Result::is_ok).count() as u64;
        return true;
    }
    for frame in pdu::frames(&datagram.payload) {
        match frame {
            Ok(frame) if selection.wants(&frame) => {
                payload.extend_from_slice(frame.octets);
                done.pdus += 1;
            }
            Ok(_) => {}
            Err(_) => done.damaged_left_out += 1,
        }
    }
    !payload.is_empty()
}
