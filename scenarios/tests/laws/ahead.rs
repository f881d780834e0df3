//! Looking ahead from perceived truth: what it foresees against what comes.

use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::ahead::{Airport, Change, Known, Moment, perceive};
use models::traffic::core::{Core, Direction, Phase, Seen};
use models::traffic::exact::Watch;
use std::path::Path;
use std::sync::Arc;

fn scene(airport: &str, rate: u32, seed: u64) -> scenarios::Scene {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 2400\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\nsees = \"none\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("ahead.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

/// The core at a time, what a safety net on its truth knows then, and the airport.
fn seen_at(scene: &scenarios::Scene, seed: u64, at_s: f64) -> (Core, Moment, Airport) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let step_s = scene.run.frame.s();
    let frames = (at_s / step_s).round() as i64;
    for frame in 1..=frames {
        core.step(frame);
        if frame % 20 == 0 {
            watch.scan(&core, SimTime(frame * scene.run.frame.0));
        }
    }
    let network = Arc::clone(&behaving.network);
    let flights = Arc::new(core.flights().to_vec());
    let known = Known {
        board: watch.board(),
        surveillance: watch.net().surveillance(),
        layout: watch.net().layout(),
    };
    let moment = perceive(known, &network, &flights, (frames, step_s), 99);
    (core, moment, Airport::new(network, flights))
}

const XSYN: &str = "layout = \"airports/XSYN.apt.dat\"";
const EGCC: &str = "layout = \"airports/EGCC.nodes.csv\"";
const EHAM: &str =
    "layout = \"airports/EHAM.apt.dat\"\nground_network = \"airports/EHAM.groundnet.xml\"";
const LIMC: &str =
    "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"";
const LSZH: &str =
    "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"";

/// A change that changes nothing.
fn none(moment: &Moment, airport: &Airport) -> Change {
    let hold = |m: usize| Change::Hold { flight: m as u32, for_s: 0.0 };
    (0..moment.seen.len())
        .map(hold)
        .find(|c| moment.can(&airport.network, &airport.flights, *c).is_ok())
        .expect("a flight")
}

fn end_s(core: &Core, m: usize) -> Option<f64> {
    match core.flights()[m].direction {
        Direction::Departure => core.measures(m).atot_s,
        Direction::Arrival => core.measures(m).aibt_s,
        Direction::Vehicle => None,
    }
}

#[test]
fn everybody_is_found_where_he_is_and_what_is_foreseen_comes() {
    let mut all = Vec::new();
    for (airport, rate) in [(XSYN, 12), (EGCC, 18), (LSZH, 20), (EHAM, 30), (LIMC, 20)] {
        for seed in [5, 6, 7] {
            let scene = scene(airport, rate, seed);
            for at_s in [900.0, 1300.0] {
                let (mut core, moment, airport) = seen_at(&scene, seed, at_s);
                let name = format!("{} seed {seed} at {at_s}", scene.airport.layout.name);
                let mut wrong = Vec::new();
                for (m, seen) in moment.seen.iter().enumerate() {
                    let phase = core.phase(m);
                    let right = match seen {
                        Seen::Planned => {
                            matches!(phase, Phase::Absent | Phase::Parked | Phase::Final)
                        }
                        Seen::Gone => matches!(phase, Phase::Gone | Phase::Rolling),
                        Seen::OnStand(_) => matches!(
                            phase,
                            Phase::Parked | Phase::Pushing | Phase::Docked | Phase::Absent
                        ),
                        Seen::Taxiing(_) => matches!(
                            phase,
                            Phase::Pushing | Phase::Starting(_) | Phase::Taxiing | Phase::Landing
                        ),
                        // Who lands is on it to a controller when he is over the threshold, 15 m high.
                        Seen::OnRunway(_) if phase == Phase::Final => {
                            core.state(m).is_some_and(|s| s.position_m.z < 16.0)
                        }
                        Seen::OnRunway(_) => matches!(
                            phase,
                            Phase::LinedUp(_) | Phase::Rolling | Phase::Landing | Phase::Taxiing
                        ),
                        Seen::OnFinal { .. } => phase == Phase::Final || phase == Phase::GoAround,
                    };
                    if !right {
                        wrong.push(format!("{} {phase:?} {seen:.60?}", core.flights()[m].callsign));
                    }
                }
                assert!(wrong.is_empty(), "{name}: {wrong:?}");
                assert!(moment.unseen.is_empty(), "{name}: {:?}", moment.unseen);
                let answer = moment.what_if(&airport, none(&moment, &airport)).expect("a flight");
                assert_eq!(answer.with, answer.without, "{name}: nothing was changed");
                assert_eq!(answer.moved().count(), 0, "{name}");
                (1..=18_000).for_each(|k| core.step(moment.frame + k));
                let under_way =
                    |m: &usize| !matches!(moment.seen[*m], Seen::Planned | Seen::OnStand(_));
                let mut errors: Vec<f64> = (0..moment.seen.len())
                    .filter(under_way)
                    .filter_map(|m| {
                        let came_s = end_s(&core, m).filter(|t| *t > at_s)?;
                        let foreseen_s = answer.without.ends_s[m].unwrap_or(at_s + 1800.0);
                        Some((foreseen_s - came_s).abs())
                    })
                    .collect();
                errors.sort_by(f64::total_cmp);
                // Measured here: medians of 0 to 217 s, 31 s over all; one of 184 under way left out.
                let middle = |k: usize| errors.get(k).copied().unwrap_or(0.0);
                let median_s =
                    0.5 * (middle(errors.len() / 2) + middle(errors.len().saturating_sub(1) / 2));
                assert!(median_s < 240.0, "{name}: {errors:.0?}");
                assert!(answer.left_out.len() <= 1, "{name}: {:?}", answer.left_out);
                all.extend(errors);
            }
        }
    }
    all.sort_by(f64::total_cmp);
    let (half_s, most_s) = (all[all.len() / 2], all[all.len() * 9 / 10]);
    println!("{} flights under way: median {half_s:.0} s, 90 % within {most_s:.0} s", all.len());
    assert!(half_s < 60.0 && most_s < 240.0, "{all:.0?}");
}

