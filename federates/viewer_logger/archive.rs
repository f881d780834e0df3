//! A finished run out of its database, scan by scan, as it was shown while it went on.
//!
//! Opening reads one row a scan; everything else is read when it is asked for. The frame of a scan is made by the
//! function that made it for the live page, from the report as it stands in the tables: the octets are the same.

use super::frame::{self, Trail};
use super::history::TRAIL;
use super::said::{AlertRow, Said, Topic};
use super::source::{self, CurvePoint, Event, ScanSums, Source};
use crate::runtime::messages::{
    FlightNotice, LagMessage, Operation, PlotMessage, ScanReport, TrackMessage, TruthMessage,
    WeatherNotice,
};
use models::time::SimTime;
use rusqlite::{Connection, OpenFlags, Row, params};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
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

    /// The weather notices of the run, in the order of time.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn weather(&self) -> rusqlite::Result<Vec<WeatherNotice>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM weather ORDER BY time_ns")?;
        let found = statement.query_map([], |row| {
            let cells: String = row.get("cells_json")?;
            Ok(WeatherNotice {
                from_ns: row.get("time_ns")?,
                rain_mm_per_h: row.get("rain_mm_per_h")?,
                visibility_m: row.get::<_, Option<f64>>("visibility_m")?.unwrap_or(f64::INFINITY),
                temperature_k: row.get::<_, f64>("temperature_c")? + 273.15,
                pressure_hpa: row.get("pressure_hpa")?,
                vapour_g_per_m3: row.get("vapour_g_per_m3")?,
                wind_mps: [row.get("wind_east_ms")?, row.get("wind_north_ms")?],
                film_mm: row.get("film_mm")?,
                cells: serde_json::from_str(&cells).unwrap_or_default(),
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// The flight list as it stood last.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn flights(&self) -> rusqlite::Result<Vec<FlightNotice>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM flights")?;
        let found = statement.query_map([], |row| {
            let address: Option<String> = row.get("address")?;
            let routing: Option<String> = row.get("routing")?;
            let ns = |s: f64| (s * 1e9).round() as i64;
            Ok(FlightNotice {
                callsign: row.get("callsign")?,
                address: address.and_then(|a| u32::from_str_radix(&a, 16).ok()),
                type_designator: row.get("type")?,
                wake: row.get("wake")?,
                movement: row.get("movement")?,
                runway: row.get("runway")?,
                stand: row.get("stand")?,
                stand_m: None,
                eta_ctd_ns: ns(row.get("eta_ctd_s")?),
                off_block_ns: row.get::<_, Option<f64>>("off_block_s")?.map(ns),
                routing: routing
                    .unwrap_or_default()
                    .split_whitespace()
                    .map(str::to_owned)
                    .collect(),
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// What operators did.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn operations(&self) -> rusqlite::Result<Vec<Operation>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM operations ORDER BY wall_utc_ns")?;
        let found = statement.query_map([], |row| {
            Ok(Operation {
                frame: row.get::<_, i64>("frame")? as u64,
                time_ns: row.get("time_ns")?,
                source: row.get("source")?,
                command: row.get("command")?,
                ok: row.get("done")?,
                text: row.get("answer")?,
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// Name and octets of the scene's text and of its files.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn files(&self) -> rusqlite::Result<Vec<(String, Vec<u8>)>> {
        if !self.columns.has("files", "octets") {
            return Ok(Vec::new());
        }
        let database = self.database();
        let mut statement = database.prepare("SELECT name, octets FROM files")?;
        let found = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        found.take(MOST_ROWS).collect()
    }

    /// What was said of a topic last, as of a time; `i64::MAX`: at the end.
    #[must_use]
    pub fn said(&self, topic: Topic, time_ns: i64) -> Option<Arc<str>> {
        if !self.columns.has("said", "octets") {
            return None;
        }
        let read = |database: &Connection| {
            database
                .prepare_cached(
                    "SELECT time_ns, octets FROM said WHERE topic = ?1 AND time_ns <= ?2 \
                     ORDER BY time_ns DESC LIMIT 1",
                )?
                .query_map(params![topic.word(), time_ns], |row| {
                    Ok((row.get::<_, i64>(0)?, row.get::<_, Vec<u8>>(1)?))
                })?
                .next()
                .transpose()
        };
        let (said_ns, octets) = self.or_empty(read(&self.database()))?;
        let holds = time_ns == i64::MAX || time_ns.saturating_sub(said_ns) <= topic.holds_ns();
        inflated(&octets).filter(|_| holds).map(Arc::from)
    }

    /// The alerts of the run, with who acknowledged them.
    #[must_use]
    pub fn alerts(&self) -> Said {
        let mut said = Said::default();
        if !self.columns.has("alerts", "id") {
            return said;
        }
        let read = |database: &Connection| {
            let question = "SELECT id, kind, subjects, time_ns, stage, end_ns, place_x_m, place_y_m \
                 FROM alerts ORDER BY id, time_ns";
            let mut statement = database.prepare_cached(question)?;
            let found = statement.query_map([], |row| {
                let alert = AlertRow {
                    kind: row.get(1)?,
                    subjects: row.get(2)?,
                    stages: vec![(row.get(3)?, row.get(4)?)],
                    end_ns: row.get(5)?,
                    place_m: [real(row, 6)?, real(row, 7)?],
                    acknowledged: None,
                };
                Ok((row.get(0)?, alert))
            })?;
            found.take(MOST_ROWS).collect::<rusqlite::Result<Vec<(u32, AlertRow)>>>()
        };
        for (id, row) in self.or_empty(read(&self.database())) {
            said.row(id, row);
        }
        for operation in self.or_empty(self.operations()) {
            said.operation(&operation);
        }
        said
    }

    /// Time of the last scan, s.
    #[must_use]
    pub fn sums_end_s(&self) -> Option<f64> {
        self.sums.last().map(|s| s.time.s())
    }

    /// The effect plan: the rows that stood at the end.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn plan(&self) -> rusqlite::Result<Vec<[String; 5]>> {
        let database = self.database();
        let question = "SELECT sensor, effect, called_for_by, bound, decision, max(scan) FROM plan \
             GROUP BY sensor, effect ORDER BY rowid";
        let mut statement = database.prepare(question)?;
        let found = statement.query_map([], |row| {
            Ok([row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?])
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// Number, name, kind and site of each sensor.
    pub(super) fn sensors(&self) -> rusqlite::Result<Vec<SensorRow>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT sensor, name, kind, x_m, y_m FROM sensors")?;
        let found = statement.query_map([], |row| {
            let at: (Option<f64>, Option<f64>) = (row.get(3)?, row.get(4)?);
            Ok((row.get(0)?, row.get(1)?, row.get(2)?, at.0.zip(at.1).map(|(x, y)| [x, y])))
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// West, south, east and north end of the truth, m.
    pub(super) fn bounds(&self) -> rusqlite::Result<Option<[f64; 4]>> {
        let question = "SELECT min(x_m), min(y_m), max(x_m), max(y_m) FROM truth";
        self.database().query_row(question, [], |row| {
            let ends =
                (0..4).map(|i| row.get::<_, Option<f64>>(i)).collect::<Result<Vec<_>, _>>()?;
            Ok(match ends[..] {
                [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
                _ => None,
            })
        })
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
        Ok(Some(frame::with_trails(&frame::encode(&report), false, &self.trails(at)?)))
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
                "sensor": p.sensor, "kind": p.kind, "time_s": SimTime(p.time_ns).s(),
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

/// The questions for the tables of this file: what an earlier version did not write is asked for as NULL.
#[derive(Debug)]
struct Columns {
    known: BTreeMap<String, BTreeSet<String>>,
    truth: String,
    tracks: String,
    plots: String,
    effects: String,
}

impl Columns {
    fn of(database: &Connection) -> rusqlite::Result<Self> {
        let mut statement = database.prepare(
            "SELECT m.name, c.name FROM sqlite_master m, pragma_table_info(m.name) c WHERE m.type = 'table'",
        )?;
        let mut known: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let mut found = statement.query([])?;
        while let Some(row) = found.next()? {
            known.entry(row.get(0)?).or_default().insert(row.get(1)?);
        }
        let mut columns = Self {
            known,
            truth: String::new(),
            tracks: String::new(),
            plots: String::new(),
            effects: String::new(),
        };
        let of_scan = |columns: &Self, table: &str, names: &[&str], key: &str| {
            let order = if columns.has(table, "place") { "place" } else { key };
            format!("{} WHERE scan = ?1 ORDER BY {order}", columns.select(table, names))
        };
        columns.truth = of_scan(&columns, "truth", &TRUTH, "entity");
        columns.tracks = of_scan(&columns, "tracks", &TRACKS, "track");
        columns.plots = of_scan(&columns, "plots", &PLOTS, "sensor, sequence");
        columns.effects = of_scan(&columns, "plot_effects", &EFFECTS, "sensor, sequence");
        Ok(columns)
    }

    fn has(&self, table: &str, column: &str) -> bool {
        self.known.get(table).is_some_and(|columns| columns.contains(column))
    }

    fn select(&self, table: &str, names: &[&str]) -> String {
        let named = |name: &&str| {
            if self.has(table, name) { (*name).to_owned() } else { format!("NULL AS {name}") }
        };
        let list: Vec<String> = names.iter().map(named).collect();
        format!("SELECT {} FROM {table}", list.join(", "))
    }
}

const TRUTH: [&str; 17] = [
    "entity",
    "callsign",
    "type",
    "x_m",
    "y_m",
    "altitude_m",
    "vx_ms",
    "vy_ms",
    "vz_ms",
    "heading_rad",
    "heading_deg",
    "length_m",
    "span_m",
    "aircraft",
    "ours",
    "track",
    "track_error_m",
];

fn truth(row: &Row<'_>) -> rusqlite::Result<TruthMessage> {
    let entity = row.get::<_, i64>(0)? as u64;
    let track: Option<u16> = row.get(15)?;
    let error_m = real(row, 16)?;
    Ok(TruthMessage {
        id: [(entity >> 32) as u16, (entity >> 16) as u16, entity as u16],
        callsign: words(row, 1)?,
        type_designator: words(row, 2)?,
        position_m: [real(row, 3)?, real(row, 4)?, real(row, 5)?],
        velocity_mps: [real(row, 6)?, real(row, 7)?, row.get::<_, Option<f64>>(8)?.unwrap_or(0.0)],
        heading_rad: angle(row, 9)?,
        // What the first version of the tables did not keep: an aircraft of no known size.
        size_m: [
            row.get::<_, Option<f64>>(11)?.unwrap_or(0.0),
            row.get::<_, Option<f64>>(12)?.unwrap_or(0.0),
        ],
        aircraft: row.get::<_, Option<bool>>(13)?.unwrap_or(true),
        ours: row.get::<_, Option<bool>>(14)?.unwrap_or(true),
        track: track.map(|number| (number, error_m)),
    })
}

const TRACKS: [&str; 41] = [
    "track",
    "status",
    "type",
    "callsign",
    "x_m",
    "y_m",
    "vx_ms",
    "vy_ms",
    "heading_rad",
    "heading_deg",
    "altitude_m",
    "var_ee_m2",
    "var_en_m2",
    "var_nn_m2",
    "manoeuvre",
    "lag_time_ns",
    "lag_x_m",
    "lag_y_m",
    "lag_var_ee_m2",
    "lag_var_en_m2",
    "lag_var_nn_m2",
    "lag_coasted",
    "lag_error_m",
    "assumed",
    "label_p",
    "estimate_ns",
    "first",
    "designator",
    "wake",
    "movement",
    "runway_stand",
    "routing",
    "ctd_eta_ns",
    "ax_ms2",
    "ay_ms2",
    "vvar_ee",
    "vvar_en",
    "vvar_nn",
    "entity",
    "error_m",
    "speed_ms",
];

fn track(row: &Row<'_>, scan_time_ns: i64) -> rusqlite::Result<TrackMessage> {
    let lag_time: Option<i64> = row.get(15)?;
    let lag = match lag_time {
        Some(time_ns) => Some(LagMessage {
            time_ns,
            position_m: [real(row, 16)?, real(row, 17)?],
            cov_m2: [real(row, 18)?, real(row, 19)?, real(row, 20)?],
            coasted: row.get::<_, Option<bool>>(21)?.unwrap_or(false),
            error_m: row.get(22)?,
        }),
        None => None,
    };
    Ok(TrackMessage {
        number: row.get(0)?,
        status: words(row, 1)?,
        track_type: words(row, 2)?,
        callsign: words(row, 3)?,
        position_m: [real(row, 4)?, real(row, 5)?],
        velocity_mps: [real(row, 6)?, real(row, 7)?],
        heading_rad: angle(row, 8)?,
        altitude_m: row.get(10)?,
        cov_m2: [real(row, 11)?, real(row, 12)?, real(row, 13)?],
        manoeuvre: row.get::<_, Option<bool>>(14)?.unwrap_or(false),
        lag,
        assumed: words(row, 23)?,
        label_p: row.get(24)?,
        time_ns: row.get::<_, Option<i64>>(25)?.unwrap_or(scan_time_ns),
        first: row.get::<_, Option<bool>>(26)?.unwrap_or(false),
        type_designator: words(row, 27)?,
        wake: words(row, 28)?,
        movement: words(row, 29)?,
        runway_stand: words(row, 30)?,
        routing: words(row, 31)?.split_whitespace().map(str::to_owned).collect(),
        ctd_eta_ns: row.get(32)?,
        acceleration_ms2: [real(row, 33)?, real(row, 34)?],
        velocity_cov_m2s2: [real(row, 35)?, real(row, 36)?, real(row, 37)?],
    })
}

const PLOTS: [&str; 28] = [
    "sensor",
    "sequence",
    "kind",
    "time_ns",
    "x_m",
    "y_m",
    "var_ee_m2",
    "var_en_m2",
    "var_nn_m2",
    "range_m",
    "azimuth_rad",
    "azimuth_deg",
    "scnr_db",
    "identity",
    "track",
    "cause",
    "truth_x_m",
    "truth_y_m",
    "axis_e",
    "axis_n",
    "along_m2",
    "across_m2",
    "altitude_m",
    "sigma_range_m",
    "sigma_azimuth_rad",
    "error_m",
    "scan",
    "sensor",
];

fn plot(row: &Row<'_>) -> rusqlite::Result<PlotMessage> {
    let range: Option<f64> = row.get(9)?;
    let polar = match range {
        Some(range_m) => Some([range_m, angle(row, 10)?, real(row, 23)?, real(row, 24)?]),
        None => None,
    };
    let truth: (Option<f64>, Option<f64>) = (row.get(16)?, row.get(17)?);
    Ok(PlotMessage {
        sensor: row.get(0)?,
        sequence: row.get(1)?,
        kind: words(row, 2)?,
        time_ns: row.get(3)?,
        position_m: [real(row, 4)?, real(row, 5)?],
        cov_m2: [real(row, 6)?, real(row, 7)?, real(row, 8)?],
        polar,
        scnr_db: row.get(12)?,
        identity: words(row, 13)?,
        track: row.get(14)?,
        cause: words(row, 15)?,
        truth_m: truth.0.zip(truth.1).map(|(x, y)| [x, y]),
        ellipse: [real(row, 18)?, real(row, 19)?, real(row, 20)?, real(row, 21)?],
        altitude_m: row.get(22)?,
        velocity_mps: None, // of no frame
        effects: Vec::new(),
    })
}

/// Name, value and unit.
type Effect = (String, f64, String);
/// Number, name, kind and site, m.
type SensorRow = (u16, String, String, Option<[f64; 2]>);

const EFFECTS: [&str; 5] = ["sensor", "sequence", "effect", "value", "unit"];

fn rows<T>(
    database: &Connection,
    question: &str,
    scan: i64,
    read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
) -> rusqlite::Result<Vec<T>> {
    database.prepare_cached(question)?.query_map([scan], read)?.collect()
}

/// A text out of the table `said`; none where it is damaged or longer than any that is written.
fn inflated(octets: &[u8]) -> Option<String> {
    use std::io::Read as _;
    let mut text = String::new();
    let decoder = flate2::read::ZlibDecoder::new(octets).take(MOST_TEXT);
    std::io::BufReader::new(decoder).read_to_string(&mut text).ok()?;
    Some(text)
}

/// A figure; NULL is what was not a number.
fn real(row: &Row<'_>, at: usize) -> rusqlite::Result<f64> {
    Ok(row.get::<_, Option<f64>>(at)?.unwrap_or(f64::NAN))
}

fn words(row: &Row<'_>, at: usize) -> rusqlite::Result<String> {
    Ok(row.get::<_, Option<String>>(at)?.unwrap_or_default())
}

/// An angle in radians, or out of the column of degrees behind it, where an earlier version wrote only that.
fn angle(row: &Row<'_>, at: usize) -> rusqlite::Result<f64> {
    Ok(match row.get::<_, Option<f64>>(at)? {
        Some(rad) => rad,
        None => real(row, at + 1)?.to_radians(),
    })
}

/// Frames kept in memory, octets and number.
const CACHE_OCTETS: usize = 256 << 20;
const CACHE_FRAMES: usize = 4096;
/// Longest text that is read, octets.
const MOST_TEXT: u64 = 8 << 20;
/// Rows of small tables and events that are read, at most.
const MOST_ROWS: usize = 100_000;
const MOST_EVENTS: usize = 20_000;

#[cfg(test)]
mod tests;
