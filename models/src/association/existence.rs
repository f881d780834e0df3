//! Whether a track has a target at all: a probability beside its state, carried through association.
//!
//! Track i exists with probability r, is detected with P_D where it is, and its plots have the density g; false plots have
//! the density λ_c. The weights of the joint events ([`super::jpda`]) are then
//!
//! ```text
//! no plot:  1 − r P_D          plot j:  r P_D g_j / λ_c(z_j)
//! r ← β₀ · r(1 − P_D)/(1 − r P_D) + (1 − β₀)          β₀ = P(no plot is its own)
//! ```
//!
//! exact for one cluster. `1 − r` is a number of its own: a track that was sure for an hour must be able to end.
//!
//! Source: Musicki, Evans, Stankovic, "Integrated probabilistic data association", IEEE Trans. AC-39 (1994); Musicki, Evans,
//! "Joint integrated probabilistic data association", IEEE Trans. AES-40 (2004).

/// Probability that a target is there, and that none is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Existence {
    there: f64,
    absent: f64,
}

/// A track is never surer than this much from one: one that is must still be able to end.
const LEAST_ABSENT: f64 = 1e-16;

/// False plots are never rarer than this, 1/m².
const LEAST_DENSITY_M2: f64 = 1e-12;

/// ln of a weight that is as good as none.
const HARDLY: f64 = -600.0;

impl Existence {
    /// With probability `there`; what is no probability is taken as its nearest end, NaN as 0.
    #[must_use]
    pub fn of(there: f64) -> Self {
        let there = if there > 0.0 { there.min(1.0) } else { 0.0 };
        Self { there, absent: (1.0 - there).max(LEAST_ABSENT) }
    }

    /// Of a track that this plot begins, which no track claims with probability `unclaimed`: new targets of `births_m2`
    /// against false plots of `false_m2` (both per square metre and look).
    #[must_use]
    pub fn born(unclaimed: f64, births_m2: f64, false_m2: f64) -> Self {
        let births = births_m2.max(0.0);
        Self::of(unclaimed * births / (births + false_m2.max(LEAST_DENSITY_M2)))
    }

    /// r.
    #[must_use]
    pub fn there(self) -> f64 {
        self.there
    }

    /// After some time that a target survives with this probability.
    #[must_use]
    pub fn survived(self, probability: f64) -> Self {
        let lost = self.there * (1.0 - probability.clamp(0.0, 1.0));
        Self { there: self.there - lost, absent: self.absent + lost }
    }

    /// `1 − r P_D`.
    fn unseen(self, detection: f64) -> f64 {
        self.absent + self.there * (1.0 - detection.clamp(0.0, 1.0))
    }

    /// ln of the weight of "no plot": `ln(1 − r P_D)`.
    #[must_use]
    pub fn log_miss(self, detection: f64) -> f64 {
        libm::log(self.unseen(detection)).max(HARDLY)
    }

    /// ln of the weight of a plot: `ln(r P_D g/λ_c)`; −∞ where it cannot be seen.
    #[must_use]
    pub fn log_pair(self, detection: f64, log_density: f64, false_m2: f64) -> f64 {
        let seen = libm::log(self.there * detection.clamp(0.0, 1.0));
        seen + log_density - libm::log(false_m2.max(LEAST_DENSITY_M2))
    }

