//! Where the radars of a run see: pictures of the probability of detection, or of the error of a plot, over the airport, made when a page
//! asks for one.
//!
//! Everything exact, a medium jet at the mean of its aspects, the weather of the time. The picture shows what is *not* seen:
//! clear where detection is sure, violet where it is not, grey where nothing is displayed; of errors clear up to a metre (1σ, the root of the
//! sum of both variances), violet from ten on.

use super::archive::Archive;
use super::kept_scene;
use super::video::{NoTurn, Turns};
use models::environment::Weather;
use models::frames::{Point2, Point3, Vector2};
use models::sensors::TargetClass;
use models::sensors::asde::Asde;
use models::sensors::asde::survey::Aspect;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Cells along the longer side, at most.
const MOST_CELLS: f64 = 240.0;
/// The same of a map of errors, which takes longer.
const MOST_SIGMA_CELLS: f64 = 96.0;
/// Cells are not smaller, m.
const LEAST_STEP_M: f64 = 10.0;
/// Beyond the outermost place of the airport, m.
const BESIDE_M: f64 = 200.0;
/// Pictures kept: a few radars at a few weathers.
const MOST_KEPT: usize = 32;
/// What stands everywhere: this type, else the first of the scene's.
const TYPE: &str = "A320";

/// The probability of detection over a grid, as a picture with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The picture as PNG with transparency: a pixel a cell, rows from north to south.
    pub png: Vec<u8>,
    /// West and north edge of the first cell, m from the reference point.
    pub corner_m: [f64; 2],
    /// Side of a cell, m.
    pub step_m: f64,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// Probability of detection in a scan.
    #[default]
    Pd,
    /// Deviation of a plot on the ground.
    Sigma,
}

impl What {
    /// By its word in a request: `pd`, `sigma`.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        match word {
            "pd" => Some(Self::Pd),
            "sigma" => Some(Self::Sigma),
            _ => None,
        }
    }
}

/// Where the scene is found.
#[derive(Debug)]
enum From {
    Scene(Arc<Scene>),
    Log(PathBuf),
}

/// The radars of a run at their places, made when they are first asked for.
#[derive(Debug)]
struct Radars {
    radars: Vec<(u16, Asde)>,
    class: TargetClass,
    aspect: Aspect,
    /// From when, s.
    weather: Vec<(f64, Weather)>,
    low_m: Point2<f64>,
    high_m: Point2<f64>,
}

/// What was made already: pictures by radar (none: all together) and weather.
#[derive(Debug, Default)]
struct Made {
    radars: Option<Radars>,
    kept: BTreeMap<(Option<u16>, usize, What), Arc<Picture>>,
}

/// The pictures of one run, and the turns of its radars.
#[derive(Debug)]
pub struct Maps {
    from: From,
    made: Mutex<Made>,
    turns: Turns,
    planning: Mutex<()>,
    stored: OnceLock<Arc<Scene>>,
}

impl Maps {
    /// Of a run that goes on.
    #[must_use]
    pub fn of(scene: Arc<Scene>) -> Arc<Self> {
        Arc::new(Self::from(From::Scene(scene)))
    }

    /// Of a run in a database.
    #[must_use]
    pub fn stored(database: PathBuf) -> Arc<Self> {
        Arc::new(Self::from(From::Log(database)))
    }

    fn from(from: From) -> Self {
        Self {
            from,
            made: Mutex::default(),
            turns: Turns::default(),
            planning: Mutex::default(),
            stored: OnceLock::new(),
        }
    }

    /// The video of one turn of a radar: [`Turns::turn`]. Takes a second and more.
    ///
    /// # Errors
    /// As [`Turns::turn`], or the scene cannot be had.
    pub fn turn(&self, asked: &super::video::Asked) -> Result<Arc<Vec<u8>>, NoTurn> {
        let scene = self.scene().map_err(NoTurn::Never)?;
        self.turns.turn(&scene, asked)
    }

