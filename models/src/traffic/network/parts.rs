//! R7 and findings: what of the network can be used.

use super::{Network, named};
use std::collections::BTreeSet;

impl Network {
    /// Out of and into each node, by the edges as they may be driven.
    fn ways_of_nodes(&self) -> [Vec<Vec<usize>>; 2] {
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
        [out, into]
    }

    /// The largest part whose nodes are all reached from and left to each other, stands aside.
    fn largest_part(&self) -> Vec<bool> {
        let count = self.nodes.len();
        let [out, into] = self.ways_of_nodes();
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
        best
    }

    /// R5, where stands lie on lanes: with what went on from them lanes lose the ways on, and who may drive them one way
    /// only is trapped. Each edge that led out of `before`'s part to such a trap, or back from it, becomes two-way.
    pub(super) fn free_lanes(&mut self, before: &Self) {
        let was = before.largest_part();
        // Nodes that were made since are of that part if the edges are on which they were made.
        let mut of_part = was.clone();
        of_part.resize(self.nodes.len(), true);
        let is_stand = |n: usize| self.nodes[n].stand.is_some();
        loop {
            let before = of_part.clone();
            for [a, b] in self.edges.iter().map(|e| e.nodes) {
                for (n, next) in [(a, b), (b, a)] {
                    of_part[n] &= n < was.len() || is_stand(next) || before[next];
                }
            }
            if of_part == before {
                break;
            }
        }
        let wanted = |net: &Self, n: usize| net.nodes[n].stand.is_none() && of_part[n];
        let mut freed = Vec::new();
        loop {
            let part = self.largest_part();
            let at_trap: Vec<usize> = (0..self.edges.len())
                .filter(|e| {
                    let edge = &self.edges[*e];
                    let [a, b] = edge.nodes;
                    !edge.two_way && part[a] != part[b] && wanted(self, a) && wanted(self, b)
                })
                .collect();
            if at_trap.is_empty() {
                break;
            }
            for e in at_trap {
                self.edges[e].two_way = true;
                let [a, b] = self.edges[e].nodes.map(|n| &self.nodes[n].name);
                freed.push(format!("{a}-{b}"));
            }
        }
        if !freed.is_empty() {
            self.findings.push(format!(
                "{} one-way edges lead to or from nothing but stands that end their lane, two-way now (assumed): {}",
                freed.len(),
                named(&freed)
            ));
        }
    }

    /// R7: what can be reached from the busiest node and left to it, stands aside.
    pub(super) fn parts(&mut self) {
        let count = self.nodes.len();
        let best = self.largest_part();
        let [_, into] = self.ways_of_nodes();
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

    pub(super) fn find(&mut self) {
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
