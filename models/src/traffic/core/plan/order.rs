//! The order that planned times make: brought up to date as the world goes on, and who is before whom at a piece.

use super::stacks::Stacks;
use super::{Booking, LANDING_AHEAD_S, PAUSE_S, Timing};
use crate::traffic::core::{Core, Phase, Policy};
use crate::traffic::pieces::Class;

/// What is taken together: with the pushback, or the steps of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Taken {
    Push,
    From(usize),
}

/// A use of a piece, and what ends it.
#[derive(Clone, Copy, Debug)]
struct User {
    mover: u32,
    class: Class,
    ends: Ends,
}

/// Who uses each piece, and leaves it again.
struct Users {
    /// Has it now.
    there: Stacks<User>,
    /// Takes it with a group that comes before the one at hand.
    planned: Stacks<User>,
}

/// What ends a use: the pushback away from it, the end of the pushback over it, or the release of a step.
#[derive(Clone, Copy, Debug)]
enum Ends {
    Leaving,
    Pushed,
    Step(u32),
}

impl Timing {
    fn ends_s(&self, ends: Ends) -> f64 {
        match ends {
            Ends::Leaving => self.push_take_s,
            Ends::Pushed => self.push_take_s + self.push_s.1,
            Ends::Step(k) => self.release_s(k as usize),
        }
    }
}

/// All that is to be taken, in its order, and what each waits for.
struct Sequence {
    groups: Vec<(f64, usize, Taken)>,
    /// Of all groups one after the other: movers and what of theirs has to end before.
    before: Vec<(u32, Ends)>,
    /// By group: where its part of that ends.
    ends: Vec<usize>,
}

impl Core {
    /// Times of all plans as the world is now, in the order that they have; `false`, with the times as they were,
    /// if that order has a cycle.
    pub(in crate::traffic::core) fn retime(&mut self) -> bool {
        let times = |t: &Timing| (t.push_take_s, t.take_s.clone(), t.front_s.clone());
        let before: Vec<_> = self.movers.iter().map(|m| times(&m.timing)).collect();
        for m in 0..self.movers.len() {
            self.bring_to_now(m);
        }
        let sequence = self.sequence();
        // In their order all settles at once, but for what is equal in it.
        let settled = (0..12).any(|_| !self.pass(&sequence));
        for (mover, (push_take_s, take_s, front_s)) in self.movers.iter_mut().zip(before) {
            let t = &mut mover.timing;
            if settled {
                t.order_s.clone_from(&t.take_s);
            } else {
                (t.push_take_s, t.take_s, t.front_s) = (push_take_s, take_s, front_s);
            }
        }
        self.book();
        settled
    }

    /// Where the front of a mover is, by what it has driven of what it holds.
    fn bring_to_now(&mut self, m: usize) {
        if !self.movers[m].timing.planned {
            return;
        }
        let now = self.time_s;
        let mut t = std::mem::take(&mut self.movers[m].timing);
        let mover = &self.movers[m];
        match mover.phase {
            Phase::Parked => {}
            Phase::Pushing => {
                // Somewhere between the begin and the end of the pushback.
                let left = (mover.push.stop_m - mover.s).max(0.0) / 1.5;
                let done = now + left;
                let front = done + (t.push_s.0 - t.push_s.1);
                t.push_take_s = done - t.push_s.1;
                t.front_s[..t.pushed].fill(front);
            }
            // The landing group comes at its time.
            Phase::Final if mover.next == 0 => {}
            Phase::Starting(until) | Phase::LinedUp(until) => {
                self.front_of_held(m, &mut t, until.max(now));
            }
            _ => {
                self.front_of_held(m, &mut t, now);
            }
        }
        self.movers[m].timing = t;
    }

