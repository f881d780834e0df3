//! Errors correlated in time: Gauss-Markov processes of first and second order.
//!
//! Both are discretised exactly, so what comes out does not depend on the step: a state advanced by
//! 0.1 s ten times has the distribution of one advanced by 1 s once.
//!
//! Source: Gelb (ed.), *Applied Optimal Estimation* (1974), sec. 2.5 and 4.5; the incomplete-gamma
//! form of the second-order covariance follows by integrating Φ(s) G Gᵀ Φ(s)ᵀ.

use rand::rngs::ChaCha8Rng;

use crate::draw::normal_pair;

/// One exact step of the first-order process with autocorrelation σ² e^(−|t|/τ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gm1Step {
    /// Factor on the old state, e^(−Δ/τ).
    pub phi: f64,
    /// Variance of what is added, in the square of σ's unit: −σ² expm1(−2Δ/τ).
    pub q: f64,
}

impl Gm1Step {
    /// The step over `dt_s` ≥ 0 for deviation `sigma` and correlation time `tau_s` > 0.
    ///
    /// `expm1` keeps all digits of `q` at tiny steps, where 1 − e^(−2Δ/τ) has lost them.
    #[must_use]
    pub fn new(sigma: f64, tau_s: f64, dt_s: f64) -> Self {
        debug_assert!(tau_s > 0.0 && dt_s >= 0.0);
        let x = dt_s / tau_s;
        Self { phi: libm::exp(-x), q: -sigma * sigma * libm::expm1(-2.0 * x) }
    }

    /// The next state, from one standard normal number.
    #[must_use]
    pub fn advance(&self, state: f64, normal: f64) -> f64 {
        self.phi * state + self.q.sqrt() * normal
    }
}

/// Variance that remains after averaging the first-order process over `span_s`, as a share of σ²:
/// (2/x)(1 − (1 − e^(−x))/x) with x = T/τ; 1 at x = 0.
///
/// Below x = 0.01 the two differences cancel and the series 1 − x/3 + x²/12 − x³/60 + x⁴/360 stands
/// for it (relative error below 1e-13).
#[must_use]
pub fn averaged_variance_ratio(tau_s: f64, span_s: f64) -> f64 {
    let x = span_s / tau_s;
    if x < 0.01 {
        return 1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0)));
    }
    2.0 / x * (1.0 + libm::expm1(-x) / x)
}

/// One exact step of the critically damped second-order process with autocorrelation
/// σ² (1 + β|t|) e^(−β|t|), β = 1/τ; the state is the value and its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gm2Step {
    /// Transition of (value, rate), row by row.
    pub phi: [[f64; 2]; 2],
    /// Variance of what is added to the value.
    pub q11: f64,
    /// Covariance of what is added to value and rate.
    pub q12: f64,
    /// Variance of what is added to the rate.
    pub q22: f64,
}

impl Gm2Step {
    /// The step over `dt_s` ≥ 0 for deviation `sigma` and time constant `tau_s` > 0.
    ///
    /// `Q₁₁ = σ² P(3, 2βΔ)` with the regularised incomplete gamma function, of order
    /// (4/3) σ² (βΔ)³: the textbook form 1 − e^(−y)(1 + y + y²/2) is 0 there long before it should be.
    #[must_use]
    pub fn new(sigma: f64, tau_s: f64, dt_s: f64) -> Self {
        debug_assert!(tau_s > 0.0 && dt_s >= 0.0);
        let beta = 1.0 / tau_s;
        let x = beta * dt_s;
        let y = 2.0 * x;
        let variance = sigma * sigma;
        let decay = libm::exp(-x);
        // e^(−x) is 0 above 745; nothing of the old state is left, and ∞ · 0 must not arise.
        let of = |factor: f64| if decay == 0.0 { 0.0 } else { decay * factor };
        let rest = of(x);
        let q12 = 2.0 * variance * beta * rest * rest;
        Self {
            phi: [[of(1.0 + x), of(dt_s)], [of(-beta * x), of(1.0 - x)]],
            q11: variance * gamma_p3(y),
            q12,
            q22: variance * beta * beta * rate_share(y),
        }
    }

