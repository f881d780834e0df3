//! Who has taken off leaves the sensors for good, but not between two of its reports.

use super::labelled::report;
use super::*;
use crate::frames::Point2;

/// A departure whose transponder is heard twice a second but from `from_s` to `to_s`: scans in which it has a track, and the numbers of these.
fn departs(mut profile: TrackingConfig, from_s: f64, to_s: f64) -> (Vec<u32>, Vec<u16>) {
    let flights = FlightList {
        runways: vec![("09/27".to_owned(), [Point2::origin(), Point2::new(3000.0, 0.0)])],
        ..FlightList::default()
    };
    // Ten seconds on the runway, 2.2 m/s² to 85 m/s, straight on.
    let place = |t: f64| {
        let run = (t - 10.0).clamp(0.0, 85.0 / 2.2);
        Point2::new(100.0 + 1.1 * run * run + 85.0 * (t - 10.0 - 85.0 / 2.2).max(0.0), 0.0)
    };
    let model = config::SensorModel::default_of(SensorId(2), SensorKind::Adsb);
    profile.sensors.push(config::SensorModel { interval_s: 0.4, ..model });
    let mut tracker = Tracker::new(profile);
    let (mut scans, mut numbers) = (Vec::new(), Vec::new());
    for scan in 1..=120u32 {
        let end = f64::from(scan);
        let told = [end - 0.75, end - 0.25].into_iter().filter(|t| !(from_s..to_s).contains(t));
        let plots: Vec<Plot> = told.map(|t| report(2, SensorKind::Adsb, t, 0, place(t))).collect();
        for track in tracker.scan(SimTime::from_s(end), &plots, &flights) {
            scans.push(scan);
            if !numbers.contains(&track.number) {
                numbers.push(track.number);
            }
        }
    }
    (scans, numbers)
}

#[test]
fn two_reports_that_are_missing_end_no_track_of_a_departure() {
    for profile in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        for from_s in [60.1, 70.6, 90.1] {
            let (scans, numbers) = departs(profile.clone(), from_s, from_s + 1.5);
            assert_eq!(numbers.len(), 1, "{from_s}: {numbers:?}");
            assert_eq!(scans.last(), Some(&120), "{from_s}");
        }
    }
}

#[test]
fn a_departure_that_is_heard_no_more_is_followed_for_a_few_scans() {
    for profile in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let (scans, _) = departs(profile, 80.0, 999.0);
        let last = scans.last().copied().expect("it was seen");
        assert!((81..=86).contains(&last), "{last}");
    }
}
