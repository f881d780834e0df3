//! Targets that are larger than a range cell: where the echo's centre lies and how it wanders.
//!
//! A target is a list of scatterers in shares of its length, width and median cross section: its
//! [`crate::sensors::radar::shape::Shape`], which is data and no measurement.
//!
//! Levels: `Point` (the reference point, nothing else), `Centroid` (closed form of bias and glint) and
//! `Table` (the same by aspect, within a stated error). In cells and video ([`crate::sensors::radar::video`]) the scatterers themselves are simulated.
//!
//! Frame: `along` the line of sight, away from the radar; `across` it, clockwise in azimuth.
//!
//! Source of the closed form: power centroid of independently fading scatterers; Skolnik,
//! *Introduction to Radar Systems*, ch. 4 (glint), Barton, *Radar Equations for Modern Radar*.

use std::f64::consts::PI;

use crate::frames::wrap_pi;
use crate::sensors::TargetClass;
use crate::sensors::radar::shape::{Echo, Echoes, echoes_of};

/// Direction from which the radar sees a target, radians clockwise from ahead, in [−π, π).
///
/// `azimuth_rad` of the target at the radar and its `heading_rad`, both clockwise from north.
#[must_use]
pub fn view_rad(azimuth_rad: f64, heading_rad: f64) -> f64 {
    wrap_pi(azimuth_rad + PI - heading_rad)
}

/// The echoes of `class` seen from `view_rad` (radians clockwise from ahead), by its shape.
#[must_use]
pub fn echoes(class: &TargetClass, view_rad: f64) -> Echoes {
    echoes_of(&class.shape, (class.length_m, class.span_m), class.rcs_m2, view_rad)
}

/// Where the echo of a target lies against its reference point, and how it wanders.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Centroid {
    /// Bias away from the radar, m: the same in each scan at the same aspect.
    pub bias_along_m: f64,
    /// Bias clockwise in azimuth, m.
    pub bias_across_m: f64,
    /// Deviation of the centre from scan to scan along the line of sight, m.
    pub glint_along_m: f64,
    /// The same across it, m.
    pub glint_across_m: f64,
    /// Total mean cross section, m².
    pub rcs_m2: f64,
}

/// How a target is described.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentLevel {
    /// Its reference point and median cross section.
    Point,
    /// As `Centroid`, from a table by aspect ([`super::aspect`]); without one, as `Centroid`.
    Table,
    /// Centroid and glint of its scatterers, closed form: the glint is 5 to 12 % high.
    Centroid,
}

/// Centroid of `class` seen from `view_rad` at `level`; `None` if nothing returns an echo.
///
/// Always within [`half_extent_m`]: a centroid lies in the hull of its scatterers.
#[must_use]
pub fn centroid(level: ExtentLevel, class: &TargetClass, view_rad: f64) -> Option<Centroid> {
    match level {
        ExtentLevel::Point => {
            (class.rcs_m2 > 0.0).then(|| Centroid { rcs_m2: class.rcs_m2, ..Centroid::default() })
        }
        ExtentLevel::Table | ExtentLevel::Centroid => centroid_of(&echoes(class, view_rad)),
    }
}

/// Power centroid x̄ = Σ w x/Σ w and its scintillation σ² = Σ w²(x − x̄)²/(Σ w)² per axis, for
/// scatterers that fade independently; `None` if there is no power, or weights that are no numbers.
///
/// Sums are taken from the strongest scatterer, so a single strong one leaves no rounding of its place.
#[must_use]
pub fn centroid_of(echoes: &[Echo]) -> Option<Centroid> {
    let strongest = echoes.iter().max_by(|a, b| a.rcs_m2.total_cmp(&b.rcs_m2))?;
    let total: f64 = echoes.iter().map(|e| e.rcs_m2).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let share = |e: &Echo| e.rcs_m2 / total;
    let (mut along, mut across) = (0.0, 0.0);
    for e in echoes {
        along += share(e) * (e.along_m - strongest.along_m);
        across += share(e) * (e.across_m - strongest.across_m);
    }
    let (mut var_along, mut var_across) = (0.0, 0.0);
    for e in echoes {
        let s = share(e);
        let (da, dc) =
            (e.along_m - strongest.along_m - along, e.across_m - strongest.across_m - across);
        var_along += s * s * da * da;
        var_across += s * s * dc * dc;
    }
    let found = Centroid {
        bias_along_m: strongest.along_m + along,
        bias_across_m: strongest.across_m + across,
        glint_along_m: f64::sqrt(var_along),
        glint_across_m: f64::sqrt(var_across),
        rcs_m2: total,
    };
    (found.bias_along_m.is_finite() && found.bias_across_m.is_finite()).then_some(found)
}

