//! Octets being written.

/// Octets up to `end`, with room behind them.
#[derive(Debug, Default)]
pub(crate) struct Buffer {
    pub(crate) octets: Vec<u8>,
    pub(crate) end: usize,
}

impl Buffer {
    /// Room for so many more octets.
    #[inline]
    fn reserve(&mut self, more: usize) {
        if self.octets.len() - self.end < more {
            self.grow(more);
        }
    }

    #[cold]
    fn grow(&mut self, more: usize) {
        self.octets.resize(2 * self.end + more + 64, 0);
    }

    #[inline]
    pub(crate) fn extend(&mut self, octets: &[u8]) {
        self.reserve(octets.len());
        self.octets[self.end..self.end + octets.len()].copy_from_slice(octets);
        self.end += octets.len();
    }

    /// The top octets of a word: all eight are written, the first ones stay.
    #[inline(always)]
    pub(crate) fn word(&mut self, word: u64, octets: usize) {
        self.reserve(8);
        if let Some(place) = self.octets[self.end..].first_chunk_mut::<8>() {
            *place = word.to_be_bytes();
        }
        self.end += octets;
    }
}
