//! Points by place: who is near one is found without a look at all.

use crate::frames::Point2;

/// Side of a cell, m: about twice the distances that are asked for.
const CELL_M: f64 = 128.0;
/// Cells each way; what is farther apart shares cells, and is told apart by whoever asks.
const SIDE: usize = 64;

/// Points in cells of a square grid that repeats itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// By cell: its last point, plus one; empty before the first point.
    last: Vec<u32>,
    /// Where each point is, and the one before it in its cell, plus one.
    points: Vec<(Point2<f64>, u32)>,
}

impl Cells {
    pub(super) fn clear(&mut self) {
        self.last.fill(0);
        self.points.clear();
    }

    /// Takes the next point in; they count up from 0.
    pub(super) fn add(&mut self, at_m: Point2<f64>) {
        self.last.resize(SIDE * SIDE, 0);
        let last = &mut self.last[wrapped(cell(at_m.x)) * SIDE + wrapped(cell(at_m.y))];
        let before = std::mem::replace(last, self.points.len() as u32 + 1);
        self.points.push((at_m, before));
    }

    /// Asks of every point within a distance, and of some in the corners beyond it, whether to take it out.
    #[inline]
    pub(super) fn near(
        &mut self,
        at_m: Point2<f64>,
        reach_m: f64,
        mut takes: impl FnMut(usize) -> bool,
    ) {
        if self.points.is_empty() {
            return;
        }
        let ((column, columns), (row, rows)) = (span(at_m.x, reach_m), span(at_m.y, reach_m));
        for x in 0..columns {
            let column = wrapped(column.wrapping_add(x)) * SIDE;
            for y in 0..rows {
                let cell = column + wrapped(row.wrapping_add(y));
                let (mut point, mut behind) = (self.last[cell], 0);
                while point > 0 {
                    let index = point as usize - 1;
                    let (there_m, before) = self.points[index];
                    let off_m = there_m - at_m;
                    let near = off_m.x.abs() <= reach_m && off_m.y.abs() <= reach_m;
                    if near && takes(index) {
                        match behind {
                            0 => self.last[cell] = before,
                            _ => self.points[behind as usize - 1].1 = before,
                        }
                    } else {
                        behind = point;
                    }
                    point = before;
                }
            }
        }
    }
}

/// The cell of a coordinate: rounded down, without a call.
#[inline]
fn cell(m: f64) -> i64 {
    let whole = (m / CELL_M) as i64;
    whole.saturating_sub(i64::from(whole as f64 * CELL_M > m))
}

#[inline]
fn wrapped(cell: i64) -> usize {
    cell.rem_euclid(SIDE as i64) as usize
}

/// The first cell of one axis within a distance, and how many, each once.
#[inline]
fn span(m: f64, reach_m: f64) -> (i64, i64) {
    let (first, last) = (cell(m - reach_m), cell(m + reach_m));
    (first, last.saturating_sub(first).saturating_add(1).clamp(0, SIDE as i64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all_near(cells: &mut Cells, at_m: Point2<f64>, reach_m: f64) -> Vec<usize> {
        let mut found = Vec::new();
        cells.near(at_m, reach_m, |point| {
            found.push(point);
            point % 3 == 0
        });
        found
    }

    proptest! {
        /// Each point that is within the distance is found, once, until it is taken out.
        #[test]
        fn nobody_within_the_distance_is_overlooked(
            points in prop::collection::vec((-9e3..9e3f64, -9e3..9e3f64), 0..60),
            (x, y) in (-9e3..9e3f64, -9e3..9e3f64),
            reach_m in prop_oneof![0.0..200.0f64, 0.0..2e4f64],
        ) {
            let mut cells = Cells::default();
            for _ in 0..2 {
                cells.clear();
                points.iter().for_each(|(x, y)| cells.add(Point2::new(*x, *y)));
            }
            let at_m = Point2::new(x, y);
            let mut found = all_near(&mut cells, at_m, reach_m);
            found.sort_unstable();
            let distinct = found.windows(2).all(|pair| pair[0] < pair[1]);
            prop_assert!(distinct, "{found:?}");
            for (i, (x, y)) in points.iter().enumerate() {
                let near = (Point2::new(*x, *y) - at_m).norm() <= reach_m;
                prop_assert!(!near || found.contains(&i), "{i}");
            }
            // Who was taken out is not found again; all others are.
            found.retain(|point| point % 3 != 0);
            let mut again = all_near(&mut cells, at_m, reach_m);
            again.sort_unstable();
            prop_assert_eq!(again, found);
        }
    }

    #[test]
    fn few_are_looked_at_where_many_are() {
        let mut cells = Cells::default();
        for n in 0..4000_u32 {
            cells.add(Point2::new(f64::from(n % 64) * 50.0, f64::from(n / 64) * 50.0));
        }
        let looked_at = all_near(&mut cells, Point2::new(1600.0, 1600.0), 50.0).len();
        assert_eq!(looked_at, 9);
    }
}
