//! Ways along a ground network: by length, by turn time, and the next shortest ones.
//!
//! A stand is only ever the begin or the end of a way. Source: Dijkstra, Numer. Math. 1 (1959) 269, over
//! nodes or, where turns cost, over arcs; Yen, Management Science 17 (1971) 712, for the next shortest.

use crate::airport::Airport;
use crate::frames::Point2;
use std::collections::BTreeSet;

/// A directed arc; a two-way edge makes two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Node it leaves.
    pub from: usize,
    /// Node it reaches.
    pub to: usize,
    /// Length, m.
    pub length_m: f64,
    /// Lies on a runway.
    pub runway: bool,
    /// Index of its edge in [`Airport::edges`].
    pub edge: usize,
}

/// A ground network for searches.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    positions_m: Vec<Point2<f64>>,
    /// Nodes that may not be passed through.
    ends_only: Vec<bool>,
    arcs: Vec<Arc>,
    out: Vec<Vec<usize>>,
}

/// A way: its arcs in order and what it costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Indices into [`Graph::arcs`].
    pub arcs: Vec<usize>,
    /// Nodes from begin to end.
    pub nodes: Vec<usize>,
    /// In the unit of the search.
    pub cost: f64,
}

/// Turns sharper than this are not driven, degrees.
pub const SHARPEST_TURN_DEG: f64 = 120.0;
/// Runway edges count so many times their length.
pub const RUNWAY_COST: f64 = 4.0;

/// What a search by turn time counts with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnTime {
    /// Speed on straights, m/s.
    pub speed_mps: f64,
    /// Seconds a quarter turn.
    pub quarter_turn_s: f64,
    /// Turns up to this cost nothing, degrees.
    pub free_deg: f64,
}

impl Default for TurnTime {
    fn default() -> Self {
        Self { speed_mps: 10.0, quarter_turn_s: 4.0, free_deg: 20.0 }
    }
}

impl Graph {
    /// The network of an airport; edges to nodes that are not there are left out.
    #[must_use]
    pub fn of(airport: &Airport) -> Self {
        let count = airport.nodes.len();
        let mut ends_only = vec![false; count];
        airport.stands.iter().filter_map(|s| s.node).for_each(|n| ends_only[n] = true);
        let positions_m: Vec<_> = airport.nodes.iter().map(|n| n.position_m).collect();
        let mut graph = Self { positions_m, ends_only, arcs: Vec::new(), out: vec![vec![]; count] };
        for (index, edge) in airport.edges.iter().enumerate() {
            if edge.from < count && edge.to < count {
                graph.add(edge.from, edge.to, edge.runway, index);
                if edge.two_way {
                    graph.add(edge.to, edge.from, edge.runway, index);
                }
            }
        }
        graph
    }

    fn add(&mut self, from: usize, to: usize, runway: bool, edge: usize) {
        let length_m = (self.positions_m[to] - self.positions_m[from]).norm();
        self.out[from].push(self.arcs.len());
        self.arcs.push(Arc { from, to, length_m, runway, edge });
    }

    /// All arcs.
    #[must_use]
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// Arcs that leave a node.
    #[must_use]
    pub fn leaving(&self, node: usize) -> &[usize] {
        self.out.get(node).map_or(&[], Vec::as_slice)
    }

    /// Plain length of an arc.
    #[must_use]
    pub fn length(arc: &Arc) -> f64 {
        arc.length_m
    }

    /// Length, four times on runways.
    #[must_use]
    pub fn runway_cost(arc: &Arc) -> f64 {
        arc.length_m * if arc.runway { RUNWAY_COST } else { 1.0 }
    }

    /// The cheapest way from node to node, or `None`. Of equally cheap ways the one over nodes with smaller
    /// indices is taken, whatever the order of the edges.
    #[must_use]
    pub fn cheapest(&self, from: usize, to: usize, cost: impl Fn(&Arc) -> f64) -> Option<Way> {
        self.cheapest_without(from, to, &cost, &[], &BTreeSet::new())
    }

    fn cheapest_without(
        &self,
        from: usize,
        to: usize,
        cost: &impl Fn(&Arc) -> f64,
        closed_nodes: &[usize],
        closed_arcs: &BTreeSet<usize>,
    ) -> Option<Way> {
        let count = self.positions_m.len();
        let mut least = vec![f64::INFINITY; count];
        let mut before: Vec<Option<usize>> = vec![None; count];
        // Costs are not negative, so their bits are in the order of their values.
        let mut open = BTreeSet::new();
        *least.get_mut(from)? = 0.0;
        open.insert((0_u64, from));
        while let Some((bits, node)) = open.pop_first() {
            if node == to {
                break;
            }
            if node != from && self.ends_only[node] {
                continue;
            }
            for index in &self.out[node] {
                let arc = &self.arcs[*index];
                if closed_nodes.contains(&arc.to) || closed_arcs.contains(index) {
                    continue;
                }
                let there = f64::from_bits(bits) + cost(arc);
                if there < least[arc.to] {
                    open.remove(&(least[arc.to].to_bits(), arc.to));
                    least[arc.to] = there;
                    before[arc.to] = Some(*index);
                    open.insert((there.to_bits(), arc.to));
                }
            }
        }
        let total = least.get(to).copied().filter(|c| c.is_finite())?;
        let mut arcs = Vec::new();
        let mut at = to;
        while at != from {
            let index = before[at]?;
            arcs.push(index);
            at = self.arcs[index].from;
        }
        arcs.reverse();
        Some(self.way(from, arcs, total))
    }

