//! The replicated core: the traffic of one airport, stepped frame by frame.
//!
//! Pure: the same flights, seed and frames give the same bits in every process that steps it, so every
//! generator steps all of it and publishes its share. Movers read each other exactly inside; outside
//! everybody sees them through their PDUs.

mod arrival;
mod asked;
mod car;
mod closed;
mod controllers;
mod day;
mod departure;
mod drive;
mod equipment;
mod failures;
mod flight;
mod greens;
mod hand;
mod hand_flight;
mod handover;
mod landing;
mod measures;
mod notice;
mod obstacles;
mod perceived;
mod plan;
mod runway;
mod sequence;
mod stands;
mod state;
mod technical_error;
mod tokens;
mod told;
mod tow;
mod vehicle;

pub use day::Day;
pub use equipment::drawn_failures;
pub use failures::{Failure, FailureKind, Shown};
pub use flight::{Clearance, Direction, Flight, Measures, Phase, Policy, Remark, Waiting};
pub use greens::{LAMP_DELAY_S, Lamps, Segment, Shown as Greens};
pub use hand::{AtWheel, Driven, SILENT_S, Wish};
pub use handover::{Ask, Given, Outcome, RELEASED_ABOVE_M};
pub use notice::{ClearedBy, Notice, Order};
pub use obstacles::Obstacle;
pub use perceived::{OnGround, Seen};
use runway::TookOff;

use super::network::Network;
use super::outline::Size;
use super::pieces::{Class, Pieces};
use super::runway_roll::NAUTICAL_MILE_M;
use super::way::{Arcs, Driving, Way};
use crate::control::actors::Actors;
use crate::control::actors::seats::crossings;
use crate::control::clearance::ClearanceKind;
use crate::control::departures::Departures;
use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::flight_list::WakeCategory;
use crate::wake::Wake;
use failures::Failing;
use notice::Granted;
use plan::{Booking, Links, Times, Timing};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

#[derive(Clone, Debug)]
struct Mover {
    flight: usize,
    class: Class,
    phase: Phase,
    /// How it drives now, and when it is dry and clear.
    driving: Driving,
    dry: Driving,
    push: Way,
    way: Way,
    stand: usize,
    /// Place of the guided point, speed, acceleration along the way, slip.
    s: f64,
    v: f64,
    a: f64,
    slip: f64,
    /// Beside the way since the end of the pushback, m, and the place of that.
    beside_m: crate::frames::Vector2<f64>,
    beside_from: f64,
    height_m: f64,
    climb_mps: f64,
    /// Taken: indices `first_held..next` of the way in use.
    first_held: usize,
    next: usize,
    refused_at: Option<u64>,
    waits_since_s: Option<f64>,
    waits_for: Option<usize>,
    /// Kept on its stand since then by somebody who stands on his own.
    shut_in_since_s: Option<f64>,
    still_since_s: Option<f64>,
    /// Frames since then; and how long it breaks away from now on, s.
    still_frames: u32,
    breaks_away_s: f64,
    /// Landing: place of the threshold, touchdown and exit on the way; braking.
    threshold: f64,
    touchdown: f64,
    /// The last of its final.
    flare: landing::Flare,
    braking: f64,
    /// Greatest braking of its roll and in its exit, by the weather in which it chose that, m/s².
    most_mps2: f64,
    off_mps2: f64,
    /// Where its exit leaves the strip, m.
    off_to_m: f64,
    landing_s: f64,
    cleared: bool,
    ready_s: f64,
    next_try_s: f64,
    parked_pieces: Vec<u32>,
    /// Steps of the way that are under the mover when it has been pushed back.
    under: Range<usize>,
    /// First step that is taken for the roll, not for the line-up; from the holding position to being lined up, s.
    roll_from: usize,
    line_up_s: f64,
    /// Pieces of the roll that are held from the line-up on, as somebody off the strip could want them.
    kept: Vec<u32>,
    /// Stands with its nose to the lane: it leaves without a pushback.
    turned: bool,
    /// Where it is towed to, out of a stand from which nothing leads away; and the stands that it was towed out of.
    tow_to: Option<usize>,
    towed_from: Vec<usize>,
    /// Where a vehicle drives to: stand, and the pieces under it there.
    goal: Option<(usize, Vec<u32>)>,
    /// How far short of its place on the stand it stands, m: who has driven there.
    stands_short_m: f64,
    /// Drives of a vehicle that were planned.
    drives: u64,
    timing: Timing,
    /// Clearances from outside; what it waits for; told to hold; stands by itself until, s.
    granted: Granted,
    /// Of these, those of a person: used whoever has the runway.
    insisted: Granted,
    /// Brakes on its take-off run.
    rejects: bool,
    /// It has been said that its runway is too short on this day.
    lacks_runway: bool,
    wants: Option<ClearanceKind>,
    holds: bool,
    stopped_until_s: f64,
    taxi_from_s: f64,
    measures: Measures,
    /// By a failure: stands, is towed.
    stopped: bool,
    towed: bool,
    cleared_way_m: Vec<crate::frames::Point2<f64>>,
    /// The cleared way by its arcs, where it is not the one that is driven.
    cleared_arcs: Vec<usize>,
    /// It is the way from this place on, and has not been drawn yet, m.
    cleared_from_m: Option<f64>,
    /// A person drives it.
    hand: Option<Box<hand::Hand>>,
    /// Given on final, it comes to its line.
    join: Option<Box<handover::Join>>,
    /// Beside its line: taxiing, and on final.
    wander: technical_error::Wander,
    approach: technical_error::Approach,
    /// Stops so far before the holding position of a runway, m.
    hold_gap_m: f64,
}

