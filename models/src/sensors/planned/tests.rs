//! What is planned of the sensors other than radars, sensor by sensor. Random scenes are played in
//! `studies`, planned against everything exact.

use super::Planned;
use crate::effects::positioning::{MEASURED, Model, PositioningEffect as E, PositioningLevels};
use crate::effects::{Level, PlanRow, Tolerance};
use crate::environment::Weather;
use crate::frames::Point2;
use crate::frames::Vector3;
use crate::plot::SensorId;
use crate::sensors::adsb::{self, Adsb, AdsbConfig};
use crate::sensors::dgps::{self, Budgeted, Dgps, DgpsConfig, DgpsModel};
use crate::sensors::dynamic::{Dynamic, DynamicConfig};
use crate::sensors::gps::{self, Gps, GpsConfig, GpsModel, Statistical};
use crate::sensors::induction_loop::{self, InductionLoop, LoopConfig};
use crate::sensors::mlat::{self, Mlat, MlatConfig};
use crate::sensors::reporting::constellation::SatelliteFailures;
use crate::sensors::reporting::cooperative::{Equipage, Equipped};
use crate::sensors::reporting::ranging::{RangeCorrections, RangingConfig};
use crate::sensors::reporting::service::{Alternating, Service};
use crate::sensors::testing::Parked;
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::sensors::{model_named, models};
use crate::time::SimTime;

const ID: SensorId = SensorId(3);

/// How the effects of a sensor are chosen.
#[derive(Clone, Copy)]
enum Mode {
    Planned(Tolerance, f64),
    Fixed(PositioningLevels),
}

fn ranges(corrections: Option<RangeCorrections>) -> RangingConfig {
    RangingConfig::example(corrections)
}

fn sensor(model: &Model, mode: Mode) -> Box<dyn Sensor> {
    let found = model_named(model.name).expect("declared");
    let mut sensor: Box<dyn Planned> = match model {
        // In the way of the first target, and in the open.
        m if *m == induction_loop::MODEL => {
            let config = LoopConfig::pair_at(ID, Point2::new(60.0, 100.0), 90.0);
            Box::new(InductionLoop::new(config).expect("sound"))
        }
        m if *m == mlat::MODEL => {
            let places = [
                (0.0, -3000.0),
                (4000.0, 0.0),
                (4000.0, 2500.0),
                (-3000.0, 2500.0),
                (2000.0, -500.0),
            ];
            let places = places.map(|(x, y)| Point2::new(x, y));
            Box::new(Mlat::new(MlatConfig::with_stations(ID, &places)).expect("sound"))
        }
        _ => (found.example)(ID).expect("sound"),
    };
    match mode {
        Mode::Planned(tolerance, run_s) => sensor.planning_mut().tolerate(tolerance, run_s),
        Mode::Fixed(levels) => sensor.planning_mut().fix(levels),
    }
    sensor
}

fn rolling(keys: &[u64], speed_mps: f64) -> Parked {
    let mut targets = Parked::aircraft(keys);
    targets.velocity_mps = Vector3::new(speed_mps, 0.0, 0.0);
    targets
}

fn play(sensor: &mut dyn Sensor, truth: &dyn Truth, scans: std::ops::Range<u64>) -> PlotSink {
    let mut sink = PlotSink { explain: true, ..PlotSink::default() };
    for scan in scans {
        let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
        let interval = ScanInterval { run_seed: 8, scan, from: at(scan - 1), to: at(scan) };
        sensor.scan(&interval, truth, &Weather::default(), &mut sink);
    }
    sink
}

fn level(rows: &[PlanRow], effect: E) -> Level {
    rows.iter().find(|row| row.effect == effect.name()).expect("a row").level
}

fn skipped(sensor: &dyn Sensor) -> usize {
    sensor.plan().iter().filter(|row| row.is_skipped()).count()
}

#[test]
fn skipped_effects_are_never_evaluated_and_the_others_are() {
    let (mut left_out, mut simulated) = (0, 0);
    for model in models().map(|m| m.model) {
        for factor in [0.0, 1.0, 10.0, 1e3] {
            let mode = Mode::Planned(Tolerance::default().times(factor), 20.0);
            let mut sensor = sensor(model, mode);
            play(sensor.as_mut(), &rolling(&[1, 2, 3], 8.0), 1..21);
            let evaluations = sensor.evaluations();
            assert_eq!(evaluations.len(), sensor.plan().len(), "{model}");
            for (row, (effect, times)) in sensor.plan().iter().zip(evaluations) {
                assert_eq!(row.effect, effect);
                let fixed = row.effect == E::Geometry.name() && row.level == Level::Cheap;
                if row.is_skipped() {
                    left_out += 1;
                    assert_eq!(times, 0, "{model} {effect} at {factor}");
                } else if !fixed {
                    simulated += 1;
                    assert!(times > 0, "{model} {effect} at {factor}");
                }
            }
        }
    }
    assert!(left_out > 40 && simulated > 60, "{left_out} {simulated}");
}

