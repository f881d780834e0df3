//! The chain under hostile input: the law that must hold stands beside each case.

use super::*;
use crate::filter::{FilterConfig, Rung};
use crate::frames::{Matrix2, Point2};
use crate::plot::{Callsign, Identity};
use config::AssociationMethod;
use proptest::prelude::*;

pub(super) fn plot(t_s: f64, sequence: u32, x: f64, y: f64) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime::from_s(t_s),
        sequence,
        position_m: Point2::new(x, y),
        axis: Vector2::new(1.0, 0.0),
        along_m2: 2.0,
        across_m2: 3.0,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

fn methods() -> [TrackingConfig; 3] {
    [
        AssociationMethod::Nearest,
        AssociationMethod::Global,
        AssociationMethod::Joint { limit: 100_000 },
    ]
    .map(|association| TrackingConfig { association, ..TrackingConfig::paper() })
}

fn assert_sound(name: &str, tracks: &[SystemTrack]) {
    for track in tracks {
        let p = track.position_cov_m2;
        let numbers = [track.position_m.coords, track.velocity_mps, track.acceleration_ms2];
        assert!(numbers.iter().all(|v| v.iter().all(|x| x.is_finite())), "{name}: {track:?}");
        assert!(track.heading_rad >= 0.0 && track.heading_rad < std::f64::consts::TAU, "{name}");
        assert!(p.iter().all(|x| x.is_finite()) && p == p.transpose(), "{name}: {p}");
        assert!(p[(0, 0)] > 0.0 && p.determinant() > 0.0, "{name}: {p}");
        assert!(track.velocity_cov_m2s2.iter().all(|x| x.is_finite()), "{name}");
    }
    assert!(tracks.windows(2).all(|w| w[0].number < w[1].number), "{name}: numbers twice");
}

#[test]
fn unsound_plots_are_counted_and_leave_no_trace() {
    let good = plot(0.5, 0, 10.0, 20.0);
    let nan = f64::NAN;
    for (name, bad) in [
        ("NaN position", Plot { position_m: Point2::new(nan, 0.0), ..good }),
        ("infinite position", Plot { position_m: Point2::new(f64::INFINITY, 0.0), ..good }),
        ("beyond the earth", Plot { position_m: Point2::new(1e300, 0.0), ..good }),
        ("negative variance", Plot { along_m2: -1.0, ..good }),
        ("NaN variance", Plot { across_m2: nan, ..good }),
        ("infinite along", Plot { along_m2: f64::INFINITY, ..good }),
        ("axis of length 2", Plot { axis: Vector2::new(2.0, 0.0), ..good }),
        ("NaN axis", Plot { axis: Vector2::new(nan, 0.0), ..good }),
        ("NaN altitude", Plot { altitude_m: Some(nan), ..good }),
        ("from the future", Plot { time: SimTime::from_s(1.1), ..good }),
    ] {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        tracker.scan(SimTime::from_s(1.0), &[bad], &FlightList::default());
        assert_eq!(tracker.outcomes(), [Outcome::Unsound], "{name}");
        assert_eq!(tracker.statistics().started, 0, "{name}");
    }
}

#[test]
fn degenerate_but_sound_plots_give_sound_tracks() {
    for config in methods() {
        for (name, along, across, step) in [
            ("no noise at all", 0.0, 0.0, 10.0),
            ("one direction exact", 0.0, 1e8, 10.0),
            ("almost exact", 1e-300, 1e-300, 10.0),
            ("useless", 1e12, 1e12, 10.0),
            ("standing", 2.0, 2.0, 0.0),
            ("standing and exact", 0.0, 0.0, 0.0),
        ] {
            let mut config = config.clone();
            // Without the assumed glint, so that the stated variances reach the filter.
            let mut sensor = config::SensorModel::default_of(SensorId(1), SensorKind::Asde);
            sensor.extra_sigma_m = 0.0;
            config.sensors.push(sensor);
            let mut tracker = Tracker::new(config);
            for k in 1..=60 {
                let t = f64::from(k);
                let mut p = plot(t - 0.5, 0, step * t, 3.0);
                (p.along_m2, p.across_m2) = (along, across);
                let tracks = tracker.scan(SimTime::from_s(t), &[p], &FlightList::default());
                for track in &tracks {
                    assert!(track.position_m.iter().all(|x| x.is_finite()), "{name}: {track:?}");
                    assert!(track.position_cov_m2.iter().all(|x| x.is_finite()), "{name}");
                }
                assert!(k < 6 || across > 1e6 || tracks.len() == 1, "{name} {k}: {}", tracks.len());
            }
        }
    }
}

