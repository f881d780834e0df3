//! Cheapest one-to-one pairing of rows and columns by shortest augmenting paths.
//!
//! Source: R. Jonker, A. Volgenant, "A shortest augmenting path algorithm for dense and sparse linear
//! assignment problems", Computing 38 (1987). Costs are pairs (forbidden cells, cost), compared in
//! that order: a forbidden cell is no large number that would swallow the finite ones.

/// A cost in the ordered group of the solver: forbidden cells first, then the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost {
    forbidden: i64,
    value: f64,
}

impl Cost {
    const ZERO: Self = Self { forbidden: 0, value: 0.0 };

    fn plus(self, other: Self) -> Self {
        Self { forbidden: self.forbidden + other.forbidden, value: self.value + other.value }
    }

    fn minus(self, other: Self) -> Self {
        Self { forbidden: self.forbidden - other.forbidden, value: self.value - other.value }
    }

    fn below(self, other: Self) -> bool {
        self.forbidden.cmp(&other.forbidden).then(self.value.total_cmp(&other.value)).is_lt()
    }
}

/// What [`Solver::solve`] found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assignment {
    /// Column of each row; `None` for rows that are left over when there are more rows than columns.
    pub column_of_row: Vec<Option<usize>>,
    /// Sum of the costs of the pairs that are not forbidden, added in row order.
    pub total: f64,
    /// Forbidden cells that had to be used to reach `min(rows, columns)` pairs.
    pub forbidden_used: usize,
}

/// Work space of the assignment; keep it to allocate nothing from call to call.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    row_price: Vec<Cost>,
    column_price: Vec<Cost>,
    row_of_column: Vec<usize>,
    way: Vec<usize>,
    least: Vec<Cost>,
    done: Vec<bool>,
    found: Vec<Option<usize>>,
}

const NONE: usize = usize::MAX;

impl Solver {
    /// The assignment of `min(rows, columns)` pairs with the fewest forbidden cells and, among
    /// those, the least total cost.
    ///
    /// `cost(row, column)` is the cost of a cell; `None`, NaN and ±∞ are forbidden. Ties go to the
    /// lower column index. `O(r² c)` with `r` the smaller side.
    pub fn solve(
        &mut self,
        rows: usize,
        columns: usize,
        cost: impl Fn(usize, usize) -> Option<f64>,
    ) -> Assignment {
        let cell = |r: usize, c: usize| match cost(r, c) {
            Some(value) if value.is_finite() => Cost { forbidden: 0, value },
            _ => Cost { forbidden: 1, value: 0.0 },
        };
        let mut column_of_row = vec![None; rows];
        if rows <= columns {
            self.augment_all(rows, columns, cell);
            for (column, &row) in self.row_of_column.iter().enumerate() {
                if row != NONE {
                    column_of_row[row] = Some(column);
                }
            }
        } else {
            self.augment_all(columns, rows, |r, c| cell(c, r));
            for (row, &column) in self.row_of_column.iter().enumerate() {
                if column != NONE {
                    column_of_row[row] = Some(column);
                }
            }
        }
        let (mut total, mut forbidden_used) = (0.0, 0);
        for (row, column) in column_of_row.iter().enumerate() {
            if let Some(column) = *column {
                let used = cell(row, column);
                total += used.value;
                forbidden_used += used.forbidden as usize;
            }
        }
        Assignment { column_of_row, total, forbidden_used }
    }

