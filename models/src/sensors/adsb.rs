//! Automatic dependent surveillance: the target broadcasts its own satellite position.
//!
//! Errors: the position's (by its accuracy category, correlated in time), the delay between measuring
//! and sending (the target has moved on), and the rounding of the surface position format.
//!
//! Source: RTCA DO-260B / DO-282B (NACp, surface position message, compact position reporting), as
//! described in J. Sun, *The 1090 Megahertz Riddle* (2021). Delays and reception are assumptions.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::draw::{DrawKey, Purpose, uniform};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningScene, rung,
};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::Weather;
use crate::frames::{Point2, Vector2};
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::bounds::{
    GEOMETRY_SHARE, SIGMAS, given, noise, percent, planned, two,
};
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::reporting::statistical::Wander;
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};

/// Radius that holds 95 % of the error for a navigation accuracy category, m; `None` where the
/// category says nothing (below 6) or does not exist.
#[must_use]
pub fn position_uncertainty_m(nacp: u8) -> Option<f64> {
    match nacp {
        11 => Some(3.0),
        10 => Some(10.0),
        9 => Some(30.0),
        8 => Some(92.6),
        7 => Some(185.2),
        6 => Some(555.6),
        _ => None,
    }
}

/// Deviation of each component of a circular error with 95 % within `radius_m`: radius/√(−2 ln 0.05).
#[must_use]
pub fn sigma_of_radius_95(radius_m: f64) -> f64 {
    radius_m / (-2.0 * libm::log(0.05)).sqrt()
}

/// Step of latitude in a surface position, m: 90°/(60 − i)/2¹⁷, i = 0 for even, 1 for odd messages.
#[must_use]
pub fn latitude_step_m(odd: bool) -> f64 {
    90.0 / (60.0 - f64::from(u8::from(odd))) / 131_072.0 * METRES_PER_DEGREE
}

/// Step of longitude in a surface position at `latitude_deg`, m.
#[must_use]
pub fn longitude_step_m(latitude_deg: f64, odd: bool) -> f64 {
    let zones = (longitude_zones(latitude_deg) - f64::from(u8::from(odd))).max(1.0);
    90.0 / zones / 131_072.0 * METRES_PER_DEGREE * libm::cos(latitude_deg.to_radians())
}

/// Number of longitude zones of compact position reporting, 1 to 59.
#[must_use]
pub fn longitude_zones(latitude_deg: f64) -> f64 {
    let latitude = latitude_deg.abs();
    if latitude > 87.0 {
        return 1.0;
    }
    let cos = libm::cos(latitude.to_radians());
    let a = 1.0 - (1.0 - libm::cos(PI / 30.0)) / (cos * cos);
    (2.0 * PI / libm::acos(a.max(-1.0))).floor().clamp(1.0, 59.0)
}

/// Deviation of a value rounded to steps of `step`: step/√12.
#[must_use]
pub fn rounding_sigma(step: f64) -> f64 {
    step / 12_f64.sqrt()
}

/// How far a target moves on while its report is delayed, m.
#[must_use]
pub fn lag_m(speed_mps: f64, latency_s: f64) -> f64 {
    speed_mps * latency_s
}

/// Metres per degree of latitude at 45°.
const METRES_PER_DEGREE: f64 = 111_132.954;

/// Parameters of an [`Adsb`].
#[derive(Clone, Debug, PartialEq)]
pub struct AdsbConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Navigation accuracy category of the targets, 6 to 11.
    pub nacp: u8,
    /// Time between two reports of a moving target, s.
    pub moving_s: f64,
    /// Time between two reports of a standing target, s.
    pub parked_s: f64,
    /// Below this speed a target counts as standing, m/s.
    pub parked_below_mps: f64,
    /// Shortest delay from measurement to transmission, s; each target has its own.
    pub latency_min_s: f64,
    /// Longest delay, s.
    pub latency_max_s: f64,
    /// Share of reports that are received.
    pub reception: f64,
    /// Share of the position's variance that is correlated in time.
    pub correlated_share: f64,
    /// Its correlation time, s.
    pub tau_s: f64,
    /// Latitude of the airport, degrees, for the step of longitude.
    pub latitude_deg: f64,
}