#[test]
fn nothing_is_simulated_for_nobody_and_a_target_switches_it_on() {
    let who = Equipped::Share(0.0);
    let nobody = Equipage { who, ..Equipage::all() };
    let config = GpsConfig {
        equipped: nobody,
        ..GpsConfig::of(ID, GpsModel::Statistical(Statistical::sps_2020()))
    };
    let mut gps = Gps::new(config).expect("sound").tolerating(Tolerance::default(), 600.0);
    play(&mut gps, &rolling(&[1, 2], 5.0), 1..4);
    assert!(gps.plan().iter().all(|row| row.is_skipped() && row.bound == 0.0));
    assert!(gps.plan().iter().all(|row| row.called_for == "no equipped target"));
    assert!(gps.evaluations().iter().all(|e| e.1 == 0));
    let mode = Mode::Planned(Tolerance::default(), 600.0);
    let mut gps = sensor(&gps::STATISTICAL, mode);
    play(gps.as_mut(), &rolling(&[], 5.0), 1..3);
    assert_eq!(skipped(gps.as_ref()), gps.plan().len());
    let found = play(gps.as_mut(), &rolling(&[1], 5.0), 3..4);
    assert_eq!(level(gps.plan(), E::Correlation), Level::Exact);
    let mut exact = sensor(&gps::STATISTICAL, Mode::Fixed(PositioningLevels::EXACT));
    let same = play(exact.as_mut(), &rolling(&[1], 5.0), 3..4);
    assert_eq!(found.plots, same.plots, "it begins as if it had been there from the first");
}

#[test]
fn an_outage_is_simulated_where_the_run_can_meet_it() {
    let level_of = |share: f64, horizon_s: f64| {
        let process = Alternating::from_share(share, 600.0);
        let service = Service { coverage: process, ..Service::PERFECT };
        let model = Statistical { service, ..Statistical::sps_2020() };
        let config = GpsConfig::of(ID, GpsModel::Statistical(model));
        let mut gps = Gps::new(config).expect("sound").tolerating(Tolerance::default(), horizon_s);
        play(&mut gps, &rolling(&[1], 5.0), 1..2);
        (level(gps.plan(), E::HardFailures), level(gps.plan(), E::SoftFailures))
    };
    let (skip, on) = (Level::Skipped, Level::Exact);
    for (share, horizon_s, expected) in [
        (0.999, 600.0, skip),
        (0.9, 600.0, on),
        (0.999, 36_000.0, on),
        (1.0, f64::INFINITY, skip),
        (0.999_999, f64::INFINITY, on),
    ] {
        assert_eq!(level_of(share, horizon_s), (expected, skip), "{share} over {horizon_s} s");
    }
    let station = |mtbf_s: f64| {
        let reference = Alternating::from_mtbf(mtbf_s, 60.0);
        let config = DgpsConfig { reference, ..DgpsConfig::on_airport(ID, Point2::origin()) };
        let mut dgps = Dgps::new(config).expect("sound").tolerating(Tolerance::default(), 600.0);
        play(&mut dgps, &rolling(&[1], 5.0), 1..2);
        level(dgps.plan(), E::ReferenceOutage)
    };
    assert_eq!((station(3.6e6), station(7200.0)), (skip, on), "MTBF of 1000 h and of 2 h");
    let mut never = ranges(None);
    never.sky.failures = SatelliteFailures::never();
    for (ranges, expected) in [(never, skip), (ranges(None), on)] {
        let config = GpsConfig::of(ID, GpsModel::PerSatellite(ranges));
        let gps = Gps::new(config).expect("sound");
        let mut gps = gps.tolerating(Tolerance::default(), f64::INFINITY);
        play(&mut gps, &rolling(&[1], 5.0), 1..2);
        assert_eq!(level(gps.plan(), E::HardFailures), expected);
        assert_eq!(level(gps.plan(), E::SoftFailures), expected);
    }
}

