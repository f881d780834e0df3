//! On-board dead reckoning ("dynamic" sensor): odometer and heading, sent by the target.
//!
//! The position drifts with the way travelled: a scale error of the odometer along the way, a heading
//! error that wanders across it. The drift is taken off where the place is known (a loop, a stand).
//! The covariance follows the same linear equations as the error, so it is what it says.
//!
//! Source: error propagation of dead reckoning, as in Borenstein & Feng, "Measurement and correction
//! of systematic odometry errors", IEEE Trans. Robotics and Automation 12 (1996); figures assumed.

use nalgebra::{Matrix4, Vector4};

use crate::draw::{DrawKey, Purpose, normal_pair, normal_pair_of, uniform};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningLevels, PositioningScene,
};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::Weather;
use crate::frames::ellipse;
use crate::frames::{Point2, Vector2};
use crate::keys::{Holds, Key};
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, count, number};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::bounds::{SIGMAS, percent, two};
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;
use std::sync::Arc;

/// Parameters of a [`Dynamic`].
#[derive(Clone, Debug, PartialEq)]
pub struct DynamicConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Time between two reports of a target, s.
    pub report_s: f64,
    /// Scale error of the odometer, deviation over targets.
    pub sigma_scale: f64,
    /// Heading error at the start, deviation, degrees.
    pub sigma_heading_deg: f64,
    /// Growth of the heading error, degrees per root of an hour.
    pub heading_walk_deg_per_sqrt_h: f64,
    /// Position error at the start and after a reset, m.
    pub sigma_start_m: f64,
    /// White error of each report, m.
    pub sigma_white_m: f64,
    /// Places where the position becomes known again, airport frame, m; at most 256.
    pub resets_m: Vec<Point2<f64>>,
    /// How near a target must come to one, m.
    pub reset_radius_m: f64,
}

impl DynamicConfig {
    /// 0.5 % of the way along, half a degree across, growing by 3° in an hour.
    #[must_use]
    pub fn odometer(id: SensorId) -> Self {
        Self {
            id,
            equipped: Equipage::all(),
            report_s: 1.0,
            sigma_scale: 0.005,
            sigma_heading_deg: 0.5,
            heading_walk_deg_per_sqrt_h: 3.0,
            sigma_start_m: 1.0,
            sigma_white_m: 0.2,
            resets_m: Vec::new(),
            reset_radius_m: 10.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        check(KEYS, "sigma_scale", self.sigma_scale)?;
        check(KEYS, "sigma_heading_deg", self.sigma_heading_deg)?;
        check(KEYS, "heading_walk_deg_per_sqrt_h", self.heading_walk_deg_per_sqrt_h)?;
        check(KEYS, "sigma_start_m", self.sigma_start_m)?;
        check(KEYS, "sigma_white_m", self.sigma_white_m)?;
        count("resets_m", self.resets_m.len(), 0, 256)?;
        for place in &self.resets_m {
            number("reset_east_m", place.x, -1e6, 1e6)?;
            number("reset_north_m", place.y, -1e6, 1e6)?;
        }
        check(KEYS, "reset_radius_m", self.reset_radius_m)
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Dynamic,
            equipped: self.equipped.clone(),
            period_s: self.report_s,
            transponder: false,
        }
    }
}

/// Drift of one target, with its covariance.
#[derive(Clone, Debug)]
struct Drift {
    /// Errors east and north (m) from the start, from the scale, and from the heading.
    parts_m: [Vector2<f64>; 3],
    /// Errors of the scale and of the heading (rad).
    rates: [f64; 2],
    covariance: Matrix4<f64>,
    last: (SimTime, Point2<f64>),
}

impl Drift {
    fn start(config: &DynamicConfig, key: DrawKey, now: SimTime, position_m: Point2<f64>) -> Self {
        let mut rng = DrawKey { scan: u64::MAX, ..key }.rng(DRAWS);
        let (a, b) = normal_pair(&mut rng);
        let (c, d) = normal_pair(&mut rng);
        let sigma = Vector4::new(
            config.sigma_start_m,
            config.sigma_start_m,
            config.sigma_scale,
            config.sigma_heading_deg.to_radians(),
        );
        Self {
            parts_m: [Vector2::new(sigma[0] * a, sigma[1] * b), Vector2::zeros(), Vector2::zeros()],
            rates: [sigma[2] * c, sigma[3] * d],
            covariance: Matrix4::from_diagonal(&sigma.component_mul(&sigma)),
            last: (now, position_m),
        }
    }

