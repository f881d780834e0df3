//! What goes out of a scan that is made by hand.

use super::*;
use crate::runtime::messages::PlotMessage;
use asterix::{Record, blocks, cat011, cat062};
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::Point2;
use models::track::TrackType;

pub(super) fn scene() -> Scene {
    scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene")
}

pub(super) fn track(number: u16, time_ns: i64) -> TrackMessage {
    TrackMessage {
        number,
        track_type: TrackType::Aircraft,
        status: TrackStatus::Confirmed,
        first: false,
        time_ns,
        position_m: Point2::new(1200.25, -3400.5),
        velocity_mps: [10.0, -3.25],
        cov_m2: [4.0, -1.0, 9.0],
        acceleration_ms2: [0.5, 0.0],
        velocity_cov_m2s2: [1.0, 0.0, 0.25],
        altitude_m: Some(120.0),
        altitude_ns: None,
        heading_rad: 0.5,
        manoeuvre: false,
        callsign: "swr_137h".into(),
        type_designator: "A320".into(),
        wake: Some(WakeCategory::Medium),
        movement: Some(MovementKind::Arrival),
        runway_stand: "28/E_19".into(),
        ctd_eta_ns: Some(time_ns + 4_000_000_000),
        routing: Vec::new(),
        assumed: String::new(),
        label_p: None,
        address: None,
        existence_p: None,
        unresolved: false,
        lag: None,
    }
}

pub(super) fn plot(sensor: u16, time_ns: i64) -> PlotMessage {
    PlotMessage {
        sensor,
        kind: SensorKind::Asde,
        time_ns,
        position_m: Point2::new(1200.0, -3400.0),
        cov_m2: [4.0, 0.0, 4.0],
        ellipse: [1.0, 0.0, 4.0, 4.0],
        altitude_m: None,
        velocity_mps: None,
        polar: Some([3605.0, 2.8, 2.0, 0.001]),
        scnr_db: Some(20.0),
        identity: String::new(),
        address: None,
        cause: "SWR137H".into(),
        truth_m: Some(Point2::new(1201.0, -3401.0)),
        sequence: 0,
        track: Some(7),
        effects: Vec::new(),
    }
}

pub(super) fn report(scan: u64, tracks: Vec<TrackMessage>, plots: Vec<PlotMessage>) -> ScanReport {
    let time_ns = scan as i64 * 1_000_000_000;
    ScanReport { run: 1, scan, time_ns, tracks, plots, ..ScanReport::default() }
}

/// Every record with its category, read while the datagrams live.
pub(super) fn read<T>(datagrams: &[Vec<u8>], get: impl Fn(&Record<'_>) -> Option<T>) -> Vec<T> {
    let blocks = datagrams.iter().flat_map(|d| blocks(d)).map(|b| b.expect("sound"));
    blocks.flat_map(|b| b.records()).filter_map(|r| get(&r.expect("sound"))).collect()
}

#[test]
fn the_time_of_day_goes_on_at_midnight() {
    let mut scene = scene();
    scene.run.start_utc_ns = 1_574_640_000_000_000_000 - 2_000_000_000; // 23:59:58
    let mut gateway = Gateway::new(&scene, Choice::default());
    let times: Vec<f64> = (1..=4)
        .flat_map(|scan| {
            let sent =
                gateway.on_scan(&report(scan, vec![track(7, scan as i64 * 1_000_000_000)], vec![]));
            read(&sent, |r| r.number(&cat062::I070))
        })
        .collect();
    assert_eq!(times, [86_399.0, 0.0, 1.0, 2.0]);
    // The landing of 4 s later is tomorrow before midnight, today after it.
    let days: Vec<Option<f64>> = [1, 3]
        .map(|scan| {
            let mut gateway = Gateway::new(&scene, Choice::default());
            let sent =
                gateway.on_scan(&report(scan, vec![track(7, scan as i64 * 1_000_000_000)], vec![]));
            let day = |r: &Record<'_>| {
                let label = r.get(&cat011::I390)?;
                label.sub(&cat011::I390_TOD)?.value("DAY")?.number()
            };
            read(&sent, day).first().copied()
        })
        .to_vec();
    assert_eq!(days, [Some(2.0), Some(0.0)]);
}

