//! Viewer and logger: a spectator that shows the run on a page and writes it down.
//!
//! ```text
//! scans, weather, flights, state ──► Viewer ──► Session (one per browser) ──► server ──► page (web/)
//!                               └──► log::Log ──► run.sqlite
//! ```
//!
//! [`Viewer`] and [`Session`] are state machines without I/O; [`server`] carries them over HTTP, [`log`] is the
//! database. Nobody in the federation waits for any of this.

pub mod access;
pub mod beside;
mod connections;
pub mod frame;
pub mod history;
pub mod keeper;
pub mod log;
pub mod log_traffic;
pub mod metrics;
pub mod picture;
pub mod process;
pub mod server;

use crate::runtime::messages::{
    Command, FederateStatus, FlightNotice, Operation, RunState, ScanReport, WeatherNotice,
};
use history::{CurvePoint, History};
use picture::{AirportMap, RunInfo};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// What the page shows: last values of everything and the scans of the run.
#[derive(Debug)]
pub struct Viewer {
    history: History,
    generation: u64,
    version: u64,
    topics: BTreeMap<&'static str, (u64, Arc<str>)>,
    operations: VecDeque<Operation>,
    plan: Vec<[String; 5]>,
    weather: Vec<WeatherNotice>,
    federates: BTreeMap<String, Load>,
    state: Option<RunState>,
    measures: BTreeMap<String, f64>,
    comparing: bool,
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
        Self {
            history: History::new(history_octets),
            generation: 0,
            version: 0,
            topics: BTreeMap::new(),
            operations: VecDeque::new(),
            plan: Vec::new(),
            weather: Vec::new(),
            federates: BTreeMap::new(),
            state: None,
            measures: BTreeMap::new(),
            comparing: false,
        }
    }

    /// Whether a browser asked for what the neighbouring rungs would give.
    #[must_use]
    pub fn comparing(&self) -> bool {
        self.comparing
    }

    /// A browser asks for the neighbouring rungs, or has seen enough.
    pub fn compare(&mut self, on: bool) {
        self.comparing = on;
        self.on_rungs(&[]);
    }

    /// What the rungs have given so far; none while nobody asks.
    pub fn on_rungs(&mut self, rows: &[beside::RungRow]) {
        let message = json!({"type": "rungs", "comparing": self.comparing, "rows": rows});
        self.set("rungs", message);
    }

    /// The scene: once, or again when another run begins.
    pub fn on_scene(&mut self, run: &RunInfo, map: &AirportMap) {
        self.set("scene", json!({"type": "scene", "run": run, "map": map}));
    }

    /// One scan of the SMDFM. One that is not later than the last begins a new history (restart).
    pub fn on_scan(&mut self, scan: &ScanReport) {
        if self.history.push(scan) {
            self.generation += 1;
        }
        self.measures = scan.measures.iter().cloned().collect();
        if let (Some((first, last)), Some((from, to))) =
            (self.history.range(), self.history.times())
        {
            let timeline = json!({
                "type": "timeline", "first": first, "last": last, "first_s": from.s(), "last_s": to.s(),
                "dropped": self.history.dropped(), "generation": self.generation,
                "measures": scan.measures, "took_us": scan.took_us,
            });
            self.set("timeline", timeline);
        }
        if self.plan != scan.plan {
            self.plan.clone_from(&scan.plan);
            self.set("plan", json!({"type": "plan", "rows": scan.plan}));
        }
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

    /// The flight list.
    pub fn on_flights(&mut self, entries: &[FlightNotice]) {
        self.set("flights", json!({"type": "flights", "entries": entries}));
    }

    /// State of the run. An infinite rate becomes null: as fast as possible.
    pub fn on_state(&mut self, state: &RunState) {
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
        }
        self.set("operations", json!({"type": "operations", "operations": self.operations}));
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

    /// The scans kept.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Curve of one track over everything kept.
    #[must_use]
    pub fn curve(&self, number: u16) -> Vec<CurvePoint> {
        self.history.curve(number, 0, u64::MAX)
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

/// One browser: what it was sent and what it looks at.
#[derive(Debug, Default)]
pub struct Session {
    seen: u64,
    generation: u64,
    shown: Option<u64>, // a scan of the past; none is the newest
    selected: Option<u16>,
    sent_scan: Option<u64>,
    explained: Option<(u64, u16)>, // scan and track
    curve_from: u64,
}

/// A message to the browser.
#[derive(Clone, Debug, PartialEq)]
pub enum Outgoing {
    /// JSON.
    Text(Arc<str>),
    /// A scan, see [`frame`].
    Binary(Vec<u8>),
}

/// What a message from the browser asks for beyond the session itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Nothing more: the session changed, poll it.
    Nothing,
    /// A command to the run, with its number and words; answer with [`reply`].
    Command(f64, String, Command),
    /// What the neighbouring rungs would give, from now on or no more: [`Viewer::compare`].
    Compare(bool),
    /// The message was not understood; send this.
    Refused(Outgoing),
}

impl Session {
    /// Everything that the browser lacks, oldest topic first. Scans that came since the last poll are
    /// passed over, the newest is sent; error curves lose nothing.
    pub fn poll(&mut self, viewer: &Viewer) -> Vec<Outgoing> {
        let mut out = Vec::new();
        if self.generation != viewer.generation {
            *self = Self { seen: self.seen, generation: viewer.generation, ..Self::default() };
            out.push(Outgoing::Text(r#"{"type":"new_run"}"#.into()));
        }
        let mut news: Vec<_> = viewer.topics.values().filter(|t| t.0 > self.seen).collect();
        news.sort_by_key(|t| t.0);
        out.extend(news.into_iter().map(|t| Outgoing::Text(t.1.clone())));
        self.seen = viewer.version;
        let newest = viewer.history.range().map(|r| r.1);
        if let Some(scan) = self.shown.or(newest).and_then(|scan| viewer.history.nearest(scan))
            && self.sent_scan != Some(scan)
            && let Some(message) = viewer.history.message(scan)
        {
            self.sent_scan = Some(scan);
            out.push(Outgoing::Binary(message));
        }
        if let (Some(number), Some(scan)) = (self.selected, self.sent_scan)
            && self.explained != Some((scan, number))
        {
            self.explained = Some((scan, number));
            let plots = viewer.history.effects(number, scan).join(",");
            out.push(Outgoing::Text(
                format!(r#"{{"type":"effects","scan":{scan},"track":{number},"plots":[{plots}]}}"#)
                    .into(),
            ));
        }
        if let (Some(number), Some(newest)) = (self.selected, newest)
            && self.curve_from <= newest
        {
            let points = viewer.history.curve(number, self.curve_from, newest);
            let reset = self.curve_from == 0;
            self.curve_from = newest + 1;
            if reset || !points.is_empty() {
                let curve =
                    json!({"type": "curve", "track": number, "reset": reset, "points": points});
                out.push(Outgoing::Text(curve.to_string().into()));
            }
        }
        out
    }

    /// Takes a message of the browser. Anything not understood is refused with its reason, nothing more.
    pub fn on_message(&mut self, text: &str) -> Asked {
        let message: FromPage = match serde_json::from_str(text) {
            Ok(message) => message,
            Err(error) => return Asked::Refused(refused(&error.to_string())),
        };
        match message {
            FromPage::Show { scan } => {
                self.shown = scan;
                self.sent_scan = None;
                Asked::Nothing
            }
            FromPage::Select { track } => {
                self.selected = track;
                self.curve_from = 0;
                Asked::Nothing
            }
            FromPage::Token { .. } => Asked::Nothing,
            FromPage::Compare { on } => Asked::Compare(on),
            FromPage::Command { id, command, frames, rate } => {
                match command_of(&command, frames, rate) {
                    Ok((words, order)) => Asked::Command(id, words, order),
                    Err(reason) => Asked::Refused(reply(id, &command, false, &reason)),
                }
            }
        }
    }
}

/// The answer to command number `id`.
#[must_use]
pub fn reply(id: f64, command: &str, accepted: bool, text: &str) -> Outgoing {
    let message = json!({
        "type": "reply", "id": id, "command": command, "accepted": accepted, "text": text,
    });
    Outgoing::Text(message.to_string().into())
}

fn refused(reason: &str) -> Outgoing {
    Outgoing::Text(json!({"type": "refused", "text": reason}).to_string().into())
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
enum FromPage {
    Show {
        scan: Option<u64>,
    },
    Select {
        track: Option<u16>,
    },
    Compare {
        on: bool,
    },
    /// Shown where none is needed; looked at before the session begins where one is.
    Token {
        #[serde(rename = "token")]
        _token: String,
    },
    Command {
        id: f64,
        command: String,
        #[serde(default)]
        frames: Option<u64>,
        #[serde(default)]
        rate: Option<f64>,
    },
}

/// The command and its words for the log.
fn command_of(
    word: &str,
    frames: Option<u64>,
    rate: Option<f64>,
) -> Result<(String, Command), String> {
    let command = match word {
        "start" | "resume" => Command::Start,
        "freeze" => Command::Freeze,
        "step" => match frames.unwrap_or(1) {
            n @ 1..=MAX_STEP => return Ok((format!("step {n}"), Command::Step { n })),
            n => return Err(format!("step: {n} frames is outside 1 ..= {MAX_STEP}")),
        },
        "stop" => Command::Stop,
        "restart" => Command::Restart,
        "fast" => Command::Rate { rate: f64::INFINITY },
        "rate" => match rate {
            Some(rate) if (MIN_RATE..=MAX_RATE).contains(&rate) => {
                return Ok((format!("rate {rate}"), Command::Rate { rate }));
            }
            Some(rate) => return Err(format!("rate: {rate} is outside {MIN_RATE} ..= {MAX_RATE}")),
            None => return Err("rate: no figure given".to_owned()),
        },
        other => return Err(format!("{other:?} is not a valid command")),
    };
    Ok((word.to_owned(), command))
}

/// Federates whose figures are kept, at most: anybody on the bus may say a name.
const FEDERATES: usize = 1024;
/// Operator actions kept for the page; all of them are in the database.
const OPERATIONS: usize = 200;
/// Weather notices kept for the page; all of them are in the database.
const NOTICES: usize = 1000;
/// Most frames in one step command: an hour of 50 ms frames.
const MAX_STEP: u64 = 72_000;
const MIN_RATE: f64 = 0.01;
const MAX_RATE: f64 = 1000.0;

#[cfg(test)]
pub(crate) mod tests;
