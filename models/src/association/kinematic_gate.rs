//! The second gate: is the plot within reach of a target of this class?
//!
//! The reachable set is the convex hull of the end points of nine constant controls (brake, coast,
//! accelerate; turn left, straight, right). It stands for the method "based on the aircraft kinematics
//! characteristics" of the paper, whose own text is not public. Only for plots that the covariance
//! gate refused.

use crate::frames::{Matrix2, Point2, Vector2};
use nalgebra::Matrix4;

/// What a class of movers can do on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassLimits {
    /// Largest forward acceleration, m/s².
    pub acceleration_ms2: f64,
    /// Largest braking, m/s².
    pub braking_ms2: f64,
    /// Largest lateral acceleration, m/s².
    pub lateral_ms2: f64,
    /// Largest turn rate, rad/s.
    pub turn_rate_rads: f64,
    /// Smallest turn radius, m.
    pub turn_radius_m: f64,
    /// Largest speed, m/s.
    pub speed_mps: f64,
}

/// A target at its last update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector2<f64>,
    /// Covariance of (px, py, vx, vy).
    pub covariance: Matrix4<f64>,
}

/// The look of [`reach`] at one plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// `L²/(eᵀEe)`: squared distance from the set over its variance in that direction; 0 inside.
    pub m: f64,
}

/// Below this speed the direction of motion says nothing and the set is a disc, m/s.
const SLOWEST_MPS: f64 = 1.0;

/// The set that a target can reach in some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReachableSet {
    /// Around the last position.
    Disc {
        /// Radius, m.
        radius_m: f64,
    },
    /// Convex hull in track axes (along, left), counter-clockwise.
    Hull {
        /// The vertices.
        vertices: [Vector2<f64>; 9],
        /// How many of them are used: 1 to 9.
        count: usize,
    },
}

impl ReachableSet {
    /// The set after `dt_s` seconds (not negative) from speed `speed_mps`.
    #[must_use]
    pub fn new(limits: &ClassLimits, speed_mps: f64, dt_s: f64) -> Self {
        if speed_mps < SLOWEST_MPS {
            let way = speed_mps * dt_s + 0.5 * limits.acceleration_ms2 * dt_s * dt_s;
            return Self::Disc { radius_m: way.min(limits.speed_mps * dt_s) };
        }
        let fastest = (speed_mps + limits.acceleration_ms2 * dt_s).min(limits.speed_mps);
        let turn = limits
            .turn_rate_rads
            .min(limits.lateral_ms2 / speed_mps.max(1.0))
            .min(fastest / limits.turn_radius_m)
            .min(std::f64::consts::PI / (2.0 * dt_s));
        // A target that is already faster than its class allows does not get faster still.
        let top = limits.speed_mps.max(speed_mps);
        let mut ends = [Vector2::zeros(); 9];
        for (k, along) in
            [-limits.braking_ms2, 0.0, limits.acceleration_ms2].into_iter().enumerate()
        {
            let left = arc_end(speed_mps, along, turn, dt_s, top);
            ends[3 * k] = Vector2::new(left.x, -left.y);
            ends[3 * k + 1] = arc_end(speed_mps, along, 0.0, dt_s, top);
            ends[3 * k + 2] = left;
        }
        let (vertices, count) = convex_hull(ends);
        Self::Hull { vertices, count }
    }

    /// The vertices of a hull; none for a disc.
    #[must_use]
    pub fn vertices(&self) -> &[Vector2<f64>] {
        match self {
            Self::Disc { .. } => &[],
            Self::Hull { vertices, count } => &vertices[..*count],
        }
    }

    /// From the nearest point of the set to `point` (both in the set's own axes); zero inside.
    #[must_use]
    pub fn from_nearest(&self, point: Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Disc { radius_m } => {
                let distance = libm::hypot(point.x, point.y);
                if distance <= *radius_m {
                    Vector2::zeros()
                } else {
                    point * ((distance - radius_m) / distance)
                }
            }
            Self::Hull { vertices, count } => from_hull(&vertices[..*count], point),
        }
    }
}

