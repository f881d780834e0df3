//! The scene as the page draws it.
//!
//! Positions are metres east and north of the aerodrome reference point. Fields that go to the browser as
//! JSON carry their unit in the name.

use super::hold_lines::HoldLine;
use models::frames::Point2;
use models::plot::SensorKind;
use scenarios::Scene;
use serde::{Deserialize, Serialize};

/// Name, seed and times of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunInfo {
    /// Name of the scene ("zurich").
    pub scene: String,
    /// Title for people.
    pub title: String,
    /// Seed of all draws. As text for the browser, whose numbers end at 2⁵³.
    #[serde(serialize_with = "as_text")]
    pub seed: u64,
    /// DIS exercise.
    pub exercise: u8,
    /// UTC of simulated time zero, nanoseconds since 1970.
    #[serde(serialize_with = "as_text")]
    pub start_utc_ns: i64,
    /// Planned duration, s.
    pub duration_s: f64,
    /// Time between scans, s.
    pub scan_s: f64,
    /// Digest of the scene file.
    pub scene_digest: String,
    /// Version of the software.
    pub version: String,
    /// ICAO location indicator of the airport.
    #[serde(default)]
    pub airport: String,
    /// Name of the run that this one was forked from; none for others.
    #[serde(default)]
    pub fork: Option<String>,
}

/// The airport as the page draws it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AirportMap {
    /// ICAO location indicator.
    pub icao: String,
    /// Name for people.
    pub name: String,
    /// Latitude and longitude of the reference point, degrees.
    pub reference_deg: [f64; 2],
    /// Runways.
    pub runways: Vec<RunwayShape>,
    /// Centre lines of taxiways.
    pub taxiways: Vec<NamedLine>,
    /// Pavement: aprons and taxiways as areas; the first ring is the outline, the others are holes.
    pub pavements: Vec<NamedArea>,
    /// Stands.
    pub stands: Vec<NamedPoint>,
    /// Runway holding positions.
    pub holds: Vec<HoldLine>,
    /// Buildings, rings as for pavements.
    pub buildings: Vec<NamedArea>,
    /// Sensors of the scene with a site.
    pub sensors: Vec<SensorSite>,
    /// Kinds of sensors.
    #[serde(default)]
    pub kinds: Vec<KindLook>,
    /// Buildings of the scene with their heights: what shadows and hides.
    pub blocks: Vec<Block>,
    /// Plates by which the light of the eye's view is measured.
    pub boards: Vec<BoardPlate>,
    /// Where a tower controller looks out; none in logs of earlier versions.
    pub cab: Option<Cab>,
}

/// The eye of a tower controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cab {
    /// Where it is, m east, north and up.
    pub at_m: [f64; 3],
    /// By what it is there, for people.
    pub by: String,
}

impl AirportMap {
    /// The eye of a tower controller, m east, north and up.
    #[must_use]
    pub fn cab_m(&self) -> [f64; 3] {
        self.cab.as_ref().map_or_else(|| self.assumed_cab().at_m, |cab| cab.at_m)
    }

    /// The same, with the eye of a tower controller where a log does not say it.
    #[must_use]
    pub fn with_cab(&self) -> Self {
        let cab = self.cab.clone().or_else(|| Some(self.assumed_cab()));
        Self { cab, ..self.clone() }
    }

    /// Where nobody says it: above the highest building, else at the first radar, else in the middle of stands and runways.
    fn assumed_cab(&self) -> Cab {
        let middle = |points: &[[f64; 2]]| {
            let n = points.len().max(1) as f64;
            [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / n)
        };
        if let Some(high) = self.blocks.iter().max_by(|a, b| a.height_m.total_cmp(&b.height_m)) {
            let [x, y] = middle(&high.ring);
            let by = format!("{CAB_OVER_ROOF_M} m above {}, the highest building", high.name);
            return Cab { at_m: [x, y, high.height_m + CAB_OVER_ROOF_M], by };
        }
        let radar = self.sensors.iter().filter(|s| s.kind == "asde").find_map(|s| s.position_m);
        let ends = self.runways.iter().flat_map(|r| r.ends);
        let places: Vec<_> = self.stands.iter().map(|s| s.position_m).chain(ends).collect();
        let by = if radar.is_some() { "at the radar" } else { "in the middle of the airport" };
        let [x, y] = radar.unwrap_or_else(|| middle(&places));
        Cab { at_m: [x, y, CAB_M], by: format!("{by}, {CAB_M} m high (assumed)") }
    }

    /// By the scene, else by the viewpoint of the layout.
    fn stated_cab(scene: &Scene) -> Option<Cab> {
        let cab = |[x, y]: [f64; 2], z: f64, by: &str| Cab { at_m: [x, y, z], by: by.to_owned() };
        let by_scene = scene.airport.cab_m.map(|p| cab(metres(p.xy()), p.z, "by the scene"));
        let viewpoint = scene.airport.layout.tower.filter(|(_, height_m)| *height_m >= LEAST_CAB_M);
        by_scene.or_else(|| viewpoint.map(|(at, z)| cab(metres(at), z, "viewpoint of the layout")))
    }
}

