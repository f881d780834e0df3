//! Whether a target stands, by the places of its own plots.
//!
//! Who stood when it was last seen is looked for there, however long ago that was: what appears beside it is somebody else.

use crate::frames::Vector2;
use crate::plot::Plot;
use crate::time::SimTime;

/// Plots that lie about one place, up to the last one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    since: SimTime,
    until: SimTime,
    /// Mean of the last plots.
    place_m: Vector2<f64>,
    plots: u32,
    slow: bool,
}

/// Plots within this of their mean are of one place, m: the echoes of a large aircraft wander as far.
const STAYS_M: f64 = 15.0;
/// So many of them, over so many seconds, are a stay.
const FEWEST_PLOTS: u32 = 3;
const LEAST_S: f64 = 10.0;
/// What is faster does not stand, m/s.
const SLOW_MPS: f64 = 3.0;
/// The mean is of so many plots.
const REMEMBERED: u32 = 10;

impl Rest {
    /// Of a track that this plot begins.
    pub(super) fn begun(plot: &Plot) -> Self {
        let place_m = plot.position_m;
        Self { since: plot.time, until: plot.time, place_m, plots: 1, slow: false }
    }

    /// A plot has updated the track, which is now this fast; `anew`: its state began again with it.
    pub(super) fn note(&mut self, plot: &Plot, velocity_mps: Vector2<f64>, anew: bool) {
        let off_m = plot.position_m - self.place_m;
        if anew || !(off_m.norm() <= STAYS_M) {
            *self = Self::begun(plot);
            return;
        }
        self.plots += 1;
        self.place_m += off_m / f64::from(self.plots.min(REMEMBERED));
        self.until = self.until.max(plot.time);
        self.slow = velocity_mps.norm() < SLOW_MPS;
    }

    /// Where it stood when it was last seen, if it did, m.
    pub(super) fn place_m(&self) -> Option<Vector2<f64>> {
        let rests =
            self.slow && self.plots >= FEWEST_PLOTS && self.until.since_s(self.since) >= LEAST_S;
        rests.then_some(self.place_m)
    }
}
