//! `[[traffic]] kind = "schedule"` and `"generated"`: flights that behave, from a table or from rates.

use crate::airport::AirportScene;
use crate::document::{Section, days_from_civil, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::run::Run;
use crate::traffic::{Entity, PARTITIONS};
use crate::types::{TypeRow, TypeTable};
use models::draw::{DrawKey, Purpose, exponential, uniform};
use models::flight_list::{FlightEntry, MovementKind, WakeCategory};
use models::frames::{Azimuth, wrap_pi};
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::core::{Core, Direction, Flight, Policy};
use models::traffic::network::{Network, code_of_span};
use models::traffic::outline::Size;
use models::traffic::pieces::Pieces;
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
    /// What was moved or assumed, one line each.
    pub remarks: Vec<String>,
}

impl Behaving {
    /// The core at time 0 of a run with this seed, or `None` in a scene loaded without truth.
    #[must_use]
    pub fn core(&self, run: &Run, seed: u64) -> Option<Core> {
        let pieces = self.pieces.clone()?;
        let (net, flights) = (Arc::clone(&self.network), Arc::clone(&self.flights));
        Some(Core::new(net, pieces, flights, self.policy, seed, run.frame.s()))
    }
}

/// `[control]` of a scene: so far everything is cleared as the core decides.
pub(crate) fn read_policy(root: &Section) -> Result<Policy, ScenarioError> {
    let Some(section) = root.section("control", &words(keys::CONTROL))? else {
        return Ok(Policy::default());
    };
    section.choice("sees", &[("none", ())])?;
    let policies = [("ordered", Policy::Ordered), ("free", Policy::Free)];
    Ok(section.choice("policy", &policies)?.unwrap_or_default())
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
    let policy = read_policy(root)?;
    if sections.is_empty() {
        return Ok((None, added));
    }
    let network = Network::of(&airport.layout);
    let mut remarks = network.findings.clone();
    let mut flights: Vec<Flight> = Vec::new();
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
            _ => (section.file().to_path_buf(), generated(section, run, &network, types)?),
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
            let runway = network
                .runways
                .iter()
                .enumerate()
                .find_map(|(r, runway)| {
                    runway.names.iter().position(|n| *n == w.runway).map(|end| (r, end))
                })
                .ok_or_else(|| {
                    let names = network.runways.iter().flat_map(|r| r.names.iter());
                    refuse("runway", &w.runway, names.map(String::as_str).collect())
                })?;
            let mut stand =
                network.stands.iter().position(|s| s.name == w.stand).ok_or_else(|| {
                    refuse(
                        "stand",
                        &w.stand,
                        network.stands.iter().map(|s| s.name.as_str()).collect(),
                    )
                })?;
            let usable = |s: usize| network.stands[s].node.is_some_and(|n| network.nodes[n].used);
            let need = code_of_span(row.class.span_m);
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
            let arrival = w.direction == Direction::Arrival;
            added.entries.push(FlightEntry {
                callsign,
                address: w.address,
                type_designator: w.designator.clone(),
                wake: row.wake,
                movement: if arrival { MovementKind::Arrival } else { MovementKind::Departure },
                runway: w.runway.clone(),
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
    let pieces = with_truth.then(|| Arc::new(Pieces::of(&network, &Core::classes(&flights))));
    let behaving = Behaving {
        network: Arc::new(network),
        pieces,
        flights: Arc::new(flights),
        first_entity,
        policy,
        remarks,
    };
    Ok((Some(behaving), added))
}

/// What a type says of a flight; figures that the table lacks are those of an A320.
fn flight_of(row: &TypeRow) -> Flight {
    let (class, k) = (&row.class, &row.kinematics);
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
        take_off: (k.liftoff_mps.unwrap_or(85.3), row.takeoff_dist_m.unwrap_or(1650.0)),
        landing: (k.touchdown_mps.unwrap_or(69.4), k.braking_ms2.unwrap_or(1.22)),
        wheelbase_m: wheelbase_m(&class.designator, class.length_m),
        idle_kg_per_s: idle_kg_per_s(&class.designator),
        key: 0,
    }
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
fn utc_ns(text: &str) -> Option<i64> {
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
    if mix.iter().all(|m| m.1 <= 0.0) {
        mix = [("A320", 5.0), ("B738", 4.0), ("E190", 2.0), ("A333", 1.0)]
            .map(|(d, w)| (d.to_owned(), w))
            .to_vec();
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
    let mut wanted = Vec::new();
    let kinds = [
        (Direction::Arrival, arrivals, "A", landing),
        (Direction::Departure, departures, "D", leaving),
    ];
    for (kind, (direction, per_h, letter, runways)) in kinds.into_iter().enumerate() {
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
            let need = types.get(designator).map_or(2, |t| code_of_span(t.class.span_m));
            let fitting: Vec<usize> =
                usable.iter().copied().filter(|s| network.stands[*s].code >= need).collect();
            let from = if fitting.is_empty() { &usable } else { &fitting };
            let stand = from[(uniform(&mut rng) * from.len() as f64) as usize % from.len()];
            let runway = &runways[number as usize % runways.len()];
            wanted.push(Wanted {
                line: section.line_of("kind"),
                callsign: format!("G{letter}{:04}", number + 1),
                address: Some(0x50_0000 + (kind as u32) * 0x1_0000 + number as u32 + 1),
                designator: designator.to_owned(),
                direction,
                runway: runway.clone(),
                stand: network.stands[stand].name.clone(),
                time_s,
                turnaround_of: None,
            });
        }
    }
    Ok(wanted)
}

/// Ends that traffic uses where the scene says nothing: arrivals to the runway with most exits, departures
/// from the next best one that does not cross it, else from the same.
fn default_ends(network: &Network, arrival: bool) -> Vec<String> {
    let exits = |r: usize| {
        let strip = network.edges.iter().filter(|e| e.strip == Some(r) && e.runway.is_none());
        strip.filter(|e| e.nodes.iter().all(|n| network.nodes[*n].used)).count()
    };
    let mut order: Vec<usize> = (0..network.runways.len()).filter(|r| exits(*r) > 0).collect();
    order.sort_by_key(|r| (std::cmp::Reverse(exits(*r)), *r));
    let Some(first) = order.first().copied() else { return Vec::new() };
    let crosses = |a: usize, b: usize| {
        network.runways[a]
            .spine
            .iter()
            .any(|(_, n)| network.runways[b].spine.iter().any(|(_, m)| m == n))
    };
    let second = order[1..].iter().copied().find(|r| !crosses(*r, first)).unwrap_or(first);
    let r = if arrival { first } else { second };
    // Landings need exits far down the runway, take-offs entries with a long run ahead.
    let reach = |end: usize| {
        let runway = &network.runways[r];
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let mut best = 0.0_f64;
        for (place, node) in &runway.spine {
            for edge in network
                .edges
                .iter()
                .filter(|e| e.nodes.contains(node) && e.strip == Some(r) && e.runway.is_none())
            {
                let other = edge.nodes[usize::from(edge.nodes[0] == *node)];
                let away = network.nodes[other].at_m - network.nodes[*node].at_m;
                let heading = Azimuth::of(if arrival { away } else { -away }).rad();
                if wrap_pi(heading - direction).abs() < 2.0 {
                    let along = if end == 0 { *place } else { runway.length_m - place };
                    best = best.max(if arrival { along } else { runway.length_m - along });
                }
            }
        }
        best
    };
    let end = usize::from(!arrival && reach(1) > reach(0) + 1.0);
    vec![network.runways[r].names[end].clone()]
}
