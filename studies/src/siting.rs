//! Maps of a site: what each radar makes of a target at every place of the airport, and how multilateration
//! covers it, for every weather.

use crate::picture::Pavement;
use models::airport::distance_to_segment_m;
use models::effects::Tolerance;
use models::environment::Weather;
use models::frames::{Point2, Point3, Vector2};
use models::sensors::TargetClass;
use models::sensors::asde::picture::Ground;
use models::sensors::asde::survey::Aspect;
use models::sensors::mlat::{ArrivalGeometry, MlatConfig};
use scenarios::{Scene, SensorScene};
use serde_json::{Value, json};

/// How far beyond the pavement the area reaches, m.
const BESIDE_M: f64 = 50.0;
/// Value of cells that have none.
pub const NO_DATA: f32 = -9999.0;
/// Most cells of a map.
pub const MOST_CELLS: usize = 20_000_000;

/// The cells of a map: their middles are whole multiples of the step, rows go from north to south.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Middle of the first cell, m east and north.
    pub first_m: Point2<f64>,
    /// Side of a cell, m.
    pub step_m: f64,
    /// Cells across and down.
    pub size: (usize, usize),
    /// Which cells belong to the area.
    pub area: Vec<bool>,
}

impl Grid {
    /// The area of a scene: its pavement and 50 m beside it.
    ///
    /// # Errors
    /// If nothing is paved, or the map would have too many cells.
    pub fn of(scene: &Scene, step_m: f64) -> Result<Self, String> {
        let layout = &scene.airport.layout;
        let places = layout
            .runways
            .iter()
            .flat_map(|r| r.ends_m)
            .chain(layout.nodes.iter().map(|n| n.position_m))
            .chain(layout.stands.iter().map(|s| s.position_m))
            .chain(layout.pavement.iter().flatten().copied());
        let (mut low, mut high) = (
            Point2::new(f64::INFINITY, f64::INFINITY),
            Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        );
        for place in places.filter(|p| p.coords.norm() <= scene.airport.radius_m) {
            (low, high) = (low.inf(&place), high.sup(&place));
        }
        if !(low.x <= high.x) {
            return Err("the scene's airport has no pavement".into());
        }
        let margin = Vector2::repeat(BESIDE_M + 40.0);
        let (low, high) = (low - margin, high + margin);
        let index = |m: f64| (m / step_m).floor();
        let (west, north) = (index(low.x), index(high.y));
        let size = ((index(high.x) - west) as usize + 1, (north - index(low.y)) as usize + 1);
        if size.0.saturating_mul(size.1) > MOST_CELLS {
            let cells = size.0 * size.1;
            return Err(format!("{cells} cells; at most {MOST_CELLS}: a larger --step is needed"));
        }
        let pavement = Pavement::of(layout, low.coords.abs().sup(&high.coords.abs()).max() + 10.0);
        let mut grid =
            Self { first_m: Point2::new(west, north) * step_m, step_m, size, area: Vec::new() };
        let near = |place: Point2<f64>| {
            (0..=4).any(|ring| {
                let r = BESIDE_M * f64::from(ring) / 4.0;
                let around = if ring == 0 { 1 } else { 16 };
                (0..around).any(|k| {
                    let (sin, cos) = libm::sincos(f64::from(k) / 16.0 * std::f64::consts::TAU);
                    pavement.factor(place + Vector2::new(sin, cos) * r) == 1.0
                })
            })
        };
        grid.area = (0..size.0 * size.1).map(|i| near(grid.place(i))).collect();
        Ok(grid)
    }

    /// The middle of a cell, m east and north.
    #[must_use]
    pub fn place(&self, index: usize) -> Point2<f64> {
        let (column, row) = (index % self.size.0, index / self.size.0);
        self.first_m + Vector2::new(column as f64, -(row as f64)) * self.step_m
    }
}

