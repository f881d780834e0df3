//! Things that go wrong: somebody passes a hold, rolls uncleared, turns wrongly, stops; a controller forgets.
//!
//! A failure is done by its mover at the next occasion and is told (`Core::shown`) when it shows in the truth.
//! Movers keep their pieces also then, so nobody overlaps: a hold is passed when the runway's pieces are free.

use super::car::Car;
use super::{Arcs, Core, Phase};
use crate::airport::distance_to_segment_m;
use crate::frames::{Point2, Vector2};
use crate::traffic::runway_roll::{NAUTICAL_MILE_M, approach_time_s};
use crate::truth::TruthState;
use std::sync::Arc;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// A departure goes onto its runway without clearance, and stands there.
    PassHold,
    /// A departure that is lined up rolls without clearance.
    TakeOffUncleared,
    /// A departure is pushed back without clearance.
    PushUncleared,
    /// A departure lines up on a runway that is not its own.
    WrongRunway,
    /// Takes a turn that is not on its cleared way.
    WrongTurn,
    /// Neither reads back nor rolls after its take-off clearance.
    NoReply,
    /// A vehicle on the runway of an arrival.
    VehicleOnRunway,
    /// Stands on its way, then goes on.
    Stop,
    /// Stands on the runway after landing, then is towed.
    BlownTyre,
    /// Stands on its way, then is towed.
    Engine,
    /// The controller forgets to clear an arrival to land.
    ForgetLandingClearance,
    /// The controller clears somebody against this one's clearance for the runway.
    ConflictingClearance,
    /// The stop bars of its runway stay dark, which it takes for its clearance, or stay lit.
    StopBar,
    /// Its transponder does not answer.
    Transponder,
}

impl FailureKind {
    /// Kinds by the words of scenes.
    pub const WORDS: [(&'static str, Self); 14] = [
        ("pass_hold", Self::PassHold),
        ("take_off_uncleared", Self::TakeOffUncleared),
        ("push_uncleared", Self::PushUncleared),
        ("wrong_runway", Self::WrongRunway),
        ("wrong_turn", Self::WrongTurn),
        ("no_reply", Self::NoReply),
        ("vehicle_on_runway", Self::VehicleOnRunway),
        ("stop", Self::Stop),
        ("blown_tyre", Self::BlownTyre),
        ("engine", Self::Engine),
        ("forget_landing_clearance", Self::ForgetLandingClearance),
        ("conflicting_clearance", Self::ConflictingClearance),
        ("stop_bar", Self::StopBar),
        ("transponder", Self::Transponder),
    ];

    /// Whether a flight of this direction ever comes to where it happens.
    #[must_use]
    pub fn happens_to(self, direction: super::Direction) -> bool {
        use super::Direction::{Arrival, Departure, Vehicle};
        match self {
            Self::PassHold
            | Self::TakeOffUncleared
            | Self::PushUncleared
            | Self::WrongRunway
            | Self::NoReply => direction == Departure,
            Self::WrongTurn | Self::VehicleOnRunway | Self::ForgetLandingClearance => {
                direction == Arrival
            }
            Self::Stop
            | Self::BlownTyre
            | Self::Engine
            | Self::ConflictingClearance
            | Self::StopBar
            | Self::Transponder => direction != Vehicle,
        }
    }

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, kind)| *kind == self).map_or("", |(word, _)| word)
    }
}

/// A failure as a scene states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Name within the scene.
    pub id: String,
    /// What.
    pub kind: FailureKind,
    /// Whose: index of the flight.
    pub flight: usize,
    /// Not before, s.
    pub at_s: f64,
    /// How long it stays, s.
    pub stay_s: f64,
    /// How long before the arrival a vehicle is on the runway, s.
    pub lead_s: f64,
    /// What the controller clears somebody else for.
    pub clearance: &'static str,
    /// Stop bars stay lit, not dark.
    pub lamps_lit: bool,
    /// Name of the vehicle.
    pub vehicle: String,
}

/// A failure that has shown in the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Name within the scene.
    pub id: String,
    /// Who does it.
    pub callsign: String,
    /// What.
    pub kind: FailureKind,
    /// Since when it shows, s.
    pub time_s: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Failing {
    pub(super) failure: Failure,
    /// Runway of its flight by the plan: whose bars fail, whichever the flight goes to by mistake.
    pub(super) runway: usize,
    pub(super) begun_s: Option<f64>,
    pub(super) shown_s: Option<f64>,
    pub(super) over: bool,
    car: Option<Car>,
    /// Of a conflicting clearance: whose it is.
    other: Option<usize>,
}

