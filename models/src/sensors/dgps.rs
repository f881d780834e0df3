//! Differential satellite positioning: errors common to user and reference station cancel, what
//! grows with distance and age of the correction remains, and the station can fail.
//!
//! Source: Parkinson & Enge in *Global Positioning System: Theory and Applications* II (1996),
//! ch. 1 (differential GPS); carrier smoothing through an ionospheric gradient doubles as in
//! Hwang, McGraw & Bader (1999), where the smoothing time counts twice.

mod bounds;

use crate::draw::DrawKey;
use crate::effects::positioning::{Model, Planning, PositioningEffect as E, PositioningLevels};
use crate::effects::{Level, PlanRow};
use crate::environment::Weather;
use crate::frames::{Point2, Vector2};
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, count, number};
use crate::sensors::declared::{Declared, Given, Modelled, Settings};
use crate::sensors::gps::Statistical;
use crate::sensors::planned::Planned;
use crate::sensors::reporting::constellation;
use crate::sensors::reporting::cooperative::{
    self, Equipage, Fix, Fleet, Reporting, Reports, shown,
};
use crate::sensors::reporting::ranging::{
    self, RangeCorrections, Ranging, RangingConfig, RangingReceiver, Want,
};
use crate::sensors::reporting::service::{
    Alternating, Service, ServiceState, read_process, read_services,
};
use crate::sensors::reporting::statistical::{
    self, NorthEast, Quality, Receiver, SoftFailure, read_soft, validate_process, validate_service,
};
use crate::sensors::{PlotSink, ScanInterval, Sensor, TargetState, Truth};
use crate::time::SimTime;
use std::sync::Arc;

/// Error budget of one differential range or position component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentialBudget {
    /// Multipath and noise of the user, m.
    pub sigma_user_m: f64,
    /// Multipath and noise of the reference station, m.
    pub sigma_ref_m: f64,
    /// Vertical ionospheric gradient, m per m (4e-6 quiet).
    pub iono_gradient: f64,
    /// Obliquity factor of the ionospheric path, 1 at the zenith.
    pub obliquity: f64,
    /// Carrier smoothing time constant, s.
    pub smoothing_s: f64,
    /// Other decorrelation with distance, m per m (1e-5: 1 m per 100 km).
    pub space_decorrelation: f64,
    /// Acceleration of the correction, m/s² (0.019 with selective availability, else 0).
    pub correction_acceleration_ms2: f64,
}

impl DifferentialBudget {
    /// σ² = σ_user² + σ_ref² + (g·OF·(d + 2τ_s v))² + (k d)² + (½ a t²)², in m, at `distance_m` from
    /// the station, `speed_mps`, with a correction `age_s` old.
    #[must_use]
    pub fn sigma_m(&self, distance_m: f64, speed_mps: f64, age_s: f64) -> f64 {
        let effective_m = distance_m + 2.0 * self.smoothing_s * speed_mps;
        let iono = self.iono_gradient * self.obliquity * effective_m;
        let space = self.space_decorrelation * distance_m;
        let old = 0.5 * self.correction_acceleration_ms2 * age_s * age_s;
        (self.sigma_user_m * self.sigma_user_m
            + self.sigma_ref_m * self.sigma_ref_m
            + iono * iono
            + space * space
            + old * old)
            .sqrt()
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(KEYS, "sigma_user_m", self.sigma_user_m)?;
        check(KEYS, "sigma_ref_m", self.sigma_ref_m)?;
        number("iono_gradient", self.iono_gradient, 0.0, 1e-2)?;
        check(KEYS, "obliquity", self.obliquity)?;
        number("smoothing_s", self.smoothing_s, 0.0, 1e4)?;
        number("space_decorrelation", self.space_decorrelation, 0.0, 1e-2)?;
        check(KEYS, "correction_acceleration_ms2", self.correction_acceleration_ms2)
    }
}

/// What a user does while the reference station is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReferenceLoss {
    /// No position, as in P_dgps = P_gps · P_rsc.
    NoReport,
    /// Stand-alone positions with these statistics.
    StandAlone(NorthEast),
}

