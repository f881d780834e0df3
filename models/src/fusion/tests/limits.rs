//! What the tracker does at its limits: the gates, a second ago through a manoeuvre, new beginnings, what is published of echoes.

use super::hard_cases::plot;
use super::*;
use crate::frames::{Matrix2, Point2};
use config::{AssociationMethod, SensorModel};

/// A tracker after twelve looks at a target that moves along x at this speed, with its last report.
fn settled(config: TrackingConfig, speed_mps: f64) -> (Tracker, SystemTrack) {
    let mut tracker = Tracker::new(config);
    let mut last = None;
    for k in 1..=12 {
        let t = f64::from(k);
        let seen = plot(t - 0.5, 0, speed_mps * (t - 0.5), 0.0);
        last = tracker.scan(SimTime::from_s(t), &[seen], &FlightList::default()).pop();
    }
    (tracker, last.expect("confirmed"))
}

/// The covariance gate opens to the quantile that it is said to, seen from outside: by the covariance that is published.
#[test]
fn the_gate_opens_as_far_as_its_probability_says() {
    for (probability, quantile) in [(0.9, 4.605_170), (0.99, 9.210_340), (0.999, 13.815_51)] {
        let mut config = TrackingConfig::paper();
        (config.gates.probability, config.gates.kinematic) = (probability, false);
        config.gates.restart = false;
        config.sensors.push(SensorModel {
            extra_sigma_m: 0.0,
            ..SensorModel::default_of(SensorId(1), SensorKind::Asde)
        });
        let (tracker, shown) = settled(config, 0.0);
        // Late, at the instant that was published: its prediction is what was published, less what is left of the echo.
        let left_m2 = tracker.tracks[0].echo_left_m2;
        let cov = shown.position_cov_m2 - left_m2;
        for (direction, r) in [(Vector2::new(1.0, 0.0), 2.0), (Vector2::new(0.0, 1.0), 3.0)] {
            let edge_m = (quantile * (direction.dot(&(cov * direction)) + r)).sqrt();
            let taken = |share: f64| {
                let mut tracker = tracker.clone();
                let at = shown.position_m + direction * (edge_m * share);
                tracker.scan(
                    SimTime::from_s(13.0),
                    &[plot(12.0, 7, at.x, at.y)],
                    &FlightList::default(),
                );
                matches!(tracker.outcomes()[0], Outcome::Used { number: Some(_), .. })
            };
            assert!(taken(0.99) && !taken(1.01), "{probability} {direction}");
        }
    }
}

/// What nobody foresaw says little of what was before it: a second ago the target was where it was published to be then.
#[test]
fn a_manoeuvre_does_not_move_what_was_a_second_ago() {
    for reports in [false, true] {
        let mut config = if reports { TrackingConfig::accurate() } else { TrackingConfig::paper() };
        config.association = AssociationMethod::Nearest;
        config.register_sites = false;
        // Narrow, so that what is braked as hard as can be is none of what was foreseen.
        config.gates.probability = 0.2;
        let mut tracker = Tracker::new(config);
        let list = FlightList::default();
        let mut before = Point2::origin();
        for k in 1..=20 {
            let t = f64::from(k);
            let (x, aside) = (20.0 * (t - 0.5), if k == 20 { -4.5 } else { 0.0 });
            let mut seen = vec![plot(t - 0.5, 0, x + aside, 0.0)];
            if reports && k == 8 {
                let own = plot(t - 0.4, 1, x + 2.0, 0.0);
                seen.push(Plot { sensor: SensorId(5), kind: SensorKind::Gps, ..own });
            }
            let tracks = tracker.scan(SimTime::from_s(t), &seen, &list);
            if k == 20 {
                assert!(tracks[0].manoeuvre, "{reports}: {:?}", tracker.statistics());
                let ago = tracks[0].second_ago.expect("published before");
                let moved = (ago.position_m - before).norm();
                assert!(moved < 0.5, "{reports}: {moved} m");
            }
            before = tracks.first().map_or(before, |track| track.position_m);
        }
    }
}

