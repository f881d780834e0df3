//! Scenes of generated traffic: of an airport that ships, and of several beside each other with taxiways between them.

use models::airport::Airport;
use models::frames::{Point2, Vector2};
use models::traffic::core::{Core, Direction, Flight, Phase};
use models::traffic::pieces::Pieces;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Airports a row, and between the middles of neighbours, m: of few, and of many small ones.
const FEW: (usize, f64) = (3, 7000.0);
const MANY: (usize, f64) = (7, 5000.0);
/// Taxiways between two neighbours.
const LINKS: usize = 3;

/// Airports of which about a thousand aircraft are there an hour later, each with so many flights an hour each way as it can serve.
pub(crate) const LARGE: ([&str; 46], f64) = (["XSYN"; 46], 19.0);
/// Longest time until as many are there as is asked for, and until traffic goes its way, s.
const UNTIL_S: f64 = 3600.0;
const WARM_S: f64 = 600.0;

/// The core of a scene, at its begin.
pub(crate) fn core(scene: &Scene, seed: u64) -> Option<Core> {
    scene.traffic.behaving.as_ref()?.core(&scene.run, seed)
}

/// How many are there.
pub(crate) fn there(core: &Core) -> usize {
    let is = |f: &usize| !matches!(core.phase(*f), Phase::Absent | Phase::Gone);
    (0..core.flights().len()).filter(is).count()
}

/// How many of them are not on stands.
pub(crate) fn moving(core: &Core) -> usize {
    let not = [Phase::Absent, Phase::Gone, Phase::Parked, Phase::Docked];
    (0..core.flights().len()).filter(|f| !not.contains(&core.phase(*f))).count()
}

/// A core and its next frame after ten minutes and when so many are there, or at the end of its hour.
pub(crate) fn when_there(scene: &Scene, seed: u64, count: usize) -> Option<(Core, i64)> {
    let mut core = core(scene, seed)?;
    let at = |s: f64| (s / scene.run.frame.s()) as i64;
    let mut frame = 1;
    while frame < at(WARM_S) || frame < at(UNTIL_S) && (frame % 20 != 0 || there(&core) < count) {
        core.step(frame);
        frame += 1;
    }
    Some((core, frame))
}

/// An hour of an airport that ships.
pub(crate) fn one(name: &str, per_h: f64) -> Result<Scene, String> {
    drawn(name, per_h, 1)
}

/// The same of another draw.
fn drawn(name: &str, per_h: f64, seed: u64) -> Result<Scene, String> {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    let there = |ext: &str| base.join(format!("airports/{name}.{ext}")).exists();
    let layout = if there("apt.dat") { "apt.dat" } else { "nodes.csv" };
    let mut airport = format!("layout = \"airports/{name}.{layout}\"");
    if there("groundnet.xml") {
        airport += &format!("\nground_network = \"airports/{name}.groundnet.xml\"");
    }
    read(&base.join("bench.toml"), &airport, per_h, "", seed)
}

fn read(file: &Path, airport: &str, per_h: f64, more: &str, seed: u64) -> Result<Scene, String> {
    let text = format!(
        "[run]\ntitle = \"bench\"\nseed = {seed}\nduration_s = 3600\n[airport]\n{airport}\n[[traffic]]\nkind = \"generated\"\n\
         arrivals_per_h = {per_h}\ndepartures_per_h = {per_h}\n{more}"
    );
    scenarios::load_text(file, &text).map_err(|e| e.to_string())
}

/// An hour of several of them as one network, each with the runway ends in use that it has alone.
pub(crate) fn together(folder: &Path, names: &[&str], per_h: f64) -> Result<Scene, String> {
    let (mut airports, mut ends) = (Vec::new(), [Vec::new(), Vec::new()]);
    let mut read_already: BTreeMap<&str, Scene> = BTreeMap::new();
    for (k, name) in names.iter().enumerate() {
        if !read_already.contains_key(name) {
            read_already.insert(name, one(name, 12.0)?);
        }
        let scene = &read_already[name];
        let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
        for (direction, ends) in [Direction::Arrival, Direction::Departure].iter().zip(&mut ends) {
            let flight = behaving.flights.iter().find(|f| f.direction == *direction);
            let (r, end) = flight.ok_or("no flight")?.runway;
            ends.push(format!("\"{k}{}\"", behaving.network.runways[r].names[end]));
        }
        airports.push(scene.airport.layout.clone());
    }
    std::fs::write(folder.join("linked.apt.dat"), linked(&airports)).map_err(|e| e.to_string())?;
    let [landing, leaving] = ends.map(|e| e.join(", "));
    let more = format!("arrival_runways = [{landing}]\ndeparture_runways = [{leaving}]\n");
    let airport = "layout = \"linked.apt.dat\"\nradius_m = 50000";
    read(&folder.join("linked.toml"), airport, per_h, &more, 1)
}

