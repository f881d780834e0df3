//! The smoother of one target: a linear Gaussian system over a whole run, forwards and back.
//!
//! State: (x, vx, y, vy) at constant velocity with white acceleration of a density that is given interval by interval, then
//! slow errors of unit variance. Plots are scalar rows. Beside the measured values as many *columns* as there are parameters
//! shared by all targets go through the same gains: the innovations are linear in these parameters, so their sums are the
//! likelihood of the parameters with every trajectory integrated out, and what comes back is how much each smoothed state
//! changes with each parameter.
//!
//! Sources: modified Bryson–Frazier form, Bierman, Automatica 9 (1973); the columns: Rosenberg 1973, de Jong, Annals of
//! Statistics 19 (1991); scores of the variances from smoothed disturbances: Koopman, Biometrika 80 (1993).

/// Numbers of the motion in the state: x, vx, y, vy.
pub(super) const MOTION: usize = 4;

/// Most numbers that one row looks at.
const LOOKED_AT: usize = 4;

/// One measured number: `z = h·state + Σ columns·θ + v`, v of this variance.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Places in the state and their factors; a factor of 0 where there are fewer.
    pub(super) h: [(usize, f64); LOOKED_AT],
    pub(super) z: f64,
    pub(super) variance: f64,
    /// By each shared parameter.
    pub(super) columns: Vec<f64>,
}

/// A moment: what moves the state since the one before, and the rows that are measured there.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    /// Since the moment before, s.
    pub(super) after_s: f64,
    /// Density of the acceleration since then, m²/s³.
    pub(super) q: f64,
    /// Share of each slow error that is left of it.
    pub(super) fade: Vec<f64>,
    pub(super) rows: Vec<Row>,
}

/// Scores of a variance: by how much of it there should be (`found`) against what the rows can tell of it (`told`).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scores {
    pub(super) found: f64,
    pub(super) told: f64,
}

/// What is known at one moment from all rows.
#[derive(Clone, Debug)]
pub(super) struct Smoothed {
    /// x, vx, y, vy.
    pub(super) state: [f64; MOTION],
    pub(super) covariance: [[f64; MOTION]; MOTION],
    /// What the motion changes by with each column.
    pub(super) by_column: Vec<[f64; MOTION]>,
    /// Of the density since the moment before.
    pub(super) moved: Scores,
    /// Of the variance of each row.
    pub(super) rows: Vec<Scores>,
}

/// A row as the way forwards took it.
struct Taken {
    gain: Vec<f64>,
    /// Innovations of the measured values, then of each column.
    nu: Vec<f64>,
    s: f64,
}

/// The way forwards.
pub(super) struct Forwards<'a> {
    moments: &'a [Moment],
    n: usize,
    columns: usize,
    /// After each moment: states (measured, then each column), covariance.
    after: Vec<(Vec<f64>, Vec<f64>)>,
    taken: Vec<Vec<Taken>>,
}

/// Where a way begins: a place and deviations of it (m) and of the velocity (m/s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub(super) place: [f64; 2],
    pub(super) sigma_m: f64,
    pub(super) sigma_mps: f64,
}

impl<'a> Forwards<'a> {
    /// Takes all rows in their order, with so many `columns`. None where a number is not finite or a variance not positive.
    pub(super) fn of(moments: &'a [Moment], start: Start, columns: usize) -> Option<Self> {
        let n = MOTION + moments.first()?.fade.len();
        let wide = 1 + columns;
        let (mut x, mut p) = (vec![0.0; n * wide], vec![0.0; n * n]);
        (x[0], x[2]) = (start.place[0], start.place[1]);
        for i in 0..n {
            p[n * i + i] = match i {
                0 | 2 => start.sigma_m * start.sigma_m,
                1 | 3 => start.sigma_mps * start.sigma_mps,
                _ => 1.0,
            };
        }
        let mut this = Self { moments, n, columns, after: Vec::new(), taken: Vec::new() };
        for moment in moments {
            this.carry(&mut x, &mut p, moment);
            let mut taken = Vec::with_capacity(moment.rows.len());
            for row in &moment.rows {
                taken.push(this.take(&mut x, &mut p, row)?);
            }
            this.taken.push(taken);
            this.after.push((x.clone(), p.clone()));
        }
        Some(this)
    }

