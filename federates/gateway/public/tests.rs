//! The committed schema is today's, and every message follows it.

use super::*;
use crate::gateway::board::{Board, KEYS};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{
    FederateStatus, FlightNotice, LagMessage, Operation, PlotMessage, RunState, ScanReport,
    TrackMessage, TruthMessage, WeatherNotice,
};
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::{Point2, Point3};
use models::plot::SensorKind;
use models::track::{TrackStatus, TrackType};
use scenarios::Scene;
use std::sync::Arc;

fn scene() -> Scene {
    scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene")
}

/// Whether a value follows a schema of the kind that is made here; the first breach otherwise.
pub(crate) fn follows(
    value: &Value,
    schema: &Value,
    all: &Value,
    place: &str,
) -> Result<(), String> {
    let breach = |what: &str| Err(format!("{place}: {what}: {value}"));
    if let Some(name) = schema["$ref"].as_str() {
        let target = all.pointer(name.trim_start_matches('#')).expect("a definition");
        return follows(value, target, all, place);
    }
    if let Some(wanted) = schema.get("const")
        && wanted != value
    {
        return breach("another constant");
    }
    match schema["type"].as_str() {
        Some("string") if !value.is_string() => breach("no text"),
        Some("boolean") if !value.is_boolean() => breach("no truth value"),
        Some("number") if !value.is_number() => breach("no number"),
        Some("integer") if !(value.is_i64() || value.is_u64()) => breach("no whole number"),
        Some("integer") if schema["minimum"] == 0 && !value.is_u64() => breach("negative"),
        Some("array") => {
            let Some(list) = value.as_array() else { return breach("no list") };
            list.iter().try_for_each(|item| follows(item, &schema["items"], all, place))
        }
        Some("object") => {
            let Some(fields) = value.as_object() else { return breach("no object") };
            for name in schema["required"].as_array().into_iter().flatten() {
                if !fields.contains_key(name.as_str().expect("a name")) {
                    return breach(&format!("{name} is missing"));
                }
            }
            fields.iter().try_for_each(|(name, field)| {
                let own = schema["properties"].get(name).unwrap_or(&schema["additionalProperties"]);
                if own.is_null() {
                    return Err(format!("{place}.{name}: not in the schema"));
                }
                follows(field, own, all, &format!("{place}.{name}"))
            })
        }
        _ => Ok(()),
    }
}

fn scan(time_ns: i64) -> ScanReport {
    let track = TrackMessage {
        number: 7,
        track_type: TrackType::Aircraft,
        status: TrackStatus::Confirmed,
        first: false,
        time_ns,
        position_m: Point2::new(1200.25, -400.5),
        velocity_mps: [3.0, -4.0],
        cov_m2: [4.0, -1.0, 9.0],
        acceleration_ms2: [0.0; 2],
        velocity_cov_m2s2: [1.0, 0.0, 1.0],
        altitude_m: Some(83.82),
        altitude_ns: Some(time_ns - 250_000_000),
        heading_rad: -0.5,
        manoeuvre: true,
        callsign: String::new(),
        type_designator: String::new(),
        wake: None,
        movement: None,
        runway_stand: String::new(),
        ctd_eta_ns: None,
        routing: Vec::new(),
        assumed: "SWR1".into(),
        label_p: Some(0.7),
        address: None,
        existence_p: None,
        unresolved: false,
        lag: Some(LagMessage {
            time_ns: time_ns - 1_000_000_000,
            position_m: Point2::new(1197.5, -396.25),
            cov_m2: [2.0, -0.5, 3.0],
            coasted: false,
            error_m: None,
        }),
    };
    let plot = PlotMessage {
        sensor: 1,
        kind: SensorKind::Asde,
        time_ns: time_ns - 100,
        position_m: Point2::new(1203.0, -404.0),
        cov_m2: [4.0, 0.0, 4.0],
        ellipse: [1.0, 0.0, 4.0, 4.0],
        altitude_m: None,
        velocity_mps: None,
        polar: Some([1260.0, -0.1, 2.0, 0.001]),
        scnr_db: Some(f64::INFINITY),
        identity: String::new(),
        address: None,
        cause: "SWR1".into(),
        truth_m: Some(Point2::new(1200.0, -400.0)),
        sequence: 3,
        track: Some(7),
        effects: Vec::new(),
    };
    let truth = TruthMessage {
        id: [417, 1, 2],
        callsign: "SWR1".into(),
        address: None,
        type_designator: "A320".into(),
        aircraft: true,
        size_m: [37.6, 34.1],
        position_m: Point3::new(1200.0, -400.0, 0.0),
        velocity_mps: [3.0, -4.0, 0.0],
        heading_rad: 2.5,
        ours: true,
        track: Some((7, 0.56)),
    };
    ScanReport {
        run: 2,
        scan: 231,
        time_ns,
        tracks: vec![track],
        plots: vec![plot],
        truth: vec![truth],
        measures: vec![("rmse_m".into(), 1.5), ("undefined".into(), f64::NAN)],
        ..ScanReport::default()
    }
}

