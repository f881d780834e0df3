//! A camera on a mast: whoever is near enough is seen once a second, with a white error.

use crate::draw::{Purpose, normal_pair};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningScene,
};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::Weather;
use crate::frames::{Point2, Vector2};
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::bounds::{SIGMAS, two};
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use std::sync::Arc;

const DRAWS: Purpose = Purpose::Own(90);

const KEYS: &[Key] = &[
    Key::number("range_m", "m", 10.0, 5000.0, "Farthest target that it sees"),
    Key::number("sigma_m", "m", 1e-3, 100.0, "White error, deviation of each component"),
];

/// The kind `camera`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "camera",
        title: "Camera",
        about: "Targets in sight, with a white error",
        colours: ["#6fb3a8", "#245a52"],
        symbol: Symbol::RING,
        radar: false,
        needs_site: true,
        carried: false,
        presets: &[("mast", "800 m, half a metre")],
        keys: &[cooperative::KEYS, KEYS],
        draws: &[DRAWS],
        assumed: Assumed::NOTHING,
    },
    read: Some(|given| Ok(Arc::new(CameraConfig::read(given)))),
    models: &[Modelled {
        model: &MODEL,
        example: |id| Ok(Box::new(Camera::new(CameraConfig::mast(id, Point2::origin()))?)),
        file: file!(),
    }],
};

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "camera",
    reads_speed: false,
    reads_distance: false,
    costs: &[(E::White, Level::Exact, 100)],
};

#[derive(Clone, Debug)]
struct CameraConfig {
    id: SensorId,
    site_m: Point2<f64>,
    equipped: Equipage,
    report_s: f64,
    range_m: f64,
    sigma_m: f64,
}

impl CameraConfig {
    fn mast(id: SensorId, site_m: Point2<f64>) -> Self {
        let equipped = Equipage::all();
        Self { id, site_m, equipped, report_s: 1.0, range_m: 800.0, sigma_m: 0.5 }
    }

    fn read(given: &Given<'_>) -> Self {
        let mut config = Self::mast(given.id, given.place_m());
        config.equipped = given.equipage();
        given.number("report_s", &mut config.report_s);
        given.number("range_m", &mut config.range_m);
        given.number("sigma_m", &mut config.sigma_m);
        config
    }

    fn reporting(&self) -> Reporting {
        let (id, equipped) = (self.id, self.equipped.clone());
        Reporting { id, kind: SensorKind(&DECLARED.kind), equipped, period_s: self.report_s }
    }
}

impl Settings for CameraConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        check(KEYS, "range_m", self.range_m)?;
        check(KEYS, "sigma_m", self.sigma_m)
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.report_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Camera::new(self.clone())?))
    }
}

struct Camera {
    config: CameraConfig,
    reporting: Reporting,
    fleet: Fleet<()>,
    planning: Planning,
}

impl Camera {
    fn new(config: CameraConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let planning = Planning::new(config.id, &MODEL);
        Ok(Self { reporting: config.reporting(), config, fleet: Fleet::default(), planning })
    }
}

fn ladders(config: &CameraConfig, _: &PositioningScene) -> Ladders {
    let white = Loss::moves(SIGMAS * config.sigma_m);
    let called = format!("σ {} m", config.sigma_m);
    Ladders { model: &MODEL, effects: vec![two(E::White, called, white)], step_m: 0.0 }
}

impl Planned for Camera {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Camera {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        self.reporting.kind
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
        let (config, reporting, planning) = (&self.config, &self.reporting, &mut self.planning);
        let mut reports = Reports::new(reporting, truth, out);
        if planning.wants_survey(truth.len()) {
            self.fleet.survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
        }
        planning.prepare(|scene| ladders(config, scene));
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |_| (),
            |(), due| {
                let place_m = due.state.position_m.xy();
                if (place_m - config.site_m).norm() > config.range_m {
                    return;
                }
                reports.expected();
                let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
                let mut error_m = Vector2::zeros();
                if levels.on(E::White) {
                    planning.count(E::White);
                    let (a, b) = normal_pair(&mut reporting.key(interval, due).rng(DRAWS));
                    error_m = config.sigma_m * Vector2::new(a, b);
                }
                let fix = Fix {
                    time: due.time,
                    position_m: place_m + error_m,
                    axis: Vector2::new(1.0, 0.0),
                    variance_m2: [config.sigma_m * config.sigma_m; 2],
                    altitude_m: None,
                };
                reports.push(due, fix, false, || [shown(&levels, E::White, error_m.norm(), "m")]);
            },
        );
    }
}
