//! One scan: plots in, tracks out.

use super::budget::Budget;
use super::config::{SensorModel, TrackingConfig};
use super::labels;
use super::life;
use super::numbers::Numbers;
use super::registration::{Registration, SiteBias};
use super::ring::Ring;
use super::track_file::{Stage, Track};
use crate::association::assignment::Solver;
use crate::association::cluster::Clusters;
use crate::association::gate::chi_square_quantile;
use crate::association::grid::Grid;
use crate::association::jpda::Jpda;
use crate::association::lbp::Belief;
use crate::association::nearest::Pair;
use crate::association::sparse::Sparse;
use crate::filter::{Gaussian, Measurement, Rung};
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::plot::{Identity, Plot, SensorId, SensorKind};
use crate::time::SimTime;
use crate::track::{SystemTrack, TrackStatus};
use std::collections::{BTreeMap, VecDeque};

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
        velocity_mps: Vector2<f64>,
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
    /// Labels taken back, as what the track showed later spoke against them.
    pub label_revisions: u64,
    /// One identity seen on two tracks.
    pub identity_conflicts: u64,
    /// Clusters too large for exact joint association: done by belief propagation.
    pub large_clusters: u64,
    /// Tracks of the largest cluster.
    pub largest_cluster: u64,
    /// Sweeps of belief propagation.
    pub sweeps: u64,
    /// Times that more plots lay in a track's search box than were gated.
    pub crowded: u64,
    /// Plots given to such tracks by the order of their places.
    pub paired_by_rank: u64,
    /// Updates of a track merged to one Gaussian, as the scan's budget did not bear its filter.
    pub merged_updates: u64,
    /// Scans in which all updates were so.
    pub light_scans: u64,
    /// Evaluations counted (of ten nanoseconds, by a table).
    pub evaluations: u64,
    /// The same of the dearest scan.
    pub most_evaluations: u64,
    /// Times that the clock was set back and all tracks were dropped.
    pub clock_resets: u64,
}

/// Refused plots in a row with a track's name after which the name is withheld.
const NAME_DOUBTED: u32 = 5;

/// Batches into which the plots of one sensor in one scan are cut at most.
const BATCHES: i64 = 64;

/// Positions farther from the reference point than this are no airport traffic, m.
const FARTHEST_M: f64 = 1e6;

/// One plot of the scan in hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) plot: Plot,
    /// Its place in the caller's list.
    pub(super) index: usize,
}

/// What gates ask of a plot; laid out in the order of a grid's cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) time: SimTime,
    /// Nothing that can be measured with.
    pub(super) measured: Option<Measurement>,
    pub(super) position_m: Vector2<f64>,
    /// Its place among the candidates.
    pub(super) k: u32,
    /// It carries an identity.
    pub(super) named: bool,
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
    pub(super) numbers: Numbers,
    pub(super) registration: Registration,
    pub(super) next_serial: u64,
    last_scan: Option<SimTime>,
    /// End of the scan before the one in hand.
    pub(super) previous: Option<SimTime>,
    /// Names of the plots of the last scans (see [`name_of`]), sorted scan by scan, and the latest time of each.
    seen: VecDeque<(SimTime, Vec<u128>)>,
    pub(super) statistics: Statistics,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) gate_1: f64,
    pub(super) identified_gate: f64,
    /// What is older than this in the scan in hand is forgotten.
    pub(super) oldest: SimTime,
    pub(super) ring: Ring,
    /// Of each plot of the next scan: it came in from outside the federation.
    outside: Vec<bool>,
    labels: labels::Labels,
    work: Work,
}

