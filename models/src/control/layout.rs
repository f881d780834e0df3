//! The parts of an airport that the safety net looks at: runways as axes, where they cross, protected areas.

use crate::airport::Airport;
pub use crate::airport::{Area, AreaKind};
use crate::frames::{Point2, Vector2};
use crate::time::SimTime;
use crate::traffic::network::{NetEdge, Network};

/// A runway as an axis from its first end. Airport frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RunwayAxis {
    /// Designators of both ends.
    pub names: [String; 2],
    /// First end.
    pub origin_m: Point2<f64>,
    /// Unit vector to the other end.
    pub along: Vector2<f64>,
    /// Length, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Distance of the holding positions from the centreline, m.
    pub hold_m: f64,
    /// Displacement of the landing thresholds from the ends, m.
    pub displaced_m: [f64; 2],
    /// Closed to all traffic for these times: from, until.
    pub closed: Vec<[SimTime; 2]>,
    /// Half width of the strip in steps of 50 m along the axis, left and right of it, m; empty: `hold_m`.
    pub strips_m: Vec<[f64; 2]>,
    /// From the ends to the holding position of those who enter along the axis, m; infinite where nobody does.
    pub ends_held_m: [f64; 2],
}

/// The place of one who is pushed back onto a lane comes so far past its line, m, before it is on it (assumed: an A333 at Boeing Field and
/// an A320 at Brainerd 10 m).
const SWING_M: f64 = 15.0;

/// Length of one step of [`RunwayAxis::strips_m`], m.
const STEP_M: f64 = 50.0;

impl RunwayAxis {
    /// The axis between two ends; `None` if they are nearer than 1 m or not finite.
    #[must_use]
    pub fn new(
        names: [String; 2],
        ends_m: [Point2<f64>; 2],
        width_m: f64,
        hold_m: f64,
    ) -> Option<Self> {
        let whole = ends_m[1] - ends_m[0];
        let length_m = libm::hypot(whole.x, whole.y);
        (length_m.is_finite() && length_m > 1.0).then(|| Self {
            names,
            origin_m: ends_m[0],
            along: whole / length_m,
            length_m,
            width_m,
            hold_m,
            displaced_m: [0.0; 2],
            closed: Vec::new(),
            strips_m: Vec::new(),
            ends_held_m: [f64::INFINITY; 2],
        })
    }

    /// Place along the axis from the first end, and distance to the right of it, m.
    #[must_use]
    #[inline]
    pub fn place_m(&self, point_m: Point2<f64>) -> (f64, f64) {
        let from = point_m - self.origin_m;
        (from.dot(&self.along), from.x * self.along.y - from.y * self.along.x)
    }

    /// Distance at which one holds beside this place, on its side, m.
    #[must_use]
    #[inline]
    pub fn hold_at_m(&self, place_m: f64, across_m: f64) -> f64 {
        if self.strips_m.is_empty() {
            return self.hold_m;
        }
        let step = (place_m / STEP_M).clamp(0.0, (self.strips_m.len() - 1) as f64) as usize;
        self.strips_m[step][usize::from(across_m > 0.0)]
    }

    /// Speed along the axis, m/s, positive from the first end.
    #[must_use]
    #[inline]
    pub fn along_mps(&self, velocity_mps: Vector2<f64>) -> f64 {
        velocity_mps.dot(&self.along)
    }

    /// Speed across the axis, m/s, positive to the right of it.
    #[must_use]
    #[inline]
    pub fn across_mps(&self, velocity_mps: Vector2<f64>) -> f64 {
        velocity_mps.x * self.along.y - velocity_mps.y * self.along.x
    }

    /// Whether it is closed at a time.
    #[must_use]
    pub fn is_closed(&self, at: SimTime) -> bool {
        self.closed.iter().any(|[from, until]| (*from..*until).contains(&at))
    }

    /// Which end is called `name`.
    #[must_use]
    pub fn end(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }
}

/// Where two runways cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Both runways.
    pub runways: [usize; 2],
    /// Its place along each, m.
    pub places_m: [f64; 2],
}