    /// Groups in their order, and which uses of others come before each.
    fn sequence(&self) -> Sequence {
        let mut groups: Vec<(f64, usize, Taken)> = Vec::new();
        let count = self.pieces.list.len();
        let mut users = Users { there: Stacks::new(count), planned: Stacks::new(count) };
        for (m, mover) in self.movers.iter().enumerate().filter(|(_, m)| m.timing.planned) {
            let (open, t) = (self.open_steps(m), &mover.timing);
            let mut there = |z: u32, ends: Ends| {
                if let Some(user) = self.user(m, ends) {
                    users.there.put(z as usize, user);
                }
            };
            if mover.phase == Phase::Parked {
                groups.push((t.push_take_s, m, Taken::Push));
                mover.parked_pieces.iter().for_each(|z| there(*z, Ends::Leaving));
            } else {
                let pushing = mover.phase == Phase::Pushing;
                if pushing {
                    mover.push.pieces.iter().for_each(|z| there(*z, Ends::Pushed));
                }
                let held = if pushing { t.first } else { mover.first_held };
                let steps = held..open.start.min(mover.way.pieces.len());
                steps.for_each(|k| there(mover.way.pieces[k], Ends::Step(k as u32)));
            }
            let mut k = open.start;
            while k < open.end {
                groups.push((t.order_s[k], m, Taken::From(k)));
                k = mover.way.group_last[k].max(k) + 1;
            }
        }
        // Of one mover in the order of its way, the pushback last.
        let step = |taken: Taken| match taken {
            Taken::From(k) => k,
            Taken::Push => usize::MAX,
        };
        groups.sort_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(step(a.2).cmp(&step(b.2)))
        });
        let (mut before, mut ends) = (Vec::new(), Vec::with_capacity(groups.len()));
        for (_, m, taken) in &groups {
            let [pieces, under] = self.taken_with(*m, *taken);
            let class = self.movers[*m].class;
            for z in pieces.iter().chain(under) {
                for (other, least) in self.pieces.conflicts(*z as usize, class) {
                    if self.in_order(*z, *other) {
                        self.users_before(*m, *other, *least, &users, &mut before);
                    }
                }
            }
            ends.push(before.len());
            let mut uses = |z: u32, ends: Ends| {
                if let Some(user) = self.user(*m, ends) {
                    users.planned.put(z as usize, user);
                }
            };
            match *taken {
                Taken::Push => {
                    let first = self.movers[*m].timing.first;
                    let step = |i: usize| Ends::Step((first + i) as u32);
                    under.iter().enumerate().for_each(|(i, z)| uses(*z, step(i)));
                    pieces.iter().for_each(|z| uses(*z, Ends::Pushed));
                }
                Taken::From(k) => {
                    let step = |i: usize| Ends::Step((k + i) as u32);
                    pieces.iter().enumerate().for_each(|(i, z)| uses(*z, step(i)));
                }
            }
        }
        Sequence { groups, before, ends }
    }

    /// A use that ends some time; who stays on a piece for ever is waited for by nobody.
    fn user(&self, m: usize, ends: Ends) -> Option<User> {
        let mover = &self.movers[m];
        let stays = matches!(ends, Ends::Step(k) if mover.timing.release[k as usize].is_none());
        (!stays).then_some(User { mover: m as u32, class: mover.class, ends })
    }

    /// Of those who use a piece before `m`, whoever is there now, and of the others where the order says who of them goes first
    /// only the last, who ends after the ones before him (of a pushback, what it leads over and what is under it then).
    fn users_before(
        &self,
        m: usize,
        piece: u32,
        least: Class,
        users: &Users,
        before: &mut Vec<(u32, Ends)>,
    ) {
        let counts = |u: &&User| u.mover as usize != m && u.class >= least;
        let ended = |u: &User| (u.mover, u.ends);
        before.extend(users.there.of(piece as usize).filter(counts).map(ended));
        let mut planned = users.planned.of(piece as usize).filter(counts).map(ended).peekable();
        let last = planned.peek().filter(|_| self.in_order(piece, piece)).map(|(o, _)| *o);
        before.extend(planned.take_while(|(o, _)| last.is_none_or(|last| last == *o)));
    }

    /// Pieces that are taken together, and those that are under the mover then.
    fn taken_with(&self, m: usize, taken: Taken) -> [&[u32]; 2] {
        let mover = &self.movers[m];
        match taken {
            Taken::Push => {
                let t = &mover.timing;
                [&mover.push.pieces, &mover.way.pieces[t.first..t.pushed]]
            }
            Taken::From(k) => [&mover.way.pieces[k..=self.last_with(m, k)], &[]],
        }
    }

    /// Last step of the group that begins with a step.
    fn last_with(&self, m: usize, first: usize) -> usize {
        let way = &self.movers[m].way;
        way.group_last[first].min(way.pieces.len() - 1).max(first)
    }

    /// Times of all groups, one after the other; whether any changed.
    fn pass(&mut self, sequence: &Sequence) -> bool {
        let (now, mut changed, mut from) = (self.time_s, false, 0);
        for ((_, m, taken), to) in sequence.groups.iter().zip(&sequence.ends) {
            let m = *m;
            let mut least = now;
            for (o, ends) in &sequence.before[from..*to] {
                let until_s = self.movers[*o as usize].timing.ends_s(*ends);
                if until_s.is_finite() {
                    least = least.max(until_s + PAUSE_S);
                }
            }
            from = *to;
            match *taken {
                Taken::Push => {
                    let take = least.max(self.flights[m].time_s);
                    let t = &mut self.movers[m].timing;
                    changed |= (t.push_take_s - take).abs() > 1e-6;
                    t.push_take_s = take;
                    let front = take + t.push_s.0;
                    t.take_s[..t.pushed].fill(take);
                    t.front_s[..t.pushed].fill(front);
                }
                Taken::From(first) => {
                    let mover = &self.movers[m];
                    let lands =
                        mover.timing.fixed && first == mover.next && mover.phase == Phase::Final;
                    let ready = if first == 0 || lands {
                        mover.landing_s - LANDING_AHEAD_S
                    } else {
                        mover.timing.front_s[first - 1]
                    };
                    let take = least.max(ready);
                    let last = self.last_with(m, first);
                    let t = &mut self.movers[m].timing;
                    changed |= (t.take_s[first] - take).abs() > 1e-6;
                    let mut front = take;
                    for i in first..=last {
                        front += t.pass_s[i];
                        t.take_s[i] = take;
                        t.front_s[i] = front;
                    }
                }
            }
        }
        changed
    }

    /// Makes the order lists of the pieces anew.
    pub(in crate::traffic::core) fn book(&mut self) {
        self.books.iter_mut().for_each(Vec::clear);
        for m in 0..self.movers.len() {
            let mover = &self.movers[m];
            if !mover.timing.planned {
                continue;
            }
            let t = &mover.timing;
            let mover_key = m as u32;
            if mover.phase == Phase::Parked {
                let booking = Booking { order_s: t.push_take_s, mover: mover_key };
                for z in &mover.push.pieces {
                    self.books[*z as usize].push(booking);
                }
                for z in &mover.way.pieces[t.first..t.pushed] {
                    self.books[*z as usize].push(booking);
                }
            }
            for k in self.open_steps(m) {
                let z = mover.way.pieces[k];
                let booking = Booking { order_s: t.order_s[k], mover: mover_key };
                self.books[z as usize].push(booking);
            }
        }
        self.version += 1;
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
                let earlier = (b.order_s, o) < (order_s, m);
                if o != m && earlier && self.movers[o].class >= *least {
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
        let mut first: Option<usize> = None;
        for (i, b) in list.iter().enumerate() {
            if b.mover as usize == m && first.is_none_or(|f| b.order_s < list[f].order_s) {
                first = Some(i);
            }
        }
        if let Some(i) = first {
            list.swap_remove(i);
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
        if self.retime() {
            return true;
        }
        self.movers[m].timing.order_s = old;
        self.book();
        false
    }
}
