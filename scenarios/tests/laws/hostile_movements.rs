//! Damaged and hostile recordings: repaired with a report, or refused with file, line and reason; never
//! a panic.

use models::truth::recorded::Rule;
use scenarios::{Scene, load_text};
use std::path::{Path, PathBuf};

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scene of one recorded movement, from the text of its file.
fn scene_of(name: &str, csv: &str) -> Result<Scene, String> {
    let folder = std::env::temp_dir().join(format!("seeds-hostile-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file: PathBuf = folder.join(format!("{name}.csv"));
    std::fs::write(&file, csv).expect("a file");
    let text = format!(
        "[run]\ntitle = \"hostile\"\nseed = 1\nstart = 2019-11-24T09:00:00Z\nduration_s = 600\n\
         [airport]\nlayout = \"airports/LSZH.apt.dat\"\n\
         [weather]\ntimeline = [{{ at_s = 0 }}]\n\
         [[traffic]]\nkind = \"recorded\"\ncallsign = \"CAI3208\"\ntype = \"B738\"\n\
         file = \"{}\"\nstart_s = 0\n",
        file.display()
    );
    let result = load_text(&here().join("hostile.toml"), &text);
    let _ = std::fs::remove_file(&file);
    result.map_err(|e| e.to_string().replace(&format!("{}/", folder.display()), ""))
}

/// The rows of a sound recording, cell by cell, without the header.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(here().join("movements/CAI3208.csv")).expect("a recording");
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).take(640).map(cells).collect()
}

const HEADER: &str = "timestamp_ms,icao24,callsign,latitude_deg,longitude_deg,altitude_ft,groundspeed_kt,track_deg,vertical_rate_fpm,onground";

fn csv(rows: &[Vec<String>]) -> String {
    let lines: Vec<String> = rows.iter().map(|r| r.join(",")).collect();
    format!("{HEADER}\n{}\n", lines.join("\n"))
}

fn changed(change: impl Fn(&mut Vec<Vec<String>>)) -> String {
    let mut rows = rows();
    change(&mut rows);
    csv(&rows)
}

#[test]
fn what_cannot_be_repaired_is_refused_with_file_line_and_reason() {
    let far = |rows: &mut Vec<Vec<String>>| {
        for row in rows {
            let lat: f64 = row[3].parse().unwrap_or(47.0);
            row[3] = format!("{}", lat + 9.0);
        }
    };
    for (name, text, expected) in [
        ("empty", String::new(), "empty.csv:1: timestamp_ms: missing"),
        ("header", format!("{HEADER}\n"), "header.csv:1: movement: found \"no record\""),
        (
            "column",
            changed(|_| ()).replacen("latitude_deg", "breadth", 1),
            "column.csv:1: latitude_deg: missing; needed is a column latitude_deg in the header",
        ),
        (
            "nan",
            changed(|rows| rows.iter_mut().for_each(|r| r[3] = "NaN".into())),
            "nan.csv:641: movement: only 0 of 640 positions are sound, needed are 10 and an eighth of all (640 filled: position missing or not a number)",
        ),
        (
            "words",
            changed(|rows| rows.iter_mut().for_each(|r| r[0] = "noon".into())),
            "words.csv:641: movement: only 0 of 640 positions are sound, needed are 10 and an eighth of all (640 rejected: time missing or not a number)",
        ),
        (
            "one",
            changed(|rows| rows.truncate(1)),
            "one.csv:2: movement: only 0 of 1 positions are sound",
        ),
        (
            "elsewhere",
            changed(far),
            "elsewhere.csv:641: movement: only 0 of 640 positions are sound, needed are 10 and an eighth of all (640 rejected: position more than 60 km away)",
        ),
        ("backwards", changed(|rows| rows.reverse()), "backwards.csv:641: movement: only"),
        (
            "gap",
            changed(|rows| rows[100..420].iter_mut().for_each(|r| r[4] = String::new())),
            "gap.csv:422: movement: no sound position for 3",
        ),
        (
            "long",
            changed(|rows| {
                for (i, row) in rows.iter_mut().enumerate() {
                    row[0] = format!("{}", 1_571_000_000_000_i64 + 60_000 * i as i64);
                }
            }),
            "long.csv:6",
        ),
        (
            "huge",
            {
                let row = rows()[0].join(",");
                format!("{HEADER}\n{}", format!("{row}\n").repeat(144_010))
            },
            "huge.csv:144002: movement: found \"more than 144000 records\"",
        ),
    ] {
        let error = scene_of(name, &text).expect_err(name);
        assert!(error.starts_with(expected), "{name}:\n{error}\n{expected}");
        assert!(!error.contains('\n'), "{name}: one line");
    }
}

#[test]
fn what_can_be_repaired_is_and_the_report_counts_it() {
    let dense = |rows: &mut Vec<Vec<String>>| {
        // Every record forty times, 5 ms apart.
        let many = rows.iter().flat_map(|row| {
            (0..40).map(move |k| {
                let mut copy = row.clone();
                copy[0] = format!("{}", row[0].parse::<i64>().expect("a time") + 5 * k);
                copy
            })
        });
        *rows = many.collect();
    };
    for (name, text, rule, least) in [
        ("teleport", changed(|rows| rows[300][3] = "47.60".into()), Rule::Jump, 1),
        (
            "holes",
            changed(|rows| rows.iter_mut().step_by(3).for_each(|r| r[4] = "NaN".into())),
            Rule::NoPosition,
            200,
        ),
        (
            "swapped",
            changed(|rows| rows.chunks_exact_mut(20).for_each(|c| c.swap(3, 4))),
            Rule::TimeOrder,
            25,
        ),
        (
            "short rows",
            changed(|rows| rows.iter_mut().step_by(5).for_each(|r| r.truncate(2))),
            Rule::NoPosition,
            100,
        ),
        ("dense", changed(dense), Rule::TooOften, 640 * 39),
    ] {
        let scene = scene_of(name, &text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let entity = &scene.traffic.entities[0];
        let report = entity.report.as_ref().expect("recorded");
        let count = report.tally.count(rule);
        assert!(count >= least, "{name}: {rule:?} counted {count} times\n{report}");
        let trajectory = entity.trajectory.as_ref().expect("loaded with truth");
        let state = trajectory.at(trajectory.start()).expect("its own begin");
        assert!(state.position_m.iter().all(|x| x.is_finite()), "{name}");
    }
}

#[test]
fn noise_does_no_harm() {
    // Cells struck out, made huge or letters, by a fixed pattern.
    let mut read = 0;
    for seed in 0..12_u64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        let text = changed(|_| ());
        let mut lines: Vec<String> = text.lines().map(Into::into).collect();
        for _ in 0..60 * (seed + 1) {
            let line = 1 + (next() % 600) as usize;
            let mut cells: Vec<&str> = lines[line].split(',').collect();
            let cell = (next() % cells.len().max(1) as u64) as usize;
            cells[cell] = ["", "1e308", "-1", "x", "NaN", "inf", "999999999999999999", "\""]
                [(next() % 8) as usize];
            lines[line] = cells.join(",");
        }
        if let Ok(scene) = scene_of(&format!("noise{seed}"), &lines.join("\n")) {
            let trajectory = scene.traffic.entities[0].trajectory.as_ref().expect("with truth");
            let state = trajectory.at(trajectory.end()).expect("its own end");
            assert!(state.velocity_mps.iter().all(|x| x.is_finite()), "seed {seed}");
            read += 1;
        }
    }
    println!("{read} of 12 read");
    assert!(read > 0, "noise that nobody reads could do no harm");
}