fn board() -> Board {
    let board = Board::new(&scene(), 1, true);
    board.on_scan(&Arc::new(scan(231_000_000_000)));
    board.on_state(RunState {
        scene: "zurich".into(),
        run: 2,
        phase: Phase::Running,
        frame: 4625,
        step_ns: 50_000_000,
        rate: f64::INFINITY,
        members: vec![crate::runtime::messages::MemberState::default()],
        ..RunState::default()
    });
    board.on_flights(vec![FlightNotice {
        callsign: "SWR1".into(),
        address: Some(0x4b_0001),
        type_designator: "A320".into(),
        wake: Some(WakeCategory::Medium),
        movement: MovementKind::Arrival,
        runway: "28".into(),
        stand: "E19".into(),
        stand_m: None,
        eta_ctd_ns: 1_500_000_000,
        off_block_ns: None,
        routing: vec!["E".into()],
    }]);
    board.on_weather(WeatherNotice {
        from_ns: 0,
        rain_mm_per_h: 4.0,
        visibility_m: f64::INFINITY,
        temperature_k: 283.15,
        pressure_hpa: 960.0,
        vapour_g_per_m3: 7.0,
        wind_mps: [1.0, -2.0],
        film_mm: 0.1,
        cells: vec![[0.0, 1.0, 2.0, 3.0]],
    });
    board.on_operation(Operation { source: "client:me".into(), ok: true, ..Operation::default() });
    board.on_federate(FederateStatus {
        name: "smdfm".into(),
        dropped: vec![("old".into(), 3)],
        ..FederateStatus::default()
    });
    board
}

#[test]
fn every_message_follows_the_schema_and_no_value_is_null() {
    let (board, schema) = (board(), schema());
    for key in KEYS.iter().copied().chain(["federate/smdfm"]) {
        let value = board.value(key).expect(key);
        let name = key.split('/').next().expect("a name");
        follows(&value, &schema["$defs"][name], &schema, key).expect(key);
        assert!(!value.to_string().contains("null"), "{value}");
    }
    let (answer, _) = crate::gateway::commands::carry_out(
        br#"{"command":"status"}"#,
        &crate::gateway::commands::Rights::ReadOnly(String::new()),
    );
    let answer = crate::gateway::commands::answer(&answer, board.value("state"));
    follows(&answer, &schema["$defs"]["answer"], &schema, "answer").expect("an answer");
    // The judge itself: a key that is not there, and a value of another kind, are noticed.
    let mut state = board.value("state").expect("state");
    state["frame"] = json!("many");
    assert!(follows(&state, &schema["$defs"]["state"], &schema, "").is_err());
    state["frame"] = json!(1);
    state["new"] = json!(1);
    assert!(follows(&state, &schema["$defs"]["state"], &schema, "").is_err());
    for key in ["nothing", "federate/nobody", "federate/", ""] {
        assert_eq!(board.value(key), None, "{key}");
    }
}

