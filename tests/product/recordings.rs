//! `seeds record`, `replay` and `dis` as a person or a script calls them: real processes on loopback.

use crate::common::{Background, Folder, Ports, finish, run, seeds, stderr, summary, wait_for};
use capture::Recorder;
use pdu::enumerations::StopReason;
use pdu::management::{StartResume, StopFreeze};
use pdu::records::{ClockTime, EntityId};
use pdu::{Body, DisTime, EntityState, Envelope};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const SOON: Duration = Duration::from_secs(30);

/// Three entities, each told once a second for a minute, in datagrams a third of a second apart; the
/// number of the datagram stands in `capabilities`.
fn write(path: &str) {
    let mut recorder = Recorder::create(path).expect("a recording");
    let (from, to): (SocketAddr, SocketAddr) =
        (([10, 0, 0, 7], 4001).into(), ([239, 1, 2, 3], 3000).into());
    for i in 0..180_u32 {
        let ns = u64::from(i) * 1_000_000_000 / 3;
        let state = EntityState {
            entity_id: EntityId::new(5, 6, (i % 3) as u16 + 1),
            capabilities: i,
            ..EntityState::default()
        };
        let mut payload = Vec::new();
        Envelope::new(1, DisTime::absolute(ns)).append(&state, &mut payload).expect("it fits");
        recorder.record(ns as i64, from, to, &payload).expect("written");
    }
    recorder.close(0).expect("closed");
}

fn receiver(ports: &Ports) -> datalink::Receiver {
    datalink::Receiver::open(&link(ports)).expect("a receiver")
}

fn link(ports: &Ports) -> datalink::LinkConfig {
    let to = datalink::Destination::of(ports.dis.parse().expect("an address"));
    datalink::LinkConfig {
        to: datalink::Destinations::new(vec![to]).expect("one"),
        interface: Some([127, 0, 0, 1].into()),
        ..datalink::LinkConfig::default()
    }
}

/// Entity States that came: (exercise, entity, number of the datagram that it was recorded in).
fn states(receiver: &mut datalink::Receiver, wanted: usize) -> Vec<(u8, EntityId, u32)> {
    let mut found = Vec::new();
    for _ in 0..500 {
        if found.len() >= wanted {
            break;
        }
        let arrived = receiver.receive(Some(Duration::from_millis(20)), |arrival| {
            for received in pdu::pdus(arrival.payload).flatten() {
                if let Body::EntityState(s) = received.body() {
                    found.push((received.header().exercise_id, s.entity_id, s.capabilities));
                }
            }
        });
        arrived.expect("received");
    }
    found
}

/// A player that takes commands.
struct Player {
    child: Child,
    answers: std::io::Lines<BufReader<std::process::ChildStdout>>,
}

