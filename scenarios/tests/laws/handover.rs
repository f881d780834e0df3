//! Aircraft given by other programs, on airports that nobody drew and on known ones, in states drawn at random: who is on a final
//! comes from where he is to his stand without a jump and touches nobody; who is not is refused with a reason; a call sign has one owner.

#[allow(dead_code, reason = "each test uses a part of it")]
use crate::drawn::{Draws, drawn};
use models::frames::{Azimuth, Point3, Vector2, Vector3};
use models::traffic::core::{Ask, Core, Direction, Given, Phase, RELEASED_ABOVE_M};
use models::traffic::outline::{distance_m, outline};
use models::truth::TruthState;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const SLOPE: f64 = 0.052_407_779_283_041_2;
const NM: f64 = 1852.0;

/// A scene of an airport: by its code, or by the text of a file.
fn scene(airport: &str, seed: u64, per_h: f64, places: usize, policy: &str) -> Option<Scene> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("handover-{airport}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (from, layout) = match airport.len() {
        4 => {
            let net = format!("airports/{airport}.groundnet.xml");
            let root = Path::new(env!("CARGO_MANIFEST_DIR"));
            let net = match root.join(&net).exists() {
                true => format!("ground_network = \"{net}\"\n"),
                false => String::new(),
            };
            (root.to_path_buf(), format!("layout = \"airports/{airport}.apt.dat\"\n{net}"))
        }
        _ => {
            std::fs::write(folder.join("X.apt.dat"), drawn(seed)).expect("a file");
            (folder, "layout = \"X.apt.dat\"\n".to_owned())
        }
    };
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 1800\n[airport]\n{layout}[[traffic]]\nkind = \"generated\"\n\
         arrivals_per_h = {per_h}\ndepartures_per_h = {per_h}\n[[traffic]]\nkind = \"handover\"\ncount = {places}\n[control]\npolicy = \"{policy}\"\n"
    );
    scenarios::load_text(&from.join("scene.toml"), &text).ok()
}

/// A state about a final of a runway end that is landed on, m and m/s as they are drawn; mostly near it.
fn about_a_final(scene: &Scene, d: &mut Draws, callsign: &str, time_s: f64) -> Given {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let lands: Vec<_> = behaving
        .flights
        .iter()
        .filter(|f| f.direction == Direction::Arrival)
        .map(|f| f.runway)
        .collect();
    let (r, end) = lands[((d.next() * lands.len() as f64) as usize).min(lands.len() - 1)];
    let runway = &behaving.network.runways[r];
    let along = (runway.ends_m[1 - end] - runway.ends_m[end]).normalize();
    let aside = Vector2::new(along.y, -along.x);
    let threshold = runway.ends_m[end] + along * runway.displaced_m[end];
    let designator = ["A320", "B738", "E190", "A320"][(d.next() * 4.0) as usize % 4];
    let flight =
        scenarios::handover::flight(&scene.traffic.types, scene.control.wake, designator, callsign);
    let flight = flight.expect("a known type");
    let wild = if d.chance(0.7) { 1.0 } else { 6.0 };
    let out_m = NM * if wild > 1.0 { d.within(0.0, 14.0) } else { d.within(3.0, 9.8) };
    let beside_m = wild * d.within(-0.03, 0.03) * out_m;
    let above_m = wild * d.within(-0.1, 0.1) * SLOPE * out_m;
    let speed = flight.landing.0 * if wild > 1.0 { d.within(0.5, 2.0) } else { d.within(1.0, 1.2) };
    let turned = Azimuth::of(along).rad() + wild * d.within(-0.05, 0.05);
    let at = threshold - along * (out_m + 0.4 * flight.size.length_m) + aside * beside_m;
    let course = Azimuth::from_rad(turned).unit() * speed;
    Given {
        address: Some(0x4b_0000 + time_s as u32),
        designator: designator.into(),
        runway: d.chance(0.5).then_some((r, end)),
        stand: None,
        at_m: Point3::new(at.x, at.y, 15.0 + SLOPE * out_m + above_m),
        velocity_mps: Vector3::new(course.x, course.y, wild * d.within(-1.0, 1.0) - SLOPE * speed),
        time_s: time_s + d.within(-0.5, 0.5),
        flight,
    }
}

