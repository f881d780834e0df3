//! P = U D Uᵀ, U unit upper triangular, D diagonal: the setting that cannot lose its positive definiteness.
//!
//! Sources: Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch. V (update);
//! Thornton, JPL TM 33-798 (1976) (weighted Gram–Schmidt prediction). Where a prior variance of 1e8
//! meets a plot variance of 1e-8, Joseph's form is 11 % off after three scans and this one exact.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::lanes::{Lane, Pair};
use super::modes::Modes;
use super::motion::Motion;
use super::three_state::{along_a_line, start_position};
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, UpdateError, UpdateError::BadInnovation, interval};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use std::array::from_fn;

/// The factors of a covariance of N components, in one or two lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ud<const N: usize, L: Lane> {
    /// Unit upper triangular; what is on and below the diagonal is not used.
    pub u: [[L; N]; N],
    /// Diagonal, not negative.
    pub d: [L; N],
}

/// What one scalar update does to the state: `x += gain · (z − h x) / alpha`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain<const N: usize, L: Lane> {
    /// P⁻ h.
    pub gain: [L; N],
    /// Variance of the innovation.
    pub alpha: L,
}

#[expect(clippy::needless_range_loop, reason = "the indices are those of the published algorithm")]
impl<const N: usize, L: Lane> Ud<N, L> {
    /// A diagonal covariance.
    #[must_use]
    pub fn diagonal(d: [L; N]) -> Self {
        Self { u: [[L::splat(0.0); N]; N], d }
    }

    /// The factors of a positive semidefinite matrix (only its upper triangle is read).
    #[must_use]
    pub fn of(mut a: [[L; N]; N]) -> Self {
        let mut ud = Self::diagonal([L::splat(0.0); N]);
        for j in (0..N).rev() {
            ud.d[j] = a[j][j];
            for i in 0..j {
                ud.u[i][j] = a[i][j].div_or(ud.d[j], 0.0);
            }
            for k in 0..j {
                for i in k..j {
                    a[k][i] = a[k][i] - ud.u[k][j] * ud.d[j] * ud.u[i][j];
                }
            }
        }
        ud
    }

    /// Element (i, j) of P.
    #[must_use]
    pub fn covariance(&self, i: usize, j: usize) -> L {
        let (i, j) = (i.min(j), i.max(j));
        let above = |r: usize, c: usize| if r == c { L::splat(1.0) } else { self.u[r][c] };
        (j..N).fold(L::splat(0.0), |sum, m| sum + above(i, m) * self.d[m] * above(j, m))
    }

    /// Prediction `P ← Φ P Φᵀ + U_q D_q U_qᵀ` by weighted Gram–Schmidt.
    #[inline]
    #[must_use]
    pub fn predicted(
        &self,
        phi: &[[f64; N]; N],
        noise_u: &[[f64; N]; N],
        noise_d: &[f64; N],
    ) -> Self {
        // W = [Φ U | U_q]; Φ is upper triangular, so is Φ U.
        let mut w: [[L; N]; N] = from_fn(|i| {
            from_fn(|j| {
                if j < i {
                    return L::splat(0.0);
                }
                (i..j).fold(L::splat(phi[i][j]), |sum, k| sum + self.u[k][j] * L::splat(phi[i][k]))
            })
        });
        let mut v: [[L; N]; N] = from_fn(|i| {
            from_fn(|j| {
                L::splat(if i == j {
                    1.0
                } else if j > i {
                    noise_u[i][j]
                } else {
                    0.0
                })
            })
        });
        self.orthogonalise(&mut w, &mut v, noise_d)
    }

    #[inline]
    fn orthogonalise(&self, w: &mut [[L; N]; N], v: &mut [[L; N]; N], noise_d: &[f64; N]) -> Self {
        let mut next = Self::diagonal([L::splat(0.0); N]);
        for j in (0..N).rev() {
            let wd: [L; N] = from_fn(|m| w[j][m] * self.d[m]);
            let vd: [L; N] = from_fn(|m| v[j][m] * L::splat(noise_d[m]));
            let dot = |a: &[L; N], b: &[L; N]| {
                (0..N).fold(L::splat(0.0), |sum, m| sum + a[m] * wd[m] + b[m] * vd[m])
            };
            next.d[j] = dot(&w[j], &v[j]);
            for i in 0..j {
                let u = dot(&w[i], &v[i]).div_or(next.d[j], 0.0);
                next.u[i][j] = u;
                for m in 0..N {
                    w[i][m] = w[i][m] - u * w[j][m];
                    v[i][m] = v[i][m] - u * v[j][m];
                }
            }
        }
        next
    }

