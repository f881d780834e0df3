//! Same scene and seed, same bits, however many processes share the work and whatever gets lost.

use crate::common;

use crate::common::{Folder, Ports, finish, run, summary};
use serde_json::Value;

fn digest(arguments: &[&str]) -> (String, Value) {
    let ports = Ports::new();
    let fast = ["--fast", "--duration", "60", "--no-viewer"];
    let output = finish(run(&ports, &[&fast[..], arguments].concat()));
    let summary = summary(&output);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", common::stderr(&output));
    assert_eq!(summary["frames"], 1200, "{arguments:?}");
    (summary["digest"].as_str().expect("a digest").to_owned(), summary)
}

#[test]
fn the_digest_depends_on_scene_and_seed_and_on_nothing_else() {
    let (reference, summary) = digest(&[]);
    assert!(summary["plots"]["asde"].as_u64() > Some(100), "{summary}");
    assert!(summary["tracks"]["confirmed"].as_u64() >= Some(3), "{summary}");

    for arguments in [
        &[][..],
        &["--in-process"],
        &["--generators", "2"],
        &["--generators", "3", "--in-process"],
        &["--smdfms", "3"],
        &["--generators", "2", "--smdfms", "2", "--in-process"],
    ] {
        let (other, _) = digest(arguments);
        assert_eq!(other, reference, "{arguments:?}");
    }

    let (lossy, summary) = digest(&["--inject-loss", "0.05"]);
    assert_eq!(lossy, reference, "with loss");
    assert!(summary["truth"]["repaired"].as_u64() > Some(0), "{summary}");

    let (other_seed, _) = digest(&["--seed", "7"]);
    assert_ne!(other_seed, reference);
}

/// Every row that sensors and tracker leave in the log, what each effect did to each plot and the plans of the effects among them.
#[test]
fn the_log_of_several_smdfms_is_that_of_one() {
    let folder = Folder::new("smdfms");
    let logged = |smdfms: &str| -> Vec<(&str, Vec<String>)> {
        let path = folder.file(&format!("{smdfms}.pcapng"));
        let fast = ["--fast", "--duration", "60", "--no-viewer", "--record", &path];
        let command = run(&Ports::new(), &[&fast[..], &["--smdfms", smdfms]].concat());
        let output = finish(command);
        assert_eq!(output.status.code(), Some(0), "{smdfms}: {}", common::stderr(&output));
        let log = folder.file(&format!("{smdfms}.sqlite"));
        let log = rusqlite::Connection::open(log).expect("a database");
        let rows = |table: &'static str| {
            let mut query = log.prepare(&format!("SELECT * FROM {table}")).expect(table);
            let columns = query.column_count();
            let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<String> {
                (0..columns).map(|c| Ok(format!("{:?} ", row.get_ref(c)?))).collect()
            };
            let rows = query.query_map([], row).expect(table);
            let mut rows: Vec<String> = rows.map(|row| row.expect(table)).collect();
            rows.sort();
            (table, rows)
        };
        ["plots", "plot_effects", "plan", "tracks", "truth"].map(rows).to_vec()
    };
    let one = logged("1");
    assert!(one.iter().all(|(_, rows)| rows.len() > 20), "{one:?}");
    for smdfms in ["2", "3"] {
        for ((table, of_one), (_, rows)) in one.iter().zip(logged(smdfms)) {
            assert!(*of_one == rows, "{smdfms} SMDFMs: {table} differs");
        }
    }
}