#[test]
fn a_change_tells_who_gains_and_who_loses_by_it() {
    let (mut looked, mut turned) = (0, 0);
    for (airport, rate, seed) in [(XSYN, 12, 8), (EGCC, 18, 9), (LIMC, 20, 10), (EHAM, 20, 11)] {
        let scene = scene(airport, rate, seed);
        let (core, moment, airport) = seen_at(&scene, seed, 1000.0);
        let name = &scene.airport.layout.name;
        let flights = Arc::clone(&airport.flights);
        let of = |direction: Direction| {
            let flights = &flights;
            let own = move |m: &usize| flights[*m].direction == direction;
            (0..flights.len()).filter(own)
        };
        // Held at its stand for five minutes, a departure takes off later by about that, or later than is looked ahead.
        let due = |m: &usize| {
            matches!(moment.seen[*m], Seen::OnStand(_)) && airport.flights[*m].time_s < 1300.0
        };
        let held = of(Direction::Departure).find(due).expect("a departure that is due");
        let change = Change::Hold { flight: held as u32, for_s: 300.0 };
        let answer = moment.what_if(&airport, change).expect("can be held");
        let at_stand_s = airport.flights[held].time_s.max(1000.0);
        let (without, with) = (answer.without.ends_s[held], answer.with.ends_s[held]);
        assert!(without.is_none_or(|w| w > at_stand_s + 120.0), "{name}: {without:?}");
        assert!(with.is_none_or(|w| w > at_stand_s + 420.0), "{name}: {with:?}");
        assert!(without.is_some() || with.is_none(), "{name}: {without:?} {with:?}");
        if let (Some(without), Some(with)) = (without, with) {
            assert!((0.0..600.0).contains(&(with - without)), "{name}: {without} {with}");
            assert!(answer.moved().any(|(m, ..)| m == held), "{name}");
        }
        let sum = |ends: &[Option<f64>]| ends.iter().flatten().count();
        let [a, b] = [&answer.without, &answer.with];
        for ahead in [a, b] {
            let m = &ahead.measures;
            assert_eq!(m[0] + m[2], sum(&ahead.ends_s) as f64, "{name}: {m:?}");
            assert!(m.iter().all(|x| x.is_finite() && *x >= 0.0) && m[7] > 0.0, "{name}: {m:?}");
        }
        // Not held without a reason, and only what can be.
        let refused = |change: Change| moment.what_if(&airport, change).expect_err("refused");
        let stand = |flight: usize, stand: usize| Change::Stand { flight: flight as u32, stand };
        assert!(refused(stand(held, 0)).contains("only an arrival"), "{name}");
        assert!(refused(stand(usize::MAX >> 40, 0)).contains("not a flight"), "{name}");
        let long = Change::Hold { flight: held as u32, for_s: 1e6 };
        assert!(refused(long).contains("0 to 900 s"), "{name}");
        let runway = Change::Runway { flight: held as u32, runway: (99, 0) };
        assert!(refused(runway).contains("no such runway"), "{name}");
        let as_it_is = moment.what_if(&airport, none(&moment, &airport)).expect("nothing").without;
        // A departure that goes to the other end of its runway takes off at another time.
        let leaves = |m: &usize| {
            matches!(moment.seen[*m], Seen::OnStand(_)) && as_it_is.ends_s[*m].is_some()
        };
        if let Some(leaves) = of(Direction::Departure).find(leaves) {
            let (r, end) = airport.flights[leaves].runway;
            let other_end = Change::Runway { flight: leaves as u32, runway: (r, 1 - end) };
            let answer = moment.what_if(&airport, other_end).expect("both ends are used");
            let moved = answer.moved().find(|(m, ..)| *m == leaves);
            assert!(moved.is_some(), "{name}: {:?}", answer.with.ends_s[leaves]);
            turned += 1;
        }
        // An arrival that has not landed goes to a stand far away that it can use: it is there at another time. (Two of the farthest may
        // be as far from its exit as its own.)
        let comes = |m: &usize| {
            core.phase(*m) == Phase::Absent && as_it_is.ends_s[*m].is_some_and(|s| s < 1800.0)
        };
        let Some(coming) = of(Direction::Arrival).find(comes) else { continue };
        let stands = &airport.network.stands;
        let away_m =
            |s: &usize| (stands[*s].at_m - stands[airport.flights[coming].stand].at_m).norm();
        let taken = |s: usize| moment.seen.contains(&Seen::OnStand(s));
        let can = |s: &usize| {
            moment.can(&airport.network, &airport.flights, stand(coming, *s)).is_ok() && !taken(*s)
        };
        let mut all: Vec<usize> = (0..stands.len()).filter(can).collect();
        all.sort_by(|a, b| away_m(b).total_cmp(&away_m(a)));
        let moves = |far: &usize| {
            let answer = moment.what_if(&airport, stand(coming, *far)).expect("can be given");
            answer.moved().any(|(m, ..)| m == coming)
        };
        let far = &all[..3];
        assert!(far.iter().any(moves), "{name}: {:.0} m away", away_m(&far[0]));
        looked += 1;
    }
    assert!(looked >= 2 && turned >= 2, "{looked} arrivals, {turned} departures");
}

