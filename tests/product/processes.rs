//! A run as an operator and an outsider meet it: real processes on loopback.

use crate::common;

use crate::common::{
    Background, Folder, Ports, SOON, finish, operate, run, stderr, summary, wait_for,
};
use pdu::enumerations::{ResponseFlag, StopReason};
use pdu::management::{StartResume, StopFreeze};
use pdu::records::{ClockTime, EntityId};
use pdu::{Body, DisTime, Envelope};
use std::time::Duration;

const CAPTURE: &str = "capture/tests/data/dis/kdis-log1.pcap";

fn phase(ports: &Ports) -> Option<String> {
    common::status(ports)?["state"]["phase"].as_str().map(str::to_owned)
}

fn in_phase(ports: &Ports, wanted: &str) -> bool {
    wait_for(SOON, || (phase(ports).as_deref() == Some(wanted)).then_some(())).is_some()
}

#[test]
fn a_second_terminal_freezes_steps_resumes_stops_and_restarts() {
    let ports = Ports::new();
    let run = Background::start(run(&ports, &["--rate", "4", "--no-viewer"]));
    assert!(in_phase(&ports, "RUNNING"), "it starts");

    let (ok, words) = operate(&ports, &["freeze"]);
    assert!(ok && words.starts_with("frozen at frame "), "{words}");
    let frozen: u64 = words.rsplit(' ').next().and_then(|n| n.parse().ok()).expect("a frame");
    let status = common::status(&ports).expect("statistics");
    for member in status["state"]["members"].as_array().expect("members") {
        assert_eq!(member["frame"], frozen, "all stand at one frame: {member}");
    }

    let (ok, words) = operate(&ports, &["freeze"]);
    assert!(!ok && words.contains("possible now: start"), "{words}");
    // Longer than the patience with a federate that stalls.
    std::thread::sleep(Duration::from_millis(2500));
    let (ok, words) = operate(&ports, &["step", "7"]);
    assert!(ok && words == format!("frozen at frame {}", frozen + 7), "{words}");
    std::thread::sleep(Duration::from_millis(500));
    assert!(in_phase(&ports, "FROZEN"), "nobody was given up");
    let (ok, words) = operate(&ports, &["rate", "0"]);
    assert!(!ok && words.contains("rate"), "{words}");
    assert!(operate(&ports, &["rate", "2"]).0);
    assert!(operate(&ports, &["resume"]).0);
    assert!(in_phase(&ports, "RUNNING"));
    let (ok, words) = operate(&ports, &["freeze"]);
    assert!(ok, "{words}");
    let (ok, words) = operate(&ports, &["restart"]);
    assert!(ok && words.contains("configured"), "{words}");
    assert!(operate(&ports, &["start"]).0);
    assert_eq!(common::status(&ports).expect("statistics")["state"]["run"], 2);
    assert_eq!(run.interrupt(), Some(0), "Ctrl-C ends clean");
    assert!(common::processes(&ports.sync).is_empty(), "nobody is left behind");
}