/// Seconds between attempts of those who could not be given a way or a runway.
const RETRY_S: f64 = 5.0;
const FINAL_M: f64 = 10.0 * NAUTICAL_MILE_M;
/// Distance at which the next piece is asked for, m.
const ASK_M: f64 = 15.0;
/// Gap before the holding position of a runway, least and most, m: 5 ± 2, drawn once a mover (assumed).
const HOLD_GAP_M: [f64; 2] = [3.0, 7.0];
const TAIL_M: f64 = 5.0;
/// Slope of the approach.
const SLOPE: f64 = 0.052_407_779_283_041_2;

/// The traffic of one airport.
#[derive(Clone, Debug)]
pub struct Core {
    net: Arc<Network>,
    pieces: Arc<Pieces>,
    arcs: Arc<Arcs>,
    flights: Arc<Vec<Flight>>,
    policy: Policy,
    seed: u64,
    step_s: f64,
    movers: Vec<Mover>,
    /// By piece: who holds it, once a visit.
    holders: Vec<Vec<u32>>,
    /// By piece: who rolls beside it.
    rolls: Vec<Vec<u32>>,
    /// By piece: planned takes that have not come yet.
    books: Vec<Vec<Booking>>,
    /// By mover: the takes of its plan; numbers of the last plan and of the last bringing up to date of all.
    links: Vec<Links>,
    plans: u64,
    retimed: u64,
    /// Room for the times of all, between bringing them up to date.
    times: Times,
    /// Changes with every release, so that a refusal is asked again only then.
    version: u64,
    /// By runway: the last take-off, the last assigned landing time and its wake.
    last_take_off: Vec<Option<TookOff>>,
    last_landing: Vec<(f64, Wake)>,
    /// From the threshold to being off the runway, s, as the last landings took it.
    occupied_s: Vec<f64>,
    crossing: Vec<Vec<usize>>,
    mixed: Vec<bool>,
    /// By runway: who rolls, lands or is lined up; who lines up behind him.
    owner: Vec<Option<usize>>,
    behind: Vec<Option<usize>>,
    /// The weather of the run, each from a time on, s; what of it is next; that of now.
    days: Arc<Vec<(f64, Day)>>,
    next_day: usize,
    day: Day,
    time_s: f64,
    frame: i64,
    cleared_by: ClearedBy,
    /// Notices whose effect frame has not come, in their order.
    waiting: Vec<Notice>,
    actors: Option<Actors>,
    /// When departures leave their stands, where that is by a sequence.
    departures: Option<Departures>,
    /// Lamps of the taxiways, where they lead.
    lamps: Option<greens::Lamps>,
    /// Clearances that the controllers have spoken.
    spoken: u64,
    /// Who goes by sight, by a person's word; who touched whom.
    by_sight: Vec<usize>,
    contacts: BTreeSet<(usize, usize)>,
    clearances: Vec<Clearance>,
    remarks: Vec<Remark>,
    failing: Vec<Failing>,
    shown: Vec<Shown>,
    obstacles: obstacles::Obstacles,
    /// Movers that people drive, and where it is paved.
    hands: Vec<hand::Hand>,
    flights_by_hand: bool,
    handovers: handover::Handovers,
    pavement_m: Arc<Vec<Vec<crate::frames::Point2<f64>>>>,
    /// By node: the part of the network that it is in where strips are left out; empty without vehicles.
    parts: Arc<Vec<usize>>,
    /// By stand, size, runway and end: how it is left, if it can be.
    leaves: BTreeMap<stands::Left, Option<stands::Leaving>>,
    /// Rings of movers that wait for each other under a policy that rules them out.
    unexpected: u64,
}

