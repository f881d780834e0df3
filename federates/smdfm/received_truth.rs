//! The truth as it arrived: entities from their PDUs, dead-reckoned to any time of the scan.
//!
//! Entities of the scene come by their frames. Visitors come stamped by the member `visitors`, and are
//! taken at their word by [`Exercise`]: the sender's time, frozen, removed and updated entities,
//! transponders.

use crate::exchange::entity_state::{Reckoned, is_deactivated, target_state};
use crate::exchange::stamp::Stamped;
use crate::exchange::{dis_types, handover};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::Frame;
use geodesy::LocalFrame;
use models::frames::Vector3;
use models::plot::Callsign;
use models::sensors::{TargetClass, TargetState, Truth};
use models::time::SimTime;
use pdu::exercise::{Change, Entity, Exercise, Limits, Transponder};
use pdu::iff::Iff;
use pdu::records::{EntityId, EntityType};
use pdu::{Body, EntityState};
use scenarios::Scene;
use scenarios::types::TypeTable;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Entities farther from the airport than this are none of its surveillance, m.
const INTEREST_M: f64 = 100_000.0;

/// Fastest thing that an airport's surveillance expects, m/s: a jump beyond is a fault of the sender.
const FASTEST_MPS: f64 = 1000.0;

/// Most visitors kept.
const MAX_VISITORS: usize = 4096;

/// All entities heard of.
pub struct ReceivedTruth {
    scene: Arc<Scene>,
    time: FrameTime,
    /// (application, number) → index of the scene's entity.
    known: BTreeMap<(u16, u16), usize>,
    entities: BTreeMap<u64, Heard>,
    visitors: Exercise,
    /// Of visitors: entity type and the class that it stands for.
    classes: BTreeMap<u64, (EntityType, TargetClass)>,
    types: TypeTable,
    /// Mode S addresses and call signs of the scene's entities: nobody else has them.
    addresses: BTreeSet<u32>,
    callsigns: BTreeSet<String>,
    /// Aircraft change hands here: a call sign of ours is somebody else's while we do not have it.
    hands_over: bool,
    /// Visitors that ever came in.
    ever: BTreeSet<u64>,
    refused: BTreeMap<&'static str, u64>,
}

struct Heard {
    id: EntityId,
    callsign: Callsign,
    address: Option<u32>,
    class: TargetClass,
    /// PDUs by the time of validity, ascending; the first one may be from before the scan.
    states: Vec<(SimTime, Reckoned)>,
    /// When its transponder went silent or answered again, by the time, ascending; at first it answers.
    answers: Vec<(SimTime, bool)>,
    /// When it left.
    ended: Option<SimTime>,
    timeout_s: f64,
}

impl Heard {
    /// Whether it is in the run at a time.
    fn is_there(&self, time: SimTime) -> bool {
        let (Some((first, _)), Some((last, _))) = (self.states.first(), self.states.last()) else {
            return false;
        };
        *first <= time
            && self.ended.is_none_or(|ended| time < ended)
            && time.since_s(*last) < self.timeout_s
    }
}

/// Key of an entity for draws: site, application and entity in one number.
#[must_use]
pub fn key_of(id: EntityId) -> u64 {
    u64::from(id.site) << 32 | u64::from(id.application) << 16 | u64::from(id.entity)
}

