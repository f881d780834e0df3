//! An SMDFM that has some of the sensors and tells what they saw to the first one, which fuses: for an airport with more sensors than
//! one core scans.
//!
//! Draws are keyed by sensor and entity, and each process takes in the same truth, so that plots are those of one SMDFM to the bit.

use super::inlets::Elsewhere;
use super::intake::Intake;
use super::remote::notices;
use super::report::{plan_line, plot_octets};
use super::setup;
use crate::federation::{is_front_end, smdfm_name, smdfm_of};
use crate::runtime::digest::Digest;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{FederateStatus, FinalReport, Frame, Kind, Notice, RunConfig};
use models::sensors::{PlotSink, Sensor};
use scenarios::Scene;
use std::collections::BTreeMap;
use std::sync::Arc;

/// SMDFMs of a run.
#[must_use]
pub fn smdfms_of(config: &RunConfig) -> u32 {
    1 + config.producers.iter().filter(|name| is_front_end(name)).count() as u32
}

/// The sensors of a scene in its order, those of other SMDFMs as sensors that see nothing.
///
/// # Errors
/// One sentence if a sensor cannot be made.
pub fn sensors_of(scene: &Scene, share: u32, of: u32) -> Result<Vec<Box<dyn Sensor>>, String> {
    let tolerance = setup::tolerance(scene);
    let one = |(at, sensor): (usize, &scenarios::SensorScene)| -> Result<Box<dyn Sensor>, String> {
        let own = smdfm_of(scene, at, of) == share;
        let made = own.then(|| sensor.made(scene, tolerance)).transpose()?.flatten();
        Ok(made.unwrap_or_else(|| Box::new(Elsewhere { id: sensor.id, kind: sensor.kind })))
    };
    scene.sensors.iter().enumerate().map(one).collect()
}

/// The federate's logic.
pub struct FrontEnd {
    scene: Arc<Scene>,
    exercise: u8,
    share: u32,
    of: u32,
    seed: u64,
    intake: Intake,
    sensors: Vec<Box<dyn Sensor>>,
    /// Lines of the plans as they were told, by sensor.
    plans: BTreeMap<u16, Vec<[String; 5]>>,
    plots: Digest,
    explain: bool,
}

impl FrontEnd {
    /// SMDFM `share` (from 2) of `of` of a scene.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8, share: u32, of: u32) -> Self {
        Self {
            seed: scene.run.seed,
            intake: Intake::of(&scene, exercise),
            sensors: Vec::new(),
            plans: BTreeMap::new(),
            plots: Digest::default(),
            explain: false,
            scene,
            exercise,
            share,
            of,
        }
    }

    /// Whether plots shall carry what every simulated effect did to them.
    #[must_use]
    pub fn explaining(mut self, explain: bool) -> Self {
        self.explain = explain;
        self
    }
}

impl Federate for FrontEnd {
    fn kind(&self) -> Kind {
        Kind::Smdfm
    }

    fn period(&self) -> Frame {
        u64::from(self.scene.run.frames_per_scan)
    }

    fn consumes(&self) -> bool {
        true
    }

    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        // Truth, weather and what came from outside; nothing of those that read it.
        let read = producer != Kind::Control.name() && producer != smdfm_name(1);
        (read && !is_front_end(producer)).then_some(0)
    }

    fn in_loop(&self) -> bool {
        // The one that fuses waits for each of its scans.
        true
    }

    fn configure(&mut self, config: &RunConfig, _out: &mut FrameOut) -> Result<(), String> {
        let smdfms = smdfms_of(config);
        if self.of != smdfms {
            return Err(format!(
                "this SMDFM has share {}/{}, but the federation has {smdfms}: give --share I/{smdfms}, or the administration station --smdfms {}",
                self.share, self.of, self.of
            ));
        }
        self.seed = config.seed;
        self.intake = Intake::of(&self.scene, self.exercise);
        self.sensors = sensors_of(&self.scene, self.share, self.of)?;
        self.plans.clear();
        self.plots = Digest::default();
        Ok(())
    }

    fn step(&mut self, frame: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        // Plots of somebody else's sensors are for the one that fuses.
        let _ = self.intake.take_in(inputs, frame);
        let interval = self.intake.interval(self.seed, frame, self.period());
        let weather = self.intake.weather_at(frame - self.period());
        let view = self.intake.truth.view(interval.from, interval.to);
        for sensor in &mut self.sensors {
            let mut sink = PlotSink { explain: self.explain, ..PlotSink::default() };
            sensor.scan(&interval, &view, &weather, &mut sink);
            sink.plots.iter().for_each(|plot| self.plots.add(frame, &plot_octets(plot)));
            let id = sensor.id();
            let plan: Vec<_> = sensor.plan().iter().map(plan_line).collect();
            let is_news = self.plans.get(&id.0).map_or(&[][..], Vec::as_slice) != plan;
            let news = is_news.then(|| plan.clone());
            self.plans.insert(id.0, plan);
            out.notices.extend(notices(id, &sink, news).map(Notice::Plots));
        }
        self.intake.truth.forget_before(interval.to);
    }

    fn state(&self) -> u64 {
        self.plots.0
    }

    fn finish(&mut self, _report: &mut FinalReport) {}

    fn status(&self, status: &mut FederateStatus) {
        status.dropped.extend(self.intake.refused());
    }
}