#[test]
fn dis_simulation_management_drives_the_run() {
    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--rate", "2", "--no-viewer", "--wait"]));
    assert!(in_phase(&ports, "CONFIGURED"), "it waits");

    let to = ports.dis.parse().expect("an address");
    let config = datalink::LinkConfig {
        to: datalink::Destinations::new(vec![datalink::Destination::of(to)]).expect("one"),
        interface: Some([127, 0, 0, 1].into()),
        ..datalink::LinkConfig::default()
    };
    let (mut sender, mut receiver) = datalink::Link::open(&config).expect("a link");
    let me = EntityId::new(77, 1, 0);
    let mut acknowledged = |octets: &[u8], request: u32| -> Option<ResponseFlag> {
        for look in 0..9000 {
            // A datagram may be lost; a request that is repeated gets the same answer.
            if look % 200 == 0 {
                sender.send(octets).expect("sent");
            }
            let mut answer = None;
            receiver
                .receive(Some(Duration::from_millis(10)), |arrival| {
                    for received in pdu::pdus(arrival.payload).flatten() {
                        if let Body::Acknowledge(a) = received.body()
                            && a.receiving_id == me
                            && a.request_id == request
                        {
                            answer = Some(a.response_flag);
                        }
                    }
                })
                .expect("received");
            if answer.is_some() {
                return answer;
            }
        }
        None
    };
    let envelope = Envelope::new(1, DisTime::relative(0));
    let start = |request_id| {
        let mut octets = Vec::new();
        let body = StartResume {
            originating_id: me,
            receiving_id: EntityId::ALL,
            request_id,
            ..StartResume::default()
        };
        envelope.append(&body, &mut octets).expect("encodes");
        octets
    };
    let stop = |request_id, reason, frozen_behaviour| {
        let mut octets = Vec::new();
        let body = StopFreeze {
            originating_id: me,
            receiving_id: EntityId::ALL,
            real_world_time: ClockTime::default(),
            reason,
            frozen_behaviour,
            request_id,
            ..StopFreeze::default()
        };
        envelope.append(&body, &mut octets).expect("encodes");
        octets
    };
    assert_eq!(acknowledged(&start(1), 1), Some(ResponseFlag::ABLE_TO_COMPLY));
    assert!(in_phase(&ports, "RUNNING"));
    // Times that no clock has: the listener outlives them, whomever they are for.
    for (request_id, (hour, for_us)) in
        [(i32::MAX, true), (i32::MIN, true), (i32::MAX, false)].into_iter().enumerate()
    {
        let mut octets = Vec::new();
        let body = StartResume {
            originating_id: EntityId::new(9, 9, 0),
            receiving_id: if for_us { EntityId::ALL } else { EntityId::new(3, 3, 3) },
            real_world_time: ClockTime { hour, ..ClockTime::default() },
            request_id: 900 + request_id as u32,
            ..StartResume::default()
        };
        envelope.append(&body, &mut octets).expect("encodes");
        let sender = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
        sender.set_broadcast(true).expect("broadcast");
        sender.send_to(&octets, &ports.dis).expect("sent");
    }
    let mut announced = Vec::new();
    let of_another_run = StopFreeze {
        originating_id: EntityId::new(9, 65_000, 0),
        receiving_id: EntityId::ALL,
        reason: StopReason::TERMINATION,
        request_id: 77,
        ..StopFreeze::default()
    };
    envelope.append(&of_another_run, &mut announced).expect("encodes");
    let neighbour = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    neighbour.set_broadcast(true).expect("broadcast");
    neighbour.send_to(&announced, &ports.dis).expect("sent");
    assert_eq!(acknowledged(&start(2), 2), Some(ResponseFlag::UNABLE_TO_COMPLY), "it runs already");
    assert_eq!(
        acknowledged(&start(1), 1),
        Some(ResponseFlag::ABLE_TO_COMPLY),
        "the same answer again"
    );
    let clock_goes_on = stop(3, StopReason::RECESS, 1);
    assert_eq!(acknowledged(&clock_goes_on, 3), Some(ResponseFlag::UNABLE_TO_COMPLY));
    assert_eq!(
        acknowledged(&stop(4, StopReason::RECESS, 0), 4),
        Some(ResponseFlag::ABLE_TO_COMPLY)
    );
    assert!(in_phase(&ports, "FROZEN"));
}

#[test]
fn an_outsiders_entity_becomes_a_target_and_garbage_does_no_harm() {
    use dis_rs::BodyRaw as _;
    use dis_rs::entity_state::builder::EntityStateBuilder;
    use dis_rs::enumerations::{EntityKind, ForceId, PlatformDomain};
    use dis_rs::model::{EntityId as Id, EntityType, Location, Pdu, PduHeader};

    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--rate", "4", "--no-viewer"]));
    assert!(in_phase(&ports, "RUNNING"), "it starts");
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_broadcast(true).expect("broadcast");

    // Standing 400 m south of the tower of Zurich.
    let place = geodesy::Geodetic::from_degrees(47.4502, 8.5569, 432.0).to_ecef();
    let octets = |x: f64, entity: u16| -> Vec<u8> {
        let body = EntityStateBuilder::new()
            .with_entity_id(Id::new(900, 9, entity))
            .with_force_id(ForceId::Neutral)
            .with_entity_type(
                EntityType::default()
                    .with_kind(EntityKind::Platform)
                    .with_domain(PlatformDomain::Land),
            )
            .with_location(Location::new(x, place.y_m, place.z_m))
            .build()
            .into_pdu_body();
        let pdu = Pdu::finalize_from_parts(
            PduHeader::new_v7(1, dis_rs::enumerations::PduType::EntityState),
            body,
            dis_rs::model::Timestamp::default(),
        );
        let mut buffer = bytes::BytesMut::with_capacity(1400);
        pdu.serialize(&mut buffer).expect("dis-rs encodes it");
        buffer.to_vec()
    };
    let sound = octets(place.x_m, 1);
    let not_a_number = octets(f64::NAN, 2);
    let seen = wait_for(SOON, || {
        socket.send_to(&sound, &ports.dis).expect("sent");
        for bad in [&b"garbage"[..], &sound[..70], &not_a_number, &[0; 1400]] {
            socket.send_to(bad, &ports.dis).expect("sent");
        }
        let status = common::status(&ports)?;
        let smdfm = &status["federates"]["smdfm"];
        let drops: Vec<String> = smdfm["dropped"]
            .as_array()?
            .iter()
            .filter_map(|d| d[0].as_str().map(str::to_owned))
            .collect();
        let targets = status["measures"]["outsiders_now"].as_f64()?;
        (targets >= 1.0
            && drops.iter().any(|d| d.contains("sound PDU"))
            && drops.iter().any(|d| d.contains("not a number")))
        .then_some(drops)
    });
    assert!(seen.is_some(), "{:?}", common::status(&ports));
    assert!(in_phase(&ports, "RUNNING"), "the run goes on");
}

