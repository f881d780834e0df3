//! A person clears two to one runway: the pilots do it, the rules raise the alert, eyes keep the bodies apart, and traffic goes on.

use crate::touching::overlap;
use models::control::alert::Change;
use models::control::clearance::ClearanceKind::{self, Cross, Land, LineUp, TakeOff};
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::core::{ClearedBy, Core, Notice, Order, Phase};
use models::traffic::exact::Watch;
use std::collections::BTreeMap;
use std::path::Path;

fn scene(name: &str, ends: &str, rate: u32, seed: u32) -> scenarios::Scene {
    let airport = airport(name);
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n{ends}[control]\nsees = \"truth\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("incursions.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

fn airport(name: &str) -> String {
    let net = format!("airports/{name}.groundnet.xml");
    let there = Path::new(env!("CARGO_MANIFEST_DIR")).join(&net).exists();
    let net = if there { format!("\nground_network = \"{net}\"") } else { String::new() };
    format!("layout = \"airports/{name}.apt.dat\"{net}")
}

/// What a person said: when, to whom, what, and who had the runway.
#[derive(Clone, Debug)]
struct Said {
    at_s: f64,
    callsign: String,
    kind: ClearanceKind,
    against: String,
}

struct Flown {
    core: Core,
    said: Vec<Said>,
    /// When raised, kind, subjects.
    alerts: Vec<(f64, String, String)>,
    touched: Vec<String>,
}

/// What a person tries, at most every five minutes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Try {
    /// Onto a runway on which somebody has been cleared to land.
    Before(ClearanceKind),
    /// The same, and the roll when it is lined up.
    BeforeAndRoll,
    /// Lines somebody up ahead of an arrival that is not cleared yet, and clears that one to land.
    AndLand,
}

fn order(core: &mut Core, frame: i64, said: &mut Vec<Said>, one: Said) {
    let callsign = |f: &usize| core.flights()[*f].callsign == one.callsign;
    let flight = (0..core.flights().len()).find(callsign).expect("a flight");
    core.notice(Notice {
        effect_frame: frame + 1,
        source: "person".into(),
        sequence: said.len() as u64,
        flight,
        order: Order::told(one.kind, true),
    });
    said.push(one);
}

/// What is said now, if there is an occasion.
fn occasion(core: &Core, now_s: f64, tries: Try, said: &[Said]) -> Option<Said> {
    let name = |f: usize| core.flights()[f].callsign.clone();
    let all: Vec<_> = core.wanted().into_iter().chain(core.could_be_cleared()).collect();
    let can = |kind: ClearanceKind, runway: usize, not: usize| {
        let fits = |(w, r): &&(_, usize)| {
            let w: &models::control::actors::Wanted = w;
            w.kind == kind && *r == runway && w.flight as usize != not
        };
        all.iter().find(fits).map(|(w, _)| w.flight as usize)
    };
    let one = |flight: usize, kind: ClearanceKind, against: usize| {
        Some(Said { at_s: now_s, callsign: name(flight), kind, against: name(against) })
    };
    // What follows the last one.
    if let Some(last) = said.last().filter(|s| s.kind == LineUp && now_s < s.at_s + 90.0) {
        let of = |name: &str| core.flights().iter().position(|f| f.callsign == name).expect("one");
        let (lined_up, other) = (of(&last.callsign), of(&last.against));
        let then = match tries {
            Try::BeforeAndRoll => (lined_up, TakeOff, other),
            Try::AndLand => (other, Land, lined_up),
            Try::Before(_) => return None,
        };
        let fits = all.iter().any(|(w, _)| w.flight as usize == then.0 && w.kind == then.1);
        return one(then.0, then.1, then.2).filter(|_| fits);
    }
    if said.last().is_some_and(|s| now_s < s.at_s + 300.0) || !(300.0..3000.0).contains(&now_s) {
        return None;
    }
    let kind = if let Try::Before(kind) = tries { kind } else { LineUp };
    let cleared = core.clearances().iter().filter(|c| c.until_s.is_none() && c.kind == "LND");
    let lands: Vec<usize> = match tries {
        Try::AndLand => (0..core.flights().len())
            .filter(|f| all.iter().any(|(w, _)| w.flight as usize == *f && w.kind == Land))
            .filter(|f| core.state(*f).is_some_and(|s| s.position_m.z < 600.0))
            .collect(),
        _ => cleared.map(|c| c.flight).collect(),
    };
    // Who is over the threshold has passed who enters there: behind him one may line up.
    let comes = |f: &usize| core.state(*f).is_some_and(|s| s.position_m.z > 20.0);
    let lands = lands.into_iter().filter(|f| core.phase(*f) == Phase::Final && comes(f));
    lands.into_iter().find_map(|f| {
        let entered = can(kind, core.flights()[f].runway.0, f)?;
        one(entered, kind, f)
    })
}

