//! What can be reached on a network: stands from runways, ends that traffic uses, lengths that types need.

use super::{RunwayEnd, flight_of};
use crate::types::TypeRow;
use models::frames::{Azimuth, wrap_pi};
use models::traffic::network::{NetEdge, Network};
use models::traffic::way::Arcs;
use models::traffic::ways::SHARPEST_TURN_DEG;

/// Stands that an aircraft of a code reaches from an exit of any runway, at turns that are driven.
pub(super) fn reached_stands(network: &Network, code: u8) -> Vec<bool> {
    let arcs = Arcs::of(network);
    let spine = network.runways.iter().flat_map(|r| r.spine.iter().map(|(_, n)| *n));
    let from = spine.flat_map(|n| arcs.leaving(n).to_vec()).collect();
    flood(network, &arcs, from, |e| e.code >= code && e.runway.is_none())
}

/// The end to land on instead where no stand is reached from the exits of the wanted one without the runway itself (a
/// backtrack after a landing is not driven): of the runways of the same direction the first with a way. `None`: the wanted one
/// will do, or no other is better.
pub(super) fn lands_instead(network: &Network, (r, end): RunwayEnd, code: u8) -> Option<RunwayEnd> {
    let heading = |r: usize, end: usize| {
        let ends_m = network.runways[r].ends_m;
        Azimuth::of(ends_m[1 - end] - ends_m[end]).rad()
    };
    let arcs = Arcs::of(network);
    let leads_to_stands = |r: usize, end: usize| {
        let runway = &network.runways[r];
        let far = |place: f64| if end == 0 { place } else { runway.length_m - place } > 600.0;
        let exits = runway.spine.iter().filter(|(place, _)| far(*place));
        let exits = exits.flat_map(|(_, n)| arcs.leaving(*n).to_vec()).filter(|a| {
            let edge = &network.edges[a / 2];
            let turn_rad = wrap_pi(arcs.heading_rad(*a) - heading(r, end)).abs();
            edge.strip == Some(r) && edge.runway.is_none() && turn_rad <= EXIT_DEG.to_radians()
        });
        let usable = |e: &NetEdge| e.code >= code && e.runway != Some(r);
        flood(network, &arcs, exits.collect(), usable).contains(&true)
    };
    if leads_to_stands(r, end) {
        return None;
    }
    let ends = (0..network.runways.len()).flat_map(|o| [(o, 0), (o, 1)]);
    let along = |o: &RunwayEnd| wrap_pi(heading(o.0, o.1) - heading(r, end)).abs() < 0.35;
    ends.filter(|o| o.0 != r).filter(along).find(|o| leads_to_stands(o.0, o.1))
}

/// Sharpest turn off a runway, degrees.
const EXIT_DEG: f64 = 115.0;

/// Stands that are reached from some arcs over edges that can be used.
fn flood(
    network: &Network,
    arcs: &Arcs,
    from: Vec<usize>,
    usable: impl Fn(&NetEdge) -> bool,
) -> Vec<bool> {
    let usable = |arc: usize| usable(&network.edges[arc / 2]);
    let mut seen = vec![false; 2 * network.edges.len()];
    let mut open: Vec<usize> = from.into_iter().filter(|a| usable(*a)).collect();
    open.iter().for_each(|a| seen[*a] = true);
    let mut stands = vec![false; network.stands.len()];
    while let Some(arc) = open.pop() {
        let node = Arcs::to(network, arc);
        if let Some(stand) = network.nodes[node].stand {
            stands[stand] = true;
            continue;
        }
        for next in arcs.leaving(node) {
            let sharp = arcs.turn_rad(arc, *next) > SHARPEST_TURN_DEG.to_radians();
            if !sharp && next / 2 != arc / 2 && usable(*next) && !seen[*next] {
                seen[*next] = true;
                open.push(*next);
            }
        }
    }
    stands
}

/// Ends that traffic uses where the scene says nothing: arrivals to the runway with most exits, departures
/// from the next best one that does not cross it, else from the same.
pub(super) fn default_ends(network: &Network, arrival: bool) -> Vec<String> {
    let exits = |r: usize| {
        let strip = network.edges.iter().filter(|e| e.strip == Some(r) && e.runway.is_none());
        strip.filter(|e| e.nodes.iter().all(|n| network.nodes[*n].used)).count()
    };
    let mut order: Vec<usize> = (0..network.runways.len()).filter(|r| exits(*r) > 0).collect();
    order.sort_by_key(|r| (std::cmp::Reverse(exits(*r)), *r));
    let Some(first) = order.first().copied() else { return Vec::new() };
    let crosses = |a: usize, b: usize| {
        network.runways[a]
            .spine
            .iter()
            .any(|(_, n)| network.runways[b].spine.iter().any(|(_, m)| m == n))
    };
    let second = order[1..].iter().copied().find(|r| !crosses(*r, first)).unwrap_or(first);
    let r = if arrival { first } else { second };
    let reach = |end: usize, arrival: bool| reach_m(network, r, end, arrival);
    // One runway for both is used one way only.
    let score = |end: usize| match (second == first, arrival) {
        (true, _) => reach(end, true).min(reach(end, false)),
        (false, true) => f64::from(1 - end as u32),
        (false, false) => reach(end, false),
    };
    let end = usize::from(score(1) > score(0) + 1.0);
    vec![network.runways[r].names[end].clone()]
}

/// How far down a runway, m: the farthest exit of landings, or the longest run from an entry of take-offs.
pub(super) fn reach_m(network: &Network, r: usize, end: usize, arrival: bool) -> f64 {
    let runway = &network.runways[r];
    let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
    let mut best = 0.0_f64;
    for (place, node) in &runway.spine {
        let on = |e: &&NetEdge| e.nodes.contains(node) && e.strip == Some(r) && e.runway.is_none();
        for edge in network.edges.iter().filter(on) {
            let other = edge.nodes[usize::from(edge.nodes[0] == *node)];
            let away = network.nodes[other].at_m - network.nodes[*node].at_m;
            let heading = Azimuth::of(if arrival { away } else { -away }).rad();
            if wrap_pi(heading - direction).abs() < 2.0 {
                let along = if end == 0 { *place } else { runway.length_m - place };
                best = best.max(if arrival { along } else { runway.length_m - along });
            }
        }
    }
    best
}

/// What a type lacks on the runways of a demand, m; 0: it can use them. Take-offs need 1.05 of their run and 100 m, landings the
/// way from 900 m behind the threshold with 2 s and 2.2 m/s² of braking (assumed).
pub(super) fn lacks_m(
    network: &Network,
    row: &TypeRow,
    landing: &[String],
    leaving: &[String],
) -> f64 {
    let f = flight_of(row);
    let v = f.landing.0;
    let need = [
        (landing, true, 900.0 + 2.0 * v + v * v / 4.4),
        (leaving, false, 1.05 * f.take_off.1 + 100.0),
    ];
    let mut lacks = 0.0_f64;
    for (ends, arrival, need_m) in need {
        for name in ends {
            let found = network.runways.iter().enumerate().find_map(|(r, runway)| {
                runway.names.iter().position(|n| n == name).map(|end| (r, end))
            });
            let Some((r, end)) = found else { continue };
            lacks = lacks.max(need_m - reach_m(network, r, end, arrival));
        }
    }
    lacks
}