/// A viewpoint lower than this is one of which the layout does not say the height, m.
const LEAST_CAB_M: f64 = 2.0;
/// Height of a cab over the roof below it, and of one of which nothing is known, m.
const CAB_OVER_ROOF_M: f64 = 5.0;
const CAB_M: f64 = 45.0;

/// A building with vertical walls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Name.
    pub name: String,
    /// Corners, m east and north.
    pub ring: Vec<[f64; 2]>,
    /// Height above the ground, m.
    pub height_m: f64,
}

/// A square plate turned to who looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoardPlate {
    /// Name.
    pub name: String,
    /// Centre, m east, north and up.
    pub centre_m: [f64; 3],
    /// Side, m.
    pub size_m: f64,
    /// Luminance, of that of the horizon.
    pub luminance_ratio: f64,
}

/// A runway between its thresholds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunwayShape {
    /// Designators of both directions, first end first.
    pub designators: [String; 2],
    /// Ends of the pavement, m east and north.
    pub ends: [[f64; 2]; 2],
    /// Width, m.
    pub width_m: f64,
}

/// A line with a name (empty: none).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedLine {
    /// Name.
    pub name: String,
    /// Points, m east and north.
    pub points_m: Vec<[f64; 2]>,
}

/// An area with a name (empty: none).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedArea {
    /// Name.
    pub name: String,
    /// Outline and holes, m east and north.
    pub rings: Vec<Vec<[f64; 2]>>,
}

/// A point with a name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedPoint {
    /// Name.
    pub name: String,
    /// Position, m east and north.
    pub position_m: [f64; 2],
}

/// How the page shows a kind of sensor; plots carry the place of their kind in the list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KindLook {
    /// Its word ("asde").
    pub word: String,
    /// Its name for people.
    pub title: String,
    /// Colour of its plots by night and by day, `#rrggbb`.
    pub colours: [String; 2],
    /// Mark of its plots: polylines in a square from −1 to 1, right and down.
    pub symbol: Vec<Vec<[f32; 2]>>,
}

impl KindLook {
    /// Every kind of sensor that there is, in the order of the numbers in plots.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let of = |kind: SensorKind| Self {
            word: kind.word.to_owned(),
            title: kind.title.to_owned(),
            colours: kind.colours.map(str::to_owned),
            symbol: kind.symbol.0.iter().map(|line| line.to_vec()).collect(),
        };
        SensorKind::all().map(of).collect()
    }
}

/// A sensor of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorSite {
    /// Number in the scene, as plots carry it.
    pub id: u16,
    /// Name in the scene.
    pub name: String,
    /// Kind, as plots carry it ("asde").
    pub kind: String,
    /// Site, m east and north; none for sensors on board.
    pub position_m: Option<[f64; 2]>,
    /// Instrumented range, m, where it has one.
    pub range_m: Option<f64>,
}

impl RunInfo {
    /// What the scene says of the run; `seed` may differ from the scene's own.
    #[must_use]
    pub fn of(scene: &Scene, seed: u64) -> Self {
        Self {
            scene: scene.name.clone(),
            title: scene.run.title.clone(),
            seed,
            exercise: scene.run.exercise,
            start_utc_ns: scene.run.start_utc_ns,
            duration_s: scene.run.duration.s(),
            scan_s: scene.run.scan().s(),
            scene_digest: format!("{:016x}", scene.hash),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            airport: scene.airport.layout.icao.clone(),
            fork: None,
        }
    }
}

impl AirportMap {
    /// The airport and the sensor sites of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let layout = &scene.airport.layout;
        let area = |ring: &Vec<Point2<f64>>| NamedArea {
            name: String::new(),
            rings: vec![ring.iter().map(|p| metres(*p)).collect()],
        };
        let runway = |r: &models::airport::Runway| RunwayShape {
            designators: r.names.clone(),
            ends: r.ends_m.map(metres),
            width_m: r.width_m,
        };
        let taxiway = |e: &models::airport::Edge| {
            let ends = [e.from, e.to].map(|i| layout.nodes.get(i).map(|n| metres(n.position_m)));
            Some(NamedLine { name: e.name.clone(), points_m: vec![ends[0]?, ends[1]?] })
        };
        let sensor = |s: &scenarios::SensorScene| SensorSite {
            id: s.id.0,
            name: s.name.clone(),
            kind: s.kind.word.to_owned(),
            position_m: s.site_m.map(|p| metres(p.xy())),
            range_m: s.asde.as_ref().map(|radar| radar.parameters.range_max_m),
        };
        let reference = scene.airport.reference;
        let board = |b: &scenarios::board::Board| BoardPlate {
            name: b.name.clone(),
            centre_m: [b.centre_m.x, b.centre_m.y, b.centre_m.z],
            size_m: b.size_m,
            luminance_ratio: b.luminance_ratio,
        };
        let mut map = Self {
            icao: layout.icao.clone(),
            name: layout.name.clone(),
            reference_deg: [reference.lat_deg(), reference.lon_deg()],
            runways: layout.runways.iter().map(runway).collect(),
            taxiways: layout.edges.iter().filter(|e| !e.runway).filter_map(taxiway).collect(),
            pavements: layout.pavement.iter().map(area).collect(),
            stands: layout
                .stands
                .iter()
                .map(|s| NamedPoint { name: s.name.clone(), position_m: metres(s.position_m) })
                .collect(),
            holds: super::hold_lines::of(layout),
            buildings: layout.buildings.iter().map(area).collect(),
            sensors: scene.sensors.iter().map(sensor).collect(),
            kinds: KindLook::all(),
            blocks: scene
                .buildings
                .iter()
                .map(|b| Block {
                    name: b.name.clone(),
                    ring: b.footprint_m.iter().map(|p| metres(*p)).collect(),
                    height_m: b.height_m,
                })
                .collect(),
            boards: scene.boards.iter().map(board).collect(),
            cab: None,
        };
        map.cab = Some(Self::stated_cab(scene).unwrap_or_else(|| map.assumed_cab()));
        map
    }
}

