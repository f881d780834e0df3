//! The conductor as a state machine: the one authority over time and life cycle.
//!
//! Pace, single step, freeze and "as fast as possible" are all ways in which the grant horizon moves.
//! The core reads no clock; the driver passes wall nanoseconds in.

use super::life_cycle::{Phase, Refused, Transition, possible, steps};
use super::member::WallNs;
use super::messages::{
    Answer, Command, FinalReport, Frame, Hello, MemberState, Order, Report, RunConfig, RunState,
    Welcome,
};
use super::views::Views;
use std::collections::{BTreeMap, VecDeque};

/// Names a question that waits for its answer.
pub type Token = u64;

/// What the conductor wants done.
#[derive(Debug, PartialEq)]
pub enum Effect {
    /// Answer a [`Hello`].
    Welcome(Token, Welcome),
    /// Tell all members.
    Order(Order),
    /// Answer a [`Command`].
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
    /// A member that holds everybody up for this long is given up, ns of wall time.
    pub stall_ns: WallNs,
}

#[derive(Debug)]
struct MemberEntry {
    hello: Hello,
    inc: u64,
    alive: bool,
    ready: Option<u32>,
    /// Consumers: whether they hear all producers. Others: true once they answered.
    present: bool,
    executed: Option<Frame>,
    /// Whether it needs the frames of the producers before it can go on.
    consumes: bool,
    /// Since when it could go on and has not; none while it is not due.
    due_since: Option<WallNs>,
    /// From a grant to the frame ends that answer it, smoothed, ns.
    latency_ns: f64,
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
    reasons: Vec<String>,
    /// What the run goes on without, and since when.
    degraded: Vec<String>,
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
    faulty: bool,
}

