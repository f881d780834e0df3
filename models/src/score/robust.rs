//! Sums over errors that a few gross ones do not decide, kept while the errors come in and of bounded size.
//!
//! An echo of a pulse before the last stands kilometres nearer; three of these decide the mean square of ten thousand
//! plots. So what is more than [`FAR_OFF`] times as far off as 95 % of all is counted by itself and left out of the sums.
//! The errors are held in bins a hundredth apart in ratio, so the limit is right within that.

use std::collections::BTreeMap;

/// Errors that 95 % do not exceed, times this, are too far off to be an error of measurement: six and a third standard
/// deviations of a circular normal error, so one in 10⁸.
pub const FAR_OFF: f64 = 2.6;

/// Bins for each doubling of the error.
const PER_OCTAVE: f64 = 64.0;
/// Smaller errors share a bin, m.
const LEAST_M: f64 = 1e-3;
/// Bins at most: errors from 2¹⁰⁰ times the least on share the last one.
const MOST_BINS: f64 = 6400.0;

/// The value below which a share `p` of sorted values lies (nearest rank).
#[must_use]
pub fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let rank = (p * sorted.len() as f64).ceil() as usize;
    (!sorted.is_empty()).then(|| sorted[rank.clamp(1, sorted.len()) - 1])
}

/// One bin.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bin<const N: usize> {
    count: u64,
    sums: [f64; N],
    farthest_m: f64,
}

/// `N` sums over errors, with the gross ones apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Robust<const N: usize> {
    bins: BTreeMap<u16, Bin<N>>,
}

impl<const N: usize> Default for Robust<N> {
    fn default() -> Self {
        Self { bins: BTreeMap::new() }
    }
}

/// What is left when the gross errors are taken off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept<const N: usize> {
    /// Errors that count.
    pub count: u64,
    /// Their sums.
    pub sums: [f64; N],
    /// Errors that were left out.
    pub left_out: u64,
    /// The largest of those, m.
    pub farthest_m: f64,
}

impl<const N: usize> Robust<N> {
    /// Adds what goes with an error of `error_m`; one that is not finite or negative is passed over.
    pub fn add(&mut self, error_m: f64, values: [f64; N]) {
        if !(error_m.is_finite() && error_m >= 0.0) {
            return;
        }
        let octaves = libm::log2(error_m.max(LEAST_M) / LEAST_M);
        let at = (octaves * PER_OCTAVE).floor().min(MOST_BINS) as u16;
        let empty = Bin { count: 0, sums: [0.0; N], farthest_m: 0.0 };
        let bin = self.bins.entry(at).or_insert(empty);
        bin.count += 1;
        bin.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        bin.farthest_m = bin.farthest_m.max(error_m);
    }

    /// The sums without the gross errors.
    #[must_use]
    pub fn kept(&self) -> Kept<N> {
        let all: u64 = self.bins.values().map(|bin| bin.count).sum();
        let rank = (0.95 * all as f64).ceil() as u64;
        let mut below = 0;
        let reached = self.bins.values().find(|bin| {
            below += bin.count;
            below >= rank
        });
        let limit_m = reached.map_or(f64::INFINITY, |bin| FAR_OFF * bin.farthest_m);
        let mut kept = Kept { count: 0, sums: [0.0; N], left_out: 0, farthest_m: 0.0 };
        for bin in self.bins.values() {
            if bin.farthest_m <= limit_m {
                kept.count += bin.count;
                kept.sums.iter_mut().zip(bin.sums).for_each(|(sum, more)| *sum += more);
            } else {
                kept.left_out += bin.count;
                kept.farthest_m = kept.farthest_m.max(bin.farthest_m);
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::recording::PlotSum;
    use proptest::prelude::*;

    #[test]
    fn three_echoes_of_another_pulse_among_a_thousand_are_counted_and_change_nothing() {
        let mut robust = Robust::<1>::default();
        (0..1000).for_each(|k| {
            let error = 0.01 * f64::from(k);
            robust.add(error, [error * error]);
        });
        let before = robust.kept();
        assert_eq!((before.count, before.left_out), (1000, 0));
        [7_500.0, 9_000.0, 1e300].iter().for_each(|e| robust.add(*e, [e * e]));
        let after = robust.kept();
        assert_eq!((after.count, after.left_out, after.farthest_m), (1000, 3, 1e300));
        assert_eq!(after.sums, before.sums);
        robust.add(f64::NAN, [f64::NAN]);
        robust.add(-1.0, [1.0]);
        assert_eq!(robust.kept(), after);
        assert_eq!(Robust::<2>::default().kept().count, 0);
    }

    proptest! {
        #[test]
        fn it_says_what_the_whole_list_says(errors in proptest::collection::vec(
            prop_oneof![9 => 0.0..30.0, 1 => 0.0f64..1e4], 1..300)
        ) {
            let mut robust = Robust::<1>::default();
            errors.iter().for_each(|e| robust.add(*e, [e * e]));
            let (kept, list) = (robust.kept(), PlotSum::of(errors.clone()));
            prop_assert_eq!(kept.count + kept.left_out, errors.len() as u64);
            // All but what lies within a bin of the list's own limit.
            let near = |e: &&f64| (**e / list.limit_m - 1.0).abs() < 0.03;
            let disputed = if list.limit_m.is_finite() {
                errors.iter().filter(near).count() as u64
            } else {
                0
            };
            prop_assert!(kept.count.abs_diff(list.count) <= disputed, "{:?} {:?}", kept, list);
        }
    }
}