    /// The picture of one radar, or of all together, in the weather of a time, s. Takes a tenth of a second the first time.
    ///
    /// # Errors
    /// The scene cannot be had, or has no such radar; as one sentence.
    pub fn picture(
        &self,
        sensor: Option<u16>,
        time_s: f64,
        what: What,
    ) -> Result<Arc<Picture>, String> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let Made { radars, kept } = &mut *made;
        if radars.is_none() {
            *radars = Some(Radars::of(&*self.scene()?)?);
        }
        let Some(radars) = radars else { return Err(String::new()) };
        if sensor.is_some_and(|id| radars.radars.iter().all(|r| r.0 != id)) {
            return Err("this sensor is not a radar".to_owned());
        }
        let weather = radars.weather.iter().rposition(|w| w.0 <= time_s).unwrap_or(0);
        if let Some(picture) = kept.get(&(sensor, weather, what)) {
            return Ok(Arc::clone(picture));
        }
        let picture = Arc::new(radars.picture(sensor, weather, what)?);
        if kept.len() >= MOST_KEPT {
            kept.pop_first();
        }
        kept.insert((sensor, weather, what), Arc::clone(&picture));
        Ok(picture)
    }

    /// What decides how well a sensor that is no radar sees: [`geometry::of`](super::geometry::of). Takes up to some tenths of a second.
    ///
    /// # Errors
    /// As there, or the scene cannot be had.
    pub fn geometry(&self, asked: &super::geometry::Asked) -> Result<serde_json::Value, String> {
        super::geometry::of(&*self.scene()?, asked)
    }

    /// Where each effect of a radar's plan is on: [`rings::of`](super::rings::of). Takes some milliseconds; one at a time.
    ///
    /// # Errors
    /// As there, or the scene cannot be had.
    pub fn rings(&self, asked: &super::rings::Asked) -> Result<serde_json::Value, String> {
        let scene = self.scene()?;
        let _one = self.planning.lock().unwrap_or_else(PoisonError::into_inner);
        super::rings::of(&scene, asked)
    }

    fn scene(&self) -> Result<Arc<Scene>, String> {
        match &self.from {
            From::Scene(scene) => Ok(Arc::clone(scene)),
            From::Log(database) => {
                if let Some(scene) = self.stored.get() {
                    return Ok(Arc::clone(scene));
                }
                let archive = Archive::open(database).map_err(|e| e.to_string())?;
                let scene = kept_scene::load_as_changed(&archive).map_err(|e| format!("{e:#}"))?;
                Ok(Arc::clone(self.stored.get_or_init(|| Arc::new(scene))))
            }
        }
    }
}

impl Radars {
    fn of(scene: &Scene) -> Result<Self, String> {
        let built = |s: &scenarios::SensorScene| {
            let radar = s.asde.as_ref()?;
            Some(radar.radar(scene, s).map(|asde| (s.id.0, asde)))
        };
        let radars = scene.sensors.iter().filter_map(built).collect::<Result<Vec<_>, _>>();
        let radars = radars.map_err(|e| e.to_string())?;
        if radars.is_empty() {
            return Err("the scene has no radar".to_owned());
        }
        let types = &scene.traffic.types;
        let row = types.get(TYPE).or_else(|| types.get(types.designators().next()?));
        let class = row.ok_or("the scene has no types of targets")?.class.clone();
        let layout = &scene.airport.layout;
        let places = layout.runways.iter().flat_map(|r| r.ends_m);
        let places = places.chain(layout.nodes.iter().map(|n| n.position_m));
        let places = places.chain(layout.stands.iter().map(|s| s.position_m));
        let (mut low_m, mut high_m) = (
            Point2::new(f64::INFINITY, f64::INFINITY),
            Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        );
        for place in places.filter(|p| p.coords.norm() <= scene.airport.radius_m) {
            (low_m, high_m) = (low_m.inf(&place), high_m.sup(&place));
        }
        if !(low_m.x <= high_m.x) {
            return Err("the scene's airport has no pavement".to_owned());
        }
        let beside = Vector2::repeat(BESIDE_M);
        let mut weather: Vec<(f64, Weather)> =
            scene.weather.iter().map(|n| (n.time.s(), n.weather.clone())).collect();
        if weather.is_empty() {
            weather.push((0.0, Weather::default()));
        }
        let aspect = Aspect::mean(&class);
        Ok(Self { radars, class, aspect, weather, low_m: low_m - beside, high_m: high_m + beside })
    }

