//! Measures what every level of every effect adds to a scan, and writes or checks the planner's table.

#![allow(missing_docs, clippy::print_stdout, reason = "a program")]

#[path = "../src/sensors/radar/sample_shapes.rs"]
mod sample_shapes;

use models::effects::Level;
use models::environment::surface::Material;
use models::environment::{RainCell, Weather};
use models::frames::{Point2, Point3, Vector2, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::asde::{Asde, AsdeParameters, DetectionRule};
use models::sensors::radar::costs::{COSTS_NS, MEASURED, of};
use models::sensors::radar::detection::Swerling;
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::equation::Reflection;
use models::sensors::radar::levels::RadarLevels;
use models::sensors::radar::shadow::Building;
use models::sensors::radar::shape;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use nix::time::{ClockId, clock_gettime};
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

const TARGETS: u32 = 2000;
const SCANS: u64 = 60;

struct Field {
    classes: [TargetClass; 2],
    places: Vec<Point3<f64>>,
}

fn class(aircraft: bool) -> TargetClass {
    let (length_m, span_m, height_m) = if aircraft { (37.6, 35.8, 11.8) } else { (4.8, 2.0, 2.5) };
    let rcs_m2 = if aircraft { 100.0 } else { 30.0 };
    let shape = sample_shapes::of(aircraft);
    TargetClass { designator: "T".into(), aircraft, length_m, span_m, height_m, rcs_m2, shape }
}

impl Field {
    fn new() -> Self {
        let place = |i: u32| {
            let share = (f64::from(i) + 0.5) / f64::from(TARGETS);
            let r = (300.0f64.powi(2) + share * (3000.0f64.powi(2) - 300.0f64.powi(2))).sqrt();
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963);
            Point3::new(r * sin, r * cos, 0.0)
        };
        Self { classes: [class(true), class(false)], places: (0..TARGETS).map(place).collect() }
    }
}

impl Truth for Field {
    fn len(&self) -> usize {
        self.places.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.classes[index % 2]
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let velocity_mps = Vector3::new(3.0, 0.0, 0.0);
        let position_m = self.places[index] + velocity_mps * time.s();
        Some(TargetState { position_m, velocity_mps, heading_rad: f64::from(index as u32) })
    }
}

fn parameters(detection: DetectionRule) -> AsdeParameters {
    AsdeParameters {
        detection,
        swerling: Swerling::One,
        range_step_m: 0.17,
        azimuth_step_deg: 0.0055,
        ..AsdeParameters::ku_band()
    }
}

fn buildings() -> Arc<[Building]> {
    let corner = |i: u32| {
        let (sin, cos) = libm::sincos(f64::from(i) * 2.1);
        let r = 500.0 + 200.0 * f64::from(i);
        Point2::new(r * sin, r * cos)
    };
    let box_at = |c: Point2<f64>| Building {
        name: "shed".into(),
        footprint_m: [(0.0, 0.0), (80.0, 0.0), (80.0, 30.0), (0.0, 30.0)]
            .map(|(x, y)| c + Vector2::new(x, y))
            .to_vec(),
        height_m: 5.0,
        facade: Material::named("metal").expect("known"),
    };
    (0..10).map(corner).map(box_at).collect()
}

fn weather() -> Weather {
    let cell = |i: u32| RainCell {
        centre_m: Point2::new(f64::from(i) * 1500.0 - 1500.0, 700.0),
        radius_m: 500.0,
        rain_mm_per_h: 8.0,
    };
    Weather {
        rain_mm_per_h: 4.0,
        visibility_m: 400.0,
        film_mm: 0.5,
        cells: (0..3).map(cell).collect(),
        ..Weather::default()
    }
}