    /// One scalar update with row `h` and variance `r ≥ 0`. A zero `r`, a zero variance of the state
    /// and both together are allowed; the caller looks at `alpha` before it divides by it.
    #[inline]
    pub fn update(&mut self, h: &[L; N], r: L) -> Gain<N, L> {
        let zero = L::splat(0.0);
        let f: [L; N] = from_fn(|j| (0..j).fold(h[j], |sum, i| sum + self.u[i][j] * h[i]));
        let g: [L; N] = from_fn(|j| self.d[j] * f[j]);
        let (mut alpha, mut gain) = (r, [zero; N]);
        for j in 0..N {
            let before = alpha;
            alpha = alpha + f[j] * g[j];
            self.d[j] = self.d[j] * before.div_or(alpha, 1.0);
            let lambda = (zero - f[j]).div_or(before, 0.0);
            for i in 0..j {
                let t = self.u[i][j];
                self.u[i][j] = t + gain[i] * lambda;
                gain[i] = gain[i] + g[j] * t;
            }
            gain[j] = g[j];
        }
        Gain { gain, alpha }
    }
}

/// Constant acceleration per axis in factored form, both axes in one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeStateUd {
    time: SimTime,
    x: [Pair; 3],
    factors: Packed,
    q: f64,
    start: Start,
}

/// The six factors of three components that are not 0 or 1: U₀₁, U₀₂, U₁₂ and D.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Packed {
    u: [Pair; 3],
    d: [Pair; 3],
}

impl Packed {
    #[inline(always)]
    fn of(ud: &Ud<3, Pair>) -> Self {
        Self { u: [ud.u[0][1], ud.u[0][2], ud.u[1][2]], d: ud.d }
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        // One sum says it of all; what is near the end of the range is refused with it.
        let [u, d] = [&self.u, &self.d].map(|f| f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
        (u + d).sum().is_finite()
    }

    #[inline(always)]
    fn ud(&self) -> Ud<3, Pair> {
        let mut ud = Ud::diagonal(self.d);
        [ud.u[0][1], ud.u[0][2], ud.u[1][2]] = self.u;
        ud
    }
}

impl ThreeStateUd {
    /// One plot: position measured, velocity and acceleration unknown; `q` in m²/s⁵.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, q: f64, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let g = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        let factors = Packed::of(&factors(&g.p));
        Ok(Self { time: plot.time, x: g.x, factors, q, start })
    }

    #[inline]
    fn predict(&self, t: f64) -> ([Pair; 3], Ud<3, Pair>) {
        let x = &self.x;
        let h = 0.5 * t * t;
        ([x[0] + x[1] * t + x[2] * h, x[1] + x[2] * t, x[2]], self.factors.ud().jerked(self.q, t))
    }
}

impl<L: Lane> Ud<3, L> {
    /// [`Self::predicted`] for constant acceleration with white jerk `q`, the ones and zeros of Φ, U
    /// and U_q left out.
    #[inline(always)]
    #[must_use]
    pub fn jerked(&self, q: f64, t: f64) -> Self {
        let (half, sixth, n) = super::motion::Step::white_jerk_ud(q, t);
        let [n0, n1, n2] = n.map(L::splat);
        let (t1, h) = (L::splat(t), L::splat(0.5 * t * t));
        let [d0, d1, d2] = self.d;
        let (u01, u02, u12) = (self.u[0][1], self.u[0][2], self.u[1][2]);
        // Rows of [ΦU | U_q], from the last one up.
        let (w01, w02, w12) = (u01 + t1, u02 + u12 * t1 + h, u12 + t1);
        let (v01, v02, v12) = (L::splat(half), L::splat(sixth), L::splat(half));
        let e2 = d2 + n2;
        let (a12, a02) =
            ((d2 * w12 + n2 * v12).div_or(e2, 0.0), (d2 * w02 + n2 * v02).div_or(e2, 0.0));
        let (w12, w02, v12, v02) = (w12 - a12, w02 - a02, v12 - a12, v02 - a02);
        let (dw12, nv12) = (d2 * w12, n2 * v12);
        let e1 = (d1 + n1) + (dw12 * w12 + nv12 * v12);
        let a01 = ((d1 * w01 + n1 * v01) + (dw12 * w02 + nv12 * v02)).div_or(e1, 0.0);
        let (w01, v01) = (w01 - a01, v01 - a01);
        let (w02, v02) = (w02 - a01 * w12, v02 - a01 * v12);
        let e0 = (d0 + n0) + (d1 * w01 * w01 + n1 * v01 * v01) + (d2 * w02 * w02 + n2 * v02 * v02);
        let mut next = Self::diagonal([e0, e1, e2]);
        (next.u[0][1], next.u[0][2], next.u[1][2]) = (a01, a02, a12);
        next
    }

