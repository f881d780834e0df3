//! `seeds fit SCENE`: the off-line approach, figures fitted from a scene's own sensors and tracker.

use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail, load_scene};
use crate::smdfm::setup;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use studies::offline::{self, FitReport};

/// Fits off-line figures of a scene's sensors and tracker, and compares both ways in accuracy and time
#[derive(Args, Clone, Debug)]
pub struct FitArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// First seed; the figures are fitted on as many seeds from here as --runs, compared on the next ones
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = cli::seed)]
    seed: u64,

    /// Runs to fit on, and as many to compare on
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..=1000))]
    runs: u64,

    /// Simulated time of each run, s [default: the scene's]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,

    /// Writes the figures: JSON, or a page if the name ends in .html
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// One JSON object on stdout
    #[arg(long)]
    json: bool,
}

/// Fits, compares and reports.
#[must_use]
pub fn run(args: &FitArgs) -> ExitCode {
    let scene = match load_scene(&args.scene) {
        Ok(scene) => scene,
        Err(code) => return code,
    };
    let whole = scene.run.duration.s();
    let seconds = args.seconds.unwrap_or(whole);
    if !(1.0..=whole).contains(&seconds) {
        return fail(BAD_INPUT, format!("--seconds {seconds}: the scene lasts 1 to {whole} s"));
    }
    if let Err(e) = offline::has_movements(&scene, seconds) {
        return fail(BAD_INPUT, e);
    }
    if let Some(Err(e)) = args.out.as_deref().map(cli::writable) {
        return fail(FAILED, format!("{e:#}"));
    }
    let make = || setup::make_sensors(&scene);
    let seeds = (args.seed, args.runs);
    let version = env!("CARGO_PKG_VERSION");
    let report = offline::run(&scene, &make, seeds, seconds, version, &mut |what| show(what));
    match report {
        Ok(report) => match write(args, &report) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => fail(FAILED, format!("{e:#}")),
        },
        Err(e) => fail(FAILED, e),
    }
}

#[expect(clippy::print_stderr, reason = "progress for a person at a terminal")]
fn show(what: &str) {
    eprintln!("{what}");
}

fn write(args: &FitArgs, report: &FitReport) -> anyhow::Result<()> {
    if let Some(path) = &args.out {
        let page = path.extension().is_some_and(|e| e == "html");
        let text = if page { report.to_html() } else { report.to_json().to_string() };
        cli::save(path, text)?;
    }
    if args.json {
        out!("{}", report.to_json());
    } else {
        out!("{}", report.to_text().trim_end());
    }
    Ok(())
}
