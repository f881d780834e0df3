//! The database of a run: one SQLite file that a person can query while the run goes on and afterwards.
//!
//! Everything of a scan is one transaction, so a scan is there as a whole or not at all. The first failure (a
//! full disk) is reported once and ends the log; what was written stays sound, and the run goes on.

mod scan;

use super::frame::Noted;
use super::picture::{AirportMap, RunInfo};
use super::said::{self, Topic};
use super::source::{Event, EventFinder};
use crate::runtime::messages::{
    FederateStatus, FlightNotice, ForeignReport, Operation, RunState, ScanReport, WeatherNotice,
};
use models::traffic::core::LAMP_DELAY_S;
use models::words::Word;
use rusqlite::{Connection, OpenFlags, Transaction, params};
use scan::{write_notes, write_scan};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Why a log cannot be opened or went no further.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file is there already; a log is never overwritten.
    #[error("log {}: exists already; name another directory", .0.display())]
    Exists(PathBuf),
    /// Another file stands where the log of an earlier run would be replaced.
    #[error("log {}: is there already and is not a log of SEEDS; name another file", .0.display())]
    Stranger(PathBuf),
    /// Another run writes the log that would be replaced.
    #[error("log {}: another run is writing it; name another directory, or wait for its end", .0.display())]
    InUse(PathBuf),
    /// The database refused.
    #[error("log {}: {}", path.display(), explain(why))]
    Database {
        /// The file.
        path: PathBuf,
        /// What SQLite says; it stands in the sentence, and is no further cause.
        why: rusqlite::Error,
    },
}

/// An open log. After a failure it takes everything and writes nothing.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    database: Option<Connection>,
    scans: u64,
    scans_lost: u64,
    events: EventFinder,
    /// The weather as the time line told it last: the same again is no event.
    weather_told: Option<WeatherNotice>,
    /// The effect plan of the last scan: a row that stands on is not written again.
    plan: Vec<[String; 5]>,
    /// Keeps other runs from replacing the file.
    _written: Option<std::fs::File>,
}