/// Two refused plots farther apart than the target can go begin nothing; nor do two more before a plot has fitted.
#[test]
fn a_state_begins_again_from_what_it_can_have_driven_and_once() {
    let list = FlightList::default();
    // Refused plots at these places in the scans from 13 on.
    let restarts = |places: &[f64]| {
        let (mut tracker, _) = settled(TrackingConfig::paper(), 8.0);
        for (n, y) in places.iter().enumerate() {
            let t = 13.0 + n as f64;
            tracker.scan(SimTime::from_s(t), &[plot(t - 0.5, 0, 100.0, *y)], &list);
        }
        tracker.statistics().restarts
    };
    // 100 m/s is the most that is believed of an unknown target.
    assert_eq!(restarts(&[95.0, 185.0]), 1);
    assert_eq!(restarts(&[-95.0, 95.0]), 0, "190 m in a second");
    // Begun again there, it finds nothing, and two elsewhere are not believed again.
    assert_eq!(restarts(&[95.0, 105.0, 15.0, 12.0]), 1);
}

/// Where a radar alone sees a target, what its echo lies off along the line of sight is in both publications.
#[test]
fn what_an_echo_lies_off_is_stated_now_and_a_second_ago() {
    let law = near_side::EchoLaw::default();
    let radar = Radar { seed: 3, site: Point2::origin(), detection: 1.0, false_plots: 0 };
    let paths: Vec<Box<Path>> =
        vec![drive(Point2::new(700.0, 700.0), 0.0, 0.0, &[(0.1, 0.0, 0.0)])];
    let run = run(TrackingConfig::accurate(), &radar, &paths, &FlightList::default(), 200);
    let track = &run.last[0];
    let sight = Vector2::new(1.0, 1.0) / std::f64::consts::SQRT_2;
    for cov in [track.position_cov_m2, track.second_ago.expect("published before").cov_m2] {
        let along = sight.dot(&(cov * sight));
        assert!(along > law.residual_m * law.residual_m, "{along} m²");
    }
}

/// The place of an outcome is that of the plot's own stamp, where the sensor is known to be late too.
#[test]
fn an_outcome_is_where_the_target_is_at_the_stamp() {
    for latency_s in [0.0, 0.5] {
        let mut config = TrackingConfig::paper();
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        config.sensors.push(SensorModel { latency_s, ..model });
        let mut tracker = Tracker::new(config);
        for k in 1..=20 {
            let t = f64::from(k);
            let seen = plot(t - 0.2, 0, 20.0 * (t - 0.2 - latency_s), 0.0);
            tracker.scan(SimTime::from_s(t), &[seen], &FlightList::default());
        }
        let Outcome::Used { position_m, .. } = tracker.outcomes()[0] else { panic!("taken") };
        let off = position_m.x - 20.0 * 19.8;
        assert!(off.abs() < 0.3, "{latency_s}: {off} m");
    }
}

/// Two abreast at 60 m/s, seen 0.2 s apart: plots that may be either's are weighed where the target is at one time, so that neither
/// track is drawn ahead or behind.
#[test]
fn plots_of_one_update_are_moved_to_one_time() {
    let mut config = TrackingConfig::paper();
    config.association = AssociationMethod::Joint { limit: 100_000 };
    let mut tracker = Tracker::new(config);
    let (mut sum, mut worst, mut count) = (0.0, 0.0f64, 0.0);
    for k in 1..=60u32 {
        let t = f64::from(k);
        let times = [t - 0.6, t - 0.4];
        let seen = [0, 1].map(|n| {
            let key = DrawKey { run_seed: 6, sensor: 1, entity: n, scan: k.into() };
            let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
            let time = times[n as usize];
            plot(time, n as u32, 60.0 * time + a, 5.0 * n as f64 + b)
        });
        let tracks = tracker.scan(SimTime::from_s(t), &seen, &FlightList::default());
        if k > 12 {
            assert_eq!(tracks.len(), 2, "scan {k}");
            for track in &tracks {
                let off = track.position_m.x - 60.0 * t;
                (sum, count) = (sum + off * off, count + 1.0);
                worst = worst.max(off.abs());
            }
        }
    }
    let rms_m = f64::sqrt(sum / count);
    println!("along {rms_m:.2} m, at most {worst:.2} m");
    assert!(rms_m < 1.5 && worst < 4.0, "{rms_m} {worst}");
}

