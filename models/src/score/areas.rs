//! Parts of an airport, as requirements name them.

use crate::airport::{Airport, distance_to_segment_m};
use crate::frames::Point2;

/// Where a target is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Area {
    /// On a runway.
    Runway,
    /// On a taxiway away from the stands.
    Taxiway,
    /// Among the stands, but not on one.
    Apron,
    /// On a stand.
    Stand,
    /// Above the ground.
    Airborne,
    /// On the ground and on nothing that the airport names (service roads, grass).
    Elsewhere,
}

impl Area {
    /// All, in the order of reports.
    pub const ALL: [Self; 6] =
        [Self::Runway, Self::Taxiway, Self::Apron, Self::Stand, Self::Airborne, Self::Elsewhere];

    /// Word for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Runway => "runway",
            Self::Taxiway => "taxiway",
            Self::Apron => "apron",
            Self::Stand => "stand",
            Self::Airborne => "airborne",
            Self::Elsewhere => "elsewhere",
        }
    }
}

/// Distances that tell the areas apart (assumed; layouts carry no polygons of them).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaRules {
    /// A target is on a stand this near to its point, m.
    pub stand_m: f64,
    /// Taxiways this near to a stand belong to the apron, m.
    pub apron_m: f64,
    /// Beside the paved width of a runway, m.
    pub runway_margin_m: f64,
    /// Beside the paved width of a taxiway, m.
    pub taxiway_margin_m: f64,
    /// Above this height a target is airborne, m.
    pub airborne_m: f64,
}

impl Default for AreaRules {
    fn default() -> Self {
        Self {
            stand_m: 25.0,
            apron_m: 90.0,
            runway_margin_m: 15.0,
            taxiway_margin_m: 10.0,
            airborne_m: 15.0,
        }
    }
}

/// A segment with half its width.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Strip {
    ends_m: [Point2<f64>; 2],
    half_m: f64,
}

impl Strip {
    fn holds(&self, point: Point2<f64>) -> bool {
        distance_to_segment_m(point, self.ends_m[0], self.ends_m[1]) <= self.half_m
    }
}

/// The areas of an airport. Without an airport everything is [`Area::Elsewhere`] or airborne.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaMap {
    rules: AreaRules,
    runways: Vec<Strip>,
    taxiways: Vec<Strip>,
    stands: Vec<Point2<f64>>,
}

impl AreaMap {
    /// No airport at all.
    #[must_use]
    pub fn open(rules: AreaRules) -> Self {
        Self { rules, runways: Vec::new(), taxiways: Vec::new(), stands: Vec::new() }
    }

    /// The areas of `airport`: runways by their strips, taxiways by the edges of the ground network,
    /// aprons by the nearness of stands.
    #[must_use]
    pub fn of(airport: &Airport, rules: AreaRules) -> Self {
        let runways = airport
            .runways
            .iter()
            .map(|r| Strip { ends_m: r.ends_m, half_m: 0.5 * r.width_m + rules.runway_margin_m });
        let at = |node: usize| airport.nodes.get(node).map(|n| n.position_m);
        let edges = airport.edges.iter().filter(|e| !e.runway);
        let taxiways = edges.filter_map(|e| {
            let half_m = 0.5 * e.width_m + rules.taxiway_margin_m;
            Some(Strip { ends_m: [at(e.from)?, at(e.to)?], half_m })
        });
        Self {
            rules,
            runways: runways.collect(),
            taxiways: taxiways.collect(),
            stands: airport.stands.iter().map(|s| s.position_m).collect(),
        }
    }

    /// The area of a point at a height above the ground (none: on the ground).
    #[must_use]
    pub fn at(&self, point: Point2<f64>, height_m: Option<f64>) -> Area {
        if height_m.is_some_and(|h| h > self.rules.airborne_m) {
            return Area::Airborne;
        }
        if self.runways.iter().any(|r| r.holds(point)) {
            return Area::Runway;
        }
        let to_stand = self.stands.iter().map(|s| libm::hypot(s.x - point.x, s.y - point.y));
        let nearest = to_stand.fold(f64::INFINITY, f64::min);
        if nearest <= self.rules.stand_m {
            Area::Stand
        } else if nearest <= self.rules.apron_m {
            Area::Apron
        } else if self.taxiways.iter().any(|t| t.holds(point)) {
            Area::Taxiway
        } else {
            Area::Elsewhere
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airport::{Edge, Hold, Node, Runway, Stand};

    #[test]
    fn every_part_is_told_apart() {
        let node = |name: &str, x: f64, y: f64| Node {
            name: name.into(),
            position_m: Point2::new(x, y),
            hold: Hold::None,
        };
        let ends_m = [Point2::new(0.0, 0.0), Point2::new(3000.0, 0.0)];
        let airport = Airport {
            runways: vec![Runway {
                names: ["09".into(), "27".into()],
                ends_m,
                thresholds_m: ends_m,
                width_m: 60.0,
            }],
            nodes: vec![node("a", 1000.0, 0.0), node("b", 1000.0, 600.0)],
            edges: vec![Edge {
                from: 0,
                to: 1,
                two_way: true,
                runway: false,
                name: "A".into(),
                width_m: 23.0,
            }],
            stands: vec![Stand {
                name: "1".into(),
                position_m: Point2::new(1000.0, 650.0),
                heading_rad: 0.0,
                node: None,
            }],
            ..Airport::default()
        };
        let map = AreaMap::of(&airport, AreaRules::default());
        let at = |x: f64, y: f64| map.at(Point2::new(x, y), Some(0.0));
        assert_eq!(at(500.0, 44.0), Area::Runway);
        assert_eq!(at(1010.0, 300.0), Area::Taxiway);
        assert_eq!(at(1000.0, 580.0), Area::Apron);
        assert_eq!(at(1003.0, 648.0), Area::Stand);
        assert_eq!(at(2000.0, 300.0), Area::Elsewhere);
        assert_eq!(map.at(Point2::new(500.0, 0.0), Some(40.0)), Area::Airborne);
        assert_eq!(map.at(Point2::new(f64::NAN, 0.0), None), Area::Elsewhere);
        let open = AreaMap::open(AreaRules::default());
        assert_eq!(open.at(Point2::origin(), None), Area::Elsewhere);
    }
}
