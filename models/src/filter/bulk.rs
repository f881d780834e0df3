//! Many tracks in one pass: the per-axis constant-acceleration filter in f32, eight tracks side by side.
//!
//! A position is kept as a whole number of metres (exact in f64) plus a remainder of at most a few
//! hundred metres in f32, whose steps are then below 0.1 mm wherever on earth the target is. A f32 that
//! held an airport's corner would move in steps of 1 mm, an earth-centred one in steps of half a metre.

use super::gaussian::{Gaussian, Measurement};
use super::lanes::Pair;
use super::three_state::start_position;
use super::{Estimate, Start, UpdateError};
use crate::plot::Plot;
use crate::time::SimTime;
use wide::f32x8;

/// Tracks per block.
const LANES: usize = 8;
/// A remainder beyond this is moved into the whole number of metres.
const REMAINDER_M: f32 = 500.0;

/// One axis of eight tracks.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    x: [f32x8; 3],
    p: [f32x8; 6],
}

#[derive(Clone, Copy, Debug, Default)]
struct Block {
    axes: [Axis; 2],
    origin: [[f64; LANES]; 2],
    time: [SimTime; LANES],
}

/// The tracks. Their numbers are their order of arrival.
#[derive(Clone, Debug)]
pub struct Bulk {
    blocks: Vec<Block>,
    len: usize,
    q: f32,
    start: Start,
}

/// What one pass did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pass {
    /// Tracks updated.
    pub updated: usize,
    /// Plots refused: late, unsound, or in one direction only.
    pub refused: usize,
}

impl Bulk {
    /// No tracks; `q` in m²/s⁵.
    #[must_use]
    pub fn new(q: f32, start: Start) -> Self {
        Self { blocks: Vec::new(), len: 0, q, start }
    }

    /// Number of tracks.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A new track from its first plot; its number.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn push(&mut self, plot: &Plot) -> Result<usize, UpdateError> {
        start_position(plot)?;
        if self.len == self.blocks.len() * LANES {
            self.blocks.push(Block::default());
        }
        let number = self.len;
        self.len += 1;
        self.restart(number, plot)?;
        Ok(number)
    }

    /// Starts a track again from one plot.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    ///
    /// # Panics
    /// If there is no such track.
    pub fn restart(&mut self, number: usize, plot: &Plot) -> Result<(), UpdateError> {
        assert!(number < self.len, "track {number} of {}", self.len);
        let (z, r) = start_position(plot)?;
        let (block, lane) = (&mut self.blocks[number / LANES], number % LANES);
        let (v, a) = (self.start.sigma_v_mps as f32, self.start.sigma_a_ms2 as f32);
        for (k, (z, r)) in [(z.x, r.xx), (z.y, r.yy)].into_iter().enumerate() {
            let whole = z.round();
            block.origin[k][lane] = whole;
            let axis = &mut block.axes[k];
            for (slot, value) in axis.x.iter_mut().zip([(z - whole) as f32, 0.0, 0.0]) {
                slot.as_mut_array()[lane] = value;
            }
            for (slot, value) in axis.p.iter_mut().zip([r as f32, 0.0, 0.0, v * v, 0.0, a * a]) {
                slot.as_mut_array()[lane] = value;
            }
        }
        block.time[lane] = plot.time;
        Ok(())
    }

    /// Predicts every track that has a plot to the time of that plot and takes it; the others stay.
    /// `plots[i]` is for track i; missing ones at the end count as none.
    pub fn update(&mut self, plots: &[Option<Plot>]) -> Pass {
        let mut pass = Pass::default();
        let q = f32x8::splat(self.q);
        for (block, plots) in self.blocks.iter_mut().zip(plots.chunks(LANES)) {
            let mut z = [[0f32; LANES]; 2];
            let mut r = [[1f32; LANES]; 2];
            let mut t = [0f32; LANES];
            let mut takes = [0f32; LANES];
            for (lane, plot) in plots.iter().enumerate() {
                let Some(plot) = plot else { continue };
                let dt = plot.time.since_s(block.time[lane]);
                match Measurement::of(plot) {
                    Ok(Measurement::Position { z: at, r: cov }) if dt >= 0.0 => {
                        z[0][lane] = (at.x - block.origin[0][lane]) as f32;
                        z[1][lane] = (at.y - block.origin[1][lane]) as f32;
                        (r[0][lane], r[1][lane]) = (cov.xx as f32, cov.yy as f32);
                        (t[lane], takes[lane]) = (dt as f32, 1.0);
                        block.time[lane] = plot.time;
                        pass.updated += 1;
                    }
                    _ => pass.refused += 1,
                }
            }
            let (t, takes) = (f32x8::new(t), f32x8::new(takes));
            for (k, axis) in block.axes.iter_mut().enumerate() {
                *axis = axis.stepped(t, q, f32x8::new(z[k]), f32x8::new(r[k]), takes);
                let far = axis.x[0].to_array();
                for (lane, far) in far.iter().enumerate() {
                    if far.abs() > REMAINDER_M {
                        let whole = far.round();
                        axis.x[0].as_mut_array()[lane] -= whole;
                        block.origin[k][lane] += f64::from(whole);
                    }
                }
            }
        }
        pass
    }

    /// The state of track `number` at its last plot.
    ///
    /// # Panics
    /// If there is no such track.
    #[must_use]
    pub fn estimate(&self, number: usize) -> Estimate {
        assert!(number < self.len, "track {number} of {}", self.len);
        let (block, lane) = (&self.blocks[number / LANES], number % LANES);
        let of = |get: &dyn Fn(&Axis) -> f32x8| {
            let [east, north] = [0, 1].map(|k| f64::from(get(&block.axes[k]).to_array()[lane]));
            Pair::new(east, north)
        };
        let mut state = Gaussian {
            x: std::array::from_fn(|i| of(&|axis| axis.x[i])),
            p: std::array::from_fn(|i| of(&|axis| axis.p[i])),
            cross: [0.0; 9],
        };
        state.x[0] = state.x[0] + Pair::new(block.origin[0][lane], block.origin[1][lane]);
        Estimate::new(block.time[lane], state)
    }
}

