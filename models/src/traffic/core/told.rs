//! What a person clears onto a runway: the pilot does it whatever the plan says, and stops for what he sees.
//!
//! A clearance of a model, or of the plan, is permission; space is the core's. A person's is used: where the runway's
//! pieces are another's, they are taken all the same. From then on, until he is off the strip or in the air, nothing but eyes keeps
//! such a mover and the others apart: he holds what is under him, so nobody new takes it, and whoever has a part of it
//! already brakes for the body that he sees. He also waits short of the way of whoever comes towards it within seconds, and who
//! crosses looks along the runway first.
//! Who is about to land goes around when somebody stands on the runway; who rolls, and can still stop, does.

use super::{Core, Direction, Flight, Phase, Policy};
use crate::control::clearance::ClearanceKind;
use crate::frames::{Azimuth, Point2};
use crate::traffic::outline::{Rectangle, Size, distance_m, outline};
use crate::traffic::profile::stopping_speed_mps;
use crate::traffic::runway_roll::NAUTICAL_MILE_M;
use crate::traffic::tractrix;

mod gives_way;

/// Room that is kept to a body that is seen, m, and to one that will be there (assumed).
const ROOM_M: f64 = 5.0;
/// Somebody who comes is waited for if he is there sooner than this after oneself, s (assumed).
const AFTER_S: f64 = 4.0;
/// Longest look ahead at the way of somebody who comes, s (assumed).
const AHEAD_S: f64 = 12.0;
/// Distance between the places of its way that a pilot looks at, m.
const STEP_M: f64 = 3.0;
/// From there a pilot on final looks whether somebody stands on the runway, m (assumed): alarms come before.
const LOOKS_M: f64 = 0.5 * NAUTICAL_MILE_M;
/// Braking for what is seen, m/s²: taxiing hard, on the runway as hard as anybody does.
const HARD_MPS2: f64 = 1.5;
const HARDEST_MPS2: f64 = 3.0;
/// Share of the lift-off speed below which a take-off is rejected (assumed).
const REJECTS_BELOW: f64 = 0.8;
/// After a rejected take-off, s (assumed): until it can roll again, or is towed away where the runway left is too short.
const RESTS_S: f64 = 30.0;

/// What somebody covers now or in some seconds.
struct Body {
    /// Whose, as [`Core::name_of`] counts.
    who: usize,
    after_s: f64,
    middle_m: Point2<f64>,
    reach_m: f64,
    outline: [Rectangle; 2],
}

fn body(who: usize, size: Size, middle_m: Point2<f64>, heading_rad: f64, after_s: f64) -> Body {
    let reach_m = 0.5 * libm::hypot(size.length_m, size.span_m);
    Body { who, after_s, middle_m, reach_m, outline: outline(size, middle_m, heading_rad) }
}

impl Body {
    /// Distance to another, m, as far as it is less than `most_m`.
    fn within_m(&self, other: &Self, most_m: f64) -> f64 {
        let least = (self.middle_m - other.middle_m).norm() - self.reach_m - other.reach_m;
        if least >= most_m { f64::INFINITY } else { distance_m(&self.outline, &other.outline) }
    }
}

impl Core {
    /// A flight does what a person clears it for; of push-backs and taxiing that is permission as ever.
    pub(super) fn insist(&mut self, m: usize, kind: ClearanceKind) {
        use ClearanceKind::{Cross, GoAround, Land, LineUp, TakeOff};
        if kind == GoAround {
            if self.movers[m].phase == Phase::Final {
                self.give_up_landing(m, "it was told to");
            }
            return;
        }
        self.movers[m].granted.set(kind, true);
        if matches!(kind, Cross | Land | LineUp | TakeOff) {
            self.movers[m].insisted.set(kind, true);
        }
    }

    /// A take-off that is cancelled: stops if it still can.
    pub(super) fn cancel_take_off(&mut self, m: usize) {
        if self.may_reject(m) {
            self.movers[m].rejects = true;
        }
    }

    fn may_reject(&self, m: usize) -> bool {
        let (mover, lift_off_mps) = (&self.movers[m], self.lift_off_mps(m));
        mover.phase == Phase::Rolling && mover.v < REJECTS_BELOW * lift_off_mps
    }

