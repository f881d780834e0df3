//! A way as a line that can be driven: straight pieces with fillets (R9).

use crate::frames::{Azimuth, Point2, Vector2, wrap_pi};

/// A line of straight pieces and arcs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    parts: Vec<Part>,
    length_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    from_m: f64,
    at_m: Point2<f64>,
    heading_rad: f64,
    /// Positive to the right, 1/m.
    curvature: f64,
}

/// Place, direction and curvature (1/m, positive to the right) at one place of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnPath {
    /// East and north, m.
    pub at_m: Point2<f64>,
    /// Direction clockwise from north, rad, not wrapped.
    pub heading_rad: f64,
    /// 1/m.
    pub curvature: f64,
}

/// A point of the line that a path was made over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Place on the path, m: of a fillet its middle.
    pub place_m: f64,
    /// Radius of the fillet, m; 0 for a kink.
    pub radius_m: f64,
    /// Its turn, rad, not negative.
    pub turn_rad: f64,
}

impl Corner {
    /// From the point to where the fillet begins, m along the line.
    #[must_use]
    pub fn tangent_m(&self) -> f64 {
        self.radius_m * libm::tan(0.5 * self.turn_rad)
    }

    /// Distance on the path from the middle of the fillet to the place beside a point of the line that is
    /// `off_m` away from the corner.
    #[must_use]
    pub fn beside_m(&self, off_m: f64) -> f64 {
        let tangent = self.tangent_m();
        let half = 0.5 * self.turn_rad * self.radius_m;
        if off_m >= tangent {
            return half + off_m - tangent;
        }
        let share = ((tangent - off_m) / self.radius_m.max(1e-9)).min(1.0);
        (half - self.radius_m * libm::asin(share)).max(0.0)
    }
}

/// Radius of a fillet: what is wanted, less where an edge is short (half of it is left to each end).
#[must_use]
pub fn fillet_radius_m(wanted_m: f64, turn_rad: f64, before_m: f64, after_m: f64) -> f64 {
    wanted_m.min(0.5 * before_m.min(after_m) / libm::tan(0.5 * turn_rad.abs()).max(1e-9))
}

/// Turns below this stay kinks, rad: at 15 m/s a jump of 8 mm/s across.
pub(crate) const KINK_RAD: f64 = 0.0005;

impl Path {
    /// A path over `points`, with fillets of at most `radius_m(i, turn)` at point `i`; also where each point is
    /// on it (of a fillet: its middle). Points nearer than 1 cm to the one before are passed over.
    #[must_use]
    pub fn over(
        points: &[Point2<f64>],
        radius_m: impl Fn(usize, f64) -> f64,
    ) -> (Self, Vec<Corner>) {
        let mut path = Self::default();
        let mut places = vec![Corner::default(); points.len()];
        let Some(first) = points.first() else { return (path, places) };
        let kept: Vec<usize> = (0..points.len())
            .filter(|i| *i == 0 || (points[*i] - points[*i - 1]).norm() > 0.01)
            .collect();
        let mut at_m = *first;
        for (k, pair) in kept.windows(2).enumerate() {
            let (a, b) = (points[pair[0]], points[pair[1]]);
            let heading_rad = Azimuth::of(b - a).rad();
            let next = kept.get(k + 2).map(|i| points[*i]);
            let turn = next.map_or(0.0, |c| wrap_pi(Azimuth::of(c - b).rad() - heading_rad));
            let after = next.map_or(0.0, |c| (c - b).norm());
            let filleted = turn.abs() > KINK_RAD;
            let radius = if filleted {
                fillet_radius_m(radius_m(pair[1], turn), turn, (b - a).norm(), after)
            } else {
                0.0
            };
            let tangent = radius * libm::tan(0.5 * turn.abs());
            let along = (b - a) / (b - a).norm();
            let end = b - along * tangent;
            let straight = (end - at_m).dot(&along).max(0.0);
            path.push(at_m, heading_rad, 0.0, straight);
            at_m = end;
            if filleted && radius > 1e-3 {
                let arc = radius * turn.abs();
                path.push(end, heading_rad, turn.signum() / radius, arc);
                let turn_rad = turn.abs();
                places[pair[1]] =
                    Corner { place_m: path.length_m - 0.5 * arc, radius_m: radius, turn_rad };
                at_m = path.at(path.length_m).at_m;
            } else {
                places[pair[1]].place_m = path.length_m;
            }
        }
        for i in 1..places.len() {
            places[i].place_m = places[i].place_m.max(places[i - 1].place_m);
        }
        (path, places)
    }