    /// [`Self::update`] with h = (1, 0, 0).
    #[inline(always)]
    pub fn update_first(&mut self, r: L) -> Gain<3, L> {
        let [d0, d1, d2] = self.d;
        let (u01, u02, u12) = (self.u[0][1], self.u[0][2], self.u[1][2]);
        let (g1, g2) = (d1 * u01, d2 * u02);
        let a0 = r + d0;
        let a1 = a0 + u01 * g1;
        let a2 = a1 + u02 * g2;
        self.d = [d0 * r.div_or(a0, 1.0), d1 * a0.div_or(a1, 1.0), d2 * a1.div_or(a2, 1.0)];
        let zero = L::splat(0.0);
        let (l1, l2) = ((zero - u01).div_or(a0, 0.0), (zero - u02).div_or(a1, 0.0));
        let k0 = d0 + g1 * u01;
        self.u[0][1] = u01 + d0 * l1;
        self.u[0][2] = u02 + k0 * l2;
        self.u[1][2] = u12 + g1 * l2;
        Gain { gain: [k0 + g2 * u02, g1 + g2 * u12, g2], alpha: a2 }
    }
}

fn factors(p: &[Pair; 6]) -> Ud<3, Pair> {
    let [a, b, c, e, f, g] = *p;
    Ud::of([[a, b, c], [b, e, f], [c, f, g]])
}

fn gaussian(x: &[Pair; 3], ud: &Ud<3, Pair>) -> Gaussian {
    let p = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(i, j)| ud.covariance(i, j));
    Gaussian { x: *x, p, cross: [0.0; 9] }
}

impl StateEstimator for ThreeStateUd {
    fn time(&self) -> SimTime {
        self.time
    }

    #[inline]
    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, gaussian(&self.x, &self.factors.ud()))
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let [p, v, _] = self.x.map(Pair::array);
        (Point2::new(p[0], p[1]), Vector2::new(v[0], v[1]))
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let (x, ud) = self.predict(interval(self.time, time)?);
        Ok(Estimate::new(time, gaussian(&x, &ud)))
    }

    #[inline]
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let (mut x, mut ud) = self.predict(interval(self.time, plot.time)?);
        let nis = match Measurement::of(plot)? {
            Measurement::Position { z, r } => {
                let Gain { gain, alpha } = ud.update_first(Pair::new(r.xx, r.yy));
                if !alpha.all_positive() {
                    return Err(BadInnovation(alpha.east().min(alpha.north())));
                }
                let nu = Pair::new(z.x, z.y) - x[0];
                let y = nu * alpha.recip();
                if !(nu * y).sum().is_finite() {
                    return Err(BadInnovation((nu * y).sum()));
                }
                x = [x[0] + gain[0] * y, x[1] + gain[1] * y, x[2] + gain[2] * y];
                Nis { d2: (nu * y).sum(), det: alpha.east() * alpha.north(), dof: 2 }
            }
            line @ Measurement::Line { .. } => {
                let g = gaussian(&x, &ud);
                let (next, p, nis) = along_a_line(g.x, g.p, &line)?;
                (x, ud) = (next, factors(&p));
                nis
            }
        };
        let factors = Packed::of(&ud);
        if !factors.is_finite() {
            return Err(UpdateError::BadCovariance);
        }
        (self.time, self.x, self.factors) = (plot.time, x, factors);
        Ok(nis)
    }

    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        super::taken(self, plot)
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        (self.time, self.x, self.factors) = (time, state.x, Packed::of(&factors(&state.p)));
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// Six states in factored form; a plot is two scalar updates along its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixStateUd {
    time: SimTime,
    x: [f64; 6],
    ud: Ud<6, f64>,
    q: f64,
    start: Start,
}