impl ReceivedTruth {
    /// Nothing heard yet of the exercise `exercise`.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8) -> Self {
        let time = FrameTime::of(&scene.run);
        let entities = scene.traffic.entities.iter().enumerate();
        let known = entities.map(|(i, e)| ((e.application, e.number), i)).collect();
        let limits = Limits { entities: MAX_VISITORS, ..Limits::default() };
        Self {
            time,
            known,
            entities: BTreeMap::new(),
            visitors: Exercise::with_limits(exercise, limits),
            classes: BTreeMap::new(),
            types: scenarios::types::shipped().unwrap_or_default(),
            addresses: scene.traffic.entities.iter().filter_map(|e| e.address).collect(),
            callsigns: scene.traffic.entities.iter().map(|e| name_of(&e.callsign)).collect(),
            hands_over: handover::places(&scene) > 0,
            ever: BTreeSet::new(),
            refused: BTreeMap::new(),
            scene,
        }
    }

    /// Takes an Entity State of the federation that belongs to `frame` while `now` is being executed.
    pub fn take(&mut self, frame: Frame, now: Frame, state: &EntityState<'_>) {
        if let Err(reason) = self.try_take(frame, now, state) {
            *self.refused.entry(reason).or_default() += 1;
        }
    }

    /// Takes what the transponder of an entity of the scene says, of the frame `frame`, while `now` is executed.
    pub fn take_answer(&mut self, frame: Frame, now: Frame, iff: &Iff<'_>) {
        let id = iff.basic.emitting_entity;
        let Some(said) = Transponder::of(iff).filter(|_| self.is_of_scene(id)) else { return };
        let time = self.time.time(frame.min(now));
        let place = self.known.get(&(id.application, id.entity));
        let given = place.is_some_and(|index| handover::is_place(&self.scene, *index));
        let Some(heard) = self.entities.get_mut(&key_of(id)) else { return };
        if given {
            // Nobody knew his address before.
            heard.address = said.address.or(heard.address);
        }
        let place = heard.answers.partition_point(|(t, _)| *t <= time);
        let before = place.checked_sub(1).is_none_or(|i| heard.answers[i].1);
        if before != said.on {
            heard.answers.insert(place, (time, said.on));
        }
    }

    /// Takes a PDU of a visitor as it was let in; says whether it had an effect.
    pub fn take_visitor(&mut self, stamped: &Stamped) -> bool {
        let mut effect = false;
        for received in pdu::pdus(&stamped.octets) {
            let taken = match received {
                Ok(received) => self.try_take_visitor(stamped, &received),
                Err(_) => Err("not a sound PDU"),
            };
            match taken {
                Ok(()) => effect = true,
                Err(reason) => *self.refused.entry(reason).or_default() += 1,
            }
        }
        effect
    }

    /// Whether this is the identifier of an entity of the scene.
    #[must_use]
    pub fn is_of_scene(&self, id: EntityId) -> bool {
        id.site == self.scene.run.site && self.known.contains_key(&(id.application, id.entity))
    }

    fn try_take(
        &mut self,
        frame: Frame,
        now: Frame,
        state: &EntityState<'_>,
    ) -> Result<(), &'static str> {
        let id = state.entity_id;
        let time = self.time.time(frame.min(now));
        let known = self
            .known
            .get(&(id.application, id.entity))
            .filter(|_| id.site == self.scene.run.site)
            .filter(|index| !handover::is_place(&self.scene, **index))
            .map(|&index| &self.scene.traffic.entities[index]);
        let reckoned = Reckoned::new(state);
        self.sane(state)?;
        let run = &self.scene.run;
        let heard = self.entities.entry(key_of(id)).or_insert_with(|| Heard {
            id,
            callsign: known.map_or_else(|| Callsign::new(&state.marking.text()), |e| e.callsign),
            address: known.and_then(|e| e.address),
            class: known.map_or_else(
                || dis_types::class_of(state.entity_type, &self.types),
                |e| e.class.clone(),
            ),
            states: Vec::new(),
            answers: Vec::new(),
            ended: None,
            timeout_s: 2.4 * run.heartbeat_parked.s().max(run.heartbeat_moving.s()),
        });
        heard.ended = is_deactivated(state).then_some(time);
        let place = heard.states.partition_point(|(t, _)| *t <= time);
        heard.states.insert(place, (time, reckoned));
        Ok(())
    }

    /// Whether an airport can believe a state.
    fn sane(&self, state: &EntityState<'_>) -> Result<TargetState, &'static str> {
        if !pdu::exercise::is_finite(state) {
            return Err("Entity State with a coordinate that is not a number");
        }
        let at = Reckoned::new(state).at(0.0, &self.scene.airport.frame);
        if at.position_m.coords.norm() > INTEREST_M {
            return Err("entity farther than 100 km from the airport");
        }
        if at.velocity_mps.norm() > FASTEST_MPS {
            return Err("entity faster than 1000 m/s");
        }
        Ok(at)
    }

    fn try_take_visitor(
        &mut self,
        stamped: &Stamped,
        received: &pdu::Received<'_>,
    ) -> Result<(), &'static str> {
        let arrival = &stamped.arrival;
        let updated;
        let state = match received.body() {
            Body::EntityState(state) => Some(state),
            Body::EntityStateUpdate(update) => {
                updated = self.visitors.entity(update.entity_id).map(|e| e.updated(update));
                updated.as_ref()
            }
            _ => None,
        };
        if let Some(state) = state {
            let id = state.entity_id;
            if self.is_of_scene(id) {
                return Err("an outsider used the identifier of an entity of the scene");
            }
            let at = self.sane(state)?;
            if let Some(placed) = self.visitors.entity(id).and_then(|e| e.at(arrival.time_ns)) {
                let before = target_state(&placed.estimate, &self.scene.airport.frame);
                let jump_m = (before.position_m - at.position_m).norm();
                let elapsed_s = placed.age_s.max(0.05);
                // One jump is a fault; an entity that stays where it jumped to is heard again after
                // the time-out.
                if jump_m > FASTEST_MPS * elapsed_s + 100.0 {
                    return Err("entity jumped farther than it can move");
                }
            }
            let key = key_of(id);
            if self.classes.get(&key).is_none_or(|(of, _)| *of != state.entity_type) {
                if self.classes.len() >= 2 * MAX_VISITORS {
                    let visitors = &self.visitors;
                    self.classes.retain(|key, _| visitors.entity(id_of(*key)).is_some());
                }
                let class = dis_types::class_of(state.entity_type, &self.types);
                self.classes.insert(key, (state.entity_type, class));
            }
        }
        // What an outsider calls himself is his own affair, as long as it hides nobody: his entity stays, without the name.
        if !self.hands_over
            && let Body::Iff(iff) = received.body()
            && let Some(transponder) = Transponder::of(iff)
        {
            if transponder.address.is_some_and(|address| self.addresses.contains(&address)) {
                return Err("an outsider used the Mode S address of an entity of the scene");
            }
            let named = transponder.identification_text();
            if named.is_some_and(|name| self.callsigns.contains(&name)) {
                return Err("an outsider used the call sign of an entity of the scene");
            }
        }
        if !self.hands_over
            && let Some(state) = state
            && self.callsigns.contains(&name_of(&Callsign::new(&state.marking.text())))
        {
            let word = "an outsider's marking is a call sign of the scene: left out";
            *self.refused.entry(word).or_default() += 1;
        }
        match self.visitors.take(arrival, received) {
            Ok(Change::Appeared(id)) => {
                if self.ever.len() < crate::exchange::stamp::EVER {
                    self.ever.insert(key_of(id));
                }
                Ok(())
            }
            Ok(_) => Ok(()),
            Err(refusal) => Err(refusal.text()),
        }
    }

    /// What the sensors may look at from `from` to `to`.
    #[must_use]
    pub fn view(&self, from: SimTime, to: SimTime) -> View<'_> {
        let start_ns = self.time.start_utc_ns;
        let ours = self.entities.iter().filter(|(_, heard)| {
            let Some((last, _)) = heard.states.last() else { return false };
            heard.ended.is_none_or(|ended| ended > from) && from.since_s(*last) < heard.timeout_s
        });
        let mut targets: Vec<(u64, Target<'_>)> =
            ours.map(|(key, heard)| (*key, Target::Ours(heard))).collect();
        let own = targets.len();
        for entity in self.visitors.entities() {
            let key = key_of(entity.id());
            let Some((_, class)) = self.classes.get(&key) else { continue };
            let ends = [from, to].map(|t| entity.at(start_ns.saturating_add(t.0)).is_some());
            if ends == [false, false] {
                continue;
            }
            let visitor = self.visitor(entity, class, start_ns);
            let ours = |t: SimTime| visitor.owner.is_some_and(|owner| owner.is_there(t));
            if !(ours(from) && ours(to)) {
                targets.push((key, Target::Visitor(Box::new(visitor))));
            }
        }
        if targets.len() > own {
            targets.sort_by_key(|(key, _)| *key);
        }
        View { targets, frame: &self.scene.airport.frame, to }
    }

    fn visitor<'a>(
        &'a self,
        entity: &'a Entity,
        class: &'a TargetClass,
        start_ns: i64,
    ) -> Visitor<'a> {
        let transponder = entity.transponder();
        let named = transponder.and_then(|t| t.identification_text());
        let callsign = Callsign::new(&named.unwrap_or_else(|| entity.marking()));
        let name = name_of(&callsign);
        let ours = !self.hands_over && self.callsigns.contains(&name);
        let same = |heard: &&Heard| !name.is_empty() && name_of(&heard.callsign) == name;
        let owner = self.entities.values().filter(|_| self.hands_over).find(same);
        let address = transponder.and_then(|t| t.address);
        // An address of ours is somebody else's only with the call sign that he has it by.
        let taken = |heard: &Heard| address.is_some() && heard.address == address && !same(&heard);
        let taken = self.hands_over && self.entities.values().any(taken);
        Visitor {
            entity,
            class,
            callsign: if ours { Callsign::new("") } else { callsign },
            address: address.filter(|_| !taken),
            owner,
            start_ns,
        }
    }

    /// Drops PDUs that no later scan can need, and entities that are gone.
    pub fn forget_before(&mut self, time: SimTime) {
        self.entities.retain(|_, heard| {
            let current = heard.states.partition_point(|(t, _)| *t <= time).saturating_sub(1);
            heard.states.drain(..current);
            let told = heard.answers.partition_point(|(t, _)| *t <= time).saturating_sub(1);
            heard.answers.drain(..told);
            let silent =
                heard.states.last().is_some_and(|(t, _)| time.since_s(*t) >= heard.timeout_s);
            !silent && heard.ended.is_none_or(|ended| ended > time)
        });
        self.visitors.forget_before(self.time.start_utc_ns.saturating_add(time.0));
    }

    /// Visitors that ever came in.
    #[must_use]
    pub fn visitors_ever(&self) -> usize {
        self.ever.len()
    }

    /// Senders of visitors: site, application, our clock minus theirs, delay of their PDUs (s).
    pub fn clocks(&self) -> impl Iterator<Item = (String, f64)> {
        self.visitors.senders().flat_map(|((site, application), clock)| {
            [
                (format!("clock_offset_s {site}:{application}"), clock.offset_s),
                (format!("delay_s {site}:{application}"), clock.delay_s),
            ]
        })
    }

    /// PDUs refused, by reason.
    #[must_use]
    pub fn refused(&self) -> Vec<(String, u64)> {
        self.refused.iter().map(|(reason, count)| ((*reason).to_owned(), *count)).collect()
    }
}

