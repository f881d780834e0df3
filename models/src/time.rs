//! Simulated time: whole nanoseconds since the start of the run.

/// A point in simulated time, nanoseconds since frame 0 of the run (UTC of frame 0 is in the scene).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SimTime(pub i64);

impl SimTime {
    /// Frame 0.
    pub const ZERO: Self = Self(0);

    /// Nearest nanosecond to `s` seconds; `s` must be finite and within ±292 years.
    #[must_use]
    #[inline]
    pub fn from_s(s: f64) -> Self {
        debug_assert!(s.is_finite());
        // `round`, half away from zero, without a call: the difference from the whole number is exact.
        let ns = s * 1e9;
        let whole = ns as i64;
        let rest = ns - whole as f64;
        Self(whole.saturating_add(i64::from(rest >= 0.5) - i64::from(rest <= -0.5)))
    }

    /// Seconds since the start of the run, for formulas and display.
    #[must_use]
    pub fn s(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Seconds from `earlier` to `self`: the integers are subtracted, then converted once. Two times that
    /// are farther apart than 292 years are 292 years apart.
    #[must_use]
    #[inline]
    pub fn since_s(self, earlier: Self) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 * 1e-9
    }

    /// The earliest time from which not more than `s` seconds passed until `self`, by [`Self::since_s`]: of many times
    /// that are asked for the same, each is one comparison. `s` as for [`Self::from_s`].
    #[must_use]
    pub fn back_s(self, s: f64) -> Self {
        let mut ns = Self::from_s(s).0;
        while ns as f64 * 1e-9 > s {
            ns -= 1;
        }
        while let Some(more) = ns.checked_add(1).filter(|more| *more as f64 * 1e-9 <= s) {
            ns = more;
        }
        Self(self.0.saturating_sub(ns))
    }

    /// `self` moved by `s` seconds, nearest nanosecond; not beyond 292 years from frame 0.
    #[must_use]
    #[inline]
    pub fn plus_s(self, s: f64) -> Self {
        Self(self.0.saturating_add(Self::from_s(s).0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn seconds_become_the_nearest_nanosecond(
            s in prop_oneof![-1e10..1e10f64, -1e-6..1e-6f64, -1e300..1e300f64],
            halves in -1_000_000i64..1_000_000,
        ) {
            prop_assert_eq!(SimTime::from_s(s).0, (s * 1e9).round() as i64);
            let half = halves as f64 / 2e9;
            prop_assert_eq!(SimTime::from_s(half).0, (half * 1e9).round() as i64);
        }

        #[test]
        fn what_is_within_so_many_seconds_is_not_before_the_time_back(
            now in 0i64..1_000_000_000_000_000,
            s in prop_oneof![0.0..1e3f64, (0u32..10_000).prop_map(|tenths| f64::from(tenths) / 10.0)],
            off_ns in -3i64..4,
        ) {
            let (now, earlier) = (SimTime(now), SimTime(now - SimTime::from_s(s).0 + off_ns));
            prop_assert_eq!(earlier >= now.back_s(s), now.since_s(earlier) <= s);
        }
    }
}
