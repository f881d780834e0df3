use super::super::areas::AreaRules;
use super::super::recording::Target;
use super::super::requirements::{Measure, Requirement};
use super::*;
use proptest::prelude::*;

fn line(name: &str, from: (f64, f64), v: (f64, f64), scans: u32) -> Target {
    let at = |k: u32| TruthPoint {
        time: SimTime::from_s(f64::from(k)),
        position_m: Point2::new(from.0 + v.0 * f64::from(k), from.1 + v.1 * f64::from(k)),
        velocity_mps: Vector2::new(v.0, v.1),
        height_m: Some(0.0),
    };
    Target { name: name.into(), path: (0..scans).map(at).collect() }
}

fn report(track: u64, k: u32, x: f64, y: f64, label: &str) -> Report {
    let time = SimTime::from_s(f64::from(k));
    Report {
        track,
        time,
        published: Some(time.plus_s(0.25)),
        position_m: Point2::new(x, y),
        velocity_mps: Some(Vector2::new(10.0, 0.0)),
        label: label.into(),
    }
}

fn scored(targets: Vec<Target>, reports: Vec<Report>) -> Score {
    let mut recording = Recording { targets, reports, ..Recording::default() };
    recording.put_in_order();
    score(&recording, &AreaMap::open(AreaRules::default()), &Rules::default())
}

#[test]
fn a_perfect_track_has_no_errors_and_a_late_one_is_behind() {
    let reports =
        |shift: f64| (0..20).map(|k| report(7, k, 10.0 * f64::from(k) - shift, 0.0, "A")).collect();
    let target = || vec![line("A", (0.0, 0.0), (10.0, 0.0), 20)];
    let perfect = scored(target(), reports(0.0));
    assert_eq!(perfect.rmse_m(), Some(0.0));
    assert_eq!(perfect.gospa.total_m, 0.0);
    assert_eq!((perfect.swaps, perfect.breaks, perfect.false_tracks), (0, 0, 0));
    assert_eq!(perfect.latency_s, Some(0.25));
    let area = &perfect.areas[0];
    assert_eq!((area.area, area.reports_due(1.0)), (Area::Elsewhere, (20, 20)));
    assert_eq!((area.right_labels, area.labels_due), (20, 20));
    let late = scored(target(), reports(5.0));
    assert_eq!(late.rmse_m(), Some(5.0));
    assert!(late.areas[0].behind_s.iter().all(|s| (s - 0.5).abs() < 1e-12));
    assert_eq!(late.gospa.localisation_m2, 25.0);
}

#[test]
fn holes_are_missed_reports_and_gaps() {
    // Scans 5, 6, 7 and 12 are missing: one gap of four seconds, one of two.
    let reports = (0..20)
        .filter(|k| ![5, 6, 7, 12].contains(k))
        .map(|k| report(7, k, 10.0 * f64::from(k), 0.0, ""))
        .collect();
    let found = scored(vec![line("A", (0.0, 0.0), (10.0, 0.0), 20)], reports);
    let area = &found.areas[0];
    assert_eq!(area.reports_due(1.0), (16, 20));
    assert_eq!(area.reports_due(2.0), (9, 10));
    assert_eq!(area.gaps(4.0, 1.0), (1, 20));
    assert_eq!(area.gaps(2.0, 1.0), (2, 20));
    assert_eq!(area.gaps(4.1, 1.0), (0, 20));
    assert_eq!((area.right_labels, area.wrong_labels, area.labels_due), (0, 0, 16));
    assert_eq!((found.swaps, found.breaks), (0, 0), "the same track again is no break");
}

