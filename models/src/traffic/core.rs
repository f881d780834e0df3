//! The replicated core: the traffic of one airport, stepped frame by frame.
//!
//! Pure: the same flights, seed and frames give the same bits in every process that steps it, so every
//! generator steps all of it and publishes its share. Movers read each other exactly inside; outside
//! everybody sees them through their PDUs.

use super::network::Network;
use super::outline::Size;
use super::pieces::{Class, Pieces};
use super::profile::{stopping, stopping_speed_mps};
use super::runway_roll::{
    Exit, Landing, NAUTICAL_MILE_M, TakeOff, approach_airspeed_mps, approach_time_s, take_off_run,
};
use super::tractrix;
use super::way::{Arcs, Driving, Way};
use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::flight_list::WakeCategory;
use crate::frames::{Azimuth, Vector3, wrap_pi};
use crate::truth::TruthState;
use std::ops::Range;
use std::sync::Arc;

/// Which piece may be taken when it is free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// Only if everybody can finish afterwards, one after the other (banker's algorithm).
    #[default]
    Ordered,
    /// Always: ends in gridlock sooner or later, which is found and named.
    Free,
}

/// Arrival or departure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Lands at its time and taxis to a stand.
    Arrival,
    /// Leaves its stand at its time and takes off.
    Departure,
}

/// One flight of a schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// For messages.
    pub callsign: String,
    /// Size on the ground.
    pub size: Size,
    /// Arrival or departure.
    pub direction: Direction,
    /// Runway, and which end it lands or takes off from (0 or 1).
    pub runway: (usize, usize),
    /// Stand wanted.
    pub stand: usize,
    /// Landing time (threshold) or off-block time, s since the start of the run.
    pub time_s: f64,
    /// Arrival whose aircraft this departure is.
    pub turnaround_of: Option<usize>,
    /// Wake category.
    pub wake: WakeCategory,
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
    /// Stops of 5 s or more off stands.
    pub stops: u32,
    /// Time of these stops, s.
    pub stopped_s: f64,
    /// Off-block to line-up, or runway vacated to in-block, s.
    pub taxi_s: f64,
    /// The same way driven alone, s.
    pub unhindered_s: f64,
    /// Fuel on the ground, kg.
    pub fuel_kg: f64,
    /// Go-arounds.
    pub go_arounds: u32,
}

/// What an input or a finding says, for the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Time, s.
    pub time_s: f64,
    /// One line.
    pub text: String,
}

#[derive(Clone, Debug)]
struct Mover {
    flight: usize,
    class: Class,
    phase: Phase,
    driving: Driving,
    push: Way,
    way: Way,
    stand: usize,
    /// Place of the guided point, speed, acceleration along the way, slip.
    s: f64,
    v: f64,
    a: f64,
    slip: f64,
    height_m: f64,
    climb_mps: f64,
    /// Taken: indices `first_held..next` of the way in use.
    first_held: usize,
    next: usize,
    refused_at: Option<u64>,
    waits_since_s: Option<f64>,
    waits_for: Option<usize>,
    still_since_s: Option<f64>,
    /// Landing: place of the threshold, touchdown and exit on the way; braking.
    threshold: f64,
    touchdown: f64,
    braking: f64,
    landing_s: f64,
    cleared: bool,
    ready_s: f64,
    next_try_s: f64,
    parked_pieces: Vec<u32>,
    taxi_from_s: f64,
    measures: Measures,
}

/// Seconds between attempts of those who could not be given a way or a runway.
const RETRY_S: f64 = 5.0;
const FINAL_M: f64 = 10.0 * NAUTICAL_MILE_M;
/// Gap that is kept ahead of the nose, m, and distance at which the next piece is asked for.
const GAP_M: f64 = 2.0;
const ASK_M: f64 = 15.0;
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
    /// Changes with every release, so that a refusal is asked again only then.
    version: u64,
    /// By runway: last take-off time and wake, last assigned landing time.
    last_take_off: Vec<Option<(f64, WakeCategory)>>,
    last_landing: Vec<f64>,
    crossing: Vec<Vec<usize>>,
    mixed: Vec<bool>,
    /// By runway: who rolls, lands or is lined up.
    owner: Vec<Option<usize>>,
    time_s: f64,
    clearances: Vec<Clearance>,
    remarks: Vec<Remark>,
}

impl Core {
    /// The core at time 0. `step_s`: length of a frame.
    #[must_use]
    pub fn new(
        net: Arc<Network>,
        pieces: Arc<Pieces>,
        flights: Arc<Vec<Flight>>,
        policy: Policy,
        seed: u64,
        step_s: f64,
    ) -> Self {
        let arcs = Arc::new(Arcs::of(&net));
        let count = net.runways.len();
        let shared = |a: usize, b: usize| {
            let spine = |r: usize| net.runways[r].spine.iter().map(|(_, n)| *n);
            a == b || spine(a).any(|n| spine(b).any(|m| m == n))
        };
        let crossing = (0..count)
            .map(|a| (0..count).filter(|b| shared(a, *b)).collect())
            .collect::<Vec<Vec<usize>>>();
        let of = |direction: Direction, r: usize| {
            flights.iter().any(|f| f.direction == direction && f.runway.0 == r)
        };
        let mixed =
            (0..count).map(|r| crossing[r].iter().any(|c| of(Direction::Departure, *c))).collect();
        let movers = (0..flights.len()).map(|f| Mover::of(f, &flights[f], seed)).collect();
        let all = pieces.list.len();
        let mut core = Self {
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
            version: 0,
            last_take_off: vec![None; count],
            last_landing: vec![f64::NEG_INFINITY; count],
            crossing,
            mixed,
            owner: vec![None; count],
            time_s: 0.0,
            clearances: Vec::new(),
            remarks: Vec::new(),
        };
        core.appear();
        core
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
        let whole = (self.time_s / RETRY_S).fract() < self.step_s / RETRY_S * 0.999;
        if whole {
            self.appear();
        }
        for m in 0..self.movers.len() {
            match self.movers[m].phase {
                Phase::Absent | Phase::Docked | Phase::Gone => {}
                Phase::Parked => self.parked(m),
                Phase::Starting(until) => {
                    if self.time_s >= until {
                        self.start_taxi(m);
                    }
                }
                Phase::Pushing => self.pushing(m),
                Phase::Taxiing => self.taxiing(m),
                Phase::LinedUp(until) => {
                    if self.time_s >= until && self.may_roll(m) {
                        self.movers[m].phase = Phase::Rolling;
                        self.clear(m, "TOF", self.end_name(m));
                        let (r, wake) = (self.flights[m].runway.0, self.flights[m].wake);
                        self.last_take_off[r] = Some((self.time_s, wake));
                    }
                }
                Phase::Rolling => self.rolling(m),
                Phase::Final => self.on_final(m),
                Phase::GoAround => self.going_around(m),
                Phase::Landing => self.landing(m),
            }
            self.count(m);
        }
        if self.policy == Policy::Free && whole {
            self.find_deadlock();
        }
    }

