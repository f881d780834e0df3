//! The publication before, revised by the plots that came since: where each track was one scan ago.
//!
//! A copy `c` of the position is taken at the publication, with `X = cov(c, x) = HP`, `P_c = HPHᵀ`. Then, for each
//! update since, in the order of the plots' times:
//!
//! ```text
//! predict:  X ← XΦᵀ                       c, P_c unchanged: the noise to come knows nothing of the past
//! update:   Y = XHᵀ;  c += Y S⁻¹ν;  P_c −= Y S⁻¹Yᵀ;  X ← X − Y Kᵀ
//! weighted: c += Y S⁻¹ν̄;  P_c −= (1 − β₀) Y S⁻¹Yᵀ − Y S⁻¹ W S⁻¹Yᵀ;  X likewise;  W = Σβνν ᵀ − ν̄ν̄ᵀ
//! restart, manoeuvre:  c, P_c stay; X = 0
//! ```
//!
//! Exact for filters of one Gaussian; of modes and histories their mixed moments are used. The updates since are read
//! from the ring, so a late plot that went to its place there is counted in its place here.
//!
//! Source: fixed-point smoothing by augmentation, Anderson and Moore, *Optimal Filtering* (1979), ch. 7.2.

use super::config::Life;
use super::filter::{TrackFilter, predict};
use crate::filter::{Gaussian, Measurement, UpdateError};
use crate::frames::{Matrix2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use nalgebra::{Matrix2x6, Matrix6};

/// See the module's text.
#[derive(Clone, Debug)]
pub(super) struct Lag {
    /// Position, m.
    pub(super) position_m: Vector2<f64>,
    /// Its covariance, m².
    pub(super) cov_m2: Matrix2<f64>,
    /// Covariance with the state (x, vx, ax, y, vy, ay) at `time`.
    x: Matrix2x6<f64>,
    time: SimTime,
}

/// One scan of plots never leaves less than this share of a covariance's determinant: a plot takes off a tenth to nine tenths
/// of a variance, and what is less is moments of modes that contradict each other.
const LEAST_LEFT: f64 = 1e-3;

/// East and north in the order of the state.
const MEASURED: [usize; 2] = [0, 3];

impl Lag {
    /// A copy of the position of `filter` at `time`.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    pub(super) fn of(
        filter: &TrackFilter,
        time: SimTime,
        life: &Life,
    ) -> Result<Self, UpdateError> {
        let state = predict(filter, time, life)?.state;
        let p = state.covariance();
        let x = Matrix2x6::from_fn(|r, c| p[(MEASURED[r], c)]);
        let cov_m2 = measured(&x);
        Ok(Self { position_m: state.position(), cov_m2, x, time })
    }

    /// What `plots` (of one time, each with its probability) that updated `before` say of the past.
    ///
    /// # Errors
    /// If they are before the filter or unsound, or a covariance is.
    pub(super) fn update(
        &mut self,
        before: &TrackFilter,
        plots: &[(Plot, f64)],
        life: &Life,
    ) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let state = predict(before, first.time, life)?.state;
        let gap_s = first.time.since_s(before.time());
        self.predict(first.time, gap_s <= life.constant_velocity_after_s);
        for k in 0..plots.len() {
            // Plots of one covariance, as nearly all are, are taken together.
            let alike = |p: &Plot| {
                let of = &plots[k].0;
                p.along_m2 == of.along_m2 && p.across_m2 == of.across_m2 && p.axis == of.axis
            };
            if plots[..k].iter().any(|(p, _)| alike(p)) {
                continue;
            }
            let own = || plots[k..].iter().filter(|(p, _)| alike(p));
            let Measurement::Position { r, .. } = Measurement::of(&plots[k].0)? else { continue };
            let s = state.position_cov() + r;
            let weight: f64 = own().map(|(_, beta)| beta).sum();
            let nu = |p: &Plot| p.position_m - state.position();
            let mean: Vector2<f64> = own().map(|(p, beta)| nu(p) * *beta).sum();
            let square: Matrix2<f64> =
                own().map(|(p, beta)| nu(p) * nu(p).transpose() * *beta).sum();
            let spread = square - mean * mean.transpose();
            let inverse = s.matrix().try_inverse().ok_or(UpdateError::BadInnovation(s.xx))?;
            self.take(&state, inverse, weight, mean, spread);
        }
        let sound = self.cov_m2.iter().chain(self.position_m.iter()).all(|v| v.is_finite());
        sound.then_some(()).ok_or(UpdateError::BadCovariance)
    }

    fn take(
        &mut self,
        state: &Gaussian,
        inverse: Matrix2<f64>,
        weight: f64,
        nu: Vector2<f64>,
        spread: Matrix2<f64>,
    ) {
        let p: Matrix6<f64> = state.covariance();
        let ph = Matrix2x6::from_fn(|r, c| p[(MEASURED[r], c)]);
        let gain = measured(&self.x) * inverse;
        // What certainty takes off, less what not knowing which plot it was leaves.
        let taken = inverse.try_inverse().unwrap_or_default() * weight - spread;
        let less = gain * taken * gain.transpose();
        let cov_m2 = self.cov_m2 - (less + less.transpose()) * 0.5;
        // Moments of modes that disagree can take away more than there is.
        let least = LEAST_LEFT * self.cov_m2.determinant();
        if !(cov_m2[(0, 0)] > 0.0 && cov_m2.determinant() > least) {
            return self.forget();
        }
        self.position_m += gain * nu;
        self.cov_m2 = cov_m2;
        self.x -= gain * taken * inverse * ph;
    }

    /// The state began again: it says nothing of the past any more.
    pub(super) fn forget(&mut self) {
        self.x = Matrix2x6::zeros();
    }

    fn predict(&mut self, time: SimTime, accelerating: bool) {
        let t = time.since_s(self.time);
        self.time = time;
        let half = if accelerating { 0.5 * t * t } else { 0.0 };
        for mut row in self.x.row_iter_mut() {
            for b in [0, 3] {
                row[b] += row[b + 1] * t + row[b + 2] * half;
                row[b + 1] += if accelerating { row[b + 2] * t } else { 0.0 };
                row[b + 2] *= f64::from(u8::from(accelerating));
            }
        }
    }
}

fn measured(x: &Matrix2x6<f64>) -> Matrix2<f64> {
    Matrix2::from_fn(|r, c| x[(r, MEASURED[c])])
}
