//! Vehicles among flights that behave: they get about, and nobody has to be cleared for them or waits for long.

use models::control::alert::Change;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::control::situation::TargetClass;
use models::time::SimTime;
use models::traffic::core::{Core, Direction, Phase};
use models::traffic::exact::{Numbers, Watch};
use scenarios::Scene;
use scenarios::hours::{Hour, hour};
use std::path::Path;

fn text(airport: &str, rest: &str, minutes: u32, seed: u64) -> String {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is = |ext: &str| base.join(format!("airports/{airport}.{ext}")).exists();
    let ext = if is("apt.dat") { "apt.dat" } else { "nodes.csv" };
    let net = format!("ground_network = \"airports/{airport}.groundnet.xml\"");
    let net = if is("groundnet.xml") { net } else { String::new() };
    format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = {}\n[airport]\nlayout = \"airports/{airport}.{ext}\"\n{net}\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 10\ndepartures_per_h = 10\n{rest}\n",
        minutes * 60
    )
}

fn scene(airport: &str, rest: &str, minutes: u32, seed: u64) -> Scene {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = text(airport, rest, minutes, seed);
    scenarios::load_text(&base.join("vehicles.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

const FLEET: &str = "vehicles = { FOLLOWME = 3, FUEL = 2, BUS = 1 }";

/// What became of the vehicles of a run.
#[derive(Default)]
struct Seen {
    /// By vehicle: stands that it stood on, in their order.
    stood: Vec<Vec<usize>>,
    /// The nearest that one was to a centreline beside the ends, m.
    nearest_m: f64,
    fastest_mps: f64,
}

#[test]
fn vehicles_get_about_beside_the_runways_and_all_is_kept_at_every_frame() {
    for (airport, seed, policy) in [
        ("XSYN", 3, "planned"),
        ("LSZH", 2, "planned"),
        ("LIMC", 2, "planned"),
        ("EHAM", 1, "planned"),
        ("LZIB", 2, "planned"),
    ] {
        let rest = format!("{FLEET}\n[control]\npolicy = \"{policy}\"");
        let scene = scene(airport, &rest, 40, seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let first = behaving.flights.len();
        let count = behaving.vehicles.len();
        let name = format!("{airport}, seed {seed}, {policy}");
        assert_eq!(count, 6, "{name}: {:?}", behaving.left_out);
        let mut seen =
            Seen { stood: vec![Vec::new(); count], nearest_m: f64::INFINITY, fastest_mps: 0.0 };
        let network = behaving.network.clone();
        let step = &mut |core: &mut Core, frame: i64| {
            core.step(frame);
            for v in 0..count {
                let Some(state) = core.state(first + v) else { continue };
                let stand = core.stand(first + v);
                if core.phase(first + v) == Phase::Parked && seen.stood[v].last() != Some(&stand) {
                    seen.stood[v].push(stand);
                }
                seen.fastest_mps = seen.fastest_mps.max(state.velocity_mps.norm());
                for runway in &network.runways {
                    let (along_m, off_m) = runway.place_m(state.position_m.xy());
                    if (0.0..=runway.length_m).contains(&along_m) {
                        seen.nearest_m = seen.nearest_m.min(off_m.abs());
                    }
                }
            }
        };
        let looks = Hour { seed, every: 1, drain_s: 2700.0, stopping: 0.2 };
        let held = hour(behaving, &scene.run, &scene.airport.layout, &looks, step).expect("truth");
        assert_eq!(held.broken(), Vec::<String>::new(), "{name}");
        assert!(held.core.all_served(), "{name}: {} of {first}", held.core.measures_of_served());
        assert_eq!(held.core.unexpected_deadlocks(), 0, "{name}");
        // Each stands 3 to 10 minutes and drives a few: in 40 minutes all but one have arrived somewhere, in the mean each once. (At
        // Malpensa, 5 km long, 7 drives of six; elsewhere 16 to 28.)
        let drives: Vec<usize> = seen.stood.iter().map(|s| s.len().saturating_sub(1)).collect();
        let stands: Vec<&str> =
            seen.stood.iter().map(|s| network.stands[s[0]].name.as_str()).collect();
        let idle = drives.iter().filter(|d| **d == 0).count();
        assert!(idle <= 1, "{name}: {drives:?} from {stands:?}");
        assert!(drives.iter().sum::<usize>() >= count, "{name}: {drives:?}");
        assert!(seen.nearest_m > 30.0, "{name}: {} m from a centreline", seen.nearest_m);
        let most_mps = behaving.vehicles.iter().map(|v| v.taxi_mps.0).fold(0.0, f64::max);
        assert!(seen.fastest_mps <= most_mps, "{name}: {} m/s", seen.fastest_mps);
        // Nobody clears them.
        let of_vehicles = held.core.clearances().iter().filter(|c| c.flight >= first).count();
        assert_eq!(of_vehicles, 0, "{name}");
    }
}

#[test]
fn vehicles_are_left_out_where_nothing_is_planned_and_that_is_said() {
    for policy in ["ordered", "free"] {
        let rest = format!("{FLEET}\n[control]\npolicy = \"{policy}\"");
        let scene = scene("LZIB", &rest, 20, 2);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        assert!(behaving.vehicles.is_empty(), "{policy}");
        let told = scene.warnings.iter().any(|w| w.contains("6 vehicles are left out"));
        assert!(told, "{policy}: {:?}", scene.warnings);
    }
}

#[test]
fn flights_have_their_stands_beside_as_many_vehicles_as_there_is_room_for() {
    let scene = scene("XSYN", "vehicles = { FOLLOWME = 40 }", 60, 5);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    // Those for whom no stand is free are left out, and that is said.
    let left_out = |r: &&String| r.contains("vehicles are left out");
    let told = behaving.left_out.iter().filter(left_out).count();
    assert_eq!(told == 1, behaving.vehicles.len() < 40, "{:?}", behaving.left_out);
    let mut core = behaving.core(&scene.run, 5).expect("truth");
    let flights = behaving.flights.len();
    (1..=72_000).for_each(|frame| core.step(frame));
    let given = |f: usize| core.stand(f) == core.flights()[f].stand;
    let others = (0..flights).filter(|f| !given(*f)).count();
    assert!(others <= flights / 5, "{others} of {flights} flights got another stand");
}

#[test]
fn the_same_vehicles_come_whoever_asks_and_without_any_nothing_is_changed() {
    let with = scene("LSZH", FLEET, 20, 1);
    let without = scene("LSZH", "", 20, 1);
    let [with, without] = [&with, &without].map(|s| s.traffic.behaving.clone().expect("behaves"));
    assert_eq!(with.flights, without.flights);
    assert!(without.vehicles.is_empty());
    assert!(with.vehicles.iter().all(|v| v.direction == Direction::Vehicle));
    let run = scene("LSZH", FLEET, 20, 1).run;
    let digest = |times: i64| {
        let mut core = with.core(&run, 1).expect("truth");
        (1..=times).for_each(|frame| core.step(frame));
        core.digest()
    };
    assert_eq!(digest(12_000), digest(12_000));
}

#[test]
fn a_type_that_is_no_vehicle_is_refused_by_name() {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (rest, said) in [
        ("vehicles = { A320 = 1 }", "A320"),
        ("vehicles = { FOLLOWME = 201 }", "0 to 200"),
        ("vehicles = { FOLLOWME = 0.5 }", "whole number"),
    ] {
        let text = text("XSYN", rest, 20, 1);
        let error = scenarios::load_text(&base.join("vehicles.toml"), &text).expect_err(rest);
        assert!(error.to_string().contains(said), "{error}");
        assert!(error.to_string().contains("vehicles"), "{error}");
    }
}

/// Vehicles were aircraft without clearances to the reference: an alert at each drive, which tracks then had missed.
#[test]
fn the_reference_takes_vehicles_for_vehicles_and_tells_of_nobody_who_drives() {
    for (airport, seed) in [("XSYN", 3), ("LSZH", 2), ("LIMC", 5)] {
        let scene = scene(airport, FLEET, 20, seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
        let mut watch = Watch::new(layout, Parameters::default(), false);
        let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
        let (mut numbers, mut drove, mut told) = (Numbers::default(), 0, Vec::new());
        for frame in 1..=scene.run.frames() as i64 {
            core.step(frame);
            if frame % 20 != 0 {
                continue;
            }
            let now = SimTime(frame * scene.run.frame.0);
            for target in numbers.targets(&core, now) {
                let flight = &core.flights()[usize::from(target.number)];
                let vehicle = flight.direction == Direction::Vehicle;
                let class = if vehicle { TargetClass::Vehicle } else { TargetClass::Aircraft };
                assert_eq!(target.class, class, "{airport}: {}", flight.callsign);
                drove += usize::from(vehicle && target.velocity_mps.norm() > 3.0);
            }
            let raised = watch.scan(&core, now).iter().filter(|(c, _)| *c == Change::Raised);
            told.extend(raised.map(|(_, a)| (a.condition.kind.word(), a.subjects())));
        }
        let fleet = |name: &String| {
            let own = |f: &&models::traffic::core::Flight| f.callsign == *name;
            core.flights().iter().find(own).is_some_and(|f| f.direction == Direction::Vehicle)
        };
        told.retain(|(_, subjects)| fleet(subjects));
        assert!(drove > 60, "{airport}: {drove}");
        assert!(told.is_empty(), "{airport}: {told:?}");
    }
}

/// Whoever came behind the first 4 096 flights of a scene had no target on exact truth.
#[test]
fn the_reference_has_everybody_who_is_there_however_many_come_before_and_after() {
    let mut scene = scene("XSYN", FLEET, 20, 3);
    let alone =
        scene.traffic.behaving.as_ref().expect("behaves").core(&scene.run, 3).expect("a core");
    let behaving = scene.traffic.behaving.as_mut().expect("behaves");
    let behaving = std::sync::Arc::get_mut(behaving).expect("nobody else has it");
    // Flights of other hours come first, as many as have numbers.
    let more = 4_100;
    let like = behaving.flights[0].clone();
    let place = |n: usize| models::traffic::core::Flight {
        callsign: format!("OLD{n}"),
        time_s: f64::INFINITY,
        turnaround_of: None,
        key: 1_000_000 + n as u64,
        ..like.clone()
    };
    let later = |f: &models::traffic::core::Flight| models::traffic::core::Flight {
        turnaround_of: f.turnaround_of.map(|of| of + more),
        ..f.clone()
    };
    let all: Vec<_> = (0..more).map(place).chain(behaving.flights.iter().map(later)).collect();
    behaving.flights = std::sync::Arc::new(all);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, 3).expect("a core");
    let mut alone = alone;
    let (mut numbers, mut few) = (Numbers::default(), Numbers::default());
    let mut had = std::collections::BTreeMap::new();
    let mut most = 0;
    for frame in 1..=scene.run.frames() as i64 {
        core.step(frame);
        alone.step(frame);
        if frame % 20 == 0 {
            let now = SimTime(frame * scene.run.frame.0);
            let (all, known) = (numbers.targets(&core, now), few.targets(&alone, now));
            let names = |targets: &[models::control::situation::Target]| {
                let mut names: Vec<_> = targets.iter().filter_map(|t| t.callsign).collect();
                names.sort();
                names
            };
            assert_eq!(names(&all), names(&known), "frame {frame}");
            assert!(all.windows(2).all(|pair| pair[0].number < pair[1].number), "in their order");
            for target in &all {
                let name = target.callsign.expect("a name");
                assert_eq!(*had.entry(name).or_insert(target.number), target.number, "{name:?}");
            }
            most = most.max(all.len());
        }
    }
    assert!(most >= 8, "{most}");
}
