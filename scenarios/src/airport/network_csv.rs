//! A routing graph in two tables, `X.nodes.csv` and `X.edges.csv`.
//!
//! `node_id,lat,lon,name,kind` with kind `gate`, `runway` or `intermediate`; `edge_id,start_node,end_node,
//! directed,length_m,kind,name` with kind `runway`, `taxiway` or `gate`. A runway is what edges of kind
//! `runway` with one name `05R / 23L` make: its ends are the two nodes farthest apart.

use super::{LayoutReport, local_m, text_of};
use crate::error::{Problem, ScenarioError};
use geodesy::{Geodetic, LocalFrame};
use models::airport::{Airport, Edge, Hold, Node, Runway, Stand};
use models::frames::{Azimuth, Point2};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Width where a runway has none, m (code number 4; assumed).
pub(super) const ASSUMED_RUNWAY_WIDTH_M: f64 = 45.0;

#[derive(Debug)]
struct NodeRow {
    id: String,
    lat_deg: f64,
    lon_deg: f64,
    name: String,
    kind: String,
}

#[derive(Debug)]
struct EdgeRow {
    line: usize,
    from: String,
    to: String,
    directed: bool,
    kind: String,
    name: String,
}

/// Both tables, in degrees.
#[derive(Debug)]
pub(super) struct Tables {
    nodes_file: PathBuf,
    edges_file: PathBuf,
    nodes: Vec<NodeRow>,
    edges: Vec<EdgeRow>,
}

/// Whether a file is the first of the two tables by its name.
pub(super) fn is_nodes_table(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().ends_with("nodes.csv"))
}

/// The second table's name.
pub(super) fn edges_table(nodes: &Path) -> PathBuf {
    let name = nodes.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    nodes.with_file_name(name.replace("nodes.csv", "edges.csv"))
}

/// Reads the tables.
pub(super) fn read(nodes_file: &Path) -> Result<Tables, ScenarioError> {
    let edges_file = edges_table(nodes_file);
    let mut nodes = Vec::new();
    for row in rows(nodes_file, &["node_id", "lat", "lon", "name", "kind"])? {
        nodes.push(NodeRow {
            id: row.cell("node_id").into(),
            lat_deg: row.number("lat", 90.0)?,
            lon_deg: row.number("lon", 180.0)?,
            name: row.cell("name").into(),
            kind: row.cell("kind").into(),
        });
    }
    let mut edges = Vec::new();
    for row in rows(&edges_file, &["start_node", "end_node", "directed", "kind", "name"])? {
        edges.push(EdgeRow {
            line: row.line,
            from: row.cell("start_node").into(),
            to: row.cell("end_node").into(),
            directed: row.yes("directed")?,
            kind: row.cell("kind").into(),
            name: row.cell("name").into(),
        });
    }
    if nodes.is_empty() {
        let problem = Problem::Line { found: "no row".into(), needed: "rows of nodes" };
        return Err(ScenarioError::new(nodes_file, 1, "nodes", problem));
    }
    Ok(Tables { nodes_file: nodes_file.into(), edges_file, nodes, edges })
}

struct Row {
    file: PathBuf,
    line: usize,
    cells: BTreeMap<String, String>,
}

impl Row {
    fn cell(&self, column: &str) -> &str {
        self.cells.get(column).map_or("", String::as_str)
    }

    fn yes(&self, column: &'static str) -> Result<bool, ScenarioError> {
        match self.cell(column).to_ascii_lowercase().as_str() {
            "1" | "true" | "yes" => Ok(true),
            "0" | "false" | "no" | "" => Ok(false),
            other => {
                let problem = Problem::Line { found: other.into(), needed: "1 or 0" };
                Err(ScenarioError::new(&self.file, self.line, column, problem))
            }
        }
    }

