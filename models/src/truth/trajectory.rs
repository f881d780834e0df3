//! One movement: a smooth path, progress along it, height over it.

use super::spline::Spline;
use crate::frames::{Azimuth, Point2, Point3, Vector3, wrap_pi};
use crate::time::SimTime;

/// Standard acceleration of gravity, m/s² (ISO 80000-3).
const GRAVITY_MS2: f64 = 9.806_65;
/// Height over which bank grows from none (wheels on the ground) to that of a coordinated turn, m.
const BANK_HEIGHT_M: f64 = 30.0;

/// The true state of one mover at one time. Airport frame, metres, seconds, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthState {
    /// Reference point, m east, north, up.
    pub position_m: Point3<f64>,
    /// Velocity, m/s east, north, up.
    pub velocity_mps: Vector3<f64>,
    /// Acceleration, m/s² east, north, up.
    pub acceleration_ms2: Vector3<f64>,
    /// Where the nose points, clockwise from north, in [−π, π).
    pub heading_rad: f64,
    /// Nose up.
    pub pitch_rad: f64,
    /// Right wing down.
    pub roll_rad: f64,
    /// Angular velocity about the body axes forward, right, down, rad/s.
    pub angular_rate_rads: Vector3<f64>,
}

impl TruthState {
    /// True if it neither moves nor turns.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.velocity_mps == Vector3::zeros() && self.acceleration_ms2 == Vector3::zeros()
    }
}

/// A path driven in one direction. Two legs meet where the mover stands and turns back on its track.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Progress at its begin, m.
    pub from_m: f64,
    /// East and north by progress since `from_m`, m; the derivative is a unit vector within some percent.
    pub path: Spline<2>,
    /// Driven tail first (pushback).
    pub backward: bool,
}

/// A movement from its first to its last moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Time 0 of the splines.
    start: SimTime,
    /// First and last moment.
    first: SimTime,
    end: SimTime,
    /// Paths driven one after the other, in the order of `Leg::from_m`; at least one.
    legs: Vec<Leg>,
    /// Distance along the paths by seconds since `start`, m.
    progress: Spline<1>,
    /// Height by seconds since `start`, m; `None` for movements that stay on the ground.
    height: Option<Spline<1>>,
}

impl Trajectory {
    /// A movement from `start`: `legs` by progress (m), `progress` and `height` by seconds since
    /// `start`; `None` without a leg.
    #[must_use]
    pub fn new(
        start: SimTime,
        end: SimTime,
        legs: Vec<Leg>,
        progress: Spline<1>,
        height: Option<Spline<1>>,
    ) -> Option<Self> {
        (!legs.is_empty()).then_some(Self { start, first: start, end, legs, progress, height })
    }

    /// Somebody who stands from `start` to `end`; `position_m` east and north.
    #[must_use]
    pub fn parked(start: SimTime, end: SimTime, position_m: Point2<f64>, heading_rad: f64) -> Self {
        let ahead = Azimuth::from_rad(heading_rad).unit();
        let line = |metres: f64| (position_m + ahead * metres).into();
        let path = Spline::new(0.0, 1.0, vec![line(-1.0), line(0.0), line(1.0), line(2.0)]);
        let step = end.since_s(start).max(1e-9);
        let progress = Spline::new(0.0, step, vec![[0.0]; 4]);
        let sound = "four finite controls and a positive step";
        let (path, progress) = (path.expect(sound), progress.expect(sound));
        let legs = vec![Leg { from_m: 0.0, path, backward: false }];
        Self { start, first: start, end, legs, progress, height: None }
    }

    /// First moment.
    #[must_use]
    #[expect(clippy::misnamed_getters, reason = "`first` cuts the run-in that `start` counts from")]
    pub fn start(&self) -> SimTime {
        self.first
    }

    /// Last moment.
    #[must_use]
    pub fn end(&self) -> SimTime {
        self.end
    }

    /// Its legs.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// Cuts off what lies outside `from` to `to`.
    #[must_use]
    pub fn cut(mut self, from: SimTime, to: SimTime) -> Self {
        self.first = self.first.max(from);
        self.end = self.end.min(to);
        self
    }

    /// The same movement, begun at another time.
    #[must_use]
    pub fn started_at(mut self, start: SimTime) -> Self {
        let shift = start.0 - self.first.0;
        self.first = start;
        self.start = SimTime(self.start.0 + shift);
        self.end = SimTime(self.end.0 + shift);
        self
    }

    /// True from the first to the last moment.
    #[must_use]
    pub fn within(&self, time: SimTime) -> bool {
        time >= self.first && time <= self.end
    }

    /// Up to when the mover stands exactly as it does at `time`: `time` itself where it moves or is not there.
    #[must_use]
    pub fn rests_until(&self, time: SimTime) -> SimTime {
        if !self.within(time) {
            return time;
        }
        let t = time.since_s(self.start);
        let height = self.height.as_ref().map_or(f64::INFINITY, |height| height.rests_until(t));
        let rests_s = self.progress.rests_until(t).min(height);
        // A microsecond early: times are rounded.
        self.start.plus_s((rests_s - 1e-6).min(1e9)).clamp(time, self.end)
    }

