//! The plan is honest: what it skips could not have mattered, on the same draws.

use super::radar::{Processing, RadarEffect, RadarLevels, Tally};
use super::{Ladder, Level, Loss, PlanRow, Rung, Tolerance, changes, choose};
use crate::draw::{DrawKey, Purpose, uniform};
use crate::environment::{RainCell, Weather, surface::Material};
use crate::frames::{Azimuth, Vector2, Vector3};
use crate::plot::{Callsign, SensorId};
use crate::sensors::asde::{Asde, AsdeParameters, Energy};
use crate::sensors::detection::{Swerling, to_db};
use crate::sensors::extended;
use crate::sensors::radar_equation::{BudgetLevels, Echo, Polarisation};
use crate::sensors::shadow::Building;
use crate::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use crate::time::SimTime;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::PI;
use std::sync::Arc;

struct Random {
    targets: Vec<(TargetClass, Vector3<f64>, Vector3<f64>, f64)>,
}

impl Truth for Random {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.targets[index].0
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (_, start, velocity_ms, heading_rad) = &self.targets[index];
        Some(TargetState {
            position_m: start + velocity_ms * time.s(),
            velocity_ms: *velocity_ms,
            heading_rad: *heading_rad,
        })
    }
}

fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[((uniform(rng) * from.len() as f64) as usize).min(from.len() - 1)]
}

struct RandomScene {
    truth: Random,
    weather: Weather,
    parameters: AsdeParameters,
    buildings: Arc<[Building]>,
}

/// Radar, weather, traffic and buildings of scene number `n`.
fn random_scene(n: u64) -> RandomScene {
    let key = DrawKey { run_seed: 4711, sensor: 0, entity: n, scan: 0 };
    let rng = &mut key.rng(Purpose::Study);
    let mut p = AsdeParameters::ku_band();
    if uniform(rng) < 0.5 {
        p.carrier_ghz = 9.0;
        p.azimuth_beamwidth_deg = 0.4;
        p.elevation_beamwidth_deg = 22.0;
        p.tilt_deg = 2.0;
        p.csc2_limit_deg = None;
        p.gain_dbi = 34.0;
        p.peak_power_w = pick(rng, &[3000.0, 25_000.0]);
        p.polarisation = pick(rng, &[Polarisation::Horizontal, Polarisation::Circular]);
    }
    p.antenna_height_m = between(rng, 20.0, 80.0);
    p.tilt_deg += between(rng, -0.4, 0.4);
    p.swerling = pick(rng, &[Swerling::Steady, Swerling::One, Swerling::Three]);
    p.energy = pick(rng, &[Energy::SinglePulse, Energy::Dwell { factor: 1.5 }]);
    p.surface =
        Material::named(pick(rng, &["asphalt", "concrete", "medium_dry_ground"])).expect("known");
    p.roughness_m = pick(rng, &[0.0, 0.003, 0.02, 0.05]);
    p.range_step_m = pick(rng, &[0.0, 0.17, 1.35]);
    p.azimuth_step_deg = pick(rng, &[0.0, 0.0055]);
    p.frequency_agile = uniform(rng) < 0.5;
    let mut weather = Weather {
        rain_mm_per_h: pick(rng, &[0.0, 0.0, 0.5, 4.0, 16.0, 50.0]),
        visibility_m: pick(rng, &[f64::INFINITY, 2000.0, 100.0]),
        film_mm: pick(rng, &[0.0, 0.0, 0.3, 1.0]),
        vapour_g_per_m3: between(rng, 1.0, 18.0),
        ..Weather::default()
    };
    for _ in 0..pick(rng, &[0, 0, 1, 3]) {
        weather.cells.push(RainCell {
            centre_m: Vector2::new(between(rng, -3000.0, 3000.0), between(rng, -3000.0, 3000.0)),
            radius_m: between(rng, 100.0, 1500.0),
            rain_mm_per_h: pick(rng, &[8.0, 30.0]),
        });
    }
    let reach = pick(rng, &[700.0, 1500.0, 3000.0, 5000.0]);
    let only_cars = uniform(rng) < 0.5;
    let count = 3 + (uniform(rng) * 20.0) as usize;
    let mut targets = Vec::new();
    for _ in 0..count {
        let aircraft = !only_cars && uniform(rng) < 0.6;
        let class = TargetClass {
            designator: "X".into(),
            aircraft,
            length_m: if aircraft { between(rng, 8.0, 72.0) } else { between(rng, 3.0, 12.0) },
            span_m: if aircraft { between(rng, 10.0, 70.0) } else { 2.5 },
            height_m: if aircraft { between(rng, 3.0, 20.0) } else { between(rng, 1.5, 4.0) },
            rcs_m2: if aircraft { between(rng, 2.0, 80.0) } else { between(rng, 1.0, 10.0) },
        };
        let (azimuth, distance) = (between(rng, -PI, PI), between(rng, 250.0, reach));
        let (sin, cos) = libm::sincos(azimuth);
        let up = if aircraft && uniform(rng) < 0.1 { between(rng, 5.0, 300.0) } else { 0.0 };
        let start = Vector3::new(distance * sin, distance * cos, up);
        let velocity = Vector3::new(between(rng, -20.0, 20.0), between(rng, -20.0, 20.0), 0.0);
        targets.push((class, start, velocity, between(rng, -PI, PI)));
    }
    let mut buildings = Vec::new();
    for _ in 0..pick(rng, &[0, 0, 2, 4]) {
        let corner = Vector2::new(between(rng, -1500.0, 1500.0), between(rng, -1500.0, 1500.0));
        if corner.norm() < 250.0 {
            continue;
        }
        let (along, across) = (between(rng, 30.0, 150.0), between(rng, 20.0, 60.0));
        buildings.push(Building {
            name: "B".into(),
            footprint_m: [(0.0, 0.0), (along, 0.0), (along, across), (0.0, across)]
                .map(|(x, y)| corner + Vector2::new(x, y))
                .to_vec(),
            height_m: between(rng, 6.0, 30.0),
            facade: Material::named(pick(rng, &["metal", "concrete"])).expect("known"),
        });
    }
    RandomScene { truth: Random { targets }, weather, parameters: p, buildings: buildings.into() }
}

