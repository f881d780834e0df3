//! Alpha-beta-gamma: the Kalman filter with its gains computed once.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::lanes::{Lane, Pair};
use super::modes::Modes;
use super::motion::Motion;
use super::three_state::start_position;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, UpdateError, UpdateError::BadInnovation, interval};
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;
use std::sync::Arc;

/// Steady gains (α, β, γ) of the constant-acceleration filter with white jerk, Λ = qT⁵/R; the Kalman
/// gain is (α, β/T, γ/T²).
///
/// `γ² = Λ(1−α)`, `β² = 2αγ`, `α² = β(2−α) − β²/4 + γ²/120`: the algebraic Riccati equation, solved by
/// bisection on α with Newton's method on β inside. Source: Kalata, IEEE Trans. AES-20 (1984), with the
/// term γ²/120 of continuous white jerk.
#[must_use]
pub fn alpha_beta_gamma(lambda: f64) -> [f64; 3] {
    if lambda.is_nan() || lambda <= 0.0 {
        return [0.0; 3];
    }
    // ln Λ(α) grows with α; bisect on a = ln(α/(1−α)), so that no end of (0, 1) is crowded.
    let gains = |logit: f64| {
        let alpha = 1.0 / (1.0 + libm::exp(-logit));
        let beta = beta_of(alpha, 1.0 / (1.0 + libm::exp(logit)));
        (alpha, beta, beta * beta / (2.0 * alpha))
    };
    let (mut low, mut high) = (-200.0, 200.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let (_, _, gamma) = gains(middle);
        // Λ = γ²/(1−α), 1/(1−α) = 1 + e^a.
        let found = gamma * gamma * (1.0 + libm::exp(middle));
        if found < lambda { low = middle } else { high = middle }
    }
    let (alpha, beta, gamma) = gains(0.5 * (low + high));
    [alpha, beta, gamma]
}

/// β in β(2−α) − β²/4 + β⁴/(480α²) = α², from β₀ = 2(α/(1+√(1−α)))²; `rest` is 1 − α.
fn beta_of(alpha: f64, rest: f64) -> f64 {
    // In b = β/α² every coefficient stays near 1 for small α.
    let a2 = alpha * alpha;
    let root = 1.0 + rest.sqrt();
    let mut b = 2.0 / (root * root);
    for _ in 0..30 {
        let value = b * (1.0 + rest) - a2 * b * b / 4.0 + a2 * a2 * b * b * b * b / 480.0 - 1.0;
        let slope = (1.0 + rest) - a2 * b / 2.0 + a2 * a2 * b * b * b / 120.0;
        let next = b - value / slope;
        if next == b {
            break;
        }
        b = next;
    }
    b * a2
}

/// Steady gains (α, β) of the constant-velocity filter with white acceleration, Λ = qT³/R; the Kalman
/// gain is (α, β/T). `β² = Λ(1−α)`, `α² + αβ − 2β + β²/6 = 0`, by bisection on β.
#[must_use]
pub fn alpha_beta(lambda: f64) -> [f64; 2] {
    if lambda.is_nan() || lambda <= 0.0 {
        return [0.0; 2];
    }
    let alpha_of = |beta: f64| {
        beta * (2.0 - beta / 6.0) / ((2.0 * beta + beta * beta / 12.0).sqrt() + beta / 2.0)
    };
    let (mut low, mut high) = (0.0, 3.0 - 3f64.sqrt());
    // 1100 halvings reach the smallest number; each costs 5 ns and this runs once.
    for _ in 0..1100 {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            break;
        }
        let rest = 1.0 - alpha_of(middle);
        if rest > 0.0 && middle * middle < lambda * rest { low = middle } else { high = middle }
    }
    [alpha_of(low), low]
}

/// What a gain filter knows beforehand: gains and covariances (unit plot variance, unit interval) of
/// its first scans and of the steady state.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Schedule {
    /// α, β, γ.
    gains: [f64; 3],
    /// pp, pv, pa, vv, va, aa after the update.
    p: [f64; 6],
}

