//! The viewer-logger on a bus and a data plane: joins as a spectator, listens, keeps, shows, and leaves with the run.
//!
//! It reads only what may be lost and never holds anybody back: what comes faster than it can keep is
//! dropped here, counted, and told at the end.

use super::Viewer;
use super::detection::Maps;
use super::keeper::{Files, Heard, Keeper, Kept};
use super::said::Topic;
use super::server::{Operate, Page, Server, serve};
use crate::exchange::operator;
use crate::runtime::bus::{Bus, BusError, Class, ask, hear_parts, watch_stations};
use crate::runtime::clock::{monotonic_ns, utc_ns};
use crate::runtime::codec::{decode, encode};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{Command, FederateStatus, Kind, Numbered, Report, ScanReport};
use crate::runtime::process::{Usage, host_name};
use crate::runtime::spectator::{Joined, Spectator, hear, last};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded};
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What the viewer-logger is to do.
#[derive(Clone, Debug)]
pub struct Task {
    /// Its name in the federation.
    pub name: String,
    /// Address of the page; none for a logger alone.
    pub page: Option<SocketAddr>,
    /// What to keep.
    pub files: Files,
    /// How long to look for an administration station.
    pub patience: Duration,
    /// How it is reached, for messages to people.
    pub endpoint: String,
}

/// A datagram as it arrived.
#[derive(Clone, Debug)]
pub struct Datagram {
    /// UTC of arrival, ns since 1970.
    pub utc_ns: i64,
    /// Sender.
    pub from: SocketAddr,
    /// Where it was sent to.
    pub to: SocketAddr,
    /// What it carried.
    pub octets: Box<[u8]>,
}

/// What reaches the viewer-logger.
#[derive(Debug)]
enum Event {
    Heard(Heard),
    Datagrams(Vec<Datagram>),
    ConductorAlive(bool),
    Stop,
}

/// Where others put what reaches the viewer-logger. Never blocks.
#[derive(Clone, Debug)]
pub struct Inbox {
    send: Sender<Event>,
    receive: Receiver<Event>,
    lost: Arc<AtomicU64>,
}

impl Default for Inbox {
    fn default() -> Self {
        let (send, receive) = bounded(WAITING);
        Self { send, receive, lost: Arc::default() }
    }
}

impl Inbox {
    /// Datagrams that arrived together.
    pub fn datagrams(&self, datagrams: Vec<Datagram>) {
        let count = datagrams.len() as u64;
        if matches!(self.send.try_send(Event::Datagrams(datagrams)), Err(TrySendError::Full(_))) {
            self.lost.fetch_add(count, Ordering::Relaxed);
        }
    }

    /// Datagrams that the system dropped before anybody saw them, in all.
    pub fn dropped(&self, before: u64, now: u64) {
        self.lost.fetch_add(now.saturating_sub(before), Ordering::Relaxed);
    }

    /// The operator of this process wants it to end.
    pub fn stop(&self) {
        self.send.send_timeout(Event::Stop, Duration::from_secs(1)).ok();
    }

    /// Takes what a message is made into.
    fn taking<T, F: Fn(T) -> Heard>(&self, heard: F) -> impl Fn(T) + use<T, F> {
        let inbox = self.clone();
        move |message| inbox.heard(heard(message))
    }

    fn heard(&self, heard: Heard) {
        self.send.try_send(Event::Heard(heard)).ok(); // a scan that is lost here is missed by its number
    }
}

/// Takes part until the run is over. Returns what was kept; none if it was stopped before it joined.
///
/// # Errors
/// If the page or a file cannot be made, nobody answers, or the administration station refuses.
pub fn run(
    task: &Task,
    scene: Arc<Scene>,
    bus: Arc<dyn Bus>,
    inbox: Inbox,
    told: impl FnOnce(Option<&Server>),
) -> anyhow::Result<Option<Kept>> {
    let page = task.page.map(|_| Page::new(Viewer::new(HISTORY)));
    if let Some(page) = &page {
        page.update(|viewer| viewer.show_detection(Maps::of(Arc::clone(&scene))));
    }
    let server = open_page(task, page.as_ref(), &bus)?;
    let mut keeper = Keeper::open(Arc::clone(&scene), page, &task.files)?;
    subscribe(&*bus, &inbox)?;
    let spectator = Spectator {
        name: &task.name,
        kind: Kind::ViewerLogger,
        scene_hash: scene.hash,
        patience: task.patience,
        endpoint: &task.endpoint,
    };
    // What arrives before the run begins is heard again as last values; only a stop counts.
    let stopped = |wait| matches!(inbox.receive.recv_timeout(wait), Ok(Event::Stop));
    let Some(Joined { name, fed, inc }) = spectator.join(&*bus, stopped)? else {
        keeper.close(0);
        return Ok(None);
    };
    bus.announce(&format!("alive/{name}/{inc}"))?;
    let alive = inbox.clone();
    watch_stations(&*bus, move |is| {
        alive.send.try_send(Event::ConductorAlive(is)).ok();
    })?;
    last_values(&*bus, &inbox)?;
    told(server.as_ref());
    let mut listening = Listening::new(&name, fed, inc);
    listening.until_the_end(&mut keeper, &*bus, &inbox);
    let kept = keeper.close(inbox.lost.load(Ordering::Relaxed));
    if let Some(server) = server {
        server.stop();
    }
    Ok(Some(kept))
}

