//! Motion as events: an acceleration begins, changes or ends at a moment nobody is told.
//!
//! A set of modes with noise of a fixed density is right for one sensor: it calls quiet what is below that sensor's errors.
//! Accelerations of machines are the same whatever looks at them. Each history is steady or accelerating; in an interval
//! nothing happens, or one event at a moment that is uniform in it:
//!
//! | event | of | what follows |
//! |---|---|---|
//! | begin, change | steady; accelerating | a new acceleration along the course or across it, N(0, σ_a²), beside that N(0, σ_s²) |
//! | end | accelerating | none |
//! | jump | both | velocity += N(0, σ_v²) per axis, no acceleration: what no machine does |
//!
//! With the old acceleration a₀: mean added to (p + vT, v, a): (a₀T²/3, a₀T/2, 0); `Q = Σ_a ⊗ E + a₀a₀ᵀ ⊗ (E − m mᵀ)`,
//! `E = [T⁴/20 T³/8 T²/6; · T²/3 T/2; · · 1]`, `m = (T²/6, T/2, 1)`. What rolls speeds up, brakes or turns, hardly ever two
//! of these from one moment on: Σ_a is long along the course in one history and across it in another; of what is too slow to show
//! a course it is round. An acceleration that stays keeps its angle to the course: it turns with `ω = (v × a)/|v|²`, and what is
//! not known of v and a is carried on with the derivatives of that.
//!
//! The N most likely histories are kept; two that say the same are one.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::lanes::{Lane, Pair};
use super::mixtures::{PositionMoments, likeliest_after, ranked};
use super::modes::Modes;
use super::motion::Step;
use super::three_state::start_position;
use super::turning::turned;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, UpdateError, interval, measurements};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// How often what happens. Nothing of it refers to a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventModel {
    /// Accelerations begin, and change, 1/s.
    pub begin_per_s: f64,
    /// Accelerations end, 1/s.
    pub end_per_s: f64,
    /// Jumps of the velocity, 1/s.
    pub jump_per_s: f64,
    /// A new acceleration, standard deviation along the course or across it (per axis where no course shows), m/s².
    pub sigma_a_ms2: f64,
    /// What it has in the other one of these directions, standard deviation, m/s².
    pub sigma_beside_ms2: f64,
    /// A jump, standard deviation per axis, m/s.
    pub sigma_v_mps: f64,
    /// Noise of a steady target: density of the acceleration, m²/s³.
    pub q_steady: f64,
    /// Noise of an accelerating one: density of the jerk, m²/s⁵.
    pub q_accelerating: f64,
}

impl Default for EventModel {
    /// Assumed, chosen on drawn movements (`studies::unseen`, seeds 21 to 28).
    fn default() -> Self {
        Self {
            begin_per_s: 0.12,
            end_per_s: 0.06,
            jump_per_s: 0.003,
            sigma_a_ms2: 1.8,
            sigma_beside_ms2: 0.3,
            sigma_v_mps: 12.0,
            q_steady: 1e-4,
            q_accelerating: 1e-4,
        }
    }
}

/// What is slower than this shows no course, m/s.
const COURSE_FROM_MPS: f64 = 2.0;

impl EventModel {
    /// Covariances (east, both, north; m²/s⁴) that a new acceleration may have, and how many: along the course and across it, or
    /// round.
    fn new_accelerations(&self, state: &Gaussian) -> ([[f64; 3]; 2], usize) {
        let [vx, vy] = state.x[1].array();
        let speed2 = vx * vx + vy * vy;
        let (long, short) = (self.sigma_a_ms2.powi(2), self.sigma_beside_ms2.powi(2));
        if !(speed2 > COURSE_FROM_MPS * COURSE_FROM_MPS && speed2.is_finite()) {
            return ([[long, 0.0, long]; 2], 1);
        }
        let [xx, xy, yy] = [vx * vx / speed2, vx * vy / speed2, vy * vy / speed2];
        let of = |along: f64, across: f64| {
            [along * xx + across * yy, (along - across) * xy, along * yy + across * xx]
        };
        ([of(long, short), of(short, long)], 2)
    }
}

/// What an acceleration that changes at a moment uniform in an interval does to one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeMoments {
    /// Added by the old acceleration to p + vT, v and the new acceleration: mean.
    pub mean: [f64; 3],
    t: f64,
    before2: f64,
}

/// Moments for an interval of `t` seconds and an old acceleration `before`, m/s².
#[must_use]
pub fn change_moments(t: f64, before: f64) -> ChangeMoments {
    let mean = [before * t * t / 3.0, before * t / 2.0, 0.0];
    ChangeMoments { mean, t, before2: before * before }
}