/// Share of a new latency in the smoothed one: about a second of frames.
const LATENCY_SMOOTHING: f64 = 0.05;
const GRANTS_KEPT: usize = 64;
/// Federates and spectators that are remembered, at most.
const MOST_MEMBERS: usize = 1024;
const MUSTER_EVERY_NS: WallNs = 20_000_000;
const STATE_EVERY_NS: WallNs = 200_000_000;
const FINISH_WITHIN_NS: WallNs = 5_000_000_000;

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
            reasons: Vec::new(),
            degraded: Vec::new(),
            views: Views::default(),
            roster: config.expected.clone(),
            last_state: 0,
            last_muster: 0,
            logger_deadline: None,
            pace_samples: VecDeque::new(),
            grants: VecDeque::new(),
            faulty: false,
            config,
        }
    }

    /// Phase of the run.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
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
            if self.members.get(&name).is_some_and(|m| m.alive) {
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
        if let Some(present) = self.members.get(&name).filter(|m| m.alive) {
            effects.push(refuse(format!(
                "'{name}' is already running (process {} on {}): stop that one first or choose another --exercise",
                present.hello.pid, present.hello.host
            )));
            return;
        }
        if hello.kind.essential() && !self.config.expected.contains(&name) {
            effects.push(refuse(format!(
                "'{name}' is not expected in this federation; expected: {}. Check --share and the administration station's --generators",
                self.config.expected.join(", ")
            )));
            return;
        }
        if hello.kind.essential() && !matches!(self.phase, Phase::Init) {
            effects.push(refuse(format!(
                "'{name}' cannot join a run that is {}: joining a run under way is not supported; start the federation anew",
                self.phase
            )));
            return;
        }
        let inc = self.next_inc;
        self.next_inc += 1;
        effects.push(Effect::Welcome(token, Welcome::Accepted { inc }));
        self.members.insert(
            name,
            MemberEntry {
                hello,
                inc,
                alive: true,
                ready: None,
                present: false,
                executed: None,
                consumes: false,
                due_since: None,
                latency_ns: 0.0,
            },
        );
        effects.push(Effect::Order(Order::Muster));
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
        if self.run > 0 || self.members.is_empty() {
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
        let joined = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
        self.roster = self.config.expected.clone();
        self.roster.extend(self.config.optional.iter().filter(joined).cloned());
        self.roster.sort();
        for member in self.members.values_mut() {
            member.ready = None;
            member.executed = None;
        }
        effects.push(Effect::Order(Order::Configure(RunConfig {
            run: self.run,
            seed: self.config.seed,
            producers: self.producers(),
            generators: self.config.generators,
            last_frame: self.config.last_frame,
        })));
    }

    /// A member's process or session is gone, or back.
    pub fn alive(
        &mut self,
        now: WallNs,
        name: &str,
        inc: u64,
        alive: bool,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get(name) else { return };
        if alive || member.inc != inc || !member.alive {
            return;
        }
        self.lose(now, name.to_owned(), "its process or connection is gone", effects);
    }

    fn lose(&mut self, now: WallNs, name: String, why: &str, effects: &mut Vec<Effect>) {
        let Some(member) = self.members.get_mut(&name).filter(|m| m.alive) else { return };
        member.alive = false;
        let (inc, host, pid) = (member.inc, member.hello.host.clone(), member.hello.pid);
        if !self.roster.contains(&name) {
            self.push_state(now, effects);
            return;
        }
        if self.phase == Phase::Stopped && self.finish_deadline.is_none() {
            return;
        }
        let reason = format!("{name} (process {pid} on {host}) is lost: {why}");
        let optional = self.config.optional.contains(&name);
        if optional {
            self.degraded.push(format!("degraded since frame {}: {reason}", self.frame()));
        } else {
            self.reasons.push(reason);
            self.faulty = true;
        }
        match self.phase {
            Phase::Running | Phase::Frozen => {
                let alive = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
                let survivors: Vec<_> = self.roster.iter().filter(alive).cloned().collect();
                let order = self.views.lose(now, &name, inc, optional, &survivors);
                effects.push(Effect::Order(order));
                self.settle_views(now, effects);
            }
            _ if optional => self.try_close(now, effects),
            _ => {
                self.fail_pending(effects);
                if self.config.batch {
                    effects.push(Effect::Exit(1));
                } else {
                    // Its final report will not come: a run that waits for it alone is closed.
                    self.try_close(now, effects);
                }
            }
        }
        self.push_state(now, effects);
    }

    fn fail_pending(&mut self, effects: &mut Vec<Effect>) {
        let text = self.reasons.last().cloned().unwrap_or_default();
        for (token, _) in std::mem::take(&mut self.pending) {
            effects.push(Effect::Answer(token, self.answer(false, &text)));
        }
    }

    /// A report of a member.
    pub fn report(&mut self, now: WallNs, from: &str, report: Report, effects: &mut Vec<Effect>) {
        let Some(member) = self.members.get_mut(from) else { return };
        match report {
            Report::Present { inc, hears, consumes } if inc == member.inc => {
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
            Report::Ready { run, inc } if run == self.run && inc == member.inc => {
                member.ready = Some(run);
                self.all_ready(now, effects);
            }
            Report::Ends(ends)
                if ends.run == self.run && ends.inc == member.inc && member.alive =>
            {
                let answered = member.executed.map_or(0, |e| e + 1);
                member.executed = Some(ends.last);
                member.due_since = None;
                // The grant that allowed the first of these frames.
                if let Some((at, _)) = self.grants.iter().find(|(_, upto)| *upto >= answered) {
                    let took = now.saturating_sub(*at) as f64;
                    member.latency_ns += (took - member.latency_ns) * LATENCY_SMOOTHING;
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
            Report::Failed { reason } => {
                let reason = format!("{from} cannot go on: {reason}");
                self.reasons.push(reason);
                self.faulty = true;
                self.fail_pending(effects);
                effects.push(Effect::Exit(1));
            }
            _ => {}
        }
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
        if self.config.autostart && self.run == 1 {
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

    /// A command of an operator; its answer comes when the state is reached.
    pub fn command(
        &mut self,
        now: WallNs,
        command: Command,
        token: Token,
        effects: &mut Vec<Effect>,
    ) {
        let refused = |this: &Self, refused: Refused| {
            Effect::Answer(token, this.answer(false, &refused.to_string()))
        };
        match command {
            Command::Status => {
                let text = self.standing();
                effects.push(Effect::Answer(token, self.answer(true, &text)));
            }
            Command::Start => {
                if let Some(why) = self.fault_blocks() {
                    effects.push(Effect::Answer(token, self.answer(false, &why)));
                    return;
                }
                match self.start(now, effects) {
                    Ok(()) => {
                        let text = format!("running from frame {}", self.anchor.1);
                        effects.push(Effect::Answer(token, self.answer(true, &text)));
                    }
                    Err(e) => effects.push(refused(self, e)),
                }
            }
            Command::Freeze => match self.phase.after(Transition::Freeze) {
                Ok(_) => {
                    self.pending.push((token, Transition::Freeze));
                    if self.goal == Goal::End {
                        self.goal = Goal::Freeze(self.granted);
                    }
                    self.settle(now, effects);
                }
                Err(e) => effects.push(refused(self, e)),
            },
            Command::Step { n } => {
                let can = steps(self.phase);
                if let Some(why) = self.fault_blocks() {
                    effects.push(Effect::Answer(token, self.answer(false, &why)));
                } else if !can || n == 0 {
                    let text = if n == 0 {
                        "a step is at least one frame".to_owned()
                    } else {
                        format!(
                            "'step' is not possible while {}; possible now: {}",
                            self.phase,
                            possible(self.phase)
                        )
                    };
                    effects.push(Effect::Answer(token, self.answer(false, &text)));
                } else {
                    self.phase = Phase::Running;
                    self.running_since = Some(now);
                    let target = self.granted.saturating_add(n).min(self.config.last_frame);
                    self.goal = Goal::Freeze(target);
                    self.pending.push((token, Transition::Freeze));
                    self.grant(now, target, effects);
                    self.settle(now, effects);
                }
            }
            Command::Stop => match self.phase.after(Transition::Stop) {
                Ok(_) => {
                    self.pending.push((token, Transition::Stop));
                    self.stop(now, effects);
                }
                Err(e) => effects.push(refused(self, e)),
            },
            Command::Restart => {
                if let Some(why) = self.fault_blocks() {
                    effects.push(Effect::Answer(token, self.answer(false, &why)));
                    return;
                }
                match self.phase.after(Transition::Restart) {
                    Ok(_) => {
                        self.pending.push((token, Transition::Restart));
                        if self.phase == Phase::Frozen {
                            self.restart_after = true;
                            self.stop(now, effects);
                        } else {
                            self.configure(effects);
                        }
                    }
                    Err(e) => effects.push(refused(self, e)),
                }
            }
            Command::Rate { rate } => {
                let text = if rate > 0.0 && !rate.is_nan() {
                    self.rate = rate;
                    self.anchor = (now, self.granted);
                    self.pace_samples.clear();
                    if rate.is_infinite() {
                        "rate: as fast as possible".to_owned()
                    } else {
                        format!("rate: {rate} simulated seconds per second")
                    }
                } else {
                    format!("rate {rate} is not above 0")
                };
                let ok = rate > 0.0;
                effects.push(Effect::Answer(token, self.answer(ok, &text)));
                self.extend(now, effects);
            }
        }
        self.push_state(now, effects);
    }

    fn fault_blocks(&self) -> Option<String> {
        self.faulty.then(|| {
            format!(
                "an essential federate is lost ({}); possible now: stop",
                self.reasons.last().map_or("", String::as_str)
            )
        })
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
        effects.push(Effect::Order(Order::Finish { run: self.run, frame }));
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
            reasons: self.reasons.iter().chain(&self.degraded).cloned().collect(),
            failed: self.faulty,
        })));
        self.answer_pending(Transition::Stop, "stopped", effects);
        if self.restart_after {
            self.configure(effects);
        } else if self.config.batch {
            effects.push(Effect::Exit(u8::from(self.faulty)));
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
        let reason = Some(self.reasons.join("; "));
        effects.push(Effect::Reached { phase: self.phase, frame: self.frame(), reason });
        self.fail_pending(effects);
        if self.config.batch {
            self.finish(now, effects);
        }
        self.push_state(now, effects);
    }

    /// Goes on with the view of lost members as far as the answers allow.
    fn settle_views(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let known = |name: &str| self.members.get(name).and_then(|m| m.executed);
        while let Some(order) = self.views.next_order(now, known) {
            effects.push(Effect::Order(order));
        }
        if self.phase == Phase::Frozen && self.views.waits() && !self.views.is_open() {
            // Lost while frozen by command: nothing moves, but a batch does not wait.
            if self.config.batch {
                self.finish(now, effects);
            }
            return;
        }
        self.settle(now, effects);
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
        effects.push(Effect::Order(Order::Grant { run: self.run, upto }));
    }

    /// Frames that members may be behind before real time slips: a quarter of a second of wall time, at least 5.
    fn slack(&self) -> Frame {
        ((0.25e9 * self.rate / self.config.step_ns as f64) as Frame).max(5)
    }

    /// Time passed.
    pub fn tick(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.run == 0 && !self.members.is_empty() && now >= self.last_muster + MUSTER_EVERY_NS {
            self.last_muster = now;
            effects.push(Effect::Order(Order::Muster));
            self.try_configure(now, effects);
        }
        self.extend(now, effects);
        let (asked_at, silent) = self.views.awaited();
        if now.saturating_sub(asked_at) > self.config.stall_ns {
            for name in silent {
                self.lose(now, name, "it does not answer", effects);
            }
        }
        if self.finish_deadline.is_some_and(|d| now >= d) {
            self.try_close(now, effects);
        }
        if now >= self.last_state + STATE_EVERY_NS {
            self.push_state(now, effects);
        }
        self.check_stall(now, effects);
    }

    /// Whether a member could execute a frame that it has not: granted, and of a consumer every input is made.
    fn is_due(&self, name: &str, member: &MemberEntry) -> bool {
        let executed = member.executed.unwrap_or(0);
        let made = |producer: &String| {
            let Some(made) = self.members.get(producer) else { return true };
            let counts = self.views.cut(producer).unwrap_or(made.executed);
            producer == name || self.views.is_absent(producer) || counts > Some(executed)
        };
        self.phase == Phase::Running
            && member.alive
            && self.roster.iter().any(|n| n == name)
            && executed < self.granted
            && (!member.consumes || self.producers().iter().all(made))
    }

    /// Gives up a member that could have gone on for longer than the stall budget. The clock of a member
    /// starts when it becomes due: time spent frozen, or waiting for others, is not its own.
    fn check_stall(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let due: Vec<bool> = self.members.iter().map(|(n, m)| self.is_due(n, m)).collect();
        let mut stuck = Vec::new();
        for ((name, member), due) in self.members.iter_mut().zip(due) {
            let since = *member.due_since.get_or_insert(now);
            if !due || self.views.is_open() {
                member.due_since = None;
            } else if now.saturating_sub(since) > self.config.stall_ns {
                stuck.push(name.clone());
            }
        }
        for name in stuck {
            let seconds = self.config.stall_ns as f64 * 1e-9;
            self.lose(now, name, &format!("no frame end for {seconds} s"), effects);
        }
    }

    /// When [`Conductor::tick`] is due next.
    #[must_use]
    pub fn deadline(&self, now: WallNs) -> WallNs {
        let mut next = self.last_state + STATE_EVERY_NS;
        if self.phase == Phase::Running && self.rate.is_finite() && self.goal == Goal::End {
            let step = self.config.step_ns as f64 / self.rate;
            let frames = (self.granted + 1).saturating_sub(self.anchor.1) as f64;
            next = next.min(self.anchor.0 + (frames * step) as WallNs);
        }
        if self.run == 0 {
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
        for reason in &self.reasons {
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
        effects.push(Effect::State(self.state()));
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
            reasons: self.reasons.iter().chain(&self.degraded).cloned().collect(),
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
