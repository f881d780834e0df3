//! A finished run out of its database, scan by scan, as it was shown while it went on.
//!
//! Opening reads one row a scan; everything else is read when it is asked for. The frame of a scan is made by the
//! function that made it for the live page, from the report as it stands in the tables: the octets are the same.

mod about;
mod rows;

use super::frame::{self, Note, Noted, Trail};
use super::history::TRAIL;
use super::source::{self, CurvePoint, Event, ScanSums, Source};
use crate::runtime::messages::{PlotMessage, ScanReport};
use models::time::SimTime;
use rows::{Columns, Effect, plot, real, rows, track, truth};
use rusqlite::{Connection, OpenFlags, params};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Why a database cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    /// It is not one of SEEDS.
    #[error("{}: is not a database of a run of SEEDS", .0.display())]
    Stranger(PathBuf),
    /// A later version wrote it.
    #[error("{}: is of a later version of SEEDS (tables of version {found}, this one reads up to {}); open it with that one", path.display(), super::log::SCHEMA)]
    Newer {
        /// The file.
        path: PathBuf,
        /// Version of its tables.
        found: i64,
    },
    /// The database refused.
    #[error("{}: {}", path.display(), reason(source))]
    Database {
        /// The file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
}

fn reason(error: &rusqlite::Error) -> String {
    use rusqlite::ErrorCode as Code;
    match error.sqlite_error_code() {
        Some(Code::CannotOpen) => "cannot be opened: is there such a file?".to_owned(),
        Some(Code::NotADatabase) => "is not a database of a run of SEEDS".to_owned(),
        Some(Code::DatabaseCorrupt) => {
            "is damaged or was cut short; what SQLite can save of it: sqlite3 FILE .recover"
                .to_owned()
        }
        _ => error.to_string(),
    }
}

/// A database that is open for looking.
#[derive(Debug)]
pub struct Archive {
    path: PathBuf,
    database: Mutex<Connection>,
    columns: Columns,
    sums: Vec<ScanSums>,
    events: Vec<Event>,
    cache: Mutex<Cache>,
}