/// A vehicle begins so far outside the strip of any other runway, m (assumed).
const CAR_CLEAR_M: f64 = 20.0;

impl Core {
    /// The same core with failures, before its first step.
    #[must_use]
    pub fn with_failures(mut self, failures: &[Failure]) -> Self {
        let count = self.movers.len();
        let planned: Vec<usize> = self.flights.iter().map(|f| f.runway.0).collect();
        for failure in failures.iter().filter(|f| f.flight < count) {
            let direction = self.flights[failure.flight].direction;
            if failure.kind == FailureKind::WrongRunway && direction == super::Direction::Departure
            {
                self.mistake_runway(failure.flight);
            }
            let failure = failure.clone();
            let failing = Failing {
                runway: planned[failure.flight],
                failure,
                begun_s: None,
                shown_s: None,
                over: false,
                car: None,
                other: None,
            };
            self.failing.push(failing);
        }
        self
    }

    /// Failures that have shown, in order.
    #[must_use]
    pub fn shown(&self) -> &[Shown] {
        &self.shown
    }

    /// The way that a flight is cleared for, m; empty before it has one.
    #[must_use]
    pub fn cleared_way_m(&self, flight: usize) -> &[Point2<f64>] {
        &self.movers[flight].cleared_way_m
    }

    /// Name of vehicle `n`, counted on from the flights.
    #[must_use]
    pub fn vehicle_name(&self, n: usize) -> Option<&str> {
        let with_car = |f: &&Failing| f.failure.kind == FailureKind::VehicleOnRunway;
        let place = n.checked_sub(self.movers.len())?;
        if let Some(driven) = place.checked_sub(self.cars()) {
            return self.hands.get(driven).map(|hand| hand.of.callsign.as_str());
        }
        self.failing.iter().filter(with_car).nth(place).map(|f| f.failure.vehicle.as_str())
    }

    /// Place of a stand, m.
    #[must_use]
    pub fn stand_m(&self, stand: usize) -> Point2<f64> {
        self.net.stands[stand].at_m
    }

    /// How many failures have a vehicle.
    pub(super) fn cars(&self) -> usize {
        let with_car = |f: &&Failing| f.failure.kind == FailureKind::VehicleOnRunway;
        self.failing.iter().filter(with_car).count()
    }

    /// State of the vehicle of the `n`-th failure that has one.
    pub(super) fn car_state(&self, n: usize) -> Option<TruthState> {
        let with_car = |f: &&Failing| f.failure.kind == FailureKind::VehicleOnRunway;
        self.failing.iter().filter(with_car).nth(n)?.car.as_ref()?.state(self.time_s)
    }

    /// The runway whose departing end is nearest to that of the flight's own is taken for it.
    fn mistake_runway(&mut self, m: usize) {
        let net = Arc::clone(&self.net);
        let (own, end) = self.flights[m].runway;
        let direction = |r: usize, e: usize| {
            (net.runways[r].ends_m[1 - e] - net.runways[r].ends_m[e]) / net.runways[r].length_m
        };
        let at = net.runways[own].ends_m[end];
        let others = (0..net.runways.len()).filter(|r| *r != own).flat_map(|r| [(r, 0), (r, 1)]);
        let similar = others.filter(|(r, e)| direction(*r, *e).dot(&direction(own, end)) > -0.2);
        let nearest = similar.min_by(|a, b| {
            let distance = |(r, e): (usize, usize)| (net.runways[r].ends_m[e] - at).norm();
            distance(*a).total_cmp(&distance(*b))
        });
        if let Some(runway) = nearest {
            let mut flights = self.flights.as_ref().clone();
            flights[m].runway = runway;
            self.flights = Arc::new(flights);
        }
    }

    /// The failure of a kind that a mover has still before or in it.
    pub(super) fn failing(&self, m: usize, kind: FailureKind) -> Option<usize> {
        self.failing.iter().position(|f| {
            f.failure.flight == m
                && f.failure.kind == kind
                && !f.over
                && (f.begun_s.is_some() || self.time_s >= f.failure.at_s)
        })
    }

    /// The failure by which a mover goes onto a runway uncleared.
    pub(super) fn enters_uncleared(&self, m: usize) -> Option<usize> {
        let passes = self.failing(m, FailureKind::PassHold);
        let passes = passes.or_else(|| self.failing(m, FailureKind::WrongRunway));
        let dark = |f: &usize| {
            let Failing { failure, begun_s, .. } = &self.failing[*f];
            let until_s = failure.at_s + failure.stay_s;
            begun_s.is_some() || !failure.lamps_lit && self.time_s <= until_s
        };
        passes.or_else(|| self.failing(m, FailureKind::StopBar).filter(dark))
    }

