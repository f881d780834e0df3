//! Aircraft that other programs give to the core on final, and those that it gives back above the airport.
//!
//! Who is given keeps his call sign and his place: in the first frame he is where his giver had him, with the velocity that he had, and
//! comes from there to the final of the model, in time, sideways and in height each by the polynomial of fifth degree that begins
//! with his offset and rate and ends with none. Nobody is taken who could not come to the final before he needs it, who would
//! land too near to somebody, or for whom no stand is left: he stays with his giver, who is told why. A call sign has one owner.
//!
//! Rules and their figures: `docs/traffic.md`, "Handed over".

mod join;

pub(super) use join::Join;

use super::arrival::{Tried, time_to_threshold_s};
use super::runway::arrival_gap_s;
use super::{Core, Direction, FINAL_M, Flight, Mover, Phase, Policy, class_of};
use crate::frames::{Azimuth, Point2, Point3, Vector2, Vector3, center, wrap_pi};
use crate::traffic::runway_roll::{NAUTICAL_MILE_M, approach_airspeed_mps};
use std::collections::BTreeMap;
use std::sync::Arc;

/// An aircraft as its giver has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Call sign, size, speeds; direction, runway, stand, time and key are the core's affair.
    pub flight: Flight,
    /// Its 24-bit address.
    pub address: Option<u32>,
    /// Its type, as whoever publishes it has it.
    pub designator: String,
    /// Runway, and which end it lands from; else the nearest final.
    pub runway: Option<(usize, usize)>,
    /// Stand wanted; else any that is large enough.
    pub stand: Option<usize>,
    /// Its middle, m east, north and up.
    pub at_m: Point3<f64>,
    /// Over the ground, m/s.
    pub velocity_mps: Vector3<f64>,
    /// When it is there, s of the run.
    pub time_s: f64,
}

/// What a program outside asks.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Take this one.
    Give(Box<Given>),
    /// Let the flight of this call sign go.
    Release(String),
}

/// An ask with the frame of its effect.
#[derive(Clone, Debug, PartialEq)]
struct Waiting {
    effect_frame: i64,
    source: String,
    sequence: u64,
    ask: Ask,
}

/// What came of an ask.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Frame in which it took effect, or was refused.
    pub frame: i64,
    /// Who asked.
    pub source: String,
    /// Number of its source.
    pub sequence: u64,
    /// Of whom.
    pub callsign: String,
    /// The flight, or why not.
    pub what: Result<usize, String>,
}

/// Places for those who are given, and what was asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Handovers {
    /// Of the flights the last ones.
    places: usize,
    waiting: Vec<Waiting>,
    given: BTreeMap<usize, Given>,
    outcomes: Vec<Outcome>,
}

/// Asks that wait at most.
const MOST_WAITING: usize = 1000;
/// Oldest state that is believed, s: a velocity is not known for longer.
const OLDEST_S: f64 = 2.0;
/// Nearest to the threshold at which somebody is taken, m: he is cleared or goes around soon after (assumed).
const NEAREST_M: f64 = 2.0 * NAUTICAL_MILE_M;
/// So far from the threshold he has come to the final, m.
const JOINED_M: f64 = 1.2 * NAUTICAL_MILE_M;
/// A final: beside its line by this share of the distance and this, m; from its slope by this share of the height and this, m; turned
/// from it by this, rad; climbing by no more, m/s (assumed: full scale of a localiser is 2.5°, of a glide path a quarter of it).
const BESIDE_SHARE: f64 = 0.05;
const BESIDE_M: f64 = 30.0;
const HEIGHT_SHARE: f64 = 0.25;
const HEIGHT_M: f64 = 40.0;
const TURNED_RAD: f64 = 20.0 * core::f64::consts::PI / 180.0;
const CLIMBS_MPS: f64 = 2.0;
const SINKS_MPS: f64 = -12.0;
/// Slower than the approach by this factor, faster than 160 kt by this, m/s: nobody on final.
const SLOW: f64 = 0.9;
const FAST_MPS: f64 = 25.0;
/// With which somebody on final slows down, m/s².
const SLOWS_MPS2: f64 = 1.0;
/// Who is to land or take off the other way within this, s, has the runway.
const OTHER_WAY_S: f64 = 1800.0;
/// Nobody is let go lower, m (1000 ft).
pub const RELEASED_ABOVE_M: f64 = 304.8;
/// Outcomes that are kept.
const MOST_OUTCOMES: usize = 10_000;

impl Core {
    /// The last `places` of the flights are places for those who are given: nobody is there before.
    #[must_use]
    pub fn with_places(mut self, places: usize) -> Self {
        self.handovers.places = places.min(self.flights.len());
        self
    }

