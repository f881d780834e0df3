//! What the tracker publishes, case by case: scene, seed and profile a line, nothing pooled.
//!
//! `cargo run --release -p studies --example chain -- [--seeds A..B] [--seconds S] [--profiles paper,accurate] [--types] [--mistaken] [--strays] SCENE…`
//!
//! SCENE is a scene that ships, a file, either with `+radar+adsb+mlat` for more sensors; `35` (thirty-five movers at Zurich under the
//! radar alone), `35:drawn` (others with each seed) or `parked:SCENE` (a scene of flights that behave, with parked aircraft and vehicles
//! between them). Behaving flights are driven with each seed anew.
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::fusion::TrackingConfig;
use scenarios::Scene;
use std::error::Error;
use studies::chain::{Published, Sum, publish_of, scored_of};
use studies::crowds::{among_parked, thirty_five, thirty_five_drawn};
use studies::movers::Movers;
use studies::reference::with_sensors;
use studies::{profiles, zurich};

struct Options {
    seconds: Option<f64>,
    profiles: Vec<String>,
    types: bool,
    mistaken: bool,
    strays: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options {
        seconds: None,
        profiles: vec!["paper".into(), "accurate".into()],
        types: false,
        mistaken: false,
        strays: false,
    };
    let (mut seeds, mut names) = (None, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--seconds" => options.seconds = Some(args.next().unwrap_or_default().parse()?),
            "--profiles" => {
                let list = args.next().unwrap_or_default();
                options.profiles = list.split(',').map(str::to_owned).collect();
            }
            "--types" => options.types = true,
            "--mistaken" => options.mistaken = true,
            "--strays" => options.strays = true,
            "--seeds" => {
                let text = args.next().unwrap_or_default();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                seeds = Some(a.parse()?..=b.parse()?);
            }
            _ => names.push(arg),
        }
    }
    println!(
        "scene seed profile: tracks targets swaps strays | published settled NEES ago NEES m | labels right wrong of listed, % \
         wrong, claimed | standing m m/s | far reports | ms a scan, most"
    );
    for name in &names {
        for seed in seeds.clone().unwrap_or(1..=1) {
            run(name, seed, &options)?;
        }
    }
    Ok(())
}

fn made(name: &str, seed: u64) -> Result<(Scene, f64), Box<dyn Error>> {
    if name == "35" {
        return Ok((thirty_five(seed)?, 600.0));
    }
    if name == "35:drawn" {
        return Ok((thirty_five_drawn(seed)?, 600.0));
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

fn run(name: &str, seed: u64, options: &Options) -> Result<(), Box<dyn Error>> {
    let (scene, whole_s) = made(name, seed)?;
    let seconds = options.seconds.map_or(whole_s, |s| s.min(whole_s));
    let truth = Movers::drive(&scene, seconds);
    let seen = profiles::see_of(&truth, &scene, zurich::sensors(&scene)?, seed, seconds);
    for profile in &options.profiles {
        let base = match profile.as_str() {
            "paper" => TrackingConfig::paper(),
            "bulk" => TrackingConfig::bulk(),
            "accurate" => TrackingConfig::accurate(),
            other => return Err(format!("profile {other}: give paper, bulk or accurate").into()),
        };
        let own = scene.tracking_config();
        let config = TrackingConfig { sensors: own.sensors, sizes: own.sizes, ..base };
        let found = publish_of(&truth, &seen, &config, &scene.flight_list);
        let score = scored_of(&truth, &scene, &seen, &found, seconds);
        let (_, mut times) = profiles::track_scans(&seen, &config, &scene.flight_list);
        times.sort_by(f64::total_cmp);
        let ms = |place: usize| times.get(place).map_or(f64::NAN, |ns| ns * 1e-6);
        let (middle, most) = (ms(times.len() / 2), ms(times.len().saturating_sub(1)));
        line(name, seed, profile, &found, score.swaps);
        println!(" | {middle:.3} {most:.3}");
        details(&found, options);
    }
    Ok(())
}

fn line(name: &str, seed: u64, profile: &str, found: &Published, swaps: u64) {
    let Published { all, settled, second_ago, labels, .. } = found;
    let given = (labels.right + labels.wrong).max(1) as f64;
    let [off, fast] = &found.standing;
    print!(
        "{name} {seed} {profile}: {} {} {swaps} {} | {:.2} {:.2} {:.2} {:.2} {:.2} | {} {} of {}, {:.2} % {:.3} | {:.1} {:.1} | {}",
        found.tracks,
        found.targets,
        found.strays,
        all.rmse_m(),
        settled.rmse_m(),
        settled.nees(),
        second_ago.rmse_m(),
        second_ago.nees(),
        labels.right,
        labels.wrong,
        labels.listed,
        100.0 * labels.wrong as f64 / given,
        labels.claimed / given,
        off.0,
        fast.0,
        found.far,
    );
}

fn details(found: &Published, options: &Options) {
    if options.types {
        for (how, sum) in ["up to 30 m/s", "faster"].into_iter().zip(&found.by_speed) {
            let (count, rmse_m, nees) = (sum.count, sum.rmse_m(), sum.nees());
            println!("  {how}: {count} reports, {rmse_m:.2} m, NEES {nees:.2}");
        }
        for ((kind, moves), sum) in &found.by_type {
            let how = if *moves { "moving" } else { "standing" };
            let Sum { count, .. } = sum;
            println!(
                "  {kind} {how}: {count} reports, {:.2} m, NEES {:.2}",
                sum.rmse_m(),
                sum.nees()
            );
        }
        let [off, fast] = &found.standing;
        println!("  standing: {} m of {}, {} m/s of {}", off.0, off.1, fast.0, fast.1);
    }
    if options.strays {
        for s in &found.strayed {
            let [before, now] = &s.targets;
            println!(
                "  scan {} track {}: {before} -> {now}, {:.0} m apart, {:.1} m/s, {}",
                s.scan,
                s.track,
                s.apart_m,
                s.speed_mps,
                if s.seen { "seen" } else { "not seen" }
            );
        }
    }
    if options.mistaken {
        for ((given, whose), (reports, first)) in &found.mistaken {
            println!("  {given} on {whose}: {reports} reports from scan {first}");
        }
    }
}
