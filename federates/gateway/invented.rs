//! Addresses for who has none.

use std::collections::{BTreeMap, BTreeSet};

/// First of the invented addresses, and how many there are: the last of all 24-bit addresses is that of everybody.
const FIRST: u32 = 0xf0_0000;
const COUNT: u32 = 0x0f_ffff;
/// Most that are kept.
const MOST: usize = 65_536;

/// Who was given which address: each his own, for as long as this lives.
#[derive(Clone, Debug)]
pub struct Invented<K> {
    given: BTreeMap<K, u32>,
    taken: BTreeSet<u32>,
}

impl<K> Default for Invented<K> {
    fn default() -> Self {
        Self { given: BTreeMap::new(), taken: BTreeSet::new() }
    }
}

impl<K: Ord> Invented<K> {
    /// His address; of a new one F00000 + `wish`, or the next that nobody has. None where too many have one.
    pub fn of(&mut self, who: K, wish: u32) -> Option<u32> {
        if let Some(address) = self.given.get(&who) {
            return Some(*address);
        }
        if self.given.len() >= MOST {
            return None;
        }
        let address = |n| FIRST + wish.wrapping_add(n) % COUNT;
        let address = (0..COUNT).map(address).find(|a| !self.taken.contains(a))?;
        self.taken.insert(address);
        self.given.insert(who, address);
        Some(address)
    }

    /// The address that he was given.
    pub fn given(&self, who: &K) -> Option<u32> {
        self.given.get(who).copied()
    }
}