impl Log {
    /// Creates the file with its tables and says which run it is.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: &Path, run: &RunInfo, map: &AirportMap) -> Result<Self, LogError> {
        if path.exists() {
            return Err(LogError::Exists(path.to_owned()));
        }
        let failed = |why| LogError::Database { path: path.to_owned(), why };
        let mut database = Connection::open(path).map_err(failed)?;
        begin(&mut database, run, map).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            _written: held(path),
            database: Some(database),
            scans: 0,
            scans_lost: 0,
            events: EventFinder::default(),
            weather_told: None,
            plan: Vec::new(),
        })
    }

    /// As [`Self::create`], in place of the log of an earlier run, if there is one.
    ///
    /// # Errors
    /// As [`Self::create`]; a file that is no log is left alone.
    pub fn replace(path: &Path, run: &RunInfo, map: &AirportMap) -> Result<Self, LogError> {
        if path.exists() {
            let id = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)
                .and_then(|old| old.pragma_query_value(None, "application_id", |r| r.get(0)));
            if !matches!(id, Ok(APPLICATION_ID)) {
                return Err(LogError::Stranger(path.to_owned()));
            }
            if is_written(path) {
                return Err(LogError::InUse(path.to_owned()));
            }
            for ending in ["", "-wal", "-shm"] {
                let mut name = path.as_os_str().to_owned();
                name.push(ending);
                std::fs::remove_file(name).ok(); // what cannot be removed is met again by `create`
            }
        }
        Self::create(path, run, map)
    }

    /// Writes one scan: truth, plots with what the effects did to them, tracks, measures.
    ///
    /// # Errors
    /// Once, when the database refuses; afterwards nothing is written and nothing is reported.
    pub fn scan(&mut self, scan: &ScanReport) -> Result<(), LogError> {
        self.scan_noted(scan, &Noted::new())
    }

    /// The same with what is noted of its tracks.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn scan_noted(&mut self, scan: &ScanReport, noted: &Noted) -> Result<(), LogError> {
        let events = self.events.scan(scan);
        let before: BTreeSet<_> = self.plan.iter().collect();
        let plan: Vec<_> = scan.plan.iter().filter(|row| !before.contains(row)).collect();
        let done = self.write(|t| {
            write_scan(t, scan, &plan)?;
            write_notes(t, scan.scan, noted)?;
            write_events(t, &events)
        });
        self.plan.clone_from(&scan.plan);
        let written = done.is_ok() && self.database.is_some();
        *(if written { &mut self.scans } else { &mut self.scans_lost }) += 1;
        done
    }

    /// Writes a change of the weather; what is told again is written once.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn weather(&mut self, w: &WeatherNotice) -> Result<(), LogError> {
        if self.weather_told.as_ref() == Some(w) {
            return Ok(());
        }
        let cells = serde_json::json!(w.cells).to_string();
        let event = weather_event(w);
        let told =
            self.weather_told.as_ref().is_some_and(|last| weather_event(last).text == event.text);
        self.weather_told = Some(w.clone());
        self.write(|t| {
            if !told {
                write_events(t, std::slice::from_ref(&event))?;
            }
            t.prepare_cached("INSERT INTO weather VALUES (?,?,?,?,?,?,?,?,?,?)")?.execute(
                params![
                    w.from_ns,
                    w.rain_mm_per_h,
                    w.visibility_m.is_finite().then_some(w.visibility_m),
                    w.temperature_k - 273.15,
                    w.pressure_hpa,
                    w.vapour_g_per_m3,
                    w.wind_mps[0],
                    w.wind_mps[1],
                    w.film_mm,
                    cells
                ],
            )?;
            Ok(())
        })
    }

    /// Writes the flight list in place of the one before.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn flights(&mut self, entries: &[FlightNotice]) -> Result<(), LogError> {
        self.write(|t| {
            t.execute("DELETE FROM flights", [])?;
            let mut insert =
                t.prepare_cached("INSERT INTO flights VALUES (?,?,?,?,?,?,?,?,?,?)")?;
            for e in entries {
                insert.execute(params![
                    e.callsign,
                    e.address.map(|a| format!("{a:06x}")),
                    e.type_designator,
                    said(e.wake),
                    e.movement.word(),
                    e.runway,
                    e.stand,
                    e.eta_ctd_ns as f64 * 1e-9,
                    e.off_block_ns.map(|ns| ns as f64 * 1e-9),
                    e.routing.join(" ")
                ])?;
            }
            Ok(())
        })
    }

    /// Writes tracks of somebody else's tracker.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn foreign(&mut self, reports: &[ForeignReport]) -> Result<(), LogError> {
        self.write(|t| {
            let mut insert =
                t.prepare_cached("INSERT INTO foreign_tracks VALUES (?,?,?,?,?,?,?,?,?,?,?)")?;
            for r in reports {
                insert.execute(params![
                    r.source,
                    r.track,
                    r.time_ns,
                    r.position_m[0],
                    r.position_m[1],
                    r.velocity_mps.map(|v| v[0]),
                    r.velocity_mps.map(|v| v[1]),
                    r.callsign,
                    r.coasting,
                    r.last,
                    r.received_ns
                ])?;
            }
            Ok(())
        })
    }

    /// Writes what was said of a topic as JSON; what does not say its time is left out.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn said(&mut self, topic: Topic, text: &str) -> Result<(), LogError> {
        let Some(time_ns) = said::time_of(text).filter(|t| topic.is_kept(*t)) else {
            return Ok(());
        };
        let octets = deflated(text);
        self.write(|t| {
            t.prepare_cached("INSERT OR REPLACE INTO said VALUES (?,?,?)")?.execute(params![
                topic.word(),
                time_ns,
                octets
            ])?;
            if topic == Topic::Traffic
                && let Some(lit) = said::greens_of(text)
            {
                // Those that are not said to be lit any more are dark; lamps show what they are told a moment later.
                let mut known = t.prepare_cached(
                    "SELECT id FROM lights l WHERE id LIKE 'green %' AND state = 'lit' AND NOT EXISTS \
                     (SELECT 1 FROM lights WHERE id = l.id AND rowid > l.rowid)",
                )?;
                let known = known.query_map([], |row| row.get(0))?;
                let known: BTreeSet<String> = known.collect::<Result<_, _>>()?;
                let lit: BTreeSet<String> = lit.iter().map(|n| format!("green {n}")).collect();
                let at_ns = time_ns + (1e9 * LAMP_DELAY_S) as i64;
                let mut insert = t.prepare_cached("INSERT INTO lights VALUES (?,?,?)")?;
                for id in known.difference(&lit) {
                    insert.execute(params![at_ns, id, "dark"])?;
                }
                for id in lit.difference(&known) {
                    insert.execute(params![at_ns, id, "lit"])?;
                }
            }
            if topic == Topic::Lights {
                for (id, state) in said::lights_of(text) {
                    t.prepare_cached(
                        "INSERT INTO lights SELECT ?1, ?2, ?3 WHERE ?3 IS NOT \
                         (SELECT state FROM lights WHERE id = ?2 ORDER BY time_ns DESC, rowid DESC LIMIT 1)",
                    )?
                    .execute(params![time_ns, id, state])?;
                }
            }
            Ok(())
        })
    }

    /// Writes an operator's action with its answer.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn operation(&mut self, o: &Operation, wall_utc_ns: i64) -> Result<(), LogError> {
        self.write(|t| {
            t.prepare_cached("INSERT INTO operations VALUES (?,?,?,?,?,?,?)")?.execute(params![
                wall_utc_ns,
                o.time_ns,
                o.frame as i64,
                o.source,
                o.command,
                o.ok,
                o.text
            ])?;
            write_events(t, &[operation_event(o)])
        })
    }

    /// Writes a change of the run's state.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn state(&mut self, s: &RunState, wall_utc_ns: i64) -> Result<(), LogError> {
        self.write(|t| {
            t.prepare_cached("INSERT INTO states VALUES (?,?,?,?,?,?,?)")?.execute(params![
                wall_utc_ns,
                s.run,
                s.frame as i64,
                s.phase.to_string(),
                s.rate.is_finite().then_some(s.rate),
                s.achieved_rate,
                s.reasons.join("; ")
            ])?;
            Ok(())
        })
    }

    /// Writes what the time line is to mark beside what is written of scans.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn events(&mut self, events: &[Event]) -> Result<(), LogError> {
        if events.is_empty() { Ok(()) } else { self.write(|t| write_events(t, events)) }
    }

    /// Writes the statistics of one federate.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn federate(
        &mut self,
        f: &FederateStatus,
        latency_us: Option<f64>,
        wall_utc_ns: i64,
    ) -> Result<(), LogError> {
        let dropped: u64 = f.dropped.iter().map(|d| d.1).sum();
        self.write(|t| {
            t.prepare_cached("INSERT INTO federates VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)")?
                .execute(params![
                    wall_utc_ns,
                    f.name,
                    f.host,
                    f.pid,
                    f.frame as i64,
                    f.cpu_s,
                    f.cpu_pct,
                    f.rss_bytes as i64,
                    f.pdus_in as i64,
                    f.pdus_out as i64,
                    f.lost as i64,
                    f.repaired as i64,
                    dropped as i64,
                    f.exec_us,
                    latency_us
                ])?;
            Ok(())
        })
    }

    /// Writes something that the time line marks.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn event(&mut self, event: &Event) -> Result<(), LogError> {
        self.write(|t| write_events(t, std::slice::from_ref(event)))
    }

    /// Keeps a file that the scene is made of.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn file(&mut self, name: &str, octets: &[u8]) -> Result<(), LogError> {
        self.write(|t| {
            t.execute("INSERT OR REPLACE INTO files VALUES (?,?)", params![name, octets])?;
            Ok(())
        })
    }

    /// Writes one figure of the run as a whole ("digest", "datagrams recorded").
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn fact(&mut self, name: &str, value: &str) -> Result<(), LogError> {
        self.write(|t| fact(t, name, value))
    }

    /// Scans written, and scans lost after a failure.
    #[must_use]
    pub fn scans(&self) -> (u64, u64) {
        (self.scans, self.scans_lost)
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Folds the write-ahead log into the file, so that one file remains.
    ///
    /// # Errors
    /// If that cannot be written; the database is sound all the same.
    pub fn close(mut self) -> Result<(), LogError> {
        let Some(database) = self.database.take() else { return Ok(()) };
        let fold = |db: &Connection| {
            db.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()))?;
            db.query_row("PRAGMA journal_mode = DELETE", [], |_| Ok(()))
        };
        fold(&database).map_err(|why| LogError::Database { path: self.path.clone(), why })
    }

    pub(super) fn write(
        &mut self,
        change: impl FnOnce(&Transaction<'_>) -> rusqlite::Result<()>,
    ) -> Result<(), LogError> {
        let Some(database) = self.database.as_mut() else { return Ok(()) };
        let done = database.transaction().and_then(|transaction| {
            change(&transaction)?; // dropped on an error: rolled back
            transaction.commit()
        });
        done.map_err(|why| {
            self.database = None;
            LogError::Database { path: self.path.clone(), why }
        })
    }
}

