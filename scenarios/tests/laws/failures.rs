//! Failures of equipment on airports that nothing was fitted on: silent transponders, stop bars that stay dark or stay lit.

use models::control::alert::Change;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::environment::Weather;
use models::plot::Callsign;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use models::traffic::core::{Core, Direction, FailureKind, drawn_failures};
use models::traffic::exact::Watch;
use scenarios::Scene;
use std::path::Path;

const LIMC: &str =
    "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"";
const LSZH: &str =
    "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"";
const LZIB: &str = "layout = \"airports/LZIB.apt.dat\"";

fn text(airport: &str, seed: u32, rest: &str) -> String {
    format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 2400\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 6\ndepartures_per_h = 8\n{rest}"
    )
}

fn load(text: &str) -> Result<Scene, scenarios::ScenarioError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("failures.toml");
    scenarios::load_text(&path, text)
}

fn scene(airport: &str, seed: u32, rest: &str) -> Scene {
    load(&text(airport, seed, rest)).unwrap_or_else(|e| panic!("{e}"))
}

fn core_of(scene: &Scene) -> Core {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    behaving.core(&scene.run, scene.run.seed).expect("with truth")
}

/// The first departure that lines up within half an hour when nothing fails: its index, its name, when.
fn first_off(airport: &str, seed: u32) -> (usize, String, f64) {
    let mut core = core_of(&scene(airport, seed, ""));
    for frame in 1..=36_000 {
        core.step(frame);
        if let Some(c) = core.clearances().iter().find(|c| c.kind == "LUP") {
            let name = core.flights()[c.flight].callsign.clone();
            return (c.flight, name, c.from_s);
        }
    }
    panic!("{airport}: nobody lines up")
}

