//! What a run sends in ASTERIX, held against its database; what comes back, scored.

use crate::common::{Folder, Ports, finish, run, seeds, stderr, summary};
use asterix::{Record, Value, blocks, cat010, cat011, cat020, cat021, cat062, presence};
use geodesy::{Geodetic, LocalFrame};
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Collects datagrams until told to stop.
struct Listener {
    address: String,
    heard: Arc<Mutex<Vec<Vec<u8>>>>,
    times: Arc<Mutex<Vec<i64>>>,
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Listener {
    fn new() -> Self {
        Self::on(UdpSocket::bind("127.0.0.1:0").expect("a port"))
    }

    fn on(socket: UdpSocket) -> Self {
        socket.set_read_timeout(Some(Duration::from_millis(50))).expect("a time-out");
        let address = socket.local_addr().expect("its address").to_string();
        let (heard, stop) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
        let times = Arc::new(Mutex::new(Vec::new()));
        let (into, at, until) = (Arc::clone(&heard), Arc::clone(&times), Arc::clone(&stop));
        let thread = std::thread::spawn(move || {
            let mut buffer = [0; 65_536];
            while !until.load(Ordering::SeqCst) {
                if let Ok(length) = socket.recv(&mut buffer) {
                    at.lock().expect("unbroken").push(federates::runtime::clock::utc_ns());
                    into.lock().expect("unbroken").push(buffer[..length].to_vec());
                }
            }
        });
        Self { address, heard, times, stop, thread: Some(thread) }
    }

    /// When they came, ns UTC; waits for what is still on its way.
    fn times(&self) -> Vec<i64> {
        std::thread::sleep(Duration::from_millis(300));
        self.times.lock().expect("unbroken").clone()
    }

    fn end(mut self) -> Vec<Vec<u8>> {
        std::thread::sleep(Duration::from_millis(200));
        self.stop.store(true, Ordering::SeqCst);
        self.thread.take().expect("once").join().expect("it ends");
        std::mem::take(&mut self.heard.lock().expect("unbroken"))
    }
}

fn numbers(database: &Connection, query: &str) -> Vec<Vec<f64>> {
    let mut query = database.prepare(query).expect(query);
    let columns = query.column_count();
    let rows = query.query_map([], |row| {
        (0..columns).map(|c| row.get::<_, Option<f64>>(c).map(|n| n.unwrap_or(f64::NAN))).collect()
    });
    rows.expect("rows").map(|r| r.expect("a row")).collect()
}

fn fact(database: &Connection, name: &str) -> f64 {
    let value: String = database
        .query_row("SELECT value FROM run WHERE name = ?", [name], |r| r.get(0))
        .expect(name);
    value.parse().expect(name)
}

/// Fails if a record lies farther from `[x, y]` than its category resolves, or at another time.
fn same(what: &str, record: &Record<'_>, at_s: f64, [x_m, y_m]: [f64; 2], frame: &LocalFrame) {
    let number = record.category.number;
    let (time, degrees, near_m) = match number {
        10 => (&cat010::I140, &cat010::I041, 0.05),
        11 => (&cat011::I140, &cat011::I041, 0.05),
        20 => (&cat020::I140, &cat020::I041, 0.4),
        21 => (&cat021::I071, &cat021::I131, 0.05),
        _ => (&cat062::I070, &cat062::I105, 0.4),
    };
    let found_s = record.number(time).expect("a time");
    let late_s = (found_s - at_s + 43_200.0).rem_euclid(86_400.0) - 43_200.0;
    assert!(late_s.abs() <= 1.0 / 256.0 + 1e-9, "{what}: {found_s} s, expected {at_s} s");
    let [lat, lon] = record.numbers(degrees).expect("a position");
    let place = Geodetic::from_degrees(lat, lon, frame.origin_geodetic().height_m);
    let there = frame.to_enu(place.to_ecef());
    let off_m = libm::hypot(there.east_m - x_m, there.north_m - y_m);
    assert!(off_m <= near_m, "{what}: {off_m} m off in category {number}");
}

#[test]
fn every_plot_and_track_of_the_database_goes_out_once() {
    let (folder, listener, ports) = (Folder::new("gateway"), Listener::new(), Ports::new());
    let recording = folder.file("run.pcapng");
    let sent = folder.file("sent.pcapng");
    // The one with GPS is there from 30 s on.
    let whole = ["zurich", "--rate", "4", "--duration", "36", "--seed", "3", "--no-viewer"];
    let to = ["--asterix", &listener.address, "--asterix-record", &sent, "--record", &recording];
    // What it sends it hears as well, as if it were of somebody else's tracker.
    let own = free_udp_port();
    let heard = ["--asterix", &own, "--asterix-in", &own];
    let output = finish(run(&ports, &[&whole[..], &to, &heard].concat()));
    let datagrams = listener.end();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    foreign_tracks_are_kept(&folder);
    let digest = |output| summary(output)["digest"].clone();
    let alone = ["zurich", "--fast", "--duration", "36", "--seed", "3", "--no-viewer"];
    assert_eq!(
        digest(&output),
        digest(&finish(run(&Ports::new(), &alone))),
        "a gateway changes no digest"
    );
    let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
    held_against_the_database(&folder, &scene, &datagrams);
    // What was recorded is what was sent; and the product scores its own tracks alike from every form.
    score_from_every_form(&folder, &sent);
}

fn free_udp_port() -> String {
    format!("127.0.0.1:{}", crate::common::free_port())
}

/// Each track report of the scans but the last came back in both categories, and stands where ours stands.
fn foreign_tracks_are_kept(folder: &Folder) {
    let database = Connection::open(folder.file("run.sqlite")).expect("the database");
    let ours = numbers(
        &database,
        "SELECT count(*) FROM tracks WHERE scan < (SELECT max(scan) FROM scans)",
    )[0][0];
    let theirs =
        numbers(&database, "SELECT count(*) FROM foreign_tracks WHERE source = '0/200'")[0][0];
    assert!(theirs >= 2.0 * ours, "{theirs} of {ours} in two categories");
    let off = "SELECT max(abs(f.x_m - t.x_m)), max(abs(f.y_m - t.y_m)), count(*) FROM foreign_tracks f \
        JOIN scans s ON abs(s.time_ns - f.time_ns) < 5000000 JOIN tracks t ON t.scan = s.scan AND t.track = f.track";
    let [x_m, y_m, pairs] = numbers(&database, off)[0][..] else { panic!("three columns") };
    assert!(pairs == theirs && x_m <= 0.51 && y_m <= 0.51, "{x_m} m, {y_m} m, {pairs} of {theirs}");
}

/// A scene of many movers that begins shortly before midnight.
fn busy_night(folder: &Folder, movers: usize) -> String {
    let zurich =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/zurich.toml"))
            .expect("the scene");
    let (before, rest) = zurich.split_once("[[traffic]]").expect("traffic");
    let (_, after) = rest.split_once("[[sensor]]").expect("sensors");
    let mut text = before.replace("2019-11-24T09:00:00Z", "2019-12-31T23:59:52Z");
    let ends = ["Terminal_A_Gate_48", "D_57", "GAC_S1_A", "I_98", "Gate_B_38"];
    let mut equipped = Vec::new();
    for i in 0..movers {
        let (from, to) = (ends[i % 5], ends[(i + 1 + i / 5 % 4) % 5]);
        text += &format!(
            "[[traffic]]\nkind = \"route\"\ncallsign = \"CAR{i}\"\ntype = \"{}\"\naddress = {}\nvia = [\"{from}\", \"{to}\"]\nstart_s = {}\nflight = {{ movement = \"vehicle\" }}\n\n",
            if i % 7 == 0 { "FIRE" } else { "FOLLOWME" },
            0x4b_8000 + i,
            (i % 20) as f64 * 0.9
        );
        equipped.push(format!("\"CAR{i}\""));
    }
    text +=
        &format!("[[sensor]]{after}").replace("\"CAI3208\"", &equipped[..movers / 2].join(", "));
    let text = text.replace("\"FOLLOW1\", \"FIRE1\"", &equipped[movers / 2..].join(", "));
    let path = folder.file("night.toml");
    std::fs::write(&path, text).expect("written");
    path
}

/// A scene of parked aircraft that all report themselves: as many tracks.
fn apron(folder: &Folder, count: usize) -> String {
    let mut layout = String::from(
        "I\n1000 Version - an apron, made by a test\n\n1 330 1 0 XAPR Apron\n\
         100 45.00 1 0 0.25 1 3 1 09 45.05000000 9.98000000 0 0 3 2 1 0 27 45.05000000 10.02000000 0 0 3 2 1 0\n\
         14 45.00000000 10.00000000 60 0 Tower\n1200\n\
         1201 45.00000000 10.00000000 both 0 N0\n1201 45.00100000 10.00000000 both 1 N1\n1202 0 1 twoway taxiway_C A\n",
    );
    let mut scene = String::from(
        "[run]\ntitle = \"apron\"\nseed = 1\nstart = 2026-01-01T06:00:00Z\nduration_s = 60\n\n\
         [airport]\nicao = \"XAPR\"\nlayout = \"apron.apt.dat\"\n\n\
         [[sensor]]\nkind = \"dgps\"\nname = \"DGPS\"\n",
    );
    for n in 0..count {
        let (lat, lon) = (45.0 + (n / 25) as f64 * 8e-4, 10.0 + (n % 25) as f64 * 11e-4);
        layout += &format!("1300 {lat:.8} {lon:.8} 0.00 gate jets S{n}\n");
        scene += &format!(
            "\n[[traffic]]\nkind = \"parked\"\ncallsign = \"P{n:04}\"\ntype = \"A320\"\nstand = \"S{n}\"\n"
        );
    }
    std::fs::write(folder.file("apron.apt.dat"), layout + "99\n").expect("written");
    let path = folder.file("apron.toml");
    std::fs::write(&path, scene).expect("written");
    path
}

/// In real time, over a multicast group of the loopback interface: every track of every scan, once. How long the burst of a scan takes
/// is printed (goal: 100 ms), not judged: it is the machine's.
#[test]
fn five_hundred_tracks_go_out_live_and_none_is_lost() {
    const TRACKS: usize = 500;
    let (folder, ports) = (Folder::new("gateway-500"), Ports::new());
    let scene = apron(&folder, TRACKS);
    let group = std::net::Ipv4Addr::new(239, 9, 77, 1);
    let socket = UdpSocket::bind((group, 0)).expect("a port of the group");
    socket.join_multicast_v4(&group, &std::net::Ipv4Addr::LOCALHOST).expect("it joins");
    let to = socket.local_addr().expect("its address").to_string();
    let listener = Listener::on(socket);
    let recording = folder.file("run.pcapng");
    let mut command = run(&ports, &[&scene, "--duration", "14", "--no-viewer", "--no-visitors"]);
    command.args(["--asterix", &to, "--asterix-send", "tracks", "--interface", "127.0.0.1"]);
    command.args(["--record", &recording]);
    let output = finish(command);
    let times = listener.times();
    let datagrams = listener.end();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let database = Connection::open(folder.file("run.sqlite")).expect("the database");
    let rows = numbers(&database, "SELECT scan, count(*) FROM tracks GROUP BY scan ORDER BY scan");
    assert!(rows.iter().filter(|row| row[1] as usize == TRACKS).count() >= 8, "{rows:?}");
    // Ends of batch (category 065) divide the scans.
    let (mut heard, mut of_scan, mut first_ns, mut bursts_ms) = (Vec::new(), [0, 0], None, vec![]);
    for (datagram, at_ns) in datagrams.iter().zip(&times) {
        for block in blocks(datagram) {
            let block = block.expect("sound");
            for record in block.records().map(|r| r.expect("sound")) {
                match block.number {
                    62 => of_scan[0] += 1,
                    11 => of_scan[1] += 1,
                    65 if record.find("020").is_some() => {
                        let begun_ns = first_ns.take().unwrap_or(*at_ns);
                        bursts_ms.push((at_ns - begun_ns) as f64 * 1e-6);
                        heard.push(std::mem::take(&mut of_scan));
                        continue;
                    }
                    _ => continue,
                }
                first_ns.get_or_insert(*at_ns);
            }
        }
    }
    let scans = numbers(&database, "SELECT count(*) FROM scans")[0][0] as usize;
    assert_eq!(heard.len(), scans, "one end of batch a scan");
    let sent: Vec<[i64; 2]> = heard.into_iter().filter(|of| *of != [0, 0]).collect();
    let expected: Vec<[i64; 2]> = rows.iter().map(|row| [row[1] as i64; 2]).collect();
    assert_eq!(sent, expected);
    bursts_ms.sort_by(f64::total_cmp);
    println!("bursts of {TRACKS} tracks, ms: {bursts_ms:.1?}");
}

#[test]
fn two_hundred_movers_across_midnight() {
    let (folder, listener, ports) = (Folder::new("gateway-night"), Listener::new(), Ports::new());
    let scene_file = busy_night(&folder, 200);
    let recording = folder.file("run.pcapng");
    let arguments =
        [&scene_file[..], "--rate", "4", "--duration", "16", "--no-viewer", "--no-visitors"];
    let to = ["--asterix", &listener.address, "--record", &recording];
    let output = finish(run(&ports, &[&arguments[..], &to].concat()));
    let datagrams = listener.end();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let scene =
        scenarios::load_without_truth(std::path::Path::new(&scene_file)).expect("the scene");
    assert_eq!(scene.traffic.entities.len(), 200);
    held_against_the_database(&folder, &scene, &datagrams);
}

/// Every plot and track once, where and when the database has them, in order.
fn held_against_the_database(folder: &Folder, scene: &scenarios::Scene, datagrams: &[Vec<u8>]) {
    let database = Connection::open(folder.file("run.sqlite")).expect("the database");
    let reference = |name| fact(&database, name);
    let frame = scene.airport.frame;
    assert!((frame.origin_geodetic().lat_deg() - reference("reference_latitude_deg")).abs() < 1e-9);
    let start_s = (scene.run.start_utc_ns.rem_euclid(86_400_000_000_000)) as f64 / 1e9;

    assert!(datagrams.iter().all(|d| d.len() <= 1400));
    let mut records = Vec::new();
    for datagram in datagrams {
        for block in blocks(datagram) {
            let block = block.expect("a sound block");
            records.extend(block.records().map(|r| r.expect("a sound record")));
        }
    }
    for record in &records {
        assert_eq!(presence::breaches(record), [], "{record:?}");
    }
    let set = |record: &Record<'_>, item, name| {
        record.get(item).and_then(|v| v.value(name)) == Some(Value::Integer(1))
    };

