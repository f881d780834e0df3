//! The ground network that movers use, made from a layout by repairs, each of which says what it did.
//!
//! | step | what |
//! | --- | --- |
//! | R1 | edges twice or to themselves out, nodes nearer than 1 m joined |
//! | R2 | edges that cross without a node are reported (bridges and tunnels are not in the files) |
//! | R3 | runway spine: nodes on a runway go to its centreline, neighbours and ends are joined both ways |
//! | R4 | runway holding positions: those of the file, else cut at a distance by the runway's length |
//! | R4b | a turn pad at ends that nobody enters near, and ways to it along the runway |
//! | R5 | stands without a node: a lead-in to the nearest edge, at most 150 m |
//! | R6 | pushbacks: planned from lead-in and lane when they are needed |
//! | R7 | only the largest strongly connected part is used |
//! | R8 | widths from the code letter, else as the layout says |
//! | R9 | fillets: see [`super::path`] |

use crate::airport::{Airport, Hold};
use crate::frames::Point2;
use std::collections::{BTreeMap, BTreeSet};

mod holds;
mod joints;
mod parts;
mod spines;
mod stands;
mod turn_pads;

/// A point of the network.
#[derive(Clone, Debug, PartialEq)]
pub struct NetNode {
    /// Name in its file, or one that says what made it.
    pub name: String,
    /// Place, m.
    pub at_m: Point2<f64>,
    /// Runway on whose centreline it lies.
    pub runway: Option<usize>,
    /// Runway for which aircraft hold here.
    pub hold_for: Option<usize>,
    /// Stand whose node it is.
    pub stand: Option<usize>,
    /// In the part of the network that is used.
    pub used: bool,
}

/// A straight edge.
#[derive(Clone, Debug, PartialEq)]
pub struct NetEdge {
    /// Its nodes.
    pub nodes: [usize; 2],
    /// May be driven from the second to the first.
    pub two_way: bool,
    /// On the centreline of this runway.
    pub runway: Option<usize>,
    /// Between runway and holding position of this runway.
    pub strip: Option<usize>,
    /// Along a runway to or from the turn pad at its end.
    pub backtrack: bool,
    /// Name of the taxiway.
    pub name: String,
    /// Largest code letter, 0 (A) to 5 (F).
    pub code: u8,
    /// Edge of the layout that it comes from.
    pub origin: Option<usize>,
}

/// A stand that movers use.
#[derive(Clone, Debug, PartialEq)]
pub struct NetStand {
    /// Name.
    pub name: String,
    /// Its node, where there is a way to it.
    pub node: Option<usize>,
    /// Place, m, and heading, rad.
    pub at_m: Point2<f64>,
    /// Heading of a parked aircraft, rad.
    pub heading_rad: f64,
    /// Largest code letter, 0 (A) to 5 (F).
    pub code: u8,
    /// Whether the file says it; else E is assumed.
    pub code_known: bool,
    /// The file gives it to light aircraft and helicopters.
    pub light: bool,
    /// Its node lies so far beyond the place of the file, m, that the tail of the longest is clear of the lane.
    pub moved_m: f64,
}

/// A runway as movers use it.
#[derive(Clone, Debug, PartialEq)]
pub struct NetRunway {
    /// Designators.
    pub names: [String; 2],
    /// Ends, m.
    pub ends_m: [Point2<f64>; 2],
    /// Displacement of the thresholds from the ends, m.
    pub displaced_m: [f64; 2],
    /// Length and width, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Nodes on it with their place from the first end, sorted.
    pub spine: Vec<(f64, usize)>,
    /// Distance of holding positions where the file has none, m.
    pub hold_distance_m: f64,
    /// By end: nobody enters near it, one backtracks to a turn pad there.
    pub turn_pads: [bool; 2],
}

/// The network with everything that the repairs said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// Points.
    pub nodes: Vec<NetNode>,
    /// Edges.
    pub edges: Vec<NetEdge>,
    /// Stands, in the order of the layout.
    pub stands: Vec<NetStand>,
    /// Runways, in the order of the layout.
    pub runways: Vec<NetRunway>,
    /// By edge: beside stands.
    lanes: Vec<bool>,
    /// What was done, in order.
    pub report: Vec<String>,
    /// What is wrong with it as a network for traffic.
    pub findings: Vec<String>,
}

/// Nodes nearer than this are one, m.
const JOINED_M: f64 = 1.0;

