//! One track: its filter, the updates of the last seconds, and what is known of it.

use super::config::TrackingConfig;
use super::consider::Consider;
use super::doubt::Doubt;
use super::extent::{Extent, Moments};
use super::filter::{TrackFilter, predict, slow_error};
use super::identity::Evidence;
use super::lag::Lag;
use super::near_side::{Body, EchoLaw};
use super::registration::{Reference, Registration};
use super::rest::Rest;
use super::ring::{Past, RingOf, Slotted};
use super::size::{self, Spread};
use crate::association::kinematic_gate::{ClassLimits, Departure};
use crate::filter::{Gaussian, UpdateError};
use crate::frames::{Matrix2, Vector2};
use crate::plot::{Callsign, Identity, Plot, SensorId, SensorKind};
use crate::time::SimTime;
use nalgebra::Matrix4;
use smallvec::SmallVec;

/// Stage of a track's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Tentative,
    Confirmed,
    /// Ended in this scan; a confirmed track is published once more.
    Ended,
}

/// What an update does to the filter.
#[derive(Clone, Copy, Debug)]
pub(super) enum Update<'a> {
    /// An ordinary plot.
    Plot(&'a Plot),
    /// A plot that only the kinematic gate accepted.
    Manoeuvre(&'a Plot),
    /// Begin again from these two.
    Restart(&'a Plot, &'a Plot),
    /// Several plots with the probability of each, moved to one time.
    Weighted(&'a [(Plot, f64)]),
}

/// Slower targets show no course, m/s.
const COURSE_FROM_MPS: f64 = 2.0;

/// Echoes whose variance is so many times what is stated are those of a large body.
const WANDERS: f64 = 1.5;

/// An update as it is kept, so that it can be done again.
#[derive(Clone, Debug)]
enum Record {
    /// An ordinary one or a manoeuvre.
    Plot(Taken),
    Restart(Box<[Taken; 2]>),
    Weighted(Box<[(Taken, f64)]>),
}

/// What a filter needs of a plot.
#[derive(Clone, Copy, Debug)]
struct Taken {
    time: SimTime,
    position_m: Vector2<f64>,
    axis: Vector2<f64>,
    along_m2: f64,
    across_m2: f64,
    sensor: SensorId,
    kind: SensorKind,
    /// Only the kinematic gate accepted it. Kept here, a record is one cache line.
    manoeuvre: bool,
    /// The filter was merged to one Gaussian for it.
    merged: bool,
}

impl Taken {
    #[inline]
    fn of(plot: &Plot) -> Self {
        let &Plot { time, position_m, axis, along_m2, across_m2, sensor, kind, .. } = plot;
        Self {
            time,
            position_m,
            axis,
            along_m2,
            across_m2,
            sensor,
            kind,
            manoeuvre: false,
            merged: false,
        }
    }

    fn plot(&self) -> Plot {
        let Self { time, position_m, axis, along_m2, across_m2, sensor, kind, .. } = *self;
        Plot {
            sensor,
            kind,
            time,
            sequence: 0,
            position_m,
            axis,
            along_m2,
            across_m2,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    }
}

/// One update and the filter before it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    before: TrackFilter,
    update: Record,
}

/// The updates of the last seconds, of all tracks.
pub(super) type Ring = RingOf<Entry>;

impl Entry {
    /// An update that became a beginning is one when it is done again.
    fn note_beginning(&mut self, after: After, update: Update<'_>) {
        if after.reborn {
            self.update = Record::Plot(Taken::of(update.plot()));
        }
    }
}

/// How an update went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Applied {
    /// The plot was taken; position and velocity just after it.
    Taken { position_m: Vector2<f64>, velocity_mps: Vector2<f64> },
    /// The filter could not go on: the track was started again from this plot.
    Reborn { position_m: Vector2<f64>, velocity_mps: Vector2<f64> },
    /// The plot was refused by the filter and left no trace.
    Refused,
}

#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Order of birth: the key of all ties.
    pub(super) serial: u64,
    /// The plot of an outsider began it.
    pub(super) outside: bool,
    /// Given at confirmation.
    pub(super) number: Option<u16>,
    pub(super) stage: Stage,
    /// The filter after the last plot.
    now: TrackFilter,
    /// Where the updates of the last seconds are, each with the filter before it.
    past: Past,
    pub(super) born: SimTime,
    pub(super) plots: u32,
    /// Time of the last plot that was more likely of this target than not.
    pub(super) last_hit: SimTime,
    /// One bit for each expected update, the newest lowest.
    pub(super) history: u32,
    pub(super) looks: u32,
    /// Since when the next update is missed.
    pub(super) due: SimTime,
    /// Interval of the sensor that updated it last, s.
    pub(super) interval_s: f64,
    /// Updated in this scan.
    pub(super) updated: bool,
    pub(super) manoeuvre: bool,
    /// Whether it stands, by its own plots.
    pub(super) rest: Rest,
    pub(super) published: bool,
    /// Plot of the last scan that both gates refused.
    pub(super) refused: Option<Box<Plot>>,
    /// Scans in a row at a speed that nothing has.
    pub(super) too_fast: u8,
    /// More plots lay where it may be than it could be told from, in this scan.
    pub(super) unresolved: bool,
    /// Its last plot made it begin anew; none has fitted since.
    pub(super) restarted: bool,
    pub(super) heading_rad: f64,
    pub(super) altitude_m: Option<f64>,
    /// What its plots said it is.
    pub(super) callsign: Option<Callsign>,
    pub(super) address: Option<u32>,
    /// Time of the last plot that said so.
    pub(super) named_at: SimTime,
    /// Its own last report of its position.
    pub(super) reference: Option<Box<Reference>>,
    /// Line of the flight list that is given as its label.
    pub(super) entry: Option<Callsign>,
    /// Line that it more likely is than not.
    pub(super) assumed: Option<Callsign>,
    /// Probability of either.
    pub(super) label_p: Option<f64>,
    /// Whether it has a target, where lives go by that.
    pub(super) doubt: Option<Box<Doubt>>,
    /// What it has shown of itself.
    pub(super) evidence: Box<Evidence>,
    /// Plots with its name in a row that were refused.
    pub(super) name_refused: u32,
    /// When each sensor has updated it last.
    pub(super) updated_by: SmallVec<[UpdatedBy; 2]>,
    /// The flight list has answered for the present identity.
    pub(super) name_settled: bool,
    pub(super) limits: ClassLimits,
    /// Length and span where the type is known, m.
    pub(super) size_m: Option<(f64, f64)>,
    /// Of a type that is a ground vehicle.
    pub(super) vehicle: bool,
    /// Where the nose points, as far as its motion has shown it: a unit vector.
    pub(super) course: Option<Vector2<f64>>,
    /// What the law of echoes leaves open of where the target is, m²: 0 where the filter holds it itself.
    pub(super) echo_left_m2: Matrix2<f64>,
    /// How its echoes wander.
    pub(super) spread: Spread,
    /// What cells it lights.
    pub(super) extent: Extent,
    /// The track that this one seems to double.
    pub(super) twin: Option<Twin>,
    /// Who was near when it was first published.
    pub(super) companion: Option<Companion>,
}