/// The level of the error budget: one deviation per report, spread over north and east.
#[derive(Clone, Debug, PartialEq)]
pub struct Budgeted {
    /// Coverage, availability, reliability, each receiver by itself.
    pub service: Service,
    /// What is added while the service is not reliable.
    pub soft: SoftFailure,
    /// Error budget.
    pub budget: DifferentialBudget,
    /// Metres north per metre of the budget.
    pub north_factor: f64,
    /// Metres east per metre of the budget.
    pub east_factor: f64,
    /// Share of the variance that is correlated in time (multipath), 0 to 1.
    pub correlated_share: f64,
    /// Its correlation time, s.
    pub tau_s: f64,
    /// Age of a correction when it arrives, s.
    pub correction_latency_s: f64,
    /// Time between two corrections, s.
    pub correction_s: f64,
}

impl Budgeted {
    /// A station on the airport: about 0.6 m.
    #[must_use]
    pub fn on_airport() -> Self {
        let gps = Statistical::sps_2020();
        Self {
            service: gps.service,
            soft: gps.soft,
            budget: DifferentialBudget {
                sigma_user_m: 0.5,
                sigma_ref_m: 0.3,
                iono_gradient: 4e-6,
                obliquity: 1.5,
                smoothing_s: 100.0,
                space_decorrelation: 1e-5,
                correction_acceleration_ms2: 0.0,
            },
            north_factor: 1.0,
            east_factor: 0.725,
            correlated_share: 0.7,
            tau_s: 100.0,
            correction_latency_s: 0.5,
            correction_s: 1.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        validate_service(&self.service)?;
        self.soft.validate()?;
        self.budget.validate()?;
        check(KEYS, "north_factor", self.north_factor)?;
        check(KEYS, "east_factor", self.east_factor)?;
        check(KEYS, "correlated_share", self.correlated_share)?;
        check(KEYS, "tau_s", self.tau_s)?;
        number("correction_latency_s", self.correction_latency_s, 0.0, 3600.0)?;
        number("correction_s", self.correction_s, 1e-3, 3600.0)
    }

    /// Age of the newest correction at `now`, s: corrections are made at whole multiples of
    /// `correction_s` and used as soon as they are received.
    #[must_use]
    pub fn correction_age_s(&self, now: SimTime) -> f64 {
        let period_ns = SimTime::from_s(self.correction_s).0;
        let since = (now.0 - SimTime::from_s(self.correction_latency_s).0).rem_euclid(period_ns);
        self.correction_latency_s + SimTime(since).s()
    }

    fn error(&self, sigma_m: f64) -> NorthEast {
        NorthEast {
            mean_north_m: 0.0,
            mean_east_m: 0.0,
            sigma_north_m: self.north_factor * sigma_m,
            sigma_east_m: self.east_factor * sigma_m,
            correlated_share: self.correlated_share,
            tau_s: self.tau_s,
        }
    }
}

/// How differential positioning is modelled, cheap first.
#[derive(Clone, Debug, PartialEq)]
pub enum DgpsModel {
    /// By its error budget.
    Budget(Budgeted),
    /// Range by range; the configuration must hold corrections.
    PerSatellite(RangingConfig),
}

/// Parameters of a [`Dgps`].
#[derive(Clone, Debug, PartialEq)]
pub struct DgpsConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Time between two reports of a target, s.
    pub report_s: f64,
    /// Where the reference station stands, airport frame, m.
    pub reference_m: Point2<f64>,
    /// Failures of the reference station, common to all users.
    pub reference: Alternating,
    /// What happens meanwhile; range by range there is no report in any case.
    pub on_reference_loss: ReferenceLoss,
    /// Level and its parameters.
    pub model: DgpsModel,
}

impl DgpsConfig {
    /// A station on the airport with MTBF 1 000 h and repair in 1 h.
    #[must_use]
    pub fn on_airport(id: SensorId, reference_m: Point2<f64>) -> Self {
        Self {
            id,
            equipped: Equipage::all(),
            report_s: 1.0,
            reference_m,
            reference: Alternating::from_mtbf(3.6e6, 3600.0),
            on_reference_loss: ReferenceLoss::NoReport,
            model: DgpsModel::Budget(Budgeted::on_airport()),
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        for coordinate in [self.reference_m.x, self.reference_m.y] {
            number("reference_m", coordinate, -1e6, 1e6)?;
        }
        validate_process(&self.reference, "reference_up", "reference_mttr_s")?;
        if let ReferenceLoss::StandAlone(error) = &self.on_reference_loss {
            error.validate()?;
        }
        match &self.model {
            DgpsModel::Budget(model) => model.validate(),
            DgpsModel::PerSatellite(model) => {
                count("corrections", usize::from(model.corrections.is_some()), 1, 1)?;
                model.validate()
            }
        }
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Dgps,
            equipped: self.equipped.clone(),
            period_s: self.report_s,
            transponder: false,
        }
    }
}

