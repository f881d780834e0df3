//! Vehicles: from stand to stand over the lanes of aircraft, in the same order as they.
//!
//! A driver backs out of a stand as aircraft are pushed out of it, drives to another one where no flight is expected, stays for a
//! few minutes, and goes on, at once where somebody waits for him. He keeps off the strips of runways, since nobody clears him there
//! (stays and times are assumed).

use super::departure::Goal;
use super::{Core, Flight, Phase, Policy, Timing};
use crate::draw::uniform;
use crate::traffic::tractrix::drawn_slip_rad;
use crate::traffic::way::Way;

/// A stay at a stand, least and most, s (assumed).
const STAY_S: [f64; 2] = [180.0, 600.0];
/// From standing after backing out to driving on, s (assumed).
const CHANGES_GEAR_S: f64 = 3.0;
/// From the end of a pushback to the begin of the taxi way of an aircraft, s (drawn 90 to 120).
const STARTS_S: f64 = 105.0;
/// Stands where a flight is expected so soon are left to it, s: much longer than a drive and a stay (assumed).
const EXPECTED_S: f64 = 2400.0;
/// So many stands are tried for one drive; without any it is tried again after, s.
const STANDS_TRIED: u64 = 4;
/// And so many for its first stand.
const FIRST_TRIED: u64 = 8;
const AGAIN_S: f64 = 30.0;
/// Nobody drives to a stand on which he would stand so far off its line, rad: 2 degrees (assumed).
const MOST_CROOKED_RAD: f64 = 0.035;

impl Core {
    /// Whether a mover is a vehicle, not a flight.
    pub(super) fn is_vehicle(&self, m: usize) -> bool {
        self.flights.get(m).is_some_and(|f| f.direction == super::Direction::Vehicle)
    }

    /// From the end of a pushback to the begin of the way after it, s.
    pub(super) fn pause_s(&self, m: usize) -> f64 {
        if self.is_vehicle(m) { CHANGES_GEAR_S } else { STARTS_S }
    }

    /// By node the part of the network that it is in, where nobody drives over strips; empty without vehicles.
    pub(super) fn parts_beside_strips(&self) -> Vec<usize> {
        if !(0..self.flights.len()).any(|m| self.is_vehicle(m)) {
            return Vec::new();
        }
        let mut parts: Vec<usize> = (0..self.net.nodes.len()).collect();
        let root = |parts: &[usize], mut n: usize| {
            while parts[n] != n {
                n = parts[n];
            }
            n
        };
        let beside = self.net.edges.iter().filter(|e| e.runway.is_none() && e.strip.is_none());
        for [a, b] in beside.map(|e| e.nodes.map(|n| root(&parts, n))).collect::<Vec<_>>() {
            let [a, b] = [root(&parts, a), root(&parts, b)];
            parts[a.max(b)] = a.min(b);
        }
        (0..parts.len()).map(|n| root(&parts, n)).collect()
    }

    /// The part of the network that a stand is in.
    fn part_of(&self, stand: usize) -> Option<usize> {
        self.net.stands[stand].node.and_then(|n| self.parts.get(n)).copied()
    }

    /// Whether a flight that has not come yet will want this stand soon.
    fn is_expected(&self, stand: usize) -> bool {
        self.flights.iter().zip(&self.movers).any(|(f, mover)| {
            let comes = mover.phase == Phase::Absent && f.direction != super::Direction::Vehicle;
            comes && f.stand == stand && f.time_s < self.time_s + EXPECTED_S
        })
    }

    /// A vehicle comes into the run: on its stand, or on the first behind it that is free for it and that it can leave now.
    pub(super) fn appear_to_drive(&mut self, m: usize, f: &Flight) {
        let count = self.net.stands.len();
        let mut tried = 0;
        for stand in (0..count).map(|k| (f.stand + k) % count) {
            if self.stand_to_drive_to(m, stand).is_none() {
                continue;
            }
            self.park(m, stand);
            if self.find_drive(m) {
                self.gives_up_drive(m);
                return;
            }
            self.leave_stand(m);
            self.movers[m].phase = Phase::Absent;
            tried += 1;
            if tried == FIRST_TRIED {
                break;
            }
        }
        self.movers[m].next_try_s = self.time_s + AGAIN_S;
    }

    /// The pieces under a vehicle on a stand that is free for it; `None` where it is not, or a flight is expected.
    fn stand_to_drive_to(&self, m: usize, stand: usize) -> Option<Vec<u32>> {
        let node = self.net.stands[stand].node.filter(|n| self.net.nodes[*n].used)?;
        self.stand_arc(node)?;
        let pieces = self.pieces_of_stand(stand, self.flights[m].size);
        let free = !self.is_expected(stand) && self.stand_is_free(m, stand, &pieces);
        free.then_some(pieces)
    }

