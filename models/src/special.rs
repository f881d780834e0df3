//! Special functions that the standard library and `libm` lack, in forms that neither overflow nor cancel.

use nalgebra::Complex;
use std::f64::consts::PI;

/// Exponentially scaled modified Bessel function `exp(−x)·I₀(x)`, `x ≥ 0`.
///
/// Power series of positive terms up to 30, the asymptotic series beyond, so nothing overflows at
/// 714 as `exp(−x)·I₀(x)` does. Source: Abramowitz & Stegun 9.6.12 and 9.7.1. Relative error below 1e-13.
#[must_use]
pub fn i0e(x: f64) -> f64 {
    debug_assert!(x >= 0.0);
    let (mut term, mut sum) = (1.0, 1.0);
    if x <= 30.0 {
        let quarter = 0.25 * x * x;
        let mut k = 1.0;
        while term > 1e-17 * sum {
            term *= quarter / (k * k);
            sum += term;
            k += 1.0;
        }
        return sum * libm::exp(-x);
    }
    for k in 1..40 {
        let odd = f64::from(2 * k - 1);
        term *= odd * odd / (8.0 * f64::from(k) * x);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum / (2.0 * PI * x).sqrt()
}

/// Natural logarithm of the regularised lower incomplete gamma function `P(a, x)`, `a > 0`, `x ≥ 0`.
#[must_use]
pub fn ln_gamma_p(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if x < a + 1.0 { ln_p_series(a, x) } else { libm::log1p(-libm::exp(ln_q_fraction(a, x))) }
}

/// Natural logarithm of the regularised upper incomplete gamma function `Q(a, x)`, `a > 0`, `x ≥ 0`.
///
/// Each of the two is computed directly where it is the smaller one, so neither is ever a difference
/// of nearly equal numbers. Source: Abramowitz & Stegun 6.5.29 (series) and 6.5.31 (continued
/// fraction, evaluated by Lentz's method).
#[must_use]
pub fn ln_gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x < a + 1.0 { libm::log1p(-libm::exp(ln_p_series(a, x))) } else { ln_q_fraction(a, x) }
}

fn ln_front(a: f64, x: f64) -> f64 {
    a * libm::log(x) - x - libm::lgamma(a)
}

fn ln_p_series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
    for _ in 0..100_000 {
        k += 1.0;
        term *= x / k;
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    ln_front(a, x) + libm::log(sum)
}

fn ln_q_fraction(a: f64, x: f64) -> f64 {
    let tiny = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / tiny;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let an = -i * (i - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / if d.abs() < tiny { tiny } else { d };
        c = b + an / c;
        c = if c.abs() < tiny { tiny } else { c };
        let step = d * c;
        h *= step;
        if (step - 1.0).abs() < 1e-16 {
            break;
        }
    }
    ln_front(a, x) + libm::log(h)
}

/// Fresnel integrals `C(x) = ∫₀ˣ cos(πt²/2) dt` and `S(x) = ∫₀ˣ sin(πt²/2) dt`.
///
/// Power series up to 2.5, the continued fraction of the complementary error function beyond.
/// Source: Abramowitz & Stegun 7.3.11, 7.3.13 and 7.1.14. Absolute error below 1e-13.
#[must_use]
pub fn fresnel(x: f64) -> (f64, f64) {
    let ax = x.abs();
    let (c, s) = if ax < 2.5 { fresnel_series(ax) } else { fresnel_fraction(ax) };
    if x < 0.0 { (-c, -s) } else { (c, s) }
}

fn fresnel_series(x: f64) -> (f64, f64) {
    // Terms x·(iπx²/2)^n / (n!·(2n+1)): even n to C, odd n to S, signs alternating in pairs.
    let y = 0.5 * PI * x * x;
    let (mut c, mut s, mut power) = (0.0, 0.0, x);
    for n in 0..200u32 {
        let term = power / f64::from(2 * n + 1);
        match n % 4 {
            0 => c += term,
            1 => s += term,
            2 => c -= term,
            _ => s -= term,
        }
        if term.abs() < 1e-18 && f64::from(n) > y {
            break;
        }
        power *= y / f64::from(n + 1);
    }
    (c, s)
}

/// `∫ₓ^∞ exp(−iπt²/2) dt/√2` in modulus, for `x ≥ 0`: the amplitude behind a knife edge, without taking
/// the difference of `C` and ½.
#[must_use]
pub fn fresnel_tail(x: f64) -> f64 {
    if x < 2.5 {
        let (c, s) = fresnel_series(x);
        return 0.5 * libm::hypot(1.0 - c - s, c - s);
    }
    let h = fresnel_tail_fraction(x);
    0.5 * libm::hypot(h.re, h.im)
}

fn fresnel_fraction(x: f64) -> (f64, f64) {
    let one = Complex::new(1.0, 0.0);
    // Quarter turns are taken out before the sine, so that large arguments keep their phase.
    let reduced = libm::fmod(0.5 * x * x, 2.0) * PI;
    let (sin, cos) = libm::sincos(reduced);
    let w = Complex::new(0.5, 0.5) * (one - Complex::new(cos, sin) * fresnel_tail_fraction(x));
    (w.re, w.im)
}

/// Continued fraction of the complementary error function on the diagonal, by Lentz's method.
fn fresnel_tail_fraction(x: f64) -> Complex<f64> {
    let one = Complex::new(1.0, 0.0);
    let mut b = Complex::new(1.0, -PI * x * x);
    let mut c = Complex::new(1e300, 0.0);
    let mut d = one / b;
    let mut h = d;
    let mut n = -1.0;
    for _ in 0..100_000 {
        n += 2.0;
        let a = -n * (n + 1.0);
        b += Complex::new(4.0, 0.0);
        d = one / (d * a + b);
        c = b + one / c * a;
        let step = c * d;
        h *= step;
        if (step.re - 1.0).abs() + step.im.abs() < 1e-16 {
            break;
        }
    }
    h * Complex::new(x, -x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_branches_of_each_function_meet() {
        let (below, above) = (i0e(30.0 - 1e-9), i0e(30.0 + 1e-9));
        assert!((below / above - 1.0).abs() < 1e-9, "{below:e} {above:e}");
        let (a, b) = (fresnel_series(2.5), fresnel_fraction(2.5));
        assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12, "{a:?} {b:?}");
        for a in [1.0, 14.0, 500.0] {
            let x = a + 1.0;
            let (p, q) = (libm::exp(ln_gamma_p(a, x)), libm::exp(ln_gamma_q(a, x)));
            assert!((p + q - 1.0).abs() < 1e-12, "{a}: {p} + {q}");
        }
    }

    #[test]
    fn far_arguments_stay_finite() {
        assert!((i0e(0.0) - 1.0).abs() < 1e-16);
        assert!((i0e(40_600.0) * (2.0 * PI * 40_600.0).sqrt() - 1.0).abs() < 1e-5);
        let (c, s) = fresnel(1e6);
        assert!((c - 0.5).abs() < 1e-5 && (s - 0.5).abs() < 1e-5);
        assert!(
            ln_gamma_q(1.0, 5000.0) == -5000.0 || (ln_gamma_q(1.0, 5000.0) + 5000.0).abs() < 1e-9
        );
    }
}
