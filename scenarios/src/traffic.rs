//! `[[traffic]]`: who moves how, and what the flight list says of it.

use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::driven;
use crate::entity::{Entity, PARTITIONS};
use crate::error::{Problem, ScenarioError};
use crate::hash::Fnv;
use crate::keys::{self, words};
use crate::movements::{self, Movement};
use crate::places::Places;
use crate::run::Run;
use crate::schedule::{self, Behaving, Days, handover};
use crate::shapes::ShapeSet;
use crate::types::{self, TypeRow, TypeTable};
use crate::via::{self, NoWay};
use crate::{TruthOf, data_file};
use models::airport::Runway;
use models::flight_list::{FlightEntry, FlightList, MovementKind};
use models::frames::Point2;
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::core::{ClearedBy, Obstacle};
use models::traffic::outline::Size;
use models::truth::recorded::{self, Report};
use models::truth::route::{self, Halt};
use models::truth::{Limits, Trajectory};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// All movers of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Traffic {
    /// The movers, in the order of the file.
    pub entities: Vec<Entity>,
    /// The types that the scene knows.
    pub types: TypeTable,
    /// Flights that behave; their entities are among `entities`, without a trajectory.
    pub behaving: Option<Arc<Behaving>>,
}

#[derive(Clone, Copy)]
enum Kind {
    Parked,
    Recorded,
    Route,
}

