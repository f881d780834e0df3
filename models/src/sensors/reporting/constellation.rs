//! Where the satellites are, who sees them, and what their geometry does to an error.
//!
//! Source: GPS SPS Performance Standard (2001), reference 24-slot constellation and epoch; dilution
//! of precision after Spilker in *Global Positioning System: Theory and Applications* I (1996).

use geodesy::{Ecef, Geodetic, LocalFrame};
use rand::rngs::ChaCha8Rng;

use crate::draw::{DrawKey, Purpose, exponential, uniform};
use crate::effects::positioning::{Ladders, Planning, PositioningEffect as E, PositioningScene};
use crate::keys::Key;
use crate::sensors::ScanInterval;
use crate::sensors::config::{ConfigError, check, count, number};
use crate::sensors::declared::Given;
use crate::sensors::reporting::service::FailureMode;
use crate::time::SimTime;

/// Gravitational constant times mass of the earth in the user algorithm, m³/s².
const MU: f64 = 3.986_005e14;
/// Rotation of the earth, rad/s.
const EARTH_RATE: f64 = 7.292_115_146_7e-5;

/// One orbital slot at the epoch.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// Name, "A1" to "F4".
    pub name: String,
    /// Right ascension of the ascending node, degrees.
    pub raan_deg: f64,
    /// Argument of latitude, degrees.
    pub latitude_argument_deg: f64,
}

/// A constellation of circular orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct Constellation {
    /// The slots, at most 32.
    pub slots: Vec<Slot>,
    /// Inclination, degrees.
    pub inclination_deg: f64,
    /// Radius of the orbits, m.
    pub radius_m: f64,
    /// Greenwich hour angle of the equinox at the epoch, degrees.
    pub greenwich_deg: f64,
}

impl Constellation {
    /// The 24 slots of the 2001 standard at 0000Z 1 July 1993.
    #[must_use]
    pub fn reference_24() -> Self {
        let slots = SLOTS_24
            .iter()
            .map(|&(name, raan_deg, latitude_argument_deg)| Slot {
                name: name.into(),
                raan_deg,
                latitude_argument_deg,
            })
            .collect();
        Self {
            slots,
            inclination_deg: 55.0,
            radius_m: 26_559_700.0,
            greenwich_deg: (18.0 + (36.0 + 14.4 / 60.0) / 60.0) * 15.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        count("slots", self.slots.len(), 1, 32)?;
        number("inclination_deg", self.inclination_deg, 0.0, 180.0)?;
        number("radius_m", self.radius_m, 6.5e6, 1e9)?;
        number("greenwich_deg", self.greenwich_deg, -360.0, 360.0)?;
        for slot in &self.slots {
            number("raan_deg", slot.raan_deg, -360.0, 360.0)?;
            number("latitude_argument_deg", slot.latitude_argument_deg, -360.0, 360.0)?;
        }
        Ok(())
    }

    /// Number of the slot with this name.
    #[must_use]
    pub fn slot(&self, name: &str) -> Option<usize> {
        self.slots.iter().position(|s| s.name == name)
    }

    /// Position of a slot's satellite `t_s` after the epoch.
    ///
    /// `u = u₀ + √(μ/a³) t`, `Λ = Ω − (GHA₀ + ω_e t)`.
    #[must_use]
    pub fn position(&self, slot: &Slot, t_s: f64) -> Ecef {
        let a = self.radius_m;
        let motion = (MU / (a * a * a)).sqrt();
        let u = slot.latitude_argument_deg.to_radians() + motion * t_s;
        let node = (slot.raan_deg - self.greenwich_deg).to_radians() - EARTH_RATE * t_s;
        let (su, cu) = libm::sincos(u);
        let (sn, cn) = libm::sincos(node);
        let (si, ci) = libm::sincos(self.inclination_deg.to_radians());
        Ecef::from_xyz_m([
            a * (cu * cn - su * ci * sn),
            a * (cu * sn + su * ci * cn),
            a * (su * si),
        ])
    }
}

/// Slots of the 2001 standard, Table 3-1: name, right ascension and argument of latitude in degrees.
const SLOTS_24: [(&str, f64, f64); 24] = [
    ("A1", 272.847, 268.126),
    ("A2", 272.847, 161.786),
    ("A3", 272.847, 11.676),
    ("A4", 272.847, 41.806),
    ("B1", 332.847, 80.956),
    ("B2", 332.847, 173.336),
    ("B3", 332.847, 309.976),
    ("B4", 332.847, 204.376),
    ("C1", 32.847, 111.876),
    ("C2", 32.847, 11.796),
    ("C3", 32.847, 339.666),
    ("C4", 32.847, 241.556),
    ("D1", 92.847, 135.226),
    ("D2", 92.847, 265.446),
    ("D3", 92.847, 35.156),
    ("D4", 92.847, 167.356),
    ("E1", 152.847, 197.046),
    ("E2", 152.847, 302.596),
    ("E3", 152.847, 66.066),
    ("E4", 152.847, 333.686),
    ("F1", 212.847, 238.886),
    ("F2", 212.847, 345.226),
    ("F3", 212.847, 105.206),
    ("F4", 212.847, 135.346),
];

/// A satellite as a receiver sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Above the horizon, rad.
    pub elevation_rad: f64,
    /// Clockwise from north, rad in [0, 2π).
    pub azimuth_rad: f64,
    /// Distance, m.
    pub range_m: f64,
    /// Unit vector to the satellite: east, north, up.
    pub unit: [f64; 3],
}

