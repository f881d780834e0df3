//! The report of a run, made from its database: a page to look at, every table as CSV and JSON.

use super::report_areas::{self, escaped};
use crate::runtime::cli;
use crate::runtime::process::machine;
use crate::viewer_logger::picture::AirportMap;
use anyhow::Context;
use rusqlite::{Connection, OpenFlags, types::ValueRef};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// Result of a query, columns in the order of the query.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    fn of(database: &Connection, query: &str) -> anyhow::Result<Self> {
        let mut statement = database.prepare(query)?;
        let names: Vec<String> = statement.column_names().map(str::to_owned).collect();
        let mut found = statement.query([])?;
        let mut rows = Vec::new();
        while let Some(row) = found.next()? {
            let value = |i: usize| {
                Ok(match row.get_ref(i)? {
                    ValueRef::Null | ValueRef::Blob(_) => Value::Null,
                    ValueRef::Integer(n) => json!(n),
                    ValueRef::Real(x) => json!(x),
                    ValueRef::Text(text) => json!(String::from_utf8_lossy(text)),
                })
            };
            rows.push((0..names.len()).map(value).collect::<rusqlite::Result<_>>()?);
        }
        Ok(Self { names, rows })
    }

    fn json(&self) -> Value {
        let object = |row: &Vec<Value>| -> Map<String, Value> {
            self.names.iter().cloned().zip(row.iter().cloned()).collect()
        };
        self.rows.iter().map(object).map(Value::Object).collect()
    }

    fn csv(&self) -> String {
        let quoted = |text: &str| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text.to_owned()
            }
        };
        let cell = |value: &Value| match value {
            Value::Null => String::new(),
            Value::String(text) => quoted(text),
            other => other.to_string(),
        };
        let mut out = self.names.iter().map(|n| quoted(n)).collect::<Vec<_>>().join(",") + "\n";
        for row in &self.rows {
            out += &(row.iter().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        out
    }

    fn html(&self) -> String {
        if self.rows.is_empty() {
            return "<p>none</p>".to_owned();
        }
        let mut out = "<table><thead><tr>".to_owned();
        for name in &self.names {
            let _ = write!(out, "<th>{}</th>", escaped(&heading(name)));
        }
        out += "</tr></thead><tbody>";
        for row in &self.rows {
            out += "<tr>";
            for value in row {
                let _ = write!(out, "<td>{}</td>", escaped(&shown(value)));
            }
            out += "</tr>";
        }
        out + "</tbody></table>"
    }

    /// The figures of a column; NaN where there is none.
    fn column(&self, name: &str) -> Vec<f64> {
        let Some(at) = self.names.iter().position(|n| n == name) else { return Vec::new() };
        self.rows.iter().map(|row| row[at].as_f64().unwrap_or(f64::NAN)).collect()
    }
}

/// The name of a column as people read it, with its unit.
fn heading(name: &str) -> String {
    let units = [
        ("_percent", ", %"),
        ("_m", ", m"),
        ("_s", ", s"),
        ("_us", ", µs"),
        ("_db", ", dB"),
        ("_ns", ", ns"),
        ("_bytes", ", bytes"),
    ];
    let unit = units.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
    let (words, unit) = unit.unwrap_or((name, ""));
    let words = match words.strip_prefix("pd_") {
        Some(sensor) => format!("share of looks detected by {sensor}"),
        None => words.replace('_', " "),
    };
    words.replace("rmse", "error (rms)").replace("scnr", "signal to clutter and noise") + unit
}

/// A figure as people read it.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_i64() => n.to_string(),
        // Counts that stand in a column of figures.
        Value::Number(n) if n.as_f64().is_some_and(|x| x.fract() == 0.0 && x.abs() < 1e15) => {
            format!("{:.0}", n.as_f64().unwrap_or(f64::NAN))
        }
        Value::Number(n) => format!("{:.2}", n.as_f64().unwrap_or(f64::NAN)),
        other => other.to_string(),
    }
}

/// Straight axes of a picture: figures to pixels.
struct Axes {
    from: [f64; 2],
    to: [f64; 2],
    size: [f64; 2],
}

const MARGIN: f64 = 46.0;

