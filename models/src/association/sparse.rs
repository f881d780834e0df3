//! The cheapest one-to-one set of pairs and misses from a list of pairs, within a counted budget.
//!
//! Shortest augmenting paths with prices, as in [`super::assignment`], but over the pairs that exist: a row's search
//! ends where the nearest free column or the cheapest miss is, so far rows cost nothing. `O(pairs)` for each row at
//! most, mostly a handful. When the budget is used up, the rows that are left take their cheapest free column.
//!
//! Source: R. Jonker, A. Volgenant, Computing 38 (1987), section 4 (sparse problems).

use super::lbp::Edge;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No column, no row.
const NONE: u32 = u32::MAX;

/// Work space; keep it to allocate nothing from call to call.
#[derive(Clone, Debug, Default)]
pub struct Sparse {
    starts: Vec<u32>,
    row_price: Vec<f64>,
    column_price: Vec<f64>,
    row_of: Vec<u32>,
    column_of: Vec<u32>,
    least: Vec<f64>,
    way: Vec<u32>,
    done: Vec<bool>,
    touched: Vec<u32>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl Sparse {
    /// Pairs rows and columns so that the sum of the gains is greatest; a pair without a gain is never taken.
    ///
    /// `edges` are sorted by row. Each look at a pair takes one from `budget`. Gives the column of each row.
    pub fn pairs(
        &mut self,
        rows: usize,
        columns: usize,
        edges: &[Edge],
        budget: &mut u64,
    ) -> impl Iterator<Item = Option<u32>> + '_ {
        self.begin(rows, columns, edges);
        for row in 0..rows {
            if !self.augment(row, edges, budget) {
                self.take_cheapest(row, edges);
            }
        }
        self.column_of.iter().map(|&c| (c != NONE).then_some(c))
    }

    fn begin(&mut self, rows: usize, columns: usize, edges: &[Edge]) {
        self.starts.clear();
        self.starts.resize(rows + 1, 0);
        edges.iter().for_each(|edge| self.starts[edge.row as usize + 1] += 1);
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // The price of a row is what its cheapest choice costs; a miss costs nothing.
        self.row_price.clear();
        self.row_price.extend((0..rows).map(|row| {
            let own = &edges[self.starts[row] as usize..self.starts[row + 1] as usize];
            own.iter().filter_map(cost).fold(0.0, f64::min)
        }));
        for (numbers, value) in [(&mut self.column_price, 0.0), (&mut self.least, f64::INFINITY)] {
            numbers.clear();
            numbers.resize(columns, value);
        }
        for (places, count) in
            [(&mut self.row_of, columns), (&mut self.way, columns), (&mut self.column_of, rows)]
        {
            places.clear();
            places.resize(count, NONE);
        }
        self.done.clear();
        self.done.resize(columns, false);
    }

    /// False if the budget did not last; nothing is changed then.
    fn augment(&mut self, first: usize, edges: &[Edge], budget: &mut u64) -> bool {
        let (mut row, mut length) = (first, 0.0);
        let (mut miss, mut who_misses) = (f64::INFINITY, first);
        self.heap.clear();
        let mut complete = true;
        let end = loop {
            let own = self.starts[row] as usize..self.starts[row + 1] as usize;
            if *budget < own.len() as u64 {
                *budget = 0;
                complete = false;
                break NONE;
            }
            *budget -= own.len() as u64;
            for edge in &edges[own] {
                let (c, Some(cost)) = (edge.column as usize, cost(edge)) else { continue };
                let reduced = (cost - self.row_price[row] - self.column_price[c]).max(0.0);
                if !self.done[c] && length + reduced < self.least[c] {
                    if self.least[c] == f64::INFINITY {
                        self.touched.push(edge.column);
                    }
                    self.least[c] = length + reduced;
                    self.way[c] = row as u32;
                    // A distance is not negative: its bits are in its own order.
                    self.heap.push(Reverse((self.least[c].to_bits(), edge.column)));
                }
            }
            if length - self.row_price[row] < miss {
                (miss, who_misses) = (length - self.row_price[row], row);
            }
            let next = loop {
                match self.heap.pop() {
                    None => break NONE,
                    Some(Reverse((_, c))) if self.done[c as usize] => {}
                    Some(Reverse((_, c))) => break c,
                }
            };
            if next == NONE || self.least[next as usize] >= miss {
                break NONE;
            }
            length = self.least[next as usize];
            if self.row_of[next as usize] == NONE {
                break next;
            }
            self.done[next as usize] = true;
            row = self.row_of[next as usize] as usize;
        };
        if complete {
            let whole = if end == NONE { miss } else { length };
            self.move_prices(first, whole);
            let mut column = end;
            if end == NONE {
                column = std::mem::replace(&mut self.column_of[who_misses], NONE);
            }
            // The columns on the way change hands. A row that misses has given its own away.
            while column != NONE && !(end == NONE && who_misses == first) {
                let row = self.way[column as usize];
                self.row_of[column as usize] = row;
                column = std::mem::replace(&mut self.column_of[row as usize], column);
            }
        }
        for column in self.touched.drain(..) {
            self.least[column as usize] = f64::INFINITY;
            self.done[column as usize] = false;
        }
        complete
    }

