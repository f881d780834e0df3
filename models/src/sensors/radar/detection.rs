//! Detection of `n` integrated pulses after a square-law detector: threshold, probability, required ratio.

use crate::association::amplitude::AmplitudeLaw;
use crate::special::{ln_gamma_p, ln_gamma_q};
use std::f64::consts::{LN_10, SQRT_2};

/// How the echo of a target fluctuates. Source: Swerling (1960).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Swerling {
    /// Case 0 (or 5): steady.
    #[default]
    Steady,
    /// Case 1: Rayleigh amplitude, the same for all pulses of a scan.
    One,
    /// Case 2: Rayleigh amplitude, new for each pulse.
    Two,
    /// Case 3: one dominant scatterer, the same for all pulses of a scan.
    Three,
    /// Case 4: one dominant scatterer, new for each pulse.
    Four,
}

impl Swerling {
    /// Case by its number, 0 to 4 (5 is another name of 0).
    #[must_use]
    pub fn case(number: u64) -> Option<Self> {
        Some(match number {
            0 | 5 => Self::Steady,
            1 => Self::One,
            2 => Self::Two,
            3 => Self::Three,
            4 => Self::Four,
            _ => return None,
        })
    }

    /// Order of the gamma distribution of the echo's energy; infinite when steady.
    fn order(self, n: u32) -> f64 {
        match self {
            Self::Steady => f64::INFINITY,
            Self::One => 1.0,
            Self::Two => f64::from(n),
            Self::Three => 2.0,
            Self::Four => 2.0 * f64::from(n),
        }
    }
}

/// The value that a gamma variate of order `order` exceeds with `ln_share` of the probability with which it exceeds
/// `from`: Newton steps on the logarithm.
fn above(order: f64, from: f64, ln_share: f64) -> f64 {
    let at = ln_gamma_q(order, from);
    let slope = |y: f64, ln_q: f64| {
        // −d ln Q/dy = y^(k−1)·e^(−y)/(Γ(k)·Q), which is at most 1 in the tail.
        libm::exp((order - 1.0) * libm::log(y) - y - libm::lgamma(order) - ln_q)
    };
    // ln Q is concave: from here on every step but the first comes from the right.
    let mut y = from.max(order);
    let mut ln_q = ln_gamma_q(order, y);
    for _ in 0..60 {
        let rest = ln_q - at - ln_share;
        let step = rest / slope(y, ln_q).max(1e-12);
        y = (y + step).max(from);
        if step.abs() <= 1e-12 * y || !step.is_finite() {
            break;
        }
        ln_q = ln_gamma_q(order, y);
    }
    y
}

/// A square-law detector that sums `n` pulses and compares with a threshold in units of noise power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector {
    /// Pulses summed.
    pub n: u32,
    /// Probability of a false alarm in one cell.
    pub pfa: f64,
    /// Threshold on the sum.
    pub threshold: f64,
}

impl Detector {
    /// The detector of `n ≥ 1` pulses for a false alarm probability inside (0, 1).
    ///
    /// The threshold solves `Q(n, T) = Pfa`, `Q` the regularised upper incomplete gamma function, by
    /// Newton steps on its logarithm; for one pulse it is `−ln Pfa`.
    #[must_use]
    pub fn new(n: u32, pfa: f64) -> Self {
        let target = libm::log(pfa);
        if n == 1 {
            return Self { n, pfa, threshold: -target };
        }
        let a = f64::from(n);
        let mut t = a + 3.0 * a.sqrt() - target;
        for _ in 0..100 {
            let ln_q = ln_gamma_q(a, t);
            // d ln Q/dT = −T^(n−1)·e^(−T)/((n−1)!·Q)
            let slope = -libm::exp((a - 1.0) * libm::log(t) - t - libm::lgamma(a) - ln_q);
            let step = (ln_q - target) / slope;
            t = (t - step).max(0.1 * t);
            if step.abs() < 1e-15 * t {
                break;
            }
        }
        Self { n, pfa, threshold: t }
    }