/// Reads `[[traffic]]` and the files that it names, which are listed in the third value; movements
/// are made of them only for `truth_of`. Generated flights use the runways for the wind at the begin, to where it blows.
pub(crate) fn read(
    root: &Section,
    run: &Run,
    (airport, days): (&AirportScene, Days),
    shapes: ShapeSet,
    truth_of: TruthOf,
) -> Result<(Traffic, FlightList, Vec<PathBuf>), ScenarioError> {
    let mut files = ["types.csv", "echo.csv"].map(|name| data_file(root.file(), name)).to_vec();
    let types = types::read(&files[0], &files[1], shapes)?;
    let mut entities: Vec<Entity> = Vec::new();
    let mut entries = Vec::new();
    let mut addresses = BTreeMap::new();
    let mut callsigns: BTreeMap<Callsign, usize> = BTreeMap::new();
    let places = Places::of(&airport.layout);
    let all = root.sections("traffic", &words(keys::TRAFFIC))?;
    let (mut sections, mut schedules, mut by_hand) = (Vec::new(), Vec::new(), Vec::new());
    let mut places_of: Option<&Section> = None;
    for section in &all {
        match section.text("kind")? {
            Some("schedule") => {
                section.only(keys::SCHEDULE)?;
                schedules.push(section);
            }
            Some("generated") => {
                section.only(keys::GENERATED)?;
                schedules.push(section);
            }
            Some("handover") => {
                section.only(keys::HANDOVER)?;
                if let Some(first) = places_of.replace(section) {
                    let (found, first_line) = ("handover".into(), first.line());
                    return Err(section.refuse("kind", Problem::Duplicate { found, first_line }));
                }
            }
            Some("driven") => {
                section.only(keys::DRIVEN)?;
                by_hand.push(section);
            }
            _ => {
                section.only(keys::MOVER)?;
                sections.push(section);
            }
        }
    }
    let with_truth = !matches!(truth_of, crate::TruthOf::Nobody);
    for (index, section) in sections.iter().enumerate() {
        let callsign = name_of(section, &mut callsigns)?;
        let row = type_row(section, &types)?;
        let kinds =
            [("parked", Kind::Parked), ("recorded", Kind::Recorded), ("route", Kind::Route)];
        let kind = section.choice("kind", &kinds)?.ok_or_else(|| {
            section.missing("kind", "the kind of movement, like \"parked\"".into())
        })?;
        // What a recording says of itself may come twice: one aircraft on two days.
        let mut address = address_of(section, &mut addresses)?;
        // What behaves gives way to all the others, whoever publishes them.
        let with_truth = truth_of.has(index) || with_truth && !schedules.is_empty();
        let (trajectory, report) = match kind {
            Kind::Parked => (Some(parked(section, run, airport, &places)?), None),
            Kind::Route => (routed(section, run, &places, row, with_truth)?, None),
            Kind::Recorded => {
                let recording = Recording::read(section, airport)?;
                let runways = &airport.layout.runways;
                address = address.or(recording.movement.address);
                files.push(recording.movement.file.clone());
                let import = with_truth.then(|| recording.import(row, runways)).transpose()?;
                import.map_or((None, None), |(trajectory, report)| (Some(trajectory), Some(report)))
            }
        };
        entries.extend(flight(section, airport, callsign, address, row)?);
        entities.push(Entity {
            callsign,
            address,
            class: row.class.clone(),
            application: 1 + (index as u16) % PARTITIONS,
            number: 1 + index as u16,
            trajectory,
            report,
        });
    }
    let mut driven = Vec::new();
    for section in &by_hand {
        let callsign = name_of(section, &mut callsigns)?;
        let row = type_row(section, &types)?;
        let address = address_of(section, &mut addresses)?;
        entries.extend(flight(section, airport, callsign, address, row)?);
        driven.push((driven::read(section, &places, callsign, row)?, address, row.class.clone()));
    }
    let first = entities.len();
    let given = places_of.map(|section| handover::read(section, &types)).transpose()?;
    let (mut behaving, mut added) = schedule::read(
        root,
        &schedules,
        run,
        (airport, days),
        &types,
        (first, given.as_ref()),
        with_truth,
    )?;
    if let Some(section) = places_of {
        let cleared = behaving.as_ref().map(|b| (b.cleared_by, b.flights.is_empty()));
        let needed = match cleared {
            Some((ClearedBy::Plan, false)) => None,
            Some((ClearedBy::Plan, true)) | None => Some(
                "a [[traffic]] of kind \"schedule\" or \"generated\" with flights beside it: who is given lands among flights that behave",
            ),
            Some(_) => Some(
                "traffic that the plan clears, without controllers = \"model\" and sees = \"truth\": controllers know the flights of the scene",
            ),
        };
        if let Some(needed) = needed {
            return Err(section.missing("kind", needed.into()));
        }
    }
    if let Some(both) = added.entities.iter().find(|a| callsigns.contains_key(&a.callsign)) {
        let problem = Problem::Duplicate { found: both.callsign.to_string(), first_line: 1 };
        return Err(root.refuse("traffic", problem));
    }
    if let (Some(section), None) = (by_hand.first(), &behaving) {
        let needed = "a [[traffic]] of kind \"schedule\" or \"generated\" beside it: what is driven moves among flights that behave".into();
        return Err(section.missing("kind", needed));
    }
    for (mover, address, class) in driven {
        let index = first + added.entities.len();
        added.entities.push(Entity {
            callsign: Callsign::new(&mover.callsign),
            address,
            class,
            application: 1 + (index as u16) % PARTITIONS,
            number: 1 + index as u16,
            trajectory: None,
            report: None,
        });
        if let Some(behaving) = &mut behaving {
            behaving.driven.push(mover);
        }
    }
    entities.extend(added.entities);
    entries.extend(added.entries);
    files.extend(added.files);
    let behaving = behaving.map(|mut behaving| {
        behaving.obstacles = entities[..first].iter().filter_map(obstacle).collect();
        if behaving.by_hand || !behaving.driven.is_empty() {
            behaving.pavement_m = driven::pavement_m(&airport.layout);
        }
        Arc::new(behaving)
    });
    entries.sort_by_key(|e: &FlightEntry| e.callsign);
    let ends = airport.layout.runways.iter().flat_map(|runway| {
        let [a, b] = runway.thresholds_m;
        [(runway.names[0].clone(), [a, b]), (runway.names[1].clone(), [b, a])]
    });
    let flight_list = FlightList { entries, runways: ends.collect() };
    Ok((Traffic { entities, types, behaving }, flight_list, files))
}

