//! P = U D Uᵀ, U unit upper triangular, D diagonal: the setting that cannot lose its positive definiteness.
//!
//! Sources: Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch. V (update);
//! Thornton, JPL TM 33-798 (1976) (weighted Gram–Schmidt prediction). Where a prior variance of 1e8
//! meets a plot variance of 1e-8, Joseph's form is 11 % off after three scans and this one exact.

use super::gaussian::{Gaussian, Measurement, Nis};
use super::lanes::{Lane, Pair};
use super::motion::Motion;
use super::three_state::start_position;
use super::{Estimate, Start, StateEstimator, UpdateError, UpdateError::BadInnovation, interval};
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
    ud: Ud<3, Pair>,
    q: f64,
    start: Start,
}

impl ThreeStateUd {
    /// One plot: position measured, velocity and acceleration unknown; `q` in m²/s⁵.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, q: f64, start: Start) -> Result<Self, UpdateError> {
        let (z, r) = start_position(plot)?;
        let g = Gaussian::at_position(z, r, start.sigma_v_ms, start.sigma_a_ms2);
        Ok(Self { time: plot.time, x: g.x, ud: factors(&g.p), q, start })
    }

    #[inline]
    fn predict(&self, t: f64) -> ([Pair; 3], Ud<3, Pair>) {
        let h = t * t / 2.0;
        let (half, sixth, d) = super::motion::Step::white_jerk_ud(self.q, t);
        let ud = self.ud.predicted(
            &[[1.0, t, h], [0.0, 1.0, t], [0.0, 0.0, 1.0]],
            &[[1.0, half, sixth], [0.0, 1.0, half], [0.0, 0.0, 1.0]],
            &d,
        );
        let x = &self.x;
        ([x[0] + x[1] * t + x[2] * h, x[1] + x[2] * t, x[2]], ud)
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

    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, gaussian(&self.x, &self.ud))
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
                let one = Pair::splat(1.0);
                let zero = Pair::splat(0.0);
                let Gain { gain, alpha } = ud.update(&[one, zero, zero], Pair::new(r.xx, r.yy));
                if !alpha.all_positive() {
                    return Err(BadInnovation(alpha.east().min(alpha.north())));
                }
                let nu = Pair::new(z.x, z.y) - x[0];
                let y = nu * alpha.recip();
                x = from_fn(|i| x[i] + gain[i] * y);
                Nis { d2: (nu * y).sum(), det: alpha.east() * alpha.north(), dof: 2 }
            }
            line @ Measurement::Line { .. } => {
                let mut joint = gaussian(&x, &ud);
                let nis = joint.update(&line)?;
                (x, ud) = (joint.x, factors(&joint.p));
                nis
            }
        };
        (self.time, self.x, self.ud) = (plot.time, x, ud);
        Ok(nis)
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        (self.time, self.x, self.ud) = (time, state.x, factors(&state.p));
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
        let g = Gaussian::at_position(z, r, start.sigma_v_ms, start.sigma_a_ms2);
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

    fn estimate(&self) -> Estimate {
        Estimate::new(self.time, joint(&self.x, &self.ud))
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
            if variance == f64::INFINITY {
                continue;
            }
            let mut h = [0.0; 6];
            (h[0], h[3]) = (axis.x, axis.y);
            let Gain { gain, alpha } = ud.update(&h, variance);
            if !alpha.all_positive() {
                return Err(BadInnovation(alpha));
            }
            let nu = axis.dot(&plot.position_m) - axis.x * x[0] - axis.y * x[3];
            x = from_fn(|i| x[i] + gain[i] * (nu / alpha));
            nis.d2 += nu * nu / alpha;
            nis.det *= alpha;
            nis.dof += 1;
        }
        (self.time, self.x, self.ud) = (plot.time, x, ud);
        Ok(nis)
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        let p = state.covariance();
        self.time = time;
        self.x = from_fn(|i| state.x[i % 3].0[i / 3]);
        self.ud = Ud::of(from_fn(|i| from_fn(|j| p[(i, j)])));
    }

    fn start(&self) -> Start {
        self.start
    }
}
