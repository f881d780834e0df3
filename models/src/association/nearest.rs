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
/// those taken. Ties go to the lower track, then the lower plot index (both in the caller's order),
/// so the same input gives the same pairs. Sorts `pairs`.
pub fn greedy(
    pairs: &mut [Pair],
    track_used: &mut [bool],
    plot_used: &mut [bool],
    mut take: impl FnMut(Pair),
) {
    pairs.sort_unstable_by(|a, b| {
        a.nis.d2.total_cmp(&b.nis.d2).then(a.track.cmp(&b.track)).then(a.plot.cmp(&b.plot))
    });
    for &pair in pairs.iter() {
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
        let mut pairs = [pair(0, 0, 2.0), pair(1, 0, 1.0), pair(1, 1, 1.0), pair(0, 1, 5.0)];
        let mut taken = Vec::new();
        greedy(&mut pairs, &mut [false; 2], &mut [false; 2], |p| taken.push((p.track, p.plot)));
        assert_eq!(taken, [(1, 0), (0, 1)]);
    }
}
