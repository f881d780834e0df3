//! R4: where aircraft hold before a runway.

use super::{NetEdge, Network, named};
use crate::airport::Airport;
use std::collections::BTreeSet;

impl Network {
    /// R4.
    pub(super) fn holds(&mut self, airport: &Airport) {
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
