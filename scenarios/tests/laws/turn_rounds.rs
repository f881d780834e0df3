//! Schedules: turn-rounds whatever the order of the rows, and slots of sequences.

use models::traffic::core::Core;
use scenarios::Scene;
use scenarios::error::ScenarioError;
use std::path::Path;

const HEADER: &str = "callsign,address,type,movement,runway,stand,tobt,ctot,eldt,turnaround_of";

/// A run from 06:00 on of a table with these rows.
fn load(name: &str, rows: &[&str], control: &str) -> Result<Scene, ScenarioError> {
    let file = std::env::temp_dir().join(format!("seeds-turns-{}-{name}.csv", std::process::id()));
    std::fs::write(&file, format!("{HEADER}\n{}\n", rows.join("\n"))).expect("written");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 1\nstart = 2026-05-12T06:00:00Z\nduration_s = 7200\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
         [[traffic]]\nkind = \"schedule\"\nfile = \"{}\"\n{control}",
        file.display()
    );
    let scene = scenarios::load_text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("t.toml"), &text);
    std::fs::remove_file(&file).ok();
    scene
}

const LANDS: &str = "AAA1,400001,A320,arrival,09,C1,,,2026-05-12T06:10:00Z,";
const LANDED: &str = "AAA0,400005,A320,arrival,09,C2,,,2026-05-12T05:30:00Z,";
const LEAVES: &str = "AAA2,400001,A320,departure,09,C1,2026-05-12T07:00:00Z,,,AAA1";

/// By callsign: the callsign whose aircraft it is.
fn turn_rounds(scene: &Scene) -> Vec<(String, String)> {
    let flights = &scene.traffic.behaving.as_ref().expect("behaves").flights;
    let of = |f: &models::traffic::core::Flight| {
        Some((f.callsign.clone(), flights[f.turnaround_of?].callsign.clone()))
    };
    flights.iter().filter_map(of).collect()
}

#[test]
fn a_turn_round_is_found_in_any_order_of_the_rows() {
    let other = "BBB1,400003,B738,arrival,09,C3,,,2026-05-12T06:20:00Z,";
    let expected = [("AAA2".to_owned(), "AAA1".to_owned())];
    for (n, rows) in
        [[LANDS, other, LEAVES], [LEAVES, other, LANDS], [other, LEAVES, LANDS]].iter().enumerate()
    {
        let scene = load(&format!("order-{n}"), rows, "").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(turn_rounds(&scene), expected, "{rows:?}");
    }
}

#[test]
fn a_turn_round_that_nobody_knows_or_two_have_is_refused_with_its_line() {
    let unknown = LEAVES.replace("Z,,,AAA1", "Z,,,AAA7");
    let said =
        load("unknown", &[LANDS, &unknown], "").map(|_| ()).expect_err("unknown").to_string();
    assert!(said.contains("csv:3: turnaround_of:") && said.contains("AAA7"), "{said}");
    let twice = LEAVES.replace("AAA2", "AAA3").replace("400001", "400009").replace(",C1,", ",C4,");
    for (n, rows) in [[LANDS, LEAVES, &twice], [LEAVES, &twice, LANDS]].iter().enumerate() {
        let said =
            load(&format!("twice-{n}"), rows, "").map(|_| ()).expect_err("twice").to_string();
        let (line, first) = (4 - n, 3 - n);
        assert!(said.contains(&format!("csv:{line}: turnaround_of:")), "{said}");
        assert!(said.contains(&format!("first in line {first}")), "{said}");
    }
    // Who has landed before the run stands on his stand: nothing is wrong with that.
    let over = LEAVES.replace("Z,,,AAA1", "Z,,,AAA0");
    let scene = load("over", &[LANDED, &over], "").unwrap_or_else(|e| panic!("{e}"));
    assert!(turn_rounds(&scene).is_empty());
    // Another type is another aircraft, which is said.
    let other = LEAVES.replace("A320", "B738");
    let scene = load("type", &[LANDS, &other], "").unwrap_or_else(|e| panic!("{e}"));
    let remarks = &scene.traffic.behaving.as_ref().expect("behaves").remarks;
    assert!(
        turn_rounds(&scene).is_empty() && remarks.iter().any(|r| r.contains("AAA2")),
        "{remarks:?}"
    );
}

/// By a sequence a slot is kept within five minutes before and ten behind it, and nobody else waits for it; who comes first is served
/// first whatever his slot (traffic.md 8.3 has slots in the sequence alone).
#[test]
fn a_slot_is_kept_by_a_sequence() {
    for control in ["", "[control]\nsequence = \"first\"\n", "[control]\nsequence = \"cps\"\n"] {
        let slot = "AAA1,400001,A320,departure,09,C1,2026-05-12T06:15:00Z,2026-05-12T07:00:00Z,,";
        let free = "AAA2,400002,A320,departure,09,C3,2026-05-12T06:16:00Z,,,";
        let name = format!("slot-{}", control.len());
        let scene = load(&name, &[slot, free], control).unwrap_or_else(|e| panic!("{e}"));
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let mut core: Core = behaving.core(&scene.run, 1).expect("truth");
        (0..7200 * 20_i64).for_each(|frame| core.step(frame));
        let [slot_s, free_s] = [0, 1].map(|f| core.measures(f).atot_s.expect("takes off"));
        let slot = if control.contains("cps") { 3300.0..=4200.0 } else { 900.0..=1800.0 };
        assert!(slot.contains(&slot_s), "{control}: at {slot_s} s");
        assert!(free_s < 2400.0, "{control}: the other one at {free_s} s");
    }
}
