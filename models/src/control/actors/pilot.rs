//! Pilots and drivers: how long they take to answer and to act, and how often they hear wrong.

use super::message::{MessageKind, words};
use crate::control::clearance::ClearanceKind;
use crate::draw::{normal_pair, uniform};
use rand::rngs::ChaCha8Rng;

/// Times and errors of speaking people (assumed; `docs/control.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Habits {
    /// A transmission takes this, s,
    pub key_s: f64,
    /// and for each word, s.
    pub word_s: f64,
    /// A readback begins after (median, s, and σ of its logarithm).
    pub readback_s: [f64; 2],
    /// What was cleared begins after the readback.
    pub action_s: [f64; 2],
    /// A controller thinks before he speaks.
    pub think_s: [f64; 2],
    /// Share of clearances that are read back wrong.
    pub wrong: f64,
    /// Share of these that the controller notices.
    pub noticed: f64,
    /// A clearance that nobody acts upon is said again after, s.
    pub again_s: f64,
}

impl Default for Habits {
    fn default() -> Self {
        Self {
            key_s: 1.5,
            word_s: 0.35,
            readback_s: [1.0, 0.4],
            action_s: [2.5, 0.5],
            think_s: [1.5, 0.4],
            wrong: 0.006,
            noticed: 0.9,
            again_s: 30.0,
        }
    }
}

impl Habits {
    /// How long a message is on the air, s.
    #[must_use]
    pub fn speaks_s(&self, kind: MessageKind, about: ClearanceKind) -> f64 {
        self.key_s + self.word_s * f64::from(words(kind, about))
    }
}

/// A lognormal time of (median, σ of the logarithm), s.
#[must_use]
pub fn lognormal_s([median_s, sigma]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    median_s * libm::exp(sigma * normal_pair(rng).0)
}

/// How one clearance is answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// From the last word of the clearance to the first of the readback, s.
    pub readback_after_s: f64,
    /// From the last word of the readback to the action, s.
    pub acts_after_s: f64,
    /// Read back wrong, and whether the controller hears it.
    pub wrong: Option<bool>,
}

/// Draws the answer to a clearance.
#[must_use]
pub fn answer(habits: &Habits, rng: &mut ChaCha8Rng) -> Answer {
    let readback_after_s = lognormal_s(habits.readback_s, rng);
    let acts_after_s = lognormal_s(habits.action_s, rng);
    let wrong = (uniform(rng) < habits.wrong).then(|| uniform(rng) < habits.noticed);
    Answer { readback_after_s, acts_after_s, wrong }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose};

    #[test]
    fn medians_spreads_and_errors_are_those_of_the_table() {
        let habits = Habits::default();
        let count = 40_000;
        let mut answers: Vec<Answer> = (0..count)
            .map(|i| {
                let key = DrawKey { run_seed: 7, sensor: 0, entity: i, scan: 0 };
                answer(&habits, &mut key.rng(Purpose::Mover))
            })
            .collect();
        let wrong = answers.iter().filter(|a| a.wrong.is_some()).count() as f64;
        let noticed = answers.iter().filter(|a| a.wrong == Some(true)).count() as f64;
        // Four standard deviations of a count.
        let expected = habits.wrong * count as f64;
        assert!((wrong - expected).abs() < 4.0 * expected.sqrt(), "{wrong} of {expected}");
        let sigma = (0.9 * 0.1 / wrong).sqrt();
        assert!((noticed / wrong - 0.9).abs() < 4.0 * sigma, "{noticed} of {wrong}");
        for (of, [median, sigma]) in [
            ((|a| a.readback_after_s) as fn(&Answer) -> f64, habits.readback_s),
            (|a| a.acts_after_s, habits.action_s),
        ] {
            answers.sort_by(|a, b| of(a).total_cmp(&of(b)));
            let at = |p: f64| of(&answers[(p * count as f64) as usize]);
            assert!((at(0.5) / median - 1.0).abs() < 0.02, "{}", at(0.5));
            let high = median * libm::exp(sigma);
            assert!((at(0.8413) / high - 1.0).abs() < 0.02, "{} {high}", at(0.8413));
        }
    }

    #[test]
    fn a_transmission_takes_its_key_and_its_words() {
        let habits = Habits::default();
        let taxi_s = habits.speaks_s(MessageKind::Clearance, ClearanceKind::Taxi);
        assert!((taxi_s - 5.7).abs() < 1e-12, "{taxi_s}");
    }
}
