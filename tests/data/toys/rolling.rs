//! Constant velocity with the acceleration as white noise: for targets that only roll on.

use super::modes::Modes;
use super::three_state::TwoState;
use super::{Declared, Estimate, Estimator, Gaussian, Nis, Start, StateEstimator, UpdateError};
use crate::plot::Plot;
use crate::time::SimTime;

/// Spectral density of the acceleration, m²/s³ (assumed).
const DENSITY: f64 = 0.5;

/// The rung `rolling`.
pub const ROLLING: Declared = Declared {
    word: "rolling",
    about: "constant velocity, one axis at a time",
    cost: 2,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        Ok(Estimator::own(Rolling(TwoState::from_plot(plot, DENSITY, config.start)?)))
    },
};

/// One target's filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling(TwoState);

impl StateEstimator for Rolling {
    fn time(&self) -> SimTime {
        self.0.time()
    }
    fn estimate(&self) -> Estimate {
        self.0.estimate()
    }
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        self.0.predicted(time)
    }
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.0.update(plot)
    }
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.0.take(plot)
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.0.replace(time, state);
    }
    fn start(&self) -> Start {
        self.0.start()
    }
}
