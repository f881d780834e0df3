//! Inputs of a consumer: frame ends name PDUs, datagrams bring them, what is missing is asked for.

use super::{CONDUCTOR, Effect, MAX_WAITING, Member, WallNs};
use crate::runtime::digest::pdu_hash;
use crate::runtime::federate::{FrameInputs, Octets};
use crate::runtime::messages::{
    Frame, FrameEnds, Joined, Numbered, Repair, Repaired, Report, Used,
};
use crate::runtime::stream::Inbox;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// How long an incomplete frame waits for the network before it is repaired by request.
const REPAIR_AFTER_NS: WallNs = 2_000_000;

/// How long a repair may take before it is asked for again.
const REPAIR_AGAIN_NS: WallNs = 200_000_000;

/// PDUs asked for in one question, and octets of its answer: the rest is asked for again.
const REPAIR_PDUS: usize = 4096;
const REPAIRED_OCTETS: usize = 512 << 10;

/// Executed frames whose inputs are kept for other consumers: more than any grant horizon.
const EATEN_FRAMES: usize = 64;

/// Frame ends of one producer that may not be used yet, at most.
const EARLY: usize = 256;

/// What this member knows of one producer.
#[derive(Debug, Default)]
pub(super) struct Producer {
    /// The incarnation whose frames count; none while it is lost.
    pub(super) inc: Option<u64>,
    /// Frame ends seen without a gap up to here; `None` before the first.
    pub(super) ended: Option<Frame>,
    /// While its loss is being settled: how far this member said that it holds its frames. It uses no more.
    pub(super) bound: Option<Option<Frame>>,
    /// Frames that have not ended count as absent.
    pub(super) absent: bool,
    /// Frames that have not ended are awaited from a successor.
    pub(super) awaited: bool,
    /// Nobody can make its frames again: only what the log has may be used.
    pub(super) live: bool,
    /// The log has its frames up to here.
    pub(super) logged: Option<Frame>,
}

/// One frame's PDUs that are named but not all here.
#[derive(Debug)]
pub(super) struct Incomplete {
    /// Hashes, each with how often it is missing.
    missing: BTreeMap<u64, usize>,
    since: WallNs,
    asked: Option<WallNs>,
    tries: u32,
}

impl Incomplete {
    pub(super) fn due(&self) -> WallNs {
        self.asked.map_or(self.since + REPAIR_AFTER_NS, |asked| asked + REPAIR_AGAIN_NS)
    }

    /// Takes one PDU off the list; whether it was on it.
    fn came(&mut self, hash: u64) -> bool {
        let Entry::Occupied(mut missing) = self.missing.entry(hash) else { return false };
        match *missing.get() {
            0 | 1 => drop(missing.remove()),
            _ => *missing.get_mut() -= 1,
        }
        true
    }
}

/// PDUs that are asked for, by frame and hash; by who is asked, and of whom they are.
type Asks = BTreeMap<(String, String), Vec<(Frame, Vec<u64>)>>;

impl Member {
    /// A report of another member.
    pub fn report(
        &mut self,
        now: WallNs,
        from: &str,
        report: Numbered<Report>,
        effects: &mut Vec<Effect>,
    ) {
        if report.fed != self.fed || from == self.name || !self.federate.consumes() {
            return;
        }
        if report.inc >= self.peers.get(from).map_or(0, Inbox::inc) {
            self.hears(from);
        }
        self.take_report(now, from, report, effects);
    }

