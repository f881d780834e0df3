//! Candidates: a uniform grid of the plots, filled by a counting sort, searched by boxes.

use crate::frames::Vector2;

/// Plots sorted by cell.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    origin: Vector2<f64>,
    cell: f64,
    inverse_cell: f64,
    columns: usize,
    rows: usize,
    /// First entry of each cell, and one more.
    starts: Vec<u32>,
    /// Plot indices, cell after cell, ascending within a cell.
    entries: Vec<u32>,
    cell_of: Vec<u32>,
}

impl Grid {
    /// Fills the grid. `cell_m` is the wished cell size (about the size of a search box); it grows
    /// where the extent would need more than four cells a plot. Positions must be finite.
    pub fn fill(&mut self, positions_m: &[Vector2<f64>], cell_m: f64) {
        let mut low = Vector2::repeat(f64::INFINITY);
        let mut high = Vector2::repeat(f64::NEG_INFINITY);
        for p in positions_m {
            low = low.inf(p);
            high = high.sup(p);
        }
        if positions_m.is_empty() {
            (low, high) = (Vector2::zeros(), Vector2::zeros());
        }
        let extent = high - low;
        let limit = (4 * positions_m.len() + 16) as f64;
        let mut cell = cell_m.max(1e-3);
        while (extent.x / cell + 1.0) * (extent.y / cell + 1.0) > limit {
            cell *= 2.0;
        }
        self.origin = low;
        (self.cell, self.inverse_cell) = (cell, 1.0 / cell);
        self.columns = (extent.x * self.inverse_cell) as usize + 1;
        self.rows = (extent.y * self.inverse_cell) as usize + 1;
        self.starts.clear();
        self.starts.resize(self.columns * self.rows + 1, 0);
        self.cell_of.clear();
        for p in positions_m {
            let c = self.column(p.x) + self.row(p.y) * self.columns;
            self.cell_of.push(c as u32);
            self.starts[c + 1] += 1;
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        self.entries.clear();
        self.entries.resize(positions_m.len(), 0);
        // From the back, so that indices ascend within a cell and `starts` ends as it began.
        for (index, &c) in self.cell_of.iter().enumerate().rev() {
            let slot = &mut self.starts[c as usize + 1];
            *slot -= 1;
            self.entries[*slot as usize] = index as u32;
        }
        self.starts.remove(0);
        self.starts.push(positions_m.len() as u32);
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
        low: Vector2<f64>,
        high: Vector2<f64>,
        mut visit: impl FnMut(std::ops::Range<usize>),
    ) {
        let outside = |lo: f64, hi: f64, origin: f64, cells: usize| {
            let end = origin + cells as f64 * self.cell;
            !(hi >= origin && lo <= end) // also for NaN
        };
        if self.entries.is_empty()
            || outside(low.x, high.x, self.origin.x, self.columns)
            || outside(low.y, high.y, self.origin.y, self.rows)
        {
            return;
        }
        let (c0, c1) = (self.column(low.x), self.column(high.x));
        for row in self.row(low.y)..=self.row(high.y) {
            let base = row * self.columns;
            let (from, to) = (self.starts[base + c0], self.starts[base + c1 + 1]);
            if from < to {
                visit(from as usize..to as usize);
            }
        }
    }

    /// Calls `visit` with the index of every plot whose cell touches the box; the caller tests the
    /// plot itself. Order: row by row, cell by cell, ascending within a cell.
    #[inline]
    pub fn visit(&self, low: Vector2<f64>, high: Vector2<f64>, mut visit: impl FnMut(usize)) {
        self.runs(low, high, |run| {
            for &entry in &self.entries[run] {
                visit(entry as usize);
            }
        });
    }

    // `as usize` saturates: below the origin gives 0.
    fn column(&self, x: f64) -> usize {
        (((x - self.origin.x) * self.inverse_cell) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.origin.y) * self.inverse_cell) as usize).min(self.rows - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_plot_inside_the_box_is_missed(
            points in proptest::collection::vec((-500.0..500.0f64, -500.0..500.0f64), 0..60),
            centre in (-600.0..600.0f64, -600.0..600.0f64),
            half in 0.0..200.0f64,
            cell in 1.0..100.0f64,
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y)| Vector2::new(x, y)).collect();
            let mut grid = Grid::default();
            grid.fill(&points, cell);
            let low = Vector2::new(centre.0 - half, centre.1 - half);
            let high = Vector2::new(centre.0 + half, centre.1 + half);
            let inside = |p: &Vector2<f64>| {
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
    fn extremes_are_survived() {
        let mut grid = Grid::default();
        grid.fill(&[], 10.0);
        grid.visit(Vector2::repeat(-1e9), Vector2::repeat(1e9), |_| panic!("empty"));
        grid.fill(&[Vector2::new(-1e12, 0.0), Vector2::new(1e12, 5.0)], 10.0);
        let mut count = 0;
        grid.visit(Vector2::repeat(-2e12), Vector2::repeat(2e12), |_| count += 1);
        assert_eq!(count, 2);
        grid.visit(Vector2::repeat(f64::NAN), Vector2::repeat(1.0), |_| panic!("NaN box"));
    }
}
