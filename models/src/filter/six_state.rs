//! Six states with the plot's full covariance: constant acceleration, both axes joined.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::modes::Modes;
use super::motion::Motion;
use super::three_state::start_position;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, UpdateError, interval};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// One Gaussian under one motion model; symmetric by storage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixState {
    time: SimTime,
    state: Gaussian,
    motion: Motion,
    start: Start,
}

impl SixState {
    /// A filter with this state at `time`.
    #[must_use]
    pub fn new(time: SimTime, state: Gaussian, motion: Motion, start: Start) -> Self {
        Self { time, state, motion, start }
    }

    /// One plot: position measured, velocity and acceleration unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, motion: Motion, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        Ok(Self { time: plot.time, state, motion, start })
    }
}

impl StateEstimator for SixState {
    fn time(&self) -> SimTime {
        self.time
    }

    #[inline]
    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, self.state)
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        self.state.motion()
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        Ok(Estimate::new(time, self.state.predicted(&self.motion.step(t))))
    }

    #[inline]
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let t = interval(self.time, plot.time)?;
        let mut next = self.state.predicted(&self.motion.step(t));
        let nis = next.update(&Measurement::of(plot)?)?;
        (self.time, self.state) = (plot.time, next);
        Ok(nis)
    }

    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        super::taken(self, plot)
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        (self.time, self.state) = (time, *state);
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// The rung `ca6`.
pub const CA6: Declared = Declared {
    word: "ca6",
    about: "Kalman filter, both axes together",
    cost: 5,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        let motion = Motion::ConstantAcceleration { q: config.q };
        Ok(Estimator::SixState(Box::new(SixState::from_plot(plot, motion, config.start)?)))
    },
};
