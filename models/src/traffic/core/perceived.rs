//! A core from what is known of an airport at a time: tracks, strips and flight plans in place of the truth. For looking ahead.
//!
//! Who is on a stand is put there, who is on final flies on from where he was seen, who is under way on the ground gets the
//! quickest way on from there, along the one that he was cleared for where that is known. Who is on his runway leaves it: a
//! departure has taken off, an arrival goes on at the next exit (assumed). Those who fit into no plan together are left out
//! and told.

use super::arrival::Tried;
use super::plan::Start;
use super::runway::TookOff;
use super::{Core, Day, Direction, Flight, Phase, Policy, TAIL_M};
use crate::frames::{Azimuth, Point2, center, wrap_pi};
use crate::traffic::network::Network;
use crate::traffic::pieces::Pieces;
use crate::traffic::runway_roll::approach_airspeed_mps;
use crate::traffic::way::{Arcs, Roll, Way};
use std::sync::Arc;

/// Somebody on the ground, airport frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OnGround {
    /// Middle of its length, m.
    pub middle_m: Point2<f64>,
    /// Where it looks, rad clockwise from north.
    pub heading_rad: f64,
    /// Ground speed, m/s.
    pub speed_mps: f64,
    /// The way that it was cleared for, m; empty where that is not known.
    pub cleared_way_m: Vec<Point2<f64>>,
    /// Does not move before, s from now: its engines start.
    pub starts_in_s: f64,
    /// Of an arrival: the stand that it was given.
    pub stand: Option<usize>,
}

/// Where a flight is, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Seen {
    /// Nowhere yet: its flight plan says when it comes.
    #[default]
    Planned,
    /// On a stand: before its departure, or after its landing.
    OnStand(usize),
    /// Under way between stand and runway.
    Taxiing(OnGround),
    /// On its runway.
    OnRunway(OnGround),
    /// On final.
    OnFinal {
        /// To the threshold, m.
        distance_m: f64,
        /// The stand that it was given.
        stand: usize,
    },
    /// It is over, or never comes.
    Gone,
}

/// An arc this far beside somebody is none that he is on, m.
const BESIDE_M: f64 = 60.0;
/// An arc is as far away as this where it lies across, m a radian.
const ACROSS_M: f64 = 20.0;
/// Arcs that a way is looked for from.
const TRIED: usize = 6;
/// Who is seen less than this beyond where he has to wait stands there, m: a track is no better.
const BEYOND_M: f64 = 30.0;
/// Off its cleared way, m.
const OFF_WAY_M: f64 = 15.0;
/// Braking of a roll-out up to the exit, m/s² (assumed).
const ROLL_OUT_MPS2: f64 = 1.5;
/// Step of a time on final, m.
const FINAL_STEP_M: f64 = 50.0;

/// Time from a distance to the threshold, s.
fn final_s(distance_m: f64, touchdown_mps: f64, head_mps: f64) -> f64 {
    let steps = (distance_m / FINAL_STEP_M).ceil().clamp(1.0, 2000.0);
    let step_m = distance_m / steps;
    let airspeed_mps = |k: usize| approach_airspeed_mps((k as f64 + 0.5) * step_m, touchdown_mps);
    let pass = |k: usize| step_m / (airspeed_mps(k) - head_mps).max(1.0);
    (0..steps as usize).map(pass).sum()
}

