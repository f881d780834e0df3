//! The administration station: configures, starts, freezes, steps, stops, restarts and measures a run.
//!
//! It owns the [`Conductor`](crate::runtime::conductor::Conductor) and is the only process that paces time.

mod actions;
mod asked;
#[cfg(test)]
mod clock_tests;
pub mod command;
mod created;
mod desk;
mod lead;
mod operate;
mod participants;
pub mod simman;
mod standby;
pub mod summary;
mod watch;

use crate::runtime::bus::{Bus, BusError, Class, Request, hear_parts};
use crate::runtime::clock::utc_ns;
use crate::runtime::clock_watch::Clocks;
use crate::runtime::codec::{decode, encode};
use crate::runtime::conductor::{ClosedRun, ConductorConfig, Effect, Input, Token};
use crate::runtime::federate::Publication;
use crate::runtime::journal::JournalError;
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::member_driver::Retained;
use crate::runtime::messages::{
    Answer, Beat, Command, FederateStatus, FetchOf, Frame, Hello, LogAsk, Numbered, Operation,
    OperatorCommand, Report, RunState, ScanReport, Welcome,
};
use crate::runtime::process::Usage;
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Candidacy, Leads, STATIONS, Steps, StepsAsk, Voted};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender};
use lead::Lead;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What reaches the administration station from outside.
pub enum Event {
    /// A federate asks to join.
    Join(Request),
    /// A report of a member.
    Report(String, Vec<u8>),
    /// A beat of a member.
    Beat(String, Vec<u8>),
    /// A member lacks orders, or reports of another one.
    Fetch(Request),
    /// Lost reports were told again.
    Fetched(Vec<u8>),
    /// One that returns reads the log of the run.
    Log(Request),
    /// A command from a second terminal or the page.
    Command(Request),
    /// A command from inside this process (DIS simulation management), with where it came from and
    /// the channel for the answer.
    Local(Command, String, Sender<Answer>),
    /// A member's liveliness changed: name, incarnation.
    Alive(String, u64, bool),
    /// A part of this process cannot go on: a fault of the run, which itself goes on.
    Broken(String),
    /// A standby reads the journal.
    Steps(Request),
    /// The voter of that name answered.
    Voted(String, Vec<u8>),
    /// A station says that it leads.
    Leads(Vec<u8>),
    /// The spectators that the run waits for will not come.
    NoSpectators,
    /// The operator of this process wants the run to end.
    Stop,
    /// This process is to end, and the run to go on when it is started again.
    Leave,
}

/// The name of an administration station.
pub const STATION: &str = STATIONS[0];

/// The name of its standby.
pub const STANDBY: &str = STATIONS[1];

/// How long a standby's question waits for more, ns.
const STEPS_WAIT_NS: u64 = 100_000_000;

/// Told of a phase reached: phase, frame, reason.
pub type PhaseHook = Box<dyn FnMut(Phase, Frame, Option<&str>) + Send>;

/// Told how the run stands.
pub type StateHook = Box<dyn FnMut(&RunState) + Send>;

/// Answers somebody's question, once.
type Answerer = Box<dyn FnOnce(Answering<'_>) + Send>;

/// What the administration station needs.
pub struct AdminContext {
    /// The synchronisation plane.
    pub bus: Arc<dyn Bus>,
    /// What this station is called: [`STATION`], or [`STANDBY`] where it was one.
    pub name: &'static str,
    /// The run.
    pub config: ConductorConfig,
    /// Events, also from simulation management and Ctrl-C.
    pub events: (Sender<Event>, Receiver<Event>),
    /// Told of every phase reached: phase, frame, reason.
    pub reached: PhaseHook,
    /// Told how the run stands, some times a second.
    pub stated: StateHook,
    /// Told of every closed run.
    pub closed: Box<dyn FnMut(&ClosedRun) + Send>,
    /// Told of the lowest frame executed and the last frame, about once a second.
    pub progress: Option<Box<dyn FnMut(Frame, Frame) + Send>>,
    /// How long expected federates may take to join, when in batch.
    pub patience: Duration,
    /// Where what the conductor is told is kept, so that a station that is started again goes on with the run.
    pub journal: Option<PathBuf>,
    /// The run of a station of which this process was the standby: it leads that one on.
    pub succeeds: Option<Box<Succeeds>>,
}

/// What a standby knows when it leads: the conductor, and the log of the run.
pub struct Succeeds(Lead, RunLog);

/// Statistics of the whole federation, as `seeds admin-station status` and the page show them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Statistics {
    /// How the run stands.
    pub state: RunState,
    /// Application measures of the last scan: plots, tracks, Pd, errors.
    pub measures: BTreeMap<String, f64>,
    /// System statistics of each federate.
    pub federates: BTreeMap<String, FederateStatus>,
    /// How far the clock of each other host is ahead of the station's, s.
    pub clocks: BTreeMap<String, f64>,
}

