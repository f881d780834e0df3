//! `seeds export RUN --format geojson|kml|czml|csv -o FILE`: a finished run for maps and tables.
//!
//! Degrees with 7 decimals, metres with 3, times in ISO 8601 UTC with ms. Each file but CSV says which run it is of: all facts of its
//! database, seed, digest and version among them.

mod alerts;
mod places;

use super::open::RUNS;
use super::sweep::cell;
use crate::gateway::public::iso8601;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::viewer_logger::named::{database_of, first_of, is_recording, recording_of};
use crate::viewer_logger::opened;
use crate::viewer_logger::picture::AirportMap;
use alerts::Alert;
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use geodesy::{Enu, Geodetic, LocalFrame};
use rusqlite::{Connection, OpenFlags};
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
        // The height of the airport changes degrees by parts in ten thousand of the distance; the scene knows it.
        let scene = facts.get("scene").map(|name| scenarios::locate(name));
        let scene = scene.and_then(|path| scenarios::load_without_truth(&path).ok());
        let height_m = scene.map_or(0.0, |s| s.airport.reference.height_m);
        let frame = LocalFrame::at(Geodetic::from_degrees(lat, lon, height_m));
        let start_utc_ns = facts.get("start_utc_ns").and_then(|v| v.parse().ok()).unwrap_or(0);
        Ok(Self { database, facts, map: map.unwrap_or_default(), frame, start_utc_ns })
    }

    fn place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let place = self.frame.to_ecef(Enu { east_m, north_m, up_m: 0.0 }).to_geodetic();
        [place.lon_deg(), place.lat_deg()]
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
                let report = Report {
                    time_ns: row.get(4)?,
                    place_deg: self.place(position_m),
                    altitude_m: row.get(7)?,
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
    match report.altitude_m {
        Some(height_m) => json!([lon, lat, digits(height_m, 3)]),
        None => json!([lon, lat]),
    }
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
        let times: Vec<String> = thing.reports.iter().map(|r| run.time(r.time_ns)).collect();
        // A line has two points at least, and all with a height or none.
        let flat = thing.reports.iter().any(|r| r.altitude_m.is_none());
        let mut line: Vec<Value> = thing
            .reports
            .iter()
            .map(|r| {
                coordinates(&Report { altitude_m: r.altitude_m.filter(|_| !flat), ..r.clone() })
            })
            .collect();
        let geometry = match (line.len(), line.pop()) {
            (1, Some(point)) => json!({"type": "Point", "coordinates": point}),
            (_, last) => {
                line.extend(last);
                json!({"type": "LineString", "coordinates": line})
            }
        };
        let properties = properties(json!(times));
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
mod tests {
    use super::*;

    /// The database, its recording, and a link to one of them were written over.
    #[test]
    fn nothing_is_exported_over_the_run_itself() {
        let folder = std::env::temp_dir().join(format!("seeds-export-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("made");
        let at = |name: &str| folder.join(name);
        for name in ["x.sqlite", "x.pcapng", "other.csv"] {
            std::fs::write(at(name), name).expect("written");
        }
        std::os::unix::fs::symlink(at("x.sqlite"), at("link.csv")).expect("linked");
        for run in ["x.sqlite", "x.pcapng"] {
            for out in ["x.sqlite", "x.pcapng", "link.csv"] {
                assert!(not_of_the_run(&at(out), &at(run)).is_err(), "{run} to {out}");
            }
            for out in ["other.csv", "new.csv"] {
                assert!(not_of_the_run(&at(out), &at(run)).is_ok(), "{run} to {out}");
            }
        }
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    /// The run of a few tables, at a place on earth.
    fn empty_run() -> Run {
        Run {
            database: Connection::open_in_memory().expect("opened"),
            facts: BTreeMap::new(),
            map: AirportMap::default(),
            frame: LocalFrame::at(Geodetic::from_degrees(47.0, 8.0, 400.0)),
            start_utc_ns: 0,
        }
    }

    #[test]
    fn an_exported_table_is_scored_as_it_is() {
        use studies::score_files;
        let run = empty_run();
        let report = |s: i64, status: &str| Report {
            time_ns: s * 1_000_000_000,
            place_deg: run.place([10.0 * s as f64, 3.0]),
            altitude_m: None,
            position_m: [10.0 * s as f64, 3.0],
            velocity_mps: Some([10.0, 0.0]),
            status: status.to_owned(),
        };
        let thing = |what, id: &str, name: &str, status| Thing {
            what,
            id: id.to_owned(),
            name: name.to_owned(),
            kind: "A320".to_owned(),
            movement: "arrival".to_owned(),
            reports: (0..20).map(|s| report(s, status)).collect(),
        };
        let things = [
            thing(What::Tracks, "7", "SWR1, \"A\"", "confirmed"),
            thing(What::Tracks, "8", "", "tentative"),
            thing(What::Truth, "1:1:1", "SWR1, \"A\"", ""),
            thing(What::Truth, "1:1:2", "", ""),
            thing(What::Truth, "1:1:3", "", ""),
        ];
        let text = csv(&run, &things);
        let tracks = score_files::tracks(&text, None).expect("tracks");
        assert_eq!(tracks.len(), 20);
        assert!(tracks.iter().all(|r| (r.track, r.label.as_str()) == (7, "SWR1, \"A\"")));
        assert_eq!(score_files::truth(&text, None).expect("truth").len(), 3);
        // By its degrees it is the same to a centimetre.
        let place = |lat: f64, lon: f64| {
            let at = run.frame.to_enu(Geodetic::from_degrees(lat, lon, 400.0).to_ecef());
            models::frames::Point2::new(at.east_m, at.north_m)
        };
        let placed = score_files::tracks(&text, Some(&place)).expect("tracks");
        let off = tracks.iter().zip(&placed).map(|(a, b)| (a.position_m - b.position_m).norm());
        assert!(off.fold(0.0, f64::max) < 0.011);
    }
}
