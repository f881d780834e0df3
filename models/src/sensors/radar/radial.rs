//! Radius that holds a share of a horizontal error with unequal, independent north and east parts.
//!
//! For σ_N = σ_E and no mean it is σ √(−2 ln(1 − q)): 2.44775 σ for 95 %. Otherwise the root of the
//! integral of the bivariate normal density over the disc, reduced to one dimension with N = r sin t.
//! That substitution makes the integrand periodic and analytic, so the trapezoidal rule converges
//! geometrically; the plain integral over N has square-root edges and stalls at 1e-4 when one σ is
//! sixty times the other.
//!
//! Source: standard bivariate normal theory; the periodic trapezoidal rule as in Trefethen &
//! Weideman, SIAM Review 56 (2014).

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Probability that the error lies within `r_m`; deviations above 0, all in m.
#[must_use]
pub fn probability_within(
    sigma_north_m: f64,
    sigma_east_m: f64,
    mean_north_m: f64,
    mean_east_m: f64,
    r_m: f64,
) -> f64 {
    if r_m <= 0.0 {
        return 0.0;
    }
    // The wide one is integrated over, the narrow one is in closed form.
    let (wide, narrow, wide_mean, narrow_mean) = if sigma_north_m >= sigma_east_m {
        (sigma_north_m, sigma_east_m, mean_north_m, mean_east_m)
    } else {
        (sigma_east_m, sigma_north_m, mean_east_m, mean_north_m)
    };
    let density = |t: f64| {
        let (sin, cos) = libm::sincos(t);
        let z = (r_m * sin - wide_mean) / wide;
        let half_chord = r_m * cos;
        let above = libm::erf((half_chord - narrow_mean) / narrow * FRAC_1_SQRT_2);
        let below = libm::erf((-half_chord - narrow_mean) / narrow * FRAC_1_SQRT_2);
        libm::exp(-0.5 * z * z) * half_chord * 0.5 * (above - below)
    };
    let scale = 0.5 * TAU / (wide * (2.0 * PI).sqrt());
    let (mut points, mut sum) = (32_u32, 0.0);
    for i in 0..points {
        sum += density(TAU * f64::from(i) / f64::from(points));
    }
    let mut value = scale * sum / f64::from(points);
    while points < MAX_POINTS {
        for i in 0..points {
            sum += density(TAU * (f64::from(i) + 0.5) / f64::from(points));
        }
        points *= 2;
        let better = scale * sum / f64::from(points);
        let change = (better - value).abs();
        value = better;
        // Two coarse grids can both miss a narrow peak: never stop before 512 points.
        if points >= 512 && change < 1e-14 {
            break;
        }
    }
    value.clamp(0.0, 1.0)
}

/// Finest grid; an edge layer it does not resolve (σ ratio beyond 10⁴) weighs less than 1e-8.
const MAX_POINTS: u32 = 1 << 16;

/// Radius in m that holds the share `q` of the error, 0 ≤ `q` < 1; deviations above 0.
///
/// Relative error below 1e-9 for σ ratios up to 10⁴. `None` outside the domain.
#[must_use]
pub fn radial_quantile(
    sigma_north_m: f64,
    sigma_east_m: f64,
    mean_north_m: f64,
    mean_east_m: f64,
    q: f64,
) -> Option<f64> {
    let sound = sigma_north_m > 0.0
        && sigma_east_m > 0.0
        && (0.0..1.0).contains(&q)
        && [sigma_north_m, sigma_east_m, mean_north_m, mean_east_m].iter().all(|x| x.is_finite());
    if !sound {
        return None;
    }
    if q == 0.0 {
        return Some(0.0);
    }
    let excess =
        |r: f64| probability_within(sigma_north_m, sigma_east_m, mean_north_m, mean_east_m, r) - q;
    // The circular error of the larger deviation about the shifted centre holds no more.
    let reach = sigma_north_m.max(sigma_east_m) * (-2.0 * libm::log1p(-q)).sqrt();
    let (mut low, mut high) = (0.0, libm::hypot(mean_north_m, mean_east_m) + reach);
    let (mut at_low, mut at_high) = (-q, excess(high).max(f64::MIN_POSITIVE));
    // Illinois form of false position: keeps the bracket, converges faster than halving.
    let mut side = 0;
    for _ in 0..200 {
        if high - low <= 1e-13 * high {
            break;
        }
        let mut r = (low * at_high - high * at_low) / (at_high - at_low);
        if !(r > low && r < high) {
            r = 0.5 * (low + high);
        }
        let at = excess(r);
        if at == 0.0 {
            return Some(r);
        }
        if at < 0.0 {
            (low, at_low) = (r, at);
            if side == -1 {
                at_high *= 0.5;
            }
            side = -1;
        } else {
            (high, at_high) = (r, at);
            if side == 1 {
                at_low *= 0.5;
            }
            side = 1;
        }
        if at.abs() < 1e-15 {
            return Some(r);
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_errors_have_their_closed_form() {
        for (q, factor) in
            [(0.5, 1.177_410_022_5), (0.95, 2.447_746_830_7), (0.9999, 4.291_932_052_6)]
        {
            let r = radial_quantile(40.85, 40.85, 0.0, 0.0, q).expect("in the domain");
            assert!((r / 40.85 - factor).abs() < 1e-9, "{q}: {r}");
        }
    }

    #[test]
    fn hard_shapes_answer() {
        for (name, sn, se, mn, me, q, expected, tolerance) in [
            // One-dimensional limits: quantiles of the normal distribution.
            ("ratio 60", 1.0, 1.0 / 60.0, 0.0, 0.0, 0.95, 1.960_1, 2e-4),
            ("ratio 60, other way", 1.0 / 60.0, 1.0, 0.0, 0.0, 0.95, 1.960_1, 2e-4),
            ("ratio 1e6", 1.0, 1e-6, 0.0, 0.0, 0.95, 1.959_963_985, 1e-8),
            ("far from the centre", 1.0, 1.0, 1e4, 0.0, 0.5, 1e4, 1e-4),
            ("tiny probability", 1.0, 1.0, 0.0, 0.0, 1e-12, 1.414_2e-6, 1e-9),
            ("nearly certain", 1.0, 1.0, 0.0, 0.0, 1.0 - 1e-9, 6.438, 1e-3),
            ("no probability", 1.0, 1.0, 5.0, 5.0, 0.0, 0.0, 0.0),
        ] {
            let r = radial_quantile(sn, se, mn, me, q).expect(name);
            assert!((r - expected).abs() <= tolerance, "{name}: {r}");
        }
        for (name, sn, se, q) in [
            ("no width", 0.0, 1.0, 0.5),
            ("certain", 1.0, 1.0, 1.0),
            ("not a number", f64::NAN, 1.0, 0.5),
            ("endless", f64::INFINITY, 1.0, 0.5),
        ] {
            assert_eq!(radial_quantile(sn, se, 0.0, 0.0, q), None, "{name}");
        }
    }
}