    fn picture(
        &mut self,
        sensor: Option<u16>,
        weather: usize,
        what: What,
    ) -> Result<Picture, String> {
        let extent = self.high_m - self.low_m;
        let cells = if what == What::Pd { MOST_CELLS } else { MOST_SIGMA_CELLS };
        let step_m = (extent.max() / cells).max(LEAST_STEP_M).ceil();
        let size = [extent.x, extent.y].map(|m| (m / step_m).ceil() as u32);
        let corner_m = [self.low_m.x, self.high_m.y];
        let weather = &self.weather[weather].1;
        let mut unseen = vec![None::<f64>; size[0] as usize * size[1] as usize];
        let asked = self.radars.iter_mut().filter(|r| sensor.is_none_or(|id| r.0 == id));
        for (_, radar) in asked {
            let air = radar.air(weather);
            for (cell, unseen) in unseen.iter_mut().enumerate() {
                let (column, row) = (cell as u32 % size[0], cell as u32 / size[0]);
                let place_m = Point3::new(
                    corner_m[0] + (f64::from(column) + 0.5) * step_m,
                    corner_m[1] - (f64::from(row) + 0.5) * step_m,
                    0.0,
                );
                let (class, aspect) = (&self.class, &self.aspect);
                let here = match what {
                    // What none of them detects.
                    What::Pd => radar
                        .detection_at(&air, class, aspect, place_m)
                        .map(|pd| unseen.unwrap_or(1.0) * (1.0 - pd)),
                    // The best of them.
                    What::Sigma => radar
                        .survey(&air, class, aspect, place_m)
                        .map(|s| unseen.map_or(s.sigma_m, |known| known.min(s.sigma_m))),
                };
                *unseen = here.or(*unseen);
            }
        }
        let share = |figure: Option<f64>| match what {
            What::Pd => colour(figure),
            What::Sigma => colour(figure.map(|m| 0.5 * (m - CLEAR_M) / (FULL_M - CLEAR_M))),
        };
        let pixels: Vec<u8> = unseen.into_iter().flat_map(share).collect();
        let png = encoded(size, &pixels).map_err(|e| e.to_string())?;
        Ok(Picture { png, corner_m, step_m })
    }
}

/// Up to this deviation a place is clear, from this on it is full, m.
const CLEAR_M: f64 = 1.0;
const FULL_M: f64 = 10.0;

/// Red, green, blue and opacity of a place that is missed with this probability; none: not displayed.
fn colour(missed: Option<f64>) -> [u8; 4] {
    let Some(missed) = missed else { return [128, 128, 128, 90] };
    // Pale at a tenth, full from a half on; red and amber are for alarms.
    let share = ((missed - 0.1) / 0.4).clamp(0.0, 1.0);
    let between = |from: f64, to: f64| (from + share * (to - from)).round() as u8;
    let opacity = 190.0 * libm::pow(missed.clamp(0.0, 1.0), 0.6);
    [between(186.0, 150.0), between(160.0, 40.0), 255, opacity as u8]
}

