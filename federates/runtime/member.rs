//! A member of the federation as a state machine: orders, reports and datagrams in; reports,
//! datagrams, repairs and publications out. It executes frame k when k is granted and every input of k
//! is complete, never because a timer fired.

use super::digest::{Digest, pdu_hash};
use super::federate::{Federate, FrameInputs, FrameOut, Octets, Publication};
use super::hearing::Hearing;
use super::messages::{
    Cuts, FinalReport, Frame, FrameEnds, Notice, Order, Repair, Repaired, Report, RunConfig,
};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// Nanoseconds of wall time since any fixed point; the core only compares them.
pub type WallNs = u64;

/// How long an incomplete frame waits for the network before it is repaired by request.
pub const REPAIR_AFTER_NS: WallNs = 2_000_000;

/// How long a repair may take before it is asked for again.
const REPAIR_AGAIN_NS: WallNs = 200_000_000;

/// Frames of own PDUs kept for repair: far more than any grant horizon.
const KEPT_FRAMES: usize = 512;

/// PDUs waiting for the frame end that names them, at most; beyond, the oldest go.
const MAX_WAITING: usize = 200_000;

/// What a member wants done.
#[derive(Debug)]
pub enum Effect {
    /// Send PDUs to the data plane.
    Send(Vec<Octets>),
    /// Tell conductor and consumers.
    Report(Report),
    /// Ask a producer for PDUs.
    Repair {
        /// Producer.
        name: String,
        /// What is missing.
        repair: Repair,
    },
    /// Publish on the bus.
    Publish(Publication),
    /// Leave with this exit code.
    Exit(u8),
}

/// Counters of the data plane as this member saw it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinkCounters {
    /// PDUs that arrived and belong to a frame of the federation.
    pub received: u64,
    /// PDUs of the federation that did not arrive before their frame was repaired.
    pub lost: u64,
    /// PDUs fetched by request.
    pub repaired: u64,
    /// PDUs sent.
    pub sent: u64,
    /// PDUs of outsiders handed to the federate.
    pub outsiders: u64,
}

/// What this member knows of one producer.
#[derive(Debug, Default)]
struct Producer {
    /// Frame ends seen without a gap up to here; `None` before the first.
    ended: Option<Frame>,
    /// The incarnation whose messages no longer count.
    sealed_inc: Option<u64>,
    /// While its loss is being settled: how far this member said that it holds its frames. It uses no more.
    bound: Option<Option<Frame>>,
    /// Frames that have not ended count as absent.
    absent: bool,
    /// Frames that have not ended are awaited from a successor.
    awaited: bool,
}

/// One frame's PDUs that are named but not all here.
#[derive(Debug)]
struct Incomplete {
    missing: Vec<u64>,
    since: WallNs,
    asked: Option<WallNs>,
    producer: String,
}

/// The state machine around a [`Federate`].
pub struct Member {
    federate: Box<dyn Federate>,
    name: String,
    inc: u64,
    config: Option<RunConfig>,
    heard: BTreeSet<String>,
    granted: Frame,
    /// Frame executed; `None` before configuration.
    executed: Frame,
    /// Frame up to which ends were reported.
    reported: Option<Frame>,
    unreported: FrameEnds,
    producers: BTreeMap<String, Producer>,
    incomplete: BTreeMap<(Frame, String), Incomplete>,
    /// Arrived PDUs that no frame end has named yet: hash → (octets, arrival number).
    waiting: BTreeMap<u64, (Octets, u64)>,
    waiting_order: VecDeque<(u64, u64, Frame)>,
    arrivals: u64,
    /// Inputs by frame and producer.
    ready: BTreeMap<(Frame, String), Vec<Octets>>,
    /// Notices by the frame of their effect and producer, each with the frame in which it was made.
    notices: BTreeMap<(Frame, String), Vec<(Frame, Notice)>>,
    /// The view whose cuts are to be held: number, last frame of each lost member.
    holding: Option<(u32, Cuts)>,
    /// The federation goes on without this incarnation.
    outcast: bool,
    own: VecDeque<(Frame, Vec<(u64, Octets)>)>,
    closed: bool,
    /// What frame 0 consists of, until time is granted.
    zero: Option<FrameOut>,
    made: Digest,
    counters: LinkCounters,
    window: Frame,
    microseconds: fn() -> u64,
    exec: ExecTimes,
    hearing: Hearing,
}

