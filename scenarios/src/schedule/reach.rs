//! What can be reached on a network: stands from runways, ends that traffic uses, lengths that types need.

use super::RunwayEnd;
use super::flights::flight_of;
use crate::types::TypeRow;
use models::frames::{Azimuth, Vector2, wrap_pi};
use models::traffic::core::Day;
use models::traffic::network::{NetEdge, Network, code_of_span};
use models::traffic::runway_roll::{INTERSECTION_SHARE, touchdown_zone};
use models::traffic::way::Arcs;
use models::traffic::ways::SHARPEST_TURN_DEG;
use std::rc::Rc;

/// A network with what every search over it needs.
#[derive(Clone)]
pub(super) struct Ground<'a> {
    pub(super) network: &'a Network,
    /// The weather of the run, each from a time on.
    pub(super) days: &'a [(f64, Day)],
    /// Wind at the begin of the run, or of what is looked at; the worst of the rest: surfaces wet, the thinnest air.
    worst: Day,
    /// By runway: closed to the end of the run.
    closed: Rc<Vec<bool>>,
    arcs: Rc<Arcs>,
    /// By node: arcs that reach it, not from stands.
    entering: Rc<Vec<Vec<usize>>>,
    /// By stand: arcs that lead on from where its lead-in joins a lane.
    lanes: Rc<Vec<Vec<usize>>>,
}

impl<'a> Ground<'a> {
    pub(super) fn of(network: &'a Network, days: &'a [(f64, Day)], closed: Vec<bool>) -> Self {
        let day = days.first().map_or(Day::default(), |d| d.1);
        let worst = days.iter().fold(day, |worst, (_, day)| Day {
            wet: worst.wet || day.wet,
            density_ratio: worst.density_ratio.min(day.density_ratio),
            ..worst
        });
        let arcs = Arcs::of(network);
        let mut entering = vec![Vec::new(); network.nodes.len()];
        for arc in (0..network.nodes.len()).flat_map(|n| arcs.leaving(n).to_vec()) {
            if network.nodes[Arcs::from(network, arc)].stand.is_none() {
                entering[Arcs::to(network, arc)].push(arc);
            }
        }
        let lane = |node: Option<usize>| node.map_or(Vec::new(), |n| lane_arcs(network, &arcs, n));
        let lanes = network.stands.iter().map(|s| lane(s.node)).collect();
        let (closed, arcs) = (Rc::new(closed), Rc::new(arcs));
        let (entering, lanes) = (Rc::new(entering), Rc::new(lanes));
        Self { network, days, worst, closed, arcs, entering, lanes }
    }

    /// The same in the wind of a time of the run, s.
    pub(super) fn in_wind_at(&self, time_s: f64) -> Self {
        let day = self.days.iter().rev().find(|d| d.0 <= time_s);
        self.in_wind(day.map_or(self.worst.wind_mps, |d| d.1.wind_mps))
    }

    /// The most of a runway ahead of any entry for take-offs from an end, m.
    pub(super) fn longest_run_m(&self, end: RunwayEnd) -> f64 {
        self.arcs.longest_run_m(self.network, end)
    }

    /// The same in another wind, m/s east and north (where it blows to).
    pub(super) fn in_wind(&self, wind_mps: Vector2<f64>) -> Self {
        Self { worst: Day { wind_mps, ..self.worst }, ..self.clone() }
    }
}

/// Stands that an aircraft of a code reaches from an exit of any runway, at turns that are driven.
pub(super) fn reached_stands(ground: &Ground<'_>, code: u8) -> Vec<bool> {
    let Ground { network, arcs, .. } = ground;
    let spine = network.runways.iter().flat_map(|r| r.spine.iter().map(|(_, n)| *n));
    let from = spine.flat_map(|n| arcs.leaving(n).to_vec()).collect();
    flood(ground, from, |e| e.code >= code && e.runway.is_none())
}

