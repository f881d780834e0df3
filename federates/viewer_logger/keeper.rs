//! Keeps what the federation says: the page, the database and the recording behind one door.
//!
//! It is fed decoded messages and raw datagrams by whoever listens; nothing that goes wrong with a file reaches
//! the run. What could not be kept is counted and told at the end.

use super::Viewer;
use super::beside::Beside;
use super::foreign::ForeignTracks;
use super::kept_scene;
use super::log::{Log, LogError};
use super::log_traffic::core_after;
use super::marks::Marks;
use super::named;
use super::noted::Notes;
use super::picture::{AirportMap, RunInfo};
use super::said::Topic;
use super::server::Page;
use super::source::Event;
use super::tolerances::Tolerances;
use crate::exchange::flights::flight_list;
use crate::runtime::clock::utc_ns;
use crate::runtime::messages::{
    AlertMessage, FederateStatus, FlightNotice, ForeignReport, Operation, Outcome, RunState,
    ScanReport, SeatMessage, WeatherNotice,
};
use capture::Recorder;
use models::flight_list::FlightList;
use models::frames::Point2;
use scenarios::Scene;
use std::io::ErrorKind;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

/// A message of the federation.
#[derive(Clone, Debug)]
pub enum Heard {
    /// One scan of the SMDFM.
    Scan(Box<ScanReport>),
    /// How the run stands.
    State(RunState),
    /// Statistics of a federate.
    Federate(FederateStatus),
    /// Weather from a time on.
    Weather(WeatherNotice),
    /// The flight list.
    Flights(Vec<FlightNotice>),
    /// Tracks of somebody else's tracker.
    Foreign(Vec<ForeignReport>),
    /// An operator's action.
    Operation(Operation),
    /// What a run came to that is over.
    Outcome(Outcome),
    /// What changed of the control alerts in a scan.
    Alerts(Vec<AlertMessage>),
    /// What controllers on tracks did.
    Seats(Vec<SeatMessage>),
    /// What people who drive did.
    Inputs(Vec<SeatMessage>),
    /// How traffic stands, or the stop bars (JSON).
    Said(Topic, String),
}

/// Where to keep things; what is none is not kept.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// Recording of all datagrams, pcapng.
    pub recording: Option<PathBuf>,
    /// Database. A second run of the same process goes to another file beside it.
    pub database: Option<PathBuf>,
}

impl Files {
    /// Both files of a recording that was asked for by name: the database stands beside it.
    #[must_use]
    pub fn beside(recording: &Path) -> Self {
        Self {
            recording: Some(recording.to_owned()),
            database: Some(named::database_of(recording)),
        }
    }

    /// Both files in a folder of their own, made here and named by the time `utc_ns` at which the run was started.
    ///
    /// Runs that begin in the same second get `…Z`, `…Z_2`, `…Z_3`: whoever makes the folder has it. Where none can be made,
    /// opening the files says why.
    #[must_use]
    pub fn in_folder(folder: &Path, utc_ns: i64) -> Self {
        let name = time_name(utc_ns);
        std::fs::create_dir_all(folder).ok();
        let mut run = folder.join(&name);
        let mut number = 2_u32;
        while std::fs::create_dir(&run).is_err_and(|e| e.kind() == ErrorKind::AlreadyExists) {
            run = folder.join(format!("{name}_{number}"));
            number += 1;
        }
        Self { recording: Some(run.join("run.pcapng")), database: Some(run.join("run.sqlite")) }
    }
}

/// What was kept and what was not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Scans in the database.
    pub scans: u64,
    /// Scans that never arrived or came after the database had failed.
    pub scans_lost: u64,
    /// Datagrams in the recording.
    pub datagrams: u64,
    /// Datagrams that could not be written.
    pub datagrams_lost: u64,
    /// Databases of the runs, in their order.
    pub databases: Vec<PathBuf>,
}

impl Kept {
    /// Whether nothing is missing.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.scans_lost == 0 && self.datagrams_lost == 0
    }
}

