//! Single decisions of the tracker, each at its limit: who gets a plot that two want, and when a state is begun again.

use super::hard_cases::plot;
use super::*;
use crate::fusion::buffers::Candidate;
use crate::fusion::weights::Local;
use config::{AssociationMethod, SensorModel};

/// Two that stand 8 m apart, and looks that bring one plot between them: it is one track's, the other goes without.
#[test]
fn a_plot_that_two_tracks_want_is_taken_once() {
    for association in [AssociationMethod::Nearest, AssociationMethod::Global] {
        let mut tracker = Tracker::new(TrackingConfig { association, ..TrackingConfig::paper() });
        let list = FlightList::default();
        for k in 1..=12 {
            let t = f64::from(k);
            let both = [plot(t - 0.5, 0, 0.0, 0.0), plot(t - 0.5, 1, 8.0, 0.0)];
            tracker.scan(SimTime::from_s(t), &both, &list);
        }
        for k in 13..=15 {
            let t = f64::from(k);
            let taken = tracker.statistics().gate_1;
            let between = plot(t - 0.5, 0, 3.9, 0.0);
            let tracks = tracker.scan(SimTime::from_s(t), &[between], &list);
            assert_eq!(tracks.len(), 2, "{association:?} {k}");
            let fresh = tracks.iter().filter(|track| track.last_plot == between.time).count();
            assert_eq!(fresh, 1, "{association:?} {k}");
            assert_eq!(tracker.statistics().gate_1, taken + 1, "{association:?} {k}");
        }
    }
}

/// Two refused plots begin the state of what moves again if they are of successive looks; what lies looks apart is no pair.
#[test]
fn refused_plots_begin_a_state_again_only_in_successive_looks() {
    let list = FlightList::default();
    let restarts = |gap_s: u32| {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        for k in 1..=12 {
            let t = f64::from(k);
            tracker.scan(SimTime::from_s(t), &[plot(t - 0.5, 0, 8.0 * t, 0.0)], &list);
        }
        for k in 13..=13 + gap_s {
            let t = f64::from(k);
            let seen = (k == 13 || k == 13 + gap_s).then(|| plot(t - 0.5, 0, 100.0, 95.0));
            tracker.scan(SimTime::from_s(t), seen.as_slice(), &list);
        }
        (tracker.statistics().restarts, tracker.statistics().refused)
    };
    assert_eq!([1, 2, 3, 4].map(restarts), [(1, 2), (1, 2), (0, 2), (0, 2)]);
}

/// What stands is where it was: two plots of another one beside it, which is seen when it is not, begin nothing again.
#[test]
fn refused_plots_do_not_begin_the_state_of_what_stands_again() {
    let list = FlightList::default();
    let mut tracker = Tracker::new(TrackingConfig::paper());
    for k in 1..=24 {
        let t = f64::from(k);
        let seen = plot(t - 0.5, 0, if k <= 16 { 0.0 } else { 95.0 }, 0.0);
        let tracks = tracker.scan(SimTime::from_s(t), &[seen], &list);
        let first = tracks.iter().find(|track| track.position_m.x < 20.0);
        assert!(k < 4 || first.is_some(), "{k}: {tracks:?}");
    }
    assert_eq!((tracker.statistics().restarts, tracker.tracks.len()), (0, 2));
}

