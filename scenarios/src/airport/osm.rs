//! Aeroway elements of OpenStreetMap, as Overpass JSON (`elements`) or GeoJSON (`features`).
//!
//! `aeroway` = runway, taxiway, taxilane, holding_position, gate, parking_position, apron, terminal, hangar;
//! `ref`, `name`, `width`, `oneway`. Ways that share a node (in GeoJSON: a coordinate) are joined there.

use super::network_csv::{ASSUMED_RUNWAY_WIDTH_M, runway_of, stem};
use super::{LayoutReport, local_m, text_of};
use crate::error::{Problem, ScenarioError};
use geodesy::{Geodetic, LocalFrame};
use models::airport::{Airport, Edge, Hold, Node, Stand};
use models::frames::{Azimuth, Point2};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A node of one or more ways.
#[derive(Clone, Debug)]
struct Point {
    id: String,
    lat_deg: f64,
    lon_deg: f64,
}

#[derive(Clone, Debug)]
struct Element {
    kind: String,
    tags: BTreeMap<String, String>,
    points: Vec<Point>,
    /// Drawn as a surface, not as a line to follow.
    area: bool,
}

/// The elements of a file, in degrees.
#[derive(Debug)]
pub(super) struct Osm {
    file: PathBuf,
    elements: Vec<Element>,
}

/// Whether a file is one of these by its name.
pub(super) fn is_osm(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json") || e.eq_ignore_ascii_case("geojson"))
}

/// Reads a file.
pub(super) fn read(file: &Path) -> Result<Osm, ScenarioError> {
    let text = text_of(file)?;
    let damaged = |line: usize, found: String, needed: &'static str| {
        ScenarioError::new(file, line, "osm", Problem::Line { found, needed })
    };
    let document: Value = serde_json::from_str(&text)
        .map_err(|e| damaged(e.line(), e.to_string(), "Overpass JSON or GeoJSON"))?;
    let elements = match (document["elements"].as_array(), document["features"].as_array()) {
        (Some(elements), _) => of_overpass(elements),
        (None, Some(features)) => features.iter().flat_map(of_feature).collect(),
        (None, None) => {
            let found = "neither elements nor features".into();
            return Err(damaged(1, found, "Overpass JSON or GeoJSON"));
        }
    };
    if !elements.iter().any(|e| matches!(e.kind.as_str(), "runway" | "taxiway" | "taxilane")) {
        return Err(damaged(1, "no aeroway".into(), "runways and taxiways (aeroway = …)"));
    }
    Ok(Osm { file: file.into(), elements })
}

fn degrees(lat: &Value, lon: &Value) -> Option<(f64, f64)> {
    let (lat, lon) = (lat.as_f64()?, lon.as_f64()?);
    (lat.abs() <= 90.0 && lon.abs() <= 180.0).then_some((lat, lon))
}

fn tags_of(value: &Value) -> BTreeMap<String, String> {
    let entries = value.as_object().into_iter().flatten();
    entries.filter_map(|(k, v)| Some((k.clone(), v.as_str()?.to_owned()))).collect()
}

