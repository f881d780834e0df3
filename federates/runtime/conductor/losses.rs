//! Who is lost, why, and how a lost member comes back.

use super::{Conductor, Effect, Fault, MemberEntry, MemberLog, OnLoss, Token, Why};
use crate::runtime::clock::WallNs;
use crate::runtime::digest::content;
use crate::runtime::life_cycle::{Phase, Transition};
use crate::runtime::messages::{
    Accepted, Frame, Hello, Kind, Order, ProducerAt, Return, Standing, Welcome,
};
use scenarios::losses::ReturnWithin;

/// Silence of a member whose connection is gone, before it is given up: three beats.
pub(super) const SILENT_NS: WallNs = 300_000_000;

/// A pause of the conductor itself: what was not heard meanwhile says nothing about members.
const OWN_PAUSE_NS: WallNs = 300_000_000;

/// A frame that takes longer is spoken of.
pub(super) const SLOW_NS: WallNs = 2_000_000_000;

/// At most so many returns of one member in a run end at the same frame.
const DEATHS_AT_ONE_FRAME: usize = 3;

/// A member of which nothing is heard for so long is given up, where nothing else is said.
const STALL_NS: WallNs = 2_000_000_000;

/// The same of one that is heard of but does not go on.
const HANG_NS: WallNs = 60_000_000_000;

/// How long a batch waits for a process that takes a lost one's place.
const TAKE_OVER_NS: WallNs = 10_000_000_000;

/// Nobody took its place: somebody else is asked then, and at most so many in a run.
const HOST_AGAIN_NS: WallNs = 3_000_000_000;
const MOST_HOSTS: u32 = 12;

/// Before a run has begun nothing is lost with a member: a batch awaits it for so long.
const JOIN_AGAIN_NS: WallNs = 10_000_000_000;

impl Conductor {
    /// A member's process or session is gone, or back: a hint, until it is silent too.
    pub fn alive(
        &mut self,
        now: WallNs,
        name: &str,
        inc: u64,
        alive: bool,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(name).filter(|m| m.inc == inc) else { return };
        member.token_gone = !alive;
        member.ran_out = !alive && now.saturating_sub(member.heard_at) > SILENT_NS;
        if !alive && member.alive && !member.hello.kind.beats() {
            self.lose(now, name.to_owned(), "its process or connection is gone", effects);
        }
        let beats = |m: &&mut MemberEntry| m.alive && m.hello.kind.beats();
        if self.config.through_router
            && self.members.values_mut().filter(beats).all(|m| m.token_gone)
        {
            self.members.values_mut().filter(beats).for_each(|m| m.ran_out = true);
        }
    }

    /// Whether a member could execute a frame that it has not: granted, and of a consumer every input made.
    fn is_due(&self, name: &str, member: &MemberEntry) -> bool {
        let executed = member.executed.unwrap_or(0);
        let made = |producer: &String| {
            let Some(made) = self.members.get(producer) else { return true };
            let Some(ahead) = self.ahead_of(name, member.hello.kind, producer) else { return true };
            let counts = self.views.cut(producer).unwrap_or(made.executed);
            self.views.is_absent(producer) || counts.map(|c| c + ahead) > Some(executed)
        };
        self.phase == Phase::Running
            && member.alive
            && self.roster.iter().any(|n| n == name)
            && executed < self.granted
            && (!member.consumes || self.producers().iter().all(made))
    }