    /// The next (value, rate), from two independent standard normal numbers.
    #[must_use]
    pub fn advance(&self, [value, rate]: [f64; 2], (n1, n2): (f64, f64)) -> [f64; 2] {
        // Cholesky factor with the rate first: q22 is of order Δ and carries q12 and q11 at small steps.
        let l22 = self.q22.sqrt();
        let l12 = if l22 > 0.0 { self.q12 / l22 } else { 0.0 };
        let l11 = (self.q11 - l12 * l12).max(0.0).sqrt();
        [
            self.phi[0][0] * value + self.phi[0][1] * rate + l12 * n1 + l11 * n2,
            self.phi[1][0] * value + self.phi[1][1] * rate + l22 * n1,
        ]
    }
}

/// P(3, y) = 1 − e^(−y)(1 + y + y²/2), the share of an Erlang-3 distribution below `y`.
fn gamma_p3(y: f64) -> f64 {
    if y < 1.0 {
        // e^(−y) y³ Σ y^k · 6/(k+3)! / 6: every term is positive, so nothing cancels.
        return libm::exp(-y) * y * y * y * positive_tail(y, 3.0) / 6.0;
    }
    1.0 - libm::exp(-y) * (1.0 + y + 0.5 * y * y)
}

/// 1 − e^(−y)(1 − y + y²/2), which starts as 2y.
fn rate_share(y: f64) -> f64 {
    if y < 1.0 {
        // P(3, y) + 2 y e^(−y): again only positive terms.
        return gamma_p3(y) + 2.0 * y * libm::exp(-y);
    }
    1.0 - libm::exp(-y) * (1.0 - y + 0.5 * y * y)
}

/// Σ yᵏ / ((n+1)(n+2)…(n+k)) for 0 ≤ y < 1, to the last bit.
fn positive_tail(y: f64, n: f64) -> f64 {
    let (mut sum, mut term, mut k) = (1.0, 1.0, n + 1.0);
    while term > 1e-18 * sum {
        term *= y / k;
        sum += term;
        k += 1.0;
    }
    sum
}

/// State of a two-dimensional first-order error: east and north with their own deviations and one τ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gm1Pair {
    /// East, in units of its own σ.
    east: f64,
    /// North, in units of its own σ.
    north: f64,
}

impl Gm1Pair {
    /// A state drawn from the stationary distribution.
    #[must_use]
    pub fn stationary(rng: &mut ChaCha8Rng) -> Self {
        let (east, north) = normal_pair(rng);
        Self { east, north }
    }

    /// Advances both components by `dt_s` with correlation time `tau_s`.
    pub fn advance(&mut self, tau_s: f64, dt_s: f64, rng: &mut ChaCha8Rng) {
        let step = Gm1Step::new(1.0, tau_s, dt_s);
        let (a, b) = normal_pair(rng);
        self.east = step.advance(self.east, a);
        self.north = step.advance(self.north, b);
    }

    /// East and north, for deviations `sigma_east` and `sigma_north`.
    #[must_use]
    pub fn error(&self, sigma_east: f64, sigma_north: f64) -> [f64; 2] {
        [sigma_east * self.east, sigma_north * self.north]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose};
    use proptest::prelude::*;