impl Core {
    /// The core of what is seen before a frame, one for each flight, under the planned policy. Also the flights that were seen
    /// and fit into no plan: they are left out.
    #[must_use]
    pub fn perceived(
        (net, pieces): (Arc<Network>, Arc<Pieces>),
        flights: Arc<Vec<Flight>>,
        (seed, step_s, day): (u64, f64, Day),
        frame: i64,
        seen: &[Seen],
    ) -> (Self, Vec<usize>) {
        let mut core = Self::empty(net, pieces, flights, Policy::Planned, seed, step_s);
        core.frame = frame;
        core.time_s = frame as f64 * step_s;
        core.day = day;
        (0..core.movers.len()).for_each(|m| core.drives_by_day(m));
        let mut left_out = Vec::new();
        let (mut under_way, mut on_final) = (Vec::new(), Vec::new());
        let count = core.flights.len();
        for (m, seen) in seen.iter().take(count).enumerate() {
            let arrives = core.flights[m].direction == Direction::Arrival;
            let fits = match seen {
                Seen::Planned => true,
                Seen::Gone => {
                    core.movers[m].phase = Phase::Gone;
                    true
                }
                // A departure that has no room there finds a stand as all do who come into a run.
                Seen::OnStand(stand) => core.put_on_stand(m, *stand) || !arrives,
                Seen::Taxiing(at) => {
                    under_way.push((m, at, core.arcs_under(m, at)));
                    true
                }
                Seen::OnRunway(at) if arrives => {
                    under_way.push((m, at, core.exits_ahead(m, at)));
                    true
                }
                Seen::OnRunway(_) => {
                    core.takes_off(m);
                    true
                }
                Seen::OnFinal { distance_m, stand } => {
                    // Its landing is a time of its runway, before anybody plans to cross.
                    core.movers[m].phase = Phase::Final;
                    core.movers[m].landing_s = core.time_s
                        + final_s(*distance_m, core.flights[m].landing.0, core.head_mps(m));
                    on_final.push((*distance_m, m, *stand));
                    true
                }
            };
            if !fits {
                left_out.push(m);
            }
        }
        let mut on_ways = Vec::new();
        for (m, at, arcs) in &under_way {
            match core.put_on_way(*m, at, arcs) {
                true => on_ways.push(*m),
                false => left_out.push(*m),
            }
        }
        // Who lands cannot wait: he is planned first, unless somebody without a plan stands in his way.
        on_final.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        on_final.retain(|(distance_m, m, stand)| !core.put_on_final(*m, *distance_m, *stand));
        left_out.extend(core.plan_ways(on_ways));
        on_final.retain(|(distance_m, m, stand)| !core.put_on_final(*m, *distance_m, *stand));
        left_out.extend(on_final.iter().map(|o| o.1));
        for m in &left_out {
            core.movers[*m].phase = Phase::Gone;
        }
        core.book();
        core.appear();
        (core, left_out)
    }

    /// Puts a flight on a stand: a departure before it is pushed back, an arrival for good.
    fn put_on_stand(&mut self, m: usize, stand: usize) -> bool {
        if stand >= self.net.stands.len() {
            return false;
        }
        let pieces = self.pieces_of_stand(stand, self.flights[m].size);
        if pieces.iter().any(|z| self.blocker(m, *z, false, &[]).is_some()) {
            return false;
        }
        self.park(m, stand);
        if self.flights[m].direction == Direction::Arrival {
            self.movers[m].phase = Phase::Docked;
            // Long enough ago for its next flight.
            self.movers[m].measures.aibt_s = Some(self.time_s - 300.0);
        }
        true
    }

    /// A departure on its runway is taken for one that takes off now.
    fn takes_off(&mut self, m: usize) {
        let (r, wake) = (self.flights[m].runway.0, self.flights[m].wake);
        let (rolled_s, airborne_s) = (self.time_s, self.time_s + self.run_s(m));
        self.last_take_off[r] = Some(TookOff { rolled_s, airborne_s, wake });
        self.movers[m].measures.atot_s = Some(airborne_s);
        self.movers[m].phase = Phase::Gone;
    }

