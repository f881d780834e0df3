//! Time of day and the day that it belongs to.

use crate::value::DAY_S;

/// A day, ns.
const DAY_NS: i64 = 86_400_000_000_000;

/// Turns times of day, as they arrive, into seconds that go on over midnight.
///
/// A time that lies more than half a day before the latest one is of the next day; one that lies more than half a day
/// after it is late and of the day before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwrap {
    latest_s: Option<f64>,
}

impl Unwrap {
    /// Times count from the midnight before `time_s` (which may be of any day: only nearness matters).
    #[must_use]
    pub fn near(time_s: f64) -> Self {
        Self { latest_s: Some(time_s) }
    }

    /// Seconds of this time of day since the midnight that the first one (or [`near`](Self::near)) counts from.
    pub fn seconds(&mut self, time_of_day_s: f64) -> f64 {
        let Some(latest_s) = self.latest_s else {
            self.latest_s = Some(time_of_day_s);
            return time_of_day_s;
        };
        let ahead_s = (time_of_day_s - latest_s + DAY_S / 2.0).rem_euclid(DAY_S) - DAY_S / 2.0;
        let seconds = latest_s + ahead_s;
        self.latest_s = Some(seconds.max(latest_s));
        seconds
    }
}

/// Time of day of an instant, seconds since midnight UTC, from nanoseconds since 1970.
#[must_use]
pub fn of_day_s(unix_ns: i64) -> f64 {
    unix_ns.rem_euclid(DAY_NS) as f64 / 1e9
}

/// The instant nearest to `near_ns` that is `of_day_ns` after some midnight; both in nanoseconds since one.
#[must_use]
pub fn of_some_day_ns(of_day_ns: i64, near_ns: i64) -> i64 {
    near_ns + (of_day_ns - near_ns + DAY_NS / 2).rem_euclid(DAY_NS) - DAY_NS / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn midnight_is_passed_forwards_and_back() {
        let mut unwrap = Unwrap::default();
        let heard = [86_398.0, 86_399.5, 0.25, 86_399.75, 1.0, 43_000.0, 86_000.0, 5.0];
        let seconds = heard.map(|t| unwrap.seconds(t));
        let day = 86_400.0;
        assert_eq!(
            seconds,
            [
                86_398.0,
                86_399.5,
                day + 0.25,
                86_399.75,
                day + 1.0,
                day + 43_000.0,
                day + 86_000.0,
                2.0 * day + 5.0
            ]
        );
        assert_eq!(Unwrap::near(3.0 * day - 1.0).seconds(2.0), 3.0 * day + 2.0);
        assert_eq!(Unwrap::near(3.0 * day + 1.0).seconds(86_399.0), 3.0 * day - 1.0);
    }

    #[test]
    fn a_time_of_day_is_of_the_nearest_day() {
        let (day, hour) = (DAY_NS, DAY_NS / 24);
        for (of_day, near, expected) in [
            (hour, 2 * hour, hour),
            (hour, 23 * hour, day + hour),
            (23 * hour, day + hour, 23 * hour),
            (11 * hour, 5 * day, 5 * day + 11 * hour),
            (13 * hour, 5 * day, 4 * day + 13 * hour),
        ] {
            assert_eq!(of_some_day_ns(of_day, near), expected);
        }
    }

    #[test]
    fn the_time_of_day_before_1970_is_positive() {
        assert_eq!(of_day_s(1_574_586_012_500_000_000), 32_412.5);
        assert_eq!(of_day_s(-500_000_000), 86_399.5);
    }
}
