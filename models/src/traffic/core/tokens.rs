//! Pieces taken and released, and who blocks whom.

use super::runway::over_s;
use super::{Core, Direction, Phase, Policy};
use crate::control::clearance::ClearanceKind;
use std::ops::Range;

/// What is taken at once.
pub(super) struct Group {
    /// Its last step.
    last: usize,
    /// Pieces that have their turn in the order with it.
    turn: Vec<u32>,
    /// Pieces that are taken, and whether for a roll.
    pieces: Vec<(u32, bool)>,
    /// Pieces that are held beside its way until the roll.
    kept: Vec<u32>,
    /// Runways that it crosses.
    pub(super) crossed: Vec<usize>,
}

impl Core {
    /// Somebody else who holds a piece that conflicts with `piece` for `m`, or rolls beside it.
    pub(super) fn blocker(&self, m: usize, piece: u32, roll: bool, gone: &[bool]) -> Option<usize> {
        if let Some(obstacle) = self.obstacle_on(piece, m) {
            return Some(obstacle);
        }
        let here = |h: &u32| *h as usize != m && !gone.get(*h as usize).copied().unwrap_or(false);
        for (other, least) in self.pieces.conflicts(piece as usize, self.movers[m].class) {
            let holds = |h: &&u32| here(h) && self.movers[**h as usize].class >= *least;
            if let Some(holder) = self.holders[*other as usize].iter().find(holds) {
                return Some(*holder as usize);
            }
        }
        if let Some(roller) = self.rolls[piece as usize].iter().find(|h| here(h)) {
            return Some(*roller as usize);
        }
        if roll {
            for beside in self.pieces.strip_beside(piece as usize) {
                if let Some(holder) = self.holders[*beside as usize].iter().find(|h| here(h)) {
                    return Some(*holder as usize);
                }
            }
        }
        None
    }

    pub(super) fn hold(&mut self, m: usize, piece: u32, roll: bool) {
        self.holders[piece as usize].push(m as u32);
        if roll {
            for i in 0..self.pieces.strip_beside(piece as usize).len() {
                let beside = self.pieces.strip_beside(piece as usize)[i];
                self.rolls[beside as usize].push(m as u32);
            }
        }
    }

    pub(super) fn release(&mut self, m: usize, piece: u32, roll: bool) {
        let drop_one = |list: &mut Vec<u32>| {
            if let Some(at) = list.iter().position(|h| *h as usize == m) {
                list.remove(at);
            }
        };
        drop_one(&mut self.holders[piece as usize]);
        if roll {
            for i in 0..self.pieces.strip_beside(piece as usize).len() {
                let beside = self.pieces.strip_beside(piece as usize)[i];
                drop_one(&mut self.rolls[beside as usize]);
            }
        }
        self.version += 1;
    }

    /// Gives back everything that it holds along its way.
    pub(super) fn release_held(&mut self, m: usize) {
        for i in self.movers[m].first_held..self.movers[m].next {
            let mover = &self.movers[m];
            let (z, roll) = (mover.way.pieces[i], mover.way.roll.contains(&i));
            self.release(m, z, roll);
        }
    }

    pub(super) fn active(&self, m: usize) -> bool {
        match self.movers[m].phase {
            Phase::Pushing
            | Phase::Starting(_)
            | Phase::Taxiing
            | Phase::LinedUp(_)
            | Phase::Rolling
            | Phase::Landing => true,
            // From its landing clearance on it holds the runway.
            Phase::Final => self.movers[m].cleared,
            _ => false,
        }
    }

    /// Whether what is left of a mover's way, from `push_from` and `from` on, is free of what the others hold
    /// after each has driven as far as what it holds already lets it.
    pub(super) fn rest_is_free(
        &self,
        m: usize,
        (push_from, from): (usize, usize),
        gone: &[bool],
        ends: &[Option<Range<usize>>],
    ) -> bool {
        let mover = &self.movers[m];
        let push = mover.push.pieces.iter().skip(push_from);
        let mut rest = push.chain(mover.way.pieces.iter().skip(from));
        rest.all(|piece| {
            let conflicts = self.pieces.conflicts(*piece as usize, mover.class);
            conflicts.iter().all(|(other, least)| {
                !self.holders[*other as usize].iter().any(|h| {
                    let h = *h as usize;
                    h != m
                        && !gone[h]
                        && self.movers[h].class >= *least
                        && ends[h].as_ref().is_none_or(|range| {
                            self.movers[h].way.pieces[range.clone()].contains(other)
                        })
                })
            })
        })
    }

