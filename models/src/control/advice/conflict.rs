//! Conflict ahead: two cleared ways meet, and both are there at one time.
//!
//! Everybody is taken to go on along his cleared way at his present speed, up to the next strip of a runway: that has its own
//! rules. Who follows another is no conflict; who comes later to where they meet is advised to hold.

use super::{Found, Picture, What};
use crate::control::actors::message::Seat;
use crate::control::clearance::ClearanceKind;
use crate::frames::{Azimuth, Point2, center, wrap_pi};

/// Nobody is looked at longer ahead, s.
pub const AHEAD_S: f64 = 120.0;
/// Two who are at one place within this meet, s (assumed: a body's length at taxi speed, and the error of both).
const TOGETHER_S: f64 = 15.0;
/// One place, m (assumed: half of two wing spans of code C and a little).
const PLACE_M: f64 = 25.0;
/// Less than this between two directions is following, rad.
const FOLLOWS_RAD: f64 = 0.8;
/// Step along a way, m.
const STEP_M: f64 = 20.0;
/// Slower ones stand, m/s.
const MOVES_MPS: f64 = 1.0;
/// Who is this far beside his way is not on it, m.
const BESIDE_M: f64 = 50.0;

/// Somebody and where he will be.
struct Runner {
    flight: u32,
    /// Seconds from now, place, direction.
    way: Vec<(f64, Point2<f64>, f64)>,
}

/// Pairs of ways that meet.
pub(super) fn look(now_s: f64, picture: &Picture<'_>) -> Vec<Found> {
    let runners: Vec<Runner> =
        (0..picture.flights.len()).filter_map(|m| runner(m, picture)).collect();
    let mut found = Vec::new();
    for (k, a) in runners.iter().enumerate() {
        for b in &runners[k + 1..] {
            let Some((at_a_s, at_b_s, place_m)) = meeting(a, b) else { continue };
            // Who is there later holds; of two at once, the one later in the list.
            let (later, first, last_s, first_s) = match at_a_s > at_b_s {
                true => (a, b, at_a_s, at_b_s),
                false => (b, a, at_b_s, at_a_s),
            };
            found.push(Found {
                seat: Seat::Ground,
                flight: later.flight,
                other: Some(first.flight),
                until_s: now_s + last_s,
                value: 1.0,
                what: What::ConflictAhead {
                    place_m,
                    meets_s: now_s + last_s,
                    behind_s: last_s - first_s,
                },
            });
        }
    }
    // One at a time for each: the next.
    found.sort_by(|a, b| a.flight.cmp(&b.flight).then(a.until_s.total_cmp(&b.until_s)));
    found.dedup_by_key(|f| f.flight);
    found
}

fn runner(m: usize, picture: &Picture<'_>) -> Option<Runner> {
    let (index, strip) = picture.strip(m)?;
    let track = picture.known.surveillance.of_strip(index)?;
    let (taxis, holds) =
        (strip.kinds.has(ClearanceKind::Taxi), strip.kinds.has(ClearanceKind::Hold));
    if !taxis || holds || track.airborne || track.of_a_runway() || track.doubt.is_some() {
        return None;
    }
    let mps = track.judged_mps;
    if mps < MOVES_MPS {
        return None;
    }
    let at_m = track.target.position_m;
    let line_m = &strip.way_m;
    let away = |k: &usize| (line_m[*k] - at_m).norm();
    let nearest = (0..line_m.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
    if away(&nearest) > BESIDE_M {
        return None;
    }
    let runways = &picture.known.layout.runways;
    let in_strip = |p: Point2<f64>| {
        runways.iter().any(|axis| {
            let (along_m, across_m) = axis.place_m(p);
            across_m.abs() <= axis.hold_m && (0.0..=axis.length_m).contains(&along_m)
        })
    };
    let (mut way, mut gone_m, mut due_m) = (Vec::new(), 0.0, 0.0);
    for w in line_m[nearest..].windows(2) {
        let along = w[1] - w[0];
        if gone_m > AHEAD_S * mps || in_strip(w[0]) {
            break;
        }
        if gone_m >= due_m {
            way.push((gone_m / mps, w[0], Azimuth::of(along).rad()));
            due_m += STEP_M;
        }
        gone_m += along.norm();
    }
    Some(Runner { flight: m as u32, way })
}

/// When each of two is where they meet first, and where; none if they do not.
fn meeting(a: &Runner, b: &Runner) -> Option<(f64, f64, Point2<f64>)> {
    let mut first: Option<(f64, f64, Point2<f64>)> = None;
    for (at_a_s, place_a, along_a) in &a.way {
        if first.is_some_and(|f| *at_a_s > f.0.max(f.1)) {
            break;
        }
        for (at_b_s, place_b, along_b) in &b.way {
            let meets = (at_a_s - at_b_s).abs() <= TOGETHER_S
                && (place_a - place_b).norm() <= PLACE_M
                && wrap_pi(along_a - along_b).abs() > FOLLOWS_RAD;
            let sooner = first.is_none_or(|f| at_a_s.max(*at_b_s) < f.0.max(f.1));
            if meets && sooner {
                first = Some((*at_a_s, *at_b_s, center(place_a, place_b)));
            }
        }
    }
    first
}