impl Core {
    /// The core at time 0, on a dry, clear and calm day. `step_s`: length of a frame.
    #[must_use]
    pub fn new(
        net: Arc<Network>,
        pieces: Arc<Pieces>,
        flights: Arc<Vec<Flight>>,
        policy: Policy,
        seed: u64,
        step_s: f64,
    ) -> Self {
        Self::in_weather((net, pieces), flights, policy, (seed, step_s), Arc::default())
    }

    /// The same in a weather: from when each holds, s, in this order.
    #[must_use]
    pub fn in_weather(
        (net, pieces): (Arc<Network>, Arc<Pieces>),
        flights: Arc<Vec<Flight>>,
        policy: Policy,
        (seed, step_s): (u64, f64),
        days: Arc<Vec<(f64, Day)>>,
    ) -> Self {
        let mut core = Self::empty(net, pieces, flights, policy, seed, step_s);
        core.days = days;
        core.look_at_weather();
        core.parts = Arc::new(core.parts_beside_strips());
        core.appear();
        core
    }

    /// The same before anybody has come into it.
    fn empty(
        net: Arc<Network>,
        pieces: Arc<Pieces>,
        flights: Arc<Vec<Flight>>,
        policy: Policy,
        seed: u64,
        step_s: f64,
    ) -> Self {
        let arcs = Arc::new(Arcs::of(&net));
        let count = net.runways.len();
        let crossing = crossings(&net);
        let of = |direction: Direction, r: usize| {
            flights.iter().any(|f| f.direction == direction && f.runway.0 == r)
        };
        let mixed =
            (0..count).map(|r| crossing[r].iter().any(|c| of(Direction::Departure, *c))).collect();
        let movers = (0..flights.len()).map(|f| Mover::of(f, &flights[f], seed)).collect();
        let all = pieces.list.len();
        let occupied_s = (0..count).map(|r| runway::occupied_first_s(&net, r)).collect();
        Self {
            net,
            pieces,
            arcs,
            flights,
            policy,
            seed,
            step_s,
            movers,
            holders: vec![Vec::new(); all],
            rolls: vec![Vec::new(); all],
            books: vec![Vec::new(); all],
            links: Vec::new(),
            plans: 0,
            retimed: 0,
            times: Times::default(),
            version: 0,
            last_take_off: vec![None; count],
            last_landing: vec![(f64::NEG_INFINITY, WakeCategory::Light.into()); count],
            occupied_s,
            crossing,
            mixed,
            owner: vec![None; count],
            behind: vec![None; count],
            days: Arc::default(),
            next_day: 0,
            day: Day::default(),
            time_s: 0.0,
            frame: 0,
            cleared_by: ClearedBy::Plan,
            waiting: Vec::new(),
            actors: None,
            departures: None,
            lamps: None,
            spoken: 0,
            by_sight: Vec::new(),
            contacts: BTreeSet::new(),
            clearances: Vec::new(),
            remarks: Vec::new(),
            failing: Vec::new(),
            shown: Vec::new(),
            obstacles: obstacles::Obstacles::default(),
            hands: Vec::new(),
            flights_by_hand: false,
            handovers: handover::Handovers::default(),
            pavement_m: Arc::default(),
            parts: Arc::default(),
            leaves: BTreeMap::new(),
            unexpected: 0,
        }
    }

    /// Classes of the movers of some flights.
    #[must_use]
    pub fn classes(flights: &[Flight]) -> Vec<Class> {
        let mut classes: Vec<Class> = flights.iter().map(|f| class_of(f.size)).collect();
        classes.sort_unstable();
        classes.dedup();
        classes
    }

