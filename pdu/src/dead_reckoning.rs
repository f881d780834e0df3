//! Dead reckoning: where an entity is some time after its Entity State PDU.
//!
//! Source: IEEE 1278.1-2012, annex E, models 1 to 9. The closed forms of the annex are 0/0 at angular
//! velocity zero and lose half their digits below about 1e-4 rad; here the same integrals are written
//! with coefficients that are power series for small angles, so that they hold for any angular
//! velocity.

use crate::EntityState;
use crate::enumerations::DeadReckoningAlgorithm;
use geodesy::{Ecef, Euler, Matrix, cross};

/// What dead reckoning needs of an entity at some instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Which model.
    pub algorithm: DeadReckoningAlgorithm,
    /// Location.
    pub location: Ecef,
    /// Linear velocity, m/s; world axes for models 2 to 5, body axes for 6 to 9.
    pub velocity_mps: [f64; 3],
    /// Linear acceleration, m/s², same axes.
    pub acceleration_mps2: [f64; 3],
    /// Orientation.
    pub orientation: Euler,
    /// Angular velocity about the body axes, rad/s.
    pub angular_velocity_rad_s: [f64; 3],
}

/// Where an entity is believed to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Location.
    pub location: Ecef,
    /// Velocity in world axes, m/s, whatever the model.
    pub velocity_mps: [f64; 3],
    /// Acceleration in world axes, m/s²: the change of `velocity_mps`.
    pub acceleration_mps2: [f64; 3],
    /// Orientation as world-to-body matrix.
    pub attitude: Matrix,
}

impl Estimate {
    /// Orientation as Euler angles.
    #[must_use]
    pub fn orientation(&self) -> Euler {
        self.attitude.euler()
    }
}

impl From<&EntityState<'_>> for Motion {
    fn from(state: &EntityState<'_>) -> Self {
        Self {
            algorithm: state.dead_reckoning_algorithm,
            location: state.location.into(),
            velocity_mps: state.linear_velocity_mps.to_f64(),
            acceleration_mps2: state.linear_acceleration_mps2.to_f64(),
            orientation: state.orientation.into(),
            angular_velocity_rad_s: state.angular_velocity_rad_s.to_f64(),
        }
    }
}

impl Motion {
    /// The entity `dt_s` seconds later (or earlier, if negative).
    ///
    /// Model 1 stands still; so do "other" and numbers without a model. Finite input gives finite
    /// output; NaN and infinity in the PDU come out as NaN in what depends on them.
    #[must_use]
    pub fn after(&self, dt_s: f64) -> Estimate {
        use DeadReckoningAlgorithm as A;
        let now = self.orientation.matrix();
        let (v, a) = (self.velocity_mps, self.acceleration_mps2);
        let omega = match self.algorithm {
            A::RPW | A::RVW | A::RPB | A::RVB => self.angular_velocity_rad_s,
            _ => [0.0; 3],
        };
        let a = match self.algorithm {
            A::RVW | A::FVW | A::RVB | A::FVB => a,
            _ => [0.0; 3],
        };
        let attitude = || rotation(omega, dt_s).transposed().times(now);
        match self.algorithm {
            A::FPW | A::RPW | A::RVW | A::FVW => {
                let moved = [0, 1, 2].map(|i| dt_s * (v[i] + 0.5 * dt_s * a[i]));
                let attitude = if omega == [0.0; 3] { now } else { attitude() };
                Estimate {
                    location: self.location.plus(moved),
                    velocity_mps: [0, 1, 2].map(|i| v[i] + dt_s * a[i]),
                    acceleration_mps2: a,
                    attitude,
                }
            }
            A::FPB | A::RPB | A::RVB | A::FVB => {
                let moved = body_displacement(omega, dt_s, v, a);
                let attitude = if omega == [0.0; 3] { now } else { attitude() };
                let v = [0, 1, 2].map(|i| v[i] + dt_s * a[i]);
                // d/dt (Rᵀ v) = Rᵀ (a + ω × v).
                let turning = cross(omega, v);
                let change = [0, 1, 2].map(|i| a[i] + turning[i]);
                Estimate {
                    location: self.location.plus(now.apply_transposed(moved)),
                    velocity_mps: attitude.apply_transposed(v),
                    acceleration_mps2: attitude.apply_transposed(change),
                    attitude,
                }
            }
            _ => Estimate {
                location: self.location,
                velocity_mps: [0.0; 3],
                acceleration_mps2: [0.0; 3],
                attitude: now,
            },
        }
    }
}

