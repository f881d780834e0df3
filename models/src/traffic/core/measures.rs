//! Measures of a frame.

use super::{Core, Phase};

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
            return;
        }
        if mover.v < 0.5 {
            let since = *mover.still_since_s.get_or_insert(now);
            if now - since >= 5.0 {
                if now - since - dt < 5.0 {
                    mover.measures.stops += 1;
                    mover.measures.stopped_s += 5.0;
                } else {
                    mover.measures.stopped_s += dt;
                }
            }
        } else {
            mover.still_since_s = None;
        }
    }
}
