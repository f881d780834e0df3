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
use crate::frames::Vector2;
use std::collections::{BTreeMap, BTreeSet};

mod turn_pads;

/// A point of the network.
#[derive(Clone, Debug, PartialEq)]
pub struct NetNode {
    /// Name in its file, or one that says what made it.
    pub name: String,
    /// Place, m.
    pub at_m: Vector2<f64>,
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
    pub at_m: Vector2<f64>,
    /// Heading of a parked aircraft, rad.
    pub heading_rad: f64,
    /// Largest code letter, 0 (A) to 5 (F).
    pub code: u8,
    /// Whether the file says it; else E is assumed.
    pub code_known: bool,
    /// Its node lies so far beyond the place of the file, m, that the tail of the longest is clear of the lane.
    pub moved_m: f64,
}

/// A runway as movers use it.
#[derive(Clone, Debug, PartialEq)]
pub struct NetRunway {
    /// Designators.
    pub names: [String; 2],
    /// Ends, m.
    pub ends_m: [Vector2<f64>; 2],
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
/// Stands farther from every edge than this have no way, m.
const STAND_REACH_M: f64 = 150.0;

impl NetRunway {
    /// Place along it from the first end and distance from its centreline (right positive), m.
    #[must_use]
    pub fn place_m(&self, point_m: Vector2<f64>) -> (f64, f64) {
        let along = (self.ends_m[1] - self.ends_m[0]) / self.length_m;
        let from = point_m - self.ends_m[0];
        (from.dot(&along), from.x * along.y - from.y * along.x)
    }

    fn at(&self, place_m: f64) -> Vector2<f64> {
        self.ends_m[0] + (self.ends_m[1] - self.ends_m[0]) * (place_m / self.length_m)
    }

    /// Distance from the runway as a line, m.
    fn distance_m(&self, point_m: Vector2<f64>) -> f64 {
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

/// A stand so near to a line lies on it, m.
const ON_EDGE_M: f64 = 3.0;

impl Network {
    /// The network of a layout.
    #[must_use]
    pub fn of(airport: &Airport) -> Self {
        let mut net = Self::default();
        net.copy(airport);
        net.clean();
        net.crossings();
        net.spines();
        net.holds(airport);
        net.turn_pads();
        net.lead_ins();
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

    /// R1.
    fn clean(&mut self) {
        let mut onto: Vec<usize> = (0..self.nodes.len()).collect();
        let mut order: Vec<usize> = (0..self.nodes.len()).collect();
        order.sort_by(|a, b| self.nodes[*a].at_m.x.total_cmp(&self.nodes[*b].at_m.x));
        let mut joined = 0;
        for i in 0..order.len() {
            for j in i + 1..order.len() {
                let (a, b) = (order[i].min(order[j]), order[i].max(order[j]));
                if self.nodes[order[j]].at_m.x - self.nodes[order[i]].at_m.x > JOINED_M {
                    break;
                }
                let near = (self.nodes[a].at_m - self.nodes[b].at_m).norm() < JOINED_M;
                let both = self.nodes[a].stand.is_some() && self.nodes[b].stand.is_some();
                if near && !both && onto[a] == a && onto[b] == b {
                    let (keep, drop) = if self.nodes[b].stand.is_some() { (b, a) } else { (a, b) };
                    onto[drop] = keep;
                    let hold_for = self.nodes[drop].hold_for;
                    self.nodes[keep].hold_for = self.nodes[keep].hold_for.or(hold_for);
                    joined += 1;
                }
            }
        }
        for edge in &mut self.edges {
            edge.nodes = edge.nodes.map(|n| onto[n]);
        }
        let before = self.edges.len();
        self.unique();
        let out = before - self.edges.len();
        self.report.push(format!(
            "R1: {joined} nodes nearer than {JOINED_M} m joined, {out} edges twice or to themselves out"
        ));
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
                }
                None => {
                    index.insert((a.min(b), a.max(b)), kept.len());
                    kept.push(edge);
                }
            }
        }
        self.edges = kept;
    }

