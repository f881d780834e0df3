//! Against the Python package opendis 1.0: the same values give the same octets, so each reads what the
//! other writes. Its octets are in `tests/data/opendis`, with the script that makes them.

mod common;

use pdu::emission::Designator;
use pdu::entity_management::IsPartOf;
use pdu::enumerations::{
    AcknowledgeFlag, CollisionType, DeadReckoningAlgorithm, EntityKind, ForceId, ResponseFlag,
    StopReason,
};
use pdu::interaction::Collision;
use pdu::management::{Acknowledge, CreateEntity, RemoveEntity, StartResume, StopFreeze};
use pdu::records::{ClockTime, EntityId, EntityType, Location, Marking, Orientation, Vector32};
use pdu::{Body, DisTime, EntityState, Envelope, Pdu, pdus};

#[test]
fn the_same_values_give_the_same_octets() {
    let (originating_id, receiving_id) = (EntityId::new(1, 2, 3), EntityId::new(4, 5, 6));
    let real_world_time = ClockTime { hour: 494_000, past_hour: DisTime(1001) };
    let cases: [(&str, Body<'static>); 9] = [
        (
            "entity_state",
            EntityState {
                entity_id: EntityId::new(1, 2, 3),
                force_id: ForceId::NEUTRAL,
                entity_type: EntityType::new(1, 2, 225, 57, 1, 2, 3),
                linear_velocity_mps: Vector32 { x: 1.5, y: -2.25, z: 3.125 },
                location: Location { x_m: 4_278_001.25, y_m: 643_002.5, z_m: 4_670_003.75 },
                orientation: Orientation { psi_rad: 0.25, theta_rad: -0.5, phi_rad: 1.75 },
                appearance: 0x0040_0000,
                dead_reckoning_algorithm: DeadReckoningAlgorithm::RVW,
                linear_acceleration_mps2: Vector32 { x: -0.5, ..Vector32::default() },
                angular_velocity_rad_s: Vector32 { z: 0.25, ..Vector32::default() },
                marking: Marking::new("SWR 123").expect("fits"),
                capabilities: 3,
                ..EntityState::default()
            }
            .into(),
        ),
        ("create_entity", CreateEntity { originating_id, receiving_id, request_id: 99 }.into()),
        ("remove_entity", RemoveEntity { originating_id, receiving_id, request_id: 98 }.into()),
        (
            "start_resume",
            StartResume {
                originating_id,
                receiving_id,
                real_world_time,
                simulation_time: ClockTime { hour: 494_001, past_hour: DisTime(1003) },
                request_id: 97,
            }
            .into(),
        ),
        (
            "stop_freeze",
            StopFreeze {
                originating_id,
                receiving_id,
                real_world_time,
                reason: StopReason::TERMINATION,
                frozen_behaviour: 1,
                padding: 0,
                request_id: 96,
            }
            .into(),
        ),
        (
            "acknowledge",
            Acknowledge {
                originating_id,
                receiving_id,
                acknowledge_flag: AcknowledgeFlag::START_RESUME,
                response_flag: ResponseFlag::ABLE_TO_COMPLY,
                request_id: 95,
            }
            .into(),
        ),
        (
            "collision",
            Collision {
                issuing_entity: originating_id,
                colliding_entity: receiving_id,
                collision_type: CollisionType(1),
                velocity_mps: Vector32 { x: 1.5, ..Vector32::default() },
                mass_kg: 78_000.0,
                location_m: Vector32 { z: -2.5, ..Vector32::default() },
                ..Collision::default()
            }
            .into(),
        ),
        (
            "designator",
            Designator {
                designating_entity: originating_id,
                system_name: 1000,
                designated_entity: receiving_id,
                code: 1688,
                power_w: 50.0,
                wavelength_um: 1.0625,
                spot: Location { x_m: 4_278_001.25, ..Location::default() },
                ..Designator::default()
            }
            .into(),
        ),
        (
            "is_part_of",
            IsPartOf {
                originating_id,
                receiving_id,
                location_m: Vector32 { x: 1.5, ..Vector32::default() },
                part_type: EntityType { kind: EntityKind(1), ..EntityType::default() },
                ..IsPartOf::default()
            }
            .into(),
        ),
    ];
    for (name, body) in cases {
        let path = common::data("opendis").join(name).with_extension("raw");
        let theirs = std::fs::read(path).expect(name);
        let ours = Pdu::new(Envelope::new(7, DisTime(0x1234_5679)), body);
        assert_eq!(ours.encode_to_vec().as_ref(), Ok(&theirs), "{name}");
        let received = pdus(&theirs).next().expect(name).expect(name);
        assert_eq!(received.body(), ours.body(), "{name}");
    }
}
