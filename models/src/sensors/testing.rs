//! Truth for the tests of sensors: targets that stand, or roll straight on.

use crate::frames::Vector3;
use crate::plot::Callsign;
use crate::sensors::{TargetClass, TargetState, Truth};
use crate::time::SimTime;

/// Targets on a line, 100 m apart, all with the same velocity.
#[derive(Clone, Debug)]
pub(crate) struct Parked {
    keys: Vec<u64>,
    class: TargetClass,
    /// Velocity of all, m/s.
    pub(crate) velocity_ms: Vector3<f64>,
    /// Heading of all, radians clockwise from north.
    pub(crate) heading_rad: f64,
}

impl Parked {
    /// Aircraft with these keys (sorted), standing, nose east.
    pub(crate) fn aircraft(keys: &[u64]) -> Self {
        let class = TargetClass {
            designator: "A320".into(),
            aircraft: true,
            length_m: 37.6,
            span_m: 35.8,
            height_m: 11.8,
            rcs_m2: 20.0,
        };
        Self {
            keys: keys.to_vec(),
            class,
            velocity_ms: Vector3::zeros(),
            heading_rad: std::f64::consts::FRAC_PI_2,
        }
    }
}

impl Truth for Parked {
    fn len(&self) -> usize {
        self.keys.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.keys[index]
    }
    fn class(&self, _index: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, index: usize) -> Callsign {
        Callsign::new(&format!("T{}", self.keys[index]))
    }
    fn address(&self, index: usize) -> Option<u32> {
        Some(self.keys[index] as u32)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        Some(TargetState {
            position_m: Vector3::new(0.0, self.keys[index] as f64 * 100.0, 0.0)
                + self.velocity_ms * time.s(),
            velocity_ms: self.velocity_ms,
            heading_rad: self.heading_rad,
        })
    }
}