fn interval(scan: u64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64);
    ScanInterval { run_seed: 99, scan, from: time(scan - 1), to: time(scan) }
}

/// What a comparison of two radars on the same scenes found.
#[derive(Debug, Default)]
struct Found {
    both: u64,
    only_one: u64,
    looks: u64,
    worst_m: f64,
    skipped: u64,
    rows: u64,
}

fn compare(scene: &RandomScene, n: u64, scans: u64, tolerance: Tolerance, found: &mut Found) {
    let radar = || {
        Asde::new(SensorId(1), Vector2::zeros(), scene.parameters.clone())
            .expect("sound parameters")
            .among(scene.buildings.clone())
    };
    let mut planned = radar().tolerating(tolerance).processing(Processing::Plot);
    let mut exact = radar().at_levels(RadarLevels::EXACT);
    for scan in 1..=scans {
        let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
        planned.scan(&interval(scan), &scene.truth, &scene.weather, &mut a);
        exact.scan(&interval(scan), &scene.truth, &scene.weather, &mut b);
        found.looks += b.looks;
        let of = |sink: &PlotSink| -> Vec<(u64, SimTime, Vector2<f64>)> {
            let pairs = sink.plots.iter().zip(&sink.causes);
            pairs.filter_map(|(p, c)| Some((c.key?, p.time, p.position_m))).collect()
        };
        let (a, b) = (of(&a), of(&b));
        for (key, time, place) in &a {
            match b.iter().find(|(k, t, _)| k == key && t == time) {
                Some((_, _, exact_place)) => {
                    let apart = (place - exact_place).norm();
                    assert!(
                        apart <= tolerance.position_m + 1e-9,
                        "scene {n} scan {scan} target {key}: {apart} m apart; plan {:#?}",
                        planned.radar_plan().map(|p| (p.total, &p.rows)),
                    );
                    found.worst_m = found.worst_m.max(apart);
                    found.both += 1;
                }
                None => found.only_one += 1,
            }
        }
        found.only_one +=
            b.iter().filter(|(k, t, _)| !a.iter().any(|x| x.0 == *k && x.1 == *t)).count() as u64;
    }
    let plan = planned.radar_plan().expect("planned");
    found.rows += plan.rows.len() as u64;
    found.skipped += plan.rows.iter().filter(|row| row.is_skipped()).count() as u64;
}