/// Direction and distance of a satellite from the origin of `frame`.
#[must_use]
pub fn look(frame: &LocalFrame, satellite: Ecef) -> Look {
    let enu = frame.to_enu(satellite).to_array();
    let range_m = geodesy::length(enu);
    let unit = enu.map(|x| x / range_m);
    let ground = libm::hypot(enu[0], enu[1]);
    let azimuth = libm::atan2(enu[0], enu[1]);
    Look {
        elevation_rad: libm::atan2(enu[2], ground),
        azimuth_rad: if azimuth < 0.0 { azimuth + std::f64::consts::TAU } else { azimuth },
        range_m,
        unit,
    }
}

/// Geometry of one fix: Q = (Hᵀ W H)⁻¹ for rows (−e, −n, −u, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dop {
    /// Q in the order east, north, up, clock.
    pub q: [[f64; 4]; 4],
}

impl Dop {
    /// Geometry of a fix from satellites in the directions `units` (east, north, up) with `weights`
    /// (all 1 if empty). `None` below four satellites or where they do not span the four unknowns:
    /// a pivot of the Cholesky factor below 1e-9 of the largest weight.
    #[must_use]
    pub fn of(units: &[[f64; 3]], weights: &[f64]) -> Option<Self> {
        if units.len() < 4 {
            return None;
        }
        let weight = |i: usize| weights.get(i).copied().unwrap_or(1.0);
        let largest = (0..units.len()).map(weight).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        let mut normal = [[0.0; 4]; 4];
        for (i, [e, n, u]) in units.iter().enumerate() {
            let row = [-e, -n, -u, 1.0];
            let w = weight(i) / largest;
            for (r, line) in normal.iter_mut().enumerate() {
                for (c, value) in line.iter_mut().enumerate() {
                    *value += w * row[r] * row[c];
                }
            }
        }
        let mut q = invert(&normal)?;
        q.iter_mut().flatten().for_each(|x| *x /= largest);
        Some(Self { q })
    }

    /// North dilution: deviation of the north error per deviation of a range.
    #[must_use]
    pub fn north(&self) -> f64 {
        self.q[1][1].sqrt()
    }
    /// East dilution.
    #[must_use]
    pub fn east(&self) -> f64 {
        self.q[0][0].sqrt()
    }
    /// Vertical dilution.
    #[must_use]
    pub fn vertical(&self) -> f64 {
        self.q[2][2].sqrt()
    }
    /// Time dilution.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.q[3][3].sqrt()
    }
    /// Horizontal dilution.
    #[must_use]
    pub fn horizontal(&self) -> f64 {
        (self.q[0][0] + self.q[1][1]).sqrt()
    }
    /// Position dilution.
    #[must_use]
    pub fn position(&self) -> f64 {
        (self.q[0][0] + self.q[1][1] + self.q[2][2]).sqrt()
    }
    /// Geometric dilution.
    #[must_use]
    pub fn geometric(&self) -> f64 {
        (self.q[0][0] + self.q[1][1] + self.q[2][2] + self.q[3][3]).sqrt()
    }

    /// Shift of the fix (east, north, up, m) per metre of range error on the satellite in direction
    /// `unit` with `weight`: its column of S = Q Hᵀ W.
    #[must_use]
    pub fn shift_per_metre(&self, unit: [f64; 3], weight: f64) -> [f64; 3] {
        let row = [-unit[0], -unit[1], -unit[2], 1.0];
        let mut shift = [0.0; 3];
        for (value, line) in shift.iter_mut().zip(&self.q) {
            *value = weight * line.iter().zip(row).map(|(q, h)| q * h).sum::<f64>();
        }
        shift
    }
}