    fn way(&self, from: usize, arcs: Vec<usize>, cost: f64) -> Way {
        let nodes = std::iter::once(from).chain(arcs.iter().map(|a| self.arcs[*a].to)).collect();
        Way { arcs, nodes, cost }
    }

    /// Turn from one arc to the next, degrees, 0 straight on.
    #[must_use]
    pub fn turn_deg(&self, first: usize, second: usize) -> f64 {
        let along = |index: usize| {
            let arc = &self.arcs[index];
            self.positions_m[arc.to] - self.positions_m[arc.from]
        };
        let (a, b) = (along(first), along(second));
        libm::atan2(a.x * b.y - a.y * b.x, a.dot(&b)).abs().to_degrees()
    }

    /// The quickest way, s, when turns cost time, sharp ones are not driven and nobody turns back on an
    /// edge; `None` if there is none. Searched over arcs, because what a turn costs depends on the arc
    /// before.
    #[must_use]
    pub fn quickest(&self, from: usize, to: usize, rule: &TurnTime) -> Option<Way> {
        let mut least = vec![f64::INFINITY; self.arcs.len()];
        let mut before: Vec<Option<usize>> = vec![None; self.arcs.len()];
        let mut open = BTreeSet::new();
        if from == to {
            return (from < self.positions_m.len()).then(|| self.way(from, Vec::new(), 0.0));
        }
        for index in self.leaving(from) {
            least[*index] = self.arcs[*index].length_m / rule.speed_mps;
            open.insert((least[*index].to_bits(), *index));
        }
        while let Some((bits, index)) = open.pop_first() {
            let arc = self.arcs[index];
            if arc.to == to {
                let mut arcs = vec![index];
                while let Some(previous) = before[arcs[arcs.len() - 1]] {
                    arcs.push(previous);
                }
                arcs.reverse();
                return Some(self.way(from, arcs, f64::from_bits(bits)));
            }
            if self.ends_only[arc.to] {
                continue;
            }
            for next in &self.out[arc.to] {
                let turn_deg = self.turn_deg(index, *next);
                if turn_deg > SHARPEST_TURN_DEG || self.arcs[*next].to == arc.from {
                    continue;
                }
                let turn_s = if turn_deg > rule.free_deg {
                    turn_deg / 90.0 * rule.quarter_turn_s
                } else {
                    0.0
                };
                let step_s = self.arcs[*next].length_m / rule.speed_mps + turn_s;
                let there = f64::from_bits(bits) + step_s;
                if there < least[*next] {
                    open.remove(&(least[*next].to_bits(), *next));
                    least[*next] = there;
                    before[*next] = Some(index);
                    open.insert((there.to_bits(), *next));
                }
            }
        }
        None
    }

    /// Up to `count` shortest ways that visit no node twice, shortest first.
    #[must_use]
    pub fn shortest_ways(&self, from: usize, to: usize, count: usize) -> Vec<Way> {
        let length = Self::length;
        let mut found: Vec<Way> = self.cheapest(from, to, length).into_iter().collect();
        let mut candidates: Vec<Way> = Vec::new();
        while !found.is_empty() && found.len() < count {
            let last = found[found.len() - 1].clone();
            for spur in 0..last.arcs.len() {
                let root = &last.arcs[..spur];
                let same_root = found.iter().filter(|w| w.arcs.starts_with(root));
                let closed: BTreeSet<usize> = same_root
                    .filter_map(|w| w.arcs.get(spur))
                    .flat_map(|a| self.twins(*a))
                    .collect();
                let (behind, at) = (&last.nodes[..spur], last.nodes[spur]);
                let Some(rest) = self.cheapest_without(at, to, &length, behind, &closed) else {
                    continue;
                };
                let arcs: Vec<usize> = root.iter().copied().chain(rest.arcs).collect();
                let cost = arcs.iter().map(|a| self.arcs[*a].length_m).sum();
                let way = self.way(from, arcs, cost);
                let known = |w: &Way| w.nodes == way.nodes;
                if !(candidates.iter().any(known) || found.iter().any(known)) {
                    candidates.push(way);
                }
            }
            let best = candidates.iter().enumerate().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
            let Some(best) = best.map(|(index, _)| index) else { break };
            found.push(candidates.swap_remove(best));
        }
        found
    }

    /// All arcs with the nodes of this one.
    fn twins(&self, arc: usize) -> Vec<usize> {
        let Arc { from, to, .. } = self.arcs[arc];
        self.out[from].iter().copied().filter(|a| self.arcs[*a].to == to).collect()
    }
}
