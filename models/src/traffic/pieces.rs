//! Pieces of edges, what movers of a class can cover while they are on them, and which pieces conflict.
//!
//! The area of a piece is made of convex quadrilaterals: a flat-ended band along the edge, the half arcs of
//! the fillets at its ends, and on the inside of bends the cut-in of the main gear.

use super::network::Network;
use super::outline::overlap_depth_m;
use super::path::{KINK_RAD, fillet_radius_m};
use super::tractrix;
use super::ways::SHARPEST_TURN_DEG;
use crate::frames::{Azimuth, Point2, Vector2, wrap_pi};
use std::collections::BTreeMap;

/// Class of a mover: 0 vehicle, 1 to 6 aircraft of code letter A to F.
pub type Class = u8;
/// Number of classes.
pub const CLASSES: usize = 7;

/// What is assumed of a class: greatest span, length and wheelbase, fillet radius, m.
#[derive(Clone, Copy, Debug)]
pub struct ClassSize {
    /// Half of the greatest span.
    pub half_span_m: f64,
    /// Greatest length.
    pub length_m: f64,
    /// Greatest distance from guided point to main gear.
    pub wheelbase_m: f64,
    /// Wanted radius of fillets.
    pub fillet_m: f64,
}

/// Sizes by class (spans: Annex 14 code letters; the rest assumed).
pub const SIZES: [ClassSize; CLASSES] = [
    ClassSize { half_span_m: 3.0, length_m: 14.0, wheelbase_m: 8.0, fillet_m: 12.0 },
    ClassSize { half_span_m: 7.5, length_m: 14.0, wheelbase_m: 6.0, fillet_m: 20.0 },
    ClassSize { half_span_m: 12.0, length_m: 34.0, wheelbase_m: 18.0, fillet_m: 30.0 },
    ClassSize { half_span_m: 18.0, length_m: 45.0, wheelbase_m: 17.0, fillet_m: 30.0 },
    ClassSize { half_span_m: 26.0, length_m: 56.0, wheelbase_m: 23.0, fillet_m: 45.0 },
    ClassSize { half_span_m: 32.5, length_m: 76.0, wheelbase_m: 32.0, fillet_m: 45.0 },
    ClassSize { half_span_m: 40.0, length_m: 77.0, wheelbase_m: 33.0, fillet_m: 60.0 },
];

/// Fillets at stands, m: of vehicles and code A half as wide (assumed).
const STAND_FILLET_M: [f64; CLASSES] = [12.0, 12.0, 25.0, 25.0, 25.0, 25.0, 25.0];
/// Radius wanted at exits of at most 60 degrees, m (assumed: 25 m/s at 1.2 m/s²).
pub const RAPID_EXIT_M: f64 = 500.0;
/// Longest piece, m, and longest piece of a lead-in.
const LONGEST_M: f64 = 45.0;
const LONGEST_AT_STAND_M: f64 = 6.0;
/// Margin around a body on taxiways and at stands, m; two bodies keep twice that.
const MARGIN_M: f64 = 2.0;
const STAND_MARGIN_M: f64 = 1.5;
/// Areas that overlap less deeply than this do not conflict, m.
const DEPTH_M: f64 = 0.3;

/// A piece of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its edge.
    pub edge: usize,
    /// Begin along the edge, m from its first node.
    pub from_m: f64,
    /// End.
    pub to_m: f64,
    /// Between runway and holding positions.
    pub strip: Option<usize>,
    /// On the centreline of a runway.
    pub runway: Option<usize>,
    /// Another runway over whose pavement it leads, in this strip.
    pub over: Option<usize>,
}

impl Piece {
    /// Neither in the strip of a runway nor on its centreline.
    #[must_use]
    pub fn off_strip(&self) -> bool {
        self.strip.is_none() && self.runway.is_none()
    }
}

/// Half a fillet at the end of an edge.
#[derive(Clone, Copy, Debug)]
struct HalfFillet {
    radius_m: f64,
    turn_rad: f64,
    /// +1 to the right when driven towards the node, else −1.
    side: f64,
    cut_in_m: f64,
}

