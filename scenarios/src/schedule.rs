//! `[[traffic]] kind = "schedule"` and `"generated"`: flights that behave, from a table or from rates.

mod reach;

use crate::airport::AirportScene;
use crate::control::Sees;
use crate::document::{Section, days_from_civil, within};
use crate::entity::{Entity, PARTITIONS};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::run::Run;
use crate::types::{TypeRow, TypeTable};
use models::airport::distance_to_segment_m;
use models::control::lights::FailedBars;
use models::draw::{DrawKey, Purpose, exponential, normal_pair, uniform};
use models::flight_list::{FlightEntry, MovementKind, WakeCategory};
use models::frames::Azimuth;
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::core::{
    ClearedBy, Core, Direction, Failure, FailureKind, Flight, Obstacle, Policy, drawn_failures,
};
use models::traffic::network::{Network, code_of_span};
use models::traffic::outline::{Rectangle, Size, distance_m, outline};
use models::traffic::pieces::Pieces;
use reach::{Reach, default_ends, end_named, lacks_m, lands_instead, reached_stands};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Flights of a scene that behave, and what they move on.
#[derive(Clone, Debug, PartialEq)]
pub struct Behaving {
    /// The ground network.
    pub network: Arc<Network>,
    /// Its pieces; `None` in a scene loaded without truth.
    pub pieces: Option<Arc<Pieces>>,
    /// The flights.
    pub flights: Arc<Vec<Flight>>,
    /// Index of the first flight's entity; the others follow it in order.
    pub first_entity: usize,
    /// Which piece may be taken.
    pub policy: Policy,
    /// Who clears: the plan, models of controllers in the core, or those of the member `control` by notices.
    pub cleared_by: ClearedBy,
    /// Errors of pilots, in multiples of what is assumed.
    pub errors: f64,
    /// Stop bars are in use.
    pub stop_bars: bool,
    /// What goes wrong.
    pub failures: Vec<Failure>,
    /// Movers of the scene that are functions of time.
    pub obstacles: Vec<Obstacle>,
    /// What was moved or assumed, one line each.
    pub remarks: Vec<String>,
}

impl Behaving {
    /// What goes wrong in a run with this seed: what the scene says and what is drawn.
    #[must_use]
    pub fn failures_of(&self, seed: u64) -> Vec<Failure> {
        let drawn = drawn_failures(&self.flights, seed, self.errors, self.stop_bars);
        self.failures.iter().cloned().chain(drawn).collect()
    }

    /// Stop bars that fail in a run with this seed.
    #[must_use]
    pub fn failed_bars(&self, seed: u64) -> Vec<FailedBars> {
        let name = |f: &Failure| &self.network.runways[self.flights[f.flight].runway.0].names[0];
        self.failures_of(seed).iter().filter_map(|f| f.bars(name(f))).collect()
    }

    /// The core at time 0 of a run with this seed, or `None` in a scene loaded without truth.
    #[must_use]
    pub fn core(&self, run: &Run, seed: u64) -> Option<Core> {
        let pieces = self.pieces.clone()?;
        let (net, flights) = (Arc::clone(&self.network), Arc::clone(&self.flights));
        let core = Core::new(net, pieces, flights, self.policy, seed, run.frame.s());
        let core = core.with_obstacles(self.obstacles.clone());
        let core = core.with_failures(&self.failures_of(seed));
        Some(match self.cleared_by {
            ClearedBy::Controllers => core.with_controllers(),
            by => core.cleared_by(by),
        })
    }
}

/// Start of a run that states none: ten minutes before the first flight of its schedule, at the full minute.
pub(crate) fn start_utc_ns(root: &Section) -> Result<Option<i64>, ScenarioError> {
    let mut first: Option<i64> = None;
    for section in root.sections("traffic", &words(keys::TRAFFIC))? {
        match section.text("kind")? {
            Some("schedule") => {
                let Some(file) = section.file_path("file")? else { continue };
                let rows = rows_of(&file)?;
                let earliest = rows.iter().filter_map(|r| r.departs_ns.or(r.lands_ns)).min();
                first = [first, earliest].into_iter().flatten().min();
            }
            Some("generated") => first = first.or(Some(GENERATED_START_NS + 600_000_000_000)),
            _ => {}
        }
    }
    Ok(first.map(|ns| (ns - 600_000_000_000).div_euclid(60_000_000_000) * 60_000_000_000))
}

/// 2026-01-01T06:00:00Z (assumed).
const GENERATED_START_NS: i64 = 1_767_247_200_000_000_000;

