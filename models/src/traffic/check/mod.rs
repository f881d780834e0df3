//! The checker of traffic: what a run shows of its movers, held against what traffic has to keep.
//!
//! It sees what anybody sees: poses at times, clearances, the layout. It knows nothing of the core, of pieces or of
//! plans, so it judges recordings, other people's traffic and our own alike.
//!
//! | row | kept when |
//! | --- | --- |
//! | overlaps | no two outlines (fuselage and wing, or vehicle) intersect |
//! | gridlocks | something moves, or nobody who is to move stands on a way |
//! | stuck | nobody stands off stands for longer than [`Rules::stuck_s`] |
//! | pavement | [`Rules::pavement_share`] of the moving samples on the ground within [`Rules::pavement_m`] of the network, or on a runway |
//! | holds | who comes over a holding position has a clearance of that runway |
//! | clearances | who leaves his stand, takes off or lands has the clearance for it |
//! | runways | one roll a runway, and nobody in the strip ahead of it |
//! | wake | time between take-offs, distance between landings |
//! | speeds, accelerations | of the type, on taxiways and on runways |
//! | teleports | nobody is elsewhere than speed and time allow |
//! | served | departures that are due are airborne, arrivals that are due stand on a stand |

mod clearances;
mod limits;
mod overlaps;
mod pavement;
mod runways;
mod service;

use super::core::{Day, Direction};
use super::network::Network;
use super::outline::Size;
use crate::airport::Airport;
use crate::control::clearance::ClearanceKind;
use crate::control::layout::Layout;
use crate::frames::{Azimuth, Point2, Point3, Vector2};
use crate::wake::Wake;
use pavement::Pavement;

/// What a mover of this type keeps. Metres, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TypeLimits {
    /// Fastest on taxiways.
    pub taxi_mps: f64,
    /// Acceleration and braking on taxiways.
    pub taxi_mps2: (f64, f64),
    /// Fastest on a runway: the larger of lift-off and touchdown.
    pub runway_mps: f64,
    /// Acceleration and braking on a runway.
    pub runway_mps2: (f64, f64),
}

impl TypeLimits {
    /// Limits of a type: speed on taxiways, acceleration and braking there, lift-off speed and run, touchdown speed.
    ///
    /// A roll is fastest at its begin, `V² ln(1/r) / (2S (1 − r))` with the ratio 0.75 of [`super::runway_roll`];
    /// nobody brakes harder than 3 m/s² (assumed).
    #[must_use]
    pub fn new(
        taxi_mps: f64,
        taxi_mps2: (f64, f64),
        (liftoff_mps, run_m): (f64, f64),
        touchdown_mps: f64,
    ) -> Self {
        let mean_mps2 = liftoff_mps * liftoff_mps / (2.0 * run_m.max(100.0));
        Self {
            taxi_mps,
            taxi_mps2,
            runway_mps: liftoff_mps.max(1.03 * touchdown_mps),
            runway_mps2: (1.16 * mean_mps2, 3.0),
        }
    }

    /// The same over the ground in all of a run's weather: thin air is flown through faster, wind is added from behind, and dense
    /// air gives more thrust.
    #[must_use]
    pub fn in_weather(mut self, days: &[(f64, Day)]) -> Self {
        let of = |f: &dyn Fn(&Day) -> f64| days.iter().map(|d| f(&d.1)).fold(0.0, f64::max);
        let thin = of(&|day| 1.0 / day.density_ratio.sqrt()).max(1.0);
        let dense = of(&|day| libm::pow(day.density_ratio, 0.7)).max(1.0);
        self.runway_mps = self.runway_mps * thin + of(&|day| day.wind_mps.norm());
        self.runway_mps2.0 *= dense;
        self
    }
}

/// A mover.
#[derive(Clone, Debug, PartialEq)]
pub struct Who {
    /// Call sign.
    pub callsign: String,
    /// Size on the ground.
    pub size: Size,
    /// Of its type.
    pub limits: TypeLimits,
    /// Wake category of an aircraft.
    pub wake: Option<Wake>,
    /// Arrival or departure; `None`: neither, or not known.
    pub direction: Option<Direction>,
    /// Landing or off-block time, s of the run.
    pub due_s: f64,
}

/// A mover at a time: middle of its length, velocity over the ground, heading. Airport frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Place in the list of movers.
    pub who: usize,
    /// Position, height over the aerodrome, m.
    pub position_m: Point3<f64>,
    /// Velocity, east and north, m/s.
    pub velocity_mps: Vector2<f64>,
    /// Heading, rad.
    pub heading_rad: f64,
}

