//! Kalman filters of each axis by itself, both axes in one pass: constant acceleration (the paper's), and constant
//! velocity.

use super::gaussian::{Gaussian, Measurement, Nis, Sym2};
use super::lanes::{Lane, Pair};
use super::modes::Modes;
use super::{Declared, Estimator};
use super::{
    Estimate, SURPRISING_D2, Start, StateEstimator, UpdateError, UpdateError::BadInnovation,
    interval, measurements,
};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use std::marker::PhantomData;

/// How a target moves between plots, axis by axis.
pub trait AxisMotion: Copy + std::fmt::Debug + PartialEq {
    /// State (position, velocity, acceleration) and covariance (pp, pv, pa, vv, va, aa) after `t` seconds, `q` the
    /// density of the noise.
    fn predict(x: &[Pair; 3], p: &[Pair; 6], q: f64, t: f64) -> ([Pair; 3], [Pair; 6]);

    /// As much of a state as this motion knows.
    #[must_use]
    fn known(x: [Pair; 3], p: [Pair; 6]) -> ([Pair; 3], [Pair; 6]);
}

/// Constant acceleration with white jerk, `q` in m²/s⁵.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accelerating;

/// Constant velocity with white acceleration, `q` in m²/s³; the acceleration and its covariances are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling;

/// The paper's filter: position, velocity and acceleration.
pub type ThreeState = PerAxis<Accelerating>;

/// Position and velocity.
pub type TwoState = PerAxis<Rolling>;

impl AxisMotion for Accelerating {
    /// `Φ P Φᵀ + Q` multiplied out in powers of `t`, so that no sum waits long for another (the update's division
    /// waits for the first of them).
    #[inline(always)]
    fn predict(x: &[Pair; 3], p: &[Pair; 6], q: f64, t: f64) -> ([Pair; 3], [Pair; 6]) {
        let [a, b, c, e, f, g] = *p;
        let t = Pair::splat(t);
        let (ec, t2) = (e + c, t * t);
        let (t3, t4) = (t2 * t, t2 * t2);
        // What the jerk adds beside the acceleration's own variance.
        let jerk = t * q;
        let of = |k: f64, noise: f64| g * k + jerk * noise;
        let p = [
            ((a + (b + b) * t) + (ec * t2 + f * t3)) + t4 * of(1.0 / 4.0, 1.0 / 20.0),
            ((b + ec * t) + f * 1.5 * t2) + t3 * of(1.0 / 2.0, 1.0 / 8.0),
            (c + f * t) + t2 * of(1.0 / 2.0, 1.0 / 6.0),
            (e + (f + f) * t) + t2 * of(1.0, 1.0 / 3.0),
            f + t * of(1.0, 1.0 / 2.0),
            g + jerk,
        ];
        ([x[0] + (x[1] * t + x[2] * 0.5 * t2), x[1] + x[2] * t, x[2]], p)
    }

    #[inline(always)]
    fn known(x: [Pair; 3], p: [Pair; 6]) -> ([Pair; 3], [Pair; 6]) {
        (x, p)
    }
}

impl AxisMotion for Rolling {
    #[inline(always)]
    fn predict(x: &[Pair; 3], p: &[Pair; 6], q: f64, t: f64) -> ([Pair; 3], [Pair; 6]) {
        let [a, b, _, e, ..] = *p;
        let (t, zero) = (Pair::splat(t), Pair::default());
        let (t2, noise) = (t * t, t * q);
        let p = [
            (a + (b + b) * t) + (e + noise * (1.0 / 3.0)) * t2,
            (b + e * t) + noise * 0.5 * t,
            zero,
            e + noise,
            zero,
            zero,
        ];
        ([x[0] + x[1] * t, x[1], zero], p)
    }

    #[inline(always)]
    fn known(x: [Pair; 3], p: [Pair; 6]) -> ([Pair; 3], [Pair; 6]) {
        let zero = Pair::default();
        ([x[0], x[1], zero], [p[0], p[1], zero, p[3], zero, zero])
    }
}

/// Position, velocity and acceleration per axis, axes independent: only R_xx and R_yy are used.
///
/// Source: the paper, sec. 3.1 (n = 3, H = [1 0 0], Φ = [1 T T²/2; 0 1 T; 0 0 1]); process noise of
/// white jerk. The covariance is symmetric by storage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerAxis<M> {
    time: SimTime,
    x: [Pair; 3],
    p: [Pair; 6],
    /// Density of the noise.
    q: f64,
    start: Start,
    motion: PhantomData<M>,
}

