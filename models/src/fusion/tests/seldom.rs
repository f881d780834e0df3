//! Scans longer than what a tracker remembers, targets that are told of seldom, and such as fly over.

use super::hard_cases::plot;
use super::*;
use crate::filter::{FilterConfig, Rung};
use crate::plot::{Callsign, Identity};
use config::SensorModel;

fn scan(tracker: &mut Tracker, t: f64, plots: &[Plot]) -> Vec<SystemTrack> {
    tracker.scan(SimTime::from_s(t), plots, &FlightList::default())
}

/// Of a scan of ten seconds the first half was too late, and with a memory of nothing all of every scan.
#[test]
fn a_plot_of_the_scan_is_never_late() {
    for (ring_s, scan_s) in [(5.0, 10), (0.0, 1), (1.5, 2), (0.5, 3), (5.0, 60)] {
        let mut tracker = Tracker::new(TrackingConfig { ring_s, ..TrackingConfig::paper() });
        // How long the first scan is nobody knows before the second.
        scan(&mut tracker, f64::from(scan_s), &[]);
        for k in 1..8_u32 {
            let (begin_s, length_s) = (f64::from(k * scan_s), f64::from(scan_s));
            let plots: Vec<Plot> = (1..=scan_s)
                .map(|n| {
                    let t = begin_s + f64::from(n);
                    plot(t, n, 8.0 * t, 0.0)
                })
                .collect();
            // One that is older than the scan before, and than what is remembered.
            let old = plot(begin_s - length_s.max(ring_s) - 0.5, 99, 0.0, 0.0);
            let tracks = scan(&mut tracker, begin_s + length_s, &[&plots[..], &[old]].concat());
            if k == 7 {
                assert_eq!(tracks.len(), 1, "{ring_s} s, scans of {scan_s} s");
                let to = Point2::new(8.0 * (begin_s + length_s), 0.0);
                assert!(
                    (tracks[0].position_m - to).norm() < 1.0,
                    "{ring_s} s, scans of {scan_s} s"
                );
            }
        }
        assert_eq!(tracker.statistics().too_late, 7, "{ring_s} s, scans of {scan_s} s");
    }
}

/// Who stands tells of himself every five seconds, ten times as seldom as who moves: each of his reports began a track that was dropped
/// before the next one came.
#[test]
fn who_stands_is_not_missed_before_he_tells_of_himself_again() {
    let profiles = [TrackingConfig::paper(), TrackingConfig::accurate()];
    for (profile, mut config) in (0..).zip(profiles) {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Adsb);
        config.sensors.push(SensorModel { interval_s: 0.5, standing_interval_s: 5.0, ..model });
        let mut tracker = Tracker::new(config);
        let (mut numbers, mut scans) = (Vec::new(), 0);
        for k in 1..=120_u32 {
            let t = f64::from(k);
            let reports: Vec<Plot> = (k % 5 == 3)
                .then(|| {
                    let mut report = plot(t - 0.4, k, 30.0, -20.0);
                    report.kind = SensorKind::Adsb;
                    report.identity = Some(Identity::Callsign(Callsign::new("CAR1")));
                    report
                })
                .into_iter()
                .collect();
            let tracks = scan(&mut tracker, t, &reports);
            if k > 20 {
                scans += tracks.len();
                numbers.extend(tracks.iter().map(|track| track.number));
            }
        }
        numbers.dedup();
        assert_eq!(
            (scans, numbers.len()),
            (100, 1),
            "profile {profile}: {:?}",
            tracker.statistics()
        );
    }
}

