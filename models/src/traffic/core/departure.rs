//! Departures: pushback, taxi way, line-up and take-off.

mod enough;
mod push;
mod to_runway;
mod turned;

use push::{Begin, nose_of};
pub(super) use push::{SWING_M, push_heading};
pub(super) use to_runway::Goal;

use super::failures::FailureKind;
use super::plan::Start;
use super::tow::TOWED_OFF_S;
use super::{Core, PUSH_BEFORE_M, Phase, Policy, RETRY_S, TAIL_M, Timing};
use crate::control::clearance::ClearanceKind;
use crate::traffic::runway_roll::take_off_run;
use crate::traffic::way::{Arcs, Driving, Roll, Way};
use std::sync::Arc;

/// Arcs of a pushback up to the bend, arcs behind it, arcs of the way after it.
type Pushback = (Vec<usize>, Vec<usize>, Vec<usize>);

/// Standing under way for so long holds back pushbacks and landings under [`Policy::Ordered`], s (assumed).
const STARVED_S: f64 = 300.0;

/// Who is not cleared to push for so long after his planned time gives his plan up, s (assumed).
const UNCLEARED_S: f64 = 60.0;

impl Core {
    /// On its stand: plans its way when it is due, and pushes back when everything for that is free.
    pub(super) fn parked(&mut self, m: usize) {
        let f = &self.flights[m];
        if self.time_s < f.time_s || self.time_s < self.movers[m].next_try_s {
            return;
        }
        if self.is_vehicle(m) && !self.is_to_drive(m) {
            return;
        }
        if self.kept_by_runway(m) {
            return;
        }
        let uncleared = self.failing(m, FailureKind::PushUncleared).is_some();
        let unplanned = self.movers[m].way.pieces.is_empty();
        if unplanned && self.waits_to_push(m) && !uncleared {
            self.movers[m].next_try_s = self.time_s + 1.0;
            return;
        }
        if self.movers[m].push.pieces.is_empty() && self.held_on_stand(m) && !uncleared {
            self.movers[m].next_try_s = self.time_s + 1.0;
            return;
        }
        self.movers[m].next_try_s = self.time_s + RETRY_S;
        if unplanned && !self.find_departure(m) {
            if self.movers[m].waits_since_s.is_none() {
                let text = format!(
                    "{}: no way from stand {} to runway {} now",
                    self.flights[m].callsign,
                    self.net.stands[self.movers[m].stand].name,
                    self.end_name(m)
                );
                self.remark(text);
            }
            let now = self.time_s;
            let since = *self.movers[m].waits_since_s.get_or_insert(now);
            if now - since > 300.0 && self.tow_elsewhere(m) {
                return;
            }
            if now - since > TOWED_OFF_S {
                self.tow_blockers(m);
            }
            self.movers[m].next_try_s = now + 15.0;
            return;
        }
        if unplanned && self.kept_by_its_way(m) {
            return;
        }
        self.movers[m].next_try_s = self.time_s + 1.0;
        if !uncleared && (!self.permitted(m, ClearanceKind::Push) || self.starves(m)) {
            // Whom nobody clears keeps nobody waiting behind his plan: he gets another one when he is cleared.
            if self.waits_to_push(m)
                && self.time_s > self.movers[m].timing.push_take_s + UNCLEARED_S
            {
                self.movers[m].push = Way::default();
                self.movers[m].way = Way::default();
                self.movers[m].timing = Timing::default();
                self.movers[m].waits_since_s = None;
                if self.policy == Policy::Planned {
                    self.book();
                }
            }
            return;
        }
        // All pieces of the pushback at once, and what is under the mover after it.
        let mover = &self.movers[m];
        let under = &mover.way.pieces[mover.under.clone()];
        let group: Vec<u32> = mover.push.pieces.iter().chain(under).copied().collect();
        let planned = self.policy == Policy::Planned;
        let order_s = mover.timing.push_take_s;
        let before =
            planned.then(|| group.iter().find_map(|z| self.planned_before(m, *z, order_s)));
        let blocker =
            group.iter().find_map(|z| self.blocker(m, *z, false, &[])).or_else(|| before.flatten());
        let mut free = blocker.is_none();
        if free {
            group.iter().for_each(|z| self.hold(m, *z, false));
            if self.policy == Policy::Ordered
                && !self.ordered(m, self.movers[m].push.pieces.len(), self.movers[m].under.end)
            {
                group.iter().for_each(|z| self.release_quietly(m, *z, false));
                free = false;
            }
        }
        if !free {
            let now = self.time_s;
            self.movers[m].waits_for = blocker;
            let since = *self.movers[m].waits_since_s.get_or_insert(now);
            if self.is_vehicle(m) {
                if now - since > TOWED_OFF_S {
                    self.gives_up_drive(m);
                }
                return;
            }
            if self.shut_in(m, blocker) {
                return;
            }
            // The way was made for a world that has changed: another one next time.
            if !planned || now > self.movers[m].timing.push_take_s + 60.0 && now > since + 60.0 {
                let old = self.movers[m].clone();
                let timings: Vec<Timing> = self.movers.iter().map(|o| o.timing.clone()).collect();
                self.movers[m].push = Way::default();
                self.movers[m].way = Way::default();
                self.movers[m].timing = Timing::default();
                if planned {
                    self.book();
                    // Others may be planned over its stand: what does not fit in leaves the old plan, and the times of the others
                    // as they were with it: re-timed without it they may come after it, who were before.
                    if !self.find_departure(m) {
                        for (other, timing) in self.movers.iter_mut().zip(timings) {
                            other.timing = timing;
                        }
                        self.movers[m] = old;
                        self.book();
                    }
                }
                self.movers[m].waits_since_s = Some(now);
                self.movers[m].next_try_s = now + RETRY_S;
            }
            return;
        }
        if planned {
            group.iter().for_each(|z| self.booked_now(m, *z));
        }
        self.used(m, ClearanceKind::Push);
        let parked = std::mem::take(&mut self.movers[m].parked_pieces);
        parked.iter().for_each(|z| self.release(m, *z, false));
        let now = self.time_s;
        let guided = 0.4 * self.flights[m].size.length_m;
        let short_m = self.short_of_node_m(self.movers[m].stand, self.flights[m].size);
        let mover = &mut self.movers[m];
        mover.phase = Phase::Pushing;
        mover.wander = mover.wander.anew();
        mover.shut_in_since_s = None;
        mover.timing.push_take_s = now;
        mover.measures.aobt_s = Some(now);
        mover.waits_since_s = None;
        mover.waits_for = None;
        let short_m = short_m + mover.stands_short_m;
        mover.s = PUSH_BEFORE_M - (guided - self.flights[m].wheelbase_m) + short_m;
        if mover.turned {
            self.starts_ahead(m);
            return;
        }
        match self.failing(m, FailureKind::PushUncleared) {
            Some(failure) => self.begin_failure(failure),
            None => self.clear(m, "PSH", String::new()),
        }
    }

