//! The order that planned times make: who is before whom at a piece, and times brought up to date as the world goes on.
//!
//! The order of two movers at a piece stays while both have their plans, whatever the delays: so what each take waits for is kept
//! ([`Links`]) and found anew only where a plan has come, gone or changed its place.

use super::stacks::Stacks;
use super::{Booking, Timing};
use crate::traffic::core::{Core, Phase, Policy};
use crate::traffic::pieces::{CLASSES, Class};

/// What ends a use of a piece, in the order in which a mover comes to it: the pushback away from it, the end of the pushback over
/// it, or the release of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Ends(u32);

/// What is taken together: with the pushback, or the steps of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Taken {
    Push,
    Steps { first: u32, last: u32 },
}

/// A use of a piece by somebody who is there now.
#[derive(Clone, Copy, Debug)]
struct User {
    mover: u32,
    class: Class,
    ends: Ends,
}

/// What has to end before a take: it ends `back_s` before the front of its mover is at the end of a step, or before the take of its
/// pushback.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before {
    pub mover: u32,
    pub ends: Ends,
    /// Step, or pushback, that it is told by.
    pub told_by: Ends,
    pub back_s: f64,
}

/// A take that has not come yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub taken: Taken,
    /// Its part of [`Links::before`]: begin, length, and room for so many.
    part: (u32, u32, u32),
    /// Number of the retiming in which that was found; 0: it is to be found anew.
    pub found: u64,
}

/// The takes of a mover's plan in the order of its way, and what each waits for.
#[derive(Clone, Debug, Default)]
pub(in crate::traffic::core) struct Links {
    /// Number of the plan, 0 without one, and of the retiming before which it came.
    plan: u64,
    pub(super) since: u64,
    pub(super) takes: Vec<Link>,
    before: Vec<Before>,
    /// Pieces on which it has bookings.
    booked: Vec<u32>,
}

impl Ends {
    pub(super) const LEAVING: Self = Self(0);
    pub(super) const PUSHED: Self = Self(1);
    /// After all.
    pub(super) const LAST: Self = Self(u32::MAX);

    pub(super) fn step(k: usize) -> Self {
        Self(k as u32 + 2)
    }

    /// Its step; `None`: the pushback.
    pub(super) fn of_step(self) -> Option<usize> {
        self.0.checked_sub(2).map(|k| k as usize)
    }
}

impl Links {
    /// Puts down what a take waits for.
    pub(super) fn put(&mut self, take: usize, found: Vec<Before>, retimed: u64) {
        let link = &mut self.takes[take];
        let (begin, _, room) = link.part;
        let count = found.len() as u32;
        link.found = retimed;
        if count <= room {
            link.part.1 = count;
            self.before[begin as usize..][..found.len()].copy_from_slice(&found);
        } else {
            link.part = (self.before.len() as u32, count, count);
            self.before.extend(found);
        }
    }

    /// What a take of these waits for.
    pub(super) fn before_of(&self, link: &Link) -> &[Before] {
        let (begin, count, _) = link.part;
        &self.before[begin as usize..][..count as usize]
    }
}

impl Timing {
    /// What the end of a use is told by, and how long before that it is; `None`: it stays for ever.
    fn told_by(&self, ends: Ends) -> Option<(Ends, f64)> {
        match ends.of_step() {
            None if ends == Ends::LEAVING => Some((Ends::PUSHED, 0.0)),
            None => Some((Ends::PUSHED, -self.push_s.1)),
            Some(k) => self.release[k].map(|(at, back_s)| (Ends::step(at), back_s)),
        }
    }

    /// Its place in the order by what is taken; after all others without a plan for that.
    fn key(&self, taken: Ends) -> f64 {
        match taken.of_step() {
            Some(k) if k >= self.pushed => self.order_s.get(k).copied().unwrap_or(f64::INFINITY),
            _ if self.planned => self.push_take_s,
            _ => f64::INFINITY,
        }
    }
}

impl Link {
    /// What its place in the order is told by.
    fn key(&self) -> Ends {
        match self.taken {
            Taken::Push => Ends::PUSHED,
            Taken::Steps { first, .. } => Ends::step(first as usize),
        }
    }
}

impl Core {
    /// Times of all plans as the world is now, in the order that they have; `false`, with the times as they were,
    /// if that order has a cycle.
    pub(in crate::traffic::core) fn retime(&mut self) -> bool {
        self.book();
        self.retimed += 1;
        let there = self.there();
        let (mut links, mut times) =
            (std::mem::take(&mut self.links), std::mem::take(&mut self.times));
        let settled = self.settle(&mut links, &there, &mut times);
        if settled {
            self.set_times(&times);
        }
        (self.links, self.times) = (links, times);
        settled
    }

