//! Who joins, and when a run is configured.

use super::{Conductor, Effect, Goal, MemberEntry, MemberLog, Token};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::{Phase, Transition};
use crate::runtime::messages::{Accepted, Hello, Order, RunConfig, Welcome};

/// Federates and spectators that are remembered, at most.
const MOST_MEMBERS: usize = 1024;

impl Conductor {
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
            // The station was away, and this one has not been heard since: another process has its name now.
            let away = present.alive && !same && present.heard_at > now;
            if away && hello.kind.beats() {
                self.lose(now, name.clone(), "another process has come in its place", effects);
            } else if same && present.alive && self.roster.contains(&name) {
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
                "'{name}' is not expected in this federation; expected: {}. Check --share and the administration station's --generators and --smdfms",
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
        let accepted = Accepted { fed, inc, orders, enter: None, epoch: 0 };
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
    pub(super) fn heard_producers(&self) -> Vec<String> {
        let joined = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
        let optional = self.config.optional.iter().filter(joined);
        self.config.producers.iter().chain(optional).cloned().collect()
    }

    /// Configures once everybody is there and hears everybody; a spectator is awaited for a while only.
    pub(super) fn try_configure(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
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

    pub(super) fn configure(&mut self, effects: &mut Vec<Effect>) {
        self.run += 1;
        self.differed = false;
        self.granted = 0;
        self.grants.clear();
        self.goal = Goal::End;
        self.finals.clear();
        self.finish_deadline = None;
        self.late.clear();
        self.restart_after = false;
        self.ran_ns = 0;
        self.running_since = None;
        self.pace_samples.clear();
        self.views.reset(self.run);
        self.degraded.clear();
        self.absent.clear();
        self.hosted.clear();
        self.moving.clear();
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

    pub(super) fn run_config(&self) -> RunConfig {
        let inc = |n: &String| self.members.get(n).map(|m| (n.clone(), m.inc));
        let consumes = |n: &&String| self.members.get(*n).is_some_and(|m| m.consumes);
        RunConfig {
            run: self.run,
            seed: self.config.seed,
            producers: self.producers(),
            live: self
                .roster
                .iter()
                .filter(|n| self.config.optional.contains(n))
                .cloned()
                .collect(),
            consumers: self.roster.iter().filter(consumes).cloned().collect(),
            incs: self.roster.iter().filter_map(inc).collect(),
            generators: self.config.generators,
            last_frame: self.config.last_frame,
        }
    }

    /// Begins a run, or waits for whom it needs and says so.
    pub(super) fn begin_again(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.awaited().is_empty() {
            return self.configure(effects);
        }
        if self.phase != Phase::Init {
            effects.push(Effect::Reached { phase: Phase::Init, frame: 0, why: None });
        }
        self.muster_again();
        let text = format!("{}: start what is missing, or stop", self.standing());
        self.answer_pending(Transition::Restart, &text, effects);
        self.push_state(now, effects);
    }

    pub(super) fn muster_again(&mut self) {
        self.mustering = true;
        self.last_muster = 0;
        let members = &self.members;
        self.faults.retain(|f| members.get(&f.name).is_some_and(|m| !m.alive));
        for member in self.members.values_mut() {
            member.ready = None;
        }
        self.phase = Phase::Init;
    }
}
