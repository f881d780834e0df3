//! The station at work: events in, what the conductor decides out; one turn of the loop is one tick of the conductor.

use super::awaiting::Awaiting;
use super::balance::Balance;
use super::statistics::Statistics;
use super::summary::RunDigests;
use super::{
    AdminContext, Event, PhaseHook, StateHook, StationError, Succeeds, ask_voter, ears, who_has,
};
use crate::runtime::bus::{Bus, Class, Request};
use crate::runtime::cli::print_line;
use crate::runtime::clock::{WallNs, monotonic_ns, utc_ns};
use crate::runtime::clock_watch::Clocks;
use crate::runtime::codec::{decode, encode};
use crate::runtime::conductor::{ClosedRun, Effect, Input, Token, Why};
use crate::runtime::federate::Publication;
use crate::runtime::journal::Journal;
use crate::runtime::lead::{Lead, Turn};
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::member_driver::Retained;
use crate::runtime::messages::{
    Answer, Beat, Command, FederateStatus, FetchOf, Frame, Hello, LogAsk, Numbered, Operation,
    OperatorCommand, Outcome, RepairOf, Report, Welcome,
};
use crate::runtime::process::{REACHED, Usage, launched, random_id};
use crate::runtime::run_log::RunLog;
use crate::runtime::senders::NO_MANAGER;
use crate::runtime::succession::{Leads, Steps, StepsAsk, Voted};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Between two beats of the station, and between two words on itself, ns.
const BEAT_NS: WallNs = 100_000_000;
const STATUS_NS: WallNs = 1_000_000_000;
/// How long a run that is to stop may take, ns.
const STOP_WITHIN_NS: WallNs = 8_000_000_000;
/// How long a fetch may take.
const FETCH_WITHIN: Duration = Duration::from_millis(500);
/// Events of one turn, beside the first.
const EVENTS_A_TURN: usize = 256;
/// After so long it says for whom it waits.
const SAY_AWAITING: Duration = Duration::from_secs(9);

/// The answer to somebody's question.
enum Answering<'a> {
    Welcome(&'a [u8]),
    Answer(&'a Answer),
}

impl Answering<'_> {
    fn to(self, request: Request) {
        match self {
            Self::Welcome(body) => request.answer(body.to_vec()),
            Self::Answer(answer) => request.answer(encode(answer)),
        }
    }
}