    /// Whether it has gone onto the runway uncleared, and stands there until that is over. What has not begun at the line holds nobody
    /// behind it.
    pub(super) fn entered_uncleared(&self, m: usize) -> bool {
        let there = |f: &Failing| f.failure.flight == m && f.begun_s.is_some() && !f.over;
        self.failing.iter().any(|f| {
            use FailureKind::{PassHold, StopBar, WrongRunway};
            there(f) && matches!(f.failure.kind, PassHold | WrongRunway | StopBar)
        })
    }

    pub(super) fn begin_failure(&mut self, f: usize) {
        let now = self.time_s;
        self.failing[f].begun_s.get_or_insert(now);
    }

    pub(super) fn show(&mut self, f: usize) {
        let now = self.time_s;
        let failing = &mut self.failing[f];
        if failing.shown_s.is_none() {
            failing.shown_s = Some(now);
            let Failure { id, kind, flight, vehicle, .. } = &failing.failure;
            let callsign = match kind {
                FailureKind::VehicleOnRunway => vehicle.clone(),
                _ => self.flights[*flight].callsign.clone(),
            };
            self.shown.push(Shown { id: id.clone(), callsign, kind: *kind, time_s: now });
        }
    }

    pub(super) fn has_begun(&self, f: usize) -> bool {
        self.failing[f].begun_s.is_some()
    }

    /// A take-off clearance that is not answered: stands for so long, s; `None` if it is answered.
    pub(super) fn silence_s(&mut self, m: usize) -> Option<f64> {
        let f = self.failing(m, FailureKind::NoReply)?;
        if self.failing[f].begun_s.is_some() {
            self.failing[f].over = true;
            return None;
        }
        self.begin_failure(f);
        self.show(f);
        Some(self.failing[f].failure.stay_s)
    }

    /// The controller clears somebody against what `m` was just cleared for: somebody else where the failure is of `m`, or
    /// whose failure it is, when he is under way on the ground.
    pub(super) fn clear_against(&mut self, m: usize) {
        let lands = |o: usize| self.flights[o].direction == super::Direction::Arrival;
        let under_way = |o: usize| {
            matches!(self.movers[o].phase, Phase::Pushing | Phase::Starting(_) | Phase::Taxiing)
        };
        let open = |f: &Failing| {
            f.failure.kind == FailureKind::ConflictingClearance
                && f.begun_s.is_none()
                && self.time_s >= f.failure.at_s
        };
        let own = self.failing.iter().position(|f| open(f) && f.failure.flight == m);
        let of_other = self.failing.iter().position(|f| {
            let o = f.failure.flight;
            open(f) && o != m && under_way(o) && lands(o) == lands(m)
        });
        let Some(f) = own.or(of_other) else { return };
        let there = |o: &usize| {
            *o != m
                && !self.is_vehicle(*o)
                && !matches!(
                    self.movers[*o].phase,
                    Phase::Absent | Phase::Gone | Phase::Final | Phase::GoAround
                )
        };
        let taxies = |o: &usize| self.movers[*o].phase == Phase::Taxiing;
        let all = 0..self.movers.len();
        let other = match own {
            Some(_) => all.clone().filter(there).find(taxies).or_else(|| all.clone().find(there)),
            None => Some(self.failing[f].failure.flight),
        };
        let Some(other) = other else { return };
        self.begin_failure(f);
        self.failing[f].other = Some(other);
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let kind = self.failing[f].failure.clearance;
        let (name, place_m) = match kind {
            "CRO" | "ENT" => (runway.names.join("/"), 0.5 * runway.length_m),
            // An entry ahead of the one that flies.
            _ => (runway.names[end].clone(), if end == 0 { 0.3 } else { 0.7 } * runway.length_m),
        };
        self.clear(other, kind, name);
        if let Some(c) = self.clearances.last_mut() {
            c.place_m = Some(place_m);
        }
        self.show(f);
    }

    /// An obstacle or the vehicle of a failure is on, or on its way to or from, this runway or one that crosses it.
    pub(super) fn car_blocks(&self, r: usize) -> bool {
        if self.obstacle_on_runway(r).is_some() {
            return true;
        }
        self.failing.iter().filter_map(|f| f.car.as_ref()).any(|car| {
            self.crossing[r].contains(&car.runway)
                && (car.start_s..car.end_s()).contains(&self.time_s)
        })
    }

