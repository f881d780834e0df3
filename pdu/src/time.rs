//! The timestamp of the header: time past the hour, in whole numbers only.

use crate::wire::Wire;

/// Units in an hour: one is 3600 s / (2³¹ − 1), about 1.68 µs. Source: IEEE 1278.1-2012, 6.2.88.
const UNITS_PER_HOUR: u32 = (1 << 31) - 1;
/// Nanoseconds in an hour.
pub const NANOS_PER_HOUR: u64 = 3_600_000_000_000;

/// A timestamp: 31 bits of units past the hour, and in the lowest bit whether the sender's clock is
/// synchronised to UTC (absolute) or not (relative).
///
/// ```
/// use pdu::DisTime;
/// let t = DisTime::absolute(3_599_999_999_999); // the last nanosecond of an hour
/// assert_eq!(t, DisTime::absolute(0)); // is the next hour
/// let later = DisTime::absolute(10_000_000);
/// assert_eq!(later.nanos_since(t), 9_999_610); // 5965 whole units of 1.68 µs
/// ```
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct DisTime(
    /// The word on the wire.
    pub u32,
);

impl DisTime {
    /// The timestamp nearest to `nanos` (any count of nanoseconds since some full hour; whole hours
    /// do not matter) of a clock synchronised to UTC.
    #[must_use]
    pub fn absolute(nanos: u64) -> Self {
        Self(units_nearest(nanos) << 1 | 1)
    }

    /// The timestamp nearest to `nanos` of a clock of the sender's own.
    #[must_use]
    pub fn relative(nanos: u64) -> Self {
        Self(units_nearest(nanos) << 1)
    }

    /// The last absolute timestamp that is not after `nanos`.
    #[must_use]
    pub fn absolute_not_after(nanos: u64) -> Self {
        let past_hour = nanos % NANOS_PER_HOUR;
        let units = u128::from(past_hour) * u128::from(UNITS_PER_HOUR) / u128::from(NANOS_PER_HOUR);
        Self((units as u32) << 1 | 1)
    }

    /// A timestamp of so many units (modulo one hour).
    #[must_use]
    pub fn from_units(units: u32, absolute: bool) -> Self {
        Self((units % UNITS_PER_HOUR) << 1 | u32::from(absolute))
    }

    /// True if the sender's clock is synchronised to UTC.
    #[must_use]
    pub fn is_absolute(self) -> bool {
        self.0 & 1 == 1
    }

    /// Units of 3600 s / (2³¹ − 1) past the hour, 0 to 2³¹ − 1 as on the wire.
    #[must_use]
    pub fn units(self) -> u32 {
        self.0 >> 1
    }

    /// Nearest nanosecond past the hour, below one hour.
    #[must_use]
    pub fn nanos_past_hour(self) -> u64 {
        let scaled = u128::from(self.units() % UNITS_PER_HOUR) * u128::from(NANOS_PER_HOUR);
        ((scaled + u128::from(UNITS_PER_HOUR / 2)) / u128::from(UNITS_PER_HOUR)) as u64
    }

    /// Units from `earlier` to `self`, taken the shorter way around the hour.
    #[must_use]
    pub fn units_since(self, earlier: Self) -> i32 {
        let hour = i64::from(UNITS_PER_HOUR);
        let ahead = (i64::from(self.units()) - i64::from(earlier.units())).rem_euclid(hour);
        (if ahead > hour / 2 { ahead - hour } else { ahead }) as i32
    }

    /// Nanoseconds (nearest) from `earlier` to `self`, taken the shorter way around the hour.
    #[must_use]
    pub fn nanos_since(self, earlier: Self) -> i64 {
        let scaled = i128::from(self.units_since(earlier)) * i128::from(NANOS_PER_HOUR);
        let half = i128::from(UNITS_PER_HOUR / 2) * scaled.signum();
        ((scaled + half) / i128::from(UNITS_PER_HOUR)) as i64
    }