/// Inverse of a symmetric positive definite matrix by Cholesky; `None` if a pivot is below 1e-9.
fn invert(a: &[[f64; 4]; 4]) -> Option<[[f64; 4]; 4]> {
    let mut l = [[0.0; 4]; 4];
    for r in 0..4 {
        for c in 0..=r {
            let rest = a[r][c] - (0..c).map(|k| l[r][k] * l[c][k]).sum::<f64>();
            if r == c {
                if rest.is_nan() || rest < 1e-9 {
                    return None;
                }
                l[r][r] = rest.sqrt();
            } else {
                l[r][c] = rest / l[c][c];
            }
        }
    }
    // Inverse of the factor, then its transpose times itself.
    let mut m = [[0.0; 4]; 4];
    for c in 0..4 {
        m[c][c] = 1.0 / l[c][c];
        for r in c + 1..4 {
            m[r][c] = -(c..r).map(|k| l[r][k] * m[k][c]).sum::<f64>() / l[r][r];
        }
    }
    let mut q = [[0.0; 4]; 4];
    for r in 0..4 {
        for c in 0..4 {
            q[r][c] = (r.max(c)..4).map(|k| m[k][r] * m[k][c]).sum();
        }
    }
    Some(q)
}

/// How one satellite fails: modes that take it off, and soft failures that falsify its range.
#[derive(Clone, Debug, PartialEq)]
pub struct SatelliteFailures {
    /// Hard failures (satellite off): MTBF and MTTR in s.
    pub hard: Vec<FailureMode>,
    /// Soft failures (range error), in s.
    pub soft: FailureMode,
    /// Range error at the onset of a soft failure, m.
    pub soft_step_m: f64,
    /// Its growth, m/s.
    pub soft_ramp_m_per_s: f64,
    /// Its limit, m.
    pub soft_limit_m: f64,
}

impl SatelliteFailures {
    /// Long-term failures every 7.5 years for 30 days, maintenance every 2 880 h for a day, three soft
    /// failures a year in the constellation of at most 6 h.
    #[must_use]
    pub fn reference() -> Self {
        let hours = |mtbf: f64, mttr: f64| FailureMode { mtbf: mtbf * 3600.0, mttr: mttr * 3600.0 };
        Self {
            hard: vec![hours(65_700.0, 720.0), hours(2880.0, 24.0)],
            soft: hours(70_128.0, 6.0),
            soft_step_m: 10.0,
            soft_ramp_m_per_s: 0.5,
            soft_limit_m: 5000.0,
        }
    }

    /// Satellites never fail.
    #[must_use]
    pub fn never() -> Self {
        Self {
            hard: Vec::new(),
            soft: FailureMode { mtbf: f64::MAX, mttr: 1.0 },
            ..Self::reference()
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        count("hard", self.hard.len(), 0, 8)?;
        for mode in self.hard.iter().chain([&self.soft]) {
            number("mtbf", mode.mtbf, 1e-3, f64::MAX)?;
            number("mttr", mode.mttr, 1e-6, 1e12)?;
        }
        number("soft_step_m", self.soft_step_m, 0.0, 1e6)?;
        number("soft_ramp_m_per_s", self.soft_ramp_m_per_s, 0.0, 1e4)?;
        number("soft_limit_m", self.soft_limit_m, self.soft_step_m, 1e6)
    }

    fn modes(&self) -> impl Iterator<Item = &FailureMode> {
        self.hard.iter().chain([&self.soft])
    }
}

/// State of one satellite: works, or is in one failure mode; exponential times in each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Health {
    /// Number of the failure mode, hard ones first; `None` while it works.
    mode: Option<usize>,
    since: SimTime,
    until: SimTime,
    sojourn: u64,
    /// Sign of a soft failure's range error.
    sign: f64,
}

impl Health {
    /// The stationary state at `now`: mode i with (λᵢ/μᵢ) p_up. `key.scan` is ignored.
    #[must_use]
    pub fn start(failures: &SatelliteFailures, key: DrawKey, now: SimTime) -> Self {
        let mut rng = DrawKey { scan: 0, ..key }.rng(Purpose::Satellite);
        let total = 1.0 + failures.modes().map(FailureMode::load).sum::<f64>();
        let mut left = uniform(&mut rng) * total - 1.0;
        let mut mode = None;
        if left >= 0.0 {
            for (i, m) in failures.modes().enumerate() {
                mode = Some(i);
                left -= m.load();
                if left < 0.0 {
                    break;
                }
            }
        }
        let mut health = Self { mode, since: now, until: now, sojourn: 0, sign: 1.0 };
        health.sign = sign(&mut rng);
        health.stay(failures, now, exponential(&mut rng));
        health
    }

