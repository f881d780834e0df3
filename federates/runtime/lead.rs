//! The conductor of a station, with its journal: what it is told is kept before anybody hears what it decided, and held by the standby,
//! where there is one. Pure but for the disk of the journal: times and messages in, what is to be done out.

use super::clock::WallNs;
use super::conductor::{Again, Conductor, ConductorConfig, Effect, Input, Replay, Step};
use super::journal::{Journal, Past, run_of};
use super::messages::{Beat, FetchOf, Fetched, Order};
use super::run_log::RunLog;
use super::succession::{Candidate, Commit, Led, Question, Steps, StepsAsk, Voted};
use std::collections::VecDeque;

/// Octets of one answer to a standby.
const CHUNK: u64 = 512 << 10;

/// How long a standby's question waits for more, ns.
const STEPS_WAIT_NS: WallNs = 100_000_000;

/// What is to be done after a turn.
#[derive(Debug, Default)]
pub struct Turn {
    /// Answers to the standby's questions, by their numbers.
    pub told: Vec<(u64, Steps)>,
    /// What the conductor decided and may be heard.
    pub effects: Vec<Effect>,
}

/// A conductor that can be made again.
pub struct Lead {
    conductor: Conductor,
    journal: Option<Journal>,
    /// Of which run the journal is.
    of: String,
    /// Its steps since the last tick, for the journal.
    steps: Vec<Step>,
    effects: Vec<Effect>,
    /// It was told something since the last tick, and when that was.
    told: bool,
    ticked: WallNs,
    /// Its time at the begin of this process.
    since: WallNs,
    /// Another process of this station led the run before.
    again: bool,
    /// What may be acted upon.
    commit: Commit,
    /// What was decided and may not be heard yet: the octets of the journal that led to it, and what members may know then.
    held: VecDeque<(u64, Vec<Effect>, Beat)>,
    /// What members may know of the conductor, where not all that it knows.
    said: Option<Beat>,
    /// A question of the standby that waits for more of the journal: since when, its number.
    waiting: Option<(WallNs, u64, StepsAsk)>,
}

impl Lead {
    /// The conductor of `config`; made again from the journal that was opened, where a station left one, with the log of its run. `who`
    /// the station is to the voters, whichever process of it, and what this one drew; its own clock, ns.
    #[must_use]
    pub fn open(
        opened: Option<(Journal, Option<Past>)>,
        config: ConductorConfig,
        (who, by): (u64, u128),
        clock: WallNs,
        log: &mut RunLog,
    ) -> Self {
        let commit = |now, fed, led| Commit::new(now, Candidate::new(fed, who, by), led);
        let (mut journal, mut past) = match opened {
            Some((journal, Some(past))) => (journal, past),
            new => {
                let commit = commit(0, config.fed, Led::default());
                return Self::of(config, new.map(|(journal, _)| journal), commit);
            }
        };
        let config = ConductorConfig { fed: past.fed, ..config };
        let mut replay = Replay::new(config.clone());
        for step in journal.steps(&mut past) {
            replay.step(step, |run, record| log.append(run, record));
        }
        let again = replay.done();
        let commit = commit(again.now, config.fed, journal.led());
        Self::of(config, Some(journal), commit).goes_on(again, clock)
    }

    /// The conductor of a station that is no more, of which this one was the standby; its own clock, ns.
    ///
    /// # Errors
    /// If that cannot be written to the journal.
    pub fn succeed(
        config: ConductorConfig,
        replay: Replay,
        mut journal: Journal,
        (candidate, led): (Candidate, Led),
        clock: WallNs,
    ) -> std::io::Result<Self> {
        journal.append_led(led)?;
        let again = replay.done();
        let commit = Commit::new(again.now, candidate, led);
        Ok(Self::of(config, Some(journal), commit).goes_on(again, clock))
    }

    fn of(config: ConductorConfig, journal: Option<Journal>, commit: Commit) -> Self {
        Self {
            of: run_of(&config),
            conductor: Conductor::new(config),
            journal,
            steps: Vec::new(),
            effects: Vec::new(),
            told: true,
            ticked: 0,
            since: 0,
            again: false,
            commit,
            held: VecDeque::new(),
            said: None,
            waiting: None,
        }
    }

