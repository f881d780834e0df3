//! One second ago: against the joint conditioning of everything at once, and on traffic.

use super::*;
use crate::filter::{FilterConfig, Rung};
use config::{AssociationMethod, SensorModel};
use nalgebra::{DMatrix, DVector, Matrix3};

const Q: f64 = 0.3;

fn phi(t: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, t, 0.5 * t * t, 0.0, 1.0, t, 0.0, 0.0, 1.0)
}

fn noise(t: f64) -> Matrix3<f64> {
    let [a, b, c, d, e] =
        [t.powi(5) / 20.0, t.powi(4) / 8.0, t.powi(3) / 6.0, t.powi(3) / 3.0, t * t / 2.0];
    Matrix3::new(a, b, c, b, d, e, c, e, t) * Q
}

/// Mean and variance of the position at `then`, of one axis that starts at time 0 with `start_m2` and no motion known,
/// given plots (time, position, variance), by the covariance of all of them at once.
fn conditioned(then: f64, start_m2: [f64; 3], plots: &[(f64, f64, f64)]) -> (f64, f64) {
    let times: Vec<f64> = plots.iter().map(|p| p.0).chain([then]).collect();
    let p0 = Matrix3::from_diagonal(&start_m2.into());
    let covariance = |a: f64, b: f64| {
        let (early, late) = if a < b { (a, b) } else { (b, a) };
        let p = phi(early) * p0 * phi(early).transpose() + noise(early);
        (p * phi(late - early).transpose())[(0, 0)]
    };
    let n = plots.len();
    let mut s = DMatrix::from_fn(n, n, |i, j| covariance(times[i], times[j]));
    (0..n).for_each(|i| s[(i, i)] += plots[i].2);
    let c = DVector::from_fn(n, |i, _| covariance(times[i], then));
    let z = DVector::from_fn(n, |i, _| plots[i].1);
    let gain = s.cholesky().expect("positive definite").solve(&c);
    (gain.dot(&z), covariance(then, then) - gain.dot(&c))
}

fn plot(t_s: f64, sequence: u32, x: f64, variance_m2: f64) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Mlat,
        time: SimTime::from_s(t_s),
        sequence,
        position_m: Point2::new(x, 0.0),
        axis: Vector2::new(1.0, 0.0),
        along_m2: variance_m2,
        across_m2: variance_m2,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

#[test]
fn it_is_what_conditioning_on_all_plots_at_once_gives_on_time_or_late() {
    // The first plot starts the track: position known to its variance, speed and acceleration to the start's.
    for (name, rung) in [("ca3", Rung::Ca3), ("ca6", Rung::Ca6), ("ca6-ud", Rung::Ca6Ud)] {
        let mut config = TrackingConfig::paper();
        config.filter = FilterConfig { q: Q, ..FilterConfig::new(rung) };
        config.association = AssociationMethod::Nearest;
        (config.gates.probability, config.gates.kinematic) = (1.0, false);
        for id in [1, 2] {
            let model = SensorModel::default_of(SensorId(id), SensorKind::Mlat);
            config.sensors.push(SensorModel { extra_sigma_m: 0.0, ..model });
        }
        let start = config.filter.start;
        let start_m2 = [4.0, start.sigma_v_mps.powi(2), start.sigma_a_ms2.powi(2)];
        let mut tracker = Tracker::new(config);
        let mut given: Vec<(f64, f64, f64)> = Vec::new();
        let (mut compared, mut late) = (0, None);
        for k in 0..14u32 {
            let t_out = f64::from(k) + 0.6;
            let x = |t: f64| 3.0 * t + 2.0 * libm::sin(t);
            let mut plots = vec![plot(f64::from(k), 0, x(f64::from(k)) + 0.3, 4.0)];
            // Two sensors from scan 5 on, nothing in scan 8, and in scan 9 what scan 7 should have had.
            if k >= 5 {
                let mut second = plot(f64::from(k) + 0.5, 0, x(f64::from(k) + 0.5) - 0.4, 1.0);
                second.sensor = SensorId(2);
                plots.push(second);
            }
            match k {
                7 => late = plots.pop(),
                8 => plots.clear(),
                9 => plots.extend(late.take()),
                _ => {}
            }
            given.extend(plots.iter().map(|p| (p.time.s(), p.position_m.x, p.along_m2)));
            let tracks = tracker.scan(SimTime::from_s(t_out), &plots, &FlightList::default());
            let Some(lag) = tracks.first().and_then(|t| t.second_ago) else {
                assert!(k < 4, "{name}: from the second report on, {k}");
                continue;
            };
            let mut all = given[1..].to_vec();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let offset = given[0].1;
            all.iter_mut().for_each(|p| p.1 -= offset);
            let (mean, variance) = conditioned(t_out - 1.0, start_m2, &all);
            let (found, claimed) = (lag.position_m.x - offset, lag.cov_m2[(0, 0)]);
            assert!((found - mean).abs() < 1e-6, "{name} {k}: {found} for {mean}");
            assert!(
                (claimed - variance).abs() < 1e-5 * variance,
                "{name} {k}: {claimed} {variance}"
            );
            assert!((lag.time.s() - (t_out - 1.0)).abs() < 1e-9);
            assert_eq!(lag.coasted, k == 8, "{name} {k}");
            compared += 1;
        }
        assert!(compared >= 10, "{name}");
    }
}

