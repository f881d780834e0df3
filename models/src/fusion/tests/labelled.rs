//! Labels from the flight list.

use super::*;
use crate::filter::testing::drawn;
use crate::fusion::config::SensorModel;
use crate::plot::{Callsign, Identity};
use crate::track::TrackType;

pub(super) fn entry(callsign: &str, designator: &str, movement: MovementKind) -> FlightEntry {
    FlightEntry {
        callsign: Callsign::new(callsign),
        address: None,
        type_designator: designator.to_owned(),
        wake: Some(WakeCategory::Medium),
        movement,
        runway: "28".to_owned(),
        stand: "E_19".to_owned(),
        stand_m: None,
        eta_ctd: SimTime::from_s(20.0),
        off_block: None,
        routing: vec!["A".to_owned(), "B".to_owned()],
    }
}

fn list(mut entries: Vec<FlightEntry>) -> FlightList {
    entries.sort_by_key(|e| e.callsign);
    let runway = [Point2::new(-700.0, 300.0), Point2::new(1800.0, 300.0)];
    let other = [Point2::new(-1250.0, -205.0), Point2::new(1600.0, -205.0)];
    FlightList { entries, runways: vec![("28".to_owned(), runway), ("10".to_owned(), other)] }
}

#[test]
fn two_entries_that_fit_equally_well_give_no_label() {
    let at = |name: &str| FlightEntry {
        stand_m: Some(Point2::new(420.0, 312.0)),
        off_block: Some(SimTime::from_s(100.0)),
        ..entry(name, "A320", MovementKind::Departure)
    };
    let radar = tower(4, 0.95, 0);
    let paths: Vec<Box<Path>> =
        vec![drive(Point2::new(420.0, 310.0), 0.0, 0.0, &[(1.0, 0.0, 0.0)])];
    let run = run(TrackingConfig::paper(), &radar, &paths, &list(vec![at("A1"), at("A2")]), 20);
    assert_eq!(run.last.len(), 1);
    assert!(run.last[0].label.is_none() && run.last[0].track_type == TrackType::NotAssociated);
}

#[test]
fn an_identity_labels_its_track_and_moves_with_the_nearer_one() {
    let flights = list(vec![FlightEntry {
        runway: String::new(),
        stand: String::new(),
        wake: None,
        ..entry("FOLLOW1", "FOLLOWME", MovementKind::Vehicle)
    }]);
    let paths = [drive(Point2::new(0.0, 500.0), 1.0, 10.0, &[(100.0, 0.0, 0.02)])];
    let last = followed(&paths, &flights);
    assert_eq!(last.len(), 1, "one target, one track");
    assert_eq!(last[0].track_type, TrackType::Vehicle);
    assert_eq!(last[0].altitude_m, Some(3.0));
    assert_eq!(last[0].label.as_ref().map(|l| l.runway_stand.as_str()), Some(""));
    assert_eq!(last[0].callsign(), Some(Callsign::new("FOLLOW1")));
    let truth = paths[0](30.0).expect("moves");
    assert!((last[0].position_m - truth).norm() < 2.0);
}

#[test]
fn a_target_that_tells_its_name_is_called_by_it_without_a_flight_list() {
    let paths = [drive(Point2::new(0.0, 500.0), 1.0, 10.0, &[(100.0, 0.0, 0.02)])];
    let last = followed(&paths, &FlightList::default());
    assert_eq!(last.len(), 1);
    assert_eq!((last[0].track_type, &last[0].label), (TrackType::NotAssociated, &None));
    assert_eq!(last[0].callsign(), Some(Callsign::new("FOLLOW1")));
}

#[test]
fn a_track_keeps_the_last_height_told_for_ten_seconds() {
    let path = drive(Point2::new(0.0, 500.0), 1.0, 10.0, &[(100.0, 0.0, 0.0)]);
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let flights = FlightList::default();
    let at = |t: f64| path(t).expect("moves");
    for k in 1..=40_u32 {
        let t = f64::from(k);
        let mut plots = Vec::new();
        // A radar tells none and takes none away; reports with it end with the 20th second.
        plots.push(Plot {
            identity: None,
            ..report(1, SensorKind::Asde, t - 0.05, 0, at(t - 0.05))
        });
        if k <= 20 {
            let told = report(3, SensorKind::Dgps, t - 0.2, 0, at(t - 0.2));
            plots.push(Plot { altitude_m: Some(200.0 - 4.0 * (t - 0.2)), ..told });
        }
        let tracks = tracker.scan(SimTime::from_s(t), &plots, &flights);
        // The first scans begin it.
        let Some(track) = tracks.first().filter(|_| k >= 5) else { continue };
        let told_s = f64::from(k.min(20)) - 0.2;
        let kept = t - told_s <= 10.0;
        let height_m = track.altitude_m.map(|m| (m * 1e6).round() / 1e6);
        assert_eq!(height_m, kept.then_some(200.0 - 4.0 * told_s), "{t} s");
        assert_eq!(track.altitude_at, kept.then(|| SimTime::from_s(told_s)), "{t} s");
    }
}

