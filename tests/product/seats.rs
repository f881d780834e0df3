//! Controllers at their seats through the product: the same bits in every layout, and what they did in the run's log.

use crate::common;

use crate::common::{Folder, Ports, finish, run, summary};

/// A scene of generated traffic with controllers, at an airport whose ways nobody tuned anything on.
fn scene(folder: &Folder, name: &str, control: &str) -> String {
    let path = folder.file(&format!("{name}.toml"));
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"seats\"\nseed = 11\nduration_s = 480\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 20\ndepartures_per_h = 30\n[control]\n{control}\n"
    );
    std::fs::write(&path, text).expect("a scene");
    path
}

fn digest(scene: &str, arguments: &[&str]) -> String {
    let ports = Ports::new();
    let fast = [scene, "--fast", "--no-viewer"];
    let output = finish(run(&ports, &[&fast[..], arguments].concat()));
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", common::stderr(&output));
    let summary = summary(&output);
    let text = std::fs::read_to_string(scene).expect("the scene");
    let duration = text.split("duration_s = ").nth(1).and_then(|t| t.split_whitespace().next());
    let frames = 20 * duration.and_then(|d| d.parse::<u64>().ok()).expect("a duration");
    assert_eq!(summary["frames"], frames, "{arguments:?}");
    summary["digest"].as_str().expect("a digest").to_owned()
}

/// All layouts of a scene: one digest. The log of one of them.
fn flown(folder: &Folder, name: &str, control: &str) -> (String, rusqlite::Connection) {
    let scene = scene(folder, name, control);
    let reference = digest(&scene, &["--in-process"]);
    let record = folder.file(&format!("{name}.pcapng"));
    for arguments in [
        &["--in-process", "--generators", "2"][..],
        &["--in-process", "--generators", "4"],
        &["--record", &record],
        &["--generators", "2"],
        &["--generators", "4"],
    ] {
        assert_eq!(digest(&scene, arguments), reference, "{name}: {arguments:?}");
    }
    let log = folder.file(&format!("{name}.sqlite"));
    (reference, rusqlite::Connection::open(log).expect("a database"))
}

fn count(log: &rusqlite::Connection, query: &str) -> i64 {
    log.query_row(query, [], |row| row.get(0)).unwrap_or_else(|e| panic!("{query}: {e}"))
}

/// Everybody moves by what was said: each clearance of a seat was spoken and read back before it held.
fn what_people_did_is_told(log: &rusqlite::Connection, name: &str) {
    let given = "FROM clearances WHERE seat <> 'plan' AND kind IN ('PSH', 'TAX', 'LUP', 'TOF')";
    let clearances = count(log, &format!("SELECT count(*) {given}"));
    assert!(clearances >= 4, "{name}: {clearances}");
    assert_eq!(count(log, "SELECT count(*) FROM clearances WHERE seat = 'plan'"), 0, "{name}");
    let unread = count(
        log,
        &format!(
            "SELECT count(*) {given} AND kind <> 'TAX' AND NOT EXISTS (SELECT 1 FROM radio WHERE radio.kind = 'readback' \
             AND sender = callsign AND radio.time_ns <= clearances.time_ns AND clearance = clearances.kind)"
        ),
    );
    assert_eq!(unread, 0, "{name}");
    // Every seat says each minute how busy it was; those who spoke were.
    assert!(count(log, "SELECT count(DISTINCT seat) FROM seats") >= 3, "{name}");
    assert!(count(log, "SELECT count(*) FROM seats WHERE busy > 0.02") > 5, "{name}");
    assert_eq!(count(log, "SELECT count(*) FROM seats WHERE busy > 1.000001"), 0, "{name}");
    let load = "SELECT count(*) FROM measures WHERE name LIKE '%: on air in 15 min' AND value > 0";
    assert!(count(log, load) >= 3, "{name}");
    // One transmission at a time on each frequency: of two, the last words are further apart than the shortest message.
    let doubled = "WITH said AS (SELECT time_ns, CASE WHEN sender IN (SELECT seat FROM seats) THEN sender ELSE receiver END AS f, rowid AS n \
         FROM radio) SELECT count(*) FROM said a JOIN said b ON a.n < b.n AND a.f = b.f AND abs(a.time_ns - b.time_ns) < 2400000000";
    assert_eq!(count(log, doubled), 0, "{name}");
}

#[test]
fn controllers_on_truth_give_one_digest_in_every_layout_and_their_log() {
    let folder = Folder::new("seats-truth");
    let (digest_truth, log) = flown(&folder, "truth", "sees = \"truth\"");
    what_people_did_is_told(&log, "truth");
    // It is they who clear, not the plan.
    let by_plan = scene(&folder, "plan", "sees = \"none\"");
    assert_ne!(digest(&by_plan, &["--in-process"]), digest_truth);
}

