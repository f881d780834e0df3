//! `seeds score --truth FILE --tracks FILE`: a recorded run held against its truth; `--alerts FILE`: a safety net ([`score_alerts`]).

use super::score_alerts;
use super::score_asterix::{self, Which};
use super::score_source::{Source, scene};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use anyhow::{Context, bail};
use clap::Args;
use models::frames::Point2;
use models::score::areas::{AreaMap, AreaRules};
use models::score::recording::Recording;
use models::score::run::Rules;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use studies::score::ScoreReport;
use studies::score_files;

/// How good recorded tracks, or the alerts of a safety net, are, held against the truth of their run
#[derive(Args, Clone, Debug)]
pub struct ScoreArgs {
    /// True states: the database of a run, what `seeds export` made of it as CSV, or CSV (time_s, target, x_m, y_m or lat_deg, lon_deg; vx_ms, vy_ms, height_m)
    #[arg(long, value_name = "FILE")]
    truth: PathBuf,

    /// Tracks: the database of a run, what `seeds export` made of it as CSV, CSV (time_s, track, x_m, y_m or lat_deg, lon_deg; vx_ms, vy_ms, label, published_s), or a recording of ASTERIX (pcap, pcapng, .ast, .ff, .rff)
    #[arg(long, value_name = "FILE", required_unless_present = "alerts")]
    tracks: Option<PathBuf>,

    /// Alerts of a safety net, held against those of the rules on the exact truth of the run: CSV (time_s, kind, subjects; end_s, id), or the database of a run
    #[arg(long, value_name = "FILE", conflicts_with_all = ["tracks", "source", "category", "shift", "scan"])]
    alerts: Option<PathBuf>,

    /// Of a recording only the tracks of this sender
    #[arg(long, value_name = "SAC/SIC", value_parser = score_asterix::source_of)]
    source: Option<(u8, u8)>,

    /// Of a recording only the tracks in this category: 10, 11, 20, 21 or 62
    #[arg(long, value_name = "N")]
    category: Option<u8>,

    /// Seconds that --asterix-time wall added to the times of day; tells the latency too [default: what the truth's database says]
    #[arg(long, value_name = "S")]
    shift: Option<f64>,

    /// Scene whose airport says what is runway, taxiway, apron and stand [default: the one that the database names]
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,

    /// Time between two scans, s [default: the database's, else the median step of the tracks]
    #[arg(long, value_name = "S")]
    scan: Option<f64>,

    /// Writes the report as a page; of alerts as CSV or JSON where the file is called so
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// One JSON object on stdout
    #[arg(long)]
    json: bool,
}