    /// A report of another member, by itself or by somebody who remembers it.
    pub(super) fn take_report(
        &mut self,
        now: WallNs,
        from: &str,
        report: Numbered<Report>,
        effects: &mut Vec<Effect>,
    ) {
        if report.fed != self.fed || from == self.name || !self.federate.consumes() {
            return;
        }
        if report.seq == 0 {
            if matches!(report.body, Report::Present { .. }) {
                self.heard.insert(from.to_owned());
            }
            return;
        }
        let known = self.peers.get(from).map_or(0, Inbox::inc);
        if report.inc > known {
            // Of a producer of this run nothing is skipped; others are heard from where they are.
            self.peers.insert(from.to_owned(), Inbox::new(self.fed, report.inc, 1));
        }
        let Some(inbox) = self.peers.get_mut(from) else { return };
        let inc = inbox.inc();
        let reports = inbox.take(now, report);
        let mut ended = false;
        for report in reports {
            // One that returns to a run sends no probes, and may have nothing to send for long.
            if let Report::Ready { at: None, run } = report
                && (run != self.run() || self.producers.contains_key(from))
            {
                self.hearing.ready(now, from, run);
            }
            if let Report::Ends(ends) = report {
                let joined = self.joined.entry(from.to_owned()).or_default();
                if joined.0 != inc {
                    *joined = (inc, Joined::default());
                }
                let Some((_, ends)) = joined.1.take(0, ends) else { continue };
                ended = true;
                let early = self.early.entry(from.to_owned()).or_default();
                // A successor speaks: what the one before told beyond its cut is of no use to anybody.
                early.retain(|(of, _)| *of >= inc);
                if early.len() < EARLY {
                    early.push((inc, ends));
                }
            }
        }
        if ended {
            self.take_early(now);
            self.hold(now, effects);
            self.advance(effects);
        }
    }

    /// A lost producer is back: its frames from `from` on are those of incarnation `inc`.
    pub(super) fn admit(&mut self, now: WallNs, name: &str, inc: u64, from: Frame) {
        let Some(producer) = self.producers.get_mut(name) else { return };
        // Frames up to there are held, or count as absent; anything else is no continuation.
        let next = producer.ended.map_or(0, |e| e + 1);
        if producer.absent {
            producer.ended = producer.ended.max(from.checked_sub(1));
        } else if next < from {
            return;
        }
        producer.inc = Some(inc);
        producer.bound = None;
        producer.absent = false;
        producer.awaited = false;
        self.take_early(now);
    }

    /// Uses the frame ends that may be used by now.
    pub(super) fn take_early(&mut self, now: WallNs) {
        if self.closed || self.outcast {
            return;
        }
        let run = self.run();
        for (name, early) in std::mem::take(&mut self.early) {
            let mut kept = Vec::new();
            for (inc, ends) in early {
                let Some(producer) = self.producers.get(&name).filter(|_| ends.run == run) else {
                    continue;
                };
                let current = producer.inc.is_some_and(|of| of == inc);
                // While its loss is settled, up to the cut; nothing before that is known.
                let limit = match (producer.bound, &self.holding) {
                    (None, _) => Some(Frame::MAX),
                    (Some(_), None) => None,
                    (Some(_), Some((_, cuts))) => {
                        cuts.iter().find(|(n, _)| *n == name).and_then(|(_, cut)| *cut)
                    }
                };
                match limit.filter(|limit| current && ends.first <= *limit) {
                    Some(limit) => {
                        let beyond = ends.last > limit;
                        if beyond {
                            kept.push((inc, ends.clone()));
                        }
                        self.take_ends(now, &name, ends, limit);
                    }
                    // Of an incarnation that is not admitted yet, or beyond what is settled.
                    None if current || producer.inc.is_none_or(|of| of < inc) => {
                        kept.push((inc, ends));
                    }
                    None => {}
                }
            }
            if !kept.is_empty() {
                self.early.insert(name, kept);
            }
        }
    }

