//! BlueSky beside a run: what the bridge makes of what it said once, and (ignored: it takes BlueSky and minutes) a real one.

use crate::common::{
    Background, Folder, Ports, SOON, finish, free_port, operate, run, stderr, summary, wait_for,
};
use crate::peers::{python, skipped};
use serde_json::Value;
use std::process::Command;

const BRIDGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/bluesky");
const CLIENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/python/src");

/// A Python program of the bridge's folder.
fn program(python: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(python);
    command.args(arguments).current_dir(format!("{BRIDGE}/tests"));
    command.env("PYTHONPATH", CLIENT).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// What ours are told as, its clocks, and logs that are none: without a run.
#[test]
fn the_bridge_alone() {
    let Some(python) = python("unittest") else {
        return skipped("python3", "apt-get install python3");
    };
    let output = finish(program(&python, &["-m", "unittest", "test_bridge.py"]));
    assert!(output.status.success(), "{}", stderr(&output));
}

/// Twelve seconds of a real BlueSky in a run at twice real time: its two aircraft are there as what they are, go as fast as they go there, stand while it
/// is held (seconds 13 to 15), and are gone with its RESET; the run itself is what it is alone.
#[test]
fn bluesky_as_it_was_recorded_is_in_the_run() {
    let Some(python) = python("zenoh") else {
        return skipped("eclipse-zenoh for Python", "clients/python/install.sh");
    };
    let (ports, folder) = (Ports::new(), Folder::new("bluesky-recorded"));
    let (public, recording) = (format!("tcp/127.0.0.1:{}", free_port()), folder.file("run.pcapng"));
    let same = ["zurich", "--duration", "30", "--seed", "7", "--no-viewer"];
    let mut command = run(&ports, &same);
    command.args(["--rate", "2", "--visitors", "--wait", "--record", &recording]);
    command.arg(format!("--public={public}"));
    let mut going = Background::start(command);
    let log = folder.file("again.jsonl");
    let said = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/bluesky/zurich.jsonl");
    let mut bridge = program(&python, &[&format!("{BRIDGE}/bridge.py"), "--endpoint", &public]);
    bridge.args(["--dis", &ports.dis, "--elevation", "432", "--replay", said, "--log", &log]);
    let listens = || std::net::TcpStream::connect(public.trim_start_matches("tcp/")).ok();
    assert!(wait_for(SOON, listens).is_some(), "the public interface");
    let bridge = Background::start(bridge);
    // It has heard that the run waits.
    let heard = || std::fs::read_to_string(&log).ok().filter(|text| text.contains("HOLD"));
    assert!(wait_for(SOON, heard).is_some(), "the bridge");
    let started = || operate(&ports, &["start"]).0.then_some(());
    assert!(wait_for(SOON, started).is_some(), "it starts once all are there");
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "it ends in order");
    drop(bridge);
    let text = std::io::read_to_string(stdout).expect("its words");
    let over: Value =
        serde_json::from_str(text.trim().lines().last().expect("a summary")).expect("JSON");
    let alone = finish(run(&Ports::new(), &[&same[..], &["--fast"]].concat()));
    assert_eq!(over["digest"], summary(&alone)["digest"], "it changes nothing");

    let database = rusqlite::Connection::open(folder.file("run.sqlite")).expect("the database");
    let mut rows = database
        .prepare("SELECT scan, callsign, type, x_m, y_m, vx_ms, vy_ms FROM truth WHERE ours = 0")
        .expect("sound");
    let rows: Vec<(i64, String, String, [f64; 4])> = rows
        .query_map([], |r| {
            Ok((r.get(0)?, r.get(1)?, r.get(2)?, [r.get(3)?, r.get(4)?, r.get(5)?, r.get(6)?]))
        })
        .and_then(Iterator::collect)
        .expect("rows");
    for (name, kind) in [("BS001", "A320"), ("BS010", "B744")] {
        let own: Vec<_> = rows.iter().filter(|row| row.1 == name).collect();
        let of = |scan: i64| own.iter().find(|row| row.0 == scan).map(|row| row.3);
        for scan in 6..13 {
            let row = own.iter().find(|row| row.0 == scan);
            assert_eq!(row.map(|row| &row.2[..]), Some(kind), "{name} in scan {scan}");
            let [_, _, vx, vy] = of(scan).expect("there");
            let speed = libm::hypot(vx, vy);
            assert!((speed - 122.8).abs() < 12.0, "{name} goes at {speed} m/s in scan {scan}");
        }
        let ([x0, y0, ..], [x1, y1, ..]) = (of(6).expect("there"), of(12).expect("there"));
        let mean = libm::hypot(x1 - x0, y1 - y0) / 6.0;
        assert!((mean - 122.8).abs() < 12.0, "{name} went at {mean} m/s");
        let [_, _, vx, vy] = of(14).expect("held, and there");
        assert_eq!([vx, vy], [0.0, 0.0], "{name} is held");
        assert_eq!(of(19), None, "{name} is gone with the RESET");
    }
}