/// A seat that the scene leaves to people and where nobody sits: nobody is cleared from it; with `fallback` its model begins after 30 s.
#[test]
fn an_empty_seat_of_a_person_clears_nobody_until_its_model_may_take_it() {
    let folder = Folder::new("seats-human");
    let taxis = |name: &str, rest: &str| {
        let scene = scene(&folder, name, &format!("sees = \"truth\"\n{rest}"));
        let record = folder.file(&format!("{name}.pcapng"));
        digest(&scene, &["--record", &record]);
        let log =
            rusqlite::Connection::open(folder.file(&format!("{name}.sqlite"))).expect("a database");
        // Who has landed taxies on by his plan and asks nobody.
        let first = "SELECT min(time_ns) FROM clearances WHERE kind = 'TAX' AND seat = 'ground' AND callsign LIKE 'GD%'";
        let first: Option<i64> = log.query_row(first, [], |row| row.get(0)).expect("a row");
        (
            first.map(|ns| ns / 1_000_000_000),
            count(&log, "SELECT count(*) FROM clearances WHERE kind = 'PSH'"),
        )
    };
    let (model_s, pushes) = taxis("model", "");
    assert!(model_s.is_some() && pushes >= 2, "{model_s:?} {pushes}");
    let (human_s, pushes) = taxis("human", "seats = { ground = \"human\" }");
    // Who is pushed back and waits for his taxi clearance is in the way of the next one.
    assert!(human_s.is_none() && pushes >= 1, "the others go on: {human_s:?} {pushes}");
    let (back_s, _) = taxis("fallback", "seats = { ground = \"human\" }\nfallback = true");
    assert!(back_s.is_some_and(|s| s >= 30), "{back_s:?}");
    let (nobody_s, pushes) = taxis("apron", "seats = { apron = \"human\", tower = \"human\" }");
    assert_eq!((nobody_s, pushes), (None, 0));
}

/// The same with the loop closed: traffic, sensors, tracks, controllers, and what they clear back to the traffic.
#[test]
fn controllers_on_tracks_give_one_digest_in_every_layout_and_their_log() {
    let folder = Folder::new("seats-tracks");
    let on_tracks = "sees = \"tracks\"\ncontrollers = \"model\"";
    let (digest_tracks, log) = flown(&folder, "tracks", on_tracks);
    what_people_did_is_told(&log, "tracks");
    assert_eq!(count(&log, "SELECT count(*) FROM run WHERE name = 'seat_events_lost'"), 0);
    // The log flies the traffic again with what was said: whoever left his block in it was seen to do so then.
    let mut left = log
        .prepare("SELECT callsign, aobt_ns FROM movements WHERE aobt_ns < 450000000000")
        .expect("a table");
    let rows = left.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)? / 1_000_000_000)));
    let all: Vec<(String, i64)> = rows.and_then(Iterator::collect).expect("rows");
    assert!(!all.is_empty());
    for (callsign, at_s) in all {
        let moved = |from: i64, to: i64| -> f64 {
            let query = "SELECT max(x_m) - min(x_m) + max(y_m) - min(y_m) FROM truth WHERE callsign = ? AND scan BETWEEN ? AND ?";
            log.query_row(query, (&callsign, from, to), |row| row.get(0)).expect("seen")
        };
        let (before_m, after_m) = (moved(at_s - 10, at_s - 1), moved(at_s + 3, at_s + 25));
        assert!(before_m < 0.5 && after_m > 2.0, "{callsign} {at_s} s: {before_m} {after_m} m");
    }
    // Without a sensor nothing looks occupied, and who calls is believed: bit for bit what the same people clear on truth, though here
    // every clearance has come through the federation.
    let by_truth = scene(&folder, "truth", "sees = \"truth\"");
    let by_plan = scene(&folder, "plan", "sees = \"tracks\"");
    assert_eq!(digest(&by_truth, &["--in-process"]), digest_tracks);
    assert_ne!(digest(&by_plan, &["--in-process"]), digest_tracks);
}

/// What a person does, as lines of `--inputs`: sits down at the apron, clears those who wait there at times, tries what is not
/// possible, and leaves. `late`: frames by which the clearances come later.
fn a_person(folder: &Folder, name: &str, asked: &[(u64, String, String)], late: u64) -> String {
    let path = folder.file(name);
    let line = |frame: u64, action: &str, more: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"apron\",\"person\":\"anna\",\"action\":\"{action}\"{more}}}\n"
        )
    };
    let mut text = line(20, "take", "");
    for (frame, callsign, clearance) in asked {
        let more = format!(",\"callsign\":\"{callsign}\",\"clearance\":\"{clearance}\"");
        text += &line(frame + late, "say", &more);
        text += &line(frame + late + 7, "here", "");
    }
    text += &line(7000, "leave", "");
    std::fs::write(&path, text).expect("inputs");
    path
}

