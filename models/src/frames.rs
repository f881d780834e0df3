//! Frames as types, and angles in them.
//!
//! | what | type | frame |
//! | --- | --- | --- |
//! | a place of the airport: position, site, stand, corner of a wall | [`Point2`], [`Point3`] | airport: m east, north, up of its reference point |
//! | an offset between places, from a sensor's site too | [`Vector2`], [`Vector3`] | local: the airport's axes, from a place known beside it |
//! | a velocity, an acceleration, an error, a direction | [`Vector2`], [`Vector3`] | the airport's axes |
//! | a place on or above the earth | [`geodesy::Ecef`], [`geodesy::Geodetic`] | earth-centred, WGS 84 |
//!
//! Place − place is an offset, place + offset a place; places do not add:
//!
//! ```
//! use models::frames::{Point2, Vector2, center};
//! let (site_m, target_m) = (Point2::new(10.0, 20.0), Point2::new(13.0, 24.0));
//! let offset_m: Vector2<f64> = target_m - site_m;
//! assert_eq!((offset_m.norm(), site_m + offset_m), (5.0, target_m));
//! assert_eq!(center(&site_m, &target_m), Point2::new(11.5, 22.0));
//! ```
//!
//! ```compile_fail,E0277
//! use models::frames::Point2;
//! let (site_m, target_m) = (Point2::new(10.0, 20.0), Point2::new(13.0, 24.0));
//! let middle_m = (site_m + target_m) * 0.5;
//! ```
//!
//! An offset is no place, nor a place an offset:
//!
//! ```compile_fail,E0308
//! use models::frames::{Point2, Vector2};
//! use models::airport::distance_to_segment_m;
//! let (a, b) = (Point2::new(0.0, 0.0), Point2::new(100.0, 0.0));
//! let offset_m: Vector2<f64> = b - a;
//! distance_to_segment_m(offset_m, a, b);
//! ```
//!
//! ```compile_fail,E0308
//! use models::frames::{Azimuth, Point2};
//! Azimuth::of(Point2::new(3.0, 4.0));
//! ```
//!
//! A place of the earth becomes one of the airport by the frame that owns the origin alone ([`geodesy::LocalFrame`]):
//!
//! ```compile_fail,E0369
//! use models::frames::{Point3, Vector3};
//! let satellite = geodesy::Ecef::from_xyz_m([2.0e7, 1.0e7, 1.0e7]);
//! let site_m = Point3::new(10.0, 20.0, 30.0);
//! let line: Vector3<f64> = satellite - site_m;
//! ```
//!
//! In memory and on the wire either is its numbers. Kernels (states of filters, sums of least squares) compute with vectors from the
//! reference point: `place.coords` at their edge, `Point2::from` back. Azimuths and headings are clockwise from north.

pub use nalgebra::{Matrix2, Matrix3, Matrix4, Point2, Point3, Vector2, Vector3, center};
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