    /// Probability that a target of mean signal-to-noise ratio `snr` per pulse is detected: the exact level.
    ///
    /// `Pd = Σ w_m·Q(n+m, T) + W_{>M}`, where `w` is the Poisson (steady) or negative binomial (fading)
    /// distribution of the number of signal quanta; every term is positive. Relative error 1e-13.
    /// Always within [Pfa, 1].
    #[must_use]
    pub fn probability(&self, snr: f64, swerling: Swerling) -> f64 {
        debug_assert!(snr >= 0.0);
        let n = f64::from(self.n);
        let s = n * snr;
        if s == 0.0 {
            return self.pfa;
        }
        let order = swerling.order(self.n);
        if self.n == 1 && order == 1.0 {
            return libm::exp(libm::log(self.pfa) / (1.0 + snr)).clamp(self.pfa, 1.0);
        }
        // Beyond this the miss probability is below 1e-200 for a steady target.
        if order == f64::INFINITY && s > 700.0 {
            return 1.0;
        }
        let t = self.threshold;
        let terms = (t + 12.0 * t.sqrt() + 40.0).ceil() as u32;
        let mut w = if order == f64::INFINITY {
            libm::exp(-s)
        } else {
            libm::exp(-order * libm::log1p(s / order))
        };
        let ratio = if order == f64::INFINITY { s } else { s / (s + order) };
        // Pmf of Poisson(T) at n, and Q(n, T) = Pfa by construction of the threshold.
        let mut pmf = libm::exp(n * libm::log(t) - t - libm::lgamma(n + 1.0));
        let mut q = self.pfa;
        let (mut detected, mut weight) = (0.0, 0.0);
        let next_weight = |w: f64, m: f64| {
            if order == f64::INFINITY {
                w * ratio / (m + 1.0)
            } else {
                w * ratio * (order + m) / (m + 1.0)
            }
        };
        for m in 0..=terms {
            let m = f64::from(m);
            detected += w * q;
            weight += w;
            q += pmf;
            pmf *= t / (n + m + 1.0);
            w = next_weight(w, m);
        }
        // From here on Q is 1. A large rest is the complement; a small one would drown in its rounding.
        let rest = 1.0 - weight;
        if rest > 1e-3 {
            detected += rest;
        } else {
            let mut m = f64::from(terms) + 1.0;
            while w > 1e-17 * detected {
                detected += w;
                w = next_weight(w, m);
                m += 1.0;
            }
        }
        detected.clamp(self.pfa, 1.0)
    }