#[test]
fn a_track_says_what_its_message_says_and_nothing_of_the_truth() {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    let number = gateway.sources.iter().find(|s| s.kind == SensorKind::Asde).expect("a radar").sic;
    let scan = report(1, vec![track(7, 1_000_000_000)], vec![plot(number.into(), 750_000_000)]);
    let sent = gateway.on_scan(&scan);
    let text: Vec<String> = read(&sent, |r| Some(asterix::json::record(r).to_string()));
    let system = text.iter().find(|t| t.contains("\"080\"")).expect("a system track");
    for words in [
        r#""CS":"swr_137""#,
        r#""ID":"SWR137H""#,
        r#""RDS":"28""#,
        r#""AST":"E19""#,
        r#""MON":1"#,
        r#""PSR":0.25"#,
        r#""COV":-1.0"#,
        r#""ATV":{"X":1.0,"Y":0.5}"#,
        r#""210":{"AX":0.5,"AY":0.0}"#,
        r#""SFC":0"#,
    ] {
        assert!(system.contains(words), "{words} in {system}");
    }
    // The call sign of the cause is in no report of a sensor.
    let plots: Vec<&String> = text.iter().filter(|t| t.contains("\"131\"")).collect();
    assert_eq!(plots.len(), 1);
    assert!(!plots[0].contains("SWR137H") && plots[0].contains(r#""131":40"#), "{}", plots[0]);
    assert!(gateway.refused().is_empty(), "{:?}", gateway.refused());
}

#[test]
fn a_lost_scan_is_counted_and_a_restart_is_not_one() {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    for (run, scan) in [(1, 1), (1, 2), (1, 5), (2, 1), (2, 2)] {
        gateway.on_scan(&ScanReport { run, ..report(scan, vec![], vec![]) });
    }
    assert_eq!(gateway.scans_lost(), 2);
}

/// Who joins a run that goes on has lost nothing of what was before; whoever was started with it has.
#[test]
fn what_was_before_a_gateway_joined_is_not_lost() {
    for (from_begin, lost) in [(false, 2), (true, 41)] {
        let mut gateway = Gateway::new(&scene(), Choice::default()).from_begin(from_begin);
        for (run, scan) in [(3, 40), (3, 42), (4, 2)] {
            gateway.on_scan(&ScanReport { run, ..report(scan, vec![], vec![]) });
        }
        assert_eq!(gateway.scans_lost(), lost, "{from_begin}");
    }
}

/// An SMDFM that returned tells scans again that were sent.
#[test]
fn a_scan_that_comes_again_is_not_sent_again() {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    let mut sent = |run, scan: u64| {
        let report = report(scan, vec![track(7, scan as i64 * 1_000_000_000)], vec![]);
        read(&gateway.on_scan(&ScanReport { run, ..report }), |r| r.number(&cat062::I070)).len()
    };
    let scans = [(1, 1), (1, 2), (1, 3), (1, 2), (1, 3), (1, 4), (2, 1), (2, 1)];
    assert_eq!(scans.map(|(run, scan)| sent(run, scan)), [1, 1, 1, 0, 0, 1, 1, 0]);
    assert_eq!(gateway.scans_lost(), 0);
}

/// A sensor whose number is no SIC, for those above are the run's own: its plots are counted, not lost without a word.
#[test]
fn plots_of_a_sensor_without_a_sic_are_counted() {
    let mut scene = scene();
    let radar = scene.sensors.iter().position(|s| s.kind == SensorKind::Asde).expect("a radar");
    scene.sensors.push(scene.sensors[radar].clone());
    let last = scene.sensors.len() - 1;
    for (number, refused) in [(MOST_SENSORS, 0), (MOST_SENSORS + 1, 2), (300, 2)] {
        scene.sensors[last].id.0 = number;
        let mut gateway = Gateway::new(&scene, Choice::default());
        let plots = vec![plot(number, 250_000_000), plot(number, 500_000_000)];
        let sent = gateway.on_scan(&report(1, vec![], plots));
        let said = read(&sent, |r| r.number(&asterix::cat010::I131)).len() as u64;
        let counted = gateway.refused().get("sensor number above 199 has no SIC");
        assert_eq!((said, counted.copied().unwrap_or(0)), (2 - refused, refused), "{number}");
    }
}

#[test]
fn only_what_is_chosen_goes_out() {
    let number = |r: &Record<'_>| Some(r.category.number);
    let sensor = Gateway::new(&scene(), Choice::default()).sources[0].sic;
    for (choice, expected) in [
        (Choice { tracks: false, status: false, ..Choice::default() }, vec![10, 19, 20, 21, 247]),
        (Choice { sensors: false, status: false, ..Choice::default() }, vec![11, 62, 65, 247]),
        (Choice { categories: Some([62].into()), ..Choice::default() }, vec![62]),
    ] {
        let mut gateway = Gateway::new(&scene(), choice);
        let scan = report(1, vec![track(7, 1_000_000_000)], vec![plot(sensor.into(), 500_000_000)]);
        let found: BTreeSet<u8> = read(&gateway.on_scan(&scan), number).into_iter().collect();
        assert!(!found.is_empty() && found.iter().all(|n| expected.contains(n)), "{found:?}");
    }
}

#[test]
fn a_report_on_the_ground_says_its_speed_in_the_surface_ground_vector() {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    gateway.sources.push(Source { sic: 9, kind: SensorKind::Adsb });
    let kt = mode_s::KNOT_MPS;
    for (number, (velocity_mps, altitude_m, expected)) in (1..).zip([
        // 15 kt to the west; standing; in the air; unknown.
        (Some([-15.0 * kt, 0.0]), None, Some(vec![0.0, 1.0, 1.0, 0.0, 15.0, 270.0])),
        (Some([0.0, 0.0]), None, Some(vec![1.0, 0.0, 0.0, 0.0, 0.0])),
        (Some([-15.0 * kt, 0.0]), Some(300.0), None),
        (None, None, None),
    ]) {
        let plot = PlotMessage {
            kind: SensorKind::Adsb,
            velocity_mps,
            altitude_m,
            polar: None,
            scnr_db: None,
            ..plot(9, 500_000_000)
        };
        let sent = gateway.on_scan(&report(number, vec![], vec![plot]));
        let vector = |r: &Record<'_>| {
            let field = r.get(&asterix::cat021::RE)?;
            let values = field.subitems().flat_map(|s| s.values());
            Some(values.filter_map(|(_, v)| v.number()).collect::<Vec<f64>>())
        };
        assert_eq!(read(&sent, vector).pop(), expected, "{velocity_mps:?} {altitude_m:?}");
    }
    assert!(gateway.refused().is_empty(), "{:?}", gateway.refused());
}

/// Alerts as they change and in every cycle while they last, their end as end of conflict; the tracks in them are marked; stop bars in
/// banks of twelve, where one is lit or changed.
#[test]
fn alerts_and_stop_bars_go_out_while_they_last_and_once_when_they_end() {
    use asterix::cat004;
    use models::control::alert::{AlertKind, Change, Stage};
    let mut gateway = Gateway::new(&scene(), Choice::default());
    let alert = |number, id, change, stage, subjects: &str| AlertMessage {
        run: 1,
        time_ns: 0,
        change,
        id,
        kind: AlertKind::RunwayOpposite,
        stage,
        subjects: subjects.into(),
        since_ns: 0,
        asterix: AlertKind::RunwayOpposite.asterix(),
        place_m: Point2::new(120.5, -40.0),
        number,
    };
    let at = |scan: u64, numbers: &[u16]| {
        let named = |number: &u16| TrackMessage {
            callsign: format!("SWR{number}"),
            ..track(*number, scan as i64 * 1_000_000_000)
        };
        report(scan, numbers.iter().map(named).collect(), vec![])
    };
    // What is said of alerts: message, number, both tracks; and by track what it is marked with.
    type Said = (Vec<[Option<f64>; 4]>, Vec<(f64, [f64; 4], Vec<f64>)>);
    let said = |sent: &[Vec<u8>]| -> Said {
        let of_004 = |r: &Record<'_>| {
            let items = [&cat004::I000, &cat004::I040, &cat004::I030, &cat004::I035];
            (r.category.number == 4).then(|| items.map(|item| r.number(item)))
        };
        let marked = |r: &Record<'_>| {
            let all = r.get(&cat011::I605);
            let all = all.iter().flat_map(|v| v.values()).filter_map(|(_, v)| v.number());
            Some((r.number(&cat011::I161)?, r.numbers(&cat011::I600)?, all.collect()))
        };
        (read(sent, of_004), read(sent, marked))
    };
    assert_eq!(said(&gateway.on_scan(&at(1, &[7, 4100]))), (vec![], vec![]));
    let raised = alert(1, 300, Change::Raised, Stage::Information, "SWR4100 SWR7");
    gateway.on_alerts(vec![raised.clone()]);
    // Told again, as messages may be lost.
    gateway.on_alerts(vec![raised]);
    let both = [Some(11.0), Some(300.0), Some(4100.0), Some(7.0)];
    for scan in 2..=3 {
        let (alerts, marks) = said(&gateway.on_scan(&at(scan, &[7, 4100])));
        assert_eq!(alerts, [both], "{scan}");
        // A number of more than twelve bits is no member of 605; 300 is 44 in an octet.
        let mark = |track| (track, [1.0, 1.0, 11.0, 44.0], vec![7.0]);
        assert_eq!(marks, [mark(7.0), mark(4100.0)], "{scan}");
    }
    gateway.on_alerts(vec![
        alert(2, 300, Change::Changed, Stage::Alarm, "SWR4100 SWR7"),
        alert(3, 301, Change::Raised, Stage::Information, "7"),
        alert(4, 302, Change::Raised, Stage::Alarm, "strip 3"),
    ]);
    let (alerts, marks) = said(&gateway.on_scan(&at(4, &[7])));
    let alone = [Some(11.0), Some(301.0), Some(7.0), None];
    let gone = [Some(11.0), Some(300.0), None, Some(7.0)];
    assert_eq!(alerts, [gone, alone, [Some(11.0), Some(302.0), None, None]]);
    assert_eq!(marks, [(7.0, [1.0, 2.0, 11.0, 44.0], vec![7.0])], "the graver one");
    gateway.on_alerts(vec![
        alert(5, 300, Change::Ended, Stage::Alarm, "SWR4100 SWR7"),
        alert(6, 302, Change::Ended, Stage::Alarm, "strip 3"),
    ]);
    let (alerts, marks) = said(&gateway.on_scan(&at(5, &[7, 4100])));
    let ended = [Some(17.0), Some(300.0), Some(4100.0), Some(7.0)];
    assert_eq!(alerts, [ended, alone, [Some(17.0), Some(302.0), None, None]]);
    let last = (4100.0, [1.0, 0.0, 11.0, 44.0], vec![7.0]);
    assert_eq!(marks, [(7.0, [1.0, 1.0, 11.0, 45.0], vec![7.0]), last]);
    assert_eq!(said(&gateway.on_scan(&at(6, &[7]))).0, [alone]);
    // Another run knows nothing of them, and what is late of the first is of nobody.
    gateway
        .on_alerts(vec![AlertMessage { run: 2, ..alert(1, 1, Change::Ended, Stage::Alarm, "7") }]);
    gateway.on_alerts(vec![alert(9, 9, Change::Raised, Stage::Alarm, "7")]);
    assert_eq!(said(&gateway.on_scan(&at(7, &[7]))).0, [[Some(17.0), Some(1.0), Some(7.0), None]]);
    assert_eq!(said(&gateway.on_scan(&at(8, &[7]))).0.len(), 0);

    let banks = |sent: &[Vec<u8>]| -> Vec<Vec<f64>> {
        read(sent, |r| {
            let bars = r.get(&cat011::I610)?;
            assert_eq!(r.number(&cat011::I000), Some(7.0));
            Some(bars.values().filter_map(|(_, v)| v.number()).collect())
        })
    };
    let lights = |lit: &[usize]| {
        let bars: Vec<_> = (0..14).map(|i| serde_json::json!({"lit": lit.contains(&i)})).collect();
        serde_json::json!({"time_s": 1.0, "bars": bars}).to_string()
    };
    gateway.on_lights(&lights(&[0, 13]));
    for scan in 9..=10 {
        let sent = gateway.on_scan(&at(scan, &[]));
        // The first indicator is the highest bit; 0 is lit.
        assert_eq!(banks(&sent), [[0.0, f64::from(0x7ff), 1.0, f64::from(0xbff)]], "{scan}");
    }
    gateway.on_lights(&lights(&[]));
    let off = [[0.0, f64::from(0xfff), 1.0, f64::from(0xfff)]];
    assert_eq!(banks(&gateway.on_scan(&at(11, &[]))), off, "once");
    assert!(banks(&gateway.on_scan(&at(12, &[]))).is_empty(), "none is lit");
    gateway.on_lights("not JSON");
    assert!(gateway.refused().is_empty(), "{:?}", gateway.refused());
}