    /// What a mover that has taken its way up to `next` still holds when it has driven there: indices of its
    /// way; `None` where everything that it holds counts (parked, pushed back).
    pub(super) fn held_at_end(&self, m: usize, next: usize) -> Option<Range<usize>> {
        let mover = &self.movers[m];
        let on_way = match mover.phase {
            Phase::Starting(_)
            | Phase::Taxiing
            | Phase::LinedUp(_)
            | Phase::Rolling
            | Phase::Landing => true,
            Phase::Final => mover.cleared,
            _ => false,
        };
        if !on_way || next == 0 {
            return None;
        }
        let behind_m = self.reach_m(m).1;
        if next >= mover.way.pieces.len() {
            if self.flights[m].direction == Direction::Departure {
                return Some(0..0);
            }
            let tail = mover.way.stop_m - behind_m;
            return Some(mover.way.ends_m.partition_point(|e| *e < tail)..next);
        }
        let tail = self.stop_before_m(m, next) - behind_m;
        Some(mover.way.ends_m[..next].partition_point(|e| *e < tail)..next)
    }

    pub(super) fn first_untaken(&self, m: usize) -> (usize, usize) {
        let mover = &self.movers[m];
        match mover.phase {
            Phase::Parked => (0, 0),
            Phase::Pushing => (mover.push.pieces.len(), 0),
            _ => (mover.push.pieces.len(), mover.next),
        }
    }

    /// Whether everybody can finish, one after the other, while the rest stand where they are; `m` counts as
    /// active with `push_from` and `from` as first pieces that it does not hold.
    pub(super) fn ordered(&self, m: usize, push_from: usize, from: usize) -> bool {
        let count = self.movers.len();
        let ends: Vec<Option<Range<usize>>> = (0..count)
            .map(|o| self.held_at_end(o, if o == m { from } else { self.movers[o].next }))
            .collect();
        let mut gone = vec![false; count];
        if self.rest_is_free(m, (push_from, from), &gone, &ends) {
            return true;
        }
        let mut left: Vec<usize> = (0..count).filter(|o| *o != m && self.active(*o)).collect();
        left.push(m);
        loop {
            let before = left.len();
            left.retain(|o| {
                let from = if *o == m { (push_from, from) } else { self.first_untaken(*o) };
                let free = self.rest_is_free(*o, from, &gone, &ends);
                gone[*o] |= free;
                !free
            });
            if left.is_empty() {
                return true;
            }
            if left.len() == before {
                return false;
            }
        }
    }

    /// The group that begins at `next` of the way in use; of a take-off all has its turn in the order now, and the line-up is taken.
    pub(super) fn next_group(&self, m: usize) -> Option<Group> {
        let mover = &self.movers[m];
        let first = mover.next;
        let last = mover.way.group_last.get(first).copied()?;
        let within = |(i, _): &&(usize, usize)| (first..=last).contains(i);
        let crossed = mover.way.crossings.iter().filter(within).map(|c| c.1).collect();
        let roll = &mover.way.roll;
        let lines_up = (first + 1..=last).contains(&mover.roll_from);
        let turn = mover.way.pieces[first..=last].to_vec();
        let last = if lines_up { mover.roll_from - 1 } else { last };
        let pieces = (first..=last).map(|i| (mover.way.pieces[i], roll.contains(&i))).collect();
        let kept = if lines_up { self.wanted_for_roll(m) } else { Vec::new() };
        Some(Group { last, turn, pieces, kept, crossed })
    }

    /// Has a group from now on.
    pub(super) fn seize(&mut self, m: usize, group: Group) {
        group.pieces.iter().for_each(|(z, r)| self.hold(m, *z, *r));
        self.has_taken(m, group);
        self.replaced(m);
    }

    /// A group that is held now: out of the order, and its clearances are used.
    fn has_taken(&mut self, m: usize, group: Group) {
        let Group { last, turn, kept, crossed, .. } = group;
        if self.policy == Policy::Planned {
            turn.iter().for_each(|z| self.booked_now(m, *z));
        }
        self.keep_for_roll(m, kept);
        self.movers[m].next = last + 1;
        self.movers[m].waits_since_s = None;
        self.movers[m].waits_for = None;
        if !crossed.is_empty() {
            self.used(m, ClearanceKind::Cross);
        }
        for r in crossed {
            self.end_crossing(m, r);
            self.clear(m, "CRO", self.net.runways[r].names.join("/"));
        }
    }