    /// Two clocks: nothing heard of a member, and heard of but not going on. The second starts when a member
    /// becomes due: time spent frozen, or waiting for others, is not its own.
    pub(super) fn check_clocks(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let paused = now.saturating_sub(self.last_tick);
        self.last_tick = now;
        let due: Vec<bool> = self.members.iter().map(|(n, m)| self.is_due(n, m)).collect();
        let settling = self.views.is_open();
        let (asked_at, silent) = self.views.awaited();
        let clocks = |name: &String| (self.stall_ns(name), self.hang_ns(name));
        let clocks: Vec<_> = self.members.keys().map(clocks).collect();
        let mut lost = Vec::new();
        for ((name, member), (due, (stall_ns, hang_ns))) in
            self.members.iter_mut().zip(due.into_iter().zip(clocks))
        {
            if paused > OWN_PAUSE_NS {
                member.heard_at += paused;
            }
            let since = *member.due_since.get_or_insert(now);
            if !due || settling {
                member.due_since = None;
            }
            // Who was accepted and has not answered yet may not know it.
            let unanswered = self.phase == Phase::Init && !member.heard;
            if !member.alive || !member.hello.kind.beats() || unanswered && !member.token_gone {
                continue;
            }
            let heard_ago = now.saturating_sub(member.heard_at);
            let owes = settling && silent.contains(name) && now.saturating_sub(asked_at) > hang_ns;
            if member.token_gone && !member.ran_out && heard_ago > SILENT_NS {
                lost.push((
                    member.heard_at,
                    name.clone(),
                    "its process or connection is gone".into(),
                ));
            } else if heard_ago > stall_ns {
                let text = format!("nothing was heard of it for {} s", stall_ns as f64 / 1e9);
                lost.push((member.heard_at, name.clone(), text));
            } else if heard_ago <= SILENT_NS
                && member.due_since.is_some()
                && now.saturating_sub(since) > hang_ns
            {
                let frame = member.executed.map_or(0, |e| e + 1);
                let text = format!("its frame {frame} hangs for {} s", hang_ns as f64 / 1e9);
                lost.push((since, name.clone(), text));
            } else if owes {
                lost.push((asked_at, name.clone(), "it does not answer".to_owned()));
            }
        }
        lost.sort();
        for (_, name, why) in lost {
            self.lose(now, name, &why, effects);
        }
    }

    /// What takes long, for people.
    pub(super) fn slow(&self, now: WallNs) -> Vec<String> {
        let slow = |(name, m): (&String, &MemberEntry)| {
            let for_ns = now.saturating_sub(m.due_since?);
            let frame = m.working.unwrap_or(m.executed.map_or(0, |e| e + 1));
            (for_ns > SLOW_NS).then(|| {
                format!("{name} is working on frame {frame} for {:.0} s", for_ns as f64 * 1e-9)
            })
        };
        let mut words: Vec<String> = self.members.iter().filter_map(slow).collect();
        let owing = self.owing();
        if !owing.is_empty() && now.saturating_sub(self.finish_since) > SLOW_NS {
            words.push(format!("waiting for the results of {}", owing.join(", ")));
        }
        words
    }

    /// Gives a member up.
    pub(super) fn lose(&mut self, now: WallNs, name: String, why: &str, effects: &mut Vec<Effect>) {
        let Some(member) = self.members.get(&name) else { return };
        let (host, pid) = (&member.hello.host, member.hello.pid);
        let reason = format!("{name} (process {pid} on {host}) is lost: {why}");
        self.lose_for(now, name, reason, effects);
    }

