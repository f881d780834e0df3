//! Controllers in the core: models that clear what its movers ask for, on truth.
//!
//! They see what each mover waits for, and nothing a controller at a window would not; a clearance is acted upon after
//! it has been thought of, spoken and read back ([`Actors`]). Space, wake and arrivals are still the core's.

use super::notice::{ClearedBy, Notice, Order};
use super::{Clearance, Core};
use crate::control::actors::message::Seat;
use crate::control::actors::pilot::Habits;
use crate::control::actors::seats::group_of;
use crate::control::actors::{Actors, Given, Wanted};
use crate::control::clearance::ClearanceKind;

impl Core {
    /// The same core with controllers at every seat, before its first step: nobody moves but by their clearances.
    #[must_use]
    pub fn with_controllers(mut self) -> Self {
        self.cleared_by = ClearedBy::Controllers;
        self.actors = Some(Actors::new(Habits::default(), self.seed, self.step_s));
        self
    }

    /// What controllers and pilots said and did; `None` where the plan clears.
    #[must_use]
    pub fn actors(&self) -> Option<&Actors> {
        self.actors.as_ref()
    }

    /// Who gave a clearance: the seat, or `plan`.
    #[must_use]
    pub fn seat_of(&self, clearance: &Clearance) -> String {
        let kind = ClearanceKind::of(clearance.kind).filter(|_| self.cleared_by != ClearedBy::Plan);
        kind.map_or_else(
            || "plan".to_owned(),
            |kind| {
                let named =
                    |w: &str| self.net.runways.iter().position(|r| r.names.iter().any(|n| n == w));
                let runway = clearance.runway.split('/').find_map(named).unwrap_or(0);
                Seat::of(kind, self.group(runway)).name()
            },
        )
    }

    /// Group of a runway: the first of those that cross it.
    fn group(&self, runway: usize) -> u8 {
        group_of(&self.crossing, runway)
    }

    /// What flights wait for now, by flight, each with its runway: that to cross, else its own.
    #[must_use]
    pub fn wanted(&self) -> Vec<(Wanted, usize)> {
        let of = |m: usize| Some(self.concerning(m, self.movers[m].wants?));
        (0..self.movers.len()).filter_map(of).collect()
    }

    /// What flights that wait for nothing could be cleared for by a person, likewise.
    #[must_use]
    pub fn could_be_cleared(&self) -> Vec<(Wanted, usize)> {
        let free = |m: &usize| self.movers[*m].wants.is_none();
        let of = |m: usize| Some(self.concerning(m, self.could(m)?));
        (0..self.movers.len()).filter(free).filter_map(of).collect()
    }

    /// A clearance of a flight with its runway: that to cross, else its own.
    fn concerning(&self, m: usize, kind: ClearanceKind) -> (Wanted, usize) {
        let mover = &self.movers[m];
        let crossed = mover.way.crossings.iter().find(|(i, _)| *i >= mover.next);
        let runway = match (kind, crossed) {
            (ClearanceKind::Cross, Some((_, r))) => *r,
            _ => self.flights[m].runway.0,
        };
        (Wanted { flight: m as u32, kind, group: self.group(runway) }, runway)
    }

    /// Lets the controllers look, once a second.
    pub(super) fn control(&mut self) {
        let Some(mut actors) = self.actors.take() else { return };
        let wanted: Vec<Wanted> = self.wanted().into_iter().map(|(w, _)| w).collect();
        for given in actors.scan(self.time_s, &wanted) {
            let Given { seat, flight, kind, acts_s, by_person } = given;
            self.spoken += 1;
            self.notice(Notice {
                effect_frame: libm::ceil(acts_s / self.step_s) as i64,
                source: seat.name(),
                sequence: self.spoken,
                flight: flight as usize,
                order: Order::told(kind, by_person),
            });
        }
        self.actors = Some(actors);
    }
}
