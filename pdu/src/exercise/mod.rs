//! An exercise as it is heard: datagrams in, the entities at any time out.
//!
//! [`Exercise`] takes everybody at his word: the sender's time ([`clock`]), dead reckoning, frozen and
//! deactivated entities, Entity State Update, Remove Entity, transponders. [`Announcer`] is its mirror:
//! it sends the states of own entities when they are due.
//!
//! ```
//! use pdu::exercise::{Announcer, Arrival, Exercise};
//! use pdu::records::{EntityId, Vector32};
//! use pdu::enumerations::DeadReckoningAlgorithm;
//! use pdu::EntityState;
//!
//! let mut ours = Announcer::new(1, Default::default());
//! let mut theirs = Exercise::new(1);
//! let state = EntityState {
//!     entity_id: EntityId::new(7, 1, 42),
//!     linear_velocity_mps: Vector32::from_f64([70.0, 0.0, 0.0]),
//!     dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
//!     ..EntityState::default()
//! };
//! let sent_at = 1_700_000_000_000_000_000; // UTC, ns
//! for datagram in ours.present(sent_at, &state, None)? {
//!     // 200 ms on the way.
//!     theirs.feed(&Arrival::in_real_time(sent_at + 200_000_000), &datagram);
//! }
//! let later = sent_at + 1_000_000_000;
//! let there = theirs.entity(EntityId::new(7, 1, 42)).and_then(|e| e.at(later)).expect("it is heard");
//! assert!((there.estimate.location.x_m - 70.0).abs() < 1e-3);
//! # Ok::<(), pdu::EncodeError>(())
//! ```
//!
//! No clock is read, nothing is sent: the caller says what time it is. Memory is bounded by [`Limits`].

mod announce;
pub mod clock;
mod entity;
mod transponder;

pub use announce::Announcer;
pub use entity::{Entity, Placed, is_finite};
pub use transponder::Transponder;

use crate::datagram::{Pdu, pdus};
use crate::enumerations::AirAppearance;
use crate::records::EntityId;
use crate::{Body, DisTime, EntityState, EntityStateUpdate};
use clock::{ClockReport, SenderClock, Validity};
use std::collections::BTreeMap;

/// When something arrived, by the receiver's clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Time of the receiver's exercise as UTC, ns since 1970.
    pub time_ns: i64,
    /// The receiver's wall clock, UTC, ns since 1970.
    pub utc_ns: i64,
    /// Exercise seconds in one second of the wall clock.
    pub rate: f64,
}

impl Arrival {
    /// For a receiver whose exercise time is the wall clock's.
    #[must_use]
    pub fn in_real_time(utc_ns: i64) -> Self {
        Self { time_ns: utc_ns, utc_ns, rate: 1.0 }
    }
}

/// What an exercise may cost its receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Entities kept.
    pub entities: usize,
    /// States kept of one entity: of more, those that are spread most evenly.
    pub states: usize,
    /// An entity that is silent so long by its sender's clock is gone, s.
    pub silence_s: f64,
}

impl Limits {
    /// A transponder that is silent so long is not heard any more, s: 2.4 of its heartbeats, which are twice as long as those of
    /// entities (10 s and 5 s, IEEE 1278.1-2012, annex B).
    fn transponder_silence_s(&self) -> f64 {
        2.0 * self.silence_s
    }

    /// Whether what a transponder said at one time is too old at another, by both clocks of the receiver.
    fn is_silent(&self, at: &Arrival, now: &Arrival) -> bool {
        let silence_ns = (self.transponder_silence_s() * 1e9) as i64;
        let ages_ns =
            [now.time_ns.saturating_sub(at.time_ns), now.utc_ns.saturating_sub(at.utc_ns)];
        ages_ns.iter().all(|age_ns| *age_ns > silence_ns)
    }
}

impl Default for Limits {
    /// 4096 entities of 64 states; 12 s are 2.4 heartbeats of 5 s (IEEE 1278.1-2012, annex B).
    fn default() -> Self {
        Self { entities: 4096, states: 64, silence_s: 12.0 }
    }
}

