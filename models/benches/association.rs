//! Time of association and update: kernels, one radar with crossing pairs, and the whole scan of ten
//! thousand targets under three radars. `cargo bench -p models --bench association`.
//!
//! "Association and update": tracks that are there already (pairs that cross at right angles on a 150 m grid, 95 %
//! detected, half as many false plots as targets), no new ones; one call of `Tracker::scan`, so sorting the plots,
//! gates, association, updates, coasting and publication. "Whole scan": starts, confirmation and deletion too.
//! A running tracker is measured, scan after scan, not one that was copied just before, in processor time of its
//! thread: on a busy machine the wall clock shows who else is running.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use models::association::assignment::Solver;
use models::association::jpda::Jpda;
use models::draw::{DrawKey, Purpose, normal_pair, uniform};
use models::filter::lanes::Pair;
use models::filter::{FilterConfig, Gaussian, Rung, Sym2};
use models::flight_list::FlightList;
use models::frames::{Point2, Vector2};
use models::fusion::config::{AssociationMethod, SensorModel};
use models::fusion::{Tracker, TrackingConfig};
use models::plot::{Plot, SensorId, SensorKind};
use models::time::SimTime;
use nix::time::{ClockId, clock_gettime};
use std::hint::black_box;
use std::time::Duration;

/// Standard deviation of a plot per axis, m: 7.5 m at 95 %.
const SIGMA_M: f64 = 3.064;

/// Targets in pairs on a 150 m grid, one east, one north, at the crossing at 6 s.
struct Crossings {
    targets: usize,
    /// False plots of a radar in one scan.
    false_plots: usize,
}

impl Crossings {
    fn columns(&self) -> usize {
        ((self.targets / 2) as f64).sqrt().ceil() as usize
    }

    /// Position (m) and velocity (m/s) of target `n` at `t` seconds.
    fn truth(&self, n: usize, t: f64) -> (Point2<f64>, Vector2<f64>) {
        let (pair, columns) = (n / 2, self.columns());
        let centre = Point2::new(150.0 * (pair % columns) as f64, 150.0 * (pair / columns) as f64);
        let velocity =
            if n.is_multiple_of(2) { Vector2::new(11.0, 0.0) } else { Vector2::new(0.0, 11.0) };
        (centre + velocity * (t - 6.0), velocity)
    }

    /// Plots of the scan (k − 1, k] of `radars` radars.
    fn scan(&self, radars: u16, k: u32) -> Vec<Plot> {
        let mut plots = Vec::new();
        let side = 150.0 * self.columns() as f64;
        for radar in 1..=radars {
            let key = DrawKey { run_seed: 1, sensor: radar.into(), entity: 0, scan: k.into() };
            let mut rng = key.rng(Purpose::Study);
            for n in 0..self.targets + self.false_plots {
                let (a, b) = normal_pair(&mut rng);
                let (u, v, w) = (uniform(&mut rng), uniform(&mut rng), uniform(&mut rng));
                let t = f64::from(k) - 1.0 + 0.001 + 0.998 * u;
                let position_m = if n < self.targets {
                    if w > 0.95 {
                        continue;
                    }
                    self.truth(n, t).0 + Vector2::new(SIGMA_M * a, SIGMA_M * b)
                } else {
                    Point2::new(side * v, side * w)
                };
                plots.push(Plot {
                    sensor: SensorId(radar),
                    kind: SensorKind::Asde,
                    time: SimTime::from_s(t),
                    sequence: n as u32,
                    position_m,
                    axis: Vector2::new(1.0, 0.0),
                    along_m2: SIGMA_M * SIGMA_M,
                    across_m2: SIGMA_M * SIGMA_M,
                    altitude_m: None,
                    polar: None,
                    identity: None,
                    scnr_db: None,
                });
            }
        }
        plots
    }

    fn config(&self, method: AssociationMethod) -> TrackingConfig {
        let mut config = TrackingConfig::bulk();
        config.association = method;
        config.filter = FilterConfig::new(Rung::Ca3);
        let area_m2 = (150.0 * self.columns() as f64).powi(2);
        for radar in 1..=3 {
            let mut sensor = SensorModel::default_of(SensorId(radar), SensorKind::Asde);
            sensor.false_density_m2 = self.false_plots as f64 / area_m2;
            (sensor.detection, sensor.extra_sigma_m) = (0.95, 0.0);
            config.sensors.push(sensor);
        }
        config
    }

    /// A tracker with a track of every target at time 0 and room for no other one.
    fn adopted(&self, method: AssociationMethod) -> Tracker {
        let mut config = self.config(method);
        config.life.most_tracks = self.targets;
        let mut tracker = Tracker::new(config);
        let r = Sym2 { xx: SIGMA_M * SIGMA_M, xy: 0.0, yy: SIGMA_M * SIGMA_M };
        let states: Vec<Gaussian> = (0..self.targets)
            .map(|n| {
                let (position, velocity) = self.truth(n, 0.0);
                let mut state = Gaussian::at_position(position, r, 1.0, 0.1);
                state.x[1] = Pair::new(velocity.x, velocity.y);
                state
            })
            .collect();
        assert_eq!(tracker.adopt(SimTime::ZERO, &states), self.targets);
        tracker
    }
}

/// Processor time of this thread.
fn thread_time() -> Duration {
    let now = clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).expect("every Unix has it");
    Duration::new(now.tv_sec().unsigned_abs(), now.tv_nsec() as u32)
}

