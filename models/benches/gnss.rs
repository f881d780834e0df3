//! Time per target of the reporting sensors at each level, and of radar cells.

#![allow(missing_docs, reason = "criterion makes public functions")]

#[path = "../src/sensors/radar/sample_shapes.rs"]
mod sample_shapes;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use geodesy::Geodetic;
use models::draw::DrawKey;
use models::environment::Weather;
use models::frames::{Point2, Point3, Vector3};
use models::plot::{Callsign, SensorId, SensorKind};
use models::sensors::adsb::{Adsb, AdsbConfig};
use models::sensors::dgps::{Dgps, DgpsConfig};
use models::sensors::dynamic::{Dynamic, DynamicConfig};
use models::sensors::gps::{Diluted, Gps, GpsConfig, GpsModel, Statistical};
use models::sensors::mlat::{Mlat, MlatConfig};
use models::sensors::offline::{Offline, OfflineConfig, OfflineFit};
use models::sensors::radar::extended::{ExtentLevel, centroid, echoes};
use models::sensors::radar::shape;
use models::sensors::radar::video::{CellRadar, CellWork, Fading, Threshold, point_echoes};
use models::sensors::reporting::constellation::{Constellation, Dop, SkyConfig, in_view};
use models::sensors::reporting::ranging::{RangeBudget, RangingConfig};
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use std::hint::black_box;

const TARGETS: u64 = 1000;

struct Field(TargetClass);

fn class() -> TargetClass {
    TargetClass {
        designator: "A320".into(),
        aircraft: true,
        length_m: 37.6,
        span_m: 35.8,
        height_m: 11.8,
        rcs_m2: 20.0,
        shape: sample_shapes::of(true),
    }
}

impl Truth for Field {
    fn len(&self) -> usize {
        TARGETS as usize
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.0
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::new("TARGET")
    }
    fn address(&self, index: usize) -> Option<u32> {
        Some(index as u32)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        Some(TargetState {
            position_m: Point3::new(10.0 * time.s(), index as f64, 0.0),
            velocity_mps: Vector3::new(10.0, 0.0, 0.0),
            heading_rad: 1.57,
        })
    }
}

fn sensors(c: &mut Criterion) {
    let id = SensorId(1);
    let site = Geodetic::from_degrees(47.45, 8.55, 432.0);
    let sky = SkyConfig::reference(site, 8.3e8);
    let ranging = RangingConfig {
        sky: SkyConfig { step_s: 1.0, ..sky.clone() },
        budget: RangeBudget::modern(),
        weighted: false,
        corrections: None,
    };
    let gps = |model| Gps::new(GpsConfig::of(id, model)).expect("sound");
    let stations = [(0.0, 0.0), (4000.0, 0.0), (4000.0, 2500.0), (0.0, 2500.0), (2000.0, -500.0)]
        .map(|(x, y)| Point2::new(x, y));
    let figures = OfflineFit {
        correlated_share: 0.8,
        tau_s: 100.0,
        pd: 0.95,
        outage_reports: 5.0,
        ..OfflineFit::white(3.0, 1.0)
    };
    let offline = OfflineConfig::of(id, SensorKind::Gps, figures);
    let list: Vec<(&str, Box<dyn Sensor>)> = vec![
        ("gps statistical", Box::new(gps(GpsModel::Statistical(Statistical::sps_2020())))),
        ("gps constellation", Box::new(gps(GpsModel::Constellation(Diluted::reference(sky))))),
        ("gps per satellite", Box::new(gps(GpsModel::PerSatellite(ranging)))),
        (
            "dgps budget",
            Box::new(Dgps::new(DgpsConfig::on_airport(id, Point2::origin())).expect("sound")),
        ),
        ("adsb (2 reports)", Box::new(Adsb::new(AdsbConfig::surface(id, 47.45)).expect("sound"))),
        (
            "mlat, 5 stations",
            Box::new(Mlat::new(MlatConfig::with_stations(id, &stations)).expect("sound")),
        ),
        ("dynamic", Box::new(Dynamic::new(DynamicConfig::odometer(id)).expect("sound"))),
        ("offline", Box::new(Offline::new(offline).expect("sound"))),
    ];
    let truth = Field(class());
    let mut group = c.benchmark_group("reports per target and second");
    group.throughput(Throughput::Elements(TARGETS));
    for (name, mut sensor) in list {
        let mut scan = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                scan += 1;
                let at = |s: u64| SimTime(s as i64 * 1_000_000_000);
                let interval = ScanInterval { run_seed: 1, scan, from: at(scan - 1), to: at(scan) };
                let mut sink = PlotSink::default();
                sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
                sink.plots.len()
            });
        });
    }
    group.finish();
}

fn geometry(c: &mut Criterion) {
    let constellation = Constellation::reference_24();
    let frame = geodesy::LocalFrame::at(Geodetic::from_degrees(47.45, 8.55, 432.0));
    let mut t_s = 0.0;
    c.bench_function("sky and dilution of one epoch", |b| {
        b.iter(|| {
            t_s += 10.0;
            let views = in_view(&constellation, &frame, t_s, 0.087, |_| false);
            let units: Vec<_> = views.iter().map(|v| v.look.unit).collect();
            Dop::of(&units, &[])
        });
    });
}

fn cells(c: &mut Criterion) {
    let radar = CellRadar {
        cell_m: 5.4,
        range_min_m: 100.0,
        cells: 1000,
        beams: 1440,
        width_rad: 0.25_f64.to_radians(),
        pulses: 14,
        pfa: 1e-6,
        threshold: 51.85,
        recovered: 1.0,
    };
    let class = class();
    let mut view = 0.0;
    let mut group = c.benchmark_group("extended target");
    for (name, level) in [("point", ExtentLevel::Point), ("centroid", ExtentLevel::Centroid)] {
        group.bench_function(name, |b| {
            b.iter(|| {
                view += 0.01;
                centroid(level, &class, black_box(view))
            });
        });
    }
    let mut work = CellWork::default();
    let mut scan = 0;
    for (name, ground_m) in [("cells at 1 km", 1000.0), ("cells at 3 km", 3000.0)] {
        group.bench_function(name, |b| {
            b.iter(|| {
                (view, scan) = (view + 0.01, scan + 1);
                let scatterers = echoes(&class, view);
                let mut points: Vec<_> =
                    point_echoes(&scatterers, ground_m, 0.7, ground_m, 100.0).collect();
                let key = DrawKey { run_seed: 1, sensor: 1, entity: 1, scan };
                Fading::Gamma(1).fade(&mut points, key);
                radar.window(&mut points, |_| 1.5, key, &mut work)
            });
        });
    }
    group.finish();
    let targets: Vec<_> = (0..50_u32)
        .flat_map(|k| {
            let azimuth_rad = f64::from(k) * 0.125;
            let scatterers = echoes(&class, f64::from(k));
            point_echoes(&scatterers, 2000.0, azimuth_rad, 2000.0, 100.0).collect::<Vec<_>>()
        })
        .collect();
    let mut group = c.benchmark_group("video of one scan");
    group.sample_size(10);
    for (name, threshold) in [
        ("known background", Threshold::Known),
        ("cell averaging", Threshold::CellAveraging { guard: 8, reference: 16 }),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| {
                scan += 1;
                let key = DrawKey { run_seed: 1, sensor: 1, entity: 0, scan };
                let fill = |_, row: &mut [f64]| {
                    row.fill(1.5);
                    true
                };
                black_box(radar.video(targets.iter().copied(), fill, threshold, key))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, sensors, geometry, cells);
criterion_main!(benches);