/// Why a PDU had no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[error("{}", self.text())]
pub enum Refusal {
    /// The octets are not a PDU.
    Damaged,
    /// It belongs to others.
    OtherExercise,
    /// NaN or infinity.
    NotFinite,
    /// No room.
    TooMany,
    /// An update of an entity of which no Entity State was heard.
    Unknown,
    /// Nothing that an exercise is made of here.
    Indifferent,
}

impl Refusal {
    /// The reason in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Damaged => "not a sound PDU",
            Self::OtherExercise => "PDU of another exercise",
            Self::NotFinite => "Entity State with a coordinate that is not a number",
            Self::TooMany => "more entities than are kept",
            Self::Unknown => "update of an entity that was never stated",
            Self::Indifferent => "PDU of a type without effect",
        }
    }
}

/// What a PDU did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A new entity.
    Appeared(EntityId),
    /// A known one said something.
    Stated(EntityId),
    /// It left.
    Left(EntityId),
    /// Entities (so many) were asked to leave.
    Removed(usize),
    /// A transponder answered for an entity.
    Identified(EntityId),
    /// Two entities touched, as one of them says.
    Collided(EntityId, EntityId),
}

/// What became of the PDUs of a datagram.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fed {
    /// What they did.
    pub changes: Vec<Change>,
    /// PDUs without effect, and why.
    pub refused: Vec<Refusal>,
}

/// Everything heard of one exercise.
#[derive(Clone, Debug)]
pub struct Exercise {
    id: u8,
    limits: Limits,
    senders: BTreeMap<(u16, u16), SenderClock>,
    entities: BTreeMap<EntityId, Entity>,
    /// Of entities that were not stated yet, or not since they left.
    transponders: BTreeMap<EntityId, (Transponder, Arrival)>,
}

impl Exercise {
    /// Nothing heard yet of the exercise with this identifier.
    #[must_use]
    pub fn new(id: u8) -> Self {
        Self::with_limits(id, Limits::default())
    }

    /// The same with other limits.
    #[must_use]
    pub fn with_limits(id: u8, limits: Limits) -> Self {
        Self {
            id,
            limits,
            senders: BTreeMap::new(),
            entities: BTreeMap::new(),
            transponders: BTreeMap::new(),
        }
    }

    /// Takes a datagram.
    pub fn feed(&mut self, arrival: &Arrival, datagram: &[u8]) -> Fed {
        let mut fed = Fed::default();
        for received in pdus(datagram) {
            match received.map_err(|_| Refusal::Damaged).and_then(|r| self.take(arrival, &r)) {
                Ok(change) => fed.changes.push(change),
                Err(refusal) => fed.refused.push(refusal),
            }
        }
        fed
    }

    /// Takes one PDU.
    ///
    /// # Errors
    /// [`Refusal`]: it had no effect.
    pub fn take(&mut self, arrival: &Arrival, pdu: &Pdu<'_>) -> Result<Change, Refusal> {
        let header = pdu.header();
        if header.exercise_id != self.id {
            return Err(Refusal::OtherExercise);
        }
        match pdu.body() {
            Body::EntityState(state) => self.state(arrival, header.timestamp, state),
            Body::EntityStateUpdate(update) => self.update(arrival, header.timestamp, update),
            Body::RemoveEntity(r) => Ok(self.remove(arrival, r.receiving_id)),
            Body::RemoveEntityR(r) => Ok(self.remove(arrival, r.receiving_id)),
            Body::Iff(iff) => {
                let id = iff.basic.emitting_entity;
                let Some(transponder) = Transponder::of(iff) else {
                    return Err(Refusal::Indifferent);
                };
                let there = self.entities.get_mut(&id).filter(|e| !e.has_left(arrival.time_ns));
                if let Some(entity) = there {
                    entity.transponder = Some((transponder, *arrival));
                } else {
                    if self.transponders.len() >= self.limits.entities {
                        let limits = self.limits;
                        self.transponders.retain(|_, (_, at)| !limits.is_silent(at, arrival));
                    }
                    if self.transponders.len() >= self.limits.entities {
                        return Err(Refusal::TooMany);
                    }
                    self.transponders.insert(id, (transponder, *arrival));
                }
                Ok(Change::Identified(id))
            }
            Body::Collision(c) => Ok(Change::Collided(c.issuing_entity, c.colliding_entity)),
            Body::CollisionElastic(c) => Ok(Change::Collided(c.issuing_entity, c.colliding_entity)),
            _ => Err(Refusal::Indifferent),
        }
    }

