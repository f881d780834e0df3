//! Candidates: a uniform grid of the plots, filled by a counting sort, searched by boxes.

use crate::frames::{Point2, center};

/// Plots sorted by cell.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    origin: Point2<f64>,
    cell: f64,
    inverse_cell: f64,
    last_column: u32,
    last_row: u32,
    /// First entry of each cell, and one more.
    starts: Vec<u32>,
    /// Plot indices, cell after cell, ascending within a cell.
    entries: Vec<u32>,
    cell_of: Vec<usize>,
    /// Plots in the fullest cell.
    fullest: u32,
}

impl Grid {
    /// Fills the grid. `cell_m` is the wished cell size (about the size of a search box); it grows
    /// where the extent would need more than four cells a plot. Positions must be finite.
    pub fn fill(&mut self, positions_m: &[Point2<f64>], cell_m: f64) {
        let first = positions_m.first().copied().unwrap_or_default();
        let (mut low, mut high) = (first, first);
        for p in positions_m {
            low = Point2::new(smaller(p.x, low.x), smaller(p.y, low.y));
            high = Point2::new(larger(p.x, high.x), larger(p.y, high.y));
        }
        let extent = high - low;
        let limit = (4 * positions_m.len() + 16) as f64;
        let mut cell = cell_m.max(1e-3);
        while (extent.x / cell + 1.0) * (extent.y / cell + 1.0) > limit {
            cell *= 2.0;
        }
        self.origin = low;
        (self.cell, self.inverse_cell) = (cell, 1.0 / cell);
        self.last_column = (extent.x * self.inverse_cell) as u32;
        self.last_row = (extent.y * self.inverse_cell) as u32;
        let cells = self.columns() * (self.last_row as usize + 1);
        let mut cell_of = std::mem::take(&mut self.cell_of);
        cell_of.clear();
        cell_of
            .extend(positions_m.iter().map(|p| self.column(p.x) + self.row(p.y) * self.columns()));
        // One place ahead of its own, so that filling the cells moves every start where it belongs.
        self.starts.clear();
        self.starts.resize(cells + 2, 0);
        for &cell in &cell_of {
            self.starts[cell + 2] += 1;
        }
        let mut before = 0;
        self.fullest = 0;
        for start in &mut self.starts {
            self.fullest = self.fullest.max(*start);
            before += *start;
            *start = before;
        }
        self.entries.clear();
        self.entries.resize(positions_m.len(), 0);
        for (index, &cell) in cell_of.iter().enumerate() {
            let slot = &mut self.starts[cell + 1];
            self.entries[*slot as usize] = index as u32;
            *slot += 1;
        }
        self.cell_of = cell_of;
    }

