//! The WGS 84 ellipsoid: geodetic and earth-centred coordinates.

use std::f64::consts::{FRAC_PI_2, PI};

/// Semi-major axis of WGS 84, m (NGA.STND.0036, table 3.1).
pub const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
/// Flattening of WGS 84 (NGA.STND.0036, table 3.1).
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared, `f (2 − f)`.
pub const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Semi-minor axis, `a (1 − f)`, m.
pub const SEMI_MINOR_AXIS_M: f64 = SEMI_MAJOR_AXIS_M * (1.0 - FLATTENING);

/// Below this distance from the centre the foot point on the ellipsoid is not unique (the evolute
/// reaches `e² a` = 42.7 km in the plane of the equator and 42.8 km along the axis).
const CENTRE_M: f64 = 43_000.0;

/// A place by latitude, longitude and height above the WGS 84 ellipsoid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, radians, north positive, in [−π/2, π/2].
    pub lat_rad: f64,
    /// Longitude, radians, east positive.
    pub lon_rad: f64,
    /// Height above the ellipsoid, metres.
    pub height_m: f64,
}

impl Geodetic {
    /// From degrees and metres.
    #[must_use]
    pub fn from_degrees(lat_deg: f64, lon_deg: f64, height_m: f64) -> Self {
        Self { lat_rad: lat_deg.to_radians(), lon_rad: lon_deg.to_radians(), height_m }
    }

    /// Latitude in degrees.
    #[must_use]
    pub fn lat_deg(self) -> f64 {
        self.lat_rad.to_degrees()
    }

    /// Longitude in degrees.
    #[must_use]
    pub fn lon_deg(self) -> f64 {
        self.lon_rad.to_degrees()
    }

    /// The same place in earth-centred, earth-fixed coordinates.
    ///
    /// `x = (N + h) cos φ cos λ`, `y = (N + h) cos φ sin λ`, `z = (N (1 − e²) + h) sin φ`,
    /// `N = a / √(1 − e² sin² φ)`. Source: NGA.STND.0036, eq. (4-14).
    #[must_use]
    pub fn to_ecef(self) -> Ecef {
        let (sin_lat, cos_lat) = libm::sincos(self.lat_rad);
        let (sin_lon, cos_lon) = libm::sincos(self.lon_rad);
        let n = SEMI_MAJOR_AXIS_M / (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
        let p = (n + self.height_m) * cos_lat;
        Ecef {
            x_m: p * cos_lon,
            y_m: p * sin_lon,
            z_m: (n * (1.0 - ECCENTRICITY_SQUARED) + self.height_m) * sin_lat,
        }
    }
}

/// A point in earth-centred, earth-fixed coordinates: x to (0° N, 0° E), y to (0° N, 90° E), z to the
/// north pole. This is the world coordinate system of DIS (IEEE 1278.1-2012, 1.6.3.1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ecef {
    /// Towards 0° N 0° E, metres.
    pub x_m: f64,
    /// Towards 0° N 90° E, metres.
    pub y_m: f64,
    /// Towards the north pole, metres.
    pub z_m: f64,
}

impl Ecef {
    /// From an array of x, y, z in metres.
    #[must_use]
    pub fn from_xyz_m(xyz_m: [f64; 3]) -> Self {
        Self { x_m: xyz_m[0], y_m: xyz_m[1], z_m: xyz_m[2] }
    }

