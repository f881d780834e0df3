//! Places of producers that are given to other processes by command: the run is that in which nobody was moved.

use crate::common::{
    self, Background, Folder, Ports, SOON, finish, operate, run, summary, wait_for,
};
use serde_json::Value;

/// Process of a member that lives, and the frame that it has executed.
fn member(ports: &Ports, name: &str) -> Option<(u64, u64)> {
    let status = common::status(ports)?;
    let members = status["state"]["members"].as_array()?.clone();
    let member = members.into_iter().find(|m| m["name"] == name && m["alive"] == true)?;
    Some((member["pid"].as_u64()?, member["frame"].as_u64()?))
}

/// One generator goes to the external world's process, whose own place goes to the other generator's, and on from there. Behaving traffic under
/// controllers on tracks: what is moved reads others. A process without a place is over; one that has taken another's stays.
#[test]
fn places_go_from_process_to_process_in_a_closed_loop() {
    let folder = Folder::new("moves");
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let scene = folder.file("loop.toml");
    let text = format!(
        "[run]\ntitle = \"moves\"\nseed = 41\nduration_s = 150\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 30\ndepartures_per_h = 60\n\
         [control]\nsees = \"tracks\"\ncontrollers = \"model\"\n"
    );
    std::fs::write(&scene, text).expect("a scene");
    let undisturbed = finish(run(&Ports::new(), &[&scene, "--in-process", "--fast"]));
    let ports = Ports::new();
    let arguments = [&scene[..], "--rate", "4", "--no-viewer", "--generators", "2"];
    let mut command = run(&ports, &arguments);
    command.args(["--on-loss", "takeover", "--stall-ms", "20000", "--return-ms", "60000"]);
    let mut going = Background::start(command);
    let (one, two, world) = ("traffic-generator-1", "traffic-generator-2", "external-world");
    let after = |name: &str, frame: u64| {
        let there = || member(&ports, name).filter(|(_, at)| *at > frame);
        wait_for(SOON, there).unwrap_or_else(|| panic!("{name}: {:?}", common::status(&ports)))
    };
    let (first, _) = after(one, 40);
    let (second, _) = after(two, 40);
    let (third, frame) = after(world, 40);
    for (name, to, pid) in [(one, world, third), (world, two, second), (one, two, second)] {
        let (ok, words) = operate(&ports, &["move", name, to]);
        assert!(ok, "{words}");
        let moved = || member(&ports, name).filter(|(of, at)| *of == pid && *at > frame);
        assert!(wait_for(SOON, moved).is_some(), "{name} to {to}: {:?}", common::status(&ports));
        let (again, words) = operate(&ports, &["move", name, to]);
        assert!(!again && words.contains("already"), "{words}");
    }
    let status = common::status(&ports).expect("a run");
    let movable = |name: &str| {
        let members = status["state"]["members"].as_array().expect("members");
        members.iter().find(|m| m["name"] == name).map(|m| m["movable"] == true)
    };
    assert_eq!([one, world, "smdfm"].map(movable), [Some(true), Some(true), Some(false)]);
    let gone = |pid: u64| {
        wait_for(SOON, || (!std::path::Path::new(&format!("/proc/{pid}")).exists()).then_some(()))
    };
    assert!(gone(first).is_some(), "its only place went");
    assert!(gone(third).is_some(), "its own place went, and then the one that it had taken");
    let (ok, words) = operate(&ports, &["move", "smdfm", two]);
    assert!(!ok && words.contains("not a place that can be moved"), "{words}");
    assert!(operate(&ports, &["rate", "fast"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let over: Value =
        serde_json::from_str(text.trim().lines().last().expect("a summary")).expect("JSON");
    let alone = summary(&undisturbed);
    for key in ["digest", "track_digest"] {
        assert_eq!(over[key], alone[key], "{key}");
    }
    assert_eq!(over["faults"], Value::Array(Vec::new()));
}

/// What moving by load needs is asked for before anything is started.
#[test]
fn balance_without_takeover_is_refused() {
    for command in ["run", "admin-station"] {
        let mut balance = common::seeds();
        balance.args([command, "--balance"]);
        balance.args(if command == "run" { &["zurich"][..] } else { &["--scene", "zurich"] });
        let output = finish(balance);
        let said = common::stderr(&output);
        assert_ne!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("--on-loss takeover"), "{said}");
    }
}