    fn push(&mut self, at_m: Point2<f64>, heading_rad: f64, curvature: f64, length_m: f64) {
        if length_m > 0.0 {
            self.parts.push(Part { from_m: self.length_m, at_m, heading_rad, curvature });
            self.length_m += length_m;
        }
    }

    /// Length, m.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// The path at a place; before its begin and after its end it goes on straight.
    #[must_use]
    pub fn at(&self, place_m: f64) -> OnPath {
        let index = self.parts.partition_point(|p| p.from_m <= place_m).saturating_sub(1);
        let Some(part) = self.parts.get(index) else {
            return OnPath { at_m: Point2::origin(), heading_rad: 0.0, curvature: 0.0 };
        };
        let beyond = (place_m - self.length_m).max(0.0);
        let along = place_m.min(self.length_m) - part.from_m;
        let (curvature, along) = if along < 0.0 { (0.0, along) } else { (part.curvature, along) };
        let mut heading_rad = part.heading_rad;
        let mut at_m = part.at_m;
        if curvature == 0.0 {
            at_m += Azimuth::from_rad(heading_rad).unit() * along;
        } else {
            let turned = heading_rad + curvature * along;
            let (s0, c0) = libm::sincos(heading_rad);
            let (s1, c1) = libm::sincos(turned);
            at_m += Vector2::new(c0 - c1, s1 - s0) / curvature;
            heading_rad = turned;
        }
        if beyond > 0.0 {
            at_m += Azimuth::from_rad(heading_rad).unit() * beyond;
            return OnPath { at_m, heading_rad, curvature: 0.0 };
        }
        OnPath { at_m, heading_rad, curvature }
    }

    /// Direction at a place, clockwise from north, rad: that of [`Path::at`], without the place.
    #[must_use]
    pub fn heading_rad(&self, place_m: f64) -> f64 {
        let index = self.parts.partition_point(|p| p.from_m <= place_m).saturating_sub(1);
        self.parts.get(index).map_or(0.0, |part| {
            let along = place_m.min(self.length_m) - part.from_m;
            part.heading_rad + part.curvature * along.max(0.0)
        })
    }

    /// Arcs as (begin, end, curvature).
    pub fn arcs(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.parts.iter().enumerate().filter(|(_, p)| p.curvature != 0.0).map(|(i, p)| {
            let end = self.parts.get(i + 1).map_or(self.length_m, |n| n.from_m);
            (p.from_m, end, p.curvature)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fillet_is_tangent_and_shorter_than_its_corner() {
        let points = [(0.0, 0.0), (0.0, 100.0), (100.0, 100.0), (100.0, 103.0)];
        let points = points.map(|(x, y)| Point2::new(x, y));
        let (path, places) = Path::over(&points, |_, _| 30.0);
        assert!(path.length_m() < 203.0 && path.length_m() > 180.0);
        let mut place = 0.0;
        let mut last = path.at(0.0);
        while place < path.length_m() {
            place += 0.1;
            let here = path.at(place);
            assert!((here.at_m - last.at_m).norm() < 0.1001, "no jump at {place}");
            assert_eq!(path.heading_rad(place), here.heading_rad, "at {place}");
            last = here;
        }
        assert!((path.at(path.length_m()).at_m - points[3]).norm() < 1e-9);
        for place in [-3.0, path.length_m(), path.length_m() + 1e-6] {
            assert_eq!(path.heading_rad(place), path.at(place).heading_rad, "at {place}");
        }
        assert!(places.windows(2).all(|p| p[0].place_m <= p[1].place_m));
        // The last edge is 3 m long: its fillet has 1.5 m.
        assert!(path.arcs().any(|(_, _, c)| (1.0 / c.abs() - 1.5).abs() < 1e-9));
    }
}
