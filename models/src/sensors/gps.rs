//! Satellite positioning reported by the target, at the level of its statistics: services that fail
//! and return, and a north and east error with a correlated and a white part.
//!
//! Source of the model: prior probability model P = P_c · P_sa · P_sr of satellite services with
//! independent Gaussian errors in north and east. Figures of the presets: GPS SPS Signal
//! Specification (1995), SPS Performance Standard (2001, 2020).

use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::environment::Weather;
use crate::frames::Vector2;
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, number};
use crate::sensors::cooperative::{Due, Equipage, Fix, Fleet, Reporting, Reports};
use crate::sensors::gauss_markov::Gm1Pair;
use crate::sensors::service::{Alternating, Service, ServiceState};
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;

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
        number("mean_north_m", self.mean_north_m, -1e4, 1e4)?;
        number("mean_east_m", self.mean_east_m, -1e4, 1e4)?;
        number("sigma_north_m", self.sigma_north_m, 1e-3, 1e4)?;
        number("sigma_east_m", self.sigma_east_m, 1e-3, 1e4)?;
        number("correlated_share", self.correlated_share, 0.0, 1.0)?;
        number("tau_s", self.tau_s, 1e-3, 1e6)
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
        number("soft_step_m", self.step_m, 0.0, 1e6)?;
        number("soft_ramp_m_per_s", self.ramp_m_per_s, 0.0, 1e4)?;
        number("soft_limit_m", self.limit_m, self.step_m, 1e6)
    }

    /// Size of the shift `age_s` after the onset, m.
    #[must_use]
    pub fn shift_m(&self, age_s: f64) -> f64 {
        (self.step_m + self.ramp_m_per_s * age_s).min(self.limit_m)
    }
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
    /// Coverage, availability, reliability, each receiver by itself.
    pub service: Service,
    /// Error while the service is reliable.
    pub error: NorthEast,
    /// Error while it is not.
    pub soft: SoftFailure,
}

/// Outages of the presets: coverage hole 10 min, unavailability 30 min, unreliability 6 h.
fn service(coverage: f64, availability: f64, reliability: f64) -> Service {
    Service {
        coverage: Alternating { up_share: coverage, mean_down_s: 600.0 },
        availability: Alternating { up_share: availability, mean_down_s: 1800.0 },
        reliability: Alternating { up_share: reliability, mean_down_s: 21_600.0 },
    }
}

impl GpsConfig {
    /// SPS of 1995 with selective availability: 100 m (95 %) horizontal, spread over north and east
    /// as the geometry of 42–50° north does (σ_E = 0.725 σ_N).
    #[must_use]
    pub fn sps_1995(id: SensorId) -> Self {
        Self {
            id,
            equipped: Equipage::all(),
            report_s: 1.0,
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
    pub fn sps_2001(id: SensorId) -> Self {
        Self {
            error: NorthEast {
                sigma_north_m: 6.00,
                sigma_east_m: 4.35,
                correlated_share: 0.95,
                tau_s: 300.0,
                ..Self::sps_1995(id).error
            },
            soft: SoftFailure { step_m: 30.0, ramp_m_per_s: 0.5, limit_m: 5000.0 },
            ..Self::sps_1995(id)
        }
    }

    /// SPS of 2020: 8 m (95 %) horizontal, 1e-5 soft failures per hour and satellite.
    #[must_use]
    pub fn sps_2020(id: SensorId) -> Self {
        Self {
            service: service(0.999, 0.9995, 0.9997),
            error: NorthEast {
                sigma_north_m: 3.69,
                sigma_east_m: 2.68,
                ..Self::sps_2001(id).error
            },
            ..Self::sps_2001(id)
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting(SensorKind::Gps).validate()?;
        validate_service(&self.service)?;
        self.error.validate()?;
        self.soft.validate()
    }

    fn reporting(&self, kind: SensorKind) -> Reporting {
        Reporting { id: self.id, kind, equipped: self.equipped.clone(), period_s: self.report_s }
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
    number(share, process.up_share, 1e-9, 1.0)?;
    number(mttr, process.mean_down_s, 1e-9, 1e10)
}

/// Satellite positioning reported by equipped targets.
#[derive(Clone, Debug)]
pub struct Gps {
    config: GpsConfig,
    reporting: Reporting,
    fleet: Fleet<Receiver>,
}

impl Gps {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: GpsConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting(SensorKind::Gps);
        Ok(Self { config, reporting, fleet: Fleet::default() })
    }
}

impl Sensor for Gps {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Gps
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        _weather: &Weather,
        out: &mut PlotSink,
    ) {
        let mut reports = Reports::new(&self.reporting, truth, out);
        let (config, sensor) = (&self.config, u32::from(self.config.id.0));
        let key = |due: &Due| DrawKey {
            run_seed: interval.run_seed,
            sensor,
            entity: due.key,
            scan: due.number,
        };
        self.fleet.for_each_due(
            &self.reporting,
            interval,
            truth,
            |due| Receiver::start(&config.service, key(due), due.time),
            |receiver, due| {
                reports.expected();
                let draw = key(due);
                let quality = receiver.service(&config.service, draw, due.time);
                if quality == Quality::NoPosition {
                    return;
                }
                let error = receiver.error(&config.error, draw, due.time);
                let soft_m = receiver.soft_shift(&config.soft, draw, quality);
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m: due.state.position_m.xy() + error.total_m() + soft_m,
                        axis: Vector2::new(0.0, 1.0),
                        variance_m2: [
                            config.error.sigma_north_m * config.error.sigma_north_m,
                            config.error.sigma_east_m * config.error.sigma_east_m,
                        ],
                        altitude_m: None,
                    },
                    true,
                    &[
                        ("correlated error", error.correlated_m.norm(), "m"),
                        ("white error", error.white_m.norm(), "m"),
                        ("soft failure", soft_m.norm(), "m"),
                    ],
                );
            },
        );
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
}

/// What the services of one receiver give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Quality {
    /// No measurement.
    NoPosition,
    /// A measurement within its statistics.
    Good,
    /// A measurement that has been off for so long.
    SoftFailure { age_s: f64 },
}

