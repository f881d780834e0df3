//! Controllers and pilots as models: everybody moves by what was said and read back, everybody is served, the same bits.

use models::control::actors::message::{MessageKind, Seat};
use models::control::actors::pilot::Habits;
use models::control::actors::{Actors, Wanted};
use models::control::clearance::ClearanceKind;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::core::{ClearedBy, Core, Direction, Flight, Notice, Order};
use models::traffic::exact::Watch;
use std::path::Path;

fn scene(airport: &str, rate: u32, seed: u32, control: &str) -> scenarios::Scene {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 2400\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\n{control}\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("controllers.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

const XSYN: &str = "layout = \"airports/XSYN.apt.dat\"";
const LIMC: &str =
    "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"";
const LSZH: &str =
    "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"";

/// The core after its scene and at most three quarters of an hour more, and the alerts that the rules raise on its truth.
fn flown(scene: &scenarios::Scene) -> (Core, Vec<String>) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let mut alerts = Vec::new();
    for frame in 1..=scene.run.frames() as i64 + 54_000 {
        core.step(frame);
        if frame % 20 == 0 {
            let now = SimTime(frame * scene.run.frame.0);
            for (change, alert) in watch.scan(&core, now) {
                let kind = alert.condition.kind.word();
                alerts.push(format!("{:.0} {change:?} {kind} {}", now.s(), alert.subjects()));
            }
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    (core, alerts)
}

fn additional_s(core: &Core) -> f64 {
    let of = |f: usize| core.measures(f).additional_s();
    (0..core.flights().len()).filter_map(of).sum::<f64>() / core.flights().len() as f64
}

#[test]
fn everybody_moves_by_what_was_read_back_and_everybody_is_served() {
    for (airport, rate, seed) in [(XSYN, 12, 3), (LIMC, 8, 4), (LSZH, 10, 5)] {
        let by_plan = flown(&scene(airport, rate, seed, "sees = \"none\"")).0;
        let (core, alerts) = flown(&scene(airport, rate, seed, "sees = \"truth\""));
        let name = format!("{airport}, seed {seed}");
        let waiting: Vec<_> = (0..core.flights().len()).filter_map(|f| core.waiting(f)).collect();
        assert_eq!(core.measures_of_served(), core.flights().len(), "{name}: {waiting:?}");
        assert_eq!(core.unexpected_deadlocks(), 0, "{name}");
        let actors = core.actors().expect("controllers");
        let step_s = 0.05;
        for c in core.clearances().iter().filter(|c| c.kind != "GOA") {
            // What an arrival is told at its exit, its way to the stand, is part of its landing.
            let arrives = core.measures(c.flight).aldt_s.is_some();
            if arrives && c.kind == "TAX" {
                continue;
            }
            let kind = ClearanceKind::of(c.kind).expect("a word");
            let read = actors.messages().filter(|m| {
                m.from == Seat::Flight(c.flight as u32)
                    && m.kind == MessageKind::Readback
                    && m.body == kind
                    && m.at_frame as f64 * step_s <= c.from_s
            });
            let same = |o: &&models::traffic::core::Clearance| {
                o.flight == c.flight && o.kind == c.kind && o.from_s <= c.from_s
            };
            let read = read.count() >= core.clearances().iter().filter(same).count();
            assert!(read, "{name}: {c:?} was not read back");
            assert_ne!(core.seat_of(c), "plan");
        }
        // What people cost: waiting for words, not for ever.
        let (plan_s, people_s) = (additional_s(&by_plan), additional_s(&core));
        assert!(people_s < plan_s + 150.0, "{name}: {plan_s:.0} s by plan, {people_s:.0} s");
        assert!(alerts.is_empty(), "{name}: {alerts:?}");
        let most = actors.samples().iter().map(|s| s.busy).fold(0.0, f64::max);
        assert!(most > 0.05 && most <= 1.0 + 1e-9, "{name}: {most}");
    }
}

/// One whom nobody clears to push stands on his stand for half an hour, and keeps nobody else waiting; then he goes, too.
#[test]
fn who_is_not_cleared_to_push_keeps_nobody_waiting_behind_his_plan() {
    for (airport, rate, seed) in [(XSYN, 12, 3), (LIMC, 10, 4), (LSZH, 10, 5)] {
        let scene = scene(airport, rate, seed, "sees = \"truth\"");
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let core = behaving.told_core(&scene.run, seed.into()).expect("with truth");
        let mut core = core.cleared_by(ClearedBy::Notices);
        let mut actors = Actors::new(Habits::default(), seed.into(), 0.05);
        let departs = |f: &Flight| f.direction == Direction::Departure;
        let first = core.flights().iter().position(departs).expect("a departure");
        let (held_until_s, mut told) = (core.flights()[first].time_s + 1800.0, 0);
        let mut served_by_s = vec![0.0; core.flights().len()];
        for frame in 1..=90_000_i64 {
            core.step(frame);
            if frame % 20 != 0 {
                continue;
            }
            let now_s = frame as f64 * 0.05;
            for (flight, at_s) in served_by_s.iter_mut().enumerate() {
                let m = core.measures(flight);
                if *at_s == 0.0 && (m.atot_s.is_some() || m.aibt_s.is_some()) {
                    *at_s = now_s;
                }
            }
            let wanted: Vec<Wanted> = core.wanted().into_iter().map(|(w, _)| w).collect();
            let held = |w: &Wanted| w.flight as usize == first && now_s < held_until_s;
            let may: Vec<bool> = wanted.iter().map(|w| !held(w)).collect();
            for given in actors.scan_seen(now_s, &wanted, &may) {
                told += 1;
                core.notice(Notice {
                    effect_frame: (given.acts_s / 0.05).ceil() as i64,
                    source: given.seat.name(),
                    sequence: told,
                    flight: given.flight as usize,
                    order: Order::told(given.kind, false),
                });
            }
        }
        let name = format!("{airport}, seed {seed}");
        let out_s = core.measures(first).aobt_s.expect("pushed at last");
        assert!((held_until_s..held_until_s + 300.0).contains(&out_s), "{name}: {out_s}");
        for (flight, f) in core.flights().iter().enumerate().filter(|(at, _)| *at != first) {
            let waited_s = served_by_s[flight] - f.time_s;
            assert!(
                served_by_s[flight] > 0.0 && waited_s < 1500.0,
                "{name}: {} {waited_s}",
                f.callsign
            );
        }
        assert!(served_by_s[first] > 0.0, "{name}");
        assert_eq!(core.unexpected_deadlocks(), 0, "{name}");
    }
}

#[test]
fn controllers_give_the_same_bits_again_and_others_than_the_plan() {
    let by = |control: &str| {
        let scene = scene(XSYN, 12, 6, control);
        let mut core = scene
            .traffic
            .behaving
            .as_ref()
            .expect("behaves")
            .core(&scene.run, 6)
            .expect("with truth");
        (1..=30_000).for_each(|frame| core.step(frame));
        core.digest()
    };
    assert_eq!(by("sees = \"truth\""), by("sees = \"truth\""));
    assert_ne!(by("sees = \"truth\""), by("sees = \"none\""));
}

/// Errors are drawn by flight: a larger factor keeps those of a smaller one, and their number is that of the rates.
#[test]
fn errors_of_people_come_by_their_rates() {
    let shown = |errors: f64| {
        let control = format!("sees = \"none\"\nerrors = {errors}");
        let mut ids = Vec::new();
        for seed in 1..=4 {
            let core = flown(&scene(LIMC, 10, seed, &control)).0;
            ids.extend(core.shown().iter().map(|s| format!("{seed} {}", s.id)));
        }
        ids
    };
    let (none, some, many) = (shown(0.0), shown(100.0), shown(200.0));
    assert!(none.is_empty());
    assert!(some.iter().filter(|id| !many.contains(id)).count() <= 1, "{some:?} {many:?}");
    // 40 departures at 0.2 and 0.4 for no_reply, 0.01 and 0.02 for pass_hold; arrivals 0.1 and 0.2 for wrong turns.
    let of = |all: &[String]| all.iter().filter(|i| i.contains("no_reply")).count();
    assert!((2..=16).contains(&of(&some)) && (6..=28).contains(&of(&many)), "{some:?} {many:?}");
}
