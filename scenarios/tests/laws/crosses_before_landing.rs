//! A person clears somebody to cross a runway on which one lands within seconds: he goes, the rules say so, and the two do not touch.

use crate::touching::overlap;
use models::control::alert::Change;
use models::control::clearance::ClearanceKind::Cross;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::core::{Core, Notice, Order, Phase};
use models::traffic::exact::Watch;
use std::path::Path;

fn scene(name: &str, ends: &str, seed: u64) -> scenarios::Scene {
    let net = format!("airports/{name}.groundnet.xml");
    let there = Path::new(env!("CARGO_MANIFEST_DIR")).join(&net).exists();
    let net = if there { format!("\nground_network = \"{net}\"") } else { String::new() };
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"airports/{name}.apt.dat\"{net}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 15\ndepartures_per_h = 15\n{ends}[control]\nsees = \"truth\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("crosses.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

/// What a person has said, and what came of it.
#[derive(Debug, Default)]
struct Flown {
    /// When, who was to cross, before whom.
    said: Vec<(f64, String, String)>,
    conflicts: usize,
    incursions: usize,
    touched: Vec<String>,
    unserved: usize,
    deadlocks: u64,
}

/// Who may be told to cross now, and the arrival that is cleared to land on that runway in `lead_s`.
fn occasion(core: &Core, lead_s: f64) -> Option<(usize, usize)> {
    let all = core.wanted().into_iter().chain(core.could_be_cleared());
    let crossing: Vec<(usize, usize)> =
        all.filter(|(w, _)| w.kind == Cross).map(|(w, r)| (w.flight as usize, r)).collect();
    let lands_s = |f: usize| {
        let (r, end) = core.flights()[f].runway;
        let cleared = |c: &models::traffic::core::Clearance| {
            c.flight == f && c.kind == "LND" && c.until_s.is_none()
        };
        let state = core.state(f).filter(|_| core.phase(f) == Phase::Final)?;
        let to_m = (core.network().runways[r].ends_m[end] - state.position_m.xy()).norm();
        core.clearances().iter().any(cleared).then(|| to_m / state.velocity_mps.norm().max(1.0))
    };
    crossing.into_iter().find_map(|(f, r)| {
        let near = |o: &usize| {
            let to_s = lands_s(*o).filter(|_| *o != f && core.flights()[*o].runway.0 == r);
            to_s.is_some_and(|s| (lead_s - 1.0..lead_s).contains(&s))
        };
        (0..core.flights().len()).find(near).map(|o| (f, o))
    })
}

/// An hour and what is left of it; at most every two minutes somebody is told to cross when another lands in `lead_s`.
fn flown(scene: &scenarios::Scene, lead_s: f64) -> Flown {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let mut flown = Flown::default();
    for frame in 1..=scene.run.frames() as i64 + 54_000 {
        core.step(frame);
        let now = SimTime(frame * scene.run.frame.0);
        if frame % 20 == 0 {
            for (change, alert) in watch.scan(&core, now) {
                let (kind, who) = (alert.condition.kind.word(), alert.subjects());
                let just = flown.said.iter().any(|(at_s, a, b)| {
                    (*at_s..at_s + 60.0).contains(&now.s()) && who.contains(a) && who.contains(b)
                });
                if *change == Change::Raised && just {
                    flown.conflicts += usize::from(kind == "CATC_CRO_LND");
                    flown.incursions += usize::from(kind == "RMCA_ARR" || kind == "RMCA_ROLL");
                }
            }
            let free = flown.said.last().is_none_or(|s| now.s() >= s.0 + 120.0);
            if let Some((flight, lands)) = occasion(&core, lead_s).filter(|_| free) {
                core.notice(Notice {
                    effect_frame: frame + 1,
                    source: "person".into(),
                    sequence: flown.said.len() as u64,
                    flight,
                    order: Order::told(Cross, true),
                });
                let name = |f: usize| core.flights()[f].callsign.clone();
                flown.said.push((now.s(), name(flight), name(lands)));
            }
        }
        if frame % 4 == 0 {
            flown.touched.extend(overlap(&core).map(|who| format!("{:.1} s: {who}", now.s())));
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    flown.unserved = core.flights().len() - core.measures_of_served();
    flown.deadlocks = core.unexpected_deadlocks();
    flown
}

/// At Milan one who was told to cross 35L late stopped on it before the one who landed, and they touched: he saw no farther along the runway than twelve
/// seconds. Runways on which one lands and which others cross to theirs; words that count from four seconds to half a minute before.
#[test]
fn who_is_told_to_cross_before_a_landing_goes_and_touches_nobody() {
    let over = |lands: &str, departs: &str| {
        format!("arrival_runways = [\"{lands}\"]\ndeparture_runways = [\"{departs}\"]\n")
    };
    let (mut said, mut incursions) = (0, 0);
    for (name, ends, seed) in [
        ("LIMC", over("35L", "35R"), 1),
        ("LIMC", over("35L", "35R"), 2),
        ("LIMC", over("17R", "35R"), 3),
        ("EHAM", over("36C", "36L"), 1),
    ] {
        let scene = scene(name, &ends, seed);
        for lead_s in [4.0, 8.0, 14.0, 30.0] {
            let flown = flown(&scene, lead_s);
            let case = format!("{name} {ends} seed {seed}, {lead_s} s");
            assert!(flown.touched.is_empty(), "{case}: {flown:?}");
            assert_eq!(flown.conflicts, flown.said.len(), "{case}: {flown:?}");
            assert_eq!((flown.unserved, flown.deadlocks), (0, 0), "{case}: {flown:?}");
            said += flown.said.len();
            incursions += flown.incursions;
        }
    }
    // He has crossed his line in most of them, and the rules say so.
    assert!(said >= 40 && 10 * incursions >= 8 * said, "{incursions} of {said}");
}