/// Buffers kept from scan to scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    keys: Vec<u64>,
    pub(super) candidates: Vec<Candidate>,
    /// Of each candidate: a track has it.
    pub(super) used: Vec<bool>,
    /// Of each candidate: inside the covariance gate of a confirmed track.
    pub(super) gated: Vec<bool>,
    /// Of each candidate: it carries the name of a confirmed track that other plots still call so.
    pub(super) held: Vec<bool>,
    pub(super) batches: Vec<Batch>,
    /// Tracks by stage at the start of the scan; the tentative ones grow.
    pub(super) confirmed: Vec<u32>,
    pub(super) tentative: Vec<u32>,
    /// Tracks on whose body other echoes may lie.
    pub(super) bodied: Vec<u32>,
    /// How many pairs want each plot.
    pub(super) claims: Vec<u32>,
    pub(super) positions: Vec<Vector2<f64>>,
    /// Earliest and latest time of the batch.
    pub(super) span: (SimTime, SimTime),
    /// Candidates of the batch that no track had when they were laid out.
    pub(super) free: Vec<u32>,
    /// Those, and the largest of their variances, m².
    pub(super) plots: Grid,
    pub(super) looks: Vec<Look>,
    pub(super) widest_m2: f64,
    /// Labelled tracks, for other echoes of their bodies.
    pub(super) bodies: Grid,
    pub(super) reaches: Vec<super::gate::Reachable>,
    pub(super) pairs: Vec<Pair>,
    pub(super) scratch: Vec<Pair>,
    pub(super) single: Vec<Pair>,
    pub(super) clusters: Clusters,
    pub(super) local: super::associate::Local,
    pub(super) weighted: Vec<(Plot, f64)>,
    pub(super) solver: Solver,
    pub(super) sparse: Sparse,
    pub(super) jpda: Jpda,
    pub(super) belief: Belief,
    pub(super) crowd: super::gate::Crowd,
    pub(super) near: Vec<std::ops::Range<usize>>,
    pub(super) budget: Budget,
    /// All updates of the scan are of merged states.
    pub(super) light: bool,
    pub(super) order: Vec<u128>,
    pub(super) track_used: Vec<bool>,
    /// Of each track: the plot of the batch that it takes.
    pub(super) chosen: Vec<u32>,
    pub(super) plot_used: Vec<bool>,
    /// Identities of the tracks with their indices, sorted.
    pub(super) identities: Vec<(Identity, u32)>,
    /// Names that went to another track in this batch.
    pub(super) renamed: BTreeMap<Identity, u32>,
    /// Tracks that are published.
    pub(super) seen: Vec<u32>,
}

impl Tracker {
    /// A tracker without tracks. Its [`Self::config`] names what is done: `imm3` where `mh9-map` was asked for without a
    /// map. Numbers of sensors that cannot be used ([`TrackingConfig::check`]) are replaced by the defaults of their kind.
    #[must_use]
    pub fn new(mut config: TrackingConfig) -> Self {
        config.sensors.iter_mut().for_each(|sensor| *sensor = sensor.sound());
        // A rung that has nothing to go by is not called by its name.
        if config.filter.rung == Rung::Mh9Map && config.filter.map.is_none() {
            config.filter.rung = Rung::Imm3;
        }
        let numbers = Numbers::new(config.life.numbers, config.life.number_rest_s);
        let registration = Registration::new(config.echo_law());
        let gate_1 = chi_square_quantile(2, config.gates.probability);
        let identified_gate = chi_square_quantile(2, config.gates.identified_probability);
        let work = Work { budget: Budget::new(&config), ..Work::default() };
        Self {
            config,
            tracks: Vec::new(),
            numbers,
            registration,
            next_serial: 0,
            last_scan: None,
            previous: None,
            seen: VecDeque::new(),
            statistics: Statistics::default(),
            outcomes: Vec::new(),
            gate_1,
            identified_gate,
            oldest: SimTime(i64::MIN),
            ring: Ring::default(),
            outside: Vec::new(),
            labels: labels::Labels::default(),
            work,
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
            if !sound(&plot) || !state.is_sound() {
                continue;
            }
            let track = Track::start(self.next_serial, &plot, &self.config, model.interval_s);
            let Ok(mut track) = track else { continue };
            let Some(number) = self.numbers.take(time, false) else { break };
            track.take_over(time, state, number);
            self.next_serial += 1;
            self.statistics.started += 1;
            self.statistics.confirmed += 1;
            self.tracks.push(track);
        }
        self.last_scan = self.last_scan.max(Some(time));
        self.tracks.len() - before
    }

