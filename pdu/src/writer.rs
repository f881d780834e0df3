//! A cursor over the caller's buffer, and the errors of encoding.

use crate::wire::Wire;

/// Why a PDU cannot be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// The caller's buffer is too small; nothing was written.
    #[error("the PDU needs {needs} octets, the buffer has {has}")]
    BufferTooSmall {
        /// Octets of the PDU.
        needs: usize,
        /// Octets of the buffer.
        has: usize,
    },
    /// The PDU does not fit its 16-bit length field.
    #[error("the PDU has {octets} octets, its length field holds at most 65535")]
    TooLong {
        /// Octets of the PDU.
        octets: usize,
    },
    /// A list has more elements than its count field can hold.
    #[error("field `{field}`: {count} elements, at most {max}")]
    TooMany {
        /// The list.
        field: &'static str,
        /// Its elements.
        count: usize,
        /// What the count field holds.
        max: u64,
    },
    /// A text has more octets than its field, or characters that the field cannot hold.
    #[error("field `{field}`: {octets} octets of text, at most {max}")]
    TextTooLong {
        /// The field.
        field: &'static str,
        /// The text's octets.
        octets: usize,
        /// The field's octets.
        max: usize,
    },
    /// A record whose size must be a multiple of some octets is not.
    #[error("field `{field}`: {octets} octets do not fit the record")]
    BadSize {
        /// The field.
        field: &'static str,
        /// Its octets.
        octets: usize,
    },
}

/// A cursor over a buffer that is exactly as long as the PDU.
#[derive(Debug)]
pub struct Writer<'b> {
    out: &'b mut [u8],
    at: usize,
}

/// A number that can be a count field.
pub(crate) trait Count: Wire + TryFrom<usize> {
    const MAX: u64;
}
impl Count for u8 {
    const MAX: u64 = u8::MAX as u64;
}
impl Count for u16 {
    const MAX: u64 = u16::MAX as u64;
}
impl Count for u32 {
    const MAX: u64 = u32::MAX as u64;
}

impl<'b> Writer<'b> {
    #[inline]
    pub(crate) fn new(out: &'b mut [u8]) -> Self {
        Self { out, at: 0 }
    }

    /// Writes a value of fixed size.
    #[inline(always)]
    pub(crate) fn put<T: Wire>(&mut self, value: &T) {
        value.put(&mut self.out[self.at..self.at + T::SIZE]);
        self.at += T::SIZE;
    }

    /// Writes octets as they are.
    #[inline]
    pub(crate) fn octets(&mut self, octets: &[u8]) {
        self.out[self.at..self.at + octets.len()].copy_from_slice(octets);
        self.at += octets.len();
    }

    /// Writes `count` zeros.
    pub(crate) fn zeros(&mut self, count: usize) {
        self.out[self.at..self.at + count].fill(0);
        self.at += count;
    }

    /// Writes a count field.
    #[inline]
    pub(crate) fn count<T: Count>(
        &mut self,
        count: usize,
        field: &'static str,
    ) -> Result<(), EncodeError> {
        let value =
            T::try_from(count).map_err(|_| EncodeError::TooMany { field, count, max: T::MAX })?;
        self.put(&value);
        Ok(())
    }

    pub(crate) fn written(&self) -> usize {
        self.at
    }
}
