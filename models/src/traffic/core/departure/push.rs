//! Pushbacks: onto which side there is room, how the tug drives, and from the gear's line to the nose wheel's.

use crate::draw::uniform;
use crate::frames::{Azimuth, Point2, wrap_pi};
use crate::traffic::core::drive::Tick;
use crate::traffic::core::{Core, Phase, TAIL_M};
use crate::traffic::path::Path;
use crate::traffic::profile::stopping_speed_mps;
use crate::traffic::way::Arcs;
use std::ops::Range;

impl Core {
    /// Whether a pushback may go over an arc.
    fn pushable(&self, arc: usize, closed: &[bool], lenient: bool) -> bool {
        let edge = &self.net.edges[arc / 2];
        let free = |n: &usize| self.net.nodes[*n].used && self.net.nodes[*n].stand.is_none();
        !closed[arc / 2]
            && edge.strip.is_none()
            && edge.runway.is_none()
            && edge.nodes.iter().all(free)
            && (lenient || edge.two_way || arc % 2 == 1)
    }

    /// Arcs away from the end of a pushback that can be pushed over, at a bend of at most 120 degrees.
    pub(super) fn back_over(&self, back: &[usize], closed: &[bool], lenient: bool) -> Vec<usize> {
        let Some(last) = back.last().copied() else { return Vec::new() };
        let node = Arcs::to(&self.net, last);
        let on = self.arcs.away_from(&self.net, node).filter(|a| a / 2 != last / 2);
        on.filter(|a| self.arcs.turn_rad(last, *a) < 2.1 && self.pushable(*a, closed, lenient))
            .collect()
    }

    /// Sides onto which an aircraft can be pushed back from the end of `back`: arcs with room for it behind the
    /// bend, and the bend, rad.
    pub(super) fn sides(
        &self,
        back: &[usize],
        closed: &[bool],
        length_m: f64,
        lenient: bool,
    ) -> Vec<(Vec<usize>, f64)> {
        let net = &self.net;
        let Some(last) = back.last().copied() else { return Vec::new() };
        let mut sides = Vec::new();
        for first in self.back_over(back, closed, lenient) {
            let turn = self.arcs.turn_rad(last, first);
            let mut chain = vec![first];
            let need = 1.0 * length_m + 25.0 * libm::tan(0.5 * turn.min(2.0)) + 12.0;
            let mut have = self.arcs.length_m(first);
            while have < need && chain.len() < 20 {
                let at = chain[chain.len() - 1];
                let node = Arcs::to(net, at);
                let next = self
                    .arcs
                    .away_from(net, node)
                    .filter(|a| {
                        a / 2 != at / 2
                            && self.pushable(*a, closed, lenient)
                            && self.arcs.turn_rad(at, *a) < if lenient { 1.2 } else { 0.7 }
                    })
                    .min_by(|p, q| {
                        self.arcs.turn_rad(at, *p).total_cmp(&self.arcs.turn_rad(at, *q))
                    });
                let Some(next) = next else { break };
                have += self.arcs.length_m(next);
                chain.push(next);
            }
            if have >= need {
                sides.push((chain, turn));
            }
        }
        sides
    }