    fn number(&self, column: &'static str, limit: f64) -> Result<f64, ScenarioError> {
        let text = self.cell(column);
        let number = text.parse().ok().filter(|n: &f64| n.abs() <= limit);
        number.ok_or_else(|| {
            let problem = Problem::Line { found: text.into(), needed: "degrees" };
            ScenarioError::new(&self.file, self.line, column, problem)
        })
    }
}

fn rows(file: &Path, columns: &[&'static str]) -> Result<Vec<Row>, ScenarioError> {
    let text = text_of(file)?;
    let damaged = |line: usize, found: String| {
        let problem = Problem::Line { found, needed: "a comma-separated table with a header" };
        ScenarioError::new(file, line, "table", problem)
    };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| damaged(1, e.to_string()))?.clone();
    if let Some(missing) = columns.iter().find(|c| !header.iter().any(|h| h == **c)) {
        return Err(damaged(1, format!("no column {missing}")));
    }
    let (mut found, mut lines) = (Vec::new(), crate::files::Lines::new(text.as_bytes(), true));
    for record in reader.records() {
        let record = record.map_err(|e| damaged(lines.of(e.position()), e.to_string()))?;
        let line = lines.of(record.position());
        let pairs = header.iter().zip(record.iter());
        let cells = pairs.map(|(key, cell)| (key.to_owned(), cell.to_owned())).collect();
        found.push(Row { file: file.into(), line, cells });
    }
    Ok(found)
}

impl Tables {
    /// Both files.
    pub(super) fn edges_file(&self) -> &Path {
        &self.edges_file
    }

    /// The middle of all nodes, at sea level.
    pub(super) fn reference(&self) -> Geodetic {
        super::middle(self.nodes.iter().map(|n| (n.lat_deg, n.lon_deg)), 0.0)
    }

    /// Replaces network and stands of `airport`, and its runways where it has none.
    pub(super) fn into_airport(
        self,
        frame: &LocalFrame,
        width_m: f64,
        airport: &mut Airport,
        report: &mut LayoutReport,
    ) {
        let mut index = BTreeMap::new();
        airport.clear_network();
        for row in &self.nodes {
            if index.contains_key(&row.id) {
                report.lines.push(format!("node {} a second time: left out", row.id));
                continue;
            }
            index.insert(row.id.clone(), airport.nodes.len());
            let position_m = local_m(frame, row.lat_deg, row.lon_deg);
            airport.nodes.push(Node { name: row.id.clone(), position_m, hold: Hold::None });
        }
        let mut seen = BTreeSet::new();
        for row in &self.edges {
            let (Some(from), Some(to)) = (index.get(&row.from), index.get(&row.to)) else {
                report.lines.push(format!("line {}: edge to no node: left out", row.line));
                continue;
            };
            let (from, to) = (*from, *to);
            let ends = if row.directed { (from, to) } else { (from.min(to), from.max(to)) };
            if from == to || !seen.insert((ends, row.directed)) {
                report.lines.push(format!("line {}: edge twice or to itself: left out", row.line));
                continue;
            }
            let runway = row.kind == "runway";
            let width_m = if runway { ASSUMED_RUNWAY_WIDTH_M } else { width_m };
            let (two_way, name) = (!row.directed, row.name.clone());
            airport.edges.push(Edge { from, to, two_way, runway, name, width_m });
        }
        self.add_stands(&index, airport, report);
        if airport.runways.is_empty() {
            airport.runways = self.runways(&index, airport, report);
        }
        if airport.name.is_empty() {
            airport.name = stem(&self.nodes_file);
            airport.icao.clone_from(&airport.name);
        }
        report.lines.push(format!(
            "{}: {} stands, {} nodes, {} edges ({} one-way)",
            self.nodes_file.display(),
            airport.stands.len(),
            airport.nodes.len(),
            airport.edges.len(),
            airport.edges.iter().filter(|e| !e.two_way).count(),
        ));
    }

