//! What is left over: other echoes of targets that are known, and new tracks.

use super::doubles;
use super::gated::{KEPT, REACH_MARGIN_M};
use crate::frames::Vector2;
use crate::fusion::buffers::Candidate;
use crate::fusion::config::SensorModel;
use crate::fusion::doubt::Doubt;
use crate::fusion::filter::position_at;
use crate::fusion::state::{Outcome, Tracker, Work};
use crate::fusion::track_file::Track;
use std::collections::BTreeSet;

impl Tracker {
    /// Marks the free plots that lie on the body of a labelled target: other echoes of it.
    pub(in crate::fusion) fn mark_other_echoes(&self, from: usize, to: usize, work: &mut Work) {
        let Work { candidates, used, gated, bodies, bodied, positions, near, .. } = work;
        if bodied.is_empty() || (from..to).all(|k| used[k] || gated[k]) {
            return;
        }
        positions.clear();
        let mut longest = 0.0f64;
        for &index in &*bodied {
            let track = &self.tracks[index as usize];
            positions.push(track.filter().motion().0);
            longest = track.size_m.map_or(longest, |(l, s)| longest.max(l.max(s)));
        }
        bodies.fill(positions, longest + REACH_MARGIN_M);
        let around = Vector2::repeat(longest + REACH_MARGIN_M);
        for k in (from..to).filter(|&k| !used[k]) {
            let plot = &candidates[k].plot;
            if gated[k] || plot.identity.is_some() {
                continue;
            }
            let place = plot.position_m;
            let mut look_at = |body: usize| {
                let track = &self.tracks[bodied[body] as usize];
                let time = plot.time.max(track.time());
                gated[k] |= track.size_m.is_some()
                    && position_at(track.filter(), time, track.way.gaps(&self.config))
                        .is_ok_and(|(at, _)| doubles::on_body(track, at, place, 0.0));
            };
            let (low, high) = (place - around, place + around);
            bodies.visit_near(low, high, KEPT, near, &mut look_at);
        }
    }

    /// A plot that no track used and that lies in no gate of a confirmed track begins a track.
    pub(in crate::fusion) fn start_tracks(
        &mut self,
        from: usize,
        to: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let mut started = BTreeSet::new();
        for k in from..to {
            if work.used[k] {
                continue;
            }
            let Candidate { plot, index } = &work.candidates[k];
            // One name, one track: another plot of it waits for the next look.
            work.gated[k] |= plot.identity.is_some_and(|name| started.contains(&name));
            let one_line_only = !plot.across_m2.is_finite() || !plot.along_m2.is_finite();
            if work.gated[k] || one_line_only {
                self.statistics.unused += 1;
                continue;
            }
            if self.initiation.as_ref().is_some_and(|own| !own.begins(plot)) {
                self.statistics.unused += 1;
                continue;
            }
            if self.tracks.len() >= self.config.life.most_tracks {
                self.statistics.no_room += 1;
                continue;
            }
            let track = Track::start(self.next_serial, plot, &self.config, model);
            let Ok(mut track) = track else {
                self.statistics.unsound += 1;
                self.outcomes[*index] = Outcome::Unsound;
                continue;
            };
            track.outside = self.is_outside(*index);
            let strength = self.config.log_strength(plot, model);
            track.doubt =
                self.config.life.existence.map(|rules| {
                    Box::new(Doubt::born(plot, model, &rules, &work.entrances, strength))
                });
            self.outcomes[*index] = Outcome::Used {
                number: None,
                serial: track.serial,
                position_m: plot.position_m,
                velocity_mps: Vector2::zeros(),
            };
            started.extend(plot.identity);
            work.used[k] = true;
            self.next_serial += 1;
            self.statistics.started += 1;
            work.tentative.push(self.tracks.len() as u32);
            self.tracks.push(track);
        }
    }
}
