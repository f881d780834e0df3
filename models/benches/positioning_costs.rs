//! Measures what every level of every effect of the sensors other than radars adds to a scan, and
//! writes or checks the planner's table.

#![allow(missing_docs, clippy::print_stdout, reason = "a program")]

#[path = "../src/sensors/sample_shapes.rs"]
mod sample_shapes;

use models::effects::positioning::costs::{COSTS_NS, MEASURED, of};
use models::effects::positioning::{
    Conditions, Planned, PositioningEffect, PositioningLevels, PositioningModel, PositioningScene,
    bounds, plan,
};
use models::effects::{Level, Loss, Tolerance};
use models::environment::Weather;
use models::frames::{Vector2, Vector3};
use models::plot::{Callsign, SensorId, SensorKind};
use models::sensors::adsb::{Adsb, AdsbConfig};
use models::sensors::config::ConfigError;
use models::sensors::constellation::SkyConfig;
use models::sensors::dgps::{Budgeted, Dgps, DgpsConfig, DgpsModel};
use models::sensors::dynamic::{Dynamic, DynamicConfig};
use models::sensors::gps::{Diluted, Gps, GpsConfig, GpsModel, Statistical};
use models::sensors::induction_loop::{InductionLoop, LoopConfig};
use models::sensors::mlat::{Mlat, MlatConfig};
use models::sensors::offline::{Offline, OfflineConfig, OfflineFit};
use models::sensors::ranging::{RangeBudget, RangeCorrections, RangingConfig};
use models::sensors::shadow::Building;
use models::sensors::shape;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use nix::time::{ClockId, clock_gettime};
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Arc;
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
            position_m: Vector3::new(along_m - 600.0, lane * 4.0, 0.0),
            velocity_mps: Vector3::new(SPEED_MPS, 0.0, 0.0),
            heading_rad: std::f64::consts::FRAC_PI_2,
        })
    }
}

fn ranges(corrections: Option<RangeCorrections>) -> RangingConfig {
    let site = geodesy::Geodetic::from_degrees(47.45, 8.55, 432.0);
    let mut sky = SkyConfig::reference(site, 8.3e8);
    sky.step_s = 1.0;
    RangingConfig { sky, budget: RangeBudget::modern(), weighted: false, corrections }
}

fn stations() -> MlatConfig {
    let places = [(0.0, 0.0), (4000.0, 0.0), (4000.0, 2500.0), (0.0, 2500.0), (2000.0, -500.0)]
        .map(|(x, y)| Vector2::new(x, y));
    let shed = |i: u32| Building {
        name: "shed".into(),
        footprint_m: [(0.0, 0.0), (80.0, 0.0), (80.0, 30.0), (0.0, 30.0)]
            .map(|(x, y)| Vector2::new(700.0 + 150.0 * f64::from(i) + x, 800.0 + y))
            .to_vec(),
        height_m: 12.0,
        facade: models::environment::surface::Material::named("metal").expect("known"),
    };
    MlatConfig {
        buildings: Arc::from((0..5).map(shed).collect::<Vec<_>>()),
        ..MlatConfig::with_stations(ID, &places)
    }
}

fn figures() -> OfflineConfig {
    let figures = OfflineFit {
        correlated_share: 0.8,
        tau_s: 100.0,
        pd: 0.95,
        outage_reports: 5.0,
        ..OfflineFit::white(3.0, 1.0)
    };
    OfflineConfig::of(ID, SensorKind::Gps, figures)
}

/// Loops across all lanes.
fn across() -> LoopConfig {
    let site_m = Vector2::new(0.0, 100.0);
    LoopConfig { half_width_m: 100.0, false_per_h: 1.0, ..LoopConfig::pair_at(ID, site_m, 90.0) }
}