    /// Says which plots of the next [`Self::scan`] came in from outside the federation, index by index.
    /// Tracks that they begin take their numbers behind all others and no label by place, and they do
    /// not register radars; else they are plots as any.
    pub fn mark_outside(&mut self, outside: Vec<bool>) {
        self.outside = outside;
    }

    /// Whether the plot at this place of the caller's list came from outside.
    pub(super) fn is_outside(&self, place: usize) -> bool {
        self.outside.get(place).copied().unwrap_or(false)
    }

    /// Serials (order of birth) of all tracks, with their numbers once they are confirmed.
    pub fn serials(&self) -> impl Iterator<Item = (u64, Option<u16>)> {
        self.tracks.iter().map(|track| (track.serial, track.number))
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
        let mut work = std::mem::take(&mut self.work);
        self.take_in(t_out, plots, &mut work);
        self.sort_tracks(&mut work);
        work.budget.begin();
        work.light = !work.budget.bears(self.tracks.len());
        self.statistics.light_scans += u64::from(work.light && work.budget.dear());
        for batch in 0..work.batches.len() {
            let Batch { from, to } = work.batches[batch];
            self.associate_batch(from, to, &mut work);
        }
        let mut out = self.end_of_scan(t_out, flights, &mut work.seen);
        let (labels, tracks) = (&mut self.labels, &mut self.tracks);
        let changes = labels::assign(labels, tracks, flights, &self.config, t_out, &mut work);
        self.statistics.identity_conflicts += changes.conflicts;
        self.statistics.label_revisions += changes.revisions;
        let (tracks, statistics) = (&mut self.tracks, &mut self.statistics);
        life::merge_duplicates(tracks, &out, &self.config, &mut work, statistics);
        self.publish(t_out, flights, &work.seen, &mut out);
        let spent = work.budget.spent();
        self.statistics.evaluations += spent;
        self.statistics.most_evaluations = self.statistics.most_evaluations.max(spent);
        self.work = work;
        self.outside.clear();
        out
    }

    fn begin(&mut self, t_out: SimTime) {
        self.statistics.scans += 1;
        if self.last_scan.is_some_and(|last| t_out < last) {
            self.statistics.clock_resets += 1;
            self.tracks.clear();
            self.ring.clear();
            self.labels = labels::Labels::default();
            self.seen.clear();
            self.numbers = Numbers::new(self.config.life.numbers, self.config.life.number_rest_s);
            self.last_scan = None;
        }
        if self.config.register_sites {
            self.registration.begin(t_out);
        }
        self.oldest = t_out.plus_s(-self.config.ring_s);
        while self.seen.front().is_some_and(|(latest, _)| *latest < self.oldest) {
            self.seen.pop_front();
        }
    }