/// Answers somebody's question, once.
type Answerer = Box<dyn FnOnce(Answering<'_>) + Send>;

/// A station that leads a run.
pub(super) struct Station {
    name: &'static str,
    bus: Arc<dyn Bus>,
    send: Sender<Event>,
    lead: Lead,
    log: RunLog,
    fed: u128,
    retained: Retained,
    statistics: Arc<Mutex<Statistics>>,
    clocks: Clocks,
    usage: Usage,
    expected: Vec<String>,
    batch: bool,
    last_frame: Frame,
    patience: Duration,
    reached: PhaseHook,
    stated: StateHook,
    closed: Box<dyn FnMut(&ClosedRun) + Send>,
    progress: Option<Box<dyn FnMut(Frame, Frame) + Send>>,
    asked: BTreeMap<Token, Answerer>,
    operations: BTreeMap<Token, Operation>,
    next_token: Token,
    /// The question of the standby that waits for more of the journal, by its number.
    standby: Option<(u64, Request)>,
    broken: Vec<String>,
    awaiting: Awaiting,
    next_beat: WallNs,
    next_status: WallNs,
    /// Since when the run is to stop.
    stopping: Option<WallNs>,
    /// The code with which the process is to end.
    exit: Option<u8>,
    /// Places are moved by load.
    balance: Option<Balance>,
    /// Requests of simulation management that were refused.
    refused: Arc<AtomicU64>,
}

impl Station {
    /// A station of a new run, or of one that goes on: with a journal, or after the station whose standby it was.
    pub(super) fn open(context: AdminContext) -> Result<(Self, Receiver<Event>), StationError> {
        let AdminContext { bus, config, events, .. } = context;
        let (send, receive) = events;
        let statistics = Arc::new(Mutex::new(Statistics::default()));
        let expected = config.expected.clone();
        let (batch, last_frame) = (config.batch, config.last_frame);
        let (lead, log) = match context.succeeds {
            Some(succeeds) => {
                let Succeeds(lead, log) = *succeeds;
                (lead, log)
            }
            None => {
                let mut log = RunLog::default();
                let opened = context.journal.as_deref();
                let opened = opened.map(|path| Journal::open(path, &config)).transpose()?;
                let who = opened.as_ref().map_or(0, |(journal, _)| who_has(journal.path()));
                let who = (who, random_id());
                (Lead::open(opened, config, who, monotonic_ns(), &mut log), log)
            }
        };
        if lead.led().standby {
            tracing::warn!(
                "a standby may lead this run by now: nothing is said until it reads on, or the voters say that it does not"
            );
        } else if lead.again() {
            // A launcher that begins with this station knows nothing of its run.
            if launched() {
                print_line(&format!("{REACHED} {}", lead.conductor().phase()));
            }
            tracing::warn!(
                "goes on with the run of the station before: {}",
                lead.conductor().standing()
            );
        }
        ears::open(&*bus, &send, &statistics)?;
        bus.announce(&format!("alive/{}/1", context.name))?;
        let station = Self {
            name: context.name,
            bus,
            send,
            fed: lead.conductor().fed(),
            awaiting: Awaiting::new(lead.now(monotonic_ns())),
            lead,
            log,
            retained: Retained::default(),
            statistics,
            clocks: Clocks::of(crate::runtime::process::host_name()),
            usage: Usage::default(),
            expected,
            batch,
            last_frame,
            patience: context.patience,
            reached: context.reached,
            stated: context.stated,
            closed: context.closed,
            progress: context.progress,
            asked: BTreeMap::new(),
            operations: BTreeMap::new(),
            next_token: 1,
            standby: None,
            broken: Vec::new(),
            next_beat: 0,
            next_status: 0,
            stopping: None,
            exit: None,
            balance: context.balance.then(Balance::default),
            refused: context.refused,
        };
        Ok((station, receive))
    }

    /// Works until the run is over; the exit code.
    pub(super) fn run(mut self, receive: &Receiver<Event>) -> Result<u8, StationError> {
        let code = loop {
            let now = self.lead.now(monotonic_ns());
            let next = self.lead.conductor().deadline(now);
            let next = next.min(self.next_beat).min(self.lead.questions_due());
            let first = match receive.recv_timeout(Duration::from_nanos(next.saturating_sub(now))) {
                Ok(event) => Some(event),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => break 1,
            };
            let events = first.into_iter().chain(receive.try_iter().take(EVENTS_A_TURN));
            if let Some(code) = self.turn(events)? {
                break code;
            }
        };
        // Members leave on the order; their sessions close on their own.
        std::thread::sleep(Duration::from_millis(50));
        self.bus.close();
        Ok(code)
    }

    /// Hears what came, carries out what is decided, and says how it stands; the exit code where that is over.
    fn turn(&mut self, events: impl Iterator<Item = Event>) -> Result<Option<u8>, StationError> {
        let now = self.lead.now(monotonic_ns());
        // Answered when what they are answered from is in the journal.
        let mut questions = Vec::new();
        for event in events {
            match event {
                Event::Fetch(_) | Event::Log(_) | Event::Repair(_) => questions.push(event),
                Event::Leave => {
                    self.say_who_leads_on();
                    return Ok(Some(0));
                }
                event => self.hear(now, event)?,
            }
        }
        let Turn { told, effects } = self.lead.turn(now);
        for (number, steps) in told {
            if let Some((_, request)) = self.standby.take_if(|(waits, _)| *waits == number) {
                request.answer(encode(&steps));
            }
        }
        for effect in effects {
            self.carry_out(effect)?;
        }
        for (voter, question) in self.lead.questions(now) {
            let replies = self.send.clone();
            ask_voter(&*self.bus, &voter, &question, move |name, body| {
                let _ = replies.send(Event::Voted(name, body));
            })?;
        }
        for question in questions {
            self.answer(question)?;
        }
        if now >= self.next_beat {
            self.next_beat = now + BEAT_NS;
            self.beat()?;
        }
        if now >= self.next_status {
            self.next_status = now + STATUS_NS;
            self.say_how_it_stands(now)?;
        }
        self.wait_for_members(now);
        if self.stopping.is_some_and(|at| now > at + STOP_WITHIN_NS) {
            self.exit.get_or_insert(1);
        }
        self.exit.map(|code| self.end(code)).transpose()
    }

    fn hear(&mut self, now: WallNs, event: Event) -> Result<(), StationError> {
        let token = self.next_token;
        self.next_token += 1;
        match event {
            Event::Join(request) => match decode::<Hello>(&request.body) {
                Ok(hello) => {
                    self.asked.insert(token, Box::new(move |a| a.to(request)));
                    self.lead.tell(now, Input::Hello(hello, token));
                }
                Err(e) => request.answer(encode(&Welcome::Refused(e.to_string()))),
            },
            Event::Beat(from, body) => match decode::<Beat>(&body) {
                Ok(beat) => {
                    let host = self.lead.conductor().host_of(&from);
                    let host = host.filter(|_| beat.fed == self.fed);
                    let apart = host.and_then(|h| self.clocks.heard(now, h, beat.utc_ns, utc_ns()));
                    if let Some(text) = apart {
                        tracing::warn!("{text}");
                    }
                    self.lead.tell(now, Input::Beat(from, beat));
                }
                Err(e) => tracing::warn!("a beat of {from} was dropped: {e}"),
            },
            Event::Fetched(body) => match decode(&body) {
                Ok(fetched) => self.lead.tell(now, Input::Fetched(fetched)),
                Err(e) => tracing::warn!("reports told again were dropped: {e}"),
            },
            Event::Report(from, body) => match decode::<Numbered<Report>>(&body) {
                Ok(report) => self.lead.tell(now, Input::Report(from, report)),
                Err(e) => tracing::warn!("a report of {from} was dropped: {e}"),
            },
            Event::Command(request) => match decode::<OperatorCommand>(&request.body) {
                Ok(OperatorCommand { source, command }) => {
                    self.operations.extend(operation(token, &command, &source));
                    self.asked.insert(token, Box::new(move |a| a.to(request)));
                    self.lead.tell(now, Input::Command(command, token));
                }
                Err(e) => tracing::warn!("a command was dropped: {e}"),
            },
            Event::Local(command, source, answer) => {
                self.operations.extend(operation(token, &command, &source));
                let tell = move |told: Answering<'_>| {
                    if let Answering::Answer(told) = told {
                        let _ = answer.send(told.clone());
                    }
                };
                self.asked.insert(token, Box::new(tell));
                self.lead.tell(now, Input::Command(command, token));
            }
            Event::Alive(name, inc, alive) => self.lead.tell(now, Input::Alive(name, inc, alive)),
            Event::Broken(why) => {
                tracing::error!("{why}");
                self.broken.push(why);
            }
            Event::Steps(request) => match decode::<StepsAsk>(&request.body) {
                Ok(ask) => {
                    self.lead.asked(now, token, ask);
                    self.standby = Some((token, request));
                }
                Err(e) => tracing::warn!("a standby's question was dropped: {e}"),
            },
            Event::Voted(name, body) => match decode::<Voted>(&body) {
                Ok(voted) => self.lead.voted(now, &name, &voted),
                Err(e) => tracing::warn!("a voice of {name} was dropped: {e}"),
            },
            Event::Leads(body) => {
                let leads = decode::<Leads>(&body).ok().filter(|leads| leads.fed == self.fed);
                if let Some(leads) = leads.filter(|leads| self.lead.deposed_by(leads.epoch)) {
                    self.lead.over();
                    self.bus.close();
                    return Err(StationError::Deposed(leads.epoch));
                }
            }
            Event::NoSpectators => self.lead.tell(now, Input::NoSpectators),
            Event::Stop => {
                let conductor = self.lead.conductor();
                let over = matches!(conductor.phase(), Phase::Stopped | Phase::Init);
                if over && !conductor.awaits_results() {
                    self.exit = Some(conductor.exit_code());
                } else if self.stopping.is_none() {
                    self.lead.tell(now, Input::Command(Command::Stop, 0));
                }
                self.stopping.get_or_insert(now);
            }
            // Of these the turn takes care.
            Event::Fetch(_) | Event::Log(_) | Event::Repair(_) | Event::Leave => {}
        }
        Ok(())
    }

    fn carry_out(&mut self, effect: Effect) -> Result<(), StationError> {
        match effect {
            Effect::Welcome(token, mut welcome) => {
                if let Welcome::Accepted(accepted) = &mut welcome {
                    accepted.epoch = self.lead.led().epoch;
                }
                if let Some(answer) = self.asked.remove(&token) {
                    answer(Answering::Welcome(&encode(&welcome)));
                }
            }
            Effect::Answer(token, answer) => {
                if let Some(mut done) = self.operations.remove(&token) {
                    done.frame = answer.state.frame;
                    done.time_ns = answer.state.frame as i64 * answer.state.step_ns;
                    done.ok = answer.ok;
                    done.text.clone_from(&answer.text);
                    self.bus.publish("obs/operation", Class::Lossy, encode(&done))?;
                }
                if let Some(tell) = self.asked.remove(&token) {
                    tell(Answering::Answer(&answer));
                }
            }
            Effect::Order(order) => self.bus.publish("ctl/order", Class::Must, encode(&order))?,
            Effect::Fetch { holder, ask } => {
                let replies = self.send.clone();
                let told = move |reply: Option<Vec<u8>>| {
                    if let Some(body) = reply {
                        let _ = replies.send(Event::Fetched(body));
                    }
                };
                let key = format!("log/{holder}");
                self.bus.request(&key, encode(&ask), FETCH_WITHIN, Box::new(told))?;
            }
            Effect::Record(run, record) => self.log.append(run, &record),
            Effect::State(state) => {
                let body = encode(&state);
                (self.stated)(&state);
                self.statistics.lock().unwrap_or_else(PoisonError::into_inner).state = state;
                let retained = Some("obs/state/last".into());
                let key = "obs/state".into();
                let publication = Publication { key, class: Class::Lossy, body, retained };
                self.retained.publish(&*self.bus, publication)?;
            }
            Effect::Reached { phase, frame, why } => {
                match &why {
                    Some(Why::Fault(why)) => tracing::error!("{phase} at frame {frame}: {why}"),
                    Some(Why::Given(why)) => tracing::info!("{phase} at frame {frame}: {why}"),
                    None => tracing::info!("{phase} at frame {frame}"),
                }
                (self.reached)(phase, frame, why.as_ref().map(Why::text));
            }
            Effect::Closed(mut run) => {
                run.reasons.extend(self.broken.iter().cloned());
                let outcome = Outcome { run: run.run, facts: RunDigests::of(&run).facts() };
                self.bus.publish("obs/outcome", Class::Must, encode(&outcome))?;
                (self.closed)(&run);
                if self.stopping.is_some() {
                    self.exit = Some(u8::from(run.failed));
                }
            }
            Effect::Exit(code) => self.exit = Some(code),
        }
        Ok(())
    }

    /// Answers who lacks orders, reports or the log of the run, and passes on who lacks PDUs.
    fn answer(&mut self, question: Event) -> Result<(), StationError> {
        let conductor = self.lead.conductor();
        match question {
            Event::Fetch(request) => match decode::<FetchOf>(&request.body) {
                Ok(ask) if ask.of == CONDUCTOR => {
                    request.answer(encode(&self.lead.fetch_orders(&ask)));
                }
                Ok(ask) => request.answer(encode(&conductor.fetch_reports(&ask))),
                Err(e) => tracing::warn!("a question for messages was dropped: {e}"),
            },
            Event::Log(request) => match decode::<LogAsk>(&request.body) {
                Ok(asked) if asked.fed == conductor.fed() => {
                    request.answer(encode(&self.log.page(asked.run, asked.page)));
                }
                Ok(_) => {}
                Err(e) => tracing::warn!("a question for the log was dropped: {e}"),
            },
            Event::Repair(request) => match decode::<RepairOf>(&request.body) {
                Ok(ask) if conductor.passes_on(&ask) => {
                    let mut asker = Some(request);
                    let told = move |reply: Option<Vec<u8>>| {
                        if let Some(body) = reply
                            && let Some(asker) = asker.take()
                        {
                            asker.answer(body);
                        }
                    };
                    let key = format!("frames/{}", ask.of);
                    self.bus.request(&key, encode(&ask.repair), FETCH_WITHIN, Box::new(told))?;
                }
                Ok(_) => {}
                Err(e) => tracing::warn!("a question for PDUs was dropped: {e}"),
            },
            _ => {}
        }
        Ok(())
    }

    fn beat(&mut self) -> Result<(), StationError> {
        self.bus.publish("ctl/beat", Class::Lossy, encode(&self.lead.beat()))?;
        if let epoch @ 1.. = self.lead.led().epoch {
            let leads = Leads { fed: self.fed, epoch };
            self.bus.publish("ctl/lead", Class::Lossy, encode(&leads))?;
        }
        Ok(())
    }

    fn say_how_it_stands(&mut self, now: WallNs) -> Result<(), StationError> {
        let conductor = self.lead.conductor();
        let running = conductor.phase() == Phase::Running;
        if let Some(progress) = self.progress.as_mut().filter(|_| running) {
            progress(conductor.frame(), self.last_frame);
        }
        self.usage.sample(now);
        let refused = Some(self.refused.load(Ordering::Relaxed)).filter(|count| *count > 0);
        let status = FederateStatus {
            name: self.name.into(),
            pid: std::process::id(),
            host: crate::runtime::process::host_name(),
            frame: conductor.frame(),
            cpu_s: self.usage.cpu_s,
            cpu_pct: self.usage.cpu_pct,
            rss_bytes: self.usage.rss_bytes,
            host_busy_pct: self.usage.host_busy_pct,
            host_cores: self.usage.host_cores,
            alarms: self.clocks.alarms().map(str::to_owned).collect(),
            dropped: refused.map(|count| (NO_MANAGER.to_owned(), count)).into_iter().collect(),
            ..Default::default()
        };
        self.bus.publish(&format!("obs/fed/{}", self.name), Class::Lossy, encode(&status))?;
        let mut statistics = self.statistics.lock().unwrap_or_else(PoisonError::into_inner);
        statistics.federates.insert(status.name.clone(), status);
        statistics.clocks = self.clocks.ahead_s().map(|(h, s)| (h.to_owned(), s)).collect();
        let places = conductor.places();
        let balance = self.balance.as_mut().filter(|_| running);
        if let Some(command) = balance.and_then(|b| b.look(now, &statistics.federates, &places)) {
            if let Command::Move { name, to } = &command {
                let host = statistics.federates.get(name).map_or("its host", |f| f.host.as_str());
                tracing::warn!("{host} is busy: {name} goes to the process of {to} (--balance)");
            }
            let token = self.next_token;
            self.next_token += 1;
            self.operations.extend(operation(token, &command, "balance"));
            self.lead.tell(now, Input::Command(command, token));
        }
        Ok(())
    }

    /// Says for whom it waits, and gives up in batch.
    fn wait_for_members(&mut self, now: WallNs) {
        let conductor = self.lead.conductor();
        let waited = self.awaiting.waited(now, conductor.phase());
        if conductor.phase() != Phase::Init || waited <= self.patience.min(SAY_AWAITING) {
            return;
        }
        let (awaited, deaf) = (conductor.awaited().join(", "), conductor.deaf().join(", "));
        let seconds = waited.as_secs();
        let text = if awaited.is_empty() && deaf.is_empty() {
            format!("after {seconds} s still waiting for the viewer-logger")
        } else if awaited.is_empty() {
            format!(
                "after {seconds} s: {deaf} joined but does not hear all traffic generators and the external world on the synchronisation plane: check that every host can reach every other (--sync-listen with an address that the others reach)"
            )
        } else {
            format!(
                "after {seconds} s still waiting for {awaited} (expected: {}): start them, or check their --sync-connect",
                self.expected.join(", ")
            )
        };
        if self.batch && waited > self.patience {
            tracing::error!("{text}");
            self.exit = Some(1);
        } else if !self.awaiting.said {
            self.awaiting.said = true;
            tracing::warn!("{text}");
        }
    }

    fn say_who_leads_on(&self) {
        let then = match self.lead.led().standby {
            true => "its standby leads on",
            false => {
                "started again with the same journal within two minutes, this station goes on with the run"
            }
        };
        tracing::warn!("leaves at frame {}: {then}", self.lead.conductor().frame());
    }

    /// The federation is over for everybody: the exit code.
    fn end(&mut self, code: u8) -> Result<u8, StationError> {
        let code = if self.broken.is_empty() { code } else { code.max(1) };
        if let Some((_, request)) = self.standby.take() {
            request.answer(encode(&Steps::Over));
        }
        self.bus.publish("ctl/order", Class::Must, encode(&self.lead.conductor().leave(code)))?;
        self.lead.over();
        Ok(code)
    }
}

/// Every operator action is told to the spectators with its answer, the log among them.
fn operation(token: Token, command: &Command, source: &str) -> Option<(Token, Operation)> {
    let command = match command {
        Command::Status => return None,
        Command::Start => "start".to_owned(),
        Command::Freeze => "freeze".to_owned(),
        Command::Step { n } => format!("step {n}"),
        Command::Stop => "stop".to_owned(),
        Command::Restart => "restart".to_owned(),
        Command::Rate { rate } => format!("rate {rate}"),
        Command::Move { name, to } => format!("move {name} {to}"),
        Command::Without { name } => format!("without {name}"),
    };
    Some((token, Operation { source: source.to_owned(), command, ..Operation::default() }))
}
