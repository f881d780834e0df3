//! Places on the earth and orientations in space, as a wire format and a simulation need them.
//!
//! | from | to | by |
//! | --- | --- | --- |
//! | [`Geodetic`] (latitude, longitude, height; WGS 84) | [`Ecef`] (earth-centred, earth-fixed) | [`Geodetic::to_ecef`], [`Ecef::to_geodetic`] |
//! | [`Ecef`] | [`Enu`] (east, north, up about an origin) | [`LocalFrame::to_enu`], [`LocalFrame::to_ecef`] |
//! | [`Euler`] (psi, theta, phi of DIS: ECEF axes to body axes) | [`Matrix`], [`Quaternion`] | [`Euler::matrix`], [`Quaternion::euler`] … |
//! | [`Euler`] at a place | [`Attitude`] (heading, pitch, roll) | [`LocalFrame::attitude`], [`LocalFrame::euler`] |
//!
//! Everything is a plain value of `f64`. Functions are total: finite input gives finite output, also at
//! the poles, on the date line, at pitch ±90° and at the centre of the earth; NaN and infinity pass
//! through as NaN. Transcendental functions come from `libm`, so the same input gives the same bits on
//! every host.
//!
//! Crates weighed before writing this: `sguaba` 0.10 (type-safe frames, but on nalgebra and uom, which a
//! wire format must not need) and `map_3d` 0.1 (no orientations, NaN at the earth's centre, platform
//! trigonometry with host-dependent bits).
//!
//! ```
//! use geodesy::{Attitude, Geodetic, LocalFrame};
//!
//! let tower = LocalFrame::at(Geodetic::from_degrees(47.4581, 8.5481, 432.0));
//! let stand = Geodetic::from_degrees(47.4510, 8.5560, 432.0).to_ecef();
//! let enu = tower.to_enu(stand);
//! assert!((enu.north_m - -789.0).abs() < 1.0 && (enu.east_m - 596.0).abs() < 1.0);
//!
//! // An aircraft that points east, level, as DIS wants it:
//! let east = Attitude { heading_rad: 90f64.to_radians(), pitch_rad: 0.0, roll_rad: 0.0 };
//! let euler = tower.euler(east);
//! assert!((tower.attitude(euler).heading_rad - 90f64.to_radians()).abs() < 1e-12);
//! ```

mod local;
mod orientation;
mod wgs84;

pub use local::{Enu, LocalFrame};
pub use orientation::{Attitude, Euler, Matrix, Quaternion};
pub use wgs84::{
    ECCENTRICITY_SQUARED, Ecef, FLATTENING, Geodetic, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M,
};

/// Cross product of two vectors in one right-handed frame.
#[must_use]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length of a vector, without overflow or underflow in between.
#[must_use]
pub fn length(v: [f64; 3]) -> f64 {
    libm::hypot(libm::hypot(v[0], v[1]), v[2])
}