#[test]
fn tracks_that_change_places_are_swaps_and_passing_each_other_is_none() {
    // Two targets meet at scan 10, 3 m apart.
    let targets =
        || vec![line("A", (0.0, 0.0), (10.0, 0.0), 21), line("B", (200.0, 3.0), (-10.0, 0.0), 21)];
    let tracks = |swap: bool| {
        let mut reports = Vec::new();
        for k in 0..21 {
            let (a, b) = (10.0 * f64::from(k), 200.0 - 10.0 * f64::from(k));
            let (one, two) = if swap && k >= 10 { (2, 1) } else { (1, 2) };
            reports.push(report(one, k, a, 0.0, "A"));
            reports.push(report(two, k, b, 3.0, "B"));
        }
        reports
    };
    let passing = scored(targets(), tracks(false));
    assert_eq!((passing.swaps, passing.breaks), (0, 0));
    let swapped = scored(targets(), tracks(true));
    assert_eq!((swapped.swaps, swapped.breaks), (2, 2));
    assert_eq!(swapped.targets[0].tracks, [1, 2]);
}

#[test]
fn a_track_that_reports_often_follows_one_target_and_none_beside_it() {
    // Two targets 30 m apart, of which the second has no track; four reports a scan are no more than one.
    let targets =
        || vec![line("A", (0.0, 0.0), (10.0, 0.0), 20), line("B", (0.0, 30.0), (10.0, 0.0), 20)];
    let of = |a_scan: u32| {
        let reports = (0..19 * a_scan).map(|k| {
            let s = f64::from(k) / f64::from(a_scan);
            let time = SimTime::from_s(s);
            Report { time, published: Some(time.plus_s(0.25)), ..report(7, 0, 10.0 * s, 0.0, "") }
        });
        scored(targets(), reports.collect())
    };
    let (once, often) = (of(1), of(4));
    assert_eq!((once.missed_targets(), often.missed_targets()), (1, 1), "B is followed by nobody");
    assert_eq!((often.swaps, often.breaks), (0, 0));
    assert!((once.gospa.false_m2 - often.gospa.false_m2).abs() < 1e-9, "{:?}", often.gospa);
    assert!(often.rmse_m().expect("reports") < 1e-9, "each at its own time");
}

#[test]
fn a_gap_is_one_across_an_area_and_no_longer_than_the_target_at_its_ends() {
    // Known from scan 5 to scan 14, and between them from 8 to 10 not.
    let reports = (5..15)
        .filter(|k| ![8, 9, 10].contains(k))
        .map(|k| report(7, k, 10.0 * f64::from(k), 0.0, ""))
        .collect();
    let found = scored(vec![line("A", (0.0, 0.0), (10.0, 0.0), 20)], reports);
    let area = &found.areas[0];
    // Five scans before, four seconds between, five scans after.
    assert_eq!((area.gaps(5.0, 1.0).0, area.gaps(5.5, 1.0).0), (2, 0));
    assert_eq!((area.gaps(4.0, 1.0).0, area.gaps(4.5, 1.0).0), (3, 2));
    // It leaves the ground within the gap: one gap of eight seconds, where it began.
    let mut target = line("A", (0.0, 0.0), (10.0, 0.0), 20);
    target.path.iter_mut().skip(10).for_each(|p| p.height_m = Some(300.0));
    let reports = (0..20)
        .filter(|k| !(7..14).contains(k))
        .map(|k| report(7, k, 10.0 * f64::from(k), 0.0, ""))
        .collect();
    let found = scored(vec![target], reports);
    assert_eq!(found.areas.len(), 2);
    let long = |at: usize| found.areas[at].gaps(8.0, 1.0).0;
    assert_eq!(long(0) + long(1), 1, "one gap, not two shorter ones");
    let (ground, air) = match found.areas[0].area {
        Area::Airborne => (1, 0),
        _ => (0, 1),
    };
    assert_eq!((long(ground), found.areas[air].gaps(1.5, 1.0).0), (1, 0));
    assert_eq!(found.areas[air].reports_due(1.0), (6, 10), "its scans are missed where it was");
}

