//! `seeds accuracy`: error against time of every model ladder.

use super::load;
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What accuracy costs in time: every rung of every model ladder on the same draws
#[derive(Args, Clone, Debug)]
pub struct AccuracyArgs {
    /// Fewer runs and scenes: about a minute instead of several
    #[arg(long)]
    quick: bool,

    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = cli::seed)]
    seed: u64,

    /// One group only (an unknown name lists what there is)
    #[arg(long, value_name = "GROUP")]
    only: Option<String>,

    /// Random scenes of the group effects, each judged target by target [default: 400, 20 with --quick]; of the group control,
    /// asked for alone, hours of traffic at each airport [default: 1]
    #[arg(long, value_name = "N")]
    scenes: Option<u64>,

    /// Scenes drawn from the seed that the filters are measured on too, so that anybody can check their order [default: 8, 2
    /// with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    unseen: Option<u32>,

    /// Recommend rungs for this time for a target and scan
    #[arg(long, value_name = "US", value_parser = budget)]
    budget_us: Option<f64>,

    /// How many targets the recommendation is for
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    targets: u64,

    /// Folder for accuracy.html, accuracy.csv, accuracy.json and a .csv of each table
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// One line of JSON on stdout: {"machine","commit","rows":[...]}
    #[arg(long)]
    json: bool,
}

/// A time in microseconds.
fn budget(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(us) if us > 0.0 && us <= 1e9 => Ok(us),
        _ => Err("a number of microseconds above 0, at most 1e9, is needed".to_owned()),
    }
}

/// Measures and reports.
#[must_use]
pub fn run(args: &AccuracyArgs) -> ExitCode {
    let options = studies::Options {
        quick: args.quick,
        seed: args.seed,
        only: args.only.clone(),
        scenes: args.scenes,
        unseen: args.unseen,
        budget: args.budget_us.map(|budget_us| (budget_us, args.targets)),
        machine: machine(),
        commit: commit(),
    };
    if let Some(Err(e)) = args.out.as_deref().map(prepared) {
        return fail(FAILED, format!("{e:#}"));
    }
    let mut shown = false;
    let mut tell = |progress: studies::Progress| {
        shown = true;
        show(&format!(
            "{} {}/{}: {}",
            progress.group, progress.done, progress.total, progress.what
        ));
    };
    // Runs of whole federations, which the crate of studies knows nothing of.
    let report = match args.only.as_deref() {
        Some(load::GROUP) => of_load(args, &options, &mut tell),
        _ => studies::run(&options, &mut tell).map_err(|e| format!("{e}, {}", load::GROUP)),
    };
    if shown {
        end_of_progress();
    }
    match report {
        Ok(report) => match write(args, &report) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => fail(FAILED, format!("{e:#}")),
        },
        Err(e) => fail(BAD_INPUT, e),
    }
}

/// The group `load`; its scenes stay in the folder of the report.
fn of_load(
    args: &AccuracyArgs,
    options: &studies::Options,
    tell: &mut dyn FnMut(studies::Progress),
) -> Result<studies::Report, String> {
    let own = std::env::temp_dir().join(format!("seeds-load-{}", std::process::id()));
    let folder = args.out.as_ref().unwrap_or(&own);
    let made = std::fs::create_dir_all(folder).context("making a folder for the scenes");
    let report = made.and_then(|()| load::study(options, folder, tell));
    if args.out.is_none() {
        let _ = std::fs::remove_dir_all(&own);
    }
    report.map_err(|e| format!("{e:#}"))
}

/// The folder of the report is there and takes files: found out before minutes of measuring.
fn prepared(folder: &Path) -> anyhow::Result<()> {
    let doing = || format!("writing the report into {}", folder.display());
    std::fs::create_dir_all(folder).with_context(doing)?;
    cli::writable(&folder.join("accuracy.html"))
}

fn write(args: &AccuracyArgs, report: &studies::Report) -> anyhow::Result<()> {
    if let Some(folder) = &args.out {
        let doing = || format!("writing the report into {}", folder.display());
        std::fs::create_dir_all(folder).with_context(doing)?;
        for (name, text) in [
            ("accuracy.html", report.to_html()),
            ("accuracy.csv", report.to_csv()),
            ("accuracy.json", report.to_json()),
        ] {
            cli::save(&folder.join(name), text)?;
        }
        for table in report.tables() {
            cli::save(&folder.join(format!("{}.csv", table.name)), table.to_csv())?;
        }
    }
    if args.json {
        show_closing(&report.closing());
        out!("{}", report.to_json_line());
    } else {
        out!("{}", report.to_text().trim_end());
    }
    Ok(())
}

#[expect(clippy::print_stderr, reason = "sentences for people beside a line for programs")]
fn show_closing(text: &str) {
    eprint!("{text}");
}

#[expect(clippy::print_stderr, reason = "progress for a person at a terminal")]
pub(super) fn show(text: &str) {
    if std::io::IsTerminal::is_terminal(&std::io::stderr()) {
        eprint!("\r\x1b[K{text}");
    } else {
        eprintln!("{text}");
    }
}

#[expect(clippy::print_stderr, reason = "progress for a person at a terminal")]
pub(super) fn end_of_progress() {
    eprintln!();
}

/// Processor and number of cores, for the head of a report.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or("unknown processor", |(_, name)| name.trim());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores")
}

/// The commit that is checked out where this was built, if that is still there.
fn commit() -> String {
    let output = std::process::Command::new("git")
        .args(["-C", env!("CARGO_MANIFEST_DIR"), "describe", "--always", "--dirty"])
        .output();
    match output {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).trim().to_owned()
        }
        _ => format!("version {}", env!("CARGO_PKG_VERSION")),
    }
}
