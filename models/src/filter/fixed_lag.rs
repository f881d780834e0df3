//! A past state as later plots revise it: a copy taken at one moment, and its covariance with the state since.
//!
//! Let `c` be copies of `K` numbers of the state, `X = cov(c, x)`, `P_c` their own covariance. Then
//!
//! ```text
//! predict:  X ← XΦᵀ                       c, P_c unchanged: the noise to come knows nothing of the past
//! update:   Y = XHᵀ;  c += Y S⁻¹ν;  P_c −= Y S⁻¹Yᵀ;  X ← X − Y Kᵀ
//! weighted: c += Y S⁻¹ν̄;  P_c −= (1 − β₀) Y S⁻¹Yᵀ − Y S⁻¹ W S⁻¹Yᵀ;  X likewise;  W = Σβνν ᵀ − ν̄ν̄ᵀ
//! ```
//!
//! Exact for filters of one Gaussian, with any number of plots in between, none too.
//!
//! Source: fixed-point smoothing by augmentation, Anderson and Moore, *Optimal Filtering* (1979), ch. 7.2.

use super::gaussian::Gaussian;
use crate::frames::{Matrix2, Vector2};
use nalgebra::{Matrix6, SMatrix, SVector};

/// Copies of `K` numbers of a state (x, vx, ax, y, vy, ay).
#[derive(Clone, Debug, PartialEq)]
pub struct FixedLag<const K: usize> {
    /// The copies, as they are known now: m, m/s, m/s².
    pub value: SVector<f64, K>,
    /// Their covariance.
    pub covariance: SMatrix<f64, K, K>,
    /// Covariance with the state.
    with_state: SMatrix<f64, K, 6>,
}

/// Places of the measured numbers in the state.
const MEASURED: [usize; 2] = [0, 3];

impl<const K: usize> FixedLag<K> {
    /// Copies of the numbers at `places` of a state, as it is.
    #[must_use]
    pub fn of(state: &Gaussian, places: [usize; K]) -> Self {
        let p = state.covariance();
        let value = |k: usize| state.x[places[k] % 3].array()[places[k] / 3];
        Self {
            value: SVector::from_fn(|k, _| value(k)),
            covariance: SMatrix::from_fn(|r, c| p[(places[r], places[c])]),
            with_state: SMatrix::from_fn(|r, c| p[(places[r], c)]),
        }
    }

    /// The state has gone on by `t_s` at constant acceleration, or at constant velocity.
    pub fn predict(&mut self, t_s: f64, accelerating: bool) {
        let half = if accelerating { 0.5 * t_s * t_s } else { 0.0 };
        for mut row in self.with_state.row_iter_mut() {
            for b in [0, 3] {
                row[b] += row[b + 1] * t_s + row[b + 2] * half;
                row[b + 1] += if accelerating { row[b + 2] * t_s } else { 0.0 };
                row[b + 2] *= f64::from(u8::from(accelerating));
            }
        }
    }

    /// Plots of one innovation covariance were taken by `state`, as it was just before them: `inverse` of that covariance,
    /// the sum of their probabilities, the mean of their innovations and what they spread about it.
    pub fn take(
        &mut self,
        state: &Gaussian,
        inverse: Matrix2<f64>,
        weight: f64,
        nu: Vector2<f64>,
        spread: Matrix2<f64>,
    ) {
        let p: Matrix6<f64> = state.covariance();
        let ph = SMatrix::<f64, 2, 6>::from_fn(|r, c| p[(MEASURED[r], c)]);
        let y = SMatrix::<f64, K, 2>::from_fn(|r, c| self.with_state[(r, MEASURED[c])]);
        let gain = y * inverse;
        // What certainty takes off, less what not knowing which plot it was leaves.
        let taken = inverse.try_inverse().unwrap_or_default() * weight - spread;
        let less = gain * taken * gain.transpose();
        self.value += gain * nu;
        self.covariance -= (less + less.transpose()) * 0.5;
        self.with_state -= gain * taken * inverse * ph;
    }

    /// The state began again: it says nothing of the past any more.
    pub fn forget(&mut self) {
        self.with_state = SMatrix::zeros();
    }
}
