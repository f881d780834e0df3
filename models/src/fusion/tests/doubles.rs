//! Two echoes of one target, and two targets side by side.

use super::*;
use crate::filter::Gaussian;
use crate::filter::Sym2;
use crate::plot::{Callsign, Identity};

fn at(t: f64, sequence: u32, position_m: Point2<f64>) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime::from_s(t),
        sequence,
        position_m,
        axis: Vector2::new(1.0, 0.0),
        along_m2: 4.0,
        across_m2: 4.0,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

/// The younger was ended as the elder's double and born again, up to seventy times in ten minutes.
#[test]
fn vehicles_parked_side_by_side_keep_a_track_each() {
    for (name, config) in
        [("paper", TrackingConfig::paper()), ("accurate", TrackingConfig::accurate())]
    {
        for seed in [71, 72, 73] {
            let radar = tower(seed, 0.95, 1);
            let paths: Vec<Box<Path>> = [(400.0, 310.0), (411.0, 310.0), (700.0, 100.0)]
                .map(|(x, y)| drive(Point2::new(x, y), 0.0, 0.0, &[(0.1, 0.0, 0.0)]))
                .into();
            let run = run(config.clone(), &radar, &paths, &FlightList::default(), 300);
            let ended = run.tracker.statistics().merged;
            assert_eq!((ended, run.last.len()), (0, 3), "{name} {seed}: {:?}", run.numbers_near);
            // The nearest may be the other's for a scan; there are no more than two numbers.
            let mut numbers = run.numbers_near[..2].concat();
            numbers.sort_unstable();
            numbers.dedup();
            assert_eq!(numbers.len(), 2, "{name} {seed}: {:?}", run.numbers_near);
        }
    }
}

/// A car that came from elsewhere stays beside a taxiing aircraft, on the body that the aircraft's type has.
#[test]
fn a_car_that_came_to_lead_an_aircraft_keeps_its_track() {
    for base in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        for named in [false, true] {
            let mut config = base.clone();
            config.sizes.push(config::TypeSize {
                designator: "A320".to_owned(),
                length_m: 37.6,
                span_m: 34.1,
            });
            let flights = FlightList {
                entries: vec![labelled::entry("SWR8", "A320", MovementKind::Departure)],
                runways: Vec::new(),
            };
            let mut tracker = Tracker::new(config);
            let mut last = Vec::new();
            for k in 1..=120u32 {
                let t = f64::from(k);
                let mut rng = DrawKey { run_seed: 74, sensor: 1, entity: 0, scan: k.into() }
                    .rng(Purpose::Study);
                let mut error = || Vector2::from(<[f64; 2]>::from(normal_pair(&mut rng))) * 0.8;
                let aircraft = Point2::new(0.0, 8.0 * t);
                let car = Point2::new(6.0 + 150.0 * (1.0 - t / 20.0).max(0.0), 8.0 * t);
                let mut plots =
                    vec![at(t - 0.6, 0, aircraft + error()), at(t - 0.5, 1, car + error())];
                if named {
                    let mut report = at(t - 0.6, 0, aircraft + error());
                    (report.sensor, report.kind) = (SensorId(2), SensorKind::Adsb);
                    report.identity = Some(Identity::Callsign(Callsign::new("SWR8")));
                    plots.push(report);
                }
                last = tracker.scan(SimTime::from_s(t), &plots, &flights);
            }
            let found = tracker.statistics();
            assert_eq!((last.len(), found.merged, found.confirmed), (2, 0, 2), "{named} {found:?}");
        }
    }
}

/// Both began beside each other, and each look has one plot for both.
#[test]
fn two_tracks_that_one_plot_a_look_feeds_become_one() {
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let mut tracker = Tracker::new(config);
        let r = Sym2 { xx: 2.0, xy: 0.0, yy: 2.0 };
        let state = |x: f64| Gaussian::at_position(Point2::new(x, 0.0), r, 1.0, 0.3);
        assert_eq!(tracker.adopt(SimTime::from_s(0.0), &[state(0.0), state(3.0)]), 2);
        let mut left = Vec::new();
        for k in 1..=12u32 {
            let t = f64::from(k);
            let plot = at(t - 0.5, 0, Point2::new(if k % 2 == 0 { 0.5 } else { 2.5 }, 0.0));
            let tracks = tracker.scan(SimTime::from_s(t), &[plot], &FlightList::default());
            left.push(tracks.iter().filter(|t| t.status != TrackStatus::Last).count());
        }
        assert_eq!((left[1], left[11]), (2, 1), "{left:?}");
        assert_eq!(tracker.statistics().merged, 1, "{left:?}");
    }
}

