//! `seeds export RUN --format geojson|kml|czml|csv -o FILE`: a finished run for maps and tables.
//!
//! Degrees with 7 decimals, metres with 3, times in ISO 8601 UTC with ms. Heights of GeoJSON are above the ellipsoid (RFC 7946), the
//! others above the airport. Each file but CSV says which run it is of: all facts of its
//! database, seed, digest and version among them.

mod alerts;
mod places;

use super::open::RUNS;
use super::sweep::cell;
use crate::gateway::public::iso8601;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::kept_scene;
use crate::viewer_logger::named::{database_of, first_of, is_recording, recording_of};
use crate::viewer_logger::opened;
use crate::viewer_logger::picture::AirportMap;
use alerts::Alert;
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use geodesy::{Enu, Geodetic, LocalFrame};
use rusqlite::{Connection, OpenFlags};
use scenarios::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write tracks, truth, plots, alerts and the airport of a finished run as GeoJSON, KML, CZML or CSV
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// The run: a folder of runs/ or its name there, its recording, the database beside it, or `last`
    #[arg(value_name = "RUN")]
    run: PathBuf,

    /// Form [default: by the file's name]
    #[arg(long, value_enum)]
    format: Option<Form>,

    /// What to write, with commas between [default: tracks,truth; in GeoJSON and KML the airport, too]
    #[arg(long, value_enum, value_delimiter = ',')]
    what: Vec<What>,

    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
}

/// The form of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    /// Lines with times, points for plots (RFC 7946)
    Geojson,
    /// Tracks over time for earth viewers (gx:Track)
    Kml,
    /// Moving points for Cesium
    Czml,
    /// One row a report
    Csv,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// System tracks
    Tracks,
    /// True positions
    Truth,
    /// Plots (not in KML, not in CZML)
    Plots,
    /// Alerts, one each, at the place where it was raised; in CSV a file of their own, as `seeds score` reads it
    Alerts,
    /// Runways, taxiways, pavement, stands, holding positions, buildings, sensors (GeoJSON, KML)
    Airport,
}

impl What {
    fn word(self) -> &'static str {
        match self {
            Self::Tracks => "track",
            Self::Truth => "truth",
            Self::Plots => "plot",
            Self::Alerts => "alert",
            Self::Airport => "airport",
        }
    }
}

