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

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all scores from 0 to 3 of four rungs: up to the best of the dearer ones only by more than the hurdle, down to the best of
    /// the cheaper ones as soon as it is as good; of equals the cheapest.
    #[test]
    fn a_rung_is_left_for_a_better_one_by_its_hurdle() {
        for code in 0..256u32 {
            let scores: Vec<f64> = (0..4).map(|k| f64::from(code >> (2 * k) & 3)).collect();
            let mut choice = Choice::new(4);
            choice.add(1.0, &scores);
            for (now, hurdle) in [(0, 0.5), (1, 0.5), (2, 1.0), (3, 1.5), (1, 1.5)] {
                let first_best = |from: usize, to: usize| {
                    let best = (from..to).map(|k| scores[k]).fold(f64::NEG_INFINITY, f64::max);
                    (from..to).find(|k| scores[*k] == best)
                };
                let cheap = first_best(0, now).filter(|k| scores[*k] >= scores[now]);
                let base = cheap.unwrap_or(now);
                let least = scores[now].max(scores[base]) + hurdle;
                let dear = first_best(now + 1, 4).filter(|k| scores[*k] > least);
                assert_eq!(choice.choose(now, hurdle), dear.unwrap_or(base), "{scores:?} {now}");
            }
        }
        // What was counts less with time, and no density costs more than the floor.
        let mut choice = Choice::new(2);
        choice.add(0.5, &[-2.0, f64::NAN]);
        choice.add(0.5, &[-1.0, -3.0]);
        let weights = choice.weights();
        assert!((choice.scores[0] + 2.0).abs() < 1e-12 && choice.scores[1] == 0.5 * FLOOR - 3.0);
        assert!((weights[0] - 1.0).abs() < 1e-12 && weights[1] == 0.0);
    }
}
