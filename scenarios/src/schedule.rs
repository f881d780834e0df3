//! `[[traffic]] kind = "schedule"` and `"generated"`: flights that behave, from a table or from rates.

mod drawn;
mod ends;
mod flights;
mod generated;
pub mod handover;
mod rates;
mod reach;
mod refused;
mod stands;
pub(crate) mod table;
mod turn_rounds;
pub(crate) mod vehicles;
mod wake;

use crate::airport::AirportScene;
use crate::control::{Sees, Separation};
use crate::document::Section;
use crate::entity::{Entity, PARTITIONS};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::run::Run;
use crate::types::TypeTable;
pub(crate) use ends::TO_THE_END_S;
pub(crate) use flights::flight_of;
pub(crate) use flights::wheelbase_m;
use generated::{GENERATED_START_NS, generated};
use models::airport::Airport;
use models::control::lights::FailedBars;
use models::flight_list::{FlightEntry, MovementKind};
use models::frames::Point2;
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::core::{
    ClearedBy, Core, Day, Direction, Driven, Failure, FailureKind, Flight, Obstacle, Policy,
    drawn_failures,
};
use models::traffic::network::{NetRunway, Network, code_of_span};
use models::traffic::pieces::Pieces;
pub(crate) use reach::end_named;
use reach::{Ground, lands_instead, reached_stands};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use table::{rows_of, scheduled};
use turn_rounds::TurnRounds;
pub(crate) use wake::wake_of;

/// Flights of a scene that behave, and what they move on.
#[derive(Clone, Debug, PartialEq)]
pub struct Behaving {
    /// The ground network.
    pub network: Arc<Network>,
    /// Its pieces; `None` in a scene loaded without truth.
    pub pieces: Option<Arc<Pieces>>,
    /// The flights.
    pub flights: Arc<Vec<Flight>>,
    /// Vehicles that drive among them.
    pub vehicles: Vec<Flight>,
    /// Index of the first flight's entity; the others follow it in order, then vehicles, then places.
    pub first_entity: usize,
    /// Places for aircraft that other programs give (`handover`), each with the key of its draws.
    pub places: Vec<u64>,
    /// The weather, each from a time on, s.
    pub days: Days,
    /// Which piece may be taken.
    pub policy: Policy,
    /// Who clears: the plan, models of controllers in the core, or those of the member `control` by notices.
    pub cleared_by: ClearedBy,
    /// Errors of pilots, in multiples of what is assumed.
    pub errors: f64,
    /// Stop bars are in use.
    pub stop_bars: bool,
    /// Departures leave their stands by the best sequence of take-offs within so many places; `None`: first come.
    pub shift: Option<usize>,
    /// Categories of wake that aircraft are separated by.
    pub wake: Separation,
    /// Lamps of the taxiways show each flight its way.
    pub greens: bool,
    /// What goes wrong.
    pub failures: Vec<Failure>,
    /// Movers of the scene that are functions of time.
    pub obstacles: Vec<Obstacle>,
    /// Movers that people drive; their entities are the last ones.
    pub driven: Vec<Driven>,
    /// People may take flights that taxi.
    pub by_hand: bool,
    /// Where it is paved, for both: outlines, m, not closed.
    pub pavement_m: Vec<Vec<Point2<f64>>>,
    /// What was moved or assumed, one line each.
    pub remarks: Vec<String>,
    /// What of the demand is left out since the airport does not bear it, one line each.
    pub left_out: Vec<String>,
}

impl Behaving {
    /// What goes wrong in a run with this seed: what the scene says and what is drawn.
    #[must_use]
    pub fn failures_of(&self, seed: u64) -> Vec<Failure> {
        let drawn = drawn_failures(&self.flights, seed, self.errors, (self.stop_bars, self.greens));
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
        let core = self.told_core(run, seed)?;
        Some(match self.cleared_by {
            ClearedBy::Controllers => {
                core.with_controllers().with_departures(self.departure_manager())
            }
            _ => core,
        })
    }

