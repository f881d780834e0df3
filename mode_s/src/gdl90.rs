//! GDL 90 messages, as displays in cockpits take them from a receiver: heartbeat and traffic reports.
//!
//! Source: GDL 90 Data Interface Specification, 560-1058-00 Rev A (Garmin, 2007). A message stands between two flags (7E); 7D and 7E within
//! it are escaped by 7D and bit 5 turned; its last two octets are a CRC (x¹⁶ + x¹² + x⁵ + 1, begun with 0), low octet first.

use crate::{FOOT_M, Target};

/// What begins and ends a message.
const FLAG: u8 = 0x7e;
/// What goes before an octet that is a flag or this.
const ESCAPE: u8 = 0x7d;

/// Octets of a heartbeat and of a traffic report before they are framed.
pub const HEARTBEAT: usize = 7;
/// See [`HEARTBEAT`].
pub const TRAFFIC: usize = 28;

/// Adds a heartbeat: that the receiver works and knows where it is, and the time of day, s of UTC.
pub fn heartbeat(out: &mut Vec<u8>, second_of_day: u32) {
    let second = second_of_day % 86_400;
    let [low, high] = (second as u16).to_le_bytes();
    // Position valid, initialised; bit 16 of the time, time is of UTC. Received messages are not counted.
    framed(out, &[0, 0x81, ((second >> 16) as u8) << 7 | 1, low, high, 0, 0]);
}

/// Adds a traffic report of a target. No alert is ever set: displays would raise it.
pub fn traffic(out: &mut Vec<u8>, target: &Target) {
    let mut octets = [0; TRAFFIC];
    // ADS-B with an address of ICAO, one of its own making, or of a vehicle.
    let kind = match (target.emitter.format, target.emitter.capability) {
        (18, 1) => 1,
        (18, _) => 4,
        _ => 0,
    };
    (octets[0], octets[1]) = (20, kind);
    octets[2..5].copy_from_slice(&target.emitter.address.to_be_bytes()[1..]);
    octets[5..8].copy_from_slice(&angle(target.lat_deg));
    octets[8..11].copy_from_slice(&angle(target.lon_deg));
    // 25 ft from −1000 ft on; 4095 is unknown.
    let altitude = libm::round((target.pressure_altitude_m / FOOT_M + 1000.0) / 25.0);
    let altitude = if altitude.is_finite() { altitude.clamp(0.0, 4094.0) as u16 } else { 4095 };
    // In the air, and what the angle below is: 1 course, 3 true heading.
    let course = if target.moves() { 1 } else { 3 };
    let misc = u16::from(!target.on_ground) << 3 | course;
    octets[11..13].copy_from_slice(&(altitude << 4 | misc).to_be_bytes());
    // Containment radius below 185 m, as the squitters say.
    octets[13] = 8 << 4 | target.nac_p.min(11);
    // Each of 12 bits: knots, and 64 ft/min up or down; the last values are unknown.
    let speed = libm::round(target.speed_kt());
    let speed = if speed.is_finite() { speed.clamp(0.0, 4094.0) as u32 } else { 4095 };
    let climb = libm::round(target.velocity_mps[2] / FOOT_M * 60.0 / 64.0);
    let climb =
        if climb.is_finite() { climb.clamp(-510.0, 510.0) as i32 as u32 & 0xfff } else { 0x800 };
    octets[14..17].copy_from_slice(&(speed << 12 | climb).to_be_bytes()[1..]);
    octets[17] = (libm::round(target.track_deg() / 360.0 * 256.0) as i64).rem_euclid(256) as u8;
    octets[18] = category(target.category);
    for (octet, letter) in octets[19..27].iter_mut().zip(letters(&target.callsign)) {
        *octet = letter;
    }
    framed(out, &octets);
}

/// Degrees in 24 bits, half a turn 2²³.
fn angle(degrees: f64) -> [u8; 3] {
    let raw = libm::round(degrees / 180.0 * f64::from(1 << 23));
    let raw = raw.clamp(-f64::from(1 << 23), f64::from((1 << 23) - 1)) as i32;
    let [_, octets @ ..] = raw.to_be_bytes();
    octets
}

/// The emitter category of a squitter (A1, C2, …) in one number.
fn category(squitter: u8) -> u8 {
    match (squitter >> 4, squitter & 7) {
        (0xa, n) => n,
        (0xb, n @ 1..) => n + 8,
        (0xc, n @ 1..) => n + 16,
        _ => 0,
    }
}

/// Eight capital letters, figures and blanks.
fn letters(callsign: &str) -> impl Iterator<Item = u8> {
    let sound = |c: &u8| c.is_ascii_uppercase() || c.is_ascii_digit();
    let text: Vec<u8> = callsign.bytes().map(|c| c.to_ascii_uppercase()).filter(sound).collect();
    text.into_iter().chain(std::iter::repeat(b' ')).take(8)
}

fn framed(out: &mut Vec<u8>, message: &[u8]) {
    out.push(FLAG);
    for octet in message.iter().copied().chain(crc(message).to_le_bytes()) {
        if octet == FLAG || octet == ESCAPE {
            out.extend([ESCAPE, octet ^ 0x20]);
        } else {
            out.push(octet);
        }
    }
    out.push(FLAG);
}

