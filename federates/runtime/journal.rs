//! The journal of an administration station: what its conductor was told, on disk before anybody hears what it decided.
//!
//! A station that is started again with the journal of one that died is that station: the conductor is a pure function of what it
//! was told, so it knows every order that was given and numbers the next ones as the one before would have. The file is written
//! and not synchronised: it survives the process, not the host. It ends with the run.

use super::codec::{RECORD_LIMIT, from_record, to_record};
use super::conductor::{ConductorConfig, Step};
use super::digest::pdu_hash;
use super::succession::{Led, TAIL};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::VecDeque;
use std::fmt::Debug;
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
    #[error("the journal {path}: {error}: {} (--journal)", remedy(error))]
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

fn remedy(error: &std::io::Error) -> &'static str {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    match error.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => {
            "make room there, or name a file where there is some"
        }
        _ => "name a file in a folder where this user may write",
    }
}

/// What keeps the octets of a journal: a file, or one of a simulated host.
pub trait Disk: Debug + Send {
    /// Its length, octets.
    ///
    /// # Errors
    /// If the system refuses.
    fn length(&self) -> std::io::Result<u64>;
    /// Fills `octets` with those from there on.
    ///
    /// # Errors
    /// If the system refuses, or it holds fewer.
    fn read(&mut self, from: u64, octets: &mut [u8]) -> std::io::Result<()>;
    /// Puts octets there.
    ///
    /// # Errors
    /// If the system refuses.
    fn write(&mut self, at: u64, octets: &[u8]) -> std::io::Result<()>;
    /// Keeps the first ones only.
    ///
    /// # Errors
    /// If the system refuses.
    fn cut(&mut self, length: u64) -> std::io::Result<()>;
    /// All octets, from the first; to be read before the next one is written.
    ///
    /// # Errors
    /// If the system refuses.
    fn all(&self) -> std::io::Result<Box<dyn Read + Send>>;
    /// Nothing is kept any more.
    ///
    /// # Errors
    /// If the system refuses.
    fn remove(&self) -> std::io::Result<()>;
}

/// A file, by its name.
#[derive(Debug)]
struct OnDisk(PathBuf, File);

impl Disk for OnDisk {
    fn length(&self) -> std::io::Result<u64> {
        Ok(self.1.metadata()?.len())
    }

    fn read(&mut self, from: u64, octets: &mut [u8]) -> std::io::Result<()> {
        self.1.seek(SeekFrom::Start(from))?;
        self.1.read_exact(octets)
    }

    fn write(&mut self, at: u64, octets: &[u8]) -> std::io::Result<()> {
        self.1.seek(SeekFrom::Start(at))?;
        self.1.write_all(octets)
    }

    fn cut(&mut self, length: u64) -> std::io::Result<()> {
        self.1.set_len(length)
    }

    fn all(&self) -> std::io::Result<Box<dyn Read + Send>> {
        Ok(Box::new(BufReader::new(self.1.try_clone()?)))
    }

    fn remove(&self) -> std::io::Result<()> {
        std::fs::remove_file(&self.0)
    }
}

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    disk: Box<dyn Disk>,
    /// Where the next record begins.
    end: u64,
    /// Who may lead after what it holds.
    led: Led,
    /// The end of the record that says so.
    led_at: u64,
    /// There may be more behind it, which does not count.
    torn: bool,
}