    /// The way since the last report adds scale and heading error to the position.
    fn advance(
        &mut self,
        config: &DynamicConfig,
        normal: f64,
        now: SimTime,
        position_m: Point2<f64>,
        levels: &PositioningLevels,
    ) {
        let (then, there_m) = self.last;
        let way_m = position_m - there_m;
        let walk = config.heading_walk_deg_per_sqrt_h.to_radians();
        let q = walk * walk * now.since_s(then) / 3600.0;
        // A clockwise heading error turns the way to its right.
        let right_m = Vector2::new(way_m.y, -way_m.x);
        let mut f = Matrix4::identity();
        (f[(0, 2)], f[(1, 2)]) = (way_m.x, way_m.y);
        (f[(0, 3)], f[(1, 3)]) = (right_m.x, right_m.y);
        if levels.on(E::Scale) {
            self.parts_m[1] += way_m * self.rates[0];
        }
        if levels.on(E::Heading) {
            self.parts_m[2] += right_m * self.rates[1];
        }
        self.rates[1] += q.sqrt() * normal;
        let moved = f * self.covariance * f.transpose();
        self.covariance = 0.5 * (moved + moved.transpose());
        self.covariance[(3, 3)] += q;
        self.last = (now, position_m);
    }

    /// The error of the position, m.
    fn error_m(&self, levels: &PositioningLevels) -> Vector2<f64> {
        let start_m = if levels.on(E::Start) { self.parts_m[0] } else { Vector2::zeros() };
        start_m + self.parts_m[1] + self.parts_m[2]
    }

    /// The position becomes known: its error is drawn anew, scale and heading stay as they are.
    fn reset(&mut self, config: &DynamicConfig, (east, north): (f64, f64)) {
        self.parts_m = [Vector2::zeros(); 3];
        self.parts_m[0] = config.sigma_start_m * Vector2::new(east, north);
        for i in 0..2 {
            for j in 0..4 {
                self.covariance[(i, j)] = 0.0;
                self.covariance[(j, i)] = 0.0;
            }
            self.covariance[(i, i)] = config.sigma_start_m * config.sigma_start_m;
        }
    }
}

/// Dead reckoning reported by equipped targets.
#[derive(Clone, Debug)]
pub struct Dynamic {
    config: DynamicConfig,
    reporting: Reporting,
    fleet: Fleet<Drift>,
    planning: Planning,
}

impl Dynamic {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: DynamicConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting();
        let planning = Planning::new(config.id, &MODEL);
        Ok(Self { config, reporting, fleet: Fleet::default(), planning })
    }
}

impl Planned for Dynamic {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Dynamic {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Dynamic
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
        if planning.wants_survey(truth.len()) {
            self.fleet.survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
        }
        planning.prepare(|scene| ladders(config, scene));
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |due| {
                let key = reporting.key(interval, due);
                Drift::start(config, key, due.time, due.state.position_m.xy())
            },
            |drift, due| {
                reports.expected();
                let position_m = due.state.position_m.xy();
                let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
                let known = config
                    .resets_m
                    .iter()
                    .any(|place| (place - position_m).norm() <= config.reset_radius_m);
                // One stream for all: what is left out takes its draws with it.
                let (walks, whites) = (levels.on(E::Heading), levels.on(E::White));
                let mut rng =
                    (walks || whites || known).then(|| reporting.key(interval, due).rng(DRAWS));
                let mut pair = |used: bool| {
                    let mut draw = || rng.as_mut().map_or(0.0, uniform);
                    let (first, second) = (draw(), draw());
                    if used { normal_pair_of(first, second) } else { (0.0, 0.0) }
                };
                let (walk, white, fresh) = (pair(walks).0, pair(whites), pair(known));
                for effect in [E::Scale, E::Heading, E::Start, E::White] {
                    planning.add(effect, u64::from(levels.on(effect)));
                }
                drift.advance(config, walk, due.time, position_m, &levels);
                if known {
                    drift.reset(config, fresh);
                }
                let p = &drift.covariance;
                let white_m2 = config.sigma_white_m * config.sigma_white_m;
                let (axis, variance_m2) =
                    ellipse([p[(0, 0)] + white_m2, p[(0, 1)], p[(1, 1)] + white_m2]);
                let drift_m = drift.error_m(&levels);
                let white_m = if levels.on(E::White) {
                    config.sigma_white_m * Vector2::new(white.0, white.1)
                } else {
                    Vector2::zeros()
                };
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m: position_m + drift_m + white_m,
                        axis,
                        variance_m2,
                        altitude_m: None,
                    },
                    true,
                    || {
                        let [start, scale, heading] = drift.parts_m.map(|part| part.norm());
                        [
                            shown(&levels, E::Scale, scale, "m"),
                            shown(&levels, E::Heading, heading, "m"),
                            shown(&levels, E::Start, start, "m"),
                            shown(&levels, E::White, white_m.norm(), "m"),
                        ]
                    },
                );
            },
        );
    }
}