/// One quantity over the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Number of the sensor; 0 of several together.
    pub number: u16,
    /// Sensor, weather and quantity, for file names and reports.
    pub sensor: String,
    /// The weather.
    pub weather: String,
    /// Quantity.
    pub layer: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Whether more is worse.
    pub more_is_worse: bool,
    /// Value of every cell; [`NO_DATA`] outside the area and where there is none.
    pub values: Vec<f32>,
}

/// Layers of a radar: name, unit, whether more is worse.
const LAYERS: [(&str, &str, bool); 7] = [
    ("scnr", "dB", false),
    ("pd", "", false),
    ("sigma", "m", true),
    ("shadow", "dB", true),
    ("ghosts", "per scan", true),
    ("left_out_m", "m", true),
    ("left_out_pd", "", true),
];

/// What is mapped.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The class of target.
    pub class: TargetClass,
    /// Its height over the ground, m.
    pub height_m: f64,
    /// By its worst aspect instead of the mean of all.
    pub worst: bool,
}

fn empty(
    grid: &Grid,
    (number, sensor): (u16, &str),
    weather: &str,
    layer: (&'static str, &'static str, bool),
) -> Map {
    Map {
        number,
        sensor: sensor.into(),
        weather: weather.into(),
        layer: layer.0,
        unit: layer.1,
        more_is_worse: layer.2,
        values: vec![NO_DATA; grid.area.len()],
    }
}

/// The maps of one radar of a scene in one weather.
///
/// # Errors
/// If the sensor is no radar, or cannot be made.
pub fn radar_maps(
    scene: &Scene,
    sensor: &SensorScene,
    (name, weather): (&str, &Weather),
    grid: &Grid,
    subject: &Subject,
) -> Result<Vec<Map>, String> {
    let parameters = sensor.asde.as_ref().ok_or("no radar")?;
    let tolerance: Tolerance = scene.tolerance();
    let mut radar = parameters.radar_for(scene, sensor, tolerance).map_err(|e| e.to_string())?;
    let air = radar.air(weather);
    let class = &subject.class;
    let aspect = if subject.worst { Aspect::worst(class) } else { Aspect::mean(class) };
    let mut maps: Vec<Map> =
        LAYERS.iter().map(|&layer| empty(grid, (sensor.id.0, &sensor.name), name, layer)).collect();
    for cell in (0..grid.area.len()).filter(|i| grid.area[*i]) {
        let place = grid.place(cell);
        let place = Point3::new(place.x, place.y, subject.height_m);
        let Some(found) = radar.survey(&air, class, &aspect, place) else {
            // What is not displayed is detected never.
            maps.iter_mut().filter(|m| m.layer == "pd").for_each(|m| m.values[cell] = 0.0);
            continue;
        };
        let values = [
            found.scnr_db,
            found.pd,
            found.sigma_m,
            found.shadow_db,
            found.ghosts,
            found.left_out.0,
            found.left_out.1,
        ];
        for (map, value) in maps.iter_mut().zip(values) {
            if value.is_finite() {
                map.values[cell] = value as f32;
            }
        }
    }
    Ok(maps)
}

/// Dilution and stations in sight of a multilateration system.
#[must_use]
pub fn mlat_maps(
    scene: &Scene,
    sensor: &SensorScene,
    system: &MlatConfig,
    grid: &Grid,
    subject: &Subject,
) -> Vec<Map> {
    // As the sensor has it: a transponder is in the middle of the body.
    let height_m = subject.height_m.max(0.5 * subject.class.height_m);
    let name = (sensor.id.0, sensor.name.as_str());
    let mut dilution = empty(grid, name, "any", ("mlat_dop", "", true));
    let mut stations = empty(grid, name, "any", ("mlat_n", "", false));
    for cell in (0..grid.area.len()).filter(|i| grid.area[*i]) {
        let place = grid.place(cell);
        let heard = system
            .stations
            .iter()
            .filter(|s| s.hears(place) && s.sees(&scene.buildings, place, height_m));
        let heard: Vec<Point2<f64>> = heard.map(|s| s.position_m).collect();
        stations.values[cell] = heard.len() as f32;
        if let Some(geometry) = ArrivalGeometry::of(&heard, place) {
            dilution.values[cell] = geometry.horizontal() as f32;
        }
    }
    vec![dilution, stations]
}