    /// The indices of the plots in the order of their cells; what is laid out in this order is read in one
    /// sweep by [`Self::runs`].
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.entries
    }

    /// Calls `visit` with the runs of places in [`Self::order`] whose cells touch the box, row by row; the
    /// caller tests the plots themselves.
    #[inline]
    pub fn runs(
        &self,
        low: Point2<f64>,
        high: Point2<f64>,
        mut visit: impl FnMut(std::ops::Range<usize>),
    ) {
        if self.misses(low, high) {
            return;
        }
        let (c0, c1) = (self.column(low.x), self.column(high.x));
        for row in self.row(low.y)..=self.row(high.y) {
            let base = row * self.columns();
            let (from, to) = (self.starts[base + c0], self.starts[base + c1 + 1]);
            if from < to {
                visit(from as usize..to as usize);
            }
        }
    }

    /// No cell touches the box.
    #[inline]
    fn misses(&self, low: Point2<f64>, high: Point2<f64>) -> bool {
        let outside = |lo: f64, hi: f64, origin: f64, last: u32| {
            let end = origin + f64::from(last + 1) * self.cell;
            !(hi >= origin && lo <= end) // also for NaN
        };
        self.entries.is_empty()
            || outside(low.x, high.x, self.origin.x, self.last_column)
            || outside(low.y, high.y, self.origin.y, self.last_row)
    }

    /// Cells (columns, rows) that touch a box that does not miss the grid.
    #[inline]
    fn cells(&self, low: Point2<f64>, high: Point2<f64>) -> [usize; 2] {
        let columns = self.column(high.x).saturating_sub(self.column(low.x)) + 1;
        [columns, self.row(high.y).saturating_sub(self.row(low.y)) + 1]
    }

    /// No more plots than this lie in the cells that touch the box.
    #[inline]
    #[must_use]
    pub fn at_most(&self, low: Point2<f64>, high: Point2<f64>) -> usize {
        if self.misses(low, high) {
            return 0;
        }
        let [columns, rows] = self.cells(low, high);
        columns.saturating_mul(rows).saturating_mul(self.fullest as usize)
    }

    /// The runs of places (see [`Self::runs`]) of a box that is made smaller about its middle until about `most`
    /// plots, or the plots of a few cells, are left. True if it was made smaller.
    pub fn runs_near(
        &self,
        low: Point2<f64>,
        high: Point2<f64>,
        most: usize,
        runs: &mut Vec<std::ops::Range<usize>>,
    ) -> bool {
        runs.clear();
        if self.misses(low, high) {
            return false;
        }
        let middle = center(&low, &high);
        let mut half = (high - low) * 0.5;
        let mut smaller = false;
        let density = self.entries.len() as f64 / (self.starts.len() as f64 - 1.0).max(1.0);
        for tries in 0..HALVINGS {
            let (low, high) = (middle - half, middle + half);
            let [columns, rows] = self.cells(low, high);
            let expected = density * columns as f64 * rows as f64;
            let last = tries + 1 == HALVINGS || columns * rows <= 4;
            if last || (rows <= most && expected <= 2.0 * most as f64) {
                runs.clear();
                let mut found = 0;
                self.runs(low, high, |run| {
                    found += run.len();
                    runs.push(run);
                });
                if last || found <= most {
                    break;
                }
            }
            (half, smaller) = (half * 0.5, true);
        }
        smaller
    }

    /// [`Self::visit`] with about `most` indices at most: of a box that holds more, those near its middle, and of those
    /// every so many. `runs` is scratch.
    pub fn visit_near(
        &self,
        low: Point2<f64>,
        high: Point2<f64>,
        most: usize,
        runs: &mut Vec<std::ops::Range<usize>>,
        mut visit: impl FnMut(usize),
    ) {
        if self.at_most(low, high) <= most {
            return self.visit(low, high, visit);
        }
        self.runs_near(low, high, most, runs);
        let places: usize = runs.iter().map(std::ops::Range::len).sum();
        let stride = places.div_ceil(most.max(1)).max(1);
        for place in every(runs, stride, 0) {
            visit(self.entries[place] as usize);
        }
    }

    /// The cell of a position and an order of the positions within it (along a curve that keeps what is near
    /// together).
    #[must_use]
    pub fn cell_at(&self, position_m: Point2<f64>) -> (usize, u64) {
        let (column, row) = (self.column(position_m.x), self.row(position_m.y));
        // `as u32` saturates: beyond the cell's edge gives the edge.
        let part = |x: f64, origin: f64, index: usize| {
            (((x - origin) * self.inverse_cell - index as f64) * 65_536.0) as u32 & 0xFFFF
        };
        let x = part(position_m.x, self.origin.x, column);
        let y = part(position_m.y, self.origin.y, row);
        let woven = (0..16).fold(0, |code, bit| {
            code | (u64::from(x >> bit & 1) << (2 * bit))
                | (u64::from(y >> bit & 1) << (2 * bit + 1))
        });
        (column + row * self.columns(), woven)
    }

    /// Calls `visit` with the index of every plot whose cell touches the box; the caller tests the
    /// plot itself. Order: row by row, cell by cell, ascending within a cell.
    #[inline]
    pub fn visit(&self, low: Point2<f64>, high: Point2<f64>, mut visit: impl FnMut(usize)) {
        self.runs(low, high, |run| {
            for &entry in &self.entries[run] {
                visit(entry as usize);
            }
        });
    }

    #[inline]
    fn columns(&self) -> usize {
        self.last_column as usize + 1
    }

    // `as u32` saturates: below the origin gives 0.
    #[inline]
    fn column(&self, x: f64) -> usize {
        (((x - self.origin.x) * self.inverse_cell) as u32).min(self.last_column) as usize
    }

    #[inline]
    fn row(&self, y: f64) -> usize {
        (((y - self.origin.y) * self.inverse_cell) as u32).min(self.last_row) as usize
    }
}

