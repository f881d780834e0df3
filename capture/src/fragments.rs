//! Packets that came in pieces, put together within a bounded memory.

use crate::error::FrameFault;
use std::collections::BTreeMap;
use std::net::IpAddr;

/// Packets that may be incomplete at the same time; with one more, the oldest is given up.
const MOST_PACKETS: usize = 64;
/// Largest IP packet (RFC 791; jumbograms of IPv6 are not read).
const MOST_OCTETS: usize = 65_535;
/// Pieces that a packet may come in: the largest packet in pieces of the least allowed MTU (68).
const MOST_PIECES: usize = 1_400;

/// What pieces of one packet have in common (the protocol is always UDP).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FragmentKey {
    pub(crate) src: IpAddr,
    pub(crate) dst: IpAddr,
    pub(crate) id: u32,
}

/// A packet's payload put together.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Whole {
    pub(crate) octets: Vec<u8>,
    pub(crate) first_frame: u64,
}

#[derive(Debug)]
struct Partial {
    octets: Vec<u8>,
    /// Stretches that came, sorted, not touching each other.
    have: Vec<(usize, usize)>,
    /// Length of the whole, known once the last piece came.
    total: Option<usize>,
    first_frame: u64,
    pieces: usize,
}

/// All packets that are not whole yet.
#[derive(Debug, Default)]
pub(crate) struct Fragments {
    partial: BTreeMap<FragmentKey, Partial>,
    given_up: Vec<(u64, FrameFault)>,
}

impl Fragments {
    /// Adds the piece at `offset`; gives the packet when it is whole. Where pieces overlap, what came
    /// first stays.
    pub(crate) fn add(
        &mut self,
        key: FragmentKey,
        offset: usize,
        more: bool,
        piece: &[u8],
        frame: u64,
    ) -> Result<Option<Whole>, FrameFault> {
        let end = offset + piece.len();
        if end > MOST_OCTETS {
            return Err(FrameFault::Field { field: "IP fragment end", value: end as u32 });
        }
        if !self.partial.contains_key(&key) && self.partial.len() >= MOST_PACKETS {
            let oldest = self.partial.iter().min_by_key(|(_, p)| p.first_frame).map(|(k, _)| *k);
            if let Some(oldest) = oldest {
                self.give_up(oldest);
            }
        }
        let packet = self.partial.entry(key).or_insert_with(|| Partial {
            octets: Vec::new(),
            have: Vec::new(),
            total: None,
            first_frame: frame,
            pieces: 0,
        });
        packet.pieces += 1;
        if !more {
            packet.total = Some(end);
        }
        if packet.octets.len() < end {
            packet.octets.resize(end, 0);
        }
        packet.fill(offset, piece);
        if packet.pieces > MOST_PIECES {
            self.give_up(key);
            return Ok(None);
        }
        let whole =
            matches!((packet.total, packet.have.as_slice()), (Some(t), [(0, e)]) if *e >= t);
        if !whole {
            return Ok(None);
        }
        Ok(self.partial.remove(&key).map(|mut p| {
            p.octets.truncate(p.total.unwrap_or(p.octets.len()));
            Whole { octets: p.octets, first_frame: p.first_frame }
        }))
    }

    /// Packets given up since the last call: frame of the first piece, and what came.
    pub(crate) fn take_given_up(&mut self) -> Vec<(u64, FrameFault)> {
        std::mem::take(&mut self.given_up)
    }

    /// Gives up all that is not whole, at the end of a file.
    pub(crate) fn finish(&mut self) {
        let keys: Vec<_> = self.partial.keys().copied().collect();
        for key in keys {
            self.give_up(key);
        }
    }

    fn give_up(&mut self, key: FragmentKey) {
        if let Some(p) = self.partial.remove(&key) {
            let have = p.have.iter().map(|(a, b)| b - a).sum();
            self.given_up.push((p.first_frame, FrameFault::Unfinished { id: key.id, have }));
        }
    }
}

impl Partial {
    /// Copies what is new of `piece` and merges its stretch into the others.
    fn fill(&mut self, offset: usize, piece: &[u8]) {
        let (mut at, end) = (offset, offset + piece.len());
        for &(from, to) in &self.have {
            if to <= at || from >= end {
                continue;
            }
            if at < from {
                self.octets[at..from].copy_from_slice(&piece[at - offset..from - offset]);
            }
            at = at.max(to);
        }
        if at < end {
            self.octets[at..end].copy_from_slice(&piece[at - offset..]);
        }
        self.have.push((offset, end));
        self.have.sort_unstable();
        let mut merged: Vec<(usize, usize)> = Vec::with_capacity(self.have.len());
        for &(from, to) in &self.have {
            match merged.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => merged.push((from, to)),
            }
        }
        self.have = merged;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    fn key(id: u32) -> FragmentKey {
        let ip = IpAddr::V4(Ipv4Addr::LOCALHOST);
        FragmentKey { src: ip, dst: ip, id }
    }

    #[test]
    fn pieces_in_any_order_twice_and_overlapping_give_the_packet() {
        let packet: Vec<u8> = (0..100u8).collect();
        for (name, pieces) in [
            ("in order", vec![(0, 48), (48, 96), (96, 100)]),
            ("backwards", vec![(96, 100), (48, 96), (0, 48)]),
            ("twice", vec![(0, 48), (0, 48), (96, 100), (48, 96)]),
            ("overlapping", vec![(96, 100), (0, 64), (40, 96)]),
        ] {
            let mut fragments = Fragments::default();
            let mut whole = None;
            for (n, (from, to)) in pieces.iter().enumerate() {
                assert_eq!(whole, None, "{name}: whole too early");
                let piece = &packet[*from..*to];
                whole = fragments.add(key(7), *from, *to < 100, piece, n as u64).expect(name);
            }
            assert_eq!(whole.expect(name).octets, packet, "{name}");
            assert!(fragments.partial.is_empty(), "{name}");
        }
    }

    #[test]
    fn memory_is_bounded_and_what_is_given_up_is_told() {
        let mut fragments = Fragments::default();
        for id in 0..200 {
            fragments.add(key(id), 8, true, &[0; 8], u64::from(id)).expect("fits");
        }
        assert_eq!(fragments.partial.len(), MOST_PACKETS);
        assert_eq!(fragments.take_given_up().len(), 200 - MOST_PACKETS);
        fragments.finish();
        assert_eq!(fragments.take_given_up().len(), MOST_PACKETS);
        assert!(fragments.add(key(1), 65_528, false, &[0; 8], 0).is_err(), "beyond 65535");
    }
}
