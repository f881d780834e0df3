//! Approximate marginals by loopy belief propagation on the list of gated pairs: for clusters that are too large to be
//! done exactly, and for anything else that is one to one (tracks and lines of the flight list).
//!
//! `ψ_e = exp(L_ij − M_i)` for the pair `e = (i, j)`; `μ_e = ψ_e/(1 + Σ_{other e of i} ψ ν)`,
//! `ν_e = 1/(1 + Σ_{other e of j} μ)`; `β_e = ψ_e ν_e/(1 + Σ_i ψ ν)`. Sums without the own term are made from both
//! ends ("sum minus own" cancels at large weights). `O(pairs)` a sweep. Exact on trees; two tracks that want the same
//! two plots are off by up to 0.21, to the certain side. No step is damped: in ln μ and ln ν each half of a sweep moves a message by
//! less than the messages it is made of have moved (`Σψν/(1 + Σψν) < 1`), so no sweep moves the messages by more than the one before.
//!
//! Source: J. Williams, R. Lau, "Approximate evaluation of marginal association probabilities with
//! belief propagation", IEEE Trans. AES 50 (2014).

/// Sweeps after which a cluster is taken as it stands: by then the best pairs do not change any more.
pub const MOST_SWEEPS: u32 = 20;

/// Largest movement of a message (relative) that counts as standing still, in association.
pub const STILL: f64 = 1e-3;

/// Logarithms of weights are cut here: e^±600 and all sums of such are finite in a double.
const LARGEST_LOG: f64 = 600.0;

/// One possible pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Row (track) of the cluster.
    pub row: u32,
    /// Column (plot) of the cluster.
    pub column: u32,
    /// `L_ij − M_i`: how much likelier than a miss, in logarithms. NaN and −∞ say impossible.
    pub gain: f64,
}

/// Messages and work space; keep it to allocate nothing from call to call.
#[derive(Clone, Debug, Default)]
pub struct Belief {
    psi: Vec<f64>,
    mu: Vec<f64>,
    nu: Vec<f64>,
    /// First edge of each row, and one more.
    rows: Vec<u32>,
    /// First place in `of_column` of each column, and one more.
    columns: Vec<u32>,
    of_column: Vec<u32>,
    misses: Vec<f64>,
    ahead: Vec<f64>,
}

/// How a run of [`Belief::run`] ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    /// Sweeps made.
    pub sweeps: u32,
    /// Largest relative movement of a message in the last one.
    pub moved: f64,
}

impl Belief {
    /// Sends messages until none moves by more than `still` of itself, or for `most_sweeps` sweeps.
    ///
    /// `edges` are sorted by row; every row and column index is below `rows` and `columns`.
    pub fn run(
        &mut self,
        rows: usize,
        columns: usize,
        edges: &[Edge],
        most_sweeps: u32,
        still: f64,
    ) -> Ended {
        self.lay_out(rows, columns, edges);
        let mut ended = Ended { sweeps: 0, moved: 0.0 };
        while ended.sweeps < most_sweeps {
            ended.sweeps += 1;
            self.send_to_columns();
            ended.moved = self.send_to_rows();
            if ended.moved <= still {
                break;
            }
        }
        self.misses.clear();
        for row in 0..rows {
            let own = self.rows[row] as usize..self.rows[row + 1] as usize;
            let sum: f64 = own.map(|e| self.psi[e] * self.nu[e]).sum();
            self.misses.push(1.0 / (1.0 + sum));
        }
        ended
    }

    /// Probability that `row` has no partner.
    #[must_use]
    pub fn miss(&self, row: usize) -> f64 {
        self.misses[row]
    }

    /// Probability of the edge at this place of the list, which belongs to `row`.
    #[must_use]
    pub fn share(&self, row: usize, edge: usize) -> f64 {
        self.psi[edge] * self.nu[edge] * self.misses[row]
    }

    /// The places in the list of the edges of a row.
    #[must_use]
    pub fn edges_of(&self, row: usize) -> std::ops::Range<usize> {
        self.rows[row] as usize..self.rows[row + 1] as usize
    }

