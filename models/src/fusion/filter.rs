//! The filter of one track: a rung of the ladder, or the one that respects slow errors.

use super::config::{Life, TrackingConfig};
use super::consider::{Consider, SlowError};
use crate::filter::{
    Estimate, Estimator, FilterConfig, Gaussian, Measurement, Nis, StateEstimator, Sym2,
    UpdateError, two_plot_start,
};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
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
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub(super) fn from_plot(config: &TrackingConfig, plot: &Plot) -> Result<Self, UpdateError> {
        if config.consider_slow_errors
            && !plot.kind.radar
            && config.sensor(plot.sensor, plot.kind).late_sigma_s > 0.0
        {
            let born = Consider::born(plot, &config.filter, slow_error(plot, config))?;
            return Ok(Self::Considering(Box::new(born)));
        }
        Ok(Self::Plain(Estimator::from_plot(&config.filter, plot)?))
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
    pub(super) fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        match self {
            Self::Plain(f) => f.motion(),
            Self::Considering(f) => {
                let now = f.estimate();
                (now.position_m(), now.velocity_mps())
            }
        }
    }

    /// The same if the state may be used.
    #[inline]
    pub(super) fn sound_motion(&self) -> Option<(Point2<f64>, Vector2<f64>)> {
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
    pub(super) fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        match self {
            Self::Plain(f) => f.position_at(time),
            Self::Considering(f) => {
                let at = f.predicted(time)?.state;
                Ok((at.position(), at.position_cov()))
            }
        }
    }

    /// Position (m) at a later time.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    #[inline]
    pub(super) fn place_at(&self, time: SimTime) -> Result<Point2<f64>, UpdateError> {
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
            Self::Considering(f) => f.predicted(time),
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
        Some(f.nis(plot, slow_error(plot, config)))
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
            && !plot.kind.radar
            && config.sensor(plot.sensor, plot.kind).errs_slowly()
        {
            *self =
                Self::Considering(Box::new(Consider::from_estimate(&f.estimate(), &config.filter)));
        }
        match self {
            Self::Plain(f) => f.update(plot).map(|_| ()),
            Self::Considering(f) => f.update(plot, slow_error(plot, config), false),
        }
    }

    /// # Errors
    /// As the filter's own update.
    pub(super) fn update_manoeuvre(
        &mut self,
        plot: &Plot,
        config: &TrackingConfig,
    ) -> Result<(), UpdateError> {
        match self {
            Self::Plain(f) => f.update_manoeuvre(plot).map(|_| ()),
            // Modes that foresee a jump take it; a single one is widened first.
            Self::Considering(f) if config.filter.modes_of_rung() > 1 => {
                f.update(plot, slow_error(plot, config), true)
            }
            Self::Considering(f) => {
                let t = plot.time.since_s(f.time());
                let mut state = f.predicted(plot.time)?.state;
                let innovation = state.innovation(&Measurement::of(plot)?)?;
                state.inflate(&innovation, t, crate::filter::MANOEUVRE_D2);
                let before = f.clone();
                f.replace(plot.time, &state);
                let done = f.update(plot, slow_error(plot, config), false);
                if done.is_err() {
                    *f = before;
                }
                done
            }
        }
    }

    /// # Errors
    /// As the filter's own update.
    pub(super) fn update_weighted(
        &mut self,
        plots: &[(Plot, f64)],
        config: &TrackingConfig,
    ) -> Result<(), UpdateError> {
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
                f.update_weighted(plots, slow_error(first, config))
            }
        }
    }

    /// Goes on as one Gaussian: what its modes or histories knew apart is mixed.
    pub(super) fn merge(&mut self) {
        if let Self::Plain(f) = self {
            let now = f.estimate();
            f.replace(now.time, &now.state);
        }
    }

    /// [`Self::update_weighted`] of one Gaussian.
    ///
    /// # Errors
    /// As the filter's own update.
    pub(super) fn update_merged(&mut self, plots: &[(Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let measured: Result<Vec<_>, _> =
            plots.iter().map(|(p, b)| Ok((crate::filter::Measurement::of(p)?, *b))).collect();
        let mut state = self.predicted(first.time)?.state;
        state.update_weighted(&measured?)?;
        self.replace(first.time, &state);
        Ok(())
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
                f.begin_again(last, &state);
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

/// How the error of a plot stays from one to the next.
pub(super) fn slow_error(plot: &Plot, config: &TrackingConfig) -> SlowError {
    if plot.kind.radar {
        let law = config.echo_law();
        return if law.residual_m > 0.0 && plot.across_m2.is_finite() {
            SlowError::Echo { sigma_m: [law.residual_m, law.beside_m], tau_s: law.residual_tau_s }
        } else {
            SlowError::White
        };
    }
    let model = config.sensor(plot.sensor, plot.kind);
    if model.errs_slowly() && plot.across_m2.is_finite() {
        SlowError::Receiver {
            share: model.slow_share,
            tau_s: model.slow_tau_s,
            late_s: model.late_sigma_s,
        }
    } else {
        SlowError::White
    }
}

/// When a gap between two plots is a long one, and how a track is carried over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gaps {
    /// From so long on it is, s.
    pub(super) after_s: f64,
    /// White acceleration then, m²/s³.
    pub(super) coast_q: f64,
}

impl Life {
    /// Those of a track whose plots come as often as this, s: what it expects is no gap.
    pub(super) fn gaps(&self, interval_s: f64) -> Gaps {
        let after_s = self.constant_velocity_after_s.max(GAP * interval_s);
        Gaps { after_s, coast_q: self.coast_q }
    }
}

/// A plot is lacking when so many of its intervals have passed (assumed).
const GAP: f64 = 1.5;

/// Position (m) with its covariance (m²) at `time`, as [`predict`].
///
/// # Errors
/// If `time` is before the filter's.
#[inline]
pub(super) fn position_at(
    filter: &TrackFilter,
    time: SimTime,
    gaps: Gaps,
) -> Result<(Point2<f64>, Sym2), UpdateError> {
    if time.since_s(filter.time()) <= gaps.after_s {
        return filter.position_at(time);
    }
    let at = predict(filter, time, gaps)?.state;
    Ok((at.position(), at.position_cov()))
}

/// Position (m) at `time`, as [`predict`].
///
/// # Errors
/// If `time` is before the filter's.
#[inline]
pub(super) fn place_at(
    filter: &TrackFilter,
    time: SimTime,
    gaps: Gaps,
) -> Result<Point2<f64>, UpdateError> {
    if time.since_s(filter.time()) <= gaps.after_s {
        return filter.place_at(time);
    }
    Ok(predict(filter, time, gaps)?.position_m())
}

/// The state at `time` without further plots: by the filter's own model for a while, then at constant
/// velocity.
///
/// # Errors
/// If `time` is before the filter's.
pub(super) fn predict(
    filter: &TrackFilter,
    time: SimTime,
    gaps: Gaps,
) -> Result<Estimate, UpdateError> {
    if time.since_s(filter.time()) <= gaps.after_s {
        return filter.predicted(time);
    }
    filter.predicted(filter.time().plus_s(gaps.after_s))?.coasted(time, gaps.coast_q)
}