#[test]
fn two_plots_of_one_time_update_one_track_in_either_order() {
    let run = |first: u16, second: u16| {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        let mut last = Vec::new();
        for k in 1..=10 {
            let t = f64::from(k);
            let mut a = plot(t, 0, 10.0 * t, 0.0);
            let mut b = plot(t, 0, 10.0 * t + 1.0, 1.0);
            (a.sensor, b.sensor) = (SensorId(first), SensorId(second));
            last = tracker.scan(SimTime::from_s(t), &[a, b], &FlightList::default());
        }
        assert_eq!(last.len(), 1);
        assert_sound("two plots at one time", &last);
        last
    };
    let (ab, ba) = (run(1, 2), run(2, 1));
    assert!((ab[0].position_m - ba[0].position_m).norm() < 1e-9, "T = 0 commutes");
}

#[test]
fn late_plots_give_the_tracks_of_plots_in_order() {
    for config in methods() {
        let radar = tower(5, 0.95, 1);
        let paths = traffic();
        let all: Vec<Vec<Plot>> =
            (1..=40).map(|k| radar.scan(k, &paths).into_iter().map(|l| l.0).collect()).collect();
        let mut punctual = Tracker::new(config.clone());
        let mut tardy = Tracker::new(config);
        let (mut last_punctual, mut last_tardy) = (Vec::new(), Vec::new());
        let mut held: Vec<(u32, Plot)> = Vec::new();
        for (k, plots) in (1u32..).zip(&all) {
            let t = SimTime::from_s(f64::from(k));
            last_punctual = punctual.scan(t, plots, &FlightList::default());
            // From scan 15 to 35 one plot in four comes one to three scans late.
            let mut now = Vec::new();
            for (index, p) in plots.iter().enumerate() {
                if (15..35).contains(&k)
                    && p.sequence < 1000
                    && (index as u32 + k).is_multiple_of(4)
                {
                    held.push((k + 1 + (index as u32) % 3, *p));
                } else {
                    now.push(*p);
                }
            }
            now.extend(held.iter().filter(|(due, _)| *due == k).map(|(_, p)| *p));
            held.retain(|(due, _)| *due > k);
            now.reverse();
            last_tardy = tardy.scan(t, &now, &FlightList::default());
        }
        assert!(tardy.statistics().late >= 10, "{:?}", tardy.statistics());
        assert_eq!(last_punctual.len(), last_tardy.len());
        for (a, b) in last_punctual.iter().zip(&last_tardy) {
            assert!(
                (a.position_m - b.position_m).norm() < 1e-9,
                "{} {}",
                a.position_m,
                b.position_m
            );
        }
    }
}

#[test]
fn copies_and_the_hopelessly_late_are_dropped_and_counted() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let first = plot(0.5, 0, 0.0, 0.0);
    tracker.scan(SimTime::from_s(1.0), &[first, first], &FlightList::default());
    assert_eq!(tracker.outcomes()[1], Outcome::Duplicate);
    tracker.scan(SimTime::from_s(2.0), &[plot(1.5, 0, 0.0, 0.0), first], &FlightList::default());
    assert_eq!(tracker.outcomes()[1], Outcome::Duplicate);
    // Of the scan before, and older than what is remembered.
    tracker.scan(SimTime::from_s(60.0), &[plot(1.9, 7, 0.0, 0.0)], &FlightList::default());
    assert_eq!(tracker.outcomes()[0], Outcome::TooLate);
    let s = tracker.statistics();
    assert_eq!((s.duplicates, s.too_late, s.started), (2, 1, 1));
}