/// By call sign, else by address, of several the first, and only of the list that was told last.
#[test]
fn a_flight_is_found_by_its_call_sign_or_address() {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    let list = [
        flight("SWR1", Some(0x4b_1805), MovementKind::Arrival),
        flight("000ABC", None, MovementKind::Departure),
        flight("SWR2", Some(0xabc), MovementKind::Departure),
        flight("SWR1", Some(0x4b_1805), MovementKind::Departure),
        flight("", Some(0x1), MovementKind::Vehicle),
    ];
    gateway.on_flights(list.to_vec());
    let found = |gateway: &Gateway, identity: &str, address| {
        let plot = PlotMessage { identity: identity.into(), address, ..plot(1, 0) };
        gateway.flight_of(&plot).and_then(|f| list.iter().position(|known| known == f))
    };
    for (identity, address, place) in [
        ("SWR1", None, Some(0)),
        ("4B1805", Some(0x4b_1805), Some(0)),
        ("000ABC", None, Some(1)),
        ("000ABC", Some(0xabc), Some(2)),
        ("SWR2", Some(0x1), Some(2)),
        ("000001", Some(0x1), Some(4)),
        ("4B1805", None, None),
        ("4b1805", Some(0x4b_1805), None),
        ("", None, None),
        ("SWR3", Some(0xabc), None),
    ] {
        assert_eq!(found(&gateway, identity, address), place, "{identity} {address:?}");
    }
    gateway.on_flights(vec![list[2].clone()]);
    let later = ["SWR1", "SWR2", "000ABC"].map(|name| found(&gateway, name, None));
    assert_eq!(later, [None, Some(2), None]);
    assert_eq!(found(&gateway, "000ABC", Some(0xabc)), Some(2));
}