/// Scale, heading and its walk, positions at the start, noise.
const DRAWS: Purpose = Purpose::Own(23);

const KEYS: &[Key] = &[
    Key::number("sigma_scale", "", 0.0, 1.0, "Scale error of the odometer, deviation over targets"),
    Key::number("sigma_heading_deg", "°", 0.0, 90.0, "Heading error at the start, deviation"),
    Key::number("heading_walk_deg_per_sqrt_h", "°/√h", 0.0, 360.0, "Growth of the heading error"),
    Key::number("sigma_start_m", "m", 1e-3, 1e4, "Position error at the start and after a reset"),
    Key::number("sigma_white_m", "m", 0.0, 1e4, "White error of each report"),
    Key::new(
        "resets",
        Holds::Places(&[]),
        "Places where the position becomes known again; at most 256",
    ),
    Key::number("reset_radius_m", "m", 0.0, 1e4, "How near a target must come to one"),
];

/// The kind `dynamic`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "dynamic",
        title: "Odometer and heading",
        about: "On-board dead reckoning: scale and heading errors that grow with the way, reset at known places",
        colours: ["#9fb0ff", "#3c4fc0"],
        symbol: Symbol::WEDGE,
        radar: false,
        needs_site: false,
        carried: true,
        presets: &[(
            "odometer",
            "0.5 % of the way along, half a degree across, growing by 3° in an hour",
        )],
        keys: &[cooperative::KEYS, KEYS],
        draws: &[DRAWS],
        assumed: Assumed::NOTHING,
    },
    read: Some(|given| Ok(Arc::new(DynamicConfig::read(given)))),
    models: &[Modelled {
        model: &MODEL,
        example: |id| Ok(Box::new(Dynamic::new(DynamicConfig::odometer(id))?)),
        file: file!(),
    }],
};

impl DynamicConfig {
    fn read(given: &Given<'_>) -> Self {
        let mut config = Self::odometer(given.id);
        config.equipped = given.equipage();
        given.number("report_s", &mut config.report_s);
        given.number("sigma_scale", &mut config.sigma_scale);
        given.number("sigma_heading_deg", &mut config.sigma_heading_deg);
        given.number("heading_walk_deg_per_sqrt_h", &mut config.heading_walk_deg_per_sqrt_h);
        given.number("sigma_start_m", &mut config.sigma_start_m);
        given.number("sigma_white_m", &mut config.sigma_white_m);
        given.number("reset_radius_m", &mut config.reset_radius_m);
        config.resets_m = given.places("resets").iter().map(|p| p.position_m.xy()).collect();
        config
    }
}

impl Settings for DynamicConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.report_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Dynamic::new(self.clone())?))
    }
}

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "odometer",
    reads_speed: true,
    reads_distance: false,
    costs: &[
        (E::Scale, Level::Exact, 1),
        (E::Heading, Level::Exact, 124),
        (E::Start, Level::Exact, 0),
        (E::White, Level::Exact, 123),
    ],
};