    /// Adds row after row by a shortest path in reduced costs; `rows ≤ columns`.
    fn augment_all(&mut self, rows: usize, columns: usize, cell: impl Fn(usize, usize) -> Cost) {
        refill(&mut self.row_price, rows, Cost::ZERO);
        refill(&mut self.column_price, columns, Cost::ZERO);
        refill(&mut self.row_of_column, columns, NONE);
        refill(&mut self.way, columns, NONE);
        let far = Cost { forbidden: i64::MAX / 4, value: 0.0 };
        for first in 0..rows {
            refill(&mut self.least, columns, far);
            refill(&mut self.done, columns, false);
            // `way[c]`: the column before `c` on the path, NONE at its start.
            let (mut row, mut from) = (first, NONE);
            let mut length = Cost::ZERO;
            let end = loop {
                let mut next = NONE;
                let mut shortest = far;
                for column in 0..columns {
                    if self.done[column] {
                        continue;
                    }
                    let reduced = cell(row, column)
                        .minus(self.row_price[row])
                        .minus(self.column_price[column])
                        .plus(length);
                    if reduced.below(self.least[column]) {
                        self.least[column] = reduced;
                        self.way[column] = from;
                    }
                    if self.least[column].below(shortest) {
                        shortest = self.least[column];
                        next = column;
                    }
                }
                if next == NONE {
                    return; // cannot happen while a column is free; nothing to pair then
                }
                self.done[next] = true;
                length = shortest;
                from = next;
                row = self.row_of_column[next];
                if row == NONE {
                    break next;
                }
            };
            // Prices: what lies inside the shortest-path tree moves by the rest of the way.
            self.row_price[first] = self.row_price[first].plus(length);
            for column in 0..columns {
                if self.done[column] && column != end {
                    let rest = length.minus(self.least[column]);
                    self.column_price[column] = self.column_price[column].minus(rest);
                    let row = self.row_of_column[column];
                    self.row_price[row] = self.row_price[row].plus(rest);
                }
            }
            let mut column = end;
            while self.way[column] != NONE {
                self.row_of_column[column] = self.row_of_column[self.way[column]];
                column = self.way[column];
            }
            self.row_of_column[column] = first;
        }
    }

    /// Global nearest neighbour: the cheapest one-to-one set of pairs and misses.
    ///
    /// `pair(track, plot)` is the cost of the pair minus the cost of missing that track (each track
    /// has its own, private miss, so the difference says it all); `None` lies outside the gate, and a
    /// pair that costs more than the miss is never taken. Gives the plot of each track.
    pub fn pairs_and_misses(
        &mut self,
        tracks: usize,
        plots: usize,
        pair: impl Fn(usize, usize) -> Option<f64>,
    ) -> &[Option<usize>] {
        let gain = |track, plot| pair(track, plot).filter(|&c| c < 0.0 && c.is_finite());
        if tracks == 2 {
            let both = [0, 1].map(|track| BestTwo::of(plots, |plot| gain(track, plot)));
            self.found.clear();
            self.found.extend(BestTwo::together(both));
            return &self.found;
        }
        let solved = self.solve(tracks, plots + tracks, |track, column| {
            if column >= plots { Some(0.0) } else { gain(track, column) }
        });
        self.found = solved.column_of_row;
        for column in &mut self.found {
            *column = column.filter(|&c| c < plots);
        }
        &self.found
    }
}

/// What one of two tracks likes best and what it takes if the other one has that.
#[derive(Clone, Copy, Debug)]
struct BestTwo {
    first: (f64, Option<usize>),
    second: (f64, Option<usize>),
}

impl BestTwo {
    fn of(plots: usize, cost: impl Fn(usize) -> Option<f64>) -> Self {
        let miss = (0.0, None);
        let mut best = Self { first: miss, second: miss };
        for plot in 0..plots {
            let Some(cost) = cost(plot) else { continue };
            if cost < best.first.0 {
                best = Self { first: (cost, Some(plot)), second: best.first };
            } else if cost < best.second.0 {
                best.second = (cost, Some(plot));
            }
        }
        best
    }

    /// The cheapest pair of choices; on a tie the first track has its way.
    fn together([a, b]: [Self; 2]) -> [Option<usize>; 2] {
        if a.first.1.is_none() || a.first.1 != b.first.1 {
            return [a.first.1, b.first.1];
        }
        if a.first.0 + b.second.0 <= a.second.0 + b.first.0 {
            [a.first.1, b.second.1]
        } else {
            [a.second.1, b.first.1]
        }
    }
}