/// The last plot of one sensor that a track has taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct UpdatedBy {
    pub(super) sensor: SensorId,
    pub(super) time: SimTime,
    pub(super) sequence: u32,
}

impl UpdatedBy {
    fn of(plot: &Plot) -> Self {
        Self { sensor: plot.sensor, time: plot.time, sequence: plot.sequence }
    }
}

/// A track that another one seems to double.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twin {
    /// Which one.
    pub(super) serial: u64,
    /// ln of the odds that both are one target.
    pub(super) odds: f64,
}

/// The nearest track when this one was first published.
#[derive(Clone, Copy, Debug)]
pub(super) struct Companion {
    pub(super) serial: u64,
    /// How far apart they have been since, m.
    pub(super) farthest_m: f64,
}

impl Track {
    pub(super) fn start(
        serial: u64,
        plot: &Plot,
        config: &TrackingConfig,
        interval_s: f64,
    ) -> Result<Self, UpdateError> {
        let now = TrackFilter::from_plot(config, plot)?;
        let mut track = Self {
            serial,
            outside: false,
            number: None,
            stage: Stage::Tentative,
            now,
            past: Past::default(),
            born: plot.time,
            plots: 1,
            last_hit: plot.time,
            history: 0,
            looks: 0,
            due: plot.time.plus_s(interval_s),
            interval_s,
            updated: true,
            manoeuvre: false,
            rest: Rest::begun(plot),
            published: false,
            refused: None,
            restarted: false,
            unresolved: false,
            too_fast: 0,
            heading_rad: 0.0,
            altitude_m: plot.altitude_m,
            callsign: None,
            address: None,
            named_at: plot.time,
            reference: None,
            entry: None,
            assumed: None,
            label_p: None,
            doubt: None,
            evidence: Box::default(),
            name_refused: 0,
            updated_by: SmallVec::new(),
            name_settled: false,
            limits: config.limits_of(None),
            size_m: None,
            vehicle: false,
            course: None,
            echo_left_m2: Matrix2::zeros(),
            spread: Spread::default(),
            extent: Extent::default(),
            twin: None,
            companion: None,
        };
        track.learn_identity(plot.identity);
        track.spread.learn(plot, interval_s);
        track.updated_by.push(UpdatedBy::of(plot));
        Ok(track)
    }