fn open_page(
    task: &Task,
    page: Option<&Arc<Page>>,
    bus: &Arc<dyn Bus>,
) -> anyhow::Result<Option<Server>> {
    let (Some(address), Some(page)) = (task.page, page) else { return Ok(None) };
    let (bus, endpoint) = (Arc::clone(bus), task.endpoint.clone());
    let door = Arc::clone(&bus);
    page.let_speak(Arc::new(move |order| operator::at_seat(&*door, order)));
    let operate: Operate = Box::new(move |_, order| operate_run(&*bus, &endpoint, order));
    Ok(Some(serve(address, Arc::clone(page), operate)?))
}

/// Asks the administration station and waits for the state reached.
fn operate_run(bus: &dyn Bus, endpoint: &str, order: Command) -> (bool, String) {
    match operator::command(bus, endpoint, "page", order) {
        Ok(answer) => (answer.ok, answer.text),
        Err(error) => (false, error.to_string()),
    }
}

fn subscribe(bus: &dyn Bus, inbox: &Inbox) -> Result<(), BusError> {
    hear_parts(bus, "tracks/1/scan", inbox.taking(|scan: ScanReport| Heard::Scan(Box::new(scan))))?;
    hear(bus, "obs/state", inbox.taking(Heard::State))?;
    hear(bus, "obs/outcome", inbox.taking(Heard::Outcome))?;
    hear(bus, "obs/fed/*", inbox.taking(Heard::Federate))?;
    hear(bus, "obs/weather", inbox.taking(Heard::Weather))?;
    hear(bus, "obs/flights", inbox.taking(Heard::Flights))?;
    hear(bus, "obs/foreign", inbox.taking(Heard::Foreign))?;
    hear(bus, "control/1/alerts", inbox.taking(Heard::Alerts))?;
    hear(bus, "control/1/seats", inbox.taking(Heard::Seats))?;
    hear(bus, "obs/inputs", inbox.taking(Heard::Inputs))?;
    hear_text(bus, "obs/driven", Topic::Driven, inbox)?;
    hear_text(bus, "obs/traffic", Topic::Traffic, inbox)?;
    hear_text(bus, "control/1/lights", Topic::Lights, inbox)?;
    hear_text(bus, "control/1/positions", Topic::Seats, inbox)?;
    hear(bus, "obs/operation", inbox.taking(Heard::Operation))
}

/// Hears what is said as JSON.
fn hear_text(bus: &dyn Bus, key: &str, topic: Topic, inbox: &Inbox) -> Result<(), BusError> {
    let inbox = inbox.clone();
    let sink = move |_: &str, octets: &[u8]| match std::str::from_utf8(octets) {
        Ok(text) if octets.len() <= MOST_TEXT => inbox.heard(Heard::Said(topic, text.to_owned())),
        _ => tracing::warn!(topic = topic.word(), octets = octets.len(), "a message was dropped"),
    };
    bus.subscribe(key, Box::new(sink))
}

/// Asks for what was said before this process listened.
fn last_values(bus: &dyn Bus, inbox: &Inbox) -> Result<(), BusError> {
    last(bus, "obs/state/last", inbox.taking(Heard::State))?;
    last(bus, "obs/weather/last", inbox.taking(Heard::Weather))?;
    last(bus, "obs/flights/last", inbox.taking(Heard::Flights))?;
    for (key, topic) in
        [("control/1/lights/last", Topic::Lights), ("control/1/positions/last", Topic::Seats)]
    {
        if let Some(octets) = ask(bus, key, Vec::new(), LIGHTS_WITHIN)?
            && let Ok(text) = String::from_utf8(octets)
        {
            inbox.heard(Heard::Said(topic, text));
        }
    }
    if let Some(octets) = ask(bus, "control/1/alerts/last", Vec::new(), LIGHTS_WITHIN)?
        && let Ok(alerts) = decode(&octets)
    {
        inbox.heard(Heard::Alerts(alerts));
    }
    Ok(())
}

/// The loop and its counters.
struct Listening {
    name: String,
    fed: u128,
    inc: u64,
    /// Federates that this process hears; told to the conductor, which waits for a complete log.
    hears: BTreeSet<String>,
    usage: Usage,
    told_ns: u64,
    pdus: u64,
    dropped: BTreeMap<&'static str, u64>,
    busy_ns: u64,
    steps: u64,
    longest_ns: u64,
}

impl Listening {
    fn new(name: &str, fed: u128, inc: u64) -> Self {
        Self {
            name: name.to_owned(),
            fed,
            inc,
            hears: BTreeSet::new(),
            usage: Usage::default(),
            told_ns: 0,
            pdus: 0,
            dropped: BTreeMap::new(),
            busy_ns: 0,
            steps: 0,
            longest_ns: 0,
        }
    }