/// Distance of `plot_m` from what the target can reach in `dt_s` seconds, over its uncertainty.
///
/// `E = P_pp + T(P_pv + P_vp) + T² P_vv + R`, no process noise: the set holds the manoeuvre. `None` if
/// anything is not finite, `dt_s` is negative, or `eᵀEe` is not positive outside the set.
#[must_use]
pub fn reach(
    limits: &ClassLimits,
    target: &Departure,
    dt_s: f64,
    plot_m: Point2<f64>,
    r_m2: Matrix2<f64>,
) -> Option<Reach> {
    let velocity = target.velocity_mps;
    let speed = libm::hypot(velocity.x, velocity.y);
    let from_start = plot_m - target.position_m;
    if !(dt_s >= 0.0
        && dt_s.is_finite()
        && speed.is_finite()
        && from_start.norm_squared().is_finite())
    {
        return None;
    }
    let set = ReachableSet::new(limits, speed, dt_s);
    let outside = match set {
        ReachableSet::Disc { .. } => set.from_nearest(from_start),
        ReachableSet::Hull { .. } => {
            let along = velocity / speed;
            let left = Vector2::new(-along.y, along.x);
            let local = Vector2::new(along.dot(&from_start), left.dot(&from_start));
            let gap = set.from_nearest(local);
            along * gap.x + left * gap.y
        }
    };
    let distance = libm::hypot(outside.x, outside.y);
    if distance == 0.0 {
        return Some(Reach { m: 0.0 });
    }
    let e = outside / distance;
    let p = &target.covariance;
    let pp = p.fixed_view::<2, 2>(0, 0);
    let pv = p.fixed_view::<2, 2>(0, 2);
    let vv = p.fixed_view::<2, 2>(2, 2);
    let cross = (e.transpose() * pv * e)[0];
    let variance = (e.transpose() * pp * e)[0]
        + 2.0 * dt_s * cross
        + dt_s * dt_s * (e.transpose() * vv * e)[0]
        + (e.transpose() * r_m2 * e)[0];
    let m = distance * distance / variance;
    (variance > 0.0 && m.is_finite()).then_some(Reach { m })
}

/// End point (along, left) after `dt_s` seconds at acceleration `a` and turn rate `rate`, speed
/// `clip(speed + a t, 0, top)`: split where the speed meets a limit, each piece turned by the heading
/// reached so far.
fn arc_end(speed: f64, a: f64, rate: f64, dt_s: f64, top: f64) -> Vector2<f64> {
    // Times at which the unclipped speed crosses the limits, in order.
    let mut cuts = [0.0, dt_s, dt_s, dt_s];
    if a != 0.0 {
        let mut crossings = [(top - speed) / a, -speed / a];
        if crossings[1] < crossings[0] {
            crossings.swap(0, 1);
        }
        cuts[1] = crossings[0].clamp(0.0, dt_s);
        cuts[2] = crossings[1].clamp(0.0, dt_s);
    }
    let mut end = Vector2::zeros();
    for piece in cuts.windows(2) {
        let tau = piece[1] - piece[0];
        if tau <= 0.0 {
            continue;
        }
        let unclipped = speed + a * (0.5 * (piece[0] + piece[1]));
        let (start, a) = if unclipped >= top {
            (top, 0.0)
        } else if unclipped <= 0.0 {
            (0.0, 0.0)
        } else {
            ((speed + a * piece[0]).clamp(0.0, top), a)
        };
        let [along, left] = arc_piece(start, a, rate * tau, tau);
        let turned = rate * piece[0];
        let (sin, cos) = if turned == 0.0 { (0.0, 1.0) } else { libm::sincos(turned) };
        end += Vector2::new(cos * along - sin * left, sin * along + cos * left);
    }
    end
}

/// One piece of constant acceleration and turn rate: `l = s₀τ c₀ + aτ² c₁`, `n = s₀τX c₂ + aτ²X c₃`
/// with `X = ωτ`; series for |X| < 0.5, where the closed forms cancel.
fn arc_piece(speed: f64, a: f64, x: f64, tau: f64) -> [f64; 2] {
    let x2 = x * x;
    let c = if x == 0.0 {
        [1.0, 0.5, 0.5, 1.0 / 3.0]
    } else if x.abs() < 0.5 {
        SERIES.iter().rev().fold([0.0; 4], |c, term| [0, 1, 2, 3].map(|k| term[k] - x2 * c[k]))
    } else {
        let (sin, cos) = libm::sincos(x);
        [sin / x, (x * sin + cos - 1.0) / x2, (1.0 - cos) / x2, (sin - x * cos) / (x2 * x)]
    };
    let (straight, grown) = (speed * tau, a * tau * tau);
    [straight * c[0] + grown * c[1], x * (straight * c[2] + grown * c[3])]
}

