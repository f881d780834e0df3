use super::*;
use crate::runtime::messages::Operation;
use crate::viewer_logger::history::History;
use crate::viewer_logger::log::Log;
use crate::viewer_logger::log::tests::Folder;
use crate::viewer_logger::picture::{AirportMap, RunInfo};
use crate::viewer_logger::said::Topic;
use crate::viewer_logger::tests::{scan, weather};
use models::control::alert::{AlertKind, Change, Stage};
use models::frames::Point2;
use models::plot::SensorKind;

/// Scans with everything that a frame may hold, wild figures included.
fn wild(n: u64) -> ScanReport {
    let mut report = scan(n);
    if n.is_multiple_of(3) {
        report.tracks[0].lag = None;
        report.tracks[0].callsign.clear();
        report.tracks[0].assumed = "GUESS1".to_owned();
        report.tracks[0].label_p = Some(0.7);
        report.tracks[0].address = Some(0x00fe_dcba);
        report.tracks[0].existence_p = Some(0.996);
        report.tracks[0].unresolved = true;
        report.tracks[0].velocity_mps = [-0.0, f64::NAN];
        report.tracks[0].altitude_m = Some(-0.0);
        report.tracks[0].first = true;
    }
    let mut second = report.tracks[0].clone();
    second.number = 1;
    second.position_m = Point2::new(f64::INFINITY, 1e300);
    second.callsign = "ÄÖÜ-emoji-🛫-long".to_owned();
    report.tracks.insert(usize::from(n.is_multiple_of(2)), second);
    let mut outsider = report.truth[0].clone();
    outsider.id = [65535, 65535, 65535];
    outsider.callsign = "X".to_owned();
    outsider.ours = false;
    outsider.aircraft = false;
    outsider.heading_rad = 0.1 + 0.2;
    outsider.track = (n > 4).then_some((1, 2.5));
    report.truth.insert(0, outsider);
    let mut alarm = report.plots[0].clone();
    alarm.cause.clear();
    alarm.truth_m = None;
    alarm.track = None;
    alarm.polar = None;
    alarm.scnr_db = None;
    alarm.sequence = 9;
    alarm.kind = SensorKind::Adsb;
    alarm.identity = "4b1234".to_owned();
    alarm.sensor = 0;
    alarm.effects.clear();
    report.plots.push(alarm);
    report
}

fn kept(reports: &[ScanReport]) -> (Folder, PathBuf) {
    let folder = Folder::new();
    let file = folder.0.join("run.sqlite");
    let mut log =
        Log::create(&file, &RunInfo::default(), &AirportMap::default()).expect("a new log");
    reports.iter().for_each(|r| log.scan(r).expect("written"));
    log.weather(&weather(4.5)).expect("written");
    log.close().expect("closed");
    (folder, file)
}

#[test]
fn a_frame_out_of_the_log_is_the_live_frame_octet_by_octet() {
    let reports: Vec<ScanReport> = (1..=40).filter(|n| *n != 17).map(wild).collect(); // one was lost
    let (_folder, file) = kept(&reports);
    let archive = Archive::open(&file).expect("opened");
    let mut history = History::new(1 << 24);
    for report in &reports {
        history.push(report);
    }
    for asked in 0..=42 {
        assert_eq!(archive.nearest(asked), history.nearest(asked), "scan {asked}");
        assert_eq!(archive.message(asked), history.message(asked), "scan {asked}");
        for number in [1, 4, 9] {
            assert_eq!(archive.effects(number, asked), history.effects(number, asked));
        }
    }
    for number in [1, 4, 9] {
        assert_eq!(archive.curve(number, 0, u64::MAX), history.curve(number, 0, u64::MAX));
        assert_eq!(archive.curve(number, 12, 20), history.curve(number, 12, 20));
    }
    assert_eq!((archive.range(), archive.times()), (history.range(), history.times()));
    assert_eq!(archive.sums(), history.sums());
    assert_eq!(archive.events()[1..], *history.events(), "but for the weather");
    assert_eq!(archive.events()[0].kind, "weather");
}

