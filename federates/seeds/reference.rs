//! `seeds reference RUN`: where the targets of a finished run were, by a smoother over all its plots, and what its sensors err by.

use super::open::RUNS;
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::runtime::messages::{ScanReport, TrackMessage};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::source::Source;
use crate::viewer_logger::{beside, kept_scene, opened};
use anyhow::{Context, ensure};
use clap::Args;
use models::frames::{Matrix2, Vector2};
use models::fusion::reference::{ReferenceRun, reference};
use models::plot::{Callsign, Identity, Plot};
use models::score::recording::{Target, TruthPoint};
use models::time::SimTime;
use models::track::TrackStatus;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use studies::reference::{Compared, Said, compared, config};
use studies::reference_report as report;

/// Where the targets of a finished run were, by a smoother over all its plots, as a reference for recordings without truth
#[derive(Args, Clone, Debug)]
pub struct ReferenceArgs {
    /// The run: a folder of runs/ or its name there, its database, or `last`
    #[arg(value_name = "RUN")]
    run: String,

    /// Scene whose sensors, sizes and flights are assumed [default: the run's own, out of its log]
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,

    /// Writes the trajectories as CSV: one line a target and scan, with covariances
    #[arg(long, short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,

    /// One JSON object on stdout: errors of sensors, trajectories, score
    #[arg(long)]
    json: bool,
}

/// Makes the reference and reports.
#[must_use]
pub fn run(args: &ReferenceArgs) -> ExitCode {
    if let Some(Err(e)) = args.out.as_deref().map(cli::writable) {
        return fail(FAILED, format!("{e:#}"));
    }
    let found = match opened::databases(&args.run, Path::new(RUNS)) {
        Ok(found) => found,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let Some(database) = found.first() else { return fail(BAD_INPUT, "no run was named") };
    let made = match made(database, args.scene.as_deref()) {
        Ok(made) => made,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    match write(args, &made) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

struct Made {
    scene: Scene,
    run: ReferenceRun,
    score: Option<Compared>,
}

fn write(args: &ReferenceArgs, made: &Made) -> anyhow::Result<()> {
    if let Some(path) = &args.out {
        cli::save(path, report::csv(&made.run))?;
    }
    if args.json {
        out!("{}", report::json(&made.run, made.score.as_ref()));
        return Ok(());
    }
    let sensor = |number: u16| {
        let known = made.scene.sensors.iter().find(|s| s.id.0 == number);
        known.map_or_else(|| format!("sensor {number}"), |s| s.name.clone())
    };
    out!("{}", report::text(&made.run, made.score.as_ref(), &sensor).trim_end());
    Ok(())
}

fn made(database: &Path, scene: Option<&str>) -> anyhow::Result<Made> {
    let archive = Archive::open(database)?;
    let scene = match scene {
        Some(name) => scenarios::load_without_truth(&scenarios::locate(name))?,
        None => kept_scene::load(&archive)
            .context("the run's own scene; name another one with --scene")?,
    };
    let flights = kept_scene::flights(&archive, &scene)?;
    let log = Log::read(&archive)?;
    ensure!(
        log.scans.iter().any(|(_, plots)| !plots.is_empty()),
        "{}: the log holds no plots",
        database.display()
    );
    let run = reference(&config(&scene), &flights, &log.scans)?;
    let there = log.targets.values().any(|t| !t.path.is_empty());
    let score = there.then(|| {
        let place = |target: u64, time: SimTime| {
            let at = log.targets.get(&target)?.at(time, LONGEST_HOLE_S)?;
            Some((at.position_m, at.velocity_mps))
        };
        compared(&run, &log.causes, &log.said, &place)
    });
    Ok(Made { scene, run, score })
}

/// The true state of a target is known between two scans that are no farther apart than this, s.
const LONGEST_HOLE_S: f64 = 2.5;

/// What a log says of plots, truth, and what was published.
#[derive(Default)]
struct Log {
    scans: Vec<(SimTime, Vec<Plot>)>,
    /// Of each plot: whom it came from.
    causes: Vec<Vec<Option<u64>>>,
    targets: BTreeMap<u64, Target>,
    said: Vec<Said>,
}

impl Log {
    fn read(archive: &Archive) -> anyhow::Result<Self> {
        let mut log = Self::default();
        let (first, last) = archive.range().unwrap_or((1, 0));
        for scan in first..=last {
            if let Some(report) = archive.report(scan).context("reading the log")? {
                log.take(&report);
            }
        }
        Ok(log)
    }

    fn take(&mut self, report: &ScanReport) {
        let time = SimTime(report.time_ns);
        let mut names: BTreeMap<&str, u64> = BTreeMap::new();
        for truth in &report.truth {
            names.insert(&truth.callsign, truth.key());
            let target = self.targets.entry(truth.key()).or_default();
            let [vx, vy, _] = truth.velocity_mps;
            target.path.push(TruthPoint {
                time,
                position_m: truth.position_m.xy(),
                velocity_mps: Vector2::new(vx, vy),
                height_m: Some(truth.position_m.z),
            });
        }
        let (mut plots, mut causes) = (Vec::new(), Vec::new());
        for message in &report.plots {
            let Some(mut plot) = beside::plot_of(message) else { continue };
            // What an outsider's plot calls its target, where that is no address.
            if plot.identity.is_none() && !message.identity.is_empty() {
                plot.identity = Some(Identity::Callsign(Callsign::new(&message.identity)));
            }
            plots.push(plot);
            causes.push(names.get(message.cause.as_str()).copied());
        }
        self.scans.push((time, plots));
        self.causes.push(causes);
        let followed = report.followed();
        let shown = |status| !matches!(status, TrackStatus::Last | TrackStatus::Tentative);
        for track in report.tracks.iter().filter(|t| shown(t.status)) {
            let Some((index, _)) = followed.get(&track.number) else { continue };
            self.said.extend(said(track, time, report.truth[*index].key()));
        }
    }
}

/// A track as published, and one scan ago.
fn said(track: &TrackMessage, time: SimTime, target: u64) -> impl Iterator<Item = Said> {
    let of = |time, ago, position_m: [f64; 2], [ee, en, nn]: [f64; 3]| Said {
        time,
        ago,
        target,
        way: None,
        position_m: position_m.into(),
        cov_m2: Matrix2::new(ee, en, en, nn),
    };
    let now = of(time, false, track.position_m.into(), track.cov_m2);
    let ago =
        track.lag.map(|lag| of(SimTime(lag.time_ns), true, lag.position_m.into(), lag.cov_m2));
    std::iter::once(now).chain(ago)
}
