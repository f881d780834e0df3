//! Joint probabilistic data association, exact, for one cluster.
//!
//! The weight of a joint event is `Π exp(M_i)` over missed tracks times `Π exp(L_ij)` over pairs, each
//! plot at most once (Fortmann, Bar-Shalom, Scheffe, IEEE J. Oceanic Eng. 8, 1983). The sum over all
//! events is done by dynamic programming over the set of used plots instead of by listing them.

/// Work space; keep it to allocate nothing from call to call.
#[derive(Clone, Debug, Default)]
pub struct Jpda {
    forward: Vec<f64>,
    backward: Vec<f64>,
    weights: Vec<f64>,
}

/// Why a cluster has no exact marginals.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum JpdaError {
    /// `tracks · 2^plots` is beyond the limit.
    #[error("{tracks} tracks and {plots} plots: more than {limit} states")]
    TooLarge {
        /// Tracks in the cluster.
        tracks: usize,
        /// Plots in the cluster.
        plots: usize,
        /// Largest `tracks · 2^plots`.
        limit: usize,
    },
    /// No joint event has a positive, finite weight.
    #[error("no joint event has a finite weight")]
    NoEvent,
}

impl Jpda {
    /// Marginals `β` of one cluster: `tracks` rows of `1 + plots` numbers, column 0 = missed.
    ///
    /// `log_miss[i] = M_i`, `log_like[i · plots + j] = L_ij`; −∞, or anything below about −1e300, lies
    /// outside the gate. Weights are taken relative to each track's best and summed linearly; where
    /// that sum comes near underflow (tracks that all want one plot and can do nothing else), the
    /// recursion is done in logarithms, so an offset of thousands on all weights costs nothing.
    /// `O(tracks · plots · 2^plots)`.
    ///
    /// # Errors
    /// If the cluster is larger than `limit`, or if no event has a finite weight.
    pub fn marginals(
        &mut self,
        log_miss: &[f64],
        log_like: &[f64],
        limit: usize,
        beta: &mut Vec<f64>,
    ) -> Result<(), JpdaError> {
        let tracks = log_miss.len();
        let plots = log_like.len().checked_div(tracks).unwrap_or(0);
        debug_assert_eq!(log_like.len(), tracks * plots);
        let states = 1usize.checked_shl(plots as u32).and_then(|s| s.checked_mul(tracks));
        if plots >= usize::BITS as usize || states.is_none_or(|s| s > limit) {
            return Err(JpdaError::TooLarge { tracks, plots, limit });
        }
        let width = plots + 1;
        self.weights.clear();
        for (track, &miss) in log_miss.iter().enumerate() {
            let row = &log_like[track * plots..(track + 1) * plots];
            let best = row.iter().fold(miss, |a, &b| if b > a { b } else { a });
            if !best.is_finite() || miss.is_nan() || row.iter().any(|l| l.is_nan()) {
                return Err(JpdaError::NoEvent);
            }
            self.weights.push(miss - best);
            self.weights.extend(row.iter().map(|l| l - best));
        }
        let logs = self.weights.len();
        self.weights.extend_from_within(..);
        // The best of each track has weight 1.
        let weight = |log: f64| if log == 0.0 { 1.0 } else { libm::exp(log) };
        self.weights[..logs].iter_mut().for_each(|w| *w = weight(*w));
        beta.clear();
        beta.resize(tracks * width, 0.0);
        let (linear, logs) = self.weights.split_at(logs);
        let total = if tracks == 2 {
            two_tracks(linear, width, beta)
        } else {
            recurse::<Linear>(&mut self.forward, &mut self.backward, linear, width, beta)
        };
        if !(total > SMALLEST_LINEAR_TOTAL) {
            let total = recurse::<Log>(&mut self.forward, &mut self.backward, logs, width, beta);
            if !total.is_finite() {
                return Err(JpdaError::NoEvent);
            }
        }
        Ok(())
    }
}

/// Below this sum of the weights (each track's best is 1) the linear form may have lost terms that
/// matter: what underflows is smaller than 1e-307, and must stay below 1e-13 of the sum.
const SMALLEST_LINEAR_TOTAL: f64 = 1e-250;

/// How weights are added and multiplied: as they are, or as logarithms.
trait Field {
    const ZERO: f64;
    const ONE: f64;
    fn times(a: f64, b: f64) -> f64;
    fn plus(a: f64, b: f64) -> f64;
    /// `value / total` as a number.
    fn share(value: f64, total: f64) -> f64;
}

struct Linear;

impl Field for Linear {
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    fn times(a: f64, b: f64) -> f64 {
        a * b
    }
    fn plus(a: f64, b: f64) -> f64 {
        a + b
    }
    fn share(value: f64, total: f64) -> f64 {
        value / total
    }
}

struct Log;

