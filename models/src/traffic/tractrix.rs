//! Across the way: the main gear is drawn behind the point that follows the line.
//!
//! Slip `δ` = direction of the path − heading at the guided point; `dδ/ds = κ(s) − sin δ/ℓ`, `ℓ` from the
//! guided point to the main gear. Source: `docs/traffic.md`; the tractrix of line and circle.

use crate::frames::wrap_pi;

/// Slip after `s_m` of straight way, from `slip_rad`: `tan(δ/2) = tan(δ₀/2) e^(−s/ℓ)`, in the form of
/// `atan2` so that it holds at 180°.
#[must_use]
pub fn slip_on_straight_rad(slip_rad: f64, s_m: f64, wheelbase_m: f64) -> f64 {
    let (sin, cos) = libm::sincos(0.5 * slip_rad);
    2.0 * libm::atan2(sin * libm::exp(-s_m / wheelbase_m), cos)
}

/// Slip after `s_m` of an arc of radius `radius_m` that begins with slip 0; `k = R/ℓ`, `t = tan(δ/2)`.
///
/// `k > 1`: `t = r (1 − E)/(1 − r² E)`, `E = e^(−√(k²−1) s/R)`, `r = 1/(k + √(k²−1))`; towards the steady
/// `sin δ = ℓ/R`. `k < 1`: `t = tan θ/(w + k tan θ)`, `w = √(1−k²)`, `θ = w s/(2R)`: no steady state.
/// `|k − 1| < 1e-9`: their common limit `t = x/(1 + x)`, `x = s/(2R)`.
#[must_use]
pub fn slip_on_arc_rad(s_m: f64, radius_m: f64, wheelbase_m: f64) -> f64 {
    let k = radius_m / wheelbase_m;
    if (k - 1.0).abs() < 1e-9 {
        let x = s_m / (2.0 * radius_m);
        return 2.0 * libm::atan(x / (1.0 + x));
    }
    if k > 1.0 {
        let root = ((k - 1.0) * (k + 1.0)).sqrt();
        let r = 1.0 / (k + root);
        let exponent = -root * s_m / radius_m;
        let (e, less) = (libm::exp(exponent), -libm::expm1(exponent));
        return 2.0 * libm::atan(r * less / (1.0 - r * r * e));
    }
    let w = ((1.0 - k) * (1.0 + k)).sqrt();
    let (sin, cos) = libm::sincos(w * s_m / (2.0 * radius_m));
    2.0 * libm::atan2(sin, w * cos + k * sin)
}

/// How far inside the arc the main gear runs, m: `R − √((R − ℓ sin δ)² + ℓ² cos² δ)`.
#[must_use]
pub fn cut_in_m(slip_rad: f64, radius_m: f64, wheelbase_m: f64) -> f64 {
    let (sin, cos) = libm::sincos(slip_rad);
    radius_m - libm::hypot(radius_m - wheelbase_m * sin, wheelbase_m * cos)
}

/// Offset of the main gear from a straight way, m: `ℓ sin δ`.
#[must_use]
pub fn lag_m(slip_rad: f64, wheelbase_m: f64) -> f64 {
    wheelbase_m * libm::sin(slip_rad)
}

/// One step of `ds_m` along a way of curvature `curvature_per_m` (midpoint rule, error of third order).
#[must_use]
pub fn stepped_slip_rad(slip_rad: f64, curvature_per_m: f64, ds_m: f64, wheelbase_m: f64) -> f64 {
    let rate = |slip: f64| curvature_per_m - libm::sin(slip) / wheelbase_m;
    let middle = slip_rad + 0.5 * ds_m * rate(slip_rad);
    slip_rad + ds_m * rate(middle)
}

/// Over `way_m` of a way whose direction is known by the place from its begin, rad: in steps no longer than the body, beyond twice
/// which [`stepped_slip_rad`] throws it about, each of the bend that there is between its ends.
#[must_use]
pub fn drawn_slip_rad(
    slip_rad: f64,
    way_m: f64,
    wheelbase_m: f64,
    heading_rad: impl Fn(f64) -> f64,
) -> f64 {
    let steps = (way_m / wheelbase_m).ceil().max(1.0);
    let ds_m = way_m / steps;
    let mut before = heading_rad(0.0);
    (1..=steps as u32).fold(slip_rad, |slip, k| {
        let after = heading_rad(f64::from(k) * ds_m);
        let bend_rad = wrap_pi(after - std::mem::replace(&mut before, after));
        stepped_slip_rad(slip, bend_rad / ds_m, ds_m, wheelbase_m)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_are_the_limit_of_the_stepped_one() {
        for (radius_m, wheelbase_m) in [(45.0, 12.6), (30.0, 30.0), (30.0, 30.00001), (20.0, 31.0)]
        {
            let mut slip = 0.0;
            for _ in 0..4000 {
                slip = stepped_slip_rad(slip, 1.0 / radius_m, 0.01, wheelbase_m);
            }
            let closed = slip_on_arc_rad(40.0, radius_m, wheelbase_m);
            assert!((slip - closed).abs() < 1e-7, "{radius_m} {wheelbase_m}: {slip} {closed}");
            for _ in 0..4000 {
                slip = stepped_slip_rad(slip, 0.0, 0.01, wheelbase_m);
            }
            let closed = slip_on_straight_rad(closed, 40.0, wheelbase_m);
            assert!((slip - closed).abs() < 1e-7, "straight after {radius_m}");
        }
    }

    /// A frame of a second at 80 m/s is 47 bodies of a light aircraft: it took off backwards.
    #[test]
    fn however_long_the_step_a_body_follows() {
        for (way_m, wheelbase_m) in [(80.0, 1.7), (17.0, 5.6), (90.0, 12.6), (400.0, 31.0)] {
            let mut slip = 0.4;
            for _ in 0..3 {
                slip = drawn_slip_rad(slip, way_m, wheelbase_m, |_| 1.0);
            }
            let closed = slip_on_straight_rad(0.4, 3.0 * way_m, wheelbase_m);
            assert!((slip - closed).abs() < 1e-3, "{way_m} m, {wheelbase_m} m: {slip}");
            // Where the line bends shorter than the step, too.
            let slip = drawn_slip_rad(0.0, way_m, wheelbase_m, |s| 0.02 * s.min(30.0));
            let on_arc = slip_on_arc_rad(way_m.min(30.0), 50.0, wheelbase_m);
            let closed = slip_on_straight_rad(on_arc, (way_m - 30.0).max(0.0), wheelbase_m);
            assert!((slip - closed).abs() < 0.03, "{way_m} m, {wheelbase_m} m: {slip} {closed}");
        }
    }

    #[test]
    fn a_slip_of_half_a_turn_is_finite() {
        let slip = slip_on_straight_rad(std::f64::consts::PI, 10.0, 12.0);
        assert!(slip.is_finite() && slip > 3.0);
    }
}
