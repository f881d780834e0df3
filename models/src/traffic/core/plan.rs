//! The planned order: every mover has planned times for all pieces of its way; who is planned first at a piece
//! goes first, whatever delays there are.
//!
//! *Step* `k` of a mover is piece `k` of its way. Its front (nose and gap) waits at the end of the step before
//! until the step is taken, and the step is released when the tail is off it, which is when the front has reached
//! a place some steps ahead: so an interval holds the whole tail, also while the mover waits.
//!
//! Takes ascend along a way, and a release comes after the take of the step that the front has to be in. Intervals
//! of different movers on conflicting pieces do not overlap. So planned time is a strict potential of the
//! dependencies, the unfinished event with the least planned time can always go on, and there is no deadlock,
//! however long anybody is delayed. Who goes first in the strip of a runway, on its centreline or over it, is not in the
//! order: whoever takes a piece there leaves the strip without taking anything more.
//!
//! Source: Gawrilow and others 2008 (time windows); Hönig and others 2019 (execution in planned order).

mod order;

use super::{Core, Direction, Phase};
use crate::flight_list::WakeCategory;
use std::ops::Range;

/// Planned times of a mover's way.
#[derive(Clone, Debug, Default)]
pub(super) struct Timing {
    /// Whether there is a plan.
    pub planned: bool,
    /// First step that is ever held.
    first: usize,
    /// Steps before this one are taken with the pushback.
    pushed: usize,
    /// From the take of the pushback to the front at the end of the steps taken with it, s; to its end.
    push_s: (f64, f64),
    /// Take of the pushback.
    pub push_take_s: f64,
    /// By step: from its begin to its end, driven alone, s.
    pass_s: Vec<f64>,
    /// By step: released while the front is in this step, so long before its end; `None`: kept for ever.
    release: Vec<Option<(usize, f64)>>,
    /// By step: planned take, front at its end.
    pub take_s: Vec<f64>,
    front_s: Vec<f64>,
    /// By step: what its place in the order is told by.
    order_s: Vec<f64>,
    /// Runways that a group uses: first step, runway, for how long from its take.
    runways: Vec<(usize, usize, f64)>,
    /// The first group cannot be taken later than planned (a landing).
    fixed: bool,
}

/// A planned take that has not come yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Booking {
    pub order_s: f64,
    pub mover: u32,
}

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
pub(super) struct Others {
    /// By piece.
    pieces: Vec<Vec<Use>>,
    /// By runway.
    runways: Vec<Vec<RunwayUse>>,
}

/// Pause between intervals of different movers, s.
const PAUSE_S: f64 = 0.05;
/// Longest time ahead that is planned, s.
const HORIZON_S: f64 = 4.0 * 3600.0;
/// From landing clearance to threshold, s: about 1.5 NM.
pub(super) const LANDING_AHEAD_S: f64 = 45.0;
/// From the holding position: ready for the roll after being lined up, s (drawn 5 to 10).
pub(super) const READY_S: f64 = 8.0;
/// From lift-off to 15 m of height, s.
pub(super) const UP_S: f64 = 7.0;
/// An arrival is cleared so long before the threshold at the latest, s: a little more than 1 NM.
pub(super) const CLEARED_BEFORE_S: f64 = 38.0;

impl Timing {
    fn release_s(&self, step: usize) -> f64 {
        match self.release[step] {
            Some((at, back_s)) => self.front_s[at] - back_s,
            None => f64::INFINITY,
        }
    }
}