    /// Takes an ask in; the frame at which it takes effect.
    pub fn ask(&mut self, effect_frame: i64, source: &str, sequence: u64, ask: Ask) -> i64 {
        let effect_frame = effect_frame.max(self.frame + 1);
        if self.handovers.waiting.len() >= MOST_WAITING {
            self.remark(format!("a handover asked by {source} was left out"));
            return effect_frame;
        }
        let ask = Waiting { effect_frame, source: source.to_owned(), sequence, ask };
        let key = |w: &Waiting| (w.effect_frame, w.source.clone(), w.sequence);
        let at = self.handovers.waiting.partition_point(|w| key(w) <= key(&ask));
        self.handovers.waiting.insert(at, ask);
        effect_frame
    }

    /// What came of the asks so far, in their order.
    #[must_use]
    pub fn handovers(&self) -> &[Outcome] {
        &self.handovers.outcomes
    }

    /// How a flight was given; `None` where it was not.
    #[must_use]
    pub fn given(&self, flight: usize) -> Option<&Given> {
        self.handovers.given.get(&flight)
    }

    /// Whether nobody has been given to this place yet.
    #[must_use]
    pub fn is_free_place(&self, flight: usize) -> bool {
        flight >= self.first_place() && !self.handovers.given.contains_key(&flight)
    }

    fn first_place(&self) -> usize {
        self.flights.len() - self.handovers.places
    }

    pub(super) fn apply_asks(&mut self) {
        while self.handovers.waiting.first().is_some_and(|w| w.effect_frame <= self.frame) {
            let Waiting { source, sequence, ask, .. } = self.handovers.waiting.remove(0);
            let (callsign, what) = match ask {
                Ask::Give(given) => (given.flight.callsign.clone(), self.take_over(*given)),
                Ask::Release(callsign) => {
                    let what = self.let_go(&callsign);
                    (callsign, what)
                }
            };
            let frame = self.frame;
            if let Err(why) = &what {
                self.remark(format!("{callsign} is not handed over: {why}"));
            }
            if self.handovers.outcomes.len() < MOST_OUTCOMES {
                self.handovers.outcomes.push(Outcome { frame, source, sequence, callsign, what });
            }
        }
    }

    /// The flight that has a call sign now, or had it, or will have it.
    fn of_name(&self, callsign: &str) -> Option<usize> {
        (0..self.flights.len())
            .find(|m| !self.is_free_place(*m) && self.flights[*m].callsign == callsign)
    }

    /// Where somebody of this name has his place.
    fn place_for(&self, callsign: &str) -> Result<usize, String> {
        let mut vehicles = (self.flights.len()..).map_while(|v| self.vehicle_name(v));
        if vehicles.any(|name| name == callsign) || self.is_obstacle(callsign) {
            return Err("its call sign is that of another mover".into());
        }
        let Some(m) = self.of_name(callsign) else {
            let free = (self.first_place()..self.flights.len()).find(|m| self.is_free_place(*m));
            return free.ok_or_else(|| {
                format!("all {} places of the scene have been given", self.handovers.places)
            });
        };
        let departs = self.flights[m].direction == Direction::Departure;
        match self.movers[m].phase {
            Phase::Gone if self.movers[m].measures.aibt_s.is_some() => {
                Err("it has been on its stand in this run".into())
            }
            Phase::Gone => Ok(m),
            Phase::Absent if !departs => Ok(m),
            Phase::Absent => Err("it has not departed yet".into()),
            _ => Err("it is here already".into()),
        }
    }

