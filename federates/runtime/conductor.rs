//! The conductor as a state machine: the one authority over time and life cycle.
//!
//! Pace, single step, freeze and "as fast as possible" are all ways in which the grant horizon moves.
//! The core reads no clock; the driver passes wall nanoseconds in.

mod commands;
mod losses;

use super::clock::WallNs;
use super::digest::content;
use super::life_cycle::{Phase, Refused, Transition};
use super::member::CONDUCTOR;
use super::messages::{
    Accepted, Answer, Beat, FetchOf, Fetched, FinalReport, Frame, FrameEnds, Hello, Joined, Kind,
    MemberState, Numbered, Order, Report, RunConfig, RunState, Welcome,
};
use super::stream::{Inbox, Outbox};
use super::views::Views;
use scenarios::losses::Losses;
use std::collections::{BTreeMap, VecDeque};

pub use scenarios::losses::OnLoss;

/// Names a question that waits for its answer.
pub type Token = u64;

/// What the conductor wants done.
#[derive(Debug, PartialEq)]
pub enum Effect {
    /// Answer a [`Hello`].
    Welcome(Token, Welcome),
    /// Tell all members.
    Order(Numbered<Order>),
    /// Ask a member for reports that did not arrive.
    Fetch {
        /// Whom.
        holder: String,
        /// What is missing.
        ask: FetchOf,
    },
    /// Answer a [`super::messages::Command`].
    Answer(Token, Answer),
    /// Tell spectators how the run stands.
    State(RunState),
    /// A phase was reached at a frame: for DIS simulation management, log and page.
    Reached {
        /// Phase.
        phase: Phase,
        /// Frame.
        frame: Frame,
        /// Why, if by a fault.
        reason: Option<String>,
    },
    /// A run is closed and all members have reported.
    Closed(Box<ClosedRun>),
    /// The federation is over.
    Exit(u8),
}

/// The results of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosedRun {
    /// Number of the run.
    pub run: u32,
    /// Seed.
    pub seed: u64,
    /// Last frame executed by all.
    pub frame: Frame,
    /// Wall time in phase RUNNING, ns.
    pub wall_ns: WallNs,
    /// Final reports by name.
    pub reports: Vec<FinalReport>,
    /// Faults; empty when all went well.
    pub reasons: Vec<String>,
    /// An essential member was lost and the run did not go on to its end.
    pub failed: bool,
}

/// What the conductor is told at the start.
#[derive(Clone, Debug)]
pub struct ConductorConfig {
    /// Title of the scene.
    pub scene: String,
    /// Hash of the scene and its data.
    pub scene_hash: u64,
    /// Version of the build.
    pub version: String,
    /// Essential members by name, sorted.
    pub expected: Vec<String>,
    /// Members that make PDUs, sorted.
    pub producers: Vec<String>,
    /// Producers without which the run begins and goes on (visitors), sorted: their loss degrades it.
    pub optional: Vec<String>,
    /// Number of traffic generators.
    pub generators: u32,
    /// Seed.
    pub seed: u64,
    /// Length of a frame, ns.
    pub step_ns: i64,
    /// UTC of frame 0, ns.
    pub start_utc_ns: i64,
    /// Last frame.
    pub last_frame: Frame,
    /// Simulated seconds per wall second; infinite = as fast as possible.
    pub rate: f64,
    /// Start as soon as all are ready.
    pub autostart: bool,
    /// End the federation when the run is over or faulty (batch), else wait for an operator.
    pub batch: bool,
    /// Spectators to wait for before the first run, so that a log is complete.
    pub await_spectators: Vec<String>,
    /// How long they are waited for once all others are ready, ns of wall time.
    pub await_spectators_ns: WallNs,
    /// Frames that may be granted ahead of the slowest member when as fast as possible.
    pub window: Frame,
    /// Drawn at the start; messages of another federation have no effect.
    pub fed: u128,
    /// When a member is given up, and what becomes of the run then.
    pub losses: Losses,
}

#[derive(Debug)]
struct MemberEntry {
    hello: Hello,
    inc: u64,
    accepted: Accepted,
    alive: bool,
    /// Accepted in the place of a lost one, not admitted yet.
    returning: bool,
    token_gone: bool,
    /// A message or beat of this incarnation came: its process knows that it was accepted.
    heard: bool,
    ready: Option<u32>,
    /// Consumers: whether they hear all producers. Others: true once they answered.
    present: bool,
    executed: Option<Frame>,
    /// Whether it needs the frames of the producers before it can go on.
    consumes: bool,
    /// Since when it could go on and has not; none while it is not due.
    due_since: Option<WallNs>,
    /// When the last message or beat of it came.
    heard_at: WallNs,
    /// The frame that it says it is executing.
    working: Option<Frame>,
    stream: Inbox<Report>,
    /// Frame ends that came in parts.
    joined: Joined,
    log: MemberLog,
    /// From a grant to the frame ends that answer it, smoothed, ns.
    latency_ns: f64,
}

