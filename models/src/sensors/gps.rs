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

use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningLevels, PositioningScene,
};
use crate::effects::{Level, PlanRow};
use crate::environment::Weather;
use crate::frames::{Matrix2, Vector2};
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::constellation::{self, Dop, Sky, SkyConfig, SkyEpoch};
use crate::sensors::cooperative::{self, Equipage, Fix, Fleet, Reporting, Reports, Shown, shown};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::gauss_markov::Gm1Pair;
use crate::sensors::planned::Planned;
use crate::sensors::ranging::{self, Ranging, RangingConfig, RangingReceiver, Want, ellipse};
use crate::sensors::satellite_bounds;
use crate::sensors::service::{Alternating, Service, ServiceState, read_services};
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;
use std::sync::Arc;

/// Statistics of a horizontal error: mean and deviation of north and east, and how much of it lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NorthEast {
    /// Mean error to the north, m.
    pub mean_north_m: f64,
    /// Mean error to the east, m.
    pub mean_east_m: f64,
    /// Deviation of the whole error to the north, m.
    pub sigma_north_m: f64,
    /// Deviation of the whole error to the east, m.
    pub sigma_east_m: f64,
    /// Share of the variance that is correlated in time, 0 to 1; the rest is white.
    pub correlated_share: f64,
    /// Correlation time of that share, s.
    pub tau_s: f64,
}

impl NorthEast {
    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(ERROR_KEYS, "mean_north_m", self.mean_north_m)?;
        check(ERROR_KEYS, "mean_east_m", self.mean_east_m)?;
        check(ERROR_KEYS, "sigma_north_m", self.sigma_north_m)?;
        check(ERROR_KEYS, "sigma_east_m", self.sigma_east_m)?;
        check(ERROR_KEYS, "correlated_share", self.correlated_share)?;
        check(ERROR_KEYS, "tau_s", self.tau_s)
    }
}

/// What a soft failure does to a position: a step at its onset, growing, up to a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftFailure {
    /// Shift at the onset, m.
    pub step_m: f64,
    /// Growth of the shift, m/s.
    pub ramp_m_per_s: f64,
    /// Largest shift, m.
    pub limit_m: f64,
}

impl SoftFailure {
    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(SOFT_KEYS, "soft_step_m", self.step_m)?;
        check(SOFT_KEYS, "soft_ramp_m_per_s", self.ramp_m_per_s)?;
        number("soft_limit_m", self.limit_m, self.step_m, 1e6)
    }

    /// Shift of a soft failure, m east and north: its direction belongs to the event. `key` is that of a
    /// report of the receiver.
    pub(crate) fn shift_of(&self, key: DrawKey, quality: Quality) -> Vector2<f64> {
        let Quality::SoftFailure { age_s, number } = quality else {
            return Vector2::zeros();
        };
        let event = DrawKey { scan: number, ..process_key(key, 4) };
        let turn = uniform(&mut event.rng(Purpose::GnssService));
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * turn);
        Vector2::new(sin, cos) * self.shift_m(age_s)
    }

    /// Size of the shift `age_s` after the onset, m.
    #[must_use]
    pub fn shift_m(&self, age_s: f64) -> f64 {
        (self.step_m + self.ramp_m_per_s * age_s).min(self.limit_m)
    }
}

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
        }
    }
}

/// Refuses service figures outside their limits.
pub(crate) fn validate_service(service: &Service) -> Result<(), ConfigError> {
    for (process, share, mttr) in [
        (&service.coverage, "coverage", "coverage_mttr_s"),
        (&service.availability, "availability", "availability_mttr_s"),
        (&service.reliability, "reliability", "reliability_mttr_s"),
    ] {
        validate_process(process, share, mttr)?;
    }
    Ok(())
}