/// What becomes part of the scene.
pub(crate) struct Added {
    pub(crate) entities: Vec<Entity>,
    pub(crate) entries: Vec<FlightEntry>,
    pub(crate) files: Vec<PathBuf>,
}

/// One flight before it is put on the network.
struct Wanted {
    line: usize,
    callsign: String,
    address: Option<u32>,
    designator: String,
    direction: Direction,
    runway: String,
    stand: String,
    time_s: f64,
    turnaround_of: Option<String>,
}

/// Index of a runway and of its end.
type RunwayEnd = (usize, usize);

/// Reads all sections of these kinds.
pub(crate) fn read(
    root: &Section,
    sections: &[&Section],
    run: &Run,
    airport: &AirportScene,
    types: &TypeTable,
    first_entity: usize,
    with_truth: bool,
) -> Result<(Option<Behaving>, Added), ScenarioError> {
    let mut added = Added { entities: Vec::new(), entries: Vec::new(), files: Vec::new() };
    let control = crate::control::read(root)?;
    if sections.is_empty() {
        return Ok((None, added));
    }
    let network = Network::of(&airport.layout);
    let mut remarks = network.findings.clone();
    let mut flights: Vec<Flight> = Vec::new();
    // Stands that a way leads to, by code letter, as they are needed.
    let mut reached: [Option<Vec<bool>>; 6] = [const { None }; 6];
    // Where landings go for whom no way leads to a stand, by runway end and code letter.
    let mut instead: BTreeMap<(RunwayEnd, u8), Option<RunwayEnd>> = BTreeMap::new();
    for section in sections {
        let (file, wanted) = match section.text("kind")? {
            Some("schedule") => {
                let file = section.file_path("file")?.ok_or_else(|| {
                    section.missing("file", "the name of a schedule (CSV)".into())
                })?;
                added.files.push(file.clone());
                let wanted = scheduled(&file, run)?;
                (file, wanted)
            }
            _ => (
                section.file().to_path_buf(),
                generated(section, run, &network, types, &mut remarks)?,
            ),
        };
        for w in wanted {
            let index = first_entity + flights.len();
            let refuse = |column: &'static str, found: &str, allowed: Vec<&str>| {
                let near = crate::document::nearest_of(found, &allowed);
                let allowed = near.unwrap_or_else(|| format!("one of {} names", allowed.len()));
                let problem = Problem::NotAllowed { found: found.into(), allowed };
                ScenarioError::new(&file, w.line, column, problem)
            };
            let row = types
                .get(&w.designator)
                .ok_or_else(|| refuse("type", &w.designator, types.designators().collect()))?;
            let runway = end_named(&network, &w.runway).ok_or_else(|| {
                let names = network.runways.iter().flat_map(|r| r.names.iter());
                refuse("runway", &w.runway, names.map(String::as_str).collect())
            })?;
            let need = code_of_span(row.class.span_m);
            let arrival = w.direction == Direction::Arrival;
            let known = arrival.then(|| instead.entry((runway, need)));
            let other =
                known.and_then(|k| *k.or_insert_with(|| lands_instead(&network, runway, need)));
            let runway = other.unwrap_or(runway);
            let runway_name = network.runways[runway.0].names[runway.1].clone();
            if other.is_some() {
                remarks.push(format!(
                    "{}: no stand is reached from the exits of runway {}, lands on {runway_name}",
                    w.callsign, w.runway
                ));
            }
            let mut stand = stand_named(&network, &w.stand).ok_or_else(|| {
                refuse("stand", &w.stand, network.stands.iter().map(|s| s.name.as_str()).collect())
            })?;
            let reached = reached[usize::from(need.min(5))]
                .get_or_insert_with(|| reached_stands(&network, need));
            let usable = |s: usize| {
                reached[s] && network.stands[s].node.is_some_and(|n| network.nodes[n].used)
            };
            if network.stands[stand].code < need || !usable(stand) {
                let at = network.stands[stand].at_m;
                let larger = (0..network.stands.len())
                    .filter(|s| network.stands[*s].code >= need && usable(*s))
                    .min_by(|a, b| {
                        let distance = |s: usize| (network.stands[s].at_m - at).norm();
                        distance(*a).total_cmp(&distance(*b)).then(a.cmp(b))
                    });
                if let Some(larger) = larger {
                    let (from, to) = (&network.stands[stand].name, &network.stands[larger].name);
                    let why = if usable(stand) { "too small" } else { "without a way" };
                    remarks.push(format!(
                        "{}: stand {from} is {why} for a {}, to {to}",
                        w.callsign, w.designator
                    ));
                    stand = larger;
                }
            }
            let callsign = Callsign::new(&w.callsign);
            let entity = Entity {
                callsign,
                address: w.address,
                class: row.class.clone(),
                application: 1 + (index as u16) % PARTITIONS,
                number: 1 + index as u16,
                trajectory: None,
                report: None,
            };
            added.entries.push(FlightEntry {
                callsign,
                address: w.address,
                type_designator: w.designator.clone(),
                wake: row.wake,
                movement: if arrival { MovementKind::Arrival } else { MovementKind::Departure },
                runway: runway_name,
                stand: network.stands[stand].name.clone(),
                stand_m: Some(network.stands[stand].at_m),
                eta_ctd: SimTime::from_s(if arrival { w.time_s } else { w.time_s + 900.0 }),
                off_block: (!arrival).then(|| SimTime::from_s(w.time_s)),
                routing: Vec::new(),
            });
            let turnaround_of = w.turnaround_of.as_ref().and_then(|name| {
                flights
                    .iter()
                    .position(|f| f.callsign == *name && f.direction == Direction::Arrival)
            });
            flights.push(Flight {
                callsign: w.callsign.clone(),
                direction: w.direction,
                runway,
                stand,
                time_s: w.time_s,
                turnaround_of,
                key: entity.key(run.site),
                ..flight_of(row)
            });
            added.entities.push(entity);
        }
    }
    if first_entity + flights.len() > 60_000 {
        let problem = Problem::OutOfRange {
            found: flights.len() as f64,
            low: 0.0,
            high: 60_000.0,
            unit: "movers",
        };
        return Err(root.refuse("traffic", problem));
    }
    let failures = crate::control::read_failures(root, &flights, control.stop_bars)?;
    let vehicles = failures.iter().filter(|f| f.kind == FailureKind::VehicleOnRunway);
    for (n, failure) in vehicles.enumerate() {
        let row = types
            .get("FOLLOWME")
            .ok_or_else(|| root.missing("failure", "a type FOLLOWME in types.csv".into()))?;
        let index = first_entity + flights.len() + n;
        let callsign = Callsign::new(&failure.vehicle);
        added.entities.push(Entity {
            callsign,
            address: None,
            class: row.class.clone(),
            application: 1 + (index as u16) % PARTITIONS,
            number: 1 + index as u16,
            trajectory: None,
            report: None,
        });
        added.entries.push(FlightEntry {
            callsign,
            address: None,
            type_designator: "FOLLOWME".into(),
            wake: None,
            movement: MovementKind::Vehicle,
            runway: String::new(),
            stand: String::new(),
            stand_m: None,
            eta_ctd: SimTime::ZERO,
            off_block: None,
            routing: Vec::new(),
        });
    }
    let pieces = with_truth.then(|| Arc::new(Pieces::of(&network, &Core::classes(&flights))));
    let behaving = Behaving {
        network: Arc::new(network),
        pieces,
        flights: Arc::new(flights),
        first_entity,
        policy: control.policy,
        cleared_by: match (control.sees, control.controllers) {
            (Sees::Truth, true) => ClearedBy::Controllers,
            (Sees::Tracks, true) => ClearedBy::Notices,
            _ => ClearedBy::Plan,
        },
        errors: control.errors,
        stop_bars: control.stop_bars,
        failures,
        obstacles: Vec::new(),
        remarks,
    };
    Ok((Some(behaving), added))
}