/// Execution times of steps, µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExecTimes {
    /// Steps timed.
    pub steps: u64,
    /// Sum.
    pub sum_us: u64,
    /// Longest.
    pub max_us: u64,
}

impl Member {
    /// A member called `name` with the incarnation that the conductor gave it. `microseconds` reads a
    /// monotonic clock for statistics only; tests pass `|| 0`.
    #[must_use]
    pub fn new(
        federate: Box<dyn Federate>,
        name: &str,
        inc: u64,
        microseconds: fn() -> u64,
    ) -> Self {
        Self {
            federate,
            name: name.to_owned(),
            inc,
            config: None,
            heard: BTreeSet::new(),
            granted: 0,
            executed: 0,
            reported: None,
            unreported: FrameEnds {
                run: 0,
                inc,
                first: 0,
                last: 0,
                pdus: Vec::new(),
                notices: Vec::new(),
            },
            producers: BTreeMap::new(),
            incomplete: BTreeMap::new(),
            waiting: BTreeMap::new(),
            waiting_order: VecDeque::new(),
            arrivals: 0,
            ready: BTreeMap::new(),
            notices: BTreeMap::new(),
            holding: None,
            outcast: false,
            own: VecDeque::new(),
            closed: false,
            zero: None,
            made: Digest::default(),
            counters: LinkCounters::default(),
            window: 10,
            microseconds,
            exec: ExecTimes::default(),
            hearing: Hearing::default(),
        }
    }

    /// What it hears of its producers on the data plane.
    pub fn hearing(&mut self) -> &mut Hearing {
        &mut self.hearing
    }

    /// Frame executed.
    #[must_use]
    pub fn executed(&self) -> Frame {
        self.executed
    }

    /// Counters of the data plane.
    #[must_use]
    pub fn counters(&self) -> &LinkCounters {
        &self.counters
    }

    /// Execution times since the last call.
    pub fn take_exec(&mut self) -> ExecTimes {
        std::mem::take(&mut self.exec)
    }

    /// The logic inside.
    #[must_use]
    pub fn federate(&self) -> &dyn Federate {
        &*self.federate
    }

    /// An order of the conductor.
    pub fn order(&mut self, order: Order, effects: &mut Vec<Effect>) {
        let run = self.config.as_ref().map_or(0, |c| c.run);
        match order {
            Order::Muster => {
                let hears = self.heard.iter().cloned().collect();
                let consumes = self.federate.consumes();
                let present = Report::Present { inc: self.inc, hears, consumes };
                effects.push(Effect::Report(present));
            }
            Order::Configure(config) => self.configure(config, effects),
            Order::Grant { run: of, upto } if of == run && !self.closed => {
                self.granted = self.granted.max(upto);
                // Every member is ready now, so frame 0 finds all its consumers.
                if let Some(out) = self.zero.take() {
                    self.emit(0, out, effects);
                    self.report_ends(effects);
                }
                self.advance(effects);
            }
            Order::Seal { run: of, view, lost } if of == run => self.seal(view, &lost, effects),
            Order::Cut { run: of, view, cuts } if of == run => {
                self.holding = Some((view, cuts));
                self.hold(effects);
            }
            Order::View { run: of, cuts, absent, .. } if of == run => {
                self.view(&cuts, &absent);
                self.advance(effects);
                if self.reported.is_some_and(|reported| self.executed > reported) {
                    self.report_ends(effects);
                }
            }
            Order::Finish { run: of, frame } if of == run && !self.closed => {
                self.closed = true;
                let mut report =
                    FinalReport { run, name: self.name.clone(), frame, ..Default::default() };
                let c = &self.counters;
                report.values = vec![
                    ("pdus_sent".into(), c.sent as f64),
                    ("pdus_received".into(), c.received as f64),
                    ("pdus_lost".into(), c.lost as f64),
                    ("pdus_repaired".into(), c.repaired as f64),
                    ("outsiders".into(), c.outsiders as f64),
                ];
                report.digests.push(("pdus".into(), self.made.0));
                self.federate.finish(&mut report);
                effects.push(Effect::Report(Report::Final(Box::new(report))));
            }
            Order::Exit { code } => effects.push(Effect::Exit(code)),
            // Orders of another run: the federation went on without them.
            _ => {}
        }
    }

