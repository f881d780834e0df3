//! Satellite positioning reported by the target, at one of three levels ([`GpsModel`]).
//!
//! | level | geometry | failures | errors |
//! | --- | --- | --- | --- |
//! | statistical | none | alternating services | north and east with their own deviation |
//! | constellation | dilution of 24 slots | satellites fail and are repaired | range deviation × dilution |
//! | per satellite | the same | the same | ranges by source, least squares |
//!
//! Which effects of a level are simulated is planned ([`crate::effects::positioning`]).
//!
//! Source of the statistical level: prior probability model P = P_c · P_sa · P_sr of satellite
//! services with independent Gaussian errors in north and east. Figures of the presets: GPS SPS
//! Signal Specification (1995), SPS Performance Standard (2001, 2020).

pub(crate) mod bounds;

use crate::effects::positioning::{Model, Planning, PositioningEffect as E};
use crate::effects::{Level, PlanRow};
use crate::environment::Weather;
use crate::frames::{Matrix2, Vector2, ellipse};
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::constellation::{self, Dop, Sky, SkyConfig, SkyEpoch, prepare_sky};
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::reporting::ranging::{self, Ranging, RangingConfig, RangingReceiver, Want};
use crate::sensors::reporting::service::{Alternating, Service, read_services};
use crate::sensors::reporting::statistical::{
    ERROR_KEYS, NorthEast, Quality, Receiver, SERVICE_KEYS, SOFT_KEYS, SoftFailure, Wander,
    read_soft, validate_service,
};
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use std::sync::Arc;

/// The statistical level: services and errors without satellites.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistical {
    /// Coverage, availability, reliability, each receiver by itself.
    pub service: Service,
    /// Error while the service is reliable.
    pub error: NorthEast,
    /// What is added while it is not.
    pub soft: SoftFailure,
}

impl Statistical {
    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        validate_service(&self.service)?;
        self.error.validate()?;
        self.soft.validate()
    }
}

/// The constellation level: outages and dilution from the satellites, one deviation for all ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct Diluted {
    /// Satellites, site, mask, failures.
    pub sky: SkyConfig,
    /// Deviation of one range (user equivalent range error), m.
    pub uere_m: f64,
    /// Share of the variance that is correlated in time, 0 to 1.
    pub correlated_share: f64,
    /// Its correlation time, s.
    pub tau_s: f64,
}

impl Diluted {
    /// The reference constellation with 3.6 m per range (7 m at 95 %).
    #[must_use]
    pub fn reference(sky: SkyConfig) -> Self {
        Self { sky, uere_m: 3.6, correlated_share: 0.95, tau_s: 300.0 }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.sky.validate()?;
        check(DILUTED_KEYS, "uere_m", self.uere_m)?;
        check(ERROR_KEYS, "correlated_share", self.correlated_share)?;
        check(ERROR_KEYS, "tau_s", self.tau_s)
    }
}

/// How satellite positioning is modelled, cheap first.
#[derive(Clone, Debug, PartialEq)]
pub enum GpsModel {
    /// By statistics of north and east.
    Statistical(Statistical),
    /// By the dilution of what is in view.
    Constellation(Diluted),
    /// Range by range.
    PerSatellite(RangingConfig),
}

/// Parameters of a [`Gps`].
#[derive(Clone, Debug, PartialEq)]
pub struct GpsConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Time between two reports of a target, s.
    pub report_s: f64,
    /// Level and its parameters.
    pub model: GpsModel,
}

/// Outages of the presets: coverage hole 10 min, unavailability 30 min, unreliability 6 h.
fn service(coverage: f64, availability: f64, reliability: f64) -> Service {
    Service {
        coverage: Alternating::from_share(coverage, 600.0),
        availability: Alternating::from_share(availability, 1800.0),
        reliability: Alternating::from_share(reliability, 21_600.0),
    }
}