/// The alpha-beta-gamma filter, both axes.
///
/// From its first plot it runs through the gains that a Kalman filter would have, then keeps the steady
/// ones. The covariance it states is the one belonging to those gains, scaled by the plot's variance.
///
/// Where several sensors see the target, each with its variance `R_s` and interval `T_s`, they tell in one interval T of the
/// table what one sensor of `1/R = Σ w/R_s` would, `w = T/T_s` of those as fast as the table and `(T/T_s)⁵` of slower ones, by Λ, as they
/// say where the target is but not how it moves in between: the table is that of this R, in which the variance of the place grows from
/// `αR` to `αR/(1 − α)` between plots. A plot t after the last one finds P grown by t/T of that, has the gain `P/(P + R_s)` and
/// leaves `(1 − gain) P`; the gains of velocity and acceleration stand to it as β and γ to α, before a plot as after one.
#[derive(Clone, Debug)]
pub struct SteadyGain {
    time: SimTime,
    x: [Pair; 3],
    /// Scale of the stated covariance per axis: of one sensor the variance of its last plot.
    r: Pair,
    /// Variance of what all sensors tell in an interval, per axis; of one sensor the same.
    told: Pair,
    /// Intervals since the start.
    count: usize,
    /// Time since the last of them, s, where several sensors cut it.
    since_s: f64,
    /// Which of the tables: by the variance of the first plot, or of what several sensors tell.
    level: usize,
    /// Who told the last plot.
    sensor: SensorId,
    /// All that tell of the target, where they are several.
    heard: Vec<Heard>,
    table: Arc<Gains>,
    start: Start,
}

/// A sensor among several: its last plot's time and variance per axis, and the interval of its plots.
#[derive(Clone, Copy, Debug)]
struct Heard {
    sensor: SensorId,
    time: SimTime,
    r: Pair,
    interval_s: f64,
}

/// A sensor that has told nothing for so many of its intervals does not see the target any more.
const SILENT: f64 = 3.0;
/// An interval is no longer than so many times the one before.
const MISSED: f64 = 1.25;
/// Plots of one sensor are no nearer than this share of the table's interval, and no farther than so many of them.
const INTERVALS: [f64; 2] = [0.1, 16.0];

/// The gains of every scan since a start: made once, shared by all tracks. One table for each plot variance, a factor of four
/// apart: a finer sensor does not make targets move less, so Λ = qT⁵/R grows as R shrinks.
#[derive(Clone, Debug, PartialEq)]
pub struct Gains {
    lambda: f64,
    interval_s: f64,
    r_m2: f64,
    tables: Vec<[Schedule; SCANS]>,
}

/// Tables on either side of the one that was asked for.
const LEVELS: usize = 3;

/// Share of the interval below which two plots are taken as of one time.
const AT_ONCE: f64 = 0.1;

/// Scans until the steady state is taken for granted.
const SCANS: usize = 24;

