//! Hours of traffic that behaves, on airports and with seeds of one's choice: held against what traffic has to keep (`models::traffic::check`).
//!
//! `cargo run --release -p scenarios --example traffic_hours -- [--policy P] [--rate N] [--seeds A..B] [--every FRAMES] [--minutes M] [--drain M] [--stops] [--say] [--cases N] AIRPORT|SCENE.toml …`
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a command-line example that measures its own time"
)]

use models::traffic::core::{Direction, Measures};
use scenarios::hours::{self, Hour};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() {
    let mut args = std::env::args().skip(1);
    let (mut policy, mut rate, mut seeds, mut every) =
        ("planned".to_owned(), 20_u32, 1..=1_u32, 10_i64);
    let (mut minutes, mut drain, mut say, mut stops) = (60_u32, 30_u32, false, false);
    let (mut what, mut cases) = (Vec::new(), 6);
    while let Some(arg) = args.next() {
        let mut next = || args.next().unwrap_or_default();
        match arg.as_str() {
            "--policy" => policy = next(),
            "--rate" => rate = next().parse().unwrap_or(rate),
            "--every" => every = next().parse().unwrap_or(every),
            "--minutes" => minutes = next().parse().unwrap_or(minutes),
            "--drain" => drain = next().parse().unwrap_or(drain),
            "--say" => say = true,
            "--cases" => cases = next().parse().unwrap_or(cases),
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
            hour(&scene, name, seed, every, drain, (say, stops, cases));
        }
    }
}

fn hour(
    scene: &scenarios::Scene,
    name: &str,
    seed: u32,
    every: i64,
    drain: u32,
    (say, stops, cases): (bool, bool, usize),
) {
    let Some(behaving) = scene.traffic.behaving.as_ref() else { return };
    let begun = Instant::now();
    let mut stepping_s = 0.0;
    let looks = Hour {
        seed: u64::from(seed),
        every,
        drain_s: f64::from(drain) * 60.0,
        stopping: if stops { 0.3 } else { 0.0 },
    };
    let held = hours::hour(behaving, &scene.run, &scene.airport.layout, &looks, |core, frame| {
        let before = Instant::now();
        core.step(frame);
        stepping_s += before.elapsed().as_secs_f64();
    });
    let Some(held) = held else { return };
    let (core, rows) = (&held.core, &held.rows);
    let count = core.flights().len();
    let extra = |direction: Direction| {
        let of = |f: &usize| core.flights()[*f].direction == direction;
        let measured = (0..count).filter(of).map(|f| core.measures(f));
        let mut all: Vec<f64> = measured.filter_map(Measures::additional_s).collect();
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        (mean, all.get((all.len() * 95 / 100).min(all.len().saturating_sub(1))).copied())
    };
    let (out, into) = (extra(Direction::Departure), extra(Direction::Arrival));
    let around: u32 = (0..count).map(|f| core.measures(f).go_arounds).sum();
    println!(
        "{name} seed {seed}: served {}/{count}{}, go-arounds {around}, additional out {:.0} s (95 % {:.0}), in {:.0} s (95 % {:.0}), \
         step {:.1} us, {:.1} s of computing",
        core.measures_of_served(),
        held.served_s.map_or(String::new(), |t| format!(" by {t:.0} s")),
        out.0,
        out.1.unwrap_or(0.0),
        into.0,
        into.1.unwrap_or(0.0),
        1e6 * stepping_s / held.frames.max(1) as f64,
        begun.elapsed().as_secs_f64()
    );
    if core.unexpected_deadlocks() > 0 {
        println!("    rings of waiting: {}", core.unexpected_deadlocks());
    }
    for row in rows.iter().filter(|r| say || !r.kept) {
        let verdict = if row.kept { "kept" } else { "BROKEN" };
        println!(
            "    {verdict:6} {:14} {:.4} (goal {}) of {}",
            row.name, row.value, row.goal, row.of
        );
        row.cases.iter().take(cases).for_each(|c| println!("           {c}"));
    }
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
