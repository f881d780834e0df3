//! Who stands and is not always seen: its track waits for it there, and goes with it when it leaves.

use super::*;
use std::collections::BTreeMap;

/// Where somebody stands who drives off east at `leaves_s` (1 m/s² to 10 m/s).
fn stands(x: f64, y: f64, leaves_s: f64) -> Box<Path> {
    drive(
        Point2::new(x, y),
        std::f64::consts::FRAC_PI_2,
        0.0,
        &[(leaves_s, 0.0, 0.0), (10.0, 1.0, 0.0), (200.0, 0.0, 0.0)],
    )
}

/// A track: whose plots it took, one after the other, and when it took the last one of each, s.
type Followed = BTreeMap<u64, Vec<(usize, f64)>>;

/// All are seen in every look of the first twenty, then with probability `detection`.
fn followed(
    config: &TrackingConfig,
    (seed, detection): (u64, f64),
    paths: &[Box<Path>],
    scans: u32,
) -> Followed {
    let mut tracker = Tracker::new(config.clone());
    let mut out = Followed::new();
    for k in 1..=scans {
        let looked = tower(seed, if k <= 20 { 1.0 } else { detection }, 0).scan(k, paths);
        let plots: Vec<Plot> = looked.iter().map(|l| l.0).collect();
        tracker.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
        for (outcome, (plot, cause)) in tracker.outcomes().iter().zip(&looked) {
            let (Outcome::Used { serial, number: Some(_), .. }, Some((path, _))) = (outcome, cause)
            else {
                continue;
            };
            let mine = out.entry(*serial).or_default();
            match mine.last_mut() {
                Some((before, at)) if before == path => *at = plot.time.s(),
                _ => mine.push((*path, plot.time.s())),
            }
        }
    }
    out
}

/// Two that stand 38 m apart and are seen in two looks of five: neither's track ever goes over to the other.
#[test]
fn what_stands_unseen_does_not_take_its_neighbours_plots() {
    for profile in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        let (mut swaps, mut tracks) = (0, 0);
        for seed in 1..=20 {
            let paths = [stands(520.0, 300.0, 1e4), stands(520.0, 338.0, 1e4)];
            let found = followed(&profile, (seed, 0.4), &paths, 400);
            tracks += found.len();
            for (serial, own) in found.iter().filter(|(_, own)| own.len() > 1) {
                println!("seed {seed}, track {serial}: {own:?}");
                swaps += own.len() - 1;
            }
        }
        println!("{swaps} swaps, {tracks} tracks of 40 that stand");
        assert_eq!(swaps, 0);
    }
}

/// One of two such leaves: its track goes with it wherever it is seen often enough to be followed, and never with the other.
#[test]
fn what_leaves_after_it_stood_unseen_keeps_its_track() {
    for profile in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        for (detection, least, most) in [(0.4, 13, 1), (0.7, 19, 0)] {
            let (mut kept, mut taken) = (0, 0);
            for seed in 1..=24 {
                let paths = [stands(520.0, 300.0, 60.0), stands(520.0, 338.0, 1e4)];
                let found = followed(&profile, (seed, detection), &paths, 90);
                kept += u32::from(found.values().filter(|own| own[0].0 == 0).count() == 1);
                taken += found.values().filter(|own| own.len() > 1).count();
            }
            println!("detection {detection}: {kept} of 24 keep their track, {taken} go over");
            assert!(taken <= most && kept >= least, "{detection}: {kept}, {taken}");
        }
    }
}
