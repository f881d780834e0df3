//! The gateway on a bus: joins as a spectator, listens, sends, and leaves with the run.

use super::{Choice, Gateway};
use crate::runtime::bus::{Bus, BusError, Class, ask, hear_parts};
use crate::runtime::clock::{monotonic_ns, utc_ns};
use crate::runtime::codec::{decode, encode};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{
    FederateStatus, FlightNotice, Hello, Kind, Numbered, Report, RunState, ScanReport,
    WeatherNotice, Welcome,
};
use crate::runtime::process::{Usage, host_name, random_id};
use anyhow::Context;
use capture::Recorder;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use datalink::LinkConfig;
use scenarios::Scene;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// What the gateway is to do.
#[derive(Clone, Debug)]
pub struct Task {
    /// Where ASTERIX goes.
    pub to: Vec<LinkConfig>,
    /// What is sent.
    pub choice: Choice,
    /// Times of day are those of the wall clock, not of the scene.
    pub wall: bool,
    /// Every datagram sent, as pcapng.
    pub recording: Option<PathBuf>,
    /// How long to look for an administration station.
    pub patience: Duration,
    /// How it is reached, for messages to people.
    pub endpoint: String,
}

/// Its name in the federation.
pub const NAME: &str = "gateway";

/// What was sent and what was not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    /// Scans that were sent.
    pub scans: u64,
    /// Scans that never arrived.
    pub scans_lost: u64,
    /// Datagrams to each receiver.
    pub datagrams: u64,
    /// Datagrams that the system did not take, or the recording.
    pub datagrams_lost: u64,
    /// Records that could not be written.
    pub records_refused: u64,
    /// Constant added to the scene's time of day, ns.
    pub shift_ns: i64,
}

impl Sent {
    /// Whether nothing is missing.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.scans_lost == 0 && self.datagrams_lost == 0 && self.records_refused == 0
    }
}

#[derive(Debug)]
enum Event {
    Scan(Box<ScanReport>),
    State(RunState),
    Weather(WeatherNotice),
    Flights(Vec<FlightNotice>),
    Federate(String),
    ConductorAlive(bool),
    Stop,
}

/// Where others put what reaches the gateway. Never blocks.
#[derive(Clone, Debug)]
pub struct Inbox {
    send: Sender<Event>,
    receive: Receiver<Event>,
}

impl Default for Inbox {
    fn default() -> Self {
        let (send, receive) = bounded(WAITING);
        Self { send, receive }
    }
}

impl Inbox {
    /// The operator of this process wants it to end.
    pub fn stop(&self) {
        self.send.send_timeout(Event::Stop, Duration::from_secs(1)).ok();
    }

    fn put(&self, event: Event) {
        self.send.try_send(event).ok(); // a scan that is lost here is missed by its number
    }
}

/// Takes part until the run is over; `None` if it was stopped before it joined.
///
/// # Errors
/// If a port or a file cannot be opened, nobody answers, or the administration station refuses.
pub fn run(
    task: &Task,
    scene: &Scene,
    bus: &dyn Bus,
    inbox: &Inbox,
) -> anyhow::Result<Option<Sent>> {
    let mut port = Port::open(task)?;
    let mut gateway = Gateway::new(scene, task.choice.clone());
    let scans = inbox.clone();
    hear_parts(bus, "tracks/1/scan", move |scan| scans.put(Event::Scan(Box::new(scan))))?;
    hear(bus, inbox, "obs/state", Event::State)?;
    hear(bus, inbox, "obs/weather", Event::Weather)?;
    hear(bus, inbox, "obs/flights", Event::Flights)?;
    hear(bus, inbox, "obs/fed/*", |status: FederateStatus| Event::Federate(status.name))?;
    let Some((name, fed, inc)) = join(task, scene, bus, inbox)? else { return Ok(None) };
    bus.announce(&format!("alive/{name}/{inc}"))?;
    let alive = inbox.clone();
    bus.watch(
        "alive/admin-station/*",
        Box::new(move |_, is| alive.put(Event::ConductorAlive(is))),
    )?;
    // What was said before this process listened.
    last(bus, inbox, "obs/state/last", Event::State)?;
    last(bus, inbox, "obs/weather/last", Event::Weather)?;
    last(bus, inbox, "obs/flights/last", Event::Flights)?;
    listen(task, &mut gateway, &mut port, bus, inbox, (&name, fed, inc));
    port.close();
    port.sent.scans_lost = gateway.scans_lost();
    port.sent.records_refused = gateway.refused().values().sum();
    for (reason, count) in gateway.refused() {
        tracing::warn!("{count} records were not written: {reason}");
    }
    Ok(Some(port.sent))
}