/// A person has the apron for five minutes: nobody is pushed but as he says, equal inputs give equal runs in every layout, and
/// so do the inputs that the log of the run kept; a frame later is another run.
#[test]
fn a_person_at_a_seat_gives_one_digest_in_every_layout_and_again_from_the_log() {
    let folder = Folder::new("seats-person");
    let scene = scene(&folder, "person", "sees = \"tracks\"\ncontrollers = \"model\"");
    let text = std::fs::read_to_string(&scene).expect("the scene");
    std::fs::write(&scene, text.replace("per_h = 30", "per_h = 120")).expect("a busier one");
    let fly = |arguments: &[&str]| digest(&scene, arguments);
    // Who wants to be pushed, and when, once nobody answers.
    let silent = a_person(&folder, "silent.jsonl", &[], 0);
    let record = folder.file("silent.pcapng");
    let unanswered = fly(&["--record", &record, "--inputs", &silent]);
    let by_model = fly(&["--in-process"]);
    assert_ne!(unanswered, by_model);
    let log = rusqlite::Connection::open(folder.file("silent.sqlite")).expect("a database");
    let calls = "SELECT sender, time_ns / 50000000 FROM radio WHERE kind = 'request' AND clearance = 'PSH' AND time_ns < 290000000000";
    let mut rows = log.prepare(calls).expect("a table");
    let rows =
        rows.query_map([], |row| Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)? as u64)));
    let calls: Vec<(String, u64)> = rows.and_then(Iterator::collect).expect("rows");
    assert!(calls.len() >= 2, "{calls:?}");
    let pushed = "SELECT count(*) FROM clearances WHERE kind = 'PSH' AND seat = 'apron' AND time_ns < 150000000000";
    assert_eq!(count(&log, pushed), 0, "nobody is pushed whom nobody cleared");
    // Nothing was heard of him for 150 s: the model takes the seat back, and clears them.
    assert!(
        count(&log, "SELECT count(*) FROM clearances WHERE kind = 'PSH' AND seat = 'apron'") > 0
    );

    let spell = "SELECT person || ' ' || taken_frame || ' ' || ended || ' ' || until_s || ' ' || orders FROM people_seats";
    let spell: String = log.query_row(spell, [], |row| row.get(0)).expect("one who sat there");
    assert_eq!(spell, "anna 20 silent 152.0 0");
    let again = folder.file("silent.sqlite");
    assert_eq!(fly(&["--in-process", "--inputs", &again]), unanswered, "from the log");

    let mut asked = vec![(300, calls[0].0.clone(), "LUP".to_owned())];
    for (callsign, frame) in &calls {
        asked.push((frame + 203, callsign.clone(), "PSH".to_owned()));
    }
    asked.sort();
    let inputs = a_person(&folder, "inputs.jsonl", &asked, 0);
    let reference = fly(&["--in-process", "--inputs", &inputs]);
    assert!(reference != unanswered && reference != by_model);
    let record = folder.file("said.pcapng");
    for arguments in
        [&["--in-process", "--generators", "4"][..], &["--generators", "2"], &["--record", &record]]
    {
        let all = [arguments, &["--inputs", &inputs]].concat();
        assert_eq!(fly(&all), reference, "{arguments:?}");
    }
    // Where controllers know the truth there is the same seat, and here it makes no other run.
    let text = std::fs::read_to_string(&scene).expect("the scene");
    let on_truth = folder.file("on-truth.toml");
    let tracks = "sees = \"tracks\"\ncontrollers = \"model\"";
    std::fs::write(&on_truth, text.replace(tracks, "sees = \"truth\"")).expect("a scene");
    for arguments in [&["--in-process"][..], &["--generators", "2"]] {
        let all = [arguments, &["--inputs", &inputs]].concat();
        assert_eq!(digest(&on_truth, &all), reference, "on truth, {arguments:?}");
    }
    let log = rusqlite::Connection::open(folder.file("said.sqlite")).expect("a database");
    // Everything that he did is there with its frame; what was not possible with its reason.
    assert_eq!(count(&log, "SELECT count(*) FROM inputs"), 2 + 2 * asked.len() as i64);
    let refused =
        "SELECT count(*) FROM inputs WHERE refused <> '' AND clearance = 'LUP' AND frame = 300";
    assert_eq!(count(&log, refused), 1);
    let said = count(&log, "SELECT count(*) FROM inputs WHERE action = 'say' AND refused = ''");
    assert!(said >= 2, "{said}");
    // Each was spoken on the frequency after it was said, read back, and only then acted upon.
    let unread = "SELECT count(*) FROM inputs i JOIN clearances c ON c.callsign = i.callsign AND c.kind = i.clearance \
         WHERE i.refused = '' AND action = 'say' AND NOT EXISTS (SELECT 1 FROM radio r WHERE r.sender = i.callsign \
         AND r.kind = 'readback' AND r.time_ns > i.time_ns AND r.time_ns <= c.time_ns)";
    assert_eq!(count(&log, unread), 0);
    // The same in the report: who sat where, what came of each order.
    let one = "SELECT count(*) FROM people_seats WHERE seat = 'apron' AND taken_s = 1.0 AND until_s = 350.0 AND ended = 'leave'";
    assert_eq!(count(&log, one), 1);
    let orders = "SELECT count(*) FROM people_orders WHERE answer = 'accepted' AND time_s < read_back_s AND \
         (holds_s IS NULL OR read_back_s < holds_s)";
    assert_eq!(count(&log, orders), said, "accepted, read back, held");
    let held = "SELECT count(*) FROM people_orders WHERE holds_s IS NOT NULL";
    assert!(count(&log, held) >= 2);
    let why = "SELECT count(*) FROM people_orders WHERE frame = 300 AND answer <> 'accepted' AND read_back_s IS NULL AND holds_s IS NULL";
    assert_eq!(count(&log, why), 1, "refused, and why");
    let early = "SELECT count(*) FROM clearances c WHERE kind = 'PSH' AND seat = 'apron' AND time_ns < 350000000000 \
         AND NOT EXISTS (SELECT 1 FROM inputs i WHERE i.callsign = c.callsign AND i.refused = '' AND i.time_ns < c.time_ns)";
    assert_eq!(count(&log, early), 0, "the model of his seat is silent");
    let again = folder.file("said.sqlite");
    assert_eq!(fly(&["--in-process", "--inputs", &again]), reference, "from the log");
    // Who waits to be pushed looks once a second: a second later the truth is another, a frame later only the words are.
    let late = a_person(&folder, "late.jsonl", &asked, 20);
    assert_ne!(fly(&["--in-process", "--inputs", &late]), reference, "a second later");
    let (late, record) = (a_person(&folder, "frame.jsonl", &asked, 1), folder.file("frame.pcapng"));
    fly(&["--record", &record, "--inputs", &late]);
    let shifted = rusqlite::Connection::open(folder.file("frame.sqlite")).expect("a database");
    let first = "SELECT min(time_ns) FROM radio WHERE kind = 'readback' AND sender IN (SELECT callsign FROM inputs)";
    assert_eq!(count(&shifted, first), count(&log, first) + 50_000_000, "a frame later");
}

