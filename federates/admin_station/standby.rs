//! A standby: the journal of a station, copied and followed, until that station is no more.

use super::lead::{Lead, candidate};
use super::{Event, StationError, Succeeds, ask_voter};
use crate::runtime::bus::{Bus, BusError, watch_stations};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::conductor::{ConductorConfig, Replay, Step};
use crate::runtime::digest::pdu_hash;
use crate::runtime::journal::{Journal, JournalError, Line, Records, run_of};
use crate::runtime::messages::{Numbered, Order};
use crate::runtime::process::random_id;
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Candidate, Led, Question, Standby, Steps, StepsAsk, Voted};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use std::path::Path;
use std::time::Duration;

/// How long a station is looked for, and how long a standby waits for voices.
const PATIENCE_NS: u64 = 120_000_000_000;

/// How long an answer is awaited.
const ANSWER: Duration = Duration::from_millis(1_000);

/// How soon it asks again where there was no answer, or nothing to read, ns.
const AGAIN_NS: u64 = 100_000_000;

/// How often it looks at the clock.
const LOOK: Duration = Duration::from_millis(50);

/// What reaches a standby.
enum Heard {
    /// The answer to a question of that number; none: no more will come.
    Steps(u64, Option<Vec<u8>>),
    /// A voter answered.
    Voted(String, Vec<u8>),
    /// A station beats.
    Beat,
    /// The connection of a station came or went.
    Alive(bool),
    /// An order to the members.
    Order(Vec<u8>),
}

/// Follows the station on `bus` until it is no more: the run that is to be led on; none if the run is over.
///
/// # Errors
/// [`StationError`]: the journal, a refusal, no station, not enough voters.
pub(super) fn follow(
    bus: &dyn Bus,
    config: &ConductorConfig,
    (path, endpoint): (&Path, &str),
    events: &Receiver<Event>,
) -> Result<Option<Box<Succeeds>>, StationError> {
    let (send, receive) = unbounded();
    listen(bus, &send)?;
    let mut copy = Copy::open(path, config)?;
    let (mut asked, mut ask_at) = (0_u64, 0);
    let (mut silent_since, mut said) = (monotonic_ns(), String::new());
    loop {
        let now = monotonic_ns();
        if copy.standby.follows() && now >= ask_at {
            asked += 1;
            ask_at = u64::MAX;
            let (number, replies) = (asked, send.clone());
            let replies = move |reply| drop(replies.send(Heard::Steps(number, reply)));
            bus.request("ctl/steps", encode(&copy.ask()?), ANSWER, Box::new(replies))?;
        }
        let heard = match receive.recv_timeout(LOOK) {
            Ok(heard) => Some(heard),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
        };
        let now = monotonic_ns();
        match heard {
            Some(Heard::Steps(number, Some(body))) if number == asked => {
                silent_since = now;
                copy.standby.heard(now);
                let steps =
                    decode::<Steps>(&body).map_err(|e| StationError::Refused(e.to_string()))?;
                ask_at = now;
                match steps {
                    Steps::Octets(octets) => copy.take(&octets)?,
                    Steps::Anew => copy = Copy::anew(copy, config),
                    Steps::Over => return Ok(copy.over()),
                    Steps::Refused(why) => return Err(StationError::Refused(why)),
                    Steps::Later(why) => {
                        if said != why {
                            tracing::warn!("waits: {why}");
                            said = why;
                        }
                        ask_at = now + 5 * AGAIN_NS;
                    }
                }
            }
            Some(Heard::Steps(number, None)) if number == asked && ask_at == u64::MAX => {
                ask_at = now + AGAIN_NS;
            }
            Some(Heard::Steps(..)) | None => {}
            Some(Heard::Voted(name, body)) => {
                if let Ok(voted) = decode::<Voted>(&body)
                    && let Some(led) = copy.voted(now, &name, &voted)
                {
                    return copy.lead(led).map(Some);
                }
            }
            Some(Heard::Beat) => {
                silent_since = now;
                copy.standby.heard(now);
            }
            Some(Heard::Alive(alive)) => copy.standby.connected(alive),
            Some(Heard::Order(body)) => {
                let order =
                    decode::<Numbered<Order>>(&body).ok().filter(|o| Some(o.fed) == copy.fed);
                if order.is_some_and(|order| matches!(order.body, Order::Exit { .. })) {
                    return Ok(copy.over());
                }
            }
        }
        if events.try_iter().any(|event| matches!(event, Event::Stop | Event::Leave)) {
            return Ok(None);
        }
        for (voter, question) in copy.questions(now) {
            let replies = send.clone();
            ask_voter(bus, &voter, &question, move |name, body| {
                let _ = replies.send(Heard::Voted(name, body));
            })?;
        }
        if now > silent_since + PATIENCE_NS {
            return Err(match copy.standing() {
                Some((here, all)) => {
                    StationError::Cut { seconds: PATIENCE_NS / 1_000_000_000, here, all }
                }
                None => StationError::NoStation {
                    endpoint: endpoint.to_owned(),
                    seconds: PATIENCE_NS / 1_000_000_000,
                },
            });
        }
    }
}

