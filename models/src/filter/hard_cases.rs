//! Hard cases of filtering, each with the law that must hold and what the naive form does.

use super::gaussian::{Gaussian, Measurement};
use super::histories::Histories;
use super::imm::Imm;
use super::lanes::{Lane, Pair};
use super::map::MapKnowledge;
use super::modes::Modes;
use super::motion::{Motion, Step};
use super::route::{Network, Route};
use super::six_state::SixState;
use super::testing::{plot_at, random_plots};
use super::three_state::ThreeState;
use super::ud::Ud;
use super::{Estimate, Estimator, FilterConfig, Rung, Start, StateEstimator, Sym2, UpdateError};
use crate::draw::{DrawKey, Purpose};
use crate::frames::Point2;
use crate::frames::Vector2;
use crate::plot::{Plot, polar_to_cartesian};
use crate::time::SimTime;
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use rand::RngExt;
use std::sync::Arc;

type Mat6 = SMatrix<f64, 6, 6>;

fn config(rung: Rung) -> FilterConfig {
    let mut config = FilterConfig::new(rung);
    let route = Route::from_course(Point2::origin(), 0.5).line(500.0, 0.0).arc(1.0, 80.0);
    config.map = Some(Arc::new(MapKnowledge::of(Network::single(route))));
    config
}

fn started(rung: Rung, plot: &Plot) -> Estimator {
    Estimator::from_plot(&config(rung), plot).expect("a sound plot starts a track")
}

fn sound(e: &Estimate) -> bool {
    e.state.is_sound()
}

/// Each row: a name, the plots that follow the first one, and whether the filter must take them.
#[test]
fn every_rung_stays_sound_in_every_hard_case() {
    let at = |t: f64, x: f64, y: f64, r: f64| plot_at(t, x, y, r);
    let cases: Vec<(&str, Plot, Vec<Plot>)> = vec![
        (
            "two plots at one time",
            at(0.0, 0.0, 0.0, 4.0),
            vec![at(1.0, 9.0, 0.0, 4.0), at(1.0, 11.0, 0.0, 4.0)],
        ),
        (
            "a nanosecond apart",
            at(0.0, 0.0, 0.0, 4.0),
            (1..50).map(|k| at(1e-9 * f64::from(k), 0.0, 0.0, 4.0)).collect(),
        ),
        (
            "an hour apart",
            at(0.0, 0.0, 0.0, 4.0),
            vec![at(1.0, 10.0, 0.0, 4.0), at(3601.0, 36_010.0, 0.0, 4.0)],
        ),
        (
            "a coast of 60 s, then a plot",
            at(0.0, 0.0, 0.0, 4.0),
            (1..20).map(f64::from).chain([79.0]).map(|t| at(t, 10.0 * t, 0.0, 4.0)).collect(),
        ),
        (
            "standing still",
            at(0.0, 50.0, 50.0, 4.0),
            (1..120).map(|k| at(f64::from(k), 50.0, 50.0, 4.0)).collect(),
        ),
        (
            "fifty sigma off",
            at(0.0, 0.0, 0.0, 4.0),
            (1..20)
                .map(|k| {
                    at(f64::from(k), 10.0 * f64::from(k), if k == 15 { 150.0 } else { 0.0 }, 4.0)
                })
                .collect(),
        ),
        (
            "a million metres off",
            at(0.0, 0.0, 0.0, 4.0),
            (1..20)
                .map(|k| {
                    at(f64::from(k), 10.0 * f64::from(k), if k == 15 { 1e6 } else { 0.0 }, 4.0)
                })
                .collect(),
        ),
        (
            "tiny R after huge P",
            at(0.0, 0.0, 0.0, 1e8),
            (1..20).map(|k| at(f64::from(k), 10.0 * f64::from(k), 0.0, 1e-8)).collect(),
        ),
        (
            "useless plots",
            at(0.0, 0.0, 0.0, 1.0),
            (1..20).map(|k| at(f64::from(k), 0.0, 0.0, 1e12)).collect(),
        ),
        (
            "collinear plots: one direction measured a million times better",
            at(0.0, 0.0, 0.0, 4.0),
            (1..50)
                .map(|k| Plot {
                    across_m2: 1e-6,
                    along_m2: 1e6,
                    axis: Vector2::new(0.6, 0.8),
                    ..at(f64::from(k), 6.0 * f64::from(k), 8.0 * f64::from(k), 1.0)
                })
                .collect(),
        ),
        (
            "at the airport's corner",
            at(0.0, 12_000.0, -9_000.0, 4.0),
            (1..50)
                .map(|k| at(f64::from(k), 12_000.0 - 15.0 * f64::from(k), -9_000.0, 4.0))
                .collect(),
        ),
    ];
    for (name, first, plots) in &cases {
        for (rung, rung_name) in Rung::ALL {
            let mut filter = started(rung, first);
            let mut refused = 0;
            for plot in plots {
                refused += usize::from(filter.update(plot).is_err());
                let e = filter.estimate();
                assert!(sound(&e), "{name}, {rung_name}: {e:?}");
                assert!(
                    sound(&filter.predicted(plot.time.plus_s(1.0)).unwrap()),
                    "{name}, {rung_name}"
                );
            }
            assert_eq!(refused, 0, "{name}, {rung_name}");
            let last = plots[plots.len() - 1].position_m;
            let off = (filter.estimate().position_m() - last).norm();
            let law = !["useless plots", "a million metres off"].contains(name)
                && !name.starts_with("collinear");
            assert!(off < 60.0 || !law, "{name}, {rung_name}: {off} m from the last plot");
        }
    }
}