/// The core until everybody is served, and which alerts were raised: kind and subjects.
fn flown(scene: &Scene) -> (Core, Vec<(String, String)>) {
    let mut core = core_of(scene);
    let network = &scene.traffic.behaving.as_ref().expect("behaves").network;
    let layout = Layout::of(&scene.airport.layout).with_network(network);
    let mut watch = Watch::new(layout, Parameters::default(), true);
    let mut raised = Vec::new();
    for frame in 1..=scene.run.frames() as i64 + 54_000 {
        core.step(frame);
        if frame % 20 == 0 {
            let now = SimTime(frame * scene.run.frame.0);
            let new = watch.scan(&core, now).iter().filter(|(c, _)| *c == Change::Raised);
            raised.extend(new.map(|(_, a)| (a.condition.kind.word(), a.subjects())));
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    (core, raised)
}

fn fails(kind: &str, callsign: &str, rest: &str) -> String {
    format!(
        "[control]\nstop_bars = true\n[[failure]]\nkind = \"{kind}\"\ncallsign = \"{callsign}\"\n{rest}\n"
    )
}

#[test]
fn by_dark_bars_somebody_enters_without_an_alert_of_the_bar_and_by_lit_ones_nobody_does() {
    for (airport, seed) in [(LIMC, 3), (LSZH, 5), (LZIB, 7)] {
        let (flight, name, lines_up_s) = first_off(airport, seed);
        let about = |raised: &[(String, String)], kind: &str| {
            raised.iter().any(|(k, subjects)| k == kind && subjects.contains(&name))
        };
        // Without the lamps' failure the bar tells.
        let (core, raised) = flown(&scene(airport, seed, &fails("pass_hold", &name, "")));
        assert!(about(&raised, "STOPBAR"), "{airport}: {raised:?}");
        assert_eq!(core.measures_of_served(), core.flights().len(), "{airport}: pass_hold");
        let (core, raised) =
            flown(&scene(airport, seed, &fails("stop_bar", &name, "stay_s = 7200")));
        assert!(about(&raised, "NOCLR_RWY") && !about(&raised, "STOPBAR"), "{airport}: {raised:?}");
        let [shown] = core.shown() else { panic!("{airport}: {:?}", core.shown()) };
        assert_eq!((shown.kind, &shown.callsign), (FailureKind::StopBar, &name));
        assert!((shown.time_s - lines_up_s).abs() < 120.0, "{airport}: {}", shown.time_s);
        assert_eq!(core.measures_of_served(), core.flights().len(), "{airport}: dark");
        // Lit ones keep everybody off the runway until they are mended, and nobody is blamed.
        let until_s = lines_up_s + 200.0;
        let from_s = lines_up_s - 30.0;
        let lit = format!("at_s = {from_s}\nstay_s = {}\nlamps = \"lit\"", until_s - from_s);
        let (core, raised) = flown(&scene(airport, seed, &fails("stop_bar", &name, &lit)));
        let runway = core.flights()[flight].runway.0;
        let entered = core.clearances().iter().filter(|c| {
            let own = core.flights()[c.flight].runway.0 == runway;
            own && c.kind == "LUP" && (from_s..until_s).contains(&c.from_s)
        });
        assert_eq!(entered.count(), 0, "{airport}");
        assert_eq!(core.shown().len(), 1, "{airport}: {:?}", core.shown());
        assert!((from_s..until_s).contains(&core.shown()[0].time_s), "{airport}");
        // An arrival that cannot leave the runway for them may be blamed for standing there; nobody who waits is.
        let departs = |name: &str| {
            let own = |f: &&models::traffic::core::Flight| f.callsign == name;
            core.flights().iter().find(own).is_some_and(|f| f.direction == Direction::Departure)
        };
        let blamed = |(kind, name): &(String, String)| {
            kind == "STOPBAR" || kind == "NOCLR_RWY" && departs(name)
        };
        assert!(!raised.iter().any(blamed), "{airport}: {raised:?}");
        assert_eq!(core.measures_of_served(), core.flights().len(), "{airport}: lit");
    }
}

/// The flights of a core as sensors look at them at the end of a second.
struct Now<'a> {
    scene: &'a Scene,
    core: &'a Core,
}

impl Truth for Now<'_> {
    fn len(&self) -> usize {
        self.core.flights().len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, index: usize) -> &TargetClass {
        let first = self.scene.traffic.behaving.as_ref().expect("behaves").first_entity;
        &self.scene.traffic.entities[first + index].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        Callsign::new(&self.core.flights()[index].callsign)
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn answers(&self, index: usize, _: SimTime) -> bool {
        self.core.answers(index)
    }
    fn at(&self, index: usize, _: SimTime) -> Option<TargetState> {
        let state = self.core.state(index)?;
        Some(TargetState {
            position_m: state.position_m,
            velocity_mps: state.velocity_mps,
            heading_rad: state.heading_rad,
        })
    }
}

#[test]
fn who_has_a_silent_transponder_is_seen_by_the_radar_alone_and_moves_as_before() {
    for (airport, seed) in [(LIMC, 3), (LSZH, 5)] {
        let watched = "[control]\nsees = \"tracks\"\n";
        let plain = core_of(&scene(airport, seed, watched));
        let flight = (0..plain.flights().len())
            .find(|f| plain.flights()[*f].direction == Direction::Departure)
            .expect("a departure");
        let name = plain.flights()[flight].callsign.clone();
        let failure = format!(
            "{watched}[[failure]]\nkind = \"transponder\"\ncallsign = \"{name}\"\nat_s = 20\nstay_s = 30\n"
        );
        let scene = scene(airport, seed, &failure);
        let (mut core, mut plain) = (core_of(&scene), plain);
        let mut sensors: Vec<(bool, Box<dyn Sensor>)> = Vec::new();
        for s in &scene.sensors {
            if let Some(radar) = &s.asde {
                let radar = radar.radar_for(&scene, s, scene.tolerance()).expect("a radar");
                sensors.push((false, Box::new(radar)));
            } else if let Some(reported) = &s.reported {
                sensors.push((true, reported.sensor(scene.tolerance(), 2400.0).expect("a sensor")));
            }
        }
        assert_eq!(sensors.len(), 2, "the standard set");
        // Seconds in which each sensor saw it, before, while and after it was silent.
        let mut seen = [[0_u32; 3]; 2];
        for second in 1..=80_i64 {
            for frame in 20 * (second - 1) + 1..=20 * second {
                core.step(frame);
                plain.step(frame);
            }
            let place = |f: usize| core.state(f).map(|s| s.position_m);
            let same =
                (0..core.flights().len()).all(|f| place(f) == plain.state(f).map(|s| s.position_m));
            assert!(same, "{airport}: it moves as before");
            let [from, to] = [second - 1, second].map(|s| SimTime::from_s(s as f64));
            let interval = ScanInterval { run_seed: 1, scan: second as u64, from, to };
            let phase = usize::from(second > 20) + usize::from(second >= 50);
            for (cooperative, sensor) in &mut sensors {
                let mut sink = PlotSink::default();
                let truth = Now { scene: &scene, core: &core };
                sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
                let own = sink.causes.iter().any(|c| c.key == Some(flight as u64));
                seen[usize::from(*cooperative)][phase] += u32::from(own);
            }
        }
        let [radar, multilateration] = seen;
        assert_eq!(multilateration[1], 0, "{airport}: {seen:?}");
        assert!(multilateration[0] >= 10 && multilateration[2] >= 15, "{airport}: {seen:?}");
        assert!(radar[1] >= 15, "{airport}: {seen:?}");
        let [shown] = core.shown() else { panic!("{airport}: {:?}", core.shown()) };
        assert_eq!((shown.kind, &shown.callsign), (FailureKind::Transponder, &name));
        assert!((shown.time_s - 20.0).abs() < 0.1, "{}", shown.time_s);
    }
}

#[test]
fn equipment_fails_by_rate_and_bars_only_where_they_are_in_use() {
    let core = core_of(&scene(LSZH, 4, ""));
    let flights: Vec<_> = (0..4000)
        .map(|n| {
            let mut flight = core.flights()[n % core.flights().len()].clone();
            flight.key = 1_000_000 + n as u64;
            flight
        })
        .collect();
    let count = |factor: f64, bars: bool, kind: FailureKind| {
        let drawn = drawn_failures(&flights, 9, factor, (bars, false));
        drawn.iter().filter(|f| f.kind == kind).count()
    };
    // 4 000 at 0.05, and about half of them at 0.005: within four standard deviations.
    let silent = count(50.0, true, FailureKind::Transponder);
    assert!((145..=255).contains(&silent), "{silent}");
    let dark = count(50.0, true, FailureKind::StopBar);
    assert!((1..=30).contains(&dark), "{dark}");
    assert_eq!(count(50.0, false, FailureKind::StopBar), 0);
    assert_eq!(count(0.0, true, FailureKind::Transponder), 0);
    let ids = |factor: f64| -> Vec<String> {
        drawn_failures(&flights, 9, factor, (true, false)).into_iter().map(|f| f.id).collect()
    };
    let (few, many) = (ids(10.0), ids(20.0));
    assert!(few.iter().all(|id| many.contains(id)), "a larger factor keeps those of a smaller one");
}

#[test]
fn bars_that_fail_where_none_are_in_use_are_refused_with_what_to_do() {
    let name = core_of(&scene(LSZH, 4, "")).flights()[0].callsign.clone();
    let rest = format!("[[failure]]\nkind = \"stop_bar\"\ncallsign = \"{name}\"\n");
    let error = load(&text(LSZH, 4, &rest)).expect_err("refused").to_string();
    assert!(error.contains("stop_bars = true"), "{error}");
}

/// The bars that fail are those of the runway that the plan names, for the core as for whoever reads the scene, also where the flight
/// itself goes to another by mistake.
#[test]
fn the_bars_that_fail_are_those_of_the_planned_runway_for_everybody() {
    for (airport, seed) in [(LIMC, 3), (LSZH, 5)] {
        let (flight, name, _) = first_off(airport, seed);
        let fails = |kind: &str| format!("[[failure]]\nkind = \"{kind}\"\ncallsign = \"{name}\"\n");
        for order in [["wrong_runway", "stop_bar"], ["stop_bar", "wrong_runway"]] {
            let rest = "[control]\nstop_bars = true\n".to_owned() + &order.map(fails).concat();
            let scene = scene(airport, seed, &rest);
            let behaving = scene.traffic.behaving.as_ref().expect("behaves");
            let mut core = core_of(&scene);
            assert_ne!(core.flights()[flight].runway, behaving.flights[flight].runway, "{airport}");
            (1..=20).for_each(|frame| core.step(frame));
            let told = behaving.failed_bars(scene.run.seed);
            let failed: Vec<_> = core.failed_bars().collect();
            assert_eq!(failed, told, "{airport}: {order:?}");
            let planned = &behaving.network.runways[behaving.flights[flight].runway.0].names[0];
            assert_eq!(&failed[0].runway, planned, "{airport}");
        }
    }
}

/// The car of a failure once stood, at its begin, in the strip of a crossing runway: an alert in its first second.
#[test]
fn the_car_that_crosses_a_runway_begins_in_the_strip_of_no_other() {
    let mut begun = 0;
    for (airport, seed) in [(LZIB, 1), (LZIB, 2), (LZIB, 3), (LSZH, 2), (LIMC, 4)] {
        let calm = core_of(&scene(airport, seed, ""));
        let arrives = |f: &&models::traffic::core::Flight| f.direction == Direction::Arrival;
        for flight in calm.flights().iter().filter(arrives).take(2) {
            let with_car = scene(airport, seed, &fails("vehicle_on_runway", &flight.callsign, ""));
            let mut core = core_of(&with_car);
            let car = core.flights().len();
            let first = (1..=48_000).find_map(|frame| {
                core.step(frame);
                core.state(car)
            });
            let Some(state) = first else { continue };
            let network = &with_car.traffic.behaving.as_ref().expect("behaves").network;
            for (r, runway) in network.runways.iter().enumerate() {
                let [a, b] = runway.ends_m;
                let off_m = models::airport::distance_to_segment_m(state.position_m.xy(), a, b);
                assert!(off_m > runway.hold_distance_m, "{airport} {seed}: {off_m:.0} m of {r}");
            }
            begun += 1;
        }
    }
    assert!(begun >= 8, "{begun} cars");
}

/// At XSYN the clearance that a controller gives against another one ended the lawful one that its holder had got since, to cross the other
/// runway, and stood itself until the end.
#[test]
fn a_conflicting_clearance_ends_itself_and_no_other() {
    let xsyn = "layout = \"airports/XSYN.apt.dat\"";
    let (mut given, mut others) = (0, 0);
    for seed in 1..=6 {
        let quiet = text(xsyn, seed, "").replace("_per_h = 6", "_per_h = 12");
        let flights = core_of(&load(&quiet).expect("a scene")).flights().to_vec();
        let failing = flights.iter().map(|f| {
            format!(
                "[[failure]]\nkind = \"conflicting_clearance\"\ncallsign = \"{}\"\n",
                f.callsign
            )
        });
        let scene = load(&(quiet + &failing.collect::<String>())).expect("a scene");
        let (core, _) = flown(&scene);
        for shown in core.shown() {
            let is = |c: &&models::traffic::core::Clearance| {
                c.kind == "CRO" && c.runway == "09/27" && c.from_s == shown.time_s
            };
            let stood_s = |c: &models::traffic::core::Clearance| {
                c.until_s.unwrap_or(f64::INFINITY) - c.from_s
            };
            for wrong in core.clearances().iter().filter(is) {
                given += 1;
                assert!(stood_s(wrong) <= 30.1, "seed {seed}: {wrong:?}");
                let since = wrong.from_s..wrong.from_s + 30.0;
                let of = core.clearances().iter().filter(|c| c.flight == wrong.flight);
                others += of.filter(|c| c.kind == "CRO" && since.contains(&c.from_s)).count() - 1;
            }
        }
    }
    assert!(given >= 10 && others >= 1, "{given} given, {others} beside");
}

/// A failure at the line that came due when its flight had lined up, or the second of two of one flight, kept that flight on the
/// runway for ever, and everybody else off it.
#[test]
fn failures_at_the_line_that_come_too_late_or_in_pairs_leave_the_runway_in_use() {
    for (airport, seed) in [(LIMC, 3), (LZIB, 7)] {
        let (_, name, lines_up_s) = first_off(airport, seed);
        let one = |kind: &str, rest: &str| {
            format!("[[failure]]\nkind = \"{kind}\"\ncallsign = \"{name}\"\n{rest}\n")
        };
        let late = format!("at_s = {}", lines_up_s + 0.5);
        let sets = [
            vec![one("pass_hold", &late)],
            vec![one("pass_hold", ""), one("wrong_runway", "")],
            vec![one("pass_hold", ""), one("stop_bar", "stay_s = 7200")],
            vec![one("wrong_runway", ""), one("stop_bar", &late)],
        ];
        for set in sets {
            let rest = "[control]\nstop_bars = true\n".to_owned() + &set.concat();
            let scene = scene(airport, seed, &rest);
            let (core, _) = flown(&scene);
            let served = (core.measures_of_served(), core.flights().len());
            assert_eq!(served.0, served.1, "{airport}: {set:?}: {:?}", core.shown());
            let alone = core.clearances().iter().filter(|c| c.kind == "LUP" && c.until_s.is_none());
            assert_eq!(alone.count(), 0, "{airport}: {set:?}: all have rolled");
        }
    }
}

/// An aircraft whose engine is dead went on at full speed when the stop beside that was over.
#[test]
fn who_stands_for_two_reasons_stands_until_both_are_over() {
    for (airport, seed) in [(LIMC, 3), (LSZH, 5)] {
        let (flight, name, _) = first_off(airport, seed);
        let one = |kind: &str, stay_s: u32| {
            format!("[[failure]]\nkind = \"{kind}\"\ncallsign = \"{name}\"\nstay_s = {stay_s}\n")
        };
        for order in [["stop", "engine"], ["engine", "stop"]] {
            let rest = order.map(|kind| one(kind, if kind == "stop" { 60 } else { 300 })).concat();
            let mut core = core_of(&scene(airport, seed, &rest));
            let mut moved_s = Vec::new();
            for frame in 1..=60_000 {
                core.step(frame);
                let shown_s = core.shown().iter().map(|s| s.time_s).fold(f64::INFINITY, f64::min);
                let now_s = frame as f64 * 0.05;
                if now_s > shown_s + 298.0 {
                    break;
                }
                let speed = core.state(flight).map_or(0.0, |s| s.velocity_mps.norm());
                if now_s > shown_s + 1.0 && speed > 0.1 {
                    moved_s.push(now_s - shown_s);
                }
            }
            assert_eq!(core.shown().len(), 2, "{airport} {order:?}: {:?}", core.shown());
            assert!(moved_s.is_empty(), "{airport} {order:?}: moves after {:?} s", moved_s.first());
        }
    }
}

/// A clearance against another one that went to a car, which nobody clears, changed the place of the lawful one.
#[test]
fn a_conflicting_clearance_is_given_to_no_car() {
    let xsyn = "layout = \"airports/XSYN.apt.dat\"";
    let mut given = 0;
    for seed in 1..=4 {
        let quiet = text(xsyn, seed, "vehicles = { FOLLOWME = 4 }\n");
        let flights = core_of(&load(&quiet).expect("a scene")).flights().to_vec();
        let of = |f: &models::traffic::core::Flight| f.direction != Direction::Vehicle;
        let failing = flights.iter().filter(|f| of(f)).map(|f| {
            format!(
                "[[failure]]\nkind = \"conflicting_clearance\"\ncallsign = \"{}\"\n",
                f.callsign
            )
        });
        let (core, _) = flown(&load(&(quiet + &failing.collect::<String>())).expect("a scene"));
        for c in core.clearances() {
            assert!(of(&core.flights()[c.flight]), "seed {seed}: {c:?}");
            assert!(c.kind != "LND" || c.place_m.is_none(), "seed {seed}: {c:?}");
        }
        for shown in core.shown() {
            let at = |c: &&models::traffic::core::Clearance| {
                c.kind == "CRO" && c.runway == "09/27" && c.from_s == shown.time_s
            };
            given += 1;
            assert!(core.clearances().iter().any(|c| at(&c)), "seed {seed}: {shown:?}");
        }
    }
    assert!(given >= 4, "{given}");
}

/// `wrong_runway` of an arrival let it land elsewhere than it was cleared, and nobody was told.
#[test]
fn a_failure_that_does_not_happen_to_its_flight_is_told_of_and_changes_nothing() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("failures.toml");
    for (airport, seed) in [(LSZH, 5), (LIMC, 3)] {
        let plain = core_of(&scene(airport, seed, ""));
        for direction in [Direction::Arrival, Direction::Departure] {
            let of = |f: &&models::traffic::core::Flight| f.direction == direction;
            let flight = plain.flights().iter().find(of).expect("one");
            for (word, kind) in FailureKind::WORDS {
                let rest = fails(word, &flight.callsign, "");
                let (read, found) =
                    scenarios::warnings::check(&path, &text(airport, seed, &rest)).expect(word);
                let told = found.iter().filter(|w| w.number == 25).count();
                assert_eq!(told, usize::from(!kind.happens_to(direction)), "{word}: {found:?}");
                if told > 0 {
                    let core = core_of(&read);
                    let runway = |f: &models::traffic::core::Flight| f.runway;
                    let same =
                        core.flights().iter().map(runway).eq(plain.flights().iter().map(runway));
                    assert!(same, "{airport}: {word} of {}", flight.callsign);
                }
            }
        }
    }
}