/// Differential satellite positioning reported by equipped targets.
#[derive(Clone, Debug)]
pub struct Dgps {
    config: DgpsConfig,
    reporting: Reporting,
    engine: Engine,
    /// The station at the end of the last scan; its outages are everybody's.
    reference: Option<ServiceState>,
    /// Beginning of the first scan.
    begins: Option<SimTime>,
    planning: Planning,
}

#[derive(Clone, Debug)]
enum Engine {
    Budget { model: Budgeted, fleet: Fleet<Receiver> },
    PerSatellite { ranging: Box<Ranging>, fleet: Fleet<RangingReceiver> },
}

impl Dgps {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: DgpsConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting();
        let engine = match config.model.clone() {
            DgpsModel::Budget(model) => Engine::Budget { model, fleet: Fleet::default() },
            DgpsModel::PerSatellite(model) => Engine::PerSatellite {
                ranging: Box::new(Ranging::new(model)?),
                fleet: Fleet::default(),
            },
        };
        let planned = match &engine {
            Engine::Budget { .. } => &BUDGET,
            Engine::PerSatellite { .. } => &PER_SATELLITE,
        };
        let planning = Planning::new(config.id, planned);
        Ok(Self { config, reporting, engine, reference: None, begins: None, planning })
    }
}

impl Planned for Dgps {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Dgps {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Dgps
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
        let mut station = Station {
            process: &config.reference,
            key: DrawKey {
                run_seed: interval.run_seed,
                sensor: u32::from(config.id.0) | STATION,
                entity: 0,
                scan: 0,
            },
            begins: *self.begins.get_or_insert(interval.from),
            state: &mut self.reference,
        };
        let distance_m = |state: &TargetState| (state.position_m.xy() - config.reference_m).norm();
        let speed_mps = |state: &TargetState| state.velocity_mps.xy().norm();
        let survey = planning.wants_survey(truth.len());
        match &mut self.engine {
            Engine::Budget { model, fleet } => {
                if survey {
                    let see = |s: &TargetState| planning.see(&s.velocity_mps, distance_m(s));
                    fleet.survey(reporting, interval, truth, see);
                }
                planning.prepare(|scene| bounds::budget(config, model, scene));
                fleet.for_each_due(
                    reporting,
                    interval,
                    truth,
                    |due| Receiver::start(due.time),
                    |receiver, due| {
                        reports.expected();
                        let draw = reporting.key(interval, due);
                        let levels =
                            planning.levels_for(&due.state.velocity_mps, || distance_m(&due.state));
                        let corrected = station.up_at(due.time, &levels, planning);
                        let quality =
                            receiver.service(&model.service, draw, due.time, &levels, planning);
                        let (mut far_m, mut fast_mps, mut age_s) = (0.0, 0.0, 0.0);
                        if levels.on(E::CorrectionDistance) {
                            planning.count(E::CorrectionDistance);
                            (far_m, fast_mps) = (distance_m(&due.state), speed_mps(&due.state));
                        }
                        if levels.on(E::CorrectionAge) {
                            planning.count(E::CorrectionAge);
                            age_s = model.correction_age_s(due.time);
                        }
                        let budget = &model.budget;
                        let error = match config.on_reference_loss {
                            ReferenceLoss::StandAlone(error) if !corrected => error,
                            _ => model.error(budget.sigma_m(far_m, fast_mps, age_s)),
                        };
                        // The error goes on through an outage.
                        let parts = receiver.error(&error, draw, due.time, &levels, planning);
                        let silent =
                            !corrected && config.on_reference_loss == ReferenceLoss::NoReport;
                        if silent || quality == Quality::NoPosition {
                            return;
                        }
                        let soft_m = model.soft.shift_of(draw, quality);
                        reports.push(
                            due,
                            Fix {
                                time: due.time,
                                position_m: due.state.position_m.xy() + parts.total_m() + soft_m,
                                axis: Vector2::new(0.0, 1.0),
                                variance_m2: [
                                    error.sigma_north_m * error.sigma_north_m,
                                    error.sigma_east_m * error.sigma_east_m,
                                ],
                                altitude_m: Some(due.state.position_m.z),
                            },
                            true,
                            || {
                                // What distance and age add to the deviation of each axis.
                                let least = budget.sigma_m(0.0, 0.0, 0.0);
                                let far = budget.sigma_m(far_m, fast_mps, 0.0) - least;
                                let old = budget.sigma_m(0.0, 0.0, age_s) - least;
                                let [soft, lasting, fresh] = parts.shown(&levels, soft_m);
                                [
                                    soft,
                                    shown(&levels, E::CorrectionDistance, far, "m of σ"),
                                    shown(&levels, E::CorrectionAge, old, "m of σ"),
                                    lasting,
                                    fresh,
                                ]
                            },
                        );
                    },
                );
            }
            Engine::PerSatellite { ranging, fleet } => {
                if survey {
                    let see = |s: &TargetState| planning.see(&s.velocity_mps, distance_m(s));
                    fleet.survey(reporting, interval, truth, see);
                }
                ranging.prepare(interval, planning, |ranging, scene| {
                    let none = RangeCorrections::on_airport();
                    let corrections = ranging.corrections.as_ref().unwrap_or(&none);
                    bounds::per_satellite(config, ranging, corrections, scene)
                });
                fleet.for_each_due(
                    reporting,
                    interval,
                    truth,
                    |_| ranging.receiver(),
                    |receiver, due| {
                        reports.expected();
                        let levels =
                            planning.levels_for(&due.state.velocity_mps, || distance_m(&due.state));
                        if !station.up_at(due.time, &levels, planning) {
                            return;
                        }
                        let key = reporting.key(interval, due);
                        let want = Want {
                            distance_m: distance_m(&due.state),
                            speed_mps: speed_mps(&due.state),
                            explain: reports.explains(),
                        };
                        let fix = ranging.fix(receiver, key, due.time, &want, &levels, planning);
                        if let Some(fix) = fix {
                            let shown = || fix.shown(&levels);
                            reports.push(due, fix.report(due), true, shown);
                        }
                    },
                );
            }
        }
        station.end(interval.to);
    }
}

