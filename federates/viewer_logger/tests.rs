use super::beside::{Beside, RungRow};
use super::*;
use crate::runtime::messages::{Command, LagMessage, PlotMessage, TrackMessage, TruthMessage};
use models::flight_list::FlightList;
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::{Point2, Point3};
use models::fusion::TrackingConfig;
use models::plot::SensorKind;
use models::track::{TrackStatus, TrackType};

/// Scan `n` at `n` seconds: one entity at 10 n metres, its track 0.1 n metres off, its plot 3 m off.
pub(super) fn scan(n: u64) -> ScanReport {
    let time_ns = 1_000_000_000 * n as i64;
    let x_m = 10.0 * n as f64;
    let truth = TruthMessage {
        id: [1, 2, 3],
        callsign: "SWR1".to_owned(),
        address: None,
        type_designator: "A320".to_owned(),
        aircraft: true,
        size_m: [37.6, 34.1],
        position_m: Point3::new(x_m, 50.0, 0.0),
        velocity_mps: [10.0, 0.0, 0.0],
        heading_rad: 1.5,
        ours: true,
        track: Some((4, 0.1 * n as f64)),
    };
    let plot = PlotMessage {
        sensor: 1,
        kind: SensorKind::Asde,
        time_ns: time_ns - 250_000_000,
        position_m: Point2::new(x_m, 50.0),
        cov_m2: [4.0, 0.0, 9.0],
        ellipse: [0.0, 1.0, 9.0, 4.0],
        altitude_m: None,
        velocity_mps: None,
        polar: Some([1200.0, 0.4, 2.0, 0.001]),
        scnr_db: Some(12.0),
        identity: String::new(),
        address: None,
        cause: "SWR1".to_owned(),
        truth_m: Some(Point2::new(x_m, 53.0)),
        sequence: 0,
        track: Some(4),
        effects: vec![("rain attenuation".to_owned(), -3.1, "dB".to_owned())],
    };
    let track = TrackMessage {
        number: 4,
        track_type: TrackType::Aircraft,
        status: TrackStatus::Confirmed,
        first: false,
        time_ns,
        position_m: Point2::new(x_m, 50.0),
        velocity_mps: [10.0, 0.0],
        cov_m2: [4.0, 0.0, 5.0],
        acceleration_ms2: [0.0; 2],
        velocity_cov_m2s2: [1.0, 0.0, 1.0],
        altitude_m: None,
        altitude_ns: None,
        heading_rad: 0.5,
        manoeuvre: false,
        callsign: "SWR1".to_owned(),
        type_designator: "A320".to_owned(),
        wake: Some(WakeCategory::Medium),
        movement: Some(MovementKind::Arrival),
        runway_stand: "28/E_19".to_owned(),
        ctd_eta_ns: None,
        routing: Vec::new(),
        assumed: String::new(),
        label_p: None,
        address: None,
        existence_p: None,
        unresolved: false,
        lag: Some(LagMessage {
            time_ns: time_ns - 1_000_000_000,
            position_m: Point2::new(7.0, 8.0),
            cov_m2: [1.0, 0.1, 2.0],
            coasted: false,
            error_m: Some(1.5),
        }),
    };
    ScanReport {
        run: 1,
        scan: n,
        time_ns,
        tracks: vec![track],
        plots: vec![plot],
        truth: vec![truth],
        measures: vec![("pd_asde".to_owned(), 0.98)],
        plan: Vec::new(),
        took_us: 800,
    }
}

/// A departure that nobody has told anything of.
pub(super) fn flight() -> FlightNotice {
    FlightNotice {
        callsign: "SWR1".to_owned(),
        address: None,
        type_designator: "A320".to_owned(),
        wake: None,
        movement: MovementKind::Departure,
        runway: "28".to_owned(),
        stand: "E_19".to_owned(),
        stand_m: None,
        eta_ctd_ns: 0,
        off_block_ns: None,
        routing: Vec::new(),
    }
}

pub(super) fn weather(rain_mm_per_h: f64) -> WeatherNotice {
    WeatherNotice {
        from_ns: 0,
        rain_mm_per_h,
        visibility_m: f64::INFINITY,
        temperature_k: 288.15,
        pressure_hpa: 1013.25,
        vapour_g_per_m3: 7.5,
        wind_mps: [0.0, 0.0],
        film_mm: 0.0,
        cells: vec![[100.0, 200.0, 300.0, 40.0]],
    }
}

