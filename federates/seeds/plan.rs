//! `seeds plan SCENE`: which physical effects a scene calls for, without running it.

use crate::external_world::{ExternalWorld, flight_notice};
use crate::federation::{RunOptions, conductor_config};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, FAILED, fail, load_scene};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{Notice, RunConfig, ScanReport};
use crate::smdfm::{Smdfm, setup};
use crate::traffic_generator::TrafficGenerator;
use clap::Args;
use models::effects::{PlanRow, Tolerance, changes};
use models::environment::Weather;
use models::frames::Vector3;
use models::plot::Callsign;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use scenarios::Scene;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Which effects a scene calls for: bound, decision, level and cost of each
#[derive(Args, Clone, Debug)]
pub struct PlanArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// Simulated time to plan for, s [default: every time at which the weather changes]
    #[arg(long, value_name = "T")]
    at: Option<f64>,

    /// What every simulated effect did to the plots of this target at the time of --at
    #[arg(long, value_name = "CALLSIGN", requires = "at")]
    explain: Option<String>,

    /// Write what the first radar of the scene shows of the turn after --at, cell by cell, as a PNG
    #[arg(long, value_name = "FILE", requires = "at", conflicts_with = "explain")]
    video: Option<PathBuf>,

    /// Ground distance at the rim of that picture, m, 100 to 100000 [default: the radar's display range]
    #[arg(long, value_name = "M", requires = "video", value_parser = rim)]
    rim: Option<f64>,

    /// Width of that picture, pixels, 64 to 8192
    #[arg(long, value_name = "N", requires = "video", default_value_t = 1600, value_parser = clap::value_parser!(u16).range(64..=8192))]
    size: u16,

    /// JSON: one object a line of the plan
    #[arg(long)]
    json: bool,
}

fn rim(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(metres) if (100.0..=100_000.0).contains(&metres) => Ok(metres),
        _ => Err(format!("'{text}' is not a distance from 100 to 100000 m")),
    }
}