/// The end to land on instead where no stand is reached from the exits of the wanted one without the runway itself, or by a
/// backtrack from a turn pad: of the runways of the same direction the first with a way. `None`: the wanted one
/// will do, or no other is better.
pub(super) fn lands_instead(
    ground: &Ground<'_>,
    (r, end): RunwayEnd,
    code: u8,
) -> Option<RunwayEnd> {
    let network = ground.network;
    let heading = |r: usize, end: usize| direction_rad(network, (r, end));
    let leads_to_stands =
        |end: RunwayEnd| Reach::of(ground, end, true).stands(code, 600.0).contains(&true);
    if leads_to_stands((r, end)) {
        return None;
    }
    let ends = (0..network.runways.len()).flat_map(|o| [(o, 0), (o, 1)]);
    let along = |o: &RunwayEnd| wrap_pi(heading(o.0, o.1) - heading(r, end)).abs() < 0.35;
    ends.filter(|o| o.0 != r).filter(along).find(|o| leads_to_stands(*o))
}

/// Sharpest turn off a runway or on to it, degrees.
const EXIT_DEG: f64 = 115.0;

pub(super) fn direction_rad(network: &Network, (r, end): RunwayEnd) -> f64 {
    let ends_m = network.runways[r].ends_m;
    Azimuth::of(ends_m[1 - end] - ends_m[end]).rad()
}

/// What lies between one end of a runway and the stands, on an empty airport: for landings from its exits, for take-offs to its
/// entries, at turns that are driven and without the runway itself.
pub(super) struct Reach<'a> {
    ground: &'a Ground<'a>,
    runway: usize,
    arrival: bool,
    /// Exits or entries: how much of the runway lies before (landings) or behind them (take-offs), m, and the arc.
    doors: Vec<(f64, usize)>,
}

impl<'a> Reach<'a> {
    pub(super) fn of(ground: &'a Ground<'a>, (r, end): RunwayEnd, arrival: bool) -> Self {
        let Ground { network, arcs, .. } = ground;
        let runway = &network.runways[r];
        let along =
            |place: f64| if (end == 0) == arrival { place } else { runway.length_m - place };
        let direction_rad = direction_rad(network, (r, end));
        let all = (0..network.nodes.len()).flat_map(|n| arcs.leaving(n).to_vec());
        let node = |arc| if arrival { Arcs::from(network, arc) } else { Arcs::to(network, arc) };
        let doors = all.filter_map(|arc| {
            let edge = &network.edges[arc / 2];
            let (place, _) = runway.spine.iter().find(|(_, n)| *n == node(arc))?;
            let turn_rad = wrap_pi(arcs.heading_rad(arc) - direction_rad).abs();
            let off = edge.strip == Some(r) && edge.runway.is_none();
            (off && turn_rad <= EXIT_DEG.to_radians()).then(|| (along(*place), arc))
        });
        let doors = doors.collect();
        Self { ground, runway: r, arrival, doors }
    }

    /// Stands that an aircraft of a code reaches from exits farther than `least_m`, or leaves for entries with more than that.
    pub(super) fn stands(&self, code: u8, least_m: f64) -> Vec<bool> {
        self.behind(self.doors_beyond(least_m), |e| self.usable(e, code))
    }

    /// The same without taxiing along another runway.
    pub(super) fn stands_off_runways(&self, code: u8, least_m: f64) -> Vec<bool> {
        let network = self.ground.network;
        let usable = |e: &NetEdge| self.usable(e, code) && !network.is_along_runway(e);
        self.behind(self.doors_beyond(least_m), usable)
    }

    fn doors_beyond(&self, least_m: f64) -> Vec<usize> {
        self.doors.iter().filter(|d| d.0 > least_m).map(|d| d.1).collect()
    }

    fn usable(&self, edge: &NetEdge, code: u8) -> bool {
        edge.code >= code && edge.runway != Some(self.runway)
    }

    /// Length that can be used, m: up to the farthest exit of landings, or the longest run from an entry of take-offs; 0 where
    /// no door has a way to or from a stand.
    pub(super) fn length_m(&self, code: u8) -> f64 {
        let mut doors = self.doors.clone();
        doors.sort_by(|a, b| b.0.total_cmp(&a.0));
        let usable = |e: &NetEdge| self.usable(e, code);
        let used = doors.iter().find(|d| self.behind(vec![d.1], usable).contains(&true));
        used.map_or(0.0, |d| d.0.max(0.0))
    }

