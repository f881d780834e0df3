//! Multilateration: the time of arrival of a target's transmission at several stations.
//!
//! The unknowns are position and time of transmission; rows of H are (u_x, u_y, 1) with the unit
//! vector u from station to target, and cov = (c σ_t)² (HᵀH)⁻¹. That is the same as using time
//! differences with their full, correlated covariance. What a position states is that with the variance of a range as
//! its own residuals show it, with or without late arrivals (`range_variance_m2`).
//!
//! Source: least squares of pseudoranges, as in Torrieri, "Statistical theory of passive location
//! systems", IEEE Trans. AES-20 (1984). Timing errors and multipath are assumptions.

use crate::draw::{Purpose, normal_pair_of, uniform};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningScene,
};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::{Weather, wavelength_m};
use crate::frames::ellipse;
use crate::frames::{Azimuth, Point2, Vector2};
use crate::keys::{Holds, Key};
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, count, number};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::radar::shadow::{Building, SightLine};
use crate::sensors::reporting::bounds::{SIGMAS, given, percent, two};
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::{PlotSink, ScanInterval, Sensor, TargetState, Truth};
use std::sync::Arc;

mod geometry;

pub use geometry::ArrivalGeometry;
use geometry::SPEED_OF_LIGHT_MPS;

/// A direction in which a station hears nothing beyond some distance (a building stands there).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlindSector {
    /// Beginning, degrees clockwise from north.
    pub from_deg: f64,
    /// End, degrees clockwise from `from_deg`'s direction.
    pub to_deg: f64,
    /// Distance beyond which nothing is heard, m.
    pub beyond_m: f64,
}

/// A receiving station.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// Where it stands, airport frame, m.
    pub position_m: Point2<f64>,
    /// Height of its antenna above the surface, m.
    pub height_m: f64,
    /// How far it hears, m.
    pub range_m: f64,
    /// Where it does not.
    pub blind: Vec<BlindSector>,
}

impl Station {
    /// Whether no building cuts the straight line to a transponder `height_m` above the surface.
    #[must_use]
    pub fn sees(&self, buildings: &[Building], target_m: Point2<f64>, height_m: f64) -> bool {
        let line = SightLine {
            site_m: self.position_m,
            antenna_m: self.height_m,
            target_m,
            height_m,
            wavelength_m: wavelength_m(TRANSPONDER_GHZ),
        };
        !buildings.iter().any(|b| line.behind(&b.footprint_m, b.height_m).blocked)
    }

    /// Whether a target at `target_m` is within reach and in no blind sector.
    #[must_use]
    pub fn hears(&self, target_m: Point2<f64>) -> bool {
        let d = target_m - self.position_m;
        let far_m = d.norm();
        far_m <= self.range_m
            && !self.blind.iter().any(|sector| {
                let turn = |deg: f64| deg.rem_euclid(360.0);
                let width_deg = sector.to_deg - sector.from_deg;
                far_m > sector.beyond_m
                    && (width_deg >= 360.0
                        || turn(Azimuth::of(d).deg360() - sector.from_deg) <= turn(width_deg))
            })
    }
}

/// Parameters of a [`Mlat`].
#[derive(Clone, Debug, PartialEq)]
pub struct MlatConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who carries a transponder.
    pub equipped: Equipage,
    /// Time between two positions of a target, s.
    pub report_s: f64,
    /// The stations, 3 to 64.
    pub stations: Vec<Station>,
    /// Deviation of a time of arrival, s.
    pub sigma_t_s: f64,
    /// Probability that a time of arrival is late by multipath.
    pub multipath: f64,
    /// Mean of that delay, m.
    pub multipath_m: f64,
    /// Probability that a station decodes a transmission it hears.
    pub reception: f64,
    /// Largest horizontal dilution of a position that is reported.
    pub max_dilution: f64,
    /// What stands between stations and targets.
    pub buildings: Arc<[Building]>,
}

