//! Traffic that behaves, on airports that ship: nobody overlaps anybody, at any frame looked at; the same
//! bits again; the free policy names its deadlock.

use models::traffic::core::{Core, Phase};
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
    for (airport, rate, seed) in [(XSYN, 10, 1), (XSYN, 20, 2), (LIMC, 8, 3), (LSZH, 10, 4)] {
        let scene = scene(airport, rate, 3600, seed, "ordered");
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
                assert!(state.position_m.norm().is_finite(), "{name} at frame {frame}");
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

#[test]
fn the_same_seed_gives_the_same_bits() {
    let scene = scene(XSYN, 15, 1800, 5, "ordered");
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
