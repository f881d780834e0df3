//! Position, velocity and acceleration of both axes with their joint covariance.
//!
//! Order of the six components where a full matrix is asked for: x, vx, ax, y, vy, ay. Stored as the
//! 21 different numbers only (two axis blocks side by side and the block between them), so that no
//! step can make the covariance unsymmetric: P − K S Kᵀ on a full matrix multiplies the antisymmetric
//! part of its rounding error by about 1.3 at every scan and stops filtering after 120 to 250 scans.

use super::lanes::{Lane, Pair};
use super::motion::Step;
use super::{UpdateError, UpdateError::BadInnovation};
use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::Plot;
use nalgebra::SMatrix;

/// Mean and covariance of (position, velocity, acceleration) of both axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaussian {
    /// Position (m), velocity (m/s), acceleration (m/s²), east and north.
    pub x: [Pair; 3],
    /// Covariance of each axis: pp, pv, pa, vv, va, aa.
    pub p: [Pair; 6],
    /// Covariance of east component i with north component j at `3 i + j`.
    pub cross: [f64; 9],
}

/// A symmetric 2 × 2 matrix: xx, xy, yy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sym2 {
    /// East–east.
    pub xx: f64,
    /// East–north.
    pub xy: f64,
    /// North–north.
    pub yy: f64,
}

impl Sym2 {
    /// As a matrix.
    #[must_use]
    pub fn matrix(self) -> Matrix2<f64> {
        Matrix2::new(self.xx, self.xy, self.xy, self.yy)
    }
}

impl std::ops::Add for Sym2 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { xx: self.xx + o.xx, xy: self.xy + o.xy, yy: self.yy + o.yy }
    }
}

/// What a plot says: a position with a full covariance, or one direction only (an induction loop).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measurement {
    /// Both coordinates, with their covariance, m².
    Position {
        /// Measured position, m.
        z: Point2<f64>,
        /// Covariance, m².
        r: Sym2,
    },
    /// The coordinate along one direction.
    Line {
        /// Any measured point; only its component along `axis` counts, m.
        z: Point2<f64>,
        /// Unit vector.
        axis: Vector2<f64>,
        /// Variance along `axis`, m².
        variance: f64,
    },
}

impl Measurement {
    /// The measurement that a plot is.
    ///
    /// # Errors
    /// If its position is not finite or a variance is negative or NaN.
    #[inline(always)]
    pub fn of(plot: &Plot) -> Result<Self, UpdateError> {
        let (z, u) = (plot.position_m, plot.axis);
        let axis = Pair::new(u.x, u.y);
        let squares = axis * axis;
        let length = squares + squares.swapped();
        let variances = Pair::new(plot.along_m2, plot.across_m2);
        // Everything is in order: one look at all of it.
        let far = Pair::new(z.x, z.y).abs().not_below(Pair::splat(FARTHEST_M));
        let negative = Pair::splat(-f64::MIN_POSITIVE).not_below(variances);
        let unlimited = variances.not_below(Pair::splat(LARGEST_M2));
        let other = (length - Pair::splat(1.0)).abs().not_below(Pair::splat(1e-6));
        if ((far | negative) | (unlimited | other)).anywhere() {
            return Self::of_one_line(plot);
        }
        // A variance whose square would vanish in a double is none.
        let variances = variances.only(variances.not_below(Pair::splat(SMALLEST_M2)));
        let [along, across] = variances.array();
        let diagonal = axis * along * axis + (axis * across * axis).swapped();
        let r =
            Sym2 { xx: diagonal.east(), xy: (along - across) * u.x * u.y, yy: diagonal.north() };
        Ok(Self::Position { z, r })
    }

    /// The rest: a plot that says nothing across its axis, or one that is unsound.
    #[cold]
    #[inline(never)]
    fn of_one_line(plot: &Plot) -> Result<Self, UpdateError> {
        let (z, u) = (plot.position_m, plot.axis);
        // Written so that NaN fails.
        let unit = (u.x * u.x + u.y * u.y - 1.0).abs() < 1e-6;
        let near = z.x.abs() < FARTHEST_M && z.y.abs() < FARTHEST_M;
        let known = plot.along_m2 >= 0.0 && plot.along_m2 < LARGEST_M2;
        if !(unit && near && known && plot.across_m2 >= LARGEST_M2) {
            return Err(UpdateError::UnsoundPlot);
        }
        let variance = if plot.along_m2 < SMALLEST_M2 { 0.0 } else { plot.along_m2 };
        Ok(Self::Line { z, axis: u, variance })
    }
}

