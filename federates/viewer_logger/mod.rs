//! Viewer and logger: a spectator that shows the run on a page and writes it down.
//!
//! ```text
//! scans, weather, flights, state ──► Viewer ──► Session (one per browser) ──► server ──► page (web/)
//!                               └──► log::Log ──► run.sqlite ──► Archive ──► Viewer (of a finished run)
//! ```
//!
//! [`Viewer`] and [`Session`] are state machines without I/O; [`server`] carries them over HTTP, [`log`] is the
//! database. Nobody in the federation waits for any of this.

pub mod archive;
pub mod assets;
pub mod author;
pub mod beside;
pub mod command;
mod connections;
pub mod detection;
pub mod drawing;
pub mod foreign;
pub mod forks;
pub mod frame;
pub mod geometry;
pub mod history;
pub mod hold_lines;
pub mod keeper;
pub mod kept_scene;
pub mod log;
pub mod log_traffic;
pub mod marks;
pub mod metrics;
pub mod named;
pub mod noted;
pub mod opened;
pub mod picture;
pub mod process;
pub mod replayed;
pub mod rings;
pub mod said;
mod seat_view;
pub mod server;
pub mod session;
pub mod source;
pub mod tolerances;
pub mod video;

use crate::runtime::messages::{
    AlertMessage, FederateStatus, FlightNotice, Operation, RunState, ScanReport, WeatherNotice,
};
use archive::Archive;
use history::History;
use picture::{AirportMap, RunInfo};
use said::{Said, Topic};
use serde_json::{Value, json};
pub use session::{Asked, Outgoing, Session, reply};
use source::{CurvePoint, Event, Source};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// What the page shows: last values of everything and the scans of the run.
#[derive(Debug)]
pub struct Viewer {
    id: String,
    info: RunInfo,
    scans: Scans,
    generation: u64,
    version: u64,
    topics: BTreeMap<&'static str, (u64, Arc<str>)>,
    operations: VecDeque<Operation>,
    /// How many of them are of earlier runs.
    operations_before: usize,
    plan: Vec<[String; 5]>,
    weather: Vec<WeatherNotice>,
    federates: BTreeMap<String, Load>,
    state: Option<RunState>,
    measures: BTreeMap<String, f64>,
    comparing: bool,
    ghost: Option<String>,
    /// Whether a browser asked for other tolerances, and whose tracks it wants, m.
    tolerances: Option<Option<f64>>,
    said: Said,
    detection: Option<Arc<detection::Maps>>,
    blocks: Vec<picture::Block>,
    cab_m: [f64; 3],
    reference_deg: [f64; 2],
}

/// Where the scans come from.
#[derive(Debug)]
enum Scans {
    Live(History),
    Stored(Box<Archive>),
}

/// Last status of a federate and what it did a second since the one before.
#[derive(Debug)]
struct Load {
    status: FederateStatus,
    wall_ns: i64,
    in_per_s: Option<f64>,
    out_per_s: Option<f64>,
}

impl Viewer {
    /// A viewer that has seen nothing yet and keeps at most about `history_octets` of scans.
    #[must_use]
    pub fn new(history_octets: usize) -> Self {
        Self::of(Scans::Live(History::new(history_octets)))
    }

    /// A viewer of a finished run, which has been told nothing but its scans.
    #[must_use]
    pub fn stored(archive: Archive) -> Self {
        let said = archive.alerts();
        Self { said, ..Self::of(Scans::Stored(Box::new(archive))) }
    }

    fn of(scans: Scans) -> Self {
        Self {
            id: LIVE.to_owned(),
            info: RunInfo::default(),
            scans,
            generation: 0,
            version: 0,
            topics: BTreeMap::new(),
            operations: VecDeque::new(),
            operations_before: 0,
            plan: Vec::new(),
            weather: Vec::new(),
            federates: BTreeMap::new(),
            state: None,
            measures: BTreeMap::new(),
            comparing: false,
            ghost: None,
            tolerances: None,
            said: Said::default(),
            detection: None,
            blocks: Vec::new(),
            cab_m: [0.0; 3],
            reference_deg: [0.0; 2],
        }
    }

    /// Where the radars see can be shown from now on.
    pub fn show_detection(&mut self, maps: Arc<detection::Maps>) {
        self.detection = Some(maps);
    }

    /// Pictures of where the radars see.
    #[must_use]
    pub fn detection(&self) -> Option<Arc<detection::Maps>> {
        self.detection.clone()
    }