fn extrapolated(given: &Given, time_s: f64) -> Point3<f64> {
    given.at_m + given.velocity_mps * (time_s - given.time_s)
}

/// What came of a run.
#[derive(Default)]
struct Found {
    taken: usize,
    refused: Vec<String>,
    served: usize,
    released: usize,
    back: usize,
    jump_m: f64,
    jump_mps: f64,
    digest: u64,
}

fn touching(core: &Core, who: &BTreeMap<usize, Given>) -> Option<String> {
    let pose = |f: usize| core.state(f).filter(|s| s.position_m.z < 3.0);
    let body = |f: usize, s: &TruthState| {
        outline(core.flights()[f].size, s.position_m.xy(), s.heading_rad)
    };
    for f in who.keys() {
        let Some(own) = pose(*f) else { continue };
        for o in (0..core.flights().len()).filter(|o| o != f) {
            let Some(theirs) = pose(o).filter(|s| (s.position_m - own.position_m).norm() < 90.0)
            else {
                continue;
            };
            if distance_m(&body(*f, &own), &body(o, &theirs)) == 0.0 {
                return Some(format!(
                    "{} {}",
                    core.flights()[*f].callsign,
                    core.flights()[o].callsign
                ));
            }
        }
    }
    None
}

/// Gives somebody every `every_s` and lets go of whoever climbs away, half an hour long; then until all are served.
fn run(name: &str, scene: &Scene, seed: u64, every_s: i64) -> Found {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let first_place = behaving.flights.len();
    let dt = scene.run.frame.s();
    let mut d = Draws { seed: seed ^ 0x5eed, counter: 0 };
    let mut found = Found::default();
    let mut asked: BTreeMap<u64, (Given, i64)> = BTreeMap::new();
    let mut given: BTreeMap<usize, Given> = BTreeMap::new();
    let (mut told, mut number) = (0, 0_u64);
    let mut let_go: BTreeMap<String, TruthState> = BTreeMap::new();
    let every = (every_s as f64 / dt) as i64;
    let frames = scene.run.frames() as i64;
    for frame in 1..=frames + 72_000 {
        if frame < frames && frame % every == 0 {
            number += 1;
            let effect = frame + 4;
            // Now and then somebody who was let go comes back.
            let back = let_go.keys().next().filter(|_| d.chance(0.5)).cloned();
            let callsign = back.unwrap_or_else(|| format!("GIV{number}"));
            let wish = about_a_final(scene, &mut d, &callsign, effect as f64 * dt);
            asked.insert(number, (wish.clone(), effect));
            core.ask(effect, "bridge", number, Ask::Give(Box::new(wish)));
        }
        // Some departures are let go above the airport; most who ask too soon are told so.
        if frame % 40 == 0 && frame < frames {
            for f in (0..first_place).filter(|f| f % 2 == 0) {
                if core.phase(f) == Phase::Rolling
                    && core.state(f).is_some_and(|s| s.position_m.z > 250.0)
                {
                    number += 1;
                    let callsign = core.flights()[f].callsign.clone();
                    core.ask(frame + 4, "bridge", number, Ask::Release(callsign));
                }
            }
        }
        let before: BTreeMap<usize, TruthState> =
            given.keys().filter_map(|f| Some((*f, core.state(*f)?))).collect();
        let flying: BTreeMap<String, TruthState> = (0..first_place)
            .filter(|f| core.phase(*f) == Phase::Rolling)
            .filter_map(|f| Some((core.flights()[f].callsign.clone(), core.state(f)?)))
            .collect();
        core.step(frame);
        for outcome in &core.handovers()[told..] {
            assert_eq!(outcome.frame, frame, "{name}: in its frame");
            match (&outcome.what, asked.get(&outcome.sequence)) {
                (Ok(f), Some((wish, effect))) => {
                    assert_eq!(frame, *effect, "{name}");
                    let state = core.state(*f).expect("it is there");
                    let off_m = (state.position_m - extrapolated(wish, frame as f64 * dt)).norm();
                    let off_mps = (state.velocity_mps - wish.velocity_mps).norm();
                    found.jump_m = found.jump_m.max(off_m);
                    found.jump_mps = found.jump_mps.max(off_mps);
                    assert_eq!(core.flights()[*f].callsign, wish.flight.callsign);
                    let back = let_go.remove(&outcome.callsign).is_some();
                    found.back += usize::from(back);
                    assert_eq!(*f < first_place, back, "{name}: who comes back is who he was");
                    assert!(given.insert(*f, wish.clone()).is_none(), "{name}: a place has one");
                    // Nobody is before or behind him too near.
                    for o in (0..core.flights().len()).filter(|o| o != f) {
                        let same = core.flights()[o].runway == core.flights()[*f].runway;
                        let Some(other) =
                            core.state(o).filter(|_| same && core.phase(o) == Phase::Final)
                        else {
                            continue;
                        };
                        let apart_nm = (other.position_m - state.position_m).norm() / NM;
                        assert!(apart_nm > 3.0, "{name}: {apart_nm} NM at {frame}");
                    }
                    found.taken += 1;
                }
                (Err(why), Some(_)) => {
                    assert!(!why.is_empty());
                    found.refused.push(why.clone());
                }
                (Ok(f), None) => {
                    assert!(core.state(*f).is_none(), "{name}: it is gone in that frame");
                    let last = &flying[&outcome.callsign];
                    assert!(last.position_m.z >= RELEASED_ABOVE_M - 1.0);
                    let_go.insert(outcome.callsign.clone(), *last);
                    found.released += 1;
                }
                (Err(_), None) => {}
            }
        }
        told = core.handovers().len();
        // Nobody jumps: place by speed, speed by what is flown and braked.
        for (f, was) in &before {
            let Some(is) = core.state(*f) else { continue };
            // Above the flare, which is another line; who went around enters ten miles out again.
            let flies = [is, *was].iter().all(|s| (16.0..960.0).contains(&s.position_m.z));
            if core.phase(*f) == Phase::Final && flies {
                let moved = (is.position_m - was.position_m - was.velocity_mps * dt).norm();
                assert!(moved < 0.05, "{name}: {moved} m at {frame}");
                let gained = (is.velocity_mps - was.velocity_mps).norm() / dt;
                assert!(gained < 3.0, "{name}: {gained} m/s2 at {frame}, {}", is.position_m.z);
            }
        }
        if frame % 10 == 0 {
            let names = (0..core.flights().len()).filter(|f| core.state(*f).is_some());
            let mut names: Vec<&str> = names.map(|f| core.flights()[f].callsign.as_str()).collect();
            names.sort_unstable();
            assert!(names.windows(2).all(|w| w[0] != w[1]), "{name}: one owner");
            assert!(names.iter().all(|n| !let_go.contains_key(*n)), "{name}: let go is gone");
            assert_eq!(touching(&core, &given), None, "{name} at {frame}");
        }
        let done = |f: &usize| core.measures(*f).aibt_s.is_some();
        if frame > frames && frame % 1200 == 0 && given.keys().all(done) {
            break;
        }
    }
    let stood = given.keys().filter(|f| core.measures(**f).aibt_s.is_some()).count();
    (found.served, found.digest) = (stood, core.digest());
    assert_eq!(core.unexpected_deadlocks(), 0, "{name}");
    let waits: Vec<_> = given
        .keys()
        .filter(|f| core.measures(**f).aibt_s.is_none())
        .map(|f| (core.flights()[*f].callsign.clone(), core.phase(*f)))
        .collect();
    assert!(waits.is_empty(), "{name}: {waits:?} of {}", given.len());
    found
}

