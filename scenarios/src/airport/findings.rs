//! What a look at a whole layout finds: parts of the network that cannot be reached, edges that are
//! too long, stands beside the network, runways that cross or are called wrongly.

use models::airport::Airport;
use models::frames::{Azimuth, Point2};

/// Edges longer than this are worth a look, m.
const LONG_EDGE_M: f64 = 500.0;
/// Nodes nearer to each other than this are one, m.
const ONE_PLACE_M: f64 = 0.5;
/// Farther from the reference point than this nothing belongs to an airport, m.
const FAR_M: f64 = 20_000.0;
/// So many names are given, the rest is counted.
const NAMED: usize = 5;

/// Findings, one line each.
pub(super) fn of(airport: &Airport) -> Vec<String> {
    let mut lines = Vec::new();
    runways(airport, &mut lines);
    network(airport, &mut lines);
    stands(airport, &mut lines);
    lines
}

/// "a, b, c and 4 more".
fn named(names: &[String]) -> String {
    let shown = names[..names.len().min(NAMED)].join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn runways(airport: &Airport, lines: &mut Vec<String>) {
    if airport.runways.is_empty() {
        lines.push("no runways in this file".into());
    }
    for (index, runway) in airport.runways.iter().enumerate() {
        let name = runway.names.join("/");
        let way = runway.ends_m[1] - runway.ends_m[0];
        let length_m = way.norm();
        if !(300.0..=6500.0).contains(&length_m) {
            lines.push(format!("runway {name}: {length_m:.0} m long"));
        }
        let usable_m = (runway.thresholds_m[1] - runway.thresholds_m[0]).dot(&way) / length_m;
        if usable_m < 0.25 * length_m {
            lines.push(format!("runway {name}: thresholds displaced by most of its length"));
        }
        for (end, designator) in runway.names.iter().enumerate() {
            let digits: String = designator.chars().take_while(char::is_ascii_digit).collect();
            let called = digits.parse().ok().filter(|n: &f64| (1.0..=36.0).contains(n));
            let Some(called) = called else {
                lines.push(format!("runway {name}: {designator:?} is not a valid designator"));
                continue;
            };
            let along = if end == 0 { way } else { -way };
            let heading_deg = Azimuth::of(along).rad().to_degrees();
            let off_deg = (heading_deg - 10.0 * called + 540.0).rem_euclid(360.0) - 180.0;
            // Designators are magnetic and rounded.
            if off_deg.abs() > 35.0 {
                let heading_deg = heading_deg.rem_euclid(360.0);
                lines.push(format!("runway {name}: end {designator} lies at {heading_deg:.0} deg"));
            }
        }
        for other in &airport.runways[index + 1..] {
            if cross(runway.ends_m, other.ends_m) {
                lines.push(format!("runways {name} and {} cross", other.names.join("/")));
            }
        }
    }
}

fn cross(a: [Point2<f64>; 2], b: [Point2<f64>; 2]) -> bool {
    let side = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| {
        (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x)
    };
    side(a[0], a[1], b[0]) * side(a[0], a[1], b[1]) < 0.0
        && side(b[0], b[1], a[0]) * side(b[0], b[1], a[1]) < 0.0
}

/// A layout without a network of its own.
pub(crate) const NO_NETWORK: &str = "no taxi network in this file: no routes";

fn network(airport: &Airport, lines: &mut Vec<String>) {
    let nodes = &airport.nodes;
    if airport.edges.is_empty() {
        lines.push(NO_NETWORK.into());
        return;
    }
    let name = |i: usize| nodes[i].name.clone();
    let length_m = |from: usize, to: usize| (nodes[to].position_m - nodes[from].position_m).norm();
    let long = airport.edges.iter().map(|e| (length_m(e.from, e.to), e));
    let long: Vec<String> = long
        .filter(|(length_m, _)| *length_m > LONG_EDGE_M)
        .map(|(length_m, e)| format!("{}-{} ({length_m:.0} m)", name(e.from), name(e.to)))
        .collect();
    if !long.is_empty() {
        lines.push(format!("{} edges longer than 500 m: {}", long.len(), named(&long)));
    }
    let far = (0..nodes.len()).filter(|i| nodes[*i].position_m.coords.norm() > FAR_M);
    let far: Vec<String> = far.map(name).collect();
    if !far.is_empty() {
        lines.push(format!("{} nodes more than 20 km away: {}", far.len(), named(&far)));
    }
    // In the order of the east coordinate, so that only neighbours have to be looked at.
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by(|a, b| nodes[*a].position_m.x.total_cmp(&nodes[*b].position_m.x));
    let mut twins = Vec::new();
    for (k, i) in order.iter().enumerate() {
        let near = order[k + 1..]
            .iter()
            .take_while(|j| nodes[**j].position_m.x - nodes[*i].position_m.x < ONE_PLACE_M);
        let twin = near.filter(|j| length_m(*i, **j) < ONE_PLACE_M);
        twins.extend(twin.map(|j| format!("{} and {}", name(*i), name(*j))));
    }
    if !twins.is_empty() {
        lines.push(format!("{} pairs of nodes at one place: {}", twins.len(), named(&twins)));
    }
    connections(airport, lines);
}

/// Parts of the network, and one-way streets that lead nowhere.
fn connections(airport: &Airport, lines: &mut Vec<String>) {
    let count = airport.nodes.len();
    let mut out: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut into: Vec<Vec<usize>> = vec![Vec::new(); count];
    for edge in &airport.edges {
        out[edge.from].push(edge.to);
        into[edge.to].push(edge.from);
        if edge.two_way {
            out[edge.to].push(edge.from);
            into[edge.from].push(edge.to);
        }
    }
    let mut placed = vec![false; count];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for start in 0..count {
        if placed[start] {
            continue;
        }
        let found = reached(start, |i| out[i].iter().chain(&into[i]).copied().collect(), count);
        found.iter().for_each(|i| placed[*i] = true);
        parts.push(found);
    }
    parts.sort_by_key(|part| (std::cmp::Reverse(part.len()), part[0]));
    if parts.len() > 1 {
        let first =
            |part: &Vec<usize>| format!("{} ({} nodes)", airport.nodes[part[0]].name, part.len());
        let others: Vec<String> = parts[1..].iter().map(first).collect();
        lines.push(format!(
            "{} parts of the network without connection: {} nodes, and those of {}",
            parts.len(),
            parts[0].len(),
            named(&others)
        ));
    }
    // From the node of the main part with the most edges: the middle of the airport.
    let Some(hub) = parts[0].iter().max_by_key(|i| (out[**i].len() + into[**i].len(), **i)) else {
        return;
    };
    let forth = reached(*hub, |i| out[i].clone(), count);
    let back = reached(*hub, |i| into[i].clone(), count);
    for (what, found) in [("cannot be reached", &forth), ("cannot be left", &back)] {
        let mut there = vec![false; count];
        found.iter().for_each(|i| there[*i] = true);
        let missing = parts[0].iter().filter(|i| !there[**i]);
        let missing: Vec<String> = missing.map(|i| airport.nodes[*i].name.clone()).collect();
        if !missing.is_empty() {
            lines.push(format!(
                "{} nodes of the main part {what} from its busiest node {} because of one-way edges: {}",
                missing.len(),
                airport.nodes[*hub].name,
                named(&missing)
            ));
        }
    }
}

/// All nodes that are reached from one, in the order of their indices.
fn reached(start: usize, next: impl Fn(usize) -> Vec<usize>, count: usize) -> Vec<usize> {
    let mut seen = vec![false; count];
    seen[start] = true;
    let mut open = vec![start];
    while let Some(i) = open.pop() {
        for j in next(i) {
            if !std::mem::replace(&mut seen[j], true) {
                open.push(j);
            }
        }
    }
    (0..count).filter(|i| seen[*i]).collect()
}

fn stands(airport: &Airport, lines: &mut Vec<String>) {
    if airport.stands.is_empty() {
        lines.push("no stands in this file".into());
    }
    let off = airport.stands.iter().filter(|s| s.node.is_none());
    let off: Vec<String> = off.map(|s| s.name.clone()).collect();
    if !off.is_empty() && !airport.edges.is_empty() {
        lines.push(format!("{} stands without a way to the network: {}", off.len(), named(&off)));
    }
}
