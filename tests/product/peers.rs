//! What other people's programs see of a run: receivers' decoders, HTTP, Python. A peer that is not installed is skipped with a word.

#![expect(clippy::print_stdout, reason = "what was skipped, and what was measured")]

use crate::common::{Background, Folder, Ports, finish, run, seeds, stderr, summary, wait_for};
use mode_s::cpr::{self, Span};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

fn free_port() -> String {
    format!("127.0.0.1:{}", crate::common::free_port())
}

pub(crate) fn skipped(what: &str, how: &str) {
    println!("SKIPPED: {what} is not installed ({how})");
}

/// Body of a GET; none while nobody answers.
fn get(address: &str, path: &str) -> Option<(u16, String)> {
    let mut stream = TcpStream::connect(address).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").ok()?;
    let mut text = String::new();
    stream.read_to_string(&mut text).ok()?;
    let code = text.split(' ').nth(1)?.parse().ok()?;
    let (_, body) = text.split_once("\r\n\r\n")?;
    Some((code, body.to_owned()))
}

fn json(address: &str, path: &str) -> Option<Value> {
    let (code, body) = get(address, path)?;
    (code == 200).then(|| serde_json::from_str(&body).expect("JSON"))
}

/// Metres between two places near each other.
fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let north = (a[0] - b[0]).to_radians() * 6_371_000.0;
    let east = (a[1] - b[1]).to_radians() * 6_371_000.0 * libm::cos(a[0].to_radians());
    libm::hypot(north, east)
}

fn place(target: &Value) -> Option<[f64; 2]> {
    Some([target["lat"].as_f64()?, target["lon"].as_f64()?])
}

