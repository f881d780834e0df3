//! Plots for the tests of the filters.

use super::motion::Motion;
use super::six_state::SixState;
use super::{Estimate, Start, StateEstimator};
use crate::draw::{DrawKey, Purpose, normal_pair};
use crate::frames::Point2;
use crate::frames::Vector2;
use crate::plot::{Plot, Polar, SensorId, SensorKind};
use crate::time::SimTime;
use rand::RngExt;

/// A plot at `time_s` seconds with a circular error of variance `r`, m².
pub(crate) fn plot_at(time_s: f64, x: f64, y: f64, r: f64) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime::from_s(time_s),
        sequence: 0,
        position_m: Point2::new(x, y),
        axis: Vector2::new(1.0, 0.0),
        along_m2: r,
        across_m2: r,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

/// Two numbers N(0, 1), the same for the same key.
pub(crate) fn drawn(seed: u64, sensor: u32, entity: u64, scan: u64) -> Vector2<f64> {
    let (a, b) =
        normal_pair(&mut DrawKey { run_seed: seed, sensor, entity, scan }.rng(Purpose::Study));
    Vector2::new(a, b)
}

/// A Gauss–Markov error of variance 1 after a step of which `keep` is the correlation.
pub(crate) fn slower(error: Vector2<f64>, keep: f64, drawn: Vector2<f64>) -> Vector2<f64> {
    error * keep + drawn * (1.0 - keep * keep).sqrt()
}

/// The plot as a radar at the origin has it, with these errors (variances along and across, m²).
pub(crate) fn by_radar(plot: Plot, [along_m2, across_m2]: [f64; 2]) -> Plot {
    let at = plot.position_m.coords;
    let range_m = at.norm();
    let polar = Polar {
        range_m,
        azimuth_rad: libm::atan2(at.x, at.y),
        sigma_range_m: along_m2.sqrt(),
        sigma_azimuth_rad: across_m2.sqrt() / range_m,
        extent_m2: None,
    };
    Plot {
        kind: SensorKind::Asde,
        axis: at / range_m,
        along_m2,
        across_m2,
        polar: Some(polar),
        ..plot
    }
}

/// Way along x of what goes to and stops, again and again: 20 s at 20 m/s, 10 s of braking, 10 s of standing, 10 s of speeding up, m.
pub(crate) fn stops_and_goes(t: f64) -> f64 {
    let (rounds, u) = ((t / 50.0).floor(), t.rem_euclid(50.0));
    let (slower, faster) = ((u - 20.0).clamp(0.0, 10.0), (u - 40.0).max(0.0));
    600.0 * rounds + 20.0 * u.min(20.0) + (20.0 - slower) * slower + faster * faster
}

/// `n` plots about a second apart of something that wanders, with oblique error ellipses.
pub(crate) fn random_plots(n: usize, seed: u64) -> Vec<Plot> {
    let mut rng = DrawKey { run_seed: seed, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
    let mut t = 0.0;
    let mut velocity = Vector2::new(20.0, 5.0);
    let mut at = Vector2::new(-300.0, 200.0);
    (0..n)
        .map(|_| {
            let dt = 0.2 + 1.6 * rng.random::<f64>();
            t += dt;
            velocity += Vector2::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5) * 3.0;
            at += velocity * dt;
            let angle = 6.0 * rng.random::<f64>();
            let error = Vector2::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5) * 4.0;
            Plot {
                axis: Vector2::new(libm::cos(angle), libm::sin(angle)),
                along_m2: 1.0 + 3.0 * rng.random::<f64>(),
                across_m2: 0.5 + 5.0 * rng.random::<f64>(),
                ..plot_at(t, at.x + error.x, at.y + error.y, 1.0)
            }
        })
        .collect()
}

/// The filtered states of `plots` under one motion model.
pub(crate) fn track_of(plots: &[Plot], motion: Motion, start: Start) -> Vec<Estimate> {
    let mut filter = SixState::from_plot(&plots[0], motion, start).expect("a sound plot");
    let mut out = vec![filter.estimate()];
    for plot in &plots[1..] {
        filter.update(plot).expect("a sound plot");
        out.push(filter.estimate());
    }
    out
}
