//! Runs with visitors from real sockets: the run is what it was, and a replay is the run.

use crate::common;

use crate::common::{Background, Folder, Ports, finish, run, seeds, stderr, summary};
use federates::runtime::clock::utc_ns;
use geodesy::{Enu, Geodetic, LocalFrame};
use pdu::enumerations::DeadReckoningAlgorithm;
use pdu::exercise::Transponder;
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use pdu::{DisTime, EntityState, Envelope};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Somebody else's simulator: one car and one aircraft with a transponder, far from all traffic, and garbage.
struct Guests {
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Guests {
    fn of(ports: &Ports) -> Self {
        Self::from("127.0.0.1", 900, ports)
    }

    /// Those of a site, from an address of this host.
    fn from(host: &'static str, site: u16, ports: &Ports) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (stop, to) = (Arc::clone(&over), ports.dis.clone());
        let thread = std::thread::spawn(move || {
            let socket = std::net::UdpSocket::bind((host, 0)).expect("a socket");
            socket.set_broadcast(true).expect("broadcast");
            // South-west of Zurich's runways.
            let airport = LocalFrame::at(Geodetic::from_degrees(47.43, 8.52, 432.0));
            let start = utc_ns();
            while !stop.load(Ordering::Relaxed) {
                let now = utc_ns();
                let t_s = (now - start) as f64 * 1e-9;
                for (entity, speed_mps) in [(1, 8.0), (2, 0.0)] {
                    let here = Enu { east_m: speed_mps * t_s, north_m: 0.0, up_m: 0.0 };
                    let id = EntityId::new(site, 9, entity);
                    let state = EntityState {
                        entity_id: id,
                        entity_type: EntityType::new(1, entity as u8, 225, 85, 0, 0, 0),
                        location: airport.to_ecef(here).into(),
                        linear_velocity_mps: Vector32::from_f64(
                            airport.vector_to_ecef([speed_mps, 0.0, 0.0]),
                        ),
                        dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
                        marking: Marking::new("GUEST").expect("short"),
                        ..EntityState::default()
                    };
                    let envelope = Envelope::new(1, DisTime::absolute(now as u64));
                    let mut octets = Vec::new();
                    envelope.append(&state, &mut octets).expect("fits");
                    let transponder =
                        Transponder { on: true, address: Some(0xabcd), ..Transponder::default() };
                    envelope.append(&transponder.iff(id), &mut octets).expect("fits");
                    let _ = socket.send_to(&octets, &to);
                    let _ = socket.send_to(&octets[..100], &to);
                }
                std::thread::sleep(Duration::from_millis(100));
            }
        });
        Self { over, thread: Some(thread) }
    }
}

impl Drop for Guests {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[test]
fn a_visitor_changes_no_digest_of_ours_and_a_replay_has_it_too() {
    let folder = Folder::new("visitors");
    let path = &folder.file("run.pcapng");
    let of_run = ["--rate", "5", "--duration", "20", "--no-viewer"];
    let ports = Ports::new();
    let alone = finish(run(&ports, &[&of_run[..], &["--no-visitors"]].concat()));
    let alone = summary(&alone);
    assert!(alone.get("external").is_none() && alone.get("foreign").is_none(), "{alone}");

    // A log may lose scans on a loaded host, and says so by exit code 3: again then.
    let mut attempts = (0..4).map(|_| {
        let ports = Ports::new();
        let guests = Guests::of(&ports);
        let output = finish(run(&ports, &[&of_run[..], &["--record", path]].concat()));
        drop(guests);
        output
    });
    let complete = |output: &std::process::Output| output.status.code() == Some(0);
    let output = attempts.find(complete).expect("one of four recordings is complete");
    let visited = summary(&output);
    assert_eq!(visited["digest"], alone["digest"], "{visited}");
    assert_eq!(visited["track_digest"], alone["track_digest"]);
    assert_eq!(visited["external"], true, "{visited}");
    assert_eq!((&visited["visitors"], &visited["touched"]), (&2.into(), &0.into()), "{visited}");
    assert_eq!(visited["truth"]["lost"], 0, "{visited}");

    let mut replay = seeds();
    replay.args(["replay", path, "--with-smdfm", "--scene", "zurich"]);
    let output = finish(replay);
    let replayed = summary(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for key in ["digest", "track_digest", "foreign", "visitors", "touched", "external"] {
        assert_eq!(replayed[key], visited[key], "{key}: {replayed}");
    }
    assert_eq!(replayed["truth"]["lost"], 0, "what others damaged is no loss of ours: {replayed}");
}

#[test]
fn outsiders_are_let_in_by_nobody_but_the_member() {
    let ports = Ports::new();
    let guests = Guests::of(&ports);
    let output = finish(run(&ports, &["--fast", "--duration", "60", "--no-viewer"]));
    drop(guests);
    let with_guests = summary(&output);
    let ports = Ports::new();
    let alone = summary(&finish(run(&ports, &["--fast", "--duration", "60", "--no-viewer"])));
    assert_eq!(with_guests["digest"], alone["digest"]);
    assert!(with_guests.get("external").is_none(), "{with_guests}");
}

#[test]
fn only_senders_and_sites_of_the_lists_come_in_and_the_rest_is_counted() {
    let folder = Folder::new("senders");
    let scene = |network: &str| {
        let mut scene = crate::scene_keys::shipped("zurich");
        scene.insert("network".to_owned(), network.parse::<toml::Table>().expect("TOML").into());
        crate::scene_keys::written(&folder, 0, &scene)
    };
    let by_key = scene("dis_from = [\"127.0.0.8/30\"]\ndis_sites = [900]");
    let lists = ["--dis-from", "127.0.0.8/30", "--dis-sites", "900"];
    for (scene, flags) in [(&by_key[..], &[][..]), ("zurich", &lists)] {
        let ports = Ports::new();
        let of_run = [scene, "--rate", "5", "--duration", "20", "--no-viewer"];
        let command = run(&ports, &[&of_run[..], flags].concat());
        let _guests = [("127.0.0.9", 900), ("127.0.0.9", 901), ("127.0.0.77", 900)]
            .map(|(host, site)| Guests::from(host, site, &ports));
        let (at, over) = (ports.sync.clone(), Arc::new(AtomicBool::new(false)));
        let ended = Arc::clone(&over);
        let watch = std::thread::spawn(move || {
            let ports = Ports { sync: at, ..Ports::new() };
            let mut counted = String::new();
            while !ended.load(Ordering::Relaxed) {
                if let Some(told) = common::status(&ports) {
                    counted = told.to_string();
                }
            }
            counted
        });
        let output = finish(command);
        over.store(true, Ordering::Relaxed);
        let counted = watch.join().expect("sound");
        assert_eq!(summary(&output)["visitors"], 2, "{flags:?}: {}", stderr(&output));
        for reason in ["not in the list (dis_from)", "not in the list (dis_sites)"] {
            assert!(counted.contains(reason), "{flags:?}: {reason}: {counted}");
        }
        let said = stderr(&output);
        assert!(said.contains("DIS of 127.0.0.77 is not taken"), "{flags:?}: {said}");
    }
}

#[test]
fn a_run_goes_on_without_its_door() {
    let ports = Ports::new();
    let mut going =
        Background::start(run(&ports, &["--rate", "2", "--duration", "24", "--no-viewer"]));
    let soon = Duration::from_secs(30);
    let running = || (common::status(&ports)?["state"]["phase"] == "RUNNING").then_some(());
    assert!(common::wait_for(soon, running).is_some(), "{:?}", common::status(&ports));
    let door = common::processes(&ports.sync)
        .into_iter()
        .find(|pid| common::processes("seeds visitors").contains(pid));
    common::kill("KILL", door.expect("the member visitors"));
    assert_eq!(going.wait(Duration::from_secs(60)), Some(0), "the run ends as it would");
}

/// Somebody's radar: two cars, a report a second each, with a clock of its own.
struct Radar {
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Radar {
    fn at(to: String) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
            let start = utc_ns();
            while !stop.load(Ordering::Relaxed) {
                let now = utc_ns();
                let t_s = (now - start) as f64 * 1e-9;
                let mut packer = asterix::Packer::new(1400);
                for (n, north_m) in [(0.0, -2600.0), (1.0, -2800.0)] {
                    packer
                        .record(&asterix::cat010::CATEGORY, |items| {
                            use asterix::cat010::*;
                            items.put(&I010, &[7, 1])?;
                            items.put(&I000, &[1])?;
                            // Its clock goes as fast as the run's.
                            let clock = asterix::time::of_day_s(now + (now - start));
                            items.put(&I140, &[clock])?;
                            items.put(&I042, &[-900.0 + 8.0 * t_s * n, north_m])?;
                            items.put(&I500, &[3.0, 3.0, 0.0])
                        })
                        .expect("fits");
                }
                for datagram in packer.take() {
                    let _ = socket.send_to(&datagram, &to);
                    let _ = socket.send_to(&datagram[..20], &to);
                }
                std::thread::sleep(Duration::from_millis(250));
            }
        });
        Self { over, thread: Some(thread) }
    }
}

impl Drop for Radar {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[test]
fn a_real_sensor_feeds_the_tracker_and_a_replay_has_its_plots() {
    let folder = Folder::new("foreign-sensor");
    let path = &folder.file("run.pcapng");
    let listen = format!("127.0.0.1:{}", common::free_port());
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/zurich.toml"))
            .expect("the scene");
    let sensor = format!(
        "\n[[sensor]]\nname = \"their radar\"\nkind = \"asterix\"\nlisten = \"{listen}\"\nsac = 7\nsic = 1\nclock = \"first\"\ninterval_s = 0.25\n"
    );
    let scene = folder.file("theirs.toml");
    std::fs::write(&scene, text + &sensor).expect("written");
    let start = |more: &[&str]| {
        let ports = Ports::new();
        let mut command = seeds();
        command.args(["run", &scene, "--dis", &ports.dis, "--sync-listen", &ports.sync]);
        command.args(["--page", &ports.page]).args(more);
        command
    };
    let refused = finish(start(&["--fast", "--duration", "5", "--no-viewer"]));
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("their radar"), "{}", stderr(&refused));