/// One run with every port: nobody changes its digest, whoever reads, sleeps or sends garbage.
#[test]
fn eyes_of_others_change_nothing_and_see_the_airport() {
    let (ports, folder) = (Ports::new(), Folder::new("peers"));
    let (beast, sbs, http) = (free_port(), free_port(), free_port());
    let recording = folder.file("run.pcapng");
    let mut command = run(
        &ports,
        &[
            "zurich",
            "--duration",
            "40",
            "--rate",
            "2",
            "--seed",
            "5",
            "--no-viewer",
            "--adsb-invent",
        ],
    );
    command.args(["--beast", &beast, "--sbs", &sbs, "--http", &http, "--record", &recording]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut lines =
        wait_for(Duration::from_secs(60), || TcpStream::connect(&sbs).ok()).expect("SBS");
    let sleeper = TcpStream::connect(&beast).expect("Beast");
    let mut garbage = TcpStream::connect(&beast).expect("Beast");
    garbage.write_all(&[0xff; 4096]).expect("sent");
    let decoder = Decoder::start(&beast, &folder);
    if decoder.is_none() {
        skipped("dump1090-mutability", "apt-get install dump1090-mutability");
    }

    let state =
        wait_for(Duration::from_secs(60), || json(&http, "/api/v1/state")).expect("a state");
    assert_eq!((&state["schema"], &state["airport"]), (&"seeds.state/1".into(), &"LSZH".into()));
    let late = |scan: &Value| scan["scan"].as_u64().is_some_and(|n| n >= 24);
    let scan = wait_for(Duration::from_secs(60), || json(&http, "/api/v1/scan").filter(late))
        .expect("a scan");
    assert!(scan["tracks"].as_array().expect("tracks").len() > 2, "{scan}");
    let aircraft = json(&http, "/data/aircraft.json").expect("targets");
    let seen = aircraft["aircraft"].as_array().expect("a list");
    assert!(seen.len() >= 4, "{aircraft}");
    if let Some(decoder) = &decoder {
        decoder.agrees_with(&http);
    }
    let (code, words) = get(&http, "/nothing").expect("an answer");
    assert!(code == 404 && words.contains("/api/v1/tracks.geojson"), "{words}");
    let map = json(&http, "/api/v1/tracks.geojson").expect("a map");
    assert_eq!(map["type"], "FeatureCollection");

    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let mut text = String::new();
    lines.set_read_timeout(Some(Duration::from_secs(5))).expect("set");
    lines.read_to_string(&mut text).expect("lines until the run's end");
    assert!(
        text.lines().count() > 50 && text.lines().all(|l| l.split(',').count() == 22),
        "{text}"
    );
    drop((sleeper, garbage, decoder));
    assert!(stderr(&output).contains("--lat 47."), "a decoder's command line: {}", stderr(&output));

    let alone = ["zurich", "--fast", "--duration", "40", "--seed", "5", "--no-viewer"];
    let alone = finish(run(&Ports::new(), &alone));
    assert_eq!(summary(&output)["digest"], summary(&alone)["digest"]);
    exported(&folder);
    in_python(&folder);
}

/// A real dump1090 that reads the Beast port and writes its picture into a folder.
struct Decoder {
    /// Ends with this.
    _running: Background,
    picture: PathBuf,
}

impl Decoder {
    fn start(beast: &str, folder: &Folder) -> Option<Self> {
        let program = "dump1090-mutability";
        Command::new(program)
            .arg("--help")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .ok()?;
        let pictures = folder.0.join("pictures");
        std::fs::create_dir_all(&pictures).expect("a folder");
        let input = free_port();
        let port = input.rsplit(':').next().expect("a port").to_owned();
        let mut command = Command::new(program);
        command.args(["--net-only", "--net-bi-port", &port, "--net-bind-address", "127.0.0.1"]);
        for other in
            ["--net-ri-port", "--net-ro-port", "--net-sbs-port", "--net-bo-port", "--net-http-port"]
        {
            command.args([other, "0"]);
        }
        command.args([
            "--lat",
            "47.458",
            "--lon",
            "8.548",
            "--quiet",
            "--write-json-every",
            "0.5",
            "--write-json",
        ]);
        command.arg(&pictures);
        let running = Background::start(command);
        let mut into = wait_for(Duration::from_secs(10), || TcpStream::connect(&input).ok())?;
        // It listens for Beast rather than fetches it: hand it over.
        let mut from = TcpStream::connect(beast).expect("Beast");
        std::thread::spawn(move || std::io::copy(&mut from, &mut into));
        Some(Self { _running: running, picture: pictures.join("aircraft.json") })
    }

    /// Every target that we show, it shows within a metre of where we had it at one of the last moments.
    fn agrees_with(&self, http: &str) {
        let mut own: Vec<Value> = Vec::new();
        let mut best: std::collections::BTreeMap<String, f64> = std::collections::BTreeMap::new();
        let mut expected = Vec::new();
        for _ in 0..60 {
            std::thread::sleep(Duration::from_millis(100));
            own.extend(json(http, "/data/aircraft.json"));
            let Ok(text) = std::fs::read_to_string(&self.picture) else { continue };
            let Ok(picture) = serde_json::from_str::<Value>(&text) else { continue };
            expected =
                own.last().and_then(|o| o["aircraft"].as_array().cloned()).unwrap_or_default();
            for target in picture["aircraft"].as_array().into_iter().flatten() {
                let hex =
                    target["hex"].as_str().unwrap_or_default().trim_start_matches('~').to_owned();
                let Some(there) = place(target) else { continue };
                for picture in &own {
                    let same = |t: &&Value| {
                        t["hex"].as_str().is_some_and(|h| h.trim_start_matches('~') == hex)
                    };
                    let ours = picture["aircraft"].as_array().into_iter().flatten().find(same);
                    if let Some(here) = ours.and_then(place) {
                        // A squitter comes between two scans as well, half a second on in a straight line.
                        let half_m =
                            ours.and_then(|t| t["gs"].as_f64()).unwrap_or(0.0) * 1852.0 / 7200.0;
                        let track =
                            ours.and_then(|t| t["track"].as_f64()).unwrap_or(0.0).to_radians();
                        let north = (half_m * libm::cos(track) / 6_371_000.0).to_degrees();
                        let wide = 6_371_000.0 * libm::cos(here[0].to_radians());
                        let east = (half_m * libm::sin(track) / wide).to_degrees();
                        let later = [here[0] + north, here[1] + east];
                        // In the air the code itself has steps of 5.1 m (3.6 m off in a corner): what it makes of the place is what
                        // has to be shown. On the ground a step is 1.3 m.
                        let flies = ours.is_some_and(|t| t["alt_baro"] != "ground");
                        let span = if flies { Span::Airborne } else { Span::Surface };
                        let coded = |place: [f64; 2], odd| {
                            cpr::decode(cpr::encode(place[0], place[1], odd, span), place, span)
                        };
                        let of = |place| [coded(place, false), coded(place, true)];
                        let places = [[here, later], of(here), of(later)].concat();
                        let places = if flies { &places[2..] } else { &places[..2] };
                        let off = places.iter().map(|place| apart_m(*place, there));
                        let off_m = off.fold(f64::INFINITY, f64::min);
                        let least = best.entry(hex.clone()).or_insert(f64::INFINITY);
                        *least = least.min(off_m);
                    }
                }
            }
        }
        assert!(expected.len() >= 4);
        for target in &expected {
            let hex = target["hex"].as_str().expect("an address").trim_start_matches('~');
            let off_m = best.get(hex).copied();
            println!("dump1090 shows {hex} within {off_m:?} m");
            assert!(off_m.is_some_and(|m| m <= 1.0), "{hex}: {off_m:?} m in {best:?}");
        }
    }
}

/// The run's database in every form.
fn exported(folder: &Folder) {
    let recording = folder.file("run.pcapng");
    let mut texts = Vec::new();
    for name in ["run.geojson", "run.kml", "run.czml", "run.csv"] {
        let file = folder.file(name);
        let mut command = seeds();
        command.args(["export", &recording, "-o", &file]);
        let output = finish(command);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
        texts.push(std::fs::read_to_string(&file).expect(name));
    }
    let database = rusqlite::Connection::open(folder.file("run.sqlite")).expect("the database");
    let count = |table: &str| -> usize {
        let query = format!("SELECT count(*) FROM {table}");
        database.query_row(&query, [], |r| r.get::<_, i64>(0)).expect("a count") as usize
    };
    let rows = count("tracks") + count("truth");
    assert_eq!(texts[3].lines().count(), rows + 1, "a row a report");
    let map: Value = serde_json::from_str(&texts[0]).expect("GeoJSON");
    let points = |f: &Value| match f["geometry"]["type"].as_str() {
        Some("LineString") => f["geometry"]["coordinates"].as_array().map_or(0, Vec::len),
        _ => 1,
    };
    let features = map["features"].as_array().expect("features");
    let is_place = |f: &Value| f["properties"]["times"].is_null();
    let (places, features): (Vec<&Value>, Vec<&Value>) = features.iter().partition(|f| is_place(f));
    let kinds = |kind: &str| places.iter().filter(|f| f["properties"]["kind"] == kind).count();
    assert_eq!((kinds("runway"), kinds("sensor")), (3, 1), "the airport");
    assert!(kinds("taxiway") > 100 && kinds("stand") > 20 && kinds("hold") > 5);
    assert_eq!(features.iter().map(|f| points(f)).sum::<usize>(), rows);
    assert!(
        features
            .iter()
            .all(|f| f["properties"]["times"].as_array().map_or(0, Vec::len) == points(f))
    );
    let fact = |name: &str| -> String {
        let query = "SELECT value FROM run WHERE name = ?1";
        database.query_row(query, [name], |r| r.get(0)).expect(name)
    };
    assert_eq!(map["run"]["scene"], "zurich");
    // A run is called as its folder is.
    let name = std::path::PathBuf::from(folder.file(""));
    let name = name.file_name().expect("a folder").to_string_lossy().into_owned();
    assert_eq!((&map["run"]["run"], &map["run"]["map_json"]), (&name.into(), &Value::Null));
    assert_eq!(map["run"]["digest"], fact("digest"), "the run's own");
    assert!(!texts[1].contains("map_json") && texts[1].contains("<Folder><name>airport</name>"));
    assert_eq!(texts[1].matches("<when>").count(), rows);
    assert_eq!(texts[1].matches("<gx:coord>").count(), rows);
    let packets: Value = serde_json::from_str(&texts[2]).expect("CZML");
    let numbers = |p: &Value| p["position"]["cartographicDegrees"].as_array().map_or(0, Vec::len);
    let packets = packets.as_array().expect("packets");
    assert_eq!(packets.iter().map(numbers).sum::<usize>(), 4 * rows);
    // Alerts in every form, and what no form has.
    for (name, says) in
        [("a.csv", "time_s,end_s,kind"), ("a.geojson", "{"), ("a.kml", "<?xml"), ("a.czml", "[")]
    {
        let file = folder.file(name);
        let mut command = seeds();
        command.args(["export", &recording, "--what", "alerts", "-o", &file]);
        assert_eq!(finish(command).status.code(), Some(0), "{name}");
        let text = std::fs::read_to_string(&file).expect(name);
        assert!(text.starts_with(says) && !text.contains("<Folder>"), "{name}: {text}");
    }
    for (what, name) in [
        ("airport", "x.csv"),
        ("airport", "x.czml"),
        ("plots", "x.kml"),
        ("alerts,tracks", "x.csv"),
    ] {
        let mut command = seeds();
        command.args(["export", &recording, "--what", what, "-o", &folder.file(name)]);
        assert_eq!(finish(command).status.code(), Some(2), "{what} in {name}");
    }
    let mut command = seeds();
    command.args(["export", &folder.file("nothing.sqlite"), "-o", &folder.file("x.csv")]);
    assert_eq!(finish(command).status.code(), Some(2));
}

/// The Python with the client's packages, if there is one.
pub(crate) fn python(modules: &str) -> Option<String> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/python/.venv/bin/python");
    let named = std::env::var("SEEDS_PYTHON").ok();
    let candidates = named.into_iter().chain([own.to_owned(), "python3".to_owned()]);
    candidates.into_iter().find(|python| {
        let mut command = Command::new(python);
        command
            .args(["-c", &format!("import {modules}")])
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    })
}

