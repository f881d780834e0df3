//! Centrelines of taxiways and runways as a filter uses them: paths by length, and where they branch.

use crate::frames::Vector2;
use std::f64::consts::PI;

/// A line or an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: Vector2<f64>,
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
}

/// A point of a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoutePoint {
    /// Position, m.
    pub position: Vector2<f64>,
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
    pub fn from_course(from: Vector2<f64>, course_rad: f64) -> Self {
        let piece = Piece { from, course: course_rad, start: 0.0, length: 0.0, curvature: 0.0 };
        Self { pieces: vec![piece], length: 0.0 }
    }

    /// Straight lines through points; points nearer than 1 mm to the one before are left out.
    /// `None` with fewer than two different points or one that is not finite.
    #[must_use]
    pub fn through(points: &[Vector2<f64>]) -> Option<Self> {
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
    pub fn nearest(&self, z: Vector2<f64>) -> (f64, f64) {
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
        Self { edges: vec![Edge { route, next: Vec::new() }] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_route_is_continuous_and_its_foot_points_are_nearest() {
        let route = Route::from_course(Vector2::new(10.0, 20.0), 0.3)
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
        let a = Vector2::new(1.0, 2.0);
        assert_eq!(Route::through(&[]), None);
        assert_eq!(Route::through(&[a, a]), None);
        assert_eq!(Route::through(&[a, Vector2::new(f64::NAN, 0.0)]), None);
        let route =
            Route::through(&[a, a, Vector2::new(1.0, 5.0), Vector2::new(4.0, 5.0)]).unwrap();
        assert_eq!(route.length_m(), 6.0);
    }
}
