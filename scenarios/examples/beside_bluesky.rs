//! What a step of traffic costs beside BlueSky in the same run, in processor time: ten, a hundred and a thousand movers, by draw.
//!
//! `cargo run --release -p scenarios --example beside_bluesky -- [--draws N] [PYTHON]`; PYTHON has BlueSky (`clients/bluesky/install.sh`).
#![allow(clippy::print_stdout, reason = "a command-line example")]

#[path = "../../models/benches/common/cpu_time.rs"]
mod cpu_time;
#[path = "../benches/common/linked.rs"]
mod linked;

use cpu_time::CpuTime;
use criterion::measurement::Measurement as _;
use linked::{moving, there, when_there};
use scenarios::Scene;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Frames over which steps are measured: two minutes.
const FRAMES: i64 = 2400;

fn main() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut draws, mut python) = (3, here.join("../clients/bluesky/.venv/bin/python"));
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--draws" => draws = args.next().and_then(|n| n.parse().ok()).unwrap_or(draws),
            _ => python = PathBuf::from(arg),
        }
    }
    let bluesky = python.exists();
    if !bluesky {
        println!("skipped BlueSky: no {} (clients/bluesky/install.sh makes it)", python.display());
    }
    let folder = std::env::temp_dir().join(format!("beside-bluesky-{}", std::process::id()));
    if let Err(e) = std::fs::create_dir_all(&folder) {
        println!("{}: {e}", folder.display());
        return;
    }
    let (names, per_h) = linked::LARGE;
    let scenes = [
        (10, linked::one("EHAM", 15.0)),
        (100, linked::together(&folder, &["EHAM", "EGCC", "LSZH", "LIMC", "LZIB", "XSYN"], 100.0)),
        (1000, linked::beside(&folder, &names, per_h, 1)),
    ];
    println!(
        "draw  there  under way  us a step  us a mover   BlueSky us a step, a mover   with conflicts us a step, a mover"
    );
    for (count, scene) in &scenes {
        let scene = match scene {
            Ok(scene) => scene,
            Err(e) => {
                println!("{count} movers: {e}");
                continue;
            }
        };
        for draw in 1..=draws {
            let Some((there, moving, step_us)) = ours(scene, draw, *count) else { continue };
            let mut line = format!(
                "{draw:4} {there:6} {moving:10} {step_us:10.1} {:11.3}",
                step_us / there.max(1) as f64
            );
            for conflicts in [false, true].into_iter().filter(|_| bluesky) {
                line += &match theirs(&python, here, there, draw, conflicts) {
                    Ok(us) => format!("   {us:10.1} {:10.3}", us / there.max(1) as f64),
                    Err(e) => format!("   BlueSky: {e}"),
                };
            }
            println!("{line}");
        }
    }
    drop(std::fs::remove_dir_all(&folder));
}

/// Who is there, who of them is under way, and a step of two minutes from then on, us.
fn ours(scene: &Scene, seed: u64, count: usize) -> Option<(usize, usize, f64)> {
    let (mut core, first) = when_there(scene, seed, count)?;
    let (there, moving) = (there(&core), moving(&core));
    let before = CpuTime.start();
    (first..first + FRAMES).for_each(|frame| core.step(frame));
    let spent = CpuTime.end(before);
    Some((there, moving, 1e6 * spent.as_secs_f64() / FRAMES as f64))
}

/// A step of BlueSky with so many aircraft, us.
fn theirs(
    python: &Path,
    here: &Path,
    count: usize,
    seed: u64,
    conflicts: bool,
) -> Result<f64, String> {
    let mut command = Command::new(python);
    command.arg(here.join("examples/bluesky_steps.py"));
    command.args([count.to_string(), seed.to_string(), "400".into()]);
    command.args(conflicts.then_some("conflicts")).env("OMP_NUM_THREADS", "1");
    let output = command.output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|l| l.strip_prefix("STEP_US "));
    let us = line.and_then(|l| l.split(' ').next()?.parse().ok());
    us.ok_or_else(|| {
        format!("said nothing of its steps: {}", String::from_utf8_lossy(&output.stderr))
    })
}
