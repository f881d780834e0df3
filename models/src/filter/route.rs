//! Centrelines of taxiways and runways as a filter uses them: paths by length, and where they branch.

use crate::airport::Airport;
use crate::frames::{Point2, Vector2, center};
use std::f64::consts::PI;

/// A line or an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: Point2<f64>,
    /// Radians from east to the left.
    course: f64,
    /// Path length at its start, m.
    start: f64,
    length: f64,
    /// 1/m, positive to the left.
    curvature: f64,
}

/// A centreline: lines and arcs one after another, by path length from its start. Beyond its ends it
/// goes straight on.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    pieces: Vec<Piece>,
    length: f64,
    /// A box that holds it.
    bounds: [Point2<f64>; 2],
}

/// A point of a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoutePoint {
    /// Position, m.
    pub position: Point2<f64>,
    /// Unit vector along.
    pub along: Vector2<f64>,
    /// Curvature, 1/m, positive to the left.
    pub curvature: f64,
    /// Number of the piece, to see whether two points are on one straight line.
    pub piece: usize,
}

impl RoutePoint {
    /// Unit vector to the left.
    #[must_use]
    pub fn left(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }
}

impl Route {
    /// A route from `from` with a course in radians from east to the left; add lines and arcs.
    #[must_use]
    pub fn from_course(from: Point2<f64>, course_rad: f64) -> Self {
        let piece = Piece { from, course: course_rad, start: 0.0, length: 0.0, curvature: 0.0 };
        Self { pieces: vec![piece], length: 0.0, bounds: [from; 2] }
    }

    /// Straight lines through points; points nearer than 1 mm to the one before are left out.
    /// `None` with fewer than two different points or one that is not finite.
    #[must_use]
    pub fn through(points: &[Point2<f64>]) -> Option<Self> {
        let mut route: Option<Self> = None;
        let mut last = *points.first()?;
        for point in points {
            let leg = point - last;
            if !(point.x.is_finite() && point.y.is_finite()) {
                return None;
            }
            if leg.norm() < 1e-3 {
                continue;
            }
            let course = libm::atan2(leg.y, leg.x);
            let so_far = route.get_or_insert_with(|| Self::from_course(last, course));
            so_far.push(course, leg.norm(), 0.0);
            last = *point;
        }
        route
    }

    fn push(&mut self, course: f64, length: f64, curvature: f64) {
        let end = self.at(self.length).position;
        if self.length == 0.0 {
            self.pieces.clear();
        }
        self.pieces.push(Piece { from: end, course, start: self.length, length, curvature });
        self.length += length;
        // An arc is nowhere farther from its start than it is long.
        let around = Vector2::repeat(if curvature == 0.0 { 0.0 } else { length });
        let last = self.at(self.length).position;
        let [low, high] = self.bounds;
        self.bounds = [low.inf(&(end - around)).inf(&last), high.sup(&(end + around)).sup(&last)];
    }

    /// Whether `z` is surely farther away than `distance_m` (not counting what lies beyond the ends).
    #[must_use]
    pub fn is_beyond(&self, z: Point2<f64>, distance_m: f64) -> bool {
        let [low, high] = self.bounds;
        let gap = (low - z).sup(&(z - high)).sup(&Vector2::zeros());
        gap.norm_squared() > distance_m * distance_m
    }

