//! Direct and surface-reflected wave together: the fourth power of the propagation factor.

use std::f64::consts::{PI, TAU};

/// Mean two-way power factor over a uniformly distributed phase: `1 + 4q² + q⁴`.
///
/// `q` is the amplitude of the reflected relative to the direct ray.
#[must_use]
pub fn incoherent(q: f64) -> f64 {
    let q2 = q * q;
    1.0 + 4.0 * q2 + q2 * q2
}

/// Two-way power factor of a point: `|1 + q·e^{jφ}|⁴` as `[(1−q)² + 4q·cos²(φ/2)]²`, which reaches
/// zero in a null but never falls below it.
#[must_use]
pub fn coherent(q: f64, phase_rad: f64) -> f64 {
    let one_way = one_way(q, phase_rad);
    one_way * one_way
}

/// One-way power factor of a point, `|1 + q·e^{jφ}|²`, never negative.
#[must_use]
pub fn one_way(q: f64, phase_rad: f64) -> f64 {
    let cos = libm::cos(0.5 * phase_rad);
    let minus = 1.0 - q;
    minus * minus + 4.0 * q * cos * cos
}

/// One-way power factor for a real reflection coefficient and a path phase: `|1 + ρ·e^{−jφ}|²`.
///
/// For negative `ρ` (grazing incidence) the form `(1−|ρ|)² + 4|ρ|·sin²(φ/2)` keeps every digit at
/// small phases, where `1 + ρ·cos φ` would cancel.
#[must_use]
pub fn one_way_real(rho: f64, path_phase_rad: f64) -> f64 {
    let (sin, cos) = libm::sincos(0.5 * path_phase_rad);
    let size = rho.abs();
    let turn = if rho < 0.0 { sin } else { cos };
    let minus = 1.0 - size;
    minus * minus + 4.0 * size * turn * turn
}

/// Mean of [`coherent`] over a vertical extent that spreads the phase by ±`spread_rad`/2 … in closed
/// form, no sampling: to `coherent` for no spread and to `incoherent` for a large one.
///
/// `(1+q²)² + 2q² + 4q(1+q²)·cos φ·sinc(Δφ/2) + 2q²·cos 2φ·sinc(Δφ)`, `sinc x = sin x/x`.
#[must_use]
pub fn extended(q: f64, phase_rad: f64, spread_rad: f64) -> f64 {
    if spread_rad < 1e-4 {
        return coherent(q, phase_rad);
    }
    extended_cos(q, libm::cos(phase_rad), spread_rad)
}

/// [`extended`] from the cosine of the phase.
#[must_use]
pub fn extended_cos(q: f64, cos: f64, spread_rad: f64) -> f64 {
    let q2 = q * q;
    if spread_rad < 1e-4 {
        let minus = 1.0 - q;
        let one_way = minus * minus + 2.0 * q * (1.0 + cos);
        return one_way * one_way;
    }
    let one = 1.0 + q2;
    let cos_twice = 2.0 * cos * cos - 1.0;
    // sinc(2h) = sinc(h)·cos h
    let half = 0.5 * spread_rad;
    let (sin_half, cos_half) = libm::sincos(half);
    let sinc_half = sin_half / half;
    let sum = one * one
        + 2.0 * q2
        + 4.0 * q * one * cos * sinc_half
        + 2.0 * q2 * cos_twice * sinc_half * cos_half;
    sum.max(0.0)
}

/// `sin x/x`, by its series near zero.
#[must_use]
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

/// Phase of a path difference, radians in [0, 2π): whole wavelengths are taken out before the factor
/// 2π, so that long paths keep their phase.
#[must_use]
pub fn path_phase_rad(difference_m: f64, wavelength_m: f64) -> f64 {
    let waves = difference_m / wavelength_m;
    (waves - waves.floor()) * TAU
}

/// Phase spread over a vertical extent centred at the scatterer: `4π·h_a·V/(λ·d)`.
#[must_use]
pub fn phase_spread_rad(antenna_m: f64, extent_m: f64, wavelength_m: f64, d_m: f64) -> f64 {
    4.0 * PI * antenna_m * extent_m / (wavelength_m * d_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_null_is_zero_and_not_negative() {
        assert!(coherent(1.0, PI) < 1e-60);
        assert_eq!(coherent(0.0, 1.0), 1.0);
        for k in 0..1000 {
            let phase = PI + (f64::from(k) - 500.0) * 1e-9;
            for spread in [0.0, 1e-5, 1e-4, 1e-3] {
                assert!(extended(1.0, phase, spread) >= 0.0);
            }
        }
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_mean_over_the_spread(
            q in 0.0..1.2f64, phase in -10.0..10.0f64, spread in 0.01..40.0f64
        ) {
            let n = 4000;
            let mean = (0..n)
                .map(|i| coherent(q, phase + ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * spread))
                .sum::<f64>() / f64::from(n);
            prop_assert!((mean - extended(q, phase, spread)).abs() < 1e-3);
        }
    }
}