fn of_overpass(elements: &[Value]) -> Vec<Element> {
    let mut places = BTreeMap::new();
    for e in elements.iter().filter(|e| e["type"] == "node") {
        if let (Some(id), Some(place)) = (e["id"].as_i64(), degrees(&e["lat"], &e["lon"])) {
            places.insert(id, place);
        }
    }
    let point = |id: i64| {
        let (lat_deg, lon_deg) = *places.get(&id)?;
        Some(Point { id: id.to_string(), lat_deg, lon_deg })
    };
    // With `out geom` a way has its places itself, in the order of its nodes where these are named too.
    let own = |way: &Value| -> Vec<Point> {
        let ids = way["nodes"].as_array().map_or(&[][..], Vec::as_slice);
        let places = way["geometry"].as_array().map_or(&[][..], Vec::as_slice);
        let named = ids.len() == places.len();
        let point = |(i, p): (usize, &Value)| {
            let (lat_deg, lon_deg) = degrees(&p["lat"], &p["lon"])?;
            let id = ids.get(i).filter(|_| named).and_then(Value::as_i64);
            let id = id.map_or_else(|| by_place(lat_deg, lon_deg), |id| id.to_string());
            Some(Point { id, lat_deg, lon_deg })
        };
        places.iter().enumerate().filter_map(point).collect()
    };
    let mut found = Vec::new();
    for e in elements {
        let tags = tags_of(&e["tags"]);
        let Some(kind) = tags.get("aeroway").cloned() else { continue };
        let points: Vec<Point> = match e["type"].as_str() {
            Some("node") => e["id"].as_i64().and_then(point).into_iter().collect(),
            Some("way") if e["geometry"].is_array() => own(e),
            Some("way") => {
                let ids = e["nodes"].as_array().map_or(&[][..], Vec::as_slice);
                ids.iter().filter_map(Value::as_i64).filter_map(point).collect()
            }
            _ => Vec::new(),
        };
        if !points.is_empty() {
            let area = tags.get("area").is_some_and(|a| a == "yes");
            found.push(Element { kind, tags, points, area });
        }
    }
    found
}

/// What stands for a node that has no name: where it is.
fn by_place(lat_deg: f64, lon_deg: f64) -> String {
    format!("{lat_deg:.7}_{lon_deg:.7}")
}

fn of_feature(feature: &Value) -> Vec<Element> {
    let tags = tags_of(&feature["properties"]);
    let Some(kind) = tags.get("aeroway").cloned() else { return Vec::new() };
    let point = |c: &Value| {
        let (lat_deg, lon_deg) = degrees(&c[1], &c[0])?;
        // Coordinates stand for the nodes that GeoJSON does not name.
        Some(Point { id: by_place(lat_deg, lon_deg), lat_deg, lon_deg })
    };
    let list = |value: &Value| -> Vec<Point> {
        value.as_array().map_or(&[][..], Vec::as_slice).iter().filter_map(point).collect()
    };
    let shape = &feature["geometry"]["coordinates"];
    let rings: Vec<Vec<Point>> = match feature["geometry"]["type"].as_str() {
        Some("Point") => vec![point(shape).into_iter().collect()],
        Some("LineString") => vec![list(shape)],
        Some("Polygon") => vec![list(&shape[0])],
        Some("MultiLineString") => {
            shape.as_array().map_or(&[][..], Vec::as_slice).iter().map(list).collect()
        }
        Some("MultiPolygon") => {
            let polygons = shape.as_array().map_or(&[][..], Vec::as_slice);
            polygons.iter().map(|p| list(&p[0])).collect()
        }
        _ => Vec::new(),
    };
    let surface =
        ["Polygon", "MultiPolygon"].map(Some).contains(&feature["geometry"]["type"].as_str());
    let area = surface || tags.get("area").is_some_and(|a| a == "yes");
    let sound = rings.into_iter().filter(|r| !r.is_empty());
    sound.map(|points| Element { kind: kind.clone(), tags: tags.clone(), points, area }).collect()
}

impl Osm {
    /// The middle of runways and taxiways, at sea level.
    pub(super) fn reference(&self) -> Geodetic {
        let moving = |e: &&Element| matches!(e.kind.as_str(), "runway" | "taxiway" | "taxilane");
        let points: Vec<&Point> =
            self.elements.iter().filter(moving).flat_map(|e| &e.points).collect();
        super::middle(points.iter().map(|p| (p.lat_deg, p.lon_deg)), 0.0)
    }