    /// Gives a member up for this `reason`.
    pub(super) fn lose_for(
        &mut self,
        now: WallNs,
        name: String,
        reason: String,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(&name).filter(|m| m.alive) else { return };
        member.alive = false;
        member.due_since = None;
        let inc = member.inc;
        self.outbox.forget(&name);
        // After the last frame only its results may be missing.
        let over = self.finish_deadline.is_none() || self.finals.contains_key(&name);
        let told = self.phase == Phase::Stopped && over;
        if !self.roster.contains(&name) || told {
            if self.views.survives(&name) {
                // Nothing is awaited of it any more, but for its answer by those whose loss is being settled.
                self.open_view(now, &name, inc, false, effects);
            }
            return self.push_state(now, effects);
        }
        let optional = self.config.optional.contains(&name);
        let absent = self.on_loss(&name) == OnLoss::Degrade;
        if absent && matches!(self.phase, Phase::Running | Phase::Frozen) {
            self.absent.insert(name.clone(), reason);
        } else if !optional {
            self.faults.push(Fault { name: name.clone(), text: reason, since: now, back: None });
        }
        let awaited = self.phase == Phase::Stopped && !optional && self.await_results(now, &name);
        match self.phase {
            Phase::Running | Phase::Frozen => self.open_view(now, &name, inc, absent, effects),
            Phase::Stopped if awaited => self.open_view(now, &name, inc, false, effects),
            Phase::Stopped => {
                if self.views.survives(&name) {
                    self.open_view(now, &name, inc, false, effects);
                }
                self.try_close(now, effects);
            }
            _ if optional => self.try_close(now, effects),
            Phase::Init | Phase::Configured => {
                // Nothing has been made: it is waited for, and the run is configured when it is there.
                self.fail_pending(effects);
                let why = Some(Why::Fault(self.open_faults().join("; ")));
                self.muster_again();
                effects.push(Effect::Reached { phase: self.phase, frame: 0, why });
                if self.config.batch {
                    self.return_deadline.get_or_insert(now + JOIN_AGAIN_NS);
                }
            }
        }
        self.push_state(now, effects);
    }

    pub(super) fn open_view(
        &mut self,
        now: WallNs,
        name: &str,
        inc: u64,
        absent: bool,
        effects: &mut Vec<Effect>,
    ) {
        let alive = |n: &&String| self.members.get(*n).is_some_and(|m| m.alive);
        let survivors: Vec<_> = self.roster.iter().filter(alive).cloned().collect();
        let order = self.views.lose(now, name, inc, absent, &survivors);
        self.say(order, effects);
        if !absent {
            // Time stands for it. Who asked for an end of the run gets that all the same, and hears of it then.
            let ends = |what: &Transition| matches!(what, Transition::Stop | Transition::Restart);
            let pending = std::mem::take(&mut self.pending).into_iter();
            let (kept, failed) = pending.partition(|(_, what)| ends(what));
            self.pending = failed;
            self.fail_pending(effects);
            self.pending = kept;
        }
        self.settle_views(now, effects);
    }

    /// Goes on with the view of lost members as far as the answers allow.
    pub(super) fn settle_views(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        loop {
            let known = |name: &str| self.members.get(name).and_then(|m| m.executed);
            let Some(order) = self.views.next_order(now, known) else { break };
            if let Order::View { cuts, absent, .. } = &order {
                for (name, cut) in cuts.iter().filter(|(name, _)| absent.contains(name)) {
                    let Some(reason) = self.absent.remove(name) else { continue };
                    let since = cut.map_or(0, |cut| cut + 1);
                    self.degraded.push(format!("degraded since frame {since}: {reason}"));
                }
            }
            self.say(order, effects);
        }
        self.ask_hosts(now, effects);
        if self.phase == Phase::Frozen && self.views.waits() && !self.views.is_open() {
            self.faulty_freeze(now, effects);
            return;
        }
        let goes_on = !self.views.waits() && !self.views.is_open();
        if self.phase == Phase::Frozen && self.frozen_by_fault && goes_on {
            // Whom time stood for is done without.
            return self.go_on(now, effects);
        }
        self.settle(now, effects);
    }

    /// Frozen with a member lost: what the policy says.
    pub(super) fn faulty_freeze(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.fail_pending(effects);
        let within = self.return_ns(now);
        self.return_deadline = within.map(|within| now + within);
        let lost = self.lost_names();
        let aborts = lost.iter().any(|name| self.on_loss(name) == OnLoss::Abort);
        if within == Some(0) || aborts {
            self.finish(now, effects);
        }
        self.push_state(now, effects);
    }

    /// How long nothing may be heard of a member, ns.
    pub(super) fn stall_ns(&self, name: &str) -> WallNs {
        self.config.losses.stall_ms.of(name).map_or(STALL_NS, |ms| ms * 1_000_000)
    }

