//! The gateway on a bus: joins as a spectator, listens, sends, and leaves with the run.

use super::alerts::still_standing;
use super::board::Board;
use super::listen::{ForeignEar, HeardLink};
use super::ports::{Feeds, Ports};
use super::{Choice, Gateway};
use crate::exchange::stands::Stands;
use crate::federation::GATEWAY as NAME;
use crate::runtime::bus::{Bus, BusError, Class, ask, hear_parts, watch_stations};
use crate::runtime::clock::{monotonic_ns, utc_ns};
use crate::runtime::codec::{decode, encode};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{
    AlertMessage, FederateStatus, FlightNotice, Kind, Numbered, Operation, Report, RunState,
    ScanReport, SeatMessage, WeatherNotice,
};
use crate::runtime::process::{Usage, host_name};
use crate::runtime::spectator::{Joined, Spectator, hear, last};
use anyhow::Context;
use capture::Recorder;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use datalink::LinkConfig;
use models::frames::Point2;
use scenarios::Scene;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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
    /// Ports beside ASTERIX.
    pub feeds: Feeds,
    /// Where tracks of others are heard.
    pub hear: Vec<HeardLink>,
    /// DIS exercise.
    pub exercise: u8,
    /// Every datagram sent, as pcapng.
    pub recording: Option<PathBuf>,
    /// Started with the run, by its launcher.
    pub from_begin: bool,
    /// How long to look for an administration station.
    pub patience: Duration,
    /// How it is reached, for messages to people.
    pub endpoint: String,
}

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
    /// Figures of the other ports.
    pub ports: serde_json::Value,
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
    Scan(Arc<ScanReport>),
    State(RunState),
    Weather(WeatherNotice),
    Flights(Vec<FlightNotice>),
    Operation(Operation),
    Alerts(Vec<AlertMessage>),
    Lights(Latest),
    Traffic(Latest),
    Inputs(Vec<SeatMessage>),
    Federate(Box<FederateStatus>),
    ConductorAlive(bool),
    Stop,
}

/// A text of which only the latest matters: it takes the place of one that waits, so that a gateway that stands still keeps one.
#[derive(Clone, Debug, Default)]
struct Latest(Arc<Mutex<Option<String>>>);

impl Latest {
    fn slot(&self) -> MutexGuard<'_, Option<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts one there; nobody is told where one waits already, or where `tell` cannot.
    fn put(&self, text: &str, tell: impl Fn(Self) -> bool) {
        let waits = self.slot().replace(text.to_owned()).is_some();
        if !waits && !tell(self.clone()) {
            self.take();
        }
    }

    fn take(&self) -> Option<String> {
        self.slot().take()
    }
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

    /// Puts what a message is made into.
    fn taking<T, F: Fn(T) -> Event>(&self, event: F) -> impl Fn(T) + use<T, F> {
        let inbox = self.clone();
        move |message| inbox.put(event(message))
    }

    fn put(&self, event: Event) {
        self.offer(event); // a scan that is lost here is missed by its number
    }

    /// Whether there was room.
    fn offer(&self, event: Event) -> bool {
        self.send.try_send(event).is_ok()
    }

    /// Waits for the operator's word, and passes over what else comes meanwhile; whether it came.
    fn passes_over(&self, wait: Duration) -> bool {
        match self.receive.recv_timeout(wait) {
            Ok(Event::Stop) => true,
            Ok(Event::Lights(latest) | Event::Traffic(latest)) => {
                // The next text is told of again.
                latest.take();
                false
            }
            _ => false,
        }
    }

    /// Puts what is said in texts of at most so many octets, the latest of them.
    fn latest(&self, most: usize, event: fn(Latest) -> Event) -> impl Fn(&[u8]) + Clone + use<> {
        let (inbox, latest) = (self.clone(), Latest::default());
        move |octets| {
            if octets.len() <= most
                && let Ok(text) = std::str::from_utf8(octets)
            {
                latest.put(text, |latest| inbox.offer(event(latest)));
            }
        }
    }
}

