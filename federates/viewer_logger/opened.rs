//! Runs that are finished, or kept by somebody else: from what a person names to viewers of them.

use super::Viewer;
use super::archive::{Archive, ArchiveError};
use super::kept_scene;
use super::named;
use super::picture::{AirportMap, NamedPoint, RunInfo, SensorSite};
use super::source::Source;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::RunState;
use std::path::{Path, PathBuf};

/// Why what was named cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// There is nothing.
    #[error("{0}: there is no such run; a run is a folder of runs/, a file run.sqlite, or `last`")]
    Missing(String),
    /// A folder without a database.
    #[error("{}: holds no run.sqlite, so there is nothing to show", .0.display())]
    NoDatabase(PathBuf),
    /// `last`, where no run was kept.
    #[error("last: {} holds no run yet", .0.display())]
    NoRuns(PathBuf),
    /// A recording alone.
    #[error(
        "{}: is a recording without its database (of the same name, beside it); `seeds open` makes one for the time that it shows it",
        .0.display()
    )]
    Recording(PathBuf),
    /// The database cannot be shown.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The database refused while it was read.
    #[error("{}: {source}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
}

/// The databases that a word names: a folder with all its runs, a file, or `last` for the newest folder of `runs`.
///
/// # Errors
/// If there is nothing of that name.
pub fn databases(word: &str, runs: &Path) -> Result<Vec<PathBuf>, OpenError> {
    let mut path = PathBuf::from(word);
    if word == "last" && !path.exists() {
        path = newest(runs).ok_or_else(|| OpenError::NoRuns(runs.to_owned()))?;
    } else if !path.exists() && path.components().count() == 1 {
        path = runs.join(word);
    }
    if !path.exists() {
        return Err(OpenError::Missing(word.to_owned()));
    }
    if path.is_dir() {
        return in_folder(&path);
    }
    if named::is_recording(&path) {
        let beside = named::database_of(&path);
        return if beside.is_file() { Ok(vec![beside]) } else { Err(OpenError::Recording(path)) };
    }
    match path.extension().and_then(|e| e.to_str()) {
        Some("toml") => in_folder(path.parent().unwrap_or(Path::new("."))),
        _ => Ok(vec![path]),
    }
}

/// `run.sqlite` first, then those of later runs of the same process.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, OpenError> {
    let first = folder.join("run.sqlite");
    if !first.is_file() {
        return Err(OpenError::NoDatabase(folder.to_owned()));
    }
    let later = named::later(&first);
    Ok(std::iter::once(first).chain(later).take(MOST).collect())
}

/// The folder whose database was written last: not all are named by their time. Of one moment that of the later name.
fn newest(runs: &Path) -> Option<PathBuf> {
    let folders = std::fs::read_dir(runs).ok()?.flatten().map(|e| e.path());
    let written = |folder: &Path| {
        // What goes on, or was cut off, is written beside it; later runs of one process have files of their own.
        let is = |name: &str| {
            let stem = name.strip_suffix("-wal").unwrap_or(name).strip_suffix(".sqlite");
            stem.is_some_and(|stem| stem == "run" || stem.starts_with("run-"))
        };
        let files = std::fs::read_dir(folder).ok()?.flatten();
        let files = files.filter(|f| f.file_name().to_str().is_some_and(is));
        files.filter_map(|f| f.metadata().ok()?.modified().ok()).max()
    };
    folders.filter(|f| f.join("run.sqlite").is_file()).max_by_key(|f| (written(f), f.clone()))
}

/// What a run is called: its folder, with the number of a later run of the same process; of a file elsewhere its name.
#[must_use]
pub fn id_of(database: &Path) -> String {
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().into_owned());
    let stem = database.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let whole = std::path::absolute(database).unwrap_or_else(|_| database.to_owned());
    let folder = whole.parent().and_then(name);
    let id = match (stem.strip_prefix("run"), folder) {
        (Some(""), Some(folder)) => folder,
        (Some(number), Some(folder)) if number.starts_with('-') => folder + number,
        _ => stem,
    };
    id.replace([',', '&', '~'], "_").chars().take(64).collect()
}

