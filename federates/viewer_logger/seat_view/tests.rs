use super::super::tests::{scan, weather};
use super::super::{Outgoing, Session, Viewer, frame, picture, said::Topic};
use super::*;
use crate::runtime::messages::{AlertMessage, ScanReport};
use models::control::alert::{AlertKind, Change, Stage};
use models::frames::{Point2, Point3};
use serde_json::json;

/// An aircraft, a car beside it, another one behind a building, and one 3 km away; each has a track, the first one a plot.
fn busy() -> ScanReport {
    let mut all = scan(3);
    let (truth, track) = (all.truth[0].clone(), all.tracks[0].clone());
    all.truth.clear();
    all.tracks.clear();
    for (i, (callsign, at)) in [
        ("SWR1", [0.0, 0.0]),
        ("CAR1", [0.0, 300.0]),
        ("CAR2", [300.0, 0.0]),
        ("BAW2", [0.0, 3000.0]),
    ]
    .into_iter()
    .enumerate()
    {
        let number = 10 + i as u16;
        let mut t = truth.clone();
        (t.id, t.callsign, t.aircraft) = ([1, 2, number], callsign.to_owned(), i % 3 == 0);
        (t.position_m, t.track) = (Point3::new(at[0], at[1], 0.0), Some((number, 0.5)));
        all.truth.push(t);
        let mut k = track.clone();
        (k.number, k.callsign, k.position_m) = (number, callsign.to_owned(), at.into());
        all.tracks.push(k);
    }
    all.plots[0].track = Some(10);
    all
}

fn map() -> picture::AirportMap {
    let ring = vec![[100.0, -50.0], [150.0, -50.0], [150.0, 50.0], [100.0, 50.0]];
    let blocks = vec![Block { name: "pier".to_owned(), ring, height_m: 12.0 }];
    picture::AirportMap { blocks, ..picture::AirportMap::default() }
}

fn order(seat: &str, action: SeatAction) -> SeatOrder {
    SeatOrder { seat: seat.to_owned(), person: "me".to_owned(), action }
}

fn viewer(visibility_m: f64) -> Viewer {
    let mut viewer = Viewer::new(1 << 20);
    viewer.on_scene(&picture::RunInfo::default(), &map());
    viewer.on_weather(&WeatherNotice { visibility_m, cells: Vec::new(), ..weather(0.0) });
    viewer.on_scan(&busy());
    let mover = |callsign: &str| json!({"callsign": callsign, "at_m": [0, 0]});
    let movers = json!({"time_s": 3.0, "movers": [mover("SWR1"), mover("CAR2")]}).to_string();
    viewer.on_said(Topic::Traffic, &movers);
    viewer.on_said(Topic::Driven, &movers);
    viewer.on_alerts(&[AlertMessage {
        run: 1,
        time_ns: 3_000_000_000,
        change: Change::Raised,
        id: 7,
        kind: AlertKind::RunwayArrival,
        stage: Stage::Alarm,
        subjects: "CAR2 BAW2".to_owned(),
        since_ns: 3_000_000_000,
        asterix: 9,
        place_m: Point2::origin(),
        number: 1,
    }]);
    viewer
}

/// Tracks and entities by call sign, number of plots, and which entity each track follows with its error.
type Seen = (Vec<String>, Vec<String>, u32, Vec<(i32, f32)>);

/// What is in the last scan among messages.
fn seen(out: &[Outgoing]) -> Seen {
    let mut scans = out.iter().filter_map(|m| match m {
        Outgoing::Binary(octets) => Some(octets),
        Outgoing::Text(_) => None,
    });
    let octets = scans.next_back().expect("a scan");
    let word = |at: usize| u32::from_le_bytes(octets[at..at + 4].try_into().expect("four"));
    let text =
        |at: usize| String::from_utf8_lossy(&octets[at..at + 12]).trim_end_matches('\0').to_owned();
    let (tracks, truths) = (word(24) as usize, word(28) as usize);
    let at = |i: usize| frame::HEADER + i * frame::TRACK;
    let pairs = (0..tracks).map(|i| (word(at(i) + 8) as i32, f32::from_bits(word(at(i) + 92))));
    (
        (0..tracks).map(|i| text(at(i) + 12)).collect(),
        (0..truths).map(|i| text(at(tracks) + i * frame::TRUTH + 8)).collect(),
        word(32),
        pairs.collect(),
    )
}

