//! The conductor as a state machine: the one authority over time and life cycle.
//!
//! Pace, single step, freeze and "as fast as possible" are all ways in which the grant horizon moves.
//! The core reads no clock; the driver passes wall nanoseconds in.

mod answers;
mod commands;
mod differences;
mod input;
mod joining;
mod losses;
mod pace;
mod phases;
mod recording;
mod reports;

use super::clock::WallNs;
use super::digest::content;
use super::life_cycle::{Phase, Transition};
use super::messages::{
    Accepted, Answer, FetchOf, FinalReport, Frame, FrameEnds, Hello, Joined, Kind, LogRecord,
    Numbered, Order, Report, RunState, Used, Welcome,
};
use super::stream::{Inbox, Outbox};
use super::views::Views;
use scenarios::losses::Losses;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

pub use input::{Again, Input, Replay, Step};
pub use scenarios::losses::OnLoss;

/// Names a question that waits for its answer.
pub type Token = u64;

/// Why a phase was reached that nobody asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Why {
    /// By a fault of the run.
    Fault(String),
    /// A place was given to another process by command: time stands until it is there.
    Given(String),
}

impl Why {
    /// In words.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Fault(text) | Self::Given(text) => text,
        }
    }
}

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
    /// Keep for whoever has to make a run again: its number, and the record.
    Record(u32, LogRecord),
    /// Tell spectators how the run stands.
    State(RunState),
    /// A phase was reached at a frame: for DIS simulation management, log and page.
    Reached {
        /// Phase.
        phase: Phase,
        /// Frame.
        frame: Frame,
        /// Why, if nobody asked for the phase itself.
        why: Option<Why>,
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
    /// Producers without which the run begins and goes on (visitors), sorted: their loss degrades it, and nobody can
    /// make their frames again.
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
    /// Who closes a loop, and by how many frames the traffic generators, who alone read it, may be ahead of it.
    pub closes: Option<(String, Frame)>,
    /// Consumers whose frames one other consumer alone reads, each with that one; they read no consumer.
    pub front_ends: BTreeMap<String, String>,
    /// One connection of the station carries all members: where all are gone at once it is this one.
    pub through_router: bool,
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
    /// It was unheard of before its token went: its connection ran out, which says nothing of its process.
    ran_out: bool,
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
    /// Sum of the hashes of the PDUs of each frame without a gap.
    named: VecDeque<(Frame, u64)>,
    /// What it used, until all that is known that was to be used.
    used: VecDeque<Used>,
    /// Digests of its state at the ends of reports.
    states: VecDeque<(Frame, u64)>,
    /// Numbers of the reports of its frame ends, each with its last frame.
    reports: VecDeque<(u64, Frame)>,
    /// Frames up to here were made by an incarnation before.
    before: Option<Frame>,
    /// Frames up to here are in the log of the run.
    recorded: Option<Frame>,
    /// PDUs of frames that have not ended, for the log.
    whole: Vec<(Frame, Vec<u8>)>,
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
            ran_out: false,
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
            let named = hashes.clone().fold(0, |sum: u64, hash| sum.wrapping_add(*hash));
            self.named.push_back((frame, named));
            let notices = ends.notices.iter().filter(|(made, ..)| *made == frame);
            self.content = self.content.wrapping_add(content(
                frame,
                hashes.copied(),
                notices.map(|(_, effect, notice)| (*effect, notice)),
            ));
            self.made.push_back((frame, self.content));
        }
        self.used.extend(ends.used.iter().cloned());
        self.states.extend(ends.state.map(|state| (ends.last, state)));
        self.reports.push_back((seq, ends.last));
        self.named.drain(..self.named.len().saturating_sub(LOGGED));
        self.used.drain(..self.used.len().saturating_sub(LOGGED));
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
#[derive(Debug)]
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
    finish_since: WallNs,
    /// Lost after the last frame of the run: their results are awaited.
    late: BTreeSet<String>,
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
    /// Whose place was given to whose process by command, until it is there.
    moving: BTreeMap<String, String>,
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
    /// Until then who was lost with the station before this process has time to find it.
    sought_until: WallNs,
    /// A run of this federation ended by a fault.
    failed: bool,
    /// Members of this run were found to differ.
    differed: bool,
    last_tick: WallNs,
}

/// Frames and reports of each member that are remembered: more than any grant horizon.
const LOGGED: usize = 4096;

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
            finish_since: 0,
            late: BTreeSet::new(),
            restart_after: false,
            faults: Vec::new(),
            notes: Vec::new(),
            degraded: Vec::new(),
            absent: BTreeMap::new(),
            hosted: BTreeMap::new(),
            moving: BTreeMap::new(),
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
            sought_until: 0,
            failed: false,
            differed: false,
            last_tick: 0,
            config,
        }
    }

    /// Phase of the run.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The federation that it leads.
    #[must_use]
    pub fn fed(&self) -> u128 {
        self.config.fed
    }

    /// Whose voices decide who leads: the members without which there is no run.
    #[must_use]
    pub fn voters(&self) -> &[String] {
        &self.config.expected
    }

    /// The incarnation of the member of that name.
    #[must_use]
    pub fn inc_of(&self, name: &str) -> Option<u64> {
        self.members.get(name).map(|member| member.inc)
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

    /// By how many frames `reader` may be ahead of `producer`; none where it does not read it.
    fn ahead_of(&self, reader: &str, kind: Kind, producer: &str) -> Option<Frame> {
        let (generates, front_ends) = (kind == Kind::TrafficGenerator, &self.config.front_ends);
        if let Some(fuser) = front_ends.get(producer) {
            return (fuser == reader).then_some(0);
        }
        if front_ends.get(reader).is_some_and(|fuser| fuser == producer) {
            return None;
        }
        match &self.config.closes {
            // In a loop generators read him who closes it, and nobody else does.
            Some((by, ahead)) if generates && by == producer => Some(*ahead),
            Some((by, _)) if generates || by == producer => None,
            _ => (reader != producer).then_some(0),
        }
    }

    /// Where consumers of all producers stand while frames of lost members are awaited.
    #[must_use]
    pub fn stand(&self) -> Frame {
        self.stand_of(|_| Some(0))
    }

    /// Where one stands then that may be so many frames ahead of each producer; none of one that it does not read.
    pub fn stand_of(&self, ahead_of: impl Fn(&str) -> Option<Frame>) -> Frame {
        let producers = self.producers();
        let awaited = producers.iter().filter(|name| !self.views.is_absent(name));
        let cuts = awaited.filter_map(|name| Some((self.views.cut(name)?, ahead_of(name)?)));
        cuts.map(|(cut, ahead)| cut.unwrap_or(0) + ahead).fold(self.granted, Frame::min)
    }

    /// Numbers an order; a muster is repeated anyway.
    fn say(&mut self, order: Order, effects: &mut Vec<Effect>) {
        effects.push(Effect::Order(match order {
            // Outside the stream: nothing of the run depends on them.
            Order::Muster | Order::Stand { .. } => self.outbox.loose(order),
            order => self.outbox.push(order),
        }));
    }
}