    #[test]
    fn hard_steps_keep_their_digits() {
        // name, βΔ, relative tolerance on Q11 against the leading terms of its series
        for (name, x, tolerance) in [
            ("textbook form 0.6 % off", 2.8e-5, 1e-12),
            ("textbook form gives 0", 3e-9, 1e-12),
            ("picosecond in a day", 1e-17, 1e-12),
            ("no step", 0.0, 1e-12),
        ] {
            let step = Gm2Step::new(2.0, 1.0, x);
            let y: f64 = 2.0 * x;
            let series =
                4.0 * y.powi(3) / 6.0 * (1.0 - 3.0 * y / 4.0 + 0.3 * y * y - y.powi(3) / 12.0);
            assert!((step.q11 - series).abs() <= tolerance * series, "{name}: {step:?}");
            assert!(step.q11 * step.q22 >= step.q12 * step.q12, "{name}: not positive definite");
        }
        for (name, tau_s, dt_s) in
            [("huge step", 10.0, 1e9), ("beyond underflow", 1e-9, 1e9), ("just before", 1.0, 744.0)]
        {
            let one = Gm1Step::new(3.0, tau_s, dt_s);
            let two = Gm2Step::new(3.0, tau_s, dt_s);
            assert!(one.phi < 1e-300 && one.q == 9.0, "{name}: {one:?}");
            assert!((two.q11 - 9.0).abs() < 1e-12 && two.phi[0][0].abs() < 1e-300, "{name}");
            let next = two.advance([1e6, 1e6], (0.5, -0.5));
            assert!(next.iter().all(|x| x.is_finite()), "{name}: {next:?}");
        }
        let tiny = Gm1Step::new(1.0, 1.0, 1e-10);
        assert!((tiny.q / (2e-10 * (1.0 - 1e-10)) - 1.0).abs() < 1e-15, "lost digits: {tiny:?}");
        assert_eq!(averaged_variance_ratio(300.0, 0.0), 1.0);
    }

    #[test]
    fn averaging_a_minute_hardly_helps_against_five_minutes_of_correlation() {
        assert!((averaged_variance_ratio(300.0, 60.0) - 0.9365).abs() < 5e-4);
        let (below, above) = (0.009_999_999, 0.010_000_001);
        let jump = averaged_variance_ratio(1.0, below) - averaged_variance_ratio(1.0, above);
        assert!(jump.abs() < 1e-9, "series and closed form meet: {jump:e}");
    }

    proptest! {
        /// Two steps make the same process as one of their sum: Φ₂Φ₁ and Φ₂Q₁Φ₂ᵀ + Q₂.
        #[test]
        fn steps_compose(tau in 0.1_f64..1e4, a in 0.0_f64..1e3, b in 0.0_f64..1e3) {
            let whole = Gm1Step::new(2.0, tau, a + b);
            let (first, second) = (Gm1Step::new(2.0, tau, a), Gm1Step::new(2.0, tau, b));
            prop_assert!((first.phi * second.phi - whole.phi).abs() < 1e-12);
            let q = second.phi * second.phi * first.q + second.q;
            prop_assert!((q - whole.q).abs() < 1e-12 * (1.0 + whole.q));

            let whole = Gm2Step::new(2.0, tau, a + b);
            let (f, s) = (Gm2Step::new(2.0, tau, a), Gm2Step::new(2.0, tau, b));
            let q11 = s.phi[0][0] * s.phi[0][0] * f.q11
                + 2.0 * s.phi[0][0] * s.phi[0][1] * f.q12
                + s.phi[0][1] * s.phi[0][1] * f.q22
                + s.q11;
            prop_assert!((q11 - whole.q11).abs() < 1e-11 * (1.0 + whole.q11), "{q11} {whole:?}");
        }
    }

    #[test]
    fn ten_hertz_and_one_hertz_have_one_autocorrelation() {
        // Value and lag-1-s products of the second-order process, made at both rates.
        let mut estimates = Vec::new();
        for (rate, seed) in [(1_u32, 5), (10, 6)] {
            let mut rng =
                DrawKey { run_seed: seed, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
            let step = Gm2Step::new(1.0, 2.0, 1.0 / f64::from(rate));
            let (mut state, mut square, mut lagged) = ([0.0, 0.0], 0.0, 0.0);
            let n = 100_000;
            for _ in 0..n {
                let before = state[0];
                for _ in 0..rate {
                    state = step.advance(state, normal_pair(&mut rng));
                }
                square += state[0] * state[0];
                lagged += before * state[0];
            }
            estimates.push((square / f64::from(n), lagged / f64::from(n)));
        }
        let expected = (1.0, 1.5 * libm::exp(-0.5));
        for (square, lagged) in estimates {
            // About five correlation times per independent sample: deviation near 0.01.
            assert!((square - expected.0).abs() < 0.04, "{square}");
            assert!((lagged - expected.1).abs() < 0.04, "{lagged} {}", expected.1);
        }
    }
}
