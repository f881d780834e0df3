//! Runway holding positions as lines across their taxiways, for the map.

use models::airport::Airport;
use models::frames::{Point2, Vector2};
use models::traffic::network::Network;
use serde::{Deserialize, Serialize};

/// Half the width of a taxiway whose width nobody says, m.
const HALF_WIDTH_M: f64 = 11.5;

/// A line that is not crossed without a clearance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HoldLine {
    /// The runway, both designators.
    pub runway: String,
    /// Its ends, m east and north.
    pub ends_m: [[f64; 2]; 2],
    /// Whether it is one of category II/III.
    #[serde(default)]
    pub cat3: bool,
}

/// The lines of an airport: those of its file, else where its ground network holds traffic.
#[must_use]
pub fn of(airport: &Airport) -> Vec<HoldLine> {
    let net = Network::of(airport);
    let mut lines = Vec::new();
    for (index, node) in net.nodes.iter().enumerate().filter(|(_, n)| n.used) {
        let Some(runway) = node.hold_for.and_then(|r| net.runways.get(r)) else { continue };
        // Across the way that leads to the runway; else across any way there.
        let touching = || net.edges.iter().filter(move |e| e.nodes.contains(&index));
        let strip = touching().find(|e| e.strip == node.hold_for);
        let Some(edge) = strip.or_else(|| touching().next()) else { continue };
        let along = net.nodes[edge.nodes[1]].at_m - net.nodes[edge.nodes[0]].at_m;
        if along.norm() < 0.1 {
            continue;
        }
        let width_m = edge.origin.and_then(|e| airport.edges.get(e)).map(|e| e.width_m);
        let half_m = width_m.map_or(HALF_WIDTH_M, |w| 0.5 * w).clamp(4.0, 30.0);
        let right = Vector2::new(along.y, -along.x).normalize() * half_m;
        let near = |p: Point2<f64>| (p - node.at_m).norm() < 1.0;
        let cat3 = airport
            .details
            .cat3_holds
            .iter()
            .any(|i| airport.nodes.get(*i).is_some_and(|n| near(n.position_m)));
        let ends_m = [node.at_m - right, node.at_m + right].map(|p| [p.x, p.y]);
        lines.push(HoldLine { runway: runway.names.join("/"), ends_m, cat3 });
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::center;

    #[test]
    fn every_line_lies_across_a_way_and_beside_its_runway() {
        for name in ["zurich", "eham", "egcc", "xsyn"] {
            let scene = scenarios::load_without_truth(&scenarios::locate(name)).expect("shipped");
            let airport = &scene.airport.layout;
            let lines = of(airport);
            assert!(lines.len() >= 2 * airport.runways.len(), "{name}: {} lines", lines.len());
            for line in &lines {
                let [a, b] = line.ends_m.map(|[x, y]| Point2::new(x, y));
                let (middle, length_m) = (center(&a, &b), (b - a).norm());
                assert!((8.0..=60.0).contains(&length_m), "{name}: {length_m} m");
                let runway = airport.runways.iter().find(|r| r.names.join("/") == line.runway);
                let runway = runway.expect("of a runway that is there");
                let off_m = runway.distance_m(middle);
                assert!(off_m < 400.0, "{name}: {off_m} m from {}", line.runway);
            }
        }
    }
}
