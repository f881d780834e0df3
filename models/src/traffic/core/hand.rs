//! Movers that a person drives: what comes in is a wish, what it does with it is bounded by the mover's own limits.
//!
//! The point under the front axle is guided, the rear axle is drawn behind it as with every other mover: the body turns by
//! `v sin β / ℓ`, `β` the angle of the front wheels, `ℓ` the wheelbase. Nothing is cleared and no piece is taken for it:
//! it is in the way of the others as recorded movers are, they brake for it when they see it, and whom it touches is told.
//! Rules and their figures: `docs/traffic.md`, "By hand".

use super::{Core, Order};
use crate::airport::inside;
use crate::frames::{Azimuth, Point2, Point3, Vector2, Vector3, wrap_pi};
use crate::traffic::outline::{Size, distance_to_line_m, outline};
use crate::truth::TruthState;
use std::sync::Arc;

/// A mover that can be driven by hand, as a scene has it; it stands until somebody takes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// Its name.
    pub callsign: String,
    /// Size on the ground.
    pub size: Size,
    /// From the front axle to the rear axle, m.
    pub wheelbase_m: f64,
    /// Largest speed, m/s.
    pub most_mps: f64,
    /// Largest acceleration, and usual braking, m/s².
    pub acc_dec_mps2: (f64, f64),
    /// Where its middle stands at first, m east and north.
    pub at_m: Point2<f64>,
    /// Where it looks at first, rad clockwise from north.
    pub heading_rad: f64,
}

/// What a driver wants, in thousandths, so that what is said, written down and read back is the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wish {
    /// −1000 (backwards) to 1000: share of the largest speed.
    pub throttle: i16,
    /// 0 to 1000: half is usual braking, all is hard braking, harder while it is held.
    pub brake: i16,
    /// −1000 (left) to 1000 (right).
    pub steer: i16,
}

/// How a driven mover is at the frame executed last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtWheel {
    /// Somebody has it.
    pub taken: bool,
    /// Place of its middle, m east and north.
    pub at_m: Point2<f64>,
    /// Where it looks, rad clockwise from north.
    pub heading_rad: f64,
    /// Speed, negative backwards, m/s, and its change, m/s².
    pub speed_mps: f64,
    /// Change of the speed along the way, m/s².
    pub acceleration_mps2: f64,
    /// Angle of the front wheels, positive to the right, rad.
    pub steer_rad: f64,
    /// It is beside all pavement.
    pub off_pavement: bool,
    /// Its wish is older than [`SILENT_S`], so that it brakes.
    pub silent: bool,
    /// Whom it touched so far.
    pub contacts: usize,
}

/// Silence after which a driver is taken for gone: no throttle, half the brake, s.
pub const SILENT_S: f64 = 1.0;
/// Largest angle of the front wheels, rad, up to [`SLOW_MPS`]; at [`FAST_MPS`] and above a share of it; its rate, rad/s.
const MOST_STEER_RAD: f64 = 65.0 * core::f64::consts::PI / 180.0;
const SLOW_MPS: f64 = 3.0;
const FAST_MPS: f64 = 15.0;
const FAST_SHARE: f64 = 0.3;
const STEER_RATE_RADPS: f64 = 12.0 * core::f64::consts::PI / 180.0;
/// Wheels are not turned so far that it would be pressed aside by more, m/s² (assumed: a car on a wet road).
const LATERAL_MPS2: f64 = 3.0;
/// Largest speed backwards and beside the pavement, m/s.
const BACKWARDS_MPS: f64 = 3.0;
const OFF_PAVEMENT_MPS: f64 = 3.0;
/// All of the brake, m/s²; the same after it was held for [`HELD_S`].
const HARD_MPS2: f64 = 1.5;
const HARDEST_MPS2: f64 = 3.0;
const HELD_S: f64 = 1.0;
/// Share of usual braking with which it rolls out without throttle and brake (assumed).
const ROLLS_OUT: f64 = 0.3;
/// Largest change of acceleration, m/s³ (assumed: a driver who means it).
const JERK_MPS3: f64 = 2.0;
/// A way of the network is paved so far beside its line, m; looked at each that many seconds.
const PAVED_BESIDE_M: f64 = 15.0;
const LOOKS_EVERY_S: f64 = 0.25;
/// Longest stop that is looked ahead at, s, and the step of that.
const MOST_STOP_S: f64 = 20.0;
const STOP_STEP_S: f64 = 0.25;