impl SixStateUd {
    /// One plot: position measured, velocity and acceleration unknown; `q` in m²/s⁵.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, q: f64, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let g = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        let mut filter =
            Self { time: plot.time, x: [0.0; 6], ud: Ud::diagonal([0.0; 6]), q, start };
        filter.replace(plot.time, &g);
        Ok(filter)
    }

    fn predict(&self, t: f64) -> ([f64; 6], Ud<6, f64>) {
        let step = Motion::ConstantAcceleration { q: self.q }.step(t);
        let (half, sixth, d) = super::motion::Step::white_jerk_ud(self.q, t);
        let mut phi = [[0.0; 6]; 6];
        let mut noise = [[0.0; 6]; 6];
        for b in [0, 3] {
            for k in 0..3 {
                phi[b + k][b + k] = 1.0;
                noise[b + k][b + k] = 1.0;
            }
            (phi[b][b + 1], phi[b][b + 2], phi[b + 1][b + 2]) = (t, step.f02, step.f12);
            (noise[b][b + 1], noise[b][b + 2], noise[b + 1][b + 2]) = (half, sixth, half);
        }
        let ud = self.ud.predicted(&phi, &noise, &[d[0], d[1], d[2], d[0], d[1], d[2]]);
        let x = from_fn(|i| (i..6).map(|j| phi[i][j] * self.x[j]).sum());
        (x, ud)
    }
}

fn joint(x: &[f64; 6], ud: &Ud<6, f64>) -> Gaussian {
    let c = |i: usize, j: usize| ud.covariance(i, j);
    Gaussian {
        x: from_fn(|i| Pair::new(x[i], x[i + 3])),
        p: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            .map(|(i, j)| Pair::new(c(i, j), c(i + 3, j + 3))),
        cross: from_fn(|k| c(k / 3, 3 + k % 3)),
    }
}

impl StateEstimator for SixStateUd {
    fn time(&self) -> SimTime {
        self.time
    }

    #[inline]
    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, joint(&self.x, &self.ud))
    }

    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let x = &self.x;
        (Point2::new(x[0], x[3]), Vector2::new(x[1], x[4]))
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let (x, ud) = self.predict(interval(self.time, time)?);
        Ok(Estimate::new(time, joint(&x, &ud)))
    }

    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        Measurement::of(plot)?;
        let (mut x, mut ud) = self.predict(interval(self.time, plot.time)?);
        let along = (plot.axis, plot.along_m2);
        let across = (plot.across_axis(), plot.across_m2);
        let mut nis = Nis { d2: 0.0, det: 1.0, dof: 0 };
        for (axis, variance) in [along, across] {
            if variance >= 1e20 {
                continue; // says nothing, as in `Measurement::of`
            }
            let mut h = [0.0; 6];
            (h[0], h[3]) = (axis.x, axis.y);
            let Gain { gain, alpha } = ud.update(&h, variance);
            let nu = axis.dot(&plot.position_m.coords) - axis.x * x[0] - axis.y * x[3];
            if !alpha.all_positive() || !(nu * nu / alpha).is_finite() {
                return Err(BadInnovation(alpha));
            }
            x = from_fn(|i| x[i] + gain[i] * (nu / alpha));
            nis.d2 += nu * nu / alpha;
            nis.det *= alpha;
            nis.dof += 1;
        }
        // Two directions known exactly and almost the same: the factors may leave the range of f64.
        let finite =
            x.iter().all(|x| x.is_finite()) && (0..6).all(|i| ud.covariance(i, i).is_finite());
        if !finite {
            return Err(UpdateError::BadCovariance);
        }
        (self.time, self.x, self.ud) = (plot.time, x, ud);
        Ok(nis)
    }

    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        super::taken(self, plot)
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        let p = state.covariance();
        self.time = time;
        self.x = from_fn(|i| state.x[i % 3].array()[i / 3]);
        self.ud = Ud::of(from_fn(|i| from_fn(|j| p[(i, j)])));
    }

    fn start(&self) -> Start {
        self.start
    }
}

/// The rung `ca3-ud`.
pub const CA3_UD: Declared = Declared {
    word: "ca3-ud",
    about: "Kalman filter, one axis at a time, factored covariance",
    cost: 3,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        let filter = ThreeStateUd::from_plot(plot, config.q, config.start)?;
        Ok(Estimator::ThreeStateUd(filter))
    },
};

/// The rung `ca6-ud`.
pub const CA6_UD: Declared = Declared {
    word: "ca6-ud",
    about: "Kalman filter, both axes together, factored covariance",
    cost: 25,
    modes: Modes::three,
    histories: None,
    start: |config, plot| {
        let filter = SixStateUd::from_plot(plot, config.q, config.start)?;
        Ok(Estimator::SixStateUd(Box::new(filter)))
    },
};