/// What stood when the operator restarted is not said of the next run, which may have no alert at all; nor what is late of it.
#[test]
fn alerts_of_a_run_end_with_it() {
    use models::control::alert::{AlertKind, Change, Stage};
    let mut gateway = Gateway::new(&scene(), Choice::default());
    let raised = AlertMessage {
        run: 1,
        time_ns: 0,
        change: Change::Raised,
        id: 1,
        kind: AlertKind::RunwayOpposite,
        stage: Stage::Alarm,
        subjects: "7".into(),
        since_ns: 0,
        asterix: AlertKind::RunwayOpposite.asterix(),
        place_m: Point2::new(0.0, 0.0),
        number: 1,
    };
    let mut said = |run, number, told: &[AlertMessage]| -> usize {
        gateway.on_alerts(told.to_vec());
        let scan = report(number, vec![track(7, number as i64 * 1_000_000_000)], vec![]);
        let sent = gateway.on_scan(&ScanReport { run, ..scan });
        read(&sent, |r| (r.category.number == 4).then_some(())).len()
            + read(&sent, |r| r.get(&cat011::I600).map(drop)).len()
    };
    let told = std::slice::from_ref(&raised);
    assert_eq!(said(1, 1, told), 2, "the alert, and the mark of its track");
    assert_eq!(said(1, 2, &[]), 2);
    assert_eq!(said(2, 1, &[]), 0, "another run");
    assert_eq!(said(2, 2, told), 0, "told again, late");
    assert_eq!(said(2, 3, &[AlertMessage { run: 2, ..raised.clone() }]), 2, "its own");
    // Who joins is told what was told of late, and begins with what stands of it.
    let of = |id, change| AlertMessage { id, change, ..raised.clone() };
    let told = [
        of(1, Change::Raised),
        of(2, Change::Raised),
        of(1, Change::Changed),
        of(2, Change::Ended),
        of(3, Change::Ended),
    ];
    let kept = alerts::still_standing(told.to_vec());
    assert_eq!(kept, [told[0].clone(), told[2].clone()]);
}

