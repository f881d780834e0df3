//! A copy of the position taken at one moment, as two more numbers of the state that nothing drives: later plots revise it
//! with everything that ties it to them, slow errors and modes included.
//!
//! Source: fixed-point smoothing by augmentation, Anderson and Moore, *Optimal Filtering* (1979), ch. 7.2.

use super::{Consider, MOTION, Slow};
use crate::filter::UpdateError;
use crate::frames::{Matrix2, Point2, Vector2};
use crate::time::SimTime;

/// East and north of the position in the state.
const POSITION: [usize; 2] = [0, MOTION / 2];

impl Consider {
    /// The filter carried on to `time`, with a copy of its position there beside the state.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    pub fn copied(&self, time: SimTime) -> Result<Self, UpdateError> {
        let mut next = self.clone();
        next.parts = self.branches(time, false)?;
        next.time = time;
        let n = next.size();
        let m = n + POSITION.len();
        let old = |i: usize| if i < n { i } else { POSITION[i - n] };
        for part in &mut next.parts {
            part.p = (0..m * m).map(|k| part.p[n * old(k / m) + old(k % m)]).collect();
            part.x.extend(POSITION.map(|k| part.x[k]));
        }
        let tau_s = f64::INFINITY;
        next.slow.push(Slow {
            sensor: None,
            delay: false,
            tau_s,
            at: n,
            directions: POSITION.len(),
        });
        Ok(next)
    }

    /// The copied position (m) as it is known now, and its covariance (m²); nothing where none was taken.
    #[must_use]
    pub fn copy(&self) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let at = self.slow.iter().find(|s| s.sensor.is_none())?.at;
        let own = |x: &[f64]| Vector2::new(x[at], x[at + 1]);
        let mean: Vector2<f64> = self.parts.iter().map(|p| own(&p.x) * p.weight).sum();
        let mut cov = Matrix2::zeros();
        for part in &self.parts {
            let (n, off) = (part.x.len(), own(&part.x) - mean);
            let p = Matrix2::from_fn(|i, j| part.p[n * (at + i) + at + j]);
            cov += (p + off * off.transpose()) * part.weight;
        }
        let sound = cov.iter().chain(mean.iter()).all(|v| v.is_finite());
        (sound && cov[(0, 0)] > 0.0 && cov.determinant() > 0.0).then(|| (Point2::from(mean), cov))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{model, one_mode, report, start};
    use super::*;
    use crate::filter::Estimate;
    use crate::filter::fixed_lag::FixedLag;
    use crate::filter::motion::Motion;
    use crate::filter::{Gaussian, Measurement};

    /// Of one mode and white errors it is the recursion with the covariance to the state.
    #[test]
    fn of_one_mode_and_white_errors_it_is_the_copy_of_a_single_gaussian() {
        let begin = Estimate::new(SimTime::ZERO, start(4.0));
        let mut with_copy = Consider::from_estimate(&begin, &one_mode(0.3))
            .copied(SimTime::from_s(0.3))
            .expect("later");
        let motion = Motion::ConstantAcceleration { q: 0.3 };
        let mut state: Gaussian = begin.state.predicted(&motion.step(0.3));
        let mut lag = FixedLag::<2>::of(&state, [0, 3]);
        let mut now_s = 0.3;
        for k in 1..6 {
            let t = 0.8 * f64::from(k);
            let plot = report(t, Point2::new(3.0 * t, t * t), 2.0);
            with_copy.update(&plot, model(0.0), false).expect("sound");
            lag.predict(t - now_s, true);
            state = state.predicted(&motion.step(t - now_s));
            let s = state.position_cov().matrix() + plot.covariance_m2();
            let inverse = s.try_inverse().expect("positive");
            let nu = plot.position_m - state.position();
            lag.take(&state, inverse, 1.0, nu, Matrix2::zeros());
            state.update(&Measurement::of(&plot).expect("sound")).expect("sound");
            now_s = t;
            let (position, cov) = with_copy.copy().expect("taken");
            assert!((position.coords - lag.value).norm() < 1e-9, "{position} {}", lag.value);
            assert!((cov - lag.covariance).norm() < 1e-9, "{cov} {}", lag.covariance);
        }
        assert!((with_copy.estimate().position_m() - state.position()).norm() < 1e-9);
    }

    /// Modes that say different things of the past are not agreed: how far they are apart is part of what is stated.
    #[test]
    fn what_modes_say_differently_of_the_past_is_in_its_covariance() {
        let config = crate::filter::FilterConfig::new(crate::filter::Rung::Imm3);
        let mut filter =
            Consider::from_estimate(&Estimate::new(SimTime::ZERO, start(4.0)), &config);
        for k in 1..20 {
            let t = f64::from(k);
            let plot = report(t, Point2::new(3.0 * t, 0.0), 4.0);
            filter.update(&plot, model(0.0), false).expect("sound");
        }
        let mut copied = filter.copied(SimTime::from_s(20.0)).expect("later");
        // It is 9 m aside: who keeps straight on says that it was there all the time, who jumps that it came there just now.
        let aside = report(20.8, Point2::new(62.4, 9.0), 4.0);
        copied.update(&aside, model(0.0), false).expect("sound");
        let at = copied.slow.iter().find(|s| s.sensor.is_none()).expect("taken").at;
        let (mean, cov) = copied.copy().expect("sound");
        let (mut first, mut second, mut within) = (0.0, 0.0, 0.0);
        for part in &copied.parts {
            let (n, y) = (part.x.len(), part.x[at + 1]);
            let own = part.p[n * (at + 1) + at + 1];
            first += part.weight * y;
            second += part.weight * (y * y + own);
            within += part.weight * own;
        }
        println!("{first:.3} m, {cov}, within the modes {within:.3} m²");
        assert!((mean.y - first).abs() < 1e-9);
        assert!((cov[(1, 1)] - (second - first * first)).abs() < 1e-9);
        assert!(cov[(1, 1)] > 1.02 * within, "{cov} {within}");
    }
}