impl AdsbConfig {
    /// Reports of category 10 twice a second when moving, every 5 s when parked.
    #[must_use]
    pub fn surface(id: SensorId, latitude_deg: f64) -> Self {
        Self {
            id,
            equipped: Equipage::all(),
            nacp: 10,
            moving_s: 0.5,
            parked_s: 5.0,
            parked_below_mps: 0.5,
            latency_min_s: 0.1,
            latency_max_s: 0.6,
            reception: 0.95,
            correlated_share: 0.95,
            tau_s: 300.0,
            latitude_deg,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        check(KEYS, "nacp", f64::from(self.nacp))?;
        number("parked_s", self.parked_s, self.moving_s, 3600.0)?;
        check(KEYS, "parked_below_mps", self.parked_below_mps)?;
        check(KEYS, "latency_min_s", self.latency_min_s)?;
        number("latency_max_s", self.latency_max_s, self.latency_min_s, 10.0)?;
        check(KEYS, "reception", self.reception)?;
        check(KEYS, "correlated_share", self.correlated_share)?;
        check(KEYS, "tau_s", self.tau_s)?;
        number("latitude_deg", self.latitude_deg, -90.0, 90.0)
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Adsb,
            equipped: self.equipped.clone(),
            period_s: self.moving_s,
            transponder: true,
        }
    }
}

/// Receiver of position broadcasts on the surface.
#[derive(Clone, Debug)]
pub struct Adsb {
    config: AdsbConfig,
    reporting: Reporting,
    sigma_m: f64,
    /// Steps east and north, even and odd.
    steps_m: [Vector2<f64>; 2],
    fleet: Fleet<Transponder>,
    planning: Planning,
}

#[derive(Clone, Debug, Default)]
struct Transponder {
    wander: Wander,
    /// Its own, drawn when it is first wanted.
    latency_s: Option<f64>,
}

impl Adsb {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: AdsbConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let uncertainty_m = position_uncertainty_m(config.nacp).ok_or(ConfigError::Number {
            key: "nacp",
            value: f64::from(config.nacp),
            min: 6.0,
            max: 11.0,
        })?;
        let steps =
            |odd| Vector2::new(longitude_step_m(config.latitude_deg, odd), latitude_step_m(odd));
        Ok(Self {
            sigma_m: sigma_of_radius_95(uncertainty_m),
            steps_m: [steps(false), steps(true)],
            reporting: config.reporting(),
            planning: Planning::new(config.id, &MODEL),
            config,
            fleet: Fleet::default(),
        })
    }
}

