//! The effect plan against everything exact: the same scenes, the same draws, what it loses and saves.

use crate::effects_common::{between, box_building, pick, row};
use crate::effects_proof::{ProofScene, SceneResult, Search, Targets, proof_scene};
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout};
use models::draw::{DrawKey, Purpose, uniform};
use models::effects::{Level, Tolerance};
use models::environment::{RainCell, Weather};
use models::frames::{Point2, Point3, Vector3};
use models::plot::SensorId;
use models::sensors::asde::{Asde, AsdeParameters};
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::levels::RadarLevels;
use models::sensors::radar::shadow::Building;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, Truth};
use models::time::SimTime;
use rand::rngs::ChaCha8Rng;
use scenarios::ScenarioError;
use scenarios::sensors::asde::shipped;
use std::sync::Arc;

/// A radar, its weather, traffic and buildings.
#[derive(Clone, Debug)]
pub struct RadarStudy {
    pub(crate) name: String,
    parameters: AsdeParameters,
    pub(crate) weather: Weather,
    pub(crate) truth: Targets,
    buildings: Arc<[Building]>,
}

/// Vehicles, or vehicles and aircraft, within `reach_m` of the radar.
fn traffic(rng: &mut ChaCha8Rng, count: usize, aircraft_share: f64, reach_m: f64) -> Targets {
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
            shape: scenarios::shapes::named(if aircraft { "narrow" } else { "car" }),
        };
        let azimuth = between(rng, -std::f64::consts::PI, std::f64::consts::PI);
        let (sin, cos) = libm::sincos(azimuth);
        let distance = between(rng, 300.0, reach_m);
        let heading = between(rng, -std::f64::consts::PI, std::f64::consts::PI);
        let (hs, hc) = libm::sincos(heading);
        let speed = pick(rng, &[0.0, 8.0, 15.0]);
        let place = Point3::new(distance * sin, distance * cos, 0.0);
        (class, place, Vector3::new(speed * hs, speed * hc, 0.0), heading)
    };
    Targets { list: (0..count).map(|_| target(rng)).collect(), back_s: None }
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
        centre_m: Point2::new(east, north),
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

impl RadarStudy {
    pub(crate) fn radar(&self) -> Result<Asde, String> {
        let made = Asde::new(SensorId(1), Point2::origin(), self.parameters.clone());
        Ok(made.map_err(|e| format!("{}: {e}", self.name))?.among(self.buildings.clone()))
    }

    /// The scene with its targets near where they are, for the comparison target by target.
    #[must_use]
    pub fn standing(&self) -> ProofScene {
        ProofScene {
            name: self.name.clone(),
            parameters: self.parameters.clone(),
            weather: self.weather.clone(),
            truth: Targets::near(self.truth.list.clone()),
            buildings: self.buildings.clone(),
            tolerance: Tolerance::default(),
            turns: 1.0,
        }
    }
}

pub(crate) fn interval(scan: u64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64);
    ScanInterval { run_seed: 1, scan, from: time(scan - 1), to: time(scan) }
}