#[test]
fn clock_jumps_leave_sound_tracks() {
    for config in methods() {
        let mut tracker = Tracker::new(config);
        let mut t = 0.0;
        for (name, jump) in
            [("steady", 1.0), ("an hour", 3600.0), ("back", -1800.0), ("none", 0.0), ("a ns", 1e-9)]
        {
            for _ in 0..8 {
                t += 1.0;
                let p = plot(t - 0.3, 0, 5.0 * (t % 60.0), 0.0);
                assert_sound(name, &tracker.scan(SimTime::from_s(t), &[p], &FlightList::default()));
            }
            t += jump;
            let tracks = tracker.scan(SimTime::from_s(t), &[], &FlightList::default());
            assert_sound(name, &tracks);
            if !(0.0..=60.0).contains(&jump) {
                let live = tracks.iter().filter(|k| k.status != TrackStatus::Last).count();
                assert_eq!(live, 0, "{name}: nothing lives through it");
            }
        }
        assert_eq!(tracker.statistics().clock_resets, 1);
    }
}

#[test]
fn a_minute_without_plots_ends_a_track_with_one_last_message() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let (mut coasting, mut ended) = (0, 0);
    for k in 1..=80 {
        let t = f64::from(k);
        let plots = [plot(t - 0.5, 0, 10.0 * t, 0.0)];
        let given = if k <= 20 { &plots[..] } else { &[] };
        let tracks = tracker.scan(SimTime::from_s(t), given, &FlightList::default());
        assert_sound("coast", &tracks);
        coasting += tracks.iter().filter(|t| t.status == TrackStatus::Coasting).count();
        ended += tracks.iter().filter(|t| t.status == TrackStatus::Last).count();
        // Straight on while it coasts.
        for track in tracks.iter().filter(|_| k > 20) {
            assert!((track.position_m - Point2::new(10.0 * t, 0.0)).norm() < 5.0, "{k}");
        }
    }
    assert_eq!(ended, 1);
    assert!((6..=9).contains(&coasting), "{coasting}");
}

#[test]
fn ten_targets_in_one_cell_neither_hang_nor_multiply() {
    for config in methods() {
        let mut tracker = Tracker::new(config);
        for k in 1..=30 {
            let t = f64::from(k);
            let plots: Vec<Plot> = (0..10)
                .map(|n| {
                    plot(
                        t - 0.5 + 1e-3 * f64::from(n),
                        n,
                        0.4 * f64::from(n),
                        0.3 * f64::from(n % 3),
                    )
                })
                .collect();
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            assert_sound("ten in a cell", &tracks);
            assert!(tracks.len() <= 10);
        }
    }
}

#[test]
fn certain_and_impossible_detection_are_survived() {
    for (name, detection, density) in [
        ("Pd 1", 1.0, 1e-8),
        ("Pd 0", 0.0, 1e-8),
        ("no false plots", 0.9, 0.0),
        ("nothing but false plots", 0.9, f64::INFINITY),
        ("NaN density", 0.9, f64::NAN),
    ] {
        for mut config in methods() {
            let mut sensor = config::SensorModel::default_of(SensorId(1), SensorKind::Asde);
            (sensor.detection, sensor.false_density_m2) = (detection, density);
            config.sensors.push(sensor);
            let mut tracker = Tracker::new(config);
            for k in 1..=20 {
                let t = f64::from(k);
                let plots = [plot(t - 0.5, 0, 8.0 * t, 0.0), plot(t - 0.5, 1, 8.0 * t, 9.0)];
                assert_sound(
                    name,
                    &tracker.scan(SimTime::from_s(t), &plots, &FlightList::default()),
                );
            }
        }
    }
}