/// What a member made, as its reports say.
#[derive(Clone, Debug, Default)]
struct MemberLog {
    /// Digest of all that it made, by frame.
    made: VecDeque<(Frame, u64)>,
    content: u64,
    /// Digests of its state at the ends of reports.
    states: VecDeque<(Frame, u64)>,
    /// Numbers of the reports of its frame ends, each with its last frame.
    reports: VecDeque<(u64, Frame)>,
    /// Frames up to here were made by an incarnation before.
    before: Option<Frame>,
}

impl MemberEntry {
    fn new(fed: u128, hello: Hello, accepted: Accepted, now: WallNs) -> Self {
        let inc = accepted.inc;
        Self {
            hello,
            inc,
            accepted,
            alive: true,
            returning: false,
            token_gone: false,
            heard: false,
            ready: None,
            present: false,
            executed: None,
            consumes: false,
            due_since: None,
            heard_at: now,
            working: None,
            stream: Inbox::new(fed, inc, 1),
            joined: Joined::default(),
            log: MemberLog::default(),
            latency_ns: 0.0,
        }
    }
}

impl MemberLog {
    fn take(&mut self, seq: u64, ends: &FrameEnds) {
        for frame in ends.first..=ends.last {
            let hashes = ends.pdus.iter().filter(|(f, _)| *f == frame).flat_map(|(_, h)| h);
            let notices = ends.notices.iter().filter(|(made, ..)| *made == frame);
            self.content = self.content.wrapping_add(content(
                frame,
                hashes.copied(),
                notices.map(|(_, effect, notice)| (*effect, notice)),
            ));
            self.made.push_back((frame, self.content));
        }
        self.states.extend(ends.state.map(|state| (ends.last, state)));
        self.reports.push_back((seq, ends.last));
        self.made.drain(..self.made.len().saturating_sub(LOGGED));
        self.states.drain(..self.states.len().saturating_sub(LOGGED));
        self.reports.drain(..self.reports.len().saturating_sub(LOGGED));
    }
}

/// A loss of an essential member.
#[derive(Debug)]
struct Fault {
    name: String,
    text: String,
    since: WallNs,
    /// The last frame of the lost one, once a successor went on from there.
    back: Option<Option<Frame>>,
}

/// What happens when all members stand at the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    /// Go on to the end of the run.
    End,
    /// Freeze at this frame.
    Freeze(Frame),
    /// Close the run at this frame.
    Stop(Frame),
}

/// The clock authority.
pub struct Conductor {
    config: ConductorConfig,
    phase: Phase,
    run: u32,
    granted: Frame,
    goal: Goal,
    rate: f64,
    members: BTreeMap<String, MemberEntry>,
    next_inc: u64,
    anchor: (WallNs, Frame),
    running_since: Option<WallNs>,
    ran_ns: WallNs,
    pending: Vec<(Token, Transition)>,
    finals: BTreeMap<String, FinalReport>,
    finish_deadline: Option<WallNs>,
    restart_after: bool,
    faults: Vec<Fault>,
    /// What is worth a word and no fault of the run.
    notes: Vec<String>,
    /// What the run goes on without, and since when.
    degraded: Vec<String>,
    /// Why those were lost whose views are not closed yet, and that the run will go on without.
    absent: BTreeMap<String, String>,
    /// When another process was asked to take the place of a lost member.
    hosted: BTreeMap<String, (WallNs, u32)>,
    views: Views,
    /// Members of this run: the essential ones and the optional ones that were there, sorted.
    roster: Vec<String>,
    last_state: WallNs,
    last_muster: WallNs,
    /// Until when spectators are waited for; set when all others are ready.
    logger_deadline: Option<WallNs>,
    pace_samples: VecDeque<(WallNs, Frame)>,
    /// The latest grants: when, and up to which frame.
    grants: VecDeque<(WallNs, Frame)>,
    outbox: Outbox<Order>,
    /// Members are awaited, and configured when all are there.
    mustering: bool,
    /// A run begins by itself.
    autostart: bool,
    /// Frozen because a member is lost, not by command.
    frozen_by_fault: bool,
    return_deadline: Option<WallNs>,
    /// A run of this federation ended by a fault.
    failed: bool,
    last_tick: WallNs,
}

/// Share of a new latency in the smoothed one: about a second of frames.
const LATENCY_SMOOTHING: f64 = 0.05;
const GRANTS_KEPT: usize = 64;
/// Federates and spectators that are remembered, at most.
const MOST_MEMBERS: usize = 1024;
/// Frames and reports of each member that are remembered: more than any grant horizon.
const LOGGED: usize = 4096;
const MUSTER_EVERY_NS: WallNs = 20_000_000;
/// A frame that is due for so long is not granted by the pace any more.
const LATE_NS: WallNs = 5_000_000;
/// Clocks are looked at as often.
const CLOCKS_EVERY_NS: WallNs = 50_000_000;
const STATE_EVERY_NS: WallNs = 200_000_000;
const FINISH_WITHIN_NS: WallNs = 5_000_000_000;
/// Before a run has begun nothing is lost with a member: a batch awaits it for so long.
const JOIN_AGAIN_NS: WallNs = 10_000_000_000;

