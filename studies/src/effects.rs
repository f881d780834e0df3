//! The effect plan against everything exact: the same scenes, the same draws, what it loses and saves.

use crate::clock::thread_ns;
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout};
use models::draw::{DrawKey, Purpose, uniform};
use models::effects::positioning::PositioningModel;
use models::effects::radar::{Processing, RadarEffect, RadarLevels, Tally};
use models::effects::{Level, PlanRow, Tolerance};
use models::environment::surface::Material;
use models::environment::{RainCell, Weather};
use models::frames::{Vector2, Vector3};
use models::plot::{Callsign, SensorId};
use models::sensors::asde::{Asde, AsdeParameters};
use models::sensors::shadow::Building;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use rand::rngs::ChaCha8Rng;
use scenarios::ScenarioError;
use scenarios::sensors::asde::shipped;
use std::sync::Arc;

/// One target: class, where at time zero, velocity, heading.
type Target = (TargetClass, Vector3<f64>, Vector3<f64>, f64);

/// Targets that move straight on.
#[derive(Clone, Debug)]
pub struct Straight(Vec<Target>);

impl Truth for Straight {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.0[index].0
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (_, start, velocity_ms, heading_rad) = &self.0[index];
        let position_m = start + velocity_ms * time.s();
        Some(TargetState { position_m, velocity_ms: *velocity_ms, heading_rad: *heading_rad })
    }
}

/// A radar, its weather, traffic and buildings.
#[derive(Clone, Debug)]
pub struct RadarStudy {
    pub(crate) name: String,
    parameters: AsdeParameters,
    pub(crate) weather: Weather,
    pub(crate) truth: Straight,
    buildings: Arc<[Building]>,
}

pub(crate) fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

pub(crate) fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[((uniform(rng) * from.len() as f64) as usize).min(from.len() - 1)]
}

/// Vehicles, or vehicles and aircraft, within `reach_m` of the radar.
fn traffic(rng: &mut ChaCha8Rng, count: usize, aircraft_share: f64, reach_m: f64) -> Straight {
    let target = |rng: &mut ChaCha8Rng| {
        let aircraft = uniform(rng) < aircraft_share;
        let (long, high) = if aircraft { (30.0, 9.0) } else { (5.0, 2.2) };
        let size = between(rng, 0.6, 2.2);
        let class = TargetClass {
            designator: "X".into(),
            aircraft,
            length_m: long * size,
            span_m: if aircraft { 28.0 * size } else { 2.4 },
            height_m: high * between(rng, 0.8, 1.5),
            rcs_m2: if aircraft { 15.0 * size } else { between(rng, 1.0, 10.0) },
        };
        let azimuth = between(rng, -std::f64::consts::PI, std::f64::consts::PI);
        let (sin, cos) = libm::sincos(azimuth);
        let distance = between(rng, 300.0, reach_m);
        let heading = between(rng, -std::f64::consts::PI, std::f64::consts::PI);
        let (hs, hc) = libm::sincos(heading);
        let speed = pick(rng, &[0.0, 8.0, 15.0]);
        let place = Vector3::new(distance * sin, distance * cos, 0.0);
        (class, place, Vector3::new(speed * hs, speed * hc, 0.0), heading)
    };
    Straight((0..count).map(|_| target(rng)).collect())
}

/// A building of metal whose south-west corner is at (`east`, `north`).
pub(crate) fn box_building(
    east: f64,
    north: f64,
    along: f64,
    across: f64,
    height_m: f64,
) -> Building {
    let corner = Vector2::new(east, north);
    Building {
        name: "terminal".into(),
        footprint_m: [(0.0, 0.0), (along, 0.0), (along, across), (0.0, across)]
            .map(|(x, y)| corner + Vector2::new(x, y))
            .to_vec(),
        height_m,
        facade: Material::named("metal").expect("metal is a material"),
    }
}

