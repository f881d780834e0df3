//! What is known of the run, for everybody who asks: last values, encoded when somebody wants them.

use super::adsb::{self, Addressed, Feed, Piece};
use super::opensky;
use super::public::{self, Heading};
use super::{Choice, Gateway};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{
    FederateStatus, FlightNotice, Operation, RunState, ScanReport, SeatMessage, WeatherNotice,
};
use scenarios::Scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Keys that have one last value.
pub const KEYS: [&str; 9] =
    ["state", "scan", "tracks", "plots", "truth", "flights", "weather", "operation", "handovers"];

/// Octets of one datagram of GDL 90.
const DATAGRAM: usize = 1400;

/// Handovers that are told.
const HANDOVERS: usize = 64;

/// Federates whose last status is kept; a federation has far fewer.
const FEDERATES: usize = 64;

/// Last values.
pub struct Board {
    known: Mutex<Known>,
    scans: watch::Sender<u64>,
}

struct Known {
    gateway: Gateway,
    exercise: u8,
    scene: String,
    scan: Option<Arc<ScanReport>>,
    state: Option<RunState>,
    operation: Option<Operation>,
    federates: BTreeMap<String, FederateStatus>,
    /// Of this run, by number.
    handovers: (u32, BTreeMap<u64, public::Handover>),
    feed: Feed,
    targets: Vec<adsb::Addressed>,
    /// Addresses of who has none, where they are to be invented.
    invented: Option<adsb::OfRun>,
    /// What ADS-B sensors were told, where that is what is sent.
    reported: Option<adsb::Reported>,
    frame_s: f64,
}

impl Board {
    /// An empty board; `invent` gives addresses to targets that have none.
    #[must_use]
    pub fn new(scene: &Scene, exercise: u8, invent: bool) -> Self {
        let known = Known {
            gateway: Gateway::new(scene, Choice::default()),
            exercise,
            scene: scene.name.clone(),
            scan: None,
            state: None,
            operation: None,
            federates: BTreeMap::new(),
            handovers: (0, BTreeMap::new()),
            feed: Feed::default(),
            targets: Vec::new(),
            invented: invent.then(adsb::OfRun::default),
            reported: None,
            frame_s: scene.run.frame.s(),
        };
        Self { known: Mutex::new(known), scans: watch::Sender::new(0) }
    }