/// `seeds score --alerts` of a run: all figures of all kinds, and those in all.
fn scored(truth: &str, alerts: &str) -> serde_json::Value {
    let mut command = common::seeds();
    command.args(["score", "--truth", truth, "--alerts", alerts, "--json"]);
    let output = finish(command);
    assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// The alerts that a run exported score as the run itself says; late, removed and invented ones as what they are.
fn the_score_of_exported_alerts_is_that_of_the_run(
    folder: &Folder,
    log: &rusqlite::Connection,
    sqlite: &str,
    exported: &str,
) {
    let write = |name: &str, text: String| {
        let path = folder.file(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let whole = write("alerts.csv", exported.to_owned());
    let own = scored(sqlite, &whole);
    let mut kinds = own["kinds"].as_array().expect("kinds").clone();
    kinds.push(own["all"].clone());
    let mut compared = 0;
    for kind in &kinds {
        for (word, key) in [
            ("reference", "reference"),
            ("detected", "detected"),
            ("missed", "missed"),
            ("false", "false"),
            ("nuisance", "nuisance"),
            ("response median", "response_median_s"),
            ("response 95 %", "response_95_percent_s"),
            ("false per 100 movements", "false_per_100_movements"),
            ("nuisance per 100 movements", "nuisance_per_100_movements"),
        ] {
            let name = format!("alerts {}: {word}", kind["kind"].as_str().expect("a word"));
            let value = "SELECT value FROM measures WHERE source = 'tracks' AND name = ?";
            let value: Option<f64> = log.query_row(value, [&name], |row| row.get(0)).ok();
            if let Some(value) = value {
                assert!((kind[key].as_f64().expect(key) - value).abs() < 1e-9, "{name}");
                compared += 1;
            }
        }
    }
    assert!(compared > 10, "{compared}");
    let of_database = scored(sqlite, sqlite);
    assert_eq!(own["kinds"], of_database["kinds"], "the database is as good as the table");
    let figure =
        |score: &serde_json::Value, key: &str| score["all"][key].as_f64().expect("a figure");
    let (detected, false_ones) = (figure(&own, "detected"), figure(&own, "false"));
    assert!(detected >= 2.0);
    // Half a minute late: some still while the true one stands, none in time.
    let columns: Vec<&str> = exported.lines().next().expect("heads").split(',').collect();
    let at = columns.iter().position(|c| *c == "time_ns").expect("a time");
    let late = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(ns) = fields[at].parse::<i64>() {
            fields[at] = (ns + 30_000_000_000).to_string();
        }
        fields.join(",") + "\n"
    };
    let late = scored(sqlite, &write("late.csv", exported.lines().map(late).collect()));
    assert_eq!(figure(&late, "detected"), 0.0);
    // Two seconds late: detected, and so much later.
    let median = figure(&own, "response_median_s");
    let heads = "time_s,kind,subjects,end_s\n".to_owned();
    let row = |alert: &serde_json::Value, by_s: f64| {
        let subjects: Vec<&str> =
            alert["subjects"].as_array().expect("some").iter().filter_map(|s| s.as_str()).collect();
        let (time_s, end_s) = (alert["time_s"].as_f64().expect("a time"), alert["end_s"].as_f64());
        let end_s = end_s.map_or(String::new(), |s| s.to_string());
        format!(
            "{},{},{},{end_s}\n",
            time_s + by_s,
            alert["kind"].as_str().expect("a kind"),
            subjects.join(" ")
        )
    };
    let truth = own["truth"].as_array().expect("true ones");
    let exact: String = truth.iter().map(|a| row(a, 2.0)).collect();
    let score = scored(sqlite, &write("exact.csv", heads.clone() + &exact));
    assert_eq!((figure(&score, "missed"), figure(&score, "false")), (0.0, 0.0));
    assert_eq!(
        (figure(&score, "response_median_s"), figure(&score, "response_95_percent_s")),
        (2.0, 2.0)
    );
    assert!(median < 2.0, "{median}");
    // One removed is one missed, one invented is one false.
    let less: String = truth.iter().skip(1).map(|a| row(a, 0.0)).collect();
    let score = scored(sqlite, &write("less.csv", heads + &less + "100,STOPBAR,NOBODY,110\n"));
    assert_eq!((figure(&score, "missed"), figure(&score, "false")), (1.0, 1.0));
    let silent = scored(sqlite, &write("silent.csv", "time_s,kind,subjects\n".to_owned()));
    assert_eq!((figure(&silent, "detected"), figure(&silent, "false")), (0.0, 0.0));
    assert_eq!(figure(&silent, "missed"), figure(&own, "reference"));
    assert!(false_ones <= figure(&late, "false"), "late ones are not less false");
}

/// A person at the tower clears everybody to land and everybody to line up, and nobody to take off: an incursion. It is raised on
/// tracks of these two when it is on truth, whoever lands sees it in time, and it is the same run in every layout and from its log.
#[test]
fn a_person_provokes_an_incursion_and_the_alert_is_raised_on_tracks() {
    let folder = Folder::new("seats-incursion");
    let scene = scene(&folder, "tower", "sees = \"tracks\"\ncontrollers = \"model\"");
    let text = std::fs::read_to_string(&scene).expect("the scene");
    std::fs::write(&scene, text.replace("= 480", "= 900")).expect("a longer one");
    let fly = |arguments: &[&str]| digest(&scene, arguments);
    let line = |frame: u64, action: &str, more: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"tower 1\",\"person\":\"eve\",\"action\":\"{action}\"{more}}}\n"
        )
    };
    // Call signs of generated flights are their numbers.
    let mut text = line(20, "take", "");
    for frame in (1000..18_000).step_by(200) {
        text += &line(frame, "here", "");
        for n in 1..=8 {
            for (letter, clearance) in [('A', "LND"), ('D', "LUP")] {
                let more =
                    format!(",\"callsign\":\"G{letter}{n:04}\",\"clearance\":\"{clearance}\"");
                text += &line(frame + 10 * n, "say", &more);
            }
        }
    }
    let inputs = folder.file("tower.jsonl");
    std::fs::write(&inputs, text).expect("inputs");
    let (record, report) = (folder.file("tower.pcapng"), folder.file("report"));
    let reference = fly(&["--record", &record, "--report", &report, "--inputs", &inputs]);
    let sqlite = folder.file("tower.sqlite");
    let log = rusqlite::Connection::open(&sqlite).expect("a database");
    for kind in ["CATC_LND_LUP", "RMCA_ARR"] {
        let mut rows = log
            .prepare(
                "SELECT r.subjects, r.time_ns, (SELECT min(a.time_ns) FROM alerts a WHERE a.kind = r.kind AND a.subjects = r.subjects) \
                 FROM reference_alerts r WHERE r.kind = ? GROUP BY r.id",
            )
            .expect("tables");
        let row = |row: &rusqlite::Row<'_>| {
            Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?, row.get::<_, Option<i64>>(2)?))
        };
        let rows = rows.query_map([kind], row).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let rows = rows.expect("rows");
        assert!(!rows.is_empty(), "{kind}");
        for (subjects, truth_ns, tracks_ns) in rows {
            let said = |word: &str| {
                let said = "SELECT count(*) FROM inputs WHERE refused = '' AND clearance = ? AND instr(?, callsign) > 0";
                log.query_row(said, (word, &subjects), |r| r.get::<_, i64>(0)).expect("inputs")
            };
            assert!(said("LND") == 1 && said("LUP") == 1, "{kind} {subjects}");
            let late_s = tracks_ns.map(|ns| (ns - truth_ns) as f64 * 1e-9);
            assert!(late_s.is_some_and(|s| s.abs() <= 3.0), "{kind} {subjects}: {late_s:?} s");
        }
    }
    // The report says what she did and what followed, on tracks and on truth.
    let read = |name: &str| std::fs::read_to_string(format!("{report}/{name}")).expect("a report");
    let alerts = read("people_alerts.csv");
    for followed in [",LUP,tracks,RMCA_ARR,alarm,", ",LUP,truth,RMCA_ARR,alarm,"] {
        let row = |line: &&str| line.contains(",tower 1,eve,GD") && line.contains(followed);
        assert!(alerts.lines().any(|line| row(&line)), "{followed}: {alerts}");
    }
    assert!(read("people_orders.csv").lines().count() > 100, "each order");
    assert!(read("people_seats.csv").contains("tower 1,eve,20,1.0,"));
    let page = read("report.html");
    assert!(page.contains("<h2>People at seats</h2>") && page.contains("<td>RMCA_ARR</td>"));
    the_score_of_exported_alerts_is_that_of_the_run(&folder, &log, &sqlite, &read("alerts.csv"));
    let around =
        "SELECT count(*) FROM remarks WHERE text LIKE '%goes around: GD% is on the runway'";
    assert!(count(&log, around) >= 1);
    assert_eq!(count(&log, "SELECT count(*) FROM remarks WHERE text LIKE '% touch'"), 0);
    for arguments in [
        &["--in-process", "--inputs", &inputs][..],
        &["--generators", "2", "--inputs", &inputs],
        &["--in-process", "--inputs", &sqlite],
    ] {
        assert_eq!(fly(arguments), reference, "{arguments:?}");
    }
}