#[expect(clippy::print_stdout, reason = "figures of a law")]
fn judge(name: &str, policy: &str, seed: u64, per_h: f64, every_s: i64) -> Option<Found> {
    let scene = scene(name, seed, per_h, 40, policy)?;
    let mut flights = scene.traffic.behaving.as_ref()?.flights.iter();
    flights.find(|f| f.direction == Direction::Arrival)?;
    let found = run(name, &scene, seed, every_s);
    println!(
        "{name} {policy} seed {seed}: {} taken, {} refused, {} let go, {} back, jump {:.4} m {:.4} m/s",
        found.taken,
        found.refused.len(),
        found.released,
        found.back,
        found.jump_m,
        found.jump_mps
    );
    assert!(
        found.jump_m <= 0.05 && found.jump_mps <= 0.1,
        "{name}: {} {}",
        found.jump_m,
        found.jump_mps
    );
    Some(found)
}

#[test]
fn who_is_given_on_known_airports_lands_without_a_jump_and_is_served() {
    let (mut taken, mut back, mut reasons) = (0, 0, BTreeMap::<String, usize>::new());
    for (airport, seed) in [("LSZH", 21), ("EHAM", 22), ("LIMC", 23), ("XSYN", 24), ("LZIB", 25)] {
        let found = judge(airport, "planned", seed, 10.0, 60).expect("a known airport");
        taken += found.taken;
        back += found.back;
        for why in &found.refused {
            let word = why.split(' ').filter(|w| w.chars().all(|c| c.is_ascii_lowercase()));
            let word = word.take(6).collect::<Vec<_>>().join(" ");
            *reasons.entry(word).or_default() += 1;
        }
    }
    println!("{taken} taken, {back} back, refused {reasons:#?}");
    assert!(taken >= 20 && back >= 1, "{taken} {back}");
    assert!(reasons.len() >= 5, "{reasons:?}");
}

