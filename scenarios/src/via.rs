//! `via` of a route, said as clearances to taxi are: stands, nodes, taxiways, runways and holding positions by name.
//!
//! A stand, a node, a holding position or an end of a runway is a place; a taxiway, and a runway between others, is driven
//! along. Between two that are driven along lies nothing but edges without a name; from and to places any way will do.

use models::airport::{Airport, Edge, Hold, Node, Stand};
use models::frames::Point2;
use models::traffic::network::Network;
use models::traffic::ways::RUNWAY_COST;
use std::collections::BTreeSet;

/// A layout as traffic drives on it: with the holding positions, ends and exits of runways that its file need not have.
#[must_use]
pub fn mended(layout: &Airport, network: &Network) -> Airport {
    let hold = |hold: bool| if hold { Hold::Runway } else { Hold::None };
    let nodes = network.nodes.iter().map(|n| Node {
        name: n.name.clone(),
        position_m: n.at_m,
        hold: hold(n.hold_for.is_some()),
    });
    let edges = network.edges.iter().map(|e| Edge {
        from: e.nodes[0],
        to: e.nodes[1],
        two_way: e.two_way,
        runway: e.runway.is_some(),
        name: e.name.clone(),
        width_m: 0.0,
    });
    let stands = layout.stands.iter().zip(&network.stands);
    let stands = stands.map(|(stand, mended)| Stand { node: mended.node, ..stand.clone() });
    Airport {
        nodes: nodes.collect(),
        edges: edges.collect(),
        stands: stands.collect(),
        ..layout.clone()
    }
}

/// The node at an end of a runway.
#[must_use]
pub fn runway_end(network: &Network, name: &str) -> Option<usize> {
    network.runways.iter().find_map(|runway| {
        let end = runway.names.iter().position(|n| n == name)?;
        let at = if end == 0 { runway.spine.first() } else { runway.spine.last() };
        at.map(|(_, node)| *node)
    })
}

/// What a name means.
#[derive(Clone, Debug, PartialEq)]
enum Stop {
    /// Any of these nodes.
    At(Vec<usize>),
    /// Along these edges.
    Along(Vec<usize>),
}

/// A way over all that was named.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Way {
    pub(crate) points_m: Vec<Point2<f64>>,
    /// By name: the point at which it is reached; none of what is driven along.
    pub(crate) index_of: Vec<Option<usize>>,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NoWay {
    /// A name that means nothing, or several things: its place in the list, and what is allowed.
    Name(usize, String),
    /// One from which the next is not reached: the place of the next one, and those that are.
    Apart(usize, Vec<String>),
}

/// The nodes that a name of a place means.
///
/// # Errors
/// If it means nothing, or several things: what is allowed.
pub fn place(layout: &Airport, network: &Network, name: &str) -> Result<Vec<usize>, String> {
    match stop(layout, network, name, false)? {
        Stop::At(nodes) => Ok(nodes),
        Stop::Along(_) => Err("the name of a place".to_owned()),
    }
}

/// Whether a name is one of a place of the layout alone, so that it needs no network.
#[must_use]
pub fn is_plain(layout: &Airport, name: &str, between: bool) -> bool {
    let explicit = name.starts_with('#');
    let runway = layout.runway(name).is_some();
    // A lead-in that is called as its stand is the same thing.
    let own = layout.stand(name).and_then(|s| s.node);
    let mut of_name = layout.edges.iter().filter(|e| e.name == name).peekable();
    let exists = of_name.peek().is_some();
    let leads_in = own.is_some() && of_name.any(|e| Some(e.from) == own || Some(e.to) == own);
    let taxiway = between && exists && !leads_in;
    layout.node(name).is_some() && (explicit || !runway && !taxiway)
}

