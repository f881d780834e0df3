//! The filter of one track: a rung of the ladder, or the one that respects slow errors.

use super::config::TrackingConfig;
use super::consider::Consider;
use crate::filter::{
    Estimate, Estimator, FilterConfig, Gaussian, Nis, StateEstimator, Sym2, UpdateError,
    two_plot_start,
};
use crate::frames::Vector2;
use crate::plot::{Plot, SensorKind};
use crate::time::SimTime;

/// See the module's text.
#[derive(Clone, Debug)]
pub(super) enum TrackFilter {
    /// Every error is white.
    Plain(Estimator),
    /// A sensor with a slow error has updated the track.
    Considering(Box<Consider>),
}

/// Plots of one weighted update that are handed on without asking for memory.
const FEW: usize = 6;

impl TrackFilter {
    pub(super) fn from_plot(config: &FilterConfig, plot: &Plot) -> Result<Self, UpdateError> {
        Ok(Self::Plain(Estimator::from_plot(config, plot)?))
    }

    #[inline]
    pub(super) fn time(&self) -> SimTime {
        match self {
            Self::Plain(f) => f.time(),
            Self::Considering(f) => f.time(),
        }
    }

    #[inline]
    pub(super) fn estimate(&self) -> Estimate {
        match self {
            Self::Plain(f) => f.estimate(),
            Self::Considering(f) => f.estimate(),
        }
    }

    /// Position (m) and velocity (m/s) after the last plot.
    #[inline]
    pub(super) fn motion(&self) -> (Vector2<f64>, Vector2<f64>) {
        match self {
            Self::Plain(f) => f.motion(),
            Self::Considering(f) => {
                let now = f.estimate();
                (now.position_m(), now.velocity_ms())
            }
        }
    }

    /// The same if the state may be used.
    #[inline]
    pub(super) fn sound_motion(&self) -> Option<(Vector2<f64>, Vector2<f64>)> {
        match self {
            Self::Plain(f) => f.sound_motion(),
            Self::Considering(f) => {
                let state = f.estimate().state;
                state.is_sound().then(|| state.motion())
            }
        }
    }

    /// Position (m) and its covariance (m²) at a later time.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    #[inline]
    pub(super) fn position_at(&self, time: SimTime) -> Result<(Vector2<f64>, Sym2), UpdateError> {
        match self {
            Self::Plain(f) => f.position_at(time),
            Self::Considering(f) => {
                let at = f.predicted(time)?.estimate().state;
                Ok((at.position(), at.position_cov()))
            }
        }
    }

    /// Position (m) at a later time.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    #[inline]
    pub(super) fn place_at(&self, time: SimTime) -> Result<Vector2<f64>, UpdateError> {
        match self {
            Self::Plain(f) => f.place_at(time),
            Self::Considering(_) => Ok(self.position_at(time)?.0),
        }
    }

    /// # Errors
    /// If `time` is before the filter's.
    pub(super) fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        match self {
            Self::Plain(f) => f.predicted(time),
            Self::Considering(f) => Ok(f.predicted(time)?.estimate()),
        }
    }

    /// The normalised innovation of a plot against a filter that respects slow errors, if it is one and the plot
    /// measures both directions.
    ///
    /// # Errors
    /// If the plot is earlier than the filter or unsound.
    pub(super) fn considered(
        &self,
        plot: &Plot,
        config: &TrackingConfig,
    ) -> Option<Result<Nis, UpdateError>> {
        let Self::Considering(f) = self else { return None };
        if !plot.across_m2.is_finite() {
            return None;
        }
        let model = config.sensor(plot.sensor, plot.kind);
        Some(f.predicted(plot.time).and_then(|at| at.nis(plot, &model)))
    }

    /// # Errors
    /// As the filter's own update.
    #[inline]
    pub(super) fn update(
        &mut self,
        plot: &Plot,
        config: &TrackingConfig,
    ) -> Result<(), UpdateError> {
        if let (Self::Plain(f), true) = (&*self, config.consider_slow_errors)
            && plot.kind != SensorKind::Asde
            && config.sensor(plot.sensor, plot.kind).slow_share > 0.0
        {
            *self = Self::Considering(Box::new(Consider::from_estimate(
                &f.estimate(),
                config.filter.q,
            )));
        }
        match self {
            Self::Plain(f) => f.update(plot).map(|_| ()),
            Self::Considering(f) if plot.across_m2.is_finite() => {
                f.update(plot, &config.sensor(plot.sensor, plot.kind))
            }
            // One direction only: the plain form, then on from there.
            Self::Considering(f) => through_gaussian(f, plot, |g, m| g.update(m).map(|_| ())),
        }
    }

    /// # Errors
    /// As the filter's own update.
    pub(super) fn update_manoeuvre(&mut self, plot: &Plot) -> Result<(), UpdateError> {
        match self {
            Self::Plain(f) => f.update_manoeuvre(plot).map(|_| ()),
            Self::Considering(f) => {
                let t = plot.time.since_s(f.time());
                through_gaussian(f, plot, |g, m| {
                    let innovation = g.innovation(m)?;
                    g.inflate(&innovation, t, crate::filter::MANOEUVRE_D2);
                    g.update(m).map(|_| ())
                })
            }
        }
    }

    /// # Errors
    /// As the filter's own update.
    pub(super) fn update_weighted(&mut self, plots: &[(Plot, f64)]) -> Result<(), UpdateError> {
        match self {
            Self::Plain(f) => {
                let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
                if plots.len() <= FEW {
                    let mut few = [(first, 0.0); FEW];
                    for (slot, (plot, beta)) in few.iter_mut().zip(plots) {
                        *slot = (plot, *beta);
                    }
                    return f.update_weighted(&few[..plots.len()]);
                }
                let many: Vec<_> = plots.iter().map(|(plot, beta)| (plot, *beta)).collect();
                f.update_weighted(&many)
            }
            Self::Considering(f) => {
                let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
                let measured: Result<Vec<_>, _> = plots
                    .iter()
                    .map(|(p, b)| Ok((crate::filter::Measurement::of(p)?, *b)))
                    .collect();
                let measured = measured?;
                through_gaussian(f, first, |g, _| g.update_weighted(&measured))
            }
        }
    }

    /// # Errors
    /// If a plot is unsound or the second one is not later than the first.
    pub(super) fn restart(
        &mut self,
        first: &Plot,
        last: &Plot,
        config: &FilterConfig,
    ) -> Result<(), UpdateError> {
        match self {
            Self::Plain(f) => f.restart(first, last),
            Self::Considering(f) => {
                let state = two_plot_start(first, last, config.start, false)?;
                f.replace(last.time, &state);
                Ok(())
            }
        }
    }

    pub(super) fn replace(&mut self, time: SimTime, state: &Gaussian) {
        match self {
            Self::Plain(f) => f.replace(time, state),
            Self::Considering(f) => f.replace(time, state),
        }
    }
}

/// An update that knows nothing of slow errors; what tied the state to them is forgotten.
fn through_gaussian(
    filter: &mut Consider,
    plot: &Plot,
    update: impl FnOnce(&mut Gaussian, &crate::filter::Measurement) -> Result<(), UpdateError>,
) -> Result<(), UpdateError> {
    let measured = crate::filter::Measurement::of(plot)?;
    let mut state = filter.predicted(plot.time)?.estimate().state;
    update(&mut state, &measured)?;
    filter.replace(plot.time, &state);
    Ok(())
}