impl Statistics {
    /// Takes what a federate says of itself. Anybody on the bus may say a name: only those that have joined are kept.
    fn hear(&mut self, status: FederateStatus) {
        if self.state.members.iter().any(|m| m.name == status.name) {
            let before = self.federates.get(&status.name).map_or(&[][..], |s| &s.alarms);
            for alarm in status.alarms.iter().filter(|a| !before.contains(a)) {
                // A federate of this host has said it to the same terminal.
                if status.host != crate::runtime::process::host_name() {
                    tracing::warn!("{} on {} {alarm}", status.name, status.host);
                }
            }
            self.federates.insert(status.name.clone(), status);
        }
    }
}

/// Why an administration station cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum StationError {
    /// The synchronisation plane.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Its standby leads.
    #[error("its standby leads the run by now (epoch {0}): this administration station ends")]
    Deposed(u32),
    /// It is not to be a standby.
    #[error("this standby is refused: {0}")]
    Refused(String),
    /// No station is there whose standby it could be.
    #[error(
        "no administration station answered at {endpoint} within {seconds} s: a standby follows one that runs with --journal"
    )]
    NoStation {
        /// Endpoint.
        endpoint: String,
        /// Patience.
        seconds: u64,
    },
    /// Neither the station is heard nor enough voters.
    #[error(
        "nothing was heard of the administration station for {seconds} s, and {here} of {all} voters are here where more than half are needed: this standby ends"
    )]
    Cut {
        /// How long.
        seconds: u64,
        /// Voices that it has.
        here: usize,
        /// All.
        all: usize,
    },
}

