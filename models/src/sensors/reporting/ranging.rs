//! Satellite positioning range by range: each source of error by satellite, and the fix by least
//! squares from what is in view.
//!
//! Errors of satellites and atmosphere are common to all receivers of an airport; multipath and noise
//! are each receiver's own. With differential corrections the common part is taken off as it was when
//! the correction was made, and the reference station's own errors come in instead.
//!
//! Source: Parkinson & Spilker (eds.), *Global Positioning System: Theory and Applications* (1996),
//! ch. 11 (error budget); obliquity of a thin ionospheric shell at 350 km; tropospheric mapping
//! function of the wide-area augmentation standard (RTCA DO-229). Deviations and times of the presets
//! are usual values, to be configured.

use crate::draw::{DrawKey, Purpose, normal_pair, normal_pair_of, uniform};
use crate::effects::positioning::{
    Ladders, Planning, PositioningEffect as E, PositioningLevels, PositioningScene,
};
use crate::frames::{Vector2, ellipse};
use crate::keys::Key;
use crate::sensors::ScanInterval;
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::declared::Given;
use crate::sensors::reporting::constellation::{Dop, Sky, SkyConfig, prepare_sky};
use crate::sensors::reporting::cooperative::{Due, Fix, Shown, shown};
use crate::sensors::reporting::gauss_markov::{Gm1Step, Gm2Step};
use crate::time::SimTime;

/// Deviation and correlation time of one source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Deviation (at the zenith where it depends on elevation), m.
    pub sigma_m: f64,
    /// Correlation time, s.
    pub tau_s: f64,
}

impl Source {
    fn validate(&self, sigma: &'static str, tau: &'static str) -> Result<(), ConfigError> {
        number(sigma, self.sigma_m, 0.0, 1e4)?;
        number(tau, self.tau_s, 1e-3, 1e6)
    }
}

/// Range error budget of a single-frequency receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeBudget {
    /// Selective availability, second order; deviation 0 since May 2000.
    pub selective_availability: Source,
    /// Clock and ephemeris, first order.
    pub clock_ephemeris: Source,
    /// Ionosphere after the broadcast model, at the zenith, first order.
    pub ionosphere: Source,
    /// Troposphere after the model, at the zenith, first order.
    pub troposphere: Source,
    /// Multipath of the code, at the zenith, first order, each receiver's own.
    pub multipath: Source,
    /// Receiver noise, white, m.
    pub noise_m: f64,
}

impl RangeBudget {
    /// Since 2000: no selective availability.
    #[must_use]
    pub fn modern() -> Self {
        Self {
            selective_availability: Source { sigma_m: 0.0, tau_s: 150.0 },
            clock_ephemeris: Source { sigma_m: 1.75, tau_s: 5400.0 },
            ionosphere: Source { sigma_m: 2.0, tau_s: 1800.0 },
            troposphere: Source { sigma_m: 0.12, tau_s: 1800.0 },
            multipath: Source { sigma_m: 0.5, tau_s: 100.0 },
            noise_m: 0.3,
        }
    }

    /// Before May 2000.
    #[must_use]
    pub fn with_selective_availability() -> Self {
        let selective_availability = Source { sigma_m: 24.0, tau_s: 150.0 };
        Self { selective_availability, ..Self::modern() }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.selective_availability
            .validate("selective_availability_m", "selective_availability_tau_s")?;
        self.clock_ephemeris.validate("clock_ephemeris_m", "clock_ephemeris_tau_s")?;
        self.ionosphere.validate("ionosphere_m", "ionosphere_tau_s")?;
        self.troposphere.validate("troposphere_m", "troposphere_tau_s")?;
        self.multipath.validate("multipath_m", "multipath_tau_s")?;
        // A range without any noise would give a covariance of 0.
        check(KEYS, "noise_m", self.noise_m)
    }

    /// Variance of one range at `elevation_rad`, m².
    #[must_use]
    pub fn variance_m2(&self, elevation_rad: f64) -> f64 {
        let (iono, tropo) = (obliquity(elevation_rad), tropospheric_mapping(elevation_rad));
        [
            self.selective_availability.sigma_m,
            self.clock_ephemeris.sigma_m,
            self.ionosphere.sigma_m * iono,
            self.troposphere.sigma_m * tropo,
        ]
        .iter()
        .map(|s| s * s)
        .sum::<f64>()
            + self.own_variance_m2(elevation_rad)
    }

    /// The part of a receiver itself: multipath and noise, m².
    fn own_variance_m2(&self, elevation_rad: f64) -> f64 {
        let multipath = self.multipath.sigma_m * multipath_growth(elevation_rad);
        multipath * multipath + self.noise_m * self.noise_m
    }
}