/// An innovation squared beyond this is none.
const LARGEST_D2: f64 = 1e300;
/// Plots of one weighted update whose states are kept side by side.
const FEW: usize = 6;

impl<M: AxisMotion> PerAxis<M> {
    /// A filter with this state and covariance (pp, pv, pa, vv, va, aa) at `time`; `q` as its motion takes it.
    #[must_use]
    pub fn new(time: SimTime, x: [Pair; 3], p: [Pair; 6], q: f64, start: Start) -> Self {
        let (x, p) = M::known(x, p);
        Self { time, x, p, q, start, motion: PhantomData }
    }

    /// One plot: position measured, velocity and acceleration unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, q: f64, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let g = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        Ok(Self::new(plot.time, g.x, g.p, q, start))
    }

    /// State per axis: position, velocity, acceleration.
    #[must_use]
    pub fn state(&self) -> [Pair; 3] {
        self.x
    }

    /// Covariance per axis: pp, pv, pa, vv, va, aa.
    #[must_use]
    pub fn covariance(&self) -> [Pair; 6] {
        self.p
    }

    /// Prediction over `t` seconds.
    #[inline(always)]
    fn predict(&self, t: f64) -> ([Pair; 3], [Pair; 6]) {
        M::predict(&self.x, &self.p, self.q, t)
    }

    /// A plot along one direction: the joint update, of which the axes keep their own parts.
    #[cold]
    #[inline(never)]
    fn update_along(&mut self, plot: &Plot, line: &Measurement) -> Result<Nis, UpdateError> {
        let (x, p) = self.predict(interval(self.time, plot.time)?);
        let (x, p, nis) = along_a_line(x, p, line)?;
        (self.time, self.x, self.p) = (plot.time, x, p);
        Ok(nis)
    }

    /// Several plots of which one measures along one direction only, or more than a few.
    #[cold]
    #[inline(never)]
    fn update_weighted_jointly(
        &mut self,
        x: [Pair; 3],
        p: [Pair; 6],
        plots: &[(&Plot, f64)],
    ) -> Result<(), UpdateError> {
        let mut joint = Gaussian { x, p, cross: [0.0; 9] };
        joint.update_weighted(&measurements(plots)?)?;
        (self.time, self.x, self.p) = (plots[0].0.time, joint.x, joint.p);
        Ok(())
    }

    /// One scalar update of each axis with its own variance `r`, `H = [1 0 0]`.
    #[inline(always)]
    fn correct(
        x: [Pair; 3],
        p: [Pair; 6],
        z: Pair,
        r: Pair,
    ) -> Result<([Pair; 3], [Pair; 6], Nis), UpdateError> {
        let [a, b, c, e, f, g] = p;
        let s = a + r;
        // The squares do not wait for the division.
        let (bb, bc, cc) = (b * b, b * c, c * c);
        let i = s.recip();
        let nu = z - x[0];
        let y = nu * i;
        let d2 = nu * y;
        // The inverse of what is not finite and positive is neither.
        if (i.not_positive() | d2.not_below(Pair::splat(LARGEST_D2))).anywhere() {
            return Err(BadInnovation(s.east().min(s.north())));
        }
        let w = r * i; // 1 − k₀ without the subtraction
        let next = [a * w, b * w, c * w, e - bb * i, f - bc * i, g - cc * i];
        let nis = Nis { d2: d2.sum(), det: s.east() * s.north(), dof: 2 };
        Ok(([x[0] + a * y, x[1] + b * y, x[2] + c * y], next, nis))
    }
}

impl<M: AxisMotion> StateEstimator for PerAxis<M> {
    #[inline]
    fn time(&self) -> SimTime {
        self.time
    }