    /// Moves to `now`, sojourn by sojourn.
    pub fn advance(&mut self, failures: &SatelliteFailures, key: DrawKey, now: SimTime) {
        while self.until <= now {
            let from = self.until;
            self.sojourn += 1;
            let mut rng = DrawKey { scan: self.sojourn, ..key }.rng(Purpose::Satellite);
            let (which, length) = (uniform(&mut rng), exponential(&mut rng));
            self.mode = match self.mode {
                Some(_) => None,
                None => {
                    let mut left = which * failures.modes().map(|m| 1.0 / m.mtbf).sum::<f64>();
                    let mut mode = None;
                    for (i, m) in failures.modes().enumerate() {
                        mode = Some(i);
                        left -= 1.0 / m.mtbf;
                        if left < 0.0 {
                            break;
                        }
                    }
                    mode
                }
            };
            self.since = from;
            self.sign = sign(&mut rng);
            self.stay(failures, from, length);
        }
    }

    /// Whether the satellite can be used (soft failures are not seen by the user).
    #[must_use]
    pub fn usable(&self, failures: &SatelliteFailures) -> bool {
        self.mode.is_none_or(|m| m >= failures.hard.len())
    }

    /// Range error of a soft failure under way at `now`, m; 0 otherwise.
    #[must_use]
    pub fn range_error_m(&self, failures: &SatelliteFailures, now: SimTime) -> f64 {
        match self.mode {
            Some(m) if m >= failures.hard.len() => {
                let grown = failures.soft_step_m
                    + failures.soft_ramp_m_per_s * now.since_s(self.since).max(0.0);
                self.sign * grown.min(failures.soft_limit_m)
            }
            _ => 0.0,
        }
    }

    fn stay(&mut self, failures: &SatelliteFailures, from: SimTime, unit: f64) {
        let mean_s = match self.mode {
            Some(i) => failures.modes().nth(i).map_or(0.0, |m| m.mttr),
            None => 1.0 / failures.modes().map(|m| 1.0 / m.mtbf).sum::<f64>(),
        };
        let length_s = mean_s * unit;
        self.until = if length_s < 3e9 {
            SimTime(from.0.saturating_add(SimTime::from_s(length_s).0.max(1)))
        } else {
            SimTime(i64::MAX)
        };
    }
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if uniform(rng) < 0.5 { -1.0 } else { 1.0 }
}

/// A sky over one site: constellation, mask, failures.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyConfig {
    /// The satellites.
    pub constellation: Constellation,
    /// Where the airport is.
    pub site: Geodetic,
    /// Seconds from 0000Z 1 July 1993 to the start of the run.
    pub epoch_s: f64,
    /// Least elevation of a satellite in use, degrees.
    pub mask_deg: f64,
    /// Largest position dilution of a usable fix.
    pub pdop_limit: f64,
    /// How satellites fail.
    pub failures: SatelliteFailures,
    /// Time between two computations of the geometry, s.
    pub step_s: f64,
}

impl SkyConfig {
    /// The reference constellation over `site`, mask 5°, PDOP up to 6, geometry every 10 s.
    #[must_use]
    pub fn reference(site: Geodetic, epoch_s: f64) -> Self {
        Self {
            constellation: Constellation::reference_24(),
            site,
            epoch_s,
            mask_deg: 5.0,
            pdop_limit: 6.0,
            failures: SatelliteFailures::reference(),
            step_s: 10.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.constellation.validate()?;
        number("site_lat_deg", self.site.lat_deg(), -90.0, 90.0)?;
        number("site_lon_deg", self.site.lon_deg(), -360.0, 360.0)?;
        number("site_height_m", self.site.height_m, -1e3, 1e4)?;
        number("epoch_s", self.epoch_s, -1e10, 1e10)?;
        check(KEYS, "mask_deg", self.mask_deg)?;
        check(KEYS, "pdop_limit", self.pdop_limit)?;
        check(KEYS, "step_s", self.step_s)?;
        self.failures.validate()
    }
}

/// A satellite in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InView {
    /// Number of its slot.
    pub slot: usize,
    /// Where it stands.
    pub look: Look,
}