impl Statistical {
    /// SPS of 1995 with selective availability: 100 m (95 %) horizontal, spread over north and east
    /// as the geometry of 42–50° north does (σ_E = 0.725 σ_N).
    #[must_use]
    pub fn sps_1995() -> Self {
        Self {
            service: service(0.999, 0.9985, 0.9997),
            error: NorthEast {
                mean_north_m: 0.0,
                mean_east_m: 0.0,
                sigma_north_m: 46.18,
                sigma_east_m: 33.48,
                correlated_share: 0.99,
                tau_s: 150.0,
            },
            soft: SoftFailure { step_m: 500.0, ramp_m_per_s: 0.5, limit_m: 5000.0 },
        }
    }

    /// SPS of 2001, without selective availability: 13 m (95 %) horizontal.
    #[must_use]
    pub fn sps_2001() -> Self {
        Self {
            error: NorthEast {
                sigma_north_m: 6.00,
                sigma_east_m: 4.35,
                correlated_share: 0.95,
                tau_s: 300.0,
                ..Self::sps_1995().error
            },
            soft: SoftFailure { step_m: 30.0, ramp_m_per_s: 0.5, limit_m: 5000.0 },
            ..Self::sps_1995()
        }
    }

    /// SPS of 2020: 8 m (95 %) horizontal.
    #[must_use]
    pub fn sps_2020() -> Self {
        Self {
            service: service(0.999, 0.9995, 0.9997),
            error: NorthEast { sigma_north_m: 3.69, sigma_east_m: 2.68, ..Self::sps_2001().error },
            ..Self::sps_2001()
        }
    }
}

impl GpsConfig {
    /// Everybody equipped, a report a second, at this level.
    #[must_use]
    pub fn of(id: SensorId, model: GpsModel) -> Self {
        Self { id, equipped: Equipage::all(), report_s: 1.0, model }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        match &self.model {
            GpsModel::Statistical(model) => model.validate(),
            GpsModel::Constellation(model) => model.validate(),
            GpsModel::PerSatellite(model) => model.validate(),
        }
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Gps,
            equipped: self.equipped.clone(),
            period_s: self.report_s,
            transponder: false,
        }
    }
}

/// Satellite positioning reported by equipped targets.
#[derive(Clone, Debug)]
pub struct Gps {
    reporting: Reporting,
    engine: Engine,
    planning: Planning,
}

#[derive(Clone, Debug)]
enum Engine {
    Statistical { model: Statistical, fleet: Fleet<Receiver> },
    Constellation { model: Diluted, sky: Box<Sky>, fleet: Fleet<Wander> },
    PerSatellite { ranging: Box<Ranging>, fleet: Fleet<RangingReceiver> },
}

impl Gps {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: GpsConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting();
        let planned = match &config.model {
            GpsModel::Statistical(_) => &STATISTICAL,
            GpsModel::Constellation(_) => &CONSTELLATION,
            GpsModel::PerSatellite(_) => &PER_SATELLITE,
        };
        let engine = match config.model {
            GpsModel::Statistical(model) => Engine::Statistical { model, fleet: Fleet::default() },
            GpsModel::Constellation(model) => {
                let sky = Box::new(Sky::new(model.sky.clone())?);
                Engine::Constellation { model, sky, fleet: Fleet::default() }
            }
            GpsModel::PerSatellite(model) => Engine::PerSatellite {
                ranging: Box::new(Ranging::new(model)?),
                fleet: Fleet::default(),
            },
        };
        Ok(Self { planning: Planning::new(reporting.id, planned), reporting, engine })
    }
}