#[test]
fn a_million_tracks_come_and_go_and_numbers_hold() {
    let mut config = TrackingConfig::paper();
    (config.life.confirm_hits, config.life.confirm_of) = (1, 1);
    config.life.delete_moving_s = 0.5;
    config.life.delete_standing_s = 0.5;
    config.life.delete_least_updates = 0.0;
    config.life.number_rest_s = 1.0;
    let mut tracker = Tracker::new(config);
    // 1 400 targets a scan, each seen once: never at the same place, so every plot is a birth.
    let mut published = 0usize;
    for k in 0..715u32 {
        let t = 2.0 * f64::from(k);
        let plots: Vec<Plot> = (0..1400)
            .map(|n| {
                let (row, column) = (n / 40, n % 40);
                let shift = if k % 2 == 0 { 0.0 } else { 700.0 };
                plot(t + 0.9, n, 1400.0 * f64::from(column) + shift, 1400.0 * f64::from(row))
            })
            .collect();
        let tracks = tracker.scan(SimTime::from_s(t + 1.0), &plots, &FlightList::default());
        assert!(tracks.iter().all(|t| t.number < 4096));
        assert!(tracks.windows(2).all(|w| w[0].number < w[1].number));
        published += tracks.iter().filter(|t| t.first).count();
    }
    let s = *tracker.statistics();
    assert!(s.started >= 1_000_000 && s.deleted >= 990_000, "{s:?}");
    assert_eq!(s.no_number, 0);
    assert_eq!(published as u64, s.confirmed);
    assert!(tracker.tracks.len() <= 2800, "nothing is left behind");
}

#[test]
fn when_numbers_run_out_confirmations_are_refused_and_counted() {
    let mut config = TrackingConfig::paper();
    config.life.numbers = 5;
    let mut tracker = Tracker::new(config);
    for k in 1..=10 {
        let t = f64::from(k);
        let plots: Vec<_> = (0..8).map(|n| plot(t - 0.5, n, 300.0 * f64::from(n), 0.0)).collect();
        let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        assert!(tracks.len() <= 5);
    }
    assert_eq!(tracker.statistics().confirmed, 5);
    assert!(tracker.statistics().no_number >= 3);
}

#[test]
fn an_hour_parked_is_one_track_that_stands() {
    let radar = tower(9, 0.9, 1);
    let paths: Vec<Box<Path>> =
        vec![drive(Point2::new(640.0, 380.0), 0.0, 0.0, &[(0.1, 0.0, 0.0)])];
    let run = run(TrackingConfig::paper(), &radar, &paths, &FlightList::default(), 3600);
    assert_eq!(run.numbers_near[0].len(), 1, "{:?}", run.numbers_near);
    assert_eq!(run.missing[0], 0);
    let track = run.last.iter().min_by(|a, b| {
        let from = |t: &SystemTrack| (t.position_m - Point2::new(640.0, 380.0)).norm();
        from(a).total_cmp(&from(b))
    });
    assert!(track.expect("parked").speed_mps() < 1.0);
}

#[test]
fn one_long_aircraft_with_two_echoes_is_one_track() {
    // Nose and tail of a B744 at taxi speed; its label comes from its transponder.
    let mut config = TrackingConfig::paper();
    config.sizes.push(config::TypeSize {
        designator: "B744".to_owned(),
        length_m: 70.7,
        span_m: 64.4,
    });
    let flights = FlightList {
        entries: vec![labelled::entry("BAW117", "B744", MovementKind::Departure)],
        runways: Vec::new(),
    };
    let mut tracker = Tracker::new(config);
    let (mut last, mut most) = (Vec::new(), 0);
    for k in 1..=60 {
        let t = f64::from(k);
        let nose = plot(t - 0.6, 0, 8.0 * t + 30.0, 0.0);
        let tail = plot(t - 0.6, 1, 8.0 * t - 30.0, 0.5);
        let mut report = plot(t - 0.6, 0, 8.0 * t + 28.0, 0.2);
        (report.sensor, report.kind) = (SensorId(2), SensorKind::Adsb);
        report.identity = Some(Identity::Callsign(Callsign::new("BAW117")));
        last = tracker.scan(SimTime::from_s(t), &[nose, tail, report], &flights);
        if k > 20 {
            most = most.max(last.iter().filter(|t| t.status != TrackStatus::Last).count());
        }
    }
    assert_eq!(last.iter().filter(|t| t.label.is_some()).count(), 1);
    assert!(tracker.statistics().merged >= 1, "the tail had a track before the label came");
    assert_eq!(most, 1, "{last:#?}");
}