#[test]
fn inputs_that_cannot_be_read_are_refused_before_anything_is_started() {
    let folder = Folder::new("seats-inputs");
    let path = folder.file("inputs.jsonl");
    for (action, why) in [
        ("\"fly\"", "there is no action \"fly\""),
        (
            "\"say\",\"callsign\":\"GD1\",\"clearance\":\"FLY\"",
            "there is no clearance \"FLY\": BTR, CRO",
        ),
    ] {
        let line =
            format!("{{\"frame\":1,\"seat\":\"ground\",\"person\":\"a\",\"action\":{action}}}\n");
        std::fs::write(&path, line).expect("written");
        let output = finish(run(&Ports::new(), &["--fast", "--no-viewer", "--inputs", &path]));
        let said = common::stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(&format!("inputs.jsonl:1: {why}")), "{said}");
    }
}

/// Departures that would queue are advised to be held, the models mostly follow it and a person at the apron decides himself: one
/// digest in every layout and from the log, every advice in the table `advice`, and nobody pushed whom an accepted advice holds.
#[test]
fn advice_is_given_decided_upon_and_followed_to_one_digest_in_every_layout() {
    let folder = Folder::new("seats-advice");
    let scene = scene(&folder, "advice", "sees = \"truth\"\nadvice = true");
    let text = std::fs::read_to_string(&scene).expect("the scene");
    // Somebody has to be seen to wait before anybody is held: a busier one, and longer.
    let text = text.replace("LZIB.apt.dat", "EGCC.nodes.csv").replace("_s = 480", "_s = 1800");
    std::fs::write(&scene, text.replace("departures_per_h = 30", "departures_per_h = 60"))
        .expect("a scene");
    let fly = |arguments: &[&str]| digest(&scene, arguments);
    let record = folder.file("advice.pcapng");
    let by_models = fly(&["--record", &record]);
    for arguments in [&["--in-process"][..], &["--generators", "2"]] {
        assert_eq!(fly(arguments), by_models, "{arguments:?}");
    }
    let log = rusqlite::Connection::open(folder.file("advice.sqlite")).expect("a database");
    let given = count(
        &log,
        "SELECT count(*) FROM advice WHERE change = 'given' AND kind = 'HOLD_STAND' AND value >= 60",
    );
    assert!(given >= 2, "{given}");
    let decided = count(
        &log,
        "SELECT count(*) FROM advice WHERE change = 'decided' AND decided_by = 'model'",
    );
    assert_eq!(decided, given, "each once");
    // Whom an accepted advice holds is not cleared before it is over.
    let early = "SELECT count(*) FROM advice a JOIN clearances c ON c.kind = 'PSH' AND instr(a.subjects || ' ', c.callsign || ' ') = 1 \
         WHERE a.change = 'decided' AND a.decision = 'accepted' AND c.time_ns > a.time_ns AND c.time_ns < \
         (SELECT min(e.time_ns) FROM advice e WHERE e.id = a.id AND e.change = 'ended')";
    assert_eq!(count(&log, early), 0);
    // Without the word in the scene nobody is advised, and it is another run.
    let plain = folder.file("plain.toml");
    let text = std::fs::read_to_string(&scene).expect("the scene");
    std::fs::write(&plain, text.replace("advice = true", "")).expect("a scene");
    assert_ne!(digest(&plain, &["--in-process"]), by_models);

    // A person at the apron: nobody decides for her.
    let line = |frame: u64, action: &str, more: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"apron\",\"person\":\"anna\",\"action\":\"{action}\"{more}}}\n"
        )
    };
    let there: String = (21..36).map(|n| line(1000 * n, "here", "")).collect();
    let sits = folder.file("sits.jsonl");
    std::fs::write(&sits, line(20_100, "take", "") + &there).expect("inputs");
    fly(&["--record", &folder.file("sits.pcapng"), "--inputs", &sits]);
    let log = rusqlite::Connection::open(folder.file("sits.sqlite")).expect("a database");
    assert_eq!(count(&log, "SELECT count(*) FROM advice WHERE change = 'decided'"), 0);
    let mut rows = log
        .prepare("SELECT subjects, frame FROM advice WHERE change = 'given' AND kind = 'HOLD_STAND' ORDER BY id LIMIT 2")
        .expect("a table");
    let rows =
        rows.query_map([], |row| Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)? as u64)));
    let open: Vec<(String, u64)> = rows.and_then(Iterator::collect).expect("rows");
    assert_eq!(open.len(), 2, "{open:?}");
    let of = |subjects: &str| subjects.split(' ').next().unwrap_or_default().to_owned();
    let decide = |n: usize, action: &str, kind: &str| {
        let more = format!(",\"callsign\":\"{}\",\"clearance\":\"{kind}\"", of(&open[n].0));
        line(open[n].1.max(open[0].1) + 21, action, &more)
    };
    let decides = folder.file("decides.jsonl");
    let words = [
        decide(0, "accept", "HOLD_STAND"),
        decide(1, "refuse", "HOLD_STAND"),
        decide(0, "accept", "GAP"),
        // Nobody is seen where control is told no tracks.
        decide(1, "what-if", "HOLD 120"),
    ];
    std::fs::write(&decides, line(20_100, "take", "") + &there + &words.concat()).expect("inputs");
    let record = folder.file("decides.pcapng");
    let reference = fly(&["--record", &record, "--inputs", &decides]);
    let log = folder.file("decides.sqlite");
    for arguments in
        [&["--in-process", "--inputs", &decides][..], &["--generators", "2", "--inputs", &log]]
    {
        assert_eq!(fly(arguments), reference, "{arguments:?}");
    }
    let log = rusqlite::Connection::open(log).expect("a database");
    for (n, decision) in [(0, "accepted"), (1, "refused")] {
        let query = format!(
            "SELECT count(*) FROM advice WHERE change = 'decided' AND decided_by = 'person' AND decision = '{decision}' \
             AND subjects LIKE '{} %'",
            of(&open[n].0)
        );
        assert_eq!(count(&log, &query), 1, "{decision}");
    }
    assert_eq!(count(&log, "SELECT count(*) FROM advice WHERE change = 'decided'"), 2);
    for (action, refused) in [
        ("accept", "%there is no advice that stands for it"),
        ("what-if", "nobody is seen in this scene%"),
    ] {
        let told = "SELECT count(*) FROM inputs WHERE action";
        let query = format!("{told} = '{action}' AND refused LIKE '{refused}'");
        assert!(count(&log, &query) >= 1, "{query}");
    }
}