    /// Sorts the plots by (sensor, time, sequence), refuses what cannot be taken, and cuts batches.
    fn take_in(&mut self, t_out: SimTime, plots: &[Plot], work: &mut Work) {
        self.outcomes.clear();
        self.outcomes.resize(plots.len(), Outcome::Unused);
        self.statistics.plots += plots.len() as u64;
        let order = Order::new(self.oldest, t_out, plots.len());
        work.keys.clear();
        for (index, plot) in plots.iter().enumerate() {
            if !sound(plot) || plot.time > t_out {
                self.outcomes[index] = Outcome::Unsound;
                self.statistics.unsound += 1;
            } else if plot.time < self.oldest {
                self.outcomes[index] = Outcome::TooLate;
                self.statistics.too_late += 1;
            } else {
                work.keys.push(order.key(plot, index));
            }
        }
        order.sort(&mut work.keys, plots);
        work.candidates.clear();
        work.batches.clear();
        let last_scan = self.last_scan;
        let start = last_scan.unwrap_or_else(|| {
            let times = work.keys.iter().map(|&key| plots[order.place(key)].time);
            SimTime(times.min().unwrap_or(t_out).0.saturating_sub(1))
        });
        (self.previous, self.last_scan) = (self.last_scan, Some(t_out));
        let mut names: Vec<u128> = Vec::with_capacity(work.keys.len());
        let mut latest = SimTime(i64::MIN);
        // Batches: one sensor, one of its intervals, counted from the end of the last scan.
        let (mut sensor, mut end, mut interval) = (None, i64::MIN, 1);
        let (mut extra_m2, mut latency_ns) = (0.0, 0);
        for &key in &work.keys {
            let index = order.place(key);
            let plot = &plots[index];
            let name = name_of(plot);
            let before = |scan: &Vec<u128>| scan.binary_search(&name).is_ok();
            if names.last() == Some(&name)
                || (last_scan.is_some_and(|last| plot.time <= last)
                    && self.seen.iter().any(|(_, scan)| before(scan)))
            {
                self.outcomes[index] = Outcome::Duplicate;
                self.statistics.duplicates += 1;
                continue;
            }
            names.push(name);
            latest = latest.max(plot.time);
            let k = work.candidates.len();
            let same = sensor == Some((plot.sensor, plot.kind));
            if !same {
                let model = self.config.sensor(plot.sensor, plot.kind);
                let spread = t_out.0.saturating_sub(start.0) / BATCHES;
                interval = SimTime::from_s(model.interval_s.clamp(1e-3, 1e6)).0.max(spread);
                extra_m2 = model.extra_sigma_m * model.extra_sigma_m;
                latency_ns = SimTime::from_s(model.latency_s.clamp(0.0, 60.0)).0;
            }
            let other = sensor.is_none_or(|(id, _)| id != plot.sensor);
            if other || plot.time.0 >= end {
                let since = plot.time.0.saturating_sub(start.0).saturating_sub(1);
                let number = since.div_euclid(interval);
                let length = interval.saturating_mul(number.saturating_add(1));
                end = start.0.saturating_add(1).saturating_add(length);
                work.batches.push(Batch { from: k, to: k });
            }
            sensor = Some((plot.sensor, plot.kind));
            work.candidates.push(Candidate { plot: *plot, index });
            let plot = &mut work.candidates[k].plot;
            if plot.polar.is_some() {
                // The site's errors, and the near side of a target of which nothing is known; its track knows more.
                plot.position_m -= self.registration.correction_m(plot);
                plot.position_m += plot.axis * self.registration.law().unknown_m.0;
            }
            plot.time = SimTime(plot.time.0.saturating_sub(latency_ns));
            // What the sensor's model adds to the stated variance.
            plot.along_m2 += extra_m2;
            plot.across_m2 += extra_m2;
        }
        self.seen.push_back((latest, names));
        let candidates = &work.candidates;
        let mut to = candidates.len();
        for batch in work.batches.iter_mut().rev() {
            batch.to = to;
            to = batch.from;
        }
        work.batches
            .sort_by_key(|b| (candidates[b.from].plot.time, candidates[b.from].plot.sensor));
        for flags in [&mut work.used, &mut work.gated, &mut work.held] {
            flags.clear();
            flags.resize(candidates.len(), false);
        }
    }

    /// Lists of the tracks by what may happen to them in this scan.
    fn sort_tracks(&mut self, work: &mut Work) {
        work.confirmed.clear();
        work.tentative.clear();
        work.bodied.clear();
        for (index, track) in self.tracks.iter_mut().enumerate() {
            track.unresolved = false;
            match track.stage {
                Stage::Confirmed => work.confirmed.push(index as u32),
                Stage::Tentative => work.tentative.push(index as u32),
                Stage::Ended => {}
            }
            if track.stage == Stage::Confirmed && track.size_m.is_some() {
                work.bodied.push(index as u32);
            }
        }
    }

