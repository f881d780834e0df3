//! `seeds airport` and `seeds traffic`: what was read, mended and assumed of layouts and recordings.

use crate::runtime::cli::print_line;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail, load_scene};
use clap::{Args, Subcommand};
use models::airport::Airport;
use models::time::SimTime;
use models::traffic::core::{Direction, Flight};
use models::traffic::network::Network;
use models::traffic::ways::{Graph, TurnTime};
use models::truth::recorded::Report;
use models::truth::{Limits, Trajectory, route};
use scenarios::ScenarioError;
use scenarios::airport::{LayoutReport, check_files, files_meant};
use scenarios::schedule::Behaving;
use scenarios::via::{self, is_plain, mended};
use scenarios::{Entity, Scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Look into airport layouts: apt.dat (X-Plane, one airport) and ground networks (FlightGear, .xml)
#[derive(Args, Clone, Debug)]
pub struct AirportArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    /// What is in a layout, what was mended and assumed, and what is wrong with it
    Check {
        /// Layouts: files, or airports that come with SEEDS, like LSZH
        #[arg(value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
        /// Files that complete the first one, like its ground network
        #[arg(long, value_name = "FILE")]
        with: Vec<PathBuf>,
        /// JSON: one object a file
        #[arg(long)]
        json: bool,
    },
    /// Buildings of an OpenStreetMap extract (.osm, Overpass JSON, GeoJSON) as [[building]] of a scene, on stdout
    Buildings {
        /// Extract
        #[arg(value_name = "FILE")]
        file: PathBuf,
    },
    /// Names of everything a way may begin or end at: stands, nodes, holding positions, runway ends, exits
    Nodes {
        /// Layout: a file, or an airport that comes with SEEDS, like LSZH
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Files that complete it, like its ground network
        #[arg(long, value_name = "FILE")]
        with: Vec<PathBuf>,
        /// JSON: one object
        #[arg(long)]
        json: bool,
    },
    /// The shortest way along the ground network, and how long a mover takes for it (never over a stand)
    Route {
        /// Layout: a file, or an airport that comes with SEEDS, like LSZH
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Files that complete it, like its ground network
        #[arg(long, value_name = "FILE")]
        with: Vec<PathBuf>,
        /// Where it begins: a name that `seeds airport nodes` lists, or #INDEX of the file
        #[arg(value_name = "FROM")]
        from: String,
        /// Where it ends: likewise
        #[arg(value_name = "TO")]
        to: String,
        /// Type that drives: a designator of types.csv
        #[arg(long = "type", value_name = "TYPE", default_value = "FOLLOWME")]
        designator: String,
        /// So many of the next shortest ways too
        #[arg(long, value_name = "NUMBER", default_value_t = 1)]
        ways: usize,
        /// JSON: one object
        #[arg(long)]
        json: bool,
    },
}

/// What was done to the recorded movements of a scene, by rule and number, and what its movers do; `check`: a finished run; `import`: movements out of somebody's table
#[derive(Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct TrafficArgs {
    #[command(subcommand)]
    command: Option<TrafficCommand>,

    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,
    /// JSON: one object a mover
    #[arg(long)]
    json: bool,
}

#[derive(Subcommand, Clone, Debug)]
enum TrafficCommand {
    Check(super::traffic_check::CheckArgs),
    Advice(super::traffic_advice::AdviceArgs),
    Import(super::traffic_import::ImportArgs),
}

/// `seeds airport …`.
#[must_use]
pub fn run(args: &AirportArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    match &args.command {
        Command::Check { files, with, json } => check_all(files, with, *json),
        Command::Buildings { file } => buildings(file),
        Command::Nodes { file, with, json } => nodes(file, with, *json),
        Command::Route { file, with, from, to, designator, ways, json } => {
            let form = Preview { designator, ways: (*ways).clamp(1, 20), json: *json };
            route_preview((file, with), [from, to], &form)
        }
    }
}

/// A layout with the files that complete it.
fn read(file: &Path, with: &[PathBuf]) -> Result<(Airport, LayoutReport), ScenarioError> {
    let named = std::iter::once(file).chain(with.iter().map(PathBuf::as_path));
    let files: Vec<PathBuf> = named.flat_map(files_meant).collect();
    check_files(&files, None)
}

