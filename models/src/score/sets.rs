//! Distances between a set of true positions and a set of tracks.

use crate::association::assignment::Solver;
use crate::association::cluster::Clusters;
use crate::association::grid::Grid;
use crate::association::nearest::Pair;
use crate::filter::Nis;
use crate::frames::{Point2, Vector2};

/// GOSPA with α = 2, and its parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gospa {
    /// The metric, m: `(localisation + missed + false)^{1/p}`.
    pub total: f64,
    /// `Σ d^p` over the pairs, m^p.
    pub localisation: f64,
    /// `c^p/2` for each missed target, m^p.
    pub missed: f64,
    /// `c^p/2` for each false track, m^p.
    pub false_tracks: f64,
    /// The pairs (truth, track) nearer than the cut-off, by truth.
    pub pairs: Vec<(usize, usize)>,
}

/// Generalised optimal sub-pattern assignment metric with α = 2 and Euclidean distance.
///
/// `[min Σ d^p + c^p/2 (missed + false)]^{1/p}` over one-to-one pairs nearer than `cut_off_m`; a pair
/// at the cut-off or beyond is one missed target and one false track. Source: Rahmathullah,
/// García-Fernández, Svensson, FUSION 2017. Positions that are not finite pair with nothing.
#[must_use]
pub fn gospa(truth_m: &[Point2<f64>], tracks_m: &[Point2<f64>], cut_off_m: f64, p: f64) -> Gospa {
    let pairs = best_pairs(truth_m, tracks_m, cut_off_m, p);
    let localisation =
        pairs.iter().map(|&(t, k)| power(distance(truth_m[t], tracks_m[k]), p)).sum();
    let half = power(cut_off_m, p) / 2.0;
    let missed = half * (truth_m.len() - pairs.len()) as f64;
    let false_tracks = half * (tracks_m.len() - pairs.len()) as f64;
    let total = power(localisation + missed + false_tracks, 1.0 / p);
    Gospa { total, localisation, missed, false_tracks, pairs }
}

/// Optimal sub-pattern assignment metric, m.
///
/// `[(min Σ min(d, c)^p + c^p (n − m))/n]^{1/p}`, m ≤ n the sizes of the sets; two empty sets give 0.
/// Source: Schuhmacher, Vo, Vo, IEEE Trans. Signal Processing 56 (2008).
#[must_use]
pub fn ospa(truth_m: &[Point2<f64>], tracks_m: &[Point2<f64>], cut_off_m: f64, p: f64) -> f64 {
    let larger = truth_m.len().max(tracks_m.len());
    if larger == 0 {
        return 0.0;
    }
    let pairs = best_pairs(truth_m, tracks_m, cut_off_m, p);
    let near: f64 = pairs.iter().map(|&(t, k)| power(distance(truth_m[t], tracks_m[k]), p)).sum();
    let far = power(cut_off_m, p) * (larger - pairs.len()) as f64;
    power((near + far) / larger as f64, 1.0 / p)
}

