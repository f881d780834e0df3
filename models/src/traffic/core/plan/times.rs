//! The earliest times of a way in the windows that the others leave.

use super::stacks::Stacks;
use super::{CLEARED_BEFORE_S, PAUSE_S, Timing};
use crate::traffic::core::{Core, Direction, Phase};

/// Another's use of a piece, s.
#[derive(Clone, Copy, Debug)]
struct Use {
    mover: usize,
    from_s: f64,
    to_s: f64,
}

/// Another's use of a runway, s.
#[derive(Clone, Copy, Debug)]
struct RunwayUse {
    from_s: f64,
    to_s: f64,
    /// From then on somebody may line up behind.
    passed_s: f64,
}

/// What all but one mover use: for his plans, while nothing else changes.
pub(in crate::traffic::core) struct Others {
    /// By piece.
    pieces: Stacks<Use>,
    /// By runway.
    runways: Vec<Vec<RunwayUse>>,
}

/// What others use on one way of a mover: for all times at which it may begin.
pub(in crate::traffic::core) struct Rivals {
    /// By step: from when until when, in the order of their begin.
    steps: Vec<Vec<(f64, f64)>>,
    /// The same of the pushback.
    push: Vec<(f64, f64)>,
    /// From then on others are planned over its stand.
    over_stand_s: f64,
    /// By the timing's runways: from when until when others keep it off.
    runways: Vec<Vec<(f64, f64)>>,
}

/// Longest time ahead that is planned, s.
const HORIZON_S: f64 = 4.0 * 3600.0;

impl Core {
    /// Every use of every piece that others have or plan, by piece. `without`: nobody, or a mover whose uses do
    /// not count.
    fn uses(&self, without: usize) -> Stacks<Use> {
        let mut uses = Stacks::new(self.pieces.list.len());
        let ever = |mover: usize, from_s: f64, to_s: f64| Use { mover, from_s, to_s };
        // Who has no plan holds what he holds for ever.
        let mut unplanned = vec![false; self.movers.len()];
        for (m, mover) in self.movers.iter().enumerate().filter(|(m, _)| *m != without) {
            let t = &mover.timing;
            match mover.phase {
                Phase::Absent | Phase::Gone | Phase::GoAround => continue,
                Phase::Parked | Phase::Docked => {
                    let leaves = mover.phase == Phase::Parked && t.planned;
                    let until = if leaves { t.push_take_s } else { f64::INFINITY };
                    for z in &mover.parked_pieces {
                        uses.put(*z as usize, ever(m, f64::NEG_INFINITY, until));
                    }
                    if !leaves {
                        continue;
                    }
                }
                _ => {}
            }
            if !t.planned {
                unplanned[m] = true;
                continue;
            }
            if matches!(mover.phase, Phase::Parked | Phase::Pushing) {
                let from =
                    if mover.phase == Phase::Parked { t.push_take_s } else { f64::NEG_INFINITY };
                for z in &mover.push.pieces {
                    uses.put(*z as usize, ever(m, from, t.push_take_s + t.push_s.1));
                }
            }
            let pushing = matches!(mover.phase, Phase::Parked | Phase::Pushing);
            let held_from = if pushing { t.first } else { mover.first_held };
            for k in held_from..mover.way.pieces.len() {
                let taken =
                    !pushing && k < self.taken(m) || mover.phase == Phase::Pushing && k < t.pushed;
                let from = if taken { f64::NEG_INFINITY } else { t.take_s[k] };
                uses.put(mover.way.pieces[k] as usize, ever(m, from, t.release_s(k)));
            }
            let arrives = self.flights[m].direction == Direction::Arrival;
            if let Some(last) = t.take_s.last().filter(|_| arrives && mover.phase != Phase::Docked)
            {
                for z in &mover.parked_pieces {
                    uses.put(*z as usize, ever(m, *last, f64::INFINITY));
                }
            }
            if let (Some((_, pieces)), Some(last)) = (&mover.goal, t.take_s.last()) {
                for z in pieces {
                    uses.put(*z as usize, ever(m, *last, f64::INFINITY));
                }
            }
        }
        if unplanned.contains(&true) {
            for (z, holders) in self.holders.iter().enumerate() {
                for h in holders.iter().map(|h| *h as usize).filter(|h| unplanned[*h]) {
                    uses.put(z, ever(h, f64::NEG_INFINITY, f64::INFINITY));
                }
            }
        }
        uses
    }

