//! Runways, pavement, stands and network from an X-Plane `apt.dat` file of one airport.
//!
//! Source: X-Plane "apt.dat" file format specification, version 1000. Row codes used: 1 airport,
//! 10 older pavement (a rectangle), 14 viewpoint, 100 runway, 110 pavement with its nodes 111 to 116,
//! 1201 node and 1202 edge of the taxi network, 1204 active zone of the edge before it, 1206 road, 1300 stand
//! with 1301 its code letter, 1400/1401 places of vehicles, 15 start position (a stand where the file has no
//! rows 1300). All others are passed over and counted. Mended and reported: edges that name a
//! node that is not there or lead from a node to itself, nodes numbered twice, runways of no length.

use super::{LayoutReport, local_m, text_of};
use crate::error::{Problem, ScenarioError};
use geodesy::{Geodetic, LocalFrame};
use models::airport::{Airport, Edge, EdgeDetail, Hold, Node, Runway, Stand, StandDetail};
use models::frames::{Azimuth, Point2};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const FOOT_M: f64 = 0.3048;
/// A stand is joined to the network where a node is at most this far away, m.
const STAND_REACH_M: f64 = 150.0;

/// The rows of a file, in degrees as they are there.
#[derive(Debug, Default)]
pub(super) struct AptDat {
    file: PathBuf,
    pub(super) icao: String,
    name: String,
    elevation_m: f64,
    runways: Vec<RunwayRow>,
    rectangles: Vec<RectangleRow>,
    outlines: Vec<Vec<OutlineNode>>,
    holes: usize,
    tower: Option<(f64, f64, f64)>,
    nodes: Vec<(String, f64, f64)>,
    edges: Vec<EdgeRow>,
    /// Rows 1206.
    roads: Vec<EdgeRow>,
    /// Rows 1400 and 1401: place and what stands or is there.
    vehicle_places: Vec<(f64, f64, String)>,
    stands: Vec<StandRow>,
    /// Rows 15.
    starts: Vec<StandRow>,
    /// What was left out while reading.
    mended: Vec<String>,
    passed_over: BTreeMap<String, usize>,
}

#[derive(Debug)]
struct RunwayRow {
    width_m: f64,
    /// Designator, latitude, longitude, displacement of the threshold in m.
    ends: [(String, f64, f64, f64); 2],
}

#[derive(Debug)]
struct RectangleRow {
    lat_deg: f64,
    lon_deg: f64,
    heading_deg: f64,
    length_m: f64,
    width_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct OutlineNode {
    place: (f64, f64),
    /// Control point of the curve that leaves the node; the mirrored one is of the curve that arrives.
    control: Option<(f64, f64)>,
}

#[derive(Debug)]
struct EdgeRow {
    line: usize,
    from: String,
    to: String,
    two_way: bool,
    runway: bool,
    name: String,
    detail: EdgeDetail,
}

#[derive(Debug)]
struct StandRow {
    lat_deg: f64,
    lon_deg: f64,
    heading_deg: f64,
    name: String,
    detail: StandDetail,
}

/// One row with what is needed to say where it is wrong.
struct Row<'a> {
    file: &'a Path,
    line: usize,
    words: Vec<&'a str>,
}

