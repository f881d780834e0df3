//! Orientations: DIS Euler angles, rotation matrices, quaternions, heading-pitch-roll.

/// DIS Euler angles: the world (ECEF) axes are turned by psi about z, then theta about the new y, then
/// phi about the new x, and are then the body axes (x forward, y right, z down).
///
/// Source: IEEE 1278.1-2012, 1.6.3.3 and 6.2.32.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Euler {
    /// About z, radians.
    pub psi_rad: f64,
    /// About y, radians.
    pub theta_rad: f64,
    /// About x, radians.
    pub phi_rad: f64,
}

/// Heading, pitch and roll against north, east, down at some place. Not the DIS angles: those are
/// against the world axes; [`LocalFrame::euler`](crate::LocalFrame::euler) converts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Clockwise from true north, radians.
    pub heading_rad: f64,
    /// Nose up positive, radians.
    pub pitch_rad: f64,
    /// Right wing down positive, radians.
    pub roll_rad: f64,
}

impl Attitude {
    /// The matrix that takes vectors in north, east, down to body axes.
    #[must_use]
    pub fn matrix(self) -> Matrix {
        Euler { psi_rad: self.heading_rad, theta_rad: self.pitch_rad, phi_rad: self.roll_rad }
            .matrix()
    }
}

/// A rotation matrix, rows first. Of an [`Euler`] it takes world vectors to body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix(
    /// Rows.
    pub [[f64; 3]; 3],
);

/// A unit quaternion. Of an [`Euler`] it turns body vectors into world axes: `v_world = q v_body q*`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion {
    /// Scalar part.
    pub w: f64,
    /// x part.
    pub x: f64,
    /// y part.
    pub y: f64,
    /// z part.
    pub z: f64,
}

impl Euler {
    /// The matrix that takes world (ECEF) vectors to body axes. Source: IEEE 1278.1-2012, 1.6.3.3.
    #[must_use]
    pub fn matrix(self) -> Matrix {
        let (sin_psi, cos_psi) = libm::sincos(self.psi_rad);
        let (sin_theta, cos_theta) = libm::sincos(self.theta_rad);
        let (sin_phi, cos_phi) = libm::sincos(self.phi_rad);
        Matrix([
            [cos_psi * cos_theta, sin_psi * cos_theta, -sin_theta],
            [
                cos_psi * sin_theta * sin_phi - sin_psi * cos_phi,
                sin_psi * sin_theta * sin_phi + cos_psi * cos_phi,
                cos_theta * sin_phi,
            ],
            [
                cos_psi * sin_theta * cos_phi + sin_psi * sin_phi,
                sin_psi * sin_theta * cos_phi - cos_psi * sin_phi,
                cos_theta * cos_phi,
            ],
        ])
    }

    /// The quaternion that turns body vectors into world axes, from half angles (no square roots, so
    /// nothing is lost near pitch ±90°).
    #[must_use]
    pub fn quaternion(self) -> Quaternion {
        let (s1, c1) = libm::sincos(self.psi_rad / 2.0);
        let (s2, c2) = libm::sincos(self.theta_rad / 2.0);
        let (s3, c3) = libm::sincos(self.phi_rad / 2.0);
        Quaternion {
            w: c1 * c2 * c3 + s1 * s2 * s3,
            x: c1 * c2 * s3 - s1 * s2 * c3,
            y: c1 * s2 * c3 + s1 * c2 * s3,
            z: s1 * c2 * c3 - c1 * s2 * s3,
        }
    }
}

impl Matrix {
    /// No rotation.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// `R v`.
    #[must_use]
    pub fn apply(&self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// `Rᵀ v`: the inverse rotation.
    #[must_use]
    pub fn apply_transposed(&self, v: [f64; 3]) -> [f64; 3] {
        let r = &self.0;
        [0, 1, 2].map(|j| r[0][j] * v[0] + r[1][j] * v[1] + r[2][j] * v[2])
    }

    /// The transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let r = &self.0;
        Self([0, 1, 2].map(|j| [r[0][j], r[1][j], r[2][j]]))
    }

    /// `self · other`: first `other`, then `self`.
    #[must_use]
    pub fn times(&self, other: Self) -> Self {
        let o = other.0;
        Self(
            self.0.map(|row| {
                [0, 1, 2].map(|j| row[0] * o[0][j] + row[1] * o[1][j] + row[2] * o[2][j])
            }),
        )
    }