impl NetRunway {
    /// Place along it from the first end and distance from its centreline (right positive), m.
    #[must_use]
    pub fn place_m(&self, point_m: Point2<f64>) -> (f64, f64) {
        let along = (self.ends_m[1] - self.ends_m[0]) / self.length_m;
        let from = point_m - self.ends_m[0];
        (from.dot(&along), from.x * along.y - from.y * along.x)
    }

    fn at(&self, place_m: f64) -> Point2<f64> {
        self.ends_m[0] + (self.ends_m[1] - self.ends_m[0]) * (place_m / self.length_m)
    }

    /// Distance from the runway as a line, m.
    fn distance_m(&self, point_m: Point2<f64>) -> f64 {
        crate::airport::distance_to_segment_m(point_m, self.ends_m[0], self.ends_m[1])
    }
}

/// Index 0 to 5 of a code letter.
#[must_use]
pub fn code_index(letter: char) -> u8 {
    (letter as u32).saturating_sub('A' as u32).min(5) as u8
}

/// Code of the smallest letter whose span is at least `span_m`.
#[must_use]
pub fn code_of_span(span_m: f64) -> u8 {
    [15.0, 24.0, 36.0, 52.0, 65.0].iter().position(|most| span_m < *most).unwrap_or(5) as u8
}

