//! From losses to outcomes: what a wrong ratio, a fixed move and the steps of an extractor do to a
//! plot, to its detection, and to the position of a track.
//!
//! Derivations: `docs/models.md`, *The effect plan*. All shifts compare two runs on the same draws.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_1_SQRT_2, LN_10};

/// Density of the standard normal distribution.
fn normal_density(z: f64) -> f64 {
    0.398_942_280_401_432_7 * libm::exp(-0.5 * z * z)
}

/// Its upper tail.
fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z * FRAC_1_SQRT_2)
}

/// Amplitude ratio of decibels, `10^(−db/20)`.
fn shrunk(db: f64) -> f64 {
    libm::exp(-db * LN_10 / 20.0)
}

/// Rms shift of one axis where the ratio is shown wrong by −`lowers_db` … +`raises_db`, m.
///
/// The thermal error is `n·σ(χ)`, `σ = sigma_1/√max(χ, least)`, with the same `n` in both runs: the
/// shift is `n` times the difference of the deviations. Largest over every exact ratio from `lowest` up.
#[must_use]
pub fn shift_by_ratio(
    sigma_1: f64,
    least: f64,
    lowest: f64,
    raises_db: f64,
    lowers_db: f64,
) -> f64 {
    let sigma = |ratio: f64| sigma_1 / ratio.max(least).sqrt();
    let high = sigma(lowest) * -libm::expm1(-raises_db * LN_10 / 20.0);
    let half = shrunk(lowers_db);
    let low = sigma(lowest * half * half) * -libm::expm1(-lowers_db * LN_10 / 20.0);
    high.max(low)
}

/// `√(2/π)`: mean of |n|.
pub const MEAN_ABS: f64 = 0.797_884_560_802_865_4;

/// Largest mean of `|z|·φ(z)` over the edges of steps, times step over deviation `u`: how often a
/// shift in proportion to a normal draw carries that draw over an edge, at the worst place among the
/// steps. At least `√(2/π)`, which holds for a spread place.
#[must_use]
pub fn edge_factor(u: f64) -> f64 {
    if u < 0.2 {
        // So many edges that the place is as good as spread.
        return MEAN_ABS;
    }
    worst_place(u, |z| z.abs() * normal_density(z)).max(MEAN_ABS)
}

/// Largest density of a normal place times the step, `u` steps per deviation: how often a fixed shift
/// carries over an edge, in units of shift over step. At least 1.
#[must_use]
pub fn density_factor(u: f64) -> f64 {
    if u < 1.0 { 1.0 } else { worst_place(u, normal_density).max(1.0) }
}

/// Largest sum over the edges `z = (k + o)·u`, o on a grid of 400 places of a step.
fn worst_place(u: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PLACES: i32 = 400;
    let edges = (6.5 / u).ceil() as i32 + 1;
    let sum = |place: i32| -> f64 {
        let offset = f64::from(place) / f64::from(PLACES);
        u * (-edges..=edges).map(|k| f((f64::from(k) + offset) * u)).sum::<f64>()
    };
    // The sum is the same on both sides of the middle; where edges are dense, it hardly changes.
    let every = if u < 2.0 { 10 } else { 1 };
    (0..=PLACES / 2).step_by(every).map(sum).fold(0.0, f64::max)
}

/// [`edge_factor`] and [`density_factor`] from a table: never below them by more than a thousandth.
#[derive(Clone, Debug, PartialEq)]
pub struct StepTable(Vec<[f64; 2]>);

const STEP_PER_UNIT: f64 = 8.0;
const STEP_TO: f64 = 12.0;

impl Default for StepTable {
    fn default() -> Self {
        let count = (STEP_TO * STEP_PER_UNIT) as u32;
        let at = |i| f64::from(i) / STEP_PER_UNIT;
        Self((0..=count).map(|i| [edge_factor(at(i)), density_factor(at(i))]).collect())
    }
}

