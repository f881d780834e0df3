//! Targets that are larger than a range cell: where the echo's centre lies and how it wanders.
//!
//! A target is a list of scatterers in shares of its length, width and median cross section. The
//! lists are a shape, not a measurement: plausible places of the strong returns of a transport
//! aircraft and of a box on wheels, free to be replaced per type ([`scatterers_of`]).
//!
//! Levels: `Point` (the reference point, nothing else) and `Centroid` (closed form of bias and
//! glint). In cells and video ([`crate::sensors::video`]) the scatterers themselves are simulated.
//!
//! Frame: `along` the line of sight, away from the radar; `across` it, clockwise in azimuth.
//!
//! Source of the closed form: power centroid of independently fading scatterers; Skolnik,
//! *Introduction to Radar Systems*, ch. 4 (glint), Barton, *Radar Equations for Modern Radar*.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::frames::wrap_pi;
use crate::sensors::TargetClass;

/// From where a scatterer is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// From everywhere.
    All,
    /// From the direction `from_deg` (0 ahead, clockwise), falling as cos² to 0 at `half_width_deg`.
    Sector {
        /// Direction of the full return, degrees clockwise from ahead.
        from_deg: f64,
        /// Where it has fallen to nothing, degrees.
        half_width_deg: f64,
    },
}

impl View {
    /// Share of the full return seen from `view_rad`, 0 to 1.
    #[must_use]
    pub fn share(self, view_rad: f64) -> f64 {
        match self {
            View::All => 1.0,
            View::Sector { from_deg, half_width_deg } => {
                let off = wrap_pi(view_rad - from_deg.to_radians()).abs();
                let half = half_width_deg.to_radians();
                if off >= half {
                    return 0.0;
                }
                let cos = libm::cos(FRAC_PI_2 * off / half);
                cos * cos
            }
        }
    }
}

/// One place on a target that returns part of the echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Forward of the centre, in lengths.
    pub x: f64,
    /// Right of the centre, in spans or widths.
    pub y: f64,
    /// Share of the median cross section.
    pub weight: f64,
    /// From where it is seen.
    pub view: View,
}

const fn everywhere(x: f64, y: f64, weight: f64) -> Scatterer {
    Scatterer { x, y, weight, view: View::All }
}

const fn seen_from(from_deg: f64, half_width_deg: f64, x: f64, y: f64, weight: f64) -> Scatterer {
    Scatterer { x, y, weight, view: View::Sector { from_deg, half_width_deg } }
}

/// A transport aircraft with two engines under the wing. Places after common layouts, weights assumed.
pub const AIRCRAFT: [Scatterer; 15] = [
    seen_from(0.0, 90.0, 0.48, 0.0, 0.10),   // nose, radome
    everywhere(0.40, 0.0, 0.08),             // forward fuselage
    seen_from(0.0, 70.0, 0.10, -0.17, 0.14), // engine inlets
    seen_from(0.0, 70.0, 0.10, 0.17, 0.14),
    seen_from(180.0, 70.0, -0.02, -0.17, 0.10), // engine nozzles
    seen_from(180.0, 70.0, -0.02, 0.17, 0.10),
    everywhere(0.02, -0.07, 0.05), // wing roots
    everywhere(0.02, 0.07, 0.05),
    everywhere(-0.10, -0.50, 0.03), // wing tips
    everywhere(-0.10, 0.50, 0.03),
    everywhere(-0.03, 0.0, 0.08),   // main gear
    everywhere(0.37, 0.0, 0.04),    // nose gear
    everywhere(-0.45, 0.0, 0.12),   // fin
    everywhere(-0.47, -0.15, 0.04), // tailplane
    everywhere(-0.47, 0.15, 0.04),
];

/// A box on wheels: each face seen from its side, and the body from everywhere. Weights assumed.
pub const VEHICLE: [Scatterer; 5] = [
    seen_from(0.0, 90.0, 0.45, 0.0, 0.75),
    seen_from(180.0, 90.0, -0.45, 0.0, 0.75),
    seen_from(90.0, 90.0, 0.0, 0.45, 0.75),
    seen_from(-90.0, 90.0, 0.0, -0.45, 0.75),
    everywhere(0.0, 0.0, 0.25),
];