/// Mean time of the scans from `first` on, `times` runs of a tracker that begins with scan 1.
fn per_scan(
    mut tracker: impl FnMut() -> Tracker,
    scans: &[Vec<Plot>],
    first: usize,
    times: u64,
) -> Duration {
    let flights = FlightList::default();
    let mut total = Duration::ZERO;
    for _ in 0..times {
        let mut tracker = tracker();
        for (k, plots) in scans.iter().enumerate() {
            let t = SimTime::from_s((k + 1) as f64);
            let begin = thread_time();
            black_box(tracker.scan(t, plots, &flights));
            if k >= first {
                total += thread_time() - begin;
            }
        }
    }
    total / (scans.len() - first) as u32
}

fn scans(c: &mut Criterion) {
    let joint = AssociationMethod::Joint { limit: 100_000 };
    for (name, method, sizes) in [
        ("nearest", AssociationMethod::Nearest, &[100, 300, 1000, 3000][..]),
        ("global", AssociationMethod::Global, &[100, 1000]),
        ("joint", joint, &[100, 1000]),
    ] {
        let mut group = c.benchmark_group(format!("association and update, {name}"));
        group.sample_size(20);
        for &targets in sizes {
            let scene = Crossings { targets, false_plots: targets / 2 };
            let scans: Vec<_> = (1..=12).map(|k| scene.scan(1, k)).collect();
            group.throughput(Throughput::Elements(targets as u64));
            group.bench_function(BenchmarkId::from_parameter(targets), |b| {
                b.iter_custom(|times| per_scan(|| scene.adopted(method), &scans, 2, times));
            });
        }
        group.finish();
    }
    let mut group = c.benchmark_group("whole scan of 10 000 targets under 3 radars");
    group.sample_size(10);
    for (name, false_plots) in [("500 false plots each", 500), ("5000 false plots each", 5000)] {
        let scene = Crossings { targets: 10_000, false_plots };
        let scans: Vec<_> = (1..=10).map(|k| scene.scan(3, k)).collect();
        group.bench_function(name, |b| {
            b.iter_custom(|times| {
                let tracker = || Tracker::new(scene.config(AssociationMethod::Nearest));
                per_scan(tracker, &scans, 4, times)
            });
        });
    }
    group.finish();
}

/// Plots of scan `k` of targets at `truth(n, t)` with errors of `sigma_m` per axis, seen by one radar.
fn seen(k: u32, n: usize, sigma_m: f64, truth: impl Fn(usize, f64) -> Point2<f64>) -> Vec<Plot> {
    let mut rng = DrawKey { run_seed: 7, sensor: 1, entity: 0, scan: k.into() }.rng(Purpose::Study);
    let plot = |i: usize| {
        let t = f64::from(k) - 1.0 + (i + 1) as f64 / (n + 1) as f64;
        let (a, b) = normal_pair(&mut rng);
        Plot {
            sensor: SensorId(1),
            kind: SensorKind::Asde,
            time: SimTime::from_s(t),
            sequence: i as u32,
            position_m: truth(i, t) + Vector2::new(a, b) * sigma_m,
            axis: Vector2::new(1.0, 0.0),
            along_m2: sigma_m * sigma_m,
            across_m2: sigma_m * sigma_m,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    };
    (0..n).map(plot).collect()
}

/// Scans of any density: the mean of the scans from the third on, births and confirmations among them.
fn crowds(c: &mut Criterion) {
    let point = |_: usize, _: f64| Point2::new(10.0, 20.0);
    let grid = |i: usize, _: f64| Point2::new((i % 32) as f64, (i / 32) as f64) * 12.0;
    let airport = |i: usize, t: f64| {
        let angle = i as f64 * 2.4;
        Point2::new((i % 100) as f64, (i / 100) as f64) * 200.0
            + Vector2::new(libm::cos(angle), libm::sin(angle)) * 10.0 * t
    };
    let mut group = c.benchmark_group("a scan of any density");
    group.sample_size(10);
    for (profile, config) in
        [("paper", TrackingConfig::paper()), ("accurate", TrackingConfig::accurate())]
    {
        let mut config = config;
        config.life.numbers = 65_536;
        for (name, n, plots) in [
            ("1000 on a metre", 1_000, (1..=6).map(|k| seen(k, 1_000, 1.0, point)).collect()),
            ("1024 on a 12 m grid", 1_024, (1..=6).map(|k| seen(k, 1_024, 3.0, grid)).collect()),
            ("the same, 25 m errors", 1_024, (1..=6).map(|k| seen(k, 1_024, 25.0, grid)).collect()),
            ("100 at airport density", 100, (1..=6).map(|k| seen(k, 100, 3.0, airport)).collect()),
            (
                "1000 at airport density",
                1_000,
                (1..=6).map(|k| seen(k, 1_000, 3.0, airport)).collect(),
            ),
            (
                "10 000 at airport density",
                10_000,
                (1..=6).map(|k| seen(k, 10_000, 3.0, airport)).collect(),
            ),
            ("10 000 on a metre", 10_000, (1..=6).map(|k| seen(k, 10_000, 1.0, point)).collect()),
        ] {
            let scans: Vec<Vec<Plot>> = plots;
            group.throughput(Throughput::Elements(n));
            group.bench_function(BenchmarkId::new(profile, name), |b| {
                b.iter_custom(|times| per_scan(|| Tracker::new(config.clone()), &scans, 2, times));
            });
        }
    }
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

criterion_group!(benches, kernels, scans, crowds);
criterion_main!(benches);
