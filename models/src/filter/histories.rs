//! Mode histories: one Kalman filter per history of modes, the most likely ones kept.
//!
//! The exact filter of a target that switches between modes has a Gaussian for every sequence of modes
//! so far. Mixing them (IMM) smears what they know; keeping the N most likely ones apart does not.
//! Source: the "split Gaussian" or N-best form of the generalised pseudo-Bayes filter, Tugnait,
//! Automatica 18 (1982).
//!
//! With one scan of lag each history also keeps what its newest plot says of the scan before:
//! `x_{k−1|k} = x_{k−1} + P_{k−1}Φᵀ Hᵀ S⁻¹ ν`, `P_{k−1|k} = P_{k−1} − P_{k−1}ΦᵀHᵀ S⁻¹ HΦP_{k−1}`: a
//! smoothing step without any inverse of P⁻, which a constant-velocity mode leaves singular.

use super::gaussian::{Factor, Gaussian, Measurement, Nis, quadratic};
use super::lanes::Pair;
use super::mixtures::{PositionMoments, likeliest_after};
use super::modes::{MAX_MODES, Modes};
use super::motion::Step;
use super::three_state::start_position;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, Sym2, UpdateError, interval, measurements, weights};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use std::sync::Arc;

/// The filter with at most N histories; L is N to keep the state of the scan before, else 0.
#[derive(Clone, Debug)]
pub struct Histories<const N: usize, const L: usize> {
    time: SimTime,
    len: usize,
    states: [Gaussian; N],
    weights: [f64; N],
    log_weights: [f64; N],
    last_mode: [u8; N],
    before: [Gaussian; L],
    before_time: Option<SimTime>,
    modes: Arc<Modes>,
    start: Start,
}

/// A child of a kept history before it is worth a full update.
#[derive(Clone, Copy, Debug)]
struct Child {
    score: f64,
    parent: u16,
    mode: u16,
}

/// Most histories any rung keeps.
const MOST: usize = 27;
/// Children with less than e⁻³⁵ of the best one's weight change nothing that a double can show.
const NEGLIGIBLE: f64 = 35.0;

impl<const N: usize, const L: usize> Histories<N, L> {
    /// One plot: position measured, velocity and acceleration unknown; a history for every mode.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, modes: Arc<Modes>, start: Start) -> Result<Self, UpdateError> {
        const { assert!(N <= MOST && (L == 0 || L == N)) };
        let (z, r) = start_position(plot)?;
        let state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        let mut filter = Self {
            time: plot.time,
            len: 0,
            states: [state; N],
            weights: [0.0; N],
            log_weights: [0.0; N],
            last_mode: [0; N],
            before: [state; L],
            before_time: None,
            modes,
            start,
        };
        filter.replace(plot.time, &state);
        Ok(filter)
    }

    /// Histories kept now.
    #[must_use]
    pub fn kept(&self) -> usize {
        self.len
    }

    fn take(
        &mut self,
        plot: &Plot,
        adjust: impl Fn(&Modes, &mut [[f64; MAX_MODES]; MAX_MODES]),
    ) -> Result<Nis, UpdateError> {
        let t = interval(self.time, plot.time)?;
        let m = Measurement::of(plot)?;
        let modes = self.modes.count();
        let steps = self.modes.steps(t);
        let mut p = self.modes.transition(t);
        adjust(&self.modes, &mut p);
        let logs = p.map(|row| row.map(libm::log));

        let mut children =
            [Child { score: f64::NEG_INFINITY, parent: 0, mode: 0 }; MOST * MAX_MODES];
        let (mut count, mut best) = (0, f64::NEG_INFINITY);
        let mut moments = PositionMoments::about(self.states[0].position());
        for parent in 0..self.len {
            let from = usize::from(self.last_mode[parent]);
            for (mode, step) in steps.iter().enumerate().take(modes) {
                if p[from][mode] == 0.0 {
                    continue;
                }
                let (at, cov) = self.states[parent].predicted_position(step);
                moments.add(self.weights[parent] * p[from][mode], at, cov);
                let likelihood = log_likelihood(at, cov, &m);
                let score = self.log_weights[parent] + logs[from][mode] + likelihood;
                if score.is_nan() {
                    continue;
                }
                best = best.max(score);
                children[count] = Child { score, parent: parent as u16, mode: mode as u16 };
                count += 1;
            }
        }
        let nis = moments.nis(&m)?;
        if best == f64::NEG_INFINITY {
            return Err(UpdateError::BadInnovation(f64::INFINITY));
        }
        let chosen = most_likely::<N>(&mut children[..count], best);
        self.replace_by_children(chosen, best, &steps, &m)?;
        (self.before_time, self.time) = (Some(self.time), plot.time);
        Ok(nis)
    }

    fn replace_by_children(
        &mut self,
        chosen: &[Child],
        best: f64,
        steps: &[Step; MAX_MODES],
        m: &Measurement,
    ) -> Result<(), UpdateError> {
        let parents = self.states;
        let mut len = 0;
        for child in chosen {
            let (parent, mode) = (usize::from(child.parent), usize::from(child.mode));
            let step = &steps[mode];
            let predicted = parents[parent].predicted(step);
            let mut state = predicted;
            if state.update(m).is_err() {
                continue; // a child that rounding has broken
            }
            if L > 0 {
                self.before[len] = smoothed(&parents[parent], step, &predicted, m)?;
            }
            self.states[len] = state;
            self.log_weights[len] = child.score - best;
            self.last_mode[len] = child.mode as u8;
            len += 1;
        }
        if len == 0 {
            return Err(UpdateError::BadCovariance);
        }
        self.len = len;
        self.weights = self.log_weights;
        weights::normalise(&mut self.weights[..self.len]);
        Ok(())
    }

    fn mixed(&self, states: &[Gaussian]) -> Gaussian {
        Gaussian::mixture(&self.weights[..self.len], &states[..self.len])
    }
}

