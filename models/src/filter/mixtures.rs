//! What mixtures of Gaussians have in common, be their parts modes or histories: their moments, and what they make of plots of which
//! at most one is their own.
//!
//! A plot of probability β for the mixture has β·L_part/L_mixture for the part, and each part weighs as much more as it explains
//! them better ([`super::weights::explained`]).

use super::gaussian::{Gaussian, Measurement, Nis, Sym2, nis_at};
use super::{UpdateError, weights};
use crate::frames::{Point2, Vector2};

/// Mean and covariance of the positions of a mixture, gathered about one of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct PositionMoments {
    origin: Point2<f64>,
    weight: f64,
    mean: [f64; 2],
    square: [f64; 3],
}

impl PositionMoments {
    /// None yet.
    #[must_use]
    pub fn about(origin: Point2<f64>) -> Self {
        Self { origin, ..Self::default() }
    }

    #[inline]
    /// Takes a part: its weight, position (m) and covariance of that (m²).
    pub fn add(&mut self, w: f64, at: Point2<f64>, p: Sym2) {
        let offset = at - self.origin;
        let (wx, wy) = (w * offset.x, w * offset.y);
        self.weight += w;
        self.mean = [self.mean[0] + wx, self.mean[1] + wy];
        self.square = [
            self.square[0] + w * p.xx + wx * offset.x,
            self.square[1] + w * p.xy + wx * offset.y,
            self.square[2] + w * p.yy + wy * offset.y,
        ];
    }

    /// Mean and covariance.
    #[must_use]
    pub fn moments(&self) -> (Point2<f64>, Sym2) {
        let k = 1.0 / self.weight;
        let [x, y] = self.mean.map(|v| v * k);
        let [xx, xy, yy] = self.square.map(|v| v * k);
        (self.origin + Vector2::new(x, y), Sym2 { xx: xx - x * x, xy: xy - x * y, yy: yy - y * y })
    }

    /// The normalised innovation of a plot against the whole.
    ///
    /// # Errors
    /// If the innovation covariance is not positive definite.
    pub fn nis(&self, m: &Measurement) -> Result<Nis, UpdateError> {
        let (at, cov) = self.moments();
        nis_at(at, cov, m)
    }
}

/// ln of how much better a part explains the plots than the mixture, and the plots with their probabilities.
pub type Share = (f64, Vec<(Measurement, f64)>);

/// For each part of a mixture (weight and state): ln of how much better it explains the plots than the mixture does, and the
/// plots with their association probabilities given this part.
///
/// # Errors
/// If an innovation covariance is not positive definite.
pub fn association_shares(
    c: &[f64],
    states: &[Gaussian],
    plots: &[(Measurement, f64)],
) -> Result<Vec<Share>, UpdateError> {
    let betas: Vec<f64> = plots.iter().map(|plot| plot.1).collect();
    let parts = weights::explained(c, &betas, |plot, part| {
        let i = states[part].innovation(&plots[plot].0)?;
        Ok(-0.5 * (i.d2 + i.ln_det))
    })?;
    let own = |part: weights::Explained| {
        let plots = plots.iter().zip(part.betas).map(|((m, _), beta)| (*m, beta));
        (libm::log(part.better), plots.collect())
    };
    Ok(parts.into_iter().map(own).collect())
}

/// A part after plots: its place in the mixture before, its state, and ln of its weight relative to the best one's.
pub type Kept = (usize, Gaussian, f64);

/// The `most` likeliest parts of a mixture after plots of which at most one is its own, the likeliest first.
///
/// # Errors
/// If no part has a weight, or an innovation covariance is not positive definite.
pub fn likeliest_after(
    c: &[f64],
    states: &[Gaussian],
    plots: &[(Measurement, f64)],
    most: usize,
) -> Result<Vec<Kept>, UpdateError> {
    let shares = association_shares(c, states, plots)?;
    let scores: Vec<f64> =
        c.iter().zip(&shares).map(|(c, share)| libm::log(*c) + share.0).collect();
    let order = ranked(&scores, most);
    let best = order.first().map_or(f64::NEG_INFINITY, |k| scores[*k]);
    if !best.is_finite() {
        return Err(UpdateError::BadInnovation(best));
    }
    let after = |k: usize| {
        let mut state = states[k];
        state.update_weighted(&shares[k].1)?;
        Ok((k, state, scores[k] - best))
    };
    order.into_iter().map(after).collect()
}

/// Places of the `most` largest weights (logs), the largest first; equal ones in their order.
#[must_use]
pub fn ranked(weights: &[f64], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
    order.truncate(most);
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;
    use crate::filter::{Estimator, FilterConfig, Rung, StateEstimator};
    use crate::plot::Plot;
    use crate::time::SimTime;

    /// Nothing is pruned yet: mean and covariance after several plots are those of the mixture of what each alone leads to and none.
    #[test]
    fn several_plots_are_the_mixture_of_each_alone_and_of_none_on_every_rung_of_modes() {
        for rung in [Rung::Ca6, Rung::Imm3, Rung::Mh27, Rung::Events27] {
            let config = FilterConfig::new(rung);
            let first = plot_at(0.0, 0.0, 0.0, 4.0);
            let filter = Estimator::from_plot(&config, &first).expect("sound");
            let plots: Vec<(Plot, f64)> = [(9.0, 1.0, 0.35), (4.0, -6.0, 0.3), (16.0, 5.0, 0.15)]
                .map(|(x, y, beta)| (plot_at(1.0, x, y, 3.0), beta))
                .to_vec();
            let mut weighted = filter.clone();
            let refs: Vec<(&Plot, f64)> = plots.iter().map(|(plot, beta)| (plot, *beta)).collect();
            weighted.update_weighted(&refs).expect("sound");
            let mut states = vec![filter.predicted(SimTime::from_s(1.0)).expect("later").state];
            let mut weights = vec![1.0 - plots.iter().map(|(_, beta)| beta).sum::<f64>()];
            for (plot, beta) in &plots {
                let mut alone = filter.clone();
                alone.update(plot).expect("sound");
                states.push(alone.estimate().state);
                weights.push(*beta);
            }
            let wanted = Gaussian::mixture(&weights, &states);
            let found = weighted.estimate().state;
            let off = (found.position() - wanted.position()).norm();
            assert!(off < 1e-5, "{rung:?}: {off}");
            let (p, q) = (found.covariance(), wanted.covariance());
            assert!((p - q).norm() < 1e-5 * q.norm(), "{rung:?}: {p} {q}");
        }
    }
}