    // Plots, by sensor in the order of the database.
    let plots = numbers(
        &database,
        "SELECT sensor, time_ns, x_m, y_m FROM plots ORDER BY scan, sensor, sequence",
    );
    let mut by_sensor: BTreeMap<u8, Vec<&Record<'_>>> = BTreeMap::new();
    for record in &records {
        let report = match record.category.number {
            10 => record.number(&cat010::I000) == Some(1.0),
            20 | 21 => true,
            _ => false,
        };
        if report {
            let source = record.find("010").expect("a source").values().nth(1).expect("SIC").1;
            by_sensor.entry(source.number().expect("a number") as u8).or_default().push(record);
            let (item, name) = match record.category.number {
                10 => (&cat010::I020, "SIM"),
                20 => (&cat020::I020, "SIM"),
                _ => (&cat021::I040, "SIM"),
            };
            assert!(set(record, item, name), "simulated");
        }
    }
    let mut expected: BTreeMap<u8, Vec<&Vec<f64>>> = BTreeMap::new();
    plots.iter().for_each(|row| expected.entry(row[0] as u8).or_default().push(row));
    assert!(expected.len() >= 3 && plots.len() > 100, "{} plots", plots.len());
    assert_eq!(
        by_sensor.iter().map(|(s, r)| (*s, r.len())).collect::<Vec<_>>(),
        expected.iter().map(|(s, r)| (*s, r.len())).collect::<Vec<_>>()
    );
    for (sensor, rows) in &expected {
        for (row, record) in rows.iter().zip(&by_sensor[sensor]) {
            let what = format!("plot of sensor {sensor} at {} s", row[1] * 1e-9);
            same(&what, record, start_s + row[1] * 1e-9, [row[2], row[3]], &frame);
        }
    }