    fn goes_on(mut self, again: Again, clock: WallNs) -> Self {
        let Again { conductor, now, effects } = again;
        // For the conductor no time passed between the two processes.
        self.since = now.saturating_sub(clock);
        (self.conductor, self.effects, self.again) = (conductor, effects, true);
        if self.commit.led().standby {
            // What was heard of its last words is not known yet.
            self.said = Some(Beat { fed: self.conductor.fed(), ..Beat::default() });
        }
        self.tell(self.now(clock), Input::Resumed);
        self
    }

    /// The conductor's time by the clock of this process, ns: it goes on where the process before was.
    #[must_use]
    pub fn now(&self, clock: WallNs) -> WallNs {
        self.since + clock
    }

    /// Whether another process of this station led the run before.
    #[must_use]
    pub fn again(&self) -> bool {
        self.again
    }

    /// How the run stands.
    #[must_use]
    pub fn conductor(&self) -> &Conductor {
        &self.conductor
    }

    /// Who may lead, as far as is known here.
    #[must_use]
    pub fn led(&self) -> Led {
        self.commit.led()
    }

    /// What members may know of the conductor.
    #[must_use]
    pub fn beat(&self) -> Beat {
        self.said.clone().unwrap_or_else(|| self.conductor.own_beat())
    }

    /// Answers a member that lacks orders: those that may be heard.
    #[must_use]
    pub fn fetch_orders(&self, ask: &FetchOf) -> Fetched<Order> {
        let mut fetched = self.conductor.fetch_orders(ask);
        if let Some(said) = &self.said {
            fetched.items.retain(|order| order.seq <= said.last_seq);
            fetched.gone_before = fetched.gone_before.min(said.last_seq + 1);
        }
        fetched
    }

    /// Tells the conductor.
    pub fn tell(&mut self, now: WallNs, input: Input) {
        if self.journal.is_some() {
            self.steps.push(Step::Told(now, input.clone()));
        }
        self.told = true;
        self.conductor.take(now, input, &mut self.effects);
    }

    /// Time passed: what is to be done, once it is in the journal what led to it, and with the standby, where there is one. Where nothing
    /// was told and nothing is due nothing is written: a standby's question is no event of the run.
    pub fn tick(&mut self, now: WallNs) -> Vec<Effect> {
        if !self.told && now < self.conductor.deadline(self.ticked) {
            return self.may_be_heard();
        }
        (self.told, self.ticked) = (false, now);
        self.conductor.tick(now, &mut self.effects);
        self.steps.push(Step::Tick(now));
        if let Some(journal) = &mut self.journal
            && let Err(e) = journal.append(&self.steps)
        {
            self.cannot_write(now, &e);
        }
        self.steps.clear();
        let effects = std::mem::take(&mut self.effects);
        if self.said.is_none() {
            return effects;
        }
        let octets = self.journal.as_ref().map_or(u64::MAX, Journal::end);
        self.held.push_back((octets, effects, self.conductor.own_beat()));
        self.may_be_heard()
    }

    fn may_be_heard(&mut self) -> Vec<Effect> {
        let mut effects = Vec::new();
        while self.held.front().is_some_and(|(octets, ..)| self.commit.may_say(*octets))
            && let Some((_, these, said)) = self.held.pop_front()
        {
            effects.extend(these);
            self.said = Some(said);
        }
        if !self.commit.led().standby && self.held.is_empty() {
            self.said = None;
        }
        effects
    }

    fn cannot_write(&mut self, now: WallNs, e: &std::io::Error) {
        tracing::warn!(
            "the journal cannot be written: {e}; the run goes on without: if this process dies, the run is lost"
        );
        // What it holds is behind the run from now on: nobody may go on from there.
        self.over();
        self.commit.dismiss(now);
    }

    /// A standby asks for the journal, by a number: a turn answers it, once there is more. The question before is not answered any more.
    pub fn asked(&mut self, now: WallNs, number: u64, ask: StepsAsk) {
        self.waiting = Some((now, number, ask));
    }

    /// After all was told that came: what the standby holds may be acted upon at once, and what is written then goes to it at once.
    pub fn turn(&mut self, now: WallNs) -> Turn {
        let mut turn = Turn::default();
        if let Some((since, number, ask)) = self.waiting.take() {
            match self.steps(now, &ask) {
                None if now < since + STEPS_WAIT_NS => self.waiting = Some((since, number, ask)),
                told => turn.told.push((number, told.unwrap_or(Steps::Octets(Vec::new())))),
            }
        }
        turn.effects = self.tick(now);
        if let Some((since, number, ask)) = self.waiting.take() {
            match self.steps(now, &ask) {
                Some(steps) => turn.told.push((number, steps)),
                None => self.waiting = Some((since, number, ask)),
            }
        }
        turn
    }