/// State of a driven mover.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hand {
    pub(super) of: Arc<Driven>,
    pub(super) taken: bool,
    pub(super) wish: Wish,
    heard_s: f64,
    /// Since when all of the brake is held, s of simulated time.
    held_since_s: Option<f64>,
    /// The guided point, m.
    pub(super) nose_m: Point2<f64>,
    pub(super) heading_rad: f64,
    pub(super) v: f64,
    pub(super) a: f64,
    pub(super) backwards: bool,
    pub(super) steer_rad: f64,
    steer_rate_radps: f64,
    pub(super) off_pavement: bool,
    pub(super) contacts: usize,
    /// Of a flight: it is beside its way, or beyond what it may; since when it stands there without a driver, s.
    pub(super) beside: bool,
    pub(super) left_s: Option<f64>,
    /// Of a flight that is given back: where its wheels turn to, rad.
    pub(super) guided_rad: Option<f64>,
}

impl Hand {
    pub(super) fn new(of: Driven) -> Self {
        let heading_rad = wrap_pi(of.heading_rad);
        let nose_m = of.at_m + Azimuth::from_rad(heading_rad).unit() * (0.4 * of.size.length_m);
        Self {
            of: Arc::new(of),
            taken: false,
            wish: Wish::default(),
            heard_s: f64::NEG_INFINITY,
            held_since_s: None,
            nose_m,
            heading_rad,
            v: 0.0,
            a: 0.0,
            backwards: false,
            steer_rad: 0.0,
            steer_rate_radps: 0.0,
            off_pavement: false,
            contacts: 0,
            beside: false,
            left_s: None,
            guided_rad: None,
        }
    }

    fn silent(&self, now_s: f64) -> bool {
        !self.taken || now_s - self.heard_s > SILENT_S
    }

    pub(super) fn middle_m(&self) -> Point2<f64> {
        self.nose_m - Azimuth::from_rad(self.heading_rad).unit() * (0.4 * self.of.size.length_m)
    }

    /// Largest angle of the wheels at the present speed, rad.
    fn most_steer_rad(&self) -> f64 {
        let share = ((self.v - SLOW_MPS) / (FAST_MPS - SLOW_MPS)).clamp(0.0, 1.0);
        let most = MOST_STEER_RAD * (1.0 - (1.0 - FAST_SHARE) * share);
        let sin = LATERAL_MPS2 * self.of.wheelbase_m / (self.v * self.v).max(1e-9);
        if sin < 1.0 { most.min(libm::asin(sin)) } else { most }
    }

    /// Braking that a brake pedal asks for, m/s².
    fn braking_mps2(&self, brake: i16, now_s: f64) -> f64 {
        let usual = self.of.acc_dec_mps2.1;
        let share = f64::from(brake) / 1000.0;
        if share <= 0.5 {
            return 2.0 * share * usual;
        }
        let held_s = self.held_since_s.map_or(0.0, |since| now_s - since);
        let most = if held_s > HELD_S { HARDEST_MPS2 } else { HARD_MPS2 };
        usual + 2.0 * (share - 0.5) * (most - usual).max(0.0)
    }