/// The tracks after 30 scans of a radar and of reports of the target's own, with its name.
fn followed(paths: &[Box<Path>; 1], flights: &FlightList) -> Vec<SystemTrack> {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let radar = tower(8, 0.95, 0);
    let mut last = Vec::new();
    for k in 1..=30 {
        let t = f64::from(k);
        let looked = radar.scan(k, paths);
        let mut plots: Vec<Plot> = looked.into_iter().map(|l| l.0).collect();
        plots.push(Plot {
            sensor: SensorId(3),
            kind: SensorKind::Dgps,
            time: SimTime::from_s(t - 0.1),
            sequence: 0,
            position_m: paths[0](t - 0.1).expect("moves"),
            axis: Vector2::new(0.0, 1.0),
            along_m2: 0.5,
            across_m2: 0.5,
            altitude_m: Some(3.0),
            polar: None,
            identity: Some(Identity::Callsign(Callsign::new("Follow1"))),
            scnr_db: None,
        });
        last = tracker.scan(SimTime::from_s(t), &plots, flights);
    }
    last
}

/// A report of FOLLOW1's own.
pub(super) fn report(
    sensor: u16,
    kind: SensorKind,
    t: f64,
    sequence: u32,
    position_m: Point2<f64>,
) -> Plot {
    Plot {
        sensor: SensorId(sensor),
        kind,
        time: SimTime::from_s(t),
        sequence,
        position_m,
        axis: Vector2::new(0.0, 1.0),
        along_m2: 4.0,
        across_m2: 4.0,
        altitude_m: None,
        polar: None,
        identity: Some(Identity::Callsign(Callsign::new("FOLLOW1"))),
        scnr_db: None,
    }
}

#[test]
fn one_name_is_one_track_whatever_its_reports_are_worth() {
    let path = drive(Point2::new(0.0, 500.0), 1.0, 10.0, &[(200.0, 0.0, 0.02)]);
    let paths = [path];
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let mut tracker = Tracker::new(config);
        let radar = tower(8, 0.95, 0);
        let mut most = 0;
        for k in 1..=120 {
            let t = f64::from(k);
            let at = |t: f64| paths[0](t).expect("moves");
            let mut plots: Vec<Plot> =
                radar.scan(k, &paths).into_iter().map(|looked| looked.0).collect();
            // Two in one interval from the first scan on; every seventh one far off, beside a false plot.
            let off = if k % 7 == 0 { Vector2::new(120.0, -60.0) } else { Vector2::zeros() };
            plots.push(report(5, SensorKind::Adsb, t - 0.8, 1, at(t - 0.8)));
            plots.push(report(5, SensorKind::Adsb, t - 0.3, 2, at(t - 0.3) + off));
            plots.push(report(6, SensorKind::Mlat, t - 0.5, 3, at(t - 0.5) + off * 0.9));
            if k % 7 >= 5 {
                let place = at(t) + Vector2::new(90.0, -40.0);
                plots.push(Plot { identity: None, ..report(7, SensorKind::Mlat, t, 4, place) });
            }
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            let named = tracks.iter().filter(|t| t.callsign() == Some(Callsign::new("FOLLOW1")));
            most = most.max(named.count());
            if k > 5 {
                let nearest = tracks.iter().map(|track| (track.position_m - at(t)).norm());
                assert!(nearest.fold(f64::INFINITY, f64::min) < 10.0, "scan {k}");
            }
        }
        assert_eq!(most, 1, "tracks of one name at a time");
    }
}