/// What a journal holds of a station that died.
pub struct Past {
    /// The federation that it led.
    pub fed: u128,
    reader: Box<dyn Read + Send>,
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
        let (path, file) = opened(path, config)?;
        Self::on(Box::new(OnDisk(path.clone(), file)), &path, config, true)
    }

    /// As [`Journal::open`], of a disk that is called `path`; where nothing is to be begun it is the copy of another station's.
    ///
    /// # Errors
    /// If the disk cannot be used, or what it holds is of another run or build.
    pub fn on(
        disk: Box<dyn Disk>,
        path: &Path,
        config: &ConductorConfig,
        begin: bool,
    ) -> Result<(Self, Option<Past>), JournalError> {
        let (of, path) = (run_of(config), path.to_owned());
        let name = path.display().to_string();
        let refused = |error| JournalError::File { path: name.clone(), error };
        let another = |what| JournalError::Another { path: name.clone(), what };
        let empty = disk.length().map_err(refused)? == 0;
        let mut reader = disk.all().map_err(refused)?;
        let head = record(&mut reader);
        let mut journal = Self { path, disk, end: 0, led: Led::default(), led_at: 0, torn: true };
        match head {
            None if empty && !begin => Ok((journal, None)),
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

    /// As [`Journal::open`], for the journal of another station that is to be copied: nothing is begun.
    ///
    /// # Errors
    /// If the file cannot be used, belongs to another run or build, or another station writes it.
    pub fn open_copy(
        path: &Path,
        config: &ConductorConfig,
    ) -> Result<(Self, Option<Past>), JournalError> {
        let (path, file) = opened(path, config)?;
        Self::on(Box::new(OnDisk(path.clone(), file)), &path, config, false)
    }

    /// What is behind its first `end` octets does not count.
    pub fn cut(&mut self, end: u64, led: Led) {
        (self.end, self.led, self.torn) = (end, led, true);
    }

    /// Octets that it holds.
    #[must_use]
    pub fn end(&self) -> u64 {
        self.end
    }

    /// Who may lead after what it holds.
    #[must_use]
    pub fn led(&self) -> Led {
        self.led
    }

    /// The end of the record that says so, in octets.
    #[must_use]
    pub fn led_at(&self) -> u64 {
        self.led_at
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its octets from there on, at most so many.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn octets(&mut self, from: u64, most: u64) -> std::io::Result<Vec<u8>> {
        let mut octets = vec![0; self.end.saturating_sub(from).min(most) as usize];
        self.disk.read(from, &mut octets)?;
        Ok(octets)
    }

    /// The hash of its last octets before that one; none if it does not hold as many.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn sum(&mut self, before: u64) -> std::io::Result<Option<u64>> {
        if before > self.end {
            return Ok(None);
        }
        let from = before.saturating_sub(TAIL);
        Ok(Some(pdu_hash(&self.octets(from, before - from)?)))
    }

    /// Adds octets as they came from another station.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn copy(&mut self, octets: &[u8]) -> std::io::Result<()> {
        if std::mem::take(&mut self.torn) {
            self.disk.cut(self.end)?;
        }
        self.write(octets)
    }

    /// Adds who may lead from here on.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn append_led(&mut self, led: Led) -> std::io::Result<()> {
        if std::mem::take(&mut self.torn) {
            self.disk.cut(self.end)?;
        }
        self.led = led;
        let mut records = Vec::new();
        add(&mut records, &Line::Led(led))?;
        self.write(&records)?;
        self.led_at = self.end;
        Ok(())
    }

    /// Adds the steps of a conductor, a tick at the end; to be called before anybody hears what it decided.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn append(&mut self, steps: &[Step]) -> std::io::Result<()> {
        if std::mem::take(&mut self.torn) {
            self.disk.cut(self.end)?;
        }
        let mut records = Vec::new();
        for step in steps {
            add(&mut records, &Line::Step(Cow::Borrowed(step)))?;
        }
        self.write(&records)
    }

    fn write(&mut self, records: &[u8]) -> std::io::Result<()> {
        self.disk.write(self.end, records)?;
        self.end += records.len() as u64;
        Ok(())
    }

    /// The run is over, or nobody may go on from here: the file is removed.
    pub fn remove(self) {
        if let Err(e) = self.disk.remove() {
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
                    match record(&mut past.reader)? {
                        (Line::Step(step), length) => {
                            octets += length;
                            begun.push_back(step.into_owned());
                        }
                        (Line::Led(led), length) if begun.is_empty() => {
                            self.end += length;
                            (self.led, self.led_at) = (led, self.end);
                        }
                        _ => return None,
                    }
                }
                self.end += std::mem::take(&mut octets);
                whole = begun;
            }
        })
    }
}

/// Records of a journal that come in pieces.
#[derive(Debug, Default)]
pub struct Records {
    octets: Vec<u8>,
}

impl Records {
    /// The records that are whole now, each with its octets.
    pub fn take(&mut self, octets: &[u8]) -> Vec<(Line<'static>, u64)> {
        self.octets.extend_from_slice(octets);
        let (mut rest, mut lines, mut taken) = (&self.octets[..], Vec::new(), 0);
        while let Some((line, length)) = record(&mut rest) {
            taken += length as usize;
            lines.push((line, length));
        }
        self.octets.drain(..taken);
        lines
    }
}

/// A record of a journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Line<'a> {
    /// The first: of which run it is, and the federation.
    Head(Cow<'a, str>, u128),
    /// A step of the conductor.
    Step(Cow<'a, Step>),
    /// Who may lead from here on.
    Led(Led),
}

/// The file of the run that `config` describes, in a folder or by its name, locked.
fn opened(path: &Path, config: &ConductorConfig) -> Result<(PathBuf, File), JournalError> {
    let own = || path.join(format!("seeds-{:016x}.journal", pdu_hash(run_of(config).as_bytes())));
    let path = if path.is_dir() { own() } else { path.to_owned() };
    let name = || path.display().to_string();
    let refused = |error| JournalError::File { path: name(), error };
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    let file = options.open(&path).map_err(refused)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(JournalError::InUse(name())),
        Err(TryLockError::Error(error)) => return Err(refused(error)),
    }
    Ok((path, file))
}

/// What a journal is of: everything that a conductor is begun with, but for what is drawn.
#[must_use]
pub fn run_of(config: &ConductorConfig) -> String {
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