    /// The state at `time`, or `None` before the first or after the last moment.
    #[must_use]
    pub fn at(&self, time: SimTime) -> Option<TruthState> {
        self.within(time).then(|| self.state_s(time.since_s(self.start)))
    }

    /// State by seconds since the start.
    ///
    /// With path `p(s)` and progress `s(t)`: `v = p' ṡ`, `a = p'' ṡ² + p' s̈`; heading is the
    /// direction of `p'`, its rate the curvature times speed. In the air, pitch is the angle of
    /// climb and bank that of a coordinated turn, `tan φ = v ψ̇ / g`.
    fn state_s(&self, t: f64) -> TruthState {
        let s = self.progress.at(t);
        let leg = &self.legs[self.legs.partition_point(|leg| leg.from_m < s.value[0]).max(1) - 1];
        let p = leg.path.at(s.value[0] - leg.from_m);
        let nose = if leg.backward { -1.0 } else { 1.0 };
        let (ds, dds) = (s.first[0], s.second[0]);
        let tangent2 = p.first[0] * p.first[0] + p.first[1] * p.first[1];
        // Clockwise from north: the turn per metre of the parameter.
        let cross = p.second[0] * p.first[1] - p.second[1] * p.first[0];
        let turn = if tangent2 > 0.0 { cross / tangent2 } else { 0.0 };
        let heading_rate = turn * ds;
        let mut state = TruthState {
            position_m: Point3::new(p.value[0], p.value[1], 0.0),
            velocity_mps: Vector3::new(p.first[0] * ds, p.first[1] * ds, 0.0),
            acceleration_ms2: Vector3::new(
                p.second[0] * ds * ds + p.first[0] * dds,
                p.second[1] * ds * ds + p.first[1] * dds,
                0.0,
            ),
            heading_rad: wrap_pi(libm::atan2(nose * p.first[0], nose * p.first[1])),
            pitch_rad: 0.0,
            roll_rad: 0.0,
            angular_rate_rads: Vector3::new(0.0, 0.0, heading_rate),
        };
        if let Some(height) = &self.height {
            let z = height.at(t);
            if z.value[0] != 0.0 || z.first[0] != 0.0 || z.second[0] != 0.0 {
                let turn_slope = {
                    let cross_slope = p.third[0] * p.first[1] - p.third[1] * p.first[0];
                    let dot = p.second[0] * p.first[0] + p.second[1] * p.first[1];
                    (cross_slope - 2.0 * dot * turn) / tangent2
                };
                let heading_acceleration = turn_slope * ds * ds + turn * dds;
                airborne(
                    &mut state,
                    z.value[0],
                    z.first[0],
                    z.second[0],
                    heading_rate,
                    heading_acceleration,
                );
            }
        }
        state
    }
}

/// Adds height, pitch, bank and their rates.
fn airborne(
    state: &mut TruthState,
    height_m: f64,
    climb_mps: f64,
    climb_ms2: f64,
    heading_rate: f64,
    heading_acceleration: f64,
) {
    state.position_m.z = height_m;
    state.velocity_mps.z = climb_mps;
    state.acceleration_ms2.z = climb_ms2;
    let velocity = state.velocity_mps.xy();
    let ground_speed = libm::hypot(velocity.x, velocity.y);
    if ground_speed <= 0.0 {
        return;
    }
    let speed_slope = velocity.dot(&state.acceleration_ms2.xy()) / ground_speed;
    let speed2 = ground_speed * ground_speed + climb_mps * climb_mps;
    let pitch = libm::atan2(climb_mps, ground_speed);
    let pitch_rate = (climb_ms2 * ground_speed - climb_mps * speed_slope) / speed2;
    // Bank blends in with height as 3u² − 2u³.
    let u = (height_m / BANK_HEIGHT_M).clamp(0.0, 1.0);
    let blend = u * u * (3.0 - 2.0 * u);
    let inside = u > 0.0 && u < 1.0;
    let blend_rate = if inside { 6.0 * u * (1.0 - u) * climb_mps / BANK_HEIGHT_M } else { 0.0 };
    let lean = ground_speed * heading_rate / GRAVITY_MS2;
    let lean_rate =
        (speed_slope * heading_rate + ground_speed * heading_acceleration) / GRAVITY_MS2;
    let roll = libm::atan(lean * blend);
    let roll_rate = (lean_rate * blend + lean * blend_rate) / (1.0 + lean * lean * blend * blend);
    let (sin_roll, cos_roll) = libm::sincos(roll);
    let (sin_pitch, cos_pitch) = libm::sincos(pitch);
    state.pitch_rad = pitch;
    state.roll_rad = roll;
    // Euler rates to body rates (Stevens & Lewis, Aircraft Control and Simulation, eq. 1.4-4).
    state.angular_rate_rads = Vector3::new(
        roll_rate - heading_rate * sin_pitch,
        pitch_rate * cos_roll + heading_rate * cos_pitch * sin_roll,
        heading_rate * cos_pitch * cos_roll - pitch_rate * sin_roll,
    );
}
