//! Is a filter as good as it says? Normalised errors and their bounds.
//!
//! Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), sec. 5.4.

use super::Estimate;
use crate::frames::{Matrix2, Point2, Vector2};

/// Quantile of χ² with `k` degrees of freedom at the normal quantile `z` (Wilson and Hilferty, PNAS
/// 17, 1931): right to 1e-4 for k ≥ 100.
#[must_use]
pub fn chi_square_quantile(k: f64, z: f64) -> f64 {
    let c = 2.0 / (9.0 * k);
    let root = 1.0 - c + z * c.sqrt();
    k * root * root * root
}

/// Where the mean over `runs` runs of a normalised squared error with `components` components lies
/// in 95 % of the scans, if the filter's covariance is right.
#[must_use]
pub fn mean_bounds_95(runs: usize, components: usize) -> (f64, f64) {
    let (n, k) = (runs as f64, (runs * components) as f64);
    (chi_square_quantile(k, -1.959_963_985) / n, chi_square_quantile(k, 1.959_963_985) / n)
}

/// Largest innovation accepted: quantile of χ² with two degrees of freedom, `−2 ln(1 − p)`.
#[must_use]
pub fn gate_2d(probability: f64) -> f64 {
    -2.0 * libm::log1p(-probability)
}

/// Normalised position error squared, (p − p̂)ᵀ P_pp⁻¹ (p − p̂); infinite where P_pp is not positive definite.
#[must_use]
pub fn position_nees(estimate: &Estimate, truth_m: Point2<f64>) -> f64 {
    let s = estimate.state.position_cov();
    match super::gaussian::Factor::of(s) {
        Ok(factor) => factor.independent(truth_m - estimate.position_m()).1,
        Err(_) => f64::INFINITY,
    }
}

/// Squared `error_m` over a stated covariance (m²): `eᵀP⁻¹e`; infinite where it is not positive definite.
#[must_use]
pub fn nees_of(cov_m2: &Matrix2<f64>, error_m: Vector2<f64>) -> f64 {
    let xy = 0.5 * (cov_m2[(0, 1)] + cov_m2[(1, 0)]);
    let s = super::gaussian::Sym2 { xx: cov_m2[(0, 0)], xy, yy: cov_m2[(1, 1)] };
    super::gaussian::Factor::of(s).map_or(f64::INFINITY, |factor| factor.d2(error_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_tables() {
        for (runs, n, low, high) in [
            (50, 2, 1.484, 2.591),
            (200, 2, 1.732, 2.287),
            (1000, 2, 1.878, 2.126),
            (200, 4, 3.618, 4.401),
            (200, 6, 5.529, 6.490),
        ] {
            let (a, b) = mean_bounds_95(runs, n);
            assert!((a - low).abs() < 6e-4 && (b - high).abs() < 6e-4, "{runs} {n}: {a} {b}");
        }
    }

    #[test]
    fn gates_are_quantiles() {
        for (p, g) in [(0.95, 5.991), (0.99, 9.210), (0.999, 13.816), (0.9999, 18.421)] {
            assert!((gate_2d(p) - g).abs() < 1e-3);
        }
    }
}