    /// The same with squitters of what is true, or of what ADS-B sensors were told.
    #[must_use]
    pub fn sending(self, origin: adsb::Origin) -> Self {
        self.known().reported = (origin == adsb::Origin::Reports).then(adsb::Reported::default);
        self
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        // A panic while it was held leaves last values; they are still fit to show.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts scans; whoever waits for the next watches it.
    #[must_use]
    pub fn scans(&self) -> watch::Receiver<u64> {
        self.scans.subscribe()
    }

    /// A scan; what its targets send until the next one.
    pub fn on_scan(&self, scan: &Arc<ScanReport>) -> Vec<Piece> {
        let mut known = self.known();
        let Known { gateway, feed, targets, invented, reported, .. } = &mut *known;
        *targets = match reported {
            Some(reported) => reported.targets(gateway, scan, invented.is_some()),
            None => adsb::targets(gateway, scan, invented.as_mut()),
        };
        let pieces = feed.on_scan(gateway, scan, targets);
        known.scan = Some(Arc::clone(scan));
        drop(known);
        self.scans.send_modify(|count| *count += 1);
        pieces
    }

    /// How the run stands.
    pub fn on_state(&self, state: RunState) {
        let known = &mut self.known().state;
        // An answer to a command may have told more than what was on its way.
        let older = |k: &RunState| (k.run, k.frame) > (state.run, state.frame);
        if !known.as_ref().is_some_and(older) {
            *known = Some(state);
        }
    }

    /// The run is over, or nobody of it is left: STOPPED, whatever was heard last.
    pub fn on_end(&self) {
        if let Some(state) = &mut self.known().state
            && state.phase != Phase::Stopped
        {
            state.phase = Phase::Stopped;
            state.reasons.push("the end of the run was not heard".to_owned());
        }
    }

    /// The flight list.
    pub fn on_flights(&self, entries: Vec<FlightNotice>) {
        self.known().gateway.on_flights(entries);
    }

    /// Weather from a time on.
    pub fn on_weather(&self, notice: WeatherNotice) {
        self.known().gateway.on_weather(notice);
    }

    /// An operator's command.
    pub fn on_operation(&self, operation: Operation) {
        self.known().operation = Some(operation);
    }

    /// What was asked of the traffic, and what came of it; whether there is anything new.
    pub fn on_inputs(&self, told: &[SeatMessage]) -> bool {
        let mut known = self.known();
        let frame_s = known.frame_s;
        let (run, all) = &mut known.handovers;
        let mut new = false;
        for message in told {
            let Some(handover) = public::handover(message, frame_s) else { continue };
            if *run != message.run {
                (*run, *all) = (message.run, BTreeMap::new());
            }
            new |= all.insert(handover.number, handover).is_none();
            while all.len() > HANDOVERS {
                all.pop_first();
            }
        }
        new
    }

    /// Load and counters of a federate.
    pub fn on_federate(&self, status: FederateStatus) {
        let federates = &mut self.known().federates;
        if federates.len() < FEDERATES || federates.contains_key(&status.name) {
            federates.insert(status.name.clone(), status);
        }
    }

    /// GDL 90 messages of the last scan: a heartbeat and a report of each target, as datagrams.
    #[must_use]
    pub fn gdl90(&self) -> Vec<Vec<u8>> {
        let known = self.known();
        let Some(scan) = &known.scan else { return Vec::new() };
        let second = known.gateway.utc_ns(scan.time_ns).div_euclid(1_000_000_000);
        let mut datagrams = vec![Vec::new()];
        mode_s::gdl90::heartbeat(&mut datagrams[0], second.rem_euclid(86_400) as u32);
        for Addressed { target, .. } in &known.targets {
            let mut report = Vec::new();
            mode_s::gdl90::traffic(&mut report, target);
            match datagrams.last_mut() {
                Some(last) if last.len() + report.len() <= DATAGRAM => last.extend(report),
                _ => datagrams.push(report),
            }
        }
        datagrams
    }

    /// Moves all times, as [`Gateway::shift_to`].
    pub fn shift_to(&self, time_ns: i64, utc_ns: i64) {
        self.known().gateway.shift_to(time_ns, utc_ns);
    }

    /// Squitters made so far, and targets that could not be written.
    #[must_use]
    pub fn squitters(&self) -> (u64, u64) {
        let known = self.known();
        (known.feed.messages(), known.feed.refused())
    }

    /// Asks something of the gateway's own knowledge: frame, flights, weather, times.
    pub fn with_gateway<T>(&self, ask: impl FnOnce(&Gateway) -> T) -> T {
        ask(&self.known().gateway)
    }

    /// The command line of a decoder beside a Beast port.
    #[must_use]
    pub fn decoder_command(&self, port: std::net::SocketAddr) -> String {
        adsb::decoder_command(&self.known().gateway, port)
    }

    /// Names of the federates that said something.
    #[must_use]
    pub fn federates(&self) -> Vec<String> {
        self.known().federates.keys().cloned().collect()
    }

    /// The last value of a key, `federate/NAME` among them, and the schema; none if there is no such key, or nothing yet.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<Value> {
        if key == "schema" {
            return Some(public::schema());
        }
        let known = self.known();
        let heading = known.heading();
        let gateway = &known.gateway;
        let scan = || known.scan.as_deref();
        let message = |name: &str, body: Option<Value>| {
            Some(public::message(gateway, &heading, name, &body?))
        };
        let body = |value: Result<Value, _>| value.ok();
        match key {
            "scan" => message(
                key,
                scan().and_then(|s| body(serde_json::to_value(public::scan(gateway, s)))),
            ),
            "tracks" => message(
                key,
                scan().and_then(|s| body(serde_json::to_value(public::tracks(gateway, s)))),
            ),
            "plots" => {
                message(key, scan().and_then(|s| body(serde_json::to_value(public::plots(s)))))
            }
            "truth" => message(
                key,
                scan().and_then(|s| body(serde_json::to_value(public::truths(gateway, s)))),
            ),
            "state" => {
                let state = known.state.as_ref()?;
                let time_ns = state.frame as i64 * state.step_ns;
                let heading = Heading { time_ns, run: state.run, ..heading.clone() };
                Some(public::message(gateway, &heading, key, &public::state(gateway, state)))
            }
            "flights" => {
                Some(public::message(gateway, &heading, key, &public::flights(&gateway.flights)))
            }
            "weather" => {
                let now = gateway.weather.iter().rev().find(|w| w.from_ns <= heading.time_ns);
                let weather = public::weather(now.or(gateway.weather.first())?);
                Some(public::message(gateway, &heading, key, &weather))
            }
            "operation" => {
                let operation = known.operation.as_ref()?;
                let heading = Heading { time_ns: operation.time_ns, ..heading.clone() };
                Some(public::message(gateway, &heading, key, &public::operation(operation)))
            }
            "handovers" => {
                let handovers = known.handovers.1.values().cloned().collect();
                let all = public::Handovers { handovers };
                Some(public::message(gateway, &heading, key, &all))
            }
            "tracks.geojson" => {
                let all =
                    public::message(gateway, &heading, "tracks", &public::tracks(gateway, scan()?));
                Some(public::geojson(all, "tracks"))
            }
            "truth.geojson" => {
                let all =
                    public::message(gateway, &heading, "truth", &public::truths(gateway, scan()?));
                Some(public::geojson(all, "truth"))
            }
            "aircraft.json" => Some(known.feed.aircraft_json(gateway, scan()?, &known.targets)),
            "states" => Some(opensky::states(gateway, scan()?, &known.targets)),
            "receiver.json" => Some(adsb::receiver_json(gateway)),
            _ => {
                let status = known.federates.get(key.strip_prefix("federate/")?)?;
                Some(public::message(gateway, &heading, "federate", &public::federate(status)))
            }
        }
    }
}

impl Known {
    fn heading(&self) -> Heading {
        let scan = self.scan.as_deref();
        Heading {
            exercise: self.exercise,
            scene: self.scene.clone(),
            run: scan.map_or_else(|| self.state.as_ref().map_or(0, |s| s.run), |s| s.run),
            scan: scan.map_or(0, |s| s.scan),
            time_ns: scan.map_or(0, |s| s.time_ns),
        }
    }
}