#[test]
fn a_state_that_is_no_covariance_is_counted_and_begun_again_and_never_used() {
    use crate::filter::lanes::{Lane, Pair};
    type Spoil = fn(&mut crate::filter::Gaussian);
    let spoil: [(&str, Spoil); 4] = [
        ("negative", |g| g.p = g.p.map(|p| p * -1e6)),
        ("indefinite", |g| g.p[1] = Pair::splat(1e3) + g.p[0]),
        ("infinite", |g| g.p[0] = Pair::splat(f64::INFINITY)),
        ("NaN", |g| g.p[0] = Pair::splat(f64::NAN)),
    ];
    for (rung, rung_name) in crate::filter::Rung::ALL {
        for (name, spoil) in spoil {
            // Gains computed once use no covariance, and state that of the last plot: nothing to spoil.
            if rung == crate::filter::Rung::Abg {
                continue;
            }
            for with_plot in [true, false] {
                let case = format!("{rung_name}, {name}, {with_plot}");
                let mut config = TrackingConfig::paper();
                config.filter = crate::filter::FilterConfig::new(rung);
                let mut tracker = Tracker::new(config);
                let at = |k: u32| plot(f64::from(k) - 0.5, 0, 10.0 * f64::from(k), 0.0);
                for k in 1..=8 {
                    tracker.scan(SimTime::from_s(k.into()), &[at(k)], &FlightList::default());
                }
                let track = &mut tracker.tracks[0];
                let time = track.time();
                let number = track.number.expect("confirmed");
                let mut state = track.filter().estimate().state;
                spoil(&mut state);
                assert!(!state.is_sound(), "{case}");
                track.take_over(time, &state, number);
                for k in 9..=14 {
                    let plots = [at(k)];
                    let plots = if with_plot || k > 10 { &plots[..] } else { &[] };
                    let tracks =
                        tracker.scan(SimTime::from_s(k.into()), plots, &FlightList::default());
                    assert_sound(&case, &tracks);
                    assert_eq!(tracks.len(), 1, "{case} {k}");
                    assert_eq!(tracks[0].number, number, "{case} {k}");
                    let off = tracks[0].position_m - Point2::new(10.0 * f64::from(k) + 5.0, 0.0);
                    assert!(off.norm() < 60.0, "{case} {k}: {off}");
                }
                assert_eq!(tracker.statistics().not_positive_definite, 1, "{case}");
            }
        }
    }
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let r = crate::filter::Sym2 { xx: 1.0, xy: 2.0, yy: 1.0 };
    let state = crate::filter::Gaussian::at_position(Point2::origin(), r, 50.0, 3.0);
    assert_eq!(tracker.adopt(SimTime::ZERO, &[state]), 0, "none of that kind is taken over");
}