impl Axes {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let part = |k: usize, v: f64| (v - self.from[k]) / (self.to[k] - self.from[k]);
        (
            MARGIN + part(0, x) * (self.size[0] - 2.0 * MARGIN),
            self.size[1] - MARGIN - part(1, y) * (self.size[1] - 2.0 * MARGIN),
        )
    }

    /// A line through the points; a gap where a figure is missing.
    fn line(&self, class: &str, points: impl Iterator<Item = (f64, f64)>) -> String {
        let mut path = String::new();
        let mut down = false;
        for (x, y) in points {
            if !(x.is_finite() && y.is_finite()) {
                down = false;
                continue;
            }
            let (px, py) = self.at(x, y);
            let _ = write!(path, "{}{px:.1} {py:.1}", if down { "L" } else { "M" });
            down = true;
        }
        format!("<path class=\"{class}\" d=\"{path}\"/>")
    }

    fn frame(&self, x_title: &str, y_title: &str) -> String {
        let mut out = String::new();
        for k in 0..2 {
            for value in ticks(self.from[k], self.to[k]) {
                let (a, b) = if k == 0 {
                    (self.at(value, self.from[1]), self.at(value, self.to[1]))
                } else {
                    (self.at(self.from[0], value), self.at(self.to[0], value))
                };
                let (x, y, anchor) = if k == 0 {
                    (a.0, a.1 + 15.0, "middle")
                } else {
                    (a.0 - 6.0, a.1 + 4.0, "end")
                };
                let _ = write!(
                    out,
                    "<path class=\"grid\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/><text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{value}</text>",
                    a.0, a.1, b.0, b.1
                );
            }
        }
        let (middle, bottom) = (self.size[0] / 2.0, self.size[1] - 10.0);
        let _ = write!(
            out,
            "<text x=\"{middle}\" y=\"{bottom}\" text-anchor=\"middle\">{x_title}</text><text x=\"10\" y=\"22\">{y_title}</text>"
        );
        out
    }

    fn svg(&self, inside: &str) -> String {
        format!(
            "<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\">{inside}</svg>",
            self.size[0], self.size[1]
        )
    }
}

/// Round figures between two bounds, about six.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let rough = (to - from) / 6.0;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    let first = (from / step).ceil() as i64;
    let last = (to / step).floor() as i64;
    (first..=last).map(|n| n as f64 * step).map(|x| (x * 1e6).round() / 1e6).collect()
}

/// Errors of tracks and plots over time, with the changes of the weather.
fn error_picture(database: &Connection) -> anyhow::Result<String> {
    let errors = Table::of(database, "SELECT * FROM error_over_time ORDER BY scan")?;
    let time = errors.column("time_s");
    let (tracks, plots) = (errors.column("track_rmse_m"), errors.column("plot_rmse_m"));
    let top = tracks.iter().chain(&plots).copied().filter(|e| e.is_finite()).fold(1.0, f64::max);
    let end = time.last().copied().unwrap_or(1.0).max(1.0);
    let axes = Axes { from: [0.0, 0.0], to: [end, 1.05 * top], size: [1160.0, 300.0] };
    let mut inside = axes.frame("time, s", "root mean square error over all targets, m");
    let weather = Table::of(
        database,
        "SELECT time_ns / 1e9 AS s, rain_mm_per_h AS rain, visibility_m AS seen FROM weather ORDER BY time_ns",
    )?;
    let mut before: &[Value] = &[];
    for row in &weather.rows {
        if row[1..] == *before {
            continue;
        }
        before = &row[1..];
        let at = row[0].as_f64().unwrap_or(0.0).max(0.0);
        let rain = row[1].as_f64().unwrap_or(0.0);
        let seen = row[2].as_f64().map_or_else(String::new, |m| format!(", visibility {m:.0} m"));
        let says = if rain > 0.0 { format!("rain {rain} mm/h") } else { "dry".to_owned() };
        let ((x, y), (_, up)) = (axes.at(at, 0.0), axes.at(at, 1.05 * top));
        let _ = write!(
            inside,
            "<path class=\"weather\" d=\"M{x:.1} {y:.1}V{up:.1}\"/><text class=\"weather\" x=\"{:.1}\" y=\"{:.1}\">{says}{seen}</text>",
            x + 4.0,
            up + 10.0
        );
    }
    inside += &axes.line("plots", time.iter().copied().zip(plots));
    inside += &axes.line("tracks", time.iter().copied().zip(tracks));
    Ok(axes.svg(&inside)
        + "<p class=\"key\"><i class=\"tracks\"></i> system tracks, at publication <i class=\"plots\"></i> plots, at their own time</p>")
}