    /// A confirmed track in this state, which is all it has.
    pub(super) fn take_over(&mut self, time: SimTime, state: &Gaussian, number: u16) {
        self.now.replace(time, state);
        (self.number, self.stage) = (Some(number), Stage::Confirmed);
        (self.history, self.looks, self.plots) = (u32::MAX, u32::BITS, 2);
    }

    /// Its body, where the type is known.
    pub(super) fn body(&self) -> Option<Body> {
        let (length_m, span_m) = self.size_m?;
        Some(Body { vehicle: self.vehicle, length_m, span_m })
    }

    /// A radar's plot as this track takes it: where its target is by what is known of its size and course, when by what
    /// is known of the radar's clock, and as uncertain as this target's echoes have been. Other plots as they are.
    pub(super) fn as_known(&self, plot: &Plot, registration: &Registration) -> Plot {
        let mut plot = *plot;
        if plot.polar.is_none() {
            return plot;
        }
        let law = registration.law();
        let late_s = registration.late_s(plot.sensor);
        if late_s != 0.0 {
            plot.position_m += self.filter().motion().1 * late_s;
        }
        if law.wanders {
            let (offset_m, _) = self.offset_m(law, plot.axis);
            plot.position_m += plot.axis * (offset_m - law.unknown_m.0);
        }
        // Where echoes are taken for those of points, what is stated holds until they clearly wander more.
        let clear = |factor: f64| law.wanders || factor >= WANDERS;
        let [along, across] = self.spread.factors(&plot).map(|f| if clear(f) { f } else { 1.0 });
        plot.along_m2 *= along;
        plot.across_m2 *= across;
        plot
    }

    /// How far its echo lies towards the radar, and the standard deviation of that, m: by its type, else by how its echoes
    /// wander.
    pub(super) fn offset_m(&self, law: &EchoLaw, axis: Vector2<f64>) -> (f64, f64) {
        // Which end is the nose does not matter here.
        let course = self.course.or_else(|| self.extent.axis());
        match (self.body(), self.spread.variance_m2()) {
            (None, Some((variance_m2, triples))) => {
                law.offset_of_unknown_m(variance_m2, triples, course, axis)
            }
            (body, _) => law.offset_m(body.as_ref(), course, axis),
        }
    }

    /// A radar's plot shows how large the target is, where the radar works in cells.
    pub(super) fn note_extent(&mut self, plot: &Plot) {
        if let Some(polar) = &plot.polar
            && let Some(moments) = polar.extent_m2
        {
            let (sin, cos) = libm::sincos(polar.azimuth_rad);
            let seen = Moments::turned(Vector2::new(sin, cos), moments);
            self.extent.learn(&seen, self.course);
        }
    }