fn check_all(files: &[PathBuf], with: &[PathBuf], json: bool) -> ExitCode {
    let mut worst = ExitCode::SUCCESS;
    for file in files {
        match read(file, with) {
            Ok((layout, report)) => {
                let network = Network::of(&layout);
                if json {
                    let mut object = described(&layout);
                    object["file"] = json!(file.display().to_string());
                    object["report"] = json!(report.lines);
                    object["findings"] = json!(report.findings);
                    object["repairs"] = json!(network.report);
                    object["network_findings"] = json!(network.findings);
                    object["holding_positions"] =
                        json!(network.nodes.iter().filter(|n| n.hold_for.is_some()).count());
                    print_line(&object.to_string());
                    continue;
                }
                report.lines.iter().for_each(|line| print_line(line));
                network.report.iter().for_each(|line| print_line(line));
                let findings = report.findings.iter().chain(&network.findings);
                findings.for_each(|line| print_line(&format!("found: {line}")));
            }
            Err(e) => worst = fail(BAD_INPUT, e),
        }
    }
    worst
}

/// The buildings of an extract, as a scene states them.
fn buildings(file: &Path) -> ExitCode {
    let (found, left_out) = match scenarios::footprints::read(file) {
        Ok(found) => found,
        Err(e) => return fail(BAD_INPUT, e),
    };
    let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    print_line(scenarios::footprints::to_toml(&found, &name).trim_end());
    if left_out > 0 {
        print_line(&format!("# {left_out} smaller buildings were left out."));
    }
    ExitCode::SUCCESS
}

/// Everything that has a name, one line each: kind, name, place, and what belongs to it.
fn nodes(file: &Path, with: &[PathBuf], json: bool) -> ExitCode {
    let (layout, _) = match read(file, with) {
        Ok(found) => found,
        Err(e) => return fail(BAD_INPUT, e),
    };
    let network = Network::of(&layout);
    let mut rows: Vec<Value> = Vec::new();
    let place = |p: models::frames::Point2<f64>| [tenths(p.x), tenths(p.y)];
    let runway_name = |r: usize| network.runways[r].names.join("/");
    for (index, stand) in layout.stands.iter().enumerate() {
        let number = stand.node.and_then(|n| layout.details.numbers.get(n));
        let way = network.stands[index].node.is_some_and(|n| network.nodes[n].used);
        let letter = char::from(b'A' + network.stands[index].code);
        rows.push(json!({
            "kind": "stand", "name": stand.name, "index": number, "at_m": place(stand.position_m),
            "heading_deg": tenths(stand.heading_rad.to_degrees().rem_euclid(360.0)),
            "code": letter.to_string(), "way": way,
        }));
    }
    for (index, node) in layout.nodes.iter().enumerate() {
        if layout.stands.iter().any(|s| s.node == Some(index)) {
            continue;
        }
        let number = layout.details.numbers.get(index);
        let (name, at_m) = (&node.name, place(node.position_m));
        rows.push(json!({ "kind": "node", "name": name, "index": number, "at_m": at_m }));
    }
    for node in &network.nodes {
        let Some(runway) = node.hold_for else { continue };
        let (name, at_m) = (&node.name, place(node.at_m));
        let runway = runway_name(runway);
        rows.push(
            json!({ "kind": "holding position", "name": name, "runway": runway, "at_m": at_m }),
        );
    }
    for (r, runway) in network.runways.iter().enumerate() {
        for end in 0..2 {
            let (name, at_m) = (&runway.names[end], place(runway.ends_m[end]));
            let length_m = tenths(runway.length_m);
            rows.push(
                json!({ "kind": "runway end", "name": name, "at_m": at_m, "length_m": length_m }),
            );
        }
        for (along_m, node) in &runway.spine {
            let exits = network
                .edges
                .iter()
                .filter(|e| e.nodes.contains(node) && e.strip == Some(r) && e.runway.is_none());
            if exits.count() > 0 {
                let (name, along_m) = (&network.nodes[*node].name, tenths(*along_m));
                let runway = runway_name(r);
                rows.push(
                    json!({ "kind": "exit", "name": name, "runway": runway, "along_m": along_m }),
                );
            }
        }
    }
    // What a way is asked for by, where several things have that name.
    for row in &mut rows {
        let name = row["name"].as_str().unwrap_or("").to_owned();
        let say = match (via::place(&layout, &network, &name), row["kind"].as_str()) {
            (Err(_), Some("stand")) => format!("stand {name}"),
            (Err(_), Some("runway end")) => format!("runway {name}"),
            (Err(_), _) => format!("node {name}"),
            _ => name,
        };
        row["say"] = say.into();
    }
    if json {
        print_line(&json!({ "icao": layout.icao, "nodes": rows }).to_string());
        return ExitCode::SUCCESS;
    }
    for row in &rows {
        let text = |key: &str| row[key].as_str().map(str::to_owned);
        let index = text("index").map(|i| format!(" #{i}")).unwrap_or_default();
        let at =
            row["at_m"].as_array().map(|p| format!(" at {} {}", p[0], p[1])).unwrap_or_default();
        let runway = text("runway").map(|r| format!(" of {r}")).unwrap_or_default();
        let along = row["along_m"].as_f64().map(|m| format!(" {m:.0} m along")).unwrap_or_default();
        let code = text("code").map(|c| format!(" code {c}")).unwrap_or_default();
        let off = if row["way"] == json!(false) { " (no way)" } else { "" };
        let (kind, name) = (text("kind").unwrap_or_default(), text("name").unwrap_or_default());
        let say = text("say").filter(|say| *say != name && !off.contains("no way"));
        let say = say.map(|say| format!(" (say \"{say}\")")).unwrap_or_default();
        print_line(&format!("{kind} {name}{index}{runway}{along}{at}{code}{off}{say}"));
    }
    ExitCode::SUCCESS
}

