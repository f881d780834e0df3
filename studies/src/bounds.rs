//! Cramér–Rao bounds of the single-target scenes, computed from the scenes themselves.
//!
//! The path is taken as pieces of constant acceleration with unknown values (priors 50 m/s and 3 m/s²
//! per axis) whose switch times are told. For a linear model with Gaussian errors the covariance of the
//! Kalman filter without process noise, re-opened at each switch, is the bound of every causal
//! estimator; one scan of lag and the full smoother follow from the same covariances. A turn counts as
//! a constant acceleration told to be one, which is more than anybody knows: its lines are low. Source: Tichavský, Muravchik, Nehorai, IEEE
//! Trans. SP-46 (1998), for the recursion.

use crate::scenes::{Leg, Noise, Scene, plot};
use models::frames::Vector2;
use nalgebra::{SMatrix, SVector};

/// Mean squared position errors, m², from `skip` scans on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// Switch times told.
    pub(crate) switches: f64,
    /// And which legs have no acceleration.
    pub(crate) legs: f64,
    /// And one second of lag.
    pub(crate) legs_lag: f64,
    /// Switch times, steady legs and the centreline told: along-track only, speed continuous.
    pub(crate) map: f64,
    /// Switch times told, all plots.
    pub(crate) smoother: f64,
}

const SIGMA_V: f64 = 50.0;
const SIGMA_A: f64 = 3.0;

/// What happens at the start of a leg.
#[derive(Clone, Copy)]
struct Switch {
    time_s: f64,
    corner: bool,
    steady: bool,
}

/// `on_map`: seen along the centreline, where a turn is no acceleration.
fn switches(scene: &Scene, on_map: bool) -> Vec<Switch> {
    let times = scene.switches_s();
    let steady = |leg: &Leg| leg.acceleration_ms2 == 0.0 && (on_map || leg.curvature == 0.0);
    let later = times.iter().zip(&scene.legs[1..]).map(|(time_s, leg)| Switch {
        time_s: *time_s,
        corner: leg.corner_rad != 0.0,
        steady: steady(leg),
    });
    later.collect()
}

/// A linear model scan by scan: x ← F x + w, cov w = Q, then scalar measurements (h, r).
struct Model<const N: usize> {
    prior: SMatrix<f64, N, N>,
    steps: Vec<(SMatrix<f64, N, N>, SMatrix<f64, N, N>)>,
    measured: Vec<Vec<(SVector<f64, N>, f64)>>,
}

/// Covariances of every scan: filtered, with one scan of lag (one fewer), smoothed.
struct Covariances<const N: usize> {
    filtered: Vec<SMatrix<f64, N, N>>,
    lagged: Vec<SMatrix<f64, N, N>>,
    smoothed: Vec<SMatrix<f64, N, N>>,
}

impl<const N: usize> Model<N> {
    fn covariances(&self) -> Covariances<N> {
        type M<const N: usize> = SMatrix<f64, N, N>;
        let mut p = self.prior;
        let mut filtered = Vec::new();
        // What the measurements of a scan say of the state before them: C and HᵀS⁻¹H, in order.
        let mut said: Vec<Vec<(M<N>, M<N>)>> = Vec::new();
        for (k, measured) in self.measured.iter().enumerate() {
            if k > 0 {
                let (f, q) = &self.steps[k - 1];
                p = f * p * f.transpose() + q;
            }
            let mut of_scan = Vec::new();
            for (h, r) in measured {
                let column = p * h;
                let s = h.dot(&column) + r;
                of_scan
                    .push((M::<N>::identity() - column / s * h.transpose(), h * h.transpose() / s));
                p -= column * column.transpose() / s;
                p = 0.5 * (p + p.transpose());
            }
            said.push(of_scan);
            filtered.push(p);
        }
        // Λ before the measurements of scan k, from those of `from` scans on.
        let back = |k: usize, mut big: M<N>| {
            for (c, information) in said[k].iter().rev() {
                big = information + c.transpose() * big * c;
            }
            let f = &self.steps[k - 1].0;
            f.transpose() * big * f
        };
        let n = filtered.len();
        let reduced = |k: usize, big: &M<N>| filtered[k] - filtered[k] * big * filtered[k];
        let lagged = (0..n - 1).map(|k| reduced(k, &back(k + 1, M::<N>::zeros()))).collect();
        let mut smoothed = vec![filtered[n - 1]];
        let mut big = M::<N>::zeros();
        for k in (0..n - 1).rev() {
            big = back(k + 1, big);
            smoothed.push(reduced(k, &big));
        }
        smoothed.reverse();
        Covariances { filtered, lagged, smoothed }
    }
}