    /// A radar's plot has updated the track: what is left open of its echo.
    pub(super) fn note_echo(&mut self, plot: &Plot, law: &EchoLaw) {
        let left = if !law.wanders {
            // The near side is not taken off: all of it is left.
            size::near_side_m2(self.spread.variance_m2().map(|seen| seen.0))
        } else if matches!(self.now, TrackFilter::Considering(_)) {
            0.0
        } else {
            let (_, sigma) = self.offset_m(law, plot.axis);
            sigma * sigma
        };
        self.echo_left_m2 = plot.axis * plot.axis.transpose() * left;
    }

    /// What an update says of where the nose points: a track of two plots has no velocity to speak of.
    pub(super) fn note_course(&mut self, velocity_mps: Vector2<f64>) {
        let speed = velocity_mps.norm();
        if self.plots >= 3 && speed > COURSE_FROM_MPS && speed.is_finite() {
            self.course = Some(velocity_mps / speed);
        }
    }

    /// The filter after the last plot.
    #[inline]
    pub(super) fn filter(&self) -> &TrackFilter {
        &self.now
    }

    /// Time of the last plot.
    #[inline]
    pub(super) fn time(&self) -> SimTime {
        self.now.time()
    }

    /// The filter as it was at `time`: after the last update that is not later.
    #[inline]
    pub(super) fn filter_before<'a>(
        &'a self,
        time: SimTime,
        ring: &'a Ring,
    ) -> Option<&'a TrackFilter> {
        if self.now.time() <= time {
            return Some(&self.now);
        }
        let place = self.past.place_at(time)?;
        Some(&ring[self.past[place].slot].before)
    }

    /// How many updates a plot of this time would have done again.
    pub(super) fn later_than(&self, time: SimTime) -> usize {
        self.past.iter().rev().take_while(|at| at.before > time).count()
    }

    /// Gives back what the ring holds for the track, which has ended.
    pub(super) fn leave(&mut self, ring: &mut Ring) {
        self.past.drain(..).for_each(|at| ring.free(at.slot));
    }

    /// Whether `plot` may be of this track as far as names go.
    pub(super) fn may_be(&self, identity: Option<Identity>) -> bool {
        match identity {
            Some(Identity::Callsign(c)) => self.callsign.is_none_or(|mine| mine == c),
            Some(Identity::Address(a)) => self.address.is_none_or(|mine| mine == a),
            None => true,
        }
    }

    /// Whether another sensor than this one has updated it within `within_s` of `time`.
    pub(super) fn has_other_than(&self, sensor: SensorId, time: SimTime, within_s: f64) -> bool {
        self.updated_by.iter().any(|by| by.sensor != sensor && time.since_s(by.time) <= within_s)
    }

    /// Takes the name away: another track has it now.
    pub(super) fn forget_identity(&mut self) {
        (self.callsign, self.address, self.entry) = (None, None, None);
        (self.assumed, self.label_p, self.name_refused) = (None, None, 0);
        (self.name_settled, self.size_m) = (false, None);
    }

    /// Whether its plots said that it is this one.
    pub(super) fn is(&self, identity: Identity) -> bool {
        match identity {
            Identity::Callsign(c) => self.callsign == Some(c),
            Identity::Address(a) => self.address == Some(a),
        }
    }

    fn learn_identity(&mut self, identity: Option<Identity>) {
        self.name_settled &= identity.is_none_or(|name| self.is(name));
        match identity {
            Some(Identity::Callsign(c)) => self.callsign = Some(c),
            Some(Identity::Address(a)) => self.address = Some(a),
            None => {}
        }
    }

    /// State for the kinematic gate.
    pub(super) fn departure(filter: &TrackFilter) -> Departure {
        let estimate = filter.estimate();
        let (pp, pv) = (estimate.position_cov_m2(), estimate.position_velocity_cov_m2s());
        let vv = estimate.velocity_cov_m2s2();
        let mut covariance = Matrix4::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&pp);
        covariance.fixed_view_mut::<2, 2>(0, 2).copy_from(&pv);
        covariance.fixed_view_mut::<2, 2>(2, 0).copy_from(&pv.transpose());
        covariance.fixed_view_mut::<2, 2>(2, 2).copy_from(&vv);
        Departure {
            position_m: estimate.position_m(),
            velocity_mps: estimate.velocity_mps(),
            covariance,
        }
    }

    /// Takes an update at its own time. A late one goes to its place, and all later ones are done
    /// again: the result is that of processing in order. With `merge` the filter goes on as one Gaussian first. What is
    /// older than `oldest` is forgotten.
    pub(super) fn apply(
        &mut self,
        update: Update<'_>,
        merge: bool,
        config: &TrackingConfig,
        oldest: SimTime,
        ring: &mut Ring,
    ) -> Applied {
        let time = update.plot().time;
        let after = if self.now.time() <= time {
            let before = self.now.time();
            let update_again = update.record(merge);
            let slot = ring.put(Entry { before: self.now.clone(), update: update_again });
            match step(&mut self.now, update, merge, config) {
                Ok(after) => {
                    ring[slot].note_beginning(after, update);
                    self.past.push(Slotted { before, slot });
                    after
                }
                Err(_) => {
                    std::mem::swap(&mut self.now, &mut ring[slot].before);
                    ring.free(slot);
                    return Applied::Refused;
                }
            }
        } else {
            // The state that the update starts from: `before` of the entry at `place`.
            let place = match self.past.place_at(time) {
                Some(place) => place,
                None if matches!(update, Update::Restart(..)) && !self.past.is_empty() => 0,
                None => return Applied::Refused, // before the oldest state that is kept
            };
            let before = ring[self.past[place].slot].before.clone();
            let mut filter = before.clone();
            let Ok(mut after) = step(&mut filter, update, merge, config) else {
                return Applied::Refused;
            };
            let mut entry = Entry { before, update: update.record(merge) };
            entry.note_beginning(after, update);
            let at = Slotted { slot: ring.put(entry), ..self.past[place] };
            self.past.insert(place, at);
            for at in &mut self.past[place + 1..] {
                let later = &mut ring[at.slot];
                later.before.clone_from(&filter);
                at.before = filter.time();
                // What cannot be done again leaves the state of the update before it.
                match again(&mut filter, &later.update, config) {
                    Ok(done) => after.reborn |= done.reborn,
                    Err(_) => filter.clone_from(&later.before),
                }
            }
            self.now = filter;
            after
        };
        self.forget_before(oldest, ring);
        let After { position_m, velocity_mps, reborn } = after;
        if reborn {
            Applied::Reborn { position_m, velocity_mps }
        } else {
            Applied::Taken { position_m, velocity_mps }
        }
    }

    /// Where the track was at `then`, by all plots it has had by now; nothing if it was not there yet, or its state then
    /// is not kept any more.
    pub(super) fn second_ago(
        &self,
        then: SimTime,
        config: &TrackingConfig,
        ring: &Ring,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        if self.born > then {
            return None;
        }
        let life = &config.life;
        if self.now.time() <= then {
            return Lag::of(&self.now, then, life).ok().map(|lag| lag.copy());
        }
        let first = self.past.iter().position(|at| {
            // The update that it leads to came after.
            ring[at.slot].update.time() > then
        })?;
        let before = &ring[self.past[first].slot].before;
        if let TrackFilter::Considering(filter) = before {
            let mut filter = filter.clone();
            if then.since_s(filter.time()) > life.constant_velocity_after_s {
                // After a long gap as its next update will find it, slow errors and all.
                filter.replace(then, &predict(before, then, life).ok()?.state);
            }
            return self.revised(filter.copied(then).ok()?, first, config, ring);
        }
        let mut lag = Lag::of(before, then, life).ok()?;
        for at in &self.past[first..] {
            let Entry { before, update } = &ring[at.slot];
            let done = match update {
                // What no prediction foresaw says little of what was before it.
                Record::Plot(taken) if taken.manoeuvre => Err(UpdateError::UnsoundPlot),
                Record::Plot(taken) => lag.update(before, &[(taken.plot(), 1.0)], life),
                Record::Weighted(plots) => lag.update(before, &whole(plots), life),
                Record::Restart(_) => Err(UpdateError::UnsoundPlot),
            };
            if done.is_err() {
                lag.forget();
            }
        }
        Some(lag.copy())
    }

    /// The copied position of `filter` after the updates from the one at place `first` of the past.
    fn revised(
        &self,
        mut filter: Consider,
        first: usize,
        config: &TrackingConfig,
        ring: &Ring,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let mut found = filter.copy()?;
        for at in &self.past[first..] {
            let update = &ring[at.slot].update;
            if update.time().since_s(filter.time()) > config.life.constant_velocity_after_s {
                break;
            }
            // What no prediction foresaw says little of what was before it.
            let done = match update {
                Record::Plot(taken) if taken.manoeuvre => break,
                Record::Restart(_) => break,
                Record::Plot(taken) => {
                    let plot = taken.plot();
                    filter.update(&plot, slow_error(&plot, config), false)
                }
                Record::Weighted(plots) => {
                    let plots = whole(plots);
                    let Some((plot, _)) = plots.first() else { break };
                    filter.update_weighted(&plots, slow_error(plot, config))
                }
            };
            let Some(copy) = done.ok().and_then(|()| filter.copy()) else { break };
            found = copy;
        }
        Some(found)
    }

    /// Begins again from the last plot; false if there is none that can begin a track.
    pub(super) fn begin_again(&mut self, config: &TrackingConfig, ring: &Ring) -> bool {
        let plot = match self.past.last().map(|at| &ring[at.slot].update) {
            Some(Record::Plot(taken)) => taken.plot(),
            Some(Record::Restart(both)) => both[1].plot(),
            Some(Record::Weighted(plots)) => *likeliest(&whole(plots)),
            None => return false,
        };
        let Ok(fresh) = TrackFilter::from_plot(config, &plot) else { return false };
        self.now = fresh;
        true
    }

    /// A plot that was more likely of this target than not has been taken.
    pub(super) fn note_hit(&mut self, plot: &Plot, interval_s: f64) {
        self.plots += 1;
        self.updated = true;
        self.due = self.due.max(plot.time.plus_s(interval_s));
        self.interval_s = interval_s;
        self.last_hit = self.last_hit.max(plot.time);
        self.altitude_m = plot.altitude_m.or(self.altitude_m);
        self.refused = None;
        self.learn_identity(plot.identity);
        match self.updated_by.iter_mut().find(|by| by.sensor == plot.sensor) {
            Some(by) if by.time > plot.time => {}
            Some(by) => *by = UpdatedBy::of(plot),
            None => self.updated_by.push(UpdatedBy::of(plot)),
        }
        if plot.identity.is_some() {
            self.name_refused = 0;
            self.named_at = self.named_at.max(plot.time);
        }
    }

    /// Forgets updates that no plot may come before any more, all but the last.
    fn forget_before(&mut self, oldest: SimTime, ring: &mut Ring) {
        let kept = self.past.iter().skip(1).take_while(|at| at.before < oldest).count();
        self.past.drain(..kept).for_each(|at| ring.free(at.slot));
    }
}

