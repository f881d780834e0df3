//! Motion models, exact for every interval: transition and process noise of one axis.
//!
//! Continuous white noise of spectral density `q` drives the last derivative. Transition and noise
//! do not depend on how an interval is cut: `Q(T₁+T₂) = Φ(T₂) Q(T₁) Φ(T₂)ᵀ + Q(T₂)`.

/// How a target moves between two plots, along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Constant velocity, acceleration driven as white noise; the acceleration of the state is set to 0.
    ConstantVelocity {
        /// Spectral density of the acceleration, m²/s³.
        q: f64,
    },
    /// Constant acceleration, white jerk. The paper's model, sec. 3.1.
    ConstantAcceleration {
        /// Spectral density of the jerk, m²/s⁵.
        q: f64,
    },
    /// Acceleration that forgets itself (Singer, IEEE Trans. AES-6, 1970).
    Singer {
        /// Rate of forgetting, 1/s, positive.
        rate: f64,
        /// Spectral density of the jerk, m²/s⁵ (`2 · rate · σ_a²`).
        q: f64,
    },
}

/// Transition `[1 t ½t²…; 0 1 …; 0 0 …]` and process noise of one axis over one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Interval, s.
    pub t: f64,
    /// Φ₀₂: position per acceleration, s².
    pub f02: f64,
    /// Φ₁₂: velocity per acceleration, s.
    pub f12: f64,
    /// Φ₂₂: what is left of the acceleration.
    pub f22: f64,
    /// Upper triangle of Q: 00, 01, 02, 11, 12, 22.
    pub q: [f64; 6],
}

impl Motion {
    /// Transition and noise over `t` seconds, `t ≥ 0`; `t = 0` gives Φ = I (but a constant-velocity
    /// model still has no acceleration) and Q = 0.
    #[inline]
    #[must_use]
    pub fn step(self, t: f64) -> Step {
        debug_assert!(t >= 0.0);
        match self {
            Self::ConstantVelocity { q } => Step::constant_velocity(q, t),
            Self::ConstantAcceleration { q } => Step::constant_acceleration(q, t),
            Self::Singer { rate, q } => Step::singer(rate, q, t),
        }
    }
}

impl Step {
    /// A step of constant acceleration; `q` in m²/s⁵.
    #[inline]
    #[must_use]
    pub fn constant_acceleration(q: f64, t: f64) -> Self {
        Self { t, f02: 0.5 * t * t, f12: t, f22: 1.0, q: constant_acceleration_noise(q, t) }
    }

    /// A step of constant velocity; `q` in m²/s³.
    #[inline]
    #[must_use]
    pub fn constant_velocity(q: f64, t: f64) -> Self {
        let q01 = 0.5 * q * t * t;
        Self { t, f02: 0.0, f12: 0.0, f22: 0.0, q: [q01 * t / 1.5, q01, 0.0, q * t, 0.0, 0.0] }
    }

    fn singer(rate: f64, q: f64, t: f64) -> Self {
        let x = rate * t;
        let (phi1, phi2) = singer_phi(x);
        Self {
            t,
            f02: t * t * phi2,
            f12: t * phi1,
            f22: libm::exp(-x),
            q: singer_noise(rate, q, t),
        }
    }

    /// Q = U D Uᵀ of white jerk in closed form: (u₀₁ = u₁₂, u₀₂, [D₀, D₁, D₂]).
    #[must_use]
    pub fn white_jerk_ud(q: f64, t: f64) -> (f64, f64, [f64; 3]) {
        let t2 = t * t;
        let t3 = t2 * t;
        (t / 2.0, t2 / 6.0, [q * (t3 * t2 / 720.0), q * (t3 / 12.0), q * t])
    }
}

#[inline]
fn constant_acceleration_noise(q: f64, t: f64) -> [f64; 6] {
    let qt = q * t;
    let qt2 = qt * t;
    let qt3 = qt2 * t;
    let qt4 = qt3 * t;
    [qt4 * t * (1.0 / 20.0), qt4 * (1.0 / 8.0), qt3 * (1.0 / 6.0), qt3 * (1.0 / 3.0), qt2 * 0.5, qt]
}

/// φ₁ = (1 − e^{−x})/x and φ₂ = (x − 1 + e^{−x})/x², by their series below x = 0.5.
fn singer_phi(x: f64) -> (f64, f64) {
    if x >= 0.5 {
        let e = libm::expm1(-x);
        return (-e / x, (x + e) / (x * x));
    }
    // Σ (−x)^k/(k+1)! and Σ (−x)^k/(k+2)!; 16 terms reach 1e-17 at x = 0.5.
    let (mut phi1, mut phi2, mut term) = (0.0, 0.0, 1.0);
    for k in 0..16 {
        let k = f64::from(k);
        phi1 += term / (k + 1.0);
        phi2 += term / ((k + 1.0) * (k + 2.0));
        term *= -x / (k + 1.0);
    }
    (phi1, phi2)
}