#[test]
fn a_recording_replayed_gives_the_same_digest() {
    let folder = Folder::new("replay");
    let path = &folder.file("run.pcapng");
    let ports = Ports::new();
    let output = finish(run(
        &ports,
        &["--fast", "--duration", "60", "--seed", "5", "--no-viewer", "--record", path],
    ));
    let recorded = summary(&output);
    assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));

    let mut replay = common::seeds();
    replay.args(["replay", path, "--with-smdfm", "--scene", "zurich"]);
    let output = finish(replay);
    let replayed = summary(&output);
    assert_eq!(replayed["digest"], recorded["digest"]);
    assert_eq!(replayed["track_digest"], recorded["track_digest"]);
    assert_eq!(replayed["seed"], 5, "the seed comes from the recording");

    // The database beside it holds what a person asks for.
    let database = rusqlite::Connection::open(folder.file("run.sqlite")).expect("a database");
    let count = |table: &str| -> i64 {
        let query = format!("SELECT COUNT(*) FROM {table}");
        database.query_row(&query, [], |row| row.get(0)).expect(table)
    };
    assert_eq!(count("scans"), 60);
    assert!(count("plots") > 100 && count("tracks") > 60 && count("truth") > 60);

    // Wireshark's dissector reads every frame, where it is installed.
    if let Ok(output) = std::process::Command::new("tshark")
        .args([
            "-r",
            path,
            "-d",
            "udp.port==20000-65535,dis",
            "-T",
            "fields",
            "-e",
            "_ws.malformed",
            "-e",
            "dis.pdu_type",
        ])
        .output()
    {
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(!text.contains("alformed"), "tshark finds malformed PDUs");
        assert!(text.lines().filter(|l| l.trim() == "1").count() > 50, "Entity State PDUs");
    } else {
        eprintln!("skipped: tshark is not installed");
    }
}

#[test]
fn a_spectator_that_stops_or_dies_changes_nothing() {
    let (reference, _) = digest(&[]);
    let folder = Folder::new("spectator");
    for signal in ["STOP", "KILL"] {
        let ports = Ports::new();
        let file = folder.file(&format!("{signal}.pcapng"));
        let path = file.clone();
        let watcher = std::thread::spawn(move || {
            let viewer = common::wait_for(std::time::Duration::from_secs(20), || {
                let found = common::processes(&format!("--record {path}"));
                let viewers: Vec<i32> = found
                    .into_iter()
                    .filter(|pid| common::processes("viewer-logger").contains(pid))
                    .collect();
                viewers.first().copied()
            });
            // While it joins or while the run goes on: it must not matter when.
            std::thread::sleep(std::time::Duration::from_millis(700));
            if let Some(pid) = viewer {
                common::kill(signal, pid);
            }
        });
        let output =
            finish(run(&ports, &["--fast", "--duration", "60", "--no-viewer", "--record", &file]));
        watcher.join().expect("the watcher ends");
        assert_eq!(summary(&output)["digest"], reference, "{signal}");
    }
}

/// Aircraft on a final of ten miles are beyond the unambiguous range of a radar whose carrier stands still: kilometres off, in more than
/// one plot in twenty.
#[test]
fn echoes_of_a_pulse_before_the_last_are_counted_and_in_no_error() {
    let ports = Ports::new();
    let folder = Folder::new("far");
    let report = folder.file("report");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
    let text = std::fs::read_to_string(format!("{shipped}/eham.toml")).expect("the scene");
    let radar = "parameters = \"ku_asde3\"\n";
    assert!(text.contains(radar));
    let text = text
        .replace("\"airports/", &format!("\"{shipped}/airports/"))
        .replace("\"schedules/", &format!("\"{shipped}/schedules/"))
        .replace(radar, &format!("{radar}overrides = {{ frequency_agile = false }}\n"));
    let scene = folder.file("fixed.toml");
    std::fs::write(&scene, text).expect("a scene");
    let arguments = [&scene[..], "--fast", "--duration", "900", "--report", &report];
    let summary = summary(&finish(run(&ports, &arguments)));
    let tracks = &summary["tracks"];
    let of = |key: &str| tracks[key].as_f64().unwrap_or_else(|| panic!("{key}: {tracks}"));
    for key in ["raw_rmse_m", "rmse_m", "straight_raw_rmse_m", "straight_rmse_m"] {
        assert!(of(key) < 12.0, "{key}: {tracks}");
    }
    assert!(of("rmse_m") < of("raw_rmse_m"), "{tracks}");
    assert!(of("gross_plots") > 300.0 && of("far_reports") > 300.0, "{tracks}");
    // Nor in the log: whoever follows an echo kilometres off follows nobody, and the target's error is not his.
    let log = rusqlite::Connection::open(format!("{report}/run.sqlite")).expect("the log");
    let number = |sql: &str| log.query_row(sql, [], |row| row.get::<_, f64>(0)).expect("a number");
    assert!(number("SELECT max(track_error_m) FROM truth") <= 60.0);
    assert!(number("SELECT max(worst_m) FROM target_accuracy") <= 60.0);
    assert!(number("SELECT count(*) FROM false_tracks WHERE scans > 3") > 0.0);
}