/// The named scenes: from a dry apron to a storm over aircraft among buildings.
///
/// # Errors
/// If a parameter set that ships is missing.
pub fn named_scenes(seed: u64) -> Result<Vec<RadarStudy>, ScenarioError> {
    let (ku, x) = (shipped("ku_asde3")?, shipped("x_smr25")?);
    let dry = Weather::default();
    let fog = Weather { visibility_m: 100.0, ..dry.clone() };
    let drizzle = Weather { rain_mm_per_h: 1.0, film_mm: 0.1, ..dry.clone() };
    let storm = Weather { rain_mm_per_h: 25.0, film_mm: 1.0, visibility_m: 800.0, ..dry.clone() };
    let cell = |east: f64, north: f64| RainCell {
        centre_m: Vector2::new(east, north),
        radius_m: 700.0,
        rain_mm_per_h: 30.0,
    };
    let cells = Weather { cells: vec![cell(800.0, 900.0), cell(-1500.0, 200.0)], ..dry.clone() };
    let open: Arc<[Building]> = Arc::new([]);
    let built: Arc<[Building]> = Arc::new([
        box_building(400.0, 300.0, 200.0, 60.0, 22.0),
        box_building(-900.0, -700.0, 120.0, 50.0, 18.0),
    ]);
    let mut number = 0;
    let mut scene = |name: &str, p: &AsdeParameters, weather: &Weather, share, reach, buildings| {
        number += 1;
        let key = DrawKey { run_seed: seed, sensor: 1, entity: number, scan: 0 };
        let truth = traffic(&mut key.rng(Purpose::Study), 60, share, reach);
        let (parameters, weather) = (p.clone(), weather.clone());
        RadarStudy { name: name.into(), parameters, weather, truth, buildings }
    };
    Ok(vec![
        scene("dry, vehicles to 1.5 km, 16 GHz", &ku, &dry, 0.0, 1500.0, open.clone()),
        scene("fog, vehicles to 3 km, 16 GHz", &ku, &fog, 0.0, 3000.0, open.clone()),
        scene("drizzle, mixed to 3 km, 16 GHz", &ku, &drizzle, 0.5, 3000.0, open.clone()),
        scene("storm, mixed to 5 km, 16 GHz", &ku, &storm, 0.5, 5000.0, open.clone()),
        scene("storm, mixed to 5 km, 9 GHz", &x, &storm, 0.5, 5000.0, open.clone()),
        scene("rain cells, mixed to 3 km, 16 GHz", &ku, &cells, 0.5, 3000.0, open),
        scene("dry, mixed among buildings, 16 GHz", &ku, &dry, 0.5, 2000.0, built.clone()),
        scene("storm, mixed among buildings, 9 GHz", &x, &storm, 0.5, 3000.0, built),
    ])
}

/// Random scenes: weather, heights, targets, sensors and buildings.
///
/// # Errors
/// If a parameter set that ships is missing.
pub fn random_scenes(seed: u64, count: u64) -> Result<Vec<RadarStudy>, ScenarioError> {
    let sets = [shipped("ku_asde3")?, shipped("x_paper")?, shipped("x_smr25")?];
    let scene = |n: u64| {
        let key = DrawKey { run_seed: seed, sensor: 2, entity: n, scan: 0 };
        let rng = &mut key.rng(Purpose::Study);
        let mut p = sets[(n % 3) as usize].clone();
        p.antenna_height_m = between(rng, 20.0, 80.0);
        p.tilt_deg += between(rng, -0.3, 0.3);
        p.roughness_m = pick(rng, &[0.003, 0.02, 0.05]);
        p.surface = Material::named(pick(rng, &["asphalt", "concrete", "medium_dry_ground"]))
            .unwrap_or(p.surface);
        let mut weather = Weather {
            rain_mm_per_h: pick(rng, &[0.0, 0.0, 1.0, 10.0, 40.0]),
            visibility_m: pick(rng, &[f64::INFINITY, 1000.0, 100.0]),
            film_mm: pick(rng, &[0.0, 0.0, 0.5]),
            vapour_g_per_m3: between(rng, 2.0, 18.0),
            ..Weather::default()
        };
        for _ in 0..pick(rng, &[0, 0, 2]) {
            weather.cells.push(RainCell {
                centre_m: Vector2::new(between(rng, -3e3, 3e3), between(rng, -3e3, 3e3)),
                radius_m: between(rng, 200.0, 1500.0),
                rain_mm_per_h: pick(rng, &[12.0, 50.0]),
            });
        }
        let share = pick(rng, &[0.0, 0.5, 1.0]);
        let reach = pick(rng, &[800.0, 1500.0, 3000.0, 5000.0]);
        let truth = traffic(rng, 25, share, reach);
        let mut buildings = Vec::new();
        for _ in 0..pick(rng, &[0, 0, 3]) {
            let (east, north) = (between(rng, -1500.0, 1500.0), between(rng, -1500.0, 1500.0));
            if libm::hypot(east, north) > 300.0 {
                let (along, across) = (between(rng, 40.0, 150.0), between(rng, 20.0, 60.0));
                buildings.push(box_building(east, north, along, across, between(rng, 6.0, 18.0)));
            }
        }
        let buildings = buildings.into();
        RadarStudy { name: format!("random {n}"), parameters: p, weather, truth, buildings }
    };
    Ok((0..count).map(scene).collect())
}