impl Planned for Gps {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Gps {
    fn id(&self) -> SensorId {
        self.reporting.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Gps
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
        let (reporting, planning) = (&self.reporting, &mut self.planning);
        let mut reports = Reports::new(reporting, truth, out);
        let survey = planning.wants_survey(truth.len());
        match &mut self.engine {
            Engine::Statistical { model, fleet } => {
                if survey {
                    fleet
                        .survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
                }
                planning.prepare(|scene| bounds::statistical(model, scene));
                statistical(model, fleet, reporting, planning, interval, truth, &mut reports);
            }
            Engine::Constellation { model, sky, fleet } => {
                if survey {
                    fleet
                        .survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
                }
                prepare_sky(
                    sky,
                    planning,
                    interval,
                    |scene| bounds::constellation(model, scene),
                    |sky| {
                        sky.prepare(interval.run_seed, interval.from, interval.to, 0.0);
                    },
                );
                diluted(model, sky, fleet, reporting, planning, interval, truth, &mut reports);
            }
            Engine::PerSatellite { ranging, fleet } => {
                if survey {
                    fleet
                        .survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
                }
                ranging.prepare(interval, planning, |config, scene| {
                    bounds::per_satellite(config, scene)
                });
                fleet.for_each_due(
                    reporting,
                    interval,
                    truth,
                    |_| ranging.receiver(),
                    |receiver, due| {
                        reports.expected();
                        let key = reporting.key(interval, due);
                        let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
                        let want = Want { explain: reports.explains(), ..Want::default() };
                        let fix = ranging.fix(receiver, key, due.time, &want, &levels, planning);
                        if let Some(fix) = fix {
                            let shown = || fix.shown(&levels);
                            reports.push(due, fix.report(due), true, shown);
                        }
                    },
                );
            }
        }
    }
}

fn statistical(
    model: &Statistical,
    fleet: &mut Fleet<Receiver>,
    reporting: &Reporting,
    planning: &mut Planning,
    interval: &ScanInterval,
    truth: &dyn Truth,
    reports: &mut Reports<'_>,
) {
    fleet.for_each_due(
        reporting,
        interval,
        truth,
        |due| Receiver::start(due.time),
        |receiver, due| {
            reports.expected();
            let draw = reporting.key(interval, due);
            let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
            let quality = receiver.service(&model.service, draw, due.time, &levels, planning);
            // The error goes on through an outage: later reports do not depend on who saw this one.
            let error = receiver.error(&model.error, draw, due.time, &levels, planning);
            if quality == Quality::NoPosition {
                return;
            }
            let soft_m = model.soft.shift_of(draw, quality);
            reports.push(
                due,
                Fix {
                    time: due.time,
                    position_m: due.state.position_m.xy() + error.total_m() + soft_m,
                    axis: Vector2::new(0.0, 1.0),
                    variance_m2: [
                        model.error.sigma_north_m * model.error.sigma_north_m,
                        model.error.sigma_east_m * model.error.sigma_east_m,
                    ],
                    altitude_m: Some(due.state.position_m.z),
                },
                true,
                || error.shown(&levels, soft_m),
            );
        },
    );
}

#[expect(clippy::too_many_arguments, reason = "the parts of one sensor and one scan")]
fn diluted(
    model: &Diluted,
    sky: &Sky,
    fleet: &mut Fleet<Wander>,
    reporting: &Reporting,
    planning: &mut Planning,
    interval: &ScanInterval,
    truth: &dyn Truth,
    reports: &mut Reports<'_>,
) {
    // Ellipse, triangular root and soft shift once per epoch, not per target.
    let epochs: Vec<_> =
        sky.epochs().iter().map(|e| e.dop.map(|d| Spread::of(&d, e, model.uere_m))).collect();
    fleet.for_each_due(
        reporting,
        interval,
        truth,
        |_| Wander::default(),
        |wander, due| {
            reports.expected();
            let key = reporting.key(interval, due);
            let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
            let unit = wander.parts(
                (model.correlated_share, model.tau_s),
                key,
                due.time,
                &levels,
                planning,
            );
            // The error goes on while there is no fix.
            let Some(spread) = sky.at(due.time).and_then(|i| epochs[i].as_ref()) else {
                return;
            };
            planning.count(E::Geometry);
            let error_m = spread.root * unit.total();
            reports.push(
                due,
                Fix {
                    time: due.time,
                    position_m: due.state.position_m.xy() + error_m + spread.soft_m,
                    axis: spread.axis,
                    variance_m2: spread.variance_m2,
                    altitude_m: Some(due.state.position_m.z),
                },
                true,
                || {
                    let norm = |unit: Vector2<f64>| (spread.root * unit).norm();
                    [
                        shown(&levels, E::Geometry, spread.hdop, "of dilution"),
                        shown(&levels, E::SoftFailures, spread.soft_m.norm(), "m"),
                        shown(&levels, E::Correlation, norm(unit.lasting()), "m"),
                        shown(&levels, E::White, norm(unit.fresh()), "m"),
                    ]
                },
            );
        },
    );
}

/// Horizontal spread of a fix at one epoch.
#[derive(Clone, Copy, Debug)]
struct Spread {
    root: Matrix2<f64>,
    axis: Vector2<f64>,
    variance_m2: [f64; 2],
    soft_m: Vector2<f64>,
    hdop: f64,
}

impl Spread {
    fn of(dop: &Dop, epoch: &SkyEpoch, uere_m: f64) -> Self {
        let [east, cross, north] =
            [dop.q[0][0], dop.q[0][1], dop.q[1][1]].map(|q| q * uere_m * uere_m);
        let (axis, variance_m2) = ellipse([east, cross, north]);
        let first = east.sqrt();
        let second = cross / first;
        let third = (north - second * second).max(0.0).sqrt();
        Self {
            root: Matrix2::new(first, 0.0, second, third),
            axis,
            variance_m2,
            soft_m: Vector2::from(epoch.soft_shift_m()),
            hdop: dop.horizontal(),
        }
    }
}

const LEVEL_KEYS: &[Key] = &[Key::word(
    "level",
    || vec!["statistical", "constellation", "per_satellite"],
    "How it is modelled, cheap first",
)];

const DILUTED_KEYS: &[Key] =
    &[Key::number("uere_m", "m", 1e-3, 1e4, "Deviation of one range, at level constellation")];

/// The kind `gps`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "gps",
        title: "GPS",
        about: "Satellite positions that targets report: geometry, outages, soft failures, correlated and white errors",
        colours: ["#57d0c8", "#00716a"],
        symbol: Symbol::PLUS,
        radar: false,
        needs_site: false,
        carried: true,
        presets: &[
            ("sps_2020", "8 m (95 %) horizontal"),
            ("sps_2001", "13 m, without selective availability"),
            ("sps_1995", "100 m, with it"),
        ],
        keys: &[
            cooperative::KEYS,
            LEVEL_KEYS,
            SERVICE_KEYS,
            SOFT_KEYS,
            ERROR_KEYS,
            DILUTED_KEYS,
            constellation::KEYS,
            ranging::KEYS,
        ],
        draws: &[],
        assumed: Assumed { slow_share: 0.95, slow_tau_s: 300.0, ..Assumed::NOTHING },
    },
    read: Some(|given| Ok(Arc::new(GpsConfig::read(given)))),
    models: &[
        Modelled {
            model: &STATISTICAL,
            example: |id| example(id, GpsModel::Statistical(Statistical::sps_2020())),
            file: file!(),
        },
        Modelled {
            model: &CONSTELLATION,
            example: |id| {
                let sky = RangingConfig::example(None).sky;
                example(id, GpsModel::Constellation(Diluted::reference(sky)))
            },
            file: file!(),
        },
        Modelled {
            model: &PER_SATELLITE,
            example: |id| example(id, GpsModel::PerSatellite(RangingConfig::example(None))),
            file: file!(),
        },
    ],
};