/// Beyond this no position is of this airport, m.
const FARTHEST_M: f64 = 1e9;
/// Harder than anything on or near a runway accelerates, brakes or turns: two g, m/s² (assumed).
const HARDEST_MS2: f64 = 20.0;
/// From this on a variance says that nothing was measured, m².
const LARGEST_M2: f64 = 1e20;
/// A variance below this is none: its square must not vanish in a double, m².
const SMALLEST_M2: f64 = 1e-30;

impl Measurement {
    /// The measured point; of a line any point on it.
    #[inline]
    #[must_use]
    pub fn point(&self) -> Point2<f64> {
        match *self {
            Self::Position { z, .. } | Self::Line { z, .. } => z,
        }
    }
}

/// An innovation covariance as L D Lᵀ: two divisions and no square root.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    /// L₁₀.
    l: f64,
    /// 1 / D₀ and 1 / D₁.
    inverse: [f64; 2],
    /// det S.
    pub(super) det: f64,
}

impl Factor {
    /// Factors of `s`.
    ///
    /// # Errors
    /// Unless `s` is finite and positive definite.
    #[inline]
    pub fn of(s: Sym2) -> Result<Self, UpdateError> {
        let first = 1.0 / s.xx;
        let l = s.xy * first;
        let rest = s.yy - l * s.xy;
        if !(s.xx > 0.0 && rest > 0.0 && s.xx + s.yy < f64::INFINITY) {
            return Err(BadInnovation(rest.min(s.xx)));
        }
        Ok(Self { l, inverse: [first, 1.0 / rest], det: s.xx * rest })
    }

    /// The innovation with its second number made independent of the first, and its squared
    /// normalised length.
    #[inline]
    #[must_use]
    pub fn independent(&self, nu: Vector2<f64>) -> ([f64; 2], f64) {
        let y = [nu.x, nu.y - self.l * nu.x];
        (y, y[0] * y[0] * self.inverse[0] + y[1] * y[1] * self.inverse[1])
    }

    /// The same for a covariance with the two measured numbers: a row of P Hᵀ L⁻ᵀ.
    #[inline]
    #[must_use]
    pub fn row(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        [a, b - self.l * a]
    }

    /// The scalar product Σ aᵢ bᵢ / Dᵢ.
    #[inline]
    #[must_use]
    pub fn dot(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        a[0] * b[0] * self.inverse[0] + a[1] * b[1] * self.inverse[1]
    }

    /// Squared normalised length of an innovation.
    #[inline]
    #[must_use]
    pub fn d2(&self, nu: Vector2<f64>) -> f64 {
        self.independent(nu).1
    }

    /// ln det S.
    #[inline]
    #[must_use]
    pub fn ln_det(&self) -> f64 {
        if self.det > f64::MIN_POSITIVE && self.det < f64::INFINITY {
            return libm::log(self.det);
        }
        -libm::log(self.inverse[0]) - libm::log(self.inverse[1])
    }
}

/// An innovation with its covariance: what a gate and an association cost need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// z − H x⁻, m east and north.
    pub nu: Vector2<f64>,
    /// Covariance of `nu`, m²; only its part along the axis means something where `dof` is 1.
    pub s: Sym2,
    /// Squared normalised length of `nu`.
    pub d2: f64,
    /// ln det S (of the one direction where `dof` is 1).
    pub ln_det: f64,
    /// Degrees of freedom of `d2`: 2, or 1 for a plot along one direction.
    pub dof: u8,
}

/// What a measurement update found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nis {
    /// Normalised innovation squared.
    pub d2: f64,
    /// Determinant of the innovation covariance, m⁴ (m² where `dof` is 1).
    pub det: f64,
    /// Degrees of freedom: 2 or 1.
    pub dof: u8,
}

impl Nis {
    /// ln det of the innovation covariance.
    #[inline]
    #[must_use]
    pub fn ln_det(&self) -> f64 {
        libm::log(self.det)
    }
}

