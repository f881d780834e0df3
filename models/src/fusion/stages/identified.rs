//! Plots with a name go first, to the track that has it.

use crate::filter::Measurement;
use crate::fusion::config::SensorModel;
use crate::fusion::stages::updated::How;
use crate::fusion::state::{Tracker, Work};
use crate::fusion::track_file::Stage;
use crate::plot::{Identity, Plot};

impl Tracker {
    /// Plots with an identity go first, to the track that has it.
    pub(in crate::fusion) fn take_identified(
        &mut self,
        from: usize,
        to: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        if work.candidates[from..to].iter().all(|c| c.plot.identity.is_none()) {
            return;
        }
        work.identities.clear();
        work.renamed.clear();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Ended {
                let callsign = track.callsign.map(Identity::Callsign);
                let address = track.address.map(Identity::Address);
                let names = callsign.into_iter().chain(address);
                work.identities.extend(names.map(|name| (name, index as u32)));
            }
        }
        work.identities.sort_unstable();
        for k in from..to {
            let plot = &work.candidates[k].plot;
            let Some(identity) = plot.identity else { continue };
            let first = work.identities.partition_point(|(name, _)| *name < identity);
            let holder = work.identities.get(first).filter(|(name, _)| *name == identity);
            let Some(&(_, track)) = holder else { continue };
            let track = track as usize;
            // Whoever holds the name: the plot starts no other track, nor is it taken for one on trial
            // while the holder is still called so.
            work.gated[k] = true;
            let taken = work.track_used[track];
            let found = Measurement::of(plot)
                .ok()
                .filter(|_| !taken)
                .and_then(|m| self.distance(&self.tracks[track], plot.time, plot, &m));
            if found.is_some_and(|pair| pair.d2 <= self.identified_gate) {
                self.update(track, How::Plot, k, model, work);
                continue;
            }
            self.tracks[track].name_refused += u32::from(!taken);
            work.held[k] = self.holds(track, plot);
        }
    }

    /// Whether the name of `plot` is this track's: it is confirmed, and has had a plot with it just now, or has not refused enough of
    /// them in a row for the name to go elsewhere.
    fn holds(&self, track: usize, plot: &Plot) -> bool {
        let track = &self.tracks[track];
        let lately = plot.time.since_s(track.named_at) <= NAME_HOLDS_S;
        track.stage == Stage::Confirmed && (lately || track.name_refused < AGREED)
    }
}

/// Reports in a row that a name's track refuses before another track may have the name.
const AGREED: u32 = 5;

/// For so long after the last plot with its name that a track took, the name is its own, s.
const NAME_HOLDS_S: f64 = 3.0;