/// What is remembered of one receiver.
#[derive(Clone, Debug)]
pub(crate) struct Receiver {
    coverage: ServiceState,
    availability: ServiceState,
    reliability: ServiceState,
    correlated: Gm1Pair,
    advanced: SimTime,
}

/// Draw keys of the three processes of one receiver; the rest of the sensor number's range is free,
/// as sensors have 16 bits.
fn process_key(key: DrawKey, process: u32) -> DrawKey {
    DrawKey { sensor: key.sensor | (process << 16), ..key }
}

impl Receiver {
    pub(crate) fn start(service: &Service, key: DrawKey, now: SimTime) -> Self {
        let mut rng = DrawKey { scan: u64::MAX, ..key }.rng(Purpose::GnssMarkov);
        Self {
            coverage: ServiceState::start(&service.coverage, process_key(key, 1), now),
            availability: ServiceState::start(&service.availability, process_key(key, 2), now),
            reliability: ServiceState::start(&service.reliability, process_key(key, 3), now),
            correlated: Gm1Pair::stationary(&mut rng),
            advanced: now,
        }
    }

    /// What the services give at `now`.
    pub(crate) fn service(&mut self, service: &Service, key: DrawKey, now: SimTime) -> Quality {
        let covered = self.coverage.advance(&service.coverage, process_key(key, 1), now);
        let available = self.availability.advance(&service.availability, process_key(key, 2), now);
        let reliable = self.reliability.advance(&service.reliability, process_key(key, 3), now);
        match (covered && available, reliable) {
            (false, _) => Quality::NoPosition,
            (true, true) => Quality::Good,
            (true, false) => Quality::SoftFailure { age_s: self.reliability.age_s(now) },
        }
    }

    /// The error at `now`; the correlated part is advanced exactly from the last report.
    pub(crate) fn error(&mut self, of: &NorthEast, key: DrawKey, now: SimTime) -> ErrorParts {
        let mut rng = key.rng(Purpose::GnssMarkov);
        self.correlated.advance(of.tau_s, now.since_s(self.advanced), &mut rng);
        self.advanced = now;
        let (east, north) = normal_pair(&mut rng);
        let (kept, rest) = (of.correlated_share.sqrt(), (1.0 - of.correlated_share).sqrt());
        let [correlated_east, correlated_north] =
            self.correlated.error(kept * of.sigma_east_m, kept * of.sigma_north_m);
        ErrorParts {
            mean_m: Vector2::new(of.mean_east_m, of.mean_north_m),
            correlated_m: Vector2::new(correlated_east, correlated_north),
            white_m: Vector2::new(rest * of.sigma_east_m * east, rest * of.sigma_north_m * north),
        }
    }