/// The reference station during one scan.
struct Station<'a> {
    process: &'a Alternating,
    key: DrawKey,
    /// Beginning of the sensor's first scan.
    begins: SimTime,
    /// Its state at the end of the last scan; made when it is first asked.
    state: &'a mut Option<ServiceState>,
}

impl Station<'_> {
    /// Whether it works at `time`. Reports come by target, not by time: each looks from the beginning
    /// of the scan.
    fn up_at(
        &mut self,
        time: SimTime,
        levels: &PositioningLevels,
        planning: &mut Planning,
    ) -> bool {
        if !levels.on(E::ReferenceOutage) {
            return true;
        }
        planning.count(E::ReferenceOutage);
        let start = || ServiceState::start(self.process, self.key, self.begins);
        self.state.get_or_insert_with(start).clone().advance(self.process, self.key, time)
    }

    fn end(&mut self, to: SimTime) {
        if let Some(state) = &mut self.state {
            state.advance(self.process, self.key, to);
        }
    }
}

/// Marks draws of the station among those of the sensor, whose number has 16 bits.
const STATION: u32 = 5 << 16;

const LEVEL_KEYS: &[Key] = &[
    Key::word("level", || vec!["budget", "per_satellite"], "How it is modelled, cheap first"),
    Key::word(
        "on_reference_loss",
        || vec!["no_report", "stand_alone"],
        "What a receiver does while the reference station is out",
    ),
];

