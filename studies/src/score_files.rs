//! Truth and tracks from comma-separated text.
//!
//! The first line names the columns, in any order; what is not known here is ignored. Truth:
//! `time_s`, `target`, a position, and if there are `vx_ms`, `vy_ms`, `altitude_m`. Tracks: `time_s`,
//! `track`, a position, and if there are `vx_ms`, `vy_ms`, `label` (or `callsign`), `published_s`,
//! `status`. Alerts: see [`alerts`]. A position is `x_m`, `y_m` (east, north of the reference point) or `lat_deg`, `lon_deg`.

use models::control::scoring::Told;
use models::frames::{Point2, Vector2};
use models::score::recording::{Report, Target, TruthPoint, differentiate};
use models::time::SimTime;
use std::collections::BTreeMap;

/// Why a text was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// A column that is needed is not there.
    #[error("line 1: column {needed} is missing; there are: {found}")]
    Column {
        /// What is needed.
        needed: &'static str,
        /// What there is.
        found: String,
    },
    /// A field is not what it should be.
    #[error("line {line}: {column}: '{found}' is not a number")]
    Number {
        /// Line of the text, from 1.
        line: usize,
        /// The column.
        column: &'static str,
        /// What stands there.
        found: String,
    },
    /// A time that no clock shows.
    #[error("line {line}: time_s: '{found}' is more than 4000000000 s")]
    Time {
        /// Line of the text, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// Positions in degrees without an airport to place them.
    #[error("line 1: positions are in degrees; name the scene of the airport with --scene")]
    NoAirport,
    /// A text without a line.
    #[error("no line of data")]
    Empty,
}

/// From degrees north and east to metres of the airport's frame.
pub type Place<'a> = Option<&'a dyn Fn(f64, f64) -> Point2<f64>>;

struct Table<'t> {
    heads: Vec<String>,
    lines: Vec<(usize, Vec<&'t str>)>,
}

impl<'t> Table<'t> {
    fn read(text: &'t str) -> Result<Self, FileError> {
        let table = Self::heads_of(text)?;
        if table.lines.is_empty() { Err(FileError::Empty) } else { Ok(table) }
    }

    /// The same where there may be nothing but the heads.
    fn heads_of(text: &'t str) -> Result<Self, FileError> {
        let mut lines = text.lines().enumerate().map(|(n, line)| (n + 1, line));
        let mut lines = lines.by_ref().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
        let cut = |line: &'t str| -> Vec<&'t str> {
            line.split(',').map(|f| f.trim().trim_matches('"')).collect()
        };
        let (_, first) = lines.next().ok_or(FileError::Empty)?;
        let heads = cut(first).into_iter().map(str::to_ascii_lowercase).collect();
        let lines: Vec<_> = lines.map(|(n, line)| (n, cut(line))).collect();
        Ok(Self { heads, lines })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.heads.iter().position(|h| h == name)
    }

    fn need(&self, needed: &'static str) -> Result<usize, FileError> {
        let found = || self.heads.join(", ");
        self.column(needed).ok_or_else(|| FileError::Column { needed, found: found() })
    }
}

fn field<'t>(fields: &[&'t str], column: Option<usize>) -> Option<&'t str> {
    column.and_then(|c| fields.get(c).copied()).filter(|f| !f.is_empty())
}

fn number(
    line: usize,
    fields: &[&str],
    column: Option<usize>,
    name: &'static str,
) -> Result<Option<f64>, FileError> {
    let Some(found) = field(fields, column) else { return Ok(None) };
    let parsed = found.parse::<f64>().ok().filter(|v| v.is_finite());
    parsed.map(Some).ok_or(FileError::Number { line, column: name, found: found.to_owned() })
}

fn needed(
    line: usize,
    fields: &[&str],
    column: usize,
    name: &'static str,
) -> Result<f64, FileError> {
    number(line, fields, Some(column), name)?.ok_or(FileError::Number {
        line,
        column: name,
        found: String::new(),
    })
}