impl Archive {
    /// Opens the file and reads its list of scans.
    ///
    /// # Errors
    /// If it is not a log of SEEDS, of a later version, or damaged.
    pub fn open(path: &Path) -> Result<Self, ArchiveError> {
        let failed = |source| ArchiveError::Database { path: path.to_owned(), source };
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let database = Connection::open_with_flags(path, flags).map_err(failed)?;
        let pragma = |name| database.pragma_query_value(None, name, |r| r.get::<_, i64>(0));
        if pragma("application_id").map_err(failed)? != i64::from(super::log::APPLICATION_ID) {
            return Err(ArchiveError::Stranger(path.to_owned()));
        }
        let found = pragma("user_version").map_err(failed)?;
        if found > super::log::SCHEMA {
            return Err(ArchiveError::Newer { path: path.to_owned(), found });
        }
        database.pragma_update(None, "cache_size", -65_536).map_err(failed)?;
        let columns = Columns::of(&database).map_err(failed)?;
        let mut archive = Self {
            path: path.to_owned(),
            columns,
            sums: Vec::new(),
            events: Vec::new(),
            cache: Mutex::default(),
            database: Mutex::new(database),
        };
        archive.follow().map_err(failed)?;
        Ok(archive)
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes in what was written since: of a run that goes on. Whether there was anything.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn follow(&mut self) -> rusqlite::Result<bool> {
        let last = self.sums.last().map_or(-1, |s| s.scan as i64);
        let select = self.columns.select(
            "scans",
            &[
                "scan",
                "time_ns",
                "worst_error_m",
                "mean_error_m",
                "untracked",
                "false_tracks",
                "wrong_labels",
            ],
        );
        let (more, events) = {
            let database = self.database();
            let mut statement =
                database.prepare(&format!("{select} WHERE scan > ?1 ORDER BY scan"))?;
            let more = statement
                .query_map([last], |row| {
                    Ok(ScanSums {
                        scan: row.get::<_, i64>(0)? as u64,
                        time: SimTime(row.get(1)?),
                        worst_error_m: row.get(2)?,
                        mean_error_m: row.get(3)?,
                        untracked: row.get::<_, Option<u32>>(4)?.unwrap_or(0),
                        false_tracks: row.get::<_, Option<u32>>(5)?.unwrap_or(0),
                        wrong_labels: row.get::<_, Option<u32>>(6)?.unwrap_or(0),
                    })
                })?
                .collect::<rusqlite::Result<Vec<_>>>()?;
            if more.is_empty() && last >= 0 {
                return Ok(false);
            }
            let events = if self.columns.has("events", "kind") {
                let mut statement = database
                    .prepare("SELECT time_ns, kind, subject, text FROM events ORDER BY time_ns")?;
                statement
                    .query_map([], |row| {
                        Ok(Event {
                            time_ns: row.get(0)?,
                            kind: row.get(1)?,
                            subject: row.get(2)?,
                            text: row.get(3)?,
                        })
                    })?
                    .take(MOST_EVENTS)
                    .collect::<rusqlite::Result<Vec<_>>>()?
            } else {
                Vec::new()
            };
            (more, events)
        };
        self.sums.extend(more);
        self.events = events;
        Ok(true)
    }

    /// A figure of the run as a whole ("seed", "title", "map_json").
    #[must_use]
    pub fn fact(&self, name: &str) -> Option<String> {
        let question = "SELECT value FROM run WHERE name = ?1";
        self.database().query_row(question, [name], |row| row.get(0)).ok()
    }

    /// The report of one scan as the SMDFM gave it, its plan left out; none where there is no such scan.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn report(&self, scan: u64) -> rusqlite::Result<Option<ScanReport>> {
        let Some(at) = self.sums.binary_search_by_key(&scan, |s| s.scan).ok() else {
            return Ok(None);
        };
        let time_ns = self.sums[at].time.0;
        let database = self.database();
        let mut report = ScanReport { run: 1, scan, time_ns, ..ScanReport::default() };
        let number = scan as i64;
        report.took_us = database
            .prepare_cached("SELECT took_us FROM scans WHERE scan = ?1")?
            .query_row([number], |r| r.get::<_, Option<i64>>(0))?
            .unwrap_or(0) as u64;
        report.truth = rows(&database, &self.columns.truth, number, truth)?;
        report.tracks = rows(&database, &self.columns.tracks, number, |row| track(row, time_ns))?;
        report.plots = rows(&database, &self.columns.plots, number, plot)?;
        let mut effects: BTreeMap<(u16, u32), Vec<Effect>> = BTreeMap::new();
        let mut statement = database.prepare_cached(&self.columns.effects)?;
        let mut found = statement.query([number])?;
        while let Some(row) = found.next()? {
            let of = effects.entry((row.get(0)?, row.get(1)?)).or_default();
            of.push((row.get(2)?, real(row, 3)?, row.get(4)?));
        }
        for plot in &mut report.plots {
            plot.effects = effects.remove(&(plot.sensor, plot.sequence)).unwrap_or_default();
        }
        let mut statement =
            database.prepare_cached("SELECT name, value FROM statistics WHERE scan = ?1")?;
        report.measures = statement
            .query_map([number], |row| Ok((row.get(0)?, real(row, 1)?)))?
            .collect::<rusqlite::Result<_>>()?;
        Ok(Some(report))
    }

    fn database(&self) -> MutexGuard<'_, Connection> {
        self.database.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn trails(&self, at: usize) -> rusqlite::Result<Vec<Trail>> {
        let database = self.database();
        let scan = self.sums[at].scan as i64;
        let mut statement = database.prepare_cached("SELECT track FROM tracks WHERE scan = ?1")?;
        let mut trails: BTreeMap<u16, Vec<[f32; 2]>> = statement
            .query_map([scan], |row| Ok((row.get(0)?, Vec::new())))?
            .collect::<rusqlite::Result<_>>()?;
        let first = self.sums[at.saturating_sub(TRAIL)].scan as i64;
        let mut statement = database.prepare_cached(
            "SELECT track, x_m, y_m FROM tracks WHERE scan >= ?1 AND scan < ?2 ORDER BY scan DESC",
        )?;
        let mut found = statement.query([first, scan])?;
        while let Some(row) = found.next()? {
            if let Some(points) = trails.get_mut(&row.get(0)?) {
                points.push([real(row, 1)? as f32, real(row, 2)? as f32]);
            }
        }
        Ok(trails.into_iter().collect())
    }

