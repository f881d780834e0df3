//! Spline through noisy data within hard limits on its derivatives.
//!
//! ```text
//! minimise  ½ Σ wᵢ |B(xᵢ) c − zᵢ|²  +  ½ λ Σ |Δ³ c|²
//! so that   |Δᵏ c − m| ≤ r          for every bound (k = 0 to 3)
//! ```
//!
//! The differences `Δᵏ` of the controls bound the k-th derivative everywhere, so a solution keeps its
//! limits at every time, not only at the knots. Solved by Newton steps on a logarithmic barrier
//! (Boyd & Vandenberghe, Convex Optimization (2004), 11.3): every iterate is strictly inside the
//! limits, all matrices are banded, and the number of steps hardly depends on the size.

use super::band::Band;

/// What a control is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Control<const N: usize> {
    /// Number of its variable; neighbours may share one (standstill).
    Free(usize),
    /// Not to be changed.
    Fixed([f64; N]),
}

/// One observation of the spline's value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Datum<const N: usize> {
    /// Place, in steps from the start of the domain.
    pub(super) place: f64,
    pub(super) value: [f64; N],
    /// One over the variance.
    pub(super) weight: f64,
}

/// `|Δ^order c − centre| ≤ radius`, the difference beginning at control `first`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound<const N: usize> {
    pub(super) order: usize,
    pub(super) first: usize,
    pub(super) centre: [f64; N],
    pub(super) radius: f64,
}

impl Bound<1> {
    /// `low ≤ Δ^order c ≤ high`.
    pub(super) fn between(order: usize, first: usize, low: f64, high: f64) -> Self {
        Self { order, first, centre: [0.5 * (low + high)], radius: 0.5 * (high - low) }
    }
}

/// The whole problem.
#[derive(Clone, Debug)]
pub(super) struct Fit<const N: usize> {
    pub(super) controls: Vec<Control<N>>,
    pub(super) data: Vec<Datum<N>>,
    /// Weight of the third differences.
    pub(super) roughness: f64,
    /// Factors of that weight, one for each third difference; all 1 where empty.
    pub(super) stiffness: Vec<f64>,
    pub(super) bounds: Vec<Bound<N>>,
}

/// A linear form of up to four variables: `Σ coefficient · variable + constant`.
#[derive(Clone, Copy, Debug)]
struct Row<const N: usize> {
    terms: [(usize, f64); 4],
    used: usize,
    constant: [f64; N],
}

/// Coefficients of the differences of order 0 to 3.
const DIFFERENCES: [&[f64]; 4] = [&[1.0], &[-1.0, 1.0], &[1.0, -2.0, 1.0], &[-1.0, 3.0, -3.0, 1.0]];

/// Values of the four basis functions at `t` of a piece.
fn basis(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let b0 = s * s * s / 6.0;
    let b3 = t * t * t / 6.0;
    let b1 = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    [b0, b1, 1.0 - b0 - b1 - b3, b3]
}

impl<const N: usize> Fit<N> {
    fn variables(&self) -> usize {
        let numbers = self.controls.iter().filter_map(|c| match c {
            Control::Free(variable) => Some(variable + 1),
            Control::Fixed(_) => None,
        });
        numbers.max().unwrap_or(0)
    }

    fn row(&self, first: usize, coefficients: &[f64]) -> Row<N> {
        let mut row = Row { terms: [(0, 0.0); 4], used: 0, constant: [0.0; N] };
        for (control, coefficient) in self.controls[first..].iter().zip(coefficients) {
            match control {
                Control::Fixed(value) => {
                    row.constant.iter_mut().zip(value).for_each(|(c, v)| *c += coefficient * v);
                }
                Control::Free(variable) => {
                    match row.terms[..row.used].iter_mut().find(|t| t.0 == *variable) {
                        Some(term) => term.1 += coefficient,
                        None => {
                            row.terms[row.used] = (*variable, *coefficient);
                            row.used += 1;
                        }
                    }
                }
            }
        }
        row
    }

