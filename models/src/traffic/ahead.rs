//! *What if*: the airport as it is seen, flown ahead twice, as it is and with one change; the difference is the answer.
//!
//! It begins from [`perceive`], so it knows what a controller knows and no more: whom no track shows is not in it, and the
//! answer says so. It clears by the plan, without the waits of frequencies and people. Nothing of the run depends on it.

mod perceive;

pub use crate::traffic::core::{Day, Direction, Flight, OnGround, Seen, class_of};
pub use perceive::{Known, perceive, stand_of};

use crate::traffic::core::{Core, Phase};
use crate::traffic::network::Network;
use crate::traffic::pieces::Pieces;
use std::sync::Arc;

/// What is done otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// A flight stays where it is for so long, s: at its stand before the push-back, or where it taxies.
    Hold {
        /// Flight, by index.
        flight: u32,
        /// For so long, s.
        for_s: f64,
    },
    /// A flight goes to or comes to another runway end.
    Runway {
        /// Flight, by index.
        flight: u32,
        /// Runway and end, by index.
        runway: (usize, usize),
    },
    /// An arrival gets another stand.
    Stand {
        /// Flight, by index.
        flight: u32,
        /// Stand, by index.
        stand: usize,
    },
}

/// Time that is looked ahead, s.
pub const AHEAD_S: f64 = 900.0;
/// A flight whose end moves by less is not told, s.
const STEADY_S: f64 = 5.0;

/// What is compared: key, words, unit. Who is not away, or not on his stand, when the time is over counts up to then.
pub const MEASURES: [(&str, &str, &str); 8] = [
    ("take_offs", "take-offs", ""),
    ("landings", "landings", ""),
    ("in_block", "arrivals on their stands", ""),
    ("to_take_off_s", "until take-off, all departures", "s"),
    ("to_stand_s", "until the stand, all arrivals", "s"),
    ("stops", "stops of 5 s or more", ""),
    ("stopped_s", "time of these stops", "s"),
    ("fuel_kg", "fuel on the ground", "kg"),
];

/// One flight ahead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ahead {
    /// The measures, in the order of [`MEASURES`].
    pub measures: [f64; 8],
    /// By flight: take-off of a departure, in-block of an arrival, s of the run; `None`: not until the end, or not there.
    pub ends_s: Vec<Option<f64>>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// As it is,
    pub without: Ahead,
    /// and with the change.
    pub with: Ahead,
    /// Flights that are seen and fit into no plan of one of the two, by index: they are in neither's measures.
    pub left_out: Vec<u32>,
    /// Flights that should be under way and that no track shows, by index.
    pub unseen: Vec<u32>,
}

impl Answer {
    /// Flights whose end differs: index, without, with, s of the run.
    pub fn moved(&self) -> impl Iterator<Item = (usize, Option<f64>, Option<f64>)> + '_ {
        let both = self.without.ends_s.iter().zip(&self.with.ends_s).enumerate();
        both.filter(|(_, (a, b))| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() >= STEADY_S,
            (a, b) => a.is_some() != b.is_some(),
        })
        .map(|(at, (a, b))| (at, *a, *b))
    }
}

/// What an airport is flown ahead on.
#[derive(Clone, Debug)]
pub struct Airport {
    /// Its ground network,
    pub network: Arc<Network>,
    /// in pieces for the classes of the flights.
    pub pieces: Arc<Pieces>,
    /// Its flights as planned.
    pub flights: Arc<Vec<Flight>>,
}

impl Airport {
    /// The airport of some flights. Cutting its network into pieces takes up to a second.
    #[must_use]
    pub fn new(network: Arc<Network>, flights: Arc<Vec<Flight>>) -> Self {
        let pieces = Arc::new(Pieces::of(&network, &Core::classes(&flights)));
        Self { network, pieces, flights }
    }
}

/// One airport at a frame, as it is seen.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Frame of the run.
    pub frame: i64,
    /// Length of a frame, s.
    pub step_s: f64,
    /// Seed of the draws of the flight ahead.
    pub seed: u64,
    /// The weather, which is taken to stay.
    pub day: Day,
    /// Where everybody is, by flight.
    pub seen: Vec<Seen>,
    /// Who should be there and is not seen, by flight.
    pub unseen: Vec<u32>,
}

