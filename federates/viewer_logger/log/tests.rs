use super::*;
use crate::viewer_logger::tests::{scan, weather};
use models::frames::Point2;
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder that goes with its value.
pub(in crate::viewer_logger) struct Folder(pub(in crate::viewer_logger) PathBuf);

impl Folder {
    pub(in crate::viewer_logger) fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("seeds-log-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("a temporary directory");
        Self(path)
    }
    fn file(&self) -> PathBuf {
        self.0.join("run.sqlite")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

fn run() -> RunInfo {
    RunInfo { scene: "zurich".to_owned(), seed: u64::MAX, ..RunInfo::default() }
}

fn create(folder: &Folder) -> Log {
    Log::create(&folder.file(), &run(), &AirportMap::default()).expect("a new log")
}

fn number(database: &Connection, question: &str) -> f64 {
    database.query_row(question, [], |row| row.get(0)).expect(question)
}

#[test]
fn what_is_written_can_be_asked_for_during_and_after_the_run() {
    let folder = Folder::new();
    let mut log = create(&folder);
    (1..=4).for_each(|n| log.scan(&scan(n)).expect("written"));
    log.weather(&weather(10.0)).expect("written");
    let freeze = Operation {
        frame: 80,
        time_ns: 4_000_000_000,
        source: "page".to_owned(),
        command: "freeze".to_owned(),
        ok: true,
        text: "FROZEN at frame 80".to_owned(),
    };
    log.operation(&freeze, 1).expect("written");
    let federate =
        FederateStatus { name: "smdfm".to_owned(), lost: 3, ..FederateStatus::default() };
    log.federate(&federate, Some(420.0), 1).expect("written");
    log.state(&RunState { rate: f64::INFINITY, ..RunState::default() }, 1).expect("written");
    log.fact("digest", "00ff").expect("written");

    let reader = Connection::open(folder.file()).expect("a second reader during the run");
    for (question, answer) in [
        ("SELECT count(*) FROM scans", 4.0),
        ("SELECT x_m FROM tracks WHERE scan = 3", 30.0),
        ("SELECT lag_y_m FROM tracks WHERE scan = 3", 8.0),
        ("SELECT lag_error_m FROM tracks WHERE scan = 3", 1.5),
        ("SELECT error_m FROM plots WHERE scan = 3", 3.0),
        ("SELECT value FROM plot_effects WHERE scan = 3 AND effect = 'rain attenuation'", -3.1),
        ("SELECT value FROM statistics WHERE scan = 2 AND name = 'pd_asde'", 0.98),
        ("SELECT plot_rmse_m FROM error_over_time WHERE scan = 1", 3.0),
        ("SELECT tracked_percent FROM target_accuracy", 100.0),
        ("SELECT plots FROM sensor_accuracy WHERE kind = 'asde'", 4.0),
        ("SELECT rmse_m FROM sensor_accuracy WHERE kind = 'asde'", 3.0),
        ("SELECT count(*) FROM weather WHERE rain_mm_per_h = 10 AND visibility_m IS NULL", 1.0),
        ("SELECT count(*) FROM operations WHERE command = 'freeze' AND done", 1.0),
        ("SELECT count(*) FROM states WHERE rate IS NULL AND phase = 'INIT'", 1.0),
        ("SELECT lost FROM network_losses WHERE name = 'smdfm'", 3.0),
        ("SELECT count(*) FROM false_tracks", 0.0),
        ("SELECT count(*) FROM wrong_labels", 0.0),
        ("SELECT count(*) FROM run WHERE name = 'seed' AND value = '18446744073709551615'", 1.0),
        ("SELECT count(*) FROM run WHERE name = 'digest' AND value = '00ff'", 1.0),
    ] {
        assert_eq!(
            number(&reader, &format!("SELECT CAST(({question}) AS REAL)")),
            answer,
            "{question}"
        );
    }
    // worst error of the four scans: 0.1 · 4; root mean square of 0.1 … 0.4
    let rmse = number(&reader, "SELECT rmse_m FROM target_accuracy");
    assert!((rmse - (0.3_f64 / 4.0).sqrt()).abs() < 1e-12, "{rmse}");
    drop(reader);
    log.close().expect("closed");
    let left: Vec<_> = std::fs::read_dir(&folder.0).expect("folder").collect();
    assert_eq!(left.len(), 1, "one file remains");
}

#[test]
fn a_track_that_lost_its_target_for_a_scan_is_no_false_track() {
    let folder = Folder::new();
    let mut log = create(&folder);
    (1..=4).for_each(|n| log.scan(&scan(n)).expect("written"));
    log.close().expect("closed");
    let writer = Connection::open(folder.file()).expect("opened");
    let false_tracks = || number(&writer, "SELECT CAST(count(*) AS REAL) FROM false_tracks");
    writer.execute("UPDATE tracks SET entity = NULL WHERE scan = 3", []).expect("written");
    assert_eq!(false_tracks(), 0.0, "it followed a target in the other scans");
    writer.execute("UPDATE tracks SET entity = NULL", []).expect("written");
    assert!(false_tracks() > 0.0);
}

#[test]
fn a_full_disk_ends_the_log_once_and_leaves_whole_scans() {
    let folder = Folder::new();
    let mut log = create(&folder);
    let database = log.database.as_ref().expect("open");
    let pages: i64 = database.query_row("PRAGMA page_count", [], |r| r.get(0)).expect("pages");
    let limit = format!("PRAGMA max_page_count = {}", pages + 12);
    database.query_row(&limit, [], |_| Ok(())).expect("limited");
    let errors: Vec<String> =
        (1..=2000).filter_map(|n| log.scan(&scan(n)).err()).map(|e| e.to_string()).collect();
    let (written, lost) = log.scans();
    assert_eq!(errors.len(), 1, "reported once");
    assert!(
        errors[0].contains("the disk is full") && errors[0].contains("run.sqlite"),
        "{errors:?}"
    );
    assert!(written > 10 && written + lost == 2000, "{written} written, {lost} lost");
    log.close().expect("nothing to close");

    let reader = Connection::open(folder.file()).expect("a sound file");
    for table in ["scans", "truth", "tracks", "plots", "plot_effects", "statistics"] {
        let rows = number(&reader, &format!("SELECT CAST(count(*) AS REAL) FROM {table}"));
        assert_eq!(rows, written as f64, "{table}: no scan is half written");
    }
    let check: String =
        reader.query_row("PRAGMA integrity_check", [], |r| r.get(0)).expect("checked");
    assert_eq!(check, "ok");
}

#[test]
fn a_log_that_cannot_be_created_says_why() {
    let folder = Folder::new();
    let nowhere = folder.0.join("missing/run.sqlite");
    let error = Log::create(&nowhere, &run(), &AirportMap::default()).expect_err("no directory");
    assert!(error.to_string().contains("is the directory there"), "{error}");
    create(&folder).close().expect("closed");
    let again = Log::create(&folder.file(), &run(), &AirportMap::default()).expect_err("exists");
    assert!(again.to_string().contains("exists already"), "{again}");
}

#[test]
fn figures_that_are_none_are_null() {
    let folder = Folder::new();
    let mut log = create(&folder);
    let mut bad = scan(1);
    bad.tracks[0].position_m = Point2::new(f64::NAN, f64::INFINITY);
    bad.plots[0].cause.clear();
    log.scan(&bad).expect("written");
    let reader = Connection::open(folder.file()).expect("reader");
    assert_eq!(number(&reader, "SELECT CAST(count(*) AS REAL) FROM tracks WHERE x_m IS NULL"), 1.0);
    assert_eq!(
        number(&reader, "SELECT CAST(count(*) AS REAL) FROM plots WHERE cause IS NULL"),
        1.0
    );
}

#[test]
fn a_decision_of_the_effect_plan_that_comes_back_is_written_again() {
    let folder = Folder::new();
    let mut log = create(&folder);
    let row = |effect: &str, decision: &str| {
        ["1", effect, "weather", "0.1 m", decision].map(str::to_owned)
    };
    for (n, decision) in (1..).zip(["exact", "exact", "skipped", "skipped", "exact", "exact"]) {
        let plan = vec![row("fog", decision), row("rain", "exact")];
        log.scan(&ScanReport { plan, ..scan(n) }).expect("written");
    }
    log.close().expect("closed");
    let reader = Connection::open(folder.file()).expect("a reader");
    let mut told = reader
        .prepare("SELECT scan, effect, decision FROM plan ORDER BY rowid")
        .expect("a question");
    let told = told.query_map([], |r| Ok((r.get(0)?, r.get(1)?, r.get(2)?))).expect("asked");
    let told: Vec<(i64, String, String)> = told.collect::<Result<_, _>>().expect("rows");
    let told: Vec<String> = told.iter().map(|(n, e, d)| format!("{n} {e} {d}")).collect();
    assert_eq!(told, ["1 fog exact", "1 rain exact", "3 fog skipped", "5 fog exact"]);
    let archive = super::super::archive::Archive::open(&folder.file()).expect("opened");
    let stood = archive.plan().expect("read");
    assert!(stood.contains(&row("fog", "exact")) && stood.len() == 2, "{stood:?}");
}

#[test]
fn a_full_disk_is_said_once_and_of_no_run_that_would_go_on() {
    let why = rusqlite::Error::SqliteFailure(rusqlite::ffi::Error::new(13), None);
    let error = LogError::Database { path: "x.sqlite".into(), why };
    let text = format!("{:#}", anyhow::Error::new(error));
    assert!(text.contains("the disk is full; the log ends here"), "{text}");
    assert!(!text.contains("run goes on"), "a fork has none: {text}");
    assert_eq!(text.matches("Error code 13").count(), 1, "{text}");
}