/// A call sign as others would write it.
fn name_of(callsign: &Callsign) -> String {
    callsign.as_str().trim().to_ascii_uppercase()
}

fn id_of(key: u64) -> EntityId {
    EntityId::new((key >> 32) as u16, (key >> 16) as u16, key as u16)
}

enum Target<'a> {
    Ours(&'a Heard),
    Visitor(Box<Visitor<'a>>),
}

struct Visitor<'a> {
    entity: &'a Entity,
    class: &'a TargetClass,
    callsign: Callsign,
    address: Option<u32>,
    /// Who of ours has its call sign: while he is there, the visitor is not.
    owner: Option<&'a Heard>,
    start_ns: i64,
}

/// The entities of one scan, sorted by key.
pub struct View<'a> {
    targets: Vec<(u64, Target<'a>)>,
    frame: &'a LocalFrame,
    to: SimTime,
}

impl View<'_> {
    /// DIS identifier.
    #[must_use]
    pub fn id(&self, index: usize) -> EntityId {
        match &self.targets[index].1 {
            Target::Ours(heard) => heard.id,
            Target::Visitor(visitor) => visitor.entity.id(),
        }
    }

    /// Whether it belongs to the federation.
    #[must_use]
    pub fn is_ours(&self, index: usize) -> bool {
        matches!(self.targets[index].1, Target::Ours(_))
    }

    /// Index of the entity with this key.
    #[must_use]
    pub fn index_of(&self, key: u64) -> Option<usize> {
        self.targets.binary_search_by_key(&key, |(k, _)| *k).ok()
    }

    /// End of the scan.
    #[must_use]
    pub fn to(&self) -> SimTime {
        self.to
    }
}

