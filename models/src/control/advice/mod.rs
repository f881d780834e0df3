//! Advice for controllers: what is better done, with its value and what happens otherwise; never an action.
//!
//! An advice is for a seat. A person there accepts or refuses it; where accepting it is saying a clearance, that is said. The
//! model at a seat decides, with a probability, only upon what it can follow: the [hold at the stand](stand_hold), which
//! knows what is asked and cleared. The others look at the airport as it is seen ([`Picture`]): ways that
//! [meet](conflict), [gaps](gap) between landings, [stands](stand) that are wanted twice. They are made from what is seen in
//! a scan and remember nothing but what was told, so the same tracks give the same advice in every layout.

pub mod conflict;
pub mod gap;
pub mod stand;
pub mod stand_hold;

pub use stand_hold::{Departing, Habits, expected_taxi_out_s};

use super::actors::message::Seat;
use super::actors::sight::Waiting;
use super::actors::{Given, Wanted};
use super::clearance::{ClearanceKind, Strip};
use crate::frames::Point2;
use crate::plot::Callsign;
use crate::traffic::ahead::{Direction, Flight, Known, stand_of};
use crate::traffic::network::Network;
use crate::words::words;
use stand_hold::StandHold;
use std::collections::BTreeMap;

/// What somebody thought of an advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Nobody has decided.
    Open,
    /// It is followed.
    Accepted,
    /// It is not.
    Refused,
}

words! {
    "decision upon an advice": Decision {
        Open = "open",
        Accepted = "accepted",
        Refused = "refused",
    }
}

/// Kinds of advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A departure is better pushed later.
    HoldAtStand,
    /// Two ways meet at one time.
    ConflictAhead,
    /// Between two landings there is room to cross or to take off.
    Gap,
    /// A stand is wanted by two.
    StandConflict,
}

words! {
    "kind of advice": Kind {
        HoldAtStand = "HOLD_STAND",
        ConflictAhead = "CONFLICT",
        Gap = "GAP",
        StandConflict = "STAND",
    }
}

impl Kind {
    /// In what it is worth what it is worth.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::ConflictAhead => "stops",
            _ => "s",
        }
    }
}

/// What is advised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// Hold it at its stand.
    HoldAtStand {
        /// Its runway, by index in the network.
        runway: usize,
        /// Takes off then, s (TTOT).
        take_off_s: f64,
        /// How many take off before it; the other is the last of them.
        before: u32,
    },
    /// Hold it where it is: its way meets the other's.
    ConflictAhead {
        /// There, m.
        place_m: Point2<f64>,
        /// It is there then, s.
        meets_s: f64,
        /// So long after the other, s.
        behind_s: f64,
    },
    /// Clear it in a gap.
    Gap {
        /// For this.
        clearance: ClearanceKind,
        /// Over or onto this runway of the layout, by index.
        runway: usize,
        /// It is open now.
        open: bool,
        /// From then on, s.
        opens_s: f64,
        /// The next one lands then, s: the other where the gap is open, else one after the other. `None`: nobody is seen to.
        lands_s: Option<f64>,
        /// What it takes, s.
        needs_s: f64,
    },
    /// Give it another stand: the other is on its own.
    StandConflict {
        /// Its stand, by index in the network.
        stand: usize,
        /// Free then, s; `None`: nobody knows.
        free_s: Option<f64>,
        /// It comes then, s.
        comes_s: f64,
        /// A free one nearby.
        instead: Option<usize>,
    },
}

impl What {
    /// Of which kind it is.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::HoldAtStand { .. } => Kind::HoldAtStand,
            Self::ConflictAhead { .. } => Kind::ConflictAhead,
            Self::Gap { .. } => Kind::Gap,
            Self::StandConflict { .. } => Kind::StandConflict,
        }
    }

    /// The clearance that whoever accepts it says.
    #[must_use]
    pub fn clearance(&self) -> Option<ClearanceKind> {
        match self {
            Self::ConflictAhead { .. } => Some(ClearanceKind::Hold),
            Self::Gap { clearance, open: true, .. } => Some(*clearance),
            _ => None,
        }
    }
}

/// An advice.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// Counted in the run from 1.
    pub id: u32,
    /// For whom.
    pub seat: Seat,
    /// Who should do something.
    pub flight: u32,
    /// Whom it depends on.
    pub other: Option<u32>,
    /// Given at, s.
    pub since_s: f64,
    /// Holds until, s.
    pub until_s: f64,
    /// What it is worth, in [`Kind::unit`].
    pub value: f64,
    /// What is advised.
    pub what: What,
    /// What was decided, and whether by a person.
    pub decision: (Decision, bool),
}