    /// Whether a flight has asked for its push-back and is not cleared.
    fn waits_to_push(&self, m: usize) -> bool {
        self.movers[m].wants == Some(ClearanceKind::Push)
    }

    /// Under the banker's rule whoever comes new may pass by somebody who waits, again and again: nobody is pushed back while
    /// somebody under way has stood for [`STARVED_S`], and nobody released to final, who could keep him off a runway.
    pub(super) fn starves(&self, m: usize) -> bool {
        let starved = |o: usize| {
            let other = &self.movers[o];
            let since = other.waits_since_s.filter(|_| other.phase == Phase::Taxiing);
            o != m && since.is_some_and(|since| self.time_s - since > STARVED_S)
        };
        self.policy == Policy::Ordered && (0..self.movers.len()).any(starved)
    }

    /// The departure's way: of several, under a plan, the one that is lined up first.
    pub(super) fn find_departure(&mut self, m: usize) -> bool {
        let (closed, opposed) = (self.closed(m), self.opposed(m));
        if self.policy != Policy::Planned {
            let found = self.plan_departure(m, &closed, &opposed, &[]);
            self.draw_cleared_way(m);
            return found;
        }
        self.retime();
        let now = self.time_s;
        let others = self.others(m);
        let lasting = self.closed_for_ever(m);
        let none = vec![false; opposed.len()];
        let mut best: Option<(f64, super::Mover)> = None;
        let mut tried: Vec<usize> = Vec::new();
        let mut planned: Vec<Pushback> = Vec::new();
        let mut slow = opposed;
        let mut shut = closed;
        for attempt in 0..5 {
            let pushback = self.find_pushback(m, &shut, &slow, &tried);
            // The same again: so would all that follow be.
            if attempt > 0 && pushback.as_ref().is_some_and(|p| planned.contains(p)) {
                break;
            }
            let Some(pushback) = pushback.filter(|p| self.lay_pushback(m, p)) else {
                if attempt == 0 {
                    (shut, slow) = (lasting.clone(), none.clone());
                    continue;
                }
                if tried.is_empty() {
                    break;
                }
                tried.clear();
                continue;
            };
            let timing = self.timing(m, self.start_of_push(m));
            let rivals = self.rivals(m, &timing, &others);
            if self.plan_among(m, timing, now, &rivals) {
                planned.push(pushback);
                let end = self.planned_end_s(m);
                let waits = self.waits_at(m);
                if best.as_ref().is_none_or(|b| end < b.0 - 1.0) {
                    best = Some((end, self.movers[m].clone()));
                }
                if waits.is_empty() && attempt > 0 {
                    break;
                }
                for e in waits {
                    slow[2 * e] = true;
                    slow[2 * e + 1] = true;
                }
            } else {
                // Not by this pushback.
                tried.extend(self.movers[m].push.arcs.last());
            }
            if attempt == 0 {
                shut.clone_from(&lasting);
            }
        }
        let found = best.is_some();
        match best {
            Some((_, mover)) => {
                self.movers[m] = mover;
                self.draw_cleared_way(m);
            }
            None => {
                self.movers[m].push = Way::default();
                self.movers[m].way = Way::default();
                self.movers[m].timing = Timing::default();
            }
        }
        self.book();
        found
    }

