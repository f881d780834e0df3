//! How far movers are from the ground network.

use super::{Breaches, Row, Rules, Seen};
use crate::airport::{Airport, distance_to_segment_m};
use crate::frames::{Azimuth, Point2};
use crate::traffic::path::Path;
use crate::traffic::ways::SHARPEST_TURN_DEG;
use std::collections::BTreeMap;

/// Lines of the network in squares.
#[derive(Clone, Debug)]
pub(super) struct Pavement {
    lines: Vec<[Point2<f64>; 2]>,
    squares: BTreeMap<(i64, i64), Vec<u32>>,
    off: Breaches,
    /// Who is off now, so that one excursion is one case.
    outside: BTreeMap<usize, f64>,
}

/// Side of a square, m.
const SQUARE_M: f64 = 100.0;
/// Longest chord of an arc, m: 0.3 m off it at 30 m of radius.
const CHORD_M: f64 = 8.0;
/// Longest lead-in that is made up, m.
const LEAD_IN_M: f64 = 150.0;

fn square(at: Point2<f64>) -> (i64, i64) {
    ((at.x / SQUARE_M).floor() as i64, (at.y / SQUARE_M).floor() as i64)
}

/// Radius of a fillet between edges of a code letter, m (R9, assumed); of unknown ones that of a 23 m wide taxiway.
fn fillet_m(code: Option<char>) -> f64 {
    match code {
        Some('A'..='C') => 30.0,
        Some('F') => 60.0,
        _ => 45.0,
    }
}

/// Lines of the arcs over the bends of a network: the centreline of an edge ends where the arc to the next one begins.
fn fillets(airport: &Airport) -> Vec<[Point2<f64>; 2]> {
    let at = |n: usize| airport.nodes[n].position_m;
    let code = |e: usize| airport.details.edges.get(e).and_then(|d| d.code);
    let mut at_node: Vec<Vec<usize>> = vec![Vec::new(); airport.nodes.len()];
    for (e, edge) in airport.edges.iter().enumerate().filter(|(_, e)| e.from != e.to) {
        at_node[edge.from].push(e);
        at_node[edge.to].push(e);
    }
    let mut lines = Vec::new();
    for (n, edges) in at_node.iter().enumerate() {
        let other = |e: usize| airport.edges[e].from + airport.edges[e].to - n;
        for (i, first) in edges.iter().enumerate() {
            for second in &edges[i + 1..] {
                let line = [at(other(*first)), at(n), at(other(*second))];
                let wanted_m = fillet_m(code(*first)).min(fillet_m(code(*second)));
                let driven = |turn: f64| turn.abs() <= SHARPEST_TURN_DEG.to_radians();
                let (path, _) =
                    Path::over(&line, |_, turn| if driven(turn) { wanted_m } else { 0.0 });
                for (from_m, to_m, _) in path.arcs() {
                    let count = ((to_m - from_m) / CHORD_M).ceil().max(1.0);
                    let point = |k: f64| path.at(from_m + (to_m - from_m) * k / count).at_m;
                    lines.extend(
                        (0..count as usize).map(|k| [point(k as f64), point(k as f64 + 1.0)]),
                    );
                }
            }
        }
    }
    lines
}

impl Pavement {
    /// Edges, their fillets, centrelines, service roads, and from each stand the line to the nearest edge that it heads away from (else to
    /// the nearest of all) and is not the lead-in of a stand.
    pub(super) fn of(airport: &Airport) -> Self {
        let at = |n: usize| airport.nodes[n].position_m;
        let mut lines: Vec<[Point2<f64>; 2]> =
            airport.edges.iter().map(|e| [at(e.from), at(e.to)]).collect();
        let of_stand =
            |p: Point2<f64>| airport.stands.iter().any(|s| (s.position_m - p).norm() < 2.0);
        let lanes = lines.iter().filter(|l| !l.iter().any(|p| of_stand(*p)));
        let edges: Vec<[Point2<f64>; 2]> = lanes.copied().collect();
        for stand in &airport.stands {
            let p = stand.position_m;
            let ahead = Azimuth::from_rad(stand.heading_rad).unit();
            let foot = |[a, b]: &[Point2<f64>; 2]| {
                let along = b - a;
                let share = (p - a).dot(&along) / along.norm_squared().max(1e-9);
                a + along * share.clamp(0.0, 1.0)
            };
            let feet = edges.iter().map(foot);
            let key = |f: &Point2<f64>| ((p - f).dot(&ahead) < 0.0, (f - p).norm());
            let nearest = feet.filter(|f| (f - p).norm() <= LEAD_IN_M).min_by(|a, b| {
                let (a, b) = (key(a), key(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            lines.extend(nearest.map(|f| [p, f]));
        }
        lines.extend(fillets(airport));
        lines.extend(airport.runways.iter().map(|r| r.ends_m));
        lines.extend(airport.details.roads.iter().map(|(ends_m, _)| *ends_m));
        let mut squares: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
        for (i, [a, b]) in lines.iter().enumerate() {
            let count = ((b - a).norm() / (0.5 * SQUARE_M)).ceil().clamp(1.0, 10_000.0) as usize;
            let mut last = None;
            for k in 0..=count {
                let (x, y) = square(a + (b - a) * (k as f64 / count as f64));
                if last == Some((x, y)) {
                    continue;
                }
                last = Some((x, y));
                for near in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
                    let here = squares.entry(near).or_default();
                    if here.last() != Some(&(i as u32)) {
                        here.push(i as u32);
                    }
                }
            }
        }
        Self { lines, squares, off: Breaches::default(), outside: BTreeMap::new() }
    }

    /// Distance from the network, m; infinite beyond a square.
    fn distance_m(&self, at: Point2<f64>) -> f64 {
        let near = self.squares.get(&square(at)).map_or(&[][..], |v| &v[..]);
        let each = near.iter().map(|i| {
            let [a, b] = self.lines[*i as usize];
            distance_to_segment_m(at, a, b)
        });
        each.fold(f64::INFINITY, f64::min)
    }

    pub(super) fn look(
        &mut self,
        rules: &Rules,
        time_s: f64,
        s: &Seen,
        name: &str,
        on_runway: bool,
    ) {
        self.off.of += 1;
        let at = s.position_m.xy();
        let distance_m = if on_runway { 0.0 } else { self.distance_m(at) };
        if distance_m <= rules.pavement_m {
            return;
        }
        let before = self.outside.insert(s.who, time_s);
        if before.is_none_or(|t| time_s - t > 5.0) && self.off.cases.len() < super::MOST_CASES {
            let (x, y, v) = (at.x, at.y, s.velocity_mps.norm());
            let text = format!(
                "{name} {distance_m:.1} m off at {time_s:.1} s, at {x:.0} {y:.0}, {v:.1} m/s"
            );
            self.off.cases.push(text);
        }
        self.off.count += 1;
    }

    pub(super) fn row(self, rules: &Rules) -> Row {
        let value = 1.0 - self.off.count as f64 / self.off.of.max(1) as f64;
        let goal = format!("at least {}", rules.pavement_share);
        let kept = value >= rules.pavement_share;
        Row { name: "pavement", value, goal, kept, of: self.off.of, cases: self.off.cases }
    }
}