/// `exp([ω]ₓ t)`: takes vectors from body axes after `t` to body axes at the start.
///
/// Rodrigues' formula `I + (sin x / x) t [ω]ₓ + ((1 − cos x) / x²) t² [ω]ₓ²`, `x = |ω| t`.
#[must_use]
pub fn rotation(omega_rad_s: [f64; 3], t_s: f64) -> Matrix {
    let angle = omega_rad_s.map(|w| w * t_s);
    let x = geodesy::length(angle);
    let (sinc, versine) = (sinc(x), versine(x));
    let [p, q, r] = angle;
    Matrix([
        [1.0 - versine * (q * q + r * r), versine * p * q - sinc * r, versine * p * r + sinc * q],
        [versine * p * q + sinc * r, 1.0 - versine * (p * p + r * r), versine * q * r - sinc * p],
        [versine * p * r - sinc * q, versine * q * r + sinc * p, 1.0 - versine * (p * p + q * q)],
    ])
}

/// `∫₀ᵗ exp([ω]ₓ u) (v + a u) du`: the way of a body with velocity `v + a u` in its own turning axes,
/// in the body axes at the start.
#[must_use]
pub fn body_displacement(
    omega_rad_s: [f64; 3],
    t_s: f64,
    velocity_mps: [f64; 3],
    acceleration_mps2: [f64; 3],
) -> [f64; 3] {
    let angle = omega_rad_s.map(|w| w * t_s);
    let x = geodesy::length(angle);
    let way = velocity_mps.map(|v| v * t_s);
    let bend = acceleration_mps2.map(|a| a * t_s * t_s);
    let (way1, bend1) = (cross(angle, way), cross(angle, bend));
    let (way2, bend2) = (cross(angle, way1), cross(angle, bend1));
    let (v1, v2) = (versine(x), second(x));
    let (a1, a2) = (first_moment(x), second_moment(x));
    [0, 1, 2].map(|i| {
        way[i] + v1 * way1[i] + v2 * way2[i] + 0.5 * bend[i] + a1 * bend1[i] + a2 * bend2[i]
    })
}

/// Below this angle (radians) the power series are used; above, the closed forms lose less than two
/// digits of sixteen.
const SERIES_BELOW: f64 = 1.0;

/// `sin x / x`.
fn sinc(x: f64) -> f64 {
    if x < 1e-8 { 1.0 } else { libm::sin(x) / x }
}

/// `(1 − cos x) / x²`, as `2 sin²(x/2) / x²`, which does not cancel.
fn versine(x: f64) -> f64 {
    let s = sinc(0.5 * x);
    0.5 * s * s
}

/// `(x − sin x) / x³`.
fn second(x: f64) -> f64 {
    if x < SERIES_BELOW {
        // Σ (−1)ᵏ x²ᵏ / (2k + 3)!
        return series(x, 1.0 / 6.0, |k| -1.0 / ((2.0 * k + 2.0) * (2.0 * k + 3.0)));
    }
    (x - libm::sin(x)) / x / x / x
}

/// `(sin x − x cos x) / x³`.
fn first_moment(x: f64) -> f64 {
    if x < SERIES_BELOW {
        // Σ (−1)ᵏ x²ᵏ (2k + 2) / (2k + 3)!
        return series(x, 1.0 / 3.0, |k| {
            -(2.0 * k + 2.0) / (2.0 * k) / ((2.0 * k + 2.0) * (2.0 * k + 3.0))
        });
    }
    (libm::sin(x) - x * libm::cos(x)) / x / x / x
}

