//! Directed edges of a network, and the quickest ways over them.

use super::network::Network;
use super::ways::SHARPEST_TURN_DEG;
use crate::frames::{Azimuth, wrap_pi};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Nobody turns farther onto a runway, rad (assumed).
const SHARPEST_ENTRY_RAD: f64 = 2.1;

/// Directed edges of a network, for searches: arc `2 e` runs from the first node of edge `e` to the second,
/// `2 e + 1` back.
#[derive(Clone, Debug, Default)]
pub struct Arcs {
    out: Vec<Vec<usize>>,
    /// By node: edges that it ends, in use or not, in their order.
    at_node: Vec<Vec<usize>>,
    heading_rad: Vec<f64>,
    length_m: Vec<f64>,
    /// By arc: what it counts in a search, s.
    cost_s: Vec<f64>,
    /// By arc: arcs that can be driven after it, and what the turn takes, s.
    onward: Vec<Vec<(usize, f64)>>,
}

/// A search's result: arcs in order and its time, s.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Arcs.
    pub arcs: Vec<usize>,
    /// Time by speeds and turns, s.
    pub time_s: f64,
}

const STRAIGHT_MPS: f64 = 10.0;
const QUARTER_TURN_S: f64 = 4.0;
const RUNWAY_FACTOR: f64 = 4.0;
/// Where others come the other way.
const OPPOSED_FACTOR: f64 = 3.0;

impl Arcs {
    /// All arcs of the part of the network that is in use.
    #[must_use]
    pub fn of(net: &Network) -> Self {
        let none = vec![Vec::new(); net.nodes.len()];
        let mut arcs = Self { out: none.clone(), at_node: none, ..Self::default() };
        for (index, edge) in net.edges.iter().enumerate() {
            let [a, b] = edge.nodes;
            let way = net.nodes[b].at_m - net.nodes[a].at_m;
            let heading = Azimuth::of(way).rad();
            arcs.heading_rad.extend([heading, wrap_pi(heading + std::f64::consts::PI)]);
            arcs.length_m.extend([way.norm(); 2]);
            let factor = if edge.runway.is_some() { RUNWAY_FACTOR } else { 1.0 };
            arcs.cost_s.extend([way.norm() / STRAIGHT_MPS * factor; 2]);
            arcs.at_node[a].push(index);
            if b != a {
                arcs.at_node[b].push(index);
            }
            if net.nodes[a].used && net.nodes[b].used {
                arcs.out[a].push(2 * index);
                if edge.two_way {
                    arcs.out[b].push(2 * index + 1);
                }
            }
        }
        arcs.onward = (0..arcs.length_m.len()).map(|a| arcs.drivable_after(net, a)).collect();
        arcs
    }

    fn drivable_after(&self, net: &Network, arc: usize) -> Vec<(usize, f64)> {
        let node = Self::to(net, arc);
        if net.nodes[node].stand.is_some() {
            return Vec::new();
        }
        let drivable = |next: &usize| {
            let turn = self.turn_rad(arc, *next);
            let slow_s = turn / std::f64::consts::FRAC_PI_2 * QUARTER_TURN_S;
            let sharp = turn > SHARPEST_TURN_DEG.to_radians();
            (next / 2 != arc / 2 && !sharp)
                .then_some((*next, if turn > 0.35 { slow_s } else { 0.0 }))
        };
        self.out[node].iter().filter_map(drivable).collect()
    }

    /// Node that an arc reaches.
    #[must_use]
    pub fn to(net: &Network, arc: usize) -> usize {
        net.edges[arc / 2].nodes[1 - arc % 2]
    }

    /// Node that an arc leaves.
    #[must_use]
    pub fn from(net: &Network, arc: usize) -> usize {
        net.edges[arc / 2].nodes[arc % 2]
    }

    /// Arcs that leave a node.
    #[must_use]
    pub fn leaving(&self, node: usize) -> &[usize] {
        &self.out[node]
    }

    /// Edges at a node, in their order, whether anybody uses them or not.
    #[must_use]
    pub fn edges_at(&self, node: usize) -> &[usize] {
        &self.at_node[node]
    }