/// `q ∫₀ᵗ g gᵀ du`, g = (u²φ₂(au), uφ₁(au), e^{−au}).
///
/// By eight Gauss–Legendre nodes while `a t ≤ 1`: the closed form cancels there (6e-6 off at 0.01,
/// negative at 1e-4), the sum is positive semidefinite by construction.
fn singer_noise(a: f64, q: f64, t: f64) -> [f64; 6] {
    let x = a * t;
    if x > 1.0 {
        let e = libm::exp(-x);
        let (a2, e2) = (a * a, e * e);
        return [
            q * (1.0 - e2 + 2.0 * x + 2.0 * x * x * x / 3.0 - 2.0 * x * x - 4.0 * x * e)
                / (2.0 * a2 * a2 * a),
            q * (x - 1.0 + e) * (x - 1.0 + e) / (2.0 * a2 * a2),
            q * (1.0 - e2 - 2.0 * x * e) / (2.0 * a2 * a),
            q * (2.0 * x - 3.0 + 4.0 * e - e2) / (2.0 * a2 * a),
            q * (1.0 - e) * (1.0 - e) / (2.0 * a2),
            q * (1.0 - e2) / (2.0 * a),
        ];
    }
    let mut sum = [0.0; 6];
    for (node, weight) in GAUSS_LEGENDRE_8 {
        for side in [-1.0, 1.0] {
            let u = 0.5 * t * (1.0 + side * node);
            let w = 0.5 * t * weight * q;
            let (phi1, phi2) = singer_phi(a * u);
            let g = [u * u * phi2, u * phi1, libm::exp(-a * u)];
            let products =
                [g[0] * g[0], g[0] * g[1], g[0] * g[2], g[1] * g[1], g[1] * g[2], g[2] * g[2]];
            sum.iter_mut().zip(products).for_each(|(s, p)| *s += w * p);
        }
    }
    sum
}

/// Positive nodes and weights of the eight-point rule on [−1, 1] (Abramowitz and Stegun, table 25.4).
const GAUSS_LEGENDRE_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn full(q: [f64; 6]) -> [[f64; 3]; 3] {
        [[q[0], q[1], q[2]], [q[1], q[3], q[4]], [q[2], q[4], q[5]]]
    }

    fn phi(s: &Step) -> [[f64; 3]; 3] {
        [[1.0, s.t, s.f02], [0.0, 1.0, s.f12], [0.0, 0.0, s.f22]]
    }

    fn cut_and_whole_agree(motion: Motion, t1: f64, t2: f64) {
        let (whole, first, second) = (motion.step(t1 + t2), motion.step(t1), motion.step(t2));
        let (f, q) = (phi(&second), full(first.q));
        let (w, q2) = (full(whole.q), full(second.q));
        for i in 0..3 {
            for j in 0..3 {
                let mut sum = q2[i][j];
                for k in 0..3 {
                    for l in 0..3 {
                        sum += f[i][k] * q[k][l] * f[j][l];
                    }
                }
                let scale = (w[i][i] * w[j][j]).sqrt();
                assert!((sum - w[i][j]).abs() <= 1e-11 * scale, "{motion:?} {t1} {t2}: Q{i}{j}");
            }
        }
    }

    proptest! {
        #[test]
        fn noise_does_not_depend_on_how_an_interval_is_cut(
            t1 in 1e-3..30.0f64, t2 in 1e-3..30.0f64, q in 1e-3..1e3f64, rate in 1e-4..3.0f64,
        ) {
            cut_and_whole_agree(Motion::ConstantVelocity { q }, t1, t2);
            cut_and_whole_agree(Motion::ConstantAcceleration { q }, t1, t2);
            cut_and_whole_agree(Motion::Singer { rate, q }, t1, t2);
        }
    }

    #[test]
    fn singer_becomes_constant_acceleration_as_its_rate_vanishes() {
        for t in [1e-3, 1.0, 60.0] {
            let (s, c) = (
                Motion::Singer { rate: 1e-9, q: 0.3 }.step(t),
                Motion::ConstantAcceleration { q: 0.3 }.step(t),
            );
            for (a, b) in s.q.iter().zip(c.q) {
                assert!((a - b).abs() <= 1e-6 * b, "t {t}: {a} {b}");
                assert!(*a > 0.0, "the closed form goes negative here");
            }
        }
    }

    #[test]
    fn both_forms_of_the_singer_noise_meet_at_one() {
        let (below, above) = (singer_noise(1.0, 1.0, 1.0), singer_noise(1.0, 1.0, 1.0 + 1e-12));
        for (a, b) in below.iter().zip(above) {
            assert!((a - b).abs() < 1e-10 * b, "{a} {b}");
        }
    }

    #[test]
    fn no_time_moves_nothing() {
        for motion in
            [Motion::ConstantAcceleration { q: 1.0 }, Motion::Singer { rate: 0.1, q: 1.0 }]
        {
            let s = motion.step(0.0);
            assert_eq!((s.t, s.f02, s.f12, s.f22, s.q), (0.0, 0.0, 0.0, 1.0, [0.0; 6]));
        }
    }
}