/// The group `effects`: named scenes one by one, random scenes together, each against everything exact.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let mut rows = Vec::new();
    if let Err(error) = measure(options, &mut rows, progress) {
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
            "A sensor played twice on the same draws: planned for its tolerance, and with every effect \
                at its most exact level: surface movement radars, then every model of the sensors that \
                targets carry. For radars the number is the largest share of a tolerance that any target \
                takes, and the time a sum of the table of costs, per target."
                .into(),
        error_label: "largest difference of a plot, m".into(),
        draws: Draws::Other,
        scenes,
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

fn measure(
    options: &Options,
    out: &mut Vec<Row>,
    progress: &mut dyn FnMut(Progress),
) -> Result<(), ScenarioError> {
    let (scans, count) = if options.quick { (200, 20) } else { (400, 400) };
    let count = options.scenes.unwrap_or(count);
    let named = named_scenes(options.seed)?;
    let models = models::sensors::models().count();
    let total = named.len() + 1 + models + usize::from(count >= LONG);
    let mut done = 0;
    let mut step = |what: &str| {
        done += 1;
        progress(Progress { group: "effects", what: what.into(), done, total });
    };
    for scene in named {
        report(&scene.standing(), options.seed, scans, out);
        step(&scene.name);
    }
    prove(options.seed, count, scans, out, &mut step)?;
    if count >= LONG {
        search(options.seed, (count / 2500).clamp(2, 20), out, &mut step)?;
    }
    let count = if options.quick { 60 } else { 400 };
    let tolerance = Tolerance::default();
    crate::effects_positioning::measure(count, options.seed, tolerance, out, &mut step);
    Ok(())
}

/// Scenes of the whole space, each judged by itself: a row for all, and one for each that fails.
fn prove(
    seed: u64,
    count: u64,
    scans: u64,
    out: &mut Vec<Row>,
    step: &mut dyn FnMut(&str),
) -> Result<(), ScenarioError> {
    let name = format!("{count} scenes of the whole space, {scans} scans each");
    let mut found = Proof::default();
    for n in 0..count {
        let scene = proof_scene(seed, n, &[])?;
        found.add(&scene, scene.judge(seed + n, scans, &|radar| radar));
        if n % 1000 == 999 {
            step(&format!("{} scenes, {} beyond", n + 1, found.violations.len()));
        }
    }
    let saved = 100.0 * (1.0 - found.cost_ns.2 / found.cost_ns.1.max(1.0));
    for (what, largest) in ["rms shift", "detection", "false plots"].iter().zip(found.largest) {
        let failed = if *what == "rms shift" { found.violations.clone() } else { Vec::new() };
        out.push(Row {
            error: Some(largest),
            error_unit: Some(SHARE.into()),
            failed,
            ..row(&name, format!("{what}, {} targets ({saved:.0} % left out)", found.targets))
        });
    }
    step(&name);
    Ok(())
}

/// So many random scenes and more: a search for the worst one is part of the proof.
const LONG: u64 = 1000;

/// A search for the worst scene: a row for each restart. What is beyond the tolerance goes, with its numbers,
/// into `tests/data/effects-cases.csv`, which the tests play again.
fn search(
    seed: u64,
    restarts: u64,
    out: &mut Vec<Row>,
    step: &mut dyn FnMut(&str),
) -> Result<(), ScenarioError> {
    const GENERATIONS: u64 = 60;
    let name = format!("search for the worst scene, {restarts} restarts");
    let search = Search { seed, generations: GENERATIONS, scans: 100 };
    for restart in 0..restarts {
        let worst = search.restart(restart, &mut |_, _| ())?;
        let genes: Vec<String> = worst.genes.iter().map(|g| format!("{g:.6}")).collect();
        let line = |v: &String| format!("{v}; genes {}", genes.join(" "));
        out.push(Row {
            error: Some(worst.ratio),
            error_unit: Some(SHARE.into()),
            failed: worst.violations.iter().map(line).collect(),
            ..row(&name, worst.scene.name.clone())
        });
        step(&format!("{name}: {} of them, the last at {:.2}", restart + 1, worst.ratio));
    }
    Ok(())
}

fn report(scene: &ProofScene, seed: u64, scans: u64, out: &mut Vec<Row>) {
    let mut found = Proof::default();
    found.add(scene, scene.judge(seed, scans, &|radar| radar));
    let (all, there, planned) = found.cost_ns;
    for (what, largest) in ["rms shift", "detection", "false plots"].iter().zip(found.largest) {
        let failed = if *what == "rms shift" { found.violations.clone() } else { Vec::new() };
        out.push(Row {
            error: Some(largest),
            error_unit: Some(SHARE.into()),
            ns_per_update: Some(planned),
            failed,
            ..row(&scene.name, format!("planned: {what}"))
        });
    }
    let saved = 100.0 * (1.0 - planned / there.max(1.0));
    let rung =
        format!("everything exact ({saved:.0} % of what is there beyond tables is left out)");
    out.push(Row {
        error: Some(0.0),
        error_unit: Some(SHARE.into()),
        ns_per_update: Some(all),
        ..row(&scene.name, rung)
    });
    match Measured::of(scene) {
        Ok(measured) => {
            for (what, ns) in [
                ("measured: planned", measured.planned),
                ("measured: everything exact, with tables", measured.tables),
                ("measured: nothing but plots", measured.bare),
            ] {
                out.push(Row { ns_per_update: Some(ns), ..row(&scene.name, what.into()) });
            }
        }
        Err(error) => out.push(Row { failed: vec![error], ..row(&scene.name, "measured".into()) }),
    }
}

/// Processor time of scans, ns a target, the least of several rounds. What the plan saves of what is there is (tables − planned) of
/// (tables − bare).
#[derive(Clone, Copy, Debug)]
struct Measured {
    /// Everything exact but for what comes from tables: detection, and the centre of the echo by aspect.
    tables: f64,
    /// As planned.
    planned: f64,
    /// Nothing simulated but where targets are, and plots of them.
    bare: f64,
}

impl Measured {
    /// Plays a scene three ways, round by round, so that all have the same neighbours on the machine.
    fn of(scene: &ProofScene) -> Result<Self, String> {
        const ROUNDS: u64 = 12;
        const SCANS: u64 = 20;
        let tabled = [RadarEffect::Detection, RadarEffect::Extent];
        let table = |levels: RadarLevels, effect| levels.with(effect, Level::Middle);
        let exact = tabled.into_iter().fold(RadarLevels::EXACT, table);
        let kept = |effect: &RadarEffect| {
            matches!(effect, RadarEffect::Detection | RadarEffect::Processing)
        };
        let skipped = RadarEffect::ALL.iter().filter(|e| !kept(e));
        let nothing = skipped.fold(exact, |levels, effect| levels.with(*effect, Level::Skipped));
        let mut radars = [
            scene.radar()?.at_levels(exact),
            scene.radar()?.tolerating(scene.tolerance),
            scene.radar()?.at_levels(nothing),
        ];
        let mut least = [f64::INFINITY; 3];
        let mut out = PlotSink::default();
        for round in 0..ROUNDS {
            for (radar, least) in radars.iter_mut().zip(&mut least) {
                for scan in 1..=SCANS {
                    out.plots.clear();
                    out.causes.clear();
                    let interval = interval(round * SCANS + scan);
                    let start = crate::clock::thread_ns();
                    radar.scan(&interval, &scene.truth, &scene.weather, &mut out);
                    let ns = (crate::clock::thread_ns() - start) as f64;
                    // In the first round boxes are planned.
                    if round > 0 {
                        *least = least.min(ns);
                    }
                }
            }
        }
        let [tables, planned, bare] = least.map(|ns| ns / scene.truth.len().max(1) as f64);
        Ok(Self { tables, planned, bare })
    }
}

const SHARE: &str = "of what is tolerated, the worst target";

/// What a number of scenes showed.
#[derive(Debug, Default)]
struct Proof {
    targets: usize,
    violations: Vec<String>,
    largest: [f64; 3],
    cost_ns: (f64, f64, f64),
}

impl Proof {
    fn add(&mut self, scene: &ProofScene, judged: Result<(SceneResult, Vec<String>), String>) {
        match judged {
            Err(error) => self.violations.push(error),
            Ok((result, violations)) => {
                self.targets += result.targets.len();
                self.violations.extend(violations);
                let largest = result.largest(&scene.tolerance);
                for (most, one) in self.largest.iter_mut().zip(largest) {
                    *most = most.max(one);
                }
                let (a, b, c) = result.cost_ns;
                let sum = self.cost_ns;
                self.cost_ns = (sum.0 + a, sum.1 + b, sum.2 + c);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_report_has_no_failures() {
        let mut rows = Vec::new();
        let options = Options { quick: true, seed: 3, scenes: Some(4), ..Options::default() };
        measure(&options, &mut rows, &mut |_| ()).expect("sets ship");
        assert!(rows.len() >= 30);
        for row in &rows {
            let unit = row.error_unit.as_deref().unwrap_or("");
            println!(
                "{} | {} | {:?} {unit} | {:?} ns",
                row.scene, row.rung, row.error, row.ns_per_update
            );
            assert!(row.failed.is_empty(), "{row:?}");
        }
    }

    #[test]
    fn plans_leave_out_a_good_part_of_what_is_there() {
        // Shares by the table of costs: dry, fog, drizzle, two storms, cells, buildings dry and in a storm.
        let least = [0.58, 0.52, 0.58, 0.33, 0.33, 0.39, 0.56, 0.42];
        for seed in [11, 12, 13] {
            for (scene, least) in named_scenes(seed).expect("sets ship").iter().zip(least) {
                let played = scene.standing().play(seed, 30).expect("a sound scene");
                let (_, there, planned) = played.cost_ns;
                let share = 1.0 - planned / there;
                println!("{} {seed}: {:.1} %", scene.name, 100.0 * share);
                assert!(share >= least, "{} {seed}: {share}", scene.name);
            }
        }
    }

    #[test]
    fn no_target_of_a_hundred_scenes_is_beyond_the_tolerance() {
        let mut rows = Vec::new();
        prove(1, 100, 200, &mut rows, &mut |_| ()).expect("sets ship");
        for row in &rows {
            println!("{} | {} | {:?}", row.scene, row.rung, row.error);
        }
        assert!(rows[0].failed.is_empty(), "{:#?}", rows[0].failed);
        assert!(rows[0].error.is_some_and(|e| e > 0.3), "the tolerance is used");
    }
}