    /// When each runway is used by others, s.
    fn runway_uses(&self, without: usize) -> Vec<Vec<RunwayUse>> {
        let mut uses = vec![Vec::new(); self.net.runways.len()];
        for (m, mover) in self.movers.iter().enumerate().filter(|(m, _)| *m != without) {
            if mover.phase == Phase::Final {
                let r = self.flights[m].runway.0;
                let from_s = mover.landing_s - CLEARED_BEFORE_S;
                for c in &self.crossing[r] {
                    let passed_s = if *c == r { 12.0 } else { 60.0 };
                    let passed_s = mover.landing_s + passed_s;
                    uses[*c].push(RunwayUse { from_s, to_s: mover.landing_s + 60.0, passed_s });
                }
            }
            let open = self.open_steps(m);
            for (k, r, for_s) in &mover.timing.runways {
                if open.contains(k) {
                    let from = mover.timing.take_s[*k];
                    let to_s = from + for_s;
                    let span = RunwayUse { from_s: from, to_s, passed_s: to_s };
                    self.crossing[*r].iter().for_each(|c| uses[*c].push(span));
                }
            }
        }
        uses
    }

    /// What all but `m` use now.
    pub(in crate::traffic::core) fn others(&self, m: usize) -> Others {
        Others { pieces: self.uses(m), runways: self.runway_uses(m) }
    }

    /// What others use of all that conflicts with a piece for a mover.
    pub(super) fn against(
        &self,
        others: &Others,
        m: usize,
        piece: u32,
        found: &mut Vec<(f64, f64)>,
    ) {
        let class = self.movers[m].class;
        let conflicts = self.pieces.conflicts(piece as usize, class).iter();
        for (other, least) in conflicts.filter(|c| self.in_order(piece, c.0)) {
            let uses = others.pieces.of(*other as usize);
            let theirs = uses.filter(|u| u.mover != m && self.movers[u.mover].class >= *least);
            found.extend(theirs.map(|u| (u.from_s, u.to_s)));
        }
    }

