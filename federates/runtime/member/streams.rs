//! The numbered streams between members: beats, what is lost and asked for again.

use super::contact::Contact;
use super::inputs::{Incomplete, Producer, holder, stand_in};
use super::{CONDUCTOR, Effect, Member};
use crate::runtime::clock::WallNs;
use crate::runtime::messages::{Beat, FetchOf, Fetched, Order, Report};
use crate::runtime::stream::Inbox;

impl Member {
    /// A beat of another member or of the conductor.
    pub fn hear_beat(&mut self, now: WallNs, from: &str, beat: &Beat) {
        if beat.fed != self.fed {
            return;
        }
        if from != CONDUCTOR {
            if self.peers.get(from).is_none_or(|inbox| inbox.inc() <= beat.inc) {
                self.hears(from);
            }
            self.has_told(now, from, beat.inc, beat.last_seq);
        } else if beat.inc == 0 {
            self.orders.told(now, beat.last_seq);
            // Who has no connection to a producer any more learns so what that has told, and asks the others for it.
            for (of, inc, seq) in &beat.seen {
                self.has_told(now, of, *inc, *seq);
            }
        }
        for (_, _, seq) in
            beat.seen.iter().filter(|(of, inc, _)| *of == self.name && *inc == self.inc)
        {
            self.outbox.confirm(from, *seq);
        }
    }

    /// A member has told its reports up to a number: what lacks of them is asked for.
    fn has_told(&mut self, now: WallNs, from: &str, inc: u64, last_seq: u64) {
        if let Some(inbox) = self.peers.get_mut(from).filter(|i| i.inc() == inc) {
            inbox.told(now, last_seq);
        } else if self.producers.contains_key(from) && self.federate.consumes() {
            let known = self.peers.get(from).map_or(0, Inbox::inc);
            if inc > known {
                let mut inbox = Inbox::new(self.fed, inc, 1);
                inbox.told(now, last_seq);
                self.peers.insert(from.to_owned(), inbox);
            }
        }
    }

    /// This member's own beat, but for what it is working on.
    #[must_use]
    pub fn beat(&self) -> Beat {
        let mut seen = vec![(CONDUCTOR.to_owned(), 0, self.orders.seen())];
        seen.extend(self.peers.iter().map(|(name, i)| (name.clone(), i.inc(), i.seen())));
        Beat {
            fed: self.fed,
            run: self.run(),
            inc: self.inc,
            last_seq: self.outbox.last(),
            executed: self.executed,
            working: None,
            seen,
            utc_ns: 0,
        }
    }

    /// Answers somebody who lacks messages.
    #[must_use]
    pub fn fetch(&self, ask: &FetchOf) -> Fetched<Report> {
        let nothing = Fetched { of: ask.of.clone(), items: Vec::new(), gone_before: 0 };
        if ask.fetch.fed != self.fed {
            nothing
        } else if ask.of == self.name && ask.fetch.inc == self.inc {
            self.outbox.fetch(&ask.of, &ask.fetch)
        } else {
            let inbox = self.peers.get(&ask.of).filter(|i| i.inc() == ask.fetch.inc);
            inbox.map_or(nothing, |inbox| inbox.relay(&ask.of, &ask.fetch))
        }
    }

    /// Orders that were lost.
    pub fn fetched_orders(
        &mut self,
        now: WallNs,
        fetched: Fetched<Order>,
        effects: &mut Vec<Effect>,
    ) {
        if fetched.gone_before > self.orders.seen() + 1 {
            return self.cast_out(effects);
        }
        for order in fetched.items {
            self.order(now, order, effects);
        }
    }

    /// Reports of another member that were lost, told again by `by`.
    pub fn fetched(
        &mut self,
        now: WallNs,
        by: &str,
        fetched: Fetched<Report>,
        effects: &mut Vec<Effect>,
    ) {
        self.hears(by);
        let Some(inbox) = self.peers.get(&fetched.of) else { return };
        let forgotten = fetched.gone_before > inbox.seen() + 1;
        if forgotten && fetched.items.first().is_none_or(|i| i.inc == inbox.inc()) {
            if self.config.is_some() && !self.producers.contains_key(&fetched.of) {
                // Nothing of it is read: it is heard from where it is.
                self.peers.insert(
                    fetched.of.clone(),
                    Inbox::new(self.fed, inbox.inc(), fetched.gone_before),
                );
                return;
            }
            return self.cast_out(effects);
        }
        if by != fetched.of && !fetched.items.is_empty() {
            self.hears_by_others(now, &fetched.of);
        }
        for report in fetched.items {
            self.take_report(now, &fetched.of, report, effects);
        }
    }

    /// Time passed: asks for what is missing too long.
    pub fn tick(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.ask_for_pdus(now, effects);
        self.stand(now, effects);
        if let Some((fetch, _)) = self.orders.due(now, false) {
            let ask = FetchOf { of: CONDUCTOR.to_owned(), fetch };
            effects.push(Effect::Fetch { holder: CONDUCTOR.to_owned(), ask });
        }
        let others = self.other_consumers();
        for (name, inbox) in &mut self.peers {
            // Of the lost nobody knows who has most.
            let takes_part = |p: &&Producer| p.inc == Some(inbox.inc());
            let producer = self.producers.get(name).filter(takes_part);
            let silent = |contact: &Contact| producer.is_some() && contact.silent(now);
            let silent = self.contacts.get(name).is_some_and(silent);
            if silent && !self.closed && producer.is_some_and(|p| p.ended < Some(self.granted)) {
                // Nobody says when the rest is there.
                inbox.told(now, inbox.seen() + 1);
            }
            let Some((fetch, tries)) = inbox.due(now, silent) else { continue };
            let holder = match silent {
                true => stand_in(name, tries, &others),
                false => holder(name, tries, &others),
            };
            if holder == *name {
                self.contacts.entry(name.clone()).or_default().asks(now);
            }
            effects.push(Effect::Fetch { holder, ask: FetchOf { of: name.clone(), fetch } });
        }
    }

    pub(super) fn other_consumers(&self) -> Vec<String> {
        let consumers = self.config.iter().flat_map(|c| &c.consumers);
        consumers.filter(|name| **name != self.name).cloned().collect()
    }

    /// When [`Member::tick`] has something to do.
    #[must_use]
    pub fn deadline(&self) -> Option<WallNs> {
        let streams = self.peers.values().filter_map(Inbox::deadline);
        let pdus = self.incomplete.values().map(Incomplete::due);
        streams.chain(self.orders.deadline()).chain(pdus).chain(self.stands).min()
    }
}
