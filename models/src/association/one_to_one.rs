//! Probabilities of a one-to-one pairing (tracks and lines of the flight list): exact in every cluster that is small
//! enough, by belief propagation ([`super::lbp`]) in the others.
//!
//! Belief propagation is off by up to 0.21, to the certain side, where two want the same two; a label has to be right as
//! often as it says. The exact form ([`super::jpda`]) is exponential in one side of the cluster, whichever is shorter.

use super::jpda::Jpda;
use super::lbp::{Belief, Edge};
use std::collections::BTreeMap;

/// A cluster of `m` and `n ≤ m` is done exactly up to this `m · 2ⁿ`.
pub const EXACT_STATES: usize = 1 << 14;

/// Results and work space; keep it to allocate little from call to call.
#[derive(Clone, Debug, Default)]
pub struct OneToOne {
    belief: Belief,
    jpda: Jpda,
    shares: Vec<f64>,
    misses: Vec<f64>,
}

impl OneToOne {
    /// Weighs the pairs: `edges` sorted by row, every index below `rows` and `columns`; belief propagation ends after
    /// `most_sweeps` or when no message moves by more than `still` of itself. Returns the evaluations that it took.
    pub fn run(
        &mut self,
        rows: usize,
        columns: usize,
        edges: &[Edge],
        most_sweeps: u32,
        still: f64,
    ) -> u64 {
        let ended = self.belief.run(rows, columns, edges, most_sweeps, still);
        let mut evaluations = u64::from(ended.sweeps) * edges.len() as u64;
        self.misses.clear();
        self.misses.extend((0..rows).map(|row| self.belief.miss(row)));
        self.shares.clear();
        self.shares.extend(
            edges.iter().enumerate().map(|(e, edge)| self.belief.share(edge.row as usize, e)),
        );
        for cluster in clusters(rows, columns, edges) {
            evaluations += self.exact(edges, &cluster);
        }
        evaluations
    }

    /// Probability that `row` has no partner.
    #[must_use]
    pub fn miss(&self, row: usize) -> f64 {
        self.misses[row]
    }

    /// Probability of the edge at this place of the list.
    #[must_use]
    pub fn share(&self, edge: usize) -> f64 {
        self.shares[edge]
    }

    /// The places in the list of the edges of a row.
    #[must_use]
    pub fn edges_of(&self, row: usize) -> std::ops::Range<usize> {
        self.belief.edges_of(row)
    }