    /// Accepts nothing more of the lost, and says how far it holds their frames.
    fn seal(&mut self, view: u32, lost: &[(String, u64)], effects: &mut Vec<Effect>) {
        self.holding = None;
        let run = self.config.as_ref().map_or(0, |c| c.run);
        let mut holds = Vec::new();
        for (name, inc) in lost {
            self.outcast |= *name == self.name && *inc == self.inc;
            if !self.federate.consumes() {
                continue;
            }
            // No further than granted: what nobody may use yet, nobody has used.
            let complete = self.complete_of(name).map(|c| c.min(self.granted));
            if let Some(producer) = self.producers.get_mut(name) {
                producer.sealed_inc = Some(*inc);
                producer.bound = Some(complete);
                holds.push((name.clone(), complete));
            }
        }
        effects.push(Effect::Report(Report::Sealed { run, view, holds }));
    }

    /// Says that every frame up to the cuts is here, once it is.
    fn hold(&mut self, effects: &mut Vec<Effect>) {
        let Some((view, cuts)) = &self.holding else { return };
        let lacks = |(name, cut): &(String, Option<Frame>)| {
            self.producers.contains_key(name) && self.complete_of(name) < *cut
        };
        if !self.federate.consumes() || !cuts.iter().any(lacks) {
            let run = self.config.as_ref().map_or(0, |c| c.run);
            effects.push(Effect::Report(Report::Held { run, view: *view }));
            self.holding = None;
        }
    }

    /// Frames up to the cuts count for everybody, later ones of the lost for nobody.
    fn view(&mut self, cuts: &[(String, Option<Frame>)], absent: &[String]) {
        for (name, cut) in cuts {
            let Some(producer) = self.producers.get_mut(name) else { continue };
            producer.ended = producer.ended.min(*cut);
            producer.bound = None;
            producer.absent = absent.contains(name);
            producer.awaited = !producer.absent;
            self.ready.retain(|(frame, of), _| of != name || Some(*frame) <= *cut);
            for ((_, of), notices) in &mut self.notices {
                if of == name {
                    notices.retain(|(made, _)| Some(*made) <= *cut);
                }
            }
            self.incomplete.retain(|(frame, of), _| of != name || Some(*frame) <= *cut);
        }
    }

    fn configure(&mut self, config: RunConfig, effects: &mut Vec<Effect>) {
        let mut out = FrameOut::default();
        let run = config.run;
        self.producers =
            config.producers.iter().map(|name| (name.clone(), Producer::default())).collect();
        self.granted = 0;
        self.executed = 0;
        self.reported = None;
        self.closed = false;
        self.made = Digest::default();
        self.incomplete.clear();
        self.hearing.configure();
        self.ready.clear();
        self.notices.clear();
        self.holding = None;
        self.own.clear();
        self.counters = LinkCounters::default();
        if self.config.is_some() {
            self.waiting.clear();
            self.waiting_order.clear();
        }
        let configured = self.federate.configure(&config, &mut out);
        self.config = Some(config);
        match configured {
            Ok(()) => {
                self.unreported = FrameEnds {
                    run,
                    inc: self.inc,
                    first: 0,
                    last: 0,
                    pdus: Vec::new(),
                    notices: Vec::new(),
                };
                self.zero = Some(out);
                effects.push(Effect::Report(Report::Ready { run, inc: self.inc }));
            }
            Err(reason) => effects.push(Effect::Report(Report::Failed { reason })),
        }
    }

