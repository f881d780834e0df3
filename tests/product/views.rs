//! A finished run: its log against what the page is shown, and what if, from here.

use federates::viewer_logger::archive::Archive;
use federates::viewer_logger::opened;
use federates::viewer_logger::source::Source;
use serde_json::{Value, json};
use std::io::BufRead as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::common;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("seeds-views-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    fn seeds(&self, arguments: &[&str]) -> Output {
        let ports = common::Ports::new();
        let own = ["--sync-listen", &ports.sync, "--dis", &ports.dis];
        let seeds = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .args(arguments)
            .args(if arguments[0] == "run" { &own[..] } else { &[] })
            .current_dir(&self.0)
            .output()
            .expect("seeds starts");
        assert!(
            seeds.status.success(),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&seeds.stderr)
        );
        seeds
    }

    fn run(&self) -> PathBuf {
        let ended =
            self.seeds(&["run", "zurich", "--fast", "--duration", "90", "--page", "127.0.0.1:0"]);
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        let last = said.lines().last().expect("a line");
        let folder = last.strip_prefix("seeds open ").unwrap_or_else(|| panic!("{said}"));
        let folder = self.0.join(folder);
        // The log says the digests of the last line.
        let line = String::from_utf8_lossy(&ended.stdout).into_owned();
        let line: Value = serde_json::from_str(line.lines().last().expect("a line")).expect("JSON");
        let log = open(&folder);
        for name in ["digest", "track_digest"] {
            assert_eq!(log.fact(name).as_deref(), line[name].as_str(), "{name}");
        }
        assert_eq!(log.fact("foreign"), None, "nothing came from outside");
        folder
    }

    fn fork(&self, run: &Path, more: &[&str]) -> Archive {
        let run = run.to_str().expect("a name");
        let said = self.seeds(&[&["fork", run][..], more].concat());
        let line = String::from_utf8_lossy(&said.stdout).into_owned();
        let folder = line.trim().rsplit(' ').next().expect("a folder").to_owned();
        open(Path::new(&folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

fn open(folder: &Path) -> Archive {
    Archive::open(&folder.join("run.sqlite")).expect("a database")
}

/// Scans whose frames differ, the flags aside.
fn different(a: &Archive, b: &Archive) -> Vec<u64> {
    let frame = |archive: &Archive, scan| {
        let mut octets = archive.message(scan).expect("a frame");
        octets[5] = 0;
        octets
    };
    assert_eq!(a.range(), b.range());
    let (first, last) = a.range().expect("scans");
    (first..=last).filter(|scan| frame(a, *scan) != frame(b, *scan)).collect()
}

#[test]
fn a_fork_is_its_parent_until_it_begins_and_what_changed_after() {
    let folder = Folder::new("fork");
    let run = folder.run();
    let parent = open(&run);
    assert_eq!(parent.range(), Some((1, 90)), "every scan is kept");
    assert!(different(&parent, &folder.fork(&run, &["--at", "40"])).is_empty(), "nothing changed");
    for (what, change) in [
        ("a sensor off", "sensor[ASDE tower].enabled=false"),
        ("another filter", "tracking.filter=imm3"),
        ("rain", "weather.rain_factor=3"),
        ("another seed", "run.sensor_seed=77"),
    ] {
        let fork = folder.fork(&run, &["--at", "40", "--set", change]);
        let first = different(&parent, &fork).first().copied();
        match what {
            "rain" => assert_eq!(first, None, "it is dry until 200 s"),
            _ => assert!(first.is_some_and(|n| n > 40 && n < 60), "{what}: from scan {first:?} on"),
        }
        assert!(fork.events().iter().any(|e| e.kind == "fork" && e.time_ns == 40_000_000_000));
    }
    forks_of_forks_and_again(&folder, &run, &parent);
    an_interrupted_fork_leaves_nothing(&run);
    fork_from_the_page(&run);
    a_recording_alone_is_opened(&folder, &run, &parent);
    let refused = Command::new(env!("CARGO_BIN_EXE_seeds"))
        .args(["fork", run.to_str().expect("a name"), "--at", "4000"])
        .output()
        .expect("seeds starts");
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("lasts from 0 to 90"));
}

/// Ctrl-C: the folder of the fork goes, or it was whole before.
fn an_interrupted_fork_leaves_nothing(run: &Path) {
    let mut interrupted = 0;
    for n in 0..12 {
        let name = format!("cut-{n}");
        let folder = run.join("forks").join(&name);
        let mut fork = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .args([
                "fork",
                run.to_str().expect("a name"),
                "--name",
                &name,
                "--set",
                "tracking.filter=mh27",
            ])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("seeds starts");
        common::wait_for(std::time::Duration::from_secs(60), || folder.exists().then_some(()))
            .expect("a folder");
        common::kill("INT", fork.id() as i32);
        let mut said = String::new();
        std::io::Read::read_to_string(&mut fork.stderr.take().expect("piped"), &mut said)
            .expect("text");
        let code = fork.wait().expect("ended").code();
        if code == Some(0) {
            assert!(folder.join("fork.toml").exists(), "whole");
            continue;
        }
        interrupted += 1;
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("nothing of the fork is kept"), "{said}");
        assert!(!folder.exists(), "half a fork is not one");
        if interrupted == 2 {
            break;
        }
    }
    assert!(interrupted > 0, "none was caught: nothing was put to the test");
}

/// Of a recording without its database: with the scene what the run was, octet by octet; without it the truth as the PDUs say it.
fn a_recording_alone_is_opened(folder: &Folder, run: &Path, parent: &Archive) {
    let alone = folder.0.join("alone.pcapng");
    std::fs::copy(run.join("run.pcapng"), &alone).expect("copied");
    let made = |more: &[&str]| {
        let temporary = folder.0.join("tmp");
        std::fs::remove_dir_all(&temporary).ok();
        std::fs::create_dir_all(&temporary).expect("a folder");
        let mut open = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .args(["open", alone.to_str().expect("a name"), "--page", "127.0.0.1:0"])
            .args(more)
            .env("TMPDIR", &temporary)
            .stdout(Stdio::piped())
            .spawn()
            .expect("seeds starts");
        let mut line = String::new();
        let out = open.stdout.take().expect("its output");
        std::io::BufReader::new(out).read_line(&mut line).expect("an address");
        assert!(line.starts_with("http://"), "{line}");
        let inside = std::fs::read_dir(&temporary).expect("a folder").flatten().next();
        let database = inside.expect("a folder of its own").path().join("alone.sqlite");
        let archive = Archive::open(&database).expect("a database");
        open.kill().ok();
        open.wait().ok();
        archive
    };
    let whole = made(&["--scene", "zurich"]);
    assert!(different(parent, &whole).is_empty());
    assert_eq!(whole.fact("digest"), parent.fact("digest"));
    let truth = made(&[]);
    // What was lost on its way and asked for again stands behind what came after it: nothing changes by that.
    some_come_late(&run.join("run.pcapng"), &alone);
    assert!(different(&truth, &made(&[])).is_empty());
    let report = |archive: &Archive, scan| archive.report(scan).expect("read").expect("a scan");
    let (ours, theirs) = (report(parent, 60), report(&truth, 60));
    assert!(theirs.tracks.is_empty() && theirs.plots.is_empty());
    assert!(ours.truth.len() > 3, "{}", ours.truth.len());
    assert_eq!(ours.truth.len(), theirs.truth.len());
    // Around another reference point: distances of pairs are the same.
    let far = |report: &federates::runtime::messages::ScanReport, a: usize, b: usize| {
        let at = |name: &str| {
            let one = report.truth.iter().find(|t| t.callsign == name).expect("there");
            [one.position_m.x, one.position_m.y]
        };
        let (p, q) = (at(&ours.truth[a].callsign), at(&ours.truth[b].callsign));
        libm::hypot(p[0] - q[0], p[1] - q[1])
    };
    for (a, b) in [(0, 1), (1, 2), (0, 3)] {
        let (here, there) = (far(&ours, a, b), far(&theirs, a, b));
        assert!((here - there).abs() < 0.5 + 1e-3 * here, "{a}, {b}: {here} and {there} m");
    }
}

/// A recording, every 23rd datagram of it twelve places later than it was.
fn some_come_late(recording: &Path, to: &Path) {
    let mut reader = capture::Reader::open(recording).expect("a recording");
    let mut late = capture::Recorder::create(to).expect("a file");
    let mut put = |d: &capture::Datagram| {
        late.record(d.utc_ns, d.from, d.to, &d.payload).expect("written");
    };
    let (mut held, mut count) = (Vec::<(usize, capture::Datagram)>::new(), 0);
    let mut datagram = capture::Datagram::empty();
    while let Some(read) = reader.read(&mut datagram) {
        read.expect("sound");
        count += 1;
        match count % 23 {
            0 => held.push((count + 12, datagram.clone())),
            _ => put(&datagram),
        }
        held.retain(|(due, d)| {
            if *due <= count {
                put(d);
            }
            *due > count
        });
    }
    held.iter().for_each(|(_, d)| put(d));
    late.close(0).expect("written");
}

/// A fork is forked, and made again by its file: the same octets. A file of another run is refused.
fn forks_of_forks_and_again(folder: &Folder, run: &Path, parent: &Archive) {
    let whole = folder.fork(run, &["--at", "30"]);
    assert_eq!(whole.fact("digest"), parent.fact("digest"), "nothing changed");
    let set = |change| ["--set", change];
    let (filter, off) = (set("tracking.filter=ca3"), set("sensor[ASDE tower].enabled=false"));
    let first = folder.fork(run, &[&["--at", "40"][..], &filter, &["--name", "first"]].concat());
    let home = first.path().parent().expect("a folder").to_owned();
    let other = folder.fork(&home, &[&["--at", "60"][..], &off].concat());
    assert!(other.path().starts_with(&home));
    let differ = different(&first, &other);
    assert!(differ.first().is_some_and(|n| *n > 60 && *n < 70), "{differ:?}");
    // Back on: the sensor is there again, beside the tracker of the first fork.
    let home_of_other = other.path().parent().expect("a folder").to_owned();
    let on = set("sensor[ASDE tower].enabled=true");
    let back = folder.fork(&home_of_other, &[&["--at", "70"][..], &on].concat());
    let plots = |archive: &Archive| {
        let report = archive.report(85).expect("read").expect("a scan");
        report.plots.iter().filter(|p| p.kind.word == "asde").count()
    };
    assert_eq!((plots(&other), plots(&back)), (0, plots(&first)));
    // By the file: beside it where it lies with its fork, in its place where that is gone.
    let file = home_of_other.join("fork.toml");
    let again = folder.fork(&file, &[]);
    assert!(different(&other, &again).is_empty());
    assert_ne!(other.path(), again.path());
    assert_eq!(other.fact("digest"), again.fact("digest"));
    assert_ne!(other.fact("digest"), first.fact("digest"));
    let text = std::fs::read_to_string(&file).expect("a file");
    assert!(text.contains("value = false\nwas = true"), "{text}");
    let digest = first.fact("digest").expect("known");
    assert!(text.contains(&format!("parent_digest = \"{digest}\"")), "{text}");
    let place = again.path().parent().expect("a folder").to_owned();
    drop(again);
    std::fs::remove_file(place.join("run.sqlite")).expect("removed");
    let again = folder.fork(&place.join("fork.toml"), &[]);
    assert_eq!(again.path().parent().map(Path::to_owned), Some(place.clone()));
    assert!(different(&other, &again).is_empty());
    // Of another run, or of one that is gone: said, with both named.
    std::fs::remove_file(place.join("run.sqlite")).expect("removed");
    for (part, by, says) in [
        (&digest[..], "0123456789abcdef", "it is another run"),
        ("parent = \"first\"", "parent = \"gone\"", "its parent 'gone' is gone"),
    ] {
        let wrong = text.replacen(part, by, 1);
        assert_ne!(wrong, text);
        std::fs::write(place.join("fork.toml"), wrong).expect("written");
        let refused = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .arg("fork")
            .arg(place.join("fork.toml"))
            .current_dir(&folder.0)
            .output()
            .expect("seeds starts");
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains(says) && said.contains("fork.toml"), "{said}");
        assert!(place.join("fork.toml").is_file(), "the file is left alone");
    }
}