    /// What a flight could be cleared for now by a person, though nobody would ask for it: at the line of its runway or of one
    /// that it crosses, lined up, on final.
    pub(super) fn could(&self, flight: usize) -> Option<ClearanceKind> {
        let mover = self.movers.get(flight)?;
        let departs = self.flights[flight].direction == Direction::Departure;
        let kind = match mover.phase {
            Phase::Taxiing if departs && mover.next == mover.threshold as usize => {
                ClearanceKind::LineUp
            }
            Phase::Taxiing if mover.way.crossings.iter().any(|c| c.0 == mover.next) => {
                ClearanceKind::Cross
            }
            Phase::LinedUp(_) => ClearanceKind::TakeOff,
            Phase::Rolling if self.may_reject(flight) => ClearanceKind::Revoke,
            Phase::Final if mover.cleared => ClearanceKind::GoAround,
            Phase::Final if self.state(flight).is_some() => ClearanceKind::Land,
            _ => return None,
        };
        (!mover.granted.has(kind)).then_some(kind)
    }

    /// Takes the group that begins at `next` by a person's word, whoever has it.
    pub(super) fn take_told(&mut self, m: usize) -> bool {
        let mover = &self.movers[m];
        let (first, crossings) = (mover.next, &mover.way.crossings);
        let departs = self.flights[m].direction == Direction::Departure;
        let kind = if departs && first == mover.threshold as usize {
            ClearanceKind::LineUp
        } else if !departs && first == 0 {
            ClearanceKind::Land
        } else if crossings.iter().any(|c| c.0 == first) {
            ClearanceKind::Cross
        } else {
            return false;
        };
        if !mover.insisted.has(kind) {
            return false;
        }
        // First in the order, where the others' plans allow that; what else they planned stays in it.
        if self.policy == Policy::Planned && self.land_first(m) {
            self.movers[m].refused_at = None;
            if self.take_free(m) {
                return true;
            }
        }
        let Some(group) = self.next_group(m) else { return false };
        if group.crossed.iter().any(|r| self.bar_sticks(*r)) {
            return false;
        }
        self.seize(m, group);
        self.goes_by_sight(m);
        true
    }

    /// From now on only eyes keep it and the others apart.
    pub(super) fn goes_by_sight(&mut self, m: usize) {
        if !self.by_sight.contains(&m) {
            self.by_sight.push(m);
        }
    }

    /// Lines up by a person's word: whose the runway is stays, it comes behind.
    pub(super) fn joins_runway(&mut self, m: usize) {
        let r = self.flights[m].runway.0;
        match self.owner[r].filter(|o| *o != m) {
            None => self.owner[r] = Some(m),
            Some(_) => drop(self.behind[r].get_or_insert(m)),
        }
    }

    /// Takes the runway for a roll by a person's word.
    pub(super) fn take_roll_told(&mut self, m: usize) -> bool {
        if !(self.may_roll(m) && self.take_roll(m, false)) {
            self.goes_by_sight(m);
            self.take_roll(m, true);
        }
        true
    }

    /// One that goes by sight does not wait for the runway's owner if that one waits behind it.
    pub(super) fn waits_in_front(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        self.by_sight.contains(&m)
            && self.crossing[r].iter().all(|c| {
                let other = self.owner[*c].filter(|o| *o != m);
                other.is_none_or(|o| *c == r && matches!(self.movers[o].phase, Phase::LinedUp(_)))
            })
            && self.movers[m].way.pieces[self.movers[m].next..]
                .iter()
                .all(|z| self.blocker(m, *z, true, &[]).is_none())
    }

    /// By mover: who has come onto its runway behind it by a person's word. He keeps off by his eyes, and cannot go before it has gone.
    pub(super) fn told_behind(&self, m: usize) -> Vec<bool> {
        let mut behind = vec![false; self.movers.len()];
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let along_m = |o: usize| {
            let place_m = runway.place_m(self.state(o)?.position_m.xy()).0;
            Some(if end == 0 { place_m } else { runway.length_m - place_m })
        };
        let Some(own_m) = along_m(m) else { return behind };
        for o in self.by_sight.iter().copied().filter(|o| *o != m) {
            let lines_up = self.flights[o].direction == Direction::Departure
                && self.flights[o].runway == (r, end)
                && matches!(self.movers[o].phase, Phase::Taxiing | Phase::LinedUp(_));
            behind[o] = lines_up && along_m(o).is_some_and(|place_m| place_m < own_m);
        }
        behind
    }