/// A sensor that is planned with nothing to lose.
fn sensor(model: PositioningModel) -> Result<Box<dyn Planned>, ConfigError> {
    use PositioningModel as M;
    let on_airport = DgpsConfig::on_airport(ID, Vector2::zeros());
    let gps = |model| Gps::new(GpsConfig::of(ID, model));
    let constellation = || Diluted::reference(ranges(None).sky);
    Ok(match model {
        M::GpsStatistical => Box::new(gps(GpsModel::Statistical(Statistical::sps_2020()))?),
        M::GpsConstellation => Box::new(gps(GpsModel::Constellation(constellation()))?),
        M::GpsPerSatellite => Box::new(gps(GpsModel::PerSatellite(ranges(None)))?),
        M::DgpsBudget => Box::new(Dgps::new(on_airport)?),
        M::DgpsPerSatellite => {
            let model = DgpsModel::PerSatellite(ranges(Some(RangeCorrections::on_airport())));
            Box::new(Dgps::new(DgpsConfig { model, ..on_airport })?)
        }
        M::Adsb => {
            Box::new(Adsb::new(AdsbConfig { moving_s: 1.0, ..AdsbConfig::surface(ID, 47.45) })?)
        }
        M::Mlat => Box::new(Mlat::new(stations())?),
        M::Loop => Box::new(InductionLoop::new(across())?),
        M::Dynamic => Box::new(Dynamic::new(DynamicConfig::odometer(ID))?),
        M::Offline => Box::new(Offline::new(figures())?),
    })
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
    fn new(model: PositioningModel, levels: PositioningLevels) -> Self {
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
fn rows(model: PositioningModel) -> Vec<(PositioningEffect, Level)> {
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
    for model in PositioningModel::ALL {
        for (effect, level) in rows(model) {
            let nothing = PositioningLevels::NOTHING;
            // Geometry is what a model does with everything left out, beyond constants.
            let (mut on, mut off) = if effect == PositioningEffect::Geometry {
                let constants = Run::new(PositioningModel::GpsStatistical, nothing);
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
                model.name(),
                effect.name(),
                level.name(),
                on.least_ns,
                of(model, effect, level)
            );
            measured.push((model, effect, level, ns));
        }
    }
    println!("plans of ten sensors: {:.1} µs", ten_plans_us());
    if write {
        return write_table(&measured);
    }
    println!("the table: {MEASURED}");
    let off = |row: &&(PositioningModel, PositioningEffect, Level, f64)| {
        let table = of(row.0, row.1, row.2);
        row.3 > 3.0 * table + 40.0 || table > 3.0 * row.3 + 40.0
    };
    let changed: Vec<_> = measured.iter().filter(off).collect();
    for (model, effect, level, ns) in &changed {
        println!("{} {} {}: {ns:.0} ns now", model.name(), effect.name(), level.name());
    }
    let whole = COSTS_NS.len() == measured.len();
    if changed.is_empty() && whole { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The least time of planning one sensor of each kind anew, µs.
fn ten_plans_us() -> f64 {
    let conditions = Conditions { any: true, speed_mps: 20.0, distance_m: 3000.0, dilution: 1.25 };
    let tolerance = Tolerance::default();
    let scene = PositioningScene { conditions, horizon_s: 600.0, tolerance };
    let dgps = DgpsConfig::on_airport(ID, Vector2::zeros());
    let corrections = RangeCorrections::on_airport();
    let all = || {
        [
            bounds::gps_statistical(&Statistical::sps_2020(), &scene),
            bounds::gps_constellation(&Diluted::reference(ranges(None).sky), &scene),
            bounds::gps_per_satellite(&ranges(None), &scene),
            bounds::dgps_budget(&dgps, &Budgeted::on_airport(), &scene),
            bounds::dgps_per_satellite(&dgps, &ranges(Some(corrections)), &corrections, &scene),
            bounds::adsb(&AdsbConfig::surface(ID, 47.45), 4.1, 1.8, &scene),
            bounds::mlat(&stations(), &scene),
            bounds::induction_loop(&across(), &scene),
            bounds::dynamic(&DynamicConfig::odometer(ID), &scene),
            bounds::offline(&figures()),
        ]
    };
    let mut least_ns = f64::INFINITY;
    for _ in 0..200 {
        let start = now();
        let rows: usize =
            all().map(|ladders| plan(ID, ladders, &scene, Loss::NONE).rows.len()).iter().sum();
        assert!(rows > 50, "every effect has its row");
        least_ns = least_ns.min((now() - start).as_nanos() as f64);
    }
    least_ns * 1e-3
}

fn write_table(measured: &[(PositioningModel, PositioningEffect, Level, f64)]) -> ExitCode {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/effects/positioning/costs.rs");
    let date = std::env::var("MEASURED_ON").unwrap_or_else(|_| "today".into());
    let Ok(old) = std::fs::read_to_string(path) else { return ExitCode::FAILURE };
    let Some((head, _)) = old.split_once("/// When and on what") else { return ExitCode::FAILURE };
    let mut text = head.to_owned();
    let _ = writeln!(text, "/// When and on what the table was measured.");
    let _ = writeln!(text, "pub const MEASURED: &str = \"{date}\";");
    let _ = writeln!(text, "\n/// Model, effect, level, ns.\n#[rustfmt::skip]");
    let _ = writeln!(
        text,
        "pub const COSTS_NS: &[(PositioningModel, PositioningEffect, Level, u32)] = &["
    );
    for (model, effect, level, ns) in measured {
        let _ = writeln!(
            text,
            "    (PositioningModel::{model:?}, PositioningEffect::{effect:?}, Level::{level:?}, {}),",
            ns.round()
        );
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
