//! Least and largest value of what is bounded.

/// Least and largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// Least.
    pub low: f64,
    /// Largest.
    pub high: f64,
}

impl Span {
    /// Of some values; not-a-number makes both ends not a number.
    #[must_use]
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let none = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };
        values.fold(none, |span, value| {
            if value.is_nan() {
                Self { low: f64::NAN, high: f64::NAN }
            } else {
                Self { low: span.low.min(value), high: span.high.max(value) }
            }
        })
    }

    /// Whether a value is between both ends, or at one.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    /// The difference of two that know nothing of each other.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        Self { low: self.low - other.high, high: self.high - other.low }
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}
