//! Slow errors respected: a filter that knows that part of a sensor's error stays from plot to plot.
//!
//! `z = Hx + Jb + v` with `b` a Gauss–Markov process of unit variance (ρ = e^{−T/τ}) for each sensor. `b`
//! is not estimated, but its covariance with the state, `C = cov(x, b)`, is carried along, so that the
//! filter neither averages a slow error away on paper nor throws away what its differences tell of
//! the velocity. Source: S. F. Schmidt 1966; Bar-Shalom, Li, Kirubarajan 2001, ch. 11.

use super::config::SensorModel;
use crate::filter::lanes::Pair;
use crate::filter::motion::{Motion, Step};
use crate::filter::{Estimate, Gaussian, Measurement, Nis, UpdateError};
use crate::frames::{Matrix2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;
use nalgebra::{Matrix6, Matrix6x2, Vector6};

/// Constant acceleration on both axes with the slow errors of the sensors that have updated it.
#[derive(Clone, Debug)]
pub struct Consider {
    time: SimTime,
    x: Vector6<f64>,
    p: Matrix6<f64>,
    /// One entry for each sensor with a slow error, in the order of first use.
    slow: Vec<Slow>,
    q: f64,
}

#[derive(Clone, Copy, Debug)]
struct Slow {
    sensor: SensorId,
    tau_s: f64,
    /// cov(x, b), b of unit variance along the plot's two axes.
    c: Matrix6x2<f64>,
}

/// One plot against the state predicted to its time.
struct Look {
    nu: Vector2<f64>,
    s: Matrix2<f64>,
    inverse: Matrix2<f64>,
    /// `P Hᵀ + C Jᵀ`
    m: Matrix6x2<f64>,
    j: Matrix2<f64>,
}

impl Consider {
    /// Goes on from a state that knows nothing of slow errors.
    #[must_use]
    pub fn from_estimate(estimate: &Estimate, q: f64) -> Self {
        let g = &estimate.state;
        let x = Vector6::new(
            g.x[0].east(),
            g.x[1].east(),
            g.x[2].east(),
            g.x[0].north(),
            g.x[1].north(),
            g.x[2].north(),
        );
        Self { time: estimate.time, x, p: g.covariance(), slow: Vec::new(), q }
    }

    /// Time of the state.
    #[must_use]
    pub fn time(&self) -> SimTime {
        self.time
    }

    /// The state with its covariance, slow errors included.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let (x, p) = (&self.x, &self.p);
        let pair = |i: usize, j: usize| Pair::new(p[(i, j)], p[(3 + i, 3 + j)]);
        let mut cross = [0.0; 9];
        for (k, slot) in cross.iter_mut().enumerate() {
            *slot = p[(k / 3, 3 + k % 3)];
        }
        let state = Gaussian {
            x: [Pair::new(x[0], x[3]), Pair::new(x[1], x[4]), Pair::new(x[2], x[5])],
            p: [pair(0, 0), pair(0, 1), pair(0, 2), pair(1, 1), pair(1, 2), pair(2, 2)],
            cross,
        };
        Estimate::new(self.time, state)
    }

    /// Forgets what tied it to slow errors and takes this state.
    pub fn replace(&mut self, time: SimTime, state: &Gaussian) {
        *self = Self::from_estimate(&Estimate::new(time, *state), self.q);
    }

    /// The state at `time`, not before the present one.
    ///
    /// # Errors
    /// If `time` is before the state's.
    pub fn predicted(&self, time: SimTime) -> Result<Self, UpdateError> {
        let t = time.since_s(self.time);
        if t < 0.0 {
            return Err(UpdateError::BackInTime(-t));
        }
        let Step { f02, f12, f22, q, .. } = Motion::ConstantAcceleration { q: self.q }.step(t);
        let mut phi = Matrix6::identity();
        let mut noise = Matrix6::zeros();
        for b in [0, 3] {
            (phi[(b, b + 1)], phi[(b, b + 2)], phi[(b + 1, b + 2)]) = (t, f02, f12);
            phi[(b + 2, b + 2)] = f22;
            for (k, (i, j)) in
                [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
            {
                noise[(b + i, b + j)] = q[k];
                noise[(b + j, b + i)] = q[k];
            }
        }
        let mut next = self.clone();
        next.time = time;
        next.x = phi * self.x;
        next.p = symmetric(phi * self.p * phi.transpose() + noise);
        for slow in &mut next.slow {
            slow.c = phi * slow.c * libm::exp(-t / slow.tau_s);
        }
        Ok(next)
    }

    /// The normalised innovation of a plot at this state's time.
    ///
    /// # Errors
    /// If the plot is unsound or the innovation covariance not positive definite.
    pub fn nis(&self, plot: &Plot, model: &SensorModel) -> Result<Nis, UpdateError> {
        let look = self.look(plot, model)?;
        let d2 = look.nu.dot(&(look.inverse * look.nu));
        Ok(Nis { d2, det: look.s.determinant(), dof: 2 })
    }

    /// Predicts to the plot's time and takes it.
    ///
    /// `S = HPHᵀ + HCJᵀ + JCᵀHᵀ + JJᵀ + R`, `K = (PHᵀ + CJᵀ)S⁻¹`, `P ← P − KSKᵀ`, `C ← C − K(HC + J)`;
    /// the slow errors of other sensors: `C ← C − KHC`.
    ///
    /// # Errors
    /// If the plot is late or unsound or a covariance not positive definite; nothing is changed then.
    pub fn update(&mut self, plot: &Plot, model: &SensorModel) -> Result<(), UpdateError> {
        let mut next = self.predicted(plot.time)?;
        let look = next.look(plot, model)?;
        let k = look.m * look.inverse;
        next.x += k * look.nu;
        next.p = symmetric(next.p - k * look.s * k.transpose());
        if model.slow_share > 0.0 && !next.slow.iter().any(|s| s.sensor == plot.sensor) {
            let c = Matrix6x2::zeros();
            next.slow.push(Slow { sensor: plot.sensor, tau_s: model.slow_tau_s.max(1e-3), c });
        }
        for slow in &mut next.slow {
            let mut hc = rows_03(&slow.c);
            if slow.sensor == plot.sensor {
                hc += look.j;
            }
            slow.c -= k * hc;
        }
        let sound = next.x.iter().all(|v| v.is_finite())
            && next.p.iter().all(|v| v.is_finite())
            && (0..6).all(|i| next.p[(i, i)] >= 0.0)
            && next.p[(0, 0)] > 0.0
            && next.p[(3, 3)] > 0.0;
        if !sound {
            return Err(UpdateError::BadCovariance);
        }
        *self = next;
        Ok(())
    }

    fn look(&self, plot: &Plot, model: &SensorModel) -> Result<Look, UpdateError> {
        let Measurement::Position { z, .. } = Measurement::of(plot)? else {
            return Err(UpdateError::UnsoundPlot);
        };
        let share = model.slow_share.clamp(0.0, 1.0);
        let across = plot.across_axis();
        let white = (1.0 - share).max(LEAST_WHITE_SHARE);
        let r = (plot.axis * plot.axis.transpose() * plot.along_m2
            + across * across.transpose() * plot.across_m2)
            * white;
        let j = Matrix2::from_columns(&[
            plot.axis * (share * plot.along_m2).sqrt(),
            across * (share * plot.across_m2).sqrt(),
        ]);
        let c = self.slow.iter().find(|s| s.sensor == plot.sensor).map(|s| s.c);
        let c = c.unwrap_or_else(Matrix6x2::zeros);
        let ph = Matrix6x2::from_columns(&[self.p.column(0), self.p.column(3)]);
        let m = ph + c * j.transpose();
        let hcj = rows_03(&c) * j.transpose();
        let s = rows_03(&ph) + hcj + hcj.transpose() + j * j.transpose() + r;
        let det = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(1, 0)];
        if !(s[(0, 0)] > 0.0 && det > 0.0 && det.is_finite()) {
            return Err(UpdateError::BadInnovation(det));
        }
        let inverse = Matrix2::new(s[(1, 1)], -s[(0, 1)], -s[(1, 0)], s[(0, 0)]) / det;
        Ok(Look { nu: z - Vector2::new(self.x[0], self.x[3]), s, inverse, m, j })
    }
}