/// Exports.
#[must_use]
pub fn run(args: &ExportArgs) -> ExitCode {
    let form = args.format.or_else(|| {
        let ending = args.out.extension()?.to_str()?.to_ascii_lowercase();
        Form::value_variants()
            .iter()
            .copied()
            .find(|f| f.to_possible_value().is_some_and(|v| v.get_name() == ending))
    });
    let Some(form) = form else {
        return fail(BAD_INPUT, "say the form: --format geojson, kml, czml or csv");
    };
    let what = match (args.what.is_empty(), form) {
        (false, _) => args.what.clone(),
        (true, Form::Geojson | Form::Kml) => vec![What::Tracks, What::Truth, What::Airport],
        (true, _) => vec![What::Tracks, What::Truth],
    };
    if let Some(why) = cannot(form, &what) {
        return fail(BAD_INPUT, why);
    }
    if let Err(e) = cli::writable(&args.out) {
        return fail(FAILED, format!("{e:#}"));
    }
    let exported = named(&args.run).and_then(|path| {
        not_of_the_run(&args.out, &path)?;
        Run::open(&path)
    });
    let exported = exported.and_then(|run| {
        let things = run.things(&what)?;
        let alerts = if what.contains(&What::Alerts) { alerts::of(&run)? } else { Vec::new() };
        Ok((run, things, alerts))
    });
    let (mut run, things, alerts) = match exported {
        Ok(read) => read,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    if !what.contains(&What::Airport) {
        run.map = AirportMap::default();
    }
    let text = match form {
        Form::Geojson => geojson(&run, &things, &alerts),
        Form::Kml => kml(&run, &things, &alerts),
        Form::Czml => czml(&run, &things, &alerts),
        Form::Csv if what == [What::Alerts] => alerts::csv(&run, &alerts),
        Form::Csv => csv(&run, &things),
    };
    match cli::save(&args.out, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Refuses to write over the files of the run itself, by whatever name.
fn not_of_the_run(out: &Path, run: &Path) -> anyhow::Result<()> {
    let database = if is_recording(run) { database_of(run) } else { run.to_path_buf() };
    let file = |path: &Path| std::fs::metadata(path).map(|m| (m.dev(), m.ino())).ok();
    // A later run of a process has the recording of its first.
    let first = first_of(&database).unwrap_or_else(|| database.clone());
    let recordings = [recording_of(&database), recording_of(&first)];
    let own = [run.to_path_buf(), database, first].into_iter().chain(recordings);
    for own in own {
        let same = file(out).is_some_and(|out| file(&own) == Some(out));
        anyhow::ensure!(!same, "-o {}: this is a file of the run itself", out.display());
    }
    Ok(())
}

/// The file that a word names: a recording or a database, or the database of a folder or of the last run.
fn named(word: &Path) -> anyhow::Result<PathBuf> {
    if word.is_file() {
        return Ok(word.to_path_buf());
    }
    let word = word.to_str().context("the name of the run is not text")?;
    let found = opened::databases(word, Path::new(RUNS))?;
    found.into_iter().next().context("no run was named")
}

/// Why a form cannot have that, if it cannot.
fn cannot(form: Form, what: &[What]) -> Option<&'static str> {
    let asked = |one: What| what.contains(&one);
    match form {
        Form::Kml | Form::Czml if asked(What::Plots) => Some(
            "--what plots: KML and CZML have things that move; plots are written as GeoJSON or CSV",
        ),
        Form::Csv | Form::Czml if asked(What::Airport) => Some(
            "--what airport: CSV and CZML have reports over time; the airport is written as GeoJSON or KML",
        ),
        Form::Csv if asked(What::Alerts) && what.len() > 1 => Some(
            "--what alerts: as CSV they have other columns than reports: ask for them in a file of their own",
        ),
        _ => None,
    }
}

/// A finished run.
struct Run {
    database: Connection,
    /// What it says of itself, its airport aside.
    facts: BTreeMap<String, String>,
    /// The airport; empty where it is not asked for.
    map: AirportMap,
    frame: LocalFrame,
    start_utc_ns: i64,
}

/// One report of a thing.
#[derive(Clone, Debug, PartialEq)]
struct Report {
    time_ns: i64,
    /// Longitude, latitude, degrees.
    place_deg: [f64; 2],
    /// Height above the reference, m.
    altitude_m: Option<f64>,
    /// Height above the ellipsoid, m.
    height_m: Option<f64>,
    position_m: [f64; 2],
    velocity_mps: Option<[f64; 2]>,
    status: String,
}

/// A track, an entity, or a sensor's plots.
#[derive(Clone, Debug, PartialEq)]
struct Thing {
    what: What,
    /// Number of the track, identifier of the entity, number of the sensor.
    id: String,
    name: String,
    kind: String,
    movement: String,
    reports: Vec<Report>,
}

impl Run {
    fn open(path: &Path) -> anyhow::Result<Self> {
        let beside = database_of(path);
        let path = if is_recording(path) { &beside } else { path };
        let doing = || format!("{}: not the database of a run", path.display());
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let database = Connection::open_with_flags(path, flags).with_context(doing)?;
        let mut facts = BTreeMap::new();
        {
            let mut query = database.prepare("SELECT name, value FROM run").with_context(doing)?;
            let rows = query.query_map([], |r| Ok((r.get(0)?, r.get::<_, Option<String>>(1)?)))?;
            for row in rows {
                let (name, value): (String, Option<String>) = row?;
                facts.insert(name, value.unwrap_or_default());
            }
        }
        facts.insert("run".to_owned(), opened::id_of(path));
        // A log of the first version has none.
        let map = facts.remove("map_json").and_then(|text| serde_json::from_str(&text).ok());
        let number = |name: &str| facts.get(name).and_then(|v| v.parse::<f64>().ok());
        let (Some(lat), Some(lon)) =
            (number("reference_latitude_deg"), number("reference_longitude_deg"))
        else {
            bail!("{}: says no reference point", path.display());
        };
        let height_m = scene_of(path, &facts).map_or(0.0, |s| s.airport.reference.height_m);
        let frame = LocalFrame::at(Geodetic::from_degrees(lat, lon, height_m));
        let start_utc_ns = facts.get("start_utc_ns").and_then(|v| v.parse().ok()).unwrap_or(0);
        Ok(Self { database, facts, map: map.unwrap_or_default(), frame, start_utc_ns })
    }

    fn place(&self, position_m: [f64; 2]) -> [f64; 2] {
        self.place_above(position_m, 0.0).0
    }

    /// Longitude and latitude in degrees of a place so high above the reference, and its height above the ellipsoid, m.
    fn place_above(&self, [east_m, north_m]: [f64; 2], up_m: f64) -> ([f64; 2], f64) {
        let place = self.frame.to_ecef(Enu { east_m, north_m, up_m }).to_geodetic();
        ([place.lon_deg(), place.lat_deg()], place.height_m)
    }

    fn time(&self, time_ns: i64) -> String {
        iso8601(self.start_utc_ns + time_ns)
    }

    fn things(&self, whats: &[What]) -> anyhow::Result<Vec<Thing>> {
        let mut all = Vec::new();
        for what in whats {
            // Same columns of all: id, name, kind, movement, time, x, y, altitude, vx, vy, status.
            let query = match what {
                What::Tracks => {
                    "SELECT track, t.callsign, t.type, coalesce(f.movement, ''), time_ns, x_m, y_m, altitude_m, vx_ms, vy_ms, status \
                     FROM tracks t JOIN scans USING (scan) LEFT JOIN flights f ON f.callsign = t.callsign AND f.callsign <> '' \
                     ORDER BY track, time_ns"
                }
                What::Truth => {
                    "SELECT dis_id, t.callsign, t.type, coalesce(f.movement, ''), time_ns, x_m, y_m, altitude_m, vx_ms, vy_ms, '' \
                     FROM truth t JOIN scans USING (scan) LEFT JOIN flights f ON f.callsign = t.callsign AND f.callsign <> '' \
                     ORDER BY entity, time_ns"
                }
                What::Plots => {
                    "SELECT p.sensor, s.name, p.kind, '', time_ns, p.x_m, p.y_m, NULL, NULL, NULL, coalesce(identity, '') \
                     FROM plots p LEFT JOIN sensors s USING (sensor) ORDER BY p.sensor, time_ns, sequence"
                }
                What::Alerts | What::Airport => continue, // no reports
            };
            let mut query =
                self.database.prepare(query).context("the database of another version")?;
            let mut rows = query.query([])?;
            while let Some(row) = rows.next()? {
                let id = match row.get_ref(0)? {
                    rusqlite::types::ValueRef::Integer(n) => n.to_string(),
                    other => other.as_str().unwrap_or("").to_owned(),
                };
                let text = |i| row.get::<_, Option<String>>(i).map(Option::unwrap_or_default);
                let position_m = [row.get(5)?, row.get(6)?];
                let velocity = row.get::<_, Option<f64>>(8)?.zip(row.get::<_, Option<f64>>(9)?);
                let altitude_m: Option<f64> = row.get(7)?;
                // Who flies is not over the place where the plane below is met; what a track says of it is barometric.
                let up_m = altitude_m.filter(|_| *what == What::Truth).unwrap_or(0.0);
                let (place_deg, _) = self.place_above(position_m, up_m);
                let height_m = altitude_m.map(|up_m| self.place_above(position_m, up_m).1);
                let report = Report {
                    time_ns: row.get(4)?,
                    place_deg,
                    altitude_m,
                    height_m,
                    position_m,
                    velocity_mps: velocity.map(|(x, y)| [x, y]),
                    status: text(10)?,
                };
                let (name, kind, movement) = (text(1)?, text(2)?, text(3)?);
                let same = |t: &&mut Thing| t.what == *what && t.id == id && !ended(t, &report);
                match all.last_mut().filter(same) {
                    Some(thing) => {
                        // A label may come late.
                        if !name.is_empty() && thing.name.is_empty() {
                            (thing.name, thing.kind, thing.movement) = (name, kind, movement);
                        }
                        thing.reports.push(report);
                    }
                    None => {
                        let reports = vec![report];
                        all.push(Thing { what: *what, id, name, kind, movement, reports });
                    }
                }
            }
        }
        Ok(all)
    }
}

/// The scene of a run: the one that its log holds, else that of its name, where it is still the same. The height of the
/// airport changes degrees by parts in ten thousand of the distance.
fn scene_of(path: &Path, facts: &BTreeMap<String, String>) -> Option<Scene> {
    let kept = Archive::open(path).ok().and_then(|archive| kept_scene::load(&archive).ok());
    kept.or_else(|| {
        let scene = scenarios::load_without_truth(&scenarios::locate(facts.get("scene")?)).ok()?;
        let digest = facts.get("scene_digest").filter(|digest| !digest.is_empty());
        digest.is_none_or(|digest| *digest == format!("{:016x}", scene.hash)).then_some(scene)
    })
}

/// A number that had its last message is another track when it comes again.
fn ended(thing: &Thing, next: &Report) -> bool {
    let last = thing.reports.last();
    thing.what == What::Tracks
        && last.is_some_and(|r| r.status == "last" || next.time_ns - r.time_ns > 30_000_000_000)
}

fn digits(x: f64, count: i32) -> f64 {
    let scale = libm::pow(10.0, f64::from(count));
    libm::round(x * scale) / scale
}

fn coordinates(report: &Report) -> Value {
    let [lon, lat] = report.place_deg.map(|d| digits(d, 7));
    match report.height_m {
        Some(height_m) => json!([lon, lat, digits(height_m, 3)]),
        None => json!([lon, lat]),
    }
}

/// Reports cut where they cross 180 degrees, each part with the point of the crossing (RFC 7946, 3.1.9).
fn at_180(reports: &[Report]) -> Vec<Vec<Report>> {
    let mut parts: Vec<Vec<Report>> = vec![Vec::new()];
    for report in reports {
        let before = parts.last().and_then(|part| part.last()).cloned();
        let apart = before.as_ref().map_or(0.0, |b| report.place_deg[0] - b.place_deg[0]);
        if let Some(before) = before.filter(|_| apart.abs() > 180.0) {
            let side = 180f64.copysign(before.place_deg[0]);
            let whole = 360.0 - apart.abs();
            let share = if whole > 0.0 { (side - before.place_deg[0]).abs() / whole } else { 0.0 };
            let between = |a: f64, b: f64| a + share * (b - a);
            let crossing = |side: f64| Report {
                time_ns: before.time_ns + (share * (report.time_ns - before.time_ns) as f64) as i64,
                place_deg: [side, between(before.place_deg[1], report.place_deg[1])],
                height_m: before.height_m.zip(report.height_m).map(|(a, b)| between(a, b)),
                ..before.clone()
            };
            parts.last_mut().into_iter().for_each(|part| part.push(crossing(side)));
            parts.push(vec![crossing(-side)]);
        }
        parts.last_mut().into_iter().for_each(|part| part.push(report.clone()));
    }
    parts
}

fn geojson(run: &Run, things: &[Thing], alerts: &[Alert]) -> String {
    let mut features = places::features(run);
    features.extend(alerts.iter().map(|alert| alert.feature(run)));
    for thing in things {
        let properties = |times: Value| {
            json!({
                "kind": thing.what.word(), "id": thing.id, "name": thing.name, "type": thing.kind,
                "movement": thing.movement, "times": times,
            })
        };
        if thing.what == What::Plots {
            features.extend(thing.reports.iter().map(|report| {
                let mut properties = properties(json!([run.time(report.time_ns)]));
                properties["identity"] = json!(report.status);
                let geometry = json!({"type": "Point", "coordinates": coordinates(report)});
                json!({"type": "Feature", "properties": properties, "geometry": geometry})
            }));
            continue;
        }
        // A line has two points at least, and all with a height or none.
        let flat = thing.reports.iter().any(|r| r.height_m.is_none());
        let point = |r: &Report| {
            coordinates(&Report { height_m: r.height_m.filter(|_| !flat), ..r.clone() })
        };
        let parts = at_180(&thing.reports);
        let of = |part: &Vec<Report>| part.iter().map(point).collect::<Vec<Value>>();
        let mut lines: Vec<Vec<Value>> = parts.iter().map(of).collect();
        let mut times: Vec<Vec<String>> =
            parts.iter().map(|part| part.iter().map(|r| run.time(r.time_ns)).collect()).collect();
        let (geometry, times) = match (lines.len(), lines.pop(), times.pop()) {
            (1, Some(mut line), Some(times)) if line.len() == 1 => {
                (json!({"type": "Point", "coordinates": line.pop()}), json!(times))
            }
            (1, Some(line), Some(times)) => {
                (json!({"type": "LineString", "coordinates": line}), json!(times))
            }
            (_, line, last) => {
                lines.extend(line);
                times.extend(last);
                (json!({"type": "MultiLineString", "coordinates": lines}), json!(times))
            }
        };
        let properties = properties(times);
        features.push(json!({"type": "Feature", "properties": properties, "geometry": geometry}));
    }
    format!("{}\n", json!({"type": "FeatureCollection", "run": run.facts, "features": features}))
}

/// Text between tags.
fn escaped(text: &str) -> String {
    let clean = text.chars().filter(|c| !c.is_control());
    let pieces = clean.map(|c| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        other => other.to_string(),
    });
    pieces.collect()
}

fn title(thing: &Thing) -> String {
    match (thing.name.is_empty(), thing.what) {
        (true, _) => format!("{} {}", thing.what.word(), thing.id),
        (false, What::Tracks) => format!("{} (track {})", thing.name, thing.id),
        (false, _) => thing.name.clone(),
    }
}

fn kml(run: &Run, things: &[Thing], alerts: &[Alert]) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n",
    );
    let name = run.facts.get("title").or(run.facts.get("scene")).map_or("", String::as_str);
    let facts: Vec<String> = run.facts.iter().map(|(k, v)| format!("{k}: {v}")).collect();
    write!(
        out,
        "<name>{}</name>\n<description>{}</description>\n",
        escaped(name),
        escaped(&facts.join("; "))
    )
    .ok();
    places::kml(run, &mut out);
    alerts.iter().for_each(|alert| alert.kml(run, &mut out));
    for thing in things {
        let flat = thing.reports.iter().any(|r| r.altitude_m.is_none());
        let mode = if flat { "clampToGround" } else { "relativeToGround" };
        write!(
            out,
            "<Placemark><name>{}</name><gx:Track><altitudeMode>{mode}</altitudeMode>",
            escaped(&title(thing))
        )
        .ok();
        for report in &thing.reports {
            write!(out, "<when>{}</when>", run.time(report.time_ns)).ok();
        }
        for report in &thing.reports {
            let [lon, lat] = report.place_deg;
            let height_m = report.altitude_m.unwrap_or(0.0);
            write!(out, "<gx:coord>{lon:.7} {lat:.7} {height_m:.3}</gx:coord>").ok();
        }
        out.push_str("</gx:Track></Placemark>\n");
    }
    out.push_str("</Document>\n</kml>\n");
    out
}