    /// x, y, z in metres.
    #[must_use]
    pub fn xyz_m(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.z_m]
    }

    /// The vector from `origin` to `self`, metres, ECEF axes.
    #[must_use]
    pub fn minus(self, origin: Self) -> [f64; 3] {
        [self.x_m - origin.x_m, self.y_m - origin.y_m, self.z_m - origin.z_m]
    }

    /// The point moved by a vector in ECEF axes, metres.
    #[must_use]
    pub fn plus(self, v: [f64; 3]) -> Self {
        Self { x_m: self.x_m + v[0], y_m: self.y_m + v[1], z_m: self.z_m + v[2] }
    }

    /// Straight-line distance, metres.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f64 {
        crate::length(self.minus(other))
    }

    /// Latitude, longitude in [−π, π] and height of the point.
    ///
    /// Four passes of Bowring's iteration on the reduced latitude (B. R. Bowring, Survey Review 23,
    /// 1976), and the height as `p cos φ + z sin φ − a √(1 − e² sin² φ)`, which keeps its digits at
    /// the poles where `p / cos φ − N` does not. Good to a few nanometres from 6 km below the surface
    /// to geostationary height; on the axis the longitude is 0.
    ///
    /// Within 43 km of the centre, where the foot point is not unique, the latitude is the geocentric
    /// one; the centre itself is latitude 0, longitude 0, height −a.
    #[must_use]
    pub fn to_geodetic(self) -> Geodetic {
        let (a, b, e2) = (SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M, ECCENTRICITY_SQUARED);
        let p = libm::hypot(self.x_m, self.y_m);
        let lon_rad = if p == 0.0 { 0.0 } else { libm::atan2(self.y_m, self.x_m) };
        let lat_rad = if libm::hypot(p, self.z_m) < CENTRE_M {
            if p == 0.0 && self.z_m == 0.0 { 0.0 } else { libm::atan2(self.z_m, p) }
        } else {
            let second_e2 = e2 / (1.0 - e2);
            // tan β = (1 − f) tan φ; the first guess is exact on the ellipsoid.
            let mut beta = libm::atan2(self.z_m, (1.0 - FLATTENING) * p);
            let mut lat = 0.0;
            for _ in 0..4 {
                let (sin, cos) = libm::sincos(beta);
                let up = self.z_m + second_e2 * b * sin * sin * sin;
                // Negative only inside the evolute, which is excluded above; zero on the axis.
                let out = (p - e2 * a * cos * cos * cos).max(0.0);
                lat = libm::atan2(up, out);
                beta = libm::atan2((1.0 - FLATTENING) * up, out);
            }
            lat
        };
        let (sin, cos) = libm::sincos(lat_rad);
        let height_m = p * cos + self.z_m * sin - a * (1.0 - e2 * sin * sin).sqrt();
        debug_assert!(!lat_rad.is_finite() || lat_rad.abs() <= FRAC_PI_2 + 1e-15);
        debug_assert!(!lon_rad.is_finite() || lon_rad.abs() <= PI + 1e-15);
        Geodetic { lat_rad, lon_rad, height_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn hard_places() {
        for (name, place) in [
            ("Zurich", Geodetic::from_degrees(47.458, 8.548, 432.0)),
            ("north pole", Geodetic::from_degrees(90.0, 0.0, 100.0)),
            ("south pole", Geodetic::from_degrees(-90.0, 0.0, -50.0)),
            ("a hair from the pole", Geodetic::from_degrees(89.999_999_99, -170.0, 100.0)),
            ("date line", Geodetic::from_degrees(-16.8, 180.0, 10.0)),
            ("equator, mine", Geodetic::from_degrees(0.0, -90.0, -6000.0)),
            ("geostationary", Geodetic::from_degrees(0.1, 19.2, 35_786_000.0)),
        ] {
            let ecef = place.to_ecef();
            let back = ecef.to_geodetic();
            let miss_m = back.to_ecef().distance_m(ecef);
            let scale = 1.0 + place.height_m.abs() / SEMI_MAJOR_AXIS_M;
            assert!(miss_m < 6e-9 * scale, "{name}: {miss_m:e} m");
            assert!((back.height_m - place.height_m).abs() < 6e-9 * scale, "{name}");
        }
    }

    #[test]
    fn the_centre_and_the_axis_are_finite() {
        for (name, x_m, y_m, z_m) in [
            ("centre", 0.0, 0.0, 0.0),
            ("beside the centre", 1e-9, 0.0, 0.0),
            ("on the axis, inside", 0.0, 0.0, 1000.0),
            ("on the axis, at the evolute's cusp", 0.0, 0.0, 42_841.3),
            ("in the equator, at the evolute's cusp", 42_697.7, 0.0, 0.0),
            ("negative zeros", -0.0, -0.0, -0.0),
            ("far", 1e300, -1e300, 1e300),
            ("tiny", 5e-324, 5e-324, -5e-324),
        ] {
            let g = Ecef { x_m, y_m, z_m }.to_geodetic();
            assert!(g.lat_rad.is_finite() && g.lat_rad.abs() <= FRAC_PI_2, "{name}: {g:?}");
            assert!(g.lon_rad.is_finite() && g.lon_rad.abs() <= PI, "{name}: {g:?}");
            assert!(!g.height_m.is_nan(), "{name}: {g:?}");
        }
        let centre = Ecef::default().to_geodetic();
        assert_eq!((centre.lat_rad, centre.lon_rad), (0.0, 0.0));
        assert_eq!(centre.height_m, -SEMI_MAJOR_AXIS_M);
    }

    proptest! {
        #[test]
        fn there_and_back(lat in -90.0..=90.0f64, lon in -180.0..=180.0f64, h in -6000.0..1e6f64) {
            let ecef = Geodetic::from_degrees(lat, lon, h).to_ecef();
            let back = ecef.to_geodetic();
            prop_assert!(back.to_ecef().distance_m(ecef) < 1e-8);
            prop_assert!((back.height_m - h).abs() < 1e-8);
        }
    }
}
