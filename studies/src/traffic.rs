//! `seeds accuracy --only traffic`: what each form of a mover's motion, of ways, of sequences and of policies costs, and how far
//! off the cheaper ones are.
//!
//! One scene a task, each with a unit of its own; the reference is the most exact form, or a numerical solution of the same law.

use crate::chart::duration;
use crate::effects_common::{between, pick};
use crate::measure::{BLOCK, Errors, timed};
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout, clock};
use models::control::departure_sequence::{Departure, Recat, Rules, Sequence, best, in_order};
use models::draw::{DrawKey, Purpose, uniform};
use models::traffic::profile::{Leg, leg_profile};
use models::traffic::runway_roll::{TakeOff, take_off_run};
use models::traffic::tractrix::{slip_on_arc_rad, slip_on_straight_rad, stepped_slip_rad};
use models::traffic::ways::{Graph, TurnTime, Way};
use rand::rngs::ChaCha8Rng;
use scenarios::Scene;
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

/// Name of the group.
pub const GROUP: &str = "traffic";

const SCENES: [(&str, &str); 6] = [
    ("along", "legs from stop to stop, 60 to 1500 m, up to 5.1, 10 or 15.4 m/s: time of a leg"),
    (
        "across",
        "arcs of 30 to 90 m and the straight after them, wheelbases of 10.8 to 31.2 m: heading of the body",
    ),
    (
        "take_off",
        "runs at densities of 0.85 to 1.05 and winds of -3 to 12 m/s: time to lift-off; spool-up of 5 s",
    ),
    (
        "ways",
        "pairs of nodes of Zurich, Milano and Amsterdam: time to drive the way, beyond the best of eight",
    ),
    (
        "sequence",
        "eight departures of mixed wake that are ready within five minutes: delay of a flight beyond the best order",
    ),
    (
        "policy",
        "half an hour of traffic of XSYN and Bratislava: time from the demand to take-off or stand beyond the best policy's",
    ),
];

const ABOUT: &str = "Each scene is one task of the traffic in its cheap, middle and exact form, on draws of the seed. The time is that \
of one leg, one heading, one take-off, one way, one sequence, and for policies of a mover from its begin to its end, its planning \
included. A policy fails where somebody is not served an hour after the end of the demand. The movers drive with jerk and \
step their heading frame by frame; their lateral wander is not in it.";

/// A draw of its own for each case of each task.
fn draws(options: &Options, task: u32, case: usize) -> ChaCha8Rng {
    DrawKey { run_seed: options.seed, sensor: 0, entity: u64::from(task), scan: case as u64 }
        .rng(Purpose::Study)
}

fn row(scene: &str, rung: &str, error: Option<f64>, unit: &str, ns: Option<f64>) -> Row {
    Row {
        group: GROUP.into(),
        scene: scene.into(),
        rung: rung.into(),
        error,
        error_unit: Some(unit.into()),
        ns_per_update: ns,
        ..Row::default()
    }
}