#[test]
fn distance_speed_and_age_call_for_what_they_need() {
    let plan = |budget: fn(&mut Budgeted), metres: f64, speed_mps: f64| {
        let mut model = Budgeted::on_airport();
        budget(&mut model);
        let reference_m = Point2::new(-metres, 100.0);
        let config = DgpsConfig {
            model: DgpsModel::Budget(model),
            ..DgpsConfig::on_airport(ID, reference_m)
        };
        let mut dgps = Dgps::new(config).expect("sound").tolerating(Tolerance::default(), 60.0);
        play(&mut dgps, &rolling(&[1], speed_mps), 1..3);
        let rows = dgps.plan();
        (level(rows, E::CorrectionDistance), level(rows, E::CorrectionAge))
    };
    let (skip, on) = (Level::Skipped, Level::Exact);
    assert_eq!(plan(|_| (), 2000.0, 8.0), (skip, skip), "on the airport, in a quiet ionosphere");
    assert_eq!(plan(|_| (), 60_000.0, 8.0), (on, skip), "sixty kilometres off");
    let storm = |m: &mut Budgeted| m.budget.iono_gradient = 3e-4;
    assert_eq!(plan(storm, 2000.0, 8.0), (on, skip), "an ionospheric storm");
    let selective = |m: &mut Budgeted| {
        m.budget.correction_acceleration_ms2 = 0.019;
        m.correction_s = 10.0;
    };
    assert_eq!(plan(selective, 2000.0, 8.0), (skip, on), "old corrections of a wandering clock");

    let latency = |tolerance: f64, speed_mps: f64| {
        let tolerance = Tolerance { position_m: tolerance, ..Tolerance::default() };
        let mut adsb = sensor(&adsb::MODEL, Mode::Planned(tolerance, 60.0));
        play(adsb.as_mut(), &rolling(&[1, 2], speed_mps), 1..12);
        level(adsb.plan(), E::Latency)
    };
    assert_eq!(latency(0.5, 0.0), skip, "who stands does not lag");
    assert_eq!(latency(0.5, 8.0), on);
    // 10 m/s after rounding: 2.5 m by the mean delay, 6 m without; 0.9 m for the format, 1.8 m of a step.
    // The mean delay would be tolerated at 5.5 m and none at 9 m, but neither costs less than the drawn one.
    assert_eq!(latency(5.5, 8.0), on);
    assert_eq!(latency(9.0, 8.0), on);
}

#[test]
fn a_faster_target_is_exact_at_once_and_planned_for_in_the_next_scan() {
    let tolerance = Tolerance { position_m: 3.0, ..Tolerance::default() };
    let config = AdsbConfig { reception: 1.0, ..AdsbConfig::surface(ID, 47.45) };
    let mut adsb = Adsb::new(config).expect("sound").tolerating(tolerance, 60.0);
    play(&mut adsb, &rolling(&[1], 0.0), 1..8);
    assert_eq!((level(adsb.plan(), E::Latency), adsb.planning().beyond()), (Level::Skipped, 0));
    let moving = rolling(&[1], 20.0);
    let found = play(&mut adsb, &moving, 8..9);
    assert!(found.causes.iter().all(|c| c.effects.iter().any(|e| e.effect == "latency")));
    let beyond = adsb.planning().beyond();
    assert!(beyond > 0 && beyond == found.plots.len() as u64);
    play(&mut adsb, &moving, 9..12);
    assert_eq!((level(adsb.plan(), E::Latency), adsb.planning().beyond()), (Level::Exact, beyond));
}

#[test]
fn leaving_one_effect_out_changes_no_other() {
    for model in models().map(|m| m.model) {
        let exact = Mode::Fixed(PositioningLevels::EXACT);
        let (mut whole, truth) = (sensor(model, exact), rolling(&[1, 2, 3], 8.0));
        let with_all = play(whole.as_mut(), &truth, 1..25);
        assert!(!with_all.plots.is_empty(), "{model}");
        for row in whole.plan() {
            let effect = *E::ALL.iter().find(|e| e.name() == row.effect).expect("known");
            // Without the correlated part the white one has the whole variance; without delays and
            // geometry times and places are others.
            if matches!(effect, E::Correlation | E::Geometry | E::Delay) {
                continue;
            }
            let levels = PositioningLevels::EXACT.with(effect, Level::Skipped);
            let mut partial = sensor(model, Mode::Fixed(levels));
            let without = play(partial.as_mut(), &truth, 1..25);
            assert!(without.plots.len() >= with_all.plots.len(), "{model} {}", effect.name());
            let mut compared = 0;
            for (plot, cause) in with_all.plots.iter().zip(&with_all.causes) {
                let same = without.plots.iter().zip(&without.causes);
                let mut same = same.filter(|(p, c)| p.time == plot.time && c.key == cause.key);
                let (_, other) = same.next().unwrap_or_else(|| panic!("{model}: a plot is lost"));
                assert!(other.effects.iter().all(|e| e.effect != effect.name()));
                for contribution in &cause.effects {
                    let depends = [E::Rounding, E::Geometry, E::Reception].map(E::name);
                    // A fix from more stations or satellites takes the same errors differently.
                    let sky = model.name.contains("satellite") || model.name.contains("const");
                    let stations = (effect == E::Reception && *model == mlat::MODEL)
                        || (effect == E::HardFailures && sky);
                    if contribution.effect == effect.name()
                        || depends.contains(&contribution.effect)
                        || stations
                    {
                        continue;
                    }
                    let other = other.effects.iter().find(|e| e.effect == contribution.effect);
                    let other = other.map_or(f64::NAN, |e| e.value);
                    // An error budget scales one error: less of it is left, no other one.
                    let scaled = matches!(effect, E::CorrectionDistance | E::CorrectionAge)
                        && *model == dgps::BUDGET;
                    let off = (other - contribution.value).abs();
                    let allowed = if scaled { 0.05 * contribution.value } else { 0.0 };
                    assert!(off <= allowed, "{model} {}: {off}", effect.name());
                    compared += 1;
                }
            }
            let alone = matches!(effect, E::Reception | E::HardFailures) || whole.plan().len() == 1;
            assert!(compared > 0 || alone, "{model} {}", effect.name());
        }
    }
}

