//! Messages of the synchronisation plane to and from octets: one version octet, then bincode.
//!
//! bincode 1.3.3 with fixed-width little-endian integers, a size limit and no trailing octets: without a
//! limit eleven hostile octets can ask for a tebibyte. PDUs never come through here.

use bincode::Options;
use serde::{Serialize, de::DeserializeOwned};

/// Raised with every incompatible change of [`super::messages`].
pub const VERSION: u8 = 2;

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
    use crate::runtime::messages::{FrameEnds, Order, Report};
    use proptest::prelude::*;

    #[test]
    fn golden_octets() {
        let grant = Order::Grant { run: 2, upto: 300 };
        let octets = encode(&grant);
        assert_eq!(octets, [2, 2, 0, 0, 0, 2, 0, 0, 0, 44, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(decode::<Order>(&octets).unwrap(), grant);
    }

    #[test]
    fn a_length_that_lies_allocates_nothing() {
        let mut octets = encode(&Report::Ends(FrameEnds::default()));
        // Two lists of no element, and no digest of a state.
        let at = octets.len() - 17;
        octets[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode::<Report>(&octets).is_err());
    }

    #[test]
    fn a_message_beyond_the_bound_is_an_error_and_no_panic() {
        let large = vec![0_u8; LIMIT as usize + 1];
        assert!(matches!(try_encode(&large), Err(CodecError::TooLarge { .. })));
        assert!(encode(&large).is_empty());
    }

    proptest! {
        #[test]
        fn any_octets_are_a_message_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode::<Report>(&octets);
            let _ = decode::<Order>(&octets);
        }
    }
}
