//! `seeds score --truth FILE --tracks FILE`: a recorded run held against its truth.

use super::score_asterix::{self, Which};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use anyhow::{Context, bail};
use clap::Args;
use models::frames::Vector2;
use models::score::areas::{AreaMap, AreaRules};
use models::score::recording::{PlotSum, Recording, Report, Target, TruthPoint};
use models::score::run::Rules;
use models::time::SimTime;
use rusqlite::{Connection, OpenFlags};
use scenarios::Scene;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use studies::score::ScoreReport;
use studies::score_files;

/// How good recorded tracks are, held against the truth: errors by area, gaps, labels, requirements
#[derive(Args, Clone, Debug)]
pub struct ScoreArgs {
    /// True states: the database of a run, or CSV (time_s, target, x_m, y_m or lat_deg, lon_deg; vx_ms, vy_ms, altitude_m)
    #[arg(long, value_name = "FILE")]
    truth: PathBuf,

    /// Tracks: the database of a run, CSV (time_s, track, x_m, y_m or lat_deg, lon_deg; vx_ms, vy_ms, label, published_s), or a recording of ASTERIX (pcap, pcapng, .ast, .ff, .rff)
    #[arg(long, value_name = "FILE")]
    tracks: PathBuf,

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

    /// Time between two scans, s [default: the database's, else 1]
    #[arg(long, value_name = "S")]
    scan: Option<f64>,