    fn lay_out(&mut self, rows: usize, columns: usize, edges: &[Edge]) {
        self.psi.clear();
        self.psi.extend(edges.iter().map(|edge| weight(edge.gain)));
        self.mu.clear();
        self.mu.resize(edges.len(), 0.0);
        self.nu.clear();
        self.nu.resize(edges.len(), 1.0);
        self.rows.clear();
        self.rows.resize(rows + 1, 0);
        self.columns.clear();
        self.columns.resize(columns + 2, 0);
        for edge in edges {
            self.rows[edge.row as usize + 1] += 1;
            self.columns[edge.column as usize + 2] += 1;
        }
        for starts in [&mut self.rows, &mut self.columns] {
            let mut sum = 0;
            for start in starts {
                sum += *start;
                *start = sum;
            }
        }
        self.of_column.clear();
        self.of_column.resize(edges.len(), 0);
        for (place, edge) in edges.iter().enumerate() {
            let slot = &mut self.columns[edge.column as usize + 1];
            self.of_column[*slot as usize] = place as u32;
            *slot += 1;
        }
    }

    fn send_to_columns(&mut self) {
        let Self { psi, mu, nu, rows, ahead, .. } = self;
        for row in rows.windows(2) {
            let own = row[0] as usize..row[1] as usize;
            ahead.clear();
            let mut sum = 1.0;
            for e in own.clone() {
                ahead.push(sum);
                sum += psi[e] * nu[e];
            }
            let mut after = 0.0;
            for e in own.clone().rev() {
                mu[e] = psi[e] / (ahead[e - own.start] + after);
                after += psi[e] * nu[e];
            }
        }
    }

    /// Gives the largest relative movement.
    fn send_to_rows(&mut self) -> f64 {
        let Self { mu, nu, columns, of_column, ahead, .. } = self;
        let mut moved = 0.0f64;
        for column in columns.windows(2) {
            let own = &of_column[column[0] as usize..column[1] as usize];
            ahead.clear();
            let mut sum = 1.0;
            for &e in own {
                ahead.push(sum);
                sum += mu[e as usize];
            }
            let mut after = 0.0;
            for (k, &e) in own.iter().enumerate().rev() {
                let e = e as usize;
                let next = 1.0 / (ahead[k] + after);
                after += mu[e];
                moved = moved.max((next - nu[e]).abs() / next.max(nu[e]));
                nu[e] = next;
            }
        }
        moved
    }
}

pub(super) fn weight(gain: f64) -> f64 {
    if gain.is_nan() || gain == f64::NEG_INFINITY {
        return 0.0;
    }
    libm::exp(gain.clamp(-LARGEST_LOG, LARGEST_LOG))
}

#[cfg(test)]
mod tests {
    use super::super::jpda::Jpda;
    use super::*;
    use proptest::prelude::*;

    /// All pairs of a matrix.
    fn dense(log_miss: &[f64], log_like: &[f64]) -> Vec<Edge> {
        let plots = log_like.len().checked_div(log_miss.len()).unwrap_or(0);
        let edge = |k: usize| Edge {
            row: (k / plots) as u32,
            column: (k % plots) as u32,
            gain: log_like[k] - log_miss[k / plots].max(-1e200),
        };
        (0..log_like.len()).map(edge).collect()
    }

    fn marginals(rows: usize, columns: usize, edges: &[Edge], sweeps: u32) -> Vec<f64> {
        let mut belief = Belief::default();
        belief.run(rows, columns, edges, sweeps, 1e-12);
        let mut beta = Vec::new();
        for row in 0..rows {
            beta.push(belief.miss(row));
            beta.extend(belief.edges_of(row).map(|e| belief.share(row, e)));
        }
        beta
    }

