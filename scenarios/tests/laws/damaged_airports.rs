//! Traffic on real networks from which edges have been taken out: whatever is left of them, nobody touches another, drives faster
//! or brakes harder than his type, or is elsewhere than his speed allows.

use models::draw::{DrawKey, Purpose, uniform};
use scenarios::hours::{Held, Hour, hour};
use std::path::{Path, PathBuf};

/// Taken out of each airport: one edge in twenty.
const SHARE: f64 = 0.05;

/// The lines of a file without one in twenty of those that are an edge.
fn without_edges(text: &str, seed: u64, is_edge: impl Fn(usize, &str) -> bool) -> String {
    let kept = text.lines().enumerate().filter(|(n, line)| {
        let key = DrawKey { run_seed: seed, sensor: 78, entity: *n as u64, scan: 0 };
        !is_edge(*n, line) || uniform(&mut key.rng(Purpose::Mover)) >= SHARE
    });
    kept.map(|(_, line)| format!("{line}\n")).collect()
}

/// A damaged airport as files in a folder, and what a scene says of it.
fn damaged(folder: &Path, airport: &str, seed: u64) -> String {
    let ships = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("airports");
    let read = |name: &str| std::fs::read_to_string(ships.join(name)).expect("ships");
    let write = |name: &str, text: String| {
        std::fs::write(folder.join(name), text).expect("a folder for the test");
    };
    match airport {
        "LZIB" => {
            let edge = |_: usize, l: &str| l.starts_with("1202 ") && !l.contains(" runway");
            write("X.apt.dat", without_edges(&read("LZIB.apt.dat"), seed, edge));
            "layout = \"X.apt.dat\"".into()
        }
        "EGCC" => {
            write("X.nodes.csv", read("EGCC.nodes.csv"));
            write("X.edges.csv", without_edges(&read("EGCC.edges.csv"), seed, |n, _| n > 0));
            "layout = \"X.nodes.csv\"".into()
        }
        other => {
            write("X.apt.dat", read(&format!("{other}.apt.dat")));
            let net = read(&format!("{other}.groundnet.xml"));
            write("X.groundnet.xml", without_edges(&net, seed, |_, l| l.contains("<arc ")));
            "layout = \"X.apt.dat\"\nground_network = \"X.groundnet.xml\"".into()
        }
    }
}

fn run(airport: &str, seed: u64) -> Result<Held, String> {
    let name = format!("damaged-{airport}-{seed}");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
    let scene = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\n{}\n[[traffic]]\nkind = \"generated\"\n\
         arrivals_per_h = 12\ndepartures_per_h = 12\n",
        damaged(&folder, airport, seed)
    );
    let file = folder.join("scene.toml");
    std::fs::write(&file, &scene).map_err(|e| e.to_string())?;
    let scene = scenarios::load_text(&file, &scene);
    // `SEEDS_KEEP=1`: the files stay where they were read.
    if std::env::var_os("SEEDS_KEEP").is_none() {
        std::fs::remove_dir_all(&folder).map_err(|e| e.to_string())?;
    }
    let scene = scene.map_err(|e| e.to_string())?;
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
    let looks = Hour { seed, every: 4, drain_s: 3600.0, stopping: 0.3 };
    let step = |core: &mut models::traffic::core::Core, frame| core.step(frame);
    hour(behaving, &scene.run, &scene.airport.layout, &looks, step).ok_or("without truth".into())
}

/// How many of each airport: `SEEDS_AIRPORTS=from..to` for more of them.
fn seeds() -> std::ops::Range<u64> {
    let asked = std::env::var("SEEDS_AIRPORTS").ok();
    let parts = asked.as_deref().and_then(|a| a.split_once(".."));
    let numbers = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.map_or(1..3, |(a, b)| a..b)
}

/// What nobody may do, however little is left of the network.
const ALWAYS: [&str; 9] = [
    "overlaps",
    "gridlocks",
    "holds",
    "clearances",
    "runways",
    "wake",
    "speeds",
    "accelerations",
    "teleports",
];

/// Two runways that are crossed one soon after the other: each crossing has its clearance until the tail is off that runway. When the
/// second was given before the first had ended, it ended with the first, and four came into a strip without one.
#[test]
fn who_crosses_two_runways_is_cleared_for_each_until_he_is_off_it() {
    for seed in [9, 19] {
        let held = run("EGCC", seed).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let holds = held.rows.iter().find(|r| r.name == "holds").expect("a row");
        assert!(holds.kept && holds.of > 20, "{seed}: {:?}", holds.cases);
        let crossings = held.core.clearances().iter().filter(|c| c.kind == "CRO");
        let long = crossings.filter(|c| c.until_s.is_some_and(|t| t - c.from_s > 10.0)).count();
        assert!(long >= 10, "{seed}: {long}");
    }
}

/// A threshold that is displaced by 566 m leaves less of the runway to brake: who cannot brake to the last exit that leads to a
/// stand is not drawn for it. Two of 17 never were released to final.
#[test]
fn landings_that_are_drawn_can_brake_behind_a_displaced_threshold() {
    let held = run("EHAM", 18).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(held.core.measures_of_served(), held.core.flights().len());
    assert!(held.core.flights().len() >= 8, "{}", held.core.flights().len());
}

#[test]
fn networks_without_some_of_their_edges_keep_the_limits() {
    let mut broken = Vec::new();
    let (mut looked_at, mut flights, mut served) = (0, 0, 0);
    for airport in ["EHAM", "EGCC", "LSZH", "LIMC", "LZIB"] {
        for seed in seeds() {
            let held = match run(airport, seed) {
                Ok(held) => held,
                // A runway that leads nowhere any more: said so.
                Err(said) => {
                    if !said.contains("is long enough for") && !said.contains("with a way") {
                        broken.push(format!("{airport} {seed}: {said}"));
                    }
                    continue;
                }
            };
            looked_at += 1;
            flights += held.core.flights().len();
            served += held.core.measures_of_served();
            let rows = held.rows.iter().filter(|r| !r.kept && ALWAYS.contains(&r.name));
            broken.extend(
                rows.map(|r| format!("{airport} {seed}: {} {}: {:?}", r.name, r.value, r.cases)),
            );
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(looked_at > 0 && 20 * served >= 19 * flights, "{served} of {flights} flights served");
}
