//! The lives of tracks: how soon they are confirmed, how many are of nobody, how often a target's track is renewed; for both
//! ways to decide (`life = "m_of_n"` and `"existence"`) on the same plots.

use crate::profiles::Seen;
use crate::zurich::Traffic;
use models::flight_list::FlightList;
use models::fusion::{Outcome, Tracker, TrackingConfig};
use models::sensors::Truth;
use models::track::TrackStatus;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};

/// What became of the tracks of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lives {
    /// Tracks that were confirmed.
    pub confirmed: u64,
    /// Of these: begun by a false plot, or without a target when they were confirmed.
    pub of_nobody: u64,
    /// Movers that a track had.
    pub targets: u64,
    /// Confirmed tracks of a mover beyond its first one.
    pub renewals: u64,
    /// Mean scans from a track's first plot to its confirmation.
    pub latency_scans: f64,
    /// Reports of tracks whose target is gone, or that never had one.
    pub reports_of_nobody: u64,
    /// Reports.
    pub reports: u64,
}

/// Tracks the plots of a run and counts.
#[must_use]
pub fn lives(scene: &Scene, seen: &Seen, config: &TrackingConfig, flights: &FlightList) -> Lives {
    let truth = Traffic(scene);
    let mut tracker = Tracker::new(config.clone());
    // By order of birth: first scan, and the mover of the last plot.
    let mut known: BTreeMap<u64, (usize, Option<u64>)> = BTreeMap::new();
    let mut serial_of: BTreeMap<u16, u64> = BTreeMap::new();
    let mut had: BTreeSet<u64> = BTreeSet::new();
    let (mut out, mut waited) = (Lives::default(), 0);
    for (scan, ((to, plots), causes)) in seen.scans.iter().zip(&seen.causes).enumerate() {
        let tracks = tracker.scan(*to, plots, flights);
        for (outcome, cause) in tracker.outcomes().iter().zip(causes) {
            if let Outcome::Used { serial, .. } = outcome {
                known.entry(*serial).or_insert((scan, None)).1 = *cause;
            }
        }
        serial_of.extend(tracker.serials().filter_map(|(serial, number)| Some((number?, serial))));
        for track in tracks.iter().filter(|t| t.status != TrackStatus::Last) {
            let serial = serial_of.get(&track.number).copied().unwrap_or(u64::MAX);
            let (began, mover) = known.get(&serial).copied().unwrap_or((scan, None));
            let mover = mover.filter(|key| truth.at(*key as usize, *to).is_some());
            out.reports += 1;
            out.reports_of_nobody += u64::from(mover.is_none());
            if track.first {
                out.confirmed += 1;
                waited += scan - began;
                match mover {
                    Some(key) => out.renewals += u64::from(!had.insert(key)),
                    None => out.of_nobody += 1,
                }
            }
        }
    }
    out.targets = had.len() as u64;
    out.latency_scans = waited as f64 / out.confirmed.max(1) as f64;
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{crowds, profiles, zurich};
    use models::fusion::config::ExistenceRules;

    /// Both ways on scenes and seeds that nothing was chosen on. Existence confirms a little sooner with no more tracks of
    /// nobody, but ends more in places that nobody was seen to pass before (0 to 3 renewals more): no profile takes it.
    #[test]
    fn existence_confirms_as_soon_as_counted_hits_and_costs_few_renewals() {
        let scenes = [
            ("Zurich", zurich::scene().expect("ships")),
            ("35 movers", crowds::thirty_five(17).expect("made of what ships")),
        ];
        for (name, scene) in &scenes {
            for seed in [611, 612] {
                let seen = profiles::see(scene, seed, 600.0).expect("sound");
                for base in [TrackingConfig::paper(), TrackingConfig::accurate()] {
                    let own = scene.tracking_config();
                    let config = TrackingConfig { sensors: own.sensors, sizes: own.sizes, ..base };
                    let counted = lives(scene, &seen, &config, &scene.flight_list);
                    let mut believed = config;
                    believed.life.existence = Some(ExistenceRules::default());
                    let believed = lives(scene, &seen, &believed, &scene.flight_list);
                    println!("{name} {seed}: counted {counted:?}\n  believed {believed:?}");
                    assert_eq!(believed.targets, counted.targets, "{name} {seed}");
                    assert!(believed.of_nobody <= counted.of_nobody + 1, "{name} {seed}");
                    assert!(believed.renewals <= counted.renewals + 4, "{name} {seed}");
                    assert!(believed.latency_scans <= counted.latency_scans + 0.1, "{name} {seed}");
                }
            }
        }
    }
}
