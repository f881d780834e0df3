//! Runs with visitors from real sockets: the run is what it was, and a replay is the run.

mod common;

use common::{Background, Folder, Ports, finish, run, seeds, stderr, summary};
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
        let over = Arc::new(AtomicBool::new(false));
        let (stop, to) = (Arc::clone(&over), ports.dis.clone());
        let thread = std::thread::spawn(move || {
            let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
            socket.set_broadcast(true).expect("broadcast");
            // South-west of Zurich's runways.
            let airport = LocalFrame::at(Geodetic::from_degrees(47.43, 8.52, 432.0));
            let start = utc_ns();
            while !stop.load(Ordering::Relaxed) {
                let now = utc_ns();
                let t_s = (now - start) as f64 * 1e-9;
                for (entity, speed_mps) in [(1, 8.0), (2, 0.0)] {
                    let here = Enu { east_m: speed_mps * t_s, north_m: 0.0, up_m: 0.0 };
                    let id = EntityId::new(900, 9, entity);
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
