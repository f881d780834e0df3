//! What can be said for certain of the marginals of a cluster that belief propagation has weighed: lower and upper bounds.
//!
//! With `p_v(G)` the probability that v has no partner in the graph G of tracks and plots,
//! `p_v(G) = 1/(1 + Σ_{u∈N(v)} ψ_vu p_u(G∖v))`, `β_ij = ψ_ij p_j(G∖i)/(1 + Σ_k ψ_ik p_k(G∖i))`: exact, but a tree of all walks that
//! meet no place twice. Cut at a depth with `p ∈ [1/(1 + Σψ), 1]` it brackets every marginal, as each step falls in its arguments and so
//! turns a lower bound into an upper one. At as many levels as there are tracks and plots it is exact.
//!
//! Source: tree of self-avoiding walks of the monomer–dimer model: Weitz (2006); Bayati, Gamarnik, Katz, Nair, Tetali (2007).

use super::lbp::{Edge, weight};

/// Levels of the tree that a run looks at first …
pub const DEPTH: usize = 3;

/// … and at most, one by one while nothing is certain and the last level took few terms: on a line of targets whose gates overlap a
/// sure pair shows at five.
pub const MOST_DEPTH: usize = 8;
const FEW_TERMS: u64 = 170;

/// Edges of a track, or of a plot on the way, beyond which the tree is cut there.
pub const MOST_EDGES: usize = 4;

/// Terms of a tree in one evaluation (of ten nanoseconds); 3.7 ns each, as measured.
pub const TERMS: u64 = 2;

/// A lower and an upper bound of a probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// Not less than this.
    pub low: f64,
    /// Not more than this.
    pub high: f64,
}

/// What was said of the tracks of one or more clusters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Certified {
    /// Tracks with bounds.
    pub tracks: u64,
    /// Of these: one pair has more than even odds for certain, so it is the best one.
    pub certain: u64,
}

/// Edges by row and by column; keep it to allocate nothing from call to call.
#[derive(Clone, Debug, Default)]
pub struct Certificate {
    /// Of each node, rows first: its edges, as places in `ends`.
    starts: Vec<u32>,
    /// The node at the other end, and ψ.
    ends: Vec<(u32, f64)>,
    rows: usize,
    /// Of each node: 1 + Σψ over all its edges.
    sums: Vec<f64>,
    /// Nodes on the walk in hand.
    walk: Vec<u32>,
    shares: Vec<(f64, Bracket)>,
    /// Terms since [`Self::lay_out`].
    terms: u64,
}

impl Certificate {
    /// Takes the pairs of a cluster; they are sorted by row, and every row and column is below `rows` and `columns`.
    pub fn lay_out(&mut self, rows: usize, columns: usize, edges: &[Edge]) {
        (self.rows, self.terms) = (rows, 0);
        let nodes = rows + columns;
        self.starts.clear();
        self.starts.resize(nodes + 1, 0);
        self.sums.clear();
        self.sums.resize(nodes, 1.0);
        for edge in edges {
            self.starts[edge.row as usize + 1] += 1;
            self.starts[rows + edge.column as usize + 1] += 1;
        }
        for node in 0..nodes {
            self.starts[node + 1] += self.starts[node];
        }
        self.ends.clear();
        self.ends.resize(2 * edges.len(), (0, 0.0));
        let mut next = self.starts.clone();
        for edge in edges {
            let (row, column, psi) = (edge.row, rows as u32 + edge.column, weight(edge.gain));
            for (own, other) in [(row, column), (column, row)] {
                let place = &mut next[own as usize];
                self.ends[*place as usize] = (other, psi);
                self.sums[own as usize] += psi;
                *place += 1;
            }
        }
    }

    /// Bounds of the probability that `row` has no partner, and of each of its pairs, in the order of the edges; of a walk that comes to
    /// a node of more than `most_edges` edges only what its weights alone say.
    pub fn bounds(
        &mut self,
        row: usize,
        depth: usize,
        most_edges: usize,
        mut each: impl FnMut(Bracket),
    ) -> Bracket {
        let mut shares = std::mem::take(&mut self.shares);
        shares.clear();
        self.walk.clear();
        self.walk.push(row as u32);
        for place in self.edges_of(row as u32) {
            let (other, psi) = self.ends[place];
            shares.push((psi, self.alone(other, depth, most_edges)));
        }
        let sum =
            |end: fn(&Bracket) -> f64| 1.0 + shares.iter().map(|(w, p)| w * end(p)).sum::<f64>();
        let (least, most) = (sum(|p| p.low), sum(|p| p.high));
        for (psi, p) in &shares {
            let (low, high) = (psi * p.low, psi * p.high);
            // All others as likely, or as unlikely, as they may be; never less than the term itself, whatever rounding says.
            let others = |sum: f64, own: f64| (sum - own).max(1.0);
            each(Bracket {
                low: low / (low + others(most, high)),
                high: high / (high + others(least, low)),
            });
        }
        self.shares = shares;
        Bracket { low: 1.0 / most, high: 1.0 / least }
    }

