//! The times that the order gives: each take as soon as all is over that it waits for.

use super::order::{Ends, Links, Taken, There};
use super::{LANDING_AHEAD_S, PAUSE_S};
use crate::traffic::core::{Core, Phase};

/// Times of all plans while they are found, one mover behind the other.
#[derive(Clone, Debug, Default)]
pub(in crate::traffic::core) struct Times {
    movers: Vec<Known>,
    take_s: Vec<f64>,
    front_s: Vec<f64>,
}

/// What is known of a mover's times.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Its first step in the lists, and how many it has.
    at: usize,
    count: usize,
    push_take_s: f64,
    /// First step that is not taken yet.
    open: usize,
    /// The first take that has no time yet, and what is told by no time yet.
    next: usize,
    unknown: Ends,
    /// Somebody waits for its next take.
    asked: bool,
}

impl Core {
    /// Finds the times of all plans; `false` if somebody would wait for himself.
    pub(super) fn settle(&self, links: &mut [Links], there: &There, times: &mut Times) -> bool {
        times.movers.clear();
        times.front_s.clear();
        (0..self.movers.len()).for_each(|m| self.begin(m, times));
        times.take_s.resize(times.front_s.len(), 0.0);
        let mut stack: Vec<(usize, Ends)> = Vec::new();
        for m in 0..self.movers.len() {
            stack.push((m, Ends::LAST));
            while let Some((x, until)) = stack.last().copied() {
                match self.advance(x, until, links, there, times) {
                    None => {
                        times.movers[x].asked = false;
                        stack.pop();
                    }
                    Some((o, _)) if times.movers[o].asked => return false,
                    Some(what) => {
                        times.movers[x].asked = true;
                        stack.push(what);
                    }
                }
            }
        }
        true
    }

    /// Takes over the times that were found.
    pub(super) fn set_times(&mut self, times: &Times) {
        let all = self.movers.iter_mut().zip(&times.movers);
        for (mover, known) in all.filter(|(m, _)| m.timing.planned) {
            let t = &mut mover.timing;
            let Known { at, count, open, push_take_s, .. } = *known;
            t.push_take_s = push_take_s;
            t.front_s.copy_from_slice(&times.front_s[at..at + count]);
            t.take_s[open..].copy_from_slice(&times.take_s[at + open..at + count]);
            t.order_s.clone_from(&t.take_s);
        }
    }

    /// What is known of a mover's times without anybody else: where its front is, by what it has driven of what it holds.
    fn begin(&self, m: usize, times: &mut Times) {
        let mover = &self.movers[m];
        let (t, now) = (&mover.timing, self.time_s);
        let at = times.front_s.len();
        times.front_s.extend(&t.front_s);
        let (front_s, mut push_take_s) = (&mut times.front_s[at..], t.push_take_s);
        match mover.phase {
            _ if !t.planned => {}
            Phase::Parked => {}
            Phase::Pushing => {
                // Somewhere between the begin and the end of the pushback.
                let left = (mover.push.stop_m - mover.s).max(0.0) / 1.5;
                let done = now + left;
                let front = done + (t.push_s.0 - t.push_s.1);
                push_take_s = done - t.push_s.1;
                front_s[..t.pushed].fill(front);
            }
            // The landing group comes at its time.
            Phase::Final if mover.next == 0 => {}
            Phase::Starting(until) | Phase::LinedUp(until) => {
                self.front_of_held(m, t, front_s, until.max(now));
            }
            _ => {
                self.front_of_held(m, t, front_s, now);
            }
        }
        let (parked, open) = (mover.phase == Phase::Parked, self.open_steps(m).start);
        times.movers.push(Known {
            at,
            count: t.front_s.len(),
            push_take_s,
            open: if parked { 0 } else { open },
            next: 0,
            unknown: if parked { Ends::PUSHED } else { Ends::step(open) },
            asked: false,
        });
    }

    /// Gives the takes of a mover their times, up to what is asked for, or says what has to be known before.
    fn advance(
        &self,
        m: usize,
        until: Ends,
        links: &mut [Links],
        there: &There,
        times: &mut Times,
    ) -> Option<(usize, Ends)> {
        let (mover, t) = (&self.movers[m], &self.movers[m].timing);
        let mut mine = times.movers[m];
        let mut asks = None;
        while mine.unknown <= until {
            let Some(link) = links[m].takes.get(mine.next) else { break };
            let over = match link.taken {
                Taken::Steps { last, .. } => (last as usize) < mine.open,
                Taken::Push => mover.phase != Phase::Parked,
            };
            // Taken since it was put down.
            if over {
                mine.next += 1;
                continue;
            }
            let taken = link.taken;
            let mut found = self.waits(&links[m], mine.next, there, times);
            if matches!(found, Err(None)) {
                let before = self.before_take(m, link, there);
                links[m].put(mine.next, before, self.retimed);
                found = self.waits(&links[m], mine.next, there, times);
            }
            let least = match found {
                Ok(least) => least,
                Err(what) => {
                    asks = what;
                    break;
                }
            };
            let take_s = &mut times.take_s[mine.at..mine.at + mine.count];
            let front_s = &mut times.front_s[mine.at..mine.at + mine.count];
            match taken {
                Taken::Push => {
                    let take = least.max(self.flights[m].time_s);
                    mine.push_take_s = take;
                    take_s[..t.pushed].fill(take);
                    front_s[..t.pushed].fill(take + t.push_s.0);
                    mine.unknown = Ends::step(t.pushed);
                }
                Taken::Steps { first, last } => {
                    let (first, last) = ((first as usize).max(mine.open), last as usize);
                    let lands = t.fixed && first == mover.next && mover.phase == Phase::Final;
                    let ready = if first == 0 || lands {
                        mover.landing_s - LANDING_AHEAD_S
                    } else {
                        front_s[first - 1]
                    };
                    let take = least.max(ready);
                    let mut front = take;
                    for i in first..=last {
                        front += t.pass_s[i];
                        take_s[i] = take;
                        front_s[i] = front;
                    }
                    mine.unknown = Ends::step(last + 1);
                }
            }
            mine.next += 1;
        }
        if asks.is_none() && mine.next == links[m].takes.len() {
            mine.unknown = Ends::LAST;
        }
        times.movers[m] = mine;
        asks
    }

    /// When all is over that a take waits for, s, at the earliest now; or what has to be known before, or none where what it
    /// waits for is to be found anew.
    fn waits(
        &self,
        mine: &Links,
        take: usize,
        there: &There,
        times: &Times,
    ) -> Result<f64, Option<(usize, Ends)>> {
        let link = &mine.takes[take];
        let mut least = self.time_s;
        if link.found == 0 {
            return Err(None);
        }
        for b in mine.before_of(link) {
            let o = b.mover as usize;
            let (alive, since) = there.by_mover[o];
            if since > link.found {
                return Err(None);
            }
            if b.ends < alive {
                continue;
            }
            let other = &times.movers[o];
            if b.told_by >= other.unknown {
                return Err(Some((o, b.told_by)));
            }
            let told_s = match b.told_by.of_step() {
                Some(at) => times.front_s[other.at + at],
                None => other.push_take_s,
            };
            let until_s = told_s - b.back_s;
            if until_s.is_finite() {
                least = least.max(until_s + PAUSE_S);
            }
        }
        Ok(least)
    }
}
