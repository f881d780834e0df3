//! The airport as everybody may know it: runways, ground network, stands, pavement, in local metres.
//!
//! Plain data, filled by the reader of airport files. Movers drive along it, filters may use it as a
//! map, and the page draws it. It says nothing of any target.

use crate::frames::{Azimuth, Point2};
use crate::time::SimTime;

/// One runway, both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Runway {
    /// Designators of both ends ("10", "28"), in the order of `ends_m`.
    pub names: [String; 2],
    /// Ends of the paved runway, m east and north.
    pub ends_m: [Point2<f64>; 2],
    /// Landing thresholds (displaced from the ends), m east and north.
    pub thresholds_m: [Point2<f64>; 2],
    /// Width, m.
    pub width_m: f64,
}

impl Runway {
    /// Direction of take-off and landing of the end called `name`, or `None` if it is no end of it.
    #[must_use]
    pub fn direction(&self, name: &str) -> Option<Azimuth> {
        let end = self.names.iter().position(|n| n == name)?;
        Some(Azimuth::of(self.ends_m[1 - end] - self.ends_m[end]))
    }

    /// Distance of a point from the centreline segment, m.
    #[must_use]
    pub fn distance_m(&self, point_m: Point2<f64>) -> f64 {
        distance_to_segment_m(point_m, self.ends_m[0], self.ends_m[1])
    }
}

/// A point of the ground network.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name or number in its file; unique within the airport.
    pub name: String,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Where aircraft or vehicles wait before the next part.
    pub hold: Hold,
}

/// Kind of a holding position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// None.
    #[default]
    None,
    /// End of a pushback.
    PushBack,
    /// Runway holding position.
    Runway,
}

/// An arc of the ground network: a straight line between two nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Index of the start in [`Airport::nodes`].
    pub from: usize,
    /// Index of the end.
    pub to: usize,
    /// May be driven from `to` to `from` as well.
    pub two_way: bool,
    /// Lies on a runway.
    pub runway: bool,
    /// Name of the taxiway; empty where the file has none.
    pub name: String,
    /// Width, m; assumed where the file has none.
    pub width_m: f64,
}

/// A parking position.
#[derive(Clone, Debug, PartialEq)]
pub struct Stand {
    /// Name, unique within the airport.
    pub name: String,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Heading of a parked aircraft, radians clockwise from north.
    pub heading_rad: f64,
    /// Index of its node in [`Airport::nodes`], where the network reaches it.
    pub node: Option<usize>,
}

/// What an edge of a file carries beside its line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeDetail {
    /// Largest aerodrome reference code letter, `A` to `F`, where given.
    pub code: Option<char>,
    /// Designators of runways whose active zone it lies in (departure, arrival or ILS).
    pub zones: Vec<String>,
}

/// What a stand of a file carries beside its place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StandDetail {
    /// Largest code letter, `A` to `F`, where given.
    pub code: Option<char>,
    /// Half the largest span, m, where given.
    pub radius_m: Option<f64>,
    /// Node at which a pushback ends.
    pub push_back: Option<usize>,
    /// Word of the file for its kind ("gate", "tie_down", "cargo").
    pub kind: String,
}

/// Why an area is protected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaKind {
    /// Closed.
    Closed,
    /// ILS critical or sensitive.
    Ils,
    /// Restricted.
    Restricted,
}

impl AreaKind {
    /// The kind of a word.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        match word {
            "closed" => Some(Self::Closed),
            "ils" => Some(Self::Ils),
            "restricted" => Some(Self::Restricted),
            _ => None,
        }
    }
}

/// A protected area and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Why.
    pub kind: AreaKind,
    /// Outline, m, not closed.
    pub outline_m: Vec<Point2<f64>>,
    /// Protected from.
    pub from: SimTime,
    /// Protected until.
    pub until: SimTime,
}

impl Area {
    /// Whether a point lies inside at a time (even-odd rule).
    #[must_use]
    pub fn holds(&self, time: SimTime, point_m: Point2<f64>) -> bool {
        if time < self.from || time >= self.until {
            return false;
        }
        inside(&self.outline_m, point_m)
    }
}

