//! R5: ways to stands, and room for the tails on them.

use super::{JOINED_M, NetEdge, Network, named};
use crate::frames::Vector2;

/// Stands farther from every edge than this have no way, m.
const STAND_REACH_M: f64 = 150.0;
/// A stand so near to a line lies on it, m.
const ON_EDGE_M: f64 = 3.0;

impl Network {
    /// R5.
    pub(super) fn lead_ins(&mut self) {
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
                if !self.is_taxiway(edge) {
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

    /// Whether an edge is a taxiway or a lane: off the strips of runways, and no lead-in to a stand.
    #[must_use]
    pub fn is_taxiway(&self, edge: &NetEdge) -> bool {
        let lead_in = edge.nodes.iter().any(|n| self.nodes[*n].stand.is_some());
        edge.strip.is_none() && edge.runway.is_none() && !lead_in
    }

    /// A stand on an edge that leads through it, the way it heads: the part behind it is its lead-in, what goes on from it is
    /// cut off, since a way never leads over a stand. The names of the ends of that edge.
    fn end_at_stand(&mut self, s: usize, ahead: Vector2<f64>) -> Option<(String, String)> {
        let at_m = self.stands[s].at_m;
        let mut best: Option<(f64, usize, f64)> = None;
        for (e, edge) in self.edges.iter().enumerate() {
            if !self.is_taxiway(edge) {
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
    pub(super) fn clear_lanes(&mut self) {
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
}

#[cfg(test)]
mod tests {
    use super::Network;
    use crate::airport::{Airport, Edge, Hold, Node, Stand};
    use crate::frames::Point2;

    /// A lane into a row of drive-through stands and a lane out of it, both one-way, that meet over the last stand only
    /// (Bratislava): where the stands end their edges the lanes stay ways in and out, and each stand is in use.
    #[test]
    fn lanes_that_meet_over_a_stand_alone_are_ways_to_all_its_neighbours() {
        for turned in [0.0, 0.6, 2.5] {
            let turn = |x: f64, y: f64| {
                let (sin, cos) = libm::sincos(turned);
                Point2::new(x * cos - y * sin, x * sin + y * cos)
            };
            let mut airport = Airport::default();
            // A two-way ring, its corner 0 at the lanes.
            let mut places = vec![(0.0, 0.0), (-300.0, 0.0), (-300.0, -300.0), (0.0, -300.0)];
            places.extend((0..4).map(|i| (60.0 + 40.0 * f64::from(i), 0.0)));
            places.extend((0..4).map(|i| (60.0 + 40.0 * f64::from(i), 70.0)));
            for (n, (x, y)) in places.iter().enumerate() {
                let (name, position_m) = (n.to_string(), turn(*x, *y));
                airport.nodes.push(Node { name, position_m, hold: Hold::None });
            }
            let mut edge = |from: usize, to: usize, two_way: bool| {
                airport.edges.push(Edge {
                    from,
                    to,
                    two_way,
                    runway: false,
                    name: String::new(),
                    width_m: 15.0,
                });
            };
            (0..4).for_each(|n| edge(n, (n + 1) % 4, true));
            for (from, to) in [(0, 4), (4, 5), (5, 6), (6, 7), (7, 11), (11, 10), (10, 9), (9, 8)] {
                edge(from, to, false);
            }
            edge(8, 0, false);
            (0..3).for_each(|i| edge(4 + i, 8 + i, true));
            for i in 0..4 {
                let position_m = turn(60.0 + 40.0 * i as f64, 40.0);
                // Heading, clockwise from north, of the axis from the lane in to the lane out.
                let heading_rad = -turned;
                airport.stands.push(Stand {
                    name: format!("S{i}"),
                    position_m,
                    heading_rad,
                    node: None,
                });
            }
            let net = Network::of(&airport);
            let unused: Vec<&str> =
                net.nodes.iter().filter(|n| !n.used).map(|n| n.name.as_str()).collect();
            assert!(unused.is_empty(), "{turned}: {unused:?}, {:?}", net.findings);
            assert_eq!(net.stands.iter().filter(|s| s.node.is_some()).count(), 4, "{turned}");
            // Only what led to and from the stands was opened.
            let one_way = net.edges.iter().filter(|e| !e.two_way).count();
            assert_eq!(one_way, 0, "{turned}");
            assert!(net.findings.iter().any(|f| f.contains("two-way now")), "{turned}");
        }
    }

    /// A trap of the file itself is not ours to free: it is reported (R7).
    #[test]
    fn a_trap_of_the_file_stays_one() {
        let mut airport = Airport::default();
        for (n, (x, y)) in
            [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (300.0, 0.0)].iter().enumerate()
        {
            let position_m = Point2::new(*x, *y);
            airport.nodes.push(Node { name: n.to_string(), position_m, hold: Hold::None });
        }
        for (from, to, two_way) in [(0, 1, true), (1, 2, true), (2, 0, true), (1, 3, false)] {
            let (runway, name, width_m) = (false, String::new(), 15.0);
            airport.edges.push(Edge { from, to, two_way, runway, name, width_m });
        }
        let net = Network::of(&airport);
        assert!(!net.nodes[3].used && net.nodes[..3].iter().all(|n| n.used));
        assert!(net.edges.iter().any(|e| !e.two_way));
        // Also with a stand beside it, whose lead-in cuts it.
        for x in [150.0, 200.0, 250.0] {
            let (name, position_m) = (format!("S{x}"), Point2::new(x, -40.0));
            let heading_rad = std::f64::consts::PI;
            airport.stands.push(Stand { name, position_m, heading_rad, node: None });
        }
        let net = Network::of(&airport);
        assert_eq!(net.edges.iter().filter(|e| !e.two_way).count(), 4);
        assert!(net.nodes[4..].iter().all(|n| !n.used), "{:?}", net.nodes);
    }
}
