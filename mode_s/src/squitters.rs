//! The bodies: what each type of squitter says.

use crate::bits::Bits;
use crate::cpr::{self, Span};
use crate::message::{Emitter, Message, ModeSError};

fn finite(
    quantity: &'static str,
    value: f64,
    allowed: &'static str,
    fits: bool,
) -> Result<f64, ModeSError> {
    if fits && value.is_finite() {
        Ok(value)
    } else {
        Err(ModeSError::Value { quantity, value, allowed })
    }
}

fn place(lat_deg: f64, lon_deg: f64) -> Result<(), ModeSError> {
    finite("latitude", lat_deg, "degrees from -90 to 90", lat_deg.abs() <= 90.0)?;
    finite("longitude", lon_deg, "degrees from -360 to 360", lon_deg.abs() <= 360.0).map(drop)
}

fn nearest(x: f64) -> f64 {
    libm::floor(x + 0.5)
}

/// Where a target on the ground is, how fast and which way (type codes 5 to 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePosition {
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Speed over ground, kt; none for unknown.
    pub speed_kt: Option<f64>,
    /// Where it moves, or points where it stands, degrees from true north; none for unknown.
    pub track_deg: Option<f64>,
    /// Odd report.
    pub odd: bool,
    /// 5 to 8: see [`nic_type_code`].
    pub type_code: u8,
}

impl SurfacePosition {
    /// The squitter.
    ///
    /// # Errors
    /// If a value is none or out of its range.
    pub fn message(&self, from: Emitter) -> Result<Message, ModeSError> {
        place(self.lat_deg, self.lon_deg)?;
        let code = f64::from(self.type_code);
        finite("type code of a surface position", code, "5 to 8", (5.0..=8.0).contains(&code))?;
        let movement = self.speed_kt.map_or(Ok(0), movement_code)?;
        let track = match self.track_deg {
            Some(track) => {
                let track = finite("track", track, "degrees", true)?;
                nearest(track * 128.0 / 360.0).rem_euclid(128.0) as u64
            }
            None => 0,
        };
        let report = cpr::encode(self.lat_deg, self.lon_deg, self.odd, Span::Surface);
        let body = Bits::default()
            .put(self.type_code.into(), 5)
            .put(movement.into(), 7)
            .put(self.track_deg.is_some().into(), 1)
            .put(track, 7)
            .put(0, 1) // time not synchronised to UTC
            .put(self.odd.into(), 1)
            .put(report.lat.into(), 17)
            .put(report.lon.into(), 17);
        Ok(Message::new(from, body.body()))
    }
}

/// Type code of a surface position by the navigation accuracy category: 6 from 10 on, 7 for 9, 8 below.
#[must_use]
pub fn nic_type_code(nac_p: u8) -> u8 {
    match nac_p {
        10.. => 6,
        9 => 7,
        _ => 8,
    }
}

/// Steps of a surface position's speed: first code, from kt, step kt.
const MOVEMENT: [(u8, f64, f64); 6] = [
    (2, 0.125, 0.125),
    (9, 1.0, 0.25),
    (13, 2.0, 0.5),
    (39, 15.0, 1.0),
    (94, 70.0, 2.0),
    (109, 100.0, 5.0),
];

/// Code of a speed over ground; speeds are rounded down, as the field says it.
///
/// # Errors
/// If it is negative or no number.
pub fn movement_code(speed_kt: f64) -> Result<u8, ModeSError> {
    let speed_kt = finite("speed", speed_kt, "knots from 0 on", speed_kt >= 0.0)?;
    Ok(if speed_kt >= 175.0 {
        124
    } else {
        let row = MOVEMENT.iter().rev().find(|(_, from_kt, _)| speed_kt >= *from_kt);
        row.map_or(1, |(first, from_kt, step_kt)| {
            first + libm::floor((speed_kt - from_kt) / step_kt) as u8
        })
    })
}

/// The lowest speed that a code stands for, kt; none for unknown and reserved codes.
#[must_use]
pub fn movement_speed_kt(code: u8) -> Option<f64> {
    match code {
        1 => Some(0.0),
        124 => Some(175.0),
        2..=123 => {
            let row = MOVEMENT.iter().rev().find(|(first, ..)| code >= *first)?;
            Some(row.1 + f64::from(code - row.0) * row.2)
        }
        _ => None,
    }
}

/// Where a target in the air is (type code 11: barometric height, NIC 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirbornePosition {
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Pressure altitude, ft.
    pub altitude_ft: f64,
    /// Odd report.
    pub odd: bool,
}

impl AirbornePosition {
    /// The squitter; the height in steps of 25 ft, clipped from -1000 to 50 175 ft.
    ///
    /// # Errors
    /// If a value is none or out of its range.
    pub fn message(&self, from: Emitter) -> Result<Message, ModeSError> {
        place(self.lat_deg, self.lon_deg)?;
        let altitude_ft = finite("altitude", self.altitude_ft, "a number of feet", true)?;
        let steps = nearest((altitude_ft + 1000.0) / 25.0).clamp(0.0, 2047.0) as u64;
        let report = cpr::encode(self.lat_deg, self.lon_deg, self.odd, Span::Airborne);
        let body = Bits::default()
            .put(11, 5)
            .put(0, 3) // no alert, one antenna supplement bit
            .put(steps >> 4, 7)
            .put(1, 1) // steps of 25 ft
            .put(steps, 4)
            .put(0, 1)
            .put(self.odd.into(), 1)
            .put(report.lat.into(), 17)
            .put(report.lon.into(), 17);
        Ok(Message::new(from, body.body()))
    }
}