    /// A report of another member.
    pub fn report(&mut self, now: WallNs, from: &str, report: Report, effects: &mut Vec<Effect>) {
        let ends = match report {
            Report::Ends(ends) => ends,
            Report::Present { .. } => {
                self.heard.insert(from.to_owned());
                return;
            }
            Report::Ready { .. } if self.producers.contains_key(from) => {
                self.hearing.ready(now, from);
                return;
            }
            _ => return,
        };
        let run = self.config.as_ref().map_or(0, |c| c.run);
        if ends.run != run || !self.federate.consumes() || self.closed {
            return;
        }
        let Some(producer) = self.producers.get_mut(from) else { return };
        let expected = producer.ended.map_or(0, |e| e + 1);
        if producer.sealed_inc == Some(ends.inc) || ends.first != expected {
            return;
        }
        producer.ended = Some(ends.last);
        for (made, effect, notice) in ends.notices {
            let notices = self.notices.entry((effect.max(made), from.to_owned())).or_default();
            notices.push((made, notice));
        }
        for (frame, hashes) in ends.pdus {
            let (named, mut missing) = (hashes.len(), Vec::new());
            for hash in hashes {
                match self.waiting.remove(&hash) {
                    Some((octets, _)) => {
                        self.counters.received += 1;
                        self.ready.entry((frame, from.to_owned())).or_default().push(octets);
                    }
                    None => missing.push(hash),
                }
            }
            self.hearing.named(now, from, named as u64, (named - missing.len()) as u64);
            if !missing.is_empty() {
                let producer = from.to_owned();
                self.incomplete.insert(
                    (frame, producer.clone()),
                    Incomplete { missing, since: now, asked: None, producer },
                );
            }
        }
        self.advance(effects);
    }

    /// PDUs from the data plane, each with the frame that its timestamp names (the frame now granted
    /// for outsiders without a usable one).
    pub fn pdus(&mut self, pdus: impl IntoIterator<Item = Octets>, effects: &mut Vec<Effect>) {
        if !self.federate.consumes() {
            return;
        }
        let mut completed = false;
        for octets in pdus {
            let hash = pdu_hash(&octets);
            self.arrivals += 1;
            let named = self.incomplete.iter_mut().find_map(|(key, i)| {
                let at = i.missing.iter().position(|&m| m == hash)?;
                i.missing.swap_remove(at);
                Some((key.clone(), i.missing.is_empty()))
            });
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
            self.hold(effects);
            self.advance(effects);
        }
    }

    /// PDUs that a producer sent again.
    pub fn repaired(&mut self, repaired: Repaired, effects: &mut Vec<Effect>) {
        if Some(repaired.run) != self.config.as_ref().map(|c| c.run) {
            return;
        }
        for (frame, octets) in repaired.pdus {
            let hash = pdu_hash(&octets);
            let Some((key, incomplete)) = self
                .incomplete
                .iter_mut()
                .find(|((f, _), i)| *f == frame && i.missing.contains(&hash))
            else {
                continue;
            };
            incomplete.missing.retain(|&m| m != hash);
            self.counters.lost += 1;
            self.counters.repaired += 1;
            let (key, complete) = (key.clone(), incomplete.missing.is_empty());
            self.hearing.repaired(&key.1, 1);
            self.ready.entry(key.clone()).or_default().push(Arc::from(octets));
            if complete {
                self.incomplete.remove(&key);
            }
        }
        self.hold(effects);
        self.advance(effects);
    }

    /// Answers a consumer that missed PDUs.
    #[must_use]
    pub fn repair(&self, repair: &Repair) -> Repaired {
        let run = self.config.as_ref().map_or(0, |c| c.run);
        let mut pdus = Vec::new();
        if repair.run == run {
            for (frame, hashes) in &repair.wanted {
                let Some((_, made)) = self.own.iter().find(|(f, _)| f == frame) else { continue };
                pdus.extend(
                    made.iter()
                        .filter(|(hash, _)| hashes.contains(hash))
                        .map(|(_, octets)| (*frame, octets.to_vec())),
                );
            }
        }
        Repaired { run, pdus }
    }

    /// Time passed: asks for what is missing too long.
    pub fn tick(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let mut asks: BTreeMap<String, Vec<(Frame, Vec<u64>)>> = BTreeMap::new();
        for ((frame, _), incomplete) in &mut self.incomplete {
            let due = incomplete
                .asked
                .map_or(incomplete.since + REPAIR_AFTER_NS, |asked| asked + REPAIR_AGAIN_NS);
            if now >= due {
                incomplete.asked = Some(now);
                asks.entry(incomplete.producer.clone())
                    .or_default()
                    .push((*frame, incomplete.missing.clone()));
            }
        }
        let run = self.config.as_ref().map_or(0, |c| c.run);
        for (name, wanted) in asks {
            effects.push(Effect::Repair { name, repair: Repair { run, wanted } });
        }
    }

    /// When [`Member::tick`] has something to do.
    #[must_use]
    pub fn deadline(&self) -> Option<WallNs> {
        self.incomplete
            .values()
            .map(|i| i.asked.map_or(i.since + REPAIR_AFTER_NS, |asked| asked + REPAIR_AGAIN_NS))
            .min()
    }

