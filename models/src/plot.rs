//! A plot: what one sensor reports of one target at one time. It never says which entity caused it.

use crate::frames::{Matrix2, Point2, Vector2};
use crate::time::SimTime;

pub use crate::kind::SensorKind;

/// Number of a sensor within the scene, in the scene's order, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SensorId(pub u16);

/// A call sign or vehicle name: up to 11 octets of ASCII, as a DIS marking carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Callsign([u8; 11]);

impl Callsign {
    /// The first 11 ASCII graphic characters of `text`, upper case; everything else is dropped.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut octets = [0; 11];
        let graphic = text.bytes().filter(u8::is_ascii_graphic).map(|b| b.to_ascii_uppercase());
        octets.iter_mut().zip(graphic).for_each(|(slot, octet)| *slot = octet);
        Self(octets)
    }

    /// The characters.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let end = self.0.iter().position(|&b| b == 0).unwrap_or(self.0.len());
        std::str::from_utf8(&self.0[..end]).unwrap_or("")
    }
}

impl std::fmt::Display for Callsign {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}

/// Who the target says it is; only cooperative sensors have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Identity {
    /// Call sign or vehicle name.
    Callsign(Callsign),
    /// 24-bit Mode S address.
    Address(u32),
}

/// The measurement of a rotating radar, kept beside the Cartesian form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    /// Slant range, m.
    pub range_m: f64,
    /// Azimuth from the site, radians clockwise from north, in [−π, π).
    pub azimuth_rad: f64,
    /// Standard deviation of the range, m.
    pub sigma_range_m: f64,
    /// Standard deviation of the azimuth, rad.
    pub sigma_azimuth_rad: f64,
    /// Second moments of the cells that it lights, along the line of sight, between, and across it (clockwise), less
    /// those of a point, m²; where the radar works in cells.
    pub extent_m2: Option<[f64; 3]>,
}

/// Height above the aerodrome reference below which a target that reports itself counts as on the ground, m (assumed).
pub const ON_GROUND_M: f64 = 15.0;

/// One report of one sensor.
///
/// The covariance is kept as two orthonormal directions with a variance each: a
/// sequential filter takes two scalar updates, and `R = Σ variance · axis axisᵀ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plot {
    /// Which sensor.
    pub sensor: SensorId,
    /// What kind of sensor.
    pub kind: SensorKind,
    /// Time of validity of the measurement.
    pub time: SimTime,
    /// Number within the sensor and scan; with sensor and time it names the plot.
    pub sequence: u32,
    /// Measured position, airport frame, m east and north.
    pub position_m: Point2<f64>,
    /// First direction of the error ellipse (unit vector, east and north); the second is it turned 90° clockwise.
    pub axis: Vector2<f64>,
    /// Variance along `axis`, m².
    pub along_m2: f64,
    /// Variance across `axis`, m². Infinite where the sensor measures along `axis` only (loops).
    pub across_m2: f64,
    /// Height above the aerodrome reference, m, where the sensor reports it.
    pub altitude_m: Option<f64>,
    /// Range and azimuth as measured, radars only.
    pub polar: Option<Polar>,
    /// Reported identity, cooperative sensors only.
    pub identity: Option<Identity>,
    /// Signal to clutter and noise ratio, dB, radars only.
    pub scnr_db: Option<f64>,
}

impl Plot {
    /// The direction across `axis`: `axis` turned 90° clockwise.
    #[must_use]
    pub fn across_axis(&self) -> Vector2<f64> {
        Vector2::new(self.axis.y, -self.axis.x)
    }

    /// Covariance of the position in the airport frame, m².
    #[must_use]
    pub fn covariance_m2(&self) -> Matrix2<f64> {
        let across = self.across_axis();
        self.axis * self.axis.transpose() * self.along_m2
            + across * across.transpose() * self.across_m2
    }
}

/// How far the plain conversion of a polar measurement falls short on average, m: `d (1 − e^{−σ_θ²/2})`.
///
/// 1.6 mm at 2 km and 0.072°, 0.9 m at 200 km and 3 mrad.
#[must_use]
pub fn polar_bias_m(ground_range_m: f64, sigma_azimuth_rad: f64) -> f64 {
    -ground_range_m * libm::expm1(-0.5 * sigma_azimuth_rad * sigma_azimuth_rad)
}

/// The principal axis of a covariance (a unit vector) with the variances along and across it, m².
#[must_use]
pub fn principal_axes(covariance_m2: &Matrix2<f64>) -> (Vector2<f64>, f64, f64) {
    let (a, b, d) = (covariance_m2[(0, 0)], covariance_m2[(0, 1)], covariance_m2[(1, 1)]);
    let (sin, cos) = libm::sincos(0.5 * libm::atan2(2.0 * b, a - d));
    let both = 2.0 * b * sin * cos;
    let along = a * cos * cos + both + d * sin * sin;
    let across = a * sin * sin - both + d * cos * cos;
    (Vector2::new(cos, sin), along, across)
}

/// A polar measurement as a Cartesian one, without the bias of the plain conversion.
///
/// With s = σ_θ²: `z = e^{s/2} d e_r`; conditional on the measurement the variance along is
/// `½d²e^{−2s}(e^s − 1)²(2e^s + 1) + ½σ_d²(1 + e^{−2s})` and across `½(d² + σ_d²)(1 − e^{−2s})`,
/// written with `expm1` because the sum of the textbook loses nine digits (all of them in f32).
/// Source: Longbin, Xiaoquan, Yiyu, Kang, Bar-Shalom, IEEE Trans. AES-34 (1998), multiplicative form.
///
/// `direction` is the unit vector from the sensor to the target, `ground_range_m` along the ground.
/// Returns the offset from the sensor (m) and the variances along and across `direction` (m²).
#[must_use]
pub fn polar_to_cartesian(
    direction: Vector2<f64>,
    ground_range_m: f64,
    sigma_range_m: f64,
    sigma_azimuth_rad: f64,
) -> (Vector2<f64>, f64, f64) {
    let (d2, sd2) = (ground_range_m * ground_range_m, sigma_range_m * sigma_range_m);
    let s = sigma_azimuth_rad * sigma_azimuth_rad;
    let (e1, m2) = (libm::expm1(s), libm::expm1(-2.0 * s));
    let along = 0.5 * d2 * (1.0 + m2) * e1 * e1 * (2.0 * e1 + 3.0) + 0.5 * sd2 * (2.0 + m2);
    let across = -0.5 * (d2 + sd2) * m2;
    (direction * (libm::exp(0.5 * s) * ground_range_m), along, across)
}