    /// Positions of each track of a scan in those before it, newest first, m.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn trails_of(&self, scan: u64) -> rusqlite::Result<Vec<Trail>> {
        self.index_at(scan).map_or_else(|| Ok(Vec::new()), |at| self.trails(at))
    }

    fn index_at(&self, scan: u64) -> Option<usize> {
        if self.sums.is_empty() {
            return None;
        }
        Some(self.sums.partition_point(|s| s.scan <= scan).saturating_sub(1))
    }

    fn made(&self, at: usize) -> rusqlite::Result<Option<Vec<u8>>> {
        let Some(report) = self.report(self.sums[at].scan)? else { return Ok(None) };
        let noted = self.noted(report.scan)?;
        let octets = frame::encode_noted(&report, &noted);
        Ok(Some(frame::with_trails(&octets, false, &self.trails(at)?)))
    }

    /// What was noted of the tracks of a scan; nothing in databases of earlier versions.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn noted(&self, scan: u64) -> rusqlite::Result<Noted> {
        if !self.columns.has("track_notes", "doing") {
            return Ok(Noted::new());
        }
        let database = self.database();
        let mut statement = database.prepare_cached(
            "SELECT track, doing, derived, alert, cleared FROM track_notes WHERE scan = ?1",
        )?;
        let found = statement.query_map([scan as i64], |row| {
            let note = Note {
                doing: row.get(1)?,
                derived: row.get(2)?,
                alert: row.get(3)?,
                cleared: row.get(4)?,
            };
            Ok((row.get(0)?, note))
        })?;
        found.collect()
    }

    fn curve_of(&self, number: u16, from: u64, upto: u64) -> rusqlite::Result<Vec<CurvePoint>> {
        let database = self.database();
        let (from, upto) = (from.min(i64::MAX as u64) as i64, upto.min(i64::MAX as u64) as i64);
        let entity: Option<String> = database
            .prepare_cached(
                "SELECT entity FROM tracks WHERE track = ?1 AND scan <= ?2 AND entity IS NOT NULL \
                 ORDER BY scan DESC LIMIT 1",
            )?
            .query_row(params![number, upto], |row| row.get(0))
            .ok();
        let mut plots: BTreeMap<i64, BTreeMap<String, f32>> = BTreeMap::new();
        if let Some(entity) = &entity {
            let mut statement = database.prepare_cached(
                "SELECT scan, kind, error_m FROM plots WHERE cause = ?1 AND scan BETWEEN ?2 AND ?3 \
                 AND error_m IS NOT NULL",
            )?;
            let mut found = statement.query(params![entity, from, upto])?;
            while let Some(row) = found.next()? {
                let of = plots.entry(row.get(0)?).or_default();
                let error_m = row.get::<_, f64>(2)? as f32;
                let largest = of.entry(row.get(1)?).or_insert(error_m);
                *largest = largest.max(error_m);
            }
        }
        let mut statement = database.prepare_cached(
            "SELECT scan, entity, error_m, var_ee_m2, var_nn_m2 FROM tracks \
             WHERE track = ?1 AND scan BETWEEN ?2 AND ?3 ORDER BY scan",
        )?;
        let mut found = statement.query(params![number, from, upto])?;
        let mut points = Vec::new();
        while let Some(row) = found.next()? {
            let (scan, of): (i64, Option<String>) = (row.get(0)?, row.get(1)?);
            if entity.is_some() && of.is_some() && of != entity {
                continue;
            }
            let Ok(at) = self.sums.binary_search_by_key(&(scan as u64), |s| s.scan) else {
                continue;
            };
            points.push(CurvePoint {
                scan: scan as u64,
                time_s: self.sums[at].time.s(),
                error_m: row.get::<_, Option<f64>>(2)?.map(|e| e as f32),
                claimed_m: (real(row, 3)? + real(row, 4)?).sqrt() as f32,
                plots_m: plots.remove(&scan).unwrap_or_default(),
            });
        }
        Ok(points)
    }

    fn effects_of(&self, number: u16, scan: u64) -> rusqlite::Result<Vec<String>> {
        let Some(report) = self.report(scan)? else { return Ok(Vec::new()) };
        let pairs = frame::pairs(&report);
        let entity = pairs.get(&number).map(|p| report.truth[p.0].callsign.clone());
        let of_it = |p: &&PlotMessage| {
            p.track == Some(number)
                || entity.as_ref().is_some_and(|e| !e.is_empty() && p.cause == *e)
        };
        let told = report.plots.iter().filter(|p| !p.effects.is_empty()).filter(of_it).map(|p| {
            json!({
                "sensor": p.sensor, "kind": p.kind.word, "time_s": SimTime(p.time_ns).s(),
                "scnr_db": p.scnr_db, "error_m": frame::plot_error_m(p), "track": p.track,
                "effects": p.effects,
            })
            .to_string()
        });
        Ok(told.collect())
    }

    /// What the database refuses while somebody looks is said in the log; the page goes on with what it has.
    fn or_empty<T: Default>(&self, read: rusqlite::Result<T>) -> T {
        read.unwrap_or_else(|error| {
            tracing::warn!("{}: {}", self.path.display(), reason(&error));
            T::default()
        })
    }
}