    /// Takes somebody who is on final; its flight, or why not.
    fn take_over(&mut self, mut given: Given) -> Result<usize, String> {
        let m = self.place_for(&given.flight.callsign)?;
        // Where it is at the begin of this step.
        let from_s = self.time_s - self.step_s;
        let age_s = from_s - given.time_s;
        let finite = given.at_m.iter().chain(&given.velocity_mps).all(|x| x.is_finite());
        if !(finite && age_s.abs() <= OLDEST_S + self.step_s) {
            return Err(format!("its state is of {age_s:.1} s before, {OLDEST_S} s at most"));
        }
        (given.at_m, given.time_s) = (given.at_m + given.velocity_mps * age_s, from_s);
        let runway = self.final_of(&given)?;
        self.is_flown_this_way(m, runway)?;
        let class = self
            .pieces
            .class_for(class_of(given.flight.size))
            .ok_or("nobody as large moves in this scene")?;
        let stand = self.stand_for(&given, runway)?;
        let off = self.off_final(&given, runway);
        let air = (given.flight.landing.0, self.head_on_mps(runway));
        let landing_s = from_s
            + time_to_threshold_s(off.out_m, off.along_mps, air, self.step_s)
                .ok_or("it is too slow to land")?;
        self.has_room(m, &given.flight, runway, landing_s)?;

        // From here on with the flight in its place, as it was before if nothing comes of it.
        let known = self.flights[m].clone();
        let wanted = match known.direction {
            Direction::Arrival if m < self.first_place() => known.stand,
            _ => stand,
        };
        let flight = Flight {
            direction: Direction::Arrival,
            runway,
            stand: wanted,
            time_s: landing_s,
            turnaround_of: None,
            key: known.key,
            ..given.flight.clone()
        };
        let mut mover = Mover::of(m, &flight, self.seed);
        (mover.class, mover.landing_s) = (class, landing_s);
        Arc::make_mut(&mut self.flights)[m] = flight;
        let before = std::mem::replace(&mut self.movers[m], mover);
        self.led(m);
        let mut choices = self.free_stands(m, 6);
        if choices.is_empty() {
            choices.extend(self.make_room(m));
        }
        let none = choices.is_empty();
        if self.policy == Policy::Planned {
            self.retime();
        }
        let mut tried = Tried::default();
        let Some((_, pieces)) = self.choose_stand(m, choices, landing_s, &mut tried) else {
            Arc::make_mut(&mut self.flights)[m] = known;
            self.movers[m] = before;
            let why = if none { "no stand is free" } else { "no way to a free stand at that time" };
            return Err(why.into());
        };
        let last = self.last_landing[runway.0];
        self.enters_final(m, pieces, landing_s, off.out_m);
        if last.0 > landing_s {
            self.last_landing[runway.0] = last;
        }
        self.begins_at(m, &given);
        if self.policy == Policy::Planned {
            self.book();
        }
        self.version += 1;
        let name = given.flight.callsign.clone();
        let (end, stand) = (self.end_name(m), self.net.stands[self.movers[m].stand].name.clone());
        self.remark(format!("{name} is taken over on final {end}, to stand {stand}"));
        self.handovers.given.insert(m, given);
        Ok(m)
    }

    /// Who is on final already begins there where he is.
    fn begins_at(&mut self, m: usize, given: &Given) {
        let guided_m = 0.4 * self.flights[m].size.length_m;
        let mover = &mut self.movers[m];
        let first = mover.way.path.at(0.0);
        let along = Azimuth::from_rad(first.heading_rad).unit();
        let aside = Vector2::new(along.y, -along.x);
        let off_m = given.at_m.xy() - first.at_m;
        mover.s = off_m.dot(&along) + guided_m;
        mover.v = given.velocity_mps.xy().dot(&along);
        // A step behind, as that of everybody on final.
        let before_m = mover.touchdown - mover.s + mover.v * self.step_s;
        mover.height_m = mover.flare.height_m(before_m);
        mover.climb_mps = -super::SLOPE * mover.v;
        let beside = (off_m.dot(&aside), given.velocity_mps.xy().dot(&aside));
        let above = (given.at_m.z - mover.height_m, given.velocity_mps.z - mover.climb_mps);
        mover.join = Some(Box::new(Join::new(given.time_s, beside, above)));
    }

    /// Threshold and direction of a runway end.
    fn threshold_m(&self, (r, end): (usize, usize)) -> (Point2<f64>, Vector2<f64>) {
        let runway = &self.net.runways[r];
        let along = (runway.ends_m[1 - end] - runway.ends_m[end]).normalize();
        (runway.ends_m[end] + along * runway.displaced_m[end], along)
    }

    /// How somebody is about a final.
    fn off_final(&self, given: &Given, runway: (usize, usize)) -> Off {
        let (threshold_m, along) = self.threshold_m(runway);
        let aside = Vector2::new(along.y, -along.x);
        let off_m = given.at_m.xy() - threshold_m;
        let out_m = -off_m.dot(&along) - 0.4 * given.flight.size.length_m;
        let along_mps = given.velocity_mps.xy().dot(&along);
        Off {
            out_m,
            along_mps,
            beside: (off_m.dot(&aside), given.velocity_mps.xy().dot(&aside)),
            above: (
                given.at_m.z - 15.0 - super::SLOPE * out_m,
                given.velocity_mps.z + super::SLOPE * along_mps,
            ),
        }
    }

