//! What a mover covers of the ground: rectangles for fuselage and wing, or for a vehicle.

use crate::frames::{Azimuth, Point2, Vector2};

/// Size of a mover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Length, m.
    pub length_m: f64,
    /// Wing span; of a vehicle its width, m.
    pub span_m: f64,
    /// Aircraft (fuselage and wing) or vehicle (one rectangle).
    pub aircraft: bool,
}

/// A rectangle on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Corners in order, m east and north.
    pub corners_m: [Point2<f64>; 4],
}

/// The outline of a mover: fuselage `L × max(2 m, 0.11 L)` and wing of chord 0.20 L from 0.15 L behind to
/// 0.05 L ahead of the middle; vehicles are one rectangle (the second is the first).
#[must_use]
pub fn outline(size: Size, middle_m: Point2<f64>, heading_rad: f64) -> [Rectangle; 2] {
    let ahead = Azimuth::from_rad(heading_rad).unit();
    let right = Vector2::new(ahead.y, -ahead.x);
    let rectangle = |behind_m: f64, ahead_m: f64, width_m: f64| {
        let at = |along: f64, across: f64| middle_m + ahead * along + right * across;
        let half = 0.5 * width_m;
        let corners_m =
            [at(-behind_m, -half), at(-behind_m, half), at(ahead_m, half), at(ahead_m, -half)];
        Rectangle { corners_m }
    };
    let l = size.length_m;
    if !size.aircraft {
        return [rectangle(0.5 * l, 0.5 * l, size.span_m); 2];
    }
    let fuselage = rectangle(0.5 * l, 0.5 * l, (0.11 * l).max(2.0));
    [fuselage, rectangle(0.15 * l, 0.05 * l, size.span_m)]
}

/// Least distance of two outlines, m; 0 where they overlap.
#[must_use]
pub fn distance_m(a: &[Rectangle; 2], b: &[Rectangle; 2]) -> f64 {
    let mut least = f64::INFINITY;
    for x in a {
        for y in b {
            least = least.min(convex_distance_m(&x.corners_m, &y.corners_m));
        }
    }
    least
}

/// Least distance of an outline from a line, m; 0 where it lies on it.
#[must_use]
pub fn distance_to_line_m(a: &[Rectangle; 2], line_m: [Point2<f64>; 2]) -> f64 {
    let each = a.iter().map(|x| convex_distance_m(&x.corners_m, &line_m));
    each.fold(f64::INFINITY, f64::min)
}

/// Least distance of two convex polygons, 0 where they overlap or one contains the other.
fn convex_distance_m(a: &[Point2<f64>], b: &[Point2<f64>]) -> f64 {
    if overlap_depth_m(a, b) >= 0.0 {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for (these, those) in [(a, b), (b, a)] {
        for p in these {
            for i in 0..those.len() {
                let end = those[(i + 1) % those.len()];
                least = least.min(crate::airport::distance_to_segment_m(*p, those[i], end));
            }
        }
    }
    least
}

/// Depth to which two convex polygons overlap: the least over the directions of their sides (separating
/// axes); negative where they are apart. Repeated corners are passed over.
#[must_use]
pub fn overlap_depth_m(a: &[Point2<f64>], b: &[Point2<f64>]) -> f64 {
    let mut depth = f64::INFINITY;
    for polygon in [a, b] {
        for i in 0..polygon.len() {
            let side = polygon[(i + 1) % polygon.len()] - polygon[i];
            let length = side.norm();
            if length < 1e-9 {
                continue;
            }
            let axis = Vector2::new(side.y, -side.x) / length;
            let (low_a, high_a) = extent(a, axis);
            let (low_b, high_b) = extent(b, axis);
            depth = depth.min(high_a.min(high_b) - low_a.max(low_b));
            if depth < 0.0 {
                return depth;
            }
        }
    }
    depth
}

fn extent(polygon: &[Point2<f64>], axis: Vector2<f64>) -> (f64, f64) {
    polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let along = p.coords.dot(&axis);
        (low.min(along), high.max(along))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wing_reaches_over_a_car_beside_the_fuselage() {
        let a320 = Size { length_m: 37.57, span_m: 35.8, aircraft: true };
        let car = Size { length_m: 4.6, span_m: 1.9, aircraft: false };
        let aircraft = outline(a320, Point2::origin(), 0.0);
        let beside = |east: f64, north: f64| {
            distance_m(&aircraft, &outline(car, Point2::new(east, north), 0.0))
        };
        assert_eq!(beside(15.0, -2.0), 0.0, "under the wing");
        assert!(beside(15.0, 10.0) > 3.0, "ahead of the wing");
        assert!((beside(18.85, 0.0) - 0.0).abs() < 1e-9 || beside(18.85, 0.0) < 1.0);
        assert_eq!(beside(0.0, 18.0), 0.0, "under the nose");
    }
}