/// A target that stands under a radar, whose echo lies off by a constant, and that reports its position by a receiver: its track is as
/// far off as it says, over what echoes and receivers are off by.
#[test]
fn a_track_that_reports_and_is_seen_says_what_both_are_off_by() {
    let config = TrackingConfig::accurate();
    let law = near_side::EchoLaw::default();
    let (mut nees, mut count) = (0.0, 0.0);
    for run in 0..40u64 {
        let draw = |entity: u64, scan: u32| {
            let key = DrawKey { run_seed: 900 + run, sensor: 1, entity, scan: scan.into() };
            Vector2::from(<[f64; 2]>::from(normal_pair(&mut key.rng(Purpose::Study))))
        };
        let truth = Point2::new(800.0, 600.0);
        let axis = truth.coords.normalize();
        let across = Vector2::new(axis.y, -axis.x);
        let constant = draw(7, 0);
        let off = axis * (law.residual_m * constant.x - law.unknown_m.0)
            + across * (law.beside_m * constant.y);
        let rho = libm::exp(-1.0f64 / 300.0);
        let mut slow = draw(8, 0);
        let mut tracker = Tracker::new(TrackingConfig { register_sites: false, ..config.clone() });
        for k in 1..=240u32 {
            slow = slow * rho + draw(8, k) * (1.0 - rho * rho).sqrt();
            let t = f64::from(k);
            let noise = draw(1, k);
            let place = truth + off + axis * (2.4 * noise.x) + across * (2.4 * noise.y);
            let line = place.coords.normalize();
            let seen = Plot {
                position_m: place,
                axis: line,
                along_m2: 2.4 * 2.4,
                across_m2: 2.4 * 2.4,
                polar: Some(Polar {
                    range_m: place.coords.norm(),
                    azimuth_rad: libm::atan2(line.x, line.y),
                    sigma_range_m: 2.4,
                    sigma_azimuth_rad: 2.4 / place.coords.norm(),
                    extent_m2: None,
                }),
                ..plot(t - 0.5, 0, 0.0, 0.0)
            };
            let report = truth + (slow * 0.95f64.sqrt() + draw(2, k) * 0.05f64.sqrt()) * 2.0;
            let own = plot(t - 0.2, 1, report.x, report.y);
            let own = Plot {
                sensor: SensorId(5),
                kind: SensorKind::Gps,
                along_m2: 4.0,
                across_m2: 4.0,
                ..own
            };
            let tracks = tracker.scan(SimTime::from_s(t), &[seen, own], &FlightList::default());
            if k > 60 {
                let error = tracks[0].position_m - truth;
                let inverse = tracks[0].position_cov_m2.try_inverse().expect("a covariance");
                nees += error.dot(&(inverse * error));
                count += 1.0;
            }
        }
    }
    let mean = nees / count;
    println!("NEES {mean:.2}");
    assert!((1.2..3.0).contains(&mean), "{mean}");
}