    /// Sankaran's approximation for a steady target (1963): within 5e-4 of the exact value at Pfa 1e-6.
    #[must_use]
    pub fn sankaran(&self, snr: f64) -> f64 {
        let k = 2.0 * f64::from(self.n);
        let l = k * snr;
        let x = 2.0 * self.threshold;
        let (kl, k2l) = (k + l, k + 2.0 * l);
        let h = 1.0 - 2.0 * kl * (k + 3.0 * l) / (3.0 * k2l * k2l);
        let p = k2l / (kl * kl);
        let m = (h - 1.0) * (1.0 - 3.0 * h);
        let mean = 1.0 + h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p);
        let deviation = h * (2.0 * p).sqrt() * (1.0 + 0.5 * m * p);
        let z = (libm::pow(x / kl, h) - mean) / deviation;
        0.5 * libm::erfc(z / SQRT_2)
    }

    /// Albersheim's equation (1981) solved for the probability, steady target: within 0.07 of exact.
    #[must_use]
    pub fn albersheim(&self, snr: f64) -> f64 {
        let n = f64::from(self.n);
        let a = libm::log(0.62 / self.pfa);
        let z = (10.0 * libm::log10(snr) + 5.0 * libm::log10(n)) / (6.2 + 4.54 / (n + 0.44).sqrt());
        let b = (libm::pow(10.0, z) - a) / (1.7 + 0.12 * a);
        1.0 / (1.0 + libm::exp(-b))
    }

    /// North's approximation for one pulse and a steady target.
    #[must_use]
    pub fn north(&self, snr: f64) -> f64 {
        0.5 * libm::erfc((-libm::log(self.pfa)).sqrt() - (snr + 0.5).sqrt())
    }

    /// Natural logarithm of the probability of a miss: finite where the probability itself rounds to 1.
    #[must_use]
    pub fn ln_miss(&self, snr: f64, swerling: Swerling) -> f64 {
        let detected = self.probability(snr, swerling);
        if detected < 0.5 {
            return libm::log1p(-detected);
        }
        let n = f64::from(self.n);
        let s = n * snr;
        match swerling.order(self.n) {
            order if order == f64::INFINITY => ln_mixture(
                &|m| m * libm::log(s) - s - libm::lgamma(m + 1.0),
                &|m| ln_gamma_p(n + m, self.threshold),
                s,
            ),
            1.0 if self.n == 1 => libm::log(-libm::expm1(libm::log(self.pfa) / (1.0 + snr))),
            order => {
                let (ln_p, ln_q) = (libm::log(s / (s + order)), -libm::log1p(s / order));
                let weight = |m: f64| {
                    libm::lgamma(order + m) - libm::lgamma(order) - libm::lgamma(m + 1.0)
                        + m * ln_p
                        + order * ln_q
                };
                ln_mixture(&weight, &|m| ln_gamma_p(n + m, self.threshold), s)
            }
        }
    }

    /// Probability of a miss, summed on its own rather than as one minus [`Self::probability`].
    #[must_use]
    pub fn miss(&self, snr: f64, swerling: Swerling) -> f64 {
        libm::exp(self.ln_miss(snr, swerling))
    }

    /// Strength of one detected look at a target of mean ratio `snr` per pulse, as the radar measures it: the sum of the
    /// pulses over the noise, less the noise's own share, per pulse. `share` in (0, 1] is the probability with which a
    /// detected look is stronger.
    ///
    /// `χ̂ = y/n − 1`, `P(Y > y | Y > T) = share`. Case 1: `y = T − (1 + nχ)·ln share`, exact for one pulse and in the
    /// tail (Swerling 1960, the upper tail is exponential); other cases: `Y` as a gamma variate of its mean
    /// `n(1 + χ)` and variance `n + 2nχ + (nχ)²/K`. A steady echo has its mean, but no less than the threshold.
    #[must_use]
    pub fn measured_snr(&self, snr: f64, swerling: Swerling, share: f64) -> f64 {
        let (n, t) = (f64::from(self.n), self.threshold);
        let ln_share = libm::log(share.clamp(1e-300, 1.0));
        let s = n * snr;
        let sum = match swerling {
            _ if !(s > 0.0 && s < f64::INFINITY) => above(n, t, ln_share),
            Swerling::Steady => (n + s).max(t),
            Swerling::One => t - (1.0 + s) * ln_share,
            _ => {
                let (mean, variance) = (n + s, n + 2.0 * s + s * s / swerling.order(self.n));
                let scale = variance / mean;
                scale * above(mean / scale, t / scale, ln_share)
            }
        };
        (sum / n - 1.0).max(t / n - 1.0)
    }

    /// The same for noise alone that has crossed the threshold: the tail of a gamma variate of order n.
    #[must_use]
    pub fn noise_snr(&self, share: f64) -> f64 {
        self.measured_snr(0.0, Swerling::Steady, share)
    }

    /// Where the strengths of plots begin, and by how much noise that has crossed the threshold is above it on average
    /// (`E[Y | Y > T]` of a gamma variate of order n by its quantiles, to a hundredth).
    #[must_use]
    pub fn strengths(&self) -> AmplitudeLaw {
        let threshold = self.threshold / f64::from(self.n) - 1.0;
        let parts = 256;
        let mean = |k: u32| self.noise_snr((f64::from(k) + 0.5) / f64::from(parts)) - threshold;
        let noise = (0..parts).map(mean).sum::<f64>() / f64::from(parts);
        AmplitudeLaw { threshold, noise }
    }

    /// Signal-to-noise ratio per pulse, as a power ratio, at which `probability` reaches `pd`: bisection
    /// on the exact form. `pd` inside (Pfa, 1).
    #[must_use]
    pub fn required_snr(&self, pd: f64, swerling: Swerling) -> f64 {
        // In decibels, over every ratio that f64 detects with.
        let (mut low, mut high) = (-120.0, 200.0);
        for _ in 0..70 {
            let middle = 0.5 * (low + high);
            if self.probability(from_db(middle), swerling) < pd {
                low = middle;
            } else {
                high = middle;
            }
        }
        from_db(0.5 * (low + high))
    }
}

