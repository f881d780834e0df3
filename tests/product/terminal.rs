//! `seeds admin-station watch` as a person meets it: in a pseudo-terminal of `script`, with keys. Skipped with a word where that is not there.

use crate::common;

use crate::common::{Background, Ports, SOON, run, wait_for};
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A terminal of 80 by 24 in which `watch` runs; of 40 by 10 two seconds later.
struct Watched {
    script: Background,
    keys: std::process::ChildStdin,
    seen: Arc<Mutex<Vec<u8>>>,
    place: String,
}

/// Whole screen taken, given back, cursor shown again.
const TAKEN: &str = "\x1b[?1049h";
const GIVEN_BACK: &str = "\x1b[?1049l";
const CURSOR: &str = "\x1b[?25h";

impl Watched {
    fn start(ports: &Ports) -> Self {
        let place = format!("watch --every 0.2 --at {}", ports.sync);
        let line = format!(
            "(sleep 2; stty cols 40 rows 10 </dev/tty) & stty cols 80 rows 24; exec {} admin-station {place}",
            env!("CARGO_BIN_EXE_seeds")
        );
        let mut command = Command::new("script");
        command.args(["-qefc", &line, "/dev/null"]).env("TERM", "xterm").env("SHELL", "/bin/sh");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("it starts");
        let keys = child.stdin.take().expect("piped");
        let mut out = child.stdout.take().expect("piped");
        let seen = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&seen);
        std::thread::spawn(move || {
            let mut part = [0; 4096];
            while let Ok(n @ 1..) = out.read(&mut part) {
                kept.lock().expect("kept").extend_from_slice(&part[..n]);
            }
        });
        Self { script: Background(child), keys, seen, place }
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.seen.lock().expect("seen")).into_owned()
    }

    fn shows(&self, words: &str) {
        let shown = wait_for(SOON, || self.text().contains(words).then_some(()));
        assert!(shown.is_some(), "{words}: {:?}", self.text());
    }

    fn press(&mut self, key: &str) {
        self.keys.write_all(key.as_bytes()).and_then(|()| self.keys.flush()).expect("pressed");
    }

    /// It ends with this code, and the terminal is as it was.
    fn ends(mut self, code: i32) {
        assert_eq!(self.script.wait(SOON), Some(code), "{:?}", self.text());
        self.shows(GIVEN_BACK);
        self.shows(CURSOR);
    }
}

fn in_phase(ports: &Ports, phase: &str) -> bool {
    let is = || common::status(ports).is_some_and(|s| s["state"]["phase"] == phase).then_some(());
    wait_for(SOON, is).is_some()
}

#[test]
fn a_screen_shows_the_run_its_keys_operate_it_and_the_terminal_is_given_back() {
    let there = Command::new("script").arg("--version").stdout(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        println!("skipped: there is no `script` (util-linux)");
        return;
    }
    let ports = Ports::new();
    let going = Background::start(run(&ports, &["--no-viewer", "--no-visitors"]));
    assert!(in_phase(&ports, "RUNNING"));
    let mut watched = Watched::start(&ports);
    watched.shows(TAKEN);
    watched.shows("► RUNNING");
    watched.shows("traffic-generator");
    // No key stops a run by itself.
    watched.press("xnyf");
    assert!(in_phase(&ports, "FROZEN"), "{:?}", watched.text());
    watched.shows("Stop the run for everybody?");
    watched.shows("f r freeze s step");
    watched.press("q");
    watched.ends(0);
    assert!(in_phase(&ports, "FROZEN"), "the run is as it was");

    let mut watched = Watched::start(&ports);
    watched.shows("‖ FROZEN");
    watched.press("r");
    assert!(in_phase(&ports, "RUNNING"), "{:?}", watched.text());
    let signalled = Watched::start(&ports);
    signalled.shows("► RUNNING");
    let script = signalled.script.0.id() as i32;
    let found = common::processes(&signalled.place).into_iter().filter(|pid| *pid != script);
    let with = |pid: &i32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        line.split(|octet| *octet == 0).nth(1) == Some(b"admin-station")
    };
    // Both that watch.
    found.filter(with).for_each(|pid| common::kill("TERM", pid));
    signalled.ends(0);
    watched.ends(0);
    let mut watched = Watched::start(&ports);
    watched.shows("► RUNNING");
    assert_eq!(going.interrupt(), Some(0));
    watched.shows("no answer from the");
    std::thread::sleep(Duration::from_millis(300));
    watched.press("q");
    watched.ends(0);
    // Nobody there from the start: no screen, one line, as without a terminal.
    let mut watched = Watched::start(&ports);
    assert_eq!(watched.script.wait(SOON), Some(1), "{:?}", watched.text());
    watched.shows("error:");
    assert!(!watched.text().contains(TAKEN), "{:?}", watched.text());
}
