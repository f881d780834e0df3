//! Track numbers: the next free one after the last given, cyclically, with a rest after use.

use crate::time::SimTime;
use std::ops::Range;

/// Numbers of tracks that plots of outsiders begin, so that outsiders take no number from us.
const OUTSIDE: Range<usize> = 4096..8192;

/// No number is given from here on: fifteen bits are what the least field for it holds, that of ASTERIX category 011.
const BEYOND: usize = 1 << 15;

/// The pools of numbers: those of ours from 0 on, without those of outsiders.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    ours: Pool,
    outside: Pool,
}

#[derive(Clone, Debug)]
struct Pool {
    /// When each number may be given (again); `SimTime(i64::MAX)` while in use.
    free_from: Vec<SimTime>,
    next: usize,
    rest_s: f64,
}

impl Numbers {
    /// `count` numbers for ours (as far as [`BEYOND`] goes), each resting `rest_s` seconds after use.
    pub(super) fn new(count: u32, rest_s: f64) -> Self {
        let count = (count as usize).clamp(1, BEYOND - OUTSIDE.len());
        let pool = |count| Pool { free_from: vec![SimTime(i64::MIN); count], next: 0, rest_s };
        Self { ours: pool(count), outside: pool(OUTSIDE.len()) }
    }

    /// The next number that is free and rested at `now`, for a track of ours or of an outsider.
    pub(super) fn take(&mut self, now: SimTime, outside: bool) -> Option<u16> {
        let place = if outside { self.outside.take(now) } else { self.ours.take(now) }?;
        let shifted = outside || place >= OUTSIDE.start;
        Some((place + if shifted { OUTSIDE.len() } else { 0 }) as u16)
    }

    /// The number's track is gone.
    pub(super) fn give_back(&mut self, number: u16, now: SimTime) {
        let number = usize::from(number);
        let pool = if OUTSIDE.contains(&number) { &mut self.outside } else { &mut self.ours };
        let place = if number < OUTSIDE.start { number } else { number - OUTSIDE.len() };
        pool.free_from[place] = now.plus_s(pool.rest_s);
    }
}

// Places and numbers of both pools differ by one constant.
const _: () = assert!(OUTSIDE.start == OUTSIDE.end - OUTSIDE.start);

impl Pool {
    fn take(&mut self, now: SimTime) -> Option<usize> {
        let count = self.free_from.len();
        let place =
            (0..count).map(|k| (self.next + k) % count).find(|&n| self.free_from[n] <= now)?;
        self.free_from[place] = SimTime(i64::MAX);
        self.next = (place + 1) % count;
        Some(place)
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
            assert!(numbers.take(now, true).is_some_and(|n| n >= 4096), "behind ours");
            numbers.take(now, false)
        };
        assert_eq!([0, 1, 2].map(|_| ours(at(0.0), None)), [Some(0), Some(1), Some(2)]);
        assert_eq!(ours(at(0.0), None), None);
        assert_eq!(ours(at(64.0), Some((1, 5.0))), None, "still resting");
        assert_eq!(ours(at(65.0), None), Some(1));
    }

    /// The field of a track number in category 011 has fifteen bits: one beyond them is never sent, however long a run goes on.
    #[test]
    fn no_number_is_beyond_what_every_category_holds() {
        let now = SimTime::from_s(0.0);
        for count in [crate::fusion::TrackingConfig::bulk().life.numbers, 61_440, u32::MAX] {
            let mut numbers = Numbers::new(count, 60.0);
            let ours: Vec<u16> = std::iter::from_fn(|| numbers.take(now, false)).collect();
            assert_eq!((ours.len(), ours.iter().max()), (28_672, Some(&0x7fff)), "{count}");
        }
    }

    #[test]
    fn outsiders_have_4096_to_8191_whatever_there_is_for_ours() {
        let now = SimTime::from_s(0.0);
        for count in [1, 3, 4096, 5000, 28_672] {
            let mut numbers = Numbers::new(count, 60.0);
            let all = |numbers: &mut Numbers, outside| -> Vec<u16> {
                std::iter::from_fn(|| numbers.take(now, outside)).collect()
            };
            let (ours, theirs) = (all(&mut numbers, false), all(&mut numbers, true));
            assert_eq!(theirs, (4096..8192).collect::<Vec<u16>>(), "{count}");
            let free = (0..=u16::MAX).filter(|n| !(4096..8192).contains(n));
            assert_eq!(ours, free.take(count as usize).collect::<Vec<u16>>(), "{count}");
            // Each comes back to where it is from.
            for number in [ours[ours.len() - 1], 0, 4096, 8191] {
                numbers.give_back(number, now);
                let later = SimTime::from_s(60.0);
                let outside = (4096..8192).contains(&number);
                assert_eq!(numbers.take(later, !outside), None, "{count}");
                assert_eq!(numbers.take(later, outside), Some(number), "{count}");
            }
        }
    }
}
