//! The mirror of [`super::Exercise`]: own entities to PDUs, when they are due.

use super::Transponder;
use crate::enumerations::AirAppearance;
use crate::publishing::{Publisher, Thresholds};
use crate::records::{EntityId, Vector32};
use crate::{DisTime, EncodeError, EntityState, Envelope};
use std::collections::BTreeMap;

/// Longest time between two IFF PDUs of a transponder that says nothing new, ns (IEEE 1278.1-2012,
/// annex B: 10 s).
const IFF_EVERY_NS: i64 = 10_000_000_000;

/// Sends the states of own entities when they are due, with their transponders.
#[derive(Clone, Debug)]
pub struct Announcer {
    exercise: u8,
    thresholds: Thresholds,
    own: BTreeMap<EntityId, Own>,
}

#[derive(Clone, Debug)]
struct Own {
    publisher: Publisher,
    sent: EntityState<'static>,
    transponder: Option<(Transponder, i64)>,
}

impl Announcer {
    /// An announcer without entities.
    #[must_use]
    pub fn new(exercise: u8, thresholds: Thresholds) -> Self {
        Self { exercise, thresholds, own: BTreeMap::new() }
    }

    /// The entity of `state` is so at `now_ns` (UTC, ns since 1970). Gives the PDUs that are due,
    /// none if receivers know it well enough.
    ///
    /// # Errors
    /// If a list of the state does not fit its PDU.
    pub fn present(
        &mut self,
        now_ns: i64,
        state: &EntityState<'_>,
        transponder: Option<&Transponder>,
    ) -> Result<Vec<Vec<u8>>, EncodeError> {
        let thresholds = self.thresholds;
        let envelope = self.envelope(now_ns);
        let own = self.own.entry(state.entity_id).or_insert_with(|| Own {
            publisher: Publisher::new(thresholds),
            sent: EntityState::default(),
            transponder: None,
        });
        let changed = own.sent.appearance != state.appearance
            || own.sent.marking != state.marking
            || own.sent.entity_type != state.entity_type;
        if changed {
            own.publisher.change();
        }
        let mut out = Vec::new();
        let due = own.publisher.due(now_ns, state.location.into(), state.orientation.into());
        if due.is_some() {
            own.publisher.sent(now_ns, state);
            own.sent = state.clone().into_owned();
            out.push(encoded(&envelope, state)?);
        }
        if let Some(transponder) = transponder {
            let fresh = own.transponder.is_some_and(|(said, at)| {
                said == *transponder && now_ns.saturating_sub(at) < IFF_EVERY_NS
            });
            if !fresh {
                own.transponder = Some((*transponder, now_ns));
                out.push(encoded(&envelope, &transponder.iff(state.entity_id))?);
            }
        }
        Ok(out)
    }

    /// Our time stands still at `now_ns`: every entity once more, where it is, frozen. Receivers
    /// would reckon them on otherwise. To be repeated every few seconds, as heartbeats are.
    ///
    /// # Errors
    /// As [`Self::present`].
    pub fn freeze(&self, now_ns: i64) -> Result<Vec<Vec<u8>>, EncodeError> {
        self.own
            .values()
            .map(|own| {
                let appearance = AirAppearance(own.sent.appearance).with_frozen(true).0;
                encoded(&self.envelope(now_ns), &at_rest(own, now_ns, appearance))
            })
            .collect()
    }

    /// Time goes on: every entity is due again.
    pub fn resume(&mut self) {
        self.own.values_mut().for_each(|own| own.publisher.change());
    }

    /// The entity leaves at `now_ns`: its last PDU, with the appearance's bit 23, if it was ever sent.
    ///
    /// # Errors
    /// As [`Self::present`].
    pub fn remove(&mut self, now_ns: i64, id: EntityId) -> Result<Option<Vec<u8>>, EncodeError> {
        let Some(own) = self.own.remove(&id) else { return Ok(None) };
        let appearance = AirAppearance(own.sent.appearance).with_deactivated(true).0;
        encoded(&self.envelope(now_ns), &at_rest(&own, now_ns, appearance)).map(Some)
    }

    fn envelope(&self, now_ns: i64) -> Envelope {
        Envelope::new(self.exercise, DisTime::absolute(now_ns.max(0) as u64))
    }
}

/// The entity where receivers believe it to be at `now_ns`, without motion.
fn at_rest(own: &Own, now_ns: i64, appearance: u32) -> EntityState<'static> {
    let believed = own.publisher.believed(now_ns);
    let mut state = EntityState {
        appearance,
        linear_velocity_mps: Vector32::default(),
        linear_acceleration_mps2: Vector32::default(),
        angular_velocity_rad_s: Vector32::default(),
        dead_reckoning_algorithm: crate::enumerations::DeadReckoningAlgorithm::STATIC,
        ..own.sent.clone()
    };
    if let Some(estimate) = &believed {
        state.location = estimate.location.into();
        state.orientation = estimate.orientation().into();
    }
    state
}

fn encoded(envelope: &Envelope, body: &impl crate::EncodeBody) -> Result<Vec<u8>, EncodeError> {
    let mut octets = Vec::with_capacity(crate::HEADER_LEN + body.body_len());
    envelope.append(body, &mut octets)?;
    Ok(octets)
}
