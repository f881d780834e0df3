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