    // Tracks, in both categories.
    let tracks = numbers(
        &database,
        "SELECT track, time_ns, t.x_m, t.y_m, vx_ms, vy_ms, status = 'tentative', status = 'coasting', \
         status = 'last' FROM tracks t JOIN scans USING (scan) ORDER BY scan, track",
    );
    assert!(tracks.len() > 50, "{} track reports", tracks.len());
    for (category, number, velocity, status) in [
        (62, &cat062::I040, &cat062::I185, &cat062::I080),
        (11, &cat011::I161, &cat011::I202, &cat011::I170),
    ] {
        let own: Vec<_> = records.iter().filter(|r| r.category.number == category).collect();
        assert_eq!(own.len(), tracks.len(), "category {category}");
        for (row, record) in tracks.iter().zip(own) {
            let what = format!("track {} at {} s", row[0], row[1] * 1e-9);
            assert_eq!(record.number(number), Some(row[0]), "{what}");
            same(&what, record, start_s + row[1] * 1e-9, [row[2], row[3]], &frame);
            let [vx, vy] = record.numbers(velocity).expect("a velocity");
            assert!((vx - row[4]).abs() <= 0.125 && (vy - row[5]).abs() <= 0.125, "{what}");
            let bits =
                ["CNF", "CST", "TSE"].map(|name| f64::from(u8::from(set(record, status, name))));
            assert_eq!(bits, [row[6], row[7], row[8]], "{what}");
            assert!(set(record, status, "SIM"), "{what}");
        }
    }