/// What a comparison found.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Looks at targets within the display range.
    pub looks: u64,
    /// Plots of both runs.
    pub both: u64,
    /// Plots of one run only.
    pub only_one: u64,
    /// Sum of the squares of the distances between plots of the same look, m².
    pub squares_m2: f64,
    /// The largest of these distances, m.
    pub worst_m: f64,
    /// Effects skipped, summed over scenes.
    pub skipped: u64,
    /// Effects at a level below exact but not skipped, summed over scenes.
    pub below: u64,
    /// Evaluations of effects that the plan skips; has to be zero.
    pub evaluated_though_skipped: u64,
    /// Time of the planned scans, ns.
    pub planned_ns: f64,
    /// Time of the exact scans, ns.
    pub exact_ns: f64,
}

impl Comparison {
    fn add(&mut self, other: &Self) {
        self.looks += other.looks;
        self.both += other.both;
        self.only_one += other.only_one;
        self.squares_m2 += other.squares_m2;
        self.worst_m = self.worst_m.max(other.worst_m);
        self.skipped += other.skipped;
        self.below += other.below;
        self.evaluated_though_skipped += other.evaluated_though_skipped;
        self.planned_ns += other.planned_ns;
        self.exact_ns += other.exact_ns;
    }

    fn pair(&mut self, apart_m: f64) {
        self.both += 1;
        self.squares_m2 += apart_m * apart_m;
        self.worst_m = self.worst_m.max(apart_m);
    }

    fn rms_m(&self) -> f64 {
        (self.squares_m2 / self.both.max(1) as f64).sqrt()
    }

    fn per_look(&self, ns: f64) -> Option<f64> {
        (self.looks > 0).then(|| ns / self.looks as f64)
    }

    /// Share of looks that only one run detects, and what is said where these are more than a tolerance
    /// and chance explain.
    fn only_one_share(&self, tolerance: Tolerance) -> (f64, Vec<String>) {
        let mean = tolerance.detection * self.looks as f64;
        let over = self.only_one as f64 > mean + 4.0 * mean.sqrt() + 1.0;
        let failed = over.then(|| format!("{} of {}", self.only_one, self.looks));
        (self.only_one as f64 / self.looks.max(1) as f64, failed.into_iter().collect())
    }
}

impl RadarStudy {
    pub(crate) fn radar(&self) -> Result<Asde, String> {
        let made = Asde::new(SensorId(1), Vector2::zeros(), self.parameters.clone());
        Ok(made.map_err(|e| format!("{}: {e}", self.name))?.among(self.buildings.clone()))
    }

    /// The plan of the scene's first scan.
    ///
    /// # Errors
    /// If the scene's parameters are outside their limits.
    pub fn plan(&self, tolerance: Tolerance) -> Result<Vec<PlanRow>, String> {
        let radar = self.radar()?;
        let air = radar.air(&self.weather);
        let area = radar.area(&self.truth, &interval(1));
        Ok(radar.plan_for(&air, &area, &tolerance).rows)
    }

    /// Evaluations, since `before`, of effects that the plan in force skips.
    fn evaluated_though_skipped(&self, radar: &Asde, before: &Tally) -> u64 {
        // A target in a shadow is simulated exactly whatever the plan skips.
        if !self.buildings.is_empty() || self.truth.0.iter().any(|t| t.0.aircraft) {
            return 0;
        }
        let rows = radar.plan().iter().zip(RadarEffect::ALL);
        let skipped = rows.filter(|(row, _)| row.is_skipped());
        skipped.map(|(_, &effect)| radar.tally().of(effect) - before.of(effect)).sum()
    }