/// −½(d² + ln det S) of a plot against a predicted position.
#[inline]
fn log_likelihood(at: Point2<f64>, cov: Sym2, m: &Measurement) -> f64 {
    match *m {
        Measurement::Position { z, r } => {
            let (nu, s) = (z - at, cov + r);
            let det = s.xx * s.yy - s.xy * s.xy;
            let d2 = (s.yy * nu.x * nu.x - 2.0 * s.xy * nu.x * nu.y + s.xx * nu.y * nu.y) / det;
            if det > f64::MIN_POSITIVE && det < f64::INFINITY && s.xx > 0.0 {
                -0.5 * (d2 + libm::log(det))
            } else {
                f64::NAN
            }
        }
        Measurement::Line { z, axis, variance } => {
            let (nu, s) = ((z - at).dot(&axis), quadratic(cov, axis) + variance);
            if s > 0.0 { -0.5 * (nu * nu / s + libm::log(s)) } else { f64::NAN }
        }
    }
}

/// The N best children, best first; equal scores in order of parent and mode.
fn most_likely<const N: usize>(children: &mut [Child], best: f64) -> &[Child] {
    let order = |a: &Child, b: &Child| {
        b.score.total_cmp(&a.score).then((a.parent, a.mode).cmp(&(b.parent, b.mode)))
    };
    // Most children of a settled track are hopeless: leave them out before sorting.
    let mut kept = 0;
    for k in 0..children.len() {
        if children[k].score >= best - NEGLIGIBLE {
            children.swap(kept, k);
            kept += 1;
        }
    }
    let children = &mut children[..kept];
    if kept > N {
        children.select_nth_unstable_by(N - 1, order);
    }
    let children = &mut children[..kept.min(N)];
    children.sort_unstable_by(order);
    children
}

/// What the plot says of the scan before, given the mode of the step in between.
fn smoothed(
    parent: &Gaussian,
    step: &Step,
    predicted: &Gaussian,
    m: &Measurement,
) -> Result<Gaussian, UpdateError> {
    // Columns of P_{k−1}Φᵀ for the position east and north: rows of ΦP_{k−1}.
    let (p, c, t, f) = (&parent.p, &parent.cross, step.t, step.f02);
    let own = [p[0] + p[1] * t + p[2] * f, p[1] + p[3] * t + p[4] * f, p[2] + p[4] * t + p[5] * f];
    let columns = [
        std::array::from_fn(|i| Pair::new(own[i].east(), c[i] + c[3 + i] * t + c[6 + i] * f)),
        std::array::from_fn(|i| {
            Pair::new(c[3 * i] + c[3 * i + 1] * t + c[3 * i + 2] * f, own[i].north())
        }),
    ];
    let mut state = *parent;
    match *m {
        Measurement::Position { z, r } => {
            let factor = Factor::of(predicted.position_cov() + r)?;
            let (y, _) = factor.independent(z - predicted.position());
            state.condition(&columns, &factor, y);
        }
        Measurement::Line { z, axis, variance } => {
            let s = quadratic(predicted.position_cov(), axis) + variance;
            let along: [Pair; 3] =
                std::array::from_fn(|i| columns[0][i] * axis.x + columns[1][i] * axis.y);
            let nu = (z - predicted.position()).dot(&axis);
            for (x, gain) in state.x.iter_mut().zip(along) {
                *x = *x + gain * (nu / s);
            }
            state.add_outer(&along, -1.0 / s);
        }
    }
    Ok(state)
}

