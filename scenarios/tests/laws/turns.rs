//! Who crosses a runway on the way to his own or back over the one that he landed on, who is given room between landings, who leaves at
//! the side of his stand, and who stands where lead-ins are short: on airports drawn for it.

#[allow(dead_code, reason = "this test draws by hand")]
use crate::drawn::Drawn;
use models::traffic::core::{Core, Direction};
use scenarios::hours::{Held, Hour, hour};
use std::path::PathBuf;

/// An hour of a drawn airport and half an hour more, with `keys` of the generated traffic; every fourth frame is looked at.
fn held(name: &str, airport: &Drawn, seed: u64, keys: &str) -> Held {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{seed}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("X.apt.dat"), airport.text()).expect("a file");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"X.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\n{keys}\n"
    );
    let scene = scenarios::load_text(&folder.join("scene.toml"), &text);
    let scene = scene.unwrap_or_else(|e| panic!("{name}: {e}"));
    std::fs::remove_dir_all(&folder).expect("removed");
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let looks = Hour { seed, every: 4, drain_s: 1800.0, stopping: 0.0 };
    let step = &mut |core: &mut Core, frame| core.step(frame);
    hour(behaving, &scene.run, &scene.airport.layout, &looks, step).expect("with truth")
}

/// Who departs over a runway to his own has that before his tail is over the other: at Flying Cloud he lost it then, a second one lined
/// up behind him, and each stood for the other until the end.
#[test]
fn who_leaves_a_strip_on_its_way_keeps_its_own_runway() {
    for (gap_m, mix) in [(200.0, "C172 = 1"), (240.0, "A320 = 1"), (300.0, "C550 = 1")] {
        let keys = format!(
            "arrivals_per_h = 2\ndepartures_per_h = 40\narrival_runways = [\"13R\"]\n\
             departure_runways = [\"13R\"]\nmix = {{ {mix} }}"
        );
        let airport = Drawn::parallel(gap_m, [10.0, 250.0, 1700.0, 2590.0], &[(0, 3), (2, 10)]);
        let held = held(&format!("keeps-runway-{gap_m}"), &airport, 1, &keys);
        let line_ups: Vec<_> = held.core.clearances().iter().filter(|c| c.kind == "LUP").collect();
        assert!(line_ups.len() > 10, "{gap_m} m: {}", line_ups.len());
        for (k, one) in line_ups.iter().enumerate() {
            let open = |c: &&&&models::traffic::core::Clearance| {
                c.runway == one.runway && c.until_s.is_none_or(|t| t > one.from_s)
            };
            let two = line_ups[..k].iter().find(|c| open(&c));
            assert!(two.is_none(), "{gap_m} m: {two:?} and {one:?}");
        }
        assert_eq!(held.broken(), Vec::<String>::new(), "{gap_m} m");
    }
}

/// Stands whose lead-ins are too short for the longest: at Flying Cloud, Marathon and others light aircraft stood up to 29 m beyond the
/// place of the file, off the pavement, and were not on a stand to anybody who looked.
#[test]
fn small_aircraft_stand_where_the_file_has_their_stand() {
    for (mix, seed, first_m, rate) in [
        ("C172 = 1", 1, 306.0, 8),
        ("C550 = 1, C172 = 1", 2, 316.0, 8),
        ("AT75 = 1, C550 = 1", 3, 318.0, 4),
    ] {
        let mut a = Drawn { turned_rad: 0.3, ..Drawn::default() };
        a.runway(0.0, 0.0, 2000.0, 0.0, ["09", "27"]);
        let mut before: Option<usize> = None;
        for (i, x) in [10.0, 800.0, 1990.0].into_iter().enumerate() {
            let (foot, top) = (a.node(x, 0.0), a.node(x, 180.0));
            a.edge(foot, top, false, &format!("E{i}"));
            if let Some(before) = before {
                a.edge(before, top, false, "A");
            }
            before = Some(top);
            if i == 1 {
                let mut lane = a.node(x, 300.0);
                a.edge(top, lane, false, "C");
                for k in 0..8 {
                    let x = x + 80.0 * (f64::from(k) + 1.0);
                    let next = a.node(x, 300.0);
                    a.edge(lane, next, false, "L");
                    lane = next;
                    a.stand(x, first_m + 2.0 * f64::from(k), &format!("S{k}"));
                }
            }
        }
        let keys = format!("arrivals_per_h = {rate}\ndepartures_per_h = {rate}\nmix = {{ {mix} }}");
        let held = held("short-lead-in", &a, seed, &keys);
        assert_eq!(held.broken(), Vec::<String>::new(), "{mix}");
        assert_eq!(held.core.measures_of_served(), held.core.flights().len(), "{mix}");
    }
}