#[test]
fn what_was_noted_of_tracks_is_in_the_frame_out_of_the_log_too() {
    use super::super::frame::{Note, Noted};
    let folder = Folder::new();
    let file = folder.0.join("run.sqlite");
    let mut log =
        Log::create(&file, &RunInfo::default(), &AirportMap::default()).expect("a new log");
    let mut history = History::new(1 << 24);
    let noted = |n: u64| -> Noted {
        let note = Note {
            doing: n as u8,
            derived: n.is_multiple_of(2),
            alert: (n % 3) as u8,
            cleared: 13,
        };
        [(4, note), (9, Note { cleared: n as u8, ..note })].into()
    };
    for n in 1..=12 {
        log.scan_noted(&wild(n), &noted(n)).expect("written");
        history.push_noted(&wild(n), &noted(n));
    }
    log.close().expect("closed");
    let archive = Archive::open(&file).expect("opened");
    for n in 1..=12 {
        assert_eq!(archive.noted(n).expect("read"), noted(n));
        assert_eq!(archive.message(n), history.message(n), "scan {n}");
    }
    // A log of before opens with what it has.
    rusqlite::Connection::open(&file)
        .and_then(|db| db.execute_batch("DROP TABLE track_notes"))
        .expect("dropped");
    let old = Archive::open(&file).expect("opened");
    assert!(old.noted(3).expect("read").is_empty() && old.message(3).is_some());
    assert_ne!(old.message(3), history.message(3));
}

#[test]
fn a_report_out_of_the_log_is_what_the_tracker_was_given() {
    let report = scan(3);
    let (_folder, file) = kept(std::slice::from_ref(&report));
    let read = Archive::open(&file).expect("opened").report(3).expect("read").expect("there");
    assert_eq!(read, report);
}

#[test]
fn a_log_that_grows_is_followed_and_a_later_version_is_refused() {
    let folder = Folder::new();
    let file = folder.0.join("run.sqlite");
    let mut log =
        Log::create(&file, &RunInfo::default(), &AirportMap::default()).expect("a new log");
    log.scan(&wild(1)).expect("written");
    let mut archive = Archive::open(&file).expect("opened");
    assert_eq!(archive.range(), Some((1, 1)));
    assert!(!archive.follow().expect("read"));
    log.scan(&wild(2)).expect("written");
    assert!(archive.follow().expect("read"));
    assert_eq!(archive.range(), Some((1, 2)));
    assert_eq!(archive.message(2).map(|m| m[5]), Some(1), "the newest");
    assert_eq!(archive.message(1).map(|m| m[5]), Some(0), "and no longer");
    drop(archive);
    log.close().expect("closed");
    Connection::open(&file)
        .and_then(|db| db.pragma_update(None, "user_version", 99))
        .expect("written");
    let refused = Archive::open(&file).expect_err("refused").to_string();
    assert!(refused.contains("later version"), "{refused}");
}

#[test]
fn a_database_of_the_first_version_opens_with_what_it_has() {
    let (_folder, file) = kept(&[scan(1), scan(2)]);
    let database = Connection::open(&file).expect("opened");
    database
        .execute_batch(
            "PRAGMA user_version = 0; DROP VIEW entities; DROP TABLE events; DROP TABLE files;
             DELETE FROM run WHERE name = 'map_json';
             ALTER TABLE truth DROP COLUMN heading_rad; ALTER TABLE truth DROP COLUMN length_m;
             ALTER TABLE truth DROP COLUMN place; ALTER TABLE tracks DROP COLUMN designator;
             ALTER TABLE plots DROP COLUMN azimuth_rad; ALTER TABLE plots DROP COLUMN place;
             ALTER TABLE scans DROP COLUMN worst_error_m;",
        )
        .expect("made old");
    drop(database);
    let archive = Archive::open(&file).expect("opened");
    let report = archive.report(2).expect("read").expect("there");
    assert_eq!(report.tracks[0].position_m, scan(2).tracks[0].position_m);
    assert!((report.truth[0].heading_rad - 1.5).abs() < 1e-9);
    assert!(archive.message(1).is_some() && archive.events().is_empty());
    assert!(crate::viewer_logger::opened::viewer(&file).is_ok());
}

#[test]
fn the_cache_drops_what_was_longest_unused() {
    let mut cache = Cache::default();
    let big: Arc<[u8]> = vec![0; CACHE_OCTETS / 4].into();
    for scan in 1..=4 {
        cache.keep(scan, Arc::clone(&big));
    }
    assert!(cache.get(1).is_some());
    cache.keep(5, big);
    assert!(cache.get(2).is_none() && cache.get(1).is_some() && cache.get(5).is_some());
    assert_eq!(cache.kept.len(), cache.used.len());
    assert!(cache.octets <= CACHE_OCTETS);
}