/// Page, database and recording of a run.
pub struct Keeper {
    scene: Arc<Scene>,
    map: AirportMap,
    page: Option<Arc<Page>>,
    log: Option<Log>,
    /// The log of this run could not be made: its scans are lost.
    unlogged: bool,
    /// Logs of earlier runs, which are being closed.
    closing: Vec<JoinHandle<()>>,
    database: Option<PathBuf>,
    recorder: Option<Recorder>,
    state: Option<RunState>,
    last_scan: Option<u64>,
    kept: Kept,
    flights: FlightList,
    beside: Option<Beside>,
    tolerances: Option<Tolerances>,
    marks: Marks,
    notes: Notes,
    /// The flight list as it is shown: with the stands that were given since.
    listed: Vec<FlightNotice>,
    /// What controllers on tracks did in this run.
    people: Vec<SeatMessage>,
    /// Tracks of somebody else's tracker that the page shows.
    foreign: ForeignTracks,
    /// Numbers of the last alert and the last event of a seat.
    last_told: [u64; 3],
    /// How many of each never came.
    never_came: [u64; 3],
}

/// Events of seats that are kept at most: days of a busy airport.
const MOST_EVENTS: usize = 1_000_000;

impl Keeper {
    /// Opens the files and shows the scene on the page.
    ///
    /// # Errors
    /// If a file cannot be made: which, and why.
    pub fn open(scene: Arc<Scene>, page: Option<Arc<Page>>, files: &Files) -> anyhow::Result<Self> {
        use anyhow::Context;
        files.recording.as_deref().map_or(Ok(()), named::check_recording)?;
        for file in [&files.recording, &files.database].into_iter().flatten() {
            let folder = file.parent().filter(|f| !f.as_os_str().is_empty());
            if let Some(folder) = folder {
                std::fs::create_dir_all(folder)
                    .with_context(|| format!("making the folder {}", folder.display()))?;
            }
        }
        let (map, info) = (AirportMap::of(&scene), RunInfo::of(&scene, scene.run.seed));
        let mut log = match &files.database {
            Some(file) => Some(Log::replace(file, &info, &map)?),
            None => None,
        };
        // After the log, which is refused where another run writes there.
        let recorder = match &files.recording {
            Some(file) => Some(
                Recorder::create(file).with_context(|| format!("recording {}", file.display()))?,
            ),
            None => None,
        };
        if let Some(log) = &mut log {
            kept_scene::keep(log, &scene);
        }
        if let Some(page) = &page {
            page.update(|viewer| viewer.on_scene(&info, &map));
        }
        let database = files.database.clone();
        Ok(Self {
            notes: Notes::of(&map),
            scene,
            map,
            page,
            log,
            unlogged: false,
            closing: Vec::new(),
            database,
            recorder,
            state: None,
            last_scan: None,
            kept: Kept { databases: files.database.iter().cloned().collect(), ..Kept::default() },
            flights: FlightList::default(),
            beside: None,
            tolerances: None,
            marks: Marks::default(),
            listed: Vec::new(),
            people: Vec::new(),
            foreign: ForeignTracks::default(),
            last_told: [0; 3],
            never_came: [0; 3],
        })
    }