/// Takes part until the run is over; `None` if it was stopped before it joined. `places` is told where its ports are.
///
/// # Errors
/// If a port or a file cannot be opened, nobody answers, or the administration station refuses.
pub fn run(
    task: &Task,
    scene: &Scene,
    bus: &dyn Bus,
    inbox: &Inbox,
    places: impl FnOnce(&[String]),
) -> anyhow::Result<Option<Sent>> {
    let mut port = Port::open(task)?;
    let ear = match task.hear.is_empty() {
        true => None,
        false => Some(ForeignEar::open(&task.hear)?),
    };
    let board = Board::new(scene, task.exercise, task.feeds.invent).sending(task.feeds.adsb_from);
    let mut ports = Ports::open(&task.feeds, board)?;
    places(&ports.places());
    let mut gateway = Gateway::new(scene, task.choice.clone()).from_begin(task.from_begin);
    let put = |event: Event| inbox.put(event);
    hear_parts(bus, "tracks/1/scan", inbox.taking(|scan| Event::Scan(Arc::new(scan))))?;
    hear(bus, "obs/state", inbox.taking(Event::State))?;
    hear(bus, "obs/weather", inbox.taking(Event::Weather))?;
    hear(bus, "obs/flights", inbox.taking(Event::Flights))?;
    hear(bus, "obs/operation", inbox.taking(Event::Operation))?;
    hear(bus, "control/1/alerts", inbox.taking(Event::Alerts))?;
    let put_lights = inbox.latest(MOST_LIGHTS, Event::Lights);
    let put_last = put_lights.clone();
    let put_traffic = inbox.latest(MOST_TRAFFIC, Event::Traffic);
    bus.subscribe("obs/traffic", Box::new(move |_, octets| put_traffic(octets)))?;
    bus.subscribe("control/1/lights", Box::new(move |_, octets| put_lights(octets)))?;
    hear(bus, "obs/inputs", inbox.taking(Event::Inputs))?;
    hear(bus, "obs/fed/*", inbox.taking(|status| Event::Federate(Box::new(status))))?;
    let spectator = Spectator {
        name: NAME,
        kind: Kind::Gateway,
        scene_hash: scene.hash,
        patience: task.patience,
        endpoint: &task.endpoint,
    };
    let stopped = |wait| inbox.passes_over(wait);
    let Some(joined) = spectator.join(bus, stopped)? else { return Ok(None) };
    bus.announce(&format!("alive/{}/{}", joined.name, joined.inc))?;
    let alive = inbox.clone();
    watch_stations(bus, move |is| alive.put(Event::ConductorAlive(is)))?;
    // What was said before this process listened.
    last(bus, "obs/state/last", |state| put(Event::State(state)))?;
    last(bus, "obs/weather/last", |notice| put(Event::Weather(notice)))?;
    last(bus, "obs/flights/last", |entries| put(Event::Flights(entries)))?;
    if let Some(octets) = ask(bus, "control/1/lights/last", Vec::new(), LIGHTS_WITHIN)? {
        put_last(&octets);
    }
    ask_for_alerts(bus, inbox)?;
    let mut listening = Listening::new(&mut gateway, &mut port, &mut ports);
    (listening.ear, listening.shifted, listening.wall) = (ear, !task.wall, task.wall);
    listening.layout =
        scene.airport.layout.stands.iter().map(|s| (s.name.clone(), s.position_m)).collect();
    listening.until_the_end(bus, inbox, &joined);
    let refused = listening.refused;
    port.close();
    ports.close();
    if let Some(refused) = refused {
        return Err(refused.into());
    }
    port.sent.ports = ports.figures();
    port.sent.scans_lost = gateway.scans_lost();
    port.sent.records_refused = gateway.refused().values().sum();
    for (reason, count) in gateway.refused() {
        tracing::warn!("{count} records were not written: {reason}");
    }
    Ok(Some(port.sent))
}

/// Asks for the alerts that stand.
fn ask_for_alerts(bus: &dyn Bus, inbox: &Inbox) -> Result<(), BusError> {
    if let Some(octets) = ask(bus, "control/1/alerts/last", Vec::new(), LIGHTS_WITHIN)?
        && let Ok(told) = decode(&octets)
    {
        inbox.put(Event::Alerts(still_standing(told)));
    }
    Ok(())
}

