//! The vehicle of a failure `vehicle_on_runway`: straight over the grass across a runway, with a stay on its centreline.

use crate::frames::{Azimuth, Point2, Point3, Vector2, Vector3};
use crate::truth::TruthState;

/// A vehicle that drives straight across a runway, with a stay on its centreline.
#[derive(Clone, Debug)]
pub(super) struct Car {
    pub(super) runway: usize,
    from_m: Point2<f64>,
    along: Vector2<f64>,
    half_m: f64,
    pub(super) start_s: f64,
    stay_s: f64,
}

/// Speed and acceleration of the vehicle.
const CAR_MPS: f64 = 8.5;
const CAR_MPS2: f64 = 1.0;
/// Begin and end of its way beside the centreline, m (assumed).
const CAR_HALF_M: f64 = 170.0;
/// From its middle to its front bumper, m.
const CAR_FRONT_M: f64 = 2.3;

impl Car {
    /// Across runway `runway` at a place of its centreline, m, from a side (unit vector); stands on the centreline for `stay_s`.
    pub(super) fn across(
        runway: usize,
        centre_m: Point2<f64>,
        side: Vector2<f64>,
        start_s: f64,
        stay_s: f64,
    ) -> Self {
        let (from_m, along) = (Self::begin_m(centre_m, side), -side);
        Self { runway, from_m, along, half_m: CAR_HALF_M, start_s, stay_s }
    }

    /// Where it begins, m.
    pub(super) fn begin_m(centre_m: Point2<f64>, side: Vector2<f64>) -> Point2<f64> {
        centre_m + side * CAR_HALF_M
    }

    /// Way until its front is so far from the centreline, m.
    pub(super) fn way_to_m(off_m: f64) -> f64 {
        CAR_HALF_M - CAR_FRONT_M - off_m
    }

    /// Time of one half of its way: from standing to standing, s.
    fn half_s(&self) -> f64 {
        CAR_MPS / CAR_MPS2 + self.half_m / CAR_MPS
    }

    /// Time from its begin to a place of its first half, s.
    pub(super) fn time_to_s(&self, place_m: f64) -> f64 {
        let ramp_m = 0.5 * CAR_MPS * CAR_MPS / CAR_MPS2;
        if place_m <= ramp_m {
            return (2.0 * place_m.max(0.0) / CAR_MPS2).sqrt();
        }
        let steady_m = (place_m.min(self.half_m) - ramp_m).min(self.half_m - 2.0 * ramp_m);
        CAR_MPS / CAR_MPS2 + steady_m / CAR_MPS
    }

    /// When it is gone, s.
    pub(super) fn end_s(&self) -> f64 {
        self.start_s + 2.0 * self.half_s() + self.stay_s
    }

    /// Distance, speed and acceleration on one half, `t` after its begin.
    fn on_half(&self, t: f64) -> (f64, f64, f64) {
        let (ramp, whole) = (CAR_MPS / CAR_MPS2, self.half_s());
        if t <= 0.0 {
            (0.0, 0.0, 0.0)
        } else if t < ramp {
            (0.5 * CAR_MPS2 * t * t, CAR_MPS2 * t, CAR_MPS2)
        } else if t < whole - ramp {
            (0.5 * CAR_MPS * ramp + CAR_MPS * (t - ramp), CAR_MPS, 0.0)
        } else if t < whole {
            let left = whole - t;
            (self.half_m - 0.5 * CAR_MPS2 * left * left, CAR_MPS2 * left, -CAR_MPS2)
        } else {
            (self.half_m, 0.0, 0.0)
        }
    }

    /// Distance from its begin, m, speed and acceleration.
    pub(super) fn place(&self, now: f64) -> (f64, f64, f64) {
        let t = now - self.start_s;
        let second = t - self.half_s() - self.stay_s;
        if second <= 0.0 {
            return self.on_half(t);
        }
        let (d, v, a) = self.on_half(second);
        (self.half_m + d, v, a)
    }

    /// Its state; none before its begin and after its end.
    pub(super) fn state(&self, now: f64) -> Option<TruthState> {
        if now < self.start_s || now > self.end_s() {
            return None;
        }
        let (d, v, a) = self.place(now);
        let (p, u) = (self.from_m + self.along * d, self.along);
        Some(TruthState {
            position_m: Point3::new(p.x, p.y, 0.0),
            velocity_mps: Vector3::new(u.x * v, u.y * v, 0.0),
            acceleration_ms2: Vector3::new(u.x * a, u.y * a, 0.0),
            heading_rad: Azimuth::of(u).rad(),
            pitch_rad: 0.0,
            roll_rad: 0.0,
            angular_rate_rads: Vector3::zeros(),
        })
    }
}