impl MlatConfig {
    /// Stations 15 m high at these places that hear 10 km, with 5 ns of timing error, in the open.
    #[must_use]
    pub fn with_stations(id: SensorId, stations_m: &[Point2<f64>]) -> Self {
        let station = |&position_m: &Point2<f64>| Station {
            position_m,
            height_m: 15.0,
            range_m: 10_000.0,
            blind: Vec::new(),
        };
        Self {
            id,
            equipped: Equipage::all(),
            report_s: 1.0,
            stations: stations_m.iter().map(station).collect(),
            sigma_t_s: 5e-9,
            multipath: 0.02,
            multipath_m: 10.0,
            reception: 0.97,
            max_dilution: 10.0,
            buildings: Arc::new([]),
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        count("stations", self.stations.len(), 3, MAX_STATIONS)?;
        for station in &self.stations {
            number("station_east_m", station.position_m.x, -1e6, 1e6)?;
            number("station_north_m", station.position_m.y, -1e6, 1e6)?;
            number("station_height_m", station.height_m, 0.0, 500.0)?;
            number("station_range_m", station.range_m, 1.0, 1e6)?;
            for sector in &station.blind {
                number("blind_from_deg", sector.from_deg, -360.0, 360.0)?;
                number("blind_to_deg", sector.to_deg, -360.0, 720.0)?;
                number("blind_beyond_m", sector.beyond_m, 0.0, 1e6)?;
            }
        }
        let off_line_m = off_line_m(&self.stations);
        if off_line_m < LEAST_OFF_LINE_M {
            return Err(ConfigError::Shape {
                key: "stations",
                found: "all of them in one place or on one line",
                value: off_line_m,
                needed: "a station at least 10 m off the line through the others",
            });
        }
        check(KEYS, "sigma_t_s", self.sigma_t_s)?;
        check(KEYS, "multipath", self.multipath)?;
        check(KEYS, "multipath_m", self.multipath_m)?;
        check(KEYS, "reception", self.reception)?;
        check(KEYS, "max_dilution", self.max_dilution)
    }

    /// The middle of the stations, m.
    #[must_use]
    pub fn middle_m(&self) -> Point2<f64> {
        let sum = self.stations.iter().fold(Vector2::zeros(), |sum, s| sum + s.position_m.coords);
        Point2::from(sum / self.stations.len().max(1) as f64)
    }

    /// Variance of one range, m², as a fix of `stations` shows it whose residuals have the sum of squares `left_m2`.
    ///
    /// Two hypotheses: timing alone, variance s = (c σ_t)²; or some of the n times late, on average pn/π of them where any is,
    /// π = 1 − (1 − p)ⁿ, variance v = s + 2μ²p/π. The residuals have n − 3 degrees of freedom:
    /// ln w₁/w₀ = ln π/(1 − π) − ½(n − 3) ln v/s + ½R(1/s − 1/v), and w₀s + w₁v is stated.
    fn range_variance_m2(&self, stations: usize, left_m2: f64) -> f64 {
        let timing_m = SPEED_OF_LIGHT_MPS * self.sigma_t_s;
        let s = timing_m * timing_m;
        let n = stations as f64;
        let late = -libm::expm1(n * libm::log1p(-self.multipath));
        if !(late > 0.0) {
            return s;
        }
        let v = s + 2.0 * self.multipath_m * self.multipath_m * self.multipath / late;
        let spare = (n - 3.0).max(0.0);
        let odds = libm::log(late) - libm::log(1.0 - late) - 0.5 * spare * libm::log(v / s)
            + 0.5 * left_m2 * (1.0 / s - 1.0 / v);
        s + (v - s) / (1.0 + libm::exp(-odds))
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Mlat,
            equipped: self.equipped.clone(),
            period_s: self.report_s,
            transponder: true,
        }
    }
}

/// Stations nearer than this to one line give no position across it: both sides of the line fit alike.
const LEAST_OFF_LINE_M: f64 = 10.0;

