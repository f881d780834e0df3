//! One squitter: format, address, body, parity.

use std::fmt::Write as _;

/// What cannot be written or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModeSError {
    /// A value that no message can carry.
    #[error("{quantity} is {value}; {allowed}")]
    Value {
        /// Which.
        quantity: &'static str,
        /// What it was.
        value: f64,
        /// What would do.
        allowed: &'static str,
    },
    /// Not the octets of one squitter.
    #[error("{0} octets; an extended squitter has 14")]
    Length(usize),
    /// Not hexadecimal.
    #[error("not hexadecimal: {0}")]
    Hex(String),
    /// Damaged.
    #[error("parity of {found:06x} where {expected:06x} belongs: the message is damaged")]
    Parity {
        /// In the message.
        found: u32,
        /// Of its first 88 bits.
        expected: u32,
    },
    /// Another downlink format.
    #[error("downlink format {0}; extended squitters are 17 and 18")]
    Format(u8),
}

/// Who sends: the first four octets of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emitter {
    /// 24-bit address.
    pub address: u32,
    /// Downlink format: 17 for transponders, 18 for vehicles and for addresses that are none of ICAO's.
    pub format: u8,
    /// Capability (17: 4 on the ground, 5 in the air) or control field (18: 0 address of ICAO, 1 another).
    pub capability: u8,
}

impl Emitter {
    /// A transponder.
    #[must_use]
    pub fn aircraft(address: u32, on_ground: bool) -> Self {
        Self { address, format: 17, capability: if on_ground { 4 } else { 5 } }
    }

    /// A vehicle's emitter.
    #[must_use]
    pub fn vehicle(address: u32) -> Self {
        Self { address, format: 18, capability: 0 }
    }

    /// An emitter whose address is invented.
    #[must_use]
    pub fn anonymous(address: u32) -> Self {
        Self { address, format: 18, capability: 1 }
    }
}

/// An extended squitter: 112 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message(pub [u8; 14]);

impl Message {
    /// A message of a sender with this body; the parity is added.
    #[must_use]
    pub fn new(emitter: Emitter, body: [u8; 7]) -> Self {
        let mut octets = [0; 14];
        octets[0] = (emitter.format << 3) | (emitter.capability & 7);
        octets[1..4].copy_from_slice(&emitter.address.to_be_bytes()[1..]);
        octets[4..11].copy_from_slice(&body);
        let parity = parity(&octets[..11]);
        octets[11..].copy_from_slice(&parity.to_be_bytes()[1..]);
        Self(octets)
    }

    /// Who sent it.
    #[must_use]
    pub fn emitter(&self) -> Emitter {
        let [first, a, b, c, ..] = self.0;
        Emitter {
            address: u32::from_be_bytes([0, a, b, c]),
            format: first >> 3,
            capability: first & 7,
        }
    }

    /// The 56 bits between address and parity.
    #[must_use]
    pub fn body(&self) -> [u8; 7] {
        let mut body = [0; 7];
        body.copy_from_slice(&self.0[4..11]);
        body
    }

    /// The octets as text.
    #[must_use]
    pub fn hex(&self) -> String {
        self.0.iter().fold(String::with_capacity(28), |mut text, octet| {
            write!(text, "{octet:02x}").ok(); // a String takes everything
            text
        })
    }

    /// Checks length, parity and format.
    ///
    /// # Errors
    /// If one of them is not that of an extended squitter.
    pub fn from_octets(octets: &[u8]) -> Result<Self, ModeSError> {
        let whole: [u8; 14] = octets.try_into().map_err(|_| ModeSError::Length(octets.len()))?;
        let expected = parity(&whole[..11]);
        let found = u32::from_be_bytes([0, whole[11], whole[12], whole[13]]);
        if found != expected {
            return Err(ModeSError::Parity { found, expected });
        }
        match whole[0] >> 3 {
            17 | 18 => Ok(Self(whole)),
            other => Err(ModeSError::Format(other)),
        }
    }

    /// The same from text.
    ///
    /// # Errors
    /// If it is not hexadecimal, or no extended squitter.
    pub fn from_hex(text: &str) -> Result<Self, ModeSError> {
        let refuse = || ModeSError::Hex(text.chars().take(40).collect());
        if !text.is_ascii() || !text.len().is_multiple_of(2) {
            return Err(refuse());
        }
        let pairs = (0..text.len() / 2).map(|i| u8::from_str_radix(&text[2 * i..2 * i + 2], 16));
        let octets: Result<Vec<u8>, _> = pairs.collect();
        Self::from_octets(&octets.map_err(|_| refuse())?)
    }
}

/// Remainder of the bits by the generator 0x1FFF409.
fn parity(octets: &[u8]) -> u32 {
    let mut rest = 0_u32;
    for octet in octets {
        rest ^= u32::from(*octet) << 16;
        for _ in 0..8 {
            rest <<= 1;
            if rest & 0x100_0000 != 0 {
                rest ^= 0x1ff_f409;
            }
        }
    }
    rest & 0xff_ffff
}