    /// The Euler angles of a world-to-body matrix; psi and phi in [−π, π], theta in [−π/2, π/2].
    ///
    /// Theta by `atan2` (the arc sine loses half the digits at ±90°). Phi is read from the axes that
    /// remain after undoing psi, so that it also holds at ±90°, where only psi − phi (or psi + phi) is
    /// defined: there psi is whatever the rounding of the matrix says and phi makes up for it.
    #[must_use]
    pub fn euler(&self) -> Euler {
        let r = &self.0;
        let psi_rad = libm::atan2(r[0][1], r[0][0]);
        let (sin_psi, cos_psi) = libm::sincos(psi_rad);
        let theta_rad = libm::atan2(-r[0][2], libm::hypot(r[0][0], r[0][1]));
        let phi_rad = libm::atan2(
            sin_psi * r[2][0] - cos_psi * r[2][1],
            cos_psi * r[1][1] - sin_psi * r[1][0],
        );
        Euler { psi_rad, theta_rad, phi_rad }
    }

    /// The quaternion of a world-to-body matrix, dividing by its largest part only.
    ///
    /// Source: S. W. Shepperd, J. Guidance and Control 1 (1978) 223.
    #[must_use]
    pub fn quaternion(&self) -> Quaternion {
        // The textbook form is for body to world, so indices are swapped.
        let r = &self.0;
        let trace = r[0][0] + r[1][1] + r[2][2];
        let parts = [trace, r[0][0], r[1][1], r[2][2]];
        let largest = (1..4).fold(0, |best, i| if parts[i] > parts[best] { i } else { best });
        // max(…, 0) keeps a damaged matrix from giving NaN.
        let root = |square: f64| square.max(0.0).sqrt().max(f64::MIN_POSITIVE);
        match largest {
            0 => {
                let s = 2.0 * root(1.0 + trace);
                Quaternion {
                    w: s / 4.0,
                    x: (r[1][2] - r[2][1]) / s,
                    y: (r[2][0] - r[0][2]) / s,
                    z: (r[0][1] - r[1][0]) / s,
                }
            }
            1 => {
                let s = 2.0 * root(1.0 + r[0][0] - r[1][1] - r[2][2]);
                Quaternion {
                    w: (r[1][2] - r[2][1]) / s,
                    x: s / 4.0,
                    y: (r[1][0] + r[0][1]) / s,
                    z: (r[2][0] + r[0][2]) / s,
                }
            }
            2 => {
                let s = 2.0 * root(1.0 - r[0][0] + r[1][1] - r[2][2]);
                Quaternion {
                    w: (r[2][0] - r[0][2]) / s,
                    x: (r[1][0] + r[0][1]) / s,
                    y: s / 4.0,
                    z: (r[2][1] + r[1][2]) / s,
                }
            }
            _ => {
                let s = 2.0 * root(1.0 - r[0][0] - r[1][1] + r[2][2]);
                Quaternion {
                    w: (r[0][1] - r[1][0]) / s,
                    x: (r[2][0] + r[0][2]) / s,
                    y: (r[2][1] + r[1][2]) / s,
                    z: s / 4.0,
                }
            }
        }
    }

    /// The angle of the one rotation that takes `self` to `other`, radians in [0, π].
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        let q = self.times(other.transposed()).quaternion();
        2.0 * libm::atan2(crate::length([q.x, q.y, q.z]), q.w.abs())
    }
}

impl Quaternion {
    /// No rotation.
    pub const IDENTITY: Self = Self { w: 1.0, x: 0.0, y: 0.0, z: 0.0 };

    /// The rotation by `|v|` radians about `v`; zero gives the identity.
    #[must_use]
    pub fn from_rotation_vector(v: [f64; 3]) -> Self {
        let angle = crate::length(v);
        let (sin, cos) = libm::sincos(angle / 2.0);
        // sin(x/2)/x → 1/2; below 1e-8 the next term is under the rounding.
        let k = if angle < 1e-8 { 0.5 } else { sin / angle };
        Self { w: cos, x: k * v[0], y: k * v[1], z: k * v[2] }
    }

    /// The shortest rotation vector of this quaternion: axis times angle in [0, π] radians.
    #[must_use]
    pub fn rotation_vector(self) -> [f64; 3] {
        let sign = if self.w < 0.0 { -1.0 } else { 1.0 };
        let v = [sign * self.x, sign * self.y, sign * self.z];
        let sin = crate::length(v);
        let k = if sin < 1e-8 { 2.0 } else { 2.0 * libm::atan2(sin, self.w.abs()) / sin };
        v.map(|x| k * x)
    }

