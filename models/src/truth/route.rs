//! Routes over the ground network and movers that drive them.

use super::fit::{Bound, Control, Datum, Fit};
use super::limits::Limits;
use super::spline::Spline;
use super::trajectory::{Leg, Trajectory};
use crate::airport::Airport;
use crate::frames::{Point2, Vector2};
use crate::time::SimTime;
use crate::traffic::ways::Graph;

/// A way along the network.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Indices of the nodes in [`Airport::nodes`], in order.
    pub nodes: Vec<usize>,
    /// Length, m.
    pub length_m: f64,
    /// Names of the taxiways, in order, without repetition; unnamed ones are left out.
    pub names: Vec<String>,
}

/// The shortest way from node `from` to node `to`, against no one-way edge; `None` if there is none.
///
/// Source: Dijkstra, Numer. Math. 1 (1959) 269. Of equally long ways the one over nodes with smaller
/// indices is taken, so the result does not depend on the order of the edges. Runways are avoided:
/// their length counts four times. A stand is only ever the begin or the end of a way.
#[must_use]
pub fn shortest(airport: &Airport, from: usize, to: usize) -> Option<Route> {
    shortest_in(airport, &Graph::of(airport), from, to)
}

/// The same for many ways: `graph` is that of `airport`.
#[must_use]
pub fn shortest_in(airport: &Airport, graph: &Graph, from: usize, to: usize) -> Option<Route> {
    let way = graph.cheapest(from, to, Graph::runway_cost)?;
    let mut names: Vec<String> = Vec::new();
    for arc in &way.arcs {
        let name = &airport.edges[graph.arcs()[*arc].edge].name;
        if !name.is_empty() && names.last() != Some(name) {
            names.push(name.clone());
        }
    }
    let length_m = way.arcs.iter().rev().map(|a| graph.arcs()[*a].length_m).sum();
    Some(Route { nodes: way.nodes, length_m, names })
}

/// A halt on a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halt {
    /// The point of the line at which it halts (index).
    pub point: usize,
    /// How long, s.
    pub duration_s: f64,
}

/// A mover that is at the begin of `line` (m, east and north) from `start`, sets off after `wait_s`
/// seconds, halts on the way and stands at the end of the line until `end`.
///
/// Corners are rounded, never sharper than the radius of the type; speed keeps within the limits on
/// straights and in turns, acceleration and braking within those of the type. `None` if the line is
/// shorter than a few metres or has points that are not finite.
#[must_use]
pub fn drive(
    line: &[Point2<f64>],
    halts: &[Halt],
    limits: &Limits,
    (start, end): (SimTime, SimTime),
    wait_s: f64,
) -> Option<Trajectory> {
    let (path, places) = rounded(line, limits.least_radius_m)?;
    let span_s = end.since_s(start).max(10.0);
    let pieces = span_s.ceil() as usize;
    let mut stops: Vec<(f64, f64)> =
        halts.iter().filter_map(|h| places.get(h.point).map(|m| (*m, h.duration_s))).collect();
    stops.push((*places.last()?, f64::INFINITY));
    let plan = Plan { path: &path, limits, stops: &stops, begin_m: places[0], wait_s };
    let progress = plan.progress(pieces)?;
    let leg = Leg { from_m: 0.0, path, backward: false };
    Trajectory::new(start, end, vec![leg], progress, None)
}

/// Distance of the controls of a path, m.
const PATH_STEP_M: f64 = 2.0;
/// Path before the first and after the last point, m.
const MARGIN_M: f64 = 6.0;