/// Who moves and falls silent is missed as soon as ever.
#[test]
fn who_moves_is_missed_as_soon_as_his_report_lacks() {
    let ended = |standing_interval_s: f64| {
        let mut config = TrackingConfig::accurate();
        let model = SensorModel::default_of(SensorId(1), SensorKind::Adsb);
        config.sensors.push(SensorModel { interval_s: 0.5, standing_interval_s, ..model });
        let mut tracker = Tracker::new(config);
        (1..=60_u32)
            .map(|k| {
                let t = f64::from(k);
                let reports: Vec<Plot> = [0.9, 0.4]
                    .map(|before| {
                        let mut report = plot(t - before, 2 * k, 15.0 * (t - before), 0.0);
                        report.kind = SensorKind::Adsb;
                        report.identity = Some(Identity::Callsign(Callsign::new("CAR1")));
                        report
                    })
                    .to_vec();
                scan(&mut tracker, t, if k <= 20 { &reports } else { &[] }).len()
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(ended(5.0), ended(0.0));
}

/// Who stood, sets off and falls silent: the five seconds of his last report from where he stood are no grace.
#[test]
fn who_sets_off_is_missed_as_soon_as_his_report_lacks() {
    let mut config = TrackingConfig::accurate();
    let model = SensorModel::default_of(SensorId(1), SensorKind::Adsb);
    config.sensors.push(SensorModel { interval_s: 0.5, standing_interval_s: 5.0, ..model });
    let mut tracker = Tracker::new(config);
    let report = |t: f64, x: f64| {
        let mut report = plot(t, (10.0 * t) as u32, x, 0.0);
        report.kind = SensorKind::Adsb;
        report.identity = Some(Identity::Callsign(Callsign::new("CAR1")));
        report
    };
    for k in 1..=34_u32 {
        let t = f64::from(k);
        let reports = match k {
            ..30 if k % 5 == 0 => vec![report(t - 0.1, 0.0)],
            ..30 => Vec::new(),
            // The last one of who stands, and half a second later he rolls.
            30 => vec![report(t - 0.6, 0.0), report(t - 0.1, 1.0)],
            _ => [0.6, 0.1].map(|s| report(t - s, 12.0 * (t - s - 29.9) + 1.0)).to_vec(),
        };
        scan(&mut tracker, t, &reports);
        if k == 27 {
            assert_eq!(tracker.tracks[0].due, SimTime::from_s(24.9 + 5.0), "he stands");
        }
    }
    assert!(tracker.tracks[0].due <= SimTime::from_s(34.4 + 0.01), "{:?}", tracker.tracks[0].due);
}

/// A radar that turns four times slower than what a coast is: its tracks were carried on at constant velocity between any two of its looks, and
/// all filters were one.
#[test]
fn a_slow_radar_has_the_filter_that_was_chosen() {
    for rung in ["ca3", "imm3"] {
        for interval_s in [1.0, 4.0, 5.0] {
            let mut config = TrackingConfig::paper();
            config.filter = FilterConfig::new(Rung::of(rung).expect("a rung"));
            let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
            config.sensors.push(SensorModel { interval_s, ..model });
            let mut tracker = Tracker::new(config);
            // Along the runway, 2.5 m/s² from the tenth look on.
            let x = |t: f64| {
                let rolls_s = (t - 10.0 * interval_s).max(0.0);
                5.0 * t + 1.25 * rolls_s * rolls_s
            };
            let mut worst_m: f64 = 0.0;
            for k in 1..=18_u32 {
                let t = interval_s * f64::from(k);
                let tracks = scan(&mut tracker, t, &[plot(t, k, x(t), 0.0)]);
                if k >= 15 {
                    assert_eq!(tracks.len(), 1, "{rung}, {interval_s} s, look {k}");
                    worst_m = worst_m.max((tracks[0].position_m.x - x(t)).abs());
                }
            }
            // Three sigmas of a plot; at constant velocity 5 to 8 m.
            assert!(worst_m < 3.0, "{rung}, {interval_s} s: {worst_m} m");
        }
    }
}

/// Nothing on a runway is faster than 150 m/s; who says that he flies over at 3 000 m may be.
#[test]
fn who_flies_over_keeps_his_track_and_who_is_that_fast_on_the_ground_does_not() {
    for (altitude_m, most_numbers) in [(Some(3000.0), 1), (Some(0.0), 40), (None, 40)] {
        let mut tracker = Tracker::new(TrackingConfig::accurate());
        let (mut numbers, mut scans) = (std::collections::BTreeSet::new(), 0);
        for k in 1..=40_u32 {
            let t = f64::from(k);
            let mut report = plot(t - 0.2, k, 190.0 * (t - 0.2), 500.0);
            report.kind = SensorKind::Adsb;
            report.altitude_m = altitude_m;
            report.identity = Some(Identity::Callsign(Callsign::new("OVER1")));
            let tracks = scan(&mut tracker, t, &[report]);
            scans += tracks.len();
            numbers.extend(tracks.iter().map(|track| track.number));
        }
        let high = altitude_m == Some(3000.0);
        assert!(numbers.len() <= most_numbers, "{altitude_m:?}: {numbers:?}");
        assert_eq!(scans >= 37, high, "{altitude_m:?}: {scans} scans with a track");
    }
}