    /// Whether a browser asked for what the other rungs would give.
    #[must_use]
    pub fn comparing(&self) -> bool {
        self.comparing
    }

    /// The rung whose tracks are wanted beside the run's own.
    #[must_use]
    pub fn ghost(&self) -> Option<&str> {
        self.ghost.as_deref()
    }

    /// A browser asks for the other rungs, and for the tracks of one of them, or has seen enough.
    pub fn compare(&mut self, on: bool, ghost: Option<String>) {
        let before = std::mem::replace(&mut self.comparing, on);
        self.ghost = ghost.filter(|_| on);
        if before != on {
            self.on_rungs(&[], &[], false);
        }
    }

    /// What the rungs have given so far, where the ghost's tracks are (m), and whether only the neighbours go on, since
    /// all would take too much; nothing while nobody asks.
    pub fn on_rungs(&mut self, rows: &[beside::RungRow], ghosts_m: &[[f64; 2]], few: bool) {
        let left_out = if few {
            "All filters would take more than 40 % of a core: only the neighbours go on."
        } else {
            ""
        };
        let message = json!({
            "type": "rungs", "comparing": self.comparing, "rows": rows, "ghost": ghosts_m,
            "left_out": left_out,
        });
        self.set("rungs", message);
    }

    /// Whether a browser asked for other tolerances of the effect plan, and by which one the tracks are wanted beside the run's own, m.
    #[must_use]
    pub fn tolerances(&self) -> Option<Option<f64>> {
        self.tolerances
    }

    /// A browser asks for other tolerances, and for the tracks of one of them (m), or has seen enough.
    pub fn compare_tolerances(&mut self, on: bool, ghost_m: Option<f64>) {
        let before = std::mem::replace(&mut self.tolerances, on.then_some(ghost_m));
        if before.is_some() != on {
            self.tell_tolerances(&tolerances::Told::default());
        }
    }

    /// What the tolerances have given so far; nothing while nobody asks.
    pub fn on_tolerances(&mut self, told: &tolerances::Told) {
        if self.tolerances.is_some() {
            self.tell_tolerances(told);
        }
    }

    fn tell_tolerances(&mut self, told: &tolerances::Told) {
        let mut message = json!(told);
        message["type"] = "tolerances".into();
        message["comparing"] = self.tolerances.is_some().into();
        self.set("tolerances", message);
    }

    /// The scene: once, or again when another run begins.
    pub fn on_scene(&mut self, run: &RunInfo, map: &AirportMap) {
        self.info = run.clone();
        self.blocks.clone_from(&map.blocks);
        let map = map.with_cab();
        self.cab_m = map.cab_m();
        self.reference_deg = map.reference_deg;
        let filters = models::filter::Rung::ALL.map(|(_, name)| name);
        let words = frame::words();
        self.set(
            "scene",
            json!({"type": "scene", "run": run, "map": map, "filters": filters, "words": words}),
        );
    }

    /// One scan of the SMDFM. One that is not later than the last begins a new history (restart).
    pub fn on_scan(&mut self, scan: &ScanReport) {
        self.on_noted(scan, &frame::Noted::new());
    }

    /// The same with what is noted of its tracks.
    pub fn on_noted(&mut self, scan: &ScanReport, noted: &frame::Noted) {
        let Scans::Live(history) = &mut self.scans else { return };
        if history.push_noted(scan, noted) {
            self.generation += 1;
        }
        self.measures = scan.measures.iter().cloned().collect();
        self.tell_timeline(&scan.measures, scan.took_us);
        if self.plan != scan.plan {
            self.plan.clone_from(&scan.plan);
            self.set("plan", json!({"type": "plan", "rows": scan.plan}));
        }
    }

    /// How far the scans go, with the measures of the run at the end of them.
    fn tell_timeline(&mut self, measures: &[(String, f64)], took_us: u64) {
        let source = self.source();
        if let (Some((first, last)), Some((from, to))) = (source.range(), source.times()) {
            let timeline = json!({
                "type": "timeline", "first": first, "last": last, "first_s": from.s(), "last_s": to.s(),
                "dropped": source.dropped(), "generation": self.generation,
                "measures": measures, "took_us": took_us, "live": self.is_live(),
            });
            self.set("timeline", timeline);
        }
    }

    /// The effect plan, where no scan tells it.
    pub fn on_plan(&mut self, rows: &[[String; 5]]) {
        self.plan = rows.to_vec();
        self.set("plan", json!({"type": "plan", "rows": rows}));
    }