#[test]
fn the_same_moment_gives_the_same_answer() {
    let scene = scene(XSYN, 14, 11);
    let (_, moment, airport) = seen_at(&scene, 11, 1100.0);
    let change = none(&moment, &airport);
    assert_eq!(moment.what_if(&airport, change), moment.what_if(&airport, change));
    // Nobody is known: all that the plans say is foreseen, and nobody is seen on the ground.
    let empty = Moment { seen: vec![Seen::Planned; moment.seen.len()], ..moment };
    let answer = empty.what_if(&airport, none(&empty, &airport)).expect("a flight");
    assert!(answer.left_out.is_empty());
}

/// Who is held on his stand is late by that: the time from when he was wanted, not from when he was held until, so that holding cost nothing.
#[test]
fn a_hold_on_a_stand_is_counted_as_what_it_costs() {
    let mut tried = 0;
    for (airport, rate) in [(XSYN, 12), (LSZH, 20)] {
        for seed in [5, 6, 7] {
            let scene = scene(airport, rate, seed);
            let (_, moment, airport) = seen_at(&scene, seed, 900.0);
            for (m, seen) in moment.seen.iter().enumerate() {
                let f = &airport.flights[m];
                let waits = f.direction == Direction::Departure && matches!(seen, Seen::OnStand(_));
                let change = Change::Hold { flight: m as u32, for_s: 120.0 };
                let Ok(answer) = moment.what_if(&airport, change) else { continue };
                let ends = [&answer.with, &answer.without].map(|a| a.ends_s[m]);
                let [Some(with), Some(without)] = ends else { continue };
                if !waits || with - without < 60.0 {
                    continue;
                }
                tried += 1;
                let departs = |o: &usize| airport.flights[*o].direction == Direction::Departure;
                let later = |o: usize| {
                    let of = |a: &models::traffic::ahead::Ahead| a.ends_s[o].unwrap_or(1800.0);
                    of(&answer.with) - of(&answer.without)
                };
                let came: f64 = (0..airport.flights.len()).filter(departs).map(later).sum();
                let told = answer.with.measures[3] - answer.without.measures[3];
                assert!((told - came).abs() < 1.0, "{}: {told} s told, {came} s came", f.callsign);
            }
        }
    }
    assert!(tried >= 2, "{tried}");
}
