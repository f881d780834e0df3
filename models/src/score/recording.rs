//! What was true and what was reported, as it stands in a recording.

use super::robust::{FAR_OFF, quantile};
use crate::frames::{Point2, Vector2};
use crate::time::SimTime;

/// True state of a target at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthPoint {
    /// When.
    pub time: SimTime,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north.
    pub velocity_mps: Vector2<f64>,
    /// Height above the ground, m, where known.
    pub height_m: Option<f64>,
}

/// A target with its whole path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Target {
    /// Call sign or any other name; what a label has to say to be right.
    pub name: String,
    /// Its states in the order of time.
    pub path: Vec<TruthPoint>,
}

impl Target {
    /// The state at `time`: cubic between the two neighbours, none outside the path or in a hole of
    /// more than `hole_s`.
    #[must_use]
    pub fn at(&self, time: SimTime, hole_s: f64) -> Option<TruthPoint> {
        let after = self.path.partition_point(|p| p.time < time);
        let late = self.path.get(after)?;
        if late.time == time {
            return Some(*late);
        }
        let early = self.path.get(after.checked_sub(1)?)?;
        let step = late.time.since_s(early.time);
        if step > hole_s {
            return None;
        }
        // Hermite: positions and velocities of both ends are kept.
        let u = time.since_s(early.time) / step;
        let (p0, p1) = (early.position_m, late.position_m);
        let (v0, v1) = (early.velocity_mps * step, late.velocity_mps * step);
        let (bend, twist) = (p1 - p0 - v0, v1 - v0);
        let (c2, c3) = (3.0 * bend - twist, twist - 2.0 * bend);
        let height_m = early.height_m.zip(late.height_m).map(|(a, b)| a + u * (b - a));
        Some(TruthPoint {
            time,
            position_m: p0 + v0 * u + c2 * (u * u) + c3 * (u * u * u),
            velocity_mps: (v0 + c2 * (2.0 * u) + c3 * (3.0 * u * u)) / step,
            height_m,
        })
    }
}

/// One report of a track.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of the track.
    pub track: u64,
    /// Time of validity.
    pub time: SimTime,
    /// When it was published, where known.
    pub published: Option<SimTime>,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north, where the track has one.
    pub velocity_mps: Option<Vector2<f64>>,
    /// Its label; empty for none.
    pub label: String,
}

/// Plots in sum, for the gain of tracking over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlotSum {
    /// Plots with a target.
    pub count: u64,
    /// Sum of their squared position errors, m².
    pub squares_m2: f64,
    /// Plots that were left out, and are in neither.
    pub left_out: u64,
    /// From this error on, m; infinite where none was left out.
    pub limit_m: f64,
    /// The largest error that was left out, m.
    pub farthest_m: f64,
}

impl PlotSum {
    /// Sums position errors (m); those that are no errors of measurement are left out and counted: an echo of a
    /// pulse before the last stands kilometres nearer, and three of these decide the mean square of ten thousand
    /// plots. Errors that are not finite or negative are not plots with a target.
    ///
    /// Of 1000 errors any three change the root mean square by 5 % at most, however far off they are.
    #[must_use]
    pub fn of(mut errors_m: Vec<f64>) -> Self {
        errors_m.retain(|e| e.is_finite() && *e >= 0.0);
        errors_m.sort_by(f64::total_cmp);
        let limit_m = quantile(&errors_m, 0.95).map_or(f64::INFINITY, |q| FAR_OFF * q);
        let kept = errors_m.partition_point(|e| *e <= limit_m);
        let (near, far) = errors_m.split_at(kept);
        Self {
            count: near.len() as u64,
            squares_m2: near.iter().map(|e| e * e).sum(),
            left_out: far.len() as u64,
            limit_m: if far.is_empty() { f64::INFINITY } else { limit_m },
            farthest_m: far.last().copied().unwrap_or(0.0),
        }
    }

    /// Root mean square of the errors, m.
    #[must_use]
    pub fn rmse_m(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares_m2 / self.count as f64).sqrt())
    }
}

/// A run: what was true, and what was reported of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// The targets.
    pub targets: Vec<Target>,
    /// The reports, sorted by time, then track.
    pub reports: Vec<Report>,
    /// The radars' plots.
    pub plots: PlotSum,
}

impl Recording {
    /// Sorts paths and reports and leaves out what is no place or velocity on earth (not finite, or beyond
    /// 10⁸ m or m/s, whose squares and differences would not be finite), and all but one state of a target at the same
    /// time (two targets of one name); gives how many were left out.
    pub fn put_in_order(&mut self) -> usize {
        let finite = |v: &Vector2<f64>| v.iter().all(|x| x.abs() < 1e8);
        let mut left_out = 0;
        for target in &mut self.targets {
            let before = target.path.len();
            target.path.retain(|p| finite(&p.position_m.coords) && finite(&p.velocity_mps));
            target.path.sort_by_key(|p| p.time);
            target.path.dedup_by_key(|p| p.time);
            left_out += before - target.path.len();
        }
        let before = self.reports.len();
        self.reports.retain(|r| finite(&r.position_m.coords));
        for report in &mut self.reports {
            report.velocity_mps = report.velocity_mps.filter(finite);
        }
        self.reports.sort_by_key(|r| (r.time, r.track));
        left_out + before - self.reports.len()
    }
}