fn refill<T: Clone>(v: &mut Vec<T>, len: usize, value: T) {
    v.clear();
    v.resize(len, value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(rows: usize, columns: usize, cost: &[Vec<f64>]) -> (usize, f64) {
        fn go(r: usize, rows: usize, skip: usize, used: u32, cost: &[Vec<f64>]) -> (usize, f64) {
            if r == rows {
                return (0, 0.0);
            }
            let mut best = (usize::MAX, 0.0);
            let mut take = |f: usize, v: f64| {
                if f < best.0 || (f == best.0 && v < best.1) {
                    best = (f, v);
                }
            };
            for (c, &value) in cost[r].iter().enumerate() {
                if used & (1 << c) == 0 {
                    let (f, v) = go(r + 1, rows, skip, used | (1 << c), cost);
                    if f != usize::MAX {
                        if value.is_finite() { take(f, v + value) } else { take(f + 1, v) }
                    }
                }
            }
            if skip > 0 {
                let (f, v) = go(r + 1, rows, skip - 1, used, cost);
                if f != usize::MAX {
                    take(f, v);
                }
            }
            best
        }
        go(0, rows, rows.saturating_sub(columns), 0, cost)
    }

    proptest! {
        #[test]
        fn it_is_the_best_of_all_permutations(
            rows in 1usize..6, columns in 1usize..6,
            cells in proptest::collection::vec((-5i32..100, 0u8..4), 36),
        ) {
            let cost: Vec<Vec<f64>> = (0..rows)
                .map(|r| (0..columns).map(|c| {
                    let (value, mask) = cells[r * 6 + c];
                    if mask == 0 { f64::INFINITY } else { f64::from(value) }
                }).collect())
                .collect();
            let found = Solver::default().solve(rows, columns, |r, c| Some(cost[r][c]));
            let (forbidden, total) = brute(rows, columns, &cost);
            prop_assert_eq!(found.column_of_row.iter().flatten().count(), rows.min(columns));
            prop_assert_eq!(found.forbidden_used, forbidden);
            prop_assert!((found.total - total).abs() < 1e-9);
        }

        #[test]
        fn two_tracks_are_paired_as_well_as_any_number(
            plots in 0usize..5,
            cells in proptest::collection::vec(proptest::option::of(-9i32..3), 10),
        ) {
            let cost = |track: usize, plot: usize| cells[5 * track + plot].map(f64::from);
            let mut solver = Solver::default();
            let best = solver.solve(2, plots + 2, |track, column| {
                if column >= plots { Some(0.0) } else { cost(track, column) }
            });
            let found = solver.pairs_and_misses(2, plots, cost).to_vec();
            prop_assert!(found[0].is_none() || found[0] != found[1], "{found:?}");
            let own = |track: usize| {
                let Some(plot) = found[track] else { return Ok(0.0) };
                cost(track, plot).ok_or("outside the gate")
            };
            prop_assert_eq!(own(0).and_then(|a| Ok(a + own(1)?)), Ok(best.total), "{:?}", found);
        }
    }

    #[test]
    fn hard_cases() {
        let nan = f64::NAN;
        for (name, rows, columns, cost, pairs, forbidden, total) in [
            ("nothing", 0, 0, vec![], 0, 0, 0.0),
            ("no column", 2, 0, vec![vec![], vec![]], 0, 0, 0.0),
            ("all NaN", 2, 2, vec![vec![nan; 2]; 2], 2, 2, 0.0),
            ("all equal", 3, 3, vec![vec![7.0; 3]; 3], 3, 0, 21.0),
            ("huge beside small", 2, 2, vec![vec![1e15, 1.0], vec![2.0, 1e300]], 2, 0, 3.0),
            ("masked", 2, 2, vec![vec![1.0, f64::INFINITY], vec![1e9, f64::INFINITY]], 2, 1, 1.0),
        ] {
            let found = Solver::default().solve(rows, columns, |r: usize, c| Some(cost[r][c]));
            assert_eq!(found.column_of_row.iter().flatten().count(), pairs, "{name}");
            assert_eq!(found.forbidden_used, forbidden, "{name}");
            assert_eq!(found.total, total, "{name}");
        }
    }

    #[test]
    fn a_miss_is_cheaper_than_a_bad_pair() {
        let cost = [[Some(-3.0), Some(2.0)], [Some(-4.0), None]];
        let mut solver = Solver::default();
        assert_eq!(solver.pairs_and_misses(2, 2, |t, p| cost[t][p]), [None, Some(0)]);
    }
}