    fn behind(&self, doors: Vec<usize>, usable: impl Fn(&NetEdge) -> bool) -> Vec<bool> {
        if self.arrival {
            return flood(self.ground, doors, usable);
        }
        let seen = flood_back(self.ground, doors, usable);
        self.ground.lanes.iter().map(|lane| lane.iter().any(|a| seen[*a])).collect()
    }
}

/// Arcs that lead on from where the lead-in of a stand joins a lane: after the pushback one of them is driven.
fn lane_arcs(network: &Network, arcs: &Arcs, stand: usize) -> Vec<usize> {
    let (mut node, mut came) = (stand, usize::MAX);
    for _ in 0..30 {
        let mut on = arcs.edges_at(node).iter().copied().filter(|e| *e != came);
        match (on.next(), on.next()) {
            (Some(e), None) => {
                let nodes = network.edges[e].nodes;
                (node, came) = (nodes[usize::from(nodes[0] == node)], e);
            }
            _ => break,
        }
    }
    arcs.leaving(node).iter().copied().filter(|a| a / 2 != came).collect()
}

/// Stands that are reached from some arcs over edges that can be used.
fn flood(ground: &Ground<'_>, from: Vec<usize>, usable: impl Fn(&NetEdge) -> bool) -> Vec<bool> {
    let Ground { network, arcs, .. } = ground;
    let next = |arc: usize| {
        let node = Arcs::to(network, arc);
        let ends = network.nodes[node].stand.is_some();
        let on = arcs.leaving(node).iter().copied().filter(move |_| !ends);
        on.filter(move |n| arcs.turn_rad(arc, *n) <= SHARPEST_TURN_DEG.to_radians()).collect()
    };
    let seen = spread(network, from, usable, next);
    let mut stands = vec![false; network.stands.len()];
    for arc in (0..seen.len()).filter(|a| seen[*a]) {
        if let Some(stand) = network.nodes[Arcs::to(network, arc)].stand {
            stands[stand] = true;
        }
    }
    stands
}

/// Arcs from which some arcs are reached; not through stands.
fn flood_back(
    ground: &Ground<'_>,
    from: Vec<usize>,
    usable: impl Fn(&NetEdge) -> bool,
) -> Vec<bool> {
    let Ground { network, arcs, entering, .. } = ground;
    spread(network, from, usable, |arc: usize| {
        let before = entering[Arcs::from(network, arc)].iter().copied();
        before.filter(|b| arcs.turn_rad(*b, arc) <= SHARPEST_TURN_DEG.to_radians()).collect()
    })
}

/// Arcs that are reached from some over edges that can be used; nobody turns back on an edge.
fn spread(
    network: &Network,
    from: Vec<usize>,
    usable: impl Fn(&NetEdge) -> bool,
    next: impl Fn(usize) -> Vec<usize>,
) -> Vec<bool> {
    let usable = |arc: usize| usable(&network.edges[arc / 2]);
    let mut seen = vec![false; 2 * network.edges.len()];
    let mut open: Vec<usize> = from.into_iter().filter(|a| usable(*a)).collect();
    open.iter().for_each(|a| seen[*a] = true);
    while let Some(arc) = open.pop() {
        for other in next(arc) {
            if other / 2 != arc / 2 && usable(other) && !seen[other] {
                seen[other] = true;
                open.push(other);
            }
        }
    }
    seen
}

/// Nobody lands or takes off with more wind from behind, m/s, or from the side, where other ends have less (traffic.md 8.4).
const MOST_TAILWIND_MPS: f64 = 2.5;
const MOST_CROSSWIND_MPS: f64 = 12.0;

