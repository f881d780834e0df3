use super::*;
use crate::viewer_logger::log::Log;
use crate::viewer_logger::log::tests::Folder;
use crate::viewer_logger::picture::{AirportMap, RunInfo};
use crate::viewer_logger::tests::scan;
use std::time::Duration;

fn scene() -> Scene {
    scenarios::load(&scenarios::locate("zurich")).expect("a shipped scene")
}

/// The log of a run of the scene with these scans.
fn kept(folder: &Folder, info: RunInfo, scans: impl Iterator<Item = ScanReport>) -> PathBuf {
    let file = folder.0.join("run.sqlite");
    let mut log = Log::create(&file, &info, &AirportMap::default()).expect("a new log");
    kept_scene::keep(&mut log, &scene());
    scans.for_each(|s| log.scan(&s).expect("written"));
    log.close().expect("closed");
    file
}

fn begin(file: &Path, scan: u64, compared: Compared) -> (Replayed, Receiver<Value>) {
    let (send, receive) = unbounded();
    let tell = move |message| drop(send.send(message));
    (Replayed::begin(file.to_owned(), scan, compared, tell).expect("a thread"), receive)
}

/// The next message that has come to its end; those before it are on their way and show nothing.
fn end(told: &Receiver<Value>) -> Value {
    loop {
        let message = told.recv_timeout(Duration::from_secs(120)).expect("told");
        assert_eq!(message["comparing"], true);
        if message["done"] == 1.0 {
            return message;
        }
        assert!(message["done"].as_f64().is_some_and(|d| (0.0..1.0).contains(&d)), "{message}");
        assert_eq!(message["rows"], json!([]));
    }
}

/// Rows without what differs from one computer to the next.
fn judged(rows: Value) -> Vec<Value> {
    let Value::Array(mut rows) = rows else { panic!("rows: {rows}") };
    for row in &mut rows {
        let row = row.as_object_mut().expect("a row");
        assert!(row.remove("scan_us").is_some() && row.remove("us_per_track").is_some());
    }
    rows
}

#[test]
fn rungs_of_a_stored_run_are_those_beside_the_run_at_every_time() {
    let folder = Folder::new();
    let file = kept(&folder, RunInfo::default(), (1..=300).map(scan));
    let config = scene().tracking_config();
    let live = |from: u64, upto: u64| {
        let mut beside = Beside::new(&config);
        beside.ghost(Some("imm3"));
        let flights = &scene().flight_list;
        (from..=upto).for_each(|n| beside.scan(&scan(n), flights));
        (judged(json!(beside.rows())), json!(beside.ghosts_m()))
    };
    let (mut dial, told) = begin(&file, 100, Compared::Rungs(Some("imm3".to_owned())));
    let found = end(&told);
    let (rows, ghost) = live(1, 100);
    assert!(rows.len() > 10 && rows.iter().filter(|r| r["chosen"] == true).count() == 1);
    assert_eq!((judged(found["rows"].clone()), &found["ghost"]), (rows, &ghost));
    assert_eq!((&found["type"], &found["scan"]), (&json!("rungs"), &json!(100)));
    // A jump begins two minutes before; whoever goes on from there goes on; back is a jump again.
    for (scan, from) in [(300, 181), (240, 121), (242, 121), (242, 121), (1, 1)] {
        if dial.last.scan == scan {
            dial.ghost(Compared::Rungs(None));
            let found = end(&told);
            assert_eq!(
                (&found["ghost"], found["rows"].as_array().map(Vec::len)),
                (&json!([]), Some(rows_of(&config)))
            );
            continue;
        }
        dial.show(scan);
        assert_eq!(judged(end(&told)["rows"].clone()), live(from, scan).0, "{scan} from {from}");
    }
    drop(dial);
    let wait = Duration::from_secs(60);
    assert!(told.recv_timeout(wait).is_err_and(|e| e.is_disconnected()), "its thread has ended");
}

fn rows_of(config: &models::fusion::TrackingConfig) -> usize {
    Beside::new(config).rows().len()
}