fn example(id: SensorId, model: GpsModel) -> Result<Box<dyn Planned>, ConfigError> {
    Ok(Box::new(Gps::new(GpsConfig::of(id, model))?))
}

impl GpsConfig {
    fn read(given: &Given<'_>) -> Self {
        let mut statistics = match given.preset {
            "sps_1995" => Statistical::sps_1995(),
            "sps_2001" => Statistical::sps_2001(),
            _ => Statistical::sps_2020(),
        };
        let model = match given.word("level", "statistical") {
            "constellation" => {
                let mut model = Diluted::reference(SkyConfig::read(given, 10.0));
                given.number("uere_m", &mut model.uere_m);
                given.number("correlated_share", &mut model.correlated_share);
                given.number("tau_s", &mut model.tau_s);
                GpsModel::Constellation(model)
            }
            "per_satellite" => GpsModel::PerSatellite(RangingConfig::read(given)),
            _ => {
                read_services(given, &mut statistics.service);
                read_soft(given, &mut statistics.soft);
                let error = &mut statistics.error;
                given.number("mean_north_m", &mut error.mean_north_m);
                given.number("mean_east_m", &mut error.mean_east_m);
                given.number("sigma_north_m", &mut error.sigma_north_m);
                given.number("sigma_east_m", &mut error.sigma_east_m);
                given.number("correlated_share", &mut error.correlated_share);
                given.number("tau_s", &mut error.tau_s);
                GpsModel::Statistical(statistics)
            }
        };
        let mut config = Self::of(given.id, model);
        config.equipped = given.equipage();
        given.number("report_s", &mut config.report_s);
        config
    }
}