/// The name of a mover, which no other has; `known`: lines of names.
fn name_of(
    section: &Section,
    known: &mut BTreeMap<Callsign, usize>,
) -> Result<Callsign, ScenarioError> {
    let text = section.need_text("callsign", "a call sign or vehicle name")?;
    let callsign = Callsign::new(text);
    if callsign.as_str() != text || text.is_empty() {
        let needed = "1 to 11 upper-case letters, digits or signs".into();
        let found = format!("the text {text:?}");
        return Err(section.refuse("callsign", Problem::WrongKind { found, needed }));
    }
    match known.insert(callsign, section.line_of("callsign")) {
        Some(first_line) => {
            let found = text.into();
            Err(section.refuse("callsign", Problem::Duplicate { found, first_line }))
        }
        None => Ok(callsign),
    }
}

/// The address of a mover, which no other has; `known`: lines of addresses.
fn address_of(
    section: &Section,
    known: &mut BTreeMap<u32, usize>,
) -> Result<Option<u32>, ScenarioError> {
    let address = section.integer("address", 1, 0xff_fffe)?.map(|a| a as u32);
    let line = section.line_of("address");
    match address.and_then(|a| Some((a, known.insert(a, line)?))) {
        Some((address, first_line)) => {
            let found = address.to_string();
            Err(section.refuse("address", Problem::Duplicate { found, first_line }))
        }
        None => Ok(address),
    }
}

/// A mover of which every place is known, as those who behave see it.
fn obstacle(entity: &Entity) -> Option<Obstacle> {
    Some(Obstacle {
        callsign: entity.callsign.to_string(),
        size: Size {
            length_m: entity.class.length_m,
            span_m: entity.class.span_m,
            aircraft: entity.class.aircraft,
        },
        trajectory: Arc::new(entity.trajectory.clone()?),
    })
}

fn type_row<'a>(section: &Section, types: &'a TypeTable) -> Result<&'a TypeRow, ScenarioError> {
    let designator = section.need_text("type", "a type designator of types.csv")?;
    types.get(designator).ok_or_else(|| {
        let allowed = types.designators().collect::<Vec<_>>().join(", ");
        section.refuse("type", Problem::NotAllowed { found: designator.into(), allowed })
    })
}

/// Imports of this process: a pure function of its records and type, worth keeping where several
/// federates, or many tests, load the same scene.
static IMPORTS: Mutex<BTreeMap<u64, (Trajectory, Report)>> = Mutex::new(BTreeMap::new());

/// Hash of everything that an import depends on.
fn import_key(movement: &Movement, row: &TypeRow, runways: &[Runway]) -> u64 {
    let mut hash = Fnv::default();
    let numbers = |hash: &mut Fnv, numbers: &[f64]| {
        numbers.iter().for_each(|n| hash.tagged(1, &n.to_bits().to_le_bytes()));
    };
    for record in &movement.records {
        hash.tagged(2, &(record.line as u64).to_le_bytes());
        hash.tagged(3, &record.time_ms.unwrap_or(i64::MIN).to_le_bytes());
        let [east, north] = record.position_m.map_or([f64::NAN; 2], Into::into);
        numbers(&mut hash, &[east, north, record.altitude_m.unwrap_or(f64::NAN)]);
        hash.tagged(4, &[record.on_ground.map_or(2, u8::from)]);
    }
    for runway in runways {
        for end in runway.ends_m {
            numbers(&mut hash, &[end.x, end.y, runway.width_m]);
        }
    }
    hash.tagged(5, format!("{:?} {}", row.kinematics, row.class.aircraft).as_bytes());
    hash.value()
}

/// A recorded movement: `file`, put so that its first record used is at `start` of the run.
struct Recording {
    movement: Movement,
    start: SimTime,
}