    /// Tracks of the cluster with at most [`MOST_EDGES`] edges: how many, and of how many one pair is certain; no more of them once so
    /// many terms were looked at.
    pub fn of_cluster(&mut self, most_terms: u64) -> Certified {
        let mut said = Certified::default();
        for row in 0..self.rows {
            if !self.is_small(row) {
                continue;
            }
            if self.terms >= most_terms {
                break;
            }
            said.tracks += 1;
            for depth in DEPTH..=MOST_DEPTH {
                let (before, mut best) = (self.terms, 0.0f64);
                self.bounds(row, depth, MOST_EDGES, |share| best = best.max(share.low));
                if best > 0.5 {
                    said.certain += 1;
                    break;
                }
                if self.terms - before > FEW_TERMS {
                    break;
                }
            }
        }
        said
    }

    /// Terms of trees since [`Self::lay_out`].
    #[must_use]
    pub fn terms(&self) -> u64 {
        self.terms
    }

    fn is_small(&self, row: usize) -> bool {
        self.edges_of(row as u32).len() <= MOST_EDGES
    }

    fn edges_of(&self, node: u32) -> std::ops::Range<usize> {
        self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize
    }

    /// Bounds of the probability that `node` has no partner where the nodes of the walk are gone.
    fn alone(&mut self, node: u32, depth: usize, most_edges: usize) -> Bracket {
        let edges = self.edges_of(node);
        if edges.len() > most_edges {
            // All of its weights, those of nodes that are gone too: a lower bound the more.
            return Bracket { low: 1.0 / self.sums[node as usize], high: 1.0 };
        }
        let (mut least, mut most) = (1.0, 1.0);
        self.terms += edges.len() as u64;
        self.walk.push(node);
        for place in edges {
            let (other, psi) = self.ends[place];
            if self.walk.contains(&other) {
                continue;
            }
            let of = if depth > 1 {
                self.alone(other, depth - 1, most_edges)
            } else {
                Bracket { low: 0.0, high: 1.0 }
            };
            least += psi * of.low;
            most += psi * of.high;
        }
        self.walk.pop();
        Bracket { low: 1.0 / most, high: 1.0 / least }
    }
}

#[cfg(test)]
mod tests {
    use super::super::jpda::Jpda;
    use super::super::lbp::Belief;
    use super::*;
    use proptest::prelude::*;

    /// All pairs of a matrix of gains against a miss; −∞ is no pair.
    fn edges_of(gains: &[f64], plots: usize) -> Vec<Edge> {
        let edge = |(k, gain): (usize, &f64)| Edge {
            row: (k / plots) as u32,
            column: (k % plots) as u32,
            gain: *gain,
        };
        gains.iter().enumerate().filter(|(_, g)| g.is_finite()).map(edge).collect()
    }

    /// Of every row the bounds of its miss and of its pairs.
    fn bounds(
        gains: &[f64],
        plots: usize,
        depth: usize,
        most_edges: usize,
    ) -> Vec<(usize, usize, Bracket)> {
        let (edges, rows) = (edges_of(gains, plots), gains.len() / plots);
        let mut certificate = Certificate::default();
        certificate.lay_out(rows, plots, &edges);
        let mut all = Vec::new();
        for row in 0..rows {
            let mut own = edges.iter().filter(|e| e.row as usize == row);
            let miss = certificate.bounds(row, depth, most_edges, |share| {
                let edge = own.next().expect("one bracket an edge");
                all.push((row, edge.column as usize + 1, share));
            });
            assert!(own.next().is_none());
            all.push((row, 0, miss));
        }
        all
    }

    fn exact(gains: &[f64], plots: usize) -> Vec<f64> {
        let mut beta = Vec::new();
        let miss = vec![0.0; gains.len() / plots];
        Jpda::default().marginals(&miss, gains, 1 << 20, &mut beta).expect("small");
        beta
    }