fn hear<T: DeserializeOwned>(
    bus: &dyn Bus,
    inbox: &Inbox,
    pattern: &str,
    event: impl Fn(T) -> Event + Send + Sync + 'static,
) -> Result<(), BusError> {
    let inbox = inbox.clone();
    let sink = move |key: &str, octets: &[u8]| match decode(octets) {
        Ok(message) => inbox.put(event(message)),
        Err(error) => tracing::warn!(key, %error, "a message was dropped"),
    };
    bus.subscribe(pattern, Box::new(sink))
}

fn last<T: DeserializeOwned>(
    bus: &dyn Bus,
    inbox: &Inbox,
    key: &str,
    event: impl Fn(T) -> Event,
) -> Result<(), BusError> {
    if let Some(octets) = ask(bus, key, Vec::new(), Duration::from_millis(500))?
        && let Ok(message) = decode(&octets)
    {
        inbox.put(event(message));
    }
    Ok(())
}

fn join(
    task: &Task,
    scene: &Scene,
    bus: &dyn Bus,
    inbox: &Inbox,
) -> anyhow::Result<Option<(String, u128, u64)>> {
    let mut hello = Hello {
        name: NAME.to_owned(),
        kind: Kind::Gateway,
        pid: std::process::id(),
        host: host_name(),
        version: crate::runtime::build::IDENTITY.to_owned(),
        scene_hash: scene.hash,
        instance: random_id(),
        was: None,
    };
    let started = monotonic_ns();
    let mut instance = 1;
    loop {
        let answer = ask(bus, "ctl/join", encode(&hello), Duration::from_millis(500))?;
        match answer.as_deref().map(decode::<Welcome>) {
            Some(Ok(Welcome::Accepted(accepted))) => {
                return Ok(Some((hello.name, accepted.fed, accepted.inc)));
            }
            Some(Ok(Welcome::NameTaken)) if instance < INSTANCES => {
                instance += 1;
                hello.name = format!("{NAME}-{instance}");
                continue;
            }
            Some(Ok(Welcome::NameTaken)) => {
                anyhow::bail!("{INSTANCES} gateways are in this federation already: end one")
            }
            Some(Ok(Welcome::Refused(why))) => {
                anyhow::bail!("the administration station refused: {why}")
            }
            Some(Err(error)) => anyhow::bail!("the administration station refused: {error}"),
            Some(Ok(Welcome::Later(_))) | None => {}
        }
        anyhow::ensure!(
            monotonic_ns() - started < task.patience.as_nanos() as u64,
            "{NAME}: no administration station answered at {} within {} s: start one there (seeds admin-station), or check --sync-connect and --exercise",
            task.endpoint,
            task.patience.as_secs()
        );
        if let Ok(Event::Stop) = inbox.receive.recv_timeout(Duration::from_millis(20)) {
            return Ok(None);
        }
    }
}