    /// Executes the next frame.
    pub fn step(&mut self, frame: i64) {
        self.time_s = frame as f64 * self.step_s;
        self.frame = frame;
        self.look_at_weather();
        self.apply_notices();
        self.apply_asks();
        self.move_hands();
        let frames_a_second = (1.0 / self.step_s).round().max(1.0) as i64;
        if frame.rem_euclid(frames_a_second) == 0 {
            self.look_at_obstacles();
        }
        let whole = (self.time_s / RETRY_S).fract() < self.step_s / RETRY_S * 0.999;
        if whole {
            self.appear();
        }
        for m in 0..self.movers.len() {
            match self.movers[m].phase {
                Phase::Absent | Phase::Docked | Phase::Gone => {}
                Phase::Parked => self.parked(m),
                Phase::Starting(until) => {
                    if self.time_s >= until && self.permitted(m, ClearanceKind::Taxi) {
                        self.used(m, ClearanceKind::Taxi);
                        self.start_taxi(m);
                    }
                }
                Phase::Pushing => self.pushing(m),
                Phase::Taxiing => self.taxiing(m),
                Phase::LinedUp(until) => {
                    if self.turned_back_by_runway(m) {
                        continue;
                    }
                    let waits = self.entered_uncleared(m);
                    self.asks_for_take_off(m);
                    if self.by_sight.contains(&m) {
                        self.joins_runway(m);
                    }
                    let uncleared = self.failing(m, FailureKind::TakeOffUncleared);
                    let told = self.movers[m].insisted.has(ClearanceKind::TakeOff);
                    let anyway = uncleared.is_some() || told;
                    let may = self.time_s >= until && !waits && (anyway || self.may_roll(m));
                    if may
                        && (uncleared.is_some() || self.permitted(m, ClearanceKind::TakeOff))
                        && match told {
                            true => self.take_roll_told(m),
                            false => self.take_roll(m, uncleared.is_some()),
                        }
                    {
                        match uncleared {
                            Some(failure) => self.begin_failure(failure),
                            None if self.clear_take_off(m) => continue,
                            None => {}
                        }
                        self.used(m, ClearanceKind::TakeOff);
                        self.movers[m].phase = Phase::Rolling;
                        let (r, wake) = (self.flights[m].runway.0, self.flights[m].wake);
                        let (rolled_s, airborne_s) = (self.time_s, self.time_s + self.run_s(m));
                        self.last_take_off[r] = Some(TookOff { rolled_s, airborne_s, wake });
                    }
                }
                Phase::Rolling => self.rolling(m),
                Phase::Final => self.on_final(m),
                Phase::GoAround => self.going_around(m),
                Phase::Landing => self.landing(m),
            }
            self.count(m);
        }
        self.watch_failures();
        if frame.rem_euclid(frames_a_second) == 0 {
            self.look_for_contact();
            self.sequence();
            self.control();
        }
        if whole {
            self.find_deadlock();
        }
    }

    /// Clears for take-off, once; true if nobody answers, so that it does not roll yet.
    fn clear_take_off(&mut self, m: usize) -> bool {
        let before = self.failing(m, FailureKind::NoReply).is_some_and(|f| self.has_begun(f));
        if !before {
            self.end_clearance(m, "LUP");
            self.clear(m, "TOF", self.end_name(m));
            self.clear_against(m);
        }
        match self.silence_s(m) {
            Some(stay_s) => {
                self.movers[m].phase = Phase::LinedUp(self.time_s + stay_s);
                true
            }
            None => false,
        }
    }

    fn rng(&self, m: usize, counter: u64) -> rand::rngs::ChaCha8Rng {
        let entity = self.flights[m].key;
        DrawKey { run_seed: self.seed, sensor: 0, entity, scan: counter }.rng(Purpose::Mover)
    }

    fn end_name(&self, m: usize) -> String {
        let (r, end) = self.flights[m].runway;
        self.net.runways[r].names[end].clone()
    }

    fn clear(&mut self, m: usize, kind: &'static str, runway: String) {
        // Drivers keep off runways: nobody clears them.
        if self.is_vehicle(m) {
            return;
        }
        let (flight, from_s) = (self.movers[m].flight, self.time_s);
        let at = |r: &super::network::NetRunway| {
            r.names.iter().any(|n| runway.split('/').any(|w| w == n))
        };
        let place_m = match kind {
            "LUP" | "CRO" | "TOF" => {
                self.net.runways.iter().find(|r| at(r)).map(|r| self.entry_m(m, r))
            }
            _ => None,
        };
        let route = if kind == "TAX" { self.route_of(m) } else { String::new() };
        self.clearances.push(Clearance {
            flight,
            kind,
            runway,
            from_s,
            until_s: None,
            place_m,
            route,
        });
    }