/// Transition and noise over one scan of `axes` axes of (position, velocity, acceleration), re-opened
/// at the switches that fall into it.
fn scan<const N: usize>(
    from: f64,
    switches: &[Switch],
    legs_known: bool,
    speed_known: bool,
) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    let mut f = SMatrix::<f64, N, N>::identity();
    let mut q = SMatrix::<f64, N, N>::zeros();
    let mut at = from;
    let advance = |f: &mut SMatrix<f64, N, N>, q: &mut SMatrix<f64, N, N>, t: f64| {
        let mut phi = SMatrix::<f64, N, N>::identity();
        for b in (0..N).step_by(3) {
            (phi[(b, b + 1)], phi[(b, b + 2)], phi[(b + 1, b + 2)]) = (t, 0.5 * t * t, t);
        }
        *f = phi * *f;
        *q = phi * *q * phi.transpose();
    };
    for switch in switches.iter().filter(|s| s.time_s > from && s.time_s <= from + 1.0) {
        advance(&mut f, &mut q, switch.time_s - at);
        at = switch.time_s;
        let mut keep = SMatrix::<f64, N, N>::identity();
        let mut fresh = SMatrix::<f64, N, N>::zeros();
        for b in (0..N).step_by(3) {
            keep[(b + 2, b + 2)] = 0.0;
            let steady = legs_known && switch.steady;
            fresh[(b + 2, b + 2)] = if steady { 0.0 } else { SIGMA_A * SIGMA_A };
            if switch.corner && !speed_known {
                keep[(b + 1, b + 1)] = 0.0;
                fresh[(b + 1, b + 1)] = SIGMA_V * SIGMA_V;
            }
        }
        f = keep * f;
        q = keep * q * keep.transpose() + fresh;
    }
    advance(&mut f, &mut q, from + 1.0 - at);
    (f, q)
}

fn first_steady(scene: &Scene) -> bool {
    scene.legs.first().is_some_and(|l| l.acceleration_ms2 == 0.0 && l.curvature == 0.0)
}

fn plane(scene: &Scene, noise: &Noise, legs_known: bool) -> Covariances<6> {
    let switches = switches(scene, false);
    let measured: Vec<Vec<(SVector<f64, 6>, f64)>> = (0..scene.samples)
        .map(|k| {
            let plot = plot(scene.at(k as f64).position_m, noise, [0.0; 2], k);
            let row = |u: Vector2<f64>| SVector::<f64, 6>::from([u.x, 0.0, 0.0, u.y, 0.0, 0.0]);
            vec![(row(plot.axis), plot.along_m2), (row(plot.across_axis()), plot.across_m2)]
        })
        .collect();
    let aa = if legs_known && first_steady(scene) { 0.0 } else { SIGMA_A * SIGMA_A };
    let vv = SIGMA_V * SIGMA_V;
    let prior = SMatrix::from_diagonal(&SVector::<f64, 6>::from([1e8, vv, aa, 1e8, vv, aa]));
    let steps = (1..scene.samples).map(|k| scan::<6>((k - 1) as f64, &switches, legs_known, false));
    Model { prior, steps: steps.collect(), measured }.covariances()
}