impl SteadyGain {
    /// One plot: position measured, velocity and acceleration unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, table: Arc<Gains>, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let zero = Pair::default();
        let x = [Pair::new(z.x, z.y), zero, zero];
        let level = table.level(0.5 * (r.xx + r.yy));
        let (r, sensor) = (Pair::new(r.xx, r.yy), plot.sensor);
        let (time, since_s, heard) = (plot.time, 0.0, Vec::new());
        Ok(Self { time, x, r, told: r, count: 0, since_s, level, sensor, heard, table, start })
    }

    /// Takes a note of who told this plot of variance `r`; whether several tell of the target.
    #[inline]
    fn hear(&mut self, plot: &Plot, r: Pair) -> bool {
        if self.heard.is_empty() && self.sensor == plot.sensor {
            return false;
        }
        self.hear_several(plot, r)
    }

    fn hear_several(&mut self, plot: &Plot, r: Pair) -> bool {
        let unit_s = self.table.interval_s;
        if self.heard.is_empty() {
            let (sensor, time, r) = (self.sensor, self.time, self.told);
            self.heard.push(Heard { sensor, time, r, interval_s: unit_s });
        }
        let [least_s, most_s] = INTERVALS.map(|k| k * unit_s);
        // One plot does not tell an interval: until the second one it is as long as may be.
        let mut new = Heard { sensor: plot.sensor, time: plot.time, r, interval_s: most_s };
        if let Some(own) = self.heard.iter_mut().find(|h| h.sensor == plot.sensor) {
            let since_s = plot.time.since_s(own.time);
            // A plot that is missed makes no slow sensor.
            let longest_s = if own.interval_s < most_s { MISSED * own.interval_s } else { most_s };
            new.interval_s =
                if since_s < least_s { own.interval_s } else { since_s.min(longest_s) };
            *own = new;
        } else {
            self.heard.push(new);
        }
        self.heard.retain(|h| plot.time.since_s(h.time) <= SILENT * h.interval_s);
        self.sensor = plot.sensor;
        let told = self.heard.iter().map(|h| {
            let often = unit_s / h.interval_s;
            h.r.recip() * if often < 1.0 { often.powi(5) } else { often }
        });
        self.told = told.fold(Pair::default(), |a, b| a + b).recip();
        if self.heard.len() == 1 {
            self.heard.clear();
            self.told = r;
        }
        self.level = self.table.level(0.5 * self.told.sum());
        !self.heard.is_empty()
    }

    /// What velocity and acceleration take of a plot to what the place takes, `t` seconds after the one before: from what it is after
    /// an interval to what it is before the next one's end. Of a new track two plots at once say nothing of these.
    fn shares(&self, t: f64) -> [f64; 2] {
        let (last, next) = (self.schedule(self.last()), self.schedule(self.count));
        let part = (t / self.table.interval_s).min(1.0);
        [1, 2].map(|k| {
            let [before, after] =
                [last.p[k] / last.p[0].max(1e-9), next.gains[k] / next.gains[0].max(1e-9)];
            before + (after - before) * part
        })
    }

    /// The interval before this one.
    fn last(&self) -> usize {
        if self.count + 1 < SCANS { self.count.saturating_sub(1) } else { self.count }
    }

    fn schedule(&self, count: usize) -> &Schedule {
        &self.table.tables[self.level][count.min(SCANS - 1)]
    }

    fn covariance(&self) -> [Pair; 6] {
        let t = 1.0 / self.table.interval_s;
        let units = [1.0, t, t * t, t * t, t * t * t, t * t * t * t];
        let p = &self.schedule(self.count).p;
        std::array::from_fn(|i| self.r * (p[i] * units[i]))
    }

    #[inline]
    fn advance(&self, t: f64) -> [Pair; 3] {
        let x = &self.x;
        [x[0] + x[1] * t + x[2] * (0.5 * t * t), x[1] + x[2] * t, x[2]]
    }
}

impl Gains {
    /// `lambda` = qT⁵/R, `interval_s` the interval T between plots, `r_m2` a typical plot variance (it
    /// matters for the first few scans only).
    #[must_use]
    pub fn new(lambda: f64, interval_s: f64, start: Start, r_m2: f64) -> Self {
        let r_m2 = if r_m2 > 0.0 { r_m2 } else { 1.0 };
        let tables = (0..=2 * LEVELS)
            .map(|level| {
                let finer = Self::finer(level);
                Self::table(lambda * finer, interval_s, start, r_m2 / finer)
            })
            .collect();
        Self { lambda, interval_s, r_m2, tables }
    }

    /// How much smaller the plot variance of a table is than the one that was asked for.
    fn finer(level: usize) -> f64 {
        libm::exp2(2.0 * (level as f64 - LEVELS as f64))
    }