#[test]
fn planned_and_exact_runs_agree_within_the_tolerance() {
    for tolerance in [
        Tolerance::default(),
        Tolerance { position_m: 3.0, detection: 0.05, sum_db: None },
        Tolerance { position_m: 0.05, detection: 0.001, sum_db: None },
    ] {
        let mut found = Found::default();
        for n in 0..120 {
            compare(&random_scene(n), n, 4, tolerance, &mut found);
        }
        println!("{tolerance:?}: {found:?}");
        assert!(found.both > 2000 && found.skipped > 100, "{found:?}");
        // Every look may differ with the tolerated probability: a binomial with that as its bound.
        let mean = tolerance.detection * found.looks as f64;
        assert!((found.only_one as f64) <= mean + 4.0 * mean.sqrt() + 1.0, "{found:?}");
    }
}

#[test]
fn a_skipped_effect_is_never_evaluated() {
    let mut skipped = 0;
    for n in 0..100 {
        let scene = random_scene(n);
        // All targets on the surface: what is out of the planned area is simulated exactly.
        let mut scene = scene;
        for target in &mut scene.truth.targets {
            target.1.z = 0.0;
        }
        scene.buildings = Arc::new([]);
        for target in &mut scene.truth.targets {
            target.0.aircraft = false;
        }
        let mut radar = Asde::new(SensorId(1), Vector2::zeros(), scene.parameters.clone())
            .expect("sound parameters")
            .tolerating(Tolerance { position_m: 1.0, detection: 0.02, sum_db: Some(0.5) });
        radar.scan(&interval(1), &scene.truth, &scene.weather, &mut PlotSink::default());
        let plan = radar.radar_plan().expect("planned");
        for (row, &effect) in plan.rows.iter().zip(RadarEffect::ALL) {
            assert_eq!(row.effect, effect.name());
            if row.is_skipped() {
                skipped += 1;
                assert_eq!(radar.tally().of(effect), 0, "scene {n}: {}", effect.name());
            }
        }
    }
    assert!(skipped > 300, "{skipped}");
}

fn plan_of(radar: &mut Asde, truth: &Random, weather: &Weather, scan: u64) -> Vec<PlanRow> {
    radar.scan(&interval(scan), truth, weather, &mut PlotSink::default());
    radar.plan().to_vec()
}

fn level(rows: &[PlanRow], effect: RadarEffect) -> Level {
    rows.iter().find(|row| row.effect == effect.name()).expect("a row").level
}

#[test]
fn a_dry_empty_flat_scene_costs_almost_nothing_and_a_cloud_switches_on_what_it_needs() {
    let class = TargetClass {
        designator: "CAR".into(),
        aircraft: false,
        length_m: 0.6,
        span_m: 0.6,
        height_m: 3.0,
        rcs_m2: 10.0,
    };
    let one =
        Random { targets: vec![(class, Vector3::new(900.0, 300.0, 0.0), Vector3::zeros(), 0.0)] };
    let mut radar = Asde::new(SensorId(1), Vector2::zeros(), AsdeParameters::ku_band())
        .expect("sound parameters");
    let dry = plan_of(&mut radar, &one, &Weather::default(), 1);
    for effect in [
        RadarEffect::RainAttenuation,
        RadarEffect::RainClutter,
        RadarEffect::Fog,
        RadarEffect::WaterFilm,
        RadarEffect::BuildingShadow,
        RadarEffect::AircraftShadow,
        RadarEffect::Ghosts,
        RadarEffect::Merging,
    ] {
        assert_eq!(level(&dry, effect), Level::Skipped, "{}", effect.name());
    }
    let cloud =
        RainCell { centre_m: Vector2::new(900.0, 300.0), radius_m: 400.0, rain_mm_per_h: 100.0 };
    let wet = Weather { cells: vec![cloud], ..Weather::default() };
    let rows = plan_of(&mut radar, &one, &wet, 2);
    let switched: Vec<_> = changes(&dry, &rows)
        .into_iter()
        .filter(|c| c.from == Level::Skipped)
        .map(|c| c.effect)
        .collect();
    assert!(switched.contains(&"rain clutter"), "{switched:?}");
    assert!(!switched.contains(&"fog") && !switched.contains(&"merging"), "{switched:?}");
    let again = plan_of(&mut radar, &one, &Weather::default(), 3);
    assert!(changes(&dry, &again).is_empty());
}

