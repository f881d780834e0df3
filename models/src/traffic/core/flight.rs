//! What goes into a core and what comes out of it, as plain data.

use crate::traffic::outline::Size;
use crate::traffic::runway_roll::{TakeOff, take_off_run};
use crate::wake::Wake;

/// Which piece may be taken when it is free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// In the order of planned times: every way is planned in the time windows that the others leave.
    #[default]
    Planned,
    /// Only if everybody can finish afterwards, one after the other (banker's algorithm).
    Ordered,
    /// Always: ends in gridlock sooner or later, which is found and named.
    Free,
}

/// Arrival, departure, or neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Lands at its time and taxis to a stand.
    Arrival,
    /// Leaves its stand at its time and takes off.
    Departure,
    /// A vehicle: drives from stand to stand from its time on, and uses no runway.
    Vehicle,
}

impl Direction {
    /// What a flight of it is, for people.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Arrival => "an arrival",
            Self::Departure => "a departure",
            Self::Vehicle => "a vehicle",
        }
    }
}

/// One flight of a schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// For messages.
    pub callsign: String,
    /// Size on the ground.
    pub size: Size,
    /// What it does.
    pub direction: Direction,
    /// Runway, and which end it lands or takes off from (0 or 1).
    pub runway: (usize, usize),
    /// Stand wanted.
    pub stand: usize,
    /// Landing time (threshold) or off-block time, s since the start of the run.
    pub time_s: f64,
    /// Slot of a departure: calculated take-off time, s since the start of the run.
    pub ctot_s: Option<f64>,
    /// Arrival whose aircraft this departure is.
    pub turnaround_of: Option<usize>,
    /// Wake category.
    pub wake: Wake,
    /// Taxi speed on straights and in quarter turns, m/s.
    pub taxi_mps: (f64, f64),
    /// Acceleration and braking when taxiing, m/s².
    pub taxi_acc_mps2: (f64, f64),
    /// Lift-off speed, m/s, and run, m.
    pub take_off: (f64, f64),
    /// Touchdown speed, m/s, and usual braking, m/s².
    pub landing: (f64, f64),
    /// From nose wheel to main gear, m.
    pub wheelbase_m: f64,
    /// Fuel of all engines at idle, kg/s.
    pub idle_kg_per_s: f64,
    /// Key of its draws.
    pub key: u64,
}

/// From the node of an entry to the end of its arc, m (assumed), and on from there until it is lined up, in lengths.
const ENTRY_ARC_M: f64 = 40.0;
pub(super) const LINES_UP_LENGTHS: f64 = 0.8;
/// What the building-up of thrust adds to a take-off run, m.
pub(super) const SPOOL_M: f64 = 10.0;

impl Flight {
    /// Its take-off run in air of a density over that of the standard one, against a head wind.
    #[must_use]
    pub fn take_off_on(&self, density_ratio: f64, headwind_mps: f64) -> TakeOff {
        TakeOff {
            liftoff_mps: self.take_off.0,
            distance_m: self.take_off.1,
            density_ratio,
            headwind_mps,
            end_ratio: 0.75,
            thrust_exponent: 0.7,
            rolling_friction: 0.02,
        }
    }

    /// Length of that run, m: in calm standard air the figure of its type; `None` where it cannot lift off.
    #[must_use]
    pub fn run_m(&self, density_ratio: f64, headwind_mps: f64) -> Option<f64> {
        if density_ratio == 1.0 && headwind_mps == 0.0 {
            return Some(self.take_off.1);
        }
        take_off_run(&self.take_off_on(density_ratio, headwind_mps)).map(|run| run.distance_m)
    }

    /// Runway that its take-off wants ahead of the node at which it enters, m: what it is driven on until it is lined up, and its
    /// run. `None` where it cannot lift off.
    #[must_use]
    pub fn needs_runway_m(&self, density_ratio: f64, headwind_mps: f64) -> Option<f64> {
        let lines_up_m = ENTRY_ARC_M + LINES_UP_LENGTHS * self.size.length_m;
        Some(self.run_m(density_ratio, headwind_mps)? + SPOOL_M + lines_up_m)
    }

    /// What tells sizes apart.
    pub(super) fn key_of_size(&self) -> (u64, u64) {
        (self.size.length_m.to_bits(), self.size.span_m.to_bits())
    }
}

/// Where a flight is in its life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Not yet in the run.
    Absent,
    /// On its stand before the pushback.
    Parked,
    /// Pushed back.
    Pushing,
    /// Tug leaves, engines start; until this time, s.
    Starting(f64),
    /// Under way on the ground.
    Taxiing,
    /// On the runway, not yet rolling; until this time, s.
    LinedUp(f64),
    /// Take-off run, and the climb after it.
    Rolling,
    /// On final.
    Final,
    /// Gone around: climbs away.
    GoAround,
    /// From touchdown on, until it has left the runway.
    Landing,
    /// On its stand, for good or until its turn-round.
    Docked,
    /// Left the run.
    Gone,
}

/// A clearance, as the plan gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Flight.
    pub flight: usize,
    /// `PSH`, `TAX`, `CRO`, `LUP`, `TOF`, `LND`, `GOA`.
    pub kind: &'static str,
    /// Runway: an end (`18R`) or both (`18R/36L`); empty off the runways.
    pub runway: String,
    /// Holds from, s.
    pub from_s: f64,
    /// Ended, s.
    pub until_s: Option<f64>,
    /// Entry, crossing or line-up place along the runway from its first end, m.
    pub place_m: Option<f64>,
    /// Of a taxi clearance: names of the taxiways that it leads over, in their order, separated by blanks.
    pub route: String,
}

/// Times and measures of one flight (`docs/traffic.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Actual off-block time, s.
    pub aobt_s: Option<f64>,
    /// Actual take-off time.
    pub atot_s: Option<f64>,
    /// Actual landing time.
    pub aldt_s: Option<f64>,
    /// Actual in-block time.
    pub aibt_s: Option<f64>,
    /// On its runway: from over the threshold until the tail is beyond the line, or from over the line until it is airborne, s.
    pub on_runway_s: [Option<f64>; 2],
    /// Stops of 5 s or more off stands.
    pub stops: u32,
    /// Time of these stops, s.
    pub stopped_s: f64,
    /// Off-block to line-up, or runway vacated to in-block, s; `None` before it has.
    pub taxi_s: Option<f64>,
    /// The same way driven alone, s.
    pub unhindered_s: f64,
    /// Fuel on the ground, kg.
    pub fuel_kg: f64,
    /// Go-arounds.
    pub go_arounds: u32,
    /// Head wind at its touchdown, m/s.
    pub head_mps: f64,
}

impl Measures {
    /// Time of taxiing less that of the same way driven alone, s; `None` before it has taxied.
    #[must_use]
    pub fn additional_s(&self) -> Option<f64> {
        Some(self.taxi_s? - self.unhindered_s)
    }
}

/// What an input or a finding says, for the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Time, s.
    pub time_s: f64,
    /// One line.
    pub text: String,
}

/// Why a mover waits.
#[derive(Clone, Debug, PartialEq)]
pub struct Waiting<'a> {
    /// Call sign of the one for whom it waits; `None`: for the policy or a clearance.
    pub behind: Option<&'a str>,
    /// Name of the edge that it wants.
    pub place: String,
    /// Since when, s of the run.
    pub since_s: f64,
    /// Time that is still planned, s; negative when it is late.
    pub planned_s: Option<f64>,
}