fn along(scene: &Scene, noise: &Noise) -> Covariances<3> {
    let switches = switches(scene, true);
    let measured: Vec<Vec<(SVector<f64, 3>, f64)>> = (0..scene.samples)
        .map(|k| {
            let at = scene.at(k as f64);
            let plot = plot(at.position_m, noise, [0.0; 2], k);
            let u = Vector2::new(libm::cos(at.course_rad), libm::sin(at.course_rad));
            let (a, c) = (plot.axis.dot(&u), plot.across_axis().dot(&u));
            let information = a * a / plot.along_m2 + c * c / plot.across_m2;
            vec![(SVector::<f64, 3>::from([1.0, 0.0, 0.0]), 1.0 / information)]
        })
        .collect();
    let prior = SMatrix::from_diagonal(&SVector::<f64, 3>::from([
        1e8,
        SIGMA_V * SIGMA_V,
        if first_steady(scene) { 0.0 } else { SIGMA_A * SIGMA_A },
    ]));
    let steps = (1..scene.samples).map(|k| scan::<3>((k - 1) as f64, &switches, true, true));
    Model { prior, steps: steps.collect(), measured }.covariances()
}

/// The bounds of a scene at one noise level.
pub(crate) fn of(scene: &Scene, noise: &Noise, skip: usize) -> Bounds {
    let plane_mse = |p: &[SMatrix<f64, 6, 6>]| {
        let from = &p[skip.min(p.len() - 1)..];
        from.iter().map(|p| p[(0, 0)] + p[(3, 3)]).sum::<f64>() / from.len() as f64
    };
    let told = plane(scene, noise, false);
    let legs = plane(scene, noise, true);
    let along = along(scene, noise).filtered;
    let along = &along[skip..];
    Bounds {
        switches: plane_mse(&told.filtered),
        legs: plane_mse(&legs.filtered),
        legs_lag: plane_mse(&legs.lagged),
        map: along.iter().map(|p| p[(0, 0)]).sum::<f64>() / along.len() as f64,
        smoother: plane_mse(&told.smoothed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::NoiseLevel;

    #[test]
    fn bounds_stand_where_an_independent_computation_put_them() {
        // Reduction of the mean squared error, %, from a second implementation in another language.
        let cell = NoiseLevel::all()[0].noise;
        let scenes = [Scene::landing(), Scene::takeoff()];
        let expected = [
            ("switch times", [53.0, 58.0]),
            ("legs", [64.0, 58.0]),
            ("lag", [80.0, 76.0]),
            ("map", [86.0, 77.0]),
            ("smoother", [92.0, 93.0]),
        ];
        for (number, scene) in scenes.iter().enumerate() {
            let b = of(scene, &cell, 3);
            let n = scene.samples as f64 - 3.0;
            let raw: f64 = (3..scene.samples)
                .map(|k| plot(scene.at(k as f64).position_m, &cell, [0.0; 2], k))
                .map(|p| p.along_m2 + p.across_m2)
                .sum::<f64>()
                / n;
            let found = [b.switches, b.legs, b.legs_lag, b.map, b.smoother];
            for ((name, expected), mse) in expected.iter().zip(found) {
                let reduction = 100.0 * (1.0 - mse / raw);
                println!("{} {name}: {reduction:.2} ({})", scene.name, expected[number]);
                assert!(
                    (reduction - expected[number]).abs() < 1.5,
                    "{} {name}: {reduction}",
                    scene.name
                );
            }
        }
    }

    #[test]
    fn who_is_told_more_can_do_better() {
        for scene in Scene::reported() {
            for level in NoiseLevel::all() {
                let b = of(&scene, &level.noise, 3);
                assert!(b.legs <= b.switches && b.legs_lag < b.legs, "{}: {b:?}", scene.name);
                assert!(b.map < b.legs && b.smoother < b.switches, "{}: {b:?}", scene.name);
            }
        }
    }
}
