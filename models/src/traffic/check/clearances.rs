//! Who leaves his stand, takes off or lands, and whether he was cleared for it.

use super::{Breaches, GROUND_M, Given, Row, STILL_MPS, Seen, Who};
use crate::control::clearance::ClearanceKind;
use crate::control::layout::Layout;
use crate::traffic::core::Direction;

/// What somebody did that needs a clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Act {
    Leaves,
    TakesOff,
    Lands,
}

#[derive(Clone, Copy, Debug)]
struct Event {
    who: usize,
    act: Act,
    time_s: f64,
    runway: Option<usize>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Past {
    /// In the air when it was last clear; stands since it was first seen.
    flying: Option<bool>,
    stands: Option<bool>,
}

/// Events of all movers.
#[derive(Clone, Debug)]
pub(super) struct Events {
    past: Vec<Past>,
    found: Vec<Event>,
}

/// A clearance may end so long before what it is for is seen (lift-off at 1.5 m of height), or begin so long after, s.
const ROOM_S: f64 = 3.0;

impl Events {
    pub(super) fn new(movers: usize) -> Self {
        Self { past: vec![Past::default(); movers], found: Vec::new() }
    }

    pub(super) fn look(&mut self, layout: &Layout, who: &[Who], time_s: f64, seen: &[Seen]) {
        for s in seen.iter().filter(|s| who[s.who].direction.is_some()) {
            let past = &mut self.past[s.who];
            let high = s.position_m.z > GROUND_M;
            let speed = s.velocity_mps.norm();
            let mut add = |act| {
                let across = |r: usize| layout.runways[r].place_m(s.position_m.xy()).1.abs();
                let runways = 0..layout.runways.len();
                let runway = runways.min_by(|a, b| across(*a).total_cmp(&across(*b)));
                self.found.push(Event { who: s.who, act, time_s, runway });
            };
            match past.flying {
                Some(false) if high => add(Act::TakesOff),
                Some(true) if !high => add(Act::Lands),
                _ => {}
            }
            past.flying = Some(high);
            let departs = who[s.who].direction == Some(Direction::Departure) && !high;
            match past.stands {
                None if departs => past.stands = Some(speed < STILL_MPS),
                Some(true) if speed > 0.5 => {
                    add(Act::Leaves);
                    past.stands = Some(false);
                }
                _ => {}
            }
        }
    }

    pub(super) fn row(self, layout: &Layout, who: &[Who], given: &[Given]) -> Row {
        use ClearanceKind::{Land, Push, TakeOff, Taxi};
        let mut missing = Breaches { of: self.found.len() as u64, ..Breaches::default() };
        for e in &self.found {
            let (kinds, does): (&[ClearanceKind], _) = match e.act {
                Act::Leaves => (&[Push, Taxi], "leaves its stand"),
                Act::TakesOff => (&[TakeOff], "takes off"),
                Act::Lands => (&[Land], "lands"),
            };
            let cleared = given.iter().any(|g| {
                let there =
                    g.runway.is_empty() || layout.runway(&g.runway).map(|r| r.0) == e.runway;
                g.who == e.who
                    && kinds.contains(&g.kind)
                    && (e.act == Act::Leaves || there)
                    && g.from_s <= e.time_s + 1.0
                    && g.until_s >= e.time_s - ROOM_S
            });
            if !cleared {
                let name = &who[e.who].callsign;
                missing.add(|| format!("{name} {does} at {:.1} s without clearance", e.time_s));
            }
        }
        missing.row("clearances")
    }
}
