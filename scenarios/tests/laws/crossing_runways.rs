//! Runways that cross: their centrelines share a node that lies a little beside one of them, both belong to their strips, and two who are
//! lined up on them do not wait for each other.

#[allow(dead_code, reason = "this test draws by hand")]
use crate::drawn::Drawn;
use models::traffic::core::{Core, Direction};
use models::traffic::network::Network;
use scenarios::Scene;
use std::fmt::Write as _;
use std::path::PathBuf;

/// A runway along x and one across it, 500 m behind its threshold; a taxiway beside the second with four exits, and an apron. The file has a
/// node on the first, `beside_m` from where they cross, and edges along the first there.
fn airport(beside_m: f64) -> String {
    let mut a = Drawn { turned_rad: 0.4, ..Drawn::default() };
    let (sin, cos) = libm::sincos(70f64.to_radians());
    // Along the second runway, and to its right.
    let second = |s: f64, d: f64| (1300.0 + s * cos + d * sin, s * sin - d * cos);
    a.runway(0.0, 0.0, 2600.0, 0.0, ["09", "27"]);
    let (from, to) = (second(-500.0, 0.0), second(1900.0, 0.0));
    a.runway(from.0, from.1, to.0, to.1, ["02", "20"]);
    let on = [900.0, 1300.0 + beside_m, 1700.0].map(|x| a.node(x, 0.0));
    for pair in on.windows(2) {
        writeln!(a.edges, "1202 {} {} twoway runway 09/27", pair[0], pair[1]).expect("text");
    }
    let mut before: Option<usize> = None;
    let node = |a: &mut Drawn, s, d| {
        let (x, y) = second(s, d);
        a.node(x, y)
    };
    for (i, s) in [300.0, 900.0, 1400.0, 1890.0].into_iter().enumerate() {
        let (foot, top) = (node(&mut a, s, 0.0), node(&mut a, s, 180.0));
        a.edge(foot, top, false, &format!("E{i}"));
        if let Some(before) = before {
            a.edge(before, top, false, "A");
        }
        before = Some(top);
        if i == 2 {
            let mut lane = node(&mut a, s, 300.0);
            a.edge(top, lane, false, "C");
            for k in 0..8 {
                let s = s - 60.0 - 60.0 * f64::from(k);
                let next = node(&mut a, s, 300.0);
                a.edge(lane, next, false, "L");
                lane = next;
                let (x, y) = second(s, 395.0);
                a.stand(x, y, &format!("S{k}"));
            }
        }
    }
    a.text()
}

fn folder(name: &str, text: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("X.apt.dat"), text).expect("a file");
    folder
}

fn flown(scene: &Scene, seed: u64) -> Core {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    (1..=72_000).for_each(|frame| core.step(frame));
    core
}

/// At Quonset an edge along a runway, cut where another one crosses it, lost the strip; whoever came there was off it, and his clearance to cross
/// was over (29 false alerts on exact truth in four quiet hours).
#[test]
fn what_lies_on_a_runway_is_in_its_strip() {
    for beside_m in [-1.2, -0.8, 0.0, 0.8, 1.2, 1.5] {
        let folder = folder(&format!("crossing-strip-{beside_m}"), &airport(beside_m));
        let (airport, _) = scenarios::airport::check(&folder.join("X.apt.dat"))
            .unwrap_or_else(|e| panic!("{beside_m} m: {e}"));
        std::fs::remove_dir_all(&folder).expect("removed");
        let net = Network::of(&airport);
        let on = net.edges.iter().filter(|e| e.runway.is_some());
        let bare = on.clone().filter(|e| e.strip != e.runway).count();
        assert!(on.count() >= 8 && bare == 0, "{beside_m} m: {bare}");
        let beside = net.edges.iter().filter(|e| e.runway.is_none() && !e.backtrack).filter(|e| {
            net.runways.iter().any(|r| {
                let along = |n: &usize| r.place_m(net.nodes[*n].at_m).1.abs() < 3.0;
                e.nodes.iter().all(along)
            })
        });
        assert_eq!(beside.count(), 0, "{beside_m} m");
    }
}

/// At Bradley and Punta Arenas the bend in a centreline at a node of the other runway's was taken for the turn off the runway: from there
/// nobody could brake, and no arrival was ever released to final.
#[test]
fn a_bend_in_a_centreline_turns_no_landing_off() {
    for beside_m in [-0.8, 0.0, 0.8] {
        let folder = folder(&format!("crossing-bend-{beside_m}"), &airport(beside_m));
        let text = "[run]\ntitle = \"t\"\nseed = 3\nduration_s = 3600\n[airport]\nlayout = \"X.apt.dat\"\n[[traffic]]\n\
             kind = \"generated\"\narrivals_per_h = 10\ndepartures_per_h = 0\narrival_runways = [\"02\"]\n";
        let scene = scenarios::load_text(&folder.join("scene.toml"), text);
        let scene = scene.unwrap_or_else(|e| panic!("{beside_m} m: {e}"));
        std::fs::remove_dir_all(&folder).expect("removed");
        let core = flown(&scene, 3);
        let arrivals: Vec<usize> = (0..core.flights().len())
            .filter(|f| core.flights()[*f].direction == Direction::Arrival)
            .collect();
        let landed = arrivals.iter().filter(|f| core.measures(**f).aldt_s.is_some()).count();
        assert!(landed >= 2, "{beside_m} m: {landed} of {}", arrivals.len());
        assert!(core.remarks().iter().all(|r| !r.text.contains("no way")), "{beside_m} m");
    }
}

/// Every second departure goes to the wrong runway, which crosses the right one: there it lines up while somebody is lined up on that, and
/// neither rolled until the hour was over.
#[test]
fn two_lined_up_on_crossing_runways_take_off_one_after_the_other() {
    let path = scenarios::locate("xsyn").with_file_name("crossing.toml");
    let mut together = 0;
    for seed in [1, 2, 3, 7] {
        let mut text = format!(
            "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
             [[traffic]]\nkind = \"generated\"\narrivals_per_h = 4\ndepartures_per_h = 14\n"
        );
        let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        let flights = &scene.traffic.behaving.as_ref().expect("behaves").flights;
        let departures = flights.iter().filter(|f| f.direction == Direction::Departure);
        for flight in departures.skip(1).step_by(2) {
            writeln!(
                text,
                "[[failure]]\nkind = \"wrong_runway\"\ncallsign = \"{}\"",
                flight.callsign
            )
            .expect("text");
        }
        let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        let core = flown(&scene, seed);
        let line_ups: Vec<(f64, f64, &str)> = core
            .clearances()
            .iter()
            .filter(|c| c.kind == "LUP")
            .map(|c| (c.from_s, c.until_s.unwrap_or(3600.0), c.runway.as_str()))
            .collect();
        let longest_s = line_ups.iter().map(|l| l.1 - l.0).fold(0.0, f64::max);
        assert!(longest_s < 600.0, "seed {seed}: lined up for {longest_s:.0} s");
        together += line_ups
            .iter()
            .flat_map(|a| line_ups.iter().map(move |b| (a, b)))
            .filter(|(a, b)| a.2 != b.2 && a.0 < b.0 && b.0 < a.1)
            .count();
    }
    assert!(together > 0, "nobody was lined up on both");
}