#[test]
fn a_nominal_delay_is_taken_off_the_reports_that_have_it() {
    let run = |known_s: f64| {
        let mut config = TrackingConfig::accurate();
        let model = SensorModel::default_of(SensorId(5), SensorKind::Adsb);
        config.sensors.push(SensorModel { latency_s: known_s, ..model });
        let mut tracker = Tracker::new(config);
        let at = |t: f64| Point2::new(40.0 * t, 0.0);
        let mut last = Vec::new();
        for k in 1..=60 {
            let t = f64::from(k);
            let plots = [report(5, SensorKind::Adsb, t - 0.2, 0, at(t - 0.2 - 0.4))];
            last = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        }
        at(60.0).x - last[0].position_m.x
    };
    assert!((run(0.0) - 16.0).abs() < 0.5, "0.4 s behind at 40 m/s: {}", run(0.0));
    assert!(run(0.4).abs() < 0.5, "{}", run(0.4));
}

/// Whose track has just ended may be seen again at once: for ten seconds nobody else is called by its name.
#[test]
fn the_line_of_a_track_that_ended_is_given_to_no_other_one_at_once() {
    let stand = Point2::new(420.0, 312.0);
    let line = FlightEntry {
        stand_m: Some(stand),
        off_block: Some(SimTime::from_s(400.0)),
        eta_ctd: SimTime::from_s(500.0),
        ..entry("DEP1", "A320", MovementKind::Departure)
    };
    let flights = list(vec![line]);
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let (mut ended, mut called) = (None, None);
    for k in 1..=120_u32 {
        let t = f64::from(k);
        // One stands at its stand, and nobody knows who it is; another one reports the name, 80 m farther, and falls silent.
        let mut plots = vec![hard_cases::plot(t - 0.4, 0, stand.x, stand.y)];
        if k <= 40 {
            let at = stand + Vector2::new(80.0, 0.0);
            let own = hard_cases::plot(t - 0.3, 1, at.x, at.y);
            let name = Some(Identity::Callsign(Callsign::new("DEP1")));
            plots.push(Plot { sensor: SensorId(3), kind: SensorKind::Adsb, identity: name, ..own });
        }
        for track in tracker.scan(SimTime::from_s(t), &plots, &flights) {
            let far = (track.position_m - stand).norm() > 40.0;
            if far && track.status == TrackStatus::Last {
                ended = Some(k);
            }
            let name = track.assumed.or(track.label.as_ref().map(|l| l.callsign));
            if !far && name.is_some() {
                called = called.or(Some(k));
            }
        }
    }
    println!("ended {ended:?}, called {called:?}");
    let (ended, called) = (ended.expect("silent"), called.expect("by its stand"));
    assert!((ended + 10..=ended + 16).contains(&called), "{ended} {called}");
}

/// A label that is given is kept where another line makes it less probable than what gives one, and taken back below four fifths: from
/// there on it is assumed only.
#[test]
fn a_given_label_is_kept_above_four_fifths_and_assumed_below() {
    let stand = Point2::new(420.0, 312.0);
    let line = |name: &str, aside_m: f64| FlightEntry {
        stand_m: Some(stand + Vector2::new(aside_m, 0.0)),
        off_block: Some(SimTime::from_s(400.0)),
        eta_ctd: SimTime::from_s(500.0),
        ..entry(name, "A320", MovementKind::Departure)
    };
    // After a minute the list brings a second departure, so far beside the stand.
    let run = |aside_m: f64| {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        let (mut before, mut last) = (None, None);
        for k in 1..=90_u32 {
            let t = f64::from(k);
            let at = stand + drawn(4, 1, 0, k.into()) * 2.5;
            let mut lines = vec![line("DEP1", 0.0)];
            lines.extend((k > 60).then(|| line("DEP2", aside_m)));
            let seen = hard_cases::plot(t - 0.4, 0, at.x, at.y);
            last = tracker.scan(SimTime::from_s(t), &[seen], &list(lines)).pop();
            if k == 60 {
                before.clone_from(&last);
            }
        }
        let (before, last) = (before.expect("stands"), last.expect("stands"));
        let given = |track: &SystemTrack| track.label.as_ref().map(|l| l.callsign);
        println!("{aside_m} m: {:?} {:?}", before.label_p, last.label_p);
        let own = Some(Callsign::new("DEP1"));
        assert!(given(&before) == own && before.label_p >= Some(0.9), "{:?}", before.label_p);
        let p = last.label_p.expect("of either");
        (given(&last) == own, last.assumed == own, p)
    };
    let (given, assumed, p) = run(38.0);
    assert!(given && !assumed && (0.8..0.9).contains(&p), "{given} {assumed} {p}");
    let (given, assumed, p) = run(20.0);
    assert!(!given && assumed && (0.55..0.78).contains(&p), "{given} {assumed} {p}");
}
