//! What is seen of a core: states of its movers, and its digest.

use super::departure::push_heading;
use super::technical_error::{BODY_M, Off, Wander};
use super::{Core, FINAL_M, Phase};
use crate::frames::{Azimuth, Point3, Vector3, wrap_pi};
use crate::truth::TruthState;

impl Core {
    /// State of a flight at the frame executed last; `None` while it is not in the run.
    #[must_use]
    pub fn state(&self, flight: usize) -> Option<TruthState> {
        if let Some(vehicle) = flight.checked_sub(self.movers.len()) {
            let cars = self.cars();
            return match vehicle.checked_sub(cars) {
                Some(driven) => self.hand_state(driven),
                None => self.car_state(vehicle),
            };
        }
        let m = self.movers.get(flight)?;
        if let Some(hand) = &m.hand {
            return Some(hand.state());
        }
        let f = &self.flights[flight];
        let guided = 0.4 * f.size.length_m;
        let gear = guided - f.wheelbase_m;
        let far = m.phase == Phase::Final && m.threshold - m.s > FINAL_M + 1.0;
        if far || matches!(m.phase, Phase::Absent | Phase::Gone) {
            return None;
        }
        let pushing = m.phase == Phase::Pushing;
        let stands_on = if pushing { &m.push } else { &m.way };
        if m.phase == Phase::Parked || stands_on.pieces.is_empty() {
            // On its stand, whatever is planned.
            let (at, heading_rad) = self.stand_pose(m.stand, f.size);
            let at = at - Azimuth::from_rad(heading_rad).unit() * m.stands_short_m;
            let back_rad = if m.turned { std::f64::consts::PI } else { 0.0 };
            let heading_rad = wrap_pi(heading_rad + back_rad);
            return Some(still(Point3::new(at.x, at.y, 0.0), heading_rad));
        }
        let on = stands_on.path.at(m.s);
        let (heading, turn_rate, along, push) = if pushing {
            let (heading, rate_per_m) = push_heading(&m.push.path, m.s);
            (heading, m.v * rate_per_m, -m.v, true)
        } else {
            let heading = wrap_pi(on.heading_rad - m.slip + libm::atan(m.wander.slope));
            let cos = libm::cos(m.slip);
            let rate = m.v * (libm::sin(m.slip) / f.wheelbase_m + m.wander.bend_per_m);
            (heading, rate, m.v * cos, false)
        };
        let (sin, cos) = libm::sincos(heading);
        let (u, n) = (nalgebra::Vector2::new(sin, cos), nalgebra::Vector2::new(cos, -sin));
        let middle = if push { on.at_m - u * gear } else { on.at_m - u * guided };
        let (beside, drift) = if push { Default::default() } else { m.beside() };
        let middle = middle + beside;
        let off = match (&m.join, m.phase) {
            (Some(join), _) => {
                let ((aside, aside_mps), (above, above_mps)) = join.at(self.time_s);
                Off { aside: [aside, aside_mps, 0.0], above: [above, above_mps, 0.0] }
            }
            (None, Phase::Final | Phase::GoAround) => m.approach.at(m.threshold - m.s, m.v),
            _ => Off::default(),
        };
        let ([aside, aside_mps, aside_ms2], [above, above_mps, above_ms2]) = (off.aside, off.above);
        let wander = if push { Wander::default() } else { m.wander };
        let beside_rad = on.heading_rad - wander.behind_rad;
        let forth = Azimuth::from_rad(beside_rad).unit();
        let right = nalgebra::Vector2::new(forth.y, -forth.x);
        let middle = middle + n * aside + right * wander.aside_m;
        // The guided point goes along its line, also where the body is not yet in it.
        let ahead_mps = Azimuth::from_rad(on.heading_rad).unit() * m.v;
        let lever = if push { gear } else { guided };
        let wander_mps = right * (m.v * wander.slope)
            - forth * (m.v * libm::sin(wander.behind_rad) / BODY_M * wander.aside_m);
        let velocity =
            ahead_mps - n * (lever * turn_rate) + drift * m.v + n * aside_mps + wander_mps;
        let along_acc = if push {
            -m.a
        } else {
            let slip_rate = m.v * (on.curvature - libm::sin(m.slip) / f.wheelbase_m);
            m.a * libm::cos(m.slip) - m.v * libm::sin(m.slip) * slip_rate
        };
        let acceleration =
            u * (along_acc + gear * turn_rate * turn_rate) + n * (along * turn_rate + aside_ms2);
        let still = m.v == 0.0 && m.a == 0.0;
        let zero = nalgebra::Vector2::zeros();
        let (velocity, acceleration) = if still { (zero, zero) } else { (velocity, acceleration) };
        let climb_mps = m.climb_mps + above_mps;
        // In the air the nose is where it flies to.
        let (heading_rad, rate_rads) = match m.phase {
            Phase::Final | Phase::GoAround => {
                (Azimuth::of(velocity).rad(), aside_ms2 / velocity.norm().max(1.0))
            }
            _ => (heading, turn_rate),
        };
        let pitch_rad =
            if m.height_m > 0.0 && m.v > 1.0 { libm::atan2(climb_mps, m.v) } else { 0.0 };
        Some(TruthState {
            position_m: Point3::new(middle.x, middle.y, m.height_m + above),
            velocity_mps: Vector3::new(velocity.x, velocity.y, if still { 0.0 } else { climb_mps }),
            acceleration_ms2: Vector3::new(acceleration.x, acceleration.y, above_ms2),
            heading_rad,
            pitch_rad,
            roll_rad: 0.0,
            angular_rate_rads: Vector3::new(0.0, 0.0, if still { 0.0 } else { rate_rads }),
        })
    }

