//! How large a target is by the cells (or echoes) that it lights: second moments of one look, averaged over looks.
//!
//! Centroid `m`, second moments `C` of the cells with equal weights, `D = C − σ_c² I` without what one cell spreads by
//! itself. A uniform stick of length L has the variance L²/12 along itself:
//!
//! ```text
//! length = √(12 max(eᵀDe, 0)),  width = √(12 max(gᵀDg, 0))          e along, g across the velocity
//! longest axis: the larger eigenvalue of D, at ½ atan2(2 D_en, D_nn − D_ee) clockwise from north
//! ```
//!
//! Averaged is D, not the lengths: a length is never negative, so that noise would lengthen what is small.
//!
//! Source: moments of a uniform distribution; as a measurement of extent: Koch, "Bayesian approach to extended object and
//! cluster tracking using random matrices", IEEE Trans. AES-44 (2008).

use crate::frames::{Point2, Vector2};

/// Second moments of what a target lights, east and north, without the spread of a point: m², may be negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// East–east.
    pub ee: f64,
    /// East–north.
    pub en: f64,
    /// North–north.
    pub nn: f64,
}

/// Variance of a uniform stick of length one.
const STICK: f64 = 12.0;

fn length_m(variance_m2: f64) -> f64 {
    (STICK * variance_m2.max(0.0)).sqrt()
}

impl Moments {
    /// Centroid (m) and moments of the cells of one echo, each of variance `cell_m2` by itself; nothing of no cell.
    #[must_use]
    pub fn of(cells_m: &[Point2<f64>], cell_m2: f64) -> Option<(Point2<f64>, Self)> {
        let n = cells_m.len() as f64;
        let centroid = Point2::from(cells_m.iter().map(|c| c.coords).sum::<Vector2<f64>>() / n);
        let mut sum = Self::default();
        for cell in cells_m {
            let d = cell - centroid;
            sum = Self { ee: sum.ee + d.x * d.x, en: sum.en + d.x * d.y, nn: sum.nn + d.y * d.y };
        }
        let found = Self { ee: sum.ee / n - cell_m2, en: sum.en / n, nn: sum.nn / n - cell_m2 };
        (n > 0.0).then_some((centroid, found))
    }

    /// Of moments along `axis` (a unit vector), between, and across it (turned 90° clockwise), m².
    #[must_use]
    pub fn turned(axis: Vector2<f64>, [along, between, across]: [f64; 3]) -> Self {
        let g = Vector2::new(axis.y, -axis.x);
        Self {
            ee: along * axis.x * axis.x + 2.0 * between * axis.x * g.x + across * g.x * g.x,
            en: along * axis.x * axis.y
                + between * (axis.x * g.y + axis.y * g.x)
                + across * g.x * g.y,
            nn: along * axis.y * axis.y + 2.0 * between * axis.y * g.y + across * g.y * g.y,
        }
    }

    fn along(&self, u: Vector2<f64>) -> f64 {
        self.ee * u.x * u.x + 2.0 * self.en * u.x * u.y + self.nn * u.y * u.y
    }

    /// Length along and width across `velocity_mps`, m; of one that stands, along and across its longest axis.
    #[must_use]
    pub fn length_and_width_m(&self, velocity_mps: Vector2<f64>) -> (f64, f64) {
        let speed = velocity_mps.norm();
        let e = if speed > 0.0 && speed.is_finite() {
            velocity_mps / speed
        } else {
            let (sin, cos) = libm::sincos(self.axis_rad());
            Vector2::new(sin, cos)
        };
        (length_m(self.along(e)), length_m(self.along(Vector2::new(e.y, -e.x))))
    }

    /// Length of the longest axis, m.
    #[must_use]
    pub fn longest_m(&self) -> f64 {
        let half_gap = 0.5 * (self.ee - self.nn);
        length_m(0.5 * (self.ee + self.nn) + libm::hypot(half_gap, self.en))
    }

