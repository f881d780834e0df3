//! Beast: the binary lines in which receivers hand messages on (TCP port 30005 by custom).
//!
//! `1A '3'`, six octets of a counter of 12 MHz, one of signal level, the message; every `1A` behind the first is doubled.

use crate::Message;

/// Ticks of the counter in a second.
pub const TICKS_PER_S: i64 = 12_000_000;

/// Signal level that is written: half of full scale.
pub const SIGNAL: u8 = 0x80;

/// Appends a message received at `time_ns`.
pub fn frame(out: &mut Vec<u8>, message: &Message, time_ns: i64) {
    let ticks = time_ns.div_euclid(1000) * 12 + time_ns.rem_euclid(1000) * 12 / 1000;
    out.extend_from_slice(&[0x1a, b'3']);
    let counter = &ticks.to_be_bytes()[2..];
    for octet in counter.iter().chain(&[SIGNAL]).chain(&message.0) {
        out.push(*octet);
        if *octet == 0x1a {
            out.push(0x1a);
        }
    }
}

/// Takes whole frames of long messages off the front of `buffer`: counter, signal, message octets.
///
/// Octets that begin no frame are passed over; what may still become one stays. The buffer never needs more than 64 octets.
pub fn take(buffer: &mut Vec<u8>) -> Vec<(u64, u8, [u8; 14])> {
    let mut found = Vec::new();
    let mut at = 0;
    'frames: while let Some(start) = buffer[at..].iter().position(|o| *o == 0x1a).map(|p| at + p) {
        at = start;
        let Some(kind) = buffer.get(start + 1) else { break };
        if *kind != b'3' {
            at = start + if *kind == 0x1a { 2 } else { 1 };
            continue;
        }
        let (mut body, mut place) = ([0; 21], start + 2);
        for octet in &mut body {
            let Some(value) = buffer.get(place) else { break 'frames };
            if *value == 0x1a {
                match buffer.get(place + 1) {
                    None => break 'frames,
                    Some(0x1a) => place += 1,
                    // A new frame begins within this one: this one was cut.
                    Some(_) => {
                        at = place;
                        continue 'frames;
                    }
                }
            }
            *octet = *value;
            place += 1;
        }
        let [a, b, c, d, e, f, signal, message @ ..] = body;
        found.push((u64::from_be_bytes([0, 0, a, b, c, d, e, f]), signal, message));
        at = place;
    }
    if !buffer[at..].contains(&0x1a) {
        at = buffer.len();
    }
    buffer.drain(..at);
    found
}