impl Advice {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.what.kind()
    }
}

/// What became of an advice.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Given.
    Given(Advice),
    /// Its time moved by more than 15 s, or it is about another.
    Moved(Advice),
    /// Decided upon.
    Decided(Advice),
    /// Over: its time has come, it was followed, or what it warned of is.
    Ended(Advice),
}

/// The same without the advice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Became {
    /// Given.
    #[default]
    Given,
    /// Its time moved, or it is about another.
    Moved,
    /// Decided upon.
    Decided,
    /// Over.
    Ended,
}

words! {
    "change of an advice": Became {
        Given = "given",
        Moved = "moved",
        Decided = "decided",
        Ended = "ended",
    }
}

impl Change {
    /// What became of it.
    #[must_use]
    pub fn became(&self) -> Became {
        match self {
            Self::Given(_) => Became::Given,
            Self::Moved(_) => Became::Moved,
            Self::Decided(_) => Became::Decided,
            Self::Ended(_) => Became::Ended,
        }
    }

    /// The advice.
    #[must_use]
    pub fn advice(&self) -> &Advice {
        match self {
            Self::Given(a) | Self::Moved(a) | Self::Decided(a) | Self::Ended(a) => a,
        }
    }
}

/// The airport as it is seen in a scan.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Tracks, strips, runways.
    pub known: Known<'a>,
    /// The ground network.
    pub network: &'a Network,
    /// The flights, as planned.
    pub flights: &'a [Flight],
    /// Who waits for what, or could be cleared for it though he does not ask, and on which runway.
    pub waiting: &'a [Waiting],
    /// Frame, and its length, s.
    pub frame: (i64, f64),
}

impl Picture<'_> {
    /// Whether a flight has taken off here, as far as is known.
    #[must_use]
    pub fn has_taken_off(&self, flight: usize) -> bool {
        self.flights.get(flight).is_some_and(|f| f.direction == Direction::Departure)
            && self.strip(flight).is_some_and(|(_, strip)| strip.lifted_off.is_some())
    }

    /// The strip of a flight, and its index on the board.
    fn strip(&self, flight: usize) -> Option<(u32, &Strip)> {
        let callsign = Callsign::new(&self.flights.get(flight)?.callsign);
        let index = self.known.board.find(callsign)?;
        Some((index as u32, &self.known.board.strips()[index]))
    }

    /// The flight of a strip, by index.
    fn flight_of(&self, strip: u32) -> Option<u32> {
        let callsign = self.known.board.strips().get(strip as usize)?.callsign;
        let own = |f: &Flight| Callsign::new(&f.callsign) == callsign;
        self.flights.iter().position(own).map(|m| m as u32)
    }

    /// The stand of a flight: of its strip, else of its plan.
    fn stand_of(&self, flight: usize) -> usize {
        let strip = self.strip(flight).map(|s| s.1);
        stand_of(strip, self.network, &self.flights[flight])
    }
}

/// What is seen to be better done, before it is an advice.
#[derive(Clone, Debug, PartialEq)]
struct Found {
    seat: Seat,
    flight: u32,
    other: Option<u32>,
    until_s: f64,
    value: f64,
    what: What,
}

/// A time that moves by less is not told, s.
const STEADY_S: f64 = 15.0;
/// Seen in so many scans, it is told.
const CONFIRMS: u32 = 3;
/// Not seen for so long, it is over, s: speeds come and go in turns.
const FORGETS_S: f64 = 10.0;
/// Advices of the kinds that look at tracks that stand at most.
const MOST: usize = 64;

/// Something that is seen, told or not yet.
#[derive(Clone, Debug)]
struct Noted {
    found: Found,
    scans: u32,
    seen_s: f64,
    told: Option<Advice>,
}

/// All that advises the controllers of an airport.
#[derive(Clone, Debug)]
pub struct Advisor {
    holds: StandHold,
    noted: BTreeMap<(Kind, u32), Noted>,
    told: u32,
}

impl Advisor {
    /// The advisor of a run: nothing has happened.
    #[must_use]
    pub fn new(habits: Habits, seed: u64, departures: Vec<Departing>) -> Self {
        let holds = StandHold::new(habits, seed, departures);
        Self { holds, noted: BTreeMap::new(), told: 0 }
    }

    /// The advice that stands, by kind and flight.
    pub fn standing(&self) -> impl Iterator<Item = &Advice> {
        self.holds.standing().chain(self.noted.values().filter_map(|n| n.told.as_ref()))
    }