    /// Where and when the taxi way begins for the plan.
    pub(super) fn start_of_push(&self, m: usize) -> Start {
        let mover = &self.movers[m];
        if mover.turned {
            return self.start_ahead(m);
        }
        let push_s = (mover.push.stop_m - mover.s.max(0.0)).max(0.0) / 1.4 + 8.0;
        let (_, place_m, _) = self.after_push(m, mover.push.stop_m);
        Start::Stand { place_m, first: mover.under.start, pushed: mover.under.end, push_s }
    }

    /// Pushback and way to the runway.
    ///
    /// `without`: last arcs of pushbacks that are not wanted.
    pub(super) fn plan_departure(
        &mut self,
        m: usize,
        closed: &[bool],
        slow: &[bool],
        without: &[usize],
    ) -> bool {
        let pushback = self.find_pushback(m, closed, slow, without);
        pushback.is_some_and(|p| self.lay_pushback(m, &p))
    }

    /// The pushback from which the way to the runway is the quickest, and the arcs of that.
    fn find_pushback(
        &mut self,
        m: usize,
        closed: &[bool],
        slow: &[bool],
        without: &[usize],
    ) -> Option<Pushback> {
        if self.movers[m].turned {
            return self.find_way_ahead(m, closed, slow);
        }
        let f = Arc::clone(&self.flights);
        let f = &f[m];
        let net = Arc::clone(&self.net);
        let into = net.stands[self.movers[m].stand].node.and_then(|n| self.stand_arc(n))?;
        let mut closed = closed.to_vec();
        closed[into / 2] = false;
        // Back along the lead-in to where it joins a lane.
        let mut back = vec![into ^ 1];
        loop {
            let node = Arcs::to(&net, back[back.len() - 1]);
            let came = back[back.len() - 1] / 2;
            let mut on = self.arcs.away_from(&net, node).filter(|a| a / 2 != came);
            match (on.next(), on.next()) {
                (Some(only), None) if back.len() < 30 && net.nodes[node].stand.is_none() => {
                    back.push(only);
                }
                _ => break,
            }
        }
        let goal = self.goal_of_way(m);
        let length = f.size.length_m;
        // Back to the lane and onto one side of it; where no way leads on from there (a dead end), farther back
        // along the lane to the next junctions. Against one-way lanes only if there is nothing else, and last with scant runway.
        let mut found: Option<(f64, Pushback)> = None;
        let mut options = 0;
        let (wanted_m, scant_m) = goal.least_m();
        for (lenient, least_m) in
            [(false, &wanted_m), (true, &wanted_m), (false, &scant_m), (true, &scant_m)]
        {
            let mut backs: Vec<(f64, Vec<usize>)> = vec![(0.0, back.clone())];
            let mut done = 0;
            while let Some(first) = (0..backs.len())
                .min_by(|p, q| backs[*p].0.total_cmp(&backs[*q].0).then(p.cmp(q)))
                .filter(|_| done < 40 && found.is_none())
            {
                let (farther, back) = backs.swap_remove(first);
                done += 1;
                for (chain, _) in self.sides(&back, &closed, length, lenient) {
                    if chain.last().is_some_and(|c| without.contains(c)) {
                        continue;
                    }
                    options += 1;
                    let (start, last) = (chain[0] ^ 1, back[back.len() - 1]);
                    for least_m in least_m {
                        let ends = |arc: usize| self.ends_way(&goal, arc, *least_m);
                        let is_closed = |e: usize| {
                            (closed[e] && e != start / 2)
                                || e == last / 2
                                || goal.keeps_off(&net.edges[e])
                        };
                        let way =
                            self.arcs.quickest(&net, &[(start, 0.0)], ends, is_closed, |a| slow[a]);
                        if let Some(way) = way {
                            if found.as_ref().is_none_or(|b| way.time_s < b.0) {
                                found = Some((way.time_s, (back.clone(), chain.clone(), way.arcs)));
                            }
                            break;
                        }
                    }
                }
                // Beyond the next junction of each side.
                for arc in self.back_over(&back, &closed, lenient) {
                    let farther = farther + self.arcs.length_m(arc);
                    if farther < 600.0 && back.len() < 30 && !back.contains(&arc) {
                        let mut longer = back.clone();
                        longer.push(arc);
                        backs.push((farther, longer));
                    }
                }
            }
            if found.is_some() {
                break;
            }
        }
        if found.is_none() && self.movers[m].waits_since_s.is_none() && !self.is_vehicle(m) {
            let (name, edges) = (&f.callsign, back.len());
            self.remark(format!("{name}: {options} ways to push back, lead-in of {edges} edges"));
        }
        found.map(|(_, pushback)| pushback)
    }