/// Squitters of what ADS-B sensors were told: with its error, gone on in a straight line, and nobody whom no sensor heard lately.
#[test]
fn squitters_of_reports_say_what_the_sensors_were_told() {
    use geodesy::Geodetic;
    use models::frames::Point3;
    let board = board::Board::new(&scene(), 1, true).sending(adsb::Origin::Reports);
    board.on_flights(vec![
        flight("SWR137H", Some(0x4b_1805), MovementKind::Arrival),
        flight("FIRE1", Some(0x4b_0002), MovementKind::Vehicle),
        flight("SWR9", Some(0x4b_0009), MovementKind::Departure),
    ]);
    let told = |identity: &str, time_ns, place: [f64; 2], velocity_mps, altitude_m| PlotMessage {
        kind: SensorKind::Adsb,
        identity: identity.into(),
        position_m: place.into(),
        velocity_mps: Some(velocity_mps),
        altitude_m,
        ..plot(9, time_ns)
    };
    let frame = scene().airport.frame;
    let shown = |scan: u64, plots: Vec<PlotMessage>| -> BTreeMap<String, serde_json::Value> {
        let mut report = report(scan, vec![], plots);
        // True of all three, and far from what is reported.
        report.truth = ["SWR137H", "FIRE1", "SWR9"]
            .iter()
            .zip(1..)
            .map(|(name, entity)| crate::runtime::messages::TruthMessage {
                id: [1, 1, entity],
                callsign: (*name).into(),
                address: None,
                type_designator: String::new(),
                aircraft: true,
                size_m: [30.0, 30.0],
                position_m: Point3::new(-3000.0, 3000.0, 0.0),
                velocity_mps: [0.0; 3],
                heading_rad: 0.0,
                ours: true,
                track: None,
            })
            .collect();
        board.on_scan(&std::sync::Arc::new(report));
        let json = board.value("aircraft.json").expect("there");
        let list = json["aircraft"].as_array().expect("a list").clone();
        list.into_iter().map(|a| (a["hex"].as_str().expect("an address").to_owned(), a)).collect()
    };
    let off_m = |entry: &serde_json::Value, place: [f64; 2]| {
        let degrees = |name: &str| entry[name].as_f64().expect(name);
        let height_m = frame.origin_geodetic().height_m;
        let at = Geodetic::from_degrees(degrees("lat"), degrees("lon"), height_m).to_ecef();
        let there = frame.to_enu(at);
        libm::hypot(there.east_m - place[0], there.north_m - place[1])
    };
    let first = shown(
        1,
        vec![
            told("SWR137H", 400_000_000, [2000.0, 500.0], [-70.0, 0.0], Some(205.74)),
            told("SWR137H", 900_000_000, [1965.5, 501.0], [-70.0, 0.0], Some(198.12)),
            told("FIRE1", 500_000_000, [100.0, 200.0], [0.0, 0.0], None),
        ],
    );
    let names: Vec<&str> = first.keys().map(String::as_str).collect();
    assert_eq!(names, ["4b0002", "4b1805"], "whom no sensor heard is not there");
    // A tenth of a second on from its last report; six decimals of degrees are 0.1 m.
    assert!(off_m(&first["4b1805"], [1958.5, 501.0]) < 0.15, "{}", first["4b1805"]);
    assert!(first["4b1805"]["alt_baro"].as_f64().is_some_and(|ft| ft > 600.0), "in the air");
    assert_eq!(first["4b1805"]["category"], "A3");
    assert!(off_m(&first["4b0002"], [100.0, 200.0]) < 0.15);
    assert_eq!(
        (&first["4b0002"]["alt_baro"], &first["4b0002"]["type"]),
        (&"ground".into(), &"adsb_icao_nt".into())
    );
    // A report that is lost: it goes on in a straight line; of one that stands the next comes in five seconds.
    let second = shown(2, vec![]);
    assert!(off_m(&second["4b1805"], [1888.5, 501.0]) < 0.15);
    assert!(off_m(&second["4b0002"], [100.0, 200.0]) < 0.15);
    assert_eq!(shown(11, vec![]).len(), 2);
    assert!(shown(12, vec![]).is_empty(), "silent for more than eleven seconds");
}