    /// How long a member may stay at one frame, ns.
    pub(super) fn hang_ns(&self, name: &str) -> WallNs {
        self.config.losses.step_ms.of(name).map_or(HANG_NS, |ms| ms * 1_000_000)
    }

    /// What becomes of the run when a member is lost; what holds for all does not speak of optional ones.
    pub(super) fn on_loss(&self, name: &str) -> OnLoss {
        let losses = &self.config.losses.on_loss;
        match self.config.optional.iter().any(|optional| optional == name) {
            true => losses.by_name(name).unwrap_or(OnLoss::Degrade),
            false => losses.of(name).unwrap_or_default(),
        }
    }

    /// Whether a lost member of the run may come back to it.
    fn may_return(&self) -> bool {
        matches!(self.phase, Phase::Running | Phase::Frozen) || self.awaits_results()
    }

    /// How long the lost are waited for. A batch ends at once where nobody would start them again; who was lost with the station has as
    /// long as it takes to find that one.
    pub(super) fn return_ns(&self, now: WallNs) -> Option<WallNs> {
        let taken_over = |name: &String| self.on_loss(name) == OnLoss::TakeOver;
        let unheard = |name: &String| self.members.get(name).is_some_and(|m| !m.heard);
        match self.config.losses.return_ms {
            Some(ReturnWithin::Ms(ms)) => Some(ms * 1_000_000),
            Some(ReturnWithin::NoEnd) => None,
            None if !self.config.batch => None,
            None if self.sought_until > now && self.lost_names().iter().any(unheard) => {
                Some(self.sought_until - now)
            }
            None if self.lost_names().iter().all(taken_over) => Some(TAKE_OVER_NS),
            None => Some(0),
        }
    }

    /// Asks the processes of surviving producers to take the places of lost ones, where the policy says so.
    pub(super) fn ask_hosts(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if !self.may_return() || self.views.is_open() {
            return;
        }
        let places = self.places();
        let waits = |n: &String| {
            let fresh = |m: &MemberEntry| m.returning && now < m.heard_at + self.stall_ns(n);
            let back = self.members.get(n).is_some_and(|m| m.alive || fresh(m));
            !back && places.contains(n) && self.on_loss(n) == OnLoss::TakeOver
        };
        let lost: Vec<String> = self.lost_names().into_iter().filter(waits).collect();
        for name in lost {
            let (asked_at, tries) = self.hosted.get(&name).copied().unwrap_or((0, 0));
            if tries >= MOST_HOSTS || asked_at > 0 && now < asked_at + HOST_AGAIN_NS {
                continue;
            }
            let hosts =
                |p: &&String| self.members.get(*p).is_some_and(|m| m.alive && m.hello.kind.hosts());
            let alive: Vec<&String> = self.config.producers.iter().filter(hosts).collect();
            // Every lost one its own, and another one each time: equal rosters choose equally.
            let turn = content(tries.into(), name.bytes().map(u64::from), std::iter::empty());
            let chosen = self.moving.get(&name).filter(|to| tries == 0 && alive.contains(to));
            let by = alive.get((turn % alive.len().max(1) as u64) as usize).copied();
            let as_asked = chosen.is_some();
            let Some(by) = chosen.or(by).cloned() else { continue };
            self.hosted.insert(name.clone(), (now, tries + 1));
            if !as_asked {
                self.notes.push(format!("{name} is taken over by the process of {by}"));
            }
            self.say(Order::Host { run: self.run, name, by }, effects);
        }
    }

