//! Approximate marginals by loopy belief propagation: a screen for large clusters, not a reference.
//!
//! Source: J. Williams, R. Lau, "Approximate evaluation of marginal association probabilities with
//! belief propagation", IEEE Trans. AES 50 (2014).

use super::jpda::log_add;

/// Most sweeps that [`marginals`] makes.
pub const MOST_SWEEPS: usize = 200;

/// Marginals as [`super::jpda::Jpda::marginals`] gives them, approximate; returns the sweeps made.
///
/// `ψ_ij = exp(L_ij − M_i)`; `μ_ij = ψ_ij/(1 + Σ_{k≠j} ψ_ik ν_ik)`, `ν_ij = 1/(1 + Σ_{k≠i} μ_kj)`;
/// `β_ij ∝ ψ_ij ν_ij`. In logarithms, sums without the own term by prefix and suffix ("sum minus own"
/// cancels to NaN at large weights). `O(tracks · plots)` a sweep. Stops when no message moves by more
/// than 1e-10 of itself, or after [`MOST_SWEEPS`].
pub fn marginals(log_miss: &[f64], log_like: &[f64], beta: &mut Vec<f64>) -> usize {
    let tracks = log_miss.len();
    let plots = log_like.len().checked_div(tracks).unwrap_or(0);
    // ψ in logs, bounded so that a track that cannot miss stays finite.
    let psi: Vec<f64> = (0..tracks * plots)
        .map(|k| {
            let difference = log_like[k] - log_miss[k / plots].max(-1e200);
            if difference.is_nan() { f64::NEG_INFINITY } else { difference.min(1e200) }
        })
        .collect();
    let mut nu = vec![0.0f64; tracks * plots];
    let mut mu = vec![f64::NEG_INFINITY; tracks * plots];
    let longest = tracks.max(plots);
    let (mut terms, mut others) = (vec![0.0; longest], vec![0.0; longest]);
    let mut sweeps = 0;
    while sweeps < MOST_SWEEPS {
        sweeps += 1;
        for track in 0..tracks {
            for plot in 0..plots {
                terms[plot] = psi[track * plots + plot] + nu[track * plots + plot];
            }
            one_plus_others(&terms[..plots], &mut others[..plots]);
            for plot in 0..plots {
                mu[track * plots + plot] = psi[track * plots + plot] - others[plot];
            }
        }
        let mut moved = 0.0f64;
        for plot in 0..plots {
            for track in 0..tracks {
                terms[track] = mu[track * plots + plot];
            }
            one_plus_others(&terms[..tracks], &mut others[..tracks]);
            for track in 0..tracks {
                let next = -others[track];
                moved = moved.max((next - nu[track * plots + plot]).abs());
                nu[track * plots + plot] = next;
            }
        }
        if moved <= 1e-10 {
            break;
        }
    }
    beta.clear();
    for track in 0..tracks {
        let row = track * plots..(track + 1) * plots;
        let total = row.clone().fold(0.0, |sum, k| log_add(sum, psi[k] + nu[k]));
        beta.push(libm::exp(-total));
        beta.extend(row.map(|k| libm::exp(psi[k] + nu[k] - total)));
    }
    sweeps
}

/// `ln(1 + Σ_{k≠j} exp terms_k)` for every `j`.
fn one_plus_others(terms: &[f64], out: &mut [f64]) {
    let mut sum = 0.0; // ln 1
    for (slot, &term) in out.iter_mut().zip(terms) {
        *slot = sum;
        sum = log_add(sum, term);
    }
    let mut after = f64::NEG_INFINITY;
    for (slot, &term) in out.iter_mut().zip(terms).rev() {
        *slot = log_add(*slot, after);
        after = log_add(after, term);
    }
}

#[cfg(test)]
mod tests {
    use super::super::jpda::Jpda;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finite_at_any_offset_and_near_the_exact_marginals(
            tracks in 1usize..5, plots in 1usize..5,
            values in proptest::collection::vec(-8.0..4.0f64, 4 + 16),
            offset in -2000.0..2000.0f64,
        ) {
            let miss: Vec<f64> = values[..tracks].iter().map(|v| v + offset).collect();
            let like: Vec<f64> = values[4..4 + tracks * plots].iter().map(|v| v + offset).collect();
            let (mut exact, mut found) = (Vec::new(), Vec::new());
            Jpda::default().marginals(&miss, &like, 100_000, &mut exact).expect("small");
            marginals(&miss, &like, &mut found);
            // Where two tracks can hardly miss, it tends to one assignment of them alone: two that are
            // almost as good are then off by up to one half. The steepest climb found 0.344 where at
            // most one track prefers a plot to its miss by more than 5, and 0.477 up to 12.
            let prefers = |track: usize| {
                let best = like[track * plots..][..plots].iter().copied().fold(f64::MIN, f64::max);
                best - miss[track] > 5.0
            };
            let most = if (0..tracks).filter(|&t| prefers(t)).count() < 2 { 0.35 } else { 0.5 };
            for (f, e) in found.iter().zip(&exact) {
                prop_assert!(f.is_finite() && (f - e).abs() <= most, "{f} for {e}, at most {most}");
            }
            for row in found.chunks(plots + 1) {
                prop_assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{row:?}");
            }
        }
    }

    #[test]
    fn one_track_is_exact_and_hostile_weights_stay_finite() {
        let (mut exact, mut found) = (Vec::new(), Vec::new());
        Jpda::default().marginals(&[-2.0], &[1.0, -3.0], 100, &mut exact).expect("small");
        marginals(&[-2.0], &[1.0, -3.0], &mut found);
        assert!(found.iter().zip(&exact).all(|(f, e)| (f - e).abs() < 1e-12));
        let nan = f64::NAN;
        let inf = f64::INFINITY;
        marginals(&[-inf, 0.0], &[inf, -1e300, nan, 1e300], &mut found);
        assert!(found.iter().all(|b| b.is_finite()), "{found:?}");
        assert_eq!(marginals(&[], &[], &mut found), 1);
    }
}