/// Runs the federation until it is over; returns the exit code.
///
/// # Errors
/// If the bus fails, or the journal belongs to another run.
pub fn run(context: AdminContext) -> Result<u8, StationError> {
    let AdminContext { bus, config, events, mut reached, mut stated, mut closed, .. } = context;
    let (mut progress, patience) = (context.progress, context.patience);
    let (send, receive) = events;
    let statistics = Arc::new(Mutex::new(Statistics::default()));
    let expected = config.expected.clone();
    let (batch, last_frame) = (config.batch, config.last_frame);
    let mut clocks = Clocks::of(crate::runtime::process::host_name());
    let (mut lead, mut log) = match context.succeeds {
        Some(succeeds) => (succeeds.0, succeeds.1),
        None => {
            let mut log = RunLog::default();
            (Lead::open(context.journal.as_deref(), config, &mut log)?, log)
        }
    };
    let fed = lead.conductor().fed();
    if lead.led().standby {
        tracing::warn!(
            "a standby may lead this run by now: nothing is said until it reads on, or the voters say that it does not"
        );
    } else if lead.again() {
        tracing::warn!(
            "goes on with the run of the station before: {}",
            lead.conductor().standing()
        );
    }
    let retained = Retained::default();

    serve(&*bus, &send, &statistics)?;
    bus.announce(&format!("alive/{}/1", context.name))?;

    let mut asked: BTreeMap<Token, Answerer> = BTreeMap::new();
    let mut operations: BTreeMap<Token, Operation> = BTreeMap::new();
    let mut next_token: Token = 1;
    let mut usage = Usage::default();
    let mut next_status = 0;
    let mut next_beat = 0;
    let mut stopping: Option<u64> = None;
    let mut broken: Vec<String> = Vec::new();
    let started = lead.now();
    let mut said_awaiting = false;
    let mut standby: Option<(u64, Request, StepsAsk)> = None;
    let code = 'run: loop {
        let now = lead.now();
        let next = lead.conductor().deadline(now).min(next_beat).min(lead.questions_due());
        let wait = Duration::from_nanos(next.saturating_sub(now));
        let first = match receive.recv_timeout(wait) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break 'run 1,
        };
        let now = lead.now();
        let mut exit = None;
        // Answered when what they are answered from is in the journal.
        let mut questions = Vec::new();
        for event in first.into_iter().chain(receive.try_iter().take(256)) {
            let token = next_token;
            next_token += 1;
            match event {
                Event::Join(request) => match decode::<Hello>(&request.body) {
                    Ok(hello) => {
                        asked.insert(token, Box::new(move |a| a.to(request)));
                        lead.tell(now, Input::Hello(hello, token));
                    }
                    Err(e) => {
                        let why = Welcome::Refused(e.to_string());
                        request.answer(encode(&why));
                    }
                },
                Event::Beat(from, body) => match decode::<Beat>(&body) {
                    Ok(beat) => {
                        let host = lead.conductor().host_of(&from).filter(|_| beat.fed == fed);
                        let apart = host.and_then(|h| clocks.heard(now, h, beat.utc_ns, utc_ns()));
                        if let Some(text) = apart {
                            tracing::warn!("{text}");
                        }
                        lead.tell(now, Input::Beat(from, beat));
                    }
                    Err(e) => tracing::warn!("a beat of {from} was dropped: {e}"),
                },
                Event::Fetch(_) | Event::Log(_) => questions.push(event),
                Event::Fetched(body) => match decode(&body) {
                    Ok(fetched) => lead.tell(now, Input::Fetched(fetched)),
                    Err(e) => tracing::warn!("reports told again were dropped: {e}"),
                },
                Event::Report(from, body) => match decode::<Numbered<Report>>(&body) {
                    Ok(report) => lead.tell(now, Input::Report(from, report)),
                    Err(e) => tracing::warn!("a report of {from} was dropped: {e}"),
                },
                Event::Command(request) => match decode::<OperatorCommand>(&request.body) {
                    Ok(OperatorCommand { source, command }) => {
                        operations.extend(operation(token, &command, &source));
                        asked.insert(token, Box::new(move |a| a.to(request)));
                        lead.tell(now, Input::Command(command, token));
                    }
                    Err(e) => tracing::warn!("a command was dropped: {e}"),
                },
                Event::Local(command, source, answer) => {
                    operations.extend(operation(token, &command, &source));
                    asked.insert(
                        token,
                        Box::new(move |a| {
                            if let Answering::Answer(a) = a {
                                let _ = answer.send(a.clone());
                            }
                        }),
                    );
                    lead.tell(now, Input::Command(command, token));
                }
                Event::Alive(name, inc, alive) => lead.tell(now, Input::Alive(name, inc, alive)),
                Event::Broken(why) => {
                    tracing::error!("{why}");
                    broken.push(why);
                }
                Event::Steps(request) => match decode::<StepsAsk>(&request.body) {
                    Ok(ask) => standby = Some((now, request, ask)),
                    Err(e) => tracing::warn!("a standby's question was dropped: {e}"),
                },
                Event::Voted(name, body) => match decode::<Voted>(&body) {
                    Ok(voted) => lead.voted(now, &name, &voted),
                    Err(e) => tracing::warn!("a voice of {name} was dropped: {e}"),
                },
                Event::Leads(body) => {
                    let leads = decode::<Leads>(&body).ok().filter(|leads| leads.fed == fed);
                    if let Some(leads) = leads.filter(|leads| lead.deposed_by(leads.epoch)) {
                        lead.over();
                        bus.close();
                        return Err(StationError::Deposed(leads.epoch));
                    }
                }
                Event::NoSpectators => lead.tell(now, Input::NoSpectators),
                Event::Leave => {
                    let then = match lead.led().standby {
                        true => "its standby leads on",
                        false => {
                            "started again with the same journal within two minutes, this station goes on with the run"
                        }
                    };
                    tracing::warn!("leaves at frame {}: {then}", lead.conductor().frame());
                    break 'run 0;
                }
                Event::Stop => {
                    let conductor = lead.conductor();
                    let over = matches!(conductor.phase(), Phase::Stopped | Phase::Init);
                    if over && !conductor.awaits_results() {
                        exit = Some(conductor.exit_code());
                    } else if stopping.is_none() {
                        lead.tell(now, Input::Command(Command::Stop, 0));
                    }
                    stopping.get_or_insert(now);
                }
            }
        }
        // What it says that it holds may be acted upon at once.
        if let Some((since, request, ask)) = standby.take() {
            match lead.steps(now, &ask) {
                None if now < since + STEPS_WAIT_NS => standby = Some((since, request, ask)),
                told => request.answer(encode(&told.unwrap_or(Steps::Octets(Vec::new())))),
            }
        }
        for effect in lead.tick(now) {
            match effect {
                Effect::Welcome(token, mut welcome) => {
                    if let Welcome::Accepted(accepted) = &mut welcome {
                        accepted.epoch = lead.led().epoch;
                    }
                    if let Some(answer) = asked.remove(&token) {
                        answer(Answering::Welcome(&encode(&welcome)));
                    }
                }
                Effect::Answer(token, answer) => {
                    if let Some(mut done) = operations.remove(&token) {
                        done.frame = answer.state.frame;
                        done.time_ns = answer.state.frame as i64 * answer.state.step_ns;
                        done.ok = answer.ok;
                        done.text.clone_from(&answer.text);
                        bus.publish("obs/operation", Class::Lossy, encode(&done))?;
                    }
                    if let Some(tell) = asked.remove(&token) {
                        tell(Answering::Answer(&answer));
                    }
                }
                Effect::Order(order) => {
                    bus.publish("ctl/order", Class::Must, encode(&order))?;
                }
                Effect::Fetch { holder, ask } => {
                    let replies = send.clone();
                    bus.request(
                        &format!("log/{holder}"),
                        encode(&ask),
                        Duration::from_millis(500),
                        Box::new(move |reply| {
                            if let Some(body) = reply {
                                let _ = replies.send(Event::Fetched(body));
                            }
                        }),
                    )?;
                }
                Effect::Record(run, record) => log.append(run, &record),
                Effect::State(state) => {
                    let body = encode(&state);
                    stated(&state);
                    statistics.lock().unwrap_or_else(PoisonError::into_inner).state = state;
                    retained.publish(
                        &*bus,
                        Publication {
                            key: "obs/state".into(),
                            class: Class::Lossy,
                            body,
                            retained: Some("obs/state/last".into()),
                        },
                    )?;
                }
                Effect::Reached { phase, frame, reason } => {
                    match &reason {
                        Some(why) => tracing::error!("{phase} at frame {frame}: {why}"),
                        None => tracing::info!("{phase} at frame {frame}"),
                    }
                    reached(phase, frame, reason.as_deref());
                }
                Effect::Closed(mut run) => {
                    run.reasons.extend(broken.iter().cloned());
                    closed(&run);
                    if stopping.is_some() {
                        exit = Some(u8::from(run.failed));
                    }
                }
                Effect::Exit(code) => exit = Some(code),
            }
        }
        // And what was written now goes to it at once.
        if let Some((since, request, ask)) = standby.take() {
            match lead.steps(now, &ask) {
                Some(steps) => request.answer(encode(&steps)),
                None => standby = Some((since, request, ask)),
            }
        }
        for (voter, question) in lead.questions(now) {
            let replies = send.clone();
            ask_voter(&*bus, &voter, &question, move |name, body| {
                let _ = replies.send(Event::Voted(name, body));
            })?;
        }
        for question in questions {
            answer_from(&lead, &mut log, question);
        }
        if now >= next_beat {
            next_beat = now + 100_000_000;
            bus.publish("ctl/beat", Class::Lossy, encode(&lead.beat()))?;
            if let epoch @ 1.. = lead.led().epoch {
                bus.publish("ctl/lead", Class::Lossy, encode(&Leads { fed, epoch }))?;
            }
        }
        let conductor = lead.conductor();
        if now >= next_status {
            next_status = now + 1_000_000_000;
            if let Some(progress) =
                progress.as_mut().filter(|_| conductor.phase() == Phase::Running)
            {
                progress(conductor.frame(), last_frame);
            }
            usage.sample(now);
            let status = FederateStatus {
                name: context.name.into(),
                pid: std::process::id(),
                host: crate::runtime::process::host_name(),
                frame: conductor.frame(),
                cpu_s: usage.cpu_s,
                cpu_pct: usage.cpu_pct,
                rss_bytes: usage.rss_bytes,
                alarms: clocks.alarms().map(str::to_owned).collect(),
                ..Default::default()
            };
            bus.publish(&format!("obs/fed/{}", context.name), Class::Lossy, encode(&status))?;
            let mut statistics = statistics.lock().unwrap_or_else(PoisonError::into_inner);
            statistics.federates.insert(status.name.clone(), status);
            statistics.clocks = clocks.ahead_s().map(|(h, s)| (h.to_owned(), s)).collect();
        }
        let waited = Duration::from_nanos(now - started);
        if conductor.phase() == Phase::Init && waited > patience.min(Duration::from_secs(9)) {
            let (awaited, deaf) = (conductor.awaited().join(", "), conductor.deaf().join(", "));
            let text = if awaited.is_empty() && deaf.is_empty() {
                format!("after {} s still waiting for the viewer-logger", waited.as_secs())
            } else if awaited.is_empty() {
                format!(
                    "after {} s: {deaf} joined but does not hear all traffic generators and the external world on the synchronisation plane: check that every host can reach every other (--sync-listen with an address that the others reach)",
                    waited.as_secs()
                )
            } else {
                format!(
                    "after {} s still waiting for {awaited} (expected: {}): start them, or check their --sync-connect",
                    waited.as_secs(),
                    expected.join(", ")
                )
            };
            if batch && waited > patience {
                tracing::error!("{text}");
                exit = Some(1);
            } else if !said_awaiting {
                said_awaiting = true;
                tracing::warn!("{text}");
            }
        }
        if stopping.is_some_and(|at| now > at + 8_000_000_000) {
            exit.get_or_insert(1);
        }
        if let Some(code) = exit {
            let code = if broken.is_empty() { code } else { code.max(1) };
            if let Some((_, request, _)) = standby.take() {
                request.answer(encode(&Steps::Over));
            }
            bus.publish("ctl/order", Class::Must, encode(&conductor.leave(code)))?;
            lead.over();
            break 'run code;
        }
    };
    // Members leave on the order; their sessions close on their own.
    std::thread::sleep(Duration::from_millis(50));
    bus.close();
    Ok(code)
}