    /// Takes a message that arrived at `utc_ns`.
    pub fn hear(&mut self, heard: Heard, utc_ns: i64) {
        match heard {
            Heard::Scan(scan) => self.scan(&scan),
            Heard::State(state) => self.run_state(state, utc_ns),
            Heard::Federate(status) => {
                let members = self.state.as_ref().map_or(&[][..], |s| &s.members);
                let latency_us =
                    members.iter().find(|m| m.name == status.name).map(|m| m.latency_us);
                self.logged(|log| log.federate(&status, latency_us, utc_ns));
                for (name, value) in &status.facts {
                    self.fact(name, value);
                }
                self.shown(|viewer| viewer.on_federate(status, utc_ns));
            }
            Heard::Weather(weather) => {
                self.logged(|log| log.weather(&weather));
                self.shown(|viewer| viewer.on_weather(&weather));
            }
            Heard::Flights(entries) => {
                self.flights = flight_list(&entries, self.scene.flight_list.runways.clone());
                self.listed = entries;
                self.list_flights();
                self.correct_stands();
            }
            Heard::Foreign(reports) => {
                self.logged(|log| log.foreign(&reports));
                self.foreign.take(&reports);
                let message = self.foreign.message();
                self.shown(|viewer| viewer.tell("foreign", message));
            }
            Heard::Outcome(outcome) => {
                if self.state.as_ref().is_none_or(|s| s.run == outcome.run) {
                    outcome.facts.iter().for_each(|(name, value)| self.fact(name, value));
                }
            }
            Heard::Alerts(alerts) => {
                let run = self.state.as_ref().map_or(0, |s| s.run);
                let mut now: Vec<_> = alerts.into_iter().filter(|a| a.run >= run).collect();
                self.only_new(0, "alerts", &mut now, |a| a.number);
                if now.is_empty() {
                    return;
                }
                self.notes.alerts(&now);
                self.logged(|log| log.alerts(&now));
                self.shown(|viewer| viewer.on_alerts(&now));
            }
            Heard::Seats(told) => self.take_people(1, "seat_events", told),
            Heard::Inputs(told) => self.take_people(2, "inputs", told),
            Heard::Said(topic, text) => {
                if topic == Topic::Traffic {
                    let events = self.marks.traffic(&text);
                    self.notes.traffic(&text);
                    self.mark(&events);
                    self.correct_stands();
                }
                self.logged(|log| log.said(topic, &text));
                self.shown(|viewer| viewer.on_said(topic, &text));
            }
            Heard::Operation(operation) => {
                self.logged(|log| log.operation(&operation, utc_ns));
                self.shown(|viewer| viewer.on_operation(operation));
            }
        }
    }

    /// Records a datagram, sound or not.
    pub fn datagram(&mut self, utc_ns: i64, from: SocketAddr, to: SocketAddr, octets: &[u8]) {
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = recorder.record(utc_ns, from, to, octets)
        {
            tracing::error!("{error}"); // once; the recorder counts what it loses from here on
        }
    }

    /// Gives what was collected to the system: now and then, and when the run stands still.
    pub fn flush(&mut self) {
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = recorder.flush()
        {
            tracing::error!("{error}");
        }
    }

    /// Notes a figure of the run as a whole in the database.
    pub fn fact(&mut self, name: &str, value: &str) {
        self.logged(|log| log.fact(name, value));
    }

    /// How the run stood last.
    #[must_use]
    pub fn state(&self) -> Option<&RunState> {
        self.state.as_ref()
    }