/// Satellites above the mask, in the order of slots, without those named in `removed`.
#[must_use]
pub fn in_view(
    constellation: &Constellation,
    frame: &LocalFrame,
    t_s: f64,
    mask_rad: f64,
    mut removed: impl FnMut(usize) -> bool,
) -> Vec<InView> {
    constellation
        .slots
        .iter()
        .enumerate()
        .filter(|&(slot, _)| !removed(slot))
        .map(|(slot, s)| InView { slot, look: look(frame, constellation.position(s, t_s)) })
        .filter(|v| v.look.elevation_rad >= mask_rad)
        .collect()
}

/// The sky of one instant, the same for every receiver of the airport.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyEpoch {
    /// Instant.
    pub time: SimTime,
    /// Satellites in use with the range error of a soft failure, m.
    pub satellites: Vec<(InView, f64)>,
    /// Geometry of their fix, `None` where there is none within the limit.
    pub dop: Option<Dop>,
}

impl SkyEpoch {
    /// Shift of a fix by soft failures, m east and north.
    #[must_use]
    pub fn soft_shift_m(&self) -> [f64; 2] {
        let mut shift = [0.0; 2];
        if let Some(dop) = &self.dop {
            for (view, error_m) in self.satellites.iter().filter(|s| s.1 != 0.0) {
                let per_metre = dop.shift_per_metre(view.look.unit, 1.0);
                shift[0] += per_metre[0] * error_m;
                shift[1] += per_metre[1] * error_m;
            }
        }
        shift
    }
}

/// When satellites begin to fail: an hour before the run, earlier than any correction in use.
const SKY_BEGINS: SimTime = SimTime(-3_600_000_000_000);

/// The sky as it goes on: satellites fail and are repaired, the geometry is computed once per step.
#[derive(Clone, Debug)]
pub struct Sky {
    config: SkyConfig,
    frame: LocalFrame,
    health: Vec<Health>,
    epochs: Vec<SkyEpoch>,
    /// Whether hard and soft failures are simulated, and how often they were looked at.
    simulated: [bool; 2],
    looked: [u64; 2],
}

