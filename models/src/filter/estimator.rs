//! Whichever filter a track has: the shipped ones in place or behind a pointer, others as [`Own`].

use super::averaged::Averaged;
use super::events::Events;
use super::histories::Histories;
use super::imm::Imm;
use super::map::MapAided;
use super::own::Own;
use super::six_state::SixState;
use super::steady::SteadyGain;
use super::three_state::{ThreeState, TwoState};
use super::ud::{SixStateUd, ThreeStateUd};
use super::{Estimate, FilterConfig, Gaussian, Nis, Start, StateEstimator, Sym2, UpdateError};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// A filter chosen at run time. The small ones stand in place, the mode filters behind a pointer.
#[derive(Clone, Debug)]
pub enum Estimator {
    /// `abg`
    SteadyGain(SteadyGain),
    /// `ca3`
    ThreeState(ThreeState),
    /// `ca3` of a target that only rolls on
    TwoState(TwoState),
    /// `ca3-ud`
    ThreeStateUd(ThreeStateUd),
    /// `ca6`
    SixState(Box<SixState>),
    /// `ca6-ud`
    SixStateUd(Box<SixStateUd>),
    /// `imm3`
    Imm3(Box<Imm<3>>),
    /// `mh3`
    Histories3(Box<Histories<3, 0>>),
    /// `mh9`
    Histories9(Box<Histories<9, 0>>),
    /// `mh27`
    Histories27(Box<Histories<27, 0>>),
    /// `mh9-lag1`
    Histories9Lag(Box<Histories<9, 9>>),
    /// `mh9-map`
    Map9(Box<MapAided<9>>),
    /// `events9`
    Events9(Box<Events<9>>),
    /// `events27`
    Events27(Box<Events<27>>),
    /// `pair`
    Pair(Box<Averaged>),
    /// A rung that is none of these.
    Own(Own),
}

impl Estimator {
    /// A new track's filter from its first plot.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(config: &FilterConfig, plot: &Plot) -> Result<Self, UpdateError> {
        (config.rung.declared().start)(config, plot)
    }

    /// A filter of somebody's own, which stands behind a pointer.
    #[must_use]
    pub fn own(filter: impl StateEstimator + std::fmt::Debug + Send + Sync + 'static) -> Self {
        Self::Own(Own::new(filter))
    }
}

/// Runs one expression on whichever filter it is.
macro_rules! on_each {
    ($self:expr, $filter:ident => $body:expr) => {
        match $self {
            Estimator::SteadyGain($filter) => $body,
            Estimator::ThreeState($filter) => $body,
            Estimator::TwoState($filter) => $body,
            Estimator::ThreeStateUd($filter) => $body,
            Estimator::SixState($filter) => $body,
            Estimator::SixStateUd($filter) => $body,
            Estimator::Imm3($filter) => $body,
            Estimator::Histories3($filter) => $body,
            Estimator::Histories9($filter) => $body,
            Estimator::Histories27($filter) => $body,
            Estimator::Histories9Lag($filter) => $body,
            Estimator::Map9($filter) => $body,
            Estimator::Events9($filter) => $body,
            Estimator::Events27($filter) => $body,
            Estimator::Pair($filter) => $body,
            Estimator::Own($filter) => $body,
        }
    };
}

impl StateEstimator for Estimator {
    #[inline]
    fn time(&self) -> SimTime {
        on_each!(self, f => f.time())
    }
    #[inline]
    fn estimate(&self) -> Estimate {
        on_each!(self, f => f.estimate())
    }
    #[inline]
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        on_each!(self, f => f.predicted(time))
    }
    #[inline]
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        on_each!(self, f => f.position_at(time))
    }
    #[inline]
    fn place_at(&self, time: SimTime) -> Result<Point2<f64>, UpdateError> {
        on_each!(self, f => f.place_at(time))
    }
    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        on_each!(self, f => f.motion())
    }
    #[inline]
    fn sound_motion(&self) -> Option<(Point2<f64>, Vector2<f64>)> {
        on_each!(self, f => f.sound_motion())
    }
    #[inline]
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        on_each!(self, f => f.take(plot))
    }
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        on_each!(self, f => f.update_manoeuvre(plot))
    }
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        on_each!(self, f => f.update_weighted(plots))
    }
    fn restart(&mut self, first: &Plot, last: &Plot) -> Result<(), UpdateError> {
        on_each!(self, f => f.restart(first, last))
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        on_each!(self, f => f.replace(time, state));
    }
    fn start(&self) -> Start {
        on_each!(self, f => f.start())
    }
    fn lagged(&self) -> Option<Estimate> {
        on_each!(self, f => f.lagged())
    }
}