/// How far the stations reach off the line that fits them best, m: the deviation across it times √n.
fn off_line_m(stations: &[Station]) -> f64 {
    let n = stations.len().max(1) as f64;
    let sum = stations.iter().fold(Vector2::zeros(), |sum, s| sum + s.position_m.coords);
    let middle = Point2::from(sum / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for station in stations {
        let d = station.position_m - middle;
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    let (half, turn) = (0.5 * (xx + yy), libm::hypot(0.5 * (xx - yy), xy));
    (half - turn).max(0.0).sqrt()
}

/// Carrier of a transponder's replies, GHz.
const TRANSPONDER_GHZ: f64 = 1.09;

/// Most stations of one system.
pub const MAX_STATIONS: usize = 64;

/// A multilateration system.
#[derive(Clone, Debug)]
pub struct Mlat {
    config: MlatConfig,
    reporting: Reporting,
    fleet: Fleet<()>,
    planning: Planning,
}

impl Mlat {
    /// A system with these parameters.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: MlatConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting();
        let planning = Planning::new(config.id, &MODEL);
        Ok(Self { config, reporting, fleet: Fleet::default(), planning })
    }
}

impl Planned for Mlat {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Mlat {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Mlat
    }

    fn plan(&self) -> &[PlanRow] {
        self.planning.rows()
    }

    fn evaluations(&self) -> Vec<(&'static str, u64)> {
        self.planning.evaluations()
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        _weather: &Weather,
        out: &mut PlotSink,
    ) {
        let (config, reporting) = (&self.config, &self.reporting);
        let planning = &mut self.planning;
        let middle_m = config.middle_m();
        let distance_m = |s: &TargetState| (s.position_m.xy() - middle_m).norm();
        if planning.wants_survey(truth.len()) {
            let see = |s: &TargetState| planning.see(&s.velocity_mps, distance_m(s));
            self.fleet.survey(reporting, interval, truth, see);
        }
        planning.prepare(|scene| ladders(config, scene));
        let mut reports = Reports::new(reporting, truth, out);
        let (mut heard, mut errors_m) = (Vec::new(), Vec::new());
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |_| (),
            |(), due| {
                reports.expected();
                let target_m = due.state.position_m.xy();
                let levels =
                    planning.levels_for(&due.state.velocity_mps, || distance_m(&due.state));
                let [reception, range, sight, timing, multipath] =
                    [E::Reception, E::StationRange, E::Sight, E::Timing, E::Multipath]
                        .map(|e| levels.on(e));
                let mut rng = reporting.key(interval, due).rng(DRAWS);
                heard.clear();
                errors_m.clear();
                // A transponder's antenna is on top or below: the middle of the body.
                let class = truth.class(due.index);
                let height_m = due.state.position_m.z.max(0.5 * class.height_m);
                for station in &config.stations {
                    // The same draws whether it is in sight, decoded or late.
                    let [decoded, late, first, second, delay] =
                        std::array::from_fn(|_| uniform(&mut rng));
                    if reception {
                        planning.count(E::Reception);
                        if decoded >= config.reception {
                            continue;
                        }
                    }
                    if range {
                        planning.count(E::StationRange);
                        if !station.hears(target_m) {
                            continue;
                        }
                    }
                    if sight {
                        planning.count(E::Sight);
                        if !station.sees(&config.buildings, target_m, height_m) {
                            continue;
                        }
                    }
                    heard.push(station.position_m);
                    let (mut noise_m, mut detour_m) = (0.0, 0.0);
                    if timing {
                        planning.count(E::Timing);
                        noise_m =
                            SPEED_OF_LIGHT_MPS * config.sigma_t_s * normal_pair_of(first, second).0;
                    }
                    if multipath {
                        planning.count(E::Multipath);
                        if late < config.multipath {
                            detour_m = config.multipath_m * -libm::log1p(-delay);
                        }
                    }
                    errors_m.push((noise_m, detour_m));
                }
                planning.count(E::Geometry);
                let Some(geometry) = ArrivalGeometry::of(&heard, target_m)
                    .filter(|g| g.horizontal() <= config.max_dilution)
                else {
                    return;
                };
                let (mut timing_m, mut multipath_m) = (Vector2::zeros(), Vector2::zeros());
                for (station_m, (noise_m, detour_m)) in heard.iter().zip(&errors_m) {
                    let shift = geometry.shift(*station_m, target_m);
                    timing_m += shift * *noise_m;
                    multipath_m += shift * *detour_m;
                }
                // What is stated follows from what the system sees: ranges that do not fit together are less certain.
                let whole: Vec<f64> =
                    errors_m.iter().map(|(noise, detour)| noise + detour).collect();
                let left_m2 = geometry.residual_m2(&heard, target_m, &whole);
                let range_m2 = config.range_variance_m2(heard.len(), left_m2);
                let (axis, variance_m2) =
                    ellipse(geometry.covariance_m2(range_m2.sqrt() / SPEED_OF_LIGHT_MPS));
                let altitude_m = reports.barometric_m(due, 0.0);
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m: target_m + timing_m + multipath_m,
                        axis,
                        variance_m2,
                        altitude_m,
                    },
                    true,
                    || {
                        [
                            shown(&levels, E::Geometry, geometry.horizontal(), "of dilution"),
                            shown(&levels, E::Reception, heard.len() as f64, "stations"),
                            shown(&levels, E::Timing, timing_m.norm(), "m"),
                            shown(&levels, E::Multipath, multipath_m.norm(), "m"),
                        ]
                    },
                );
            },
        );
    }
}