/// Slant over vertical path through a thin shell at 350 km: 1/√(1 − (R cos el/(R + h))²).
#[must_use]
pub fn obliquity(elevation_rad: f64) -> f64 {
    let x = 6_371_000.0 / 6_721_000.0 * libm::cos(elevation_rad);
    1.0 / (1.0 - x * x).sqrt()
}

/// Slant over vertical delay of the troposphere: 1.001/√(0.002001 + sin² el).
#[must_use]
pub fn tropospheric_mapping(elevation_rad: f64) -> f64 {
    let sin = libm::sin(elevation_rad);
    1.001 / (0.002_001 + sin * sin).sqrt()
}

/// Multipath against that at the zenith: 1 + 2 e^(−el/10°), between 1 and 3.
#[must_use]
pub fn multipath_growth(elevation_rad: f64) -> f64 {
    1.0 + 2.0 * libm::exp(-elevation_rad.max(0.0) / 10_f64.to_radians())
}

/// Corrections from a reference station, range by range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeCorrections {
    /// Multipath and noise of the station's ranges after its own averaging.
    pub reference: Source,
    /// Vertical ionospheric gradient, m per m.
    pub iono_gradient: f64,
    /// Carrier smoothing time constant of the user, s.
    pub smoothing_s: f64,
    /// Other decorrelation with distance, m per m.
    pub space_decorrelation: f64,
    /// Age of a correction when it arrives, s.
    pub latency_s: f64,
    /// Time between two corrections, s.
    pub period_s: f64,
}

impl RangeCorrections {
    /// A station on the airport in a quiet ionosphere.
    #[must_use]
    pub fn on_airport() -> Self {
        Self {
            reference: Source { sigma_m: 0.3, tau_s: 100.0 },
            iono_gradient: 4e-6,
            smoothing_s: 100.0,
            space_decorrelation: 1e-5,
            latency_s: 0.5,
            period_s: 1.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reference.validate("reference_range_m", "reference_tau_s")?;
        check(CORRECTION_KEYS, "iono_gradient", self.iono_gradient)?;
        check(CORRECTION_KEYS, "smoothing_s", self.smoothing_s)?;
        check(CORRECTION_KEYS, "space_decorrelation", self.space_decorrelation)?;
        number("correction_latency_s", self.latency_s, 0.0, 600.0)?;
        number("correction_s", self.period_s, 1e-3, 600.0)
    }

    /// When the newest correction in use at `now` was made: a whole multiple of the period.
    #[must_use]
    pub fn made_at(&self, now: SimTime) -> SimTime {
        let period_ns = SimTime::from_s(self.period_s).0;
        let received = now.0 - SimTime::from_s(self.latency_s).0;
        SimTime(received.div_euclid(period_ns) * period_ns)
    }
}

/// Parameters of the per-satellite level.
#[derive(Clone, Debug, PartialEq)]
pub struct RangingConfig {
    /// Satellites, site, mask, failures. Its step is also that of the common errors: 1 s by habit.
    pub sky: SkyConfig,
    /// Range error budget.
    pub budget: RangeBudget,
    /// Weights by elevation (1/σ²) instead of equal ones.
    pub weighted: bool,
    /// Corrections in use, for differential positioning.
    pub corrections: Option<RangeCorrections>,
}

impl RangingConfig {
    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.sky.validate()?;
        self.budget.validate()?;
        self.corrections.as_ref().map_or(Ok(()), RangeCorrections::validate)
    }

    /// Oldest epoch that a correction may need, s.
    fn keep_s(&self) -> f64 {
        self.corrections.map_or(0.0, |c| c.latency_s + c.period_s) + self.sky.step_s
    }
}

/// Unit states of the errors that all receivers share for one satellite.
#[derive(Clone, Copy, Debug, Default)]
struct Common {
    selective: [f64; 2],
    clock: f64,
    ionosphere: f64,
    troposphere: f64,
    reference: f64,
    gradient: f64,
    space: f64,
    /// Which of them have begun: those of the sky, of the reference station, of the distance.
    begun: [bool; 3],
}

/// One satellite of an epoch as a receiver uses it.
#[derive(Clone, Copy, Debug)]
struct Range {
    slot: usize,
    /// Shift of the fix east, north, up per metre on this range.
    shift: [f64; 3],
    /// Errors of satellite and atmosphere, m.
    common_m: f64,
    /// Error of a soft failure, m.
    soft_m: f64,
    /// Station's error on this range, m, and unit decorrelation states.
    reference_m: f64,
    gradient: f64,
    space: f64,
    /// Growth of multipath.
    multipath: f64,
    /// Variance of the whole range and of the receiver's own part, m², and slant over vertical path.
    variance_m2: f64,
    own_variance_m2: f64,
    obliquity: f64,
    /// The same of the troposphere.
    tropospheric: f64,
}

