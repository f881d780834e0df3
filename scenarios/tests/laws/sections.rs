//! Several `[[traffic]]` sections of one scene: nobody is there twice, whoever drew or wrote him.

use models::traffic::core::Direction;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn loaded(sections: &str) -> Result<scenarios::Scene, scenarios::ScenarioError> {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 3\nstart = 2026-05-12T06:00:00Z\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n{sections}"
    );
    scenarios::load_text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("sections.toml"), &text)
}

const TWELVE: &str =
    "[[traffic]]\nkind = \"generated\"\narrivals_per_h = 12\ndepartures_per_h = 12\n";

/// Two sections of rates drew the same flights, at the same times, under the same names.
#[test]
fn sections_of_rates_draw_flights_of_their_own() {
    let light = "[[traffic]]\nkind = \"generated\"\narrivals_per_h = 6\ndepartures_per_h = 3\nmix = { C172 = 1 }\n";
    let scene = loaded(&format!("{TWELVE}{light}{TWELVE}")).unwrap_or_else(|e| panic!("{e}"));
    let flights = &scene.traffic.behaving.as_ref().expect("behaves").flights;
    let names: BTreeSet<&str> = flights.iter().map(|f| f.callsign.as_str()).collect();
    assert_eq!(names.len(), flights.len());
    assert!(flights.len() > 30, "{}", flights.len());
    let times: BTreeSet<u64> = flights.iter().map(|f| f.time_s.to_bits()).collect();
    assert_eq!(times.len(), flights.len(), "two are due at one time");
    // An address is that of one aircraft: of a turn-round's arrival and departure each has its own.
    let mut by_address: BTreeMap<u32, usize> = BTreeMap::new();
    for entry in &scene.traffic.entities {
        *by_address.entry(entry.address.expect("drawn with one")).or_default() += 1;
    }
    assert!(by_address.values().all(|n| *n == 1), "{by_address:?}");
    let of = |f: &models::traffic::core::Flight| f.turnaround_of.map(|a| flights[a].direction);
    assert!(flights.iter().filter_map(of).all(|d| d == Direction::Arrival));
    // What the first draws stays what it was without the others.
    let alone = loaded(TWELVE).unwrap_or_else(|e| panic!("{e}"));
    let alone = &alone.traffic.behaving.as_ref().expect("behaves").flights;
    assert_eq!(alone[..], flights[..alone.len()]);
}