/// Scores and reports.
#[must_use]
pub fn run(args: &ScoreArgs) -> ExitCode {
    if args.scan.is_some_and(|s| !(0.01..=60.0).contains(&s)) {
        return fail(BAD_INPUT, "--scan: a scan lasts 0.01 to 60 s");
    }
    if let Some(Err(e)) = args.out.as_deref().map(cli::writable) {
        return fail(FAILED, format!("{e:#}"));
    }
    if let Some(alerts) = &args.alerts {
        let report = match score_alerts::scored(&args.truth, alerts, args.scene.as_deref()) {
            Ok(report) => report,
            Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
        };
        return match score_alerts::write(&report, args.out.as_deref(), args.json) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => fail(FAILED, format!("{e:#}")),
        };
    }
    let tracks = args.tracks.as_deref().unwrap_or(Path::new(""));
    let report = match scored(args, tracks) {
        Ok(report) => report,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    match write(args, &report) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn write(args: &ScoreArgs, report: &ScoreReport) -> anyhow::Result<()> {
    if let Some(path) = &args.out {
        cli::save(path, report.to_html())?;
    }
    if args.json {
        out!("{}", report.to_json());
    } else {
        out!("{}", report.to_text().trim_end());
    }
    Ok(())
}

fn scored(args: &ScoreArgs, path: &Path) -> anyhow::Result<ScoreReport> {
    let truth = Source::open(&args.truth)?;
    let tracks = Source::tracks(path)?;
    let mut notes = Vec::new();
    let scene = scene(args.scene.as_deref(), &[&truth, &tracks], &mut notes)?;
    let place = scene.as_ref().map(|s| |lat: f64, lon: f64| s.airport.local_m(lat, lon));
    let place: score_files::Place<'_> =
        place.as_ref().map(|p| p as &dyn Fn(f64, f64) -> Point2<f64>);
    let targets = truth.targets(place).with_context(|| args.truth.display().to_string())?;
    let reports = if let Source::Recording(read) = &tracks {
        let start = truth.fact("start_utc_ns").and_then(|ns| ns.parse().ok());
        let which = Which {
            category: args.category,
            source: args.source,
            start_utc_ns: start.or_else(|| scene.as_ref().map(|s| s.run.start_utc_ns)),
            // What the run's own gateway added, where its log says so.
            shift_s: args.shift.or_else(|| {
                let shift_ns: f64 = truth.fact("asterix_shift_ns")?.parse().ok()?;
                Some(shift_ns * 1e-9)
            }),
        };
        let (reports, remarks) = score_asterix::reports(read, &which, place)
            .with_context(|| path.display().to_string())?;
        notes.extend(remarks);
        reports
    } else {
        tracks.reports(place).with_context(|| path.display().to_string())?
    };
    let plots = tracks.plots()?;
    let mut recording = Recording { targets, reports, plots };
    let left_out = recording.put_in_order();
    if left_out > 0 {
        notes.push(format!(
            "{left_out} rows were left out: numbers that are not finite, or a target's second state at the same time."
        ));
    }
    if recording.reports.is_empty() {
        bail!("{}: no track", path.display());
    }
    let spans_s = spans_s(&recording);
    if spans_s > MOST_SPAN_S {
        bail!(
            "truth and tracks span {spans_s:.0} s, at most {MOST_SPAN_S:.0} s (a week) can be scored: do both count from the same time?"
        );
    }
    if plots.left_out > 0 {
        notes.push(format!(
            "{} of {} radar plots lie more than {:.0} m (up to {:.0} m) from the target that caused them, as echoes of a \
             pulse before the last do: they are left out of the plots' error, and so of the reduction.",
            plots.left_out,
            plots.left_out + plots.count,
            plots.limit_m,
            plots.farthest_m,
        ));
    }
    if plots.count > 0 {
        notes.push(
            "The reduction holds published tracks, predicted to the end of the scan, against plots at their own \
             time: it is less than the filter's own gain."
                .into(),
        );
    }
    let scan_s = args.scan.or_else(|| tracks.fact("scan_s")?.parse().ok());
    let scan_s = scan_s.unwrap_or_else(|| {
        let step_s = median_step_s(&recording).unwrap_or(1.0);
        notes.push(format!(
            "Scans last {step_s} s, the median step of the tracks; --scan says another."
        ));
        step_s
    });
    if is_above_the_ground(&recording, &AreaRules::default()) {
        notes.push(format!(
            "No target comes below {} m, so that none counts as on the ground: heights of targets (height_m, altitude_m) are those above \
             the ground, not above the sea.",
            AreaRules::default().airborne_m
        ));
    }
    let rules = rules(&recording, scan_s);
    if rules.hole_s > (2.5 * scan_s).max(2.5) {
        notes.push(format!(
            "Truth has fewer states than scans: between them it is interpolated, over {:.1} s at most.",
            rules.hole_s
        ));
    }
    let areas = scene.as_ref().map_or_else(
        || AreaMap::open(AreaRules::default()),
        |s| AreaMap::of(&s.airport.layout, AreaRules::default()),
    );
    let title = format!("{} against {}", path.display(), args.truth.display());
    let report = ScoreReport::of(title, notes, &recording, &areas, &rules);
    Ok(report.with_second_ago(&recording, tracks.second_ago(), &areas, &rules))
}

/// The usual time between two reports of a track, to the millisecond, within what a scan may last.
fn median_step_s(recording: &Recording) -> Option<f64> {
    let mut before = BTreeMap::new();
    let steps = recording.reports.iter().filter_map(|r| {
        let last = before.insert(r.track, r.time)?;
        Some(r.time.since_s(last)).filter(|s| *s > 0.0)
    });
    let mut steps_s: Vec<f64> = steps.collect();
    steps_s.sort_by(f64::total_cmp);
    let middle = *steps_s.get(steps_s.len() / 2)?;
    Some((middle * 1000.0).round().clamp(10.0, 60_000.0) / 1000.0)
}

/// Whether heights are known, and all of them are those of aircraft in flight.
fn is_above_the_ground(recording: &Recording, rules: &AreaRules) -> bool {
    let points = || recording.targets.iter().flat_map(|t| &t.path);
    points().next().is_some()
        && points().all(|p| p.height_m.is_some_and(|height| height > rules.airborne_m))
}

/// Rules for a time between scans; truth is interpolated over two and a half of its own median steps at least.
fn rules(recording: &Recording, scan_s: f64) -> Rules {
    let steps = recording.targets.iter().flat_map(|t| t.path.windows(2));
    let mut steps_s: Vec<f64> = steps.map(|w| w[1].time.since_s(w[0].time)).collect();
    steps_s.sort_by(f64::total_cmp);
    let step_s = steps_s.get(steps_s.len() / 2).copied().unwrap_or(0.0);
    Rules { scan_s, hole_s: (2.5 * scan_s.max(step_s)).max(2.5), ..Rules::default() }
}

/// Longest recording that is scored, s.
const MOST_SPAN_S: f64 = 7.0 * 86_400.0;

/// From the first time to the last one, of truth and tracks together, s.
fn spans_s(recording: &Recording) -> f64 {
    let truth = recording.targets.iter().flat_map(|t| &t.path).map(|p| p.time.s());
    let times = || truth.clone().chain(recording.reports.iter().map(|r| r.time.s()));
    times().fold(f64::MIN, f64::max) - times().fold(f64::MAX, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::Vector2;
    use models::score::recording::{Report, Target, TruthPoint};
    use models::score::run::score;
    use models::time::SimTime;

    #[test]
    fn a_good_track_is_not_false_where_truth_has_few_states() {
        let at = |s: f64| (SimTime::from_s(s), Point2::new(10.0 * s, 0.0), Vector2::new(10.0, 0.0));
        for step in [1, 3, 5] {
            let path = (0..=60).step_by(step).map(|s| {
                let (time, position_m, velocity_mps) = at(f64::from(s));
                TruthPoint { time, position_m, velocity_mps, height_m: Some(0.0) }
            });
            let targets = vec![Target { name: "A".into(), path: path.collect() }];
            let reports = (0..=60).map(|s| {
                let (time, position_m, velocity) = at(f64::from(s));
                let (published, label) = (None, String::new());
                Report {
                    track: 1,
                    time,
                    published,
                    position_m,
                    velocity_mps: Some(velocity),
                    label,
                }
            });
            let recording =
                Recording { targets, reports: reports.collect(), ..Recording::default() };
            let areas = AreaMap::open(AreaRules::default());
            let found = score(&recording, &areas, &rules(&recording, 1.0));
            let false_reports: u64 = found.areas.iter().map(|a| a.false_reports(60.0).0).sum();
            assert_eq!((false_reports, found.gospa.false_m2), (0, 0.0), "a state every {step} s");
            let due: u64 = found.areas.iter().map(|a| a.target_scans()).sum();
            assert!(due >= 60, "a state every {step} s: {due} scans");
        }
    }

    fn report(track: u64, s: f64) -> Report {
        Report {
            track,
            time: SimTime::from_s(s),
            published: None,
            position_m: Point2::new(10.0 * s, 0.0),
            velocity_mps: None,
            label: String::new(),
        }
    }

    #[test]
    fn scans_last_as_long_as_a_track_waits_for_its_next_report() {
        for step_s in [0.25, 1.0, 4.0, 0.001, 500.0] {
            // Two tracks by turns; one of them misses a fifth of its reports.
            let one = (0..50).map(|k| report(1, f64::from(k) * step_s));
            let kept = (0..50).filter(|k| k % 5 != 3);
            let other = kept.map(|k| report(2, (f64::from(k) + 0.4) * step_s));
            let mut recording =
                Recording { reports: one.chain(other).collect(), ..Recording::default() };
            recording.put_in_order();
            assert_eq!(median_step_s(&recording), Some(step_s.clamp(0.01, 60.0)), "{step_s} s");
        }
        assert_eq!(median_step_s(&Recording::default()), None);
    }

    #[test]
    fn heights_above_the_sea_are_noticed() {
        let of = |heights_m: [Option<f64>; 2]| {
            let path = heights_m.map(|height_m| TruthPoint {
                time: SimTime::ZERO,
                position_m: Point2::origin(),
                velocity_mps: Vector2::zeros(),
                height_m,
            });
            let targets = vec![Target { name: "A".into(), path: path.to_vec() }];
            let recording = Recording { targets, ..Recording::default() };
            is_above_the_ground(&recording, &AreaRules::default())
        };
        assert!(of([Some(432.0), Some(440.0)]));
        assert!(!of([Some(432.0), Some(0.0)]) && !of([Some(432.0), None]) && !of([None, None]));
    }
}
