//! Runs a [`Member`] on a bus and a data plane: the only loop of an essential federate.

use super::bus::{Bus, BusError, Class, Request, ask, watch_stations};
use super::clock::{monotonic_ns, monotonic_us, utc_ns};
use super::codec::{decode, encode};
use super::data_plane::DataPlane;
use super::federate::{Federate, Octets, Publication};
use super::grace::{GRACE_NS, Grace};
use super::hearing::LOOK_NS;
use super::member::{CONDUCTOR, Effect, Member, Pulse, Remake};
use super::messages::{
    Accepted, Beat, FederateStatus, FetchOf, Hello, LogAsk, LogPage, Numbered, Order, RepairOf,
    Report, Welcome,
};
use super::overflow::Overflow;
use super::process::Usage;
use super::succession::{Candidacy, Voter};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What reaches a federate from outside.
pub enum Event {
    /// An order of the conductor.
    Order(Vec<u8>),
    /// A report of another member.
    Report(String, Vec<u8>),
    /// Sound PDUs of this exercise.
    Pdus(Vec<Octets>),
    /// A beat of another member or of the conductor.
    Beat(String, Vec<u8>),
    /// Lost orders were told again.
    Orders(Vec<u8>),
    /// Lost reports were told again.
    Reports(String, Vec<u8>),
    /// Somebody lacks reports.
    FetchWanted(Request),
    /// A datagram or PDU was dropped, and why.
    Dropped(&'static str, u64),
    /// A probe of the producer of this name was heard on the data plane: a short or a long one.
    Probe(String, bool),
    /// A repair was answered.
    Repaired(String, Vec<u8>),
    /// A consumer misses PDUs.
    RepairWanted(Request),
    /// The conductor came or went.
    ConductorAlive(bool),
    /// A part of this process cannot go on, and why: the run must hear of it.
    Failed(String),
    /// The operator of this process wants it to end.
    Stop,
}

/// What a federate needs around its logic.
pub struct MemberContext {
    /// Name in the federation.
    pub name: String,
    /// Hash of the scene.
    pub scene_hash: u64,
    /// The synchronisation plane.
    pub bus: Arc<dyn Bus>,
    /// The data plane, sending side.
    pub data: Box<dyn DataPlane>,
    /// Where the data plane's receiving side and the operator put events.
    pub events: (Sender<Event>, Receiver<Event>),
    /// How the conductor is reached, for messages.
    pub endpoint: String,
    /// How long to wait for a conductor.
    pub patience: Duration,
    /// Makes the producers in this process, should the run have to be made again; only a consumer needs it.
    pub remake: Option<Remake>,
    /// Starts another member beside this one, in the place of a lost one.
    pub host: Option<Host>,
}

/// Starts a member of a name, of so many traffic generators, in this process; whether it does.
pub type Host = Box<dyn Fn(&str, u32) -> bool + Send>;

/// Why a federate ended badly.
#[derive(Debug, thiserror::Error)]
pub enum MemberError {
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nobody answered.
    #[error(
        "{name}: no administration station answered at {endpoint} within {seconds} s: start one there (seeds admin-station), or check --sync-connect and --exercise"
    )]
    NoConductor {
        /// This federate.
        name: String,
        /// Endpoint.
        endpoint: String,
        /// Patience.
        seconds: u64,
    },
    /// The conductor said no.
    #[error("the administration station refused: {0}")]
    Refused(String),
    /// The conductor is gone for good.
    #[error(
        "{name}: nothing was heard of the administration station for {seconds} s; this federate stands at frame {frame} and ends"
    )]
    ConductorLost {
        /// This federate.
        name: String,
        /// Frame executed.
        frame: u64,
        /// How long it was waited for.
        seconds: u64,
    },
    /// Its place was given to another process, by command: it is no failure.
    #[error("{name} goes on in the process of {to}")]
    Yielded {
        /// This federate.
        name: String,
        /// Whose process.
        to: String,
    },
    /// The federation goes on with another one.
    #[error("{name} is not taken back: {reason}")]
    Dismissed {
        /// This federate.
        name: String,
        /// Why.
        reason: String,
    },
}