impl Conductor {
    /// A conductor in phase INIT.
    #[must_use]
    pub fn new(config: ConductorConfig) -> Self {
        Self {
            phase: Phase::Init,
            run: 0,
            granted: 0,
            goal: Goal::End,
            rate: config.rate,
            members: BTreeMap::new(),
            next_inc: 1,
            anchor: (0, 0),
            running_since: None,
            ran_ns: 0,
            pending: Vec::new(),
            finals: BTreeMap::new(),
            finish_deadline: None,
            restart_after: false,
            faults: Vec::new(),
            notes: Vec::new(),
            degraded: Vec::new(),
            absent: BTreeMap::new(),
            hosted: BTreeMap::new(),
            views: Views::default(),
            roster: config.expected.clone(),
            last_state: 0,
            last_muster: 0,
            logger_deadline: None,
            pace_samples: VecDeque::new(),
            grants: VecDeque::new(),
            outbox: Outbox::new(config.fed, 0),
            mustering: true,
            autostart: config.autostart,
            frozen_by_fault: false,
            return_deadline: None,
            failed: false,
            last_tick: 0,
            config,
        }
    }

    /// Phase of the run.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The last frame that may be executed.
    #[must_use]
    pub fn granted(&self) -> Frame {
        self.granted
    }

    /// Expected members that have not joined.
    #[must_use]
    pub fn awaited(&self) -> Vec<&str> {
        self.config
            .expected
            .iter()
            .filter(|name| !self.members.get(*name).is_some_and(|m| m.alive))
            .map(String::as_str)
            .collect()
    }

    /// Lowest frame that every essential member has executed; of a lost one, its last that counts.
    #[must_use]
    pub fn frame(&self) -> Frame {
        self.roster
            .iter()
            .filter(|name| !self.views.is_absent(name))
            .filter_map(|name| {
                let executed = self.members.get(name)?.executed;
                Some(self.views.cut(name).unwrap_or(executed).unwrap_or(0))
            })
            .min()
            .unwrap_or(self.granted)
    }

    /// Producers of this run, sorted.
    fn producers(&self) -> Vec<String> {
        let produces =
            |n: &&String| self.config.producers.contains(n) || self.config.optional.contains(n);
        self.roster.iter().filter(produces).cloned().collect()
    }

    /// Where consumers stand while frames of lost members are awaited.
    #[must_use]
    pub fn stand(&self) -> Frame {
        let producers = self.producers();
        let awaited = producers.iter().filter(|name| !self.views.is_absent(name));
        let cuts = awaited.filter_map(|name| self.views.cut(name));
        cuts.map(|cut| cut.unwrap_or(0)).fold(self.granted, Frame::min)
    }

    /// A federate asks to join.
    pub fn hello(&mut self, now: WallNs, hello: Hello, token: Token, effects: &mut Vec<Effect>) {
        let name = hello.name.clone();
        let refuse = |why: String| Effect::Welcome(token, Welcome::Refused(why));
        if hello.version != self.config.version {
            effects.push(refuse(format!(
                "'{name}' is version {}, this federation runs {}: use the same build everywhere",
                hello.version, self.config.version
            )));
            return;
        }
        if hello.scene_hash != self.config.scene_hash {
            effects.push(refuse(format!(
                "'{name}' on {} has another scene (hash {:016x}) than this federation ('{}', {:016x}): give every federate the same scene file and data",
                hello.host, hello.scene_hash, self.config.scene, self.config.scene_hash
            )));
            return;
        }
        if !hello.kind.essential() && !self.config.optional.contains(&name) {
            let other = |m: &MemberEntry| m.alive && m.hello.instance != hello.instance;
            if self.members.get(&name).is_some_and(other) {
                effects.push(Effect::Welcome(token, Welcome::NameTaken));
                return;
            }
            if self.members.len() >= MOST_MEMBERS {
                self.members.retain(|_, m| m.alive || m.hello.kind.essential());
            }
            if self.members.len() >= MOST_MEMBERS {
                effects.push(refuse(format!(
                    "{MOST_MEMBERS} federates and spectators are here already"
                )));
                return;
            }
        }
        let stall_ns = self.stall_ns(&name);
        if let Some(present) = self.members.get_mut(&name) {
            let same = present.hello.instance == hello.instance;
            let outcast = hello.was.is_some_and(|was| was.inc == present.inc);
            let fresh = now < present.heard_at + stall_ns;
            let taken = present.returning && fresh;
            // Its answer was lost, and it has not asked again since: nobody knows whether that process still is.
            let running = present.alive && (present.heard || fresh);
            if same && !outcast && (present.alive || present.returning) {
                // Asked again: the answer was late, or lost.
                present.heard_at = now;
                let accepted = Box::new(present.accepted.clone());
                effects.push(Effect::Welcome(token, Welcome::Accepted(accepted)));
                return;
            }
            if same && present.alive && self.roster.contains(&name) {
                self.lose(now, name.clone(), "it missed what nobody remembers", effects);
            } else if running || taken {
                effects.push(refuse(format!(
                    "'{name}' is already running (process {} on {}): stop that one first or choose another --exercise",
                    present.hello.pid, present.hello.host
                )));
                return;
            }
        }
        if hello.kind.essential() && !self.config.expected.contains(&name) {
            effects.push(refuse(format!(
                "'{name}' is not expected in this federation; expected: {}. Check --share and the administration station's --generators",
                self.config.expected.join(", ")
            )));
            return;
        }
        if let Some(answer) = self.welcome_back(now, &hello, token) {
            effects.push(answer);
            return;
        }
        if hello.kind.beats() && matches!(self.phase, Phase::Running | Phase::Frozen) {
            let text =
                format!("'{name}' can join when a run begins, not one that is {}", self.phase);
            effects.push(refuse(text));
            return;
        }
        let inc = self.next_inc;
        self.next_inc += 1;
        let (fed, orders) = (self.config.fed, self.outbox.last());
        let accepted = Accepted { fed, inc, orders, enter: None };
        let welcome = Welcome::Accepted(Box::new(accepted.clone()));
        effects.push(Effect::Welcome(token, welcome));
        self.members.insert(name, MemberEntry::new(fed, hello, accepted, now));
        self.say(Order::Muster, effects);
        self.push_state(now, effects);
    }