/// A stop bar across an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopBar {
    /// Runway.
    pub runway: usize,
    /// Place along its axis from the first end, m.
    pub place_m: f64,
    /// Distance from the centreline, m; positive on the right of the axis. `None`: the runway's, on both sides.
    pub across_m: Option<f64>,
    /// Place along the axis at which the taxiway behind it enters the runway, m.
    pub entry_m: f64,
    /// Lit.
    pub lit: bool,
}

/// What of an airport does not change from scan to scan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Runways.
    pub runways: Vec<RunwayAxis>,
    /// Pairs that cross.
    pub crossings: Vec<Crossing>,
    /// Protected areas.
    pub areas: Vec<Area>,
    /// Stop bars, lit, at the holding positions of the ground network.
    pub bars: Vec<StopBar>,
    /// Places of the stands of the ground network, m.
    pub stands_m: Vec<Point2<f64>>,
    /// Smallest box around the ground network, m: beyond it nobody taxies. `None`: unknown.
    pub ground_m: Option<[Point2<f64>; 2]>,
}

impl Layout {
    /// The layout of these runways.
    #[must_use]
    pub fn new(runways: Vec<RunwayAxis>) -> Self {
        let mut crossings = Vec::new();
        for a in 0..runways.len() {
            for b in a + 1..runways.len() {
                crossings.extend(crossing(&runways, a, b));
            }
        }
        Self { runways, crossings, ..Self::default() }
    }

    /// The layout of an airport: hold distance 90 m, 40 m for runways under 1 200 m (assumed, as the ground
    /// network does where the file has no holding positions).
    #[must_use]
    pub fn of(airport: &Airport) -> Self {
        let axis = |r: &crate::airport::Runway| {
            let length_m = (r.ends_m[1] - r.ends_m[0]).norm();
            let hold_m = if length_m < 1200.0 { 40.0 } else { 90.0 };
            let mut axis = RunwayAxis::new(r.names.clone(), r.ends_m, r.width_m, hold_m)?;
            let place = |end: usize| axis.place_m(r.thresholds_m[end]).0.clamp(0.0, length_m);
            axis.displaced_m = [place(0), length_m - place(1)];
            axis.closed = airport.details.closed_runways(r).collect();
            (length_m >= 100.0).then_some(axis)
        };
        let mut layout = Self::new(airport.runways.iter().filter_map(axis).collect());
        layout.areas.clone_from(&airport.details.areas);
        let places = || {
            let nodes = airport.nodes.iter().map(|n| n.position_m);
            nodes.chain(airport.stands.iter().map(|s| s.position_m))
        };
        if places().next().is_some() {
            let fold = |f: fn(f64, f64) -> f64, from: f64| {
                places().fold(Point2::new(from, from), |m, p| Point2::new(f(m.x, p.x), f(m.y, p.y)))
            };
            let room = Vector2::new(150.0, 150.0);
            layout.ground_m = Some([
                fold(f64::min, f64::INFINITY) - room,
                fold(f64::max, f64::NEG_INFINITY) + room,
            ]);
        }
        layout
    }

