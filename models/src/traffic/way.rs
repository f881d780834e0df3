//! The way of one mover: its nodes, the line over them, the pieces along it and how fast it may be driven.

pub use super::arcs::{Arcs, Found, Search};
use super::network::Network;
use super::path::{Corner, Path};
use super::pieces::{Class, Pieces, wanted_radius_m};
use crate::frames::Point2;
use std::ops::Range;

/// How a mover drives, for the speeds along its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driving {
    /// Speed on straights, m/s.
    pub straight_mps: f64,
    /// Speed in a quarter turn.
    pub turn_mps: f64,
    /// Acceleration, braking (positive), m/s²; jerk, m/s³.
    pub acc_mps2: f64,
    /// Braking.
    pub dec_mps2: f64,
    /// Jerk.
    pub jerk_mps3: f64,
    /// Lateral acceleration in turns, m/s².
    pub lateral_mps2: f64,
}

/// The way of a mover.
#[derive(Clone, Debug, Default)]
pub struct Way {
    /// The line of the guided point.
    pub path: Path,
    /// Arcs in order.
    pub arcs: Vec<usize>,
    /// Pieces in order.
    pub pieces: Vec<u32>,
    /// Where each piece ends on the path, m.
    pub ends_m: Vec<f64>,
    /// By index: the last piece that has to be taken together with it.
    pub group_last: Vec<usize>,
    /// Indices that are taken as a roll (the strip beside them has to be empty).
    pub roll: Range<usize>,
    /// Index of the first piece of each runway crossing, and the runway.
    pub crossings: Vec<(usize, usize)>,
    /// Other runways whose strips a landing leaves with that of its own.
    pub lands_over: Vec<usize>,
    /// Where one waits for a strip: the index of its first piece, and the place, m.
    holds_m: Vec<(usize, f64)>,
    /// Where the guided point stops at last, m.
    pub stop_m: f64,
    /// Greatest speed every two metres.
    envelope_mps: Vec<f64>,
}

/// Gap that is kept ahead of the nose, m.
pub const GAP_M: f64 = 2.0;
/// Spacing of the envelope, m.
const STEP_M: f64 = 2.0;
/// Speed on lead-ins and on lanes beside stands, m/s.
const LEAD_IN_MPS: f64 = 2.6;
const LANE_MPS: f64 = 10.0;
/// Nobody is slower than this in a turn, m/s: through a bend of 0.3 m radius, as layouts have them between nodes a metre apart.
const LEAST_MPS: f64 = 0.6;

/// The part of a way that is a landing roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roll {
    /// From the begin of the way to here, m.
    pub free_to_m: f64,
    /// Braking in it, m/s².
    pub dec_mps2: f64,
    /// Nobody leaves it faster, m/s.
    pub exit_mps: f64,
    /// Up to here it is driven on as fast as that, m: the end of the strip.
    pub off_to_m: f64,
    /// Braking from the begin of the exit to there, m/s².
    pub off_dec_mps2: f64,
}

/// A turn off a runway by more than this is none of a fast exit, rad (61 degrees: sixty, with room for how files place nodes).
const FAST_TURN_RAD: f64 = 1.064_650_843_716_541;

impl Roll {
    /// There is none.
    pub const NONE: Self = Self {
        free_to_m: 0.0,
        dec_mps2: 1.0,
        exit_mps: f64::INFINITY,
        off_to_m: 0.0,
        off_dec_mps2: 1.0,
    };
}

/// When places of a way are reached by somebody who drives alone.
#[derive(Clone, Debug)]
pub struct Alone {
    from_m: f64,
    times_s: Vec<f64>,
}

impl Alone {
    /// Time since the begin at which a place is reached, s; 0 before the begin, that of the end beyond it.
    #[must_use]
    pub fn time_s(&self, place_m: f64) -> f64 {
        let cell = ((place_m - self.from_m) / STEP_M).max(0.0);
        let last = self.times_s.len() - 1;
        let low = (cell as usize).min(last);
        let (a, b) = (self.times_s[low], self.times_s[(low + 1).min(last)]);
        a + (b - a) * (cell - low as f64).min(1.0)
    }
}