    /// A way that leaves `arcs` at its first junction where another turn leads to a goal, too.
    pub(super) fn detour(
        &self,
        arcs: &[usize],
        goal: &dyn Fn(usize) -> bool,
        closed: &dyn Fn(usize) -> bool,
    ) -> Option<Vec<usize>> {
        let net = &self.net;
        let off = |edge: usize| net.edges[edge].strip.is_none() && net.edges[edge].runway.is_none();
        let place = |node: usize| net.nodes[node].at_m;
        let beside_m = |p: Point2<f64>| {
            let ends = arcs.iter().map(|a| (place(Arcs::from(net, *a)), place(Arcs::to(net, *a))));
            ends.map(|(a, b)| distance_to_segment_m(p, a, b)).fold(f64::INFINITY, f64::min)
        };
        for i in 1..arcs.len() {
            let before = arcs[i - 1];
            if !off(before / 2) {
                continue;
            }
            for alt in self.arcs.leaving(Arcs::to(net, before)).iter().copied() {
                let other =
                    alt != arcs[i] && alt / 2 != before / 2 && off(alt / 2) && !closed(alt / 2);
                let end = Arcs::to(net, alt);
                if !other
                    || self.arcs.turn_rad(before, alt) > 2.0
                    || net.nodes[end].stand.is_some()
                    || beside_m(place(end)) < 60.0
                {
                    continue;
                }
                let shut = |e: usize| closed(e) || e == before / 2;
                if let Some(found) = self.arcs.quickest(net, &[(alt, 0.0)], goal, shut, |_| false) {
                    return Some([&arcs[..i], &found.arcs[..]].concat());
                }
            }
        }
        None
    }

    /// Begins, shows and ends failures after the movers of a frame.
    pub(super) fn watch_failures(&mut self) {
        for f in 0..self.failing.len() {
            if self.failing[f].over || self.time_s < self.failing[f].failure.at_s {
                continue;
            }
            self.watch(f);
        }
    }

    fn watch(&mut self, f: usize) {
        let now = self.time_s;
        let Failing { failure, begun_s, shown_s, .. } = &self.failing[f];
        let (kind, m, stay_s) = (failure.kind, failure.flight, failure.stay_s);
        let (begun, shown_s) = (begun_s.is_some(), *shown_s);
        let mover = &self.movers[m];
        let length_m = self.flights[m].size.length_m;
        match kind {
            FailureKind::PassHold | FailureKind::WrongRunway => {
                let line =
                    (mover.threshold as usize).checked_sub(1).and_then(|i| mover.way.ends_m.get(i));
                let over = line.is_some_and(|line| mover.s + 0.1 * length_m > *line);
                if begun && over && shown_s.is_none() {
                    self.show(f);
                } else if shown_s.is_some_and(|at| now >= at + stay_s) {
                    // Seen, and cleared where it stands.
                    self.failing[f].over = true;
                    self.clear(m, "LUP", self.end_name(m));
                }
            }
            FailureKind::TakeOffUncleared | FailureKind::PushUncleared => {
                if begun && mover.v > 0.0 {
                    self.show(f);
                    self.failing[f].over = true;
                }
            }
            FailureKind::WrongTurn => {
                let place = mover.way.path.at(mover.s).at_m;
                let away = mover.phase == Phase::Taxiing
                    && !mover.cleared_way_m.is_empty()
                    && mover
                        .cleared_way_m
                        .windows(2)
                        .all(|w| distance_to_segment_m(place, w[0], w[1]) > 5.0);
                if begun && away {
                    self.show(f);
                    self.failing[f].over = true;
                }
            }
            FailureKind::Stop | FailureKind::Engine | FailureKind::BlownTyre => {
                let on_runway = kind == FailureKind::BlownTyre
                    && mover.phase == Phase::Landing
                    && mover.v < 25.0;
                let in_strip = (mover.first_held..mover.next)
                    .any(|i| self.pieces.list[mover.way.pieces[i] as usize].strip.is_some());
                let lands = self.flights[m].direction == super::Direction::Arrival;
                let taxies = mover.phase == Phase::Taxiing
                    && (kind != FailureKind::BlownTyre || !lands)
                    && !in_strip
                    && mover.v > 3.0
                    && now - mover.taxi_from_s >= 20.0;
                if !begun && (on_runway || taxies) {
                    self.begin_failure(f);
                    self.movers[m].stopped = true;
                } else if begun && mover.v == 0.0 && shown_s.is_none() {
                    self.show(f);
                } else if shown_s.is_some_and(|at| now >= at + stay_s) {
                    self.failing[f].over = true;
                    let lasts = self.failing.iter().any(|f| {
                        use FailureKind::{BlownTyre, Engine, Stop};
                        let stops = matches!(f.failure.kind, Stop | Engine | BlownTyre);
                        stops && f.failure.flight == m && f.begun_s.is_some() && !f.over
                    });
                    let mover = &mut self.movers[m];
                    mover.stopped = lasts;
                    mover.refused_at = None;
                    mover.towed |= kind != FailureKind::Stop;
                }
            }
            FailureKind::ForgetLandingClearance => {
                let t = (mover.threshold - mover.s) / mover.v.max(1.0);
                if begun && mover.phase == Phase::Final && t <= 30.0 {
                    self.show(f);
                    self.failing[f].over = true;
                }
            }
            FailureKind::ConflictingClearance => {
                if shown_s.is_some_and(|at| now >= at + 30.0) {
                    self.failing[f].over = true;
                    let clearance = self.failing[f].failure.clearance;
                    if let Some(other) = self.failing[f].other {
                        // That one, not what he was cleared for since.
                        let given = |c: &super::Clearance| Some(c.from_s) == shown_s;
                        self.end_clearance_of(other, |c| c.kind == clearance && given(c));
                    }
                }
            }
            FailureKind::VehicleOnRunway => self.watch_car(f),
            FailureKind::StopBar | FailureKind::Transponder => self.watch_equipment(f),
            FailureKind::NoReply => {}
        }
    }

