//! The departure manager in the core: what happens to departures is told to it, and who is to wait stays on his stand.

use super::{Core, Direction, Phase};
use crate::control::departures::{Departures, Milestones};

impl Core {
    /// The same core with departures that leave their stands by a sequence, before its first step.
    #[must_use]
    pub fn with_departures(mut self, departures: Option<Departures>) -> Self {
        self.departures = departures;
        self
    }

    /// Target times of a flight, where departures leave by a sequence and it has a place in it.
    #[must_use]
    pub fn milestones(&self, flight: usize) -> Option<Milestones> {
        self.departures.as_ref()?.milestones(flight as u32)
    }

    /// Whether a flight that could be pushed waits for its turn in the sequence.
    pub(super) fn held_on_stand(&mut self, m: usize) -> bool {
        let now_s = self.time_s;
        let Some(departures) = &mut self.departures else { return false };
        departures.asks(m as u32, now_s);
        !departures.may_push(m as u32, now_s)
    }

    /// Tells the departure manager what has happened, once a second.
    pub(super) fn sequence(&mut self) {
        let Some(mut departures) = self.departures.take() else { return };
        let flights: Vec<u32> = departures.flights().collect();
        for flight in flights {
            let Some(mover) = self.movers.get(flight as usize) else { continue };
            if self.flights[flight as usize].direction != Direction::Departure {
                continue;
            }
            if let Some(at_s) = mover.measures.aobt_s {
                departures.pushed(flight, at_s);
            }
            let line = mover.threshold as usize;
            let waits = mover.next == line && mover.v < 0.5;
            let lines_up = mover.phase == Phase::Taxiing && (mover.next > line || waits);
            if lines_up || matches!(mover.phase, Phase::LinedUp(_) | Phase::Rolling) {
                departures.at_line(flight, self.time_s);
            }
            if let Some(at_s) = mover.measures.atot_s {
                departures.took_off(flight, at_s);
            }
        }
        departures.scan(self.time_s);
        self.departures = Some(departures);
    }
}