/// Create Entity, Set Data, Remove Entity, octet by octet: the entity is a target of the sensors in between.
#[test]
fn an_entity_that_is_created_by_pdus_is_a_target_until_it_is_removed() {
    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--rate", "4", "--no-viewer"]));
    assert!(in_phase(&ports, "RUNNING"), "it starts");
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_broadcast(true).expect("broadcast");
    // Of the scene.
    let site: u16 = 417;
    let pdu = |kind: u8, request: u32, rest: &[u8]| -> Vec<u8> {
        let length = (28 + rest.len()) as u16;
        let mut octets = vec![7, 1, kind, 5, 0, 0, 0, 0];
        octets.extend(length.to_be_bytes());
        octets.extend([0, 0, 0, 77, 0, 1, 0, 0]);
        for number in [site, 9, 3000] {
            octets.extend(number.to_be_bytes());
        }
        octets.extend(request.to_be_bytes());
        octets.extend(rest);
        octets
    };
    // Standing 400 m south of the tower: one variable datum, 240142, of 192 bits.
    let place = geodesy::Geodetic::from_degrees(47.4502, 8.5569, 432.0).to_ecef();
    let mut location = vec![0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 3, 0xaa, 0x0e, 0, 0, 0, 192];
    for metres in [place.x_m, place.y_m, place.z_m] {
        location.extend(metres.to_be_bytes());
    }
    let (create, set, remove) = (pdu(11, 1, &[]), pdu(19, 2, &location), pdu(12, 3, &[]));
    let targets = || common::status(&ports)?["measures"]["outsiders_now"].as_f64();
    let seen = wait_for(SOON, || {
        // Datagrams may be lost; what is repeated is not done twice.
        for octets in [&create, &set] {
            socket.send_to(octets, &ports.dis).expect("sent");
        }
        targets().filter(|targets| *targets >= 1.0)
    });
    assert_eq!(seen, Some(1.0), "{:?}", common::status(&ports));
    let gone = wait_for(SOON, || {
        socket.send_to(&remove, &ports.dis).expect("sent");
        targets().filter(|targets| *targets == 0.0)
    });
    assert_eq!(gone, Some(0.0), "{:?}", common::status(&ports));
    assert!(in_phase(&ports, "RUNNING"), "the run goes on");
}

#[test]
fn a_recording_that_lost_its_logger_is_not_called_complete() {
    let ports = Ports::new();
    let folder = Folder::new("lost");
    let record = &folder.file("run.pcapng");
    let mut run =
        Background::start(run(&ports, &["--rate", "4", "--duration", "500", "--record", record]));
    assert!(in_phase(&ports, "RUNNING"));
    common::kill("KILL", federate(&ports, "viewer-logger"));
    assert!(operate(&ports, &["rate", "fast"]).0);
    assert_eq!(run.wait(SOON), Some(3), "complete, but data lost");
}

#[test]
fn a_dead_federate_freezes_the_run_in_real_time_and_ends_it_when_fast() {
    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--rate", "2"]));
    assert!(in_phase(&ports, "RUNNING"));
    common::kill("KILL", federate(&ports, "traffic-generator"));
    assert!(in_phase(&ports, "FROZEN"));
    let status = common::status(&ports).expect("statistics");
    let reason = status["state"]["reasons"][0].as_str().expect("a reason").to_owned();
    assert!(reason.contains("traffic-generator") && reason.contains("lost"), "{reason}");
    let (ok, words) = operate(&ports, &["resume"]);
    assert!(!ok && words.contains("traffic-generator"), "{words}");
}

/// Every one of these was lost and came back; on a busy machine others may have been missed for a while as well.
fn made_good(summed: &serde_json::Value, names: &[&str]) {
    let faults: Vec<&str> =
        summed["faults"].as_array().expect("a list").iter().filter_map(|f| f.as_str()).collect();
    assert!(faults.iter().all(|f| f.contains("back after")), "{faults:?}");
    for name in names {
        assert!(faults.iter().any(|f| f.starts_with(name)), "{name} is told: {faults:?}");
    }
}