    /// 64-bit digest of the state (FNV-1a over the bits of every mover).
    #[must_use]
    pub fn digest(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut feed = |value: u64| {
            for octet in value.to_le_bytes() {
                hash = (hash ^ u64::from(octet)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        for m in &self.movers {
            let phase = match m.phase {
                Phase::Absent => 0,
                Phase::Parked => 1,
                Phase::Pushing => 2,
                Phase::Starting(_) => 3,
                Phase::Taxiing => 4,
                Phase::LinedUp(_) => 5,
                Phase::Rolling => 6,
                Phase::Final => 7,
                Phase::GoAround => 8,
                Phase::Landing => 9,
                Phase::Docked => 10,
                Phase::Gone => 11,
            };
            feed(phase);
            feed(m.stand as u64);
            feed((m.first_held as u64) << 32 | m.next as u64);
            let (granted, insisted) = (u64::from(m.granted.bits()), u64::from(m.insisted.bits()));
            feed(insisted << 32 | granted << 1 | u64::from(m.holds));
            let mut errors = m.wander.bits().to_vec();
            if matches!(m.phase, Phase::Final | Phase::GoAround) {
                let off = m.approach.at(m.threshold - m.s, m.v);
                errors.extend([off.aside[0], off.above[0]]);
            }
            [m.s, m.v, m.a, m.slip, m.height_m, m.beside_m.x, m.beside_m.y]
                .iter()
                .chain(&errors)
                .for_each(|x| feed(x.to_bits()));
            if let Some(hand) = &m.hand {
                hand.feed(&mut feed);
            }
            if let Some((stand, _)) = &m.goal {
                feed(*stand as u64);
            }
        }
        self.feed_failures(&mut feed);
        self.feed_hands(&mut feed);
        self.feed_handovers(&mut feed);
        hash
    }
}

fn still(position_m: Point3<f64>, heading_rad: f64) -> TruthState {
    let zero = Vector3::zeros();
    TruthState {
        position_m,
        velocity_mps: zero,
        acceleration_ms2: zero,
        heading_rad,
        pitch_rad: 0.0,
        roll_rad: 0.0,
        angular_rate_rads: zero,
    }
}