impl<const N: usize, const L: usize> StateEstimator for Histories<N, L> {
    fn time(&self) -> SimTime {
        self.time
    }

    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, self.mixed(&self.states))
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        Gaussian::mean_motion(&self.weights[..self.len], &self.states[..self.len])
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        let (p, steps) = (self.modes.transition(t), self.modes.steps(t));
        let modes = self.modes.count();
        // Prediction is linear: all histories together are one Gaussian for each mode they may change to.
        let mut weights = [0.0; MAX_MODES];
        let mut next = [Gaussian::default(); MAX_MODES];
        for mode in 0..modes {
            let mut share = [0.0; N];
            for k in 0..self.len {
                share[k] = self.weights[k] * p[usize::from(self.last_mode[k])][mode];
            }
            weights[mode] = share.iter().sum();
            if weights[mode] > 0.0 {
                share.iter_mut().for_each(|w| *w /= weights[mode]);
                let mixed = Gaussian::mixture(&share[..self.len], &self.states);
                next[mode] = mixed.predicted(&steps[mode]);
            }
        }
        Ok(Estimate::new(time, Gaussian::mixture(&weights, &next)))
    }

    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, |_, _| ())
    }

    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, Modes::expect_jump)
    }

    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let t = interval(self.time, first.time)?;
        let (p, steps) = (self.modes.transition(t), self.modes.steps(t));
        let mut children = Vec::new();
        let mut c = Vec::new();
        let mut states = Vec::new();
        for parent in 0..self.len {
            let from = usize::from(self.last_mode[parent]);
            for (mode, step) in steps.iter().enumerate().take(self.modes.count()) {
                if p[from][mode] > 0.0 {
                    c.push(self.weights[parent] * p[from][mode]);
                    states.push(self.states[parent].predicted(step));
                    children.push((parent, mode));
                }
            }
        }
        let kept = likeliest_after(&c, &states, &measurements(plots)?, N)?;
        let parents = self.states;
        for (slot, (k, state, log_weight)) in kept.iter().enumerate() {
            self.states[slot] = *state;
            if L > 0 {
                // Which plot it was is not known: nothing is said of the scan before.
                self.before[slot] = parents[children[*k].0];
            }
            self.log_weights[slot] = *log_weight;
            self.last_mode[slot] = children[*k].1 as u8;
        }
        self.len = kept.len();
        self.weights = self.log_weights;
        weights::normalise(&mut self.weights[..self.len]);
        (self.before_time, self.time) = (Some(self.time), first.time);
        Ok(())
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        let prior = self.modes.prior();
        self.len = self.modes.count().min(N);
        for (k, prior) in prior.iter().enumerate().take(self.len) {
            self.states[k] = *state;
            self.log_weights[k] = libm::log(*prior);
            self.last_mode[k] = k as u8;
        }
        self.weights = self.log_weights;
        weights::normalise(&mut self.weights[..self.len]);
        (self.time, self.before_time) = (time, None);
    }

    fn start(&self) -> Start {
        self.start
    }

    fn lagged(&self) -> Option<Estimate> {
        if L == 0 {
            return None;
        }
        Some(Estimate::new(self.before_time?, self.mixed(&self.before)))
    }
}

/// The rung `mh3`.
pub const MH3: Declared = Declared {
    word: "mh3",
    about: "3 histories of motion",
    cost: 52,
    modes: Modes::three,
    histories: Some(3),
    start: |config, plot| {
        let filter = Histories::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Histories3(Box::new(filter)))
    },
};

/// The rung `mh9`.
pub const MH9: Declared = Declared {
    word: "mh9",
    about: "9 histories of motion",
    cost: 125,
    modes: Modes::three,
    histories: Some(9),
    start: |config, plot| {
        let filter = Histories::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Histories9(Box::new(filter)))
    },
};

/// The rung `mh27`.
pub const MH27: Declared = Declared {
    word: "mh27",
    about: "27 histories of motion",
    cost: 395,
    modes: Modes::four,
    histories: Some(27),
    start: |config, plot| {
        let filter = Histories::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Histories27(Box::new(filter)))
    },
};

/// The rung `mh9-lag1`.
pub const MH9_LAG1: Declared = Declared {
    word: "mh9-lag1",
    about: "9 histories, told a second later",
    cost: 172,
    modes: Modes::four,
    histories: Some(9),
    start: |config, plot| {
        let filter = Histories::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Histories9Lag(Box::new(filter)))
    },
};
