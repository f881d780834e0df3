//! Sensors that look seldom, and targets that tell their place badly: a track that gets all that is due to it is not lost.

use super::hard_cases::plot;
use super::*;
use crate::plot::{Callsign, Identity};
use config::SensorModel;

/// How many tracks a scene of one target had one after the other, and in how many scans from the begin of `from_s` on there was none.
fn lives(
    config: &TrackingConfig,
    seconds: u32,
    from_s: f64,
    told: impl Fn(u32) -> Option<Plot>,
) -> (usize, u32) {
    let mut tracker = Tracker::new(config.clone());
    let (mut numbers, mut missing) = (Vec::new(), 0);
    for k in 1..=seconds {
        let t = f64::from(k);
        let plots: Vec<Plot> = told(k).into_iter().collect();
        let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        missing += u32::from(t > from_s && tracks.is_empty());
        numbers.extend(tracks.iter().map(|track| track.number));
        numbers.dedup();
    }
    (numbers.len(), missing)
}

fn profiles() -> [TrackingConfig; 2] {
    [TrackingConfig::paper(), TrackingConfig::accurate()]
}

/// A radar that turns ten times a minute and slower: between two of its looks nothing is missed, and one look that fails ends nobody.
#[test]
fn a_target_that_is_seen_every_time_has_one_track_however_seldom_that_is() {
    for (profile, config) in profiles().into_iter().enumerate() {
        for turn_s in [1_u32, 3, 6, 8, 12] {
            for every_tenth_fails in [false, true] {
                let mut config = config.clone();
                let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
                config.sensors.push(SensorModel { interval_s: f64::from(turn_s), ..model });
                // At taxiing speed, with an error of 3 m.
                let told = |k: u32| {
                    let (look, t) = (k / turn_s, f64::from(k) - 0.25);
                    let fails = every_tenth_fails && look % 10 == 0;
                    let mut rng = DrawKey { run_seed: 4, sensor: 1, entity: 1, scan: u64::from(k) }
                        .rng(Purpose::Study);
                    let (east, north) = normal_pair(&mut rng);
                    let mut seen = plot(t, k, 10.0 * t + 3.0 * east, 3.0 * north);
                    (seen.along_m2, seen.across_m2) = (9.0, 9.0);
                    (k.is_multiple_of(turn_s) && !fails).then_some(seen)
                };
                let (tracks, missing) = lives(&config, 40 * turn_s, f64::from(6 * turn_s), told);
                let name = format!("profile {profile}, {turn_s} s, failing {every_tenth_fails}");
                assert_eq!((tracks, missing), (1, 0), "{name}");
            }
        }
    }
}

/// Who says himself that he knows his place to 200 m has a wide track, and one.
#[test]
fn who_tells_his_place_badly_has_one_track() {
    for (profile, config) in profiles().into_iter().enumerate() {
        for (sigma_m, speed_mps) in
            [(15.0, 12.0), (20.0, 12.0), (37.8, 12.0), (37.8, 0.0), (60.0, 12.0), (200.0, 12.0)]
        {
            for named in [true, false] {
                for every_tenth_fails in [false, true] {
                    let told = |k: u32| {
                        let t = f64::from(k) - 0.25;
                        let mut report = plot(t, k, speed_mps * t, 100.0);
                        report.kind = SensorKind::Adsb;
                        (report.along_m2, report.across_m2) =
                            (sigma_m * sigma_m, sigma_m * sigma_m);
                        let name = Identity::Callsign(Callsign::new("CAR1"));
                        report.identity = named.then_some(name);
                        (!every_tenth_fails || k < 10 || !k.is_multiple_of(10)).then_some(report)
                    };
                    let (tracks, missing) = lives(&config, 100, 6.0, told);
                    let name = format!(
                        "profile {profile}, {sigma_m} m, {speed_mps} m/s, {named} {every_tenth_fails}"
                    );
                    assert_eq!((tracks, missing), (1, 0), "{name}");
                }
            }
        }
    }
}

/// Who falls silent is missed as ever: a wide track waits no longer than a narrow one.
#[test]
fn a_wide_track_that_gets_nothing_more_ends() {
    for config in profiles() {
        for sigma_m in [3.0, 37.8, 200.0] {
            let mut tracker = Tracker::new(config.clone());
            for k in 1..=40_u32 {
                let t = f64::from(k);
                let mut report = plot(t - 0.25, k, 12.0 * t, 100.0);
                report.kind = SensorKind::Adsb;
                (report.along_m2, report.across_m2) = (sigma_m * sigma_m, sigma_m * sigma_m);
                let plots = if k <= 28 { vec![report] } else { Vec::new() };
                tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
                assert!(k != 28 || tracker.tracks.len() == 1, "{sigma_m}");
            }
            assert!(tracker.tracks.is_empty(), "{sigma_m}");
        }
    }
}

/// Of a target that is measured once a second every other plot comes a second late: it was measured each time.
#[test]
fn a_measurement_that_comes_late_is_no_miss() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let seen = |k: u32| plot(f64::from(k) - 0.5, k, 8.0 * f64::from(k), 40.0);
    let mut confirmed = 0;
    for k in 1..=30_u32 {
        let plots = if k % 2 == 0 { vec![seen(k), seen(k - 1)] } else { Vec::new() };
        let tracks = tracker.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
        confirmed += tracks.len();
        if k == 20 {
            assert_eq!(tracker.tracks.len(), 1);
            assert_eq!(tracker.tracks[0].history & 0xff, 0xff, "of {:?}", tracker.statistics());
        }
    }
    assert!(confirmed >= 26, "{confirmed}: {:?}", tracker.statistics());
}

/// A late plot is one measurement: it stands for the look that it lacked, not for the present one as well.
#[test]
fn a_late_plot_counts_once() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let seen = |k: u32| plot(f64::from(k) - 0.5, k, 8.0 * f64::from(k), 40.0);
    for k in 1..=12_u32 {
        // The eleventh is measured as any and comes a second late, the twelfth is none.
        let plots = match k {
            11 => Vec::new(),
            12 => vec![seen(11)],
            _ => vec![seen(k)],
        };
        tracker.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
    }
    let track = &tracker.tracks[0];
    assert_eq!((track.looks, track.history & 0b111), (12, 0b110));
}