    /// Takes stands, holding positions and taxiways of a ground network in: where each stop bar is, and how far the strip
    /// reaches (to the holding position there, and short of every taxiway that is not within it).
    #[must_use]
    pub fn with_network(mut self, net: &Network) -> Self {
        self.stands_m = net.stands.iter().map(|stand| stand.at_m).collect();
        for (index, node) in net.nodes.iter().enumerate() {
            let Some(of) = node.hold_for.and_then(|r| net.runways.get(r)) else { continue };
            let Some((r, _)) = self.runway(&of.names[0]) else { continue };
            let (place_m, across_m) = self.runways[r].place_m(bar_at_m(net, index));
            // Who enters a runway along its axis holds beyond its end, where no bar is across a way beside it.
            let axis = &mut self.runways[r];
            if across_m.abs() < 0.5 * axis.width_m {
                let beyond_m = [-place_m, place_m - axis.length_m];
                for (held_m, beyond_m) in axis.ends_held_m.iter_mut().zip(beyond_m) {
                    *held_m = if beyond_m > 0.0 { held_m.min(beyond_m) } else { *held_m };
                }
                continue;
            }
            let entry_m = entry_of(net, index, node.hold_for.unwrap_or(0)).unwrap_or(place_m);
            let across_m = short_of_passing_m(net, &self.runways[r], [place_m, across_m]);
            self.bars.push(StopBar {
                runway: r,
                place_m,
                across_m: Some(across_m),
                entry_m,
                lit: true,
            });
        }
        for r in 0..self.runways.len() {
            let steps = (self.runways[r].length_m / STEP_M).ceil() as usize;
            let mut strips = vec![[self.runways[r].hold_m; 2]; steps.max(1)];
            let last = strips.len() - 1;
            let mut least = |place_m: f64, across_m: f64, reach: usize, distance_m: f64| {
                let step = (place_m / STEP_M).clamp(0.0, last as f64) as usize;
                for at in &mut strips[step.saturating_sub(reach)..=(step + reach).min(last)] {
                    let side = &mut at[usize::from(across_m > 0.0)];
                    *side = side.min(distance_m);
                }
            };
            let axis = &self.runways[r];
            for bar in self.bars.iter().filter(|b| b.runway == r) {
                let across_m = bar.across_m.unwrap_or(axis.hold_m);
                least(bar.place_m, across_m, 1, across_m.abs());
            }
            let number = net.runways.iter().position(|n| n.names == axis.names);
            for (index, edge) in
                net.edges.iter().enumerate().filter(|(_, e)| {
                    e.runway.is_none() && e.strip.is_none_or(|s| Some(s) != number)
                })
            {
                // Who is pushed back onto a lane swings past its line.
                let swing_m = if net.is_lane(index) { SWING_M } else { 0.0 };
                let [a, b] = edge.nodes.map(|n| net.nodes[n].at_m);
                let count = ((b - a).norm() / 2.0).ceil().clamp(1.0, 5_000.0) as usize;
                for i in 0..=count {
                    let (s, d) = axis.place_m(a + (b - a) * (i as f64 / count as f64));
                    let beside = (-60.0..=axis.length_m + 60.0).contains(&s);
                    // What touches the runway itself is a crossing that the file does not end with a hold.
                    if beside
                        && d.abs() < axis.hold_m + swing_m
                        && d.abs() > 0.5 * axis.width_m + 15.0
                    {
                        // Between two points of an edge, too, where a step ends there.
                        let short_m = (d.abs() - swing_m).max(0.5 * axis.width_m + 15.0);
                        least(s - 2.0, d, 0, short_m);
                        least(s + 2.0, d, 0, short_m);
                    }
                }
            }
            self.runways[r].strips_m = strips;
        }
        self
    }

    /// Whether an end of one runway lies in the strip of the other: who has one of them has both.
    #[must_use]
    pub fn strips_meet(&self, a: usize, b: usize) -> bool {
        let within = |a: &RunwayAxis, b: &RunwayAxis| {
            [0.0, a.length_m].iter().any(|end| {
                let (place, across) = b.place_m(a.origin_m + a.along * *end);
                (0.0..=b.length_m).contains(&place) && across.abs() < b.hold_m
            })
        };
        let (a, b) = (&self.runways[a], &self.runways[b]);
        within(a, b) || within(b, a)
    }

    /// The runway with an end called `name`, and which end; `18R/36L` names both.
    #[must_use]
    pub fn runway(&self, name: &str) -> Option<(usize, Option<usize>)> {
        if let Some((first, second)) = name.split_once('/') {
            let (a, b) = (self.runway(first)?, self.runway(second)?);
            return (a.0 == b.0).then_some((a.0, None));
        }
        let found = |(r, axis): (usize, &RunwayAxis)| axis.end(name).map(|end| (r, Some(end)));
        self.runways.iter().enumerate().find_map(found)
    }
}

