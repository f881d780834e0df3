//! A standby: the journal of a station, copied and followed, until that station is no more. Pure but for the disk of the journal.

use super::clock::WallNs;
use super::conductor::{ConductorConfig, Replay, Step};
use super::digest::pdu_hash;
use super::journal::{Journal, JournalError, Line, Past, Records, run_of};
use super::lead::Lead;
use super::messages::{Numbered, Order};
use super::run_log::RunLog;
use super::succession::{Candidate, Led, Question, Standby, Steps, StepsAsk, Voted};

/// How soon it asks again where there was no answer, or nothing to read, ns.
const AGAIN_NS: WallNs = 100_000_000;

/// What becomes of a standby after it heard something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Becomes {
    /// It goes on following.
    Standby,
    /// The station in place of the one that is lost.
    Leader(Led),
    /// Nothing: the run is over.
    Over,
    /// Nothing: it is not wanted, and why.
    Refused(String),
}

/// A standby, with the journal of a station as far as it was read.
pub struct Follower {
    config: ConductorConfig,
    journal: Journal,
    who: u64,
    by: u128,
    standby: Standby,
    /// The federation, once it is known.
    fed: Option<u128>,
    replay: Replay,
    log: RunLog,
    records: Records,
    /// Steps since the last tick.
    open: Vec<Step>,
    /// Octets up to the end of the last record read, and of the last tick.
    read: u64,
    whole: u64,
    led: Led,
    /// Questions so far, whether the last one waits for its answer, and when the next one is due.
    asked: u64,
    awaits: bool,
    ask_at: WallNs,
    silent_since: WallNs,
    said: String,
}

impl Follower {
    /// One that goes on from what its journal holds of this run. `who` it is to the voters, whichever process of it, and what this one
    /// drew, which no other process may have, nor the numbers after it.
    #[must_use]
    pub fn open(
        (journal, past): (Journal, Option<Past>),
        config: &ConductorConfig,
        (who, by): (u64, u128),
        now: WallNs,
    ) -> Self {
        let candidate = Candidate::new(config.fed, who, by);
        let mut follower = Self {
            config: config.clone(),
            journal,
            who,
            by,
            standby: Standby::new(now, candidate, Led::default()),
            fed: None,
            replay: Replay::new(config.clone()),
            log: RunLog::default(),
            records: Records::default(),
            open: Vec::new(),
            read: 0,
            whole: 0,
            led: Led::default(),
            asked: 0,
            awaits: false,
            ask_at: 0,
            silent_since: now,
            said: String::new(),
        };
        if let Some(mut past) = past {
            follower.begin(now, past.fed);
            for step in follower.journal.steps(&mut past) {
                follower.replay.step(step, |run, record| follower.log.append(run, record));
            }
            follower.led = follower.journal.led();
            (follower.read, follower.whole) = (follower.journal.end(), follower.journal.end());
            follower.standby.led(follower.led);
        }
        follower
    }

    /// What it holds is of another journal. Its questions are another process's from now on: they are counted anew.
    fn anew(&mut self, now: WallNs) {
        self.journal.cut(0, Led::default());
        self.by = self.by.wrapping_add(1);
        let candidate = Candidate::new(self.config.fed, self.who, self.by);
        self.standby = Standby::new(now, candidate, Led::default());
        (self.fed, self.replay) = (None, Replay::new(self.config.clone()));
        (self.log, self.records) = (RunLog::default(), Records::default());
        self.open.clear();
        (self.read, self.whole, self.led) = (0, 0, Led::default());
    }

    /// The journal is of that federation.
    fn begin(&mut self, now: WallNs, fed: u128) {
        self.fed = Some(fed);
        self.config.fed = fed;
        self.replay = Replay::new(self.config.clone());
        let candidate = Candidate::new(fed, self.who, self.by);
        self.standby = Standby::new(now, candidate, Led::default());
    }

    /// The question for more of the journal that is due, with its number.
    ///
    /// # Errors
    /// If the journal cannot be read.
    pub fn ask(&mut self, now: WallNs) -> Result<Option<(u64, StepsAsk)>, JournalError> {
        if !self.standby.follows() || now < self.ask_at {
            return Ok(None);
        }
        self.asked += 1;
        self.awaits = true;
        self.ask_at = WallNs::MAX;
        let from = self.journal.end();
        let sum = self.journal.sum(from).map_err(|error| self.failed(error))?;
        let sum = sum.unwrap_or_else(|| pdu_hash(&[]));
        Ok(Some((self.asked, StepsAsk { run: run_of(&self.config), who: self.who, from, sum })))
    }

    fn failed(&self, error: std::io::Error) -> JournalError {
        JournalError::File { path: self.journal.path().display().to_string(), error }
    }

