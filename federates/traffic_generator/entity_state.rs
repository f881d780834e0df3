//! Between truth in the airport frame and Entity State PDUs in world coordinates.

use geodesy::{Attitude, Ecef, Enu, Euler, LocalFrame};
use models::frames::Vector3;
use models::sensors::TargetState;
use models::truth::TruthState;
use pdu::EntityState;
use pdu::dead_reckoning::Motion;
use pdu::enumerations::{DeadReckoningAlgorithm, ForceId};
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use scenarios::{Entity, Scene};

/// Appearance bit of a platform that leaves the exercise (bit 23, "state": deactivated).
const DEACTIVATED: u32 = 1 << 23;

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
        entity_type: entity_type(entity),
        linear_velocity_mps: Vector32::from_f64(world(truth.velocity_ms)),
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

/// Whether a PDU says that its entity has left.
#[must_use]
pub fn is_deactivated(state: &EntityState<'_>) -> bool {
    state.appearance & DEACTIVATED != 0
}

/// Platform types by size: civil fixed-wing aircraft by weight class, land vehicles as utility trucks.
fn entity_type(entity: &Entity) -> EntityType {
    const PLATFORM: u8 = 1;
    const LAND: u8 = 1;
    const AIR: u8 = 2;
    let class = &entity.class;
    if !class.aircraft {
        let category = match class.designator.as_str() {
            "FOLLOWME" => 81, // single unit car
            "BUS" => 85,
            "FIRE" | "SNOW" => 83, // single unit utility or emergency truck
            _ => 82,               // single unit cargo truck
        };
        return EntityType::new(PLATFORM, LAND, 0, category, 0, 0, 0);
    }
    // Light below 20 m of span, then medium, large and heavy fixed wing.
    let category = match class.span_m {
        s if s < 20.0 => 85,
        s if s < 29.0 => 86,
        s if s < 52.0 => 87,
        _ => 88,
    };
    EntityType::new(PLATFORM, AIR, 0, category, 0, 0, 0)
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
        let estimate = self.motion.after(elapsed_s);
        let enu = frame.to_enu(estimate.location);
        let velocity = frame.vector_to_enu(estimate.velocity_mps);
        TargetState {
            position_m: Vector3::new(enu.east_m, enu.north_m, enu.up_m),
            velocity_ms: Vector3::from(velocity),
            heading_rad: frame.attitude(estimate.orientation()).heading_rad,
        }
    }
}