/// A flight of an A320 on runway 28.
pub(super) fn flight(callsign: &str, address: Option<u32>, movement: MovementKind) -> FlightNotice {
    FlightNotice {
        callsign: callsign.into(),
        address,
        type_designator: "A320".into(),
        wake: Some(WakeCategory::Medium),
        movement,
        runway: "28".into(),
        stand: String::new(),
        stand_m: None,
        eta_ctd_ns: 0,
        off_block_ns: None,
        routing: Vec::new(),
    }
}

/// An aircraft on final and a fire engine that stands, with their flights; somebody without an address.
pub(super) fn on_final(scan: u64) -> (Vec<FlightNotice>, ScanReport) {
    use models::frames::Point3;
    let truth = |entity, callsign: &str, position_m: [f64; 3], velocity_mps, heading_rad| {
        crate::runtime::messages::TruthMessage {
            id: [1, 1, entity],
            callsign: callsign.into(),
            address: None,
            type_designator: if callsign == "FIRE1" { "FIRE".into() } else { "A320".into() },
            aircraft: callsign != "FIRE1",
            size_m: [30.0, 30.0],
            position_m: Point3::new(position_m[0], position_m[1], position_m[2]),
            velocity_mps,
            heading_rad,
            ours: true,
            track: None,
        }
    };
    let flights = vec![
        flight("SWR137H", Some(0x4b_1805), MovementKind::Arrival),
        flight("FIRE1", Some(0x4b_0002), MovementKind::Vehicle),
        flight("NOBODY", None, MovementKind::Departure),
    ];
    let mut report = report(scan, vec![], vec![]);
    report.truth = vec![
        truth(1, "SWR137H", [3000.0, 500.0, 300.0], [-70.0, 0.0, -3.5], 4.7),
        truth(2, "FIRE1", [100.0, 200.0, 0.0], [0.0; 3], std::f64::consts::FRAC_PI_2),
        truth(3, "NOBODY", [0.0; 3], [1.0, 0.0, 0.0], 0.0),
    ];
    (flights, report)
}

/// State vectors as clients of the OpenSky Network read them: by place in the array, metres and m/s, null where nothing is known.
#[test]
fn state_vectors_have_their_values_where_opensky_has_them() {
    let board = board::Board::new(&scene(), 1, false);
    assert!(board.value("states").is_none(), "nothing yet");
    let (flights, report) = on_final(1);
    board.on_flights(flights);
    board.on_scan(&std::sync::Arc::new(report));
    let all = board.value("states").expect("there");
    let start_s = scene().run.start_utc_ns / 1_000_000_000;
    assert_eq!(all["time"], start_s + 1);
    let states = all["states"].as_array().expect("a list");
    assert_eq!(states.len(), 2, "who has no address is not there");
    let [air, ground] = [&states[0], &states[1]];
    assert!(states.iter().all(|state| state.as_array().is_some_and(|s| s.len() == 18)));
    assert_eq!(
        (&air[0], &air[1], &air[3]),
        (&"4b1805".into(), &"SWR137H ".into(), &(start_s + 1).into())
    );
    assert_eq!(
        (&air[8], &air[9], &air[10], &air[11]),
        (&false.into(), &70.0.into(), &270.0.into(), &(-3.5).into())
    );
    let frame = scene().airport.frame;
    let place =
        frame.to_ecef(geodesy::Enu { east_m: 3000.0, north_m: 500.0, up_m: 300.0 }).to_geodetic();
    let near = |value: &serde_json::Value, what: f64, by: f64| {
        value.as_f64().is_some_and(|value| (value - what).abs() <= by)
    };
    assert!(near(&air[5], place.lon_deg(), 1e-6) && near(&air[6], place.lat_deg(), 1e-6), "{air}");
    assert!(near(&air[13], place.height_m, 0.01), "{air}");
    assert!(
        air[7].as_f64().is_some_and(|m| (500.0..1500.0).contains(&m)),
        "pressure altitude: {air}"
    );
    assert_eq!(
        (&air[12], &air[14], &air[15], &air[16], &air[17]),
        (&serde_json::Value::Null, &serde_json::Value::Null, &false.into(), &0.into(), &4.into())
    );
    assert_eq!(
        (&ground[0], &ground[8], &ground[10], &ground[17]),
        (&"4b0002".into(), &true.into(), &90.0.into(), &16.into())
    );
    assert!(ground[7].is_null() && ground[11].is_null(), "{ground}");
}