/// 1/(2k+1)!, 1/((2k)!(2k+2)), 1/(2k+2)!, 1/((2k+1)!(2k+3)): nine terms reach 1e-20 at X = 0.5.
const SERIES: [[f64; 4]; 9] = {
    let mut terms = [[0.0; 4]; 9];
    let (mut k, mut factorial) = (0, 1.0); // (2k)!
    while k < terms.len() {
        let n = (2 * k) as f64;
        terms[k] = [
            1.0 / (factorial * (n + 1.0)),
            1.0 / (factorial * (n + 2.0)),
            1.0 / (factorial * (n + 1.0) * (n + 2.0)),
            1.0 / (factorial * (n + 1.0) * (n + 3.0)),
        ];
        factorial *= (n + 1.0) * (n + 2.0);
        k += 1;
    }
    terms
};

fn cross(o: Vector2<f64>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x)
}

/// Monotone chain (Andrew 1979): counter-clockwise, without duplicates and collinear points.
fn convex_hull(mut points: [Vector2<f64>; 9]) -> ([Vector2<f64>; 9], usize) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut distinct = 1;
    for index in 1..points.len() {
        if points[index] != points[distinct - 1] {
            points[distinct] = points[index];
            distinct += 1;
        }
    }
    let points = &points[..distinct];
    // A hull of nine points in two chains, each point at most once in either, plus the closing one.
    let (mut hull, mut count) = ([Vector2::zeros(); 20], 0);
    for &p in points {
        while count >= 2 && cross(hull[count - 2], hull[count - 1], p) <= 0.0 {
            count -= 1;
        }
        hull[count] = p;
        count += 1;
    }
    let lower = count + 1;
    for &p in points.iter().rev().skip(1) {
        while count >= lower && cross(hull[count - 2], hull[count - 1], p) <= 0.0 {
            count -= 1;
        }
        hull[count] = p;
        count += 1;
    }
    let count = if distinct == 1 { 1 } else { count - 1 };
    let mut vertices = [Vector2::zeros(); 9];
    vertices[..count].copy_from_slice(&hull[..count]);
    (vertices, count)
}