impl Way {
    /// The way over arcs, with a straight continuation of `before_m` and `beyond_m` at its ends; the guided
    /// point stops `stop_beyond_m` behind the last node.
    #[must_use]
    pub fn over(
        net: &Network,
        pieces: &Pieces,
        arcs: &[usize],
        class: Class,
        (before_m, beyond_m): (f64, f64),
        stop_beyond_m: f64,
    ) -> Self {
        let Some(first) = arcs.first() else { return Self::default() };
        let mut points: Vec<Point2<f64>> = Vec::with_capacity(arcs.len() + 3);
        points.push(net.nodes[Arcs::from(net, *first)].at_m);
        points.extend(arcs.iter().map(|a| net.nodes[Arcs::to(net, *a)].at_m));
        let shift = usize::from(before_m > 0.0);
        if shift == 1 {
            let back = (points[0] - points[1]).normalize();
            points.insert(0, points[0] + back * before_m);
        }
        let last = points.len() - 1;
        if beyond_m > 0.0 {
            let ahead = (points[last] - points[last - 1]).normalize();
            points.push(points[last] + ahead * beyond_m);
        }
        let radius = |i: usize, turn: f64| {
            let k = i - shift;
            if k == 0 || k >= arcs.len() {
                0.0
            } else {
                wanted_radius_m(net, arcs[k - 1] / 2, arcs[k] / 2, turn, class)
            }
        };
        let (path, corners) = Path::over(&points, radius);
        let mut way = Self { path, arcs: arcs.to_vec(), ..Self::default() };
        for (k, arc) in arcs.iter().enumerate() {
            let (from, to): (&Corner, &Corner) = (&corners[k + shift], &corners[k + shift + 1]);
            let edge = arc / 2;
            let (start, count) = pieces.of_edge[edge];
            let length = net.length_m(edge);
            for i in 0..count {
                let z = if arc % 2 == 0 { start + i } else { start + count - 1 - i };
                let piece = &pieces.list[z];
                let off = if arc % 2 == 0 { piece.to_m } else { length - piece.from_m };
                let end = if i + 1 == count {
                    to.place_m
                } else if off < 0.5 * length {
                    (from.place_m + from.beside_m(off)).min(to.place_m)
                } else {
                    (to.place_m - to.beside_m(length - off)).max(from.place_m)
                };
                way.pieces.push(z as u32);
                way.ends_m.push(end.max(way.ends_m.last().copied().unwrap_or(0.0)));
            }
        }
        way.stop_m = corners[last].place_m + stop_beyond_m;
        way.group_last = (0..way.pieces.len()).collect();
        way
    }

    /// A way over no edge, for somebody in the air (its one piece is held by nobody).
    #[must_use]
    pub fn straight(path: Path) -> Self {
        Self { path, pieces: vec![0], ends_m: vec![0.0], group_last: vec![0], ..Self::default() }
    }

    /// Makes one group of each crossing of a runway strip: with everything that the body covers beyond it.
    /// Indices of `without` (a roll) are left alone.
    pub fn group_crossings(&mut self, pieces: &Pieces, clear_m: f64, without: Range<usize>) {
        let strip = |z: u32| pieces.list[z as usize].strip;
        let mut i = 0;
        while i < self.pieces.len() {
            let Some(runway) = strip(self.pieces[i]).filter(|_| !without.contains(&i)) else {
                i += 1;
                continue;
            };
            let mut last = i;
            while last + 1 < self.pieces.len()
                && strip(self.pieces[last + 1]).is_some()
                && !without.contains(&(last + 1))
            {
                last += 1;
            }
            let clear = self.ends_m[last] + clear_m;
            let mut end = last;
            while end + 1 < self.pieces.len()
                && self.ends_m[end] < clear
                && !without.contains(&(end + 1))
            {
                end += 1;
            }
            // Where the strips of two runways touch, or one is taxied along over another, both are crossed.
            let mut crossed = vec![runway];
            let over = |k: usize| pieces.list[self.pieces[k] as usize].over;
            for r in (i..=last).flat_map(|k| strip(self.pieces[k]).into_iter().chain(over(k))) {
                if !crossed.contains(&r) {
                    crossed.push(r);
                }
            }
            self.crossings.extend(crossed.into_iter().map(|r| (i, r)));
            for k in i..=end {
                self.group_last[k] = self.group_last[k].max(end);
            }
            i = last + 1;
        }
        // What lies in a group ends with the group that reaches farthest.
        for k in 0..self.group_last.len() {
            let end = self.group_last[k];
            let farther = self.group_last[k..=end].iter().copied().max().unwrap_or(end);
            self.group_last[k] = farther;
        }
    }

