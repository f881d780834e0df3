//! Whether a consumer hears a producer itself. One that it does not hear tells the station all the same, as long as both are connected to that:
//! its messages and PDUs then come by others, and a person is told.

use super::Member;
use crate::runtime::clock::WallNs;

/// How long a question may stay without an answer, ns; behind it whoever is asked is not there until it is heard again.
const ANSWER_NS: WallNs = 20_000_000;

/// For how long all must have come by others before that is said, ns: ten beats.
const INDIRECT_NS: WallNs = 1_000_000_000;

/// What is known of the way to one producer.
#[derive(Debug, Default)]
pub(super) struct Contact {
    /// The first question to it since it was heard.
    asked: Option<WallNs>,
    /// Since when what it tells comes by others alone.
    indirect: Option<WallNs>,
    alarm: Option<String>,
}

impl Contact {
    /// It was asked for something.
    pub(super) fn asks(&mut self, now: WallNs) {
        self.asked.get_or_insert(now);
    }

    /// It was asked, did not answer, and was not heard since.
    pub(super) fn silent(&self, now: WallNs) -> bool {
        self.asked.is_some_and(|asked| now >= asked + ANSWER_NS)
    }
}

impl Member {
    /// A word of a producer came by itself.
    pub(super) fn hears(&mut self, from: &str) {
        if let Some(Contact { alarm: Some(_), .. }) = self.contacts.remove(from) {
            tracing::info!("{} hears {from} itself now", self.name);
        }
    }

    /// What a producer told came by somebody else.
    pub(super) fn hears_by_others(&mut self, now: WallNs, from: &str) {
        let Some(contact) = self.contacts.get_mut(from).filter(|c| c.silent(now)) else { return };
        let since = *contact.indirect.get_or_insert(now);
        if now >= since + INDIRECT_NS && contact.alarm.is_none() {
            let text = format!(
                "hears nothing of {from} itself, its messages come by the station: no connection between the two, by a firewall or since one stood still while they met; start one of them again"
            );
            tracing::warn!("{} {text}", self.name);
            contact.alarm = Some(text);
        }
    }

    /// What is wrong with the connections to producers now, for a person.
    pub fn unheard(&self) -> impl Iterator<Item = &str> {
        self.contacts.values().filter_map(|contact| contact.alarm.as_deref())
    }
}