    /// One step of `dt` seconds that ends at `now_s`.
    pub(super) fn step(&mut self, now_s: f64, dt: f64) {
        let silent = self.silent(now_s);
        let wish = if silent { Wish { throttle: 0, brake: 500, steer: 0 } } else { self.wish };
        self.held_since_s = (wish.brake >= 1000).then(|| self.held_since_s.unwrap_or(now_s));
        let standing = self.v == 0.0;
        if standing && wish.throttle != 0 {
            self.backwards = wish.throttle < 0 && !self.of.size.aircraft;
        }
        let against = (wish.throttle < 0) != self.backwards && wish.throttle != 0;
        let most = if self.backwards { BACKWARDS_MPS } else { self.of.most_mps };
        let most = if self.off_pavement { most.min(OFF_PAVEMENT_MPS) } else { most };
        let share = f64::from(wish.throttle).abs() / 1000.0;
        let wished = if against || wish.brake > 0 { 0.0 } else { share * most };
        let (acc, usual) = self.of.acc_dec_mps2;
        let soft = match (against, self.v > most) {
            (true, _) | (_, true) => usual,
            _ if wish.throttle != 0 => usual,
            _ => ROLLS_OUT * usual,
        };
        let error = wished - self.v;
        let half = 0.5 * JERK_MPS3 * dt;
        let reach = |e: f64| ((half * half + 2.0 * JERK_MPS3 * e).sqrt() - half).max(0.0);
        let want = if wish.brake > 0 {
            -self.braking_mps2(wish.brake, now_s)
        } else if error >= 0.0 {
            reach(error).min(acc)
        } else {
            -reach(-error).min(soft)
        };
        let (v, a) = (self.v, self.a);
        let next = want.clamp(a - JERK_MPS3 * dt, a + JERK_MPS3 * dt);
        let then = v + 0.5 * (a + next) * dt;
        let stands = then <= 0.0 || v == 0.0 && wished == 0.0;
        (self.v, self.a) = if stands { (0.0, 0.0) } else { (then, next) };
        let moved_m = if v == 0.0 && stands { 0.0 } else { 0.5 * (v + self.v) * dt };

        let target = f64::from(wish.steer) / 1000.0 * self.most_steer_rad();
        let target = if silent { self.guided_rad.unwrap_or(self.steer_rad) } else { target };
        let turned = STEER_RATE_RADPS * dt;
        let before = self.steer_rad;
        let most_rad = self.most_steer_rad();
        self.steer_rad = target.clamp(before - turned, before + turned).clamp(-most_rad, most_rad);
        self.steer_rate_radps = (self.steer_rad - before) / dt;
        if moved_m == 0.0 {
            return;
        }
        let signed_m = if self.backwards { -moved_m } else { moved_m };
        let steer = 0.5 * (before + self.steer_rad);
        let turn = signed_m * libm::sin(steer) / self.of.wheelbase_m;
        let along = Azimuth::from_rad(self.heading_rad + 0.5 * turn + steer).unit();
        self.nose_m += along * signed_m;
        self.heading_rad = wrap_pi(self.heading_rad + turn);
    }

    /// Where it will be while it comes to a stand with usual braking: seconds from now, middle, heading; now first.
    pub(super) fn stopping(&self) -> Vec<(f64, Point2<f64>, f64)> {
        let mut then = self.clone();
        then.taken = false;
        let mut way = vec![(0.0, then.middle_m(), then.heading_rad)];
        let mut after_s = 0.0;
        while then.v > 0.0 && after_s < MOST_STOP_S {
            after_s += STOP_STEP_S;
            then.step(0.0, STOP_STEP_S);
            let far = way.last().is_none_or(|(_, at, _)| {
                (then.middle_m() - at).norm() > 0.4 * then.of.size.length_m
            });
            if far || then.v == 0.0 {
                way.push((after_s, then.middle_m(), then.heading_rad));
            }
        }
        way
    }

    pub(super) fn feed(&self, feed: &mut dyn FnMut(u64)) {
        let Wish { throttle, brake, steer } = self.wish;
        feed(u64::from(self.taken) | u64::from(self.backwards) << 1);
        [throttle, brake, steer].iter().for_each(|x| feed(*x as u64));
        [self.nose_m.x, self.nose_m.y, self.heading_rad, self.v, self.a, self.steer_rad]
            .iter()
            .for_each(|x| feed(x.to_bits()));
    }

    /// What a driver says; `now_s`: when it is heard.
    pub(super) fn told(&mut self, order: Order, now_s: f64) {
        match order {
            Order::Take => {
                (self.taken, self.wish, self.heard_s) = (true, Wish::default(), now_s);
            }
            Order::Leave => (self.taken, self.wish) = (false, Wish::default()),
            Order::Drive(wish) => {
                self.wish = Wish {
                    throttle: wish.throttle.clamp(-1000, 1000),
                    brake: wish.brake.clamp(0, 1000),
                    steer: wish.steer.clamp(-1000, 1000),
                };
                self.heard_s = now_s;
            }
            _ => {}
        }
    }

    pub(super) fn at_wheel(&self, now_s: f64) -> AtWheel {
        let sign = if self.backwards { -1.0 } else { 1.0 };
        AtWheel {
            taken: self.taken,
            at_m: self.middle_m(),
            heading_rad: self.heading_rad,
            speed_mps: sign * self.v,
            acceleration_mps2: sign * self.a,
            steer_rad: self.steer_rad,
            off_pavement: self.off_pavement,
            silent: self.silent(now_s),
            contacts: self.contacts,
        }
    }

