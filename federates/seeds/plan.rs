//! `seeds plan SCENE`: which physical effects a scene calls for, without running it.

use super::accuracy::{end_of_progress, show};
use super::plan_report::{self, SensorPlan};
use crate::exchange::flights::flight_notice;
use crate::external_world::ExternalWorld;
use crate::federation::{RunOptions, conductor_config};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, FAILED, fail, load_scene};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{Frame, Notice, RunConfig, ScanReport};
use crate::smdfm::intake::Intake;
use crate::smdfm::{Smdfm, setup};
use crate::traffic_generator::TrafficGenerator;
use clap::Args;
use models::effects::{Change, PlanRow, Tolerance, changes};
use models::environment::Weather;
use models::plot::Callsign;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use models::traffic::core::ClearedBy;
use scenarios::Scene;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Which effects a scene calls for: what is simulated, what is left out with its bound, and what that saves
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

    /// What another radar, ADS-B or multilateration would gain: runs the scene with each set and counts the requirements met
    #[arg(long, conflicts_with_all = ["at", "explain", "video", "all"])]
    advice: bool,

    /// Simulated time of each of these runs at most, s, 10 to 86400
    #[arg(long, value_name = "S", requires = "advice", default_value_t = 600.0, value_parser = advice_seconds)]
    advice_s: f64,

    /// Every row of every sensor, also those of what is not there
    #[arg(long)]
    all: bool,

    /// JSON: one object for each time, sensor and effect, then the totals of each radar
    #[arg(long)]
    json: bool,
}

fn rim(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(metres) if (100.0..=100_000.0).contains(&metres) => Ok(metres),
        _ => Err(format!("'{text}' is not a distance from 100 to 100000 m")),
    }
}

fn advice_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (10.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err(format!("'{text}' is not a time from 10 to 86400 s")),
    }
}

/// What more sensors would gain, by running the scene with them.
fn advice(args: &PlanArgs) -> ExitCode {
    let file = scenarios::locate(&args.scene);
    let text = match scenarios::text_of(&file) {
        Ok(text) => text,
        Err(e) => return fail(cli::BAD_INPUT, e),
    };
    let mut told = false;
    let mut tell = |what: String| {
        told = true;
        show(&what);
    };
    let found = studies::sensor_advice::advise(&file, &text, args.advice_s, &[1, 2], &mut tell);
    if told {
        end_of_progress();
    }
    match found {
        Ok(found) if args.json => {
            let table = found.table();
            let row = |row: &Vec<String>| {
                let cells = table.heads.iter().cloned().zip(row.iter().map(|c| number(c)));
                serde_json::Value::Object(cells.collect())
            };
            let rows: Vec<serde_json::Value> = table.rows.iter().map(row).collect();
            let refused = &found.refused;
            let whole = serde_json::json!({
                "scene": args.scene, "seconds": found.seconds, "seeds": found.seeds, "choices": rows, "refused": refused,
            });
            out!("{whole}");
            ExitCode::SUCCESS
        }
        Ok(found) => {
            out!("{}", found.to_text().trim_end());
            ExitCode::SUCCESS
        }
        Err(e) => fail(cli::BAD_INPUT, e),
    }
}

/// A cell as a number where it is one.
fn number(cell: &str) -> serde_json::Value {
    let number = cell.parse::<f64>().ok().and_then(serde_json::Number::from_f64);
    number.map_or_else(|| cell.into(), serde_json::Value::Number)
}

/// Prints the plan.
#[must_use]
pub fn run(args: &PlanArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    if args.advice {
        return advice(args);
    }
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
        _ => plan(&scene, args),
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
            position_m: truth.position_m,
            velocity_mps: truth.velocity_mps,
            heading_rad: truth.heading_rad,
        })
    }
}

/// The traffic of a scene whose movers behave, as the generator plays it: there is no truth but that.
struct Played {
    generator: TrafficGenerator,
    intake: Intake,
    made: FrameOut,
    next: Frame,
}

impl Played {
    fn of(scene: &Arc<Scene>) -> anyhow::Result<Self> {
        let exercise = scene.run.exercise;
        let mut generator = TrafficGenerator::new(Arc::clone(scene), exercise, 1, 1);
        let mut made = FrameOut::default();
        let run = run_of(scene);
        generator.configure(&run, &mut made).map_err(|e| anyhow::anyhow!(e))?;
        Ok(Self { generator, intake: Intake::of(scene, exercise), made, next: 0 })
    }

