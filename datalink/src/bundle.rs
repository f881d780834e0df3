//! PDUs put into datagrams.

use std::time::{Duration, Instant};

/// How PDUs are put into datagrams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packing {
    /// Several PDUs in a datagram; `None` (the default): one PDU a datagram, which every tool reads.
    pub bundle: Option<Bundle>,
    /// Let the system cut datagrams of equal size out of one large piece (segmentation offload).
    /// Receivers see no difference.
    pub offload: bool,
}

/// Limits of a bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bundle {
    /// Octets of a datagram at most (a larger PDU goes alone).
    pub most_octets: usize,
    /// How long the first PDU of a bundle may wait for others.
    pub most_wait: Duration,
}

impl Default for Bundle {
    /// 1400 octets, which pass every Ethernet, and 5 ms.
    fn default() -> Self {
        Self { most_octets: 1400, most_wait: Duration::from_millis(5) }
    }
}

/// Octets on which each PDU of a bundle starts.
const BOUNDARY: usize = 8;

/// Datagrams ready to go, one behind the other, and the bundle that is being filled.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    pub(crate) octets: Vec<u8>,
    /// End of each ready datagram within `octets`; what follows the last is the open bundle.
    pub(crate) ends: Vec<usize>,
    pub(crate) pdus: u64,
    opened: Option<Instant>,
}

impl Queue {
    /// Adds a PDU as a datagram of its own.
    pub(crate) fn push_alone(&mut self, pdu: &[u8]) {
        self.close();
        self.octets.extend_from_slice(pdu);
        self.ends.push(self.octets.len());
        self.pdus += 1;
    }

    /// Adds a PDU to the open bundle, closing it where the PDU does not fit. A PDU that is no
    /// multiple of eight octets long can only be the last of its bundle: nothing is put in between
    /// that a receiver could take for a PDU.
    pub(crate) fn push_bundled(
        &mut self,
        pdu: &[u8],
        limits: &Bundle,
        now: impl FnOnce() -> Instant,
    ) {
        if self.open_octets() + pdu.len() > limits.most_octets {
            self.close();
        }
        if self.open_octets() == 0 {
            self.opened = Some(now());
        }
        self.octets.extend_from_slice(pdu);
        self.pdus += 1;
        let full = self.open_octets() >= limits.most_octets;
        if full || !pdu.len().is_multiple_of(BOUNDARY) {
            self.close();
        }
    }

    /// Ends the open bundle.
    pub(crate) fn close(&mut self) {
        if self.open_octets() > 0 {
            self.ends.push(self.octets.len());
        }
        self.opened = None;
    }

    /// When the open bundle was begun.
    pub(crate) fn opened(&self) -> Option<Instant> {
        self.opened
    }

    fn open_octets(&self) -> usize {
        self.octets.len() - self.ends.last().copied().unwrap_or(0)
    }

    /// Forgets the ready datagrams; the open bundle stays.
    pub(crate) fn sent(&mut self) {
        let done = self.ends.last().copied().unwrap_or(0);
        self.octets.drain(..done);
        self.ends.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[expect(clippy::disallowed_methods, reason = "a test of deadlines")]
    fn bundled(lengths: &[usize], most_octets: usize) -> Vec<usize> {
        let mut queue = Queue::default();
        let limits = Bundle { most_octets, ..Bundle::default() };
        for &n in lengths {
            queue.push_bundled(&vec![1; n], &limits, Instant::now);
        }
        queue.close();
        assert_eq!(queue.opened(), None);
        let starts = std::iter::once(&0).chain(&queue.ends);
        queue.ends.iter().zip(starts).map(|(end, start)| end - start).collect()
    }

    #[test]
    fn bundles_keep_size_and_boundaries() {
        for (name, lengths, most, expected) in [
            ("nine entity states", &[144; 10][..], 1400, &[1296, 144][..]),
            ("exactly full", &[100 * 8, 75 * 8, 8], 1400, &[1400, 8]),
            ("odd length ends its bundle", &[144, 42, 144], 1400, &[186, 144]),
            ("longer than a bundle", &[144, 3000, 144], 1400, &[144, 3000, 144]),
            ("one at a time", &[144, 144], 100, &[144, 144]),
        ] {
            assert_eq!(bundled(lengths, most), expected, "{name}");
        }
    }

    #[test]
    fn what_was_sent_is_forgotten_and_the_open_bundle_stays() {
        let mut queue = Queue::default();
        queue.push_alone(&[1; 10]);
        #[expect(clippy::disallowed_methods, reason = "a test of deadlines")]
        queue.push_bundled(&[2; 16], &Bundle::default(), Instant::now);
        queue.sent();
        assert_eq!((queue.octets.as_slice(), queue.ends.len()), (&[2; 16][..], 0));
        queue.close();
        assert_eq!(queue.ends, [16]);
    }
}
