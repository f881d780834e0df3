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

mod late;
mod order;
mod settle;
mod stacks;
mod times;

pub(super) use order::Links;
pub(super) use settle::Times;
pub(super) use times::{Others, Rivals};

use super::{Core, Direction, Phase};
use order::Ends;
use std::ops::Range;

/// Planned times of a mover's way.
#[derive(Clone, Debug, Default)]
pub(super) struct Timing {
    /// Whether there is a plan.
    pub planned: bool,
    /// Its number: another one when its place in the order changes.
    number: u64,
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
    mover: u32,
    taken: Ends,
}

/// Pause between intervals of different movers, s.
const PAUSE_S: f64 = 0.05;
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
            Start::Stand { place_m, first, pushed, push_s } => {
                (place_m, 0.3, push_s, first, pushed)
            }
            Start::Final => {
                (mover.threshold, self.flights[m].landing.0 - self.head_mps(m), 0.0, 0, 0)
            }
            Start::UnderWay => (0.0, 0.3, 0.0, 0, 0),
        };
        let alone = way.alone(from_m, v_mps, &mover.driving);
        let at = |place_m: f64| alone.time_s(place_m);
        // Where it waits for the step after each.
        let stops_m: Vec<f64> = (0..count).map(|k| self.stop_before_m(m, k + 1)).collect();
        let landing = matches!(start, Start::Final);
        let mut before = at(if pushed > 0 { stops_m[pushed - 1] } else { from_m });
        // The engines are started after the pushback.
        let push_s =
            if pushed > 0 { (push_s + self.pause_s(m) + before, push_s) } else { (0.0, 0.0) };
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
                let on = mover.goal.as_ref().map_or(&mover.parked_pieces, |goal| &goal.1);
                let stays = on.contains(&way.pieces[k]);
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
            runways.push((
                mover.threshold as usize,
                r,
                self.slot_s(m).max(self.flights[m].wake.usual_gap_s()),
            ));
        }
        let zeros = vec![0.0; count];
        Timing {
            planned: false,
            number: 0,
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

    /// Brings the times that steps take alone up to date, for those that are still open.
    pub(super) fn passes_anew(&mut self, m: usize) {
        let pushed = self.movers[m].timing.pushed > 0;
        let start = if pushed { self.start_of_push(m) } else { Start::UnderWay };
        let fresh = self.timing(m, start);
        let open = self.open_steps(m);
        let timing = &mut self.movers[m].timing;
        timing.pass_s[open.clone()].copy_from_slice(&fresh.pass_s[open.clone()]);
        timing.release[open.clone()].clone_from_slice(&fresh.release[open]);
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

    /// When the front reaches the end of what is held, driven alone from now; the fronts of these steps.
    fn front_of_held(&self, m: usize, t: &Timing, front_s: &mut [f64], now: f64) -> f64 {
        let mover = &self.movers[m];
        let mut front = now;
        let mut begin = 0.0;
        for k in 0..self.taken(m).min(mover.way.pieces.len()) {
            let (place, end) = (mover.s, self.stop_before_m(m, k + 1));
            let share =
                if end > begin { ((end - place) / (end - begin)).clamp(0.0, 1.0) } else { 0.0 };
            front += t.pass_s[k] * share;
            front_s[k] = front;
            begin = end;
        }
        front
    }

    /// Plans a mover whose way has just been made; `true` if it has a plan now.
    pub(super) fn plan(&mut self, m: usize, start: Start, from_s: f64) -> bool {
        let (timing, others) = (self.timing(m, start), self.others(m));
        let rivals = self.rivals(m, &timing, &others);
        self.plan_among(m, timing, from_s, &rivals)
    }

    /// The same with [`Core::timing`] of the way and [`Core::rivals`] on it at hand.
    pub(super) fn plan_among(
        &mut self,
        m: usize,
        timing: Timing,
        from_s: f64,
        rivals: &Rivals,
    ) -> bool {
        match self.schedule(m, timing, from_s, rivals) {
            Some(timing) => {
                self.movers[m].timing = timing;
                self.replaced(m);
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
    /// the pushback.
    Stand { place_m: f64, first: usize, pushed: usize, push_s: f64 },
    /// Over the threshold.
    Final,
    /// On its way already: what it holds is taken.
    UnderWay,
}

#[cfg(test)]
mod tests;