/// Seconds of a run, of a day, or since 1970; what is beyond is no time.
fn instant(line: usize, fields: &[&str], column: usize) -> Result<SimTime, FileError> {
    let seconds = needed(line, fields, column, "time_s")?;
    if seconds.abs() > MOST_TIME_S {
        return Err(FileError::Time { line, found: fields[column].to_owned() });
    }
    Ok(SimTime::from_s(seconds))
}

/// Largest time, s: the year 2096 counted from 1970.
const MOST_TIME_S: f64 = 4e9;

/// The two columns of a position and whether they are degrees.
fn position_columns(
    table: &Table<'_>,
    place: Place<'_>,
) -> Result<(usize, usize, bool), FileError> {
    if let (Some(lat), Some(lon)) = (table.column("lat_deg"), table.column("lon_deg")) {
        return if place.is_some() { Ok((lat, lon, true)) } else { Err(FileError::NoAirport) };
    }
    Ok((table.need("x_m")?, table.need("y_m")?, false))
}

fn position(
    line: usize,
    fields: &[&str],
    (a, b, degrees): (usize, usize, bool),
    place: Place<'_>,
) -> Result<Point2<f64>, FileError> {
    match place.filter(|_| degrees) {
        Some(place) => {
            Ok(place(needed(line, fields, a, "lat_deg")?, needed(line, fields, b, "lon_deg")?))
        }
        None => Ok(Point2::new(needed(line, fields, a, "x_m")?, needed(line, fields, b, "y_m")?)),
    }
}

/// Targets with their paths; velocities are differences where the text has none.
///
/// # Errors
/// With line and column.
pub fn truth(text: &str, place: Place<'_>) -> Result<Vec<Target>, FileError> {
    let table = Table::read(text)?;
    let time = table.need("time_s")?;
    let name = table.column("target").map_or_else(|| table.need("callsign"), Ok);
    let name = name.map_err(|_| table.need("target").err().unwrap_or(FileError::Empty))?;
    let at = position_columns(&table, place)?;
    let (vx, vy) = (table.column("vx_ms"), table.column("vy_ms"));
    let height = table.column("altitude_m");
    let mut paths: BTreeMap<&str, Vec<TruthPoint>> = BTreeMap::new();
    for (line, fields) in &table.lines {
        let velocity = number(*line, fields, vx, "vx_ms")?.zip(number(*line, fields, vy, "vy_ms")?);
        paths.entry(field(fields, Some(name)).unwrap_or("")).or_default().push(TruthPoint {
            time: instant(*line, fields, time)?,
            position_m: position(*line, fields, at, place)?,
            velocity_mps: velocity.map_or_else(Vector2::zeros, |(x, y)| Vector2::new(x, y)),
            height_m: number(*line, fields, height, "altitude_m")?,
        });
    }
    let whole = vx.is_some() && vy.is_some();
    Ok(paths
        .into_iter()
        .map(|(name, mut path)| {
            path.sort_by_key(|p| p.time);
            if !whole {
                differentiate(&mut path);
            }
            Target { name: name.to_owned(), path }
        })
        .collect())
}

