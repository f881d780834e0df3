//! The sensor model and data fusion module: truth and weather in, plots and system tracks out, once a scan.
//!
//! Truth is only what arrived as PDUs, dead-reckoned to the time at which each sensor looks
//! ([`received_truth`]); sensors make plots, the tracker makes tracks, [`evaluation`] holds both
//! against the truth that the sensors received. The tracker never sees that truth.

pub mod change;
pub mod command;
pub mod evaluation;
pub mod foreign;
pub mod foreign_plot;
pub mod front_end;
pub mod inlets;
pub mod intake;
pub mod received_truth;
pub mod remote;
pub mod report;
pub mod setup;

#[cfg(test)]
mod address_tests;
#[cfg(test)]
mod foreign_plot_tests;
#[cfg(test)]
mod handover_tests;
#[cfg(test)]
mod height_tests;
#[cfg(test)]
mod inlet_tests;
#[cfg(test)]
mod silent_tests;
#[cfg(test)]
mod visitor_tests;
#[cfg(test)]
mod weather_tests;

use crate::exchange::flights::flight_list;
use crate::federation::{closes_loop, is_front_end, on_tracks};
use crate::runtime::bus::Class;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::{encode, encode_parts};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Publication};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{
    FederateStatus, FinalReport, Frame, Kind, Notice, RunConfig, ScanReport, TrackNotice,
};
use evaluation::Evaluation;
use foreign::Digests;
use front_end::smdfms_of;
use inlets::Inlets;
use intake::Intake;
use models::flight_list::FlightList;
use models::frames::Point2;
use models::fusion::Tracker;
use models::sensors::{PlotSink, Sensor};
use models::track::SystemTrack;
use remote::Remote;
use scenarios::Scene;
use std::sync::Arc;

/// Figures on the clocks of visitors' senders in a report, at most.
const MOST_CLOCKS: usize = 64;

/// The federate's logic.
pub struct Smdfm {
    scene: Arc<Scene>,
    time: FrameTime,
    seed: u64,
    run: u32,
    intake: Intake,
    flights: FlightList,
    sensors: Vec<Box<dyn Sensor>>,
    inlets: Inlets,
    tracker: Tracker,
    evaluation: Evaluation,
    digests: Digests,
    /// Plots of the sensors that other SMDFMs have.
    remote: Remote,
    exercise: u8,
    explain: bool,
    /// What a fork changed; nothing in a run.
    amend: change::Amend,
    /// A tracker that runs along until a fork takes it.
    warm: Option<Tracker>,
}

impl Smdfm {
    /// The SMDFM of a scene.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8) -> Self {
        let time = FrameTime::of(&scene.run);
        Self {
            time,
            seed: scene.run.seed,
            run: 0,
            intake: Intake::of(&scene, exercise),
            flights: FlightList::default(),
            sensors: Vec::new(),
            inlets: Inlets::default(),
            tracker: Tracker::new(scene.tracking_config()),
            evaluation: Evaluation::default(),
            digests: Digests::default(),
            remote: Remote::default(),
            exercise,
            explain: false,
            amend: change::Amend::default(),
            warm: None,
            scene,
        }
    }

    /// Whether plots shall carry what every simulated effect did to them.
    #[must_use]
    pub fn explaining(mut self, explain: bool) -> Self {
        self.explain = explain;
        self
    }

    fn take_in(&mut self, inputs: &FrameInputs, now: Frame) {
        let came = self.intake.take_in(inputs, now);
        if came.visitors > 0 {
            self.digests.external();
        }
        for plots in &came.plots {
            if self.inlets.take(plots, self.time.start_utc_ns) {
                self.digests.external();
            }
        }
        for (_, notice) in &inputs.notices {
            match notice {
                Notice::Flights(flights) => {
                    self.flights = flight_list(flights, self.scene.flight_list.runways.clone());
                }
                Notice::Outsider { .. }
                | Notice::MoreFlights(_)
                | Notice::Tracks(_)
                | Notice::Wants { .. }
                | Notice::Given(_)
                | Notice::Seat(_)
                | Notice::Stands(_)
                | Notice::Weather(_)
                | Notice::Clearances(_) => {}
                Notice::Plots(plots) => self.remote.take(plots),
            }
        }
    }
}

/// A track as control takes it.
fn track_notice(track: &SystemTrack) -> TrackNotice {
    let label = track.label.as_ref();
    TrackNotice {
        number: track.number,
        callsign: track.callsign().map_or_else(String::new, |c| c.as_str().to_owned()),
        type_designator: label.map_or_else(String::new, |l| l.type_designator.clone()),
        movement: label.map(|l| l.movement),
        first: track.first,
        position_m: Point2::new(track.position_m.x, track.position_m.y),
        velocity_mps: [track.velocity_mps.x, track.velocity_mps.y],
        altitude_m: track.altitude_m,
        last_plot_ns: track.last_plot.0,
    }
}

impl Federate for Smdfm {
    fn kind(&self) -> Kind {
        Kind::Smdfm
    }