/// A clearance of a runway.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Place in the list of movers.
    pub who: usize,
    /// For what.
    pub kind: ClearanceKind,
    /// End or ends, as the layout names them.
    pub runway: String,
    /// Holds from, s.
    pub from_s: f64,
    /// Until, s; infinite while it stands.
    pub until_s: f64,
}

/// Bounds and tolerances of the checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Outlines may overlap by this much: the error of the positions, m.
    pub overlap_m: f64,
    /// Nothing moves for so long: a gridlock, s.
    pub gridlock_s: f64,
    /// Longest standstill off stands, s.
    pub stuck_s: f64,
    /// Farthest from the network, m.
    pub pavement_m: f64,
    /// Share of moving samples that have to be that near.
    pub pavement_share: f64,
    /// A nose counts as over a holding position so far beyond it, m: a strip that is narrower than its holding distance ends
    /// at the lines of the taxiways beside it, and who turns there drives an arc that cuts their corners.
    pub hold_m: f64,
    /// Heights are right within this, m: higher it flies.
    pub height_m: f64,
    /// Added to the limits of speed, m/s: the error of the speeds.
    pub speed_mps: f64,
    /// Added to the limits of acceleration, m/s², where the error of one of two speeds explains no more.
    pub acceleration_mps2: f64,
    /// From being due to being served, s.
    pub serve_s: f64,
}

impl Rules {
    /// For states without error and many times a second.
    #[must_use]
    pub fn exact() -> Self {
        Self {
            overlap_m: 0.0,
            hold_m: 4.0,
            height_m: 0.0,
            speed_mps: 1e-6,
            acceleration_mps2: 0.1,
            ..Self::default()
        }
    }
}

/// How right the positions in a database have to be for [`Rules::default`], m: the largest threshold of dead reckoning.
pub const CHECKED_WITHIN_M: f64 = 0.1;

impl Default for Rules {
    /// For the database of a run: once a second, positions right within 0.1 m ([`CHECKED_WITHIN_M`]), the threshold of dead reckoning. Within it a
    /// jerk of 2 m/s³ has gained 0.45 m/s.
    fn default() -> Self {
        Self {
            overlap_m: 0.3,
            gridlock_s: 300.0,
            stuck_s: 1200.0,
            pavement_m: 11.5,
            pavement_share: 0.995,
            hold_m: 4.0,
            height_m: 0.1,
            speed_mps: 0.45,
            acceleration_mps2: 0.3,
            serve_s: 1800.0,
        }
    }
}

/// One row of the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was looked at.
    pub name: &'static str,
    /// How many breaches, or the share.
    pub value: f64,
    /// What it may be, in words.
    pub goal: String,
    /// Whether it was kept.
    pub kept: bool,
    /// How many samples, pairs or flights were looked at.
    pub of: u64,
    /// The first breaches, one line each.
    pub cases: Vec<String>,
}

/// Cases of a row that are told at most.
const MOST_CASES: usize = 20;
/// On the ground below this height, m.
const GROUND_M: f64 = 1.5;
/// Slower than this it stands, m/s.
const STILL_MPS: f64 = 0.1;

/// What breaches something, counted, the first told.
#[derive(Clone, Debug, Default)]
struct Breaches {
    count: u64,
    of: u64,
    cases: Vec<String>,
}

impl Breaches {
    fn add(&mut self, text: impl FnOnce() -> String) {
        self.count += 1;
        if self.cases.len() < MOST_CASES {
            self.cases.push(text());
        }
    }

    fn row(self, name: &'static str) -> Row {
        let kept = self.count == 0;
        Row {
            name,
            value: self.count as f64,
            goal: "0".into(),
            kept,
            of: self.of,
            cases: self.cases,
        }
    }
}

/// What was seen of a mover last, and when.
#[derive(Clone, Copy, Debug)]
struct Last {
    time_s: f64,
    seen: Seen,
    still_since_s: f64,
    /// Mean velocity of the nose wheel since the sample before, m/s.
    nose_mps: Option<Vector2<f64>>,
}

/// Mean velocity of the nose wheel, 0.4 of the length ahead of the middle, since the sample before, m/s.
fn nose_mps(who: &Who, last: &Last, dt: f64, s: &Seen) -> Vector2<f64> {
    let at = |s: &Seen| {
        let ahead = Azimuth::from_rad(s.heading_rad).unit() * (0.4 * who.size.length_m);
        s.position_m.xy() + ahead
    };
    (at(s) - at(&last.seen)) / dt
}