fn described(layout: &Airport) -> Value {
    let runways = layout.runways.iter().map(|runway| {
        let length_m = (runway.ends_m[1] - runway.ends_m[0]).norm();
        json!({ "names": runway.names, "length_m": tenths(length_m), "width_m": runway.width_m })
    });
    let network_m: f64 = layout
        .edges
        .iter()
        .map(|e| (layout.nodes[e.to].position_m - layout.nodes[e.from].position_m).norm())
        .sum();
    json!({
        "icao": layout.icao,
        "name": layout.name,
        "runways": runways.collect::<Vec<_>>(),
        "nodes": layout.nodes.len(),
        "edges": layout.edges.len(),
        "one_way": layout.edges.iter().filter(|e| !e.two_way).count(),
        "network_m": tenths(network_m),
        "stands": layout.stands.len(),
        "stands_on_network": layout.stands.iter().filter(|s| s.node.is_some()).count(),
        "pavement": layout.pavement.len(),
    })
}

/// How a way is shown.
struct Preview<'a> {
    designator: &'a str,
    ways: usize,
    json: bool,
}

fn route_preview(
    (file, with): (&Path, &[PathBuf]),
    names: [&String; 2],
    form: &Preview<'_>,
) -> ExitCode {
    let Preview { designator, ways, json } = *form;
    let (mut layout, _) = match read(file, with) {
        Ok(found) => found,
        Err(e) => return fail(BAD_INPUT, e),
    };
    // By the lines of the file; where it does not know a name, by those of the network that was made of it.
    let network = Network::of(&layout);
    let mut ends: [Vec<usize>; 2] = Default::default();
    if names.iter().all(|name| is_plain(&layout, name, false)) {
        ends = names.map(|name| layout.node(name).into_iter().collect());
    } else {
        for (end, name) in ends.iter_mut().zip(names) {
            match via::place(&layout, &network, name) {
                Ok(nodes) => *end = nodes,
                Err(allowed) => {
                    let error = format!("{}: {name}: allowed is {allowed}", file.display());
                    return fail(BAD_INPUT, error);
                }
            }
        }
        layout = mended(&layout, &network);
    }
    let limits = match scenarios::types::shipped() {
        Ok(types) => types.get(designator).map(|t| Limits::of(t.class.aircraft, &t.kinematics)),
        Err(e) => return fail(BAD_INPUT, e),
    };
    let Some(limits) = limits else {
        return fail(BAD_INPUT, format!("--type {designator}: no designator of types.csv"));
    };
    let [from, to] = names;
    let pairs = ends[0].iter().flat_map(|a| ends[1].iter().map(move |b| [*a, *b]));
    let ways_of =
        pairs.filter_map(|pair| Some((route::shortest(&layout, pair[0], pair[1])?, pair)));
    let nearest = ways_of.min_by(|a, b| a.0.length_m.total_cmp(&b.0.length_m));
    let Some((way, ends)) = nearest else {
        return fail(FAILED, format!("{}: no way from {from} to {to}", file.display()));
    };
    let points: Vec<_> = way.nodes.iter().map(|n| layout.nodes[*n].position_m).collect();
    // Far longer than anything takes: at 1 m/s.
    let span = (SimTime::ZERO, SimTime::from_s(60.0 + way.length_m));
    let drive_s = route::drive(&points, &[], &limits, span, 0.0).map(|t| driving_s(&t));
    let graph = Graph::of(&layout);
    let turning = graph.quickest(ends[0], ends[1], &TurnTime::default()).map(|w| w.cost);
    let others: Vec<f64> =
        graph.shortest_ways(ends[0], ends[1], ways).iter().map(|w| tenths(w.cost)).collect();
    let nodes: Vec<&str> = way.nodes.iter().map(|n| layout.nodes[*n].name.as_str()).collect();
    if json {
        let object = json!({
            "from": from, "to": to, "length_m": tenths(way.length_m), "nodes": nodes,
            "taxiways": way.names, "type": designator, "drive_s": drive_s.map(tenths),
            "turn_time_s": turning.map(tenths), "shortest_m": others,
            "points_m": points.iter().map(|p| [tenths(p.x), tenths(p.y)]).collect::<Vec<_>>(),
        });
        print_line(&object.to_string());
        return ExitCode::SUCCESS;
    }
    let along = if way.names.is_empty() { "(no names)".into() } else { way.names.join(", ") };
    let time = drive_s.map_or("too short to drive".into(), |s| format!("{s:.0} s"));
    print_line(&format!("{from} to {to}: {:.0} m, {designator} {time}", way.length_m));
    print_line(&format!("over {along}"));
    let turning =
        turning.map_or("no way without turns above 120 deg".into(), |s| format!("{s:.0} s"));
    print_line(&format!("by turn time (10 m/s, 4 s a quarter turn): {turning}"));
    if ways > 1 {
        let lengths: Vec<String> = others.iter().map(|m| format!("{m:.0} m")).collect();
        print_line(&format!("shortest ways: {}", lengths.join(", ")));
    }
    print_line(&format!("nodes {}", nodes.join(" ")));
    ExitCode::SUCCESS
}