    pub(in crate::traffic::core) fn pushing(&mut self, m: usize) {
        let mover = &mut self.movers[m];
        let (s, v, a) = (mover.s, mover.v, mover.a);
        let stop = mover.push.stop_m;
        let wish = mover.push.most_mps(s).min(stopping_speed_mps(stop - s, 0.2, Some(0.3)));
        let limits = Tick { acc: 0.2, dec: 0.25, jerk: 0.3, dt: self.step_s };
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, stop);
        if mover.v == 0.0 && stop - mover.s < 0.5 {
            let now = self.time_s;
            let mut rng = self.rng(m, 2);
            let pause = match self.is_vehicle(m) {
                true => self.pause_s(m),
                false => 90.0 + 30.0 * uniform(&mut rng),
            };
            self.movers[m].phase = Phase::Starting(now + pause);
            self.begin_way_after_push(m);
        }
    }

    /// The place on the taxi way at which the nose wheel is when the gear is at `gear_m` of the pushback: steps
    /// under the mover there, place, slip.
    pub(in crate::traffic::core) fn after_push(
        &self,
        m: usize,
        gear_m: f64,
    ) -> (Range<usize>, f64, f64) {
        let f = &self.flights[m];
        let (wheelbase, length) = (f.wheelbase_m, f.size.length_m);
        let mover = &self.movers[m];
        let heading = push_heading(&mover.push.path, gear_m).0;
        // The nearest place of the way to the nose wheel, near its begin.
        let nose = nose_of(&mover.push.path, gear_m, wheelbase);
        let begin = Begin::of(&mover.way.path, mover.push.path.length_m());
        let (_, at) = begin.nearest(nose);
        let slip = wrap_pi(mover.way.path.at(at).heading_rad - heading);
        let nose_tip = at + 0.1 * length + 1.0;
        let needed = mover.way.ends_m.iter().position(|e| *e >= nose_tip).unwrap_or(0);
        let tail = at - 0.9 * length - TAIL_M;
        let first = mover.way.ends_m.iter().position(|e| *e >= tail).unwrap_or(0);
        (first..needed + 1, at, slip)
    }

    /// From the pushback to the taxi way: the same place, seen from the nose wheel.
    fn begin_way_after_push(&mut self, m: usize) {
        let (_, at, slip) = self.after_push(m, self.movers[m].s);
        let nose =
            nose_of(&self.movers[m].push.path, self.movers[m].s, self.flights[m].wheelbase_m);
        let pushed: Vec<u32> = self.movers[m].push.pieces.clone();
        pushed.iter().for_each(|z| self.release(m, *z, false));
        let mover = &mut self.movers[m];
        (mover.first_held, mover.next) = (mover.under.start, mover.under.end);
        (mover.beside_m, mover.beside_from) = (nose - mover.way.path.at(at).at_m, at);
        (mover.s, mover.slip) = (at, slip);
        self.end_clearance(m, "PSH");
    }
}

/// Where the nose wheel is when the main gear is at a place of a pushback, m.
pub(super) fn nose_of(push: &Path, gear_m: f64, wheelbase_m: f64) -> Point2<f64> {
    push.at(gear_m).at_m + Azimuth::from_rad(push_heading(push, gear_m).0).unit() * wheelbase_m
}

/// Heading when the main gear is at a place of a pushback, rad, and its change with the place, rad/m: against the chord
/// of the line from [`SWING_M`] before to as far behind, as the nose is swung in and out of a bend gradually.
pub(in crate::traffic::core) fn push_heading(push: &Path, gear_m: f64) -> (f64, f64) {
    let (a, b) = (push.at(gear_m - SWING_M), push.at(gear_m + SWING_M));
    let unit = |heading_rad: f64| Azimuth::from_rad(heading_rad).unit();
    let (chord, change) = (b.at_m - a.at_m, unit(b.heading_rad) - unit(a.heading_rad));
    let rate = (change.x * chord.y - change.y * chord.x) / chord.norm_squared().max(1e-6);
    (wrap_pi(Azimuth::of(-chord).rad()), rate)
}

/// Way over which the nose is swung into a bend of a pushback, before and behind it, m (assumed).
pub(in crate::traffic::core) const SWING_M: f64 = 3.0;

/// The begin of a path, every two metres: as far as somebody who has been pushed back may be on it.
pub(super) struct Begin<'a> {
    path: &'a Path,
    points_m: Vec<Point2<f64>>,
}

/// From point to point, m.
const LOOK_M: f64 = 2.0;

impl<'a> Begin<'a> {
    /// The first `reach_m` (the way begins where the line of the pushback ends: nobody is farther on than that is long).
    pub(super) fn of(path: &'a Path, reach_m: f64) -> Self {
        let count = (reach_m / LOOK_M) as usize;
        let points_m = (0..=count).map(|k| path.at(LOOK_M * k as f64).at_m).collect();
        Self { path, points_m }
    }

    /// Distance of a point from it, and the place nearest to it, m.
    pub(super) fn nearest(&self, point_m: Point2<f64>) -> (f64, f64) {
        let mut best = (f64::INFINITY, 0.0);
        for (k, at_m) in self.points_m.iter().enumerate() {
            let distance_m = (at_m - point_m).norm();
            if distance_m < best.0 {
                best = (distance_m, LOOK_M * k as f64);
            }
        }
        for (around_m, step_m) in [(LOOK_M, 0.1), (0.1, 0.01)] {
            let (from_m, to_m) = ((best.1 - around_m).max(0.0), best.1 + around_m);
            let count = ((to_m - from_m) / step_m) as usize;
            for place in (0..=count).map(|k| from_m + step_m * k as f64) {
                let distance_m = (self.path.at(place).at_m - point_m).norm();
                if distance_m < best.0 {
                    best = (distance_m, place);
                }
            }
        }
        best
    }
}