/// A call sign in two schedules was two flights of one name.
#[test]
fn a_call_sign_of_two_schedules_is_refused_where_it_comes_again() {
    let folder = std::env::temp_dir().join(format!("seeds-sections-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let write = |name: &str, rows: &str| {
        let head = "callsign,address,type,movement,runway,stand,sobt,eldt\n";
        std::fs::write(folder.join(name), format!("{head}{rows}")).expect("written");
    };
    write("a.csv", "DLH1,,A320,departure,09,C1,2026-05-12T06:05:00Z,\n");
    write(
        "b.csv",
        "DLH2,,A320,departure,09,C2,2026-05-12T06:05:00Z,\nDLH1,,A320,departure,09,C3,2026-05-12T06:10:00Z,\n",
    );
    let section = |name: &str| {
        let file = folder.join(name);
        format!("[[traffic]]\nkind = \"schedule\"\nfile = {:?}\n", file.display().to_string())
    };
    let one = loaded(&section("a.csv")).map(|_| ());
    let both = loaded(&format!("{}{}", section("a.csv"), section("b.csv"))).map(|_| ());
    std::fs::remove_dir_all(&folder).expect("removed");
    assert!(one.is_ok(), "{one:?}");
    let told = both.expect_err("twice").to_string();
    assert!(told.contains("b.csv:3") && told.contains("DLH1"), "{told}");
}

/// A car took off, and an address that nobody can read was none.
#[test]
fn rows_that_cannot_be_flown_are_refused() {
    let folder = std::env::temp_dir().join(format!("seeds-rows-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("s.csv");
    let told = |row: &str| {
        // A spreadsheet's mark before the first column, and its ends of lines.
        let head = "\u{feff}callsign,address,type,movement,runway,stand,sobt,eldt";
        std::fs::write(&file, format!("{head}\r\n{row}\r\n")).expect("written");
        let section =
            format!("[[traffic]]\nkind = \"schedule\"\nfile = {:?}\n", file.display().to_string());
        loaded(&section).err().map(|e| e.to_string())
    };
    let of = |address: &str, designator: &str| {
        told(&format!("DLH1,{address},{designator},departure,09,C1,2026-05-12T06:05:00Z,"))
    };
    let [car, word, long, prefixed, none] = [
        of("", "FOLLOWME"),
        of("4b18zz", "A320"),
        of("14b1800", "A320"),
        of("0x4b1800", "A320"),
        of("", "A320"),
    ];
    std::fs::remove_dir_all(&folder).expect("removed");
    let car = car.expect("refused");
    assert!(car.contains("s.csv:2: type") && !car.contains("BUS"), "{car}");
    for refused in [word, long] {
        let told = refused.expect("refused");
        assert!(told.contains("s.csv:2: address"), "{told}");
    }
    assert_eq!((prefixed, none), (None, None));
}

/// Numbers of drawn flights end at 60 000: a section behind those that used all of them drew nobody, and nothing said so.
#[test]
fn a_section_for_which_no_number_is_left_says_so() {
    let most = "[[traffic]]\nkind = \"generated\"\ndepartures_per_h = 2000\nprofile = \"even\"\nmix = { C172 = 1 }\n";
    let text = |sections: usize| {
        format!(
            "[run]\ntitle = \"t\"\nseed = 3\nduration_s = 86400\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n{}",
            most.repeat(sections)
        )
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sections.toml");
    let left_out = |sections: usize| {
        let scene = scenarios::load_text(&path, &text(sections)).unwrap_or_else(|e| panic!("{e}"));
        scene.traffic.behaving.expect("behaves").left_out.clone()
    };
    let (two, three) = (left_out(2), left_out(3));
    assert_eq!(three.len(), two.len() + 1, "{two:?} {three:?}");
    let told = three.last().expect("said");
    assert!(told.contains("60000") && told.contains("none"), "{told}");
}

/// A reader of tables begins to look for a row before the comments and blank lines in front of it, and told that line.
#[test]
fn rows_are_named_by_their_own_line_whatever_is_before_them() {
    let folder = std::env::temp_dir().join(format!("seeds-lines-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("s.csv");
    let sound = "DLH1,,A320,departure,09,C1,2026-05-12T06:05:00Z,";
    let wrong = [
        "DLH2,,A320,departure,09,C2,yesterday,",
        "DLH2,,A320",
        "DLH2,xyz,A320,departure,09,C2,2026-05-12T06:05:00Z,",
    ];
    let before = ["", "# one", "# one\n\n", "\n\n\n", "# \"\n#\n\n# three\n#four"];
    let mut found = Vec::new();
    for end in ["\n", "\r\n"] {
        for (first, second) in before.iter().flat_map(|a| before.map(|b| (a, b))) {
            for bad in wrong {
                let head = "callsign,address,type,movement,runway,stand,sobt,eldt";
                let text = format!("{head}\n{first}\n{sound}\n{second}\n{bad}\n# end\n");
                let due = 1 + text.lines().position(|l| l == bad).expect("there");
                std::fs::write(&file, text.replace('\n', end)).expect("written");
                let section = format!(
                    "[[traffic]]\nkind = \"schedule\"\nfile = {:?}\n",
                    file.display().to_string()
                );
                let told = loaded(&section).err().map(|e| e.to_string()).unwrap_or_default();
                found.push((due, bad, told));
            }
        }
    }
    std::fs::remove_dir_all(&folder).expect("removed");
    for (due, bad, told) in found {
        assert!(told.contains(&format!("s.csv:{due}: ")), "{bad}: due {due}, {told}");
    }
}