    /// Network, stands, pavement and buildings of `airport`, and its runways where it has none.
    pub(super) fn into_airport(
        self,
        frame: &LocalFrame,
        width_m: f64,
        airport: &mut Airport,
        report: &mut LayoutReport,
    ) {
        let mut network = Network { frame, index: BTreeMap::new(), seen: BTreeSet::new(), airport };
        network.airport.clear_network();
        let has_runways = !network.airport.runways.is_empty();
        for element in &self.elements {
            let tag = |key: &str| element.tags.get(key).map_or("", String::as_str);
            let name = if tag("ref").is_empty() { tag("name") } else { tag("ref") };
            let width = tag("width").trim_end_matches('m').trim().parse().ok();
            let width = width.filter(|w: &f64| (1.0..=300.0).contains(w));
            match element.kind.as_str() {
                "runway" if element.points.len() >= 2 => {
                    let width_m = width.unwrap_or(ASSUMED_RUNWAY_WIDTH_M);
                    network.add_runway(element, name, width_m, has_runways, report);
                }
                "taxiway" | "taxilane" if element.area => network.add_outline(element, true),
                "taxiway" | "taxilane" => {
                    let back = matches!(tag("oneway"), "-1" | "reverse");
                    let one_way = back || matches!(tag("oneway"), "yes" | "1" | "true");
                    let mut way = element.clone();
                    if back {
                        way.points.reverse();
                    }
                    network.add_way(&way, name, width.unwrap_or(width_m), !one_way, false);
                }
                "apron" => network.add_outline(element, true),
                "terminal" | "hangar" => network.add_outline(element, false),
                _ => {}
            }
        }
        // After the ways, so that it is known which nodes are theirs.
        let mut off = 0;
        for element in &self.elements {
            match element.kind.as_str() {
                "holding_position" => {
                    let node = network.index.get(&element.points[0].id).copied();
                    match node {
                        Some(node) => network.airport.nodes[node].hold = Hold::Runway,
                        None => off += 1,
                    }
                }
                "gate" | "parking_position" => network.add_stand(element, report),
                _ => {}
            }
        }
        if off > 0 {
            report.lines.push(format!("{off} holding positions beside the taxiways: left out"));
        }
        let airport = network.airport;
        if airport.name.is_empty() {
            airport.name = stem(&self.file);
            airport.icao.clone_from(&airport.name);
        }
        report.lines.push(format!(
            "{}: {} runways, {} stands, {} nodes, {} edges ({} one-way), {} aprons, {} buildings",
            self.file.display(),
            airport.runways.len(),
            airport.stands.len(),
            airport.nodes.len(),
            airport.edges.len(),
            airport.edges.iter().filter(|e| !e.two_way).count(),
            airport.pavement.len(),
            airport.buildings.len(),
        ));
    }
}

struct Network<'a> {
    frame: &'a LocalFrame,
    index: BTreeMap<String, usize>,
    seen: BTreeSet<(usize, usize)>,
    airport: &'a mut Airport,
}

