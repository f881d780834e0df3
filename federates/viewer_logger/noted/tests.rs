use super::super::tests::scan;
use super::*;
use models::control::alert::AlertKind;
use models::frames::Point2;

/// A runway to the east from (0, 0) to (1000, 0), 60 m wide, and a stand at (500, 400).
fn notes() -> Notes {
    let runway = RunwayShape {
        designators: ["09".into(), "27".into()],
        ends: [[0.0, 0.0], [1000.0, 0.0]],
        width_m: 60.0,
    };
    Notes { runways: vec![runway], stands_m: vec![[500.0, 400.0]], ..Notes::default() }
}

/// Scan `n` with its track at a place, at so many m/s.
fn at(n: u64, place_m: [f64; 2], mps: f64) -> ScanReport {
    let mut report = scan(n);
    report.tracks[0].position_m = Point2::from(place_m);
    report.tracks[0].velocity_mps = [mps, 0.0];
    report
}

fn told(time_s: f64, phase: &str, more: &str) -> String {
    format!(
        r#"{{"time_s":{time_s},"movers":[{{"callsign":"SWR1","phase":"{phase}","stand":"A"{more}}}],"runways":[]}}"#
    )
}

fn alert(id: u32, change: Change, stage: Stage, subjects: &str, s: i64) -> AlertMessage {
    AlertMessage {
        run: 1,
        time_ns: s * 1_000_000_000,
        change,
        id,
        kind: AlertKind::RunwayArrival,
        stage,
        subjects: subjects.into(),
        since_ns: 0,
        asterix: 9,
        place_m: Point2::new(1.0, 2.0),
        number: 0,
    }
}

const TAXIWAY: [f64; 2] = [500.0, 200.0];