    fn take_ends(&mut self, now: WallNs, from: &str, ends: FrameEnds, limit: Frame) {
        let Some(producer) = self.producers.get_mut(from) else { return };
        let next = producer.ended.map_or(0, |e| e + 1);
        let last = ends.last.min(limit);
        // What is known is not taken twice; a hole within a stream is a fault of its sender.
        if ends.first > next || last < next {
            return;
        }
        producer.ended = Some(last);
        for (made, effect, notice) in ends.notices {
            if (next..=last).contains(&made) {
                let notices = self.notices.entry((effect.max(made), from.to_owned())).or_default();
                notices.push((made, notice));
            }
        }
        let reads = self.federate.reads_pdus();
        for (frame, hashes) in ends.pdus {
            if !reads || !(next..=last).contains(&frame) {
                continue;
            }
            let (named, mut missing) = (hashes.len(), BTreeMap::new());
            let (mut came, mut here) = (Vec::new(), 0);
            for hash in hashes {
                match self.waiting.remove(&hash) {
                    Some((octets, _)) => {
                        here += 1;
                        came.push(octets);
                    }
                    None => *missing.entry(hash).or_default() += 1,
                }
            }
            if here > 0 {
                self.counters.received += here;
                self.ready.entry((frame, from.to_owned())).or_default().append(&mut came);
            }
            self.hearing.named(now, from, named as u64, here);
            if !missing.is_empty() {
                let incomplete = Incomplete { missing, since: now, asked: None, tries: 0 };
                self.incomplete.insert((frame, from.to_owned()), incomplete);
            }
        }
    }

    /// PDUs from the data plane, each with the frame that its timestamp names (the frame now granted
    /// for outsiders without a usable one).
    pub fn pdus(
        &mut self,
        now: WallNs,
        pdus: impl IntoIterator<Item = Octets>,
        effects: &mut Vec<Effect>,
    ) {
        if !self.federate.reads_pdus() {
            return;
        }
        let mut completed = false;
        for octets in pdus {
            let hash = pdu_hash(&octets);
            self.arrivals += 1;
            let named = self
                .incomplete
                .iter_mut()
                .find_map(|(key, i)| i.came(hash).then(|| (key.clone(), i.missing.is_empty())));
            if let Some((key, complete)) = named {
                self.counters.received += 1;
                self.hearing.came(&key.1, 1);
                self.ready.entry(key.clone()).or_default().push(octets);
                if complete {
                    self.incomplete.remove(&key);
                    completed = true;
                }
                continue;
            }
            // A copy of a PDU that waits adds nothing, and must not take its place in the order.
            if let Entry::Vacant(free) = self.waiting.entry(hash) {
                free.insert((octets, self.arrivals));
                self.waiting_order.push_back((hash, self.arrivals, self.granted));
            }
            if self.waiting_order.len() > MAX_WAITING
                && let Some((hash, _, _)) = self.waiting_order.pop_front()
            {
                self.waiting.remove(&hash);
            }
        }
        if completed {
            self.hold(now, effects);
            self.advance(effects);
        }
    }

    /// PDUs that `by` sent again.
    pub fn repaired(
        &mut self,
        now: WallNs,
        by: &str,
        repaired: Repaired,
        effects: &mut Vec<Effect>,
    ) {
        self.hears(by);
        if Some(repaired.run) != self.config.as_ref().map(|c| c.run) {
            return;
        }
        for (frame, octets) in repaired.pdus {
            let hash = pdu_hash(&octets);
            let mut of_frame =
                self.incomplete.range_mut((frame, String::new())..(frame + 1, String::new()));
            let Some((key, incomplete)) =
                of_frame.find_map(|(key, i)| i.came(hash).then_some((key, i)))
            else {
                continue;
            };
            // The rest of a long frame is asked for as soon as this page is here.
            (incomplete.since, incomplete.asked) = (now, None);
            self.counters.lost += 1;
            self.counters.repaired += 1;
            let (key, complete) = (key.clone(), incomplete.missing.is_empty());
            self.hearing.repaired(&key.1, 1);
            self.ready.entry(key.clone()).or_default().push(Arc::from(octets));
            if complete {
                self.incomplete.remove(&key);
            }
        }
        self.hold(now, effects);
        self.advance(effects);
    }

