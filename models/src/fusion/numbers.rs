//! Track numbers: the next free one after the last given, cyclically, with a rest after use.

use crate::time::SimTime;

/// The pool of numbers.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    /// When each number may be given (again); `SimTime(i64::MAX)` while in use.
    free_from: Vec<SimTime>,
    next: usize,
    rest_s: f64,
}

impl Numbers {
    /// Numbers 0 to `count − 1` (at most 65 536), each resting `rest_s` seconds after use.
    pub(super) fn new(count: u32, rest_s: f64) -> Self {
        let count = (count as usize).clamp(1, 1 << 16);
        Self { free_from: vec![SimTime(i64::MIN); count], next: 0, rest_s }
    }

    /// The next number that is free and rested at `now`.
    pub(super) fn take(&mut self, now: SimTime) -> Option<u16> {
        let count = self.free_from.len();
        let number =
            (0..count).map(|k| (self.next + k) % count).find(|&n| self.free_from[n] <= now)?;
        self.free_from[number] = SimTime(i64::MAX);
        self.next = (number + 1) % count;
        Some(number as u16)
    }

    /// The number's track is gone.
    pub(super) fn give_back(&mut self, number: u16, now: SimTime) {
        self.free_from[number as usize] = now.plus_s(self.rest_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_round_rest_and_run_out() {
        let mut numbers = Numbers::new(3, 60.0);
        let at = SimTime::from_s;
        assert_eq!([0, 1, 2].map(|_| numbers.take(at(0.0))), [Some(0), Some(1), Some(2)]);
        assert_eq!(numbers.take(at(0.0)), None);
        numbers.give_back(1, at(5.0));
        assert_eq!(numbers.take(at(64.0)), None, "still resting");
        assert_eq!(numbers.take(at(65.0)), Some(1));
    }
}