/// The way over these names, at least two.
pub(crate) fn way(layout: &Airport, network: &Network, names: &[&str]) -> Result<Way, NoWay> {
    let last = names.len().saturating_sub(1);
    let meant = |(at, name): (usize, &&str)| {
        let between = at > 0 && at < last;
        stop(layout, network, name, between).map_err(|allowed| NoWay::Name(at, allowed))
    };
    let stops: Vec<Stop> = names.iter().enumerate().map(meant).collect::<Result<_, _>>()?;
    let search = Search::of(network, &stops);
    match search.cheapest() {
        Ok((nodes, index_of)) => {
            let points_m = nodes.iter().map(|n| network.nodes[*n].at_m).collect();
            let at = |(stop, index): (&Stop, usize)| matches!(stop, Stop::At(_)).then_some(index);
            Ok(Way { points_m, index_of: stops.iter().zip(index_of).map(at).collect() })
        }
        Err((reached, nodes)) => {
            let next = (reached + 1).min(last);
            Err(NoWay::Apart(next, search.connected(reached, &nodes, &stops[next])))
        }
    }
}

/// A node, or the one at its place that its edges were given to.
fn joined(network: &Network, node: usize) -> usize {
    let reached = |at: usize| network.edges.iter().any(|e| e.nodes.contains(&at));
    if reached(node) {
        return node;
    }
    let near = |at: &usize| {
        let apart = network.nodes.get(*at).zip(network.nodes.get(node));
        apart.is_some_and(|(a, b)| (a.at_m - b.at_m).norm() <= ONE_PLACE_M)
    };
    (0..network.nodes.len()).filter(near).find(|at| reached(*at)).unwrap_or(node)
}

/// Nodes nearer than this are one, m.
const ONE_PLACE_M: f64 = 1.0;

fn stop(layout: &Airport, network: &Network, name: &str, between: bool) -> Result<Stop, String> {
    let stand = |name: &str| {
        let at = layout.stands.iter().position(|s| s.name == name)?;
        network.stands.get(at)?.node
    };
    let number = |name: &str| {
        layout.details.numbers.iter().position(|n| n == name).map(|at| joined(network, at))
    };
    let node = |name: &str| {
        let named = network.nodes.iter().position(|n| n.name == name);
        named.map(|at| joined(network, at)).or_else(|| number(name))
    };
    let taxiway = |name: &str| {
        let of = |(index, e): (usize, &models::traffic::network::NetEdge)| {
            (e.name == name && e.runway.is_none()).then_some(index)
        };
        let edges: Vec<usize> = network.edges.iter().enumerate().filter_map(of).collect();
        (!name.is_empty() && !edges.is_empty()).then_some(Stop::Along(edges))
    };
    let runway_of = |name: &str| {
        let named =
            |names: &[String; 2]| names.iter().any(|n| n == name) || names.join("/") == name;
        network.runways.iter().position(|r| named(&r.names))
    };
    let along_runway = |name: &str| {
        let of = runway_of(name)?;
        let edges = network.edges.iter().enumerate().filter(|(_, e)| e.runway == Some(of));
        Some(Stop::Along(edges.map(|(index, _)| index).collect()))
    };
    let runway = |name: &str| match between {
        true => along_runway(name),
        false => runway_end(network, name).map(|end| Stop::At(vec![end])),
    };
    let hold = |name: &str| {
        let of = runway_of(name)?;
        let holds = network.nodes.iter().enumerate();
        let holds = holds.filter(|(_, n)| n.hold_for == Some(of) && n.used);
        let holds: Vec<usize> = holds.map(|(index, _)| index).collect();
        (!holds.is_empty()).then_some(Stop::At(holds))
    };
    let one = |at: usize| Stop::At(vec![at]);
    let mut found: Vec<(String, Stop)> = Vec::new();
    let at_stand = stand(name);
    found.extend(at_stand.map(|at| (format!("stand {name}"), one(at))));
    let other = node(name).filter(|at| Some(*at) != at_stand);
    let short = other == number(name);
    let said = if short { format!("#{name}") } else { format!("node {name}") };
    found.extend(other.map(|at| (said, one(at))));
    found.extend(runway(name).map(|stop| (format!("runway {name}"), stop)));
    // A way begins and ends at places. A lead-in that is called as its stand is the same thing.
    let leads_in = |stop: &Stop| match stop {
        Stop::Along(edges) => {
            let nodes = edges.iter().flat_map(|e| network.edges[*e].nodes);
            at_stand.is_some_and(|at| nodes.into_iter().any(|node| node == at))
        }
        Stop::At(_) => false,
    };
    let along = taxiway(name).filter(|stop| between && !leads_in(stop));
    found.extend(along.map(|stop| (format!("taxiway {name}"), stop)));
    if found.is_empty() {
        let said = match name.split_once(' ') {
            Some(("stand", name)) => stand(name).map(one),
            Some(("node", name)) => node(name).map(one),
            Some(("taxiway", name)) if between => taxiway(name),
            Some(("runway", name)) => runway(name),
            Some(("hold", name)) => hold(name),
            _ => name.strip_prefix('#').and_then(|n| number(n).or_else(|| node(n))).map(one),
        };
        return said.ok_or_else(|| {
            let ways = if between { ", a taxiway, a runway" } else { "" };
            let ends = if !between && taxiway(name).is_some() {
                " (a way neither begins nor ends along a taxiway)"
            } else {
                ""
            };
            format!(
                "a stand, a node, a holding position, an end or exit of a runway{ways}, or `hold RUNWAY`{ends}; `seeds airport nodes` lists the names"
            )
        });
    }
    if found.len() > 1 {
        let words: Vec<String> = found.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        return Err(format!("one of {}: it is the name of each", words.join(", ")));
    }
    Ok(found.swap_remove(0).1)
}