/// Ends that traffic uses where the scene names none, for landings and take-offs, each beside those that it names (empty: none).
///
/// Both bear as many types of the demand as any runway does (`mixes`: what it is drawn from, and what instead where nothing of it can).
/// Landings go to the runway with most exits from which stands are reached, take-offs to the next best one that does not cross it,
/// else to the same, at the wind of the begin. Nobody takes off towards those who land, on runways side by side either.
pub(super) fn default_ends(
    ground: &Ground<'_>,
    named: [&[String]; 2],
    mixes: &[Vec<(&TypeRow, f64)>],
) -> [Vec<String>; 2] {
    let (network, wind_mps) = (ground.network, ground.worst.wind_mps);
    let exits = |r: usize| {
        let off = |e: &&NetEdge| e.runway.is_none() && !e.backtrack;
        let strip = network.edges.iter().filter(|e| e.strip == Some(r)).filter(off);
        strip.filter(|e| e.nodes.iter().all(|n| network.nodes[*n].used)).count()
    };
    let mut order: Vec<usize> = (0..network.runways.len()).filter(|r| exits(*r) > 0).collect();
    if order.iter().any(|r| !ground.closed[*r]) {
        order.retain(|r| !ground.closed[*r]);
    }
    order.sort_by_key(|r| (std::cmp::Reverse(exits(*r)), *r));
    let crosses = |a: usize, b: usize| {
        let spine = |r: usize| network.runways[r].spine.iter().map(|(_, n)| *n);
        spine(a).any(|n| spine(b).any(|m| m == n))
    };
    let all: Vec<RunwayEnd> = order.iter().flat_map(|r| [(*r, 0), (*r, 1)]).collect();
    let of = |arrival: bool| -> Vec<Candidate> {
        let fixed: Vec<RunwayEnd> = named[usize::from(!arrival)]
            .iter()
            .filter_map(|name| end_named(network, name))
            .collect();
        let ends = if fixed.is_empty() { &all } else { &fixed };
        let reaches: Vec<Reach<'_>> =
            ends.iter().map(|end| Reach::of(ground, *end, arrival)).collect();
        let bears = borne(ends, &reaches, mixes);
        let candidate = |(n, end): (usize, &RunwayEnd)| {
            let (r, e) = *end;
            let ends_m = network.runways[r].ends_m;
            let towards = (ends_m[1 - e] - ends_m[e]).normalize();
            let tail_mps = wind_mps.dot(&towards);
            Candidate {
                end: *end,
                rank: order.iter().position(|o| *o == r).unwrap_or(order.len()),
                towards,
                length_m: reaches[n].length_m(0),
                short: !bears[n],
                tailwind: tail_mps > MOST_TAILWIND_MPS,
                crosswind: (wind_mps - towards * tail_mps).norm() > MOST_CROSSWIND_MPS,
            }
        };
        ends.iter().enumerate().map(candidate).collect()
    };
    let [landing, leaving] = [of(true), of(false)];
    let mut best: Option<(Merit, f64, [RunwayEnd; 2])> = None;
    for (lands, leaves) in landing.iter().flat_map(|a| leaving.iter().map(move |d| (a, d))) {
        let same = lands.end.0 == leaves.end.0;
        if !same && crosses(lands.end.0, leaves.end.0) {
            continue;
        }
        let both = [lands, leaves];
        let count = |what: &dyn Fn(&Candidate) -> bool| both.iter().filter(|c| what(c)).count();
        let merit = Merit {
            without_way: count(&|c| c.length_m == 0.0),
            tailwinds: count(&|c| c.tailwind),
            short: count(&|c| c.short),
            head_on: lands.towards.dot(&leaves.towards) < HEAD_ON_COS,
            crosswinds: count(&|c| c.crosswind),
            ranks: (lands.rank, if same { usize::MAX } else { leaves.rank }),
        };
        let length_m = if same { lands.length_m.min(leaves.length_m) } else { leaves.length_m };
        let better = best.as_ref().is_none_or(|(known, known_m, _)| {
            merit < *known || merit == *known && length_m > known_m + 1.0
        });
        if better {
            best = Some((merit, length_m, [lands.end, leaves.end]));
        }
    }
    let name = |(r, end): RunwayEnd| vec![network.runways[r].names[end].clone()];
    best.map_or([Vec::new(), Vec::new()], |(_, _, ends)| ends.map(name))
}

/// Ends whose directions enclose more than 120 degrees lie head-on (assumed).
const HEAD_ON_COS: f64 = -0.5;

/// An end that traffic may use.
struct Candidate {
    end: RunwayEnd,
    /// Place of its runway in the order by exits.
    rank: usize,
    /// Direction of landings and take-offs.
    towards: Vector2<f64>,
    /// Length that can be used, m.
    length_m: f64,
    tailwind: bool,
    crosswind: bool,
    /// Types of the demand that another end bears cannot use this one.
    short: bool,
}

/// An end that bears this share of what the best one does is not short: a second runway is worth more than the largest types (assumed).
const ENOUGH: f64 = 0.7;