/// Reports of tracks; those whose status is "last" or "tentative" are left out.
///
/// # Errors
/// With line and column.
pub fn tracks(text: &str, place: Place<'_>) -> Result<Vec<Report>, FileError> {
    let table = Table::read(text)?;
    let (time, track) = (table.need("time_s")?, table.need("track")?);
    let at = position_columns(&table, place)?;
    let (vx, vy) = (table.column("vx_ms"), table.column("vy_ms"));
    let published = table.column("published_s");
    let label = table.column("label").or_else(|| table.column("callsign"));
    let status = table.column("status");
    let mut reports = Vec::new();
    for (line, fields) in &table.lines {
        let state = field(fields, status).unwrap_or("").to_ascii_lowercase();
        if state == "last" || state == "tentative" {
            continue;
        }
        let velocity = number(*line, fields, vx, "vx_ms")?.zip(number(*line, fields, vy, "vy_ms")?);
        reports.push(Report {
            track: needed(*line, fields, track, "track")? as u64,
            time: instant(*line, fields, time)?,
            published: number(*line, fields, published, "published_s")?.map(SimTime::from_s),
            position_m: position(*line, fields, at, place)?,
            velocity_mps: velocity.map(|(x, y)| Vector2::new(x, y)),
            label: field(fields, label).unwrap_or("").to_owned(),
        });
    }
    Ok(reports)
}

/// A time in seconds (`name_s`) or nanoseconds (`name_ns`) of the run.
struct TimeColumn {
    at: usize,
    name: &'static str,
    unit_s: f64,
}

impl TimeColumn {
    fn of(table: &Table<'_>, names: [&'static str; 2]) -> Option<Self> {
        let [s, ns] = names;
        let of = |name, unit_s| table.column(name).map(|at| Self { at, name, unit_s });
        of(s, 1.0).or_else(|| of(ns, 1e-9))
    }

    fn read(&self, line: usize, fields: &[&str]) -> Result<Option<f64>, FileError> {
        let time_s = number(line, fields, Some(self.at), self.name)?.map(|t| t * self.unit_s);
        if time_s.is_some_and(|s| s.abs() > MOST_TIME_S) {
            return Err(FileError::Time { line, found: fields[self.at].to_owned() });
        }
        Ok(time_s)
    }
}

