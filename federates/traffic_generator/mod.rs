//! The traffic generator: ground truth of its share of the movers, as Entity State PDUs.
//!
//! A PDU is due when the receivers' dead reckoning would be off by more than the scene's thresholds,
//! when a mover starts or stops, and at the heartbeat. A parked aircraft costs one PDU a minute.

pub mod entity_state;

use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FinalReport, Frame, Kind, RunConfig};
use entity_state::{deactivated, state_pdu, world_pose};
use pdu::publishing::{Publisher, Thresholds};
use pdu::{EntityState, Envelope};
use scenarios::Scene;
use std::sync::Arc;

/// The federate's logic.
pub struct TrafficGenerator {
    scene: Arc<Scene>,
    exercise: u8,
    time: FrameTime,
    share: u32,
    of: u32,
    movers: Vec<Mover>,
}

/// One mover of this share.
struct Mover {
    /// Index into the scene's entities.
    entity: usize,
    /// What receivers believe, from the last PDU; none before the first and after the last.
    sent: Option<Sent>,
}

struct Sent {
    still: bool,
    publisher: Publisher,
    state: EntityState<'static>,
}

impl TrafficGenerator {
    /// Share `share` (from 1) of `of` of the scene's traffic.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8, share: u32, of: u32) -> Self {
        let time = FrameTime::of(&scene.run);
        Self { scene, exercise, time, share, of, movers: Vec::new() }
    }

    fn frame(&mut self, frame: Frame, out: &mut FrameOut) {
        let now = self.time.time(frame);
        let run = &self.scene.run;
        let envelope = Envelope::new(self.exercise, self.time.stamp(frame));
        for mover in &mut self.movers {
            let entity = &self.scene.traffic.entities[mover.entity];
            let truth = entity.trajectory.as_ref().and_then(|t| t.at(now));
            let state = match (truth, mover.sent.take()) {
                (Some(truth), sent) => {
                    let still = truth.is_still();
                    let mut publisher = match sent {
                        Some(sent) if sent.still == still => {
                            let (location, orientation) =
                                world_pose(&truth, &self.scene.airport.frame);
                            if sent.publisher.due(now.0, location, orientation).is_none() {
                                mover.sent = Some(sent);
                                continue;
                            }
                            sent.publisher
                        }
                        // New, or it starts or stops: the heartbeat changes too.
                        _ => Publisher::new(Thresholds {
                            distance_m: run.dead_reckoning.position_m,
                            angle_rad: run.dead_reckoning.orientation_rad,
                            heartbeat_ns: match still {
                                true => run.heartbeat_parked.0,
                                false => run.heartbeat_moving.0,
                            },
                            jitter: 0.1,
                        }),
                    };
                    let state = state_pdu(entity, &truth, still, &self.scene);
                    publisher.sent(now.0, &state);
                    mover.sent = Some(Sent { still, publisher, state: state.clone() });
                    state
                }
                // Gone: one last PDU says so.
                (None, Some(sent)) => deactivated(sent.state),
                (None, None) => continue,
            };
            let mut octets = Vec::with_capacity(144);
            envelope.append(&state, &mut octets).expect("an Entity State without parameters fits");
            out.pdus.push(octets.into());
        }
    }
}

impl Federate for TrafficGenerator {
    fn kind(&self) -> Kind {
        Kind::TrafficGenerator
    }

    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        if config.generators != self.of {
            return Err(format!(
                "this traffic generator has share {}/{}, but the federation has {} generators: give --share I/{}",
                self.share, self.of, config.generators, config.generators
            ));
        }
        let entities = &self.scene.traffic.entities;
        let own = |entity: &usize| scenarios::in_share(*entity, self.share, self.of);
        let own: Vec<usize> = (0..entities.len()).filter(own).collect();
        if own.iter().any(|entity| entities[*entity].trajectory.is_none()) {
            return Err("the scene was loaded without this share of its truth".into());
        }
        self.movers = own.into_iter().map(|entity| Mover { entity, sent: None }).collect();
        self.frame(0, out);
        Ok(())
    }

    fn step(&mut self, frame: Frame, _inputs: &FrameInputs, out: &mut FrameOut) {
        self.frame(frame, out);
    }

    fn finish(&mut self, report: &mut FinalReport) {
        report.values.push(("entities".into(), self.movers.len() as f64));
    }
}
