//! Updates of a filter: what one does, and what is kept of it so that it can be done again.

use super::config::TrackingConfig;
use super::filter::{Gaps, TrackFilter, predict};
use crate::filter::UpdateError;
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, SensorId, SensorKind};
use crate::time::SimTime;

/// What an update does to the filter.
#[derive(Clone, Copy, Debug)]
pub(super) enum Update<'a> {
    /// An ordinary plot.
    Plot(&'a Plot),
    /// A plot that only the kinematic gate accepted.
    Manoeuvre(&'a Plot),
    /// Begin again from these two.
    Restart(&'a Plot, &'a Plot),
    /// Several plots with the probability of each, moved to one time.
    Weighted(&'a [(Plot, f64)]),
}

/// An update as it is kept, so that it can be done again.
#[derive(Clone, Debug)]
pub(super) enum Record {
    /// An ordinary one or a manoeuvre.
    Plot(Taken),
    Restart(Box<[Taken; 2]>),
    Weighted(Box<[(Taken, f64)]>),
}

/// What a filter needs of a plot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taken {
    time: SimTime,
    position_m: Point2<f64>,
    axis: Vector2<f64>,
    along_m2: f64,
    across_m2: f64,
    sensor: SensorId,
    kind: SensorKind,
    /// Only the kinematic gate accepted it. Kept here, a record is one cache line.
    pub(super) manoeuvre: bool,
    /// The filter was merged to one Gaussian for it.
    merged: bool,
}

impl Taken {
    #[inline]
    pub(super) fn of(plot: &Plot) -> Self {
        let &Plot { time, position_m, axis, along_m2, across_m2, sensor, kind, .. } = plot;
        Self {
            time,
            position_m,
            axis,
            along_m2,
            across_m2,
            sensor,
            kind,
            manoeuvre: false,
            merged: false,
        }
    }

    pub(super) fn plot(&self) -> Plot {
        let Self { time, position_m, axis, along_m2, across_m2, sensor, kind, .. } = *self;
        Plot {
            sensor,
            kind,
            time,
            sequence: 0,
            position_m,
            axis,
            along_m2,
            across_m2,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    }
}

impl<'a> Update<'a> {
    /// The plot that names the update (of several, the likeliest).
    #[inline]
    pub(super) fn plot(&self) -> &'a Plot {
        match *self {
            Self::Plot(p) | Self::Manoeuvre(p) | Self::Restart(_, p) => p,
            Self::Weighted(plots) => likeliest(plots),
        }
    }

    pub(super) fn record(&self, merged: bool) -> Record {
        let of = |plot| Taken { merged, ..Taken::of(plot) };
        match *self {
            Self::Plot(p) => Record::Plot(of(p)),
            Self::Manoeuvre(p) => Record::Plot(Taken { manoeuvre: true, ..of(p) }),
            Self::Restart(a, b) => Record::Restart(Box::new([of(a), of(b)])),
            Self::Weighted(plots) => {
                Record::Weighted(plots.iter().map(|(plot, beta)| (of(plot), *beta)).collect())
            }
        }
    }
}

impl Record {
    /// Time of the plot that names it.
    pub(super) fn time(&self) -> SimTime {
        match self {
            Self::Plot(taken) => taken.time,
            Self::Restart(both) => both[1].time,
            Self::Weighted(plots) => {
                plots.first().map_or(SimTime(i64::MIN), |(taken, _)| taken.time)
            }
        }
    }
}

pub(super) fn whole(plots: &[(Taken, f64)]) -> Vec<(Plot, f64)> {
    plots.iter().map(|(taken, beta)| (taken.plot(), *beta)).collect()
}

pub(super) fn likeliest(plots: &[(Plot, f64)]) -> &Plot {
    let likeliest = plots.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    &likeliest.expect("a weighted update has a plot").0
}

/// What an update led to.
#[derive(Clone, Copy, Debug)]
pub(super) struct After {
    pub(super) position_m: Point2<f64>,
    pub(super) velocity_mps: Vector2<f64>,
    /// The filter began again.
    pub(super) reborn: bool,
}

/// Does an update. A filter that could not go on, or whose state would be none that may be used, begins
/// again from the plot.
///
/// # Errors
/// If the plot cannot be taken at all.
#[inline]
pub(super) fn step(
    filter: &mut TrackFilter,
    update: Update<'_>,
    merge: bool,
    (config, gaps): (&TrackingConfig, Gaps),
) -> Result<After, UpdateError> {
    match run(filter, update, merge, (config, gaps)) {
        Ok(()) => {
            if let Some((position_m, velocity_mps)) = filter.sound_motion() {
                return Ok(After { position_m, velocity_mps, reborn: false });
            }
        }
        Err(e @ (UpdateError::BackInTime(_) | UpdateError::UnsoundPlot)) => return Err(e),
        Err(UpdateError::BadInnovation(_) | UpdateError::BadCovariance) => {}
    }
    *filter = TrackFilter::from_plot(config, update.plot())?;
    let (position_m, velocity_mps) = filter.sound_motion().ok_or(UpdateError::BadCovariance)?;
    Ok(After { position_m, velocity_mps, reborn: true })
}

#[inline]
fn run(
    filter: &mut TrackFilter,
    update: Update<'_>,
    merge: bool,
    (config, gaps): (&TrackingConfig, Gaps),
) -> Result<(), UpdateError> {
    let time = update.plot().time;
    // After a long gap the state is carried on at constant velocity, not with an old acceleration.
    if time.since_s(filter.time()) > gaps.after_s {
        let carried = predict(filter, time, gaps)?;
        filter.replace(time, &carried.state);
    }
    if merge {
        if let Update::Weighted(plots) = update {
            return filter.update_merged(plots);
        }
        filter.merge();
    }
    match update {
        Update::Plot(plot) => filter.update(plot, config),
        Update::Manoeuvre(plot) => filter.update_manoeuvre(plot, config),
        Update::Restart(first, last) => filter.restart(first, last, &config.filter),
        Update::Weighted(plots) => filter.update_weighted(plots, config),
    }
}

/// The same for an update that was done before.
pub(super) fn again(
    filter: &mut TrackFilter,
    update: &Record,
    known: (&TrackingConfig, Gaps),
) -> Result<After, UpdateError> {
    match update {
        Record::Plot(taken) => {
            let plot = taken.plot();
            let update =
                if taken.manoeuvre { Update::Manoeuvre(&plot) } else { Update::Plot(&plot) };
            step(filter, update, taken.merged, known)
        }
        Record::Restart(both) => {
            let [first, last] = both.map(|taken| taken.plot());
            step(filter, Update::Restart(&first, &last), both[1].merged, known)
        }
        Record::Weighted(plots) => {
            let merged = plots.first().is_some_and(|(taken, _)| taken.merged);
            step(filter, Update::Weighted(&whole(plots)), merged, known)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;

    #[test]
    fn of_weighted_plots_the_likeliest_stands_for_all() {
        let plot = |x: f64| plot_at(0.0, x, 0.0, 1.0);
        for (betas, x) in [([0.2, 0.7, 0.1], 1.0), ([0.6, 0.3, 0.1], 0.0), ([0.1, 0.3, 0.5], 2.0)] {
            let plots: Vec<_> =
                betas.iter().enumerate().map(|(k, b)| (plot(k as f64), *b)).collect();
            assert_eq!(likeliest(&plots).position_m.x, x, "{betas:?}");
        }
    }
}