impl ChangeMoments {
    /// Covariance of (p, v, a), upper triangle, for a new acceleration N(0, `sigma`²); 0: none.
    #[must_use]
    pub fn noise(&self, sigma: f64) -> [f64; 6] {
        self.noise_of(sigma * sigma)
    }

    /// The same by the variance of the new acceleration.
    fn noise_of(&self, s2: f64) -> [f64; 6] {
        let (t, b2) = (self.t, self.before2);
        let t2 = t * t;
        [
            t2 * t2 * (s2 / 20.0 + b2 / 45.0),
            t2 * t * (s2 / 8.0 + b2 / 24.0),
            t2 * s2 / 6.0,
            t2 * (s2 / 3.0 + b2 / 12.0),
            t * s2 / 2.0,
            s2,
        ]
    }
}

/// One history.
#[derive(Clone, Copy, Debug)]
struct History {
    state: Gaussian,
    accelerating: bool,
    weight: f64,
    log_weight: f64,
}

/// The filter with at most N histories.
#[derive(Clone, Debug)]
pub struct Events<const N: usize> {
    time: SimTime,
    kept: Vec<History>,
    model: EventModel,
    start: Start,
    /// ln of the density that the last plot was given.
    log_density: f64,
}

/// A history is dropped below this share of the best one's weight: e⁻¹⁶.
const NEGLIGIBLE: f64 = 16.0;
/// Two histories are one whose means are this near (squares over variances) …
const SAME_MEANS: f64 = 0.1;
/// … and whose variances differ by less than this share.
const SAME_SPREAD: f64 = 0.3;
/// Share of histories of a new track that accelerate.
const ACCELERATING: f64 = 0.3;
/// Prior of a jump once a plot was accepted by the kinematic gate alone.
const JUMP_PRIOR: f64 = 0.5;