impl<'a> Update<'a> {
    /// The plot that names the update (of several, the likeliest).
    #[inline]
    fn plot(&self) -> &'a Plot {
        match *self {
            Self::Plot(p) | Self::Manoeuvre(p) | Self::Restart(_, p) => p,
            Self::Weighted(plots) => likeliest(plots),
        }
    }

    fn record(&self, merged: bool) -> Record {
        let of = |plot| Taken { merged, ..Taken::of(plot) };
        match *self {
            Self::Plot(p) => Record::Plot(of(p)),
            Self::Manoeuvre(p) => Record::Plot(Taken { manoeuvre: true, ..of(p) }),
            Self::Restart(a, b) => Record::Restart(Box::new([of(a), of(b)])),
            Self::Weighted(plots) => {
                Record::Weighted(plots.iter().map(|(plot, beta)| (of(plot), *beta)).collect())
            }
        }
    }
}

impl Record {
    /// Time of the plot that names it.
    fn time(&self) -> SimTime {
        match self {
            Self::Plot(taken) => taken.time,
            Self::Restart(both) => both[1].time,
            Self::Weighted(plots) => {
                plots.first().map_or(SimTime(i64::MIN), |(taken, _)| taken.time)
            }
        }
    }
}

fn whole(plots: &[(Taken, f64)]) -> Vec<(Plot, f64)> {
    plots.iter().map(|(taken, beta)| (taken.plot(), *beta)).collect()
}

