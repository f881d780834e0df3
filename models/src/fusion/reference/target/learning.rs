//! What the plots of a target say of how it moves and how its echoes wander.
//!
//! The density of the acceleration at each time, the variances of its plots and their weights are those under which the plots
//! are likeliest, with what is expected as a few plots more: fixed points of the scores of smoothed disturbances (Koopman,
//! Biometrika 80, 1993), a plot's weight as of Student's errors. What stands is told that its velocity is none.

use super::Target;
use crate::frames::{Point2, Vector2};
use crate::fusion::reference::linear::Smoothed;
use crate::time::SimTime;

/// Limits of the density of the acceleration, m²/s³.
const Q_LIMITS: [f64; 2] = [1e-4, 300.0];
/// What the density is without plots that say so (m²/s³), and as how many intervals that counts.
const USUAL_Q: f64 = 0.3;
const USUAL_COUNTS: f64 = 4.0;
/// That is of targets as fast as this, m/s; of slower ones less with the square of the speed, down to this share.
const BRISK_MPS: f64 = 2.0;
const SLOWEST_SHARE: f64 = 1e-3;
/// The density holds for about so long to either side, s.
const Q_WINDOW_S: f64 = 3.0;
/// What is slower than this stands, m/s, where it is so for so long, s.
const SLOW_MPS: f64 = 0.3;
const STANDS_S: f64 = 10.0;
/// At either end of such a stretch it may move already, s.
const SURE_S: f64 = 3.0;
/// Where plots within this time pull at a velocity of none by so many times what noise does, the target does not stand, s.
const PULL_S: f64 = 2.5;
const MOST_PULL: f64 = 4.0;
/// What is faster shows its course, m/s.
const COURSE_FROM_MPS: f64 = 1.5;
/// Plots that what is stated of the variance counts for.
const STATED_COUNTS: f64 = 6.0;
const FACTOR_LIMITS: [f64; 2] = [0.05, 8.0];
/// Degrees of freedom of the errors of plots: one wild plot weighs little.
const FREEDOM: f64 = 6.0;
/// But not less than this: the tracker's gates have let it pass, and a whole stretch that a smooth way misses must be able to bend it.
const LEAST_WEIGHT: f64 = 0.25;