/// One layer over all radars: the chance that at least one detects.
#[must_use]
pub fn any_of(grid: &Grid, weather: &str, pds: &[&Map]) -> Map {
    let mut any = empty(grid, (0, "all radars"), weather, ("pd_any", "", false));
    for cell in (0..grid.area.len()).filter(|i| grid.area[*i]) {
        let miss: f32 = pds.iter().map(|m| 1.0 - m.values[cell].max(0.0)).product();
        any.values[cell] = 1.0 - miss;
    }
    any
}

impl Map {
    /// The map less another one of the same grid.
    #[must_use]
    pub fn less(&self, other: &Self) -> Self {
        let pairs = self.values.iter().zip(&other.values);
        let values = pairs
            .map(|(a, b)| if *a == NO_DATA || *b == NO_DATA { NO_DATA } else { a - b })
            .collect();
        Self { values, ..self.clone() }
    }

    /// Values of the area.
    pub fn known(&self) -> impl Iterator<Item = f32> + '_ {
        self.values.iter().copied().filter(|v| *v != NO_DATA)
    }

    /// Name of its files, without ending: with the sensor's number, as names that differ may be one in ASCII.
    #[must_use]
    pub fn file_stem(&self) -> String {
        let word = |text: &str| -> String {
            let plain =
                |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
            text.chars().map(plain).collect()
        };
        let (number, sensor) = (self.number, word(&self.sensor));
        let sensor = if number == 0 { sensor } else { format!("{number}_{sensor}") };
        format!("{sensor}-{}-{}", word(&self.weather), self.layer)
    }

    /// Least, mean and largest value, and the share of cells of the area that have one.
    #[must_use]
    pub fn summary(&self, grid: &Grid) -> Value {
        let (mut least, mut most, mut sum, mut n) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0u64);
        for v in self.known().map(f64::from) {
            (least, most, sum, n) = (least.min(v), most.max(v), sum + v, n + 1);
        }
        let area = grid.area.iter().filter(|a| **a).count().max(1);
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let mut value = json!({
            "sensor": self.sensor, "weather": self.weather, "layer": self.layer, "unit": self.unit,
            "least": finite(least), "mean": finite(sum / n as f64), "most": finite(most),
            "share_of_area": n as f64 / area as f64, "file": self.file_stem(),
        });
        if self.layer.starts_with("pd") {
            let good = self.known().filter(|v| *v >= 0.9).count() as f64;
            value["share_pd_0_9"] = json!(good / area as f64);
        }
        value
    }

    /// 32-bit floats, little endian, rows from north: the raster that BIL readers open.
    #[must_use]
    pub fn bil(&self) -> Vec<u8> {
        self.values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// The worst places, worst first: their cells.
    #[must_use]
    pub fn worst(&self, count: usize) -> Vec<usize> {
        let mut cells: Vec<usize> =
            (0..self.values.len()).filter(|i| self.values[*i] != NO_DATA).collect();
        let badness = |i: usize| if self.more_is_worse { -self.values[i] } else { self.values[i] };
        let order = |a: &usize, b: &usize| badness(*a).total_cmp(&badness(*b)).then(a.cmp(b));
        if cells.len() > count {
            cells.select_nth_unstable_by(count, order);
            cells.truncate(count);
        }
        cells.sort_by(order);
        cells
    }
}

/// Header of the raster.
#[must_use]
pub fn header(grid: &Grid) -> String {
    format!(
        "BYTEORDER I\nLAYOUT BIL\nNROWS {}\nNCOLS {}\nNBANDS 1\nNBITS 32\nPIXELTYPE FLOAT\n\
         BANDROWBYTES {}\nTOTALROWBYTES {}\nULXMAP {}\nULYMAP {}\nXDIM {}\nYDIM {}\nNODATA {NO_DATA}\n",
        grid.size.1,
        grid.size.0,
        4 * grid.size.0,
        4 * grid.size.0,
        grid.first_m.x,
        grid.first_m.y,
        grid.step_m,
        grid.step_m,
    )
}