#[test]
fn a_filter_that_refuses_a_plot_is_left_as_it_was() {
    let nan = f64::NAN;
    let bad = [
        ("back in time", plot_at(0.5, 0.0, 0.0, 4.0)),
        ("a clock that jumped back an hour", plot_at(-3_599.0, 0.0, 0.0, 4.0)),
        ("no number", plot_at(2.0, nan, 0.0, 4.0)),
        ("infinite", plot_at(2.0, 0.0, f64::INFINITY, 4.0)),
        ("negative variance", plot_at(2.0, 0.0, 0.0, -1.0)),
        ("variance no number", plot_at(2.0, 0.0, 0.0, nan)),
        ("axis no number", Plot { axis: Vector2::new(nan, 0.0), ..plot_at(2.0, 0.0, 0.0, 1.0) }),
    ];
    for (rung, rung_name) in Rung::ALL {
        let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
        filter.update(&plot_at(1.0, 5.0, 0.0, 4.0)).unwrap();
        let before = filter.estimate();
        for (name, plot) in &bad {
            assert!(filter.update(plot).is_err(), "{rung_name} took a plot: {name}");
            assert!(filter.update_manoeuvre(plot).is_err(), "{rung_name}: {name}");
            assert!(filter.update_weighted(&[(plot, 0.7)]).is_err(), "{rung_name}: {name}");
            assert_eq!(filter.estimate(), before, "{rung_name}: {name}");
        }
        assert!(matches!(filter.predicted(SimTime::ZERO), Err(UpdateError::BackInTime(_))));
        assert!(filter.update_weighted(&[]).is_err());
        assert!(Estimator::from_plot(&config(rung), &bad[2].1).is_err());
    }
}

#[test]
fn an_exact_plot_is_taken_exactly_and_a_second_one_refused() {
    for rung in [Rung::Ca3, Rung::Ca3Ud, Rung::Ca6, Rung::Ca6Ud, Rung::Mh9] {
        let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
        filter.update(&plot_at(1.0, 7.0, 3.0, 0.0)).expect("R = 0");
        let e = filter.estimate();
        assert!((e.position_m() - Point2::new(7.0, 3.0)).norm() < 1e-9, "{}", rung.name());
        assert!(sound(&e) && e.position_cov_m2().amax() < 1e-9, "{}", rung.name());
        // S = 0: 0/0 in the naive form.
        let again = filter.update(&plot_at(1.0, 7.1, 3.0, 0.0));
        assert!(
            again.is_err() || e.position_cov_m2().amax() > 0.0,
            "{}: two exact plots that differ",
            rung.name()
        );
        assert!(sound(&filter.estimate()));
    }
}

/// P − K S Kᵀ on a full matrix: what the covariance of this crate never does.
struct Naive {
    p: Mat6,
}

