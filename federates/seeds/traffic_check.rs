//! `seeds traffic check RUN`: the traffic of a finished run, held against what traffic has to keep.
//!
//! Reads the database of the run and the layout of its scene, nothing else: poses once a scan, clearances, flights.

use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail, out};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::{kept_scene, opened};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use models::control::clearance::ClearanceKind;
use models::frames::{Point3, Vector2};
use models::time::SimTime;
use models::traffic::check::{CHECKED_WITHIN_M, Checker, Given, Row, Rules, Seen, TypeLimits, Who};
use models::traffic::core::Direction;
use models::traffic::outline::Size;
use models::wake::Wake;
use rusqlite::{Connection, OpenFlags};
use scenarios::Scene;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

/// Overlaps, gridlocks, pavement, holding positions, runways, wake, limits and service of a finished run; exit code 1 if anything is broken
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// A folder of runs/ or its name there, a database (run.sqlite), or `last` for the newest
    #[arg(value_name = "RUN")]
    run: String,

    /// Scene whose airport it is [default: the one that the database holds]
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,

    /// Form of the table
    #[arg(long, value_enum, default_value_t = Form::Text)]
    form: Form,

    /// Flights that are due so long before the end have to be served, s
    #[arg(long, value_name = "S", default_value_t = 1800.0, value_parser = cli::seconds)]
    serve: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    Text,
    Json,
    Csv,
}