impl Gaussian {
    /// A target of unknown velocity at a measured position: P_pp = R, P_vv = σ_v², P_aa = σ_a².
    #[must_use]
    pub fn at_position(z: Point2<f64>, r: Sym2, sigma_v_mps: f64, sigma_a_ms2: f64) -> Self {
        let zero = Pair::default();
        let mut cross = [0.0; 9];
        cross[0] = r.xy;
        let (vv, aa) = (sigma_v_mps * sigma_v_mps, sigma_a_ms2 * sigma_a_ms2);
        Self {
            x: [Pair::new(z.x, z.y), zero, zero],
            p: [Pair::new(r.xx, r.yy), zero, zero, Pair::splat(vv), zero, Pair::splat(aa)],
            cross,
        }
    }

    /// Position and velocity from two measured positions `t` seconds apart, the later one last.
    ///
    /// `v̂ = (z₂ − z₁)/t`, `P_pp = R₂`, `P_pv = R₂/t`, `P_vv = (R₁ + R₂)/t²`, `P_aa = σ_a²`. With
    /// `vague` the acceleration that may have acted in between is counted too (`P_vv += t²σ_a²/4`,
    /// `P_va = tσ_a²/2`): then this is the limit of a one-plot start with unlimited velocity.
    #[must_use]
    pub fn from_two(
        first: (Point2<f64>, Sym2),
        last: (Point2<f64>, Sym2),
        t: f64,
        sigma_a_ms2: f64,
        vague: bool,
    ) -> Self {
        let aa = sigma_a_ms2 * sigma_a_ms2;
        let ((z1, r1), (z2, r2)) = (first, last);
        let v = (z2 - z1) / t;
        let sum = r1 + r2;
        let (vv_more, va) = if vague { (t * t * aa / 4.0, t * aa / 2.0) } else { (0.0, 0.0) };
        let t2 = t * t;
        Self {
            x: [Pair::new(z2.x, z2.y), Pair::new(v.x, v.y), Pair::default()],
            p: [
                Pair::new(r2.xx, r2.yy),
                Pair::new(r2.xx / t, r2.yy / t),
                Pair::default(),
                Pair::new(sum.xx / t2 + vv_more, sum.yy / t2 + vv_more),
                Pair::splat(va),
                Pair::splat(aa),
            ],
            cross: [r2.xy, r2.xy / t, 0.0, r2.xy / t, sum.xy / t2, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// The same without acceleration: mean, variance and covariances of the acceleration are zero.
    #[must_use]
    pub fn without_acceleration(mut self) -> Self {
        let zero = Pair::default();
        self.x[2] = zero;
        (self.p[2], self.p[4], self.p[5]) = (zero, zero, zero);
        for k in [2, 5, 6, 7, 8] {
            self.cross[k] = 0.0;
        }
        self
    }

    /// Prediction: `x ← Φ x`, `P ← Φ P Φᵀ + Q`, rows first, then columns, no product with a zero.
    #[inline]
    #[must_use]
    pub fn predicted(&self, step: &Step) -> Self {
        let (x, p) = predict_axes(&self.x, &self.p, step);
        let Step { t, f02, f12, f22, .. } = *step;
        let c = &self.cross;
        let row = |k: usize| {
            [c[k] + c[3 + k] * t + c[6 + k] * f02, c[3 + k] + c[6 + k] * f12, c[6 + k] * f22]
        };
        let (r0, r1, r2) = (row(0), row(1), row(2));
        let mut cross = [0.0; 9];
        for i in 0..3 {
            cross[3 * i] = r0[i] + r1[i] * t + r2[i] * f02;
            cross[3 * i + 1] = r1[i] + r2[i] * f12;
            cross[3 * i + 2] = r2[i] * f22;
        }
        Self { x, p, cross }
    }

    /// [`Self::predicted`] by a step of constant velocity: whatever is said of the acceleration, it is
    /// nothing afterwards.
    #[inline]
    #[must_use]
    pub fn predicted_steady(&self, step: &Step) -> Self {
        let (t, [x0, x1, _], [a, b, _, e, _, _]) = (step.t, self.x, self.p);
        let zero = Pair::default();
        let b0 = b + e * t;
        let p = [
            a + b * t + b0 * t + Pair::splat(step.q[0]),
            b0 + Pair::splat(step.q[1]),
            zero,
            e + Pair::splat(step.q[3]),
            zero,
            zero,
        ];
        let c = &self.cross;
        let (r0, r1) = (Pair::new(c[0], c[1]), Pair::new(c[3], c[4]));
        let (c01, c34) = ((r0 + r1 * t).array(), r1.array());
        let cross =
            [c01[0] + c01[1] * t, c01[1], 0.0, c34[0] + c34[1] * t, c34[1], 0.0, 0.0, 0.0, 0.0];
        Self { x: [x0 + x1 * t, x1, zero], p, cross }
    }

    /// Predicted position and its covariance alone: a third of the work of [`Self::predicted`].
    #[inline]
    #[must_use]
    pub fn predicted_position(&self, step: &Step) -> (Point2<f64>, Sym2) {
        let Step { t, f02, .. } = *step;
        let (x, p, c) = (&self.x, &self.p, &self.cross);
        let at = x[0] + x[1] * t + x[2] * f02;
        let pp = p[0]
            + (p[1] + p[1] + p[3] * t + p[4] * (2.0 * f02)) * t
            + (p[2] + p[2] + p[5] * f02) * f02
            + Pair::splat(step.q[0]);
        let xy = (c[0] + c[3] * t + c[6] * f02)
            + (c[1] + c[4] * t + c[7] * f02) * t
            + (c[2] + c[5] * t + c[8] * f02) * f02;
        (Point2::new(at.east(), at.north()), Sym2 { xx: pp.east(), xy, yy: pp.north() })
    }

    /// Covariance of the position, m².
    #[inline]
    #[must_use]
    pub fn position_cov(&self) -> Sym2 {
        Sym2 { xx: self.p[0].east(), xy: self.cross[0], yy: self.p[0].north() }
    }

    /// Position, m.
    #[inline]
    #[must_use]
    pub fn position(&self) -> Point2<f64> {
        Point2::new(self.x[0].east(), self.x[0].north())
    }

    /// The innovation of a measurement at the time of this state.
    ///
    /// # Errors
    /// If its covariance is not positive definite and finite.
    #[inline]
    pub fn innovation(&self, m: &Measurement) -> Result<Innovation, UpdateError> {
        match *m {
            Measurement::Position { z, r } => {
                let (nu, s) = (z - self.position(), self.position_cov() + r);
                let f = Factor::of(s)?;
                Ok(Innovation { nu, s, d2: f.independent(nu).1, ln_det: f.ln_det(), dof: 2 })
            }
            Measurement::Line { z, axis, variance } => {
                let pp = self.position_cov();
                let (nu, s) = ((z - self.position()).dot(&axis), quadratic(pp, axis) + variance);
                if !s.all_positive() {
                    return Err(BadInnovation(s));
                }
                let outer = Sym2 {
                    xx: s * axis.x * axis.x,
                    xy: s * axis.x * axis.y,
                    yy: s * axis.y * axis.y,
                };
                Ok(Innovation {
                    nu: axis * nu,
                    s: outer,
                    d2: nu * nu / s,
                    ln_det: libm::log(s),
                    dof: 1,
                })
            }
        }
    }

    /// Measurement update. On an error the state is left as it was.
    ///
    /// With L D Lᵀ = S, N = P⁻Hᵀ L⁻ᵀ and y = L⁻¹ν: `x ← x + N D⁻¹ y`, `P ← P − N D⁻¹ Nᵀ`; one row of H for a
    /// plot along one direction.
    ///
    /// # Errors
    /// If the innovation covariance is not positive definite and finite.
    #[inline]
    pub fn update(&mut self, m: &Measurement) -> Result<Nis, UpdateError> {
        match *m {
            Measurement::Position { z, r } => {
                let factor = Factor::of(self.position_cov() + r)?;
                let (y, d2) = factor.independent(z - self.position());
                if !d2.is_finite() {
                    return Err(BadInnovation(d2));
                }
                let columns = self.position_columns();
                self.condition(&columns, &factor, y);
                Ok(Nis { d2, det: factor.det, dof: 2 })
            }
            Measurement::Line { z, axis, variance } => {
                let nu = (z - self.position()).dot(&axis);
                let s = quadratic(self.position_cov(), axis) + variance;
                if !s.all_positive() {
                    return Err(BadInnovation(s));
                }
                if !nu.is_finite() {
                    return Err(BadInnovation(nu));
                }
                let [a, b] = self.position_columns();
                let n: [Pair; 3] = std::array::from_fn(|i| a[i] * axis.x + b[i] * axis.y);
                for (x, n) in self.x.iter_mut().zip(n) {
                    *x = *x + n * (nu / s);
                }
                self.add_outer(&n, -1.0 / s);
                Ok(Nis { d2: nu * nu / s, det: s, dof: 1 })
            }
        }
    }

    /// P Hᵀ for the position east and north, each as (east, north) pairs of the three components.
    #[inline]
    #[must_use]
    pub fn position_columns(&self) -> [[Pair; 3]; 2] {
        let (p, c) = (&self.p, &self.cross);
        [
            [
                Pair::new(p[0].east(), c[0]),
                Pair::new(p[1].east(), c[1]),
                Pair::new(p[2].east(), c[2]),
            ],
            [
                Pair::new(c[0], p[0].north()),
                Pair::new(c[3], p[1].north()),
                Pair::new(c[6], p[2].north()),
            ],
        ]
    }

    /// `x ← x + M S⁻¹ ν`, `P ← P − M S⁻¹ Mᵀ` for the covariance columns M of this state with a measured
    /// position whose innovation covariance is factored in `factor`; `y` is the independent innovation.
    #[inline]
    pub fn condition(&mut self, columns: &[[Pair; 3]; 2], factor: &Factor, y: [f64; 2]) {
        let [m0, m1] = columns;
        let n1 = [m1[0] - m0[0] * factor.l, m1[1] - m0[1] * factor.l, m1[2] - m0[2] * factor.l];
        let (g0, g1) = (y[0] * factor.inverse[0], y[1] * factor.inverse[1]);
        for (x, (a, b)) in self.x.iter_mut().zip(m0.iter().zip(&n1)) {
            *x = *x + (*a * g0 + *b * g1);
        }
        self.add_outer(m0, -factor.inverse[0]);
        self.add_outer(&n1, -factor.inverse[1]);
    }

    /// [`Self::update`] of a state without acceleration, as [`Self::predicted_steady`] leaves it.
    ///
    /// # Errors
    /// As [`Self::update`].
    #[inline]
    pub fn update_steady(&mut self, m: &Measurement) -> Result<Nis, UpdateError> {
        let Measurement::Position { z, r } = *m else { return self.update(m) };
        let factor = Factor::of(self.position_cov() + r)?;
        let (y, d2) = factor.independent(z - self.position());
        if !d2.is_finite() {
            return Err(BadInnovation(d2));
        }
        let mut state = Steady::of(self);
        let c = &self.cross;
        let m0 = [Pair::new(self.p[0].east(), c[0]), Pair::new(self.p[1].east(), c[1])];
        let m1 = [Pair::new(c[0], self.p[0].north()), Pair::new(c[3], self.p[1].north())];
        let n1 = [m1[0] - m0[0] * factor.l, m1[1] - m0[1] * factor.l];
        let (g0, g1) = (y[0] * factor.inverse[0], y[1] * factor.inverse[1]);
        state.x = [state.x[0] + (m0[0] * g0 + n1[0] * g1), state.x[1] + (m0[1] * g0 + n1[1] * g1)];
        state.add_outer(&m0, -factor.inverse[0]);
        state.add_outer(&n1, -factor.inverse[1]);
        *self = state.gaussian();
        Ok(Nis { d2, det: factor.det, dof: 2 })
    }

    /// P ← P + k n nᵀ.
    #[inline]
    pub fn add_outer(&mut self, n: &[Pair; 3], k: f64) {
        let s = [n[0] * k, n[1] * k, n[2] * k];
        self.p[0] = self.p[0] + s[0] * n[0];
        self.p[1] = self.p[1] + s[0] * n[1];
        self.p[2] = self.p[2] + s[0] * n[2];
        self.p[3] = self.p[3] + s[1] * n[1];
        self.p[4] = self.p[4] + s[1] * n[2];
        self.p[5] = self.p[5] + s[2] * n[2];
        let north = n.map(Pair::north);
        for (row, s) in self.cross.chunks_exact_mut(3).zip(s) {
            let east = s.east();
            row[0] += east * north[0];
            row[1] += east * north[1];
            row[2] += east * north[2];
        }
    }

    /// Adds `w` times the mean and covariance of `other` to this accumulator.
    #[inline]
    pub fn accumulate(&mut self, other: &Self, w: f64) {
        for (sum, x) in self.x.iter_mut().zip(&other.x) {
            *sum = *sum + *x * w;
        }
        for (sum, p) in self.p.iter_mut().zip(&other.p) {
            *sum = *sum + *p * w;
        }
        for (sum, c) in self.cross.iter_mut().zip(&other.cross) {
            *sum += *c * w;
        }
    }

    /// Mean and covariance of a mixture with weights that sum to 1.
    #[inline]
    #[must_use]
    pub fn mixture(weights: &[f64], parts: &[Self]) -> Self {
        let mut sum = Self::default();
        for (part, w) in parts.iter().zip(weights) {
            sum.accumulate(part, *w);
        }
        for (part, w) in parts.iter().zip(weights) {
            let d = [part.x[0] - sum.x[0], part.x[1] - sum.x[1], part.x[2] - sum.x[2]];
            sum.add_outer(&d, *w);
        }
        sum
    }

    /// [`Self::mixture`] of positions and velocities alone; nothing is said of the acceleration.
    #[inline]
    #[must_use]
    pub fn mixture_steady<const N: usize>(weights: &[f64; N], parts: &[Self; N]) -> Self {
        let mut sum = Steady::default();
        for (part, w) in parts.iter().zip(weights) {
            let part = Steady::of(part);
            sum.x = [sum.x[0] + part.x[0] * *w, sum.x[1] + part.x[1] * *w];
            for (sum, p) in sum.p.iter_mut().zip(part.p) {
                *sum = *sum + p * *w;
            }
        }
        for (part, w) in parts.iter().zip(weights) {
            sum.add_outer(&[part.x[0] - sum.x[0], part.x[1] - sum.x[1]], *w);
        }
        sum.gaussian()
    }

    /// Mean of a mixture with weights that sum to 1: position (m) and velocity (m/s).
    #[inline]
    #[must_use]
    pub fn mean_motion(weights: &[f64], parts: &[Self]) -> (Point2<f64>, Vector2<f64>) {
        let mut sum = [Pair::default(); 2];
        for (part, w) in parts.iter().zip(weights) {
            sum = [sum[0] + part.x[0] * *w, sum[1] + part.x[1] * *w];
        }
        let [p, v] = sum.map(Pair::array);
        (Point2::new(p[0], p[1]), Vector2::new(v[0], v[1]))
    }

    /// Position (m) and velocity (m/s).
    #[inline]
    #[must_use]
    pub fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let [p, v, _] = self.x.map(Pair::array);
        (Point2::new(p[0], p[1]), Vector2::new(v[0], v[1]))
    }

    /// The normalised innovation of a measurement at the time of this state.
    ///
    /// # Errors
    /// If its covariance is not positive definite and finite.
    #[inline]
    pub fn nis(&self, m: &Measurement) -> Result<Nis, UpdateError> {
        nis_at(self.position(), self.position_cov(), m)
    }

    /// Several plots of which at most one is of this target (probabilistic data association).
    ///
    /// `betas[i]` is the probability that `measurements[i]` is; the rest of 1 that none is. Each plot
    /// updates its own copy and the copies are mixed: exact for unequal R, and equal to
    /// `P⁻ − (1−β₀)NNᵀ + K(Σβνν ᵀ − ν̄ν̄ᵀ)Kᵀ` for equal ones. On an error the state is left as it was.
    ///
    /// # Errors
    /// If an innovation covariance is not positive definite and finite.
    pub fn update_weighted(&mut self, weighted: &[(Measurement, f64)]) -> Result<(), UpdateError> {
        let missed = (1.0 - weighted.iter().map(|(_, beta)| beta).sum::<f64>()).max(0.0);
        let mut mean = [Pair::default(); 3];
        for (k, x) in mean.iter_mut().enumerate() {
            *x = self.x[k] * missed;
        }
        let mut sum = Self { x: mean, ..Self::default() };
        for (k, p) in sum.p.iter_mut().enumerate() {
            *p = self.p[k] * missed;
        }
        for (k, c) in sum.cross.iter_mut().enumerate() {
            *c = self.cross[k] * missed;
        }
        let updated = |m: &Measurement| {
            let mut copy = *self;
            copy.update(m).map(|_| copy)
        };
        for (m, beta) in weighted {
            sum.accumulate(&updated(m)?, *beta);
        }
        let centre = sum.x;
        let spread =
            |part: &Self| [part.x[0] - centre[0], part.x[1] - centre[1], part.x[2] - centre[2]];
        sum.add_outer(&spread(self), missed);
        for (m, beta) in weighted {
            sum.add_outer(&spread(&updated(m)?), *beta);
        }
        *self = sum;
        Ok(())
    }

    /// P⁻ += c·b bᵀ per axis, b = (1, 2/t, 0): room for an acceleration that no model foresaw, with
    /// the smallest c ≥ 0 for which νᵀ(S + cI)⁻¹ν is at most `target`. Returns c, m².
    ///
    /// Nothing that moves changes its speed by more than two g allow in `t`: what two sensors disagree
    /// on within milliseconds is their error and no manoeuvre.
    pub fn inflate(&mut self, innovation: &Innovation, t: f64, target: f64) -> f64 {
        if innovation.d2.is_nan() || innovation.d2 <= target {
            return 0.0;
        }
        let (nu, s) = (innovation.nu, innovation.s);
        let d2 = |c: f64| {
            if innovation.dof == 1 {
                return nu.norm_squared() / (s.xx + s.yy + c);
            }
            let (a, b, d) = (s.xx + c, s.xy, s.yy + c);
            (d * nu.x * nu.x - 2.0 * b * nu.x * nu.y + a * nu.y * nu.y) / (a * d - b * b)
        };
        let (mut low, mut high) = (0.0, nu.norm_squared() / target);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if d2(middle) > target { low = middle } else { high = middle }
        }
        let rate = if t > 0.0 { (2.0 / t).min(HARDEST_MS2 * t / high.sqrt()) } else { 0.0 };
        self.p[0] = self.p[0] + Pair::splat(high);
        self.p[1] = self.p[1] + Pair::splat(high * rate);
        self.p[3] = self.p[3] + Pair::splat(high * rate * rate);
        high
    }

    /// The covariance in the order x, vx, ax, y, vy, ay.
    #[must_use]
    pub fn covariance(&self) -> SMatrix<f64, 6, 6> {
        let index = |i: usize, j: usize| [[0, 1, 2], [1, 3, 4], [2, 4, 5]][i][j];
        SMatrix::from_fn(|r, c| match (r / 3, c / 3) {
            (0, 0) => self.p[index(r, c)].east(),
            (1, 1) => self.p[index(r - 3, c - 3)].north(),
            (0, _) => self.cross[3 * r + c - 3],
            _ => self.cross[3 * c + r - 3],
        })
    }

    /// True if every number is finite and the covariance positive semidefinite (to rounding).
    ///
    /// A covariance that is not must never be used: the caller reports it and starts the track again.
    #[inline]
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.is_clearly_sound() || self.is_sound_by_correlation()
    }

