//! The covariance gate: a chi-square quantile for the innovation's degrees of freedom.

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
    use crate::filter::{Measurement, Sym2, nis_at};
    use crate::frames::Point2;
    use crate::frames::{Matrix2, Vector2};

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
    fn what_is_close_to_certain_keeps_its_digits() {
        // P(χ²₂ ≤ x) is x/2 near zero, and P(χ²₁ ≤ x) √(2x/π).
        for p in [1e-9, 1e-20, 1e-200] {
            let found = chi_square_quantile(2, p);
            assert!((found - 2.0 * p).abs() < 1e-8 * p, "{p}: {found}");
        }
        for dof in 1..12 {
            for x in [0.0, -0.0, -1e-300, -4.0, f64::NEG_INFINITY, f64::NAN] {
                assert_eq!(chi_square_survival(dof, x), 1.0, "{dof} {x}");
            }
            for p in [1e-6, 0.3, 0.5, 0.9, 0.999_999] {
                let x = chi_square_quantile(dof, p);
                let back = 1.0 - chi_square_survival(dof, x);
                assert!((back - p).abs() < 1e-12, "{dof} {p}: {back}");
            }
        }
        for p in [0.0, -0.5, f64::NEG_INFINITY] {
            assert_eq!(chi_square_quantile(3, p), 0.0);
        }
        for (dof, p) in [(0, 0.5), (3, 1.0), (3, 7.0)] {
            assert_eq!(chi_square_quantile(dof, p), f64::INFINITY);
        }
    }

    #[test]
    fn hard_cases_of_the_gate() {
        let look = |nu: Vector2<f64>, s: Sym2| {
            let r = Sym2 { xx: 0.0, xy: 0.0, yy: 0.0 };
            nis_at(Point2::origin(), s, &Measurement::Position { z: nu.into(), r })
        };
        let nu = Vector2::new(1.0, 2.0);
        for (name, xx, xy, yy) in [
            ("zero", 0.0, 0.0, 0.0),
            ("negative", -1.0, 0.0, 1.0),
            ("indefinite", 1.0, 2.0, 1.0),
            ("singular", 1.0, 1.0, 1.0),
            ("NaN", f64::NAN, 0.0, 0.0),
            ("infinite", f64::INFINITY, 0.0, 0.0),
            ("NaN beside", 1.0, f64::NAN, 1.0),
        ] {
            assert!(look(nu, Sym2 { xx, xy, yy }).is_err(), "{name}");
        }
        let unit = Sym2 { xx: 1.0, xy: 0.0, yy: 1.0 };
        let nowhere = look(Vector2::new(f64::NAN, 0.0), unit).expect("a sound covariance");
        assert!(!(nowhere.d2 <= f64::INFINITY), "no gate opens");
        assert_eq!(chi_square_quantile(2, 1.0), f64::INFINITY);
        assert_eq!(chi_square_quantile(2, 0.0), 0.0);
        assert_eq!(chi_square_quantile(3, f64::NAN), f64::INFINITY);
        // The factored form is the inverse one.
        let nu = Vector2::new(-3.0, 2.0);
        let found = look(nu, Sym2 { xx: 4.0, xy: 1.5, yy: 9.0 }).expect("positive definite");
        let s = Matrix2::new(4.0, 1.5, 1.5, 9.0);
        let inverse = s.try_inverse().expect("regular");
        assert!((found.d2 - (nu.transpose() * inverse * nu)[0]).abs() < 1e-12);
        assert!((found.ln_det() - libm::log(s.determinant())).abs() < 1e-12);
    }
}