fn now() -> Duration {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

/// The radar with only these levels, and the least time of its scans so far.
struct Run {
    radar: Asde,
    least_ns: f64,
}

impl Run {
    fn new(levels: RadarLevels, detection: DetectionRule) -> Self {
        let radar = Asde::new(SensorId(1), Point2::origin(), parameters(detection));
        let radar = radar.expect("sound parameters").among(buildings()).at_levels(levels);
        Self { radar, least_ns: f64::INFINITY }
    }

    fn scan(&mut self, scan: u64, truth: &Field, weather: &Weather, out: &mut PlotSink) {
        let time = |n: u64| SimTime::from_s(n as f64);
        let interval = ScanInterval { run_seed: 1, scan, from: time(scan - 1), to: time(scan) };
        out.plots.clear();
        out.causes.clear();
        let start = now();
        self.radar.scan(&interval, truth, weather, out);
        let ns = (now() - start).as_nanos() as f64 / f64::from(TARGETS);
        // The first scans make tables and the plan.
        if scan > 2 {
            self.least_ns = self.least_ns.min(ns);
        }
    }
}

/// Everything skipped: where targets are, and whether the beam meets them.
fn nothing() -> RadarLevels {
    let skip = |levels: RadarLevels, &effect: &RadarEffect| levels.with(effect, Level::Skipped);
    let mut levels = RadarEffect::ALL.iter().fold(RadarLevels::EXACT, skip);
    levels.budget.reflection = Reflection::None;
    levels
}

/// What an effect needs to be computed at all.
fn ground_of(effect: RadarEffect) -> RadarLevels {
    use RadarEffect as E;
    let mut levels = nothing();
    match effect {
        E::Lobing | E::Roughness | E::WaterFilm | E::ReflectedPolarisation | E::RoundEarth => {
            levels.budget.reflection = Reflection::Incoherent;
        }
        E::Glint | E::Processing => levels = levels.with(E::Extent, Level::Exact),
        _ => {}
    }
    levels
}

/// The levels with one effect at one level, and the rule of detection to measure under.
fn with(effect: RadarEffect, level: Level) -> (RadarLevels, DetectionRule) {
    let mut levels = ground_of(effect).with(effect, level);
    match effect {
        RadarEffect::SurfaceReflection => levels.budget.reflection = Reflection::Incoherent,
        RadarEffect::Detection => return (levels, DetectionRule::Bernoulli),
        _ => {}
    }
    (levels, DetectionRule::Threshold)
}

/// Every effect with the levels that it comes in.
fn rows() -> Vec<(RadarEffect, Level)> {
    let all = [Level::Cheap, Level::Middle, Level::Exact];
    let measured = |&(effect, level): &(RadarEffect, Level)| {
        match effect.value() {
            // These say it in their files.
            Some(value) => value.levels.iter().any(|row| row.0 == level),
            None => COSTS_NS.iter().any(|row| (row.0, row.1) == (effect, level)),
        }
    };
    let levels = RadarEffect::ALL.iter().flat_map(|&e| all.into_iter().map(move |l| (e, l)));
    levels.filter(measured).collect()
}

fn main() -> ExitCode {
    let write = std::env::args().any(|a| a == "--write");
    // `cargo test --benches` and `cargo bench -- FILTER` for other benches pass here too.
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return ExitCode::SUCCESS;
    }
    let (truth, weather) = (Field::new(), weather());
    let mut out = PlotSink::default();
    let mut measured = Vec::new();
    for (effect, level) in rows() {
        let (levels, rule) = with(effect, level);
        let mut on = Run::new(levels, rule);
        let mut off = Run::new(ground_of(effect), DetectionRule::Threshold);
        let video = effect == RadarEffect::Processing && level == Level::Exact;
        for scan in 1..=if video { 8 } else { SCANS } {
            on.scan(scan, &truth, &weather, &mut out);
            off.scan(scan, &truth, &weather, &mut out);
        }
        let ns = (on.least_ns - off.least_ns).max(0.0);
        println!(
            "{:24} {:8} {ns:8.1} ns (in the table {})",
            effect.name(),
            level.name(),
            of(effect, level)
        );
        measured.push((effect, level, ns));
    }
    if write {
        return write_table(&measured);
    }
    println!("the table: {MEASURED}");
    let off = |row: &&(RadarEffect, Level, f64)| {
        let table = of(row.0, row.1);
        row.2 > 3.0 * table + 40.0 || table > 3.0 * row.2 + 40.0
    };
    let changed: Vec<_> = measured.iter().filter(off).collect();
    for (effect, level, ns) in &changed {
        println!("{} {}: {ns:.0} ns now", effect.name(), level.name());
    }
    if changed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn write_table(measured: &[(RadarEffect, Level, f64)]) -> ExitCode {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/sensors/radar/costs.rs");
    let date = std::env::var("MEASURED_ON").unwrap_or_else(|_| "today".into());
    let Ok(old) = std::fs::read_to_string(path) else { return ExitCode::FAILURE };
    let Some((head, _)) = old.split_once("/// When and on what") else { return ExitCode::FAILURE };
    let mut text = head.to_owned();
    let _ = writeln!(text, "/// When and on what the table was measured.");
    let _ = writeln!(text, "pub const MEASURED: &str = \"{date}\";");
    let _ = writeln!(text, "\n/// Effect, level, ns.\n#[rustfmt::skip]");
    let _ = writeln!(text, "pub const COSTS_NS: &[(RadarEffect, Level, u32)] = &[");
    let planned = |row: &&(RadarEffect, Level, f64)| row.0.value().is_none();
    for (effect, level, ns) in measured.iter().filter(planned) {
        let _ = writeln!(text, "    (RadarEffect::{effect:?}, Level::{level:?}, {}),", ns.round());
    }
    text.push_str("];\n");
    match std::fs::write(path, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            println!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}
