//! The airport frame and angles in it.
//!
//! Positions and velocities are `Vector2`/`Vector3` of metres (or metres per second) east, north,
//! up at the aerodrome reference point. Azimuths and headings are clockwise from north.

pub use nalgebra::{Matrix2, Matrix3, Matrix4, Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// `angle_rad` brought into [−π, π).
#[must_use]
pub fn wrap_pi(angle_rad: f64) -> f64 {
    if (-PI..PI).contains(&angle_rad) {
        return angle_rad;
    }
    let wrapped = libm::remainder(angle_rad, TAU);
    if wrapped >= PI { wrapped - TAU } else { wrapped }
}

/// A horizontal direction seen from a site, clockwise from north, always in [−π, π).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Azimuth(f64);

impl Azimuth {
    /// Any angle in radians, clockwise from north; wrapped.
    #[must_use]
    pub fn from_rad(angle_rad: f64) -> Self {
        Self(wrap_pi(angle_rad))
    }

    /// Direction of the vector (`east`, `north`); zero vector gives north.
    #[must_use]
    pub fn of(east_north: Vector2<f64>) -> Self {
        Self::from_rad(libm::atan2(east_north.x, east_north.y))
    }

    /// Radians in [−π, π).
    #[must_use]
    pub fn rad(self) -> f64 {
        self.0
    }

    /// Degrees in [0, 360), for display.
    #[must_use]
    pub fn deg360(self) -> f64 {
        self.0.to_degrees().rem_euclid(360.0)
    }

    /// The shortest turn from `other` to `self`, in [−π, π). No `Sub`: raw differences break at due south.
    #[must_use]
    pub fn minus(self, other: Self) -> f64 {
        wrap_pi(self.0 - other.0)
    }

    /// Unit vector (east, north) of this direction.
    #[must_use]
    pub fn unit(self) -> Vector2<f64> {
        let (sin, cos) = libm::sincos(self.0);
        Vector2::new(sin, cos)
    }
}

/// First axis (unit vector east, north) and variances along and across it of a covariance given as
/// variance east, covariance, variance north. The first is the larger.
#[must_use]
pub fn ellipse([east, cross, north]: [f64; 3]) -> (Vector2<f64>, [f64; 2]) {
    let (half_sum, half_difference) = (0.5 * (east + north), 0.5 * (east - north));
    let radius = libm::hypot(half_difference, cross);
    let larger = half_sum + radius;
    // det / larger: no cancellation where the ellipse is thin.
    let smaller =
        if larger > 0.0 { ((east * north - cross * cross) / larger).max(0.0) } else { 0.0 };
    let turn = 0.5 * libm::atan2(cross, half_difference);
    let (sin, cos) = libm::sincos(turn);
    (Vector2::new(cos, sin), [larger, smaller])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_south_differences_are_small() {
        let a = Azimuth::from_rad(PI - 1e-9);
        let b = Azimuth::from_rad(-PI + 1e-9);
        assert!((b.minus(a) - 2e-9).abs() < 1e-15);
        assert_eq!(Azimuth::from_rad(PI).rad(), -PI);
    }
}
