//! Traffic on airports that nobody has drawn: made at random, written as files, read, and run for half an hour; and on files that
//! are damaged.

use crate::drawn::{Drawn, drawn};
use models::control::alert::Change;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::core::Core;
use models::traffic::exact::Watch;
use scenarios::hours::{Held, Hour, hour};
use std::fmt::Write as _;
use std::path::PathBuf;

/// The airport of a file, driven for half an hour; else what its reader said.
fn run(name: &str, text: &str, per_h: f64, looks: Hour, policy: &str) -> Result<Held, String> {
    let scene = scene(name, text, per_h, &looks, policy)?;
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
    let step = |core: &mut Core, frame| core.step(frame);
    hour(behaving, &scene.run, &scene.airport.layout, &looks, step).ok_or("without truth".into())
}

fn scene(
    name: &str,
    text: &str,
    per_h: f64,
    looks: &Hour,
    policy: &str,
) -> Result<scenarios::Scene, String> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("airport-{name}"));
    std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
    std::fs::write(folder.join("X.apt.dat"), text).map_err(|e| e.to_string())?;
    let scene = format!(
        "[run]\ntitle = \"t\"\nseed = {}\nduration_s = 1800\n[airport]\nlayout = \"X.apt.dat\"\n[[traffic]]\nkind = \"generated\"\n\
         arrivals_per_h = {per_h}\ndepartures_per_h = {per_h}\n[control]\npolicy = \"{policy}\"\n",
        looks.seed
    );
    let scene = scenarios::load_text(&folder.join("scene.toml"), &scene);
    let scene = scene.map_err(|e| e.to_string())?;
    // `SEEDS_KEEP=1`: the files stay where they were read.
    if std::env::var_os("SEEDS_KEEP").is_none() {
        std::fs::remove_dir_all(&folder).map_err(|e| e.to_string())?;
    }
    Ok(scene)
}

/// The same, and what the safety net raises on the exact truth in the hour: nothing, where nobody errs.
fn alerts(name: &str, text: &str, per_h: f64, looks: Hour) -> Result<(Held, Vec<String>), String> {
    let scene = scene(name, text, per_h, &looks, "planned")?;
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let mut raised = Vec::new();
    let step = |core: &mut Core, frame: i64| {
        core.step(frame);
        let now = SimTime(frame * scene.run.frame.0);
        if frame % 20 == 0 {
            let new = watch.scan(core, now).iter().filter(|c| c.0 == Change::Raised);
            raised.extend(new.map(|(_, alert)| {
                format!("{:.0} s {} {}", now.s(), alert.condition.kind.word(), alert.subjects())
            }));
        }
    };
    let held = hour(behaving, &scene.run, &scene.airport.layout, &looks, step);
    Ok((held.ok_or("without truth")?, raised))
}

fn looks(seed: u64, stopping: f64) -> Hour {
    Hour { seed, every: 4, drain_s: 7200.0, stopping }
}

/// How many airports: `SEEDS_AIRPORTS=from..to` for more of them.
fn seeds() -> std::ops::Range<u64> {
    let asked = std::env::var("SEEDS_AIRPORTS").ok();
    let parts = asked.as_deref().and_then(|a| a.split_once(".."));
    let numbers = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.map_or(1..9, |(a, b)| a..b)
}