/// World file: size of a pixel, no rotation, middle of the upper left one.
#[must_use]
pub fn world_file(grid: &Grid) -> String {
    let (step, first) = (grid.step_m, grid.first_m);
    format!("{step}\n0\n0\n{}\n{}\n{}\n", -step, first.x, first.y)
}

/// The local projection about the scene's reference point.
#[must_use]
pub fn projection(scene: &Scene) -> String {
    let (lat, lon) = {
        let at = scene.airport.reference;
        (at.lat_rad.to_degrees(), at.lon_rad.to_degrees())
    };
    format!(
        "PROJCS[\"{} local\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,\
         298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],\
         PROJECTION[\"Azimuthal_Equidistant\"],PARAMETER[\"latitude_of_center\",{lat}],\
         PARAMETER[\"longitude_of_center\",{lon}],PARAMETER[\"false_easting\",0],\
         PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]\n",
        scene.name
    )
}

/// What is nearest to a place, for people: a stand, a runway, a taxiway.
#[must_use]
pub fn nearest(scene: &Scene, place: Point2<f64>) -> String {
    let layout = &scene.airport.layout;
    let stands =
        layout.stands.iter().map(|s| ((s.position_m - place).norm(), format!("stand {}", s.name)));
    let runways = layout.runways.iter().map(|r| {
        let away = distance_to_segment_m(place, r.ends_m[0], r.ends_m[1]) - 0.5 * r.width_m;
        (away, format!("runway {}", r.names.join("/")))
    });
    let ways = layout.edges.iter().filter(|e| !e.name.is_empty()).map(|e| {
        let ends = [e.from, e.to].map(|i| layout.nodes[i].position_m);
        (distance_to_segment_m(place, ends[0], ends[1]), format!("taxiway {}", e.name))
    });
    let all = stands.chain(runways).chain(ways);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(String::new, |(_, name)| name)
}

