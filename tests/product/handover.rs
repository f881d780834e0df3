//! Handover through the product: what is asked stands in frames, so every layout gives the same bits, and so does the log.

use crate::common::{self, Folder, Ports, finish, run, summary};
use models::traffic::core::Direction;
use serde_json::{Value, json};

fn scene(folder: &Folder) -> String {
    let path = folder.file("handover.toml");
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"handover\"\nseed = 12\nduration_s = 300\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\nprofile = \"even\"\narrivals_per_h = 6\ndepartures_per_h = 30\n\
         [[traffic]]\nkind = \"handover\"\ncount = 4\n[[sensor]]\nkind = \"adsb\"\nname = \"a\"\n"
    );
    std::fs::write(&path, text).expect("a scene");
    path
}

fn fly(scene: &str, arguments: &[&str]) -> Value {
    let fast = [scene, "--fast", "--no-viewer"];
    let output = finish(run(&Ports::new(), &[&fast[..], arguments].concat()));
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", common::stderr(&output));
    let summary = summary(&output);
    assert_eq!(summary["frames"], 6000, "{arguments:?}");
    assert_eq!(summary["faults"], json!([]), "{arguments:?}");
    summary
}

/// Asks: one on final, one too high, one of a name that is there, one that is let go too soon.
fn asks(folder: &Folder, scene: &str) -> String {
    let loaded = scenarios::load(std::path::Path::new(scene)).expect("the scene");
    let behaving = loaded.traffic.behaving.as_ref().expect("behaves");
    let leaves = behaving.flights.iter().find(|f| f.direction == Direction::Departure);
    let leaves = leaves.expect("a departure");
    let (r, end) = leaves.runway;
    let runway = &behaving.network.runways[r];
    let along = (runway.ends_m[1 - end] - runway.ends_m[end]).normalize();
    let state = |at_s: f64, up_m: f64| {
        let at = (runway.ends_m[end] - along * 9000.0) * 1e3;
        let v = along * 75e3;
        let (x, y, z, ns) = (at.x as i64, at.y as i64, (1e3 * up_m) as i64, (1e9 * at_s) as i64);
        format!("A320 4b1234 - - {x} {y} {z} {} {} -3900 run {ns}", v.x as i64, v.y as i64)
    };
    let line = |frame: u64, action: &str, callsign: &str, state: &str| {
        json!({"frame": frame, "seat": "handover", "person": "test", "action": action, "callsign": callsign, "clearance": state})
            .to_string()
    };
    let all = [
        line(400, "give", "BSK2", &state(20.0, 1500.0)),
        line(420, "give", "BSK1", &state(21.0, 490.0)),
        line(500, "give", "BSK1", &state(25.0, 490.0)),
        line(600, "release", &leaves.callsign, ""),
    ];
    let path = folder.file("asks.jsonl");
    std::fs::write(&path, all.join("\n")).expect("inputs");
    path
}

#[test]
fn a_handover_gives_one_digest_in_every_layout_and_again_from_the_log() {
    let folder = Folder::new("handover");
    let scene = scene(&folder);
    let asks = asks(&folder, &scene);
    let reference = fly(&scene, &["--in-process", "--inputs", &asks]);
    let alone = fly(&scene, &["--in-process"]);
    assert_ne!(reference["digest"], alone["digest"], "it is there");
    let record = folder.file("run.pcapng");
    for arguments in
        [&["--in-process", "--generators", "2"][..], &["--record", &record], &["--generators", "2"]]
    {
        let found = fly(&scene, &[arguments, &["--inputs", &asks]].concat());
        assert_eq!(found["digest"], reference["digest"], "{arguments:?}");
        assert_eq!(found["track_digest"], reference["track_digest"], "{arguments:?}");
    }
    let log = folder.file("run.sqlite");
    let again = fly(&scene, &["--in-process", "--inputs", &log]);
    assert_eq!(again["digest"], reference["digest"], "from the log");
    let log = rusqlite::Connection::open(log).expect("a database");
    let mut rows = log
        .prepare("SELECT callsign, action, refused FROM inputs ORDER BY number")
        .expect("a table");
    let rows = rows.query_map([], |r| Ok((r.get(0)?, r.get(1)?, r.get(2)?)));
    let rows: Vec<(String, String, String)> = rows.and_then(Iterator::collect).expect("rows");
    assert_eq!(rows.len(), 4, "{rows:?}");
    for (row, words) in rows.iter().zip(["above the slope", "", "here already", "climbs away"]) {
        assert!(row.2.contains(words) && row.2.is_empty() == words.is_empty(), "{row:?}");
    }
    // It lands, in the log's own flight of the traffic and in the truth that was seen; its name and address are kept.
    let landed = "SELECT count(*) FROM movements WHERE callsign = 'BSK1' AND aldt_ns > 0";
    let count = |query: &str| -> i64 { log.query_row(query, [], |r| r.get(0)).expect(query) };
    assert_eq!(count(landed), 1);
    assert_eq!(count("SELECT count(*) FROM movements WHERE callsign = ''"), 0);
    let seen = count("SELECT count(*) FROM truth WHERE callsign = 'BSK1'");
    assert!(seen > 250, "{seen}");
    // A recording replayed has the same bits, and the same names.
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_seeds"));
    command.args(["replay", &record, "--with-smdfm", "--scene", &scene]);
    let output = finish(command);
    assert!(output.status.success(), "{}", common::stderr(&output));
    let replayed = summary(&output);
    assert_eq!(replayed["track_digest"], reference["track_digest"], "{replayed}");
}

#[test]
fn a_handover_that_cannot_be_is_refused_before_anything_is_started() {
    let folder = Folder::new("handover-refused");
    let scene = scene(&folder);
    for (line, words) in [
        (r#""action":"give","callsign":"BSK1","clearance":"A320 - - - 0 0 0 0 0""#, "TYPE ADDRESS"),
        (r#""action":"give","clearance":"A320""#, "name the callsign"),
        (
            r#""action":"give","callsign":"BSK1","clearance":"A320 - - - 0 0 0 0 0 0 age 5""#,
            "run NANOSECONDS",
        ),
        (
            r#""action":"give","callsign":"B K","clearance":"A320 - - - 0 0 0 0 0 0 run 5""#,
            "upper-case",
        ),
        (
            r#""action":"give","callsign":"BSK1","clearance":"FIRE - - - 0 0 0 0 0 0 run 5""#,
            "not an aircraft",
        ),
        (
            r#""action":"give","callsign":"BSK1","clearance":"A320 - 77 - 0 0 0 0 0 0 run 5""#,
            "no runway",
        ),
        (r#""action":"take""#, "give or release"),
    ] {
        let inputs = folder.file("bad.jsonl");
        let text = format!("{{\"frame\":5,\"seat\":\"handover\",\"person\":\"a\",{line}}}\n");
        std::fs::write(&inputs, text).expect("inputs");
        let output =
            finish(run(&Ports::new(), &[&scene, "--fast", "--no-viewer", "--inputs", &inputs]));
        let said = common::stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && said.contains("bad.jsonl:1"), "{said}");
    }
}