/// Which ends bear about as much of a demand as any does: of the first of its mixes that is borne anywhere, by weight.
fn borne(ends: &[RunwayEnd], reaches: &[Reach<'_>], mixes: &[Vec<(&TypeRow, f64)>]) -> Vec<bool> {
    for mix in mixes {
        let of = |(end, reach): (&RunwayEnd, &Reach<'_>)| -> f64 {
            let usable = mix.iter().filter(|(row, _)| {
                needs_m(row, reach, end.1) <= reach.length_m(code_of_span(row.class.span_m))
            });
            usable.map(|(_, weight)| weight).sum()
        };
        let borne: Vec<f64> = ends.iter().zip(reaches).map(of).collect();
        let most = borne.iter().copied().fold(0.0, f64::max);
        if most > 0.0 {
            return borne.iter().map(|b| *b >= ENOUGH * most).collect();
        }
    }
    vec![true; ends.len()]
}

/// What speaks against an end for landings and one for take-offs, the gravest first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Merit {
    without_way: usize,
    tailwinds: usize,
    head_on: bool,
    crosswinds: usize,
    short: usize,
    ranks: (usize, usize),
}

/// Runway that a type needs behind an entry or before an exit, m. Take-offs need 1.15 of their run, where no entry has that 1.05 of
/// it and 100 m; landings the way from the farthest touchdown (900 m behind the threshold, which may be displaced, less on a short runway) with 2 s and
/// the braking below; at the thinnest air, the most water and the tail wind that the run knows, never with a head wind.
pub(super) fn needs_m(row: &TypeRow, reach: &Reach<'_>, end: usize) -> f64 {
    let f = flight_of(row);
    let Ground { network, worst, .. } = reach.ground;
    let tail_mps =
        (-worst.head_mps(Azimuth::from_rad(direction_rad(network, (reach.runway, end))))).max(0.0);
    if reach.arrival {
        let runway = &network.runways[reach.runway];
        let v = f.landing.0 + tail_mps;
        let zone = touchdown_zone(runway.length_m - runway.displaced_m[end]);
        let braking_mps2 = if worst.wet { WET_BRAKING_MPS2 } else { DRY_BRAKING_MPS2 };
        let stop_m = v * v / (2.0 * braking_mps2);
        return runway.displaced_m[end] + zone.within_m.1 + 2.0 * v + stop_m;
    }
    let run_m = f.run_m(worst.density_ratio, -tail_mps).unwrap_or(f64::INFINITY);
    let longest_m = reach.doors.iter().map(|d| d.0).fold(0.0, f64::max);
    (INTERSECTION_SHARE * run_m).min(longest_m).max(1.05 * run_m + 100.0)
}

/// Braking of a landing that a runway is long enough for, m/s² (assumed).
const DRY_BRAKING_MPS2: f64 = 2.2;
const WET_BRAKING_MPS2: f64 = 1.6;

/// What a type lacks on the runways of a demand, m; 0: it can use them.
pub(super) fn lacks_m(
    ground: &Ground<'_>,
    row: &TypeRow,
    landing: &[String],
    leaving: &[String],
) -> f64 {
    let mut lacks = 0.0_f64;
    for (ends, arrival) in [(landing, true), (leaving, false)] {
        for name in ends {
            let Some(end) = end_named(ground.network, name) else { continue };
            let code = code_of_span(row.class.span_m);
            let reach = Reach::of(ground, end, arrival);
            lacks = lacks.max(needs_m(row, &reach, end.1) - reach.length_m(code));
        }
    }
    lacks
}

/// Direction of landings and take-offs of an end, a unit vector.
pub(super) fn direction_of(ground: &Ground<'_>, name: &str) -> Option<Vector2<f64>> {
    let (r, end) = end_named(ground.network, name)?;
    let ends_m = ground.network.runways[r].ends_m;
    Some((ends_m[1 - end] - ends_m[end]).normalize())
}

/// A runway's end by its name.
pub(crate) fn end_named(network: &Network, name: &str) -> Option<RunwayEnd> {
    network
        .runways
        .iter()
        .enumerate()
        .find_map(|(r, runway)| runway.names.iter().position(|n| n == name).map(|end| (r, end)))
}