    /// Expected members that have joined but do not hear all producers yet.
    #[must_use]
    pub fn deaf(&self) -> Vec<&str> {
        let deaf = |name: &&String| self.members.get(*name).is_some_and(|m| m.alive && !m.present);
        self.config.expected.iter().filter(deaf).map(String::as_str).collect()
    }

    /// Producers that a consumer must hear: the essential ones and the optional ones that joined.
    fn heard_producers(&self) -> Vec<String> {
        let joined = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
        let optional = self.config.optional.iter().filter(joined);
        self.config.producers.iter().chain(optional).cloned().collect()
    }

    /// Configures once everybody is there and hears everybody; a spectator is awaited for a while only.
    fn try_configure(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if !self.mustering || self.members.is_empty() {
            return;
        }
        if !self.awaited().is_empty() || !self.deaf().is_empty() {
            return;
        }
        let within = self.config.await_spectators_ns;
        let deadline = *self.logger_deadline.get_or_insert(now + within);
        // One that has come and gone again is not waited for.
        let settled = |name: &String| self.members.get(name).is_some_and(|m| m.present || !m.alive);
        if self.config.await_spectators.iter().all(settled) || now >= deadline {
            self.configure(effects);
        }
    }

    /// The spectators that were to be waited for will not come.
    pub fn await_no_spectators(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        // A member that is optional is no spectator.
        let optional = &self.config.optional;
        self.config.await_spectators.retain(|name| optional.contains(name));
        self.try_configure(now, effects);
    }

    fn configure(&mut self, effects: &mut Vec<Effect>) {
        self.run += 1;
        self.granted = 0;
        self.grants.clear();
        self.goal = Goal::End;
        self.finals.clear();
        self.finish_deadline = None;
        self.restart_after = false;
        self.ran_ns = 0;
        self.running_since = None;
        self.pace_samples.clear();
        self.views.reset(self.run);
        self.degraded.clear();
        self.absent.clear();
        self.hosted.clear();
        let joined = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
        self.roster = self.config.expected.clone();
        self.roster.extend(self.config.optional.iter().filter(joined).cloned());
        self.roster.sort();
        for member in self.members.values_mut() {
            member.ready = None;
            member.executed = None;
        }
        self.mustering = false;
        self.frozen_by_fault = false;
        self.return_deadline = None;
        self.faults.clear();
        self.notes.clear();
        for member in self.members.values_mut() {
            member.log = MemberLog::default();
            member.due_since = None;
            member.returning = false;
        }
        let config = self.run_config();
        self.say(Order::Configure(config), effects);
    }

    fn run_config(&self) -> RunConfig {
        let inc = |n: &String| self.members.get(n).map(|m| (n.clone(), m.inc));
        let consumes = |n: &&String| self.members.get(*n).is_some_and(|m| m.consumes);
        RunConfig {
            run: self.run,
            seed: self.config.seed,
            producers: self.producers(),
            consumers: self.roster.iter().filter(consumes).cloned().collect(),
            incs: self.roster.iter().filter_map(inc).collect(),
            generators: self.config.generators,
            last_frame: self.config.last_frame,
        }
    }

    /// Begins a run, or waits for whom it needs and says so.
    fn begin_again(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.awaited().is_empty() {
            return self.configure(effects);
        }
        if self.phase != Phase::Init {
            effects.push(Effect::Reached { phase: Phase::Init, frame: 0, reason: None });
        }
        self.muster_again();
        let text = format!("{}: start what is missing, or stop", self.standing());
        self.answer_pending(Transition::Restart, &text, effects);
        self.push_state(now, effects);
    }