#[test]
fn a_stricter_tolerance_never_skips_more() {
    for n in 0..60 {
        let scene = random_scene(n);
        let radar = Asde::new(SensorId(1), Vector2::zeros(), scene.parameters.clone())
            .expect("sound parameters")
            .among(scene.buildings.clone());
        let air = radar.air(&scene.weather);
        let area = radar.area(&scene.truth, &interval(1));
        let count = |factor: f64| {
            let tolerance = Tolerance::default().times(factor);
            let plan = radar.plan_for(&air, &area, &tolerance);
            plan.rows.iter().map(|r| r.cost_ns).sum::<f64>()
        };
        let (strict, normal, loose) = (count(0.01), count(1.0), count(100.0));
        assert!(
            strict >= normal - 1e-9 && normal >= loose - 1e-9,
            "{n}: {strict} {normal} {loose}"
        );
    }
}

#[test]
fn every_effect_has_its_row_and_every_plan_a_finite_sum() {
    let scenes: Vec<RandomScene> = (0..20).map(random_scene).collect();
    let prepared: Vec<_> = scenes
        .iter()
        .map(|s| {
            let radar = Asde::new(SensorId(1), Vector2::zeros(), s.parameters.clone())
                .expect("sound parameters")
                .among(s.buildings.clone());
            let air = radar.air(&s.weather);
            let area = radar.area(&s.truth, &interval(1));
            (radar, air, area)
        })
        .collect();
    for (radar, air, area) in &prepared {
        let plan = radar.plan_for(air, area, &Tolerance::default());
        assert_eq!(plan.rows.len(), RadarEffect::ALL.len());
        assert!(plan.total.db().is_finite());
    }
}

fn ladder(effect: &'static str, rungs: &[(Level, Loss, f64)]) -> Ladder {
    let rungs = rungs.iter().map(|&(level, loss, cost_ns)| Rung { level, loss, cost_ns }).collect();
    Ladder { effect, called_for: String::new(), rungs }
}

fn simple(effect: &'static str, db: f64) -> Ladder {
    let exact = (Level::Exact, Loss::NONE, 10.0);
    ladder(effect, &[(Level::Skipped, Loss::raises(db), 0.0), exact])
}

#[test]
fn the_sum_counts_and_not_each_bound() {
    let ladders = [simple("a", 0.3), simple("b", 0.3), simple("c", 0.3), simple("d", 0.05)];
    let (chosen, total) = choose(&ladders, &Tolerance::default(), |l| l.raises_db <= 0.7);
    assert_eq!(chosen.iter().filter(|&&r| r == 0).count(), 3);
    assert!((total.raises_db - 0.65).abs() < 1e-12);
    assert_eq!(chosen[3], 0, "the smallest goes first");
}

#[test]
fn what_cannot_be_told_is_simulated() {
    for bound in [f64::NAN, f64::INFINITY] {
        let (chosen, _) = choose(&[simple("a", bound)], &Tolerance::default(), |_| true);
        assert_eq!(chosen, [1], "{bound}");
    }
}