    /// Hamilton's product: first `other`, then `self`.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        }
    }

    /// The inverse rotation (of a unit quaternion).
    #[must_use]
    pub fn conjugate(self) -> Self {
        Self { w: self.w, x: -self.x, y: -self.y, z: -self.z }
    }

    /// Scaled to length one; a quaternion without length gives the identity.
    #[must_use]
    pub fn normalised(self) -> Self {
        let n = libm::hypot(libm::hypot(self.w, self.x), libm::hypot(self.y, self.z));
        if n == 0.0 {
            return Self::IDENTITY;
        }
        Self { w: self.w / n, x: self.x / n, y: self.y / n, z: self.z / n }
    }

    /// The world-to-body matrix of a body-to-world quaternion.
    #[must_use]
    pub fn matrix(self) -> Matrix {
        let Self { w, x, y, z } = self;
        Matrix([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])
    }

    /// The DIS Euler angles.
    #[must_use]
    pub fn euler(self) -> Euler {
        self.matrix().euler()
    }

    /// The angle of the one rotation that takes `self` to `other`, radians in [0, π]; keeps its digits
    /// for small angles, where the arc cosine has none.
    #[must_use]
    pub fn angle_to(self, other: Self) -> f64 {
        crate::length(other.times(self.conjugate()).rotation_vector())
    }

    /// The orientation a share `t` (0 to 1) of the way to `other`, along the shorter arc.
    #[must_use]
    pub fn slerp(self, other: Self, t: f64) -> Self {
        let way = other.times(self.conjugate()).rotation_vector();
        Self::from_rotation_vector(way.map(|x| t * x)).times(self).normalised()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn worst(a: Matrix, b: Matrix) -> f64 {
        let pairs = a.0.into_iter().flatten().zip(b.0.into_iter().flatten());
        pairs.fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
    }

    #[test]
    fn gimbal_lock_keeps_the_orientation() {
        for (name, theta_rad) in [
            ("straight up", FRAC_PI_2),
            ("straight down", -FRAC_PI_2),
            ("1e-5 below", FRAC_PI_2 - 1e-5),
            ("1e-9 below", FRAC_PI_2 - 1e-9),
            ("1e-16 below", FRAC_PI_2 - 1e-16),
        ] {
            for (psi_rad, phi_rad) in [(0.3, 0.7), (-2.0, 3.0), (3.1, -1.0), (0.0, PI)] {
                let euler = Euler { psi_rad, theta_rad, phi_rad };
                let m = euler.matrix();
                assert!(worst(m.euler().matrix(), m) < 5e-16, "{name}: from the matrix");
                let q = euler.quaternion();
                assert!(worst(q.matrix(), m) < 1e-15, "{name}: quaternion");
                assert!(worst(q.euler().matrix(), m) < 2e-15, "{name}: from the quaternion");
            }
        }
    }

    #[test]
    fn small_angles_keep_their_digits() {
        let a = Euler { psi_rad: 1.0, theta_rad: -0.3, phi_rad: 0.2 }.quaternion();
        for angle in [1e-3, 1e-6, 1e-9] {
            let b = Quaternion::from_rotation_vector([0.0, angle, 0.0]).times(a);
            assert!((a.angle_to(b) / angle - 1.0).abs() < 1e-6, "{angle}: {}", a.angle_to(b));
            let by_matrix = a.matrix().angle_to(&b.matrix());
            assert!((by_matrix - angle).abs() < 1e-15, "{angle}: {by_matrix}");
        }
        assert!(a.angle_to(a) < 1e-16);
    }

    proptest! {
        #[test]
        fn all_forms_agree(psi in -PI..PI, theta in -FRAC_PI_2..FRAC_PI_2, phi in -PI..PI) {
            let m = Euler { psi_rad: psi, theta_rad: theta, phi_rad: phi }.matrix();
            prop_assert!(worst(m.euler().matrix(), m) < 1e-15);
            prop_assert!(worst(m.quaternion().matrix(), m) < 2e-15);
            prop_assert!(worst(m.times(m.transposed()), Matrix::IDENTITY) < 1e-15);
        }

        #[test]
        fn rotation_vectors_come_back(x in -1.8..1.8f64, y in -1.8..1.8f64, z in -1.8..1.8f64) {
            let back = Quaternion::from_rotation_vector([x, y, z]).rotation_vector();
            for (a, b) in back.into_iter().zip([x, y, z]) {
                prop_assert!((a - b).abs() < 1e-13);
            }
        }

        #[test]
        fn half_way_is_half_the_angle(psi in -PI..PI, theta in -1.5..1.5f64) {
            let a = Euler { psi_rad: psi, theta_rad: theta, phi_rad: 0.1 }.quaternion();
            let b = Euler { psi_rad: 0.5, theta_rad: 0.2, phi_rad: -1.0 }.quaternion();
            let half = a.slerp(b, 0.5);
            prop_assert!((a.angle_to(half) - half.angle_to(b)).abs() < 1e-13);
        }
    }
}