impl<const N: usize> Events<N> {
    /// One plot: position measured, velocity and acceleration unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, model: EventModel, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        Ok(Self::at(plot.time, &state, model, start))
    }

    /// From a state at a time, accelerating or not.
    #[must_use]
    pub fn at(time: SimTime, state: &Gaussian, model: EventModel, start: Start) -> Self {
        let kept = Vec::with_capacity(N);
        let mut filter = Self { time, kept, model, start, log_density: 0.0 };
        filter.replace(time, state);
        filter
    }

    /// ln of the density (1/m², or 1/m of a plot along one direction) that the last plot was given before it was taken.
    #[must_use]
    pub fn log_density(&self) -> f64 {
        self.log_density
    }

    /// Histories kept now.
    #[must_use]
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    /// What may become of one state within `t` seconds: probability, whether it accelerates then, state.
    fn branches(
        &self,
        state: &Gaussian,
        accelerating: bool,
        t: f64,
        jump: f64,
        mut each: impl FnMut(f64, bool, Gaussian),
    ) {
        let m = &self.model;
        let within = |rate: f64| -libm::expm1(-rate * t);
        let change = within(m.begin_per_s);
        let end = if accelerating { within(m.end_per_s) } else { 0.0 };
        let jump = jump.max(within(m.jump_per_s));
        let nothing = (1.0 - change - end).max(0.0) * (1.0 - jump);
        let rest = (1.0 - nothing - jump).max(0.0);
        let of_rest = if change + end > 0.0 { rest / (change + end) } else { 0.0 };
        if nothing > 0.0 {
            let next = if accelerating {
                turned(state, t).plus(Step::constant_acceleration(m.q_accelerating, t).q)
            } else {
                state.predicted_steady(&Step::constant_velocity(m.q_steady, t))
            };
            each(nothing, accelerating, next);
        }
        // The old acceleration for a time that is uniform in the interval, then a new one or none.
        let old = Step { t, f02: t * t / 3.0, f12: t / 2.0, f22: 0.0, q: [0.0; 6] };
        if change + end > 0.0 {
            let ended = state.predicted(&old);
            let before = state.x[2].array();
            if end > 0.0 {
                each(end * of_rest, false, ended.plus_changed(t, before, [0.0; 3]));
            }
            let (spreads, count) = m.new_accelerations(state);
            let chance = change * of_rest / count as f64;
            for spread in &spreads[..count] {
                each(chance, true, ended.plus_changed(t, before, *spread));
            }
        }
        if jump > 0.0 {
            let s2 = m.sigma_v_mps * m.sigma_v_mps;
            let q = [s2 * t * t / 3.0, s2 * t / 2.0, 0.0, s2, 0.0, 0.0];
            each(
                jump,
                false,
                state.predicted_steady(&Step { q, ..Step::constant_velocity(0.0, t) }),
            );
        }
    }

    /// All histories one interval on: log of prior weight, flag, state.
    fn children(&self, t: f64, jump: f64) -> Vec<(f64, bool, Gaussian)> {
        let mut children = Vec::with_capacity(4 * self.kept.len());
        for parent in &self.kept {
            self.branches(&parent.state, parent.accelerating, t, jump, |chance, flag, state| {
                children.push((parent.weight * chance, flag, state));
            });
        }
        children
    }

    fn take(&mut self, plot: &Plot, jump: f64) -> Result<Nis, UpdateError> {
        let t = interval(self.time, plot.time)?;
        let m = Measurement::of(plot)?;
        let children = self.children(t, jump);
        let mut moments = PositionMoments::about(self.kept[0].state.position());
        let mut scores = Vec::with_capacity(children.len());
        let mut dof = 2;
        for (weight, _, state) in &children {
            moments.add(*weight, state.position(), state.position_cov());
            scores.push(match state.innovation(&m) {
                Ok(i) => {
                    dof = i.dof;
                    libm::log(*weight) - 0.5 * (i.d2 + i.ln_det)
                }
                Err(_) => f64::NEG_INFINITY,
            });
        }
        let nis = moments.nis(&m)?;
        let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !best.is_finite() {
            return Err(UpdateError::BadInnovation(best));
        }
        let sum: f64 = scores.iter().map(|s| libm::exp(s - best)).sum();
        let mut kept: Vec<History> = Vec::with_capacity(N);
        for k in ranked(&scores, scores.len()) {
            if scores[k] < best - NEGLIGIBLE {
                break;
            }
            let (_, accelerating, mut state) = children[k];
            if state.update(&m).is_err() {
                continue; // a child that rounding has broken
            }
            let log_weight = scores[k] - best;
            let one = History { state, accelerating, weight: libm::exp(log_weight), log_weight };
            match kept.iter().position(|other| other.says_the_same(&one)) {
                Some(same) => kept[same].join(&one),
                None if kept.len() < N => kept.push(one),
                None => break,
            }
        }
        self.settle(kept)?;
        self.time = plot.time;
        self.log_density =
            best + libm::log(sum) - 0.5 * f64::from(dof) * libm::log(std::f64::consts::TAU);
        Ok(nis)
    }

    fn settle(&mut self, kept: Vec<History>) -> Result<(), UpdateError> {
        let sum: f64 = kept.iter().map(|h| h.weight).sum();
        if kept.is_empty() || !(sum > 0.0 && sum.is_finite()) {
            return Err(UpdateError::BadCovariance);
        }
        self.kept = kept;
        self.kept.iter_mut().for_each(|h| h.weight /= sum);
        Ok(())
    }

    fn mixed(&self) -> Gaussian {
        mixture(self.kept.iter().map(|h| (h.weight, &h.state)))
    }
}

fn mixture<'a>(parts: impl Iterator<Item = (f64, &'a Gaussian)>) -> Gaussian {
    let (weights, states): (Vec<f64>, Vec<Gaussian>) = parts.map(|(w, s)| (w, *s)).unzip();
    Gaussian::mixture(&weights, &states)
}

impl History {
    fn says_the_same(&self, other: &Self) -> bool {
        if self.accelerating != other.accelerating {
            return false;
        }
        let (a, b) = (&self.state, &other.state);
        let last = if self.accelerating { 3 } else { 2 };
        let (mut apart, mut traces) = (0.0, [0.0; 2]);
        for (k, place) in [0, 3, 5].into_iter().enumerate().take(last) {
            let (x, y) = (a.x[k].array(), b.x[k].array());
            let (p, q) = (a.p[place].array(), b.p[place].array());
            for axis in 0..2 {
                let d = x[axis] - y[axis];
                apart += if p[axis] > 0.0 { d * d / p[axis] } else { 0.0 };
            }
            traces[0] += p[0] + p[1];
            traces[1] += q[0] + q[1];
        }
        apart < SAME_MEANS
            && (traces[0] - traces[1]).abs() <= SAME_SPREAD * traces[0].max(traces[1])
    }

    fn join(&mut self, other: &Self) {
        let sum = self.weight + other.weight;
        let share = [self.weight / sum, other.weight / sum];
        self.state = Gaussian::mixture(&share, &[self.state, other.state]);
        self.weight = sum;
        self.log_weight = libm::log(sum);
    }
}

impl Gaussian {
    /// More noise of the same kind on both axes.
    fn plus(self, q: [f64; 6]) -> Self {
        self.plus_pairs(q, q)
    }