/// Where the bar of a holding position is. Where others pass it on their way along the runway, it is across the way over the strip beyond
/// their taxiway: they pass no bar.
fn bar_at_m(net: &Network, index: usize) -> Point2<f64> {
    let node = &net.nodes[index];
    let (within, passing): (Vec<_>, Vec<_>) = net
        .edges
        .iter()
        .filter(|e| e.nodes.contains(&index))
        .partition(|e| e.strip == node.hold_for);
    let Some(way) = within.first().filter(|_| passing.len() > 1) else { return node.at_m };
    let next = way.nodes[usize::from(way.nodes[0] == index)];
    let along_m = net.nodes[next].at_m - node.at_m;
    let length_m = along_m.norm();
    if length_m < 1.0 {
        return node.at_m;
    }
    node.at_m + along_m * (BESIDE_TAXIWAY_M.min(0.5 * length_m) / length_m)
}

/// From a taxiway's centreline to a bar beside it, m (assumed: half of a wide taxiway and some room).
const BESIDE_TAXIWAY_M: f64 = 15.0;

/// How far from the axis a bar at a place along it and across it is, m: short of every taxiway that passes it along the runway. Who
/// goes on along that is over no line.
fn short_of_passing_m(net: &Network, axis: &RunwayAxis, bar_m: [f64; 2]) -> f64 {
    let [place_m, across_m] = bar_m;
    let passes = |edge: &&NetEdge| edge.runway.is_none() && edge.strip.is_none();
    let mut nearest_m = f64::INFINITY;
    for edge in net.edges.iter().filter(passes) {
        let [(from, a), (to, b)] = edge.nodes.map(|n| axis.place_m(net.nodes[n].at_m));
        // What comes nearer the runway at more than 18° leads there.
        if (b - a).abs() > ALONG * (to - from).abs() {
            continue;
        }
        let count = ((to - from).abs() / 2.0).ceil().clamp(1.0, 5_000.0) as usize;
        for i in 0..=count {
            let share = i as f64 / count as f64;
            let (along_m, off_m) = (from + (to - from) * share, a + (b - a) * share);
            let beside = (along_m - place_m).abs() <= PASSES_M && off_m * across_m > 0.0;
            // What touches the runway itself is a crossing that the file does not end with a hold.
            if beside && off_m.abs() > 0.5 * axis.width_m + 15.0 {
                nearest_m = nearest_m.min(off_m.abs());
            }
        }
    }
    across_m.signum() * across_m.abs().min(nearest_m - CLEAR_M)
}

/// Who passes a bar so far beside it along the runway may be over its line ([`super::parameters::Parameters::bar_reach_m`]), m.
const PASSES_M: f64 = 40.0;
/// Across for along of a way that is along the runway at most (assumed: exits turn off at 25° and more).
const ALONG: f64 = 0.33;
/// From a taxiway's centreline to a line that no nose on it comes over, m: the tracker's 95 % error.
const CLEAR_M: f64 = 7.5;

/// Where the way from a holding position over the strip meets its runway, m along it.
fn entry_of(net: &Network, from: usize, runway: usize) -> Option<f64> {
    let (mut seen, mut open) = (vec![from], std::collections::VecDeque::from([from]));
    while let Some(node) = open.pop_front() {
        if let Some((place_m, _)) = net.runways[runway].spine.iter().find(|(_, n)| *n == node) {
            return Some(*place_m);
        }
        for edge in net.edges.iter().filter(|e| e.strip == Some(runway) && e.nodes.contains(&node))
        {
            let next = edge.nodes[usize::from(edge.nodes[0] == node)];
            if !seen.contains(&next) && seen.len() < 50 {
                seen.push(next);
                open.push_back(next);
            }
        }
    }
    None
}

