//! Simulated time: whole nanoseconds since the start of the run.

/// A point in simulated time, nanoseconds since frame 0 of the run (UTC of frame 0 is in the scene).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SimTime(pub i64);

impl SimTime {
    /// Frame 0.
    pub const ZERO: Self = Self(0);

    /// Nearest nanosecond to `s` seconds; `s` must be finite and within ±292 years.
    #[must_use]
    pub fn from_s(s: f64) -> Self {
        debug_assert!(s.is_finite());
        Self((s * 1e9).round() as i64)
    }

    /// Seconds since the start of the run, for formulas and display.
    #[must_use]
    pub fn s(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Seconds from `earlier` to `self`: the integers are subtracted, then converted once.
    #[must_use]
    pub fn since_s(self, earlier: Self) -> f64 {
        (self.0 - earlier.0) as f64 * 1e-9
    }

    /// `self` moved by `s` seconds, nearest nanosecond.
    #[must_use]
    pub fn plus_s(self, s: f64) -> Self {
        Self(self.0 + Self::from_s(s).0)
    }
}