/// A landing that leaves between two runways comes back over its own by the same group: its clearance to cross ended with the landing,
/// and at Flying Cloud five in an hour were on the runway without one.
#[test]
fn who_comes_back_over_the_runway_that_he_landed_on_is_cleared_for_it() {
    for (gap_m, seed) in [(180.0, 1), (200.0, 2), (215.0, 3)] {
        let mut a = Drawn { turned_rad: 1.1, ..Drawn::default() };
        a.runway(0.0, 0.0, 2600.0, 0.0, ["13R", "31L"]);
        a.runway(0.0, gap_m, 2600.0, gap_m, ["13L", "31R"]);
        // Off to the south at 1 750 m only; to the north leads a way into which no landing turns.
        let (between, taxi_y) = (60.0, gap_m + 180.0);
        let (off, south) = (a.node(1750.0, gap_m), a.node(1900.0, between));
        let (turn, back) = (a.node(2350.0, between), a.node(2350.0, gap_m));
        let (entry, first) = (a.node(10.0, gap_m), a.node(10.0, taxi_y));
        let (middle, last) = (a.node(1700.0, taxi_y), a.node(2230.0, taxi_y));
        let ways = [
            (off, south),
            (south, turn),
            (turn, back),
            (back, last),
            (last, middle),
            (middle, first),
            (first, entry),
        ];
        for (from, to) in ways {
            a.edge(from, to, false, "A");
        }
        a.apron(middle, (1700.0, taxi_y), 1.0, 10);
        let keys = "arrivals_per_h = 8\ndepartures_per_h = 4\narrival_runways = [\"13L\"]\n\
                    departure_runways = [\"13L\"]\nmix = { A320 = 1, C550 = 1 }";
        let held = held(&format!("comes-back-{gap_m}"), &a, seed, keys);
        let crossed =
            held.core.clearances().iter().filter(|c| c.kind == "CRO" && c.runway == "13L/31R");
        assert!(crossed.count() >= 5, "{gap_m} m: nobody comes back");
        assert_eq!(held.broken(), Vec::<String>::new(), "{gap_m} m");
    }
}

/// Landings on the near runway as often as they come, departures from the far one: at Seattle landings 165 s apart left nobody time to
/// cross between them, and departures stood for up to half an hour. Here they stood for 364 to 851 s at most.
#[test]
fn who_crosses_is_given_room_between_landings() {
    let mut most_s = Vec::new();
    for (gap_m, seed, arrivals, departures) in
        [(300.0, 4, 18, 10), (420.0, 1, 18, 10), (300.0, 4, 20, 12), (420.0, 4, 20, 12)]
    {
        let keys = format!(
            "arrivals_per_h = {arrivals}\ndepartures_per_h = {departures}\narrival_runways = [\"13L\"]\n\
             departure_runways = [\"31L\"]\nmix = {{ A320 = 1, B738 = 1 }}"
        );
        let airport =
            Drawn::parallel(gap_m, [10.0, 700.0, 1900.0, 2590.0], &[(0, 8), (1, 8), (2, 8)]);
        let held = held(&format!("room-to-cross-{gap_m}-{arrivals}"), &airport, seed, &keys);
        let core = &held.core;
        let departs = |f: &usize| core.flights()[*f].direction == Direction::Departure;
        let all = (0..core.flights().len()).filter(departs);
        most_s.push(all.map(|f| core.measures(f).stopped_s).fold(0.0, f64::max));
        let broken: Vec<String> =
            held.broken().into_iter().filter(|b| !b.starts_with("served")).collect();
        assert_eq!(broken, Vec::<String>::new(), "{gap_m} m, seed {seed}");
    }
    assert!(most_s.iter().sum::<f64>() < 4.0 * 450.0, "{most_s:?}");
    assert!(most_s.iter().all(|s| *s < 600.0), "{most_s:?}");
}