impl<'a> Row<'a> {
    fn word(&self, index: usize, name: &'static str) -> Result<&'a str, ScenarioError> {
        self.words.get(index).copied().ok_or_else(|| self.damaged(name, "end of line", name))
    }

    fn number(
        &self,
        index: usize,
        name: &'static str,
        low: f64,
        high: f64,
    ) -> Result<f64, ScenarioError> {
        let word = self.word(index, name)?;
        let found: f64 = word.parse().map_err(|_| self.damaged(name, word, "a number"))?;
        if found >= low && found <= high {
            return Ok(found);
        }
        let problem = Problem::OutOfRange { found, low, high, unit: "" };
        Err(ScenarioError::new(self.file, self.line, name, problem))
    }

    fn latitude(&self, index: usize) -> Result<f64, ScenarioError> {
        self.number(index, "latitude", -90.0, 90.0)
    }

    fn longitude(&self, index: usize) -> Result<f64, ScenarioError> {
        self.number(index, "longitude", -180.0, 180.0)
    }

    fn rest(&self, index: usize) -> String {
        self.words.get(index..).unwrap_or(&[]).join(" ")
    }

    fn damaged(&self, name: &'static str, found: &str, needed: &'static str) -> ScenarioError {
        let problem = Problem::Line { found: found.into(), needed };
        ScenarioError::new(self.file, self.line, name, problem)
    }
}

/// Reads the first airport of a file.
pub(super) fn read(file: &Path) -> Result<AptDat, ScenarioError> {
    let text = text_of(file)?;
    let mut apt = AptDat { file: file.to_path_buf(), ..AptDat::default() };
    let mut outline: Option<(usize, Vec<OutlineNode>)> = None;
    let mut numbers = BTreeSet::new();
    let mut edge_before = EdgeBefore::None;
    let mut elsewhere = false;
    for (index, text_line) in text.lines().enumerate() {
        let row = Row { file, line: index + 1, words: text_line.split_whitespace().collect() };
        // The first two lines are the header: "I" or "A", then the version of the format.
        let Some(code) = row.words.first().filter(|_| index >= 2) else { continue };
        match *code {
            "1" | "16" | "17" if !apt.icao.is_empty() => {
                *apt.passed_over.entry("second airport".into()).or_default() += 1;
                break;
            }
            other if elsewhere && !matches!(other, "1" | "16" | "17" | "99") => {}
            // One of helicopters or seaplanes before it: nothing of that is the airport's.
            "16" | "17" => {
                *apt.passed_over.entry((*code).into()).or_default() += 1;
                elsewhere = true;
            }
            "1" => {
                elsewhere = false;
                apt.elevation_m = row.number(1, "elevation", -2000.0, 20_000.0)? * FOOT_M;
                apt.icao = row.word(4, "ICAO code")?.into();
                apt.name = row.rest(5);
            }
            "100" => {
                let found = runway(&row)?;
                let [a, b] = &found.ends;
                if (a.1, a.2) == (b.1, b.2) {
                    let (line, name) = (index + 1, format!("{}/{}", a.0, b.0));
                    apt.mended.push(format!("line {line}: runway {name} of no length: left out"));
                } else if apt.runways.iter().any(|r| is_same(&r.ends, &found.ends)) {
                    let (line, name) = (index + 1, format!("{}/{}", a.0, b.0));
                    apt.mended.push(format!("line {line}: runway {name} a second time: left out"));
                } else {
                    apt.runways.push(found);
                }
            }
            "10" => apt.rectangles.push(rectangle(&row)?),
            "14" => {
                let height_m = row.number(3, "height", 0.0, 2000.0)? * FOOT_M;
                apt.tower = Some((row.latitude(1)?, row.longitude(2)?, height_m));
            }
            "110" => outline = Some((0, Vec::new())),
            "111" | "112" | "113" | "114" => {
                let curved = matches!(*code, "112" | "114");
                let control =
                    if curved { Some((row.latitude(3)?, row.longitude(4)?)) } else { None };
                let place = (row.latitude(1)?, row.longitude(2)?);
                if let Some((rings, nodes)) = &mut outline {
                    nodes.push(OutlineNode { place, control });
                    if matches!(*code, "113" | "114") {
                        let ring = std::mem::take(nodes);
                        if *rings == 0 {
                            apt.outlines.push(ring)
                        } else {
                            apt.holes += 1
                        }
                        *rings += 1;
                    }
                }
            }
            "115" | "116" => {}
            "120" | "130" => outline = None,
            "1201" => {
                let id = row.word(4, "node number")?.to_owned();
                let (lat_deg, lon_deg) = (row.latitude(1)?, row.longitude(2)?);
                if numbers.insert(id.clone()) {
                    apt.nodes.push((id, lat_deg, lon_deg));
                } else {
                    let line = index + 1;
                    apt.mended.push(format!("line {line}: node {id} a second time: left out"));
                }
            }
            "1202" => {
                apt.edges.push(edge(&row)?);
                edge_before = EdgeBefore::Taxiway;
            }
            "1204" => match (edge_before, apt.edges.last_mut()) {
                (EdgeBefore::Taxiway, Some(edge)) => {
                    let runways = row.rest(2);
                    let names = runways.split([',', ' ']).filter(|n| !n.is_empty());
                    edge.detail.zones.extend(names.map(str::to_owned));
                }
                _ => {
                    let line = index + 1;
                    apt.mended.push(format!("line {line}: active zone of no taxiway: left out"));
                }
            },
            "1206" => {
                let word = row.word(3, "direction")?;
                let two_way = word != "oneway";
                let (from, to) =
                    (row.word(1, "first node")?.into(), row.word(2, "second node")?.into());
                let (line, name, detail) = (row.line, row.rest(4), EdgeDetail::default());
                apt.roads.push(EdgeRow { line, from, to, two_way, runway: false, name, detail });
                edge_before = EdgeBefore::Road;
            }
            "1301" => match apt.stands.last_mut() {
                Some(stand) => stand.detail.code = row.words.get(1).and_then(|w| code_letter(w)),
                None => {
                    let line = index + 1;
                    apt.mended.push(format!("line {line}: size of no stand: left out"));
                }
            },
            "1400" | "1401" => {
                let place = (row.latitude(1)?, row.longitude(2)?, row.rest(4));
                apt.vehicle_places.push(place);
            }
            "1300" => apt.stands.push(StandRow {
                lat_deg: row.latitude(1)?,
                lon_deg: row.longitude(2)?,
                heading_deg: row.number(3, "heading", -1e6, 1e6)?,
                name: row.rest(6),
                detail: stand_detail(&row),
            }),
            "15" => apt.starts.push(StandRow {
                lat_deg: row.latitude(1)?,
                lon_deg: row.longitude(2)?,
                heading_deg: row.number(3, "heading", -1e6, 1e6)?,
                name: row.rest(4),
                detail: StandDetail::default(),
            }),
            "99" => break,
            other => *apt.passed_over.entry(other.into()).or_default() += 1,
        }
    }
    if apt.icao.is_empty() || apt.runways.is_empty() {
        let problem = Problem::Line {
            found: format!(
                "{} airports, {} runways",
                usize::from(!apt.icao.is_empty()),
                apt.runways.len()
            ),
            needed: "one airport (row 1) with its runways (rows 100)",
        };
        return Err(ScenarioError::new(file, text.lines().count().max(1), "airport", problem));
    }
    Ok(apt)
}

fn runway(row: &Row<'_>) -> Result<RunwayRow, ScenarioError> {
    let end = |at: usize| -> Result<_, ScenarioError> {
        let displaced_m = row.number(at + 3, "displaced threshold", 0.0, 5000.0)?;
        let name = row.word(at, "runway name")?.to_owned();
        Ok((name, row.latitude(at + 1)?, row.longitude(at + 2)?, displaced_m))
    };
    Ok(RunwayRow { width_m: row.number(1, "width", 1.0, 300.0)?, ends: [end(8)?, end(17)?] })
}

fn rectangle(row: &Row<'_>) -> Result<RectangleRow, ScenarioError> {
    Ok(RectangleRow {
        lat_deg: row.latitude(1)?,
        lon_deg: row.longitude(2)?,
        heading_deg: row.number(4, "heading", -360.0, 360.0)?,
        length_m: row.number(5, "length", 0.0, 30_000.0)? * FOOT_M,
        width_m: row.number(8, "width", 0.0, 30_000.0)? * FOOT_M,
    })
}

fn edge(row: &Row<'_>) -> Result<EdgeRow, ScenarioError> {
    let direction = row.word(3, "direction")?;
    let two_way = match direction {
        "twoway" => true,
        "oneway" => false,
        _ => return Err(row.damaged("direction", direction, "oneway or twoway")),
    };
    let name = row.rest(5);
    Ok(EdgeRow {
        line: row.line,
        from: row.word(1, "first node")?.into(),
        to: row.word(2, "second node")?.into(),
        two_way,
        runway: row.word(4, "kind")? == "runway",
        name: if name == "." { String::new() } else { name },
        detail: EdgeDetail {
            code: row.words.get(4).and_then(|w| code_letter(w.strip_prefix("taxiway_")?)),
            zones: Vec::new(),
        },
    })
}

/// The row of the network that a row 1204 would belong to.
#[derive(Clone, Copy)]
enum EdgeBefore {
    None,
    Taxiway,
    Road,
}

fn code_letter(word: &str) -> Option<char> {
    word.chars().next().filter(|c| word.len() == 1 && ('A'..='F').contains(c))
}

/// Words of a row 1300: kind, then the aircraft it is for; heavy ones need code E, jets C.
fn stand_detail(row: &Row<'_>) -> StandDetail {
    let word = |index: usize| row.words.get(index).copied().unwrap_or("");
    let fits = |wanted: &str| word(5).split('|').any(|w| w == wanted);
    let code = if fits("heavy") {
        Some('E')
    } else if fits("jets") || fits("turboprops") {
        Some('C')
    } else if fits("props") || fits("helos") {
        Some('A')
    } else {
        None
    };
    StandDetail { code, kind: word(4).to_owned(), ..StandDetail::default() }
}

/// Whether two runways lie at the same place, whichever way round they are written.
fn is_same(a: &[(String, f64, f64, f64); 2], b: &[(String, f64, f64, f64); 2]) -> bool {
    /// About ten metres.
    const NEAR_DEG: f64 = 1e-4;
    let near = |p: usize, q: usize| {
        (a[p].1 - b[q].1).abs() < NEAR_DEG && (a[p].2 - b[q].2).abs() < NEAR_DEG
    };
    near(0, 0) && near(1, 1) || near(0, 1) && near(1, 0)
}

impl AptDat {
    /// The middle of the runway ends, at field elevation.
    pub(super) fn reference(&self) -> Geodetic {
        let ends = self.runways.iter().flat_map(|r| r.ends.iter());
        super::middle(ends.map(|e| (e.1, e.2)), self.elevation_m)
    }

