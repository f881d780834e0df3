//! One scan: plots in, tracks out.

use super::config::{SensorModel, TrackingConfig};
use super::labels;
use super::life;
use super::numbers::Numbers;
use super::registration::{Registration, SiteBias};
use super::track_file::{Stage, Track, predict};
use crate::association::assignment::Solver;
use crate::association::cluster::Clusters;
use crate::association::gate::chi_square_quantile;
use crate::association::grid::Grid;
use crate::association::jpda::Jpda;
use crate::association::nearest::Pair;
use crate::filter::{Gaussian, Measurement};
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::plot::{Identity, Plot, SensorId, SensorKind};
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
pub(super) struct Candidate {
    pub(super) plot: Plot,
    /// Its place in the caller's list.
    pub(super) index: usize,
    pub(super) used: bool,
    /// Inside the covariance gate of a confirmed track.
    pub(super) gated: bool,
}

/// Plots of one sensor and interval: `candidates[from..to]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    pub(super) from: usize,
    pub(super) to: usize,
}

/// All tracks, scan after scan.
#[derive(Clone, Debug)]
pub struct Tracker {
    pub(super) config: TrackingConfig,
    pub(super) tracks: Vec<Track>,
    numbers: Numbers,
    pub(super) registration: Registration,
    pub(super) next_serial: u64,
    last_scan: Option<SimTime>,
    /// (time, sensor, sequence) of the plots of the last scans, sorted scan by scan.
    seen: VecDeque<Vec<(SimTime, SensorId, u32)>>,
    pub(super) statistics: Statistics,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) gate_1: f64,
    pub(super) identified_gate: f64,
    work: Work,
}

/// Buffers kept from scan to scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    pub(super) candidates: Vec<Candidate>,
    pub(super) batches: Vec<Batch>,
    pub(super) positions: Vec<Vector2<f64>>,
    /// Earliest and latest time of the batch.
    pub(super) span: (SimTime, SimTime),
    pub(super) grid: Grid,
    /// Labelled tracks, for other echoes of their bodies.
    pub(super) bodies: Grid,
    pub(super) body_tracks: Vec<u32>,
    pub(super) pairs: Vec<Pair>,
    pub(super) scratch: Vec<Pair>,
    pub(super) clusters: Clusters,
    pub(super) solver: Solver,
    pub(super) jpda: Jpda,
    pub(super) track_used: Vec<bool>,
    pub(super) plot_used: Vec<bool>,
    /// Identities of the tracks with their indices, sorted.
    pub(super) names: Vec<(Identity, u32)>,
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
            registration: Registration::default(),
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

    /// Estimated constant errors of the radars' sites.
    #[must_use]
    pub fn site_biases(&self) -> Vec<SiteBias> {
        self.registration.biases()
    }

    /// What became of each plot of the last [`Self::scan`], index by index. For evaluation: the truth
    /// at the plot's time can be held against the track's state just after the plot.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// Takes over confirmed tracks with known states (a hand-over, or a study that starts from truth).
    /// States that no filter can start from, and those beyond the last number, are left out; gives
    /// how many were taken.
    pub fn adopt(&mut self, time: SimTime, states: &[Gaussian]) -> usize {
        let before = self.tracks.len();
        for state in states {
            let model = SensorModel::default_of(SensorId(0), SensorKind::Asde);
            let plot = Plot {
                sensor: SensorId(0),
                kind: model.kind,
                time,
                sequence: 0,
                position_m: state.position(),
                axis: Vector2::new(1.0, 0.0),
                along_m2: 1.0,
                across_m2: 1.0,
                altitude_m: None,
                polar: None,
                identity: None,
                scnr_db: None,
            };
            if !sound(&plot) {
                continue;
            }
            let track = Track::start(self.next_serial, &plot, &self.config, model.interval_s);
            let Ok(mut track) = track else { continue };
            let Some(number) = self.numbers.take(time) else { break };
            track.take_over(time, state, number);
            self.next_serial += 1;
            self.statistics.started += 1;
            self.statistics.confirmed += 1;
            self.tracks.push(track);
        }
        self.last_scan = self.last_scan.max(Some(time));
        self.tracks.len() - before
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
        let sorted;
        let flights = if flights.is_sorted() {
            flights
        } else {
            sorted = flights.sorted();
            &sorted
        };
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
            if config.register_sites {
                self.registration.correct(&mut c.plot);
            }
            let extra = config.sensor(c.plot.sensor, c.plot.kind).extra_sigma_m;
            c.plot.along_m2 += extra * extra;
            c.plot.across_m2 += extra * extra;
        }
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
                last_plot: track.last_hit,
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
            if let (Stage::Ended, Some(number)) = (track.stage, track.number) {
                numbers.give_back(number, t_out);
            }
            track.stage != Stage::Ended
        });
        out.sort_by_key(|track| track.number);
        out
    }
}

fn sound(plot: &Plot) -> bool {
    let finite = plot.position_m.iter().all(|x| x.abs() <= FARTHEST_M);
    let axis = (plot.axis.norm_squared() - 1.0).abs() < 1e-6;
    let altitude = plot.altitude_m.is_none_or(f64::is_finite);
    finite && axis && altitude && Measurement::of(plot).is_ok() && plot.along_m2.is_finite()
}
