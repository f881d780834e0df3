//! Weights from log-likelihoods, whatever their size.

/// ln Σ exp(log_weights), and the weights normalised to sum 1 written over `log_weights`.
///
/// The largest is taken out first and the rest summed around it, so that no offset costs anything:
/// exp(−d²/2) itself is zero beyond d² = 1489. All at −∞ (or NaN, or none at all) gives `None` and
/// leaves the input alone: the caller keeps its prior weights and counts an outlier. One or more at +∞
/// share the whole weight.
pub fn normalise(log_weights: &mut [f64]) -> Option<f64> {
    let (mut best, mut largest) = (0, f64::NEG_INFINITY);
    for (i, w) in log_weights.iter().enumerate() {
        if w.is_nan() {
            return None;
        }
        if *w > largest {
            (best, largest) = (i, *w);
        }
    }
    if largest == f64::NEG_INFINITY {
        return None;
    }
    let mut rest = 0.0;
    for (i, w) in log_weights.iter_mut().enumerate() {
        *w = if *w == largest { 1.0 } else { libm::exp(*w - largest) };
        if i != best {
            rest += *w;
        }
    }
    let scale = 1.0 / (1.0 + rest);
    log_weights.iter_mut().for_each(|w| *w *= scale);
    Some(largest + libm::log1p(rest))
}

/// What a part of a mixture makes of plots of which at most one is its own.
#[derive(Clone, Debug, Default)]
pub struct Explained {
    /// How much better it explains them than the mixture does.
    pub better: f64,
    /// Probability of each plot given this part.
    pub betas: Vec<f64>,
}

/// For each part of a mixture with weights `c`: how it explains plots of these probabilities (for the mixture), by the log
/// likelihood `log(plot, part)`. A plot of probability β for the mixture has β·L_part/L_mixture for the part.
///
/// # Errors
/// The first one of `log`.
pub fn explained<E>(
    c: &[f64],
    betas: &[f64],
    mut log: impl FnMut(usize, usize) -> Result<f64, E>,
) -> Result<Vec<Explained>, E> {
    let missed = (1.0 - betas.iter().sum::<f64>()).max(0.0);
    let one = || Explained { better: 0.0, betas: Vec::with_capacity(betas.len()) };
    let mut parts: Vec<Explained> = c.iter().map(|_| one()).collect();
    let (mut logs, mut joint) = (Vec::with_capacity(c.len()), Vec::with_capacity(c.len()));
    for (plot, beta) in betas.iter().enumerate() {
        logs.clear();
        for part in 0..c.len() {
            logs.push(log(plot, part)?);
        }
        joint.clear();
        joint.extend(logs.iter().zip(c).map(|(l, w)| l + libm::log(*w)));
        let all = normalise(&mut joint);
        for (part, log) in parts.iter_mut().zip(&logs) {
            let ratio = all.map_or(1.0, |all| libm::exp((log - all).min(600.0)));
            part.betas.push(beta * ratio);
        }
    }
    for part in &mut parts {
        part.better = missed + part.betas.iter().sum::<f64>();
        if part.better > 0.0 {
            part.betas.iter_mut().for_each(|beta| *beta /= part.better);
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_offset_costs_nothing(
            mut w in proptest::collection::vec(-700.0..700.0f64, 1..20), offset in -1e5..1e5f64,
        ) {
            let mut shifted: Vec<f64> = w.iter().map(|x| x + offset).collect();
            let (a, b) = (normalise(&mut w).unwrap(), normalise(&mut shifted).unwrap());
            prop_assert!((a + offset - b).abs() < 1e-9);
            prop_assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (x, y) in w.iter().zip(&shifted) {
                prop_assert!((x - y).abs() < 1e-9);
            }
        }
    }

    /// Bayes: a part and a plot (or none) together are as likely as the plot is and the part is given it; each way of adding up
    /// is one.
    #[test]
    fn parts_and_plots_are_one_distribution() {
        let (c, betas) = ([0.5, 0.3, 0.2], [0.4, 0.25, 0.1]);
        let logs = [[-1.0, -4.0, -700.0], [-3.0, -0.5, -2.0], [-9.0, -8.0, -1.0]];
        let parts = explained(&c, &betas, |plot, part| Ok::<f64, ()>(logs[plot][part]));
        let parts = parts.expect("no error");
        let whole: f64 = c.iter().zip(&parts).map(|(c, part)| c * part.better).sum();
        assert!((whole - 1.0).abs() < 1e-12, "{whole}");
        for (plot, beta) in betas.iter().enumerate() {
            let likelihood = |part: usize| c[part] * libm::exp(logs[plot][part]);
            let all: f64 = (0..3).map(likelihood).sum();
            for part in 0..3 {
                let joint = c[part] * parts[part].better * parts[part].betas[plot];
                assert!((joint - beta * likelihood(part) / all).abs() < 1e-12, "{plot} {part}");
            }
        }
        for (c, part) in c.iter().zip(&parts) {
            let missed = c * part.better * (1.0 - part.betas.iter().sum::<f64>());
            assert!((missed - c * 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn nothing_possible_is_said_and_not_divided_by() {
        let minus = f64::NEG_INFINITY;
        for mut w in [vec![], vec![minus], vec![minus, minus], vec![0.0, f64::NAN]] {
            assert_eq!(normalise(&mut w), None);
        }
        let mut w = [minus, -5e5];
        assert_eq!(normalise(&mut w), Some(-5e5));
        assert_eq!(w, [0.0, 1.0]);
    }
}