/// Places of the broadside flash along the fuselage, in lengths.
const FLASH_X: [f64; 7] = [-0.35, -0.233_333, -0.116_667, 0.0, 0.116_667, 0.233_333, 0.35];
/// Radius of a fuselage in lengths (1.98 m of 37.6 m for an A320).
const FUSELAGE_RADIUS: f64 = 0.05;
/// Share left of a scatterer behind the fuselage.
const BEHIND_FUSELAGE: f64 = 0.05;

/// Scatterers of a class: the aircraft's or the vehicle's list.
#[must_use]
pub fn scatterers_of(class: &TargetClass) -> &'static [Scatterer] {
    if class.aircraft { &AIRCRAFT } else { &VEHICLE }
}

/// Direction from which the radar sees a target, radians clockwise from ahead, in [−π, π).
///
/// `azimuth_rad` of the target at the radar and its `heading_rad`, both clockwise from north.
#[must_use]
pub fn view_rad(azimuth_rad: f64, heading_rad: f64) -> f64 {
    wrap_pi(azimuth_rad + PI - heading_rad)
}

/// One echo of a target, in the frame of the line of sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// Away from the radar, from the reference point, m.
    pub along_m: f64,
    /// Clockwise in azimuth, from the reference point, m.
    pub across_m: f64,
    /// Mean cross section, m².
    pub rcs_m2: f64,
}

/// Most echoes of one target: the longest list and the flash.
pub const MAX_ECHOES: usize = 22;

/// The echoes of one target; at most [`MAX_ECHOES`], without allocation.
#[derive(Clone, Copy, Debug)]
pub struct Echoes {
    list: [Echo; MAX_ECHOES],
    len: usize,
}

impl std::ops::Deref for Echoes {
    type Target = [Echo];
    fn deref(&self) -> &[Echo] {
        &self.list[..self.len]
    }
}

/// The echoes of `class` seen from `view_rad` (radians clockwise from ahead).
///
/// Scatterers whose line of sight crosses the fuselage count 5 %. Aircraft flash at broadside:
/// seven points on the near side share (0.3 + 20 exp(−½(Δβ/3°)²)) · RCS · |sin β|.
#[must_use]
pub fn echoes(class: &TargetClass, view_rad: f64) -> Echoes {
    let (sin, cos) = libm::sincos(view_rad);
    let mut out = Echoes { list: [Echo::default(); MAX_ECHOES], len: 0 };
    let mut add = |x_m: f64, y_m: f64, rcs_m2: f64| {
        if rcs_m2 > 0.0 && out.len < MAX_ECHOES {
            out.list[out.len] =
                Echo { along_m: -cos * x_m - sin * y_m, across_m: sin * x_m - cos * y_m, rcs_m2 };
            out.len += 1;
        }
    };
    let (mut last_view, mut last_share) = (View::All, 1.0);
    for scatterer in scatterers_of(class) {
        if scatterer.view != last_view {
            (last_view, last_share) = (scatterer.view, scatterer.view.share(view_rad));
        }
        let (x_m, y_m) = (scatterer.x * class.length_m, scatterer.y * class.span_m);
        let mut rcs_m2 = scatterer.weight * last_share * class.rcs_m2;
        if class.aircraft && behind_fuselage(class, x_m, y_m, sin, cos) {
            rcs_m2 *= BEHIND_FUSELAGE;
        }
        add(x_m, y_m, rcs_m2);
    }
    if class.aircraft {
        let off = (wrap_pi(view_rad).abs() - FRAC_PI_2) / 3_f64.to_radians();
        let share = (0.3 + 20.0 * libm::exp(-0.5 * off * off)) * sin.abs() / 7.0;
        let side_m = (FUSELAGE_RADIUS * class.length_m).min(0.5 * class.span_m).copysign(sin);
        for x in FLASH_X {
            add(x * class.length_m, side_m, share * class.rcs_m2);
        }
    }
    out
}

/// Whether the way from (x, y) to the radar crosses the fuselage |x| < L/2, y = 0.
fn behind_fuselage(class: &TargetClass, x_m: f64, y_m: f64, sin: f64, cos: f64) -> bool {
    if y_m == 0.0 || y_m * sin >= 0.0 {
        return false;
    }
    (x_m - y_m / sin * cos).abs() < 0.5 * class.length_m
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
        ExtentLevel::Centroid => centroid_of(&echoes(class, view_rad)),
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
    use proptest::prelude::*;

    fn class(aircraft: bool, length_m: f64, span_m: f64) -> TargetClass {
        TargetClass {
            designator: "T".into(),
            aircraft,
            length_m,
            span_m,
            height_m: 10.0,
            rcs_m2: 20.0,
        }
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