    /// Finds where one waits for each crossing, and for the step `and`: at a holding position in a bend before its arc, which
    /// cuts the corner and so leads over the line.
    pub fn hold_before(&mut self, and: Option<usize>) {
        let mut steps: Vec<usize> = self.crossings.iter().map(|c| c.0).chain(and).collect();
        steps.retain(|k| *k > 0);
        steps.dedup();
        let holds = steps.into_iter().map(|k| {
            let end = self.ends_m[k - 1];
            let arc = self.path.arcs().find(|(from, to, _)| (*from..=*to).contains(&end));
            (k, arc.map_or(end, |a| a.0))
        });
        self.holds_m = holds.collect();
    }

    /// Where the guided point stops while step `next` is the first that is not taken, m: the nose, `ahead_m` before it, keeps
    /// [`GAP_M`] from the end of what is taken, at a strip `hold_gap_m` from where one waits for it. Never falls with `next`.
    #[must_use]
    pub fn stop_before_m(&self, next: usize, ahead_m: f64, hold_gap_m: f64) -> f64 {
        if next >= self.pieces.len() {
            return self.stop_m;
        }
        let end = |k: usize| next.checked_sub(k).map_or(0.0, |i| self.ends_m[i]);
        let hold = self.holds_m.iter().find(|h| h.0 == next);
        let (last, gap_m) = hold.map_or((end(1), GAP_M), |h| (h.1.min(end(1)), hold_gap_m));
        // A short last piece takes nothing back of what the one before it gave.
        ((last - gap_m).max(end(2) - GAP_M) - ahead_m).min(self.stop_m)
    }

    /// Lengthens the groups that begin with the steps `firsts` until whoever has driven to their end is off the strips in them
    /// with all of its body (`ahead_m` before and `behind_m` behind the guided point): nobody in a strip needs a piece more
    /// to leave it. `line_up`: from this step on nothing is taken with a crossing.
    pub fn clear_strips(
        &mut self,
        pieces: &Pieces,
        firsts: &[usize],
        line_up: usize,
        (ahead_m, behind_m, hold_gap_m): (f64, f64, f64),
    ) {
        let end = line_up.min(self.pieces.len());
        for first in firsts {
            let Some(mut last) = self.group_last.get(*first).copied() else { continue };
            let off_m = |way: &Self, last: usize| {
                let strip = |k: &usize| pieces.list[way.pieces[*k] as usize].strip.is_some();
                (*first..=last).rev().find(strip).map_or(0.0, |k| way.ends_m[k] + behind_m)
            };
            while last + 1 < end
                && self.stop_before_m(last + 1, ahead_m, hold_gap_m) < off_m(self, last)
            {
                last = self.group_last[last + 1].max(last + 1).min(end - 1);
            }
            self.group(*first, last);
        }
    }

    /// One group from `first` to `last`, taken as a roll where `roll`.
    pub fn group(&mut self, first: usize, last: usize) {
        for k in first..=last.min(self.pieces.len().saturating_sub(1)) {
            self.group_last[k] = last;
        }
    }

    /// Where a landing begins to turn off its runway, m: the begin of the arc at the end of its roll, or that end where it goes
    /// straight on. A node of another runway's centreline may lie a little beside this one's: that bend turns nobody off.
    #[must_use]
    pub fn turns_off_m(&self) -> Option<f64> {
        let end_m = *self.ends_m.get(self.roll.end.checked_sub(1)?)?;
        let arc = self.path.arcs().find(|(_, to_m, _)| *to_m >= end_m - 1.0);
        Some(arc.map_or(end_m, |arc| arc.0.min(end_m)))
    }

