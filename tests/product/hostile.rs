//! What anybody may throw at a run that goes on: damaged captures, random octets, sound PDUs that say nonsense. The run ends as it would.
//!
//! `cargo test --release --test product hostile -- --ignored --nocapture`: a million of them (a minute and a half).

#![expect(clippy::print_stdout, reason = "what was thrown, and what was measured")]

use crate::common;

use crate::common::{Folder, Ports, finish, run, seeds, stderr, summary};
use pdu::enumerations::{DatumId, PduType};
use pdu::management::EventReport;
use pdu::records::{EntityId, Location, Marking, VariableDatum, Vector32};
use pdu::{DisTime, EntityState, Envelope};
use serde_json::Value;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[path = "../../pdu/tests/common/samples.rs"]
mod samples;

/// Orders to the administration station are obeyed when they come from this host: that is no attack. Stop, action, set
/// data, and the same with reliability.
const ORDERS: [u8; 6] = [14, 16, 19, 54, 56, 59];

/// Makes hostile datagrams, the same ones every time.
struct Hostile {
    seeds: Vec<Vec<u8>>,
    state: u64,
    made: u64,
}

impl Hostile {
    fn new() -> Self {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("pdu/tests/data");
        let mut seeds = Vec::new();
        for file in captures(&data) {
            let Ok(reader) = capture::Reader::open(&file) else { continue };
            seeds.extend(reader.flatten().take(200).map(|d| d.payload));
        }
        assert!(seeds.len() > 100, "captures of other libraries: {}", seeds.len());
        for pdu in samples::pdus() {
            let mut octets = Vec::new();
            pdu.append(&mut octets).expect("a sample can be written");
            seeds.push(octets);
        }
        Self { seeds, state: 1999, made: 0 }
    }

    /// SplitMix64.
    fn draw(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.draw() % limit.max(1) as u64) as usize
    }

    fn seed(&mut self) -> Vec<u8> {
        let at = self.below(self.seeds.len());
        let mut octets = self.seeds[at].clone();
        // Into this exercise, or nobody looks further.
        if let Some(exercise) = octets.get_mut(1) {
            *exercise = 1;
        }
        octets
    }

    fn octets(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.draw() as u8).collect()
    }

    fn number(&mut self) -> f64 {
        const NUMBERS: [f64; 10] =
            [f64::NAN, f64::INFINITY, -1e300, 1e18, 0.0, -0.0, 1e-320, 6.4e6, 4.28e6, 6.4e5];
        match self.below(3) {
            0 => f64::from_bits(self.draw()),
            _ => NUMBERS[self.below(NUMBERS.len())],
        }
    }

    /// A sound Entity State that says nonsense; now and then in the name of one of ours.
    fn nonsense(&mut self) -> Vec<u8> {
        let ours = self.below(4) == 0;
        let id = match ours {
            true => EntityId::new(417, 1 + self.below(16) as u16, 1 + self.below(10) as u16),
            false => EntityId::new(self.draw() as u16, self.draw() as u16, self.draw() as u16),
        };
        let state = EntityState {
            entity_id: id,
            location: Location { x_m: self.number(), y_m: self.number(), z_m: self.number() },
            linear_velocity_mps: Vector32 {
                x: self.number() as f32,
                y: self.number() as f32,
                z: self.number() as f32,
            },
            appearance: self.draw() as u32,
            dead_reckoning_algorithm: pdu::enumerations::DeadReckoningAlgorithm(self.draw() as u8),
            marking: Marking::new(if ours { "EDW229" } else { "HOSTILE" }).expect("short"),
            ..EntityState::default()
        };
        encoded(&state, self.draw() as u32)
    }

    /// A report as only the member `visitors` may send it.
    fn forged_stamp(&mut self) -> Vec<u8> {
        let ids = [0x5345_4556, 0x5345_4541];
        let id = DatumId(ids[self.below(2)]);
        let length = self.below(300);
        let value = match self.below(2) {
            0 => self.octets(length),
            _ => [self.octets(42), self.nonsense()].concat(),
        };
        let report = EventReport {
            originating_id: EntityId::new(417, 65_000, 2),
            receiving_id: EntityId::ALL,
            variable_datums: vec![VariableDatum::new(id, &value)].into(),
            ..EventReport::default()
        };
        encoded(&report, self.draw() as u32)
    }

    fn datagram(&mut self) -> Vec<u8> {
        self.made += 1;
        let mut octets = match self.made % 10 {
            0 => self.seed(),
            1..=3 => {
                let mut octets = self.seed();
                for _ in 0..=self.below(8) {
                    let at = self.below(octets.len());
                    if at != 1 && at < octets.len() {
                        octets[at] = self.draw() as u8;
                    }
                }
                octets
            }
            4 => {
                let octets = self.seed();
                let end = self.below(octets.len());
                octets[..end].to_vec()
            }
            5 => {
                let length = self.below(1500);
                self.octets(length)
            }
            6 => {
                let length = 12 + self.below(400);
                let mut octets = self.octets(length);
                octets[..3].copy_from_slice(&[5 + self.below(3) as u8, 1, self.draw() as u8]);
                octets[8..10].copy_from_slice(&(length as u16).to_be_bytes());
                octets
            }
            7 => self.nonsense(),
            8 => self.forged_stamp(),
            _ => [self.seed(), self.nonsense(), self.seed()].concat(),
        };
        // A list that says that it goes on for ever.
        if self.below(20) == 0 && octets.len() > 40 {
            let at = 12 + self.below(octets.len() - 14);
            octets[at..at + 2].copy_from_slice(&[0xff, 0xff]);
        }
        let orders: Vec<usize> = pdu::frames(&octets)
            .flatten()
            .filter(|frame| ORDERS.contains(&frame.header.pdu_type.0))
            .map(|frame| frame.offset)
            .collect();
        for at in orders {
            octets[at + 1] = 2;
        }
        octets
    }
}

