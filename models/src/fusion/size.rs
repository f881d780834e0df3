//! Of what size a target is, as its echoes show it: one law for labels, for the near side of echoes and for how its plots
//! are weighed.
//!
//! The centre of an echo wanders over the body from look to look. Of three plots of equal distance `|z₁ − 2z₂ + z₃|²/6` is the
//! variance of one of them, whatever the velocity; an acceleration a adds (aT²)²/6, 0.7 m² at 2 m/s². Along and across the
//! line of sight are held apart. A plot of a radar states one glint for every target; a car's is a fifth of it, a heavy jet's
//! one and a half times. The variance that a body shows is [`plot_variance_m2`]; ln of what was seen in n triples is
//! N(ln v, 4/n + 0.35²) about it.

use crate::frames::Point2;
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// A body as the radar's law sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// A ground vehicle; else an aircraft.
    pub vehicle: bool,
    /// Length over all, m.
    pub length_m: f64,
    /// Span, or width of a vehicle, m.
    pub span_m: f64,
}

/// Spread of ln variance within a class.
const WITHIN_CLASS: f64 = 0.35;
/// Fewer triples say nothing of the type.
pub(super) const FEWEST_TRIPLES: f64 = 8.0;

/// Variance of one plot of a target of this size per axis, m²: noise and cells, and the wander of the echo's centre over the
/// body. Fitted to radar plots of eleven types from a car (0.15 m²) and a fuel truck (0.8) over C550 (0.7) and A320 (7.0) to
/// B788 (16) and A333 (20): right within a factor of two.
pub(super) fn plot_variance_m2(length_m: f64, span_m: f64) -> f64 {
    0.12 + 0.0026 * (length_m * length_m + span_m * span_m)
}

/// Diagonal of a body that shows such a variance, m: the law the other way round.
pub(super) fn diagonal_m(variance_m2: f64) -> f64 {
    ((variance_m2 - 0.12).max(0.0) / 0.0026).sqrt()
}

/// Mean square of how far towards the radar the echo of an aircraft lies that shows such a variance, m²: (2/π)(0.095 ½L + 0.11 ½S)
/// of [`super::near_side`] with L = S by [`diagonal_m`]; of a target that has shown none yet (1.9 m)².
pub(super) fn near_side_m2(variance_m2: Option<f64>) -> f64 {
    variance_m2.map_or(3.6, |v| 0.82 * (v - 0.12).max(0.0))
}

/// ln of how likely it is that a body of this size shows such a variance in so many triples, but for a constant.
pub(super) fn ln_density(seen_m2: f64, triples: f64, length_m: f64, span_m: f64) -> f64 {
    let sigma2 = 4.0 / triples.max(0.1) + WITHIN_CLASS * WITHIN_CLASS;
    let off = libm::log(seen_m2.max(1e-3)) - libm::log(plot_variance_m2(length_m, span_m));
    -0.5 * off * off / sigma2
}

/// Kinds of targets of which nothing is known, and how many of a hundred are of each: car, truck, light, regional, medium,
/// heavy (assumed).
pub(super) static CLASSES: [(Body, f64); 6] = [
    (Body { vehicle: true, length_m: 4.6, span_m: 1.9 }, 0.32),
    (Body { vehicle: true, length_m: 12.0, span_m: 3.0 }, 0.22),
    (Body { vehicle: false, length_m: 8.3, span_m: 11.0 }, 0.12),
    (Body { vehicle: false, length_m: 30.0, span_m: 20.0 }, 0.08),
    (Body { vehicle: false, length_m: 38.0, span_m: 36.0 }, 0.20),
    (Body { vehicle: false, length_m: 60.0, span_m: 60.0 }, 0.06),
];

/// Plots that what is stated counts for.
const PRIOR: f64 = 12.0;
/// Share that is kept of what was seen, per triple: the aspect changes.
const KEPT: f64 = 0.98;
/// Limits of the ratio (assumed): thermal errors are stated rightly, and a manoeuvre is not glint.
const LEAST: f64 = 0.12;
const MOST: f64 = 5.0;

/// A plot's time and place.
type At = (SimTime, Point2<f64>);

/// The last plot of a radar, and the one a turn before it.
#[derive(Clone, Copy, Debug)]
struct Last {
    sensor: SensorId,
    one: At,
    before: Option<At>,
}

/// Radars whose plots of one target are compared; of more, the first, each until it sees the target no more.
const MOST_RADARS: usize = 4;

/// Ratio of the variances seen to the variances stated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    /// Of each radar, the last plots.
    last: [Option<Last>; MOST_RADARS],
    seen: [f64; 2],
    triples: f64,
    stated: [f64; 2],
    /// The same of about the last [`FEWEST_TRIPLES`] triples: sum and number.
    lately: [f64; 2],
}

/// Share that is kept of what was seen lately, per triple.
const LATELY: f64 = 0.89;