impl Source for Archive {
    fn range(&self) -> Option<(u64, u64)> {
        Some((self.sums.first()?.scan, self.sums.last()?.scan))
    }

    fn times(&self) -> Option<(SimTime, SimTime)> {
        Some((self.sums.first()?.time, self.sums.last()?.time))
    }

    fn nearest(&self, scan: u64) -> Option<u64> {
        Some(self.sums.get(self.index_at(scan)?)?.scan)
    }

    fn at(&self, time: SimTime) -> Option<u64> {
        source::at(&self.sums, time)
    }

    fn time_of(&self, scan: u64) -> Option<SimTime> {
        let at = self.sums.binary_search_by_key(&scan, |s| s.scan).ok()?;
        Some(self.sums[at].time)
    }

    fn message(&self, scan: u64) -> Option<Vec<u8>> {
        let at = self.index_at(scan)?;
        let number = self.sums[at].scan;
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let octets = match cache.get(number) {
            Some(octets) => octets,
            None => {
                let octets: Arc<[u8]> = self.or_empty(self.made(at))?.into();
                cache.keep(number, Arc::clone(&octets));
                octets
            }
        };
        let mut message = octets.to_vec();
        message[5] |= u8::from(at + 1 == self.sums.len());
        Some(message)
    }

    fn curve(&self, number: u16, from: u64, upto: u64) -> Vec<CurvePoint> {
        self.or_empty(self.curve_of(number, from, upto))
    }

    fn effects(&self, number: u16, scan: u64) -> Vec<String> {
        self.nearest(scan)
            .map_or_else(Vec::new, |scan| self.or_empty(self.effects_of(number, scan)))
    }

    fn sums(&self) -> &[ScanSums] {
        &self.sums
    }

    fn events(&self) -> &[Event] {
        &self.events
    }
}

/// Frames that were made, the ones longest unused dropped first.
#[derive(Debug, Default)]
struct Cache {
    kept: BTreeMap<u64, (u64, Arc<[u8]>)>, // by scan: when it was last used
    used: BTreeMap<u64, u64>,              // by that: the scan
    clock: u64,
    octets: usize,
}

impl Cache {
    fn get(&mut self, scan: u64) -> Option<Arc<[u8]>> {
        let (when, octets) = self.kept.get_mut(&scan)?;
        self.used.remove(when);
        self.clock += 1;
        *when = self.clock;
        self.used.insert(self.clock, scan);
        Some(Arc::clone(octets))
    }

    fn keep(&mut self, scan: u64, octets: Arc<[u8]>) {
        self.clock += 1;
        self.octets += octets.len();
        self.used.insert(self.clock, scan);
        self.kept.insert(scan, (self.clock, octets));
        while self.octets > CACHE_OCTETS || self.kept.len() > CACHE_FRAMES {
            let Some((_, oldest)) = self.used.pop_first() else { break };
            self.octets -= self.kept.remove(&oldest).map_or(0, |(_, octets)| octets.len());
        }
    }
}

/// Frames kept in memory, octets and number.
const CACHE_OCTETS: usize = 256 << 20;
const CACHE_FRAMES: usize = 4096;
/// Rows of small tables and events that are read, at most.
const MOST_ROWS: usize = 100_000;
const MOST_EVENTS: usize = 20_000;

#[cfg(test)]
mod tests;