fn encoded(body: &impl pdu::EncodeBody, stamp: u32) -> Vec<u8> {
    let mut octets = Vec::new();
    Envelope::new(1, DisTime(stamp)).append(body, &mut octets).expect("fits");
    octets
}

fn captures(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            match path.extension().and_then(|e| e.to_str()) {
                _ if path.is_dir() => folders.push(path),
                Some("pcap" | "pcapng" | "raw" | "bin") => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found
}

/// Throws `count` datagrams in the time given, evenly; says how many went out.
fn throw(to: &str, count: u64, seconds: f64, over: &AtomicBool) -> u64 {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_broadcast(true).expect("broadcast");
    let mut hostile = Hostile::new();
    let each = Duration::from_secs_f64(seconds / (count as f64 / 100.0));
    let mut sent = 0;
    while sent < count && !over.load(Ordering::Relaxed) {
        for _ in 0..100.min(count - sent) {
            // A datagram longer than the system sends is refused here already.
            let _ = socket.send_to(&hostile.datagram(), to);
            sent += 1;
        }
        std::thread::sleep(each);
    }
    sent
}

/// A run of `seconds` at a rate under `count` datagrams: it ends as it would, and its recording is the run.
fn stands(count: u64, rate: &str, seconds: &str, throwing_s: f64, recorded: bool) -> Value {
    let (ports, folder) = (Ports::new(), Folder::new("hostile"));
    let path = folder.file("run.pcapng");
    let mut arguments = vec!["zurich", "--rate", rate, "--duration", seconds, "--no-viewer"];
    if recorded {
        arguments.extend(["--record", &path]);
    }
    let over = Arc::new(AtomicBool::new(false));
    let (to, until) = (ports.dis.clone(), Arc::clone(&over));
    let thrower = std::thread::spawn(move || throw(&to, count, throwing_s, &until));
    let output = finish(run(&ports, &arguments));
    over.store(true, Ordering::Relaxed);
    let sent = thrower.join().expect("it threw");
    let found = summary(&output);
    let words = stderr(&output);
    println!("{sent} hostile datagrams: {found}\n{words}");
    // 3: the log lost a scan on a busy host, and said so; the run itself is whole.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{words}");
    assert_eq!(found["faults"], Value::Array(Vec::new()), "{found}");
    assert!(!words.contains("panicked") && !words.contains("broken invariant"), "{words}");
    let frames = seconds.parse::<f64>().expect("a number") * 20.0;
    assert_eq!(found["frames"].as_f64(), Some(frames), "{found}");
    assert!(sent * 10 > count * 9, "{sent} of {count} before the run was over");
    if recorded && output.status.code() == Some(0) {
        let mut replay = seeds();
        replay.args(["replay", &path, "--with-smdfm", "--scene", "zurich"]);
        let replayed = summary(&finish(replay));
        for key in ["digest", "track_digest", "foreign", "visitors", "touched"] {
            assert_eq!(replayed[key], found[key], "{key}: {replayed}");
        }
    }
    found
}

#[test]
fn what_is_thrown_is_hostile_and_gives_no_orders() {
    let mut hostile = Hostile::new();
    let (mut sound, mut damaged, mut types) = (0, 0, std::collections::BTreeSet::new());
    for _ in 0..20_000 {
        for received in pdu::pdus(&hostile.datagram()) {
            match received {
                Ok(received) => {
                    let header = received.header();
                    sound += 1;
                    types.insert(header.pdu_type.0);
                    let order = ORDERS.contains(&header.pdu_type.0);
                    assert!(!order || header.exercise_id == 2, "{:?}", header.pdu_type);
                }
                Err(_) => damaged += 1,
            }
        }
    }
    assert!(sound > 5000 && damaged > 5000, "{sound} sound, {damaged} damaged");
    assert!(types.len() > 40 && types.contains(&PduType::ENTITY_STATE.0), "{} types", types.len());
}

/// Who connects and says nothing takes places of the port for a few seconds; with a hundred of them, as the library has it, nobody else was let
/// in for ten. Whoever operates the run is let in meanwhile, and the run is what it is without them.
#[test]
fn two_hundred_silent_connections_leave_the_synchronisation_port_answering() {
    let ports = Ports::new();
    let alone = finish(run(&ports, &["--in-process", "--fast", "--duration", "120"]));
    let arguments = ["--rate", "2", "--duration", "120", "--no-viewer", "--no-visitors"];
    let mut going = common::Background::start(run(&ports, &arguments));
    let running = || (common::status(&ports)?["state"]["phase"] == "RUNNING").then_some(());
    assert!(common::wait_for(common::SOON, running).is_some(), "{:?}", common::status(&ports));
    let to = ports.sync.trim_start_matches("tcp/");
    let silent: Vec<_> = (0..200).map_while(|_| std::net::TcpStream::connect(to).ok()).collect();
    assert_eq!(silent.len(), 200);
    let within = Duration::from_secs(8);
    assert!(common::wait_for(within, running).is_some(), "it does not answer");
    let (frozen, words) = common::operate(&ports, &["freeze"]);
    assert!(frozen, "{words}");
    drop(silent);
    assert!(common::operate(&ports, &["rate", "200"]).0);
    assert!(common::operate(&ports, &["resume"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(common::SOON), Some(0));
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|line| line.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(found["digest"], summary(&alone)["digest"], "{found}");
    assert_eq!(found["faults"], Value::Array(Vec::new()), "{found}");
}

/// The SMDFM stands still while forty thousand datagrams come for it: what its receive buffer cannot hold is thrown away, which it says within
/// 2 s of waking up, with what to do; the run is what it is without that.
#[test]
fn a_receive_buffer_that_overflows_is_told_and_the_run_is_exact() {
    let ports = Ports::new();
    let alone = finish(run(&ports, &["--in-process", "--fast", "--duration", "60"]));
    let arguments = ["--rate", "2", "--duration", "60", "--no-viewer", "--no-visitors"];
    let mut command = run(&ports, &arguments);
    command.args(["--stall-ms", "60000"]);
    let mut going = common::Background::start(command);
    let pid = || {
        let status = common::status(&ports)?;
        let smdfm = status["state"]["members"].as_array()?.iter().find(|m| m["name"] == "smdfm")?;
        let running = status["state"]["phase"] == "RUNNING" && smdfm["frame"].as_u64()? > 20;
        running.then(|| smdfm["pid"].as_i64())?
    };
    let pid = common::wait_for(common::SOON, pid).expect("it runs") as i32;
    common::kill("STOP", pid);
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_broadcast(true).expect("broadcast");
    for _ in 0..40_000 {
        let _ = socket.send_to(&[7; 200], &ports.dis);
    }
    common::kill("CONT", pid);
    let told = || {
        let status = common::status(&ports)?;
        let alarms = status["federates"]["smdfm"]["alarms"].as_array()?.clone();
        alarms
            .into_iter()
            .find(|alarm| alarm.as_str().is_some_and(|a| a.contains("loses datagrams")))
    };
    let told = common::wait_for(Duration::from_secs(10), told);
    let told = told.unwrap_or_else(|| panic!("{:?}", common::status(&ports)));
    let words = told.as_str().expect("a sentence");
    assert!(words.contains("receive buffer is full"), "{words}");
    assert!(words.contains(&ports.dis), "{words}");
    assert!(words.contains("rmem_max") || words.contains("too much to do"), "{words}");
    assert!(common::operate(&ports, &["rate", "200"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(common::SOON), Some(0));
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|line| line.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(found["digest"], summary(&alone)["digest"], "{found}");
}

#[test]
fn twenty_thousand_hostile_datagrams_leave_a_run_and_its_recording_whole() {
    stands(20_000, "4", "40", 8.0, true);
}

/// Octets that are no message, no request and no handshake, requests without an end, and connections on which nothing is said, on the
/// synchronisation port and on the page's: the run is what it is without them, and both ports answer afterwards.
#[test]
fn garbage_on_the_tcp_ports_leaves_the_run_as_it_was_and_both_answering() {
    use std::io::{Read as _, Write as _};
    use std::net::TcpStream;
    let ports = Ports::new();
    let alone = finish(run(&ports, &["--in-process", "--fast", "--duration", "120"]));
    let mut going = common::Background::start(run(&ports, &["--rate", "2", "--duration", "120"]));
    let in_phase = |phase: &str| {
        let there = || (common::status(&ports)?["state"]["phase"] == phase).then_some(());
        common::wait_for(common::SOON, there).is_some()
    };
    assert!(in_phase("RUNNING"), "{:?}", common::status(&ports));
    let mut hostile = Hostile::new();
    let sync = ports.sync.trim_start_matches("tcp/").to_owned();
    let mut kept = Vec::new();
    let mut sent = 0;
    for round in 0..240 {
        let to = [&sync, &ports.page][round % 2];
        // A port whose connections are taken refuses more: no fault of the run.
        let Ok(mut stream) = TcpStream::connect(to) else { continue };
        let _ = stream.set_write_timeout(Some(Duration::from_secs(1)));
        let length = 1 + hostile.below(20_000);
        let noise = hostile.octets(length);
        let octets = match round / 2 % 6 {
            0 => noise,
            // Length of a message, then something else; the longest that two octets can say.
            1 => [&[0xff, 0xff], &noise[..]].concat(),
            2 => [b"GET / HTTP/1.1\r\nX: ", &noise[..]].concat(),
            3 => [
                &b"GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"[..],
                b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
                &noise,
            ]
            .concat(),
            4 => b"POST /seat HTTP/1.1\r\nContent-Length: 18446744073709551615\r\n\r\n{".to_vec(),
            _ => Vec::new(),
        };
        sent += usize::from(stream.write_all(&octets).is_ok());
        if round % 8 < 2 {
            kept.push(stream);
        }
    }
    assert!(sent > 120, "{sent} of 240");
    // Silent connections may take all places of a port for the seconds that it gives them.
    assert!(in_phase("RUNNING"), "{:?}", common::status(&ports));
    let answers = || {
        let mut stream = TcpStream::connect(&ports.page).ok()?;
        stream.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
        let head = format!("GET / HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", ports.page);
        stream.write_all(head.as_bytes()).ok()?;
        let mut start = [0; 12];
        stream.read_exact(&mut start).ok()?;
        (start == *b"HTTP/1.1 200").then_some(())
    };
    assert!(common::wait_for(common::SOON, answers).is_some(), "the page answers");
    drop(kept);
    let (given, words) = common::operate(&ports, &["rate", "200"]);
    assert!(given, "{words}");
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(common::SOON), Some(0));
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|line| line.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(found["digest"], summary(&alone)["digest"], "{found}");
    assert_eq!(found["faults"], Value::Array(Vec::new()), "{found}");
}

#[test]
#[ignore = "a million; named in CONTRIBUTING.md"]
fn a_million_hostile_datagrams_leave_a_run_whole() {
    stands(1_000_000, "1", "90", 45.0, false);
}
