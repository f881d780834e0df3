//! Time per target and scan of the radar's models, and of the whole sensor stage.

#![allow(missing_docs, reason = "criterion makes public functions")]

#[path = "common/cpu_time.rs"]
mod cpu_time;

#[path = "../src/sensors/radar/sample_shapes.rs"]
mod sample_shapes;

use cpu_time::{CpuTime, targets};
use criterion::{Criterion, criterion_group, criterion_main};
use models::effects::Level;
use models::environment::surface::Material;
use models::environment::{RainCell, Weather};
use models::frames::{Point2, Point3, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::asde::picture::{EvenGround, VideoScene};
use models::sensors::asde::{Asde, AsdeParameters};
use models::sensors::radar::detection::{Detector, PdTable, Swerling};
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::equation::{BudgetLevels, Echo};
use models::sensors::radar::levels::{Processing, RadarLevels};
use models::sensors::radar::shadow::Building;
use models::sensors::radar::shape;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use std::hint::black_box;
use std::sync::Arc;

/// What a field is full of: reflectors without extent, vehicles, aircraft.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Point,
    Vehicle,
    Aircraft,
}

struct Field {
    class: TargetClass,
    places: Vec<Point3<f64>>,
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
            Point3::new(r * sin, r * cos, 0.0)
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

/// Traffic of many types that goes to and fro, a quarter of it standing and a tenth in the air, to 4.5 km.
struct Crowd {
    classes: Vec<TargetClass>,
    places: Vec<(Point3<f64>, Vector3<f64>)>,
}

impl Crowd {
    fn new(count: u32, types: u32) -> Self {
        let class = |i: u32| {
            let aircraft = !i.is_multiple_of(3);
            let length_m = if aircraft { 9.0 } else { 4.0 } * libm::exp(0.07 * f64::from(i));
            TargetClass {
                designator: format!("T{i}"),
                aircraft,
                length_m,
                span_m: if aircraft { 0.95 } else { 0.4 } * length_m,
                height_m: 0.3 * length_m,
                rcs_m2: 2.0 + 1.5 * f64::from(i),
                shape: sample_shapes::of(aircraft),
            }
        };
        let place = |i: u32| {
            let share = (f64::from(i) + 0.5) / f64::from(count);
            let r = (150.0f64.powi(2) + share * (4500.0f64.powi(2) - 150.0f64.powi(2))).sqrt();
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963);
            let up_m = if i % 10 == 9 { 10.0 + 290.0 * f64::from(i % 97) / 97.0 } else { 0.0 };
            let (east, north) = libm::sincos(f64::from(i) * 1.7);
            let speed = [0.0, 3.0, 8.0, 15.0][(i % 4) as usize];
            (Point3::new(r * sin, r * cos, up_m), Vector3::new(east, north, 0.0) * speed)
        };
        Self { classes: (0..types).map(class).collect(), places: (0..count).map(place).collect() }
    }
}

impl Truth for Crowd {
    fn len(&self) -> usize {
        self.places.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.classes[(index * 7) % self.classes.len()]
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (start, velocity_mps) = self.places[index];
        // Back after 40 s.
        let phase = time.s() / 40.0;
        let position_m = start + velocity_mps * (40.0 * (phase - (phase + 0.5).floor()).abs());
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
    Asde::new(SensorId(id), Point2::origin(), parameters()).expect("sound parameters")
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
                let to = Point2::new(0.0, ground_m);
                radar.budget(&air, &levels, black_box(&echo), Point2::origin(), to)
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

/// Planning of 20 radars on five masts over 1000 targets of 30 types: what a scan takes with planning, and without.
fn crowds(c: &mut Criterion<CpuTime>) {
    let truth = Crowd::new(1000, 30);
    let wall = |east: f64, north: f64| {
        let corner = |x: f64, y: f64| Point2::new(east + x, north + y);
        Building {
            name: "wall".into(),
            footprint_m: vec![
                corner(0.0, 0.0),
                corner(200.0, 0.0),
                corner(200.0, 40.0),
                corner(0.0, 40.0),
            ],
            height_m: 20.0,
            facade: Material::named("metal").expect("a material"),
        }
    };
    let built: Arc<[Building]> = Arc::new([wall(400.0, 500.0), wall(-900.0, -700.0)]);
    let mut group = c.benchmark_group("crowd");
    for (name, buildings) in [("open", Arc::new([]) as Arc<[Building]>), ("built", built)] {
        let site = |i: u16| {
            let (sin, cos) = libm::sincos(f64::from(i % 5) * 1.256);
            Point2::new(sin, cos) * 300.0
        };
        let made = |i: u16| {
            let radar = Asde::new(SensorId(i), site(i), parameters()).expect("sound parameters");
            radar.among(buildings.clone())
        };
        let mut radars: Vec<Asde> = (1..=20).map(made).collect();
        let dry = Weather::default();
        let mut scan = 0;
        let mut plan = |radars: &mut Vec<Asde>, weather: &Weather, planning: bool| {
            scan += 1;
            for radar in radars.iter_mut() {
                radar.plan_scan(&interval(scan), &truth, weather, planning);
            }
        };
        // Until every box is planned that targets come through.
        let versions = |radars: &[Asde]| radars.iter().map(|r| r.planner().version()).sum::<u64>();
        let (mut quiet, mut before) = (0, 0);
        while quiet < 80 {
            plan(&mut radars, &dry, true);
            let now = versions(&radars);
            quiet = if now == before { quiet + 1 } else { 0 };
            before = now;
        }
        for (what, planning) in [("looks alone", false), ("looks and planning", true)] {
            group.bench_function(format!("{what}, {name}, 20 radars, 1000 targets"), |b| {
                b.iter(|| plan(&mut radars, &dry, planning));
            });
        }
        let mut notice = 0;
        group.bench_function(format!("looks and planning, {name}, a notice a scan"), |b| {
            b.iter(|| {
                notice += 1;
                let rain_mm_per_h = [10.0, 12.0][notice % 2];
                plan(&mut radars, &Weather { rain_mm_per_h, ..rain() }, true);
            });
        });
        // The scans that follow a notice, each with 16 new boxes a radar: the time of eleven.
        group.bench_function(
            format!("looks and planning, {name}, a notice and ten scans more"),
            |b| {
                b.iter(|| {
                    notice += 1;
                    let rain_mm_per_h = [10.0, 12.0][notice % 2];
                    let weather = Weather { rain_mm_per_h, ..rain() };
                    (0..11).for_each(|_| plan(&mut radars, &weather, true));
                });
            },
        );
    }
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
        centre_m: Point2::new(f64::from(i) * 700.0 - 1400.0, 500.0),
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
    targets = budgets, detection, plans, crowds, scans, cells
);
criterion_main!(benches);