/// What is asked of the look ahead is an input as any other, refused or not, and changes nothing: one digest in every layout,
/// however long the answers take.
#[test]
fn questions_what_would_be_if_change_nothing_and_give_one_digest_in_every_layout() {
    let folder = Folder::new("seats-what-if");
    let control = "sees = \"tracks\"\ncontrollers = \"model\"\nadvice = true";
    let scene = scene(&folder, "asked", control);
    let line = |frame: u64, action: &str, more: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"ground\",\"person\":\"anna\",\"action\":\"{action}\"{more}}}\n"
        )
    };
    let asks = |frame: u64, change: &str| {
        let more = format!(",\"callsign\":\"GD0003\",\"clearance\":\"{change}\"");
        line(frame, "what-if", &more)
    };
    let changes = ["HOLD 120", "HOLD 60", "HOLD 0", "STAND 1", "HOLD long", "RUNWAY 99"];
    let all = changes.iter().map(|change| asks(1200, change)).collect::<String>();
    // More than there are in a minute: refused by their number, never by a clock.
    let many = (0..14).map(|n| asks(4000, &format!("HOLD {n}"))).collect::<String>();
    let inputs = folder.file("asked.jsonl");
    let text = asks(10, "HOLD 9") + &line(20, "take", "") + &all + &many;
    std::fs::write(&inputs, text).expect("inputs");
    let record = folder.file("asked.pcapng");
    let reference = digest(&scene, &["--record", &record, "--inputs", &inputs]);
    let log = folder.file("asked.sqlite");
    for arguments in
        [&["--in-process", "--inputs", &inputs][..], &["--generators", "2", "--inputs", &log]]
    {
        assert_eq!(digest(&scene, arguments), reference, "{arguments:?}");
    }
    let log = rusqlite::Connection::open(log).expect("a database");
    let told = |refused: &str| {
        let query = "SELECT count(*) FROM inputs WHERE action = 'what-if' AND refused LIKE";
        count(&log, &format!("{query} '{refused}'"))
    };
    assert_eq!(told("ground is not yours%"), 1, "before she sat down");
    assert_eq!(told("") + told("% a minute are answered%"), 3 + 14, "what can be asked");
    assert!(told("") >= 12 && told("% a minute are answered%") >= 2, "{}", told(""));
    assert_eq!(told("HOLD \"long\": give seconds%"), 1);
    assert_eq!(told("there is no runway \"99\"") + told("there is no stand \"1\""), 2);
}

