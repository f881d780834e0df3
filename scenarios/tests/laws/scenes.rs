//! The scenes that ship are sound, and bad input gives exactly one line that says what to do.

use scenarios::{in_share, load, load_share, load_text, load_without_truth};
use std::path::{Path, PathBuf};

fn zurich() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml")
}

/// The error line of zurich.toml with one text replaced by another, with the folder taken off.
fn error_with(from: &str, to: &str) -> String {
    let text = std::fs::read_to_string(zurich()).expect("zurich.toml");
    assert!(text.contains(from), "{from:?} is not in zurich.toml");
    let result = load_text(&zurich(), &text.replacen(from, to, 1));
    let line = result.expect_err("an error").to_string();
    line.replace(&format!("{}/", env!("CARGO_MANIFEST_DIR")), "")
}

#[test]
fn zurich_is_sound() {
    let scene = load(&zurich()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.airport.layout.runways.len(), 3);
    assert_eq!(scene.run.frames(), 12_000);
    assert_eq!(scene.run.frames_per_scan, 20);
    assert_eq!(scene.weather.len(), 3);
    assert_eq!(scene.weather[2].weather.visibility_m, 400.0, "what is not said stays");
    assert_eq!(scene.hash, load(&zurich()).unwrap().hash);
}

#[test]
fn bad_scenes_give_one_line() {
    for (from, to, expected) in [
        (
            "seed = 1",
            "sed = 1",
            "zurich.toml:6: run.sed: unknown key, did you mean `seed`?; allowed here: title, seed, start, duration_s, exercise, site, targets_max, frame_s, scan_s, dead_reckoning, heartbeat",
        ),
        (
            "duration_s = 600",
            "duration_min = 10",
            "zurich.toml:8: run.duration_min: unknown key, did you mean `duration_s`?; allowed here: title, seed, start, duration_s, exercise, site, targets_max, frame_s, scan_s, dead_reckoning, heartbeat",
        ),
        (
            "duration_s = 600",
            "duration_s = \"10 min\"",
            "zurich.toml:8: run.duration_s: found the text \"10 min\", needed is a number in s (no unit)",
        ),
        (
            "duration_s = 600",
            "duration_s = -600",
            "zurich.toml:8: run.duration_s: found -600, allowed is 1 to 86400 s",
        ),
        (
            "duration_s = 600\n",
            "",
            "zurich.toml:4: run.duration_s: missing; needed is a number in s (no unit)",
        ),
        (
            "LSZH.apt.dat",
            "LSZX.apt.dat",
            "zurich.toml:18: airport.layout: file airports/LSZX.apt.dat: does not exist; paths count from the folder of the scene file",
        ),
        (
            "rain_mm_per_h = 16",
            "rain_mm_per_h = 4000",
            "zurich.toml:27: weather.timeline[3].rain_mm_per_h: found 4000, allowed is 0 to 1000 mm/h",
        ),
        (
            "at_s = 400",
            "at_s = 100",
            "zurich.toml:27: weather.timeline[3].at_s: found 100 s, needed is a time after that of the entry before",
        ),
        (
            "lat_deg = 47.453819",
            "lat_deg = 48.453819",
            "zurich.toml:113: sensor[1].site.lat_deg: 110118 m from the aerodrome reference point, allowed is at most 6000 m (airport.radius_m)",
        ),
        (
            "kind = \"asde\"",
            "kind = \"sonar\"",
            "zurich.toml:110: sensor[1].kind: found \"sonar\", allowed is \"asde\", \"gps\", \"dgps\", \"adsb\", \"mlat\", \"loop\", \"dynamic\", \"offline\", \"asterix\"",
        ),
        (
            "profile = \"paper\"",
            "profile = paper",
            "zurich.toml:126: scene: not TOML: string values must be quoted, expected literal string",
        ),
        (
            "[accuracy]",
            "[acuracy]",
            "zurich.toml:128: acuracy: unknown key, did you mean `accuracy`?; allowed here: run, airport, traffic, weather, building, board, sensor, tracking, accuracy, network, external, control, failure, shape, shapes",
        ),
        (
            "movements/EDW229.csv",
            "movements/EDW.csv",
            "zurich.toml:36: traffic[1].file: file movements/EDW.csv: does not exist; paths count from the folder of the scene file",
        ),
        (
            "callsign = \"FIRE1\"",
            "callsign = \"FOLLOW1\"",
            "zurich.toml:101: traffic[8].callsign: \"FOLLOW1\" is there a second time; first in line 91; names must differ",
        ),
        (
            "address = 4960258",
            "address = 4960257",
            "zurich.toml:103: traffic[8].address: \"4960257\" is there a second time; first in line 93; names must differ",
        ),
        (
            "type = \"FIRE\"",
            "type = \"FIRE\"\nspeed_kt = 20",
            "zurich.toml:103: traffic[8].speed_kt: unknown key; allowed here: kind, callsign, type, count, address, flight, stand, file, start_s, cut_from_s, cut_to_s, via, halts, arrivals_per_h, departures_per_h, mix, profile, turnaround_min, vehicles, seed, arrival_runways, departure_runways",
        ),
        (
            "visibility_m = 400, film_mm",
            "wind_ms = 4, film_mm",
            "zurich.toml:26: weather.timeline[2].wind_ms: unknown key, did you mean `wind_mps`?; allowed here: at_s, rain_mm_per_h, visibility_m, temperature_c, pressure_hpa, vapour_g_per_m3, wind_mps, wind_from_deg, film_mm, cells",
        ),
        (
            "\"GAC_S1_A\", \"I_98\"",
            "\"GAC_S1_A\", \"I_99\"",
            "zurich.toml:104: traffic[8].via: found \"I_99\", allowed is a stand, a node, a holding position, an end or exit of a runway, a taxiway, a runway, or `hold RUNWAY`; `seeds airport nodes` lists the names",
        ),
        (
            "equipped = [\"CAI3208\"]",
            "equipped = [\"CAI3209\"]",
            "zurich.toml:118: sensor[2].equipped: found \"CAI3209\", allowed is \"EDW229\", \"CAI3208\", \"SWR137H\", \"ENT57BW\", \"ACA879\", \"AEE5ZH\", \"FOLLOW1\", \"FIRE1\"",
        ),
        (
            "cut_from_s = 270",
            "cut_from_s = 500",
            "zurich.toml:56: traffic[3].cut_to_s: found 480 s, needed is a time after cut_from_s",
        ),
        (
            "movements/SWR137H.csv",
            "types.csv",
            "types.csv:1: timestamp_ms: missing; needed is a column timestamp_ms in the header (or time_s), and one latitude_deg in the header (or lat_deg; or x_m), and one longitude_deg in the header (or lon_deg; or y_m)",
        ),
    ] {
        assert_eq!(error_with(from, to), expected, "{from:?} -> {to:?}");
    }
}