    /// Takes the group that begins at `next` of the way in use, if all of it is free and the policy agrees; by a person's word also
    /// where it is not.
    pub(super) fn take(&mut self, m: usize) -> bool {
        self.take_free(m) || self.take_told(m)
    }

    pub(super) fn take_free(&mut self, m: usize) -> bool {
        let mover = &self.movers[m];
        if mover.refused_at == Some(self.version) {
            return false;
        }
        let first = mover.next;
        let Some(last) = mover.way.group_last.get(first).copied() else { return false };
        let within = |(i, _): &&(usize, usize)| (first..=last).contains(i);
        let crossed: Vec<usize> = mover.way.crossings.iter().filter(within).map(|c| c.1).collect();
        let length_m = mover.way.ends_m[last] - mover.s;
        for r in crossed.iter().copied() {
            if let Some(near) = self.arrival_before(m, r, over_s(length_m)) {
                return self.refuse_now(m, near);
            }
            if let Some(near) = self.lands_towards(m, r) {
                return self.refuse_now(m, near);
            }
            if let Some(near) = self.rolls_before(m, r, 10.0 + 0.16 * length_m) {
                return self.refuse_now(m, near);
            }
            if let Some(near) = self.obstacle_on_runway(r) {
                return self.refuse_now(m, near);
            }
        }
        let Some(group) = self.next_group(m) else { return false };
        let Group { last, turn, pieces, kept, crossed } = &group;
        let blocker = pieces.iter().find_map(|(z, r)| self.blocker(m, *z, *r, &[]));
        let blocker = blocker.or_else(|| kept.iter().find_map(|z| self.blocker(m, *z, false, &[])));
        if let Some(blocker) = blocker {
            return self.refuse(m, Some(blocker));
        }
        if self.policy == Policy::Planned {
            let order_s = self.order_of(m, first);
            let before = turn.iter().find_map(|z| self.planned_before(m, *z, order_s));
            if let Some(before) = before {
                return self.refuse(m, Some(before));
            }
        }
        if !crossed.is_empty()
            && (!self.permitted(m, ClearanceKind::Cross)
                || crossed.iter().any(|r| self.bar_sticks(*r)))
        {
            return self.refuse_told(m);
        }
        pieces.iter().for_each(|(z, r)| self.hold(m, *z, *r));
        if self.policy == Policy::Ordered
            && !self.ordered(m, self.movers[m].push.pieces.len(), last + 1)
        {
            pieces.iter().for_each(|(z, r)| self.release_quietly(m, *z, *r));
            return self.refuse(m, None);
        }
        self.has_taken(m, group);
        true
    }

    pub(super) fn release_quietly(&mut self, m: usize, piece: u32, roll: bool) {
        let version = self.version;
        self.release(m, piece, roll);
        self.version = version;
    }

    /// Refused for want of a clearance.
    fn refuse_told(&mut self, m: usize) -> bool {
        self.refuse(m, None);
        self.movers[m].refused_at = None;
        false
    }

    /// Refused by the time, not by what is held: asked again at the next step.
    fn refuse_now(&mut self, m: usize, by: usize) -> bool {
        self.refuse(m, Some(by));
        self.movers[m].refused_at = None;
        false
    }

    pub(super) fn refuse(&mut self, m: usize, blocker: Option<usize>) -> bool {
        let (version, now) = (self.version, self.time_s);
        let mover = &mut self.movers[m];
        mover.refused_at = Some(version);
        mover.waits_since_s.get_or_insert(now);
        mover.waits_for = blocker;
        false
    }

    /// Waits for each other in a ring, each for more than 30 s: said once, by name.
    pub(super) fn find_deadlock(&mut self) {
        let waits = |m: usize| -> Option<usize> {
            let mover = self.movers.get(m)?;
            (self.time_s - mover.waits_since_s? >= 30.0).then_some(mover.waits_for?)
        };
        let mut found: Vec<String> = Vec::new();
        for start in 0..self.movers.len() {
            let (mut at, mut ring) = (start, vec![start]);
            while let Some(next) = waits(at) {
                if next == start {
                    if ring.iter().min() == Some(&start) {
                        let names: Vec<&str> =
                            ring.iter().map(|m| self.flights[*m].callsign.as_str()).collect();
                        let text = format!("deadlock: {} wait for each other", names.join(", "));
                        found.push(text);
                    }
                    break;
                }
                if ring.contains(&next) {
                    break;
                }
                ring.push(next);
                at = next;
            }
        }
        for text in found {
            if !self.remarks.iter().any(|r| r.text == text) {
                self.unexpected += u64::from(self.policy != Policy::Free);
                self.remark(text);
            }
        }
    }
}