/// Some white error is always assumed, or repeated reports would make the position exact on paper.
const LEAST_WHITE_SHARE: f64 = 1e-3;

fn rows_03(m: &Matrix6x2<f64>) -> Matrix2<f64> {
    Matrix2::new(m[(0, 0)], m[(0, 1)], m[(3, 0)], m[(3, 1)])
}

fn symmetric(m: Matrix6<f64>) -> Matrix6<f64> {
    (m + m.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, normal_pair};
    use crate::filter::consistency::position_nees;
    use crate::plot::SensorKind;

    fn report(t_s: f64, position_m: Vector2<f64>, variance: f64) -> Plot {
        Plot {
            sensor: SensorId(2),
            kind: SensorKind::Gps,
            time: SimTime::from_s(t_s),
            sequence: 0,
            position_m,
            axis: Vector2::new(0.0, 1.0),
            along_m2: variance,
            across_m2: variance,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    }

    fn model(share: f64) -> SensorModel {
        let base = SensorModel::default_of(SensorId(2), SensorKind::Gps);
        SensorModel { slow_share: share, slow_tau_s: 300.0, ..base }
    }

    /// Jerk density of the target, m²/s⁵.
    const Q: f64 = 1e-4;

    fn start(variance: f64) -> Gaussian {
        let r = crate::filter::gaussian::Sym2 { xx: variance, xy: 0.0, yy: variance };
        Gaussian::at_position(Vector2::zeros(), r, 5.0, 1.0)
    }

    /// Mean NEES and claimed variance of a receiver that moves at 5 m/s, 200 runs of 200 s.
    fn run(share_assumed: f64) -> (f64, f64, f64) {
        let (share, tau) = (0.99f64, 300.0f64);
        let rho = libm::exp(-1.0 / tau);
        let (mut nees, mut claimed, mut velocity2) = (0.0, 0.0, 0.0);
        let runs = 200;
        for run in 0..runs {
            let mut rng =
                DrawKey { run_seed: run, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
            let draw = |rng: &mut _| {
                let (a, b) = normal_pair(rng);
                Vector2::new(a, b)
            };
            let mut slow = draw(&mut rng);
            let mut truth = Vector2::zeros();
            let (mut velocity, mut acceleration) = (Vector2::new(5.0, 0.0), Vector2::zeros());
            let mut filter = Consider::from_estimate(&Estimate::new(SimTime::ZERO, start(1e6)), Q);
            for k in 1..=200 {
                slow = slow * rho + draw(&mut rng) * (1.0 - rho * rho).sqrt();
                // White jerk of the density that the filter assumes, in ten steps a second.
                for _ in 0..10 {
                    acceleration += draw(&mut rng) * (Q * 0.1).sqrt();
                    velocity += acceleration * 0.1;
                    truth += velocity * 0.1;
                }
                let error = slow * share.sqrt() + draw(&mut rng) * (1.0 - share).sqrt();
                filter
                    .update(&report(f64::from(k), truth + error, 1.0), &model(share_assumed))
                    .expect("sound");
            }
            let estimate = filter.estimate();
            nees += position_nees(&estimate, truth);
            claimed += estimate.position_cov_m2().trace() / 2.0;
            velocity2 += (estimate.velocity_ms() - velocity).norm_squared() / 2.0;
        }
        let n = runs as f64;
        (nees / n, claimed / n, (velocity2 / n).sqrt())
    }

    #[test]
    fn a_slow_error_is_not_averaged_away_on_paper() {
        let (white, white_claim, white_velocity) = run(0.0);
        let (honest, claim, velocity) = run(0.99);
        println!(
            "taken as white: NEES {white:.2}, claims {white_claim:.2} m², velocity {white_velocity:.3}"
        );
        println!("considered: NEES {honest:.2}, claims {claim:.2} m², velocity {velocity:.3} m/s");
        assert!(white > 4.0, "optimistic: {white}");
        // 200 runs: 95 % bounds of the mean are 1.73 to 2.29.
        assert!((1.6..2.4).contains(&honest), "{honest}");
        assert!((0.9..1.1).contains(&claim), "{claim}");
        assert!(velocity < 0.75 * white_velocity, "{velocity} {white_velocity}");
    }

    #[test]
    fn without_a_slow_share_it_is_the_six_state_filter() {
        let mut consider = Consider::from_estimate(&Estimate::new(SimTime::ZERO, start(4.0)), 0.3);
        let mut plain = start(4.0);
        let mut before = SimTime::ZERO;
        for k in 1..=50 {
            let t = f64::from(k) * 0.7;
            let z = Vector2::new(t * t, 3.0 - t);
            let mut plot = report(t, z, 2.0);
            plot.axis = Vector2::new(0.6, 0.8);
            plot.across_m2 = 7.0;
            consider.update(&plot, &model(0.0)).expect("sound");
            let step = Motion::ConstantAcceleration { q: 0.3 }.step(plot.time.since_s(before));
            plain = plain.predicted(&step);
            plain.update(&Measurement::of(&plot).expect("sound")).expect("sound");
            before = plot.time;
        }
        let found = consider.estimate();
        assert!((found.position_m() - plain.position()).norm() < 1e-9);
        // The white share is never above what the plot says.
        assert!((found.state.covariance() - plain.covariance()).norm() < 1e-9);
    }
}
