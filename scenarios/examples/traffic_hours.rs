//! Hours of traffic that behaves, on airports and with seeds of one's choice: who was served, who overlapped whom.
//!
//! `cargo run --release -p scenarios --example traffic_hours -- [--policy P] [--rate N] [--seeds A..B] [--every FRAMES] [--stops] [--say] AIRPORT|SCENE.toml …`
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a command-line example that measures its own time"
)]

use models::traffic::core::{Core, Notice, Order, Phase};
use models::traffic::outline::{Rectangle, distance_m, outline};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() {
    let mut args = std::env::args().skip(1);
    let (mut policy, mut rate, mut seeds, mut every) =
        ("planned".to_owned(), 20_u32, 1..=1_u32, 10_i64);
    let (mut minutes, mut drain, mut say, mut stops) = (60_u32, 30_u32, false, false);
    let mut what = Vec::new();
    while let Some(arg) = args.next() {
        let mut next = || args.next().unwrap_or_default();
        match arg.as_str() {
            "--policy" => policy = next(),
            "--rate" => rate = next().parse().unwrap_or(rate),
            "--every" => every = next().parse().unwrap_or(every),
            "--minutes" => minutes = next().parse().unwrap_or(minutes),
            "--drain" => drain = next().parse().unwrap_or(drain),
            "--say" => say = true,
            "--stops" => stops = true,
            "--seeds" => {
                let text = next();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                seeds = a.parse().unwrap_or(1)..=b.parse().unwrap_or(1);
            }
            _ => what.push(arg),
        }
    }
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in &what {
        for seed in seeds.clone() {
            let (path, text) = if name.ends_with(".toml") {
                let path = PathBuf::from(name);
                let text = std::fs::read_to_string(&path).unwrap_or_default();
                (path, format!("{text}\n[control]\npolicy = \"{policy}\"\n"))
            } else {
                let layout = |ext: &str| format!("airports/{name}.{ext}");
                let mut airport = if base.join(layout("apt.dat")).exists() {
                    format!("layout = \"{}\"", layout("apt.dat"))
                } else {
                    format!("layout = \"{}\"", layout("nodes.csv"))
                };
                if base.join(layout("groundnet.xml")).exists() {
                    airport += &format!("\nground_network = \"{}\"", layout("groundnet.xml"));
                }
                let text = format!(
                    "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = {}\n[airport]\n{airport}\n[[traffic]]\nkind = \"generated\"\n\
                     arrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\npolicy = \"{policy}\"\n",
                    minutes * 60
                );
                (base.join("hours.toml"), text)
            };
            let scene = match scenarios::load_text(&path, &text) {
                Ok(scene) => scene,
                Err(e) => {
                    println!("{name}: {e}");
                    break;
                }
            };
            hour(&scene, name, seed, every, drain, (say, stops));
        }
    }
}

fn hour(
    scene: &scenarios::Scene,
    name: &str,
    seed: u32,
    every: i64,
    drain: u32,
    (say, stops): (bool, bool),
) {
    let Some(behaving) = scene.traffic.behaving.as_ref() else { return };
    let Some(mut core) = behaving.core(&scene.run, u64::from(seed)) else { return };
    // Three in ten stand still for 20 to 180 s some minutes after their time.
    for f in 0..core.flights().len() {
        let draw =
            |k: usize| ((f * 7919 + k * 104_729 + seed as usize * 31) % 1000) as f64 / 1000.0;
        if stops && draw(1) < 0.3 {
            let at_s = core.flights()[f].time_s + 120.0 + 400.0 * draw(2);
            core.notice(Notice {
                effect_frame: (at_s * 20.0) as i64,
                source: "stops".into(),
                sequence: f as u64,
                flight: f,
                order: Order::Stop(20.0 + 160.0 * draw(3)),
            });
        }
    }
    let begun = Instant::now();
    let frames = scene.run.frames() as i64 + i64::from(drain) * 60 * 20;
    let (mut overlaps, mut pairs): (Vec<String>, u64) = (Vec::new(), 0);
    let mut done_at = None;
    for frame in 1..=frames {
        core.step(frame);
        if frame % every == 0 {
            for text in overlapping(&core, &mut pairs) {
                if overlaps.iter().filter(|o| o.split(' ').next() == text.split(' ').next()).count()
                    < 2
                    && overlaps.len() < 20
                {
                    overlaps.push(format!("{text} at {:.1} s", frame as f64 * 0.05));
                }
            }
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            done_at = Some(frame as f64 * 0.05);
            break;
        }
    }
    let count = core.flights().len();
    let extra: Vec<f64> = (0..count)
        .map(|f| core.measures(f))
        .filter(|m| m.taxi_s > 0.0)
        .map(|m| m.taxi_s - m.unhindered_s)
        .collect();
    let around: u32 = (0..count).map(|f| core.measures(f).go_arounds).sum();
    println!(
        "{name} seed {seed}: served {}/{count}{}, overlaps {} (of {pairs} near), go-arounds {around}, additional {:.0} s, {:.1} s of computing",
        core.measures_of_served(),
        done_at.map_or(String::new(), |t| format!(" by {t:.0} s")),
        overlaps.len(),
        extra.iter().sum::<f64>() / extra.len().max(1) as f64,
        begun.elapsed().as_secs_f64()
    );
    if core.unexpected_deadlocks() > 0 {
        println!("    rings of waiting: {}", core.unexpected_deadlocks());
    }
    overlaps.iter().for_each(|o| println!("    {o}"));
    let served = |f: usize| core.measures(f).aibt_s.is_some() || core.measures(f).atot_s.is_some();
    for f in (0..count).filter(|f| !served(*f)) {
        let flight = &core.flights()[f];
        let stand = &behaving.network.stands[core.stand(f)].name;
        println!(
            "    not served: {} {:?} due {:.0} s, stand {stand}, {:?}, waits for {:?}",
            flight.callsign,
            flight.direction,
            flight.time_s,
            core.phase(f),
            core.waiting(f)
        );
    }
    if say {
        for r in core.remarks() {
            println!("    {:7.1} {}", r.time_s, r.text);
        }
    }
}

fn overlapping(core: &Core, pairs: &mut u64) -> Vec<String> {
    let mut there: Vec<(usize, [Rectangle; 2])> = Vec::new();
    for (f, flight) in core.flights().iter().enumerate() {
        let Some(state) = core.state(f).filter(|s| s.position_m.z < 15.0) else { continue };
        there.push((f, outline(flight.size, state.position_m.xy(), state.heading_rad)));
    }
    let mut found = Vec::new();
    for (i, (a, first)) in there.iter().enumerate() {
        for (b, second) in &there[i + 1..] {
            let near = (first[0].corners_m[0] - second[0].corners_m[0]).norm() < 160.0;
            let stand = |f: usize| matches!(core.phase(f), Phase::Parked | Phase::Docked);
            if !near || (stand(*a) && stand(*b)) && !(*pairs).is_multiple_of(7) {
                continue;
            }
            *pairs += 1;
            if distance_m(first, second) == 0.0 {
                let name = |f: usize| {
                    let at = core.state(f).map_or([0.0; 2], |s| s.position_m.xy().into());
                    let stand = core.stand(f);
                    format!(
                        "{} {:?} stand {stand} at {at:.0?}",
                        core.flights()[f].callsign,
                        core.phase(f)
                    )
                };
                found.push(format!("{} and {}", name(*a), name(*b)));
            }
        }
    }
    found
}
