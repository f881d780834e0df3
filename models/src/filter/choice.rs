//! Which of several rungs the plots justify: by the likelihood that each gave them, discounted.
//!
//! `s_r ← λ s_r + ℓ_r`, `w_r ∝ exp(s_r − max s)`; ℓ the normalised log density of a plot, mode priors included. A likelihood
//! needs no truth, so a track finds its own best rung as it goes.

/// Least log density of one plot: a rung that diverges must not take the weights with it.
pub const FLOOR: f64 = -1e4;

/// Discounted log likelihoods of the rungs, the cheapest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    scores: Vec<f64>,
}

impl Choice {
    /// `rungs` of equal standing.
    #[must_use]
    pub fn new(rungs: usize) -> Self {
        Self { scores: vec![0.0; rungs] }
    }

    /// Takes the log densities of a plot; what was before counts `kept` (λ to the power of the time in between).
    pub fn add(&mut self, kept: f64, logs: &[f64]) {
        for (score, log) in self.scores.iter_mut().zip(logs) {
            // NaN is no density.
            let log = if *log > FLOOR { *log } else { FLOOR };
            *score = kept * *score + log;
        }
    }

    /// Weights of sum 1.
    #[must_use]
    pub fn weights(&self) -> Vec<f64> {
        let most = self.scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut weights: Vec<f64> = self.scores.iter().map(|s| libm::exp(s - most)).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        weights
    }

    /// The rung to use after `now`: the best of the dearer ones if it is better by `switch_up`, a cheaper one as soon as
    /// it is as good.
    #[must_use]
    pub fn choose(&self, now: usize, switch_up: f64) -> usize {
        let best = |from: usize, to: usize| {
            // Of equals the first, which is the cheapest.
            (from..to).rev().max_by(|&a, &b| self.scores[a].total_cmp(&self.scores[b]))
        };
        let cheaper = best(0, now).filter(|&k| self.scores[k] >= self.scores[now]);
        let dearer = best(now + 1, self.scores.len())
            .filter(|&k| self.scores[k] > self.scores[now] + switch_up);
        match (cheaper, dearer) {
            (Some(cheap), Some(dear)) if self.scores[dear] > self.scores[cheap] + switch_up => dear,
            (Some(cheap), _) => cheap,
            (None, Some(dear)) => dear,
            (None, None) => now,
        }
    }
}
