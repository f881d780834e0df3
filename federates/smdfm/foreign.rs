//! What visitors did to a run, kept apart from what is ours.
//!
//! Plots of visitors and of real sensors, and tracks from the scan on in which they took such a plot, go into the digest
//! `foreign`; `digest` and `track_digest` hold the rest as if no visitor had been there. One that
//! touches ours (a common track, a gate, a shadow, an echo that merges) changes them, as it should;
//! tracks that took plots of ours and of visitors are counted.

use super::inlets::Inlets;
use super::received_truth::View;
use super::report::{plot_octets, track_octets};
use crate::runtime::digest::{Digest, combine};
use crate::runtime::messages::{FinalReport, Frame};
use models::fusion::{Outcome, Tracker};
use models::plot::{Plot, SensorId};
use models::sensors::PlotSink;
use models::track::SystemTrack;
use std::collections::{BTreeMap, BTreeSet};

/// The digests of a run's plots and tracks, ours and foreign.
#[derive(Clone, Debug, Default)]
pub struct Digests {
    plots: Digest,
    tracks: Digest,
    foreign: Digest,
    /// Serials of tracks that took a visitor's plot.
    taken: BTreeSet<u64>,
    /// Serials of published tracks by number.
    serials: BTreeMap<u16, u64>,
    /// Serials of tracks that took a plot of one of ours.
    ours: BTreeSet<u64>,
    touched: u64,
    /// When that was last looked through.
    pruned: Frame,
    external: bool,
}

/// Frames after which what is remembered of tracks is looked through.
const PRUNE_EVERY: Frame = 1200;

/// Which plots of a scan visitors caused or sensors of somebody else sent live, index by index.
#[must_use]
pub fn of_outsiders(view: &View<'_>, sink: &PlotSink, inlets: &Inlets) -> Vec<bool> {
    let visitor = |key| view.index_of(key).is_some_and(|index| !view.is_ours(index));
    let live = |plot: &Plot| !inlets.is_empty() && inlets.is_live(plot.sensor);
    let plots = sink.plots.iter().zip(&sink.causes);
    plots.map(|(plot, cause)| cause.key.is_some_and(visitor) || live(plot)).collect()
}

impl Digests {
    /// All of them in one number.
    #[must_use]
    pub fn state(&self) -> u64 {
        combine(&[self.plots.0, self.tracks.0, self.foreign.0])
    }

    /// A PDU of an outsider took effect.
    pub fn external(&mut self) {
        self.external = true;
    }

    /// Adds one scan; `outside` as [`of_outsiders`] gives it.
    pub fn scan(
        &mut self,
        frame: Frame,
        sink: &PlotSink,
        outside: &[bool],
        tracker: &Tracker,
        tracks: &[SystemTrack],
    ) {
        // Visitors' plots shift the numbers of those behind them.
        let mut before: BTreeMap<SensorId, u32> = BTreeMap::new();
        for (plot, outside) in sink.plots.iter().zip(outside) {
            if *outside {
                self.foreign.add(frame, &plot_octets(plot));
                *before.entry(plot.sensor).or_default() += 1;
            } else {
                let shift = before.get(&plot.sensor).copied().unwrap_or(0);
                let plot = Plot { sequence: plot.sequence.saturating_sub(shift), ..*plot };
                self.plots.add(frame, &plot_octets(&plot));
            }
        }
        let causes = sink.causes.iter().map(|cause| cause.key.is_some());
        for ((outcome, outside), caused) in tracker.outcomes().iter().zip(outside).zip(causes) {
            let Outcome::Used { serial, .. } = outcome else { continue };
            if !caused && !outside {
                continue;
            }
            let (set, other) = match outside {
                true => (&mut self.taken, &self.ours),
                false => (&mut self.ours, &self.taken),
            };
            self.touched += u64::from(set.insert(*serial) && other.contains(serial));
        }
        let numbered = || tracker.serials().filter_map(|(serial, number)| Some((number?, serial)));
        self.serials.extend(numbered());
        for track in tracks {
            let serial = self.serials.get(&track.number);
            let foreign = serial.is_some_and(|serial| self.taken.contains(serial));
            let digest = if foreign { &mut self.foreign } else { &mut self.tracks };
            digest.add(frame, &track_octets(track));
        }
        // Tracks that are gone need no memory.
        if frame >= self.pruned + PRUNE_EVERY {
            self.pruned = frame;
            self.serials = numbered().collect();
            let live: BTreeSet<u64> = tracker.serials().map(|(serial, _)| serial).collect();
            for set in [&mut self.ours, &mut self.taken] {
                set.retain(|serial| live.contains(serial));
            }
        }
    }

    /// Fills the digests of a run's end.
    pub fn finish(&self, visitors: usize, report: &mut FinalReport) {
        report.digests.push(("plots".into(), self.plots.0));
        report.digests.push(("tracks".into(), self.tracks.0));
        if self.external {
            report.digests.push(("foreign".into(), self.foreign.0));
            report.values.push(("visitors".into(), visitors as f64));
            report.values.push(("touched".into(), self.touched as f64));
        }
    }
}