    /// Names of the taxiways of a mover's way as it was cleared, off the runways, in their order.
    fn route_of(&self, m: usize) -> String {
        let mover = &self.movers[m];
        let arcs = match mover.cleared_arcs.is_empty() {
            true => &mover.way.arcs,
            false => &mover.cleared_arcs,
        };
        let mut names: Vec<&str> = Vec::new();
        for edge in arcs.iter().map(|arc| &self.net.edges[arc / 2]) {
            let name = edge.name.trim();
            if edge.runway.is_none() && !name.is_empty() && names.last() != Some(&name) {
                names.push(name);
            }
        }
        names.join(" ")
    }

    /// Where a mover's way comes on to the centreline of a runway, or nearest to it within the next 600 m (who lines up as he crosses
    /// another one has 2 km to go): place along it, m.
    fn entry_m(&self, m: usize, runway: &super::network::NetRunway) -> f64 {
        let mover = &self.movers[m];
        let (mut best, mut place_m, mut ahead) = (f64::INFINITY, 0.0, 0.0);
        let most_m = if mover.next <= mover.threshold as usize { 2000.0 } else { 600.0 };
        while ahead <= most_m && mover.s + ahead <= mover.way.stop_m.max(mover.s) {
            let (place, across) = runway.place_m(mover.way.path.at(mover.s + ahead).at_m);
            if across.abs() < best {
                (best, place_m) = (across.abs(), place);
            }
            if best < 2.0 {
                break;
            }
            ahead += 4.0;
        }
        place_m
    }

    /// The way from a place on as a line, a point every 8 m.
    fn line_of(way: &Way, from_m: f64) -> Vec<crate::frames::Point2<f64>> {
        let count = ((way.stop_m - from_m) / 8.0).clamp(0.0, 5000.0) as usize;
        let mut line: Vec<_> =
            (0..=count).map(|i| way.path.at(from_m + 8.0 * i as f64).at_m).collect();
        line.push(way.path.at(way.stop_m).at_m);
        line
    }

    /// Draws the way of a mover as it was cleared: of all ways that are laid only of the one that is chosen.
    fn draw_cleared_way(&mut self, m: usize) {
        let mover = &mut self.movers[m];
        if let Some(from_m) = mover.cleared_from_m.take() {
            mover.cleared_way_m = Self::line_of(&mover.way, from_m);
        }
    }

    fn end_clearance(&mut self, m: usize, kind: &'static str) {
        self.end_clearance_of(m, |c| c.kind == kind);
    }

    /// Ends the clearance to cross one runway: the one for the next runway may have begun before it.
    fn end_crossing(&mut self, m: usize, runway: usize) {
        let names = self.net.runways[runway].names.join("/");
        self.end_clearance_of(m, |c| c.kind == "CRO" && c.runway == names);
    }

    /// Ends all that it is cleared for.
    fn end_clearances(&mut self, m: usize) {
        let (flight, now) = (self.movers[m].flight, self.time_s);
        let open = |c: &&mut Clearance| c.flight == flight && c.until_s.is_none();
        self.clearances.iter_mut().filter(open).for_each(|c| c.until_s = Some(now));
    }

    fn end_clearance_of(&mut self, m: usize, which: impl Fn(&Clearance) -> bool) {
        let (flight, now) = (self.movers[m].flight, self.time_s);
        let open = self.clearances.iter_mut().rev();
        if let Some(c) =
            open.filter(|c| c.flight == flight).find(|c| which(c) && c.until_s.is_none())
        {
            c.until_s = Some(now);
        }
    }

    fn remark(&mut self, text: String) {
        let time_s = self.time_s;
        if self.remarks.len() < 10_000 {
            self.remarks.push(Remark { time_s, text });
        }
    }
}

/// A driver brakes so hard at most, m/s², and so suddenly, m/s³ (traffic.md 2.1; the first assumed: freight and passengers).
const DRIVER_MPS2: f64 = 2.0;
const DRIVER_MPS3: f64 = 2.0;
/// Way on which somebody comes back to his line after a pushback, m.
const BESIDE_M: f64 = 60.0;
/// Straight line before the begin of a pushback, m.
const PUSH_BEFORE_M: f64 = 30.0;

/// Class of a mover by its span.
#[must_use]
pub fn class_of(size: Size) -> Class {
    if size.aircraft { super::network::code_of_span(size.span_m) + 1 } else { 0 }
}