/// Refuses a process that is never up or has no outage length.
pub(crate) fn validate_process(
    process: &Alternating,
    share: &'static str,
    mttr: &'static str,
) -> Result<(), ConfigError> {
    number(share, process.up_share(), 1e-9, 1.0)?;
    number(mttr, process.mean_down_s, 1e-9, 1e10)
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

/// Plans, follows the satellites with what is simulated of their failures, and plans for the geometry
/// that they leave. With nobody to see them, no satellite is followed.
pub(crate) fn prepare_sky(
    sky: &mut Sky,
    planning: &mut Planning,
    interval: &ScanInterval,
    ladders: impl Fn(&PositioningScene) -> Ladders,
    step: impl FnOnce(&mut Sky),
) {
    if !planning.anybody() {
        planning.prepare(ladders);
        return;
    }
    if sky.epochs().is_empty() {
        planning.see_dilution(sky.nominal_dilution(interval.from));
    }
    planning.prepare(&ladders);
    let levels = planning.levels();
    sky.simulate(levels.on(E::HardFailures), levels.on(E::SoftFailures));
    step(sky);
    let [hard, soft] = sky.take_looked();
    planning.add(E::HardFailures, hard);
    planning.add(E::SoftFailures, soft);
    planning.see_dilution(sky.largest_dilution());
    planning.prepare(ladders);
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
                planning.prepare(|scene| satellite_bounds::gps_statistical(model, scene));
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
                    |scene| satellite_bounds::gps_constellation(model, scene),
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
                    satellite_bounds::gps_per_satellite(config, scene)
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
                            reports.push(due, Fix::of_ranges(due, &fix), true, shown);
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
                    altitude_m: None,
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
                    altitude_m: None,
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

/// A horizontal error of unit deviation that wanders: correlated and white part.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wander {
    /// The correlated part and when it was advanced last; made when it is first wanted.
    correlated: Option<(Gm1Pair, SimTime)>,
}

impl Wander {
    /// Correlated and white part at `now` of an error of unit deviation, of whose variance `share` is
    /// correlated over `tau_s`; the correlated part is advanced exactly from the last report. Where it
    /// is left out, the white part has the whole variance.
    pub(crate) fn parts(
        &mut self,
        (share, tau_s): (f64, f64),
        key: DrawKey,
        now: SimTime,
        levels: &PositioningLevels,
        planning: &mut Planning,
    ) -> Parts {
        let (lasting, fresh) = (levels.on(E::Correlation), levels.on(E::White));
        let mut parts = Parts::default();
        if !lasting && !fresh {
            return parts;
        }
        let mut rng = key.rng(Purpose::GnssMarkov);
        if lasting {
            planning.count(E::Correlation);
            let (state, advanced) = self.correlated.get_or_insert_with(|| {
                let start = DrawKey { scan: u64::MAX, ..key };
                (Gm1Pair::stationary(&mut start.rng(Purpose::GnssMarkov)), now)
            });
            state.advance(tau_s, now.since_s(*advanced), &mut rng);
            *advanced = now;
            parts.correlated = Vector2::from(state.error(1.0, 1.0));
            parts.roots[0] = share.sqrt();
        } else {
            // The draws of the part that is left out.
            let _ = (uniform(&mut rng), uniform(&mut rng));
        }
        if fresh {
            planning.count(E::White);
            let (east, north) = normal_pair(&mut rng);
            let variance = if lasting { 1.0 - share } else { 1.0 };
            parts.white = Vector2::new(east, north);
            parts.roots[1] = variance.sqrt();
        }
        parts
    }
}

/// An error of unit deviation in its parts, each of unit deviation with the root of its share.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Parts {
    pub(crate) correlated: Vector2<f64>,
    pub(crate) white: Vector2<f64>,
    pub(crate) roots: [f64; 2],
}

impl Parts {
    /// The correlated part.
    pub(crate) fn lasting(&self) -> Vector2<f64> {
        self.correlated * self.roots[0]
    }

    /// The white part.
    pub(crate) fn fresh(&self) -> Vector2<f64> {
        self.white * self.roots[1]
    }

    /// The whole error.
    pub(crate) fn total(&self) -> Vector2<f64> {
        self.lasting() + self.fresh()
    }
}

/// The parts of one horizontal error, m east and north.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ErrorParts {
    pub(crate) mean_m: Vector2<f64>,
    pub(crate) correlated_m: Vector2<f64>,
    pub(crate) white_m: Vector2<f64>,
}

impl ErrorParts {
    pub(crate) fn total_m(&self) -> Vector2<f64> {
        self.mean_m + self.correlated_m + self.white_m
    }

    /// What was simulated of them, and of a soft failure.
    pub(crate) fn shown(&self, levels: &PositioningLevels, soft_m: Vector2<f64>) -> [Shown; 3] {
        [
            shown(levels, E::SoftFailures, soft_m.norm(), "m"),
            shown(levels, E::Correlation, self.correlated_m.norm(), "m"),
            shown(levels, E::White, self.white_m.norm(), "m"),
        ]
    }
}

/// What the services of one receiver give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Quality {
    /// No measurement.
    NoPosition,
    /// A measurement within its statistics.
    Good,
    /// A measurement that has been off for so long, since this change of the service.
    SoftFailure { age_s: f64, number: u64 },
}

/// What is remembered of one receiver.
#[derive(Clone, Debug)]
pub(crate) struct Receiver {
    /// Its first report, when its services begin.
    begins: SimTime,
    coverage: Option<ServiceState>,
    availability: Option<ServiceState>,
    reliability: Option<ServiceState>,
    wander: Wander,
}

/// Draw keys of the three processes of one receiver; the rest of the sensor number's range is free,
/// as sensors have 16 bits.
fn process_key(key: DrawKey, process: u32) -> DrawKey {
    DrawKey { sensor: key.sensor | (process << 16), ..key }
}