/// From the first to the last moment of motion, s.
fn driving_s(trajectory: &Trajectory) -> f64 {
    const STEP: i64 = 100_000_000;
    let steps = (trajectory.start().0 / STEP)..=(trajectory.end().0 / STEP);
    let moving = steps
        .filter(|k| trajectory.at(SimTime(k * STEP)).is_some_and(|s| s.velocity_mps.norm() > 0.05));
    let (mut first, mut last) = (None, 0);
    for k in moving {
        first.get_or_insert(k);
        last = k;
    }
    first.map_or(0.0, |first| (last - first) as f64 * 0.1)
}

/// `seeds traffic SCENE`.
#[must_use]
pub fn traffic(args: &TrafficArgs) -> ExitCode {
    match &args.command {
        Some(TrafficCommand::Check(check)) => return super::traffic_check::run(check),
        Some(TrafficCommand::Advice(advice)) => return super::traffic_advice::run(advice),
        Some(TrafficCommand::Import(import)) => return super::traffic_import::run(import),
        None => {}
    }
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    let scene = match load_scene(&args.scene) {
        Ok(scene) => scene,
        Err(code) => return code,
    };
    for entity in &scene.traffic.entities {
        let Some(trajectory) = &entity.trajectory else { continue };
        let most = Most::of(trajectory);
        if args.json {
            print_line(&mover(entity, trajectory, &most).to_string());
            continue;
        }
        let kind = if entity.report.is_some() { "recorded" } else { "made" };
        print_line(&format!(
            "{} ({}, {kind}): {:.1} s to {:.1} s; fastest {:.1} m/s, acceleration {:.2}, braking {:.2}, lateral {:.2} m/s2, highest {:.0} m",
            entity.callsign,
            entity.class.designator,
            trajectory.start().s(),
            trajectory.end().s(),
            most.speed_mps,
            most.acceleration_ms2,
            most.braking_ms2,
            most.lateral_ms2,
            most.height_m
        ));
        if let Some(report) = &entity.report {
            print_line(&report.to_string());
        }
    }
    if let Some(behaving) = &scene.traffic.behaving {
        flights(&scene, behaving, args.json);
    }
    ExitCode::SUCCESS
}