    /// The table for plots of this variance, m².
    fn level(&self, r_m2: f64) -> usize {
        // Half-way between two tables, a factor of two.
        (0..2 * LEVELS).find(|l| r_m2 * Self::finer(*l) * 2.0 >= self.r_m2).unwrap_or(2 * LEVELS)
    }

    fn table(lambda: f64, interval_s: f64, start: Start, r: f64) -> [Schedule; SCANS] {
        // A scalar Kalman filter in units of the plot's deviation and of the interval.
        let t = interval_s;
        let (vv, aa) =
            (start.sigma_v_mps * start.sigma_v_mps, start.sigma_a_ms2 * start.sigma_a_ms2);
        let mut p = [1.0, 0.0, 0.0, vv * t * t / r, 0.0, aa * t * t * t * t / r];
        let step = Motion::ConstantAcceleration { q: lambda }.step(1.0);
        let mut scans = [Schedule { gains: [1.0, 0.0, 0.0], p }; SCANS];
        for scan in scans.iter_mut().skip(1) {
            let lanes = p.map(Pair::splat);
            let [a, b, c, e, f, g] =
                super::gaussian::predict_axes(&[Pair::default(); 3], &lanes, &step)
                    .1
                    .map(Pair::east);
            let i = 1.0 / (a + 1.0);
            let gains = [a * i, b * i, c * i];
            p = [a * i, b * i, c * i, e - gains[1] * b, f - gains[1] * c, g - gains[2] * c];
            *scan = Schedule { gains, p };
        }
        let steady = alpha_beta_gamma(lambda);
        scans[SCANS - 1] = Schedule { gains: steady, p: steady_covariance(steady, lambda) };
        scans
    }
}

/// Steady covariance (unit variance and interval) from the gains: the three equations of the Riccati
/// equation that the gains do not use up.
fn steady_covariance([alpha, beta, gamma]: [f64; 3], lambda: f64) -> [f64; 6] {
    let s = 1.0 / (1.0 - alpha);
    let va_aa = beta * gamma * s - lambda / 2.0; // g = K₁ S K₂ − Q₁₂
    let va = 0.5 * (beta * beta * s - lambda / 3.0 - va_aa); // 2f + g = K₁ S K₁ − Q₁₁
    let va_sum = beta * s - beta - gamma - 1.5 * va - 0.5 * va_aa - lambda / 8.0;
    [alpha, beta, gamma, va_sum, va, va_aa]
}

impl StateEstimator for SteadyGain {
    fn time(&self) -> SimTime {
        self.time
    }

