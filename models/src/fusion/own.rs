//! Somebody's own rules in place of ours: which gated plot a track gets, which plots begin a track, when one is confirmed.
//!
//! Everything else stays: gates, filters, coasting, labels, publication. `Tracker::with_association` and
//! `Tracker::with_initiation` put them in; a whole tracker of one's own needs neither (`studies/examples/my_tracker.rs`).

use crate::plot::Plot;
use std::fmt::Debug;

/// A plot inside the covariance gate of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatedPair {
    /// Which track: equal numbers are one track, within a call.
    pub track: u32,
    /// Which plot, likewise.
    pub plot: u32,
    /// Squared normalised distance: χ² with `dof` degrees of freedom if the plot is the track's.
    pub d2: f64,
    /// ln of the determinant of the innovation covariance (m⁴; m² where `dof` is 1).
    pub ln_det: f64,
    /// 2, or 1 for a plot that measures one direction.
    pub dof: u8,
}

/// Decides which of its gated plots each track gets.
pub trait Association: Debug + Send + Sync {
    /// The pairs to be taken, as places in `pairs` (sorted by track, then plot). Of pairs that share a track or a plot the
    /// first one given counts; what is no place is passed over. Equal input has to give equal output.
    fn assign(&self, pairs: &[GatedPair]) -> Vec<usize>;
}

/// What becomes of a track on trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trial {
    /// Nothing yet.
    Goes,
    /// It is confirmed.
    Confirmed,
    /// It is dropped.
    Dropped,
}

/// What a track on trial has shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown {
    /// One bit for each expected update, the newest lowest: 1 where a plot came.
    pub history: u32,
    /// Expected updates so far.
    pub looks: u32,
    /// Plots so far, the first one included.
    pub plots: u32,
    /// A plot carried a name.
    pub named: bool,
}

/// Decides which plots begin tracks, and which tracks are published.
pub trait Initiation: Debug + Send + Sync {
    /// Whether a plot that no track took, and that lies in no gate of a confirmed track, begins one.
    fn begins(&self, plot: &Plot) -> bool;

    /// What becomes of a track on trial at the end of a scan.
    fn judge(&self, shown: &Shown) -> Trial;
}