/// A stand by its name; files write "A 17", "A_17" and "A17" for one stand.
fn stand_named(network: &Network, name: &str) -> Option<usize> {
    let bare = |text: &str| text.replace([' ', '_'], "");
    let exact = network.stands.iter().position(|s| s.name == name);
    exact.or_else(|| {
        let wanted = bare(name);
        let mut same = (0..network.stands.len())
            .filter(|s| bare(&network.stands[*s].name) == wanted && !wanted.is_empty());
        let first = same.next()?;
        same.next().is_none().then_some(first)
    })
}

/// Types of a demand that names none, with weights, and what comes instead where the runways are too short for all of them.
const USUAL_MIX: [(&str, f64); 4] = [("A320", 5.0), ("B738", 4.0), ("E190", 2.0), ("A333", 1.0)];
const SMALLER_MIXES: [&[(&str, f64)]; 2] = [
    &[("AT75", 3.0), ("DH8D", 2.0), ("E145", 1.0), ("C550", 2.0)],
    &[("C550", 1.0), ("C172", 4.0)],
];

fn owned(mix: &[(&str, f64)]) -> Vec<(String, f64)> {
    mix.iter().map(|(d, w)| ((*d).to_owned(), *w)).collect()
}

/// What a type says of a flight.
fn flight_of(row: &TypeRow) -> Flight {
    let (class, k) = (&row.class, &row.kinematics);
    let usual = runs_where_unknown(&class.designator, row.wake);
    Flight {
        callsign: String::new(),
        size: Size { length_m: class.length_m, span_m: class.span_m, aircraft: class.aircraft },
        direction: Direction::Arrival,
        runway: (0, 0),
        stand: 0,
        time_s: 0.0,
        turnaround_of: None,
        wake: row.wake.unwrap_or(WakeCategory::Medium),
        taxi_mps: (k.taxi_straight_mps, k.taxi_turn_mps),
        taxi_acc_mps2: (k.taxi_acc_ms2, k.taxi_dec_ms2),
        take_off: (
            k.liftoff_mps.unwrap_or(usual.liftoff_mps),
            row.takeoff_dist_m.unwrap_or(usual.run_m),
        ),
        landing: (
            k.touchdown_mps.unwrap_or(usual.touchdown_mps),
            k.braking_ms2.unwrap_or(usual.braking_mps2),
        ),
        wheelbase_m: wheelbase_m(&class.designator, class.length_m),
        idle_kg_per_s: idle_kg_per_s(&class.designator),
        key: 0,
    }
}