/// What is planned of those who move by themselves, and what was moved or assumed of it.
fn flights(scene: &Scene, behaving: &Behaving, json: bool) {
    let network = &behaving.network;
    let entities = scene.traffic.entities.iter().skip(behaving.first_entity);
    for (flight, entity) in behaving.flights.iter().zip(entities) {
        let Flight { callsign, time_s, .. } = flight;
        let (designator, arrives) =
            (&entity.class.designator, flight.direction == Direction::Arrival);
        let runway = &network.runways[flight.runway.0].names[flight.runway.1];
        let stand = &network.stands[flight.stand].name;
        let turn_round = flight.turnaround_of.map(|a| &behaving.flights[a].callsign);
        if json {
            let direction = if arrives { "arrival" } else { "departure" };
            let object = json!({
                "callsign": callsign, "type": designator, "direction": direction, "runway": runway,
                "stand": stand, "time_s": time_s, "turn_round_of": turn_round,
            });
            print_line(&object.to_string());
            continue;
        }
        let of = turn_round.map(|a| format!(", as {a} came")).unwrap_or_default();
        print_line(&if arrives {
            format!(
                "{callsign} ({designator}, arrival): lands on {runway} at {time_s:.0} s, to stand {stand}"
            )
        } else {
            format!(
                "{callsign} ({designator}, departure): off stand {stand} at {time_s:.0} s{of}, takes off from {runway}"
            )
        });
    }
    if !json {
        behaving.remarks.iter().chain(&behaving.left_out).for_each(|line| print_line(line));
    }
}

/// Extremes of a movement, looked at every 50 ms.
#[derive(Default)]
struct Most {
    speed_mps: f64,
    acceleration_ms2: f64,
    braking_ms2: f64,
    lateral_ms2: f64,
    height_m: f64,
}

impl Most {
    fn of(trajectory: &Trajectory) -> Self {
        const STEP: i64 = 50_000_000;
        let mut most = Self::default();
        let mut time = trajectory.start();
        while let Some(state) = trajectory.at(time) {
            let v = state.velocity_mps.xy();
            let (a, speed) = (state.acceleration_ms2.xy(), v.norm());
            if let Some(ahead) = v.try_normalize(1e-6) {
                let along = a.dot(&ahead);
                most.acceleration_ms2 = most.acceleration_ms2.max(along);
                most.braking_ms2 = most.braking_ms2.max(-along);
                most.lateral_ms2 = most.lateral_ms2.max((a - ahead * along).norm());
            }
            most.speed_mps = most.speed_mps.max(speed);
            most.height_m = most.height_m.max(state.position_m.z);
            time = SimTime(time.0 + STEP);
        }
        most
    }
}

fn mover(entity: &Entity, trajectory: &Trajectory, most: &Most) -> Value {
    json!({
        "callsign": entity.callsign.as_str(),
        "type": entity.class.designator,
        "from_s": trajectory.start().s(),
        "to_s": trajectory.end().s(),
        "fastest_mps": most.speed_mps,
        "acceleration_ms2": most.acceleration_ms2,
        "braking_ms2": most.braking_ms2,
        "lateral_ms2": most.lateral_ms2,
        "highest_m": most.height_m,
        "import": entity.report.as_ref().map(import),
    })
}

fn import(report: &Report) -> Value {
    let rules = report.tally.rows().map(|(rule, count, line)| {
        json!({ "rule": format!("{rule:?}"), "text": rule.text(), "count": count, "first_line": line })
    });
    let held = report.held.iter().map(|held| {
        let (column, unit) = held.limit.column();
        json!({
            "column": column, "unit": unit, "value": held.value, "duration_s": held.duration_s,
            "recorded": held.recorded, "along_m": held.along_m,
        })
    });
    json!({
        "records": report.records,
        "used": report.used,
        "rules": rules.collect::<Vec<_>>(),
        "held": held.collect::<Vec<_>>(),
        "gaps": report.gaps,
        "longest_gap_s": report.longest_gap.0,
        "longest_gap_to_line": report.longest_gap.1,
        "standstills": report.stands.0,
        "standing_s": report.stands.1,
        "backward_legs": report.pushbacks,
        "sigma_m": report.sigma_m,
        "across_rms_m": report.across_m.0,
        "across_max_m": report.across_m.1,
        "along_rms_m": report.along_m.0,
        "along_max_m": report.along_m.1,
        "centred_max_m": report.centred_m,
        "altitude_offset_m": report.altitude_offset_m,
        "liftoff_s": report.liftoff_s,
        "touchdown_s": report.touchdown_s,
    })
}

fn tenths(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