impl Settings for GpsConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.report_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Gps::new(self.clone())?))
    }
}

/// By statistics of north and east.
pub static STATISTICAL: Model = Model {
    name: "GPS, statistical",
    reads_speed: false,
    reads_distance: false,
    costs: &[
        (E::Geometry, Level::Cheap, 0),
        (E::HardFailures, Level::Exact, 11),
        (E::SoftFailures, Level::Exact, 7),
        (E::Correlation, Level::Exact, 137),
        (E::White, Level::Exact, 130),
    ],
};

/// By the dilution of what is in view.
pub static CONSTELLATION: Model = Model {
    name: "GPS, constellation",
    reads_speed: false,
    reads_distance: false,
    costs: &[
        (E::Geometry, Level::Middle, 16),
        (E::HardFailures, Level::Exact, 0),
        (E::SoftFailures, Level::Exact, 0),
        (E::Correlation, Level::Exact, 124),
        (E::White, Level::Exact, 116),
    ],
};

/// Range by range.
pub static PER_SATELLITE: Model = Model {
    name: "GPS, per satellite",
    reads_speed: false,
    reads_distance: false,
    costs: &[
        (E::Geometry, Level::Exact, 92),
        (E::HardFailures, Level::Exact, 0),
        (E::SoftFailures, Level::Exact, 0),
        (E::RangeErrors, Level::Exact, 2),
        (E::Multipath, Level::Exact, 456),
        (E::White, Level::Exact, 398),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Tolerance;
    use crate::sensors::reporting::ranging::RangeBudget;
    use crate::sensors::testing::{Parked, outages, seen_mean_s};
    use crate::time::SimTime;

    /// Errors (east, north) by target, and reports expected, over `scans` scans of `scan_s`.
    fn run(
        config: &GpsConfig,
        truth: &Parked,
        scan_s: f64,
        scans: u64,
    ) -> (Vec<(u64, SimTime, Vector2<f64>)>, u64) {
        let mut gps = Gps::new(config.clone()).expect("a sound configuration");
        let mut sink = PlotSink::default();
        for scan in 1..=scans {
            let interval = ScanInterval {
                run_seed: 11,
                scan,
                from: SimTime::from_s((scan - 1) as f64 * scan_s),
                to: SimTime::from_s(scan as f64 * scan_s),
            };
            gps.scan(&interval, truth, &Weather::default(), &mut sink);
        }
        let errors = sink
            .plots
            .iter()
            .zip(&sink.causes)
            .map(|(plot, cause)| {
                let truth_m = cause.truth_m.expect("a report has a target");
                (cause.key.expect("a report has a target"), plot.time, plot.position_m - truth_m)
            })
            .collect();
        (errors, sink.looks)
    }

    #[test]
    fn errors_have_their_statistics_at_10_hz_and_at_1_hz() {
        let keys: Vec<u64> = (0..100).collect();
        let truth = Parked::aircraft(&keys);
        for (report_s, scans) in [(1.0, 400), (0.1, 400)] {
            let model = Statistical {
                service: Service::PERFECT,
                error: NorthEast {
                    mean_north_m: 2.0,
                    mean_east_m: -1.0,
                    sigma_north_m: 6.0,
                    sigma_east_m: 4.35,
                    correlated_share: 0.8,
                    tau_s: 4.0,
                },
                ..Statistical::sps_2001()
            };
            let config =
                GpsConfig { report_s, ..GpsConfig::of(SensorId(2), GpsModel::Statistical(model)) };
            let (errors, looks) = run(&config, &truth, 1.0, scans);
            assert_eq!(errors.len() as u64, looks);
            let n = errors.len() as f64;
            let mean = errors.iter().fold(Vector2::zeros(), |sum, e| sum + e.2) / n;
            let square = errors
                .iter()
                .fold(Vector2::zeros(), |sum, e| sum + (e.2 - mean).component_mul(&(e.2 - mean)))
                / n;
            // 100 targets, 100 correlation times of 4 s (two each count once): 5 000 independent samples.
            let tolerance = 4.0 / 5_000_f64.sqrt();
            assert!((mean.x + 1.0).abs() < 4.35 * tolerance, "east mean {}", mean.x);
            assert!((mean.y - 2.0).abs() < 6.0 * tolerance, "north mean {}", mean.y);
            assert!((square.x.sqrt() / 4.35 - 1.0).abs() < tolerance, "east {}", square.x.sqrt());
            assert!((square.y.sqrt() / 6.0 - 1.0).abs() < tolerance, "north {}", square.y.sqrt());
            // Lag of 4 s: e^(−1) of the correlated share.
            let lag = (4.0 / report_s).round() as usize;
            let (mut product, mut pairs) = (0.0, 0.0);
            let mut by_target = errors.clone();
            by_target.sort_by_key(|e| (e.0, e.1));
            for target in by_target.chunk_by(|a, b| a.0 == b.0) {
                for pair in target.windows(lag + 1) {
                    product += (pair[0].2.y - 2.0) * (pair[lag].2.y - 2.0);
                    pairs += 1.0;
                }
            }
            let correlation = product / pairs / 36.0;
            assert!(
                (correlation - 0.8 * libm::exp(-1.0)).abs() < 0.06,
                "{report_s}: {correlation}"
            );
        }
    }

    #[test]
    fn the_radius_of_95_percent_is_the_published_one() {
        let keys: Vec<u64> = (0..20_000).collect();
        for (name, model, r95_m) in [
            ("1995", Statistical::sps_1995(), 100.0),
            ("2001", Statistical::sps_2001(), 13.0),
            ("2020", Statistical::sps_2020(), 8.0),
        ] {
            let model = Statistical { service: Service::PERFECT, ..model };
            let config = GpsConfig::of(SensorId(1), GpsModel::Statistical(model));
            let (errors, _) = run(&config, &Parked::aircraft(&keys), 1.0, 1);
            let within = errors.iter().filter(|e| e.2.norm() <= r95_m).count() as f64;
            let share = within / errors.len() as f64;
            assert!(
                (share - 0.95).abs() < 4.0 * (0.95 * 0.05 / 20_000.0_f64).sqrt(),
                "{name}: {share}"
            );
        }
    }

    fn sky() -> SkyConfig {
        SkyConfig::reference(geodesy::Geodetic::from_degrees(47.45, 8.55, 432.0), 8.64e8)
    }

    fn levels() -> [(&'static str, GpsModel); 3] {
        let ranging = RangingConfig {
            sky: SkyConfig { step_s: 1.0, ..sky() },
            budget: RangeBudget::modern(),
            weighted: false,
            corrections: None,
        };
        [
            ("statistical", GpsModel::Statistical(Statistical::sps_2020())),
            ("constellation", GpsModel::Constellation(Diluted::reference(sky()))),
            ("per satellite", GpsModel::PerSatellite(ranging)),
        ]
    }

    #[test]
    fn a_target_reports_the_same_whoever_else_is_there() {
        for (name, model) in levels() {
            let config = GpsConfig::of(SensorId(4), model);
            let (together, _) = run(&config, &Parked::aircraft(&[1, 2, 3, 700]), 1.0, 50);
            let (alone, _) = run(&config, &Parked::aircraft(&[3]), 0.25, 200);
            let same: Vec<_> = together.into_iter().filter(|e| e.0 == 3).collect();
            assert_eq!(same, alone, "{name}");
        }
    }

    #[test]
    fn reported_covariances_are_those_of_the_errors_at_every_level() {
        for (name, model) in levels() {
            let config = GpsConfig { report_s: 50.0, ..GpsConfig::of(SensorId(4), model) };
            let truth = Parked::aircraft(&(0..20).collect::<Vec<_>>());
            let gps = Gps::new(config).expect("sound");
            let mut sink = PlotSink::default();
            for run_seed in 0..100 {
                let (from, to) = (SimTime::ZERO, SimTime::from_s(50.0));
                let mut fresh = gps.clone();
                fresh.scan(
                    &ScanInterval { run_seed, scan: 1, from, to },
                    &truth,
                    &Weather::default(),
                    &mut sink,
                );
            }
            let (mut sum, mut n) = (0.0, 0.0);
            for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
                let error = plot.position_m - cause.truth_m.expect("a target");
                if error.norm() < 29.0 {
                    let along = error.dot(&plot.axis);
                    let across = error.dot(&plot.across_axis());
                    sum += along * along / plot.along_m2 + across * across / plot.across_m2;
                    n += 1.0;
                }
            }
            assert!(n > 1900.0, "{name}: {n} reports");
            // Per satellite, the twenty receivers share most of their error: 100 samples of χ² with
            // two degrees of freedom, deviation 0.2.
            assert!((sum / n - 2.0).abs() < 0.6, "{name}: {}", sum / n);
        }
    }

    #[test]
    fn a_sky_without_enough_satellites_gives_no_position() {
        let mut poor = sky();
        poor.mask_deg = 60.0;
        let (errors, looks) = run(
            &GpsConfig::of(SensorId(1), GpsModel::Constellation(Diluted::reference(poor))),
            &Parked::aircraft(&[1, 2]),
            1.0,
            20,
        );
        assert_eq!((errors.len(), looks), (0, 40));
    }

    #[test]
    fn services_take_and_shift_their_shares() {
        let process = |share, mean_down_s| Alternating::from_share(share, mean_down_s);
        let model = Statistical {
            service: Service {
                coverage: process(0.9, 10.0),
                availability: process(0.8, 10.0),
                reliability: process(0.7, 10.0),
            },
            soft: SoftFailure { step_m: 500.0, ramp_m_per_s: 1.0, limit_m: 520.0 },
            ..Statistical::sps_2020()
        };
        let probability = model.service.position_probability();
        let config = GpsConfig::of(SensorId(5), GpsModel::Statistical(model));
        let keys: Vec<u64> = (0..1000).collect();
        let (errors, looks) = run(&config, &Parked::aircraft(&keys), 1.0, 200);
        let obtained = errors.len() as f64 / looks as f64;
        assert!((obtained - 0.72).abs() < 0.01, "coverage × availability: {obtained}");
        let far: Vec<f64> = errors.iter().map(|e| e.2.norm()).filter(|e| *e > 250.0).collect();
        let soft = far.len() as f64 / errors.len() as f64;
        assert!((soft - 0.3).abs() < 0.01, "soft failures are large errors: {soft}");
        assert!(far.iter().all(|e| *e > 480.0 && *e < 545.0), "step, ramp and limit");
        let good = (errors.len() - far.len()) as f64 / looks as f64;
        assert!((good - probability).abs() < 0.01);
    }

    #[test]
    fn planned_services_last_as_configured_at_10_hz_and_at_1_hz() {
        let model = Statistical {
            service: Service {
                coverage: Alternating::from_share(0.9, 60.0),
                availability: Alternating::NEVER_FAILS,
                reliability: Alternating::from_share(0.8, 40.0),
            },
            soft: SoftFailure { step_m: 500.0, ramp_m_per_s: 0.0, limit_m: 500.0 },
            ..Statistical::sps_2020()
        };
        let (seconds, keys) = (8_000, (0..40).collect::<Vec<_>>());
        for report_s in [1.0, 0.1] {
            let config = GpsConfig {
                report_s,
                ..GpsConfig::of(SensorId(7), GpsModel::Statistical(model.clone()))
            };
            let gps = Gps::new(config).expect("sound");
            let mut gps = gps.tolerating(Tolerance::default(), seconds as f64);
            let found = outages(&mut gps, &Parked::aircraft(&keys), report_s, seconds);
            // Renewal theory: var(share) = 2 P²(1−P)² per outage; outages are exponential.
            let n = found.number;
            assert!(n > 450.0, "{n} outages");
            assert!((found.share - 0.9).abs() < 4.0 * (2.0 / n).sqrt() * 0.09, "{}", found.share);
            let ratio = found.mean_s / seen_mean_s(60.0, report_s);
            assert!((ratio - 1.0).abs() < 4.0 / n.sqrt(), "{report_s}: {}", found.mean_s);
            // Soft failures, among the reports that came.
            let (mut far, mut events, mut before) = (0.0, 0.0, None);
            for (key, _, error_m) in &found.errors_m {
                let off = error_m.norm() > 250.0;
                far += f64::from(u8::from(off));
                events += f64::from(u8::from(off && before == Some((*key, false))));
                before = Some((*key, off));
            }
            let share = far / found.errors_m.len() as f64;
            let tolerance = 4.0 * (2.0_f64 / events).sqrt() * 0.16;
            assert!((share - 0.2).abs() < tolerance && events > 1000.0, "{share} of {events}");
            let mean_s = far * report_s / events;
            // Outages of coverage hide the beginning or the end of some: they look shorter.
            assert!(mean_s > 30.0 && mean_s < 42.0, "{report_s}: {mean_s}");
        }
    }

    #[test]
    fn unsound_parameters_are_named() {
        let sound = GpsConfig::of(SensorId(1), GpsModel::Statistical(Statistical::sps_2020()));
        let with = |change: fn(&mut Statistical)| {
            let mut model = Statistical::sps_2020();
            change(&mut model);
            GpsConfig::of(SensorId(1), GpsModel::Statistical(model))
        };
        for (name, config) in [
            ("report_s", GpsConfig { report_s: 0.0, ..sound.clone() }),
            ("report_s", GpsConfig { report_s: f64::NAN, ..sound.clone() }),
            ("sigma_north_m", with(|m| m.error.sigma_north_m = 0.0)),
            ("soft_limit_m", with(|m| m.soft.limit_m = 5.0)),
            ("coverage", with(|m| m.service.coverage.mean_up_s = 0.0)),
            ("mask_deg", {
                let sky = SkyConfig { mask_deg: 95.0, ..sky() };
                GpsConfig::of(SensorId(1), GpsModel::Constellation(Diluted::reference(sky)))
            }),
        ] {
            match Gps::new(config) {
                Err(ConfigError::Number { key, .. }) => assert_eq!(key, name),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}
