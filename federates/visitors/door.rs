//! Who comes in: a budget a frame, shared among senders; known entities before new ones.
//!
//! A flood costs visitors, never the run. What is refused is counted by reason.

use crate::exchange::stamp::EVER;
use crate::runtime::senders::{NO_SENDER, NO_SITE, Senders};
use pdu::enumerations::PduType;
use pdu::records::EntityId;
use pdu::{Body, Frame};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::{IpAddr, SocketAddr};

/// PDUs let into a frame.
pub const PDUS_A_FRAME: usize = 256;
/// Octets let into a frame.
pub const OCTETS_A_FRAME: usize = 64 * 1024;
/// Entities inside at a time.
pub const ENTITIES: usize = 4096;
/// Sender addresses heard at a time; the rest is refused.
const SOURCES: usize = 256;
/// PDUs of one sender that may wait for a frame, and of all.
const WAITING_OF_ONE: usize = 2 * PDUS_A_FRAME;
const WAITING: usize = 16 * PDUS_A_FRAME;
/// Longest PDU, octets.
const LONGEST: usize = 1400;
/// Senders remembered of an entity of the scene.
const VOICES: usize = 4;
/// An entity that is silent so long makes room, ns of the host's clock.
const ROOM_AFTER_NS: i64 = 15_000_000_000;

/// A PDU that waits for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Waiting {
    /// UTC of its arrival, ns.
    pub utc_ns: i64,
    /// Who sent it.
    pub from: SocketAddr,
    /// The PDU.
    pub octets: Vec<u8>,
    about: EntityId,
    opens: bool,
}

impl Waiting {
    /// Whether its subject is a wildcard (Remove Entity) that stands for somebody inside.
    fn asks_for(&self, inside: &BTreeMap<EntityId, i64>) -> bool {
        const ANY: u16 = 0xffff;
        let of = self.about;
        [of.site, of.application, of.entity].contains(&ANY)
            && inside.keys().any(|id| of.addresses(*id))
    }
}

/// The door.
#[derive(Debug)]
pub struct Door {
    exercise: u8,
    site: u16,
    /// Entities of the scene: (application, number).
    own: BTreeSet<(u16, u16)>,
    /// Whose datagrams are taken.
    senders: Senders,
    /// Entities that may be inside at a time.
    most: usize,
    waiting: BTreeMap<IpAddr, VecDeque<Waiting>>,
    waiting_count: usize,
    /// Whose turn it is to begin.
    turn: usize,
    /// Entities inside, with the UTC of their last PDU.
    inside: BTreeMap<EntityId, i64>,
    ever: BTreeSet<EntityId>,
    /// Who sends what is said about entities of the scene: the last sender, and the ones before.
    voices: BTreeMap<(u16, u16), (SocketAddr, Vec<SocketAddr>)>,
    refused: BTreeMap<&'static str, u64>,
    heard: u64,
}

impl Door {
    /// The door of an exercise in which `own` are the entities of `site`.
    #[must_use]
    pub fn new(exercise: u8, site: u16, own: BTreeSet<(u16, u16)>) -> Self {
        Self {
            exercise,
            site,
            own,
            senders: Senders::default(),
            most: ENTITIES,
            waiting: BTreeMap::new(),
            waiting_count: 0,
            turn: 0,
            inside: BTreeMap::new(),
            ever: BTreeSet::new(),
            voices: BTreeMap::new(),
            refused: BTreeMap::new(),
            heard: 0,
        }
    }

    /// From now on only what these lists allow is heard.
    pub fn take_only(&mut self, senders: Senders) {
        self.senders = senders;
    }

    /// From now on so many entities are inside at a time, with those of the scene, and no more than ever.
    #[must_use]
    pub fn with_targets(mut self, most: usize) -> Self {
        self.most = most.saturating_sub(self.own.len()).min(ENTITIES);
        self
    }

    /// Nobody is inside: a new run.
    pub fn clear(&mut self) {
        let (exercise, site) = (self.exercise, self.site);
        let (senders, most) = (std::mem::take(&mut self.senders), self.most);
        *self = Self::new(exercise, site, std::mem::take(&mut self.own));
        (self.senders, self.most) = (senders, most);
    }

    /// A datagram arrived.
    pub fn knock(&mut self, utc_ns: i64, from: SocketAddr, datagram: &[u8]) {
        if !self.senders.takes(from.ip()) {
            return self.refuse(NO_SENDER);
        }
        let mut frames = pdu::frames(datagram);
        for frame in frames.by_ref() {
            match frame {
                Ok(frame) => self.knock_one(utc_ns, from, &frame),
                Err(_) => self.refuse("not a sound PDU"),
            }
        }
        if !frames.rest().is_empty() {
            self.refuse("octets after the last PDU of a datagram");
        }
    }

    fn knock_one(&mut self, utc_ns: i64, from: SocketAddr, frame: &Frame<'_>) {
        if frame.header.exercise_id != self.exercise {
            return self.refuse("PDU of another exercise");
        }
        let Some((about, opens)) = subject(frame) else { return };
        // The federation's own come through its frame ends; who forges them is not heard, but named.
        let own = (about.application, about.entity);
        if about.site == self.site && self.own.contains(&own) {
            return self.own_said(own, from);
        }
        self.heard += 1;
        // Who is to be removed may be everybody: what is inside has come through here.
        if opens && !self.senders.takes_site(about.site, self.site) {
            return self.refuse(NO_SITE);
        }
        if frame.octets.len() > LONGEST {
            return self.refuse("longer than 1400 octets");
        }
        let ip = from.ip();
        if !self.waiting.contains_key(&ip) && self.waiting.len() >= SOURCES {
            return self.refuse("more than 256 sender addresses");
        }
        let queue = self.waiting.entry(ip).or_default();
        if queue.len() >= WAITING_OF_ONE || self.waiting_count >= WAITING {
            return self.refuse("over the budget of its sender");
        }
        // Only what can be decoded takes part in anything.
        if frame.decode().is_err() {
            return self.refuse("not a sound PDU");
        }
        queue.push_back(Waiting { utc_ns, from, octets: frame.octets.to_vec(), about, opens });
        self.waiting_count += 1;
    }