/// The checker, fed with the movers of one time after the other.
#[derive(Clone, Debug)]
pub struct Checker {
    layout: Layout,
    rules: Rules,
    who: Vec<Who>,
    last: Vec<Option<Last>>,
    time_s: f64,
    stands_m: Vec<Point2<f64>>,
    overlaps: overlaps::Overlaps,
    pavement: Pavement,
    runways: runways::Runways,
    limits: limits::Limits,
    service: service::Service,
    events: clearances::Events,
}

impl Checker {
    /// A checker of these movers on an airport.
    #[must_use]
    pub fn new(airport: &Airport, who: Vec<Who>, rules: Rules) -> Self {
        let layout = Layout::of(airport).with_network(&Network::of(airport));
        let count = who.len();
        Self {
            runways: runways::Runways::new(layout.runways.len(), count),
            layout,
            rules,
            last: vec![None; count],
            time_s: f64::NEG_INFINITY,
            stands_m: airport.stands.iter().map(|s| s.position_m).collect(),
            overlaps: overlaps::Overlaps::default(),
            pavement: Pavement::of(airport),
            limits: limits::Limits::default(),
            service: service::Service::new(count),
            events: clearances::Events::new(count),
            who,
        }
    }

    /// Takes in everybody who is there at a time. Times ascend; what is not finite is left out.
    pub fn frame(&mut self, time_s: f64, seen: &[Seen]) {
        if time_s <= self.time_s {
            return;
        }
        self.time_s = time_s;
        let finite = |s: &&Seen| {
            let numbers = s.position_m.iter().chain(s.velocity_mps.iter());
            s.who < self.who.len() && numbers.chain([&s.heading_rad]).all(|x| x.is_finite())
        };
        let seen: Vec<Seen> = seen.iter().filter(finite).copied().collect();
        let ground: Vec<Seen> =
            seen.iter().filter(|s| s.position_m.z < GROUND_M).copied().collect();
        self.overlaps.look(&self.who, &self.rules, time_s, &ground);
        for s in &ground {
            let on_runway = self.on_runway(s.position_m.xy());
            if s.velocity_mps.norm() >= 0.5 {
                let name = &self.who[s.who].callsign;
                self.pavement.look(&self.rules, time_s, s, name, on_runway);
            }
        }
        for s in &seen {
            if let Some(last) = &self.last[s.who] {
                let taxies = [s.position_m.xy(), last.seen.position_m.xy()]
                    .iter()
                    .all(|p| !self.near_runway(*p));
                self.limits.look(&self.rules, &self.who[s.who], last, time_s, s, taxies);
            }
        }
        self.runways.look(&self.layout, &self.rules, &self.who, time_s, &seen);
        self.service.look(&self.rules, &self.who, &self.stands_m, time_s, &seen, &self.last);
        self.events.look(&self.layout, &self.who, time_s, &seen);
        for s in seen {
            let still = s.velocity_mps.norm() < STILL_MPS;
            let before = self.last[s.who];
            let still_since_s = match before.filter(|_| still) {
                Some(l) if l.seen.velocity_mps.norm() < STILL_MPS => l.still_since_s,
                _ => time_s,
            };
            let who = &self.who[s.who];
            let nose_mps = before.map(|l| nose_mps(who, &l, time_s - l.time_s, &s));
            self.last[s.who] = Some(Last { time_s, seen: s, still_since_s, nose_mps });
        }
    }

    fn on_runway(&self, at_m: Point2<f64>) -> bool {
        self.layout.runways.iter().any(|r| {
            let (s, d) = r.place_m(at_m);
            (0.0..=r.length_m).contains(&s) && d.abs() <= 0.5 * r.width_m
        })
    }

    fn near_runway(&self, at_m: Point2<f64>) -> bool {
        self.layout.runways.iter().any(|r| {
            let (s, d) = r.place_m(at_m);
            (-100.0..=r.length_m + 100.0).contains(&s) && d.abs() <= r.hold_m + 60.0
        })
    }

    /// The table. `given`: every clearance of the run.
    #[must_use]
    pub fn finish(mut self, given: &[Given]) -> Vec<Row> {
        let mut rows = vec![self.overlaps.row()];
        rows.extend(self.service.gridlocks());
        rows.push(self.pavement.row(&self.rules));
        rows.extend(self.runways.rows(&self.layout, &self.who, given));
        rows.push(self.events.row(&self.layout, &self.who, given));
        rows.extend(self.limits.rows());
        rows.push(self.service.served(&self.rules, &self.who, &self.stands_m, self.time_s));
        rows
    }
}

#[cfg(test)]
mod tests;