    proptest! {
        #[test]
        fn finite_at_any_offset_and_near_the_exact_marginals(
            tracks in 1usize..5, plots in 1usize..5,
            values in proptest::collection::vec(-8.0..4.0f64, 4 + 16),
            offset in -2000.0..2000.0f64,
        ) {
            let miss: Vec<f64> = values[..tracks].iter().map(|v| v + offset).collect();
            let like: Vec<f64> = values[4..4 + tracks * plots].iter().map(|v| v + offset).collect();
            let mut exact = Vec::new();
            Jpda::default().marginals(&miss, &like, 100_000, &mut exact).expect("small");
            let found = marginals(tracks, plots, &dense(&miss, &like), 200);
            // Where two tracks can hardly miss, it tends to one assignment of them alone: two that are
            // almost as good are then off by up to one half. The steepest climb found 0.344 where at
            // most one track prefers a plot to its miss by more than 5, and 0.477 up to 12.
            let prefers = |track: usize| {
                let best = like[track * plots..][..plots].iter().copied().fold(f64::MIN, f64::max);
                best - miss[track] > 5.0
            };
            let most = if (0..tracks).filter(|&t| prefers(t)).count() < 2 { 0.35 } else { 0.5 };
            for (f, e) in found.iter().zip(&exact) {
                prop_assert!(f.is_finite() && (f - e).abs() <= most, "{f} for {e}, at most {most}");
            }
            for row in found.chunks(plots + 1) {
                prop_assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{row:?}");
            }
        }

        /// Why nothing is damped.
        #[test]
        fn no_sweep_moves_a_message_by_more_than_the_one_before(
            rows in 1usize..7, columns in 1usize..7,
            values in proptest::collection::vec(-12.0..40.0f64, 36),
        ) {
            let edges = dense(&vec![0.0; rows], &values[..rows * columns]);
            let mut belief = Belief::default();
            let mut before = f64::INFINITY;
            for sweeps in 1..40 {
                let ended = belief.run(rows, columns, &edges, sweeps, 0.0);
                prop_assert!(ended.moved <= before + 1e-12, "{sweeps}: {} {before}", ended.moved);
                before = ended.moved;
            }
        }

        #[test]
        fn on_a_tree_it_is_exact(
            tracks in 1usize..6,
            values in proptest::collection::vec(-8.0..8.0f64, 12),
        ) {
            // A chain: track i may have plots i and i + 1.
            let edges: Vec<Edge> = (0..2 * tracks)
                .map(|k| Edge { row: (k / 2) as u32, column: (k / 2 + k % 2) as u32, gain: values[k] })
                .collect();
            let plots = tracks + 1;
            let mut like = vec![f64::NEG_INFINITY; tracks * plots];
            edges.iter().for_each(|e| like[e.row as usize * plots + e.column as usize] = e.gain);
            let mut exact = Vec::new();
            Jpda::default().marginals(&vec![0.0; tracks], &like, 100_000, &mut exact).expect("small");
            let found = marginals(tracks, plots, &edges, 400);
            for track in 0..tracks {
                let exact = &exact[track * (plots + 1)..][..plots + 1];
                let found = &found[3 * track..][..3];
                for (f, e) in found.iter().zip([exact[0], exact[track + 1], exact[track + 2]]) {
                    prop_assert!((f - e).abs() < 1e-9, "{f} for {e}");
                }
            }
        }
    }

    /// On a chain each sweep carries what one track knows to the next: after as many sweeps as tracks it is exact. A damped step
    /// would only draw near.
    #[test]
    fn a_chain_is_exact_after_as_many_sweeps_as_it_has_tracks() {
        for tracks in 1..=8_usize {
            let gain = |k: usize| 1.0 + ((k * 7) % 5) as f64 - 0.3 * k as f64;
            let edges: Vec<Edge> = (0..2 * tracks)
                .map(|k| Edge {
                    row: (k / 2) as u32,
                    column: (k / 2 + k % 2) as u32,
                    gain: gain(k),
                })
                .collect();
            let found = marginals(tracks, tracks + 1, &edges, tracks as u32 + 1);
            let settled = marginals(tracks, tracks + 1, &edges, 1_000);
            for (f, s) in found.iter().zip(&settled) {
                assert!((f - s).abs() < 1e-12, "{tracks}: {f} {s}");
            }
        }
    }

    #[test]
    fn hostile_weights_stay_finite() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        let edges = dense(&[-inf, 0.0], &[inf, -1e300, nan, 1e300]);
        let found = marginals(2, 2, &edges, 200);
        assert!(found.iter().all(|b| b.is_finite()), "{found:?}");
        let mut belief = Belief::default();
        assert_eq!(belief.run(0, 0, &[], 20, 1e-3), Ended { sweeps: 1, moved: 0.0 });
        belief.run(2, 1, &[], 20, 1e-3);
        assert_eq!((belief.miss(0), belief.miss(1)), (1.0, 1.0));
    }

    #[test]
    fn a_thousand_that_are_all_alike_share_alike_within_the_sweeps() {
        let n = 300;
        let edges = dense(&vec![0.0; n], &vec![3.0; n * n]);
        let mut belief = Belief::default();
        let ended = belief.run(n, n, &edges, MOST_SWEEPS, STILL);
        assert!(ended.sweeps <= MOST_SWEEPS);
        for row in 0..n {
            let sum: f64 = belief.edges_of(row).map(|e| belief.share(row, e)).sum();
            assert!((sum + belief.miss(row) - 1.0).abs() < 1e-12);
            assert!(
                belief.edges_of(row).all(|e| (belief.share(row, e) * n as f64 - 1.0).abs() < 0.1)
            );
        }
    }
}
