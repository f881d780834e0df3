//! R1 and R2: nodes that are one, edges twice, edges that cross without a node.

use super::{JOINED_M, Network, crossing, named};

impl Network {
    /// R1.
    pub(super) fn clean(&mut self) {
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

    /// R2: edges that cross without a node, joined where they do or left as they are.
    pub(super) fn crossings(&mut self, mend: bool) {
        let mut found = Vec::new();
        let mut first = 0;
        // Where edges are cut more come, and are looked at as those of the file are.
        while first < self.edges.len() {
            let mut second = first + 1;
            while second < self.edges.len() {
                if let Some(places_m) = self.cross_m([first, second]) {
                    let name = |e: usize| {
                        self.edges[e].nodes.map(|n| self.nodes[n].name.as_str()).join("-")
                    };
                    found.push(format!("{} and {}", name(first), name(second)));
                    if mend {
                        let node = self.cut(first, places_m[0], format!("X_{}", found.len()));
                        self.cut_at(second, node);
                    }
                }
                second += 1;
            }
            first += 1;
        }
        let left = if mend { "joined there" } else { "left as they are" };
        self.report
            .push(format!("R2: {} pairs of edges cross without a node, {left}", found.len()));
        if !found.is_empty() {
            let what = if mend { "crossed without a node, joined" } else { "cross without a node" };
            self.findings.push(format!("{} pairs of edges {what}: {}", found.len(), named(&found)));
        }
    }

    /// Where two edges cross, off their ends and not along each other: places on each, m.
    fn cross_m(&self, edges: [usize; 2]) -> Option<[f64; 2]> {
        let [first, second] = edges.map(|e| &self.edges[e]);
        if first.nodes.iter().any(|n| second.nodes.contains(n)) {
            return None;
        }
        let ([a, b], [c, d]) = (self.ends(first), self.ends(second));
        if a.x.max(b.x) < c.x.min(d.x) || c.x.max(d.x) < a.x.min(b.x) {
            return None;
        }
        let (s, t) = crossing(a, b, c, d)?;
        let clear = |share: f64, length: f64| share * length > 5.0 && (1.0 - share) * length > 5.0;
        let (l, m) = ((b - a).norm(), (d - c).norm());
        let angle = ((b - a).dot(&(d - c)) / (l * m)).abs();
        let across = clear(s, l) && clear(t, m) && angle < libm::cos(15_f64.to_radians());
        across.then_some([s * l, t * m])
    }
}

#[cfg(test)]
mod tests {
    use super::Network;
    use crate::airport::{Airport, Edge, Hold, Node};
    use crate::frames::Point2;

    /// Two parallel taxiways over two others: four crossings, at which one turns off where they are mended.
    #[test]
    fn edges_that_cross_are_joined_where_somebody_says_so() {
        for turned in [0.0, 0.4, 2.0] {
            let (sin, cos) = libm::sincos(turned);
            let mut airport = Airport::default();
            let places = [
                [0.0, 100.0],
                [400.0, 100.0],
                [0.0, 200.0],
                [400.0, 200.0],
                [100.0, 0.0],
                [130.0, 300.0],
                [300.0, 0.0],
                [300.0, 300.0],
            ];
            for (n, [x, y]) in places.iter().enumerate() {
                let position_m = Point2::new(x * cos - y * sin, x * sin + y * cos);
                airport.nodes.push(Node { name: n.to_string(), position_m, hold: Hold::None });
            }
            for n in [0, 2, 4, 6] {
                let (name, width_m) = (String::new(), 23.0);
                let (from, to, two_way, runway) = (n, n + 1, n != 4, false);
                airport.edges.push(Edge { from, to, two_way, runway, name, width_m });
            }
            let left = Network::of(&airport);
            assert_eq!((left.nodes.len(), left.edges.len()), (8, 4), "{turned}");
            assert!(left.findings.iter().any(|f| f.starts_with("4 pairs of edges cross")));
            airport.details.mend_crossings = true;
            let net = Network::of(&airport);
            assert_eq!((net.nodes.len(), net.edges.len()), (12, 12), "{turned}");
            for n in 8..12 {
                let at = net.edges.iter().filter(|e| e.nodes.contains(&n)).count();
                assert_eq!(at, 4, "{turned}: node {n}");
            }
            let one_way = net.edges.iter().filter(|e| !e.two_way).count();
            assert_eq!(one_way, 3, "{turned}: parts of a one-way edge are driven as it is");
            assert!(net.nodes[8..].iter().all(|n| n.used), "{turned}");
        }
    }
}