/// An hour and what is left of it, with models at the seats and a person who errs.
fn flown(scene: &scenarios::Scene, tries: Try) -> Flown {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let (mut said, mut alerts, mut touched) = (Vec::new(), Vec::new(), Vec::new());
    for frame in 1..=scene.run.frames() as i64 + 54_000 {
        core.step(frame);
        let now = SimTime(frame * scene.run.frame.0);
        if frame % 20 == 0 {
            for (change, alert) in watch.scan(&core, now) {
                if *change == Change::Raised {
                    alerts.push((now.s(), alert.condition.kind.word(), alert.subjects()));
                }
            }
            if let Some(one) = occasion(&core, now.s(), tries, &said) {
                order(&mut core, frame, &mut said, one);
            }
        }
        if frame % 4 == 0 {
            touched.extend(overlap(&core).map(|who| format!("{:.1} s: {who}", now.s())));
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    Flown { core, said, alerts, touched }
}

/// Airports on whose ways nothing was tuned: wherever a person clears a second one onto a runway, both do it, the conflict is told of
/// these two within the readback's time, the movement too where it comes to that, nobody touches anybody, and all the rest are served.
#[test]
fn who_is_cleared_onto_a_runway_that_is_anothers_goes_there_and_the_alert_is_raised() {
    let (mut movements, mut conflicts) = (BTreeMap::new(), BTreeMap::new());
    // Runways on which one lands and which others cross to theirs.
    let eham = "arrival_runways = [\"36C\"]\ndeparture_runways = [\"36L\"]\n";
    let limc = "arrival_runways = [\"17R\"]\ndeparture_runways = [\"35R\"]\n";
    for (name, ends, seed, tries, least) in [
        ("XSYN", "", 3, Try::Before(LineUp), 4),
        ("LZIB", "", 3, Try::Before(LineUp), 4),
        ("EHAM", eham, 3, Try::Before(Cross), 3),
        ("LIMC", limc, 1, Try::Before(Cross), 1),
        ("XSYN", "", 3, Try::BeforeAndRoll, 6),
        ("LZIB", "", 3, Try::BeforeAndRoll, 6),
        ("XSYN", "", 3, Try::AndLand, 4),
        ("XSYN", "", 1, Try::AndLand, 4),
        ("LZIB", "", 3, Try::AndLand, 4),
    ] {
        let scene = scene(name, ends, 15, seed);
        let Flown { core, said, alerts, touched } = flown(&scene, tries);
        let case = format!("{name} {tries:?}");
        assert!(said.len() >= least, "{case}: {said:?}");
        for s in &said {
            let conflict = match (tries, s.kind) {
                (_, Cross) => "CATC_CRO_LND",
                // The model at the tower may have the one in the air in time.
                (Try::AndLand, _) => continue,
                (_, LineUp) => "CATC_LND_LUP",
                // Where the landing has been given up, nobody is left to conflict with.
                _ => continue,
            };
            let of = |who: &str| who.contains(&s.callsign) && who.contains(&s.against);
            // From when he acts upon it: where he still has a way to go to the line, that is when he comes there.
            let acts = core.clearances().iter().find(|c| {
                let own = core.flights()[c.flight].callsign == s.callsign;
                own && c.kind == s.kind.word() && c.from_s >= s.at_s
            });
            let acts_s = acts.map_or(s.at_s, |c| c.from_s);
            assert!(acts_s < s.at_s + 60.0, "{case}: {s:?} acts at {acts_s} s");
            let raised = alerts.iter().find(|(at_s, kind, who)| {
                kind == conflict && of(who) && (s.at_s..acts_s + 15.0).contains(at_s)
            });
            let rows = core.clearances().iter().map(|c| (c, &core.flights()[c.flight].callsign));
            let rows = rows.filter(|(_, who)| **who == s.callsign || **who == s.against);
            let rows: Vec<String> = rows
                .map(|(c, who)| {
                    format!("{who} {} {} {:.0} {:?}", c.kind, c.runway, c.from_s, c.until_s)
                })
                .collect();
            assert!(raised.is_some(), "{case}: {s:?}: {rows:?}");
            let moved = alerts.iter().find(|(at_s, kind, who)| {
                kind.starts_with("RMCA") && of(who) && (s.at_s..s.at_s + 60.0).contains(at_s)
            });
            if let Some((_, kind, _)) = moved {
                *movements.entry(kind.clone()).or_insert(0) += 1;
            }
        }
        if tries == Try::AndLand {
            let found = alerts.iter().filter(|a| a.1.starts_with("CATC_LND")).count();
            *conflicts.entry(name).or_insert(0) += found;
        }
        // Nobody else is told of; that somebody lined up for long waits says nothing of a conflict.
        for (at_s, kind, who) in alerts.iter().filter(|a| a.1 != "NOMOV") {
            let meant = |s: &Said| {
                (who.contains(&s.callsign) || who.contains(&s.against))
                    && (s.at_s..s.at_s + 300.0).contains(at_s)
            };
            assert!(said.iter().any(meant), "{case}: {at_s} {kind} {who}");
        }
        assert!(touched.is_empty(), "{case}: {touched:?}");
        assert!(!core.remarks().iter().any(|r| r.text.ends_with(" touch")), "{case}");
        assert_eq!(core.measures_of_served(), core.flights().len(), "{case}");
        assert_eq!(core.unexpected_deadlocks(), 0, "{case}");
    }
    assert!(conflicts.len() == 2 && conflicts.values().all(|n| *n >= 2), "{conflicts:?}");
    assert!(movements.get("RMCA_ARR").is_some_and(|n| *n >= 15), "{movements:?}");
}

/// Everything that is asked for is cleared but the take-off, and everybody who comes to the line of an occupied runway is lined up by a
/// person: a queue on the runway, in which only eyes keep bodies apart.
#[test]
fn who_lines_up_behind_somebody_stops_short_of_him() {
    for (name, seed, least) in [("XSYN", 3, 4), ("LZIB", 5, 4), ("EHAM", 7, 3)] {
        let scene = scene(name, "", 25, seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        // Nobody at the seats: a model would clear the take-off.
        let core = behaving.told_core(&scene.run, scene.run.seed).expect("with truth");
        let mut core = core.cleared_by(ClearedBy::Notices);
        let (mut sequence, mut touched) = (0, Vec::new());
        for frame in 1..=40_000 {
            core.step(frame);
            if frame % 20 == 0 {
                let asked = core.wanted().into_iter().map(|(w, _)| (w, false));
                let could = core.could_be_cleared().into_iter().map(|(w, _)| (w, true));
                let all: Vec<_> = asked.chain(could.filter(|(w, _)| w.kind == LineUp)).collect();
                for (w, by_person) in all.into_iter().filter(|(w, _)| w.kind != TakeOff) {
                    sequence += 1;
                    core.notice(Notice {
                        effect_frame: frame + 1,
                        source: "person".into(),
                        sequence,
                        flight: w.flight as usize,
                        order: Order::told(w.kind, by_person),
                    });
                }
            }
            if frame % 4 == 0 {
                touched.extend(overlap(&core).map(|who| format!("{} s: {who}", frame / 20)));
            }
        }
        let on_runway = |f: &usize| {
            let entered = core.clearances().iter().any(|c| c.flight == *f && c.kind == "LUP");
            entered && core.state(*f).is_some()
        };
        let queue = (0..core.flights().len()).filter(on_runway).count();
        assert!(queue >= least, "{name}: {queue} on runways");
        assert!(touched.is_empty(), "{name}: {touched:?}");
    }
}

/// The same words at the same frames, the same bits; and a clearance of a model is permission only.
#[test]
fn a_persons_word_is_an_input_like_any_other() {
    let scene = scene("XSYN", "", 15, 3);
    let [a, b] = [0, 1].map(|_| flown(&scene, Try::Before(LineUp)).core.digest());
    assert_eq!(a, b);
    assert_ne!(a, flown(&scene, Try::Before(Cross)).core.digest(), "XSYN has nothing to cross");
}