fn begin(database: &mut Connection, run: &RunInfo, map: &AirportMap) -> rusqlite::Result<()> {
    database.query_row("PRAGMA journal_mode = WAL", [], |_| Ok(()))?;
    database.pragma_update(None, "synchronous", "NORMAL")?;
    database.pragma_update(None, "application_id", APPLICATION_ID)?;
    database.pragma_update(None, "user_version", SCHEMA)?;
    let transaction = database.transaction()?;
    transaction.execute_batch(include_str!("log.sql"))?;
    for (name, value) in [
        ("scene", run.scene.clone()),
        ("title", run.title.clone()),
        ("seed", run.seed.to_string()),
        ("exercise", run.exercise.to_string()),
        ("start_utc_ns", run.start_utc_ns.to_string()),
        ("duration_s", run.duration_s.to_string()),
        ("scan_s", run.scan_s.to_string()),
        ("scene_digest", run.scene_digest.clone()),
        ("version", run.version.clone()),
        ("airport", map.icao.clone()),
        ("reference_latitude_deg", map.reference_deg[0].to_string()),
        ("reference_longitude_deg", map.reference_deg[1].to_string()),
        ("map_json", serde_json::json!(map).to_string()),
        ("fork", run.fork.clone().unwrap_or_default()),
    ] {
        fact(&transaction, name, &value)?;
    }
    for s in &map.sensors {
        transaction.execute(
            "INSERT INTO sensors VALUES (?,?,?,?,?,?)",
            params![
                s.id,
                s.name,
                s.kind,
                s.position_m.map(|p| p[0]),
                s.position_m.map(|p| p[1]),
                s.range_m
            ],
        )?;
    }
    transaction.commit()
}

