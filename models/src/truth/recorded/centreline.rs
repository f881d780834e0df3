//! Runs follow the centreline of the runway.
//!
//! Positions of one flight share errors that no smoothing finds: a bias of the receiver, the place of
//! the antenna, a coarse grid. Pilots, on the other hand, keep to the centreline of a runway. Both
//! together, as the best linear estimate of two sources with normal errors, draw the positions of a
//! run across towards the centreline; along the runway nothing changes.

use super::phases::Roll;
use super::reject::{Clean, on_track};
use super::{Rule, Tally};
use crate::airport::Runway;
use crate::frames::{Point2, Vector2};

/// Common error of the positions of a flight, m (assumed).
const BIAS_M: f64 = 5.0;
/// How well pilots keep to the centreline, m (assumed).
const PILOT_M: f64 = 2.0;
/// Beyond the ends of the runway the pull fades over this distance, m.
const FADE_M: f64 = 1500.0;

/// Moves positions and track; returns the largest distance of a position, m.
pub(super) fn centred(
    clean: &mut Clean,
    rolls: &[Roll],
    runways: &[Runway],
    tally: &mut Tally,
) -> f64 {
    let mut largest_m = 0.0_f64;
    for roll in rolls {
        let Some(runway) = runways.iter().find(|runway| is_on(clean, roll, runway)) else {
            continue;
        };
        let before = clean.clone();
        let shift = |t: f64, p: Point2<f64>| shift(&before, runway, t, p);
        for fix in &mut clean.fixes {
            if fix.t >= roll.from as f64 && fix.t <= roll.to as f64 {
                let by = shift(fix.t, fix.p);
                fix.p += by;
                largest_m = largest_m.max(by.norm());
                if by.norm() >= 1.0 {
                    tally.add(Rule::Centreline, fix.line);
                }
            }
        }
        let to = roll.to.min(before.last_s());
        for (i, p) in before.rough.iter().enumerate().take(to + 1).skip(roll.from) {
            clean.rough[i] = p + shift(i as f64, *p);
        }
    }
    largest_m
}

/// True if most of the fast part of a run lies on the runway.
fn is_on(clean: &Clean, roll: &Roll, runway: &Runway) -> bool {
    let to = roll.to.min(clean.last_s());
    let fast = (roll.from..=to).filter(|i| clean.speed(*i as f64) > 25.0);
    let room_m = 0.5 * runway.width_m + 2.0 * clean.sigma_m;
    let (mut on, mut inside) = (0, 0);
    for i in fast {
        let (along, across, beyond_m) = place(runway, clean.rough[i]);
        if beyond_m <= 0.0 {
            let v = clean.velocity(i as f64);
            inside += 1;
            on += usize::from(across.abs() <= room_m && v.dot(&along).abs() > 0.97 * v.norm());
        }
    }
    inside >= 3 && 4 * on >= 3 * inside
}

/// Direction of the runway, distance left of its centreline, and distance beyond its nearer end.
fn place(runway: &Runway, p: Point2<f64>) -> (Vector2<f64>, f64, f64) {
    let way = runway.ends_m[1] - runway.ends_m[0];
    let length_m = way.norm();
    let along = way / length_m.max(1e-9);
    let from = p - runway.ends_m[0];
    let at_m = from.dot(&along);
    (along, from.dot(&Vector2::new(-along.y, along.x)), (-at_m).max(at_m - length_m))
}

/// How far a position at time `t` is moved.
fn shift(clean: &Clean, runway: &Runway, t: f64, p: Point2<f64>) -> Vector2<f64> {
    let (along, across_m, beyond_m) = place(runway, p);
    let track_m = place(runway, on_track(&clean.rough, t)).1;
    let v = clean.velocity(t);
    let speed = v.norm();
    let angle =
        libm::asin((v.dot(&Vector2::new(-along.y, along.x)) / speed.max(1e-3)).clamp(-1.0, 1.0))
            .abs();
    let bias2 = BIAS_M * BIAS_M + clean.sigma_m * clean.sigma_m;
    // What leaves the runway, or comes onto it, is free: slow, turned or far from the centreline.
    let noise_rad = 1.4 * clean.sigma_m / (4.0 * speed).max(1.0);
    let share = smooth((speed - 12.0) / 15.0)
        * (1.0 - smooth((angle - 0.05 - noise_rad) / 0.07))
        * (1.0 - smooth((track_m.abs() - 9.0 - 2.0 * clean.sigma_m) / 9.0))
        * (1.0 - smooth(beyond_m / FADE_M))
        * (bias2 / (bias2 + PILOT_M * PILOT_M));
    Vector2::new(along.y, -along.x) * (across_m * share)
}

/// 0 below 0, 1 above 1, 3u² − 2u³ between.
fn smooth(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}