/// The probability of detection of one detector and one fluctuation, in a table over decibels.
#[derive(Clone, Debug, PartialEq)]
pub struct PdTable {
    pd: Vec<f64>,
    /// Largest slope from here up, per dB.
    steepest: Vec<f64>,
    window_db: (f64, f64),
}

/// First entry, dB.
const TABLE_FROM_DB: f64 = -30.0;
/// Entries per dB.
const TABLE_PER_DB: f64 = 20.0;
/// Entries: up to 70 dB.
const TABLE_LEN: usize = 2001;

impl PdTable {
    /// Largest difference to the exact probability (see the test of this name).
    pub const ERROR: f64 = 2e-4;

    /// Tabulates the exact form: 2001 evaluations, about 1 ms.
    #[must_use]
    pub fn new(detector: &Detector, swerling: Swerling) -> Self {
        let db = |i: usize| TABLE_FROM_DB + i as f64 / TABLE_PER_DB;
        let pd: Vec<f64> =
            (0..TABLE_LEN).map(|i| detector.probability(from_db(db(i)), swerling)).collect();
        let mut steepest = vec![0.0; TABLE_LEN];
        for i in (0..TABLE_LEN - 1).rev() {
            let slope = 1.02 * (pd[i + 1] - pd[i]).abs() * TABLE_PER_DB;
            steepest[i] = f64::max(steepest[i + 1], slope);
        }
        let from = pd.partition_point(|p| *p < pd[0] + 1e-7).saturating_sub(1);
        let to = pd.partition_point(|p| *p < 1.0 - 1e-7).min(TABLE_LEN - 1);
        let window_db = (db(from), db(to));
        Self { pd, steepest, window_db }
    }

    /// Ratios between which the probability is more than 1e-7 from both its ends, dB.
    #[must_use]
    pub fn window_db(&self) -> (f64, f64) {
        self.window_db
    }

    /// Probability at a ratio.
    #[must_use]
    pub fn at(&self, ratio: f64) -> f64 {
        self.at_db(to_db(ratio))
    }

    /// Probability at a ratio in dB; its ends beyond the table.
    #[must_use]
    pub fn at_db(&self, db: f64) -> f64 {
        let place = ((db - TABLE_FROM_DB) * TABLE_PER_DB).clamp(0.0, (TABLE_LEN - 1) as f64);
        let index = (place as usize).min(TABLE_LEN - 2);
        let share = place - index as f64;
        self.pd[index] + share * (self.pd[index + 1] - self.pd[index])
    }

    /// Probability at a ratio in dB, and an upper bound of its slope per dB there and above.
    #[must_use]
    pub fn from_db_up(&self, db: f64) -> (f64, f64) {
        let place = ((db - TABLE_FROM_DB) * TABLE_PER_DB).clamp(0.0, (TABLE_LEN - 1) as f64);
        let index = (place as usize).min(TABLE_LEN - 2);
        let share = place - index as f64;
        let pd = self.pd[index] + share * (self.pd[index + 1] - self.pd[index]);
        // One entry before: the slope changes within an entry.
        (pd, self.steepest[index.saturating_sub(1)])
    }
}

/// Power ratio of decibels.
#[must_use]
pub fn from_db(db: f64) -> f64 {
    libm::exp(ln_ratio(db))
}

/// Natural logarithm of a power ratio given in decibels: stays finite where the ratio itself underflows.
#[must_use]
pub fn ln_ratio(db: f64) -> f64 {
    db * (LN_10 / 10.0)
}

/// Decibels of a power ratio for display, with a floor at −300 dB (zero has no logarithm).
#[must_use]
pub fn to_db(ratio: f64) -> f64 {
    if ratio > 1e-30 { 10.0 * libm::log10(ratio) } else { -300.0 }
}

/// Albersheim's equation: required ratio in dB per pulse for a steady target; for `pd` 0.1 to 0.9 and
/// `pfa` 1e-7 to 1e-3, `None` where its logarithm has no value.
#[must_use]
pub fn albersheim_db(pd: f64, pfa: f64, n: f64) -> Option<f64> {
    let a = libm::log(0.62 / pfa);
    let b = libm::log(pd / (1.0 - pd));
    let inner = a + 0.12 * a * b + 1.7 * b;
    (inner > 0.0)
        .then(|| -5.0 * libm::log10(n) + (6.2 + 4.54 / (n + 0.44).sqrt()) * libm::log10(inner))
}