/// Prints the plan.
#[must_use]
pub fn run(args: &PlanArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    let scene = match load_scene(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    if let Some(at) = args.at
        && !(0.0..=scene.run.duration.s()).contains(&at)
    {
        let end = scene.run.duration.s();
        return fail(cli::BAD_INPUT, format!("--at {at}: the scene lasts from 0 to {end} s"));
    }
    let movers = &scene.traffic.entities;
    if let Some(asked) = &args.explain
        && !movers.iter().any(|e| e.callsign.as_str() == asked)
    {
        let known: Vec<_> = movers.iter().map(|e| e.callsign.as_str()).collect();
        let known = known.join(", ");
        return fail(cli::BAD_INPUT, format!("--explain {asked}: the scene has {known}"));
    }
    let outcome = match (&args.explain, &args.video, args.at) {
        (Some(callsign), _, Some(at)) => explain(&scene, callsign, at, args.json),
        (_, Some(file), Some(at)) => video(&scene, file, at, args),
        _ => plan(&scene, args.at, args.json),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// The picture of a whole turn.
fn video(scene: &Scene, file: &Path, at: f64, args: &PlanArgs) -> anyhow::Result<()> {
    let png =
        studies::picture::video_png(scene, SimTime::from_s(at), usize::from(args.size), args.rim)
            .map_err(anyhow::Error::msg)?;
    cli::save(file, png)
}

/// The traffic of a scene at one time, exact, as the planner looks at it.
struct Traffic<'a> {
    scene: &'a Scene,
    present: Vec<usize>,
}

impl<'a> Traffic<'a> {
    fn at(scene: &'a Scene, time: SimTime) -> Self {
        let there = |i: &usize| {
            scene.traffic.entities[*i].trajectory.as_ref().is_some_and(|t| t.within(time))
        };
        Self { scene, present: (0..scene.traffic.entities.len()).filter(there).collect() }
    }
}

impl Truth for Traffic<'_> {
    fn len(&self) -> usize {
        self.present.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.present[index] as u64
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.scene.traffic.entities[self.present[index]].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.scene.traffic.entities[self.present[index]].callsign
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.scene.traffic.entities[self.present[index]].address
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let truth =
            self.scene.traffic.entities[self.present[index]].trajectory.as_ref()?.at(time)?;
        Some(TargetState {
            position_m: Vector3::new(truth.position_m.x, truth.position_m.y, truth.position_m.z),
            velocity_ms: truth.velocity_ms,
            heading_rad: truth.heading_rad,
        })
    }
}

/// The rows of all sensors at a time, at a tolerance.
fn rows(scene: &Scene, time: SimTime, tolerance: Tolerance) -> anyhow::Result<Vec<PlanRow>> {
    let mut sensors: Vec<Box<dyn Sensor>> =
        setup::make_sensors_for(scene, tolerance).map_err(|e| anyhow::anyhow!(e))?;
    let notice = scene.weather.iter().rev().find(|n| n.time <= time);
    let weather = notice.map_or_else(Weather::default, |n| n.weather.clone());
    let truth = Traffic::at(scene, time);
    let scan = scene.run.scan();
    let interval = ScanInterval {
        run_seed: scene.run.seed,
        scan: (time.0 / scan.0) as u64 + 1,
        from: time,
        to: SimTime(time.0 + scan.0),
    };
    let mut rows = Vec::new();
    for sensor in &mut sensors {
        sensor.scan(&interval, &truth, &weather, &mut PlotSink::default());
        rows.extend(sensor.plan().iter().cloned());
    }
    Ok(rows)
}

fn plan(scene: &Scene, at: Option<f64>, json: bool) -> anyhow::Result<()> {
    let times: Vec<SimTime> = match at {
        Some(at) => vec![SimTime::from_s(at)],
        None => scene.weather.iter().map(|n| n.time).collect(),
    };
    let tolerance = setup::tolerance(scene);
    for time in times {
        let rows = rows(scene, time, tolerance)?;
        if json {
            for row in &rows {
                let line = json!({
                    "at_s": time.s(), "sensor": row.sensor.0, "effect": row.effect,
                    "called_for": row.called_for,
                    "bound": Some(row.bound).filter(|b| b.is_finite()), "unit": row.unit,
                    "skipped": row.is_skipped(), "level": format!("{:?}", row.level).to_lowercase(),
                    "cost_ns": row.cost_ns,
                });
                out!("{line}");
            }
            continue;
        }
        out!(
            "{} at {:.0} s, tolerance {} m and {} of detection",
            scene.name,
            time.s(),
            tolerance.position_m,
            tolerance.detection
        );
        let wide = scene.sensors.iter().map(|s| s.name.chars().count()).max().unwrap_or(0).max(10);
        out!(
            "  {:<wide$}  {:<32}{:>16}  {:<10}{:>9}  called for by",
            "sensor",
            "effect",
            "bound",
            "decision",
            "ns/target"
        );
        let name_of = |id| scene.sensors.iter().find(|s| s.id == id).map_or("", |s| &*s.name);
        for row in &rows {
            let name = name_of(row.sensor);
            let [_, effect, called_for, bound, _] = crate::smdfm::report::plan_line(row);
            let level = format!("{:?}", row.level).to_lowercase();
            out!(
                "  {name:<wide$}  {effect:<32}{bound:>16}  {level:<10}{:>9.0}  {called_for}",
                row.cost_ns
            );
        }
        for (word, factor) in [("a tenth", 0.1), ("ten times", 10.0)] {
            let other = self::rows(scene, time, tolerance.times(factor))?;
            let changed: Vec<String> = changes(&rows, &other)
                .iter()
                .map(|c| {
                    let levels = format!("{:?} instead of {:?}", c.to, c.from).to_lowercase();
                    format!("{}: {} {levels}", name_of(c.sensor), c.effect)
                })
                .collect();
            let text =
                if changed.is_empty() { "nothing changes".to_owned() } else { changed.join(", ") };
            out!("  with {word} of the tolerance: {text}");
        }
        out!();
    }
    Ok(())
}

/// Runs the scene up to a time, without network or clock, and shows a target's plots of that scan.
fn explain(scene: &Arc<Scene>, callsign: &str, at: f64, json: bool) -> anyhow::Result<()> {
    let report = scan_at(scene, at)?;
    let plots: Vec<_> = report.plots.iter().filter(|p| p.cause == callsign).collect();
    if plots.is_empty() {
        let known: Vec<_> = report.truth.iter().map(|t| t.callsign.as_str()).collect();
        anyhow::bail!(
            "no plot of '{callsign}' in the scan that ends at {:.0} s; targets there: {}",
            report.time_ns as f64 * 1e-9,
            known.join(", ")
        );
    }
    for plot in plots {
        if json {
            out!("{}", serde_json::to_string(plot)?);
            continue;
        }
        let [east, north] = plot.position_m;
        out!(
            "{} plot of {callsign} at {:.3} s: east {east:.2} m, north {north:.2} m",
            plot.kind,
            plot.time_ns as f64 * 1e-9
        );
        if let Some([truth_east, truth_north]) = plot.truth_m {
            out!("  error east {:+.2} m, north {:+.2} m", east - truth_east, north - truth_north);
        }
        for (effect, value, unit) in &plot.effects {
            out!("  {effect:<32}{value:>12.4} {unit}");
        }
    }
    Ok(())
}

/// The report of the scan that ends at or after `at` seconds.
fn scan_at(scene: &Arc<Scene>, at: f64) -> anyhow::Result<ScanReport> {
    let exercise = scene.run.exercise;
    let config = conductor_config(scene, &RunOptions::default());
    let run = RunConfig {
        run: 1,
        seed: config.seed,
        producers: config.producers,
        generators: 1,
        last_frame: config.last_frame,
    };
    let mut traffic = TrafficGenerator::new(Arc::clone(scene), exercise, 1, 1);
    let mut world = ExternalWorld::new(Arc::clone(scene), exercise);
    let mut smdfm = Smdfm::new(Arc::clone(scene), exercise).explaining(true);
    let refused = |e: String| anyhow::anyhow!(e);
    let mut made = FrameOut::default();
    traffic.configure(&run, &mut made).map_err(refused)?;
    world.configure(&run, &mut made).map_err(refused)?;
    smdfm.configure(&run, &mut FrameOut::default()).map_err(refused)?;
    let flights = scene.flight_list.entries.iter().map(flight_notice).collect();
    let mut inputs =
        FrameInputs { notices: vec![(0, Notice::Flights(flights))], ..Default::default() };
    let wanted = (at * 1e9 / scene.run.frame.0 as f64).ceil() as u64;
    let last = wanted.next_multiple_of(smdfm.period()).clamp(smdfm.period(), run.last_frame);
    let mut scan = FrameOut::default();
    for frame in 0..=last {
        if frame > 0 {
            made = FrameOut::default();
            traffic.step(frame, &FrameInputs::default(), &mut made);
            world.step(frame, &FrameInputs::default(), &mut made);
        }
        inputs.pdus.extend(made.pdus.drain(..).map(|octets| (frame, octets)));
        if frame > 0 && frame.is_multiple_of(smdfm.period()) {
            scan = FrameOut::default();
            smdfm.step(frame, &std::mem::take(&mut inputs), &mut scan);
        }
    }
    let body = scan.publish.iter().find(|p| p.key == "tracks/1/scan").map(|p| &p.body[..]);
    Ok(crate::runtime::codec::decode(body.unwrap_or_default())?)
}