/// The specification's own: the octet comes in at the low end, after the turn.
fn crc(message: &[u8]) -> u16 {
    let turned = |high: u16| {
        (0..8).fold(high << 8, |c, _| if c & 0x8000 == 0 { c << 1 } else { c << 1 ^ 0x1021 })
    };
    message.iter().fold(0, |crc, octet| turned(crc >> 8) ^ crc << 8 ^ u16::from(*octet))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Emitter, KNOT_MPS};

    fn hex(octets: &[u8]) -> String {
        octets.iter().map(|octet| format!("{octet:02x}")).collect()
    }

    /// The messages between the flags, escapes undone, without their CRC, which is checked.
    fn messages(octets: &[u8]) -> Vec<Vec<u8>> {
        let parts = octets.split(|octet| *octet == FLAG).filter(|part| !part.is_empty());
        let plain = |part: &[u8]| {
            let (mut plain, mut escaped) = (Vec::new(), false);
            for octet in part {
                match octet {
                    &ESCAPE => escaped = true,
                    octet => {
                        plain.push(if std::mem::take(&mut escaped) { octet ^ 0x20 } else { *octet })
                    }
                }
            }
            let sum = plain.split_off(plain.len() - 2);
            assert_eq!(u16::from_le_bytes([sum[0], sum[1]]), crc(&plain));
            plain
        };
        parts.map(plain).collect()
    }

    fn target() -> Target {
        let lsb = 180.0 / f64::from(1 << 23);
        Target {
            emitter: Emitter::aircraft(0xab_4549, true),
            callsign: "N825V".into(),
            category: 0xa1,
            lat_deg: f64::from(0x1f_ef15) * lsb,
            lon_deg: f64::from(0xa8_8978 - (1 << 24)) * lsb,
            pressure_altitude_m: 5000.0 * FOOT_M,
            velocity_mps: [
                123.0 * KNOT_MPS * std::f64::consts::FRAC_1_SQRT_2,
                123.0 * KNOT_MPS * std::f64::consts::FRAC_1_SQRT_2,
                64.0 * FOOT_M / 60.0,
            ],
            heading_deg: 45.0,
            on_ground: false,
            size_m: [8.0, 11.0],
            nac_p: 9,
        }
    }

    /// Section 2.2.4 of the specification: octets and their CRC.
    #[test]
    fn the_sum_is_that_of_the_specification() {
        assert_eq!(crc(&[0x00, 0x81, 0x41, 0xdb, 0xd0, 0x08, 0x02]), 0x8bb3);
    }

    /// Section 3.5.4: a light aircraft at 5000 ft, 123 kt to the north-east, 64 ft/min up. There its containment is below 25 m (10); we say 8.
    #[test]
    fn a_traffic_report_is_the_example_of_the_specification() {
        let mut out = Vec::new();
        traffic(&mut out, &target());
        let [message] = &messages(&out)[..] else { panic!("one") };
        let example = "1400ab45491fef15a889780f09a907b00120014e383235562020200000";
        assert_eq!(hex(message), example[..56].replacen("09a907b0", "098907b0", 1));
    }

    #[test]
    fn a_heartbeat_has_the_second_of_the_day_in_seventeen_bits() {
        for (second, octets) in [
            (0, "00810100000000"),
            (53_467, "008101dbd00000"),
            (65_536, "00818100000000"),
            (86_399, "0081817f510000"),
            (86_400, "00810100000000"),
        ] {
            let mut out = Vec::new();
            heartbeat(&mut out, second);
            assert_eq!(
                messages(&out).iter().map(|m| hex(m)).collect::<Vec<_>>(),
                [octets],
                "{second}"
            );
        }
    }

    #[test]
    fn a_vehicle_that_stands_has_its_heading_and_no_height_in_the_air() {
        let stands = Target {
            emitter: Emitter::vehicle(0x7e_7d01),
            callsign: "follow-1".into(),
            category: 0xc2,
            velocity_mps: [0.0; 3],
            heading_deg: 359.9,
            on_ground: true,
            pressure_altitude_m: f64::NAN,
            ..target()
        };
        let mut out = Vec::new();
        traffic(&mut out, &stands);
        assert!(out[1..out.len() - 1].iter().all(|octet| *octet != FLAG), "it is escaped");
        let message = &messages(&out)[0];
        assert_eq!(&message[1..5], [4, 0x7e, 0x7d, 0x01]);
        assert_eq!((&message[11..13], message[17], message[18]), (&[0xff, 0xf3][..], 0, 18));
        assert_eq!(&message[19..27], b"FOLLOW1 ");
    }

    #[test]
    fn what_no_report_can_say_is_clipped_or_unknown() {
        for (lat_deg, altitude_m, up_mps, raw) in [
            (90.0, 1e9, 1e9, ("400000", 0xffe, 0x1fe)),
            (-90.0, -1e9, -1e9, ("c00000", 0, 0xe02)),
            (0.0, 0.0, f64::NAN, ("000000", 40, 0x800)),
        ] {
            let velocity_mps = [0.0, 10.0, up_mps];
            let target = Target {
                lat_deg,
                pressure_altitude_m: altitude_m,
                velocity_mps,
                lon_deg: 180.0,
                ..target()
            };
            let mut out = Vec::new();
            traffic(&mut out, &target);
            let message = &messages(&out)[0];
            let twelve = |high: u8, low: u8| u16::from(high) << 8 | u16::from(low);
            let told = (
                hex(&message[5..8]),
                twelve(message[11], message[12]) >> 4,
                twelve(message[15], message[16]) & 0xfff,
            );
            assert_eq!((&told.0[..], told.1, told.2), raw);
            assert_eq!(hex(&message[8..11]), "7fffff");
        }
    }
}