impl Spread {
    /// Factors on the variances that a plot states along and across.
    pub(super) fn factors(&self, plot: &Plot) -> [f64; 2] {
        let own = [plot.along_m2, plot.across_m2];
        [0, 1].map(|k| {
            let prior = PRIOR * own[k];
            let found = (self.seen[k] + prior) / (self.stated[k] + prior);
            if found.is_finite() { found.clamp(LEAST, MOST) } else { 1.0 }
        })
    }

    /// Variance of one plot as it was seen, the mean of both directions, and how many triples say so; none yet.
    pub(super) fn variance_m2(&self) -> Option<(f64, f64)> {
        let mean = 0.5 * (self.seen[0] + self.seen[1]) / self.triples;
        (self.triples > 0.0).then_some((mean, self.triples))
    }

    /// The same of the last triples only: a track that went over to another target shows it there first.
    pub(super) fn lately_m2(&self) -> Option<(f64, f64)> {
        let [sum, triples] = self.lately;
        (triples > 0.0).then_some((sum / triples, triples))
    }

    /// Takes a plot that the track has taken, with the variances that it states; `interval_s` of its sensor. Only radars
    /// show bodies.
    pub(super) fn learn(&mut self, plot: &Plot, interval_s: f64) {
        if !plot.kind.radar || !plot.across_m2.is_finite() {
            return;
        }
        let here = (plot.time, plot.position_m);
        let near = |a: SimTime, b: SimTime| {
            let t = b.since_s(a);
            t > 0.5 * interval_s && t < 1.5 * interval_s
        };
        // The plots of one radar lie as far off as its next: between those of two there is the body.
        let own = |last: &Option<Last>| last.as_ref().is_some_and(|l| l.sensor == plot.sensor);
        let known = self.last.iter().position(own);
        let gone = |l: &Last| here.0.since_s(l.one.0) > 2.5 * interval_s;
        let free = || self.last.iter().position(|last| last.as_ref().is_none_or(gone));
        let Some(place) = known.or_else(free) else { return };
        let kept = known.and(self.last[place]);
        let two = kept.and_then(|l| Some((l.before?, l.one)));
        if let Some((first, second)) = two.filter(|(_, second)| near(second.0, here.0)) {
            let bend = first.1.coords - second.1.coords * 2.0 + here.1.coords;
            let parts = [bend.dot(&plot.axis), bend.dot(&plot.across_axis())];
            let stated = [plot.along_m2, plot.across_m2];
            self.triples = KEPT * self.triples + 1.0;
            self.lately = self.lately.map(|l| LATELY * l);
            self.lately[1] += 1.0;
            for k in 0..2 {
                // One wild plot is no property of the target: six deviations of a triple.
                let limit = 36.0 * MOST * stated[k];
                let square = (parts[k] * parts[k] / 6.0).min(limit);
                self.seen[k] = KEPT * self.seen[k] + square;
                self.lately[0] += 0.5 * square;
                self.stated[k] = KEPT * self.stated[k] + stated[k];
            }
        }
        let before = kept.map(|l| l.one).filter(|one| near(one.0, here.0));
        self.last[place] = Some(Last { sensor: plot.sensor, one: here, before });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, normal_pair};
    use crate::filter::testing::plot_at;
    use crate::frames::Vector2;

    /// What plots of these types wander, m²: in the mean of them the law is right within a fifth, and of each within a factor of two.
    #[test]
    fn the_law_of_size_is_that_of_the_types_it_was_fitted_to() {
        let types = [
            (4.6, 1.9, 0.15),
            (12.0, 2.6, 0.8),
            (14.39, 15.9, 0.7),
            (37.6, 35.8, 7.0),
            (56.7, 60.1, 16.0),
            (63.7, 60.3, 20.0),
        ];
        let off =
            types.map(|(length, span, seen)| libm::log(plot_variance_m2(length, span) / seen));
        assert!(off.iter().all(|o| o.abs() < std::f64::consts::LN_2), "{off:?}");
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        assert!(mean.abs() < libm::log(1.2), "{mean}");
    }