#[test]
fn values_are_those_of_the_scan() {
    let board = board();
    let scan = board.value("scan").expect("a scan");
    assert_eq!(scan["schema"], "seeds.scan/1");
    assert_eq!(
        (&scan["run"], &scan["scan"], &scan["time_s"]),
        (&json!(2), &json!(231), &json!(231.0))
    );
    assert_eq!(scan["utc"], "2019-11-24T09:03:51.000Z");
    let track = &scan["tracks"][0];
    assert_eq!(
        (&track["speed_ms"], &track["entity"], &track["error_m"]),
        (&json!(5.0), &json!("SWR1"), &json!(0.56))
    );
    assert!((track["heading_deg"].as_f64().expect("a heading") - 331.352_1).abs() < 1e-3);
    assert_eq!((&track["altitude_m"], &track["altitude_age_s"]), (&json!(83.82), &json!(0.25)));
    let lag = json!({
        "time_ns": 230_000_000_000_i64, "x_m": 1197.5, "y_m": -396.25,
        "var_ee_m2": 2.0, "var_en_m2": -0.5, "var_nn_m2": 3.0, "coasted": false,
    });
    assert_eq!(track["lag"], lag, "the publication before, revised");
    assert_eq!(scan["plots"][0]["error_m"], json!(5.0));
    assert_eq!(scan["plots"][0].get("scnr_db"), None, "infinite");
    assert_eq!(scan["measures"], json!({"rmse_m": 1.5}));
    let truth = &board.value("truth").expect("truth")["truth"][0];
    let frame = scene().airport.frame;
    let place = geodesy::Geodetic::from_degrees(
        truth["lat_deg"].as_f64().expect("a latitude"),
        truth["lon_deg"].as_f64().expect("a longitude"),
        frame.origin_geodetic().height_m,
    );
    let there = frame.to_enu(place.to_ecef());
    assert!((there.east_m - 1200.0).abs() < 1e-3 && (there.north_m + 400.0).abs() < 1e-3);
    assert_eq!(board.value("state").expect("state").get("rate"), None, "as fast as possible");
    assert_eq!(board.value("weather").expect("weather").get("visibility_m"), None, "clear");
    let map = board.value("tracks.geojson").expect("a map");
    assert_eq!(
        (&map["type"], map["features"].as_array().map(Vec::len)),
        (&json!("FeatureCollection"), Some(1))
    );
    assert_eq!(map["features"][0]["geometry"]["coordinates"][0], track["lon_deg"]);
}

#[test]
fn a_map_of_receivers_shows_the_targets() {
    let board = board();
    // The flight list came after the scan: only now has the target its address.
    board.on_scan(&Arc::new(scan(232_000_000_000)));
    let aircraft = board.value("aircraft.json").expect("targets");
    let [target] = &aircraft["aircraft"].as_array().expect("a list")[..] else { panic!("one") };
    assert_eq!(
        (
            &target["hex"],
            &target["type"],
            &target["flight"],
            &target["alt_baro"],
            &target["category"]
        ),
        (&json!("4b0001"), &json!("adsb_icao"), &json!("SWR1    "), &json!("ground"), &json!("A3"))
    );
    assert_eq!((&target["gs"], &target["track"]), (&json!(9.7), &json!(143.13)));
    assert!((target["lat"].as_f64().expect("a latitude") - 47.4).abs() < 0.1);
    let expected_s = 1_574_586_000.0 + 232.0;
    assert_eq!(aircraft["now"], json!(expected_s));
    assert_eq!(board.value("receiver.json").expect("a receiver")["refresh"], 1000);
    // What a real readsb wrote of such targets: the same keys with values of the same kind, but for what only an antenna knows.
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/vectors/mode_s/aircraft-readsb.json");
    let text = std::fs::read_to_string(path).expect("the example");
    let real: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let same = |ours: &serde_json::Value, theirs: &serde_json::Value| {
        std::mem::discriminant(ours) == std::mem::discriminant(theirs)
    };
    for key in ["now", "messages", "aircraft"] {
        assert!(same(&aircraft[key], &real[key]), "{key}");
    }
    let antenna = ["r_dst", "r_dir", "nac_v", "sda"];
    for theirs in real["aircraft"].as_array().expect("a list") {
        for (key, value) in theirs.as_object().expect("an object") {
            let ours = match &key[..] {
                // One or the other, by whether it moves.
                "track" | "true_heading" => &target["track"],
                key => &target[key],
            };
            assert!(antenna.contains(&&key[..]) || same(ours, value), "{key}: {ours}, {value}");
        }
    }
}

#[test]
fn the_committed_schema_is_todays() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/schema/seeds-v1.json");
    let today = format!("{}\n", serde_json::to_string_pretty(&schema()).expect("JSON"));
    if std::env::var_os("SEEDS_WRITE_SCHEMA").is_some() {
        std::fs::write(path, &today).expect("written");
    }
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert_eq!(
        committed, today,
        "the public messages changed: within /1 keys are only added; SEEDS_WRITE_SCHEMA=1 writes the file anew"
    );
}