/// Where two runways cross, within their length.
fn crossing(runways: &[RunwayAxis], a: usize, b: usize) -> Option<Crossing> {
    let (first, second) = (&runways[a], &runways[b]);
    let cross = first.along.perp(&second.along);
    if cross.abs() < 0.05 {
        return None;
    }
    let between = second.origin_m - first.origin_m;
    let at = between.perp(&second.along) / cross;
    let other = between.perp(&first.along) / cross;
    let on = |place: f64, axis: &RunwayAxis| (0.0..=axis.length_m).contains(&place);
    (on(at, first) && on(other, second))
        .then_some(Crossing { runways: [a, b], places_m: [at, other] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::network::{NetNode, NetRunway};

    fn axis(a: [f64; 2], b: [f64; 2]) -> RunwayAxis {
        let ends = [Point2::new(a[0], a[1]), Point2::new(b[0], b[1])];
        RunwayAxis::new(["09".into(), "27".into()], ends, 45.0, 90.0).expect("long enough")
    }

    #[test]
    fn runways_cross_where_they_meet_and_only_within_their_length() {
        let east = axis([0.0, 0.0], [3000.0, 0.0]);
        let south = axis([1800.0, 1200.0], [1800.0, -1300.0]);
        let away = axis([1800.0, 1200.0], [1800.0, 100.0]);
        let layout = Layout::new(vec![east.clone(), south, away, east]);
        assert_eq!(layout.crossings.len(), 2);
        assert_eq!(layout.crossings[0].places_m, [1800.0, 1200.0]);
        assert_eq!(layout.runway("27"), Some((0, Some(1))));
        assert_eq!(layout.runway("09/27"), Some((0, None)));
        assert_eq!(layout.runway("05"), None);
    }

    #[test]
    fn the_right_of_an_axis_is_positive() {
        let east = axis([0.0, 0.0], [3000.0, 0.0]);
        assert_eq!(east.place_m(Point2::new(100.0, -30.0)), (100.0, 30.0));
    }

    /// A holding position at the junction with a taxiway along the runway: who taxies past it passes no bar. One on the way itself, and
    /// one on a short way, stay on it.
    #[test]
    fn a_bar_is_beside_the_taxiway_that_passes_it() {
        let node = |x: f64, y: f64, hold_for| NetNode {
            name: String::new(),
            at_m: Point2::new(x, y),
            runway: None,
            hold_for,
            stand: None,
            used: true,
        };
        let edge = |nodes, strip| NetEdge {
            nodes,
            two_way: true,
            runway: None,
            strip,
            backtrack: false,
            name: String::new(),
            code: 4,
            origin: None,
        };
        let bar = |length_m: f64, passing: bool| {
            let mut net = Network::default();
            net.nodes = vec![
                node(1000.0, length_m - 98.0, None),
                node(1000.0, -98.0, Some(0)),
                node(900.0, -98.0, None),
                node(1100.0, -98.0, None),
            ];
            net.edges = vec![edge([1, 2], None), edge([0, 1], Some(0))];
            if passing {
                net.edges.push(edge([3, 1], None));
            }
            bar_at_m(&net, 1)
        };
        assert_eq!(bar(98.0, true), Point2::new(1000.0, -83.0));
        assert_eq!(bar(20.0, true), Point2::new(1000.0, -88.0));
        assert_eq!(bar(98.0, false), Point2::new(1000.0, -98.0));
    }

    /// A taxiway that passes a bar nearer to the runway than the bar is has the bar short of it, also where no node joins the two; one
    /// beyond the bar, one across, one within the strip, and one that is farther along the runway change nothing.
    #[test]
    fn a_bar_is_short_of_the_taxiway_that_passes_it() {
        let node = |at: [f64; 2]| NetNode {
            name: String::new(),
            at_m: Point2::new(at[0], at[1]),
            runway: None,
            hold_for: None,
            stand: None,
            used: true,
        };
        let runway = || NetRunway {
            names: ["09".into(), "27".into()],
            ends_m: [Point2::new(0.0, 0.0), Point2::new(3000.0, 0.0)],
            displaced_m: [0.0; 2],
            length_m: 3000.0,
            width_m: 45.0,
            spine: Vec::new(),
            hold_distance_m: 90.0,
            turn_pads: [false; 2],
        };
        let across_m = |ends: [[f64; 2]; 2], strip| {
            let mut net = Network::default();
            let hold = NetNode { hold_for: Some(0), ..node([1000.0, -60.0]) };
            net.nodes = vec![hold, node(ends[0]), node(ends[1])];
            net.edges = vec![NetEdge {
                nodes: [1, 2],
                two_way: true,
                runway: None,
                strip,
                backtrack: false,
                name: String::new(),
                code: 4,
                origin: None,
            }];
            net.runways = vec![runway()];
            let along = axis([0.0, 0.0], [3000.0, 0.0]);
            Layout::new(vec![along]).with_network(&net).bars[0].across_m.expect("a side")
        };
        assert_eq!(across_m([[900.0, -56.0], [1100.0, -56.0]], None), 48.5);
        assert_eq!(across_m([[900.0, -61.0], [1100.0, -61.0]], None), 53.5, "a nose may stray");
        assert_eq!(across_m([[970.0, -62.0], [1030.0, -50.0]], None), 42.5, "a bend");
        assert_eq!(across_m([[970.0, -75.0], [1030.0, -50.0]], None), 60.0, "an exit");
        assert_eq!(across_m([[900.0, -68.0], [1100.0, -68.0]], None), 60.0, "beyond the bar");
        assert_eq!(across_m([[900.0, -56.0], [950.0, -56.0]], None), 60.0, "farther along");
        assert_eq!(across_m([[900.0, 56.0], [1100.0, 56.0]], None), 60.0, "on the other side");
        assert_eq!(across_m([[900.0, -56.0], [1100.0, -56.0]], Some(0)), 60.0, "in the strip");
        assert_eq!(across_m([[900.0, -20.0], [1100.0, -20.0]], None), 60.0, "on the runway");
        // A holding position on the axis beyond an end is no bar: the strip ends there.
        let mut net = Network::default();
        net.nodes = vec![NetNode { hold_for: Some(0), ..node([3055.0, 1.0]) }];
        net.runways = vec![runway()];
        let layout = Layout::new(vec![axis([0.0, 0.0], [3000.0, 0.0])]).with_network(&net);
        assert!(layout.bars.is_empty());
        assert_eq!(layout.runways[0].ends_held_m, [f64::INFINITY, 55.0]);
    }

    /// Who was pushed back onto a lane beside a runway was told of as one on it (each hour at Brainerd): the strip ends a swing short of
    /// such a lane, and at a taxiway that no stand lies at as before.
    #[test]
    fn a_strip_ends_a_swing_short_of_a_lane_beside_stands() {
        let node = |at: [f64; 2], stand| NetNode {
            name: String::new(),
            at_m: Point2::new(at[0], at[1]),
            runway: None,
            hold_for: None,
            stand,
            used: true,
        };
        for (lane_m, beside_stand, without_m) in
            [(70.0, true, 55.0), (70.0, false, 70.0), (95.0, true, 80.0), (95.0, false, 90.0)]
        {
            let mut net = Network::default();
            let stand = beside_stand.then_some(0);
            net.nodes = vec![
                node([1000.0, -lane_m], None),
                node([1200.0, -lane_m], None),
                node([1100.0, -lane_m - 60.0], stand),
                node([1100.0, -lane_m], None),
            ];
            let edge = |nodes| NetEdge {
                nodes,
                two_way: true,
                runway: None,
                strip: None,
                backtrack: false,
                name: String::new(),
                code: 4,
                origin: None,
            };
            net.edges = vec![edge([0, 3]), edge([3, 1]), edge([3, 2])];
            let net = net.with_lanes();
            let layout = Layout::new(vec![axis([0.0, 0.0], [3000.0, 0.0])]).with_network(&net);
            let hold_m = layout.runways[0].hold_at_m(1075.0, 30.0);
            assert_eq!(hold_m, without_m, "lane at {lane_m} m, stands: {beside_stand}");
            assert_eq!(layout.runways[0].hold_at_m(1075.0, -30.0), 90.0, "the other side");
            assert_eq!(layout.runways[0].hold_at_m(2000.0, 30.0), 90.0, "farther along");
        }
    }
}
