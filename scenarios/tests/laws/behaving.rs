//! Traffic that behaves, on airports that ship: nobody overlaps anybody, at any frame looked at; the same
//! bits again; the free policy names its deadlock.

use models::traffic::core::{ClearedBy, Core, Direction, Notice, Order, Phase};
use models::traffic::outline::{Rectangle, distance_m, outline};
use std::path::Path;

/// A generated scene of an airport.
fn scene(airport: &str, rate: u32, duration_s: u32, seed: u32, policy: &str) -> scenarios::Scene {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = {duration_s}\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\npolicy = \"{policy}\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("behaving.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

const XSYN: &str = "layout = \"airports/XSYN.apt.dat\"";
const LIMC: &str =
    "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"";
const LSZH: &str =
    "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"";

fn core_of(scene: &scenarios::Scene) -> Core {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    behaving.core(&scene.run, scene.run.seed).expect("with truth")
}

/// Pairs that overlap on the ground.
fn overlaps(core: &Core) -> Vec<String> {
    let mut there: Vec<(usize, [Rectangle; 2])> = Vec::new();
    for (f, flight) in core.flights().iter().enumerate() {
        let Some(state) = core.state(f).filter(|s| s.position_m.z < 15.0) else { continue };
        there.push((f, outline(flight.size, state.position_m.xy(), state.heading_rad)));
    }
    let mut found = Vec::new();
    for (i, (a, first)) in there.iter().enumerate() {
        for (b, second) in &there[i + 1..] {
            let near = (first[0].corners_m[0] - second[0].corners_m[0]).norm() < 160.0;
            if near && distance_m(first, second) == 0.0 {
                let name = |f: usize| format!("{} {:?}", core.flights()[f].callsign, core.phase(f));
                found.push(format!("{} and {}", name(*a), name(*b)));
            }
        }
    }
    found
}

#[test]
fn nobody_overlaps_anybody_and_speeds_keep_their_limits() {
    for (airport, rate, seed, policy) in [
        (XSYN, 10, 1, "ordered"),
        (XSYN, 20, 2, "planned"),
        (LIMC, 8, 3, "ordered"),
        (LSZH, 10, 4, "planned"),
    ] {
        let scene = scene(airport, rate, 3600, seed, policy);
        let mut core = core_of(&scene);
        let mut done = 0;
        let mut before: Vec<Option<f64>> = vec![None; core.flights().len()];
        for frame in 1..=scene.run.frames() as i64 {
            core.step(frame);
            for f in 0..core.flights().len() {
                let Some(state) = core.state(f) else {
                    before[f] = None;
                    continue;
                };
                let speed = state.velocity_mps.xy().norm();
                let name = &core.flights()[f].callsign;
                assert!(state.position_m.coords.norm().is_finite(), "{name} at frame {frame}");
                if core.phase(f) == Phase::Taxiing {
                    assert!(speed < 15.4 + 12.0, "{name}: {speed} m/s at frame {frame}");
                    if let Some(before) = before[f] {
                        // No jump: the last centimetres before a line are taken at once.
                        assert!(
                            (speed - before).abs() < 0.5,
                            "{name}: {before} to {speed} m/s at frame {frame}"
                        );
                    }
                }
                before[f] = Some(speed);
            }
            if frame % 20 == 0 {
                let found = overlaps(&core);
                assert!(found.is_empty(), "{airport}, seed {seed}, frame {frame}: {found:?}");
            }
        }
        for f in 0..core.flights().len() {
            let m = core.measures(f);
            done += usize::from(m.atot_s.is_some() || m.aibt_s.is_some());
        }
        assert!(done >= 3, "{airport}: only {done} flights done");
    }
}

/// Steps a scene and half an hour more, or until everybody is served; (served, flights, rings of waiting).
fn served(scene: &scenarios::Scene, mut core: Core) -> (usize, usize, Core) {
    for frame in 1..=scene.run.frames() as i64 + 36_000 {
        core.step(frame);
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    (core.measures_of_served(), core.flights().len(), core)
}

#[test]
fn everybody_is_served_in_the_planned_order_also_when_some_stop_for_minutes() {
    for (airport, seed, stops) in [(XSYN, 2, false), (LSZH, 1, false), (LSZH, 2, true)] {
        let scene = scene(airport, 10, 2400, seed, "planned");
        let mut core = core_of(&scene);
        for f in 0..core.flights().len() {
            let draw = (f * 7919 + seed as usize * 31) % 1000;
            if stops && draw < 300 {
                let at_s = core.flights()[f].time_s + 120.0 + draw as f64;
                let effect_frame = (at_s * 20.0) as i64;
                let order = Order::Stop(20.0 + 0.5 * draw as f64);
                let (source, sequence) = ("stops".to_owned(), f as u64);
                core.notice(Notice { effect_frame, source, sequence, flight: f, order });
            }
        }
        let (done, of, core) = served(&scene, core);
        let waiting: Vec<_> =
            (0..of).filter_map(|f| core.waiting(f).map(|w| format!("{f}: {w:?}"))).collect();
        assert_eq!(done, of, "{airport}, seed {seed}: {waiting:?}");
        assert_eq!(core.unexpected_deadlocks(), 0);
    }
}

/// Amsterdam's schedule says `A_17` where its network says `A17`: the scene that ships could not be read.
#[test]
fn every_scene_with_flights_that_ships_is_read() {
    for name in ["eham", "egcc", "xsyn"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("{name}.toml"));
        let scene = scenarios::load_without_truth(&file).unwrap_or_else(|e| panic!("{e}"));
        let flights = scene.traffic.behaving.map_or(0, |b| b.flights.len());
        assert!(flights >= 10, "{name}: {flights} flights");
    }
}

/// Nothing moves without a clearance from outside, and what is asked for the past takes effect at the next frame.
#[test]
fn with_notices_a_departure_waits_for_each_clearance() {
    use models::control::clearance::ClearanceKind as Kind;
    let scene = scene(XSYN, 4, 2400, 3, "planned");
    let mut core = core_of(&scene).cleared_by(ClearedBy::Notices);
    let flight = (0..core.flights().len())
        .find(|f| core.flights()[*f].direction == Direction::Departure)
        .expect("a departure");
    let due = (core.flights()[flight].time_s * 20.0) as i64 + 400;
    let mut asked: Vec<Kind> = Vec::new();
    for frame in 1..=due + 40_000 {
        core.step(frame);
        let Some(kind) = core.wants(flight).filter(|k| asked.last() != Some(k)) else { continue };
        asked.push(kind);
        let order = Order::Clear(kind);
        let sequence = asked.len() as u64;
        let notice = Notice { effect_frame: 0, source: "tower".into(), sequence, flight, order };
        assert_eq!(core.notice(notice), frame + 1);
    }
    for kind in [Kind::Push, Kind::Taxi, Kind::LineUp, Kind::TakeOff] {
        assert!(asked.contains(&kind), "{kind:?} of {asked:?}");
    }
    assert!(core.measures(flight).atot_s.is_some(), "{:?}", core.phase(flight));
    let others: Vec<usize> = (0..core.flights().len()).filter(|f| *f != flight).collect();
    assert!(others.iter().all(|f| core.measures(*f).aobt_s.is_none()), "nobody else was cleared");
}

/// Who is told to hold has that as a clearance until he is told to taxi, which stands again from then on; told twice it is one.
#[test]
fn holding_is_a_clearance_until_one_taxies_again() {
    let scene = scene(XSYN, 4, 2400, 3, "planned");
    let mut core = core_of(&scene);
    let leaves = |f: &usize| core.flights()[*f].direction == Direction::Departure;
    let flight = (0..core.flights().len()).find(leaves).expect("a departure");
    let mut said = 0;
    let mut tell = |core: &mut Core, order| {
        said += 1;
        let (source, sequence) = ("ground".to_owned(), said);
        core.notice(Notice { effect_frame: 0, source, sequence, flight, order });
    };
    let (mut taxies_at, mut held_m) = (None, None);
    for frame in 1..=scene.run.frames() as i64 {
        core.step(frame);
        if !core.clearances().iter().any(|c| c.flight == flight && c.kind == "TAX") {
            continue;
        }
        let at = *taxies_at.get_or_insert(frame);
        match frame - at {
            100 | 140 => tell(&mut core, Order::Hold),
            // Stands by now, and so it goes on to.
            500 => held_m = core.state(flight).map(|s| s.position_m),
            700 => {
                let moved_m =
                    (core.state(flight).expect("there").position_m - held_m.expect("there")).norm();
                assert!(moved_m < 0.01, "{moved_m} m");
                tell(&mut core, Order::Clear(models::control::clearance::ClearanceKind::Taxi));
            }
            _ => {}
        }
    }
    let of: Vec<_> = core.clearances().iter().filter(|c| c.flight == flight).collect();
    let all = |kind: &str| -> Vec<(f64, Option<f64>)> {
        of.iter().filter(|c| c.kind == kind).map(|c| (c.from_s, c.until_s)).collect()
    };
    let (taxies, holds) = (all("TAX"), all("HLD"));
    let ([(from_s, until_s), (again_s, _)], [(held_s, over_s)]) = (&taxies[..], &holds[..]) else {
        panic!("{taxies:?} {holds:?}");
    };
    assert!((*until_s, *over_s) == (Some(*held_s), Some(*again_s)), "{taxies:?} {holds:?}");
    assert!((held_s - from_s - 5.0).abs() < 0.2 && (again_s - held_s - 30.0).abs() < 0.2);
    assert!(core.measures(flight).atot_s.is_some(), "{:?}", core.phase(flight));
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let scene = scene(XSYN, 15, 1800, 5, "planned");
    let (mut a, mut b) = (core_of(&scene), core_of(&scene));
    for frame in 1..=scene.run.frames() as i64 {
        a.step(frame);
        b.step(frame);
        if frame % 200 == 0 {
            assert_eq!(a.digest(), b.digest(), "frame {frame}");
        }
    }
    assert_ne!(a.digest(), core_of(&scene).digest());
}

#[test]
fn wrong_schedules_are_refused_with_line_and_nearest_name() {
    let header = "callsign,address,type,movement,runway,stand,eobt,eldt";
    let base = std::env::temp_dir().join(format!("seeds-schedules-{}", std::process::id()));
    std::fs::create_dir_all(&base).expect("a folder");
    let layout = Path::new(env!("CARGO_MANIFEST_DIR")).join("airports/XSYN.apt.dat");
    for (row, expected) in [
        ("AB1,4b0001,A32O,departure,09,C1,2026-01-01T06:00:00Z,", ":2: type: found"),
        ("AB1,4b0001,A320,departure,10,C1,2026-01-01T06:00:00Z,", ":2: runway: found"),
        ("AB1,4b0001,A320,departure,09,C99,2026-01-01T06:00:00Z,", ":2: stand: found"),
        ("AB1,4b0001,A320,departure,09,C1,,", ":2: eobt: found"),
        ("AB1,4b0001,A320,departure,09,C1,yesterday,", ":2: eobt: found"),
        ("AB1,4b0001,A320,hovering,09,C1,,", ":2: movement: found"),
    ] {
        std::fs::write(base.join("s.csv"), format!("{header}\n{row}\n")).expect("a file");
        let text = format!(
            "[run]\ntitle = \"t\"\nduration_s = 600\n[airport]\nlayout = {:?}\n[[traffic]]\nkind = \"schedule\"\nfile = \"s.csv\"\n",
            layout.display().to_string()
        );
        let error = scenarios::load_text(&base.join("x.toml"), &text).expect_err(row).to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
    let _ = std::fs::remove_dir_all(&base);
}

/// Manchester's second runway has, behind a landing from the north-east, only exits that lead back onto it.
#[test]
fn who_would_land_where_no_exit_leads_to_a_stand_lands_on_the_parallel_runway() {
    let base = std::env::temp_dir().join(format!("seeds-parallel-{}", std::process::id()));
    std::fs::create_dir_all(&base).expect("a folder");
    let layout = Path::new(env!("CARGO_MANIFEST_DIR")).join("airports/EGCC.nodes.csv");
    let row = |n: u32, movement: &str, runway: &str, times: &str| {
        format!("XAA{n},3c010{n},A319,{movement},{runway},26,{times}\n")
    };
    let csv = [
        "callsign,address,type,movement,runway,stand,eobt,eldt\n".to_owned(),
        row(1, "departure", "23L", "2026-01-01T00:05:00Z,"),
        row(2, "arrival", "23L", ",2026-01-01T00:20:00Z"),
        row(3, "arrival", "23R", ",2026-01-01T00:25:00Z"),
        row(4, "arrival", "05R", ",2026-01-01T00:30:00Z"),
    ];
    std::fs::write(base.join("s.csv"), csv.concat()).expect("a file");
    let text = format!(
        "[run]\ntitle = \"t\"\nstart = 2026-01-01T00:00:00Z\nduration_s = 3600\n[airport]\nlayout = {:?}\n[[traffic]]\nkind = \"schedule\"\nfile = \"s.csv\"\n",
        layout.display().to_string()
    );
    let scene = scenarios::load_text(&base.join("x.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    let _ = std::fs::remove_dir_all(&base);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let names = |r: (usize, usize)| behaving.network.runways[r.0].names[r.1].as_str();
    let runways: Vec<&str> = behaving.flights.iter().map(|f| names(f.runway)).collect();
    assert_eq!(runways, ["23L", "23R", "23R", "05R"]);
    let told = behaving.remarks.iter().filter(|r| r.contains("runway 23L, lands on 23R"));
    assert_eq!(told.count(), 1, "{:?}", behaving.remarks);
}

/// A car that stands on the runway for four minutes and a parked aircraft are given way to: nobody overlaps them, nobody
/// rolls or lands beside the car, and all are served.
#[test]
fn what_is_recorded_or_driven_is_given_way_to() {
    let movers = "[[traffic]]\nkind = \"parked\"\ncallsign = \"STANDS\"\ntype = \"A320\"\nstand = \"C1\"\n\
         [[traffic]]\nkind = \"route\"\ncallsign = \"CAR1\"\ntype = \"FOLLOWME\"\nvia = [\"#24\", \"#3\", \"#24\"]\nstart_s = 900\nhalts = [{ at = \"#3\", duration_s = 240 }]\n";
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 3\nduration_s = 2400\n[airport]\n{XSYN}\n{movers}[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 12\ndepartures_per_h = 12\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("behaving.toml");
    let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
    let share = scene.traffic.behaving.as_ref().expect("behaves");
    assert_eq!(share.obstacles.len(), 2);
    let mut core = core_of(&scene);
    let driven = &scene.traffic.entities[1];
    let runway = scene.airport.layout.runway("09").expect("is there");
    let mut met = 0;
    for frame in 1..=scene.run.frames() as i64 + 36_000 {
        core.step(frame);
        if frame % 10 != 0 {
            continue;
        }
        let now = models::time::SimTime(frame * scene.run.frame.0);
        for entity in &scene.traffic.entities[..2] {
            let Some(state) = entity.trajectory.as_ref().and_then(|t| t.at(now)) else { continue };
            let size = models::traffic::outline::Size {
                length_m: entity.class.length_m,
                span_m: entity.class.span_m,
                aircraft: entity.class.aircraft,
            };
            let body = outline(size, state.position_m.xy(), state.heading_rad);
            for (f, flight) in core.flights().iter().enumerate() {
                let Some(other) = core.state(f).filter(|s| s.position_m.z < 3.0) else { continue };
                let inside = entity.callsign == driven.callsign
                    && runway.distance_m(state.position_m.xy()) < 60.0;
                let rolls = matches!(core.phase(f), Phase::Rolling | Phase::Landing);
                assert!(!(inside && rolls), "{} rolls at {:.1} s", flight.callsign, now.s());
                met += u32::from(inside && core.phase(f) == Phase::Taxiing);
                let theirs = outline(flight.size, other.position_m.xy(), other.heading_rad);
                let apart = distance_m(&body, &theirs) > 0.0;
                assert!(apart, "{} and {} at {:.1} s", entity.callsign, flight.callsign, now.s());
            }
        }
    }
    assert!(met > 0, "nobody taxies while the car is there: the test says nothing");
    assert_eq!(core.measures_of_served(), core.flights().len(), "{:?}", core.remarks());
}
