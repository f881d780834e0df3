//! Messages of the synchronisation plane to and from octets: one version octet, then bincode.
//!
//! bincode 1.3.3 with fixed-width little-endian integers, a size limit and no trailing octets: without a
//! limit eleven hostile octets can ask for a tebibyte. PDUs never come through here.

use bincode::Options;
use serde::{Serialize, de::DeserializeOwned};

/// Raised with every incompatible change of [`super::messages`].
pub const VERSION: u8 = 11;

/// Largest message, octets.
pub const LIMIT: u64 = 8 << 20;

/// Why octets are not a message.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    /// Nothing at all.
    #[error("empty message")]
    Empty,
    /// Another version of the protocol.
    #[error("protocol version {0}, this build speaks {VERSION}: use the same build on all hosts")]
    Version(u8),
    /// Larger than the bound.
    #[error("a message of {octets} octets, where {LIMIT} are the most")]
    TooLarge {
        /// Its length.
        octets: u64,
    },
    /// Damaged or hostile.
    #[error("not a message: {0}")]
    Body(#[from] bincode::Error),
}

fn options() -> impl Options {
    bincode::DefaultOptions::new()
        .with_fixint_encoding()
        .with_little_endian()
        .with_limit(LIMIT)
        .reject_trailing_bytes()
}

/// The octets of a message.
///
/// # Errors
/// [`CodecError::TooLarge`] beyond the bound.
pub fn try_encode<T: Serialize>(message: &T) -> Result<Vec<u8>, CodecError> {
    let size = bincode::DefaultOptions::new().with_fixint_encoding().serialized_size(message)?;
    if size > LIMIT {
        return Err(CodecError::TooLarge { octets: size });
    }
    let mut octets = Vec::with_capacity(size as usize + 1);
    octets.push(VERSION);
    options().serialize_into(&mut octets, message)?;
    Ok(octets)
}

/// Longest record of a journal, octets: a message as long as any may be, and its place.
pub const RECORD_LIMIT: u64 = LIMIT + 4096;

/// The octets of a record of a journal, which belongs to one build.
///
/// # Errors
/// Beyond [`RECORD_LIMIT`].
pub fn to_record<T: Serialize>(record: &T) -> Result<Vec<u8>, CodecError> {
    Ok(options().with_limit(RECORD_LIMIT).serialize(record)?)
}

/// A record of a journal.
///
/// # Errors
/// If the octets are none of a `T`.
pub fn from_record<T: DeserializeOwned>(octets: &[u8]) -> Result<T, CodecError> {
    Ok(options().with_limit(RECORD_LIMIT).deserialize(octets)?)
}

/// Octets of a message, without the version.
#[must_use]
pub fn encoded_size<T: Serialize>(message: &T) -> usize {
    let options = bincode::DefaultOptions::new().with_fixint_encoding();
    options.serialized_size(message).map_or(usize::MAX, |size| size as usize)
}

/// Octets of a part of a message that is told in parts.
const PART_OCTETS: usize = 768 << 10;

/// Octets of a message that is told in parts, at most.
const WHOLE_OCTETS: u64 = 64 << 20;

/// First octet of a part; no version of the protocol.
const PART: u8 = 0xff;

/// Octets before those of a part: kind, version, what it is a part of, which, of how many.
const PART_HEAD: usize = 14;

/// The octets of a message, in parts where it is long.
#[must_use]
pub fn encode_parts<T: Serialize>(message: &T) -> Vec<Vec<u8>> {
    let size = encoded_size(message);
    if size <= PART_OCTETS {
        return vec![encode(message)];
    }
    let whole = options().with_limit(WHOLE_OCTETS).serialize(message);
    let whole = match whole {
        Ok(whole) => whole,
        Err(_) => {
            tracing::error!(
                "{} was not sent: it has {size} octets, where {WHOLE_OCTETS} are the most",
                std::any::type_name::<T>()
            );
            return Vec::new();
        }
    };
    let id = xxhash_rust::xxh3::xxh3_64(&whole).to_le_bytes();
    let of = whole.len().div_ceil(PART_OCTETS) as u16;
    let part = |(at, octets): (usize, &[u8])| {
        let mut part = Vec::with_capacity(PART_HEAD + octets.len());
        part.extend([PART, VERSION]);
        part.extend(id);
        part.extend((at as u16).to_le_bytes());
        part.extend(of.to_le_bytes());
        part.extend(octets);
        part
    };
    whole.chunks(PART_OCTETS).enumerate().map(part).collect()
}

