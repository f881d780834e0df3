//! What a core tells of its flights and runways: phases, measures, why they wait, where they may go.

use super::{Clearance, Core, Direction, Flight, Measures, Mover, Phase, Remark, Waiting};
use crate::traffic::network::Network;

impl Core {
    /// Phase of a flight.
    #[must_use]
    pub fn phase(&self, flight: usize) -> Phase {
        self.movers[flight].phase
    }

    /// Measures of a flight.
    #[must_use]
    pub fn measures(&self, flight: usize) -> &Measures {
        &self.movers[flight].measures
    }

    /// Stand of a flight: given, or taken in its place.
    #[must_use]
    pub fn stand(&self, flight: usize) -> usize {
        self.movers[flight].stand
    }

    /// How many flights have taken off or are in block.
    #[must_use]
    pub fn measures_of_served(&self) -> usize {
        let done = |m: &&Mover| match self.flights[m.flight].direction {
            Direction::Arrival => m.measures.aibt_s.is_some(),
            Direction::Departure => m.measures.atot_s.is_some(),
            Direction::Vehicle => false,
        };
        self.movers.iter().filter(done).count()
    }

    /// Whether every flight has taken off or is in block.
    #[must_use]
    pub fn all_served(&self) -> bool {
        let vehicles = (0..self.flights.len()).filter(|f| self.is_vehicle(*f)).count();
        self.measures_of_served() + vehicles == self.flights.len()
    }

    /// Clearances so far, in the order of their begin.
    #[must_use]
    pub fn clearances(&self) -> &[Clearance] {
        &self.clearances
    }

    /// What was remarked so far.
    #[must_use]
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    /// How many rings of movers that wait for each other were found under a policy that rules them out: 0.
    #[must_use]
    pub fn unexpected_deadlocks(&self) -> u64 {
        self.unexpected
    }

    /// The network that its movers use.
    #[must_use]
    pub fn network(&self) -> &Network {
        &self.net
    }

    /// Flights of the core.
    #[must_use]
    pub fn flights(&self) -> &[Flight] {
        &self.flights
    }

    /// Why a flight waits: for whom, at which piece, and how long by the plan, s (`None`: not planned).
    #[must_use]
    pub fn waiting(&self, flight: usize) -> Option<Waiting<'_>> {
        let m = &self.movers[flight];
        // Who stands before what he sees waits for that, also where the pieces ahead are his.
        let seen =
            || (m.phase == Phase::Taxiing && m.v == 0.0).then(|| self.sees(flight)).flatten();
        // It may wait for a piece as well, which nobody has: he is the one in its way.
        let seen = m.waits_for.is_none().then(seen).flatten();
        let since_s = m.waits_since_s.or(seen.and(m.still_since_s))?;
        let step = m.next.min(m.way.pieces.len().saturating_sub(1));
        let piece = m.way.pieces.get(step).map(|z| self.pieces.list[*z as usize].edge);
        let edge = piece.map(|e| &self.net.edges[e]);
        let place = edge.map_or(String::new(), |e| {
            let [a, b] = e.nodes.map(|n| self.net.nodes[n].name.as_str());
            if e.name.is_empty() { format!("{a}-{b}") } else { format!("{} ({a}-{b})", e.name) }
        });
        let parked = m.phase == Phase::Parked;
        let take_s = if parked { m.timing.push_take_s } else { self.order_of(flight, step) };
        Some(Waiting {
            behind: seen.map(|s| s.1).or(m.waits_for).map(|o| self.name_of(o)),
            place,
            since_s,
            planned_s: m.timing.planned.then_some(take_s - self.time_s).filter(|s| s.is_finite()),
        })
    }

    /// Place up to which a flight may drive, m from it, and the line there: its authority and, behind it, its
    /// planned way to the end, east and north, every 20 m. Empty off the ground and on stands.
    #[must_use]
    pub fn ways_ahead(&self, flight: usize) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
        let m = &self.movers[flight];
        if !matches!(m.phase, Phase::Starting(_) | Phase::Taxiing | Phase::Landing) {
            return (Vec::new(), Vec::new());
        }
        let held = self.authority(flight).max(m.s);
        let line = |from: f64, to: f64| -> Vec<[f64; 2]> {
            let count = (((to - from) / 20.0).ceil() as usize).min(2_000);
            let at = |i: usize| (from + 20.0 * i as f64).min(to);
            (0..=count).map(|i| m.way.path.at(at(i)).at_m).map(|p| [p.x, p.y]).collect()
        };
        (line(m.s, held), line(held, m.way.stop_m.max(held)))
    }

    /// Who has a runway (rolls, lands, is lined up), and how many wait on the ground to enter it.
    #[must_use]
    pub fn runway_state(&self, runway: usize) -> (Option<&str>, usize) {
        let owner = self.owner.get(runway).copied().flatten();
        let queue = self.movers.iter().filter(|m| {
            let f = &self.flights[m.flight];
            let departs = f.direction == Direction::Departure && f.runway.0 == runway;
            departs && m.phase == Phase::Taxiing && m.v == 0.0
        });
        (owner.map(|o| self.flights[o].callsign.as_str()), queue.count())
    }

    /// Names of the pieces that a flight holds: edge and number along it.
    #[must_use]
    pub fn held_pieces(&self, flight: usize) -> Vec<u32> {
        let mine = |(z, h): (usize, &Vec<u32>)| h.contains(&(flight as u32)).then_some(z as u32);
        self.holders.iter().enumerate().filter_map(mine).collect()
    }

    /// Why a flight waits: "for KLM123", or `None` while it does not.
    #[must_use]
    pub fn waits_for(&self, flight: usize) -> Option<&str> {
        let m = &self.movers[flight];
        m.waits_since_s?;
        m.waits_for.map(|o| self.name_of(o))
    }
}