    fn muster_again(&mut self) {
        self.mustering = true;
        self.last_muster = 0;
        let members = &self.members;
        self.faults.retain(|f| members.get(&f.name).is_some_and(|m| !m.alive));
        for member in self.members.values_mut() {
            member.ready = None;
        }
        self.phase = Phase::Init;
    }

    /// Numbers an order; a muster is repeated anyway.
    fn say(&mut self, order: Order, effects: &mut Vec<Effect>) {
        effects.push(Effect::Order(match order {
            Order::Muster => self.outbox.loose(order),
            order => self.outbox.push(order),
        }));
    }

    fn fail_pending(&mut self, effects: &mut Vec<Effect>) {
        let text = self.open_faults().join("; ");
        for (token, _) in std::mem::take(&mut self.pending) {
            effects.push(Effect::Answer(token, self.answer(false, &text)));
        }
    }

    /// A report of a member.
    pub fn report(
        &mut self,
        now: WallNs,
        from: &str,
        report: Numbered<Report>,
        effects: &mut Vec<Effect>,
    ) {
        if !self.hear(now, from, report.fed, report.inc) {
            return;
        }
        let Some(member) = self.members.get_mut(from) else { return };
        if report.seq == 0 {
            if matches!(report.body, Report::Present { .. }) {
                self.take_report(now, from, 0, report.body, effects);
            }
            return;
        }
        let next = member.stream.seen() + 1;
        for (seq, report) in (next..).zip(member.stream.take(now, report)) {
            self.take_report(now, from, seq, report, effects);
        }
    }

    /// Notes that a member lives; whether it is one.
    fn hear(&mut self, now: WallNs, from: &str, fed: u128, inc: u64) -> bool {
        let known = self.members.get_mut(from).filter(|m| m.inc == inc && fed == self.config.fed);
        let Some(member) = known else { return false };
        member.heard_at = now;
        member.heard = true;
        // Silent while nothing was being made: nobody went on without it.
        if !member.alive && !member.returning && !self.views.removed().contains_key(from) {
            member.alive = true;
        }
        true
    }

    /// A beat of a member.
    pub fn beat(&mut self, now: WallNs, from: &str, beat: &Beat) {
        if !self.hear(now, from, beat.fed, beat.inc) {
            return;
        }
        let Some(member) = self.members.get_mut(from) else { return };
        member.stream.told(now, beat.last_seq);
        let working = beat.working.map(|(frame, _)| frame);
        if beat.run == self.run && working.is_some() && working != member.working {
            member.due_since = None;
        }
        member.working = working;
        for (_, _, seq) in beat.seen.iter().filter(|(of, inc, _)| of == CONDUCTOR && *inc == 0) {
            self.outbox.confirm(from, *seq);
        }
    }

    /// The conductor's own beat.
    #[must_use]
    pub fn own_beat(&self) -> Beat {
        let seen = self.members.iter().map(|(n, m)| (n.clone(), m.inc, m.stream.seen()));
        Beat {
            fed: self.config.fed,
            run: self.run,
            inc: 0,
            last_seq: self.outbox.last(),
            executed: self.granted,
            working: None,
            seen: seen.collect(),
        }
    }

    /// Answers a member that lacks orders.
    #[must_use]
    pub fn fetch_orders(&self, ask: &FetchOf) -> Fetched<Order> {
        if ask.fetch.fed != self.config.fed || ask.fetch.inc != 0 {
            return Fetched { of: ask.of.clone(), items: Vec::new(), gone_before: 0 };
        }
        self.outbox.fetch(&ask.of, &ask.fetch)
    }

    /// Answers a member that lacks reports of another one.
    #[must_use]
    pub fn fetch_reports(&self, ask: &FetchOf) -> Fetched<Report> {
        let nothing = Fetched { of: ask.of.clone(), items: Vec::new(), gone_before: 0 };
        let stream = self.members.get(&ask.of).map(|m| &m.stream);
        let asked =
            |s: &&Inbox<Report>| s.inc() == ask.fetch.inc && ask.fetch.fed == self.config.fed;
        stream.filter(asked).map_or(nothing, |stream| stream.relay(&ask.of, &ask.fetch))
    }

    /// Reports that were lost on their way.
    pub fn fetched(&mut self, now: WallNs, fetched: Fetched<Report>, effects: &mut Vec<Effect>) {
        let Some(member) = self.members.get(&fetched.of) else { return };
        if fetched.gone_before > member.stream.seen() + 1 {
            self.lose(now, fetched.of, "its reports were lost and are not remembered", effects);
            return;
        }
        for report in fetched.items {
            self.report(now, &fetched.of, report, effects);
        }
    }