    fn until_the_end(&mut self, keeper: &mut Keeper, bus: &dyn Bus, inbox: &Inbox) {
        let mut alone_since = None;
        loop {
            let event = inbox.receive.recv_timeout(Duration::from_millis(250));
            let began = monotonic_ns();
            match event {
                Ok(Event::Heard(heard)) => {
                    self.present(&heard, bus);
                    keeper.hear(heard, utc_ns());
                }
                Ok(Event::Datagrams(datagrams)) => self.datagrams(keeper, &datagrams),
                Ok(Event::ConductorAlive(alive)) => alone_since = (!alive).then_some(began),
                Ok(Event::Stop) => break,
                Err(RecvTimeoutError::Timeout) => keeper.flush(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            // Whatever still arrives: others on the network may go on for ever.
            if let Some(since) = alone_since {
                let stopped = keeper.state().is_some_and(|s| s.phase == Phase::Stopped);
                let grace_ns = if stopped { LATE_NS } else { GRACE_NS };
                if began.saturating_sub(since) >= grace_ns {
                    if !stopped {
                        tracing::warn!("the administration station is gone; the log ends here");
                    }
                    break;
                }
            }
            let took = monotonic_ns() - began;
            self.steps += 1;
            self.busy_ns += took;
            self.longest_ns = self.longest_ns.max(took);
            if began - self.told_ns >= STATUS_NS || self.told_ns == 0 {
                self.tell(keeper, bus, inbox, began);
            }
        }
        // What had arrived by then belongs to the run.
        for event in inbox.receive.try_iter().take(WAITING) {
            match event {
                Event::Heard(heard) => keeper.hear(heard, utc_ns()),
                Event::Datagrams(datagrams) => self.datagrams(keeper, &datagrams),
                Event::ConductorAlive(_) | Event::Stop => {}
            }
        }
    }

    /// Says whom this process hears, whenever that changes.
    fn present(&mut self, heard: &Heard, bus: &dyn Bus) {
        let Heard::Federate(status) = heard else { return };
        if self.hears.len() < HEARD && self.hears.insert(status.name.clone()) {
            let hears = self.hears.iter().cloned().collect();
            let body = Report::Present { hears, consumes: false };
            let present = Numbered { fed: self.fed, inc: self.inc, seq: 0, body };
            bus.publish(&format!("fed/{}", self.name), Class::Must, encode(&present)).ok();
        }
    }

    fn datagrams(&mut self, keeper: &mut Keeper, datagrams: &[Datagram]) {
        for d in datagrams {
            keeper.datagram(d.utc_ns, d.from, d.to, &d.octets);
            for pdu in pdu::pdus(&d.octets) {
                match pdu {
                    Ok(_) => self.pdus += 1,
                    Err(_) => *self.dropped.entry("not a sound PDU").or_default() += 1,
                }
            }
        }
    }

    /// Tells the federation how this process does.
    fn tell(&mut self, keeper: &mut Keeper, bus: &dyn Bus, inbox: &Inbox, now_ns: u64) {
        self.told_ns = now_ns;
        keeper.flush();
        self.usage.sample(now_ns);
        let status = FederateStatus {
            name: self.name.clone(),
            pid: std::process::id(),
            host: host_name(),
            frame: keeper.state().map_or(0, |s| s.frame),
            cpu_s: self.usage.cpu_s,
            cpu_pct: self.usage.cpu_pct,
            rss_bytes: self.usage.rss_bytes,
            pdus_in: self.pdus,
            lost: inbox.lost.load(Ordering::Relaxed),
            dropped: self.dropped.iter().map(|(r, n)| ((*r).to_owned(), *n)).collect(),
            exec_us: self.busy_ns as f64 / 1000.0 / self.steps.max(1) as f64,
            exec_max_us: self.longest_ns as f64 / 1000.0,
            ..FederateStatus::default()
        };
        if let Err(error) =
            bus.publish(&format!("obs/fed/{}", self.name), Class::Lossy, encode(&status))
        {
            tracing::debug!(%error, "the status was not told");
        }
        keeper.hear(Heard::Federate(status), utc_ns());
    }
}

/// Events that may wait: some seconds of a busy run.
const WAITING: usize = 65_536;
/// Longest message of JSON that is taken, octets.
const MOST_TEXT: usize = 4 << 20;
/// Scans kept for looking back, octets.
const HISTORY: usize = 256 << 20;
/// Federates whose names are kept, at most: anybody on the bus may say one.
const HEARD: usize = 1024;
const STATUS_NS: u64 = 1_000_000_000;
/// How long the federate of control is asked for its lights; most scenes have none.
const LIGHTS_WITHIN: Duration = Duration::from_millis(200);
/// How long what was sent before the end may be on its way.
const LATE_NS: u64 = 250_000_000;
/// How long a run may be without its administration station.
const GRACE_NS: u64 = 10_000_000_000;

#[cfg(test)]
mod tests;