fn fact(t: &Transaction<'_>, name: &str, value: &str) -> rusqlite::Result<()> {
    t.execute("INSERT OR REPLACE INTO run VALUES (?,?)", [name, value])?;
    Ok(())
}

pub(super) fn write_events(t: &Transaction<'_>, events: &[Event]) -> rusqlite::Result<()> {
    let mut insert = t.prepare_cached("INSERT INTO events VALUES (?,?,?,?)")?;
    for e in events {
        insert.execute(params![e.time_ns, e.kind, e.subject, e.text])?;
    }
    Ok(())
}

/// A change of the weather as the time line marks it.
#[must_use]
pub(super) fn weather_event(w: &WeatherNotice) -> Event {
    let rain =
        if w.rain_mm_per_h > 0.0 { format!("rain {} mm/h", w.rain_mm_per_h) } else { "dry".into() };
    let text = if w.visibility_m.is_finite() {
        format!("{rain}, visibility {} m", w.visibility_m)
    } else {
        rain
    };
    Event { time_ns: w.from_ns, kind: "weather".into(), subject: String::new(), text }
}

/// An operator's action as the time line marks it.
#[must_use]
pub(super) fn operation_event(o: &Operation) -> Event {
    let text = format!("{}: {}", o.command, o.text);
    Event { time_ns: o.time_ns, kind: "operator".into(), subject: o.source.clone(), text }
}

/// "SEED" in the file's header: what a log is known by.
pub(super) const APPLICATION_ID: i32 = 0x5345_4544;

/// Version of the tables in `log.sql`; a reader knows all earlier ones.
pub const SCHEMA: i64 = 5;

/// The file, locked for as long as its log is written, so that another run does not take its place; `None` where nothing can be locked.
fn held(path: &Path) -> Option<std::fs::File> {
    let file = std::fs::File::open(path).ok()?;
    file.try_lock().ok().map(|()| file)
}

/// Whether another process writes this log.
fn is_written(path: &Path) -> bool {
    let file = std::fs::File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock(), Err(std::fs::TryLockError::WouldBlock)))
}

/// A text as the table `said` holds it.
fn deflated(text: &str) -> Vec<u8> {
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write as _;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // A vector takes everything.
    encoder.write_all(text.as_bytes()).ok();
    encoder.finish().unwrap_or_default()
}

/// Root of the mean square; none of nothing.
fn rmse(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = errors.fold((0_u32, 0.0), |(n, sum), e| (n + 1, sum + e * e));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

/// SQLite's reason with what to do about it.
fn explain(error: &rusqlite::Error) -> String {
    use rusqlite::ErrorCode as Code;
    let advice = match error.sqlite_error_code() {
        Some(Code::DiskFull) => "the disk is full; the log ends here",
        Some(Code::SystemIoFailure) => "the file cannot be written; the log ends here",
        Some(Code::CannotOpen) => "cannot be opened; is the directory there and writable?",
        Some(Code::ReadOnly) => "the directory is read-only",
        _ => return error.to_string(),
    };
    format!("{advice} ({error})")
}

/// Word of a value; empty where there is none.
fn said<T: Word>(value: Option<T>) -> Cow<'static, str> {
    value.map(|value| value.said()).unwrap_or_default()
}

#[cfg(test)]
pub(super) mod tests;