    /// By hand: three plots of equal distance, then a fourth.
    #[test]
    fn a_triple_shows_the_square_of_its_bend_over_six() {
        let mut spread = Spread::default();
        assert_eq!((spread.variance_m2(), spread.lately_m2()), (None, None));
        let plots = [(0.0, 0.0, 0.0), (1.0, 13.0, 0.0), (2.0, 20.0, 6.0), (3.0, 30.0, 6.0)];
        let plots = plots.map(|(t, x, y)| plot_at(t, x, y, 4.0));
        assert_eq!((plots[0].axis, plots[0].along_m2), (Vector2::x(), 4.0));
        for plot in &plots[..3] {
            spread.learn(plot, 1.0);
        }
        // Bends −6 and 6: 6 m² either way of 4 m² stated.
        assert_eq!(spread.variance_m2(), Some((6.0, 1.0)));
        assert_eq!(spread.lately_m2(), Some((6.0, 1.0)));
        assert_eq!(spread.factors(&plots[0]), [(6.0 + 48.0) / 52.0; 2]);
        // Bends 3 and −6: 1.5 and 6 m²; of what was there 0.98 are kept, of what was lately 0.89.
        spread.learn(&plots[3], 1.0);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
        let (mean, triples) = spread.variance_m2().expect("seen");
        close(triples, 1.98);
        close(mean, 0.5 * (5.88 + 1.5 + 5.88 + 6.0) / 1.98);
        let (mean, triples) = spread.lately_m2().expect("seen");
        close(triples, 1.89);
        close(mean, (0.89 * 6.0 + 3.75) / 1.89);
        let [along, across] = spread.factors(&plots[0]);
        close(along, (5.88 + 1.5 + 48.0) / (7.92 + 48.0));
        close(across, (5.88 + 6.0 + 48.0) / (7.92 + 48.0));
        // A ratio has its limits, and what states nothing has none.
        spread.seen = [0.0, 1e9];
        spread.stated = [1e9, 4.0];
        assert_eq!(spread.factors(&plots[0]), [LEAST, MOST]);
        let nothing = Plot { along_m2: 0.0, across_m2: f64::NAN, ..plots[0] };
        assert_eq!(Spread::default().factors(&nothing), [1.0, 1.0]);
        // Plots without an error across, and those of no radar, show nothing.
        let mut spread = Spread::default();
        for plot in &plots {
            let bearingless = Plot { across_m2: f64::NAN, ..*plot };
            spread.learn(&bearingless, 1.0);
        }
        assert_eq!(spread.variance_m2(), None);
    }

    #[test]
    fn sizes_and_variances_are_one_law_read_both_ways() {
        for (length, span) in [(3.0, 4.0), (30.0, 40.0), (60.0, 60.0)] {
            let diagonal = libm::hypot(length, span);
            assert!((diagonal_m(plot_variance_m2(length, span)) - diagonal).abs() < 1e-9);
        }
        assert!((plot_variance_m2(30.0, 40.0) - 6.62).abs() < 1e-12);
        assert_eq!((diagonal_m(0.12), diagonal_m(-5.0)), (0.0, 0.0));
        assert_eq!((near_side_m2(None), near_side_m2(Some(0.01))), (3.6, 0.0));
        assert!((near_side_m2(Some(1.12)) - 0.82).abs() < 1e-12);
        // Likeliest is the size that shows just that, and one e-fold off is less likely by ½/σ².
        let seen = plot_variance_m2(30.0, 40.0);
        assert_eq!(ln_density(seen, 8.0, 30.0, 40.0), 0.0);
        let off = ln_density(seen * std::f64::consts::E, 8.0, 30.0, 40.0);
        assert!((off + 0.5 / (0.5 + 0.35 * 0.35)).abs() < 1e-9, "{off}");
        let off = ln_density(seen / std::f64::consts::E, 0.0, 30.0, 40.0);
        assert!((off + 0.5 / (40.0 + 0.35 * 0.35)).abs() < 1e-9, "{off}");
        assert_eq!(ln_density(0.0, 8.0, 30.0, 40.0), ln_density(1e-3, 8.0, 30.0, 40.0));
        // Of a hundred targets a hundred are of some kind.
        let shares: f64 = CLASSES.iter().map(|(_, share)| share).sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }

    /// One plot half a kilometre off, among forty: it counts for no more than six deviations of the widest that is believed.
    #[test]
    fn one_wild_plot_is_no_property_of_the_target() {
        let seen = |wild_m: f64| {
            let mut spread = Spread::default();
            for k in 0..40u32 {
                let key = DrawKey { run_seed: 3, sensor: 1, entity: 0, scan: k.into() };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                let off_m = if k == 30 { wild_m } else { 0.0 };
                let plot = plot_at(f64::from(k), 500.0 + a + off_m, b, 2.0);
                spread.learn(&plot, 1.0);
            }
            spread.variance_m2().expect("seen")
        };
        let ((usual, triples), (wild, _)) = (seen(0.0), seen(500.0));
        assert!((0.5..2.0).contains(&usual), "{usual}");
        let most = usual + 0.5 * 3.0 * 36.0 * MOST * 2.0 / triples;
        assert!(wild > usual && wild <= most, "{usual} {wild} {most}");
        // Plots that come twice as fast as the sensor looks, or half as fast, show nothing.
        let of_every = |t: f64| {
            let mut spread = Spread::default();
            for k in 0..9u32 {
                let plot = plot_at(t * f64::from(k), f64::from(k % 2), 0.0, 2.0);
                spread.learn(&plot, 1.0);
            }
            spread.variance_m2().is_some()
        };
        assert_eq!([0.4, 0.6, 1.0, 1.4, 1.6].map(of_every), [false, true, true, true, false]);
    }
}
