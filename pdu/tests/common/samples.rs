//! A PDU of every typed type, with a different value in every field and something in every list.

use pdu::attribute::{Attribute, AttributeRecordSet};
use pdu::emission::*;
use pdu::entity_management::*;
use pdu::enumerations::{
    AcknowledgeFlag, ActionId, AggregateFormation, AggregateKind, AntennaPatternType,
    AttachedPartStation, AttributeActionCode, BeamFunction, CollisionType, ConstantGrid, Country,
    CryptoSystem, DatumId, DeadReckoningAlgorithm, EmitterFunction, EmitterName,
    EnvironmentModelType, EnvironmentRecordType, EventType, ForceId, GridCoordinateSystem,
    HighDensityTrackJam, IffSystemMode, IffSystemName, IffSystemType, InputSource, MajorModulation,
    ModulationSystem, PartNature, PartPosition, PduType, ProtocolVersion, ReceiverState,
    Reliability, RequestStatus, ResponseFlag, StateUpdateIndicator, StationName, StopReason,
    TdlType, TransferType, TransmitState, VariableParameterType,
};
use pdu::environment::{EnvironmentRecord, EnvironmentalProcess};
use pdu::gridded::*;
use pdu::iff::*;
use pdu::interaction::*;
use pdu::management::*;
use pdu::radio::*;
use pdu::records::*;
use pdu::reliable::*;
use pdu::{Body, DisTime, EntityState, EntityStateUpdate, Envelope, List, Pdu};

const A: EntityId = EntityId::new(0x0102, 0x0304, 0x0506);
const B: EntityId = EntityId::new(0x1112, 0x1314, 0x1516);
const C: EntityId = EntityId::new(0x2122, 0x2324, 0x2526);
const TYPE: EntityType = EntityType::new(1, 2, 225, 57, 3, 4, 5);
const V1: Vector32 = Vector32 { x: 1.5, y: -2.25, z: 3.125 };
const V2: Vector32 = Vector32 { x: -0.5, y: 0.75, z: 9.0 };
const PLACE: Location = Location { x_m: 4_278_001.25, y_m: 643_002.5, z_m: 4_670_003.75 };
const TURN: Orientation = Orientation { psi_rad: 0.25, theta_rad: -0.5, phi_rad: 1.75 };
const CLOCK: ClockTime = ClockTime { hour: 494_000, past_hour: DisTime(0x1234_5679) };
const CLOCK2: ClockTime = ClockTime { hour: 494_001, past_hour: DisTime(0x0234_5679) };

const FIXED: [FixedDatum; 2] = [
    FixedDatum { id: DatumId(54_100), value: [1, 2, 3, 4] },
    FixedDatum { id: DatumId(57_300), value: [5, 6, 7, 8] },
];

fn event() -> EventId {
    EventId { site: 0x3132, application: 0x3334, event: 0x3536 }
}

fn datums() -> Vec<VariableDatum<'static>> {
    vec![
        VariableDatum::new(DatumId(240_010), b"eleven char"),
        VariableDatum::new(DatumId(240_011), b"eight ch"),
    ]
}

/// The kinds of variable parameters.
pub(crate) fn parameters() -> Vec<VariableParameter> {
    vec![
        VariableParameter::Articulated(ArticulatedPart {
            change: 1,
            attached_to: 2,
            parameter_type: 4107,
            value: 0.5,
            padding: 0,
        }),
        VariableParameter::Attached(AttachedPart {
            detached: 1,
            attached_to: 3,
            station: AttachedPartStation(896),
            part_type: TYPE,
        }),
        VariableParameter::Separation(Separation {
            reason: 2,
            pre_entity: 1,
            padding1: 0,
            parent: B,
            padding2: 0,
            station_name: StationName(7),
            station_number: 8,
        }),
        VariableParameter::EntityType(EntityTypeParameter {
            change: 1,
            entity_type: TYPE,
            padding: [0; 6],
        }),
        VariableParameter::Association(EntityAssociation {
            change: 1,
            status: 2,
            association_type: 4,
            entity: C,
            own_station: StationName(3),
            connection: 1,
            member_type: 2,
            group: 77,
        }),
    ]
}

