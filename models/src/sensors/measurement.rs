//! Errors of a measured range and azimuth, and quantisation.

use crate::environment::SPEED_OF_LIGHT;
use crate::frames::Vector2;

/// Standard deviation of a range by the leading edge of a pulse, m.
///
/// `σ_R = (c/2)·√(τ/(2·B·E/N₀))`. Source: Skolnik, *Introduction to Radar Systems*, accuracy of range
/// by the threshold crossing of a pulse with rise time 1/B.
#[must_use]
pub fn range_sigma_m(pulse_s: f64, bandwidth_hz: f64, energy_ratio: f64) -> f64 {
    0.5 * SPEED_OF_LIGHT * delay_sigma_s(pulse_s, bandwidth_hz, energy_ratio)
}

/// Standard deviation of the delay itself, s.
#[must_use]
pub fn delay_sigma_s(pulse_s: f64, bandwidth_hz: f64, energy_ratio: f64) -> f64 {
    (pulse_s / (2.0 * bandwidth_hz * energy_ratio)).sqrt()
}

/// Standard deviation of an angle, in the unit of the beamwidth: `0.628·θ_B/√(2·E/N₀)`.
///
/// Source: Skolnik, *Introduction to Radar Systems*, angular accuracy of a scanning beam.
#[must_use]
pub fn angle_sigma(beamwidth: f64, energy_ratio: f64) -> f64 {
    0.628 * beamwidth / (2.0 * energy_ratio).sqrt()
}

/// Energy of a pulse over noise density from the signal-to-noise power ratio in the bandwidth: `(S/N)·B·τ`.
#[must_use]
pub fn energy_ratio(snr: f64, bandwidth_hz: f64, pulse_s: f64) -> f64 {
    snr * bandwidth_hz * pulse_s
}

/// The middle of the cell that holds `value`; `value` itself where there are no cells (`step` 0).
#[must_use]
pub fn quantised(value: f64, step: f64) -> f64 {
    if step == 0.0 { value } else { ((value / step).floor() + 0.5) * step }
}

/// Position of a polar measurement relative to the site and its variances along and across the line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartesianPlot {
    /// East and north of the site, m.
    pub offset_m: Vector2<f64>,
    /// Unit vector of the line of sight.
    pub axis: Vector2<f64>,
    /// Variance along it, m².
    pub along_m2: f64,
    /// Variance across it, m².
    pub across_m2: f64,
}

/// Converts ground range and azimuth. Where the arc is bent by more than a tenth of the range error
/// (`σ_θ²·r > 0.1·σ_r`) the unbiased form is used.
///
/// Source of the unbiased form and its covariance: Longbin et al. (1998), multiplicative debiasing,
/// conditional on the measurement; written with `expm1` so that small angles keep their digits.
#[must_use]
pub fn to_cartesian(
    ground_range_m: f64,
    azimuth_rad: f64,
    sigma_range_m: f64,
    sigma_azimuth_rad: f64,
) -> CartesianPlot {
    let (r, vr, va) =
        (ground_range_m, sigma_range_m * sigma_range_m, sigma_azimuth_rad * sigma_azimuth_rad);
    let (sin, cos) = libm::sincos(azimuth_rad);
    let axis = Vector2::new(sin, cos);
    if va * r <= 0.1 * sigma_range_m {
        return CartesianPlot { offset_m: axis * r, axis, along_m2: vr, across_m2: r * r * va };
    }
    let up = libm::expm1(va);
    let down2 = libm::expm1(-2.0 * va);
    // e^s − 3/2 + e^{−2s}/2 = expm1(s) + expm1(−2s)/2
    let along_m2 = r * r * (up + 0.5 * down2) + 0.5 * vr * (2.0 + down2);
    let across_m2 = -0.5 * (r * r + vr) * down2;
    CartesianPlot { offset_m: axis * (r * libm::exp(0.5 * va)), axis, along_m2, across_m2 }
}