#[test]
fn a_second_later_every_rung_knows_better_where_a_target_was_and_how_well() {
    let joint = AssociationMethod::Joint { limit: 16_384 };
    let mut worst: Vec<String> = Vec::new();
    for (rung, name) in Rung::ALL {
        let (mut now2, mut ago2, mut nees, mut count) = (0.0, 0.0, 0.0, 0.0);
        let mut strayed = 0.0;
        for seed in [1, 2] {
            let radar = tower(seed, 0.95, 1);
            let paths = traffic();
            let mut config = TrackingConfig::paper();
            config.filter = FilterConfig::new(rung);
            config.association = joint;
            let mut tracker = Tracker::new(config);
            for k in 1..=150 {
                let plots: Vec<Plot> = radar.scan(k, &paths).into_iter().map(|l| l.0).collect();
                let t_out = SimTime::from_s(f64::from(k));
                let tracks = tracker.scan(t_out, &plots, &FlightList::default());
                for path in &paths {
                    let truth = |t: f64| path(t).expect("moves for ever");
                    let moves = (truth(t_out.s()) - truth(t_out.s() - 1.0)).norm() > 0.5;
                    let near = |t: &&SystemTrack| (t.position_m - truth(t_out.s())).norm() < 25.0;
                    let Some(track) = tracks.iter().find(near).filter(|_| k > 8 && moves) else {
                        continue;
                    };
                    let Some(lag) = track.second_ago else { continue };
                    let error = lag.position_m - truth(lag.time.s());
                    // What began again in this scan was published elsewhere before: it counts in neither.
                    if error.norm() > 25.0 {
                        strayed += 1.0;
                        continue;
                    }
                    now2 += (track.position_m - truth(t_out.s())).norm_squared();
                    ago2 += error.norm_squared();
                    let inverse = lag.cov_m2.try_inverse().expect("a covariance");
                    nees += error.dot(&(inverse * error));
                    count += 1.0;
                }
            }
        }
        let reduction = 1.0 - ago2 / now2;
        println!(
            "{name}: now {:.2} m, one second ago {:.2} m, {:.0} %, NEES {:.1}",
            (now2 / count).sqrt(),
            (ago2 / count).sqrt(),
            100.0 * reduction,
            nees / count
        );
        if !(count > 500.0 && reduction > 0.2 && strayed < 0.01 * count) {
            worst.push(format!("{name}: {reduction:.2} of {count}"));
        }
    }
    assert!(worst.is_empty(), "{worst:?}");
}