    /// Course at the end, radians from east to the left.
    fn end_course(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.course + p.curvature * p.length)
    }

    /// A straight line added at the end, after a corner of `corner_rad` to the left.
    #[must_use]
    pub fn line(mut self, length_m: f64, corner_rad: f64) -> Self {
        let course = self.end_course() + corner_rad;
        self.push(course, length_m, 0.0);
        self
    }

    /// An arc added at the end: `angle_rad` to the left (negative: right) with `radius_m`.
    #[must_use]
    pub fn arc(mut self, angle_rad: f64, radius_m: f64) -> Self {
        let course = self.end_course();
        self.push(course, angle_rad.abs() * radius_m, angle_rad.signum() / radius_m);
        self
    }

    /// Length, m.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.length
    }

    /// The point at path length `s`.
    #[must_use]
    pub fn at(&self, s: f64) -> RoutePoint {
        let after = self.pieces.partition_point(|p| p.start <= s);
        let piece = after.saturating_sub(1);
        let p = &self.pieces[piece];
        // Straight on beyond the ends.
        let on = (s - p.start).clamp(0.0, p.length);
        let beyond = s - p.start - on;
        let turned = p.curvature * on;
        let half = 0.5 * turned;
        let chord = if half.abs() < 1e-6 { on } else { on * libm::sin(half) / half };
        let (sin, cos) = libm::sincos(p.course + half);
        let middle = p.from + Vector2::new(cos, sin) * chord;
        let along = if turned == 0.0 {
            Vector2::new(cos, sin)
        } else {
            let (sin, cos) = libm::sincos(p.course + turned);
            Vector2::new(cos, sin)
        };
        let curvature = if beyond == 0.0 { p.curvature } else { 0.0 };
        RoutePoint { position: middle + along * beyond, along, curvature, piece }
    }

    /// Path length of the nearest point and its distance from `z`, m.
    #[must_use]
    pub fn nearest(&self, z: Point2<f64>) -> (f64, f64) {
        let mut best = (0.0, f64::INFINITY);
        for p in &self.pieces {
            let candidates = if p.curvature == 0.0 {
                let (sin, cos) = libm::sincos(p.course);
                [(z - p.from).dot(&Vector2::new(cos, sin)).clamp(0.0, p.length), 0.0]
            } else {
                // Angle at the centre between the start of the arc and the point.
                let (sin, cos) = libm::sincos(p.course);
                let centre = p.from + Vector2::new(-sin, cos) / p.curvature;
                let (a, b) = (p.from - centre, z - centre);
                let angle = libm::atan2(a.x * b.y - a.y * b.x, a.dot(&b)) * p.curvature.signum();
                let angle = if angle < -PI / 2.0 { angle + 2.0 * PI } else { angle };
                [(angle / p.curvature.abs()).clamp(0.0, p.length), p.length]
            };
            for on in candidates {
                let s = p.start + on;
                let distance = (self.at(s).position - z).norm();
                if distance < best.1 {
                    best = (s, distance);
                }
            }
        }
        best
    }
}

/// One stretch without a junction, and what follows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The centreline.
    pub route: Route,
    /// Edges that begin where this one ends, with the probability of each; they sum to 1 or are empty.
    pub next: Vec<(usize, f64)>,
    /// Width of the pavement, m; 0 where it says nothing of how far from the centreline targets keep.
    pub width_m: f64,
}

/// The ways that a target may take: stretches joined at junctions, each way out with a probability
/// (from the cleared route; equal where nothing is known).
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// The edges.
    pub edges: Vec<Edge>,
}

impl Network {
    /// A single way.
    #[must_use]
    pub fn single(route: Route) -> Self {
        Self { edges: vec![Edge { route, next: Vec::new(), width_m: 0.0 }] }
    }

