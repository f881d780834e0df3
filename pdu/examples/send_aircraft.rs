//! One aircraft taxies a circle at Zurich for ten seconds, as DIS 7 on UDP.
//!
//! `cargo run -p pdu --example send_aircraft [ADDRESS:PORT]`, by default 127.0.0.1:3000. States are sent
//! when dead reckoning needs them, not at every step.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use geodesy::{Attitude, Enu, Geodetic, LocalFrame};
use pdu::enumerations::{AirAppearance, DeadReckoningAlgorithm, ForceId};
use pdu::publishing::{Publisher, Thresholds};
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use pdu::{DisTime, EntityState, Envelope};
use std::error::Error;
use std::net::UdpSocket;
use std::time::Duration;

const STEP_NS: i64 = 50_000_000;
const SPEED_MPS: f64 = 8.0;
const RADIUS_M: f64 = 40.0;

fn main() -> Result<(), Box<dyn Error>> {
    let to = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:3000".to_owned());
    let socket = UdpSocket::bind("127.0.0.1:0")?;
    let airport = LocalFrame::at(Geodetic::from_degrees(47.4581, 8.5481, 432.0));
    let thresholds = Thresholds { distance_m: 0.5, ..Thresholds::default() };
    let mut publisher = Publisher::new(thresholds);
    let mut datagram = Vec::with_capacity(1400);
    let mut sent = 0;
    for step in 0..200 {
        let now_ns = step * STEP_NS;
        let state = taxiing(&airport, now_ns as f64 * 1e-9)?;
        if let Some(why) = publisher.due(now_ns, state.location.into(), state.orientation.into()) {
            datagram.clear();
            let envelope = Envelope::new(1, DisTime::relative(now_ns as u64));
            envelope.append(&state, &mut datagram)?;
            socket.send_to(&datagram, &to)?;
            publisher.sent(now_ns, &state);
            sent += 1;
            println!("{:6.2} s: {why:?}", now_ns as f64 * 1e-9);
        }
        std::thread::sleep(Duration::from_nanos(STEP_NS as u64));
    }
    println!("{sent} of 200 steps were sent to {to}");
    Ok(())
}

/// The aircraft after `t_s` seconds.
fn taxiing(airport: &LocalFrame, t_s: f64) -> Result<EntityState<'static>, pdu::EncodeError> {
    let turn = SPEED_MPS / RADIUS_M * t_s;
    let (sin, cos) = libm::sincos(turn);
    let here = Enu { east_m: RADIUS_M * (1.0 - cos), north_m: RADIUS_M * sin, up_m: 0.0 };
    let velocity = [SPEED_MPS * sin, SPEED_MPS * cos, 0.0];
    let inwards = SPEED_MPS * SPEED_MPS / RADIUS_M;
    let acceleration = [inwards * cos, -inwards * sin, 0.0];
    let attitude = Attitude { heading_rad: turn, ..Attitude::default() };
    Ok(EntityState {
        entity_id: EntityId::new(1, 1, 42),
        force_id: ForceId::NEUTRAL,
        entity_type: EntityType::new(1, 2, 71, 57, 1, 0, 0),
        linear_velocity_mps: Vector32::from_f64(airport.vector_to_ecef(velocity)),
        linear_acceleration_mps2: Vector32::from_f64(airport.vector_to_ecef(acceleration)),
        angular_velocity_rad_s: Vector32 {
            z: (SPEED_MPS / RADIUS_M) as f32,
            ..Vector32::default()
        },
        location: airport.to_ecef(here).into(),
        orientation: airport.euler(attitude).into(),
        dead_reckoning_algorithm: DeadReckoningAlgorithm::RVW,
        appearance: AirAppearance::default().with_power_plant(true).with_landing_gear(true).0,
        marking: Marking::new("SWR8")?,
        ..EntityState::default()
    })
}