#[test]
fn without_truth_all_else_is_the_same() {
    let mut full = load(&zurich()).unwrap_or_else(|e| panic!("{e}"));
    let outline = load_without_truth(&zurich()).unwrap_or_else(|e| panic!("{e}"));
    assert!(full.traffic.entities.iter().all(|e| e.trajectory.is_some()));
    for entity in &mut full.traffic.entities {
        entity.trajectory = None;
        entity.report = None;
    }
    assert_eq!(full, outline);
}

#[test]
fn shares_make_each_movement_once_and_all_else_is_the_same() {
    let full = load(&zurich()).unwrap_or_else(|e| panic!("{e}"));
    let outline = load_without_truth(&zurich()).unwrap_or_else(|e| panic!("{e}"));
    // Parked movers cost nothing and are there in every share.
    let parked: Vec<bool> =
        outline.traffic.entities.iter().map(|e| e.trajectory.is_some()).collect();
    let mut made = vec![0; full.traffic.entities.len()];
    for share in 1..=3 {
        let part = load_share(&zurich(), share, 3).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((part.hash, &part.weather), (full.hash, &full.weather));
        for (index, (own, whole)) in
            part.traffic.entities.iter().zip(&full.traffic.entities).enumerate()
        {
            if in_share(index, share, 3) {
                assert_eq!(own, whole, "share {share}");
                made[index] += 1;
            } else {
                assert_eq!(own.trajectory.is_some(), parked[index], "share {share}: {index}");
            }
        }
    }
    assert!(made.iter().all(|n| *n == 1), "{made:?}");
}