fn u32_at(octets: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(octets[at..at + 4].try_into().expect("four octets"))
}

fn f64_at(octets: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(octets[at..at + 8].try_into().expect("eight octets"))
}

fn texts(out: &[Outgoing]) -> Vec<Value> {
    out.iter()
        .filter_map(|m| match m {
            Outgoing::Text(text) => Some(serde_json::from_str(text).expect("JSON")),
            Outgoing::Binary(_) => None,
        })
        .collect()
}

fn binary(out: &[Outgoing]) -> Option<&[u8]> {
    out.iter().find_map(|m| match m {
        Outgoing::Binary(octets) => Some(&octets[..]),
        Outgoing::Text(_) => None,
    })
}

#[test]
fn a_scan_is_laid_out_as_the_page_reads_it() {
    let octets = frame::with_trails(&frame::encode(&scan(3)), true, &[(4, vec![[20.0, 50.0]])]);
    assert_eq!(&octets[..6], b"SEED\x03\x01");
    assert_eq!([8, 24, 28, 32, 36].map(|at| u32_at(&octets, at)), [3, 1, 1, 1, 1]);
    assert_eq!(&octets[16..24], 3_000_000_000_i64.to_le_bytes());
    let track = &octets[frame::HEADER..];
    assert_eq!(u32_at(track, 8), 0, "index of its truth");
    assert_eq!([f64_at(track, 56), f64_at(track, 64)], [30.0, 50.0]);
    let truth = &track[frame::TRACK..];
    assert_eq!(&truth[8..13], b"SWR1\0");
    assert_eq!(f64_at(truth, 32), 30.0);
    assert_eq!(u32_at(truth, 72), 4, "number of its track");
    let plot = &truth[frame::TRUTH..];
    assert_eq!(f32::from_bits(u32_at(plot, 32)), 9.0, "variance to the north");
    assert_eq!(f32::from_bits(u32_at(plot, 40)), 0.25, "age");
    assert_eq!(f32::from_bits(u32_at(plot, 44)), 3.0, "error");
    assert_eq!(&plot[frame::PLOT..][..4], [4, 0, 1, 0], "trail of track 4 with one point");
    assert_eq!(plot.len(), frame::PLOT + 4 + 8);
}

#[test]
fn scrubbing_back_shows_the_scan_that_was_and_never_a_later_one() {
    let mut history = History::new(1 << 20);
    for n in [1, 2, 3, 5, 6] {
        history.push(&scan(n));
    }
    for (asked, shown) in [(0, 1), (1, 1), (3, 3), (4, 3), (5, 5), (99, 6)] {
        assert_eq!(history.nearest(asked), Some(shown), "asked for {asked}");
        let message = history.message(asked).expect("kept");
        assert_eq!(u64::from(u32_at(&message, 8)), shown);
        assert_eq!(message[5] == 1, shown == 6, "the flag of the newest scan");
    }
    let message = history.message(5).expect("kept");
    let trail = &message[message.len() - 3 * 8..];
    assert_eq!(f32::from_bits(u32_at(trail, 0)), 30.0, "newest dot first: scan 3");
}