    /// With what a change at a moment uniform in `t` seconds adds: old acceleration `before`, covariance of the new one.
    fn plus_changed(self, t: f64, before: [f64; 2], [xx, xy, yy]: [f64; 3]) -> Self {
        let [east, north] = before.map(|a| change_moments(t, a));
        let mut next = self.plus_pairs(east.noise_of(xx), north.noise_of(yy));
        // The moment is the same of both axes.
        let both = ChangeMoments { before2: before[0] * before[1], ..east }.noise_of(xy);
        for (cross, place) in next.cross.iter_mut().zip([0, 1, 2, 1, 3, 4, 2, 4, 5]) {
            *cross += both[place];
        }
        next
    }

    fn plus_pairs(mut self, east: [f64; 6], north: [f64; 6]) -> Self {
        for k in 0..6 {
            self.p[k] = self.p[k] + Pair::new(east[k], north[k]);
        }
        self
    }
}

impl<const N: usize> StateEstimator for Events<N> {
    fn time(&self) -> SimTime {
        self.time
    }

    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, self.mixed())
    }

    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        self.mixed().motion()
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        // All histories of one kind together: a prediction takes no likelihood that would tell them apart.
        let mut parts = Vec::with_capacity(8);
        for kind in [false, true] {
            let own = || self.kept.iter().filter(|h| h.accelerating == kind);
            let sum: f64 = own().map(|h| h.weight).sum();
            if sum > 0.0 {
                let state = mixture(own().map(|h| (h.weight / sum, &h.state)));
                self.branches(&state, kind, t, 0.0, |chance, _, next| {
                    parts.push((sum * chance, next));
                });
            }
        }
        Ok(Estimate::new(time, mixture(parts.iter().map(|(w, s)| (*w, s)))))
    }

    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, 0.0)
    }

    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, JUMP_PRIOR)
    }

    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        // One that is certain is an ordinary update.
        if let Some((certain, _)) = plots.iter().find(|(_, beta)| *beta >= 1.0) {
            return self.take(certain, 0.0).map(|_| ());
        }
        let children = self.children(interval(self.time, first.time)?, 0.0);
        let c: Vec<f64> = children.iter().map(|child| child.0).collect();
        let states: Vec<Gaussian> = children.iter().map(|child| child.2).collect();
        let kept = likeliest_after(&c, &states, &measurements(plots)?, N)?;
        let history = |(k, state, log_weight): (usize, Gaussian, f64)| {
            let weight = libm::exp(log_weight);
            History { state, accelerating: children[k].1, weight, log_weight }
        };
        let kept = kept.into_iter().map(history).collect();
        self.settle(kept)?;
        // Which plot it was is not known: it says nothing of the rung.
        (self.time, self.log_density) = (first.time, f64::NAN);
        Ok(())
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        let mut moving = *state;
        if state.p[5].array().iter().any(|v| *v <= 0.0) {
            let s2 = self.start.sigma_a_ms2 * self.start.sigma_a_ms2;
            moving.p[5] = Pair::splat(s2);
        }
        self.kept.clear();
        for (accelerating, weight, state) in [
            (false, 1.0 - ACCELERATING, state.without_acceleration()),
            (true, ACCELERATING, moving),
        ] {
            self.kept.push(History { state, accelerating, weight, log_weight: libm::log(weight) });
        }
        (self.time, self.log_density) = (time, f64::NAN);
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// The rung `events9`.
pub const EVENTS9: Declared = Declared {
    word: "events9",
    about: "9 histories of accelerations that begin, change, end",
    cost: 490,
    modes: Modes::three,
    histories: Some(0),
    start: |config, plot| {
        let filter = Events::from_plot(plot, EventModel::default(), config.start)?;
        Ok(Estimator::Events9(Box::new(filter)))
    },
};

