//! Twelve scenes with one failure each, of generated traffic, watched by radar and multilateration: what each has to raise, of whom, when,
//! and nothing else.

use studies::control::{self, NOTHING};
use studies::expected::{Alert, Expected, on_tracks};

/// An airport of the study, seed, failure with its keys, whose; what has to be raised within so many seconds, and what may be.
struct Case {
    airport: &'static str,
    seed: u64,
    failure: &'static str,
    of: &'static str,
    more: &'static str,
    raises: &'static [(&'static str, f64)],
    also: &'static [&'static str],
}

const fn case(
    airport: &'static str,
    seed: u64,
    (failure, of): (&'static str, &'static str),
    raises: &'static [(&'static str, f64)],
) -> Case {
    Case { airport, seed, failure, of, more: "", raises, also: &[] }
}

/// What the car, and who stands on the runway, may cause beside.
const RUNWAY: &[&str] = &["RMCA_ARR", "RMCA_ROLL", "ROUTE_DEV", "NOMOV"];

const CASES: [Case; 12] = [
    Case {
        also: RUNWAY,
        ..case("LZIB", 22, ("pass_hold", "GD0006"), &[("STOPBAR", 3.0), ("NOCLR_RWY", 6.0)])
    },
    Case {
        also: RUNWAY,
        ..case("XSYN", 32, ("take_off_uncleared", "GD0002"), &[("NOCLR_TOF", 14.0)])
    },
    case("EGCC", 33, ("forget_landing_clearance", "GA0003"), &[("NOCLR_LND", 3.0)]),
    case("LIMC", 34, ("push_uncleared", "GD0002"), &[("NOCLR_PUSH", 14.0)]),
    Case {
        also: &["RMCA_ARR", "RMCA_ROLL", "NOCLR_LND"],
        ..case("XSYN", 35, ("vehicle_on_runway", "GA0003"), &[("NOCLR_RWY", 6.0)])
    },
    Case { also: RUNWAY, ..case("LSZH", 36, ("wrong_turn", "GA0001"), &[("ROUTE_DEV", 20.0)]) },
    Case {
        also: RUNWAY,
        more: "stay_s = 180\n",
        ..case("LZIB", 37, ("no_reply", "GD0002"), &[("NOMOV", 48.0)])
    },
    Case {
        also: RUNWAY,
        more: "clearance = \"LUP\"\n",
        ..case("EHAM", 38, ("conflicting_clearance", "GA0004"), &[("CATC_LND_LUP", 1.0)])
    },
    Case {
        also: RUNWAY,
        ..case("LSZH", 39, ("wrong_runway", "GD0002"), &[("STOPBAR", 6.0), ("NOCLR_RWY", 12.0)])
    },
    Case { also: RUNWAY, ..case("LZIB", 40, ("stop_bar", "GD0003"), &[("NOCLR_RWY", 6.0)]) },
    Case { also: RUNWAY, ..case("LIMC", 41, ("blown_tyre", "GA0001"), &[]) },
    Case { also: RUNWAY, ..case("EHAM", 42, ("transponder", "GA0001"), &[]) },
];

#[test]
fn each_failure_raises_its_alerts_in_time_and_no_other() {
    let mut wrong = Vec::new();
    for Case { airport, seed, failure, of, more, raises, also } in &CASES {
        let name = format!("{airport} {seed}, {failure} of {of}");
        let (_, files, rate) = control::AIRPORTS.iter().find(|a| a.0 == *airport).expect("known");
        let quiet = control::text(files, *rate, *seed, 2400.0, NOTHING).expect("a scene");
        let text = format!(
            "{quiet}[[failure]]\nid = \"f\"\nkind = \"{failure}\"\ncallsign = \"{of}\"\n{more}"
        );
        let scene = match control::read(&text) {
            Ok(scene) => scene,
            Err(e) => {
                wrong.push(format!("{name}: {e}"));
                continue;
            }
        };
        let (shown, raised) = on_tracks(&scene, &["ASDE tower", "MLAT"]).expect("flies");
        let alert = |(kind, within_s): &(&str, f64)| Alert {
            kind: (*kind).to_owned(),
            failure: "f".into(),
            within_s: *within_s,
            subjects: None,
            // Of the car, not of who lands, where there is one.
            involves: (*failure != "vehicle_on_runway").then(|| (*of).to_owned()),
        };
        let expected = Expected {
            expected: raises.iter().map(alert).collect(),
            also: also.iter().map(|kind| (*kind).to_owned()).collect(),
        };
        if shown.len() != 1 {
            wrong.push(format!("{name}: shows {shown:?}"));
        }
        wrong.extend(expected.complaints(&shown, &raised).iter().map(|c| format!("{name}: {c}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