    /// The ways over an airport: its taxiways and runways in every direction in which they may be driven,
    /// stretches without a junction in one piece. At a junction every way on is as likely as the next, but
    /// none that turns by more than 120°. A runway of which the ground network knows nothing is a stretch
    /// of its own.
    #[must_use]
    pub fn of_airport(airport: &Airport) -> Self {
        let place = |node: usize| airport.nodes[node].position_m;
        let mut arcs: Vec<Arc> = Vec::new();
        for edge in &airport.edges {
            let sound = edge.from < airport.nodes.len() && edge.to < airport.nodes.len();
            if !sound || !((place(edge.to) - place(edge.from)).norm() >= SHORTEST_M) {
                continue;
            }
            let arc = Arc { from: edge.from, to: edge.to, width_m: edge.width_m };
            arcs.push(arc);
            if edge.two_way {
                arcs.push(Arc { from: edge.to, to: edge.from, ..arc });
            }
        }
        arcs.sort_by_key(|a| (a.from, a.to));
        arcs.dedup_by_key(|a| (a.from, a.to));
        let arcs = &arcs;
        let leaving = |node: usize| {
            let first = arcs.partition_point(|a| a.from < node);
            let last = arcs.partition_point(|a| a.from <= node);
            first..last
        };
        let onward = |arc: usize| {
            let Arc { from, to, .. } = arcs[arc];
            let course = (place(to) - place(from)).normalize();
            leaving(to).filter(move |&next| {
                let turned = (place(arcs[next].to) - place(to)).normalize();
                arcs[next].to != from && turned.dot(&course) >= SHARPEST_COSINE
            })
        };
        let mut ways_in = vec![0; arcs.len()];
        (0..arcs.len()).for_each(|arc| onward(arc).for_each(|next| ways_in[next] += 1));
        // The only way on from its predecessor, and nobody else's: part of the same stretch.
        let follower = |arc: usize| {
            let mut ways = onward(arc);
            match (ways.next(), ways.next()) {
                (Some(next), None) if ways_in[next] == 1 => Some(next),
                _ => None,
            }
        };
        let mut inner = vec![false; arcs.len()];
        (0..arcs.len()).filter_map(follower).for_each(|next| inner[next] = true);
        let (mut edges, mut ends) = (Vec::new(), Vec::new());
        let mut first_of = vec![None; arcs.len()];
        let mut done = vec![false; arcs.len()];
        // Rings have no first arc; they are opened where they are met.
        let starts = (0..arcs.len()).filter(|&a| !inner[a]).chain(0..arcs.len());
        for start in starts {
            if done[start] {
                continue;
            }
            let (mut arc, mut points, mut length) = (start, vec![place(arcs[start].from)], 0.0);
            let mut width = 0.0;
            loop {
                done[arc] = true;
                let to = place(arcs[arc].to);
                let leg = (to - points[points.len() - 1]).norm();
                (width, length) = (width + arcs[arc].width_m * leg, length + leg);
                points.push(to);
                match follower(arc) {
                    Some(next) if !done[next] => arc = next,
                    _ => break,
                }
            }
            let Some(route) = Route::through(&points) else { continue };
            first_of[start] = Some(edges.len());
            edges.push(Edge { route, next: Vec::new(), width_m: width / length });
            ends.push(arc);
        }
        for (edge, end) in ends.into_iter().enumerate() {
            let ways: Vec<usize> = onward(end).filter_map(|next| first_of[next]).collect();
            let share = 1.0 / ways.len().max(1) as f64;
            edges[edge].next = ways.into_iter().map(|way| (way, share)).collect();
        }
        for runway in &airport.runways {
            let known = airport.edges.iter().any(|e| {
                let middle = center(&place(e.from), &place(e.to));
                e.runway && runway.distance_m(middle) < 0.5 * runway.width_m
            });
            let [a, b] = runway.ends_m;
            for ends in [[a, b], [b, a]].iter().filter(|_| !known) {
                if let Some(route) = Route::through(ends) {
                    edges.push(Edge { route, next: Vec::new(), width_m: runway.width_m });
                }
            }
        }
        Self { edges }
    }
}

/// One direction of an arc of the ground network.
#[derive(Clone, Copy, Debug)]
struct Arc {
    from: usize,
    to: usize,
    width_m: f64,
}

/// Arcs shorter than this have no direction, m.
const SHORTEST_M: f64 = 0.01;

/// Cosine of the sharpest turn that is taken without stopping, 120°.
const SHARPEST_COSINE: f64 = -0.5;

#[cfg(test)]
mod tests {
    use super::*;

    /// Arcs between places that a file does not have, or of one place, lead nowhere.
    #[test]
    fn arcs_of_no_places_make_no_way() {
        use crate::airport::{Edge as Between, Hold, Node};
        let node = |x: f64| Node {
            name: String::new(),
            position_m: Point2::new(x, 0.0),
            hold: Hold::None,
        };
        let between = |from, to| Between {
            from,
            to,
            two_way: true,
            runway: false,
            name: String::new(),
            width_m: 20.0,
        };
        let ways = |edges: Vec<Between>| {
            let airport =
                Airport { nodes: vec![node(0.0), node(100.0)], edges, ..Airport::default() };
            Network::of_airport(&airport).edges.len()
        };
        assert_eq!(ways(vec![between(0, 1)]), 2);
        for (from, to) in [(0, 2), (2, 0), (7, 9), (1, 1)] {
            assert_eq!(ways(vec![between(0, 1), between(from, to)]), 2, "{from} {to}");
            assert_eq!(ways(vec![between(from, to)]), 0, "{from} {to}");
        }
        // Twice the same, and one way.
        assert_eq!(ways(vec![between(0, 1), between(1, 0), between(0, 1)]), 2);
        assert_eq!(ways(vec![Between { two_way: false, ..between(0, 1) }]), 1);
    }

