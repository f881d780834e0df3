//! Stands and nodes of a layout by name, and the ways between them: a scene may have ten thousand movers.

use models::airport::{Airport, Stand};
use models::traffic::network::Network;
use models::traffic::ways::Graph;
use models::truth::route::{self, Route};
use std::cell::OnceCell;
use std::collections::BTreeMap;

/// What [`Airport::node`], [`Airport::stand`] and [`route::shortest`] find, without a search of the whole layout each time.
pub(crate) struct Places<'a> {
    layout: &'a Airport,
    stands: BTreeMap<&'a str, usize>,
    nodes: BTreeMap<&'a str, usize>,
    numbers: BTreeMap<&'a str, usize>,
    graph: OnceCell<Graph>,
    network: OnceCell<Network>,
}

/// Index by name; of equal names the first.
fn by_name<'a>(names: impl Iterator<Item = &'a str>) -> BTreeMap<&'a str, usize> {
    let mut index = BTreeMap::new();
    for (at, name) in names.enumerate() {
        index.entry(name).or_insert(at);
    }
    index
}

impl<'a> Places<'a> {
    pub(crate) fn of(layout: &'a Airport) -> Self {
        Self {
            layout,
            stands: by_name(layout.stands.iter().map(|s| &*s.name)),
            nodes: by_name(layout.nodes.iter().map(|n| &*n.name)),
            numbers: by_name(layout.details.numbers.iter().map(|n| &**n)),
            graph: OnceCell::new(),
            network: OnceCell::new(),
        }
    }

    pub(crate) fn layout(&self) -> &'a Airport {
        self.layout
    }

    pub(crate) fn stand(&self, name: &str) -> Option<&'a Stand> {
        self.stands.get(name).map(|at| &self.layout.stands[*at])
    }

    pub(crate) fn node(&self, name: &str) -> Option<usize> {
        let named = |name: &str| self.nodes.get(name).copied();
        let numbered = |number: &str| self.numbers.get(number).copied();
        match name.strip_prefix('#') {
            Some(number) => numbered(number).or_else(|| named(number)),
            None => named(name)
                .or_else(|| self.stand(name).and_then(|s| s.node))
                .or_else(|| numbered(name)),
        }
    }

    /// The network that traffic drives on.
    pub(crate) fn network(&self) -> &Network {
        self.network.get_or_init(|| Network::of(self.layout))
    }

    pub(crate) fn shortest(&self, from: usize, to: usize) -> Option<Route> {
        let graph = self.graph.get_or_init(|| Graph::of(self.layout));
        route::shortest_in(self.layout, graph, from, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found_where_a_search_of_the_layout_finds_it() {
        for scene in ["zurich", "eham", "xsyn"] {
            let scene = crate::load(&crate::locate(scene)).expect("a shipped scene");
            let layout = &scene.airport.layout;
            let places = Places::of(layout);
            let names =
                layout.nodes.iter().map(|n| &n.name).chain(layout.stands.iter().map(|s| &s.name));
            let mut count = 0;
            for name in names.chain(&layout.details.numbers) {
                for name in [name.clone(), format!("#{name}"), format!("{name}?")] {
                    assert_eq!(places.node(&name), layout.node(&name), "{name}");
                    assert_eq!(places.stand(&name), layout.stand(&name), "{name}");
                    count += usize::from(layout.node(&name).is_some());
                }
            }
            assert!(count > 50, "{count}");
        }
    }
}
