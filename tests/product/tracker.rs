//! The worked example for people with a tracker of their own: a process of its own, fed live by multicast, recorded, scored.

use crate::common::{Folder, Ports, finish, free_port, stderr};
use std::process::Command;

/// The tracker in Python sees every plot once, its tracks come back recorded, and every form of the recording is scored alike.
#[test]
fn a_tracker_in_python_is_fed_recorded_and_scored() {
    if !Command::new("python3").arg("--version").output().is_ok_and(|o| o.status.success()) {
        println!("SKIPPED: python3 is not installed (apt-get install python3)");
        return;
    }
    let (ports, folder) = (Ports::new(), Folder::new("tracker"));
    let (plots, tracks) =
        (format!("239.9.1.1:{}", free_port()), format!("239.9.1.2:{}", free_port()));
    let mut command = Command::new("bash");
    command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/clients/tracker/score.sh"));
    command.args(["zurich", "40", folder.file("").trim_end_matches('/')]);
    command.env("SEEDS", env!("CARGO_BIN_EXE_seeds")).env("RATE", "4");
    command.env("PLOTS", plots).env("TRACKS", tracks).env("PORTS", flags(&ports));
    let output = finish(command);
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    let read = |name: &str| -> serde_json::Value {
        let text = std::fs::read_to_string(folder.file(name)).expect("written");
        serde_json::from_str(&text).expect("JSON")
    };
    let recorded = read("record.json");
    assert_eq!(
        (recorded["lost"].as_u64(), recorded["dropped_by_system"].as_u64()),
        (Some(0), Some(0))
    );
    let score = |form: &str| {
        let mut report = read(&format!("score-{form}.json"));
        report.as_object_mut().expect("an object").remove("title");
        report
    };
    let first = score("pcapng");
    for form in ["ast", "ff"] {
        assert_eq!(score(form), first, "{form}");
    }
    // Its tracks follow targets of the radar, within what a small filter can.
    let table = String::from_utf8(output.stdout).expect("text");
    let number = |row: &str| -> f64 {
        let line = table.lines().find(|line| line.starts_with(row)).expect(row);
        let word = line[row.len()..].split_whitespace().next().expect("a figure");
        word.parse().expect("a number")
    };
    assert!(number("tracks  ") >= 3.0, "{table}");
    assert!(number("position error of the tracks, rms") < 8.0, "{table}");
    println!("{said}{table}");
}

/// Times of day that begin anew at midnight: without a run.
#[test]
fn the_small_tracker_goes_on_at_midnight() {
    let mut command = Command::new("python3");
    command.args(["-m", "unittest", "test_tracker.py"]);
    command.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/clients/tracker"));
    match command.env("PYTHONDONTWRITEBYTECODE", "1").output() {
        Ok(output) => assert!(output.status.success(), "{}", stderr(&output)),
        Err(_) => println!("SKIPPED: python3 is not installed (apt-get install python3)"),
    }
}

fn flags(ports: &Ports) -> String {
    format!("--dis {} --sync-listen {} --page {}", ports.dis, ports.sync, ports.page)
}