fn likeliest(plots: &[(Plot, f64)]) -> &Plot {
    let likeliest = plots.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    &likeliest.expect("a weighted update has a plot").0
}

/// What an update led to.
#[derive(Clone, Copy, Debug)]
struct After {
    position_m: Vector2<f64>,
    velocity_mps: Vector2<f64>,
    /// The filter began again.
    reborn: bool,
}

/// Does an update. A filter that could not go on, or whose state would be none that may be used, begins
/// again from the plot.
///
/// # Errors
/// If the plot cannot be taken at all.
#[inline]
fn step(
    filter: &mut TrackFilter,
    update: Update<'_>,
    merge: bool,
    config: &TrackingConfig,
) -> Result<After, UpdateError> {
    match run(filter, update, merge, config) {
        Ok(()) => {
            if let Some((position_m, velocity_mps)) = filter.sound_motion() {
                return Ok(After { position_m, velocity_mps, reborn: false });
            }
        }
        Err(e @ (UpdateError::BackInTime(_) | UpdateError::UnsoundPlot)) => return Err(e),
        Err(UpdateError::BadInnovation(_) | UpdateError::BadCovariance) => {}
    }
    *filter = TrackFilter::from_plot(config, update.plot())?;
    let (position_m, velocity_mps) = filter.sound_motion().ok_or(UpdateError::BadCovariance)?;
    Ok(After { position_m, velocity_mps, reborn: true })
}