impl Core {
    /// Times of a new way, without anybody else: to be filled by `schedule`.
    pub(super) fn timing(&self, m: usize, start: Start) -> Timing {
        let mover = &self.movers[m];
        let behind_m = self.reach_m(m).1;
        let way = &mover.way;
        let count = way.pieces.len();
        let (from_m, v_mps, push_s, first, pushed) = match start {
            Start::Stand { place_m, first, pushed, push_s, front_s } => {
                (place_m, 0.3, (front_s, push_s), first, pushed)
            }
            Start::Final => (mover.threshold, self.flights[m].landing.0, (0.0, 0.0), 0, 0),
            Start::UnderWay => (0.0, 0.3, (0.0, 0.0), 0, 0),
        };
        let alone = way.alone(from_m, v_mps, &mover.driving);
        let at = |place_m: f64| alone.time_s(place_m);
        // Where it waits for the step after each.
        let stops_m: Vec<f64> = (0..count).map(|k| self.stop_before_m(m, k + 1)).collect();
        let landing = matches!(start, Start::Final);
        let mut before = at(if pushed > 0 { stops_m[pushed - 1] } else { from_m });
        let mut pass_s = vec![0.0; count];
        for k in pushed..count {
            let here = at(stops_m[k]).max(before);
            pass_s[k] = here - before;
            before = here;
        }
        if landing && count > 0 {
            pass_s[0] += LANDING_AHEAD_S;
        }
        let leaves = self.flights[m].direction == Direction::Departure;
        let release = (0..count)
            .map(|k| {
                let off_m = way.ends_m[k] + behind_m;
                let into = (k..count).find(|j| stops_m[*j] >= off_m);
                if let Some(into) = into.filter(|j| *j + 1 < count) {
                    let back_s = at(stops_m[into]) - at(off_m);
                    return Some((into, back_s.clamp(0.0, pass_s[into])));
                }
                if leaves {
                    return Some((count - 1, -(READY_S + self.run_s(m))));
                }
                // On the stand all but what is under the aircraft is released.
                let stays = mover.parked_pieces.contains(&way.pieces[k]);
                (!stays).then_some((count - 1, -10.0))
            })
            .collect();
        let mut runways = Vec::new();
        for (k, r) in &way.crossings {
            runways.push((*k, *r, 40.0));
        }
        let r = self.flights[m].runway.0;
        let fixed = landing;
        if leaves {
            let gap = match self.flights[m].wake {
                WakeCategory::Heavy | WakeCategory::Super => 140.0,
                _ => 90.0,
            };
            runways.push((mover.threshold as usize, r, self.slot_s(m).max(gap)));
        }
        let zeros = vec![0.0; count];
        Timing {
            planned: false,
            first,
            pushed,
            push_s,
            push_take_s: 0.0,
            pass_s,
            release,
            take_s: zeros.clone(),
            front_s: zeros.clone(),
            order_s: zeros,
            runways,
            fixed,
        }
    }

    /// Whether the planned order says who goes first over two pieces that conflict: not where one is on the centreline of a
    /// runway and the other in a strip. Whoever takes such a piece leaves the strip without taking anything more.
    fn in_order(&self, piece: u32, other: u32) -> bool {
        let [a, b] = [piece, other].map(|z| &self.pieces.list[z as usize]);
        a.off_strip() || b.off_strip() || a.runway.or(b.runway).is_none()
    }

    /// Steps of a mover that are planned and not yet taken.
    fn open_steps(&self, m: usize) -> Range<usize> {
        let mover = &self.movers[m];
        if !mover.timing.planned {
            return 0..0;
        }
        let from = match mover.phase {
            Phase::Parked => mover.timing.pushed,
            Phase::Pushing => mover.timing.pushed,
            Phase::Gone | Phase::Docked | Phase::Absent | Phase::GoAround => return 0..0,
            _ => self.taken(m),
        };
        from..mover.way.pieces.len()
    }

    /// Steps before this one have had their turn in the order: what is taken, and with a line-up the roll.
    fn taken(&self, m: usize) -> usize {
        let mover = &self.movers[m];
        if mover.next == mover.roll_from { mover.way.pieces.len() } else { mover.next }
    }

    /// Every use of every piece that others have or plan, by piece. `without`: nobody, or a mover whose uses do
    /// not count.
    fn uses(&self, without: usize) -> Vec<Vec<Use>> {
        let mut uses = vec![Vec::new(); self.pieces.list.len()];
        let ever = |mover: usize, from_s: f64, to_s: f64| Use { mover, from_s, to_s };
        for (m, mover) in self.movers.iter().enumerate().filter(|(m, _)| *m != without) {
            let t = &mover.timing;
            match mover.phase {
                Phase::Absent | Phase::Gone | Phase::GoAround => continue,
                Phase::Parked | Phase::Docked => {
                    let leaves = mover.phase == Phase::Parked && t.planned;
                    let until = if leaves { t.push_take_s } else { f64::INFINITY };
                    for z in &mover.parked_pieces {
                        uses[*z as usize].push(ever(m, f64::NEG_INFINITY, until));
                    }
                    if !leaves {
                        continue;
                    }
                }
                _ => {}
            }
            if !t.planned {
                for (z, holders) in self.holders.iter().enumerate() {
                    if holders.contains(&(m as u32)) {
                        uses[z].push(ever(m, f64::NEG_INFINITY, f64::INFINITY));
                    }
                }
                continue;
            }
            if matches!(mover.phase, Phase::Parked | Phase::Pushing) {
                let from =
                    if mover.phase == Phase::Parked { t.push_take_s } else { f64::NEG_INFINITY };
                for z in &mover.push.pieces {
                    uses[*z as usize].push(ever(m, from, t.push_take_s + t.push_s.1));
                }
            }
            let pushing = matches!(mover.phase, Phase::Parked | Phase::Pushing);
            let held_from = if pushing { t.first } else { mover.first_held };
            for k in held_from..mover.way.pieces.len() {
                let taken =
                    !pushing && k < self.taken(m) || mover.phase == Phase::Pushing && k < t.pushed;
                let from = if taken { f64::NEG_INFINITY } else { t.take_s[k] };
                uses[mover.way.pieces[k] as usize].push(ever(m, from, t.release_s(k)));
            }
            let arrives = self.flights[m].direction == Direction::Arrival;
            if let Some(last) = t.take_s.last().filter(|_| arrives && mover.phase != Phase::Docked)
            {
                for z in &mover.parked_pieces {
                    uses[*z as usize].push(ever(m, *last, f64::INFINITY));
                }
            }
        }
        uses
    }