/// What two tracks claim of one plot, each by itself with less than even odds: it is theirs if one of them has it more likely than not, else
/// whoever else may have it.
#[test]
fn a_plot_is_used_up_by_what_all_tracks_claim_of_it() {
    let mut tracker = Tracker::new(TrackingConfig::accurate());
    for k in 1..=12 {
        let t = f64::from(k);
        let both = [plot(t - 0.5, 0, 0.0, 0.0), plot(t - 0.5, 1, 8.0, 0.0)];
        tracker.scan(SimTime::from_s(t), &both, &FlightList::default());
    }
    let between = plot(12.5, 0, 4.0, 0.0);
    let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
    let used = |claims: [f64; 2]| {
        let mut tracker = tracker.clone();
        let mut work = std::mem::take(&mut tracker.work);
        work.candidates = vec![Candidate { plot: between, index: 0 }];
        (work.used, work.track_used) = (vec![false], vec![false; 2]);
        tracker.outcomes = vec![Outcome::Unused];
        let local = Local { tracks: vec![0, 1], plots: vec![0], ..Local::default() };
        let rows = claims.into_iter().enumerate();
        let rows = rows.map(|(row, claim)| (row, 1.0 - claim, std::iter::once((0, claim))));
        tracker.take_rows(0, &local, rows, &model, &mut work);
        assert_eq!(work.track_used, [false; 2], "neither has it for certain");
        work.used[0]
    };
    assert_eq!([[0.2, 0.25], [0.24, 0.25]].map(used), [false; 2]);
    assert_eq!([[0.26, 0.25], [0.3, 0.3], [0.45, 0.4]].map(used), [true; 3]);
}

/// Who else follows a track, and how lately.
#[test]
fn another_sensor_follows_a_track_while_its_plots_are_recent() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    for k in 1..=5 {
        let t = f64::from(k);
        tracker.scan(SimTime::from_s(t), &[plot(t - 0.5, 0, 8.0 * t, 0.0)], &FlightList::default());
    }
    let (track, own) = (&tracker.tracks[0], plot(0.0, 0, 0.0, 0.0).sensor);
    let other = SensorId(own.0 + 1);
    let follows = |sensor, at_s| track.has_other_than(sensor, SimTime::from_s(at_s), 3.0);
    assert_eq!([4.5, 7.5, 7.6].map(|t| follows(other, t)), [true, true, false]);
    assert!(!follows(own, 4.5));
}

/// What was a second ago is published where it is asked for, of all that were published then.
#[test]
fn a_second_ago_is_told_of_what_was_published_then_and_only_if_asked_for() {
    for asked in [true, false] {
        let mut tracker =
            Tracker::new(TrackingConfig { second_ago: asked, ..TrackingConfig::paper() });
        let mut told = Vec::new();
        for k in 1..=9 {
            let t = f64::from(k);
            let tracks = tracker.scan(
                SimTime::from_s(t),
                &[plot(t - 0.5, 0, 8.0 * t, 0.0)],
                &FlightList::default(),
            );
            told.extend(tracks.iter().map(|t| (t.first, t.second_ago.map(|ago| ago.time))));
        }
        assert!(told.len() > 3 && told[0] == (true, None), "{told:?}");
        let first = 9 - told.len() + 1;
        for (n, (again, then)) in told.iter().enumerate().skip(1) {
            let before = SimTime::from_s((first + n - 1) as f64);
            assert_eq!((*again, *then), (false, asked.then_some(before)), "{asked} {n}");
        }
    }
}

/// By existence too, a track that has become too wide to say where its target is ends.
#[test]
fn a_track_that_is_too_wide_ends_however_sure_its_target_is() {
    let mut config = TrackingConfig::paper();
    config.life.existence = Some(config::ExistenceRules::default());
    for (radius_m, deleted) in [(1e-3, 1), (1e3, 0)] {
        let mut tracker = Tracker::new(config.clone());
        for k in 1..=17 {
            let t = f64::from(k);
            if k == 14 {
                assert_eq!(tracker.statistics().confirmed, 1);
                tracker.config.life.delete_radius_m = radius_m;
            }
            let plots = if k <= 14 { vec![plot(t - 0.5, 0, 8.0 * t, 0.0)] } else { Vec::new() };
            tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            // While its plots come it is as wide as they are.
            assert!(k > 14 || tracker.statistics().deleted == 0);
        }
        assert_eq!(tracker.statistics().deleted, deleted, "{radius_m}");
    }
}