/// Reads messages that may come in parts, one after the other.
#[derive(Debug, Default)]
pub struct Parts {
    id: u64,
    of: u16,
    got: std::collections::BTreeMap<u16, Vec<u8>>,
    /// Messages of which a part did not come before the next one began.
    pub lost: u64,
}

impl Parts {
    /// A message, or a part of one: what is whole now.
    ///
    /// # Errors
    /// As [`decode`].
    pub fn take<T: DeserializeOwned>(&mut self, octets: &[u8]) -> Result<Option<T>, CodecError> {
        let [PART, version, rest @ ..] = octets else { return decode(octets).map(Some) };
        if *version != VERSION {
            return Err(CodecError::Version(*version));
        }
        let damaged = || CodecError::Body(Box::new(bincode::ErrorKind::SizeLimit));
        let (id, rest) = rest.split_first_chunk::<8>().ok_or_else(damaged)?;
        let (at, rest) = rest.split_first_chunk::<2>().ok_or_else(damaged)?;
        let (of, body) = rest.split_first_chunk::<2>().ok_or_else(damaged)?;
        let (id, at, of) =
            (u64::from_le_bytes(*id), u16::from_le_bytes(*at), u16::from_le_bytes(*of));
        let most = WHOLE_OCTETS as usize / PART_OCTETS + 1;
        if at >= of || usize::from(of) > most || body.len() > PART_OCTETS {
            return Err(damaged());
        }
        if (id, of) != (self.id, self.of) {
            self.lost += u64::from(!self.got.is_empty());
            (self.id, self.of) = (id, of);
            self.got.clear();
        }
        self.got.insert(at, body.to_vec());
        if self.got.len() < usize::from(of) {
            return Ok(None);
        }
        let whole: Vec<u8> = std::mem::take(&mut self.got).into_values().flatten().collect();
        Ok(Some(options().with_limit(WHOLE_OCTETS).deserialize(&whole)?))
    }
}

/// The octets of a message that is bounded by its kind. What is too large all the same is told, and arrives as
/// an empty message, which its receiver drops: nothing ends by it.
#[must_use]
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    try_encode(message).unwrap_or_else(|e| {
        tracing::error!("{} was not sent: {e}", std::any::type_name::<T>());
        Vec::new()
    })
}