    /// Axes apart and both well inside: the pivots of L D Lᵀ of both 3 × 3 blocks are far above rounding.
    /// What fails here is looked at again with care.
    #[inline]
    fn is_clearly_sound(&self) -> bool {
        let [a, b, c, e, f, g] = self.p;
        let i = a.recip();
        let (l1, l2) = (b * i, c * i);
        let (e1, f1, g1) = (e - l1 * b, f - l1 * c, g - l2 * c);
        let g2 = g1 - f1 * (f1 * e1.recip());
        // What is not finite leaves no number; the pivots subtract what is not finite from itself.
        let nothing = (a + self.x[0]) * 0.0 + (self.x[1] + self.x[2]) * 0.0;
        let (spare, zero) = (1e-9, Pair::default());
        let bad = zero.not_below(a)
            | zero.not_below(e1 - e * spare)
            | nothing.not_below(Pair::splat(1.0));
        let bad_acceleration = zero.not_below(g2 - g * spare);
        // A filter without an acceleration has none of its covariances.
        let bad = bad.anywhere() || bad_acceleration.anywhere() && [c, f, g] != [zero; 3];
        // Of a zero only the sign may be set.
        let joined = self.cross.iter().fold(0, |bits, c| bits | c.to_bits() << 1);
        !bad && joined == 0
    }

