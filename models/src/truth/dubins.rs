//! The shortest path between two poses with a limited curvature.
//!
//! Source: Dubins, Amer. J. Math. 79 (1957) 497; the four words with a straight middle and the two of
//! three arcs in closed form after Shkel & Lumelsky, Robotics and Autonomous Systems 34 (2001) 179.

use crate::frames::{Point2, Vector2};
use std::f64::consts::TAU;

/// A place and a direction (unit vector).
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) place: Point2<f64>,
    pub(super) ahead: Vector2<f64>,
}

/// Points about every `step_m` from `from` to `to` (both included), turning with `radius_m` at the sharpest.
pub(super) fn connect(from: Pose, to: Pose, radius_m: f64, step_m: f64) -> Vec<Point2<f64>> {
    let across = (to.place - from.place) / radius_m;
    let d = across.norm();
    let theta = libm::atan2(across.y, across.x);
    let angle = |v: Vector2<f64>| libm::atan2(v.y, v.x);
    let (a, b) = (turn(angle(from.ahead) - theta), turn(angle(to.ahead) - theta));
    // Each word: kinds of its three parts (left +1, straight 0, right −1) and their lengths over the radius.
    let best = words(a, b, d)
        .into_iter()
        .flatten()
        .min_by(|p, q| p.1.iter().sum::<f64>().total_cmp(&q.1.iter().sum()));
    let Some((kinds, lengths)) = best else { return vec![from.place, to.place] };
    let mut points = vec![from.place];
    let (mut place, mut heading) = (from.place, angle(from.ahead));
    for (kind, length) in kinds.into_iter().zip(lengths) {
        let count = (length * radius_m / step_m).ceil().max(1.0) as usize;
        let part = length / count as f64;
        for _ in 0..count {
            // The chord of an arc points along its middle direction.
            let middle = heading + 0.5 * kind * part;
            let half = 0.5 * part;
            let chord = if kind == 0.0 { part } else { 2.0 * libm::sin(half) };
            let (sin, cos) = libm::sincos(middle);
            place += Vector2::new(cos, sin) * (chord * radius_m);
            heading += kind * part;
            points.push(place);
        }
    }
    points
}

type Word = ([f64; 3], [f64; 3]);

fn words(a: f64, b: f64, d: f64) -> [Option<Word>; 6] {
    let ((sa, ca), (sb, cb)) = (libm::sincos(a), libm::sincos(b));
    let cab = libm::cos(a - b);
    let root = |square: f64| (square >= 0.0).then(|| square.sqrt());
    let lsl = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb)).map(|p| {
        let middle = libm::atan2(cb - ca, d + sa - sb);
        ([1.0, 0.0, 1.0], [turn(middle - a), p, turn(b - middle)])
    });
    let rsr = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa)).map(|p| {
        let middle = libm::atan2(ca - cb, d - sa + sb);
        ([-1.0, 0.0, -1.0], [turn(a - middle), p, turn(middle - b)])
    });
    let lsr = root(d * d - 2.0 + 2.0 * cab + 2.0 * d * (sa + sb)).map(|p| {
        let middle = libm::atan2(-ca - cb, d + sa + sb) - libm::atan2(-2.0, p);
        ([1.0, 0.0, -1.0], [turn(middle - a), p, turn(middle - b)])
    });
    let rsl = root(d * d - 2.0 + 2.0 * cab - 2.0 * d * (sa + sb)).map(|p| {
        let middle = libm::atan2(ca + cb, d - sa - sb) - libm::atan2(2.0, p);
        ([-1.0, 0.0, 1.0], [turn(a - middle), p, turn(b - middle)])
    });
    let three = |cos: f64| (cos.abs() <= 1.0).then(|| TAU - libm::acos(cos));
    let rlr = three((6.0 - d * d + 2.0 * cab + 2.0 * d * (sa - sb)) / 8.0).map(|p| {
        let t = turn(a - libm::atan2(ca - cb, d - sa + sb) + 0.5 * p);
        ([-1.0, 1.0, -1.0], [t, p, turn(a - b - t + p)])
    });
    let lrl = three((6.0 - d * d + 2.0 * cab + 2.0 * d * (sb - sa)) / 8.0).map(|p| {
        let t = turn(libm::atan2(cb - ca, d + sa - sb) - a + 0.5 * p);
        ([1.0, -1.0, 1.0], [t, p, turn(b - a - t + p)])
    });
    [lsl, rsr, lsr, rsl, rlr, lrl]
}

/// An angle in [0, 2π); what is a rounding error below a full turn is none.
fn turn(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > TAU - 1e-9 { 0.0 } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_poses_is_joined() {
        let radius_m = 12.0;
        for i in 0..8 {
            for j in 0..8 {
                for distance in [0.0, 5.0, 20.0, 47.0, 200.0] {
                    let pose = |place, k: i32| {
                        let (sin, cos) = libm::sincos(f64::from(k) * TAU / 8.0 + 0.1);
                        Pose { place, ahead: Vector2::new(cos, sin) }
                    };
                    let from = pose(Point2::new(3.0, 4.0), i);
                    let to = pose(Point2::new(3.0 + distance, 4.0), j);
                    let points = connect(from, to, radius_m, 1.0);
                    let end = points[points.len() - 1];
                    assert!((end - to.place).norm() < 1e-6, "{i} {j} {distance}: ends at {end}");
                    let last = end - points[points.len().saturating_sub(2)];
                    if last.norm() > 0.1 {
                        assert!(last.normalize().dot(&to.ahead) > 0.99, "{i} {j} {distance}");
                    }
                    for w in points.windows(3) {
                        let (u, v) = (w[1] - w[0], w[2] - w[1]);
                        if u.norm() > 1e-6 && v.norm() > 1e-6 {
                            let bend = (u.x * v.y - u.y * v.x).abs() / (u.norm() * v.norm());
                            assert!(bend <= 1.2 / radius_m, "{i} {j} {distance}: {bend}");
                        }
                    }
                }
            }
        }
    }
}
