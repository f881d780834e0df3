//! Constant errors of a radar's site, estimated from targets that report their own position.
//!
//! `δ = J b + v`, `J = (e_r, d e_c)`, `b` = (range, azimuth) bias; `b̂ = (Σ JᵀWJ + B₀⁻¹)⁻¹ Σ JᵀWδ`, `W⁻¹` the sum
//! of both covariances. The reporting target's own error is slow, so its pairs are not independent: about
//! one counts in 2τ/T.

use crate::frames::{Matrix2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// What is known of the errors of all radars.
#[derive(Clone, Debug, Default)]
pub(super) struct Registration {
    sites: Vec<(SensorId, Site)>,
}

#[derive(Clone, Copy, Debug)]
struct Site {
    information: Matrix2<f64>,
    vector: Vector2<f64>,
}

/// A target's own report, kept to compare radar plots with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    pub(super) time: SimTime,
    pub(super) position_m: Vector2<f64>,
    /// Variance per axis, m².
    pub(super) variance_m2: f64,
    /// Pairs that count as one: 2τ/T, at least 1.
    pub(super) repeats: f64,
}

/// Bias of a radar with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteBias {
    /// The radar.
    pub sensor: SensorId,
    /// Measured minus true range, m.
    pub range_m: f64,
    /// Its standard deviation, m.
    pub sigma_range_m: f64,
    /// Measured minus true azimuth, rad.
    pub azimuth_rad: f64,
    /// Its standard deviation, rad.
    pub sigma_azimuth_rad: f64,
}

/// A site is assumed to be set up this well, standard deviations (assumed).
const PRIOR_RANGE_M: f64 = 10.0;
const PRIOR_AZIMUTH_RAD: f64 = 5e-3;

/// A report may be this old when a radar plot is held against it, s.
const OLDEST_REFERENCE_S: f64 = 1.5;

impl Registration {
    /// Takes one pair: a radar plot and the target's own report, moved to the plot's time by `velocity_ms`.
    pub(super) fn learn(&mut self, plot: &Plot, reference: &Reference, velocity_ms: Vector2<f64>) {
        let Some(polar) = plot.polar else { return };
        let dt_s = plot.time.since_s(reference.time);
        if !(dt_s.abs() <= OLDEST_REFERENCE_S && polar.range_m > 1.0) {
            return;
        }
        // What was taken off already is part of the bias.
        let taken_off = self.correction_m(plot);
        let expected = reference.position_m + velocity_ms * dt_s;
        let delta = plot.position_m + taken_off - expected;
        let (radial, across) = (plot.axis, plot.across_axis());
        // Velocity over the gap is uncertain by about 1 m/s.
        let report = reference.variance_m2 + dt_s * dt_s;
        let weights = [
            1.0 / ((plot.along_m2 + report) * reference.repeats),
            1.0 / ((plot.across_m2 + report) * reference.repeats),
        ];
        let errors = [radial.dot(&delta), across.dot(&delta)];
        // A plot of another target, or a report gone wrong, teaches nothing.
        let limits = [PRIOR_RANGE_M, PRIOR_AZIMUTH_RAD * polar.range_m];
        let sigma = [plot.along_m2 + report, plot.across_m2 + report].map(f64::sqrt);
        if (0..2).any(|k| !(errors[k].abs() <= 3.0 * limits[k] + 4.0 * sigma[k])) {
            return;
        }
        let site = self.site(plot.sensor);
        site.information[(0, 0)] += weights[0];
        site.information[(1, 1)] += polar.range_m * polar.range_m * weights[1];
        site.vector[0] += weights[0] * errors[0];
        site.vector[1] += polar.range_m * weights[1] * errors[1];
    }

    /// Takes the known errors off a radar plot.
    pub(super) fn correct(&self, plot: &mut Plot) {
        plot.position_m -= self.correction_m(plot);
    }

    fn correction_m(&self, plot: &Plot) -> Vector2<f64> {
        let (Some(polar), Some(bias)) = (plot.polar, self.bias(plot.sensor)) else {
            return Vector2::zeros();
        };
        plot.axis * bias.range_m + plot.across_axis() * (polar.range_m * bias.azimuth_rad)
    }

    /// The estimate for one radar, if any pair was seen.
    pub(super) fn bias(&self, sensor: SensorId) -> Option<SiteBias> {
        let (_, site) = self.sites.iter().find(|(id, _)| *id == sensor)?;
        let i = &site.information;
        Some(SiteBias {
            sensor,
            range_m: site.vector[0] / i[(0, 0)],
            sigma_range_m: (1.0 / i[(0, 0)]).sqrt(),
            azimuth_rad: site.vector[1] / i[(1, 1)],
            sigma_azimuth_rad: (1.0 / i[(1, 1)]).sqrt(),
        })
    }

    /// All estimates.
    pub(super) fn biases(&self) -> Vec<SiteBias> {
        self.sites.iter().filter_map(|(id, _)| self.bias(*id)).collect()
    }

    fn site(&mut self, sensor: SensorId) -> &mut Site {
        let index = self.sites.iter().position(|(id, _)| *id == sensor).unwrap_or_else(|| {
            let prior = Matrix2::new(
                1.0 / (PRIOR_RANGE_M * PRIOR_RANGE_M),
                0.0,
                0.0,
                1.0 / (PRIOR_AZIMUTH_RAD * PRIOR_AZIMUTH_RAD),
            );
            self.sites.push((sensor, Site { information: prior, vector: Vector2::zeros() }));
            self.sites.len() - 1
        });
        &mut self.sites[index].1
    }
}