#[test]
fn a_wish_on_the_way_is_followed_at_once_and_the_end_of_the_owner_cancels() {
    let folder = Folder::new();
    let file = kept(&folder, RunInfo::default(), (1..=400).map(scan));
    let (mut dial, told) = begin(&file, 130, Compared::Rungs(None));
    [400, 10, 390, 20].into_iter().for_each(|scan| dial.show(scan));
    let mut found = end(&told);
    while found["scan"] != 20 {
        found = end(&told);
    }
    assert_eq!(found["rows"][0]["since_s"], 1.0, "{found}");
    dial.show(400);
    drop(dial);
    // Whatever was under way is told at most; then the thread is gone.
    while let Ok(message) = told.recv_timeout(Duration::from_secs(60)) {
        assert_ne!(message["scan"], 400, "cancelled before its end");
    }
}

#[test]
fn tolerances_of_a_stored_run_are_compared_on_its_truth() {
    let folder = Folder::new();
    let file = kept(&folder, RunInfo { seed: 3, ..RunInfo::default() }, (1..=40).map(scan));
    let (_dial, told) = begin(&file, 40, Compared::Tolerances(Some(0.5)));
    let found = end(&told);
    assert_eq!((&found["type"], &found["why_not"]), (&json!("tolerances"), &json!("")));
    let scene = Arc::new(scene());
    let (mut chains, mut before) = (Chains::new(Arc::clone(&scene), 3).expect("sensors"), None);
    for n in 1..=40 {
        let work = Work::of(&scan(n), before.take(), &scene.flight_list, None);
        before = Some((SimTime(scan(n).time_ns), scan(n).truth));
        chains.scan(&work);
    }
    let own = json!(chains.told(Some(0.5)));
    let errors = |told: &Value| -> Vec<Value> {
        let rows = told["rows"].as_array().expect("rows").iter();
        rows.map(|r| json!([r["tolerance_m"], r["rmse_60s_m"], r["apart_60s_m"], r["skipped"]]))
            .collect()
    };
    assert_eq!((errors(&found), &found["ghosts_m"]), (errors(&own), &own["ghosts_m"]));
    assert!(own["rows"].as_array().is_some_and(|r| r.len() == 7 && r[0]["plots"] != 0), "{own}");
}

#[test]
fn what_cannot_be_compared_says_why() {
    let why = |file: &Path, compared| {
        let (_dial, told) = begin(file, 5, compared);
        let found = end(&told);
        assert_eq!(found["rows"], json!([]));
        found["why_not"].as_str().unwrap_or("").to_owned()
    };
    let rungs = || Compared::Rungs(None);
    let folder = Folder::new();
    let bare = (1..=9).map(|n| ScanReport { plots: Vec::new(), ..scan(n) });
    let file = kept(&folder, RunInfo::default(), bare);
    assert_eq!(why(&file, rungs()), NO_PLOTS);
    let missing = folder.0.join("gone.sqlite");
    assert!(!why(&missing, rungs()).is_empty());
    let folder = Folder::new();
    let mut unsure = scan(4);
    unsure.plots[0].ellipse = [f64::NAN; 4];
    let file = kept(
        &folder,
        RunInfo::default(),
        (1..=9).map(|n| if n == 4 { unsure.clone() } else { scan(n) }),
    );
    assert!(why(&file, rungs()).contains("earlier version"));
    // A fork tells its filter; with other sensors it is another truth of effects.
    let fork = || RunInfo { fork: Some("parent".to_owned()), ..RunInfo::default() };
    let folder = Folder::new();
    let file = kept(&folder, fork(), (1..=9).map(scan));
    assert!(why(&file, rungs()).contains("fork its parent again"));
    let database = rusqlite::Connection::open(&file).expect("a database");
    let set = |changes: &str| {
        let sql = "INSERT OR REPLACE INTO run VALUES (?1, ?2)";
        database.execute(sql, [kept_scene::CHANGES, changes]).expect("written");
    };
    set(r#"[["tracking.filter","abg"],["weather.rain_factor","2"]]"#);
    assert!(why(&file, Compared::Tolerances(None)).contains("weather.rain_factor to 2"));
    let (_dial, told) = begin(&file, 5, rungs());
    let own: Vec<_> = end(&told)["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter(|r| r["chosen"] == true)
        .cloned()
        .collect();
    assert_eq!((own.len(), &own[0]["rung"]), (1, &json!("abg")));
}