#[test]
fn a_stricter_tolerance_never_costs_less() {
    for model in models().map(|m| m.model) {
        let mut last = f64::INFINITY;
        for factor in [0.0, 0.1, 1.0, 10.0, 100.0, 1e4] {
            let tolerance = Tolerance::default().times(factor);
            let mut sensor = sensor(model, Mode::Planned(tolerance, 600.0));
            play(sensor.as_mut(), &rolling(&[1, 2, 3], 8.0), 1..3);
            let cost: f64 = sensor.plan().iter().map(|row| row.cost_ns).sum();
            assert!(cost <= last + 1e-9, "{model} at {factor}: {cost} ns after {last} ns");
            last = cost;
        }
    }
}

#[test]
fn the_level_that_the_scene_fixes_stands_in_its_row() {
    for (model, level, words) in [
        (&gps::STATISTICAL, Level::Cheap, "level statistical"),
        (&gps::CONSTELLATION, Level::Middle, "level constellation"),
        (&gps::PER_SATELLITE, Level::Exact, "level per_satellite"),
        (&dgps::BUDGET, Level::Cheap, "level budget"),
        (&dgps::PER_SATELLITE, Level::Exact, "level per_satellite"),
    ] {
        for factor in [0.0, 1e6] {
            let tolerance = Tolerance::default().times(factor);
            let mut sensor = sensor(model, Mode::Planned(tolerance, 600.0));
            play(sensor.as_mut(), &rolling(&[1], 8.0), 1..2);
            let row = &sensor.plan()[0];
            assert_eq!((row.effect, row.level), (E::Geometry.name(), level), "{model}");
            assert!(row.called_for.contains("fixed by") && row.called_for.contains(words));
        }
    }
}

#[test]
fn every_level_has_its_measured_cost() {
    for model in models().map(|m| m.model) {
        let mut sensor = sensor(model, Mode::Planned(Tolerance::EXACT, f64::INFINITY));
        play(sensor.as_mut(), &rolling(&[1, 2, 3], 8.0), 1..4);
        for row in sensor.plan() {
            let effect = *E::ALL.iter().find(|e| e.name() == row.effect).expect("known");
            let measured = model.costs.iter().any(|c| c.0 == effect);
            assert!(measured, "{model} {}", row.effect);
        }
    }
    assert!(MEASURED.starts_with("20"), "a date");
}

#[test]
fn what_was_left_out_before_it_is_simulated_stays_in_the_sum() {
    // Nobody moves, then they do: the way of the odometers before is not made good.
    let tolerance = Tolerance { position_m: 40.0, ..Tolerance::default() };
    let config = DynamicConfig::odometer(ID);
    let mut dynamic = Dynamic::new(config).expect("sound").tolerating(tolerance, 20.0);
    play(&mut dynamic, &rolling(&[1, 2], 1.0), 1..3);
    assert_eq!(level(dynamic.plan(), E::Scale), Level::Skipped);
    let before = dynamic.plan().iter().find(|r| r.effect == E::Scale.name()).expect("a row").loss;
    play(&mut dynamic, &rolling(&[1, 2], 90.0), 3..6);
    let plan = dynamic.planning().plan().expect("planned");
    if plan.levels.on(E::Scale) {
        assert!(plan.total.fixed_m >= before.fixed_m - 1e-9, "{:?} {before:?}", plan.total);
    }
    assert!(plan.levels.on(E::Heading) && plan.total.fixed_m <= 40.0, "{:?}", plan.total);
}
