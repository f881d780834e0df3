//! Digests that do not depend on who did the work: sums of hashes.

use super::codec::encode;
use super::messages::{Frame, Notice};
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// A sum of hashes, one per (frame, octets): the same for any order and any division of the work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Digest {
    /// Adds one item of a frame.
    pub fn add(&mut self, frame: Frame, octets: &[u8]) {
        self.0 = self.0.wrapping_add(xxh3_64_with_seed(octets, frame));
    }
}

/// The hash that names a PDU in a frame end.
#[must_use]
pub fn pdu_hash(octets: &[u8]) -> u64 {
    xxh3_64_with_seed(octets, 0)
}

/// What a frame adds to the digest of all that its maker made: hashes of PDUs, notices with their effect frames.
/// A frame without any adds nothing.
#[must_use]
pub fn content<'a>(
    frame: Frame,
    hashes: impl Iterator<Item = u64>,
    notices: impl Iterator<Item = (Frame, &'a Notice)>,
) -> u64 {
    let mut octets: Vec<u8> = hashes.flat_map(u64::to_le_bytes).collect();
    for (effect, notice) in notices {
        octets.extend(effect.to_le_bytes());
        octets.extend(encode(notice));
    }
    if octets.is_empty() { 0 } else { xxh3_64_with_seed(&octets, frame) }
}

/// One number for a run from the digests of its parts, in the order given.
#[must_use]
pub fn combine(parts: &[u64]) -> u64 {
    let octets: Vec<u8> = parts.iter().flat_map(|p| p.to_le_bytes()).collect();
    xxh3_64_with_seed(&octets, parts.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_does_not_matter_but_content_and_frame_do() {
        let sum = |items: &[(u64, &[u8])]| {
            let mut digest = Digest::default();
            items.iter().for_each(|(frame, octets)| digest.add(*frame, octets));
            digest
        };
        assert_eq!(sum(&[(1, b"a"), (2, b"b")]), sum(&[(2, b"b"), (1, b"a")]));
        assert_ne!(sum(&[(1, b"a"), (2, b"b")]), sum(&[(1, b"b"), (2, b"a")]));
    }
}