/// The same with the traffic that each of them has alone, on its own runways and stands, of one draw.
pub(crate) fn beside(
    folder: &Path,
    names: &[&str],
    per_h: f64,
    draw: u64,
) -> Result<Scene, String> {
    let mut scene = together(folder, names, 12.0 * names.len() as f64)?;
    let large = Arc::make_mut(scene.traffic.behaving.as_mut().ok_or("nothing behaves")?);
    let mut flights: Vec<Flight> = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let alone = drawn(name, per_h, 1000 * draw + k as u64)?;
        let alone = alone.traffic.behaving.as_ref().ok_or("nothing behaves")?;
        let first = flights.len();
        for f in alone.flights.as_ref() {
            let ((r, end), stand) = (f.runway, &alone.network.stands[f.stand].name);
            let end = format!("{k}{}", alone.network.runways[r].names[end]);
            let stand = format!("{k}_{stand}");
            let mut runways = large.network.runways.iter().enumerate();
            let runway = runways
                .find_map(|(r, n)| Some((r, n.names.iter().position(|n| *n == end)?)))
                .ok_or("no such runway")?;
            let stands = &large.network.stands;
            flights.push(Flight {
                callsign: format!("{}{k}", f.callsign),
                runway,
                stand: stands.iter().position(|s| s.name == stand).ok_or("no such stand")?,
                turnaround_of: f.turnaround_of.map(|o| o + first),
                key: f.key + 1_000_000 * (k as u64 + 1),
                ..f.clone()
            });
        }
    }
    if Core::classes(&flights) != Core::classes(&large.flights) {
        large.pieces = Some(Arc::new(Pieces::of(&large.network, &Core::classes(&flights))));
    }
    large.flights = Arc::new(flights);
    Ok(scene)
}

/// The text of an apt.dat file: some airports a row, each joined to the one before and to the one of the row before. Runways and
/// stands have the number of their airport before their name.
fn linked(airports: &[Airport]) -> String {
    let mut text = "I\n1000 Version - linked\n\n1 30 0 0 XLNK Linked\n".to_owned();
    let degrees =
        |m: Point2<f64>| format!("{:.8} {:.8}", 45.0 + m.y / 111_132.0, 10.0 + m.x / 78_847.0);
    let (row, apart_m) = if airports.len() > 12 { MANY } else { FEW };
    let place = |k: usize| Vector2::new(apart_m * (k % row) as f64, apart_m * (k / row) as f64);
    let mut first: Vec<usize> = vec![0];
    let (mut nodes, mut edges) = (String::new(), String::new());
    for (k, airport) in airports.iter().enumerate() {
        for r in &airport.runways {
            let [a, b] = r.ends_m.map(|e| degrees(e + place(k)));
            let [n, m] = &r.names;
            let width_m = r.width_m;
            writeln!(text, "100 {width_m:.2} 1 0 0.25 1 3 1 {k}{n} {a} 0.00 0.00 3 2 1 0 {k}{m} {b} 0.00 0.00 3 2 1 0")
                .unwrap_or_default();
        }
        for (s, stand) in airport.stands.iter().enumerate() {
            let (at, heading) =
                (degrees(stand.position_m + place(k)), stand.heading_rad.to_degrees());
            writeln!(text, "1300 {at} {heading:.2} gate jets {k}_{}", stand.name)
                .unwrap_or_default();
            let code = airport.details.stands.get(s).and_then(|d| d.code);
            if let Some(code) = code {
                writeln!(text, "1301 {code} airline").unwrap_or_default();
            }
        }
        let start = first[k];
        for (n, node) in airport.nodes.iter().enumerate() {
            let at = degrees(node.position_m + place(k));
            writeln!(nodes, "1201 {at} both {} {k}_{}", start + n, node.name.replace(' ', "_"))
                .unwrap_or_default();
        }
        first.push(start + airport.nodes.len());
        for (e, edge) in airport.edges.iter().enumerate() {
            if airport.details.joined.contains(&e) {
                continue;
            }
            let way = if edge.two_way { "twoway" } else { "oneway" };
            let code = airport.details.edges.get(e).and_then(|d| d.code).unwrap_or('F');
            let what = if edge.runway { "runway".to_owned() } else { format!("taxiway_{code}") };
            writeln!(
                edges,
                "1202 {} {} {way} {what} {k}{}",
                start + edge.from,
                start + edge.to,
                edge.name
            )
            .unwrap_or_default();
        }
        for other in
            [k.checked_sub(1).filter(|_| k % row > 0), k.checked_sub(row)].into_iter().flatten()
        {
            let (mine, theirs) = (
                ends_of(airport, place(k), place(other)),
                ends_of(&airports[other], place(other), place(k)),
            );
            for (a, b) in mine.iter().zip(&theirs) {
                writeln!(edges, "1202 {} {} twoway taxiway_F LINK", start + a, first[other] + b)
                    .unwrap_or_default();
            }
        }
    }
    text + &nodes + &edges + "99\n"
}

/// The nodes of an airport, not of stands nor within 150 m of each other, that are nearest to another place.
fn ends_of(airport: &Airport, at: Vector2<f64>, to: Vector2<f64>) -> Vec<usize> {
    let towards = (to - at).normalize();
    let mut all: Vec<usize> = (0..airport.nodes.len())
        .filter(|n| {
            let p = airport.nodes[*n].position_m;
            let stand = airport
                .stands
                .iter()
                .any(|s| s.node == Some(*n) || (s.position_m - p).norm() < 60.0);
            let runway = airport.runways.iter().any(|r| r.distance_m(p) < 100.0);
            !stand && !runway && airport.edges.iter().any(|e| e.from == *n || e.to == *n)
        })
        .collect();
    let far = |n: usize| airport.nodes[n].position_m.coords.dot(&towards);
    all.sort_by(|a, b| far(*b).total_cmp(&far(*a)));
    let mut kept: Vec<usize> = Vec::new();
    for n in all {
        let p = airport.nodes[n].position_m;
        if kept.len() < LINKS
            && kept.iter().all(|k| (airport.nodes[*k].position_m - p).norm() > 150.0)
        {
            kept.push(n);
        }
    }
    kept
}