fn client_tests(file: &str, settings: &[(&str, &str)], python: &str) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/python");
    let mut command = Command::new(python);
    command.args(["-m", "unittest", "-v", file]).current_dir(format!("{folder}/tests"));
    command.env("PYTHONPATH", format!("{folder}/src")).env("PYTHONDONTWRITEBYTECODE", "1");
    command.env("SEEDS", env!("CARGO_BIN_EXE_seeds")).envs(settings.iter().copied());
    let output = finish(command);
    assert!(output.status.success(), "{}", stderr(&output));
    println!("{}", stderr(&output));
}

/// The finished run, read by the client: rows, data frames, Parquet, the notebook.
fn in_python(folder: &Folder) {
    let Some(python) = python("pandas, pyarrow, nbclient, matplotlib, ipykernel") else {
        return skipped(
            "pandas, pyarrow, nbclient, matplotlib or ipykernel",
            "clients/python/install.sh",
        );
    };
    let (log, out) = (folder.file("run.sqlite"), folder.file("parquet"));
    client_tests("test_log.py", &[("SEEDS_LOG", &log), ("SEEDS_OUT", &out)], &python);
}

/// Which versions of the messages the client takes: without a run.
#[test]
fn the_python_client_takes_a_run_that_speaks_its_version_among_others() {
    let Some(python) = python("unittest") else {
        return skipped("python3", "apt-get install python3");
    };
    client_tests("test_version.py", &[], &python);
}