/// The text of the scene as it was run, where the log holds it.
fn scene_text(database: &Connection) -> String {
    let read = || -> rusqlite::Result<(String, Vec<u8>)> {
        let question = "SELECT name, octets FROM files WHERE name LIKE '%.toml' ORDER BY name = \
             (SELECT value FROM run WHERE name = 'scene_file') DESC LIMIT 1";
        database.query_row(question, [], |row| Ok((row.get(0)?, row.get(1)?)))
    };
    match read() {
        Ok((name, octets)) => format!(
            "<details><summary>{}</summary><pre>{}</pre></details>",
            escaped(&name),
            escaped(&String::from_utf8_lossy(&octets))
        ),
        Err(_) => "<p>not in the log</p>".to_owned(),
    }
}

/// Writes `report.html` (what happened, with pictures), `report.json` and one CSV for each table and view.
///
/// # Errors
/// If the database cannot be read or a file not written.
pub fn write(folder: &Path, database: &Path) -> anyhow::Result<()> {
    let doing = || format!("writing the report into {}", folder.display());
    std::fs::create_dir_all(folder).with_context(doing)?;
    let connection = Connection::open_with_flags(database, OpenFlags::SQLITE_OPEN_READ_ONLY)
        .with_context(|| format!("reading {}", database.display()))?;
    let names = Table::of(
        &connection,
        "SELECT name FROM sqlite_master WHERE type IN ('table', 'view') AND name NOT LIKE 'sqlite_%' ORDER BY type DESC, name",
    )?;
    let mut everything = Map::new();
    let mut files = String::new();
    for row in names.rows {
        let name = shown(&row[0]);
        let found = Table::of(&connection, &format!("SELECT * FROM \"{name}\""))?;
        cli::save(&folder.join(format!("{name}.csv")), found.csv())?;
        let _ = write!(
            files,
            "<li><a href=\"{name}.csv\">{name}.csv</a> {} rows</li>",
            found.rows.len()
        );
        if found.rows.len() <= IN_JSON {
            everything.insert(name, found.json());
        }
    }
    let text = serde_json::to_string_pretty(&everything)?;
    cli::save(&folder.join("report.json"), text)?;
    cli::save(&folder.join("report.html"), page(&connection, &files)?)
}

/// Larger tables are in their CSV files only.
const IN_JSON: usize = 5000;

fn page(database: &Connection, files: &str) -> anyhow::Result<String> {
    let facts = Table::of(database, "SELECT name, value FROM run ORDER BY name")?;
    let fact = |wanted: &str| {
        facts.rows.iter().find(|r| r[0] == wanted).map_or_else(String::new, |r| shown(&r[1]))
    };
    let title = Some(fact("title")).filter(|t| !t.is_empty()).unwrap_or_else(|| fact("scene"));
    let mut measures = Table::of(
        database,
        "SELECT name AS measure, value FROM statistics WHERE scan = (SELECT max(scan) FROM statistics) ORDER BY name",
    )?;
    for row in &mut measures.rows {
        row[0] = json!(heading(&shown(&row[0])));
    }
    let map: AirportMap = serde_json::from_str(&fact("map_json")).unwrap_or_default();
    let mut areas = report_areas::seen(database, &map)?;
    let names = Table::of(database, "SELECT sensor, name FROM sensors")?;
    let names = names.rows.iter().filter_map(|r| Some((r[0].as_u64()? as u16, shown(&r[1]))));
    let names = names.collect();
    let mut about = Table::of(
        database,
        "SELECT name, value FROM run WHERE name <> 'map_json' AND value <> '' ORDER BY name",
    )?;
    about.rows.push(vec![json!("report made on"), json!(machine())]);
    let mut body = format!("<h1>{}</h1>", escaped(&title));
    for (heading, inside) in [
        ("Verdict", report_areas::verdict(&mut areas)),
        ("Faults", table_or_nothing(database, FAULTS)?),
        ("Where everybody went", report_areas::map(database, &map)?),
        ("Errors over time", error_picture(database)?),
        ("Detection by area", report_areas::detection(&areas, &names)),
        ("Targets", Table::of(database, "SELECT * FROM target_accuracy")?.html()),
        ("Sensors", Table::of(database, "SELECT * FROM sensor_accuracy")?.html()),
        ("Measures of the run", measures.html()),
        ("Measures of the traffic", table_or_nothing(database, TRAFFIC)?),
        ("Effects, largest first", {
            Table::of(database, "SELECT * FROM effect_sizes ORDER BY abs(mean) DESC")?.html()
        }),
        ("Tracks that followed nothing", Table::of(database, "SELECT * FROM false_tracks")?.html()),
        ("Network and load", Table::of(database, "SELECT * FROM network_losses")?.html()),
        ("People at seats", people(database)?),
        ("Operator actions", {
            Table::of(
                database,
                "SELECT time_ns / 1e9 AS time_s, source, command, answer FROM operations ORDER BY wall_utc_ns",
            )?
            .html()
        }),
        ("Wrong labels", {
            Table::of(
                database,
                "SELECT label, entity, count(*) AS scans, min(scan) AS first_scan, max(scan) AS last_scan FROM wrong_labels GROUP BY label, entity ORDER BY scans DESC",
            )?
            .html()
        }),
        ("About the run", about.html()),
        ("The scene", scene_text(database)),
        ("All tables", format!("<ul>{files}</ul>")),
    ]
    .into_iter()
    .filter(|(_, inside)| !inside.is_empty())
    {
        let _ = write!(body, "<section><h2>{heading}</h2>{inside}</section>");
    }
    Ok(format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>{} – SEEDS</title><style>{STYLE}</style><main>{body}</main></html>",
        escaped(&title)
    ))
}