    fn datum_row(&self, datum: &Datum<N>) -> Row<N> {
        let pieces = self.controls.len() - 3;
        let place = datum.place.clamp(0.0, pieces as f64);
        let piece = (place as usize).min(pieces - 1);
        self.row(piece, &basis(place - piece as f64))
    }

    /// The controls of a solution without regard to the bounds, or `None` if the data do not fix it.
    pub(super) fn unbounded(&self) -> Option<Vec<[f64; N]>> {
        let system = System::of(self);
        let mut x = vec![[0.0; N]; self.variables()];
        system.newton_step(&mut x, 0.0)?;
        Some(self.expand(&x))
    }

    /// The controls of the solution, from a start strictly within all bounds; `None` if it is not, or
    /// the data do not fix the solution.
    pub(super) fn bounded(&self, start: &[[f64; N]]) -> Option<Vec<[f64; N]>> {
        let system = System::of(self);
        let mut x = vec![[0.0; N]; self.variables()];
        for (control, value) in self.controls.iter().zip(start) {
            if let Control::Free(variable) = control {
                x[*variable] = *value;
            }
        }
        let mut value = system.cost(&x);
        system.barrier(&x)?;
        let count = system.bounds.len().max(1) as f64;
        let mut weight = (value / count).max(1e-3);
        loop {
            for _ in 0..60 {
                let decrement = system.newton_step(&mut x, weight)?;
                if decrement < 1e-3 * weight * count.sqrt() {
                    break;
                }
            }
            if weight * count <= 0.2 {
                break;
            }
            value = system.cost(&x);
            debug_assert!(value.is_finite());
            weight *= 0.15;
        }
        Some(self.expand(&x))
    }

    /// Values of all controls from those of the variables.
    fn expand(&self, x: &[[f64; N]]) -> Vec<[f64; N]> {
        let value = |c: &Control<N>| match c {
            Control::Free(variable) => x[*variable],
            Control::Fixed(value) => *value,
        };
        self.controls.iter().map(value).collect()
    }
}

/// The problem in rows over its variables.
struct System<const N: usize> {
    data: Vec<(Row<N>, [f64; N], f64)>,
    /// Third differences with their weights.
    rough: Vec<(Row<N>, f64)>,
    bounds: Vec<(Row<N>, [f64; N], f64)>,
    variables: usize,
}

impl<const N: usize> Row<N> {
    fn terms(&self) -> &[(usize, f64)] {
        &self.terms[..self.used]
    }

    fn value(&self, x: &[[f64; N]]) -> [f64; N] {
        let mut sum = self.constant;
        for (variable, coefficient) in self.terms() {
            sum.iter_mut().zip(&x[*variable]).for_each(|(s, v)| *s += coefficient * v);
        }
        sum
    }

    /// `value − target` and its square.
    fn error(&self, x: &[[f64; N]], target: &[f64; N]) -> ([f64; N], f64) {
        let mut error = self.value(x);
        error.iter_mut().zip(target).for_each(|(e, t)| *e -= t);
        let square = error.iter().map(|e| e * e).sum();
        (error, square)
    }
}

impl<const N: usize> System<N> {
    fn of(fit: &Fit<N>) -> Self {
        let differences = |order: usize, first: usize| fit.row(first, DIFFERENCES[order]);
        let bound = |b: &Bound<N>| (differences(b.order, b.first), b.centre, b.radius);
        // A bound without variables cannot be met nor missed by a step.
        let bounds = fit.bounds.iter().map(bound).filter(|(row, ..)| row.has_weight()).collect();
        Self {
            data: fit.data.iter().map(|d| (fit.datum_row(d), d.value, d.weight)).collect(),
            rough: (0..fit.controls.len().saturating_sub(3))
                .map(|j| {
                    let factor = fit.stiffness.get(j).copied().unwrap_or(1.0);
                    (differences(3, j), fit.roughness * factor)
                })
                .collect(),
            bounds,
            variables: fit.variables(),
        }
    }