impl Moment {
    /// Time of it, s of the run.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.frame as f64 * self.step_s
    }

    /// Whether a change can be made now.
    ///
    /// # Errors
    /// Why it cannot, in words that follow the flight's name.
    pub fn can(&self, network: &Network, flights: &[Flight], change: Change) -> Result<(), String> {
        change.apply(network, &mut flights.to_vec(), &mut self.seen.clone(), self.now_s())
    }

    /// Flies ahead without and with a change.
    ///
    /// # Errors
    /// As [`Self::can`].
    pub fn what_if(&self, airport: &Airport, change: Change) -> Result<Answer, String> {
        let (mut flights, mut seen) = (airport.flights.as_ref().clone(), self.seen.clone());
        change.apply(&airport.network, &mut flights, &mut seen, self.now_s())?;
        let (mut before, mut left_out) = self.core(airport, &airport.flights, &self.seen);
        let (mut after, others) = self.core(airport, &Arc::new(flights), &seen);
        left_out.extend(others);
        left_out.sort_unstable();
        left_out.dedup();
        let mut in_both = vec![true; airport.flights.len()];
        left_out.iter().for_each(|m| in_both[*m] = false);
        Ok(Answer {
            without: self.flown(&mut before, &airport.flights, &in_both),
            with: self.flown(&mut after, &airport.flights, &in_both),
            left_out: left_out.into_iter().map(|m| m as u32).collect(),
            unseen: self.unseen.clone(),
        })
    }

    fn core(
        &self,
        airport: &Airport,
        flights: &Arc<Vec<Flight>>,
        seen: &[Seen],
    ) -> (Core, Vec<usize>) {
        let parts = (Arc::clone(&airport.network), Arc::clone(&airport.pieces));
        let known = (self.seed, self.step_s, self.day);
        Core::perceived(parts, Arc::clone(flights), known, self.frame, seen)
    }

    /// `flights`: as they are wanted, whatever is changed: who is held is late by that.
    fn flown(&self, core: &mut Core, flights: &[Flight], counts: &[bool]) -> Ahead {
        let frames = (AHEAD_S / self.step_s).ceil() as i64;
        (1..=frames).for_each(|k| core.step(self.frame + k));
        let (now_s, end_s) = (self.now_s(), self.now_s() + AHEAD_S);
        let mut ahead = Ahead { ends_s: vec![None; counts.len()], ..Ahead::default() };
        for (m, f) in flights.iter().enumerate().filter(|(m, _)| counts[*m]) {
            let measures = core.measures(m);
            let there = core.phase(m) != Phase::Absent && self.seen[m] != Seen::Gone;
            let within = |t: &f64| *t > now_s && *t <= end_s;
            let end = match f.direction {
                Direction::Departure => measures.atot_s,
                Direction::Arrival => measures.aibt_s,
                Direction::Vehicle => None,
            };
            let (end, landed) = (end.filter(within), measures.aldt_s.filter(within));
            let over = core.phase(m) == Phase::Docked && end.is_none();
            ahead.ends_s[m] = end;
            let until_s = end.unwrap_or(end_s) - f.time_s.max(now_s);
            let until_s = if there && !over { until_s.max(0.0) } else { 0.0 };
            let one = f64::from(u8::from(end.is_some()));
            let m = &mut ahead.measures;
            match f.direction {
                Direction::Departure => {
                    m[0] += one;
                    m[3] += until_s;
                }
                Direction::Arrival => {
                    m[2] += one;
                    m[4] += until_s;
                }
                Direction::Vehicle => {}
            }
            m[1] += f64::from(u8::from(landed.is_some()));
            m[5] += f64::from(measures.stops);
            m[6] += measures.stopped_s;
            m[7] += measures.fuel_kg;
        }
        ahead
    }
}

impl Change {
    /// Whom it is about, by index.
    #[must_use]
    pub fn flight(self) -> u32 {
        match self {
            Self::Hold { flight, .. }
            | Self::Runway { flight, .. }
            | Self::Stand { flight, .. } => flight,
        }
    }

    fn apply(
        self,
        network: &Network,
        flights: &mut [Flight],
        seen: &mut [Seen],
        now_s: f64,
    ) -> Result<(), String> {
        let m = self.flight() as usize;
        let (Some(f), Some(seen)) = (flights.get_mut(m), seen.get_mut(m)) else {
            return Err("is not a flight of this run".into());
        };
        let departs = f.direction == Direction::Departure;
        if *seen == Seen::Gone {
            return Err("is gone, or is seen by no sensor".into());
        }
        match self {
            Self::Hold { for_s, .. } if !(0.0..=AHEAD_S).contains(&for_s) => {
                Err(format!("can be held for 0 to {AHEAD_S:.0} s, not for {for_s}"))
            }
            Self::Hold { for_s, .. } => match seen {
                Seen::OnStand(_) | Seen::Planned if departs => {
                    f.time_s = f.time_s.max(now_s) + for_s;
                    Ok(())
                }
                Seen::Taxiing(at) => {
                    at.starts_in_s = at.starts_in_s.max(for_s);
                    Ok(())
                }
                _ => Err("is not where it could be held: at its stand, or taxiing".into()),
            },
            Self::Runway { runway: (r, end), .. } => {
                if network.runways.get(r).is_none() || end > 1 {
                    return Err("has no such runway to go to".into());
                }
                match seen {
                    Seen::Planned => {}
                    Seen::OnStand(_) | Seen::Taxiing(_) if departs => {}
                    _ => return Err("cannot change its runway any more".into()),
                }
                if let Seen::Taxiing(at) = seen {
                    at.cleared_way_m.clear();
                }
                f.runway = (r, end);
                Ok(())
            }
            Self::Stand { stand, .. } => {
                let Some(s) = network.stands.get(stand) else {
                    return Err("has no such stand to go to".into());
                };
                let code = class_of(f.size).saturating_sub(1);
                if departs {
                    return Err("departs: only an arrival gets another stand".into());
                }
                if s.node.is_none() || s.code < code {
                    return Err(format!("cannot use stand {}", s.name));
                }
                match seen {
                    Seen::Taxiing(at) | Seen::OnRunway(at) => at.stand = Some(stand),
                    Seen::OnFinal { stand: given, .. } => *given = stand,
                    Seen::OnStand(_) => return Err("is on its stand already".into()),
                    _ => {}
                }
                f.stand = stand;
                Ok(())
            }
        }
    }
}