/// All pieces of a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pieces {
    /// The pieces.
    pub list: Vec<Piece>,
    /// First piece and number of pieces by edge, from its first node on.
    pub of_edge: Vec<(usize, usize)>,
    /// By class and piece: conflicting pieces and from which class on.
    conflicts: Vec<Vec<Vec<(u32, Class)>>>,
    /// By class: pieces that lie in the strip beside each spine piece, for a roll.
    strip_of: BTreeMap<usize, Vec<u32>>,
    /// By stand and class: length of the straight line that ends at its node, m.
    straight_m: Vec<[f64; CLASSES]>,
}

/// A runway other than `own` over whose pavement a part of an edge leads, m from its first node.
fn over(net: &Network, edge: usize, own: usize, [from_m, to_m]: [f64; 2]) -> Option<usize> {
    let [a, b] = net.edges[edge].nodes.map(|n| net.nodes[n].at_m);
    let length_m = net.length_m(edge).max(1e-9);
    let points = [from_m, 0.5 * (from_m + to_m), to_m].map(|m| a + (b - a) * (m / length_m));
    (0..net.runways.len()).filter(|r| *r != own).find(|r| {
        let runway = &net.runways[*r];
        points.iter().any(|at_m| {
            let (along_m, off_m) = runway.place_m(*at_m);
            (0.0..=runway.length_m).contains(&along_m) && off_m.abs() <= 0.5 * runway.width_m
        })
    })
}

type Quad = [Point2<f64>; 4];

impl Pieces {
    /// Pieces of a network, and their conflicts for movers of these classes.
    #[must_use]
    pub fn of(net: &Network, classes: &[Class]) -> Self {
        let mut pieces = Self::default();
        for (index, edge) in net.edges.iter().enumerate() {
            let length = net.length_m(index);
            let stand = edge.nodes.iter().any(|n| net.nodes[*n].stand.is_some());
            let most = if stand { LONGEST_AT_STAND_M } else { LONGEST_M };
            let count = (length / most).ceil().max(1.0) as usize;
            pieces.of_edge.push((pieces.list.len(), count));
            for k in 0..count {
                let at = |k: usize| length * k as f64 / count as f64;
                let (strip, runway) = (edge.strip, edge.runway);
                let over = strip.and_then(|own| over(net, index, own, [at(k), at(k + 1)]));
                pieces.list.push(Piece {
                    edge: index,
                    from_m: at(k),
                    to_m: at(k + 1),
                    strip,
                    runway,
                    over,
                });
            }
        }
        let mut at_node = vec![Vec::new(); net.nodes.len()];
        for (index, edge) in net.edges.iter().enumerate() {
            edge.nodes.iter().for_each(|n| at_node[*n].push(index));
        }
        pieces.straight_m = (0..net.stands.len()).map(|s| straight_m(net, &at_node, s)).collect();
        pieces.conflicts = vec![Vec::new(); CLASSES];
        let mut areas: Vec<Vec<Vec<Quad>>> = vec![Vec::new(); CLASSES];
        for class in classes {
            areas[*class as usize] =
                (0..pieces.list.len()).map(|z| pieces.area(net, &at_node, z, *class)).collect();
        }
        pieces.relate(&areas, classes);
        pieces.strips(net);
        pieces
    }

    /// Pieces that conflict with `piece` for a mover of `class`, each with the least class of the other.
    #[must_use]
    pub fn conflicts(&self, piece: usize, class: Class) -> &[(u32, Class)] {
        self.conflicts[class as usize].get(piece).map_or(&[], Vec::as_slice)
    }

    /// The smallest class that is at least this one and of which conflicts are known.
    #[must_use]
    pub fn class_for(&self, class: Class) -> Option<Class> {
        (class..CLASSES as Class).find(|c| !self.conflicts[*c as usize].is_empty())
    }

    /// Length of the straight line that ends at the node of a stand, whichever way one comes into its lead-in, m; 0 without one.
    #[must_use]
    pub fn straight_to_m(&self, stand: usize, class: Class) -> f64 {
        self.straight_m.get(stand).map_or(0.0, |by_class| by_class[class as usize])
    }

    /// Pieces beside a spine piece that have to be empty while somebody rolls over it.
    #[must_use]
    pub fn strip_beside(&self, piece: usize) -> &[u32] {
        self.strip_of.get(&piece).map_or(&[], Vec::as_slice)
    }