impl Planned for Adsb {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Adsb {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Adsb
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
        let mut reports = Reports::new(reporting, truth, out);
        let parked_every = (config.parked_s / config.moving_s).round().max(1.0) as u64;
        let (sigma_m, steps_m) = (self.sigma_m, self.steps_m);
        if planning.wants_survey(truth.len()) {
            self.fleet.survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
        }
        let step_m = steps_m[0].norm().max(steps_m[1].norm());
        planning.prepare(|scene| ladders(config, sigma_m, step_m, scene));
        let span_s = config.latency_max_s - config.latency_min_s;
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |_| Transponder::default(),
            |transponder, due| {
                let velocity_mps = due.state.velocity_mps.xy();
                let parked = velocity_mps.norm() < config.parked_below_mps;
                if parked && !due.number.is_multiple_of(parked_every) {
                    return;
                }
                reports.expected();
                let key = reporting.key(interval, due);
                let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
                // The error goes on whether the report is received or not.
                let share = (config.correlated_share, config.tau_s);
                let parts = transponder.wander.parts(share, key, due.time, &levels, planning);
                if levels.on(E::Reception) {
                    planning.count(E::Reception);
                    if uniform(&mut key.rng(DRAWS)) >= config.reception {
                        return;
                    }
                }
                let error_m = sigma_m * parts.total();
                let latency_s = match levels.of(E::Latency) {
                    Level::Skipped => 0.0,
                    Level::Cheap => config.latency_min_s + 0.5 * span_s,
                    Level::Middle | Level::Exact => {
                        *transponder.latency_s.get_or_insert_with(|| {
                            let own = DrawKey { scan: u64::MAX, ..key };
                            config.latency_min_s + uniform(&mut own.rng(DRAWS)) * span_s
                        })
                    }
                };
                let mut behind_m = Vector2::zeros();
                if levels.on(E::Latency) {
                    planning.count(E::Latency);
                    behind_m = velocity_mps * latency_s;
                }
                let measured_m = due.state.position_m.xy() + error_m - behind_m;
                let step_m = steps_m[usize::from(due.number % 2 == 1)];
                let mut position_m = measured_m;
                if levels.on(E::Rounding) {
                    planning.count(E::Rounding);
                    position_m = Point2::from(measured_m.coords.zip_map(&step_m, |x, step| {
                        if step > 0.0 { (x / step).round() * step } else { x }
                    }));
                }
                let variance =
                    |step: f64| sigma_m * sigma_m + rounding_sigma(step) * rounding_sigma(step);
                let altitude_m = reports.barometric_m(due, latency_s);
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m,
                        axis: Vector2::new(0.0, 1.0),
                        variance_m2: [variance(step_m.y), variance(step_m.x)],
                        altitude_m,
                    },
                    true,
                    || {
                        let rounded_m = (position_m - measured_m).norm();
                        [
                            shown(&levels, E::Latency, behind_m.norm(), "m"),
                            shown(&levels, E::Rounding, rounded_m, "m"),
                            shown(&levels, E::Correlation, sigma_m * parts.lasting().norm(), "m"),
                            shown(&levels, E::White, sigma_m * parts.fresh().norm(), "m"),
                        ]
                    },
                );
            },
        );
    }
}

/// Reception and delays.
const DRAWS: Purpose = Purpose::Own(20);

const KEYS: &[Key] = &[
    Key::whole("nacp", 6, 11, "Navigation accuracy category of the targets"),
    Key::number(
        "parked_s",
        "s",
        0.01,
        3600.0,
        "Time between two reports of a standing target, not less than `report_s`",
    ),
    Key::number(
        "parked_below_mps",
        "m/s",
        0.0,
        100.0,
        "Below this speed a target counts as standing",
    ),
    Key::number(
        "latency_min_s",
        "s",
        0.0,
        10.0,
        "Shortest delay from measuring to sending; each target has its own",
    ),
    Key::number("latency_max_s", "s", 0.0, 10.0, "Longest delay from measuring to sending"),
    Key::number("reception", "", 0.0, 1.0, "Share of reports that are received"),
    Key::number(
        "correlated_share",
        "",
        0.0,
        1.0,
        "Share of the position's variance that is correlated in time",
    ),
    Key::number("tau_s", "s", 1e-3, 1e6, "Correlation time of that share"),
];

/// The kind `adsb`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "adsb",
        title: "ADS-B",
        about: "Broadcasts of the target's own satellite position: accuracy category, delay, rounding of the surface format, reception",
        colours: ["#ef8fc0", "#a82a70"],
        symbol: Symbol::TRIANGLE,
        radar: false,
        needs_site: false,
        carried: true,
        presets: &[("surface", "category 10, twice a second when moving, every 5 s when parked")],
        keys: &[cooperative::KEYS, KEYS],
        draws: &[DRAWS],
        // What its delay is off the nominal one, at taxi speeds.
        assumed: Assumed {
            slow_share: 0.95,
            slow_tau_s: 300.0,
            extra_sigma_m: 3.0,
            ..Assumed::NOTHING
        },
    },
    read: Some(|given| Ok(Arc::new(AdsbConfig::read(given)))),
    models: &[Modelled {
        model: &MODEL,
        example: |id| {
            let config = AdsbConfig { moving_s: 1.0, ..AdsbConfig::surface(id, 47.45) };
            Ok(Box::new(Adsb::new(config)?))
        },
        file: file!(),
    }],
};