impl Field for Log {
    const ZERO: f64 = f64::NEG_INFINITY;
    const ONE: f64 = 0.0;
    fn times(a: f64, b: f64) -> f64 {
        a + b
    }
    fn plus(a: f64, b: f64) -> f64 {
        log_add(a, b)
    }
    fn share(value: f64, total: f64) -> f64 {
        libm::exp(value - total)
    }
}

/// `ln(eᵃ + eᵇ)` without overflow; −∞ is the neutral element.
#[must_use]
pub fn log_add(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + libm::log1p(libm::exp(low - high)) }
}

/// The same for two tracks `a` and `b`, in closed form: `β_aj = a_j (Σ_{k≠j} b_k) / total`, a miss excluding
/// nothing. The sums without one term are added up from both ends: a subtraction would cancel.
fn two_tracks(weights: &[f64], width: usize, beta: &mut [f64]) -> f64 {
    let (a, b) = weights.split_at(width);
    let (for_a, for_b) = beta.split_at_mut(width);
    without_own(b, for_a);
    without_own(a, for_b);
    let total: f64 = a.iter().zip(&*for_a).map(|(a, b)| a * b).sum();
    for (own, others) in [(a, for_a), (b, for_b)] {
        for (own, others) in own.iter().zip(others) {
            *others = own * *others / total;
        }
    }
    total
}

/// The sum of all, then for each further term the sum of all but that one.
fn without_own(terms: &[f64], sums: &mut [f64]) {
    let mut head = terms[0];
    for (term, sum) in terms.iter().zip(&mut *sums).skip(1) {
        *sum = head;
        head += term;
    }
    sums[0] = head;
    let mut tail = 0.0;
    for (term, sum) in terms.iter().zip(sums).skip(1).rev() {
        *sum += tail;
        tail += term;
    }
}