    /// After a look of which no plot was its own with probability `missed`.
    #[must_use]
    pub fn after(self, missed: f64, detection: f64) -> Self {
        let missed = missed.clamp(0.0, 1.0);
        let unseen = self.unseen(detection);
        if !(unseen > 0.0) {
            // Certain to be there and to be seen, and not seen.
            return Self { there: 1.0 - missed, absent: missed.max(LEAST_ABSENT) };
        }
        let there = self.there * (1.0 - detection.clamp(0.0, 1.0)) / unseen;
        Self {
            there: missed * there + (1.0 - missed),
            absent: (missed * self.absent / unseen).max(LEAST_ABSENT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_was_sure_comes_down_in_as_many_misses_as_its_detection_says() {
        for detection in [0.5, 0.9, 0.99, 1.0] {
            for start in [1.0, 1.0 - 1e-16, 0.999] {
                let mut track = Existence::of(start);
                let most = (16.0 / -libm::log10(1.0 - detection)).ceil() as u32;
                for _ in 0..most.max(1) {
                    track = track.after(1.0, detection);
                }
                assert!(track.there() <= 0.5 + 1e-9, "{detection} {start}: {track:?}");
            }
        }
        assert!(
            Existence::of(1.0).after(1.0, 1.0).there() < 1e-9,
            "seen for certain, and not seen"
        );
        assert_eq!(Existence::of(0.7).after(1.0, 0.0), Existence::of(0.7), "nothing was looked at");
    }

    proptest! {
        #[test]
        fn it_is_a_probability_whatever_is_given(
            start in -1.0..2.0_f64,
            steps in proptest::collection::vec((0.0..1.0_f64, 0.0..=1.0_f64, 0.0..=1.0_f64), 1..40),
        ) {
            let mut track = Existence::of(start);
            for (missed, detection, survival) in steps {
                let before = track;
                track = track.after(missed, detection);
                let unseen = before.after(1.0, detection);
                prop_assert!(unseen.there() <= before.there() + 1e-12);
                prop_assert!(before.after(0.0, detection).there() >= before.there() - 1e-12);
                track = track.survived(survival);
                prop_assert!((0.0..=1.0).contains(&track.there()) && track.absent > 0.0);
                prop_assert!((track.there() + track.absent - 1.0).abs() < 1e-9);
                prop_assert!(track.log_miss(detection).is_finite());
            }
        }
    }

    #[test]
    fn a_look_is_answered_by_the_rule_of_bayes() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
        let even = Existence::of(0.5);
        // Unseen: it is there and was missed in one case of ten, absent in five.
        close(even.after(1.0, 0.8).there(), 1.0 / 6.0);
        close(even.after(1.0, 0.8).absent, 5.0 / 6.0);
        close(even.after(0.25, 0.8).there(), 0.25 / 6.0 + 0.75);
        close(even.after(0.25, 0.8).absent, 0.25 * 5.0 / 6.0);
        close(even.after(7.0, 1.5).there(), 0.0);
        close(even.survived(0.9).there(), 0.45);
        close(even.survived(0.9).absent, 0.55);
        close(even.survived(-2.0).there(), 0.0);
        close(even.survived(2.0).there(), 0.5);
        close(even.log_miss(0.8), -0.510_825_623_765_990_7);
        // ln(0.5 · 0.8 · e⁻³ / 10⁻⁶).
        close(even.log_pair(0.8, -3.0, 1e-6), 9.899_219_826_089_98);
        close(even.log_pair(5.0, -3.0, 1e-6) - even.log_pair(1.0, -3.0, 1e-6), 0.0);
        // False plots are never rarer than 10⁻¹² a square metre.
        close(even.log_pair(0.8, 0.0, 1e-30), even.log_pair(0.8, 0.0, 1e-12));
        close(Existence::born(0.5, 3e-6, 1e-6).there(), 0.375);
        close(Existence::born(1.0, 1e-12, 0.0).there(), 0.5);
        close(Existence::born(1.0, -1.0, 1e-6).there(), 0.0);
        assert_eq!(Existence::of(2.0).there(), 1.0);
        // Neither certainty is for ever.
        assert_eq!(
            (Existence::of(1.0).absent, Existence::of(1.0).log_miss(1.0)),
            (1e-16, libm::log(1e-16))
        );
        assert_eq!(Existence { there: 1.0, absent: 0.0 }.log_miss(1.0), HARDLY);
        let impossible = Existence { there: 1.0, absent: 0.0 }.after(0.25, 1.0);
        assert_eq!(impossible, Existence { there: 0.75, absent: 0.25 });
        assert_eq!(even.after(0.0, 0.8), Existence { there: 1.0, absent: 1e-16 });
    }

    #[test]
    fn no_number_leads_to_none() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            assert!((0.0..=1.0).contains(&Existence::of(bad).there()), "{bad}");
        }
        assert_eq!(Existence::of(f64::NAN).there(), 0.0);
        assert!(Existence::born(1.0, 1e-9, 0.0).there() > 0.99);
        assert_eq!(Existence::born(1.0, 0.0, 1e-8).there(), 0.0);
        assert_eq!(Existence::of(0.5).log_pair(0.0, -3.0, 1e-8), f64::NEG_INFINITY);
    }
}