    /// What others use on the way of a mover.
    pub(in crate::traffic::core) fn rivals(&self, m: usize, t: &Timing, others: &Others) -> Rivals {
        let mover = &self.movers[m];
        let count = mover.way.pieces.len();
        let start = if t.pushed > 0 { t.first } else { mover.next };
        let mut steps = vec![Vec::new(); count];
        for k in start..count {
            self.against(others, m, mover.way.pieces[k], &mut steps[k]);
            steps[k].sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let (mut push, mut over_stand) = (Vec::new(), Vec::new());
        if t.pushed > 0 {
            mover.push.pieces.iter().for_each(|z| self.against(others, m, *z, &mut push));
            mover.parked_pieces.iter().for_each(|z| self.against(others, m, *z, &mut over_stand));
        }
        // Until it is pushed back nobody can be planned over its stand; who is already has to come later.
        let over_stand_s = over_stand.iter().map(|u| u.0).fold(f64::INFINITY, f64::min);
        // Who lines up does so behind a landed one.
        let departs = self.flights[m].direction == Direction::Departure;
        let lines_up = |k: usize| departs && k == mover.threshold as usize;
        let off = |(k, r, _): &(usize, usize, f64)| {
            let uses = others.runways[*r].iter();
            uses.map(|u| (u.from_s, if lines_up(*k) { u.passed_s } else { u.to_s })).collect()
        };
        let runways = t.runways.iter().map(off).collect();
        Rivals { steps, push, over_stand_s, runways }
    }

    /// The earliest times of a mover's way among what the others do: the least fixed point of "whoever would meet
    /// a use waits until it ends". `None` if there is none within the horizon, or a landing would have to wait.
    ///
    /// Every bound only rises, and a later take never makes an earlier release, so the first assignment without
    /// a meeting is the earliest of all for each step, in whatever order the bounds are raised.
    pub(super) fn schedule(
        &self,
        m: usize,
        mut t: Timing,
        from_s: f64,
        rivals: &Rivals,
    ) -> Option<Timing> {
        let count = self.movers[m].way.pieces.len();
        let start = if t.pushed > 0 { t.first } else { self.movers[m].next };
        let mut least = vec![f64::NEG_INFINITY; count];
        let mut least_push = from_s;
        let horizon = from_s + HORIZON_S;
        // Steps before this one have their times; bounds from there on have risen.
        let mut risen = 0;
        for _ in 0..4000 {
            let again = self.forward(m, &mut t, (least_push, &mut least), from_s, rivals, risen);
            let late = t.fixed && t.take_s[start] > from_s + 0.5;
            if late || t.take_s.last().is_some_and(|l| *l > horizon) {
                return None;
            }
            risen = count;
            if t.pushed > 0 {
                let (take, done) = (t.push_take_s, t.push_take_s + t.push_s.1);
                let mut meet = |(from, to): &(f64, f64), until: f64| {
                    if take < *to && *from < until {
                        least_push = least_push.max(to + PAUSE_S);
                        risen = 0;
                    }
                };
                rivals.push.iter().for_each(|u| meet(u, done));
                for k in t.first..t.pushed {
                    let until = t.release_s(k);
                    rivals.steps[k].iter().for_each(|u| meet(u, until));
                }
            }
            // The release of a step changes with the times of the steps behind it.
            let first = t.pushed.max(start);
            let mut from = again.max(first);
            while from > first && t.release[from - 1].is_none_or(|(at, _)| at >= again) {
                from -= 1;
            }
            for k in from..count {
                let (take, until) = (t.take_s[k], t.release_s(k));
                for (begin, end) in rivals.steps[k].iter().take_while(|u| u.0 < until) {
                    if take < *end && *begin < until {
                        least[k] = least[k].max(end + PAUSE_S);
                        risen = risen.min(k);
                    }
                }
            }
            for ((k, _, for_s), uses) in t.runways.iter().zip(&rivals.runways) {
                if *k < start {
                    continue;
                }
                let take = t.take_s[*k];
                for (begin, end) in uses {
                    if take < *end && *begin < take + for_s {
                        least[*k] = least[*k].max(end + PAUSE_S);
                        risen = risen.min(*k);
                    }
                }
            }
            let late = t.pushed > 0 && t.push_take_s > rivals.over_stand_s;
            if late || least_push > horizon || least.iter().any(|l| *l > horizon) {
                return None;
            }
            if risen == count {
                t.planned = true;
                t.order_s.clone_from(&t.take_s);
                return Some(t);
            }
        }
        None
    }

    /// Takes and fronts from the bounds, of the groups from the one with the step `risen` on; the first step of that. A take that
    /// would fall into somebody's use waits at once.
    fn forward(
        &self,
        m: usize,
        t: &mut Timing,
        (push_s, least): (f64, &mut [f64]),
        from_s: f64,
        rivals: &Rivals,
        risen: usize,
    ) -> usize {
        let way = &self.movers[m].way;
        let count = way.pieces.len();
        let first = if t.pushed > 0 { t.pushed } else { self.movers[m].next };
        let (mut k, mut front) = (first, from_s);
        if t.pushed > 0 {
            t.push_take_s = push_s;
            front = push_s + t.push_s.0;
            t.take_s[..t.pushed].fill(push_s);
            t.front_s[..t.pushed].fill(front);
        } else if k > 0 {
            // What is held already: the front reaches its end by the rest of the way alone.
            let mut held_s = std::mem::take(&mut t.front_s);
            front = self.front_of_held(m, t, &mut held_s, from_s);
            t.front_s = held_s;
        }
        let last_of = |k: usize| way.group_last[k].min(count - 1).max(k);
        while k < count && last_of(k) < risen {
            k = last_of(k) + 1;
        }
        if k > first {
            front = t.front_s[k - 1];
        }
        let begun = k;
        while k < count {
            let last = last_of(k);
            let bound = least[k..=last].iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let mut take = front.max(bound);
            loop {
                let before = take;
                for i in k..=last {
                    for (begin, end) in &rivals.steps[i] {
                        if *begin >= take {
                            break;
                        }
                        if take < *end {
                            least[i] = least[i].max(end + PAUSE_S);
                            take = take.max(least[i]);
                        }
                    }
                }
                if take == before {
                    break;
                }
            }
            front = take;
            for i in k..=last {
                front += t.pass_s[i];
                t.take_s[i] = take;
                t.front_s[i] = front;
            }
            k = last + 1;
        }
        begun
    }
}