    /// Answers a consumer that missed PDUs, from what this member made or was given.
    #[must_use]
    pub fn repair(&self, repair: &Repair) -> Repaired {
        let run = self.run();
        let (mut pdus, mut octets) = (Vec::new(), 0);
        if repair.run == run {
            for (frame, hashes) in &repair.wanted {
                let hashes: BTreeSet<u64> = hashes.iter().copied().collect();
                let own = self.own.iter().filter(|own| own.frame == *frame);
                let made =
                    own.flat_map(|own| own.pdus.iter().map(|(hash, octets)| (*hash, octets)));
                let ready = self.ready.range((*frame, String::new())..(*frame + 1, String::new()));
                let given = ready.flat_map(|(_, pdus)| pdus);
                let eaten = self.eaten.iter().filter(|(of, _)| of == frame).flat_map(|(_, p)| p);
                let given = given.chain(eaten).map(|octets| (pdu_hash(octets), octets));
                let wanted = made.chain(given).filter(|(hash, _)| hashes.contains(hash));
                for (_, pdu) in wanted {
                    octets += pdu.len();
                    if octets > REPAIRED_OCTETS && !pdus.is_empty() {
                        return Repaired { run, pdus };
                    }
                    pdus.push((*frame, pdu.to_vec()));
                }
            }
        }
        Repaired { run, pdus }
    }

    /// Asks for PDUs that are missing too long.
    pub(super) fn ask_for_pdus(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let others = self.other_consumers();
        let mut asks = Asks::new();
        for ((frame, of), incomplete) in &mut self.incomplete {
            if now >= incomplete.due() {
                incomplete.asked = Some(now);
                // The station passes a question on to whom it hears.
                let here = self.producers.get(of).is_some_and(|p| p.inc.is_some());
                let silent = self.contacts.get(of).is_some_and(|contact| contact.silent(now));
                let name = match silent && here {
                    true => stand_in(of, incomplete.tries, &others),
                    false => pdu_holder(of, incomplete.tries, here, &others),
                };
                if name == *of {
                    self.contacts.entry(of.clone()).or_default().asks(now);
                }
                incomplete.tries += 1;
                let wanted = asks.entry((name, of.clone())).or_default();
                let asked: usize = wanted.iter().map(|(_, hashes)| hashes.len()).sum();
                let page = &incomplete.missing;
                let most = page.len().min(REPAIR_PDUS.saturating_sub(asked));
                if most > 0 {
                    wanted.push((*frame, page.keys().take(most).copied().collect()));
                }
            }
        }
        let run = self.run();
        for ((holder, of), wanted) in asks {
            effects.push(Effect::Repair { holder, of, repair: Repair { run, wanted } });
        }
    }

    /// Highest frame of producer `name` up to which all is complete here; none if not even frame 0 is.
    pub(super) fn complete_of(&self, name: &str) -> Option<Frame> {
        let ended = self.producers.get(name)?.ended?;
        let missing = self.incomplete.keys().filter(|(_, of)| of == name).map(|(frame, _)| *frame);
        match missing.min() {
            Some(frame) => frame.checked_sub(1).map(|before| before.min(ended)),
            None => Some(ended),
        }
    }

    /// Last frame that may be executed with the inputs that are here; none if not even those of frame 0 are.
    pub(super) fn complete(&self) -> Option<Frame> {
        if !self.federate.consumes() {
            return Some(Frame::MAX);
        }
        let of = |(name, producer): (&String, &Producer)| {
            if producer.absent {
                return Some(Frame::MAX);
            }
            let complete = self.complete_of(name);
            let ahead = self.federate.ahead_of(name).unwrap_or(0);
            let usable = producer.bound.map_or(complete, |bound| complete.min(bound));
            let usable = self.in_log(name, usable);
            usable.map(|frame| frame.saturating_add(ahead))
        };
        self.producers.iter().map(of).min().unwrap_or(Some(Frame::MAX))
    }

