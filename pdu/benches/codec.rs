//! Encode, decode with all fields read, and reject, against dis-rs in the same run.

use criterion::{Criterion, criterion_group, criterion_main};
use dis_rs::model::{PduBody, VariableParameter as TheirParameter};
use pdu::enumerations::{DeadReckoningAlgorithm, ForceId, PduType};
use pdu::records::*;
use pdu::{Body, DisTime, EntityState, Envelope, Filter, List, frames, pdus};
use std::hint::black_box;

fn entity_state(parameters: usize) -> EntityState<'static> {
    let part = VariableParameter::Articulated(ArticulatedPart {
        change: 1,
        attached_to: 0,
        parameter_type: 4107,
        value: 0.5,
        padding: 0,
    });
    EntityState {
        entity_id: EntityId::new(1, 2, 3),
        force_id: ForceId(1),
        entity_type: EntityType::new(1, 2, 225, 57, 1, 2, 0),
        linear_velocity_mps: Vector32 { x: 1.0, y: 2.0, z: 3.0 },
        location: Location { x_m: 4_278_000.0, y_m: 643_000.0, z_m: 4_670_000.0 },
        orientation: Orientation { psi_rad: 0.5, theta_rad: -0.5, phi_rad: 3.0 },
        appearance: 1 << 22,
        dead_reckoning_algorithm: DeadReckoningAlgorithm::RVW,
        marking: Marking::new("SWR 1234").expect("fits"),
        variable_parameters: List::from(vec![part; parameters]),
        ..EntityState::default()
    }
}

/// Reads every field of ours.
#[inline]
fn read(state: &EntityState<'_>) -> f64 {
    let mut sum = 0.0;
    let mut add = |x: f64| sum += x;
    let number = |id: EntityId| u32::from(id.site ^ id.application ^ id.entity);
    add(number(state.entity_id).into());
    add(state.force_id.0.into());
    for t in [state.entity_type, state.alternative_entity_type] {
        let small = t.kind.0 ^ t.domain ^ t.category ^ t.subcategory ^ t.specific ^ t.extra;
        add((u32::from(small) ^ u32::from(t.country.0)).into());
    }
    for v in
        [state.linear_velocity_mps, state.linear_acceleration_mps2, state.angular_velocity_rad_s]
    {
        add((v.x + v.y + v.z).into());
    }
    add(state.location.x_m + state.location.y_m + state.location.z_m);
    let o = state.orientation;
    add((o.psi_rad + o.theta_rad + o.phi_rad).into());
    add(state.appearance.into());
    add(state.dead_reckoning_algorithm.0.into());
    add(state.dead_reckoning_parameters.iter().fold(0_u8, |a, b| a ^ b).into());
    add(state.marking.octets.iter().fold(0_u8, |a, b| a ^ b).into());
    add(state.capabilities.into());
    for parameter in state.variable_parameters.iter() {
        if let VariableParameter::Articulated(part) = parameter {
            add(f64::from(part.value) + f64::from(part.parameter_type));
            add(f64::from(part.change) + f64::from(part.attached_to));
        }
    }
    sum
}

/// Reads every field of theirs.
fn read_theirs(state: &dis_rs::entity_state::model::EntityState) -> f64 {
    let mut sum = 0.0;
    let mut add = |x: f64| sum += x;
    let id = &state.entity_id;
    let address = &id.simulation_address;
    add(u32::from(address.site_id ^ address.application_id ^ id.entity_id).into());
    add(u8::from(state.force_id).into());
    for t in [&state.entity_type, &state.alternative_entity_type] {
        let small = u8::from(t.kind)
            ^ u8::from(t.domain)
            ^ t.category
            ^ t.subcategory
            ^ t.specific
            ^ t.extra;
        add((u32::from(small) ^ u32::from(u16::from(t.country))).into());
    }
    let dr = &state.dead_reckoning_parameters;
    for v in [&state.entity_linear_velocity, &dr.linear_acceleration, &dr.angular_velocity] {
        add((v.first_vector_component + v.second_vector_component + v.third_vector_component)
            .into());
    }
    let p = &state.entity_location;
    add(p.x_coordinate + p.y_coordinate + p.z_coordinate);
    let o = &state.entity_orientation;
    add((o.psi + o.theta + o.phi).into());
    black_box(&state.entity_appearance);
    add(u8::from(dr.algorithm).into());
    black_box(&dr.other_parameters);
    add(state.entity_marking.marking_string.bytes().fold(0_u8, |a, b| a ^ b).into());
    black_box(&state.entity_capabilities);
    for parameter in &state.variable_parameters {
        if let TheirParameter::Articulated(part) = parameter {
            add(part.parameter_value.into());
            add(f64::from(part.change_indicator) + f64::from(part.attachment_id));
        }
    }
    sum
}

fn codec(criterion: &mut Criterion) {
    for parameters in [0, 2] {
        let envelope = Envelope::new(1, DisTime::absolute(1_234_567_890));
        let state = entity_state(parameters);
        let mut octets = Vec::new();
        envelope.append(&state, &mut octets).expect("fits");
        let theirs = dis_rs::parse(&octets).expect("sound").remove(0);

        let mut group = criterion.benchmark_group(format!("encode/{parameters}"));
        let mut out = [0; 256];
        group.bench_function("pdu", |b| {
            b.iter(|| envelope.encode(black_box(&state), black_box(&mut out)));
        });
        let mut buffer = bytes::BytesMut::with_capacity(256);
        group.bench_function("dis-rs", |b| {
            b.iter(|| {
                buffer.clear();
                black_box(&theirs).serialize(black_box(&mut buffer))
            });
        });
        group.finish();

        let mut group = criterion.benchmark_group(format!("decode/{parameters}"));
        group.bench_function("pdu", |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for received in pdus(black_box(&octets)) {
                    let Ok(received) = received else { continue };
                    if let Body::EntityState(state) = received.body() {
                        sum += read(state);
                    }
                }
                sum
            });
        });
        group.bench_function("pdu, one type", |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for frame in frames(black_box(&octets)) {
                    let Ok(frame) = frame else { continue };
                    if let Some(Ok(state)) = frame.decode_as::<EntityState<'_>>() {
                        sum += read(&state);
                    }
                }
                sum
            });
        });
        group.bench_function("dis-rs", |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for pdu in dis_rs::parse(black_box(&octets)).expect("sound") {
                    if let PduBody::EntityState(state) = &pdu.body {
                        sum += read_theirs(state);
                    }
                }
                sum
            });
        });
        group.finish();

        // An entity of another site, of another exercise: not wanted.
        let mut group = criterion.benchmark_group(format!("reject/{parameters}"));
        let other_site = Filter::default().exercise(1).only([PduType::ENTITY_STATE]).site(9);
        group.bench_function("pdu", |b| {
            b.iter(|| frames(black_box(&octets)).flatten().filter(|f| other_site.wants(f)).count());
        });
        group.bench_function("dis-rs", |b| {
            b.iter(|| {
                let all = dis_rs::parse(black_box(&octets)).expect("sound");
                let wanted = all.iter().filter(|pdu| match &pdu.body {
                    PduBody::EntityState(s) => s.entity_id.simulation_address.site_id == 9,
                    _ => false,
                });
                wanted.count()
            });
        });
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(60)
        .warm_up_time(std::time::Duration::from_millis(500))
        .measurement_time(std::time::Duration::from_secs(2));
    targets = codec
}
criterion_main!(benches);
