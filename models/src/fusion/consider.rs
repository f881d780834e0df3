//! Slow errors respected: a filter that knows that part of a sensor's error stays from plot to plot.
//!
//! `z = Hx + Jb + v` with `b` a Gauss–Markov process of unit variance (ρ = e^{−T/τ}) for each sensor: both directions of a
//! receiver's error, what a radar's echo lies off along and across the line of sight; and how late the reports of a target are
//! beyond what is known, which stays and shows as −v times the delay. `b` stands in the state beside the
//! motion of the target, so that the filter neither averages a slow error away on paper nor throws away what its differences
//! tell of the velocity, and learns it where another sensor shows it. The modes of the rung act on the motion; the slow
//! errors are the same whatever the mode. Source: Bar-Shalom, Li, Kirubarajan 2001, ch. 11; modes as in [`crate::filter::imm`] and
//! [`crate::filter::histories`].

mod born;
mod past;

use crate::filter::lanes::Pair;
use crate::filter::mixtures::ranked;
use crate::filter::modes::{MAX_MODES, Modes, ca, cv};
use crate::filter::motion::Step;
use crate::filter::{Estimate, FilterConfig, Gaussian, Measurement, Nis, UpdateError, weights};
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;
use std::sync::Arc;

/// How part of a sensor's error stays from plot to plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlowError {
    /// Every error is white.
    White,
    /// Of a receiver.
    Receiver {
        /// This share of the variance that a plot states, in both directions.
        share: f64,
        /// Its correlation time, s.
        tau_s: f64,
        /// Standard deviation of how late the reports of one target are, the same for as long as it is seen, s.
        late_s: f64,
    },
    /// Of an echo, beside what a plot states.
    Echo {
        /// Standard deviations along and across the line of sight, m.
        sigma_m: [f64; 2],
        /// Their correlation time, s.
        tau_s: f64,
    },
}

/// A rung of the ladder with the slow errors of the sensors that have updated it.
#[derive(Clone, Debug)]
pub struct Consider {
    time: SimTime,
    modes: Arc<Modes>,
    /// Histories kept; 0 where the modes are mixed.
    keep: usize,
    slow: Vec<Slow>,
    parts: Vec<Part>,
    /// Of a track that a report began, until another sensor sees its target.
    alone: Option<born::Alone>,
}

/// The slow error of one sensor: rows of the state from `at`.
#[derive(Clone, Copy, Debug)]
struct Slow {
    /// None of the copy of a position ([`past`]).
    sensor: Option<SensorId>,
    /// It is the delay of the sensor's reports.
    delay: bool,
    tau_s: f64,
    at: usize,
    directions: usize,
}

/// One mode, or one history of modes: motion (x, vx, ax, y, vy, ay), then slow errors.
#[derive(Clone, Debug)]
struct Part {
    weight: f64,
    mode: usize,
    x: Vec<f64>,
    /// Symmetric, row by row.
    p: Vec<f64>,
}

/// Numbers of the motion.
const MOTION: usize = 6;
/// Most numbers of slow errors; what more sensors say is taken for white.
const MOST_SLOW: usize = 12;
/// Some white error is always assumed, or repeated reports would make the position exact on paper.
const LEAST_WHITE_SHARE: f64 = 1e-3;
/// Least weight of a mode that is mixed: it must be able to come back.
const LEAST_WEIGHT: f64 = 1e-30;

/// One measured number: `z = u·position + slope · b + v`.
#[derive(Clone, Copy, Debug)]
struct Row {
    u: Vector2<f64>,
    z: f64,
    variance: f64,
    /// Places of `b` in the state and their factors; a factor of 0 where there is none.
    slow: [(usize, f64); 2],
}

impl Row {
    /// What it measures of a state, or of a line of the covariance.
    fn of(&self, v: &[f64]) -> f64 {
        let slow = self.slow.iter().filter(|s| s.1 != 0.0).map(|(at, slope)| slope * v[*at]);
        self.u.x * v[0] + self.u.y * v[3] + slow.sum::<f64>()
    }
}

/// One or two rows of one plot.
#[derive(Clone, Copy, Debug)]
struct Rows {
    rows: [Row; 2],
    count: usize,
}

/// Innovations of plots with the probability of each.
type Shares = Vec<([f64; 2], f64)>;

/// The innovation of a plot against one part.
#[derive(Clone, Debug)]
struct Look {
    nu: [f64; 2],
    s: [f64; 3],
    /// `P Hᵀ`
    ph: [Vec<f64>; 2],
    d2: f64,
    ln_det: f64,
}