#[inline]
fn run(
    filter: &mut TrackFilter,
    update: Update<'_>,
    merge: bool,
    config: &TrackingConfig,
) -> Result<(), UpdateError> {
    let (time, life) = (update.plot().time, &config.life);
    // After a long gap the state is carried on at constant velocity, not with an old acceleration.
    if time.since_s(filter.time()) > life.constant_velocity_after_s {
        let carried = predict(filter, time, life)?;
        filter.replace(time, &carried.state);
    }
    if merge {
        if let Update::Weighted(plots) = update {
            return filter.update_merged(plots);
        }
        filter.merge();
    }
    match update {
        Update::Plot(plot) => filter.update(plot, config),
        Update::Manoeuvre(plot) => filter.update_manoeuvre(plot, config),
        Update::Restart(first, last) => filter.restart(first, last, &config.filter),
        Update::Weighted(plots) => filter.update_weighted(plots, config),
    }
}

/// The same for an update that was done before.
fn again(
    filter: &mut TrackFilter,
    update: &Record,
    config: &TrackingConfig,
) -> Result<After, UpdateError> {
    match update {
        Record::Plot(taken) => {
            let plot = taken.plot();
            let update =
                if taken.manoeuvre { Update::Manoeuvre(&plot) } else { Update::Plot(&plot) };
            step(filter, update, taken.merged, config)
        }
        Record::Restart(both) => {
            let [first, last] = both.map(|taken| taken.plot());
            step(filter, Update::Restart(&first, &last), both[1].merged, config)
        }
        Record::Weighted(plots) => {
            let merged = plots.first().is_some_and(|(taken, _)| taken.merged);
            step(filter, Update::Weighted(&whole(plots)), merged, config)
        }
    }
}
