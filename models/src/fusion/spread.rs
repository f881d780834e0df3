//! How far the echoes of one target wander from look to look, against what its plots state.
//!
//! A plot of a radar states one glint for every target; a car's is a fifth of it, a heavy jet's one and a half times. The
//! track sees it: of three plots of equal distance `|z₁ − 2z₂ + z₃|²/6` is the variance of one of them, whatever the
//! velocity. Along and across the line of sight are held apart. An acceleration a adds (aT²)²/6, 0.7 m² at 2 m/s².

use crate::frames::Vector2;
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// Plots that what is stated counts for.
const PRIOR: f64 = 12.0;
/// Share that is kept of what was seen, per triple: the aspect changes.
const KEPT: f64 = 0.98;
/// Limits of the ratio (assumed): thermal errors are stated rightly, and a manoeuvre is not glint.
const LEAST: f64 = 0.12;
const MOST: f64 = 3.0;

/// A plot's time and place.
type At = (SimTime, Vector2<f64>);

/// Ratio of the variances seen to the variances stated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    last: Option<(SensorId, [At; 2])>,
    one: Option<(SensorId, At)>,
    seen: [f64; 2],
    triples: f64,
    stated: [f64; 2],
}

impl Spread {
    /// Factors on the variances that a plot states along and across.
    pub(super) fn factors(&self, plot: &Plot) -> [f64; 2] {
        let own = [plot.along_m2, plot.across_m2];
        [0, 1].map(|k| {
            let prior = PRIOR * own[k];
            let found = (self.seen[k] + prior) / (self.stated[k] + prior);
            if found.is_finite() { found.clamp(LEAST, MOST) } else { 1.0 }
        })
    }

    /// Variance of one plot as it was seen, the mean of both directions, and how many triples say so; none yet.
    pub(super) fn variance_m2(&self) -> Option<(f64, f64)> {
        let mean = 0.5 * (self.seen[0] + self.seen[1]) / self.triples;
        (self.triples > 0.0).then_some((mean, self.triples))
    }

    /// Takes a plot that the track has taken, with the variances that it states; `interval_s` of its sensor.
    pub(super) fn learn(&mut self, plot: &Plot, interval_s: f64) {
        let here = (plot.time, plot.position_m);
        let near = |a: SimTime, b: SimTime| {
            let t = b.since_s(a);
            t > 0.5 * interval_s && t < 1.5 * interval_s
        };
        if let Some((sensor, [first, second])) = self.last
            && sensor == plot.sensor
            && near(second.0, here.0)
        {
            let bend = first.1 - second.1 * 2.0 + here.1;
            let parts = [bend.dot(&plot.axis), bend.dot(&plot.across_axis())];
            let stated = [plot.along_m2, plot.across_m2];
            self.triples = KEPT * self.triples + 1.0;
            for k in 0..2 {
                // One wild plot is no property of the target: six deviations of a triple.
                let limit = 36.0 * MOST * stated[k];
                self.seen[k] = KEPT * self.seen[k] + (parts[k] * parts[k] / 6.0).min(limit);
                self.stated[k] = KEPT * self.stated[k] + stated[k];
            }
        }
        self.last = match self.one {
            Some((sensor, before)) if sensor == plot.sensor && near(before.0, here.0) => {
                Some((sensor, [before, here]))
            }
            _ => None,
        };
        self.one = Some((plot.sensor, here));
    }
}
