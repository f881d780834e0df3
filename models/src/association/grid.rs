//! Candidates: a uniform grid of the plots, filled by a counting sort, searched by boxes.

use crate::frames::Vector2;

/// Plots sorted by cell.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    origin: Vector2<f64>,
    cell: f64,
    inverse_cell: f64,
    last_column: u32,
    last_row: u32,
    /// First entry of each cell, and one more.
    starts: Vec<u32>,
    /// Plot indices, cell after cell, ascending within a cell.
    entries: Vec<u32>,
    cell_of: Vec<usize>,
}

impl Grid {
    /// Fills the grid. `cell_m` is the wished cell size (about the size of a search box); it grows
    /// where the extent would need more than four cells a plot. Positions must be finite.
    pub fn fill(&mut self, positions_m: &[Vector2<f64>], cell_m: f64) {
        let first = positions_m.first().copied().unwrap_or_default();
        let (mut low, mut high) = (first, first);
        for p in positions_m {
            low = Vector2::new(smaller(p.x, low.x), smaller(p.y, low.y));
            high = Vector2::new(larger(p.x, high.x), larger(p.y, high.y));
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
        for start in &mut self.starts {
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
        low: Vector2<f64>,
        high: Vector2<f64>,
        mut visit: impl FnMut(std::ops::Range<usize>),
    ) {
        let outside = |lo: f64, hi: f64, origin: f64, last: u32| {
            let end = origin + f64::from(last + 1) * self.cell;
            !(hi >= origin && lo <= end) // also for NaN
        };
        if self.entries.is_empty()
            || outside(low.x, high.x, self.origin.x, self.last_column)
            || outside(low.y, high.y, self.origin.y, self.last_row)
        {
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
