//! Stands and taxi network from a FlightGear `groundnet.xml` file.
//!
//! Stands (`Parking`) and nodes share one space of indices; arcs are directed, so a two-way edge is
//! there twice. Mended and reported: duplicate arcs, arcs from a node to itself or to none, nodes without
//! arcs, indices that are there twice.

use super::{LayoutReport, local_m, text_of};
use crate::error::{Problem, ScenarioError};
use geodesy::{Geodetic, LocalFrame};
use models::airport::{Airport, Edge, Hold, Node, Stand, StandDetail};
use models::frames::Azimuth;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The elements of a file, in degrees.
#[derive(Debug)]
pub(super) struct GroundNet {
    file: PathBuf,
    points: Vec<Point>,
    arcs: Vec<Arc>,
}

#[derive(Debug)]
struct Point {
    line: usize,
    index: usize,
    lat_deg: f64,
    lon_deg: f64,
    on_runway: bool,
    hold: Hold,
    /// Name and heading of a stand.
    stand: Option<(String, f64)>,
    /// Index of the point where its pushback ends.
    push_back: Option<usize>,
    radius_m: Option<f64>,
    kind: String,
    cat3: bool,
}

#[derive(Debug)]
struct Arc {
    line: usize,
    begin: usize,
    end: usize,
    name: String,
}

/// Reads a file.
pub(super) fn read(file: &Path) -> Result<GroundNet, ScenarioError> {
    let text = text_of(file)?;
    let document = roxmltree::Document::parse(&text).map_err(|error| {
        let problem = Problem::Line { found: error.to_string(), needed: "well-formed XML" };
        ScenarioError::new(file, error.pos().row as usize, "groundnet", problem)
    })?;
    let mut net = GroundNet { file: file.to_path_buf(), points: Vec::new(), arcs: Vec::new() };
    // Elements come in the order of the file: their lines are counted once.
    let (mut line, mut counted) = (1, 0);
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        let start = node.range().start;
        line += text[counted..start].matches('\n').count();
        counted = start;
        let element = Element { file, line, node };
        match node.tag_name().name() {
            "Parking" => net.points.push(parking(&element)?),
            "node" => net.points.push(taxi_node(&element)?),
            "arc" => net.arcs.push(Arc {
                line: element.line,
                begin: element.index("begin")?,
                end: element.index("end")?,
                name: node.attribute("name").unwrap_or("").trim().into(),
            }),
            _ => {}
        }
    }
    if net.points.is_empty() {
        let problem = Problem::Line { found: "no node".into(), needed: "Parking or node elements" };
        return Err(ScenarioError::new(file, 1, "groundnet", problem));
    }
    Ok(net)
}

struct Element<'a> {
    file: &'a Path,
    line: usize,
    node: roxmltree::Node<'a, 'a>,
}

impl Element<'_> {
    fn text(&self, name: &'static str) -> Result<&str, ScenarioError> {
        self.node
            .attribute(name)
            .ok_or_else(|| self.damaged(name, "no such attribute", "the attribute"))
    }

    fn index(&self, name: &'static str) -> Result<usize, ScenarioError> {
        let text = self.text(name)?;
        text.trim().parse().map_err(|_| self.damaged(name, text, "a whole number from 0"))
    }

    fn number(&self, name: &'static str) -> Result<f64, ScenarioError> {
        let text = self.text(name)?;
        let number = text.trim().parse().ok().filter(|n: &f64| n.is_finite());
        number.ok_or_else(|| self.damaged(name, text, "a number"))
    }

    /// `N47 27.355215`: hemisphere and degrees, then minutes; or plain degrees.
    fn degrees(&self, name: &'static str, limit: f64) -> Result<f64, ScenarioError> {
        const NEEDED: &str = "degrees and minutes like N47 27.355215";
        let text = self.text(name)?.trim();
        let damaged = || self.damaged(name, text, NEEDED);
        let (sign, rest) = match text.chars().next() {
            Some('N' | 'E') => (1.0, &text[1..]),
            Some('S' | 'W') => (-1.0, &text[1..]),
            _ => (1.0, text),
        };
        let mut parts = rest.split_whitespace();
        let degrees: f64 = parts.next().and_then(|p| p.parse().ok()).ok_or_else(damaged)?;
        let (sign, degrees) = if degrees < 0.0 { (-sign, -degrees) } else { (sign, degrees) };
        let minutes: f64 = parts.next().map_or(Ok(0.0), |p| p.parse().map_err(|_| damaged()))?;
        let value = sign * (degrees + minutes / 60.0);
        let sound =
            (0.0..60.0).contains(&minutes) && value.abs() <= limit && parts.next().is_none();
        if sound { Ok(value) } else { Err(damaged()) }
    }

    fn damaged(&self, name: &'static str, found: &str, needed: &'static str) -> ScenarioError {
        let problem = Problem::Line { found: found.into(), needed };
        let key = format!("{}.{name}", self.node.tag_name().name());
        ScenarioError::new(self.file, self.line, key, problem)
    }
}