    #[inline(never)]
    fn is_sound_by_correlation(&self) -> bool {
        let mut a = self.covariance();
        if !a.iter().all(|v| v.is_finite()) || !self.x.iter().all(|v| v.sum().is_finite()) {
            return false;
        }
        // Cholesky of the correlation matrix, in place; a component without variance is left out.
        let scale: [f64; 6] = std::array::from_fn(|i| a[(i, i)]);
        if scale.iter().any(|v| *v < 0.0) {
            return false;
        }
        for i in 0..6 {
            for j in 0..6 {
                let d = (scale[i] * scale[j]).sqrt();
                if d == 0.0 {
                    if a[(i, j)] != 0.0 {
                        return false;
                    }
                } else {
                    a[(i, j)] /= d;
                }
            }
        }
        for j in 0..6 {
            let pivot = a[(j, j)];
            if pivot < -1e-9 {
                return false;
            }
            if pivot <= 1e-15 {
                continue;
            }
            for r in j + 1..6 {
                let factor = a[(r, j)] / pivot;
                for c in j + 1..6 {
                    a[(r, c)] -= factor * a[(j, c)];
                }
            }
        }
        true
    }
}

/// Position and velocity of both axes, without an acceleration.
#[derive(Clone, Copy, Debug, Default)]
struct Steady {
    /// Position and velocity, east and north.
    x: [Pair; 2],
    /// Covariance: pp, pv, vv of each axis; of the east position, then velocity, with north position and
    /// velocity.
    p: [Pair; 5],
}