fn any_plot() -> impl Strategy<Value = Plot> {
    let odd = prop_oneof![
        8 => -2000.0..2000.0f64,
        1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(1e308), 1 => Just(-0.0),
    ];
    let variance = prop_oneof![
        6 => 0.01..100.0f64,
        1 => Just(0.0), 1 => Just(1e-300), 1 => Just(1e300), 1 => Just(f64::INFINITY), 1 => Just(f64::NAN),
    ];
    let time = prop_oneof![8 => -3.0..1.0f64, 1 => -100.0..100.0f64, 1 => Just(0.0)];
    (
        (odd.clone(), odd.clone(), time, variance.clone(), variance, 0.0..7.0f64),
        (0u16..4, 0u32..5, proptest::option::of(0u32..4), proptest::option::of(odd), any::<bool>()),
    )
        .prop_map(
            |((x, y, t, along, across, angle), (sensor, sequence, name, altitude_m, polar))| Plot {
                sensor: SensorId(sensor),
                kind: [SensorKind::Asde, SensorKind::Gps, SensorKind::Loop, SensorKind::Adsb]
                    [sensor as usize],
                time: SimTime::from_s(t),
                sequence,
                position_m: Point2::new(x, y),
                axis: Vector2::new(libm::cos(angle), libm::sin(angle)),
                along_m2: along,
                across_m2: across,
                altitude_m,
                polar: polar.then_some(Polar {
                    range_m: x,
                    azimuth_rad: angle,
                    sigma_range_m: along,
                    sigma_azimuth_rad: across,
                    extent_m2: None,
                }),
                identity: name.map(|n| {
                    if n < 2 {
                        Identity::Address(n)
                    } else {
                        Identity::Callsign(Callsign::new("ABC"))
                    }
                }),
                scnr_db: None,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn hostile_plots_never_panic_and_never_give_nan(
        scans in proptest::collection::vec(
            (proptest::collection::vec(any_plot(), 0..12), -2.0..4.0f64), 1..14),
        method in 0usize..4,
        jump in prop_oneof![6 => Just(0.0), 1 => -1e12..1e12f64, 1 => -1e4..1e4f64],
        rung in 0usize..crate::filter::Rung::ALL.len(),
    ) {
        let mut config = methods().get(method).cloned().unwrap_or_else(TrackingConfig::accurate);
        config.filter = crate::filter::FilterConfig::new(crate::filter::Rung::ALL[rung].0);
        // Everything is confirmed at once, so that everything is published.
        (config.life.confirm_hits, config.life.confirm_of) = (1, 2);
        let mut tracker = Tracker::new(config);
        let flights = FlightList {
            entries: ["ABC", "ABD"].map(|name| FlightEntry {
                stand_m: Some(Point2::new(100.0, 100.0)),
                off_block: Some(SimTime::from_s(2.0)),
                ..super::labelled::entry(name, "A320", MovementKind::Departure)
            }).to_vec(),
            runways: vec![("28".to_owned(), [Point2::origin(), Point2::new(0.0, 1000.0)])],
        };
        let mut t = 0.0;
        for (k, (plots, step)) in scans.into_iter().enumerate() {
            t += if k == 6 { jump } else { step };
            let shifted: Vec<Plot> =
                plots.iter().map(|p| Plot { time: SimTime::from_s(t + p.time.s()), ..*p }).collect();
            let tracks = tracker.scan(SimTime::from_s(t), &shifted, &flights);
            for track in &tracks {
                let vectors = [track.position_m.coords, track.velocity_mps, track.acceleration_ms2];
                prop_assert!(vectors.iter().all(|v| v.iter().all(|x| x.is_finite())), "{:?}", track);
                let covariances: [Matrix2<f64>; 2] = [track.position_cov_m2, track.velocity_cov_m2s2];
                prop_assert!(covariances.iter().all(|c| c.iter().all(|x| x.is_finite())), "{:?}", track);
                prop_assert!(track.altitude_m.is_none_or(f64::is_finite));
            }
            prop_assert_eq!(tracker.outcomes().len(), shifted.len());
        }
    }
}

#[test]
fn two_sensors_a_moment_apart_are_as_good_as_at_one_instant_on_every_rung() {
    let truth = |t: f64| Point2::new(300.0 * libm::cos(0.03 * t), 300.0 * libm::sin(0.03 * t));
    let run = |rung: Rung, apart_s: f64| {
        let mut config = TrackingConfig::paper();
        config.filter = FilterConfig::new(rung);
        let mut tracker = Tracker::new(config);
        let (mut sum, mut fastest) = (0.0, 0.0f64);
        for k in 1..=120u32 {
            let t_out = f64::from(k);
            let mut plots = Vec::new();
            for sensor in [1u16, 2] {
                let key = DrawKey { run_seed: 5, sensor: sensor.into(), entity: 1, scan: k.into() };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                let t = t_out - 0.5 + apart_s * f64::from(sensor - 1);
                let at = truth(t) + Vector2::new(a, b) * 3.0;
                let mut plot = plot(t, 0, at.x, at.y);
                plot.sensor = SensorId(sensor);
                (plot.along_m2, plot.across_m2) = (9.0, 9.0);
                plots.push(plot);
            }
            let tracks = tracker.scan(SimTime::from_s(t_out), &plots, &FlightList::default());
            if k > 20 {
                assert_eq!(tracks.len(), 1, "{rung:?} {apart_s} at {k} s");
                sum += (tracks[0].position_m - truth(t_out)).norm_squared() / 100.0;
                fastest = fastest.max(tracks[0].speed_mps());
            }
        }
        (sum.sqrt(), fastest)
    };
    for (rung, name) in Rung::ALL {
        let (at_once, _) = run(rung, 0.0);
        for apart_s in [1e-9, 1e-6, 1e-3, 0.02, 0.2, 0.4] {
            let (error, fastest) = run(rung, apart_s);
            println!(
                "{name}, {apart_s} s: {error:.2} m for {at_once:.2} m, at most {fastest:.1} m/s"
            );
            assert!(error <= 1.5 * at_once, "{name}, {apart_s} s: {error} m for {at_once} m");
            // It drives 9 m/s.
            assert!(fastest < 25.0, "{name}, {apart_s} s: {fastest} m/s");
        }
    }
}

#[test]
fn a_track_faster_than_anything_ends_after_three_scans() {
    let mut config = TrackingConfig::paper();
    config.gates.restart = false;
    let mut tracker = Tracker::new(config);
    let mut counts = Vec::new();
    for k in 1..=9 {
        let t = f64::from(k);
        let speed = if k < 4 { 90.0 } else { 400.0 };
        let mut p = plot(t - 0.5, 0, speed * t, 0.0);
        // A gate that takes anything.
        (p.along_m2, p.across_m2) = (1e5, 1e5);
        let tracks = tracker.scan(SimTime::from_s(t), &[p], &FlightList::default());
        counts.push(tracks.iter().filter(|t| t.speed_mps() > 150.0).count());
    }
    assert!(counts.iter().sum::<usize>() <= 3, "{counts:?}");
}

#[test]
fn numbers_of_a_sensor_that_cannot_be_used_are_refused_with_a_sentence_and_replaced() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 1e300] {
        let model = config::SensorModel::default_of(SensorId(1), SensorKind::Asde);
        for (name, model) in [
            ("interval_s", config::SensorModel { interval_s: bad, ..model }),
            ("standing_interval_s", config::SensorModel { standing_interval_s: bad, ..model }),
            ("detection", config::SensorModel { detection: bad, ..model }),
            ("false_density_m2", config::SensorModel { false_density_m2: bad, ..model }),
            ("extra_sigma_m", config::SensorModel { extra_sigma_m: bad, ..model }),
            ("slow_share", config::SensorModel { slow_share: bad, ..model }),
            ("slow_tau_s", config::SensorModel { slow_tau_s: bad, ..model }),
            ("latency_s", config::SensorModel { latency_s: bad, ..model }),
            ("late_sigma_s", config::SensorModel { late_sigma_s: bad, ..model }),
        ] {
            let mut config = TrackingConfig::accurate();
            config.sensors.push(model);
            let refusal = config.check().expect_err("it cannot be used").to_string();
            assert!(refusal.contains(name) && refusal.contains("sensor 1"), "{refusal}");
            let mut tracker = Tracker::new(config);
            let mut last = Vec::new();
            for k in 1..=6 {
                let t = f64::from(k);
                let plots = [plot(t - 0.5, 0, 10.0 * t, 0.0)];
                last = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            }
            assert_eq!(last.len(), 1, "{name} {bad}");
            assert_sound(name, &last);
        }
    }
    assert_eq!(TrackingConfig::accurate().check(), Ok(()));
}
