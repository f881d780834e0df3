//! What scenes give, to the bit: a change that was not meant to change a result shows here, with its scene.
//!
//! Meant ones: `SEEDS_WRITE_DIGESTS=1 cargo test --release --test product digests` writes the table anew, and the commit says why.

use crate::common::{Folder, Ports, finish, run, stderr, summary};
use crate::scene_keys::{scenes, shipped, written};
use std::fmt::Write;
use std::path::Path;

/// Those that ship under every profile, and those that keys are tried in: other sensors, levels, weather and control.
fn all() -> Vec<(String, toml::Table)> {
    let mut all = Vec::new();
    for name in ["zurich", "asmgcs", "xsyn", "eham", "egcc"] {
        for profile in ["paper", "accurate", "bulk"] {
            let mut scene = shipped(name);
            let tracking = scene["tracking"].as_table_mut().expect("a table");
            tracking.insert("profile".to_owned(), profile.into());
            all.push((format!("{name} {profile}"), scene));
        }
    }
    all.extend(scenes());
    all
}

#[test]
fn scenes_give_the_bits_of_the_table() {
    let folder = Folder::new("digests");
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/digests.csv");
    let mut made = "scene,plots,digest,track_digest\n".to_owned();
    // Of a mutant (`tests/mutants/draw`) one difference is enough.
    let mutant = std::env::var_os("SEEDS_MUTANT").is_some();
    let before = std::fs::read_to_string(&table).unwrap_or_default();
    for (number, (name, scene)) in all().iter().enumerate() {
        let file = written(&folder, number, scene);
        let seconds = scene["run"]["duration_s"].as_integer().expect("seconds").min(600);
        let seconds = seconds.to_string();
        let arguments = [&file, "--fast", "--no-viewer", "--in-process", "--duration", &seconds];
        let output = finish(run(&Ports::new(), &arguments));
        assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
        let said = summary(&output);
        let plots = said["plots"].as_object().expect("by kind").values();
        let plots: u64 = plots.map(|n| n.as_u64().unwrap_or(0)).sum();
        let bits = |key: &str| said[key].as_str().expect("a digest").to_owned();
        let line = format!("{name},{plots},{},{}", bits("digest"), bits("track_digest"));
        assert!(!mutant || before.lines().any(|l| l == line), "now: {line}");
        let _ = writeln!(made, "{line}");
    }
    if std::env::var_os("SEEDS_WRITE_DIGESTS").is_some() {
        std::fs::write(&table, &made).expect("written");
    }
    let kept = std::fs::read_to_string(&table).expect("tests/data/digests.csv");
    let only_in = |one: &str, other: &str| {
        one.lines().filter(|line| !other.lines().any(|o| o == *line)).collect::<Vec<_>>().join("\n")
    };
    assert!(made == kept, "now:\n{}\nbefore:\n{}", only_in(&made, &kept), only_in(&kept, &made));
}