    /// Where the longest axis points, radians clockwise from north in (−π/2, π/2].
    #[must_use]
    pub fn axis_rad(&self) -> f64 {
        0.5 * libm::atan2(2.0 * self.en, self.nn - self.ee)
    }

    fn blended(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self { ee: mix(self.ee, other.ee), en: mix(self.en, other.en), nn: mix(self.nn, other.nn) }
    }
}

/// What the looks at one target have shown of its extent. The axes are kept in the frame of the target where its course is
/// known (east is across, north along), so that a turn does not smear them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    mean: Moments,
    looks: f64,
    /// Along the course; else east and north.
    framed: bool,
}

/// Share that is kept from look to look.
const KEPT: f64 = 0.9;
/// Shorter ones show no axis, m.
const SHOWS_AXIS_M: f64 = 10.0;
/// Looks before anything is said.
const FEWEST: f64 = 5.0;

impl Extent {
    /// Takes one look (moments east and north) at a target whose nose points along `course`, a unit vector.
    pub fn learn(&mut self, seen: &Moments, course: Option<Vector2<f64>>) {
        if !(seen.ee + seen.nn + seen.en).is_finite() {
            return;
        }
        let own = match course {
            // Components along and across the course.
            Some(e) => {
                let g = Vector2::new(e.y, -e.x);
                let between =
                    seen.ee * e.x * g.x + seen.en * (e.x * g.y + e.y * g.x) + seen.nn * e.y * g.y;
                Moments { ee: seen.along(g), en: between, nn: seen.along(e) }
            }
            None => *seen,
        };
        if self.framed != course.is_some() {
            // What was seen before its course was known tells nothing of length and width.
            *self = Self { framed: course.is_some(), ..Self::default() };
        }
        self.looks = KEPT * self.looks + 1.0;
        self.mean = self.mean.blended(&own, 1.0 / self.looks);
    }

    /// Length and width, m, once enough looks say so: as far as it lights cells, so a little less than the body.
    #[must_use]
    pub fn size_m(&self) -> Option<(f64, f64)> {
        let nose = if self.framed { Vector2::new(0.0, 1.0) } else { Vector2::zeros() };
        (self.looks >= FEWEST * KEPT).then(|| self.mean.length_and_width_m(nose))
    }

    /// Along which line (either way) one that has never moved lies, as a unit vector: where it is long and narrow enough to
    /// say so.
    #[must_use]
    pub fn axis(&self) -> Option<Vector2<f64>> {
        let (length, width) = self.size_m().filter(|_| !self.framed)?;
        let (sin, cos) = libm::sincos(self.mean.axis_rad());
        (self.mean.longest_m() >= SHOWS_AXIS_M && length >= 1.5 * width)
            .then(|| Vector2::new(sin, cos))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, uniform};

    /// Cells of a body of this size at this heading, each shifted by a cell's own spread.
    fn lit(length: f64, width: f64, heading: f64, look: u64) -> Vec<Point2<f64>> {
        let mut rng = DrawKey { run_seed: 5, sensor: 1, entity: 1, scan: look }.rng(Purpose::Study);
        let (sin, cos) = libm::sincos(heading);
        let (e, g) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
        (0..60)
            .map(|_| {
                let mut draw = |l: f64| l * (uniform(&mut rng) - 0.5);
                let body = e * draw(length) + g * draw(width);
                Point2::from(body + Vector2::new(draw(CELL_M), draw(CELL_M)))
            })
            .collect()
    }

    const CELL_M: f64 = 5.4;