/// Shnidman's equation (2002): required ratio in dB per pulse for every Swerling case.
#[must_use]
pub fn shnidman_db(pd: f64, pfa: f64, n: u32, swerling: Swerling) -> f64 {
    let k = swerling.order(n);
    let pulses = f64::from(n);
    let alpha = if n < 40 { 0.0 } else { 0.25 };
    let sign = if pd < 0.5 { -1.0 } else { 1.0 };
    let eta = (-0.8 * libm::log(4.0 * pfa * (1.0 - pfa))).sqrt()
        + sign * (-0.8 * libm::log(4.0 * pd * (1.0 - pd))).sqrt();
    let x = eta * (eta + 2.0 * (0.5 * pulses + alpha - 0.25).sqrt());
    let c1 = (((17.7006 * pd - 18.4496) * pd + 14.5339) * pd - 3.525) / k;
    let c2 = (libm::exp(27.31 * pd - 25.14)
        + (pd - 0.8) * (0.7 * libm::log(1e-5 / pfa) + (2.0 * pulses - 20.0) / 80.0))
        / k;
    let c_db = if pd <= 0.872 { c1 } else { c1 + c2 };
    c_db + 10.0 * libm::log10(x / pulses)
}

/// The generalised Marcum Q function and its complement, each with its logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarcumQ {
    /// `Q_N(a, b)`.
    pub q: f64,
    /// `1 − Q_N(a, b)`, summed on its own.
    pub p: f64,
    /// Logarithm of `q`.
    pub ln_q: f64,
    /// Logarithm of `p`; −∞ where `p` is zero.
    pub ln_p: f64,
}

/// `Q_N(a, b)`, `N ≥ 1`, `a, b ≥ 0`: sums of positive terms around their largest, in logarithms, so
/// neither the smaller of the two nor its logarithm ever underflows.
#[must_use]
pub fn marcum_q(order: u32, a: f64, b: f64) -> MarcumQ {
    let n = f64::from(order);
    let (s, t) = (0.5 * a * a, 0.5 * b * b);
    let weight = |m: f64| {
        if s == 0.0 {
            return if m == 0.0 { 0.0 } else { f64::NEG_INFINITY };
        }
        m * libm::log(s) - s - libm::lgamma(m + 1.0)
    };
    let ln_q = ln_mixture(&weight, &|m| ln_gamma_q(n + m, t), s).min(0.0);
    let ln_p = ln_mixture(&weight, &|m| ln_gamma_p(n + m, t), s).min(0.0);
    // The larger of the two from the smaller, which has all its digits.
    let (ln_q, ln_p) = if ln_q > ln_p {
        (libm::log1p(-libm::exp(ln_p)), ln_p)
    } else {
        (ln_q, libm::log1p(-libm::exp(ln_q)))
    };
    MarcumQ { q: libm::exp(ln_q), p: libm::exp(ln_p), ln_q, ln_p }
}

/// `ln Σ exp(weight(m) + tail(m))`, m = 0, 1, …: a unimodal sum, from its largest term outwards.
fn ln_mixture(weight: &dyn Fn(f64) -> f64, tail: &dyn Fn(f64) -> f64, mean: f64) -> f64 {
    let term = |m: f64| weight(m) + tail(m);
    // Largest term: golden-section-like bisection on the sign of the difference.
    let (mut low, mut high) = (0.0, (2.0 * mean + 100.0).ceil());
    while high - low > 1.0 {
        let middle = (0.5 * (low + high)).floor();
        if term(middle + 1.0) > term(middle) {
            low = middle + 1.0;
        } else {
            high = middle;
        }
    }
    let peak_at = if term(high) > term(low) { high } else { low };
    let peak = term(peak_at);
    if peak == f64::NEG_INFINITY {
        return peak;
    }
    let mut sum = 1.0;
    let mut m = peak_at;
    loop {
        m += 1.0;
        let t = libm::exp(term(m) - peak);
        sum += t;
        if t < 1e-18 * sum {
            break;
        }
    }
    m = peak_at;
    while m > 0.0 {
        m -= 1.0;
        let t = libm::exp(term(m) - peak);
        sum += t;
        if t < 1e-18 * sum {
            break;
        }
    }
    peak + libm::log(sum)
}
