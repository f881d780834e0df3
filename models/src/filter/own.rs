//! Filters that are not among the shipped ones: any [`StateEstimator`], behind a pointer.

use super::{Estimate, Gaussian, Nis, Start, StateEstimator, Sym2, UpdateError};
use crate::frames::Point2;
use crate::plot::Plot;
use crate::time::SimTime;
use std::fmt::Debug;

/// What [`StateEstimator`] offers, in a form that may stand behind a pointer.
trait Boxed: Debug + Send + Sync {
    fn cloned(&self) -> Box<dyn Boxed>;
    fn time(&self) -> SimTime;
    fn estimate(&self) -> Estimate;
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError>;
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError>;
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError>;
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError>;
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError>;
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError>;
    fn restart(&mut self, first: &Plot, last: &Plot) -> Result<(), UpdateError>;
    fn replace(&mut self, time: SimTime, state: &Gaussian);
    fn start(&self) -> Start;
    fn lagged(&self) -> Option<Estimate>;
}

impl<F: StateEstimator + Debug + Send + Sync + 'static> Boxed for F {
    fn cloned(&self) -> Box<dyn Boxed> {
        Box::new(self.clone())
    }
    fn time(&self) -> SimTime {
        StateEstimator::time(self)
    }
    fn estimate(&self) -> Estimate {
        StateEstimator::estimate(self)
    }
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        StateEstimator::predicted(self, time)
    }
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        StateEstimator::position_at(self, time)
    }
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        StateEstimator::update(self, plot)
    }
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        StateEstimator::take(self, plot)
    }
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        StateEstimator::update_manoeuvre(self, plot)
    }
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        StateEstimator::update_weighted(self, plots)
    }
    fn restart(&mut self, first: &Plot, last: &Plot) -> Result<(), UpdateError> {
        StateEstimator::restart(self, first, last)
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        StateEstimator::replace(self, time, state);
    }
    fn start(&self) -> Start {
        StateEstimator::start(self)
    }
    fn lagged(&self) -> Option<Estimate> {
        StateEstimator::lagged(self)
    }
}

/// A filter of somebody's own.
#[derive(Debug)]
pub struct Own(Box<dyn Boxed>);

impl Own {
    /// Any filter.
    pub fn new(filter: impl StateEstimator + Debug + Send + Sync + 'static) -> Self {
        Self(Box::new(filter))
    }
}

impl Clone for Own {
    fn clone(&self) -> Self {
        Self(self.0.cloned())
    }
}

impl StateEstimator for Own {
    fn time(&self) -> SimTime {
        self.0.time()
    }
    fn estimate(&self) -> Estimate {
        self.0.estimate()
    }
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        self.0.predicted(time)
    }
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        self.0.position_at(time)
    }
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.0.update(plot)
    }
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.0.take(plot)
    }
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.0.update_manoeuvre(plot)
    }
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        self.0.update_weighted(plots)
    }
    fn restart(&mut self, first: &Plot, last: &Plot) -> Result<(), UpdateError> {
        self.0.restart(first, last)
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.0.replace(time, state);
    }
    fn start(&self) -> Start {
        self.0.start()
    }
    fn lagged(&self) -> Option<Estimate> {
        self.0.lagged()
    }
}
