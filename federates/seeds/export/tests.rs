//! Tests of exports.

use super::*;

/// The database, its recording, and a link to one of them were written over.
#[test]
fn nothing_is_exported_over_the_run_itself() {
    let folder = std::env::temp_dir().join(format!("seeds-export-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    let at = |name: &str| folder.join(name);
    for name in ["x.sqlite", "x.pcapng", "other.csv"] {
        std::fs::write(at(name), name).expect("written");
    }
    std::os::unix::fs::symlink(at("x.sqlite"), at("link.csv")).expect("linked");
    for run in ["x.sqlite", "x.pcapng"] {
        for out in ["x.sqlite", "x.pcapng", "link.csv"] {
            assert!(not_of_the_run(&at(out), &at(run)).is_err(), "{run} to {out}");
        }
        for out in ["other.csv", "new.csv"] {
            assert!(not_of_the_run(&at(out), &at(run)).is_ok(), "{run} to {out}");
        }
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// The run of a few tables, at a place on earth.
fn empty_run() -> Run {
    Run {
        database: Connection::open_in_memory().expect("opened"),
        facts: BTreeMap::new(),
        map: AirportMap::default(),
        frame: LocalFrame::at(Geodetic::from_degrees(47.0, 8.0, 400.0)),
        start_utc_ns: 0,
    }
}

#[test]
fn an_exported_table_is_scored_as_it_is() {
    use studies::score_files;
    let run = empty_run();
    let report = |s: i64, status: &str| Report {
        time_ns: s * 1_000_000_000,
        place_deg: run.place([10.0 * s as f64, 3.0]),
        altitude_m: None,
        height_m: None,
        position_m: [10.0 * s as f64, 3.0],
        velocity_mps: Some([10.0, 0.0]),
        status: status.to_owned(),
    };
    let thing = |what, id: &str, name: &str, status| Thing {
        what,
        id: id.to_owned(),
        name: name.to_owned(),
        kind: "A320".to_owned(),
        movement: "arrival".to_owned(),
        reports: (0..20).map(|s| report(s, status)).collect(),
    };
    let things = [
        thing(What::Tracks, "7", "SWR1, \"A\"", "confirmed"),
        thing(What::Tracks, "8", "", "tentative"),
        thing(What::Truth, "1:1:1", "SWR1, \"A\"", ""),
        thing(What::Truth, "1:1:2", "", ""),
        thing(What::Truth, "1:1:3", "", ""),
    ];
    let text = csv(&run, &things);
    let tracks = score_files::tracks(&text, None).expect("tracks");
    assert_eq!(tracks.len(), 20);
    assert!(tracks.iter().all(|r| (r.track, r.label.as_str()) == (7, "SWR1, \"A\"")));
    assert_eq!(score_files::truth(&text, None).expect("truth").len(), 3);
    // By its degrees it is the same to a centimetre.
    let place = |lat: f64, lon: f64| {
        let at = run.frame.to_enu(Geodetic::from_degrees(lat, lon, 400.0).to_ecef());
        models::frames::Point2::new(at.east_m, at.north_m)
    };
    let placed = score_files::tracks(&text, Some(&place)).expect("tracks");
    let off = tracks.iter().zip(&placed).map(|(a, b)| (a.position_m - b.position_m).norm());
    assert!(off.fold(0.0, f64::max) < 0.011);
}

/// Own scenes had the height 0, and those that ship what the folder said of their name.
#[test]
fn degrees_are_those_of_the_airport_of_the_run() {
    use crate::viewer_logger::log::Log;
    use crate::viewer_logger::picture::RunInfo;
    let folder = std::env::temp_dir().join(format!("seeds-height-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("a scene");
    let reference = scene.airport.reference;
    assert!(reference.height_m > 400.0);
    let of = |name: &str, held: bool, digest: &str| {
        let file = folder.join(format!("{name}.sqlite"));
        let info = RunInfo {
            scene: name.to_owned(),
            scene_digest: digest.to_owned(),
            ..RunInfo::of(&scene, 1)
        };
        let mut log = Log::replace(&file, &info, &AirportMap::of(&scene)).expect("a log");
        if held {
            kept_scene::keep(&mut log, &scene);
        }
        log.close().expect("closed");
        Run::open(&file).expect("opened").frame.origin_geodetic().height_m
    };
    let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
    assert!(near(of("my-own-scene", true, ""), reference.height_m));
    assert!(near(of("zurich", false, ""), reference.height_m));
    assert!(near(of("zurich", false, "00000000000000ff"), 0.0), "another scene of this name");
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// Who is 10 km high and 30 km off is 47 m away from where the plane below is met, and 70 m higher than that plane.
#[test]
fn who_flies_is_where_it_is_over_the_ellipsoid() {
    let run = empty_run();
    run.database
        .execute_batch(
            "CREATE TABLE scans (scan INTEGER, time_ns INTEGER);
             CREATE TABLE flights (callsign TEXT, movement TEXT);
             CREATE TABLE truth (scan INTEGER, entity INTEGER, dis_id TEXT, callsign TEXT, type TEXT, x_m REAL, y_m REAL,
             altitude_m REAL, vx_ms REAL, vy_ms REAL);
             INSERT INTO scans VALUES (1, 0); INSERT INTO truth VALUES (1, 1, '1:1:1', 'A', 'A320', 30000, 0, 10000, 0, 0);",
        )
        .expect("tables");
    let things = run.things(&[What::Truth]).expect("truth");
    let report = &things[0].reports[0];
    let [lon, lat] = report.place_deg;
    let height_m = report.height_m.expect("a height");
    let back = run.frame.to_enu(Geodetic::from_degrees(lat, lon, height_m).to_ecef());
    let off = libm::hypot(back.east_m - 30_000.0, back.north_m);
    assert!(off < 1e-3 && (back.up_m - 10_000.0).abs() < 1e-3, "{back:?}");
    assert!((height_m - 10_470.0).abs() < 1.0, "{height_m}");
    let text: Value = serde_json::from_str(&geojson(&run, &things, &[])).expect("JSON");
    assert_eq!(text["features"][0]["geometry"]["coordinates"][2], digits(height_m, 3));
}

#[test]
fn a_line_over_180_degrees_is_two_and_labels_are_where_their_points_are() {
    let report = |s: i64, lon: f64| Report {
        time_ns: s * 1_000_000_000,
        place_deg: [lon, -17.0 - 0.1 * s as f64],
        altitude_m: Some(0.0),
        height_m: Some(10.0 * s as f64),
        position_m: [0.0; 2],
        velocity_mps: None,
        status: String::new(),
    };
    for way in [1.0, -1.0] {
        let thing = Thing {
            what: What::Tracks,
            id: "7".to_owned(),
            name: String::new(),
            kind: String::new(),
            movement: String::new(),
            reports: [179.7, 179.9, -179.9, -179.7]
                .iter()
                .zip(0..)
                .map(|(lon, s)| report(s, way * lon))
                .collect(),
        };
        let things = [thing];
        let run = empty_run();
        let text: Value = serde_json::from_str(&geojson(&run, &things, &[])).expect("JSON");
        let feature = &text["features"][0];
        assert_eq!(feature["geometry"]["type"], "MultiLineString");
        let crossing = [180.0 * way, -17.15, 15.0];
        let lines = feature["geometry"]["coordinates"].as_array().expect("lines");
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0][2], json!(crossing));
        assert_eq!(lines[1][0], json!([-crossing[0], crossing[1], crossing[2]]));
        for (line, times) in
            lines.iter().zip(feature["properties"]["times"].as_array().expect("times"))
        {
            let line = line.as_array().expect("points");
            assert_eq!((line.len(), times.as_array().expect("each").len()), (3, 3));
            let lons: Vec<f64> = line.iter().map(|p| p[0].as_f64().expect("degrees")).collect();
            assert!(lons.windows(2).all(|w| (w[1] - w[0]).abs() < 1.0), "{lons:?}");
        }
        let packets: Value = serde_json::from_str(&czml(&run, &things, &[])).expect("JSON");
        let packet = &packets[1];
        assert_eq!(packet["label"]["heightReference"], packet["point"]["heightReference"]);
    }
}
