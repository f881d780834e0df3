//! The covariance gate: a chi-square quantile for the innovation's degrees of freedom.

use crate::frames::{Matrix2, Vector2};

/// A passed look at one innovation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Normalised innovation squared `νᵀ S⁻¹ ν`.
    pub d2: f64,
    /// `ln det S`.
    pub ln_det: f64,
}

/// `νᵀS⁻¹ν` and `ln det S` through the Cholesky factor of `S` (its upper triangle is read).
///
/// `None` unless `S` is positive definite and everything is finite: such a pair is no candidate, and
/// NaN goes no further.
#[must_use]
pub fn distance(innovation_m: Vector2<f64>, s_m2: Matrix2<f64>) -> Option<Distance> {
    let (s00, s01, s11) = (s_m2[(0, 0)], s_m2[(0, 1)], s_m2[(1, 1)]);
    if !(s00 > 0.0 && s00.is_finite()) {
        return None;
    }
    let l = s01 / s00;
    let rest = s11 - l * s01;
    if !(rest > 0.0 && rest.is_finite()) {
        return None;
    }
    let across = innovation_m.y - l * innovation_m.x;
    let d2 = innovation_m.x * innovation_m.x / s00 + across * across / rest;
    let ln_det = libm::log(s00) + libm::log(rest);
    (d2.is_finite() && ln_det.is_finite()).then_some(Distance { d2, ln_det })
}

/// Quantile `x` of the chi-square distribution: `P(χ²_dof ≤ x) = probability`.
///
/// Two degrees: `−2 ln(1 − p)`. Otherwise bisection on the survival function
/// `Q(a, x/2)`, `a = dof/2`, built up from `Q(½, y) = erfc √y` or `Q(1, y) = e^{−y}` by
/// `Q(a + 1, y) = Q(a, y) + y^a e^{−y}/Γ(a + 1)` (every term positive).
/// Source: Abramowitz and Stegun, 26.4 and 6.5.21. `probability` outside [0, 1) gives infinity
/// (no gate) or zero.
#[must_use]
pub fn chi_square_quantile(dof: u32, probability: f64) -> f64 {
    if probability.is_nan() || probability >= 1.0 || dof == 0 {
        return f64::INFINITY;
    }
    if probability <= 0.0 {
        return 0.0;
    }
    if dof == 2 {
        return -2.0 * libm::log1p(-probability);
    }
    let wanted = 1.0 - probability;
    let (mut low, mut high) = (0.0, f64::from(dof));
    while chi_square_survival(dof, high) > wanted {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if chi_square_survival(dof, middle) > wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// `P(χ²_dof > x)`, see [`chi_square_quantile`].
#[must_use]
pub fn chi_square_survival(dof: u32, x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    let y = 0.5 * x;
    let (mut a, mut q, mut term) = if dof % 2 == 1 {
        (0.5, libm::erfc(y.sqrt()), (y / std::f64::consts::PI).sqrt() * 2.0 * libm::exp(-y))
    } else {
        (1.0, libm::exp(-y), y * libm::exp(-y))
    };
    while a + 0.75 < 0.5 * f64::from(dof) {
        q += term;
        a += 1.0;
        term *= y / a;
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_the_tables() {
        // Abramowitz and Stegun, table 26.8.
        for (dof, p, value) in [
            (1, 0.99, 6.63490),
            (2, 0.95, 5.99147),
            (2, 0.99, 9.21034),
            (2, 0.999, 13.8155),
            (3, 0.95, 7.81473),
            (4, 0.99, 13.2767),
            (5, 0.99, 15.0863),
            (6, 0.99, 16.8119),
            (10, 0.5, 9.34182),
        ] {
            let found = chi_square_quantile(dof, p);
            assert!((found - value).abs() < 6e-5 * value, "{dof} {p}: {found} for {value}");
        }
    }

    #[test]
    fn hard_cases_of_the_gate() {
        let nu = Vector2::new(1.0, 2.0);
        for (name, s) in [
            ("zero", Matrix2::zeros()),
            ("negative", Matrix2::new(-1.0, 0.0, 0.0, 1.0)),
            ("indefinite", Matrix2::new(1.0, 2.0, 2.0, 1.0)),
            ("singular", Matrix2::new(1.0, 1.0, 1.0, 1.0)),
            ("NaN", Matrix2::new(f64::NAN, 0.0, 0.0, 1.0)),
            ("infinite", Matrix2::new(f64::INFINITY, 0.0, 0.0, 1.0)),
            ("NaN beside", Matrix2::new(1.0, f64::NAN, 0.0, 1.0)),
        ] {
            assert!(distance(nu, s).is_none(), "{name}");
        }
        assert!(distance(Vector2::new(f64::NAN, 0.0), Matrix2::identity()).is_none());
        assert_eq!(chi_square_quantile(2, 1.0), f64::INFINITY);
        assert_eq!(chi_square_quantile(2, 0.0), 0.0);
        assert_eq!(chi_square_quantile(3, f64::NAN), f64::INFINITY);
    }

    #[test]
    fn distance_is_the_inverse_form() {
        let s = Matrix2::new(4.0, 1.5, 1.5, 9.0);
        let nu = Vector2::new(-3.0, 2.0);
        let found = distance(nu, s).expect("positive definite");
        let inverse = s.try_inverse().expect("regular");
        assert!((found.d2 - (nu.transpose() * inverse * nu)[0]).abs() < 1e-12);
        assert!((found.ln_det - libm::log(s.determinant())).abs() < 1e-12);
    }
}