    /// A standby asks for the journal; none while there is no more.
    pub fn steps(&mut self, now: WallNs, ask: &StepsAsk) -> Option<Steps> {
        let Some(journal) = &mut self.journal else {
            return Some(Steps::Refused(
                "the administration station keeps no journal, which a standby reads: start it with --journal FILE".into(),
            ));
        };
        if ask.run != self.of {
            return Some(Steps::Refused(
                "the administration station leads another run: give the standby the same scene, seed, flags and build".into(),
            ));
        }
        if self.commit.has_another(now, ask.who) {
            return Some(Steps::Later("it has another standby".into()));
        }
        if self.commit.held_more(ask.from, journal.led_at()) {
            return Some(Steps::Later("the voters are asked whether another standby leads".into()));
        }
        match journal.sum(ask.from) {
            Ok(sum) if sum == Some(ask.sum) => {}
            Ok(_) => return Some(Steps::Anew),
            Err(e) => return Some(Steps::Later(format!("its journal cannot be read: {e}"))),
        }
        self.commit.holds(now, ask.who, ask.from);
        // Not before there are members: their voices decide when one of the two is lost.
        let there = self.conductor.awaited().is_empty();
        let near = journal.end() - ask.from < CHUNK / 8;
        if near && there && !self.commit.led().standby {
            self.said = Some(self.conductor.own_beat());
            let led = self.commit.admit();
            if let Err(e) = journal.append_led(led) {
                self.cannot_write(now, &e);
                return None;
            }
            tracing::info!("a standby holds the journal and leads on if this station is lost");
        }
        match journal.octets(ask.from, CHUNK) {
            Ok(octets) if octets.is_empty() => None,
            Ok(octets) => Some(Steps::Octets(octets)),
            Err(e) => Some(Steps::Later(format!("its journal cannot be read: {e}"))),
        }
    }

    /// The questions that are due to voters, where the standby is silent.
    pub fn questions(&mut self, now: WallNs) -> Vec<Question> {
        let questions = self.commit.tick(now, self.conductor.voters());
        if let Some((here, all, silent)) = self.commit.stands() {
            tracing::warn!(
                "nothing is heard of the standby, without which nothing is said: {here} of {all} voters here, asking {}",
                silent.join(", ")
            );
        }
        questions
    }

    /// How many voters are here, of how many, where it asks them whether it goes on without its standby.
    #[must_use]
    pub fn standing(&self) -> Option<(usize, usize)> {
        self.commit.standing()
    }

    /// How it stands with its standby, for people: who may lead, what it has decided and not said, the voices that it has.
    #[must_use]
    pub fn says(&self) -> String {
        let Led { epoch, standby } = self.commit.led();
        let end = self.journal.as_ref().map_or(0, Journal::end);
        let said = self.said.as_ref().map(|said| said.last_seq);
        format!(
            "leads epoch {epoch}, standby in: {standby}, {} turns not said, said to {said:?} of {}, journal {end}, {:?}",
            self.held.len(),
            self.conductor.own_beat().last_seq,
            self.commit,
        )
    }

    /// When the next questions are due.
    #[must_use]
    pub fn questions_due(&self) -> WallNs {
        self.commit.deadline()
    }

    /// A voter answered.
    pub fn voted(&mut self, now: WallNs, name: &str, voted: &Voted) {
        let inc = self.conductor.inc_of(name);
        let Some(led) = self.commit.voted(name, voted, inc) else { return };
        tracing::warn!("the run goes on without the standby, of which nothing is heard");
        if let Some(journal) = &mut self.journal
            && let Err(e) = journal.append_led(led)
        {
            self.cannot_write(now, &e);
        }
    }

    /// Whether a station of `epoch` leads in place of this one.
    #[must_use]
    pub fn deposed_by(&self, epoch: u32) -> bool {
        self.commit.deposed_by(epoch)
    }

    /// Nobody is to go on from here.
    pub fn over(&mut self) {
        if let Some(journal) = self.journal.take() {
            journal.remove();
        }
    }
}
