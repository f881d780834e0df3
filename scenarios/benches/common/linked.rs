//! Scenes of generated traffic: of an airport that ships, and of several beside each other with taxiways between them.

use models::airport::Airport;
use models::frames::Vector2;
use models::traffic::core::Direction;
use scenarios::Scene;
use std::fmt::Write as _;
use std::path::Path;

/// Between the middles of neighbours, m.
const APART_M: f64 = 7000.0;
/// Taxiways between two neighbours.
const LINKS: usize = 3;

/// An hour of an airport that ships.
pub(crate) fn one(name: &str, per_h: f64) -> Result<Scene, String> {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    let there = |ext: &str| base.join(format!("airports/{name}.{ext}")).exists();
    let layout = if there("apt.dat") { "apt.dat" } else { "nodes.csv" };
    let mut airport = format!("layout = \"airports/{name}.{layout}\"");
    if there("groundnet.xml") {
        airport += &format!("\nground_network = \"airports/{name}.groundnet.xml\"");
    }
    read(&base.join("bench.toml"), &airport, per_h, "")
}

fn read(file: &Path, airport: &str, per_h: f64, more: &str) -> Result<Scene, String> {
    let text = format!(
        "[run]\ntitle = \"bench\"\nseed = 1\nduration_s = 3600\n[airport]\n{airport}\n[[traffic]]\nkind = \"generated\"\n\
         arrivals_per_h = {per_h}\ndepartures_per_h = {per_h}\n{more}"
    );
    scenarios::load_text(file, &text).map_err(|e| e.to_string())
}

/// An hour of several of them as one network, each with the runway ends in use that it has alone.
pub(crate) fn together(folder: &Path, names: &[&str], per_h: f64) -> Result<Scene, String> {
    let (mut airports, mut ends) = (Vec::new(), [Vec::new(), Vec::new()]);
    for (k, name) in names.iter().enumerate() {
        let scene = one(name, 12.0)?;
        let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
        for (direction, ends) in [Direction::Arrival, Direction::Departure].iter().zip(&mut ends) {
            let flight = behaving.flights.iter().find(|f| f.direction == *direction);
            let (r, end) = flight.ok_or("no flight")?.runway;
            ends.push(format!("\"{k}{}\"", behaving.network.runways[r].names[end]));
        }
        airports.push(scene.airport.layout);
    }
    std::fs::write(folder.join("linked.apt.dat"), linked(&airports)).map_err(|e| e.to_string())?;
    let [landing, leaving] = ends.map(|e| e.join(", "));
    let more = format!("arrival_runways = [{landing}]\ndeparture_runways = [{leaving}]\n");
    let airport = "layout = \"linked.apt.dat\"\nradius_m = 50000";
    read(&folder.join("linked.toml"), airport, per_h, &more)
}

/// The text of an apt.dat file: three airports a row, each joined to the one before and to the one three before it. Runways and
/// stands have the number of their airport before their name.
fn linked(airports: &[Airport]) -> String {
    let mut text = "I\n1000 Version - linked\n\n1 30 0 0 XLNK Linked\n".to_owned();
    let degrees =
        |m: Vector2<f64>| format!("{:.8} {:.8}", 45.0 + m.y / 111_132.0, 10.0 + m.x / 78_847.0);
    let place = |k: usize| Vector2::new(APART_M * (k % 3) as f64, APART_M * (k / 3) as f64);
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
            [k.checked_sub(1).filter(|_| k % 3 > 0), k.checked_sub(3)].into_iter().flatten()
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
    let far = |n: usize| airport.nodes[n].position_m.dot(&towards);
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
