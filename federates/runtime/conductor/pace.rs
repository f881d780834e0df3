//! How the horizon moves, and what is due by the clock.

use super::{Conductor, Effect, Goal};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{FetchOf, Frame, Order};

const GRANTS_KEPT: usize = 64;
const MUSTER_EVERY_NS: WallNs = 20_000_000;
/// A frame that is due for so long is not granted by the pace any more.
const LATE_NS: WallNs = 5_000_000;
/// Clocks are looked at as often.
const CLOCKS_EVERY_NS: WallNs = 50_000_000;
const STATE_EVERY_NS: WallNs = 200_000_000;

impl Conductor {
    /// Moves the horizon as far as the pace allows.
    pub(super) fn extend(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let stands = self.views.is_open() || self.views.waits();
        let (last, steps) = match self.goal {
            Goal::End => (self.config.last_frame, false),
            // Steps are made as fast as possible, and like all else as far ahead as members remember.
            Goal::Freeze(at) => (at, true),
            Goal::Stop(_) => return,
        };
        if self.phase != Phase::Running || stands {
            return;
        }
        let upto = if self.rate.is_infinite() || steps {
            let upto = (self.frame() + self.config.window).min(last);
            // Move in half windows: fewer messages, and nobody waits.
            let worth = upto == last || upto >= self.granted + self.config.window / 2;
            if worth { upto } else { self.granted }
        } else {
            let step = self.config.step_ns as f64 / self.rate;
            let due = self.anchor.1 + (now.saturating_sub(self.anchor.0) as f64 / step) as Frame;
            let horizon = self.horizon();
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

    pub(super) fn grant(&mut self, now: WallNs, upto: Frame, effects: &mut Vec<Effect>) {
        self.granted = upto;
        if self.grants.len() == GRANTS_KEPT {
            self.grants.pop_front();
        }
        self.grants.push_back((now, upto));
        self.say(Order::Grant { run: self.run, upto }, effects);
    }

    /// Up to where real time may go: a producer is a few frames behind at most, so that it never catches up in a burst; a
    /// consumer may be at a scan that takes most of its second meanwhile.
    fn horizon(&self) -> Frame {
        let slack = self.slack();
        let scan = slack.max(self.config.window / 2);
        let reach = |name: &String| {
            let member = self.members.get(name).filter(|_| !self.views.is_absent(name))?;
            let executed = self.views.cut(name).unwrap_or(member.executed).unwrap_or(0);
            Some(executed + if member.consumes { scan } else { slack })
        };
        let reach = self.roster.iter().filter_map(reach).min().unwrap_or(self.granted + slack);
        reach.min(self.config.last_frame)
    }

    /// Frames that members may be behind before real time slips: a quarter of a second of wall time, at least 5.
    pub(super) fn slack(&self) -> Frame {
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
            if let Some((fetch, _)) = member.stream.due(now, false) {
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
        if self.mustering && !self.members.is_empty() {
            next = next.min(self.last_muster + MUSTER_EVERY_NS);
        }
        next.max(now + 100_000)
    }
}