/// Velocities by central differences, for paths that were recorded without.
pub fn differentiate(path: &mut [TruthPoint]) {
    let states: Vec<(SimTime, Point2<f64>)> = path.iter().map(|p| (p.time, p.position_m)).collect();
    for (k, point) in path.iter_mut().enumerate() {
        let (a, b) = (states[k.saturating_sub(1)], states[(k + 1).min(states.len() - 1)]);
        let span = b.0.since_s(a.0);
        point.velocity_mps = if span > 0.0 { (b.1 - a.1) / span } else { Vector2::zeros() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parabola(s: f64) -> TruthPoint {
        TruthPoint {
            time: SimTime::from_s(s),
            position_m: Point2::new(s * s, 3.0 * s),
            velocity_mps: Vector2::new(2.0 * s, 3.0),
            height_m: Some(s),
        }
    }

    #[test]
    fn constant_acceleration_is_interpolated_exactly_and_holes_stay_holes() {
        let target = Target { name: "A".into(), path: [0.0, 1.0, 2.0, 9.0].map(parabola).to_vec() };
        let between = target.at(SimTime::from_s(1.25), 2.0).expect("inside");
        let exact = parabola(1.25);
        assert!((between.position_m - exact.position_m).norm() < 1e-12);
        assert!((between.velocity_mps - exact.velocity_mps).norm() < 1e-12);
        assert_eq!(between.height_m, Some(1.25));
        assert_eq!(target.at(SimTime::from_s(2.0), 2.0), Some(parabola(2.0)));
        for outside in [-0.1, 5.0, 9.1] {
            assert_eq!(target.at(SimTime::from_s(outside), 2.0), None, "{outside}");
        }
        assert_eq!(Target::default().at(SimTime::ZERO, 2.0), None);
    }

    #[test]
    fn every_row_that_is_left_out_is_counted() {
        // Two targets of one name: at each time one of the two states stays.
        let path: Vec<TruthPoint> = [0.0, 0.0, 1.0, 1.0, 2.0].map(parabola).to_vec();
        let target = Target { name: "A".into(), path };
        let mut recording = Recording { targets: vec![target], ..Recording::default() };
        assert_eq!(recording.put_in_order(), 2);
        assert_eq!(recording.targets[0].path.len(), 3);
    }

    /// 1000 errors of a circular normal measurement of several qualities, as targets near and far have.
    fn plots(seed: u64) -> Vec<f64> {
        use crate::draw::{DrawKey, Purpose, normal_pair};
        let key = DrawKey { run_seed: seed, sensor: 0, entity: 0, scan: 0 };
        let mut rng = key.rng(Purpose::Study);
        let error = |k: u32| {
            let (a, b) = normal_pair(&mut rng);
            [0.6, 2.0, 4.0][k as usize % 3] * libm::hypot(a, b)
        };
        (0..1000).map(error).collect()
    }

    #[test]
    fn three_echoes_of_a_pulse_before_the_last_do_not_decide_the_error_of_a_thousand_plots() {
        for seed in 0..40 {
            let honest = PlotSum::of(plots(seed));
            let rms = honest.rmse_m().expect("plots");
            assert_eq!(honest.left_out, 0, "seed {seed}: no error of measurement is left out");
            // As far as a pulse goes between two, and the worst place for a test of this kind: just inside.
            let limit = FAR_OFF * quantile(&plots_sorted(seed), 0.95).expect("plots");
            for far_m in [7_495.0, 300.0, 61.0, 0.999 * limit, 1.3 * limit] {
                let mut with = plots(seed);
                with.extend([far_m; 3]);
                let found = PlotSum::of(with);
                let change = found.rmse_m().expect("plots") / rms - 1.0;
                assert!(change.abs() <= 0.05, "seed {seed}: {far_m} m changes {change}");
                if far_m > 1.2 * limit {
                    assert_eq!((found.left_out, found.farthest_m), (3, far_m));
                }
            }
        }
        assert_eq!(PlotSum::of(vec![f64::NAN, f64::INFINITY, -1.0]).rmse_m(), None);
    }

    fn plots_sorted(seed: u64) -> Vec<f64> {
        let mut sorted = plots(seed);
        sorted.sort_by(f64::total_cmp);
        sorted
    }

    #[test]
    fn differences_find_the_velocity() {
        let mut path = [0.0, 1.0, 2.0, 3.0].map(parabola);
        path.iter_mut().for_each(|p| p.velocity_mps = Vector2::zeros());
        differentiate(&mut path);
        assert!((path[1].velocity_mps - parabola(1.0).velocity_mps).norm() < 1e-12);
        differentiate(&mut path[..1]);
        assert_eq!(path[0].velocity_mps, Vector2::zeros());
    }
}
