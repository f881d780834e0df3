//! What is scored and against what: files of truth, tracks and alerts, and the scene of the airport.

use super::score_asterix;
use crate::exchange::asterix_file::{self, Pieces};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::kept_scene;
use anyhow::{Context, bail};
use models::frames::{Point2, Vector2};
use models::score::recording::{PlotSum, Report, Target, TruthPoint};
use models::time::SimTime;
use rusqlite::{Connection, OpenFlags};
use scenarios::Scene;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use studies::score_files::{self, Stage, told_apart};

/// The scene that says what is where: the one asked for has to be there; else the one that a log holds; of a log without
/// it the one of its name, where that is still the same.
pub(super) fn scene(
    asked: Option<&str>,
    logs: &[&Source],
    notes: &mut Vec<String>,
) -> anyhow::Result<Option<Scene>> {
    let load = |name: &str| scenarios::load_without_truth(&scenarios::locate(name));
    if let Some(asked) = asked {
        return Ok(Some(load(asked)?));
    }
    let fact = |name: &str| logs.iter().find_map(|s| s.fact(name)).filter(|v| !v.is_empty());
    let named = fact("scene");
    let same = |scene: &Scene| {
        fact("scene_digest").is_none_or(|digest| digest == format!("{:016x}", scene.hash))
    };
    let found = logs.iter().find_map(|s| s.kept_scene());
    let found =
        found.or_else(|| named.as_deref().and_then(|n| load(n).ok()).filter(|scene| same(scene)));
    notes.push(match (&found, named) {
        (Some(s), _) => format!("Areas are those of scene {} ({}).", s.name, s.airport.layout.icao),
        (None, Some(name)) => {
            format!("Scene {name}, as it was run, is not here: areas are unknown; name one with --scene.")
        }
        (None, None) => "Areas are unknown: name the scene of the airport with --scene.".into(),
    });
    Ok(found)
}

/// Octets of the largest text that is read.
const LARGEST_TEXT: u64 = 1 << 30;

/// How a database begins.
const DATABASE: &[u8] = b"SQLite format 3";

/// A file with truth or tracks.
pub(super) enum Source {
    Database(Connection),
    Text(String),
    /// A recording of ASTERIX, whose tracks [`score_asterix`] finds.
    Recording(Pieces),
}

impl Source {
    /// A file with tracks, which may be a recording of ASTERIX.
    pub(super) fn tracks(path: &Path) -> anyhow::Result<Self> {
        let doing = || path.display().to_string();
        if std::fs::metadata(path).with_context(doing)?.is_file() {
            return match score_asterix::is_recording(path)? {
                true => Ok(Self::Recording(asterix_file::read(path, None)?)),
                false => Self::open(path),
            };
        }
        // What a pipe gave is gone: it is opened once, and what it is decided by its octets.
        let mut octets = Vec::new();
        let file = std::fs::File::open(path).with_context(doing)?;
        file.take(LARGEST_TEXT + 1).read_to_end(&mut octets).with_context(doing)?;
        if octets.len() as u64 > LARGEST_TEXT {
            bail!("{}: longer than {} MiB", path.display(), LARGEST_TEXT >> 20);
        }
        if octets.starts_with(DATABASE) {
            bail!("{}: a database is read from a file, not from a pipe", path.display());
        }
        match String::from_utf8(octets) {
            Ok(text) => Ok(Self::Text(text)),
            Err(other) => {
                let read = asterix_file::of_octets(other.as_bytes(), &doing())?;
                Ok(Self::Recording(read))
            }
        }
    }

    pub(super) fn open(path: &Path) -> anyhow::Result<Self> {
        let doing = || path.display().to_string();
        let mut head = [0; 15];
        let mut file = std::fs::File::open(path).with_context(doing)?;
        let length = file.read(&mut head).with_context(doing)?;
        if &head[..length] == DATABASE {
            let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
            return Ok(Self::Database(
                Connection::open_with_flags(path, flags).with_context(doing)?,
            ));
        }
        let mut text = head[..length].to_vec();
        // Read on from where it is (a pipe has no second beginning); a device may never end.
        file.take(LARGEST_TEXT).read_to_end(&mut text).with_context(doing)?;
        if text.len() as u64 > LARGEST_TEXT {
            bail!("{}: longer than {} MiB", path.display(), LARGEST_TEXT >> 20);
        }
        match String::from_utf8(text) {
            Ok(text) => Ok(Self::Text(text)),
            Err(_) => bail!("{}: neither the database of a run nor text", path.display()),
        }
    }

