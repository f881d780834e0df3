//! When flights by rates come: rates by hour of the run, drawn, even, or in banks.

use crate::document::{Section, within};
use crate::error::ScenarioError;
use models::traffic::core::Direction;

/// Flights an hour, as a function of time.
#[derive(Clone, Debug)]
pub(super) struct Rates {
    /// By hour of the run; the last one holds from then on.
    per_h: Vec<f64>,
    /// The third of each hour in which all of them come, at three times the rate.
    third: Option<usize>,
}

const HOUR_S: f64 = 3600.0;

impl Rates {
    /// Reads a key: a rate, or one for each hour.
    pub(super) fn read(
        section: &Section,
        key: &str,
        direction: Direction,
        banks: bool,
    ) -> Result<Self, ScenarioError> {
        let per_h = section.number_or_numbers(key, within(0.0, 2000.0, "flights/h"))?;
        // A bank: who comes stays while the others come, and all leave after it (assumed).
        let third = banks.then_some(if direction == Direction::Arrival { 0 } else { 2 });
        Ok(Self { per_h, third })
    }

    /// Whether anybody comes at all.
    pub(super) fn any(&self) -> bool {
        self.per_h.iter().any(|rate| *rate > 0.0)
    }

    /// When `count` more flights are expected than at a time, s; infinity if that is never or after `end_s`.
    pub(super) fn after_s(&self, from_s: f64, count: f64, end_s: f64) -> f64 {
        let (mut time_s, mut left) = (from_s, count);
        while time_s <= end_s {
            let (rate_per_h, until_s) = self.at(time_s);
            let here = match rate_per_h > 0.0 {
                true => (until_s - time_s) * rate_per_h / HOUR_S,
                false => 0.0,
            };
            if left <= here {
                return time_s + left * HOUR_S / rate_per_h;
            }
            (time_s, left) = (until_s, left - here);
        }
        f64::INFINITY
    }

    /// The rate at a time, flights/h, and until when it holds, s.
    fn at(&self, time_s: f64) -> (f64, f64) {
        let Some(last) = self.per_h.len().checked_sub(1) else { return (0.0, f64::INFINITY) };
        let third_s = HOUR_S / 3.0;
        let slot = (time_s / third_s).max(0.0) as usize;
        let rate = self.per_h[(slot / 3).min(last)];
        match self.third {
            Some(third) => {
                let rate = if slot % 3 == third { 3.0 * rate } else { 0.0 };
                (rate, (slot + 1) as f64 * third_s)
            }
            None if slot / 3 >= last => (rate, f64::INFINITY),
            None => (rate, (slot / 3 + 1) as f64 * HOUR_S),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(per_h: &[f64], third: Option<usize>) -> Rates {
        Rates { per_h: per_h.to_vec(), third }
    }

    /// How many are expected before a time, by sums of small steps.
    fn expected(rates: &Rates, to_s: f64) -> f64 {
        let steps = 400_000;
        let dt = to_s / f64::from(steps);
        (0..steps).map(|k| rates.at((f64::from(k) + 0.5) * dt).0 * dt / HOUR_S).sum()
    }

    #[test]
    fn as_many_come_as_the_rates_of_the_hours_add_up_to() {
        for third in [None, Some(0), Some(2)] {
            for per_h in [&[30.0][..], &[10.0, 0.0, 45.0], &[0.0, 7.5], &[60.0, 1.0]] {
                let rates = rates(per_h, third);
                for count in [0.4, 3.0, 17.0, 60.0] {
                    let at_s = rates.after_s(0.0, count, 1e6);
                    let found = expected(&rates, at_s);
                    assert!(
                        (found - count).abs() < 0.02,
                        "{per_h:?} {third:?}: {found} of {count}"
                    );
                }
            }
        }
    }

    #[test]
    fn nobody_comes_in_an_hour_without_any_nor_after_the_end() {
        let shut = rates(&[20.0, 0.0, 20.0], None);
        let mut time_s = 0.0;
        for _ in 0..200 {
            time_s = shut.after_s(time_s, 0.31, 20_000.0);
            assert!(!(3600.5..7200.0).contains(&time_s), "{time_s} s");
        }
        assert_eq!(rates(&[5.0, 0.0], None).after_s(0.0, 6.0, 1e5), f64::INFINITY);
        assert_eq!(rates(&[], None).after_s(0.0, 1.0, 1e5), f64::INFINITY);
        let bank = rates(&[12.0], Some(2));
        let first_s = bank.after_s(0.0, 0.01, 1e5);
        assert!((2400.0..2500.0).contains(&first_s), "{first_s} s");
    }
}