    /// Whether a vehicle at the end of its way stands along its line: behind a sharp bend its rear axle needs some metres to come in
    /// behind its nose.
    fn ends_straight(&self, m: usize) -> bool {
        let Way { path, stop_m, .. } = &self.movers[m].way;
        let wheelbase_m = self.flights[m].wheelbase_m;
        // What was before so many wheelbases leaves no trace.
        let from_m = (stop_m - 12.0 * wheelbase_m).max(0.0);
        let heading_rad = |way_m: f64| path.heading_rad(from_m + way_m);
        let steps = (4.0 * (stop_m - from_m) / wheelbase_m).ceil();
        let step_m = (stop_m - from_m) / steps.max(1.0);
        let slip_rad = (0..steps as u32).fold(0.0, |slip, k| {
            let at_m = f64::from(k) * step_m;
            drawn_slip_rad(slip, step_m, wheelbase_m, |way_m| heading_rad(at_m + way_m))
        });
        slip_rad.abs() <= MOST_CROOKED_RAD
    }

    /// Whether a vehicle on a stand drives now: it has a drive, or its stay is over and one is found.
    pub(super) fn is_to_drive(&mut self, m: usize) -> bool {
        if self.movers[m].goal.is_some() && !self.movers[m].push.pieces.is_empty() {
            return true;
        }
        let in_the_way = || self.movers.iter().any(|o| o.waits_for == Some(m));
        if self.time_s < self.movers[m].ready_s && !in_the_way() {
            self.movers[m].next_try_s = self.time_s + 5.0;
            return false;
        }
        let found = self.find_drive(m);
        if !found {
            self.movers[m].next_try_s = self.time_s + AGAIN_S;
        }
        found
    }

    /// Draws a stand to drive to, and plans the way there.
    fn find_drive(&mut self, m: usize) -> bool {
        let count = self.net.stands.len();
        let mut tried = 0;
        let drives = self.movers[m].drives;
        self.movers[m].drives += 1;
        let mut rng = self.rng(m, 16 + drives);
        let first = (uniform(&mut rng) * count as f64) as usize;
        for stand in (0..count).map(|k| (first + k) % count) {
            let here = self.movers[m].stand;
            if stand == here || self.part_of(stand) != self.part_of(here) {
                continue;
            }
            let Some(pieces) = self.stand_to_drive_to(m, stand) else { continue };
            self.movers[m].goal = Some((stand, pieces));
            if self.find_departure(m) && self.ends_straight(m) {
                return true;
            }
            self.gives_up_drive(m);
            tried += 1;
            if tried == STANDS_TRIED {
                break;
            }
        }
        false
    }

    /// A drive that has not begun is none any more.
    pub(super) fn gives_up_drive(&mut self, m: usize) {
        let mover = &mut self.movers[m];
        mover.goal = None;
        (mover.push, mover.way) = Default::default();
        mover.timing = Timing::default();
        (mover.waits_since_s, mover.waits_for) = (None, None);
        if self.policy == Policy::Planned {
            self.book();
        }
    }

    /// Lays the way of a vehicle over arcs that end at its stand; the step from which on nothing may be under it after backing out.
    pub(super) fn lay_to_goal(&mut self, m: usize, arcs: &[usize]) -> Option<usize> {
        let stand = self.movers[m].goal.as_ref()?.0;
        let from = std::mem::replace(&mut self.movers[m].stand, stand);
        let laid = self.lay_to_stand(m, arcs);
        self.movers[m].stand = from;
        laid.then(|| self.movers[m].way.pieces.len().saturating_sub(1))
    }

    /// A vehicle is where it drove to: keeps what is under it, and stays for a while.
    pub(super) fn arrives_to_stay(&mut self, m: usize) {
        let Some((stand, pieces)) = self.movers[m].goal.take() else { return };
        pieces.iter().for_each(|z| self.hold(m, *z, false));
        self.release_held(m);
        let mut rng = self.rng(m, 15 + self.movers[m].drives);
        let stay_s = STAY_S[0] + (STAY_S[1] - STAY_S[0]) * uniform(&mut rng);
        let now = self.time_s;
        let mover = &mut self.movers[m];
        mover.stands_short_m = mover.way.stop_m - mover.s;
        (mover.stand, mover.parked_pieces) = (stand, pieces);
        (mover.push, mover.way) = (Way::default(), Way::default());
        mover.timing = Timing::default();
        mover.phase = Phase::Parked;
        (mover.first_held, mover.next) = (0, 0);
        (mover.waits_since_s, mover.waits_for) = (None, None);
        (mover.ready_s, mover.next_try_s) = (now + stay_s, now);
    }

    /// Where a mover on a stand is to go: a departure on to its runway, a vehicle to its stand.
    pub(super) fn goal_of_way(&self, m: usize) -> Goal {
        match &self.movers[m].goal {
            Some((stand, _)) => Goal::Stand(self.net.stands[*stand].node),
            None => Goal::Runway(self.entries(m)),
        }
    }
}
