//! The way back: what a squitter says.

use crate::bits::get;
use crate::cpr::Report;
use crate::message::{Emitter, Message, ModeSError};
use crate::squitters::movement_speed_kt;

/// What a squitter says.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// Position on the ground.
    Surface {
        /// Type code, 5 to 8.
        type_code: u8,
        /// Speed code, 0 to 127.
        movement: u8,
        /// Speed over ground, kt, where it is known: the lowest of its step.
        speed_kt: Option<f64>,
        /// Track, degrees, where it is valid.
        track_deg: Option<f64>,
        /// Position within its zone.
        report: Report,
    },
    /// Position in the air.
    Airborne {
        /// Pressure altitude, ft, in steps of 25.
        altitude_ft: Option<f64>,
        /// Position within its zone.
        report: Report,
    },
    /// Velocity over ground.
    Velocity {
        /// To the east, kt.
        east_kt: Option<f64>,
        /// To the north, kt.
        north_kt: Option<f64>,
        /// Up, ft/min.
        climb_fpm: Option<f64>,
    },
    /// Call sign.
    Identification {
        /// Without the spaces at its end.
        callsign: String,
        /// As [`crate::Identification::category`].
        category: u8,
    },
    /// Operational status.
    Status {
        /// Version of the standard.
        version: u8,
        /// Class of length and width, on the ground.
        length_width_code: Option<u8>,
        /// Navigation accuracy category.
        nac_p: u8,
        /// Source integrity level.
        sil: u8,
    },
    /// Another type code.
    Other(u8),
}

/// Reads a message.
///
/// # Errors
/// If it is damaged, or no extended squitter.
pub fn read(message: &Message) -> Result<(Emitter, Reading), ModeSError> {
    let message = Message::from_octets(&message.0)?;
    let body = message.body();
    let bits = |first, count| get(&body, first, count);
    let report =
        || Report { odd: bits(22, 1) == 1, lat: bits(23, 17) as u32, lon: bits(40, 17) as u32 };
    let type_code = bits(1, 5) as u8;
    let reading = match (type_code, bits(6, 3)) {
        (5..=8, _) => {
            let movement = bits(6, 7) as u8;
            let track_deg = (bits(13, 1) == 1).then(|| bits(14, 7) as f64 * 360.0 / 128.0);
            let speed_kt = movement_speed_kt(movement);
            Reading::Surface { type_code, movement, speed_kt, track_deg, report: report() }
        }
        (9..=18, _) => {
            let steps = (bits(9, 7) << 4) | bits(17, 4);
            let fine = bits(16, 1) == 1;
            let altitude_ft = fine.then_some(steps as f64 * 25.0 - 1000.0);
            Reading::Airborne { altitude_ft, report: report() }
        }
        (19, 1) => {
            let part = |sign, first, count, step: f64| match bits(first, count) {
                0 => None,
                n => {
                    let value = (n - 1) as f64 * step;
                    Some(if bits(sign, 1) == 1 { -value } else { value })
                }
            };
            Reading::Velocity {
                east_kt: part(14, 15, 10, 1.0),
                north_kt: part(25, 26, 10, 1.0),
                climb_fpm: part(37, 38, 9, 64.0),
            }
        }
        (1..=4, number) => {
            let characters = (0..8).map(|i| match bits(9 + 6 * i, 6) as u8 {
                n @ 1..=26 => char::from(n + 64),
                n @ (32 | 48..=57) => char::from(n),
                _ => '#',
            });
            let callsign: String = characters.collect();
            let category = ((0xe - type_code) << 4) | number as u8;
            Reading::Identification { callsign: callsign.trim_end().to_owned(), category }
        }
        (31, subtype @ 0..=1) => Reading::Status {
            version: bits(41, 3) as u8,
            length_width_code: (subtype == 1).then(|| bits(21, 4) as u8),
            nac_p: bits(45, 4) as u8,
            sil: bits(51, 2) as u8,
        },
        (other, _) => Reading::Other(other),
    };
    Ok((message.emitter(), reading))
}
