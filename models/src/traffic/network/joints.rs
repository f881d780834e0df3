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

    /// R2.
    pub(super) fn crossings(&mut self) {
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
}
