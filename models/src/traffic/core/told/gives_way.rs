//! Who crosses a runway and sees somebody come along it, fast: he crosses before him where he is off his way in time, else stops
//! short of it; who cannot stop short of it any more, or is in it, goes on.

use super::{AFTER_S, Body, HARD_MPS2, ROOM_M, STEP_M, body};
use crate::traffic::core::{Core, Phase};
use crate::traffic::outline::Size;

/// Somebody faster than this on a runway, or on final, does not stop for who crosses, m/s (assumed).
const FAST_MPS: f64 = 15.0;
/// So far along his way a pilot looks for where he would be off the runway again, m, and so long he looks at who comes, s (assumed).
const ACROSS_M: f64 = 270.0;
const COMES_S: f64 = 45.0;

/// Who has to brake hard to stop short of that way goes on if he is off it so long before, s (assumed).
const COMMITTED_S: f64 = 1.5;
/// He means to stop so much farther from that way, and what he needs more he has of the room to it, m (assumed).
const SHORT_M: f64 = 4.0;

impl Core {
    /// Room before the way of one who comes, m, for a taxiing flight that crosses it: infinite where it goes on. `None` where that one is
    /// not fast or his way is not met, and for who comes onto it without leaving it.
    pub(super) fn gives_way_m(&self, m: usize, o: usize) -> Option<f64> {
        let (mover, other) = (&self.movers[m], &self.movers[o]);
        let comes = matches!(other.phase, Phase::Final | Phase::Landing | Phase::Rolling);
        let theirs = self.flights[o].runway.0;
        let crosses =
            |(i, r): &(usize, usize)| *i >= mover.first_held && self.crossing[theirs].contains(r);
        if !comes
            || other.v < FAST_MPS
            || mover.phase != Phase::Taxiing
            || !mover.way.crossings.iter().any(crosses)
        {
            return None;
        }
        let here = self.state(m)?;
        // All between nose, tail and wing tips, so that nothing is between two of his places.
        let swept = Size { aircraft: false, ..self.flights[o].size };
        let bodies = self.will_cover(o, swept, COMES_S);
        let meets = |own: &Body, until_s: f64| {
            let mut in_time = bodies.iter().filter(|b| b.after_s <= until_s);
            in_time.any(|b| own.within_m(b, ROOM_M) < ROOM_M)
        };
        let now = body(m, self.flights[m].size, here.position_m.xy(), here.heading_rad, 0.0);
        if bodies.iter().any(|b| now.within_m(b, ROOM_M) < ROOM_M - SHORT_M) {
            return Some(f64::INFINITY);
        }
        let alone = mover.way.alone_to(mover.s, mover.v, &mover.driving, mover.s + ACROSS_M);
        let stop_m = |mps2: f64| mover.v * mover.v / (2.0 * mps2);
        let (mut free_m, mut in_time) = (None, [true; 2]);
        for (k, then) in self.drawn_ahead(m, (ACROSS_M / STEP_M) as usize).enumerate() {
            let ahead_m = STEP_M * (k + 1) as f64;
            match (free_m, meets(&then, COMES_S)) {
                (None, false) => continue,
                (_, true) => {
                    free_m.get_or_insert(ahead_m - STEP_M);
                    let at_s = alone.time_s(mover.s + ahead_m);
                    in_time[0] &= !meets(&then, at_s + AFTER_S);
                    in_time[1] &= !meets(&then, at_s + COMMITTED_S);
                }
                (Some(free_m), false) => {
                    // Near the edge nobody thinks better of it for a second.
                    let goes = match free_m {
                        m if m + SHORT_M < stop_m(HARD_MPS2) => true,
                        m if m < stop_m(0.5 * HARD_MPS2) => in_time[1],
                        _ => in_time[0],
                    };
                    let stops_m = (free_m - SHORT_M).max(0.0);
                    return Some(if goes { f64::INFINITY } else { stops_m });
                }
            }
        }
        None
    }
}
