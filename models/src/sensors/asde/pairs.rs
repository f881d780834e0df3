//! Looks that may share a cell with another one, wherever the centres of their echoes are.

use super::merging::{PLACE_STEP_M, Place};
use std::f64::consts::TAU;
use std::ops::Range;

/// A look as the search for pairs reads it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// Azimuth from the radar, in [−π, π].
    pub(super) azimuth_rad: f64,
    /// Distance on the ground.
    pub(super) ground_m: f64,
    /// How far the centre of its echo may lie from the target.
    pub(super) bias_m: f64,
}

/// So many looks are tested at once: most windows hold fewer.
const BLOCK: usize = 8;

/// All looks in few digits, for a first test of many at once.
#[derive(Clone, Debug, Default)]
struct Coarse {
    azimuth_rad: Vec<f32>,
    ground_m: Vec<f32>,
    bias_m: Vec<f32>,
}

/// The search: looks sorted by their slant range.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    looks: Vec<(Near, usize)>,
    order: Vec<Place>,
    /// In the order of the range, with a block of nobody behind: range steps, looks.
    steps: Vec<u32>,
    coarse: Coarse,
    widest_m: f64,
}

impl Pairs {
    /// Forgets all looks.
    pub(super) fn clear(&mut self) {
        self.looks.clear();
        self.order.clear();
        self.widest_m = 0.0;
    }

    /// Adds a look at a target, in the order of looks.
    pub(super) fn add(&mut self, target: usize, slant_m: f64, near: Near) {
        self.order.push(Place::new(0, slant_m, self.looks.len() as u32));
        self.looks.push((near, target));
        self.widest_m = self.widest_m.max(near.bias_m);
    }

    /// Marks the looks that may share a cell of a length and width; whether there are any.
    pub(super) fn find(&mut self, cell_m: f64, beam_rad: f64, paired: &mut Vec<bool>) -> bool {
        paired.clear();
        paired.resize(self.looks.len(), false);
        self.order.sort_unstable();
        self.steps.clear();
        self.steps.extend(self.order.iter().map(|place| place.step() as u32));
        self.steps.resize(self.looks.len() + BLOCK, u32::MAX);
        self.coarse.fill(self.order.iter().map(|place| &self.looks[place.index() as usize].0));
        let mut any = false;
        for first in 0..self.looks.len() {
            let one = &self.looks[self.order[first].index() as usize].0;
            let reach_m = cell_m + one.bias_m + self.widest_m;
            let last = self.steps[first].saturating_add((reach_m / PLACE_STEP_M) as u32 + 3);
            let mut from = first + 1;
            // Blocks as long as the window goes on; the last looks of the last one may be beyond it.
            while self.steps[from] <= last {
                let block = from..from + BLOCK;
                if self.coarse.may_be_near(first, block.clone(), beam_rad as f32) {
                    for second in block {
                        let (a, b) = (first, second.min(self.looks.len() - 1));
                        if a != b && self.may_share(a, b, cell_m, beam_rad) {
                            any = true;
                            paired[self.order[a].index() as usize] = true;
                            paired[self.order[b].index() as usize] = true;
                        }
                    }
                }
                from = (from + BLOCK).min(self.looks.len());
            }
        }
        any
    }

    /// Whether two looks, by their places in the order of the range, may be in one cell.
    fn may_share(&self, a: usize, b: usize, cell_m: f64, beam_rad: f64) -> bool {
        let look = |place: usize| &self.looks[self.order[place].index() as usize];
        let ((one, target), (other, of_other)) = (look(a), look(b));
        let biased_m = one.bias_m + other.bias_m;
        let apart_m = f64::from(self.steps[b] - self.steps[a]) * PLACE_STEP_M;
        let nearest_m = one.ground_m.min(other.ground_m).max(1.0);
        let turned = (one.azimuth_rad - other.azimuth_rad).abs();
        apart_m <= cell_m + biased_m + 2.0 * PLACE_STEP_M
            && turned.min(TAU - turned) < beam_rad + biased_m / nearest_m
            && target != of_other
    }
}

impl Coarse {
    fn fill<'a>(&mut self, looks: impl ExactSizeIterator<Item = &'a Near>) {
        let count = looks.len() + BLOCK;
        self.azimuth_rad.clear();
        self.ground_m.clear();
        self.bias_m.clear();
        for near in looks {
            self.azimuth_rad.push(near.azimuth_rad as f32);
            self.ground_m.push(near.ground_m.max(1.0) as f32);
            self.bias_m.push(near.bias_m as f32);
        }
        self.azimuth_rad.resize(count, 0.0);
        self.ground_m.resize(count, f32::INFINITY);
        self.bias_m.resize(count, 0.0);
    }

    /// Whether one of a block may be near enough in azimuth to a look: never less than what decides, rounding included.
    fn may_be_near(&self, look: usize, block: Range<usize>, beam_rad: f32) -> bool {
        let (azimuth_rad, ground_m, bias_m) =
            (self.azimuth_rad[look], self.ground_m[look], self.bias_m[look]);
        let azimuths = self.azimuth_rad[block.clone()].iter();
        let others = azimuths.zip(&self.ground_m[block.clone()]).zip(&self.bias_m[block]);
        others.fold(false, |any, ((azimuth, ground), bias)| {
            let turned = (azimuth_rad - azimuth).abs();
            let aside_rad = turned.min(std::f32::consts::TAU - turned) - beam_rad;
            let nearest_m = ground_m.min(*ground);
            any | ((aside_rad - 1e-5) * nearest_m <= bias_m + bias + 1.0)
        })
    }
}