/// What went wrong: in the federation, of movers, and rings of those that wait for each other.
const FAULTS: &str = "SELECT time_ns / 1e9 AS time_s, text AS fault FROM events WHERE kind = 'fault' ORDER BY time_ns";
/// What traffic that behaves did (from truth), and the alerts of control against those on truth (from tracks).
const TRAFFIC: &str =
    "SELECT name AS measure, value, unit, source FROM measures ORDER BY source DESC, rowid";

/// A table; empty where it has no rows, or the log is of a version without it.
fn table_or_nothing(database: &Connection, query: &str) -> anyhow::Result<String> {
    let Some(name) = query.split(" FROM ").nth(1).and_then(|rest| rest.split(' ').next()) else {
        return Ok(String::new());
    };
    let known = "SELECT count(*) FROM sqlite_master WHERE name = ?1";
    if database.query_row(known, [name], |row| row.get::<_, i64>(0))? == 0 {
        return Ok(String::new());
    }
    let table = Table::of(database, query)?;
    Ok(if table.rows.is_empty() { String::new() } else { table.html() })
}

/// What people at controllers' seats did, and which alerts followed; empty where nobody sat down.
fn people(database: &Connection) -> anyhow::Result<String> {
    let known = "SELECT count(*) FROM sqlite_master WHERE name = 'people_seats'";
    if database.query_row(known, [], |row| row.get::<_, i64>(0))? == 0 {
        return Ok(String::new());
    }
    let seats = Table::of(database, "SELECT * FROM people_seats")?;
    if seats.rows.is_empty() {
        return Ok(String::new());
    }
    let orders = Table::of(database, "SELECT * FROM people_orders")?.html();
    let alerts = Table::of(database, "SELECT * FROM people_alerts")?.html();
    Ok(format!(
        "{}<h3>What was said</h3>{orders}<h3>Alerts within 300 s of whom it was said to</h3>{alerts}",
        seats.html()
    ))
}

