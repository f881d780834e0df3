//! One scan: plots in, tracks out.

use super::config::{SensorModel, TrackingConfig};
use super::labels;
use super::life;
use super::numbers::Numbers;
use super::track_file::{Applied, Stage, Track, Update, predict};
use crate::association::assignment::Solver;
use crate::association::cluster::Clusters;
use crate::association::gate::chi_square_quantile;
use crate::association::grid::Grid;
use crate::association::jpda::Jpda;
use crate::association::kinematic_gate;
use crate::association::nearest::{self, Pair};
use crate::filter::{Measurement, StateEstimator};
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::plot::{Identity, Plot, SensorId};
use crate::time::SimTime;
use crate::track::{SystemTrack, TrackStatus};
use std::collections::VecDeque;

/// What became of one plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It updated (or began) a track; the track's state just after that, at the plot's own time.
    Used {
        /// Track number; none while the track is tentative.
        number: Option<u16>,
        /// Order of birth of the track: the same for its whole life.
        serial: u64,
        /// Position, m.
        position_m: Vector2<f64>,
        /// Velocity, m/s.
        velocity_ms: Vector2<f64>,
    },
    /// Near a track that had another plot, and not a new target.
    Unused,
    /// Refused: not finite, outside the area, or of a time that cannot be.
    Unsound,
    /// Older than what can still be taken in its order.
    TooLate,
    /// A copy of a plot that was there before.
    Duplicate,
}

/// Counters since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Scans.
    pub scans: u64,
    /// Plots given.
    pub plots: u64,
    /// Plots that a track took through the covariance gate.
    pub gate_1: u64,
    /// Plots that only the kinematic gate accepted: marked manoeuvres.
    pub gate_2: u64,
    /// Plots that both gates refused, nearest to a track without a plot.
    pub refused: u64,
    /// Tracks whose state was started again from two refused plots.
    pub restarts: u64,
    /// Tracks restarted because a covariance was not positive definite.
    pub not_positive_definite: u64,
    /// Plots near a track that had another one.
    pub unused: u64,
    /// Plots that could not be taken at all.
    pub unsound: u64,
    /// Plots behind a later one of their track, taken in their order.
    pub late: u64,
    /// Plots older than the ring.
    pub too_late: u64,
    /// Copies.
    pub duplicates: u64,
    /// Tracks started.
    pub started: u64,
    /// Starts refused for lack of room.
    pub no_room: u64,
    /// Tracks confirmed.
    pub confirmed: u64,
    /// Confirmations refused for lack of a number.
    pub no_number: u64,
    /// Tentative tracks dropped.
    pub tentative_dropped: u64,
    /// Confirmed tracks deleted.
    pub deleted: u64,
    /// Tracks ended as a double of another one.
    pub merged: u64,
    /// One identity seen on two tracks.
    pub identity_conflicts: u64,
    /// Clusters too large for exact joint association.
    pub large_clusters: u64,
    /// Times that the clock was set back and all tracks were dropped.
    pub clock_resets: u64,
}

/// Positions farther from the reference point than this are no airport traffic, m.
const FARTHEST_M: f64 = 1e6;

/// One plot of the scan in hand.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    plot: Plot,
    /// Its place in the caller's list.
    index: usize,
    used: bool,
    /// Inside the covariance gate of a confirmed track.
    gated: bool,
}

/// Plots of one sensor and interval: `candidates[from..to]`.
#[derive(Clone, Copy, Debug)]
struct Batch {
    from: usize,
    to: usize,
}

/// All tracks, scan after scan.
#[derive(Clone, Debug)]
pub struct Tracker {
    config: TrackingConfig,
    tracks: Vec<Track>,
    numbers: Numbers,
    next_serial: u64,
    last_scan: Option<SimTime>,
    /// (time, sensor, sequence) of the plots of the last scans, sorted scan by scan.
    seen: VecDeque<Vec<(SimTime, SensorId, u32)>>,
    statistics: Statistics,
    outcomes: Vec<Outcome>,
    gate_1: f64,
    identified_gate: f64,
    work: Work,
}

/// Buffers kept from scan to scan.
#[derive(Clone, Debug, Default)]
struct Work {
    candidates: Vec<Candidate>,
    batches: Vec<Batch>,
    positions: Vec<Vector2<f64>>,
    grid: Grid,
    pairs: Vec<Pair>,
    scratch: Vec<Pair>,
    clusters: Clusters,
    solver: Solver,
    jpda: Jpda,
    track_used: Vec<bool>,
    plot_used: Vec<bool>,
}