impl Player {
    fn start(ports: &Ports, file: &str, arguments: &[&str]) -> Self {
        let mut command = seeds();
        command.args(["replay", file, "--control", "--quiet", "--dis", &ports.dis]);
        command.args(["--interface", "127.0.0.1"]).args(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("it starts");
        let answers = BufReader::new(child.stdout.take().expect("its output")).lines();
        Self { child, answers }
    }

    fn tell(&mut self, words: &str) -> Value {
        let stdin = self.child.stdin.as_mut().expect("its input");
        writeln!(stdin, "{words}").expect("told");
        let line = self.answers.next().expect("an answer").expect("text");
        serde_json::from_str(&line).expect("JSON")
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_player_is_paused_sought_stepped_both_ways_and_ended() {
    let (folder, ports) = (Folder::new("player"), Ports::new());
    let file = folder.file("a.pcapng");
    write(&file);
    let mut receiver = receiver(&ports);
    let mut player =
        Player::start(&ports, &file, &["--rate", "0.1", "--set-exercise", "9", "--set-site", "77"]);
    assert_eq!(states(&mut receiver, 1), [(9, EntityId::new(77, 6, 1), 0)], "it plays");
    assert_eq!(player.tell("pause")["phase"], "Paused");
    let sought = player.tell("seek 30");
    assert_eq!((&sought["at_s"], &sought["next"]), (&30.0.into(), &90.into()));
    let alive: Vec<u32> = states(&mut receiver, 3).iter().map(|s| s.2).collect();
    assert_eq!(alive, [87, 88, 89], "the state of each entity before that time");
    assert_eq!(player.tell("step")["next"], 91);
    assert_eq!(states(&mut receiver, 1)[0].2, 90);
    assert_eq!(player.tell("step")["next"], 92);
    assert_eq!(states(&mut receiver, 1)[0].2, 91);
    assert_eq!(player.tell("back")["next"], 91);
    let back: Vec<u32> = states(&mut receiver, 3).iter().map(|s| s.2).collect();
    assert_eq!(back, [88, 89, 90], "as if the last one had not come");
    assert_eq!(player.tell("fast")["phase"], "Paused");
    assert_eq!(player.tell("resume")["phase"], "Playing");
    assert_eq!(states(&mut receiver, 89).last().map(|s| s.2), Some(179), "to the end");
    writeln!(player.child.stdin.as_mut().expect("its input"), "quit").expect("told");
    let last = player.answers.next().expect("a line").expect("text");
    let last: Value = serde_json::from_str(&last).expect("JSON");
    assert_eq!(last["states"], 6);
    assert!(last["datagrams"].as_u64() > Some(91), "{last}");
    assert!(player.child.wait().expect("it ends").success());
}

#[test]
fn a_player_waits_for_start_resume_and_stands_at_stop_freeze() {
    let (folder, ports) = (Folder::new("resume"), Ports::new());
    let file = folder.file("a.pcapng");
    write(&file);
    let (mut sender, mut receiver) = datalink::Link::open(&link(&ports)).expect("a link");
    let mut player = Player::start(&ports, &file, &["--start-on-resume", "--rate", "100"]);
    assert_eq!(player.tell("rate 20")["phase"], "Waiting", "nothing happens of itself");
    let (me, all) = (EntityId::new(1, 1, 0), EntityId::new(0xffff, 0xffff, 0xffff));
    let envelope = Envelope::new(1, DisTime::absolute(0));
    let mut send = |octets: &[u8]| sender.send(octets).expect("sent");
    let mut start = Vec::new();
    let resume = StartResume {
        originating_id: me,
        receiving_id: all,
        real_world_time: ClockTime::default(),
        simulation_time: ClockTime::default(),
        request_id: 1,
    };
    envelope.append(&resume, &mut start).expect("it fits");
    send(&start);
    assert!(!states(&mut receiver, 1).is_empty(), "it plays");
    let mut stop = Vec::new();
    let freeze = StopFreeze {
        originating_id: me,
        receiving_id: all,
        real_world_time: ClockTime::default(),
        reason: StopReason::RECESS,
        frozen_behaviour: 0,
        padding: 0,
        request_id: 2,
    };
    envelope.append(&freeze, &mut stop).expect("it fits");
    send(&stop);
    let stands = wait_for(SOON, || (player.tell("rate 20")["phase"] == "Paused").then_some(()));
    assert!(stands.is_some(), "it stands");
}

#[test]
fn a_recorder_keeps_what_a_player_sends() {
    let (folder, ports) = (Folder::new("record"), Ports::new());
    let (first, second) = (folder.file("a.pcapng"), folder.file("b.pcapng"));
    write(&first);
    let mut command = seeds();
    command.args(["record", &second, "--quiet", "--dis", &ports.dis, "--interface", "127.0.0.1"]);
    let recorder = Background::start(command);
    // The recorder listens once it has made its file.
    assert!(wait_for(SOON, || Path::new(&second).exists().then_some(())).is_some());
    let mut command = seeds();
    command.args(["replay", &first, "--fast", "--quiet", "--dis", &ports.dis]);
    command.args(["--interface", "127.0.0.1"]);
    let output = finish(command);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(summary(&output)["datagrams"], 180);
    assert_eq!(recorder.interrupt(), Some(0));
    let checked = summary(&dis(&["check", &second, "--json"], 0));
    assert_eq!((&checked["pdus"], &checked["damaged"]), (&180.into(), &0.into()), "{checked}");
    dis(&["diff", &first, &second], 0);
}

/// `seeds dis …` ended with this code.
fn dis(arguments: &[&str], code: i32) -> std::process::Output {
    let mut command = seeds();
    command.arg("dis").args(arguments);
    let output = finish(command);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    output
}

fn lines(output: &std::process::Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn a_run_as_fast_as_possible_is_replayed_in_the_time_that_it_simulated() {
    let (folder, ports) = (Folder::new("stamps"), Ports::new());
    let file = folder.file("run.pcapng");
    let mut command: Command = run(&ports, &["--fast", "--duration", "60", "--no-viewer"]);
    command.args(["--record", &file]);
    let output = finish(command);
    assert!(output.status.success(), "{}", stderr(&output));

    let replay = |arguments: &[&str]| {
        let mut command = seeds();
        command.args(["replay", &file, "--fast", "--dis", &ports.dis]);
        finish({
            command.args(["--interface", "127.0.0.1"]).args(arguments);
            command
        })
    };
    let output = replay(&["--from", "20", "--to", "40"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("played by the stamps"), "{}", stderr(&output));
    let sent = summary(&output);
    assert!(sent["states"].as_u64() > Some(0) && sent["datagrams"].as_u64() > Some(0), "{sent}");
    let at_s = sent["at_s"].as_f64().expect("a time");
    assert!((20.0..=40.0).contains(&at_s), "{sent}");

    let output = replay(&["--from", "59", "--schedule", "arrival"]);
    assert_eq!(output.status.code(), Some(2));
    let words = stderr(&output);
    assert!(words.contains("nothing between --from and --to"), "{words}");
    assert_eq!(words.trim().lines().count(), 1, "{words}");
}

#[test]
fn the_tools_count_cut_merge_and_compare() {
    let folder = Folder::new("tools");
    let file = folder.file("a.pcapng");
    write(&file);
    let stat = summary(&dis(&["stat", &file, "--json"], 0));
    assert_eq!(stat["pdus"], 180, "{stat}");

    let dumped = lines(&dis(&["dump", &file, "--json", "--entity", "5:6:2", "--to", "10"], 0));
    assert_eq!(dumped.len(), 10);

    let (early, late) = (folder.file("early.pcapng"), folder.file("late.raw"));
    dis(&["cut", &file, "-o", &early, "--to", "29.9"], 0);
    dis(&["cut", &file, "-o", &late, "--from", "29.9", "--set-exercise", "3"], 0);
    let checked = summary(&dis(&["check", &early, "--json"], 0));
    assert_eq!(checked["pdus"], 90, "{checked}");
    let differ = dis(&["diff", &file, &early], 1);
    assert!(!differ.stdout.is_empty());

    let whole = folder.file("whole.pcapng");
    dis(&["merge", &whole, &early, &late, "--exercise", "1"], 0);
    dis(&["diff", &early, &whole], 0);
    let by_type: BTreeMap<String, u64> = {
        let merged = summary(&dis(&["check", &late, "--json"], 0));
        serde_json::from_value(merged["by_type"].clone()).expect("counts")
    };
    assert_eq!(by_type, BTreeMap::from([("1".to_owned(), 90)]));
}

#[test]
fn a_damaged_file_has_a_code_of_its_own_and_each_error_one_line() {
    let folder = Folder::new("damage");
    let file = folder.file("a.raw");
    let mut octets = Vec::new();
    let envelope = Envelope::new(1, DisTime::absolute(0));
    envelope.append(&EntityState::default(), &mut octets).expect("it fits");
    octets.truncate(100);
    std::fs::write(&file, &octets).expect("written");
    let checked = summary(&dis(&["check", &file, "--json"], 0));
    assert_eq!((&checked["pdus"], &checked["damaged"]), (&0.into(), &1.into()), "{checked}");
    dis(&["check", &file, "--strict"], 1);

    let (whole, cut) = (folder.file("whole.pcapng"), folder.file("cut.pcapng"));
    write(&whole);
    let octets = std::fs::read(&whole).expect("read");
    std::fs::write(&cut, &octets[..octets.len() - 20]).expect("written");
    let checked = summary(&dis(&["check", &cut, "--json"], 3));
    assert!(checked["pdus"].as_u64() >= Some(179), "{checked}");

    for (arguments, code) in [
        (&["dis", "stat", "/nowhere/a.pcap"][..], 2),
        (&["dis", "diff", "/nowhere/a.pcap", &file], 2),
        (&["dis", "cut", &file, "-o", "/nowhere/b.raw"], 1),
        (&["replay", "/nowhere/a.pcap"], 2),
        (&["record", "/nowhere/a.pcapng", "--duration", "1"], 1),
    ] {
        let mut command = seeds();
        command.args(arguments);
        let output = finish(command);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
        let words = stderr(&output);
        assert!(words.contains("/nowhere/"), "{words}");
        assert_eq!(words.trim().lines().count(), 1, "{words}");
    }
}
