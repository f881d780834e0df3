//! What the safety net knows of the ground beside its tracks: protected areas, closed runways, fog, narrow runways. Of the file of the
//! airport and the weather notice, on tracks, held against the same rules on exact truth.

use crate::common::{Folder, Ports, finish, run, stderr};
use rusqlite::Connection;
use std::path::Path;

const AIRPORTS: [(&str, &str); 2] = [("LZIB", ""), ("LIMC", "LIMC.groundnet.xml")];

/// A quarter of an hour of a scene of generated traffic on tracks, with an overlay; its log.
fn flown(
    folder: &Folder,
    name: &str,
    airport: (&str, &str),
    overlay: &str,
    rest: &str,
) -> Connection {
    flown_for(900, folder, name, airport, overlay, rest)
}

fn flown_for(
    duration_s: u32,
    folder: &Folder,
    name: &str,
    (airport, net): (&str, &str),
    overlay: &str,
    rest: &str,
) -> Connection {
    let airports = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/airports");
    let file = |name: &str| {
        let own = folder.file(name);
        match Path::new(&own).exists() {
            true => own,
            false => airports.join(name).display().to_string(),
        }
    };
    let over = folder.file(&format!("{name}.overlay.toml"));
    std::fs::write(&over, overlay).expect("an overlay");
    let layout = file(&format!("{airport}.apt.dat"));
    let network = match net {
        "" => String::new(),
        net => format!("ground_network = {:?}\n", file(net)),
    };
    let text = format!(
        "[run]\ntitle = \"protected\"\nseed = 23\nduration_s = {duration_s}\n[airport]\nlayout = {layout:?}\n{network}overlay = {over:?}\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 16\ndepartures_per_h = 20\n[control]\nsees = \"tracks\"\n{rest}\n"
    );
    let scene = folder.file(&format!("{name}.toml"));
    std::fs::write(&scene, text).expect("a scene");
    let record = folder.file(&format!("{name}.pcapng"));
    let ports = Ports::new();
    let output = finish(run(&ports, &[&scene, "--fast", "--no-viewer", "--record", &record]));
    assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
    Connection::open(folder.file(&format!("{name}.sqlite"))).expect("a database")
}

/// When alerts of a kind were raised, ns, and of whom: on tracks and on exact truth.
fn raised(log: &Connection, table: &str, kind: &str) -> Vec<(i64, String, String)> {
    let query = format!(
        "SELECT min(time_ns), subjects, stage FROM {table} WHERE kind = ? GROUP BY subjects ORDER BY 1"
    );
    let mut rows = log.prepare(&query).expect("a table");
    let rows = rows.query_map([kind], |r| Ok((r.get(0)?, r.get(1)?, r.get(2)?))).expect("rows");
    rows.map(|r| r.expect("a row")).collect()
}

/// Everybody of whom exact truth tells is told of on tracks within 3 s, and nobody else; how many.
fn told_as_on_truth(log: &Connection, kind: &str, name: &str) -> usize {
    let (tracks, truth) = (raised(log, "alerts", kind), raised(log, "reference_alerts", kind));
    for (at_ns, subjects, stage) in &truth {
        let same = tracks
            .iter()
            .any(|(on, s, g)| s == subjects && g == stage && (on - at_ns).abs() <= 3_000_000_000);
        assert!(same, "{name}: {kind} of {subjects} at {at_ns}: {tracks:?}");
    }
    assert_eq!(tracks.len(), truth.len(), "{name}: {tracks:?} {truth:?}");
    truth.len()
}

/// A square of ground on a taxiway that is driven over: restricted it is told of as information, closed as an alarm, and out of its time
/// not at all.
#[test]
fn who_is_in_a_protected_area_in_its_time_is_told_of() {
    let folder = Folder::new("protected-area");
    for airport in AIRPORTS {
        let name = airport.0;
        let plain = flown(&folder, &format!("{name}-plain"), airport, "", "");
        assert!(raised(&plain, "alerts", "AREA").is_empty(), "{name}");
        // Somebody who taxies: slow, on the ground, and a departure.
        let query = "SELECT x_m, y_m, t.callsign, scan FROM truth t JOIN flights USING (callsign) WHERE movement = 'departure' AND \
             vx_ms * vx_ms + vy_ms * vy_ms BETWEEN 36 AND 200 AND altitude_m < 1 ORDER BY scan, t.callsign LIMIT 1 OFFSET 20";
        let at: (f64, f64, String, i64) = plain
            .query_row(query, [], |r| Ok((r.get(0)?, r.get(1)?, r.get(2)?, r.get(3)?)))
            .expect("a taxiing one");
        let corners: Vec<String> = [(-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0)]
            .map(|(e, n)| format!("{{ east_m = {:.1}, north_m = {:.1} }}", at.0 + e, at.1 + n))
            .to_vec();
        let area = |kind: &str, rest: &str| {
            format!("[[area]]\nkind = \"{kind}\"\ncorners = [{}]\n{rest}", corners.join(", "))
        };
        for (kind, stage) in [("restricted", "information"), ("closed", "alarm")] {
            let case = format!("{name}-{kind}");
            let log = flown(&folder, &case, airport, &area(kind, ""), "");
            assert!(told_as_on_truth(&log, "AREA", &case) >= 1, "{case}");
            let told = raised(&log, "alerts", "AREA");
            let own =
                told.iter().find(|(_, subjects, _)| *subjects == at.2).expect("who was seen there");
            assert_eq!(own.2, stage, "{case}");
            assert!((own.0 / 1_000_000_000 - at.3).abs() <= 15, "{case}: {own:?} {at:?}");
        }
        let late = flown(
            &folder,
            &format!("{name}-late"),
            airport,
            &area("closed", "from_s = 5000\n"),
            "",
        );
        assert!(raised(&late, "alerts", "AREA").is_empty(), "{name}: out of its time");
    }
}