/// The pairs nearer than the cut-off that save most: each saves `c^p − d^p` against leaving both
/// alone, in either metric. Only neighbours are looked at, and no pair crosses a cluster.
fn best_pairs(
    truth_m: &[Point2<f64>],
    tracks_m: &[Point2<f64>],
    cut_off_m: f64,
    p: f64,
) -> Vec<(usize, usize)> {
    let finite: Vec<usize> =
        (0..tracks_m.len()).filter(|&k| tracks_m[k].iter().all(|x| x.is_finite())).collect();
    let positions: Vec<_> = finite.iter().map(|&k| tracks_m[k]).collect();
    if !(cut_off_m > 0.0 && p > 0.0) || positions.is_empty() {
        return Vec::new();
    }
    let mut grid = Grid::default();
    grid.fill(&positions, cut_off_m);
    let around = Vector2::repeat(cut_off_m);
    let mut pairs: Vec<Pair> = Vec::new();
    for (t, &truth) in truth_m.iter().enumerate() {
        if !truth.iter().all(|x| x.is_finite()) {
            continue;
        }
        let first = pairs.len();
        grid.visit(truth - around, truth + around, |k| {
            let d = distance(truth, positions[k]);
            if d < cut_off_m {
                let nis = Nis { d2: d, det: 1.0, dof: 2 };
                pairs.push(Pair { track: t as u32, plot: finite[k] as u32, nis });
            }
        });
        pairs[first..].sort_unstable_by_key(|pair| pair.plot);
    }
    let mut clusters = Clusters::default();
    let borders = clusters.cut(truth_m.len(), tracks_m.len(), &mut pairs, &mut Vec::new()).to_vec();
    let mut solver = Solver::default();
    let most = power(cut_off_m, p);
    let mut found = Vec::new();
    for border in borders.windows(2) {
        let cluster = &pairs[border[0] as usize..border[1] as usize];
        let mut rows: Vec<u32> = cluster.iter().map(|c| c.track).collect();
        rows.dedup();
        let mut columns: Vec<u32> = cluster.iter().map(|c| c.plot).collect();
        columns.sort_unstable();
        columns.dedup();
        let mut cost = vec![None; rows.len() * columns.len()];
        for pair in cluster {
            let row = rows.partition_point(|&r| r < pair.track);
            let column = columns.partition_point(|&c| c < pair.plot);
            cost[row * columns.len() + column] = Some(power(pair.nis.d2, p) - most);
        }
        let chosen =
            solver.pairs_and_misses(rows.len(), columns.len(), |r, c| cost[r * columns.len() + c]);
        for (row, &column) in chosen.iter().enumerate() {
            if let Some(column) = column {
                found.push((rows[row] as usize, columns[column] as usize));
            }
        }
    }
    found.sort_unstable();
    found
}

fn distance(a: Point2<f64>, b: Point2<f64>) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}

fn power(x: f64, p: f64) -> f64 {
    if p == 1.0 {
        x
    } else if p == 2.0 {
        x * x
    } else if p == 0.5 {
        x.sqrt()
    } else {
        libm::pow(x, p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(values: &[(f64, f64)]) -> Vec<Point2<f64>> {
        values.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    proptest! {
        #[test]
        fn both_are_metrics(
            a in proptest::collection::vec((-50.0..50.0f64, -50.0..50.0f64), 0..6),
            b in proptest::collection::vec((-50.0..50.0f64, -50.0..50.0f64), 0..6),
            c in proptest::collection::vec((-50.0..50.0f64, -50.0..50.0f64), 0..6),
            p in prop_oneof![Just(1.0), Just(2.0), Just(3.0)],
        ) {
            let (a, b, c) = (points(&a), points(&b), points(&c));
            let g = |x: &[_], y: &[_]| gospa(x, y, 20.0, p).total;
            let o = |x: &[_], y: &[_]| ospa(x, y, 20.0, p);
            prop_assert!(g(&a, &a) < 1e-9 && o(&a, &a) < 1e-9);
            prop_assert!((g(&a, &b) - g(&b, &a)).abs() < 1e-9);
            prop_assert!((o(&a, &b) - o(&b, &a)).abs() < 1e-9);
            prop_assert!(g(&a, &c) <= g(&a, &b) + g(&b, &c) + 1e-9);
            prop_assert!(o(&a, &c) <= o(&a, &b) + o(&b, &c) + 1e-9);
            prop_assert!(o(&a, &b) <= 20.0 + 1e-9);
        }
    }

    #[test]
    fn the_parts_add_up_and_nothing_hostile_pairs() {
        let truth = points(&[(0.0, 0.0), (100.0, 0.0), (f64::NAN, 0.0)]);
        let tracks = points(&[(3.0, 4.0), (500.0, 0.0), (f64::INFINITY, 0.0)]);
        let found = gospa(&truth, &tracks, 20.0, 2.0);
        assert_eq!(found.pairs, [(0, 0)]);
        assert_eq!((found.localisation, found.missed, found.false_tracks), (25.0, 400.0, 400.0));
        assert_eq!(found.total, 825f64.sqrt());
        assert_eq!(gospa(&[], &[], 20.0, 2.0).total, 0.0);
        assert_eq!(ospa(&[], &[], 20.0, 2.0), 0.0);
    }
}