/// Asks a voter who is to lead.
fn ask_voter(
    bus: &dyn Bus,
    voter: &str,
    question: &Candidacy,
    answered: impl Fn(String, Vec<u8>) + Send + 'static,
) -> Result<(), BusError> {
    let name = voter.to_owned();
    let replies = move |reply: Option<Vec<u8>>| {
        if let Some(body) = reply {
            answered(name.clone(), body);
        }
    };
    let within = Duration::from_millis(500);
    bus.request(&format!("candidate/{voter}"), encode(question), within, Box::new(replies))
}

/// Answers who lacks orders, reports or the log of the run.
fn answer_from(lead: &Lead, log: &mut RunLog, question: Event) {
    let conductor = lead.conductor();
    match question {
        Event::Fetch(request) => match decode::<FetchOf>(&request.body) {
            Ok(ask) if ask.of == CONDUCTOR => {
                request.answer(encode(&lead.fetch_orders(&ask)));
            }
            Ok(ask) => request.answer(encode(&conductor.fetch_reports(&ask))),
            Err(e) => tracing::warn!("a question for messages was dropped: {e}"),
        },
        Event::Log(request) => match decode::<LogAsk>(&request.body) {
            Ok(asked) if asked.fed == conductor.fed() => {
                request.answer(encode(&log.page(asked.run, asked.page)));
            }
            Ok(_) => {}
            Err(e) => tracing::warn!("a question for the log was dropped: {e}"),
        },
        _ => {}
    }
}

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
    };
    Some((token, Operation { source: source.to_owned(), command, ..Operation::default() }))
}

