//! The effect plan held against everything exact, scene by scene, nothing pooled: how much of each tolerance is used, what share of what is
//! there is left out, and what is beyond.
//!
//! `cargo run --release -p studies --example effects -- named [A..B]`: the named scenes of the study by seed.
//! `… -- random SEED A..B [SCANS]`: scenes of the whole space by number; only those beyond, and what all of them use at most.
//! `… -- edges SEED A..B [SCANS [EDGE]]`: the same put on edges: of boxes, of the display, of tolerances, with shapes of their own; all or one.
//! `… -- search SEED RESTARTS [GENERATIONS]`: a search for the worst scene.
//! `… -- cases FILE SCANS`: cases of a file like `tests/data/effects-cases.csv`, with three seeds of draws each.
//! `… -- scenes SCENE…`: the radar of scenes that were written, flights that behave driven.
//! `… -- why SCENE…`: the same with what is simulated and left out, effect by effect.
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::effects::Tolerance;
use scenarios::{ScenarioError, locate};
use std::error::Error;
use std::ops::Range;
use studies::effects_proof::{
    Edge, ProofScene, SceneResult, Search, edge_scene, judge_scene, named_cases, proof_scene,
};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["named", rest @ ..] => named(range(rest.first().copied().unwrap_or("1..11"))?),
        ["random", seed, numbers, rest @ ..] => {
            let scans = rest.first().map_or(Ok(400), |s| s.parse())?;
            let seed = seed.parse()?;
            random(seed, range(numbers)?, scans, &|n| proof_scene(seed, n, &[]))
        }
        ["edges", seed, numbers, rest @ ..] => {
            let scans = rest.first().map_or(Ok(400), |s| s.parse())?;
            let only = rest.get(1).map(|word| {
                let found = Edge::ALL.into_iter().find(|e| format!("{e:?}") == **word);
                found.ok_or_else(|| format!("{word} is no edge: {:?}", Edge::ALL))
            });
            let (seed, only) = (seed.parse()?, only.transpose()?);
            random(seed, range(numbers)?, scans, &|n| edge_scene(seed, n, only))
        }
        ["search", seed, restarts, rest @ ..] => {
            let generations = rest.first().map_or(Ok(60), |s| s.parse())?;
            let search = Search { seed: seed.parse()?, generations, scans: 100 };
            for restart in 0..restarts.parse()? {
                let mut tell = |generation: u64, ratio: f64| {
                    if generation.is_multiple_of(10) && generation < generations {
                        println!("  restart {restart}, generation {generation}: {ratio:.2} so far");
                    }
                };
                let worst = search.restart(restart, &mut tell)?;
                println!("{:.2} in {}", worst.ratio, worst.scene.name);
                let genes: Vec<String> = worst.genes.iter().map(|g| format!("{g:.6}")).collect();
                for violation in &worst.violations {
                    println!("  BEYOND {violation}; genes {}", genes.join(" "));
                }
            }
            Ok(())
        }
        ["cases", file, scans] => {
            for (scene, what) in named_cases(&std::fs::read_to_string(file)?)? {
                for seed in 1..4 {
                    let result = scene.play(seed, scans.parse()?)?;
                    let beyond = result.violations(&scene.tolerance);
                    let name = format!("{} ({what}), draws {seed}", scene.name);
                    say(&name, &result, &scene.tolerance, &beyond);
                }
            }
            Ok(())
        }
        ["scenes", scenes @ ..] => {
            for name in scenes {
                let scene = scenarios::load(&locate(name))?;
                let (result, beyond) = judge_scene(&scene, scene.tolerance(), 1..3)?;
                say(name, &result, &scene.tolerance(), &beyond);
            }
            Ok(())
        }
        ["why", scenes @ ..] => {
            for name in scenes {
                let scene = scenarios::load(&locate(name))?;
                let (result, beyond) = judge_scene(&scene, scene.tolerance(), 1..2)?;
                say(name, &result, &scene.tolerance(), &beyond);
                say_effects(&result);
            }
            Ok(())
        }
        _ => Err("named [A..B] | random SEED A..B [SCANS] | edges SEED A..B [SCANS [EDGE]] | search SEED RESTARTS [GENERATIONS] | cases FILE SCANS | scenes SCENE… | why SCENE…".into()),
    }
}

fn range(text: &str) -> Result<Range<u64>, Box<dyn Error>> {
    let (a, b) = text.split_once("..").ok_or("a range is written A..B")?;
    Ok(a.parse()?..b.parse()?)
}

fn say(name: &str, result: &SceneResult, tolerance: &Tolerance, beyond: &[String]) {
    let [shift, detection, plots] = result.largest(tolerance);
    let (_, there, planned) = result.cost_ns;
    println!(
        "{name}: {} targets, {shift:.2} of the shift, {detection:.2} of the detection, {plots:.2} of the false plots; {:.1} % left out{}",
        result.targets.len(),
        100.0 * (1.0 - planned / there.max(1.0)),
        if beyond.is_empty() { "" } else { " BEYOND" },
    );
    beyond.iter().for_each(|b| println!("  {b}"));
}

/// Where the time of a target goes: effect by effect, ns simulated and left out.
fn say_effects(result: &SceneResult) {
    let (_, there, planned) = result.cost_ns;
    println!("  there {there:.0} ns a target, simulated {planned:.0}");
    let shown = result.by_effect.iter().filter(|(_, kept, left)| kept + left >= 0.5);
    shown.for_each(|(effect, kept, left)| {
        println!("  {:<22} {kept:>4.0} simulated {left:>4.0} left out", effect.name());
    });
}

fn named(seeds: Range<u64>) -> Result<(), Box<dyn Error>> {
    for seed in seeds {
        for scene in studies::effects::named_scenes(seed)? {
            let scene = scene.standing();
            let (result, beyond) = scene.judge(seed, 400, &|radar| radar)?;
            say(&format!("{} {seed}", scene.name), &result, &scene.tolerance, &beyond);
        }
    }
    Ok(())
}

fn random(
    seed: u64,
    numbers: Range<u64>,
    scans: u64,
    make: &dyn Fn(u64) -> Result<ProofScene, ScenarioError>,
) -> Result<(), Box<dyn Error>> {
    let (mut most, mut targets, mut count) = ([0.0f64; 3], 0, 0);
    for n in numbers {
        let scene = make(n)?;
        let (result, beyond) = scene.judge(seed + n, scans, &|radar| radar)?;
        let largest = result.largest(&scene.tolerance);
        (0..3).for_each(|i| most[i] = most[i].max(largest[i]));
        targets += result.targets.len();
        count += 1;
        if !beyond.is_empty() {
            println!("BEYOND {seed},{n} {}: {beyond:#?}", scene.name);
        }
        if n % 1000 == 999 {
            println!(
                "{count} scenes, {targets} targets: {most:.2?} of shift, detection, false plots"
            );
        }
    }
    println!("{count} scenes, {targets} targets: {most:.2?} of shift, detection, false plots");
    Ok(())
}
