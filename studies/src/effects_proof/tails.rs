//! Tails of counts.

/// Probability of `k` or more of `n`, each with probability `p`.
#[must_use]
pub fn binomial_tail(n: u64, p: f64, k: u64) -> f64 {
    if k == 0 {
        return 1.0;
    }
    if k > n || p <= 0.0 {
        return 0.0;
    }
    if p >= 1.0 {
        return 1.0;
    }
    let (nf, kf) = (n as f64, k as f64);
    if kf < nf * p {
        // Below the mean the first terms may be less than the smallest number there is: from the other end.
        return 1.0 - binomial_tail(n, 1.0 - p, n - k + 1);
    }
    let ln_choose = libm::lgamma(nf + 1.0) - libm::lgamma(kf + 1.0) - libm::lgamma(nf - kf + 1.0);
    let mut term = libm::exp(ln_choose + kf * libm::log(p) + (nf - kf) * libm::log1p(-p));
    let mut sum = 0.0;
    for i in k..=n {
        sum += term;
        let i = i as f64;
        term *= (nf - i) / (i + 1.0) * p / (1.0 - p);
        if term < 1e-18 * sum && i > nf * p {
            break;
        }
    }
    sum.min(1.0)
}

/// Probability of `k` or more where `mean` are expected.
#[must_use]
pub fn poisson_tail(mean: f64, k: u64) -> f64 {
    if k == 0 {
        return 1.0;
    }
    if mean <= 0.0 {
        return 0.0;
    }
    let kf = k as f64;
    if kf < mean {
        let mut term = libm::exp((kf - 1.0) * libm::log(mean) - mean - libm::lgamma(kf));
        let mut below = 0.0;
        for i in (1..=k).rev() {
            below += term;
            term *= (i - 1) as f64 / mean;
        }
        return 1.0 - below.min(1.0);
    }
    let mut term = libm::exp(kf * libm::log(mean) - mean - libm::lgamma(kf + 1.0));
    let mut sum = 0.0;
    let mut i = kf;
    loop {
        sum += term;
        i += 1.0;
        term *= mean / i;
        // Where the first term is nothing, so are all.
        if term <= 1e-18 * sum && i > mean {
            return sum.min(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_counts_are_those_of_sums() {
        // By hand: 1 − 0.9^10, and 10 choose 9 and 10.
        assert!((binomial_tail(10, 0.1, 1) - (1.0 - 0.9f64.powi(10))).abs() < 1e-12);
        assert!((binomial_tail(10, 0.5, 9) - 11.0 / 1024.0).abs() < 1e-12);
        assert!((poisson_tail(2.0, 1) - (1.0 - libm::exp(-2.0))).abs() < 1e-12);
        assert_eq!((binomial_tail(5, 0.3, 0), binomial_tail(5, 0.3, 6)), (1.0, 0.0));
        // Below the mean, where the first terms are less than the smallest number there is, and where they are not.
        assert_eq!((binomial_tail(40_000, 0.1, 16), poisson_tail(2000.0, 3)), (1.0, 1.0));
        assert!((binomial_tail(10, 0.5, 2) - 1013.0 / 1024.0).abs() < 1e-12);
        assert!((poisson_tail(2.0, 2) + 3.0 * libm::exp(-2.0) - 1.0).abs() < 1e-12);
        assert!((poisson_tail(3.0, 2) + 4.0 * libm::exp(-3.0) - 1.0).abs() < 1e-12);
        // Far beyond it.
        assert_eq!((poisson_tail(0.5, 2000), binomial_tail(4000, 0.001, 3000)), (0.0, 0.0));
    }
}