    fn take_report(
        &mut self,
        now: WallNs,
        from: &str,
        seq: u64,
        report: Report,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(from) else { return };
        match report {
            Report::Present { hears, consumes } => {
                // A consumer must hear the producers, an awaited spectator everybody.
                let producers = self.heard_producers();
                let Some(member) = self.members.get_mut(from) else { return };
                let needed = match consumes {
                    _ if self.config.optional.iter().any(|o| o == from) => &[],
                    _ if self.config.await_spectators.iter().any(|s| s == from) => {
                        &self.config.expected[..]
                    }
                    true => &producers[..],
                    false => &[],
                };
                member.present = needed.iter().all(|p| p == from || hears.contains(p));
                member.consumes = consumes;
                self.try_configure(now, effects);
            }
            Report::Ready { run, at } if run == self.run => match at {
                None => {
                    member.ready = Some(run);
                    self.all_ready(now, effects);
                }
                Some(at) => self.returned(now, from, at, effects),
            },
            Report::Ends(ends) if ends.run == self.run && member.alive => {
                let Some((seq, ends)) = member.joined.take(seq, ends) else { return };
                let next = member.executed.map_or(0, |e| e + 1);
                if ends.first != next || ends.last < next || ends.last > self.granted {
                    return;
                }
                member.log.take(seq, &ends);
                let told = ends.state.map(|state| (ends.last, state));
                member.executed = Some(ends.last);
                member.due_since = None;
                // The grant that allowed the first of these frames.
                if let Some((at, _)) = self.grants.iter().find(|(_, upto)| *upto >= next) {
                    let took = now.saturating_sub(*at) as f64;
                    member.latency_ns += (took - member.latency_ns) * LATENCY_SMOOTHING;
                }
                if let Some((frame, state)) = told {
                    self.compare_traffic(now, from, frame, state, effects);
                }
                self.settle(now, effects);
                self.extend(now, effects);
            }
            Report::Sealed { run, view, holds } if run == self.run => {
                self.views.sealed(from, view, holds);
                self.settle_views(now, effects);
            }
            Report::Held { run, view } if run == self.run => {
                self.views.held(from, view);
                self.settle_views(now, effects);
            }
            Report::Final(report) if report.run == self.run => {
                self.finals.insert(from.to_owned(), *report);
                self.try_close(now, effects);
            }
            Report::Failed { reason } if self.config.optional.iter().any(|o| o == from) => {
                self.lose(now, from.to_owned(), &format!("it cannot go on: {reason}"), effects);
            }
            Report::Failed { reason } if member.returning => {
                member.returning = false;
                let (name, inc) = (from.to_owned(), member.inc);
                self.notes.push(format!("{from} did not come back: {reason}"));
                self.say(Order::Dismiss { name, inc, reason }, effects);
            }
            Report::Failed { reason } => {
                let text = format!("{from} cannot go on: {reason}");
                self.faults.push(Fault { name: from.to_owned(), text, since: now, back: None });
                self.failed = true;
                self.fail_pending(effects);
                effects.push(Effect::Exit(1));
            }
            _ => {}
        }
    }

    /// All generators step the same traffic: where two of them do not have the same state at a frame, the run is
    /// worth nothing any more.
    fn compare_traffic(
        &mut self,
        now: WallNs,
        from: &str,
        frame: Frame,
        state: u64,
        effects: &mut Vec<Effect>,
    ) {
        let generates = |m: &MemberEntry| m.alive && m.hello.kind == Kind::TrafficGenerator;
        if self.failed || !self.members.get(from).is_some_and(generates) {
            return;
        }
        let differs = |m: &MemberEntry| {
            m.log.states.iter().rev().any(|(f, other)| *f == frame && *other != state)
        };
        let other = self.members.iter().find(|(n, m)| *n != from && generates(m) && differs(m));
        let Some(other) = other.map(|(name, _)| name.clone()) else { return };
        let text = format!(
            "{from} and {other} do not have the same traffic at frame {frame}: other builds, other hosts, or a fault of SEEDS"
        );
        self.faults.push(Fault { name: from.to_owned(), text, since: now, back: None });
        self.failed = true;
        self.fail_pending(effects);
        effects.push(Effect::Exit(1));
    }

    fn all_ready(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let is_ready =
            |n: &String| self.members.get(n).is_some_and(|m| !m.alive || m.ready == Some(self.run));
        let ready = self.awaited().is_empty() && self.roster.iter().all(is_ready);
        if !ready || self.finish_deadline.is_some() {
            return;
        }
        let was = self.phase;
        if was != Phase::Configured {
            self.phase = Phase::Configured;
            effects.push(Effect::Reached { phase: self.phase, frame: 0, reason: None });
        }
        self.answer_pending(Transition::Restart, "configured; waiting for start", effects);
        if std::mem::take(&mut self.autostart) {
            let _ = self.start(now, effects);
        }
        self.push_state(now, effects);
    }

    fn start(&mut self, now: WallNs, effects: &mut Vec<Effect>) -> Result<(), Refused> {
        self.phase = self.phase.after(Transition::Start)?;
        self.goal = Goal::End;
        self.anchor = (now, self.granted);
        self.running_since = Some(now);
        self.pace_samples.clear();
        effects.push(Effect::Reached { phase: self.phase, frame: self.granted, reason: None });
        self.extend(now, effects);
        Ok(())
    }

    fn stop(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.phase == Phase::Running {
            self.goal = Goal::Stop(self.granted);
            self.settle(now, effects);
        } else {
            self.finish(now, effects);
        }
    }