impl Consider {
    /// Goes on from a state that knows nothing of slow errors, with the modes of the configured rung.
    #[must_use]
    pub fn from_estimate(estimate: &Estimate, config: &FilterConfig) -> Self {
        let one = || {
            let motion = if config.rolling { cv(config.q) } else { ca(config.q) };
            Arc::new(Modes::new(&[motion], &[&[1.0]], &[1.0]).expect("one mode that stays"))
        };
        // Of events the modes go on: they know no slow errors.
        let (modes, keep) = match config.rung.declared().histories {
            Some(kept) => (Arc::clone(&config.modes), kept),
            None => (one(), 0),
        };
        let (slow, parts) = (Vec::new(), Vec::new());
        let mut filter = Self { time: estimate.time, modes, keep, slow, parts, alone: None };
        filter.replace(estimate.time, &estimate.state);
        filter
    }

    /// Time of the state.
    #[must_use]
    pub fn time(&self) -> SimTime {
        self.time
    }

    /// The state with its covariance, slow errors included.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        Estimate::new(self.time, mixture(&self.parts))
    }

    /// Takes this state: modes and what tied it to slow errors are forgotten, the slow errors are not.
    pub fn replace(&mut self, time: SimTime, state: &Gaussian) {
        let n = self.size();
        let (mut x, mut p) = (vec![0.0; n], vec![0.0; n * n]);
        let full = state.covariance();
        let best = self.parts.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        for i in 0..n {
            x[i] = match (i < MOTION, best) {
                (true, _) => state.x[i % 3].array()[i / 3],
                (false, Some(best)) => best.x[i],
                (false, None) => 0.0,
            };
            for j in 0..n {
                p[n * i + j] = match (i < MOTION && j < MOTION, i < MOTION || j < MOTION, best) {
                    (true, ..) => full[(i, j)],
                    (_, true, _) => 0.0,
                    (_, _, Some(best)) => best.p[n * i + j],
                    (_, _, None) => f64::from(u8::from(i == j)),
                };
            }
        }
        if let Some((at, ties)) = self.tied() {
            for (row, tie) in [0, MOTION / 2].into_iter().zip(ties) {
                (p[n * row + at], p[n * at + row]) = (tie, tie);
            }
        }
        let prior = self.modes.prior();
        self.parts = (0..self.modes.count())
            .map(|mode| Part { weight: prior[mode], mode, x: x.clone(), p: p.clone() })
            .collect();
        self.time = time;
    }

    /// The state at `time`, not before the present one; nothing is stored.
    ///
    /// # Errors
    /// If `time` is before the state's.
    pub fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        Ok(Estimate::new(time, mixture(&self.branches(time, false)?)))
    }

    /// The normalised innovation of a plot against the state predicted to its time.
    ///
    /// # Errors
    /// If the plot is late or unsound or the innovation covariance not positive definite.
    pub fn nis(&self, plot: &Plot, slow: SlowError) -> Result<Nis, UpdateError> {
        let mut at = self.clone();
        let rows = at.rows(plot, slow)?;
        let parts = at.branches(plot.time, false)?;
        let (mut mean, mut s) = ([0.0; 2], [0.0; 3]);
        for part in &parts {
            let look = part.look(&rows)?;
            let [a, b] = look.nu;
            mean = [mean[0] + part.weight * a, mean[1] + part.weight * b];
            let square = [a * a, a * b, b * b];
            (0..3).for_each(|k| s[k] += part.weight * (look.s[k] + square[k]));
        }
        let [a, b] = mean;
        let s = [s[0] - a * a, s[1] - a * b, s[2] - b * b];
        let (d2, det) = solved(mean, s, rows.count)?;
        Ok(Nis { d2, det, dof: rows.count as u8 })
    }

    /// Predicts to the plot's time and takes it; `jump`: a manoeuvre that no mode foresaw.
    ///
    /// `S = HPHᵀ + R`, `K = PHᵀS⁻¹` with the slow error's column in H, for each mode.
    ///
    /// # Errors
    /// If the plot is late or unsound or a covariance not positive definite; nothing is changed then.
    pub fn update(&mut self, plot: &Plot, slow: SlowError, jump: bool) -> Result<(), UpdateError> {
        self.take(&[(plot, 1.0)], slow, jump)
    }

    /// Takes several plots of one sensor and time of which at most one is of this target, with the probability of each.
    ///
    /// # Errors
    /// As [`Self::update`]; also for an empty list.
    pub fn update_weighted(
        &mut self,
        plots: &[(Plot, f64)],
        slow: SlowError,
    ) -> Result<(), UpdateError> {
        let plots: Vec<(&Plot, f64)> = plots.iter().map(|(plot, beta)| (plot, *beta)).collect();
        self.take(&plots, slow, false)
    }

    fn take(
        &mut self,
        plots: &[(&Plot, f64)],
        slow: SlowError,
        jump: bool,
    ) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let mut next = self.clone();
        next.hear(first.sensor, slow);
        let rows = next.rows(first, slow)?;
        let mut points = Vec::with_capacity(plots.len());
        for (plot, beta) in plots {
            points.push((Measurement::of(plot)?.point(), *beta));
        }
        let mut parts = next.branches(first.time, jump)?;
        let mut looks = Vec::with_capacity(parts.len());
        for part in &parts {
            looks.push(part.look(&rows)?);
        }
        let (shares, mut logs) = next.explained(&parts, &looks, &rows, &points)?;
        if weights::normalise(&mut logs).is_none() {
            logs = parts.iter().map(|part| part.weight).collect();
        }
        // What is hopeless is not worth an update.
        let order =
            if next.keep == 0 { (0..parts.len()).collect() } else { ranked(&logs, next.keep) };
        let frozen = next.frozen();
        next.parts.clear();
        for k in order {
            let mut part = std::mem::take(&mut parts[k]);
            part.condition(&looks[k], &rows, &shares[k], frozen);
            part.weight = logs[k].max(LEAST_WEIGHT);
            next.parts.push(part);
        }
        let sum: f64 = next.parts.iter().map(|part| part.weight).sum();
        next.parts.iter_mut().for_each(|part| part.weight /= sum);
        if !next.parts.iter().all(Part::is_sound) {
            return Err(UpdateError::BadCovariance);
        }
        next.time = first.time;
        *self = next;
        Ok(())
    }

    /// For each part: the innovations of the plots with their probabilities given this part, and ln of its weight with how
    /// well it explains them. A plot of probability β for the whole has β·L_part/L_whole for the part.
    fn explained(
        &self,
        parts: &[Part],
        looks: &[Look],
        rows: &Rows,
        points: &[(Point2<f64>, f64)],
    ) -> Result<(Vec<Shares>, Vec<f64>), UpdateError> {
        let innovations = |k: usize, point: Point2<f64>| -> [f64; 2] {
            std::array::from_fn(|r| {
                if r >= rows.count {
                    return 0.0;
                }
                // The first plot's own innovation, moved to this plot's place.
                looks[k].nu[r] + rows.rows[r].u.dot(&point.coords) - rows.rows[r].z
            })
        };
        if let [(point, beta)] = points
            && *beta >= 1.0
        {
            let shares = (0..parts.len()).map(|k| vec![(innovations(k, *point), 1.0)]).collect();
            let log = |(part, look): (&Part, &Look)| {
                libm::log(part.weight) - 0.5 * (look.d2 + look.ln_det)
            };
            return Ok((shares, parts.iter().zip(looks).map(log).collect()));
        }
        let c: Vec<f64> = parts.iter().map(|part| part.weight).collect();
        let betas: Vec<f64> = points.iter().map(|point| point.1).collect();
        let found = weights::explained(&c, &betas, |plot, part| {
            let nu = innovations(part, points[plot].0);
            let (d2, _) = solved(nu, looks[part].s, rows.count)?;
            Ok(-0.5 * (d2 + looks[part].ln_det))
        })?;
        let logs = found.iter().zip(&c).map(|(one, c)| libm::log(c * one.better)).collect();
        let own = |(k, one): (usize, &weights::Explained)| {
            let plots = points.iter().zip(&one.betas);
            plots.map(|((point, _), beta)| (innovations(k, *point), *beta)).collect()
        };
        Ok((found.iter().enumerate().map(own).collect(), logs))
    }

    fn size(&self) -> usize {
        MOTION + self.slow.iter().map(|s| s.directions).sum::<usize>()
    }

    /// The rows of a plot; a sensor that is new gets its place in the state.
    fn rows(&mut self, plot: &Plot, slow: SlowError) -> Result<Rows, UpdateError> {
        let m = Measurement::of(plot)?;
        let z = m.point();
        let (share, sigma_m, tau_s, late_s) = match slow {
            SlowError::White => (0.0, [0.0; 2], 1.0, 0.0),
            SlowError::Receiver { share, tau_s, late_s } => {
                (share.clamp(0.0, 1.0), [0.0; 2], tau_s, late_s)
            }
            SlowError::Echo { sigma_m, tau_s } => (0.0, sigma_m.map(|s| s.max(0.0)), tau_s, 0.0),
        };
        let now = self.estimate();
        let velocity = now.velocity_mps();
        // The line of sight to the target, not to its plot, whose error would turn the directions in which it is counted.
        let axis = plot.polar.filter(|_| sigma_m != [0.0; 2]).map_or(plot.axis, |polar| {
            let at_m = now.position_m() + velocity * plot.time.since_s(self.time);
            let line = plot.axis * polar.range_m + (at_m - z);
            let turned = line.try_normalize(1.0).unwrap_or(plot.axis);
            if turned.dot(&plot.axis) > 0.0 { turned } else { plot.axis }
        });
        let across = Vector2::new(axis.y, -axis.x);
        let is_slow = share > 0.0 || sigma_m != [0.0; 2];
        let place = is_slow.then(|| self.place((plot.sensor, false), tau_s, 2)).flatten();
        let delay =
            (late_s > 0.0).then(|| self.place((plot.sensor, true), f64::INFINITY, 1)).flatten();
        let delay = delay.filter(|_| !self.waits(plot.sensor));
        let row = |k: usize, u: Vector2<f64>, variance: f64| {
            let (white, own) = match place {
                Some(at) if share > 0.0 => {
                    let white = (1.0 - share).max(LEAST_WHITE_SHARE);
                    (white * variance, (at + k, (share * variance).sqrt()))
                }
                Some(at) => (variance, (at + k, sigma_m[k])),
                None => (variance, (0, 0.0)),
            };
            let late = delay.map_or((0, 0.0), |at| (at, -late_s * u.dot(&velocity)));
            Row { u, z: u.dot(&z.coords), variance: white, slow: [own, late] }
        };
        let count = if matches!(m, Measurement::Position { .. }) { 2 } else { 1 };
        let second = if count == 2 { plot.across_m2 } else { 0.0 };
        Ok(Rows { rows: [row(0, axis, plot.along_m2), row(1, across, second)], count })
    }

    /// Where the slow error of a sensor stands; a new one is put behind the others while there is room.
    fn place(
        &mut self,
        (sensor, delay): (SensorId, bool),
        tau_s: f64,
        directions: usize,
    ) -> Option<usize> {
        let own = |s: &&Slow| s.sensor == Some(sensor) && s.delay == delay;
        if let Some(found) = self.slow.iter().find(own) {
            return Some(found.at);
        }
        let n = self.size();
        if n + directions > MOTION + MOST_SLOW {
            return None;
        }
        let m = n + directions;
        for part in &mut self.parts {
            let mut p = vec![0.0; m * m];
            for i in 0..n {
                p[m * i..m * i + n].copy_from_slice(&part.p[n * i..n * (i + 1)]);
            }
            (n..m).for_each(|k| p[m * k + k] = 1.0);
            part.p = p;
            part.x.resize(m, 0.0);
        }
        let (sensor, tau_s) = (Some(sensor), tau_s.max(1e-3));
        self.slow.push(Slow { sensor, delay, tau_s, at: n, directions });
        Some(n)
    }

    /// The parts carried on to `time`: mixed, one for each mode; or each history with every mode.
    fn branches(&self, time: SimTime, jump: bool) -> Result<Vec<Part>, UpdateError> {
        let t = time.since_s(self.time);
        if t < 0.0 {
            return Err(UpdateError::BackInTime(-t));
        }
        let mut p = self.modes.transition(t);
        if jump {
            self.modes.expect_jump(&mut p);
        }
        let fade: Vec<f64> = self
            .slow
            .iter()
            .flat_map(|s| std::iter::repeat_n(libm::exp(-t / s.tau_s), s.directions))
            .collect();
        let mut out = Vec::new();
        if self.keep == 0 {
            let mut weights = [0.0; MAX_MODES];
            for (mode, weight) in weights.iter_mut().enumerate().take(self.modes.count()) {
                let share: Vec<f64> =
                    self.parts.iter().map(|part| part.weight * p[part.mode][mode]).collect();
                *weight = share.iter().sum();
                let mut part = if *weight > 0.0 {
                    let share: Vec<f64> = share.iter().map(|w| w / *weight).collect();
                    Part::mixed(&self.parts, &share)
                } else {
                    self.parts[mode].clone()
                };
                part.predict(&self.modes.step(mode, t), &fade);
                (part.weight, part.mode) = (*weight, mode);
                out.push(part);
            }
            return Ok(out);
        }
        for parent in &self.parts {
            for (mode, chance) in p[parent.mode].iter().enumerate().take(self.modes.count()) {
                if *chance > 0.0 && parent.weight * chance > 1e-16 {
                    let mut part = parent.clone();
                    part.predict(&self.modes.step(mode, t), &fade);
                    (part.weight, part.mode) = (parent.weight * chance, mode);
                    out.push(part);
                }
            }
        }
        Ok(out)
    }
}

