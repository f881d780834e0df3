//! The 56 bits of a message's body, most significant first.

/// Bits in the order in which they are sent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bits {
    value: u64,
    used: u32,
}

impl Bits {
    /// Appends the lowest `bits` of `value`.
    pub(crate) fn put(mut self, value: u64, bits: u32) -> Self {
        self.value = (self.value << bits) | (value & ((1 << bits) - 1));
        self.used += bits;
        self
    }

    /// The seven octets, once all 56 bits are there.
    pub(crate) fn body(self) -> [u8; 7] {
        debug_assert_eq!(self.used, 56, "a body has 56 bits");
        let [_, body @ ..] = self.value.to_be_bytes();
        body
    }
}

/// Bits `first..first + count` (from 1, as the tables count) of a body.
pub(crate) fn get(body: &[u8; 7], first: u32, count: u32) -> u64 {
    let whole = body.iter().fold(0, |sum, octet| (sum << 8) | u64::from(*octet));
    (whole >> (57 - first - count)) & ((1 << count) - 1)
}