    /// Answers a process that was a member of this run, or is to take a lost one's place; none if it is neither.
    pub(super) fn welcome_back(
        &mut self,
        now: WallNs,
        hello: &Hello,
        token: Token,
    ) -> Option<Effect> {
        let name = &hello.name;
        if !self.may_return() || !self.roster.contains(name) {
            return None;
        }
        let later = |why: &str| Some(Effect::Welcome(token, Welcome::Later(why.to_owned())));
        let Some(cut) = self.views.cut(name) else {
            return later("its loss is being settled");
        };
        if self.views.is_absent(name) {
            let text =
                format!("the run goes on without '{name}': it takes part again after a restart");
            return Some(Effect::Welcome(token, Welcome::Refused(text)));
        }
        if self.views.is_open() {
            return later("a loss is being settled");
        }
        let old = self.members.get(name)?;
        let cut = self.returns_at(name, cut);
        let at_cut = |fault: &&Fault| fault.name == *name && fault.back == Some(cut);
        if self.faults.iter().filter(at_cut).count() >= DEATHS_AT_ONE_FRAME {
            let text =
                format!("'{name}' dies at frame {} again and again", cut.map_or(0, |c| c + 1));
            return Some(Effect::Welcome(token, Welcome::Refused(text)));
        }
        let removed_inc = self.views.removed().get(name).map(|r| r.inc);
        let was = hello.was.filter(|w| w.fed == self.config.fed && w.run == self.run);
        let keep = hello.instance == old.hello.instance && was.map(|w| w.inc) == removed_inc;
        let producers = match old.consumes {
            true => {
                let names = self.producers();
                let others = names.iter().filter(|n| *n != name);
                others.map(|n| self.producer_at((name, old.hello.kind), n, cut)).collect()
            }
            false => Vec::new(),
        };
        let (consumes, present) = (old.consumes, old.present);
        let mut log = old.log.clone();
        log.cut(cut);
        let enter = Return { config: self.run_config(), upto: cut, keep, producers };
        let inc = self.next_inc;
        self.next_inc += 1;
        let (fed, orders, enter) = (self.config.fed, self.outbox.last(), Some(enter));
        let accepted = Accepted { fed, inc, orders, enter, epoch: 0 };
        let mut entry = MemberEntry::new(self.config.fed, hello.clone(), accepted.clone(), now);
        entry.alive = false;
        entry.returning = true;
        (entry.consumes, entry.present) = (consumes, present);
        entry.executed = cut;
        entry.log = log;
        self.members.insert(name.clone(), entry);
        Some(Effect::Welcome(token, Welcome::Accepted(Box::new(accepted))))
    }

    /// Where the frames of a producer come from, for a consumer of a kind that has those up to `upto`.
    fn producer_at(&self, reader: (&str, Kind), name: &str, upto: Option<Frame>) -> ProducerAt {
        let absent = self.views.is_absent(name);
        let name = name.to_owned();
        let member = self.members.get(&name);
        // Frame 0 of a consumer has no inputs.
        let used = upto.filter(|frame| *frame > 0);
        // It has made nothing only if what the consumer used is known here.
        let empty = |made| member.is_some_and(|m| m.log.content == 0 && m.executed >= made);
        let logged = member.and_then(|m| m.executed);
        if let Some(cut) = self.views.cut(&name) {
            // The lost consumer may have been ahead of the survivors: what it used is made again too.
            let made = if absent { cut } else { cut.max(used) };
            let made = self.made_again(reader, &name, made);
            return ProducerAt { empty: empty(made), name, made, stream: None, absent, logged };
        }
        // What an incarnation before made is not in this one's stream.
        let made = used.max(member.and_then(|m| m.log.before));
        let made = self.made_again(reader, &name, made);
        let stream = member.map(|m| {
            let later = m.log.reports.iter().find(|(_, last)| Some(*last) > made);
            (m.inc, later.map_or(m.stream.seen() + 1, |(seq, _)| *seq))
        });
        ProducerAt { empty: empty(made), name, made, stream, absent, logged }
    }