/// The first exit that one can brake for leads to the other side and back over the runway, where the next one lands; a little farther on
/// one leaves it at the side of the stands.
#[test]
fn a_landing_leaves_at_the_side_of_its_stand() {
    let mut a = Drawn { turned_rad: 2.6, ..Drawn::default() };
    a.runway(0.0, 0.0, 2600.0, 0.0, ["09", "27"]);
    let places = [10.0, 1900.0, 2590.0];
    let feet = places.map(|x| a.node(x, 0.0));
    let tops = places.map(|x| a.node(x, 200.0));
    for k in 0..3 {
        a.edge(feet[k], tops[k], false, &format!("E{k}"));
        if k > 0 {
            a.edge(tops[k - 1], tops[k], false, "A");
        }
    }
    a.apron(tops[1], (1900.0, 200.0), 1.0, 10);
    let (foot, first, last) = (a.node(1650.0, 0.0), a.node(1650.0, -200.0), a.node(2590.0, -200.0));
    a.edge(foot, first, false, "F");
    a.edge(first, last, false, "B");
    a.edge(last, feet[2], false, "G");
    for seed in 1..=2 {
        let keys = "arrivals_per_h = 14\ndepartures_per_h = 4\narrival_runways = [\"09\"]\n\
                    departure_runways = [\"09\"]\nmix = { A320 = 1, B738 = 1 }";
        let held = held("own-side", &a, seed, keys);
        let core = &held.core;
        let crossed = core.clearances().iter().filter(|c| c.kind == "CRO").count();
        assert_eq!(crossed, 0, "seed {seed}");
        assert_eq!(core.measures_of_served(), core.flights().len(), "seed {seed}");
        assert_eq!(held.broken(), Vec::<String>::new(), "seed {seed}");
    }
}

/// One way in the middle of the runway, and at both ends a loop to turn on, as the file has it: at Pichoy and three more of 54 airports
/// the loops were taken for entries, nobody backtracked, and nothing flew.
#[test]
fn who_has_loops_at_the_ends_of_the_runway_backtracks_to_them() {
    let mut a = Drawn { turned_rad: 1.1, ..Drawn::default() };
    a.runway(-1250.0, 0.0, 1250.0, 0.0, ["09", "27"]);
    let (foot, top) = (a.node(-140.0, 0.0), a.node(-140.0, 180.0));
    a.edge(foot, top, false, "N");
    a.apron(top, (-140.0, 180.0), 1.0, 6);
    for (side, beside) in [(-1.0, 40.0), (1.0, -45.0)] {
        let corners = [(1150.0, 0.0), (1165.0, 0.8), (1215.0, 1.0), (1240.0, 0.7), (1250.0, 0.0)];
        let nodes = corners.map(|(x, y)| a.node(side * x, y * beside));
        nodes.windows(2).for_each(|pair| a.edge(pair[0], pair[1], false, "N"));
    }
    for seed in 1..=2 {
        let held = held("loops", &a, seed, "arrivals_per_h = 5\ndepartures_per_h = 5");
        let core = &held.core;
        let (flights, served) = (core.flights().len(), core.measures_of_served());
        assert!(flights >= 6, "seed {seed}: {flights}");
        assert_eq!(served, flights, "seed {seed}");
        assert_eq!(held.broken(), Vec::<String>::new(), "seed {seed}");
        assert!(core.flights().iter().all(|f| f.size.span_m > 25.0), "seed {seed}: airliners");
    }
}
