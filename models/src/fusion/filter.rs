//! The filter of one track: a rung of the ladder, or the one that respects slow errors.

use super::config::{SensorModel, TrackingConfig};
use super::consider::Consider;
use crate::filter::{
    Estimate, Estimator, FilterConfig, Gaussian, StateEstimator, UpdateError, two_plot_start,
};
use crate::plot::Plot;
use crate::time::SimTime;

/// See the module's text.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly every track is plain and lives in one arena")]
pub(super) enum TrackFilter {
    /// Every error is white.
    Plain(Estimator),
    /// A sensor with a slow error has updated the track.
    Considering(Box<Consider>),
}

impl TrackFilter {
    pub(super) fn from_plot(config: &FilterConfig, plot: &Plot) -> Result<Self, UpdateError> {
        Ok(Self::Plain(Estimator::from_plot(config, plot)?))
    }

    pub(super) fn time(&self) -> SimTime {
        match self {
            Self::Plain(f) => f.time(),
            Self::Considering(f) => f.time(),
        }
    }

    pub(super) fn estimate(&self) -> Estimate {
        match self {
            Self::Plain(f) => f.estimate(),
            Self::Considering(f) => f.estimate(),
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

    /// `d²`, ln det S and degrees of freedom of a plot whose time is within the filter's own model.
    ///
    /// # Errors
    /// If the plot is earlier than the filter or unsound.
    pub(super) fn innovation(
        &self,
        plot: &Plot,
        model: &SensorModel,
    ) -> Result<(f64, f64, u8), UpdateError> {
        match self {
            Self::Considering(f) if plot.across_m2.is_finite() => {
                let (d2, ln_det) = f.predicted(plot.time)?.innovation(plot, model)?;
                Ok((d2, ln_det, 2))
            }
            _ => {
                let found = self.predicted(plot.time)?.innovation(plot)?;
                Ok((found.d2, found.ln_det, found.dof))
            }
        }
    }

    /// # Errors
    /// As the filter's own update.
    pub(super) fn update(
        &mut self,
        plot: &Plot,
        model: &SensorModel,
        config: &TrackingConfig,
    ) -> Result<(), UpdateError> {
        let slow = config.consider_slow_errors && model.slow_share > 0.0;
        if let (Self::Plain(f), true) = (&*self, slow) {
            *self = Self::Considering(Box::new(Consider::from_estimate(
                &f.estimate(),
                config.filter.q,
            )));
        }
        match self {
            Self::Plain(f) => f.update(plot).map(|_| ()),
            Self::Considering(f) if plot.across_m2.is_finite() => f.update(plot, model),
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
    pub(super) fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        match self {
            Self::Plain(f) => f.update_weighted(plots),
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