/// A rung as a function of a case.
type Form<T> = (&'static str, fn(&T) -> f64);

/// Rungs that give one number for a case, against the reference.
fn numbers<T>(
    scene: &str,
    unit: &str,
    cases: &[T],
    reference: impl Fn(&T) -> f64,
    rungs: &[Form<T>],
    blocks: usize,
) -> Vec<Row> {
    let exact: Vec<f64> = cases.iter().map(reference).collect();
    let of = |(name, form): &Form<T>| {
        let mut errors = Errors::default();
        cases.iter().zip(&exact).for_each(|(case, e)| errors.add((form(case) - e).abs()));
        let (ns, _) = timed(blocks, |k| {
            black_box(form(black_box(&cases[k % cases.len()])));
        });
        row(scene, name, errors.rms(), unit, ns)
    };
    rungs.iter().map(of).collect()
}

fn leg_time_s(leg: &Leg, jerk_mps3: Option<f64>) -> f64 {
    leg_profile(&Leg { jerk_mps3, ..*leg }).map_or(f64::NAN, |p| p.time_s)
}

/// Jerk of a taxiing aircraft, m/s³.
const JERK_MPS3: f64 = 0.6;

fn along(options: &Options, blocks: usize) -> Vec<Row> {
    let leg = |case: usize| {
        let mut rng = draws(options, 1, case);
        let length_m = 60.0 * libm::pow(25.0, uniform(&mut rng));
        let vmax_mps = pick(&mut rng, &[5.1, 10.0, 15.4]);
        let (acc_mps2, dec_mps2) = (0.7, 0.7);
        Leg { length_m, v0_mps: 0.0, v1_mps: 0.0, vmax_mps, acc_mps2, dec_mps2, jerk_mps3: None }
    };
    let cases: Vec<Leg> = (0..BLOCK).map(leg).collect();
    let exact = |leg: &Leg| leg_time_s(leg, Some(JERK_MPS3));
    let rungs: [Form<Leg>; 3] = [
        ("constant speed", |leg| leg.length_m / leg.vmax_mps),
        ("acceleration", |leg| leg_time_s(leg, None)),
        ("jerk", |leg| leg_time_s(leg, Some(JERK_MPS3))),
    ];
    numbers("along", "s of a leg", &cases, exact, &rungs, blocks)
}

/// A place on an arc and the straight behind it.
struct Turn {
    radius_m: f64,
    wheelbase_m: f64,
    arc_m: f64,
    place_m: f64,
}

impl Turn {
    fn stepped(&self, step_m: f64) -> f64 {
        let (mut slip, mut at) = (0.0, 0.0);
        while at < self.place_m {
            let end = if at < self.arc_m { self.arc_m.min(self.place_m) } else { self.place_m };
            let curvature = if at < self.arc_m { 1.0 / self.radius_m } else { 0.0 };
            let ds = step_m.min(end - at);
            slip = stepped_slip_rad(slip, curvature, ds, self.wheelbase_m);
            at += ds.max(1e-9);
        }
        slip.to_degrees()
    }

    fn closed(&self) -> f64 {
        let on_arc = slip_on_arc_rad(self.place_m.min(self.arc_m), self.radius_m, self.wheelbase_m);
        let behind_m = (self.place_m - self.arc_m).max(0.0);
        slip_on_straight_rad(on_arc, behind_m, self.wheelbase_m).to_degrees()
    }
}

fn across(options: &Options, blocks: usize) -> Vec<Row> {
    let turn = |case: usize| {
        let mut rng = draws(options, 2, case);
        let wheelbase_m = pick(&mut rng, &[10.8, 12.6, 15.6, 25.4, 31.2]);
        let radius_m = between(&mut rng, f64::max(30.0, 1.2 * wheelbase_m), 90.0);
        let arc_m = radius_m * FRAC_PI_2 * between(&mut rng, 0.3, 1.0);
        Turn { radius_m, wheelbase_m, arc_m, place_m: (arc_m + 60.0) * uniform(&mut rng) }
    };
    let cases: Vec<Turn> = (0..BLOCK).map(turn).collect();
    let rungs: [Form<Turn>; 4] = [
        ("tangent", |_| 0.0),
        ("steady turn", |t| {
            let steady = libm::asin((t.wheelbase_m / t.radius_m).min(1.0)).to_degrees();
            if t.place_m < t.arc_m { steady } else { 0.0 }
        }),
        ("closed tractrix", Turn::closed),
        ("stepped, 0.5 m", |t| t.stepped(0.5)),
    ];
    // A hundred thousandth of a degree from the limit of ever shorter steps.
    let exact = |t: &Turn| t.stepped(0.01);
    numbers("across", "degrees of heading", &cases, exact, &rungs, blocks.min(20))
}

/// Thrust comes up from nothing within this, s (assumed, as the movers have it).
const SPOOL_S: f64 = 5.0;

/// Time to lift-off by small steps of the same law.
fn integrated_s(t: &TakeOff) -> f64 {
    let Some(run) = take_off_run(t) else { return f64::NAN };
    let (mut v, mut time, dt) = (0.0, 0.0, 1e-3);
    while v < run.liftoff_ground_mps && time < 300.0 {
        let air = v + t.headwind_mps;
        let thrust = f64::min(1.0, (time + 0.5 * dt) / SPOOL_S);
        v += dt * (run.a_mps2 * thrust - run.b_per_m * air * air).max(0.0);
        time += dt;
    }
    time
}

fn take_off(options: &Options, blocks: usize) -> Vec<Row> {
    let run = |case: usize| {
        let mut rng = draws(options, 3, case);
        let liftoff_mps = between(&mut rng, 60.0, 90.0);
        // What keeps the mean acceleration between 1.5 and 2.6 m/s².
        let distance_m = 0.5 * liftoff_mps * liftoff_mps / between(&mut rng, 1.5, 2.6);
        TakeOff {
            liftoff_mps,
            distance_m,
            density_ratio: between(&mut rng, 0.85, 1.05),
            headwind_mps: between(&mut rng, -3.0, 12.0),
            end_ratio: 0.75,
            thrust_exponent: 0.7,
            rolling_friction: 0.02,
        }
    };
    let cases: Vec<TakeOff> = (0..BLOCK).map(run).collect();
    let rungs: [Form<TakeOff>; 4] = [
        ("constant acceleration", |t| 2.0 * t.distance_m / t.liftoff_mps),
        ("constant, wind and density", |t| {
            let ground = t.liftoff_mps / t.density_ratio.sqrt() - t.headwind_mps;
            2.0 * t.distance_m / (t.liftoff_mps * t.liftoff_mps) * ground
        }),
        ("thrust less drag", |t| take_off_run(t).map_or(f64::NAN, |r| r.time_s)),
        ("thrust less drag, spool-up", |t| {
            take_off_run(t).map_or(f64::NAN, |r| r.time_s + 0.5 * SPOOL_S)
        }),
    ];
    numbers("take_off", "s to lift-off", &cases, integrated_s, &rungs, blocks)
}

/// Time to drive a way with jerk, slowing down to 5.1 m/s and less in turns above 20°, s.
fn driven_s(graph: &Graph, way: &Way) -> f64 {
    let (mut time_s, mut length_m, mut v0_mps) = (0.0, 0.0, 0.0_f64);
    for (k, index) in way.arcs.iter().enumerate() {
        length_m += graph.arcs()[*index].length_m;
        let turn_deg = way.arcs.get(k + 1).map(|next| graph.turn_deg(*index, *next));
        // 10 kt in a quarter turn, more in less of one.
        let v1_mps = match turn_deg {
            None => 0.0,
            Some(deg) if deg <= 20.0 => continue,
            Some(deg) => (5.1 * (90.0 / deg).sqrt()).min(15.4),
        };
        let (acc_mps2, dec_mps2) = (0.7, 0.7);
        let leg = |v0_mps: f64, v1_mps: f64| {
            let jerk_mps3 = Some(JERK_MPS3);
            let leg =
                Leg { length_m, v0_mps, v1_mps, vmax_mps: 15.4, acc_mps2, dec_mps2, jerk_mps3 };
            leg_profile(&leg).map(|p| p.time_s)
        };
        // Too short to change the speed: at the lower one.
        let least = v0_mps.min(v1_mps).max(1.0);
        time_s += leg(v0_mps, v1_mps).unwrap_or(length_m / least);
        (length_m, v0_mps) = (0.0, v1_mps);
    }
    time_s
}

fn ways(options: &Options) -> Result<Vec<Row>, String> {
    let (airports, pairs): (&[&str], usize) =
        if options.quick { (&["LSZH"], 30) } else { (&["LSZH", "LIMC", "EHAM"], 150) };
    let (mut excess, mut ns) = ([const { Vec::new() }; 3], [0.0; 3]);
    for airport in airports {
        let text = format!(
            "[run]\ntitle = \"ways\"\nstart = 2026-01-01T06:00:00Z\nduration_s = 60\n[airport]\nlayout = \"airports/{airport}.apt.dat\"\n\
             ground_network = \"airports/{airport}.groundnet.xml\"\n"
        );
        let scene = read(&text)?;
        let graph = Graph::of(&scene.airport.layout);
        let nodes = scene.airport.layout.nodes.len();
        for case in 0..pairs {
            let mut rng = draws(options, 4, case);
            let node = |rng: &mut ChaCha8Rng| (uniform(rng) * nodes as f64) as usize;
            let (from, to) = (node(&mut rng), node(&mut rng));
            let mut spent = [0.0; 3];
            let mut clocked = |rung: usize, search: &mut dyn FnMut() -> Vec<Way>| {
                let begin = clock::thread_ns();
                let found = search();
                spent[rung] += (clock::thread_ns() - begin) as f64;
                found
            };
            let shortest = |graph: &Graph| graph.cheapest(from, to, Graph::length);
            let by_length = clocked(0, &mut || shortest(&graph).into_iter().collect());
            let rule = TurnTime::default();
            let by_turns =
                clocked(1, &mut || graph.quickest(from, to, &rule).into_iter().collect());
            let mut several = clocked(2, &mut || graph.shortest_ways(from, to, 8));
            several.extend(by_turns.iter().cloned());
            let time = |ways: &[Way]| {
                ways.iter().map(|w| driven_s(&graph, w)).reduce(f64::min).filter(|s| *s > 0.0)
            };
            let times = [time(&by_length), time(&by_turns), time(&several)];
            let [Some(a), Some(b), Some(c)] = times else { continue };
            for (rung, time_s) in [a, b, c].into_iter().enumerate() {
                excess[rung].push(time_s - c);
                ns[rung] += spent[rung];
            }
        }
    }
    let rungs = ["by length", "by turn time", "best of eight driven"];
    let rows = rungs.iter().enumerate().map(|(k, rung)| {
        let count = excess[k].len().max(1) as f64;
        let mean = excess[k].iter().sum::<f64>() / count;
        row("ways", rung, Some(mean), "s of a way, mean", Some(ns[k] / count))
    });
    Ok(rows.collect())
}

fn sequence(options: &Options) -> Vec<Row> {
    let instances = if options.quick { 10 } else { 40 };
    let rules = Rules::default();
    let draw = |case: usize| {
        let mut rng = draws(options, 5, case);
        let flight = |rng: &mut ChaCha8Rng| Departure {
            ready_s: between(rng, 0.0, 300.0),
            recat: pick(rng, &[Recat::B, Recat::C, Recat::D, Recat::D, Recat::E, Recat::F]),
            way: Some(pick(rng, &[1, 2, 3])),
            ctot_s: None,
        };
        let mut flights: Vec<Departure> = (0..8).map(|_| flight(&mut rng)).collect();
        flights.sort_by(|a, b| a.ready_s.total_cmp(&b.ready_s));
        flights
    };
    let cases: Vec<Vec<Departure>> = (0..instances).map(draw).collect();
    let delay = |s: &Sequence| s.delay_s / s.order.len().max(1) as f64;
    let shifted = |flights: &[Departure], shift: Option<usize>| {
        best(flights, shift, None, &rules).unwrap_or_default()
    };
    let exact: Vec<f64> = cases.iter().map(|f| delay(&shifted(f, None))).collect();
    let came: Vec<usize> = (0..8).collect();
    let rungs: [(&str, Option<Option<usize>>); 5] = [
        ("first come", None),
        ("shift 1", Some(Some(1))),
        ("shift 2", Some(Some(2))),
        ("shift 3", Some(Some(3))),
        ("best of all", Some(None)),
    ];
    let of = |(name, how): &(&str, Option<Option<usize>>)| {
        let run = |flights: &[Departure]| match how {
            None => in_order(flights, &came, None, &rules),
            Some(shift) => shifted(flights, *shift),
        };
        let begin = clock::thread_ns();
        let found: Vec<f64> = cases.iter().map(|f| delay(&run(f))).collect();
        let ns = (clock::thread_ns() - begin) as f64 / instances as f64;
        let excess: f64 = found.iter().zip(&exact).map(|(f, e)| f - e).sum();
        row("sequence", name, Some(excess / instances as f64), "s of a flight, mean", Some(ns))
    };
    rungs.iter().map(of).collect()
}

fn read(text: &str) -> Result<Scene, String> {
    let path = scenarios::locate("zurich").with_file_name("traffic.toml");
    scenarios::load_text(&path, text).map_err(|e| e.to_string())
}

/// After the end of the demand somebody may take this long, s.
const LONGEST_S: f64 = 3600.0;

/// Mean time of a flight from its demand to take-off or stand, s, flights not served, and processor time of a mover, ns.
fn ruled(airport: &str, policy: &str, options: &Options) -> Result<(f64, usize, f64), String> {
    let minutes = if options.quick { 10 } else { 30 };
    let text = format!(
        "[run]\ntitle = \"policy\"\nseed = {}\nduration_s = {}\n[airport]\nlayout = \"airports/{airport}.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 16\ndepartures_per_h = 16\n[control]\npolicy = \"{policy}\"\n",
        options.seed,
        60 * minutes
    );
    let scene = read(&text)?;
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
    let mut core = behaving.core(&scene.run, options.seed).ok_or("no truth")?;
    let step_s = scene.run.frame.s();
    let most = scene.run.frames() as i64 + (LONGEST_S / step_s) as i64;
    let begin = clock::thread_ns();
    for frame in 1..=most {
        core.step(frame);
        if frame % 1200 == 0 && core.all_served() {
            break;
        }
    }
    let ns = (clock::thread_ns() - begin) as f64 / core.flights().len().max(1) as f64;
    // From when it was to push back or to land.
    let needed = |f: usize| {
        let m = core.measures(f);
        let done = if m.aldt_s.is_some() { m.aibt_s } else { m.atot_s };
        Some(done? - core.flights()[f].time_s)
    };
    let times: Vec<f64> = (0..core.flights().len()).filter_map(needed).collect();
    let unserved = core.flights().len() - core.measures_of_served();
    Ok((times.iter().sum::<f64>() / times.len().max(1) as f64, unserved, ns))
}

fn policy(options: &Options) -> Result<Vec<Row>, String> {
    let airports: &[&str] = if options.quick { &["XSYN"] } else { &["XSYN", "LZIB"] };
    let mut rows = Vec::new();
    let mut found: Vec<(&str, f64, usize, f64)> = Vec::new();
    for rung in ["free", "ordered", "planned"] {
        let (mut time_s, mut unserved, mut ns) = (0.0, 0, 0.0);
        for airport in airports {
            let one = ruled(airport, rung, options)?;
            time_s += one.0 / airports.len() as f64;
            unserved += one.1;
            ns += one.2 / airports.len() as f64;
        }
        found.push((rung, time_s, unserved, ns));
    }
    let served = found.iter().filter(|f| f.2 == 0);
    let least = served.map(|f| f.1).fold(f64::INFINITY, f64::min);
    for (rung, time_s, unserved, ns) in found {
        let error = (unserved == 0).then_some(time_s - least);
        let mut one = row("policy", rung, error, "s of a flight, mean", Some(ns));
        if unserved > 0 {
            one.failed.push(format!("{unserved} flights were not served"));
        }
        rows.push(one);
    }
    Ok(rows)
}

/// What each task's forms cost and are off by, in a sentence each.
fn said(rows: &[Row]) -> String {
    let form = |r: &&Row| {
        let error = r.error.map_or_else(
            || r.failed.join(", "),
            |e| format!("{e:.2} {}", r.error_unit.as_deref().unwrap_or("")),
        );
        format!("{} {error} for {}", r.rung, r.ns_per_update.map_or("–".into(), duration))
    };
    let task = |(name, _): &(&str, &str)| {
        let forms: Vec<String> =
            rows.iter().filter(|r| r.scene == *name).map(|r| form(&r)).collect();
        format!("{name}: {}.", forms.join("; "))
    };
    SCENES.iter().map(task).collect::<Vec<_>>().join(" ")
}

/// Measures the group.
pub fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let blocks = if options.quick { 10 } else { 100 };
    let scenes = SCENES.map(|(name, about)| SceneAbout { name: name.into(), about: about.into() });
    let mut outcome = Outcome {
        ladder: Ladder {
            group: GROUP.into(),
            title: "Movers, ways, sequences and policies".into(),
            about: ABOUT.into(),
            error_label: "error, in the unit of the task".into(),
            draws: Draws::Other,
            unit: "s".into(),
            scenes: scenes.to_vec(),
            ..Ladder::default()
        },
        ..Outcome::default()
    };
    for (done, (name, _)) in SCENES.iter().enumerate() {
        let rows = match *name {
            "along" => Ok(along(options, blocks)),
            "across" => Ok(across(options, blocks)),
            "take_off" => Ok(take_off(options, blocks)),
            "ways" => ways(options),
            "sequence" => Ok(sequence(options)),
            _ => policy(options),
        };
        outcome.rows.extend(rows.unwrap_or_else(|e| {
            vec![Row { failed: vec![e], ..row(name, "could not be measured", None, "", None) }]
        }));
        let what = (*name).to_owned();
        progress(Progress { group: GROUP, what, done: done + 1, total: SCENES.len() });
    }
    outcome.said = Some(said(&outcome.rows));
    outcome
}