fn parking(element: &Element<'_>) -> Result<Point, ScenarioError> {
    // The number of a stand may stand beside its name: name="Gate_" number="12".
    let number = element.node.attribute("number").unwrap_or("").trim();
    let name = format!("{}{number}", element.text("name")?.trim()).replace(' ', "_");
    Ok(Point {
        line: element.line,
        index: element.index("index")?,
        lat_deg: element.degrees("lat", 90.0)?,
        lon_deg: element.degrees("lon", 180.0)?,
        on_runway: false,
        hold: Hold::None,
        stand: Some((name, element.number("heading")?)),
        push_back: element.node.attribute("pushBackRoute").and_then(|t| t.trim().parse().ok()),
        radius_m: element.node.attribute("radius").and_then(|t| t.trim().parse().ok()),
        kind: element.node.attribute("type").unwrap_or("").trim().into(),
        cat3: false,
    })
}

fn taxi_node(element: &Element<'_>) -> Result<Point, ScenarioError> {
    let hold = match element.node.attribute("holdPointType").unwrap_or("none") {
        "PushBack" => Hold::PushBack,
        "none" | "" => Hold::None,
        _ => Hold::Runway,
    };
    Ok(Point {
        line: element.line,
        index: element.index("index")?,
        lat_deg: element.degrees("lat", 90.0)?,
        lon_deg: element.degrees("lon", 180.0)?,
        on_runway: element.node.attribute("isOnRunway") == Some("1"),
        hold,
        stand: None,
        push_back: None,
        radius_m: None,
        kind: String::new(),
        cat3: element.node.attribute("holdPointType").is_some_and(|t| t.contains("III")),
    })
}

impl GroundNet {
    /// The middle of all points, at sea level.
    pub(super) fn reference(&self) -> Geodetic {
        super::middle(self.points.iter().map(|p| (p.lat_deg, p.lon_deg)), 0.0)
    }