    /// The layout in local metres.
    pub(super) fn into_airport(
        self,
        frame: &LocalFrame,
        taxiway_width_m: f64,
        report: &mut LayoutReport,
    ) -> Airport {
        let local = |(lat_deg, lon_deg): (f64, f64)| local_m(frame, lat_deg, lon_deg);
        let mut airport =
            Airport { icao: self.icao.clone(), name: self.name.clone(), ..Airport::default() };
        airport.tower = self.tower.map(|(lat, lon, height_m)| (local((lat, lon)), height_m));
        airport.runways = self.runways.iter().map(|row| row.in_local(&local)).collect();
        let rectangles = self.rectangles.iter().map(|row| row.outline(&local));
        let outlines = self.outlines.iter().map(|ring| flattened(ring, &local));
        airport.pavement = rectangles.chain(outlines).filter(|ring| ring.len() >= 3).collect();
        airport.nodes = self
            .nodes
            .iter()
            .map(|(name, lat, lon)| Node {
                name: name.clone(),
                position_m: local((*lat, *lon)),
                hold: Hold::None,
            })
            .collect();
        let runway_width_m = self.runways.iter().map(|r| r.width_m).fold(taxiway_width_m, f64::max);
        let index: BTreeMap<&str, usize> =
            self.nodes.iter().enumerate().map(|(i, n)| (n.0.as_str(), i)).collect();
        report.lines.extend(self.mended.iter().cloned());
        for row in &self.edges {
            let (from, to) = (index.get(row.from.as_str()), index.get(row.to.as_str()));
            let (Some(from), Some(to)) = (from.copied(), to.copied()) else {
                let missing = if from.is_none() { &row.from } else { &row.to };
                let line = row.line;
                report.lines.push(format!("line {line}: edge to no node {missing}: left out"));
                continue;
            };
            if from == to {
                let (line, name) = (row.line, &row.from);
                report.lines.push(format!("line {line}: edge from {name} to itself: left out"));
                continue;
            }
            airport.edges.push(Edge {
                from,
                to,
                two_way: row.two_way,
                runway: row.runway,
                name: row.name.clone(),
                width_m: if row.runway { runway_width_m } else { taxiway_width_m },
            });
            airport.details.edges.push(row.detail.clone());
        }
        let mut lost_roads = 0;
        for row in &self.roads {
            match (index.get(row.from.as_str()), index.get(row.to.as_str())) {
                (Some(from), Some(to)) if from != to => {
                    let ends = [*from, *to].map(|n| airport.nodes[n].position_m);
                    airport.details.roads.push((ends, row.two_way));
                }
                _ => lost_roads += 1,
            }
        }
        if lost_roads > 0 {
            report
                .lines
                .push(format!("{lost_roads} rows 1206 to no node or to themselves: left out"));
        }
        let places = self.vehicle_places.iter();
        airport.details.vehicle_places =
            places.map(|(lat, lon, word)| (local((*lat, *lon)), word.clone())).collect();
        self.add_stands(&local, &mut airport, taxiway_width_m, report);
        report.lines.push(format!(
            "{}: {} ({}), {} runways, {} pavement outlines ({} holes left out), {} nodes, {} edges ({} one-way), {} stands",
            self.file.display(), airport.icao, airport.name, airport.runways.len(), airport.pavement.len(),
            self.holes, self.nodes.len(), self.edges.len(),
            airport.edges.iter().filter(|e| !e.two_way).count(), airport.stands.len(),
        ));
        let rows: Vec<_> =
            self.passed_over.iter().map(|(code, n)| format!("{code} ({n})")).collect();
        if !rows.is_empty() {
            report.lines.push(format!("rows passed over: {}", rows.join(", ")));
        }
        airport
    }

