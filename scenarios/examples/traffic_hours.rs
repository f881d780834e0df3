//! Hours of traffic that behaves, on airports and with seeds of one's choice: held against what traffic has to keep (`models::traffic::check`).
//!
//! `cargo run --release -p scenarios --example traffic_hours -- [--policy P] [--rate N] [--seeds A..B] [--every FRAMES] [--stops] [--say] [--cases N] AIRPORT|SCENE.toml …`
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a command-line example that measures its own time"
)]

use models::control::clearance::ClearanceKind;
use models::traffic::check::{Checker, Given, Rules, Seen, TypeLimits, Who};
use models::traffic::core::{Notice, Order};
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
    let who = core.flights().iter().map(|f| Who {
        callsign: f.callsign.clone(),
        size: f.size,
        limits: TypeLimits::new(f.taxi_mps.0, f.taxi_acc_mps2, f.take_off, f.landing.0),
        wake: Some(f.wake),
        direction: Some(f.direction),
        due_s: f.time_s,
    });
    let mut checker = Checker::new(&scene.airport.layout, who.collect(), Rules::exact());
    let mut done_at = None;
    for frame in 1..=frames {
        core.step(frame);
        if frame % every == 0 {
            let all = (0..core.flights().len()).filter_map(|f| {
                let state = core.state(f)?;
                Some(Seen {
                    who: f,
                    position_m: state.position_m,
                    velocity_mps: state.velocity_mps.xy(),
                    heading_rad: state.heading_rad,
                })
            });
            checker.frame(frame as f64 * 0.05, &all.collect::<Vec<_>>());
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            done_at = Some(frame as f64 * 0.05);
            break;
        }
    }
    let given = core.clearances().iter().filter_map(|c| {
        Some(Given {
            who: c.flight,
            kind: ClearanceKind::of(c.kind)?,
            runway: c.runway.clone(),
            from_s: c.from_s,
            until_s: c.until_s.unwrap_or(f64::INFINITY),
        })
    });
    let rows = checker.finish(&given.collect::<Vec<_>>());
    let count = core.flights().len();
    let extra: Vec<f64> = (0..count)
        .map(|f| core.measures(f))
        .filter(|m| m.taxi_s > 0.0)
        .map(|m| m.taxi_s - m.unhindered_s)
        .collect();
    let around: u32 = (0..count).map(|f| core.measures(f).go_arounds).sum();
    println!(
        "{name} seed {seed}: served {}/{count}{}, go-arounds {around}, additional {:.0} s, {:.1} s of computing",
        core.measures_of_served(),
        done_at.map_or(String::new(), |t| format!(" by {t:.0} s")),
        extra.iter().sum::<f64>() / extra.len().max(1) as f64,
        begun.elapsed().as_secs_f64()
    );
    if core.unexpected_deadlocks() > 0 {
        println!("    rings of waiting: {}", core.unexpected_deadlocks());
    }
    for row in &rows {
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