/// "a, b and 4 more".
fn named(names: &[String]) -> String {
    let shown = names[..names.len().min(6)].join(", ");
    match names.len().saturating_sub(6) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Two taxiways that meet a runway no farther apart cross it, m (assumed).
const ACROSS_M: f64 = 60.0;

impl Network {
    /// The network of a layout.
    #[must_use]
    pub fn of(airport: &Airport) -> Self {
        let mut net = Self::default();
        net.copy(airport);
        net.clean();
        net.crossings(airport.details.mend_crossings);
        net.spines();
        net.holds(airport);
        net.turn_pads();
        let before = net.clone();
        net.lead_ins();
        net.free_lanes(&before);
        net.report.push("R6: pushbacks follow lead-in and lane, L + 20 m away from the way".into());
        net.parts();
        net.report.push("R8: widths by code letter, else as the layout says".into());
        net.report.push("R9: fillets of 30 m (C), 45 m (D, E), 60 m (F), 25 m to stands, less where edges are short".into());
        net.clear_lanes();
        net.mark_lanes();
        net.find();
        net
    }

    fn copy(&mut self, airport: &Airport) {
        let guessed: BTreeSet<usize> = airport.details.joined.iter().copied().collect();
        for node in &airport.nodes {
            self.nodes.push(NetNode {
                name: node.name.clone(),
                at_m: node.position_m,
                runway: None,
                hold_for: (node.hold == Hold::Runway).then_some(usize::MAX),
                stand: None,
                used: false,
            });
        }
        for (index, edge) in airport.edges.iter().enumerate() {
            if guessed.contains(&index) {
                continue;
            }
            let code = airport.details.edges.get(index).and_then(|d| d.code);
            self.edges.push(NetEdge {
                nodes: [edge.from, edge.to],
                two_way: edge.two_way,
                runway: None,
                strip: None,
                backtrack: false,
                name: edge.name.clone(),
                code: code.map_or(5, code_index),
                origin: Some(index),
            });
        }
        let by_guess: BTreeSet<usize> = guessed.iter().map(|e| airport.edges[*e].from).collect();
        for (index, stand) in airport.stands.iter().enumerate() {
            let detail = airport.details.stands.get(index);
            let letter = detail.and_then(|d| d.code).map(code_index);
            let by_radius = detail
                .and_then(|d| d.radius_m)
                .filter(|r| *r > 1.0)
                .map(|r| code_of_span(2.0 * r - 0.1));
            let node = stand.node.filter(|n| !by_guess.contains(n));
            if let Some(node) = node {
                self.nodes[node].stand = Some(index);
            }
            self.stands.push(NetStand {
                name: stand.name.clone(),
                node,
                at_m: stand.position_m,
                heading_rad: stand.heading_rad,
                code: letter.or(by_radius).unwrap_or(4),
                code_known: letter.or(by_radius).is_some(),
                light: detail.is_some_and(|d| ["ga", "tie_down"].contains(&d.kind.as_str())),
                moved_m: 0.0,
            });
        }
        for runway in &airport.runways {
            let along = runway.ends_m[1] - runway.ends_m[0];
            let length_m = along.norm();
            if length_m < 100.0 {
                continue;
            }
            let displaced = |end: usize| {
                let sign = if end == 0 { 1.0 } else { -1.0 };
                let shift = (runway.thresholds_m[end] - runway.ends_m[end]).dot(&along) / length_m;
                (sign * shift).clamp(0.0, 0.5 * length_m)
            };
            self.runways.push(NetRunway {
                names: runway.names.clone(),
                ends_m: runway.ends_m,
                displaced_m: [displaced(0), displaced(1)],
                length_m,
                width_m: runway.width_m,
                spine: Vec::new(),
                // Code number 1 and 2: up to 1 200 m; longer ones are taken for precision runways.
                hold_distance_m: if length_m < 1200.0 { 40.0 } else { 90.0 },
                turn_pads: [false; 2],
            });
        }
    }

    /// One edge a pair of nodes; two one-way edges make a two-way one.
    fn unique(&mut self) {
        let mut kept: Vec<NetEdge> = Vec::with_capacity(self.edges.len());
        let mut index: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for edge in std::mem::take(&mut self.edges) {
            let [a, b] = edge.nodes;
            if a == b {
                continue;
            }
            match index.get(&(a.min(b), a.max(b))) {
                Some(known) => {
                    let other = &mut kept[*known];
                    other.two_way |= edge.two_way || other.nodes == [b, a];
                    other.runway = other.runway.or(edge.runway);
                    other.strip = other.strip.or(edge.strip);
                }
                None => {
                    index.insert((a.min(b), a.max(b)), kept.len());
                    kept.push(edge);
                }
            }
        }
        self.edges = kept;
    }

    fn ends(&self, edge: &NetEdge) -> [Point2<f64>; 2] {
        edge.nodes.map(|n| self.nodes[n].at_m)
    }

    /// Length of an edge, m.
    #[must_use]
    pub fn length_m(&self, edge: usize) -> f64 {
        let [a, b] = self.ends(&self.edges[edge]);
        (b - a).norm()
    }

    /// Whether who drives an edge taxies along a runway; over a short one between two taxiways he only crosses it.
    #[must_use]
    pub fn is_along_runway(&self, edge: &NetEdge) -> bool {
        let [a, b] = self.ends(edge);
        edge.runway.is_some() && (b - a).norm() > ACROSS_M
    }

    /// Whether an edge is a lane beside stands: a lead-in begins at one of its nodes.
    #[must_use]
    pub fn is_lane(&self, edge: usize) -> bool {
        self.lanes.get(edge).copied().unwrap_or(false)
    }

    /// The same with its lanes beside stands marked.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn with_lanes(mut self) -> Self {
        self.mark_lanes();
        self
    }

    fn mark_lanes(&mut self) {
        let mut beside = vec![false; self.nodes.len()];
        for edge in &self.edges {
            let stand = edge.nodes.iter().any(|n| self.nodes[*n].stand.is_some());
            if stand {
                edge.nodes.iter().for_each(|n| beside[*n] = true);
            }
        }
        self.lanes = self.edges.iter().map(|e| e.nodes.iter().any(|n| beside[*n])).collect();
    }

    fn add_node(&mut self, name: String, at_m: Point2<f64>) -> usize {
        self.nodes.push(NetNode {
            name,
            at_m,
            runway: None,
            hold_for: None,
            stand: None,
            used: false,
        });
        self.nodes.len() - 1
    }

    /// Cuts an edge at a place, m from its first node; the node that is made or that is there.
    fn cut(&mut self, edge: usize, place_m: f64, name: String) -> usize {
        let [a, b] = self.ends(&self.edges[edge]);
        let length = (b - a).norm();
        let [first, second] = self.edges[edge].nodes;
        if place_m <= JOINED_M && self.nodes[first].stand.is_none() {
            return first;
        }
        if length - place_m <= JOINED_M && self.nodes[second].stand.is_none() {
            return second;
        }
        let node = self.add_node(name, a + (b - a) * (place_m / length).clamp(0.0, 1.0));
        self.cut_at(edge, node);
        node
    }

    /// Cuts an edge at a node that lies on it; the rest is the last edge.
    fn cut_at(&mut self, edge: usize, node: usize) {
        let mut rest = self.edges[edge].clone();
        rest.nodes[0] = node;
        self.edges[edge].nodes[1] = node;
        self.edges.push(rest);
    }
}

/// Shares of two segments at which they cross, both in [0, 1].
fn crossing(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>, d: Point2<f64>) -> Option<(f64, f64)> {
    let (u, v, w) = (b - a, d - c, c - a);
    let area = u.x * v.y - u.y * v.x;
    if area.abs() < 1e-9 {
        return None;
    }
    let (s, t) = ((w.x * v.y - w.y * v.x) / area, (w.x * u.y - w.y * u.x) / area);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some((s, t))
}
