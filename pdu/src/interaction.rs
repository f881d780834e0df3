//! Collisions, and the warfare PDUs that real traffic holds.

use crate::enumerations::CollisionType;
use crate::records::{EntityId, EntityType, EventId, Location, VariableParameter, Vector32};

record! {
    /// Collision (type 4). Source: IEEE 1278.1-2012, 7.2.3.
    Collision {
        /// Who detected it.
        issuing_entity: EntityId,
        /// With whom.
        colliding_entity: EntityId,
        /// Number of the event.
        event_id: EventId,
        /// Kind.
        collision_type: CollisionType,
        /// Unused.
        padding: u8,
        /// Velocity of the issuing entity, m/s, world axes.
        velocity_mps: Vector32,
        /// Mass of the issuing entity, kg.
        mass_kg: f32,
        /// Where, in the body axes of the colliding entity, metres.
        location_m: Vector32,
    }
}
fixed_body!(Collision = COLLISION);

record! {
    /// Collision-Elastic (type 66). Source: IEEE 1278.1-2012, 7.2.4.
    CollisionElastic {
        /// Who detected it.
        issuing_entity: EntityId,
        /// With whom.
        colliding_entity: EntityId,
        /// Number of the event.
        event_id: EventId,
        /// Unused.
        padding: u16,
        /// Velocity of the contact point, m/s, world axes.
        contact_velocity_mps: Vector32,
        /// Mass of the issuing entity, kg.
        mass_kg: f32,
        /// Where, in the body axes of the issuing entity, metres.
        location_m: Vector32,
        /// Intermediate results xx, xy, xz, yy, yz, zz.
        intermediate_results: [f32; 6],
        /// Normal of the surface, world axes.
        unit_surface_normal: Vector32,
        /// 1 elastic, 0 inelastic.
        coefficient_of_restitution: f32,
    }
}
fixed_body!(CollisionElastic = COLLISION_ELASTIC);

record! {
    /// Descriptor of a munition, an explosion or an expendable. Source: IEEE 1278.1-2012, 6.2.19.
    Descriptor {
        /// Type.
        entity_type: EntityType,
        /// Warhead: SISO-REF-010, UID 60.
        warhead: u16,
        /// Fuse: SISO-REF-010, UID 61.
        fuse: u16,
        /// Rounds.
        quantity: u16,
        /// Rounds per minute.
        rate_per_min: u16,
    }
}

record! {
    /// Fire (type 2). Source: IEEE 1278.1-2012, 7.3.2.
    Fire {
        /// Who fires.
        firing_entity: EntityId,
        /// At whom.
        target_entity: EntityId,
        /// What.
        munition_id: EntityId,
        /// Number of the event.
        event_id: EventId,
        /// Number of the fire mission, 0 if none.
        fire_mission: u32,
        /// Where from, world coordinates.
        location: Location,
        /// The munition.
        descriptor: Descriptor,
        /// Its velocity, m/s, world axes.
        velocity_mps: Vector32,
        /// Assumed range, metres.
        range_m: f32,
    }
}
fixed_body!(Fire = FIRE);

body! {
    /// Detonation (type 3). Source: IEEE 1278.1-2012, 7.3.3.
    Detonation = DETONATION {
        /// Who fired.
        firing_entity: EntityId;
        /// At whom.
        target_entity: EntityId;
        /// What explodes.
        exploding_entity: EntityId;
        /// Number of the event.
        event_id: EventId;
        /// Its velocity, m/s, world axes.
        velocity_mps: Vector32;
        /// Where, world coordinates.
        location: Location;
        /// The munition.
        descriptor: Descriptor;
        /// Where, in the body axes of the target, metres.
        location_in_entity_m: Vector32;
        /// Result: SISO-REF-010, UID 62.
        result: u8;
        count number_of_variable_parameters: u8 = variable_parameters;
        /// Unused.
        padding: u16;
        /// Records of 16 octets.
        list variable_parameters: VariableParameter, number_of_variable_parameters;
    }
}