impl Naive {
    fn scan(&mut self, q: f64, r: Sym2) {
        let step = Step::constant_acceleration(q, 1.0);
        let mut phi = Mat6::identity();
        let mut noise = Mat6::zeros();
        for b in [0, 3] {
            (phi[(b, b + 1)], phi[(b, b + 2)], phi[(b + 1, b + 2)]) = (1.0, 0.5, 1.0);
            for (k, (i, j)) in
                [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
            {
                noise[(b + i, b + j)] = step.q[k];
                noise[(b + j, b + i)] = step.q[k];
            }
        }
        self.p = phi * self.p * phi.transpose() + noise;
        let mut h = SMatrix::<f64, 2, 6>::zeros();
        (h[(0, 0)], h[(1, 3)]) = (1.0, 1.0);
        let s = h * self.p * h.transpose() + r.matrix();
        let Some(inverse) = s.try_inverse() else { return };
        let k = self.p * h.transpose() * inverse;
        self.p -= k * s * k.transpose();
    }
}

#[test]
fn a_million_correlated_scans_stay_symmetric_and_at_the_fixed_point() {
    let r = Sym2 { xx: 4.0, xy: 0.5, yy: 3.0 };
    let mut state =
        Gaussian::at_position(Point2::origin(), Sym2 { xx: 4.0, xy: 0.0, yy: 4.0 }, 50.0, 3.0);
    let step = Step::constant_acceleration(0.3, 1.0);
    let mut early = Mat6::zeros();
    let m = Measurement::Position { z: Point2::origin(), r };
    for scan in 0..1_000_000 {
        state = state.predicted(&step);
        state.update(&m).unwrap();
        if scan == 2_000 {
            early = state.covariance();
        }
    }
    let late = state.covariance();
    assert_eq!(late, late.transpose());
    assert!(late.symmetric_eigenvalues().min() > 0.0);
    assert!((late - early).amax() < 1e-9 * early.amax(), "it drifts");
    // The naive form is no covariance any more after two hundred scans.
    let mut naive =
        Naive { p: Mat6::from_diagonal(&SVector::from([4.0, 2500.0, 9.0, 4.0, 2500.0, 9.0])) };
    (0..250).for_each(|_| naive.scan(0.3, r));
    let asymmetry = (naive.p - naive.p.transpose()).amax();
    let symmetric = 0.5 * (naive.p + naive.p.transpose());
    assert!(
        asymmetry > 1e-3
            || symmetric.symmetric_eigenvalues().min() <= 0.0
            || !asymmetry.is_finite(),
        "the naive form failed here in 2026: {asymmetry:e}"
    );
}

#[test]
fn a_tiny_variance_after_a_huge_one_keeps_its_digits_in_factored_form() {
    // P0 = 1e8, R = 1e-8, three constant-acceleration scans: P_pp is R to sixteen digits.
    let mut ud = Ud::<3, Pair>::diagonal([1e8; 3].map(Pair::splat));
    let mut joseph = [1e8, 0.0, 0.0, 1e8, 0.0, 1e8];
    for _ in 0..3 {
        ud = ud.jerked(1e-6, 1.0);
        ud.update_first(Pair::splat(1e-8));
        joseph = joseph_scan(joseph, 1e-6, 1e-8);
    }
    // Acceleration variance: three exact positions give it from the jerk noise and R alone.
    let found = ud.covariance(2, 2).east();
    assert!((found / 8.266_666_666_666_657e-7 - 1.0).abs() < 1e-12, "{found:e}");
    let naive = (joseph[5] / 8.266_666_666_666_657e-7 - 1.0).abs();
    assert!(naive > 1e-3, "Joseph's form was 11 % off here: {naive}");
}

/// Joseph's form on the full 3 × 3 matrix.
fn joseph_scan(p: [f64; 6], q: f64, r: f64) -> [f64; 6] {
    let full = |p: [f64; 6]| {
        SMatrix::<f64, 3, 3>::new(p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5])
    };
    let step = Step::constant_acceleration(q, 1.0);
    let phi = SMatrix::<f64, 3, 3>::new(1.0, 1.0, 0.5, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0);
    let prior = phi * full(p) * phi.transpose() + full(step.q);
    let h = SMatrix::<f64, 1, 3>::new(1.0, 0.0, 0.0);
    let k = prior.column(0) / (prior[(0, 0)] + r);
    let a = SMatrix::<f64, 3, 3>::identity() - k * h;
    let p = a * prior * a.transpose() + k * r * k.transpose();
    [p[(0, 0)], p[(0, 1)], p[(0, 2)], p[(1, 1)], p[(1, 2)], p[(2, 2)]]
}