const STYLE: &str = "body{font:14px/1.45 system-ui,sans-serif;margin:0;background:#f4f6f9;color:#1b2430}\
main{max-width:1200px;margin:0 auto;padding:min(1.5rem,2vw)}h1{font-size:1.6rem;margin:.2rem 0 1rem}h2{font-size:1.05rem;margin:0 0 .6rem}\
section{background:#fff;border:1px solid #dde3ea;border-radius:6px;padding:1rem 1.2rem;margin-bottom:1rem;overflow:auto}\
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}\
th,td{padding:3px 12px 3px 0;border-bottom:1px solid #e6ebf1;text-align:right;white-space:nowrap}\
th{color:#5a6877;font-weight:600}td:first-child,th:first-child{text-align:left}\
svg{width:100%;height:auto;font:11px system-ui,sans-serif;fill:#5a6877}\
.verdict{font-size:1.15rem;font-weight:700;margin:.2rem 0 .7rem}pre{font-size:12px;overflow:auto;max-height:40em}.plot path{fill:none;stroke-width:1.4}path.grid{stroke:#e6ebf1;stroke-width:1}\
path.tracks{stroke:#1f6fd1}path.plots{stroke:#e0a23a;stroke-width:1}path.truth{stroke:#8a97a6;stroke-width:3.5;opacity:.55}\
path.weather{stroke:#3c9d84;stroke-dasharray:4 3}text.weather{fill:#2c7a66}circle.alarm{fill:#c3423f;opacity:.5}\
.key i{display:inline-block;width:22px;height:4px;margin:0 .3rem 0 1rem;vertical-align:middle}\
i.tracks{background:#1f6fd1}i.plots{background:#e0a23a}i.truth{background:#8a97a6}i.alarm{background:#c3423f}\
ul{columns:3 18em;padding-left:1.1rem}";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_keep_their_columns_and_quote_what_needs_it() {
        let database = Connection::open_in_memory().expect("a database");
        let table = Table::of(&database, "SELECT 2 AS z, 'a,\"b\"' AS a, NULL AS m, 0.5 AS x");
        let table = table.expect("a row");
        assert_eq!(table.csv(), "z,a,m,x\n2,\"a,\"\"b\"\"\",,0.5\n");
        assert_eq!(table.json()[0]["x"], 0.5);
        assert!(table.html().contains("<td>–</td>"));
        let none = Table::of(&database, "SELECT 1 AS only WHERE 0").expect("no row");
        assert_eq!(none.csv(), "only\n", "an empty table still says what it would hold");
    }

    #[test]
    fn faults_and_measures_of_the_traffic_stand_in_the_report_where_there_are_any() {
        let database = Connection::open_in_memory().expect("a database");
        let of = |query| table_or_nothing(&database, query).expect("read");
        assert_eq!((of(FAULTS), of(TRAFFIC)), (String::new(), String::new()), "an earlier log");
        database
            .execute_batch(
                "CREATE TABLE events (time_ns INTEGER, kind TEXT, subject TEXT, text TEXT);
                 CREATE TABLE measures (source TEXT, name TEXT, value REAL, unit TEXT);
                 INSERT INTO events VALUES (1000000000, 'alert', '', 'no fault');",
            )
            .expect("tables");
        assert_eq!((of(FAULTS), of(TRAFFIC)), (String::new(), String::new()), "all went well");
        database
            .execute_batch(
                "INSERT INTO events VALUES (2500000000, 'fault', '', 'deadlock: A, B wait');
                 INSERT INTO measures VALUES ('truth', 'taxi_out_mean', 312.4, 's');",
            )
            .expect("rows");
        assert!(of(FAULTS).contains("<td>2.50</td><td>deadlock: A, B wait</td>"), "{}", of(FAULTS));
        assert!(of(TRAFFIC).contains("taxi_out_mean") && of(TRAFFIC).contains("312.40"));
        assert!(!of(FAULTS).contains("no fault"));
    }

    #[test]
    fn weather_that_comes_back_is_marked_again_and_weather_that_stays_is_not() {
        let database = Connection::open_in_memory().expect("a database");
        database
            .execute_batch(
                "CREATE TABLE error_over_time (scan INTEGER, time_s REAL, track_rmse_m REAL, plot_rmse_m REAL);
                 INSERT INTO error_over_time VALUES (1, 1.0, 2.0, 3.0), (600, 600.0, 2.0, 3.0);
                 CREATE TABLE weather (time_ns INTEGER, rain_mm_per_h REAL, visibility_m REAL);
                 INSERT INTO weather VALUES (0, 0, NULL), (100000000000, 4, 800), (200000000000, 4, 800), (300000000000, 0, NULL);",
            )
            .expect("rows");
        let picture = error_picture(&database).expect("drawn");
        assert_eq!(picture.matches("<path class=\"weather\"").count(), 3, "{picture}");
        assert_eq!(picture.matches(">dry<").count(), 2, "before the rain and after it");
    }

    #[test]
    fn headings_have_words_and_units() {
        assert_eq!(heading("straight_raw_rmse_m"), "straight raw error (rms), m");
        assert_eq!(heading("tracked_percent"), "tracked, %");
        assert_eq!(heading("pd_asde"), "share of looks detected by asde");
        assert_eq!(heading("callsign"), "callsign");
        assert_eq!((shown(&json!(834.0)), shown(&json!(0.961))), ("834".into(), "0.96".into()));
    }

    #[test]
    fn axes_have_round_figures() {
        assert_eq!(ticks(0.0, 600.0), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0]);
        assert_eq!(ticks(-0.3, 0.31), [-0.2, 0.0, 0.2]);
        assert!(ticks(f64::NAN, 1.0).is_empty() && ticks(1.0, 1.0).is_empty());
    }
}
