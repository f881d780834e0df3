//! East, north, up about an origin.

use crate::{Attitude, Ecef, Euler, Geodetic, Matrix};

/// A point (or difference of points) in a [`LocalFrame`], metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Enu {
    /// East of the origin, metres.
    pub east_m: f64,
    /// North of the origin, metres.
    pub north_m: f64,
    /// Up along the ellipsoid's normal at the origin, metres.
    pub up_m: f64,
}

impl Enu {
    /// East, north, up in metres.
    #[must_use]
    pub fn to_array(self) -> [f64; 3] {
        [self.east_m, self.north_m, self.up_m]
    }
}

/// A Cartesian frame east, north, up at an origin on or near the earth.
///
/// At a pole "north" is along the meridian of the origin's longitude, continued over the pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    geodetic: Geodetic,
    origin: Ecef,
    /// Rows: east, north, up in ECEF axes.
    ecef_to_enu: Matrix,
}

impl LocalFrame {
    /// The frame at a place.
    #[must_use]
    pub fn at(place: Geodetic) -> Self {
        Self::new(place, place.to_ecef())
    }

    /// The frame at a point; the origin is exactly that point.
    #[must_use]
    pub fn at_ecef(point: Ecef) -> Self {
        Self::new(point.to_geodetic(), point)
    }

    fn new(geodetic: Geodetic, origin: Ecef) -> Self {
        let (sin_lat, cos_lat) = libm::sincos(geodetic.lat_rad);
        let (sin_lon, cos_lon) = libm::sincos(geodetic.lon_rad);
        let ecef_to_enu = Matrix([
            [-sin_lon, cos_lon, 0.0],
            [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        ]);
        Self { geodetic, origin, ecef_to_enu }
    }

    /// The origin in earth-centred coordinates.
    #[must_use]
    pub fn origin(&self) -> Ecef {
        self.origin
    }

    /// The origin by latitude, longitude, height.
    #[must_use]
    pub fn origin_geodetic(&self) -> Geodetic {
        self.geodetic
    }

    /// A point in this frame. The difference is taken first, so the rounding is that of the ECEF
    /// coordinates (about 1 nm), not of the rotation.
    #[must_use]
    pub fn to_enu(&self, point: Ecef) -> Enu {
        let [east_m, north_m, up_m] = self.vector_to_enu(point.minus(self.origin));
        Enu { east_m, north_m, up_m }
    }

    /// A point of this frame in earth-centred coordinates.
    #[must_use]
    pub fn to_ecef(&self, point: Enu) -> Ecef {
        self.origin.plus(self.vector_to_ecef(point.to_array()))
    }

    /// A vector (velocity, acceleration …, any unit) from ECEF axes to east, north, up.
    #[must_use]
    pub fn vector_to_enu(&self, v: [f64; 3]) -> [f64; 3] {
        self.ecef_to_enu.apply(v)
    }

    /// A vector from east, north, up to ECEF axes.
    #[must_use]
    pub fn vector_to_ecef(&self, v: [f64; 3]) -> [f64; 3] {
        self.ecef_to_enu.apply_transposed(v)
    }

    /// The DIS Euler angles of a body with this heading, pitch and roll at the origin.
    ///
    /// Body axes: x forward, y right, z down (IEEE 1278.1-2012, 1.6.3.2).
    #[must_use]
    pub fn euler(&self, attitude: Attitude) -> Euler {
        attitude.matrix().times(self.ecef_to_ned()).euler()
    }

    /// Heading, pitch and roll at the origin of a body with these DIS Euler angles.
    #[must_use]
    pub fn attitude(&self, euler: Euler) -> Attitude {
        let ned_to_body = euler.matrix().times(self.ecef_to_ned().transposed());
        let Euler { psi_rad, theta_rad, phi_rad } = ned_to_body.euler();
        Attitude { heading_rad: psi_rad, pitch_rad: theta_rad, roll_rad: phi_rad }
    }

    fn ecef_to_ned(&self) -> Matrix {
        let Matrix([east, north, up]) = self.ecef_to_enu;
        Matrix([north, east, up.map(|x| -x)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn headings_at_hard_places() {
        for (name, lat_deg, lon_deg) in [
            ("Zurich", 47.458, 8.548),
            ("north pole", 90.0, 33.0),
            ("south pole", -90.0, -120.0),
            ("date line", 52.0, 180.0),
            ("other side of the date line", 52.0, -180.0),
            ("origin of the world axes", 0.0, 0.0),
        ] {
            let frame = LocalFrame::at(Geodetic::from_degrees(lat_deg, lon_deg, 0.0));
            for heading_rad in [0.0, 1.0, FRAC_PI_2, 3.0, -2.0, -FRAC_PI_2] {
                let attitude = Attitude { heading_rad, pitch_rad: 0.05, roll_rad: -0.02 };
                let back = frame.attitude(frame.euler(attitude));
                for (a, b) in [
                    (back.heading_rad, heading_rad),
                    (back.pitch_rad, 0.05),
                    (back.roll_rad, -0.02),
                ] {
                    assert!((a - b).abs() < 2e-15, "{name}, heading {heading_rad}: {a} for {b}");
                }
                // The nose points along the heading.
                let nose = frame.euler(attitude).matrix().apply_transposed([1.0, 0.0, 0.0]);
                let enu = frame.vector_to_enu(nose);
                let (sin, cos) = libm::sincos(heading_rad);
                assert!((enu[0] - sin * libm::cos(0.05)).abs() < 1e-15, "{name}");
                assert!((enu[1] - cos * libm::cos(0.05)).abs() < 1e-15, "{name}");
                assert!((enu[2] - libm::sin(0.05)).abs() < 1e-15, "{name}");
            }
        }
    }

    #[test]
    fn crossing_the_date_line_is_a_small_step() {
        let frame = LocalFrame::at(Geodetic::from_degrees(0.0, 179.999_999, 0.0));
        let enu = frame.to_enu(Geodetic::from_degrees(0.0, -179.999_999, 0.0).to_ecef());
        assert!((enu.east_m - 2e-6 * PI / 180.0 * 6_378_137.0).abs() < 1e-8);
    }

    #[test]
    fn a_vertical_nose_keeps_its_orientation() {
        let frame = LocalFrame::at(Geodetic::from_degrees(47.0, 8.0, 400.0));
        for pitch_rad in [FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2 - 1e-9] {
            let attitude = Attitude { heading_rad: 0.4, pitch_rad, roll_rad: 0.9 };
            let back = frame.attitude(frame.euler(attitude)).matrix();
            for (row, expected) in back.0.iter().zip(attitude.matrix().0) {
                for (a, b) in row.iter().zip(expected) {
                    assert!((a - b).abs() < 2e-15, "pitch {pitch_rad}: {a} for {b}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn enu_there_and_back(
            lat in -90.0..=90.0f64, lon in -180.0..=180.0f64,
            e in -5e4..5e4f64, n in -5e4..5e4f64, u in -500.0..5e3f64,
        ) {
            let frame = LocalFrame::at(Geodetic::from_degrees(lat, lon, 300.0));
            let back = frame.to_enu(frame.to_ecef(Enu { east_m: e, north_m: n, up_m: u }));
            prop_assert!((back.east_m - e).abs() < 3e-9);
            prop_assert!((back.north_m - n).abs() < 3e-9);
            prop_assert!((back.up_m - u).abs() < 3e-9);
        }
    }
}