const STATUS_EVERY_NS: u64 = 1_000_000_000;
const BEAT_EVERY: Duration = Duration::from_millis(100);
/// How often and how long a page of the log of the run is asked for.
const LOG_TRIES: u32 = 10;
const LOG_WITHIN: Duration = Duration::from_millis(1_000);
const PROBE_EVERY_NS: u64 = 300_000_000;
/// Probes of a run, at least: one that is lost is no word.
const PROBES: u32 = 8;
/// How old what a beat says may be.
const BEAT_FRESH_NS: u64 = 20_000_000;

/// Joins, executes what is granted, and returns the exit code that the conductor gave.
///
/// # Errors
/// [`MemberError`], one sentence each.
pub fn run(context: MemberContext, federate: Box<dyn Federate>) -> Result<u8, MemberError> {
    let MemberContext { name, scene_hash, bus, mut data, events, endpoint, patience, remake, host } =
        context;
    let (send, receive) = events;
    let kind = federate.kind();
    let (consumes, reads) = (federate.consumes(), federate.reads_pdus());

    let orders = send.clone();
    bus.subscribe(
        "ctl/order",
        Box::new(move |_, body| {
            let _ = orders.send(Event::Order(body.to_vec()));
        }),
    )?;
    if consumes {
        let reports = send.clone();
        let own = name.clone();
        bus.subscribe(
            "fed/*",
            Box::new(move |key, body| {
                let from = key.strip_prefix("fed/").unwrap_or(key);
                if from != own {
                    let _ = reports.send(Event::Report(from.to_owned(), body.to_vec()));
                }
            }),
        )?;
    }
    // Asked and answered beside the loop, which may be at a heavy frame.
    let voter = Arc::new(Mutex::new(Voter::default()));
    for pattern in ["ctl/beat", "beat/*"] {
        let beats = send.clone();
        let own = name.clone();
        let voter = Arc::clone(&voter);
        bus.subscribe(
            pattern,
            Box::new(move |key, body| {
                let from = key.strip_prefix("beat/").unwrap_or(CONDUCTOR);
                if from == CONDUCTOR {
                    voter.lock().unwrap_or_else(PoisonError::into_inner).beat(monotonic_ns());
                }
                if from != own {
                    let _ = beats.send(Event::Beat(from.to_owned(), body.to_vec()));
                }
            }),
        )?;
    }
    let wanted = send.clone();
    bus.serve(
        &format!("log/{name}"),
        Box::new(move |request| {
            let _ = wanted.send(Event::FetchWanted(request));
        }),
    )?;
    let votes = Arc::clone(&voter);
    bus.serve(
        &format!("candidate/{name}"),
        Box::new(move |request| match decode::<Candidacy>(&request.body) {
            Ok(ask) => {
                let mut voter = votes.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(voted) = voter.asked(monotonic_ns(), &ask) {
                    request.answer(encode(&voted));
                }
            }
            Err(e) => tracing::warn!("a station's question was dropped: {e}"),
        }),
    )?;
    let enrol = |accepted: &Accepted| {
        let mut voter = voter.lock().unwrap_or_else(PoisonError::into_inner);
        voter.enrol(accepted.fed, accepted.inc, accepted.epoch);
    };
    let wanted = send.clone();
    bus.serve(
        &format!("frames/{name}"),
        Box::new(move |request| {
            let _ = wanted.send(Event::RepairWanted(request));
        }),
    )?;

    let mut joining = Joining {
        hello: Hello {
            name: name.clone(),
            kind,
            pid: std::process::id(),
            host: super::process::host_name(),
            version: crate::runtime::build::IDENTITY.to_owned(),
            scene_hash,
            instance: super::process::random_id(),
            was: None,
        },
        endpoint: &endpoint,
        patience,
    };
    let Some(accepted) = joining.join(&*bus, &receive)? else { return Ok(0) };
    enrol(&accepted);
    bus.announce(&format!("alive/{name}/{}", accepted.inc))?;
    let alive = send.clone();
    watch_stations(&*bus, move |is| drop(alive.send(Event::ConductorAlive(is))))?;

    let mut member = Member::new(federate, &name, &accepted, monotonic_us);
    // One that takes no PDU in has nothing to hear there.
    if let Some(plane) = data.plane().filter(|_| reads) {
        member.hearing().on(plane);
    }
    let mut probing = Probing::default();
    let beating = Beating::start(Arc::clone(&bus), &name, member.pulse(), member.beat());
    let retained = Retained::default();
    let mut status = StatusKeeper::new(&name);
    let mut grace = Grace::new(accepted.fed);
    let mut effects = Vec::new();
    if accepted.enter.is_some() {
        let mut pages = |page| log_page(&*bus, &accepted, page);
        member.enter(&accepted, remake.as_ref(), &mut pages, &mut effects);
    }
    let code = 'run: loop {
        let now = monotonic_ns();
        let look = if consumes { now + LOOK_NS } else { u64::MAX }.min(probing.due());
        let next = member.deadline().unwrap_or(u64::MAX).min(status.due()).min(look);
        let wait = Duration::from_nanos(next.saturating_sub(now));
        let first = match receive.recv_timeout(wait) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break 'run 1,
        };
        let now = monotonic_ns();
        for event in first.into_iter().chain(receive.try_iter().take(256)) {
            match event {
                Event::Order(body) => match decode::<Numbered<Order>>(&body) {
                    Ok(order) => {
                        // Spectators see by the status whom they hear.
                        if order.body == Order::Muster {
                            status.due_now();
                        }
                        grace.heard(now, order.fed);
                        if kind.sends_pdus() {
                            probing.order(&order.body, now);
                        }
                        if consumes && matches!(order.body, Order::Finish { .. }) {
                            told(&name, member.hearing().finish());
                        }
                        member.order(now, order, &mut effects);
                    }
                    Err(e) => tracing::warn!("an order was dropped: {e}"),
                },
                Event::Beat(from, body) => match decode::<Beat>(&body) {
                    Ok(beat) => {
                        if from == CONDUCTOR {
                            grace.heard(now, beat.fed);
                        }
                        member.hear_beat(now, &from, &beat);
                    }
                    Err(e) => tracing::warn!("a beat of {from} was dropped: {e}"),
                },
                Event::Orders(body) => match decode(&body) {
                    Ok(fetched) => member.fetched_orders(now, fetched, &mut effects),
                    Err(e) => tracing::warn!("orders told again were dropped: {e}"),
                },
                Event::Reports(by, body) => match decode(&body) {
                    Ok(fetched) => member.fetched(now, &by, fetched, &mut effects),
                    Err(e) => tracing::warn!("reports told again were dropped: {e}"),
                },
                Event::FetchWanted(request) => match decode::<FetchOf>(&request.body) {
                    Ok(ask) => request.answer(encode(&member.fetch(&ask))),
                    Err(e) => tracing::warn!("a question for reports was dropped: {e}"),
                },
                Event::Report(from, body) => match decode::<Numbered<Report>>(&body) {
                    Ok(report) => member.report(now, &from, report, &mut effects),
                    Err(e) => tracing::warn!("a report of {from} was dropped: {e}"),
                },
                Event::Pdus(pdus) => member.pdus(now, pdus, &mut effects),
                Event::Dropped(reason, count) => status.dropped(reason, count),
                Event::Probe(producer, long) => member.hearing().probed(&producer, long),
                Event::Repaired(by, body) => match decode(&body) {
                    Ok(repaired) => member.repaired(now, &by, repaired, &mut effects),
                    Err(e) => tracing::warn!("a repair was dropped: {e}"),
                },
                Event::RepairWanted(request) => match decode(&request.body) {
                    Ok(repair) => request.answer(encode(&member.repair(&repair))),
                    Err(e) => tracing::warn!("a repair request was dropped: {e}"),
                },
                Event::ConductorAlive(alive) => {
                    // One that appears may be that of another federation: what it tells says so.
                    if !alive {
                        grace.gone(now);
                        tracing::warn!(
                            "{name}: no connection to the administration station; standing at frame {}",
                            member.executed()
                        );
                    }
                }
                Event::Failed(reason) => {
                    member.fail(reason, &mut effects);
                }
                Event::Stop => break 'run 0,
            }
        }
        member.tick(now, &mut effects);
        told(&name, member.hearing().tick(now));
        if now >= probing.due() {
            probing.sent(now);
            data.probe(&name);
        }
        beating.refresh(now, || member.beat());
        let mut outcast = None;
        for effect in effects.drain(..) {
            match effect {
                Effect::Send(pdus) => data.send(&pdus),
                Effect::Report(report) => {
                    if let Report::Failed { reason } = &report.body {
                        tracing::error!("{name}: {reason}");
                    }
                    // The figures of the whole run are known now.
                    if matches!(report.body, Report::Final(_)) {
                        status.due_now();
                    }
                    bus.publish(&format!("fed/{name}"), Class::Must, encode(&report))?;
                }
                Effect::Repair { holder, of, repair } => {
                    let replies = send.clone();
                    let ask = match holder == CONDUCTOR {
                        true => encode(&RepairOf { of, repair }),
                        false => encode(&repair),
                    };
                    bus.request(
                        &format!("frames/{holder}"),
                        ask,
                        Duration::from_millis(500),
                        Box::new(move |reply| {
                            if let Some(body) = reply {
                                let _ = replies.send(Event::Repaired(holder.clone(), body));
                            }
                        }),
                    )?;
                }
                Effect::Fetch { holder, ask } => {
                    let replies = send.clone();
                    let orders = ask.of == CONDUCTOR;
                    bus.request(
                        &format!("log/{holder}"),
                        encode(&ask),
                        Duration::from_millis(500),
                        Box::new(move |reply| {
                            if let Some(body) = reply {
                                let _ = replies.send(match orders {
                                    true => Event::Orders(body),
                                    false => Event::Reports(holder.clone(), body),
                                });
                            }
                        }),
                    )?;
                }
                Effect::Host { name: lost, generators } => {
                    if host.as_ref().is_some_and(|host| host(&lost, generators)) {
                        tracing::warn!("{name}: takes the place of {lost}");
                    }
                }
                Effect::Rejoin(was) => outcast = Some(was),
                Effect::Dismissed(reason) => {
                    bus.close();
                    return Err(MemberError::Dismissed { name, reason });
                }
                Effect::Yielded(to) => {
                    bus.close();
                    return Err(MemberError::Yielded { name, to });
                }
                Effect::Publish(publication) => retained.publish(&*bus, publication)?,
                Effect::Exit(code) => break 'run code,
            }
        }
        if let Some(was) = outcast {
            tracing::warn!(
                "{name}: the federation went on without this process, which stands at frame {}; joining again",
                member.executed()
            );
            joining.hello.was = Some(was);
            joining.patience = Duration::from_nanos(GRACE_NS);
            let Some(accepted) = joining.join(&*bus, &receive)? else { break 'run 0 };
            enrol(&accepted);
            bus.announce(&format!("alive/{name}/{}", accepted.inc))?;
            let mut pages = |page| log_page(&*bus, &accepted, page);
            member.enter(&accepted, remake.as_ref(), &mut pages, &mut effects);
            beating.refresh(u64::MAX, || member.beat());
            grace = Grace::new(accepted.fed);
        }
        if now >= status.due() {
            let report = status.take(now, &mut member, &*data);
            bus.publish(&format!("obs/fed/{name}"), Class::Lossy, encode(&report))?;
        }
        if grace.is_over(now) {
            bus.close();
            return Err(MemberError::ConductorLost {
                name,
                frame: member.executed(),
                seconds: GRACE_NS / 1_000_000_000,
            });
        }
    };
    bus.close();
    Ok(code)
}