    /// Closes the files and says what was kept. `dropped` datagrams never reached this process.
    pub fn close(mut self, dropped: u64) -> Kept {
        self.flush();
        self.write_done();
        if let Some(recorder) = self.recorder.take() {
            self.kept.datagrams = recorder.recorded();
            self.kept.datagrams_lost = recorder.lost() + dropped;
            if let Err(error) = recorder.close(dropped) {
                tracing::error!("{error}");
            }
            self.fact("datagrams_recorded", &self.kept.datagrams.to_string());
            self.fact("datagrams_lost", &self.kept.datagrams_lost.to_string());
        }
        let state = self.state.take();
        self.close_log(state.as_ref());
        for thread in self.closing.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a log was not closed: its thread ended by a broken invariant");
            }
        }
        self.kept.clone()
    }

    /// Keeps of what is told again and again only what is new; what was lost for good is said and noted.
    fn take_people(&mut self, stream: usize, what: &str, mut told: Vec<SeatMessage>) {
        let run = self.state.as_ref().map_or(0, |s| s.run);
        told.retain(|m| m.run >= run);
        self.only_new(stream, what, &mut told, |m| m.number);
        told.truncate(MOST_EVENTS - self.people.len().min(MOST_EVENTS));
        self.people.extend(told);
    }

    fn only_new<T>(&mut self, stream: usize, what: &str, told: &mut Vec<T>, number: fn(&T) -> u64) {
        let last = self.last_told[stream];
        told.retain(|one| number(one) == 0 || number(one) > last);
        let numbered = told.iter().map(number).filter(|n| *n > 0);
        let (new, count) = numbered.fold((last, 0), |(most, count), n| (most.max(n), count + 1));
        self.last_told[stream] = new;
        // Of alerts that stand for long not all is told that was told of them.
        let lost = (new - last).saturating_sub(count);
        if lost > 0 {
            tracing::warn!(lost, "{what} did not arrive: the log has a hole there");
            self.never_came[stream] += lost;
            self.fact(&format!("{what}_lost"), &self.never_came[stream].to_string());
        }
    }

    fn scan(&mut self, scan: &ScanReport) {
        if self.state.as_ref().is_some_and(|s| s.run > scan.run) {
            return; // a straggler of the run before
        }
        if self.last_scan.is_some_and(|last| scan.scan <= last) {
            return; // served again to a late joiner
        }
        let missed = self.last_scan.map_or(0, |last| scan.scan - last - 1);
        if missed > 0 && (self.log.is_some() || self.unlogged) {
            self.kept.scans_lost += missed;
            tracing::warn!(scan = scan.scan, missed, "scans did not arrive");
        }
        self.last_scan = Some(scan.scan);
        self.kept.scans_lost += u64::from(self.unlogged);
        let noted = self.notes.scan(scan);
        self.logged(|log| log.scan_noted(scan, &noted));
        self.shown(|viewer| viewer.on_noted(scan, &noted));
        self.write_done();
        self.compare(scan);
        self.compare_tolerances(scan);
    }

    /// Writes down what people did on the page, and shows it in its list.
    fn write_done(&mut self) {
        let done = self.page.as_ref().map_or_else(Vec::new, |page| page.viewer().take_done());
        for operation in done {
            self.logged(|log| log.operation(&operation, utc_ns()));
            self.shown(|viewer| viewer.on_operation(operation));
        }
    }

    /// Runs the other rungs on the scan while a browser asks for them.
    fn compare(&mut self, scan: &ScanReport) {
        let asked = self.page.as_ref().is_some_and(|page| page.viewer().comparing());
        if !asked {
            self.beside = None;
            return;
        }
        let scene = &self.scene;
        let beside = self.beside.get_or_insert_with(|| Beside::new(&scene.tracking_config()));
        let ghost = self.page.as_ref().and_then(|page| page.viewer().ghost().map(str::to_owned));
        beside.ghost(ghost.as_deref());
        beside.scan(scan, &self.flights);
        let (rows, ghosts_m, few) = (beside.rows(), beside.ghosts_m().to_vec(), beside.few());
        self.shown(|viewer| viewer.on_rungs(&rows, &ghosts_m, few));
    }

    /// Has other tolerances of the effect plan simulated beside the run while a browser asks for them.
    fn compare_tolerances(&mut self, scan: &ScanReport) {
        let Some(page) = self.page.as_ref() else { return };
        let Some(ghost_m) = page.viewer().tolerances() else {
            self.tolerances = None;
            return;
        };
        let seed = self.state.as_ref().map_or(self.scene.run.seed, |s| s.seed);
        let (scene, shown) = (&self.scene, Arc::clone(page));
        let beside = self.tolerances.get_or_insert_with(|| {
            Tolerances::begin(Arc::clone(scene), seed, move |told| {
                shown.update(|viewer| viewer.on_tolerances(&told));
            })
        });
        beside.scan(scan, &self.flights, ghost_m);
    }

    fn run_state(&mut self, state: RunState, utc_ns: i64) {
        let before = self.state.take();
        // Run 0 is none yet: the federates are joining.
        let new_run = before.as_ref().is_some_and(|b| 0 < b.run && b.run < state.run);
        if new_run {
            self.last_scan = None;
            self.beside = None;
            self.tolerances = None;
            self.close_log(before.as_ref());
            self.marks = Marks::default();
            self.notes = Notes::of(&self.map);
            self.people.clear();
            (self.last_told, self.never_came) = ([0; 3], [0; 3]);
            self.open_log(state.run, state.seed);
        }
        // The station's seed stands in the state of run 0 already, of which there is no log.
        let known = before.as_ref().filter(|b| b.run > 0);
        let seed = known.map_or(self.scene.run.seed, |b| b.seed);
        if seed != state.seed && state.run > 0 {
            self.fact("seed", &state.seed.to_string());
            let info = RunInfo::of(&self.scene, state.seed);
            let map = self.map.clone();
            self.shown(|viewer| viewer.on_scene(&info, &map));
        }
        let told = |s: &RunState| (s.run, s.phase, s.rate.to_bits(), s.reasons.clone());
        if before.as_ref().is_none_or(|b| told(b) != told(&state)) {
            self.logged(|log| log.state(&state, utc_ns));
        }
        let events = self.marks.state(&state);
        self.mark(&events);
        self.shown(|viewer| viewer.on_state(&state));
        self.state = Some(state);
    }

    /// Another run of the same process: `run.sqlite` is followed by `run-2.sqlite`, in place of an earlier one of its own only.
    fn open_log(&mut self, run: u32, seed: u64) {
        let Some(first) = &self.database else { return };
        let file = named::following(first, run);
        let of = first.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        tracing::info!("run {run} is logged in {}", file.display());
        let opened = Log::replace(&file, &RunInfo::of(&self.scene, seed), &self.map);
        self.unlogged = opened.is_err();
        match opened {
            Ok(mut log) => {
                kept_scene::keep(&mut log, &self.scene);
                self.log = Some(log);
                self.kept.databases.push(file);
                self.fact(named::FOLLOWS, &of);
            }
            Err(error) => tracing::error!("{error}"),
        }
    }

    /// Closes the log of the run whose last state this is. Its traffic is stepped once more for that, which takes a while: beside the run
    /// that follows, and [`Self::close`] waits for it.
    fn close_log(&mut self, state: Option<&RunState>) {
        let Some(mut log) = self.log.take() else { return };
        let (written, lost) = log.scans();
        self.kept.scans += written;
        self.kept.scans_lost += lost;
        let (scene, people) = (Arc::clone(&self.scene), std::mem::take(&mut self.people));
        let end = state.map(|s| (s.seed, s.frame));
        let work = move || {
            if let Some((seed, frame)) = end
                && let Some((core, told)) = core_after(&scene, seed, frame, &people)
                && let Err(error) = log.traffic(&scene, &core, &told, &people)
            {
                tracing::error!("{error}");
            }
            if let Err(error) = log.close() {
                tracing::error!("{error}");
            }
        };
        match std::thread::Builder::new().name("log".to_owned()).spawn(work) {
            Ok(thread) => self.closing.push(thread),
            Err(error) => tracing::error!("the log could not be closed: {error}"),
        }
    }

    fn logged(&mut self, write: impl FnOnce(&mut Log) -> Result<(), LogError>) {
        if let Some(log) = &mut self.log
            && let Err(error) = write(log)
        {
            tracing::error!("{error}; the run goes on"); // once: the log takes everything silently from here on
        }
    }

    /// Who has another stand than planned is shown and logged with it.
    fn correct_stands(&mut self) {
        let stands = &self.map.stands;
        let at_m = |name: &str| {
            let stand = stands.iter().find(|s| s.name == name)?;
            Some(Point2::from(stand.position_m))
        };
        if self.marks.correct(&mut self.listed, at_m) {
            self.list_flights();
        }
    }

    fn list_flights(&mut self) {
        let entries = std::mem::take(&mut self.listed);
        self.logged(|log| log.flights(&entries));
        self.shown(|viewer| viewer.on_flights(&entries));
        self.listed = entries;
    }

    /// Something for the time line of the page and of the log.
    fn mark(&mut self, events: &[Event]) {
        if !events.is_empty() {
            self.logged(|log| log.events(events));
            self.shown(|viewer| viewer.on_events(events));
        }
    }

    fn shown(&self, show: impl FnOnce(&mut Viewer)) {
        if let Some(page) = &self.page {
            page.update(show);
        }
    }
}

/// UTC as a name for a folder: 2026-11-21T00-21-05Z.
fn time_name(utc_ns: i64) -> String {
    let seconds = utc_ns.div_euclid(1_000_000_000);
    let (days, of_day) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    // Days since 1970 to a Gregorian date, counted from 0000-03-01 in eras of 400 years of 146097 days.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = year_of_era + era * 400 + next;
    let (h, m, s) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{h:02}-{m:02}-{s:02}Z")
}

#[cfg(test)]
mod tests;