/// Hard bounds of bias and glint, m: half the projected extent along and across the line of sight,
/// ½(L|cos β| + W|sin β|) and ½(L|sin β| + W|cos β|).
#[must_use]
pub fn half_extent_m(class: &TargetClass, view_rad: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(view_rad);
    let (sin, cos) = (sin.abs(), cos.abs());
    (
        0.5 * (class.length_m * cos + class.span_m * sin),
        0.5 * (class.length_m * sin + class.span_m * cos),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, exponential};
    use crate::sensors::testing;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn class(aircraft: bool, length_m: f64, span_m: f64) -> TargetClass {
        testing::class(aircraft, length_m, span_m, 20.0)
    }

    #[test]
    fn the_nose_on_view_is_ahead_and_the_mirror_image_mirrors() {
        // The radar is north of an aircraft that heads north: azimuth of the target is south.
        assert!(view_rad(PI, 0.0).abs() < 1e-15);
        // Radar in the west of an aircraft heading north sees its left side.
        assert!((view_rad(FRAC_PI_2, 0.0) + FRAC_PI_2).abs() < 1e-15);
        let a320 = class(true, 37.6, 35.8);
        let nose_on = centroid(ExtentLevel::Centroid, &a320, 0.0).expect("an echo");
        assert!(nose_on.bias_across_m.abs() < 1e-12);
        for degrees in 1..180 {
            let view = f64::from(degrees).to_radians();
            let right = centroid(ExtentLevel::Centroid, &a320, view).expect("an echo");
            let left = centroid(ExtentLevel::Centroid, &a320, -view).expect("an echo");
            assert!((right.bias_along_m - left.bias_along_m).abs() < 1e-9);
            assert!((right.bias_across_m + left.bias_across_m).abs() < 1e-9);
            assert!((right.glint_along_m - left.glint_along_m).abs() < 1e-9);
        }
        let toward = echoes(&a320, 0.0)[0];
        assert!(toward.along_m < -17.0, "the nose is nearer to the radar ahead: {toward:?}");
    }

    #[test]
    fn sizes_of_bias_and_glint_are_those_of_their_class() {
        for (name, class, bias_m, glint_m) in [
            ("A320", class(true, 37.6, 35.8), 3.2, 3.6),
            ("B747", class(true, 70.7, 64.4), 6.0, 6.8),
            ("C172", class(true, 8.3, 11.0), 1.0, 1.0),
        ] {
            let (mut bias, mut glint) = (0.0_f64, 0.0_f64);
            for degrees in -180..180 {
                let c = centroid(ExtentLevel::Centroid, &class, f64::from(degrees).to_radians())
                    .expect("an echo");
                bias = bias.max(c.bias_along_m.abs()).max(c.bias_across_m.abs());
                glint = glint.max(c.glint_along_m).max(c.glint_across_m);
            }
            assert!(bias < bias_m && bias > 0.3 * bias_m, "{name}: bias up to {bias}");
            assert!(glint < glint_m && glint > 0.3 * glint_m, "{name}: glint up to {glint}");
        }
    }

    #[test]
    fn the_closed_glint_is_a_little_high_against_draws() {
        let a320 = class(true, 37.6, 35.8);
        for degrees in [0, 20, 45, 75, 120, 160, 180] {
            let echoes = echoes(&a320, f64::from(degrees).to_radians());
            let closed = centroid_of(&echoes).expect("an echo");
            let key = DrawKey { run_seed: 1, sensor: 0, entity: degrees as u64, scan: 0 };
            let mut rng = key.rng(Purpose::Study);
            let (mut sum, mut square) = (0.0, 0.0);
            let n = 20_000;
            for _ in 0..n {
                let (mut power, mut moment) = (0.0, 0.0);
                for e in echoes.iter() {
                    let p = e.rcs_m2 * exponential(&mut rng);
                    power += p;
                    moment += p * e.along_m;
                }
                let x = moment / power;
                sum += x;
                square += x * x;
            }
            let mean = sum / f64::from(n);
            let sigma = (square / f64::from(n) - mean * mean).sqrt();
            let ratio = closed.glint_along_m / sigma;
            assert!(ratio > 0.98 && ratio < 1.2, "{degrees}: closed {closed:?}, drawn {sigma}");
        }
    }

    #[test]
    fn without_power_there_is_no_plot() {
        let nothing = TargetClass { rcs_m2: 0.0, ..class(true, 10.0, 10.0) };
        for level in [ExtentLevel::Point, ExtentLevel::Centroid] {
            assert_eq!(centroid(level, &nothing, 1.0), None);
        }
        assert_eq!(centroid_of(&[]), None);
        let broken = Echo { along_m: 1.0, across_m: 0.0, rcs_m2: f64::NAN };
        assert_eq!(centroid_of(&[broken]), None);
        let endless = Echo { rcs_m2: f64::INFINITY, ..broken };
        assert_eq!(centroid_of(&[endless, endless]), None);
    }

    proptest! {
        #[test]
        fn bias_and_glint_stay_in_their_bounds(
            length in 1.0_f64..90.0, span in 1.0_f64..90.0, view in -10.0_f64..10.0,
            aircraft: bool,
        ) {
            let class = class(aircraft, length, span);
            let c = centroid(ExtentLevel::Centroid, &class, view).expect("an echo");
            let (along, across) = half_extent_m(&class, view);
            prop_assert!(c.bias_along_m.abs() <= along && c.glint_along_m <= along, "{:?}", c);
            prop_assert!(c.bias_across_m.abs() <= across && c.glint_across_m <= across, "{:?}", c);
            prop_assert!(c.rcs_m2 > 0.0 && c.rcs_m2 < 22.0 * class.rcs_m2);
        }
    }
}