/// A real headless BlueSky in a namespace of its own, since it listens on all interfaces: both pictures, and what happens to it while the run goes on.
#[test]
#[ignore = "needs BlueSky and a minute; named in CONTRIBUTING.md"]
fn bluesky_shows_ours_and_its_aircraft_are_visitors() {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/bluesky/.venv/bin/python");
    let named = std::env::var("SEEDS_BLUESKY_PYTHON").unwrap_or_else(|_| own.to_owned());
    let imports = "import bluesky, zmq, msgpack, seeds_client, zenoh";
    let there = Command::new(&named).args(["-c", imports]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        return skipped("BlueSky", "clients/bluesky/install.sh");
    }
    let folder = Folder::new("bluesky");
    let scene = folder.file("cars.toml");
    std::fs::write(&scene, cars(200)).expect("written");
    let mut command = Command::new("unshare");
    command.args(["-rn", &named, &format!("{BRIDGE}/check.py")]);
    command.args([env!("CARGO_BIN_EXE_seeds"), &scene, folder.file("").trim_end_matches('/')]);
    let output = finish(command);
    assert!(output.status.success(), "{}", stderr(&output));
    let found = summary(&output);
    println!("{found}");
    for key in [
        "whole",
        "same_digest",
        "theirs",
        "goes_on_after_hold",
        "whole_after_reset",
        "theirs_after_reset",
        "deleted_comes_again",
        "node_again",
        "whole_after_node",
        "whole_after_server",
    ] {
        assert_eq!(found[key], true, "{key}: {found}");
    }
    assert_eq!(
        (&found["run_code"], &found["summary"]["faults"]),
        (&0.into(), &Value::Array(vec![]))
    );
    assert_eq!(found["bridge"]["damaged"], 0, "{found}");
}

/// Zurich with cars alone.
fn cars(count: usize) -> String {
    let zurich =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/zurich.toml"))
            .expect("the scene");
    let (before, rest) = zurich.split_once("[[traffic]]").expect("traffic");
    let (_, after) = rest.split_once("[[sensor]]").expect("sensors");
    let ends = ["Terminal_A_Gate_48", "D_57", "GAC_S1_A", "I_98", "Gate_B_38"];
    let mut text = before.to_owned();
    for i in 0..count {
        text += &format!(
            "[[traffic]]\nkind = \"route\"\ncallsign = \"CAR{i}\"\ntype = \"FOLLOWME\"\naddress = {}\nvia = [\"{}\", \"{}\"]\nstart_s = {}\nflight = {{ movement = \"vehicle\" }}\n\n",
            0x4b_8000 + i,
            ends[i % 5],
            ends[(i + 1 + i / 5 % 4) % 5],
            (i % 20) as f64 * 0.9
        );
    }
    let text = text + "[[sensor]]" + after;
    text.replace("\"CAI3208\"", "\"CAR0\"").replace("\"FOLLOW1\", \"FIRE1\"", "\"CAR1\"")
}