/// A process that stood still, and one that died and is started again: the run goes on by itself, and its
/// digest is that of a run where nothing happened.
#[test]
fn a_paused_and_a_killed_federate_come_back_and_nothing_is_missing() {
    let undisturbed = finish({
        let mut command = common::seeds();
        command.args(["run", "zurich", "--in-process", "--fast"]);
        command
    });
    let ports = Ports::new();
    let mut background = Background::start(run(&ports, &["--rate", "4"]));
    assert!(in_phase(&ports, "RUNNING"));
    let paused = federate(&ports, "traffic-generator");
    common::kill("STOP", paused);
    assert!(in_phase(&ports, "FROZEN"), "it is missed");
    std::thread::sleep(Duration::from_secs(2));
    common::kill("CONT", paused);
    assert!(in_phase(&ports, "RUNNING"), "it is back: {:?}", common::status(&ports));
    let killed = federate(&ports, "smdfm");
    common::kill("KILL", killed);
    assert!(in_phase(&ports, "FROZEN"));
    let (ok, words) = operate(&ports, &["resume"]);
    assert!(!ok && words.contains("start smdfm again"), "{words}");
    let mut again = common::seeds();
    again.args(["smdfm", "--sync-connect", &ports.sync, "--dis", &ports.dis]);
    let _again = Background::start(again);
    assert!(in_phase(&ports, "RUNNING"), "another process goes on: {:?}", common::status(&ports));
    assert!(operate(&ports, &["rate", "fast"]).0);
    assert!(in_phase(&ports, "STOPPED"), "{:?}", common::status(&ports));
    let stdout = background.0.stdout.take().expect("piped");
    assert_eq!(background.interrupt(), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let summed: serde_json::Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(summed["digest"], summary(&undisturbed)["digest"], "{line}");
    made_good(&summed, &["traffic-generator", "smdfm"]);
}

/// Another generator's process takes the place of a killed one, the launcher starts a killed SMDFM again: nobody
/// does anything, and the digest is that of a run where nothing happened.
#[test]
fn whoever_is_killed_under_takeover_is_replaced_and_nothing_is_missing() {
    let undisturbed = finish({
        let mut command = common::seeds();
        command.args(["run", "zurich", "--in-process", "--fast", "--duration", "400"]);
        command
    });
    let ports = Ports::new();
    let arguments = ["--rate", "4", "--duration", "400", "--no-viewer", "--generators", "2"];
    let mut command = run(&ports, &arguments);
    command.args(["--on-loss", "takeover", "--stall-ms", "1500,smdfm=3000", "--no-visitors"]);
    command.args(["--smdfms", "2"]);
    let mut background = Background::start(command);
    assert!(in_phase(&ports, "RUNNING"));
    let member = |of: &dyn Fn(&serde_json::Value) -> bool| {
        let status = common::status(&ports)?;
        let members = status["state"]["members"].as_array()?.clone();
        let running = status["state"]["phase"] == "RUNNING";
        members.into_iter().find(|m| running && m["alive"] == true && of(m))
    };
    let replaced = |name: &str| {
        let killed = wait_for(SOON, || member(&|m| m["name"] == name)).expect("a member");
        let pid = &killed["pid"];
        common::kill("KILL", pid.as_i64().expect("a process") as i32);
        let back = || member(&|m| m["name"] == name && m["pid"] != *pid);
        assert!(wait_for(SOON, back).is_some(), "{killed}: {:?}", common::status(&ports));
    };
    replaced("traffic-generator-1");
    replaced("smdfm");
    replaced("smdfm-2");
    assert!(operate(&ports, &["rate", "fast"]).0);
    let stdout = background.0.stdout.take().expect("piped");
    assert_eq!(background.wait(SOON), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let summed: serde_json::Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(summed["digest"], summary(&undisturbed)["digest"], "{line}");
    made_good(&summed, &["traffic-generator-1", "smdfm (", "smdfm-2"]);
}

/// A process that stands still while it joins is not refused by itself: it asks again and is answered the same.
#[test]
fn a_process_that_stood_still_while_joining_joins() {
    let ports = Ports::new();
    let part = |name: &str| {
        let mut command = common::seeds();
        command.args([name, "--dis", &ports.dis]);
        command
    };
    let mut station = part("admin-station");
    station.args(["--sync-listen", &ports.sync, "--fast", "--duration", "20", "--batch"]);
    let mut station = Background::start(station);
    let member = |name: &str| {
        let mut command = part(name);
        common::patient(&mut command).args(["--sync-connect", &ports.sync]);
        Background::start(command)
    };
    let _generator = member("traffic-generator");
    let smdfm = member("smdfm");
    // Stopped as soon as it is known: before it was answered, or while it is.
    let known = wait_for(SOON, || {
        let members = common::status(&ports)?["state"]["members"].clone();
        members.as_array()?.iter().any(|m| m["name"] == "smdfm").then_some(())
    });
    assert!(known.is_some(), "the SMDFM asks to join");
    common::kill("STOP", smdfm.0.id() as i32);
    let _world = member("external-world");
    std::thread::sleep(Duration::from_secs(3));
    common::kill("CONT", smdfm.0.id() as i32);
    assert_eq!(station.wait(SOON), Some(0), "it took part");
}

/// Who waits for a station that is not there ends as soon as it is told to, and not when its patience is over.
#[test]
fn a_federate_that_waits_for_a_station_ends_when_it_is_told_to() {
    for name in ["external-world", "smdfm", "viewer-logger", "visitors"] {
        let ports = Ports::new();
        let mut command = common::seeds();
        command.args([name, "--dis", &ports.dis, "--sync-connect", &ports.sync]);
        // As one of a launcher, which has two minutes of patience.
        common::patient(&mut command);
        if name == "viewer-logger" {
            command.args(["--no-page"]);
        }
        let mut waiting = Background::start(command);
        let connects = || {
            let seen = std::fs::read_dir(format!("/proc/{}/task", waiting.0.id())).ok()?;
            let threads =
                seen.flatten().filter_map(|t| std::fs::read_to_string(t.path().join("comm")).ok());
            threads.into_iter().any(|name| name.starts_with("net-")).then_some(())
        };
        assert!(wait_for(SOON, connects).is_some(), "{name} opens its session");
        std::thread::sleep(Duration::from_millis(300));
        common::kill("TERM", waiting.0.id() as i32);
        assert_eq!(waiting.wait(SOON), Some(0), "{name}");
    }
}

/// Every federate ends with a launcher that is killed: at any moment of its start, and while the run goes on.
#[test]
fn no_federate_outlives_a_killed_launcher() {
    for (after_ms, arguments) in [
        (0, &["--no-viewer"][..]),
        (5, &[]),
        (20, &[]),
        (60, &["--wait"]),
        (200, &["--fast", "--duration", "80000"]),
        (3000, &[]),
    ] {
        let ports = Ports::new();
        let mut launcher = Background::start(run(&ports, arguments));
        std::thread::sleep(Duration::from_millis(after_ms));
        launcher.0.kill().expect("it can be killed");
        launcher.0.wait().expect("it has ended");
        // A tenth of a second where nothing else runs; patience for a machine that does much else.
        let gone =
            common::wait_for(SOON, || common::processes(&ports.sync).is_empty().then_some(()));
        let left = common::processes(&ports.sync);
        assert!(gone.is_some(), "killed after {after_ms} ms with {arguments:?}: {left:?} are left");
    }
}

/// When a run is over its processes end; nothing goes on without them.
#[test]
fn a_run_that_ends_in_order_says_of_nobody_that_it_goes_on_without() {
    let ports = Ports::new();
    let output = finish(run(&ports, &["--rate", "20", "--duration", "10", "--no-viewer"]));
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("STOPPED at frame 200") && !said.contains(" ended ("), "{said}");
}

/// The process of this run whose command is `seeds name`, as soon as there is one.
fn federate(ports: &Ports, name: &str) -> i32 {
    let found = wait_for(SOON, || {
        let called = common::processes(&format!("seeds {name}"));
        common::processes(&ports.sync).into_iter().find(|pid| called.contains(pid))
    });
    found.unwrap_or_else(|| panic!("{name} does not start"))
}

/// Seconds from `SIGNAL` to the viewer-logger, as it starts or when all run, to the end of a short run.
fn lasts_with_viewer(signal: Option<&str>, at_start: bool) -> (f64, Option<i32>) {
    let ports = Ports::new();
    let mut run = Background::start(run(&ports, &["--fast", "--duration", "20"]));
    let viewer = federate(&ports, "viewer-logger");
    if !at_start {
        in_phase(&ports, "RUNNING");
    }
    if let Some(signal) = signal {
        common::kill(signal, viewer);
    }
    #[expect(clippy::disallowed_methods, reason = "how long other processes take")]
    let began = std::time::Instant::now();
    let code = run.wait(SOON);
    (began.elapsed().as_secs_f64(), code)
}

#[test]
fn a_viewer_stopped_or_killed_at_the_start_delays_nothing() {
    let (alone_s, code) = lasts_with_viewer(None, true);
    assert_eq!(code, Some(0), "alone");
    for signal in ["STOP", "KILL"] {
        let (lasts_s, code) = lasts_with_viewer(Some(signal), true);
        // 2 s each at start and end where nothing else runs; before, 12 to 23 s. Patience for a busy machine.
        assert!(lasts_s < 2.0 * alone_s + 9.0, "{signal}: {lasts_s:.1} s, alone {alone_s:.1} s");
        assert_eq!(code, Some(0), "{signal}: the run is complete without it");
    }
}

#[test]
fn a_second_viewer_takes_part_under_a_name_of_its_own() {
    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--rate", "2"]));
    assert!(in_phase(&ports, "RUNNING"));
    let folder = Folder::new("second-viewer");
    let mut second = common::seeds();
    second.args(["viewer-logger", "--sync-connect", &ports.sync, "--dis", &ports.dis]);
    second.args(["--page", "localhost:0", "--record", &folder.file("second.pcapng")]);
    let _second = Background::start(second);
    let names = wait_for(SOON, || {
        let status = common::status(&ports)?;
        let members = status["state"]["members"].as_array()?.clone();
        let names: Vec<_> = members.iter().filter_map(|m| m["name"].as_str()).collect();
        names.contains(&"viewer-logger-2").then(|| names.contains(&"viewer-logger"))
    });
    assert_eq!(names, Some(true));
}

#[test]
fn too_few_files_are_told_and_nobody_panics() {
    let ports = Ports::new();
    for files in ["24", "40"] {
        let mut command = std::process::Command::new("sh");
        let line = format!(
            "ulimit -n {files}; exec {} run --fast --duration 5 --no-viewer --sync-listen {} --dis {}",
            env!("CARGO_BIN_EXE_seeds"),
            ports.sync,
            ports.dis
        );
        command.args(["-c", &line]).current_dir(env!("CARGO_MANIFEST_DIR"));
        let output = finish(command);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{files}: {text}");
        assert!(text.contains("ulimit -n") && !text.contains("panicked"), "{files}: {text}");
    }
}

#[test]
fn a_movement_that_nothing_can_be_made_of_ends_the_launcher_with_its_words() {
    let folder = Folder::new("no-way");
    let copied = std::process::Command::new("cp")
        .args(["-r", "scenarios", &folder.file("")])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status();
    assert!(copied.expect("cp").success());
    let scene = folder.file("scenarios/bad.toml");
    let text = std::fs::read_to_string(folder.file("scenarios/zurich.toml")).expect("the scene");
    let via = text.lines().find(|line| line.starts_with("via = ")).expect("a route");
    // The node where it halts: from there to itself.
    let halt = via.split('"').nth(3).expect("a node");
    std::fs::write(&scene, text.replace(via, &format!("via = [\"{halt}\", \"{halt}\"]")))
        .expect("written");
    for generators in ["1", "3"] {
        let ports = Ports::new();
        let arguments = [&*scene, "--fast", "--no-viewer", "--generators", generators];
        let command = run(&ports, &arguments);
        let output = finish(command);
        let words = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(words.contains("bad.toml:") && words.contains("at least 10 m of way"), "{words}");
        assert_eq!(words.lines().filter(|l| l.contains("bad.toml")).count(), 1, "{words}");
    }
}

/// The same run, every link under mutual TLS and every message by the access list.
#[test]
fn a_run_with_certificates_gives_the_same_digest_and_is_closed_to_others() {
    let folder = Folder::new("certs");
    let made = finish({
        let mut command = common::seeds();
        command.args(["certs", &folder.file("c"), "--generators", "2"]);
        command
    });
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    let certs = folder.file("c");
    let mut check = common::seeds();
    check.args(["certs", "check", &certs, "--endpoint", "tls/127.0.0.1:7447"]);
    assert_eq!(finish(check).status.code(), Some(0));

    let plain = finish(run(&Ports::new(), &["--fast", "--duration", "20", "--no-viewer"]));
    let mut ports = Ports::new();
    ports.sync = ports.sync.replace("tcp/", "tls/");
    let arguments = ["--fast", "--duration", "20", "--certs", &certs, "--generators", "2"];
    let record = folder.file("run.pcapng");
    let mut command = run(&ports, &arguments);
    command.args(["--record", &record]);
    let output = finish(command);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(summary(&output)["digest"], summary(&plain)["digest"]);

    let mut ports = Ports::new();
    ports.sync = ports.sync.replace("tcp/", "tls/");
    let _run = Background::start(run(&ports, &["--rate", "2", "--certs", &certs, "--no-viewer"]));
    let ask = |more: &[&str]| {
        let mut command = common::seeds();
        command.args(["admin-station", "status", "--json", "--at", &ports.sync]).args(more);
        finish(command)
    };
    let running = wait_for(SOON, || {
        let output = ask(&["--certs", &certs]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (text.contains("RUNNING") && text.contains("\"smdfm\"")).then_some(())
    });
    assert!(running.is_some(), "an operator with a certificate is let in");
    // Another authority's operator.
    let other = folder.file("other");
    let mut command = common::seeds();
    command.args(["certs", &other]);
    assert_eq!(finish(command).status.code(), Some(0));
    let refused = ask(&["--certs", &other]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("seeds certs check"), "{}", stderr(&refused));
}

#[test]
fn bad_input_gives_one_line_and_the_right_code() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let taken = taken.local_addr().expect("its address").to_string();
    let free_sync = Ports::new().sync;
    let taken_sync = format!("tcp/{taken}");
    for (arguments, code, words) in [
        (&["run", "nowhere.toml", "--fast"][..], 2, "scene nowhere.toml: No such file"),
        (&["run", "--seed", "-1"], 2, "a whole number from 0 to"),
        (&["run", "--page", "example.org:8600"], 2, "localhost:8600"),
        (&["run", "--report", "Cargo.toml"], 2, "'Cargo.toml' is a file"),
        (&["viewer-logger", "--report", "Cargo.toml"], 2, "'Cargo.toml' is a file"),
        (&["run", "--duration", "-5"], 2, "-5"),
        (&["run", "--generators", "0"], 2, "1..=16"),
        (&["run", "--inject-loss", "2", "--no-viewer", "--fast"], 2, "--inject-loss"),
        (&["run", "--rate", "-1"], 2, "is not a rate"),
        (&["run", "--rate", "1e-300"], 2, "is not a rate"),
        (&["run", "--dis", "here", "--no-viewer"], 2, "--dis here"),
        (&["run", "--interface", "192.0.2.77", "--no-viewer"], 2, "192.0.2.77"),
        (&["run", "--sync-listen", "here"], 2, "is not an endpoint"),
        (&["run", "--sync-connect", "tcp/127.0.0.1:9"], 2, "--sync-listen"),
        (&["run", "--sync-listen", "tcp/127.0.0.1:0"], 2, "--sync-listen"),
        (&["smdfm", "--sync-connect", "tcp/127.0.0.1:0"], 2, "port 0"),
        (&["run", "--dis", "127.255.255.255:0"], 2, "port 0"),
        (&["replay", "x.pcapng", "--with-smdfm", "--rate", "2"], 2, "--rate"),
        (&["replay", "x.pcapng", "--with-smdfm", "--from", "5"], 2, "--from"),
        (&["replay", "x.pcapng", "--with-smdfm", "--to", "5"], 2, "--to"),
        (&["replay", "x.pcapng", "--with-smdfm", "--loop"], 2, "--loop"),
        (&["replay", "x.pcapng", "--with-smdfm", "--dis", "127.255.255.255:9"], 2, "--dis"),
        (&["replay", "x.pcapng", "--with-smdfm", "--set-site", "7"], 2, "--set-site"),
        (&["replay", "x.pcapng", "--seed", "7"], 2, "--with-smdfm"),
        (&["run", "--page", &taken], 2, "--page"),
        (
            &["run", "xsyn", "--in-process", "--record", "/nowhere/x.pcapng"],
            2,
            "leave out --record",
        ),
        (&["run", "xsyn", "--in-process", "--public"], 2, "--in-process has no gateway"),
        (&["run", "xsyn", "--in-process", "--asterix", "127.0.0.1:9"], 2, "has no gateway"),
        (
            &["run", "--no-viewer", "--fast", "--record", "/tmp", "--sync-listen", &free_sync],
            1,
            "/tmp",
        ),
        (&["run", "--no-viewer", "--sync-listen", &taken_sync], 1, "--sync-listen"),
        (&["smdfm", "--sync-connect", "tcp/127.0.0.1:9"], 1, "127.0.0.1:9"),
        (&["smdfm", "--interface", "192.0.2.1"], 1, "192.0.2.1"),
        (
            &["run", "--sync-listen", "udp/127.0.0.1:7447"],
            2,
            "tcp/ADDRESS:PORT or tls/ADDRESS:PORT",
        ),
        (&["run", "--sync-listen", "tcp/0.0.0.0:7447"], 2, "could command this run"),
        (&["run", "--sync-listen", "tls/127.0.0.1:7447"], 2, "needs certificates"),
        (&["run", "--certs", "/nowhere"], 2, "seeds certs /nowhere"),
        (&["certs"], 2, "<DIR>"),
        (&["certs", "check", "/nowhere"], 2, "/nowhere/authority.pem"),
        (&["traffic-generator", "--share", "3/2"], 2, "3/2"),
        (&["admin-station", "status", "--at", "tcp/127.0.0.1:9"], 1, "127.0.0.1:9"),
        (&["admin-station", "--sync-connect", "tcp/127.0.0.1:9", "freeze"], 1, "127.0.0.1:9"),
        (&["admin-station", "--rate", "2", "freeze"], 2, "--rate is for starting"),
        (&["replay", "/nowhere.pcapng", "--with-smdfm"], 2, "/nowhere.pcapng"),
        (&["replay", CAPTURE, "--from", "5", "--to", "2"], 2, "--from is after --to"),
        (&["replay", CAPTURE, "--from", "80000"], 2, "nothing between --from and --to"),
        (&["run", "xsyn", "--in-process", "--balance"], 2, "leave out one of them"),
        (&["verify", "/nowhere"], 2, "/nowhere"),
        (&["dis", "check", "/nowhere.pcap"], 2, "/nowhere.pcap"),
        (&["plan", "/dev/zero"], 2, "longer than"),
        (&["plan", "--explain", "NOBODY", "--at", "10"], 2, "--explain NOBODY"),
        (&["plan", "--video", "/dev/null", "--at", "10", "--rim", "nan"], 2, "is not a distance"),
        (&["airport", "check", "/dev/zero"], 2, "longer than"),
        (&["airport", "nodes", "PARIS"], 2, "airports that come with SEEDS: EGCC"),
        (&["fit", "--out", "/nowhere/figures.json"], 1, "/nowhere/figures.json"),
        (&["reference", "/nowhere"], 2, "/nowhere"),
        (&["accuracy", "--out", "/dev/null"], 1, "/dev/null"),
    ] {
        let mut command = common::seeds();
        command.args(arguments);
        let output = finish(command);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
        assert!(text.contains(words), "{arguments:?}: {text}");
        assert!(!text.contains("panicked"), "{arguments:?}: {text}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_federate_started_twice_or_of_another_scene_is_refused() {
    let ports = Ports::new();
    let _run = Background::start(run(&ports, &["--no-viewer"]));
    assert!(in_phase(&ports, "RUNNING"));
    let mut twice = common::seeds();
    twice.args(["external-world", "--sync-connect", &ports.sync, "--dis", &ports.dis]);
    let output = finish(twice);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("already running"), "{}", stderr(&output));

    let folder = Folder::new("scene");
    let copied = std::process::Command::new("cp")
        .args(["-r", "scenarios", &folder.file("")])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status();
    assert!(copied.expect("cp").success());
    let other = folder.file("scenarios/other.toml");
    let text = std::fs::read_to_string(folder.file("scenarios/zurich.toml")).expect("the scene");
    std::fs::write(&other, text.replace("seed = 1", "seed = 2")).expect("written");
    let mut stranger = common::seeds();
    stranger
        .args(["smdfm", "--sync-connect", &ports.sync, "--dis", &ports.dis, "--scene"])
        .arg(&other);
    let output = finish(stranger);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("another scene"), "{}", stderr(&output));
}

#[test]
fn a_fast_run_whose_federate_dies_ends_with_one() {
    let ports = Ports::new();
    let mut command = run(&ports, &["--rate", "1", "--no-viewer", "--wait"]);
    command.arg("--duration").arg("600");
    let mut background = Background::start(command);
    assert!(in_phase(&ports, "CONFIGURED"));
    common::kill("KILL", federate(&ports, "smdfm"));
    assert_eq!(background.wait(SOON), Some(1));
    // The summary of a complete run, for comparison, has no faults.
    let output = finish(run(&Ports::new(), &["--fast", "--duration", "20", "--no-viewer"]));
    assert_eq!(summary(&output)["faults"].as_array().map(Vec::len), Some(0));
}

/// A generator of behaving traffic that has nothing to send yet, and an SMDFM that never sends: the data plane is not dead, and nobody says so.
#[test]
fn a_generator_without_a_pdu_and_a_second_smdfm_are_no_dead_plane() {
    let folder = common::Folder::new("quiet");
    let scene = folder.file("quiet.toml");
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"quiet\"\nseed = 77\nduration_s = 240\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 24\ndepartures_per_h = 40\n\
         [control]\nsees = \"tracks\"\ncontrollers = \"model\"\n"
    );
    std::fs::write(&scene, text).expect("a scene");
    let arguments = [&scene, "--rate", "6", "--no-viewer", "--generators", "3", "--smdfms", "2"];
    let mut command = run(&Ports::new(), &arguments);
    command.args(["--duration", "20"]);
    let output = finish(command);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains("hears none"), "{said}");
}