#[test]
fn a_plot_fifty_sigma_off_decides_for_the_jump_mode() {
    let mut filter = Imm::<3>::from_plot(
        &plot_at(0.0, 0.0, 0.0, 4.0),
        Arc::new(Modes::three()),
        Start::default(),
    )
    .unwrap();
    for k in 1..30 {
        filter.update(&plot_at(f64::from(k), 10.0 * f64::from(k), 0.0, 4.0)).unwrap();
    }
    assert!(filter.weights()[2] < 0.1);
    filter.update(&plot_at(30.0, 300.0, 120.0, 4.0)).unwrap();
    let w = filter.weights();
    assert!(w[2] > 1.0 - 1e-9, "{w:?}");
    // Likelihoods themselves, floored at the smallest number, give every mode its prior back.
    let naive = [3000f64, 3000.0, 60.0].map(|d2| libm::exp(-0.5 * d2).max(f64::MIN_POSITIVE));
    assert_eq!(naive[0], naive[1]);
    assert!(naive[0] > 0.0 && libm::exp(-1500.0) == 0.0);
}

#[test]
fn all_likelihoods_underflowing_leaves_finite_weights() {
    // 1e8 m off: d² is beyond 1e14 in every mode, exp(−d²/2) zero in all of them.
    for rung in [Rung::Imm3, Rung::Mh3, Rung::Mh9, Rung::Mh27, Rung::Mh9Lag1, Rung::Mh9Map] {
        let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
        for k in 1..10 {
            filter.update(&plot_at(f64::from(k), 10.0 * f64::from(k), 0.0, 4.0)).unwrap();
        }
        filter.update(&plot_at(10.0, 1e8, -1e8, 4.0)).unwrap();
        assert!(sound(&filter.estimate()), "{}", rung.name());
        filter.update(&plot_at(11.0, 110.0, 0.0, 4.0)).unwrap();
        assert!(sound(&filter.estimate()), "{}", rung.name());
    }
}

#[test]
fn headings_near_north_south_and_standstill() {
    let heading = |vx: f64, vy: f64, sigma: f64| {
        let mut state = Gaussian::at_position(Point2::origin(), Sym2::default(), sigma, 1.0);
        state.x[1] = Pair::new(vx, vy);
        Estimate::new(SimTime::ZERO, state).heading_rad()
    };
    for (name, vx, vy, expected) in [
        ("north", 0.0, 10.0, 0.0),
        ("just west of north", -1e-18, 10.0, 0.0),
        ("west of north", -1e-9, 10.0, std::f64::consts::TAU - 1e-10),
        ("south, from the east", 1e-9, -10.0, std::f64::consts::PI - 1e-10),
        ("south, from the west", -1e-9, -10.0, std::f64::consts::PI + 1e-10),
        ("west", -10.0, 0.0, 1.5 * std::f64::consts::PI),
    ] {
        let (found, _) = heading(vx, vy, 0.1).expect(name);
        assert!(
            (found - expected).abs() < 1e-15 && found < std::f64::consts::TAU,
            "{name}: {found}"
        );
    }
    // Noise at standstill has no heading; nor has a speed less certain than itself.
    assert_eq!(heading(0.01, -0.02, 0.1), None);
    assert_eq!(heading(0.0, 0.0, 0.0), None);
    assert_eq!(heading(3.0, 0.0, 5.0), None);
}

