//! Measures of a frame.

use super::{Core, Phase};

/// Who taxies slower than half a metre a second for so long has stopped, s.
const STOPS_S: f64 = 5.0;
/// Fuel flow over idle after a start, and for how long, s (traffic.md 10, assumed there).
const BREAK_AWAY: f64 = 1.5;
const BREAKS_AWAY_S: f64 = 8.0;

impl Core {
    /// Measures of a frame.
    pub(super) fn count(&mut self, m: usize) {
        let (dt, now) = (self.step_s, self.time_s);
        let idle = self.flights[m].idle_kg_per_s;
        let mover = &mut self.movers[m];
        let engines = matches!(
            mover.phase,
            Phase::Starting(_) | Phase::Taxiing | Phase::LinedUp(_) | Phase::Landing
        );
        if !engines {
            return;
        }
        mover.measures.fuel_kg += idle * dt;
        if mover.phase != Phase::Taxiing {
            (mover.still_since_s, mover.still_frames) = (None, 0);
            return;
        }
        // Breaking away takes more than idle for a while.
        if mover.v == 0.0 {
            mover.breaks_away_s = BREAKS_AWAY_S;
        } else if mover.breaks_away_s > 0.0 {
            mover.breaks_away_s -= dt;
            mover.measures.fuel_kg += (BREAK_AWAY - 1.0) * idle * dt;
        }
        if mover.v < 0.5 {
            mover.still_since_s.get_or_insert(now);
            // By frames: of times, five seconds are reached twice or never, by their last bit.
            mover.still_frames += 1;
            let stops = (STOPS_S / dt).round().max(1.0) as u32;
            if mover.still_frames == stops {
                mover.measures.stops += 1;
                mover.measures.stopped_s += STOPS_S;
            } else if mover.still_frames > stops {
                mover.measures.stopped_s += dt;
            }
        } else {
            (mover.still_since_s, mover.still_frames) = (None, 0);
        }
    }
}
