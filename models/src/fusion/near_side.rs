//! Where the echo of a target lies: on its near side, by its size and the side that it shows.
//!
//! `plot = truth − o e_r`, `o = κ_L h_L + κ_S h_S`, `h_L = ½L|cos β|`, `h_S = ½S|sin β|`, β the view (0 from ahead), L the
//! length and S the span (or width). An aircraft has scatterers along its whole body, so the centre of its echo stays
//! near its middle; a vehicle is a box that turns a face to the radar.
//!
//! Source: the power centroid of scatterers (Skolnik, *Introduction to Radar Systems*, ch. 4); the two numbers of a kind
//! of body are assumed, and learnt where targets report their position ([`super::registration`]).

use super::size;
pub use super::size::Body;
use crate::frames::Vector2;
use std::f64::consts::{FRAC_2_PI, PI};

/// How far the echo lies towards the radar, in half extents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kappa {
    /// Of half the length that is seen.
    pub length: f64,
    /// Of half the span or width that is seen.
    pub span: f64,
}

/// What is assumed of echoes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoLaw {
    /// Of aircraft.
    pub aircraft: Kappa,
    /// Of ground vehicles.
    pub vehicle: Kappa,
    /// Offset where the type of a target is not known, m, and its standard deviation over the targets of an airport.
    pub unknown_m: (f64, f64),
    /// Standard deviation of what the law leaves, m.
    pub residual_m: f64,
    /// Standard deviation of what an echo lies off across the line of sight, of a target of which nothing is known, m.
    pub beside_m: f64,
    /// Correlation time of that: the aspect changes it, s.
    pub residual_tau_s: f64,
    /// Whether the echoes of one target wander otherwise than its plots state; else they are those of points.
    pub wanders: bool,
}

impl EchoLaw {
    /// Every target is a point: nothing is taken off.
    pub const POINT: Self = Self {
        aircraft: Kappa { length: 0.0, span: 0.0 },
        vehicle: Kappa { length: 0.0, span: 0.0 },
        unknown_m: (0.0, 0.0),
        residual_m: 0.0,
        beside_m: 0.0,
        residual_tau_s: 100.0,
        wanders: false,
    };
}

impl Default for EchoLaw {
    /// Fitted on movements at two airports (aircraft 0.077 to 0.107 and 0.110, vehicles 0.558 to 0.563 and 0.107 to
    /// 0.153); the mean over their targets 1.9 m.
    fn default() -> Self {
        Self {
            aircraft: Kappa { length: 0.095, span: 0.11 },
            vehicle: Kappa { length: 0.56, span: 0.13 },
            unknown_m: (1.9, 0.9),
            residual_m: 1.4,
            beside_m: 1.2,
            residual_tau_s: 100.0,
            wanders: true,
        }
    }
}

/// Half the length and half the span that are seen along the line of sight `axis` by the `course` of the nose, both unit
/// vectors, m.
#[must_use]
pub fn half_extents_m(body: &Body, axis: Vector2<f64>, course: Vector2<f64>) -> (f64, f64) {
    let (cos, sin) = (axis.dot(&course).abs(), axis.perp(&course).abs());
    (0.5 * body.length_m * cos, 0.5 * body.span_m * sin)
}

impl Kappa {
    /// Offset towards the radar, m, of half extents that are seen.
    #[must_use]
    pub fn offset_m(&self, (length_m, span_m): (f64, f64)) -> f64 {
        self.length * length_m + self.span * span_m
    }

    /// Mean and standard deviation of the offset over all headings, m.
    ///
    /// `E o = (2/π)(A + B)`, `Var o = ½(A² + B²) + 2AB/π − (E o)²`, `A = κ_L L/2`, `B = κ_S S/2`.
    #[must_use]
    pub fn mean_offset_m(&self, body: &Body) -> (f64, f64) {
        let (a, b) = (0.5 * self.length * body.length_m, 0.5 * self.span * body.span_m);
        let mean = FRAC_2_PI * (a + b);
        let variance = 0.5 * (a * a + b * b) + 2.0 * a * b / PI - mean * mean;
        (mean, variance.max(0.0).sqrt())
    }

    /// The half extent that, times the length's number, gives the offset: `h = h_L + (κ_S/κ_L) h_S`, m.
    #[must_use]
    pub fn joint_half_extent_m(&self, (length_m, span_m): (f64, f64)) -> f64 {
        if self.length > 0.0 { length_m + self.span / self.length * span_m } else { 0.0 }
    }
}

impl EchoLaw {
    /// The numbers of a body.
    #[must_use]
    pub fn of(&self, body: &Body) -> Kappa {
        if body.vehicle { self.vehicle } else { self.aircraft }
    }