    /// The final that somebody is on: the one he says, or the nearest.
    fn final_of(&self, given: &Given) -> Result<(usize, usize), String> {
        let ends = (0..self.net.runways.len()).flat_map(|r| [(r, 0), (r, 1)]);
        let known = |runway: &(usize, usize)| given.runway.is_none_or(|said| said == *runway);
        let mut refused: Option<(f64, String)> = None;
        let mut best: Option<(f64, (usize, usize))> = None;
        for runway in ends.filter(known) {
            let off = self.off_final(given, runway);
            let turned = (off.beside.0).abs() / off.out_m.abs().max(1.0);
            match self.is_on(&off, given, runway) {
                Ok(()) if best.is_none_or(|b| turned < b.0) => best = Some((turned, runway)),
                Err(why) if off.out_m > 0.0 && refused.as_ref().is_none_or(|r| turned < r.0) => {
                    refused = Some((turned, why));
                }
                _ => {}
            }
        }
        best.map(|b| b.1).ok_or_else(|| {
            refused.map_or_else(|| "it is on no final of this airport".into(), |r| r.1)
        })
    }

    fn is_on(&self, off: &Off, given: &Given, (r, end): (usize, usize)) -> Result<(), String> {
        let name = &self.net.runways[r].names[end];
        let miles = off.out_m / NAUTICAL_MILE_M;
        if !(NEAREST_M..=FINAL_M).contains(&off.out_m) {
            return Err(format!(
                "it is {miles:.1} NM from the threshold of {name}: {:.0} to {:.0} NM are needed",
                NEAREST_M / NAUTICAL_MILE_M,
                FINAL_M / NAUTICAL_MILE_M
            ));
        }
        let most_m = BESIDE_M + BESIDE_SHARE * off.out_m;
        if off.beside.0.abs() > most_m {
            let by_m = off.beside.0.abs();
            return Err(format!(
                "it is {by_m:.0} m beside the final of {name}, {most_m:.0} m at most"
            ));
        }
        let most_m = HEIGHT_M + HEIGHT_SHARE * super::SLOPE * off.out_m;
        if off.above.0.abs() > most_m {
            let (by_m, word) =
                (off.above.0.abs(), if off.above.0 > 0.0 { "above" } else { "below" });
            return Err(format!(
                "it is {by_m:.0} m {word} the slope of {name}, {most_m:.0} m at most"
            ));
        }
        let (_, along) = self.threshold_m((r, end));
        let turned = wrap_pi(Azimuth::of(given.velocity_mps.xy()).rad() - Azimuth::of(along).rad());
        if turned.abs() > TURNED_RAD {
            let degrees = turned.abs().to_degrees();
            return Err(format!(
                "its course is {degrees:.0} degrees off the final of {name}, 20 at most"
            ));
        }
        let climb_mps = given.velocity_mps.z;
        if !(SINKS_MPS..=CLIMBS_MPS).contains(&climb_mps) {
            return Err(format!(
                "it climbs by {climb_mps:.1} m/s, {SINKS_MPS} to {CLIMBS_MPS} m/s on final"
            ));
        }
        let touchdown_mps = given.flight.landing.0;
        let head_mps = self.head_on_mps((r, end));
        let last_mps = approach_airspeed_mps(0.0, touchdown_mps) - head_mps;
        let first_mps = approach_airspeed_mps(FINAL_M, touchdown_mps) - head_mps;
        let (least, most) = (SLOW * last_mps, first_mps + FAST_MPS);
        let v = off.along_mps;
        let left_m = off.out_m - JOINED_M;
        let slows_m = 0.5 * (v * v - last_mps * last_mps).max(0.0) / SLOWS_MPS2 + v;
        if !(least..=most).contains(&v) || slows_m > left_m {
            return Err(format!(
                "it flies {v:.0} m/s, {least:.0} to {most:.0} m/s on final, less near the runway"
            ));
        }
        let joins_m = Join::new(0.0, off.beside, off.above).takes_s() * v.max(last_mps);
        if joins_m > left_m {
            return Err(format!(
                "it needs {joins_m:.0} m to come to the final of {name}, {left_m:.0} m are left"
            ));
        }
        Ok(())
    }

    /// Nobody is to use this runway, or one that crosses it, the other way soon.
    fn is_flown_this_way(&self, m: usize, (r, end): (usize, usize)) -> Result<(), String> {
        let opposes = |o: &usize| {
            let f = &self.flights[*o];
            let other = &self.movers[*o];
            let soon = match other.phase {
                Phase::Gone | Phase::Docked => false,
                Phase::Landing => true,
                Phase::Taxiing => f.direction == Direction::Departure || self.owner[r] == Some(*o),
                Phase::Absent | Phase::Parked => {
                    f.time_s.max(other.landing_s) < self.time_s + OTHER_WAY_S
                }
                _ => true,
            };
            *o != m && soon && f.runway.0 == r && f.runway.1 != end && !self.is_free_place(*o)
        };
        match (0..self.flights.len()).find(opposes) {
            Some(o) => Err(format!(
                "runway {} is used from the other end, by {}",
                self.net.runways[r].names[end], self.flights[o].callsign
            )),
            None => Ok(()),
        }
    }