/// The message in `octets`.
///
/// # Errors
/// If it is empty, of another version, damaged, too large, or has octets left over.
pub fn decode<T: DeserializeOwned>(octets: &[u8]) -> Result<T, CodecError> {
    match octets {
        [] => Err(CodecError::Empty),
        [VERSION, body @ ..] => Ok(options().deserialize(body)?),
        [other, ..] => Err(CodecError::Version(*other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::{FrameEnds, Joined, Notice, Order, Report, Used};
    use proptest::prelude::*;

    #[test]
    fn golden_octets() {
        let grant = Order::Grant { run: 2, upto: 300 };
        let octets = encode(&grant);
        assert_eq!(octets, [11, 2, 0, 0, 0, 2, 0, 0, 0, 44, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(decode::<Order>(&octets).unwrap(), grant);
        let mut other = octets;
        other[0] = VERSION - 1;
        let refused = decode::<Order>(&other);
        assert!(matches!(refused, Err(CodecError::Version(10))), "sound but for its version");
    }

    #[test]
    fn a_length_that_lies_allocates_nothing() {
        let mut octets = encode(&Report::Ends(FrameEnds::default()));
        // Three lists of no element, no digest of a state, and that it does not go on.
        let at = octets.len() - 26;
        octets[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode::<Report>(&octets).is_err());
    }

    #[test]
    fn a_message_beyond_the_bound_is_an_error_and_no_panic() {
        let large = vec![0_u8; LIMIT as usize + 1];
        assert!(matches!(try_encode(&large), Err(CodecError::TooLarge { .. })));
        assert!(encode(&large).is_empty());
    }

    #[test]
    fn a_long_message_goes_in_parts_and_comes_whole_or_not_at_all() {
        let long: Vec<u64> = (0..900_000).collect();
        let parts = encode_parts(&long);
        assert!(parts.len() > 8 && parts.iter().all(|p| p.len() <= PART_HEAD + PART_OCTETS));
        let mut reader = Parts::default();
        // In any order, with one twice; a short one between leaves it alone.
        for part in parts[1..].iter().rev().chain(&parts[2..3]) {
            assert!(matches!(reader.take::<Vec<u64>>(part), Ok(None)));
        }
        assert_eq!(reader.take::<Vec<u64>>(&encode(&vec![1_u64])).unwrap(), Some(vec![1]));
        assert_eq!(reader.take::<Vec<u64>>(&parts[0]).unwrap(), Some(long.clone()));
        // Of one that lacks a part nothing is left.
        assert!(matches!(reader.take::<Vec<u64>>(&parts[0]), Ok(None)));
        let other = encode_parts(&long[1..].to_vec());
        for part in &other[1..] {
            assert!(matches!(reader.take::<Vec<u64>>(part), Ok(None)));
        }
        assert_eq!(reader.take::<Vec<u64>>(&other[0]).unwrap(), Some(long[1..].to_vec()));
        assert_eq!(reader.lost, 1);
        for wrong in [&[PART][..], &[PART, VERSION, 0, 0], &[PART, 1, 0], &[PART; 40]] {
            assert!(reader.take::<Vec<u64>>(wrong).is_err());
        }
        let beyond = vec![0_u64; WHOLE_OCTETS as usize / 8 + 1];
        assert!(encode_parts(&beyond).is_empty());
    }

    /// What one frame consists of may be longer than any message.
    #[test]
    fn a_frame_beyond_the_bound_is_told_in_parts_and_joined() {
        let flight = |n: u32| crate::runtime::messages::FlightNotice {
            callsign: format!("F{n}"),
            address: Some(n),
            type_designator: "A320".into(),
            wake: Some(models::flight_list::WakeCategory::Medium),
            movement: models::flight_list::MovementKind::Arrival,
            runway: "14".into(),
            stand: "B33".into(),
            stand_m: None,
            eta_ctd_ns: 0,
            off_block_ns: None,
            routing: vec!["H".into(), "L7".into()],
        };
        let flights = Notice::Flights((0..10_000).map(flight).collect());
        let ends = FrameEnds {
            run: 1,
            first: 3,
            last: 6,
            pdus: vec![(3, vec![1, 2]), (5, (0..200_000).collect()), (6, vec![3])],
            notices: vec![(4, 4, Notice::Flights(Vec::new())), (5, 9, flights)],
            used: vec![Used { of: "external-world".into(), first: 3, last: 6, sum: 5 }],
            state: Some(7),
            goes_on: false,
        };
        let parts = ends.clone().parts();
        assert!(parts.iter().all(|p| encode(&Report::Ends(p.clone())).len() < 256 << 10));
        let mut joined = Joined::default();
        let mut pieces: Vec<FrameEnds> = Vec::new();
        for (seq, part) in (1..).zip(parts) {
            if let Some((first, whole)) = joined.take(seq, part) {
                assert!(first <= seq && whole.first == pieces.last().map_or(3, |p| p.last + 1));
                pieces.push(whole);
            }
        }
        let pdus: Vec<_> = pieces.iter().flat_map(|p| p.pdus.clone()).collect();
        let notices: Vec<_> = pieces.iter().flat_map(|p| p.notices.clone()).collect();
        assert_eq!((pdus, notices), (ends.pdus, ends.notices));
        let used: Vec<_> = pieces.iter().flat_map(|p| p.used.clone()).collect();
        assert_eq!(used, ends.used);
        assert_eq!(pieces.last().map(|p| (p.last, p.state)), Some((6, Some(7))));
    }

    proptest! {
        #[test]
        fn any_octets_are_a_message_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode::<Report>(&octets);
            let _ = decode::<Order>(&octets);
        }
    }
}