impl StepTable {
    /// Both factors at `u`: the larger of the two entries around it, and 1 % more for what lies between.
    #[must_use]
    pub fn at(&self, u: f64) -> (f64, f64) {
        let place = u * STEP_PER_UNIT;
        if place >= (self.0.len() - 1) as f64 {
            // Only one edge counts.
            return (0.241_971 * u, normal_density(0.0) * u);
        }
        let (a, b) = (self.0[place as usize], self.0[place as usize + 1]);
        (1.01 * a[0].max(b[0]), 1.01 * a[1].max(b[1]))
    }
}

/// Largest change of a probability of detection `pd` (of decibels, growing, steepest at one place)
/// while the exact ratio is anywhere in `range_db` and the shown one off by −`lowers_db` … +`raises_db`.
#[must_use]
pub fn detection_change(
    pd: impl Fn(f64) -> f64,
    range_db: (f64, f64),
    raises_db: f64,
    lowers_db: f64,
    steps: u32,
) -> f64 {
    let up = |db: f64| pd(db + raises_db) - pd(db);
    let down = |db: f64| pd(db) - pd(db - lowers_db);
    let worst_up = if raises_db > 0.0 { largest(&up, range_db, steps) } else { 0.0 };
    let worst_down = if lowers_db > 0.0 { largest(&down, range_db, steps) } else { 0.0 };
    f64::max(worst_up, worst_down)
}

/// Largest value of a function with one maximum: golden section.
fn largest(f: &impl Fn(f64) -> f64, (mut low, mut high): (f64, f64), steps: u32) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let mut most = f(low).max(f(high));
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..steps {
        most = most.max(fa).max(fb);
        // Where both are flat, the side on which the ends differ is not known: towards the larger end.
        if fa > fb || (fa == fb && f(low) > f(high)) {
            (high, b, fb) = (b, a, fa);
            a = high - GOLDEN * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + GOLDEN * (high - low);
            fb = f(b);
        }
    }
    most
}

/// A shift of one axis, on the ground, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisShift {
    /// Deviation of a shift in proportion to the draw of the plot's own thermal error.
    pub drawn_m: f64,
    /// The same from scan to scan.
    pub fixed_m: f64,
    /// Deviation of a shift by draws of its own.
    pub own_m: f64,
    /// The largest of a bounded shift that goes with anything: left out steps where nothing spreads them.
    pub bounded_m: f64,
    /// Step of the extractor in both runs; 0 for none.
    pub step_m: f64,
    /// Factors of the steps: edge and density, at the place of the plot among them.
    pub factors: (f64, f64),
    /// Whether nothing spreads the plot of one run over the steps: then every shift may be a whole step.
    pub on_edge: bool,
}

impl AxisShift {
    /// Mean square of the shift after the steps, m².
    #[must_use]
    pub fn square_m2(&self) -> f64 {
        let same = self.drawn_m + self.bounded_m;
        let moved = self.drawn_m + self.fixed_m + self.own_m + self.bounded_m;
        if self.step_m > 0.0 && self.on_edge && moved > 0.0 {
            let whole = moved + self.step_m;
            return whole * whole;
        }
        let smooth = if self.bounded_m > 0.0 {
            let sum = same + self.fixed_m;
            sum * sum
        } else {
            self.drawn_m * self.drawn_m + self.fixed_m * self.fixed_m
        };
        smooth + self.own_m * self.own_m + self.step_m * self.flips_m()
    }

    /// Mean number of steps that a plot is carried, times the step, m.
    fn flips_m(&self) -> f64 {
        if self.step_m == 0.0 {
            return 0.0;
        }
        let (edge, density) = self.factors;
        // The rule is of first order in the shift: two hundredths more where it is not small.
        1.02 * (edge * self.drawn_m + density * (self.fixed_m + MEAN_ABS * self.own_m))
    }

    /// Probability that the steps carry a plot.
    #[must_use]
    pub fn flip(&self) -> f64 {
        let moved = self.drawn_m + self.fixed_m + self.own_m;
        if self.step_m == 0.0 || moved == 0.0 {
            0.0
        } else if self.on_edge {
            1.0
        } else {
            (self.flips_m() / self.step_m).min(1.0)
        }
    }
}

