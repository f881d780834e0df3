//! Plots that only the kinematic gate accepts, and those that no gate does.

use super::gated::trace;
use super::updated::How;
use crate::association::kinematic_gate;
use crate::filter::Measurement;
use crate::fusion::config::SensorModel;
use crate::fusion::filter::position_at;
use crate::fusion::state::{Tracker, Work};
use crate::fusion::track_file::Track;
use crate::plot::Plot;

impl Tracker {
    /// Offers what the covariance gate left to the reachable sets of confirmed tracks without a plot.
    pub(in crate::fusion) fn take_manoeuvres(&mut self, model: &SensorModel, work: &mut Work) {
        let mut offers: Vec<(f64, f64, u32, usize)> = Vec::new();
        let limit = self.kinematic_gate;
        for pair in work.reaches.iter().filter(|pair| !pair.hopeless) {
            let track = &self.tracks[pair.track as usize];
            let k = pair.k as usize;
            let plot = &work.candidates[k].plot;
            let Some(filter) = track.way.filter_before(plot.time, &self.ring) else { continue };
            let dt_s = self.reckoned_s(track, plot.time.since_s(filter.time()));
            let (target, r) = (Track::departure(filter), plot.covariance_m2());
            let reach = kinematic_gate::reach(&track.limits, &target, dt_s, plot.position_m, r);
            let Some(reach) = reach.filter(|reach| reach.m <= limit) else { continue };
            let measured = Measurement::of(plot).ok();
            let found = measured.and_then(|m| self.distance(track, plot.time, plot, &m));
            offers.push((reach.m, found.map_or(f64::MAX, |d| d.d2), pair.track, k));
        }
        offers.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        });
        for (_, _, track, k) in offers {
            if !work.track_used[track as usize] && !work.used[k] {
                self.update(track as usize, How::Manoeuvre, k, model, work);
            }
        }
    }

    /// Remembers the nearest plot that both gates refused; two in a row that fit together start the
    /// track's state anew. Once: before the next new beginning a plot must have fitted the last one, or clutter
    /// would keep a track alive for ever.
    pub(in crate::fusion) fn note_refused(&mut self, model: &SensorModel, work: &mut Work) {
        let mut refusals: Vec<(f64, u32, usize)> = Vec::new();
        for pairs in work.reaches.chunk_by(|a, b| a.track == b.track) {
            let index = pairs[0].track;
            let track = &self.tracks[index as usize];
            if work.track_used[index as usize] || track.updated {
                continue;
            }
            let mut nearest: Option<(f64, usize)> = None;
            for k in pairs.iter().map(|pair| pair.k as usize).filter(|&k| !work.used[k]) {
                let plot = &work.candidates[k].plot;
                let Some(filter) = track.way.filter_before(plot.time, &self.ring) else { continue };
                let Ok((at, _)) = position_at(filter, plot.time, track.way.gaps(&self.config))
                else {
                    continue;
                };
                let distance = (plot.position_m - at).norm();
                if track.rest.place_m().is_some()
                    && plot.identity.is_none()
                    && !track.refused.as_ref().is_some_and(|before| bears_out(track, before, plot))
                {
                    let most_s = self.reckoned_s(track, plot.time.since_s(filter.time()));
                    let way_m = 0.5 * track.limits.acceleration_ms2 * most_s * most_s;
                    if distance > way_m + 3.0 * trace(plot).sqrt() {
                        continue;
                    }
                }
                if nearest.is_none_or(|best| (distance, k) < best) {
                    nearest = Some((distance, k));
                }
            }
            refusals.extend(nearest.map(|(distance, k)| (distance, index, k)));
        }
        refusals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index, k) in refusals {
            if work.used[k] {
                continue;
            }
            self.statistics.refused += 1;
            let plot = &work.candidates[k].plot;
            let track = &mut self.tracks[index as usize];
            // What says its name says no more than others see: while they follow the track, it is not moved by it.
            let lone = plot.identity.is_none()
                || !track.has_other_than(
                    plot.sensor,
                    plot.time,
                    3.0 * track.interval_s.max(model.interval_s),
                );
            let before = track.refused.take().filter(|before| {
                let dt_s = plot.time.since_s(before.time);
                if bears_out(track, before, plot) {
                    return true;
                }
                // A second radar says it as well as a second look of the first.
                let unnamed = before.identity.is_none() && plot.identity.is_none();
                let two = before.sensor != plot.sensor && unnamed && dt_s >= 0.0;
                lone && (two || before.sensor == plot.sensor && dt_s > 0.0)
                    && dt_s <= 2.5 * model.interval_s
                    && (plot.position_m - before.position_m).norm()
                        <= track.limits.speed_mps * dt_s + 3.0 * trace(plot).sqrt()
            });
            match before {
                Some(before) if self.config.gates.restart && !track.restarted => {
                    self.statistics.restarts += 1;
                    self.update(index as usize, How::Restart(&before), k, model, work);
                }
                _ => track.refused = Some(Box::new(*plot)),
            }
        }
    }
}

/// Whether two plots of one second, of two sensors, say the same of a track: one with its name, one that sees who is there without
/// being told. Neither alone moves a track that the other follows.
fn bears_out(track: &Track, before: &Plot, plot: &Plot) -> bool {
    let own = |p: &Plot| p.identity.map(|name| track.is(name));
    let one_is_told = matches!((own(before), own(plot)), (Some(true), None) | (None, Some(true)));
    let dt_s = plot.time.since_s(before.time);
    let since_s = plot.time.since_s(track.time()).clamp(0.0, AGREES_S);
    let speed_mps = track.filter().motion().1.norm() + track.limits.acceleration_ms2 * since_s;
    let spread_m = 3.0 * (trace(before) + trace(plot)).sqrt();
    one_is_told
        && before.sensor != plot.sensor
        && dt_s.abs() <= AGREES_S
        && (plot.position_m - before.position_m).norm() <= speed_mps * dt_s.abs() + spread_m
}

/// Plots of two sensors are of one moment if they are no farther apart, s.
const AGREES_S: f64 = 1.0;