fn listen(bus: &dyn Bus, send: &Sender<Heard>) -> Result<(), BusError> {
    let to = send.clone();
    bus.subscribe("ctl/beat", Box::new(move |_, _| drop(to.send(Heard::Beat))))?;
    let to = send.clone();
    bus.subscribe(
        "ctl/order",
        Box::new(move |_, body| drop(to.send(Heard::Order(body.to_vec())))),
    )?;
    let to = send.clone();
    watch_stations(bus, move |alive| drop(to.send(Heard::Alive(alive))))?;
    Ok(())
}

/// The journal of a station, as far as it was read.
struct Copy {
    config: ConductorConfig,
    journal: Journal,
    candidate: Candidate,
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
}

impl Copy {
    /// Goes on from what the file holds of this run.
    fn open(path: &Path, config: &ConductorConfig) -> Result<Self, JournalError> {
        let (journal, past) = Journal::open_copy(path, config)?;
        let mut copy = Self::of(journal, config);
        if let Some(mut past) = past {
            copy.begin(past.fed);
            for step in copy.journal.steps(&mut past) {
                copy.replay.step(step, |run, record| copy.log.append(run, record));
            }
            copy.led = copy.journal.led();
            (copy.read, copy.whole) = (copy.journal.end(), copy.journal.end());
            copy.standby = Standby::new(monotonic_ns(), copy.candidate.clone(), copy.journal.led());
        }
        Ok(copy)
    }

    fn of(journal: Journal, config: &ConductorConfig) -> Self {
        let candidate = candidate(config.fed, journal.path(), random_id());
        Self {
            config: config.clone(),
            standby: Standby::new(monotonic_ns(), candidate.clone(), Led::default()),
            candidate,
            journal,
            fed: None,
            replay: Replay::new(config.clone()),
            log: RunLog::default(),
            records: Records::default(),
            open: Vec::new(),
            read: 0,
            whole: 0,
            led: Led::default(),
        }
    }

    /// What it holds is of another journal.
    fn anew(self, config: &ConductorConfig) -> Self {
        let Self { mut journal, candidate, .. } = self;
        journal.cut(0, Led::default());
        Self { candidate, ..Self::of(journal, config) }
    }

    /// The journal is of that federation.
    fn begin(&mut self, fed: u128) {
        self.fed = Some(fed);
        self.config.fed = fed;
        self.replay = Replay::new(self.config.clone());
        self.candidate = candidate(fed, self.journal.path(), self.candidate.by());
        self.standby = Standby::new(monotonic_ns(), self.candidate.clone(), Led::default());
    }

    fn ask(&mut self) -> Result<StepsAsk, JournalError> {
        let from = self.journal.end();
        let sum = self.journal.sum(from).map_err(|error| self.failed(error))?;
        let sum = sum.unwrap_or_else(|| pdu_hash(&[]));
        Ok(StepsAsk { run: run_of(&self.config), who: self.candidate.who(), from, sum })
    }

    fn failed(&self, error: std::io::Error) -> JournalError {
        JournalError::File { path: self.journal.path().display().to_string(), error }
    }

    fn take(&mut self, octets: &[u8]) -> Result<(), JournalError> {
        self.journal.copy(octets).map_err(|error| self.failed(error))?;
        for (line, length) in self.records.take(octets) {
            self.read += length;
            match line {
                Line::Head(_, fed) => self.begin(fed),
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

    fn questions(&mut self, now: u64) -> Vec<Question> {
        let questions = self.standby.tick(now, self.replay.conductor().voters());
        if let Some((here, all, silent)) = self.standby.stands() {
            tracing::warn!(
                "nothing is heard of the administration station: {here} of {all} voters here, asking {}",
                silent.join(", ")
            );
        }
        questions
    }

    fn voted(&mut self, now: u64, name: &str, voted: &Voted) -> Option<Led> {
        let inc = self.replay.conductor().inc_of(name);
        self.standby.voted(now, name, voted, inc)
    }

    /// How many voters are here, of how many, where it asks them.
    fn standing(&self) -> Option<(usize, usize)> {
        self.standby.standing()
    }

    fn over(self) -> Option<Box<Succeeds>> {
        tracing::info!("the run is over");
        self.journal.remove();
        None
    }

    /// Leads on from the last tick of the station.
    fn lead(self, led: Led) -> Result<Box<Succeeds>, StationError> {
        let Self { config, mut journal, replay, log, whole, led: was, .. } = self;
        journal.cut(whole, was);
        // Another one than the standby: its questions are counted anew.
        let candidate = candidate(config.fed, journal.path(), random_id());
        let path = journal.path().display().to_string();
        let refused = |error| JournalError::File { path, error };
        let lead = Lead::succeed(config, replay, journal, (candidate, led)).map_err(refused)?;
        tracing::warn!("leads from here (epoch {}): the administration station is lost", led.epoch);
        Ok(Box::new(Succeeds(lead, log)))
    }
}