    proptest! {
        /// Whatever the weights, the depth and where walks are cut: what is exact lies between the bounds; a level more never widens
        /// them, and as many levels as there are tracks and plots are exact.
        #[test]
        fn what_is_exact_lies_between_the_bounds(
            tracks in 1usize..5, plots in 1usize..5,
            values in proptest::collection::vec(-8.0..8.0f64, 16),
            holes in 0u32..65_536,
            most_edges in 0usize..6,
        ) {
            let hole = |k: usize| holes >> k & 1 == 1 && !k.is_multiple_of(3);
            let gains: Vec<f64> = (0..tracks * plots)
                .map(|k| if hole(k) { f64::NEG_INFINITY } else { values[k] })
                .collect();
            let exact = exact(&gains, plots);
            let mut before: Option<Vec<(usize, usize, Bracket)>> = None;
            for depth in 1..=tracks + plots {
                for limit in [most_edges, usize::MAX] {
                    let found = bounds(&gains, plots, depth, limit);
                    for (row, column, b) in &found {
                        let beta = exact[row * (plots + 1) + column];
                        prop_assert!(
                            b.low - 1e-12 <= beta && beta <= b.high + 1e-12,
                            "{row} {column}: {beta} in {b:?} at depth {depth}, {limit} edges"
                        );
                    }
                    if limit == usize::MAX {
                        for ((_, _, b), (_, _, wider)) in found.iter().zip(before.iter().flatten()) {
                            prop_assert!(b.low >= wider.low - 1e-12 && b.high <= wider.high + 1e-12);
                        }
                        before = Some(found);
                    }
                }
            }
            for (row, column, b) in before.iter().flatten() {
                let beta = exact[row * (plots + 1) + column];
                prop_assert!((b.low - beta).abs() < 1e-9 && (b.high - beta).abs() < 1e-9, "{row} {column}");
            }
        }
    }

    /// Two that want the same two, nearly alike: belief propagation is sure of more than there is to know, and nothing is certified.
    /// Two that want different ones are. A track of more edges than are looked at is not counted.
    #[test]
    fn what_belief_is_sure_of_in_vain_is_not_certified() {
        let said = |gains: &[f64], plots: usize| {
            let mut certificate = Certificate::default();
            certificate.lay_out(gains.len() / plots, plots, &edges_of(gains, plots));
            let said = certificate.of_cluster(u64::MAX);
            (said.tracks, said.certain)
        };
        let alike = [5.0, 4.6, 4.6, 5.0];
        let mut belief = Belief::default();
        belief.run(2, 2, &edges_of(&alike, 2), 200, 1e-12);
        let exact = exact(&alike, 2);
        assert!(belief.share(0, 0) > exact[1] + 0.1, "{} {}", belief.share(0, 0), exact[1]);
        assert_eq!(said(&alike, 2), (2, 2), "at this depth it is exact");
        assert_eq!(said(&[5.0, 5.0, 5.0, 5.0], 2), (2, 0));
        assert_eq!(said(&[5.0, -2.0, -2.0, 5.0], 2), (2, 2));
        assert_eq!(said(&[0.0; 10], 5), (0, 0));
        assert_eq!(said(&[9.0, -3.0, -3.0, -3.0, 0.0, 0.0, 0.0, 0.0], 4), (2, 1));
        // Weights that no double holds bound everything by 0 and 1.
        for gain in [1e300, f64::INFINITY] {
            for (_, _, b) in bounds(&[gain, gain, 0.0, 0.0], 2, DEPTH, MOST_EDGES) {
                assert!(0.0 <= b.low && b.low <= b.high && b.high <= 1.0 + 1e-12, "{b:?}");
            }
        }
    }

    /// A line of targets of which each may have its neighbours' plots: what is likelier by sixty to one is sure, though three levels do not
    /// show it. Of more tracks than are paid for only the first ones are looked at, and each takes no more than a few hundred terms.
    #[test]
    fn a_level_more_is_looked_at_while_it_costs_little() {
        let n = 25u32;
        let gain = |row: u32, column: u32| libm::log(if row == column { 6e6 } else { 1e5 });
        let near = |row: u32| row.saturating_sub(1)..=(row + 1).min(n - 1);
        let edges: Vec<Edge> = (0..n)
            .flat_map(|row| {
                near(row).map(move |column| Edge { row, column, gain: gain(row, column) })
            })
            .collect();
        let mut certificate = Certificate::default();
        let said = |certificate: &mut Certificate, most: u64| {
            certificate.lay_out(n as usize, n as usize, &edges);
            certificate.of_cluster(most)
        };
        assert_eq!(said(&mut certificate, u64::MAX), Certified { tracks: 25, certain: 25 });
        let all = certificate.terms();
        assert!((2_500..25 * 400).contains(&all), "{all}");
        let mut low = 0.0f64;
        certificate.bounds(12, DEPTH, MOST_EDGES, |share| low = low.max(share.low));
        assert!(low < 0.3, "{low}");
        let some = said(&mut certificate, all / 5).tracks;
        assert!((3..10).contains(&some) && certificate.terms() < all / 5 + 1_000, "{some}");
        assert_eq!(said(&mut certificate, 0).tracks, 0);
    }
}