    /// Plays the scene planned and with everything exact, at a level of the signal processing, on the
    /// same draws.
    ///
    /// # Errors
    /// If the scene's parameters are outside their limits.
    pub fn compare(
        &self,
        processing: Processing,
        scans: u64,
        tolerance: Tolerance,
    ) -> Result<Comparison, String> {
        let mut planned = self.radar()?.tolerating(tolerance).processing(processing);
        let mut exact = self.radar()?.at_levels(RadarLevels::EXACT).processing(processing);
        let mut found = Comparison::default();
        for scan in 1..=scans {
            let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
            let interval = interval(scan);
            let before = planned.tally().clone();
            let start = thread_ns();
            planned.scan(&interval, &self.truth, &self.weather, &mut a);
            let between = thread_ns();
            found.evaluated_though_skipped += self.evaluated_though_skipped(&planned, &before);
            exact.scan(&interval, &self.truth, &self.weather, &mut b);
            let planned_ns = (between - start) as f64;
            let exact_ns = (thread_ns() - between) as f64;
            // The first scan makes tables and the plan.
            if scan > 1 {
                found.planned_ns += planned_ns;
                found.exact_ns += exact_ns;
            }
            found.looks += b.looks;
            let (a, b) = (by_look(&a), by_look(&b));
            for (key, place) in &a {
                match b.iter().find(|(other, _)| other == key) {
                    Some((_, exact)) => found.pair((place - exact).norm()),
                    None => found.only_one += 1,
                }
            }
            let missing = b.iter().filter(|(key, _)| !a.iter().any(|(other, _)| other == key));
            found.only_one += missing.count() as u64;
        }
        let rows = || planned.plan().iter();
        found.skipped = rows().filter(|row| row.is_skipped()).count() as u64;
        found.below = rows().filter(|row| row.level < Level::Exact).count() as u64 - found.skipped;
        Ok(found)
    }
}

/// Scenes for the levels that are too expensive for hundreds of them, each with a tolerance at which the
/// plan leaves something out and simulates something: rain, extent, targets close to each other, buildings.
fn cell_scenes(seed: u64) -> Result<Vec<(RadarStudy, Tolerance)>, ScenarioError> {
    let (mut ku, mut x) = (shipped("ku_asde3")?, shipped("x_smr25")?);
    (ku.range_max_m, x.range_max_m) = (1600.0, 1600.0);
    let class = |aircraft: bool, length_m: f64, span_m: f64, height_m: f64, rcs_m2: f64| {
        let designator = "X".into();
        TargetClass { designator, aircraft, length_m, span_m, height_m, rcs_m2 }
    };
    let reflector = class(false, 0.5, 0.5, 2.5, 10.0);
    let car = class(false, 4.8, 2.0, 2.2, 5.0);
    let jet = class(true, 37.6, 35.8, 11.8, 20.0);
    // Every second target 7 m behind the one before it, on a slow way outwards.
    let spread =
        |number: u64, count: u64, near: f64, far: f64, class: &dyn Fn(u64) -> TargetClass| {
            let key = DrawKey { run_seed: seed, sensor: 3, entity: number, scan: 0 };
            let rng = &mut key.rng(Purpose::Study);
            let mut last = (0.0, 0.0);
            let target = |i: u64| {
                last = if i.is_multiple_of(2) {
                    let azimuth = between(rng, -std::f64::consts::PI, std::f64::consts::PI);
                    (azimuth, between(rng, near, far - 60.0))
                } else {
                    (last.0, last.1 + 7.0)
                };
                let (sin, cos) = libm::sincos(last.0);
                let out = Vector3::new(sin, cos, 0.0);
                (class(i), out * last.1, out * 2.0, last.0)
            };
            Straight((0..count).map(target).collect())
        };
    let dry = Weather::default();
    let drizzle = Weather { rain_mm_per_h: 1.0, film_mm: 0.1, visibility_m: 3000.0, ..dry.clone() };
    let rain = Weather { rain_mm_per_h: 10.0, film_mm: 0.5, ..dry.clone() };
    let cloud =
        RainCell { centre_m: Vector2::new(500.0, 500.0), radius_m: 500.0, rain_mm_per_h: 25.0 };
    let cloudy = Weather { cells: vec![cloud], ..dry.clone() };
    let open: Arc<[Building]> = Arc::new([]);
    // A row of buildings all round, and one before some of the targets.
    let beyond: Arc<[Building]> = (0..24)
        .map(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 24.0);
            box_building(1250.0 * sin - 60.0, 1250.0 * cos - 30.0, 120.0, 60.0, 18.0)
        })
        .collect();
    let before: Arc<[Building]> = Arc::new([box_building(200.0, 350.0, 200.0, 60.0, 12.0)]);
    let tolerance = |position_m: f64| Tolerance { position_m, ..Tolerance::default() };
    let scene = |name: &str,
                 p: &AsdeParameters,
                 weather: &Weather,
                 truth,
                 buildings: &Arc<[Building]>| {
        let (parameters, weather) = (p.clone(), weather.clone());
        RadarStudy { name: name.into(), parameters, weather, truth, buildings: buildings.clone() }
    };
    let mixed = |i: u64| if i % 4 < 2 { jet.clone() } else { car.clone() };
    Ok(vec![
        (
            scene(
                "drizzle, reflectors before a ring of buildings, 16 GHz",
                &ku,
                &drizzle,
                spread(1, 40, 300.0, 900.0, &|_| reflector.clone()),
                &beyond,
            ),
            tolerance(1.0),
        ),
        (
            scene(
                "rain, pairs of cars, 16 GHz",
                &ku,
                &rain,
                spread(2, 40, 300.0, 1400.0, &|_| car.clone()),
                &open,
            ),
            tolerance(4.0),
        ),
        (
            scene(
                "cloud over cars before a ring of buildings, 9 GHz",
                &x,
                &cloudy,
                spread(3, 40, 300.0, 900.0, &|_| car.clone()),
                &beyond,
            ),
            tolerance(4.0),
        ),
        (
            scene(
                "rain, aircraft and cars behind a building, 16 GHz",
                &ku,
                &rain,
                spread(4, 40, 300.0, 1400.0, &mixed),
                &before,
            ),
            tolerance(1.0),
        ),
    ])
}