fn listen(
    task: &Task,
    gateway: &mut Gateway,
    port: &mut Port,
    bus: &dyn Bus,
    inbox: &Inbox,
    (own, fed, inc): (&str, u128, u64),
) {
    let mut hears = BTreeSet::new();
    let (mut alone_since, mut state, mut told_ns) = (None, RunState::default(), 0);
    let mut usage = Usage::default();
    let mut shifted = !task.wall;
    loop {
        let event = inbox.receive.recv_timeout(Duration::from_millis(250));
        let now_ns = monotonic_ns();
        match event {
            Ok(Event::Scan(scan)) => {
                if !shifted {
                    port.sent.shift_ns = gateway.shift_to(scan.time_ns, utc_ns());
                    shifted = true;
                }
                port.send(&gateway.on_scan(&scan));
            }
            Ok(Event::State(now)) => state = now,
            Ok(Event::Weather(notice)) => gateway.on_weather(notice),
            Ok(Event::Flights(entries)) => gateway.on_flights(entries),
            Ok(Event::Federate(name)) => {
                // The conductor waits with the first frame until this process hears the others.
                if hears.len() < HEARD && hears.insert(name) {
                    let hears = hears.iter().cloned().collect();
                    let body = Report::Present { hears, consumes: false };
                    let present = Numbered { fed, inc, seq: 0, body };
                    bus.publish(&format!("fed/{own}"), Class::Must, encode(&present)).ok();
                }
            }
            Ok(Event::ConductorAlive(alive)) => alone_since = (!alive).then_some(now_ns),
            Ok(Event::Stop) | Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                let stopped = state.phase == Phase::Stopped;
                let grace_ns = if stopped { 0 } else { GRACE_NS };
                if alone_since.is_some_and(|since| now_ns - since >= grace_ns) {
                    if !stopped {
                        tracing::warn!("the administration station is gone; sending ends here");
                    }
                    break;
                }
            }
        }
        if now_ns - told_ns >= STATUS_NS || told_ns == 0 {
            told_ns = now_ns;
            usage.sample(now_ns);
            let status = FederateStatus {
                name: own.to_owned(),
                pid: std::process::id(),
                host: host_name(),
                frame: state.frame,
                cpu_s: usage.cpu_s,
                cpu_pct: usage.cpu_pct,
                rss_bytes: usage.rss_bytes,
                pdus_out: port.sent.datagrams,
                lost: gateway.scans_lost(),
                dropped: gateway.refused().iter().map(|(r, n)| (r.clone(), *n)).collect(),
                ..FederateStatus::default()
            };
            bus.publish(&format!("obs/fed/{own}"), Class::Lossy, encode(&status)).ok();
        }
    }
    // What had arrived by then belongs to the run.
    for event in inbox.receive.try_iter() {
        if let Event::Scan(scan) = event {
            port.send(&gateway.on_scan(&scan));
        }
    }
}

/// Sockets and recording.
struct Port {
    senders: Vec<datalink::Sender>,
    recorder: Option<Recorder>,
    from: SocketAddr,
    to: SocketAddr,
    sent: Sent,
    complained: bool,
}

impl Port {
    fn open(task: &Task) -> anyhow::Result<Self> {
        let mut senders = Vec::new();
        for link in &task.to {
            let sender = datalink::Sender::open(link)
                .with_context(|| format!("--asterix {}", link.to.first()))?;
            senders.push(sender);
        }
        let recorder = match &task.recording {
            Some(file) => Some(
                Recorder::create(file).with_context(|| format!("recording {}", file.display()))?,
            ),
            None => None,
        };
        let own = senders.first().and_then(|s| s.address().ok());
        let nowhere = SocketAddr::from(([127, 0, 0, 1], 0));
        let to = task.to.first().map_or(nowhere, |link| link.to.first());
        let from = own.filter(|from| from.is_ipv4() == to.is_ipv4()).unwrap_or(nowhere);
        Ok(Self { senders, recorder, from, to, sent: Sent::default(), complained: false })
    }

    fn send(&mut self, datagrams: &[Vec<u8>]) {
        self.sent.scans += 1;
        for datagram in datagrams {
            self.sent.datagrams += 1;
            for sender in &mut self.senders {
                if let Err(error) = sender.send(datagram).and_then(|()| sender.flush()) {
                    self.sent.datagrams_lost += 1;
                    if !self.complained {
                        self.complained = true;
                        tracing::warn!("sending ASTERIX: {error}");
                    }
                }
            }
            if let Some(recorder) = &mut self.recorder
                && let Err(error) = recorder.record(utc_ns(), self.from, self.to, datagram)
            {
                tracing::error!("{error}");
            }
        }
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = recorder.flush()
        {
            tracing::error!("{error}");
        }
    }

    fn close(&mut self) {
        if let Some(recorder) = self.recorder.take() {
            self.sent.datagrams_lost += recorder.lost();
            if let Err(error) = recorder.close(0) {
                tracing::error!("{error}");
            }
        }
    }
}

/// Events that may wait: some minutes of a run.
const WAITING: usize = 4096;
/// Names of federates that are told to the conductor; a federation has far fewer.
const HEARD: usize = 256;
/// Gateways that a federation may have.
const INSTANCES: u32 = 16;
const STATUS_NS: u64 = 1_000_000_000;
/// How long a run may be without its administration station.
const GRACE_NS: u64 = 10_000_000_000;
