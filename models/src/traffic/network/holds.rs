//! R4: where aircraft hold before a runway.

use super::{NetEdge, NetRunway, Network, named};
use crate::airport::Airport;
use crate::frames::Point2;
use std::collections::BTreeSet;

/// Between the edge of a runway and the nearest place where one holds, m.
const OFF_EDGE_M: f64 = 15.0;

/// The strip of a runway goes on behind its ends for so long, m.
const BEYOND_END_M: f64 = 60.0;

impl NetRunway {
    /// Whether a place lies in the strip behind an end, not beside the runway.
    fn has_behind_end(&self, at_m: Point2<f64>) -> bool {
        let (place_m, across_m) = self.place_m(at_m);
        let behind_m = (-place_m).max(place_m - self.length_m);
        (0.0..BEYOND_END_M).contains(&behind_m) && across_m.abs() < self.hold_distance_m
    }
}

impl Network {
    /// A node of every taxiway that crosses the axis of a runway in its strip behind an end, where no runway is: who goes there is in
    /// the way of who lands over it. Cut where none is there.
    fn behind_ends(&mut self, runway: &NetRunway) -> Vec<usize> {
        let mut found = BTreeSet::new();
        for e in 0..self.edges.len() {
            let edge = &self.edges[e];
            let stands = edge.nodes.iter().any(|n| self.nodes[*n].stand.is_some());
            if edge.runway.is_some() || edge.strip.is_some() || stands {
                continue;
            }
            let [a, b] = self.ends(edge);
            let [across_a, across_b] = [a, b].map(|p| runway.place_m(p).1);
            if across_a * across_b > 0.0 || across_a == across_b {
                continue;
            }
            let share = across_a / (across_a - across_b);
            if !runway.has_behind_end(a + (b - a) * share) {
                continue;
            }
            let nodes = edge.nodes;
            let near = [a, b].map(|p| runway.has_behind_end(p));
            let node = match near {
                [true, true] => nodes[usize::from(across_b.abs() < across_a.abs())],
                [true, false] => nodes[0],
                [false, true] => nodes[1],
                [false, false] => {
                    let name = format!("behind_{}_{}", runway.names.join("_"), self.nodes.len());
                    self.cut(e, share * (b - a).norm(), name)
                }
            };
            if self.nodes[node].runway.is_none() {
                found.insert(node);
            }
        }
        found.into_iter().collect()
    }

    /// R4.
    pub(super) fn holds(&mut self, airport: &Airport) {
        for r in 0..self.runways.len() {
            let (mut of_file, mut of_zone, mut made) = (0, 0, 0);
            let runway = self.runways[r].clone();
            let mut open: Vec<usize> = runway.spine.iter().map(|(_, n)| *n).collect();
            let behind = self.behind_ends(&runway);
            open.extend(&behind);
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
                    let behind_end = runway.has_behind_end(self.nodes[next].at_m)
                        && !other_runway
                        && self.nodes[next].stand.is_none();
                    let place = if far >= wanted {
                        // The distance grows evenly along a straight edge off the runway.
                        Some(length * ((wanted - near) / (far - near)).clamp(0.0, 1.0))
                    } else if !behind_end
                        && (degree != 1
                            || other_runway
                            || self.nodes[next].stand.is_some()
                            || (flat && near > 30.0))
                    {
                        // A junction nearer than that: hold short of it, as far from the runway as there is room.
                        let place = (length - 25.0).max(0.5 * length);
                        let hold_m = near + (far - near) * place / length;
                        // Nobody holds on the pavement of the runway: beyond the junction then.
                        let no_room = hold_m < 0.5 * runway.width_m + OFF_EDGE_M;
                        let ends = degree == 1 || other_runway || self.nodes[next].stand.is_some();
                        (!no_room || ends).then_some(place)
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
            if !behind.is_empty() {
                self.report.push(format!(
                    "R4: runway {name}: {} pass within {BEYOND_END_M} m behind an end: crossed with a clearance",
                    if behind.len() == 1 { "1 taxiway".into() } else { format!("{} taxiways", behind.len()) }
                ));
            }
        }
        let mut unused = Vec::new();
        for node in &mut self.nodes {
            if node.hold_for == Some(usize::MAX) {
                node.hold_for = None;
                unused.push(node.name.clone());
            }
        }
        if !unused.is_empty() {
            self.report.push(format!(
                "R4: {} holding positions of the file are not the first on a way off a runway, not used: {}",
                unused.len(),
                named(&unused)
            ));
        }
    }
}