    /// Takes in what a run that somebody else keeps has grown by; nothing for a run of this process.
    pub fn follow(&mut self) -> bool {
        let Scans::Stored(archive) = &mut self.scans else { return false };
        let grown = archive.follow().unwrap_or_else(|error| {
            tracing::warn!("{}: {error}", archive.path().display());
            false
        });
        if grown {
            self.said = archive.alerts();
            self.tell_end();
        }
        grown
    }

    /// The time line of a stored run, with its measures at the end.
    pub(super) fn tell_end(&mut self) {
        let Scans::Stored(archive) = &self.scans else { return };
        let last = archive.range().and_then(|r| archive.report(r.1).ok().flatten());
        let (measures, took_us) = last.map_or_else(Default::default, |l| (l.measures, l.took_us));
        self.tell_timeline(&measures, took_us);
    }

    /// What the run is called where there are several.
    pub fn set_id(&mut self, id: &str) {
        id.clone_into(&mut self.id);
        self.version += 1;
    }

    /// See [`Self::set_id`]; "live" until told otherwise.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Name, seed and times of the run.
    #[must_use]
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// Latitude and longitude from which metres are counted, degrees; none where nobody says them.
    #[must_use]
    pub fn reference_deg(&self) -> Option<[f64; 2]> {
        let [latitude, longitude] = self.reference_deg;
        (latitude != 0.0 || longitude != 0.0).then_some(self.reference_deg)
    }

    /// The database that a run is shown from; none of one that goes on in this process.
    #[must_use]
    pub fn database(&self) -> Option<&std::path::Path> {
        match &self.scans {
            Scans::Live(_) => None,
            Scans::Stored(archive) => Some(archive.path()),
        }
    }

    /// Whether the run goes on in this process.
    #[must_use]
    pub fn is_live(&self) -> bool {
        matches!(self.scans, Scans::Live(_))
    }

    /// The scans and what belongs to them.
    #[must_use]
    pub fn source(&self) -> &dyn Source {
        match &self.scans {
            Scans::Live(history) => history,
            Scans::Stored(archive) => &**archive,
        }
    }

    /// What the time line marks.
    #[must_use]
    pub fn events(&self) -> Vec<Event> {
        let mut events = self.source().events().to_vec();
        if self.is_live() {
            let mut weather: Vec<Event> = self.weather.iter().map(log::weather_event).collect();
            weather.dedup_by(|later, earlier| later.text == earlier.text);
            events.extend(weather);
            events.extend(self.said.events());
            let of_this_run = self.operations.iter().skip(self.operations_before);
            events.extend(of_this_run.map(log::operation_event));
            events.sort_by_key(|e| e.time_ns);
        }
        events
    }

    /// Something that happened beside the scans: the time line marks it. Nothing for a stored run, which has its own.
    pub fn on_events(&mut self, events: &[Event]) {
        let Scans::Live(history) = &mut self.scans else { return };
        events.iter().for_each(|event| history.note(event.clone()));
        self.version += 1;
    }

    /// The weather from a time on. The page is given all of the run, to show what was when it looks back.
    pub fn on_weather(&mut self, weather: &WeatherNotice) {
        self.weather.retain(|w| w.from_ns < weather.from_ns); // a restarted run begins anew
        self.weather.push(weather.clone());
        if self.weather.len() > NOTICES {
            self.weather.remove(0);
        }
        // An infinite visibility becomes null: clear.
        self.set("weather", json!({"type": "weather", "notices": self.weather}));
    }

