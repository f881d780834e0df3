//! The updates of the last seconds, of all tracks, about in the order in which they were done: a scan goes through
//! the tracks in one order, so what it reads and writes here lies side by side.

use crate::time::SimTime;
use smallvec::SmallVec;
use std::ops::{Deref, DerefMut, Index, IndexMut};

/// Place of an entry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot(u32);

/// See the module's text.
#[derive(Clone, Debug)]
pub(super) struct RingOf<T> {
    entries: Vec<T>,
    /// Places that may be used again.
    free: Vec<Slot>,
}

impl<T> Default for RingOf<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), free: Vec::new() }
    }
}

impl<T> RingOf<T> {
    #[inline]
    pub(super) fn put(&mut self, entry: T) -> Slot {
        if let Some(slot) = self.free.pop() {
            self.entries[slot.0 as usize] = entry;
            return slot;
        }
        self.entries.push(entry);
        Slot(self.entries.len() as u32 - 1)
    }

    /// The entry is read no more.
    #[inline]
    pub(super) fn free(&mut self, slot: Slot) {
        self.free.push(slot);
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.free.clear();
    }
}

impl<T> Index<Slot> for RingOf<T> {
    type Output = T;

    #[inline]
    fn index(&self, slot: Slot) -> &T {
        &self.entries[slot.0 as usize]
    }
}

impl<T> IndexMut<Slot> for RingOf<T> {
    #[inline]
    fn index_mut(&mut self, slot: Slot) -> &mut T {
        &mut self.entries[slot.0 as usize]
    }
}

/// One update of a track: where it is, and the time of the filter before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slotted {
    pub(super) before: SimTime,
    pub(super) slot: Slot,
}

/// The updates of one track in the order of time.
#[derive(Clone, Debug, Default)]
pub(super) struct Past(SmallVec<[Slotted; 8]>);

impl Past {
    /// The last update whose filter before it is not later than `time`.
    #[inline]
    pub(super) fn place_at(&self, time: SimTime) -> Option<usize> {
        self.0.iter().rposition(|at| at.before <= time)
    }
}

impl Deref for Past {
    type Target = SmallVec<[Slotted; 8]>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Past {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