    /// Shift of a soft failure, m east and north: its direction belongs to the event.
    pub(crate) fn soft_shift(
        &self,
        soft: &SoftFailure,
        key: DrawKey,
        quality: Quality,
    ) -> Vector2<f64> {
        let Quality::SoftFailure { age_s } = quality else {
            return Vector2::zeros();
        };
        let event = DrawKey { scan: self.reliability.sojourn(), ..process_key(key, 4) };
        let turn = uniform(&mut event.rng(Purpose::GnssService));
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * turn);
        Vector2::new(sin, cos) * soft.shift_m(age_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::testing::Parked;

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
        let keys: Vec<u64> = (0..400).collect();
        let truth = Parked::aircraft(&keys);
        for (report_s, scans) in [(1.0, 500), (0.1, 500)] {
            let config = GpsConfig {
                report_s,
                service: Service::PERFECT,
                error: NorthEast {
                    mean_north_m: 2.0,
                    mean_east_m: -1.0,
                    sigma_north_m: 6.0,
                    sigma_east_m: 4.35,
                    correlated_share: 0.8,
                    tau_s: 20.0,
                },
                ..GpsConfig::sps_2001(SensorId(2))
            };
            let (errors, looks) = run(&config, &truth, 1.0, scans);
            assert_eq!(errors.len() as u64, looks);
            let n = errors.len() as f64;
            let mean = errors.iter().fold(Vector2::zeros(), |sum, e| sum + e.2) / n;
            let square = errors
                .iter()
                .fold(Vector2::zeros(), |sum, e| sum + (e.2 - mean).component_mul(&(e.2 - mean)))
                / n;
            // 400 targets, 25 correlation times of 20 s (two each count once): 5 000 independent samples.
            let tolerance = 4.0 / 5_000_f64.sqrt();
            assert!((mean.x + 1.0).abs() < 4.35 * tolerance, "east mean {}", mean.x);
            assert!((mean.y - 2.0).abs() < 6.0 * tolerance, "north mean {}", mean.y);
            assert!((square.x.sqrt() / 4.35 - 1.0).abs() < tolerance, "east {}", square.x.sqrt());
            assert!((square.y.sqrt() / 6.0 - 1.0).abs() < tolerance, "north {}", square.y.sqrt());
            // Lag of 20 s: e^(−1) of the correlated share.
            let lag = (20.0 / report_s).round() as usize;
            let (mut product, mut pairs) = (0.0, 0.0);
            for target in errors.chunk_by(|a, b| a.1 < b.1) {
                assert!(!target.is_empty());
            }
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
        for (name, config, r95_m) in [
            ("1995", GpsConfig::sps_1995(SensorId(1)), 100.0),
            ("2001", GpsConfig::sps_2001(SensorId(1)), 13.0),
            ("2020", GpsConfig::sps_2020(SensorId(1)), 8.0),
        ] {
            let config = GpsConfig { service: Service::PERFECT, ..config };
            let (errors, _) = run(&config, &Parked::aircraft(&keys), 1.0, 1);
            let within = errors.iter().filter(|e| e.2.norm() <= r95_m).count() as f64;
            let share = within / errors.len() as f64;
            assert!(
                (share - 0.95).abs() < 4.0 * (0.95 * 0.05 / 20_000.0_f64).sqrt(),
                "{name}: {share}"
            );
        }
    }

    #[test]
    fn a_target_reports_the_same_whoever_else_is_there() {
        let config = GpsConfig::sps_2020(SensorId(4));
        let (together, _) = run(&config, &Parked::aircraft(&[1, 2, 3, 700]), 1.0, 50);
        let (alone, _) = run(&config, &Parked::aircraft(&[3]), 0.25, 200);
        let same: Vec<_> = together.into_iter().filter(|e| e.0 == 3).collect();
        assert_eq!(same, alone);
    }

    #[test]
    fn services_take_and_shift_their_shares() {
        let process = |share, mean_down_s| Alternating { up_share: share, mean_down_s };
        let config = GpsConfig {
            service: Service {
                coverage: process(0.9, 10.0),
                availability: process(0.8, 10.0),
                reliability: process(0.7, 10.0),
            },
            soft: SoftFailure { step_m: 500.0, ramp_m_per_s: 1.0, limit_m: 520.0 },
            ..GpsConfig::sps_2020(SensorId(5))
        };
        let keys: Vec<u64> = (0..1000).collect();
        let (errors, looks) = run(&config, &Parked::aircraft(&keys), 1.0, 200);
        let obtained = errors.len() as f64 / looks as f64;
        assert!((obtained - 0.72).abs() < 0.01, "coverage × availability: {obtained}");
        let far: Vec<f64> = errors.iter().map(|e| e.2.norm()).filter(|e| *e > 250.0).collect();
        let soft = far.len() as f64 / errors.len() as f64;
        assert!((soft - 0.3).abs() < 0.01, "soft failures are large errors: {soft}");
        assert!(far.iter().all(|e| *e > 480.0 && *e < 545.0), "step, ramp and limit");
        let good = (errors.len() - far.len()) as f64 / looks as f64;
        assert!((good - config.service.position_probability()).abs() < 0.01);
    }

    #[test]
    fn unsound_parameters_are_named() {
        let sound = GpsConfig::sps_2020(SensorId(1));
        for (name, config) in [
            ("report_s", GpsConfig { report_s: 0.0, ..sound.clone() }),
            ("report_s", GpsConfig { report_s: f64::NAN, ..sound.clone() }),
            (
                "sigma_north_m",
                GpsConfig {
                    error: NorthEast { sigma_north_m: 0.0, ..sound.error },
                    ..sound.clone()
                },
            ),
            (
                "soft_limit_m",
                GpsConfig {
                    soft: SoftFailure { step_m: 10.0, ramp_m_per_s: 0.0, limit_m: 5.0 },
                    ..sound.clone()
                },
            ),
            (
                "coverage",
                GpsConfig {
                    service: Service {
                        coverage: Alternating { up_share: 0.0, mean_down_s: 1.0 },
                        ..Service::PERFECT
                    },
                    ..sound.clone()
                },
            ),
        ] {
            match Gps::new(config) {
                Err(ConfigError::Number { key, .. }) => assert_eq!(key, name),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}