#[test]
fn standing_still_for_an_hour_ends_at_rest() {
    for (rung, name) in Rung::ALL {
        let mut filter = started(rung, &plot_at(0.0, 100.0, 40.0, 4.0));
        let mut rng = DrawKey { run_seed: 5, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
        let mut noise = || 3.0 * (rng.random::<f64>() + rng.random::<f64>() - 1.0);
        let mut sum = 0.0;
        for k in 1..3600 {
            filter.update(&plot_at(f64::from(k), 100.0 + noise(), 40.0 + noise(), 4.0)).unwrap();
            if k > 100 {
                sum += (filter.estimate().position_m() - Point2::new(100.0, 40.0)).norm_squared();
            }
        }
        // Uniform sums of ±1.5 each have a variance of 1.5 m² per axis: a track is better than a plot.
        let rms = (sum / 3500.0).sqrt();
        assert!(rms < 3f64.sqrt(), "{name}: {rms} m");
        let (speed, _) = filter.estimate().speed_mps();
        assert!(speed < 3.0, "{name}: {speed} m/s");
        assert!(sound(&filter.estimate()), "{name}");
    }
}

#[test]
fn a_target_at_the_radar_is_a_plot_like_any_other() {
    for range_m in [0.0, 1e-6, 0.5, 10.0] {
        let (offset, along, across) =
            polar_to_cartesian(Vector2::new(0.6, 0.8), range_m, 1.5, 1e-3);
        assert!(offset.norm() <= range_m * 1.001 && along > 0.0 && across > 0.0, "{range_m}");
        let plot = Plot {
            axis: Vector2::new(0.6, 0.8),
            along_m2: along,
            across_m2: across,
            ..plot_at(1.0, offset.x, offset.y, 1.0)
        };
        for (rung, name) in Rung::ALL {
            let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
            filter.update(&plot).expect(name);
            assert!(sound(&filter.estimate()), "{name} at {range_m} m");
        }
    }
}

#[test]
fn a_million_updates_a_microsecond_apart_do_not_drift() {
    // The bound: constant-acceleration least squares over one second; the covariance must follow it.
    let zero = Pair::default();
    let p = [4.0, 0.0, 0.0, 1.0, 0.0, 1.0].map(Pair::splat);
    let mut filter = ThreeState::new(SimTime::ZERO, [zero; 3], p, 1e-12, Start::default());
    for k in 1..=1_000_000_i64 {
        let mut plot = plot_at(0.0, 0.0, 0.0, 1e6);
        plot.time = SimTime(k * 1_000);
        filter.update(&plot).unwrap();
    }
    let e = filter.estimate();
    assert!(sound(&e) && e.position_m() == Point2::origin());
    // A million plots of 1e6 m² are one of 1 m²: the information about the position grows by about one.
    let pp = e.position_cov_m2()[(0, 0)];
    assert!(pp > 0.3 && pp < 4.0, "{pp}");
}

#[test]
fn a_million_tracks_created_and_dropped_leave_nothing_behind() {
    let (mut sum, config) = (0.0, config(Rung::Ca3));
    for k in 0..1_000_000 {
        let first = plot_at(0.0, f64::from(k), 0.0, 4.0);
        let mut filter = Estimator::from_plot(&config, &first).expect("a sound plot");
        filter.update(&plot_at(1.0, f64::from(k) + 5.0, 0.0, 4.0)).unwrap();
        sum += filter.estimate().position_m().y.abs();
    }
    assert_eq!(sum, 0.0);
    assert!(size_of::<Estimator>() <= 512, "{}", size_of::<Estimator>());
}

#[test]
fn one_scan_of_lag_is_one_step_of_the_smoother() {
    // One history, one mode: the lagged state must be the smoothed one of two scans.
    let plots = random_plots(12, 4);
    let modes = Arc::new(
        Modes::new(&[Motion::ConstantAcceleration { q: 0.5 }], &[&[1.0]], &[1.0]).unwrap(),
    );
    let mut filter = Histories::<3, 3>::from_plot(&plots[0], modes, Start::default()).unwrap();
    assert_eq!(filter.lagged(), None);
    for k in 1..plots.len() {
        filter.update(&plots[k]).unwrap();
        let motion = Motion::ConstantAcceleration { q: 0.5 };
        let smoothed = super::smoother::smooth(&plots[..=k], motion, Start::default()).unwrap();
        let lagged = filter.lagged().unwrap();
        assert_eq!(lagged.time, plots[k - 1].time);
        assert!((lagged.position_m() - smoothed[k - 1].position_m()).norm() < 1e-9);
        let difference = lagged.state.covariance() - smoothed[k - 1].state.covariance();
        assert!(difference.amax() < 1e-7 * smoothed[k - 1].state.covariance().amax());
    }
}

#[test]
fn the_two_ways_to_the_same_covariance_agree() {
    // Six states at once, and factored along the plot's own axes.
    let plots = random_plots(200, 9);
    let (mut a, mut b) = (started(Rung::Ca6, &plots[0]), started(Rung::Ca6Ud, &plots[0]));
    for plot in &plots[1..] {
        let (na, nb) = (a.update(plot).unwrap(), b.update(plot).unwrap());
        assert!((na.d2 - nb.d2).abs() < 1e-9 * na.d2.max(1.0));
        assert!((na.det / nb.det - 1.0).abs() < 1e-9);
        let difference = a.estimate().state.covariance() - b.estimate().state.covariance();
        assert!(difference.amax() < 1e-9 * a.estimate().state.covariance().amax());
    }
}

#[test]
fn a_plot_along_one_direction_says_nothing_of_the_other() {
    let line = Plot {
        axis: Vector2::new(1.0, 0.0),
        along_m2: 0.01,
        across_m2: f64::INFINITY,
        ..plot_at(5.0, 52.0, 1e6, 1.0)
    };
    for rung in
        [Rung::Ca3, Rung::Ca3Ud, Rung::Ca6, Rung::Ca6Ud, Rung::Imm3, Rung::Mh9, Rung::Mh9Lag1]
    {
        let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
        for k in 1..5 {
            filter.update(&plot_at(f64::from(k), 10.0 * f64::from(k), 0.0, 4.0)).unwrap();
        }
        let before = filter.predicted(line.time).unwrap();
        let nis = filter.update(&line).unwrap_or_else(|e| panic!("{}: {e}", rung.name()));
        assert_eq!(nis.dof, 1);
        let e = filter.estimate();
        assert!((e.position_m().x - 52.0).abs() < 0.3, "{}", rung.name());
        assert!((e.position_m().y - before.position_m().y).abs() < 1.0, "{}", rung.name());
        assert!(sound(&e));
    }
}

#[test]
fn a_manoeuvre_is_followed_where_a_plain_update_lags() {
    for (rung, name) in Rung::ALL {
        let mut plain = started(rung, &plot_at(0.0, 0.0, 0.0, 1.0));
        for k in 1..20 {
            plain.update(&plot_at(f64::from(k), 15.0 * f64::from(k), 0.0, 1.0)).unwrap();
        }
        let mut marked = plain.clone();
        let surprise = plot_at(20.0, 290.0, 10.0, 1.0);
        plain.update(&surprise).unwrap();
        marked.update_manoeuvre(&surprise).unwrap();
        let off = |f: &Estimator| (f.estimate().position_m() - surprise.position_m).norm();
        assert!(off(&marked) <= off(&plain) + 0.2, "{name}: {} {}", off(&marked), off(&plain));
        assert!(sound(&marked.estimate()), "{name}");
        // Two plots are enough to start again.
        marked.restart(&surprise, &plot_at(21.0, 286.0, 24.0, 1.0)).unwrap();
        let velocity = marked.estimate().velocity_mps();
        assert!((velocity - Vector2::new(-4.0, 14.0)).norm() < 1e-9, "{name}: {velocity}");
        assert!(marked.restart(&surprise, &surprise).is_err(), "no time between the plots");
    }
}

/// A manoeuvre is a shift of ½at² and a change of speed of at, so 2/t of the shift: over milliseconds any shift would
/// be hundreds of metres per second.
#[test]
fn two_sensors_that_disagree_within_milliseconds_are_no_manoeuvre() {
    for rung in [Rung::Ca3, Rung::Ca6] {
        let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 1.0));
        for k in 1..=20 {
            let t = f64::from(k);
            filter.update(&plot_at(t, 10.0 * t, 0.0, 1.0)).expect("sound");
        }
        let (before, off) = (filter.motion().1, plot_at(20.03, 200.3, 12.0, 1.0));
        filter.update_manoeuvre(&off).expect("sound");
        let change = (filter.motion().1 - before).norm();
        assert!(change < 2.0, "{rung:?}: {change:.1} m/s in 30 ms");
    }
}