/// The rung `events27`.
pub const EVENTS27: Declared = Declared {
    word: "events27",
    about: "27 histories of accelerations that begin, change, end",
    cost: 1_530,
    modes: Modes::three,
    histories: Some(0),
    start: |config, plot| {
        let filter = Events::from_plot(plot, EventModel::default(), config.start)?;
        Ok(Estimator::Events27(Box::new(filter)))
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    fn history(accelerating: bool) -> History {
        let state = Gaussian {
            x: [Pair::new(3.0, 4.0), Pair::new(9.0, 1.0), Pair::new(0.5, 0.2)],
            p: [(2.0, 3.0), (0.0, 0.0), (0.0, 0.0), (0.5, 0.4), (0.0, 0.0), (0.1, 0.2)]
                .map(|(east, north)| Pair::new(east, north)),
            cross: [0.0; 9],
        };
        History { state, accelerating, weight: 0.5, log_weight: -0.7 }
    }

    /// Two histories are one up to a tenth of a deviation squared, over all that they tell apart, and up to three tenths of their
    /// variances: what lies farther apart are two things that the next plots decide between.
    #[test]
    fn histories_are_one_only_where_they_say_the_same() {
        for accelerating in [false, true] {
            let one = history(accelerating);
            assert!(one.says_the_same(&one));
            assert!(!one.says_the_same(&history(!accelerating)));
            // Moved by this many deviations in one of the numbers, both axes.
            let moved = |number: usize, deviations: f64| {
                let mut other = one;
                let place = [0, 3, 5][number];
                let [east, north] = one.state.p[place].array().map(|v| deviations * v.sqrt());
                other.state.x[number] = other.state.x[number] + Pair::new(east, north);
                one.says_the_same(&other)
            };
            // Of two axes, a tenth: 0.22 each.
            let numbers = if accelerating { 3 } else { 2 };
            for number in 0..numbers {
                assert!(moved(number, 0.21) && !moved(number, 0.24), "{accelerating} {number}");
            }
            if !accelerating {
                assert!(moved(2, 3.0), "what is steady has no acceleration");
            }
            let wider = |by: f64| {
                let mut other = one;
                other.state.p.iter_mut().for_each(|p| *p = *p * by);
                [one.says_the_same(&other), other.says_the_same(&one)]
            };
            assert_eq!(
                [1.4, 1.45, 0.72, 0.68].map(wider),
                [[true; 2], [false; 2], [true; 2], [false; 2]]
            );
        }
    }

    /// The old acceleration until a moment, the new one after it, for every moment of the interval.
    #[test]
    fn a_change_at_any_moment_has_the_moments_of_all_moments() {
        for (t, before, sigma) in
            [(1.0, 0.0, 2.0), (2.0, 3.0, 0.0), (0.5, -1.5, 1.2), (3.0, 2.0, 1.0)]
        {
            let steps = 20_000;
            let (mut mean, mut square) = ([0.0; 3], [[0.0; 3]; 3]);
            for k in 0..steps {
                let (chance, u) =
                    (1.0 / f64::from(steps), t * (f64::from(k) + 0.5) / f64::from(steps));
                let (left, old, new) = (t - u, before, sigma);
                let of_old = [old * u * (0.5 * u + left), old * u, 0.0];
                let of_new = [new * 0.5 * left * left, new * left, new];
                for i in 0..3 {
                    mean[i] += chance * of_old[i];
                    for j in 0..3 {
                        square[i][j] += chance * (of_old[i] * of_old[j] + of_new[i] * of_new[j]);
                    }
                }
            }
            let moments = change_moments(t, before);
            let noise = moments.noise(sigma);
            for (n, (i, j)) in
                [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
            {
                assert!((moments.mean[i] - mean[i]).abs() < 1e-6, "{t} {before} {i}");
                let expected = square[i][j] - mean[i] * mean[j];
                assert!(
                    (noise[n] - expected).abs() < 1e-6,
                    "{t} {before} {sigma} {i} {j}: {} {expected}",
                    noise[n]
                );
            }
        }
    }

    #[test]
    fn a_new_acceleration_is_along_the_course_or_across_it_or_round_where_there_is_none() {
        let model = EventModel { sigma_a_ms2: 2.0, sigma_beside_ms2: 0.5, ..EventModel::default() };
        let of = |east: f64, north: f64| {
            let mut state = Gaussian::default();
            state.x[1] = Pair::new(east, north);
            model.new_accelerations(&state)
        };
        let close = |a: [f64; 3], b: [f64; 3]| {
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} for {b:?}");
        };
        for (east, north) in
            [(0.0, 0.0), (2.0, 0.0), (-1.2, 1.6), (f64::NAN, 1.0), (f64::INFINITY, 0.0)]
        {
            let (round, count) = of(east, north);
            assert_eq!((round[0], count), ([4.0, 0.0, 4.0], 1), "{east} {north}");
        }
        let ([along, across], count) = of(0.0, -9.0);
        assert_eq!(count, 2);
        close(along, [0.25, 0.0, 4.0]);
        close(across, [4.0, 0.0, 0.25]);
        // North-east: half of each, and what they have together.
        let ([along, across], _) = of(5.0, 5.0);
        close(along, [2.125, 1.875, 2.125]);
        close(across, [2.125, -1.875, 2.125]);
    }
}