impl Receiver {
    pub(crate) fn start(now: SimTime) -> Self {
        Self {
            begins: now,
            coverage: None,
            availability: None,
            reliability: None,
            wander: Wander::default(),
        }
    }

    /// What the services give at `now`. Each is followed from the receiver's beginning, whenever it is
    /// first asked: what it does is the same.
    pub(crate) fn service(
        &mut self,
        service: &Service,
        key: DrawKey,
        now: SimTime,
        levels: &PositioningLevels,
        planning: &mut Planning,
    ) -> Quality {
        let begins = self.begins;
        let up = |state: &mut Option<ServiceState>, process: &Alternating, number: u32| {
            let key = process_key(key, number);
            let state = state.get_or_insert_with(|| ServiceState::start(process, key, begins));
            (state.advance(process, key, now), *state)
        };
        if levels.on(E::HardFailures) {
            planning.count(E::HardFailures);
            let (covered, _) = up(&mut self.coverage, &service.coverage, 1);
            let (available, _) = up(&mut self.availability, &service.availability, 2);
            if !(covered && available) {
                return Quality::NoPosition;
            }
        }
        if levels.on(E::SoftFailures) {
            planning.count(E::SoftFailures);
            let (reliable, state) = up(&mut self.reliability, &service.reliability, 3);
            if !reliable {
                return Quality::SoftFailure { age_s: state.age_s(now), number: state.sojourn() };
            }
        }
        Quality::Good
    }

    /// The error at `now`; the correlated part is advanced exactly from the last report.
    pub(crate) fn error(
        &mut self,
        of: &NorthEast,
        key: DrawKey,
        now: SimTime,
        levels: &PositioningLevels,
        planning: &mut Planning,
    ) -> ErrorParts {
        let lasting = (of.correlated_share, of.tau_s);
        let parts = self.wander.parts(lasting, key, now, levels, planning);
        let sigma_m = Vector2::new(of.sigma_east_m, of.sigma_north_m);
        ErrorParts {
            mean_m: Vector2::new(of.mean_east_m, of.mean_north_m),
            correlated_m: parts.correlated.component_mul(&sigma_m) * parts.roots[0],
            white_m: parts.white.component_mul(&sigma_m) * parts.roots[1],
        }
    }
}

const LEVEL_KEYS: &[Key] = &[Key::word(
    "level",
    || vec!["statistical", "constellation", "per_satellite"],
    "How it is modelled, cheap first",
)];

/// Keys of outages that are drawn by shares of time.
pub(crate) const SERVICE_KEYS: &[Key] = &[
    Key::number(
        "coverage",
        "",
        1e-9,
        1.0,
        "Share of time in which a position is possible at the place",
    ),
    Key::number("coverage_mttr_s", "s", 1e-9, 1e10, "Mean length of a gap in coverage"),
    Key::number("availability", "", 1e-9, 1.0, "Share of that in which enough satellites work"),
    Key::number("availability_mttr_s", "s", 1e-9, 1e10, "Mean length of such an outage"),
    Key::number(
        "reliability",
        "",
        1e-9,
        1.0,
        "Share of that in which the error is within its statistics",
    ),
    Key::number(
        "reliability_mttr_s",
        "s",
        1e-9,
        1e10,
        "Mean length of a time with a position far off",
    ),
];

/// Keys of positions far off.
pub(crate) const SOFT_KEYS: &[Key] = &[
    Key::number("soft_step_m", "m", 0.0, 1e6, "First shift of a soft failure"),
    Key::number("soft_ramp_m_per_s", "m/s", 0.0, 1e4, "Growth of that shift"),
    Key::number("soft_limit_m", "m", 0.0, 1e6, "Largest shift, not less than the first"),
];

const ERROR_KEYS: &[Key] = &[
    Key::number("mean_north_m", "m", -1e4, 1e4, "Mean error to the north"),
    Key::number("mean_east_m", "m", -1e4, 1e4, "Mean error to the east"),
    Key::number("sigma_north_m", "m", 1e-3, 1e4, "Deviation of the whole error to the north"),
    Key::number("sigma_east_m", "m", 1e-3, 1e4, "Deviation of the whole error to the east"),
    Key::number(
        "correlated_share",
        "",
        0.0,
        1.0,
        "Share of the variance that is correlated in time",
    ),
    Key::number("tau_s", "s", 1e-3, 1e6, "Correlation time of that share"),
];

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

pub(crate) fn read_soft(given: &Given<'_>, soft: &mut SoftFailure) {
    given.number("soft_step_m", &mut soft.step_m);
    given.number("soft_ramp_m_per_s", &mut soft.ramp_m_per_s);
    given.number("soft_limit_m", &mut soft.limit_m);
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
    use crate::sensors::ranging::RangeBudget;
    use crate::sensors::testing::{Parked, outages, seen_mean_s};

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
