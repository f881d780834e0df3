//! What a scan has in hand: plots with what gates ask of them, batches, and who was cut off from what.

use crate::filter::Measurement;
use crate::frames::Point2;
use crate::plot::Plot;
use crate::time::SimTime;
use std::ops::Range;

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
    pub(super) position_m: Point2<f64>,
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

/// Tracks in whose boxes lie more plots than are gated exactly.
#[derive(Clone, Debug, Default)]
pub(super) struct Crowd {
    /// Those tracks.
    pub(super) tracks: Vec<u32>,
    /// Places (in the grid's order) of plots in the boxes of tracks that did not look at all of them.
    pub(super) covered: Vec<u32>,
    /// How many such boxes begin less how many end at each place.
    pub(super) steps: Vec<i32>,
    pub(super) runs: Vec<Range<usize>>,
    pub(super) near: Vec<u32>,
    /// Distance (its bits), turn, place.
    pub(super) ranked: Vec<(u64, u32, u32)>,
}

impl Crowd {
    pub(super) fn begin(&mut self, places: usize) {
        self.tracks.clear();
        self.covered.clear();
        self.steps.clear();
        self.steps.resize(places + 1, 0);
    }

    /// Track `index` was cut off from plots of its box; from some without a look at them (`unseen`).
    pub(super) fn note(&mut self, index: u32, unseen: bool) {
        self.tracks.push(index);
        for run in self.runs.iter().filter(|_| unseen) {
            self.steps[run.start] += 1;
            self.steps[run.end] -= 1;
        }
    }

    pub(super) fn end(&mut self) {
        if self.tracks.is_empty() {
            return;
        }
        let mut depth = 0;
        for (place, step) in self.steps.iter().enumerate() {
            depth += step;
            if depth > 0 {
                self.covered.push(place as u32);
            }
        }
    }
}

/// A pair that a target of the track's class could just have made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reachable {
    pub(super) track: u32,
    pub(super) k: u32,
    /// The kinematic gate need not be asked.
    pub(super) hopeless: bool,
    pub(super) distance_m: f64,
}