/// From one in fifty to nineteen in twenty: five looks with one plot for both; each look before them that brought both a plot of
/// their own takes some of that.
#[test]
fn looks_that_tell_two_apart_are_counted_against_those_that_do_not() {
    let looks = |apart: u32| {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        let r = Sym2 { xx: 2.0, xy: 0.0, yy: 2.0 };
        let state = |x: f64| Gaussian::at_position(Point2::new(x, 0.0), r, 1.0, 0.3);
        assert_eq!(tracker.adopt(SimTime::from_s(0.0), &[state(0.0), state(3.0)]), 2);
        for k in 1..=30u32 {
            let t = f64::from(k);
            let place = |x: f64, n: u32| at(t - 0.5, n, Point2::new(x, 0.0));
            let both = [place(0.0, 0), place(3.0, 1)];
            let one = [place(if k % 2 == 0 { 0.5 } else { 2.5 }, 0)];
            let plots = if k <= apart { &both[..] } else { &one[..] };
            tracker.scan(SimTime::from_s(t), plots, &FlightList::default());
            if tracker.statistics().merged == 1 {
                return k - apart;
            }
        }
        u32::MAX
    };
    let found = [0, 3, 6, 9].map(looks);
    println!("{found:?}");
    assert!((4..=6).contains(&found[0]), "{found:?}");
    assert!(found.windows(2).all(|two| two[1] > two[0]), "{found:?}");
}

/// A body lies along its nose, wherever that points: what is on it along is beside it across.
#[test]
fn what_lies_on_a_body_lies_along_its_nose() {
    use super::super::stages::doubles::on_body;
    let mut tracker = Tracker::new(TrackingConfig::paper());
    tracker.scan(SimTime::from_s(1.0), &[at(0.5, 0, Point2::origin())], &FlightList::default());
    let track = &mut tracker.tracks[0];
    let place = Point2::new(30.0, -70.0);
    track.size_m = Some((40.0, 10.0));
    for degrees in [0.0_f64, 30.0, 90.0, 135.0, 260.0] {
        track.heading_rad = degrees.to_radians();
        let (sin, cos) = libm::sincos(track.heading_rad);
        let (nose, right) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
        // Nine tenths of the length before and behind, six of the span aside.
        for (along, aside, on) in [
            (35.9, 0.0, true),
            (36.1, 0.0, false),
            (0.0, 5.9, true),
            (0.0, 6.1, false),
            (35.0, 5.0, true),
        ] {
            for (a, b) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let point = place + nose * (a * along) + right * (b * aside);
                assert_eq!(on_body(track, place, point, 1e6), on, "{degrees}: {along} {aside}");
            }
        }
    }
    // Of unknown size it is all round, as far as asked.
    track.size_m = None;
    assert!(on_body(track, place, place + Vector2::new(3.0, 4.0), 5.0));
    assert!(!on_body(track, place, place + Vector2::new(3.0, 4.0), 4.9));
}

/// Who stands beside another one and says another address is a target of its own, however near.
#[test]
fn neighbours_of_different_addresses_keep_a_track_each() {
    for (config, apart_m) in [
        (TrackingConfig::paper(), 25.0),
        (TrackingConfig::accurate(), 25.0),
        (TrackingConfig::accurate(), 12.0),
    ] {
        let mut tracker = Tracker::new(config);
        let mut last = Vec::new();
        for k in 1..=40u32 {
            let t = f64::from(k);
            let plots = [0, 1].map(|n| Plot {
                sensor: SensorId(2),
                kind: SensorKind::Adsb,
                identity: Some(Identity::Address(0x40_0000 + n)),
                ..at(t - 0.5, n, Point2::new(apart_m * f64::from(n), 0.0))
            });
            last = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        }
        assert_eq!((last.len(), tracker.statistics().merged), (2, 0), "{apart_m} m");
    }
}