impl AdsbConfig {
    fn read(given: &Given<'_>) -> Self {
        let mut config = Self::surface(given.id, given.reference.lat_deg());
        config.equipped = given.equipage();
        let mut nacp = f64::from(config.nacp);
        given.number("nacp", &mut nacp);
        config.nacp = nacp as u8;
        given.number("report_s", &mut config.moving_s);
        given.number("parked_s", &mut config.parked_s);
        given.number("parked_below_mps", &mut config.parked_below_mps);
        given.number("latency_min_s", &mut config.latency_min_s);
        given.number("latency_max_s", &mut config.latency_max_s);
        given.number("reception", &mut config.reception);
        given.number("correlated_share", &mut config.correlated_share);
        given.number("tau_s", &mut config.tau_s);
        config
    }
}

impl Settings for AdsbConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.moving_s, 0.5 * (self.latency_min_s + self.latency_max_s))
    }

    fn standing_s(&self) -> f64 {
        self.parked_s
    }

    fn late_sigma_s(&self) -> f64 {
        (self.latency_max_s - self.latency_min_s) / 12f64.sqrt()
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Adsb::new(self.clone())?))
    }
}

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "ADS-B",
    reads_speed: true,
    reads_distance: false,
    costs: &[
        (E::Geometry, Level::Cheap, 0),
        (E::Reception, Level::Exact, 61),
        (E::Latency, Level::Cheap, 0),
        (E::Latency, Level::Exact, 0),
        (E::Rounding, Level::Exact, 13),
        (E::Correlation, Level::Exact, 126),
        (E::White, Level::Exact, 121),
    ],
};