const KEYS: &[Key] = &[
    Key::number(
        "reference_up",
        "",
        1e-9,
        1.0,
        "Share of time in which the reference station works",
    ),
    Key::number("reference_mttr_s", "s", 1e-9, 1e10, "Mean length of its outages"),
    Key::number("sigma_user_m", "m", 1e-3, 1e3, "Deviation of the receiver's own error"),
    Key::number("sigma_ref_m", "m", 0.0, 1e3, "Deviation of the reference station's error"),
    Key::number("obliquity", "", 1.0, 10.0, "Slant of the rays through the ionosphere"),
    Key::number(
        "correction_acceleration_ms2",
        "m/s²",
        0.0,
        10.0,
        "Acceleration of a range error while its correction ages",
    ),
    Key::number("north_factor", "", 1e-3, 100.0, "Dilution to the north"),
    Key::number("east_factor", "", 1e-3, 100.0, "Dilution to the east"),
    Key::number(
        "correlated_share",
        "",
        0.0,
        1.0,
        "Share of the variance that is correlated in time",
    ),
    Key::number("tau_s", "s", 1e-3, 1e6, "Correlation time of that share"),
];

/// The kind `dgps`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "dgps",
        title: "Differential GPS",
        about: "Satellite positions with corrections of a reference station: distance from it, age of corrections, its outages",
        colours: ["#8fe36b", "#3d7a00"],
        symbol: Symbol::CROSS,
        radar: false,
        needs_site: false,
        carried: true,
        presets: &[("on_airport", "a station on the airport: about 0.6 m")],
        keys: &[
            cooperative::KEYS,
            LEVEL_KEYS,
            KEYS,
            ranging::CORRECTION_KEYS,
            statistical::SERVICE_KEYS,
            statistical::SOFT_KEYS,
            constellation::KEYS,
            ranging::KEYS,
        ],
        draws: &[],
        // Noise is a third; multipath of a vehicle that moves, and corrections, change within half a minute.
        assumed: Assumed { slow_share: 0.65, slow_tau_s: 30.0, ..Assumed::NOTHING },
    },
    read: Some(|given| Ok(Arc::new(DgpsConfig::read(given)))),
    models: &[
        Modelled {
            model: &BUDGET,
            example: |id| Ok(Box::new(Dgps::new(DgpsConfig::on_airport(id, Point2::origin()))?)),
            file: file!(),
        },
        Modelled {
            model: &PER_SATELLITE,
            example: |id| {
                let corrections = Some(RangeCorrections::on_airport());
                let model = DgpsModel::PerSatellite(RangingConfig::example(corrections));
                let config = DgpsConfig { model, ..DgpsConfig::on_airport(id, Point2::origin()) };
                Ok(Box::new(Dgps::new(config)?))
            },
            file: file!(),
        },
    ],
};

impl DgpsConfig {
    fn read(given: &Given<'_>) -> Self {
        let mut config = Self::on_airport(given.id, given.place_m());
        config.equipped = given.equipage();
        given.number("report_s", &mut config.report_s);
        read_process(given, "reference_up", "reference_mttr_s", &mut config.reference);
        if given.word("on_reference_loss", "no_report") == "stand_alone" {
            config.on_reference_loss = ReferenceLoss::StandAlone(Statistical::sps_2020().error);
        }
        config.model = if given.word("level", "budget") == "per_satellite" {
            let mut ranging = RangingConfig::read(given);
            ranging.corrections = Some(RangeCorrections::read(given));
            DgpsModel::PerSatellite(ranging)
        } else {
            let mut model = Budgeted::on_airport();
            read_services(given, &mut model.service);
            read_soft(given, &mut model.soft);
            let budget = &mut model.budget;
            given.number("sigma_user_m", &mut budget.sigma_user_m);
            given.number("sigma_ref_m", &mut budget.sigma_ref_m);
            given.number("iono_gradient", &mut budget.iono_gradient);
            given.number("obliquity", &mut budget.obliquity);
            given.number("smoothing_s", &mut budget.smoothing_s);
            given.number("space_decorrelation", &mut budget.space_decorrelation);
            given.number("correction_acceleration_ms2", &mut budget.correction_acceleration_ms2);
            given.number("north_factor", &mut model.north_factor);
            given.number("east_factor", &mut model.east_factor);
            given.number("correlated_share", &mut model.correlated_share);
            given.number("tau_s", &mut model.tau_s);
            given.number("correction_latency_s", &mut model.correction_latency_s);
            given.number("correction_s", &mut model.correction_s);
            DgpsModel::Budget(model)
        };
        config
    }
}

impl Settings for DgpsConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.report_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Dgps::new(self.clone())?))
    }
}