fn all_of(out: &[Outgoing]) -> String {
    let text = |m: &Outgoing| match m {
        Outgoing::Text(text) => text.to_string(),
        Outgoing::Binary(octets) => String::from_utf8_lossy(octets).into_owned(),
    };
    out.iter().map(text).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_controller_is_sent_tracks_and_plots_and_nothing_of_the_truth() {
    let viewer = viewer(f64::INFINITY);
    let mut session = Session::default();
    let before = session.poll(&viewer);
    assert_eq!(seen(&before).1.len(), 4);
    session.on_message(r#"{"type":"select","track":10}"#);
    assert!(all_of(&session.poll(&viewer)).contains("\"effects\""));
    let told = session.sits(&order("tower 1", SeatAction::Take));
    assert!(all_of(&told).contains(r#"{"seats":["tower 1"],"type":"sees"}"#), "{told:?}");
    assert!(all_of(&told).contains(r#""points":[],"reset":true"#), "what was known of errors goes");
    let out = session.poll(&viewer);
    let (tracks, truth, plots, pairs) = seen(&out);
    assert_eq!((tracks.len(), truth.len(), plots), (4, 0, 1));
    assert!(pairs.iter().all(|(index, error)| *index == -1 && error.is_nan()), "{pairs:?}");
    assert!(!all_of(&out).contains("\"effects\"") && !all_of(&out).contains("\"curve\""));
    assert!(all_of(&out).contains("BAW2"), "traffic is a controller's");
    let [strip, _] = &session.strip(&[&viewer], 0.0, 10.0, 5)[..] else { panic!("two messages") };
    assert!(all_of(std::slice::from_ref(strip)).contains("\"worst_m\":[null,null,null,null,null]"));
    // Another action at the seat is no news; leaving gives everything back.
    assert!(session.sits(&order("tower 1", SeatAction::Here)).is_empty());
    assert!(!session.sits(&order("tower 1", SeatAction::Leave)).is_empty());
    let after = session.poll(&viewer);
    assert_eq!(seen(&after), seen(&before), "errors among it");
    assert!(all_of(&after).contains("\"effects\""));
}

#[test]
fn who_is_aboard_is_sent_himself_and_whom_he_can_see_and_no_word_of_anybody_else() {
    for (visibility_m, expected) in [
        (f64::INFINITY, vec!["SWR1", "CAR1", "BAW2"]),
        (600.0, vec!["SWR1", "CAR1"]),
        (150.0, vec!["SWR1"]),
    ] {
        let viewer = viewer(visibility_m);
        let mut session = Session::default();
        session.sits(&order("pilot SWR1", SeatAction::Take));
        let out = session.poll(&viewer);
        let (tracks, truth, plots, pairs) = seen(&out);
        assert_eq!((&tracks, &truth, plots), (&truth, &truth, 0));
        assert_eq!(truth, expected, "{visibility_m} m");
        let indices: Vec<i32> = pairs.iter().map(|p| p.0).collect();
        assert_eq!(indices, (0..truth.len() as i32).collect::<Vec<_>>(), "of those that are left");
        assert!(pairs.iter().all(|p| p.1.is_nan()));
        assert!(!all_of(&out).contains("CAR2"), "behind the pier, and in what is said");
        assert!(all_of(&out).contains(r#"[{"at_m":[0,0],"callsign":"SWR1"}]"#), "{}", all_of(&out));
    }
    // Behind the pier the aircraft is out of sight; one that is not there sees nothing; two seats see with four eyes.
    let viewer = viewer(f64::INFINITY);
    let of = |seats: &[&str]| {
        let mut session = Session::default();
        seats.iter().for_each(|seat| drop(session.sits(&order(seat, SeatAction::Take))));
        seen(&session.poll(&viewer)).1
    };
    assert_eq!(of(&["driver CAR2"]), ["CAR1", "CAR2", "BAW2"]);
    assert_eq!(of(&["driver NOBODY"]), Vec::<String>::new());
    assert_eq!(of(&["driver CAR2", "pilot SWR1"]), ["SWR1", "CAR1", "CAR2", "BAW2"]);
}

#[test]
fn a_line_over_a_roof_is_not_hidden_and_one_below_it_is() {
    let block = &map().blocks[0];
    let (near, far) = ([0.0, 0.0, 5.0], [300.0, 0.0, 5.0]);
    assert!(hides(near, far, block) && hides(far, near, block));
    assert!(!hides([0.0, 0.0, 30.0], [300.0, 0.0, 30.0], block), "over it");
    assert!(hides([0.0, 0.0, 20.0], [300.0, 0.0, 0.0], block), "lands behind it");
    assert!(!hides(near, [300.0, 200.0, 5.0], block), "past it");
    assert!(!hides(near, [90.0, 0.0, 5.0], block), "in front of it");
    let air = |rain, visibility_m| WeatherNotice {
        visibility_m,
        cells: vec![[0.0, 0.0, 10.0, 50.0]],
        ..weather(rain)
    };
    let (dry, wet) = ([99.0, 0.0, 1.0], [5.0, 0.0, 1.0]);
    assert!((sight_m(Some(&air(0.0, 1000.0)), dry, dry) - 1000.0).abs() < 0.1);
    assert!(sight_m(Some(&air(0.0, 1000.0)), wet, wet) < 600.0, "inside the cell");
    assert_eq!(sight_m(Some(&air(0.0, f64::INFINITY)), dry, dry), f64::INFINITY);
    assert_eq!(sight_m(None, [0.0; 3], [0.0; 3]), f64::INFINITY);
    // Over the cell from side to side: the air halfway counts, not that at either end.
    let other_side = [-99.0, 0.0, 1.0];
    assert!(sight_m(Some(&air(0.0, 1000.0)), dry, other_side) < 600.0, "the cell is between");
    assert!((sight_m(Some(&air(0.0, 1000.0)), wet, [5.0, 300.0, 1.0]) - 1000.0).abs() < 0.1);
}

#[test]
fn a_message_that_is_cut_anywhere_is_none_and_one_that_keeps_all_says_the_same_but_errors() {
    let whole = frame::with_trails(
        &frame::encode(&busy()),
        true,
        &[(10, vec![[1.0, 2.0]; 3]), (13, vec![[3.0, 4.0]])],
    );
    let keeps = frame::Keeps { tracks: true, plots: true, truth: vec![true; 4] };
    let same = frame::reduced(&whole, &keeps).expect("a message");
    assert_eq!(same.len(), whole.len());
    for cut in 0..whole.len() {
        assert!(frame::reduced(&whole[..cut], &keeps).is_none(), "{cut}");
    }
    let few = frame::Keeps { truth: vec![false, false, false, true], ..frame::Keeps::default() };
    let few = frame::reduced(&whole, &few).expect("a message");
    assert_eq!(
        few.len(),
        frame::HEADER + frame::TRACK + frame::TRUTH + 4 + 8,
        "with its own trail"
    );
}

#[test]
fn all_pages_of_one_person_see_from_his_seats_until_he_has_none() {
    let viewer = viewer(f64::INFINITY);
    let mut other = Session::default();
    let before = other.poll(&viewer);
    let seats = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let told = other.is_of(seats(&["tower 1"]));
    assert!(all_of(&told).contains(r#"{"seats":["tower 1"],"type":"sees"}"#), "{told:?}");
    assert_eq!(seen(&other.poll(&viewer)).1.len(), 0, "no truth on his other page");
    assert!(other.is_of(seats(&["tower 1"])).is_empty(), "no news");
    // What he took on this page is his also where nobody else knows of it.
    assert!(!other.sits(&order("pilot SWR1", SeatAction::Take)).is_empty());
    assert!(all_of(&other.is_of(seats(&[]))).contains(r#"["pilot SWR1"]"#));
    assert!(!other.sits(&order("pilot SWR1", SeatAction::Leave)).is_empty());
    assert_eq!(seen(&other.poll(&viewer)), seen(&before), "everything is back");
    assert!(other.is_of(seats(&[])).is_empty());
}

#[test]
fn a_controller_sees_out_of_the_window_whom_the_weather_lets_him_and_no_more() {
    // The highest roof is the pier's: the cab is above it.
    let cab = map().cab_m();
    let on_screen = |visibility_m: f64, eye: bool| {
        let viewer = viewer(visibility_m);
        let mut session = Session::default();
        if eye {
            session.looks_out();
        }
        session.sits(&order("tower 1", SeatAction::Take));
        let (tracks, truth, _, pairs) = seen(&session.poll(&viewer));
        assert!(pairs.iter().all(|p| p.1.is_nan()), "no errors");
        (tracks.len(), truth)
    };
    assert_eq!(on_screen(f64::INFINITY, false), (4, vec![]), "the screen has no window");
    let (tracks, clear) = on_screen(f64::INFINITY, true);
    assert!(tracks == 4 && clear.len() >= 3, "{clear:?} from {cab:?}");
    let (_, fog) = on_screen(150.0, true);
    assert!(fog.len() < clear.len(), "{fog:?}");
}

#[test]
fn the_cab_is_over_the_highest_roof_else_at_a_radar_else_in_the_middle() {
    let mut map = map();
    let top = map.blocks.iter().map(|b| b.height_m).fold(0.0, f64::max);
    assert!((map.cab_m()[2] - top - 5.0).abs() < 1e-9);
    map.blocks.clear();
    map.sensors = vec![picture::SensorSite {
        id: 1,
        name: "radar".to_owned(),
        kind: "asde".to_owned(),
        position_m: Some([7.0, 8.0]),
        range_m: None,
    }];
    assert_eq!(map.cab_m(), [7.0, 8.0, 45.0]);
    map.sensors.clear();
    map.stands = vec![
        picture::NamedPoint { name: String::new(), position_m: [0.0, 10.0] },
        picture::NamedPoint { name: String::new(), position_m: [20.0, 30.0] },
    ];
    map.runways.clear();
    assert_eq!(map.cab_m(), [10.0, 20.0, 45.0]);
    assert_eq!(picture::AirportMap::default().cab_m(), [0.0, 0.0, 45.0]);
}

#[test]
fn a_new_run_is_seen_from_the_same_seats_and_windows() {
    for (seat, eye) in [("pilot SWR1", false), ("tower 1", false), ("tower 1", true)] {
        let mut viewer = viewer(f64::INFINITY);
        let mut session = Session::default();
        if eye {
            session.looks_out();
        }
        session.sits(&order(seat, SeatAction::Take));
        // Errors, which are none, equal nothing.
        let whom = |out: &[Outgoing]| {
            let (tracks, truth, plots, pairs) = seen(out);
            (tracks, truth, plots, pairs.iter().all(|p| p.1.is_nan()))
        };
        let before = whom(&session.poll(&viewer));
        assert!(!eye || before.1.len() >= 3, "{before:?}");
        let mut again = busy();
        (again.run, again.time_ns) = (2, again.time_ns - 1_000_000_000);
        viewer.on_scan(&again);
        let out = session.poll(&viewer);
        assert!(all_of(&out).contains("new_run"));
        assert_eq!(whom(&out), before, "{seat}, eye {eye}");
    }
}

#[test]
fn no_seat_is_told_how_well_the_run_does_and_a_cockpit_no_plan_operator_or_other_trackers_tracks() {
    use crate::runtime::messages::Operation;
    let mut viewer = viewer(f64::INFINITY);
    viewer.on_plan(&[["1", "fog", "w", "b", "as decided"].map(str::to_owned)]);
    viewer.on_operation(Operation { command: "freeze".to_owned(), ..Operation::default() });
    viewer.tell("foreign", json!({"type": "foreign", "tracks": [{"callsign": "CAR2"}]}));
    viewer.tell("later", json!({"type": "later"}));
    let told = |out: &[Outgoing]| {
        let all = all_of(out);
        ["pd_asde", "as decided", "\"freeze\"", "CAR2", "\"later\"", "\"weather\"", "\"scene\""]
            .map(|what| all.contains(what))
    };
    let mut session = Session::default();
    let all = [true; 7];
    assert_eq!(told(&session.poll(&viewer)), all);
    let taken = all_of(&session.sits(&order("pilot SWR1", SeatAction::Take)));
    for gone in [r#""tracks":[]"#, r#""rows":[]"#, r#""operations":[]"#] {
        assert!(taken.contains(gone), "what was known goes: {taken}");
    }
    let aboard = session.poll(&viewer);
    assert!(all_of(&aboard).contains(r#""measures":[]"#), "{}", all_of(&aboard));
    assert_eq!(told(&aboard)[..5], [false; 5]);
    // Of a page that is opened at the seat, and of one that judges again.
    let mut fresh = Session::default();
    fresh.sits(&order("pilot SWR1", SeatAction::Take));
    assert_eq!(told(&fresh.poll(&viewer)), [false, false, false, false, false, true, true]);
    let mut tower = Session::default();
    tower.sits(&order("tower 1", SeatAction::Take));
    assert_eq!(told(&tower.poll(&viewer)), [false, true, true, true, true, true, true]);
    session.sits(&order("pilot SWR1", SeatAction::Leave));
    assert_eq!(told(&session.poll(&viewer)), [true, true, true, true, true, false, false]);
}