/// Position broadcasts with position deviation `sigma_m`, rounded to steps of up to `step_m` (the
/// diagonal of a step east and north).
fn ladders(config: &AdsbConfig, sigma_m: f64, step_m: f64, scene: &PositioningScene) -> Ladders {
    let speed_mps = scene.conditions.speed_mps;
    let (least_s, most_s) = (config.latency_min_s, config.latency_max_s);
    let latency = planned(
        E::Latency,
        format!("{least_s} to {most_s} s at up to {speed_mps} m/s"),
        vec![
            rung(Level::Skipped, Loss::moves(speed_mps * most_s)),
            rung(Level::Cheap, Loss::moves(0.5 * speed_mps * (most_s - least_s))),
            rung(Level::Exact, Loss::NONE),
        ],
    );
    let [correlated, white] = noise(sigma_m, config.correlated_share, config.tau_s);
    let called = format!("accuracy category {}, fixed by the scene", config.nacp);
    Ladders {
        model: &MODEL,
        effects: vec![
            given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            two(
                E::Reception,
                format!("{} received", percent(config.reception)),
                Loss::odds(1.0 - config.reception),
            ),
            latency,
            two(E::Rounding, format!("steps of {step_m:.2} m"), Loss::moves(0.5 * step_m)),
            correlated,
            white,
        ],
        step_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector3;
    use crate::plot::Plot;
    use crate::sensors::testing::Parked;
    use crate::time::SimTime;

    fn scan(config: AdsbConfig, truth: &Parked, seconds: u64) -> PlotSink {
        let mut adsb = Adsb::new(config).expect("sound");
        let mut sink = PlotSink { explain: true, ..PlotSink::default() };
        for scan in 1..=seconds {
            let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
            let interval = ScanInterval { run_seed: 2, scan, from: at(scan - 1), to: at(scan) };
            adsb.scan(&interval, truth, &Weather::default(), &mut sink);
        }
        sink
    }

    #[test]
    fn zones_are_those_of_the_standard() {
        // Transition latitudes of the standard's table.
        for (latitude, zones) in [
            (0.0, 59.0),
            (10.47, 59.0),
            (10.471, 58.0),
            (47.45, 40.0),
            (-60.0, 29.0),
            (86.53, 3.0),
            (86.99, 2.0),
            (87.0, 2.0),
            (89.0, 1.0),
            (90.0, 1.0),
        ] {
            assert_eq!(longitude_zones(latitude), zones, "{latitude}");
        }
        assert!(longitude_step_m(90.0, true).abs() < 1e-9, "at the pole longitude is nothing");
    }

    #[test]
    fn an_aircraft_tells_its_height_in_steps_of_25_feet_as_old_as_its_position() {
        let mut truth = Parked::aircraft(&[3, 7]);
        truth.velocity_mps = Vector3::new(70.0, 0.0, 4.0);
        let sink = scan(AdsbConfig::surface(SensorId(3), 47.5), &truth, 40);
        assert!(sink.plots.len() > 100);
        let mut steps = std::collections::BTreeSet::new();
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let told_m = plot.altitude_m.expect("told");
            let step = told_m / (25.0 * 0.3048);
            assert!((step - step.round()).abs() < 1e-9 && step.is_sign_positive(), "{told_m}");
            let age_s = lag(cause).expect("late") / 70.0;
            let then_m = 4.0 * (plot.time.s() - age_s);
            assert!((told_m - then_m).abs() <= 12.5 * 0.3048 + 1e-6, "{told_m} for {then_m}");
            steps.insert(step as i64);
        }
        assert!(steps.len() > 15, "{steps:?}");
        let cars = scan(AdsbConfig::surface(SensorId(3), 47.5), &truth.of_vehicles(), 40);
        assert!(!cars.plots.is_empty() && cars.plots.iter().all(|p| p.altitude_m.is_none()));
        // Heights draw nothing: the same places.
        let same = |(a, b): (&Plot, &Plot)| a.position_m == b.position_m && a.time == b.time;
        assert!(sink.plots.iter().zip(&cars.plots).all(same));
    }

    /// What the latency did to a report; `None` where it was left out.
    fn lag(cause: &crate::sensors::Cause) -> Option<f64> {
        cause.effects.iter().find(|e| e.effect == "latency").map(|e| e.value)
    }

    #[test]
    fn standing_targets_report_seldom_and_lag_nothing() {
        let config = AdsbConfig { reception: 1.0, ..AdsbConfig::surface(SensorId(1), 47.45) };
        let keys: Vec<u64> = (0..200).collect();
        let mut truth = Parked::aircraft(&keys);
        let parked = scan(config.clone(), &truth, 20);
        assert_eq!(parked.plots.len() as u64, parked.looks);
        assert_eq!(parked.plots.len(), 200 * 4);
        assert!(parked.causes.iter().all(|c| lag(c).is_none()));
        truth.velocity_mps = Vector3::new(0.0, 70.0, 0.0);
        let moving = scan(config, &truth, 20);
        assert_eq!(moving.plots.len(), 200 * 40);
        let lags: Vec<f64> = moving.causes.iter().filter_map(lag).collect();
        assert_eq!(lags.len(), moving.causes.len());
        assert!(lags.iter().all(|l| (7.0..=42.0).contains(l)), "0.1 to 0.6 s at 70 m/s");
        let mean = lags.iter().sum::<f64>() / lags.len() as f64;
        assert!((mean - 24.5).abs() < 2.0, "{mean}");
    }

    #[test]
    fn the_error_is_that_of_its_category() {
        let keys: Vec<u64> = (0..4000).collect();
        for nacp in [9, 10, 11] {
            let config = AdsbConfig {
                nacp,
                parked_s: 0.5,
                reception: 0.8,
                ..AdsbConfig::surface(SensorId(1), 47.45)
            };
            let sink = scan(config, &Parked::aircraft(&keys), 1);
            let share = sink.plots.len() as f64 / sink.looks as f64;
            assert!((share - 0.8).abs() < 4.0 * (0.16 / 8000.0_f64).sqrt(), "{share}");
            let radius_m = position_uncertainty_m(nacp).expect("known");
            let within = sink
                .plots
                .iter()
                .zip(&sink.causes)
                .filter(|(p, c)| (p.position_m - c.truth_m.expect("a target")).norm() <= radius_m)
                .count();
            let held = within as f64 / sink.plots.len() as f64;
            // Two reports of a target are one sample; rounding adds a little at category 11.
            assert!((held - 0.95).abs() < if nacp == 11 { 0.03 } else { 0.014 }, "{nacp}: {held}");
        }
        for nacp in [0, 5, 12] {
            let config = AdsbConfig { nacp, ..AdsbConfig::surface(SensorId(1), 0.0) };
            assert!(matches!(Adsb::new(config), Err(ConfigError::Number { key: "nacp", .. })));
        }
    }
}