/// On final at 70 m/s for 40 s, then braking, as only its own reports tell of, which are late by a delay of its own: published now and
/// a second ago it is as far off as it says from its first report on, and after four looks that brought none.
#[test]
fn what_reports_alone_tell_of_is_as_late_as_they_are_from_the_first_one_on() {
    const LATE_S: f64 = 0.144;
    let place = |t: f64| {
        let braking = (t - 40.0).max(0.0);
        Point2::new(0.8, -0.6) * (70.0 * t - braking * braking)
    };
    // First reports, on final, after the gap, braking: sums of NEES and their number.
    let (mut now, mut ago) = ([[0.0; 2]; 4], [[0.0; 2]; 4]);
    for run in 0..60u64 {
        let draw = |entity: u64, scan: u32| {
            let key = DrawKey { run_seed: 5_000 + run, sensor: 5, entity, scan: scan.into() };
            Vector2::from(<[f64; 2]>::from(normal_pair(&mut key.rng(Purpose::Study))))
        };
        let mut config = TrackingConfig::accurate();
        let model = SensorModel::default_of(SensorId(5), SensorKind::Adsb);
        config.sensors.push(SensorModel { late_sigma_s: LATE_S, extra_sigma_m: 0.0, ..model });
        let mut tracker = Tracker::new(config);
        let (delay_s, rho) = (LATE_S * draw(4, 0).x, libm::exp(-1.0f64 / 300.0));
        let mut slow = draw(3, 0);
        for k in 1..=60u32 {
            slow = slow * rho + draw(3, k) * (1.0 - rho * rho).sqrt();
            let t = f64::from(k) - 0.3;
            let off = (slow * 0.95f64.sqrt() + draw(2, k) * 0.05f64.sqrt()) * 2.0;
            let at = place(t - delay_s) + off;
            let name = Some(crate::plot::Identity::Callsign(crate::plot::Callsign::new("FINAL1")));
            let said = Plot {
                sensor: SensorId(5),
                kind: SensorKind::Adsb,
                along_m2: 4.0,
                across_m2: 4.0,
                identity: name,
                ..plot(t, 0, at.x, at.y)
            };
            let seen = if (24..28).contains(&k) { &[][..] } else { &[said][..] };
            let shown = tracker.scan(SimTime::from_s(f64::from(k)), seen, &FlightList::default());
            let part = match k {
                3..=4 => 0,
                5..=23 => 1,
                28..=32 => 2,
                33.. => 3,
                _ => continue,
            };
            let Some(track) = shown.first() else { continue };
            let add = |sums: &mut [[f64; 2]; 4], off: Vector2<f64>, cov: Matrix2<f64>| {
                let inverse = cov.try_inverse().expect("a covariance");
                sums[part][0] += off.dot(&(inverse * off));
                sums[part][1] += 1.0;
            };
            let truth = place(f64::from(k));
            add(&mut now, track.position_m - truth, track.position_cov_m2);
            if let Some(lag) = track.second_ago {
                add(&mut ago, lag.position_m - place(lag.time.s()), lag.cov_m2);
            }
        }
    }
    let [now, ago] = [now, ago].map(|sums| sums.map(|[nees, count]| nees / count));
    println!("now {now:.2?}, a second ago {ago:.2?}");
    assert!(now.iter().chain(&ago).all(|nees| (1.2..3.2).contains(nees)), "{now:?} {ago:?}");
}

/// What has taken off is gone after three looks without a plot, not after one.
#[test]
fn what_takes_off_may_miss_a_look() {
    let runway = [Point2::new(-200.0, 0.0), Point2::new(3_200.0, 0.0)];
    let flights = FlightList { entries: Vec::new(), runways: vec![("09".to_owned(), runway)] };
    for missed in [1, 2] {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        let mut numbers = Vec::new();
        for k in 1..=56u32 {
            let t = f64::from(k);
            let x = |t: f64| (t - 12.0).max(0.0).powi(2);
            let seen = plot(t - 0.5, 0, x(t - 0.5), 0.0);
            let gone = (50..50 + missed).contains(&k);
            let plots = if gone { &[][..] } else { &[seen][..] };
            let tracks = tracker.scan(SimTime::from_s(t), plots, &flights);
            numbers.extend(tracks.iter().map(|track| track.number));
        }
        numbers.dedup();
        assert_eq!(numbers.len(), 1, "{missed} missed: {numbers:?}");
        assert!(tracker.tracks[0].evidence.took_off.is_some());
    }
}

/// Three plots of four looks make a track; with two missed of the first three there is no third one to come.
#[test]
fn a_track_on_trial_is_dropped_as_soon_as_it_cannot_be_confirmed() {
    let after = |seen: &[bool]| {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        for (k, seen) in seen.iter().enumerate() {
            let t = 1.0 + k as f64;
            let plots = [plot(t - 0.5, 0, 0.0, 0.0)];
            let plots = if *seen { &plots[..] } else { &[] };
            tracker.scan(SimTime::from_s(t), plots, &FlightList::default());
        }
        let found = tracker.statistics();
        (found.confirmed, found.tentative_dropped)
    };
    assert_eq!(after(&[true, true]), (0, 0));
    assert_eq!(after(&[true, true, true]), (1, 0));
    assert_eq!(after(&[true, false, true, true]), (1, 0));
    assert_eq!(after(&[true, false]), (0, 0));
    assert_eq!(after(&[true, false, false]), (0, 1));
}