    fn finish(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.pause_clock(now);
        self.phase = Phase::Stopped;
        self.finish_deadline = Some(now + FINISH_WITHIN_NS);
        let frame = self.frame();
        self.return_deadline = None;
        self.say(Order::Finish { run: self.run, frame }, effects);
        effects.push(Effect::Reached { phase: self.phase, frame, reason: None });
        self.try_close(now, effects);
    }

    fn pause_clock(&mut self, now: WallNs) {
        if let Some(since) = self.running_since.take() {
            self.ran_ns += now.saturating_sub(since);
        }
    }

    fn try_close(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let Some(deadline) = self.finish_deadline else { return };
        let outstanding = self
            .roster
            .iter()
            .any(|n| self.members.get(n).is_some_and(|m| m.alive) && !self.finals.contains_key(n));
        if outstanding && now < deadline {
            return;
        }
        self.finish_deadline = None;
        effects.push(Effect::Closed(Box::new(ClosedRun {
            run: self.run,
            seed: self.config.seed,
            frame: self.frame(),
            wall_ns: self.ran_ns,
            reports: self.finals.values().cloned().collect(),
            reasons: self.faults.iter().map(|f| &f.text).chain(&self.degraded).cloned().collect(),
            failed: !self.lost_names().is_empty(),
        })));
        self.failed |= !self.lost_names().is_empty();
        self.answer_pending(Transition::Stop, "stopped", effects);
        if std::mem::take(&mut self.restart_after) {
            self.begin_again(now, effects);
        } else if self.config.batch {
            effects.push(Effect::Exit(self.exit_code()));
        }
        self.push_state(now, effects);
    }

    /// Whether all members stand at the goal, and what follows.
    fn settle(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.phase != Phase::Running || self.views.is_open() {
            return;
        }
        let frame = self.frame();
        if self.views.waits() {
            // What a lost producer has not made is not left out: consumers stand before it.
            let stand = self.stand();
            let mut consumers = self.members.values().filter(|m| m.alive && m.consumes);
            if consumers.all(|m| m.executed.unwrap_or(0) >= stand) {
                match self.goal {
                    Goal::Stop(_) => self.finish(now, effects),
                    _ => self.freeze_by_fault(now, effects),
                }
            }
            return;
        }
        match self.goal {
            Goal::End if frame >= self.config.last_frame => self.finish(now, effects),
            Goal::Stop(at) if frame >= at => self.finish(now, effects),
            Goal::Freeze(at) if frame >= at => {
                if at >= self.config.last_frame {
                    let text = "the run is over at its last frame";
                    self.answer_pending(Transition::Freeze, text, effects);
                    self.finish(now, effects);
                    return;
                }
                self.pause_clock(now);
                self.phase = Phase::Frozen;
                effects.push(Effect::Reached { phase: self.phase, frame, reason: None });
                let text = format!("frozen at frame {frame}");
                self.answer_pending(Transition::Freeze, &text, effects);
                self.push_state(now, effects);
            }
            _ => {}
        }
    }

    fn freeze_by_fault(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.pause_clock(now);
        self.phase = Phase::Frozen;
        self.frozen_by_fault = true;
        let reason = Some(self.open_faults().join("; "));
        effects.push(Effect::Reached { phase: self.phase, frame: self.frame(), reason });
        self.faulty_freeze(now, effects);
    }

    /// The last order of the federation: outside the stream, since nobody is left to ask for what came before.
    #[must_use]
    pub fn leave(&self, code: u8) -> Numbered<Order> {
        self.outbox.loose(Order::Exit { code })
    }

