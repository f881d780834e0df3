//! From phase to phase: ready, started, frozen, closed.

use super::{ClosedRun, Conductor, Effect, Fault, Goal, OnLoss, Why};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::{Phase, Refused, Transition};
use crate::runtime::messages::{Numbered, Order};

/// Results are awaited at least so long, of members that are heard of; as long as a frame may take where that is longer.
const FINISH_WITHIN_NS: WallNs = 5_000_000_000;

impl Conductor {
    pub(super) fn all_ready(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let is_ready =
            |n: &String| self.members.get(n).is_some_and(|m| !m.alive || m.ready == Some(self.run));
        let ready = self.awaited().is_empty() && self.roster.iter().all(is_ready);
        if !ready || self.finish_deadline.is_some() {
            return;
        }
        let was = self.phase;
        if was != Phase::Configured {
            self.phase = Phase::Configured;
            effects.push(Effect::Reached { phase: self.phase, frame: 0, why: None });
        }
        self.answer_pending(Transition::Restart, "configured; waiting for start", effects);
        if std::mem::take(&mut self.autostart) {
            let _ = self.start(now, effects);
        }
        self.push_state(now, effects);
    }

    pub(super) fn start(&mut self, now: WallNs, effects: &mut Vec<Effect>) -> Result<(), Refused> {
        self.phase = self.phase.after(Transition::Start)?;
        self.goal = Goal::End;
        self.anchor = (now, self.granted);
        self.running_since = Some(now);
        self.pace_samples.clear();
        effects.push(Effect::Reached { phase: self.phase, frame: self.granted, why: None });
        self.extend(now, effects);
        Ok(())
    }

    pub(super) fn stop(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.phase == Phase::Running {
            self.goal = Goal::Stop(self.granted);
            self.settle(now, effects);
        } else {
            self.finish(now, effects);
        }
    }

    pub(super) fn finish(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.pause_clock(now);
        self.phase = Phase::Stopped;
        self.await_finals(now);
        let frame = self.frame();
        self.return_deadline = None;
        self.say(Order::Finish { run: self.run, frame }, effects);
        effects.push(Effect::Reached { phase: self.phase, frame, why: None });
        self.try_close(now, effects);
    }

    /// Results are awaited from now on: they are asked for again until they come, their member is lost, or it is heard of for as long as
    /// a frame may take and has not told them.
    fn await_finals(&mut self, now: WallNs) {
        let within = self.roster.iter().map(|name| self.hang_ns(name)).max();
        let within = within.unwrap_or(0).max(FINISH_WITHIN_NS);
        self.finish_since = now;
        self.finish_deadline = Some(now.saturating_add(within));
    }

    /// Of whom results are awaited, once the run is over.
    pub(super) fn owing(&self) -> Vec<String> {
        if self.finish_deadline.is_none() {
            return Vec::new();
        }
        let awaited =
            |n: &String| self.late.contains(n) || self.members.get(n).is_some_and(|m| m.alive);
        let owes = |n: &&String| awaited(n) && !self.finals.contains_key(*n);
        self.roster.iter().filter(owes).cloned().collect()
    }

    /// The run is closed without the results of these, and says so.
    fn close_without(&mut self, now: WallNs, owing: Vec<String>) {
        let after_s = now.saturating_sub(self.finish_since) as f64 * 1e-9;
        for name in owing.into_iter().filter(|name| !self.late.contains(name)) {
            let text = format!("{name} has not told its results within {after_s:.0} s");
            match self.config.optional.contains(&name) {
                true => self.degraded.push(text),
                false => self.faults.push(Fault { name, text, since: now, back: None }),
            }
        }
    }

    /// Whether every frame is made and results are still awaited of those that were lost after that.
    #[must_use]
    pub fn awaits_results(&self) -> bool {
        !self.late.is_empty()
    }

    /// The results of a member that is lost are awaited: all frames are made, and the policy says that it comes back.
    pub(super) fn await_results(&mut self, now: WallNs, name: &str) -> bool {
        let all_made = self.goal == Goal::End
            && !self.frozen_by_fault
            && self.frame() >= self.config.last_frame;
        let returns = matches!(self.on_loss(name), OnLoss::Freeze | OnLoss::TakeOver);
        let within = self.return_ns(now);
        if !all_made || !returns || within == Some(0) {
            return false;
        }
        self.late.insert(name.to_owned());
        self.finish_deadline = Some(within.map_or(WallNs::MAX, |ns| now.saturating_add(ns)));
        true
    }

    /// One that was thought to be lost at the end of the run has told its results all the same.
    pub(super) fn results_came(&mut self, now: WallNs, name: &str) {
        if self.late.remove(name) {
            let last = Some(self.config.last_frame);
            for fault in self.faults.iter_mut().filter(|f| f.name == name && f.back.is_none()) {
                fault.back = Some(last);
                let after_s = now.saturating_sub(fault.since) as f64 * 1e-9;
                fault.text += &format!("; its results came {after_s:.1} s later");
            }
            if self.late.is_empty() {
                self.await_finals(now);
            }
        }
    }

    /// One that was lost at the end of the run is back: it is told again that the run is over.
    pub(super) fn finish_again(&mut self, now: WallNs, name: &str, effects: &mut Vec<Effect>) {
        if self.late.remove(name) {
            if self.late.is_empty() {
                self.await_finals(now);
            }
            self.say(Order::Finish { run: self.run, frame: self.config.last_frame }, effects);
        }
    }

    pub(super) fn pause_clock(&mut self, now: WallNs) {
        if let Some(since) = self.running_since.take() {
            self.ran_ns += now.saturating_sub(since);
        }
    }

    pub(super) fn try_close(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let Some(deadline) = self.finish_deadline else { return };
        let owing = self.owing();
        // Who has not found a station that was started again is heard, or missed, before anything is closed without his results.
        let sought = |n: &String| self.members.get(n).is_some_and(|m| m.alive && !m.heard);
        let sought = self.roster.iter().any(|n| sought(n) && !self.finals.contains_key(n));
        if !owing.is_empty() && (now < deadline || sought) {
            return;
        }
        self.close_without(now, owing);
        self.finish_deadline = None;
        self.late.clear();
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
    pub(super) fn settle(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
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
                self.say(Order::Stand { run: self.run }, effects);
                effects.push(Effect::Reached { phase: self.phase, frame, why: None });
                let text = format!("frozen at frame {frame}");
                self.answer_pending(Transition::Freeze, &text, effects);
                self.push_state(now, effects);
            }
            _ => {}
        }
    }

    pub(super) fn freeze_by_fault(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        self.pause_clock(now);
        self.phase = Phase::Frozen;
        self.frozen_by_fault = true;
        self.say(Order::Stand { run: self.run }, effects);
        // Where all that is away was given to others by command, nothing is wrong.
        let given = self.lost_names().iter().all(|name| self.moving.contains_key(name));
        let text = self.open_faults().join("; ");
        let why = Some(if given { Why::Given(text) } else { Why::Fault(text) });
        effects.push(Effect::Reached { phase: self.phase, frame: self.frame(), why });
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
}