/// Runs of a type where `types.csv` knows none.
struct UsualRuns {
    liftoff_mps: f64,
    run_m: f64,
    touchdown_mps: f64,
    braking_mps2: f64,
}

/// Usual values of manuals, from memory; other light types fly like a light twin, all others like an A320.
fn runs_where_unknown(designator: &str, wake: Option<WakeCategory>) -> UsualRuns {
    let (liftoff_mps, run_m, touchdown_mps, braking_mps2) = match (designator, wake) {
        ("C172", _) => (30.0, 290.0, 28.0, 1.2),
        ("C550", _) => (55.0, 850.0, 54.0, 1.4),
        ("AT75", _) => (56.6, 1100.0, 56.0, 1.3),
        ("DH8D", _) => (62.0, 1100.0, 61.0, 1.4),
        ("E145", _) => (68.0, 1500.0, 66.0, 1.3),
        ("CRJ9", _) => (76.0, 1600.0, 71.0, 1.3),
        (_, Some(WakeCategory::Light)) => (45.0, 600.0, 42.0, 1.2),
        _ => (85.3, 1650.0, 69.4, 1.22),
    };
    UsualRuns { liftoff_mps, run_m, touchdown_mps, braking_mps2 }
}

/// From nose wheel to main gear, m (standard literature, from memory; others 0.37 of the length).
fn wheelbase_m(designator: &str, length_m: f64) -> f64 {
    let known = [
        ("A319", 11.0),
        ("A320", 12.6),
        ("A321", 16.9),
        ("B737", 12.6),
        ("B738", 15.6),
        ("B752", 18.3),
        ("B763", 22.8),
        ("A332", 22.2),
        ("A333", 25.4),
        ("B788", 22.8),
        ("B789", 25.8),
        ("A359", 28.7),
        ("B744", 25.6),
        ("B77W", 31.2),
        ("A388", 31.9),
        ("E190", 13.8),
        ("CRJ9", 17.3),
        ("E145", 14.5),
        ("AT75", 10.8),
        ("DH8D", 13.9),
        ("C550", 5.6),
        ("C172", 1.7),
    ];
    known.iter().find(|k| k.0 == designator).map_or(0.37 * length_m, |k| k.1)
}

/// Fuel of all engines at idle, kg/s (orders of the ICAO databank, from memory).
fn idle_kg_per_s(designator: &str) -> f64 {
    match designator {
        "B752" => 0.36,
        "B763" => 0.40,
        "A332" | "A333" | "A359" => 0.52,
        "B744" => 0.84,
        "B77W" => 0.76,
        "B788" | "B789" => 0.44,
        "A388" => 1.20,
        "E190" => 0.18,
        "CRJ9" | "E145" => 0.12,
        "AT75" | "DH8D" => 0.10,
        "C550" => 0.04,
        _ => 0.22,
    }
}

// ---- tables -----------------------------------------------------------------------------------------

struct CsvRow {
    line: usize,
    cells: BTreeMap<String, String>,
    departs_ns: Option<i64>,
    lands_ns: Option<i64>,
}

impl CsvRow {
    fn cell(&self, name: &str) -> &str {
        self.cells.get(name).map_or("", String::as_str)
    }
}

