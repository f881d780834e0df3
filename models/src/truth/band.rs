//! Symmetric positive definite band matrices: factor and solve in linear time.

/// Lower half of a symmetric band matrix, row by row.
#[derive(Clone, Debug)]
pub(super) struct Band {
    /// Number of diagonals below the main one.
    width: usize,
    size: usize,
    /// `rows[i * (width + 1) + k]` is the entry (i, i − width + k); the last of a row is the diagonal.
    rows: Vec<f64>,
}

impl Band {
    pub(super) fn zeros(size: usize, width: usize) -> Self {
        Self { width, size, rows: vec![0.0; size * (width + 1)] }
    }

    /// Adds to the entries (i, j) and (j, i); they have to lie in the band.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        let at = row * (self.width + 1) + self.width + column - row;
        self.rows[at] += value;
    }

    /// Multiplies every diagonal entry by `1 + share` and adds `least`.
    pub(super) fn stiffen(&mut self, share: f64, least: f64) {
        for i in 0..self.size {
            let diagonal = &mut self.rows[i * (self.width + 1) + self.width];
            *diagonal += *diagonal * share + least;
        }
    }

    /// The product with a vector.
    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        let (w, stride) = (self.width, self.width + 1);
        let mut product = vec![0.0; self.size];
        for i in 0..self.size {
            let below = w.min(i);
            let row = &self.rows[i * stride + w - below..i * stride + w];
            let mut sum = self.rows[i * stride + w] * x[i];
            let before = x[i - below..i].iter().zip(&mut product[i - below..i]);
            for (entry, (left, product)) in row.iter().zip(before) {
                sum += entry * left;
                *product += entry * x[i];
            }
            product[i] += sum;
        }
        product
    }

    /// Replaces the matrix by its Cholesky factor `L`, `A = L Lᵀ`; false if it is not positive definite.
    ///
    /// Source: Golub & Van Loan, Matrix Computations (2013), alg. 4.3.5.
    #[must_use]
    pub(super) fn factor(&mut self) -> bool {
        let (w, stride) = (self.width, self.width + 1);
        for i in 0..self.size {
            let (above, row) = self.rows.split_at_mut(i * stride);
            for j in i.saturating_sub(w)..i {
                // Entries of row i from `first` on, with those of row j above them.
                let shared = (w + j - i).min(w.min(j));
                let at = w + j - i;
                let upper = &above[j * stride + w - shared..=j * stride + w];
                let sum: f64 = row[at - shared..at].iter().zip(upper).map(|(a, b)| a * b).sum();
                row[at] = (row[at] - sum) / upper[shared];
            }
            let square: f64 = row[w - w.min(i)..w].iter().map(|a| a * a).sum();
            let rest = row[w] - square;
            if !(rest > 0.0 && rest.is_finite()) {
                return false;
            }
            row[w] = rest.sqrt();
        }
        true
    }

    /// Solves `A x = b` in place, after [`Band::factor`].
    pub(super) fn solve(&self, b: &mut [f64]) {
        let (w, stride) = (self.width, self.width + 1);
        for i in 0..self.size {
            let mut sum = b[i];
            for k in i.saturating_sub(w)..i {
                sum -= self.rows[i * stride + w + k - i] * b[k];
            }
            b[i] = sum / self.rows[i * stride + w];
        }
        for i in (0..self.size).rev() {
            b[i] /= self.rows[i * stride + w];
            let solved = b[i];
            for k in i.saturating_sub(w)..i {
                b[k] -= self.rows[i * stride + w + k - i] * solved;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_gives_the_right_side_again() {
        let size = 12;
        let mut band = Band::zeros(size, 2);
        for i in 0..size {
            band.add(i, i, 4.0 + i as f64);
            if i >= 1 {
                band.add(i, i - 1, -1.5);
            }
            if i >= 2 {
                band.add(i - 2, i, 0.25);
            }
        }
        let truth: Vec<f64> = (0..size).map(|i| (i as f64 - 3.0) * 0.7).collect();
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 4.0 + i as f64,
            1 => -1.5,
            2 => 0.25,
            _ => 0.0,
        };
        let mut b: Vec<f64> =
            (0..size).map(|i| (0..size).map(|j| entry(i, j) * truth[j]).sum()).collect();
        assert!(band.factor());
        band.solve(&mut b);
        for (found, expected) in b.iter().zip(&truth) {
            assert!((found - expected).abs() < 1e-12);
        }
        let mut bad = Band::zeros(2, 1);
        bad.add(0, 0, 1.0);
        bad.add(1, 0, 2.0);
        bad.add(1, 1, 1.0);
        assert!(!bad.factor(), "indefinite");
    }
}
