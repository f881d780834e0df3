//! A member of the federation as a state machine: orders, reports, beats and datagrams in; reports,
//! datagrams, requests and publications out. It executes frame k when k is granted and every input of k
//! is complete, never because a timer fired.

mod inputs;
mod past;
mod returning;

use super::clock::WallNs;
use super::digest::{Digest, content, pdu_hash};
use super::federate::{Aside, Federate, FrameOut, Octets, Publication};
use super::hearing::Hearing;
use super::messages::{
    Accepted, Beat, Cuts, FetchOf, Fetched, FinalReport, Frame, FrameEnds, Joined, Notice,
    Numbered, Order, Repair, Report, RunConfig, Was,
};
use super::stream::{Inbox, Outbox};
use inputs::{Incomplete, Producer};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

pub use past::Pages;
pub use returning::{Makers, Remake};

/// How the conductor is called where messages of streams are asked for.
pub const CONDUCTOR: &str = "conductor";

/// Frames of own PDUs kept for repair and return: far more than any grant horizon.
const KEPT_FRAMES: usize = 512;

/// Octets of PDUs told whole in one report.
const WHOLE_OCTETS: usize = 128 << 10;

/// PDUs waiting for the frame end that names them, at most; beyond, the oldest go.
const MAX_WAITING: usize = 200_000;

/// What a member wants done.
#[derive(Debug)]
pub enum Effect {
    /// Send PDUs to the data plane.
    Send(Vec<Octets>),
    /// Tell conductor and consumers.
    Report(Numbered<Report>),
    /// Ask somebody who may have them for PDUs.
    Repair {
        /// Whom.
        name: String,
        /// What is missing.
        repair: Repair,
    },
    /// Ask somebody who may have them for messages of a stream.
    Fetch {
        /// Whom.
        holder: String,
        /// What is missing.
        ask: FetchOf,
    },
    /// Publish on the bus.
    Publish(Publication),
    /// The federation goes on without this incarnation: join again.
    Rejoin(Was),
    /// Take the place of a lost member beside this one.
    Host {
        /// Its name.
        name: String,
        /// Number of traffic generators of the run.
        generators: u32,
    },
    /// The federation does not take this process back.
    Dismissed(String),
    /// The process of this one takes its place: leave.
    Yielded(String),
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

/// What is being executed, for the thread that says so while the federate is at it.
#[derive(Debug, Default)]
pub struct Pulse {
    /// Frame + 1; 0 while nothing is executed.
    frame: AtomicU64,
    since_us: AtomicU64,
}

impl Pulse {
    fn begin(&self, frame: Frame, now_us: u64) {
        self.since_us.store(now_us, Ordering::Relaxed);
        self.frame.store(frame + 1, Ordering::Relaxed);
    }

    fn end(&self) {
        self.frame.store(0, Ordering::Relaxed);
    }

