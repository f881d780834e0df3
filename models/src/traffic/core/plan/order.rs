//! The order that planned times make: brought up to date as the world goes on, and who is before whom at a piece.

use super::{Booking, LANDING_AHEAD_S, PAUSE_S, Timing};
use crate::traffic::core::{Core, Phase, Policy};

impl Core {
    /// Times of all plans as the world is now, in the order that they have; `false`, with the times as they were,
    /// if that order has a cycle.
    pub(in crate::traffic::core) fn retime(&mut self) -> bool {
        let now = self.time_s;
        let before: Vec<Timing> = self.movers.iter().map(|m| m.timing.clone()).collect();
        // Groups in their order, and who uses each piece before whom.
        let mut groups: Vec<(f64, usize, usize)> = Vec::new();
        let mut users: Vec<Vec<(f64, usize, usize)>> = vec![Vec::new(); self.pieces.list.len()];
        let count = self.movers.len();
        const PUSH: usize = usize::MAX;
        const PARKED: usize = usize::MAX - 1;
        for m in 0..count {
            if !self.movers[m].timing.planned {
                continue;
            }
            let open = self.open_steps(m);
            let pushing = matches!(self.movers[m].phase, Phase::Parked | Phase::Pushing);
            let mut t = std::mem::take(&mut self.movers[m].timing);
            let mover = &self.movers[m];
            if mover.phase == Phase::Parked {
                groups.push((t.push_take_s, m, PUSH));
                for z in &mover.parked_pieces {
                    users[*z as usize].push((f64::NEG_INFINITY, m, PARKED));
                }
            }
            if mover.phase == Phase::Pushing {
                // Somewhere between the begin and the end of the pushback.
                let left = (mover.push.stop_m - mover.s).max(0.0) / 1.5;
                let done = now + left;
                let front = done + (t.push_s.0 - t.push_s.1);
                t.push_take_s = done - t.push_s.1;
                t.front_s[..t.pushed].fill(front);
            }
            if !pushing {
                if let Phase::Starting(until) = mover.phase {
                    let front = self.front_of_held(m, &mut t, until.max(now));
                    let _ = front;
                } else if mover.phase == Phase::Final && mover.next == 0 {
                    // The landing group comes at its time.
                } else {
                    let from =
                        if let Phase::LinedUp(until) = mover.phase { until.max(now) } else { now };
                    self.front_of_held(m, &mut t, from);
                }
            }
            let mover = &self.movers[m];
            let mut k = open.start;
            while k < open.end {
                groups.push((t.order_s[k], m, k));
                k = mover.way.group_last[k].max(k) + 1;
            }
            let held = if pushing { t.first } else { mover.first_held };
            for k in held..mover.way.pieces.len() {
                let z = mover.way.pieces[k];
                let order = if k < open.start && mover.phase != Phase::Parked {
                    f64::NEG_INFINITY
                } else if k < open.start {
                    t.push_take_s
                } else {
                    t.order_s[k]
                };
                users[z as usize].push((order, m, k));
            }
            if pushing {
                let order =
                    if mover.phase == Phase::Parked { t.push_take_s } else { f64::NEG_INFINITY };
                for z in &mover.push.pieces {
                    users[*z as usize].push((order, m, PUSH));
                }
            }
            self.movers[m].timing = t;
        }
        groups.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut settled = false;
        for _pass in 0..12 {
            let mut changed = false;
            for (order, m, first) in &groups {
                let (m, first) = (*m, *first);
                let mover = &self.movers[m];
                let pieces: &[u32] = if first == PUSH {
                    &mover.push.pieces
                } else {
                    let last = mover.way.group_last[first].min(mover.way.pieces.len() - 1);
                    &mover.way.pieces[first..=last.max(first)]
                };
                let under: &[u32] = if first == PUSH {
                    &mover.way.pieces[mover.timing.first..mover.timing.pushed]
                } else {
                    &[]
                };
                let mut least = now;
                for z in pieces.iter().chain(under) {
                    for (other, class) in self.pieces.conflicts(*z as usize, mover.class) {
                        if !self.in_order(*z, *other) {
                            continue;
                        }
                        for (o_order, o, k) in &users[*other as usize] {
                            if *o == m
                                || self.movers[*o].class < *class
                                || (*o_order, *o) >= (*order, m)
                            {
                                continue;
                            }
                            let theirs = &self.movers[*o].timing;
                            let until = if *k == PUSH {
                                theirs.push_take_s + theirs.push_s.1
                            } else if *k == PARKED {
                                theirs.push_take_s
                            } else {
                                theirs.release_s(*k)
                            };
                            if until.is_finite() {
                                least = least.max(until + PAUSE_S);
                            }
                        }
                    }
                }
                let ready = if first == PUSH {
                    self.flights[m].time_s
                } else if first == 0
                    || self.movers[m].timing.fixed
                        && first == self.movers[m].next
                        && self.movers[m].phase == Phase::Final
                {
                    self.movers[m].landing_s - LANDING_AHEAD_S
                } else {
                    self.movers[m].timing.front_s[first - 1]
                };
                let take = least.max(ready);
                let group_last = self.movers[m].way.group_last.get(first).copied();
                let t = &mut self.movers[m].timing;
                if first == PUSH {
                    changed |= (t.push_take_s - take).abs() > 1e-6;
                    t.push_take_s = take;
                    let front = take + t.push_s.0;
                    t.take_s[..t.pushed].fill(take);
                    t.front_s[..t.pushed].fill(front);
                } else {
                    changed |= (t.take_s[first] - take).abs() > 1e-6;
                    let mut front = take;
                    for i in first..=group_last.unwrap_or(first).min(t.take_s.len() - 1).max(first)
                    {
                        front += t.pass_s[i];
                        t.take_s[i] = take;
                        t.front_s[i] = front;
                    }
                }
            }
            if !changed {
                settled = true;
                break;
            }
        }
        if settled {
            for m in 0..count {
                let t = &mut self.movers[m].timing;
                t.order_s.clone_from(&t.take_s);
            }
        } else {
            for (m, t) in before.into_iter().enumerate() {
                self.movers[m].timing = t;
            }
        }
        self.book();
        settled
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