    /// Plays on until a time, or the end of the run.
    fn play(&mut self, scene: &Scene, until: SimTime) {
        let last = (until.0 as u64).div_ceil(scene.run.frame.0 as u64).min(scene.run.frames());
        while self.next <= last {
            let mut made = std::mem::take(&mut self.made);
            if self.next > 0 {
                self.generator.step(self.next, &FrameInputs::default(), &mut made);
            }
            let pdus = made.pdus.drain(..).map(|octets| (self.next, octets)).collect();
            self.intake.take_in(&FrameInputs { pdus, ..FrameInputs::default() }, self.next);
            // What a run forgets after each scan; the one that is asked for begins a scan before the end.
            let now = SimTime(scene.run.frame.0 * self.next as i64);
            if now.0 % scene.run.scan().0 == 0 {
                self.intake.truth.forget_before(now.min(SimTime(until.0 - scene.run.scan().0)));
            }
            self.next += 1;
        }
    }
}

/// Scans of the same second until no box waits for its plan.
const SCANS: usize = 200;

/// The plans of all sensors at a time, at a tolerance.
fn plans(
    scene: &Scene,
    truth: &dyn Truth,
    time: SimTime,
    tolerance: Tolerance,
) -> anyhow::Result<Vec<SensorPlan>> {
    let mut sensors: Vec<Box<dyn Sensor>> =
        setup::make_sensors_for(scene, tolerance).map_err(|e| anyhow::anyhow!(e))?;
    let weather = weather_at(scene, time);
    let scan = scene.run.scan();
    let interval = ScanInterval {
        run_seed: scene.run.seed,
        scan: (time.0 / scan.0) as u64 + 1,
        from: time,
        to: SimTime(time.0 + scan.0),
    };
    let names = |index: usize| truth.callsign(index).as_str().to_owned();
    let mut found = Vec::new();
    for (sensor, own) in sensors.iter_mut().zip(&scene.sensors) {
        let mut planned = usize::MAX;
        for _ in 0..SCANS {
            sensor.scan(&interval, truth, &weather, &mut PlotSink::default());
            let now = sensor.boxes().len();
            if std::mem::replace(&mut planned, now) == now {
                break;
            }
        }
        found.push(SensorPlan::of(&own.name, sensor.as_ref(), &names, tolerance));
    }
    Ok(found)
}

/// The weather in force, its cells moved by the wind since its notice.
fn weather_at(scene: &Scene, time: SimTime) -> Weather {
    let notice = scene.weather.iter().rev().find(|n| n.time <= time);
    notice.map_or_else(Weather::default, |n| n.weather.after(time.since_s(n.time)))
}

fn plan(scene: &Arc<Scene>, args: &PlanArgs) -> anyhow::Result<()> {
    let times: Vec<SimTime> = match args.at {
        Some(at) => vec![SimTime::from_s(at)],
        None => scene.weather.iter().map(|n| n.time).collect(),
    };
    let tolerance = setup::tolerance(scene);
    let mut before: Option<Vec<PlanRow>> = None;
    let behaving = scene.traffic.behaving.as_ref();
    if behaving.is_some_and(|b| b.cleared_by == ClearedBy::Notices) {
        cli::warn(
            &"controllers that see tracks clear this traffic in a run; here nobody does, so departures stay on their stands",
        );
    }
    let mut played = behaving.map(|_| Played::of(scene)).transpose()?;
    for time in times {
        let end = SimTime(time.0 + scene.run.scan().0);
        let stated = Traffic::at(scene, time);
        let seen = played.as_mut().map(|played| {
            played.play(scene, end);
            played.intake.truth.view(time, end)
        });
        let truth: &dyn Truth = seen.as_ref().map_or(&stated, |seen| seen);
        let found = plans(scene, truth, time, tolerance)?;
        if args.json {
            let mut lines = Vec::new();
            found.iter().for_each(|sensor| sensor.json(time.s(), &mut lines));
            lines.iter().for_each(|line| out!("{line}"));
            continue;
        }
        let mut text = String::new();
        found.iter().for_each(|sensor| sensor.text(args.all, &mut text));
        out!(
            "{}",
            plan_report::heading(&scene.name, time.s(), &weather_at(scene, time), &tolerance)
        );
        out!("{}", text.trim_end());
        let rows: Vec<PlanRow> = found.iter().flat_map(|sensor| sensor.rows.clone()).collect();
        let name_of = |id| scene.sensors.iter().find(|s| s.id == id).map_or("", |s| &*s.name);
        let say = |changed: &[Change]| -> Vec<String> {
            let one = |c: &Change| {
                let sign = if c.to > c.from { '+' } else { '-' };
                format!("{sign} {} of {}", c.effect, name_of(c.sensor))
            };
            changed.iter().map(one).collect()
        };
        if let Some(before) = &before {
            let changed = say(&changes(before, &rows));
            if !changed.is_empty() {
                out!("  against the notice before: {}", changed.join(", "));
            }
        }
        for (word, factor) in [("a tenth", 0.1), ("ten times", 10.0)] {
            let other = plans(scene, truth, time, tolerance.times(factor))?;
            let other: Vec<PlanRow> = other.iter().flat_map(|sensor| sensor.rows.clone()).collect();
            let changed = say(&changes(&rows, &other));
            let text =
                if changed.is_empty() { "nothing changes".to_owned() } else { changed.join(", ") };
            out!("  with {word} of the tolerance: {text}");
        }
        out!();
        before = Some(rows);
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
        let (east, north) = (plot.position_m.x, plot.position_m.y);
        out!(
            "{} plot of {callsign} at {:.3} s: east {east:.2} m, north {north:.2} m",
            plot.kind.word,
            plot.time_ns as f64 * 1e-9
        );
        if let Some(truth_m) = plot.truth_m {
            let error_m = plot.position_m - truth_m;
            out!("  error east {:+.2} m, north {:+.2} m", error_m.x, error_m.y);
        }
        for (effect, value, unit) in &plot.effects {
            out!("  {effect:<32}{value:>12.4} {unit}");
        }
    }
    Ok(())
}