    fn carry(&self, x: &mut [f64], p: &mut [f64], moment: &Moment) {
        let (n, t) = (self.n, moment.after_s);
        for own in x.chunks_exact_mut(n) {
            own[0] += t * own[1];
            own[2] += t * own[3];
            moment.fade.iter().enumerate().for_each(|(k, f)| own[MOTION + k] *= f);
        }
        for j in 0..n {
            p[j] += t * p[n + j];
            p[2 * n + j] += t * p[3 * n + j];
        }
        for i in 0..n {
            p[n * i] += t * p[n * i + 1];
            p[n * i + 2] += t * p[n * i + 3];
        }
        for (k, f) in moment.fade.iter().enumerate() {
            for j in 0..n {
                p[n * (MOTION + k) + j] *= f;
                p[n * j + MOTION + k] *= f;
            }
            p[(n + 1) * (MOTION + k)] += 1.0 - f * f;
        }
        let [a, b, c] = noise(moment);
        for at in [0, 2] {
            p[n * at + at] += a;
            p[n * at + at + 1] += b;
            p[n * (at + 1) + at] += b;
            p[n * (at + 1) + at + 1] += c;
        }
    }

    fn take(&self, x: &mut [f64], p: &mut [f64], row: &Row) -> Option<Taken> {
        let n = self.n;
        let mut gain: Vec<f64> =
            (0..n).map(|i| row.h.iter().map(|(at, h)| h * p[n * i + at]).sum()).collect();
        let s = row.h.iter().map(|(at, h)| h * gain[*at]).sum::<f64>() + row.variance;
        if !(s > 0.0 && s < f64::INFINITY && row.variance > 0.0) {
            return None;
        }
        let column = gain.clone();
        gain.iter_mut().for_each(|g| *g /= s);
        let mut nu = Vec::with_capacity(1 + self.columns);
        for (k, own) in x.chunks_exact_mut(n).enumerate() {
            let z = if k == 0 { row.z } else { row.columns.get(k - 1).copied().unwrap_or(0.0) };
            let found = z - row.h.iter().map(|(at, h)| h * own[*at]).sum::<f64>();
            if !found.is_finite() {
                return None;
            }
            own.iter_mut().zip(&gain).for_each(|(x, g)| *x += g * found);
            nu.push(found);
        }
        for i in 0..n {
            for j in i..n {
                p[n * i + j] -= gain[i] * column[j];
                p[n * j + i] = p[n * i + j];
            }
        }
        Some(Taken { gain, nu, s })
    }

    /// What the rows say of the shared parameters: adds to the information (columns by columns) and its vector.
    pub(super) fn tell(&self, information: &mut [f64], vector: &mut [f64]) {
        let c = self.columns;
        for taken in self.taken.iter().flatten() {
            for i in 0..c {
                let own = taken.nu[1 + i] / taken.s;
                if own == 0.0 {
                    continue;
                }
                vector[i] += own * taken.nu[0];
                for j in 0..c {
                    information[c * i + j] += own * taken.nu[1 + j];
                }
            }
        }
    }

    /// The way back.
    pub(super) fn back(&self) -> Vec<Smoothed> {
        let (n, wide) = (self.n, 1 + self.columns);
        let (mut small, mut big) = (vec![0.0; n * wide], vec![0.0; n * n]);
        let mut out = Vec::with_capacity(self.moments.len());
        for (k, moment) in self.moments.iter().enumerate().rev() {
            let mut here = self.smoothed(k, &small, &big);
            for (row, taken) in moment.rows.iter().zip(&self.taken[k]).rev() {
                here.rows.push(self.give(&mut small, &mut big, row, taken));
            }
            here.rows.reverse();
            here.moved = moved(&small, &big, n, moment);
            carry_back(&mut small, &mut big, n, moment);
            out.push(here);
        }
        out.reverse();
        out
    }