/// A viewer of the run in a database, told everything but its scans, which it reads when they are asked for.
///
/// # Errors
/// If the database cannot be shown.
pub fn viewer(database: &Path) -> Result<Viewer, OpenError> {
    let archive = Archive::open(database)?;
    let failed = |source| OpenError::Database { path: database.to_owned(), source };
    let (info, map) = scene_of(&archive).map_err(failed)?;
    let state = RunState {
        run: 1,
        phase: Phase::Stopped,
        seed: info.seed,
        frame: archive.times().map_or(0, |t| (t.1.0 / frame_ns(&archive)) as u64),
        ..RunState::default()
    };
    let (weather, flights) =
        (archive.weather().map_err(failed)?, archive.flights().map_err(failed)?);
    let operations = archive.operations().map_err(failed)?;
    let plan = archive.plan().map_err(failed)?;
    let mut viewer = Viewer::stored(archive);
    viewer.set_id(&id_of(database));
    viewer.on_scene(&info, &map);
    weather.iter().for_each(|w| viewer.on_weather(w));
    viewer.on_flights(&flights);
    operations.into_iter().for_each(|o| viewer.on_operation(o));
    viewer.on_plan(&plan);
    viewer.on_state(&state);
    viewer.show_detection(super::detection::Maps::stored(database.to_owned()));
    viewer.tell_end();
    Ok(viewer)
}

/// The length of a frame by the scene in the log, ns; 50 ms of a log without it.
fn frame_ns(archive: &Archive) -> i64 {
    kept_scene::load(archive).map_or(50_000_000, |scene| scene.run.frame.0.max(1))
}

/// What a run says of itself, and its airport as it is drawn.
///
/// # Errors
/// If the database refuses.
pub fn scene_of(archive: &Archive) -> rusqlite::Result<(RunInfo, AirportMap)> {
    let kept = archive.fact("map_json").and_then(|m| serde_json::from_str(&m).ok());
    let map = match kept {
        Some(map) => map,
        None => map_of_itself(archive)?,
    };
    Ok((run_info(archive), map))
}

fn run_info(archive: &Archive) -> RunInfo {
    let text = |name: &str| archive.fact(name).unwrap_or_default();
    let number = |name: &str| text(name).parse().unwrap_or(0.0);
    RunInfo {
        scene: text("scene"),
        title: text("title"),
        seed: text("seed").parse().unwrap_or(0),
        exercise: text("exercise").parse().unwrap_or(0),
        start_utc_ns: text("start_utc_ns").parse().unwrap_or(0),
        duration_s: number("duration_s"),
        scan_s: number("scan_s"),
        scene_digest: text("scene_digest"),
        version: text("version"),
        airport: text("airport"),
        fork: archive.fact("fork").filter(|f| !f.is_empty()),
    }
}

/// Of a database without its map (the first version of the tables): the sensors that it names.
fn map_of_itself(archive: &Archive) -> rusqlite::Result<AirportMap> {
    let number = |name: &str| archive.fact(name).and_then(|t| t.parse().ok()).unwrap_or(0.0);
    let sensors = archive.sensors()?;
    let corner = |x: f64, y: f64| NamedPoint { name: String::new(), position_m: [x, y] };
    Ok(AirportMap {
        icao: archive.fact("airport").unwrap_or_default(),
        reference_deg: [number("reference_latitude_deg"), number("reference_longitude_deg")],
        stands: archive.bounds()?.map_or_else(Vec::new, |[x0, y0, x1, y1]| {
            vec![corner(x0, y0), corner(x1, y1)] // so that the page knows where to look
        }),
        sensors: sensors
            .into_iter()
            .map(|(id, name, kind, position_m)| SensorSite {
                id,
                name,
                kind,
                position_m,
                range_m: None,
            })
            .collect(),
        ..AirportMap::default()
    })
}