/// Every so many of the places of `runs`, beginning with number `first`; what lies between costs nothing.
pub fn every(
    runs: &[std::ops::Range<usize>],
    stride: usize,
    first: usize,
) -> impl Iterator<Item = usize> + '_ {
    let mut skip = first;
    runs.iter().flat_map(move |run| {
        let from = run.start + skip.min(run.len());
        let taken = (run.end - from).div_ceil(stride.max(1));
        skip = if from < run.end { taken * stride - (run.end - from) } else { skip - run.len() };
        (from..run.end).step_by(stride.max(1))
    })
}

/// Times that a box is halved: from the whole earth to a metre.
const HALVINGS: usize = 26;

// One instruction each: nobody asks for the order of a NaN here.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector2;
    use proptest::prelude::*;

    /// The place that is as far east as north.
    fn both(m: f64) -> Point2<f64> {
        Point2::new(m, m)
    }

    proptest! {
        #[test]
        fn no_plot_inside_the_box_is_missed(
            points in proptest::collection::vec((-500.0..500.0f64, -500.0..500.0f64), 0..60),
            centre in (-600.0..600.0f64, -600.0..600.0f64),
            half in 0.0..200.0f64,
            cell in 1.0..100.0f64,
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
            let mut grid = Grid::default();
            grid.fill(&points, cell);
            let low = Point2::new(centre.0 - half, centre.1 - half);
            let high = Point2::new(centre.0 + half, centre.1 + half);
            let inside = |p: &Point2<f64>| {
                p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y
            };
            let mut seen = Vec::new();
            grid.visit(low, high, |i| seen.push(i));
            let mut found: Vec<_> = seen.iter().copied().filter(|&i| inside(&points[i])).collect();
            found.sort_unstable();
            let all: Vec<_> = (0..points.len()).filter(|&i| inside(&points[i])).collect();
            prop_assert_eq!(found, all);
            seen.sort_unstable();
            seen.dedup();
            prop_assert!(seen.len() <= points.len());
        }
    }

    #[test]
    fn a_crowded_box_shrinks_about_its_middle_and_a_crowded_cell_is_given_whole() {
        let mut grid = Grid::default();
        let spread: Vec<_> =
            (0..10_000).map(|k| Point2::new(f64::from(k % 100), f64::from(k / 100))).collect();
        grid.fill(&spread, 1.0);
        let (low, high) = (both(-1e6), both(1e6));
        let mut runs = Vec::new();
        // About a middle that lies in the scene.
        let middle = Point2::new(50.0, 50.0);
        assert!(grid.runs_near(low + middle.coords, high + middle.coords, 500, &mut runs));
        let found: usize = runs.iter().map(|r| r.len()).sum();
        assert!((100..=500).contains(&found), "{found}");
        let place = runs[0].start;
        assert!((spread[grid.order()[place] as usize] - middle).norm() < 30.0);
        assert!(grid.at_most(low, high) >= 10_000);
        assert!(!grid.runs_near(middle, middle, 500, &mut runs));
        // All in one cell: no box is small enough.
        grid.fill(&vec![Point2::new(3.0, 4.0); 5_000], 25.0);
        grid.runs_near(low, high, 500, &mut runs);
        assert_eq!(runs.iter().map(|r| r.len()).sum::<usize>(), 5_000);
        let whole: Vec<usize> = every(&[3..7, 7..7, 9..20], 3, 2).collect();
        assert_eq!(whole, [5, 10, 13, 16, 19]);
        grid.runs_near(both(f64::NAN), high, 500, &mut runs);
        assert!(runs.is_empty());
        for beside in [Vector2::repeat(f64::NAN), Vector2::new(1e9, 0.0), Vector2::new(0.0, -1e9)] {
            runs.push(0..1);
            assert!(
                !grid.runs_near(low + beside, high + beside, 500, &mut runs) && runs.is_empty()
            );
            assert_eq!(grid.at_most(low + beside, high + beside), 0);
        }
    }

    #[test]
    fn a_wide_scene_has_four_cells_a_plot_at_most_and_a_small_one_those_that_were_wished() {
        let mut grid = Grid::default();
        for (count, extent) in [(1u32, 0.0), (2, 1e7), (100, 1e6), (1_000, 300.0), (1_000, 30.0)] {
            let at = |k: u32| f64::from(k) / f64::from(count.max(2) - 1) * extent;
            let line: Vec<_> = (0..count).map(|k| Point2::new(at(k), at(k * 7 % count))).collect();
            grid.fill(&line, 10.0);
            let cells = grid.starts.len() - 2;
            assert!(cells <= 4 * count as usize + 16, "{count} {extent}: {cells}");
            // No wider than what keeps to that: half the cells would not.
            let halved = (2.0 * extent / grid.cell + 1.0).powi(2);
            assert!(grid.cell == 10.0 || halved > f64::from(4 * count + 16), "{count} {extent}");
            assert_eq!(grid.cells(line[0], line[0]), [1, 1]);
            let all = grid.cells(Point2::origin(), both(extent));
            assert_eq!(all[0] * all[1], cells, "{count} {extent}");
            // The fullest cell, counted.
            let mut per_cell = std::collections::BTreeMap::<usize, usize>::new();
            for p in &line {
                *per_cell.entry(grid.cell_at(*p).0).or_default() += 1;
            }
            assert_eq!(per_cell.values().max(), Some(&(grid.fullest as usize)), "{count} {extent}");
            assert_eq!(grid.at_most(line[0], line[0]), grid.fullest as usize);
        }
    }

    #[test]
    fn the_order_within_a_cell_weaves_both_axes() {
        let mut grid = Grid::default();
        grid.fill(&[Point2::origin(), Point2::new(16.0, 16.0)], 16.0);
        let code = |x: f64, y: f64| grid.cell_at(Point2::new(x, y));
        // The highest bits are the quarters of the cell: east one, north two.
        assert_eq!(code(0.0, 0.0), (0, 0));
        assert_eq!(code(8.0, 0.0), (0, 1 << 30));
        assert_eq!(code(0.0, 8.0), (0, 2 << 30));
        assert_eq!(code(12.0, 4.0), (0, (1 << 30) + (0b11 << 28)));
        // The lowest is a 65 536th.
        assert_eq!(code(16.0 / 65_536.0, 0.0), (0, 1));
        assert_eq!(code(0.0, 3.0 * 16.0 / 65_536.0), (0, 0b1010));
        assert_eq!((code(16.0, 0.0).0, code(0.0, 16.0).0, code(20.0, 20.0).0), (1, 2, 3));
    }

    #[test]
    fn of_a_crowd_every_so_many_are_visited() {
        let mut grid = Grid::default();
        let spread: Vec<_> =
            (0..900).map(|k| Point2::new(f64::from(k % 30), f64::from(k / 30))).collect();
        grid.fill(&spread, 1.0);
        let visited = |low: Point2<f64>, high: Point2<f64>, most: usize| {
            let mut seen = Vec::new();
            grid.visit_near(low, high, most, &mut Vec::new(), |i| seen.push(i));
            seen
        };
        let (low, high) = (both(-1.0), both(40.0));
        assert_eq!(visited(low, high, 900).len(), 900);
        for most in [1, 7, 50, 200] {
            let seen = visited(low, high, most);
            assert!(!seen.is_empty() && seen.len() <= most, "{most}: {}", seen.len());
            let distinct: std::collections::BTreeSet<_> = seen.iter().collect();
            assert_eq!(distinct.len(), seen.len());
            // About the middle of the box.
            let far = seen.iter().map(|&i| (spread[i] - both(19.5)).amax());
            let half = (most as f64).sqrt().max(3.0);
            assert!(far.fold(0.0, f64::max) <= half, "{most}: {seen:?}");
        }
        // All in one cell: every fifth.
        grid.fill(&vec![Point2::new(3.0, 4.0); 500], 25.0);
        let mut seen = Vec::new();
        grid.visit_near(low, high, 100, &mut Vec::new(), |i| seen.push(i));
        assert_eq!(seen, (0..500).step_by(5).collect::<Vec<_>>());
    }

    #[test]
    fn extremes_are_survived() {
        let mut grid = Grid::default();
        grid.fill(&[], 10.0);
        grid.visit(both(-1e9), both(1e9), |_| panic!("empty"));
        grid.fill(&[Point2::new(-1e12, 0.0), Point2::new(1e12, 5.0)], 10.0);
        let mut count = 0;
        grid.visit(both(-2e12), both(2e12), |_| count += 1);
        assert_eq!(count, 2);
        grid.visit(both(f64::NAN), both(1.0), |_| panic!("NaN box"));
    }
}
