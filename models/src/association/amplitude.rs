//! What the strength of an echo says of whether it has a target: stronger ones than noise makes at the threshold hardly ever are false.
//!
//! `LR = p₁(χ)/p₀(χ)`, χ the signal-to-noise ratio that the plot states, t the least one, e the mean by which noise that crosses the
//! threshold is above it:
//!
//! ```text
//! p₀ = exp(−(χ − t)/e)/e                                     noise: sums of exponential powers, above the threshold
//! p₁ = Σ w_S exp(−(χ − t)/(S + e))/(S + e),  w_S ∝ P_D(S) = exp(−t/(S + e))      targets of mean ratio S, Swerling 1
//! ```
//!
//! S from 8 dB below t to 40 dB above, all alike: small and distant targets are among them. LR is held within [0.3, 30], as neither
//! law is known better. Source: D. Lerro, Y. Bar-Shalom, "Interacting multiple model tracking with target amplitude feature", IEEE Trans.
//! AES-29 (1993).

/// Where the strengths of a sensor's plots begin, and how far noise reaches above that; ratios per pulse, not decibels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmplitudeLaw {
    /// Least ratio of a plot.
    pub threshold: f64,
    /// Mean excess of false plots over it.
    pub noise: f64,
}

/// Limits of the ratio of the likelihoods.
pub const LIMITS: [f64; 2] = [0.3, 30.0];

/// Mean ratios of targets over the threshold, dB: from, step, how many.
const MEANS_DB: (f64, f64, u32) = (-8.0, 4.0, 13);

impl AmplitudeLaw {
    /// ln of how much likelier a plot of this ratio is of a target than of noise; 0 where a number is unsound.
    #[must_use]
    pub fn log_ratio(&self, ratio: f64) -> f64 {
        let above = (ratio - self.threshold).max(0.0);
        let sound = ratio.is_finite() && self.threshold > 0.0 && self.noise > 0.0;
        if !(sound && self.threshold.is_finite() && self.noise.is_finite()) {
            return 0.0;
        }
        let (from, step, count) = MEANS_DB;
        // ln p₁ by the largest of its terms, as all may be below what a double holds.
        let mut largest = f64::NEG_INFINITY;
        let (mut sum, mut weights) = (0.0, 0.0);
        for k in 0..count {
            let db = from + step * f64::from(k);
            let mean = self.threshold * libm::pow(10.0, 0.1 * db) + self.noise;
            let detected = -self.threshold / mean;
            weights += libm::exp(detected);
            let term = detected - above / mean - libm::log(mean);
            if term > largest {
                sum = sum * libm::exp(largest - term) + 1.0;
                largest = term;
            } else {
                sum += libm::exp(term - largest);
            }
        }
        let of_targets = largest + libm::log(sum) - libm::log(weights);
        let of_noise = -above / self.noise - libm::log(self.noise);
        let [least, most] = LIMITS.map(libm::log);
        (of_targets - of_noise).clamp(least, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, exponential};

    const LAW: AmplitudeLaw = AmplitudeLaw { threshold: 18.0, noise: 1.0 };

    /// The mean over noise of a ratio of likelihoods is 1 where nothing holds it: with the limits it is below; over targets its logarithm
    /// is positive, of the weak ones too.
    #[test]
    fn noise_loses_and_targets_win_weak_ones_included() {
        let mut rng = DrawKey { run_seed: 4, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
        let mut mean = |scale: f64| {
            let draws = 4_000;
            let sum = |_| LAW.log_ratio(LAW.threshold + scale * exponential(&mut rng));
            (0..draws).map(sum).sum::<f64>() / f64::from(draws)
        };
        assert!(mean(LAW.noise) < -1.0);
        for (mean_ratio, least) in [(18.0, 1.0), (60.0, 2.0), (1_800.0, 3.0)] {
            let found = mean(mean_ratio + LAW.noise);
            assert!(found > least, "{mean_ratio}: {found}");
        }
        // A look in twenty of true ones is weaker than 13 dB: it costs no more than one at the limit.
        assert_eq!(LAW.log_ratio(18.0), libm::log(0.3));
    }

    #[test]
    fn it_rises_with_the_strength_within_its_limits_and_unsound_numbers_say_nothing() {
        let mut before = f64::NEG_INFINITY;
        for k in 0..400 {
            let now = LAW.log_ratio(10.0 + f64::from(k) * f64::from(k));
            assert!(now >= before && now >= libm::log(0.3) && now <= libm::log(30.0));
            before = now;
        }
        assert_eq!(before, libm::log(30.0));
        assert_eq!(LAW.log_ratio(1e300), libm::log(30.0));
        let strange = [0.0, -1.0, f64::NAN, f64::INFINITY];
        for number in strange {
            assert_eq!(AmplitudeLaw { threshold: number, ..LAW }.log_ratio(25.0), 0.0);
            assert_eq!(AmplitudeLaw { noise: number, ..LAW }.log_ratio(25.0), 0.0);
        }
        assert_eq!([f64::NAN, f64::INFINITY].map(|ratio| LAW.log_ratio(ratio)), [0.0; 2]);
        // By hand, where no limit holds it: 6 above the threshold.
        let means: Vec<f64> =
            (0..13).map(|k| 18.0 * libm::pow(10.0, -0.8 + 0.4 * f64::from(k)) + 1.0).collect();
        let weights: f64 = means.iter().map(|m| libm::exp(-18.0 / m)).sum();
        let of_targets: f64 = means.iter().map(|m| libm::exp(-24.0 / m) / m).sum::<f64>() / weights;
        let by_hand = libm::log(of_targets) + 6.0;
        assert!((LAW.log_ratio(24.0) - by_hand).abs() < 1e-12 && by_hand.abs() < 1.2, "{by_hand}");
    }
}
