//! Interacting multiple models: one Gaussian per mode, mixed before every prediction.
//!
//! Source: Blom and Bar-Shalom, IEEE Trans. AC-33 (1988). The weights live in the log domain: a plot
//! fifty sigma off makes every likelihood zero in floating point, and a filter that floors them then
//! returns its prior where the right weights are 2e-32 to 1.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::mixtures::{PositionMoments, association_shares};
use super::modes::{MAX_MODES, Modes};
use super::three_state::start_position;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, UpdateError, interval, measurements, weights};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use std::array::from_fn;
use std::sync::Arc;

/// The filter with M modes.
#[derive(Clone, Debug)]
pub struct Imm<const M: usize> {
    time: SimTime,
    states: [Gaussian; M],
    weights: [f64; M],
    modes: Arc<Modes>,
    start: Start,
    /// ln of the density that the last plot was given.
    log_density: f64,
}

/// Least weight of a mode: it must be able to come back.
const LEAST_WEIGHT: f64 = 1e-30;

impl<const M: usize> Imm<M> {
    /// One plot: position measured, velocity and acceleration unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    ///
    /// # Panics
    /// If `modes` has not exactly M modes: the caller chooses both together.
    pub fn from_plot(plot: &Plot, modes: Arc<Modes>, start: Start) -> Result<Self, UpdateError> {
        assert_eq!(modes.count(), M, "modes and size of the filter belong together");
        let (z, r) = start_position(plot)?;
        let state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        let weights = prior(&modes);
        let log_density = f64::NAN;
        Ok(Self { time: plot.time, states: [state; M], weights, modes, start, log_density })
    }

    /// ln of the density (1/m², or 1/m of a plot along one direction) that the last plot was given before it was taken;
    /// NaN if there was none, or several of which one was meant.
    #[must_use]
    pub fn log_density(&self) -> f64 {
        self.log_density
    }

    /// Probability of each mode.
    #[must_use]
    pub fn weights(&self) -> [f64; M] {
        self.weights
    }

    /// Weights of the modes under `transition`, and the shares of the old ones in each.
    #[inline(always)]
    fn shares(&self, transition: &[[f64; MAX_MODES]; MAX_MODES]) -> ([f64; M], [[f64; M]; M]) {
        let mut c = [0.0; M];
        let mut shares = [[0.0; M]; M];
        for j in 0..M {
            let share: [f64; M] = from_fn(|i| transition[i][j] * self.weights[i]);
            c[j] = share.iter().sum();
            let scale = 1.0 / c[j];
            shares[j] = share.map(|w| w * scale);
        }
        (c, shares)
    }

    /// The states mixed for mode `j` and carried on for `t` seconds.
    #[inline(always)]
    fn mixed(&self, j: usize, share: &[f64; M], possible: bool, t: f64) -> Gaussian {
        let step = self.modes.step(j, t);
        if !possible {
            self.states[j].predicted(&step)
        } else if self.modes.is_steady(j) {
            Gaussian::mixture_steady(share, &self.states).predicted_steady(&step)
        } else {
            Gaussian::mixture(share, &self.states).predicted(&step)
        }
    }

    /// Weights of the modes after `t` seconds; their mixed, predicted states into `out`.
    #[inline]
    fn mix(
        &self,
        t: f64,
        transition: &[[f64; MAX_MODES]; MAX_MODES],
        out: &mut [Gaussian; M],
    ) -> [f64; M] {
        let (c, shares) = self.shares(transition);
        for (j, out) in out.iter_mut().enumerate() {
            *out = self.mixed(j, &shares[j], c[j] > 0.0, t);
        }
        c
    }