impl AirportMap {
    /// Places that are seen when the whole airport is, m.
    #[must_use]
    pub fn points(&self) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> = self.runways.iter().flat_map(|r| r.ends).collect();
        points.extend(self.taxiways.iter().flat_map(|t| t.points_m.iter().copied()));
        points.extend(self.stands.iter().map(|s| s.position_m));
        points.extend(self.pavements.iter().flat_map(|p| p.rings.concat()));
        points.retain(|p| p[0].is_finite() && p[1].is_finite());
        if points.is_empty() {
            points = vec![[-1000.0, -1000.0], [1000.0, 1000.0]];
        }
        points
    }
}

/// Centimetres are enough to draw, and keep the message short.
fn metres(p: Point2<f64>) -> [f64; 2] {
    [p.x, p.y].map(|x| (x * 100.0).round() / 100.0)
}

fn as_text<N: ToString, S: serde::Serializer>(value: &N, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn of(more: &str, airport: &str) -> AirportMap {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zurich.toml");
        let text = std::fs::read_to_string(&path).expect("a scene");
        let text = text.replacen("[airport]\n", &format!("[airport]\n{airport}\n"), 1) + more;
        AirportMap::of(&scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}")))
    }

    #[test]
    fn a_controller_looks_out_where_the_scene_says_else_at_the_viewpoint_else_above_the_roofs() {
        let building = "\n[[building]]\nname = \"pier\"\nheight_m = 18\nfootprint = [{ east_m = 500, north_m = 0 }, { east_m = 540, north_m = 0 }, { east_m = 540, north_m = 40 }]\n";
        // Row 14 of the layout: 150 ft, at 47.453819 N 8.556911 E.
        let map = of(building, "");
        let cab = map.cab.clone().expect("known");
        assert!((cab.at_m[2] - 45.72).abs() < 1e-9, "{cab:?}");
        let at = geodesy::LocalFrame::at(geodesy::Geodetic::from_degrees(
            map.reference_deg[0],
            map.reference_deg[1],
            432.0,
        ));
        let place = geodesy::Geodetic::from_degrees(47.453819, 8.556911, 432.0).to_ecef();
        let place = at.to_enu(place);
        let off = libm::hypot(cab.at_m[0] - place.east_m, cab.at_m[1] - place.north_m);
        assert!(off < 0.1 && cab.by.contains("layout"), "{off} m: {cab:?}");
        let said = "tower = { place = { x_m = 12, y_m = -34, height_m = 3 }, cab_height_m = 40 }";
        let cab = of(building, said).cab.expect("known");
        assert_eq!((cab.at_m, &cab.by[..]), ([12.0, -34.0, 43.0], "by the scene"));
        // A log of an earlier version does not say it: above the highest roof.
        let old = AirportMap { cab: None, ..map };
        let cab = old.with_cab().cab.expect("known");
        assert!(cab.at_m[2] == 23.0 && cab.by.contains("pier"), "{cab:?}");
    }

    #[test]
    fn the_boards_of_the_reference_are_appended_to_any_scene() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/views/boards.toml");
        let text = std::fs::read_to_string(folder).expect("the boards");
        let map = of(&format!("\n{text}"), "");
        assert_eq!(map.boards.len(), 21);
        for board in &map.boards {
            // Each is 1.6° wide from 50 m above the reference point, and what its name says away.
            let [x, y, z] = board.centre_m;
            let far_m = libm::hypot(libm::hypot(x, y), z - 50.0);
            let wide_deg = 2.0 * libm::atan(0.5 * board.size_m / far_m).to_degrees();
            assert!((wide_deg - 1.6).abs() < 0.01, "{board:?}");
            let name = format!("d{far_m:.0}r{}", board.luminance_ratio);
            assert_eq!(name, board.name, "{board:?}");
        }
    }
}