    /// Writes the report as a page
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
    let report = match scored(args) {
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

fn scored(args: &ScoreArgs) -> anyhow::Result<ScoreReport> {
    let truth = Source::open(&args.truth)?;
    let recording = score_asterix::is_recording(&args.tracks)?;
    let tracks = if recording { Source::Recording } else { Source::open(&args.tracks)? };
    let mut notes = Vec::new();
    let named = [&truth, &tracks].into_iter().find_map(|s| s.fact("scene"));
    let scene = scene(args.scene.as_deref(), named.as_deref(), &mut notes)?;
    let place = scene.as_ref().map(|s| |lat: f64, lon: f64| s.airport.local_m(lat, lon));
    let place: score_files::Place<'_> =
        place.as_ref().map(|p| p as &dyn Fn(f64, f64) -> Vector2<f64>);
    let targets = truth.targets(place).with_context(|| args.truth.display().to_string())?;
    let reports = if recording {
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
        let (reports, remarks) = score_asterix::reports(&args.tracks, &which, place)
            .with_context(|| args.tracks.display().to_string())?;
        notes.extend(remarks);
        reports
    } else {
        tracks.reports(place).with_context(|| args.tracks.display().to_string())?
    };
    let plots = tracks.plots()?;
    let mut recording = Recording { targets, reports, plots };
    let left_out = recording.put_in_order();
    if left_out > 0 {
        notes.push(format!("{left_out} rows with numbers that are not finite were left out."));
    }
    if recording.reports.is_empty() {
        bail!("{}: no track", args.tracks.display());
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
    let scan_s = args.scan.or_else(|| tracks.fact("scan_s")?.parse().ok()).unwrap_or(1.0);
    let rules = Rules { scan_s, hole_s: (2.5 * scan_s).max(2.5), ..Rules::default() };
    let areas = scene.as_ref().map_or_else(
        || AreaMap::open(AreaRules::default()),
        |s| AreaMap::of(&s.airport.layout, AreaRules::default()),
    );
    let title = format!("{} against {}", args.tracks.display(), args.truth.display());
    let report = ScoreReport::of(title, notes, &recording, &areas, &rules);
    Ok(report.with_second_ago(&recording, tracks.second_ago(), &areas, &rules))
}

/// Longest recording that is scored, s.
const MOST_SPAN_S: f64 = 7.0 * 86_400.0;

/// From the first time to the last one, of truth and tracks together, s.
fn spans_s(recording: &Recording) -> f64 {
    let truth = recording.targets.iter().flat_map(|t| &t.path).map(|p| p.time.s());
    let times = || truth.clone().chain(recording.reports.iter().map(|r| r.time.s()));
    times().fold(f64::MIN, f64::max) - times().fold(f64::MAX, f64::min)
}

/// The scene that says what is where: the one asked for has to be there, the database's may be gone.
fn scene(
    asked: Option<&str>,
    named: Option<&str>,
    notes: &mut Vec<String>,
) -> anyhow::Result<Option<Scene>> {
    let load = |name: &str| scenarios::load_without_truth(&scenarios::locate(name));
    if let Some(asked) = asked {
        return Ok(Some(load(asked)?));
    }
    let found = named.and_then(|name| load(name).ok());
    notes.push(match (&found, named) {
        (Some(s), _) => format!("Areas are those of scene {} ({}).", s.name, s.airport.layout.icao),
        (None, Some(name)) => {
            format!("Scene {name} is not here: areas are unknown; name one with --scene.")
        }
        (None, None) => "Areas are unknown: name the scene of the airport with --scene.".into(),
    });
    Ok(found)
}

/// Octets of the largest text that is read.
const LARGEST_TEXT: u64 = 1 << 30;

/// A file with truth or tracks.
enum Source {
    Database(Connection),
    Text(String),
    /// A recording of ASTERIX, which is read by [`score_asterix`].
    Recording,
}

impl Source {
    fn open(path: &Path) -> anyhow::Result<Self> {
        let doing = || path.display().to_string();
        let mut head = [0; 15];
        let mut file = std::fs::File::open(path).with_context(doing)?;
        let length = file.read(&mut head).with_context(doing)?;
        if &head[..length] == b"SQLite format 3" {
            let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
            return Ok(Self::Database(
                Connection::open_with_flags(path, flags).with_context(doing)?,
            ));
        }
        let mut text = head[..length].to_vec();
        // Read on from where it is (a pipe has no second beginning); a device may never end.
        file.take(LARGEST_TEXT).read_to_end(&mut text).with_context(doing)?;
        if text.len() as u64 > LARGEST_TEXT {
            bail!("{}: longer than {} MiB", path.display(), LARGEST_TEXT >> 20);
        }
        match String::from_utf8(text) {
            Ok(text) => Ok(Self::Text(text)),
            Err(_) => bail!("{}: neither the database of a run nor text", path.display()),
        }
    }

    /// A figure of the run.
    fn fact(&self, name: &str) -> Option<String> {
        let Self::Database(database) = self else { return None };
        database.query_row("SELECT value FROM run WHERE name = ?", [name], |r| r.get(0)).ok()
    }

    fn targets(&self, place: score_files::Place<'_>) -> anyhow::Result<Vec<Target>> {
        let database = match self {
            Self::Text(text) => return Ok(score_files::truth(text, place)?),
            Self::Database(database) => database,
            Self::Recording => return Ok(Vec::new()),
        };
        let mut query = database.prepare(
            "SELECT entity, callsign, time_ns, x_m, y_m, vx_ms, vy_ms, altitude_m \
             FROM truth JOIN scans USING (scan)",
        )?;
        let mut rows = query.query([])?;
        let mut targets: BTreeMap<i64, Target> = BTreeMap::new();
        while let Some(row) = rows.next()? {
            let target = targets.entry(row.get(0)?).or_default();
            target.name = row.get::<_, Option<String>>(1)?.unwrap_or_default();
            target.path.push(TruthPoint {
                time: SimTime(row.get(2)?),
                position_m: Vector2::new(row.get(3)?, row.get(4)?),
                velocity_mps: Vector2::new(row.get(5)?, row.get(6)?),
                height_m: row.get(7)?,
            });
        }
        Ok(targets.into_values().collect())
    }

    /// Reports; of our own runs the publication is late by what the scan took.
    fn reports(&self, place: score_files::Place<'_>) -> anyhow::Result<Vec<Report>> {
        let database = match self {
            Self::Text(text) => return Ok(score_files::tracks(text, place)?),
            Self::Database(database) => database,
            Self::Recording => return Ok(Vec::new()),
        };
        let mut query = database.prepare(
            "SELECT track, time_ns, took_us, x_m, y_m, vx_ms, vy_ms, callsign \
             FROM tracks JOIN scans USING (scan) WHERE status NOT IN ('last', 'tentative')",
        )?;
        let reports = query.query_map([], |row| {
            let time: i64 = row.get(1)?;
            let took_us: Option<i64> = row.get(2)?;
            Ok(Report {
                track: row.get::<_, i64>(0)?.unsigned_abs(),
                time: SimTime(time),
                published: took_us.map(|us| SimTime(time + us * 1000)),
                position_m: Vector2::new(row.get(3)?, row.get(4)?),
                velocity_mps: Some(Vector2::new(row.get(5)?, row.get(6)?)),
                label: row.get::<_, Option<String>>(7)?.unwrap_or_default(),
            })
        })?;
        Ok(reports.collect::<Result<_, _>>()?)
    }

    /// The tracks one scan earlier, as they were revised; none where a log does not hold them.
    fn second_ago(&self) -> Vec<Report> {
        let Self::Database(database) = self else { return Vec::new() };
        let query = database.prepare(
            "SELECT track, lag_time_ns, time_ns, lag_x_m, lag_y_m, callsign FROM tracks JOIN scans USING (scan) \
             WHERE status NOT IN ('last', 'tentative') AND lag_time_ns IS NOT NULL",
        );
        let Ok(mut query) = query else { return Vec::new() };
        let reports = query.query_map([], |row| {
            Ok(Report {
                track: row.get::<_, i64>(0)?.unsigned_abs(),
                time: SimTime(row.get(1)?),
                published: Some(SimTime(row.get(2)?)),
                position_m: Vector2::new(row.get(3)?, row.get(4)?),
                velocity_mps: None,
                label: row.get::<_, Option<String>>(5)?.unwrap_or_default(),
            })
        });
        reports.map_or_else(|_| Vec::new(), |rows| rows.flatten().collect())
    }

    /// The radars' plots of targets.
    fn plots(&self) -> anyhow::Result<PlotSum> {
        let Self::Database(database) = self else { return Ok(PlotSum::default()) };
        let mut query = database.prepare(
            "SELECT error_m FROM plots \
             WHERE kind = 'asde' AND cause IS NOT NULL AND error_m IS NOT NULL",
        )?;
        let errors_m = query.query_map([], |row| row.get(0))?;
        Ok(PlotSum::of(errors_m.collect::<Result<_, _>>()?))
    }
}