fn rows_of(file: &Path) -> Result<Vec<CsvRow>, ScenarioError> {
    let damaged = |line: usize, column: &str, found: String, needed: &'static str| {
        ScenarioError::new(file, line, column, Problem::Line { found, needed })
    };
    const TABLE: &str = "a comma-separated table with a header";
    let octets = crate::files::read(file, crate::LARGEST_DATA)
        .map_err(|e| damaged(1, "schedule", e.to_string(), TABLE))?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(octets.as_ref());
    let header =
        reader.headers().map_err(|e| damaged(1, "schedule", e.to_string(), TABLE))?.clone();
    for needed in ["callsign", "type", "movement", "runway", "stand"] {
        if !header.iter().any(|h| h == needed) {
            return Err(damaged(1, "schedule", format!("no column {needed}"), TABLE));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let line_of = |p: Option<&csv::Position>| p.map_or(1, |p| p.line() as usize);
        let record =
            record.map_err(|e| damaged(line_of(e.position()), "schedule", e.to_string(), TABLE))?;
        let line = line_of(record.position());
        let pairs = header.iter().zip(record.iter());
        let cells: BTreeMap<String, String> =
            pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        let mut row = CsvRow { line, cells, departs_ns: None, lands_ns: None };
        let time = |name: &'static str| -> Result<Option<i64>, ScenarioError> {
            let text = row.cell(name);
            if text.is_empty() {
                return Ok(None);
            }
            let ns = utc_ns(text);
            ns.map(Some).ok_or_else(|| {
                damaged(line, name, text.into(), "a UTC time like 2026-05-12T06:05:00Z")
            })
        };
        match row.cell("movement") {
            "departure" => {
                let times = [time("tobt")?, time("eobt")?, time("sobt")?];
                let departs = times.into_iter().flatten().next();
                row.departs_ns = Some(departs.ok_or_else(|| {
                    damaged(line, "eobt", String::new(), "one of tobt, eobt, sobt")
                })?);
            }
            "arrival" => {
                let lands = time("eldt")?.or(time("sibt")?.map(|t| t - 480_000_000_000));
                row.lands_ns =
                    Some(lands.ok_or_else(|| {
                        damaged(line, "eldt", String::new(), "one of eldt, sibt")
                    })?);
            }
            other => {
                return Err(damaged(line, "movement", other.into(), "arrival or departure"));
            }
        }
        rows.push(row);
    }
    Ok(rows)
}

/// `2026-05-12T06:05:00Z`, nanoseconds since 1970.
pub(crate) fn utc_ns(text: &str) -> Option<i64> {
    let (date, clock) = text.strip_suffix('Z')?.split_once('T')?;
    let numbers = |text: &str, separator: char| -> Option<Vec<i64>> {
        text.split(separator).map(|p| p.parse().ok()).collect()
    };
    let (date, clock) = (numbers(date, '-')?, numbers(clock, ':')?);
    let [year, month, day] = date[..] else { return None };
    let [hour, minute, second] = clock[..] else { return None };
    let sound = (1900..2200).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && (0..24).contains(&hour)
        && (0..60).contains(&minute)
        && (0..=60).contains(&second);
    let days = days_from_civil(year, month, day);
    sound.then(|| (((days * 24 + hour) * 60 + minute) * 60 + second) * 1_000_000_000)
}

/// The flights of a table; what lies before the start of the run is over.
fn scheduled(file: &Path, run: &Run) -> Result<Vec<Wanted>, ScenarioError> {
    const DAY_NS: i64 = 86_400_000_000_000;
    let rows = rows_of(file)?;
    let times = || rows.iter().filter_map(|r| r.departs_ns.or(r.lands_ns));
    let first_day = times().min().map_or(0, |t| t.div_euclid(DAY_NS));
    let shift_ns = (run.start_utc_ns.div_euclid(DAY_NS) - first_day) * DAY_NS;
    let mut names = BTreeSet::new();
    let mut wanted = Vec::new();
    for row in &rows {
        let Some(ns) = row.departs_ns.or(row.lands_ns) else { continue };
        let time_s = (ns + shift_ns - run.start_utc_ns) as f64 / 1e9;
        let departure = row.departs_ns.is_some();
        if time_s < if departure { -900.0 } else { 0.0 } || time_s > run.duration.s() {
            continue;
        }
        let callsign = row.cell("callsign").to_owned();
        let sound = Callsign::new(&callsign).as_str() == callsign && !callsign.is_empty();
        if !sound || !names.insert(callsign.clone()) {
            let needed = "1 to 11 upper-case letters, digits or signs, each once";
            let problem = Problem::Line { found: callsign, needed };
            return Err(ScenarioError::new(file, row.line, "callsign", problem));
        }
        let after = row.cell("turnaround_of");
        wanted.push(Wanted {
            line: row.line,
            callsign,
            address: u32::from_str_radix(row.cell("address"), 16).ok().filter(|a| *a > 0),
            designator: row.cell("type").into(),
            direction: if departure { Direction::Departure } else { Direction::Arrival },
            runway: row.cell("runway").into(),
            stand: row.cell("stand").replace(' ', "_"),
            time_s: time_s.max(0.0),
            turnaround_of: (!after.is_empty()).then(|| after.into()),
        });
    }
    Ok(wanted)
}