/// An Entity State with this many variable parameters.
pub(crate) fn entity_state(parameters: usize) -> EntityState<'static> {
    EntityState {
        entity_id: A,
        force_id: ForceId(1),
        entity_type: TYPE,
        alternative_entity_type: EntityType::new(1, 1, 71, 6, 7, 8, 9),
        linear_velocity_mps: V1,
        location: PLACE,
        orientation: TURN,
        appearance: 0x8240_3000,
        dead_reckoning_algorithm: DeadReckoningAlgorithm::RVW,
        dead_reckoning_parameters: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
        linear_acceleration_mps2: V2,
        angular_velocity_rad_s: Vector32 { x: 0.125, y: -0.0625, z: 0.25 },
        marking: Marking::new("SWR 123").expect("fits"),
        capabilities: 0x0000_0003,
        variable_parameters: List::from(
            self::parameters().into_iter().cycle().take(parameters).collect::<Vec<_>>(),
        ),
    }
}

/// One body of every typed type.
pub(crate) fn bodies() -> Vec<Body<'static>> {
    let fixed_datums: List<'static, FixedDatum> = List::from(&FIXED);
    let variable_datums = || List::from(datums());
    let ids: List<'static, DatumId> = List::from(&[DatumId(54_100), DatumId(57_300)]);
    let (originating_id, receiving_id, request_id) = (A, B, 0x0a0b_0c0d);
    let reliability = Reliability::UNACKNOWLEDGED;
    let time_interval = DisTime(0x0102_0304);
    let beam = |number, targets: Vec<TrackJam>| Beam {
        number,
        parameter_index: 0x0203,
        parameters: FundamentalParameters {
            frequency_hz: 15.7e9,
            frequency_range_hz: 1e6,
            effective_power_dbm: 87.5,
            pulse_repetition_hz: 8192.0,
            pulse_width_us: 0.0625,
        },
        data: BeamData {
            azimuth_centre_rad: 0.5,
            azimuth_sweep_rad: 0.25,
            elevation_centre_rad: -0.125,
            elevation_sweep_rad: 0.0625,
            sweep_sync_percent: 50.0,
        },
        function: BeamFunction(1),
        high_density: HighDensityTrackJam(1),
        status: 1,
        jamming_technique: [1, 2, 3, 4],
        targets: List::from(targets),
        extra: &[],
    };
    let targets = vec![
        TrackJam { entity: B, emitter: 1, beam: 2 },
        TrackJam { entity: C, emitter: 3, beam: 4 },
    ];
    let basic = IffBasic {
        emitting_entity: A,
        event_id: event(),
        antenna_m: V1,
        system_type: IffSystemType(1),
        system_name: IffSystemName(2),
        system_mode: IffSystemMode(3),
        change_options: 0x00,
        system_designator: 5,
        system_specific: 6,
        status: 0x01,
        data_field_1: 7,
        information_layers: 0b0001_0110,
        data_field_2: 9,
        parameter_1: 0x2011,
        parameter_2: 0x2022,
        parameter_3: 0x2000 | 0o1234,
        parameter_4: 0x2044,
        parameter_5: 0x2000 | 35 << 1,
        parameter_6: 0x2066,
    };
    let iff_records = vec![IffRecord { record_type: DatumId(5001), content: b"0123456789" }];
    let mode_s = ModeSTransponder {
        status: 0x8000,
        levels_present: 0x00,
        aircraft_present_domain: 1,
        aircraft_identification: *b"SWR123  ",
        aircraft_address: 0x004b_1234,
        identification_type: 1,
        dap_source: 0,
        altitude: 0x0010,
        capability_report: 5,
        padding: [0; 3],
    };
    vec![
        entity_state(5).into(),
        CreateEntity { originating_id, receiving_id, request_id }.into(),
        RemoveEntity { originating_id, receiving_id, request_id }.into(),
        StartResume {
            originating_id,
            receiving_id,
            real_world_time: CLOCK,
            simulation_time: CLOCK2,
            request_id,
        }
        .into(),
        StopFreeze {
            originating_id,
            receiving_id,
            real_world_time: CLOCK,
            reason: StopReason::RECESS,
            frozen_behaviour: 2,
            padding: 0,
            request_id,
        }
        .into(),
        Acknowledge {
            originating_id,
            receiving_id,
            acknowledge_flag: AcknowledgeFlag::START_RESUME,
            response_flag: ResponseFlag::ABLE_TO_COMPLY,
            request_id,
        }
        .into(),
        ActionRequest {
            originating_id,
            receiving_id,
            request_id,
            action_id: ActionId::TIME_ADVANCE,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        ActionResponse {
            originating_id,
            receiving_id,
            request_id,
            request_status: RequestStatus::COMPLETE,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        DataQuery {
            originating_id,
            receiving_id,
            request_id,
            time_interval,
            fixed_datum_ids: ids.clone(),
            variable_datum_ids: ids.clone(),
        }
        .into(),
        SetData {
            originating_id,
            receiving_id,
            request_id,
            padding: 0,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        Data {
            originating_id,
            receiving_id,
            request_id,
            padding: 0,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        EventReport {
            originating_id,
            receiving_id,
            event_type: EventType::DETECT,
            padding: 0,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        Comment {
            originating_id,
            receiving_id,
            fixed_datums: List::default(),
            variable_datums: variable_datums(),
        }
        .into(),
        EnvironmentalProcess {
            process_id: A,
            environment_type: EntityType::new(4, 1, 0, 2, 0, 0, 0),
            model_type: EnvironmentModelType(1),
            status: 2,
            sequence_number: 17,
            records: vec![
                EnvironmentRecord {
                    record_type: EnvironmentRecordType(0x0101),
                    index: 0,
                    padding: 0,
                    content: b"0123456789abcdef",
                },
                EnvironmentRecord {
                    record_type: EnvironmentRecordType(0x0a00_0000),
                    index: 1,
                    padding: 0,
                    content: b"01234567",
                },
            ]
            .into(),
        }
        .into(),
        EntityStateUpdate {
            entity_id: A,
            padding: 0,
            linear_velocity_mps: V1,
            location: PLACE,
            orientation: TURN,
            appearance: 0x0040_1000,
            variable_parameters: List::from(parameters()),
        }
        .into(),
        Fire {
            firing_entity: A,
            target_entity: B,
            munition_id: C,
            event_id: event(),
            fire_mission: 3,
            location: PLACE,
            descriptor: Descriptor {
                entity_type: EntityType::new(2, 2, 225, 1, 2, 3, 4),
                warhead: 1000,
                fuse: 100,
                quantity: 2,
                rate_per_min: 60,
            },
            velocity_mps: V1,
            range_m: 1234.5,
        }
        .into(),
        Detonation {
            firing_entity: A,
            target_entity: B,
            exploding_entity: C,
            event_id: event(),
            velocity_mps: V1,
            location: PLACE,
            descriptor: Descriptor {
                entity_type: EntityType::new(2, 2, 225, 1, 2, 3, 4),
                warhead: 1000,
                fuse: 100,
                quantity: 2,
                rate_per_min: 60,
            },
            location_in_entity_m: V2,
            result: 1,
            padding: 0,
            variable_parameters: List::from(parameters()),
        }
        .into(),
        Collision {
            issuing_entity: A,
            colliding_entity: B,
            event_id: event(),
            collision_type: CollisionType(1),
            padding: 0,
            velocity_mps: V1,
            mass_kg: 78_000.0,
            location_m: V2,
        }
        .into(),
        CollisionElastic {
            issuing_entity: A,
            colliding_entity: B,
            event_id: event(),
            padding: 0,
            contact_velocity_mps: V1,
            mass_kg: 78_000.0,
            location_m: V2,
            intermediate_results: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            unit_surface_normal: V2,
            coefficient_of_restitution: 0.5,
        }
        .into(),
        ElectromagneticEmission {
            emitting_entity: A,
            event_id: event(),
            state_update: StateUpdateIndicator(1),
            padding: 0,
            systems: List::from(vec![
                EmitterSystem {
                    padding: 0,
                    name: EmitterName::ASR_9,
                    function: EmitterFunction(33),
                    number: 1,
                    location_m: V2,
                    beams: List::from(vec![beam(1, targets), beam(2, vec![])]),
                    extra: &[],
                },
                EmitterSystem { number: 2, ..EmitterSystem::default() },
            ]),
        }
        .into(),
        Designator {
            designating_entity: A,
            system_name: 1000,
            designated_entity: B,
            code: 1688,
            power_w: 50.0,
            wavelength_um: 1.0625,
            spot_in_entity_m: V1,
            spot: PLACE,
            dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
            padding: [0; 3],
            acceleration_mps2: V2,
        }
        .into(),
        Transmitter {
            radio_entity: A,
            radio_number: 1,
            radio_type: EntityType::new(7, 2, 225, 1, 2, 3, 4),
            transmit_state: TransmitState(2),
            input_source: InputSource(1),
            antenna_location: PLACE,
            relative_antenna_m: V1,
            antenna_pattern_type: AntennaPatternType::BEAM,
            frequency_hz: 118_100_000,
            bandwidth_hz: 8333.0,
            power_dbm: 40.0,
            modulation: Modulation {
                spread_spectrum: 0,
                major: MajorModulation(1),
                detail: 2,
                system: ModulationSystem(1),
            },
            crypto_system: CryptoSystem(1),
            crypto_key: 0x0102,
            padding: [0; 3],
            modulation_parameters: b"modulate",
            antenna_pattern: &[
                0x3e, 0x80, 0, 0, 0xbf, 0, 0, 0, 0x3f, 0xe0, 0, 0, 0x3d, 0xcc, 0xcc, 0xcd, 0x3e,
                0x4c, 0xcc, 0xcd, 1, 0, 0, 0, 0x3f, 0x80, 0, 0, 0x3f, 0, 0, 0, 0x3e, 0x80, 0, 0, 0,
                0, 0, 0,
            ],
            records: List::from(vec![TransmitterRecord {
                record_type: DatumId(3000),
                content: b"variable-parameter-22.",
            }]),
            unused: 0,
        }
        .into(),
        Signal {
            radio_entity: A,
            radio_number: 1,
            encoding: 0x0004,
            tdl_type: TdlType(0),
            sample_rate: 8000,
            samples: 7,
            data: SignalData::new(b"seven o"),
        }
        .into(),
        Receiver {
            radio_entity: A,
            radio_number: 1,
            receiver_state: ReceiverState(2),
            padding: 0,
            received_power_dbm: -75.5,
            transmitter_entity: B,
            transmitter_radio_number: 3,
        }
        .into(),
        Iff {
            basic,
            layers: List::from(vec![
                IffLayer::Emissions(Layer2 {
                    specific: 1,
                    beam: BeamData {
                        azimuth_centre_rad: 0.5,
                        azimuth_sweep_rad: 0.25,
                        elevation_centre_rad: -0.125,
                        elevation_sweep_rad: 0.0625,
                        sweep_sync_percent: 50.0,
                    },
                    parameter_1: 1,
                    parameter_2: 2,
                    parameters: List::from(&[IffParameters {
                        effective_power_dbm: 57.0,
                        frequency_hz: 1.09e9,
                        group_repetition_hz: 450.0,
                        pulse_width_us: 0.5,
                        burst_length: 1,
                        applicable_modes: 2,
                        system_specific: [1, 2, 3],
                    }]),
                }),
                IffLayer::ModeS(BasicDataLayer {
                    specific: 0,
                    reporting_simulation: SimulationAddress { site: 1, application: 2 },
                    records: List::from(iff_records),
                    ..mode_s.into()
                }),
            ]),
        }
        .into(),
        AggregateState {
            aggregate_id: A,
            force_id: ForceId(1),
            state: pdu::enumerations::AggregateState(1),
            aggregate_type: AggregateType {
                kind: AggregateKind(1),
                domain: 1,
                country: Country(71),
                category: 2,
                subcategory: 3,
                specific: 4,
                extra: 5,
            },
            formation: AggregateFormation(2),
            marking: AggregateMarking::new("ground handling, stand B34").expect("fits"),
            dimensions_m: V1,
            orientation: TURN,
            centre_of_mass: PLACE,
            velocity_mps: V2,
            aggregates: List::from(&[B]),
            entities: List::from(&[A, C]),
            padding: 0,
            silent_aggregates: List::from(vec![SilentAggregates {
                count: 2,
                padding: 0,
                aggregate_type: AggregateType { kind: AggregateKind(1), ..Default::default() },
            }]),
            silent_entities: List::from(vec![SilentEntities {
                count: 3,
                entity_type: TYPE,
                appearances: List::from(&[1, 2]),
            }]),
            variable_datums: variable_datums(),
        }
        .into(),
        TransferOwnership {
            originating_id,
            receiving_id,
            request_id,
            reliability,
            transfer_type: TransferType(1),
            transfer_entity: C,
            record_sets: List::from(vec![RecordSet {
                record_id: DatumId(31_000),
                serial_number: 1,
                padding: 0,
                record_bits: 48,
                records: b"recordrecord",
            }]),
        }
        .into(),
        IsPartOf {
            originating_id,
            receiving_id,
            nature: PartNature(1),
            position: PartPosition(1),
            location_m: V1,
            station_name: StationName(2),
            station_number: 3,
            part_type: TYPE,
        }
        .into(),
        GriddedData {
            process_id: A,
            field_number: 1,
            pdu_number: 2,
            pdu_total: 3,
            coordinate_system: GridCoordinateSystem(0),
            constant_grid: ConstantGrid(1),
            environment_type: EntityType::new(4, 1, 0, 2, 0, 0, 0),
            orientation: TURN,
            sample_time: CLOCK,
            total_values: 6,
            padding: [0; 3],
            axes: List::from(vec![
                GridAxis {
                    start: GridAxisStart {
                        initial: -1.0,
                        last: 1.0,
                        points: 3,
                        interleaf: 1,
                        axis_type: 0,
                        points_here: 3,
                        initial_index: 0,
                    },
                    irregular: None,
                },
                GridAxis {
                    start: GridAxisStart {
                        initial: 0.0,
                        last: 9.0,
                        points: 2,
                        interleaf: 1,
                        axis_type: 1,
                        points_here: 2,
                        initial_index: 0,
                    },
                    irregular: Some(IrregularAxis {
                        scale: 0.5,
                        offset: 1.0,
                        values: List::from(&[0, 18]),
                    }),
                },
            ]),
            data: GridValues::Components(List::from(vec![
                GridComponent { sample_type: 1, samples: GridSamples::Octets(b"five.") },
                GridComponent {
                    sample_type: 2,
                    samples: GridSamples::Scaled {
                        scale: 0.5,
                        offset: 273.0,
                        values: List::from(&[1, 2, 3]),
                    },
                },
                GridComponent {
                    sample_type: 3,
                    samples: GridSamples::Floats(List::from(&[1.0, 2.0, 3.0])),
                },
            ])),
        }
        .into(),
        CreateEntityR { originating_id, receiving_id, reliability, padding: [0; 3], request_id }
            .into(),
        RemoveEntityR { originating_id, receiving_id, reliability, padding: [0; 3], request_id }
            .into(),
        StartResumeR {
            originating_id,
            receiving_id,
            real_world_time: CLOCK,
            simulation_time: CLOCK2,
            reliability,
            padding: [0; 3],
            request_id,
        }
        .into(),
        StopFreezeR {
            originating_id,
            receiving_id,
            real_world_time: CLOCK,
            reason: StopReason::TERMINATION,
            frozen_behaviour: 2,
            reliability,
            padding: 0,
            request_id,
        }
        .into(),
        AcknowledgeR {
            originating_id,
            receiving_id,
            acknowledge_flag: AcknowledgeFlag::STOP_FREEZE,
            response_flag: ResponseFlag::UNABLE_TO_COMPLY,
            request_id,
        }
        .into(),
        action_request_r(None),
        ActionResponseR {
            originating_id,
            receiving_id,
            request_id,
            request_status: RequestStatus::COMPLETE,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        DataQueryR {
            originating_id,
            receiving_id,
            reliability,
            padding: [0; 3],
            request_id,
            time_interval,
            fixed_datum_ids: ids.clone(),
            variable_datum_ids: ids,
        }
        .into(),
        SetDataR {
            originating_id,
            receiving_id,
            reliability,
            padding: [0; 3],
            request_id,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        DataR {
            originating_id,
            receiving_id,
            request_id,
            reliability,
            padding: [0; 3],
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        EventReportR {
            originating_id,
            receiving_id,
            event_type: EventType::DETECT,
            padding: 0,
            fixed_datums: fixed_datums.clone(),
            variable_datums: variable_datums(),
        }
        .into(),
        CommentR {
            originating_id,
            receiving_id,
            fixed_datums: List::default(),
            variable_datums: variable_datums(),
        }
        .into(),
        Attribute {
            originating_simulation: SimulationAddress { site: 1, application: 2 },
            padding1: [0; 6],
            record_pdu_type: PduType::ENTITY_STATE,
            record_version: ProtocolVersion::DIS7,
            master_record_type: DatumId(0),
            action_code: AttributeActionCode(0),
            padding2: 0,
            record_sets: List::from(vec![
                AttributeRecordSet {
                    entity_id: A,
                    records: List::from(vec![
                        AttributeRecord { record_type: DatumId(252_200), content: b"ab" },
                        AttributeRecord { record_type: DatumId(252_201), content: b"0123456789" },
                    ]),
                },
                AttributeRecordSet { entity_id: B, records: List::default() },
            ]),
        }
        .into(),
    ]
}

/// Action Request-R in its shorter (`None`) or longer form.
pub(crate) fn action_request_r(unused: Option<u32>) -> Body<'static> {
    ActionRequestR {
        originating_id: A,
        receiving_id: B,
        reliability: Reliability::UNACKNOWLEDGED,
        padding: [0; 3],
        request_id: 0x0a0b_0c0d,
        action_id: ActionId::RUN,
        unused,
        fixed_datums: List::from(&FIXED),
        variable_datums: List::from(datums()),
    }
    .into()
}

/// The bodies as PDUs of DIS 7, exercise 7, then variants that deserve their own look.
pub(crate) fn pdus() -> Vec<Pdu<'static>> {
    let envelope = Envelope::new(7, DisTime::absolute(1_234_567_890_123));
    let mut all: Vec<Pdu<'static>> =
        bodies().into_iter().map(|body| Pdu::new(envelope, body)).collect();
    all.push(Pdu::new(envelope, action_request_r(Some(0))));
    all.push(Pdu::new(envelope, entity_state(0)));
    all.push(Pdu::new(
        envelope,
        EntityState {
            variable_parameters: List::from(vec![VariableParameter::Other {
                record_type: VariableParameterType(99),
                octets: *b"15 octets only.",
            }]),
            ..entity_state(0)
        },
    ));
    all.push(Pdu::new(Envelope::dis6(7, DisTime::relative(5)), entity_state(2)));
    all
}