    /// The scene as it was run, where the log holds it.
    fn kept_scene(&self) -> Option<Scene> {
        let Self::Database(database) = self else { return None };
        let archive = Archive::open(Path::new(database.path()?)).ok()?;
        kept_scene::load(&archive).ok()
    }

    /// A figure of the run.
    pub(super) fn fact(&self, name: &str) -> Option<String> {
        let Self::Database(database) = self else { return None };
        database.query_row("SELECT value FROM run WHERE name = ?", [name], |r| r.get(0)).ok()
    }

    pub(super) fn targets(&self, place: score_files::Place<'_>) -> anyhow::Result<Vec<Target>> {
        let database = match self {
            Self::Text(text) => return Ok(score_files::truth(text, place)?),
            Self::Database(database) => database,
            Self::Recording(_) => return Ok(Vec::new()),
        };
        let mut query = database.prepare(
            "SELECT entity, callsign, time_ns, x_m, y_m, vx_ms, vy_ms, altitude_m \
             FROM truth JOIN scans USING (scan)",
        )?;
        let mut rows = query.query([])?;
        let mut targets: BTreeMap<i64, Target> = BTreeMap::new();
        while let Some(row) = rows.next()? {
            let target = targets.entry(row.get(0)?).or_default();
            target.name = row.get::<_, Option<String>>(1)?.unwrap_or_default();
            target.path.push(TruthPoint {
                time: SimTime(row.get(2)?),
                position_m: Point2::new(row.get(3)?, row.get(4)?),
                velocity_mps: Vector2::new(row.get(5)?, row.get(6)?),
                height_m: row.get(7)?,
            });
        }
        Ok(targets.into_values().collect())
    }

    /// Reports; of our own runs the publication is late by what the scan took.
    pub(super) fn reports(&self, place: score_files::Place<'_>) -> anyhow::Result<Vec<Report>> {
        let database = match self {
            Self::Text(text) => return Ok(score_files::tracks(text, place)?),
            Self::Database(database) => database,
            Self::Recording(_) => return Ok(Vec::new()),
        };
        let mut query = database.prepare(
            "SELECT track, time_ns, took_us, x_m, y_m, vx_ms, vy_ms, callsign, coalesce(status, '') \
             FROM tracks JOIN scans USING (scan)",
        )?;
        let reports = query.query_map([], |row| {
            let time: i64 = row.get(1)?;
            let took_us: Option<i64> = row.get(2)?;
            let report = Report {
                track: row.get::<_, i64>(0)?.unsigned_abs(),
                time: SimTime(time),
                published: took_us.map(|us| SimTime(time + us * 1000)),
                position_m: Point2::new(row.get(3)?, row.get(4)?),
                velocity_mps: Some(Vector2::new(row.get(5)?, row.get(6)?)),
                label: row.get::<_, Option<String>>(7)?.unwrap_or_default(),
            };
            Ok((report, Stage::of(&row.get::<_, String>(8)?)))
        })?;
        Ok(told_apart(reports.collect::<Result<_, _>>()?))
    }

    /// The tracks one scan earlier, as they were revised; none where a log does not hold them.
    pub(super) fn second_ago(&self) -> Vec<Report> {
        let Self::Database(database) = self else { return Vec::new() };
        let query = database.prepare(
            "SELECT track, lag_time_ns, time_ns, lag_x_m, lag_y_m, callsign, status FROM tracks JOIN scans USING (scan) \
             WHERE status <> 'tentative' AND lag_time_ns IS NOT NULL",
        );
        let Ok(mut query) = query else { return Vec::new() };
        let reports = query.query_map([], |row| {
            let report = Report {
                track: row.get::<_, i64>(0)?.unsigned_abs(),
                time: SimTime(row.get(1)?),
                published: Some(SimTime(row.get(2)?)),
                position_m: Point2::new(row.get(3)?, row.get(4)?),
                velocity_mps: None,
                label: row.get::<_, Option<String>>(5)?.unwrap_or_default(),
            };
            Ok((report, Stage::of(&row.get::<_, String>(6)?)))
        });
        reports.map_or_else(|_| Vec::new(), |rows| told_apart(rows.flatten().collect()))
    }