/// A search over (how many stops are reached, node).
struct Search<'a> {
    network: &'a Network,
    stops: &'a [Stop],
    /// By stop and edge: it is driven along for this stop.
    along: Vec<BTreeSet<usize>>,
    /// By node: edges that leave it, with where they lead.
    out: Vec<Vec<(usize, usize)>>,
    /// Nodes that are not passed through.
    ends_only: BTreeSet<usize>,
}

/// A free way beside one that was named counts so many times its length.
const BESIDE: f64 = 3.0;

/// Nodes of a way, and the place in it of each stop.
type Reached = (Vec<usize>, Vec<usize>);
/// The last stop that is reached, and the nodes up to which one gets from it.
type Short = (usize, Vec<usize>);

impl<'a> Search<'a> {
    fn of(network: &'a Network, stops: &'a [Stop]) -> Self {
        let mut out = vec![Vec::new(); network.nodes.len()];
        for (index, edge) in network.edges.iter().enumerate() {
            out[edge.nodes[0]].push((index, edge.nodes[1]));
            if edge.two_way {
                out[edge.nodes[1]].push((index, edge.nodes[0]));
            }
        }
        let edges = |stop: &Stop| match stop {
            Stop::Along(edges) => edges.iter().copied().collect(),
            Stop::At(_) => BTreeSet::new(),
        };
        let ends_only = network.stands.iter().filter_map(|s| s.node).collect();
        Self { network, stops, along: stops.iter().map(edges).collect(), out, ends_only }
    }

    fn is_at(&self, stop: usize, node: usize) -> bool {
        matches!(self.stops.get(stop), Some(Stop::At(nodes)) if nodes.contains(&node))
    }

    /// Where one gets from a state by one edge, or by being there: state, cost.
    fn next(&self, (reached, node): (usize, usize)) -> Vec<((usize, usize), f64)> {
        let mut next = Vec::new();
        if self.is_at(reached + 1, node) {
            next.push(((reached + 1, node), 0.0));
        }
        if self.ends_only.contains(&node) && !self.is_at(reached, node) {
            return next;
        }
        let is_place = |stop: usize| matches!(self.stops.get(stop), Some(Stop::At(_)));
        let (here, there) = (is_place(reached), is_place(reached + 1));
        for (index, to) in &self.out[node] {
            let edge = &self.network.edges[*index];
            let length_m = (self.network.nodes[*to].at_m - self.network.nodes[node].at_m).norm();
            let on = |stop: usize| self.along.get(stop).is_some_and(|edges| edges.contains(index));
            if on(reached + 1) {
                next.push(((reached + 1, *to), length_m));
            }
            if on(reached) {
                next.push(((reached, *to), length_m));
            } else if here || there || edge.name.is_empty() && edge.runway.is_none() {
                let runway = if edge.runway.is_some() { RUNWAY_COST } else { 1.0 };
                let beside = if here && there { 1.0 } else { BESIDE };
                next.push(((reached, *to), length_m * runway * beside));
            }
        }
        next
    }

