//! Time per target and scan of the radar's models, and of the whole sensor stage.

#![allow(missing_docs, reason = "criterion makes public functions")]

#[path = "common/cpu_time.rs"]
mod cpu_time;

#[path = "../src/sensors/radar/sample_shapes.rs"]
mod sample_shapes;

use cpu_time::{CpuTime, targets};
use criterion::{Criterion, criterion_group, criterion_main};
use models::effects::Level;
use models::environment::{RainCell, Weather};
use models::frames::{Vector2, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::asde::picture::{EvenGround, VideoScene};
use models::sensors::asde::{Asde, AsdeParameters};
use models::sensors::radar::detection::{Detector, PdTable, Swerling};
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::equation::{BudgetLevels, Echo};
use models::sensors::radar::levels::{Processing, RadarLevels};
use models::sensors::radar::shape;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use std::hint::black_box;

/// What a field is full of: reflectors without extent, vehicles, aircraft.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Point,
    Vehicle,
    Aircraft,
}

struct Field {
    class: TargetClass,
    places: Vec<Vector3<f64>>,
}

impl Field {
    fn new(count: u32, kind: Kind) -> Self {
        let (length_m, span_m, height_m) = match kind {
            Kind::Point => (0.2, 0.2, 2.5),
            Kind::Vehicle => (4.8, 2.0, 2.5),
            Kind::Aircraft => (37.6, 35.8, 11.8),
        };
        let class = TargetClass {
            designator: "T".into(),
            aircraft: kind == Kind::Aircraft,
            length_m,
            span_m,
            height_m,
            rcs_m2: 10.0,
            shape: match kind {
                Kind::Point => shape::Shape::point(),
                _ => sample_shapes::of(kind == Kind::Aircraft),
            },
        };
        // A spiral that fills 300 to 3000 m evenly.
        let place = |i: u32| {
            let share = (f64::from(i) + 0.5) / f64::from(count);
            let r = (300.0f64.powi(2) + share * (3000.0f64.powi(2) - 300.0f64.powi(2))).sqrt();
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963);
            Vector3::new(r * sin, r * cos, 0.0)
        };
        Self { class, places: (0..count).map(place).collect() }
    }
}

impl Truth for Field {
    fn len(&self) -> usize {
        self.places.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let velocity_mps = Vector3::new(10.0, 0.0, 0.0);
        let position_m = self.places[index] + velocity_mps * time.s();
        Some(TargetState { position_m, velocity_mps, heading_rad: 1.0 })
    }
}

fn parameters() -> AsdeParameters {
    AsdeParameters {
        swerling: Swerling::One,
        range_step_m: 0.17,
        azimuth_step_deg: 0.0055,
        ..AsdeParameters::ku_band()
    }
}

fn radar(id: u16) -> Asde {
    Asde::new(SensorId(id), Vector2::zeros(), parameters()).expect("sound parameters")
}

fn interval(scan: u64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64);
    ScanInterval { run_seed: 1, scan, from: time(scan - 1), to: time(scan) }
}

fn rain() -> Weather {
    Weather { rain_mm_per_h: 10.0, visibility_m: 400.0, film_mm: 0.5, ..Weather::default() }
}

fn budgets(c: &mut Criterion<CpuTime>) {
    let radar = parameters().radar();
    let air = radar.air(&rain());
    let mut group = c.benchmark_group("budget");
    for (name, levels) in [("middle", BudgetLevels::MIDDLE), ("exact", BudgetLevels::EXACT)] {
        let mut ground_m = 500.0;
        group.bench_function(name, |b| {
            b.iter(|| {
                ground_m = if ground_m > 3000.0 { 500.0 } else { ground_m + 1.7 };
                let echo = Echo { ground_m, height_m: 1.5, extent_m: 3.0, rcs_m2: 10.0 };
                let to = Vector2::new(0.0, ground_m);
                radar.budget(&air, &levels, black_box(&echo), Vector2::zeros(), to)
            });
        });
    }
    group.finish();
}

fn detection(c: &mut Criterion<CpuTime>) {
    let detector = Detector::new(14, 1e-6);
    let table = PdTable::new(&detector, Swerling::One);
    let mut group = c.benchmark_group("detection");
    let mut snr = 1.0;
    let mut next = move || {
        snr = if snr > 100.0 { 1.0 } else { snr * 1.01 };
        snr
    };
    group.bench_function("albersheim", |b| b.iter(|| detector.albersheim(black_box(next()))));
    group.bench_function("sankaran", |b| b.iter(|| detector.sankaran(black_box(next()))));
    group.bench_function("table", |b| b.iter(|| table.at(black_box(next()))));
    group.bench_function("exact steady", |b| {
        b.iter(|| detector.probability(black_box(next()), Swerling::Steady));
    });
    group.bench_function("exact fading", |b| {
        b.iter(|| detector.probability(black_box(next()), Swerling::One));
    });
    group.finish();
}