    /// Brings the order lists of the pieces up to date with the plans.
    pub(in crate::traffic::core) fn book(&mut self) {
        self.links.resize_with(self.movers.len(), Links::default);
        for m in 0..self.movers.len() {
            let (mover, links) = (&self.movers[m], &mut self.links[m]);
            let plan = if mover.timing.planned { mover.timing.number } else { 0 };
            if links.plan != plan {
                links.plan = plan;
                self.link(m);
            }
        }
        self.version += 1;
    }

    /// Puts the takes of a mover's plan down, in place of what it had before. Whoever comes after it at a piece finds anew what
    /// it waits for.
    fn link(&mut self, m: usize) {
        let mut links = std::mem::take(&mut self.links[m]);
        let key = m as u32;
        for z in links.booked.drain(..) {
            self.books[z as usize].retain(|b| b.mover != key);
        }
        links.since = self.retimed + 1;
        links.takes.clear();
        links.before.clear();
        let mover = &self.movers[m];
        let t = &mover.timing;
        if links.plan != 0 {
            let open = self.open_steps(m);
            let takes = &mut links.takes;
            let mut put = |taken| takes.push(Link { taken, part: (0, 0, 0), found: 0 });
            let mut books = Vec::new();
            let held = if mover.phase == Phase::Parked {
                put(Taken::Push);
                let under = mover.way.pieces[t.first..t.pushed].iter().enumerate();
                books.extend(mover.push.pieces.iter().map(|z| (*z, Ends::PUSHED)));
                books.extend(under.map(|(i, z)| (*z, Ends::step(t.first + i))));
                open.start
            } else {
                if mover.phase == Phase::Pushing { t.first } else { mover.first_held }
            };
            let mut k = open.start;
            while k < open.end {
                let last = self.last_with(m, k);
                put(Taken::Steps { first: k as u32, last: last as u32 });
                k = last + 1;
            }
            books.extend(open.clone().map(|k| (mover.way.pieces[k], Ends::step(k))));
            for (z, taken) in books {
                let list = &mut self.books[z as usize];
                let at = list.partition_point(|b| (b.mover, b.taken) <= (key, taken));
                list.insert(at, Booking { mover: key, taken });
                links.booked.push(z);
            }
            let there = mover.way.pieces.get(held..open.start).unwrap_or_default();
            let parked = mover.parked_pieces.iter().chain(&mover.push.pieces);
            let all: Vec<u32> = parked.chain(there).chain(&links.booked).copied().collect();
            all.into_iter().for_each(|z| self.find_anew(m, z));
        }
        self.links[m] = links;
    }

    /// Whoever is to take what conflicts with a piece finds anew what it waits for.
    fn find_anew(&mut self, m: usize, piece: u32) {
        for class in 0..CLASSES {
            for (other, _) in self.pieces.conflicts(piece as usize, class as Class) {
                for b in self.books[*other as usize].iter().filter(|b| b.mover as usize != m) {
                    let takes = &mut self.links[b.mover as usize].takes;
                    let after = takes.partition_point(|l| l.key() <= b.taken);
                    // What is under a mover when it has been pushed back is taken with the pushback.
                    if let Some(link) = takes.get_mut(after.saturating_sub(1)) {
                        link.found = 0;
                    }
                }
            }
        }
    }

    /// Its place in the order has changed: what it waits for, and who waits for it, is found anew.
    pub(in crate::traffic::core) fn replaced(&mut self, m: usize) {
        self.plans += 1;
        self.movers[m].timing.number = self.plans;
    }

    /// Uses of pieces that end some time, of those who are there now and have a plan.
    fn there(&self) -> There {
        let mut users = Stacks::new(self.pieces.list.len());
        let mut by_mover: Vec<_> = self.links.iter().map(|l| (Ends::LAST, l.since)).collect();
        for (m, mover) in self.movers.iter().enumerate().filter(|(_, m)| m.timing.planned) {
            let (open, t) = (self.open_steps(m), &mover.timing);
            let mut put = |z: u32, ends: Ends| {
                if t.told_by(ends).is_some() {
                    users.put(z as usize, User { mover: m as u32, class: mover.class, ends });
                }
            };
            let steps = match mover.phase {
                Phase::Parked => {
                    by_mover[m].0 = Ends::LEAVING;
                    mover.parked_pieces.iter().for_each(|z| put(*z, Ends::LEAVING));
                    continue;
                }
                Phase::Pushing => {
                    by_mover[m].0 = Ends::PUSHED;
                    mover.push.pieces.iter().for_each(|z| put(*z, Ends::PUSHED));
                    t.first
                }
                Phase::Gone | Phase::Docked | Phase::Absent | Phase::GoAround => continue,
                _ => {
                    by_mover[m].0 = Ends::step(mover.first_held);
                    mover.first_held
                }
            };
            let held = steps..open.start.min(mover.way.pieces.len());
            held.for_each(|k| put(mover.way.pieces[k], Ends::step(k)));
        }
        There { users, by_mover }
    }