    /// Nodes of the cheapest way with the place in it at which each stop is reached; else the last stop that is, and
    /// the nodes up to which one gets from it.
    fn cheapest(&self) -> Result<Reached, Short> {
        let count = self.network.nodes.len();
        let id = |(reached, node): (usize, usize)| reached * count + node;
        let mut least = vec![f64::INFINITY; self.stops.len() * count];
        let mut before: Vec<Option<(usize, usize)>> = vec![None; least.len()];
        let mut open = BTreeSet::new();
        let Some(Stop::At(begins)) = self.stops.first() else { return Err((0, Vec::new())) };
        for begin in begins {
            least[id((0, *begin))] = 0.0;
            open.insert((0_u64, 0, *begin));
        }
        let (mut farthest, end) = (0, self.stops.len() - 1);
        while let Some((bits, reached, node)) = open.pop_first() {
            farthest = farthest.max(reached);
            if reached == end {
                let mut states = vec![(reached, node)];
                while let Some(state) = before[id(states[states.len() - 1])] {
                    states.push(state);
                }
                states.reverse();
                let (mut nodes, mut index_of) = (vec![states[0].1], vec![0]);
                for (reached, node) in &states[1..] {
                    if nodes.last() != Some(node) {
                        nodes.push(*node);
                    }
                    if index_of.len() <= *reached {
                        index_of.push(nodes.len() - 1);
                    }
                }
                return Ok((nodes, index_of));
            }
            for (state, cost) in self.next((reached, node)) {
                let there = f64::from_bits(bits) + cost;
                if there < least[id(state)] {
                    open.remove(&(least[id(state)].to_bits(), state.0, state.1));
                    least[id(state)] = there;
                    before[id(state)] = Some((reached, node));
                    open.insert((there.to_bits(), state.0, state.1));
                }
            }
        }
        let reached = |node: &usize| least[id((farthest, *node))].is_finite();
        Err((farthest, (0..count).filter(reached).collect()))
    }

    /// Names of the taxiways that are driven onto from these nodes, the one nearest to another stop first.
    fn connected(&self, reached: usize, nodes: &[usize], wanted: &Stop) -> Vec<String> {
        let there = match wanted {
            Stop::At(nodes) => nodes.clone(),
            Stop::Along(edges) => edges.iter().flat_map(|e| self.network.edges[*e].nodes).collect(),
        };
        let runway = |name: &str| self.network.runways.iter().any(|r| r.names.join("/") == name);
        let leaving = nodes.iter().flat_map(|node| &self.out[*node]);
        let others = leaving.filter(|(index, _)| !self.along[reached].contains(index));
        let edges = others.map(|(index, _)| &self.network.edges[*index]);
        let named = edges.filter(|e| !e.name.is_empty() && e.runway.is_none() && !runway(&e.name));
        let names: BTreeSet<&str> = named.map(|e| &e.name[..]).collect();
        let far_m = |name: &str| {
            let of_name = self.network.edges.iter().filter(|e| e.name == name);
            let places = of_name.flat_map(|e| e.nodes).map(|n| self.network.nodes[n].at_m);
            let far = places.flat_map(|at_m| {
                there.iter().map(move |n| (self.network.nodes[*n].at_m - at_m).norm())
            });
            far.fold(f64::INFINITY, f64::min)
        };
        let mut names: Vec<(f64, String)> =
            names.into_iter().map(|name| (far_m(name), name.to_owned())).collect();
        names.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
        let mut names: Vec<String> = names.into_iter().map(|(_, name)| name).collect();
        names.truncate(5);
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airport::check_files;
    use models::traffic::ways::Graph;

    fn airport(name: &str) -> (Airport, Network) {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("airports").join(name);
        let beside = file.with_file_name(name.replace(".apt.dat", ".groundnet.xml"));
        let files: Vec<_> = [file, beside].into_iter().filter(|f| f.is_file()).collect();
        let layout = check_files(&files, None).unwrap_or_else(|e| panic!("{e}")).0;
        let network = Network::of(&layout);
        (layout, network)
    }

    /// Names of what is driven along, each run once.
    fn driven(network: &Network, way: &Way) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for pair in way.points_m.windows(2) {
            let is = |e: &&models::traffic::network::NetEdge| {
                let ends = e.nodes.map(|n| network.nodes[n].at_m);
                ends == [pair[0], pair[1]] || ends == [pair[1], pair[0]]
            };
            let edge = network.edges.iter().find(is).expect("along an edge");
            if !edge.name.is_empty() && edge.runway.is_none() && names.last() != Some(&edge.name) {
                names.push(edge.name.clone());
            }
        }
        names
    }