/// A page of the log of the run that a member returns to.
fn log_page(bus: &dyn Bus, accepted: &Accepted, page: u64) -> Result<LogPage, String> {
    let run = accepted.enter.as_ref().map_or(0, |enter| enter.config.run);
    let question = encode(&LogAsk { fed: accepted.fed, run, page });
    for _ in 0..LOG_TRIES {
        let answer = ask(bus, "log/run", question.clone(), LOG_WITHIN);
        if let Some(body) = answer.map_err(|e| e.to_string())? {
            return decode(&body).map_err(|e| e.to_string());
        }
    }
    Err(format!("page {page} of the log of the run was not answered"))
}

/// What a consumer does not hear is said where it runs; the administration station tells of it as well.
fn told(name: &str, words: Vec<String>) {
    for text in words {
        tracing::warn!("{name} {text}");
    }
}

/// When a producer probes the data plane: from its configuration on, and some times more once the run has begun, as others may
/// be configured long after it.
#[derive(Default)]
struct Probing {
    next: Option<u64>,
    sent: u32,
    begun: bool,
}

impl Probing {
    fn order(&mut self, order: &Order, now: u64) {
        match order {
            Order::Configure(_) => *self = Self { next: Some(now), ..Self::default() },
            Order::Grant { .. } if !self.begun => (self.begun, self.sent) = (true, 0),
            Order::Finish { .. } => self.next = None,
            _ => {}
        }
    }

