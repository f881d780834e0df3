//! The truth as it arrived: entities from their PDUs, dead-reckoned to any time of the scan.

use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::Frame;
use crate::traffic_generator::entity_state::{Reckoned, is_deactivated};
use geodesy::LocalFrame;
use models::plot::Callsign;
use models::sensors::{TargetClass, TargetState, Truth};
use models::time::SimTime;
use pdu::EntityState;
use pdu::records::EntityId;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Entities farther from the airport than this are none of its surveillance, m.
const INTEREST_M: f64 = 100_000.0;

/// An outsider that is silent this long is gone, s (2.4 heartbeats of 5 s, as IEEE 1278.1 has it).
const OUTSIDER_TIMEOUT_S: f64 = 12.0;

/// Fastest thing that an airport's surveillance expects, m/s: a jump beyond is a fault of the sender.
const FASTEST_MS: f64 = 1000.0;

/// Most outsiders kept; more than any airport has, and a bound for what a hostile sender can cost.
const MAX_OUTSIDERS: usize = 20_000;

/// All entities heard of.
pub struct ReceivedTruth {
    scene: Arc<Scene>,
    time: FrameTime,
    entities: BTreeMap<u64, Heard>,
    refused: BTreeMap<&'static str, u64>,
}

struct Heard {
    id: EntityId,
    ours: bool,
    callsign: Callsign,
    address: Option<u32>,
    class: TargetClass,
    /// PDUs by the time of validity, ascending; the first one may be from before the scan.
    states: Vec<(SimTime, Reckoned)>,
    /// When it left.
    ended: Option<SimTime>,
    timeout_s: f64,
}

/// Key of an entity for draws: site, application and entity in one number.
#[must_use]
pub fn key_of(id: EntityId) -> u64 {
    u64::from(id.site) << 32 | u64::from(id.application) << 16 | u64::from(id.entity)
}

impl ReceivedTruth {
    /// Nothing heard yet.
    #[must_use]
    pub fn new(scene: Arc<Scene>) -> Self {
        let time = FrameTime::of(&scene.run);
        Self { scene, time, entities: BTreeMap::new(), refused: BTreeMap::new() }
    }

    /// Takes an Entity State that belongs to `frame` (or arrived then) while `now` is being executed.
    pub fn take(&mut self, frame: Frame, now: Frame, state: &EntityState<'_>, ours: bool) {
        if let Err(reason) = self.try_take(frame, now, state, ours) {
            *self.refused.entry(reason).or_default() += 1;
        }
    }