    /// Fills the envelope: the highest speed from which every limit ahead can be met; of a landing roll only the braking counts, and
    /// within the strip an exit is driven at its own speed.
    pub fn limit(&mut self, net: &Network, pieces: &Pieces, d: &Driving, roll: &Roll) {
        let Roll { free_to_m, dec_mps2: roll_dec_mps2, exit_mps, off_to_m, off_dec_mps2 } = *roll;
        let count = (self.stop_m.max(self.path.length_m()) / STEP_M).ceil() as usize + 2;
        let mut limits = vec![d.straight_mps; count];
        let cells = |from: f64, to: f64| {
            let low = (from / STEP_M).floor().max(0.0) as usize;
            low..((to / STEP_M).ceil() as usize + 1).min(count)
        };
        if off_to_m > free_to_m {
            let off_mps = exit_mps.max(d.straight_mps);
            limits[cells(free_to_m, off_to_m)].fill(off_mps);
        }
        let mut from = 0.0;
        for (z, end) in self.pieces.iter().zip(&self.ends_m) {
            let piece = &pieces.list[*z as usize];
            let edge = &net.edges[piece.edge];
            let at_stand =
                |e: &super::network::NetEdge| e.nodes.iter().any(|n| net.nodes[*n].stand.is_some());
            let most = if at_stand(edge) {
                LEAD_IN_MPS
            } else if net.is_lane(piece.edge) {
                LANE_MPS
            } else {
                f64::INFINITY
            };
            limits[cells(from, *end)].iter_mut().for_each(|l| *l = l.min(most));
            from = *end;
        }
        if let Some(last) = self.ends_m.last() {
            let stand = self.pieces.last().is_some_and(|z| {
                net.edges[pieces.list[*z as usize].edge]
                    .nodes
                    .iter()
                    .any(|n| net.nodes[*n].stand.is_some())
            });
            if stand && self.stop_m > *last {
                limits[cells(*last, self.stop_m)].iter_mut().for_each(|l| *l = l.min(LEAD_IN_MPS));
            }
        }
        limits[..((free_to_m / STEP_M).max(0.0) as usize).min(count)].fill(f64::INFINITY);
        for (from, to, curvature) in self.path.arcs().filter(|a| a.1 > free_to_m) {
            let turn = (to - from) * curvature.abs();
            let lateral = (d.lateral_mps2 / curvature.abs()).sqrt();
            let turns_off = off_to_m > free_to_m && from < free_to_m + 1.0;
            let most = match () {
                () if turns_off && turn <= FAST_TURN_RAD => lateral.min(exit_mps),
                () if turn > 0.8 => lateral.min(d.turn_mps),
                () => lateral,
            };
            limits[cells(from - 1.0, to + 1.0)]
                .iter_mut()
                .for_each(|l| *l = l.min(most.max(LEAST_MPS)));
        }
        if free_to_m > 0.0 {
            let at = ((free_to_m / STEP_M) as usize).min(count - 1);
            limits[at] = limits[at].min(exit_mps);
        }
        for i in (0..count - 1).rev() {
            let dec = match (i as f64) * STEP_M {
                at if at < free_to_m => roll_dec_mps2,
                at if at < off_to_m => off_dec_mps2,
                _ => 0.7 * d.dec_mps2,
            };
            limits[i] = limits[i].min((limits[i + 1] * limits[i + 1] + 2.0 * dec * STEP_M).sqrt());
        }
        self.envelope_mps = limits;
    }

    /// Highest speed at a place, m/s.
    #[must_use]
    pub fn most_mps(&self, place_m: f64) -> f64 {
        let index = (place_m / STEP_M).max(0.0) as usize;
        let at = |i: usize| self.envelope_mps.get(i).copied().unwrap_or(f64::INFINITY);
        at(index)
            .min(at(index + 1))
            .min(self.envelope_mps.last().copied().unwrap_or(f64::INFINITY).max(at(index)))
    }

    /// Whether somebody at a place meets every limit up to another with a braking, m/s².
    #[must_use]
    pub fn meets(&self, (from_m, to_m): (f64, f64), v_mps: f64, dec_mps2: f64) -> bool {
        let places =
            (0..).map(|k| STEP_M * f64::from(k)).take_while(|ahead| from_m + ahead <= to_m);
        let squared = |mps: f64| mps * mps;
        places.into_iter().all(|ahead| {
            squared(v_mps) <= squared(self.most_mps(from_m + ahead)) + 2.0 * dec_mps2 * ahead
        })
    }

    /// When each place is reached by somebody who drives alone from `from_m` with `v_mps`.
    #[must_use]
    pub fn alone(&self, from_m: f64, v_mps: f64, d: &Driving) -> Alone {
        self.alone_to(from_m, v_mps, d, f64::INFINITY)
    }

