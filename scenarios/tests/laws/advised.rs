//! Advice from what is seen, on airports that it was not made on: what it warns of would be, and nothing else.

use models::control::actors::sight::Waiting;
use models::control::advice::{Advice, Advisor, Change, Habits, Picture, What};
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::frames::Point2;
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::ahead::Known;
use models::traffic::core::Core;
use models::traffic::exact::Watch;
use std::collections::BTreeMap;
use std::path::Path;

fn scene(airport: &str, rate: u32, seed: u64) -> scenarios::Scene {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 2400\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\nsees = \"truth\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("advised.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

const AIRPORTS: [(&str, u32); 5] = [
    ("layout = \"airports/XSYN.apt.dat\"", 14),
    ("layout = \"airports/EGCC.nodes.csv\"", 20),
    ("layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"", 20),
    ("layout = \"airports/EHAM.apt.dat\"\nground_network = \"airports/EHAM.groundnet.xml\"", 30),
    ("layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"", 20),
];

/// An advice when it was given, and the truth of its two from then on until half a minute after its time.
struct Told {
    since_s: f64,
    advice: Advice,
    /// Time, place of either.
    truth: Vec<(f64, [Option<Point2<f64>>; 2])>,
}

fn told(airport: &str, rate: u32, seed: u64) -> (String, Core, Vec<Told>) {
    let scene = scene(airport, rate, seed);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let mut advisor = Advisor::new(Habits::default(), seed, Vec::new());
    let step_s = scene.run.frame.s();
    let mut all: Vec<Told> = Vec::new();
    for frame in 1..=scene.run.frames() as i64 {
        core.step(frame);
        if frame % 20 != 0 {
            continue;
        }
        let now = SimTime(frame * scene.run.frame.0);
        watch.scan(&core, now);
        let layout = watch.net().layout();
        let callsign = |flight: u32| Callsign::new(&core.flights()[flight as usize].callsign);
        let asked = core.wanted().into_iter().chain(core.could_be_cleared());
        let waiting: Vec<Waiting> = asked
            .map(|(wanted, runway)| Waiting {
                wanted,
                strip: watch.board().find(callsign(wanted.flight)).map(|i| i as u32),
                runway: layout.runway(&behaving.network.runways[runway].names[0]).map(|r| r.0),
            })
            .collect();
        let (board, surveillance) = (watch.board(), watch.net().surveillance());
        let picture = Picture {
            known: Known { board, surveillance, layout },
            network: &behaving.network,
            flights: core.flights(),
            waiting: &waiting,
            frame: (frame, step_s),
        };
        for change in advisor.scan(now.s(), &[], true, Some(&picture)) {
            if let Change::Given(advice) = change {
                all.push(Told { since_s: now.s(), advice, truth: Vec::new() });
            }
        }
        for told in all.iter_mut().filter(|t| now.s() <= t.advice.until_s + 30.0) {
            let at = |flight: u32| core.state(flight as usize).map(|s| s.position_m.xy());
            let two = [Some(told.advice.flight), told.advice.other].map(|f| f.and_then(at));
            told.truth.push((now.s(), two));
        }
    }
    (scene.airport.layout.name, core, all)
}

#[test]
fn what_is_advised_from_what_is_seen_is_so() {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (airport, rate) in AIRPORTS {
        for seed in [3, 4, 5] {
            let (name, core, all) = told(airport, rate, seed);
            let text = |t: &Told| format!("{name} seed {seed} at {:.0}: {:?}", t.since_s, t.advice);
            let mut apart = Vec::new();
            for t in &all {
                *kinds.entry(t.advice.kind().word()).or_default() += 1;
                let other = t.advice.other.map(|o| o as usize);
                match t.advice.what {
                    // Who is said to meet comes near, or one of the two is held before. Speeds change: 3 m for each second ahead.
                    What::ConflictAhead { meets_s, .. } => {
                        assert!((t.since_s..=t.since_s + 125.0).contains(&meets_s), "{}", text(t));
                        let most_m = 150.0 + 3.0 * (meets_s - t.since_s);
                        let near =
                            |two: &[Option<Point2<f64>>; 2]| Some((two[0]? - two[1]?).norm());
                        let distances = t.truth.iter().filter_map(|(_, two)| near(two));
                        let least_m = distances.fold(f64::INFINITY, f64::min);
                        let moved_m = |k: usize| {
                            t.truth
                                .windows(2)
                                .filter_map(move |w| Some((w[1].1[k]? - w[0].1[k]?).norm()))
                        };
                        let stood = |k: usize| moved_m(k).filter(|m| *m < 0.3).count() >= 3;
                        assert!(
                            least_m < most_m || stood(0) || stood(1),
                            "{}: {least_m:.0}",
                            text(t)
                        );
                        apart.push(least_m);
                    }
                    // Who lands behind an open gap lands when it is said; whoever uses it has its time.
                    What::Gap { open: true, lands_s, needs_s, .. } => {
                        let lands_s = lands_s.expect("somebody lands behind it");
                        assert!(lands_s - t.since_s >= needs_s, "{}", text(t));
                        let landed_s = other.and_then(|o| core.measures(o).aldt_s);
                        assert!(landed_s.is_none_or(|l| l > lands_s - 10.0), "{}", text(t));
                    }
                    What::Gap { opens_s, lands_s, needs_s, .. } => {
                        let enough = lands_s.is_none_or(|l| l - opens_s >= needs_s);
                        assert!(opens_s > t.since_s && enough, "{}", text(t));
                    }
                    // Who is said to be on the stand is there, and the other one is not sent onto somebody.
                    What::StandConflict { stand, instead, .. } => {
                        let other = other.expect("somebody is there");
                        assert_eq!(core.stand(other), stand, "{}", text(t));
                        assert_ne!(instead, Some(stand), "{}", text(t));
                        assert!(t.advice.value > 0.0, "{}", text(t));
                    }
                    What::HoldAtStand { .. } => panic!("nobody asks: {}", text(t)),
                }
            }
            apart.sort_by(f64::total_cmp);
            apart.sort_by(f64::total_cmp);
            println!("{name} seed {seed}: {} advices, meet at {apart:.0?}", all.len());
        }
    }
    assert!(kinds.len() == 3 && kinds.values().all(|n| *n >= 2), "{kinds:?}");
}