    /// Replaces what belief says of a cluster (places in the list), if that is small enough.
    fn exact(&mut self, edges: &[Edge], cluster: &[usize]) -> u64 {
        let side = |of: fn(&Edge) -> u32| -> Vec<u32> {
            let mut all: Vec<u32> = cluster.iter().map(|&e| of(&edges[e])).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (rows, columns) = (side(|e| e.row), side(|e| e.column));
        let turned = rows.len() < columns.len();
        let (many, few) = if turned { (&columns, &rows) } else { (&rows, &columns) };
        let states = 1_usize.checked_shl(few.len() as u32).and_then(|s| s.checked_mul(many.len()));
        let Some(states) = states.filter(|s| *s <= EXACT_STATES) else { return 0 };
        let place = |edge: &Edge| {
            let (long, short) =
                if turned { (edge.column, edge.row) } else { (edge.row, edge.column) };
            let at = |list: &[u32], index: u32| list.binary_search(&index).unwrap_or(0);
            (at(many, long), at(few, short))
        };
        let mut gains = vec![f64::NEG_INFINITY; many.len() * few.len()];
        for &e in cluster {
            let (i, j) = place(&edges[e]);
            gains[i * few.len() + j] = edges[e].gain;
        }
        let mut beta = Vec::new();
        if self.jpda.marginals(&vec![0.0; many.len()], &gains, EXACT_STATES, &mut beta).is_err() {
            return 0;
        }
        rows.iter().for_each(|row| self.misses[*row as usize] = 1.0);
        for &e in cluster {
            let (i, j) = place(&edges[e]);
            self.shares[e] = beta[i * (few.len() + 1) + 1 + j];
            self.misses[edges[e].row as usize] -= self.shares[e];
        }
        rows.iter().for_each(|row| {
            let miss = &mut self.misses[*row as usize];
            *miss = miss.max(0.0);
        });
        (states * few.len()) as u64
    }
}

/// The edges (places in the list) that hang together by rows and columns, in the order of their first.
fn clusters(rows: usize, columns: usize, edges: &[Edge]) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..rows + columns).collect();
    fn root(parent: &mut [usize], mut node: usize) -> usize {
        while parent[node] != node {
            parent[node] = parent[parent[node]];
            node = parent[node];
        }
        node
    }
    for edge in edges {
        let a = root(&mut parent, edge.row as usize);
        let b = root(&mut parent, rows + edge.column as usize);
        parent[a.max(b)] = a.min(b);
    }
    let mut found: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (e, edge) in edges.iter().enumerate() {
        found.entry(root(&mut parent, edge.row as usize)).or_default().push(e);
    }
    found.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every pairing, one after the other.
    fn by_hand(rows: usize, columns: usize, edges: &[Edge]) -> Vec<f64> {
        #[expect(clippy::too_many_arguments, reason = "the whole state of the recursion")]
        fn walk(
            row: usize,
            rows: usize,
            used: &mut Vec<bool>,
            edges: &[Edge],
            taken: &mut Vec<usize>,
            weight: f64,
            sums: &mut [f64],
            total: &mut f64,
        ) {
            if row == rows {
                *total += weight;
                taken.iter().for_each(|e| sums[*e] += weight);
                return;
            }
            walk(row + 1, rows, used, edges, taken, weight, sums, total);
            for (e, edge) in edges.iter().enumerate().filter(|(_, e)| e.row as usize == row) {
                let column = edge.column as usize;
                if used[column] {
                    continue;
                }
                used[column] = true;
                taken.push(e);
                let with = weight * libm::exp(edge.gain);
                walk(row + 1, rows, used, edges, taken, with, sums, total);
                taken.pop();
                used[column] = false;
            }
        }
        let (mut sums, mut total) = (vec![0.0; edges.len()], 0.0);
        let mut used = vec![false; columns];
        walk(0, rows, &mut used, edges, &mut Vec::new(), 1.0, &mut sums, &mut total);
        sums.iter().map(|s| s / total).collect()
    }

    proptest! {
        #[test]
        fn small_clusters_are_exact_whichever_side_is_longer(
            gains in proptest::collection::vec(proptest::option::of(-6.0..8.0), 5 * 5),
            rows in 1..=5_usize,
            columns in 1..=5_usize,
        ) {
            let mut edges = Vec::new();
            for row in 0..rows {
                for column in 0..columns {
                    if let Some(gain) = gains[row * 5 + column] {
                        edges.push(Edge { row: row as u32, column: column as u32, gain });
                    }
                }
            }
            let mut pairing = OneToOne::default();
            pairing.run(rows, columns, &edges, 200, 1e-6);
            let exact = by_hand(rows, columns, &edges);
            for (e, share) in exact.iter().enumerate() {
                prop_assert!((pairing.share(e) - share).abs() < 1e-9, "{e}: {share}");
            }
            for row in 0..rows {
                let own: f64 = pairing.edges_of(row).map(|e| exact[e]).sum();
                prop_assert!((pairing.miss(row) - (1.0 - own)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_is_too_large_is_left_to_belief() {
        let n = 20_u32;
        let all = (0..n).flat_map(|row| (0..n).map(move |column| Edge { row, column, gain: 1.0 }));
        let edges: Vec<Edge> = all.collect();
        let (mut pairing, mut belief) = (OneToOne::default(), Belief::default());
        pairing.run(n as usize, n as usize, &edges, 200, 1e-6);
        belief.run(n as usize, n as usize, &edges, 200, 1e-6);
        assert_eq!(pairing.share(7), belief.share(0, 7));
        assert_eq!(pairing.miss(3), belief.miss(3));
    }
}