    /// Arcs that somebody on the ground may be on, the nearest first: beside him, and lying as he looks.
    fn arcs_under(&self, m: usize, at: &OnGround) -> Vec<usize> {
        let guided_m = self.guided_m(m, at);
        let class = self.movers[m].class;
        let mut found: Vec<(f64, usize)> = Vec::new();
        for arc in 0..2 * self.net.edges.len() {
            let edge = &self.net.edges[arc / 2];
            let driven = arc % 2 == 0 || edge.two_way;
            let used = edge.nodes.iter().all(|n| self.net.nodes[*n].used);
            if !driven || !used || class > edge.code + 1 || edge.runway.is_some() {
                continue;
            }
            let [a, b] = [Arcs::from(&self.net, arc), Arcs::to(&self.net, arc)]
                .map(|n| self.net.nodes[n].at_m);
            let along = b - a;
            let share =
                ((guided_m - a).dot(&along) / along.norm_squared().max(1e-9)).clamp(0.0, 1.0);
            let beside_m = (a + along * share - guided_m).norm();
            let across = wrap_pi(self.arcs.heading_rad(arc) - at.heading_rad).abs();
            if beside_m <= BESIDE_M && across < 1.6 {
                found.push((beside_m + ACROSS_M * across, arc));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().take(TRIED).map(|f| f.1).collect()
    }

    /// Exits ahead of an arrival on its runway at which it can turn off, the next one first.
    fn exits_ahead(&self, m: usize, at: &OnGround) -> Vec<usize> {
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let along = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let place_m = along(runway.place_m(at.middle_m).0);
        let brakes_m = at.speed_mps * at.speed_mps / (2.0 * ROLL_OUT_MPS2);
        let mut found: Vec<(f64, usize)> = Vec::new();
        for (place, node) in &runway.spine {
            for arc in self.arcs.leaving(*node) {
                let edge = &self.net.edges[arc / 2];
                let turn = wrap_pi(self.arcs.heading_rad(*arc) - direction).abs().to_degrees();
                if edge.runway.is_none() && edge.strip == Some(r) && turn <= 115.0 {
                    let ahead_m = along(*place) - place_m;
                    // Behind the last one: back to it.
                    let far_m = if ahead_m >= brakes_m { ahead_m } else { 1e5 - ahead_m };
                    found.push((far_m, *arc));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().take(TRIED).map(|f| f.1).collect()
    }

    fn guided_m(&self, m: usize, at: &OnGround) -> Point2<f64> {
        at.middle_m
            + Azimuth::from_rad(at.heading_rad).unit() * (0.4 * self.flights[m].size.length_m)
    }

    /// Plans all who are under way; whom no plan holds.
    fn plan_ways(&mut self, all: Vec<usize>) -> Vec<usize> {
        let mut left_out = Vec::new();
        let left_m = |m: usize| self.movers[m].way.stop_m - self.movers[m].s;
        let mut open: Vec<(f64, usize)> = all.into_iter().map(|m| (left_m(m), m)).collect();
        // Who is nearest to his end first; who stands in another's way has his plan before him.
        open.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let now = self.time_s;
        loop {
            let before = open.len();
            open.retain(|(_, m)| !self.plan(*m, Start::UnderWay, now));
            if open.len() == before {
                // Of those who wait for each other the last one goes.
                let Some((_, m)) = open.pop() else { break };
                self.release_held(m);
                left_out.push(m);
            }
        }
        left_out
    }

    /// Lays the way of somebody on the ground, and puts him on it.
    fn put_on_way(&mut self, m: usize, at: &OnGround, starts: &[usize]) -> bool {
        let arrives = self.flights[m].direction == Direction::Arrival;
        if arrives {
            let wanted = at.stand.unwrap_or(self.flights[m].stand);
            self.movers[m].stand = wanted;
            let pieces = self.pieces_of_stand(wanted, self.flights[m].size);
            let (stand, pieces) = match self.stand_is_free(m, wanted, &pieces) {
                true => (wanted, pieces),
                false => match self.free_stand(m) {
                    Some(free) => free,
                    None => return false,
                },
            };
            self.movers[m].stand = stand;
            self.movers[m].parked_pieces = pieces;
        }
        let pushed = !arrives && at.starts_in_s > 0.0 && self.lay_from_stand(m, at);
        let laid = pushed || starts.iter().any(|arc| self.lay_from(m, *arc, &at.cleared_way_m));
        if !laid {
            return false;
        }
        self.draw_cleared_way(m);
        let guided_m = self.guided_m(m, at);
        let way = &self.movers[m].way;
        let beside_m = |place: f64| (way.path.at(place).at_m - guided_m).norm();
        let to_m = way.stop_m.min(way.path.length_m()).min(600.0);
        let places = (0..=to_m.max(0.0) as usize).map(|k| k as f64);
        let nearest = places.min_by(|a, b| beside_m(*a).total_cmp(&beside_m(*b))).unwrap_or(0.0);
        let mut place = if pushed { self.pushed_to_m(m) } else { nearest.min(way.stop_m) };
        // Who stands a little beyond a line has not passed it.
        let departs = (!arrives).then_some(self.movers[m].threshold as usize);
        let lines: Vec<usize> = way.crossings.iter().map(|c| c.0).chain(departs).collect();
        for first in lines {
            let line_m = self.stop_before_m(m, first);
            if place > line_m && place < line_m + BEYOND_M {
                place = line_m;
            }
        }
        let (ahead_m, behind_m) = self.reach_m(m);
        let way = &self.movers[m].way;
        let step_at = |m: f64| way.ends_m.partition_point(|e| *e < m);
        let last = way.pieces.len().saturating_sub(1);
        let first_held = step_at(place - behind_m).min(last);
        let mut next = step_at(place + ahead_m + 1.0).min(last) + 1;
        next = next.max(way.group_last[next - 1].min(last) + 1);
        // Its strip is the runway's: who is in it is on the runway.
        if departs.is_some_and(|first| next > first) {
            return false;
        }
        let held: Vec<(u32, bool)> =
            (first_held..next).map(|k| (way.pieces[k], way.roll.contains(&k))).collect();
        let most_mps = way.most_mps(place);
        let on = way.path.at(place);
        held.iter().for_each(|(z, roll)| self.hold(m, *z, *roll));
        let now = self.time_s;
        let mover = &mut self.movers[m];
        (mover.first_held, mover.next) = (first_held, next);
        (mover.s, mover.v, mover.a, mover.slip) = (place, at.speed_mps.min(most_mps), 0.0, 0.0);
        // No more than a taxiway is wide: from there it comes to its line.
        let off_m = guided_m - on.at_m;
        mover.beside_m = off_m * (15.0 / off_m.norm().max(15.0));
        mover.beside_from = place;
        mover.phase = Phase::Taxiing;
        mover.taxi_from_s = now;
        mover.measures.aobt_s = Some(now);
        mover.stopped_until_s = now + at.starts_in_s.max(0.0);
        true
    }

    /// Lays the way that a departure has after the push-back from its stand, if it was pushed where it is seen: nobody sees by a
    /// track that it goes backwards.
    fn lay_from_stand(&mut self, m: usize, at: &OnGround) -> bool {
        let Some(stand) = at.stand.filter(|s| *s < self.net.stands.len()) else { return false };
        self.movers[m].stand = stand;
        let (closed, easy) = (self.closed_for_ever(m), vec![false; 2 * self.net.edges.len()]);
        if !self.plan_departure(m, &closed, &easy, &[]) {
            return false;
        }
        let ends_m = self.movers[m].way.path.at(self.pushed_to_m(m)).at_m;
        (ends_m - at.middle_m).norm() < self.movers[m].push.stop_m + self.flights[m].size.length_m
    }

    /// Where on its way a departure stands after its push-back, m.
    fn pushed_to_m(&self, m: usize) -> f64 {
        self.after_push(m, self.movers[m].push.stop_m).1
    }

    /// Lays the way of a departure to its runway or of an arrival to its stand, from an arc on.
    fn lay_from(&mut self, m: usize, from: usize, cleared_m: &[Point2<f64>]) -> bool {
        let (r, arrives) =
            (self.flights[m].runway.0, self.flights[m].direction == Direction::Arrival);
        let closed = self.closed_for_ever(m);
        let net = Arc::clone(&self.net);
        let entries = self.entries(m);
        let stand = net.stands[self.movers[m].stand].node;
        let shut = |e: usize| closed[e] && e != from / 2 || net.edges[e].runway == Some(r);
        let slow = |arc: usize| {
            let [a, b] = net.edges[arc / 2].nodes.map(|node| net.nodes[node].at_m);
            let middle = center(&a, &b);
            !cleared_m.is_empty() && beside_line_m(cleared_m, middle) > OFF_WAY_M
        };
        let found = if arrives {
            let goal = |arc: usize| Some(Arcs::to(&net, arc)) == stand;
            self.arcs.quickest(&net, &[(from, 0.0)], goal, shut, slow)
        } else {
            let with = |least_m: f64| {
                let goal = |arc: usize| self.enters(&entries, arc, least_m);
                self.arcs.quickest(&net, &[(from, 0.0)], goal, shut, slow)
            };
            entries.least_m.into_iter().find_map(with)
        };
        let Some(found) = found else { return false };
        let mut arcs = self.behind(m, from);
        arcs.extend(found.arcs);
        match arrives {
            true => self.lay_to_stand(m, &arcs),
            false => self.lay_to_runway(m, arcs).is_some(),
        }
    }

    /// The straightest arcs behind one, as far as a tail reaches; none on runways.
    fn behind(&self, m: usize, from: usize) -> Vec<usize> {
        let mut arcs = vec![from];
        let mut room_m = self.reach_m(m).1 + TAIL_M;
        while room_m > 0.0 && arcs.len() < 16 {
            let first = arcs[0];
            let node = Arcs::from(&self.net, first);
            let towards = self.arcs.away_from(&self.net, node).map(|a| a ^ 1);
            let before = towards.filter(|b| {
                let edge = &self.net.edges[b / 2];
                (b % 2 == 0 || edge.two_way)
                    && edge.runway.is_none()
                    && !arcs.iter().any(|a| a / 2 == b / 2)
                    && self.arcs.turn_rad(*b, first) < 1.0
            });
            let turn = |b: &usize| self.arcs.turn_rad(*b, first);
            let Some(before) = before.min_by(|p, q| turn(p).total_cmp(&turn(q))) else { break };
            room_m -= self.arcs.length_m(before);
            arcs.insert(0, before);
        }
        arcs.pop();
        arcs
    }

    /// Lays a way over arcs that end at its stand.
    pub(super) fn lay_to_stand(&mut self, m: usize, arcs: &[usize]) -> bool {
        let net = Arc::clone(&self.net);
        let size = self.flights[m].size;
        let guided_m = 0.4 * size.length_m - self.short_of_node_m(self.movers[m].stand, size);
        let class = self.movers[m].class;
        let mut way = Way::over(&net, &self.pieces, arcs, class, (0.0, 60.0), guided_m);
        if way.pieces.is_empty() {
            return false;
        }
        way.group_crossings(&self.pieces, size.length_m + 10.0, 0..0);
        way.hold_before(None);
        let firsts: Vec<usize> = way.crossings.iter().map(|c| c.0).collect();
        way.clear_strips(&self.pieces, &firsts, usize::MAX, self.body_m(m));
        let driving = self.movers[m].driving;
        way.limit(&net, &self.pieces, &driving, &Roll::NONE);
        let mover = &mut self.movers[m];
        mover.measures.unhindered_s = way.unhindered_s(0.0, way.stop_m, &driving);
        mover.way = way;
        true
    }

    /// Puts an arrival on final so far from its threshold, with a way to a free stand.
    fn put_on_final(&mut self, m: usize, distance_m: f64, stand: usize) -> bool {
        let mut choices = self.free_stands(m, 6);
        if stand < self.net.stands.len() && !choices.iter().any(|c| c.0 == stand) {
            let pieces = self.pieces_of_stand(stand, self.flights[m].size);
            if self.stand_is_free(m, stand, &pieces) {
                choices.insert(0, (stand, pieces));
            }
        }
        choices.sort_by_key(|c| c.0 != stand);
        let mps = approach_airspeed_mps(distance_m, self.flights[m].landing.0) - self.head_mps(m);
        // Whose landing fits into no order of the runway lands a little later.
        for later_s in [0.0, 15.0, 30.0, 60.0] {
            let landing_s = self.movers[m].landing_s + later_s;
            let (all, mut tried) = (choices.clone(), Tried::default());
            if let Some((_, pieces)) = self.choose_stand(m, all, landing_s, &mut tried) {
                self.enters_final(m, pieces, landing_s, distance_m + mps * later_s);
                return true;
            }
        }
        false
    }
}

/// Distance from a line of points to a point, m.
fn beside_line_m(line_m: &[Point2<f64>], point_m: Point2<f64>) -> f64 {
    let pieces = line_m.windows(2).map(|w| {
        let along = w[1] - w[0];
        let share = ((point_m - w[0]).dot(&along) / along.norm_squared().max(1e-9)).clamp(0.0, 1.0);
        (w[0] + along * share - point_m).norm()
    });
    pieces.fold(f64::INFINITY, f64::min)
}