/// By the differential error budget.
pub static BUDGET: Model = Model {
    name: "DGPS, budget",
    reads_speed: true,
    reads_distance: true,
    costs: &[
        (E::Geometry, Level::Cheap, 0),
        (E::HardFailures, Level::Exact, 11),
        (E::SoftFailures, Level::Exact, 7),
        (E::ReferenceOutage, Level::Exact, 6),
        (E::CorrectionDistance, Level::Exact, 16),
        (E::CorrectionAge, Level::Exact, 10),
        (E::Correlation, Level::Exact, 132),
        (E::White, Level::Exact, 126),
    ],
};

/// Differential, range by range.
pub static PER_SATELLITE: Model = Model {
    name: "DGPS, per satellite",
    reads_speed: true,
    reads_distance: true,
    costs: &[
        (E::Geometry, Level::Exact, 135),
        (E::HardFailures, Level::Exact, 0),
        (E::SoftFailures, Level::Exact, 0),
        (E::ReferenceOutage, Level::Exact, 0),
        (E::CorrectionDistance, Level::Exact, 6),
        (E::CorrectionAge, Level::Exact, 23),
        (E::ReferenceErrors, Level::Exact, 4),
        (E::Multipath, Level::Exact, 467),
        (E::White, Level::Exact, 415),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Tolerance;
    use crate::sensors::reporting::constellation::{SatelliteFailures, SkyConfig};
    use crate::sensors::reporting::ranging::{RangeBudget, RangeCorrections};
    use crate::sensors::testing::{Parked, outages, seen_mean_s};
    use std::collections::BTreeSet;

    fn run(config: &DgpsConfig, keys: &[u64], scans: u64) -> PlotSink {
        let mut dgps = Dgps::new(config.clone()).expect("a sound configuration");
        let mut sink = PlotSink::default();
        for scan in 1..=scans {
            let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
            let interval = ScanInterval { run_seed: 3, scan, from: at(scan - 1), to: at(scan) };
            dgps.scan(&interval, &Parked::aircraft(keys), &Weather::default(), &mut sink);
        }
        sink
    }

    fn sound() -> DgpsConfig {
        let model = Budgeted { service: Service::PERFECT, ..Budgeted::on_airport() };
        DgpsConfig {
            model: DgpsModel::Budget(model),
            ..DgpsConfig::on_airport(SensorId(1), Point2::origin())
        }
    }

    #[test]
    fn a_lost_station_silences_everybody_at_once_for_its_share() {
        let config = DgpsConfig { reference: Alternating::from_mtbf(60.0, 30.0), ..sound() };
        let keys: Vec<u64> = (0..20).collect();
        let sink = run(&config, &keys, 20_000);
        let share = sink.plots.len() as f64 / sink.looks as f64;
        // 220 outages: σ ≈ P(1−P)√(2/n) = 0.021.
        assert!((share - 2.0 / 3.0).abs() < 0.085, "{share}");
        let mut per_scan = vec![0_u32; 20_001];
        for plot in &sink.plots {
            per_scan[(plot.time.0 as u64).div_ceil(1_000_000_000) as usize] += 1;
        }
        let partial = per_scan.iter().filter(|&&n| n > 0 && n < 20).count();
        assert!(
            partial < 600,
            "only the scans in which the station changes are partial: {partial}"
        );
        let ranging = RangingConfig::example(Some(RangeCorrections::on_airport()));
        let model = DgpsModel::PerSatellite(RangingConfig {
            sky: SkyConfig { failures: SatelliteFailures::never(), ..ranging.sky },
            ..ranging
        });
        let by_range = run(&DgpsConfig { model, ..config.clone() }, &[3], 3_000);
        // As often, and with the same draws, as by the budget.
        let looks_up = by_range.plots.len() as f64 / by_range.looks as f64;
        let same = run(&config, &[3], 3_000);
        assert!((looks_up - same.plots.len() as f64 / same.looks as f64).abs() < 1e-9);
        let late = run(&config, &[7], 20_000);
        let times: BTreeSet<_> = sink.plots.iter().map(|p| p.time).collect();
        assert!(late.plots.iter().all(|p| times.contains(&p.time)));
    }

    #[test]
    fn a_planned_station_is_out_as_long_as_configured_at_10_hz_and_at_1_hz() {
        let seconds = 100_000;
        for report_s in [1.0, 0.1] {
            let reference = Alternating::from_share(0.9, 30.0);
            let dgps = Dgps::new(DgpsConfig { reference, report_s, ..sound() }).expect("sound");
            let mut dgps = dgps.tolerating(Tolerance::default(), seconds as f64);
            let found = outages(&mut dgps, &Parked::aircraft(&[4]), report_s, seconds);
            let n = found.number;
            assert!(n > 250.0, "{n} outages");
            assert!((found.share - 0.9).abs() < 4.0 * (2.0 / n).sqrt() * 0.09, "{}", found.share);
            let ratio = found.mean_s / seen_mean_s(30.0, report_s);
            assert!((ratio - 1.0).abs() < 4.0 / n.sqrt(), "{report_s}: {}", found.mean_s);
        }
    }

    #[test]
    fn the_error_grows_with_distance_and_age() {
        let config = Budgeted::on_airport();
        let near = config.budget.sigma_m(0.0, 0.0, 1.0);
        assert!((near - (0.34_f64).sqrt()).abs() < 1e-12);
        assert!(config.budget.sigma_m(1e5, 0.0, 1.0) > 1.0);
        let with_sa = DifferentialBudget { correction_acceleration_ms2: 0.019, ..config.budget };
        let step = (with_sa.sigma_m(0.0, 0.0, 5.0).powi(2) - near * near).sqrt();
        assert!((step - 0.2375).abs() < 1e-9, "½ a t² at 5 s: {step}");
        let age = Budgeted { correction_s: 10.0, correction_latency_s: 2.0, ..config };
        for (at_s, expected) in [(2.0, 2.0), (5.0, 5.0), (11.5, 11.5), (12.0, 2.0), (0.0, 10.0)] {
            assert!(
                (age.correction_age_s(SimTime::from_s(at_s)) - expected).abs() < 1e-9,
                "{at_s}"
            );
        }
    }

    #[test]
    fn standing_alone_is_an_answer_too() {
        let alone = Statistical::sps_2001().error;
        let config = DgpsConfig {
            reference: Alternating::from_mtbf(100.0, 100.0),
            on_reference_loss: ReferenceLoss::StandAlone(alone),
            ..sound()
        };
        let keys: Vec<u64> = (0..50).collect();
        let sink = run(&config, &keys, 2_000);
        assert_eq!(sink.plots.len() as u64, sink.looks, "a position always");
        let mut squares = [(0.0, 0.0); 2];
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let error = plot.position_m - cause.truth_m.expect("a report has a target");
            let slot = &mut squares[usize::from(plot.along_m2 > 4.0)];
            *slot = (slot.0 + error.y * error.y / plot.along_m2, slot.1 + 1.0);
        }
        for (square, n) in squares {
            assert!(
                n > 10_000.0 && (square / n - 1.0).abs() < 0.1,
                "its covariance is its error's"
            );
        }
    }

    #[test]
    fn range_by_range_it_is_about_as_good_as_its_budget() {
        let site = geodesy::Geodetic::from_degrees(47.45, 8.55, 432.0);
        let mut sky = SkyConfig::reference(site, 8.64e8);
        (sky.step_s, sky.failures) = (1.0, SatelliteFailures::never());
        let ranging = RangingConfig {
            sky,
            budget: RangeBudget::modern(),
            weighted: true,
            corrections: Some(RangeCorrections::on_airport()),
        };
        let config = DgpsConfig { model: DgpsModel::PerSatellite(ranging.clone()), ..sound() };
        let keys: Vec<u64> = (0..300).collect();
        let sink = run(&config, &keys, 5);
        let square: f64 = sink
            .plots
            .iter()
            .zip(&sink.causes)
            .map(|(p, c)| (p.position_m - c.truth_m.expect("a target")).norm_squared())
            .sum();
        let rms = (square / sink.plots.len() as f64).sqrt();
        assert!(rms > 0.5 && rms < 2.5, "{rms}");
        let without = RangingConfig { corrections: None, ..ranging };
        let config = DgpsConfig { model: DgpsModel::PerSatellite(without), ..sound() };
        assert!(matches!(Dgps::new(config), Err(ConfigError::Count { key: "corrections", .. })));
    }
}