// ---- generated --------------------------------------------------------------------------------------

/// Flights by rates: draws belong to a flight's number, so that another rate keeps who they are.
fn generated(
    section: &Section,
    run: &Run,
    network: &Network,
    types: &TypeTable,
    remarks: &mut Vec<String>,
) -> Result<Vec<Wanted>, ScenarioError> {
    let rate = |key: &str| section.number_or(key, 0.0, within(0.0, 2000.0, "flights/h"));
    let (arrivals, departures) = (rate("arrivals_per_h")?, rate("departures_per_h")?);
    let seed = section.integer("seed", 0, i64::MAX)?.map_or(run.seed, |s| s as u64);
    let even = section.choice("profile", &[("poisson", false), ("even", true)])?.unwrap_or(false);
    let mut mix: Vec<(String, f64)> = Vec::new();
    if let Some(table) = section.any_section("mix")? {
        for designator in table.keys() {
            let weight = table.need_number(designator, within(0.0, 1e6, ""))?;
            if types.get(designator).is_none_or(|t| !t.class.aircraft) {
                let allowed = types.designators().collect::<Vec<_>>().join(", ");
                let found = designator.into();
                return Err(table.refuse(designator, Problem::NotAllowed { found, allowed }));
            }
            mix.push((designator.to_owned(), weight));
        }
    }
    let drawn_mix = mix.iter().all(|m| m.1 <= 0.0);
    if drawn_mix {
        mix = owned(&USUAL_MIX);
    }
    let ends = |key: &str, arrival: bool| -> Result<Vec<String>, ScenarioError> {
        let given: Vec<String> = section.texts(key)?.into_iter().map(|(n, _)| n).collect();
        Ok(if given.is_empty() { default_ends(network, arrival) } else { given })
    };
    let (landing, leaving) = (ends("arrival_runways", true)?, ends("departure_runways", false)?);
    let usable: Vec<usize> = (0..network.stands.len())
        .filter(|s| network.stands[*s].node.is_some_and(|n| network.nodes[n].used))
        .collect();
    if (arrivals > 0.0 && landing.is_empty())
        || (departures > 0.0 && leaving.is_empty())
        || usable.is_empty()
    {
        let needed = "a runway with entries and exits, and stands with a way".into();
        let found = format!("an airport where {}", network.findings.join("; "));
        return Err(section.refuse("kind", Problem::WrongKind { found, needed }));
    }
    let lacks = |designator: &str| {
        types.get(designator).map_or(0.0, |row| {
            let none: &[String] = &[];
            let landing = if arrivals > 0.0 { &landing } else { none };
            lacks_m(network, row, landing, if departures > 0.0 { &leaving } else { none })
        })
    };
    // Nobody asked for airliners: where none fits, smaller ones come.
    let fits =
        |mix: &[(String, f64)]| mix.iter().any(|m| types.get(&m.0).is_some() && lacks(&m.0) <= 0.0);
    if drawn_mix && !fits(&mix) {
        let smaller = SMALLER_MIXES.iter().map(|m| owned(m)).find(|m| fits(m));
        mix = smaller.unwrap_or(mix);
    }
    let too_long = mix.iter().filter(|m| lacks(&m.0) > 0.0).map(|m| m.0.clone());
    let too_long = too_long.collect::<Vec<_>>().join(", ");
    let least = mix.iter().map(|m| lacks(&m.0)).fold(f64::INFINITY, f64::min);
    if least > 0.0 {
        let ends: std::collections::BTreeSet<&str> =
            landing.iter().chain(&leaving).map(String::as_str).collect();
        let ends = ends.into_iter().collect::<Vec<_>>().join(", ");
        let found = format!(
            "{too_long}, of which each lacks {least:.0} m or more to an exit, or from an entry, that stands have a way to"
        );
        let needed = format!("a mix with a type that runway {ends} is long enough for");
        return Err(section.refuse("mix", Problem::WrongKind { found, needed }));
    }
    mix.retain(|m| (!drawn_mix || types.get(&m.0).is_some()) && lacks(&m.0) <= 0.0);
    if !too_long.is_empty() {
        remarks.push(format!(
            "{too_long}: left out, the runways are too short for them or too narrow to turn on"
        ));
    }
    let mut drawn: Vec<Drawn> = Vec::new();
    let kinds =
        [(Direction::Arrival, arrivals, landing), (Direction::Departure, departures, leaving)];
    for (kind, (direction, per_h, runways)) in kinds.into_iter().enumerate() {
        if per_h <= 0.0 {
            continue;
        }
        let mut time_s = if direction == Direction::Arrival { 260.0 } else { 30.0 };
        for number in 0..5000_u64 {
            let key = DrawKey { run_seed: seed, sensor: 1 + kind as u32, entity: number, scan: 0 };
            let mut rng = key.rng(Purpose::Mover);
            let gap = if even { 1.0 } else { exponential(&mut rng) };
            time_s += gap * 3600.0 / per_h;
            if time_s > run.duration.s() {
                break;
            }
            let total: f64 = mix.iter().map(|m| m.1).sum();
            let mut left = uniform(&mut rng) * total;
            let designator = mix
                .iter()
                .find(|m| {
                    left -= m.1;
                    left <= 0.0
                })
                .map_or("A320", |m| m.0.as_str());
            let place = uniform(&mut rng);
            let (mean_min, sigma_min) =
                match types.get(designator).map(|t| code_of_span(t.class.span_m)) {
                    Some(0..=2) | None => (48.0, 12.0),
                    _ => (95.0, 15.0),
                };
            let turn_round_s = 60.0 * (mean_min + sigma_min * normal_pair(&mut rng).0).max(35.0);
            drawn.push(Drawn {
                number,
                direction,
                time_s,
                designator: designator.to_owned(),
                runway: runways[number as usize % runways.len()].clone(),
                place,
                turn_round_s,
            });
        }
    }
    Ok(on_stands(section, network, types, &usable, drawn, remarks))
}