/// Colour of a movement, red green blue alpha.
fn colour(thing: &Thing) -> [u8; 4] {
    let alpha = if thing.what == What::Truth { 120 } else { 255 };
    match thing.movement.as_str() {
        "arrival" => [230, 159, 0, alpha],
        "departure" => [86, 180, 233, alpha],
        "vehicle" => [0, 158, 115, alpha],
        _ => [200, 200, 200, alpha],
    }
}

fn czml(run: &Run, things: &[Thing], alerts: &[Alert]) -> String {
    let span = |reports: &[Report]| {
        let first = reports.first().map_or(0, |r| r.time_ns);
        let last = reports.last().map_or(0, |r| r.time_ns);
        (first, last)
    };
    let spans: Vec<(i64, i64)> = things.iter().map(|t| span(&t.reports)).collect();
    let begin = spans.iter().map(|s| s.0).min().unwrap_or(0);
    let end = spans.iter().map(|s| s.1).max().unwrap_or(0);
    let interval = |a, b| format!("{}/{}", run.time(a), run.time(b));
    let mut packets = vec![json!({
        "id": "document", "version": "1.0",
        "name": run.facts.get("title").or(run.facts.get("scene")),
        "clock": {"interval": interval(begin, end), "currentTime": run.time(begin), "multiplier": 1},
        "properties": {"run": run.facts},
    })];
    for (index, (thing, (first, last))) in things.iter().zip(spans).enumerate() {
        let mut positions = Vec::new();
        for report in &thing.reports {
            let [lon, lat] = report.place_deg.map(|d| digits(d, 7));
            positions.push(json!(digits((report.time_ns - begin) as f64 * 1e-9, 3)));
            positions.extend([
                json!(lon),
                json!(lat),
                json!(digits(report.altitude_m.unwrap_or(0.0), 3)),
            ]);
        }
        let size = if thing.what == What::Truth { 6 } else { 9 };
        packets.push(json!({
            "id": format!("{}-{}-{index}", thing.what.word(), thing.id),
            "name": title(thing),
            "availability": interval(first, last),
            "position": {
                "epoch": run.time(begin), "cartographicDegrees": positions,
                "interpolationAlgorithm": "LINEAR", "interpolationDegree": 1,
            },
            "point": {"pixelSize": size, "color": {"rgba": colour(thing)}, "heightReference": "RELATIVE_TO_GROUND"},
            "label": {
                "text": title(thing), "font": "11px sans-serif", "pixelOffset": {"cartesian2": [8, -8]},
                "horizontalOrigin": "LEFT", "show": thing.what == What::Tracks,
                "heightReference": "RELATIVE_TO_GROUND",
            },
        }));
    }
    packets.extend(alerts.iter().map(|alert| alert.packet(run, end)));
    format!("{}\n", Value::Array(packets))
}

fn csv(run: &Run, things: &[Thing]) -> String {
    let mut out = String::from(
        "kind,id,name,type,movement,utc,time_s,lat_deg,lon_deg,x_m,y_m,altitude_m,vx_ms,vy_ms,status\n",
    );
    for thing in things {
        let head: Vec<String> =
            [thing.what.word(), &thing.id, &thing.name, &thing.kind, &thing.movement]
                .iter()
                .map(|text| cell(text))
                .collect();
        for report in &thing.reports {
            let [lon, lat] = report.place_deg;
            let [x_m, y_m] = report.position_m;
            let optional = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.3}"));
            let (vx, vy) = (report.velocity_mps.map(|v| v[0]), report.velocity_mps.map(|v| v[1]));
            writeln!(
                out,
                "{},{},{:.3},{lat:.7},{lon:.7},{x_m:.3},{y_m:.3},{},{},{},{}",
                head.join(","),
                run.time(report.time_ns),
                report.time_ns as f64 * 1e-9,
                optional(report.altitude_m),
                optional(vx),
                optional(vy),
                cell(&report.status)
            )
            .ok();
        }
    }
    out
}

#[cfg(test)]
mod tests;