type Look = ((u64, SimTime), Vector2<f64>);

fn by_look(sink: &PlotSink) -> Vec<Look> {
    let pairs = sink.plots.iter().zip(&sink.causes);
    pairs.filter_map(|(plot, cause)| Some(((cause.key?, plot.time), plot.position_m))).collect()
}

pub(crate) fn interval(scan: u64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64);
    ScanInterval { run_seed: 1, scan, from: time(scan - 1), to: time(scan) }
}

/// The group `effects`: named scenes one by one, random scenes together, each against everything exact.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let mut rows = Vec::new();
    if let Err(error) = measure(options.quick, options.seed, &mut rows, progress) {
        rows.push(Row {
            group: "effects".into(),
            failed: vec![error.to_string()],
            ..Row::default()
        });
    }
    let mut scenes: Vec<SceneAbout> = Vec::new();
    for row in &rows {
        if !scenes.iter().any(|s| s.name == row.scene) {
            let about = "planned against everything exact, on the same draws".into();
            scenes.push(SceneAbout { name: row.scene.clone(), about });
        }
    }
    let ladder = Ladder {
        group: "effects".into(),
        title: "Which effects a scene calls for".into(),
        about:
            "A sensor played twice on the same draws: planned for the tolerance named in the rung, \
                and with every effect at its most exact level: surface movement radars, then every \
                model of the sensors that targets carry. The error is the largest distance between \
                two plots of the same look; the time is per look."
                .into(),
        error_label: "largest difference of a plot, m".into(),
        draws: Draws::Other,
        scenes,
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

fn measure(
    quick: bool,
    seed: u64,
    out: &mut Vec<Row>,
    progress: &mut dyn FnMut(Progress),
) -> Result<(), ScenarioError> {
    let (scans, count) = if quick { (6, 60) } else { (30, 400) };
    let tolerance = Tolerance::default();
    let named = named_scenes(seed)?;
    let cells = cell_scenes(seed)?;
    let models = PositioningModel::ALL.len();
    let total = named.len() + 3 + models + cells.len();
    let mut done = 0;
    let mut step = |what: &str| {
        done += 1;
        progress(Progress { group: "effects", what: what.into(), done, total });
    };
    for scene in named {
        report(&scene.name, scene.compare(Processing::Plot, scans, tolerance), tolerance, out);
        step(&scene.name);
    }
    for tolerance in [tolerance, tolerance.times(0.1), tolerance.times(6.0)] {
        let mut sum = Ok(Comparison::default());
        for scene in random_scenes(seed, count)? {
            sum = match (sum, scene.compare(Processing::Plot, 4, tolerance)) {
                (Ok(mut sum), Ok(one)) => {
                    sum.add(&one);
                    Ok(sum)
                }
                (Err(e), _) | (_, Err(e)) => Err(e),
            };
        }
        let name = format!("{count} random scenes, {} m", tolerance.position_m);
        report(&name, sum, tolerance, out);
        step(&name);
    }
    let count = if quick { 60 } else { 400 };
    crate::effects_positioning::measure(count, seed, tolerance, out, &mut step);
    // A handful of scenes at the levels that are too expensive for hundreds.
    for (scene, tolerance) in cells {
        for (how, processing, scans) in [
            ("windows of cells", Processing::Cells, if quick { 20 } else { 100 }),
            ("video", Processing::Video, if quick { 3 } else { 12 }),
        ] {
            let found = scene.compare(processing, scans, tolerance);
            report_cells(&scene.name, how, found, tolerance, out);
        }
        step(&scene.name);
    }
    Ok(())
}

/// A row of this group.
pub(crate) fn row(scene: &str, rung: String) -> Row {
    Row { group: "effects".into(), scene: scene.into(), rung, ..Row::default() }
}

/// The row that the planned ones are measured against; the plan takes `share` of its time.
pub(crate) fn exact_row(scene: &str, ns_per_look: Option<f64>, share: f64) -> Row {
    let saved = 100.0 * (1.0 - share);
    let rung = format!("everything exact (the plan saves {saved:.0} % of its time)");
    Row { error: Some(0.0), ns_per_update: ns_per_look, ..row(scene, rung) }
}

fn report(
    scene: &str,
    found: Result<Comparison, String>,
    tolerance: Tolerance,
    out: &mut Vec<Row>,
) {
    let rung = format!("planned, {} m, {}", tolerance.position_m, tolerance.detection);
    let row = |what: &str| row(scene, format!("{rung}: {what}"));
    let found = match found {
        Ok(found) => found,
        Err(reason) => {
            out.push(Row { failed: vec![reason], ..row("failed") });
            return;
        }
    };
    let mut failed = Vec::new();
    if found.worst_m > tolerance.position_m || found.both == 0 {
        failed.push(format!("{} m apart, {} plots", found.worst_m, found.both));
    }
    if found.evaluated_though_skipped > 0 {
        failed.push(format!("{} evaluations of skipped effects", found.evaluated_though_skipped));
    }
    out.push(Row {
        error: Some(found.worst_m),
        error_unit: Some(LARGEST.into()),
        ns_per_update: found.per_look(found.planned_ns),
        failed,
        ..row("position")
    });
    let (share, failed) = found.only_one_share(tolerance);
    out.push(Row {
        error: Some(share),
        error_unit: Some(ONLY_ONE.into()),
        failed,
        ..row("detection")
    });
    out.push(Row {
        error_unit: Some(LARGEST.into()),
        ..exact_row(
            scene,
            found.per_look(found.exact_ns),
            found.planned_ns / found.exact_ns.max(1.0),
        )
    });
}

/// Rows of a comparison in cells: the largest difference of a plot, and the share of plots of one run only.
fn report_cells(
    scene: &str,
    how: &str,
    found: Result<Comparison, String>,
    tolerance: Tolerance,
    out: &mut Vec<Row>,
) {
    let row =
        |what: &str| row(scene, format!("{how}, planned, {} m: {what}", tolerance.position_m));
    let found = match found {
        Ok(found) => found,
        Err(reason) => {
            out.push(Row { failed: vec![reason], ..row("failed") });
            return;
        }
    };
    let mut failed = Vec::new();
    if found.worst_m > tolerance.position_m || found.both == 0 {
        failed.push(format!("{} m apart, {} plots", found.worst_m, found.both));
    }
    if found.skipped == 0 {
        failed.push("nothing skipped".into());
    }
    let (skipped, below, rms_m) = (found.skipped, found.below, found.rms_m());
    out.push(Row {
        error: Some(found.worst_m),
        error_unit: Some(LARGEST.into()),
        ns_per_update: found.per_look(found.planned_ns),
        failed,
        ..row(&format!(
            "position ({skipped} effects skipped, {below} below exact; {rms_m:.3} m rms)"
        ))
    });
    let (share, failed) = found.only_one_share(tolerance);
    let saved = 100.0 * (1.0 - found.planned_ns / found.exact_ns.max(1.0));
    out.push(Row {
        error: Some(share),
        error_unit: Some(ONLY_ONE.into()),
        ns_per_update: found.per_look(found.exact_ns),
        failed,
        ..row(&format!("detection (the plan saves {saved:.0} % of the time of everything exact)"))
    });
}

const LARGEST: &str = "m, largest difference of a plot";
const ONLY_ONE: &str = "share of looks that only one run detects";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_report_has_no_failures() {
        let mut rows = Vec::new();
        measure(true, 3, &mut rows, &mut |_| ()).expect("sets ship");
        assert!(rows.len() >= 30);
        for row in &rows {
            println!(
                "{} | {} | {:?} {} | {:?} ns",
                row.scene,
                row.rung,
                row.error,
                row.error_unit.as_deref().unwrap_or(""),
                row.ns_per_update
            );
            assert!(row.failed.is_empty(), "{row:?}");
        }
    }
}