    /// State of a flight at the frame executed last; `None` while it is not in the run.
    #[must_use]
    pub fn state(&self, flight: usize) -> Option<TruthState> {
        let m = self.movers.get(flight)?;
        let f = &self.flights[flight];
        let guided = 0.4 * f.size.length_m;
        let gear = guided - f.wheelbase_m;
        if matches!(m.phase, Phase::Absent | Phase::Gone) {
            return None;
        }
        let pushing = matches!(m.phase, Phase::Parked | Phase::Pushing);
        let stands_on = if pushing && !m.push.pieces.is_empty() { &m.push } else { &m.way };
        if stands_on.pieces.is_empty() {
            // On its stand, without a way yet.
            let (at, heading_rad) = self.stand_pose(m.stand);
            return Some(still(Vector3::new(at.x, at.y, 0.0), heading_rad));
        }
        let on = stands_on.path.at(m.s);
        let (heading, turn_rate, along, push) = if pushing {
            (wrap_pi(on.heading_rad + std::f64::consts::PI), m.v * on.curvature, -m.v, true)
        } else {
            let heading = wrap_pi(on.heading_rad - m.slip);
            let cos = libm::cos(m.slip);
            (heading, m.v * libm::sin(m.slip) / f.wheelbase_m, m.v * cos, false)
        };
        let (sin, cos) = libm::sincos(heading);
        let (u, n) = (nalgebra::Vector2::new(sin, cos), nalgebra::Vector2::new(cos, -sin));
        let middle = if push { on.at_m - u * gear } else { on.at_m - u * guided };
        let velocity = u * along - n * (gear * turn_rate);
        let along_acc = if push {
            -m.a
        } else {
            let slip_rate = m.v * (on.curvature - libm::sin(m.slip) / f.wheelbase_m);
            m.a * libm::cos(m.slip) - m.v * libm::sin(m.slip) * slip_rate
        };
        let acceleration = u * (along_acc + gear * turn_rate * turn_rate) + n * (along * turn_rate);
        let still = m.v == 0.0 && m.a == 0.0;
        let zero = nalgebra::Vector2::zeros();
        let (velocity, acceleration) = if still { (zero, zero) } else { (velocity, acceleration) };
        let pitch_rad =
            if m.height_m > 0.0 && m.v > 1.0 { libm::atan2(m.climb_mps, m.v) } else { 0.0 };
        Some(TruthState {
            position_m: Vector3::new(middle.x, middle.y, m.height_m),
            velocity_mps: Vector3::new(
                velocity.x,
                velocity.y,
                if still { 0.0 } else { m.climb_mps },
            ),
            acceleration_ms2: Vector3::new(acceleration.x, acceleration.y, 0.0),
            heading_rad: heading,
            pitch_rad,
            roll_rad: 0.0,
            angular_rate_rads: Vector3::new(0.0, 0.0, if still { 0.0 } else { turn_rate }),
        })
    }

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
        };
        self.movers.iter().filter(done).count()
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

    /// Flights of the core.
    #[must_use]
    pub fn flights(&self) -> &[Flight] {
        &self.flights
    }

    /// Why a flight waits: "for KLM123", or `None` while it does not.
    #[must_use]
    pub fn waits_for(&self, flight: usize) -> Option<&str> {
        let m = &self.movers[flight];
        m.waits_since_s?;
        m.waits_for.map(|o| self.flights[o].callsign.as_str())
    }

    /// 64-bit digest of the state (FNV-1a over the bits of every mover).
    #[must_use]
    pub fn digest(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut feed = |value: u64| {
            for octet in value.to_le_bytes() {
                hash = (hash ^ u64::from(octet)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        for m in &self.movers {
            let phase = match m.phase {
                Phase::Absent => 0,
                Phase::Parked => 1,
                Phase::Pushing => 2,
                Phase::Starting(_) => 3,
                Phase::Taxiing => 4,
                Phase::LinedUp(_) => 5,
                Phase::Rolling => 6,
                Phase::Final => 7,
                Phase::GoAround => 8,
                Phase::Landing => 9,
                Phase::Docked => 10,
                Phase::Gone => 11,
            };
            feed(phase);
            feed(m.stand as u64);
            feed((m.first_held as u64) << 32 | m.next as u64);
            [m.s, m.v, m.a, m.slip, m.height_m].iter().for_each(|x| feed(x.to_bits()));
        }
        hash
    }

    fn stand_pose(&self, stand: usize) -> (nalgebra::Vector2<f64>, f64) {
        let s = &self.net.stands[stand];
        let Some(node) = s.node else { return (s.at_m, s.heading_rad) };
        let into = self.stand_arc(node);
        let heading = into.map_or(s.heading_rad, |arc| self.arcs.heading_rad(arc));
        (self.net.nodes[node].at_m, heading)
    }

    /// The arc by which a stand is entered.
    fn stand_arc(&self, node: usize) -> Option<usize> {
        let edges = self.net.edges.iter().enumerate();
        let mut arcs = edges.filter_map(|(e, edge)| {
            let used = edge.nodes.iter().all(|n| self.net.nodes[*n].used);
            if edge.nodes[1] == node && used {
                Some(2 * e)
            } else if edge.nodes[0] == node && edge.two_way && used {
                Some(2 * e + 1)
            } else {
                None
            }
        });
        arcs.next()
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
        let (flight, from_s) = (self.movers[m].flight, self.time_s);
        self.clearances.push(Clearance { flight, kind, runway, from_s, until_s: None });
    }

    fn end_clearance(&mut self, m: usize, kind: &'static str) {
        let (flight, now) = (self.movers[m].flight, self.time_s);
        let open = self.clearances.iter_mut().rev();
        if let Some(c) =
            open.filter(|c| c.flight == flight).find(|c| c.kind == kind && c.until_s.is_none())
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

    // ---- tokens ------------------------------------------------------------------------------------

    /// Somebody else who holds a piece that conflicts with `piece` for `m`, or rolls beside it.
    fn blocker(&self, m: usize, piece: u32, roll: bool, gone: &[bool]) -> Option<usize> {
        let here = |h: &u32| *h as usize != m && !gone.get(*h as usize).copied().unwrap_or(false);
        for (other, least) in self.pieces.conflicts(piece as usize, self.movers[m].class) {
            let holds = |h: &&u32| here(h) && self.movers[**h as usize].class >= *least;
            if let Some(holder) = self.holders[*other as usize].iter().find(holds) {
                return Some(*holder as usize);
            }
        }
        if let Some(roller) = self.rolls[piece as usize].iter().find(|h| here(h)) {
            return Some(*roller as usize);
        }
        if roll {
            for beside in self.pieces.strip_beside(piece as usize) {
                if let Some(holder) = self.holders[*beside as usize].iter().find(|h| here(h)) {
                    return Some(*holder as usize);
                }
            }
        }
        None
    }

    fn hold(&mut self, m: usize, piece: u32, roll: bool) {
        self.holders[piece as usize].push(m as u32);
        if roll {
            for i in 0..self.pieces.strip_beside(piece as usize).len() {
                let beside = self.pieces.strip_beside(piece as usize)[i];
                self.rolls[beside as usize].push(m as u32);
            }
        }
    }

    fn release(&mut self, m: usize, piece: u32, roll: bool) {
        let drop_one = |list: &mut Vec<u32>| {
            if let Some(at) = list.iter().position(|h| *h as usize == m) {
                list.remove(at);
            }
        };
        drop_one(&mut self.holders[piece as usize]);
        if roll {
            for i in 0..self.pieces.strip_beside(piece as usize).len() {
                let beside = self.pieces.strip_beside(piece as usize)[i];
                drop_one(&mut self.rolls[beside as usize]);
            }
        }
        self.version += 1;
    }

    fn active(&self, m: usize) -> bool {
        match self.movers[m].phase {
            Phase::Pushing
            | Phase::Starting(_)
            | Phase::Taxiing
            | Phase::LinedUp(_)
            | Phase::Rolling
            | Phase::Landing => true,
            // From its landing clearance on it holds the runway.
            Phase::Final => self.movers[m].cleared,
            _ => false,
        }
    }

    /// Whether what is left of a mover's way, from `push_from` and `from` on, is free of what the others hold
    /// after each has driven as far as what it holds already lets it.
    fn rest_is_free(
        &self,
        m: usize,
        (push_from, from): (usize, usize),
        gone: &[bool],
        ends: &[Option<Range<usize>>],
    ) -> bool {
        let mover = &self.movers[m];
        let push = mover.push.pieces.iter().skip(push_from);
        let mut rest = push.chain(mover.way.pieces.iter().skip(from));
        rest.all(|piece| {
            let conflicts = self.pieces.conflicts(*piece as usize, mover.class);
            conflicts.iter().all(|(other, least)| {
                !self.holders[*other as usize].iter().any(|h| {
                    let h = *h as usize;
                    h != m
                        && !gone[h]
                        && self.movers[h].class >= *least
                        && ends[h].as_ref().is_none_or(|range| {
                            self.movers[h].way.pieces[range.clone()].contains(other)
                        })
                })
            })
        })
    }

    /// What a mover that has taken its way up to `next` still holds when it has driven there: indices of its
    /// way; `None` where everything that it holds counts (parked, pushed back).
    fn held_at_end(&self, m: usize, next: usize) -> Option<Range<usize>> {
        let mover = &self.movers[m];
        let on_way = match mover.phase {
            Phase::Starting(_)
            | Phase::Taxiing
            | Phase::LinedUp(_)
            | Phase::Rolling
            | Phase::Landing => true,
            Phase::Final => mover.cleared,
            _ => false,
        };
        if !on_way || next == 0 {
            return None;
        }
        let length = self.flights[m].size.length_m;
        if next >= mover.way.pieces.len() {
            if self.flights[m].direction == Direction::Departure {
                return Some(0..0);
            }
            let tail = mover.way.stop_m - 0.95 * length - TAIL_M;
            return Some(mover.way.ends_m.partition_point(|e| *e < tail)..next);
        }
        let tail = mover.way.ends_m[next - 1] - GAP_M - 0.1 * length - 0.95 * length - TAIL_M;
        Some(mover.way.ends_m[..next].partition_point(|e| *e < tail)..next)
    }

    fn first_untaken(&self, m: usize) -> (usize, usize) {
        let mover = &self.movers[m];
        match mover.phase {
            Phase::Parked => (0, 0),
            Phase::Pushing => (mover.push.pieces.len(), 0),
            _ => (mover.push.pieces.len(), mover.next),
        }
    }

    /// Whether everybody can finish, one after the other, while the rest stand where they are; `m` counts as
    /// active with `push_from` and `from` as first pieces that it does not hold.
    fn ordered(&self, m: usize, push_from: usize, from: usize) -> bool {
        let count = self.movers.len();
        let ends: Vec<Option<Range<usize>>> = (0..count)
            .map(|o| self.held_at_end(o, if o == m { from } else { self.movers[o].next }))
            .collect();
        let mut gone = vec![false; count];
        if self.rest_is_free(m, (push_from, from), &gone, &ends) {
            return true;
        }
        let mut left: Vec<usize> = (0..count).filter(|o| *o != m && self.active(*o)).collect();
        left.push(m);
        loop {
            let before = left.len();
            left.retain(|o| {
                let from = if *o == m { (push_from, from) } else { self.first_untaken(*o) };
                let free = self.rest_is_free(*o, from, &gone, &ends);
                gone[*o] |= free;
                !free
            });
            if left.is_empty() {
                return true;
            }
            if left.len() == before {
                return false;
            }
        }
    }

    /// Takes the group that begins at `next` of the way in use, if all of it is free and the policy agrees.
    fn take(&mut self, m: usize) -> bool {
        let mover = &self.movers[m];
        if mover.refused_at == Some(self.version) {
            return false;
        }
        let first = mover.next;
        let Some(last) = mover.way.group_last.get(first).copied() else { return false };
        let roll = mover.way.roll.clone();
        let group: Vec<(u32, bool)> =
            (first..=last).map(|i| (mover.way.pieces[i], roll.contains(&i))).collect();
        let blocker = group.iter().find_map(|(z, r)| self.blocker(m, *z, *r, &[]));
        if let Some(blocker) = blocker {
            return self.refuse(m, Some(blocker));
        }
        group.iter().for_each(|(z, r)| self.hold(m, *z, *r));
        if self.policy == Policy::Ordered
            && !self.ordered(m, self.movers[m].push.pieces.len(), last + 1)
        {
            group.iter().for_each(|(z, r)| self.release_quietly(m, *z, *r));
            return self.refuse(m, None);
        }
        self.movers[m].next = last + 1;
        self.movers[m].waits_since_s = None;
        self.movers[m].waits_for = None;
        let crossed = self.movers[m]
            .way
            .crossings
            .iter()
            .find(|(i, _)| (first..=last).contains(i))
            .map(|(_, r)| *r);
        if let Some(r) = crossed {
            self.end_clearance(m, "CRO");
            self.clear(m, "CRO", self.net.runways[r].names.join("/"));
        }
        true
    }

    fn release_quietly(&mut self, m: usize, piece: u32, roll: bool) {
        let version = self.version;
        self.release(m, piece, roll);
        self.version = version;
    }

    fn refuse(&mut self, m: usize, blocker: Option<usize>) -> bool {
        let (version, now) = (self.version, self.time_s);
        let mover = &mut self.movers[m];
        mover.refused_at = Some(version);
        mover.waits_since_s.get_or_insert(now);
        mover.waits_for = blocker;
        false
    }

    /// Waits for each other in a ring, each for more than 30 s: said once, by name.
    fn find_deadlock(&mut self) {
        let waits = |m: usize| -> Option<usize> {
            let mover = &self.movers[m];
            (self.time_s - mover.waits_since_s? >= 30.0).then_some(mover.waits_for?)
        };
        let mut found: Vec<String> = Vec::new();
        for start in 0..self.movers.len() {
            let (mut at, mut ring) = (start, vec![start]);
            while let Some(next) = waits(at) {
                if next == start {
                    if ring.iter().min() == Some(&start) {
                        let names: Vec<&str> =
                            ring.iter().map(|m| self.flights[*m].callsign.as_str()).collect();
                        let text = format!("deadlock: {} wait for each other", names.join(", "));
                        found.push(text);
                    }
                    break;
                }
                if ring.contains(&next) {
                    break;
                }
                ring.push(next);
                at = next;
            }
        }
        for text in found {
            if !self.remarks.iter().any(|r| r.text == text) {
                self.remark(text);
            }
        }
    }

    // ---- stands ------------------------------------------------------------------------------------

    /// Pieces under an aircraft on a stand.
    fn pieces_of_stand(&self, stand: usize, size: Size) -> Vec<u32> {
        let Some(mut arc) = self.net.stands[stand].node.and_then(|n| self.stand_arc(n)) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        let mut room = 0.5 * size.length_m + 1.0;
        loop {
            let (first, count) = self.pieces.of_edge[arc / 2];
            for i in 0..count {
                let z = if arc % 2 == 0 { first + count - 1 - i } else { first + i };
                let piece = &self.pieces.list[z];
                found.push(z as u32);
                room -= piece.to_m - piece.from_m;
                if room <= 0.0 {
                    return found;
                }
            }
            // Longer than its lead-in: the straightest edge behind it.
            let node = Arcs::from(&self.net, arc);
            let behind = (0..self.net.edges.len()).flat_map(|e| [2 * e, 2 * e + 1]).filter(|b| {
                Arcs::to(&self.net, *b) == node
                    && b / 2 != arc / 2
                    && self.arcs.turn_rad(*b, arc) < 1.6
            });
            let straightest = behind
                .min_by(|p, q| self.arcs.turn_rad(*p, arc).total_cmp(&self.arcs.turn_rad(*q, arc)));
            match straightest {
                Some(next) if found.len() < 64 => arc = next,
                _ => return found,
            }
        }
    }

    /// Whether somebody of this class could stand there: nobody there or beside, nobody's way over it,
    /// nobody else on his way to it.
    fn stand_is_free(&self, m: usize, stand: usize, pieces: &[u32]) -> bool {
        if pieces.is_empty() || pieces.iter().any(|z| self.blocker(m, *z, false, &[]).is_some()) {
            return false;
        }
        let touches = |other: usize, z: u32| {
            let class = self.movers[other].class;
            pieces.iter().any(|p| {
                self.pieces
                    .conflicts(*p as usize, self.movers[m].class)
                    .iter()
                    .any(|(o, least)| *o == z && class >= *least)
            })
        };
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let coming = matches!(other.phase, Phase::Final | Phase::Landing)
                || (other.phase == Phase::Taxiing
                    && self.flights[o].direction == Direction::Arrival);
            if coming
                && (other.stand == stand || other.parked_pieces.iter().any(|z| touches(o, *z)))
            {
                return false;
            }
            if self.active(o) {
                let (p, w) = self.first_untaken(o);
                let rest = other.push.pieces.iter().skip(p).chain(other.way.pieces.iter().skip(w));
                if rest.into_iter().any(|z| touches(o, *z)) {
                    return false;
                }
            }
        }
        true
    }

    /// Free stands for a flight, best first, at most `most`: the wanted one, else the smallest that are large
    /// enough, nearest to it.
    fn free_stands(&self, m: usize, most: usize) -> Vec<(usize, Vec<u32>)> {
        let f = &self.flights[m];
        let mut found = Vec::new();
        let wanted = self.pieces_of_stand(f.stand, f.size);
        if self.stand_is_free(m, f.stand, &wanted) {
            found.push((f.stand, wanted));
        }
        let need = class_of(f.size).saturating_sub(1);
        let at = self.net.stands[f.stand].at_m;
        let mut others: Vec<usize> = (0..self.net.stands.len())
            .filter(|s| {
                let stand = &self.net.stands[*s];
                *s != f.stand
                    && stand.code >= need
                    && stand.node.is_some_and(|n| self.net.nodes[n].used)
            })
            .collect();
        others.sort_by(|a, b| {
            let key = |s: usize| (self.net.stands[s].code, (self.net.stands[s].at_m - at).norm());
            let ((ca, da), (cb, db)) = (key(*a), key(*b));
            ca.cmp(&cb).then(da.total_cmp(&db)).then(a.cmp(b))
        });
        for s in others {
            if found.len() >= most {
                break;
            }
            let pieces = self.pieces_of_stand(s, f.size);
            if self.stand_is_free(m, s, &pieces) {
                found.push((s, pieces));
            }
        }
        found.truncate(most);
        found
    }

    fn free_stand(&self, m: usize) -> Option<(usize, Vec<u32>)> {
        self.free_stands(m, 1).pop()
    }

    /// Who comes into the run: departures on their stands, arrivals on final.
    fn appear(&mut self) {
        for m in 0..self.movers.len() {
            if self.movers[m].phase != Phase::Absent || self.movers[m].next_try_s > self.time_s {
                continue;
            }
            let flights = Arc::clone(&self.flights);
            let f = &flights[m];
            match f.direction {
                Direction::Departure => self.appear_on_stand(m, f),
                Direction::Arrival => self.appear_on_final(m, f),
            }
        }
    }

    fn appear_on_stand(&mut self, m: usize, f: &Flight) {
        // The aircraft of a turn-round becomes the departure when it is due.
        if let Some(arrival) = f.turnaround_of {
            let docked = self.movers[arrival].phase == Phase::Docked;
            let rested =
                self.movers[arrival].measures.aibt_s.is_some_and(|t| self.time_s >= t + 300.0);
            if docked && rested && self.time_s >= f.time_s - 60.0 {
                let stand = self.movers[arrival].stand;
                self.leave_stand(arrival);
                self.park(m, stand);
            }
            return;
        }
        if self.time_s < f.time_s - 1800.0 && self.time_s > 0.0 {
            return;
        }
        let wanted = self.pieces_of_stand(f.stand, f.size);
        if !self.stand_is_free(m, f.stand, &wanted) {
            // An aircraft there that nobody needs any more is taken for this one.
            let idle = (0..self.movers.len()).find(|o| {
                self.movers[*o].phase == Phase::Docked
                    && self.movers[*o].stand == f.stand
                    && !self.flights.iter().any(|g| g.turnaround_of == Some(*o))
            });
            match idle {
                Some(idle) if self.time_s >= f.time_s - 600.0 => {
                    self.leave_stand(idle);
                    if !self.stand_is_free(m, f.stand, &wanted) {
                        return;
                    }
                }
                _ if self.time_s < f.time_s => return,
                _ => {
                    if let Some((stand, _)) = self.free_stand(m) {
                        let text = format!(
                            "{}: stand {} is not free, at {} instead",
                            f.callsign, self.net.stands[f.stand].name, self.net.stands[stand].name
                        );
                        self.remark(text);
                        self.park(m, stand);
                    }
                    return;
                }
            }
        }
        self.park(m, f.stand);
    }

    fn park(&mut self, m: usize, stand: usize) {
        let pieces = self.pieces_of_stand(stand, self.flights[m].size);
        pieces.iter().for_each(|z| self.hold(m, *z, false));
        let mover = &mut self.movers[m];
        mover.stand = stand;
        mover.parked_pieces = pieces;
        mover.phase = Phase::Parked;
        mover.next_try_s = 0.0;
    }

    fn leave_stand(&mut self, m: usize) {
        let pieces = std::mem::take(&mut self.movers[m].parked_pieces);
        pieces.iter().for_each(|z| self.release(m, *z, false));
        self.movers[m].phase = Phase::Gone;
    }

    // ---- departures --------------------------------------------------------------------------------

    /// Edges that a mover cannot use: too narrow, or under somebody who stands for long.
    fn closed(&self, m: usize) -> Vec<bool> {
        let class = self.movers[m].class;
        let mut closed: Vec<bool> = self.net.edges.iter().map(|e| class > e.code + 1).collect();
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let stands = matches!(other.phase, Phase::Parked | Phase::Docked);
            let promised = matches!(other.phase, Phase::Final | Phase::Landing | Phase::Taxiing);
            if !(stands || promised) {
                continue;
            }
            for z in &other.parked_pieces {
                for (y, least) in self.pieces.conflicts(*z as usize, other.class) {
                    if class >= *least {
                        closed[self.pieces.list[*y as usize].edge] = true;
                    }
                }
            }
        }
        closed
    }

    /// Arcs that others who are under way will use the other way round: dear to meet them there.
    fn opposed(&self, m: usize) -> Vec<bool> {
        let mut opposed = vec![false; 2 * self.net.edges.len()];
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            if self.active(o) || self.movers[o].phase == Phase::Final {
                self.movers[o].way.arcs.iter().for_each(|a| opposed[a ^ 1] = true);
            }
        }
        opposed
    }

    fn parked(&mut self, m: usize) {
        let f = &self.flights[m];
        if self.time_s < f.time_s || self.time_s < self.movers[m].next_try_s {
            return;
        }
        self.movers[m].next_try_s = self.time_s + RETRY_S;
        if self.movers[m].push.pieces.is_empty() && !self.plan_departure(m) {
            if self.movers[m].waits_since_s.is_none() {
                let text = format!(
                    "{}: no way from stand {} to runway {} now",
                    self.flights[m].callsign,
                    self.net.stands[self.movers[m].stand].name,
                    self.end_name(m)
                );
                self.remark(text);
            }
            let now = self.time_s;
            self.movers[m].waits_since_s.get_or_insert(now);
            self.movers[m].next_try_s = now + 30.0;
            return;
        }
        // All pieces of the pushback at once.
        let group: Vec<u32> = self.movers[m].push.pieces.clone();
        let blocker = group.iter().find_map(|z| self.blocker(m, *z, false, &[]));
        let mut free = blocker.is_none();
        if free {
            group.iter().for_each(|z| self.hold(m, *z, false));
            if self.policy == Policy::Ordered && !self.ordered(m, group.len(), 0) {
                group.iter().for_each(|z| self.release_quietly(m, *z, false));
                free = false;
            }
        }
        if !free {
            // The way was made for a world that has changed: made anew next time.
            self.movers[m].push = Way::default();
            self.movers[m].way = Way::default();
            self.movers[m].waits_for = blocker;
            return;
        }
        let parked = std::mem::take(&mut self.movers[m].parked_pieces);
        parked.iter().for_each(|z| self.release(m, *z, false));
        let now = self.time_s;
        let guided = 0.4 * self.flights[m].size.length_m;
        let mover = &mut self.movers[m];
        mover.phase = Phase::Pushing;
        mover.measures.aobt_s = Some(now);
        mover.waits_since_s = None;
        mover.s = PUSH_BEFORE_M - (guided - self.flights[m].wheelbase_m);
        self.clear(m, "PSH", String::new());
    }

    /// Pushback and way to the runway.
    fn plan_departure(&mut self, m: usize) -> bool {
        let f = self.flights[m].clone();
        let net = Arc::clone(&self.net);
        let Some(into) = net.stands[self.movers[m].stand].node.and_then(|n| self.stand_arc(n))
        else {
            return false;
        };
        let mut closed = self.closed(m);
        closed[into / 2] = false;
        // Back along the lead-in to where it joins a lane.
        let mut back = vec![into ^ 1];
        loop {
            let node = Arcs::to(&net, back[back.len() - 1]);
            let on: Vec<usize> = (0..net.edges.len())
                .filter(|e| net.edges[*e].nodes.contains(&node) && *e != back[back.len() - 1] / 2)
                .collect();
            if on.len() == 1 && back.len() < 30 && net.nodes[node].stand.is_none() {
                back.push(if net.edges[on[0]].nodes[0] == node {
                    2 * on[0]
                } else {
                    2 * on[0] + 1
                });
            } else {
                break;
            }
        }
        let lane_node = Arcs::to(&net, back[back.len() - 1]);
        let last = back[back.len() - 1];
        let (r, end) = f.runway;
        // Entries with enough runway ahead, the longest run first choice by time.
        let runway = &net.runways[r];
        let run_ahead = |node: usize| {
            let place = runway.spine.iter().find(|(_, n)| *n == node).map_or(0.0, |(p, _)| *p);
            if end == 0 { runway.length_m - place } else { place }
        };
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let entry = |arc: usize| {
            let edge = &net.edges[arc / 2];
            let node = Arcs::to(&net, arc);
            let turn = wrap_pi(direction - self.arcs.heading_rad(arc)).abs();
            (edge.strip == Some(r)
                && edge.runway.is_none()
                && runway.spine.iter().any(|(_, n)| *n == node)
                && turn < 2.1)
                .then(|| run_ahead(node))
        };
        let longest = (0..2 * net.edges.len()).filter_map(entry).fold(0.0, f64::max);
        let needed =
            (1.15 * f.take_off.1 + 100.0).min(longest).max((runway.length_m - 300.0).min(longest));
        let needed_again = (1.15 * f.take_off.1 + 100.0).min(longest);
        let length = f.size.length_m;
        let mut options: Vec<(Vec<usize>, f64)> = Vec::new();
        // Back onto a lane that leads to the way; if there is none, against a one-way lane.
        for lenient in [false, true] {
            if !options.is_empty() {
                break;
            }

            for e in (0..net.edges.len())
                .filter(|e| net.edges[*e].nodes.contains(&lane_node) && *e != last / 2)
            {
                let mut chain =
                    vec![if net.edges[e].nodes[0] == lane_node { 2 * e } else { 2 * e + 1 }];
                let turn = self.arcs.turn_rad(last, chain[0]);
                let usable = |a: usize| {
                    let edge = &net.edges[a / 2];
                    !closed[a / 2]
                        && edge.strip.is_none()
                        && edge.runway.is_none()
                        && edge
                            .nodes
                            .iter()
                            .all(|n| net.nodes[*n].used && net.nodes[*n].stand.is_none())
                        && (lenient || edge.two_way || a % 2 == 1)
                };
                if turn > 2.1 || !usable(chain[0]) {
                    continue;
                }
                let need = 1.0 * length + 25.0 * libm::tan(0.5 * turn.min(2.0)) + 12.0;
                let mut have = self.arcs.length_m(chain[0]);
                while have < need && chain.len() < 20 {
                    let at = chain[chain.len() - 1];
                    let node = Arcs::to(&net, at);
                    let next = (0..net.edges.len())
                        .filter(|e| net.edges[*e].nodes.contains(&node) && *e != at / 2)
                        .map(|e| if net.edges[e].nodes[0] == node { 2 * e } else { 2 * e + 1 })
                        .filter(|a| {
                            usable(*a)
                                && self.arcs.turn_rad(at, *a) < if lenient { 1.2 } else { 0.7 }
                        })
                        .min_by(|p, q| {
                            self.arcs.turn_rad(at, *p).total_cmp(&self.arcs.turn_rad(at, *q))
                        });
                    let Some(next) = next else { break };
                    have += self.arcs.length_m(next);
                    chain.push(next);
                }
                if have >= need {
                    options.push((chain, turn));
                }
            }
        }
        let opposed = self.opposed(m);
        let mut best: Option<(f64, Vec<usize>, Vec<usize>)> = None;
        for (chain, _) in &options {
            let start = chain[0] ^ 1;
            for least in [needed, needed_again] {
                let goal = |arc: usize| entry(arc).is_some_and(|run| run >= least - 1.0);
                let is_closed = |e: usize| {
                    (closed[e] && e != start / 2) || e == last / 2 || net.edges[e].runway == Some(r)
                };
                if let Some(found) =
                    self.arcs.quickest(&net, &[(start, 0.0)], goal, is_closed, |a| opposed[a])
                {
                    if best.as_ref().is_none_or(|b| found.time_s < b.0) {
                        best = Some((found.time_s, chain.clone(), found.arcs));
                    }
                    break;
                }
            }
        }
        let Some((_, chain, taxi)) = best else {
            if self.movers[m].waits_since_s.is_none() {
                let text = format!(
                    "{}: {} ways to push back, lead-in of {} edges",
                    f.callsign,
                    options.len(),
                    back.len()
                );
                self.remark(text);
            }
            return false;
        };
        let class = self.movers[m].class;
        let push_arcs: Vec<usize> = back.iter().chain(&chain).copied().collect();
        let mut push = Way::over(&net, &self.pieces, &push_arcs, class, (PUSH_BEFORE_M, 0.0), 0.0);
        // The nose wheel ends 2 m beyond the fillet of lead-in and lane.
        let lane_place = (0..back.len()).map(|k| self.pieces.of_edge[back[k] / 2].1).sum::<usize>();
        let corner = push.ends_m[lane_place - 1];
        let fillet =
            push.path.arcs().find(|(from, to, _)| *from <= corner + 0.1 && *to >= corner - 0.1);
        push.stop_m = fillet.map_or(corner, |a| a.1) + f.wheelbase_m + 2.0;
        let tail = push.stop_m + (0.9 * length - f.wheelbase_m) + TAIL_M;
        let needed_pieces =
            push.ends_m.iter().position(|e| *e >= tail).unwrap_or(push.ends_m.len() - 1);
        push.pieces.truncate(needed_pieces + 1);
        push.ends_m.truncate(needed_pieces + 1);
        let driving = Driving {
            straight_mps: 1.5,
            turn_mps: 1.5,
            acc_mps2: 0.2,
            dec_mps2: 0.2,
            jerk_mps3: 0.3,
            lateral_mps2: 0.5,
        };
        push.limit(&net, &self.pieces, &driving, 0.0, 1.0);
        // Taxi: from the far end of the pushback over the lane node to the entry, then along the runway.
        let mut arcs: Vec<usize> = chain.iter().rev().map(|a| a ^ 1).collect();
        let skipped: f64 = chain.iter().map(|a| self.arcs.length_m(*a)).sum();
        arcs.extend(taxi.iter().skip(1));
        let line_up_node = Arcs::to(&net, arcs[arcs.len() - 1]);
        let before_runway = arcs.len();
        let at = runway.spine.iter().position(|(_, n)| *n == line_up_node).unwrap_or(0);
        let ahead: Vec<usize> = if end == 0 {
            runway.spine[at..].windows(2).filter_map(|w| self.arc_between(w[0].1, w[1].1)).collect()
        } else {
            runway.spine[..=at]
                .windows(2)
                .rev()
                .filter_map(|w| self.arc_between(w[1].1, w[0].1))
                .collect()
        };
        if ahead.is_empty() {
            return false;
        }
        arcs.extend(ahead);
        let mut way = Way::over(&net, &self.pieces, &arcs, class, (0.0, 3000.0), 0.0);
        let pieces_before: usize =
            arcs[..before_runway].iter().map(|a| self.pieces.of_edge[a / 2].1).sum();
        let total = way.pieces.len();
        way.roll = pieces_before..total;
        let mut first_strip = pieces_before;
        while first_strip > 0
            && self.pieces.list[way.pieces[first_strip - 1] as usize].strip == Some(r)
        {
            first_strip -= 1;
        }
        way.group_crossings(&self.pieces, length + 10.0, first_strip..total);
        way.group(first_strip, total - 1);
        let joined = way.ends_m[pieces_before - 1];
        let turned = way
            .path
            .arcs()
            .find(|a| a.0 <= joined + 0.1 && a.1 >= joined - 0.1)
            .map_or(joined, |a| a.1);
        way.stop_m = (turned + 0.8 * length).min(way.ends_m[total - 1]);
        let driving = self.movers[m].driving;
        way.limit(&net, &self.pieces, &driving, 0.0, 1.0);
        // The nose stands `wheelbase` before the gear's place, seen from the far end of the chain.
        let pushed = push.stop_m - corner;
        let start = (skipped - pushed) + f.wheelbase_m;
        let mover = &mut self.movers[m];
        mover.measures.unhindered_s =
            240.0 + way.unhindered_s(start.max(0.0), way.stop_m, &driving);
        mover.push = push;
        mover.way = way;
        mover.threshold = first_strip as f64;
        true
    }

    fn arc_between(&self, from: usize, to: usize) -> Option<usize> {
        self.arcs.leaving(from).iter().copied().find(|a| Arcs::to(&self.net, *a) == to)
    }

    fn pushing(&mut self, m: usize) {
        let mover = &mut self.movers[m];
        let (s, v, a) = (mover.s, mover.v, mover.a);
        let stop = mover.push.stop_m;
        let wish = mover.push.most_mps(s).min(stopping_speed_mps(stop - s, 0.2, Some(0.3)));
        let limits = Tick { acc: 0.2, dec: 0.25, jerk: 0.3, dt: self.step_s };
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, stop);
        if mover.v == 0.0 && stop - mover.s < 0.5 {
            let now = self.time_s;
            let mut rng = self.rng(m, 2);
            let pause = 90.0 + 30.0 * uniform(&mut rng);
            self.movers[m].phase = Phase::Starting(now + pause);
            self.begin_way_after_push(m);
        }
    }

    /// From the pushback to the taxi way: the same place, seen from the nose wheel.
    fn begin_way_after_push(&mut self, m: usize) {
        let f = &self.flights[m];
        let (wheelbase, length) = (f.wheelbase_m, f.size.length_m);
        let mover = &self.movers[m];
        let gear = mover.push.path.at(mover.s);
        let heading = gear.heading_rad + std::f64::consts::PI;
        let nose = gear.at_m + Azimuth::from_rad(heading).unit() * wheelbase;
        // The nearest place of the way to the nose wheel, near its begin.
        let (mut best, mut at) = (f64::INFINITY, 0.0);
        let mut place = 0.0;
        while place < 400.0 {
            let distance = (mover.way.path.at(place).at_m - nose).norm();
            if distance < best {
                (best, at) = (distance, place);
            }
            place += 0.05;
        }
        let slip = wrap_pi(mover.way.path.at(at).heading_rad - heading);
        let nose_tip = at + 0.1 * length + 1.0;
        let needed = mover.way.ends_m.iter().position(|e| *e >= nose_tip).unwrap_or(0);
        let tail = at - 0.9 * length - TAIL_M;
        let first = mover.way.ends_m.iter().position(|e| *e >= tail).unwrap_or(0);
        let under: Vec<u32> = mover.way.pieces[first..=needed].to_vec();
        let pushed: Vec<u32> = mover.push.pieces.clone();
        under.iter().for_each(|z| self.hold(m, *z, false));
        pushed.iter().for_each(|z| self.release(m, *z, false));
        let mover = &mut self.movers[m];
        (mover.first_held, mover.next) = (first, needed + 1);
        (mover.s, mover.slip) = (at, slip);
        self.end_clearance(m, "PSH");
    }

    fn start_taxi(&mut self, m: usize) {
        self.movers[m].phase = Phase::Taxiing;
        self.movers[m].taxi_from_s = self.time_s;
        self.clear(m, "TAX", String::new());
    }

    /// Whether a departure may go onto the runway now: wake and arrivals.
    fn may_line_up(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        for (o, other) in self.movers.iter().enumerate() {
            let near =
                other.phase == Phase::Final && self.crossing[r].contains(&self.flights[o].runway.0);
            if near && !other.cleared && other.landing_s - self.time_s < 135.0 {
                return false;
            }
        }
        self.wake_left_s(m) < 30.0
    }

    /// Whether a departure of this runway or of one that crosses it will want it soon.
    fn departures_wait(&self, r: usize) -> bool {
        (0..self.movers.len()).any(|m| {
            let f = &self.flights[m];
            let soon = match self.movers[m].phase {
                Phase::Absent | Phase::Parked => (f.time_s - self.time_s).abs() < 300.0,
                Phase::Pushing | Phase::Starting(_) | Phase::Taxiing => true,
                _ => false,
            };
            soon && f.direction == Direction::Departure && self.crossing[r].contains(&f.runway.0)
        })
    }

    /// Whether somebody else has this runway or one that crosses it.
    fn owned(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        self.crossing[r].iter().any(|c| self.owner[*c].is_some_and(|o| o != m))
    }

    /// Off the runway: the next one may have it.
    fn vacate(&mut self, m: usize) {
        for owner in &mut self.owner {
            if *owner == Some(m) {
                *owner = None;
            }
        }
    }

    fn wake_left_s(&self, m: usize) -> f64 {
        let r = self.flights[m].runway.0;
        let behind = self.crossing[r].iter().filter_map(|c| self.last_take_off[*c]);
        let left = behind
            .map(|(time, wake)| time + departure_gap_s(wake, self.flights[m].wake) - self.time_s);
        left.fold(0.0, f64::max)
    }

    fn may_roll(&self, m: usize) -> bool {
        self.wake_left_s(m) <= 0.0
    }

    // ---- on the way --------------------------------------------------------------------------------

    /// One step along the way in use, under the authority.
    fn drive(&mut self, m: usize) {
        let length = self.flights[m].size.length_m;
        let (ahead, behind) = (0.1 * length, 0.95 * length + TAIL_M);
        let d = self.movers[m].driving;
        loop {
            let mover = &self.movers[m];
            let authority = self.authority(m, ahead);
            let needed =
                stopping(mover.v, mover.a.max(0.0), 0.8 * d.dec_mps2, d.jerk_mps3, self.step_s).0
                    + mover.v * self.step_s
                    + ASK_M;
            if mover.next >= mover.way.pieces.len() || needed <= authority - mover.s {
                break;
            }
            let departs = self.flights[m].direction == Direction::Departure
                && mover.next == mover.threshold as usize;
            if departs && (!self.may_line_up(m) || self.owned(m)) {
                let now = self.time_s;
                self.movers[m].waits_since_s.get_or_insert(now);
                break;
            }
            if !self.take(m) {
                break;
            }
            if departs {
                let r = self.flights[m].runway.0;
                self.owner[r] = Some(m);
                self.clear(m, "LUP", self.end_name(m));
            }
        }
        let authority = self.authority(m, ahead);
        let mover = &mut self.movers[m];
        let (s, v, a) = (mover.s, mover.v, mover.a);
        let look = s + 0.4 * v;
        let wish = (0.98 * mover.way.most_mps(s).min(mover.way.most_mps(look)))
            .min(stopping_speed_mps(authority - s, 0.7 * d.dec_mps2, Some(d.jerk_mps3)));
        // Nobody creeps up by centimetres.
        let wish = if v == 0.0 && authority - s < 0.5 { 0.0 } else { wish };
        let limits = Tick { acc: d.acc_mps2, dec: d.dec_mps2, jerk: d.jerk_mps3, dt: self.step_s };
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, authority);
        self.follow(m, s);
        loop {
            let mover = &self.movers[m];
            let i = mover.first_held;
            if i >= mover.next
                || i + 1 >= mover.way.pieces.len()
                || mover.s <= mover.way.ends_m[i] + behind
            {
                break;
            }
            let (z, roll) = (mover.way.pieces[i], mover.way.roll.contains(&i));
            let left_strip = self.pieces.list[z as usize].strip.is_some()
                && self.pieces.list[mover.way.pieces[i + 1] as usize].strip.is_none();
            self.release(m, z, roll);
            self.movers[m].first_held += 1;
            if left_strip {
                self.vacate(m);
                self.end_clearance(m, "CRO");
                self.end_clearance(m, "LND");
            }
        }
    }

    /// Up to where the guided point may go.
    fn authority(&self, m: usize, ahead_m: f64) -> f64 {
        let mover = &self.movers[m];
        if mover.next >= mover.way.pieces.len() {
            return mover.way.stop_m;
        }
        let last = mover.next.checked_sub(1).map_or(0.0, |i| mover.way.ends_m[i]);
        (last - GAP_M - ahead_m).min(mover.way.stop_m)
    }

    /// The main gear is drawn behind.
    fn follow(&mut self, m: usize, from: f64) {
        let wheelbase = self.flights[m].wheelbase_m;
        let mover = &mut self.movers[m];
        let ds = mover.s - from;
        if ds > 0.0 {
            let on = mover.way.path.at(0.5 * (from + mover.s));
            mover.slip = tractrix::stepped_slip_rad(mover.slip, on.curvature, ds, wheelbase);
        }
    }

    fn taxiing(&mut self, m: usize) {
        self.drive(m);
        let mover = &self.movers[m];
        if mover.v != 0.0 || mover.next < mover.way.pieces.len() || mover.way.stop_m - mover.s > 0.6
        {
            return;
        }
        let now = self.time_s;
        if self.flights[m].direction == Direction::Departure {
            let mut rng = self.rng(m, 3);
            let ready = 5.0 + 5.0 * uniform(&mut rng);
            let mover = &mut self.movers[m];
            mover.phase = Phase::LinedUp(now + ready);
            mover.measures.taxi_s = now - mover.measures.aobt_s.unwrap_or(now);
            self.end_clearance(m, "TAX");
            self.end_clearance(m, "LUP");
            return;
        }
        // On its stand: keeps what is under it.
        let size = self.flights[m].size;
        let parked = self.pieces_of_stand(self.movers[m].stand, size);
        parked.iter().for_each(|z| self.hold(m, *z, false));
        let mover = &self.movers[m];
        let held: Vec<(u32, bool)> = (mover.first_held..mover.next)
            .map(|i| (mover.way.pieces[i], mover.way.roll.contains(&i)))
            .collect();
        held.iter().for_each(|(z, r)| self.release(m, *z, *r));
        let mover = &mut self.movers[m];
        mover.parked_pieces = parked;
        mover.phase = Phase::Docked;
        mover.measures.aibt_s = Some(now);
        mover.measures.taxi_s = now - mover.taxi_from_s;
        self.end_clearance(m, "TAX");
    }

    fn rolling(&mut self, m: usize) {
        let f = self.flights[m].clone();
        let day = TakeOff {
            liftoff_mps: f.take_off.0,
            distance_m: f.take_off.1,
            density_ratio: 1.0,
            headwind_mps: 0.0,
            end_ratio: 0.75,
            thrust_exponent: 0.7,
            rolling_friction: 0.02,
        };
        let (a0, b) = take_off_run(&day).map_or((2.0, 0.0), |r| (r.a_mps2, r.b_per_m));
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        let airborne = mover.v >= f.take_off.0;
        let wish = if !airborne {
            (a0 - b * mover.v * mover.v).max(0.3)
        } else if mover.v < f.take_off.0 + 5.0 {
            0.5
        } else {
            0.0
        };
        // Thrust builds up within 5 s.
        let jerk = if airborne { 2.0 } else { 0.2 * a0 };
        let a = wish.clamp(mover.a - 2.0 * dt, mover.a + jerk * dt);
        let from = mover.s;
        mover.s += mover.v * dt + 0.25 * (mover.a + a) * dt * dt;
        mover.v = (mover.v + 0.5 * (mover.a + a) * dt).max(0.0);
        mover.a = a;
        if airborne {
            let climb = (mover.climb_mps + 1.0 * dt).min(10.0);
            mover.height_m += 0.5 * (mover.climb_mps + climb) * dt;
            mover.climb_mps = climb;
        }
        let lifted = airborne && mover.measures.atot_s.is_none();
        let (height, behind) = (mover.height_m, 0.95 * f.size.length_m + TAIL_M);
        self.follow(m, from);
        if lifted {
            self.movers[m].measures.atot_s = Some(self.time_s);
            self.end_clearance(m, "TOF");
        }
        loop {
            let mover = &self.movers[m];
            let i = mover.first_held;
            if i >= mover.next || !(height > 15.0 || mover.s > mover.way.ends_m[i] + behind) {
                break;
            }
            let (z, roll) = (mover.way.pieces[i], mover.way.roll.contains(&i));
            self.release(m, z, roll);
            self.movers[m].first_held += 1;
        }
        if height > 15.0 {
            self.vacate(m);
        }
        if height >= 500.0 {
            self.movers[m].phase = Phase::Gone;
        }
    }

    // ---- arrivals ----------------------------------------------------------------------------------

    fn appear_on_final(&mut self, m: usize, f: &Flight) {
        let Some(time) = approach_time_s(f.landing.0, 0.0, 10.0) else { return };
        let wanted = f.time_s.max(self.movers[m].landing_s);
        if self.time_s < wanted - time {
            return;
        }
        let r = f.runway.0;
        let last = self.crossing[r]
            .iter()
            .map(|c| self.last_landing[*c])
            .fold(f64::NEG_INFINITY, f64::max);
        let gap =
            if self.mixed[r] && self.departures_wait(r) { 240.0 } else { arrival_gap_s(f.wake) };
        if self.time_s + time < last + gap {
            self.movers[m].next_try_s = self.time_s + RETRY_S;
            return;
        }
        let mut choices = self.free_stands(m, 6);
        if choices.is_empty() {
            choices.extend(self.make_room(m));
        }
        let none = choices.is_empty();
        let chosen = choices.into_iter().find(|(stand, _)| {
            self.movers[m].stand = *stand;
            self.plan_arrival(m)
        });
        let Some((stand, pieces)) = chosen else {
            if self.movers[m].waits_since_s.is_none() {
                let why = if none { "no free stand" } else { "no way to a free stand" };
                self.remark(format!(
                    "{}: {why} from runway {}, not released to final",
                    f.callsign,
                    self.end_name(m)
                ));
            }
            let now = self.time_s;
            self.movers[m].waits_since_s.get_or_insert(now);
            self.movers[m].next_try_s = now + 30.0;
            return;
        };
        if stand != f.stand {
            self.remark(format!(
                "{}: stand {} is not free, to {} instead",
                f.callsign, self.net.stands[f.stand].name, self.net.stands[stand].name
            ));
        }
        let landing_s = self.time_s + time;
        self.last_landing[r] = landing_s;
        let mover = &mut self.movers[m];
        mover.parked_pieces = pieces;
        mover.landing_s = landing_s;
        mover.phase = Phase::Final;
        mover.waits_since_s = None;
        mover.cleared = false;
        (mover.first_held, mover.next, mover.slip, mover.a) = (0, 0, 0.0, 0.0);
        mover.s = mover.threshold - FINAL_M;
        mover.v = approach_airspeed_mps(FINAL_M, f.landing.0);
        mover.height_m = 15.0 + SLOPE * FINAL_M;
        mover.climb_mps = -SLOPE * mover.v;
    }

    /// The aircraft that has stood longest without a next flight is towed away.
    fn make_room(&mut self, m: usize) -> Option<(usize, Vec<u32>)> {
        let idle = |o: &usize| {
            let other = &self.movers[*o];
            other.phase == Phase::Docked
                && other.class >= self.movers[m].class
                && other.measures.aibt_s.is_some_and(|t| self.time_s > t + 1200.0)
                && !self.flights.iter().any(|g| g.turnaround_of == Some(*o))
        };
        let oldest = (0..self.movers.len()).filter(idle).min_by(|a, b| {
            let since = |o: usize| self.movers[o].measures.aibt_s.unwrap_or(0.0);
            since(*a).total_cmp(&since(*b))
        })?;
        self.remark(format!(
            "{}: towed away from stand {}",
            self.flights[oldest].callsign, self.net.stands[self.movers[oldest].stand].name
        ));
        self.leave_stand(oldest);
        self.free_stand(m)
    }

    /// Exit and way to the stand.
    fn plan_arrival(&mut self, m: usize) -> bool {
        let f = self.flights[m].clone();
        let net = Arc::clone(&self.net);
        let (r, end) = f.runway;
        let runway = &net.runways[r];
        let Some(node) = net.stands[self.movers[m].stand].node else { return false };
        let closed = self.closed(m);
        let mut rng = self.rng(m, 4);
        let touchdown_m = (420.0 + 110.0 * normal_pair(&mut rng).0).clamp(150.0, 900.0);
        let landing = Landing {
            touchdown_mps: f.landing.0,
            touchdown_m,
            delay_s: 2.0,
            nominal_mps2: f.landing.1,
            greatest_mps2: 2.5,
        };
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let along = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let mut spine: Vec<(f64, usize)> =
            runway.spine.iter().map(|(p, n)| (along(*p), *n)).collect();
        if end == 1 {
            spine.reverse();
        }
        let threshold = runway.displaced_m[end];
        let mut exits: Vec<(Exit, usize)> = Vec::new();
        for (place, n) in &spine {
            for arc in self.arcs.leaving(*n) {
                let edge = &net.edges[arc / 2];
                let turn = wrap_pi(self.arcs.heading_rad(*arc) - direction).abs().to_degrees();
                if edge.runway.is_some() || edge.strip != Some(r) || turn > 115.0 {
                    continue;
                }
                let speed_mps = if turn <= 35.0 {
                    25.7
                } else if turn <= 60.0 {
                    12.9
                } else {
                    7.7
                };
                exits.push((Exit { place_m: place - threshold, speed_mps }, *arc));
            }
        }
        exits.sort_by(|a, b| a.0.place_m.total_cmp(&b.0.place_m).then(a.1.cmp(&b.1)));
        let opposed = self.opposed(m);
        let mut left: Vec<(Exit, usize)> = exits;
        while !left.is_empty() {
            let places: Vec<Exit> = left.iter().map(|e| e.0).collect();
            let chosen = landing.exit(&places).unwrap_or(left.len() - 1);
            let (exit, arc) = left.remove(chosen);
            let is_closed = |e: usize| closed[e] || net.edges[e].runway == Some(r);
            let goal = |a: usize| Arcs::to(&net, a) == node;
            let Some(found) =
                self.arcs.quickest(&net, &[(arc, 0.0)], goal, is_closed, |a| opposed[a])
            else {
                continue;
            };
            // Braking harder than anybody does: not this exit.
            let Some(needed) = landing.needed_mps2(exit).filter(|a| *a <= 3.0) else { continue };
            let at = spine
                .iter()
                .position(|(p, _)| (p - threshold - exit.place_m).abs() < 0.01)
                .unwrap_or(0);
            let mut arcs: Vec<usize> =
                spine[..=at].windows(2).filter_map(|w| self.arc_between(w[0].1, w[1].1)).collect();
            if arcs.is_empty() {
                continue;
            }
            let on_runway: usize = arcs.iter().map(|a| self.pieces.of_edge[a / 2].1).sum();
            arcs.extend(found.arcs);
            let guided = 0.4 * f.size.length_m;
            let mut way =
                Way::over(&net, &self.pieces, &arcs, self.movers[m].class, (0.0, 60.0), guided);
            way.roll = 0..on_runway;
            way.group_crossings(&self.pieces, f.size.length_m + 10.0, 0..on_runway);
            // Landing: the runway up to the exit with the exit beyond the holding position.
            let exit_end = way
                .crossings
                .iter()
                .find(|c| c.0 == on_runway)
                .map_or(on_runway, |_| way.group_last[on_runway]);
            way.crossings.retain(|c| c.0 != on_runway);
            way.group(0, exit_end.min(way.pieces.len() - 1));
            let free_to = way.path.arcs().next().map_or(way.ends_m[on_runway - 1], |a| a.0);
            let braking = (1.15 * needed.max(0.5)).max(f.landing.1.min(1.6)).min(3.0);
            let driving = self.movers[m].driving;
            way.limit(&net, &self.pieces, &driving, free_to, braking);
            let vacated = way.ends_m[exit_end];
            let mover = &mut self.movers[m];
            mover.measures.unhindered_s = way.unhindered_s(vacated, way.stop_m, &driving);
            mover.threshold = threshold;
            mover.touchdown = threshold + touchdown_m;
            mover.braking = braking;
            mover.way = way;
            return true;
        }
        false
    }

    fn on_final(&mut self, m: usize) {
        let f = self.flights[m].clone();
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        let distance = (mover.threshold - mover.s).max(0.0);
        let over = (mover.s - mover.threshold) / (mover.touchdown - mover.threshold).max(1.0);
        let wish = if over > 0.0 {
            f.landing.0 * (1.03 - 0.03 * over.min(1.0))
        } else {
            approach_airspeed_mps(distance, f.landing.0)
        };
        let a = ((wish - mover.v) / 1.0).clamp(-1.0, 0.5).clamp(mover.a - dt, mover.a + dt);
        mover.s += mover.v * dt;
        mover.v += a * dt;
        mover.a = a;
        let before = mover.height_m;
        mover.height_m = if over < 0.0 {
            15.0 + SLOPE * distance
        } else {
            15.0 * (1.0 - over).max(0.0) * (1.0 - over).max(0.0)
        };
        mover.climb_mps = (mover.height_m - before) / dt;
        let (cleared, down) = (mover.cleared, mover.s >= mover.touchdown);
        if !cleared && distance < 2.0 * NAUTICAL_MILE_M {
            // Taken at once: the landing group, if the runway is free and the exit beyond it.
            if !self.owned(m) && self.take_landing(m) {
                let r = self.flights[m].runway.0;
                self.owner[r] = Some(m);
                self.movers[m].cleared = true;
                self.clear(m, "LND", self.end_name(m));
            } else if distance < NAUTICAL_MILE_M {
                let mover = &mut self.movers[m];
                mover.phase = Phase::GoAround;
                mover.measures.go_arounds += 1;
                mover.parked_pieces.clear();
                let (waits_for, r) = (mover.waits_for, self.flights[m].runway.0);
                let owner =
                    self.crossing[r].iter().find_map(|c| self.owner[*c].filter(|o| *o != m));
                let name =
                    |o: usize| format!("{} ({:?})", self.flights[o].callsign, self.movers[o].phase);
                let why = match (owner, waits_for) {
                    (Some(o), _) => format!("runway taken by {}", name(o)),
                    (None, Some(o)) => format!("in the way: {}", name(o)),
                    (None, None) => "others could not finish".into(),
                };
                self.remark(format!("{} goes around: {why}", f.callsign));
                let mover = &mut self.movers[m];
                // Straight on over the runway.
                let here = mover.way.path.at(mover.s);
                let ahead = here.at_m + Azimuth::from_rad(here.heading_rad).unit() * 30_000.0;
                let (path, _) = super::path::Path::over(&[here.at_m, ahead], |_, _| 0.0);
                mover.way = Way::straight(path);
                (mover.s, mover.next, mover.first_held) = (0.0, 0, 0);
                self.clear(m, "GOA", self.end_name(m));
                return;
            }
        }
        if down {
            let now = self.time_s;
            let mover = &mut self.movers[m];
            (mover.height_m, mover.climb_mps) = (0.0, 0.0);
            mover.phase = Phase::Landing;
            mover.measures.aldt_s = Some(now);
            mover.ready_s = now + 2.0;
        }
    }

    fn take_landing(&mut self, m: usize) -> bool {
        // Its own promised stand is not in its way.
        let before = self.movers[m].phase;
        self.movers[m].phase = Phase::Landing;
        let mut taken = self.take(m);
        // The world has changed since the way was planned: another exit or way may do.
        if !taken && self.time_s >= self.movers[m].next_try_s {
            self.movers[m].next_try_s = self.time_s + 3.0;
            let old = self.movers[m].clone();
            if self.plan_arrival(m) && self.movers[m].way.arcs != old.way.arcs {
                self.movers[m].refused_at = None;
                taken = self.take(m);
            } else {
                self.movers[m] = old;
            }
        }
        self.movers[m].phase = before;
        taken
    }

    fn going_around(&mut self, m: usize) {
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        mover.s += mover.v * dt;
        mover.a *= 0.9;
        mover.v += mover.a * dt;
        mover.climb_mps = (mover.climb_mps + 1.5 * dt).min(0.0875 * mover.v);
        mover.height_m += mover.climb_mps * dt;
        if mover.height_m >= 900.0 {
            let again = self.time_s + 600.0;
            let mover = &mut self.movers[m];
            mover.phase = Phase::Absent;
            mover.landing_s = again;
            mover.way = Way::default();
        }
    }

    fn landing(&mut self, m: usize) {
        let now = self.time_s;
        let mover = &self.movers[m];
        let exit_from = mover.way.path.arcs().next().map_or(mover.way.stop_m, |a| a.0);
        if mover.s >= exit_from {
            self.movers[m].phase = Phase::Taxiing;
            self.movers[m].taxi_from_s = now;
            self.clear(m, "TAX", String::new());
            self.taxiing(m);
            return;
        }
        let wish = if now < mover.ready_s {
            mover.v
        } else {
            mover.way.most_mps(mover.s + 0.3 * mover.v).min(mover.v.max(15.0))
        };
        let dec = 1.2 * mover.braking;
        let limits = Tick { acc: 0.5, dec, jerk: 2.0, dt: self.step_s };
        let (s, v, a) = (mover.s, mover.v, mover.a);
        let end = mover.way.stop_m;
        let mover = &mut self.movers[m];
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, end);
        self.follow(m, s);
        let behind = 0.95 * self.flights[m].size.length_m + TAIL_M;
        loop {
            let mover = &self.movers[m];
            let i = mover.first_held;
            if i + 1 >= mover.next || mover.s <= mover.way.ends_m[i] + behind {
                break;
            }
            let (z, roll) = (mover.way.pieces[i], mover.way.roll.contains(&i));
            self.release(m, z, roll);
            self.movers[m].first_held += 1;
        }
    }

    /// Measures of a frame.
    fn count(&mut self, m: usize) {
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

/// Straight line before the begin of a pushback, m.
const PUSH_BEFORE_M: f64 = 30.0;

fn still(position_m: Vector3<f64>, heading_rad: f64) -> TruthState {
    let zero = Vector3::zeros();
    TruthState {
        position_m,
        velocity_mps: zero,
        acceleration_ms2: zero,
        heading_rad,
        pitch_rad: 0.0,
        roll_rad: 0.0,
        angular_rate_rads: zero,
    }
}

/// Class of a mover by its span.
#[must_use]
pub fn class_of(size: Size) -> Class {
    if size.aircraft { super::network::code_of_span(size.span_m) + 1 } else { 0 }
}

/// Time between departures on one runway, s (ICAO wake categories, at least 60 s).
#[must_use]
pub fn departure_gap_s(first: WakeCategory, then: WakeCategory) -> f64 {
    use WakeCategory::{Heavy as H, Light as L, Medium as M, Super as J};
    match (first, then) {
        (J, H) => 120.0,
        (J, M | L) => 180.0,
        (H, M | L) | (M, L) => 120.0,
        _ => 60.0,
    }
}

/// Time between arrivals on one runway, s: 3.8 NM at 70 m/s, light ones 6 NM (assumed in place of a table of
/// pairs).
fn arrival_gap_s(wake: WakeCategory) -> f64 {
    if wake == WakeCategory::Light { 170.0 } else { 130.0 }
}

/// One step of a speed that follows a wish with limited acceleration and jerk.
struct Tick {
    acc: f64,
    dec: f64,
    jerk: f64,
    dt: f64,
}

impl Tick {
    /// Place, speed and acceleration after the step; never beyond `stop`, where standing is exact.
    fn tick(&self, s: f64, v: f64, a: f64, wish: f64, stop: f64) -> (f64, f64, f64) {
        let Self { acc, dec, jerk, dt } = *self;
        if v == 0.0 && wish == 0.0 {
            return (s, 0.0, 0.0);
        }
        let gap = stop - s;
        if v < 0.05 && gap < 0.15 {
            return (s, 0.0, 0.0);
        }
        let error = wish - v;
        let reach = |e: f64| {
            let half = 0.5 * jerk * dt;
            ((half * half + 2.0 * jerk * e).sqrt() - half).max(0.0)
        };
        let mut want = if error >= 0.0 { reach(error).min(acc) } else { -(reach(-error).min(dec)) };
        // Braking begins where the stop with the jerk limit needs it: the acceleration has to come down first.
        if gap > 0.0 && stopping(v, a, 0.85 * dec, jerk, dt).0 + v * dt >= gap {
            want = -dec;
        }
        let next = want.clamp(a - jerk * dt, a + jerk * dt).clamp(-dec, acc);
        let faster = v + 0.5 * (a + next) * dt;
        if faster <= 0.0 {
            let moved = if v > 0.0 { 0.5 * v * dt } else { 0.0 };
            return ((s + moved).min(stop.max(s)), 0.0, 0.0);
        }
        let moved = 0.5 * (v + faster) * dt;
        if moved >= gap {
            return (stop.max(s), 0.0, 0.0);
        }
        (s + moved, faster, next)
    }
}

impl Mover {
    fn of(flight: usize, f: &Flight, seed: u64) -> Self {
        let mut rng =
            DrawKey { run_seed: seed, sensor: 0, entity: f.key, scan: 1 }.rng(Purpose::Mover);
        let (first, second) = normal_pair(&mut rng);
        let factor = (0.92 + 0.06 * first).clamp(0.75, 1.0);
        let brisk = (1.0 + 0.1 * second).clamp(0.7, 1.0);
        let driving = Driving {
            straight_mps: f.taxi_mps.0 * factor,
            turn_mps: f.taxi_mps.1,
            acc_mps2: f.taxi_acc_mps2.0 * brisk,
            dec_mps2: f.taxi_acc_mps2.1,
            jerk_mps3: 0.6,
            lateral_mps2: 1.2,
        };
        Self {
            flight,
            class: class_of(f.size),
            phase: Phase::Absent,
            driving,
            push: Way::default(),
            way: Way::default(),
            stand: f.stand,
            s: 0.0,
            v: 0.0,
            a: 0.0,
            slip: 0.0,
            height_m: 0.0,
            climb_mps: 0.0,
            first_held: 0,
            next: 0,
            refused_at: None,
            waits_since_s: None,
            waits_for: None,
            still_since_s: None,
            threshold: 0.0,
            touchdown: 0.0,
            braking: 1.2,
            landing_s: f64::NEG_INFINITY,
            cleared: false,
            ready_s: 0.0,
            next_try_s: 0.0,
            parked_pieces: Vec::new(),
            taxi_from_s: 0.0,
            measures: Measures::default(),
        }
    }
}