impl Recording {
    fn read(section: &Section, airport: &AirportScene) -> Result<Self, ScenarioError> {
        let file = section.file_path("file")?.ok_or_else(|| {
            section.missing("file", "the name of a recorded movement (CSV)".into())
        })?;
        let start_s = section.need_number("start_s", within(-86_400.0, 86_400.0, "s"))?;
        let cut = within(0.0, 86_400.0, "s");
        let from_s = section.number_or("cut_from_s", 0.0, cut)?;
        let to_s = section.number_or("cut_to_s", f64::INFINITY, within(0.0, f64::INFINITY, "s"))?;
        if to_s <= from_s {
            let needed = "a time after cut_from_s";
            return Err(section.refuse("cut_to_s", Problem::Order { found: to_s, needed }));
        }
        let movement = movements::read(&file, airport, from_s, to_s)?;
        Ok(Self { movement, start: SimTime::from_s(start_s) })
    }

    /// The truth that is made of it.
    fn import(
        &self,
        row: &TypeRow,
        runways: &[Runway],
    ) -> Result<(Trajectory, Report), ScenarioError> {
        let key = import_key(&self.movement, row, runways);
        let known = IMPORTS.lock().ok().and_then(|imports| imports.get(&key).cloned());
        let (trajectory, report) = match known {
            Some(import) => import,
            None => {
                let limits = Limits::of(row.class.aircraft, &row.kinematics);
                let records = &self.movement.records;
                let import = recorded::import(records, &limits, runways, SimTime::ZERO);
                let import = import.map_err(|refusal| {
                    let (file, line) = (&self.movement.file, refusal.line());
                    ScenarioError::new(file, line, "movement", Problem::Model(Box::new(refusal)))
                })?;
                if let Ok(mut imports) = IMPORTS.lock() {
                    imports.insert(key, import.clone());
                }
                import
            }
        };
        Ok((trajectory.started_at(self.start), report))
    }
}

/// Along the ground network over the points named in `via`: it is there during the whole run, sets
/// off at `start_s`, and halts where `halts` says.
fn routed(
    section: &Section,
    run: &Run,
    places: &Places<'_>,
    row: &TypeRow,
    with_truth: bool,
) -> Result<Option<Trajectory>, ScenarioError> {
    let layout = places.layout();
    let via = section.texts("via")?;
    if via.len() < 2 {
        let needed = "a list of two or more nodes or stands, in order".into();
        return Err(section.missing("via", needed));
    }
    let start_s = section.need_number("start_s", within(0.0, 86_400.0, "s"))?;
    let at_line = |line: usize, problem| {
        ScenarioError::new(section.file(), line, format!("{}.via", section.path()), problem)
    };
    let between = |at: usize| at > 0 && at + 1 < via.len();
    let plain =
        via.iter().enumerate().all(|(at, (name, _))| via::is_plain(layout, name, between(at)));
    let (points, index_of) = if plain {
        let nodes: Vec<usize> = via.iter().filter_map(|(name, _)| places.node(name)).collect();
        let mut points = vec![layout.nodes[nodes[0]].position_m];
        let mut index_of = vec![Some(0)];
        for (pair, named) in nodes.windows(2).zip(via.windows(2)) {
            let way = places.shortest(pair[0], pair[1]).ok_or_else(|| {
                let (from, to) = (named[0].0.clone(), named[1].0.clone());
                at_line(named[1].1, Problem::NoRoute { from, to })
            })?;
            points.extend(way.nodes.iter().skip(1).map(|n| layout.nodes[*n].position_m));
            index_of.push(Some(points.len() - 1));
        }
        (points, index_of)
    } else {
        let names: Vec<&str> = via.iter().map(|(name, _)| name.as_str()).collect();
        let way = via::way(layout, places.network(), &names).map_err(|refused| match refused {
            NoWay::Name(at, allowed) => {
                at_line(via[at].1, Problem::NotAllowed { found: via[at].0.clone(), allowed })
            }
            NoWay::Apart(at, connected) => {
                let (from, to) = (via[at.max(1) - 1].0.clone(), via[at].0.clone());
                at_line(via[at].1, Problem::Apart { from, to, connected })
            }
        })?;
        (way.points_m, way.index_of)
    };
    let mut halts = Vec::new();
    for halt in section.sections("halts", &words(keys::HALT))? {
        let at = halt.need_text("at", "one of the names in via")?;
        // Along a taxiway there is no one place.
        let places_of = || via.iter().zip(&index_of).filter_map(|((n, _), i)| Some((n, (*i)?)));
        let point = places_of().find(|(name, _)| *name == at).ok_or_else(|| {
            let names: Vec<_> = places_of().map(|(name, _)| format!("\"{name}\"")).collect();
            halt.refuse("at", Problem::NotAllowed { found: at.into(), allowed: names.join(", ") })
        })?;
        let duration_s = halt.need_number("duration_s", within(0.0, 86_400.0, "s"))?;
        halts.push(Halt { point: point.1, duration_s });
    }
    halts.sort_by_key(|h| h.point);
    if !with_truth {
        return Ok(None);
    }
    let limits = Limits::of(row.class.aircraft, &row.kinematics);
    let trajectory = route::drive(&points, &halts, &limits, (SimTime::ZERO, run.duration), start_s);
    if trajectory.is_none() {
        let found = "a way of no length".into();
        let needed = "at least 10 m of way".into();
        return Err(section.refuse("via", Problem::WrongKind { found, needed }));
    }
    Ok(trajectory)
}