    fn due(&self) -> u64 {
        self.next.unwrap_or(u64::MAX)
    }

    fn sent(&mut self, now: u64) {
        self.sent += 1;
        let over = self.begun && self.sent >= PROBES;
        self.next = (!over).then_some(now + PROBE_EVERY_NS);
    }
}

/// How this process asks to take part.
struct Joining<'a> {
    hello: Hello,
    endpoint: &'a str,
    patience: Duration,
}

impl Joining<'_> {
    /// Asks until accepted, refused, out of patience, or stopped (`None`). The same question gets the same
    /// answer, however late it comes.
    fn join(
        &self,
        bus: &dyn Bus,
        events: &Receiver<Event>,
    ) -> Result<Option<Accepted>, MemberError> {
        let hello = encode(&self.hello);
        let started = monotonic_ns();
        loop {
            let answer = ask(bus, "ctl/join", hello.clone(), Duration::from_millis(500))?;
            match answer.as_deref().map(decode::<Welcome>) {
                Some(Ok(Welcome::Accepted(accepted))) => return Ok(Some(*accepted)),
                Some(Ok(Welcome::Refused(why))) => return Err(MemberError::Refused(why)),
                Some(Ok(Welcome::NameTaken)) => {
                    let name = &self.hello.name;
                    return Err(MemberError::Refused(format!("the name '{name}' is taken")));
                }
                Some(Err(e)) => return Err(MemberError::Refused(e.to_string())),
                Some(Ok(Welcome::Later(_))) | None => {}
            }
            // What arrives before is told again: orders and reports are numbered, PDUs are repaired.
            if events.try_iter().any(|e| matches!(e, Event::Stop)) {
                return Ok(None);
            }
            if monotonic_ns() - started > self.patience.as_nanos() as u64 {
                return Err(MemberError::NoConductor {
                    name: self.hello.name.clone(),
                    endpoint: self.endpoint.to_owned(),
                    seconds: self.patience.as_secs(),
                });
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Says ten times a second that this process lives, also while the federate is at a heavy frame.
struct Beating {
    beat: Arc<Mutex<(u64, Beat)>>,
    ended: Arc<AtomicBool>,
}

impl Beating {
    fn start(bus: Arc<dyn Bus>, name: &str, pulse: Arc<Pulse>, first: Beat) -> Self {
        let beat = Arc::new(Mutex::new((0, first)));
        let ended = Arc::new(AtomicBool::new(false));
        let (of, end, key) = (Arc::clone(&beat), Arc::clone(&ended), format!("beat/{name}"));
        std::thread::spawn(move || {
            while !end.load(Ordering::Relaxed) {
                let mut beat = of.lock().unwrap_or_else(PoisonError::into_inner).1.clone();
                beat.working = pulse.working(monotonic_us());
                beat.utc_ns = utc_ns();
                if bus.publish(&key, Class::Lossy, encode(&beat)).is_err() {
                    return;
                }
                std::thread::sleep(BEAT_EVERY);
            }
        });
        Self { beat, ended }
    }

    /// Renews what the next beat says, unless that is fresh.
    fn refresh(&self, now: u64, beat: impl FnOnce() -> Beat) {
        let mut kept = self.beat.lock().unwrap_or_else(PoisonError::into_inner);
        if now >= kept.0.saturating_add(BEAT_FRESH_NS) {
            let at = if now == u64::MAX { kept.0 } else { now };
            *kept = (at, beat());
        }
    }
}

impl Drop for Beating {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

/// Last values, served to late joiners.
#[derive(Default)]
pub struct Retained(Arc<Mutex<BTreeMap<String, Vec<u8>>>>);

impl Retained {
    /// Publishes, and serves the last value where asked to.
    ///
    /// # Errors
    /// If the bus is closed.
    pub fn publish(&self, bus: &dyn Bus, publication: Publication) -> Result<(), BusError> {
        if let Some(key) = publication.retained {
            let mut values = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let first = values.insert(key.clone(), publication.body.clone()).is_none();
            drop(values);
            if first {
                let values = Arc::clone(&self.0);
                let served = key.clone();
                bus.serve(
                    &key,
                    Box::new(move |request| {
                        let body = values
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner)
                            .get(&served)
                            .cloned();
                        request.answer(body.unwrap_or_default());
                    }),
                )?;
            }
        }
        bus.publish(&publication.key, publication.class, publication.body)
    }
}

/// Gathers the statistics of this federate.
struct StatusKeeper {
    status: FederateStatus,
    usage: Usage,
    next: u64,
    dropped: BTreeMap<&'static str, u64>,
    overflow: Overflow,
}

impl StatusKeeper {
    fn new(name: &str) -> Self {
        let status = FederateStatus {
            name: name.to_owned(),
            pid: std::process::id(),
            host: super::process::host_name(),
            ..Default::default()
        };
        Self {
            status,
            usage: Usage::default(),
            next: 0,
            dropped: BTreeMap::new(),
            overflow: Overflow::default(),
        }
    }

    fn due(&self) -> u64 {
        self.next
    }

    fn due_now(&mut self) {
        self.next = 0;
    }

    fn dropped(&mut self, reason: &'static str, count: u64) {
        *self.dropped.entry(reason).or_default() += count;
    }

    fn take(&mut self, now: u64, member: &mut Member, data: &dyn DataPlane) -> FederateStatus {
        self.next = now + STATUS_EVERY_NS;
        self.usage.sample(now);
        let exec = member.take_exec();
        let counters = member.counters();
        let mut status = FederateStatus {
            frame: member.executed(),
            cpu_s: self.usage.cpu_s,
            cpu_pct: self.usage.cpu_pct,
            rss_bytes: self.usage.rss_bytes,
            host_busy_pct: self.usage.host_busy_pct,
            host_cores: self.usage.host_cores,
            pdus_in: counters.received + counters.outsiders,
            pdus_out: counters.sent,
            lost: counters.lost,
            repaired: counters.repaired,
            exec_us: exec.sum_us as f64 / exec.steps.max(1) as f64,
            exec_max_us: exec.max_us as f64,
            dropped: self.dropped.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect(),
            ..self.status.clone()
        };
        if data.refused() > 0 {
            status.dropped.push(("not sent: refused by the kernel".into(), data.refused()));
        }
        if data.kernel_drops() > 0 {
            status.dropped.push(("receive buffer full".into(), data.kernel_drops()));
        }
        member.federate().status(&mut status);
        let (drops, buffer) = (data.kernel_drops(), data.buffer_octets());
        let word = self.overflow.look(now, drops, buffer, data.plane().as_ref());
        told(&status.name, word.into_iter().collect());
        let alarms = member.hearing().alarms().chain(self.overflow.alarm());
        status.alarms = alarms.map(str::to_owned).collect();
        status.alarms.extend(member.unheard().map(str::to_owned));
        status
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::local_bus::LocalHub;

    #[test]
    fn a_beat_tells_the_time_of_its_host() {
        let hub = LocalHub::default();
        let (member, station) = (hub.join(), hub.join());
        let (heard, beats) = crossbeam_channel::unbounded();
        let sink = move |_: &str, octets: &[u8]| drop(heard.send(octets.to_vec()));
        station.subscribe("beat/*", Box::new(sink)).expect("heard");
        let before = utc_ns();
        let _beating = Beating::start(Arc::new(member), "x", Arc::default(), Beat::default());
        let beats: Vec<Beat> =
            beats.iter().take(3).map(|octets| decode(&octets).expect("a beat")).collect();
        let times: Vec<i64> = beats.iter().map(|beat| beat.utc_ns).collect();
        assert!(times.is_sorted() && times[0] >= before && times[2] <= utc_ns(), "{times:?}");
        assert!(times[2] > times[0], "each its own");
    }
}
