//! What operators ask of a run, and its answers.

use super::{Conductor, Effect, Goal, Token};
use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::{Phase, Refused, Transition, possible, steps};
use crate::runtime::messages::Command;

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
        }
        self.push_state(now, effects);
    }

    /// Why time cannot go on, and what is possible.
    fn fault_blocks(&self) -> Option<String> {
        let awaited = self.lost_names();
        (!awaited.is_empty()).then(|| {
            format!(
                "time stands: {}; possible now: start {} again, stop, restart",
                self.open_faults().join("; "),
                awaited.join(" and "),
            )
        })
    }
}
