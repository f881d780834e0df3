//! `seeds reference`: the trajectories of a finished run out of its log alone, with their score where the log has the truth.

use crate::common::{Folder, Ports, finish, run, seeds, stderr};
use serde_json::Value;
use std::collections::BTreeSet;

/// Of a run of the scene at Zurich, recorded by the product itself: as near as the same smoother is on plots that never left the
/// process (`studies::reference`), and the same text from the same log.
#[test]
fn the_reference_of_a_recorded_run_is_nearer_than_what_was_published() {
    let folder = Folder::new("reference");
    let (report, table) = (folder.file("report"), folder.file("reference.csv"));
    let arguments = ["--fast", "--seed", "907", "--duration", "300", "--report", &report];
    let done = finish(run(&Ports::new(), &arguments));
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let database = format!("{report}/run.sqlite");
    let reference = |more: &[&str]| {
        let done = finish({
            let mut command = seeds();
            command.args(["reference", &database]).args(more);
            command
        });
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        String::from_utf8(done.stdout).expect("text")
    };
    let said = reference(&["--json", "-o", &table]);
    let found: Value = serde_json::from_str(&said).expect("JSON");
    let score = |part: &str, which: &str, key: &str| {
        found["score"][part][which][key]
            .as_f64()
            .unwrap_or_else(|| panic!("{part} {which}: {said}"))
    };
    // Published by `paper`, as the scene ships; the reference knows more of echoes, and what came later.
    let (published, own) =
        (score("published", "all", "rmse_m"), score("reference_then", "all", "rmse_m"));
    assert!(own <= 0.6 * published && own <= 2.2, "{published} m, reference {own} m");
    assert!(score("every_point", "all", "count") > 1_000.0, "{said}");
    let nees = score("every_point", "all", "nees");
    assert!((1.0..=3.0).contains(&nees), "{nees}");
    assert_eq!((&found["score"]["far"], &found["unsound"]), (&Value::from(0), &Value::from(0)));
    // The radar of the scene has no errors, and none is found.
    let [site] = &found["sites"].as_array().expect("radars")[..] else { panic!("{said}") };
    assert!(site["range_m"]["value"].as_f64().is_some_and(|m| m.abs() <= 0.8), "{site}");

    // The table holds a line a target and scan, of the targets that the report names.
    let lines = std::fs::read_to_string(&table).expect("written");
    let ways = found["trajectories"].as_array().expect("trajectories");
    let points: u64 = ways.iter().filter_map(|w| w["points"].as_u64()).sum();
    assert_eq!(lines.lines().count() as u64, points + 1);
    let heads: Vec<&str> = lines.lines().next().expect("heads").split(',').collect();
    let column = |name: &str| heads.iter().position(|h| *h == name).expect("a head");
    let (track, callsign) = (column("track"), column("callsign"));
    let named: BTreeSet<&str> = lines
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(callsign).expect("a field"))
        .filter(|name| !name.is_empty())
        .collect();
    assert!(
        named.contains("FOLLOW1") && named.contains("CAI3208"),
        "what reports itself: {named:?}"
    );
    let tracks: BTreeSet<&str> =
        lines.lines().skip(1).map(|line| line.split(',').nth(track).expect("a field")).collect();
    assert_eq!(tracks.len(), ways.len());

    // For a person, twice the same; another scene's sensors are assumed where they are asked for.
    let text = reference(&[]);
    assert_eq!(text, reference(&[]), "pure of the log");
    assert!(text.contains("ASDE tower: range"), "{text}");
    assert!(text.lines().next().is_some_and(|l| l.starts_with(&format!("{} traj", ways.len()))));
    assert_eq!(text, reference(&["--scene", "zurich"]));
}