#[test]
fn a_number_that_comes_again_when_its_target_is_gone_is_no_swap() {
    let mut later = line("B", (0.0, 500.0), (10.0, 0.0), 60);
    later.path.retain(|p| p.time.s() >= 40.0);
    let targets = vec![line("A", (0.0, 0.0), (10.0, 0.0), 10), later];
    let a = (0..10).map(|k| report(7, k, 10.0 * f64::from(k), 0.0, ""));
    let b = (40..60).map(|k| report(7, k, 10.0 * f64::from(k), 500.0, ""));
    let found = scored(targets, a.chain(b).collect());
    assert_eq!((found.swaps, found.missed_targets()), (0, 0));
}

#[test]
fn what_follows_nothing_is_false_and_what_nothing_follows_is_missed() {
    let reports = (3..10).map(|k| report(9, k, 5000.0, 0.0, "A")).collect();
    let found = scored(vec![line("A", (0.0, 0.0), (1.0, 0.0), 10)], reports);
    assert_eq!((found.false_tracks, found.missed_targets()), (1, 1));
    assert_eq!(found.rmse_m(), None);
    let area = &found.areas[0];
    assert_eq!((area.nearest_target_m.len(), area.reports_due(1.0)), (7, (0, 10)));
    assert!(area.nearest_target_m[0] > 4900.0);
    assert_eq!(scored(Vec::new(), Vec::new()), Score::default());
}

#[test]
fn a_track_that_coasts_when_its_target_has_ended_is_false_and_counted_by_itself_too() {
    // The target ends at 9 s, another one is far away; the track goes on to 39 s.
    let reports = (0..40).map(|k| report(7, k, 10.0 * f64::from(k), 0.0, "A")).collect();
    let targets =
        vec![line("A", (0.0, 0.0), (10.0, 0.0), 10), line("B", (0.0, 9000.0), (0.0, 0.0), 40)];
    let found = scored(targets, reports);
    // 30 reports of a target that is not there; 15 of them within the 15 s after its end.
    assert_eq!(found.areas[0].false_reports(1000.0), (30, 15));
    assert_eq!((found.areas[0].nearest_target_m.len(), found.areas[0].after_end_m.len()), (40, 15));
    let judged = Requirement {
        standard: String::new(),
        area: String::new(),
        name: String::new(),
        measure: Measure::FalseReports,
        probability: 0.5,
        at_least: false,
        threshold: 1000.0,
        interval_s: 1.0,
        gap_s: 0.0,
    };
    assert_eq!(judged.count(&found.areas[0]), (30, 40), "the verdict knows of no grace");
    assert_eq!((found.areas[0].unreported, found.areas[0].before_first), (40, 40), "B");
}

proptest! {
    #[test]
    fn hostile_recordings_are_scored_without_panic(
        points in proptest::collection::vec((0u64..5, -20i64..40, any::<f64>(), any::<f64>()), 0..60),
        reports in proptest::collection::vec((0u64..4, -20i64..40, any::<f64>(), any::<f64>()), 0..60),
    ) {
        let mut targets: Vec<Target> = (0..5).map(|_| Target::default()).collect();
        for (target, s, x, y) in points {
            targets[target as usize].path.push(TruthPoint {
                time: SimTime(s * 500_000_000),
                position_m: Point2::new(x, y),
                velocity_mps: Vector2::new(y, x),
                height_m: Some(x),
            });
        }
        let reports = reports.into_iter().map(|(track, s, x, y)| Report {
            track,
            time: SimTime(s * 400_000_000),
            published: None,
            position_m: Point2::new(x, y),
            velocity_mps: Some(Vector2::new(y, x)),
            label: String::new(),
        });
        let found = scored(targets, reports.collect());
        for area in &found.areas {
            let (hits, due) = area.reports_due(1.0);
            prop_assert!(hits <= due);
            prop_assert!(area.position_m.windows(2).all(|w| w[0] <= w[1]));
        }
    }
}