/// On a stand for the whole run.
fn parked(
    section: &Section,
    run: &Run,
    airport: &AirportScene,
    places: &Places<'_>,
) -> Result<Trajectory, ScenarioError> {
    let name = section.need_text("stand", "the name of a stand")?;
    let stand = places.stand(name).ok_or_else(|| unknown_stand(section, "stand", airport))?;
    Ok(Trajectory::parked(SimTime::ZERO, run.duration, stand.position_m, stand.heading_rad))
}

fn unknown_stand(section: &Section, key: &str, airport: &AirportScene) -> ScenarioError {
    let found = section.text(key).ok().flatten().unwrap_or("").to_owned();
    let allowed =
        airport.layout.stands.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    section.refuse(key, Problem::NotAllowed { found, allowed })
}

/// `flight = { … }`: one line of the flight list; without it the mover is not expected by anybody.
fn flight(
    section: &Section,
    airport: &AirportScene,
    callsign: Callsign,
    address: Option<u32>,
    row: &TypeRow,
) -> Result<Option<FlightEntry>, ScenarioError> {
    let Some(flight) = section.section("flight", &words(keys::FLIGHT))? else { return Ok(None) };
    let movements = [
        ("arrival", MovementKind::Arrival),
        ("departure", MovementKind::Departure),
        ("vehicle", MovementKind::Vehicle),
    ];
    let movement = flight.choice("movement", &movements)?.ok_or_else(|| {
        flight.missing("movement", "\"arrival\", \"departure\" or \"vehicle\"".into())
    })?;
    let runway = flight.text("runway")?.unwrap_or("");
    if !(runway.is_empty() || airport.layout.runway(runway).is_some()) {
        let names = airport.layout.runways.iter().flat_map(|r| r.names.iter());
        let allowed = names.map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
        return Err(flight.refuse("runway", Problem::NotAllowed { found: runway.into(), allowed }));
    }
    let stand = flight.text("stand")?.unwrap_or("");
    let stand_m: Option<Point2<f64>> = airport.layout.stand(stand).map(|s| s.position_m);
    if !stand.is_empty() && stand_m.is_none() {
        return Err(unknown_stand(&flight, "stand", airport));
    }
    let day = within(-86_400.0, 86_400.0, "s");
    Ok(Some(FlightEntry {
        callsign,
        address,
        type_designator: row.class.designator.clone(),
        wake: row.wake,
        movement,
        runway: runway.into(),
        stand: stand.into(),
        stand_m,
        eta_ctd: SimTime::from_s(flight.number_or("eta_ctd_s", 0.0, day)?),
        off_block: flight.number("off_block_s", day)?.map(SimTime::from_s),
        routing: flight.texts("routing")?.into_iter().map(|(name, _)| name).collect(),
    }))
}