/// No overlap, no gridlock, everything cleared, everybody served in the end: on each of them, also where three in ten stop.
#[test]
fn airports_at_random_keep_what_traffic_has_to_keep() {
    let mut broken = Vec::new();
    let mut refused = 0;
    for seed in seeds() {
        let text = drawn(seed);
        for (policy, stopping) in [("planned", 0.0), ("planned", 0.3), ("ordered", 0.3)] {
            let name = format!("seed {seed}, {policy}, {stopping} stop");
            match run(&format!("random-{seed}"), &text, 8.0, looks(seed, stopping), policy) {
                // A short one whose entries leave less than a run: said so.
                Err(said) if said.contains("is long enough for") => refused += 1,
                Err(said) => broken.push(format!("{name}: {said}")),
                Ok(held) => {
                    if stopping == 0.0 {
                        let raised =
                            alerts(&format!("alerts-{seed}"), &text, 8.0, looks(seed, 0.0));
                        let raised = raised.map(|(_, raised)| raised).unwrap_or_default();
                        broken.extend(raised.iter().map(|r| format!("{name}: on truth {r}")));
                    }
                    let (done, of) = (held.core.measures_of_served(), held.core.flights().len());
                    broken.extend(held.broken().iter().map(|b| format!("{name}: {b}")));
                    if done < of || held.core.unexpected_deadlocks() > 0 {
                        let rings = held.core.unexpected_deadlocks();
                        let said = held.core.remarks().iter().map(|r| r.text.as_str());
                        let said = said.collect::<Vec<_>>().join("; ");
                        broken
                            .push(format!("{name}: served {done} of {of}, {rings} rings: {said}"));
                    }
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(
        2 * refused < 3 * (seeds().end - seeds().start),
        "{refused} refused: too few looked at"
    );
}

/// Airports on which something broke once: a crawl that ended with a jolt, somebody who was passed by for longer than twenty
/// minutes, a bend of 0.4 m radius that was driven at 1 m/s, somebody who braked while he came to his line from 2 m beside it,
/// airports that nobody can land on or leave without a backtrack, bends over a right angle whose arcs led off the pavement, and
/// queues at a runway that were told as rings. One that is too short is refused with the reason.
#[test]
fn what_broke_on_an_airport_once_is_kept() {
    let once = [(33, "planned"), (70, "planned"), (59, "ordered"), (94, "ordered")];
    let later = [175, 402, 550, 555, 1000, 1113, 1227, 1373].map(|seed| (seed, "planned"));
    for (seed, policy) in
        once.into_iter().chain(later).chain([1207, 1214, 1227].map(|seed| (seed, "ordered")))
    {
        let name = format!("once-{seed}");
        let held = run(&name, &drawn(seed), 8.0, looks(seed, 0.3), policy);
        let held = held.unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        assert_eq!(held.broken(), Vec::<String>::new(), "seed {seed}");
        assert_eq!(held.core.unexpected_deadlocks(), 0, "seed {seed}");
    }
    // Every departure enters from an intersection, with less ahead than is wanted there.
    let held = run("once-scant", &drawn(1200), 8.0, looks(1200, 0.0), "planned").expect("usable");
    assert_eq!(held.core.measures_of_served(), held.core.flights().len());
    assert!(held.core.clearances().iter().filter(|c| c.kind == "TOF").count() >= 3);
    // Ends that are reached by a backtrack only.
    for seed in [29, 64] {
        let held = run("once-backtrack", &drawn(seed), 8.0, looks(seed, 0.0), "planned");
        let held = held.unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        assert_eq!(held.broken(), Vec::<String>::new(), "seed {seed}");
        assert_eq!(held.core.measures_of_served(), held.core.flights().len(), "seed {seed}");
    }
    let short = backtracked(450.0, 18.0, &[0.5]);
    let said = run("once-short", &short, 8.0, looks(1, 0.0), "planned");
    let said = said.map(|h| h.core.flights().len()).expect_err("too short for the mix");
    assert!(said.contains("is long enough for"), "{said}");
}

/// An airport with its taxiways only where `shares` of the runway say: everybody backtracks to the ends.
fn backtracked(length_m: f64, width_m: f64, shares: &[f64]) -> String {
    let mut a = Drawn { turned_rad: 0.7, ..Drawn::default() };
    a.runway(0.0, 0.0, length_m, 0.0, ["05", "23"]);
    a.runways = a.runways.replacen("100 45.00", &format!("100 {width_m:.2}"), 1);
    let mut before = None;
    for share in shares {
        let x = share * length_m;
        let (foot, half, top) = (a.node(x, 0.0), a.node(x, 95.0), a.node(x, 170.0));
        a.edge(foot, half, false, "E");
        a.edge(half, top, false, "E");
        if let Some(before) = before.replace(top) {
            a.edge(before, top, false, "A");
        }
    }
    let middle = shares[shares.len() / 2] * length_m;
    let foot = a.node(middle, 280.0);
    a.edge(
        before.map_or(0, |last| last - 3 * (shares.len() - 1 - shares.len() / 2)),
        foot,
        false,
        "C",
    );
    for side in [-1.0, 1.0] {
        let mut lane = foot;
        for k in 1..=5 {
            let x = middle + side * 60.0 * f64::from(k);
            let next = a.node(x, 280.0);
            a.edge(lane, next, false, "L");
            lane = next;
            if k < 5 {
                let (lat, lon) = a.at(x, 375.0);
                let heading = a.turned_rad.to_degrees().rem_euclid(360.0);
                writeln!(a.stands, "1300 {lat:.8} {lon:.8} {heading:.2} gate jets|turboprops S{x:.0}\n1301 C airline")
                    .expect("text");
            }
        }
    }
    a.text()
}

/// Where the only ways off the runway lie in its middle, or near one end, flights backtrack and turn on it: everybody is served,
/// and at both ends at least one used a pad. Wide bodies, who cannot turn on 45 m, are left out.
#[test]
fn airports_without_entries_at_their_ends_are_served_by_backtracks() {
    for (name, length_m, width_m, shares) in [
        ("middle", 2300.0, 45.0, &[0.45][..]),
        ("two", 3000.0, 45.0, &[0.35, 0.6]),
        ("end", 2500.0, 45.0, &[0.02]),
        ("narrow", 2400.0, 30.0, &[0.6]),
        // Too short for airliners: turboprops, and a field for light ones.
        ("regional", 1700.0, 30.0, &[0.5]),
        ("field", 1100.0, 18.0, &[0.4]),
    ] {
        let text = backtracked(length_m, width_m, shares);
        let held = run(&format!("back-{name}"), &text, 5.0, looks(1, 0.0), "planned");
        let held = held.unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(held.broken(), Vec::<String>::new(), "{name}");
        let (done, of) = (held.core.measures_of_served(), held.core.flights().len());
        assert_eq!(done, of, "{name}");
        assert!(of >= 3, "{name}: {of} flights");
        let report = held.core.network().report.join("; ");
        assert!(report.contains("backtrack to a turn pad"), "{name}: {report}");
        let around = held.core.remarks().iter().filter(|r| r.text.contains("goes around")).count();
        assert!(2 * around <= of, "{name}: {around} go-arounds of {of} flights");
    }
}

/// A taxiway that leads around the end of a runway, to an apron on the other side.
fn around_the_end(behind_m: f64) -> String {
    let mut a = Drawn { turned_rad: 2.1, ..Drawn::default() };
    let length_m = 2600.0;
    a.runway(0.0, 0.0, length_m, 0.0, ["12", "30"]);
    let mut before = None;
    for x in [10.0, 0.3 * length_m, 0.6 * length_m, length_m - 10.0] {
        let (foot, top) = (a.node(x, 0.0), a.node(x, 170.0));
        a.edge(foot, top, false, "E");
        if let Some(before) = before.replace(top) {
            a.edge(before, top, false, "A");
        }
    }
    let corners = [170.0, -170.0].map(|y| a.node(length_m + behind_m, y));
    a.edge(before.unwrap_or(0), corners[0], false, "A");
    a.edge(corners[0], corners[1], false, "Z");
    let mut lane = corners[1];
    for k in 0..8 {
        let x = length_m - 70.0 * f64::from(k);
        let next = a.node(x, -230.0);
        a.edge(lane, next, false, "L");
        lane = next;
        let (lat, lon) = a.at(x - 35.0, -330.0);
        let heading = (a.turned_rad.to_degrees() + 180.0).rem_euclid(360.0);
        writeln!(
            a.stands,
            "1300 {lat:.8} {lon:.8} {heading:.2} gate jets|turboprops S{k}\n1301 C airline"
        )
        .expect("text");
    }
    a.text()
}

/// Whoever goes around the end of a runway within its strip is in the way of who lands over it: he crosses, with a clearance, and
/// waits for it off the strip. Farther away nobody asks.
#[test]
fn a_taxiway_behind_the_end_of_a_runway_is_crossed_with_a_clearance() {
    for (behind_m, crosses) in [(25.0, true), (45.0, true), (75.0, false)] {
        let name = format!("around-{behind_m}");
        let (held, raised) =
            alerts(&name, &around_the_end(behind_m), 9.0, looks(1, 0.0)).expect("usable");
        assert_eq!(held.broken(), Vec::<String>::new(), "{name}");
        assert_eq!(raised, Vec::<String>::new(), "{name}");
        let (core, of) = (&held.core, held.core.flights().len());
        assert_eq!(core.measures_of_served(), of, "{name}");
        let crossed = core.clearances().iter().filter(|c| c.kind == "CRO").count();
        assert!(of >= 6 && if crosses { crossed >= of } else { crossed == 0 }, "{crossed} of {of}");
        let report = core.network().report.join("; ");
        assert_eq!(report.contains("behind an end"), crosses, "{name}: {report}");
    }
}

/// Taking whatever is free ends in gridlock: on some of them it does, and then the ring is named within a minute of standing still.
#[test]
fn the_free_policy_names_its_deadlock_within_a_minute() {
    let mut gridlocks = 0;
    for seed in seeds() {
        let held = run(&format!("free-{seed}"), &drawn(seed), 14.0, looks(seed, 0.3), "free");
        let Ok(held) = held else { continue };
        let row = held.rows.iter().find(|r| r.name == "gridlocks").expect("a row");
        if row.kept {
            continue;
        }
        gridlocks += 1;
        let since: f64 = row.cases[0]
            .split_whitespace()
            .find_map(|w| w.parse().ok())
            .unwrap_or_else(|| panic!("seed {seed}: {}", row.cases[0]));
        let named = held.core.remarks().iter().find(|r| r.text.starts_with("deadlock"));
        assert!(
            named.is_some_and(|r| r.time_s <= since + 60.0),
            "seed {seed}: nothing moves since {since} s, named {named:?}"
        );
    }
    assert!(gridlocks > 0, "no gridlock at all: the test looks at nothing");
}

fn xsyn() -> String {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("airports/XSYN.apt.dat");
    std::fs::read_to_string(file).expect("ships")
}

/// Without holding positions, runway edges or lead-ins a file is still usable.
#[test]
fn a_file_without_holds_spines_or_lead_ins_is_usable() {
    let lines = |keep: &dyn Fn(&str) -> bool| -> String {
        xsyn().lines().filter(|l| keep(l)).map(|l| format!("{l}\n")).collect()
    };
    let no_holds = lines(&|l| !l.starts_with("1204"));
    let no_spine = lines(&|l| !(l.starts_with("1202") && l.contains(" runway ")));
    // Nodes 50, 52, … are stands: without their edges they are joined to the nearest lane.
    let no_lead_ins = lines(&|l| {
        let mut words = l.split_whitespace();
        let second = (words.next() == Some("1202")).then(|| words.nth(1)).flatten();
        second.and_then(|n| n.parse::<u32>().ok()).is_none_or(|n| n < 50 || n % 2 == 1)
    });
    for (name, text) in [("holds", no_holds), ("spine", no_spine), ("lead-ins", no_lead_ins)] {
        assert_ne!(text, xsyn(), "{name}: nothing was taken out");
        let held = run(&format!("without-{name}"), &text, 10.0, looks(3, 0.0), "planned");
        let held = held.unwrap_or_else(|e| panic!("without {name}: {e}"));
        assert_eq!(held.broken(), Vec::<String>::new(), "without {name}");
        assert_eq!(held.core.measures_of_served(), held.core.flights().len(), "without {name}");
        assert!(held.core.flights().len() > 6, "without {name}");
    }
}

/// What cannot be used says why.
#[test]
fn a_file_that_cannot_be_used_says_why() {
    let without = |rows: &[&str]| -> String {
        let kept = |l: &&str| !rows.iter().any(|r| l.starts_with(r));
        xsyn().lines().filter(kept).map(|l| format!("{l}\n")).collect()
    };
    for (rows, says) in [
        (&["1300", "1301"][..], "stands with a way"),
        (&["1202"][..], "no stand with a way"),
        (&["1201", "1202"][..], "no stand with a way"),
        (&["100 "][..], "runway"),
    ] {
        let said = run("unusable", &without(rows), 10.0, looks(1, 0.0), "planned");
        let said = said.map(|h| h.core.flights().len()).expect_err("cannot be used");
        assert!(said.contains(says), "without {rows:?}: {said}");
    }
}