    /// The same in a run of the federation, where controllers are the member `control`: what they clear comes as notices.
    #[must_use]
    pub fn told_core(&self, run: &Run, seed: u64) -> Option<Core> {
        let pieces = self.pieces.clone()?;
        let net = Arc::clone(&self.network);
        let (flights, random) = (self.with_places(), (seed, run.frame.s()));
        let days = Arc::clone(&self.days);
        let core = Core::in_weather((net, pieces), flights, self.policy, random, days);
        let core = core.with_places(self.places.len());
        let core = core.with_obstacles(self.obstacles.clone());
        let core = core.with_failures(&self.failures_of(seed));
        let core = core.with_driven(&self.driven, self.by_hand, self.pavement_m.clone());
        let core = if self.greens { core.with_greens(seed, self.errors) } else { core };
        Some(match self.cleared_by {
            ClearedBy::Plan => core.with_departures(self.departure_manager()),
            ClearedBy::Notices | ClearedBy::Controllers => core.cleared_by(ClearedBy::Notices),
        })
    }
}

impl Behaving {
    /// The flights, behind them the vehicles, and then the places for those who are given: nobody is expected there.
    fn with_places(&self) -> Arc<Vec<Flight>> {
        let like = self.flights.first().filter(|_| !self.places.is_empty());
        if like.is_none() && self.vehicles.is_empty() {
            return Arc::clone(&self.flights);
        }
        let all = self.flights.iter().chain(&self.vehicles).cloned();
        let Some(like) = like else { return Arc::new(all.collect()) };
        let place = |key: &u64| Flight {
            callsign: String::new(),
            direction: Direction::Arrival,
            time_s: f64::INFINITY,
            turnaround_of: None,
            key: *key,
            ..like.clone()
        };
        Arc::new(all.chain(self.places.iter().map(place)).collect())
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
    ctot_s: Option<f64>,
    turnaround_of: Option<String>,
}

/// Index of a runway and of its end.
type RunwayEnd = (usize, usize);

/// The weather as movers feel it: each from a time on, s; the first from 0.
pub(crate) type Days = Arc<Vec<(f64, Day)>>;

/// Reads all sections of these kinds.
pub(crate) fn read(
    root: &Section,
    sections: &[&Section],
    run: &Run,
    (airport, days): (&AirportScene, Days),
    types: &TypeTable,
    (first_entity, places): (usize, Option<&handover::Places>),
    with_truth: bool,
) -> Result<(Option<Behaving>, Added), ScenarioError> {
    let mut added = Added { entities: Vec::new(), entries: Vec::new(), files: Vec::new() };
    let control = crate::control::read(root)?;
    if sections.is_empty() {
        return Ok((None, added));
    }
    let network = Network::of(&airport.layout);
    let lasts = |[from, until]: [SimTime; 2]| from <= SimTime::ZERO && until >= run.duration;
    let closed = |r: &NetRunway| {
        let own = airport.layout.runways.iter().filter(|own| own.names == r.names);
        own.flat_map(|own| airport.layout.details.closed_runways(own)).any(lasts)
    };
    let closed = network.runways.iter().map(closed).collect();
    let ground = Ground::of(&network, &days, closed);
    let (mut remarks, mut left_out) = (network.findings.clone(), Vec::new());
    let mut flights: Vec<Flight> = Vec::new();
    // Stands that a way leads to, by code letter, as they are needed.
    let mut reached: [Option<Vec<bool>>; 6] = [const { None }; 6];
    // Where landings go for whom no way leads to a stand, by runway end and code letter.
    let mut instead: BTreeMap<(RunwayEnd, u8), Option<RunwayEnd>> = BTreeMap::new();
    let mut driving = Vec::new();
    let mut drawn_before = 0;
    let mut lines: BTreeMap<String, usize> = BTreeMap::new();
    let mut turn_rounds = TurnRounds::default();
    for section in sections {
        let kind = section.text("kind")?;
        let drawn = kind != Some("schedule");
        let (file, wanted) = match kind {
            Some("schedule") => {
                let file = section.file_path("file")?.ok_or_else(|| {
                    section.missing("file", "the name of a schedule (CSV)".into())
                })?;
                added.files.push(file.clone());
                let (wanted, over) = scheduled(&file, run)?;
                turn_rounds.over(over);
                (file, wanted)
            }
            _ => {
                driving.extend(vehicles::wanted(section, types)?);
                let in_use = &airport.layout.details.in_use;
                let numbered = (*section, &mut drawn_before);
                let told = (&mut remarks, &mut left_out);
                let flights = generated(numbered, run, &ground, in_use, types, told)?;
                (section.file().to_path_buf(), flights)
            }
        };
        let (count, mut short) = (wanted.len(), Vec::new());
        for w in wanted {
            let index = first_entity + flights.len();
            let refuse = |column: &'static str, found: &str, allowed: Vec<&str>| {
                let allowed = crate::document::one_of(found, &allowed);
                let problem = Problem::NotAllowed { found: found.into(), allowed };
                ScenarioError::new(&file, w.line, column, problem)
            };
            if let Some(first_line) = lines.insert(w.callsign.clone(), w.line) {
                let problem = Problem::Duplicate { found: w.callsign.clone(), first_line };
                return Err(ScenarioError::new(&file, w.line, "callsign", problem));
            }
            let row = types.get(&w.designator).filter(|t| t.class.aircraft).ok_or_else(|| {
                let flies = |d: &&str| types.get(d).is_some_and(|t| t.class.aircraft);
                refuse("type", &w.designator, types.designators().filter(flies).collect())
            })?;
            let runway = end_named(&network, &w.runway).ok_or_else(|| {
                let names = network.runways.iter().flat_map(|r| r.names.iter());
                refuse("runway", &w.runway, names.map(String::as_str).collect())
            })?;
            let need = code_of_span(row.class.span_m);
            let arrival = w.direction == Direction::Arrival;
            let known = arrival.then(|| instead.entry((runway, need)));
            let other =
                known.and_then(|k| *k.or_insert_with(|| lands_instead(&ground, runway, need)));
            let runway = other.unwrap_or(runway);
            let runway_name = network.runways[runway.0].names[runway.1].clone();
            if other.is_some() {
                remarks.push(format!(
                    "{}: no stand is reached from the exits of runway {}, lands on {runway_name}",
                    w.callsign, w.runway
                ));
            }
            if let Some(lack) = refused::lack(&ground, &w, row, runway) {
                match lack {
                    refused::Lack::Now(text) => remarks.push(text),
                    // Nobody named a drawn one: the others come.
                    refused::Lack::Always(text) if drawn => {
                        short.push(text);
                        continue;
                    }
                    refused::Lack::Always(found) => {
                        let needed = "a longer runway, a lighter type or other weather".into();
                        let problem = Problem::WrongKind { found, needed };
                        return Err(ScenarioError::new(&file, w.line, "runway", problem));
                    }
                }
            }
            let mut stand = stand_named(&network, &w.stand).ok_or_else(|| {
                refuse("stand", &w.stand, network.stands.iter().map(|s| s.name.as_str()).collect())
            })?;
            let reached = reached[usize::from(need.min(5))]
                .get_or_insert_with(|| reached_stands(&ground, need));
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
            turn_rounds.add(&w, &file);
            flights.push(Flight {
                callsign: w.callsign.clone(),
                direction: w.direction,
                runway,
                stand,
                time_s: w.time_s,
                ctot_s: w.ctot_s,
                turnaround_of: None,
                wake: wake_of(row, control.wake),
                key: entity.key(run.site),
                ..flight_of(row)
            });
            added.entities.push(entity);
        }
        if let Some(first) = short.first() {
            let gone = short.len();
            left_out.push(format!(
                "{gone} of {count} drawn flights are left out: the runway is too short for them in the weather, like {first}"
            ));
        }
    }
    turn_rounds.resolve(&mut flights, &mut remarks)?;
    remarks.extend(on_closed(&airport.layout, &network, &flights));
    let first = first_entity + flights.len();
    let draws = (run.site, run.seed, first);
    if control.policy != Policy::Planned && !driving.is_empty() {
        let count = driving.len();
        left_out.push(format!("{count} vehicles are left out: they drive in a planned order only"));
        driving.clear();
    }
    let vehicles = vehicles::placed(&driving, (&network, &flights), types, draws, &mut left_out);
    let mut driven_by_models = Vec::new();
    for (vehicle, entity, entry) in vehicles {
        driven_by_models.push(vehicle);
        added.entities.push(entity);
        added.entries.push(entry);
    }
    let vehicles = driven_by_models;
    let first = first + vehicles.len();
    let mut keys = Vec::new();
    for n in 0..places.map_or(0, |p| p.count) {
        let entity = handover::entity(first + n, n, types)
            .ok_or_else(|| root.missing("traffic", "aircraft in types.csv".into()))?;
        keys.push(entity.key(run.site));
        added.entities.push(entity);
    }
    if first + keys.len() > 60_000 {
        let problem = Problem::OutOfRange {
            found: (first - first_entity + keys.len()) as f64,
            low: 0.0,
            high: 60_000.0,
            unit: "movers",
        };
        return Err(root.refuse("traffic", problem));
    }
    let failures = crate::control::read_failures(root, &flights, control.stop_bars)?;
    let cars = failures.iter().filter(|f| f.kind == FailureKind::VehicleOnRunway);
    for (n, failure) in cars.enumerate() {
        let row = types
            .get("FOLLOWME")
            .ok_or_else(|| root.missing("failure", "a type FOLLOWME in types.csv".into()))?;
        let index = first + keys.len() + n;
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
    let mut classes = Core::classes(&flights);
    classes.extend(Core::classes(&vehicles));
    classes.extend(places.and_then(|p| p.largest));
    classes.sort_unstable();
    classes.dedup();
    let pieces = with_truth.then(|| Arc::new(Pieces::of(&network, &classes)));
    let behaving = Behaving {
        network: Arc::new(network),
        pieces,
        flights: Arc::new(flights),
        vehicles,
        first_entity,
        places: keys,
        days,
        policy: control.policy,
        cleared_by: match (control.sees, control.controllers) {
            (Sees::Truth, true) => ClearedBy::Controllers,
            (Sees::Tracks, true) => ClearedBy::Notices,
            _ => ClearedBy::Plan,
        },
        errors: control.errors,
        stop_bars: control.stop_bars,
        shift: control.shift,
        wake: control.wake,
        greens: control.greens,
        failures,
        obstacles: Vec::new(),
        driven: Vec::new(),
        by_hand: control.by_hand,
        pavement_m: Vec::new(),
        remarks,
        left_out,
    };
    Ok((Some(behaving), added))
}

/// A stand by its name; files write "A 17", "A_17" and "A17" for one stand.
pub(crate) fn stand_named(network: &Network, name: &str) -> Option<usize> {
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

/// Flights that are given a runway at a time at which it is closed: whoever named it wants them, or has not seen it.
fn on_closed(airport: &Airport, network: &Network, flights: &[Flight]) -> Vec<String> {
    let closures = airport.runways.iter().flat_map(|own| {
        airport.details.closed_runways(own).map(move |[from, until]| (&own.names, from, until))
    });
    let told = closures.filter_map(|(names, from, until)| {
        let there = |f: &&Flight| {
            let time = SimTime::from_s(f.time_s);
            network.runways[f.runway.0].names == *names && from <= time && time < until
        };
        let count = flights.iter().filter(there).count();
        let until = match until.0 {
            i64::MAX => "the end".to_owned(),
            _ => format!("{:.0} s", until.s()),
        };
        (count > 0).then(|| {
            let (name, from) = (names.join("/"), from.s().max(0.0));
            format!("closed runway: {count} flights are due on {name}, closed from {from:.0} s to {until}")
        })
    });
    told.collect()
}