    #[inline]
    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, Gaussian { x: self.x, p: self.p, cross: [0.0; 9] })
    }

    #[inline]
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let (x, p) = self.predict(interval(self.time, time)?);
        Ok(Estimate::new(time, Gaussian { x, p, cross: [0.0; 9] }))
    }

    #[inline]
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        // What is not asked for is not computed: the compiler sees through the call.
        let (x, p) = self.predict(interval(self.time, time)?);
        let at = Point2::new(x[0].east(), x[0].north());
        Ok((at, Sym2 { xx: p[0].east(), xy: 0.0, yy: p[0].north() }))
    }

    #[inline]
    fn place_at(&self, time: SimTime) -> Result<Point2<f64>, UpdateError> {
        let t = interval(self.time, time)?;
        let x = &self.x;
        let at = x[0] + (x[1] * t + x[2] * 0.5 * (t * t));
        Ok(Point2::new(at.east(), at.north()))
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let [p, v, _] = self.x.map(Pair::array);
        (Point2::new(p[0], p[1]), Vector2::new(v[0], v[1]))
    }

    #[inline]
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let (z, r) = match Measurement::of(plot)? {
            Measurement::Position { z, r } => (Pair::new(z.x, z.y), Pair::new(r.xx, r.yy)),
            line @ Measurement::Line { .. } => return self.update_along(plot, &line),
        };
        let (x, p) = self.predict(interval(self.time, plot.time)?);
        let (x, p, nis) = Self::correct(x, p, z, r)?;
        (self.time, self.x, self.p) = (plot.time, x, p);
        Ok(nis)
    }

    #[inline]
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let (z, r) = match Measurement::of(plot)? {
            Measurement::Position { z, r } => (Pair::new(z.x, z.y), Pair::new(r.xx, r.yy)),
            line @ Measurement::Line { .. } => return self.update_along(plot, &line),
        };
        let (x, p) = self.predict(interval(self.time, plot.time)?);
        let (x, p, nis) = Self::correct(x, p, z, r)?;
        if nis.d2 > SURPRISING_D2 {
            return self.update_manoeuvre(plot);
        }
        (self.time, self.x, self.p) = (plot.time, x, p);
        Ok(nis)
    }

    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let (x, p) = self.predict(interval(self.time, first.time)?);
        let mut means = [x; FEW];
        let missed = (1.0 - plots.iter().map(|plot| plot.1).sum::<f64>()).max(0.0);
        let (mut mean, mut sum) = (x.map(|x| x * missed), p.map(|p| p * missed));
        for (k, (plot, beta)) in plots.iter().enumerate() {
            let measured = Measurement::of(plot)?;
            let (Measurement::Position { z, r }, true) = (measured, plots.len() <= FEW) else {
                return self.update_weighted_jointly(x, p, plots);
            };
            let (z, r) = (Pair::new(z.x, z.y), Pair::new(r.xx, r.yy));
            let (own, cov, _) = Self::correct(x, p, z, r)?;
            mean.iter_mut().zip(own).for_each(|(mean, own)| *mean = *mean + own * *beta);
            sum.iter_mut().zip(cov).for_each(|(sum, cov)| *sum = *sum + cov * *beta);
            means[k] = own;
        }
        let parts = means.iter().zip(plots.iter().map(|plot| plot.1));
        for (own, weight) in parts.chain([(&x, missed)]) {
            let d: [Pair; 3] = std::array::from_fn(|i| own[i] - mean[i]);
            let s = d.map(|d| d * weight);
            let outer =
                [s[0] * d[0], s[0] * d[1], s[0] * d[2], s[1] * d[1], s[1] * d[2], s[2] * d[2]];
            sum.iter_mut().zip(outer).for_each(|(sum, outer)| *sum = *sum + outer);
        }
        (self.time, self.x, self.p) = (first.time, mean, sum);
        Ok(())
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.time = time;
        (self.x, self.p) = M::known(state.x, state.p);
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// A plot along one direction: the joint update, of which the axes keep their own parts.
pub(super) fn along_a_line(
    x: [Pair; 3],
    p: [Pair; 6],
    line: &Measurement,
) -> Result<([Pair; 3], [Pair; 6], Nis), UpdateError> {
    let mut joint = Gaussian { x, p, cross: [0.0; 9] };
    let nis = joint.update(line)?;
    Ok((joint.x, joint.p, nis))
}

/// Position and covariance of a plot that can start a track.
pub(super) fn start_position(plot: &Plot) -> Result<(Point2<f64>, Sym2), UpdateError> {
    match Measurement::of(plot)? {
        Measurement::Position { z, r } if r.xx.is_finite() && r.yy.is_finite() => Ok((z, r)),
        _ => Err(UpdateError::UnsoundPlot),
    }
}