    fn half_fillets(
        &self,
        net: &Network,
        at_node: &[Vec<usize>],
        edge: usize,
        node: usize,
        class: Class,
    ) -> Vec<HalfFillet> {
        let size = &SIZES[class as usize];
        let other_end = |e: usize| {
            let [a, b] = net.edges[e].nodes;
            if a == node { b } else { a }
        };
        let here = net.nodes[node].at_m;
        let heading = Azimuth::of(here - net.nodes[other_end(edge)].at_m).rad();
        let mut fillets = Vec::new();
        for next in at_node[node].iter().filter(|e| **e != edge) {
            let turn =
                wrap_pi(Azimuth::of(net.nodes[other_end(*next)].at_m - here).rad() - heading);
            if turn.abs() <= KINK_RAD || turn.abs() > SHARPEST_TURN_DEG.to_radians() {
                continue;
            }
            let wanted = wanted_radius_m(net, edge, *next, turn, class);
            let radius_m =
                fillet_radius_m(wanted, turn, net.length_m(edge), net.length_m(*next)).max(0.5);
            let slip = tractrix::slip_on_arc_rad(radius_m * turn.abs(), radius_m, size.wheelbase_m);
            // Gear and wing run inside by what has built up until the end of the arc.
            let lag = tractrix::lag_m(slip, size.wheelbase_m).abs();
            let cut_in_m = tractrix::cut_in_m(slip, radius_m, size.wheelbase_m).max(0.35 * lag);
            fillets.push(HalfFillet {
                radius_m,
                turn_rad: turn.abs(),
                side: turn.signum(),
                cut_in_m,
            });
        }
        fillets
    }

    fn at_stand(&self, net: &Network, edge: usize) -> bool {
        net.edges[edge].nodes.iter().any(|n| net.nodes[*n].stand.is_some())
    }

    /// What bodies of a class can cover whose foot on the way is in the piece.
    fn area(&self, net: &Network, at_node: &[Vec<usize>], piece: usize, class: Class) -> Vec<Quad> {
        let Piece { edge, from_m, to_m, .. } = self.list[piece];
        let size = &SIZES[class as usize];
        let nodes = net.edges[edge].nodes;
        let [a, b] = nodes.map(|n| net.nodes[n].at_m);
        let length = (b - a).norm().max(1e-6);
        let margin = if self.at_stand(net, edge) { STAND_MARGIN_M } else { MARGIN_M };
        let half = size.half_span_m + margin;
        let mut quads = Vec::new();
        for end in 0..2 {
            // Coordinates: x towards the node, from it backwards negative; y to the right.
            let (origin, towards) =
                if end == 1 { (b, (b - a) / length) } else { (a, (a - b) / length) };
            let right = Vector2::new(towards.y, -towards.x);
            let at = |x: f64, y: f64| origin + towards * x + right * y;
            let (low, high) =
                if end == 1 { (from_m - length, to_m - length) } else { (-to_m, -from_m) };
            if end == 1 {
                quads.push([at(low, -half), at(low, half), at(high, half), at(high, -half)]);
            }
            let node = nodes[end];
            if net.nodes[node].stand.is_some() && high > -0.5 {
                // A parked aircraft has its middle here: wing a little, nose half a length beyond.
                let (wing, nose) = (0.05 * size.length_m + 1.0, 0.5 * size.length_m + 1.5);
                let narrow = (0.06 * size.length_m + 1.5).max(size.half_span_m.min(3.0));
                quads.push([at(0.0, -half), at(0.0, half), at(wing, half), at(wing, -half)]);
                quads.push([
                    at(0.0, -narrow),
                    at(0.0, narrow),
                    at(nose, narrow),
                    at(nose, -narrow),
                ]);
                continue;
            }
            for f in self.half_fillets(net, at_node, edge, node, class) {
                let tangent = f.radius_m * libm::tan(0.5 * f.turn_rad);
                let steps = (0.5 * f.turn_rad / 0.15).ceil().max(1.0) as usize;
                let inner = (half + f.cut_in_m).min(half + size.half_span_m);
                for k in 0..steps {
                    let phi = |k: usize| 0.5 * f.turn_rad * k as f64 / steps as f64;
                    let x = |phi: f64| -tangent + f.radius_m * libm::sin(phi);
                    let (p, q) = (phi(k), phi(k + 1));
                    // Part of the piece on whose stretch of the edge the arc lies; the node end has the rest.
                    let beyond = if high > -1e-6 { f64::INFINITY } else { high };
                    if x(q) < low || x(p) >= beyond {
                        continue;
                    }
                    let corner = |phi: f64, off: f64| {
                        let (sin, cos) = libm::sincos(phi);
                        let y = f.radius_m * (1.0 - cos);
                        // Normal of the arc, positive to the inside.
                        at(x(phi) - off * sin, f.side * (y + off * cos))
                    };
                    quads.push([
                        corner(p, -half),
                        corner(p, inner),
                        corner(q, inner),
                        corner(q, -half),
                    ]);
                }
                // The gear is still inside for a while before (when driven the other way: after) the arc.
                let reach = -tangent - 0.25 * size.length_m;
                let (strip_low, strip_high) = (low.max(reach), high.min(-tangent));
                if strip_high > strip_low && f.cut_in_m > 0.1 {
                    let y = |off: f64| f.side * off;
                    quads.push([
                        at(strip_low, 0.0),
                        at(strip_low, y(inner)),
                        at(strip_high, y(inner)),
                        at(strip_high, 0.0),
                    ]);
                }
            }
        }
        quads.into_iter().map(hull).collect()
    }

