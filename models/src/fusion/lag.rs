//! The publication before, revised by the plots that came since: where each track was one scan ago.
//!
//! A copy of the position is taken at the publication and carried through each update since ([`crate::filter::fixed_lag`]), in
//! the order of the plots' times. Restart, manoeuvre: the copy stays and knows nothing of the state any more. Of modes and
//! histories their mixed moments are used. The updates since are read from the ring, so a late plot that went to its place
//! there is counted in its place here.

use super::filter::{Gaps, TrackFilter, predict};
use crate::filter::fixed_lag::FixedLag;
use crate::filter::{Measurement, UpdateError};
use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// See the module's text.
#[derive(Clone, Debug)]
pub(super) struct Lag {
    copy: FixedLag<2>,
    time: SimTime,
}

/// One scan of plots never leaves less than this share of a covariance's determinant: a plot takes off a tenth to nine tenths
/// of a variance, and what is less is moments of modes that contradict each other.
const LEAST_LEFT: f64 = 1e-3;

/// East and north in the order of the state.
const MEASURED: [usize; 2] = [0, 3];

impl Lag {
    /// A copy of the position of `filter` at `time`.
    ///
    /// # Errors
    /// If `time` is before the filter's.
    pub(super) fn of(filter: &TrackFilter, time: SimTime, gaps: Gaps) -> Result<Self, UpdateError> {
        let state = predict(filter, time, gaps)?.state;
        Ok(Self { copy: FixedLag::of(&state, MEASURED), time })
    }

    /// Position (m) and its covariance (m²).
    pub(super) fn copy(&self) -> (Point2<f64>, Matrix2<f64>) {
        (Point2::from(self.copy.value), self.copy.covariance)
    }

    /// What `plots` (of one time, each with its probability) that updated `before` say of the past.
    ///
    /// # Errors
    /// If they are before the filter or unsound, or a covariance is.
    pub(super) fn update(
        &mut self,
        before: &TrackFilter,
        plots: &[(Plot, f64)],
        gaps: Gaps,
    ) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let state = predict(before, first.time, gaps)?.state;
        let gap_s = first.time.since_s(before.time());
        self.copy.predict(first.time.since_s(self.time), gap_s <= gaps.after_s);
        self.time = first.time;
        for k in 0..plots.len() {
            // Plots of one covariance, as nearly all are, are taken together.
            let alike = |p: &Plot| {
                let of = &plots[k].0;
                p.along_m2 == of.along_m2 && p.across_m2 == of.across_m2 && p.axis == of.axis
            };
            if plots[..k].iter().any(|(p, _)| alike(p)) {
                continue;
            }
            let own = || plots[k..].iter().filter(|(p, _)| alike(p));
            let Measurement::Position { r, .. } = Measurement::of(&plots[k].0)? else { continue };
            let s = state.position_cov() + r;
            let weight: f64 = own().map(|(_, beta)| beta).sum();
            let nu = |p: &Plot| p.position_m - state.position();
            let mean: Vector2<f64> = own().map(|(p, beta)| nu(p) * *beta).sum();
            let square: Matrix2<f64> =
                own().map(|(p, beta)| nu(p) * nu(p).transpose() * *beta).sum();
            let spread = square - mean * mean.transpose();
            let inverse = s.matrix().try_inverse().ok_or(UpdateError::BadInnovation(s.xx))?;
            let kept = self.copy.clone();
            self.copy.take(&state, inverse, weight, mean, spread);
            // Moments of modes that disagree can take away more than there is.
            let (left, least) = (self.copy.covariance, LEAST_LEFT * kept.covariance.determinant());
            if !(left[(0, 0)] > 0.0 && left.determinant() > least) {
                self.copy = kept;
                self.forget();
            }
        }
        let sound = self.copy.covariance.iter().chain(self.copy.value.iter());
        let sound = sound.copied().all(f64::is_finite);
        sound.then_some(()).ok_or(UpdateError::BadCovariance)
    }

    /// The state began again: it says nothing of the past any more.
    pub(super) fn forget(&mut self) {
        self.copy.forget();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;
    use crate::filter::{Estimator, FilterConfig, Gaussian, Rung, StateEstimator, Sym2};

    fn filter(variance_m2: f64) -> TrackFilter {
        let r = Sym2 { xx: variance_m2, xy: 0.0, yy: variance_m2 };
        let state = Gaussian::at_position(Point2::origin(), r, 2.0, 0.3);
        let first = plot(0.0, Point2::origin(), 1.0);
        let mut rung = Estimator::from_plot(&FilterConfig::new(Rung::Ca6), &first).expect("sound");
        rung.replace(SimTime::ZERO, &state);
        TrackFilter::Plain(rung)
    }

    fn plot(t: f64, position_m: Point2<f64>, variance_m2: f64) -> Plot {
        plot_at(t, position_m.x, position_m.y, variance_m2)
    }

    /// A plot that is its own with a probability says of the past what the mixture of both cases says.
    #[test]
    fn what_a_plot_that_may_be_anothers_says_of_the_past_is_the_mixture_of_both() {
        let gaps = crate::fusion::TrackingConfig::paper().life.gaps(1.0);
        let before = filter(5.0);
        let copied = Lag::of(&before, SimTime::from_s(0.2), gaps).expect("later");
        let seen = plot(1.0, Point2::new(4.0, -2.0), 2.0);
        let after = |beta: f64| {
            let mut lag = copied.clone();
            lag.update(&before, &[(seen, beta)], gaps).expect("sound");
            lag.copy()
        };
        let ((own, own_cov), (other, other_cov)) = (after(1.0), copied.copy());
        assert!((own - other).norm() > 0.5, "{own} {other}");
        for beta in [0.2, 0.5, 0.8] {
            let (found, cov) = after(beta);
            let off = own - other;
            let wanted = other + off * beta;
            let spread = off * off.transpose() * (beta * (1.0 - beta));
            let wanted_cov = own_cov * beta + other_cov * (1.0 - beta) + spread;
            assert!((found - wanted).norm() < 1e-9, "{beta}: {found} {wanted}");
            assert!((cov - wanted_cov).norm() < 1e-9, "{beta}: {cov} {wanted_cov}");
        }
    }

    /// Moments that contradict each other (a state four times as sure as the one that was copied) leave the copy as it was.
    #[test]
    fn what_would_take_away_more_than_there_is_is_not_believed() {
        let gaps = crate::fusion::TrackingConfig::paper().life.gaps(1.0);
        let mut lag = Lag::of(&filter(100.0), SimTime::from_s(0.2), gaps).expect("later");
        let (place, cov) = lag.copy();
        let seen = plot(0.3, Point2::new(3.0, 0.0), 1.0);
        lag.update(&filter(1.0), &[(seen, 1.0)], gaps).expect("sound");
        assert_eq!(lag.copy(), (place, cov));
        // Nor what leaves a thousandth of it, more than a plot of any sensor takes.
        let mut lag = Lag::of(&filter(100.0), SimTime::from_s(0.2), gaps).expect("later");
        lag.update(&filter(99.2), &[(seen, 1.0)], gaps).expect("sound");
        assert_eq!(lag.copy(), (place, cov));
        // Nor does it say anything from then on.
        let next = plot(0.6, Point2::new(9.0, 0.0), 1.0);
        lag.update(&filter(100.0), &[(next, 1.0)], gaps).expect("sound");
        assert_eq!(lag.copy(), (place, cov));
    }
}