#[test]
fn every_clearance_and_phase_that_is_said_has_its_number() {
    use models::control::clearance::ClearanceKind;
    assert!(ClearanceKind::ALL.iter().all(|kind| cleared(kind.word()) > 0));
    assert_eq!((cleared("PSH"), cleared("CRO"), cleared("REV"), cleared("XXX")), (1, 4, 13, 0));
    let more = r#","cleared":[{"kind":"PSH"},{"kind":"TAX"}]"#;
    for (phase, number) in [
        ("parked", 1),
        ("pushing", 2),
        ("starting", 3),
        ("taxiing", 4),
        ("lined up", 7),
        ("rolling", 8),
        ("going around", 9),
        ("final", 10),
        ("landing", 11),
        ("docked", 13),
    ] {
        let mut notes = notes();
        notes.traffic(&told(2.0, phase, more));
        let note = notes.scan(&at(3, TAXIWAY, 6.0))[&4];
        let wanted = Note { doing: number, derived: false, alert: 0, cleared: 2 };
        assert_eq!(note, wanted, "{phase}");
    }
    // Who waits holds, who taxies over a runway crosses it, and a word of a later version is derived.
    let doing_of = |phase: &str, more: &str, place_m| {
        let mut notes = notes();
        notes.traffic(&told(2.0, phase, more));
        let note = notes.scan(&at(3, place_m, 6.0))[&4];
        (DOING[usize::from(note.doing)], note.derived)
    };
    assert_eq!(doing_of("taxiing", r#","waits":{"for":null,"at":""}"#, TAXIWAY).0, "holding");
    assert_eq!(doing_of("taxiing", "", [500.0, 10.0]), ("crossing", false));
    assert_eq!(doing_of("hovering", "", TAXIWAY), ("taxiing", true));
}

#[test]
fn a_scan_has_what_was_said_as_of_earlier_times_whichever_comes_first() {
    let said = |report_first: bool| {
        let mut notes = notes();
        let mut found = Vec::new();
        for n in 1..=8 {
            let report = at(n, TAXIWAY, 6.0);
            let text = told(n as f64, if n < 4 { "parked" } else { "pushing" }, "");
            let raised = alert(1, Change::Raised, Stage::Alarm, "SWR1 CAR1", n as i64);
            if report_first {
                found.push(notes.scan(&report)[&4]);
            }
            notes.traffic(&text);
            if n == 5 {
                notes.alerts(&[raised]);
            }
            if !report_first {
                found.push(notes.scan(&report)[&4]);
            }
        }
        found
    };
    let (first, last) = (said(true), said(false));
    assert_eq!(first, last);
    let doing: Vec<u8> = first.iter().map(|note| note.doing).collect();
    assert_eq!(doing, [4, 1, 1, 1, 2, 2, 2, 2], "the first scan is by map and speed");
    let alerts: Vec<u8> = first.iter().map(|note| note.alert).collect();
    assert_eq!(alerts, [0, 0, 0, 0, 0, 2, 2, 2]);
}

#[test]
fn an_alert_is_of_its_subjects_by_name_or_number_and_ends() {
    let mut notes = notes();
    let mut report = at(9, TAXIWAY, 6.0);
    let mut nameless = report.tracks[0].clone();
    (nameless.number, nameless.callsign) = (17, String::new());
    // A call sign that is only likely is not one.
    nameless.assumed = "CAR1".into();
    report.tracks.push(nameless);
    let mut stages = |notes: &mut Notes, n: u64| {
        report.time_ns = 1_000_000_000 * n as i64;
        let noted = notes.scan(&report);
        (noted[&4].alert, noted[&17].alert)
    };
    notes.alerts(&[alert(1, Change::Raised, Stage::Information, "SWR1 17", 1)]);
    assert_eq!(stages(&mut notes, 2), (1, 1));
    notes.alerts(&[alert(2, Change::Raised, Stage::Alarm, "17 CAR1", 2)]);
    assert_eq!(stages(&mut notes, 3), (1, 2), "the gravest");
    notes.alerts(&[alert(1, Change::Ended, Stage::Information, "SWR1 17", 3)]);
    assert_eq!(stages(&mut notes, 4), (0, 2));
    notes.alerts(&[alert(2, Change::Changed, Stage::Alarm, "SWR1 CAR1", 4)]);
    assert_eq!(stages(&mut notes, 5), (2, 0), "as it is called now");
}

#[test]
fn by_map_and_speed_a_track_does_another_thing_when_it_has_for_five_seconds() {
    let word = |place_m, mps| {
        let note = notes().scan(&at(1, place_m, mps))[&4];
        assert!(note.derived && note.cleared == 0);
        DOING[usize::from(note.doing)]
    };
    assert_eq!(word(TAXIWAY, 6.0), "taxiing");
    assert_eq!(word(TAXIWAY, 0.2), "holding");
    assert_eq!(word([510.0, 420.0], 0.2), "parked");
    assert_eq!(word([510.0, 20.0], 0.2), "lined up");
    assert_eq!(word([510.0, 20.0], 60.0), "landing", "an arrival");
    assert_eq!(word([510.0, 31.0], 60.0), "taxiing", "beside the runway");
    assert_eq!(word([-1.0, 0.0], 6.0), "taxiing", "before its begin");
    let mut notes = notes();
    let mut shown = Vec::new();
    for n in 1..=20_u64 {
        // It stops for three seconds, and then for good.
        let stands = (4..7).contains(&n) || n >= 10;
        let note = notes.scan(&at(n, TAXIWAY, if stands { 0.0 } else { 6.0 }))[&4];
        shown.push(DOING[usize::from(note.doing)]);
    }
    assert!(shown[..14].iter().all(|word| *word == "taxiing"), "{shown:?}");
    assert!(shown[14..].iter().all(|word| *word == "holding"), "{shown:?}");
}

#[test]
fn what_is_no_text_or_too_old_says_nothing() {
    let mut notes = notes();
    for text in ["", "no JSON", "{}", r#"{"time_s":null,"movers":[]}"#] {
        notes.traffic(text);
    }
    notes.traffic(&told(1.0, "pushing", ""));
    assert_eq!(notes.scan(&at(11, TAXIWAY, 6.0))[&4].doing, 2);
    assert_eq!(notes.scan(&at(12, TAXIWAY, 6.0))[&4].doing, 4, "nothing was heard for ten seconds");
}
