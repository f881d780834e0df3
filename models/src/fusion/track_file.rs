//! One track: its filter, the updates of the last seconds, and what is known of it.

use super::config::{Life, TrackingConfig};
use super::filter::TrackFilter;
use super::registration::Reference;
use crate::association::kinematic_gate::{ClassLimits, Departure};
use crate::filter::{Estimate, Gaussian, UpdateError};
use crate::frames::Vector2;
use crate::plot::{Callsign, Identity, Plot};
use crate::time::SimTime;
use nalgebra::Matrix4;
use std::collections::VecDeque;

/// Stage of a track's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Tentative,
    Confirmed,
    /// Ended in this scan; a confirmed track is published once more.
    Ended,
}

/// What an update does to the filter; kept so that it can be done again.
#[derive(Clone, Debug)]
pub(super) enum Update {
    /// The first plot.
    Start(Plot),
    /// An ordinary plot.
    Plot(Plot),
    /// A plot that only the kinematic gate accepted.
    Manoeuvre(Plot),
    /// Begin again from these two.
    Restart(Plot, Plot),
    /// Several plots with the probability of each, moved to one time.
    Weighted {
        plots: Vec<(Plot, f64)>,
        /// Whether one of them is likelier than none.
        hit: bool,
    },
}

/// One update and the filter after it.
#[derive(Clone, Debug)]
struct Entry {
    update: Update,
    after: TrackFilter,
}

/// How an update went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Applied {
    /// The plot was taken; position and velocity just after it.
    Taken { position_m: Vector2<f64>, velocity_ms: Vector2<f64> },
    /// The filter could not go on: the track was started again from this plot.
    Reborn { position_m: Vector2<f64>, velocity_ms: Vector2<f64> },
    /// The plot was refused by the filter and left no trace.
    Refused,
}

#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Order of birth: the key of all ties.
    pub(super) serial: u64,
    /// Given at confirmation.
    pub(super) number: Option<u16>,
    pub(super) stage: Stage,
    /// Never empty; the last entry is the present state.
    ring: VecDeque<Entry>,
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
    pub(super) published: bool,
    /// Plot of the last scan that both gates refused.
    pub(super) refused: Option<Plot>,
    pub(super) heading_rad: f64,
    pub(super) altitude_m: Option<f64>,
    /// What its plots said it is.
    pub(super) callsign: Option<Callsign>,
    pub(super) address: Option<u32>,
    /// Its own last report of its position.
    pub(super) reference: Option<Reference>,
    /// Line of the flight list.
    pub(super) entry: Option<Callsign>,
    /// The flight list has answered for the present identity.
    pub(super) name_settled: bool,
    pub(super) limits: ClassLimits,
    /// Length and span where the type is known, m.
    pub(super) size_m: Option<(f64, f64)>,
    /// Serial of the track that this one seems to double, and for how many scans.
    pub(super) twin: Option<(u64, u32)>,
}

impl Track {
    pub(super) fn start(
        serial: u64,
        plot: &Plot,
        config: &TrackingConfig,
        interval_s: f64,
    ) -> Result<Self, UpdateError> {
        let after = TrackFilter::from_plot(&config.filter, plot)?;
        let mut track = Self {
            serial,
            number: None,
            stage: Stage::Tentative,
            ring: VecDeque::from([Entry { update: Update::Start(*plot), after }]),
            born: plot.time,
            plots: 1,
            last_hit: plot.time,
            history: 0,
            looks: 0,
            due: plot.time.plus_s(interval_s),
            interval_s,
            updated: true,
            manoeuvre: false,
            published: false,
            refused: None,
            heading_rad: 0.0,
            altitude_m: plot.altitude_m,
            callsign: None,
            address: None,
            reference: None,
            entry: None,
            name_settled: false,
            limits: config.limits_of(None),
            size_m: None,
            twin: None,
        };
        track.learn_identity(plot.identity);
        Ok(track)
    }

    /// A confirmed track in this state, which is all it has.
    pub(super) fn take_over(&mut self, time: SimTime, state: &Gaussian, number: u16) {
        if let Some(entry) = self.ring.back_mut() {
            entry.after.replace(time, state);
        }
        (self.number, self.stage) = (Some(number), Stage::Confirmed);
        (self.history, self.looks, self.plots) = (u32::MAX, u32::BITS, 2);
    }

    /// The filter after the last plot.
    pub(super) fn filter(&self) -> &TrackFilter {
        &self.ring.back().expect("a track has at least one entry").after
    }

    /// Time of the last plot.
    pub(super) fn time(&self) -> SimTime {
        self.filter().time()
    }

    /// The filter as it was at `time`: after the last update that is not later.
    pub(super) fn filter_before(&self, time: SimTime) -> Option<&TrackFilter> {
        self.ring.iter().rev().map(|e| &e.after).find(|f| f.time() <= time)
    }