impl Axis {
    /// Predict and update as [`super::three_state`]; lanes where `takes` is 0 have t = 0 and no gain.
    #[inline]
    fn stepped(&self, t: f32x8, q: f32x8, z: f32x8, r: f32x8, takes: f32x8) -> Self {
        let s = f32x8::splat;
        let h = s(0.5) * t * t;
        let [a, b, c, e, f, g] = self.p;
        let (q1, q2, q3) = (q * t, q * t * t, q * t * t * t);
        let (c0, f0) = (c + f * t + g * h, f + g * t);
        let (b0, e0) = (b + e * t + f * h, e + f * t);
        let a = a + b * t + c * h + b0 * t + c0 * h + q3 * t * t * s(1.0 / 20.0);
        let b = b0 + c0 * t + q3 * t * s(1.0 / 8.0);
        let c = c0 + q3 * s(1.0 / 6.0);
        let e = e0 + f0 * t + q3 * s(1.0 / 3.0);
        let f = f0 + q2 * s(0.5);
        let g = g + q1;
        let x0 = self.x[0] + self.x[1] * t + self.x[2] * h;
        let x1 = self.x[1] + self.x[2] * t;
        let i = takes / (a + r);
        let w = s(1.0) - takes + r * i;
        let nu = z - x0;
        let (k0, k1, k2) = (a * i, b * i, c * i);
        Self {
            x: [x0 + k0 * nu, x1 + k1 * nu, self.x[2] + k2 * nu],
            p: [a * w, b * w, c * w, e - k1 * b, f - k1 * c, g - k2 * c],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::StateEstimator;
    use crate::filter::testing::{plot_at, random_plots};
    use crate::filter::three_state::ThreeState;
    use crate::frames::Vector2;

    #[test]
    fn f32_follows_f64_to_a_centimetre_at_the_airports_corner() {
        let corner = Vector2::new(9_000.123, -7_500.456);
        let moved = |plot: &Plot| Plot { position_m: plot.position_m + corner, ..*plot };
        let runs: Vec<Vec<Plot>> = (0..19).map(|seed| random_plots(300, seed)).collect();
        let mut bulk = Bulk::new(0.3, Start::default());
        let mut exact = Vec::new();
        for run in &runs {
            bulk.push(&moved(&run[0])).unwrap();
            exact.push(ThreeState::from_plot(&moved(&run[0]), 0.3, Start::default()).unwrap());
        }
        for k in 1..300 {
            // Every seventh plot of a track is missing.
            let missing = |track: usize| (k + track).is_multiple_of(7);
            let plots: Vec<Option<Plot>> = runs
                .iter()
                .enumerate()
                .map(|(track, run)| (!missing(track)).then(|| moved(&run[k])))
                .collect();
            let pass = bulk.update(&plots);
            assert_eq!(pass.updated, plots.iter().flatten().count());
            for (track, filter) in exact.iter_mut().enumerate() {
                if let Some(plot) = &plots[track] {
                    filter.update(plot).unwrap();
                }
                let (a, b) = (bulk.estimate(track), filter.estimate());
                assert_eq!(a.time, b.time);
                assert!((a.position_m() - b.position_m()).norm() < 0.01, "scan {k} track {track}");
                assert!(a.state.is_sound());
                let difference = a.state.covariance() - b.state.covariance();
                assert!(difference.amax() < 1e-3 * b.state.covariance().amax());
            }
        }
    }

    #[test]
    fn late_and_unsound_plots_are_refused_and_change_nothing() {
        let mut bulk = Bulk::new(0.3, Start::default());
        bulk.push(&plot_at(10.0, 1.0, 2.0, 4.0)).unwrap();
        let before = bulk.estimate(0);
        for bad in [plot_at(9.0, 1.0, 2.0, 4.0), plot_at(11.0, f64::NAN, 2.0, 4.0)] {
            assert_eq!(bulk.update(&[Some(bad)]), Pass { updated: 0, refused: 1 });
            assert_eq!(bulk.estimate(0), before);
        }
        assert_eq!(bulk.update(&[None]), Pass::default());
        assert_eq!(bulk.estimate(0), before);
    }
}
