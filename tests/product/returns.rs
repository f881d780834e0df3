//! Return as processes: whoever is killed is started again by hand, with an outsider there and controllers who clear on tracks, and
//! the run is the one in which nothing happened. And what is said where the log of the run finds no room.

use crate::common;

use crate::common::{Background, Folder, Ports, SOON, finish, operate, run, summary, wait_for};
use geodesy::{Enu, Geodetic, LocalFrame};
use pdu::enumerations::DeadReckoningAlgorithm;
use pdu::records::{EntityId, EntityType, Marking};
use pdu::{DisTime, EntityState, Envelope};
use serde_json::Value;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Entities of somebody else's simulator, ten reports a second each, 5 km and more from the airport and off its approaches.
struct Guests(Arc<AtomicBool>, Option<std::thread::JoinHandle<()>>);

impl Guests {
    fn of(ports: &Ports, airport: Geodetic, number: u16) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (stop, to) = (Arc::clone(&over), ports.dis.clone());
        let thread = std::thread::spawn(move || {
            let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
            socket.set_broadcast(true).expect("broadcast");
            let airport = LocalFrame::at(airport);
            while !stop.load(Ordering::Relaxed) {
                for entity in 1..=number {
                    let here =
                        Enu { east_m: 5_000.0 + 40.0 * f64::from(entity), north_m: 0.0, up_m: 0.0 };
                    let state = EntityState {
                        entity_id: EntityId::new(900, 9, entity),
                        entity_type: EntityType::new(1, 1, 225, 85, 0, 0, 0),
                        location: airport.to_ecef(here).into(),
                        dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
                        marking: Marking::new("GUEST").expect("short"),
                        ..EntityState::default()
                    };
                    let mut octets = Vec::new();
                    let now = federates::runtime::clock::utc_ns();
                    let envelope = Envelope::new(1, DisTime::absolute(now as u64));
                    envelope.append(&state, &mut octets).expect("fits");
                    let _ = socket.send_to(&octets, &to);
                }
                std::thread::sleep(Duration::from_millis(100));
            }
        });
        Self(over, Some(thread))
    }
}

impl Drop for Guests {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        if let Some(thread) = self.1.take() {
            let _ = thread.join();
        }
    }
}

/// Traffic, sensors, tracks, controllers on these tracks, and back: the closed loop, with a person at the apron who asks for what
/// cannot be and leaves, and another one who drives a car up and down all the time. The scene and their inputs.
fn closed_loop(folder: &Folder) -> (String, String) {
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let scene = folder.file("loop.toml");
    let text = format!(
        "[run]\ntitle = \"returns\"\nseed = 23\nduration_s = 240\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 20\ndepartures_per_h = 60\n\
         [[traffic]]\nkind = \"driven\"\ncallsign = \"FOLLOW1\"\ntype = \"FOLLOWME\"\nstand = \"GA_Ramp_14\"\n\
         [control]\nsees = \"tracks\"\ncontrollers = \"model\"\n"
    );
    std::fs::write(&scene, text).expect("a scene");
    let inputs = folder.file("inputs.jsonl");
    let line = |frame: u64, action: &str, more: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"apron\",\"person\":\"anna\",\"action\":\"{action}\"{more}}}\n"
        )
    };
    let mut said = line(20, "take", "");
    for frame in (100..1500).step_by(300) {
        said += &line(frame, "say", ",\"callsign\":\"NOBODY\",\"clearance\":\"PSH\"");
    }
    said += &line(1600, "leave", "");
    let mut drives = |frame: u64, action: &str, wish: &str| {
        said += &format!(
            "{{\"frame\":{frame},\"seat\":\"driver FOLLOW1\",\"person\":\"ben\",\"action\":\"{action}\",\"clearance\":\"{wish}\"}}\n"
        );
    };
    drives(40, "take", "");
    for frame in (60..4700).step_by(15) {
        let wish = if frame / 200 % 2 == 0 { "250 0 60" } else { "-400 0 -60" };
        drives(frame, "drive", wish);
    }
    std::fs::write(&inputs, said).expect("inputs");
    (scene, inputs)
}