/// A smooth path near a line, and the places of the line's points on it.
fn rounded(line: &[Point2<f64>], least_radius_m: f64) -> Option<(Spline<2>, Vec<f64>)> {
    let mut points: Vec<Point2<f64>> = Vec::new();
    let mut corner_of = Vec::with_capacity(line.len());
    for (i, corner) in line.iter().enumerate() {
        if i > 0 {
            let from = line[i - 1];
            let way = corner - from;
            let count = (way.norm() / 1.0).ceil().max(1.0) as usize;
            for k in 1..=count {
                points.push(from + way * (k as f64 / count as f64));
            }
        } else {
            points.push(*corner);
        }
        corner_of.push(points.len() - 1);
    }
    // Corners sharper than the radius become the shortest turns that are not.
    let timed: Vec<_> = points.iter().enumerate().map(|(i, p)| (i as f64, *p)).collect();
    let turned = super::recorded::turned(&timed, 1.3 * least_radius_m);
    let corner_of: Vec<usize> = corner_of
        .iter()
        .map(|i| turned.partition_point(|(n, _)| *n < *i as f64).min(turned.len() - 1))
        .collect();
    let points: Vec<Point2<f64>> = turned.iter().map(|(_, p)| *p).collect();
    let mut places = vec![MARGIN_M];
    for pair in points.windows(2) {
        places.push(places[places.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let length_m = *places.last()?;
    if length_m < MARGIN_M + 4.0 || !length_m.is_finite() {
        return None;
    }
    // Rounded by a moving mean over the arc that a turn of the least radius needs.
    let reach_m = 1.6 * least_radius_m;
    let round = |i: usize| {
        let reach = reach_m.min(places[i] - MARGIN_M).min(length_m - places[i]);
        let window = |j: &usize| (places[*j] - places[i]).abs() <= reach;
        let low = (0..=i).rev().take_while(window).last().unwrap_or(i);
        let high = (i..points.len()).take_while(window).last().unwrap_or(i);
        let sum: Vector2<f64> = points[low..=high].iter().map(|p| p.coords).sum();
        Point2::from(sum / (high - low + 1) as f64)
    };
    let smooth: Vec<Point2<f64>> = (0..points.len()).map(round).collect();
    let mut along = vec![MARGIN_M];
    for pair in smooth.windows(2) {
        along.push(along[along.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let h = PATH_STEP_M;
    let pieces = ((along[along.len() - 1] + MARGIN_M) / h).ceil() as usize + 1;
    let data = smooth.iter().zip(&along).map(|(p, place)| Datum {
        place: place / h,
        value: (*p).into(),
        weight: 1.0,
    });
    let fit = Fit {
        controls: (0..pieces + 3).map(Control::Free).collect(),
        data: data.collect(),
        roughness: 4.0,
        stiffness: Vec::new(),
        bounds: Vec::new(),
    };
    let path = Spline::new(0.0, h, fit.unbounded()?)?;
    Some((path, corner_of.iter().map(|i| along[*i]).collect()))
}

struct Plan<'a> {
    path: &'a Spline<2>,
    limits: &'a Limits,
    /// Places and durations of halts, in order of place.
    stops: &'a [(f64, f64)],
    begin_m: f64,
    /// Rest before it sets off, s.
    wait_s: f64,
}

/// Share of the limits that the plan uses; the rest is for smoothing.
const SHARE: f64 = 0.7;

impl Plan<'_> {
    /// Fastest progress within the limits, then smoothed within them.
    fn progress(&self, pieces: usize) -> Option<Spline<1>> {
        let wish = self.wish(pieces as f64);
        let at = |t: f64| -> f64 {
            let i = wish.partition_point(|w| w.0 <= t).clamp(1, wish.len() - 1);
            let ((ta, a), (tb, b)) = (wish[i - 1], wish[i]);
            if tb > ta { a + (b - a) * ((t - ta) / (tb - ta)).clamp(0.0, 1.0) } else { b }
        };
        let count = pieces + 3;
        let tick = |j: usize| (j as f64 - 1.0).max(0.0);
        // Controls of standing times are one variable.
        let stands = |t: f64| at(t + 1.5) - at(t - 1.5) < 1e-6;
        let mut controls = Vec::with_capacity(count);
        let mut next = 0;
        for j in 0..count {
            if j > 0 && !(stands(tick(j)) && stands(tick(j - 1))) && j > 2 {
                next += 1;
            }
            controls.push(if next == 0 {
                Control::Fixed([self.begin_m])
            } else {
                Control::Free(next - 1)
            });
        }
        let data: Vec<Datum<1>> = (0..=4 * pieces)
            .map(|k| 0.25 * k as f64)
            .map(|t| Datum { place: t, value: [at(t)], weight: 4.0 })
            .collect();
        // The limit of a turn holds where the mover is, which the limits themselves change.
        let mut found: Option<Spline<1>> = None;
        for _ in 0..8 {
            let place = |t: f64| found.as_ref().map_or_else(|| at(t), |s| s.at(t).value[0]);
            let bounds = self.bounds(count, place);
            let (controls, data) = (controls.clone(), data.clone());
            let fit = Fit { controls, data, roughness: 0.5, stiffness: Vec::new(), bounds };
            let mut solution = fit.bounded()?;
            for j in 1..solution.len() {
                solution[j][0] = solution[j][0].max(solution[j - 1][0]);
            }
            found = Spline::new(0.0, 1.0, solution);
            if self.keeps_turns(found.as_ref()?) {
                break;
            }
        }
        found
    }

    /// True if no turn is driven faster than its limit.
    fn keeps_turns(&self, progress: &Spline<1>) -> bool {
        let mut t = 0.0;
        while t <= progress.end() {
            let jet = progress.at(t);
            if jet.first[0] > 1.02 * self.fastest(jet.value[0], jet.value[0]) {
                return false;
            }
            t += 0.25;
        }
        true
    }

    fn bounds(&self, count: usize, place: impl Fn(f64) -> f64) -> Vec<Bound<1>> {
        let tick = |j: usize| (j as f64 - 1.0).max(0.0);
        let l = self.limits;
        let mut bounds = Vec::with_capacity(3 * count);
        for j in 0..count {
            if j + 1 < count {
                let (low, high) = (place(tick(j) - 2.0) - 1.0, place(tick(j) + 3.0) + 1.0);
                bounds.push(Bound::between(1, j, 0.0, self.fastest(low, high).max(0.5)));
            }
            if j + 2 < count {
                // The parameter of the path is length within some percent: keep clear.
                bounds.push(Bound::between(2, j, -0.96 * l.taxi_dec_ms2, 0.96 * l.taxi_acc_ms2));
            }
            if j + 3 < count {
                bounds.push(Bound::between(3, j, -l.jerk_ms3, l.jerk_ms3));
            }
        }
        bounds
    }

    /// Speed limit between two places: straights, and lateral acceleration in turns.
    fn fastest(&self, from_m: f64, to_m: f64) -> f64 {
        let mut fastest = self.limits.taxi_mps;
        let mut place = from_m.max(0.0);
        while place <= to_m.min(self.path.end()) {
            let jet = self.path.at(place);
            let (d, dd) = (jet.first, jet.second);
            let speed2 = (d[0] * d[0] + d[1] * d[1]).max(1e-6);
            let bend = (d[0] * dd[1] - d[1] * dd[0]).abs() / (speed2 * speed2.sqrt());
            fastest = fastest.min((self.limits.lateral_ms2 / bend.max(1e-9)).sqrt());
            place += 1.0;
        }
        0.97 * fastest
    }

    /// Place by time of a mover that uses its limits: forward and backward passes over the path, then
    /// time along it with the halts. Starts and ends at rest.
    fn wish(&self, span_s: f64) -> Vec<(f64, f64)> {
        const STEP_M: f64 = 0.5;
        let end_m = self.stops.last().map_or(self.begin_m, |s| s.0);
        let count = ((end_m - self.begin_m) / STEP_M).ceil().max(1.0) as usize;
        let place = |i: usize| (self.begin_m + i as f64 * STEP_M).min(end_m);
        let mut speed: Vec<f64> =
            (0..=count).map(|i| SHARE * self.fastest(place(i) - 3.0, place(i) + 3.0)).collect();
        speed[0] = 0.0;
        for (m, _) in self.stops {
            speed[(((m - self.begin_m) / STEP_M).round().max(0.0) as usize).min(count)] = 0.0;
        }
        let (acc, dec) = (SHARE * self.limits.taxi_acc_ms2, SHARE * self.limits.taxi_dec_ms2);
        for i in 1..=count {
            speed[i] = speed[i].min((speed[i - 1] * speed[i - 1] + 2.0 * acc * STEP_M).sqrt());
        }
        for i in (0..count).rev() {
            speed[i] = speed[i].min((speed[i + 1] * speed[i + 1] + 2.0 * dec * STEP_M).sqrt());
        }
        // At least some seconds at rest before it sets off, so that it begins exactly still.
        let mut t = self.wait_s.max(3.0);
        let mut wish = vec![(0.0, self.begin_m), (t, self.begin_m)];
        let mut next_stop = 0;
        for i in 1..=count {
            t += STEP_M / (0.5 * (speed[i - 1] + speed[i])).max(0.05);
            wish.push((t, place(i)));
            while next_stop < self.stops.len() && self.stops[next_stop].0 <= place(i) + 0.5 * STEP_M
            {
                let duration_s = self.stops[next_stop].1.min(span_s + 10.0);
                if i == count || speed[i] == 0.0 {
                    t += duration_s;
                    wish.push((t, place(i)));
                }
                next_stop += 1;
            }
        }
        wish
    }
}