impl Tracker {
    /// A tracker without tracks.
    #[must_use]
    pub fn new(config: TrackingConfig) -> Self {
        let numbers = Numbers::new(config.life.numbers, config.life.number_rest_s);
        let gate_1 = chi_square_quantile(2, config.gates.probability);
        let identified_gate = chi_square_quantile(2, config.gates.identified_probability);
        Self {
            config,
            tracks: Vec::new(),
            numbers,
            next_serial: 0,
            last_scan: None,
            seen: VecDeque::new(),
            statistics: Statistics::default(),
            outcomes: Vec::new(),
            gate_1,
            identified_gate,
            work: Work::default(),
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &TrackingConfig {
        &self.config
    }

    /// Counters since the start.
    #[must_use]
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// What became of each plot of the last [`Self::scan`], index by index. For evaluation: the truth
    /// at the plot's time can be held against the track's state just after the plot.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// One update cycle: all plots up to `t_out` that have not been given before, in any order.
    ///
    /// Gives the confirmed tracks at `t_out` in order of their numbers; a track that ended in this
    /// scan comes once more with [`TrackStatus::Last`]. The stored states stay at their last plots.
    /// If `t_out` is before that of the last scan, everything is forgotten (and counted): a clock
    /// that was set back leaves nothing to continue from.
    pub fn scan(
        &mut self,
        t_out: SimTime,
        plots: &[Plot],
        flights: &FlightList,
    ) -> Vec<SystemTrack> {
        self.begin(t_out);
        self.take_in(t_out, plots);
        let mut work = std::mem::take(&mut self.work);
        for batch in 0..work.batches.len() {
            let Batch { from, to } = work.batches[batch];
            self.associate_batch(from, to, &mut work);
        }
        life::end_of_scan(
            &mut self.tracks,
            &mut self.numbers,
            t_out,
            flights,
            &self.config,
            &mut self.statistics,
        );
        self.statistics.identity_conflicts +=
            labels::assign(&mut self.tracks, flights, &self.config, t_out, &mut work.solver);
        life::merge_duplicates(
            &mut self.tracks,
            t_out,
            &self.config,
            &mut work.grid,
            &mut self.statistics,
        );
        self.work = work;
        self.publish(t_out, flights)
    }

    fn begin(&mut self, t_out: SimTime) {
        self.statistics.scans += 1;
        if self.last_scan.is_some_and(|last| t_out < last) {
            self.statistics.clock_resets += 1;
            self.tracks.clear();
            self.seen.clear();
            self.numbers = Numbers::new(self.config.life.numbers, self.config.life.number_rest_s);
            self.last_scan = None;
        }
        let oldest = t_out.plus_s(-self.config.ring_s);
        for track in &mut self.tracks {
            track.updated = false;
            track.manoeuvre = false;
            track.forget_before(oldest);
        }
        while self.seen.front().is_some_and(|scan| scan.last().is_none_or(|key| key.0 < oldest)) {
            self.seen.pop_front();
        }
    }

    /// Sorts the plots by (time, sensor, sequence), refuses what cannot be taken, and cuts batches.
    fn take_in(&mut self, t_out: SimTime, plots: &[Plot]) {
        self.outcomes.clear();
        self.outcomes.resize(plots.len(), Outcome::Unused);
        self.statistics.plots += plots.len() as u64;
        let oldest = t_out.plus_s(-self.config.ring_s);
        let candidates = &mut self.work.candidates;
        candidates.clear();
        for (index, plot) in plots.iter().enumerate() {
            if !sound(plot) || plot.time > t_out {
                self.outcomes[index] = Outcome::Unsound;
                self.statistics.unsound += 1;
            } else if plot.time < oldest {
                self.outcomes[index] = Outcome::TooLate;
                self.statistics.too_late += 1;
            } else {
                candidates.push(Candidate { plot: *plot, index, used: false, gated: false });
            }
        }
        let key = |c: &Candidate| (c.plot.time, c.plot.sensor, c.plot.sequence);
        candidates.sort_unstable_by(|a, b| {
            key(a)
                .cmp(&key(b))
                .then(a.plot.position_m.x.total_cmp(&b.plot.position_m.x))
                .then(a.plot.position_m.y.total_cmp(&b.plot.position_m.y))
                .then(a.index.cmp(&b.index))
        });
        let last_scan = self.last_scan;
        let mut before = None;
        candidates.retain(|c| {
            let this = key(c);
            let seen_before = last_scan.is_some_and(|last| c.plot.time <= last)
                && self.seen.iter().any(|scan| scan.binary_search(&this).is_ok());
            let copy = seen_before || before == Some(this);
            before = Some(this);
            if copy {
                self.outcomes[c.index] = Outcome::Duplicate;
                self.statistics.duplicates += 1;
            }
            !copy
        });
        self.seen.push_back(candidates.iter().map(key).collect());
        let first = candidates.first().map_or(t_out, |c| c.plot.time);
        let start = last_scan.unwrap_or(SimTime(first.0 - 1));
        self.last_scan = Some(t_out);
        // Batches: one sensor, one of its intervals, counted from the end of the last scan.
        let config = &self.config;
        let interval_number = |c: &Candidate| {
            let model = config.sensor(c.plot.sensor, c.plot.kind);
            let interval = SimTime::from_s(model.interval_s.clamp(1e-3, 1e6)).0;
            (c.plot.time.0 - start.0 - 1).div_euclid(interval)
        };
        candidates.sort_by_key(|c| (c.plot.sensor, interval_number(c)));
        let batches = &mut self.work.batches;
        batches.clear();
        let mut from = 0;
        for to in 1..=candidates.len() {
            let name = |c: &Candidate| (c.plot.sensor, interval_number(c));
            if to == candidates.len() || name(&candidates[to]) != name(&candidates[from]) {
                batches.push(Batch { from, to });
                from = to;
            }
        }
        batches.sort_by_key(|b| (candidates[b.from].plot.time, candidates[b.from].plot.sensor));
        // What the sensor's model adds to the stated variance.
        for c in candidates.iter_mut() {
            let extra = config.sensor(c.plot.sensor, c.plot.kind).extra_sigma_m;
            c.plot.along_m2 += extra * extra;
            c.plot.across_m2 += extra * extra;
        }
    }

    /// Gives the plots `candidates[from..to]` (one sensor, one interval) to tracks; starts new ones.
    fn associate_batch(&mut self, from: usize, to: usize, work: &mut Work) {
        let first = work.candidates[from].plot;
        let model = self.config.sensor(first.sensor, first.kind);
        work.positions.clear();
        work.positions.extend(work.candidates[from..to].iter().map(|c| c.plot.position_m));
        work.grid.fill(&work.positions, GRID_CELL_M);
        work.track_used.clear();
        work.track_used.resize(self.tracks.len(), false);
        self.take_identified(from, to, &model, work);
        self.take_gated(from, to, Stage::Confirmed, &model, work);
        if self.config.gates.kinematic {
            self.take_manoeuvres(from, to, &model, work);
        }
        self.note_refused(from, to, &model, work);
        self.take_gated(from, to, Stage::Tentative, &model, work);
        self.start_tracks(from, to, &model, work);
    }

    /// Plots with an identity go first, to the track that has it.
    fn take_identified(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        for k in from..to {
            let plot = work.candidates[k].plot;
            let Some(identity) = plot.identity else { continue };
            let holder = self.tracks.iter().position(|t| {
                t.stage != Stage::Ended
                    && match identity {
                        Identity::Callsign(c) => t.callsign == Some(c),
                        Identity::Address(a) => t.address == Some(a),
                    }
            });
            let Some(track) = holder else { continue };
            // Whoever holds the name: the plot starts no other track.
            work.candidates[k].gated = true;
            if work.track_used[track] {
                continue;
            }
            let gate = self.identified_gate;
            if self.distance(track, &plot).is_some_and(|pair| pair.d2 <= gate) {
                self.update(track, Update::Plot(plot), k, model, work);
            }
        }
    }

    /// Covariance gate and association of all tracks of one stage.
    fn take_gated(
        &mut self,
        from: usize,
        to: usize,
        stage: Stage,
        model: &SensorModel,
        work: &mut Work,
    ) {
        self.gated_pairs(from, to, stage, work);
        work.plot_used.clear();
        work.plot_used.resize(to - from, false);
        let mut pairs = std::mem::take(&mut work.pairs);
        let mut taken = std::mem::take(&mut work.scratch);
        taken.clear();
        nearest::greedy(&mut pairs, &mut work.track_used, &mut work.plot_used, |p| taken.push(p));
        for pair in &taken {
            let k = from + pair.plot as usize;
            let plot = work.candidates[k].plot;
            self.update(pair.track as usize, Update::Plot(plot), k, model, work);
        }
        work.pairs = pairs;
        work.scratch = taken;
    }

    /// All pairs of tracks of `stage` and free plots inside the covariance gate.
    fn gated_pairs(&mut self, from: usize, to: usize, stage: Stage, work: &mut Work) {
        let Work { candidates, grid, pairs, track_used, .. } = work;
        let batch = &mut candidates[from..to];
        let (begin, end) = batch.iter().fold((SimTime(i64::MAX), SimTime(i64::MIN)), |span, c| {
            (span.0.min(c.plot.time), span.1.max(c.plot.time))
        });
        let widest = batch.iter().fold(0.0f64, |w, c| w.max(search_variance(&c.plot)));
        pairs.clear();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != stage || track_used[index] {
                continue;
            }
            // Where it may be at any time of the batch.
            let Some(base) = track.filter_before(begin).or_else(|| track.filter_before(end)) else {
                continue;
            };
            let Ok(last) = predict(base, end, &self.config.life) else { continue };
            let first = predict(base, begin.max(base.time()), &self.config.life)
                .map_or(last.position_m(), |e| e.position_m());
            let s = last.position_cov_m2();
            let half = Vector2::new(
                (self.gate_1 * (s[(0, 0)] + widest)).sqrt(),
                (self.gate_1 * (s[(1, 1)] + widest)).sqrt(),
            );
            let low = first.inf(&last.position_m()) - half;
            let high = first.sup(&last.position_m()) + half;
            let young = track.plots == 1;
            grid.visit(low, high, |k| {
                let c = &mut batch[k];
                let p = c.plot.position_m;
                let inside = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
                if c.used || !inside || !track.may_be(c.plot.identity) {
                    return;
                }
                let Some(found) = distance(track, &c.plot, &self.config) else { return };
                let within =
                    if young { within_first_gate(track, &c.plot) } else { found.d2 <= self.gate_1 };
                if within {
                    if stage == Stage::Confirmed {
                        c.gated = true;
                    }
                    pairs.push(Pair {
                        track: index as u32,
                        plot: k as u32,
                        d2: found.d2,
                        ln_det: found.ln_det,
                    });
                }
            });
        }
    }

    /// Offers what the covariance gate left to the reachable sets of confirmed tracks without a plot.
    fn take_manoeuvres(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        let mut offers: Vec<(f64, f64, usize, usize)> = Vec::new();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Confirmed || work.track_used[index] {
                continue;
            }
            self.for_plots_in_reach(track, from, to, model, work, |k, plot, filter| {
                let dt_s = plot.time.since_s(filter.time());
                let target = Track::departure(filter);
                let r = plot.covariance_m2();
                let Some(reach) =
                    kinematic_gate::reach(&track.limits, &target, dt_s, plot.position_m, r)
                else {
                    return;
                };
                if reach.m <= self.config.gates.kinematic_limit {
                    let d2 = distance(track, plot, &self.config).map_or(f64::MAX, |d| d.d2);
                    offers.push((reach.m, d2, index, k));
                }
            });
        }
        offers.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        });
        for (_, _, track, k) in offers {
            if !work.track_used[track] && !work.candidates[k].used {
                let plot = work.candidates[k].plot;
                self.update(track, Update::Manoeuvre(plot), k, model, work);
            }
        }
    }

    /// Remembers the nearest plot that both gates refused; two in a row that fit together start the
    /// track's state anew.
    fn note_refused(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        let mut refusals: Vec<(f64, usize, usize)> = Vec::new();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Confirmed || work.track_used[index] || track.updated {
                continue;
            }
            let mut nearest: Option<(f64, usize)> = None;
            self.for_plots_in_reach(track, from, to, model, work, |k, plot, filter| {
                let Ok(at) = predict(filter, plot.time, &self.config.life) else { return };
                let distance = (plot.position_m - at.position_m()).norm();
                if nearest.is_none_or(|(best, _)| distance < best) {
                    nearest = Some((distance, k));
                }
            });
            if let Some((distance, k)) = nearest {
                refusals.push((distance, index, k));
            }
        }
        refusals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index, k) in refusals {
            if work.candidates[k].used {
                continue;
            }
            self.statistics.refused += 1;
            let plot = work.candidates[k].plot;
            let track = &self.tracks[index];
            let before = track.refused.filter(|before| {
                let dt_s = plot.time.since_s(before.time);
                before.sensor == plot.sensor
                    && dt_s > 0.0
                    && dt_s <= 2.5 * model.interval_s
                    && (plot.position_m - before.position_m).norm()
                        <= track.limits.speed_ms * dt_s + 3.0 * trace(&plot).sqrt()
            });
            match before {
                Some(before) if self.config.gates.restart => {
                    self.statistics.restarts += 1;
                    self.update(index, Update::Restart(before, plot), k, model, work);
                }
                _ => self.tracks[index].refused = Some(plot),
            }
        }
    }

    /// Calls `visit` for every free plot of the batch that the fastest target of the track's class could
    /// have reached, with the filter as it was before that plot.
    fn for_plots_in_reach<'a>(
        &self,
        track: &'a Track,
        from: usize,
        to: usize,
        model: &SensorModel,
        work: &Work,
        mut visit: impl FnMut(usize, &Plot, &'a crate::filter::Estimator),
    ) {
        let batch = &work.candidates[from..to];
        let latest = batch.iter().fold(SimTime(i64::MIN), |t, c| t.max(c.plot.time));
        let centre = track.filter().estimate().position_m();
        let way = latest.since_s(track.time()).max(0.0) + model.interval_s.min(1.0);
        let radius = track.limits.speed_ms * way + REACH_MARGIN_M;
        let around = Vector2::repeat(radius);
        work.grid.visit(centre - around, centre + around, |k| {
            let c = &batch[k];
            if c.used || c.gated || !track.may_be(c.plot.identity) {
                return;
            }
            // Nobody else's name may be put on a track that has none by a manoeuvre.
            if c.plot.identity.is_some() && track.callsign.is_none() && track.address.is_none() {
                return;
            }
            if let Some(filter) = track.filter_before(c.plot.time) {
                let dt_s = c.plot.time.since_s(filter.time());
                let offset = c.plot.position_m - filter.estimate().position_m();
                let uncertainty =
                    3.0 * (trace(&c.plot) + filter.estimate().position_cov_m2().trace()).sqrt();
                if offset.norm() <= track.limits.speed_ms * dt_s + uncertainty {
                    visit(from + k, &c.plot, filter);
                }
            }
        });
    }

    /// A plot that no track used and that lies in no gate of a confirmed track begins a track.
    fn start_tracks(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        for k in from..to {
            let Candidate { plot, used, gated, index } = work.candidates[k];
            if used {
                continue;
            }
            let one_line_only = !plot.across_m2.is_finite() || !plot.along_m2.is_finite();
            if gated || one_line_only {
                self.statistics.unused += 1;
                continue;
            }
            if self.tracks.len() >= self.config.life.most_tracks {
                self.statistics.no_room += 1;
                continue;
            }
            let Ok(track) = Track::start(self.next_serial, &plot, &self.config, model.interval_s)
            else {
                self.statistics.unsound += 1;
                self.outcomes[index] = Outcome::Unsound;
                continue;
            };
            self.outcomes[index] = Outcome::Used {
                number: None,
                serial: track.serial,
                position_m: plot.position_m,
                velocity_ms: Vector2::zeros(),
            };
            work.candidates[k].used = true;
            self.next_serial += 1;
            self.statistics.started += 1;
            self.tracks.push(track);
            work.track_used.push(true);
        }
    }

    fn distance(&self, track: usize, plot: &Plot) -> Option<Distance> {
        distance(&self.tracks[track], plot, &self.config)
    }

    /// Gives candidate `k` to a track.
    fn update(
        &mut self,
        index: usize,
        update: Update,
        k: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let candidate = &mut work.candidates[k];
        let track = &mut self.tracks[index];
        let manoeuvre = matches!(update, Update::Manoeuvre(_) | Update::Restart(..));
        let by_gate_2 = matches!(update, Update::Manoeuvre(_));
        let late = candidate.plot.time < track.time();
        let applied = track.apply(update, candidate.plot.time, model.interval_s, &self.config);
        let (position_m, velocity_ms) = match applied {
            Applied::Taken { position_m, velocity_ms } => (position_m, velocity_ms),
            Applied::Reborn { position_m, velocity_ms } => {
                self.statistics.not_positive_definite += 1;
                (position_m, velocity_ms)
            }
            Applied::Refused => {
                self.statistics.unsound += 1;
                return;
            }
        };
        candidate.used = true;
        work.track_used[index] = true;
        track.manoeuvre |= manoeuvre;
        self.statistics.late += u64::from(late);
        if by_gate_2 {
            self.statistics.gate_2 += 1;
        } else if !manoeuvre {
            self.statistics.gate_1 += 1;
        }
        self.outcomes[candidate.index] =
            Outcome::Used { number: track.number, serial: track.serial, position_m, velocity_ms };
    }

    /// A predicted copy of each confirmed track, by number; ended tracks leave.
    fn publish(&mut self, t_out: SimTime, flights: &FlightList) -> Vec<SystemTrack> {
        let mut out: Vec<SystemTrack> = Vec::with_capacity(self.tracks.len());
        for track in &mut self.tracks {
            let Some(number) = track.number else { continue };
            let Ok(at) = predict(track.filter(), t_out, &self.config.life) else { continue };
            if let Some((heading, _)) = at.heading_rad() {
                track.heading_rad = heading;
            }
            let (track_type, label) = labels::label(track.entry, flights);
            let status = match track.stage {
                Stage::Ended => TrackStatus::Last,
                _ if !track.updated && track.history & 1 == 0 => TrackStatus::Coasting,
                _ => TrackStatus::Confirmed,
            };
            out.push(SystemTrack {
                number,
                track_type,
                status,
                first: !track.published,
                time: t_out,
                last_plot: track.time(),
                position_m: at.position_m(),
                velocity_ms: at.velocity_ms(),
                acceleration_ms2: at.acceleration_ms2(),
                position_cov_m2: at.position_cov_m2(),
                velocity_cov_m2s2: at.velocity_cov_m2s2(),
                altitude_m: track.altitude_m,
                heading_rad: track.heading_rad,
                manoeuvre: track.manoeuvre,
                label,
            });
            track.published = true;
        }
        let numbers = &mut self.numbers;
        self.tracks.retain(|track| {
            if track.stage == Stage::Ended {
                if let Some(number) = track.number {
                    numbers.give_back(number, t_out);
                }
            }
            track.stage != Stage::Ended
        });
        out.sort_by_key(|track| track.number);
        out
    }
}