    /// The advice of a kind that stands for a flight.
    #[must_use]
    pub fn of(&self, kind: Kind, flight: u32) -> Option<&Advice> {
        self.standing().find(|a| a.flight == flight && a.kind() == kind)
    }

    /// Whether the model may push a flight now: there is no accepted advice to hold it.
    #[must_use]
    pub fn may_push(&self, flight: u32) -> bool {
        self.holds.may_push(flight)
    }

    /// A clearance was given.
    pub fn given(&mut self, given: &Given) {
        self.holds.given(given);
    }

    /// Somebody decides upon the advice of a kind that stands for a flight.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn decide(
        &mut self,
        kind: Kind,
        flight: u32,
        decision: Decision,
        by_person: bool,
    ) -> Result<Change, String> {
        if kind == Kind::HoldAtStand {
            return self.holds.decide(flight, decision, by_person);
        }
        let told = self.noted.get_mut(&(kind, flight)).and_then(|n| n.told.as_mut());
        let advice = told.ok_or("there is no advice that stands for it")?;
        if advice.decision.0 == decision {
            return Err(format!("the advice is {} already", decision.word()));
        }
        advice.decision = (decision, by_person);
        Ok(Change::Decided(advice.clone()))
    }

    /// One scan: who wants what, by flight; `taken`: whether a person has the apron's seat; `picture`: the airport as it is seen,
    /// where anybody looks at it. What changed.
    pub fn scan(
        &mut self,
        now_s: f64,
        wanted: &[Wanted],
        taken: bool,
        picture: Option<&Picture<'_>>,
    ) -> Vec<Change> {
        let mut changes = self.holds.scan(now_s, wanted, taken, &mut self.told);
        if let Some(picture) = picture {
            let mut found = conflict::look(now_s, picture);
            found.extend(gap::look(now_s, picture));
            found.extend(stand::look(now_s, picture));
            self.note(now_s, found, &mut changes);
        }
        changes
    }

    /// What is seen now becomes advice when it stays, and is over when it goes.
    fn note(&mut self, now_s: f64, found: Vec<Found>, changes: &mut Vec<Change>) {
        for found in found {
            let key = (found.what.kind(), found.flight);
            // Of two who meet the one stays advised that was, though now the other is there later.
            if let Some(turned) = found.other.and_then(|o| self.noted.get_mut(&(key.0, o)))
                && key.0 == Kind::ConflictAhead
                && turned.found.other == Some(found.flight)
            {
                turned.seen_s = now_s;
                continue;
            }
            if self.noted.len() >= MOST && !self.noted.contains_key(&key) {
                continue;
            }
            let noted = self.noted.entry(key).or_insert_with(|| Noted {
                found: found.clone(),
                scans: 0,
                seen_s: now_s,
                told: None,
            });
            (noted.scans, noted.seen_s) = (noted.scans + 1, now_s);
            match &mut noted.told {
                None if noted.scans >= CONFIRMS => {
                    self.told += 1;
                    let advice = found.advice(self.told, now_s, (Decision::Open, false));
                    noted.told = Some(advice.clone());
                    changes.push(Change::Given(advice));
                }
                Some(told) => {
                    let moved = (told.until_s - found.until_s).abs() > STEADY_S
                        || told.other != found.other
                        || told.what.clearance() != found.what.clearance();
                    if moved {
                        // What a person accepted when there was nothing to say yet is his to accept once there is.
                        let waits = told.what.clearance().is_none()
                            && told.decision == (Decision::Accepted, true);
                        let opens = waits && found.what.clearance().is_some();
                        let decision = if opens { (Decision::Open, false) } else { told.decision };
                        *told = found.advice(told.id, told.since_s, decision);
                        changes.push(Change::Moved(told.clone()));
                    }
                }
                None => {}
            }
            noted.found = found;
        }
        self.noted.retain(|_, noted| {
            let over = now_s - noted.seen_s > FORGETS_S;
            if let (true, Some(told)) = (over, noted.told.take_if(|_| over)) {
                changes.push(Change::Ended(told));
            }
            !over
        });
    }
}