/// Variance of what the errors that all receivers share change by within `age_s`, `2σ²(1 − ρ(t))` of each source, m²: of clocks and
/// orbits, and at the zenith of the ionosphere and of the troposphere.
pub(crate) fn aged_m2(b: &RangeBudget, age_s: f64) -> [f64; 3] {
    let first = |of: &Source| -2.0 * of.sigma_m * of.sigma_m * libm::expm1(-age_s / of.tau_s);
    let x = age_s / b.selective_availability.tau_s;
    let sigma_m = b.selective_availability.sigma_m;
    let second = 2.0 * sigma_m * sigma_m * (1.0 - (1.0 + x) * libm::exp(-x)).max(0.0);
    [second + first(&b.clock_ephemeris), first(&b.ionosphere), first(&b.troposphere)]
}

/// What all receivers of the airport share at one instant.
#[derive(Clone, Debug)]
struct RangeEpoch {
    time: SimTime,
    ranges: Vec<Range>,
    fix: bool,
}

/// The per-satellite level: common errors advanced once per step, fixes on demand.
#[derive(Clone, Debug)]
pub struct Ranging {
    config: RangingConfig,
    sky: Sky,
    common: Vec<Common>,
    /// Number of the next step of the errors of the sky, of the reference station, of the distance.
    next: Option<[i64; 3]>,
    epochs: Vec<RangeEpoch>,
}

/// What one receiver remembers: a multipath state per satellite and when it was advanced.
#[derive(Clone, Debug)]
pub struct RangingReceiver {
    multipath: Vec<Option<(f64, SimTime)>>,
}

/// What a fix is made for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Want {
    /// Distance from the reference station, m.
    pub(crate) distance_m: f64,
    /// Speed over ground, m/s.
    pub(crate) speed_mps: f64,
    /// Whether the error is wanted by its sources.
    pub(crate) explain: bool,
}

/// A fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeFix {
    /// Error of the position, m east and north.
    pub error_m: Vector2<f64>,
    /// Error of the height, m.
    pub error_up_m: f64,
    /// Variance east, covariance, variance north, m².
    pub covariance_m2: [f64; 3],
    /// Satellites used.
    pub satellites: usize,
    /// The error by its sources.
    parts: RangeParts,
}

/// Shares of the sources in the error of a fix, m east and north.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RangeParts([Vector2<f64>; 7]);

const AGED: usize = 0;
const STATION: usize = 1;
const FAR: usize = 2;
const COMMON: usize = 3;
const SOFT: usize = 4;
const OWN: usize = 5;
const NOISE: usize = 6;

impl RangeFix {
    /// The report of a receiver that is due, with its height.
    pub(crate) fn report(&self, due: &Due) -> Fix {
        let (axis, variance_m2) = ellipse(self.covariance_m2);
        Fix {
            time: due.time,
            position_m: due.state.position_m.xy() + self.error_m,
            axis,
            variance_m2,
            altitude_m: Some(due.state.position_m.z + self.error_up_m),
        }
    }

    /// What each effect did to the fix.
    pub(crate) fn shown(&self, levels: &PositioningLevels) -> [Shown; 8] {
        let of = |effect: E, part: usize| {
            let metres = self.parts.0[part].norm();
            // Without corrections there are none of the station, and the other way round.
            if metres == 0.0 { None } else { shown(levels, effect, metres, "m") }
        };
        [
            shown(levels, E::Geometry, self.satellites as f64, "satellites"),
            of(E::SoftFailures, SOFT),
            of(E::RangeErrors, COMMON),
            of(E::CorrectionDistance, FAR),
            of(E::CorrectionAge, AGED),
            of(E::ReferenceErrors, STATION),
            of(E::Multipath, OWN),
            of(E::White, NOISE),
        ]
    }
}