impl Network<'_> {
    fn place(&self, point: &Point) -> Point2<f64> {
        local_m(self.frame, point.lat_deg, point.lon_deg)
    }

    fn node(&mut self, point: &Point) -> usize {
        if let Some(known) = self.index.get(&point.id) {
            return *known;
        }
        let position_m = self.place(point);
        let node = Node { name: point.id.clone(), position_m, hold: Hold::None };
        self.airport.nodes.push(node);
        self.index.insert(point.id.clone(), self.airport.nodes.len() - 1);
        self.airport.nodes.len() - 1
    }

    fn add_way(&mut self, way: &Element, name: &str, width_m: f64, two_way: bool, runway: bool) {
        for pair in way.points.windows(2) {
            let (from, to) = (self.node(&pair[0]), self.node(&pair[1]));
            if from == to {
                continue;
            }
            if !self.seen.insert((from.min(to), from.max(to))) {
                // Mapped twice: driven the ways that either of them is.
                let known = self
                    .airport
                    .edges
                    .iter_mut()
                    .find(|e| [e.from, e.to] == [from, to] || [e.from, e.to] == [to, from]);
                if let Some(known) = known {
                    known.two_way |= two_way || known.from == to;
                }
                continue;
            }
            let name = name.to_owned();
            self.airport.edges.push(Edge { from, to, two_way, runway, name, width_m });
        }
    }

    fn add_runway(
        &mut self,
        way: &Element,
        name: &str,
        width_m: f64,
        has_runways: bool,
        report: &mut LayoutReport,
    ) {
        let closed = way.points.len() > 3
            && way.points.first().map(|p| &p.id) == way.points.last().map(|p| &p.id);
        if way.area || closed {
            self.add_outline(way, true);
            report.lines.push(format!("runway {name:?}: a surface without a line: pavement only"));
            return;
        }
        self.add_way(way, name, width_m, true, true);
        // Another file has said where they lie, with thresholds that this form does not know.
        if has_runways {
            return;
        }
        let points: Vec<_> = way.points.iter().map(|p| self.place(p)).collect();
        match runway_of(name, &points, width_m) {
            Some(runway) => {
                // A runway may be several ways of one name: the longest stretch over all of them.
                let known = self.airport.runways.iter().position(|r| r.names == runway.names);
                match known {
                    Some(known) => {
                        let ends = self.airport.runways[known].ends_m;
                        let all: Vec<_> = points.into_iter().chain(ends).collect();
                        if let Some(whole) = runway_of(name, &all, width_m) {
                            self.airport.runways[known] = whole;
                        }
                    }
                    None => self.airport.runways.push(runway),
                }
            }
            None => {
                report.lines.push(format!("runway {name:?}: no line with a designator: left out"))
            }
        }
    }

    fn add_outline(&mut self, way: &Element, apron: bool) {
        let mut ring: Vec<_> = way.points.iter().map(|p| self.place(p)).collect();
        if ring.len() > 1 && (ring[0] - ring[ring.len() - 1]).norm() < 0.01 {
            ring.pop();
        }
        if ring.len() >= 3 {
            let rings =
                if apron { &mut self.airport.pavement } else { &mut self.airport.buildings };
            rings.push(ring);
        }
    }

    /// A gate on a taxiway is a node of its own; a parking position that is a way leads to its last point
    /// that no other way uses; any other stand has a place only.
    fn add_stand(&mut self, element: &Element, report: &mut LayoutReport) {
        let tag = |key: &str| element.tags.get(key).map_or("", String::as_str);
        let given = if tag("ref").is_empty() { tag("name") } else { tag("ref") };
        let mut name = given.replace(' ', "_");
        if name.is_empty() {
            name = format!("stand_{}", self.airport.stands.len() + 1);
        }
        if self.airport.stands.iter().any(|s| s.name == name) {
            let unique = format!("{name}_{}", self.airport.stands.len() + 1);
            report.lines.push(format!("second stand {name:?}, called {unique}"));
            name = unique;
        }
        let end = if element.points.len() > 1 {
            let first_known = self.index.contains_key(&element.points[0].id);
            self.add_way(element, &name, 23.0, true, false);
            if first_known { element.points.last() } else { element.points.first() }
        } else {
            element.points.first()
        };
        let Some(end) = end else { return };
        let position_m = self.place(end);
        let node = self.index.get(&end.id).copied();
        let neighbour = node.and_then(|n| {
            let edge = self.airport.edges.iter().find(|e| e.from == n || e.to == n)?;
            Some(self.airport.nodes[if edge.from == n { edge.to } else { edge.from }].position_m)
        });
        let nearest = || {
            let taxi = self.airport.edges.iter().filter(|e| !e.runway);
            let feet = taxi.map(|e| {
                let (a, b) =
                    (self.airport.nodes[e.from].position_m, self.airport.nodes[e.to].position_m);
                let share =
                    ((position_m - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                a + (b - a) * share
            });
            feet.min_by(|p, q| (p - position_m).norm().total_cmp(&(q - position_m).norm()))
        };
        let stated = tag("direction").parse().ok().filter(|d: &f64| d.is_finite());
        let heading_rad = match (stated, neighbour.or_else(nearest)) {
            (Some(deg), _) => Azimuth::from_rad(deg.to_radians()).rad(),
            (None, Some(from)) if (position_m - from).norm() > 0.5 => {
                Azimuth::of(position_m - from).rad()
            }
            _ => 0.0,
        };
        self.airport.stands.push(Stand { name, position_m, heading_rad, node });
    }
}