    /// Seconds from `earlier` to `self`, taken the shorter way around the hour; correctly rounded.
    #[must_use]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        (i64::from(self.units_since(earlier)) * 3600) as f64 / f64::from(UNITS_PER_HOUR)
    }

    /// The time nearest to `reference_nanos` that has this timestamp. Both count nanoseconds from the
    /// same full hour and may be negative; this is how a receiver gets back the simulated time that
    /// the hour's wrap has cut off.
    #[must_use]
    pub fn near(self, reference_nanos: i64) -> i64 {
        let hour = NANOS_PER_HOUR as i64;
        let ahead = (self.nanos_past_hour() as i64 - reference_nanos.rem_euclid(hour)) % hour;
        let shortest = if ahead > hour / 2 {
            ahead - hour
        } else if ahead < -hour / 2 {
            ahead + hour
        } else {
            ahead
        };
        reference_nanos.saturating_add(shortest)
    }
}

/// Nearest unit past the hour, below one hour.
fn units_nearest(nanos: u64) -> u32 {
    let scaled = u128::from(nanos % NANOS_PER_HOUR) * u128::from(UNITS_PER_HOUR);
    let nearest = (scaled + u128::from(NANOS_PER_HOUR / 2)) / u128::from(NANOS_PER_HOUR);
    (nearest % u128::from(UNITS_PER_HOUR)) as u32
}

impl std::fmt::Debug for DisTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "DisTime({self} ({}))", self.0)
    }
}

impl std::fmt::Display for DisTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let nanos = self.nanos_past_hour();
        let (s, us) = (nanos / 1_000_000_000, nanos % 1_000_000_000 / 1000);
        let mark = if self.is_absolute() { "" } else { " relative" };
        write!(f, "{:02}:{:02}.{us:06}{mark}", s / 60, s % 60)
    }
}

impl Wire for DisTime {
    const SIZE: usize = 4;
    #[inline(always)]
    fn get(octets: &[u8]) -> Self {
        Self(u32::get(octets))
    }
    #[inline(always)]
    fn put(&self, octets: &mut [u8]) {
        self.0.put(octets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_hour_wraps() {
        let before = DisTime::absolute(NANOS_PER_HOUR - 5_000_000);
        let after = DisTime::absolute(NANOS_PER_HOUR + 5_000_000);
        assert!((after.nanos_since(before) - 10_000_000).abs() < 1700);
        assert!((before.nanos_since(after) + 10_000_000).abs() < 1700);
        assert!((after.seconds_since(before) - 0.01).abs() < 2e-6);
        // 2³¹ − 1 on the wire (senders that take 2³¹ units for an hour) is the full hour.
        assert_eq!(DisTime(u32::MAX).nanos_past_hour(), 0);
        assert_eq!(DisTime(u32::MAX).units_since(DisTime(1)), 0);
        assert_eq!(DisTime(u32::MAX).to_string(), "00:00.000000");
        assert_eq!(DisTime::relative(61_500_000_000).to_string(), "01:01.500000 relative");
    }

    #[test]
    fn frames_have_their_own_timestamps_for_three_hours() {
        for frame in 0..3 * 3600 * 20_i64 {
            let nanos = frame * 50_000_000;
            let stamp = DisTime::absolute(nanos as u64);
            let back = stamp.near(nanos + 1_000_000_000);
            assert_eq!((back + 25_000_000).div_euclid(50_000_000), frame);
            assert!((back - nanos).abs() <= 839);
        }
    }

    proptest! {
        #[test]
        fn nearest_is_nearest(nanos in 0..NANOS_PER_HOUR) {
            let t = DisTime::absolute(nanos);
            let miss = t.near(nanos as i64) - nanos as i64;
            prop_assert!(miss.abs() <= 839, "{miss}");
            let floor = DisTime::absolute_not_after(nanos);
            let behind = nanos as i64 - floor.near(nanos as i64);
            prop_assert!((-1..=1677).contains(&behind), "{behind}");
        }

        #[test]
        fn near_is_within_half_an_hour(word: u32, reference in -10_i64.pow(16)..10_i64.pow(16)) {
            let back = DisTime(word).near(reference);
            prop_assert!((back - reference).abs() <= NANOS_PER_HOUR as i64 / 2 + 1);
            prop_assert_eq!(back.rem_euclid(NANOS_PER_HOUR as i64),
                DisTime(word).nanos_past_hour() as i64);
        }

        #[test]
        fn differences_are_antisymmetric(a: u32, b: u32) {
            let (a, b) = (DisTime(a), DisTime(b));
            prop_assert_eq!(a.units_since(b), -b.units_since(a));
            prop_assert_eq!(a.nanos_since(b), -b.nanos_since(a));
        }
    }
}