/// Times of day follow the wall clock at rate 1 only.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "--asterix-time wall: this run goes at rate {0}, and times of day follow the wall clock at rate 1 only; take --asterix-time scene"
)]
pub struct NotAtWallRate(pub f64);

/// Whether a run goes at rate 1, or has not said yet how fast.
fn at_wall_rate(state: &RunState) -> bool {
    matches!(state.rate, 0.0 | 1.0)
}

/// The loop and what it carries.
struct Listening<'a> {
    gateway: &'a mut Gateway,
    port: &'a mut Port,
    ports: &'a mut Ports,
    ear: Option<ForeignEar>,
    shifted: bool,
    /// Times of day are the host's, and the rate at which they ceased to be.
    wall: bool,
    off_wall: Option<f64>,
    state: RunState,
    refused: Option<NotAtWallRate>,
    /// Stands that flights have now.
    stands: Stands,
    /// The flight list as it is planned, and as it is told: with them.
    planned: Vec<FlightNotice>,
    listed: Vec<FlightNotice>,
    /// Number of the run that they are of.
    run: Option<u32>,
    /// Where each stand is, m east and north.
    layout: BTreeMap<String, Point2<f64>>,
}

impl<'a> Listening<'a> {
    fn new(gateway: &'a mut Gateway, port: &'a mut Port, ports: &'a mut Ports) -> Self {
        Self {
            gateway,
            port,
            ports,
            ear: None,
            shifted: true,
            wall: false,
            off_wall: None,
            state: RunState::default(),
            refused: None,
            stands: Stands::default(),
            planned: Vec::new(),
            listed: Vec::new(),
            run: None,
            layout: BTreeMap::new(),
        }
    }

    fn until_the_end(&mut self, bus: &dyn Bus, inbox: &Inbox, joined: &Joined) {
        let mut hears = BTreeSet::new();
        let (mut alone_since, mut told_ns) = (None, 0);
        let mut usage = Usage::default();
        loop {
            let event = inbox.receive.recv_timeout(self.ports.next_due(TICK));
            let now_ns = monotonic_ns();
            self.ports.send_until(now_ns);
            self.hear_others(bus);
            match event {
                Ok(Event::Federate(status)) => {
                    // The conductor waits with the first frame until this process hears the others.
                    if hears.len() < HEARD && hears.insert(status.name.clone()) {
                        let hears = hears.iter().cloned().collect();
                        let body = Report::Present { hears, consumes: false };
                        let present = Numbered { fed: joined.fed, inc: joined.inc, seq: 0, body };
                        let key = format!("fed/{}", joined.name);
                        bus.publish(&key, Class::Must, encode(&present)).ok();
                    }
                    self.ports.on_federate(*status);
                }
                Ok(Event::ConductorAlive(alive)) => alone_since = (!alive).then_some(now_ns),
                Ok(Event::Stop) | Err(RecvTimeoutError::Disconnected) => break,
                Ok(event) => self.take(event),
                Err(RecvTimeoutError::Timeout) => {
                    let stopped = self.state.phase == Phase::Stopped;
                    let grace_ns = if stopped { 0 } else { GRACE_NS };
                    if alone_since.is_some_and(|since| now_ns - since >= grace_ns) {
                        if !stopped {
                            tracing::warn!("the administration station is gone; sending ends here");
                        }
                        break;
                    }
                }
            }
            if self.refused.is_some() {
                return;
            }
            if now_ns - told_ns >= STATUS_NS || told_ns == 0 {
                told_ns = now_ns;
                usage.sample(now_ns);
                self.ports.say_state();
                let status = self.status(&usage, &joined.name);
                let key = format!("obs/fed/{}", joined.name);
                bus.publish(&key, Class::Lossy, encode(&status)).ok();
            }
        }
        // What had arrived by then belongs to the run.
        for event in inbox.receive.try_iter() {
            self.take(event);
        }
    }