    /// What a take waits for: whoever is there now, and of the others where the order says who of them goes first only the last, who
    /// ends after the ones before him.
    pub(super) fn before_take(&self, m: usize, link: &Link, there: &There) -> Vec<Before> {
        let (mover, mut before) = (&self.movers[m], Vec::new());
        let place = (mover.timing.key(link.key()), m as u32);
        for z in self.taken_with(m, link.taken).into_iter().flatten() {
            for (other, least) in self.pieces.conflicts(*z as usize, mover.class) {
                if !self.in_order(*z, *other) {
                    continue;
                }
                let counts = |u: &&User| u.mover as usize != m && u.class >= *least;
                for u in there.users.of(*other as usize).filter(counts) {
                    before.extend(self.before(u.mover, u.ends));
                }
                let booked = |b: &&Booking| {
                    let o = &self.movers[b.mover as usize];
                    b.mover as usize != m
                        && o.class >= *least
                        && (o.timing.key(b.taken), b.mover) < place
                        && o.timing.told_by(b.taken).is_some()
                };
                let list = &self.books[*other as usize];
                let at = |b: &Booking| self.movers[b.mover as usize].timing.key(b.taken);
                let last = list
                    .iter()
                    .filter(booked)
                    .max_by(|p, q| at(p).total_cmp(&at(q)).then(p.mover.cmp(&q.mover)))
                    .filter(|_| self.in_order(*other, *other))
                    .map(|b| b.mover);
                for b in list.iter().filter(|b| last.is_none_or(|o| o == b.mover)).filter(booked) {
                    before.extend(self.before(b.mover, b.taken));
                }
            }
        }
        before
    }

    fn before(&self, mover: u32, ends: Ends) -> Option<Before> {
        let (told_by, back_s) = self.movers[mover as usize].timing.told_by(ends)?;
        Some(Before { mover, ends, told_by, back_s })
    }

    /// Pieces that are taken together, and those that are under the mover then.
    fn taken_with(&self, m: usize, taken: Taken) -> [&[u32]; 2] {
        let mover = &self.movers[m];
        match taken {
            Taken::Push => {
                let t = &mover.timing;
                [&mover.push.pieces, &mover.way.pieces[t.first..t.pushed]]
            }
            Taken::Steps { first, last } => {
                [&mover.way.pieces[first as usize..=last as usize], &[]]
            }
        }
    }

    /// Last step of the group that begins with a step.
    fn last_with(&self, m: usize, first: usize) -> usize {
        let way = &self.movers[m].way;
        way.group_last[first].min(way.pieces.len() - 1).max(first)
    }

    /// Who is planned before `m` at a piece that conflicts with `piece`, and has not come yet.
    pub(in crate::traffic::core) fn planned_before(
        &self,
        m: usize,
        piece: u32,
        order_s: f64,
    ) -> Option<usize> {
        let class = self.movers[m].class;
        let conflicts = self.pieces.conflicts(piece as usize, class).iter();
        for (other, least) in conflicts.filter(|c| self.in_order(piece, c.0)) {
            for b in &self.books[*other as usize] {
                let o = b.mover as usize;
                let theirs = &self.movers[o];
                let earlier = o != m && (theirs.timing.key(b.taken), o) < (order_s, m);
                if earlier && theirs.class >= *least {
                    return Some(o);
                }
            }
        }
        None
    }

    /// Planned take of the next group, for the order.
    pub(in crate::traffic::core) fn order_of(&self, m: usize, step: usize) -> f64 {
        self.movers[m].timing.order_s.get(step).copied().unwrap_or(f64::INFINITY)
    }

    /// A booking that has become a hold.
    pub(in crate::traffic::core) fn booked_now(&mut self, m: usize, piece: u32) {
        let list = &mut self.books[piece as usize];
        if let Some(first) = list.iter().position(|b| b.mover as usize == m) {
            list.remove(first);
        }
    }

    /// Puts a landing first at the pieces of its exit, if the order of the others allows that.
    pub(in crate::traffic::core) fn land_first(&mut self, m: usize) -> bool {
        if self.policy != Policy::Planned || !self.movers[m].timing.planned {
            return false;
        }
        let first = self.movers[m].next;
        let last = self.movers[m].way.group_last.get(first).copied().unwrap_or(first);
        let old = self.movers[m].timing.order_s.clone();
        let now = self.time_s - 1.0;
        self.movers[m].timing.order_s[first..=last].fill(now);
        self.replaced(m);
        if self.retime() {
            return true;
        }
        self.movers[m].timing.order_s = old;
        self.replaced(m);
        self.book();
        false
    }
}

/// Who is where now.
pub(super) struct There {
    users: Stacks<User>,
    /// By mover: its first use that has not ended yet; the retiming before which its plan came or went.
    pub by_mover: Vec<(Ends, u64)>,
}