/// Cell of the search grid, m: about a search box of a taxiing target.
const GRID_CELL_M: f64 = 25.0;

/// Added to the search circle of the kinematic gate, m; the exact test follows.
const REACH_MARGIN_M: f64 = 50.0;

/// Innovation squared and its ln det S.
#[derive(Clone, Copy, Debug)]
struct Distance {
    d2: f64,
    ln_det: f64,
}

/// Distance of a plot from a track predicted to the plot's own time.
fn distance(track: &Track, plot: &Plot, config: &TrackingConfig) -> Option<Distance> {
    let filter = track.filter_before(plot.time)?;
    let at = predict(filter, plot.time, &config.life).ok()?;
    let found = at.innovation(plot).ok()?;
    (found.d2.is_finite() && found.ln_det.is_finite())
        .then_some(Distance { d2: found.d2, ln_det: found.ln_det })
}

/// First gate of a track with one plot: as far as its class can go.
fn within_first_gate(track: &Track, plot: &Plot) -> bool {
    let first = track.filter().estimate();
    let dt_s = plot.time.since_s(first.time).abs();
    let margin = 3.0 * trace(plot).sqrt();
    (plot.position_m - first.position_m()).norm() <= track.limits.speed_ms * dt_s + margin
}

/// `tr R`, m²; a direction that is not measured counts 10 m.
fn trace(plot: &Plot) -> f64 {
    plot.along_m2.min(100.0) + plot.across_m2.min(100.0)
}

/// Largest variance of the plot for the search box; a direction that is not measured counts 20 m.
fn search_variance(plot: &Plot) -> f64 {
    let bounded = |v: f64| if v.is_finite() { v } else { 400.0 };
    bounded(plot.along_m2).max(bounded(plot.across_m2))
}

fn sound(plot: &Plot) -> bool {
    let finite = plot.position_m.iter().all(|x| x.abs() <= FARTHEST_M);
    let axis = (plot.axis.norm_squared() - 1.0).abs() < 1e-6;
    let altitude = plot.altitude_m.is_none_or(f64::is_finite);
    finite && axis && altitude && Measurement::of(plot).is_ok() && plot.along_m2.is_finite()
}