    /// Tells the federation what somebody's tracker said meanwhile.
    fn hear_others(&mut self, bus: &dyn Bus) {
        let Some(ear) = &mut self.ear else { return };
        let reports = ear.poll(self.gateway);
        for part in reports.chunks(REPORTS) {
            bus.publish("obs/foreign", Class::Lossy, encode(&part.to_vec())).ok();
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Scan(scan) => {
                if self.gateway.knows(&scan) {
                    return;
                }
                if !self.shifted {
                    let now_ns = utc_ns();
                    self.port.sent.shift_ns = self.gateway.shift_to(scan.time_ns, now_ns);
                    self.ports.shift_to(scan.time_ns, now_ns);
                    self.shifted = true;
                }
                if self.run.replace(scan.run).is_some_and(|before| before != scan.run) {
                    self.stands = Stands::default();
                    self.listed.clone_from(&self.planned);
                    self.list_flights();
                }
                self.stands.come_to(scan.time_ns);
                self.correct_stands();
                let labelled = match self.stands.labelled(&scan) {
                    Cow::Borrowed(_) => None,
                    Cow::Owned(labelled) => Some(Arc::new(labelled)),
                };
                let scan = labelled.unwrap_or(scan);
                self.port.send(&self.gateway.on_scan(&scan));
                self.ports.on_scan(&scan);
            }
            Event::State(state) => {
                if self.wall && !at_wall_rate(&state) {
                    if !self.shifted {
                        self.refused = Some(NotAtWallRate(state.rate));
                        return;
                    }
                    self.off_wall = Some(state.rate);
                }
                self.ports.on_state(&state);
                self.gateway.stands_at(state.frame);
                self.state = state;
            }
            Event::Weather(notice) => {
                self.ports.on_weather(&notice);
                self.gateway.on_weather(notice);
            }
            Event::Flights(entries) => {
                self.listed.clone_from(&entries);
                self.planned = entries;
                if !self.correct_stands() {
                    self.list_flights();
                }
            }
            Event::Traffic(latest) => latest.take().iter().for_each(|text| self.stands.hear(text)),
            Event::Alerts(told) => self.gateway.on_alerts(told),
            Event::Lights(latest) => latest.take().iter().for_each(|t| self.gateway.on_lights(t)),
            Event::Inputs(told) => self.ports.on_inputs(&told),
            Event::Operation(operation) => self.ports.on_operation(operation),
            Event::Federate(_) | Event::ConductorAlive(_) | Event::Stop => {}
        }
    }

    /// Tells the flight list again where somebody has another stand than it says; whether it did.
    fn correct_stands(&mut self) -> bool {
        let plain = |name: &str| name.replace('_', " ");
        let layout = &self.layout;
        let at_m = |name: &str| {
            let same = |known: &&String| plain(known) == plain(name);
            layout.get(name).or_else(|| layout.get(layout.keys().find(same)?)).copied()
        };
        let corrected = self.stands.correct(&mut self.listed, at_m);
        if corrected {
            self.list_flights();
        }
        corrected
    }

    fn list_flights(&mut self) {
        self.ports.on_flights(&self.listed);
        self.gateway.on_flights(self.listed.clone());
    }