impl Ranging {
    /// A level with these parameters that has not begun.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: RangingConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let sky = Sky::new(config.sky.clone())?;
        Ok(Self { config, sky, common: Vec::new(), next: None, epochs: Vec::new() })
    }

    /// Its parameters.
    #[must_use]
    pub fn config(&self) -> &RangingConfig {
        &self.config
    }

    /// A receiver that has seen nothing.
    #[must_use]
    pub fn receiver(&self) -> RangingReceiver {
        RangingReceiver { multipath: vec![None; self.config.sky.constellation.slots.len()] }
    }

    /// Computes what reports in (`from`, `to`] need.
    pub(crate) fn prepare(
        &mut self,
        interval: &ScanInterval,
        planning: &mut Planning,
        ladders: impl Fn(&RangingConfig, &PositioningScene) -> Ladders,
    ) {
        let (run_seed, keep_s) = (interval.run_seed, self.config.keep_s());
        let step_ns = SimTime::from_s(self.config.sky.step_s).0;
        // Whoever comes later, the errors of the sky begin with the sensor.
        let begins = (interval.from.0 - SimTime::from_s(keep_s).0).div_euclid(step_ns);
        self.next.get_or_insert([begins; 3]);
        let mut added = 0;
        let config = &self.config;
        let step = |sky: &mut Sky| {
            added = sky.prepare(run_seed, interval.from, interval.to, keep_s);
        };
        prepare_sky(&mut self.sky, planning, interval, |scene| ladders(config, scene), step);
        let levels = planning.levels();
        let all = self.sky.epochs().len();
        self.epochs.retain(|e| self.sky.epochs().first().is_some_and(|s| e.time >= s.time));
        for number in all - added..all {
            self.advance_common(run_seed, self.sky.epochs()[number].time, &levels);
            let epoch = self.epoch(number);
            for effect in [E::RangeErrors, E::ReferenceErrors, E::CorrectionDistance] {
                if self.wants(&levels, effect) {
                    planning.add(effect, epoch.ranges.len() as u64);
                }
            }
            self.epochs.push(epoch);
        }
    }

    /// Whether the states behind an effect are followed.
    fn wants(&self, levels: &PositioningLevels, effect: E) -> bool {
        match (&self.config.corrections, effect) {
            (None, E::RangeErrors) => levels.on(E::RangeErrors),
            // Corrected, they matter by what they change while a correction ages.
            (Some(_), E::RangeErrors) => levels.on(E::CorrectionAge),
            (Some(_), effect) => levels.on(effect),
            (None, _) => false,
        }
    }

    fn advance_common(&mut self, run_seed: u64, time: SimTime, levels: &PositioningLevels) {
        let wanted = [E::RangeErrors, E::ReferenceErrors, E::CorrectionDistance]
            .map(|effect| self.wants(levels, effect));
        if wanted == [false; 3] {
            return;
        }
        let step_s = self.config.sky.step_s;
        let number = time.0.div_euclid(SimTime::from_s(step_s).0);
        let Some(mut next) = self.next else { return };
        // What was left out until now is followed from its beginning: the same draws, the same errors.
        let missed = next.iter().zip(wanted).filter(|(_, wanted)| *wanted).map(|(next, _)| *next);
        for number in missed.min().unwrap_or(number)..=number {
            let mut due = wanted;
            for (due, next) in due.iter_mut().zip(&mut next) {
                *due = *due && *next <= number;
                *next = if *due { number + 1 } else { *next };
            }
            self.step_common(run_seed, number as u64, due);
        }
        self.next = Some(next);
    }

    /// One step of the errors of the sky, of the reference station, of the distance.
    fn step_common(&mut self, run_seed: u64, number: u64, wanted: [bool; 3]) {
        let step_s = self.config.sky.step_s;
        let budget = &self.config.budget;
        let reference_tau_s = self.config.corrections.map_or(1.0, |c| c.reference.tau_s);
        self.common.resize(self.config.sky.constellation.slots.len(), Common::default());
        let selective = Gm2Step::new(1.0, budget.selective_availability.tau_s, step_s);
        let unit = |tau_s: f64| Gm1Step::new(1.0, tau_s, step_s);
        let clock = unit(budget.clock_ephemeris.tau_s);
        let (ionosphere, troposphere) =
            (unit(budget.ionosphere.tau_s), unit(budget.troposphere.tau_s));
        let reference = unit(reference_tau_s);
        // The stationary distribution, at the first step of a state.
        let fresh = Gm1Step { phi: 0.0, q: 1.0 };
        let [sky, station, far] = wanted;
        for (slot, c) in self.common.iter_mut().enumerate() {
            let key = DrawKey { run_seed, sensor: SKY_ERRORS, entity: slot as u64, scan: number };
            let mut rng = key.rng(Purpose::GnssMarkov);
            // One stream for all: what is left out takes its draws with it.
            let mut pair = |used: bool| {
                let (first, second) = (uniform(&mut rng), uniform(&mut rng));
                if used { normal_pair_of(first, second) } else { (0.0, 0.0) }
            };
            let [old_sky, old_station, old_far] = c.begun;
            let next = |begun: bool, step: Gm1Step| if begun { step } else { fresh };
            let ab = pair(sky);
            if sky {
                c.selective = if old_sky {
                    selective.advance(c.selective, ab)
                } else {
                    [ab.0, ab.1 / budget.selective_availability.tau_s]
                };
            }
            let (a, b) = pair(sky);
            if sky {
                c.clock = next(old_sky, clock).advance(c.clock, a);
                c.ionosphere = next(old_sky, ionosphere).advance(c.ionosphere, b);
            }
            let (a, b) = pair(sky || station);
            if sky {
                c.troposphere = next(old_sky, troposphere).advance(c.troposphere, a);
            }
            if station {
                c.reference = next(old_station, reference).advance(c.reference, b);
            }
            let (a, b) = pair(far);
            if far {
                c.gradient = next(old_far, ionosphere).advance(c.gradient, a);
                c.space = next(old_far, troposphere).advance(c.space, b);
            }
            c.begun = [old_sky || sky, old_station || station, old_far || far];
        }
    }

    fn epoch(&self, number: usize) -> RangeEpoch {
        let sky = &self.sky.epochs()[number];
        let budget = &self.config.budget;
        let weight = |elevation_rad: f64| match self.config.weighted {
            true => 1.0 / budget.variance_m2(elevation_rad),
            false => 1.0,
        };
        let weights: Vec<_> =
            sky.satellites.iter().map(|s| weight(s.0.look.elevation_rad)).collect();
        let units: Vec<_> = sky.satellites.iter().map(|s| s.0.look.unit).collect();
        // The limit on dilution is that of equal weights, whatever the weights of the fix.
        let dop = sky.dop.and_then(|equal| match self.config.weighted {
            true => Dop::of(&units, &weights),
            false => Some(equal),
        });
        let ranges = sky.satellites.iter().zip(&weights).map(|((view, soft_m), w)| {
            let el = view.look.elevation_rad;
            let state = self.common.get(view.slot).copied().unwrap_or_default();
            let multipath = multipath_growth(el);
            Range {
                slot: view.slot,
                shift: dop.map_or([0.0; 3], |d| d.shift_per_metre(view.look.unit, *w)),
                common_m: budget.selective_availability.sigma_m * state.selective[0]
                    + budget.clock_ephemeris.sigma_m * state.clock
                    + budget.ionosphere.sigma_m * obliquity(el) * state.ionosphere
                    + budget.troposphere.sigma_m * tropospheric_mapping(el) * state.troposphere,
                soft_m: *soft_m,
                reference_m: self.config.corrections.map_or(0.0, |c| c.reference.sigma_m)
                    * state.reference,
                gradient: obliquity(el) * state.gradient,
                space: state.space,
                multipath,
                variance_m2: budget.variance_m2(el),
                own_variance_m2: budget.own_variance_m2(el),
                obliquity: obliquity(el),
                tropospheric: tropospheric_mapping(el),
            }
        });
        RangeEpoch { time: sky.time, ranges: ranges.collect(), fix: dop.is_some() }
    }

    fn at(&self, time: SimTime) -> Option<&RangeEpoch> {
        self.epochs.partition_point(|e| e.time <= time).checked_sub(1).map(|i| &self.epochs[i])
    }

    /// The fix of `receiver` at `now`; `None` without enough satellites. `key` is that of the report.
    #[must_use]
    pub(crate) fn fix(
        &self,
        receiver: &mut RangingReceiver,
        key: DrawKey,
        now: SimTime,
        want: &Want,
        levels: &PositioningLevels,
        planning: &mut Planning,
    ) -> Option<RangeFix> {
        let &Want { distance_m, speed_mps, explain } = want;
        let epoch = self.at(now).filter(|e| e.fix)?;
        planning.count(E::Geometry);
        let budget = &self.config.budget;
        let corrected = match &self.config.corrections {
            Some(c) => Some((c, self.at(c.made_at(now))?)),
            None => None,
        };
        let old_m2 =
            corrected.map_or([0.0; 3], |(c, _)| aged_m2(budget, now.since_s(c.made_at(now))));
        let [multipath, noise] = [E::Multipath, E::White].map(|e| levels.on(e));
        let [aged, far] = [E::CorrectionAge, E::CorrectionDistance].map(|e| levels.on(e));
        let [common, station] = [E::RangeErrors, E::ReferenceErrors].map(|e| levels.on(e));
        let ranges = epoch.ranges.len() as u64;
        for (on, effect) in [(multipath, E::Multipath), (noise, E::White)] {
            planning.add(effect, if on { ranges } else { 0 });
        }
        planning.add(E::CorrectionAge, if aged && corrected.is_some() { ranges } else { 0 });
        let mut rng = (multipath || noise).then(|| key.rng(Purpose::GnssMarkov));
        let mut shift = [0.0; 3];
        let mut cov = [0.0; 3];
        let mut parts = RangeParts::default();
        let mut step = (f64::NAN, Gm1Step { phi: 0.0, q: 1.0 });
        for range in &epoch.ranges {
            let (innovation, white) = rng.as_mut().map_or((0.0, 0.0), normal_pair);
            let mut own_m = 0.0;
            if multipath {
                let state = match receiver.multipath[range.slot] {
                    None => innovation,
                    Some((state, then)) => {
                        let dt_s = now.since_s(then);
                        if dt_s != step.0 {
                            step = (dt_s, Gm1Step::new(1.0, budget.multipath.tau_s, dt_s));
                        }
                        step.1.advance(state, innovation)
                    }
                };
                receiver.multipath[range.slot] = Some((state, now));
                own_m = budget.multipath.sigma_m * range.multipath * state;
            }
            let noise_m = if noise { budget.noise_m * white } else { 0.0 };
            let mut error_m = own_m + noise_m;
            let mut variance_m2 = range.own_variance_m2;
            let [east, north, up] = range.shift;
            let mut part = |which: usize, error_m: f64| {
                if explain {
                    parts.0[which] += Vector2::new(east, north) * error_m;
                }
            };
            if let Some((c, then)) = corrected {
                let mut aged_m = 0.0;
                if aged {
                    let Some(old) = then.ranges.iter().find(|r| r.slot == range.slot) else {
                        // Risen since the correction was made: no corrected range, so none at all;
                        // the geometry is that of the others for at most one correction period.
                        continue;
                    };
                    aged_m = range.common_m + range.soft_m - (old.common_m + old.soft_m);
                }
                let iono = c.iono_gradient * (distance_m + 2.0 * c.smoothing_s * speed_mps);
                let space = c.space_decorrelation * distance_m;
                let station_m = if station { range.reference_m * range.multipath } else { 0.0 };
                let far_m = if far { iono * range.gradient + space * range.space } else { 0.0 };
                error_m += aged_m + station_m + far_m;
                part(AGED, aged_m);
                part(STATION, station_m);
                part(FAR, far_m);
                let reference = c.reference.sigma_m * range.multipath;
                let slant = iono * range.obliquity;
                variance_m2 += reference * reference + slant * slant + space * space;
                let [same, ionosphere, troposphere] = old_m2;
                variance_m2 += same
                    + ionosphere * range.obliquity * range.obliquity
                    + troposphere * range.tropospheric * range.tropospheric;
            } else {
                let common_m = if common { range.common_m } else { 0.0 };
                error_m += common_m + range.soft_m;
                part(COMMON, common_m);
                part(SOFT, range.soft_m);
                variance_m2 = range.variance_m2;
            }
            part(OWN, own_m);
            part(NOISE, noise_m);
            shift[0] += east * error_m;
            shift[1] += north * error_m;
            shift[2] += up * error_m;
            cov[0] += east * east * variance_m2;
            cov[1] += east * north * variance_m2;
            cov[2] += north * north * variance_m2;
        }
        Some(RangeFix {
            error_m: Vector2::new(shift[0], shift[1]),
            error_up_m: shift[2],
            covariance_m2: cov,
            satellites: epoch.ranges.len(),
            parts,
        })
    }
}