/// Forward sums `F_i(s)` over the first `i` tracks with plots `s` used, backward sums `B_i(s)` over
/// the rest with `s` taken, and `β_i0 = Σ_s F_i(s) M_i B_{i+1}(s)`, `β_ij = Σ_{s∌j} F_i(s) L_ij
/// B_{i+1}(s ∪ j)`, all over `B_0(∅)`, which is returned. Only reachable sets do any work.
fn recurse<A: Field>(
    forward: &mut Vec<f64>,
    backward: &mut Vec<f64>,
    weights: &[f64],
    width: usize,
    beta: &mut [f64],
) -> f64 {
    let tracks = weights.len() / width;
    let sets = 1usize << (width - 1);
    forward.clear();
    forward.resize((tracks + 1) * sets, A::ZERO);
    backward.clear();
    backward.resize(2 * sets, A::ONE);
    forward[0] = A::ONE;
    for track in 0..tracks {
        let (now, next) = forward[track * sets..].split_at_mut(sets);
        let row = &weights[track * width..(track + 1) * width];
        for set in 0..sets {
            let so_far = now[set];
            if so_far == A::ZERO {
                continue;
            }
            next[set] = A::plus(next[set], A::times(so_far, row[0]));
            for (plot, &weight) in row[1..].iter().enumerate() {
                let bit = 1 << plot;
                if set & bit == 0 && weight != A::ZERO {
                    next[set | bit] = A::plus(next[set | bit], A::times(so_far, weight));
                }
            }
        }
    }
    let total = (0..sets).fold(A::ZERO, |sum, set| A::plus(sum, forward[tracks * sets + set]));
    for track in (0..tracks).rev() {
        let now = &forward[track * sets..(track + 1) * sets];
        let row = &weights[track * width..(track + 1) * width];
        let (rest, mine) = backward.split_at_mut(sets);
        let mut sums = [A::ZERO; usize::BITS as usize + 1];
        for set in 0..sets {
            if now[set] == A::ZERO {
                continue;
            }
            let missed = A::times(row[0], rest[set]);
            sums[0] = A::plus(sums[0], A::times(now[set], missed));
            let mut onward = missed;
            for (plot, &weight) in row[1..].iter().enumerate() {
                let bit = 1 << plot;
                if set & bit == 0 && weight != A::ZERO {
                    let taken = A::times(weight, rest[set | bit]);
                    onward = A::plus(onward, taken);
                    sums[plot + 1] = A::plus(sums[plot + 1], A::times(now[set], taken));
                }
            }
            mine[set] = onward;
        }
        for (column, &sum) in sums[..width].iter().enumerate() {
            beta[track * width + column] = A::share(sum, total);
        }
        rest.copy_from_slice(mine);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All joint events one by one.
    fn brute(log_miss: &[f64], log_like: &[f64]) -> Vec<f64> {
        fn go(
            track: usize,
            used: u32,
            weight: f64,
            m: &[f64],
            l: &[f64],
            path: &mut Vec<usize>,
            beta: &mut [f64],
        ) {
            let plots = l.len() / m.len();
            if track == m.len() {
                for (t, &c) in path.iter().enumerate() {
                    beta[t * (plots + 1) + c] += libm::exp(weight);
                }
                return;
            }
            path.push(0);
            go(track + 1, used, weight + m[track], m, l, path, beta);
            path.pop();
            for p in 0..plots {
                if used & (1 << p) == 0 {
                    path.push(p + 1);
                    let next = weight + l[track * plots + p];
                    go(track + 1, used | (1 << p), next, m, l, path, beta);
                    path.pop();
                }
            }
        }
        let width = log_like.len() / log_miss.len() + 1;
        let mut beta = vec![0.0; log_miss.len() * width];
        go(0, 0, 0.0, log_miss, log_like, &mut Vec::new(), &mut beta);
        for row in beta.chunks_mut(width) {
            let sum: f64 = row.iter().sum();
            row.iter_mut().for_each(|b| *b /= sum);
        }
        beta
    }

    proptest! {
        #[test]
        fn it_is_the_sum_over_all_events_at_any_offset(
            tracks in 1usize..5, plots in 0usize..5,
            values in proptest::collection::vec(-12.0..6.0f64, 4 + 16),
            offset in -2000.0..2000.0f64,
        ) {
            let miss: Vec<f64> = values[..tracks].to_vec();
            let like: Vec<f64> = values[4..4 + tracks * plots].to_vec();
            let expected = brute(&miss, &like);
            let (mut found, mut jpda) = (Vec::new(), Jpda::default());
            let shift = |v: &[f64]| v.iter().map(|x| x + offset).collect::<Vec<_>>();
            jpda.marginals(&shift(&miss), &shift(&like), 100_000, &mut found).expect("small");
            for (f, e) in found.iter().zip(&expected) {
                prop_assert!((f - e).abs() < 1e-11, "{f} for {e}");
            }
            // Both forms agree.
            let weights = jpda.weights[jpda.weights.len() / 2..].to_vec();
            let mut logs = found.clone();
            recurse::<Log>(&mut Vec::new(), &mut Vec::new(), &weights, plots + 1, &mut logs);
            for (f, e) in logs.iter().zip(&expected) {
                prop_assert!((f - e).abs() < 1e-11, "{f} for {e}");
            }
        }
    }

    #[test]
    fn hard_cases() {
        let gone = -1e300;
        let none = f64::NEG_INFINITY;
        for (name, miss, like, row0) in [
            // Two tracks that cannot miss want one plot each: only one event is left.
            ("no way to miss", vec![none; 2], vec![-3.0, gone, -700.0, -900.0], vec![0., 1., 0.]),
            // Conflict: both are 2000 nats better on plot 0; the linear form underflows.
            ("underflow", vec![-2000.0; 2], vec![0.0, gone, 0.0, gone], vec![0.5, 0.5, 0.0]),
            ("all outside", vec![-1.0; 2], vec![gone; 4], vec![1.0, 0.0, 0.0]),
        ] {
            let mut beta = Vec::new();
            Jpda::default().marginals(&miss, &like, 100_000, &mut beta).expect(name);
            for (f, e) in beta.iter().zip(&row0) {
                assert!((f - e).abs() < 1e-12, "{name}: {beta:?}");
            }
        }
        let mut beta = Vec::new();
        let mut jpda = Jpda::default();
        // Ten tracks in one cell, ten plots: within the limit, and equal by symmetry.
        jpda.marginals(&[-2.0; 10], &[-5.0; 100], 100_000, &mut beta).expect("10 · 2^10");
        assert!(beta.chunks(11).all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-12));
        assert!(
            beta.chunks(11).all(|row| row.iter().zip(&beta).all(|(a, b)| (a - b).abs() < 1e-12))
        );
        for (name, miss, like) in [
            ("too large", vec![-1.0; 40], vec![0.0; 1600]),
            ("NaN", vec![f64::NAN], vec![0.0]),
            ("impossible", vec![none], vec![none]),
            ("two for one, no miss", vec![none; 2], vec![0.0; 2]),
        ] {
            assert!(jpda.marginals(&miss, &like, 100_000, &mut beta).is_err(), "{name}");
        }
        // Wherever one number is not a number.
        for tracks in 1..4 {
            for at in 0..tracks * 4 {
                let mut numbers = vec![-1.0; tracks * 4];
                numbers[at] = f64::NAN;
                let (miss, like) = numbers.split_at(tracks);
                let found = jpda.marginals(miss, like, 100_000, &mut beta);
                assert!(found.is_err(), "{at} of {tracks}: {beta:?}");
            }
        }
        jpda.marginals(&[], &[], 1, &mut beta).expect("nothing is fine");
    }
}