fn plans(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("plan");
    let truth = Field::new(1000, Kind::Aircraft);
    // What planning costs is what a planned scan takes beyond one at the same levels: the steady state.
    let mut radars: Vec<Asde> = (1..=20).map(radar).collect();
    let (wet, dry) = (rain(), Weather::default());
    let (mut out, mut scan) = (PlotSink::default(), 0);
    let mut run = |radars: &mut Vec<Asde>, weather: &Weather| {
        scan += 1;
        out.plots.clear();
        out.causes.clear();
        for radar in radars.iter_mut() {
            radar.scan(&interval(scan), &truth, weather, &mut out);
        }
    };
    group.bench_function("20 radars, 1000 targets", |b| b.iter(|| run(&mut radars, &wet)));
    // The planning alone, and what it needs anyway: when the beam points at which target.
    for (name, planning) in [("looks alone", false), ("looks and planning", true)] {
        let mut scan = 0;
        group.bench_function(format!("{name}, 20 radars, 1000 targets"), |b| {
            b.iter(|| {
                scan += 1;
                for radar in &mut radars {
                    radar.plan_scan(&interval(scan), &truth, &wet, planning);
                }
            });
        });
    }
    let (mut scan, mut wetter) = (0, false);
    group.bench_function("looks and planning, new weather, 20 radars, 1000 targets", |b| {
        b.iter(|| {
            scan += 1;
            wetter = !wetter;
            for radar in &mut radars {
                radar.plan_scan(&interval(scan), &truth, if wetter { &dry } else { &wet }, true);
            }
        });
    });
    let mut wetter = false;
    group.bench_function("20 radars, 1000 targets, new weather", |b| {
        b.iter(|| {
            wetter = !wetter;
            run(&mut radars, if wetter { &wet } else { &dry });
        });
    });
    group.finish();
}

fn scans(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("scan");
    group.sample_size(10);
    for count in [1000, 10_000] {
        for (name, kind) in
            [("points", Kind::Point), ("vehicles", Kind::Vehicle), ("aircraft", Kind::Aircraft)]
        {
            let truth = Field::new(count, kind);
            group.throughput(targets(3 * u64::from(count)));
            for how in ["planned", "exact without extent", "exact"] {
                let levels = match how {
                    "planned" => None,
                    "exact" => Some(RadarLevels::EXACT),
                    _ => Some(
                        RadarLevels::EXACT
                            .with(RadarEffect::Extent, Level::Skipped)
                            .with(RadarEffect::Glint, Level::Skipped),
                    ),
                };
                let made = (1..=3).map(radar).map(|radar| match levels {
                    Some(levels) => radar.at_levels(levels),
                    None => radar,
                });
                let mut radars: Vec<Asde> = made.collect();
                let mut out = PlotSink::default();
                let mut scan = 0;
                group.bench_function(format!("{how} {name}, rain, 3 x {count}"), |b| {
                    b.iter(|| {
                        scan += 1;
                        out.plots.clear();
                        out.causes.clear();
                        for radar in &mut radars {
                            radar.scan(&interval(scan), &truth, &rain(), &mut out);
                        }
                    });
                });
            }
        }
    }
    let cells = (0..5).map(|i| RainCell {
        centre_m: Vector2::new(f64::from(i) * 700.0 - 1400.0, 500.0),
        radius_m: 600.0,
        rain_mm_per_h: 20.0,
    });
    let storm = Weather { cells: cells.collect(), ..rain() };
    let truth = Field::new(1000, Kind::Point);
    let mut one = radar(1);
    let mut out = PlotSink::default();
    let mut scan = 0;
    group.throughput(targets(1000));
    group.bench_function("planned points, five rain cells, 1 x 1000", |b| {
        b.iter(|| {
            scan += 1;
            out.plots.clear();
            out.causes.clear();
            one.scan(&interval(scan), &truth, &storm, &mut out);
        });
    });
    group.finish();
}

fn cells(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("cells");
    group.sample_size(10);
    for (name, kind) in [("vehicles", Kind::Vehicle), ("aircraft", Kind::Aircraft)] {
        let truth = Field::new(1000, kind);
        let mut one = radar(1).processing(Processing::Cells);
        let mut out = PlotSink::default();
        let mut scan = 0;
        group.throughput(targets(1000));
        group.bench_function(format!("windows of 1000 {name}, rain"), |b| {
            b.iter(|| {
                scan += 1;
                out.plots.clear();
                out.causes.clear();
                one.scan(&interval(scan), &truth, &rain(), &mut out);
            });
        });
    }
    let truth = Field::new(100, Kind::Aircraft);
    let mut one = radar(1).at_levels(RadarLevels::EXACT);
    let mut scan = 0;
    group.throughput(targets(1));
    for (name, scene) in [("plain", VideoScene::PLAIN), ("picture", VideoScene::PICTURE)] {
        group.bench_function(format!("video of a turn with 100 aircraft, rain, {name}"), |b| {
            b.iter(|| {
                scan += 1;
                black_box(one.video(&interval(scan), &truth, &rain(), &EvenGround, &scene))
            });
        });
    }
    group.finish();
}

criterion_group!(
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = budgets, detection, plans, scans, cells
);
criterion_main!(benches);
