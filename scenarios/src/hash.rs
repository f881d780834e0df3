//! The 64-bit hash that names a scene: FNV-1a, so the same in every process and on every host.

/// FNV-1a, 64 bits (Fowler, Noll, Vo; draft-eastlake-fnv).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds octets, preceded by their number and a tag, so that neighbours cannot run together.
    pub(crate) fn tagged(&mut self, tag: u8, octets: &[u8]) {
        self.octets(&[tag]);
        self.octets(&(octets.len() as u64).to_le_bytes());
        self.octets(octets);
    }

    /// The hash so far.
    pub(crate) fn value(self) -> u64 {
        self.0
    }

    fn octets(&mut self, octets: &[u8]) {
        for octet in octets {
            self.0 = (self.0 ^ u64::from(*octet)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