    /// Frames up to `complete` of a producer that may be used as far as the log goes.
    pub(super) fn in_log(&self, name: &str, complete: Option<Frame>) -> Option<Frame> {
        let live = self.producers.get(name).filter(|producer| producer.live);
        live.map_or(complete, |producer| complete.min(producer.logged))
    }

    /// Notes for the next report what this step uses of each producer whose PDUs it has to have: the conductor holds it
    /// against what that one named.
    fn tell_used(&mut self, last: Frame, sums: &BTreeMap<String, u64>) {
        let first = std::mem::replace(&mut self.unused, last + 1);
        if !self.federate.reads_pdus() {
            return;
        }
        let needed = |(name, producer): &(&String, &Producer)| {
            !producer.absent && self.federate.ahead_of(name) == Some(0)
        };
        let used = self.producers.iter().filter(needed).map(|(of, _)| {
            let sum = sums.get(of).copied().unwrap_or(0);
            Used { of: of.clone(), first, last, sum }
        });
        self.unreported.used.extend(used);
    }

    pub(super) fn inputs_up_to(&mut self, frame: Frame) -> FrameInputs {
        let mut inputs = FrameInputs::default();
        let next = (frame + 1, String::new());
        let later = self.ready.split_off(&next);
        let mut sums: BTreeMap<String, u64> = BTreeMap::new();
        for ((frame, name), pdus) in std::mem::replace(&mut self.ready, later) {
            let sum = sums.entry(name).or_default();
            *sum = pdus.iter().fold(*sum, |sum, octets| sum.wrapping_add(pdu_hash(octets)));
            inputs.pdus.extend(pdus.iter().map(|octets| (frame, octets.clone())));
            self.eaten.push_back((frame, pdus));
        }
        while self.eaten.front().is_some_and(|(f, _)| f + (EATEN_FRAMES as Frame) < frame) {
            self.eaten.pop_front();
        }
        inputs.pdus.sort();
        self.tell_used(frame, &sums);
        let later = self.notices.split_off(&next);
        for ((effect, _), notices) in std::mem::replace(&mut self.notices, later) {
            inputs.notices.extend(notices.into_iter().map(|(_, notice)| (effect, notice)));
        }
        // What no frame end has named although every frame up to its arrival is complete is not ours.
        while let Some(&(hash, number, granted)) = self.waiting_order.front() {
            if granted >= frame {
                break;
            }
            self.waiting_order.pop_front();
            if self.waiting.get(&hash).is_some_and(|(_, n)| *n == number)
                && let Some((octets, _)) = self.waiting.remove(&hash)
            {
                self.counters.outsiders += 1;
                inputs.outsiders.push((granted, octets));
            }
        }
        inputs
    }
}

/// Whom to ask for what `name` told: itself twice, then in turn the conductor and all who may hold it.
pub(super) fn holder(name: &str, tries: u32, others: &[String]) -> String {
    in_turn(&[name, CONDUCTOR], others, &[], tries.saturating_sub(1))
}

/// Whom to ask for PDUs that `name` made: itself twice, then in turn all who may hold them, last the conductor, who hears it.
fn pdu_holder(name: &str, tries: u32, conductor: bool, others: &[String]) -> String {
    let last: &[&str] = if conductor { &[CONDUCTOR] } else { &[] };
    in_turn(&[name], others, last, tries.saturating_sub(1))
}

/// Whom to ask for what `name` told or made that does not answer: the conductor, and every fourth time somebody else.
pub(super) fn stand_in(name: &str, tries: u32, others: &[String]) -> String {
    match tries % 4 {
        3 => in_turn(&[], others, &[name], tries / 4),
        _ => CONDUCTOR.to_owned(),
    }
}

fn in_turn(first: &[&str], others: &[String], last: &[&str], turn: u32) -> String {
    let others = others.iter().map(String::as_str);
    let all: Vec<&str> = first.iter().copied().chain(others).chain(last.iter().copied()).collect();
    all[turn as usize % all.len()].to_owned()
}