    fn take(
        &mut self,
        plot: &Plot,
        transition: &[[f64; MAX_MODES]; MAX_MODES],
    ) -> Result<Nis, UpdateError> {
        let t = interval(self.time, plot.time)?;
        let m = Measurement::of(plot)?;
        let (c, shares) = self.shares(transition);
        let mut moments = PositionMoments::about(self.states[0].position());
        let mut states = [Gaussian::default(); M];
        let (mut d2, mut scale) = ([0.0; M], [0.0; M]);
        for j in 0..M {
            let mut state = self.mixed(j, &shares[j], c[j] > 0.0, t);
            moments.add(c[j], state.position(), state.position_cov());
            let steady = self.modes.is_steady(j);
            let found = if steady { state.update_steady(&m) } else { state.update(&m) }?;
            states[j] = state;
            // c/√det S · exp(−d²/2) with the smallest d² taken out: the logs that would cancel are not taken.
            (d2[j], scale[j]) = (found.d2, c[j] / found.det.sqrt());
        }
        let nis = moments.nis(&m)?;
        let least = d2.iter().copied().fold(f64::INFINITY, f64::min);
        if !least.is_finite() {
            return Err(UpdateError::BadInnovation(least));
        }
        let weights = from_fn(|j| scale[j] * likelihood(d2[j] - least));
        let sum: f64 = weights.iter().sum();
        self.log_density =
            libm::log(sum) - 0.5 * (least + f64::from(nis.dof) * libm::log(std::f64::consts::TAU));
        self.weights = floored(weights).unwrap_or(c);
        (self.time, self.states) = (plot.time, states);
        Ok(nis)
    }
}

fn prior<const M: usize>(modes: &Modes) -> [f64; M] {
    let prior = modes.prior();
    from_fn(|j| prior[j])
}

/// exp(−d²/2); 1 without the call for the best mode.
#[inline]
fn likelihood(d2: f64) -> f64 {
    if d2 == 0.0 { 1.0 } else { libm::exp(-0.5 * d2) }
}

/// Weights of sum 1, each at least [`LEAST_WEIGHT`]; `None` where nothing is possible.
#[inline]
fn floored<const M: usize>(weights: [f64; M]) -> Option<[f64; M]> {
    let sum: f64 = weights.iter().sum();
    if !(sum > 0.0 && sum < f64::INFINITY) {
        return None;
    }
    let weights = weights.map(|w| (w / sum).max(LEAST_WEIGHT));
    let sum: f64 = weights.iter().sum();
    Some(weights.map(|w| w / sum))
}

impl<const M: usize> StateEstimator for Imm<M> {
    fn time(&self) -> SimTime {
        self.time
    }

    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, Gaussian::mixture(&self.weights, &self.states))
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        Gaussian::mean_motion(&self.weights, &self.states)
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        let mut states = [Gaussian::default(); M];
        let c = self.mix(t, &self.modes.transition(t), &mut states);
        Ok(Estimate::new(time, Gaussian::mixture(&c, &states)))
    }

    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let transition = self.modes.transition(interval(self.time, plot.time)?);
        self.take(plot, &transition)
    }

    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let mut transition = self.modes.transition(interval(self.time, plot.time)?);
        self.modes.expect_jump(&mut transition);
        self.take(plot, &transition)
    }

    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let t = interval(self.time, first.time)?;
        let mut states = [Gaussian::default(); M];
        let c = self.mix(t, &self.modes.transition(t), &mut states);
        let shares = association_shares(&c, &states, &measurements(plots)?)?;
        for (state, share) in states.iter_mut().zip(&shares) {
            state.update_weighted(&share.1)?;
        }
        let mut log_weights: [f64; M] = from_fn(|j| libm::log(c[j]) + shares[j].0);
        let sound = weights::normalise(&mut log_weights).is_some();
        self.weights = sound.then(|| floored(log_weights)).flatten().unwrap_or(c);
        (self.time, self.states) = (first.time, states);
        self.log_density = f64::NAN;
        Ok(())
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        (self.time, self.states) = (time, [*state; M]);
        self.weights = prior(&self.modes);
        self.log_density = f64::NAN;
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// The rung `imm3`.
pub const IMM3: Declared = Declared {
    word: "imm3",
    about: "three kinds of motion, weighted",
    cost: 27,
    modes: Modes::mixed,
    histories: Some(0),
    start: |config, plot| {
        let filter = Imm::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Imm3(Box::new(filter)))
    },
};