impl Found {
    fn advice(&self, id: u32, since_s: f64, decision: (Decision, bool)) -> Advice {
        Advice {
            id,
            seat: self.seat,
            flight: self.flight,
            other: self.other,
            since_s,
            until_s: self.until_s,
            value: self.value,
            what: self.what,
            decision,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conflict(flight: u32, other: u32, meets_s: f64) -> Found {
        Found {
            seat: Seat::Ground,
            flight,
            other: Some(other),
            until_s: meets_s,
            value: 1.0,
            what: What::ConflictAhead { place_m: Point2::origin(), meets_s, behind_s: 3.0 },
        }
    }

    fn gap(open: bool) -> Found {
        let (clearance, runway) = (ClearanceKind::Cross, 0);
        let what =
            What::Gap { clearance, runway, open, opens_s: 0.0, lands_s: Some(90.0), needs_s: 40.0 };
        Found { seat: Seat::Tower(0), flight: 7, other: Some(8), until_s: 50.0, value: 9.0, what }
    }

    /// Words of what changed in a scan that finds these.
    fn scan(advisor: &mut Advisor, now_s: f64, found: &[Found]) -> Vec<(&'static str, u32, u32)> {
        let mut changes = Vec::new();
        advisor.note(now_s, found.to_vec(), &mut changes);
        changes.iter().map(|c| (c.became().word(), c.advice().flight, c.advice().id)).collect()
    }

    #[test]
    fn what_stays_for_three_scans_is_told_once_and_over_ten_seconds_after_it_went() {
        let mut advisor = Advisor::new(Habits::default(), 1, Vec::new());
        let one = [conflict(3, 4, 60.0)];
        assert!(scan(&mut advisor, 1.0, &one).is_empty());
        assert!(scan(&mut advisor, 2.0, &one).is_empty());
        assert_eq!(scan(&mut advisor, 3.0, &one), [("given", 3, 1)]);
        assert!(scan(&mut advisor, 4.0, &[conflict(3, 4, 70.0)]).is_empty(), "10 s later");
        assert_eq!(scan(&mut advisor, 5.0, &[conflict(3, 4, 80.0)]), [("moved", 3, 1)]);
        // Now the other one is later: the same two meet, and the first stays advised.
        assert!(scan(&mut advisor, 6.0, &[conflict(4, 3, 80.0)]).is_empty());
        assert!(scan(&mut advisor, 15.0, &[]).is_empty());
        assert!(advisor.of(Kind::ConflictAhead, 3).is_some());
        assert_eq!(scan(&mut advisor, 17.0, &[]), [("ended", 3, 1)]);
        assert!(advisor.standing().next().is_none());
        // Seen in one scan only: never told, and nothing is left of it.
        scan(&mut advisor, 18.0, &one);
        assert!(scan(&mut advisor, 40.0, &[]).is_empty() && advisor.noted.is_empty());
        let many: Vec<Found> = (0..1000).map(|f| conflict(f, f + 1000, 60.0)).collect();
        for now_s in [50.0, 51.0, 52.0] {
            scan(&mut advisor, now_s, &many);
        }
        assert_eq!(advisor.standing().count(), MOST);
    }

    #[test]
    fn a_person_decides_upon_what_stands_and_a_gap_can_be_said_while_it_is_open() {
        let mut advisor = Advisor::new(Habits::default(), 1, Vec::new());
        for now_s in [1.0, 2.0, 3.0] {
            scan(&mut advisor, now_s, &[gap(false)]);
        }
        let said = |a: &Advisor| a.of(Kind::Gap, 7).and_then(|a| a.what.clearance());
        assert_eq!(said(&advisor), None, "it is not open yet");
        assert_eq!(scan(&mut advisor, 4.0, &[gap(true)]), [("moved", 7, 1)]);
        assert_eq!(said(&advisor), Some(ClearanceKind::Cross));
        let decide =
            |a: &mut Advisor, kind, d| a.decide(kind, 7, d, true).map(|c| c.became().word());
        assert!(decide(&mut advisor, Kind::ConflictAhead, Decision::Accepted).is_err());
        assert_eq!(decide(&mut advisor, Kind::Gap, Decision::Refused), Ok("decided"));
        assert!(decide(&mut advisor, Kind::Gap, Decision::Refused).is_err(), "twice");
        // What was decided stays with it, and the models decide nothing of it.
        scan(&mut advisor, 5.0, &[gap(false)]);
        let decision = advisor.of(Kind::Gap, 7).map(|a| a.decision);
        assert_eq!(decision, Some((Decision::Refused, true)));
        // What was accepted before there was anything to say is open again when there is, once.
        assert_eq!(decide(&mut advisor, Kind::Gap, Decision::Accepted), Ok("decided"));
        scan(&mut advisor, 6.0, &[gap(true)]);
        let decision = advisor.of(Kind::Gap, 7).map(|a| a.decision);
        assert_eq!(decision, Some((Decision::Open, false)));
        assert_eq!(decide(&mut advisor, Kind::Gap, Decision::Accepted), Ok("decided"));
        scan(&mut advisor, 7.0, &[gap(true)]);
        assert!(decide(&mut advisor, Kind::Gap, Decision::Accepted).is_err(), "said already");
    }
}
