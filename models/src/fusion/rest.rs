//! Whether a target stands, by the places of its own plots.
//!
//! Who stood when it was last seen is looked for there, however long ago that was: what appears beside it is somebody else.

use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// Plots that lie about one place, up to the last one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    since: SimTime,
    until: SimTime,
    /// Mean of the last plots.
    place_m: Point2<f64>,
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
    pub(super) fn place_m(&self) -> Option<Point2<f64>> {
        let rests =
            self.slow && self.plots >= FEWEST_PLOTS && self.until.since_s(self.since) >= LEAST_S;
        rests.then_some(self.place_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;

    fn plot(t: f64, x: f64) -> Plot {
        plot_at(t, x, 0.0, 2.0)
    }

    fn stay(rest: &mut Rest, from_s: u32, seconds: u32, x: f64) {
        for k in from_s..from_s + seconds {
            rest.note(&plot(f64::from(k), x), Vector2::zeros(), false);
        }
    }

    /// After an hour at one place it stands 8 m farther: forty looks on it is looked for there.
    #[test]
    fn where_it_stands_is_where_it_stood_lately() {
        let mut rest = Rest::begun(&plot(0.0, 0.0));
        stay(&mut rest, 1, 3_600, 0.0);
        stay(&mut rest, 3_601, 40, 8.0);
        let place = rest.place_m().expect("stands").x;
        assert!((place - 8.0).abs() < 0.3, "{place}");
    }

    #[test]
    fn ten_seconds_of_slow_plots_of_one_place_are_a_stay_and_a_new_beginning_is_none() {
        let mut rest = Rest::begun(&plot(0.0, 0.0));
        stay(&mut rest, 1, 9, 0.0);
        assert_eq!(rest.place_m(), None);
        stay(&mut rest, 10, 1, 0.0);
        assert!(rest.place_m().is_some());
        let mut fast = rest;
        fast.note(&plot(11.0, 1.0), Vector2::new(3.1, 0.0), false);
        assert_eq!(fast.place_m(), None, "what moves does not stand");
        let mut far = rest;
        far.note(&plot(11.0, 15.2), Vector2::zeros(), false);
        assert_eq!(far.place_m(), None, "it is somewhere else");
        rest.note(&plot(11.0, 1.0), Vector2::zeros(), true);
        assert_eq!(rest.place_m(), None, "its state began again");
        stay(&mut rest, 12, 10, 1.0);
        assert!(rest.place_m().is_some());
    }
}
