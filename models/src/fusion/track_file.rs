//! One track: its way, and what is known of it.

use super::config::{SensorModel, TrackingConfig};
use super::doubt::Doubt;
use super::extent::{Extent, Moments};
use super::filter::TrackFilter;
use super::identity::Evidence;
use super::near_side::{Body, EchoLaw};
use super::registration::{Reference, Registration};
use super::rest::Rest;
use super::size::{self, Spread};
use super::way::Way;
use crate::association::kinematic_gate::{ClassLimits, Departure};
use crate::filter::{Gaussian, UpdateError};
use crate::frames::{Matrix2, Vector2};
use crate::plot::{Callsign, Identity, Plot, SensorId};
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

/// Slower than this one stands, m/s (assumed; transponders tell of who is parked below 0.5).
const STANDS_MPS: f64 = 1.0;

/// Slower targets show no course, m/s.
const COURSE_FROM_MPS: f64 = 2.0;

/// Echoes whose variance is so many times what is stated are those of a large body.
const WANDERS: f64 = 1.5;

#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Order of birth: the key of all ties.
    pub(super) serial: u64,
    /// The plot of an outsider began it.
    pub(super) outside: bool,
    /// Given at confirmation.
    pub(super) number: Option<u16>,
    pub(super) stage: Stage,
    /// Its filter, with the updates of the last seconds.
    pub(super) way: Way,
    pub(super) born: SimTime,
    pub(super) plots: u32,
    /// Time of the last plot that was more likely of this target than not.
    pub(super) last_hit: SimTime,
    /// One bit for each expected update, the newest lowest.
    pub(super) history: u32,
    pub(super) looks: u32,
    /// Since when the next update is missed.
    pub(super) due: SimTime,
    /// The last expected update that did not come.
    pub(super) missed: Option<Missed>,
    /// In this scan it had a plot that was measured before that, and one that was not.
    pub(super) came_late: bool,
    pub(super) came_in_time: bool,
    /// Interval of the sensor that updated it last, s.
    pub(super) interval_s: f64,
    /// How long after its last plot it is missed, s, and of which sensor that plot was.
    pub(super) wait_s: f64,
    pub(super) heard_by: SensorId,
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
    /// The last height reported, m, and when.
    pub(super) altitude: Option<(f64, SimTime)>,
    /// What its plots said it is.
    pub(super) callsign: Option<Callsign>,
    pub(super) address: Option<u32>,
    /// Time of the last plot that said so, and how often such come, s.
    pub(super) named_at: SimTime,
    pub(super) named_every_s: f64,
    /// Its own last report of its position.
    pub(super) reference: Option<Box<Reference>>,
    /// When one of its plots was held against a lane last.
    pub(super) lane_at: Option<SimTime>,
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

/// An expected update that did not come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Missed {
    /// End of the scan in which it was missed.
    pub(super) at: SimTime,
    /// Looks with that one.
    pub(super) looks: u32,
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
        model: &SensorModel,
    ) -> Result<Self, UpdateError> {
        let (interval_s, wait_s) =
            (model.interval_s, model.interval_s.max(model.standing_interval_s));
        let mut way = Way::from_plot(plot, config)?;
        way.expect(interval_s);
        let mut track = Self {
            serial,
            outside: false,
            number: None,
            stage: Stage::Tentative,
            way,
            born: plot.time,
            plots: 1,
            last_hit: plot.time,
            history: 0,
            looks: 0,
            due: plot.time.plus_s(wait_s),
            missed: None,
            came_late: false,
            came_in_time: true,
            interval_s,
            wait_s,
            heard_by: plot.sensor,
            updated: true,
            manoeuvre: false,
            rest: Rest::begun(plot),
            published: false,
            refused: None,
            restarted: false,
            unresolved: false,
            too_fast: 0,
            heading_rad: 0.0,
            altitude: plot.altitude_m.map(|height_m| (height_m, plot.time)),
            callsign: None,
            address: None,
            named_at: plot.time,
            named_every_s: wait_s,
            reference: None,
            lane_at: None,
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
        self.way.replace(time, state);
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
        } else if matches!(self.filter(), TrackFilter::Considering(_)) {
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
        self.way.filter()
    }

    /// Time of the last plot.
    #[inline]
    pub(super) fn time(&self) -> SimTime {
        self.filter().time()
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

    /// Takes over what another track is called by its plots.
    pub(super) fn take_name_of(&mut self, other: &Self) {
        self.forget_identity();
        (self.callsign, self.address) = (other.callsign, other.address);
        (self.named_at, self.named_every_s) = (other.named_at, other.named_every_s);
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

    /// A plot that was more likely of this target than not has been taken.
    ///
    /// Of one that stands, and that one sensor alone tells of, nothing is missed before that tells of who stands.
    pub(super) fn note_hit(&mut self, plot: &Plot, model: &SensorModel) {
        self.plots += 1;
        self.updated = true;
        let late = self.missed.is_some_and(|missed| plot.time <= missed.at);
        self.came_late |= late;
        self.came_in_time |= !late;
        let stands = self.filter().motion().1.norm() < STANDS_MPS && plot.sensor == self.heard_by;
        let slowest_s = model.interval_s.max(model.standing_interval_s);
        let waited_s =
            std::mem::replace(&mut self.wait_s, if stands { slowest_s } else { model.interval_s });
        // Who sets off is missed as soon as his next report lacks, not when the one of who stands was due.
        let due = plot.time.plus_s(self.wait_s);
        let sets_off = !stands && waited_s > model.interval_s;
        self.due = if sets_off { due.max(self.last_hit) } else { self.due.max(due) };
        (self.interval_s, self.heard_by) = (model.interval_s, plot.sensor);
        self.way.expect(model.interval_s);
        self.last_hit = self.last_hit.max(plot.time);
        if let Some(height_m) = plot.altitude_m
            && self.altitude.is_none_or(|(_, at)| at <= plot.time)
        {
            self.altitude = Some((height_m, plot.time));
        }
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
            self.named_every_s = slowest_s;
        }
    }
}