impl Default for Part {
    fn default() -> Self {
        Self { weight: 0.0, mode: 0, x: Vec::new(), p: Vec::new() }
    }
}

impl Part {
    fn mixed(parts: &[Self], share: &[f64]) -> Self {
        let n = parts[0].x.len();
        let (mut x, mut p) = (vec![0.0; n], vec![0.0; n * n]);
        for (part, w) in parts.iter().zip(share) {
            x.iter_mut().zip(&part.x).for_each(|(x, own)| *x += w * own);
        }
        let mut off = vec![0.0; n];
        for (part, w) in parts.iter().zip(share) {
            (0..n).for_each(|i| off[i] = part.x[i] - x[i]);
            for i in 0..n {
                for j in i..n {
                    p[n * i + j] += w * (part.p[n * i + j] + off[i] * off[j]);
                }
            }
        }
        mirror(&mut p, n);
        Self { weight: 0.0, mode: 0, x, p }
    }

    /// `x ← Φx`, `P ← ΦPΦᵀ + Q`; the slow errors fade by `fade` and are driven so that their variance stays 1.
    fn predict(&mut self, step: &Step, fade: &[f64]) {
        let n = self.x.len();
        let Step { t, f02, f12, f22, q } = *step;
        let carry = |v: &mut [f64; 3]| {
            *v = [v[0] + t * v[1] + f02 * v[2], v[1] + f12 * v[2], f22 * v[2]];
        };
        for b in [0, 3] {
            let mut v = [self.x[b], self.x[b + 1], self.x[b + 2]];
            carry(&mut v);
            self.x[b..b + 3].copy_from_slice(&v);
        }
        fade.iter().enumerate().for_each(|(k, f)| self.x[MOTION + k] *= f);
        for j in 0..n {
            for b in [0, 3] {
                let mut v = [0, 1, 2].map(|k| self.p[n * (b + k) + j]);
                carry(&mut v);
                (0..3).for_each(|k| self.p[n * (b + k) + j] = v[k]);
            }
        }
        for i in 0..n {
            for b in [0, 3] {
                let mut v = [0, 1, 2].map(|k| self.p[n * i + b + k]);
                carry(&mut v);
                (0..3).for_each(|k| self.p[n * i + b + k] = v[k]);
            }
        }
        for (k, f) in fade.iter().enumerate() {
            for j in 0..n {
                self.p[n * (MOTION + k) + j] *= f;
                self.p[n * j + MOTION + k] *= f;
            }
            self.p[(n + 1) * (MOTION + k)] += 1.0 - f * f;
        }
        for b in [0, 3] {
            for (k, (i, j)) in
                [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
            {
                self.p[n * (b + i) + b + j] += q[k];
            }
        }
        mirror(&mut self.p, n);
    }

    fn look(&self, rows: &Rows) -> Result<Look, UpdateError> {
        let n = self.x.len();
        let column = |row: &Row| -> Vec<f64> {
            (0..n).map(|i| row.of(&self.p[n * i..n * (i + 1)])).collect()
        };
        let [first, second] = &rows.rows;
        let mut look = Look {
            nu: [first.z - first.of(&self.x), 0.0],
            s: [0.0, 0.0, 1.0],
            ph: [column(first), Vec::new()],
            d2: 0.0,
            ln_det: 0.0,
        };
        look.s[0] = first.of(&look.ph[0]) + first.variance;
        if rows.count == 2 {
            look.nu[1] = second.z - second.of(&self.x);
            look.ph[1] = column(second);
            look.s[1] = first.of(&look.ph[1]);
            look.s[2] = second.of(&look.ph[1]) + second.variance;
        }
        let (d2, det) = solved(look.nu, look.s, rows.count)?;
        (look.d2, look.ln_det) = (d2, libm::log(det));
        Ok(look)
    }

    /// The measurement update by innovations with their probabilities; the rest of 1 is "none of them". What is `frozen` is
    /// respected and not learnt.
    fn condition(
        &mut self,
        look: &Look,
        rows: &Rows,
        shares: &[([f64; 2], f64)],
        frozen: Option<usize>,
    ) {
        let n = self.x.len();
        let [a, b, c] = look.s;
        let det = a * c - b * b;
        // Rows of K.
        let gain: Vec<[f64; 2]> = (0..n)
            .map(|i| {
                let first = look.ph[0][i];
                if rows.count == 1 {
                    return [first / a, 0.0];
                }
                let second = look.ph[1][i];
                [(first * c - second * b) / det, (second * a - first * b) / det]
            })
            .collect();
        let (mut mean, mut square, mut taken) = ([0.0; 2], [0.0; 3], 0.0);
        for ([x, y], beta) in shares {
            mean = [mean[0] + beta * x, mean[1] + beta * y];
            square = [square[0] + beta * x * x, square[1] + beta * x * y, square[2] + beta * y * y];
            taken += beta;
        }
        // What is left open between the plots, less what the update takes away.
        let left = [
            square[0] - mean[0] * mean[0] - taken * a,
            square[1] - mean[0] * mean[1] - taken * b,
            square[2] - mean[1] * mean[1] - taken * c,
        ];
        for i in 0..n {
            let [k0, k1] = gain[i];
            let is_frozen = frozen == Some(i);
            if !is_frozen {
                self.x[i] += k0 * mean[0] + k1 * mean[1];
            }
            let (l0, l1) = (k0 * left[0] + k1 * left[1], k0 * left[1] + k1 * left[2]);
            for j in i + usize::from(is_frozen)..n {
                self.p[n * i + j] += l0 * gain[j][0] + l1 * gain[j][1];
            }
        }
        mirror(&mut self.p, n);
    }

    fn is_sound(&self) -> bool {
        let n = self.x.len();
        let finite = self.x.iter().chain(&self.p).all(|v| v.is_finite());
        finite
            && (0..n).all(|i| self.p[n * i + i] >= 0.0)
            && self.p[0] > 0.0
            && self.p[3 * n + 3] > 0.0
    }
}

/// `νᵀS⁻¹ν` and det S; `s` is (00, 01, 11).
///
/// # Errors
/// Unless S is finite and positive definite.
fn solved(nu: [f64; 2], [a, b, c]: [f64; 3], count: usize) -> Result<(f64, f64), UpdateError> {
    let det = if count == 1 { a } else { a * c - b * b };
    if !(a > 0.0 && det > 0.0 && det < f64::INFINITY) {
        return Err(UpdateError::BadInnovation(det));
    }
    let d2 = if count == 1 {
        nu[0] * nu[0] / a
    } else {
        (c * nu[0] * nu[0] - 2.0 * b * nu[0] * nu[1] + a * nu[1] * nu[1]) / det
    };
    Ok((d2, det))
}

/// Copies the upper triangle to the lower one.
fn mirror(p: &mut [f64], n: usize) {
    for i in 1..n {
        for j in 0..i {
            p[n * i + j] = p[n * j + i];
        }
    }
}

/// The motion of all parts together.
fn mixture(parts: &[Part]) -> Gaussian {
    let states: Vec<Gaussian> = parts.iter().map(motion).collect();
    let weights: Vec<f64> = parts.iter().map(|part| part.weight).collect();
    Gaussian::mixture(&weights, &states)
}

fn motion(part: &Part) -> Gaussian {
    let (x, p, n) = (&part.x, &part.p, part.x.len());
    let pair = |i: usize, j: usize| Pair::new(p[n * i + j], p[n * (3 + i) + 3 + j]);
    let mut cross = [0.0; 9];
    for (k, slot) in cross.iter_mut().enumerate() {
        *slot = p[n * (k / 3) + 3 + k % 3];
    }
    Gaussian {
        x: [Pair::new(x[0], x[3]), Pair::new(x[1], x[4]), Pair::new(x[2], x[5])],
        p: [pair(0, 0), pair(0, 1), pair(0, 2), pair(1, 1), pair(1, 2), pair(2, 2)],
        cross,
    }
}

#[cfg(test)]
mod tests;