/// Each scan a heartbeat and a report of each target, to whoever was named; none longer than a datagram that passes everywhere.
#[test]
fn a_display_in_a_cockpit_hears_every_target_once_a_scan() {
    let ear = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    ear.set_read_timeout(Some(std::time::Duration::from_secs(30))).expect("set");
    let to = ear.local_addr().expect("its address");
    let feeds = ports::Feeds { gdl90: vec![to], ..ports::Feeds::default() };
    assert!(feeds.asked());
    let mut ports =
        ports::Ports::open(&feeds, board::Board::new(&scene(), 1, false)).expect("open");
    let (flights, report) = on_final(7);
    ports.on_flights(&flights);
    ports.on_scan(&std::sync::Arc::new(report));
    let mut octets = [0; 2000];
    let length = ear.recv(&mut octets).expect("a datagram");
    let kinds: Vec<u8> = octets[..length]
        .split(|octet| *octet == 0x7e)
        .filter(|message| !message.is_empty())
        .map(|message| message[0])
        .collect();
    assert_eq!(kinds, [0, 20, 20], "a heartbeat and two reports");
    assert_eq!(ports.figures()["gdl90_datagrams"], 1);
    // Sixty targets: several datagrams, all reports.
    let (_, mut many) = on_final(8);
    many.truth = (1..=60)
        .map(|entity| crate::runtime::messages::TruthMessage {
            id: [1, 1, entity],
            ..many.truth[0].clone()
        })
        .collect();
    ports.on_scan(&std::sync::Arc::new(many));
    let mut reports = 0;
    while reports < 60 {
        let length = ear.recv(&mut octets).expect("a datagram");
        assert!(length <= 1400);
        let messages = octets[..length].split(|o| *o == 0x7e).filter(|m| !m.is_empty());
        reports += messages.filter(|m| m[0] == 20).count();
    }
    assert_eq!(reports, 60);
    ports.close();
}

/// Whatever was heard last, whoever asks afterwards learns that the run is over.
#[test]
fn a_run_whose_end_was_not_heard_is_over_all_the_same() {
    use crate::runtime::life_cycle::Phase;
    use crate::runtime::messages::RunState;
    let board = board::Board::new(&scene(), 1, false);
    board.on_end();
    assert_eq!(board.value("state"), None, "of a run that never was nothing is said");
    board.on_state(RunState { phase: Phase::Running, frame: 20, ..RunState::default() });
    assert_eq!(board.value("state").expect("there")["phase"], "RUNNING");
    board.on_end();
    let over = board.value("state").expect("there");
    assert_eq!((over["phase"].as_str(), over["frame"].as_u64()), (Some("STOPPED"), Some(20)));
    assert_eq!(over["reasons"][0], "the end of the run was not heard");
    board.on_state(RunState { phase: Phase::Stopped, frame: 40, ..RunState::default() });
    board.on_end();
    assert_eq!(board.value("state").expect("there")["reasons"], serde_json::json!([]));
}