#[test]
fn what_was_said_beside_the_scans_is_read_as_it_was_at_each_time() {
    use crate::runtime::messages::AlertMessage;
    let folder = Folder::new();
    let file = folder.0.join("run.sqlite");
    let mut log =
        Log::create(&file, &RunInfo::default(), &AirportMap::default()).expect("a new log");
    (1..=6).for_each(|n| log.scan(&scan(n)).expect("written"));
    let traffic =
        |s: u32| format!("{{\"time_s\":{s}.0,\"movers\":[],\"text\":\"{}\"}}", "Ä".repeat(500));
    log.said(Topic::Traffic, &traffic(2)).expect("written");
    log.said(Topic::Traffic, &traffic(4)).expect("written");
    log.said(Topic::Lights, "{\"time_s\":1.0,\"bars\":[]}").expect("written");
    log.said(Topic::Lights, "no JSON").expect("left out");
    let alert = |change: Change, stage: Stage, s: i64| AlertMessage {
        run: 1,
        time_ns: s * 1_000_000_000,
        change,
        id: 3,
        kind: AlertKind::StopBar,
        stage,
        subjects: "SWR1".into(),
        since_ns: 0,
        asterix: 16,
        place_m: Point2::new(5.0, 6.0),
        number: 0,
    };
    log.alerts(&[alert(Change::Raised, Stage::Information, 2)]).expect("written");
    log.alerts(&[alert(Change::Changed, Stage::Alarm, 3)]).expect("written");
    log.alerts(&[alert(Change::Ended, Stage::Alarm, 5)]).expect("written");
    let seen = Operation {
        time_ns: 3,
        source: "page".into(),
        command: "acknowledge 3".into(),
        ok: true,
        ..Operation::default()
    };
    log.operation(&seen, 1).expect("written");
    log.close().expect("closed");
    let archive = Archive::open(&file).expect("opened");
    let said = |topic, s: i64| archive.said(topic, s * 1_000_000_000).map(|t| t.to_string());
    assert_eq!(said(Topic::Traffic, 1), None);
    assert_eq!(said(Topic::Traffic, 3), Some(traffic(2)));
    assert_eq!(said(Topic::Traffic, 14), Some(traffic(4)));
    assert_eq!(said(Topic::Traffic, 15), None, "nothing was heard for ten seconds");
    assert!(said(Topic::Lights, 1_000_000).is_some());
    let viewer = crate::viewer_logger::opened::viewer(&file).expect("opened");
    let at = |s: i64| viewer.alerts_at(s * 1_000_000_000);
    assert_eq!(at(1)["open"], json!([]));
    assert_eq!(
        (&at(2)["open"][0]["stage"], &at(4)["open"][0]["stage"]),
        (&json!("information"), &json!("alarm"))
    );
    assert_eq!(at(4)["open"][0]["acknowledged"], "page");
    assert_eq!((&at(5)["open"], &at(5)["ended"][0]["end_s"]), (&json!([]), &json!(5.0)));
    let events: Vec<_> = viewer.events().into_iter().filter(|e| e.kind == "alert").collect();
    assert_eq!((events.len(), &events[0].text[..]), (1, "information STOPBAR: SWR1"));
    // A browser that looks back is sent the state of then, and told when there is none any more.
    let mut session = crate::viewer_logger::Session::default();
    let mut sent = |scan: u64| -> Vec<serde_json::Value> {
        session.on_message(&format!("{{\"type\":\"show\",\"scan\":{scan}}}"));
        let texts = session.poll(&viewer).into_iter().filter_map(|m| match m {
            crate::viewer_logger::Outgoing::Text(text) => serde_json::from_str(&text).ok(),
            crate::viewer_logger::Outgoing::Binary(_) => None,
        });
        texts
            .filter(|m: &serde_json::Value| {
                ["traffic", "lights", "alerts"].iter().any(|t| m["type"] == *t)
            })
            .collect()
    };
    let kinds = |out: &[serde_json::Value]| {
        out.iter().map(|m| m["type"].as_str().unwrap_or("").to_owned()).collect::<Vec<_>>()
    };
    let first = sent(3);
    assert_eq!(kinds(&first), ["traffic", "lights", "alerts"]);
    assert_eq!(first[0]["state"]["time_s"], 2.0);
    assert!(sent(3).is_empty(), "once");
    let back = sent(1);
    assert_eq!(kinds(&back), ["traffic", "alerts"], "the bars are the same");
    assert_eq!((&back[0]["state"], &back[1]["open"]), (&serde_json::Value::Null, &json!([])));
}