/// A runway that is closed for a time: who lands or rolls on it then is told of, nobody before.
#[test]
fn who_uses_a_closed_runway_is_told_of() {
    let folder = Folder::new("protected-runway");
    for airport in AIRPORTS {
        let name = airport.0;
        // Where a runway is backtracked the first take-off comes after a quarter of an hour.
        let plain = flown_for(1500, &folder, &format!("{name}-open"), airport, "", "");
        assert!(raised(&plain, "alerts", "RWY_CLOSED").is_empty(), "{name}");
        let query = "SELECT runway, atot_ns FROM movements WHERE atot_ns > 300000000000 ORDER BY atot_ns LIMIT 1";
        let (runway, off_ns): (String, i64) =
            plain.query_row(query, [], |r| Ok((r.get(0)?, r.get(1)?))).expect("one takes off");
        let end = runway.split('/').next().expect("an end");
        let from_s = off_ns / 1_000_000_000 - 60;
        let overlay =
            format!("[[closed]]\nrunway = \"{end}\"\nfrom_s = {from_s}\nuntil_s = 5000\n");
        let log = flown_for(1500, &folder, &format!("{name}-closed"), airport, &overlay, "");
        let told = raised(&log, "alerts", "RWY_CLOSED");
        assert!(told_as_on_truth(&log, "RWY_CLOSED", name) >= 1, "{name}");
        assert!(
            told.iter().all(|(at, _, stage)| *at >= from_s * 1_000_000_000 && stage == "alarm"),
            "{name}: {told:?}"
        );
    }
}

/// A car on the runway before an arrival: in fog it is told of 45 s before the landing, else 30 s.
#[test]
fn in_fog_conflicts_on_runways_are_told_of_earlier() {
    let folder = Folder::new("protected-fog");
    for airport in AIRPORTS {
        let name = airport.0;
        let car = "[[failure]]\nid = \"CAR\"\nkind = \"vehicle_on_runway\"\ncallsign = \"GA0001\"\nlead_s = 70\nstay_s = 60\n";
        let first_s = |weather: &str, case: &str| {
            let log =
                flown(&folder, &format!("{name}-{case}"), airport, "", &format!("{car}{weather}"));
            let of = |table: &str| {
                let all = raised(&log, table, "RMCA_ARR");
                let own = all.into_iter().find(|(_, subjects, _)| subjects.contains("GA0001"));
                own.unwrap_or_else(|| panic!("{name} {case}: {table}")).0 as f64 * 1e-9
            };
            let (tracks_s, truth_s) = (of("alerts"), of("reference_alerts"));
            assert!((tracks_s - truth_s).abs() <= 3.0, "{name} {case}: {tracks_s} {truth_s}");
            let landed = "SELECT aldt_ns FROM movements WHERE callsign = 'GA0001'";
            let _: Option<i64> = log.query_row(landed, [], |r| r.get(0)).expect("a row");
            tracks_s
        };
        let clear_s = first_s("", "clear");
        let mist_s = first_s("[weather]\ntimeline = [{ at_s = 0, visibility_m = 600 }]\n", "mist");
        let fog_s = first_s("[weather]\ntimeline = [{ at_s = 0, visibility_m = 500 }]\n", "fog");
        assert!((clear_s - mist_s).abs() <= 2.0, "{name}: {clear_s} {mist_s}");
        assert!((13.0..=17.0).contains(&(clear_s - fog_s)), "{name}: {clear_s} {fog_s}");
    }
}

/// The same airport with a runway of 25 m: airliners are told of when they are cleared to taxi to it, light aircraft are not.
#[test]
fn who_is_too_large_for_his_runway_is_told_of() {
    for (airport, net) in AIRPORTS {
        let folder = Folder::new(&format!("protected-narrow-{airport}"));
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(format!("scenarios/airports/{airport}.apt.dat"));
        let text = std::fs::read_to_string(file).expect("a layout");
        let narrow = |line: &str| {
            let mut words: Vec<&str> = line.split_whitespace().collect();
            if words.first() != Some(&"100") {
                return line.to_owned();
            }
            words[1] = "25.00";
            words.join(" ")
        };
        let wide = flown(&folder, &format!("{airport}-wide"), (airport, net), "", "");
        assert!(raised(&wide, "alerts", "WRTY").is_empty(), "{airport}");
        let lines: Vec<String> = text.lines().map(narrow).collect();
        std::fs::write(folder.file(&format!("{airport}.apt.dat")), lines.join("\n"))
            .expect("a file");
        let log = flown(&folder, &format!("{airport}-narrow"), (airport, net), "", "");
        assert!(told_as_on_truth(&log, "WRTY", airport) >= 2, "{airport}");
        let told = raised(&log, "alerts", "WRTY");
        assert!(told.iter().all(|(_, _, stage)| stage == "information"), "{told:?}");
    }
}
