//! Scenes of the proof: drawn from a seed over the whole space that a scene may state, or given by a search.

use models::draw::{DrawKey, Purpose, uniform};
use models::effects::Tolerance;
use models::environment::surface::{MATERIALS, Material};
use models::environment::{RainCell, Weather};
use models::frames::{Point2, Point3, Vector2, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::asde::{Asde, AsdeParameters, DetectionRule, Energy};
use models::sensors::radar::detection::Swerling;
use models::sensors::radar::equation::{BudgetLevels, Echo, Polarisation};
use models::sensors::radar::shadow::Building;
use models::sensors::{TargetClass, TargetState, Truth};
use models::time::SimTime;
use rand::rngs::ChaCha8Rng;
use scenarios::ScenarioError;
use scenarios::sensors::asde::shipped;
use std::f64::consts::PI;
use std::sync::Arc;

/// One target: class, where at time zero (airport frame, m), velocity (m/s), heading (rad).
pub type Target = (TargetClass, Point3<f64>, Vector3<f64>, f64);

/// Targets that go straight on, or a little and come back: then each stays near where it is.
#[derive(Clone, Debug)]
pub struct Targets {
    /// One by one.
    pub list: Vec<Target>,
    /// After so many seconds each is back where it was; `None`: it goes on.
    pub back_s: Option<f64>,
}

impl Targets {
    /// They stay near where they are.
    #[must_use]
    pub fn near(list: Vec<Target>) -> Self {
        Self { list, back_s: Some(4.0) }
    }
}

impl Truth for Targets {
    fn len(&self) -> usize {
        self.list.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.list[index].0
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (_, start, velocity_mps, heading_rad) = &self.list[index];
        let away_s = self.back_s.map_or(time.s(), |back_s| {
            let phase = time.s() / back_s;
            back_s * (phase - (phase + 0.5).floor()).abs()
        });
        let position_m = start + velocity_mps * away_s;
        Some(TargetState { position_m, velocity_mps: *velocity_mps, heading_rad: *heading_rad })
    }
}

/// A scene of the proof.
#[derive(Clone, Debug)]
pub struct ProofScene {
    /// What it is, for people.
    pub name: String,
    /// The radar.
    pub parameters: AsdeParameters,
    /// The weather at the start; its cells move with the wind.
    pub weather: Weather,
    /// The targets.
    pub truth: Targets,
    /// The buildings.
    pub buildings: Arc<[Building]>,
    /// What is tolerated.
    pub tolerance: Tolerance,
    /// Turns of the antenna in a scan.
    pub turns: f64,
}

/// Numbers between 0 and 1 from which a scene is made: of a generator, or of a search.
pub struct Genes<'a> {
    rng: ChaCha8Rng,
    given: &'a [f64],
    next: usize,
}

impl<'a> Genes<'a> {
    pub(super) fn new(seed: u64, n: u64, given: &'a [f64]) -> Self {
        let key = DrawKey { run_seed: seed, sensor: 9, entity: n, scan: 0 };
        Self { rng: key.rng(Purpose::Study), given, next: 0 }
    }

