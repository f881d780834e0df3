//! The journal of an administration station: what its conductor was told, on disk before anybody hears what it decided.
//!
//! A station that is started again with the journal of one that died is that station: the conductor is a pure function of what it
//! was told, so it knows every order that was given and numbers the next ones as the one before would have. The file is written
//! and not synchronised: it survives the process, not the host. It ends with the run.

use super::codec::{RECORD_LIMIT, from_record, to_record};
use super::conductor::{ConductorConfig, Step};
use super::digest::pdu_hash;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufReader, Error, Read, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// What every record begins with.
const MARK: u32 = u32::from_le_bytes(*b"SJ01");

/// Octets before each record: mark, length, hash.
const HEAD: usize = 16;

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The system refuses it.
    #[error(
        "the journal {path}: {error}: name a file in a folder where this user may write (--journal)"
    )]
    File {
        /// The file.
        path: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// It is in use.
    #[error(
        "the journal {0} belongs to an administration station that runs: one file each (--journal)"
    )]
    InUse(String),
    /// It is no journal, or of another run.
    #[error(
        "the journal {path} is {what}: remove it to begin anew, or name another file (--journal)"
    )]
    Another {
        /// The file.
        path: String,
        /// What it is instead.
        what: &'static str,
    },
}

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Where the next record begins.
    end: u64,
    /// There may be more behind it, which does not count.
    torn: bool,
}

/// What a journal holds of a station that died.
pub struct Past {
    /// The federation that it led.
    pub fed: u128,
    reader: BufReader<File>,
}

impl Journal {
    /// Opens or begins the journal of the run that `config` describes, a file or one of its own in a folder; with what it holds already,
    /// if a station died.
    ///
    /// # Errors
    /// If the file cannot be used, belongs to another run or build, or another station writes it.
    pub fn open(
        path: &Path,
        config: &ConductorConfig,
    ) -> Result<(Self, Option<Past>), JournalError> {
        let of = run_of(config);
        let own = || path.join(format!("seeds-{:016x}.journal", pdu_hash(of.as_bytes())));
        let path = &if path.is_dir() { own() } else { path.to_owned() };
        let name = || path.display().to_string();
        let refused = |error| JournalError::File { path: name(), error };
        let another = |what| JournalError::Another { path: name(), what };
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let file = options.open(path).map_err(refused)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JournalError::InUse(name())),
            Err(TryLockError::Error(error)) => return Err(refused(error)),
        }
        let mut reader = BufReader::new(file.try_clone().map_err(refused)?);
        let empty = file.metadata().map_err(refused)?.len() == 0;
        let head = record(&mut reader);
        let mut journal = Self { path: path.to_owned(), file, end: 0, torn: true };
        match head {
            None if empty => {
                let mut records = Vec::new();
                add(&mut records, &Line::Head(of.into(), config.fed)).map_err(refused)?;
                journal.write(&records).map_err(refused)?;
                Ok((journal, None))
            }
            Some((Line::Head(was, fed), octets)) if was == of => {
                journal.end = octets;
                Ok((journal, Some(Past { fed, reader })))
            }
            Some((Line::Head(..), _)) => {
                Err(another("one of another run (scene, seed, flags or build)"))
            }
            _ => Err(another("no journal of an administration station")),
        }
    }

    /// Adds the steps of a conductor, a tick at the end; to be called before anybody hears what it decided.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn append(&mut self, steps: &[Step]) -> std::io::Result<()> {
        if std::mem::take(&mut self.torn) {
            self.file.set_len(self.end)?;
        }
        let mut records = Vec::new();
        for step in steps {
            add(&mut records, &Line::Step(Cow::Borrowed(step)))?;
        }
        self.write(&records)
    }

    fn write(&mut self, records: &[u8]) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(records)?;
        self.end += records.len() as u64;
        Ok(())
    }

    /// The run is over, or nobody may go on from here: the file is removed.
    pub fn remove(self) {
        if let Err(e) = std::fs::remove_file(&self.path) {
            tracing::warn!("the journal {} could not be removed: {e}", self.path.display());
        }
    }

    /// The steps of the station that died, up to its last tick: what was told after it led to nothing that anybody heard of, and the
    /// journal goes on in its place.
    pub fn steps<'a>(&'a mut self, past: &'a mut Past) -> impl Iterator<Item = Step> + 'a {
        let (mut whole, mut octets) = (VecDeque::new(), 0);
        std::iter::from_fn(move || {
            loop {
                if let Some(step) = whole.pop_front() {
                    return Some(step);
                }
                let mut begun = VecDeque::new();
                while !matches!(begun.back(), Some(Step::Tick(_))) {
                    let (Line::Step(step), length) = record(&mut past.reader)? else { return None };
                    octets += length;
                    begun.push_back(step.into_owned());
                }
                self.end += std::mem::take(&mut octets);
                whole = begun;
            }
        })
    }
}

/// A record of a journal, behind its head.
#[derive(Serialize, Deserialize)]
enum Line<'a> {
    /// Of which run it is, and the federation.
    Head(Cow<'a, str>, u128),
    /// A step of the conductor.
    Step(Cow<'a, Step>),
}

/// What a journal is of: everything that a conductor is begun with, but for what is drawn.
fn run_of(config: &ConductorConfig) -> String {
    format!("{:?}", ConductorConfig { fed: 0, ..config.clone() })
}

fn add(records: &mut Vec<u8>, line: &Line<'_>) -> std::io::Result<()> {
    let octets = to_record(line).map_err(Error::other)?;
    records.extend(MARK.to_le_bytes());
    records.extend((octets.len() as u32).to_le_bytes());
    records.extend(pdu_hash(&octets).to_le_bytes());
    records.extend(octets);
    Ok(())
}

/// The next sound record and its octets; the last one may have been cut short by the end of its writer.
fn record(from: &mut impl Read) -> Option<(Line<'static>, u64)> {
    let mut head = [0; HEAD];
    from.read_exact(&mut head).ok()?;
    let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let length = word(4);
    if word(0) != MARK || u64::from(length) > RECORD_LIMIT {
        return None;
    }
    let mut octets = vec![0; length as usize];
    from.read_exact(&mut octets).ok()?;
    let sum = u64::from(word(8)) | u64::from(word(12)) << 32;
    if pdu_hash(&octets) != sum {
        return None;
    }
    Some((from_record(&octets).ok()?, HEAD as u64 + u64::from(length)))
}

#[cfg(test)]
mod tests;