    fn period(&self) -> Frame {
        u64::from(self.scene.run.frames_per_scan)
    }

    fn consumes(&self) -> bool {
        true
    }

    fn logs(&self, producer: &str) -> bool {
        is_front_end(producer)
    }

    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        // Control reads the tracks; nothing of it is for the sensors.
        (producer != Kind::Control.name()).then_some(0)
    }

    fn in_loop(&self) -> bool {
        closes_loop(&self.scene) && on_tracks(&self.scene)
    }

    fn configure(&mut self, config: &RunConfig, _out: &mut FrameOut) -> Result<(), String> {
        self.seed = config.seed;
        self.run = config.run;
        self.intake = Intake::of(&self.scene, self.exercise);
        self.flights = FlightList::default();
        let smdfms = smdfms_of(config);
        self.sensors = front_end::sensors_of(&self.scene, 1, smdfms)?;
        self.remote = Remote::default();
        let tracking = self.scene.tracking_config();
        tracking.check().map_err(|e| format!("tracking: {e}"))?;
        self.tracker = Tracker::new(tracking);
        self.inlets = Inlets::of(&self.scene)?;
        self.evaluation = Evaluation::beside(self.inlets.ids());
        self.digests = Digests::default();
        Ok(())
    }

    fn step(&mut self, frame: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        let began = monotonic_ns();
        self.take_in(inputs, frame);
        let interval = self.intake.interval(self.seed, frame, self.period());
        let weather = self.intake.weather_at(frame - self.period());
        let weather = self.amend.weather(weather);
        let view = self.intake.truth.view(interval.from, interval.to);
        let mut sink = PlotSink { explain: self.explain, ..PlotSink::default() };
        let mut looks = Vec::new();
        for sensor in &mut self.sensors {
            let (plots, before) = (sink.plots.len(), sink.looks);
            sensor.scan(&interval, &view, &weather, &mut sink);
            self.inlets.scan(sensor.id(), &interval, &mut sink);
            self.remote.scan(sensor.id(), sensor.kind(), &mut sink);
            looks.push((sensor.kind(), sink.looks - before, sink.plots.len() - plots));
        }
        let outside = foreign::of_outsiders(&view, &sink, &self.inlets);
        if outside.contains(&true) {
            self.tracker.mark_outside(outside.clone());
        }
        let tracks = self.tracker.scan(interval.to, &sink.plots, &self.flights);
        let took_ns = monotonic_ns() - began;
        if let Some(warm) = &mut self.warm {
            warm.scan(interval.to, &sink.plots, &self.flights);
        }
        self.evaluation.scan(&view, interval.to, &sink, self.tracker.outcomes(), &tracks, &looks);
        self.digests.scan(frame, &sink, &outside, &self.tracker, &tracks);
        if on_tracks(&self.scene) {
            out.notices.push(Notice::Tracks(tracks.iter().map(track_notice).collect()));
        }
        let mut report = report::scan_report(&report::ScanParts {
            run: self.run,
            interval: &interval,
            view: &view,
            sink: &sink,
            outcomes: self.tracker.outcomes(),
            tracks: &tracks,
            evaluation: &self.evaluation,
            plan: self.sensors.iter().flat_map(|s| self.remote.plan_of(&**s)).collect(),
            took_us: took_ns / 1000,
        });
        report.measures.extend(self.intake.truth.clocks().take(MOST_CLOCKS));
        report.measures.extend(report::tracker_values(self.tracker.statistics()));
        if !self.inlets.is_empty() {
            report.measures.push(("foreign_plots".into(), self.inlets.taken() as f64));
        }
        let mut parts = encode_parts(&report);
        let publish = |key: &str, body, retained: Option<&str>| Publication {
            key: key.into(),
            class: Class::Lossy,
            body,
            retained: retained.map(str::to_owned),
        };
        if parts.len() == 1 {
            let body = parts.remove(0);
            out.publish.push(publish("tracks/1/scan", body, Some("tracks/1/list")));
        } else {
            // One answer has one message: of a scan beyond it the tracks alone.
            let list =
                ScanReport { plots: Vec::new(), truth: Vec::new(), plan: Vec::new(), ..report };
            out.publish.extend(parts.into_iter().map(|part| publish("tracks/1/scan", part, None)));
            out.publish.push(publish("tracks/1/list", encode(&list), Some("tracks/1/list")));
        }
        self.intake.truth.forget_before(interval.to);
    }

    fn state(&self) -> u64 {
        self.digests.state()
    }

    fn finish(&mut self, report: &mut FinalReport) {
        self.digests.finish(self.intake.truth.visitors_ever(), report);
        report.values.extend(self.evaluation.values());
        report.values.extend(report::tracker_values(self.tracker.statistics()));
        if !self.inlets.is_empty() {
            report.values.push(("foreign_plots".into(), self.inlets.taken() as f64));
        }
    }

    fn status(&self, status: &mut FederateStatus) {
        status.dropped.extend(self.intake.refused());
        status.dropped.extend(self.inlets.refused());
    }
}