    /// Somebody says something about an entity of the scene. That its sender changes is a takeover; that an earlier one
    /// goes on meanwhile is a forger.
    fn own_said(&mut self, own: (u16, u16), from: SocketAddr) {
        let (last, before) = self.voices.entry(own).or_insert((from, Vec::new()));
        if *last == from {
            return;
        }
        let forged = before.contains(&from);
        if before.len() < VOICES && !before.contains(last) {
            before.push(*last);
        }
        *last = from;
        if forged {
            self.refuse("two senders use the identifier of an entity of the scene");
        }
    }

    /// What comes into the frame that is executed at `utc_ns`: sorted by sender, entity and arrival.
    pub fn admit(&mut self, utc_ns: i64) -> Vec<Waiting> {
        self.inside.retain(|_, heard| utc_ns.saturating_sub(*heard) < ROOM_AFTER_NS);
        if self.waiting_count == 0 {
            self.waiting.clear();
            return Vec::new();
        }
        let sources = self.waiting.len();
        let most_of_one = if sources > 1 { PDUS_A_FRAME / 2 } else { PDUS_A_FRAME };
        let mut taken_of = vec![0_usize; sources];
        let mut admitted: Vec<Waiting> = Vec::new();
        let mut octets = 0;
        // Known entities first, then new ones; one PDU of each sender in turn.
        for new in [false, true] {
            let mut idle = 0;
            let mut at = self.turn % sources;
            while idle < sources && admitted.len() < PDUS_A_FRAME {
                let source = at;
                at = (at + 1) % sources;
                idle += 1;
                if taken_of[source] >= most_of_one {
                    continue;
                }
                let Some(queue) = self.waiting.values_mut().nth(source) else { continue };
                let inside = &self.inside;
                let known = |w: &Waiting| inside.contains_key(&w.about) || w.asks_for(inside);
                let fits = |w: &Waiting| known(w) != new;
                let Some(place) = queue.iter().position(fits) else { continue };
                if octets + queue[place].octets.len() > OCTETS_A_FRAME {
                    continue;
                }
                let Some(waiting) = queue.remove(place) else { continue };
                self.waiting_count -= 1;
                idle = 0;
                if new && !waiting.opens {
                    self.refuse("about an entity that was never stated");
                    continue;
                }
                if new && self.inside.len() >= self.most {
                    self.refuse(match self.most {
                        ENTITIES => "more than 4096 entities",
                        _ => "more targets than targets_max",
                    });
                    continue;
                }
                if new && !self.ever.contains(&waiting.about) {
                    if self.ever.len() >= EVER {
                        self.refuse("more than 65 536 identifiers in one run");
                        continue;
                    }
                    self.ever.insert(waiting.about);
                }
                if waiting.opens || self.inside.contains_key(&waiting.about) {
                    self.inside.insert(waiting.about, utc_ns);
                }
                taken_of[source] += 1;
                octets += waiting.octets.len();
                admitted.push(waiting);
            }
        }
        self.turn = self.turn.wrapping_add(1);
        self.waiting.retain(|_, queue| !queue.is_empty());
        // What waits longer than a second is of yesterday.
        for queue in self.waiting.values_mut() {
            while queue.front().is_some_and(|w| utc_ns.saturating_sub(w.utc_ns) > 1_000_000_000) {
                queue.pop_front();
                self.waiting_count -= 1;
                *self.refused.entry("over the budget of its sender").or_default() += 1;
            }
        }
        admitted.sort_by_key(|w| (w.from.ip(), w.about, w.utc_ns));
        admitted
    }

    fn refuse(&mut self, reason: &'static str) {
        *self.refused.entry(reason).or_default() += 1;
    }

    /// What was refused, by reason.
    #[must_use]
    pub fn refused(&self) -> &BTreeMap<&'static str, u64> {
        &self.refused
    }

    /// PDUs of outsiders heard.
    #[must_use]
    pub fn heard(&self) -> u64 {
        self.heard
    }

    /// Entities inside.
    #[must_use]
    pub fn inside(&self) -> usize {
        self.inside.len()
    }
}

/// Whom a PDU is about, and whether it can make an entity known; `None` for what no visitor needs.
fn subject(frame: &Frame<'_>) -> Option<(EntityId, bool)> {
    let id = |at: usize| {
        let two = |at: usize| -> Option<u16> {
            Some(u16::from_be_bytes(frame.octets.get(at..at + 2)?.try_into().ok()?))
        };
        Some(EntityId::new(two(at)?, two(at + 2)?, two(at + 4)?))
    };
    match frame.header.pdu_type {
        PduType::ENTITY_STATE => Some((id(12)?, true)),
        PduType::ENTITY_STATE_UPDATE | PduType::IFF | PduType::COLLISION => Some((id(12)?, false)),
        PduType::COLLISION_ELASTIC => Some((id(12)?, false)),
        // Who shall be removed.
        PduType::REMOVE_ENTITY | PduType::REMOVE_ENTITY_R => {
            let Ok(pdu) = frame.decode() else { return None };
            match pdu.body() {
                Body::RemoveEntity(r) => Some((r.receiving_id, false)),
                Body::RemoveEntityR(r) => Some((r.receiving_id, false)),
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