    fn smoothed(&self, k: usize, small: &[f64], big: &[f64]) -> Smoothed {
        let n = self.n;
        let (x, p) = &self.after[k];
        let motion = |own: &[f64], small: &[f64], i: usize| {
            own[i] - (0..n).map(|j| p[n * i + j] * small[j]).sum::<f64>()
        };
        let (first, lambda) = (&x[..n], &small[..n]);
        // Rows of the motion of P, times Λ.
        let half: Vec<Vec<f64>> = (0..MOTION)
            .map(|i| {
                (0..n).map(|j| (0..n).map(|l| p[n * i + l] * big[n * l + j]).sum::<f64>()).collect()
            })
            .collect();
        let mut covariance = [[0.0; MOTION]; MOTION];
        for (i, line) in covariance.iter_mut().enumerate() {
            for (j, c) in line.iter_mut().enumerate() {
                *c = p[n * i + j] - (0..n).map(|l| half[i][l] * p[n * l + j]).sum::<f64>();
            }
        }
        let by_column = x[n..].chunks_exact(n).zip(small[n..].chunks_exact(n));
        Smoothed {
            state: std::array::from_fn(|i| motion(first, lambda, i)),
            covariance,
            by_column: by_column
                .map(|(own, small)| std::array::from_fn(|i| -motion(own, small, i)))
                .collect(),
            moved: Scores::default(),
            rows: Vec::new(),
        }
    }

    /// Gives a row's part to what comes before it: `λ ← Cᵀλ − hν/s`, `Λ ← CᵀΛC + hhᵀ/s`, C = I − Khᵀ.
    fn give(&self, small: &mut [f64], big: &mut [f64], row: &Row, taken: &Taken) -> Scores {
        let n = self.n;
        let gain = &taken.gain;
        let mut score = Scores::default();
        for (k, own) in small.chunks_exact_mut(n).enumerate() {
            let along: f64 = gain.iter().zip(&*own).map(|(g, l)| g * l).sum();
            let all = taken.nu[k] / taken.s + along;
            if k == 0 {
                score.found = row.variance * all * all;
            }
            row.h.iter().for_each(|(at, h)| own[*at] -= h * all);
        }
        let column: Vec<f64> = (0..n)
            .map(|i| gain.iter().enumerate().map(|(j, g)| big[n * i + j] * g).sum())
            .collect();
        let whole: f64 = gain.iter().zip(&column).map(|(g, c)| g * c).sum::<f64>() + 1.0 / taken.s;
        score.told = row.variance * whole;
        for (at, h) in row.h.iter().filter(|(_, h)| *h != 0.0) {
            for j in 0..n {
                big[n * at + j] -= h * column[j];
                big[n * j + at] -= h * column[j];
            }
        }
        for (a, h) in &row.h {
            for (b, g) in &row.h {
                big[n * a + b] += h * g * whole;
            }
        }
        score
    }
}

/// Variances of one axis that a moment adds: of the place, of both, of the velocity.
fn noise(moment: &Moment) -> [f64; 3] {
    let (q, t) = (moment.q, moment.after_s);
    [q * t * t * t / 3.0, q * t * t / 2.0, q * t]
}

/// `λᵀQλ` and `tr ΛQ`.
fn moved(small: &[f64], big: &[f64], n: usize, moment: &Moment) -> Scores {
    let [a, b, c] = noise(moment);
    let mut scores = Scores::default();
    for at in [0, 2] {
        let (p, v) = (small[at], small[at + 1]);
        scores.found += a * p * p + 2.0 * b * p * v + c * v * v;
        let entry = |i: usize, j: usize| big[n * (at + i) + at + j];
        scores.told += a * entry(0, 0) + 2.0 * b * entry(0, 1) + c * entry(1, 1);
    }
    scores
}

/// `λ ← Φᵀλ`, `Λ ← ΦᵀΛΦ`.
fn carry_back(small: &mut [f64], big: &mut [f64], n: usize, moment: &Moment) {
    let t = moment.after_s;
    for own in small.chunks_exact_mut(n) {
        own[1] += t * own[0];
        own[3] += t * own[2];
        moment.fade.iter().enumerate().for_each(|(k, f)| own[MOTION + k] *= f);
    }
    for j in 0..n {
        big[n + j] += t * big[j];
        big[3 * n + j] += t * big[2 * n + j];
    }
    for i in 0..n {
        big[n * i + 1] += t * big[n * i];
        big[n * i + 3] += t * big[n * i + 2];
    }
    for (k, f) in moment.fade.iter().enumerate() {
        for j in 0..n {
            big[n * (MOTION + k) + j] *= f;
            big[n * j + MOTION + k] *= f;
        }
    }
}