    /// The same for places up to `to_m` only.
    #[must_use]
    pub fn alone_to(&self, from_m: f64, v_mps: f64, d: &Driving, to_m: f64) -> Alone {
        let (mut place, mut v, mut time) = (from_m, v_mps, 0.0);
        let fastest = v_mps.max(d.straight_mps);
        let mut times_s = vec![0.0];
        while place < self.stop_m && place < to_m + STEP_M {
            let stop = (1.4 * d.dec_mps2 * (self.stop_m - place)).sqrt().max(0.3);
            let wish = self.most_mps(place).min(fastest);
            // Braking of a landing roll is in the envelope, not in the stop.
            let wish = if v > d.straight_mps { wish } else { wish.min(stop) };
            v = (v * v + 2.0 * d.acc_mps2 * STEP_M).sqrt().min(wish).max(0.3);
            time += STEP_M / v;
            place += STEP_M;
            times_s.push(time);
        }
        Alone { from_m, times_s }
    }

    /// Time to drive the way alone from `from_m` to its stop, s, by the envelope and the acceleration.
    #[must_use]
    pub fn unhindered_s(&self, from_m: f64, to_m: f64, d: &Driving) -> f64 {
        let (mut place, mut v, mut time) = (from_m, 0.3_f64, 0.0);
        while place < to_m {
            let stop = (2.0 * 0.7 * d.dec_mps2 * (to_m - place)).sqrt().max(0.3);
            let wish = self.most_mps(place).min(stop);
            v = (v * v + 2.0 * d.acc_mps2 * STEP_M).sqrt().min(wish).max(0.3);
            time += STEP_M / v;
            place += STEP_M;
        }
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::pieces::Piece;

    /// A way over pieces of 30 m, those of `strip` in a strip, with a place to wait for step `hold` at `hold_m`.
    fn way(count: usize, strip: Range<usize>, hold: Option<(usize, f64)>) -> (Way, Pieces) {
        let piece = |k: usize| {
            let strip = strip.contains(&k).then_some(0);
            Piece { edge: k, from_m: 0.0, to_m: 30.0, strip, runway: None, over: None }
        };
        let mut pieces = Pieces::default();
        pieces.list.extend((0..count).map(piece));
        let way = Way {
            pieces: (0..count as u32).collect(),
            ends_m: (1..=count).map(|k| 30.0 * k as f64).collect(),
            group_last: (0..count).collect(),
            holds_m: hold.into_iter().collect(),
            stop_m: 30.0 * count as f64,
            ..Way::default()
        };
        (way, pieces)
    }

    #[test]
    fn a_place_to_wait_far_before_a_strip_never_takes_back_what_was_given() {
        let (way, _) = way(10, 6..8, Some((6, 110.0)));
        let stops: Vec<f64> = (0..=10).map(|k| way.stop_before_m(k, 4.0, 5.0)).collect();
        assert!(stops.windows(2).all(|w| w[0] <= w[1]), "{stops:?}");
        assert_eq!(stops[3], 90.0 - GAP_M - 4.0);
        // The line lies at 110 m, two pieces back: no farther back than what the piece before gave.
        assert_eq!(stops[6], 150.0 - GAP_M - 4.0);
        assert_eq!(stops[10], way.stop_m);
    }

    #[test]
    fn who_has_driven_to_the_end_of_a_crossing_is_off_the_strip() {
        let body = (4.0, 61.0, 6.0);
        for hold in [None, Some((9, 250.0)), Some((8, 225.0))] {
            let (mut way, pieces) = way(20, 3..5, hold);
            way.group(3, 4);
            way.clear_strips(&pieces, &[3], usize::MAX, body);
            let last = way.group_last[3];
            let off_m = way.ends_m[4] + body.1;
            assert!(way.stop_before_m(last + 1, body.0, body.2) >= off_m, "{hold:?}: {last}");
            assert!(way.stop_before_m(last, body.0, body.2) < off_m, "{hold:?}: {last} is too far");
        }
        // A take-off is not begun by a crossing.
        let (mut way, pieces) = way(20, 3..5, None);
        way.clear_strips(&pieces, &[3], 6, body);
        assert_eq!(way.group_last[3], 5);
    }
}