    fn status(&self, usage: &Usage, name: &str) -> FederateStatus {
        let (counts, mut alarms) = self.ports.told();
        // What is off stays off: the times go on from where they were.
        alarms.extend(self.off_wall.map(|rate| {
            format!("sends times of day that are not the host's any more: the run went at rate {rate}, and --asterix-time wall follows it at rate 1 only")
        }));
        let (heard, foreign) = self.ear.as_ref().map(ForeignEar::counted).unwrap_or_default();
        let refused = self.gateway.refused().iter().map(|(reason, n)| (reason.clone(), *n));
        FederateStatus {
            name: name.to_owned(),
            pid: std::process::id(),
            host: host_name(),
            frame: self.state.frame,
            cpu_s: usage.cpu_s,
            cpu_pct: usage.cpu_pct,
            rss_bytes: usage.rss_bytes,
            pdus_out: self.port.sent.datagrams,
            lost: self.gateway.scans_lost(),
            dropped: refused.chain(counts).chain(foreign).collect(),
            pdus_in: heard,
            alarms,
            // The log keeps it, so that tracks that come back find their truth.
            facts: match self.port.sent.shift_ns {
                0 => Vec::new(),
                shift_ns => vec![("asterix_shift_ns".to_owned(), shift_ns.to_string())],
            },
            ..FederateStatus::default()
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
/// How often the run is looked at when nothing arrives.
const TICK: Duration = Duration::from_millis(250);
/// Octets of a message about stop bars.
const MOST_LIGHTS: usize = 1 << 20;
/// Octets of a message about traffic: thousands of movers with their ways.
const MOST_TRAFFIC: usize = 64 << 20;
/// How long is waited for what control said of them before; none is there where nobody controls.
const LIGHTS_WITHIN: Duration = Duration::from_millis(200);
const STATUS_NS: u64 = 1_000_000_000;
/// Foreign reports of one message.
const REPORTS: usize = 500;
/// How long a run may be without its administration station.
const GRACE_NS: u64 = 10_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    fn task(wall: bool) -> Task {
        Task {
            to: Vec::new(),
            choice: Choice::default(),
            wall,
            feeds: Feeds::default(),
            hear: Vec::new(),
            exercise: 1,
            recording: None,
            from_begin: false,
            patience: Duration::from_secs(1),
            endpoint: String::new(),
        }
    }

    /// Four thousand texts of 64 MiB could wait for one that stands still.
    #[test]
    fn of_texts_that_wait_the_latest_is_kept_and_one_that_finds_no_room_is_not_the_last() {
        let inbox = Inbox::default();
        let say = inbox.latest(8, Event::Traffic);
        let taken = || match inbox.receive.try_recv() {
            Ok(Event::Traffic(latest)) => latest.take(),
            Ok(other) => panic!("{other:?}"),
            Err(_) => None,
        };
        for text in ["one", "two", "three", "far too long", "\u{fc}"] {
            say(text.as_bytes());
        }
        say(&[0xff]);
        assert_eq!((inbox.receive.len(), taken().as_deref()), (1, Some("\u{fc}")));
        assert_eq!(taken(), None);
        // No room for a word of it now; the next one is heard of.
        (0..WAITING).for_each(|_| inbox.put(Event::Inputs(Vec::new())));
        say(b"lost");
        while inbox.receive.try_recv().is_ok() {}
        say(b"next");
        assert_eq!(taken().as_deref(), Some("next"));
        // Passed over while nobody takes part yet; the next one is heard of, too.
        say(b"early");
        assert!(!inbox.passes_over(Duration::ZERO));
        say(b"later");
        assert_eq!(taken().as_deref(), Some("later"));
        inbox.stop();
        assert!(inbox.passes_over(Duration::ZERO));
    }

    #[test]
    fn times_of_the_wall_are_for_runs_at_rate_1() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        for (wall, rate, refused) in [
            (true, 1.0, false),
            (true, 4.0, true),
            (true, 0.5, true),
            (true, f64::INFINITY, true),
            // Nothing is said yet.
            (true, 0.0, false),
            (false, 4.0, false),
        ] {
            let task = task(wall);
            let mut gateway = Gateway::new(&scene, Choice::default());
            let mut port = Port::open(&task).expect("nothing to open");
            let mut ports =
                Ports::open(&task.feeds, Board::new(&scene, 1, false)).expect("nothing");
            let mut listening = Listening::new(&mut gateway, &mut port, &mut ports);
            (listening.shifted, listening.wall) = (!wall, wall);
            listening.take(Event::State(RunState { rate, ..RunState::default() }));
            assert_eq!(listening.refused, refused.then_some(NotAtWallRate(rate)), "{wall} {rate}");
            // Once times of day are told, another rate ends nothing: it is an alarm from then on.
            (listening.refused, listening.shifted) = (None, true);
            for rate in [1.0, rate, 1.0] {
                listening.take(Event::State(RunState { rate, ..RunState::default() }));
            }
            let alarms = listening.status(&Usage::default(), NAME).alarms;
            let said = alarms.iter().any(|a| a.contains(&format!("went at rate {rate},")));
            assert_eq!((listening.refused, said, alarms.len()), (None, refused, refused.into()));
        }
    }

    /// The stand of a label as it goes out (062, item 390), and that of the flight list.
    #[test]
    fn a_label_and_the_flight_list_have_the_stand_that_was_given() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        let file = std::env::temp_dir().join(format!("seeds-stands-{}.pcapng", std::process::id()));
        let task = Task { recording: Some(file.clone()), ..task(false) };
        let mut gateway = Gateway::new(&scene, Choice::default());
        let mut port = Port::open(&task).expect("a recording");
        let mut ports = Ports::open(&task.feeds, Board::new(&scene, 1, false)).expect("nothing");
        let mut listening = Listening::new(&mut gateway, &mut port, &mut ports);
        listening.layout = [("ZZ_7Q".to_owned(), Point2::new(4.0, 5.0))].into();
        let flight = FlightNotice {
            callsign: "swr_137h".into(),
            address: None,
            type_designator: "A320".into(),
            wake: None,
            movement: models::flight_list::MovementKind::Arrival,
            runway: "28".into(),
            stand: "E_19".into(),
            stand_m: None,
            eta_ctd_ns: 0,
            off_block_ns: None,
            routing: Vec::new(),
        };
        listening.take(Event::Flights(vec![flight.clone()]));
        let scan = |n: u64| {
            let track = super::super::tests::track(7, n as i64 * 1_000_000_000);
            Event::Scan(Arc::new(super::super::tests::report(n, vec![track], Vec::new())))
        };
        listening.take(scan(1));
        let has = |name: &str| {
            let octets = std::fs::read(&file).expect("recorded");
            octets.windows(name.len()).any(|w| w == name.as_bytes())
        };
        assert!(has("E19") && !has("ZZ7Q"));
        listening.take(scan(1));
        assert_eq!(listening.port.sent.scans, 1, "it was sent already");
        assert_eq!(listening.gateway.flights, std::slice::from_ref(&flight));
        let text = r#"{"time_s":1.5,"movers":[{"callsign":"swr_137h","stand":"ZZ 7Q"}]}"#;
        let said = Latest::default();
        said.put(text, |_| true);
        listening.take(Event::Traffic(said));
        listening.take(scan(2));
        assert!(has("ZZ7Q"));
        let stand_m = Some(Point2::new(4.0, 5.0));
        let given = FlightNotice { stand: "ZZ 7Q".into(), stand_m, ..flight.clone() };
        assert_eq!(listening.gateway.flights, std::slice::from_ref(&given));
        // The list comes again as it was planned.
        listening.take(Event::Flights(vec![flight]));
        assert_eq!(listening.gateway.flights, [given]);
        listening.port.close();
        std::fs::remove_file(&file).ok();
    }