#[test]
fn one_certain_plot_among_several_is_an_ordinary_update() {
    for (rung, name) in Rung::ALL {
        if rung == Rung::Abg || rung == Rung::Mh9Map {
            continue; // fixed gains and merged plots: sound below, not equal
        }
        let mut a = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
        for k in 1..8 {
            a.update(&plot_at(f64::from(k), 10.0 * f64::from(k), 0.0, 4.0)).unwrap();
        }
        let mut b = a.clone();
        let (right, wrong) = (plot_at(8.0, 81.0, 1.0, 4.0), plot_at(8.0, 95.0, 9.0, 4.0));
        a.update(&right).unwrap();
        b.update_weighted(&[(&right, 1.0), (&wrong, 0.0)]).unwrap();
        let (a, b) = (a.estimate(), b.estimate());
        assert!((a.position_m() - b.position_m()).norm() < 1e-6, "{name}");
        let difference = a.state.covariance() - b.state.covariance();
        assert!(difference.amax() < 1e-6 * a.state.covariance().amax(), "{name}");
    }
}

fn any_plot(t: f64, x: f64, y: f64, angle: f64, along: f64, across: f64) -> Plot {
    Plot {
        axis: Vector2::new(libm::cos(angle), libm::sin(angle)),
        along_m2: along,
        across_m2: across,
        ..plot_at(t, x, y, 1.0)
    }
}

