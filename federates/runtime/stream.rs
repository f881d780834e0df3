//! Numbered streams: orders of the conductor, reports of each member.
//!
//! Every message carries the federation, the incarnation of its sender and a number that counts up by
//! one. The sender keeps what somebody may still ask for ([`Outbox`]); the receiver hands messages on in
//! order, keeps those that came too early, and asks for those that are missing ([`Inbox`]). A beat names
//! the last number, so the end of a burst cannot be lost unnoticed. Number 0 is outside the stream: a
//! message that is repeated anyway.

use super::clock::WallNs;
use super::messages::{Fetch, Fetched, Numbered, Weight};
use std::collections::{BTreeMap, VecDeque};

/// Messages kept at most for who confirms none of them: far more than any grant horizon lets a reader be behind.
const KEPT_MOST: usize = 4096;

/// Messages kept at least, whether or not all readers have confirmed them.
const KEPT: usize = 1024;

/// Octets kept at most.
const KEPT_OCTETS: usize = 64 << 20;

/// Octets of one answer.
const PAGE_OCTETS: usize = 512 << 10;

/// Messages that may wait for a missing one.
const HELD: usize = 256;

/// Octets that may wait for a missing one.
const HELD_OCTETS: usize = 4 << 20;

/// How long a gap may close by itself.
const ASK_AFTER_NS: WallNs = 2_000_000;

/// Pauses between questions for the same message: the first, doubled up to the last, which is that of beats. Orders and reports are taken in
/// their order: where much is lost a run is as fast as its holes are filled.
const ASK_AGAIN_NS: [WallNs; 2] = [20_000_000, 100_000_000];

/// The first of these pauses where it is only supposed that there is something.
const ASK_SOON_NS: WallNs = 5_000_000;

/// The sender's end of a stream.
#[derive(Debug)]
pub struct Outbox<T> {
    fed: u128,
    inc: u64,
    last: u64,
    kept: VecDeque<(u64, T)>,
    octets: usize,
    /// Up to which number each reader has all.
    confirmed: BTreeMap<String, u64>,
}

impl<T: Clone + Weight> Outbox<T> {
    /// The stream of incarnation `inc` (0: the conductor) in federation `fed`.
    #[must_use]
    pub fn new(fed: u128, inc: u64) -> Self {
        Self { fed, inc, last: 0, kept: VecDeque::new(), octets: 0, confirmed: BTreeMap::new() }
    }

    /// Numbers a message and keeps it.
    pub fn push(&mut self, body: T) -> Numbered<T> {
        self.last += 1;
        self.octets += body.octets();
        self.kept.push_back((self.last, body.clone()));
        let needed = self.confirmed.values().copied().min().unwrap_or(self.last);
        while let Some((seq, first)) = self.kept.front()
            && (self.octets > KEPT_OCTETS
                || self.kept.len() > KEPT_MOST
                || self.kept.len() > KEPT && *seq <= needed)
        {
            self.octets -= first.octets();
            self.kept.pop_front();
        }
        self.number(self.last, body)
    }

    /// A message outside the stream.
    #[must_use]
    pub fn loose(&self, body: T) -> Numbered<T> {
        self.number(0, body)
    }

    fn number(&self, seq: u64, body: T) -> Numbered<T> {
        Numbered { fed: self.fed, inc: self.inc, seq, body }
    }

    /// Number of the last message.
    #[must_use]
    pub fn last(&self) -> u64 {
        self.last
    }

    /// A reader has everything up to `seq`.
    pub fn confirm(&mut self, reader: &str, seq: u64) {
        let confirmed = self.confirmed.entry(reader.to_owned()).or_default();
        *confirmed = seq.min(self.last).max(*confirmed);
    }

    /// A reader is gone: nothing is kept for it.
    pub fn forget(&mut self, reader: &str) {
        self.confirmed.remove(reader);
    }

    /// The messages asked for, as far as they are kept and fit one answer.
    #[must_use]
    pub fn fetch(&self, of: &str, fetch: &Fetch) -> Fetched<T> {
        let gone_before = self.kept.front().map_or(self.last + 1, |(seq, _)| *seq);
        let wanted = self.kept.iter().filter(|(seq, _)| (fetch.from..=fetch.to).contains(seq));
        let items = page(wanted.map(|(seq, body)| self.number(*seq, body.clone())));
        Fetched { of: of.to_owned(), items, gone_before }
    }
}