#[test]
fn a_scene_anywhere_finds_the_types_and_parameter_sets_that_ship() {
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::temp_dir().join(format!("scenarios-elsewhere-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let layout = shipped.join("airports/LSZH.apt.dat");
    let text = format!(
        r#"
        [run]
        title = "elsewhere"
        start = 2026-01-01T00:00:00Z
        duration_s = 10
        [airport]
        icao = "LSZH"
        layout = "{}"
        [[traffic]]
        kind = "parked"
        callsign = "ABC1"
        type = "A320"
        stand = "General_Aviation"
        [[sensor]]
        kind = "asde"
        name = "radar"
        parameters = "x_smr25"
        site = {{ lat_deg = 47.453819, lon_deg = 8.556911, height_m = 60 }}
        "#,
        layout.display()
    );
    let path = folder.join("elsewhere.toml");
    std::fs::write(&path, &text).expect("written");
    let found = scenarios::load(&path);
    // Its own table, once there is one.
    let own = folder.join("types.csv");
    let table = std::fs::read_to_string(shipped.join("types.csv")).expect("the table");
    std::fs::write(&own, table.replace("A320,", "A999,")).expect("written");
    let refused = scenarios::load(&path);
    std::fs::remove_dir_all(&folder).expect("removed");
    assert!(found.is_ok(), "{:?}", found.err().map(|e| e.to_string()));
    let words = refused.map(|_| ()).expect_err("no such type").to_string();
    assert!(words.contains("A320") && words.contains("A999"), "{words}");
}

#[test]
fn a_file_that_is_no_scene_is_refused_without_being_read_to_its_end() {
    let said = |path: &str| load(Path::new(path)).expect_err("no scene").to_string();
    assert_eq!(said("/dev/zero"), "scene /dev/zero: longer than 16 MiB");
    assert!(
        said("nosuch").contains("scenes that come with SEEDS: asmgcs, egcc, eham, xsyn, zurich"),
        "{}",
        said("nosuch")
    );
    let file = std::env::temp_dir().join(format!("seeds-latin-{}.toml", std::process::id()));
    std::fs::write(&file, b"[run]\ntitle = \"Z\xfcrich\"\n").expect("written");
    let line = load(&file).expect_err("not UTF-8").to_string();
    std::fs::remove_file(&file).expect("removed");
    assert!(line.ends_with(":2: scene: not UTF-8 text"), "{line}");
    let long = "x".repeat(1_000_000);
    assert!(error_with("EDW229", &long).len() < 400, "a megabyte does not come back in a message");
}

/// A mix without a type was taken for none at all, and airliners came.
#[test]
fn a_mix_in_which_nothing_can_be_drawn_is_refused_in_one_sentence() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mix.toml");
    let of = |mix: &str| {
        let text = format!(
            "[run]\ntitle = \"t\"\nseed = 1\nduration_s = 600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
             [[traffic]]\nkind = \"generated\"\narrivals_per_h = 6\ndepartures_per_h = 6\n{mix}\n"
        );
        scenarios::load_text(&path, &text).map(|_| ()).map_err(|e| e.to_string())
    };
    for mix in ["mix = {}", "mix = { A320 = 0 }", "mix = { A320 = 0, C172 = 0.0 }"] {
        let words = of(mix).expect_err(mix);
        assert!(words.contains(":11:") && words.contains("mix"), "{words}");
        assert!(words.contains("a type with a weight above 0"), "{words}");
        assert_eq!(words.lines().count(), 1, "{words}");
    }
    for mix in ["", "mix = { A320 = 0, C172 = 1 }"] {
        assert_eq!(of(mix), Ok(()), "{mix}");
    }
}