    fn move_prices(&mut self, first: usize, whole: f64) {
        self.row_price[first] += whole;
        for &column in &self.touched {
            let c = column as usize;
            if self.done[c] {
                let rest = whole - self.least[c];
                self.column_price[c] -= rest;
                self.row_price[self.row_of[c] as usize] += rest;
            }
        }
    }

    fn take_cheapest(&mut self, row: usize, edges: &[Edge]) {
        let own = &edges[self.starts[row] as usize..self.starts[row + 1] as usize];
        let free = own.iter().filter(|e| self.row_of[e.column as usize] == NONE);
        let best = free.filter(|e| cost(e).is_some()).max_by(|a, b| a.gain.total_cmp(&b.gain));
        if let Some(edge) = best {
            self.row_of[edge.column as usize] = row as u32;
            self.column_of[row] = edge.column;
        }
    }
}

/// What a pair costs beside a miss; only pairs that are better than one are there.
fn cost(edge: &Edge) -> Option<f64> {
    (edge.gain > 0.0 && edge.gain < f64::INFINITY).then_some(-edge.gain)
}

#[cfg(test)]
mod tests {
    use super::super::assignment::Solver;
    use super::*;
    use proptest::prelude::*;

    fn total(edges: &[Edge], pairs: &[Option<u32>]) -> f64 {
        let gain = |row: usize, column: u32| {
            let own = edges.iter().find(|e| e.row as usize == row && e.column == column);
            own.expect("a pair of the list").gain
        };
        pairs.iter().enumerate().filter_map(|(row, c)| c.map(|c| gain(row, c))).sum()
    }

    /// What gains nothing over a miss is a miss, and so is what no number says.
    #[test]
    fn only_pairs_that_are_better_than_a_miss_are_there() {
        for (gain, is_there) in [
            (1e-300, true),
            (0.0, false),
            (-0.0, false),
            (-1.0, false),
            (f64::NAN, false),
            (f64::INFINITY, false),
        ] {
            let edge = Edge { row: 0, column: 0, gain };
            assert_eq!(cost(&edge), is_there.then_some(-gain), "{gain}");
        }
    }

    proptest! {
        #[test]
        fn it_is_as_good_as_the_dense_one_and_one_to_one(
            rows in 1usize..9, columns in 1usize..9,
            cells in proptest::collection::vec(proptest::option::of(-4.0..9.0f64), 81),
        ) {
            let cell = |row: usize, column: usize| cells[9 * row + column];
            let edges: Vec<Edge> = (0..rows * columns)
                .filter_map(|k| {
                    let (row, column) = (k / columns, k % columns);
                    let gain = cell(row, column)?;
                    Some(Edge { row: row as u32, column: column as u32, gain })
                })
                .collect();
            let mut solver = Solver::default();
            let best = solver.solve(rows, columns + rows, |row, column| {
                if column >= columns { Some(0.0) } else { cell(row, column).map(|g| -g) }
            });
            for (budget, slack) in [(u64::MAX, 1e-9), (7, f64::INFINITY)] {
                let mut left = budget;
                let found: Vec<_> =
                    Sparse::default().pairs(rows, columns, &edges, &mut left).collect();
                let mut taken: Vec<u32> = found.iter().flatten().copied().collect();
                let count = taken.len();
                taken.sort_unstable();
                taken.dedup();
                prop_assert_eq!(taken.len(), count, "one column twice");
                prop_assert!(total(&edges, &found) >= -best.total - slack);
                // Nobody misses beside a free column that is better than a miss.
                for edge in &edges {
                    let idle = found[edge.row as usize].is_none() && edge.gain > 0.0;
                    prop_assert!(!idle || taken.contains(&edge.column), "{edge:?} {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_chain_of_thousands_costs_what_its_pairs_are() {
        // Each row likes the column of the one before it a little better than its own: beyond ten rows it
        // is worth that the first misses, and all behind it take the column before theirs.
        let n = 5_000u32;
        let edges: Vec<Edge> = (0..n)
            .flat_map(|row| {
                let own = Edge { row, column: row, gain: 5.0 };
                let before = Edge { row, column: row.saturating_sub(1), gain: 5.5 };
                if row == 0 { vec![own] } else { vec![before, own] }
            })
            .collect();
        let (mut sparse, mut budget) = (Sparse::default(), 1_000_000);
        let found: Vec<_> = sparse.pairs(n as usize, n as usize, &edges, &mut budget).collect();
        let best: Vec<_> = (0..n).map(|row| row.checked_sub(1)).collect();
        assert_eq!(found, best);
        assert!(1_000_000 - budget < 4 * edges.len() as u64, "{budget} left");
    }
}
