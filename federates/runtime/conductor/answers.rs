//! How the run stands: answers to operators, state for spectators.

use super::losses::{SILENT_NS, SLOW_NS};
use super::{Conductor, Effect, MemberEntry};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::{Phase, Transition};
use crate::runtime::messages::{Answer, Health, MemberState, RunState};

impl Conductor {
    pub(super) fn fail_pending(&mut self, effects: &mut Vec<Effect>) {
        let text = self.open_faults().join("; ");
        for (token, _) in std::mem::take(&mut self.pending) {
            effects.push(Effect::Answer(token, self.answer(false, &text)));
        }
    }

    pub(super) fn answer_pending(
        &mut self,
        what: Transition,
        text: &str,
        effects: &mut Vec<Effect>,
    ) {
        let pending = std::mem::take(&mut self.pending);
        for (token, transition) in pending {
            if transition == what {
                effects.push(Effect::Answer(token, self.answer(true, text)));
            } else {
                self.pending.push((token, transition));
            }
        }
    }

    pub(super) fn answer(&self, ok: bool, text: &str) -> Answer {
        Answer { ok, text: text.to_owned(), state: self.state() }
    }

    /// How the run stands, for people.
    #[must_use]
    pub fn standing(&self) -> String {
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

    pub(super) fn push_state(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
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

    fn heard_ago(&self, member: &MemberEntry) -> WallNs {
        self.last_tick.saturating_sub(member.heard_at)
    }

    fn health(&self, member: &MemberEntry) -> Health {
        let slow = |since: WallNs| self.last_tick.saturating_sub(since) > SLOW_NS;
        if member.returning {
            Health::Returning
        } else if !member.alive {
            Health::Lost
        } else if member.hello.kind.beats() && self.heard_ago(member) > SILENT_NS {
            Health::Silent
        } else if member.due_since.is_some_and(slow) {
            Health::Late
        } else {
            Health::Alive
        }
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
                    health: self.health(m),
                    heard_ms: m.hello.kind.beats().then(|| self.heard_ago(m) / 1_000_000),
                    behind: match self.roster.contains(name) {
                        true => self.granted.saturating_sub(m.executed.unwrap_or(0)),
                        false => 0,
                    },
                    movable: self.is_movable(name),
                })
                .collect(),
        }
    }
}