/// A flight by rates, before it has a stand.
struct Drawn {
    number: u64,
    direction: Direction,
    time_s: f64,
    designator: String,
    runway: String,
    /// Draw for its stand.
    place: f64,
    /// Of an arrival: from its landing to its earliest off-block, s.
    turn_round_s: f64,
}

/// Stands for drawn flights: a departure is the turn-round of the first arrival that is ready, else of the first
/// population; nobody is put where somebody else is or beside whom there is no room. Who finds none is left out.
fn on_stands(
    section: &Section,
    network: &Network,
    types: &TypeTable,
    usable: &[usize],
    drawn: Vec<Drawn>,
    remarks: &mut Vec<String>,
) -> Vec<Wanted> {
    let size_of = |d: &Drawn| {
        let (length_m, span_m) =
            types.get(&d.designator).map_or((37.6, 35.8), |t| (t.class.length_m, t.class.span_m));
        Size { length_m, span_m, aircraft: true }
    };
    let heading = |s: usize| {
        let node = network.stands[s].node?;
        let edge = network.edges.iter().find(|e| e.nodes.contains(&node))?;
        let from = edge.nodes[usize::from(edge.nodes[0] == node)];
        let at_m = network.nodes[node].at_m;
        Some((at_m, Azimuth::of(at_m - network.nodes[from].at_m).rad()))
    };
    let poses: Vec<_> = (0..network.stands.len()).map(heading).collect();
    // Stands by runway end, code and direction.
    let mut known: BTreeMap<(String, u8, bool), Vec<bool>> = BTreeMap::new();
    let mut reach = |name: &str, code: u8, arrival: bool| -> Vec<bool> {
        let key = (name.to_owned(), code, arrival);
        let found = known.entry(key).or_insert_with(|| match end_named(network, name) {
            Some(end) => Reach::of(network, end, arrival).stands(code, 0.0),
            None => vec![true; network.stands.len()],
        });
        found.clone()
    };
    let widest_m = drawn.iter().map(|d| size_of(d).span_m).fold(36.0, f64::max);
    // Who leaves as whose turn-round: the first that is ready.
    let mut order: Vec<usize> = (0..drawn.len()).collect();
    order.sort_by(|a, b| drawn[*a].time_s.total_cmp(&drawn[*b].time_s).then(a.cmp(b)));
    let mut leaves_as: Vec<Option<usize>> = vec![None; drawn.len()];
    let mut comes_as: Vec<Option<usize>> = vec![None; drawn.len()];
    for d in order.iter().filter(|d| drawn[**d].direction == Direction::Departure) {
        let ready = order.iter().copied().find(|a| {
            drawn[*a].direction == Direction::Arrival
                && leaves_as[*a].is_none()
                && drawn[*a].time_s + 480.0 + drawn[*a].turn_round_s <= drawn[*d].time_s
        });
        if let Some(a) = ready {
            (leaves_as[a], comes_as[*d]) = (Some(*d), Some(a));
        }
    }
    // Occupied: stand, from, to, size.
    let mut taken: Vec<(usize, f64, f64, Size)> = Vec::new();
    let mut stand_of: Vec<Option<usize>> = vec![None; drawn.len()];
    let first_population = order
        .iter()
        .copied()
        .filter(|i| drawn[*i].direction == Direction::Departure && comes_as[*i].is_none());
    let landing = order.iter().copied().filter(|i| drawn[*i].direction == Direction::Arrival);
    for i in first_population.chain(landing) {
        let d = &drawn[i];
        let size = size_of(d);
        let (from, to) = match (d.direction, leaves_as[i]) {
            (Direction::Departure, _) => (d.time_s - 2400.0, d.time_s + 900.0),
            (_, Some(next)) => (d.time_s - 300.0, drawn[next].time_s + 900.0),
            _ => (d.time_s - 300.0, f64::INFINITY),
        };
        let free = |s: usize| {
            let Some((at_m, heading_rad)) = poses[s] else { return false };
            taken.iter().all(|(other, begin, end, theirs)| {
                if *begin >= to || *end <= from {
                    return true;
                }
                let Some((there, towards)) = poses[*other] else { return true };
                *other != s
                    && ((there - at_m).norm() > 120.0
                        || distance_m(
                            &outline(size, at_m, heading_rad),
                            &outline(*theirs, there, towards),
                        ) > 4.0)
            })
        };
        let need = code_of_span(size.span_m);
        let mut reached = reach(&d.runway, need, d.direction == Direction::Arrival);
        if let Some(next) = leaves_as[i] {
            let left = reach(&drawn[next].runway, need, false);
            reached.iter_mut().zip(left).for_each(|(r, l)| *r &= l);
        }
        let fits = |s: usize| network.stands[s].code >= need && reached[s];
        let mut fitting: Vec<usize> =
            usable.iter().copied().filter(|s| fits(*s) && free(*s)).collect();
        // Who would close a lane goes elsewhere, where there is an elsewhere.
        let clear = |s: &usize| {
            poses[*s].is_some_and(|(at_m, heading_rad)| {
                clear_of_lanes(network, &outline(size, at_m, heading_rad), widest_m)
            })
        };
        if fitting.iter().any(clear) {
            fitting.retain(clear);
        }
        if fitting.is_empty() {
            continue;
        }
        let stand = fitting[(d.place * fitting.len() as f64) as usize % fitting.len()];
        taken.push((stand, from, to, size));
        stand_of[i] = Some(stand);
    }
    let mut wanted = Vec::new();
    let mut left_out = 0;
    let name = |d: &Drawn| {
        let letter = if d.direction == Direction::Arrival { "A" } else { "D" };
        format!("G{letter}{:04}", d.number + 1)
    };
    for (i, d) in drawn.iter().enumerate() {
        let aircraft = comes_as[i].unwrap_or(i);
        let Some(stand) = stand_of[aircraft] else {
            left_out += 1;
            continue;
        };
        let kind = u32::from(d.direction == Direction::Departure);
        wanted.push(Wanted {
            line: section.line_of("kind"),
            callsign: name(d),
            address: Some(0x50_0000 + kind * 0x1_0000 + d.number as u32 + 1),
            designator: drawn[aircraft].designator.clone(),
            direction: d.direction,
            runway: d.runway.clone(),
            stand: network.stands[stand].name.clone(),
            time_s: d.time_s,
            turnaround_of: comes_as[i].map(|a| name(&drawn[a])),
        });
    }
    if left_out > 0 {
        remarks.push(format!(
            "{left_out} of {} drawn flights are left out: no stand is free for them",
            drawn.len()
        ));
    }
    wanted
}

/// Whether the widest of the demand can pass a parked outline on every lane that is wide enough for it.
fn clear_of_lanes(network: &Network, parked: &[Rectangle; 2], widest_m: f64) -> bool {
    let middle = (parked[0].corners_m[0] + parked[0].corners_m[2]) * 0.5;
    network.edges.iter().all(|edge| {
        let lead_in = edge.nodes.iter().any(|n| network.nodes[*n].stand.is_some());
        if lead_in || edge.strip.is_some() || edge.runway.is_some() {
            return true;
        }
        let [a, b] = edge.nodes.map(|n| network.nodes[n].at_m);
        if distance_to_segment_m(middle, a, b) > 80.0 {
            return true;
        }
        let line = Rectangle { corners_m: [a, b, b, a] };
        let span_m = if edge.code >= code_of_span(widest_m) { widest_m } else { 36.0 };
        distance_m(parked, &[line; 2]) > 0.5 * span_m + 3.0
    })
}