    fn relate(&mut self, areas: &[Vec<Vec<Quad>>], classes: &[Class]) {
        let mut sorted: Vec<Class> = classes.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        let Some(largest) = sorted.last().copied() else { return };
        let count = self.list.len();
        for class in &sorted {
            self.conflicts[*class as usize] = (0..count).map(|z| vec![(z as u32, 0)]).collect();
        }
        let boxes: Vec<[f64; 4]> =
            areas[largest as usize].iter().map(|quads| bounds(quads)).collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|p, q| boxes[*p][0].total_cmp(&boxes[*q][0]).then(p.cmp(q)));
        for (i, z) in order.iter().enumerate() {
            for y in &order[i + 1..] {
                if boxes[*y][0] > boxes[*z][2] {
                    break;
                }
                let (p, q) = (boxes[*z], boxes[*y]);
                if p[1] > q[3] || q[1] > p[3] {
                    continue;
                }
                // The larger the one, the smaller the other may be: a staircase of the classes.
                let mut other = sorted.len();
                for class in &sorted {
                    while other > 0
                        && overlaps(
                            &areas[*class as usize][*z],
                            &areas[sorted[other - 1] as usize][*y],
                        )
                    {
                        other -= 1;
                    }
                    if let Some(least) = sorted.get(other) {
                        self.conflicts[*class as usize][*z].push((*y as u32, *least));
                    }
                }
                let mut other = sorted.len();
                for class in &sorted {
                    while other > 0
                        && overlaps(
                            &areas[sorted[other - 1] as usize][*z],
                            &areas[*class as usize][*y],
                        )
                    {
                        other -= 1;
                    }
                    if let Some(least) = sorted.get(other) {
                        self.conflicts[*class as usize][*y].push((*z as u32, *least));
                    }
                }
            }
        }
        for lists in &mut self.conflicts {
            lists.iter_mut().for_each(|l| l.sort_unstable());
        }
    }

    /// For each spine piece, the pieces of its strip that lie beside it.
    fn strips(&mut self, net: &Network) {
        let in_strips: Vec<(usize, &Piece)> =
            self.list.iter().enumerate().filter(|(_, p)| p.strip.is_some()).collect();
        for (z, piece) in self.list.iter().enumerate() {
            let Some(r) = piece.runway else { continue };
            let runway = &net.runways[r];
            let centre = |p: &Piece, share: f64| {
                let [a, b] = net.edges[p.edge].nodes.map(|n| net.nodes[n].at_m);
                a + (b - a) * ((p.from_m + (p.to_m - p.from_m) * share) / (b - a).norm().max(1e-9))
            };
            let mine = [0.0, 1.0].map(|s| runway.place_m(centre(piece, s)).0);
            let (low, high) = (mine[0].min(mine[1]) - 60.0, mine[0].max(mine[1]) + 60.0);
            let beside = in_strips.iter().filter(|(y, other)| {
                *y != z
                    && [0.0, 0.5, 1.0].iter().any(|s| {
                        let (along, off) = runway.place_m(centre(other, *s));
                        along > low && along < high && off.abs() < runway.hold_distance_m - 5.0
                    })
            });
            self.strip_of.insert(z, beside.map(|(y, _)| *y as u32).collect());
        }
    }
}

