//! Somebody's own rules in place of ours, and the files' order.

use super::super::own::{Association, GatedPair, Initiation, Shown, Trial};
use super::*;
use crate::frames::Point2;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// All pairs by distance, greedily: what `nearest` does.
#[derive(Debug)]
struct Greedy;

impl Association for Greedy {
    fn assign(&self, pairs: &[GatedPair]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|&a, &b| pairs[a].d2.total_cmp(&pairs[b].d2).then(a.cmp(&b)));
        order
    }
}

/// Never the same plot twice, and nothing that is there.
#[derive(Debug)]
struct Mad;

impl Association for Mad {
    fn assign(&self, pairs: &[GatedPair]) -> Vec<usize> {
        (0..pairs.len()).chain(0..pairs.len()).chain([usize::MAX]).collect()
    }
}

/// Plots near the reference point begin nothing; five plots confirm.
#[derive(Debug)]
struct Slow;

impl Initiation for Slow {
    fn begins(&self, plot: &Plot) -> bool {
        plot.position_m.coords.norm() > 300.0
    }
    fn judge(&self, shown: &Shown) -> Trial {
        match (shown.plots >= 5, shown.looks > 20) {
            (true, _) => Trial::Confirmed,
            (_, true) => Trial::Dropped,
            _ => Trial::Goes,
        }
    }
}

/// Position and number of each track after each of 60 scans.
fn run(mut tracker: Tracker) -> Vec<(u32, u16, Point2<f64>)> {
    let (paths, radar) = (traffic(), tower(5, 0.95, 4));
    let mut out = Vec::new();
    for k in 1..=60 {
        let plots: Vec<Plot> = radar.scan(k, &paths).into_iter().map(|looked| looked.0).collect();
        let tracks = tracker.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
        out.extend(tracks.iter().map(|t| (k, t.number, t.position_m)));
    }
    out
}

#[test]
fn an_association_of_ones_own_decides_and_cannot_break_the_tracker() {
    let tracker = || Tracker::new(TrackingConfig::paper());
    let ours = run(tracker());
    assert!(ours.len() > 200);
    assert_eq!(run(tracker().with_association(Arc::new(Greedy))), ours, "the rule that ours is");
    let mad = run(tracker().with_association(Arc::new(Mad)));
    assert!(mad.len() > 200, "whatever it says, a track gets one plot and a plot one track");
}

#[test]
fn an_initiation_of_ones_own_says_where_tracks_begin_and_when_they_are_shown() {
    let ours = run(Tracker::new(TrackingConfig::paper()));
    let own = run(Tracker::new(TrackingConfig::paper()).with_initiation(Arc::new(Slow)));
    let first = |all: &[(u32, u16, Point2<f64>)]| all.iter().map(|t| t.0).min().expect("tracks");
    assert_eq!((first(&ours), first(&own)), (3, 5));
    // Nobody inside when it was first shown.
    let mut seen = BTreeSet::new();
    let fresh: Vec<_> = own.iter().filter(|t| seen.insert(t.1)).collect();
    assert!(!fresh.is_empty() && fresh.iter().all(|t| t.2.coords.norm() > 200.0));
}

/// A walk from a datagram to a track goes one way: no file of the tracker knows, over others, itself.
#[test]
fn no_file_of_the_tracker_is_in_a_circle() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/fusion");
    let mut files: BTreeMap<String, String> = BTreeMap::new();
    for folder in [root.clone(), root.join("stages")] {
        for entry in std::fs::read_dir(&folder).expect("there") {
            let path = entry.expect("readable").path();
            let name = path.file_stem().and_then(|n| n.to_str()).unwrap_or("").to_owned();
            if path.extension().is_some_and(|e| e == "rs") && name != "mod" {
                files.insert(name, std::fs::read_to_string(&path).expect("text"));
            }
        }
    }
    assert!(files.len() > 25);
    let knows = |text: &str| -> BTreeSet<String> {
        let lines = text.lines().filter(|l| l.trim_start().starts_with("use "));
        let words = lines.flat_map(|l| l.split(|c: char| !(c.is_alphanumeric() || c == '_')));
        let own = |line: &&str| files.contains_key(*line);
        words.filter(own).map(str::to_owned).collect()
    };
    // `use crate::association::gate` and the like are other folders' files.
    let text = |t: &str| -> String {
        let of_ours = |l: &&str| !l.contains("crate::") || l.contains("crate::fusion");
        t.lines().filter(of_ours).collect::<Vec<_>>().join("\n")
    };
    let graph: BTreeMap<String, BTreeSet<String>> = files
        .iter()
        .map(|(name, t)| {
            (name.clone(), knows(&text(t)).into_iter().filter(|k| k != name).collect())
        })
        .collect();
    let mut left = graph;
    while let Some(leaf) = left
        .iter()
        .find(|(_, knows)| knows.iter().all(|k| !left.contains_key(k)))
        .map(|(name, _)| name.clone())
    {
        left.remove(&leaf);
    }
    assert!(left.is_empty(), "in a circle, or above one: {left:?}");
}