fn page<T: Weight>(items: impl Iterator<Item = Numbered<T>>) -> Vec<Numbered<T>> {
    let mut octets = 0;
    let fits = |item: &Numbered<T>| {
        octets += item.body.octets();
        octets <= PAGE_OCTETS || octets == item.body.octets()
    };
    items.take_while(fits).collect()
}

/// The receiver's end of a stream.
#[derive(Debug)]
pub struct Inbox<T> {
    fed: u128,
    inc: u64,
    next: u64,
    held: BTreeMap<u64, T>,
    held_octets: usize,
    /// The highest number that is known to exist.
    told: u64,
    /// When to ask, after which pause again, how often asked.
    ask: Option<(WallNs, WallNs, u32)>,
    /// The latest messages handed on, for others who lack them.
    past: VecDeque<(u64, T)>,
    past_octets: usize,
}

impl<T: Clone + Weight> Inbox<T> {
    /// The stream of incarnation `inc`, from number `next` on.
    #[must_use]
    pub fn new(fed: u128, inc: u64, next: u64) -> Self {
        Self {
            fed,
            inc,
            next,
            held: BTreeMap::new(),
            held_octets: 0,
            told: next - 1,
            ask: None,
            past: VecDeque::new(),
            past_octets: 0,
        }
    }

    /// The incarnation whose stream this is.
    #[must_use]
    pub fn inc(&self) -> u64 {
        self.inc
    }

    /// Everything up to this number was handed on.
    #[must_use]
    pub fn seen(&self) -> u64 {
        self.next - 1
    }

    /// A message arrived; returns those that are now in order.
    pub fn take(&mut self, now: WallNs, message: Numbered<T>) -> Vec<T> {
        if (message.fed, message.inc) != (self.fed, self.inc) || message.seq < self.next {
            return Vec::new();
        }
        if message.seq > self.next {
            let octets = message.body.octets();
            self.told(now, message.seq);
            if self.held.len() < HELD && self.held_octets + octets <= HELD_OCTETS {
                self.held_octets += octets;
                if let Some(twice) = self.held.insert(message.seq, message.body) {
                    self.held_octets -= twice.octets();
                }
            }
            return Vec::new();
        }
        let mut ordered = vec![message.body];
        while let Some(body) = self.held.remove(&(self.next + ordered.len() as u64)) {
            self.held_octets -= body.octets();
            ordered.push(body);
        }
        for body in &ordered {
            self.past_octets += body.octets();
            self.past.push_back((self.next, body.clone()));
            self.next += 1;
        }
        while self.past.len() > HELD || self.past_octets > HELD_OCTETS && self.past.len() > 1 {
            let Some((_, gone)) = self.past.pop_front() else { break };
            self.past_octets -= gone.octets();
        }
        self.ask = (self.told >= self.next).then_some((now + ASK_AFTER_NS, ASK_AGAIN_NS[0], 0));
        ordered
    }

    /// The sender has numbered its messages up to `last`.
    pub fn told(&mut self, now: WallNs, last: u64) {
        self.told = self.told.max(last);
        if self.told >= self.next {
            self.ask.get_or_insert((now + ASK_AFTER_NS, ASK_AGAIN_NS[0], 0));
        }
    }

    /// What to ask for now, and how often it was asked before. Where nobody says that there is something, `soon`, the pauses begin shorter.
    pub fn due(&mut self, now: WallNs, soon: bool) -> Option<(Fetch, u32)> {
        let (at, pause, tries) = self.ask.filter(|(at, ..)| now >= *at)?;
        let pause = if soon && tries == 0 { ASK_SOON_NS } else { pause };
        self.ask = Some((at.max(now) + pause, (2 * pause).min(ASK_AGAIN_NS[1]), tries + 1));
        let to = self.held.keys().next().map_or(u64::MAX, |first| first - 1);
        Some((Fetch { fed: self.fed, inc: self.inc, from: self.next, to }, tries))
    }

    /// When [`Inbox::due`] has something to ask.
    #[must_use]
    pub fn deadline(&self) -> Option<WallNs> {
        self.ask.map(|(at, ..)| at)
    }

    /// The messages that somebody else lacks, as far as they are remembered here.
    #[must_use]
    pub fn relay(&self, of: &str, fetch: &Fetch) -> Fetched<T> {
        let wanted = self.past.iter().filter(|(seq, _)| (fetch.from..=fetch.to).contains(seq));
        let number = |(seq, body): &(u64, T)| Numbered {
            fed: self.fed,
            inc: self.inc,
            seq: *seq,
            body: body.clone(),
        };
        Fetched { of: of.to_owned(), items: page(wanted.map(number)), gone_before: 0 }
    }
}