    /// Stands are not part of the network of these files: each is joined to its nearest node.
    fn add_stands(
        &self,
        local: &impl Fn((f64, f64)) -> Point2<f64>,
        airport: &mut Airport,
        width_m: f64,
        report: &mut LayoutReport,
    ) {
        let mut names = BTreeSet::new();
        let network_nodes = airport.nodes.len();
        let stands = if self.stands.is_empty() && !self.starts.is_empty() {
            let count = self.starts.len();
            report.lines.push(format!("no rows 1300: {count} rows 15 taken for stands (assumed)"));
            &self.starts
        } else {
            &self.stands
        };
        for row in stands {
            let position_m = local((row.lat_deg, row.lon_deg));
            let mut name = row.name.replace(' ', "_");
            let mut copy = 2;
            while !names.insert(name.clone()) {
                name = format!("{}_{copy}", row.name.replace(' ', "_"));
                copy += 1;
            }
            let nearest = airport.nodes[..network_nodes]
                .iter()
                .map(|n| (n.position_m - position_m).norm())
                .enumerate()
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .filter(|(_, distance_m)| *distance_m <= STAND_REACH_M);
            let node = nearest.map(|(to, distance_m)| {
                airport.nodes.push(Node { name: name.clone(), position_m, hold: Hold::None });
                let from = airport.nodes.len() - 1;
                let edge =
                    Edge { from, to, two_way: true, runway: false, name: String::new(), width_m };
                airport.details.joined.push(airport.edges.len());
                airport.edges.push(edge);
                report.lines.push(format!(
                    "stand {name}: joined to node {} at {distance_m:.0} m (assumed)",
                    airport.nodes[to].name
                ));
                from
            });
            let heading_rad = Azimuth::from_rad(row.heading_deg.to_radians()).rad();
            airport.stands.push(Stand { name, position_m, heading_rad, node });
            airport.details.stands.push(row.detail.clone());
        }
    }
}

impl RunwayRow {
    fn in_local(&self, local: &impl Fn((f64, f64)) -> Point2<f64>) -> Runway {
        let [a, b] = &self.ends;
        let ends_m = [local((a.1, a.2)), local((b.1, b.2))];
        let along = (ends_m[1] - ends_m[0]).normalize();
        Runway {
            names: [a.0.clone(), b.0.clone()],
            ends_m,
            thresholds_m: [ends_m[0] + along * a.3, ends_m[1] - along * b.3],
            width_m: self.width_m,
        }
    }
}

impl RectangleRow {
    fn outline(&self, local: &impl Fn((f64, f64)) -> Point2<f64>) -> Vec<Point2<f64>> {
        let centre = local((self.lat_deg, self.lon_deg));
        let along = Azimuth::from_rad(self.heading_deg.to_radians()).unit() * (0.5 * self.length_m);
        let across =
            Azimuth::from_rad((self.heading_deg + 90.0).to_radians()).unit() * (0.5 * self.width_m);
        vec![
            centre + along + across,
            centre + along - across,
            centre - along - across,
            centre - along + across,
        ]
    }
}

/// Straight pieces of an outline; curves are Bézier, quadratic with one control point, cubic with two.
fn flattened(ring: &[OutlineNode], local: &impl Fn((f64, f64)) -> Point2<f64>) -> Vec<Point2<f64>> {
    const PIECES: usize = 6;
    let mut points: Vec<Point2<f64>> = Vec::new();
    for (index, node) in ring.iter().enumerate() {
        let next = &ring[(index + 1) % ring.len()];
        // Weights of the corners sum to one: vectors from the reference point.
        let corner = |at| local(at).coords;
        let (a, b) = (corner(node.place), corner(next.place));
        let leaving = node.control.map(corner);
        let arriving = next.control.map(|c| b * 2.0 - corner(c));
        points.push(a.into());
        if leaving.is_none() && arriving.is_none() {
            continue;
        }
        for piece in 1..PIECES {
            let t = piece as f64 / PIECES as f64;
            let s = 1.0 - t;
            let place = match (leaving, arriving) {
                (Some(c), Some(d)) => {
                    a * (s * s * s)
                        + c * (3.0 * s * s * t)
                        + d * (3.0 * s * t * t)
                        + b * (t * t * t)
                }
                (Some(c), None) | (None, Some(c)) => a * (s * s) + c * (2.0 * s * t) + b * (t * t),
                (None, None) => a * s + b * t,
            };
            points.push(place.into());
        }
    }
    points.dedup_by(|p, q| (*p - *q).norm() < 0.01);
    points
}