    /// Distance that is free before the guided point of a mover, m, as its pilot sees it; `None` while nobody goes by sight or nothing
    /// is near.
    pub(super) fn sees_free_m(&self, m: usize) -> Option<f64> {
        self.sees(m).map(|(free_m, _)| free_m)
    }

    /// The same, and who is there: a flight or, behind flights and obstacles, a mover that a person drives.
    pub(super) fn sees(&self, m: usize) -> Option<(f64, usize)> {
        if self.by_sight.is_empty() && self.hands.is_empty() {
            return None;
        }
        let own = self.by_sight.contains(&m);
        let mover = &self.movers[m];
        let size = self.flights[m].size;
        let here = self.state(m)?;
        let brakes = if mover.phase == Phase::Taxiing { HARD_MPS2 } else { HARDEST_MPS2 };
        let look_m = mover.v * mover.v / (2.0 * brakes) + 1.5 * mover.v + 20.0;
        let near_m = look_m + 70.0 * AHEAD_S + 100.0;
        let mut bodies: Vec<Body> = Vec::new();
        // Who crosses before somebody fast lets nobody else pass: he would stop in that one's way.
        let (mut gives_way, mut hurries): (Option<(f64, usize)>, bool) = (None, false);
        let seen = |o: &usize| *o != m && (own || self.by_sight.contains(o));
        for o in (0..self.movers.len()).filter(seen) {
            match self.gives_way_m(m, o) {
                Some(free_m) if free_m.is_infinite() => hurries = true,
                Some(free_m) if gives_way.is_none_or(|g| free_m < g.0) => {
                    gives_way = Some((free_m, o));
                }
                _ => {}
            }
        }
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            if !(own || self.by_sight.contains(&o)) {
                continue;
            }
            let on_ground = |s: &crate::truth::TruthState| s.position_m.z < 12.0;
            let Some(state) = self.state(o) else { continue };
            if (state.position_m - here.position_m).xy().norm() > near_m {
                continue;
            }
            let theirs = self.flights[o].size;
            if on_ground(&state) {
                bodies.push(body(o, theirs, state.position_m.xy(), state.heading_rad, 0.0));
            }
            // Of two who go by sight, the later one in the list lets the other pass.
            let yields = own && !(self.by_sight.contains(&o) && o > m) && !hurries;
            if yields && self.movers[o].v > 0.5 {
                bodies.extend(self.will_cover(o, theirs, AHEAD_S));
            }
        }
        for (n, hand) in self.hands.iter().enumerate() {
            let who = self.hand_number(n);
            if (hand.middle_m() - here.position_m.xy()).norm() < near_m {
                let way = hand.stopping().into_iter();
                bodies.extend(
                    way.map(|(after_s, at, heading)| body(who, hand.of.size, at, heading, after_s)),
                );
            }
        }
        if bodies.is_empty() {
            return gives_way;
        }
        let now = body(m, size, here.position_m.xy(), here.heading_rad, 0.0);
        // Who is in the way of somebody already goes on; to who stands there, no nearer than now.
        let apart: Vec<f64> = bodies.iter().map(|b| now.within_m(b, ROOM_M)).collect();
        let steps = (look_m / STEP_M) as usize;
        for (k, then) in self.drawn_ahead(m, steps).enumerate() {
            let ahead_m = STEP_M * (k + 1) as f64;
            let at_s = ahead_m / mover.v.max(3.0);
            let meets = bodies.iter().zip(&apart).find(|(b, apart)| {
                let in_time = b.after_s <= at_s + AFTER_S;
                let present = b.after_s == 0.0;
                if !in_time || !present && **apart < ROOM_M {
                    return false;
                }
                then.within_m(b, ROOM_M) < apart.min(ROOM_M) - 0.05
            });
            if let Some((met, _)) = meets {
                let free_m = (ahead_m - STEP_M).max(0.0);
                return gives_way.filter(|g| g.0 < free_m).or(Some((free_m, met.who)));
            }
        }
        gives_way
    }

    /// What it covers at the next places of its way, [`STEP_M`] apart, as it will be drawn along.
    fn drawn_ahead(&self, m: usize, steps: usize) -> impl Iterator<Item = Body> + '_ {
        let (mover, Flight { size, wheelbase_m, .. }) = (&self.movers[m], &self.flights[m]);
        let guided_m = 0.4 * size.length_m;
        (1..=steps).scan(mover.slip, move |slip, k| {
            let ahead_m = STEP_M * k as f64;
            let heading = |on: f64| mover.way.path.heading_rad(mover.s + ahead_m - STEP_M + on);
            *slip = tractrix::drawn_slip_rad(*slip, STEP_M, *wheelbase_m, heading);
            let on = mover.way.path.at(mover.s + ahead_m);
            let heading_rad = on.heading_rad - *slip;
            let middle_m = on.at_m - Azimuth::from_rad(heading_rad).unit() * guided_m;
            Some(body(m, *size, middle_m, heading_rad, 0.0))
        })
    }

    /// What a mover covers in the next seconds if it goes on as it does, while it is on the ground.
    fn will_cover(&self, o: usize, size: Size, ahead_s: f64) -> Vec<Body> {
        let other = &self.movers[o];
        let on_way =
            matches!(other.phase, Phase::Taxiing | Phase::Landing | Phase::Rolling | Phase::Final);
        if !on_way {
            return Vec::new();
        }
        let guided_m = 0.4 * size.length_m;
        let step_s = (0.5 * size.length_m / other.v).clamp(0.25, 2.0);
        let times = (1..=(ahead_s / step_s) as usize).map(|k| step_s * k as f64);
        let mut bodies = Vec::new();
        for after_s in times {
            if other.height_m + other.climb_mps * after_s > 12.0 {
                continue;
            }
            let gone_m = other.v * after_s + 0.5 * other.a.max(0.0) * after_s * after_s;
            let on = other.way.path.at(other.s + gone_m - guided_m);
            bodies.push(body(o, size, on.at_m, on.heading_rad, after_s));
        }
        bodies
    }

    /// The speed that lets a taxiing or landing mover stop for what it sees, m/s, and the braking for it, m/s².
    pub(super) fn wish_by_sight(&self, m: usize) -> Option<(f64, f64)> {
        let free_m = self.sees_free_m(m)?;
        let taxies = self.movers[m].phase == Phase::Taxiing;
        let dec = if taxies { HARD_MPS2 } else { HARDEST_MPS2 };
        let wish =
            if free_m < 1.0 { 0.0 } else { stopping_speed_mps(free_m, 0.8 * dec, Some(2.0)) };
        Some((wish, dec))
    }

    /// A roll that is rejected for what is ahead, or was cancelled: brakes, then stands lined up again. `true` while it does.
    pub(super) fn rejects_take_off(&mut self, m: usize) -> bool {
        if !self.movers[m].rejects {
            if self.by_sight.is_empty() && self.hands.is_empty() || self.movers[m].height_m > 0.0 {
                return false;
            }
            let Some(free_m) = self.sees_free_m(m) else { return false };
            let (v, lift_off_mps) = (self.movers[m].v, self.lift_off_mps(m));
            // Beyond that speed only if it comes to a stand before it.
            if v >= REJECTS_BELOW * lift_off_mps && v * v / (2.0 * HARDEST_MPS2) > free_m {
                return false;
            }
            self.movers[m].rejects = true;
        }
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        let from = mover.s;
        let a = (-HARDEST_MPS2).clamp(mover.a - 2.0 * dt, mover.a + 2.0 * dt);
        let next_mps = (mover.v + 0.5 * (mover.a + a) * dt).max(0.0);
        mover.s += 0.5 * (mover.v + next_mps) * dt;
        (mover.v, mover.a) = (next_mps, if next_mps > 0.0 { a } else { 0.0 });
        self.follow(m, from);
        if self.movers[m].v == 0.0 {
            self.stands_after_rejecting(m);
        }
        true
    }

    fn stands_after_rejecting(&mut self, m: usize) {
        self.movers[m].rejects = false;
        self.end_clearance(m, "TOF");
        // It is lined up again, until it rolls or is towed away.
        self.clear(m, "LUP", self.end_name(m));
        self.movers[m].phase = Phase::LinedUp(self.time_s + RESTS_S);
        let (name, (r, end)) = (self.flights[m].callsign.clone(), self.flights[m].runway);
        self.remark(format!("{name}: take-off rejected"));
        let runway = &self.net.runways[r];
        let Some(state) = self.state(m) else { return };
        let place_m = runway.place_m(state.position_m.xy()).0;
        let left_m = if end == 0 { runway.length_m - place_m } else { place_m };
        let run_m = self.flights[m].run_m(self.day.density_ratio, self.head_mps(m));
        if run_m.is_some_and(|run_m| left_m > run_m + 100.0) {
            return;
        }
        self.tow_off_runway(m, &format!("{name}: too little runway is left"));
    }

    /// Somebody on the runway ahead whom the pilot of an arrival sees before he lands.
    pub(super) fn seen_on_runway(&self, m: usize) -> Option<usize> {
        let mover = &self.movers[m];
        let to_threshold_m = mover.threshold - mover.s;
        if self.by_sight.is_empty() && self.hands.is_empty()
            || !(0.0..LOOKS_M).contains(&to_threshold_m)
        {
            return None;
        }
        let own = self.by_sight.contains(&m);
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let on_it = |at: Point2<f64>, length_m: f64| {
            let (place_m, across_m) = runway.place_m(at);
            let along_m = if end == 0 { place_m } else { runway.length_m - place_m };
            let half_m = 0.5 * length_m;
            (-60.0..runway.length_m + half_m).contains(&along_m)
                && across_m.abs() < 0.5 * runway.width_m + half_m + 5.0
        };
        let mover = (0..self.movers.len()).filter(|o| *o != m).find(|o| {
            if !(own || self.by_sight.contains(o)) {
                return false;
            }
            // Who rolls ahead is gone when it comes.
            let rolls = self.movers[*o].v > 20.0;
            let state = self.state(*o).filter(|s| s.position_m.z < 12.0 && !rolls);
            state.is_some_and(|s| on_it(s.position_m.xy(), self.flights[*o].size.length_m))
        });
        mover.or_else(|| {
            let on_it = |h: &super::hand::Hand| on_it(h.middle_m(), h.of.size.length_m);
            self.hands.iter().position(on_it).map(|n| self.beside_hand(n))
        })
    }

    /// On final, cleared or not: what was taken for the landing is given back, and it goes around.
    pub(super) fn give_up_landing(&mut self, m: usize, why: &str) {
        if self.movers[m].cleared {
            self.release_held(m);
            self.vacate(m);
            self.end_clearance(m, "LND");
        }
        self.go_around(m, why);
    }

    /// Once a second: bodies that touch, as nothing but eyes kept them apart.
    pub(super) fn look_for_contact(&mut self) {
        let mut found = Vec::new();
        for m in self.by_sight.iter().copied() {
            let Some(state) = self.state(m).filter(|s| s.position_m.z < 3.0) else { continue };
            let own = body(m, self.flights[m].size, state.position_m.xy(), state.heading_rad, 0.0);
            for o in (0..self.movers.len()).filter(|o| *o != m) {
                let Some(state) = self.state(o).filter(|s| s.position_m.z < 3.0) else { continue };
                let theirs =
                    body(o, self.flights[o].size, state.position_m.xy(), state.heading_rad, 0.0);
                if own.within_m(&theirs, 1.0) == 0.0 {
                    found.push((m.min(o), m.max(o)));
                }
            }
        }
        for pair in found {
            if self.contacts.insert(pair) {
                let [a, b] = [pair.0, pair.1].map(|m| self.flights[m].callsign.clone());
                self.remark(format!("{a} and {b} touch"));
            }
        }
    }
}