    /// Replaces the network and the stands of `airport`.
    pub(super) fn into_airport(
        self,
        frame: &LocalFrame,
        width_m: f64,
        airport: &mut Airport,
        report: &mut LayoutReport,
    ) {
        let mut by_index = BTreeMap::new();
        for point in &self.points {
            if let Entry::Vacant(free) = by_index.entry(point.index) {
                free.insert(point);
            } else {
                let (line, index) = (point.line, point.index);
                report.lines.push(format!("line {line}: index {index} a second time: left out"));
            }
        }
        let arcs = self.merged_arcs(&by_index, report);
        let used: BTreeSet<usize> = arcs.keys().flat_map(|(a, b)| [*a, *b]).collect();
        let isolated = by_index.keys().filter(|index| !used.contains(index));
        for index in isolated {
            let point = by_index[index];
            let what = point.stand.as_ref().map_or("node", |_| "stand");
            report.lines.push(format!(
                "line {}: {what} {index} has no arc: left out of the network",
                point.line
            ));
        }
        let (mut nodes, mut stands) = (Vec::new(), Vec::new());
        let mut details = Vec::new();
        let mut node_of = BTreeMap::new();
        let mut names = BTreeSet::new();
        for (index, point) in &by_index {
            let position_m = local_m(frame, point.lat_deg, point.lon_deg);
            let mut name = point.stand.as_ref().map_or_else(|| index.to_string(), |s| s.0.clone());
            if name.is_empty() || !names.insert(name.clone()) {
                let unique = format!("{name}_{index}");
                report.lines.push(format!("line {}: second {name:?}, called {unique}", point.line));
                names.insert(unique.clone());
                name = unique;
            }
            let node = used.contains(index).then(|| {
                nodes.push(Node { name: name.clone(), position_m, hold: point.hold });
                node_of.insert(*index, nodes.len() - 1);
                nodes.len() - 1
            });
            if let Some((_, heading_deg)) = point.stand {
                if !(0.0..360.0).contains(&heading_deg) {
                    let sound = heading_deg.rem_euclid(360.0);
                    report
                        .lines
                        .push(format!("stand {name}: heading {heading_deg} read as {sound:.2}"));
                }
                let heading_rad = Azimuth::from_rad(heading_deg.to_radians()).rad();
                stands.push(Stand { name, position_m, heading_rad, node });
                details.push((point.radius_m, point.push_back, point.kind.clone()));
            }
        }
        let edges = arcs.iter().map(|((a, b), arc)| Edge {
            from: if arc.forward { node_of[a] } else { node_of[b] },
            to: if arc.forward { node_of[b] } else { node_of[a] },
            two_way: arc.forward && arc.backward,
            runway: by_index[a].on_runway && by_index[b].on_runway,
            name: arc.name.clone(),
            width_m,
        });
        airport.edges = edges.collect();
        airport.details = models::airport::Details::default();
        let stand_details = details.into_iter().map(|(radius_m, push_back, kind)| StandDetail {
            code: None,
            radius_m,
            push_back: push_back.and_then(|i| node_of.get(&i).copied()),
            kind,
        });
        airport.details.stands = stand_details.collect();
        airport.details.numbers =
            by_index.keys().filter(|i| used.contains(i)).map(ToString::to_string).collect();
        let cat3 = by_index.values().filter(|p| p.cat3);
        airport.details.cat3_holds = cat3.filter_map(|p| node_of.get(&p.index).copied()).collect();
        airport.nodes = nodes;
        airport.stands = stands;
        report.lines.push(format!(
            "{}: {} stands, {} nodes in the network, {} edges from {} arcs ({} one-way)",
            self.file.display(),
            airport.stands.len(),
            airport.nodes.len(),
            airport.edges.len(),
            self.arcs.len(),
            airport.edges.iter().filter(|e| !e.two_way).count(),
        ));
    }

    /// One entry for each pair of points, by the smaller index first.
    fn merged_arcs(
        &self,
        by_index: &BTreeMap<usize, &Point>,
        report: &mut LayoutReport,
    ) -> BTreeMap<(usize, usize), MergedArc> {
        let mut merged: BTreeMap<(usize, usize), MergedArc> = BTreeMap::new();
        for arc in &self.arcs {
            let missing = [arc.begin, arc.end].into_iter().find(|i| !by_index.contains_key(i));
            if let Some(index) = missing {
                let line = arc.line;
                report.lines.push(format!("line {line}: arc to no node {index}: left out"));
                continue;
            }
            if arc.begin == arc.end {
                report
                    .lines
                    .push(format!("line {}: arc from {} to itself: left out", arc.line, arc.begin));
                continue;
            }
            let forward = arc.begin < arc.end;
            let pair = (arc.begin.min(arc.end), arc.begin.max(arc.end));
            let entry = merged.entry(pair).or_default();
            let direction = if forward { &mut entry.forward } else { &mut entry.backward };
            if *direction {
                let (a, b) = (arc.begin, arc.end);
                report
                    .lines
                    .push(format!("line {}: arc {a} to {b} a second time: left out", arc.line));
            }
            *direction = true;
            if entry.name.is_empty() {
                entry.name.clone_from(&arc.name);
            }
        }
        merged
    }
}

#[derive(Debug, Default)]
struct MergedArc {
    /// From the smaller index to the larger.
    forward: bool,
    backward: bool,
    name: String,
}