#[test]
fn a_restarted_run_begins_the_history_anew() {
    let mut viewer = Viewer::new(1 << 20);
    let mut session = Session::default();
    (1..=5).for_each(|n| viewer.on_scan(&scan(n)));
    session.on_message(r#"{"type":"show","scan":2}"#);
    let out = session.poll(&viewer);
    assert_eq!(u32_at(binary(&out).expect("scan"), 8), 2);
    viewer.on_scan(&scan(1));
    assert_eq!(viewer.source().range(), Some((1, 1)));
    let out = session.poll(&viewer);
    assert_eq!(texts(&out)[0]["type"], "new_run");
    assert_eq!(u32_at(binary(&out).expect("scan"), 8), 1, "back to the newest");
}

#[test]
fn recordings_without_a_scene_lie_beside_each_other_by_place_and_clock() {
    let recording = |id: &str, start_utc_ns: i64, reference_deg: [f64; 2]| {
        let mut viewer = Viewer::new(1 << 20);
        viewer.set_id(id);
        let info = RunInfo { start_utc_ns, ..RunInfo::default() };
        viewer.on_scene(&info, &AirportMap { reference_deg, ..AirportMap::default() });
        (1..=9).for_each(|n| viewer.on_scan(&scan(n)));
        viewer
    };
    let s = 1_000_000_000;
    let (zurich, runs) = ([47.458, 8.548], ["a", "later", "elsewhere", "unknown"]);
    let runs = [
        recording(runs[0], 7, zurich),
        recording(runs[1], 7 + 2 * s, [47.458, 8.548_000_1]),
        recording(runs[2], 7, [47.458, 8.549]),
        recording(runs[3], 7, [0.0, 0.0]),
    ];
    let all: Vec<&Viewer> = runs.iter().collect();
    let mut session = Session::default();
    let mut open = |ids: &[&str]| {
        let ids: Vec<String> = ids.iter().map(|id| (*id).to_owned()).collect();
        session.open(&all, &ids).map(|()| {
            session.on_message(r#"{"type":"show","scan":5}"#);
            session.poll_runs(&all)
        })
    };
    let refused = open(&["a", "elsewhere"]).expect_err("another origin");
    assert!(refused.contains("elsewhere") && refused.contains("--scene"), "{refused}");
    let out = open(&["a", "later"]).expect("one origin");
    let scans: Vec<u32> = out
        .iter()
        .filter_map(|m| match m {
            Outgoing::Binary(octets) => Some(u32_at(octets, 8)),
            Outgoing::Text(_) => None,
        })
        .collect();
    assert_eq!(scans, [5, 3], "by the clock, which began two seconds later");
    assert!(open(&["a", "unknown"]).is_ok(), "of a log that does not say it");
}

#[test]
fn of_too_many_events_those_that_somebody_is_to_look_at_and_the_newest_are_marked() {
    let mut viewer = Viewer::new(1 << 24);
    viewer.on_scan(&scan(1));
    let event = |time_ns: i64, kind: &str| Event {
        time_ns,
        kind: kind.to_owned(),
        subject: String::new(),
        text: String::new(),
    };
    let grave = ["alert", "fault", "operator"].map(|kind| event(1, kind));
    viewer.on_events(&grave);
    viewer.on_events(&(2..=2500).map(|n| event(n, "lost")).collect::<Vec<_>>());
    let marked = |viewer: &Viewer| {
        let told = texts(&Session::default().strip(&[viewer], 0.0, 10.0, 5)).pop().expect("events");
        let events = told["events"].as_array().expect("a list").clone();
        let times: Vec<i64> = events.iter().filter_map(|e| e["time_ns"].as_i64()).collect();
        (times, told["more"].as_u64().expect("a number"))
    };
    let (times, more) = marked(&viewer);
    assert_eq!((times.len(), more), (2000, 502));
    assert_eq!(times[..4], [1, 1, 1, 504], "and of the others the newest, in the order of time");
    assert!(times.is_sorted() && times.ends_with(&[2499, 2500]));
    // What is kept of a long run ends with the run, not after so many events.
    viewer.on_events(&(2501..=25_000).map(|n| event(n, "lost")).collect::<Vec<_>>());
    assert_eq!(viewer.source().events().len(), 20_000);
    assert!(marked(&viewer).0.ends_with(&[24_999, 25_000]));
}

#[test]
fn another_first_run_is_shown_at_the_time_that_was_looked_back_to() {
    let run = |id: &str, start_utc_ns: i64, scans: std::ops::RangeInclusive<u64>| {
        let mut viewer = Viewer::new(1 << 20);
        viewer.set_id(id);
        let scene_digest = format!("{start_utc_ns:016x}");
        let info = RunInfo { start_utc_ns, scene_digest, ..RunInfo::default() };
        viewer.on_scene(&info, &AirportMap::default());
        scans.for_each(|n| viewer.on_scan(&scan(n)));
        viewer
    };
    let s = 1_000_000_000;
    // One scene; one that began two seconds later by the clock; one that has an end before.
    let runs = [
        run("a", 7, 1..=9),
        run("b", 7, 1..=9),
        run("later", 7 + 2 * s, 1..=9),
        run("short", 7, 1..=3),
    ];
    let all: Vec<&Viewer> = runs.iter().collect();
    for (to, looked_back, newest) in [("b", 5, 9), ("later", 3, 9), ("short", 3, 3)] {
        for (asked, expected) in [("5", looked_back), ("null", newest)] {
            let mut session = Session::default();
            session.on_message(&format!(r#"{{"type":"show","scan":{asked}}}"#));
            session.poll_runs(&all);
            session.open(&all, &[to.to_owned()]).expect("there");
            let out = session.poll_runs(&all);
            assert_eq!(u32_at(binary(&out).expect("scan"), 8), expected, "{to}, {asked}");
        }
    }
}

#[test]
fn the_time_line_marks_what_operators_did_in_this_run() {
    let mut viewer = Viewer::new(1 << 20);
    let freeze = |time_ns: i64| Operation {
        time_ns,
        command: "freeze".to_owned(),
        ok: true,
        ..Operation::default()
    };
    let marked = |viewer: &Viewer| viewer.events().iter().map(|e| e.time_ns).collect::<Vec<_>>();
    viewer.on_state(&RunState { run: 1, ..RunState::default() });
    (1..=3).for_each(|n| viewer.on_operation(freeze(n)));
    assert_eq!(marked(&viewer), [1, 2, 3]);
    viewer.on_state(&RunState { run: 2, ..RunState::default() });
    viewer.on_operation(freeze(9));
    assert_eq!(marked(&viewer), [9]);
    // The oldest go, those of the run before first.
    (0..OPERATIONS as i64 - 3).for_each(|n| viewer.on_operation(freeze(10 + n)));
    assert_eq!(marked(&viewer).len(), OPERATIONS - 2);
    let operations = &viewer.topics["operations"].1;
    assert_eq!(operations.matches("freeze").count(), OPERATIONS, "the list has all");
}

#[test]
fn the_history_keeps_to_its_limit_and_says_what_it_dropped() {
    let mut history = History::new(20_000);
    for n in 1..=200 {
        history.push(&scan(n));
    }
    let (first, last) = history.range().expect("kept");
    assert!(first > 1 && last == 200, "{first} to {last}");
    assert_eq!(history.dropped(), first - 1);
}

#[test]
fn a_curve_follows_the_entity_and_arrives_without_gaps() {
    let mut viewer = Viewer::new(1 << 20);
    let mut session = Session::default();
    let mut other = scan(1);
    other.truth[0].id = [9, 9, 9]; // the number served another entity before
    viewer.on_scan(&other);
    (2..=4).for_each(|n| viewer.on_scan(&scan(n)));
    session.on_message(r#"{"type":"select","track":4}"#);
    let first = texts(&session.poll(&viewer)).pop().expect("curve");
    (5..=9).for_each(|n| viewer.on_scan(&scan(n)));
    let second = texts(&session.poll(&viewer)).pop().expect("curve");
    let scans = |curve: &Value| -> Vec<u64> {
        let points = curve["points"].as_array().expect("points");
        points.iter().map(|p| p["scan"].as_u64().expect("number")).collect()
    };
    assert_eq!(scans(&first), [2, 3, 4]);
    assert_eq!((first["reset"].as_bool(), second["reset"].as_bool()), (Some(true), Some(false)));
    assert_eq!(scans(&second), [5, 6, 7, 8, 9]);
    let point = &first["points"][2];
    assert!((point["error_m"].as_f64().expect("error") - 0.4).abs() < 1e-6);
    assert!((point["claimed_m"].as_f64().expect("claim") - 3.0).abs() < 1e-6);
    assert_eq!(point["plots_m"]["asde"].as_f64(), Some(3.0));
}

#[test]
fn the_plots_of_the_selected_target_say_what_every_effect_did() {
    let mut viewer = Viewer::new(1 << 20);
    let mut session = Session::default();
    (1..=4).for_each(|n| viewer.on_scan(&scan(n)));
    let explained = |session: &mut Session| {
        let out = texts(&session.poll(&viewer));
        out.into_iter().find(|m| m["type"] == "effects")
    };
    assert_eq!(explained(&mut session), None, "nothing is selected");
    session.on_message(r#"{"type":"select","track":4}"#);
    let now = explained(&mut session).expect("explained");
    assert_eq!((now["scan"].as_u64(), now["track"].as_u64()), (Some(4), Some(4)));
    assert_eq!(now["plots"][0]["effects"][0], json!(["rain attenuation", -3.1, "dB"]));
    assert_eq!(now["plots"][0]["error_m"].as_f64(), Some(3.0));
    assert_eq!(explained(&mut session), None, "once");
    session.on_message(r#"{"type":"show","scan":2}"#);
    assert_eq!(explained(&mut session).expect("explained")["scan"], 2);
    session.on_message(r#"{"type":"select","track":5}"#);
    assert_eq!(explained(&mut session).expect("answered")["plots"], json!([]));
}

#[test]
fn all_rungs_see_the_plots_of_the_run_and_only_when_asked() {
    let mut beside = Beside::new(&TrackingConfig::paper());
    let names = |rows: &[RungRow]| rows.iter().map(|r| r.rung.clone()).collect::<Vec<_>>();
    let rows = beside.rows();
    assert_eq!(names(&rows).len(), 14, "all but the one that needs a map: {rows:?}");
    assert_eq!(names(&rows)[..3], ["abg", "ca3", "ca3-ud"]);
    let chosen: Vec<_> = rows.iter().filter(|r| r.chosen).map(|r| &r.rung[..]).collect();
    assert_eq!(chosen, ["ca3"]);
    beside.ghost(Some("imm3"));
    assert_eq!(rows[0].rmse_m, None, "nothing was seen yet");
    (1..=12).for_each(|n| beside.scan(&scan(n), &FlightList::default()));
    for row in beside.rows() {
        assert_eq!((row.tracks, row.raw_rmse_m), (1, Some(3.0)), "{row:?}");
        assert!(row.rmse_m.is_some_and(|e| e < 6.0), "{row:?}");
        assert!(row.rmse_now_m.is_some() && row.us_per_track.is_some_and(|us| us > 0.0), "{row:?}");
        assert_eq!(row.rmse_60s_m, row.rmse_m, "twelve seconds are within the last minute");
    }
    assert_eq!(beside.ghosts_m().len(), 1);
    assert!((beside.ghosts_m()[0][0] - 120.0).abs() < 10.0, "{:?}", beside.ghosts_m());
    beside.ghost(None);
    assert!(beside.ghosts_m().is_empty());
    // An error that lies more than a minute back is in the sum and not in the minute.
    (13..=80).for_each(|n| beside.scan(&scan(n), &FlightList::default()));
    let row = beside.rows().into_iter().find(|r| r.chosen).expect("the run's own");
    assert!(row.plots > 70 && row.rmse_60s_m != row.rmse_m, "{row:?}");
    let mut viewer = Viewer::new(1 << 20);
    let mut session = Session::default();
    assert_eq!(session.on_message(r#"{"type":"compare","on":true}"#), Asked::Compare(true, None));
    viewer.compare(true, None);
    viewer.on_rungs(&beside.rows(), &[], false);
    let rows = |sent: Vec<serde_json::Value>| {
        sent.into_iter().find(|m| !m["rows"].is_null()).map(|m| m["rows"].clone())
    };
    let sent = rows(texts(&session.poll(&viewer))).expect("rungs");
    assert_eq!(sent[1]["chosen"], true);
    viewer.compare(false, None);
    assert_eq!(rows(texts(&session.poll(&viewer))), Some(json!([])));
}

#[test]
fn a_session_is_sent_each_last_value_once() {
    let mut viewer = Viewer::new(1 << 20);
    viewer.on_weather(&weather(0.0));
    viewer.on_weather(&WeatherNotice { from_ns: 5, ..weather(10.0) });
    let mut session = Session::default();
    // The notices of one poll, and no kind of message twice in it.
    let notices = |out: &[serde_json::Value]| {
        let kinds: std::collections::BTreeSet<_> = out.iter().map(|m| m["type"].as_str()).collect();
        assert_eq!(kinds.len(), out.len(), "{out:?}");
        out.iter().find(|m| !m["notices"].is_null()).expect("weather")["notices"].clone()
    };
    let out = notices(&texts(&session.poll(&viewer)));
    assert_eq!(out[0]["rain_mm_per_h"], 0.0);
    assert_eq!(out[1]["rain_mm_per_h"], 10.0);
    assert!(out[1]["visibility_m"].is_null(), "clear");
    viewer.on_weather(&weather(1.0));
    let again = notices(&texts(&session.poll(&viewer)));
    assert_eq!(again.as_array().map(Vec::len), Some(1), "a new run from time 0");
    assert!(session.poll(&viewer).is_empty());
}

#[test]
fn what_the_page_cannot_mean_is_refused_with_a_reason() {
    let mut session = Session::default();
    for (text, reason) in [
        ("", "EOF"),
        ("{", "EOF"),
        ("[1,2]", "invalid type"),
        (r#"{"type":"show","scan":-1}"#, "-1"),
        (r#"{"type":"select","track":70000}"#, "70000"),
        (r#"{"type":"command","id":1,"command":"explode"}"#, "not a valid command"),
        (r#"{"type":"command","id":1,"command":"rate","rate":0}"#, "outside"),
        (r#"{"type":"command","id":1,"command":"rate","rate":1e400}"#, "out of range"),
        (r#"{"type":"command","id":1,"command":"rate"}"#, "no figure"),
        (r#"{"type":"command","id":1,"command":"step","frames":0}"#, "outside"),
        (r#"{"type":"command","id":1,"command":"move","name":"external-world"}"#, "whose process"),
    ] {
        let Asked::Refused(Outgoing::Text(answer)) = session.on_message(text) else {
            panic!("{text} was taken");
        };
        assert!(answer.contains(reason), "{text}: {answer}");
    }
    for (text, words, command) in [
        (r#"{"type":"command","id":1,"command":"freeze"}"#, "freeze", Command::Freeze),
        (r#"{"type":"command","id":1,"command":"resume"}"#, "resume", Command::Start),
        (
            r#"{"type":"command","id":1,"command":"step","frames":20}"#,
            "step 20",
            Command::Step { n: 20 },
        ),
        (
            r#"{"type":"command","id":1,"command":"rate","rate":2.5}"#,
            "rate 2.5",
            Command::Rate { rate: 2.5 },
        ),
        (
            r#"{"type":"command","id":1,"command":"fast"}"#,
            "fast",
            Command::Rate { rate: f64::INFINITY },
        ),
        (
            r#"{"type":"command","id":1,"command":"move","name":"a","to":"b"}"#,
            "move a b",
            Command::Move { name: "a".into(), to: "b".into() },
        ),
    ] {
        assert_eq!(session.on_message(text), Asked::Command(1.0, words.to_owned(), command));
    }
}

#[test]
fn figures_that_are_none_do_not_stop_the_page() {
    let mut viewer = Viewer::new(1 << 20);
    let mut bad = scan(1);
    bad.truth[0].position_m = [f64::NAN; 3].into();
    bad.truth[0].track = Some((4, f64::NAN));
    bad.tracks[0].position_m[1] = f64::INFINITY;
    bad.tracks[0].cov_m2 = [f64::NAN; 3];
    bad.plots[0].cov_m2 = [f64::INFINITY, 0.0, 1.0];
    viewer.on_scan(&bad);
    let mut session = Session::default();
    session.on_message(r#"{"type":"select","track":4}"#);
    let out = session.poll(&viewer);
    assert!(binary(&out).is_some());
    assert!(texts(&out).last().expect("curve")["points"][0]["claimed_m"].is_null());
}

#[test]
fn rates_of_pdus_come_from_the_counters() {
    let mut viewer = Viewer::new(1 << 20);
    let status = |pid, pdus_in| FederateStatus {
        name: "smdfm".to_owned(),
        pid,
        pdus_in,
        ..FederateStatus::default()
    };
    let mut session = Session::default();
    let mut rate = |viewer: &Viewer| {
        texts(&session.poll(viewer)).pop().expect("federates")["federates"][0]["in_per_s"].as_f64()
    };
    viewer.on_federate(status(7, 100), 0);
    assert_eq!(rate(&viewer), None, "one reading is no rate");
    viewer.on_federate(status(7, 150), 2_000_000_000);
    assert_eq!(rate(&viewer), Some(25.0));
    viewer.on_federate(status(8, 10), 3_000_000_000);
    assert_eq!(rate(&viewer), None, "another process: its counters began anew");
}