    fn ends(&self, edge: &NetEdge) -> [Vector2<f64>; 2] {
        edge.nodes.map(|n| self.nodes[n].at_m)
    }

    /// Length of an edge, m.
    #[must_use]
    pub fn length_m(&self, edge: usize) -> f64 {
        let [a, b] = self.ends(&self.edges[edge]);
        (b - a).norm()
    }

    /// Whether an edge is a lane beside stands: a lead-in begins at one of its nodes.
    #[must_use]
    pub fn is_lane(&self, edge: usize) -> bool {
        self.lanes.get(edge).copied().unwrap_or(false)
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

    /// R2.
    fn crossings(&mut self) {
        let mut found = Vec::new();
        for (i, first) in self.edges.iter().enumerate() {
            let [a, b] = self.ends(first);
            for second in &self.edges[i + 1..] {
                if first.nodes.iter().any(|n| second.nodes.contains(n)) {
                    continue;
                }
                let [c, d] = self.ends(second);
                if a.x.max(b.x) < c.x.min(d.x) || c.x.max(d.x) < a.x.min(b.x) {
                    continue;
                }
                let Some((s, t)) = crossing(a, b, c, d) else { continue };
                let clear =
                    |share: f64, length: f64| share * length > 5.0 && (1.0 - share) * length > 5.0;
                let (l, m) = ((b - a).norm(), (d - c).norm());
                let angle = ((b - a).dot(&(d - c)) / (l * m)).abs();
                if clear(s, l) && clear(t, m) && angle < libm::cos(15_f64.to_radians()) {
                    let name = |n: usize| self.nodes[n].name.clone();
                    found.push(format!(
                        "{}-{} and {}-{}",
                        name(first.nodes[0]),
                        name(first.nodes[1]),
                        name(second.nodes[0]),
                        name(second.nodes[1])
                    ));
                }
            }
        }
        self.report.push(format!(
            "R2: {} pairs of edges cross without a node, left as they are",
            found.len()
        ));
        if !found.is_empty() {
            self.findings.push(format!(
                "{} pairs of edges cross without a node: {}",
                found.len(),
                named(&found)
            ));
        }
    }

    fn add_node(&mut self, name: String, at_m: Vector2<f64>) -> usize {
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
        let mut rest = self.edges[edge].clone();
        rest.nodes = [node, second];
        self.edges[edge].nodes[1] = node;
        self.edges.push(rest);
        node
    }

    /// R3.
    fn spines(&mut self) {
        for r in 0..self.runways.len() {
            let (mut moved, mut cut) = (0, 0);
            let runway = self.runways[r].clone();
            // Where another runway crosses, both have a node.
            let mut spine: Vec<(f64, usize)> = Vec::new();
            for other in 0..r {
                let [a, b] = runway.ends_m;
                let [c, d] = self.runways[other].ends_m;
                if let Some((s, _)) = crossing(a, b, c, d) {
                    let place = s * runway.length_m;
                    let on_other = self.runways[other].place_m(runway.at(place)).0;
                    let known = self.runways[other].spine.iter();
                    let near = known
                        .filter(|(p, _)| (p - on_other).abs() < JOINED_M)
                        .map(|(_, node)| *node)
                        .next();
                    let name = format!("{}x{}", runway.names[0], self.runways[other].names[0]);
                    let node = match near {
                        Some(node) => node,
                        None => self.add_node(name, runway.at(place)),
                    };
                    spine.push((place, node));
                    if near.is_none() {
                        self.nodes[node].runway = Some(other);
                        self.runways[other].spine.push((on_other, node));
                    }
                }
            }
            for n in 0..self.nodes.len() {
                let node = &self.nodes[n];
                let (place, off) = runway.place_m(node.at_m);
                let on = off.abs() <= 0.5 * runway.width_m + 1.0
                    && (-1.0..=runway.length_m + 1.0).contains(&place);
                let in_use = self.edges.iter().any(|e| e.nodes.contains(&n));
                if on && in_use && node.runway.is_none() && node.stand.is_none() {
                    moved += usize::from(off.abs() > 0.01);
                    let place = place.clamp(0.0, runway.length_m);
                    self.nodes[n].at_m = runway.at(place);
                    self.nodes[n].runway = Some(r);
                    self.nodes[n].hold_for = None;
                    spine.push((place, n));
                }
            }
            let on: BTreeSet<usize> = spine.iter().map(|(_, n)| *n).collect();
            for e in 0..self.edges.len() {
                let edge = &self.edges[e];
                if edge.nodes.iter().any(|n| on.contains(n)) {
                    continue;
                }
                let [a, b] = self.ends(edge);
                if let Some((s, t)) = crossing(a, b, runway.ends_m[0], runway.ends_m[1]) {
                    let node = self.cut(
                        e,
                        s * (b - a).norm(),
                        format!("{}_at_{:.0}", runway.names[0], t * runway.length_m),
                    );
                    self.nodes[node].runway = Some(r);
                    spine.push((t * runway.length_m, node));
                    cut += 1;
                }
            }
            for (place, end) in [(0.0, 0), (runway.length_m, 1)] {
                if !spine.iter().any(|(p, _)| (p - place).abs() < 5.0) {
                    let node =
                        self.add_node(format!("end_{}", runway.names[end]), runway.at(place));
                    self.nodes[node].runway = Some(r);
                    spine.push((place, node));
                }
            }
            self.runways[r].spine = spine;
            let name = runway.names.join("/");
            self.report.push(format!("R3: runway {name}: {moved} nodes put on the centreline, {cut} edges that cross it cut, spine made"));
        }
        for r in 0..self.runways.len() {
            let mut spine = std::mem::take(&mut self.runways[r].spine);
            spine.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            // Places nearer than a metre are one.
            let mut kept: Vec<(f64, usize)> = Vec::new();
            for (place, node) in spine {
                match kept.last() {
                    Some((p, known)) if place - p < JOINED_M => {
                        let known = *known;
                        self.edges.iter_mut().for_each(|e| {
                            e.nodes = e.nodes.map(|n| if n == node { known } else { n })
                        });
                        for other in &mut self.runways {
                            other
                                .spine
                                .iter_mut()
                                .filter(|s| s.1 == node)
                                .for_each(|s| s.1 = known);
                        }
                    }
                    _ => kept.push((place, node)),
                }
            }
            let on: BTreeSet<usize> = kept.iter().map(|(_, n)| *n).collect();
            self.edges.retain(|e| !e.nodes.iter().all(|n| on.contains(n)));
            for pair in kept.windows(2) {
                self.edges.push(NetEdge {
                    nodes: [pair[0].1, pair[1].1],
                    two_way: true,
                    runway: Some(r),
                    strip: Some(r),
                    backtrack: false,
                    name: self.runways[r].names.join("/"),
                    code: 5,
                    origin: None,
                });
            }
            self.runways[r].spine = kept;
        }
        self.unique();
    }

    /// R4.
    fn holds(&mut self, airport: &Airport) {
        for r in 0..self.runways.len() {
            let (mut of_file, mut of_zone, mut made) = (0, 0, 0);
            let runway = self.runways[r].clone();
            let mut open: Vec<usize> = runway.spine.iter().map(|(_, n)| *n).collect();
            let mut inside: BTreeSet<usize> = open.iter().copied().collect();
            while let Some(node) = open.pop() {
                let leaving: Vec<usize> = (0..self.edges.len())
                    .filter(|e| {
                        let edge = &self.edges[*e];
                        edge.nodes.contains(&node) && edge.runway.is_none() && edge.strip.is_none()
                    })
                    .collect();
                for e in leaving {
                    let edge = &self.edges[e];
                    let (first, next) =
                        (edge.nodes[0] == node, edge.nodes[usize::from(edge.nodes[0] == node)]);
                    if inside.contains(&next) {
                        self.edges[e].strip = Some(r);
                        continue;
                    }
                    let (near, far) = (
                        runway.distance_m(self.nodes[node].at_m),
                        runway.distance_m(self.nodes[next].at_m),
                    );
                    let length = self.length_m(e);
                    let given = self.nodes[next].hold_for.is_some() && far > 25.0 && far < 300.0;
                    if given {
                        self.edges[e].strip = Some(r);
                        self.nodes[next].hold_for = Some(r);
                        of_file += 1;
                        continue;
                    }
                    let zoned = |edge: &NetEdge| {
                        let zones = edge
                            .origin
                            .and_then(|o| airport.details.edges.get(o))
                            .map(|d| &d.zones);
                        zones.is_some_and(|z| z.iter().any(|name| runway.names.contains(name)))
                    };
                    let beyond = self
                        .edges
                        .iter()
                        .enumerate()
                        .filter(|(i, other)| *i != e && other.nodes.contains(&next));
                    let beyond_zone = beyond.map(|(_, other)| zoned(other)).collect::<Vec<_>>();
                    if zoned(&self.edges[e])
                        && far >= 25.0
                        && !beyond_zone.is_empty()
                        && !beyond_zone.contains(&true)
                    {
                        self.edges[e].strip = Some(r);
                        self.nodes[next].hold_for = Some(r);
                        of_zone += 1;
                        continue;
                    }
                    let degree = beyond_zone.len();
                    let wanted = runway.hold_distance_m;
                    let other_runway = self.nodes[next].runway.is_some();
                    let flat = far - near < 0.3 * length;
                    let place = if far >= wanted {
                        // The distance grows evenly along a straight edge off the runway.
                        Some(length * ((wanted - near) / (far - near)).clamp(0.0, 1.0))
                    } else if degree != 1
                        || other_runway
                        || self.nodes[next].stand.is_some()
                        || (flat && near > 30.0)
                    {
                        // A junction nearer than that: hold short of it, as far from the runway as there is room.
                        Some((length - 25.0).max(0.5 * length))
                    } else {
                        None
                    };
                    match place {
                        Some(place) => {
                            let from_first = if first { place } else { length - place };
                            let name =
                                format!("hold_{}_{}", runway.names.join("_"), self.nodes.len());
                            let before = self.edges.len();
                            let hold = self.cut(e, from_first, name);
                            let inner =
                                if first || self.edges.len() == before { e } else { before };
                            self.edges[inner].strip = Some(r);
                            if self.nodes[hold].runway.is_none() {
                                self.nodes[hold].hold_for = Some(r);
                            }
                            made += 1;
                        }
                        None => {
                            self.edges[e].strip = Some(r);
                            inside.insert(next);
                            open.push(next);
                        }
                    }
                }
            }
            let name = runway.names.join("/");
            self.report.push(format!(
                "R4: runway {name}: {of_file} holding positions of the file, {of_zone} at the end of active zones, {made} made at {} m (assumed) or short of a junction",
                runway.hold_distance_m
            ));
        }
        for node in &mut self.nodes {
            if node.hold_for == Some(usize::MAX) {
                node.hold_for = None;
            }
        }
    }

    /// R5.
    fn lead_ins(&mut self) {
        let (mut joined, mut at_node, mut off) = (0, 0, Vec::new());
        let mut on_edge: Vec<String> = Vec::new();
        let has_edge = |net: &Self, node: usize| net.edges.iter().any(|e| e.nodes.contains(&node));
        // First all that have a lead-in: nobody is joined to the lead-in of another.
        for s in 0..self.stands.len() {
            if self.stands[s].node.is_some_and(|n| has_edge(self, n)) {
                continue;
            }
            let stand = self.stands[s].clone();
            let usable = |net: &Self, n: usize| {
                let node = &net.nodes[n];
                node.runway.is_none() && node.stand.is_none()
            };
            let degree =
                |net: &Self, n: usize| net.edges.iter().filter(|e| e.nodes.contains(&n)).count();
            let near = (0..self.nodes.len()).find(|n| {
                (self.nodes[*n].at_m - stand.at_m).norm() < 2.0
                    && usable(self, *n)
                    && degree(self, *n) == 1
            });
            if let Some(node) = near {
                self.nodes[node].stand = Some(s);
                self.stands[s].node = Some(node);
                at_node += 1;
            }
        }
        for s in 0..self.stands.len() {
            if self.stands[s].node.is_some_and(|n| has_edge(self, n)) {
                continue;
            }
            let stand = self.stands[s].clone();
            let ahead = crate::frames::Azimuth::from_rad(stand.heading_rad).unit();
            if let Some((from, to)) = self.end_at_stand(s, ahead) {
                on_edge.push(format!("{} ({from}-{to})", stand.name));
                joined += 1;
                continue;
            }
            let mut best: Option<(bool, f64, usize, f64)> = None;
            for (e, edge) in self.edges.iter().enumerate() {
                let stands_there = edge.nodes.iter().any(|n| self.nodes[*n].stand.is_some());
                if edge.strip.is_some() || edge.runway.is_some() || stands_there {
                    continue;
                }
                let [a, b] = self.ends(edge);
                let length = (b - a).norm();
                let place = ((stand.at_m - a).dot(&(b - a)) / length).clamp(0.0, length);
                let foot = a + (b - a) * (place / length);
                let distance = (stand.at_m - foot).norm();
                if distance <= STAND_REACH_M && distance > JOINED_M {
                    let against = (stand.at_m - foot).dot(&ahead) < 0.0;
                    let better = best.is_none_or(|(x, d, ..)| (against, distance) < (x, d));
                    if better {
                        best = Some((against, distance, e, place));
                    }
                }
            }
            let Some((_, _, e, place)) = best else {
                off.push(stand.name.clone());
                continue;
            };
            let length = self.length_m(e);
            let place = if place < 10.0 {
                0.0
            } else if length - place < 10.0 {
                length
            } else {
                place
            };
            let foot = self.cut(e, place, format!("at_{}", stand.name));
            let node = match stand.node {
                Some(node) => node,
                None => self.add_node(stand.name.clone(), stand.at_m),
            };
            self.nodes[node].stand = Some(s);
            self.stands[s].node = Some(node);
            let (code, name) = (self.edges[e].code, String::new());
            self.edges.push(NetEdge {
                nodes: [foot, node],
                two_way: true,
                runway: None,
                strip: None,
                backtrack: false,
                name,
                code,
                origin: None,
            });
            joined += 1;
        }
        self.report.push(format!(
            "R5: {joined} stands joined to the nearest edge, {at_node} to the end of a lead-in, {} without a way within {STAND_REACH_M} m",
            off.len()
        ));
        if !on_edge.is_empty() {
            self.findings.push(format!(
                "{} stands lie on a taxiway, which ends there: {}",
                on_edge.len(),
                named(&on_edge)
            ));
        }
        if !off.is_empty() {
            self.findings.push(format!(
                "{} stands without a way to the network: {}",
                off.len(),
                named(&off)
            ));
        }
    }

    /// A stand on an edge that leads through it, the way it heads: the part behind it is its lead-in, what goes on from it is
    /// cut off, since a way never leads over a stand. The names of the ends of that edge.
    fn end_at_stand(&mut self, s: usize, ahead: Vector2<f64>) -> Option<(String, String)> {
        let at_m = self.stands[s].at_m;
        let mut best: Option<(f64, usize, f64)> = None;
        for (e, edge) in self.edges.iter().enumerate() {
            let stands_there = edge.nodes.iter().any(|n| self.nodes[*n].stand.is_some());
            if edge.strip.is_some() || edge.runway.is_some() || stands_there {
                continue;
            }
            let [a, b] = self.ends(edge);
            let length = (b - a).norm();
            let place = (at_m - a).dot(&(b - a)) / length;
            let off_m = (a + (b - a) * (place / length) - at_m).norm();
            let along = (b - a).dot(&ahead) / length;
            let inside = place > 10.0 && length - place > 10.0;
            if inside && off_m < ON_EDGE_M && along.abs() > 0.7 {
                let nearer = best.is_none_or(|x| off_m < x.0);
                best = if nearer { Some((off_m, e, place)) } else { best };
            }
        }
        let (_, e, place) = best?;
        let [first, second] = self.edges[e].nodes;
        let names = [first, second].map(|n| self.nodes[n].name.clone());
        let [a, b] = self.ends(&self.edges[e]);
        let node = self.cut(e, place, self.stands[s].name.clone());
        let rest = self.edges.len() - 1;
        // The cut leaves the part from the first node in place and puts the other last.
        let (kept, dropped) = if (b - a).dot(&ahead) > 0.0 { (e, rest) } else { (rest, e) };
        self.edges[kept].two_way = true;
        self.edges.remove(dropped);
        self.nodes[node].stand = Some(s);
        self.stands[s].node = Some(node);
        let [from, to] = names;
        Some((from, to))
    }

    /// A stand nearer to its lane than its largest aircraft needs goes on along its lead-in, until the tail is
    /// clear of the lane: files place stands at the nose, the middle or the jetty.
    fn clear_lanes(&mut self) {
        // Half a typical length and half the span on the lane, m, by code letter (assumed), and 9 m of margins.
        const NEEDED_M: [f64; 6] = [22.0, 36.0, 47.0, 60.0, 78.0, 88.0];
        // So that each that fits has its middle within 0.7 of its length of the place of the file, m.
        const MOST_MOVED_M: f64 = 44.0;
        let (mut moved, mut farthest) = (0, 0.0_f64);
        for s in 0..self.stands.len() {
            let Some(node) = self.stands[s].node else { continue };
            let on = |n: usize| -> Vec<usize> {
                (0..self.edges.len()).filter(|e| self.edges[*e].nodes.contains(&n)).collect()
            };
            let leads = on(node);
            let [mut edge] = leads[..] else { continue };
            let (mut at, mut length, mut next_to) = (node, 0.0, None);
            loop {
                let [a, b] = self.edges[edge].nodes;
                let other = if a == at { b } else { a };
                length += self.length_m(edge);
                next_to.get_or_insert(other);
                let beyond: Vec<usize> = on(other).into_iter().filter(|e| *e != edge).collect();
                if beyond.len() != 1 || length > 100.0 {
                    break;
                }
                (edge, at) = (beyond[0], other);
            }
            let code = if self.stands[s].code_known { self.stands[s].code.min(5) } else { 2 };
            let short = (NEEDED_M[usize::from(code)] - length).min(MOST_MOVED_M);
            let Some(from) = next_to.filter(|_| short > 0.5) else { continue };
            let ahead = self.nodes[node].at_m - self.nodes[from].at_m;
            if ahead.norm() < 0.1 {
                continue;
            }
            self.nodes[node].at_m += ahead / ahead.norm() * short;
            self.stands[s].moved_m = short;
            moved += 1;
            farthest = farthest.max(short);
        }
        self.report.push(format!(
            "R5: {moved} stands moved along their lead-in, up to {farthest:.0} m, so that tails are clear of the lane (assumed)"
        ));
    }

    /// R7: what can be reached from the busiest node and left to it, stands aside.
    fn parts(&mut self) {
        let count = self.nodes.len();
        let (mut out, mut into) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for edge in &self.edges {
            let [a, b] = edge.nodes;
            out[a].push(b);
            into[b].push(a);
            if edge.two_way {
                out[b].push(a);
                into[a].push(b);
            }
        }
        let passes = |n: usize| self.nodes[n].stand.is_none();
        let reached = |start: usize, next: &Vec<Vec<usize>>| {
            let mut seen = vec![false; count];
            let mut open = vec![start];
            seen[start] = true;
            while let Some(n) = open.pop() {
                for m in &next[n] {
                    if !std::mem::replace(&mut seen[*m], true) && passes(*m) {
                        open.push(*m);
                    }
                }
            }
            seen
        };
        let mut best: Vec<bool> = vec![false; count];
        let mut placed = vec![false; count];
        for start in 0..count {
            if placed[start] || !passes(start) || out[start].is_empty() {
                continue;
            }
            let (forth, back) = (reached(start, &out), reached(start, &into));
            let part: Vec<bool> = (0..count).map(|n| forth[n] && back[n] && passes(n)).collect();
            (0..count).filter(|n| part[*n]).for_each(|n| placed[n] = true);
            if part.iter().filter(|p| **p).count() > best.iter().filter(|p| **p).count() {
                best = part;
            }
        }
        let in_use: BTreeSet<usize> = self.edges.iter().flat_map(|e| e.nodes).collect();
        let mut lost = Vec::new();
        for n in 0..count {
            let stand_of_part = self.nodes[n].stand.is_some() && into[n].iter().any(|m| best[*m]);
            self.nodes[n].used = best[n] || stand_of_part;
            if !self.nodes[n].used && in_use.contains(&n) {
                lost.push(self.nodes[n].name.clone());
            }
        }
        self.report.push(format!(
            "R7: {} nodes in use, {} cannot be reached from and left to them",
            self.nodes.iter().filter(|n| n.used).count(),
            lost.len()
        ));
        if !lost.is_empty() {
            self.findings.push(format!("{} nodes out of use: {}", lost.len(), named(&lost)));
        }
    }

    fn find(&mut self) {
        for (r, runway) in self.runways.iter().enumerate() {
            let name = runway.names.join("/");
            let holds: Vec<usize> = (0..self.nodes.len())
                .filter(|n| self.nodes[*n].hold_for == Some(r) && self.nodes[*n].used)
                .collect();
            if holds.is_empty() {
                self.findings.push(format!("runway {name}: no entry or exit: no edge leads to it"));
            }
        }
        let unusable: Vec<String> = self
            .stands
            .iter()
            .filter(|s| s.node.is_some_and(|n| !self.nodes[n].used))
            .map(|s| s.name.clone())
            .collect();
        if !unusable.is_empty() {
            self.findings.push(format!(
                "{} stands cannot be reached: {}",
                unusable.len(),
                named(&unusable)
            ));
        }
        let mut near = Vec::new();
        for (i, a) in self.stands.iter().enumerate() {
            for b in &self.stands[i + 1..] {
                if (a.at_m - b.at_m).norm() < 20.0 {
                    near.push(format!("{} and {}", a.name, b.name));
                }
            }
        }
        if !near.is_empty() {
            self.findings.push(format!(
                "{} pairs of stands nearer than 20 m: {}",
                near.len(),
                named(&near)
            ));
        }
        let long = (0..self.edges.len())
            .filter(|e| self.edges[*e].runway.is_none() && !self.edges[*e].backtrack)
            .filter(|e| self.length_m(*e) > 500.0)
            .count();
        if long > 0 {
            self.findings.push(format!("{long} taxiway edges longer than 500 m"));
        }
    }
}

/// Shares of two segments at which they cross, both in [0, 1].
fn crossing(
    a: Vector2<f64>,
    b: Vector2<f64>,
    c: Vector2<f64>,
    d: Vector2<f64>,
) -> Option<(f64, f64)> {
    let (u, v, w) = (b - a, d - c, c - a);
    let area = u.x * v.y - u.y * v.x;
    if area.abs() < 1e-9 {
        return None;
    }
    let (s, t) = ((w.x * v.y - w.y * v.x) / area, (w.x * u.y - w.y * u.x) / area);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some((s, t))
}