/// The same a second before.
fn before_plot(plot: &Plot) -> Plot {
    Plot { time: plot.time.plus_s(-1.0), ..*plot }
}

/// Any f64 now and then, an ordinary one mostly.
fn hostile(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    prop_oneof![8 => range, 1 => any::<f64>()]
}

#[test]
fn an_exact_line_a_hair_off_an_axis_is_taken_or_refused_but_never_half_taken() {
    for (rung, name) in Rung::ALL {
        for angle in [-5.8e-162, 5e-324, 1e-200, 1e-155, 1e-80, 1e-9] {
            for (along, across) in [(3.2, 0.0), (0.0, 3.2), (3.2, 5e-324), (0.0, 0.0)] {
                let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
                let before = filter.estimate();
                let plot = any_plot(0.0, 0.0, 0.0, angle, along, across);
                // The naive factored form divides by a variance of 6e-323: infinite factors, NaN next.
                let taken = filter.update(&plot).is_ok();
                let after = filter.estimate();
                assert!(taken || after == before, "{name}: angle {angle:e}");
                assert!(
                    after.state.covariance().iter().all(|v| v.is_finite()),
                    "{name}: {angle:e}"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_plots_keep_every_rung_sound(seed in 0..1_000_000u64, q in 1e-4..100.0f64) {
        let plots = random_plots(40, seed);
        for (rung, name) in Rung::ALL {
            let mut config = config(rung);
            config.q = q;
            let mut filter = Estimator::from_plot(&config, &plots[0]).unwrap();
            for plot in &plots[1..] {
                let nis = filter.update(plot).unwrap();
                prop_assert!(nis.d2 >= 0.0 && nis.det > 0.0, "{} {:?}", name, nis);
                prop_assert!(sound(&filter.estimate()), "{}", name);
            }
        }
    }

    #[test]
    fn hostile_plots_never_make_a_number_that_is_none(
        plots in proptest::collection::vec(
            (hostile(0.0..2.0), hostile(-1e4..1e4), hostile(-1e4..1e4), hostile(-4.0..4.0),
             hostile(0.0..10.0), hostile(0.0..10.0)), 1..30),
    ) {
        for (rung, name) in Rung::ALL {
            let mut filter = started(rung, &plot_at(0.0, 0.0, 0.0, 4.0));
            let mut t = 0.0;
            for (dt, x, y, angle, along, across) in &plots {
                let angle = if angle.is_finite() { *angle } else { 0.0 };
                t = if dt.abs() < 1e6 { t + dt } else { t };
                let plot = any_plot(t, *x, *y, angle, *along, *across);
                let before = filter.estimate();
                if filter.update(&plot).is_err() {
                    prop_assert_eq!(filter.estimate(), before, "{}", name);
                }
                let e = filter.estimate();
                let finite = e.state.x.iter().all(|v| v.sum().is_finite())
                    && e.state.covariance().iter().all(|v| v.is_finite());
                prop_assert!(finite, "{}: {:?} after {:?}", name, e, plot);
            }
        }
    }

    #[test]
    fn any_model_and_any_order_of_operations_leave_a_state_of_numbers(
        noise in (1e-12..1e6f64, 1e-12..1e6f64, 1e-12..1e6f64),
        switch in proptest::collection::vec(prop_oneof![3 => 1e-9..0.3f64, 1 => Just(0.0)], 6),
        start in (1e-3..1e4f64, 1e-3..1e3f64),
        q in prop_oneof![1e-12..1e6f64, Just(0.0)],
        steps in proptest::collection::vec(
            (0usize..5, prop_oneof![6 => 0.0..3.0f64, 1 => Just(0.0), 1 => 0.0..1e5f64, 1 => -1e4..0.0f64],
             (-1e5..1e5f64, -1e5..1e5f64, 0.0..1.0f64),
             (0.0..7.0f64, prop_oneof![3 => 0.0..100.0f64, 1 => Just(0.0)],
              prop_oneof![4 => 0.0..100.0f64, 1 => Just(f64::INFINITY), 1 => Just(1e12)])), 1..25),
    ) {
        let row = |i: usize| {
            let (a, b) = (switch[2 * i], switch[2 * i + 1]);
            let stay = 1.0 - a - b;
            [[stay, a, b], [a, stay, b], [a, b, stay]][i]
        };
        let rows = [row(0), row(1), row(2)];
        let motions = [
            Motion::ConstantVelocity { q: noise.0 },
            Motion::ConstantAcceleration { q: noise.1 },
            Motion::Singer { rate: 0.1 + switch[0], q: noise.2 },
        ];
        let modes = Modes::new(&motions, &rows.each_ref().map(|r| &r[..]), &[0.5, 0.3, 0.2]);
        let modes = Arc::new(modes.expect("rows sum to 1"));
        for (rung, name) in Rung::ALL {
            let mut config = config(rung);
            config.q = q;
            config.modes = Arc::clone(&modes);
            config.start = Start { sigma_v_mps: start.0, sigma_a_ms2: start.1 };
            let mut filter = Estimator::from_plot(&config, &plot_at(0.0, 0.0, 0.0, 4.0)).unwrap();
            let mut t: f64 = 0.0;
            for (operation, dt, (x, y, beta), (angle, along, across)) in &steps {
                t = if *dt < 0.0 { t } else { t + dt };
                let plot = any_plot(t + dt.min(0.0), *x, *y, *angle, *along, *across);
                let near = plot_at(t, x + 3.0, y - 2.0, 1.0 + along);
                let before = filter.estimate();
                let done = match operation {
                    0 | 1 => filter.update(&plot).map(|_| ()),
                    2 => filter.update_manoeuvre(&plot).map(|_| ()),
                    3 => filter.update_weighted(&[(&near, 0.5 * beta), (&plot, 0.4 * beta)]),
                    _ => filter.restart(&before_plot(&plot), &plot),
                };
                if done.is_err() {
                    prop_assert_eq!(filter.estimate(), before, "{}", name);
                }
                for at in [Ok(filter.estimate()), filter.predicted(filter.time().plus_s(1.5))] {
                    let Ok(e) = at else { continue };
                    let finite = e.state.x.iter().all(|v| v.sum().is_finite())
                        && e.state.covariance().iter().all(|v| v.is_finite());
                    prop_assert!(finite, "{}: {:?} after {} of {:?}", name, e, operation, plot);
                }
                let (place, velocity) = filter.motion();
                let e = filter.estimate();
                let off = (place - e.position_m()).norm() + (velocity - e.velocity_mps()).norm();
                prop_assert!(off <= 1e-6 * (1.0 + place.coords.norm() + velocity.norm()), "{}: {}", name, off);
                let later = filter.time().plus_s(0.7);
                if let (Ok(a), Ok((b, _))) = (filter.place_at(later), filter.position_at(later)) {
                    prop_assert!((a - b).norm() <= 1e-6 * (1.0 + a.coords.norm()), "{}: {} {}", name, a, b);
                }
            }
        }
    }

    #[test]
    fn two_equal_radars_are_one_with_half_the_variance(
        x in -50.0..50.0f64, y in -50.0..50.0f64, r in 0.1..100.0f64,
    ) {
        let start = plot_at(0.0, 0.0, 0.0, 9.0);
        let motion = Motion::ConstantAcceleration { q: 0.3 };
        let fresh = || SixState::from_plot(&start, motion, Start::default()).unwrap();
        let (first, second) = (plot_at(1.0, x, y, r), plot_at(1.0, y, x, r));
        let middle = plot_at(1.0, 0.5 * (x + y), 0.5 * (x + y), 0.5 * r);
        let (mut a, mut b, mut c) = (fresh(), fresh(), fresh());
        a.update(&first).unwrap();
        a.update(&second).unwrap();
        b.update(&second).unwrap();
        b.update(&first).unwrap();
        c.update(&middle).unwrap();
        for other in [b.estimate(), c.estimate()] {
            prop_assert!((a.estimate().position_m() - other.position_m()).norm() < 1e-9);
            let difference = a.estimate().state.covariance() - other.state.covariance();
            prop_assert!(difference.amax() < 1e-7);
        }
    }
}
