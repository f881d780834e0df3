//! Which plots are of one target: by the tracker itself, run over the whole recording.

use crate::flight_list::FlightList;
use crate::fusion::config::TrackingConfig;
use crate::fusion::near_side::Body;
use crate::fusion::state::{Outcome, Statistics, Tracker};
use crate::plot::{Callsign, Plot};
use crate::time::SimTime;
use std::collections::BTreeMap;

/// Two tracks of one name that are farther apart in time than this are two stays of the target, s.
const LONGEST_GAP_S: f64 = 120.0;

/// The plots of one target.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    /// The tracks that had them, by order of birth, each with its number.
    pub(super) tracks: Vec<(u64, u16)>,
    /// In the order of time; the nominal delay of their sensors is taken off the time, and their variances hold what the
    /// sensor's model adds.
    pub(super) plots: Vec<Plot>,
    /// Which ones these are: scan, and place in it; not in order.
    pub(super) places: Vec<(usize, usize)>,
    pub(super) body: Option<Body>,
    /// What it calls itself, or was given as its label last.
    pub(super) callsign: Option<Callsign>,
    /// What it calls itself.
    named: Option<Callsign>,
    /// Whether it was ever confirmed.
    confirmed: bool,
}

/// All plots of confirmed tracks by target, and what the tracker counted.
pub(super) fn gather(
    config: &TrackingConfig,
    flights: &FlightList,
    scans: &[(SimTime, Vec<Plot>)],
) -> (Vec<Gathered>, Statistics) {
    let mut tracker = Tracker::new(config.clone());
    let mut found: BTreeMap<u64, Gathered> = BTreeMap::new();
    for (scan, (to, plots)) in scans.iter().enumerate() {
        let _ = tracker.scan(*to, plots, flights);
        for (place, (plot, outcome)) in plots.iter().zip(tracker.outcomes()).enumerate() {
            let Outcome::Used { number, serial, .. } = outcome else { continue };
            let model = config.sensor(plot.sensor, plot.kind).sound();
            let extra_m2 = model.extra_sigma_m * model.extra_sigma_m;
            let mut own = *plot;
            own.time = plot.time.plus_s(-model.latency_s);
            (own.along_m2, own.across_m2) = (plot.along_m2 + extra_m2, plot.across_m2 + extra_m2);
            let target = found.entry(*serial).or_default();
            target.plots.push(own);
            target.places.push((scan, place));
            if let (Some(number), true) = (number, target.tracks.is_empty()) {
                target.tracks.push((*serial, *number));
            }
        }
        for track in &tracker.tracks {
            if let Some(target) = found.get_mut(&track.serial) {
                target.confirmed |= track.number.is_some();
                if let (Some(number), true) = (track.number, target.tracks.is_empty()) {
                    target.tracks.push((track.serial, number));
                }
                target.body = track.body().or(target.body);
                target.callsign = track.callsign.or(track.entry).or(target.callsign);
                target.named = track.callsign.or(target.named);
            }
        }
    }
    let mut all: Vec<Gathered> = found.into_values().filter(|t| t.confirmed).collect();
    for target in &mut all {
        target.plots.sort_by_key(|p| (p.time, p.sensor, p.sequence));
    }
    (joined(all), *tracker.statistics())
}

/// Tracks that call themselves by one name, one after the other, are one target. A label by what a track shows is not enough: of two
/// targets that are taken for one line of the list a way from the one to the other would be made.
fn joined(all: Vec<Gathered>) -> Vec<Gathered> {
    let mut out: Vec<Gathered> = Vec::with_capacity(all.len());
    for next in all {
        let (Some(name), Some(first)) = (next.named, next.plots.first()) else {
            out.push(next);
            continue;
        };
        let follows = |before: &&mut Gathered| {
            before.named == Some(name)
                && before.plots.last().is_some_and(|last| {
                    let gap_s = first.time.since_s(last.time);
                    (0.0..=LONGEST_GAP_S).contains(&gap_s)
                })
        };
        match out.iter_mut().rev().find(follows) {
            Some(before) => {
                before.tracks.extend(next.tracks);
                before.plots.extend(next.plots);
                before.places.extend(next.places);
                before.body = next.body.or(before.body);
            }
            None => out.push(next),
        }
    }
    out
}