fn encoded(size: [u32; 2], pixels: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(picture: &Picture) -> (usize, Vec<u8>) {
        let mut reader =
            png::Decoder::new(std::io::Cursor::new(&picture.png)).read_info().expect("a picture");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        let info = reader.next_frame(&mut pixels).expect("pixels");
        (info.width as usize, pixels)
    }

    /// The pixel of a place.
    fn at(picture: &Picture, place_m: [f64; 2]) -> [u8; 4] {
        let (width, pixels) = decoded(picture);
        let column = ((place_m[0] - picture.corner_m[0]) / picture.step_m) as usize;
        let row = ((picture.corner_m[1] - place_m[1]) / picture.step_m) as usize;
        let from = 4 * (row * width + column);
        [pixels[from], pixels[from + 1], pixels[from + 2], pixels[from + 3]]
    }

    #[test]
    fn what_a_building_hides_is_violet_and_what_is_open_is_clear() {
        let file = scenarios::locate("asmgcs");
        let scene = Arc::new(scenarios::load_without_truth(&file).expect("the shipped scene"));
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
        let site_m = radar.site_m.expect("a site").xy();
        let maps = Maps::of(Arc::clone(&scene));
        let picture = maps.picture(None, 0.0, What::Pd).expect("a picture");
        assert_eq!(*maps.picture(Some(radar.id.0), 1.0, What::Pd).expect("of it alone"), *picture);
        assert!(maps.picture(Some(999), 0.0, What::Pd).is_err());
        // Every cell is what the radar's own chance there says.
        let mut asde = radar.asde.as_ref().expect("one").radar(&scene, radar).expect("sound");
        let class = scene.traffic.types.get(TYPE).expect("a type").class.clone();
        let (aspect, air) = (Aspect::mean(&class), asde.air(&scene.weather[0].weather));
        let (width, pixels) = decoded(&picture);
        let (mut hidden, mut open) = (0, 0);
        for cell in (0..pixels.len() / 4).step_by(37) {
            let (column, row) = ((cell % width) as f64 + 0.5, (cell / width) as f64 + 0.5);
            let x = picture.corner_m[0] + column * picture.step_m;
            let y = picture.corner_m[1] - row * picture.step_m;
            let place_m = Point3::new(x, y, 0.0);
            let survey = asde.survey(&air, &class, &aspect, place_m);
            let shown = at(&picture, [x, y]);
            assert_eq!(shown, colour(survey.map(|s| 1.0 - s.pd)), "{place_m}");
            hidden += u32::from(survey.is_some_and(|s| s.pd < 0.5));
            open += u32::from(survey.is_some_and(|s| s.pd > 0.999));
        }
        assert!(hidden > 0 && open > 100, "{hidden} hidden, {open} open");
        // Under the mast nothing is displayed.
        assert_eq!(at(&picture, [site_m.x, site_m.y]), colour(None));
        // The map of errors is the radar's own deviation there: clear beside it, violet far off.
        let errors = maps.picture(None, 0.0, What::Sigma).expect("a picture of errors");
        let (width, pixels) = decoded(&errors);
        let (mut steep, mut known) = (BTreeMap::new(), 0);
        for cell in (0..pixels.len() / 4).step_by(41) {
            let (column, row) = ((cell % width) as f64 + 0.5, (cell / width) as f64 + 0.5);
            let x = errors.corner_m[0] + column * errors.step_m;
            let y = errors.corner_m[1] - row * errors.step_m;
            let survey = asde.survey(&air, &class, &aspect, Point3::new(x, y, 0.0));
            let Some(survey) = survey else {
                assert_eq!(at(&errors, [x, y]), colour(None));
                continue;
            };
            let share = 0.5 * (survey.sigma_m - 1.0) / 9.0;
            assert_eq!(at(&errors, [x, y]), colour(Some(share)), "{} m", survey.sigma_m);
            steep.insert((survey.sigma_m * 1e4) as i64, at(&errors, [x, y])[3]);
            known += 1;
        }
        let (least, most) = (steep.values().min(), steep.values().max());
        assert!(known > 50 && steep.values().is_sorted() && least < most, "{known} {steep:?}");
        // Heavy rain hides more.
        let rain = maps.picture(None, 450.0, What::Pd).expect("a picture in rain");
        let opacity = |p: &Picture| decoded(p).1.chunks(4).map(|c| u64::from(c[3])).sum::<u64>();
        assert!(opacity(&rain) > opacity(&picture));
    }
}