    /// Uses by others of what conflicts with a piece for a class.
    fn against<'a>(
        &'a self,
        uses: &'a [Vec<Use>],
        m: usize,
        piece: u32,
    ) -> impl Iterator<Item = Use> + 'a {
        let class = self.movers[m].class;
        let conflicts = self.pieces.conflicts(piece as usize, class).iter();
        conflicts.filter(move |c| self.in_order(piece, c.0)).flat_map(move |(other, least)| {
            uses[*other as usize]
                .iter()
                .filter(move |u| u.mover != m && self.movers[u.mover].class >= *least)
                .copied()
        })
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
    pub(super) fn others(&self, m: usize) -> Others {
        Others { pieces: self.uses(m), runways: self.runway_uses(m) }
    }

    /// The earliest times of a mover's way among what the others do: the least fixed point of "whoever would meet
    /// a use waits until it ends". `None` if there is none within the horizon, or a landing would have to wait.
    ///
    /// Every bound only rises, and a later take never makes an earlier release, so the first assignment without
    /// a meeting is the earliest of all for each step.
    fn schedule(&self, m: usize, mut t: Timing, from_s: f64, others: &Others) -> Option<Timing> {
        let way = &self.movers[m].way;
        let count = way.pieces.len();
        let Others { pieces: uses, runways: runway_uses } = others;
        let start = if t.pushed > 0 { t.first } else { self.movers[m].next };
        let mut against: Vec<Vec<Use>> = vec![Vec::new(); count];
        for k in start..count {
            against[k] = self.against(uses, m, way.pieces[k]).collect();
        }
        let mut pushed_against: Vec<Use> = Vec::new();
        if t.pushed > 0 {
            for z in &self.movers[m].push.pieces {
                pushed_against.extend(self.against(uses, m, *z));
            }
        }
        // Until it is pushed back nobody can be planned over its stand; who is already has to come later.
        let mut over_stand_s = f64::INFINITY;
        for z in self.movers[m].parked_pieces.iter().filter(|_| t.pushed > 0) {
            let uses = self.against(uses, m, *z).map(|u| u.from_s);
            over_stand_s = uses.fold(over_stand_s, f64::min);
        }
        let mut least = vec![f64::NEG_INFINITY; count];
        let mut least_push = from_s;
        let horizon = from_s + HORIZON_S;
        for _ in 0..4000 {
            self.forward(m, &mut t, least_push, &least, from_s);
            if t.take_s.last().is_some_and(|l| *l > horizon) {
                return None;
            }
            let mut met = false;
            if t.pushed > 0 {
                let (take, done) = (t.push_take_s, t.push_take_s + t.push_s.1);
                for u in &pushed_against {
                    if take < u.to_s && u.from_s < done {
                        least_push = least_push.max(u.to_s + PAUSE_S);
                        met = true;
                    }
                }
                for k in t.first..t.pushed {
                    let until = t.release_s(k);
                    for u in &against[k] {
                        if take < u.to_s && u.from_s < until {
                            least_push = least_push.max(u.to_s + PAUSE_S);
                            met = true;
                        }
                    }
                }
            }
            for k in t.pushed.max(start)..count {
                let (take, until) = (t.take_s[k], t.release_s(k));
                for u in &against[k] {
                    if take < u.to_s && u.from_s < until {
                        least[k] = least[k].max(u.to_s + PAUSE_S);
                        met = true;
                    }
                }
            }
            for (k, r, for_s) in &t.runways {
                if *k < start {
                    continue;
                }
                let take = t.take_s[*k];
                let lines_up = self.flights[m].direction == Direction::Departure
                    && *k == self.movers[m].threshold as usize;
                for u in &runway_uses[*r] {
                    // Who lines up does so behind a landed one.
                    let to = if lines_up { u.passed_s } else { u.to_s };
                    if take < to && u.from_s < take + for_s {
                        least[*k] = least[*k].max(to + PAUSE_S);
                        met = true;
                    }
                }
            }
            let late = t.pushed > 0 && t.push_take_s > over_stand_s;
            if late || least_push > horizon || least.iter().any(|l| *l > horizon) {
                return None;
            }
            if !met {
                let late = t.fixed && t.take_s[start] > from_s + 0.5;
                t.planned = !late;
                t.order_s.clone_from(&t.take_s);
                return (!late).then_some(t);
            }
        }
        None
    }

    /// Takes and fronts from the bounds.
    fn forward(&self, m: usize, t: &mut Timing, push_s: f64, least: &[f64], from_s: f64) {
        let way = &self.movers[m].way;
        let count = way.pieces.len();
        let mut front = from_s;
        let mut k = if t.pushed > 0 { t.pushed } else { self.movers[m].next };
        if t.pushed > 0 {
            t.push_take_s = push_s;
            front = push_s + t.push_s.0;
            t.take_s[..t.pushed].fill(push_s);
            t.front_s[..t.pushed].fill(front);
        } else if k > 0 {
            // What is held already: the front reaches its end by the rest of the way alone.
            front = self.front_of_held(m, t, from_s);
        }
        while k < count {
            let last = way.group_last[k].min(count - 1).max(k);
            let bound = least[k..=last].iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let take = front.max(bound);
            front = take;
            for i in k..=last {
                front += t.pass_s[i];
                t.take_s[i] = take;
                t.front_s[i] = front;
            }
            k = last + 1;
        }
    }

    /// When the front reaches the end of what is held, driven alone from now; the fronts of these steps.
    fn front_of_held(&self, m: usize, t: &mut Timing, now: f64) -> f64 {
        let mover = &self.movers[m];
        let mut front = now;
        let mut begin = 0.0;
        for k in 0..self.taken(m).min(mover.way.pieces.len()) {
            let (place, end) = (mover.s, self.stop_before_m(m, k + 1));
            let share =
                if end > begin { ((end - place) / (end - begin)).clamp(0.0, 1.0) } else { 0.0 };
            front += t.pass_s[k] * share;
            t.front_s[k] = front;
            begin = end;
        }
        front
    }

    /// Plans a mover whose way has just been made; `true` if it has a plan now.
    pub(super) fn plan(&mut self, m: usize, start: Start, from_s: f64) -> bool {
        let (timing, others) = (self.timing(m, start), self.others(m));
        self.plan_among(m, timing, from_s, &others)
    }

    /// The same with [`Core::timing`] of the way and [`Core::others`] of the mover at hand.
    pub(super) fn plan_among(
        &mut self,
        m: usize,
        timing: Timing,
        from_s: f64,
        others: &Others,
    ) -> bool {
        match self.schedule(m, timing, from_s, others) {
            Some(timing) => {
                self.movers[m].timing = timing;
                true
            }
            None => {
                self.movers[m].timing = Timing::default();
                false
            }
        }
    }

    /// Planned end: line-up or stand, s.
    pub(super) fn planned_end_s(&self, m: usize) -> f64 {
        self.movers[m].timing.take_s.last().copied().unwrap_or(f64::INFINITY)
    }

    /// Steps at which a mover would wait longest: their edges, for another way.
    pub(super) fn waits_at(&self, m: usize) -> Vec<usize> {
        let mover = &self.movers[m];
        let t = &mover.timing;
        let mut edges = Vec::new();
        for k in t.pushed.max(1)..mover.way.pieces.len() {
            if t.take_s[k] - t.front_s[k - 1] > 10.0 {
                edges.push(self.pieces.list[mover.way.pieces[k] as usize].edge);
            }
        }
        edges
    }
}

/// Where a planned way begins.
#[derive(Clone, Copy, Debug)]
pub(super) enum Start {
    /// After a pushback: nose wheel, first step under the tail, first step that is not under the mover, duration of
    /// the pushback, and from its take to the front at the end of what is under the mover.
    Stand { place_m: f64, first: usize, pushed: usize, push_s: f64, front_s: f64 },
    /// Over the threshold.
    Final,
    /// On its way already: what it holds is taken.
    UnderWay,
}