    #[test]
    fn a_route_is_continuous_and_its_foot_points_are_nearest() {
        let route = Route::from_course(Point2::new(10.0, 20.0), 0.3)
            .line(100.0, 0.0)
            .arc(1.2, 60.0)
            .arc(-0.8, 90.0)
            .line(50.0, 0.5);
        let mut before = route.at(-5.0);
        let mut s = -5.0;
        while s < route.length_m() + 5.0 {
            let here = route.at(s);
            assert!((here.position - before.position).norm() < 0.1001, "{s}");
            assert!((here.along.norm() - 1.0).abs() < 1e-12);
            let beside = here.position + here.left() * 4.0;
            if s > 1.0 && s < route.length_m() - 1.0 {
                assert!(route.nearest(beside).1 <= 4.0 + 1e-9, "{s}");
            }
            before = here;
            s += 0.1;
        }
        let turned = route.arc(3.0, 30.0);
        let (s, distance) = turned.nearest(turned.at(turned.length_m() - 1.0).position);
        assert!(distance < 1e-9 && (s - turned.length_m() + 1.0).abs() < 1e-9);
    }

    #[test]
    fn points_that_repeat_or_are_no_numbers_make_no_route() {
        let a = Point2::new(1.0, 2.0);
        assert_eq!(Route::through(&[]), None);
        assert_eq!(Route::through(&[a, a]), None);
        assert_eq!(Route::through(&[a, Point2::new(f64::NAN, 0.0)]), None);
        let route = Route::through(&[a, a, Point2::new(1.0, 5.0), Point2::new(4.0, 5.0)]).unwrap();
        assert_eq!(route.length_m(), 6.0);
    }

    #[test]
    fn an_airport_becomes_stretches_between_its_junctions() {
        use crate::airport::{self, Hold, Node, Runway};
        let node = |x: f64, y: f64| Node {
            name: format!("{x} {y}"),
            position_m: Point2::new(x, y),
            hold: Hold::None,
        };
        let arc = |from, to, two_way| airport::Edge {
            from,
            to,
            two_way,
            runway: false,
            name: String::new(),
            width_m: 20.0,
        };
        // 0 – 1 – 2 both ways, then straight on to 3 or left to 4, one way only; 5 – 5 is none.
        let airport = Airport {
            nodes: vec![
                node(0.0, 0.0),
                node(100.0, 0.0),
                node(200.0, 10.0),
                node(300.0, 10.0),
                node(200.0, 110.0),
                node(9.0, 9.0),
            ],
            edges: vec![
                arc(0, 1, true),
                arc(2, 1, true),
                arc(2, 3, false),
                arc(2, 4, false),
                arc(5, 5, true),
            ],
            runways: vec![Runway {
                names: ["09".to_owned(), "27".to_owned()],
                ends_m: [Point2::new(0.0, 500.0), Point2::new(2000.0, 500.0)],
                thresholds_m: [Point2::new(0.0, 500.0), Point2::new(2000.0, 500.0)],
                width_m: 45.0,
            }],
            ..Airport::default()
        };
        let network = Network::of_airport(&airport);
        let lengths: Vec<f64> = network.edges.iter().map(|e| e.route.length_m().round()).collect();
        let mut sorted = lengths.clone();
        sorted.sort_by(f64::total_cmp);
        assert_eq!(sorted, [100.0, 100.0, 200.0, 200.0, 2000.0, 2000.0]);
        let stem = network.edges.iter().find(|e| e.next.len() == 2).expect("forks at node 2");
        assert!((stem.route.length_m() - 200.5).abs() < 0.1 && stem.width_m == 20.0);
        for (way, share) in &stem.next {
            assert_eq!(*share, 0.5);
            let begin = network.edges[*way].route.at(0.0).position;
            assert!((begin - Point2::new(200.0, 10.0)).norm() < 1e-9);
        }
        assert!(stem.route.is_beyond(Point2::new(100.0, 30.0), 19.0));
        assert!(!stem.route.is_beyond(Point2::new(100.0, 30.0), 21.0));
        assert_eq!(Network::of_airport(&Airport::default()).edges, []);
    }
}
