//! Between truth in the airport frame and Entity State PDUs in world coordinates.

use super::dis_types;
use geodesy::{Attitude, Ecef, Enu, Euler, LocalFrame};
use models::frames::{Point3, Vector3};
use models::sensors::TargetState;
use models::truth::TruthState;
use pdu::EntityState;
use pdu::dead_reckoning::{Estimate, Motion};
use pdu::enumerations::{DeadReckoningAlgorithm, ForceId};
use pdu::exercise::Transponder;
use pdu::records::{EntityId, Marking, Vector32};
use scenarios::{Entity, Scene};

/// Appearance bit of a platform that leaves the exercise (bit 23, "state": deactivated).
const DEACTIVATED: u32 = 1 << 23;

/// Appearance bit of a platform that stands because time does (bit 21).
const FROZEN: u32 = 1 << 21;

/// A target lower than this has its weight on its wheels, m above the aerodrome reference.
const ON_GROUND_BELOW_M: f64 = 15.0;

/// The PDU's body for a mover.
#[must_use]
pub fn state_pdu(
    entity: &Entity,
    truth: &TruthState,
    still: bool,
    scene: &Scene,
) -> EntityState<'static> {
    let frame = &scene.airport.frame;
    let (at, orientation) = world_pose(truth, frame);
    let world = |v: Vector3<f64>| frame.vector_to_ecef([v.x, v.y, v.z]);
    let algorithm = if still { 1 } else { scene.run.dead_reckoning.algorithm };
    let rate = truth.angular_rate_rads;
    EntityState {
        entity_id: EntityId::new(scene.run.site, entity.application, entity.number),
        force_id: ForceId(0),
        entity_type: dis_types::of_class(&entity.class),
        linear_velocity_mps: Vector32::from_f64(world(truth.velocity_mps)),
        location: at.into(),
        orientation: orientation.into(),
        dead_reckoning_algorithm: DeadReckoningAlgorithm(algorithm),
        linear_acceleration_mps2: Vector32::from_f64(world(truth.acceleration_ms2)),
        angular_velocity_rad_s: Vector32::from_f64([rate.x, rate.y, rate.z]),
        marking: Marking::new(entity.callsign.as_str())
            .expect("the scene accepts call signs of at most 11 ASCII characters"),
        ..EntityState::default()
    }
}

/// What the transponder of a mover says, where it has an address or has failed (`on` is false): Mode S with the call
/// sign.
#[must_use]
pub fn transponder(entity: &Entity, truth: &TruthState, on: bool) -> Option<Transponder> {
    if entity.address.is_none() && on {
        return None;
    }
    Some(Transponder {
        on,
        address: entity.address,
        identification: Some(Transponder::identification_of(entity.callsign.as_str())),
        on_ground: Some(truth.position_m.z < ON_GROUND_BELOW_M),
        ..Transponder::default()
    })
}

/// Location and orientation in world axes. Headings of the truth count from the airport's north.
#[must_use]
pub fn world_pose(truth: &TruthState, frame: &LocalFrame) -> (Ecef, Euler) {
    let p = truth.position_m;
    let attitude = Attitude {
        heading_rad: truth.heading_rad,
        pitch_rad: truth.pitch_rad,
        roll_rad: truth.roll_rad,
    };
    (frame.to_ecef(Enu { east_m: p.x, north_m: p.y, up_m: p.z }), frame.euler(attitude))
}

/// The same entity in its last PDU.
#[must_use]
pub fn deactivated(mut state: EntityState<'static>) -> EntityState<'static> {
    state.appearance |= DEACTIVATED;
    state.dead_reckoning_algorithm = DeadReckoningAlgorithm(1);
    state.linear_velocity_mps = Vector32::default();
    state.linear_acceleration_mps2 = Vector32::default();
    state.angular_velocity_rad_s = Vector32::default();
    state
}

/// The same entity while time stands, at the place where it is: nobody is to move it on. With `over` it leaves with the run.
///
/// Bit 21 is in no PDU of a frame: by it, what is told aside is known again.
#[must_use]
pub fn frozen(state: EntityState<'static>, over: bool) -> EntityState<'static> {
    let mut state = EntityState { appearance: state.appearance | FROZEN, ..state };
    if over {
        state.appearance |= DEACTIVATED;
    }
    state.dead_reckoning_algorithm = DeadReckoningAlgorithm(1);
    state.linear_velocity_mps = Vector32::default();
    state.linear_acceleration_mps2 = Vector32::default();
    state.angular_velocity_rad_s = Vector32::default();
    state
}

/// Whether a PDU of ours was told beside the frames, while time stood or at the end.
#[must_use]
pub fn is_frozen(state: &EntityState<'_>) -> bool {
    state.appearance & FROZEN != 0
}

/// Whether a PDU says that its entity has left.
#[must_use]
pub fn is_deactivated(state: &EntityState<'_>) -> bool {
    state.appearance & DEACTIVATED != 0
}

/// What receivers believe of an entity from one PDU, by dead reckoning.
#[derive(Clone, Debug)]
pub struct Reckoned {
    motion: Motion,
}

impl Reckoned {
    /// From a PDU as receivers decode it.
    #[must_use]
    pub fn new(state: &EntityState<'_>) -> Self {
        Self { motion: Motion::from(state) }
    }

    /// State in the airport frame, `elapsed_s` after the PDU's time.
    #[must_use]
    pub fn at(&self, elapsed_s: f64, frame: &LocalFrame) -> TargetState {
        target_state(&self.motion.after(elapsed_s), frame)
    }
}

/// A dead-reckoned state in the airport frame.
#[must_use]
pub fn target_state(estimate: &Estimate, frame: &LocalFrame) -> TargetState {
    let enu = frame.to_enu(estimate.location);
    let velocity = frame.vector_to_enu(estimate.velocity_mps);
    TargetState {
        position_m: Point3::new(enu.east_m, enu.north_m, enu.up_m),
        velocity_mps: Vector3::from(velocity),
        heading_rad: frame.attitude(estimate.orientation()).heading_rad,
    }
}