    /// The same as arcs that leave it, whether they may be driven or not.
    pub fn away_from<'a>(
        &'a self,
        net: &'a Network,
        node: usize,
    ) -> impl Iterator<Item = usize> + 'a {
        let away = move |e: &usize| if net.edges[*e].nodes[0] == node { 2 * e } else { 2 * e + 1 };
        self.at_node[node].iter().map(away)
    }

    /// Direction of an arc, rad clockwise from north.
    #[must_use]
    pub fn heading_rad(&self, arc: usize) -> f64 {
        self.heading_rad[arc]
    }

    /// Length of an arc, m.
    #[must_use]
    pub fn length_m(&self, arc: usize) -> f64 {
        self.length_m[arc]
    }

    /// Runway ahead of where an arc comes onto it for a take-off from an end of it, m; none where it does not, or turns back.
    #[must_use]
    pub fn run_ahead_m(&self, net: &Network, (r, end): (usize, usize), arc: usize) -> Option<f64> {
        let (runway, edge) = (&net.runways[r], &net.edges[arc / 2]);
        if edge.strip != Some(r) || edge.runway.is_some() {
            return None;
        }
        let node = Self::to(net, arc);
        let place = runway.spine.iter().find(|(_, n)| *n == node)?.0;
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let turn = wrap_pi(direction - self.heading_rad(arc)).abs();
        (turn < SHARPEST_ENTRY_RAD).then_some(if end == 0 {
            runway.length_m - place
        } else {
            place
        })
    }

    /// The most of it ahead of any entry, m; 0 without one.
    #[must_use]
    pub fn longest_run_m(&self, net: &Network, end: (usize, usize)) -> f64 {
        let nodes = net.runways[end.0].spine.iter().map(|(_, n)| *n);
        let towards = nodes.flat_map(|n| self.away_from(net, n)).map(|a| a ^ 1);
        towards.filter_map(|arc| self.run_ahead_m(net, end, arc)).fold(0.0, f64::max)
    }

    /// Turn from one arc to the next, rad, not negative.
    #[must_use]
    pub fn turn_rad(&self, first: usize, next: usize) -> f64 {
        wrap_pi(self.heading_rad[next] - self.heading_rad[first]).abs()
    }

    /// The quickest way that begins with one of `starts` (arc, time before it) and ends with an arc that is a
    /// `goal`; edges with `closed` are not used, arcs with `slow` cost three times. Equal times: smaller arc
    /// numbers.
    #[must_use]
    pub fn quickest(
        &self,
        net: &Network,
        starts: &[(usize, f64)],
        goal: impl Fn(usize) -> bool,
        closed: impl Fn(usize) -> bool,
        slow: impl Fn(usize) -> bool,
    ) -> Option<Found> {
        let mut search = Search::new(self);
        let arc = search.run(self, net, starts, goal, closed, slow)?;
        Some(search.found(arc))
    }

    /// The same to the node of a stand, by a search for others of the same beginning that goes on where it stopped: `closed` and
    /// `slow` say what they said to it before.
    #[must_use]
    pub fn quickest_to(
        &self,
        net: &Network,
        search: &mut Search,
        start: usize,
        stand: usize,
        closed: impl Fn(usize) -> bool,
        slow: impl Fn(usize) -> bool,
    ) -> Option<Found> {
        let begun = search.least.iter().any(|l| l.is_finite());
        let starts: &[(usize, f64)] = if begun { &[] } else { &[(start, 0.0)] };
        let arc = search.reached[stand].or_else(|| {
            search.run(self, net, starts, |a| Self::to(net, a) == stand, closed, slow)
        })?;
        Some(search.found(arc))
    }
}

/// A search for quickest ways, as far as it has come.
#[derive(Clone, Debug)]
pub struct Search {
    least: Vec<f64>,
    before: Vec<usize>,
    open: BinaryHeap<Reverse<(u64, usize)>>,
    /// By node: the arc by which it was reached first.
    reached: Vec<Option<usize>>,
}

impl Search {
    /// One that has not begun.
    #[must_use]
    pub fn new(arcs: &Arcs) -> Self {
        let count = arcs.length_m.len();
        Self {
            least: vec![f64::INFINITY; count],
            before: vec![usize::MAX; count],
            open: BinaryHeap::new(),
            reached: vec![None; arcs.out.len()],
        }
    }

    /// Goes on to the first arc that is a goal. Nothing leads on from a stand, so one that ended there can go on to others.
    fn run(
        &mut self,
        arcs: &Arcs,
        net: &Network,
        starts: &[(usize, f64)],
        goal: impl Fn(usize) -> bool,
        closed: impl Fn(usize) -> bool,
        slow: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let Self { least, before, open, reached } = self;
        let cost = |arc: usize| arcs.cost_s[arc] * if slow(arc) { OPPOSED_FACTOR } else { 1.0 };
        for (arc, time_s) in starts {
            if !closed(arc / 2) && *time_s + cost(*arc) < least[*arc] {
                least[*arc] = *time_s + cost(*arc);
                open.push(Reverse((least[*arc].to_bits(), *arc)));
            }
        }
        while let Some(Reverse((bits, arc))) = open.pop() {
            if least[arc].to_bits() != bits {
                continue;
            }
            reached[Arcs::to(net, arc)].get_or_insert(arc);
            if goal(arc) {
                return Some(arc);
            }
            for (next, turn_s) in &arcs.onward[arc] {
                let there = f64::from_bits(bits) + cost(*next) + turn_s;
                if there < least[*next] && !closed(next / 2) {
                    least[*next] = there;
                    before[*next] = arc;
                    open.push(Reverse((there.to_bits(), *next)));
                }
            }
        }
        None
    }

    fn found(&self, arc: usize) -> Found {
        let mut arcs = vec![arc];
        let mut at = arc;
        while self.before[at] != usize::MAX {
            at = self.before[at];
            arcs.push(at);
        }
        arcs.reverse();
        Found { arcs, time_s: self.least[arc] }
    }
}