    fn holds_in_order(whole: &[String], wanted: &[String]) -> bool {
        let mut rest = whole.iter();
        wanted.iter().all(|name| rest.any(|n| n == name))
    }

    #[test]
    fn a_way_over_the_names_of_taxiways_is_driven_along_them_in_their_order() {
        let (mut tried, mut long) = (0, 0);
        for file in ["LSZH.apt.dat", "EHAM.apt.dat", "LIMC.apt.dat", "LZIB.apt.dat", "XSYN.apt.dat"]
        {
            let (layout, network) = airport(file);
            let whole = mended(&layout, &network);
            let graph = Graph::of(&whole);
            let stands: Vec<_> = whole.stands.iter().filter(|s| s.node.is_some()).collect();
            for (n, stand) in stands.iter().step_by(1 + stands.len() / 8).enumerate() {
                let runway = &network.runways[n % network.runways.len()];
                let hold = network
                    .nodes
                    .iter()
                    .position(|node| node.used && node.hold_for == Some(n % network.runways.len()));
                let (Some(hold), Some(from)) = (hold, stand.node) else { continue };
                let Some(way) = graph.cheapest(from, hold, Graph::runway_cost) else { continue };
                let mut names: Vec<String> = Vec::new();
                let mut clear = true;
                for arc in &way.arcs {
                    let arc = &graph.arcs()[*arc];
                    clear &= !arc.runway;
                    let name = &whole.edges[arc.edge].name;
                    if !name.is_empty() && names.last() != Some(name) {
                        names.push(name.clone());
                    }
                }
                if !clear || names.is_empty() {
                    continue;
                }
                let said: Vec<String> = names.iter().map(|n| format!("taxiway {n}")).collect();
                let (begin, end) =
                    (format!("stand {}", stand.name), format!("hold {}", runway.names[0]));
                let via: Vec<&str> = std::iter::once(&*begin)
                    .chain(said.iter().map(|s| &**s))
                    .chain([&*end])
                    .collect();
                let found = super::way(&layout, &network, &via);
                let found = found.unwrap_or_else(|e| panic!("{file}: {via:?}: {e:?}"));
                let driven = driven(&network, &found);
                assert!(holds_in_order(&driven, &names), "{file}: {via:?}: {driven:?}");
                assert_eq!(found.index_of.len(), via.len());
                assert_eq!(found.index_of[via.len() - 1], Some(found.points_m.len() - 1));
                assert!(found.index_of[1..via.len() - 1].iter().all(Option::is_none));
                // Fewer names are enough where the way is the shortest; other names are driven along, too.
                tried += 1;
                long += usize::from(names.len() > 2);
            }
        }
        assert!(tried > 20 && long > 5, "{tried}, {long}");
    }