    /// Whether `plot` may be of this track as far as names go.
    pub(super) fn may_be(&self, identity: Option<Identity>) -> bool {
        match identity {
            Some(Identity::Callsign(c)) => self.callsign.is_none_or(|mine| mine == c),
            Some(Identity::Address(a)) => self.address.is_none_or(|mine| mine == a),
            None => true,
        }
    }

    /// Takes the name away: another track has it now.
    pub(super) fn forget_identity(&mut self) {
        (self.callsign, self.address, self.entry) = (None, None, None);
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
            velocity_ms: estimate.velocity_ms(),
            covariance,
        }
    }

    /// Takes an update at its own time. A late one goes to its place, and all later ones are done
    /// again: the result is that of processing in order.
    pub(super) fn apply(
        &mut self,
        update: Update,
        time: SimTime,
        interval_s: f64,
        config: &TrackingConfig,
    ) -> Applied {
        let place = self.ring.iter().rposition(|e| e.after.time() <= time).map_or(0, |k| k + 1);
        if place == 0 && !matches!(update, Update::Restart(..)) {
            return Applied::Refused; // before the oldest state that is kept
        }
        let mut filter = self.ring[place.max(1) - 1].after.clone();
        let plot = *update.plot();
        let mut reborn = false;
        let hit = !matches!(update, Update::Weighted { hit: false, .. });
        match run(&mut filter, &update, config) {
            Ok(()) => {}
            Err(UpdateError::BadInnovation(_) | UpdateError::BadCovariance) => {
                match TrackFilter::from_plot(&config.filter, &plot) {
                    Ok(fresh) => filter = fresh,
                    Err(_) => return Applied::Refused,
                }
                reborn = true;
            }
            Err(UpdateError::BackInTime(_) | UpdateError::UnsoundPlot) => return Applied::Refused,
        }
        let estimate = filter.estimate();
        let (position_m, velocity_ms) = (estimate.position_m(), estimate.velocity_ms());
        if !(position_m.norm_squared() + velocity_ms.norm_squared()).is_finite() {
            return Applied::Refused;
        }
        let update = if reborn { Update::Start(plot) } else { update };
        self.ring.insert(place, Entry { update, after: filter.clone() });
        for entry in self.ring.range_mut(place + 1..) {
            // What cannot be done again leaves the state of the update before it.
            if run(&mut filter, &entry.update, config).is_err() {
                continue;
            }
            entry.after = filter.clone();
        }
        if hit {
            self.plots += 1;
            self.updated = true;
            self.due = self.due.max(plot.time.plus_s(interval_s));
            self.interval_s = interval_s;
            self.last_hit = self.last_hit.max(plot.time);
            self.altitude_m = plot.altitude_m.or(self.altitude_m);
            self.refused = None;
            self.learn_identity(plot.identity);
        }
        if reborn {
            Applied::Reborn { position_m, velocity_ms }
        } else {
            Applied::Taken { position_m, velocity_ms }
        }
    }

    /// Forgets updates older than `oldest`, all but the last.
    pub(super) fn forget_before(&mut self, oldest: SimTime) {
        while self.ring.len() > 1 && self.ring[1].after.time() < oldest {
            self.ring.pop_front();
        }
    }
}

impl Update {
    /// The plot that names the update (of several, the likeliest).
    fn plot(&self) -> &Plot {
        match self {
            Self::Start(p) | Self::Plot(p) | Self::Manoeuvre(p) | Self::Restart(_, p) => p,
            Self::Weighted { plots, .. } => {
                let likeliest = plots.iter().max_by(|a, b| a.1.total_cmp(&b.1));
                &likeliest.expect("a weighted update has a plot").0
            }
        }
    }
}

fn run(
    filter: &mut TrackFilter,
    update: &Update,
    config: &TrackingConfig,
) -> Result<(), UpdateError> {
    let (time, life) = (update.plot().time, &config.life);
    // After a long gap the state is carried on at constant velocity, not with an old acceleration.
    if time.since_s(filter.time()) > life.constant_velocity_after_s {
        let carried = predict(filter, time, life)?;
        filter.replace(time, &carried.state);
    }
    match update {
        Update::Start(plot) | Update::Plot(plot) => {
            filter.update(plot, &config.sensor(plot.sensor, plot.kind), config)
        }
        Update::Manoeuvre(plot) => filter.update_manoeuvre(plot),
        Update::Restart(first, last) => filter.restart(first, last, &config.filter),
        Update::Weighted { plots, .. } => {
            let borrowed: Vec<_> = plots.iter().map(|(plot, beta)| (plot, *beta)).collect();
            filter.update_weighted(&borrowed)
        }
    }
}

/// The state at `time` without further plots: by the filter's own model for a while, then at constant
/// velocity.
///
/// # Errors
/// If `time` is before the filter's.
pub(super) fn predict(
    filter: &TrackFilter,
    time: SimTime,
    life: &Life,
) -> Result<Estimate, UpdateError> {
    if time.since_s(filter.time()) <= life.constant_velocity_after_s {
        return filter.predicted(time);
    }
    filter
        .predicted(filter.time().plus_s(life.constant_velocity_after_s))?
        .coasted(time, life.coast_q)
}