impl Mover {
    /// How far it is beside its way, m, and how that changes with the place: after a pushback it comes to the line within
    /// [`BESIDE_M`] of driving.
    fn beside(&self) -> (crate::frames::Vector2<f64>, crate::frames::Vector2<f64>) {
        let x = ((self.s - self.beside_from) / BESIDE_M).clamp(0.0, 1.0);
        let share = 1.0 - x * x * (3.0 - 2.0 * x);
        (self.beside_m * share, self.beside_m * (-6.0 * x * (1.0 - x) / BESIDE_M))
    }

    /// What coming to its line from beside it takes of the acceleration and the braking that it has along the way, m/s².
    fn beside_mps2(&self) -> f64 {
        let x = (self.s - self.beside_from) / BESIDE_M;
        if !(0.0..1.0).contains(&x) || self.v == 0.0 {
            return 0.0;
        }
        let along_m = self
            .beside_m
            .dot(&crate::frames::Azimuth::from_rad(self.way.path.at(self.s).heading_rad).unit());
        (6.0 * (2.0 * x - 1.0) * along_m).abs() * (self.v / BESIDE_M) * (self.v / BESIDE_M)
    }

    /// Fastest when towed, m/s.
    fn most_mps(&self) -> f64 {
        if self.towed { 3.0 } else { f64::INFINITY }
    }

    fn of(flight: usize, f: &Flight, seed: u64) -> Self {
        let mut rng =
            DrawKey { run_seed: seed, sensor: 0, entity: f.key, scan: 1 }.rng(Purpose::Mover);
        let (first, second) = normal_pair(&mut rng);
        let factor = (0.92 + 0.06 * first).clamp(0.75, 1.0);
        let brisk = (1.0 + 0.1 * second).clamp(0.7, 1.0);
        let drives = f.direction == Direction::Vehicle;
        let driving = Driving {
            straight_mps: f.taxi_mps.0 * factor,
            turn_mps: f.taxi_mps.1,
            acc_mps2: f.taxi_acc_mps2.0 * brisk,
            dec_mps2: if drives { f.taxi_acc_mps2.1.min(DRIVER_MPS2) } else { f.taxi_acc_mps2.1 },
            jerk_mps3: if drives { DRIVER_MPS3 } else { 0.6 },
            lateral_mps2: 1.2,
        };
        Self {
            flight,
            class: class_of(f.size),
            phase: Phase::Absent,
            driving,
            dry: driving,
            push: Way::default(),
            way: Way::default(),
            stand: f.stand,
            s: 0.0,
            v: 0.0,
            a: 0.0,
            slip: 0.0,
            beside_m: crate::frames::Vector2::new(0.0, 0.0),
            beside_from: 0.0,
            height_m: 0.0,
            climb_mps: 0.0,
            first_held: 0,
            next: 0,
            refused_at: None,
            waits_since_s: None,
            waits_for: None,
            shut_in_since_s: None,
            still_since_s: None,
            still_frames: 0,
            breaks_away_s: 0.0,
            threshold: 0.0,
            touchdown: 0.0,
            flare: landing::Flare::default(),
            braking: 1.2,
            most_mps2: 2.5,
            off_mps2: 1.5,
            off_to_m: 0.0,
            landing_s: f64::NEG_INFINITY,
            cleared: false,
            ready_s: 0.0,
            next_try_s: 0.0,
            parked_pieces: Vec::new(),
            under: 0..0,
            roll_from: usize::MAX,
            line_up_s: 35.0,
            kept: Vec::new(),
            turned: false,
            tow_to: None,
            towed_from: Vec::new(),
            goal: None,
            stands_short_m: 0.0,
            drives: 0,
            timing: Timing::default(),
            granted: Granted::default(),
            insisted: Granted::default(),
            rejects: false,
            lacks_runway: false,
            wants: None,
            holds: false,
            stopped_until_s: f64::NEG_INFINITY,
            taxi_from_s: 0.0,
            measures: Measures::default(),
            stopped: false,
            towed: false,
            cleared_way_m: Vec::new(),
            cleared_arcs: Vec::new(),
            cleared_from_m: None,
            hand: None,
            join: None,
            wander: technical_error::Wander::default(),
            approach: technical_error::Approach::default(),
            hold_gap_m: HOLD_GAP_M[0] + (HOLD_GAP_M[1] - HOLD_GAP_M[0]) * uniform(&mut rng),
        }
    }
}