    #[test]
    fn every_name_that_is_listed_is_known_and_one_of_two_things_is_refused_with_how_to_say_either()
    {
        for file in ["LSZH.apt.dat", "EHAM.apt.dat", "XSYN.apt.dat"] {
            let (layout, network) = airport(file);
            let names = |meant: &str, between| stop(&layout, &network, meant, between);
            let (mut known, mut twice) = (0, 0);
            let listed = network.nodes.iter().filter(|n| n.hold_for.is_some());
            let listed = listed.map(|n| n.name.clone());
            let spines = network.runways.iter().flat_map(|r| &r.spine);
            let listed = listed.chain(spines.map(|(_, node)| network.nodes[*node].name.clone()));
            let ends = network.runways.iter().flat_map(|r| r.names.clone());
            for name in listed.chain(ends).chain(layout.stands.iter().map(|s| s.name.clone())) {
                match names(&name, false) {
                    Ok(Stop::At(_)) => known += 1,
                    Ok(Stop::Along(_)) => panic!("{file}: {name} is a place at the end"),
                    Err(said) => {
                        // Every way to say it is one that is understood.
                        let forms: Vec<&str> = said.split('"').skip(1).step_by(2).collect();
                        if forms.is_empty() {
                            let stand = layout.stands.iter().position(|s| s.name == name);
                            let no_way = stand.is_some_and(|s| network.stands[s].node.is_none());
                            assert!(no_way, "{file}: {name}: {said}");
                            continue;
                        }
                        assert!(forms.len() > 1, "{file}: {name}: {said}");
                        for form in forms {
                            assert!(names(form, false).is_ok(), "{file}: {form}");
                        }
                        twice += 1;
                    }
                }
            }
            assert!(known > 20, "{file}: {known}");
            assert!(twice < known, "{file}: {twice} of {known}");
        }
        let (layout, network) = airport("LSZH.apt.dat");
        let said = stop(&layout, &network, "28", true).expect_err("a node and a runway");
        assert_eq!(said, "one of \"#28\", \"runway 28\": it is the name of each");
        assert!(
            matches!(stop(&layout, &network, "runway 28", true), Ok(Stop::Along(e)) if e.len() > 3)
        );
        assert!(
            matches!(stop(&layout, &network, "runway 28", false), Ok(Stop::At(n)) if n.len() == 1)
        );
        assert!(!is_plain(&layout, "28", true) && is_plain(&layout, "#28", true));
        // A stand whose lead-in is called as it is.
        assert!(layout.edges.iter().any(|e| e.name == "D_57") && is_plain(&layout, "D_57", true));
        assert!(matches!(stop(&layout, &network, "D_57", true), Ok(Stop::At(_))));
        for wrong in ["nowhere", "hold 99", "taxiway 9", "stand nowhere", ""] {
            let said = stop(&layout, &network, wrong, true).expect_err(wrong);
            assert!(said.contains("seeds airport nodes"), "{said}");
        }
    }

    #[test]
    fn taxiways_that_do_not_meet_are_said_with_the_nearest_that_do() {
        let mut tried = 0;
        for file in ["EHAM.apt.dat", "LIMC.apt.dat", "LZIB.apt.dat"] {
            let (layout, network) = airport(file);
            let names: BTreeSet<&str> = network
                .edges
                .iter()
                .filter(|e| !e.name.is_empty() && e.runway.is_none())
                .map(|e| &e.name[..])
                .collect();
            let stand = layout.stands.iter().zip(&network.stands).find(|(_, s)| s.node.is_some());
            let begin = format!("stand {}", stand.expect("one with a way").0.name);
            let of = |names: [&str; 2]| {
                let [a, b] = names.map(|n| format!("taxiway {n}"));
                super::way(&layout, &network, &[&begin, &a, &b, &begin])
            };
            for (a, b) in names.iter().zip(names.iter().rev()).filter(|(a, b)| a != b).take(6) {
                let Err(NoWay::Apart(2, connected)) = of([a, b]) else { continue };
                for other in connected {
                    match of([a, &other]) {
                        // It is met; whether one gets back from there is another matter.
                        Ok(_) | Err(NoWay::Apart(3, _)) => tried += 1,
                        wrong => panic!("{file}: {a} meets {other}: {wrong:?}"),
                    }
                }
            }
        }
        assert!(tried > 3, "{tried}");
    }
}