/// Radius wanted between two edges, m: wide at rapid exits of runways, small at stands. In a bend of more than a right angle so
/// small that its arc stays as near to the corner as in that: pavement is filled up no farther (assumed); never less than a
/// wheelbase.
#[must_use]
pub fn wanted_radius_m(
    net: &Network,
    edge: usize,
    next: usize,
    turn_rad: f64,
    class: Class,
) -> f64 {
    let size = &SIZES[class as usize];
    let inside = |turn_rad: f64| 1.0 - libm::cos(0.5 * turn_rad);
    let sharp = inside(std::f64::consts::FRAC_PI_2) / inside(turn_rad.abs()).max(1e-9);
    let wanted = size.fillet_m.min((size.fillet_m * sharp).max(size.wheelbase_m));
    let at_stand = |e: usize| net.edges[e].nodes.iter().any(|n| net.nodes[*n].stand.is_some());
    if at_stand(edge) || at_stand(next) {
        return wanted.min(STAND_FILLET_M[class as usize]);
    }
    let on_runway = |e: usize| net.edges[e].runway.is_some();
    let rapid = on_runway(edge) != on_runway(next) && turn_rad.abs() < 61_f64.to_radians();
    if rapid {
        return RAPID_EXIT_M;
    }
    // A gentle bend is driven in a wide arc that cuts the corner by no more than this.
    let cut = 1.0 / libm::cos(0.5 * turn_rad.abs().min(2.0)) - 1.0;
    wanted.max((GENTLE_CUT_M / cut.max(1e-9)).min(RAPID_EXIT_M))
}

/// By class: what the fillet at the other end leaves of the edge that leads to a stand, m.
fn straight_m(net: &Network, at_node: &[Vec<usize>], stand: usize) -> [f64; CLASSES] {
    let mut left_m = [0.0; CLASSES];
    let Some(node) = net.stands[stand].node else { return left_m };
    let [edge] = at_node[node][..] else { return left_m };
    let other_end =
        |e: usize, n: usize| net.edges[e].nodes[usize::from(net.edges[e].nodes[0] == n)];
    let heading = |from: usize, to: usize| Azimuth::of(net.nodes[to].at_m - net.nodes[from].at_m);
    let bend = other_end(edge, node);
    for (class, left_m) in left_m.iter_mut().enumerate() {
        let before = at_node[bend].iter().filter(|e| **e != edge).map(|before| {
            let turn = heading(bend, node).rad() - heading(other_end(*before, bend), bend).rad();
            let turn = wrap_pi(turn);
            if turn.abs() > SHARPEST_TURN_DEG.to_radians() {
                return 0.0;
            }
            let wanted_m = wanted_radius_m(net, *before, edge, turn, class as Class);
            let radius_m =
                fillet_radius_m(wanted_m, turn, net.length_m(*before), net.length_m(edge));
            radius_m * libm::tan(0.5 * turn.abs())
        });
        *left_m = net.length_m(edge) - before.fold(0.0, f64::max);
    }
    left_m
}

/// How far an arc through a gentle bend may be from its corner, m (assumed).
const GENTLE_CUT_M: f64 = 1.0;

/// The corners in convex order: a folded quadrilateral (inside of a sharp arc) becomes its hull or a part
/// of it that is not smaller than its diagonals.
fn hull(quad: Quad) -> Quad {
    let [a, b, c, d] = quad.map(|corner| corner.coords);
    let centre = (a + b + c + d) * 0.25;
    let mut sorted = quad;
    sorted.sort_by(|p, q| {
        let angle = |v: &Point2<f64>| libm::atan2(v.y - centre.y, v.x - centre.x);
        angle(p).total_cmp(&angle(q))
    });
    sorted
}

fn bounds(quads: &[Quad]) -> [f64; 4] {
    let mut found = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for p in quads.iter().flatten() {
        found = [found[0].min(p.x), found[1].min(p.y), found[2].max(p.x), found[3].max(p.y)];
    }
    found
}

fn overlaps(a: &[Quad], b: &[Quad]) -> bool {
    let near = |p: &Quad, q: &Quad| {
        let (p, q) = (bounds(&[*p]), bounds(&[*q]));
        p[0] <= q[2] && q[0] <= p[2] && p[1] <= q[3] && q[1] <= p[3]
    };
    a.iter().any(|p| b.iter().any(|q| near(p, q) && overlap_depth_m(p, q) > DEPTH_M))
}