    /// With what the process of the administration station ends.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        u8::from(self.failed || !self.lost_names().is_empty())
    }

    fn answer_pending(&mut self, what: Transition, text: &str, effects: &mut Vec<Effect>) {
        let pending = std::mem::take(&mut self.pending);
        for (token, transition) in pending {
            if transition == what {
                effects.push(Effect::Answer(token, self.answer(true, text)));
            } else {
                self.pending.push((token, transition));
            }
        }
    }

    /// Moves the horizon as far as the pace allows.
    fn extend(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let stands = self.views.is_open() || self.views.waits();
        if self.phase != Phase::Running || self.goal != Goal::End || stands {
            return;
        }
        let slowest = self.frame();
        let upto = if self.rate.is_infinite() {
            let upto = (slowest + self.config.window).min(self.config.last_frame);
            // Move in half windows: fewer messages, and nobody waits.
            let worth =
                upto == self.config.last_frame || upto >= self.granted + self.config.window / 2;
            if worth { upto } else { self.granted }
        } else {
            let step = self.config.step_ns as f64 / self.rate;
            let due = self.anchor.1 + (now.saturating_sub(self.anchor.0) as f64 / step) as Frame;
            let horizon = (slowest + self.slack()).min(self.config.last_frame);
            if due > horizon {
                // Slip: the anchors move, nobody catches up in a burst.
                self.anchor = (now, horizon.max(self.granted));
            }
            due.min(horizon)
        };
        if upto > self.granted {
            self.grant(now, upto, effects);
        }
    }

    fn grant(&mut self, now: WallNs, upto: Frame, effects: &mut Vec<Effect>) {
        self.granted = upto;
        if self.grants.len() == GRANTS_KEPT {
            self.grants.pop_front();
        }
        self.grants.push_back((now, upto));
        self.say(Order::Grant { run: self.run, upto }, effects);
    }

    /// Frames that members may be behind before real time slips: a quarter of a second of wall time, at least 5.
    fn slack(&self) -> Frame {
        ((0.25e9 * self.rate / self.config.step_ns as f64) as Frame).max(5)
    }

    /// Time passed.
    pub fn tick(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.mustering && !self.members.is_empty() && now >= self.last_muster + MUSTER_EVERY_NS {
            self.last_muster = now;
            self.say(Order::Muster, effects);
            self.try_configure(now, effects);
        }
        self.extend(now, effects);
        for (name, member) in &mut self.members {
            if let Some((fetch, _)) = member.stream.due(now) {
                let ask = FetchOf { of: name.clone(), fetch };
                effects.push(Effect::Fetch { holder: name.clone(), ask });
            }
        }
        if self.return_deadline.is_some_and(|d| now >= d) {
            self.return_deadline = None;
            if matches!(self.phase, Phase::Init | Phase::Configured) {
                effects.push(Effect::Exit(1));
            } else {
                self.finish(now, effects);
            }
        }
        if self.finish_deadline.is_some_and(|d| now >= d) {
            self.try_close(now, effects);
        }
        if now >= self.last_state + STATE_EVERY_NS {
            self.push_state(now, effects);
        }
        self.check_clocks(now, effects);
        self.ask_hosts(now, effects);
    }

    /// When [`Conductor::tick`] is due next.
    #[must_use]
    pub fn deadline(&self, now: WallNs) -> WallNs {
        let streams = self.members.values().filter_map(|m| m.stream.deadline());
        let clocks = [self.last_state + STATE_EVERY_NS, self.last_tick + CLOCKS_EVERY_NS];
        let mut next = streams.chain(clocks).chain(self.return_deadline).min().unwrap_or(now);
        if self.phase == Phase::Running && self.rate.is_finite() && self.goal == Goal::End {
            let step = self.config.step_ns as f64 / self.rate;
            let frames = (self.granted + 1).saturating_sub(self.anchor.1) as f64;
            let at = self.anchor.0 + (frames * step) as WallNs;
            // Where members are late, their frame ends move time, not this clock.
            next = next.min(if at + LATE_NS < now { now + LATE_NS } else { at });
        }
        if self.mustering {
            next = next.min(self.last_muster + MUSTER_EVERY_NS);
        }
        next.max(now + 100_000)
    }

    fn answer(&self, ok: bool, text: &str) -> Answer {
        Answer { ok, text: text.to_owned(), state: self.state() }
    }

    fn standing(&self) -> String {
        let mut text =
            format!("{} at frame {} of {}", self.phase, self.frame(), self.config.last_frame);
        let awaited = self.awaited();
        if self.phase == Phase::Init && !awaited.is_empty() {
            text += &format!(", waiting for {}", awaited.join(", "));
        }
        for reason in self.open_faults().iter().chain(&self.degraded) {
            text += &format!("; {reason}");
        }
        text
    }

    fn push_state(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.phase == Phase::Running {
            let frame = self.frame();
            self.pace_samples.push_back((now, frame));
            while self.pace_samples.front().is_some_and(|(at, _)| now - at > 3_000_000_000) {
                self.pace_samples.pop_front();
            }
        }
        self.last_state = now;
        let mut state = self.state();
        state.reasons.extend(self.slow(now));
        effects.push(Effect::State(state));
    }

    /// How the run stands.
    #[must_use]
    pub fn state(&self) -> RunState {
        let achieved_rate = match (self.pace_samples.front(), self.pace_samples.back()) {
            (Some(&(t0, f0)), Some(&(t1, f1))) if t1 > t0 && self.phase == Phase::Running => {
                (f1.saturating_sub(f0)) as f64 * self.config.step_ns as f64 / (t1 - t0) as f64
            }
            _ => 0.0,
        };
        RunState {
            scene: self.config.scene.clone(),
            run: self.run,
            phase: self.phase,
            frame: self.frame(),
            last_frame: self.config.last_frame,
            step_ns: self.config.step_ns,
            start_utc_ns: self.config.start_utc_ns,
            seed: self.config.seed,
            rate: self.rate,
            achieved_rate,
            reasons: [self.open_faults(), self.degraded.clone(), self.notes.clone()].concat(),
            members: self
                .members
                .iter()
                .map(|(name, m)| MemberState {
                    name: name.clone(),
                    host: m.hello.host.clone(),
                    pid: m.hello.pid,
                    essential: self.config.expected.contains(name),
                    alive: m.alive,
                    frame: m.executed.unwrap_or(0),
                    latency_us: m.latency_ns * 1e-3,
                })
                .collect(),
        }
    }
}