/// Weight of a place when sites are compared: runways 4, taxiways 2, the rest 1 (assumed).
pub(crate) fn weight(scene: &Scene, place: Point2<f64>) -> f64 {
    let layout = &scene.airport.layout;
    let on_runway = layout
        .runways
        .iter()
        .any(|r| distance_to_segment_m(place, r.ends_m[0], r.ends_m[1]) <= 0.5 * r.width_m);
    if on_runway {
        return 4.0;
    }
    let on_taxiway = layout.edges.iter().any(|e| {
        let ends = [e.from, e.to].map(|i| layout.nodes[i].position_m);
        distance_to_segment_m(place, ends[0], ends[1]) <= 0.5 * e.width_m
    });
    if on_taxiway { 2.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zurich() -> Scene {
        scenarios::load_without_truth(&scenarios::locate("zurich"))
            .unwrap_or_else(|e| panic!("{e}"))
    }

    fn subject() -> Subject {
        let class = zurich().traffic.types.get("A320").expect("a type").class.clone();
        Subject { class, height_m: 0.0, worst: false }
    }

    fn maps_at(scene: &Scene, step_m: f64, weather: &Weather) -> (Grid, Vec<Map>) {
        let grid = Grid::of(scene, step_m).expect("pavement");
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
        let maps = radar_maps(scene, radar, ("w", weather), &grid, &subject());
        (grid, maps.expect("maps"))
    }

    #[test]
    fn a_coarse_map_is_the_fine_one_at_common_cells_and_rain_only_takes_away() {
        let scene = zurich();
        let dry = Weather::default();
        let (fine, of_fine) = maps_at(&scene, 50.0, &dry);
        let (coarse, of_coarse) = maps_at(&scene, 100.0, &dry);
        let mut common = 0;
        for (i, here) in of_coarse[1].values.iter().enumerate().filter(|v| *v.1 != NO_DATA) {
            let away = (coarse.place(i) - fine.first_m) / fine.step_m;
            let at = (-away.y).round() as usize * fine.size.0 + away.x.round() as usize;
            assert_eq!(of_fine[1].values[at], *here);
            common += 1;
        }
        assert!(common > 150, "{common} cells");
        let good = |maps: &[Map]| maps[1].known().filter(|v| *v >= 0.9).count();
        let mut before = usize::MAX;
        for rain_mm_per_h in [0.0, 4.0, 16.0, 50.0] {
            let (_, maps) = maps_at(&scene, 100.0, &Weather { rain_mm_per_h, ..dry.clone() });
            assert!(good(&maps) <= before, "{rain_mm_per_h} mm/h");
            before = good(&maps);
            let nothing = maps[0].less(&maps[0]);
            assert!(nothing.known().all(|v| v == 0.0));
        }
        let worst = of_coarse[2].worst(20);
        assert_eq!(worst.len(), 20);
        assert!(worst.windows(2).all(|w| of_coarse[2].values[w[0]] >= of_coarse[2].values[w[1]]));
        assert_eq!(of_coarse[1].bil().len(), 4 * coarse.size.0 * coarse.size.1);
        assert!(header(&coarse).contains(&format!("NROWS {}", coarse.size.1)));
    }

    #[test]
    fn what_the_radar_does_not_display_is_detected_never_and_among_the_worst_places() {
        let mut scene = zurich();
        let radar = scene.sensors.iter_mut().find_map(|s| s.asde.as_mut()).expect("a radar");
        radar.parameters.range_max_m = 1500.0;
        let (grid, maps) = maps_at(&scene, 100.0, &Weather::default());
        let of = |layer: &str| maps.iter().find(|m| m.layer == layer).expect("a layer");
        let (pd, ratio) = (of("pd"), of("scnr"));
        let (mut dark, mut area) = (0, 0);
        for cell in (0..grid.area.len()).filter(|i| grid.area[*i]) {
            area += 1;
            dark += usize::from(ratio.values[cell] == NO_DATA);
            assert_eq!(
                pd.values[cell] == 0.0,
                ratio.values[cell] == NO_DATA || pd.values[cell] == 0.0
            );
            assert!(pd.values[cell] != NO_DATA, "{cell}");
        }
        assert!(dark > 20 && dark < area, "{dark} of {area}");
        let about = pd.summary(&grid);
        assert_eq!(
            (about["least"].as_f64(), about["share_of_area"].as_f64()),
            (Some(0.0), Some(1.0))
        );
        assert!(pd.worst(20).iter().all(|cell| pd.values[*cell] == 0.0));
        let shown = ratio.summary(&grid)["share_of_area"].as_f64().expect("a share");
        assert!((shown - (area - dark) as f64 / area as f64).abs() < 1e-12);
    }

    #[test]
    fn maps_of_sensors_with_like_names_have_files_of_their_own() {
        let scene = zurich();
        let grid = Grid::of(&scene, 500.0).expect("pavement");
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
        let stem = |number: u16, name: &str| {
            let mut sensor = radar.clone();
            (sensor.id, sensor.name) = (models::plot::SensorId(number), name.to_owned());
            let weather = Weather::default();
            let maps = radar_maps(&scene, &sensor, ("dry", &weather), &grid, &subject());
            maps.expect("maps")[0].file_stem()
        };
        let names = ["Ñ", "Ö", "a b", "a-b", "A_b"];
        let stems: std::collections::BTreeSet<String> =
            (1..).zip(names).map(|(number, name)| stem(number, name)).collect();
        assert_eq!(stems.len(), names.len(), "{stems:?}");
        assert!(stems.iter().all(|s| s.is_ascii() && s.ends_with("-dry-scnr")), "{stems:?}");
    }
}