/// Reception, times of arrival, late arrivals.
const DRAWS: Purpose = Purpose::Own(21);

const STATION_KEYS: &[Key] = &[
    Key::number("range_m", "m", 1.0, 1e6, "Farthest transmission that the station hears")
        .or("10000"),
    Key::new("blind", Holds::Tables(BLIND_KEYS), "Sectors in which the station hears nothing"),
];

const BLIND_KEYS: &[Key] = &[
    Key::number("from_deg", "°", -360.0, 360.0, "Where the sector begins, clockwise from north")
        .needed(),
    Key::number("to_deg", "°", -360.0, 720.0, "Where it ends, clockwise from its beginning")
        .needed(),
    Key::number("beyond_m", "m", 0.0, 1e6, "Distance beyond which it is deaf there").needed(),
];

const KEYS: &[Key] = &[
    Key::new(
        "stations",
        Holds::Places(STATION_KEYS),
        "The stations, 3 to 64, not all on one line; 15 m high unless they say otherwise",
    )
    .needed(),
    Key::number("sigma_t_s", "s", 1e-12, 1e-5, "Deviation of a time of arrival"),
    Key::number("multipath", "", 0.0, 1.0, "Probability that a time of arrival is late"),
    Key::number("multipath_m", "m", 0.0, 1e4, "Mean of that delay"),
    Key::number(
        "reception",
        "",
        0.0,
        1.0,
        "Probability that a station decodes a transmission that it hears",
    ),
    Key::number(
        "max_dilution",
        "",
        0.5,
        1e4,
        "Largest horizontal dilution of a position that is reported",
    ),
];

/// The kind `mlat`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "mlat",
        title: "Multilateration",
        about: "Positions of transponders from times of arrival at stations: geometry, timing, late arrivals, range, buildings in the way",
        colours: ["#e8e070", "#756b00"],
        symbol: Symbol::DIAMOND,
        radar: false,
        needs_site: false,
        carried: true,
        presets: &[("airport", "5 ns of timing error, a position a second")],
        keys: &[cooperative::KEYS, KEYS],
        draws: &[DRAWS],
        assumed: Assumed::NOTHING,
    },
    read: Some(|given| Ok(Arc::new(MlatConfig::read(given)?))),
    models: &[Modelled {
        model: &MODEL,
        example: |id| Ok(Box::new(Mlat::new(MlatConfig::example(id))?)),
        file: file!(),
    }],
};