/// Tracks that plots from outside begin have their numbers behind all of ours, whoever reports more.
#[test]
fn what_outsiders_begin_is_numbered_behind_all_others() {
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let places = [(0.0, 0.0), (500.0, 0.0), (0.0, 700.0), (-400.0, -400.0)];
    let mut tracks = Vec::new();
    for k in 1..=6 {
        let t = f64::from(k);
        let plots: Vec<Plot> =
            (0..).zip(places).map(|(n, (x, y))| plot(t - 0.5, n, x, y)).collect();
        // Of the last one nothing is said: it is ours.
        tracker.mark_outside(vec![false, true, false]);
        tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
    }
    let behind = places.map(|(x, y)| {
        let near = |t: &&SystemTrack| (t.position_m - Point2::new(x, y)).norm() < 20.0;
        tracks.iter().find(near).expect("confirmed").number >= 4096
    });
    assert_eq!(behind, [false, true, false, false]);
}

/// Who is taken over at a time is not continued from a time before it, nor from one before the last scan.
#[test]
fn a_clock_that_is_set_back_behind_a_takeover_leaves_nothing() {
    use crate::filter::{Gaussian, Sym2};
    let r = Sym2 { xx: 4.0, xy: 0.0, yy: 4.0 };
    let state = Gaussian::at_position(Point2::new(50.0, 60.0), r, 5.0, 1.0);
    let list = FlightList::default();
    for (scan_s, adopt_s, next_s, resets) in
        [(None, 10.0, 5.0, 1), (None, 10.0, 10.5, 0), (Some(20.0), 10.0, 15.0, 1)]
    {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        if let Some(s) = scan_s {
            tracker.scan(SimTime::from_s(s), &[], &list);
        }
        assert_eq!(tracker.adopt(SimTime::from_s(adopt_s), &[state]), 1);
        let left = tracker.scan(SimTime::from_s(next_s), &[], &list).len();
        let found = tracker.statistics().clock_resets;
        assert_eq!((found, left), (resets, usize::from(resets == 0)), "{adopt_s} {next_s}");
    }
}

/// Of one look no track takes two plots, however they crowd, cross, jump and come in twos.
#[test]
fn of_one_look_a_track_takes_one_plot() {
    for (association, kinematic) in [
        (AssociationMethod::Nearest, true),
        (AssociationMethod::Global, true),
        (AssociationMethod::Nearest, false),
    ] {
        let mut config = TrackingConfig { association, ..TrackingConfig::paper() };
        config.gates.kinematic = kinematic;
        let mut tracker = Tracker::new(config);
        let mut used = 0;
        for k in 1..=60u32 {
            let t = f64::from(k);
            let key = DrawKey { run_seed: 3, sensor: 1, entity: 5, scan: k.into() };
            let mut rng = key.rng(Purpose::Study);
            let mut plots = Vec::new();
            for n in 0..20u32 {
                let (a, b) = normal_pair(&mut rng);
                let way = (f64::from(n % 5) - 2.0) * 8.0 * t;
                let jump = if uniform(&mut rng) < 0.1 { 25.0 } else { 1.0 };
                let (x, y) =
                    (15.0 * f64::from(n / 5) + way + jump * a, 9.0 * f64::from(n) + jump * b);
                plots.push(plot(t - 0.5, 2 * n, x, y));
                if uniform(&mut rng) < 0.3 {
                    plots.push(plot(t - 0.5, 2 * n + 1, x + 6.0 * a, y + 9.0));
                }
            }
            tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            let mut serials: Vec<u64> = tracker
                .outcomes()
                .iter()
                .filter_map(|o| match o {
                    Outcome::Used { serial, .. } => Some(*serial),
                    _ => None,
                })
                .collect();
            used += serials.len();
            serials.sort_unstable();
            let twice = serials.windows(2).find(|w| w[0] == w[1]);
            assert_eq!(twice, None, "{association:?} {k}");
        }
        assert!(used > 600, "{used}");
    }
}