    /// A stand that is large enough: the wanted one, else the smallest, nearest to the runway.
    fn stand_for(&self, given: &Given, (r, _): (usize, usize)) -> Result<usize, String> {
        let need = class_of(given.flight.size).saturating_sub(1);
        let fits = |s: &usize| {
            let stand = &self.net.stands[*s];
            stand.code >= need && stand.node.is_some_and(|n| self.net.nodes[n].used)
        };
        if let Some(stand) = given.stand.filter(|s| *s < self.net.stands.len()).filter(fits) {
            return Ok(stand);
        }
        let [a, b] = self.net.runways[r].ends_m;
        let middle_m = center(&a, &b);
        let key = |s: usize| (self.net.stands[s].code, (self.net.stands[s].at_m - middle_m).norm());
        (0..self.net.stands.len())
            .filter(fits)
            .min_by(|a, b| {
                let ((c, d), (e, f)) = (key(*a), key(*b));
                c.cmp(&e).then(d.total_cmp(&f))
            })
            .ok_or_else(|| "no stand is large enough".into())
    }

    /// Whether a landing at this time keeps its distance from the others.
    fn has_room(
        &self,
        m: usize,
        flight: &Flight,
        (r, end): (usize, usize),
        landing_s: f64,
    ) -> Result<(), String> {
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let f = &self.flights[o];
            if other.phase != Phase::Final || !self.crossing[r].contains(&f.runway.0) {
                continue;
            }
            let apart_s = (landing_s - other.landing_s).abs();
            let needed_s = match other.landing_s <= landing_s {
                true => arrival_gap_s(f.wake, flight, self.head_on_mps((r, end))),
                false => arrival_gap_s(flight.wake, f, self.head_mps(o)),
            };
            let needed_s = needed_s.max(self.backtrack_gap_s(r));
            if apart_s < needed_s {
                return Err(format!(
                    "it would land {apart_s:.0} s from {}: {needed_s:.0} s are needed",
                    f.callsign
                ));
            }
        }
        let held_s = self.crossing[r].iter().map(|c| self.backtracks_for_s(*c)).fold(0.0, f64::max);
        if self.time_s + held_s > landing_s {
            return Err(format!("somebody backtracks on the runway for {held_s:.0} s"));
        }
        Ok(())
    }

    /// Lets somebody go who climbs above the airport; its flight, or why not.
    fn let_go(&mut self, callsign: &str) -> Result<usize, String> {
        let m = self.of_name(callsign).ok_or("there is no such flight")?;
        let (f, mover) = (&self.flights[m], &self.movers[m]);
        let least_mps = match mover.phase {
            Phase::Rolling => self.lift_off_mps(m),
            Phase::GoAround => f.landing.0 - self.head_mps(m),
            _ => return Err("it is not one that climbs away".into()),
        };
        if mover.height_m < RELEASED_ABOVE_M {
            return Err(format!(
                "it is at {:.0} m, {RELEASED_ABOVE_M:.0} m are needed",
                mover.height_m
            ));
        }
        if mover.v < least_mps {
            return Err(format!("it flies {:.0} m/s, {least_mps:.0} m/s are needed", mover.v));
        }
        self.release_held(m);
        self.vacate(m);
        if self.movers[m].phase == Phase::GoAround {
            self.end_clearance(m, "GOA");
        }
        let mover = &mut self.movers[m];
        mover.phase = Phase::Gone;
        mover.timing = super::Timing::default();
        self.version += 1;
        self.remark(format!("{callsign} is let go"));
        Ok(m)
    }

    pub(super) fn feed_handovers(&self, feed: &mut impl FnMut(u64)) {
        for (m, given) in &self.handovers.given {
            feed(*m as u64);
            given.flight.callsign.bytes().for_each(|b| feed(u64::from(b)));
            if let Some(join) = &self.movers[*m].join {
                join.feed(feed);
            }
        }
    }
}

/// How somebody is about a final: m to the threshold, m/s along it; beside and above it, m and m/s.
struct Off {
    out_m: f64,
    along_mps: f64,
    beside: (f64, f64),
    above: (f64, f64),
}
