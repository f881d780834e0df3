//! A car that drives on a scene's airport as an outsider: what `seeds sim --visitors` lets in.

use crate::exchange::stamp::{self, Stamped};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FinalReport, Frame, Kind, RunConfig};
use geodesy::Enu;
use pdu::enumerations::DeadReckoningAlgorithm;
use pdu::exercise::Arrival;
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use pdu::{DisTime, EntityState, Envelope};
use scenarios::Scene;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;

/// Frames between two of its PDUs.
const EVERY: Frame = 10;

/// Its speed to the north, m/s.
const SPEED_MPS: f64 = 8.0;

/// The member `visitors` of a simulated federation: the same car in every run.
pub(super) struct Guests {
    scene: Arc<Scene>,
}

impl Guests {
    pub(super) fn new(scene: Arc<Scene>) -> Self {
        Self { scene }
    }

    fn pdu(&self, frame: Frame) -> Option<Vec<u8>> {
        let (run, airport) = (&self.scene.run, &self.scene.airport.frame);
        let time = FrameTime::of(run);
        let at_ns = time.time(frame).0;
        let north_m = SPEED_MPS * at_ns as f64 * 1e-9;
        let place = Enu { east_m: 40.0, north_m, up_m: 0.0 };
        let velocity_mps = airport.vector_to_ecef([0.0, SPEED_MPS, 0.0]);
        let car = EntityState {
            entity_id: EntityId::new(900, 9, 1),
            entity_type: EntityType::new(1, 1, 225, 81, 0, 0, 0),
            location: airport.to_ecef(place).into(),
            linear_velocity_mps: Vector32::from_f64(velocity_mps),
            dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
            marking: Marking::new("GUEST1").ok()?,
            ..EntityState::default()
        };
        let utc_ns = time.start_utc_ns + at_ns;
        let sent = DisTime::absolute(utc_ns as u64);
        let mut octets = Vec::new();
        Envelope::new(run.exercise, sent).append(&car, &mut octets).ok()?;
        let arrival = Arrival { time_ns: utc_ns, utc_ns, rate: 1.0 };
        let from = SocketAddr::from((Ipv4Addr::LOCALHOST, 3000));
        let envelope = Envelope::new(run.exercise, time.stamp(frame));
        stamp::encode(run.site, &envelope, &Stamped { arrival, from, octets }).ok()
    }
}

impl Federate for Guests {
    fn kind(&self) -> Kind {
        Kind::Visitors
    }

    fn live(&self) -> bool {
        true
    }

    fn configure(&mut self, _: &RunConfig, _: &mut FrameOut) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, frame: Frame, _: &FrameInputs, out: &mut FrameOut) {
        if frame.is_multiple_of(EVERY) {
            out.pdus.extend(self.pdu(frame).map(Into::into));
        }
    }

    fn finish(&mut self, _: &mut FinalReport) {}
}
