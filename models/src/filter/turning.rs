//! A state carried on with an acceleration that keeps its angle to the course, as that of a machine in a turn does.
//!
//! It turns with `ω = (v × a)/|v|²`: Φ(ω) on (p, v, a) of both axes, and for the covariance its derivatives by v and a too.

use super::gaussian::Gaussian;
use super::lanes::Pair;
use super::motion::Step;

/// An acceleration does not turn faster, rad/s, nor that of a target slower than [`TURNS_FROM_MPS`].
const FASTEST_TURN: f64 = 0.6;
const TURNS_FROM_MPS: f64 = 3.0;

/// A state carried on for `t` seconds with an acceleration that keeps its angle to the course.
pub(super) fn turned(state: &Gaussian, t: f64) -> Gaussian {
    let ([vx, vy], [ax, ay]) = (state.x[1].array(), state.x[2].array());
    let speed2 = vx * vx + vy * vy;
    let turns = speed2 > TURNS_FROM_MPS * TURNS_FROM_MPS && speed2.is_finite();
    let found = if turns { (vx * ay - vy * ax) / speed2 } else { 0.0 };
    let rate = found.clamp(-FASTEST_TURN, FASTEST_TURN);
    let x = rate * t;
    if x.abs() < 1e-9 {
        return state.predicted(&Step::constant_acceleration(0.0, t));
    }
    let (sin, cos) = libm::sincos(x);
    // sin x/ω, (1 − cos x)/ω, (1 − cos x)/ω², (x − sin x)/ω²
    let (s1, c1, c2, s2) = if x.abs() < 1e-3 {
        let (x2, t2) = (x * x, t * t);
        (t * (1.0 - x2 / 6.0), t * x / 2.0, t2 / 2.0 * (1.0 - x2 / 12.0), t2 * x / 6.0)
    } else {
        let r2 = rate * rate;
        (sin / rate, (1.0 - cos) / rate, (1.0 - cos) / r2, (x - sin) / r2)
    };
    // Rows of Φ on (x, vx, ax, y, vy, ay): each has its own axis, and the other one's acceleration.
    let own = [[1.0, t, c2], [0.0, 1.0, s1], [0.0, 0.0, cos]];
    let other = [s2, c1, sin];
    let apply = |v: &[f64; 6]| -> [f64; 6] {
        std::array::from_fn(|row| {
            let (axis, k) = (row / 3, row % 3);
            let sign = if axis == 0 { -1.0 } else { 1.0 };
            (0..3).map(|j| own[k][j] * v[3 * axis + j]).sum::<f64>()
                + sign * other[k] * v[3 * (1 - axis) + 2]
        })
    };
    // Derivatives: of the rate by velocity and acceleration, of what is added by the rate (∫ τᵏ R(ωτ) a to second order).
    let by_state = if found == rate {
        [(ay - 2.0 * rate * vx), -vy, (-ax - 2.0 * rate * vy), vx].map(|d| d / speed2)
    } else {
        [0.0; 4]
    };
    let aside = |angle: f64, k: f64| {
        let (sin, cos) = libm::sincos(angle);
        [-(sin * ax + cos * ay) * k, (cos * ax - sin * ay) * k]
    };
    let by_rate = [aside(x / 2.0, t * t * t / 6.0), aside(2.0 / 3.0 * x, t * t / 2.0), aside(x, t)];
    let along = |v: &[f64; 6]| -> [f64; 6] {
        let turned = apply(v);
        let [of_vx, of_ax, of_vy, of_ay] = by_state;
        let more = of_vx * v[1] + of_ax * v[2] + of_vy * v[4] + of_ay * v[5];
        std::array::from_fn(|i| turned[i] + by_rate[i % 3][i / 3] * more)
    };
    let mean: [f64; 6] = std::array::from_fn(|i| state.x[i % 3].array()[i / 3]);
    let full = state.covariance();
    let mut half = [[0.0; 6]; 6]; // columns of FP, then rows of FPFᵀ
    for (j, column) in half.iter_mut().enumerate() {
        *column = along(&std::array::from_fn(|i| full[(i, j)]));
    }
    let rows: [[f64; 6]; 6] = std::array::from_fn(|i| along(&std::array::from_fn(|j| half[j][i])));
    let mean = apply(&mean);
    let pair = |i: usize, j: usize| Pair::new(rows[i][j], rows[3 + i][3 + j]);
    let mut cross = [0.0; 9];
    for (k, slot) in cross.iter_mut().enumerate() {
        *slot = rows[k / 3][3 + k % 3];
    }
    Gaussian {
        x: [0, 1, 2].map(|k| Pair::new(mean[k], mean[3 + k])),
        p: [pair(0, 0), pair(0, 1), pair(0, 2), pair(1, 1), pair(1, 2), pair(2, 2)],
        cross,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(x: [f64; 6]) -> Gaussian {
        Gaussian { x: [0, 1, 2].map(|k| Pair::new(x[k], x[3 + k])), ..Gaussian::default() }
    }

    fn mean(state: &Gaussian) -> [f64; 6] {
        std::array::from_fn(|i| state.x[i % 3].array()[i / 3])
    }

    /// On a circle it comes round; on a straight way it goes straight on.
    #[test]
    fn a_steady_turn_is_a_circle() {
        let (radius, rate) = (40.0, 0.25);
        let mut now = state([radius, 0.0, -rate * rate * radius, 0.0, rate * radius, 0.0]);
        for k in 1..=40 {
            now = turned(&now, 0.7);
            let (sin, cos) = libm::sincos(0.7 * rate * f64::from(k));
            let [x, _, _, y, _, _] = mean(&now);
            let off = libm::hypot(x - radius * cos, y - radius * sin);
            assert!(off < 1e-9, "{k}: {off}");
        }
        let straight = mean(&turned(&state([0.0, 12.0, 2.0, 0.0, 0.0, 0.0]), 1.0));
        assert_eq!(straight, [13.0, 14.0, 2.0, 0.0, 0.0, 0.0]);
    }

    /// What is not known of each number is carried on as that number itself is.
    #[test]
    fn the_covariance_goes_with_the_derivatives_of_the_way() {
        for x in [[5.0, 9.0, -1.0, -3.0, 2.0, 2.0], [0.0, -4.0, 0.5, 0.0, 6.0, 1.2]] {
            let t = 1.0;
            let step = 1e-5;
            let by: [[f64; 6]; 6] = std::array::from_fn(|j| {
                let at = |sign: f64| {
                    let mut moved = x;
                    moved[j] += sign * step;
                    mean(&turned(&state(moved), t))
                };
                let (more, less) = (at(1.0), at(-1.0));
                std::array::from_fn(|i| (more[i] - less[i]) / (2.0 * step))
            });
            let spread = [0.2, 0.5, 0.3, 0.1, 0.4, 0.6];
            let mut uncertain = state(x);
            for (k, slot) in [0, 3, 5].into_iter().enumerate() {
                uncertain.p[slot] = Pair::new(spread[k], spread[3 + k]);
            }
            let found = turned(&uncertain, t).covariance();
            for i in 0..6 {
                for j in 0..6 {
                    let of: f64 = (0..6).map(|k| by[k][i] * by[k][j] * spread[k]).sum();
                    let scale = (found[(i, i)] * found[(j, j)]).sqrt();
                    let off = (found[(i, j)] - of).abs() / scale;
                    assert!(off < 5e-3, "{i} {j}: {} {of}", found[(i, j)]);
                }
            }
        }
    }

    /// Gentle and hard, to the left and to the right: as integrated, and each the mirror image of the other.
    #[test]
    fn turns_are_what_is_integrated_and_their_mirror_images() {
        for (rate, t) in [
            (1e-12, 1.0),
            (3e-10, 1.0),
            (1e-8, 1.0),
            (1e-6, 2.0),
            (3e-4, 3.0),
            (9e-4, 1.0),
            (2e-3, 1.0),
            (0.03, 1.5),
            (0.59, 2.0),
        ] {
            let (vx, ax) = (12.0, 0.8);
            let start = [7.0, vx, ax, -4.0, 0.0, rate * vx];
            let mut now = state(start);
            for (k, slot) in [0, 3, 5].into_iter().enumerate() {
                now.p[slot] = Pair::new(0.3 + 0.1 * k as f64, 0.5 - 0.1 * k as f64);
            }
            (now.p[1], now.cross) = (Pair::new(0.1, -0.1), [0.05; 9]);
            // Simpson's rule on the acceleration that turns.
            let (mut moved, mut faster, steps) = ([0.0; 2], [0.0; 2], 400);
            for k in 0..=steps {
                let tau = t * f64::from(k) / f64::from(steps);
                let weight = match k {
                    0 => 1.0,
                    k if k == steps => 1.0,
                    k => [2.0, 4.0][k as usize % 2],
                } * t
                    / (3.0 * f64::from(steps));
                let (sin, cos) = libm::sincos(rate * tau);
                let a = [cos * ax - sin * start[5], sin * ax + cos * start[5]];
                for axis in 0..2 {
                    faster[axis] += weight * a[axis];
                    moved[axis] += weight * (t - tau) * a[axis];
                }
            }
            let (sin, cos) = libm::sincos(rate * t);
            let wanted = [
                7.0 + vx * t + moved[0],
                vx + faster[0],
                cos * ax - sin * start[5],
                -4.0 + moved[1],
                faster[1],
                sin * ax + cos * start[5],
            ];
            let found = turned(&now, t);
            for (found, wanted) in mean(&found).iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-9, "{rate}: {found} {wanted}");
            }
            let mirror = |g: &Gaussian| Gaussian {
                x: g.x.map(|x| Pair::new(x.east(), -x.north())),
                p: g.p,
                cross: g.cross.map(|c| -c),
            };
            let image = turned(&mirror(&now), t);
            let (found, image) = (mirror(&found), image);
            let off = (found.covariance() - image.covariance()).amax();
            assert!(off < 1e-9 * found.covariance().amax(), "{rate}: {off}");
            for (a, b) in mean(&found).iter().zip(mean(&image)) {
                assert!((a - b).abs() < 1e-9, "{rate}: {a} {b}");
            }
            // No jump of what is not known where the form changes, nor against a hardly other turn.
            let mut other = now;
            other.x[2] = Pair::new(ax, rate * vx * (1.0 + 1e-6) + 1e-9);
            let off = (turned(&other, t).covariance() - turned(&now, t).covariance()).amax();
            assert!(off < 1e-5 * turned(&now, t).covariance().amax(), "{rate}: {off}");
        }
    }
}
