//! Who joined the exercise by Action Request 45: each is told of phases by itself, in the -R forms, and has to
//! acknowledge; what is not acknowledged is repeated three times, a second apart, and then told to all.

use pdu::records::EntityId;
use std::collections::BTreeSet;

/// At a time, at most.
const MOST: usize = 64;

/// Requests to one of them that wait for an acknowledgement, at most; the oldest goes.
const WAITING_OF_ONE: usize = 8;

/// How often what is not acknowledged is repeated, and after which pause.
const REPEATS: u32 = 3;
const REPEAT_AFTER_NS: u64 = 1_000_000_000;

struct Sent {
    to: EntityId,
    request_id: u32,
    what: &'static str,
    octets: Vec<u8>,
    repeats: u32,
    again_ns: u64,
}

/// The participants, and what they have not acknowledged.
#[derive(Default)]
pub(super) struct Participants {
    joined: BTreeSet<EntityId>,
    sent: Vec<Sent>,
}

impl Participants {
    /// One joins; false if there are too many.
    pub(super) fn join(&mut self, id: EntityId) -> bool {
        self.joined.contains(&id) || self.joined.len() < MOST && self.joined.insert(id)
    }

    /// One resigns: nothing more is sent to it.
    pub(super) fn resign(&mut self, id: EntityId) {
        self.joined.remove(&id);
        self.sent.retain(|sent| sent.to != id);
    }

    /// Who is there.
    pub(super) fn all(&self) -> impl Iterator<Item = EntityId> {
        self.joined.iter().copied()
    }

    /// A request was sent and is to be acknowledged.
    pub(super) fn sent(
        &mut self,
        now_ns: u64,
        (to, request_id): (EntityId, u32),
        what: &'static str,
        octets: Vec<u8>,
    ) {
        let of_one = |sent: &Sent| sent.to == to;
        if self.sent.iter().filter(|sent| of_one(sent)).count() >= WAITING_OF_ONE
            && let Some(oldest) = self.sent.iter().position(of_one)
        {
            self.sent.remove(oldest);
        }
        let again_ns = now_ns + REPEAT_AFTER_NS;
        self.sent.push(Sent { to, request_id, what, octets, repeats: 0, again_ns });
    }

    /// An acknowledgement; says what it was for.
    pub(super) fn acknowledged(&mut self, from: EntityId, request_id: u32) -> Option<&'static str> {
        let which = |s: &Sent| s.to == from && s.request_id == request_id;
        let at = self.sent.iter().position(which)?;
        Some(self.sent.remove(at).what)
    }

    /// What is to be sent again, and who did not acknowledge what.
    pub(super) fn due(&mut self, now_ns: u64) -> (Vec<Vec<u8>>, Vec<String>) {
        let (mut again, mut silent) = (Vec::new(), Vec::new());
        self.sent.retain_mut(|sent| {
            if now_ns < sent.again_ns {
                return true;
            }
            if sent.repeats == REPEATS {
                let Sent { to, what, request_id, .. } = sent;
                silent.push(format!("{to} did not acknowledge {what} (request {request_id})"));
                return false;
            }
            sent.repeats += 1;
            sent.again_ns = now_ns + REPEAT_AFTER_NS;
            again.push(sent.octets.clone());
            true
        });
        (again, silent)
    }
}