/// Two hundred movers seen by every sensor and five hundred tracks, ten scans over midnight: each once, in its order, where and
/// when it was, in datagrams that every network carries.
#[test]
fn five_hundred_tracks_go_out_once_each_over_midnight() {
    use asterix::{cat010, cat020, cat021};
    use geodesy::Geodetic;
    const SCANS: u64 = 10;
    let mut scene =
        scenarios::load_without_truth(&scenarios::locate("asmgcs")).expect("a scene of many kinds");
    scene.run.start_utc_ns = 1_574_640_000_000_000_000 - 5_300_000_000; // 23:59:54.7
    let mut gateway = Gateway::new(&scene, Choice::default());
    let kinds: BTreeSet<&str> = gateway.sources.iter().map(|s| s.kind.word).collect();
    assert!(
        kinds.contains("mlat") && kinds.contains("adsb") && kinds.contains("asde"),
        "{kinds:?}"
    );
    let number = |n: u64, by: u64| ((n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) % by) as f64;
    let place =
        |n: u64| [number(n, 8_000_000) * 1e-3 - 4000.0, number(n + 77, 8_000_000) * 1e-3 - 4000.0];
    let of_day = |gateway: &Gateway, ns| gateway.of_day_s(ns);
    let (mut most_s, mut octets) = (0.0_f64, 0);
    for number_of_scan in 1..=SCANS {
        let end_ns = number_of_scan as i64 * 1_000_000_000;
        let tracks: Vec<TrackMessage> = (0..500)
            .map(|n| TrackMessage {
                position_m: place(n + 1000 * number_of_scan).into(),
                ..track(n as u16, end_ns)
            })
            .collect();
        let mut plots = Vec::new();
        for source in &gateway.sources {
            for n in 0..200 {
                plots.push(PlotMessage {
                    kind: source.kind,
                    position_m: place(n + 1000 * (u64::from(source.sic) + 300 * number_of_scan))
                        .into(),
                    sequence: n as u32,
                    polar: None,
                    ..plot(source.sic.into(), end_ns - 999_000_000 + 4_999_999 * n as i64)
                });
            }
        }
        // As they may arrive: not in their order.
        plots.reverse();
        let scan = report(number_of_scan, tracks, plots);
        let began = crate::runtime::clock::monotonic_ns();
        let sent = gateway.on_scan(&scan);
        most_s = most_s.max((crate::runtime::clock::monotonic_ns() - began) as f64 * 1e-9);
        octets += sent.iter().map(Vec::len).sum::<usize>();
        assert!(sent.iter().all(|d| d.len() <= DATAGRAM_LIMIT));
        assert!(gateway.refused().is_empty(), "{:?}", gateway.refused());

        let frame = &gateway.frame;
        let back = |[lat, lon]: [f64; 2]| {
            let height_m = frame.origin_geodetic().height_m;
            let there = frame.to_enu(Geodetic::from_degrees(lat, lon, height_m).to_ecef());
            [there.east_m, there.north_m]
        };
        let near = |found: [f64; 2], asked: [f64; 2], within_m: f64, what: &str| {
            let off_m = libm::hypot(found[0] - asked[0], found[1] - asked[1]);
            assert!(off_m <= within_m, "{what}: {off_m} m");
        };
        let on_time = |found: f64, ns: i64, what: &str| {
            let off_s = (found - of_day(&gateway, ns) + 43_200.0).rem_euclid(86_400.0) - 43_200.0;
            assert!(off_s.abs() <= 1.0 / 256.0 + 1e-9, "{what}: {off_s} s");
        };
        // (category, SIC or track number, time of day, place)
        let heard = read(&sent, |r| {
            let source = |item| r.numbers::<2>(item).map(|n| n[1] as u16);
            let number = |item| r.number(item).map(|n| n as u16);
            Some(match r.category.number {
                10 if r.number(&cat010::I000) == Some(1.0) => (
                    10,
                    source(&cat010::I010)?,
                    r.number(&cat010::I140)?,
                    r.numbers(&cat010::I041)?,
                ),
                20 => (
                    20,
                    source(&cat020::I010)?,
                    r.number(&cat020::I140)?,
                    r.numbers(&cat020::I041)?,
                ),
                21 => (
                    21,
                    source(&cat021::I010)?,
                    r.number(&cat021::I071)?,
                    r.numbers(&cat021::I131)?,
                ),
                62 => (
                    62,
                    number(&cat062::I040)?,
                    r.number(&cat062::I070)?,
                    r.numbers(&cat062::I105)?,
                ),
                11 => (
                    11,
                    number(&cat011::I161)?,
                    r.number(&cat011::I140)?,
                    r.numbers(&cat011::I041)?,
                ),
                _ => return None,
            })
        });
        let mut plots: Vec<&PlotMessage> = scan.plots.iter().collect();
        plots.sort_by_key(|p| (p.sensor, p.sequence));
        let (said_plots, said_tracks) = heard.split_at(plots.len());
        for ((category, sic, time_s, place), plot) in said_plots.iter().zip(&plots) {
            assert_eq!((*sic, *category <= 21 && *category != 11), (plot.sensor, true));
            near(
                back(*place),
                plot.position_m.into(),
                if *category == 20 { 0.4 } else { 0.05 },
                plot.kind.word,
            );
            on_time(*time_s, plot.time_ns, plot.kind.word);
        }
        assert_eq!(said_tracks.len(), 2 * scan.tracks.len(), "once in 062, once in 011");
        for (said, (category, within_m)) in said_tracks.chunks(500).zip([(62, 0.4), (11, 0.05)]) {
            for ((of, number, time_s, place), track) in said.iter().zip(&scan.tracks) {
                assert_eq!((*of, *number), (category, track.number));
                near(back(*place), track.position_m.into(), within_m, "track");
                on_time(*time_s, track.time_ns, "track");
            }
        }
    }
    assert_eq!(gateway.scans_lost(), 0);
    println!("{SCANS} scans, {octets} octets, slowest burst made in {:.1} ms", 1e3 * most_s);
}