fn serve(
    bus: &dyn Bus,
    send: &Sender<Event>,
    statistics: &Arc<Mutex<Statistics>>,
) -> Result<(), BusError> {
    let to = send.clone();
    bus.serve(
        "ctl/join",
        Box::new(move |request| {
            let _ = to.send(Event::Join(request));
        }),
    )?;
    let to = send.clone();
    bus.serve(
        "ctl/command",
        Box::new(move |request| {
            let _ = to.send(Event::Command(request));
        }),
    )?;
    let to = send.clone();
    bus.subscribe(
        "fed/*",
        Box::new(move |key, body| {
            let from = key.strip_prefix("fed/").unwrap_or(key);
            let _ = to.send(Event::Report(from.to_owned(), body.to_vec()));
        }),
    )?;
    let to = send.clone();
    bus.subscribe(
        "beat/*",
        Box::new(move |key, body| {
            let from = key.strip_prefix("beat/").unwrap_or(key);
            let _ = to.send(Event::Beat(from.to_owned(), body.to_vec()));
        }),
    )?;
    let to = send.clone();
    bus.serve(
        "log/conductor",
        Box::new(move |request| {
            let _ = to.send(Event::Fetch(request));
        }),
    )?;
    let to = send.clone();
    bus.serve(
        "ctl/steps",
        Box::new(move |request| {
            let _ = to.send(Event::Steps(request));
        }),
    )?;
    let to = send.clone();
    bus.subscribe(
        "ctl/lead",
        Box::new(move |_, body| {
            let _ = to.send(Event::Leads(body.to_vec()));
        }),
    )?;
    let to = send.clone();
    bus.serve(
        "log/run",
        Box::new(move |request| {
            let _ = to.send(Event::Log(request));
        }),
    )?;
    let to = send.clone();
    bus.watch(
        "alive/*/*",
        Box::new(move |key, alive| {
            let mut parts = key.split('/').skip(1);
            if let (Some(name), Some(Ok(inc))) = (parts.next(), parts.next().map(str::parse)) {
                let _ = to.send(Event::Alive(name.to_owned(), inc, alive));
            }
        }),
    )?;
    let kept = Arc::clone(statistics);
    bus.subscribe(
        "obs/fed/*",
        Box::new(move |_, body| {
            if let Ok(status) = decode::<FederateStatus>(body) {
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.hear(status);
            }
        }),
    )?;
    let kept = Arc::clone(statistics);
    hear_parts(bus, "tracks/1/scan", move |scan: ScanReport| {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.measures = scan.measures.into_iter().collect();
    })?;
    let kept = Arc::clone(statistics);
    bus.serve(
        "ctl/statistics",
        Box::new(move |request| {
            let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            let body = serde_json::to_vec(&*kept).unwrap_or_default();
            request.answer(body);
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::MemberState;

    #[test]
    fn two_hundred_thousand_names_that_never_joined_are_not_kept() {
        let member = MemberState { name: "smdfm".to_owned(), ..MemberState::default() };
        let state = RunState { members: vec![member], ..RunState::default() };
        let mut statistics = Statistics { state, ..Statistics::default() };
        for n in 0..200_000 {
            let name = format!("forged-{n}");
            statistics.hear(FederateStatus { name, ..FederateStatus::default() });
        }
        statistics.hear(FederateStatus { name: "smdfm".to_owned(), ..FederateStatus::default() });
        assert_eq!(statistics.federates.keys().collect::<Vec<_>>(), ["smdfm"]);
    }
}
