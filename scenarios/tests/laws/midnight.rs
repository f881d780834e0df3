//! Schedules around midnight, and demand that goes on for a day.

use scenarios::Scene;
use std::path::{Path, PathBuf};

fn load(name: &str, text: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    scenarios::load_text(&path, text).unwrap_or_else(|e| panic!("{e}"))
}

/// A table of three flights of one day, the first a minute after midnight.
fn table(name: &str) -> PathBuf {
    let file =
        std::env::temp_dir().join(format!("seeds-midnight-{}-{name}.csv", std::process::id()));
    let rows = "callsign,address,type,movement,runway,stand,tobt,eldt\n\
                AAA1,400001,A320,arrival,09,C1,,2021-08-29T00:01:00Z\n\
                BBB2,400002,A320,arrival,09,C2,,2021-08-29T00:20:00Z\n\
                CCC3,400003,A320,arrival,09,C3,,2021-08-29T13:00:00Z\n";
    std::fs::write(&file, rows).expect("written");
    file
}

/// The flights of a run that begins then (`None`: as its schedule says), with their times from its begin, s.
fn flights(start: Option<&str>, duration_s: u32) -> Vec<(String, f64)> {
    let file = table(start.unwrap_or("none").replace(':', "").as_str());
    let start = start.map_or(String::new(), |start| format!("start = {start}\n"));
    let text = format!(
        "[run]\ntitle = \"t\"\n{start}duration_s = {duration_s}\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
         [[traffic]]\nkind = \"schedule\"\nfile = \"{}\"\n",
        file.display()
    );
    let scene = load("midnight.toml", &text);
    std::fs::remove_file(&file).ok();
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    behaving.flights.iter().map(|f| (f.callsign.clone(), f.time_s)).collect()
}

/// The run of such a schedule begins on the day before, and the table was moved there: of a day all but the last minutes were over.
#[test]
fn a_schedule_that_begins_at_midnight_is_played_from_its_first_flight_on() {
    let of = |name: &str, time_s: f64| (name.to_owned(), time_s);
    let hour = [of("AAA1", 600.0), of("BBB2", 1740.0)];
    assert_eq!(flights(None, 3600), hour);
    assert_eq!(flights(Some("2021-08-28T23:51:00Z"), 3600), hour, "the same, said");
    assert_eq!(flights(None, 86_400).len(), 3);
    // On another date, and later on a day, as ever.
    assert_eq!(flights(Some("2026-05-12T12:50:00Z"), 3600), [of("CCC3", 600.0)]);
    assert_eq!(flights(Some("2026-05-12T00:00:00Z"), 3600), [of("AAA1", 60.0), of("BBB2", 1200.0)]);
}

/// Nobody landed any more after the first five thousand.
#[test]
fn demand_goes_on_to_the_end_of_a_day() {
    let scene = load(
        "demand.toml",
        "[run]\ntitle = \"t\"\nseed = 3\nduration_s = 86400\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 230\ndepartures_per_h = 230\nprofile = \"even\"\n",
    );
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let last_s = behaving.flights.iter().map(|f| f.time_s).fold(0.0, f64::max);
    assert!(last_s > 86_000.0, "{last_s}: {:?}", behaving.left_out);
}
