//! What the executable says of layouts and of the traffic of a scene.

use crate::common::{self, Folder, Ports, finish, stderr};
use serde_json::Value;

fn said(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = common::seeds();
    command.args(arguments);
    let output = finish(command);
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), stderr(&output))
}

#[test]
fn a_way_begins_and_ends_at_every_name_that_is_listed() {
    let files = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let malpensa = [format!("{files}/LIMC.apt.dat"), format!("{files}/LIMC.groundnet.xml")];
    for (file, with) in [("EHAM", None), ("XSYN", None), (&*malpensa[0], Some(&*malpensa[1]))] {
        let with: Vec<&str> = with.iter().flat_map(|file| ["--with", file]).collect();
        let (code, text, error) =
            said(&[&["airport", "nodes", file, "--json"], &with[..]].concat());
        assert_eq!(code, Some(0), "{file}: {error}");
        let listed: Value = serde_json::from_str(&text).expect("JSON");
        let rows = listed["nodes"].as_array().expect("rows");
        let of = |kind: &str| -> Vec<&str> {
            let all = rows.iter().filter(|r| r["kind"] == kind && r["way"] != false);
            all.filter_map(|r| r["say"].as_str()).collect()
        };
        let twice = rows.iter().filter(|r| r["say"] != r["name"] && r["way"] != false).count();
        assert!(twice < rows.len() / 4, "{file}: {twice} names are of two things");
        let stand = of("stand")[0];
        for kind in ["stand", "node", "holding position", "runway end", "exit"] {
            let names = of(kind);
            assert!(!names.is_empty(), "{file}: no {kind}");
            let mut ways = 0;
            for name in [names[names.len() / 3], names[names.len() / 2], names[names.len() - 1]] {
                let route = ["airport", "route", file, name, stand, "--json"];
                let (code, text, error) = said(&[&route[..], &with[..]].concat());
                assert!(code != Some(2), "{file}: {kind} {name}: {error}");
                if code == Some(0) {
                    let way: Value = serde_json::from_str(&text).expect("JSON");
                    assert_eq!((&way["from"], &way["to"]), (&name.into(), &stand.into()));
                    ways += usize::from(way["length_m"].as_f64().is_some_and(|m| m > 0.0));
                }
            }
            assert!(ways > 0, "{file}: from no {kind} to {stand}");
        }
    }
    let (code, _, error) = said(&["airport", "route", "XSYN", "nowhere", "nowhere"]);
    assert_eq!(code, Some(2), "{error}");
    assert!(error.contains("nowhere: allowed is a stand"), "{error}");
}

#[test]
fn the_flights_of_generated_traffic_are_listed() {
    let (code, text, error) = said(&["traffic", "xsyn", "--json"]);
    assert_eq!(code, Some(0), "{error}");
    let rows: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    for direction in ["arrival", "departure"] {
        let some = rows.iter().filter(|r| r["direction"] == direction);
        assert!(some.clone().count() > 1, "{text}");
        for row in some {
            assert!(row["time_s"].as_f64().is_some() && row["runway"].is_string(), "{row}");
            assert!(row["stand"].is_string() && row["type"].is_string(), "{row}");
        }
    }
    let (_, lines, _) = said(&["traffic", "xsyn"]);
    let listed =
        |r: &&Value| lines.contains(&format!("{} (", r["callsign"].as_str().expect("one")));
    assert_eq!(rows.iter().filter(listed).count(), rows.len(), "{lines}");
}

/// A scene where one stands, of a layout that lies elsewhere, as `seeds scene new /else/where.apt.dat` writes it: its runs could be neither
/// forked nor checked. And one that goes on for longer than its scene says: its clearances were logged up to there only.
#[test]
fn a_run_knows_its_layout_when_that_is_gone_and_its_traffic_to_the_end() {
    let folder = Folder::new("elsewhere");
    let there = folder.file("there");
    std::fs::create_dir(&there).expect("a folder");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports/XSYN.apt.dat");
    let layout = format!("{there}/OWN.apt.dat");
    std::fs::copy(shipped, &layout).expect("a copy");
    let here = |arguments: &[&str]| {
        let mut command = common::seeds();
        command.args(arguments).current_dir(folder.file(""));
        let output = finish(command);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    };
    here(&["scene", "new", &layout, "-o", "own.toml"]);
    let ports = Ports::new();
    let planes = ["--sync-listen", &ports.sync, "--dis", &ports.dis, "--page", &ports.page];
    let run = ["run", "own.toml", "--fast", "--record", "own.pcapng", "--duration", "1500"];
    here(&[&run[..], &planes[..]].concat());
    let database = rusqlite::Connection::open(folder.file("own.sqlite")).expect("the database");
    let last = "SELECT max(time_ns) FROM clearances";
    let last: i64 = database.query_row(last, [], |row| row.get(0)).expect("some");
    assert!(last > 1_200_000_000_000, "of the last minutes there is none: {last}");
    std::fs::remove_dir_all(&there).expect("removed");
    here(&["traffic", "check", "own.sqlite"]);
    here(&["fork", "own.sqlite", "--at", "1400", "--set", "tracking.filter=imm3"]);
}