/// On-board dead reckoning.
fn ladders(config: &DynamicConfig, scene: &PositioningScene) -> Ladders {
    let (speed_mps, horizon_s) = (scene.conditions.speed_mps, scene.horizon_s);
    let way_m = if speed_mps > 0.0 { speed_mps * horizon_s } else { 0.0 };
    let of = |sigma: f64| if sigma > 0.0 && way_m > 0.0 { SIGMAS * sigma * way_m } else { 0.0 };
    let walk_rad = config.heading_walk_deg_per_sqrt_h.to_radians() * (horizon_s / 3600.0).sqrt();
    let heading = of(config.sigma_heading_deg.to_radians()) + of(walk_rad);
    let called = if way_m > 0.0 { format!("ways to {way_m} m") } else { "nobody moves".into() };
    Ladders {
        model: &MODEL,
        effects: vec![
            two(
                E::Scale,
                format!("{} of the way, {called}", percent(config.sigma_scale)),
                Loss::moves(of(config.sigma_scale)),
            ),
            two(
                E::Heading,
                format!(
                    "{}° and {}°/√h, {called}",
                    config.sigma_heading_deg, config.heading_walk_deg_per_sqrt_h
                ),
                Loss::moves(heading),
            ),
            two(
                E::Start,
                format!(
                    "σ {} m at the start, {} known places",
                    config.sigma_start_m,
                    config.resets_m.len()
                ),
                Loss::moves(std::f64::consts::SQRT_2 * SIGMAS * config.sigma_start_m),
            ),
            two(
                E::White,
                format!("σ {} m", config.sigma_white_m),
                Loss::moves(SIGMAS * config.sigma_white_m),
            ),
        ],
        step_m: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector3;
    use crate::sensors::testing::Parked;

    fn run(config: DynamicConfig, speed_mps: f64, seconds: u64) -> PlotSink {
        let keys: Vec<u64> = (0..1500).collect();
        let mut truth = Parked::aircraft(&keys);
        truth.velocity_mps = Vector3::new(speed_mps, 0.0, 0.0);
        let mut sensor = Dynamic::new(config).expect("sound");
        let mut sink = PlotSink::default();
        for scan in 1..=seconds {
            sink = PlotSink::default();
            let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
            let interval = ScanInterval { run_seed: 6, scan, from: at(scan - 1), to: at(scan) };
            sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
        }
        sink
    }

    fn spread(sink: &PlotSink) -> (f64, f64, f64) {
        let n = sink.plots.len() as f64;
        let (mut east, mut north, mut chi) = (0.0, 0.0, 0.0);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let error = plot.position_m - cause.truth_m.expect("a target");
            let (along, across) = (error.dot(&plot.axis), error.dot(&plot.across_axis()));
            chi += along * along / plot.along_m2 + across * across / plot.across_m2;
            east += error.x * error.x;
            north += error.y * error.y;
        }
        ((east / n).sqrt(), (north / n).sqrt(), chi / n)
    }

    #[test]
    fn the_drift_grows_with_the_way_and_is_as_large_as_it_says() {
        let config = DynamicConfig::odometer(SensorId(9));
        let (east, north, chi) = spread(&run(config.clone(), 10.0, 100));
        // 1 km: 5 m along, 8.7 m across by the first half degree; 1 m at the start.
        assert!((east - 26_f64.sqrt()).abs() < 0.4, "{east}");
        assert!(north > 8.0 && north < 10.5, "{north}");
        assert!((chi - 2.0).abs() < 4.0 * 2.0 / 1500_f64.sqrt(), "{chi}");
        let (east, north, chi) = spread(&run(config, 0.0, 100));
        assert!((east - 1.02).abs() < 0.08 && (north - 1.02).abs() < 0.08, "standing: no drift");
        assert!((chi - 2.0).abs() < 0.21, "{chi}");
    }

    #[test]
    fn a_known_place_takes_the_drift_off() {
        // Each target passes its own place at 905 m; 80 m or 0.4 m of drift are left after it.
        let config = DynamicConfig {
            resets_m: (0..250).map(|k| Point2::new(905.0, f64::from(k) * 100.0)).collect(),
            reset_radius_m: 10.0,
            ..DynamicConfig::odometer(SensorId(9))
        };
        let mut sink = run(config, 10.0, 100);
        sink.plots.truncate(250);
        let (east, _, chi) = spread(&sink);
        assert!(east < 1.3, "{east}");
        assert!((chi - 2.0).abs() < 4.0 * 2.0 / 250_f64.sqrt(), "{chi}");
    }
}