    /// The radars' plots of targets.
    pub(super) fn plots(&self) -> anyhow::Result<PlotSum> {
        let Self::Database(database) = self else { return Ok(PlotSum::default()) };
        let mut query = database.prepare(
            "SELECT error_m FROM plots \
             WHERE kind = 'asde' AND cause IS NOT NULL AND error_m IS NOT NULL",
        )?;
        let errors_m = query.query_map([], |row| row.get(0))?;
        Ok(PlotSum::of(errors_m.collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::log::Log;
    use crate::viewer_logger::picture::{AirportMap, RunInfo};

    #[test]
    fn areas_are_those_of_the_scene_as_it_was_run() {
        let folder = std::env::temp_dir().join(format!("seeds-score-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let ran = scenarios::load_without_truth(&scenarios::locate("asmgcs")).expect("a scene");
        let of = |name: &str, held: bool, scene_digest: &str| {
            let file = folder.join(name);
            let (scene, scene_digest) = ("zurich".to_owned(), scene_digest.to_owned());
            let info = RunInfo { scene, scene_digest, ..RunInfo::default() };
            let mut log = Log::replace(&file, &info, &AirportMap::default()).expect("a log");
            if held {
                kept_scene::keep(&mut log, &ran);
            }
            log.close().expect("closed");
            let source = Source::open(&file).expect("opened");
            let mut notes = Vec::new();
            let found = super::scene(None, &[&source], &mut notes).expect("a scene or none");
            (found.map(|s| s.hash), notes.concat())
        };
        // Another scene of the same name is here; the log holds the one that was run.
        assert_eq!(of("held.sqlite", true, &format!("{:016x}", ran.hash)).0, Some(ran.hash));
        // It does not: the one of that name is taken where it is the same.
        let zurich = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("a scene");
        let same = format!("{:016x}", zurich.hash);
        assert_eq!(of("same.sqlite", false, &same).0, Some(zurich.hash));
        assert_eq!(of("early.sqlite", false, "").0, Some(zurich.hash));
        let (found, notes) = of("other.sqlite", false, "00000000000000ff");
        assert_eq!(found, None);
        assert!(notes.contains("as it was run"), "{notes}");
        std::fs::remove_dir_all(&folder).ok();
    }

    /// A pipe gives its octets once, whatever they are.
    #[test]
    fn tracks_come_by_a_pipe_whole() {
        use std::io::Write;
        use std::os::fd::AsRawFd;
        let by_pipe = |octets: &[u8]| {
            let (reader, mut writer) = std::io::pipe().expect("a pipe");
            writer.write_all(octets).expect("written");
            drop(writer);
            let path = format!("/proc/self/fd/{}", reader.as_raw_fd());
            Source::tracks(Path::new(&path))
        };
        let text = "time_s,track,x_m,y_m\n0,7,1,2\n";
        let reports = by_pipe(text.as_bytes()).expect("opened").reports(None).expect("tracks");
        assert_eq!((reports.len(), reports[0].track), (1, 7));
        // The block of a category, without a file around it.
        let block = [0x3e, 0x00, 0x05, 0x80, 0xff];
        let Ok(Source::Recording(read)) = by_pipe(&block) else { panic!("a recording") };
        assert_eq!(read.pieces.first().map(|p| &p.octets[..]), Some(&block[..]));
        let refused = by_pipe(b"SQLite format 3\0...").err().expect("no pipe").to_string();
        assert!(refused.contains("not from a pipe"), "{refused}");
    }

    #[test]
    fn a_number_of_a_log_that_comes_again_is_another_track() {
        let database = Connection::open_in_memory().expect("opened");
        database
            .execute_batch(
                "CREATE TABLE scans (scan INTEGER, time_ns INTEGER, took_us INTEGER);
                 CREATE TABLE tracks (scan INTEGER, track INTEGER, status TEXT, callsign TEXT, x_m REAL, y_m REAL, vx_ms REAL,
                 vy_ms REAL, lag_time_ns INTEGER, lag_x_m REAL, lag_y_m REAL);",
            )
            .expect("tables");
        for (scan, status) in [(1, "confirmed"), (2, "confirmed"), (3, "last"), (9, "confirmed")] {
            let time_ns = scan * 1_000_000_000i64;
            database
                .execute("INSERT INTO scans VALUES (?, ?, 5)", (scan, time_ns))
                .expect("a scan");
            let lag_ns = (scan != 1).then_some(time_ns - 1_000_000_000);
            database
                .execute(
                    "INSERT INTO tracks VALUES (?, 7, ?, 'A', 0, 0, 0, 0, ?, 0, 0)",
                    (scan, status, lag_ns),
                )
                .expect("a track");
        }
        let source = Source::Database(database);
        let of = |reports: Vec<Report>| -> Vec<(i64, u64)> {
            reports.iter().map(|r| (r.time.0 / 1_000_000_000, r.track)).collect()
        };
        assert_eq!(of(source.reports(None).expect("tracks")), [(1, 7), (2, 7), (9, 8)]);
        assert_eq!(of(source.second_ago()), [(1, 7), (8, 8)]);
    }
}