    #[inline]
    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, Gaussian { x: self.x, p: self.covariance(), cross: [0.0; 9] })
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let [p, v, _] = self.x.map(Pair::array);
        (Point2::new(p[0], p[1]), Vector2::new(v[0], v[1]))
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        let mut now = self.estimate();
        // The process noise that the gains stand for: q = ΛR/T⁵ per axis.
        let unit = Motion::ConstantAcceleration { q: 1.0 }.step(t);
        let q = self.told
            * (self.table.lambda * Gains::finer(self.level)
                / libm::pow(self.table.interval_s, 5.0));
        let quiet = super::motion::Step { q: [0.0; 6], ..unit };
        now.state = now.state.predicted(&quiet);
        for (p, noise) in now.state.p.iter_mut().zip(unit.q) {
            *p = *p + q * noise;
        }
        now.time = time;
        Ok(now)
    }

    #[inline]
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let t = interval(self.time, plot.time)?;
        let Measurement::Position { z, r } = Measurement::of(plot)? else {
            // Fixed gains know positions only.
            return Err(UpdateError::UnsoundPlot);
        };
        let r = Pair::new(r.xx, r.yy);
        if !r.all_positive() {
            return Err(BadInnovation(r.east().min(r.north())));
        }
        let x = self.advance(t);
        let nu = Pair::new(z.x, z.y) - x[0];
        // No innovation covariance is less than the plot's.
        let most = (nu * nu * r.recip()).sum();
        if !most.is_finite() {
            return Err(BadInnovation(most));
        }
        let interval_s = self.table.interval_s;
        let known = self.r * self.schedule(self.count).p[0];
        let several = self.hear(plot, r);
        // After a gap the course is as unknown as at the start.
        let gap = t > 5.0 * interval_s;
        // Several sensors cut an interval into pieces.
        self.since_s = if several { self.since_s + t } else { interval_s };
        if gap {
            self.count = 1;
        } else if self.since_s >= 0.5 * interval_s || self.count == 0 {
            self.count = (self.count + 1).min(SCANS - 1);
            self.since_s = 0.0;
        }
        let [alpha, beta, gamma] = self.schedule(self.count).gains;
        // What two plots of one sensor closer than this say of the speed is noise over a small number: the second one is taken
        // as another look at the same place, P/(P + R) with P = αR.
        let at_once = !several && t < AT_ONCE * interval_s;
        let gain = if several {
            let before = self.schedule(self.last()).p[0];
            let found = known + self.told * ((alpha / (1.0 - alpha) - before) * t / interval_s);
            let gain = found * (found + r).recip();
            self.r = if gap { r } else { gain * r } * (1.0 / alpha.max(1e-9));
            gain
        } else {
            (self.r, self.told) = (r, r);
            Pair::splat(if at_once { alpha / (1.0 + alpha) } else { alpha })
        };
        let s = r * (Pair::splat(1.0) - gain).recip();
        let d2 = (nu * nu * s.recip()).sum();
        // Gains belong to the interval of the table; a shorter one makes them no larger.
        let rate = if at_once { 0.0 } else { 1.0 / t.max(interval_s) };
        // Of velocity and acceleration in proportion to what the place takes.
        let [of_v, of_a] = if several { self.shares(t) } else { [beta, gamma] };
        let moved = if several { nu * gain } else { nu };
        self.x = [
            x[0] + if gap { nu } else { nu * gain },
            x[1] + moved * (of_v * rate),
            x[2] + moved * (of_a * rate * rate),
        ];
        self.time = plot.time;
        Ok(Nis { d2, det: s.east() * s.north(), dof: 2 })
    }

    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        super::taken(self, plot)
    }

    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        // Gains cannot be widened: take the plot and look for the new course with fresh ones.
        let count = self.count;
        self.count = count.min(2);
        let found = self.update(plot);
        if found.is_err() {
            self.count = count;
        }
        found
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        (self.time, self.x, self.count) = (time, state.x, 1);
        (self.r, self.told) = (state.p[0], state.p[0]);
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// The rung `abg`.
pub const ABG: Declared = Declared {
    word: "abg",
    about: "fixed gains",
    cost: 2,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        let gains = Arc::clone(&config.gains);
        Ok(Estimator::SteadyGain(SteadyGain::from_plot(plot, gains, config.start)?))
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, normal_pair};
    use crate::filter::testing::plot_at;
    use crate::filter::{FilterConfig, Rung};

    /// Fixed gains need a variance on both axes.
    #[test]
    fn a_plot_that_is_exact_on_one_axis_is_refused() {
        let first = plot_at(0.0, 0.0, 0.0, 4.0);
        let config = FilterConfig::new(Rung::Abg);
        let mut filter = Estimator::from_plot(&config, &first).expect("a sound plot");
        for exact in [0.0, 1e-31] {
            let plot = Plot { along_m2: exact, ..plot_at(1.0, 1.0, 0.0, 4.0) };
            assert_eq!(filter.update(&plot), Err(BadInnovation(0.0)));
        }
        assert!(filter.update(&plot_at(1.0, 1.0, 0.0, 4.0)).is_ok());
    }

    /// Gains of the textbook's filter that has run for long; of nothing that moves there is nothing to correct.
    #[test]
    fn steady_gains_are_those_of_a_filter_that_has_run_for_long() {
        let run = |n: usize, lambda: f64| {
            let f = nalgebra::Matrix3::new(1.0, 1.0, 0.5, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0);
            let q = if n == 3 {
                [1.0 / 20.0, 1.0 / 8.0, 1.0 / 6.0, 1.0 / 3.0, 0.5, 1.0]
            } else {
                [1.0 / 3.0, 0.5, 0.0, 1.0, 0.0, 0.0]
            };
            let q = nalgebra::Matrix3::new(q[0], q[1], q[2], q[1], q[3], q[4], q[2], q[4], q[5]);
            let (mut p, mut k) = (nalgebra::Matrix3::identity(), nalgebra::Vector3::zeros());
            if n == 2 {
                p[(2, 2)] = 0.0;
            }
            for _ in 0..40_000 {
                p = f * p * f.transpose() + q * lambda;
                k = p.column(0) / (p[(0, 0)] + 1.0);
                p -= k * p.row(0);
                p = (p + p.transpose()) * 0.5;
            }
            k
        };
        for lambda in [1e-6, 1e-3, 0.3, 5.0, 1e3, 1e6] {
            let (found, expected) = (alpha_beta_gamma(lambda), run(3, lambda));
            for i in 0..3 {
                assert!(
                    (found[i] - expected[i]).abs() < 1e-5 * expected[i],
                    "{lambda} {i}: {found:?} for {expected}"
                );
            }
            let (found, expected) = (alpha_beta(lambda), run(2, lambda));
            for i in 0..2 {
                assert!(
                    (found[i] - expected[i]).abs() < 1e-5 * expected[i],
                    "{lambda} {i}: {found:?} for {expected}"
                );
            }
        }
        for lambda in [0.0, -1.0, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!(
                (alpha_beta_gamma(lambda), alpha_beta(lambda)),
                ([0.0; 3], [0.0; 2]),
                "{lambda}"
            );
        }
    }

    /// One sensor: deviation of its plots, m; its interval and its first plot, s.
    type Told = (f64, f64, f64);

    /// Drives, turns at 2 m/s², drives on, brakes and stands.
    fn way(t: f64) -> Point2<f64> {
        let turn = |t: f64| Point2::new(libm::sin(0.2 * t), 1.0 - libm::cos(0.2 * t)) * 50.0;
        if t < 30.0 {
            Point2::new(10.0 * (t - 30.0), 0.0)
        } else if t < 40.0 {
            turn(t - 30.0)
        } else {
            let along = Vector2::new(libm::cos(2.0), libm::sin(2.0));
            let slower = (t - 60.0).clamp(0.0, 8.0);
            turn(10.0) + along * (10.0 * (t - 40.0).min(20.0) + (10.0 - 0.625 * slower) * slower)
        }
    }

    /// Mean squared error and its mean share of what is stated, at whole seconds from the tenth on, over 40 runs.
    fn followed(sensors: &[Told]) -> (f64, f64) {
        let (mut sum, mut nees, mut count) = (0.0, 0.0, 0.0);
        for run in 0..40 {
            let mut plots: Vec<(Plot, usize)> = Vec::new();
            for (n, (sigma_m, interval_s, first_s)) in sensors.iter().enumerate() {
                for k in 0..(80.0 / interval_s) as u32 {
                    let t = first_s + interval_s * f64::from(k);
                    // What a sensor draws does not depend on who else looks.
                    let stream = (sigma_m * 1e3) as u32;
                    let key = DrawKey { run_seed: 5, sensor: stream, entity: run, scan: k.into() };
                    let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                    let at = way(t) + Vector2::new(a, b) * *sigma_m;
                    let plot = plot_at(t, at.x, at.y, sigma_m * sigma_m);
                    plots.push((Plot { sensor: SensorId(n as u16), ..plot }, n));
                }
            }
            plots.sort_by_key(|(p, n)| (p.time, *n));
            let config = FilterConfig::new(Rung::Abg);
            let mut filter = Estimator::from_plot(&config, &plots[0].0).expect("sound");
            let mut next = 1;
            for second in 10..80 {
                let at = SimTime::from_s(f64::from(second));
                while next < plots.len() && plots[next].0.time <= at {
                    filter.take(&plots[next].0).expect("sound");
                    next += 1;
                }
                let found = filter.predicted(at).expect("later");
                let off = found.position_m() - way(at.s());
                sum += off.norm_squared();
                nees += crate::filter::consistency::nees_of(&found.position_cov_m2(), off);
                count += 1.0;
            }
        }
        (sum / count, nees / count)
    }

    /// Each sensor had the gains that the first one would have alone: a radar of 2.5 m between the plots of 0.5 m of another
    /// sensor drew the track to its own errors.
    #[test]
    fn of_several_sensors_none_makes_it_worse_than_another_alone() {
        for sensors in [
            [(2.5, 1.0, 0.0), (0.5, 1.0, 0.4)],
            [(0.5, 1.0, 0.0), (2.5, 1.0, 0.4)],
            [(2.5, 1.0, 0.0), (2.4, 1.0, 0.5)],
            [(2.5, 1.0, 0.0), (2.4, 1.0, 1e-6)],
            [(6.0, 1.0, 0.0), (1.0, 1.0, 0.001)],
            [(2.5, 1.0, 0.0), (0.6, 4.0, 0.3)],
            [(1.5, 1.0, 0.0), (5.0, 0.5, 0.2)],
        ] {
            let both = followed(&sensors);
            let alone = [followed(&sensors[..1]), followed(&sensors[1..])];
            println!("{sensors:?}: {both:.3?}, alone {alone:.3?}");
            assert!(alone.iter().all(|a| both.0 <= a.0), "{sensors:?}");
            // It brakes and turns harder than the gains foresee, with one sensor as with two.
            let most = alone.iter().map(|a| a.1).fold(0.0, f64::max);
            assert!(both.1 <= 1.5 * most, "{sensors:?}: NEES {} of {most}", both.1);
        }
    }

    /// Beside a coarse sensor, what a fine one tells in an interval falls by no more than a quarter more of its interval explains where it
    /// misses a plot, and is what it was with its next one; what has become slower is seen to be so after some plots.
    #[test]
    fn a_missed_plot_makes_no_slow_sensor() {
        let coarse = |t: f64| Plot { sensor: SensorId(1), ..plot_at(t, 5.0 * t, 0.0, 36.0) };
        let fine = |t: f64| Plot { sensor: SensorId(2), ..plot_at(t, 5.0 * t, 0.0, 0.25) };
        let gains = Arc::new(Gains::new(0.05, 1.0, Start::default(), 4.0));
        let mut filter =
            SteadyGain::from_plot(&coarse(0.0), gains, Start::default()).expect("sound");
        let mut told = Vec::new();
        for k in 0..40 {
            let t = f64::from(k) + 0.4;
            // One plot is missed; from the twentieth second on it looks every fourth.
            if k != 12 && (k < 20 || k % 4 == 0) {
                filter.update(&fine(t)).expect("sound");
            }
            told.push(filter.told.east());
            filter.update(&coarse(t + 0.6)).expect("sound");
        }
        println!("{told:.3?}");
        let usual = told[11];
        assert!((usual - 1.0 / (4.0 + 1.0 / 36.0)).abs() < 1e-9, "{usual}");
        assert!(told[13] > 2.0 * usual && told[13] < 3.2 * usual, "{}", told[13]);
        assert_eq!(told[14], usual);
        // A fourth as often is 4⁵ times less.
        assert!(told[39] > 30.0 * usual, "{}", told[39]);
    }
}
