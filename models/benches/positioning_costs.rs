//! Measures what every level of every effect of the sensors other than radars adds to a scan, and
//! writes or checks the costs that stand with each model.

#![allow(missing_docs, clippy::print_stdout, reason = "a program")]

#[path = "../src/sensors/radar/sample_shapes.rs"]
mod sample_shapes;

use models::effects::Level;
use models::effects::positioning::{MEASURED, PositioningEffect, PositioningLevels};
use models::environment::Weather;
use models::frames::{Point3, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::config::ConfigError;
use models::sensors::declared::Modelled;
use models::sensors::models;
use models::sensors::planned::Planned;
use models::sensors::radar::shape;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use nix::time::{ClockId, clock_gettime};
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

const TARGETS: usize = 1000;
const SCANS: u64 = 200;
const SPEED_MPS: f64 = 10.0;
const ID: SensorId = SensorId(1);

struct Field(TargetClass);

impl Truth for Field {
    fn len(&self) -> usize {
        TARGETS
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.0
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::new("TARGET")
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        // Fifty lanes; in each, a target over the same place every six seconds.
        let (lane, place) = ((index / 20) as f64, (index % 20) as f64);
        let along_m = (SPEED_MPS * time.s() + 60.0 * place) % 1200.0;
        Some(TargetState {
            position_m: Point3::new(along_m - 600.0, lane * 4.0, 0.0),
            velocity_mps: Vector3::new(SPEED_MPS, 0.0, 0.0),
            heading_rad: std::f64::consts::FRAC_PI_2,
        })
    }
}

/// A sensor of a model that is planned with nothing to lose.
fn sensor(model: &Modelled) -> Result<Box<dyn Planned>, ConfigError> {
    (model.example)(ID)
}

fn now() -> Duration {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

/// A sensor at fixed levels and the least time of its scans so far, per expected report.
struct Run {
    sensor: Box<dyn Sensor>,
    least_ns: f64,
}

impl Run {
    fn new(model: &Modelled, levels: PositioningLevels) -> Self {
        let mut sensor = sensor(model).expect("sound parameters");
        sensor.planning_mut().fix(levels);
        Self { sensor, least_ns: f64::INFINITY }
    }

    fn scan(&mut self, scan: u64, truth: &Field, out: &mut PlotSink) {
        let time = |n: u64| SimTime::from_s(n as f64);
        let interval = ScanInterval { run_seed: 1, scan, from: time(scan - 1), to: time(scan) };
        out.plots.clear();
        out.causes.clear();
        out.looks = 0;
        let start = now();
        self.sensor.scan(&interval, truth, &Weather::default(), out);
        let ns = (now() - start).as_nanos() as f64 / out.looks.max(1) as f64;
        if scan > 3 {
            self.least_ns = self.least_ns.min(ns);
        }
    }
}

/// Every effect of a model with the levels that it comes in.
fn rows(model: &Modelled) -> Vec<(PositioningEffect, Level)> {
    let mut sensor = sensor(model).expect("sound parameters");
    let interval =
        ScanInterval { run_seed: 1, scan: 1, from: SimTime::ZERO, to: SimTime::from_s(1.0) };
    let truth = Field(class());
    sensor.scan(&interval, &truth, &Weather::default(), &mut PlotSink::default());
    let mut rows = Vec::new();
    for row in sensor.plan() {
        let effect = PositioningEffect::ALL.iter().find(|e| e.name() == row.effect);
        let Some(&effect) = effect else { continue };
        // Effects without bound in this scene are planned as skipped; they are measured all the same.
        let given = effect == PositioningEffect::Geometry;
        let level = if given { row.level } else { Level::Exact };
        if effect == PositioningEffect::Latency {
            rows.push((effect, Level::Cheap));
        }
        rows.push((effect, level));
    }
    rows
}

fn class() -> TargetClass {
    TargetClass {
        designator: "A320".into(),
        aircraft: true,
        length_m: 37.6,
        span_m: 35.8,
        height_m: 11.8,
        rcs_m2: 100.0,
        shape: sample_shapes::of(true),
    }
}

fn main() -> ExitCode {
    let write = std::env::args().any(|a| a == "--write");
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return ExitCode::SUCCESS;
    }
    let truth = Field(class());
    let mut out = PlotSink::default();
    let mut measured = Vec::new();
    for model in models() {
        for (effect, level) in rows(model) {
            let nothing = PositioningLevels::NOTHING;
            // Geometry is what a model does with everything left out, beyond constants.
            let (mut on, mut off) = if effect == PositioningEffect::Geometry {
                let first = models().next().expect("models");
                let constants = Run::new(first, nothing);
                (Run::new(model, nothing), constants)
            } else {
                (Run::new(model, nothing.with(effect, level)), Run::new(model, nothing))
            };
            for scan in 1..=SCANS {
                on.scan(scan, &truth, &mut out);
                off.scan(scan, &truth, &mut out);
            }
            let cheap = effect == PositioningEffect::Geometry && level == Level::Cheap;
            let ns = if cheap { 0.0 } else { (on.least_ns - off.least_ns).max(0.0) };
            println!(
                "{:20} {:32} {:8} {ns:8.1} ns of {:.1} (in the table {})",
                model.model.name,
                effect.name(),
                level.name(),
                on.least_ns,
                model.model.cost_ns(effect, level)
            );
            measured.push((model, effect, level, ns));
        }
    }
    if write {
        for model in models() {
            let own: Vec<_> = measured.iter().filter(|row| row.0.model == model.model).collect();
            let rows: Vec<_> = own.iter().map(|row| (row.1, row.2, row.3)).collect();
            if let Err(error) = write_costs(model, &rows) {
                println!("{error}");
                return ExitCode::FAILURE;
            }
        }
        println!("set MEASURED in models/src/effects/positioning.rs");
        return ExitCode::SUCCESS;
    }
    println!("the table: {MEASURED}");
    let off = |row: &&(&Modelled, PositioningEffect, Level, f64)| {
        let table = row.0.model.cost_ns(row.1, row.2);
        row.3 > 3.0 * table + 40.0 || table > 3.0 * row.3 + 40.0
    };
    let changed: Vec<_> = measured.iter().filter(off).collect();
    for (model, effect, level, ns) in &changed {
        println!("{} {} {}: {ns:.0} ns now", model.model.name, effect.name(), level.name());
    }
    let whole = models().map(|m| m.model.costs.len()).sum::<usize>() == measured.len();
    if changed.is_empty() && whole { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Puts what was measured in place of the lines between `costs: &[` and `],` of the model's declaration.
fn write_costs(
    modelled: &Modelled,
    rows: &[(PositioningEffect, Level, f64)],
) -> Result<(), String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(modelled.file);
    let failed = |e: std::io::Error| format!("{}: {e}", path.display());
    let text = std::fs::read_to_string(&path).map_err(failed)?;
    let name = format!("name: \"{}\",", modelled.model.name);
    let (head, rest) = text.split_once(&name).ok_or("no such model")?;
    let (mid, rest) = rest.split_once("costs: &[\n").ok_or("no costs")?;
    let (_, tail) = rest.split_once("    ],\n").ok_or("costs without end")?;
    let mut lines = String::new();
    for (effect, level, ns) in rows {
        let _ = writeln!(lines, "        (E::{effect:?}, Level::{level:?}, {}),", ns.round());
    }
    std::fs::write(&path, format!("{head}{name}{mid}costs: &[\n{lines}    ],\n{tail}"))
        .map_err(failed)
}
