//! R3: the centreline of a runway as a row of nodes.

use super::{JOINED_M, NetEdge, Network, crossing};
use std::collections::BTreeSet;

/// A node of one runway so near to where another one crosses it is that of the crossing, m (assumed): an edge of the file to it along the
/// other one is none beside it.
const SHARED_M: f64 = 2.0;
/// Across for along of an edge that lies along a runway at most.
const ALONG: f64 = 0.1;

impl Network {
    /// R3.
    pub(super) fn spines(&mut self) {
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
                        .filter(|(p, _)| (p - on_other).abs() < SHARED_M)
                        .min_by(|a, b| (a.0 - on_other).abs().total_cmp(&(b.0 - on_other).abs()))
                        .map(|(_, node)| *node);
                    let name = format!("{}x{}", runway.names[0], self.runways[other].names[0]);
                    let node = match near {
                        Some(node) => node,
                        None => self.add_node(name, runway.at(place)),
                    };
                    // On both centrelines: beside one of them it would be a bend in a roll.
                    self.nodes[node].at_m = runway.at(place);
                    self.nodes[node].runway = Some(other);
                    spine.push((place, node));
                    self.runways[other].spine.retain(|(_, n)| *n != node);
                    self.runways[other].spine.push((on_other, node));
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
            let crosses: Vec<usize> = (0..self.runways.len())
                .filter(|o| *o != r)
                .flat_map(|o| self.runways[o].spine.iter().map(|(_, n)| *n))
                .collect();
            spine.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            // Places nearer than a metre are one.
            let mut kept: Vec<(f64, usize)> = Vec::new();
            for (place, node) in spine {
                match kept.last_mut() {
                    Some((p, known)) if place - *p < JOINED_M => {
                        let known = *known;
                        // Where runways cross they go on crossing.
                        if crosses.contains(&node) {
                            self.nodes[known].at_m = self.nodes[node].at_m;
                            *p = place;
                        }
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
            // Also what the file has along the centreline to a node of a runway that crosses it: not on this one, but on its pavement.
            let (runway, nodes) = (&self.runways[r], &self.nodes);
            let paved = |n: &usize| {
                let (place, off) = runway.place_m(nodes[*n].at_m);
                let within = (-1.0..=runway.length_m + 1.0).contains(&place);
                nodes[*n].runway.is_some() && within && off.abs() <= 0.5 * runway.width_m + 1.0
            };
            let along = |e: &NetEdge| {
                let [a, b] = e.nodes.map(|n| runway.place_m(nodes[n].at_m));
                (b.1 - a.1).abs() <= ALONG * (b.0 - a.0).abs()
            };
            self.edges.retain(|e| {
                let replaced = e.nodes.iter().all(|n| on.contains(n));
                let beside = e.runway.is_none() && e.nodes.iter().all(paved) && along(e);
                !replaced && !beside
            });
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airport::{Airport, Edge, Hold, Node, Runway};
    use crate::frames::Point2;
    use crate::frames::Vector2;

    /// Two runways that cross, each with taxiways over it, one of which comes to the crossing within a metre: as at Bradley, Punta
    /// Arenas and New Bedford, where landings were to brake for a bend that was none, and no arrival found a way.
    #[test]
    fn centrelines_are_straight_also_where_runways_cross() {
        let offsets = [(0.0, 0.0), (0.7, 0.3), (-0.6, 0.5), (0.4, -0.8), (3.0, 2.0), (-0.2, 8.0)];
        for (dx, dy) in offsets {
            for angle_deg in [40.0_f64, 75.0, 90.0, 130.0] {
                let (sin, cos) = libm::sincos(angle_deg.to_radians());
                let along = Vector2::new(cos, sin);
                let at = Point2::new(1200.0, 0.0);
                let ends = [
                    [Point2::new(0.0, 0.0), Point2::new(2500.0, 0.0)],
                    [at - along * 700.0, at + along * 900.0],
                ];
                let runway = |names: [&str; 2], ends_m| Runway {
                    names: names.map(String::from),
                    ends_m,
                    thresholds_m: ends_m,
                    width_m: 45.0,
                };
                let mut airport = Airport::default();
                airport.runways.push(runway(["09", "27"], ends[0]));
                airport.runways.push(runway(["01", "19"], ends[1]));
                let places = [
                    at + Vector2::new(dx, dy),
                    at + Vector2::new(150.0, 260.0),
                    at + along * 400.0 + Vector2::new(1.0, 0.5),
                    Point2::new(600.0, -4.0),
                    Point2::new(600.0, 300.0),
                ];
                for (k, position_m) in places.into_iter().enumerate() {
                    let name = format!("n{k}");
                    airport.nodes.push(Node { name, position_m, hold: Hold::None });
                }
                for (from, to) in [(0, 1), (1, 2), (1, 4), (3, 4)] {
                    let name = "T".into();
                    let edge = Edge { from, to, two_way: true, runway: false, name, width_m: 23.0 };
                    airport.edges.push(edge);
                }
                let network = Network::of(&airport);
                let spines = network.runways.iter().map(|r| &r.spine);
                let all: Vec<BTreeSet<usize>> =
                    spines.map(|s| s.iter().map(|(_, n)| *n).collect()).collect();
                assert!(all[0].intersection(&all[1]).count() == 1, "{dx} {dy} {angle_deg}");
                for runway in &network.runways {
                    for (place, node) in &runway.spine {
                        let off_m = (network.nodes[*node].at_m - runway.at(*place)).norm();
                        assert!(off_m < 1e-6, "{dx} {dy} {angle_deg}: {off_m} m at {place}");
                    }
                }
            }
        }
    }
}
