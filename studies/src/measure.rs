//! What every ladder needs: quantiles, timed blocks, sums of errors.

use crate::clock;
use models::frames::{Point2, Vector2};
use models::plot::{Plot, SensorId, SensorKind};
use models::time::SimTime;

/// Calls in a timed block.
pub(crate) const BLOCK: usize = 1000;

/// The value below which a share `p` lies (nearest rank); sorts the values.
pub(crate) fn quantile(values: &mut [f64], p: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    models::score::robust::quantile(values, p)
}

/// Median and 99 % quantile of some times, ns.
pub(crate) fn median_and_p99(times: &mut [f64]) -> (Option<f64>, Option<f64>) {
    (quantile(times, 0.5), quantile(times, 0.99))
}

/// Median and 99 % quantile of the time of one call over blocks of 1 000 calls, ns. The first two
/// blocks warm caches and branch predictors.
pub(crate) fn timed(blocks: usize, mut call: impl FnMut(usize)) -> (Option<f64>, Option<f64>) {
    let mut times = Vec::with_capacity(blocks);
    for block in 0..blocks + 2 {
        let begin = clock::thread_ns();
        for k in 0..BLOCK {
            call(block * BLOCK + k);
        }
        let ns = (clock::thread_ns() - begin) as f64 / BLOCK as f64;
        if block >= 2 {
            times.push(ns);
        }
    }
    median_and_p99(&mut times)
}

/// Distances, for their root mean square and their quantile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Errors(Vec<f64>);

impl Errors {
    pub(crate) fn add(&mut self, error: f64) {
        self.0.push(error);
    }
    pub(crate) fn rms(&self) -> Option<f64> {
        let sum: f64 = self.0.iter().map(|e| e * e).sum();
        (!self.0.is_empty()).then(|| (sum / self.0.len() as f64).sqrt())
    }
    pub(crate) fn p95(&mut self) -> Option<f64> {
        quantile(&mut self.0, 0.95)
    }
    pub(crate) fn most(&self) -> Option<f64> {
        self.0.iter().copied().reduce(f64::max)
    }
}

/// A plot of sensor 1 with equal variances in both directions.
pub(crate) fn round_plot(
    time: SimTime,
    sequence: u32,
    position_m: Point2<f64>,
    sigma_m: f64,
) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time,
        sequence,
        position_m,
        axis: Vector2::new(1.0, 0.0),
        along_m2: sigma_m * sigma_m,
        across_m2: sigma_m * sigma_m,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}