    /// What sight depends on.
    fn air(&self) -> seat_view::Air<'_> {
        seat_view::Air { weather: &self.weather, blocks: &self.blocks, cab_m: self.cab_m }
    }

    /// The flight list.
    pub fn on_flights(&mut self, entries: &[FlightNotice]) {
        self.set("flights", json!({"type": "flights", "entries": entries}));
    }

    /// State of the run. An infinite rate becomes null: as fast as possible.
    pub fn on_state(&mut self, state: &RunState) {
        if self.state.as_ref().is_some_and(|before| before.run < state.run) {
            self.said.clear(); // of the run before
            self.operations_before = self.operations.len();
        }
        self.state = Some(state.clone());
        let mut message = json!({"type": "state", "state": state});
        message["state"]["seed"] = state.seed.to_string().into(); // more than a browser's number holds
        self.set("state", message);
    }

    /// Statistics of one federate, which arrived at `wall_ns` of any clock that goes on evenly.
    pub fn on_federate(&mut self, status: FederateStatus, wall_ns: i64) {
        let before = self.federates.get(&status.name).filter(|b| b.status.pid == status.pid);
        let per_s = |now: u64, then: fn(&FederateStatus) -> u64| {
            let before = before.filter(|b| wall_ns > b.wall_ns)?;
            let seconds = (wall_ns - before.wall_ns) as f64 * 1e-9;
            Some(now.saturating_sub(then(&before.status)) as f64 / seconds)
        };
        let load = Load {
            in_per_s: per_s(status.pdus_in, |s| s.pdus_in),
            out_per_s: per_s(status.pdus_out, |s| s.pdus_out),
            status,
            wall_ns,
        };
        if self.federates.len() < FEDERATES || self.federates.contains_key(&load.status.name) {
            self.federates.insert(load.status.name.clone(), load);
        }
        let rows: Vec<Value> = self.federates.values().map(Load::row).collect();
        self.set("federates", json!({"type": "federates", "federates": rows}));
    }

    /// An operator's action, wherever it came from.
    pub fn on_operation(&mut self, operation: Operation) {
        self.operations.push_back(operation);
        while self.operations.len() > OPERATIONS {
            self.operations.pop_front();
            self.operations_before = self.operations_before.saturating_sub(1);
        }
        self.set("operations", json!({"type": "operations", "operations": self.operations}));
    }

    /// How traffic stands or the stop bars are, as it was said (JSON).
    pub fn on_said(&mut self, topic: Topic, text: &str) {
        if self.said.tell(topic, text) {
            self.version += 1;
        }
    }

    /// What changed of the control alerts.
    pub fn on_alerts(&mut self, alerts: &[AlertMessage]) {
        alerts.iter().for_each(|a| self.said.alert(a));
        self.version += 1;
    }

    /// A person has seen an alert; what is said in answer.
    ///
    /// # Errors
    /// If there is none of that number, or it was acknowledged before.
    pub fn acknowledge(&mut self, id: u32) -> Result<String, String> {
        let now_ns = self.source().times().map_or(0, |t| t.1.0);
        self.version += 1;
        self.said.acknowledge(id, "page", now_ns)
    }

    /// What people did on the page, for the log: once each.
    pub fn take_done(&mut self) -> Vec<Operation> {
        self.said.take_done()
    }

    /// What was said of a topic last, as of a time; `i64::MAX`: now.
    #[must_use]
    pub fn said_at(&self, topic: Topic, time_ns: i64) -> Option<Arc<str>> {
        match &self.scans {
            Scans::Live(_) => self.said.at(topic, time_ns),
            Scans::Stored(archive) => archive.said(topic, time_ns),
        }
    }

    /// The alerts of a time, as a message for the page.
    #[must_use]
    pub fn alerts_at(&self, time_ns: i64) -> Value {
        let (open, ended) = self.said.alerts_at(time_ns);
        json!({"type": "alerts", "open": open, "ended": ended})
    }

    /// The run as Prometheus text.
    #[must_use]
    pub fn metrics(&self) -> String {
        let federates = self.federates.values().map(|load| &load.status);
        metrics::text(self.state.as_ref(), federates, &self.measures)
    }

    /// Counts up with every change: what a server watches.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Curve of one track over everything kept.
    #[must_use]
    pub fn curve(&self, number: u16) -> Vec<CurvePoint> {
        self.source().curve(number, 0, u64::MAX)
    }

    /// Tells browsers something of this kind; they get what was told last.
    fn tell(&mut self, topic: &'static str, message: Value) {
        self.set(topic, message);
    }

    fn set(&mut self, topic: &'static str, message: Value) {
        self.version += 1;
        self.topics.insert(topic, (self.version, message.to_string().into()));
    }
}

impl Load {
    fn row(&self) -> Value {
        let mut row = json!(self.status);
        row["in_per_s"] = self.in_per_s.into();
        row["out_per_s"] = self.out_per_s.into();
        row
    }
}

/// Federates whose figures are kept, at most: anybody on the bus may say a name.
const FEDERATES: usize = 1024;
/// What the run of this process is called.
const LIVE: &str = "live";
/// Operator actions kept for the page; all of them are in the database.
const OPERATIONS: usize = 200;
/// Weather notices kept for the page; all of them are in the database.
const NOTICES: usize = 1000;

#[cfg(test)]
pub(crate) mod tests;