    /// The frame that is being executed, and for how long, ms.
    #[must_use]
    pub fn working(&self, now_us: u64) -> Option<(Frame, u64)> {
        let frame = self.frame.load(Ordering::Relaxed).checked_sub(1)?;
        Some((frame, now_us.saturating_sub(self.since_us.load(Ordering::Relaxed)) / 1000))
    }
}

/// How often it is said that time stands: others forget an entity after 12 s of silence.
const STANDS_EVERY_NS: WallNs = 4_000_000_000;

/// What this member made in a frame.
#[derive(Debug)]
struct Own {
    frame: Frame,
    pdus: Vec<(u64, Octets)>,
    notices: Vec<(Frame, Notice)>,
    /// Digest of all that it made up to and in this frame.
    made: u64,
}

/// The state machine around a [`Federate`].
pub struct Member {
    federate: Box<dyn Federate>,
    name: String,
    fed: u128,
    inc: u64,
    orders: Inbox<Order>,
    outbox: Outbox<Report>,
    peers: BTreeMap<String, Inbox<Report>>,
    config: Option<RunConfig>,
    heard: BTreeSet<String>,
    granted: Frame,
    /// Frame executed; `None` before configuration.
    executed: Frame,
    /// Frame up to which ends were reported.
    reported: Option<Frame>,
    unreported: FrameEnds,
    producers: BTreeMap<String, Producer>,
    /// Frame ends that came in parts, by producer, of an incarnation.
    joined: BTreeMap<String, (u64, Joined)>,
    /// Frame ends that may not be used yet: of an incarnation that is not admitted, or that is being sealed.
    early: BTreeMap<String, Vec<(u64, FrameEnds)>>,
    incomplete: BTreeMap<(Frame, String), Incomplete>,
    /// Arrived PDUs that no frame end has named yet: hash → (octets, arrival number).
    waiting: BTreeMap<u64, (Octets, u64)>,
    waiting_order: VecDeque<(u64, u64, Frame)>,
    arrivals: u64,
    /// Inputs by frame and producer.
    ready: BTreeMap<(Frame, String), Vec<Octets>>,
    /// Notices by the frame of their effect and producer, each with the frame in which it was made.
    notices: BTreeMap<(Frame, String), Vec<(Frame, Notice)>>,
    /// Inputs of the latest frames executed, for other consumers that lack them.
    eaten: VecDeque<(Frame, Vec<Octets>)>,
    /// The view whose cuts are to be held: number, last frame of each lost member.
    holding: Option<(u32, Cuts)>,
    /// The federation goes on without this incarnation.
    outcast: bool,
    own: VecDeque<Own>,
    /// Digests of the federate's state at the ends of the latest reports.
    states: VecDeque<(Frame, u64)>,
    /// Digest of all that was made.
    content: u64,
    closed: bool,
    /// Time stands: when that is said again.
    stands: Option<WallNs>,
    /// What frame 0 consists of, until time is granted.
    zero: Option<FrameOut>,
    made: Digest,
    counters: LinkCounters,
    window: Frame,
    microseconds: fn() -> u64,
    exec: ExecTimes,
    pulse: Arc<Pulse>,
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
    /// A member called `name`, as the conductor accepted it. `microseconds` reads a monotonic clock for
    /// statistics and beats only; tests pass `|| 0`.
    #[must_use]
    pub fn new(
        federate: Box<dyn Federate>,
        name: &str,
        accepted: &Accepted,
        microseconds: fn() -> u64,
    ) -> Self {
        let Accepted { fed, inc, orders, .. } = *accepted;
        Self {
            federate,
            name: name.to_owned(),
            fed,
            inc,
            orders: Inbox::new(fed, 0, orders + 1),
            outbox: Outbox::new(fed, inc),
            peers: BTreeMap::new(),
            config: None,
            heard: BTreeSet::new(),
            granted: 0,
            executed: 0,
            reported: None,
            unreported: FrameEnds::default(),
            producers: BTreeMap::new(),
            joined: BTreeMap::new(),
            early: BTreeMap::new(),
            incomplete: BTreeMap::new(),
            waiting: BTreeMap::new(),
            waiting_order: VecDeque::new(),
            arrivals: 0,
            ready: BTreeMap::new(),
            notices: BTreeMap::new(),
            eaten: VecDeque::new(),
            holding: None,
            outcast: false,
            own: VecDeque::new(),
            states: VecDeque::new(),
            content: 0,
            closed: false,
            stands: None,
            zero: None,
            made: Digest::default(),
            counters: LinkCounters::default(),
            window: 10,
            microseconds,
            exec: ExecTimes::default(),
            pulse: Arc::default(),
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

    /// Incarnation.
    #[must_use]
    pub fn inc(&self) -> u64 {
        self.inc
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

    /// What is being executed.
    #[must_use]
    pub fn pulse(&self) -> Arc<Pulse> {
        Arc::clone(&self.pulse)
    }

    fn run(&self) -> u32 {
        self.config.as_ref().map_or(0, |c| c.run)
    }

    /// A part of this process cannot go on.
    pub fn fail(&mut self, reason: String, effects: &mut Vec<Effect>) {
        self.tell(Report::Failed { reason }, effects);
    }

    /// Says that time stands, where it is due and there is something to say.
    fn stand(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.stands.is_some_and(|due| now >= due) {
            let told = self.aside(Aside::Stands, effects);
            self.stands = told.then_some(now + STANDS_EVERY_NS);
        }
    }

    /// Sends what belongs to no frame; says whether there was any.
    fn aside(&mut self, what: Aside, effects: &mut Vec<Effect>) -> bool {
        let pdus = self.federate.aside(what);
        let any = !pdus.is_empty();
        if any {
            effects.push(Effect::Send(pdus));
        }
        any
    }

    fn tell(&mut self, report: Report, effects: &mut Vec<Effect>) {
        effects.push(Effect::Report(self.outbox.push(report)));
    }

    /// An order of the conductor.
    pub fn order(&mut self, now: WallNs, order: Numbered<Order>, effects: &mut Vec<Effect>) {
        if order.fed != self.fed || order.inc != 0 {
            return;
        }
        if order.seq == 0 {
            return self.carry_out(now, order.body, effects);
        }
        for order in self.orders.take(now, order) {
            self.carry_out(now, order, effects);
        }
    }

    fn carry_out(&mut self, now: WallNs, order: Order, effects: &mut Vec<Effect>) {
        let run = self.run();
        match order {
            Order::Muster => {
                let hears = self.heard.iter().cloned().collect();
                let consumes = self.federate.consumes();
                let present = self.outbox.loose(Report::Present { hears, consumes });
                effects.push(Effect::Report(present));
            }
            Order::Configure(config) => self.configure(config, effects),
            Order::Grant { run: of, upto } if of == run && !self.closed => {
                if self.stands.take().is_some() {
                    self.aside(Aside::GoesOn, effects);
                }
                self.granted = self.granted.max(upto);
                // Every member is ready now, so frame 0 finds all its consumers.
                if let Some(out) = self.zero.take() {
                    self.emit(0, out, effects);
                    self.report_ends(effects);
                }
                self.advance(effects);
            }
            // Frozen before the first grant: nobody has been told of anybody yet, and frame 0 is still to come.
            Order::Stand { run: of } if of == run && !self.closed && self.zero.is_none() => {
                self.stands = Some(now);
                self.stand(now, effects);
            }
            Order::Seal { run: of, view, lost } if of == run => self.seal(view, &lost, effects),
            Order::Cut { run: of, view, cuts } if of == run => {
                self.holding = Some((view, cuts));
                self.take_early(now);
                self.hold(now, effects);
            }
            Order::View { run: of, cuts, absent, .. } if of == run => {
                self.view(&cuts, &absent);
                self.advance(effects);
                if self.reported.is_some_and(|reported| self.executed > reported) {
                    self.report_ends(effects);
                }
            }
            Order::Admit { run: of, name, inc, from } if of == run => {
                if name == self.name {
                    self.report_again(from, effects);
                } else {
                    self.admit(now, &name, inc, from);
                    self.advance(effects);
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
                self.tell(Report::Final(Box::new(report)), effects);
                self.stands = None;
                self.aside(Aside::Over, effects);
            }
            Order::Logged { run: of, name, upto } if of == run => {
                if let Some(producer) = self.producers.get_mut(&name) {
                    producer.logged = producer.logged.max(Some(upto));
                    self.advance(effects);
                }
            }
            Order::Host { run: of, name, by } if of == run && by == self.name => {
                let generators = self.config.as_ref().map_or(1, |c| c.generators);
                effects.push(Effect::Host { name, generators });
            }
            Order::Dismiss { name, inc, reason } if name == self.name && inc == self.inc => {
                effects.push(Effect::Dismissed(reason));
            }
            Order::Yield { name, inc, to } if name == self.name && inc == self.inc => {
                effects.push(Effect::Yielded(to));
            }
            Order::Exit { code } => effects.push(Effect::Exit(code)),
            // Orders of another run: the federation went on without them.
            _ => {}
        }
    }

    /// Accepts nothing more of the lost, and says how far it holds their frames.
    fn seal(&mut self, view: u32, lost: &[(String, u64)], effects: &mut Vec<Effect>) {
        self.holding = None;
        let mut holds = Vec::new();
        for (name, inc) in lost {
            self.outbox.forget(name);
            if *name == self.name && *inc == self.inc {
                return self.cast_out(effects);
            }
            if !self.federate.consumes() {
                continue;
            }
            // No further than granted: what nobody may use yet, nobody has used.
            let complete = self.complete_of(name).map(|c| c.min(self.granted));
            let complete = self.in_log(name, complete);
            if let Some(producer) = self.producers.get_mut(name) {
                producer.bound = Some(complete);
                holds.push((name.clone(), complete));
            }
        }
        let run = self.run();
        self.tell(Report::Sealed { run, view, holds }, effects);
    }

    /// The others go on without this incarnation: it stops, and joins again.
    fn cast_out(&mut self, effects: &mut Vec<Effect>) {
        if !self.outcast {
            self.outcast = true;
            let run = self.run();
            effects.push(Effect::Rejoin(Was { fed: self.fed, inc: self.inc, run }));
        }
    }

    /// Says that every frame up to the cuts is here, once it is; asks others for what the lost no longer give.
    fn hold(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let Some((view, cuts)) = self.holding.take() else { return };
        let mut lacks = false;
        for (name, cut) in &cuts {
            let consumed = self.federate.consumes() && self.producers.contains_key(name);
            if consumed && self.complete_of(name) < *cut {
                lacks = true;
                if self.producers.get(name).is_some_and(|p| p.ended < *cut)
                    && let Some(inbox) = self.peers.get_mut(name)
                {
                    inbox.told(now, inbox.seen() + 1);
                }
            }
        }
        if lacks {
            self.holding = Some((view, cuts));
        } else {
            let run = self.run();
            self.tell(Report::Held { run, view }, effects);
        }
    }

    /// Frames up to the cuts count for everybody, later ones of the lost for nobody.
    fn view(&mut self, cuts: &[(String, Option<Frame>)], absent: &[String]) {
        self.holding = None;
        if !self.federate.consumes() {
            return;
        }
        let stepped = self.executed - self.executed % self.federate.period();
        let used = Some(stepped).filter(|frame| *frame > 0);
        for (name, cut) in cuts {
            let Some(producer) = self.producers.get_mut(name) else { continue };
            // One that is lost itself may have used more than the others hold: a successor makes the same again.
            let used = used.filter(|_| !absent.contains(name)).min(producer.ended);
            let kept = (*cut).max(used);
            producer.ended = producer.ended.min(kept);
            producer.bound = None;
            producer.inc = None;
            producer.absent = absent.contains(name);
            producer.awaited = !producer.absent;
            let counts = |frame: Frame| Some(frame) <= kept;
            self.ready.retain(|(frame, of), _| of != name || counts(*frame));
            for ((_, of), notices) in &mut self.notices {
                if of == name {
                    notices.retain(|(made, _)| counts(*made));
                }
            }
            self.incomplete.retain(|(frame, of), _| of != name || counts(*frame));
        }
    }

    fn configure(&mut self, config: RunConfig, effects: &mut Vec<Effect>) {
        match self.begin(config) {
            Ok(out) => {
                self.zero = Some(out);
                let run = self.run();
                self.tell(Report::Ready { run, at: None }, effects);
            }
            Err(reason) => self.tell(Report::Failed { reason }, effects),
        }
    }

    /// Back to frame 0 of a run.
    fn begin(&mut self, config: RunConfig) -> Result<FrameOut, String> {
        let mut out = FrameOut::default();
        let inc = |name: &String| config.incs.iter().find(|(n, _)| n == name).map(|(_, inc)| *inc);
        let live = |name: &String| config.live.contains(name);
        let producer =
            |name: &String| Producer { inc: inc(name), live: live(name), ..Producer::default() };
        // One that makes notices for other consumers does not wait for itself.
        let reads = |n: &&String| **n != self.name && self.federate.ahead_of(n).is_some();
        let others = config.producers.iter().filter(reads);
        self.producers = others.map(|n| (n.clone(), producer(n))).collect();
        self.granted = 0;
        self.executed = 0;
        self.reported = None;
        self.closed = false;
        self.stands = None;
        self.made = Digest::default();
        self.content = 0;
        self.early.clear();
        self.incomplete.clear();
        self.hearing.configure(config.run, self.producers.keys());
        self.ready.clear();
        self.notices.clear();
        self.eaten.clear();
        self.holding = None;
        self.own.clear();
        self.states.clear();
        self.zero = None;
        self.counters = LinkCounters::default();
        if self.config.is_some() {
            self.waiting.clear();
            self.waiting_order.clear();
        }
        self.unreported = FrameEnds { run: config.run, ..FrameEnds::default() };
        let configured = self.federate.configure(&config, &mut out);
        self.config = Some(config);
        configured.map(|()| out)
    }

    fn advance(&mut self, effects: &mut Vec<Effect>) {
        if self.config.is_none() || self.closed || self.outcast {
            return;
        }
        // Frame 0 of every producer must have been seen before frame 1 is due.
        let Some(complete) = self.complete() else { return };
        let upto = self.granted.min(complete);
        let before = self.executed;
        while self.executed < upto {
            let frame = self.executed + 1;
            let out = self.execute(frame);
            self.emit(frame, out, effects);
        }
        let reported = self.reported.unwrap_or(0);
        // Report at the horizon and often enough before it that the conductor can move it.
        let stands = self.executed == self.granted
            || self.federate.in_loop()
            || self.producers.values().any(|p| p.awaited);
        if self.executed > before && (stands || self.executed - reported >= self.window) {
            self.report_ends(effects);
        }
    }

    fn execute(&mut self, frame: Frame) -> FrameOut {
        self.executed = frame;
        let mut out = FrameOut::default();
        if frame.is_multiple_of(self.federate.period()) {
            let inputs = self.inputs_up_to(frame);
            let started = (self.microseconds)();
            self.pulse.begin(frame, started);
            self.federate.step(frame, &inputs, &mut out);
            self.pulse.end();
            let took = (self.microseconds)().saturating_sub(started);
            self.exec.steps += 1;
            self.exec.sum_us += took;
            self.exec.max_us = self.exec.max_us.max(took);
        }
        out
    }

    /// Keeps what a frame consists of.
    fn keep(&mut self, frame: Frame, out: &mut FrameOut) {
        let mut pdus: Vec<_> = out.pdus.iter().map(|o| (pdu_hash(o), o.clone())).collect();
        pdus.sort_by_key(|(hash, _)| *hash);
        let now = out.notices.drain(..).map(|notice| (frame, notice));
        let later = out.later.drain(..).map(|(effect, notice)| (effect.max(frame), notice));
        let notices: Vec<_> = now.chain(later).collect();
        out.pdus.iter().for_each(|octets| self.made.add(frame, octets));
        self.counters.sent += out.pdus.len() as u64;
        self.content = self.content.wrapping_add(content(
            frame,
            pdus.iter().map(|(hash, _)| *hash),
            notices.iter().map(|(effect, notice)| (*effect, notice)),
        ));
        self.own.push_back(Own { frame, pdus, notices, made: self.content });
        while self.own.len() > KEPT_FRAMES {
            self.own.pop_front();
        }
    }

    fn emit(&mut self, frame: Frame, mut out: FrameOut, effects: &mut Vec<Effect>) {
        self.keep(frame, &mut out);
        self.unreported.last = frame;
        if let Some(own) = self.own.back() {
            name_frame(own, &mut self.unreported);
        }
        if !out.pdus.is_empty() {
            effects.push(Effect::Send(out.pdus));
        }
        effects.extend(out.publish.into_iter().map(Effect::Publish));
    }

    fn report_ends(&mut self, effects: &mut Vec<Effect>) {
        let next = self.executed + 1;
        let run = self.unreported.run;
        let empty = FrameEnds { run, first: next, last: next, ..FrameEnds::default() };
        let mut ends = std::mem::replace(&mut self.unreported, empty);
        self.reported = Some(ends.last);
        let state = self.federate.state();
        ends.state = Some(state);
        self.states.push_back((ends.last, state));
        while self.states.len() > KEPT_FRAMES {
            self.states.pop_front();
        }
        if self.federate.live() {
            self.tell_whole(ends.first, effects);
        }
        for part in ends.parts() {
            self.tell(Report::Ends(part), effects);
        }
    }

    /// The PDUs of frames from `first` on, for the log.
    fn tell_whole(&mut self, first: Frame, effects: &mut Vec<Effect>) {
        let run = self.run();
        let frames = self.own.iter().filter(|own| own.frame >= first);
        let all = frames.flat_map(|own| own.pdus.iter().map(|(_, octets)| (own.frame, octets)));
        let (mut parts, mut octets) = (Vec::<Vec<(Frame, Vec<u8>)>>::new(), usize::MAX);
        for (frame, pdu) in all {
            if octets.saturating_add(pdu.len()) > WHOLE_OCTETS {
                parts.push(Vec::new());
                octets = 0;
            }
            octets += pdu.len();
            if let Some(part) = parts.last_mut() {
                part.push((frame, pdu.to_vec()));
            }
        }
        for pdus in parts {
            self.tell(Report::Whole { run, pdus }, effects);
        }
    }

    /// A beat of another member or of the conductor.
    pub fn hear_beat(&mut self, now: WallNs, from: &str, beat: &Beat) {
        if beat.fed != self.fed {
            return;
        }
        if from == CONDUCTOR {
            if beat.inc == 0 {
                self.orders.told(now, beat.last_seq);
            }
        } else if let Some(inbox) = self.peers.get_mut(from).filter(|i| i.inc() == beat.inc) {
            inbox.told(now, beat.last_seq);
        } else if self.producers.contains_key(from) && self.federate.consumes() {
            let known = self.peers.get(from).map_or(0, Inbox::inc);
            if beat.inc > known {
                let mut inbox = Inbox::new(self.fed, beat.inc, 1);
                inbox.told(now, beat.last_seq);
                self.peers.insert(from.to_owned(), inbox);
            }
        }
        for (_, _, seq) in
            beat.seen.iter().filter(|(of, inc, _)| *of == self.name && *inc == self.inc)
        {
            self.outbox.confirm(from, *seq);
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

    /// Reports of another member that were lost.
    pub fn fetched(&mut self, now: WallNs, fetched: Fetched<Report>, effects: &mut Vec<Effect>) {
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
        for report in fetched.items {
            self.report(now, &fetched.of, report, effects);
        }
    }

    /// Time passed: asks for what is missing too long.
    pub fn tick(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.ask_for_pdus(now, effects);
        self.stand(now, effects);
        if let Some((fetch, _)) = self.orders.due(now) {
            let ask = FetchOf { of: CONDUCTOR.to_owned(), fetch };
            effects.push(Effect::Fetch { holder: CONDUCTOR.to_owned(), ask });
        }
        let others = self.other_consumers();
        for (name, inbox) in &mut self.peers {
            let Some((fetch, tries)) = inbox.due(now) else { continue };
            let holder = holder(name, tries, true, &others);
            effects.push(Effect::Fetch { holder, ask: FetchOf { of: name.clone(), fetch } });
        }
    }

    fn other_consumers(&self) -> Vec<String> {
        let consumers = self.config.iter().flat_map(|c| &c.consumers);
        consumers.filter(|name| **name != self.name).cloned().collect()
    }

    /// What it waits for, for people: each producer whose frames it lacks, and what is known of them.
    #[must_use]
    pub fn waits_for(&self) -> Vec<String> {
        let next = self.executed + 1;
        let lacks = |(name, producer): (&String, &Producer)| {
            let complete = self.complete_of(name);
            (!producer.absent && complete < Some(next)).then(|| {
                let (inc, ended, bound) = (producer.inc, producer.ended, producer.bound);
                let stream = self.peers.get(name).map(|i| (i.inc(), i.seen()));
                format!(
                    "frame {next} of {name}: complete to {complete:?}, ended {ended:?}, incarnation {inc:?}, bound {bound:?}, awaited {}, reports {stream:?}",
                    producer.awaited
                )
            })
        };
        self.producers.iter().filter_map(lacks).collect()
    }

    /// When [`Member::tick`] has something to do.
    #[must_use]
    pub fn deadline(&self) -> Option<WallNs> {
        let streams = self.peers.values().filter_map(Inbox::deadline);
        let pdus = self.incomplete.values().map(Incomplete::due);
        streams.chain(self.orders.deadline()).chain(pdus).chain(self.stands).min()
    }
}

/// Adds a frame to a report.
fn name_frame(own: &Own, ends: &mut FrameEnds) {
    if !own.pdus.is_empty() {
        ends.pdus.push((own.frame, own.pdus.iter().map(|(hash, _)| *hash).collect()));
    }
    ends.notices.extend(own.notices.iter().map(|(effect, n)| (own.frame, *effect, n.clone())));
}

/// Whom to ask for what `name` made: itself twice, then in turn all who may hold it.
fn holder(name: &str, tries: u32, conductor: bool, consumers: &[String]) -> String {
    let conductor = conductor.then_some(CONDUCTOR);
    let all: Vec<&str> =
        [name].into_iter().chain(conductor).chain(consumers.iter().map(String::as_str)).collect();
    let turn = (tries as usize).saturating_sub(1) % all.len();
    all[turn].to_owned()
}
