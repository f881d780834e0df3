//! What operators ask of a run, and its answers.

use super::{Conductor, Effect, Fault, Goal, Token};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::{Phase, Refused, Transition, possible, steps};
use crate::runtime::messages::{Command, Order};
use scenarios::losses::OnLoss;

impl Conductor {
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
                    // Steps that are not granted yet are not made.
                    if !matches!(self.goal, Goal::Stop(_)) {
                        self.goal = Goal::Freeze(self.granted);
                    }
                    self.settle(now, effects);
                }
                Err(e) => match self.fault_blocks().filter(|_| self.phase == Phase::Frozen) {
                    Some(why) => effects.push(Effect::Answer(token, self.answer(false, &why))),
                    None => effects.push(refused(self, e)),
                },
            },
            Command::Step { n } => {
                let can = steps(self.phase);
                if let Some(why) = self.fault_blocks() {
                    effects.push(Effect::Answer(token, self.answer(false, &why)));
                } else if !can || n == 0 {
                    let text = if n == 0 {
                        "a step is at least one frame".to_owned()
                    } else {
                        self.impossible("step")
                    };
                    effects.push(Effect::Answer(token, self.answer(false, &text)));
                } else {
                    self.phase = Phase::Running;
                    self.running_since = Some(now);
                    let reached =
                        Effect::Reached { phase: self.phase, frame: self.granted, why: None };
                    effects.push(reached);
                    let target = self.granted.saturating_add(n).min(self.config.last_frame);
                    self.goal = Goal::Freeze(target);
                    self.pending.push((token, Transition::Freeze));
                    self.extend(now, effects);
                    self.settle(now, effects);
                }
            }
            Command::Stop if self.awaits_results() => {
                self.pending.push((token, Transition::Stop));
                self.finish_deadline = Some(now);
                self.try_close(now, effects);
            }
            Command::Stop => match self.phase.after(Transition::Stop) {
                Ok(_) => {
                    self.pending.push((token, Transition::Stop));
                    self.stop(now, effects);
                }
                Err(e) => effects.push(refused(self, e)),
            },
            Command::Restart => match self.phase.after(Transition::Restart) {
                Ok(_) => {
                    self.pending.push((token, Transition::Restart));
                    if self.phase == Phase::Frozen {
                        self.restart_after = true;
                        self.stop(now, effects);
                    } else if self.finish_deadline.is_some() {
                        // The run is closed first, with the results of all who are there.
                        self.restart_after = true;
                        if self.awaits_results() {
                            self.finish_deadline = Some(now);
                            self.try_close(now, effects);
                        }
                    } else {
                        self.begin_again(now, effects);
                    }
                }
                Err(e) => effects.push(refused(self, e)),
            },
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
            Command::Move { name, to } => {
                let moved = self.give(now, &name, &to, effects);
                let (ok, text) = match moved {
                    Ok(text) => (true, text),
                    Err(text) => (false, text),
                };
                effects.push(Effect::Answer(token, self.answer(ok, &text)));
            }
            Command::Without { name } => {
                let (ok, text) = match self.leave_out(now, &name, effects) {
                    Ok(text) => (true, text),
                    Err(text) => (false, text),
                };
                effects.push(Effect::Answer(token, self.answer(ok, &text)));
            }
        }
        self.push_state(now, effects);
    }

    /// That a command is not possible now, and which are.
    fn impossible(&self, word: &str) -> String {
        let (phase, now) = (self.phase, possible(self.phase));
        format!("'{word}' is not possible while {phase}; possible now: {now}")
    }

    /// Goes on without a lost member that time stands for, as `on_loss = "degrade"` would have from the begin.
    ///
    /// # Errors
    /// Why not, for a person.
    fn leave_out(
        &mut self,
        now: WallNs,
        name: &str,
        effects: &mut Vec<Effect>,
    ) -> Result<String, String> {
        if !matches!(self.phase, Phase::Running | Phase::Frozen) {
            return Err(self.impossible("without"));
        }
        let lost = self.lost_names();
        if !lost.iter().any(|lost| lost == name) {
            return Err(match lost.is_empty() {
                true => "time stands for nobody: nobody is lost".to_owned(),
                false => format!("'{name}' is not lost; lost: {}", lost.join(", ")),
            });
        }
        let (Some(cut), false) = (self.views.cut(name), self.views.is_open()) else {
            return Err("a loss is being settled: ask again".to_owned());
        };
        let Some(inc) = self.views.removed().get(name).map(|removed| removed.inc) else {
            return Err(format!("'{name}' is not lost"));
        };
        let of = |f: &&mut Fault| f.name == name && f.back.is_none();
        let mut reasons: Vec<String> = Vec::new();
        for fault in self.faults.iter_mut().filter(of) {
            reasons.push(std::mem::take(&mut fault.text));
        }
        self.faults.retain(|f| f.name != name || f.back.is_some());
        let reason = format!("{}; goes on without it by command", reasons.join("; "));
        self.absent.insert(name.to_owned(), reason);
        self.hosted.remove(name);
        self.moving.remove(name);
        if self.lost_names().is_empty() {
            self.return_deadline = None;
        }
        // One that was on its way back is not taken any more.
        if let Some(member) = self.members.get_mut(name).filter(|m| m.returning) {
            member.returning = false;
            let inc = member.inc;
            let reason =
                format!("the run goes on without '{name}': it takes part again after a restart");
            self.say(Order::Dismiss { name: name.to_owned(), inc, reason }, effects);
        }
        self.open_view(now, name, inc, true, effects);
        let since = cut.map_or(0, |cut| cut + 1);
        Ok(format!("goes on without {name} from frame {since}"))
    }

    /// Producers whose places other processes can take.
    #[must_use]
    pub fn places(&self) -> Vec<String> {
        let hosts = |p: &&String| self.members.get(*p).is_some_and(|m| m.hello.kind.hosts());
        self.config.producers.iter().filter(hosts).cloned().collect()
    }

    /// Whether the place of a name can be given to another process now, and its process take another's.
    pub(super) fn is_movable(&self, name: &str) -> bool {
        let place = self.config.producers.iter().any(|p| p == name);
        place
            && self.members.get(name).is_some_and(|m| m.alive && m.hello.kind.hosts())
            && self.on_loss(name) == OnLoss::TakeOver
            && matches!(self.phase, Phase::Running | Phase::Frozen)
    }

    /// Gives the place of a producer to the process of another one: as one that is lost, at a frame boundary and to the same bits, but
    /// by command and to somebody chosen.
    ///
    /// # Errors
    /// Why not, for a person.
    fn give(
        &mut self,
        now: WallNs,
        name: &str,
        to: &str,
        effects: &mut Vec<Effect>,
    ) -> Result<String, String> {
        if !matches!(self.phase, Phase::Running | Phase::Frozen) {
            return Err(self.impossible("move"));
        }
        if let Some(why) = self.fault_blocks() {
            return Err(why);
        }
        for asked in [name, to] {
            let places = self.places();
            if !places.iter().any(|place| place == asked) {
                let places = places.join(", ");
                return Err(format!("'{asked}' is not a place that can be moved: {places} can"));
            }
        }
        let (Some(from), Some(by)) = (self.members.get(name), self.members.get(to)) else {
            return Err(format!("{name} or {to} has not joined"));
        };
        if (&from.hello.host, from.hello.pid) == (&by.hello.host, by.hello.pid) {
            return Err(format!("{name} is in the process of {to} already"));
        }
        if self.on_loss(name) != OnLoss::TakeOver {
            return Err(format!(
                "{name} cannot be moved: its place is taken by another process only under --on-loss takeover (or {name}=takeover)"
            ));
        }
        if self.views.is_open() || !from.alive || !by.alive {
            return Err("a loss is being settled: ask again".to_owned());
        }
        let (inc, at) = (from.inc, self.frame());
        self.hosted.remove(name);
        self.moving.insert(name.to_owned(), to.to_owned());
        self.say(Order::Yield { name: name.to_owned(), inc, to: to.to_owned() }, effects);
        let text = format!("{name} goes to the process of {to}, from frame {at} or soon after");
        self.lose_for(now, name.to_owned(), text.clone(), effects);
        Ok(text)
    }

    /// Why time cannot go on, and what is possible.
    fn fault_blocks(&self) -> Option<String> {
        let awaited = self.lost_names();
        (!awaited.is_empty()).then(|| {
            format!(
                "time stands: {}; possible now: start {} again, go on without {}, stop, restart",
                self.open_faults().join("; "),
                awaited.join(" and "),
                match &awaited[..] {
                    [one] => one,
                    _ => "them, one by one",
                },
            )
        })
    }
}