impl Truth for View<'_> {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.targets[index].0
    }
    fn class(&self, index: usize) -> &TargetClass {
        match &self.targets[index].1 {
            Target::Ours(heard) => &heard.class,
            Target::Visitor(visitor) => visitor.class,
        }
    }
    fn callsign(&self, index: usize) -> Callsign {
        match &self.targets[index].1 {
            Target::Ours(heard) => heard.callsign,
            Target::Visitor(visitor) => visitor.callsign,
        }
    }
    fn address(&self, index: usize) -> Option<u32> {
        match &self.targets[index].1 {
            Target::Ours(heard) => heard.address,
            Target::Visitor(visitor) => visitor.address,
        }
    }
    fn answers(&self, index: usize, time: SimTime) -> bool {
        let heard = match &self.targets[index].1 {
            Target::Ours(heard) => heard,
            Target::Visitor(visitor) => return visitor.entity.answers(),
        };
        let at = heard.answers.partition_point(|(t, _)| *t <= time);
        at.checked_sub(1).is_none_or(|at| heard.answers[at].1)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        match &self.targets[index].1 {
            Target::Ours(heard) => {
                if heard.ended.is_some_and(|ended| time >= ended) {
                    return None;
                }
                let at = heard.states.partition_point(|(t, _)| *t <= time).checked_sub(1)?;
                let (since, reckoned) = &heard.states[at];
                Some(reckoned.at(time.since_s(*since), self.frame))
            }
            Target::Visitor(visitor) => {
                if visitor.owner.is_some_and(|owner| owner.is_there(time)) {
                    return None;
                }
                let placed = visitor.entity.at(visitor.start_ns.saturating_add(time.0))?;
                let state = target_state(&placed.estimate, self.frame);
                // What the sensors see moves by the exercise's seconds.
                let velocity_mps: Vector3<f64> = state.velocity_mps * placed.pace;
                Some(TargetState { velocity_mps, ..state })
            }
        }
    }
}