/// The rung `ca3`.
pub const CA3: Declared = Declared {
    word: "ca3",
    about: "Kalman filter, one axis at a time",
    cost: 2,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        Ok(match config.rolling {
            true => Estimator::TwoState(TwoState::from_plot(plot, config.q, config.start)?),
            false => Estimator::ThreeState(ThreeState::from_plot(plot, config.q, config.start)?),
        })
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::motion::Motion;
    use crate::filter::six_state::SixState;
    use crate::filter::testing::random_plots;

    /// Of both axes the one that is worse is told.
    #[test]
    fn what_is_no_covariance_is_told_by_its_worse_axis() {
        let (zero, one) = (Pair::default(), Pair::splat(1.0));
        for (pp, told) in [(Pair::new(-5.0, 5.0), -4.0), (Pair::new(5.0, -3.0), -2.0)] {
            let p = [pp, zero, zero, one, zero, one];
            let found = TwoState::correct([zero; 3], p, zero, one);
            assert_eq!(found.err(), Some(BadInnovation(told)));
        }
    }

    /// A plot far from where it was expected is taken as one of a manoeuvre.
    #[test]
    fn what_surprises_is_a_manoeuvre() {
        let plots = random_plots(20, 5);
        let mut filter =
            TwoState::from_plot(&plots[0], 0.5, Start::default()).expect("a sound plot");
        for plot in &plots[1..19] {
            filter.update(plot).expect("a sound plot");
        }
        let at = filter.predicted(plots[19].time).expect("later").position_m();
        for off_m in [0.5, 200.0] {
            let plot = Plot { position_m: at + Vector2::new(off_m, 0.0), ..plots[19] };
            let surprises = off_m > 100.0;
            let [mut taken, mut updated, mut turned] = [filter; 3];
            taken.take(&plot).expect("sound");
            updated.update(&plot).expect("sound");
            turned.update_manoeuvre(&plot).expect("sound");
            assert_eq!(taken.estimate(), if surprises { turned } else { updated }.estimate());
            let differ = taken.estimate() != updated.estimate();
            assert_eq!(differ, surprises, "{off_m}");
        }
    }

    #[test]
    fn constant_velocity_is_the_joint_filter_of_that_motion() {
        let mut plots = random_plots(300, 5);
        for plot in &mut plots {
            plot.across_m2 = plot.along_m2;
        }
        let (start, q) = (Start::default(), 0.5);
        let motion = Motion::ConstantVelocity { q };
        let mut joint = SixState::from_plot(&plots[0], motion, start).expect("a sound plot");
        let mut alone = TwoState::from_plot(&plots[0], q, start).expect("a sound plot");
        for (k, plots) in plots[1..].windows(2).enumerate() {
            // From the same state: several plots at once tie the axes of the joint one together.
            joint.replace(alone.time(), &alone.estimate().state);
            if k % 3 == 0 {
                let other = Plot { time: plots[0].time, ..plots[1] };
                let both = [(&plots[0], 0.6), (&other, 0.3)];
                joint.update_weighted(&both).expect("sound plots");
                alone.update_weighted(&both).expect("sound plots");
            } else {
                joint.update(&plots[0]).expect("a sound plot");
                alone.update(&plots[0]).expect("a sound plot");
            }
            assert!(alone.sound_motion().is_some());
            let later = plots[0].time.plus_s(0.7);
            for (a, b) in [
                (alone.estimate(), joint.estimate()),
                (alone.predicted(later).expect("later"), joint.predicted(later).expect("later")),
            ] {
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + b.abs());
                let (a, b) = (a.state, b.state);
                for i in 0..2 {
                    assert!(near(a.x[i].east(), b.x[i].east()), "{a:?} for {b:?}");
                    assert!(near(a.x[i].north(), b.x[i].north()), "{a:?} for {b:?}");
                }
                for i in [0, 1, 3] {
                    assert!(near(a.p[i].east(), b.p[i].east()), "{a:?} for {b:?}");
                    assert!(near(a.p[i].north(), b.p[i].north()), "{a:?} for {b:?}");
                }
                assert_eq!([a.x[2], a.p[2], a.p[4], a.p[5]], [Pair::default(); 4]);
            }
        }
    }
}
