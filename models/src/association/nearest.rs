//! Nearest neighbour, greedy: the paper's "sub-optimal nearest neighbour".

use crate::filter::Nis;

/// One gated pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Index of the track.
    pub track: u32,
    /// Index of the plot.
    pub plot: u32,
    /// Normalised innovation squared, with the determinant of its covariance.
    pub nis: Nis,
}

/// Takes the pairs by increasing `d²`, each track and each plot at most once, calling `take` for
/// those taken. Ties go to the pair that comes first in `pairs`, so the same input gives the same pairs.
/// `order` is scratch.
pub fn greedy(
    pairs: &[Pair],
    order: &mut Vec<u128>,
    track_used: &mut [bool],
    plot_used: &mut [bool],
    mut take: impl FnMut(Pair),
) {
    order.clear();
    // A distance is not negative: its bits are in its own order.
    let key = |(place, pair): (usize, &Pair)| {
        (u128::from(pair.nis.d2.max(0.0).to_bits()) << 64) | place as u128
    };
    order.extend(pairs.iter().enumerate().map(key));
    order.sort_unstable();
    for &key in &*order {
        let pair = pairs[key as u64 as usize];
        let (t, p) = (pair.track as usize, pair.plot as usize);
        if !track_used[t] && !plot_used[p] {
            track_used[t] = true;
            plot_used[p] = true;
            take(pair);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_first_and_each_once() {
        let pair = |track, plot, d2| Pair { track, plot, nis: Nis { d2, det: 1.0, dof: 2 } };
        let pairs = [pair(0, 0, 2.0), pair(1, 0, 1.0), pair(1, 1, 1.0), pair(0, 1, 5.0)];
        let mut taken = Vec::new();
        let mut order = Vec::new();
        let take = |p: Pair| taken.push((p.track, p.plot));
        greedy(&pairs, &mut order, &mut [false; 2], &mut [false; 2], take);
        assert_eq!(taken, [(1, 0), (0, 1)]);
    }
}