    /// The station answered the question of that number; none: no answer will come.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub fn told(
        &mut self,
        now: WallNs,
        number: u64,
        steps: Option<Steps>,
    ) -> Result<Becomes, JournalError> {
        // The octets of an answer that comes twice would be in the journal twice.
        if number != self.asked || !std::mem::take(&mut self.awaits) {
            return Ok(Becomes::Standby);
        }
        let Some(steps) = steps else {
            self.ask_at = now + AGAIN_NS;
            return Ok(Becomes::Standby);
        };
        self.heard(now);
        self.ask_at = now;
        match steps {
            Steps::Octets(octets) => self.take(now, &octets)?,
            Steps::Anew => self.anew(now),
            Steps::Over => return Ok(Becomes::Over),
            Steps::Refused(why) => return Ok(Becomes::Refused(why)),
            Steps::Later(why) => {
                if self.said != why {
                    tracing::warn!("waits: {why}");
                    self.said = why;
                }
                self.ask_at = now + 5 * AGAIN_NS;
            }
        }
        Ok(Becomes::Standby)
    }

    /// A station beats.
    pub fn heard(&mut self, now: WallNs) {
        self.silent_since = now;
        self.standby.heard(now);
    }

    /// The connection of the station is there, or gone.
    pub fn connected(&mut self, connected: bool) {
        self.standby.connected(connected);
    }

    /// An order to the members.
    #[must_use]
    pub fn ordered(&self, order: &Numbered<Order>) -> Becomes {
        match order.body {
            Order::Exit { .. } if Some(order.fed) == self.fed => Becomes::Over,
            _ => Becomes::Standby,
        }
    }

    fn take(&mut self, now: WallNs, octets: &[u8]) -> Result<(), JournalError> {
        self.journal.copy(octets).map_err(|error| self.failed(error))?;
        for (line, length) in self.records.take(octets) {
            self.read += length;
            match line {
                Line::Head(_, fed) => self.begin(now, fed),
                Line::Step(step) => {
                    let tick = matches!(*step, Step::Tick(_));
                    self.open.push(step.into_owned());
                    if tick {
                        for step in self.open.drain(..) {
                            self.replay.step(step, |run, record| self.log.append(run, record));
                        }
                    } else {
                        continue;
                    }
                }
                Line::Led(led) => {
                    if led.standby && !self.standby.is_in() {
                        tracing::info!(
                            "holds the journal of the station and leads on if that is lost"
                        );
                    }
                    self.led = led;
                    self.standby.led(led);
                }
            }
            self.whole = self.read;
        }
        Ok(())
    }

    /// The questions that are due to the voters.
    pub fn questions(&mut self, now: WallNs) -> Vec<Question> {
        let questions = self.standby.tick(now, self.replay.conductor().voters());
        if let Some((here, all, silent)) = self.standby.stands() {
            tracing::warn!(
                "nothing is heard of the administration station: {here} of {all} voters here, asking {}",
                silent.join(", ")
            );
        }
        questions
    }

    /// A voter answered.
    pub fn voted(&mut self, now: WallNs, name: &str, voted: &Voted) -> Becomes {
        let inc = self.replay.conductor().inc_of(name);
        self.standby.voted(now, name, voted, inc).map_or(Becomes::Standby, Becomes::Leader)
    }

    /// Whether the station says nothing without it.
    #[must_use]
    pub fn is_in(&self) -> bool {
        self.standby.is_in()
    }

    /// How many voters are here, of how many, where it asks them.
    #[must_use]
    pub fn standing(&self) -> Option<(usize, usize)> {
        self.standby.standing()
    }

    /// How it stands, for people.
    #[must_use]
    pub fn says(&self) -> String {
        let (end, asked, at) = (self.journal.end(), self.asked, self.ask_at);
        format!("follows, journal {end}, question {asked}, next at {at}, {:?}", self.standby)
    }

    /// Since when nothing was heard of a station, ns.
    #[must_use]
    pub fn silent_since(&self) -> WallNs {
        self.silent_since
    }

    /// The run is over: its journal is removed.
    pub fn over(self) {
        tracing::info!("the run is over");
        self.journal.remove();
    }

    /// Leads on from the last tick of the station, with the log of its run; the own clock, ns.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub fn lead(self, led: Led, clock: WallNs) -> Result<(Lead, RunLog), JournalError> {
        let Self { config, mut journal, replay, log, whole, led: was, who, by, .. } = self;
        journal.cut(whole, was);
        // Another one than the standby: its questions are counted anew.
        let candidate = Candidate::new(config.fed, who, by.wrapping_add(1));
        let path = journal.path().display().to_string();
        let lead = Lead::succeed(config, replay, journal, (candidate, led), clock)
            .map_err(|error| JournalError::File { path, error })?;
        tracing::warn!("leads from here (epoch {}): the administration station is lost", led.epoch);
        Ok((lead, log))
    }
}