    /// Offset towards the radar and its standard deviation, m: of a body that is known, by its `course` if that is known.
    #[must_use]
    pub fn offset_m(
        &self,
        body: Option<&Body>,
        course: Option<Vector2<f64>>,
        axis: Vector2<f64>,
    ) -> (f64, f64) {
        let (offset, sigma) = match (body, course) {
            (None, _) => self.unknown_m,
            (Some(body), None) => self.of(body).mean_offset_m(body),
            (Some(body), Some(course)) => {
                (self.of(body).offset_m(half_extents_m(body, axis, course)), 0.0)
            }
        };
        (offset, libm::hypot(sigma, self.residual_m))
    }
}

impl EchoLaw {
    /// Offset and its standard deviation of a target whose type nobody has said, by the variance of its plots that was
    /// seen in so many triples: `p_k ∝ prior · N(ln s²; ln v_k, 2/(n/2) + 0.35²)`, `o = Σ p_k o_k`.
    #[must_use]
    pub fn offset_of_unknown_m(
        &self,
        variance_m2: f64,
        triples: f64,
        course: Option<Vector2<f64>>,
        axis: Vector2<f64>,
    ) -> (f64, f64) {
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (body, weight) in likely(variance_m2, triples) {
            let (offset, sigma) = match course {
                Some(course) => (self.of(body).offset_m(half_extents_m(body, axis, course)), 0.0),
                None => self.of(body).mean_offset_m(body),
            };
            sum += weight;
            mean += weight * offset;
            square += weight * (offset * offset + sigma * sigma);
        }
        if !(sum > 0.0 && mean.is_finite()) {
            return self.offset_m(None, course, axis);
        }
        mean /= sum;
        let variance = (square / sum - mean * mean).max(0.0) + self.residual_m * self.residual_m;
        (mean, variance.sqrt())
    }
}

/// What an echo of an aircraft lies off across the line of sight, a constant while it shows the radar the same side: share of its
/// length or span (measured on traffic of four airports: 0.8 to 1.6 m rms of targets of 38 m that stand, half of that of moving ones).
const ACROSS_SHARE: f64 = 0.03;

impl EchoLaw {
    /// Standard deviation, over the sides that a body shows, of what its echo lies off across the line of sight, m.
    ///
    /// A vehicle is a box whose faces return `cos²` of the angle at which they are seen (Lambert): its echo lies
    /// `κ_L ½L cos²β` ahead of the middle, so `κ_L ½L cos²β sin β` beside the line of sight, with a mean square over β of `(κ_L ½L)²/16`.
    #[must_use]
    pub fn across_m(&self, body: Option<&Body>) -> f64 {
        match body {
            None => self.beside_m,
            Some(body) if body.vehicle => 0.125 * self.vehicle.length * body.length_m,
            Some(body) => ACROSS_SHARE * body.length_m.max(body.span_m),
        }
    }

    /// The same of a target whose type nobody has said, as [`Self::offset_of_unknown_m`].
    #[must_use]
    pub fn across_of_unknown_m(&self, variance_m2: f64, triples: f64) -> f64 {
        let (mut sum, mut square) = (0.0, 0.0);
        for (body, weight) in likely(variance_m2, triples) {
            let across = self.across_m(Some(body));
            sum += weight;
            square += weight * across * across;
        }
        if sum > 0.0 { (square / sum).sqrt() } else { self.beside_m }
    }
}

/// Kinds of bodies, each with how likely it is by the variance that plots show.
fn likely(variance_m2: f64, triples: f64) -> impl Iterator<Item = (&'static Body, f64)> {
    size::CLASSES.iter().map(move |(body, prior)| {
        let ln = size::ln_density(variance_m2, triples, body.length_m, body.span_m);
        (body, prior * libm::exp(ln))
    })
}

/// What is faster than this may fly, m/s (a light aircraft lifts off above; assumed).
const FLIES_MPS: f64 = 30.0;

/// Whether a target is on the ground for certain. A plot of a radar is where a slant range meets the ground: of an aircraft on final
/// at 3° it is 4 to 7 m too far from 5 km on, which is no error of the site.
#[must_use]
pub fn on_ground(velocity_mps: Vector2<f64>) -> bool {
    velocity_mps.norm() < FLIES_MPS
}