    fn try_take(
        &mut self,
        frame: Frame,
        now: Frame,
        state: &EntityState<'_>,
        ours: bool,
    ) -> Result<(), &'static str> {
        let id = state.entity_id;
        let key = key_of(id);
        let time = self.time.time(frame.min(now));
        let known = self.scene.traffic.entities.iter().find(|e| {
            (self.scene.run.site, e.application, e.number) == (id.site, id.application, id.entity)
        });
        if !ours && known.is_some() {
            return Err("an outsider used the identifier of an entity of the scene");
        }
        let numbers = [
            state.location.x_m,
            state.location.y_m,
            state.location.z_m,
            f64::from(state.orientation.psi_rad),
            f64::from(state.orientation.theta_rad),
            f64::from(state.orientation.phi_rad),
        ];
        let vectors = [
            state.linear_velocity_mps,
            state.linear_acceleration_mps2,
            state.angular_velocity_rad_s,
        ];
        let finite = numbers.iter().all(|n| n.is_finite())
            && vectors.iter().all(|v| v.to_f64().iter().all(|n| n.is_finite()));
        if !finite {
            return Err("Entity State with a coordinate that is not a number");
        }
        let frame = &self.scene.airport.frame;
        let reckoned = Reckoned::new(state);
        let at = reckoned.at(0.0, frame);
        if at.position_m.norm() > INTEREST_M {
            return Err("entity farther than 100 km from the airport");
        }
        if at.velocity_ms.norm() > FASTEST_MS {
            return Err("entity faster than 1000 m/s");
        }
        if let Some(heard) = self.entities.get(&key)
            && let Some((before, last)) = heard.states.last()
            && !ours
        {
            let elapsed_s = time.since_s(*before).max(0.05);
            let jump_m = (last.at(0.0, frame).position_m - at.position_m).norm();
            // One jump is a fault; an entity that stays where it jumped to is heard again after the time-out.
            if jump_m > FASTEST_MS * elapsed_s + 100.0 {
                return Err("entity jumped farther than it can move");
            }
        }
        if !self.entities.contains_key(&key) {
            if !ours && self.entities.values().filter(|e| !e.ours).count() >= MAX_OUTSIDERS {
                return Err("more than 20 000 entities of outsiders");
            }
            let run = &self.scene.run;
            let heard = Heard {
                id,
                ours,
                callsign: known
                    .map_or_else(|| Callsign::new(&state.marking.text()), |e| e.callsign),
                address: known.and_then(|e| e.address),
                class: known.map_or_else(|| class_of(state), |e| e.class.clone()),
                states: Vec::new(),
                ended: None,
                timeout_s: if ours {
                    2.4 * run.heartbeat_parked.s().max(run.heartbeat_moving.s())
                } else {
                    OUTSIDER_TIMEOUT_S
                },
            };
            self.entities.insert(key, heard);
        }
        let heard = self.entities.get_mut(&key).expect("it was inserted above");
        heard.ended = is_deactivated(state).then_some(time);
        let place = heard.states.partition_point(|(t, _)| *t <= time);
        heard.states.insert(place, (time, reckoned));
        Ok(())
    }

    /// What the sensors may look at from `from` to `to`.
    #[must_use]
    pub fn view(&self, from: SimTime, to: SimTime) -> View<'_> {
        let entities = self
            .entities
            .iter()
            .filter(|(_, heard)| {
                let Some((last, _)) = heard.states.last() else { return false };
                heard.ended.is_none_or(|ended| ended > from)
                    && from.since_s(*last) < heard.timeout_s
            })
            .map(|(key, heard)| (*key, heard))
            .collect();
        View { entities, frame: &self.scene.airport.frame, to }
    }

    /// Drops PDUs that no later scan can need, and entities that are gone.
    pub fn forget_before(&mut self, time: SimTime) {
        self.entities.retain(|_, heard| {
            let current = heard.states.partition_point(|(t, _)| *t <= time).saturating_sub(1);
            heard.states.drain(..current);
            let silent =
                heard.states.last().is_some_and(|(t, _)| time.since_s(*t) >= heard.timeout_s);
            !silent && heard.ended.is_none_or(|ended| ended > time)
        });
    }

    /// Entity States refused, by reason.
    #[must_use]
    pub fn refused(&self) -> Vec<(String, u64)> {
        self.refused.iter().map(|(reason, count)| ((*reason).to_owned(), *count)).collect()
    }
}

/// Size and echo of an entity that the scene does not know, by its entity type.
fn class_of(state: &EntityState<'_>) -> TargetClass {
    let air = state.entity_type.kind.0 == 1 && state.entity_type.domain == 2;
    let (designator, length_m, span_m, height_m, rcs_m2) = match (air, state.entity_type.category) {
        (true, 84 | 85) => ("light aircraft", 9.0, 11.0, 3.0, 3.0),
        (true, _) => ("aircraft", 38.0, 35.0, 12.0, 20.0),
        (false, _) => ("vehicle", 6.0, 2.2, 2.0, 5.0),
    };
    TargetClass { designator: designator.into(), aircraft: air, length_m, span_m, height_m, rcs_m2 }
}

/// The entities of one scan, sorted by key.
pub struct View<'a> {
    entities: Vec<(u64, &'a Heard)>,
    frame: &'a LocalFrame,
    to: SimTime,
}

impl View<'_> {
    /// DIS identifier.
    #[must_use]
    pub fn id(&self, index: usize) -> EntityId {
        self.entities[index].1.id
    }

    /// Whether it belongs to the federation.
    #[must_use]
    pub fn is_ours(&self, index: usize) -> bool {
        self.entities[index].1.ours
    }

    /// Index of the entity with this key.
    #[must_use]
    pub fn index_of(&self, key: u64) -> Option<usize> {
        self.entities.binary_search_by_key(&key, |(k, _)| *k).ok()
    }

    /// End of the scan.
    #[must_use]
    pub fn to(&self) -> SimTime {
        self.to
    }
}

impl Truth for View<'_> {
    fn len(&self) -> usize {
        self.entities.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.entities[index].0
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.entities[index].1.class
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.entities[index].1.callsign
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.entities[index].1.address
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let heard = self.entities[index].1;
        if heard.ended.is_some_and(|ended| time >= ended) {
            return None;
        }
        let at = heard.states.partition_point(|(t, _)| *t <= time).checked_sub(1)?;
        let (since, reckoned) = &heard.states[at];
        Some(reckoned.at(time.since_s(*since), self.frame))
    }
}