    // The order of a cycle: sensors, 062, 011, end of batch; and one end of batch a scan.
    let scans = numbers(&database, "SELECT count(*) FROM scans")[0][0] as usize;
    let ends = records.iter().filter(|r| r.category.number == 65 && r.find("020").is_some());
    let batches: Vec<u64> =
        ends.map(|r| r.find("020").expect("there").octets()[0].into()).collect();
    assert_eq!(batches, (1..=scans as u64).map(|n| n % 256).collect::<Vec<_>>());
    let order = |r: &Record<'_>| match r.category.number {
        10 | 19 | 20 | 21 => 0,
        62 => 1,
        11 => 2,
        _ => 3,
    };
    let places: Vec<i32> = records.iter().map(order).collect();
    assert_eq!(places.windows(2).filter(|w| w[1] < w[0]).count(), scans - 1, "one descent a scan");
    assert!(records.iter().any(|r| r.category.number == 247));
}

fn score_from_every_form(folder: &Folder, sent: &str) {
    let tool = |arguments: &[&str]| {
        let mut command = seeds();
        command.args(arguments);
        let output = finish(command);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).expect("text")
    };
    let stat: serde_json::Value =
        serde_json::from_str(&tool(&["asterix", "stat", "--json", sent])).expect("JSON");
    assert_eq!((stat["damaged"].as_u64(), stat["other_datagrams"].as_u64()), (Some(0), Some(0)));
    assert!(tool(&["asterix", "check", sent]).contains(" 0 findings"));
    // A file that is no ASTERIX fails, in words, also for a program.
    let stranger = folder.file("stranger.ast");
    std::fs::write(&stranger, "hello, this is a text and no recording of anything\n")
        .expect("written");
    for more in [&[][..], &["--json"]] {
        let mut command = seeds();
        command.args(["asterix", "stat", &stranger]).args(more);
        let output = finish(command);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("this is not ASTERIX"), "{}", stderr(&output));
    }
    let dumped = tool(&["asterix", "dump", sent]).lines().count() as u64;
    assert_eq!(stat["records"].as_u64(), Some(dumped));
    let truth = folder.file("run.sqlite");
    let score = |tracks: &str, category: &str| -> serde_json::Value {
        let text = tool(&[
            "score",
            "--truth",
            &truth,
            "--tracks",
            tracks,
            "--category",
            category,
            "--scene",
            "zurich",
            "--json",
        ]);
        serde_json::from_str(&text).expect("JSON")
    };
    let strip = |mut report: serde_json::Value| {
        for key in ["title", "notes"] {
            report.as_object_mut().expect("an object").remove(key);
        }
        report
    };
    let first = strip(score(sent, "62"));
    for name in ["sent.ast", "sent.ff", "sent.rff"] {
        let other = folder.file(name);
        tool(&["asterix", "convert", sent, &other]);
        assert_eq!(strip(score(&other, "62")), first, "{name}");
    }
    // Two categories of one sender: said, with what to choose.
    let mut both = seeds();
    both.args(["score", "--truth", &truth, "--tracks", sent, "--scene", "zurich"]);
    let refused = finish(both);
    assert_eq!(refused.status.code(), Some(2));
    let words = stderr(&refused);
    assert!(
        words.contains("--source 0/200 --category 62") && words.contains("--category 11"),
        "{words}"
    );
}

#[test]
fn what_cannot_be_sent_is_said_before_the_run() {
    for (flags, words) in [
        (&["--asterix", "127.0.0.1"][..], "is not ADDR:PORT"),
        (&["--asterix", "127.0.0.1:8600", "--asterix-cat", "48"], "category 48 is not written"),
        (
            &["--asterix", "127.0.0.1:8600", "--asterix-time", "wall", "--rate", "2"],
            "at rate 1 only",
        ),
        (&["--asterix", "127.0.0.1:8600", "--in-process"], "--in-process has no gateway"),
        (&["--asterix-send", "tracks"], "--asterix <ADDR:PORT>"),
    ] {
        let output =
            finish(run(&Ports::new(), &[&["--no-viewer", "--duration", "1"], flags].concat()));
        let said = stderr(&output);
        assert!(said.contains(words), "{flags:?}: {said}");
        assert_ne!(output.status.code(), Some(0), "{flags:?}");
    }
}