impl Steady {
    #[inline(always)]
    fn of(g: &Gaussian) -> Self {
        let c = &g.cross;
        let p = [g.p[0], g.p[1], g.p[3], Pair::new(c[0], c[1]), Pair::new(c[3], c[4])];
        Self { x: [g.x[0], g.x[1]], p }
    }

    #[inline(always)]
    fn gaussian(&self) -> Gaussian {
        let zero = Pair::default();
        let [a, b, e, c0, c1] = self.p;
        let ([c00, c01], [c10, c11]) = (c0.array(), c1.array());
        Gaussian {
            x: [self.x[0], self.x[1], zero],
            p: [a, b, zero, e, zero, zero],
            cross: [c00, c01, 0.0, c10, c11, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// P ← P + k n nᵀ.
    #[inline(always)]
    fn add_outer(&mut self, n: &[Pair; 2], k: f64) {
        let s = [n[0] * k, n[1] * k];
        let north = Pair::new(n[0].north(), n[1].north());
        self.p[0] = self.p[0] + s[0] * n[0];
        self.p[1] = self.p[1] + s[0] * n[1];
        self.p[2] = self.p[2] + s[1] * n[1];
        self.p[3] = self.p[3] + north * s[0].east();
        self.p[4] = self.p[4] + north * s[1].east();
    }
}

/// The normalised innovation of a measurement against a position (m) with its covariance (m²).
///
/// # Errors
/// If the covariance of the innovation is not positive definite and finite.
#[inline]
pub fn nis_at(at: Point2<f64>, cov: Sym2, m: &Measurement) -> Result<Nis, UpdateError> {
    match *m {
        Measurement::Position { z, r } => {
            let factor = Factor::of(cov + r)?;
            Ok(Nis { d2: factor.d2(z - at), det: factor.det, dof: 2 })
        }
        Measurement::Line { z, axis, variance } => {
            let s = quadratic(cov, axis) + variance;
            if !s.all_positive() {
                return Err(BadInnovation(s));
            }
            let nu = (z - at).dot(&axis);
            Ok(Nis { d2: nu * nu / s, det: s, dof: 1 })
        }
    }
}

/// State and covariance of both axes over one step; the block between the axes is left to the caller.
#[inline(always)]
pub(super) fn predict_axes(x: &[Pair; 3], p: &[Pair; 6], step: &Step) -> ([Pair; 3], [Pair; 6]) {
    let Step { t, f02, f12, f22, q } = *step;
    let [a, b, c, e, f, g] = *p;
    let (c0, f0, g0) = (c + f * t + g * f02, f + g * f12, g * f22);
    let (b0, e0) = (b + e * t + f * f02, e + f * f12);
    let a0 = a + b * t + c * f02;
    (
        [x[0] + x[1] * t + x[2] * f02, x[1] + x[2] * f12, x[2] * f22],
        [
            a0 + b0 * t + c0 * f02 + Pair::splat(q[0]),
            b0 + c0 * f12 + Pair::splat(q[1]),
            c0 * f22 + Pair::splat(q[2]),
            e0 + f0 * f12 + Pair::splat(q[3]),
            f0 * f22 + Pair::splat(q[4]),
            g0 * f22 + Pair::splat(q[5]),
        ],
    )
}

/// uᵀ S u.
#[inline]
pub(super) fn quadratic(s: Sym2, u: Vector2<f64>) -> f64 {
    s.xx * u.x * u.x + 2.0 * s.xy * u.x * u.y + s.yy * u.y * u.y
}

#[cfg(test)]
mod tests;