    /// Where the vehicle comes to the centreline, m, and the side that it comes from: 900 m behind the threshold and from the right,
    /// but that it does not begin in the strip of another runway, where there is such a place.
    fn car_place(
        &self,
        r: usize,
        end: usize,
        toward: Vector2<f64>,
        right: Vector2<f64>,
    ) -> (Point2<f64>, Vector2<f64>) {
        let runway = &self.net.runways[r];
        let centre = |more_m: f64| {
            let place_m = runway.displaced_m[end] + 900.0 + more_m;
            runway.ends_m[end] + toward * place_m.min(runway.length_m - 300.0)
        };
        let in_strip = |at: Point2<f64>| {
            self.net.runways.iter().enumerate().any(|(other, o)| {
                let off_m = distance_to_segment_m(at, o.ends_m[0], o.ends_m[1]);
                other != r && off_m <= o.hold_distance_m + CAR_CLEAR_M
            })
        };
        let places = [0.0, 150.0, -150.0, 300.0, -300.0, 450.0].map(centre);
        let all = places.iter().flat_map(|place| [(*place, right), (*place, -right)]);
        let clear = all.into_iter().find(|(place, side)| !in_strip(Car::begin_m(*place, *side)));
        clear.unwrap_or((places[0], right))
    }

    fn watch_car(&mut self, f: usize) {
        let now = self.time_s;
        let Failure { flight: m, stay_s, lead_s, .. } = self.failing[f].failure;
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let hold_m = runway.hold_distance_m;
        if let Some(car) = &self.failing[f].car {
            // Front bumper over the strip's edge.
            let (over, gone) = (car.place(now).0 > Car::way_to_m(hold_m), now > car.end_s());
            if over {
                self.show(f);
            }
            self.failing[f].over = gone;
            return;
        }
        let mover = &self.movers[m];
        if mover.phase != Phase::Final {
            return;
        }
        let toward = (runway.ends_m[1 - end] - runway.ends_m[end]) / runway.length_m;
        let right = Vector2::new(toward.y, -toward.x);
        let (centre, right) = self.car_place(r, end, toward, right);
        let mut car = Car::across(r, centre, right, now, stay_s);
        let rolls = self.crossing[r].iter().any(|c| {
            self.owner[*c]
                .is_some_and(|o| matches!(self.movers[o].phase, Phase::Rolling | Phase::Landing))
        });
        // Its front is over the edge of the strip `lead_s` before the landing.
        let distance_nm = (mover.threshold - mover.s) / NAUTICAL_MILE_M;
        let to_threshold_s =
            approach_time_s(self.flights[m].landing.0, self.head_mps(m), distance_nm)
                .unwrap_or((mover.threshold - mover.s) / mover.v.max(1.0));
        if to_threshold_s <= lead_s + car.time_to_s(Car::way_to_m(hold_m)) && !rolls {
            car.start_s = now;
            self.failing[f].car = Some(car);
            self.begin_failure(f);
        }
    }

    /// Feeds what failures add to the state.
    pub(super) fn feed_failures(&self, feed: &mut dyn FnMut(u64)) {
        for failing in &self.failing {
            feed(failing.begun_s.map_or(0, f64::to_bits));
            feed(failing.shown_s.map_or(0, f64::to_bits));
            feed(u64::from(failing.over));
        }
    }
}
