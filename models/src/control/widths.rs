//! Whether a cleared way or runway is wide enough for a type, by the code letters of what it leads over.

use super::layout::RunwayAxis;
use crate::airport::distance_to_segment_m;
use crate::frames::Point2;
use crate::traffic::network::Network;

/// Least width of a runway by code letter, A to F, m (Annex 14 of ICAO, from memory: the least of its code numbers). Nobody is smaller
/// than A: a runway of 10 m that is used at all is wide enough for it.
const LEAST_RUNWAY_M: [f64; 6] = [0.0, 18.0, 30.0, 45.0, 45.0, 45.0];
/// Widths in files are rounded, m.
const ROUNDED_M: f64 = 1.0;
/// A point of a way is on every edge that is nearer than this, m (assumed): at junctions the widest counts.
const ON_EDGE_M: f64 = 12.0;
/// So many points in a row lie on edges that are too narrow (assumed; points of a cleared way are 8 m apart).
const IN_A_ROW: usize = 3;

/// Whether a runway is too narrow for a code letter, 0 (A) to 5 (F).
#[must_use]
pub fn runway_is_narrow(runway: &RunwayAxis, code: u8) -> bool {
    runway.width_m + ROUNDED_M < LEAST_RUNWAY_M[usize::from(code.min(5))]
}

/// Whether a way leads over edges that are too narrow for a code letter, 0 (A) to 5 (F).
#[must_use]
pub fn way_is_narrow(network: &Network, code: u8, way_m: &[Point2<f64>]) -> bool {
    let ends = |e: &crate::traffic::network::NetEdge| e.nodes.map(|n| network.nodes[n].at_m);
    let narrow = |p: &Point2<f64>| {
        let on = network.edges.iter().filter(|e| {
            let [a, b] = ends(e);
            distance_to_segment_m(*p, a, b) < ON_EDGE_M
        });
        on.map(|e| e.code).max().is_some_and(|widest| widest < code)
    };
    let mut row = 0;
    way_m.iter().any(|p| {
        row = if narrow(p) { row + 1 } else { 0 };
        row >= IN_A_ROW
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airport::{Airport, Edge, EdgeDetail, Hold, Node};

    fn runway(width_m: f64) -> RunwayAxis {
        let ends = [Point2::new(0.0, 0.0), Point2::new(2000.0, 0.0)];
        RunwayAxis::new(["09".into(), "27".into()], ends, width_m, 90.0).expect("an axis")
    }

    #[test]
    fn a_runway_is_wide_enough_for_its_letters_and_those_below() {
        for (width_m, widest) in
            [(9.0, 0), (18.0, 1), (23.0, 1), (29.5, 2), (30.0, 2), (44.0, 5), (45.0, 5)]
        {
            for code in 0..6 {
                assert_eq!(
                    runway_is_narrow(&runway(width_m), code),
                    code > widest,
                    "{width_m} {code}"
                );
            }
        }
    }

    /// A taxiway of code C meets one of code E: only who follows the narrow one is on it.
    #[test]
    fn a_way_is_narrow_where_it_follows_a_narrow_edge_not_where_it_crosses_one() {
        let mut airport = Airport::default();
        for (x, y) in [(0.0, 0.0), (200.0, 0.0), (400.0, 0.0), (200.0, 200.0)] {
            let name = format!("{x} {y}");
            let position_m = Point2::new(x, y);
            airport.nodes.push(Node { name, position_m, hold: Hold::None });
        }
        for (from, to, code) in [(0, 1, 'E'), (1, 2, 'E'), (1, 3, 'C')] {
            let name = code.to_string();
            airport.edges.push(Edge {
                from,
                to,
                two_way: true,
                runway: false,
                name,
                width_m: 23.0,
            });
            airport.details.edges.push(EdgeDetail { code: Some(code), zones: Vec::new() });
        }
        let network = Network::of(&airport);
        let line = |a: [f64; 2], b: [f64; 2]| -> Vec<Point2<f64>> {
            let at = |i: i32, k: usize| a[k] + (b[k] - a[k]) * f64::from(i) / 25.0;
            (0..=25).map(|i| Point2::new(at(i, 0), at(i, 1))).collect()
        };
        let straight = [line([0.0, 0.0], [200.0, 0.0]), line([200.0, 0.0], [400.0, 0.0])].concat();
        let aside = [line([0.0, 0.0], [200.0, 0.0]), line([200.0, 0.0], [200.0, 200.0])].concat();
        for (code, way, narrow) in
            [(4, &straight, false), (2, &aside, false), (3, &aside, true), (5, &straight, true)]
        {
            assert_eq!(way_is_narrow(&network, code, way), narrow, "{code}");
        }
        // Off every edge nobody can tell.
        assert!(!way_is_narrow(&network, 5, &line([0.0, 900.0], [400.0, 900.0])));
    }
}
