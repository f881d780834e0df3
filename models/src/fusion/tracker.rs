//! The pipeline: one scan of plots in, tracks out.

use super::budget::Budget;
use super::buffers::Batch;
use super::config::{SensorModel, TrackingConfig};
use super::doubt::Doubt;
use super::numbers::Numbers;
use super::own::{Association, Initiation};
use super::places::Places;
use super::registration::{Registration, SiteBias};
use super::resting::Resting;
use super::stages::batches::sound;
use super::stages::gated::lay_out;
use super::stages::{doubles, labels};
use super::state::{Outcome, Statistics, Tracker, Work};
use super::track_file::{Stage, Track};
use super::way::Ring;
use crate::association::gate::chi_square_quantile;
use crate::filter::{Gaussian, Rung};
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::plot::{Plot, SensorId, SensorKind};
use crate::time::SimTime;
use crate::track::SystemTrack;
use std::collections::VecDeque;
use std::sync::Arc;

impl Tracker {
    /// A tracker without tracks. Its [`Self::config`] names what is done: `imm3` where `mh9-map` was asked for without a
    /// map. Numbers of sensors that cannot be used ([`TrackingConfig::check`]) are replaced by the defaults of their kind.
    #[must_use]
    pub fn new(mut config: TrackingConfig) -> Self {
        config.sensors.iter_mut().for_each(|sensor| *sensor = sensor.sound());
        // A rung that has nothing to go by is not called by its name.
        if config.filter.rung == Rung::Mh9Map && config.filter.map.is_none() {
            config.filter.rung = Rung::Imm3;
        }
        let numbers = Numbers::new(config.life.numbers, config.life.number_rest_s);
        let registration = Registration::new(config.echo_law());
        let gate_1 = chi_square_quantile(2, config.gates.probability);
        let identified_gate = chi_square_quantile(2, config.gates.identified_probability);
        let kinematic_gate = chi_square_quantile(2, config.gates.kinematic_probability);
        let work = Work { budget: Budget::new(&config), ..Work::default() };
        Self {
            config,
            tracks: Vec::new(),
            numbers,
            registration,
            next_serial: 0,
            last_scan: None,
            previous: None,
            seen: VecDeque::new(),
            statistics: Statistics::default(),
            outcomes: Vec::new(),
            gate_1,
            identified_gate,
            kinematic_gate,
            oldest: SimTime(i64::MIN),
            ring: Ring::default(),
            outside: Vec::new(),
            labels: Resting::default(),
            places: Places::default(),
            association: None,
            initiation: None,
            work,
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &TrackingConfig {
        &self.config
    }

    /// Counters since the start.
    #[must_use]
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Estimated constant errors of the radars' sites.
    #[must_use]
    pub fn site_biases(&self) -> Vec<SiteBias> {
        self.registration.biases()
    }

    /// What became of each plot of the last [`Self::scan`], index by index. For evaluation: the truth
    /// at the plot's time can be held against the track's state just after the plot.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// With somebody's own rule of which gated plot each confirmed track gets.
    #[must_use]
    pub fn with_association(mut self, own: Arc<dyn Association>) -> Self {
        self.association = Some(own);
        self
    }

    /// With somebody's own rule of which plots begin tracks and when a track is confirmed.
    #[must_use]
    pub fn with_initiation(mut self, own: Arc<dyn Initiation>) -> Self {
        self.initiation = Some(own);
        self
    }

    /// Takes over confirmed tracks with known states (a hand-over, or a study that starts from truth).
    /// States that no filter can start from, and those beyond the last number, are left out; gives
    /// how many were taken.
    pub fn adopt(&mut self, time: SimTime, states: &[Gaussian]) -> usize {
        let before = self.tracks.len();
        for state in states {
            let model = SensorModel::default_of(SensorId(0), SensorKind::Asde);
            let plot = Plot {
                sensor: SensorId(0),
                kind: model.kind,
                time,
                sequence: 0,
                position_m: state.position(),
                axis: Vector2::new(1.0, 0.0),
                along_m2: 1.0,
                across_m2: 1.0,
                altitude_m: None,
                polar: None,
                identity: None,
                scnr_db: None,
            };
            if !sound(&plot) || !state.is_sound() {
                continue;
            }
            let track = Track::start(self.next_serial, &plot, &self.config, &model);
            let Ok(mut track) = track else { continue };
            let Some(number) = self.numbers.take(time, false) else { break };
            track.take_over(time, state, number);
            track.doubt = self.config.life.existence.map(|_| Box::new(Doubt::sure(&plot, &model)));
            self.next_serial += 1;
            self.statistics.started += 1;
            self.statistics.confirmed += 1;
            self.tracks.push(track);
        }
        self.last_scan = self.last_scan.max(Some(time));
        self.tracks.len() - before
    }

    /// Says which plots of the next [`Self::scan`] came in from outside the federation, index by index.
    /// Tracks that they begin take their numbers behind all others and no label by place, and they do
    /// not register radars; else they are plots as any.
    pub fn mark_outside(&mut self, outside: Vec<bool>) {
        self.outside = outside;
    }

    /// Serials (order of birth) of all tracks, with their numbers once they are confirmed.
    pub fn serials(&self) -> impl Iterator<Item = (u64, Option<u16>)> {
        self.tracks.iter().map(|track| (track.serial, track.number))
    }

    /// One update cycle: all plots up to `t_out` that have not been given before, in any order.
    ///
    /// Gives the confirmed tracks at `t_out` in order of their numbers; a track that ended in this
    /// scan comes once more with `TrackStatus::Last`. The stored states stay at their last plots.
    /// If `t_out` is before that of the last scan, everything is forgotten (and counted): a clock
    /// that was set back leaves nothing to continue from.
    pub fn scan(
        &mut self,
        t_out: SimTime,
        plots: &[Plot],
        flights: &FlightList,
    ) -> Vec<SystemTrack> {
        let sorted;
        let flights = if flights.is_sorted() {
            flights
        } else {
            sorted = flights.sorted();
            &sorted
        };
        self.begin(t_out);
        let mut work = std::mem::take(&mut self.work);
        self.take_in(t_out, plots, &mut work);
        self.sort_tracks(&mut work);
        work.budget.begin();
        if self.config.life.existence.is_some() {
            work.entrances.fill(flights, self.config.labels.final_length_m);
        }
        work.light = !work.budget.bears(self.tracks.len());
        self.statistics.light_scans += u64::from(work.light && work.budget.dear());
        for batch in 0..work.batches.len() {
            let Batch { from, to } = work.batches[batch];
            self.associate_batch(from, to, &mut work);
        }
        let mut out = self.end_of_scan(t_out, flights, &mut work.seen);
        let (labels, tracks) = (&mut self.labels, &mut self.tracks);
        let with = (&mut work.pairing, &mut work.budget);
        let changes = labels::assign(labels, tracks, flights, &self.config, t_out, with);
        self.statistics.identity_conflicts += changes.conflicts;
        self.statistics.label_revisions += changes.revisions;
        let (tracks, statistics) = (&mut self.tracks, &mut self.statistics);
        let scan = (self.previous, &self.config);
        doubles::merge_duplicates(tracks, &out, scan, &mut work, statistics);
        self.publish(t_out, flights, &work.seen, &mut out);
        let spent = work.budget.spent();
        self.statistics.evaluations += spent;
        self.statistics.most_evaluations = self.statistics.most_evaluations.max(spent);
        self.work = work;
        self.outside.clear();
        out
    }

    /// Gives the plots `candidates[from..to]` (one sensor, one interval) to tracks; starts new ones.
    pub(super) fn associate_batch(&mut self, from: usize, to: usize, work: &mut Work) {
        let first = work.candidates[from].plot;
        let model = self.config.sensor(first.sensor, first.kind);
        let none = (SimTime(i64::MAX), SimTime(i64::MIN));
        work.span = work.candidates[from..to]
            .iter()
            .fold(none, |span, c| (span.0.min(c.plot.time), span.1.max(c.plot.time)));
        work.track_used.clear();
        work.track_used.resize(self.tracks.len(), false);
        self.take_identified(from, to, &model, work);
        lay_out(from, to, work);
        self.take_gated(from, to, Stage::Confirmed, &model, work);
        lay_out(from, to, work);
        if work.free.is_empty() {
            return;
        }
        self.reachable_pairs(&model, work);
        if self.config.gates.kinematic {
            self.take_manoeuvres(&model, work);
        }
        self.note_refused(&model, work);
        self.take_gated(from, to, Stage::Tentative, &model, work);
        self.mark_other_echoes(from, to, work);
        self.start_tracks(from, to, &model, work);
    }
}