impl Sky {
    /// A sky that has not begun. Its draws belong to no sensor: sensors with the same sky see the
    /// same satellites fail.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: SkyConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let frame = LocalFrame::at(config.site);
        Ok(Self {
            config,
            frame,
            health: Vec::new(),
            epochs: Vec::new(),
            simulated: [true; 2],
            looked: [0; 2],
        })
    }

    /// Whether satellites fail hard, and softly, from the next epoch on. What they do is the same
    /// whether it was followed meanwhile or not.
    pub(crate) fn simulate(&mut self, hard: bool, soft: bool) {
        self.simulated = [hard, soft];
    }

    /// How often satellites were asked for hard and soft failures since the last call.
    pub(crate) fn take_looked(&mut self) -> [u64; 2] {
        std::mem::take(&mut self.looked)
    }

    /// Horizontal dilution at `time` with every satellite in order; 0 where there is no fix.
    pub(crate) fn nominal_dilution(&self, time: SimTime) -> f64 {
        let config = &self.config;
        let t_s = config.epoch_s + time.s();
        let mask_rad = config.mask_deg.to_radians();
        let views = in_view(&config.constellation, &self.frame, t_s, mask_rad, |_| false);
        let units: Vec<_> = views.iter().map(|v| v.look.unit).collect();
        let dop = Dop::of(&units, &[]).filter(|d| d.position() <= config.pdop_limit);
        dop.map_or(0.0, |d| d.horizontal())
    }

    /// Largest horizontal dilution of the epochs kept.
    pub(crate) fn largest_dilution(&self) -> f64 {
        let dilutions = self.epochs.iter().filter_map(|e| e.dop).map(|d| d.horizontal());
        dilutions.fold(0.0, f64::max)
    }

    /// Computes the epochs that reports in (`from`, `to`] need; keeps those of the last `keep_s`.
    /// Returns how many were added at the end of [`Sky::epochs`].
    pub fn prepare(&mut self, run_seed: u64, from: SimTime, to: SimTime, keep_s: f64) -> usize {
        let step_ns = SimTime::from_s(self.config.step_s).0;
        let oldest = SimTime(from.0 - SimTime::from_s(keep_s).0 - step_ns);
        self.epochs.retain(|e| e.time > oldest);
        let first = match self.epochs.last() {
            Some(last) => last.time.0.div_euclid(step_ns) + 1,
            None => (from.0 - SimTime::from_s(keep_s).0).div_euclid(step_ns),
        };
        let before = self.epochs.len();
        for number in first..=to.0.div_euclid(step_ns) {
            let epoch = self.epoch(run_seed, SimTime(number * step_ns));
            self.epochs.push(epoch);
        }
        self.epochs.len() - before
    }

    /// The epochs computed, in order of time.
    #[must_use]
    pub fn epochs(&self) -> &[SkyEpoch] {
        &self.epochs
    }

    /// The number (in [`Sky::epochs`]) of the newest epoch not after `time`.
    #[must_use]
    pub fn at(&self, time: SimTime) -> Option<usize> {
        self.epochs.partition_point(|e| e.time <= time).checked_sub(1)
    }

    /// Its parameters.
    #[must_use]
    pub fn config(&self) -> &SkyConfig {
        &self.config
    }

    fn epoch(&mut self, run_seed: u64, time: SimTime) -> SkyEpoch {
        let config = &self.config;
        let key = |slot: usize| DrawKey { run_seed, sensor: 0, entity: slot as u64, scan: 0 };
        let [hard, soft] = self.simulated;
        let fails = hard || soft;
        if self.health.is_empty() && fails {
            let slots = 0..config.constellation.slots.len();
            self.health =
                slots.map(|slot| Health::start(&config.failures, key(slot), SKY_BEGINS)).collect();
        }
        if fails {
            for (slot, health) in self.health.iter_mut().enumerate() {
                health.advance(&config.failures, key(slot), time);
            }
        }
        let (health, looked) = (&self.health, &mut self.looked);
        let satellites: Vec<_> = in_view(
            &config.constellation,
            &self.frame,
            config.epoch_s + time.s(),
            config.mask_deg.to_radians(),
            |slot| {
                looked[0] += u64::from(hard);
                hard && !health[slot].usable(&config.failures)
            },
        )
        .into_iter()
        .map(|view| {
            looked[1] += u64::from(soft);
            let false_m =
                if soft { health[view.slot].range_error_m(&config.failures, time) } else { 0.0 };
            (view, false_m)
        })
        .collect();
        let units: Vec<_> = satellites.iter().map(|s| s.0.look.unit).collect();
        let dop = Dop::of(&units, &[]).filter(|d| d.position() <= config.pdop_limit);
        SkyEpoch { time, satellites, dop }
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

/// Keys of the sky.
pub(crate) const KEYS: &[Key] = &[
    Key::number("mask_deg", "°", 0.0, 89.0, "Least elevation of a satellite in use"),
    Key::number("pdop_limit", "", 1.0, 1e6, "Largest dilution of a position that is given"),
    Key::number("step_s", "s", 0.01, 3600.0, "Time between two geometries of the sky"),
    Key::flag("satellite_failures", "Whether satellites fail"),
];

/// 1993-07-01T00:00:00Z, the epoch of the reference constellation.
const EPOCH_UTC_NS: i64 = 741_484_800 * 1_000_000_000;

impl SkyConfig {
    /// Over the airport of a scene, with a geometry every `step_s` unless it says otherwise.
    pub(crate) fn read(given: &Given<'_>, step_s: f64) -> Self {
        let epoch_s = (given.start_utc_ns - EPOCH_UTC_NS) as f64 * 1e-9;
        let mut sky = Self { step_s, ..Self::reference(given.reference, epoch_s) };
        given.number("mask_deg", &mut sky.mask_deg);
        given.number("pdop_limit", &mut sky.pdop_limit);
        given.number("step_s", &mut sky.step_s);
        let mut fail = true;
        given.flag("satellite_failures", &mut fail);
        if !fail {
            sky.failures = SatelliteFailures::never();
        }
        sky
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn angles_of_slots_beyond_a_turn_are_refused_by_their_key() {
        let sound = Constellation::reference_24();
        assert!(sound.validate().is_ok());
        for wrong in [-360.5, 360.5, f64::NAN] {
            let mut argument = sound.clone();
            argument.slots[3].latitude_argument_deg = wrong;
            let said = argument.validate().expect_err("beyond a turn").to_string();
            assert!(said.contains("latitude_argument_deg"), "{said}");
            let mut node = sound.clone();
            node.slots[3].raan_deg = wrong;
            let said = node.validate().expect_err("beyond a turn").to_string();
            assert!(said.contains("raan_deg"), "{said}");
        }
    }

    fn rome() -> Geodetic {
        Geodetic::from_degrees(41.8, 12.25, 10.0)
    }

    #[test]
    fn too_few_or_degenerate_satellites_give_no_fix() {
        let unit = |az: f64, el: f64| {
            let (saz, caz) = libm::sincos(az);
            let (sel, cel) = libm::sincos(el);
            [saz * cel, caz * cel, sel]
        };
        let ring =
            |n: usize, el: f64| -> Vec<_> { (0..n).map(|i| unit(i as f64 * 1.7, el)).collect() };
        for (name, units, fix) in [
            ("none", vec![], false),
            ("three", ring(3, 0.5), false),
            ("four in one place", vec![unit(0.3, 0.7); 4], false),
            ("all at one elevation: up and clock are one", ring(8, 0.5), false),
            (
                "all in one vertical plane",
                (1..8).map(|i| unit(0.0, f64::from(i) * 0.4)).collect(),
                false,
            ),
            (
                "all at one elevation but for 1e-7",
                {
                    let mut units = ring(7, 0.5);
                    units.push(unit(0.1, 0.5 + 1e-7));
                    units
                },
                false,
            ),
            (
                "four, well spread",
                vec![unit(0.0, 0.2), unit(2.1, 0.2), unit(4.2, 0.2), unit(0.0, 1.5)],
                true,
            ),
        ] {
            let dop = Dop::of(&units, &[]);
            assert_eq!(dop.is_some(), fix, "{name}: {dop:?}");
            if let Some(dop) = dop {
                assert!(dop.geometric().is_finite() && dop.geometric() > 0.0, "{name}");
            }
        }
        let four = [unit(0.0, 0.2), unit(2.1, 0.2), unit(4.2, 0.2), unit(0.0, 1.5)];
        for weights in [[0.0; 4], [f64::NAN; 4], [f64::INFINITY; 4], [1.0, 1.0, 1.0, 0.0]] {
            assert_eq!(Dop::of(&four, &weights), None, "{weights:?}");
        }
    }

    proptest! {
        /// Q scales with 1/W, and S H = I: a range error of the form H x moves the fix by x.
        #[test]
        fn the_solution_solves(seed in 0_u64..1000, scale in 1e-6_f64..1e6) {
            let t = seed as f64 * 977.0;
            let frame = LocalFrame::at(rome());
            let views = in_view(&Constellation::reference_24(), &frame, t, 0.087, |_| false);
            let units: Vec<_> = views.iter().map(|v| v.look.unit).collect();
            let weights: Vec<_> = (0..units.len()).map(|i| scale * (1.0 + i as f64)).collect();
            let dop = Dop::of(&units, &weights).expect("five satellites or more at Rome");
            let x = [3.0, -2.0, 5.0, 7.0];
            let mut moved = [0.0; 3];
            for (unit, w) in units.iter().zip(&weights) {
                let range = x[3] - unit[0] * x[0] - unit[1] * x[1] - unit[2] * x[2];
                let shift = dop.shift_per_metre(*unit, *w);
                moved.iter_mut().zip(shift).for_each(|(m, s)| *m += s * range);
            }
            for i in 0..3 {
                prop_assert!((moved[i] - x[i]).abs() < 1e-9, "{moved:?}");
            }
        }
    }

    #[test]
    fn a_day_over_rome_has_the_published_shape() {
        let frame = LocalFrame::at(rome());
        let constellation = Constellation::reference_24();
        let (mut n2, mut e2, mut least, mut count) = (0.0, 0.0, usize::MAX, 0.0);
        let (mut north, mut hdop): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for minute in 0..1440 {
            let views = in_view(
                &constellation,
                &frame,
                f64::from(minute) * 60.0,
                5_f64.to_radians(),
                |_| false,
            );
            let units: Vec<_> = views.iter().map(|v| v.look.unit).collect();
            least = least.min(units.len());
            count += units.len() as f64;
            let dop = Dop::of(&units, &[]).expect("a fix at every minute");
            n2 += dop.north() * dop.north();
            e2 += dop.east() * dop.east();
            north.push(dop.north());
            hdop.push(dop.horizontal());
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        assert!(least >= 5 && (count / 1440.0 - 8.0).abs() < 0.5, "{least} {}", count / 1440.0);
        assert!((mean(&north) - 0.87).abs() < 0.05, "NDOP {}", mean(&north));
        assert!((mean(&hdop) - 1.09).abs() < 0.05, "HDOP {}", mean(&hdop));
        let ratio = f64::sqrt(n2 / e2);
        assert!((ratio - 1.38).abs() < 0.06, "north is worse than east by {ratio}");
    }

    #[test]
    fn satellites_are_down_for_their_share() {
        let failures = SatelliteFailures {
            hard: vec![
                FailureMode { mtbf: 1000.0, mttr: 100.0 },
                FailureMode { mtbf: 400.0, mttr: 20.0 },
            ],
            soft: FailureMode { mtbf: 2000.0, mttr: 50.0 },
            ..SatelliteFailures::reference()
        };
        let (mut usable, mut soft, mut looks) = (0.0, 0.0, 0.0);
        let (mut far, mut most) = (0.0, f64::max(failures.soft_step_m, 0.0));
        for slot in 0..200 {
            let key = DrawKey { run_seed: 5, sensor: 1, entity: slot, scan: 0 };
            let mut health = Health::start(&failures, key, SimTime::ZERO);
            for k in 0..200 {
                let now = SimTime::from_s(f64::from(k) * 500.0);
                health.advance(&failures, key, now);
                usable += f64::from(u8::from(health.usable(&failures)));
                let error_m = health.range_error_m(&failures, now);
                soft += f64::from(u8::from(error_m != 0.0));
                far += f64::from(u8::from(error_m > 0.0));
                most = f64::max(most, error_m.abs());
                looks += 1.0;
            }
        }
        let p_up = 1.0 / (1.0 + 0.1 + 0.05 + 0.025);
        // 40 000 looks, nearly independent at 500 s.
        assert!((usable / looks - 1.025 * p_up).abs() < 0.01, "{}", usable / looks);
        assert!((soft / looks - 0.025 * p_up).abs() < 0.004, "{}", soft / looks);
        // Too near as often as too far, and never beyond the limit: some 850 of them.
        assert!((far / soft - 0.5).abs() < 0.08, "{} of {soft}", far);
        assert!(most <= failures.soft_limit_m, "{most}");
    }

    #[test]
    fn the_sky_does_not_depend_on_the_scan_interval() {
        let config = SkyConfig::reference(rome(), 1e8);
        let mut coarse = Sky::new(config.clone()).expect("sound");
        let mut fine = Sky::new(config).expect("sound");
        coarse.prepare(3, SimTime::ZERO, SimTime::from_s(60.0), 0.0);
        for k in 0..600 {
            let at = |k: i64| SimTime(k * 100_000_000);
            fine.prepare(3, at(k), at(k + 1), 0.0);
            let (a, b) =
                (fine.at(at(k + 1)).expect("prepared"), coarse.at(at(k + 1)).expect("prepared"));
            assert_eq!(fine.epochs()[a], coarse.epochs()[b]);
        }
        assert!(fine.epochs().len() <= 3, "old epochs are forgotten");
    }

    /// What is a little beyond a limit is refused by its key, what is a little within is not.
    #[test]
    fn a_sky_beyond_its_limits_is_refused_by_the_key() {
        type Set = fn(&mut SkyConfig, f64);
        let said = |change: &dyn Fn(&mut SkyConfig)| {
            let mut sky = SkyConfig::reference(rome(), 1e8);
            change(&mut sky);
            sky.validate().err().map(|e| e.to_string())
        };
        assert_eq!(said(&|_| ()), None);
        let all: [(&str, f64, f64, Set); 7] = [
            ("site_lat_deg", -90.0, 90.0, |s, v| s.site = Geodetic::from_degrees(v, 12.0, 0.0)),
            ("site_lon_deg", -360.0, 360.0, |s, v| s.site = Geodetic::from_degrees(41.0, v, 0.0)),
            ("site_height_m", -1e3, 1e4, |s, v| s.site = Geodetic::from_degrees(41.0, 12.0, v)),
            ("epoch_s", -1e10, 1e10, |s, v| s.epoch_s = v),
            ("mask_deg", 0.0, 89.0, |s, v| s.mask_deg = v),
            ("pdop_limit", 1.0, 1e6, |s, v| s.pdop_limit = v),
            ("step_s", 0.01, 3600.0, |s, v| s.step_s = v),
        ];
        for (key, low, high, set) in all {
            let by = 1e-3 * (high - low).min(f64::max(low.abs(), 0.01));
            for (value, refused) in [
                (low + by, false),
                (high - by, false),
                (low - by, true),
                (high + by, true),
                (f64::NAN, true),
            ] {
                let found = said(&|sky| set(sky, value));
                let named = found.as_ref().is_some_and(|text| text.contains(key));
                assert_eq!((found.is_some(), named), (refused, refused), "{key} = {value}");
            }
        }
    }
}