    fn cost(&self, x: &[[f64; N]]) -> f64 {
        let data: f64 = self.data.iter().map(|(row, z, w)| w * row.error(x, z).1).sum();
        let rough: f64 = self.rough.iter().map(|(row, w)| w * row.error(x, &[0.0; N]).1).sum();
        0.5 * (data + rough)
    }

    /// `−Σ ln(r² − |e|²)`, or `None` outside the bounds.
    fn barrier(&self, x: &[[f64; N]]) -> Option<f64> {
        let mut sum = 0.0;
        for (row, centre, radius) in &self.bounds {
            let room = radius * radius - row.error(x, centre).1;
            if room.is_nan() || room <= 0.0 {
                return None;
            }
            sum -= libm::log(room);
        }
        Some(sum)
    }

    /// One damped Newton step on `cost + weight · barrier`; returns half the squared Newton decrement.
    fn newton_step(&self, x: &mut Vec<[f64; N]>, weight: f64) -> Option<f64> {
        let size = self.variables * N;
        let mut hessian = Band::zeros(size, (4 * N - 1).min(size.saturating_sub(1)));
        let mut gradient = vec![0.0; size];
        let mut add = |row: &Row<N>, pull: &[f64; N], curvature: &[[f64; N]; N]| {
            for (index, (i, ci)) in row.terms().iter().enumerate() {
                for a in 0..N {
                    gradient[i * N + a] += ci * pull[a];
                }
                for (j, cj) in &row.terms()[..=index] {
                    for a in 0..N {
                        for b in 0..N {
                            // The lower half of a diagonal block only; `add` mirrors the rest.
                            if i == j && b > a || curvature[a][b] == 0.0 {
                                continue;
                            }
                            hessian.add(i * N + a, j * N + b, ci * cj * curvature[a][b]);
                        }
                    }
                }
            }
        };
        let scaled_identity =
            |w: f64| std::array::from_fn(|a| std::array::from_fn(|b| if a == b { w } else { 0.0 }));
        for (row, z, w) in &self.data {
            let (error, _) = row.error(x, z);
            add(row, &error.map(|e| w * e), &scaled_identity(*w));
        }
        for (row, w) in &self.rough {
            let (error, _) = row.error(x, &[0.0; N]);
            add(row, &error.map(|e| w * e), &scaled_identity(*w));
        }
        if weight > 0.0 {
            for (row, centre, radius) in &self.bounds {
                let (error, square) = row.error(x, centre);
                let room = radius * radius - square;
                let curvature = std::array::from_fn(|a| {
                    std::array::from_fn(|b| {
                        let own = if a == b { 2.0 / room } else { 0.0 };
                        weight * (own + 4.0 * error[a] * error[b] / (room * room))
                    })
                });
                add(row, &error.map(|e| weight * 2.0 * e / room), &curvature);
            }
        }
        hessian.stiffen(1e-13, 1e-12);
        if !hessian.factor() {
            return None;
        }
        let mut step = gradient.clone();
        hessian.solve(&mut step);
        let decrement: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
        if !decrement.is_finite() {
            return None;
        }
        let moved = |share: f64| -> Vec<[f64; N]> {
            let shift = |(i, v): (usize, &[f64; N])| {
                std::array::from_fn(|a| v[a] - share * step[i * N + a])
            };
            x.iter().enumerate().map(shift).collect()
        };
        if weight <= 0.0 {
            *x = moved(1.0);
            return Some(0.5 * decrement);
        }
        let before = self.cost(x) + weight * self.barrier(x)?;
        let mut share = 1.0;
        for _ in 0..50 {
            let candidate = moved(share);
            if let Some(barrier) = self.barrier(&candidate) {
                let after = self.cost(&candidate) + weight * barrier;
                if after <= before - 0.1 * share * decrement + 1e-9 * before.abs() {
                    *x = candidate;
                    return Some(0.5 * decrement);
                }
            }
            share *= 0.5;
        }
        Some(0.0) // no step within rounding: as good as it gets
    }
}

impl<const N: usize> Row<N> {
    fn has_weight(&self) -> bool {
        self.terms().iter().any(|t| t.1 != 0.0)
    }
}