    /// Lays the lines of a pushback and of the way after it.
    fn lay_pushback(&mut self, m: usize, (back, chain, taxi): &Pushback) -> bool {
        if self.movers[m].turned {
            return self.lay_way_ahead(m, taxi);
        }
        let f = Arc::clone(&self.flights);
        let f = &f[m];
        let net = Arc::clone(&self.net);
        let length = f.size.length_m;
        let class = self.movers[m].class;
        // Taxi: from the far end of the pushback over the lane node to the entry, then along the runway.
        let mut arcs: Vec<usize> = chain.iter().rev().map(|a| a ^ 1).collect();
        let skipped: f64 = chain.iter().map(|a| self.arcs.length_m(*a)).sum();
        arcs.extend(taxi.iter().skip(1));
        let laid = match self.is_vehicle(m) {
            true => self.lay_to_goal(m, &arcs),
            false => self.lay_to_runway(m, arcs),
        };
        let Some(first_strip) = laid else { return false };
        let push_arcs: Vec<usize> = back.iter().chain(chain).copied().collect();
        let mut push = Way::over(&net, &self.pieces, &push_arcs, class, (PUSH_BEFORE_M, 0.0), 0.0);
        // The nose wheel ends 2 m beyond the fillet of lead-in and lane.
        let lane_place = (0..back.len()).map(|k| self.pieces.of_edge[back[k] / 2].1).sum::<usize>();
        let corner = push.ends_m[lane_place - 1];
        let fillet =
            push.path.arcs().find(|(from, to, _)| *from <= corner + 0.1 && *to >= corner - 0.1);
        // And, where there is room, so far on that the nose wheel is on the way that follows.
        let first_m = fillet.map_or(corner, |a| a.1) + f.wheelbase_m + 2.0;
        let tail = (0.9 * length - f.wheelbase_m) + TAIL_M;
        let room_m = push.ends_m.last().map_or(0.0, |end| end - tail - first_m);
        let begin = Begin::of(&self.movers[m].way.path, push.path.length_m());
        let off_m = |gear_m: f64| begin.nearest(nose_of(&push.path, gear_m, f.wheelbase_m)).0;
        let steps = (room_m.clamp(0.0, 60.0) / 2.0) as usize;
        let stops = (0..=steps).map(|k| first_m + 2.0 * k as f64).map(|stop| (off_m(stop), stop));
        let mut best = (f64::INFINITY, first_m);
        for stop in stops {
            if stop.0 < best.0 {
                best = stop;
            }
            if best.0 < 0.2 {
                break;
            }
        }
        push.stop_m = best.1;
        let tail = push.stop_m + tail;
        let needed_pieces =
            push.ends_m.iter().position(|e| *e >= tail).unwrap_or(push.ends_m.len() - 1);
        push.pieces.truncate(needed_pieces + 1);
        push.ends_m.truncate(needed_pieces + 1);
        let at_push = Driving {
            straight_mps: 1.5,
            turn_mps: 1.5,
            acc_mps2: 0.2,
            dec_mps2: 0.2,
            jerk_mps3: 0.3,
            lateral_mps2: 0.5,
        };
        push.limit(&net, &self.pieces, &at_push, &Roll::NONE);
        // The nose stands `wheelbase` before the gear's place, seen from the far end of the chain.
        let pushed = push.stop_m - corner;
        let start = (skipped - pushed) + f.wheelbase_m;
        let mover = &mut self.movers[m];
        let (way, driving) = (&mover.way, &mover.driving);
        mover.measures.unhindered_s = 240.0 + way.unhindered_s(start.max(0.0), way.stop_m, driving);
        mover.push = push;
        let stop = self.movers[m].push.stop_m;
        self.movers[m].under = self.after_push(m, stop).0;
        self.movers[m].under.end <= first_strip
    }