    pub(super) fn state(&self) -> TruthState {
        let gear = 0.4 * self.of.size.length_m - self.of.wheelbase_m;
        let v = if self.backwards { -self.v } else { self.v };
        let along_a = if self.backwards { -self.a } else { self.a };
        let (sin_b, cos_b) = libm::sincos(self.steer_rad);
        let turn_rate = v * sin_b / self.of.wheelbase_m;
        let (sin, cos) = libm::sincos(self.heading_rad);
        let (u, n) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
        let along = v * cos_b;
        let still = self.v == 0.0;
        let velocity = u * along - n * (gear * turn_rate);
        let along_a = along_a * cos_b - v * sin_b * self.steer_rate_radps;
        let acceleration = u * (along_a + gear * turn_rate * turn_rate) + n * (along * turn_rate);
        let zero = Vector2::zeros();
        let (velocity, acceleration) = if still { (zero, zero) } else { (velocity, acceleration) };
        let middle = self.middle_m();
        TruthState {
            position_m: Point3::new(middle.x, middle.y, 0.0),
            velocity_mps: Vector3::new(velocity.x, velocity.y, 0.0),
            acceleration_ms2: Vector3::new(acceleration.x, acceleration.y, 0.0),
            heading_rad: self.heading_rad,
            pitch_rad: 0.0,
            roll_rad: 0.0,
            angular_rate_rads: Vector3::new(0.0, 0.0, if still { 0.0 } else { turn_rate }),
        }
    }
}

impl Core {
    /// The same core with movers that people can drive, before its first step; `flights`: people may also take flights that taxi. `pavement_m`: its outlines, not closed.
    #[must_use]
    pub fn with_driven(
        mut self,
        all: &[Driven],
        flights: bool,
        pavement_m: Vec<Vec<Point2<f64>>>,
    ) -> Self {
        self.flights_by_hand = flights;
        if all.is_empty() && !flights {
            return self;
        }
        self.hands = all.iter().cloned().map(Hand::new).collect();
        self.pavement_m = Arc::new(pavement_m);
        self.beside_others();
        self
    }

    /// Index of the first driven mover, counted on from flights and vehicles of failures, for [`Core::state`] and notices.
    #[must_use]
    pub fn first_driven(&self) -> usize {
        self.movers.len() + self.cars()
    }

    /// How driven mover `n` (from 0) is.
    #[must_use]
    pub fn at_wheel(&self, n: usize) -> Option<AtWheel> {
        self.hands.get(n).map(|hand| hand.at_wheel(self.time_s))
    }

    /// The driven movers, in their order.
    #[must_use]
    pub fn driven(&self) -> Vec<&Driven> {
        self.hands.iter().map(|hand| &*hand.of).collect()
    }

    pub(super) fn hand_state(&self, n: usize) -> Option<TruthState> {
        self.hands.get(n).map(Hand::state)
    }

    /// What a driver does; `n` from 0.
    pub(super) fn drive_by_hand(&mut self, n: usize, order: Order) {
        let now = self.time_s;
        if let Some(hand) = self.hands.get_mut(n) {
            hand.told(order, now);
        }
    }

    /// Moves what people drive.
    pub(super) fn move_hands(&mut self) {
        let look = (self.time_s / LOOKS_EVERY_S).fract() < self.step_s / LOOKS_EVERY_S * 0.999;
        for n in 0..self.hands.len() {
            let (now, dt) = (self.time_s, self.step_s);
            self.hands[n].step(now, dt);
            if !look || self.hands[n].v == 0.0 {
                continue;
            }
            let off = !self.is_paved(&self.hands[n]);
            if off && !self.hands[n].off_pavement {
                let name = self.hands[n].of.callsign.clone();
                self.remark(format!("{name} leaves the pavement"));
            }
            self.hands[n].off_pavement = off;
        }
    }

    /// Whether the middle of what is driven is on pavement: an outline, a runway, or beside a way of the network.
    pub(super) fn is_paved(&self, hand: &Hand) -> bool {
        let at = hand.middle_m();
        let on_runway = self.net.runways.iter().any(|r| {
            let (place, across) = r.place_m(at);
            (-60.0..r.length_m + 60.0).contains(&place) && across.abs() < 0.5 * r.width_m
        });
        if on_runway || self.pavement_m.iter().any(|ring| inside(ring, at)) {
            return true;
        }
        let body = outline(hand.of.size, at, hand.heading_rad);
        self.lines_near(at).any(|line| distance_to_line_m(&body, line) < PAVED_BESIDE_M)
    }

    pub(super) fn feed_hands(&self, feed: &mut dyn FnMut(u64)) {
        self.hands.iter().for_each(|hand| hand.feed(feed));
    }
}

#[cfg(test)]
mod tests;