    /// Gates are nodes; they head away from the node that they are joined to (assumed).
    fn add_stands(
        &self,
        index: &BTreeMap<String, usize>,
        airport: &mut Airport,
        report: &mut LayoutReport,
    ) {
        let mut names = BTreeSet::new();
        for row in self.nodes.iter().filter(|r| r.kind == "gate") {
            let node = index[&row.id];
            let mut name = if row.name.is_empty() { row.id.clone() } else { row.name.clone() };
            if !names.insert(name.clone()) {
                name = format!("{name}_{}", row.id);
                names.insert(name.clone());
            }
            let here = airport.nodes[node].position_m;
            let joined = airport.edges.iter().find(|e| e.from == node || e.to == node);
            let ahead = joined.map(|e| {
                let other = if e.from == node { e.to } else { e.from };
                here - airport.nodes[other].position_m
            });
            let heading_rad = ahead.map_or(0.0, |a| Azimuth::of(a).rad());
            airport.stands.push(Stand { name, position_m: here, heading_rad, node: Some(node) });
        }
        if !airport.stands.is_empty() {
            report.lines.push("headings of gates: away from the taxiway (assumed)".into());
        }
    }

    fn runways(
        &self,
        index: &BTreeMap<String, usize>,
        airport: &Airport,
        report: &mut LayoutReport,
    ) -> Vec<Runway> {
        let mut by_name: BTreeMap<&str, Vec<Point2<f64>>> = BTreeMap::new();
        for row in self.edges.iter().filter(|r| r.kind == "runway" && !r.name.is_empty()) {
            let ends = [&row.from, &row.to].into_iter().filter_map(|id| index.get(id));
            let points = ends.map(|n| airport.nodes[*n].position_m);
            by_name.entry(row.name.as_str()).or_default().extend(points);
        }
        let width_m = ASSUMED_RUNWAY_WIDTH_M;
        by_name.iter().filter_map(|(name, points)| {
            report.lines.push(format!(
                "runway {name}: ends are its nodes farthest apart, width {width_m} m, thresholds at the ends (assumed)"
            ));
            runway_of(name, points, width_m)
        }).collect()
    }
}

/// A runway called `05R / 23L` over points on it; each designator goes to the end where it begins.
pub(super) fn runway_of(name: &str, points: &[Point2<f64>], width_m: f64) -> Option<Runway> {
    let (mut best, mut ends) = (0.0, None);
    for a in points {
        for b in points {
            let length = (b - a).norm();
            if length > best {
                (best, ends) = (length, Some([*a, *b]));
            }
        }
    }
    let mut ends_m = ends?;
    let designators: Vec<&str> = name.split('/').map(str::trim).filter(|n| !n.is_empty()).collect();
    let digits: String = designators.first()?.chars().take_while(char::is_ascii_digit).collect();
    let called_rad = digits.parse().ok().map(|n: f64| (10.0 * n).to_radians())?;
    let along = ends_m[1] - ends_m[0];
    if along.dot(&Azimuth::from_rad(called_rad).unit()) < 0.0 {
        ends_m.swap(0, 1);
    }
    let first = designators.first().map(|d| (*d).to_owned())?;
    let second = designators.get(1).map_or_else(|| opposite(&first), |d| (*d).to_owned());
    Some(Runway { names: [first, second], ends_m, thresholds_m: ends_m, width_m })
}

/// The designator of the other end: 05R is 23L.
fn opposite(designator: &str) -> String {
    let digits: String = designator.chars().take_while(char::is_ascii_digit).collect();
    let number: u32 = digits.parse().unwrap_or(36);
    let letter = match designator.chars().last() {
        Some('L') => "R",
        Some('R') => "L",
        Some('C') => "C",
        _ => "",
    };
    format!("{:02}{letter}", (number + 17) % 36 + 1)
}

/// `EGCC` of `…/EGCC.nodes.csv`.
pub(super) fn stem(path: &Path) -> String {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    name.split('.').next().unwrap_or("").to_owned()
}