    /// A member that returns says how it stands; if that is how the lost one stood, the run goes on with it.
    pub(super) fn returned(
        &mut self,
        now: WallNs,
        name: &str,
        at: Standing,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(name).filter(|m| m.returning) else { return };
        let upto = member.executed;
        let (made, state) = (member.log.made_at(upto), member.log.state_at(upto));
        let differs = |own: Option<u64>, told: Option<u64>| matches!((own, told), (Some(own), Some(told)) if own != told);
        let unknown = member.consumes && upto.is_some() && (state.is_none() || at.state.is_none());
        if at.frame != upto || differs(made, Some(at.made)) || differs(state, at.state) || unknown {
            let frame = upto.unwrap_or(0);
            let text = format!(
                "the run as {name} made it again differs at frame {frame} or before: it is another build, scene or input than the one that was lost"
            );
            let inc = member.inc;
            member.returning = false;
            self.notes.push(text.clone());
            self.say(Order::Dismiss { name: name.to_owned(), inc, reason: text }, effects);
            return self.push_state(now, effects);
        }
        member.returning = false;
        member.alive = true;
        member.heard_at = now;
        let inc = member.inc;
        self.views.returned(name);
        if let Some((asked_at, _)) = self.hosted.get_mut(name) {
            *asked_at = 0;
        }
        if self.moving.remove(name).is_some()
            && let Some(at) = self.faults.iter().position(|f| f.name == name && f.back.is_none())
        {
            // It went by command: no fault of the run, and all is well again.
            self.faults.remove(at);
        }
        for fault in self.faults.iter_mut().filter(|f| f.name == name && f.back.is_none()) {
            fault.back = Some(upto);
            let after_s = now.saturating_sub(fault.since) as f64 * 1e-9;
            fault.text += &format!("; back after {after_s:.1} s, from frame {}", upto.unwrap_or(0));
        }
        let from = upto.map_or(0, |u| u + 1);
        self.say(Order::Admit { run: self.run, name: name.to_owned(), inc, from }, effects);
        if self.granted > 0 {
            self.say(Order::Grant { run: self.run, upto: self.granted }, effects);
        }
        self.finish_again(now, name, effects);
        if !self.views.waits() && !self.views.is_open() {
            self.go_on(now, effects);
        }
        self.push_state(now, effects);
    }

    /// All are back: the run goes on as it went.
    fn go_on(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.return_deadline = None;
        self.anchor = (now, self.granted);
        self.pace_samples.clear();
        if self.frozen_by_fault {
            self.frozen_by_fault = false;
            self.phase = Phase::Running;
            self.running_since = Some(now);
            let frame = self.frame();
            effects.push(Effect::Reached { phase: self.phase, frame, why: None });
        }
        self.settle(now, effects);
        self.extend(now, effects);
    }

    /// Names of essential members that are lost.
    pub(super) fn lost_names(&self) -> Vec<String> {
        let open = self.faults.iter().filter(|f| f.back.is_none());
        let mut names: Vec<_> = open.map(|f| f.name.clone()).collect();
        names.sort();
        names.dedup();
        names
    }

    /// Losses that nobody has made good.
    pub(super) fn open_faults(&self) -> Vec<String> {
        self.faults.iter().filter(|f| f.back.is_none()).map(|f| f.text.clone()).collect()
    }
}

impl MemberLog {
    /// Digest of all that was made up to `frame`, where it is remembered.
    fn made_at(&self, frame: Option<Frame>) -> Option<u64> {
        let Some(frame) = frame else { return Some(0) };
        self.made.iter().find(|(f, _)| *f == frame).map(|(_, made)| *made)
    }

    fn state_at(&self, frame: Option<Frame>) -> Option<u64> {
        let Some(frame) = frame else { return Some(0) };
        self.states.iter().find(|(f, _)| *f == frame).map(|(_, state)| *state)
    }

    /// Forgets what was made after `frame`.
    fn cut(&mut self, frame: Option<Frame>) {
        self.made.retain(|(f, _)| Some(*f) <= frame);
        self.named.retain(|(f, _)| Some(*f) <= frame);
        self.used.retain(|used| Some(used.last) <= frame);
        self.states.retain(|(f, _)| Some(*f) <= frame);
        self.reports.clear();
        self.whole.clear();
        self.before = frame;
        self.content = self.made.back().map_or(0, |(_, made)| *made);
    }
}
