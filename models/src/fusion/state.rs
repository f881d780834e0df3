//! All that a tracker holds from scan to scan, and its buffers. The stages ([`super::stages`]) work on it.

use super::budget::Budget;
use super::buffers::{Batch, Candidate, Crowd, Look, Reachable};
use super::config::TrackingConfig;
use super::doubt::Entrances;
use super::numbers::Numbers;
use super::own::{Association, Initiation};
use super::places::Places;
use super::registration::Registration;
use super::resting::Resting;
use super::track_file::Track;
use super::way::Ring;
use super::weights::{Local, Shifts};
use crate::association::assignment::Solver;
use crate::association::certificate::Certificate;
use crate::association::cluster::Clusters;
use crate::association::grid::Grid;
use crate::association::jpda::Jpda;
use crate::association::lbp::Belief;
use crate::association::nearest::Pair;
use crate::association::one_to_one::OneToOne;
use crate::association::sparse::Sparse;
use crate::frames::{Point2, Vector2};
use crate::plot::{Identity, Plot};
use crate::time::SimTime;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

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
        position_m: Point2<f64>,
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
    /// Tracks of the clusters that it weighed.
    pub believed: u64,
    /// Of these: their marginals have bounds ([`crate::association::certificate`]).
    pub certified: u64,
    /// Of these: by the bounds one pair has more than even odds.
    pub certain: u64,
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

/// All tracks, scan after scan.
#[derive(Clone, Debug)]
pub struct Tracker {
    pub(super) config: TrackingConfig,
    pub(super) tracks: Vec<Track>,
    pub(super) numbers: Numbers,
    pub(super) registration: Registration,
    pub(super) next_serial: u64,
    pub(super) last_scan: Option<SimTime>,
    /// End of the scan before the one in hand.
    pub(super) previous: Option<SimTime>,
    /// Names of the plots of the last scans (see [`name_of`]), sorted scan by scan, and the latest time of each.
    pub(super) seen: VecDeque<(SimTime, Vec<u128>)>,
    pub(super) statistics: Statistics,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) gate_1: f64,
    pub(super) identified_gate: f64,
    /// The same of the kinematic gate: squared distance from the reachable set.
    pub(super) kinematic_gate: f64,
    /// What is older than this in the scan in hand is forgotten.
    pub(super) oldest: SimTime,
    pub(super) ring: Ring,
    /// Of each plot of the next scan: it came in from outside the federation.
    pub(super) outside: Vec<bool>,
    pub(super) labels: Resting,
    /// How well each place is seen, where lives go by existence.
    pub(super) places: Places,
    pub(super) work: Work,
    /// Somebody's own rules in place of ours.
    pub(super) association: Option<Arc<dyn Association>>,
    pub(super) initiation: Option<Arc<dyn Initiation>>,
}

/// Buffers kept from scan to scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    pub(super) keys: Vec<u64>,
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
    /// Of each plot of a cluster: the sum of what its tracks claim of it.
    pub(super) claimed: Vec<f64>,
    pub(super) positions: Vec<Point2<f64>>,
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
    pub(super) reaches: Vec<Reachable>,
    pub(super) pairs: Vec<Pair>,
    pub(super) scratch: Vec<Pair>,
    pub(super) single: Vec<Pair>,
    pub(super) clusters: Clusters,
    pub(super) local: Local,
    pub(super) weighted: Vec<(Plot, f64)>,
    pub(super) solver: Solver,
    pub(super) sparse: Sparse,
    pub(super) jpda: Jpda,
    pub(super) belief: Belief,
    pub(super) certificate: Certificate,
    pub(super) pairing: OneToOne,
    pub(super) crowd: Crowd,
    pub(super) near: Vec<std::ops::Range<usize>>,
    pub(super) budget: Budget,
    /// All updates of the scan are of merged states.
    pub(super) light: bool,
    /// The cluster in hand is too large for more than a few plots an update.
    pub(super) hurried: bool,
    pub(super) order: Vec<u128>,
    /// ln by which plots speak for tracks more.
    pub(super) shifts: Shifts,
    /// Where targets come into view.
    pub(super) entrances: Entrances,
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
    /// Whether the plot at this place of the caller's list came from outside.
    pub(super) fn is_outside(&self, place: usize) -> bool {
        self.outside.get(place).copied().unwrap_or(false)
    }
}