/// A car that is driven through the inputs of a file: forward, wheels to the right for a while, backwards, and a silence of its driver.
fn a_drive(folder: &Folder, name: &str, from: u64) -> String {
    let path = folder.file(name);
    let line = |frame: u64, action: &str, wish: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"driver FOLLOW1\",\"person\":\"anna\",\"action\":\"{action}\",\"clearance\":\"{wish}\"}}\n"
        )
    };
    let mut text = line(from, "take", "");
    for (k, wish) in (0..160).map(|k| match k {
        0..50 => (k, "300 0 0"),
        50..70 => (k, "100 0 350"),
        70..100 => (k, "400 0 0"),
        100..120 => (k, "0 1000 0"),
        _ => (k, "-600 0 -200"),
    }) {
        text += &line(from + 20 + 10 * k, "drive", wish);
    }
    // Nothing for ten seconds, and a last word.
    text += &line(from + 1820, "drive", "200 0 0");
    text += &line(from + 1900, "leave", "");
    std::fs::write(&path, text).expect("inputs");
    path
}

/// A person drives a car among flights: equal inputs give equal runs in every layout, and so do those that the log kept; the log has
/// each with its frame, and flies the traffic again with them.
#[test]
fn a_car_that_is_driven_gives_one_digest_in_every_layout_and_again_from_the_log() {
    let folder = Folder::new("seats-driven");
    for control in ["sees = \"none\"", "sees = \"tracks\"\ncontrollers = \"model\""] {
        let path = scene(&folder, "driven", control);
        let text = std::fs::read_to_string(&path)
            .expect("the scene")
            .replace("duration_s = 480", "duration_s = 120");
        let car = "[[traffic]]\nkind = \"driven\"\ncallsign = \"FOLLOW1\"\ntype = \"FOLLOWME\"\nstand = \"GA_Ramp_14\"\n[control]";
        std::fs::write(&path, text.replace("[control]", car)).expect("with a car");
        let fly = |arguments: &[&str]| {
            let ports = Ports::new();
            let all = [&[path.as_str(), "--fast", "--no-viewer"][..], arguments].concat();
            let output = finish(run(&ports, &all));
            assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", common::stderr(&output));
            summary(&output)["digest"].as_str().expect("a digest").to_owned()
        };
        let inputs = a_drive(&folder, "drive.jsonl", 200);
        let reference = fly(&["--in-process", "--inputs", &inputs]);
        assert_ne!(fly(&["--in-process"]), reference, "{control}: it was driven");
        let record = folder.file("driven.pcapng");
        for arguments in [&["--generators", "2"][..], &["--record", &record]] {
            let all = [arguments, &["--inputs", &inputs]].concat();
            assert_eq!(fly(&all), reference, "{control}: {arguments:?}");
        }
        let log = rusqlite::Connection::open(folder.file("driven.sqlite")).expect("a database");
        assert_eq!(count(&log, "SELECT count(*) FROM inputs"), 163, "{control}");
        assert_eq!(
            count(&log, "SELECT count(*) FROM run WHERE name = 'inputs_lost'"),
            0,
            "{control}"
        );
        let first = "SELECT frame FROM inputs WHERE action = 'drive' AND clearance = '300 0 0' ORDER BY frame LIMIT 1";
        assert_eq!(count(&log, first), 220, "{control}");
        // It stood until the first wish worked, drove, and stands again after its driver fell silent.
        let moved = |from: i64, to: i64| -> f64 {
            let query = "SELECT max(x_m) - min(x_m) + max(y_m) - min(y_m) FROM truth WHERE callsign = 'FOLLOW1' AND scan BETWEEN ? AND ?";
            log.query_row(query, (from, to), |row| row.get(0)).expect("seen")
        };
        assert!(
            moved(1, 11) < 0.01 && moved(12, 60) > 60.0,
            "{control}: {} {}",
            moved(1, 11),
            moved(12, 60)
        );
        assert!(moved(95, 100) < 0.3, "{control}: {}", moved(95, 100));
        let again = folder.file("driven.sqlite");
        assert_eq!(
            fly(&["--in-process", "--inputs", &again]),
            reference,
            "{control}: from the log"
        );
        // A frame later it is another run.
        let late = a_drive(&folder, "late.jsonl", 201);
        assert_ne!(
            fly(&["--in-process", "--inputs", &late]),
            reference,
            "{control}: a frame later"
        );
    }
}

