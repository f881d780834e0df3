//! Time of association and update: kernels, one radar with crossing pairs, and the whole scan of ten
//! thousand targets under three radars. `cargo bench -p models --bench association`.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use models::association::assignment::Solver;
use models::association::jpda::Jpda;
use models::draw::{DrawKey, Purpose, normal_pair, uniform};
use models::filter::{FilterConfig, Rung};
use models::flight_list::FlightList;
use models::frames::Vector2;
use models::fusion::config::{AssociationMethod, SensorModel};
use models::fusion::{Tracker, TrackingConfig};
use models::plot::{Plot, SensorId, SensorKind};
use models::time::SimTime;
use std::hint::black_box;

/// Plots of scan `k` of `radars` radars that see `targets` targets in pairs on a 150 m grid, with half as
/// many false plots.
fn scan(targets: usize, radars: u16, k: u32) -> Vec<Plot> {
    let columns = ((targets / 2) as f64).sqrt().ceil() as usize;
    let mut plots = Vec::new();
    for radar in 1..=radars {
        let mut rng = DrawKey { run_seed: 1, sensor: radar.into(), entity: 0, scan: k.into() }
            .rng(Purpose::Study);
        let side = 150.0 * columns as f64;
        for n in 0..targets + targets / 2 {
            let (a, b) = normal_pair(&mut rng);
            let (u, v) = (uniform(&mut rng), uniform(&mut rng));
            let t = f64::from(k) - 1.0 + 0.001 + 0.998 * u;
            let position_m = if n < targets {
                if uniform(&mut rng) > 0.95 {
                    continue;
                }
                let pair = n / 2;
                let centre =
                    Vector2::new(150.0 * (pair % columns) as f64, 150.0 * (pair / columns) as f64);
                let way = 11.0 * (t - 6.0);
                let along =
                    if n % 2 == 0 { Vector2::new(way, 0.0) } else { Vector2::new(0.0, way) };
                centre + along + Vector2::new(3.064 * a, 3.064 * b)
            } else {
                Vector2::new(side * v, side * uniform(&mut rng))
            };
            plots.push(Plot {
                sensor: SensorId(radar),
                kind: SensorKind::Asde,
                time: SimTime::from_s(t),
                sequence: n as u32,
                position_m,
                axis: Vector2::new(1.0, 0.0),
                along_m2: 3.064 * 3.064,
                across_m2: 3.064 * 3.064,
                altitude_m: None,
                polar: None,
                identity: None,
                scnr_db: None,
            });
        }
    }
    plots
}

fn config(method: AssociationMethod, rung: Rung) -> TrackingConfig {
    let mut config = TrackingConfig::bulk();
    config.association = method;
    config.filter = FilterConfig::new(rung);
    for radar in 1..=3 {
        let mut sensor = SensorModel::default_of(SensorId(radar), SensorKind::Asde);
        (sensor.false_density_m2, sensor.extra_sigma_m) = (2.2e-5, 0.0);
        config.sensors.push(sensor);
    }
    config
}

/// A tracker that has followed the first five scans, and the sixth.
fn warm(config: TrackingConfig, targets: usize, radars: u16) -> (Tracker, Vec<Plot>) {
    let mut tracker = Tracker::new(config);
    for k in 1..=5 {
        let plots = scan(targets, radars, k);
        tracker.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
    }
    (tracker, scan(targets, radars, 6))
}

fn scans(c: &mut Criterion) {
    let flights = FlightList::default();
    let t = SimTime::from_s(6.0);
    let joint = AssociationMethod::Joint { limit: 100_000 };
    for (name, method) in [
        ("nearest", AssociationMethod::Nearest),
        ("global", AssociationMethod::Global),
        ("joint", joint),
    ] {
        for targets in [100, 1000] {
            let (tracker, plots) = warm(config(method, Rung::Ca3), targets, 1);
            c.bench_function(&format!("scan of {targets} targets, {name}"), |b| {
                b.iter_batched_ref(
                    || tracker.clone(),
                    |tracker| black_box(tracker.scan(t, &plots, &flights)),
                    BatchSize::LargeInput,
                );
            });
        }
    }
    let mut group = c.benchmark_group("whole scan");
    group.sample_size(10);
    let (tracker, plots) = warm(config(AssociationMethod::Nearest, Rung::Ca3), 10_000, 3);
    group.bench_function("10 000 targets under 3 radars with clutter", |b| {
        b.iter_batched_ref(
            || tracker.clone(),
            |tracker| black_box(tracker.scan(t, &plots, &flights)),
            BatchSize::PerIteration,
        );
    });
    group.finish();
}

fn kernels(c: &mut Criterion) {
    let mut rng = DrawKey { run_seed: 2, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
    let cost: Vec<f64> = (0..100 * 100).map(|_| uniform(&mut rng)).collect();
    let mut solver = Solver::default();
    c.bench_function("assignment 100 by 100, dense", |b| {
        b.iter(|| black_box(solver.solve(100, 100, |r, k| Some(cost[100 * r + k]))));
    });
    let mut jpda = Jpda::default();
    let mut beta = Vec::new();
    for (tracks, plots) in [(2, 3), (4, 5), (10, 10)] {
        let miss = vec![-3.0; tracks];
        let like: Vec<f64> = (0..tracks * plots).map(|_| 4.0 - 8.0 * uniform(&mut rng)).collect();
        c.bench_function(&format!("joint marginals, {tracks} tracks and {plots} plots"), |b| {
            b.iter(|| jpda.marginals(black_box(&miss), &like, 100_000, &mut beta));
        });
    }
}

criterion_group!(benches, kernels, scans);
criterion_main!(benches);