    pub(super) fn arc_between(&self, from: usize, to: usize) -> Option<usize> {
        self.arcs.leaving(from).iter().copied().find(|a| Arcs::to(&self.net, *a) == to)
    }

    pub(super) fn start_taxi(&mut self, m: usize) {
        self.movers[m].phase = Phase::Taxiing;
        self.movers[m].wander = self.movers[m].wander.anew();
        self.movers[m].taxi_from_s = self.time_s;
        self.clear(m, "TAX", String::new());
    }

    pub(super) fn rolling(&mut self, m: usize) {
        if self.rejects_take_off(m) {
            return;
        }
        let f = self.flights[m].clone();
        let day = self.take_off(m);
        // Who can no longer stop when the air becomes too thin goes on as if it had not.
        let (a0, b) = take_off_run(&day).map_or((2.0, 0.0), |r| (r.a_mps2, r.b_per_m));
        let (lift_off_mps, head_mps) = (self.lift_off_mps(m), day.headwind_mps);
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        // It lifts off in the step in which it reaches the speed for that.
        let airborne = mover.height_m > 0.0 || mover.v + mover.a.max(0.0) * dt >= lift_off_mps;
        let wish = if !airborne {
            let airspeed_mps = mover.v + head_mps;
            (a0 - b * airspeed_mps * airspeed_mps).max(0.3)
        } else if mover.v < lift_off_mps + 5.0 {
            0.5
        } else {
            0.0
        };
        // Thrust builds up within 5 s.
        let jerk = if airborne { 2.0 } else { 0.2 * a0 };
        let a = wish.clamp(mover.a - 2.0 * dt, mover.a + jerk * dt);
        let from = mover.s;
        mover.s += mover.v * dt + 0.25 * (mover.a + a) * dt * dt;
        mover.v = (mover.v + 0.5 * (mover.a + a) * dt).max(0.0);
        mover.a = a;
        if airborne {
            let climb = (mover.climb_mps + 1.0 * dt).min(10.0);
            mover.height_m += 0.5 * (mover.climb_mps + climb) * dt;
            mover.climb_mps = climb;
        }
        let lifted = airborne && mover.measures.atot_s.is_none();
        let (height, behind) = (mover.height_m, 0.95 * f.size.length_m + TAIL_M);
        self.follow(m, from);
        if lifted {
            self.movers[m].measures.atot_s = Some(self.time_s);
            self.movers[m].measures.on_runway_s[1] = Some(self.time_s);
            self.end_clearance(m, "TOF");
            self.end_clearance(m, "LUP");
        }
        loop {
            let mover = &self.movers[m];
            let i = mover.first_held;
            if i >= mover.next || !(height > 15.0 || mover.s > mover.way.ends_m[i] + behind) {
                break;
            }
            self.leave_first_held(m);
        }
        if height > 15.0 {
            self.vacate(m);
        }
        if height >= 500.0 {
            self.movers[m].timing = Timing::default();
            self.movers[m].phase = Phase::Gone;
        }
    }
}