/// How fast a target in the air flies over ground (type code 19, subtype 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirborneVelocity {
    /// Towards the east, kt.
    pub east_kt: f64,
    /// Towards the north, kt.
    pub north_kt: f64,
    /// Up, ft/min.
    pub climb_fpm: f64,
}

impl AirborneVelocity {
    /// The squitter: 1 kt and 64 ft/min, clipped at 1022 kt and 32 640 ft/min.
    ///
    /// # Errors
    /// If a value is none.
    pub fn message(&self, from: Emitter) -> Result<Message, ModeSError> {
        let part = |quantity, value: f64, step: f64, most: f64| {
            let value = finite(quantity, value, "a number", true)?;
            let steps = nearest(value.abs() / step).min(most) as u64 + 1;
            Ok((u64::from(value < 0.0), steps))
        };
        let (west, east) = part("speed to the east", self.east_kt, 1.0, 1022.0)?;
        let (south, north) = part("speed to the north", self.north_kt, 1.0, 1022.0)?;
        let (down, climb) = part("rate of climb", self.climb_fpm, 64.0, 510.0)?;
        let body = Bits::default()
            .put(19, 5)
            .put(1, 3)
            .put(0, 2)
            .put(NAC_V, 3)
            .put(west, 1)
            .put(east, 10)
            .put(south, 1)
            .put(north, 10)
            .put(0, 1) // source of the rate: satellites
            .put(down, 1)
            .put(climb, 9)
            .put(0, 10); // no difference of heights
        Ok(Message::new(from, body.body()))
    }
}

/// Accuracy of the velocity: better than 3 m/s.
const NAC_V: u64 = 2;

/// Who it is (type codes 1 to 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identification<'a> {
    /// Call sign: letters, digits and spaces, at most eight.
    pub callsign: &'a str,
    /// Set and number as two hexadecimal digits: A3 is 0xa3. Set A is type code 4, B 3, C 2, D 1.
    pub category: u8,
}

impl Identification<'_> {
    /// The squitter; letters are made capital.
    ///
    /// # Errors
    /// If the category is none, or the call sign has no place.
    pub fn message(&self, from: Emitter) -> Result<Message, ModeSError> {
        let (set, number) = (self.category >> 4, self.category & 15);
        let fits = (0xa..=0xd).contains(&set) && number < 8;
        finite("emitter category", self.category.into(), "sets A to D, numbers 0 to 7", fits)?;
        let length = self.callsign.chars().count();
        finite("length of the call sign", length as f64, "at most 8 characters", length <= 8)?;
        let mut bits = Bits::default().put(u64::from(0xe - set), 5).put(number.into(), 3);
        for character in self.callsign.chars().chain(std::iter::repeat(' ')).take(8) {
            let character = character.to_ascii_uppercase();
            let code = match character {
                'A'..='Z' => u64::from(character) - 64,
                '0'..='9' | ' ' => u64::from(character),
                other => {
                    let value = f64::from(u32::from(other));
                    return Err(ModeSError::Value {
                        quantity: "character of the call sign",
                        value,
                        allowed: "letters, digits and spaces",
                    });
                }
            };
            bits = bits.put(code, 6);
        }
        Ok(Message::new(from, bits.body()))
    }
}

/// How good its reports are, and how large it is (type code 31, version 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OperationalStatus {
    /// Class of length and width of a target on the ground; none in the air.
    pub length_width_code: Option<u8>,
    /// Navigation accuracy category of the position.
    pub nac_p: u8,
    /// Source integrity level.
    pub sil: u8,
}

impl OperationalStatus {
    /// The squitter.
    ///
    /// # Errors
    /// If a code does not fit.
    pub fn message(&self, from: Emitter) -> Result<Message, ModeSError> {
        let nac_p = finite("NACp", self.nac_p.into(), "0 to 11", self.nac_p <= 11)? as u64;
        let sil = finite("SIL", self.sil.into(), "0 to 3", self.sil <= 3)? as u64;
        let start = Bits::default().put(31, 5);
        let capabilities = match self.length_width_code {
            Some(code) => {
                finite("length and width code", code.into(), "0 to 15", code <= 15)?;
                start.put(1, 3).put(0, 8).put(NAC_V, 3).put(0, 1).put(code.into(), 4)
            }
            None => start.put(0, 3).put(0, 16),
        };
        let body = capabilities
            .put(SYSTEM_DESIGN_ASSURANCE, 8)
            .put(0, 8) // antenna offset not said
            .put(2, 3) // version
            .put(0, 1)
            .put(nac_p, 4)
            .put(0, 2)
            .put(sil, 2)
            .put(0, 4);
        Ok(Message::new(from, body.body()))
    }
}

/// Operational mode: nothing but the assurance of the design, level C.
const SYSTEM_DESIGN_ASSURANCE: u64 = 2;

/// Code of the smallest class that a length and a width fit into, m; 0 (not known) where one of them is not above zero.
#[must_use]
pub fn length_width_code(length_m: f64, width_m: f64) -> u8 {
    const CLASSES: [(f64, f64); 14] = [
        (15.0, 23.0),
        (25.0, 28.5),
        (25.0, 34.0),
        (35.0, 33.0),
        (35.0, 38.0),
        (45.0, 39.5),
        (45.0, 45.0),
        (55.0, 45.0),
        (55.0, 52.0),
        (65.0, 59.5),
        (65.0, 67.0),
        (75.0, 72.5),
        (75.0, 80.0),
        (85.0, 80.0),
    ];
    if length_m <= 0.0 || width_m <= 0.0 {
        return 0;
    }
    let fits = |(length, width): &(f64, f64)| length_m <= *length && width_m <= *width;
    CLASSES.iter().position(fits).map_or(15, |i| i as u8 + 1)
}
