//! Everything that a conductor is told, as values: told again in the same order, they make the same conductor.

use super::{Conductor, ConductorConfig, Effect, Token};
use crate::runtime::clock::WallNs;
use crate::runtime::messages::{Beat, Command, Fetched, Hello, LogRecord, Numbered, Report};
use serde::{Deserialize, Serialize};

/// What a conductor is told. The passing of time is told by [`Conductor::tick`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Input {
    /// A federate asks to join.
    Hello(Hello, Token),
    /// A beat of the member of that name.
    Beat(String, Beat),
    /// A report of the member of that name.
    Report(String, Numbered<Report>),
    /// Reports that were lost on their way.
    Fetched(Fetched<Report>),
    /// An operator's command.
    Command(Command, Token),
    /// The connection of a member is gone, or back: name, incarnation, whether it is there.
    Alive(String, u64, bool),
    /// The spectators that were to be waited for will not come.
    NoSpectators,
    /// The process that held this conductor died, and this one made it again from its journal.
    Resumed,
}

/// Members have so long to find a station that was started again: their connections are tried anew every few seconds.
const FOUND_AGAIN_NS: WallNs = 15_000_000_000;

/// A step of a conductor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Step {
    /// It was told something at that time.
    Told(WallNs, Input),
    /// Time passed, to then.
    Tick(WallNs),
}

/// A conductor made again from the steps of the one before.
pub struct Again {
    /// The conductor, as it was after the last step.
    pub conductor: Conductor,
    /// Its time then, ns.
    pub now: WallNs,
    /// What it decided at last: nobody knows whether that was carried out, and it may be twice.
    pub effects: Vec<Effect>,
}

/// A conductor that is being made from the steps of another one.
pub struct Replay {
    conductor: Conductor,
    now: WallNs,
    effects: Vec<Effect>,
    carried_out: bool,
}

impl Replay {
    /// At the begin.
    #[must_use]
    pub fn new(config: ConductorConfig) -> Self {
        let conductor = Conductor::new(config);
        Self { conductor, now: 0, effects: Vec::new(), carried_out: false }
    }

    /// The next step; `record` is told what it decided to keep in the log of the run.
    pub fn step(&mut self, step: Step, mut record: impl FnMut(u32, &LogRecord)) {
        if std::mem::take(&mut self.carried_out) {
            self.effects.clear();
        }
        let begin = self.effects.len();
        match step {
            Step::Told(at, input) => {
                self.now = at;
                self.conductor.take(at, input, &mut self.effects);
            }
            Step::Tick(at) => {
                self.now = at;
                self.conductor.tick(at, &mut self.effects);
                self.carried_out = true;
            }
        }
        for effect in &self.effects[begin..] {
            if let Effect::Record(run, what) = effect {
                record(*run, what);
            }
        }
    }

    /// As it is now.
    #[must_use]
    pub fn conductor(&self) -> &Conductor {
        &self.conductor
    }

    /// It is the conductor from now on.
    #[must_use]
    pub fn done(self) -> Again {
        let Self { conductor, now, mut effects, .. } = self;
        effects.retain(|effect| !matches!(effect, Effect::Record(..)));
        Again { conductor, now, effects }
    }
}

impl Conductor {
    /// The conductor that has gone through `steps` since its begin; `record` is told what it decided to keep in the log of the run.
    pub fn again(
        config: ConductorConfig,
        steps: impl IntoIterator<Item = Step>,
        mut record: impl FnMut(u32, &LogRecord),
    ) -> Again {
        let mut replay = Replay::new(config);
        steps.into_iter().for_each(|step| replay.step(step, &mut record));
        replay.done()
    }

    /// Takes what it is told.
    pub fn take(&mut self, now: WallNs, input: Input, effects: &mut Vec<Effect>) {
        match input {
            Input::Hello(hello, token) => self.hello(now, hello, token, effects),
            Input::Beat(from, beat) => self.beat(now, &from, &beat),
            Input::Report(from, report) => self.report(now, &from, report, effects),
            Input::Fetched(fetched) => self.fetched(now, fetched, effects),
            Input::Command(command, token) => self.command(now, command, token, effects),
            Input::Alive(name, inc, alive) => self.alive(now, &name, inc, alive, effects),
            Input::NoSpectators => self.await_no_spectators(now, effects),
            Input::Resumed => self.resumed(now, effects),
        }
    }

    /// Nothing was heard while there was no station: that says nothing about members, whose connections are gone too.
    fn resumed(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        for member in self.members.values_mut().filter(|m| m.alive || m.returning) {
            member.heard_at = now + FOUND_AGAIN_NS;
            member.heard = false;
            member.due_since = None;
            member.token_gone = false;
            member.ran_out = false;
        }
        self.sought_until = now + 2 * FOUND_AGAIN_NS;
        // What was awaited within a time cannot come before its sender has found this station; who does not is missed first.
        for deadline in [&mut self.finish_deadline, &mut self.return_deadline].into_iter().flatten()
        {
            *deadline = (*deadline).max(now) + 2 * FOUND_AGAIN_NS;
        }
        // Who asked the process before gets no answer any more.
        self.pending.clear();
        self.notes.push(format!(
            "the administration station was started again at frame {}",
            self.frame()
        ));
        self.push_state(now, effects);
    }
}