impl MlatConfig {
    fn read(given: &Given<'_>) -> Result<Self, ConfigError> {
        let mut config = Self::with_stations(given.id, &[]);
        config.equipped = given.equipage();
        for place in given.places("stations") {
            let number =
                |key: &str, default: f64| place.numbers.get(key).copied().unwrap_or(default);
            let sectors = place.tables.get("blind").map_or(&[][..], Vec::as_slice);
            let blind = sectors.iter().map(|sector| {
                let of = |key: &str| sector.get(key).copied().unwrap_or(f64::NAN);
                BlindSector {
                    from_deg: of("from_deg"),
                    to_deg: of("to_deg"),
                    beyond_m: of("beyond_m"),
                }
            });
            config.stations.push(Station {
                position_m: place.position_m.xy(),
                height_m: if place.has_height { place.position_m.z } else { 15.0 },
                range_m: number("range_m", 10_000.0),
                blind: blind.collect(),
            });
        }
        config.buildings = given.buildings.into();
        given.number("report_s", &mut config.report_s);
        given.number("sigma_t_s", &mut config.sigma_t_s);
        given.number("multipath", &mut config.multipath);
        given.number("multipath_m", &mut config.multipath_m);
        given.number("reception", &mut config.reception);
        given.number("max_dilution", &mut config.max_dilution);
        if config.stations.is_empty() {
            let needed = "a list of at least three places [{ lat_deg = …, lon_deg = … }, …]";
            return Err(ConfigError::Missing { key: "stations", needed });
        }
        Ok(config)
    }

    /// Five stations among sheds.
    fn example(id: SensorId) -> Self {
        let places = [(0.0, 0.0), (4000.0, 0.0), (4000.0, 2500.0), (0.0, 2500.0), (2000.0, -500.0)]
            .map(|(x, y)| Point2::new(x, y));
        let shed = |i: u32| Building {
            name: "shed".into(),
            footprint_m: [(0.0, 0.0), (80.0, 0.0), (80.0, 30.0), (0.0, 30.0)]
                .map(|(x, y)| Point2::new(700.0 + 150.0 * f64::from(i) + x, 800.0 + y))
                .to_vec(),
            height_m: 12.0,
            facade: &crate::environment::surface::MATERIALS[0],
        };
        Self {
            buildings: Arc::from((0..5).map(shed).collect::<Vec<_>>()),
            ..Self::with_stations(id, &places)
        }
    }
}

impl Settings for MlatConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.report_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Mlat::new(self.clone())?))
    }
}

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "multilateration",
    reads_speed: false,
    reads_distance: true,
    costs: &[
        (E::Geometry, Level::Exact, 369),
        (E::Reception, Level::Exact, 0),
        (E::StationRange, Level::Exact, 7),
        (E::Sight, Level::Exact, 836),
        (E::Timing, Level::Exact, 177),
        (E::Multipath, Level::Exact, 5),
    ],
};

/// Multilateration; distances are from the middle of the stations.
fn ladders(config: &MlatConfig, scene: &PositioningScene) -> Ladders {
    let stations = config.stations.len();
    let any_of = |p: f64| -libm::expm1(stations as f64 * libm::log1p(-p.min(1.0 - 1e-16)));
    let middle_m = config.middle_m();
    let far_m = scene.conditions.distance_m;
    let short = config
        .stations
        .iter()
        .filter(|s| !s.blind.is_empty() || (s.position_m - middle_m).norm() + far_m > s.range_m);
    let short = short.count();
    let sigma_m = crate::environment::SPEED_OF_LIGHT * config.sigma_t_s;
    let certain = |n: usize| Loss::odds(if n > 0 { 1.0 } else { 0.0 });
    let late = if config.multipath_m > 0.0 { any_of(config.multipath) } else { 0.0 };
    Ladders {
        model: &MODEL,
        effects: vec![
            given(
                E::Geometry,
                Level::Exact,
                format!("{stations} stations, dilution to {}", config.max_dilution),
                0.0,
            ),
            two(
                E::Reception,
                format!("{} decoded by each station", percent(config.reception)),
                Loss::odds(any_of(1.0 - config.reception)),
            ),
            two(
                E::StationRange,
                format!("{short} stations that may not hear all, targets to {far_m} m"),
                certain(short),
            ),
            two(
                E::Sight,
                format!("{} buildings", config.buildings.len()),
                certain(config.buildings.len()),
            ),
            two(
                E::Timing,
                format!("σ {sigma_m:.2} m per arrival"),
                Loss::moves(SIGMAS * sigma_m * config.max_dilution),
            ),
            two(
                E::Multipath,
                format!(
                    "{} late by {} m on average",
                    percent(config.multipath),
                    config.multipath_m
                ),
                Loss::odds(late),
            ),
        ],
        step_m: 0.0,
    }
}

#[cfg(test)]
mod tests;