    let of_run = ["--rate", "2", "--duration", "20", "--no-viewer", "--record", path];
    let mut attempts = (0..4).map(|_| {
        let radar = Radar::at(listen.clone());
        let output = finish(start(&of_run));
        drop(radar);
        output
    });
    // The radar's clock keeps the pace that was asked for: a run that cannot, on a loaded host, refuses what comes ahead of it.
    let complete = |output: &std::process::Output| {
        let plots = |output| summary(output)["foreign_plots"].as_u64();
        output.status.code() == Some(0) && plots(output) > Some(20)
    };
    let output = attempts.find(complete).expect("one of four runs keeps its pace and its log");
    let heard = summary(&output);
    assert_eq!(heard["external"], true, "{heard}");

    let mut replay = seeds();
    replay.args(["replay", path, "--with-smdfm", "--scene", &scene]);
    let output = finish(replay);
    let replayed = summary(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for key in ["digest", "track_digest", "foreign", "foreign_plots", "touched", "external"] {
        assert_eq!(replayed[key], heard[key], "{key}: {replayed}");
    }
}

#[test]
fn a_frozen_run_is_seen_to_stand_and_its_replay_is_the_run() {
    let (ports, folder) = (Ports::new(), Folder::new("frozen"));
    let path = &folder.file("run.pcapng");
    let arguments = ["--rate", "2", "--duration", "20", "--no-viewer", "--no-visitors"];
    let command = run(&ports, &[&arguments[..], &["--record", path]].concat());
    let finished = std::thread::spawn(move || finish(command));
    let soon = Duration::from_secs(60);
    let running = || (common::status(&ports)?["state"]["phase"] == "RUNNING").then_some(());
    assert!(common::wait_for(soon, running).is_some(), "{:?}", common::status(&ports));
    let (frozen, words) = common::operate(&ports, &["freeze"]);
    assert!(frozen, "{words}");
    // Long enough for a generator that waits for a processor.
    std::thread::sleep(Duration::from_secs(2));
    let (going, words) = common::operate(&ports, &["start"]);
    assert!(going, "{words}");
    let output = finished.join().expect("it ends");
    let going = summary(&output);
    assert_eq!(going["faults"], serde_json::json!([]), "{going}");
    let mut dump = seeds();
    dump.args(["dis", "dump", path]);
    let text = String::from_utf8(finish(dump).stdout).expect("text");
    let stands = text.lines().filter(|l| l.ends_with(" frozen")).count();
    assert!(stands >= 5, "{stands} entities stand");
    let over = text.lines().filter(|l| l.ends_with(" frozen deactivated")).count();
    println!("{stands} told while time stood, {over} at the end");
    if output.status.code() == Some(0) {
        let mut replay = seeds();
        replay.args(["replay", path, "--with-smdfm", "--scene", "zurich"]);
        let replayed = summary(&finish(replay));
        for key in ["digest", "track_digest"] {
            assert_eq!(replayed[key], going[key], "{key}: {replayed}");
        }
    }
}