    /// What is left to be said of each confirmed track, by number; ended tracks leave.
    fn publish(
        &mut self,
        t_out: SimTime,
        flights: &FlightList,
        seen: &[u32],
        out: &mut [SystemTrack],
    ) {
        for (&index, shown) in seen.iter().zip(&mut *out) {
            let track = &mut self.tracks[index as usize];
            if track.name_refused >= NAME_DOUBTED {
                // What calls itself so is seen elsewhere.
                (shown.reported, shown.label_p) = (None, Some(1.0 - labels::NAMED));
            } else {
                (shown.track_type, shown.label) = labels::label(track.entry, flights);
                (shown.assumed, shown.label_p) = (track.assumed, track.label_p);
            }
            shown.status = match track.stage {
                Stage::Ended => TrackStatus::Last,
                _ if !track.updated && track.history & 1 == 0 => TrackStatus::Coasting,
                _ => TrackStatus::Confirmed,
            };
            (track.heading_rad, track.published) = (shown.heading_rad, true);
        }
        if !out.is_sorted_by_key(|track| track.number) {
            out.sort_by_cached_key(|track| track.number);
        }
        let mut ended = false;
        for track in &mut self.tracks {
            (track.updated, track.manoeuvre) = (false, false);
            ended |= track.stage == Stage::Ended;
        }
        if !ended {
            return;
        }
        let (numbers, ring, labels) = (&mut self.numbers, &mut self.ring, &mut self.labels);
        self.tracks.retain_mut(|track| {
            if track.stage != Stage::Ended {
                return true;
            }
            if let Some(number) = track.number {
                numbers.give_back(number, t_out);
            }
            if let Some(entry) = track.entry {
                labels.rest(entry, t_out);
            }
            track.leave(ring);
            false
        });
    }
}

/// The order in which plots are taken: by their names, and of one name by position. One short key each, sensor
/// before coarse time before place in the caller's list; with care where two keys differ in the place alone.
#[derive(Clone, Copy, Debug)]
struct Order {
    oldest: SimTime,
    time_bits: u32,
    place_bits: u32,
    shift: u32,
}

impl Order {
    /// For up to `plots` plots of times from `oldest` to `t_out`.
    fn new(oldest: SimTime, t_out: SimTime, plots: usize) -> Self {
        let span = t_out.0.saturating_sub(oldest.0).max(0).cast_unsigned();
        let place_bits = usize::BITS - plots.leading_zeros();
        let time_bits = 48 - place_bits.min(32);
        let shift = (u64::BITS - span.leading_zeros()).saturating_sub(time_bits);
        Self { oldest, time_bits, place_bits, shift }
    }

    #[inline]
    fn key(&self, plot: &Plot, place: usize) -> u64 {
        let time = plot.time.0.saturating_sub(self.oldest.0).cast_unsigned() >> self.shift;
        let coarse = (u64::from(plot.sensor.0) << self.time_bits) | time;
        (coarse << self.place_bits) | place as u64
    }

    #[inline]
    fn place(&self, key: u64) -> usize {
        (key & ((1 << self.place_bits) - 1)) as usize
    }

    fn sort(&self, keys: &mut [u64], plots: &[Plot]) {
        keys.sort_unstable();
        for alike in keys.chunk_by_mut(|a, b| a >> self.place_bits == b >> self.place_bits) {
            if alike.len() > 1 {
                alike.sort_unstable_by(|&a, &b| {
                    let [p, q] = [a, b].map(|key| &plots[self.place(key)]);
                    let place = |p: &Plot, q: &Plot| {
                        let (p, q) = (p.position_m, q.position_m);
                        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
                    };
                    name_of(p).cmp(&name_of(q)).then_with(|| place(p, q)).then(a.cmp(&b))
                });
            }
        }
    }
}

/// The name of a plot, in the order in which plots are taken: sensor, time, number within the scan.
fn name_of(plot: &Plot) -> u128 {
    let time = plot.time.0.cast_unsigned() ^ (1 << 63);
    (u128::from(plot.sensor.0) << 96) | (u128::from(time) << 32) | u128::from(plot.sequence)
}

fn sound(plot: &Plot) -> bool {
    let near = plot.position_m.x.abs() <= FARTHEST_M && plot.position_m.y.abs() <= FARTHEST_M;
    near && plot.altitude_m.is_none_or(f64::is_finite) && Measurement::of(plot).is_ok()
}