    /// What control told last is asked for once, and what has ended of it is nobody's who joins now.
    #[test]
    fn alerts_that_stand_are_asked_for_at_the_start() {
        use crate::runtime::bus::Request;
        use crate::runtime::local_bus::LocalHub;
        use models::control::alert::{AlertKind, Change, Stage};
        let alert = |id, change| AlertMessage {
            run: 1,
            time_ns: 0,
            change,
            id,
            kind: AlertKind::RunwayOpposite,
            stage: Stage::Alarm,
            subjects: "7".into(),
            since_ns: 0,
            asterix: 11,
            place_m: Point2::new(0.0, 0.0),
            number: id.into(),
        };
        let told = [alert(1, Change::Raised), alert(2, Change::Ended), alert(3, Change::Changed)];
        let hub = LocalHub::default();
        let (control, octets) = (hub.join(), encode(&told.to_vec()));
        let answer = move |request: Request| request.answer(octets.clone());
        control.serve("control/1/alerts/last", Box::new(answer)).expect("served");
        let inbox = Inbox::default();
        ask_for_alerts(&hub.join(), &inbox).expect("asked");
        let heard = inbox.receive.try_recv();
        let Ok(Event::Alerts(heard)) = heard else { panic!("{heard:?}") };
        assert_eq!(heard, [told[0].clone(), told[2].clone()]);
    }
}