/// Runs of one folder that are opened together.
const MOST: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::log::tests::Folder;

    #[test]
    fn what_is_not_a_run_is_said_in_one_sentence() {
        let folder = Folder::new();
        let runs = folder.0.join("runs");
        std::fs::create_dir_all(runs.join("a")).expect("a folder");
        let file = folder.0.join("x.sqlite");
        std::fs::write(&file, "my letters").expect("written");
        let capture = folder.0.join("x2.pcapng");
        std::fs::write(&capture, "").expect("written");
        let say = |word: &str| match databases(word, &runs) {
            Ok(found) => viewer(&found[0]).err().map_or(String::new(), |e| e.to_string()),
            Err(error) => error.to_string(),
        };
        for (word, part) in [
            ("nothing", "no such run"),
            ("last", "holds no run yet"),
            ("a", "no run.sqlite"),
            (file.to_str().expect("a name"), "not a database of a run"),
            (capture.to_str().expect("a name"), "is a recording"),
        ] {
            let said = say(word);
            assert!(said.contains(part) && !said.contains('\n'), "{word}: {said}");
        }
    }

    #[test]
    fn the_last_run_is_the_one_that_was_written_last_whatever_its_name() {
        use std::time::{Duration, UNIX_EPOCH};
        let folder = Folder::new();
        let runs = folder.0.join("runs");
        for (name, second) in
            [("2026-11-22T08-50-46Z_10", 7), ("2026-11-22T08-50-46Z_9", 6), ("mine", 5), ("a", 7)]
        {
            std::fs::create_dir_all(runs.join(name)).expect("a folder");
            let file = std::fs::File::create(runs.join(name).join("run.sqlite")).expect("a file");
            file.set_modified(UNIX_EPOCH + Duration::from_secs(second)).expect("a time");
        }
        std::fs::create_dir_all(runs.join("z")).expect("a folder without a run");
        let last = || databases("last", &runs).expect("one");
        assert_eq!(last(), [runs.join("a").join("run.sqlite")], "of one second by the name");
        let wal = std::fs::File::create(runs.join("mine").join("run.sqlite-wal")).expect("a file");
        wal.set_modified(UNIX_EPOCH + Duration::from_secs(8)).expect("a time");
        assert_eq!(last(), [runs.join("mine").join("run.sqlite")], "it goes on");
        let again = runs.join("2026-11-22T08-50-46Z_9").join("run-2.sqlite");
        let file = std::fs::File::create(&again).expect("a file");
        file.set_modified(UNIX_EPOCH + Duration::from_secs(9)).expect("a time");
        assert_eq!(last().last(), Some(&again), "it was begun again");
    }

    #[test]
    fn a_run_is_called_by_its_folder() {
        for (file, id) in [
            ("/r/2026-11-22T08-50-46Z/run.sqlite", "2026-11-22T08-50-46Z"),
            ("/r/2026-11-22T08-50-46Z/run-2.sqlite", "2026-11-22T08-50-46Z-2"),
            ("/r/mine.sqlite", "mine"),
            ("/r/a,b/run.sqlite", "a_b"),
        ] {
            assert_eq!(id_of(Path::new(file)), id);
        }
    }

    #[test]
    fn frames_are_as_long_as_the_scene_has_them() {
        let folder = Folder::new();
        let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
        for (name, frame_s) in [("slow", 0.25), ("quick", 0.02)] {
            let text = format!(
                "[run]\ntitle = \"frames\"\nseed = 1\nstart = 2026-01-01T06:00:00Z\nduration_s = 60\nframe_s = {frame_s}\n\
                 [airport]\nicao = \"LZIB\"\nlayout = \"{airports}/LZIB.apt.dat\"\n\
                 [[traffic]]\nkind = \"generated\"\narrivals_per_h = 1\ndepartures_per_h = 1\nmix = {{ A320 = 1 }}\n\
                 [[sensor]]\nkind = \"asde\"\nname = \"tower\"\nparameters = \"ku_asde3\"\n\
                 site = {{ east_m = 250, north_m = 250, height_m = 30 }}\n[tracking]\nprofile = \"accurate\"\n"
            );
            let path = folder.0.join(format!("{name}.toml"));
            std::fs::write(&path, text).expect("written");
            let scene = scenarios::load_without_truth(&path).expect("a scene");
            let file = folder.0.join(format!("{name}.sqlite"));
            let mut log = crate::viewer_logger::log::Log::create(
                &file,
                &RunInfo::of(&scene, 1),
                &AirportMap::of(&scene),
            )
            .expect("a log");
            kept_scene::keep(&mut log, &scene);
            log.close().expect("closed");
            let archive = Archive::open(&file).expect("opened");
            assert_eq!(frame_ns(&archive), (frame_s * 1e9) as i64, "{name}");
        }
    }
}