/// Probability that a plot is shifted by more than `limit_m`, from the shifts of both axes.
///
/// Steps of an axis either count as they are or by the probability of a flip, whichever is less.
#[must_use]
pub fn tail(axes: &[AxisShift; 2], limit_m: f64) -> f64 {
    let drawn2: f64 = axes
        .iter()
        .map(|a| {
            let sum = a.drawn_m + a.own_m;
            sum * sum
        })
        .sum();
    let rms = drawn2.sqrt();
    let flips = axes.map(|a| a.flip());
    let fixed = hypot(axes[0].fixed_m + axes[0].bounded_m, axes[1].fixed_m + axes[1].bounded_m);
    let mut least = 1.0f64;
    for counted in 0..4u8 {
        let (mut jump2, mut chance) = (0.0, 0.0);
        for (i, axis) in axes.iter().enumerate() {
            if counted >> i & 1 == 1 {
                chance += flips[i];
            } else if flips[i] > 0.0 {
                jump2 += axis.step_m * axis.step_m;
            }
        }
        let left = limit_m - jump2.sqrt() - fixed;
        let beyond = if rms == 0.0 {
            if left >= 0.0 { 0.0 } else { 1.0 }
        } else if left <= 0.0 {
            1.0
        } else {
            // Two axes: the vector is within where both are, at the rms of their sum.
            2.0 * normal_tail(left / rms)
        };
        least = least.min(chance + beyond);
    }
    least
}

fn hypot(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Gains of a steady filter of position, speed and acceleration against white jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackGain {
    /// Gain on the position.
    pub gain: f64,
    /// Mean square of the position's error over that of white errors of the plots.
    pub noise_gain: f64,
}

impl TrackGain {
    /// The gains at a period, for white jerk of density `jerk_m2_s5` and plots of `variance_m2`.
    ///
    /// Riccati and Lyapunov recursions until they stand still. `None` where they do not.
    #[must_use]
    pub fn steady(period_s: f64, jerk_m2_s5: f64, variance_m2: f64) -> Option<Self> {
        let t = period_s;
        let (t2, t3) = (t * t, t * t * t);
        #[rustfmt::skip]
        let (f, q) = (
            Matrix3::new(1.0, t, 0.5 * t2, 0.0, 1.0, t, 0.0, 0.0, 1.0),
            Matrix3::new(
                t2 * t3 / 20.0, t2 * t2 / 8.0, t3 / 6.0,
                t2 * t2 / 8.0, t3 / 3.0, t2 / 2.0,
                t3 / 6.0, t2 / 2.0, t,
            ) * (jerk_m2_s5 / variance_m2),
        );
        // Everything in units of the plots' variance.
        let mut p = Matrix3::identity() * (1.0 + jerk_m2_s5 / variance_m2);
        let mut k = Vector3::zeros();
        let mut left = 200_000;
        loop {
            let predicted = f * p * f.transpose() + q;
            let next: Vector3<f64> = predicted.column(0) / (predicted[(0, 0)] + 1.0);
            let update = Matrix3::identity() - next * Matrix3::identity().row(0);
            p = update * predicted * update.transpose() + next * next.transpose();
            let moved = (next - k).amax();
            k = next;
            left -= 1;
            if moved <= 1e-14 * k.amax() {
                break;
            }
            if left == 0 || !moved.is_finite() {
                return None;
            }
        }
        let step = (Matrix3::identity() - k * Matrix3::identity().row(0)) * f;
        // Sum of (step^n) K Kᵀ (step^n)ᵀ by doubling.
        let (mut sum, mut power) = (k * k.transpose(), step);
        for _ in 0..40 {
            sum += power * sum * power.transpose();
            power *= power;
        }
        sum[(0, 0)].is_finite().then_some(Self { gain: k[0], noise_gain: sum[(0, 0)] })
    }

    /// Rms shift of the published position, from the rms of shifts that are new in each scan and a
    /// fixed one.
    #[must_use]
    pub fn shift_m(&self, white_m: f64, fixed_m: f64) -> f64 {
        (fixed_m * fixed_m + self.noise_gain * white_m * white_m).sqrt()
    }
}

#[cfg(test)]
mod tests;