fn lzib() -> Geodetic {
    Geodetic::from_degrees(48.170, 17.213, 133.0)
}

fn members(ports: &Ports) -> Option<Vec<Value>> {
    Some(common::status(ports)?["state"]["members"].as_array()?.clone())
}

fn is_in(ports: &Ports, phase: &str) -> bool {
    common::status(ports).is_some_and(|status| status["state"]["phase"] == phase)
}

/// The living process that is `name` in this run, and the frame that it has executed.
fn alive(ports: &Ports, name: &str) -> Option<(i32, u64)> {
    let members = members(ports)?;
    let member = members.iter().find(|m| m["name"] == name && m["alive"] == true)?;
    Some((member["pid"].as_i64()? as i32, member["frame"].as_u64().unwrap_or(0)))
}

/// Starts federate `name` of a run by hand.
fn start(ports: &Ports, scene: &str, name: &str) -> Background {
    let mut command = common::seeds();
    command.args([name, "--scene", scene, "--sync-connect", &ports.sync, "--dis", &ports.dis]);
    common::patient(&mut command);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Background(command.spawn().expect("it starts"))
}

/// Kills each set of federates, one after the other within a third of a second, starts them again, and goes on: the run's summary.
fn with_losses(scene: &str, inputs: &str, sets: &[&[&str]]) -> Value {
    let ports = Ports::new();
    let arguments = [scene, "--rate", "4", "--no-viewer", "--inputs", inputs];
    let mut command = run(&ports, &arguments);
    command.args(["--return-ms", "none", "--stall-ms", "10000"]);
    let mut going = Background::start(command);
    let guests = Guests::of(&ports, lzib(), 3);
    let inside = || {
        let status = common::status(&ports)?;
        let inside = status["measures"]["outsiders_now"].as_f64()? >= 3.0;
        (inside && status["state"]["phase"] == "RUNNING").then_some(())
    };
    assert!(wait_for(SOON, inside).is_some(), "guests: {:?}", common::status(&ports));
    let mut started = Vec::new();
    for set in sets {
        let found =
            |name: &&str| wait_for(SOON, || alive(&ports, name)).expect("a living member").0;
        let pids: Vec<i32> = set.iter().map(found).collect();
        for pid in &pids {
            common::kill("KILL", *pid);
            std::thread::sleep(Duration::from_millis(100));
        }
        let missed = || {
            let gone = set.iter().all(|name| alive(&ports, name).is_none());
            (gone && is_in(&ports, "FROZEN")).then_some(())
        };
        assert!(wait_for(SOON, missed).is_some(), "{set:?}: {:?}", common::status(&ports));
        started.extend(set.iter().map(|name| start(&ports, scene, name)));
        let back = |name: &str| {
            let (pid, frame) = alive(&ports, name)?;
            (!pids.contains(&pid) && is_in(&ports, "RUNNING")).then_some(frame)
        };
        for name in *set {
            let at = wait_for(SOON, || back(name));
            let at = at.unwrap_or_else(|| panic!("{name}: {:?}", common::status(&ports)));
            let on = wait_for(SOON, || back(name).filter(|frame| *frame > at + 40));
            assert!(on.is_some(), "{name} goes on: {:?}", common::status(&ports));
        }
    }
    drop(guests);
    assert!(operate(&ports, &["rate", "fast"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    serde_json::from_str(line).expect("JSON")
}

fn comes_back(name: &str, sets: &[&[&str]]) {
    let folder = Folder::new(name);
    let (scene, inputs) = closed_loop(&folder);
    let command = run(&Ports::new(), &[&scene, "--in-process", "--fast", "--inputs", &inputs]);
    let undisturbed = summary(&finish(command));
    let found = with_losses(&scene, &inputs, sets);
    for key in ["digest", "track_digest", "frames"] {
        assert_eq!(found[key], undisturbed[key], "{key}: {found}");
    }
    assert_eq!(found["external"], true, "outsiders were in it: {found}");
    let faults: Vec<&str> =
        found["faults"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(faults.iter().all(|fault| fault.contains("back after")), "{faults:?}");
    for lost in sets.concat() {
        assert!(faults.iter().any(|fault| fault.starts_with(lost)), "{lost}: {faults:?}");
    }
}

#[test]
fn a_killed_smdfm_control_and_generator_each_return_to_the_same_run() {
    comes_back("returns-one", &[&["smdfm"], &["control"], &["traffic-generator"]]);
}

#[test]
fn two_that_are_killed_within_half_a_second_return_to_the_same_run() {
    comes_back("returns-two", &[&["smdfm", "control"], &["control", "traffic-generator"]]);
}

/// The station itself is killed, alone and with a federate within a tenth of a second, with outsiders there, a person who drives and
/// controllers on tracks; its launcher starts it again with its journal, and the run is the one in which nothing happened.
#[test]
fn a_killed_station_goes_on_with_its_run_and_so_it_does_with_others_killed_beside_it() {
    let folder = Folder::new("returns-station");
    let (scene, inputs) = closed_loop(&folder);
    let command = run(&Ports::new(), &[&scene, "--in-process", "--fast", "--inputs", &inputs]);
    let undisturbed = summary(&finish(command));
    let ports = Ports::new();
    let mut command = run(&ports, &[&scene, "--rate", "4", "--no-viewer", "--inputs", &inputs]);
    command.args(["--on-loss", "takeover", "--return-ms", "none", "--stall-ms", "10000"]);
    command.env("TMPDIR", &folder.0);
    let mut going = Background::start(command);
    let guests = Guests::of(&ports, lzib(), 3);
    let goes_on = |beyond: u64| {
        let status = common::status(&ports)?;
        let frame = status["state"]["frame"].as_u64().filter(|frame| *frame > beyond)?;
        let inside = status["measures"]["outsiders_now"].as_f64()? >= 3.0;
        (inside && status["state"]["phase"] == "RUNNING").then_some(frame)
    };
    let station = || {
        let ours = common::processes(&format!("--sync-listen {}", ports.sync));
        let stations = common::processes("seeds admin-station --scene");
        let found: Vec<i32> = stations.into_iter().filter(|pid| ours.contains(pid)).collect();
        (found.len() == 1).then(|| found[0])
    };
    let mut frame = wait_for(SOON, || goes_on(40)).expect("guests are in");
    for set in [&[][..], &["smdfm"], &["control"]] {
        let dead = wait_for(SOON, station).expect("a station");
        let others: Vec<i32> = set
            .iter()
            .map(|name| wait_for(SOON, || alive(&ports, name)).expect("alive").0)
            .collect();
        for pid in [dead].iter().chain(&others) {
            common::kill("KILL", *pid);
            std::thread::sleep(Duration::from_millis(100));
        }
        let on = wait_for(SOON, || {
            let back =
                |name: &&&str| alive(&ports, name).is_some_and(|(pid, _)| !others.contains(&pid));
            goes_on(frame + 60).filter(|_| set.iter().all(|name| back(&name)))
        });
        frame = on.unwrap_or_else(|| panic!("{set:?}: {:?}", common::status(&ports)));
        assert_ne!(station(), Some(dead));
    }
    drop(guests);
    assert!(operate(&ports, &["rate", "fast"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    for key in ["digest", "track_digest", "frames"] {
        assert_eq!(found[key], undisturbed[key], "{key}: {found}");
    }
    assert_eq!(found["external"], true, "outsiders were in it: {found}");
    let left = std::fs::read_dir(&folder.0).expect("a folder").flatten();
    let left: Vec<_> = left
        .map(|entry| entry.file_name())
        .filter(|name| name != "loop.toml" && name != "inputs.jsonl")
        .collect();
    assert!(left.is_empty(), "the journal is removed with the run: {left:?}");
}

/// A process stands still for 3 s. A connection on which nothing is said is closed after 2 s; what `stall_ms` says decides all the same:
/// 2 s freeze the run until it wakes up, 20 s do not, and it is heard again by itself. A process that is killed afterwards is missed at
/// once all the same. The digest is the undisturbed run's.
fn stands_still(stall_ms: Option<&str>) {
    let ports = Ports::new();
    let scene = ["--duration", "150", "--no-viewer", "--no-visitors"];
    let undisturbed = {
        let mut command = common::seeds();
        command.args(["run", "zurich", "--in-process", "--fast", "--duration", "150"]);
        summary(&finish(command))
    };
    let mut command = run(&ports, &scene);
    command.args(["--rate", "2", "--return-ms", "none"]);
    command.args(stall_ms.iter().flat_map(|ms| ["--stall-ms", *ms]));
    let mut going = Background::start(command);
    let name = "traffic-generator";
    let at =
        |least: u64| alive(&ports, name).filter(|(_, f)| *f > least && is_in(&ports, "RUNNING"));
    let (pid, frame) = wait_for(SOON, || at(40)).expect("it runs");
    common::kill("STOP", pid);
    // Two statuses a second: none of them may be missed.
    let seen: Vec<bool> = (0..6)
        .map(|_| {
            std::thread::sleep(Duration::from_millis(500));
            is_in(&ports, "FROZEN")
        })
        .collect();
    common::kill("CONT", pid);
    if stall_ms.is_none() {
        assert!(seen.contains(&true), "it is missed: {seen:?}");
    } else {
        assert!(!seen.contains(&true) && !is_in(&ports, "FROZEN"), "{:?}", common::status(&ports));
    }
    // Beyond the window of grants: consumers hear it too.
    let on = wait_for(SOON, || at(frame + 80));
    assert_eq!(on.map(|(again, _)| again), Some(pid), "{:?}", common::status(&ports));
    if stall_ms.is_some() {
        common::kill("KILL", pid);
        let missed = || is_in(&ports, "FROZEN").then_some(());
        let within = Duration::from_secs(10);
        assert!(wait_for(within, missed).is_some(), "{:?}", common::status(&ports));
        let _again = start(&ports, "zurich", name);
        assert!(wait_for(SOON, || at(0)).is_some(), "{:?}", common::status(&ports));
        ended(&ports, &mut going, &undisturbed, "its process or connection is gone");
    } else {
        ended(&ports, &mut going, &undisturbed, "nothing was heard of it for 2 s");
    }
}

/// Lets a run go on to its end: its digest is that of the undisturbed one, and it had one fault, which is named and made good.
fn ended(ports: &Ports, going: &mut Background, undisturbed: &Value, fault: &str) {
    assert!(operate(ports, &["rate", "fast"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(found["digest"], undisturbed["digest"], "{found}");
    let faults = found["faults"].as_array().expect("a list");
    let told =
        |f: &Value| f.as_str().is_some_and(|f| f.contains(fault) && f.contains("back after"));
    assert!(faults.len() == 1 && told(&faults[0]), "{faults:?}");
}

#[test]
fn a_pause_beyond_stall_ms_freezes_until_it_is_over() {
    stands_still(None);
}

#[test]
fn a_pause_within_a_long_stall_ms_freezes_nothing_and_a_kill_after_it_does_at_once() {
    stands_still(Some("20000"));
}

/// The disk is full from the second page of the log on: the run goes on and ends as it would, it is said when it happens, and who
/// would need the log to return says why he cannot.
#[test]
fn a_log_of_the_run_without_room_is_told_at_once_and_to_who_would_return() {
    let folder = Folder::new("returns-full");
    let ports = Ports::new();
    let words = folder.file("words");
    let to = std::fs::File::create(&words).expect("a file");
    let mut command = std::process::Command::new("sh");
    // 300 kB are the largest file; a write beyond is an error and no signal.
    let line = format!(
        "trap '' XFSZ; ulimit -f 600; exec {} run zurich --rate 4 --duration 900 --no-viewer --return-ms none --stall-ms 10000 \
         --sync-listen {} --dis {}",
        env!("CARGO_BIN_EXE_seeds"),
        ports.sync,
        ports.dis
    );
    command.args(["-c", &line]).current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(to);
    let going = Background(command.spawn().expect("it starts"));
    let _guests = Guests::of(&ports, Geodetic::from_degrees(47.43, 8.52, 432.0), 100);
    let said = || std::fs::read_to_string(&words).unwrap_or_default();
    let full = "the log of the run could not be written to";
    let told = wait_for(SOON, || said().contains(full).then_some(()));
    assert!(told.is_some(), "{}: {:?}", said(), common::status(&ports));
    assert!(said().contains("TMPDIR"), "what to do: {}", said());
    assert!(is_in(&ports, "RUNNING"), "it goes on: {:?}", common::status(&ports));
    let (pid, _) = alive(&ports, "smdfm").expect("the SMDFM");
    common::kill("KILL", pid);
    let frozen = || (alive(&ports, "smdfm").is_none() && is_in(&ports, "FROZEN")).then_some(());
    assert!(wait_for(SOON, frozen).is_some(), "{:?}", common::status(&ports));
    let mut again = common::seeds();
    again.args(["smdfm", "--sync-connect", &ports.sync, "--dis", &ports.dis]);
    let output = finish(again);
    let reason = common::stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{reason}");
    assert!(reason.contains(full) && !reason.contains("panicked"), "{reason}");
    assert!(is_in(&ports, "FROZEN"), "nobody is let in without his inputs");
    let _ = going.interrupt();
}

/// Every process of a run is killed, the launcher first; the same command with `--continue` goes on, to the digest of the run in which nothing
/// happened, and leaves no journal. A file that is there is not written over, and one that is none is refused.
#[test]
fn a_run_whose_processes_are_all_killed_is_continued() {
    let folder = Folder::new("continued");
    let journal = &folder.file("run.journal");
    let of_run = ["zurich", "--rate", "4", "--duration", "60", "--no-viewer", "--no-visitors"];
    let with = |ports: &Ports, flag: &str| run(ports, &[&of_run[..], &[flag, journal]].concat());
    let ports = Ports::new();
    let none = finish(with(&ports, "--continue"));
    assert_eq!(none.status.code(), Some(2), "{}", common::stderr(&none));
    let first = Background::start(with(&ports, "--journal"));
    let frame = || common::status(&ports)?["state"]["frame"].as_u64().filter(|at| *at > 200);
    wait_for(SOON, frame).expect("it runs");
    let twice = finish(with(&Ports::new(), "--journal"));
    let words = common::stderr(&twice);
    assert!(twice.status.code() == Some(2) && words.contains("--continue FILE"), "{words}");
    let all = common::processes(&ports.sync);
    assert!(all.len() >= 5, "{all:?}");
    common::kill("KILL", first.0.id() as i32);
    all.iter().for_each(|pid| common::kill("KILL", *pid));
    assert!(wait_for(SOON, || common::processes(&ports.sync).is_empty().then_some(())).is_some());
    drop(first);
    let output = finish(with(&ports, "--continue"));
    assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));
    let found = summary(&output);
    let alone = ["zurich", "--in-process", "--fast", "--duration", "60"];
    let undisturbed = summary(&finish(run(&Ports::new(), &alone)));
    for key in ["digest", "track_digest", "frames"] {
        assert_eq!(found[key], undisturbed[key], "{key}: {found}");
    }
    assert!(!std::path::Path::new(journal).exists(), "the run is over");
}
