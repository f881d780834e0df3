//! Track numbers: the next free one after the last given, cyclically, with a rest after use.

use crate::time::SimTime;

/// The pools of numbers: 0 to `count − 1` for what is ours, as many behind them for tracks that plots
/// of outsiders begin, so that outsiders take no number from us.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    ours: Pool,
    outside: Pool,
}

#[derive(Clone, Debug)]
struct Pool {
    first: usize,
    /// When each number may be given (again); `SimTime(i64::MAX)` while in use.
    free_from: Vec<SimTime>,
    next: usize,
    rest_s: f64,
}

impl Numbers {
    /// Numbers 0 to `count − 1` (at most 65 536), each resting `rest_s` seconds after use.
    pub(super) fn new(count: u32, rest_s: f64) -> Self {
        let count = (count as usize).clamp(1, 1 << 16);
        let pool = |first: usize, count: usize| Pool {
            first,
            free_from: vec![SimTime(i64::MIN); count],
            next: 0,
            rest_s,
        };
        Self { ours: pool(0, count), outside: pool(count, count.min((1 << 16) - count)) }
    }

    /// The next number that is free and rested at `now`, for a track of ours or of an outsider.
    pub(super) fn take(&mut self, now: SimTime, outside: bool) -> Option<u16> {
        if outside { self.outside.take(now) } else { self.ours.take(now) }
    }

    /// The number's track is gone.
    pub(super) fn give_back(&mut self, number: u16, now: SimTime) {
        let outside = usize::from(number) >= self.outside.first;
        let pool = if outside { &mut self.outside } else { &mut self.ours };
        pool.free_from[usize::from(number) - pool.first] = now.plus_s(pool.rest_s);
    }
}

impl Pool {
    fn take(&mut self, now: SimTime) -> Option<u16> {
        let count = self.free_from.len();
        let number =
            (0..count).map(|k| (self.next + k) % count).find(|&n| self.free_from[n] <= now)?;
        self.free_from[number] = SimTime(i64::MAX);
        self.next = (number + 1) % count;
        Some((self.first + number) as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_round_rest_and_run_out() {
        let mut numbers = Numbers::new(3, 60.0);
        let at = SimTime::from_s;
        let mut ours = |now, back: Option<(u16, f64)>| {
            if let Some((number, s)) = back {
                numbers.give_back(number, at(s));
            }
            assert!(numbers.take(now, true).is_none_or(|n| (3..6).contains(&n)), "behind ours");
            numbers.take(now, false)
        };
        assert_eq!([0, 1, 2].map(|_| ours(at(0.0), None)), [Some(0), Some(1), Some(2)]);
        assert_eq!(ours(at(0.0), None), None);
        assert_eq!(ours(at(64.0), Some((1, 5.0))), None, "still resting");
        assert_eq!(ours(at(65.0), None), Some(1));
    }
}
