//! A standby as a process: the station is killed or stands still, the standby is, one after the other; the run is the one in which
//! nothing happened.

use crate::common;

use crate::common::{Background, Folder, Ports, SOON, finish, run, summary, wait_for};
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;

/// Simulated seconds of these runs, and how fast they are.
const DURATION: &str = "90";
const RATE: &str = "3";

/// A run in which every process was started by hand.
struct Run {
    folder: Folder,
    /// Where the station listens, and its standby.
    stations: [Ports; 2],
    members: Vec<Background>,
}

impl Run {
    /// Three members, at `station`.
    fn new(name: &str) -> Self {
        let stations = [Ports::new(), Ports::new()];
        Self { folder: Folder::new(name), stations, members: Vec::new() }
    }

    fn member(&mut self, name: &str, at: usize) {
        let mut command = common::seeds();
        let (sync, dis) = (&self.stations[at].sync, &self.stations[0].dis);
        command.args([name, "--scene", "zurich", "--sync-connect", sync, "--dis", dis]);
        common::patient(&mut command);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        self.members.push(Background(command.spawn().expect("it starts")));
    }

    /// A station, or its standby, with its words in a file of that name.
    fn station(&self, name: &str, at: usize, more: &[&str]) -> Background {
        let mut command = common::seeds();
        let (sync, dis) = (&self.stations[at].sync, &self.stations[0].dis);
        let words =
            std::fs::File::create(self.folder.file(&format!("{name}.txt"))).expect("a file");
        command.args(["admin-station", "--scene", "zurich", "--rate", RATE, "--batch"]);
        command.args(["--duration", DURATION, "--return-ms", "none", "--on-loss", "freeze"]);
        command.args(["--sync-listen", sync, "--dis", dis]);
        command.args(["--journal", &self.folder.file(&format!("{name}.journal"))]).args(more);
        command.stdout(Stdio::piped()).stderr(words);
        Background(command.spawn().expect("it starts"))
    }

    fn standby(&self, name: &str, at: usize) -> Background {
        let first = self.stations[1 - at].sync.clone();
        let standby = self.station(name, at, &["--standby", "--sync-connect", &first]);
        assert!(self.said(name, "holds the journal"), "{name}: {}", self.words(name));
        standby
    }

    fn words(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.file(&format!("{name}.txt"))).unwrap_or_default()
    }

    /// Whether that station says so, soon.
    fn said(&self, name: &str, what: &str) -> bool {
        wait_for(SOON, || self.words(name).contains(what).then_some(())).is_some()
    }

    /// Waits until the run, at that station, is beyond a frame.
    fn beyond(&self, at: usize, frame: u64) -> u64 {
        let beyond = || {
            let status = common::status(&self.stations[at])?;
            let running = status["state"]["phase"] == "RUNNING";
            status["state"]["frame"].as_u64().filter(|at| running && *at > frame)
        };
        wait_for(SOON, beyond).unwrap_or_else(|| panic!("{:?}", common::status(&self.stations[at])))
    }

    /// The run ends at that station, and is the one in which nothing happened.
    fn ends(&self, station: Background, name: &str) {
        ends(station, &self.words(name));
    }
}

fn ends(mut station: Background, words: &str) {
    let stdout = station.0.stdout.take().expect("piped");
    assert_eq!(station.wait(SOON), Some(0), "{words}");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    let alone = ["zurich", "--in-process", "--fast", "--duration", DURATION];
    let undisturbed = summary(&finish(run(&Ports::new(), &alone)));
    for key in ["digest", "track_digest", "frames"] {
        assert_eq!(found[key], undisturbed[key], "{key}: {found}");
    }
}

const MEMBERS: [&str; 3] = ["traffic-generator", "external-world", "smdfm"];

/// The station is killed, and the SMDFM a tenth of a second later; its replacement finds the standby, which leads.
#[test]
fn the_standby_leads_on_when_the_station_is_killed() {
    let mut going = Run::new("standby-killed");
    let station = going.station("first", 0, &[]);
    MEMBERS.iter().for_each(|name| going.member(name, 0));
    going.beyond(0, 20);
    let standby = going.standby("second", 1);
    let frame = going.beyond(0, 60);
    common::kill("KILL", station.0.id() as i32);
    std::thread::sleep(Duration::from_millis(100));
    common::kill("KILL", going.members[2].0.id() as i32);
    assert!(going.said("second", "leads from here"), "{}", going.words("second"));
    going.member("smdfm", 1);
    going.beyond(1, frame + 100);
    assert!(going.members[0].0.try_wait().expect("known").is_none(), "members stay");
    going.ends(standby, "second");
    assert!(!std::path::Path::new(&going.folder.file("second.journal")).exists(), "over");
}

/// A station that stands still for four seconds is followed by its standby. It ends when it wakes up, and says why; the run does not
/// hear of it.
#[test]
fn a_station_that_stood_still_hears_that_its_standby_leads() {
    let mut going = Run::new("standby-paused");
    let mut station = going.station("first", 0, &[]);
    MEMBERS.iter().for_each(|name| going.member(name, 0));
    going.beyond(0, 20);
    let standby = going.standby("second", 1);
    let frame = going.beyond(0, 60);
    common::kill("STOP", station.0.id() as i32);
    assert!(going.said("second", "leads from here"), "{}", going.words("second"));
    going.beyond(1, frame + 40);
    common::kill("CONT", station.0.id() as i32);
    assert_eq!(station.wait(SOON), Some(1), "{}", going.words("first"));
    assert!(going.words("first").contains("its standby leads"), "{}", going.words("first"));
    going.ends(standby, "second");
}

/// A standby that is killed holds nothing up for long; the next one begins from nothing while the run goes on, and leads on when the
/// station is killed as well.
#[test]
fn the_run_goes_on_without_its_standby_and_with_the_next_one() {
    let mut going = Run::new("standby-lost");
    let station = going.station("first", 0, &[]);
    MEMBERS.iter().for_each(|name| going.member(name, 0));
    going.beyond(0, 20);
    let standby = going.standby("second", 1);
    let frame = going.beyond(0, 60);
    common::kill("KILL", standby.0.id() as i32);
    assert!(going.said("first", "goes on without the standby"), "{}", going.words("first"));
    let frame = going.beyond(0, frame + 60);
    let standby = going.standby("third", 1);
    let frame = going.beyond(0, frame + 40);
    common::kill("KILL", station.0.id() as i32);
    going.beyond(1, frame + 40);
    going.ends(standby, "third");
}

/// What cannot be: a station without a journal, another run; each is one clear error.
#[test]
fn a_standby_of_nothing_that_can_be_followed_is_refused() {
    let mut going = Run::new("standby-refused");
    let _station = going.station("first", 0, &[]);
    MEMBERS.iter().for_each(|name| going.member(name, 0));
    going.beyond(0, 20);
    let first = going.stations[0].sync.clone();
    let other = ["--standby", "--sync-connect", &first, "--seed", "999"];
    let mut standby = going.station("second", 1, &other);
    assert_eq!(standby.wait(SOON), Some(1), "{}", going.words("second"));
    assert!(going.words("second").contains("leads another run"), "{}", going.words("second"));
    let mut command = common::seeds();
    command.args(["admin-station", "--standby", "--sync-connect", &first]);
    let output = finish(command);
    assert_eq!(output.status.code(), Some(2));
    assert!(common::stderr(&output).contains("--journal"), "{}", common::stderr(&output));
}