#[test]
fn who_is_given_on_random_airports_lands_without_a_jump_and_is_served() {
    let (mut taken, mut airports) = (0, 0);
    for seed in 300..330 {
        let policy = ["planned", "ordered"][(seed % 2) as usize];
        let Some(found) = judge(&format!("random-{seed}"), policy, seed, 6.0, 90) else { continue };
        taken += found.taken;
        airports += 1;
    }
    assert!(airports >= 20 && taken >= 60, "{airports} {taken}");
}

#[test]
fn equal_asks_give_equal_bits() {
    let digest = |_: u32| judge("LZIB", "planned", 31, 8.0, 100).expect("a known airport").digest;
    assert_eq!(digest(0), digest(1));
}

#[test]
fn places_that_nobody_could_use_are_refused() {
    let text = |more: &str, places: &str| {
        format!(
            "[run]\ntitle = \"t\"\nstart = 2019-11-24T09:00:00Z\nseed = 1\nduration_s = 600\n[airport]\nlayout = \"airports/LZIB.apt.dat\"\n{more}\n[[traffic]]\nkind = \"handover\"\n{places}\n"
        )
    };
    let traffic = "[[traffic]]\nkind = \"generated\"\narrivals_per_h = 20\n";
    let sees = format!("{traffic}[control]\nsees = \"truth\"\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let load = |text: String| scenarios::load_text(&path, &text).map_err(|e| e.to_string());
    for (more, places, words) in [
        ("", "", "with flights beside it"),
        (&sees, "", "without controllers"),
        (traffic, "count = 0", "1 to 500"),
        (traffic, "count = 501", "1 to 500"),
        (traffic, "type = \"FOLLOWME\"", "allowed is"),
        (traffic, "callsign = \"A\"", "unknown key"),
        (traffic, "[[traffic]]\nkind = \"handover\"", "handover"),
    ] {
        let why = load(text(more, places)).map(|_| ()).expect_err(words);
        assert!(why.contains(words), "{why} lacks {words}");
    }
    let scene = load(text(traffic, "type = \"A388\"\ncount = 7")).expect("a sound scene");
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    assert_eq!(behaving.places.len(), 7);
    // A place is nobody before, and the largest type can be given.
    let core = behaving.core(&scene.run, 1).expect("with truth");
    assert!((0..core.flights().len()).skip(behaving.flights.len()).all(|f| core.is_free_place(f)));
}