/// Checks and tells.
#[must_use]
pub fn run(args: &CheckArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    let found = match opened::databases(&args.run, Path::new(super::open::RUNS)) {
        Ok(found) => found,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let mut all_kept = true;
    for database in found {
        match check(&database, args) {
            Ok(rows) => {
                all_kept &= rows.iter().all(|r| r.kept);
                tell(&database.display().to_string(), &rows, args.form);
            }
            Err(error) => return fail(BAD_INPUT, format!("{error:#}")),
        }
    }
    if all_kept { ExitCode::SUCCESS } else { ExitCode::from(FAILED) }
}

fn tell(name: &str, rows: &[Row], form: Form) {
    match form {
        Form::Json => {
            let rows = rows.iter().map(|r| {
                json!({
                    "check": r.name, "value": r.value, "goal": r.goal, "kept": r.kept, "of": r.of,
                    "cases": r.cases,
                })
            });
            let kept = rows.clone().all(|r| r["kept"] == json!(true));
            let rows: Vec<_> = rows.collect();
            out!("{}", json!({ "run": name, "kept": kept, "checks": rows }));
        }
        Form::Csv => {
            out!("run,check,value,of,goal,kept,first_case");
            let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
            for r in rows {
                let case = quoted(r.cases.first().map_or("", |c| c));
                let (value, of, kept) = (r.value, r.of, r.kept);
                out!("{},{},{value},{of},{},{kept},{case}", quoted(name), r.name, quoted(&r.goal));
            }
        }
        Form::Text => {
            out!("{name}");
            for r in rows {
                let verdict = if r.kept { "kept" } else { "BROKEN" };
                let value = if r.value.fract() == 0.0 {
                    format!("{}", r.value)
                } else {
                    format!("{:.4}", r.value)
                };
                out!("{verdict:7} {:14} {value:>8} of {:<8} goal {}", r.name, r.of, r.goal);
                r.cases.iter().for_each(|c| out!("        {c}"));
            }
        }
    }
}

/// The table of one run.
fn check(path: &Path, args: &CheckArgs) -> anyhow::Result<Vec<Row>> {
    let archive = Archive::open(path)?;
    let scene = match &args.scene {
        Some(name) => scenarios::load_without_truth(&scenarios::locate(name))?,
        None => scene_of(&archive)?,
    };
    drop(archive);
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database =
        Connection::open_with_flags(path, flags).with_context(|| path.display().to_string())?;
    let mut read = Read::of(&database, &scene).context("reading the flights")?;
    let frames = read.frames(&database, &scene).context("reading the truth")?;
    if frames.is_empty() {
        bail!("{}: no truth in it: nothing can be checked", path.display());
    }
    let given = read.given(&database).context("reading the clearances")?;
    let within_m = scene.run.dead_reckoning.position_m;
    if within_m > CHECKED_WITHIN_M {
        tracing::warn!(
            "{}: its positions are right within {within_m} m only (run.dead_reckoning.position_m), speeds and accelerations \
             less than the check wants: run the scene with {CHECKED_WITHIN_M}",
            path.display()
        );
    }
    let rules = Rules { serve_s: args.serve, ..Rules::default() };
    let mut checker = Checker::new(&scene.airport.layout, read.who, rules);
    for (time_s, seen) in &frames {
        checker.frame(*time_s, seen);
    }
    let mut rows = checker.finish(&given);
    if scene.traffic.behaving.is_none() {
        tracing::info!(
            "{}: nobody is cleared in it: {} are not judged",
            path.display(),
            ABOUT_CLEARANCES.join(", ")
        );
        rows.retain(|row| !ABOUT_CLEARANCES.contains(&row.name));
    }
    Ok(rows)
}

/// Rows that judge what follows clearances: recorded movements follow none.
const ABOUT_CLEARANCES: [&str; 3] = ["holds", "clearances", "served"];

/// The scene that the database names if it is here as it was, else as the database holds it.
fn scene_of(archive: &Archive) -> anyhow::Result<Scene> {
    let digest = archive.fact("scene_digest").unwrap_or_default();
    let named = archive.fact("scene").unwrap_or_default();
    if !named.is_empty()
        && let Ok(scene) = scenarios::load_without_truth(&scenarios::locate(&named))
        && format!("{:016x}", scene.hash) == digest
    {
        return Ok(scene);
    }
    let folder = std::env::temp_dir().join(format!("seeds-check-{}", std::process::id()));
    let read = kept_scene::write(archive, &folder).and_then(|(text, file)| {
        std::fs::write(&file, text)?;
        Ok(scenarios::load_without_truth(&file)?)
    });
    std::fs::remove_dir_all(&folder).ok();
    read.context("reading the scene out of the database; name it with --scene")
}

/// The movers of a database.
struct Read {
    who: Vec<Who>,
    /// Direction and due time by call sign.
    flights: BTreeMap<String, (Option<Direction>, f64)>,
    by_callsign: BTreeMap<String, usize>,
}

impl Read {
    fn of(database: &Connection, scene: &Scene) -> rusqlite::Result<Self> {
        let mut flights = BTreeMap::new();
        let mut query =
            database.prepare("SELECT callsign, movement, eta_ctd_s, off_block_s FROM flights")?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let movement: Option<String> = row.get(1)?;
            let direction = match movement.as_deref() {
                Some("arrival") => Some(Direction::Arrival),
                Some("departure") => Some(Direction::Departure),
                _ => None,
            };
            let due: Option<f64> = match direction {
                Some(Direction::Departure) => row.get(3)?,
                _ => row.get(2)?,
            };
            flights.insert(row.get(0)?, (direction, due.unwrap_or(f64::INFINITY)));
        }
        let days = scene.traffic.behaving.as_ref().map(|b| Arc::clone(&b.days)).unwrap_or_default();
        // The schedule knows what the list may have lost.
        for f in scene.traffic.behaving.iter().flat_map(|b| b.flights.iter()) {
            flights.insert(f.callsign.clone(), (Some(f.direction), f.time_s));
        }
        let mut read = Self { who: Vec::new(), flights, by_callsign: BTreeMap::new() };
        for f in scene.traffic.behaving.iter().flat_map(|b| b.flights.iter()) {
            // Also who was never seen.
            read.by_callsign.insert(f.callsign.clone(), read.who.len());
            read.who.push(Who {
                callsign: f.callsign.clone(),
                size: f.size,
                limits: TypeLimits::new(f.taxi_mps.0, f.taxi_acc_mps2, f.take_off, f.landing.0)
                    .in_weather(&days),
                wake: Some(f.wake),
                direction: Some(f.direction),
                due_s: f.time_s,
            });
        }
        Ok(read)
    }

    fn number(&mut self, scene: &Scene, callsign: &str, designator: &str, size: Size) -> usize {
        if let Some(at) = self.by_callsign.get(callsign) {
            return *at;
        }
        let row = scene.traffic.types.get(designator);
        let (direction, due_s) =
            self.flights.get(callsign).copied().unwrap_or((None, f64::INFINITY));
        let limits = row.map_or(TypeLimits::new(20.0, (1.5, 3.0), (90.0, 1500.0), 80.0), |r| {
            let k = &r.kinematics;
            let run = (k.liftoff_mps.unwrap_or(85.3), r.takeoff_dist_m.unwrap_or(1650.0));
            let taxi = (k.taxi_acc_ms2, k.taxi_dec_ms2);
            TypeLimits::new(k.taxi_straight_mps, taxi, run, k.touchdown_mps.unwrap_or(69.4))
        });
        let wake = row.and_then(|r| r.wake).map(Wake::from);
        let callsign = callsign.to_owned();
        self.by_callsign.insert(callsign.clone(), self.who.len());
        self.who.push(Who { callsign, size, limits, wake, direction, due_s });
        self.who.len() - 1
    }

    fn frames(
        &mut self,
        database: &Connection,
        scene: &Scene,
    ) -> rusqlite::Result<Vec<(f64, Vec<Seen>)>> {
        let mut query = database.prepare(
            "SELECT time_ns, callsign, type, x_m, y_m, altitude_m, vx_ms, vy_ms, heading_rad, length_m, span_m, aircraft, entity \
             FROM truth JOIN scans USING (scan) ORDER BY time_ns, entity",
        )?;
        let mut rows = query.query([])?;
        let mut frames: Vec<(f64, Vec<Seen>)> = Vec::new();
        while let Some(row) = rows.next()? {
            let time_s = SimTime(row.get(0)?).s();
            let callsign: Option<String> = row.get(1)?;
            let callsign = match callsign {
                Some(name) if !name.is_empty() => name,
                _ => format!("entity {}", row.get::<_, i64>(12)?),
            };
            let designator: Option<String> = row.get(2)?;
            let size = Size {
                length_m: row.get::<_, Option<f64>>(9)?.unwrap_or(5.0),
                span_m: row.get::<_, Option<f64>>(10)?.unwrap_or(2.0),
                aircraft: row.get::<_, Option<bool>>(11)?.unwrap_or(false),
            };
            let who = self.number(scene, &callsign, designator.as_deref().unwrap_or(""), size);
            let height_m = row.get::<_, Option<f64>>(5)?.unwrap_or(0.0);
            let seen = Seen {
                who,
                position_m: Point3::new(row.get(3)?, row.get(4)?, height_m),
                velocity_mps: Vector2::new(row.get(6)?, row.get(7)?),
                heading_rad: row.get::<_, Option<f64>>(8)?.unwrap_or(0.0),
            };
            match frames.last_mut() {
                Some((at, seen_then)) if *at == time_s => seen_then.push(seen),
                _ => frames.push((time_s, vec![seen])),
            }
        }
        Ok(frames)
    }

    fn given(&self, database: &Connection) -> rusqlite::Result<Vec<Given>> {
        let mut query =
            database.prepare("SELECT callsign, kind, runway, time_ns, until_ns FROM clearances")?;
        let mut rows = query.query([])?;
        let mut given = Vec::new();
        while let Some(row) = rows.next()? {
            let (callsign, kind): (String, String) = (row.get(0)?, row.get(1)?);
            let (Some(who), Some(kind)) =
                (self.by_callsign.get(&callsign), ClearanceKind::of(&kind))
            else {
                continue;
            };
            let until: Option<i64> = row.get(4)?;
            given.push(Given {
                who: *who,
                kind,
                runway: row.get::<_, Option<String>>(2)?.unwrap_or_default(),
                from_s: SimTime(row.get(3)?).s(),
                until_s: until.map_or(f64::INFINITY, |ns| SimTime(ns).s()),
            });
        }
        Ok(given)
    }
}
