//! Where surveyed lanes are, for errors of radar sites where no target reports its position.
//!
//! What taxis keeps to the lane: across it a plot less the lane's nearest point is a difference without a reference, of the one direction
//! n that the lane's normal has. Recorded traffic lies a median 1.8 m beside the ground network at hand, in stretches of tens of
//! seconds, and farther in a tenth of the cases: one pair a minute and target, Student-t of three degrees of freedom, scale
//! [`SCALE_M`].
//!
//! Source: Jaramillo, Besada, de Miguel, Casar, "Airport based bias estimation of surface movement radars", IEEE Radar Conference 2005.

use crate::filter::route::Network;
use crate::frames::{Point2, Vector2};

/// A target keeps to a lane while its speed is within these, m/s …
const TAXIING_MPS: std::ops::RangeInclusive<f64> = 3.0..=14.0;
/// … its course off the lane's by less than 15° …
const LEAST_COSINE: f64 = 0.965_925_826_289_068_3;
/// … and it is no farther from it than this, m.
const BESIDE_M: f64 = 12.0;

/// Between two pairs of one target, s: what lies off now lies off still after seconds.
pub(super) const APART_S: f64 = 60.0;

/// Scale of the deviation from lanes, m.
pub(super) const SCALE_M: f64 = 3.0;

/// Degrees of freedom of its law.
const FREEDOM: f64 = 3.0;

/// Unit normal of the nearest lane that a target at this place and velocity keeps to, and how far off it is along that, m.
pub(super) fn beside(
    lanes: &Network,
    place: Point2<f64>,
    velocity_mps: Vector2<f64>,
) -> Option<(Vector2<f64>, f64)> {
    let speed = velocity_mps.norm();
    if !TAXIING_MPS.contains(&speed) {
        return None;
    }
    let mut best: Option<(f64, Vector2<f64>, f64)> = None;
    for edge in lanes.edges.iter().filter(|edge| !edge.route.is_beyond(place, BESIDE_M)) {
        let (s, distance_m) = edge.route.nearest(place);
        // Beyond an end there is no lane to be beside of.
        if !(distance_m <= BESIDE_M && s > 0.0 && s < edge.route.length_m()) {
            continue;
        }
        let at = edge.route.at(s);
        let along = at.along.dot(&velocity_mps).abs() >= LEAST_COSINE * speed;
        if along && best.is_none_or(|(nearest, ..)| distance_m < nearest) {
            // One normal whichever way the lane is driven: which of two edges on one line is nearer is a matter of rounding.
            let normal = at.left();
            let turned = normal.x < 0.0 || (normal.x == 0.0 && normal.y < 0.0);
            let normal = if turned { -normal } else { normal };
            best = Some((distance_m, normal, (place - at.position).dot(&normal)));
        }
    }
    best.map(|(_, normal, off_m)| (normal, off_m))
}

/// Variance of a deviation that is `found_m` off what was foreseen, m²: that of its law and `spread_m2`, the more the farther it is off
/// (one step of the Student-t law's weights).
pub(super) fn variance_m2(found_m: f64, spread_m2: f64) -> f64 {
    let whole = SCALE_M * SCALE_M + spread_m2;
    whole * (FREEDOM + found_m * found_m / whole) / (FREEDOM + 1.0)
}
