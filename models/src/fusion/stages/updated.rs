//! A plot updates its track, at the plot's own time.

use crate::fusion::budget::MERGED_ABOVE;
use crate::fusion::buffers::Candidate;
use crate::fusion::config::SensorModel;
use crate::fusion::on_lanes::APART_S;
use crate::fusion::registration::{Reference, Waiting};
use crate::fusion::state::{Outcome, Tracker, Work};
use crate::fusion::updates::Update;
use crate::fusion::way::Applied;
use crate::plot::Plot;
use crate::time::SimTime;

impl Tracker {
    /// Gives candidate `k` to a track.
    pub(in crate::fusion) fn update(
        &mut self,
        index: usize,
        how: How<'_>,
        k: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let Candidate { plot, index: place } = &work.candidates[k];
        let outside = self.is_outside(*place) || self.tracks[index].outside;
        // The plot as the track knows its target: offset of its echo, and how that wanders.
        let stated = *plot;
        let known = self.tracks[index].as_known(plot, &self.registration);
        let plot = &known;
        let several: Vec<(Plot, f64)>;
        let how = match how {
            How::Weighted { plots, hit } if plot.polar.is_some() => {
                several = {
                    let (track, sites) = (&self.tracks[index], &self.registration);
                    plots.iter().map(|(p, beta)| (track.as_known(p, sites), *beta)).collect()
                };
                How::Weighted { plots: &several, hit }
            }
            other => other,
        };
        self.believe(index, &how, plot, model);
        let track = &mut self.tracks[index];
        let late = plot.time < track.time();
        if late {
            // What comes behind it is done again.
            let again = track.way.later_than(plot.time) as u64 * work.budget.update();
            if work.budget.left_of(0.9) < again {
                self.statistics.too_late += 1;
                self.outcomes[*place] = Outcome::TooLate;
                return;
            }
            work.budget.spend(again);
        }
        let (update, hit) = match how {
            How::Plot => (Update::Plot(plot), true),
            How::Manoeuvre => (Update::Manoeuvre(plot), true),
            How::Restart(before) => (Update::Restart(before, plot), true),
            How::Weighted { plots, hit } => (Update::Weighted(plots), hit),
        };
        let manoeuvre = matches!(how, How::Manoeuvre | How::Restart(_));
        // Where full weighing would cost too much, the track goes on as one Gaussian for this update.
        let plots = if let How::Weighted { plots, .. } = how { plots.len() as u64 + 1 } else { 1 };
        let dear = plots > 2 && work.budget.left_of(0.7) < plots * work.budget.update();
        let merge = (work.light || dear) && work.budget.update() > MERGED_ABOVE;
        self.statistics.merged_updates += u64::from(merge);
        work.budget.spend(if merge { 30 * plots } else { plots * work.budget.update() });
        let config = &self.config;
        let applied = track.way.apply(update, merge, config, self.oldest, &mut self.ring);
        let (position_m, velocity_mps) = match applied {
            Applied::Taken { position_m, velocity_mps } => (position_m, velocity_mps),
            Applied::Reborn { position_m, velocity_mps } => {
                self.statistics.not_positive_definite += 1;
                (position_m, velocity_mps)
            }
            Applied::Refused => {
                self.statistics.unsound += 1;
                return;
            }
        };
        let new_name = plot.identity.filter(|name| hit && !track.is(*name));
        if hit {
            track.note_hit(plot, model);
            work.used[k] = true;
            work.track_used[index] = true;
        }
        if hit {
            track.note_course(velocity_mps);
            track.rest.note(plot, velocity_mps, matches!(how, How::Restart(_)));
        }
        if hit && !manoeuvre {
            track.note_extent(&stated);
            track.spread.learn(&stated, model.interval_s);
            if stated.polar.is_some() {
                track.note_echo(&stated, self.registration.law());
            }
        }
        if hit && self.config.register_sites && !outside {
            if plot.polar.is_some() && !manoeuvre {
                let waiting = Waiting {
                    plot: stated,
                    taken_off_m: self.registration.correction_m(&stated)
                        - stated.axis * self.registration.law().unknown_m.0,
                    velocity_mps,
                    body: track.body(),
                    course: track.course,
                    interval_s: model.interval_s,
                };
                let due = |at: SimTime| plot.time.since_s(at) >= APART_S;
                if let Some(lanes) = &config.lanes
                    && track.number.is_some()
                    && track.lane_at.is_none_or(due)
                    && self.registration.learn_lane(&waiting, lanes)
                {
                    track.lane_at = Some(plot.time);
                }
                if let Some(reference) = &mut track.reference {
                    reference.keep(waiting);
                }
            } else if plot.identity.is_some() && plot.along_m2.is_finite() {
                let repeats = if model.slow_share > 0.0 {
                    (2.0 * model.slow_tau_s / model.interval_s.max(1e-3)).max(1.0)
                } else {
                    1.0
                };
                let variance_m2 = 0.5 * (plot.along_m2 + plot.across_m2);
                let next = Reference::new(plot.time, plot.position_m, variance_m2, repeats);
                if let Some(before) = &track.reference {
                    self.registration.learn(before, &next);
                }
                track.reference = Some(Box::new(next));
            }
        }
        if hit {
            track.restarted = matches!(how, How::Restart(_));
        }
        track.manoeuvre |= manoeuvre;
        self.statistics.late += u64::from(late);
        match how {
            How::Manoeuvre => self.statistics.gate_2 += 1,
            How::Restart(_) => {}
            How::Plot | How::Weighted { .. } => self.statistics.gate_1 += 1,
        }
        // At the time that the plot itself says.
        let position_m = position_m + velocity_mps * model.latency_s;
        self.outcomes[*place] =
            Outcome::Used { number: track.number, serial: track.serial, position_m, velocity_mps };
        // The name goes with the track that is nearer to the plot that carries it.
        if let Some(name) = new_name {
            let first = work.identities.partition_point(|(known, _)| *known < name);
            let listed = work.identities.get(first).filter(|(known, _)| *known == name);
            let holder = work.renamed.insert(name, index as u32).or(listed.map(|l| l.1));
            if let Some(other) = holder.map(|other| other as usize).filter(|&o| o != index) {
                let track = &mut self.tracks[other];
                if track.is(name) {
                    track.forget_identity();
                    track.limits = self.config.limits_of(None);
                    self.statistics.identity_conflicts += 1;
                }
            }
        }
    }
}

/// How a plot is given to a track.
#[derive(Clone, Copy, Debug)]
pub(in crate::fusion) enum How<'a> {
    /// As an ordinary plot.
    Plot,
    /// As one that only the kinematic gate accepted.
    Manoeuvre,
    /// With an earlier one, as a new beginning.
    Restart(&'a Plot),
    /// With others and the probability of each; `hit`: one of them is likelier than none.
    Weighted { plots: &'a [(Plot, f64)], hit: bool },
}