#[test]
fn the_cheapest_level_that_fits_is_taken() {
    let rungs = [
        (Level::Skipped, Loss::raises(5.0), 0.0),
        (Level::Cheap, Loss::either_way(0.4), 2.0),
        (Level::Middle, Loss::either_way(0.1), 8.0),
        (Level::Exact, Loss::NONE, 30.0),
    ];
    for (limit, expected) in [(10.0, 0), (1.0, 1), (0.2, 2), (0.0, 3)] {
        let ladders = [ladder("a", &rungs)];
        let (chosen, _) = choose(&ladders, &Tolerance::default(), |l| l.db() <= limit);
        assert_eq!(chosen, [expected], "limit {limit}");
    }
}

#[test]
fn every_level_has_its_measured_cost() {
    let scene = random_scene(3);
    let radar = Asde::new(SensorId(1), Vector2::zeros(), scene.parameters.clone())
        .expect("sound parameters");
    let air = radar.air(&scene.weather);
    let ladders = radar.ladders_for(&air, &radar.area(&scene.truth, &interval(1)));
    for (ladder, &effect) in ladders.iter().zip(RadarEffect::ALL) {
        assert!(ladder.rungs.last().is_some_and(|r| r.level == Level::Exact), "{}", ladder.effect);
        for rung in &ladder.rungs {
            let row = |row: &&(RadarEffect, Level, u32)| (row.0, row.1) == (effect, rung.level);
            let measured = super::costs::COSTS_NS.iter().filter(row).count();
            let wanted = usize::from(rung.level != Level::Skipped);
            assert_eq!(measured, wanted, "{} {}", ladder.effect, rung.level.name());
            assert_eq!(rung.cost_ns, super::costs::of(effect, rung.level));
        }
    }
    assert!(super::costs::MEASURED.starts_with("20"), "a date");
}

#[test]
fn no_echo_is_weaker_than_the_plan_reckons_with() {
    let (mut tested, mut closest) = (0, f64::INFINITY);
    for n in 0..300 {
        let mut scene = random_scene(n);
        if n % 5 == 0 {
            // Targets above the antenna.
            scene.parameters.antenna_height_m = 6.0;
            scene.parameters.assumed_height_m = 1.5;
        }
        let radar = Asde::new(SensorId(1), Vector2::zeros(), scene.parameters.clone())
            .expect("sound parameters");
        let air = radar.air(&scene.weather);
        let area = radar.area(&scene.truth, &interval(1));
        let planned = radar.radar_scene(&air, &area);
        let budgets = scene.parameters.radar();
        for index in 0..scene.truth.len() {
            let state = scene.truth.at(index, SimTime::from_s(0.7)).expect("there");
            let class = scene.truth.class(index);
            let ground_m = state.position_m.xy().norm();
            let far = ground_m > scene.parameters.range_max_m;
            if state.position_m.z > super::radar::SURFACE_M || far {
                continue;
            }
            let view =
                extended::view_rad(Azimuth::of(state.position_m.xy()).rad(), state.heading_rad);
            let seen = extended::centroid(extended::ExtentLevel::Centroid, class, view);
            let echo = Echo {
                ground_m,
                height_m: state.position_m.z.max(0.5 * class.height_m),
                extent_m: class.height_m,
                rcs_m2: seen.expect("an echo").rcs_m2,
            };
            let (site_m, place_m) = (Vector2::zeros(), state.position_m.xy());
            let levels = BudgetLevels::EXACT;
            let b = budgets.budget(&air, &levels, &echo, site_m, place_m, &mut Tally::default());
            let rain_w = b.rain_w * scene.parameters.rain_correlation();
            let scnr_db = to_db(b.signal_w / (b.noise_w + rain_w + b.ground_w));
            let least_db = super::radar::least_scnr_db(&planned, ground_m);
            assert!(scnr_db >= least_db, "scene {n} target {index}: {scnr_db} below {least_db} dB");
            closest = closest.min(scnr_db - least_db);
            tested += 1;
        }
    }
    println!("{tested} echoes, {closest:.2} dB above the bound at least");
    assert!(tested > 2500 && closest < 6.0);
}
