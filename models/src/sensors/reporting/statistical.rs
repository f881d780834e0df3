//! Errors and outages by statistics: a horizontal error of which a part lasts, services that come and go, failures that
//! grow. What receivers of satellites have in common where no satellite is followed.

use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::effects::positioning::{Planning, PositioningEffect as E, PositioningLevels};
use crate::frames::Vector2;
use crate::keys::Key;
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::declared::Given;
use crate::sensors::reporting::cooperative::{Shown, shown};
use crate::sensors::reporting::gauss_markov::Gm1Pair;
use crate::sensors::reporting::service::{Alternating, Service, ServiceState};
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

pub(crate) const ERROR_KEYS: &[Key] = &[
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

pub(crate) fn read_soft(given: &Given<'_>, soft: &mut SoftFailure) {
    given.number("soft_step_m", &mut soft.step_m);
    given.number("soft_ramp_m_per_s", &mut soft.ramp_m_per_s);
    given.number("soft_limit_m", &mut soft.limit_m);
}
