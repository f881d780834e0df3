//! The off-line reference of a run against its truth, beside what was published, case by case: nothing pooled.
//!
//! `cargo run --release -p studies --example reference -- [--seeds A..B] [--seconds S] [--types] SCENE…`
//!
//! SCENE as in the example `chain`; `SCENE+radar+adsb+mlat` has these beside its own sensors.
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::sensors::Truth;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::error::Error;
use studies::chain::Sum;
use studies::crowds::{among_parked, thirty_five};
use studies::movers::Movers;
use studies::reference::{Compared, Errors, compare, config, with_sensors};
use studies::{profiles, zurich};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut seeds, mut names, mut limit, mut types) = (1..=1, Vec::new(), None, false);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--seconds" => limit = Some(args.next().unwrap_or_default().parse::<f64>()?),
            "--types" => types = true,
            "--seeds" => {
                let text = args.next().unwrap_or_default();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                seeds = a.parse()?..=b.parse()?;
            }
            _ => names.push(arg),
        }
    }
    println!(
        "scene seed: published, reference then | one second ago, reference then (m/NEES: all, moving, standing) | every point"
    );
    for name in &names {
        for seed in seeds.clone() {
            run(name, seed, limit, types)?;
        }
    }
    Ok(())
}

fn made(name: &str, seed: u64) -> Result<(Scene, f64), Box<dyn Error>> {
    if name == "35" {
        return Ok((thirty_five(seed)?, 600.0));
    }
    if let Some(airport) = name.strip_prefix("parked:") {
        return Ok(among_parked(airport, seed)?);
    }
    let mut words = name.split('+');
    let file = scenarios::locate(words.next().unwrap_or_default());
    let mut scene = with_sensors(&file, &scenarios::text_of(&file)?, words)?;
    scene.run.seed = seed;
    let seconds = scene.run.duration.s();
    Ok((scene, seconds))
}

fn run(name: &str, seed: u64, limit: Option<f64>, types: bool) -> Result<(), Box<dyn Error>> {
    let (scene, whole_s) = made(name, seed)?;
    let seconds = limit.map_or(whole_s, |s| s.min(whole_s));
    let truth = Movers::drive(&scene, seconds);
    let seen = profiles::see_of(&truth, &scene, zurich::sensors(&scene)?, seed, seconds);
    let config = config(&scene);
    let (found, run) = compare(&truth, &seen, &config, &scene.flight_list)?;
    let Compared { now, ago, every, far, gone, missing, .. } = &found;
    println!(
        "{name} {seed}: {} {} | {} {} | {} | {} ways, {far} far, {gone} gone, {missing} missing",
        errors(&now[0]),
        errors(&now[1]),
        errors(&ago[0]),
        errors(&ago[1]),
        errors(every),
        run.trajectories.len()
    );
    for site in &run.sites {
        let show = |f: models::fusion::reference::Found, k: f64| {
            format!("{:.2}±{:.2}{}", k * f.value, k * f.sigma, if f.known { "" } else { "?" })
        };
        println!(
            "   radar {}: {} m, {} mrad, {} s; kappa {} {}",
            site.sensor.0,
            show(site.range_m, 1.0),
            show(site.azimuth_rad, 1e3),
            show(site.time_s, 1.0),
            show(run.kappa[0], 1.0),
            show(run.kappa[1], 1.0)
        );
    }
    if types {
        let mut kinds: BTreeMap<(String, bool), [Sum; 2]> = BTreeMap::new();
        for ((key, moves), sums) in &found.by_target {
            let kind = truth.class(*key as usize).designator.clone();
            let own = kinds.entry((kind, *moves)).or_default();
            for (own, sum) in own.iter_mut().zip(sums) {
                own.count += sum.count;
                own.squares_m2 += sum.squares_m2;
                own.nees += sum.nees;
            }
        }
        for ((kind, moves), sums) in &kinds {
            let how = if *moves { "moving" } else { "standing" };
            println!("   {kind} {how} {}: {} -> {}", sums[0].count, sum(&sums[0]), sum(&sums[1]));
        }
    }
    Ok(())
}

fn sum(s: &Sum) -> String {
    format!("{:.2}/{:.2}", s.rmse_m(), s.nees())
}

fn errors(e: &Errors) -> String {
    format!("{} ({} {})", sum(&e.all), sum(&e.moving), sum(&e.standing))
}