/// `(x²/2 + 1 − cos x − x sin x) / x⁴`.
fn second_moment(x: f64) -> f64 {
    if x < SERIES_BELOW {
        // Σ (−1)ᵏ x²ᵏ (2k + 3) / (2k + 4)!
        return series(x, 1.0 / 8.0, |k| {
            -(2.0 * k + 3.0) / (2.0 * k + 1.0) / ((2.0 * k + 3.0) * (2.0 * k + 4.0))
        });
    }
    (0.5 + ((1.0 - libm::cos(x)) / x - libm::sin(x)) / x) / x / x
}

/// A power series in x² by its first term and the ratio of term k to term k − 1 (k from 1); ten terms
/// are exact to rounding below 1.
fn series(x: f64, first: f64, ratio: impl Fn(f64) -> f64) -> f64 {
    let x2 = x * x;
    let mut term = first;
    let mut sum = first;
    for k in 1..10 {
        term *= x2 * ratio(f64::from(k));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn motion(algorithm: DeadReckoningAlgorithm, omega: [f64; 3]) -> Motion {
        Motion {
            algorithm,
            location: Ecef { x_m: 4_278_000.0, y_m: 643_000.0, z_m: 4_670_000.0 },
            velocity_mps: [70.0, -1.0, 2.0],
            acceleration_mps2: [-2.0, 0.3, 0.1],
            orientation: Euler { psi_rad: 0.4, theta_rad: -0.9, phi_rad: 2.0 },
            angular_velocity_rad_s: omega,
        }
    }

    /// The body's path by 200 000 steps of the differential equation, second order.
    fn by_steps(m: &Motion, dt_s: f64) -> Ecef {
        let steps = 200_000;
        let h = dt_s / f64::from(steps);
        let now = m.orientation.matrix();
        let turn = rotation(m.angular_velocity_rad_s, h);
        let mut to_start = rotation(m.angular_velocity_rad_s, 0.5 * h);
        let mut way = [0.0; 3];
        for i in 0..steps {
            let u = (f64::from(i) + 0.5) * h;
            let v = [0, 1, 2].map(|j| m.velocity_mps[j] + u * m.acceleration_mps2[j]);
            let step = to_start.apply(v);
            way = [0, 1, 2].map(|j| way[j] + h * step[j]);
            to_start = to_start.times(turn);
        }
        m.location.plus(now.apply_transposed(way))
    }

    #[test]
    fn body_axes_follow_the_differential_equation() {
        for omega in [[0.3, -0.2, 0.5], [0.0, 0.0, 3.1], [2e-3, 0.0, 1e-3], [9.0, 3.0, 1.0]] {
            let m = motion(DeadReckoningAlgorithm::RVB, omega);
            let miss_m = m.after(4.0).location.distance_m(by_steps(&m, 4.0));
            assert!(miss_m < 5e-5, "{omega:?}: {miss_m:e} m");
        }
    }

    #[test]
    fn models_are_what_their_letters_say() {
        use DeadReckoningAlgorithm as A;
        let omega = [0.1, 0.2, -0.3];
        let at = |algorithm| motion(algorithm, omega).after(2.0);
        let start = motion(A::STATIC, omega);
        let moved = |algorithm| at(algorithm).location.minus(start.location);
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-8);
        let now = start.orientation.matrix();
        // P: v t. V: v t + a t² / 2. W: as given. B: turned into the world.
        let (p, v) = ([140.0, -2.0, 4.0], [136.0, -1.4, 4.2]);
        assert!(near(moved(A::STATIC), [0.0; 3]) && near(moved(A::OTHER), [0.0; 3]));
        assert!(near(moved(A::FPW), p) && near(moved(A::RPW), p));
        assert!(near(moved(A::FVW), v) && near(moved(A::RVW), v));
        assert!(near(moved(A::FPB), now.apply_transposed(p)));
        assert!(near(moved(A::FVB), now.apply_transposed(v)));
        for (algorithm, turns) in [
            (A::STATIC, false),
            (A::FPW, false),
            (A::RPW, true),
            (A::RVW, true),
            (A::FVW, false),
            (A::FPB, false),
            (A::RPB, true),
            (A::RVB, true),
            (A::FVB, false),
        ] {
            let turned = at(algorithm).attitude.angle_to(&now);
            let expected = if turns { 2.0 * 0.14_f64.sqrt() } else { 0.0 };
            assert!((turned - expected).abs() < 1e-14, "{algorithm}: {turned}");
        }
        // Velocity is the change of location, acceleration that of velocity.
        for algorithm in [A::FPW, A::RVW, A::FPB, A::RPB, A::RVB, A::FVB] {
            let m = motion(algorithm, omega);
            let (before, after) = (m.after(2.0 - 1e-3), m.after(2.0 + 1e-3));
            let slope = after.location.minus(before.location).map(|d| d / 2e-3);
            let here = m.after(2.0);
            let close =
                |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-5);
            assert!(close(slope, here.velocity_mps), "{algorithm}");
            let change = [0, 1, 2].map(|i| (after.velocity_mps[i] - before.velocity_mps[i]) / 2e-3);
            assert!(close(change, here.acceleration_mps2), "{algorithm}");
        }
    }

    #[test]
    fn coefficients_agree_where_series_and_closed_form_meet() {
        let (below, above) = (1.0 - 1e-15, 1.0);
        for (name, f) in [
            ("second", second as fn(f64) -> f64),
            ("first moment", first_moment),
            ("second moment", second_moment),
        ] {
            let jump = (f(below) - f(above)).abs() / f(above);
            assert!(jump < 1e-14, "{name}: {jump:e}");
        }
    }

    #[test]
    fn hard_angular_velocities() {
        let still = motion(DeadReckoningAlgorithm::RVB, [0.0; 3]).after(5.0);
        for (name, omega) in [
            ("smallest number", [5e-324, 0.0, 0.0]),
            ("negative zero", [-0.0, 0.0, -0.0]),
            ("1e-12 rad/s", [0.0, 0.0, 1e-12]),
        ] {
            let turned = motion(DeadReckoningAlgorithm::RVB, omega).after(5.0);
            assert!(turned.location.distance_m(still.location) < 2e-9, "{name}");
        }
        let spin = motion(DeadReckoningAlgorithm::RVB, [1e6, 0.0, 1e6]).after(5.0);
        // Spinning so fast, only the part of the motion along the axis remains.
        let axis = (72.0 * 5.0 - 1.9 * 12.5) / 2.0;
        let moved = still_frame(&spin);
        assert!((moved[0] - axis).abs() < 1e-3 && (moved[2] - axis).abs() < 1e-3, "{moved:?}");
        let huge = motion(DeadReckoningAlgorithm::RVB, [1e150, 1e150, 0.0]).after(1.0);
        assert!(geodesy::length(huge.location.xyz_m()).is_finite());
    }

    fn still_frame(e: &Estimate) -> [f64; 3] {
        let m = motion(DeadReckoningAlgorithm::RVB, [0.0; 3]);
        m.orientation.matrix().apply(e.location.minus(m.location))
    }

    proptest! {
        #[test]
        fn going_there_and_back_is_staying(
            algorithm in 2_u8..=9, p in -3.0..3.0f64, q in -3.0..3.0f64, r in -3.0..3.0f64,
            dt in 0.0..20.0f64,
        ) {
            // Without acceleration the model is the same from any instant on.
            let mut m = motion(DeadReckoningAlgorithm(algorithm), [p, q, r]);
            m.acceleration_mps2 = [0.0; 3];
            let there = m.after(dt);
            let body = algorithm >= 6;
            let back = Motion {
                location: there.location,
                velocity_mps: if body { m.velocity_mps } else { there.velocity_mps },
                orientation: there.orientation(),
                ..m
            }.after(-dt);
            prop_assert!(back.location.distance_m(m.location) < 1e-8);
            prop_assert!(back.attitude.angle_to(&m.orientation.matrix()) < 1e-13);
        }

        #[test]
        fn two_steps_are_one(
            p in -3.0..3.0f64, q in -3.0..3.0f64, r in -3.0..3.0f64, a in 0.0..10.0f64, b in 0.0..10.0f64,
        ) {
            let mut m = motion(DeadReckoningAlgorithm::RPB, [p, q, r]);
            m.acceleration_mps2 = [0.0; 3];
            let half = m.after(a);
            let two = Motion { location: half.location, orientation: half.orientation(), ..m }.after(b);
            prop_assert!(two.location.distance_m(m.after(a + b).location) < 1e-8);
        }
    }
}