/// A person takes a flight while it taxies, slows it down with the wheels straight, and gives it back: equal inputs give equal runs, and so do
/// those that the log kept; the log flies the traffic again with them.
#[test]
fn a_flight_that_a_person_taxies_gives_one_digest_in_every_layout_and_again_from_the_log() {
    let folder = Folder::new("seats-pilot");
    let path = scene(&folder, "pilot", "by_hand = true");
    let fly = |arguments: &[&str]| digest(&path, arguments);
    let record = folder.file("before.pcapng");
    let untouched = fly(&["--record", &record]);
    let log = rusqlite::Connection::open(folder.file("before.sqlite")).expect("a database");
    // Who taxies ten seconds after he was cleared to, and for long.
    let query = "SELECT callsign, time_ns / 1000000000 + 12 FROM clearances WHERE kind = 'TAX' AND time_ns > 20000000000 AND \
         (until_ns IS NULL OR until_ns - time_ns > 60000000000) ORDER BY time_ns LIMIT 1";
    let (callsign, at_s): (String, i64) =
        log.query_row(query, [], |row| Ok((row.get(0)?, row.get(1)?))).expect("one who taxies");
    let inputs = folder.file("pilot.jsonl");
    let line = |frame: i64, action: &str, wish: &str| {
        format!(
            "{{\"frame\":{frame},\"seat\":\"pilot {callsign}\",\"person\":\"anna\",\"action\":\"{action}\",\"clearance\":\"{wish}\"}}\n"
        )
    };
    let mut text = line(20 * at_s, "take", "");
    for k in 1..=30 {
        text += &line(20 * at_s + 10 * k, "drive", "0 300 0");
    }
    text += &line(20 * at_s + 310, "leave", "");
    std::fs::write(&inputs, text).expect("inputs");
    let reference = fly(&["--in-process", "--inputs", &inputs]);
    assert_ne!(reference, untouched, "{callsign} at {at_s} s: it stood");
    let record = folder.file("flown.pcapng");
    assert_eq!(fly(&["--generators", "2", "--inputs", &inputs]), reference);
    assert_eq!(fly(&["--record", &record, "--inputs", &inputs]), reference);
    let log = rusqlite::Connection::open(folder.file("flown.sqlite")).expect("a database");
    let back = format!("SELECT count(*) FROM remarks WHERE text = '{callsign} goes on by itself'");
    assert_eq!(count(&log, &back), 1, "{callsign}");
    let again = folder.file("flown.sqlite");
    assert_eq!(fly(&["--in-process", "--inputs", &again]), reference, "from the log");
}