/// Derivatives of a plot of a target by (range bias m, azimuth bias rad, time offset s, κ_L, κ_S): columns, m east and
/// north. `axis` from the radar to the target, `ground_m` away, that moves at `velocity_mps`.
#[must_use]
pub fn derivatives(
    axis: Vector2<f64>,
    ground_m: f64,
    velocity_mps: Vector2<f64>,
    (length_m, span_m): (f64, f64),
) -> [Vector2<f64>; 5] {
    let across = Vector2::new(axis.y, -axis.x);
    [axis, across * ground_m, -velocity_mps, -axis * length_m, -axis * span_m]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box whose faces return cos² of the angle at which they are seen, looked at from all around: its echo lies beside the line
    /// of sight by as much as the law says, which of a fire engine was a third of that.
    #[test]
    fn what_a_box_shows_beside_the_line_of_sight_is_what_the_law_says() {
        let law = EchoLaw::default();
        for (length_m, span_m) in [(4.6, 1.9), (12.0, 3.0), (13.8, 3.0), (18.0, 0.0)] {
            let body = Body { vehicle: true, length_m, span_m };
            let (mut square, steps) = (0.0, 360);
            for step in 0..steps {
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * f64::from(step) / f64::from(steps));
                // The faces to the front or the rear and to the side, each by what it returns.
                let ahead = law.vehicle.length * 0.5 * length_m * cos * cos.abs();
                square += (ahead * sin).powi(2) / f64::from(steps);
            }
            let stated = law.across_m(Some(&body));
            assert!((stated - square.sqrt()).abs() < 1e-9, "{length_m} m: {stated} {square}");
        }
        // A jet's by its larger side.
        let jet = |length_m, span_m| Body { vehicle: false, length_m, span_m };
        assert_eq!(law.across_m(Some(&jet(30.0, 40.0))), law.across_m(Some(&jet(40.0, 30.0))));
        assert!((law.across_m(Some(&jet(40.0, 30.0))) - 1.2).abs() < 1e-12);
    }

    #[test]
    fn of_a_target_that_nobody_names_it_is_that_of_the_bodies_that_its_plots_are_like() {
        let law = EchoLaw::default();
        let body = |k: usize| size::CLASSES[k].0;
        let like = |body: &Body| size::plot_variance_m2(body.length_m, body.span_m);
        let of = |k: usize| law.across_of_unknown_m(like(&body(k)), 400.0);
        let known = |k: usize| law.across_m(Some(&body(k)));
        // Car, truck, medium, heavy.
        assert!(of(0) < of(1) && of(1) < of(4) && of(4) < of(5));
        for k in [1, 4, 5] {
            assert!((0.6..1.4).contains(&(of(k) / known(k))), "{k}: {} {}", of(k), known(k));
        }
        assert_eq!(EchoLaw::POINT.across_m(None), 0.0);
        assert!(law.across_of_unknown_m(f64::NAN, 10.0).is_finite());
    }

    /// The half extent that one number stands for leads to the offset that both lead to, whatever is seen.
    #[test]
    fn one_number_for_both_extents_is_the_same_offset() {
        let law = EchoLaw::default();
        for kappa in [law.aircraft, law.vehicle] {
            for seen in [(0.0, 8.0), (19.0, 0.0), (11.0, 5.0)] {
                let joint = kappa.length * kappa.joint_half_extent_m(seen);
                assert!((joint - kappa.offset_m(seen)).abs() < 1e-12, "{seen:?}");
            }
        }
    }

    /// What plain profiles publish of an echo's near side is what the law of echoes has for a body that wanders so.
    #[test]
    fn the_near_side_of_what_wanders_is_that_of_such_a_body() {
        for variance_m2 in [0.5, 2.0, 7.0, 18.0] {
            let side_m = size::diagonal_m(variance_m2) / std::f64::consts::SQRT_2;
            let body = Body { vehicle: false, length_m: side_m, span_m: side_m };
            let law = EchoLaw::default();
            let (mean_m, _) = law.aircraft.mean_offset_m(&body);
            let found = size::near_side_m2(Some(variance_m2));
            assert!(
                (found / (mean_m * mean_m) - 1.0).abs() < 0.01,
                "{variance_m2}: {found} {mean_m}"
            );
        }
        assert!((size::near_side_m2(None).sqrt() - EchoLaw::default().unknown_m.0).abs() < 0.01);
    }

    /// Of which heading nothing is known, its near side lies off by what all headings make of it.
    #[test]
    fn a_heading_that_is_not_known_is_in_what_is_stated_of_the_near_side() {
        let law = EchoLaw::default();
        let axis = Vector2::new(0.0, 1.0);
        let (heavy, _) = size::CLASSES[5];
        let seen_m2 = 4.0 * size::plot_variance_m2(heavy.length_m, heavy.span_m);
        let (mean, sigma) = law.offset_of_unknown_m(seen_m2, 1e4, None, axis);
        let (wanted, own) = law.aircraft.mean_offset_m(&heavy);
        assert!((mean - wanted).abs() < 0.05, "{mean} {wanted}");
        assert!((sigma - libm::hypot(own, law.residual_m)).abs() < 0.02, "{sigma} {own}");
    }
}