    fn unit(&mut self) -> f64 {
        let own = uniform(&mut self.rng);
        self.next += 1;
        self.given.get(self.next - 1).copied().unwrap_or(own)
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Equal shares of equal ratios.
    pub(super) fn scaled(&mut self, low: f64, high: f64) -> f64 {
        low * libm::exp(self.unit() * libm::log(high / low))
    }

    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[((self.unit() * from.len() as f64) as usize).min(from.len() - 1)]
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// How many genes decide a scene before its further targets.
pub const GENES: usize = 64;

/// A scene of the whole space: number `n` of a seed, its first numbers given by a search where `given`
/// has any.
///
/// # Errors
/// If a parameter set that ships is missing.
pub fn proof_scene(seed: u64, n: u64, given: &[f64]) -> Result<ProofScene, ScenarioError> {
    let g = &mut Genes::new(seed, n, given);
    let mut p = shipped(g.pick(&["ku_asde3", "x_paper", "x_smr25"]))?;
    if g.chance(0.2) {
        p.carrier_ghz = g.between(5.0, 35.0);
    }
    p.polarisation =
        g.pick(&[Polarisation::Horizontal, Polarisation::Vertical, Polarisation::Circular]);
    if g.chance(0.4) {
        p.azimuth_beamwidth_deg = g.scaled(0.15, 2.0);
        p.elevation_beamwidth_deg = g.scaled(0.8, 90.0);
        p.tilt_deg = g.between(-1.0, 15.0);
        p.csc2_limit_deg = g.chance(0.5).then_some(g.between(10.0, 60.0));
    }
    p.antenna_height_m = g.scaled(4.0, 110.0);
    p.assumed_height_m = p.assumed_height_m.min(p.antenna_height_m);
    p.rain_top_m = p.rain_top_m.max(p.antenna_height_m);
    p.peak_power_w *= g.scaled(1e-3, 10.0);
    // Half of the scenes: as strong as gives the first target a wanted ratio of signal to clutter and noise.
    let wanted_db = if g.chance(0.5) { Some(g.between(-20.0, 60.0)) } else { None };
    p.roughness_m = g.pick(&[0.0, 0.001, 0.003, 0.02, 0.05, 0.2]);
    let usable =
        |m: &&Material| p.carrier_ghz >= m.published_ghz.0 && p.carrier_ghz <= m.extrapolated_ghz;
    let surfaces: Vec<&'static Material> = MATERIALS.iter().filter(usable).collect();
    p.surface = g.pick(&surfaces);
    p.reflection_coupling = if g.chance(0.5) { 0.0 } else { g.scaled(0.05, 1.0) };
    p.range_step_m = g.pick(&[0.0, 0.17, 0.17, 1.0, 5.0]);
    p.azimuth_step_deg = g.pick(&[0.0, 0.0055, 0.0055, 0.05, 0.5]);
    p.swerling = Swerling::case(g.pick(&[0, 0, 1, 2, 3, 4])).unwrap_or_default();
    p.detection = if g.chance(0.1) { DetectionRule::Threshold } else { DetectionRule::Bernoulli };
    p.energy = if g.chance(0.5) { Energy::SinglePulse } else { Energy::Dwell { factor: 1.5 } };
    p.frequency_agile = g.chance(0.5);
    p.rotation_rpm = g.pick(&[60.0, 60.0, 30.0]);
    // At most 512 pulses are summed.
    while p.pulses() > 500.0 {
        p.prf_hz *= 0.5;
    }
    p.range_max_m = p.range_max_m.min(0.99 * p.unambiguous_m());
    let mut weather = Weather {
        rain_mm_per_h: g.pick(&[0.0, 0.0, 1.0, 10.0, 40.0, 200.0]),
        visibility_m: g.pick(&[f64::INFINITY, 1000.0, 100.0, 30.0]),
        film_mm: g.pick(&[0.0, 0.0, 0.1, 0.5, 5.0]),
        temperature_k: 273.15 + g.between(-25.0, 40.0),
        vapour_g_per_m3: g.between(1.0, 20.0),
        wind_mps: Vector2::new(g.between(-15.0, 15.0), g.between(-15.0, 15.0)),
        ..Weather::default()
    };
    let reach = p.range_max_m;
    // The first target's place, and what the others do. Steep ones too: there polarisations differ most.
    let steep = g.chance(0.15);
    let far_m = g.scaled(60.0, if steep { 900.0 } else { reach * 1.05 });
    let azimuth = g.between(-PI, PI);
    let up_m = if g.chance(0.6) && !steep { 0.0 } else { g.scaled(1.0, 300.0) };
    let count = g.pick(&[1, 1, 2, 2, 3, 5, 8, 12]);
    let together = g.chance(0.5);
    let wall = g.pick(&[0, 0, 1, 2, 3]);
    let (wall_off_m, wall_long_m) = (g.scaled(8.0, 400.0), g.between(60.0, 300.0));
    let (wall_high_m, metal) = (g.between(3.0, 60.0), g.chance(0.5));
    let cells = g.pick(&[0, 0, 1, 3]);
    let tolerance = Tolerance {
        position_m: g.pick(&[0.1, 0.1, 0.02, 0.5, 5.0]),
        detection: g.pick(&[0.01, 0.01, 0.001, 0.1]),
        ..Tolerance::default()
    };
    let first_rcs = g.scaled(0.05, 1.0);
    let heading = match g.pick(&[0, 1, 2]) {
        0 => azimuth,
        1 => azimuth + 0.5 * PI,
        _ => g.between(-PI, PI),
    };
    let radial = |azimuth: f64| {
        let (sin, cos) = libm::sincos(azimuth);
        Vector3::new(sin, cos, 0.0)
    };
    let centre = Point3::from(radial(azimuth) * far_m);
    let mut targets = Vec::new();
    for i in 0..count {
        let class = class_of(
            g.pick(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]),
            if i == 0 { first_rcs } else { g.scaled(0.05, 1.0) },
        );
        let (place, heading) = if i == 0 {
            (centre + Vector3::new(0.0, 0.0, up_m), heading)
        } else if together {
            let near = Vector3::new(g.between(-50.0, 50.0), g.between(-50.0, 50.0), 0.0);
            (
                centre + near + Vector3::new(0.0, 0.0, if g.chance(0.7) { up_m } else { 0.0 }),
                g.between(-PI, PI),
            )
        } else {
            let up = if g.chance(0.8) { 0.0 } else { g.scaled(1.0, 300.0) };
            let place = Point3::from(radial(g.between(-PI, PI)) * g.scaled(20.0, reach * 1.05));
            (place + Vector3::new(0.0, 0.0, up), g.between(-PI, PI))
        };
        let speed = g.pick(&[0.0, 0.0, 0.3, 2.0]);
        targets.push((class, place, radial(heading) * speed, heading));
    }
    for _ in 0..cells {
        let place = centre.xy() + Vector2::new(g.between(-2e3, 2e3), g.between(-2e3, 2e3));
        weather.cells.push(RainCell {
            centre_m: place,
            radius_m: g.scaled(100.0, 1500.0),
            rain_mm_per_h: weather.rain_mm_per_h + g.scaled(2.0, 100.0),
        });
    }
    if let (Some(wanted_db), Some((class, place, ..))) = (wanted_db, targets.first()) {
        let radar = p.radar();
        let height_m = f64::max(place.z, 0.5 * class.height_m);
        let (extent_m, rcs_m2) = (class.height_m, class.rcs_m2);
        let echo = Echo { ground_m: place.xy().coords.norm(), height_m, extent_m, rcs_m2 };
        let air = radar.air(&weather);
        let exact = BudgetLevels::EXACT;
        let ratio = radar.budget(&air, &exact, &echo, Point2::origin(), place.xy()).snr();
        if ratio > 0.0 {
            let factor = libm::pow(10.0, 0.1 * wanted_db) / ratio;
            p.peak_power_w = (p.peak_power_w * factor).clamp(1e-3, 1e8);
        }
    }
    let buildings = if wall == 0 {
        Vec::new()
    } else {
        // Before, beside or behind the first target; its face towards it.
        let (out, across) = (radial(azimuth).xy(), radial(azimuth + 0.5 * PI).xy());
        let (offset, face) = match wall {
            1 => (-out * wall_off_m, across),
            2 => (across * wall_off_m, out),
            _ => (out * wall_off_m, across),
        };
        let middle = centre.xy() + offset;
        let corner = |a: f64, b: f64| {
            middle + face * (a * 0.5 * wall_long_m) + offset.normalize() * (b * 30.0)
        };
        let footprint_m =
            vec![corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let facade = Material::named(if metal { "metal" } else { "concrete" }).unwrap_or(p.surface);
        let wall = Building { name: "wall".into(), footprint_m, height_m: wall_high_m, facade };
        if wall.contains(Point2::origin()) { Vec::new() } else { vec![wall] }
    };
    Ok(ProofScene {
        name: format!("scene {n} of seed {seed}"),
        parameters: p,
        weather,
        truth: Targets::near(targets),
        buildings: buildings.into(),
        tolerance,
        turns: 1.0,
    })
}

/// Every shape, with the size of a type of it.
const KINDS: [(&str, &str, bool, f64, f64, f64, f64); 10] = [
    ("FOLLOWME", "car", false, 4.8, 2.0, 1.9, 3.0),
    ("FIRE", "truck", false, 12.0, 3.0, 3.7, 10.0),
    ("TUG", "tug", false, 9.0, 4.5, 2.5, 6.0),
    ("C172", "light", true, 8.3, 11.0, 2.7, 2.0),
    ("AT75", "regional_prop", true, 27.2, 27.0, 7.7, 10.0),
    ("CRJ9", "rear_engine", true, 33.5, 23.2, 7.5, 10.0),
    ("A320", "narrow", true, 37.6, 35.8, 11.8, 15.0),
    ("B789", "wide", true, 62.8, 60.1, 17.0, 50.0),
    ("B744", "wide_four", true, 70.7, 64.4, 19.4, 60.0),
    ("A388", "super", true, 72.7, 79.8, 24.1, 80.0),
];

fn class_of(kind: usize, rcs: f64) -> TargetClass {
    let (designator, shape, aircraft, length_m, span_m, height_m, rcs_m2) = KINDS[kind];
    TargetClass {
        designator: designator.into(),
        aircraft,
        length_m,
        span_m,
        height_m,
        rcs_m2: rcs_m2 * rcs,
        shape: scenarios::shapes::named(shape),
    }
}

impl ProofScene {
    /// Its radar, exact.
    pub(crate) fn radar(&self) -> Result<Asde, String> {
        let made = Asde::new(SensorId(1), Point2::origin(), self.parameters.clone());
        Ok(made.map_err(|e| format!("{}: {e}", self.name))?.among(self.buildings.clone()))
    }
}

/// Scenes that were once beyond their tolerance, or nearly: number and seed, the numbers that a search gave
/// where it found them, and what was wrong. One a line: `seed,number,genes or nothing,what`.
///
/// # Errors
/// The line that is none, or a parameter set that is missing.
pub fn named_cases(text: &str) -> Result<Vec<(ProofScene, String)>, String> {
    let mut found = Vec::new();
    for (line, row) in (1..).zip(text.lines()) {
        if row.trim().is_empty() || row.starts_with('#') || row.starts_with("seed,") {
            continue;
        }
        let wrong = || format!("line {line}: '{row}' is not seed,number,genes,what");
        let mut parts = row.splitn(4, ',');
        let mut next = || parts.next().map(str::trim).ok_or_else(wrong);
        let (seed, number, genes, what) = (next()?, next()?, next()?, next()?);
        let whole = |text: &str| text.parse::<u64>().map_err(|_| wrong());
        let genes: Vec<f64> = genes
            .split_whitespace()
            .map(|g| g.parse::<f64>().ok().filter(|g| (0.0..1.0).contains(g)).ok_or_else(wrong))
            .collect::<Result<_, _>>()?;
        let scene = proof_scene(whole(seed)?, whole(number)?, &genes).map_err(|e| e.to_string())?;
        found.push((scene, what.to_owned()));
    }
    Ok(found)
}