    fn state(
        &mut self,
        arrival: &Arrival,
        stamp: DisTime,
        state: &EntityState<'_>,
    ) -> Result<Change, Refusal> {
        if !entity::is_finite(state) {
            return Err(Refusal::NotFinite);
        }
        let id = state.entity_id;
        let new = !self.entities.contains_key(&id);
        if new && self.entities.len() >= self.limits.entities {
            return Err(Refusal::TooMany);
        }
        let valid = self.valid(arrival, stamp, id);
        let leaves = AirAppearance(state.appearance).deactivated();
        if new && leaves {
            return Ok(Change::Left(id));
        }
        let entity = self.entities.entry(id).or_insert_with(|| Entity::new(state, arrival));
        entity.stated(arrival, valid, state, &self.limits);
        if entity.is_here()
            && let Some(waiting) = self.transponders.remove(&id)
            && !self.limits.is_silent(&waiting.1, arrival)
        {
            entity.transponder = Some(waiting);
        }
        Ok(if leaves {
            Change::Left(id)
        } else if new {
            Change::Appeared(id)
        } else {
            Change::Stated(id)
        })
    }

    fn update(
        &mut self,
        arrival: &Arrival,
        stamp: DisTime,
        update: &EntityStateUpdate<'_>,
    ) -> Result<Change, Refusal> {
        let id = update.entity_id;
        let Some(entity) = self.entities.get(&id) else { return Err(Refusal::Unknown) };
        let state = entity.updated(update);
        self.state(arrival, stamp, &state)
    }

    fn remove(&mut self, arrival: &Arrival, whom: EntityId) -> Change {
        let mut count = 0;
        for (id, entity) in &mut self.entities {
            if whom.addresses(*id) && !entity.has_left(arrival.time_ns) {
                entity.leave(arrival.time_ns);
                count += 1;
            }
        }
        Change::Removed(count)
    }

    /// When a stamp of an entity's sender is true.
    fn valid(&mut self, arrival: &Arrival, stamp: DisTime, id: EntityId) -> Validity {
        let sender = (id.site, id.application);
        // Each sender has an entity, or had one: the bound of the entities bounds the senders.
        if self.senders.len() >= self.limits.entities && !self.senders.contains_key(&sender) {
            let entities = &self.entities;
            self.senders.retain(|of, _| entities.keys().any(|id| (id.site, id.application) == *of));
        }
        self.senders.entry(sender).or_default().take(arrival, stamp)
    }

    /// All entities, by identifier; also those that have left and were not forgotten.
    pub fn entities(&self) -> impl Iterator<Item = &Entity> {
        self.entities.values()
    }

    /// One entity.
    #[must_use]
    pub fn entity(&self, id: EntityId) -> Option<&Entity> {
        self.entities.get(&id)
    }

    /// Those that are there at `time_ns` of the exercise, with where they are believed to be.
    pub fn at(&self, time_ns: i64) -> impl Iterator<Item = (&Entity, Placed)> {
        self.entities.values().filter_map(move |e| e.at(time_ns).map(|placed| (e, placed)))
    }

    /// Senders (site, application) with what is known of their clocks.
    pub fn senders(&self) -> impl Iterator<Item = ((u16, u16), ClockReport)> {
        self.senders.iter().map(|(sender, clock)| (*sender, clock.report()))
    }

    /// Drops what nobody can ask for who asks for `time_ns` and later: older states, and entities
    /// that have left or fallen silent.
    pub fn forget_before(&mut self, time_ns: i64) {
        let limits = self.limits;
        self.entities.retain(|_, entity| entity.forget_before(time_ns, &limits));
    }
}

#[cfg(test)]
mod tests;