/// Sensor number of draws for errors of the sky: no sensor's own, as they are common to all.
const SKY_ERRORS: u32 = 7 << 16;

/// Keys of ranges, at level per_satellite.
pub(crate) const KEYS: &[Key] = &[
    Key::number(
        "selective_availability_m",
        "m",
        0.0,
        1e4,
        "Range error by selective availability, deviation",
    ),
    Key::number("selective_availability_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number("clock_ephemeris_m", "m", 0.0, 1e4, "Range error by clocks and orbits, deviation"),
    Key::number("clock_ephemeris_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number(
        "ionosphere_m",
        "m",
        0.0,
        1e4,
        "Range error by the ionosphere at the zenith, deviation",
    ),
    Key::number("ionosphere_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number(
        "troposphere_m",
        "m",
        0.0,
        1e4,
        "Range error by the troposphere at the zenith, deviation",
    ),
    Key::number("troposphere_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number("multipath_m", "m", 0.0, 1e4, "Range error by multipath at the zenith, deviation"),
    Key::number("multipath_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number("noise_m", "m", 1e-3, 1e4, "Noise of a range, deviation"),
    Key::flag("weighted", "Whether low satellites weigh less in a fix"),
];

/// Keys of corrections.
pub(crate) const CORRECTION_KEYS: &[Key] = &[
    Key::number(
        "reference_range_m",
        "m",
        0.0,
        1e4,
        "Range error of the reference station, deviation, at level per_satellite",
    ),
    Key::number("reference_tau_s", "s", 1e-3, 1e6, "Its correlation time"),
    Key::number("iono_gradient", "", 0.0, 1e-2, "Gradient of the ionospheric delay, m/m"),
    Key::number("smoothing_s", "s", 0.0, 1e4, "Time constant of carrier smoothing"),
    Key::number(
        "space_decorrelation",
        "",
        0.0,
        1e-2,
        "Decorrelation of other errors with distance, m/m",
    ),
    Key::number(
        "correction_latency_s",
        "s",
        0.0,
        3600.0,
        "Age of a correction when it arrives; to 600 at level per_satellite",
    ),
    Key::number(
        "correction_s",
        "s",
        1e-3,
        3600.0,
        "Time between two corrections; to 600 at level per_satellite",
    ),
];

impl RangeCorrections {
    pub(crate) fn read(given: &Given<'_>) -> Self {
        let mut c = Self::on_airport();
        given.number("reference_range_m", &mut c.reference.sigma_m);
        given.number("reference_tau_s", &mut c.reference.tau_s);
        given.number("iono_gradient", &mut c.iono_gradient);
        given.number("smoothing_s", &mut c.smoothing_s);
        given.number("space_decorrelation", &mut c.space_decorrelation);
        given.number("correction_latency_s", &mut c.latency_s);
        given.number("correction_s", &mut c.period_s);
        c
    }
}

impl RangingConfig {
    pub(crate) fn read(given: &Given<'_>) -> Self {
        let mut b = RangeBudget::modern();
        given.number("selective_availability_m", &mut b.selective_availability.sigma_m);
        given.number("selective_availability_tau_s", &mut b.selective_availability.tau_s);
        given.number("clock_ephemeris_m", &mut b.clock_ephemeris.sigma_m);
        given.number("clock_ephemeris_tau_s", &mut b.clock_ephemeris.tau_s);
        given.number("ionosphere_m", &mut b.ionosphere.sigma_m);
        given.number("ionosphere_tau_s", &mut b.ionosphere.tau_s);
        given.number("troposphere_m", &mut b.troposphere.sigma_m);
        given.number("troposphere_tau_s", &mut b.troposphere.tau_s);
        given.number("multipath_m", &mut b.multipath.sigma_m);
        given.number("multipath_tau_s", &mut b.multipath.tau_s);
        given.number("noise_m", &mut b.noise_m);
        let mut weighted = false;
        given.flag("weighted", &mut weighted);
        Self { sky: SkyConfig::read(given, 1.0), budget: b, weighted, corrections: None }
    }

    /// Over Zurich, for benches and tests.
    pub(crate) fn example(corrections: Option<RangeCorrections>) -> Self {
        let site = geodesy::Geodetic::from_degrees(47.45, 8.55, 432.0);
        let sky = SkyConfig { step_s: 1.0, ..SkyConfig::reference(site, 8.3e8) };
        Self { sky, budget: RangeBudget::modern(), weighted: false, corrections }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::gps;
    use geodesy::Geodetic;
    use proptest::prelude::*;

    fn config(corrections: Option<RangeCorrections>, budget: RangeBudget) -> RangingConfig {
        let mut sky = SkyConfig::reference(Geodetic::from_degrees(47.45, 8.55, 432.0), 8.64e7);
        sky.step_s = 1.0;
        sky.failures = crate::sensors::reporting::constellation::SatelliteFailures::never();
        RangingConfig { sky, budget, weighted: false, corrections }
    }

    /// Follows the sky over an interval with everything simulated.
    fn prepare(ranging: &mut Ranging, run_seed: u64, from_s: f64, to_s: f64) {
        let interval = ScanInterval {
            run_seed,
            scan: 1,
            from: SimTime::from_s(from_s),
            to: SimTime::from_s(to_s),
        };
        ranging.prepare(&interval, &mut planning(), gps::bounds::per_satellite);
    }

    fn planning() -> Planning {
        Planning::new(crate::plot::SensorId(1), &gps::PER_SATELLITE).always()
    }

    fn fix(
        ranging: &Ranging,
        receiver: &mut RangingReceiver,
        key: DrawKey,
        now_s: f64,
        distance_m: f64,
    ) -> RangeFix {
        let want = Want { distance_m, explain: true, ..Want::default() };
        let (now, levels) = (SimTime::from_s(now_s), PositioningLevels::EXACT);
        let fix = ranging.fix(receiver, key, now, &want, &levels, &mut planning()).expect("a fix");
        let parts = fix.parts.0.iter().fold(Vector2::zeros(), |sum, part| sum + part);
        assert!((parts - fix.error_m).norm() < 1e-9, "the error is the sum of its sources");
        fix
    }

    /// Mean squares of the error over the trace of its stated covariance, and mean square error.
    fn run(config: RangingConfig, runs: u64, distance_m: f64) -> (f64, f64) {
        let (mut ratio, mut square, mut n) = (0.0, 0.0, 0.0);
        for run_seed in 0..runs {
            let mut ranging = Ranging::new(config.clone()).expect("sound");
            let mut receiver = ranging.receiver();
            prepare(&mut ranging, run_seed, 99.0, 101.0);
            let key = DrawKey { run_seed, sensor: 1, entity: 4, scan: 100 };
            let fix = fix(&ranging, &mut receiver, key, 100.25, distance_m);
            let [east, cross, north] = fix.covariance_m2;
            assert!(east * north > cross * cross);
            ratio += fix.error_m.norm_squared() / (east + north);
            square += fix.error_m.norm_squared();
            n += 1.0;
        }
        (ratio / n, square / n)
    }

    #[test]
    fn errors_match_the_covariance_that_is_reported() {
        let corrections = RangeCorrections::on_airport();
        for (name, config, metres, sigma) in [
            ("modern", config(None, RangeBudget::modern()), 0.0, 3.5..6.5),
            (
                "selective availability",
                config(None, RangeBudget::with_selective_availability()),
                0.0,
                20.0..40.0,
            ),
            (
                "weighted",
                RangingConfig { weighted: true, ..config(None, RangeBudget::modern()) },
                0.0,
                3.0..6.0,
            ),
            ("differential", config(Some(corrections), RangeBudget::modern()), 3000.0, 0.6..1.8),
            (
                "differential, corrections of a wandering clock 30 s old",
                config(
                    Some(RangeCorrections { latency_s: 30.0, ..corrections }),
                    RangeBudget::with_selective_availability(),
                ),
                3000.0,
                2.0..12.0,
            ),
            (
                "differential, 100 km",
                config(Some(corrections), RangeBudget::modern()),
                1e5,
                1.2..3.0,
            ),
        ] {
            let (ratio, square) = run(config, 1000, metres);
            // The mean of e²/trace has a deviation of at most √(2/n) = 0.045.
            assert!((ratio - 1.0).abs() < 0.15, "{name}: {ratio}");
            assert!(sigma.contains(&square.sqrt()), "{name}: {} m", square.sqrt());
        }
    }

    #[test]
    fn an_old_correction_of_a_wandering_clock_is_worse_than_a_new_one() {
        let budget = RangeBudget::with_selective_availability();
        let with_age = |latency_s| {
            let corrections = RangeCorrections { latency_s, ..RangeCorrections::on_airport() };
            run(config(Some(corrections), budget), 1000, 0.0).1
        };
        let (fresh, old) = (with_age(0.0), with_age(20.0));
        assert!(fresh < 4.0 && old > 4.0 * fresh, "{fresh} {old}");
    }

    #[test]
    fn receivers_share_the_sky_but_not_their_multipath() {
        let mut ranging = Ranging::new(config(None, RangeBudget::modern())).expect("sound");
        let (mut difference, mut square) = (0.0, 0.0);
        for run_seed in 0..500 {
            prepare(&mut ranging, run_seed, 0.0, 1.0);
            let error_m = |entity| {
                let key = DrawKey { run_seed, sensor: 1, entity, scan: 1 };
                fix(&ranging, &mut ranging.receiver(), key, 0.5, 0.0).error_m
            };
            let (a, b) = (error_m(1), error_m(2));
            difference += (a - b).norm_squared();
            square += 0.5 * (a.norm_squared() + b.norm_squared());
            ranging = Ranging::new(config(None, RangeBudget::modern())).expect("sound");
        }
        let correlation = 1.0 - 0.5 * difference / square;
        assert!(correlation > 0.85 && correlation < 0.995, "{correlation}");
    }

    #[test]
    fn mapping_functions_hold_their_limits() {
        let zenith = std::f64::consts::FRAC_PI_2;
        for (name, f) in [
            ("obliquity", obliquity as fn(f64) -> f64),
            ("troposphere", tropospheric_mapping),
            ("multipath", multipath_growth),
        ] {
            assert!((f(zenith) - 1.0).abs() < 2.5e-3, "{name} at the zenith: {}", f(zenith));
            for (low, high) in [(0.0, 0.1), (0.1, 0.5), (0.5, 1.0), (1.0, zenith)] {
                assert!(f(low) > f(high) && f(low).is_finite(), "{name}");
            }
        }
        assert!((obliquity(5_f64.to_radians()) - 3.04).abs() < 0.05);
    }

    proptest! {
        #[test]
        fn the_ellipse_is_the_covariance(
            east in 1e-6_f64..1e6, north in 1e-6_f64..1e6, r in -0.999_999_f64..0.999_999,
        ) {
            let cross = r * (east * north).sqrt();
            let (axis, [along, across]) = ellipse([east, cross, north]);
            let other = Vector2::new(axis.y, -axis.x);
            let back = axis * axis.transpose() * along + other * other.transpose() * across;
            let scale = along;
            prop_assert!((axis.norm() - 1.0).abs() < 1e-12 && across > 0.0);
            prop_assert!((back[(0, 0)] - east).abs() < 1e-9 * scale);
            prop_assert!((back[(0, 1)] - cross).abs() < 1e-9 * scale);
            prop_assert!((back[(1, 1)] - north).abs() < 1e-9 * scale);
        }
    }
}
