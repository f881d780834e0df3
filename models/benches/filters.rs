//! One update of both axes, beside two published Kalman filters in the same run.
//!
//! `cargo bench -p models --bench filters`. The peers do what `ca3` does (two independent axes of
//! position, velocity, acceleration; constant Q and R) or what `ca6` does; ours also compute Q for the
//! plot's own interval, check the plot and the innovation, and return the normalised innovation.

use criterion::{Criterion, criterion_group, criterion_main};
use models::filter::{Estimator, FilterConfig, Rung, StateEstimator};
use models::frames::{Point2, Vector2};
use models::plot::{Plot, SensorId, SensorKind};
use models::time::SimTime;
use std::hint::black_box;

/// Plots of a target that brakes, with errors that a generator of the old school gives.
fn plots(n: usize) -> Vec<Plot> {
    let mut seed = 12_345_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * 5.0
    };
    (0..n)
        .map(|k| {
            let t = k as f64;
            Plot {
                sensor: SensorId(1),
                kind: SensorKind::Asde,
                time: SimTime(k as i64 * 1_000_000_000),
                sequence: 0,
                position_m: Point2::new(80.0 * t - 0.6 * t * t + noise(), 3.0 * t + noise()),
                axis: Vector2::new(0.6, 0.8),
                along_m2: 2.4,
                across_m2: 3.6,
                altitude_m: None,
                polar: None,
                identity: None,
                scnr_db: None,
            }
        })
        .collect()
}

const N: usize = 60;

fn ours(c: &mut Criterion) {
    let plots = plots(N + 1);
    for (rung, name) in Rung::ALL {
        let config = FilterConfig::new(rung);
        let started = Estimator::from_plot(&config, &plots[0]).expect("a sound plot");
        c.bench_function(&format!("{name}, {N} updates"), |b| {
            b.iter_batched_ref(
                || started.clone(),
                |filter| {
                    for plot in &plots[1..] {
                        let _ = black_box(filter.update(plot));
                    }
                },
                criterion::BatchSize::SmallInput,
            );
        });
    }
}

/// Process noise of one axis at one second, q = 0.3.
fn noise_of_one_axis() -> [[f64; 3]; 3] {
    let q = models::filter::motion::Step::constant_acceleration(0.3, 1.0).q;
    [[q[0], q[1], q[2]], [q[1], q[3], q[4]], [q[2], q[4], q[5]]]
}

/// minikalman: two independent axes, as `ca3`.
fn minikalman_two_axes(c: &mut Criterion) {
    use minikalman::prelude::*;
    use minikalman::regular::builder::KalmanFilterBuilder;
    let plots = plots(N + 1);
    let builder = KalmanFilterBuilder::<3, f64>::default();
    let axis = |z: f64| {
        let mut filter = builder.build();
        filter.state_vector_mut().apply(|x| x.set_row(0, z));
        filter.state_transition_mut().apply(|f| {
            f.make_identity();
            f.set_at(0, 1, 1.0);
            f.set_at(0, 2, 0.5);
            f.set_at(1, 2, 1.0);
        });
        filter.estimate_covariance_mut().apply(|p| {
            p.set_at(0, 0, 3.0);
            p.set_at(1, 1, 2500.0);
            p.set_at(2, 2, 9.0);
        });
        let noise = noise_of_one_axis();
        filter.direct_process_noise_mut().apply(|q| {
            for (i, row) in noise.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    q.set_at(i, j, *value);
                }
            }
        });
        filter
    };
    let mut measurement = builder.observations().build::<1>();
    measurement.observation_matrix_mut().apply(|h| h.set_at(0, 0, 1.0));
    measurement.measurement_noise_covariance_mut().apply(|r| r.set_at(0, 0, 3.0));
    let first = plots[0].position_m;
    c.bench_function(&format!("minikalman, two axes, {N} updates"), |b| {
        b.iter_batched_ref(
            || [axis(first.x), axis(first.y)],
            |filters| {
                for plot in &plots[1..] {
                    for (filter, z) in filters.iter_mut().zip(plot.position_m.iter()) {
                        filter.predict();
                        measurement.measurement_vector_mut().apply(|m| m.set_row(0, *z));
                        filter.correct(&mut measurement);
                    }
                    black_box(&filters);
                }
            },
            criterion::BatchSize::SmallInput,
        );
    });
}

type Mat<const R: usize, const C: usize> = nalgebra::SMatrix<f64, R, C>;
type Dim<const N: usize> = nalgebra::Const<N>;

/// Six states of constant acceleration with positions measured.
struct SixStates {
    f: Mat<6, 6>,
    ft: Mat<6, 6>,
    q: Mat<6, 6>,
    h: Mat<2, 6>,
    ht: Mat<6, 2>,
    r: Mat<2, 2>,
}

impl SixStates {
    fn new() -> Self {
        let (mut f, mut q, mut h) =
            (Mat::<6, 6>::identity(), Mat::<6, 6>::zeros(), Mat::<2, 6>::zeros());
        for b in [0, 3] {
            (f[(b, b + 1)], f[(b, b + 2)], f[(b + 1, b + 2)]) = (1.0, 0.5, 1.0);
            for (i, row) in noise_of_one_axis().iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    q[(b + i, b + j)] = *value;
                }
            }
            h[(b / 3, b)] = 1.0;
        }
        let r = Mat::<2, 2>::new(3.1, -0.6, -0.6, 2.9);
        Self { f, ft: f.transpose(), q, h, ht: h.transpose(), r }
    }
}

impl adskalman::TransitionModelLinearNoControl<f64, Dim<6>> for SixStates {
    fn F(&self) -> &Mat<6, 6> {
        &self.f
    }
    fn FT(&self) -> &Mat<6, 6> {
        &self.ft
    }
    fn Q(&self) -> &Mat<6, 6> {
        &self.q
    }
}

impl adskalman::ObservationModel<f64, Dim<6>, Dim<2>> for SixStates {
    fn H(&self) -> &Mat<2, 6> {
        &self.h
    }
    fn HT(&self) -> &Mat<6, 2> {
        &self.ht
    }
    fn R(&self) -> &Mat<2, 2> {
        &self.r
    }
}

/// adskalman: six states, as `ca6`, by the default (Joseph) form of its update.
fn adskalman_six_states(c: &mut Criterion) {
    let plots = plots(N + 1);
    let model = SixStates::new();
    let filter = adskalman::KalmanFilterNoControl::new(&model, &model);
    let first = plots[0].position_m;
    let x = Mat::<6, 1>::from([[first.x, 0.0, 0.0, first.y, 0.0, 0.0]]);
    let p = Mat::<6, 6>::from_diagonal(&Mat::<6, 1>::from([[3.0, 2500.0, 9.0, 3.0, 2500.0, 9.0]]));
    c.bench_function(&format!("adskalman, six states, {N} updates"), |b| {
        b.iter_batched_ref(
            || adskalman::StateAndCovariance::new(x, p),
            |state| {
                for plot in &plots[1..] {
                    *state =
                        filter.step(state, &plot.position_m.coords).expect("a regular innovation");
                }
                black_box(&state);
            },
            criterion::BatchSize::SmallInput,
        );
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().without_plots().sample_size(50);
    targets = ours, minikalman_two_axes, adskalman_six_states
}
criterion_main!(benches);