impl Target<'_> {
    /// Learns from what came back how the target moves and how its echoes wander.
    pub(in crate::fusion::reference) fn learn(&mut self, back: &[Smoothed], late: bool) {
        self.learn_density(back);
        self.learn_plots(back);
        for (velocity, here) in self.velocity.iter_mut().zip(back) {
            *velocity = Vector2::new(here.state[1], here.state[3]);
        }
        self.position = back.iter().map(|b| Point2::new(b.state[0], b.state[2])).collect();
        if late {
            self.learn_standing(back);
        }
        self.learn_course();
    }

    fn learn_density(&mut self, back: &[Smoothed]) {
        let times: Vec<f64> = self.at.iter().map(|a| a.time.since_s(self.at[0].time)).collect();
        let old = self.q.clone();
        let mut first = 0;
        for k in 0..times.len() {
            while times[k] - times[first] > 3.0 * Q_WINDOW_S {
                first += 1;
            }
            let (mut found, mut told) = (0.0, 0.0);
            for j in first..times.len() {
                let off = (times[j] - times[k]) / Q_WINDOW_S;
                if off > 3.0 {
                    break;
                }
                if self.stands[j] {
                    continue;
                }
                let weight = libm::exp(-0.5 * off * off);
                // Of the density here: it is what holds all around.
                found += weight * back[j].moved.found;
                told += weight * back[j].moved.told;
            }
            let usual = self.usual_q(k);
            let ratio = (found + USUAL_COUNTS * usual / old[k]) / (told + USUAL_COUNTS);
            let ratio = if ratio.is_finite() { ratio.clamp(0.1, 10.0) } else { 1.0 };
            self.q[k] = (old[k] * ratio).clamp(Q_LIMITS[0], Q_LIMITS[1]);
        }
    }

    /// The density that is expected of a target by its speed: what is slow does not accelerate much.
    fn usual_q(&self, k: usize) -> f64 {
        let share = (self.velocity[k].norm() / BRISK_MPS).min(1.0);
        if self.moves[k] || !share.is_finite() {
            USUAL_Q
        } else {
            USUAL_Q * (share * share).max(SLOWEST_SHARE)
        }
    }

    fn learn_plots(&mut self, back: &[Smoothed]) {
        let mut sums = vec![[(0.0, 0.0); 2]; self.factors.len()];
        for (k, here) in back.iter().enumerate() {
            let Some(index) = self.at[k].plot else { continue };
            let plot = &self.gathered.plots[index];
            let Some(of) = self.factors.iter().position(|f| f.0 == plot.sensor) else { continue };
            let sides = if plot.across_m2.is_finite() { 2 } else { 1 };
            let mut square = 0.0;
            for side in 0..sides {
                let Some(score) = here.rows.get(side) else { continue };
                // Expected square of the white error over its variance, before the weight.
                square += (score.found + 1.0 - score.told).max(0.0) / self.weights[index];
                sums[of][side].0 += score.found;
                sums[of][side].1 += score.told;
            }
            let sides = sides as f64;
            self.weights[index] = ((FREEDOM + sides) / (FREEDOM + square)).max(LEAST_WEIGHT);
        }
        for ((_, factors), sums) in self.factors.iter_mut().zip(&sums) {
            for (factor, (found, told)) in factors.iter_mut().zip(sums) {
                let ratio = (found + STATED_COUNTS / *factor) / (told + STATED_COUNTS);
                let ratio = if ratio.is_finite() { ratio.clamp(0.2, 5.0) } else { 1.0 };
                *factor = (*factor * ratio).clamp(FACTOR_LIMITS[0], FACTOR_LIMITS[1]);
            }
        }
    }

    /// Stretches in which the target is slow for long. Where plots pull at a velocity that was told to be none, it moves, and
    /// that is settled.
    fn learn_standing(&mut self, back: &[Smoothed]) {
        let count = self.at.len();
        let seconds = |a: usize, b: usize| self.at[b].time.since_s(self.at[a].time);
        let mut first = 0;
        let mut moves = Vec::new();
        for k in 0..count {
            while seconds(first, k) > PULL_S {
                first += 1;
            }
            if !self.stands[k] {
                continue;
            }
            let near = (first..count).take_while(|j| seconds(k, *j) <= PULL_S);
            let (mut found, mut told) = (0.0, 0.0);
            for j in near.filter(|j| self.stands[*j]) {
                let rows = &back[j].rows;
                rows.iter().skip(rows.len().saturating_sub(2)).for_each(|s| {
                    found += s.found;
                    told += s.told;
                });
            }
            if found > MOST_PULL * told {
                moves.push(k);
            }
        }
        moves.into_iter().for_each(|k| self.moves[k] = true);
        let slow = |k: usize| {
            let speed = self.velocity[k].norm();
            let sigma = (0.5 * (back[k].covariance[1][1] + back[k].covariance[3][3])).sqrt();
            !self.moves[k] && speed < SLOW_MPS && sigma < SLOW_MPS
        };
        let mut next = vec![false; count];
        let mut k = 0;
        while k < count {
            let from = k;
            while k < count && slow(k) {
                k += 1;
            }
            if k > from && seconds(from, k - 1) >= STANDS_S {
                let (a, b) = (self.at[from].time, self.at[k - 1].time);
                for j in from..k {
                    let t = self.at[j].time;
                    next[j] = t.since_s(a) >= SURE_S && b.since_s(t) >= SURE_S;
                }
            }
            k = k.max(from + 1);
        }
        self.stands = next;
    }

    /// The course at each moment: by the velocity, of what is slow by that of the nearest moment that shows one.
    fn learn_course(&mut self) {
        let count = self.at.len();
        let shown = |k: usize| {
            let v = self.velocity[k];
            let speed = v.norm();
            (!self.stands[k] && speed > COURSE_FROM_MPS && speed.is_finite()).then(|| v / speed)
        };
        let mut nearest: Vec<Option<(f64, Vector2<f64>)>> = vec![None; count];
        let mut pass = |order: &mut dyn Iterator<Item = usize>| {
            let mut last: Option<(SimTime, Vector2<f64>)> = None;
            for k in order {
                if let Some(course) = shown(k) {
                    last = Some((self.at[k].time, course));
                }
                if let Some((time, course)) = last {
                    let off = self.at[k].time.since_s(time).abs();
                    if nearest[k].is_none_or(|n| off < n.0) {
                        nearest[k] = Some((off, course));
                    }
                }
            }
        };
        pass(&mut (0..count));
        pass(&mut (0..count).rev());
        self.course = nearest.into_iter().map(|n| n.map(|n| n.1)).collect();
    }
}