/// The run of a scene whose traffic one generator makes.
fn run_of(scene: &Scene) -> RunConfig {
    let config = conductor_config(scene, &RunOptions::default());
    RunConfig {
        run: 1,
        seed: config.seed,
        producers: config.producers,
        generators: 1,
        last_frame: config.last_frame,
        ..RunConfig::default()
    }
}

/// The report of the scan that ends at or after `at` seconds.
fn scan_at(scene: &Arc<Scene>, at: f64) -> anyhow::Result<ScanReport> {
    let exercise = scene.run.exercise;
    let run = run_of(scene);
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
    let mut parts = crate::runtime::codec::Parts::default();
    let mut whole = None;
    for part in scan.publish.iter().filter(|p| p.key == "tracks/1/scan") {
        whole = parts.take(&part.body)?;
    }
    whole.ok_or_else(|| anyhow::anyhow!("no scan was made"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(rest: &str) -> Arc<Scene> {
        let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
        let text = format!(
            "[run]\ntitle = \"p\"\nseed = 7\nduration_s = 300\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
             [[traffic]]\nkind = \"generated\"\narrivals_per_h = 20\ndepartures_per_h = 20\n\
             [[sensor]]\nkind = \"asde\"\nname = \"tower\"\nparameters = \"ku_asde3\"\n\
             site = {{ east_m = 250, north_m = 250, height_m = 30 }}\n{rest}"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("plan.toml");
        Arc::new(scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}")))
    }

    #[test]
    fn who_behaves_is_planned_for_where_a_run_has_him() {
        let scene = load("");
        let (time, end) = (SimTime::from_s(200.0), SimTime::from_s(201.0));
        let mut played = Played::of(&scene).expect("a generator");
        played.play(&scene, end);
        let view = played.intake.truth.view(time, end);
        let report = scan_at(&scene, 201.0).expect("a scan");
        let there: Vec<&str> = report.truth.iter().map(|t| t.callsign.as_str()).collect();
        let known: Vec<String> =
            (0..view.len()).map(|i| view.callsign(i).as_str().to_owned()).collect();
        assert!(!there.is_empty() && there.iter().all(|name| known.iter().any(|k| k == name)));
        let found = plans(&scene, &view, time, setup::tolerance(&scene)).expect("plans");
        let plots = report.plots.iter().filter(|p| there.contains(&p.cause.as_str()));
        let seen: std::collections::BTreeSet<&str> = plots.map(|p| p.cause.as_str()).collect();
        let mut json = Vec::new();
        found.iter().for_each(|sensor| sensor.json(200.0, &mut json));
        let total = json.iter().find_map(|row| row.get("total")).expect("a total");
        let planned = total["targets"].as_u64().expect("a number") as usize;
        assert!(!seen.is_empty() && planned >= seen.len(), "{planned} of {seen:?}");
    }

    #[test]
    fn rain_cells_of_a_plan_are_where_the_run_has_them() {
        let cell =
            "cells = [{ east_m = -180, north_m = 1084, radius_m = 600, rain_mm_per_h = 100 }]";
        let scene = load(&format!(
            "[weather]\ntimeline = [{{ at_s = 10, wind_mps = 20, wind_from_deg = 270, {cell} }}]\n"
        ));
        for (at_s, east_m) in [(10.0, -180.0), (110.0, 1820.0)] {
            let weather = weather_at(&scene, SimTime::from_s(at_s));
            assert!((weather.cells[0].centre_m.x - east_m).abs() < 1e-6, "{at_s} s");
        }
    }
}