    /// Highest frame of producer `name` up to which all is complete here; none if not even frame 0 is.
    fn complete_of(&self, name: &str) -> Option<Frame> {
        let ended = self.producers.get(name)?.ended?;
        let missing = self.incomplete.keys().filter(|(_, of)| of == name).map(|(frame, _)| *frame);
        match missing.min() {
            Some(frame) => frame.checked_sub(1).map(|before| before.min(ended)),
            None => Some(ended),
        }
    }

    /// Last frame whose inputs are complete; none if not even those of frame 0 are.
    fn complete(&self) -> Option<Frame> {
        if !self.federate.consumes() {
            return Some(Frame::MAX);
        }
        let of = |(name, producer): (&String, &Producer)| {
            if producer.absent {
                return Some(Frame::MAX);
            }
            let complete = self.complete_of(name);
            producer.bound.map_or(complete, |bound| complete.min(bound))
        };
        self.producers.iter().map(of).min().unwrap_or(Some(Frame::MAX))
    }

    fn advance(&mut self, effects: &mut Vec<Effect>) {
        if self.config.is_none() || self.closed || self.outcast {
            return;
        }
        // Frame 0 of every producer must have been seen before frame 1 is due.
        let Some(complete) = self.complete() else { return };
        let upto = self.granted.min(complete);
        let period = self.federate.period();
        let before = self.executed;
        while self.executed < upto {
            let frame = self.executed + 1;
            self.executed = frame;
            let mut out = FrameOut::default();
            if frame.is_multiple_of(period) {
                let inputs = self.inputs_up_to(frame);
                let started = (self.microseconds)();
                self.federate.step(frame, &inputs, &mut out);
                let took = (self.microseconds)().saturating_sub(started);
                self.exec.steps += 1;
                self.exec.sum_us += took;
                self.exec.max_us = self.exec.max_us.max(took);
            }
            self.emit(frame, out, effects);
        }
        let reported = self.reported.unwrap_or(0);
        // Report at the horizon and often enough before it that the conductor can move it.
        let stands = self.executed == self.granted || self.producers.values().any(|p| p.awaited);
        if self.executed > before && (stands || self.executed - reported >= self.window) {
            self.report_ends(effects);
        }
    }

    fn inputs_up_to(&mut self, frame: Frame) -> FrameInputs {
        let mut inputs = FrameInputs::default();
        let next = (frame + 1, String::new());
        let later = self.ready.split_off(&next);
        for ((frame, _), pdus) in std::mem::replace(&mut self.ready, later) {
            inputs.pdus.extend(pdus.into_iter().map(|octets| (frame, octets)));
        }
        inputs.pdus.sort();
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

    fn emit(&mut self, frame: Frame, out: FrameOut, effects: &mut Vec<Effect>) {
        self.unreported.last = frame;
        if !out.pdus.is_empty() {
            let mut made: Vec<_> =
                out.pdus.iter().map(|octets| (pdu_hash(octets), octets.clone())).collect();
            made.sort_by_key(|(hash, _)| *hash);
            self.unreported.pdus.push((frame, made.iter().map(|(hash, _)| *hash).collect()));
            self.own.push_back((frame, made));
            while self.own.len() > KEPT_FRAMES {
                self.own.pop_front();
            }
            out.pdus.iter().for_each(|octets| self.made.add(frame, octets));
            self.counters.sent += out.pdus.len() as u64;
            effects.push(Effect::Send(out.pdus));
        }
        let now = out.notices.into_iter().map(|notice| (frame, notice));
        let stamped = now.chain(out.later).map(|(effect, n)| (frame, effect.max(frame), n));
        self.unreported.notices.extend(stamped);
        effects.extend(out.publish.into_iter().map(Effect::Publish));
    }

    fn report_ends(&mut self, effects: &mut Vec<Effect>) {
        let next = FrameEnds {
            run: self.unreported.run,
            inc: self.inc,
            first: self.executed + 1,
            last: self.executed + 1,
            pdus: Vec::new(),
            notices: Vec::new(),
        };
        let ends = std::mem::replace(&mut self.unreported, next);
        self.reported = Some(ends.last);
        effects.push(Effect::Report(Report::Ends(ends)));
    }
}