/// A page asks for a fork: it is made, is among the runs, and the difference is told; what cannot be is refused with its reason.
fn fork_from_the_page(run: &Path) {
    let mut open = Command::new(env!("CARGO_BIN_EXE_seeds"))
        .args(["open", run.to_str().expect("a name"), "--page", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("seeds starts");
    let mut line = String::new();
    let out = open.stdout.take().expect("its output");
    std::io::BufReader::new(out).read_line(&mut line).expect("an address");
    let at = line.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
    let uri = format!("ws://{at}/socket").parse().expect("a URI");
    let request =
        tungstenite::ClientRequestBuilder::new(uri).with_header("Origin", format!("http://{at}"));
    let mut socket = tungstenite::connect(request).expect("connected").0;
    let runs = loop {
        let message = socket.read().expect("a message");
        let found = message.to_text().ok().and_then(|t| serde_json::from_str::<Value>(t).ok());
        if let Some(runs) = found.filter(|m| m["type"] == "runs") {
            break runs;
        }
    };
    let parent = runs["runs"][0]["id"].as_str().expect("a name").to_owned();
    let mut ask = |id: u32, run: &str, key: &str, value: &str| {
        let message =
            json!({"type": "fork", "id": id, "run": run, "at_s": 40.0, "changes": [[key, value]]});
        socket.send(tungstenite::Message::text(message.to_string())).expect("sent");
        loop {
            let message = socket.read().expect("a message");
            let Ok(text) = message.to_text() else { continue };
            let Ok(value) = serde_json::from_str::<Value>(text) else { continue };
            let ended = value["type"] == "fork" && value["id"] == id && value["state"] != "running";
            if ended || value["type"] == "refused" {
                return value;
            }
        }
    };
    let done = ask(7, &parent, "sensor[ASDE tower].enabled", "false");
    assert_eq!(done["state"], "done", "{done}");
    assert!(done["run"].as_str().is_some_and(|r| r != parent), "{done}");
    let first_s = done["difference"]["first_s"].as_f64().expect("it differs");
    assert!((40.0..60.0).contains(&first_s), "{done}");
    assert!(done["text"].as_str().is_some_and(|t| t.contains("untracked")), "{done}");
    let bad = ask(8, &parent, "tracking.filter", "nonsense");
    assert_eq!(bad["state"], "failed", "{bad}");
    assert!(bad["text"].as_str().is_some_and(|t| t.contains("nonsense")), "{bad}");
    let none = ask(9, "nobody", "tracking.filter", "imm3");
    assert!(none["text"].as_str().is_some_and(|t| t.contains("no such run")), "{none}");
    open.kill().ok();
    open.wait().ok();
}

#[test]
fn the_incursion_of_the_first_hour_is_one_alert_on_the_page_in_the_picture_and_in_the_report() {
    let folder = Folder::new("incursion");
    let report = folder.0.join("report");
    let told = report.to_str().expect("a name");
    folder.seeds(&[
        "run",
        "asmgcs",
        "--fast",
        "--duration",
        "180",
        "--page",
        "127.0.0.1:0",
        "--report",
        told,
    ]);
    let viewer = opened::viewer(&report.join("run.sqlite")).expect("opened");
    let alerts = |s: i64| viewer.alerts_at(s * 1_000_000_000)["open"].clone();
    assert_eq!(alerts(60), serde_json::json!([]));
    let raised: Vec<_> = viewer.events().into_iter().filter(|e| e.kind == "alert").collect();
    assert_eq!(raised.len(), 1, "recorded movements follow no clearances: {raised:?}");
    assert_eq!(raised[0].subject, "FOLLOW2 SWR137H");
    let standing = alerts(raised[0].time_ns / 1_000_000_000);
    assert_eq!(
        (&standing[0]["kind"], &standing[0]["stage"]),
        (&"RMCA_ROLL".into(), &"alarm".into())
    );

    // The picture of that moment, in both forms, and a series.
    let at = (raised[0].time_ns / 1_000_000_000).to_string();
    for form in ["svg", "png"] {
        let file = folder.0.join(format!("map.{form}"));
        let file = file.to_str().expect("a name");
        folder.seeds(&["picture", told, "--at", &at, "--view", "#fit=targets&col=day", "-o", file]);
        let octets = std::fs::read(file).expect("written");
        let words = String::from_utf8_lossy(&octets);
        match form {
            "svg" => {
                assert!(words.contains("<title>FOLLOW2</title>"), "its label");
                assert!(words.contains("RMCA_ROLL FOLLOW2 SWR137H"), "the alert");
            }
            _ => assert!(octets.starts_with(b"\x89PNG")),
        }
    }
    let before = folder.0.join("before.svg");
    let before = before.to_str().expect("a name");
    folder.seeds(&["picture", told, "--at", "60", "-o", before]);
    let words = std::fs::read_to_string(before).expect("written");
    assert!(!words.contains("RMCA"), "nothing stands yet");
    // 0 is a time: nothing is there yet, and no duration is asked for.
    let at_0 = Command::new(env!("CARGO_BIN_EXE_seeds"))
        .args(["picture", told, "--at", "0", "-o", "x.png"])
        .current_dir(&folder.0)
        .output()
        .expect("seeds starts");
    let said = String::from_utf8_lossy(&at_0.stderr).into_owned();
    assert!(said.contains("there is no picture at 0 s: the run lasts from 1"), "{said}");
    let series = folder.0.join("frames.svg");
    let series = series.to_str().expect("a name");
    folder.seeds(&["picture", told, "--from", "10", "--to", "12", "--every", "1", "-o", series]);
    assert_eq!(std::fs::read_dir(folder.0.join("frames")).expect("a folder").count(), 3);
    for (words, says) in [
        (vec!["--at", "4000", "-o", "x.png"], "there is no picture at 4000 s"),
        (vec!["-o", "x.jpg"], "which form"),
        (vec!["--view", "z=0", "-o", "x.png"], "z=0 cannot be read"),
        (vec!["--from", "5", "--to", "2", "--every", "1", "-o", "x.png"], "is after --to"),
    ] {
        let refused = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .args([&["picture", told][..], &words].concat())
            .current_dir(&folder.0)
            .output()
            .expect("seeds starts");
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains(says), "{said}");
    }

    // The report begins with its verdict and says how it was made.
    let page = std::fs::read_to_string(report.join("report.html")).expect("a report");
    let place = |words: &str| page.find(words).unwrap_or_else(|| panic!("no {words:?}"));
    assert!(place("<h2>Verdict</h2>") < place("<h2>Errors over time</h2>"));
    for words in ["The requirement is", "runways", "<h2>Detection by area</h2>", "FOLLOW2</text>"] {
        place(words);
    }
    for words in ["run asmgcs --fast", "cores, linux", "[airport]"] {
        place(words);
    }
}

#[test]
fn every_command_has_its_manual_page() {
    let folder = Folder::new("man");
    let pages = folder.0.join("man");
    folder.seeds(&["man", pages.to_str().expect("a name")]);
    for name in ["seeds.1", "seeds-run.1", "seeds-picture.1", "seeds-dis-cut.1"] {
        let text =
            std::fs::read_to_string(pages.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(text.contains(".TH"), "{name}");
    }
}