    #[test]
    fn a_body_that_turns_keeps_its_size_and_a_point_has_none() {
        for (length, width, tolerance) in [(38.0, 4.0, 2.0), (38.0, 30.0, 2.0), (12.0, 3.0, 2.0)] {
            let mut extent = Extent::default();
            let mut worst = 0.0f64;
            for look in 0..60 {
                let heading = 0.1 * look as f64;
                let cells = lit(length, width, heading, look);
                let (_, seen) = Moments::of(&cells, CELL_M * CELL_M / 12.0).expect("cells");
                let (sin, cos) = libm::sincos(heading);
                extent.learn(&seen, Some(Vector2::new(sin, cos)));
                if look < 4 {
                    assert_eq!(extent.size_m(), None, "not of {look} looks");
                } else if look > 20 {
                    let (l, w) = extent.size_m().expect("seen often");
                    worst = worst.max((l - length).abs()).max((w - width).abs());
                }
            }
            assert!(worst < tolerance, "{length} by {width}: off by {worst} m");
        }
        let one = Moments::of(&[Point2::new(3.0, 4.0)], 1.0).expect("a cell").1;
        assert_eq!((one.longest_m(), one.axis_rad()), (0.0, 0.0));
        assert_eq!(Moments::of(&[], 1.0), None);
    }

    #[test]
    fn moments_along_a_line_of_sight_are_those_east_and_north() {
        let cells = lit(30.0, 6.0, 0.7, 3);
        let (centroid, wanted) = Moments::of(&cells, 0.0).expect("cells");
        let axis = Vector2::new(0.6, 0.8);
        let g = Vector2::new(axis.y, -axis.x);
        let n = cells.len() as f64;
        let mut along = [0.0; 3];
        for cell in &cells {
            let (a, b) = ((cell - centroid).dot(&axis), (cell - centroid).dot(&g));
            along[0] += a * a / n;
            along[1] += a * b / n;
            along[2] += b * b / n;
        }
        let found = Moments::turned(axis, along);
        for (a, b) in [(found.ee, wanted.ee), (found.en, wanted.en), (found.nn, wanted.nn)] {
            assert!((a - b).abs() < 1e-10, "{found:?} {wanted:?}");
        }
    }

    /// Seen lying at 45° before its course was known, it is no shorter and no wider for it afterwards.
    #[test]
    fn what_was_seen_before_its_course_was_known_is_none_of_its_length() {
        let heading = std::f64::consts::FRAC_PI_4;
        let (sin, cos) = libm::sincos(heading);
        let mut extent = Extent::default();
        for look in 0..30 {
            let cells = lit(38.0, 4.0, heading, look);
            let (_, seen) = Moments::of(&cells, CELL_M * CELL_M / 12.0).expect("cells");
            let course = (look >= 20).then_some(Vector2::new(sin, cos));
            extent.learn(&seen, course);
            if (20..24).contains(&look) {
                assert_eq!(extent.size_m(), None, "look {look}");
            }
            assert!(look < 20 || extent.axis().is_none());
        }
        let (length, width) = extent.size_m().expect("seen often");
        assert!((length - 38.0).abs() < 2.5 && (width - 4.0).abs() < 2.5, "{length} {width}");
    }

    /// What has never moved lies along its axis if it is long and narrow; round or small bodies lie in no direction.
    #[test]
    fn only_what_is_long_and_narrow_shows_how_it_lies() {
        for k in 0..12 {
            let heading = 0.26 * f64::from(k);
            for (length, width, shows) in
                [(38.0, 4.0, true), (30.0, 12.0, true), (30.0, 27.0, false), (6.0, 2.0, false)]
            {
                let mut extent = Extent::default();
                for look in 0..30 {
                    let cells = lit(length, width, heading, look);
                    let (_, seen) = Moments::of(&cells, CELL_M * CELL_M / 12.0).expect("cells");
                    extent.learn(&seen, None);
                }
                let (sin, cos) = libm::sincos(heading);
                let along = extent.axis().map(|axis| axis.dot(&Vector2::new(sin, cos)).abs());
                assert_eq!(along.is_some(), shows, "{length} by {width} at {heading}");
                assert!(along.is_none_or(|cos| cos > 0.99), "{length} by {width}: {along:?}");
            }
        }
    }
}