/// The public interface, seen by the Python client: every scan, values of the database, commands, garbage.
#[test]
fn the_python_client_sees_and_commands_a_run() {
    let Some(python) = python("zenoh, jsonschema") else {
        return skipped("eclipse-zenoh or jsonschema for Python", "clients/python/install.sh");
    };
    let (ports, folder) = (Ports::new(), Folder::new("public"));
    let (public, recording) = (format!("tcp/{}", free_port()), folder.file("run.pcapng"));
    let mut command = run(
        &ports,
        &["zurich", "--duration", "60", "--rate", "4", "--seed", "5", "--no-viewer", "--wait"],
    );
    command.args([&format!("--public={public}"), "--record", &recording]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/schema/seeds-v1.json");
    let log = folder.file("run.sqlite");
    let settings = [("SEEDS_PUBLIC", &public[..]), ("SEEDS_SCHEMA", schema), ("SEEDS_LOG", &log)];
    client_tests("test_live.py", &settings, &python);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let alone = ["zurich", "--fast", "--duration", "60", "--seed", "5", "--no-viewer"];
    let alone = finish(run(&Ports::new(), &alone));
    assert_eq!(summary(&output)["digest"], summary(&alone)["digest"], "clients change nothing");
}

/// Ten at all ports: readers, one of each asleep, one of each that sends garbage. Digest and frames of the run are what they are alone; its speed
/// is printed beside that of a run without anybody.
#[test]
fn ten_clients_some_asleep_some_rude_change_nothing() {
    let (ports, beast, sbs, http) = (Ports::new(), free_port(), free_port(), free_port());
    let of_run = [
        "zurich",
        "--duration",
        "32",
        "--rate",
        "4",
        "--seed",
        "7",
        "--no-viewer",
        "--no-visitors",
    ];
    let mut command = run(&ports, &of_run);
    command.args(["--beast", &beast, "--sbs", &sbs, "--http", &http, "--adsb-invent"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let connect = |port: &String| {
        wait_for(Duration::from_secs(60), || TcpStream::connect(port).ok()).expect("a port")
    };
    let ask = |mut stream: TcpStream, path: &str| {
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {http}\r\n\r\n").expect("asked");
        stream
    };
    // Awake: Beast, SBS, the stream of scans.
    let awake = [connect(&beast), connect(&sbs), ask(connect(&http), "/api/v1/stream")];
    let readers = awake.map(|mut stream| {
        std::thread::spawn(move || {
            stream.set_read_timeout(Some(Duration::from_secs(60))).expect("set");
            let mut heard = Vec::new();
            let _ = stream.read_to_end(&mut heard);
            heard.len()
        })
    });
    // Asleep: they read nothing until the run is over.
    let asleep = [connect(&beast), connect(&sbs), ask(connect(&http), "/api/v1/stream")];
    // Rude: octets that nobody asked for, for as long as they are taken.
    let rude = [&beast, &sbs, &http, &http].map(|port| {
        let mut stream = connect(port);
        std::thread::spawn(move || {
            stream.set_write_timeout(Some(Duration::from_secs(1))).expect("set");
            let garbage: Vec<u8> = (0..=255).cycle().take(65_536).collect();
            (0..50).take_while(|_| stream.write_all(&garbage).is_ok()).count()
        })
    });
    let output = child.wait_with_output().expect("it ends");
    let heard = readers.map(|reader| reader.join().expect("it read"));
    let taken = rude.map(|rude| rude.join().expect("it wrote"));
    drop(asleep);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(heard.iter().all(|octets| *octets > 2_000), "those awake heard the run: {heard:?}");
    let with = summary(&output);
    let alone = summary(&finish(run(&Ports::new(), &of_run)));
    for key in ["digest", "track_digest", "frames", "faults"] {
        assert_eq!(with[key], alone[key], "{key}: {with}");
    }
    println!(
        "rate with ten clients {}, alone {}; garbage taken: {taken:?}",
        with["rate"], alone["rate"]
    );
}

#[test]
fn a_sweep_makes_one_table() {
    let folder = Folder::new("sweep");
    let table = folder.file("table.csv");
    let mut command = seeds();
    command.args([
        "sweep",
        "zurich",
        "--vary",
        "tracking.profile=paper,accurate",
        "--seeds",
        "1..2",
    ]);
    command.args(["--duration", "20", "-o", &table]);
    let output = finish(command);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = std::fs::read_to_string(&table).expect("the table");
    let rows: Vec<&str> = text.lines().collect();
    assert!(rows[0].starts_with("tracking.profile,seed,"), "{}", rows[0]);
    let starts: Vec<String> =
        rows[1..].iter().map(|r| r.split(',').take(2).collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(starts, ["paper 1", "paper 2", "accurate 1", "accurate 2"]);
    let column = rows[0].split(',').position(|c| c == "digest").expect("a digest");
    let alone = finish(run(
        &Ports::new(),
        &["zurich", "--fast", "--duration", "20", "--seed", "2", "--no-viewer"],
    ));
    assert_eq!(
        rows[2].split(',').nth(column),
        summary(&alone)["digest"].as_str(),
        "as the run alone"
    );
    let mut wrong = seeds();
    wrong.args(["sweep", "zurich", "--vary", "sensor.asde.rpn=60", "-o", &table]);
    let refused = finish(wrong);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("rpn"), "{}", stderr(&refused));
}
