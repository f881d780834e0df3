//! Names that are told from the wrong place: whose track is called so, and what becomes of the report.

use super::hard_cases::plot;
use super::labelled::report;
use super::*;
use crate::plot::{Callsign, Identity};

fn name() -> Callsign {
    Callsign::new("FOLLOW1")
}

/// Two targets 1.5 km apart.
fn place(target: usize, t: f64) -> Point2<f64> {
    [Point2::new(10.0 * t, 0.0), Point2::new(9.0 * t, 1500.0)][target]
}

/// What a radar sees of both, as scan `k`.
fn seen(k: u32) -> Vec<Plot> {
    let t = f64::from(k) - 0.5;
    [0, 1].map(|n| plot(t, n as u32, place(n, t).x, place(n, t).y)).to_vec()
}

fn nearest(tracks: &[SystemTrack], to: Point2<f64>) -> &SystemTrack {
    let off = |t: &&SystemTrack| (t.position_m - to).norm();
    tracks.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("its track")
}

/// From where scan `k` brings a report, if it brings one.
type From<'a> = &'a dyn Fn(u32) -> Option<usize>;

/// Who is called so after each scan: the first, the second.
fn called(config: &TrackingConfig, scans: u32, from: From<'_>) -> Vec<[bool; 2]> {
    let mut tracker = Tracker::new(config.clone());
    (1..=scans)
        .map(|k| {
            let t = f64::from(k);
            let mut plots = seen(k);
            plots.extend(
                from(k).map(|n| report(5, SensorKind::Adsb, t - 0.3, k, place(n, t - 0.3))),
            );
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            [0, 1].map(|n| k > 5 && nearest(&tracks, place(n, t)).callsign() == Some(name()))
        })
        .collect()
}

/// Up to four reports on somebody else's track name nobody; from the fifth in a row on the name is that one's.
#[test]
fn a_name_changes_tracks_by_five_reports_in_a_row_and_not_by_fewer() {
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        for misplaced in [1, 2, 4] {
            for honest_after in [0, 2, 60] {
                let from = |k: u32| match k {
                    ..60 => Some(0),
                    _ if k < 60 + misplaced => Some(1),
                    _ if k < 60 + misplaced + honest_after => Some(0),
                    _ => None,
                };
                let called = called(&config, 90, &from);
                let wrong = called[10..].iter().position(|named| *named != [true, false]);
                assert_eq!(wrong, None, "{misplaced} misplaced, {honest_after} after");
            }
        }
        let moved = called(&config, 90, &|k| Some(usize::from(k >= 60)));
        assert_eq!(moved[58], [true, false]);
        assert_eq!(moved[70], [false, true]);
    }
}

/// What withholds a name withholds the address with it.
#[test]
fn a_doubted_name_has_no_address_either() {
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let mut tracker = Tracker::new(config);
        for k in 1..=70_u32 {
            let t = f64::from(k);
            let mut plots = seen(k);
            let from = place(0, t - 0.3) + Vector2::new(if k > 50 { 7_500.0 } else { 0.0 }, 0.0);
            let mut own = report(5, SensorKind::Adsb, t - 0.3, 1, from);
            own.identity = Some(Identity::Address(0x4B_1234));
            plots.push(own);
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            let mine = (k > 10).then(|| nearest(&tracks, place(0, t)));
            if k == 50 {
                assert_eq!(mine.and_then(|track| track.address), Some(0x4B_1234));
            }
            if k >= 61 {
                let mine = mine.expect("its track");
                assert_eq!((mine.address, mine.callsign()), (None, None), "{k}");
            }
        }
    }
}

/// Who calls himself otherwise from some time on is one target with the new name, not a second one beside the old.
#[test]
fn who_changes_his_name_is_one_track_with_the_new_one() {
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let mut tracker = Tracker::new(config);
        for k in 1..=120_u32 {
            let t = f64::from(k);
            let mut plots = seen(k);
            let mut own = report(5, SensorKind::Adsb, t - 0.3, 1, place(0, t - 0.3));
            if k >= 40 {
                own.identity = Some(Identity::Callsign(Callsign::new("XYZ2")));
            }
            plots.push(own);
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            if k == 39 {
                assert_eq!(nearest(&tracks, place(0, t)).callsign(), Some(name()));
            }
            if k >= 70 {
                assert_eq!(tracks.len(), 2, "{k}");
                let mine = nearest(&tracks, place(0, t));
                assert_eq!(mine.callsign(), Some(Callsign::new("XYZ2")), "{k}");
            }
        }
    }
}

/// Whose transponder is silent keeps his track when another one with a name comes to stand beside him: both are seen every scan.
#[test]
fn a_name_beside_one_that_is_heard_no_more_is_another_target() {
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let mut tracker = Tracker::new(config);
        for k in 1..=120_u32 {
            let t = f64::from(k);
            let mut plots = vec![plot(t - 0.5, 0, 0.0, 0.0)];
            if k < 40 {
                plots.push(report(5, SensorKind::Adsb, t - 0.3, k, Point2::origin()));
            }
            // It comes from 300 m away and stands 40 m beside from then on.
            let beside =
                Point2::new(0.0, (300.0 - 10.0 * f64::from(k.saturating_sub(60))).max(40.0));
            if k >= 60 {
                plots.push(plot(t - 0.5, 1, beside.x, beside.y));
                let mut own = report(5, SensorKind::Adsb, t - 0.3, k, beside);
                own.identity = Some(Identity::Callsign(Callsign::new("XYZ2")));
                plots.push(own);
            }
            let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            if k >= 70 {
                assert_eq!(tracks.len(), 2, "{k}");
                assert_ne!(
                    nearest(&tracks, Point2::origin()).callsign(),
                    Some(Callsign::new("XYZ2")),
                    "{k}"
                );
            }
        }
    }
}