/// From the nearest point of a convex polygon (or segment, or point) to `point`; zero inside.
fn from_hull(vertices: &[Vector2<f64>], point: Vector2<f64>) -> Vector2<f64> {
    let next = |k: usize| vertices[(k + 1) % vertices.len()];
    let inside = vertices.len() >= 3
        && vertices.iter().enumerate().all(|(k, &v)| cross(v, next(k), point) >= 0.0);
    if inside {
        return Vector2::zeros();
    }
    let mut best = point - vertices[0];
    for (k, &v) in vertices.iter().enumerate() {
        let edge = next(k) - v;
        let length2 = edge.norm_squared();
        let t =
            if length2 > 0.0 { ((point - v).dot(&edge) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let gap = point - (v + edge * t);
        if gap.norm_squared() < best.norm_squared() {
            best = gap;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const JET: ClassLimits = ClassLimits {
        acceleration_ms2: 3.0,
        braking_ms2: 4.5,
        lateral_ms2: 2.5,
        turn_rate_rads: 0.35,
        turn_radius_m: 15.0,
        speed_mps: 95.0,
    };

    /// The same motion in small steps.
    fn integrate(speed: f64, a: f64, rate: f64, dt_s: f64, top: f64) -> Vector2<f64> {
        let steps = 40_000;
        let h = dt_s / f64::from(steps);
        (0..steps).fold(Vector2::zeros(), |sum, k| {
            let t = (f64::from(k) + 0.5) * h;
            let (sin, cos) = libm::sincos(rate * t);
            sum + Vector2::new(cos, sin) * (speed + a * t).clamp(0.0, top) * h
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn arcs_are_the_integrated_motion(
            speed in 1.0..130.0f64, a in -8.0..4.0f64, rate in -1.0..1.0f64, dt in 0.0..4.0f64,
        ) {
            let found = arc_end(speed, a, rate, dt, 95.0);
            let expected = integrate(speed, a, rate, dt, 95.0);
            prop_assert!((found - expected).norm() < 1e-5, "{found} for {expected}");
        }

        #[test]
        fn the_hull_holds_its_points_and_its_gap_is_a_distance(
            speed in 1.0..90.0f64, dt in 0.01..5.0f64, x in -50.0..400.0f64, y in -200.0..200.0f64,
        ) {
            let set = ReachableSet::new(&JET, speed, dt);
            for &v in set.vertices() {
                prop_assert!(set.from_nearest(v).norm() < 1e-9);
            }
            let point = Vector2::new(x, y);
            let gap = set.from_nearest(point);
            // The nearest point is in the set, and no vertex is nearer.
            prop_assert!(set.from_nearest(point - gap).norm() < 1e-9);
            for v in set.vertices() {
                prop_assert!(gap.norm() <= (point - v).norm() + 1e-9);
            }
        }
    }

    /// A set is known by how far it reaches in every direction: a hull as far as the nine ends that it is of.
    #[test]
    fn the_hull_reaches_as_far_as_the_nine_motions_in_every_direction() {
        for (speed, dt) in [
            (20.0, 2.0),
            (1.0, 1.0),
            (6.0, 4.0),
            (94.0, 1.0),
            (120.0, 2.0),
            (40.0, 9.0),
            (3.0, 0.4),
            // Longer than a quarter of a turn takes.
            (2.0, 9.0),
        ] {
            let fastest = f64::min(speed + 3.0 * dt, 95.0);
            let turn = [0.35, 2.5 / speed, fastest / 15.0, std::f64::consts::PI / (2.0 * dt)];
            let turn = turn.into_iter().fold(f64::INFINITY, f64::min);
            let mut ends = Vec::new();
            for a in [-4.5, 0.0, 3.0] {
                ends.extend(
                    [-turn, 0.0, turn].map(|rate| integrate(speed, a, rate, dt, speed.max(95.0))),
                );
            }
            let set = ReachableSet::new(&JET, speed, dt);
            let vertices = set.vertices();
            let reach = |points: &[Vector2<f64>], d: Vector2<f64>| {
                points.iter().map(|p| p.dot(&d)).fold(f64::NEG_INFINITY, f64::max)
            };
            for k in 0..720 {
                let (sin, cos) = libm::sincos(f64::from(k) * 0.5_f64.to_radians());
                let (found, expected) =
                    (reach(vertices, Vector2::new(cos, sin)), reach(&ends, Vector2::new(cos, sin)));
                assert!(
                    (found - expected).abs() < 1e-4,
                    "{speed} {dt} {k}: {found} for {expected}"
                );
            }
            // Counter-clockwise, with no vertex on the line between its neighbours.
            let at = |k: usize| vertices[k % vertices.len()];
            for k in 0..vertices.len() {
                let (one, two) = (at(k + 1) - at(k), at(k + 2) - at(k + 1));
                assert!(one.x * two.y - one.y * two.x > 0.0, "{speed} {dt}: {vertices:?}");
            }
            // From every place outside, the gap is the way to the nearest place of the border.
            for k in 0..60 {
                let (sin, cos) = libm::sincos(f64::from(k) * 6.0_f64.to_radians());
                let point = at(0) * 0.5 + Vector2::new(cos, sin) * (300.0 + 20.0 * speed * dt);
                let border = (0..vertices.len()).flat_map(|v| {
                    (0..=1000).map(move |s| at(v).lerp(&at(v + 1), f64::from(s) * 1e-3))
                });
                let nearest = border.map(|b| (point - b).norm()).fold(f64::INFINITY, f64::min);
                let gap = set.from_nearest(point).norm();
                assert!(
                    gap <= nearest + 1e-9 && gap > nearest - 0.05,
                    "{speed} {dt} {k}: {gap} {nearest}"
                );
            }
        }
    }

    #[test]
    fn what_hardly_moves_reaches_a_disc() {
        // From standing ½ a t², at most what the class does in the time.
        for (speed, dt, radius) in
            [(0.0, 2.0, 6.0), (0.5, 2.0, 7.0), (0.99, 0.0, 0.0), (0.0, 100.0, 9_500.0)]
        {
            let set = ReachableSet::new(&JET, speed, dt);
            assert_eq!(set, ReachableSet::Disc { radius_m: radius }, "{speed} {dt}");
            assert!(set.vertices().is_empty());
            let gap = set.from_nearest(Vector2::new(-0.6, 0.8) * (radius + 5.0));
            assert!((gap - Vector2::new(-3.0, 4.0)).norm() < 1e-9, "{gap}");
            assert_eq!(set.from_nearest(Vector2::new(radius, 0.0)), Vector2::zeros());
        }
        assert!(matches!(ReachableSet::new(&JET, 1.0, 1.0), ReachableSet::Hull { .. }));
    }

    #[test]
    fn hard_cases_of_the_reachable_set() {
        for (name, speed, dt) in [
            ("no time", 40.0, 0.0),
            ("a nanosecond", 40.0, 1e-9),
            ("an hour", 40.0, 3600.0),
            ("faster than the class", 200.0, 1.0),
            ("standing", 0.0, 1.0),
            ("just moving", 1.0, 1.0),
        ] {
            let set = ReachableSet::new(&JET, speed, dt);
            let gap = set.from_nearest(Vector2::new(1e4, -1e4));
            assert!(gap.iter().all(|g| g.is_finite()), "{name}: {gap}");
            assert!(set.vertices().iter().all(|v| v.iter().all(|c| c.is_finite())), "{name}");
        }
        let target = Departure {
            position_m: Point2::origin(),
            velocity_mps: Vector2::new(20.0, 0.0),
            covariance: Matrix4::identity(),
        };
        let far = Point2::new(1e3, 0.0);
        let r = Matrix2::identity();
        assert!(reach(&JET, &target, -1.0, far, r).is_none(), "negative time");
        assert!(reach(&JET, &target, f64::NAN, far, r).is_none(), "NaN time");
        assert!(reach(&JET, &target, 1.0, Point2::new(f64::NAN, 0.0), r).is_none(), "NaN plot");
        assert!(reach(&JET, &target, 1.0, far, Matrix2::repeat(f64::NAN)).is_none(), "NaN noise");
        let blind = Departure { covariance: Matrix4::zeros(), ..target };
        assert!(reach(&JET, &blind, 1.0, far, Matrix2::zeros()).is_none(), "no variance at all");
    }

    /// Out of reach ahead, the variance is that of where it would be without the manoeuvre: place and speed err together.
    #[test]
    fn what_is_out_of_reach_is_measured_by_the_place_as_it_was_foreseen() {
        for (pv, dt_s) in [(0.0, 1.0), (1.5, 1.0), (1.5, 3.0), (-0.8, 2.0)] {
            let mut covariance = Matrix4::identity() * 4.0;
            for axis in 0..2 {
                (covariance[(axis, axis + 2)], covariance[(axis + 2, axis)]) = (pv, pv);
            }
            let target = Departure {
                position_m: Point2::origin(),
                velocity_mps: Vector2::new(30.0, 0.0),
                covariance,
            };
            let farthest = 30.0 * dt_s + 0.5 * JET.acceleration_ms2 * dt_s * dt_s;
            let plot = Point2::new(farthest + 12.0, 0.0);
            let found = reach(&JET, &target, dt_s, plot, Matrix2::identity()).expect("sound").m;
            let variance = 4.0 + 2.0 * dt_s * pv + dt_s * dt_s * 4.0 + 1.0;
            assert!((found - 144.0 / variance).abs() < 1e-6 * found, "{pv} {dt_s}: {found}");
        }
    }

    #[test]
    fn the_series_meets_the_closed_form() {
        for sign in [-1.0, 1.0] {
            let below = arc_piece(80.0, 3.0, sign * (0.5 - 1e-13), 3.0);
            let above = arc_piece(80.0, 3.0, sign * 0.5, 3.0);
            assert!((below[0] - above[0]).abs() < 1e-10 && (below[1] - above[1]).abs() < 1e-10);
        }
    }
}