/// Details by index; shorter lists than those they belong to say nothing of the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// By index in [`Airport::edges`].
    pub edges: Vec<EdgeDetail>,
    /// By index in [`Airport::stands`].
    pub stands: Vec<StandDetail>,
    /// Edges that the import guessed: from a stand to its nearest node.
    pub joined: Vec<usize>,
    /// Numbers of the nodes in their file, by index in [`Airport::nodes`].
    pub numbers: Vec<String>,
    /// Nodes that hold at CAT II/III.
    pub cat3_holds: Vec<usize>,
    /// Service roads for vehicles: begin and end, m, and whether both ways.
    pub roads: Vec<([Point2<f64>; 2], bool)>,
    /// Runway ends in use for arrivals and departures, where somebody says them.
    pub in_use: [Vec<String>; 2],
    /// Stands and destinations of vehicles: place, m, and its word ("fuel_jets", "crew_car").
    pub vehicle_places: Vec<(Point2<f64>, String)>,
    /// Protected areas.
    pub areas: Vec<Area>,
    /// Whether edges that cross without a node are joined where they do (else a bridge is assumed, or a tunnel).
    pub mend_crossings: bool,
    /// Runways that are closed for a time, by the name of one of their ends: from, until.
    pub closures: Vec<(String, [SimTime; 2])>,
}

impl Details {
    /// When a runway is closed.
    pub fn closed_runways<'a>(
        &'a self,
        runway: &'a Runway,
    ) -> impl Iterator<Item = [SimTime; 2]> + 'a {
        let own = |name: &str| runway.names.iter().any(|n| n == name);
        self.closures.iter().filter(move |(name, _)| own(name)).map(|(_, times)| *times)
    }
}

/// Everything of one airport.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Airport {
    /// ICAO location indicator.
    pub icao: String,
    /// Name.
    pub name: String,
    /// Runways.
    pub runways: Vec<Runway>,
    /// Points of the ground network.
    pub nodes: Vec<Node>,
    /// Arcs of the ground network.
    pub edges: Vec<Edge>,
    /// Stands.
    pub stands: Vec<Stand>,
    /// Outlines of pavement, m east and north, not closed (last point differs from the first).
    pub pavement: Vec<Vec<Point2<f64>>>,
    /// Outlines of buildings, where known.
    pub buildings: Vec<Vec<Point2<f64>>>,
    /// What some files say beyond that; empty where a file says nothing.
    pub details: Details,
    /// Control tower, m east and north, and height of its viewpoint over ground, m.
    pub tower: Option<(Point2<f64>, f64)>,
}

impl Airport {
    /// Without nodes, edges and stands, and without what is said of them by index: for another network in their place.
    pub fn clear_network(&mut self) {
        self.nodes.clear();
        self.edges.clear();
        self.stands.clear();
        let Details { roads, in_use, vehicle_places, areas, closures, .. } =
            std::mem::take(&mut self.details);
        self.details =
            Details { roads, in_use, vehicle_places, areas, closures, ..Details::default() };
    }

    /// The runway with an end called `name`.
    #[must_use]
    pub fn runway(&self, name: &str) -> Option<&Runway> {
        self.runways.iter().find(|r| r.names.iter().any(|n| n == name))
    }

    /// The stand called `name`.
    #[must_use]
    pub fn stand(&self, name: &str) -> Option<&Stand> {
        self.stands.iter().find(|s| s.name == name)
    }

    /// Index of the node called `name`, of the node of the stand called so, or, for `#12`, of the node (or
    /// stand) with number 12 in its file.
    #[must_use]
    pub fn node(&self, name: &str) -> Option<usize> {
        if let Some(number) = name.strip_prefix('#') {
            let numbered = self.details.numbers.iter().position(|n| n == number);
            return numbered.or_else(|| self.nodes.iter().position(|n| n.name == number));
        }
        let stand = || self.stand(name).and_then(|s| s.node);
        let numbered = || self.details.numbers.iter().position(|n| n == name);
        self.nodes.iter().position(|n| n.name == name).or_else(stand).or_else(numbered)
    }
}

/// Whether a point lies inside an outline that is not closed (even-odd rule), both in m.
#[must_use]
pub fn inside(outline_m: &[Point2<f64>], point_m: Point2<f64>) -> bool {
    let next = outline_m.iter().cycle().skip(1);
    let crossed = outline_m.iter().zip(next).filter(|(a, b)| {
        (a.y > point_m.y) != (b.y > point_m.y)
            && point_m.x < a.x + (b.x - a.x) * (point_m.y - a.y) / (b.y - a.y)
    });
    crossed.count() % 2 == 1
}

/// Distance of a point from the segment `a` to `b`, m.
#[must_use]
pub fn distance_to_segment_m(point_m: Point2<f64>, a: Point2<f64>, b: Point2<f64>) -> f64 {
    let along = b - a;
    let length2 = along.norm_squared();
    let share =
        if length2 > 0.0 { ((point_m - a).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (point_m - a - along * share).norm()
}
