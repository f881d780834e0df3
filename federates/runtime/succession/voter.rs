//! The voice of a member.

use super::{Candidacy, SILENT_NS, Voice, Voted, Wants};
use crate::runtime::clock::WallNs;
use std::collections::BTreeMap;

/// Askers whose withdrawals are remembered.
const REMEMBERED: usize = 16;

/// What a member has promised, for the life of its process.
#[derive(Clone, Debug, Default)]
pub struct Voter {
    fed: u128,
    inc: u64,
    epoch: u32,
    /// Who has the promise, and the processes of it that were told so, each by its last attempt.
    to: Option<u64>,
    holders: BTreeMap<u128, u32>,
    /// Attempts that were given up: a question that comes after that is late.
    withdrawn: BTreeMap<u128, u32>,
    beat_at: Option<WallNs>,
}

impl Voter {
    /// The member was accepted into federation `fed` as incarnation `inc`, by a station of `epoch`.
    pub fn enrol(&mut self, fed: u128, inc: u64, epoch: u32) {
        if fed != self.fed {
            *self = Self { fed, epoch, ..Self::default() };
        }
        self.inc = inc;
        if epoch > self.epoch {
            (self.epoch, self.to) = (epoch, None);
            self.holders.clear();
        }
    }

    /// A station was heard.
    pub fn beat(&mut self, now: WallNs) {
        self.beat_at = Some(now);
    }

    /// The answer to a station's question; none to one of another federation, or that is late.
    pub fn asked(&mut self, now: WallNs, ask: &Candidacy) -> Option<Voted> {
        let Candidacy { fed, who, by, since, attempt, wants } = *ask;
        if fed != self.fed || self.inc == 0 {
            return None;
        }
        let voted = |voice| Some(Voted { by, attempt, inc: self.inc, voice });
        let own = self.to == Some(who) && since.checked_add(1) == Some(self.epoch);
        if wants == Wants::Nothing {
            // What another process of the same was told holds, and what a later attempt was told.
            if own && self.holders.get(&by).is_some_and(|held| *held <= attempt) {
                self.holders.remove(&by);
                if self.holders.is_empty() {
                    (self.epoch, self.to) = (since, None);
                }
            }
            if self.withdrawn.len() >= REMEMBERED && !self.withdrawn.contains_key(&by) {
                self.withdrawn.pop_first();
            }
            let known = self.withdrawn.entry(by).or_default();
            *known = attempt.max(*known);
            return voted(Voice::Free);
        }
        if self.withdrawn.get(&by).is_some_and(|given_up| attempt <= *given_up) {
            return None;
        }
        if own {
            let held = self.holders.entry(by).or_default();
            *held = attempt.max(*held);
            return voted(Voice::Promised);
        }
        if self.epoch > since {
            return voted(Voice::Another(self.epoch));
        }
        let hears = self.beat_at.is_some_and(|at| now.saturating_sub(at) < SILENT_NS);
        if wants == Wants::Lead && hears {
            return voted(Voice::Beating);
        }
        (self.epoch, self.to) = (since.checked_add(1)?, Some(who));
        self.holders = BTreeMap::from([(by, attempt)]);
        voted(Voice::Promised)
    }
}