/// Alerts of a safety net: `time_s` (or `time_ns`) at which it was raised, `kind` (a word of the rules or a message type of
/// ASTERIX category 004), `subjects` (call signs with blanks between, in any order), and if there are `end_s` (or `end_ns`;
/// empty: it stands) and `id`: rows with one `id`, like the stages of an alert, are one. So the table `alerts` of a run can be read.
///
/// # Errors
/// With line and column.
pub fn alerts(text: &str) -> Result<Vec<Told>, FileError> {
    let table = Table::heads_of(text)?;
    let time = TimeColumn::of(&table, ["time_s", "time_ns"]);
    let time = time.map_or_else(|| table.need("time_s").map(|_| None), |t| Ok(Some(t)))?;
    let Some(time) = time else { return Err(FileError::Empty) };
    let (kind, subjects) = (table.need("kind")?, table.need("subjects")?);
    let (end, id) = (TimeColumn::of(&table, ["end_s", "end_ns"]), table.column("id"));
    let mut alerts: Vec<Told> = Vec::new();
    let mut known: BTreeMap<&str, usize> = BTreeMap::new();
    for (line, fields) in &table.lines {
        let on_s = time.read(*line, fields)?.ok_or(FileError::Number {
            line: *line,
            column: time.name,
            found: String::new(),
        })?;
        let end_s = end.as_ref().map(|end| end.read(*line, fields)).transpose()?.flatten();
        let text = |at| field(fields, Some(at)).unwrap_or("");
        let mut names: Vec<String> = text(subjects).split_whitespace().map(str::to_owned).collect();
        names.sort();
        let told = Told {
            kind: text(kind).to_owned(),
            subjects: names,
            on_s,
            end_s: end_s.unwrap_or(f64::INFINITY),
            nearest_m: None,
        };
        let place = field(fields, id).map(|id| *known.entry(id).or_insert(alerts.len()));
        match place.and_then(|at| alerts.get_mut(at)) {
            Some(first) => {
                first.on_s = first.on_s.min(told.on_s);
                let ends = [first.end_s, told.end_s].into_iter().filter(|s| s.is_finite());
                first.end_s = ends.reduce(f64::max).unwrap_or(f64::INFINITY);
                first.subjects = first.subjects.clone().max(told.subjects);
            }
            None => alerts.push(told),
        }
    }
    Ok(alerts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alerts_of_any_net_are_read_and_the_stages_of_one_are_one() {
        let text = "id,kind,subjects,time_s,end_s\n7,RMCA_ARR,B A,12.5,40\n7,RMCA_ARR,B A,15,40\n8,STOPBAR,C,9,\n";
        let found = alerts(text).expect("sound");
        let row = |t: &Told| (t.kind.clone(), t.subjects.join("+"), t.on_s, t.end_s);
        let expected = [
            ("RMCA_ARR".to_owned(), "A+B".to_owned(), 12.5, 40.0),
            ("STOPBAR".to_owned(), "C".to_owned(), 9.0, f64::INFINITY),
        ];
        assert_eq!(found.iter().map(row).collect::<Vec<_>>(), expected);
        // The table of a run: nanoseconds; without an id every row is one.
        let text = "time_ns,kind,stage,subjects,end_ns\n12500000000,A,alarm,X,\n13500000000,A,alarm,X,14e9\n";
        let found = alerts(text).expect("sound");
        assert_eq!((found.len(), found[0].on_s, found[1].end_s), (2, 12.5, 14.0));
        assert_eq!(alerts("time_s,kind,subjects\n").expect("a net that says nothing"), []);
        let said = |text: &str| alerts(text).expect_err(text).to_string();
        assert!(said("time_s,kind\n1,A").contains("column subjects is missing"));
        assert!(said("kind,subjects\nA,X").contains("column time_s is missing"));
        assert_eq!(said("time_s,kind,subjects\n,A,X"), "line 2: time_s: '' is not a number");
        assert!(said("time_s,kind,subjects\n9e12,A,X").contains("line 2: time_s: '9e12'"));
        assert_eq!(said(""), "no line of data");
    }

    #[test]
    fn columns_may_come_in_any_order_and_velocities_may_be_missing() {
        let text = "target,y_m,x_m,time_s\nA,0,0,0\nA,0,10,1\nB,5,5,0\n# said\n\nA,0,20,2\n";
        let targets = truth(text, None).expect("sound");
        assert_eq!(targets.len(), 2);
        assert_eq!(targets[0].path[1].velocity_mps, Vector2::new(10.0, 0.0));
        let text = "time_s,track,x_m,y_m,vx_ms,vy_ms,callsign,status\n0,3,1,2,3,4,\"A\",confirmed\n\
                    1,3,1,2,,,A,last\n";
        let reports = tracks(text, None).expect("sound");
        assert_eq!(reports.len(), 1);
        assert_eq!((reports[0].track, reports[0].label.as_str()), (3, "A"));
        assert_eq!(reports[0].velocity_mps, Some(Vector2::new(3.0, 4.0)));
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let said = |text: &str| tracks(text, None).expect_err(text).to_string();
        assert_eq!(said(""), "no line of data");
        assert!(said("time_s,x_m,y_m\n0,0,0").contains("column track is missing"));
        assert_eq!(said("time_s,track,x_m,y_m\n0,1,east,0"), "line 2: x_m: 'east' is not a number");
        assert!(said("time_s,track,x_m,y_m\n0,1,nan,0").contains("is not a number"));
        assert!(said("time_s,track,x_m,y_m\n0,1,3").contains("line 2: y_m"));
        assert!(said("time_s,track,x_m,y_m\n1e15,1,3,4").contains("line 2: time_s: '1e15'"));
        assert!(said("time_s,track,lat_deg,lon_deg\n0,1,47,8").contains("--scene"));
        let place = |lat: f64, lon: f64| Point2::new(lon * 10.0, lat * 10.0);
        let found = tracks("time_s,track,lat_deg,lon_deg\n0,1,47,8", Some(&place)).expect("sound");
        assert_eq!(found[0].position_m, Point2::new(80.0, 470.0));
    }
}
