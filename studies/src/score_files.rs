//! Truth and tracks from comma-separated text, with or without quotes.
//!
//! The first line names the columns, in any order; what is not known here is ignored. Truth:
//! `time_s`, `target` (or `callsign`, `name`), a position, and if there are `vx_ms`, `vy_ms`, and `height_m` above the ground
//! (or `altitude_m`). Tracks: `time_s`, `track` (or `id`), a position, and if there are `vx_ms`, `vy_ms`, `label` (or
//! `callsign`, `name`), `published_s`, `status`. Alerts: see [`alerts`]. A position is `x_m`, `y_m` (east, north of the
//! reference point) or `lat_deg`, `lon_deg`. Where a column `kind` says track, truth or plot, as in what `seeds export`
//! writes, only rows of what is read count, and targets are told apart by `id`.

use csv::{ReaderBuilder, StringRecord, Trim};
use models::control::scoring::Told;
use models::frames::{Point2, Vector2};
use models::score::recording::{Report, Target, TruthPoint, differentiate};
use models::time::SimTime;
use scenarios::files::Lines;
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
    /// A track that has no number.
    #[error("line {line}: track: '{found}' is not a whole number from 0 to 2^53")]
    Track {
        /// Line of the text, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A field that does not end in its line.
    #[error("line {line}: a quote is not closed in its line")]
    Quote {
        /// Line of the text, from 1.
        line: usize,
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

struct Table {
    heads: Vec<String>,
    lines: Vec<(usize, StringRecord)>,
}

impl Table {
    /// Rows of one kind, where the rows say theirs.
    fn read(text: &str, kind: &str) -> Result<Self, FileError> {
        let mut table = Self::heads_of(text)?;
        if let Some(column) = table.column("kind") {
            let other = |found: &str| KINDS.contains(&found) && found != kind;
            table.lines.retain(|(_, fields)| !fields.get(column).is_some_and(other));
        }
        if table.lines.is_empty() { Err(FileError::Empty) } else { Ok(table) }
    }

    /// The same where there may be nothing but the heads.
    fn heads_of(text: &str) -> Result<Self, FileError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let (mut lines, mut numbers) = (Vec::new(), Lines::new(text.as_bytes(), true));
        for record in reader.records() {
            // Text is UTF-8 and rows may be of any length: nothing else is refused.
            let fields = record.map_err(|_| FileError::Empty)?;
            let line = numbers.of(fields.position());
            if fields.iter().any(|field| field.contains('\n')) {
                return Err(FileError::Quote { line });
            }
            if fields.iter().any(|field| !field.is_empty()) {
                lines.push((line, fields));
            }
        }
        if lines.is_empty() {
            return Err(FileError::Empty);
        }
        let heads = lines.remove(0).1.iter().map(str::to_ascii_lowercase).collect();
        Ok(Self { heads, lines })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.heads.iter().position(|h| h == name)
    }

    /// The first that is there of several names of a column.
    fn one_of(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.column(name))
    }

    fn need(&self, needed: &'static str) -> Result<usize, FileError> {
        self.need_one_of(&[needed])
    }

    /// The first that is there of several names, which all are missing else by the first of them.
    fn need_one_of(&self, names: &[&'static str]) -> Result<usize, FileError> {
        let found = || self.heads.join(", ");
        let needed = names.first().copied().unwrap_or_default();
        self.one_of(names).ok_or_else(|| FileError::Column { needed, found: found() })
    }
}

/// What rows of an export are of.
const KINDS: [&str; 3] = ["track", "truth", "plot"];

fn field(fields: &StringRecord, column: Option<usize>) -> Option<&str> {
    column.and_then(|c| fields.get(c)).filter(|f| !f.is_empty())
}

fn number(
    line: usize,
    fields: &StringRecord,
    column: Option<usize>,
    name: &'static str,
) -> Result<Option<f64>, FileError> {
    let Some(found) = field(fields, column) else { return Ok(None) };
    let parsed = found.parse::<f64>().ok().filter(|v| v.is_finite());
    parsed.map(Some).ok_or(FileError::Number { line, column: name, found: found.to_owned() })
}

fn needed(
    line: usize,
    fields: &StringRecord,
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
fn instant(line: usize, fields: &StringRecord, column: usize) -> Result<SimTime, FileError> {
    let seconds = needed(line, fields, column, "time_s")?;
    if seconds.abs() > MOST_TIME_S {
        return Err(FileError::Time {
            line,
            found: field(fields, Some(column)).unwrap_or_default().to_owned(),
        });
    }
    Ok(SimTime::from_s(seconds))
}

/// Largest time, s: the year 2096 counted from 1970.
const MOST_TIME_S: f64 = 4e9;

/// The two columns of a position and whether they are degrees.
fn position_columns(table: &Table, place: Place<'_>) -> Result<(usize, usize, bool), FileError> {
    let metres = table.column("x_m").zip(table.column("y_m"));
    if let Some((lat, lon)) = table.column("lat_deg").zip(table.column("lon_deg")) {
        // Without an airport metres will do, where both are there.
        return match (place, metres) {
            (Some(_), _) => Ok((lat, lon, true)),
            (None, Some((x, y))) => Ok((x, y, false)),
            (None, None) => Err(FileError::NoAirport),
        };
    }
    Ok((table.need("x_m")?, table.need("y_m")?, false))
}

fn position(
    line: usize,
    fields: &StringRecord,
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

/// Targets with their paths; velocities are differences where a row has none.
///
/// # Errors
/// With line and column.
pub fn truth(text: &str, place: Place<'_>) -> Result<Vec<Target>, FileError> {
    let table = Table::read(text, "truth")?;
    let time = table.need("time_s")?;
    let name = table.need_one_of(&["target", "callsign", "name"])?;
    // Several targets of an export may have no name.
    let id = table.column("id").filter(|_| table.column("kind").is_some());
    let at = position_columns(&table, place)?;
    let (vx, vy) = (table.column("vx_ms"), table.column("vy_ms"));
    let height = table.one_of(&["height_m", "altitude_m"]);
    let height_name = if table.column("height_m").is_some() { "height_m" } else { "altitude_m" };
    let mut paths: BTreeMap<(&str, &str), Vec<(TruthPoint, bool)>> = BTreeMap::new();
    for (line, fields) in &table.lines {
        let velocity = number(*line, fields, vx, "vx_ms")?.zip(number(*line, fields, vy, "vy_ms")?);
        let point = TruthPoint {
            time: instant(*line, fields, time)?,
            position_m: position(*line, fields, at, place)?,
            velocity_mps: velocity.map_or_else(Vector2::zeros, |(x, y)| Vector2::new(x, y)),
            height_m: number(*line, fields, height, height_name)?,
        };
        let name = field(fields, Some(name)).unwrap_or("");
        let key = (name, field(fields, id).unwrap_or(""));
        paths.entry(key).or_default().push((point, velocity.is_some()));
    }
    Ok(paths
        .into_iter()
        .map(|((name, _), mut states)| {
            states.sort_by_key(|(point, _)| point.time);
            let told: Vec<bool> = states.iter().map(|(_, told)| *told).collect();
            let given: Vec<TruthPoint> = states.into_iter().map(|(point, _)| point).collect();
            let mut path = given.clone();
            differentiate(&mut path);
            for ((point, given), _) in path.iter_mut().zip(given).zip(told).filter(|(_, t)| *t) {
                *point = given;
            }
            Target { name: name.to_owned(), path }
        })
        .collect())
}

/// Reports of tracks; those whose status is "last" or "tentative" are left out, numbers that come again
/// are told apart (see [`told_apart`]).
///
/// # Errors
/// With line and column.
pub fn tracks(text: &str, place: Place<'_>) -> Result<Vec<Report>, FileError> {
    let table = Table::read(text, "track")?;
    let (time, track) = (table.need("time_s")?, table.need_one_of(&["track", "id"])?);
    let at = position_columns(&table, place)?;
    let (vx, vy) = (table.column("vx_ms"), table.column("vy_ms"));
    let published = table.column("published_s");
    let label = table.one_of(&["label", "callsign", "name"]);
    let status = table.column("status");
    let mut reports = Vec::new();
    for (line, fields) in &table.lines {
        let velocity = number(*line, fields, vx, "vx_ms")?.zip(number(*line, fields, vy, "vy_ms")?);
        let report = Report {
            track: whole(*line, fields, track)?,
            time: instant(*line, fields, time)?,
            published: number(*line, fields, published, "published_s")?.map(SimTime::from_s),
            position_m: position(*line, fields, at, place)?,
            velocity_mps: velocity.map(|(x, y)| Vector2::new(x, y)),
            label: field(fields, label).unwrap_or("").to_owned(),
        };
        reports.push((report, Stage::of(field(fields, status).unwrap_or(""))));
    }
    Ok(told_apart(reports))
}

/// The number of a track.
fn whole(line: usize, fields: &StringRecord, column: usize) -> Result<u64, FileError> {
    const MOST: f64 = 9_007_199_254_740_992.0;
    let found = field(fields, Some(column)).unwrap_or("");
    let number = found.parse::<f64>().ok().filter(|n| n.fract() == 0.0 && (0.0..=MOST).contains(n));
    let number = number.map(|n| n as u64);
    number.ok_or_else(|| FileError::Track { line, found: found.to_owned() })
}

/// What a report says of its track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It stands, and is scored.
    Live,
    /// It is not confirmed yet.
    Tentative,
    /// It ends.
    Last,
}

impl Stage {
    /// By the word of a table: everything that is neither "tentative" nor "last" stands.
    #[must_use]
    pub fn of(status: &str) -> Self {
        if status.eq_ignore_ascii_case("last") {
            Self::Last
        } else if status.eq_ignore_ascii_case("tentative") {
            Self::Tentative
        } else {
            Self::Live
        }
    }
}

/// A track that was silent for longer is another one when its number comes again, ns.
const SILENT_NS: i64 = 30_000_000_000;

/// The reports that are scored, in the order of time; a number that comes again after its last message, or after 30 s
/// of silence, is another track, and has a number above all others.
#[must_use]
pub fn told_apart(mut reports: Vec<(Report, Stage)>) -> Vec<Report> {
    reports.sort_by_key(|(report, _)| (report.time, report.track));
    let mut next = reports.iter().map(|(report, _)| report.track).max().unwrap_or(0);
    let mut known: BTreeMap<u64, (u64, SimTime, bool)> = BTreeMap::new();
    let mut kept = Vec::new();
    for (mut report, stage) in reports {
        let number = report.track;
        let track = match known.get(&number) {
            None => number,
            Some((track, last, false)) if report.time.0 - last.0 <= SILENT_NS => *track,
            Some(_) => {
                next = next.wrapping_add(1);
                next
            }
        };
        known.insert(number, (track, report.time, stage == Stage::Last));
        if stage == Stage::Live {
            report.track = track;
            kept.push(report);
        }
    }
    kept
}

/// A time in seconds (`name_s`) or nanoseconds (`name_ns`) of the run.
struct TimeColumn {
    at: usize,
    name: &'static str,
    unit_s: f64,
}

impl TimeColumn {
    fn of(table: &Table, names: [&'static str; 2]) -> Option<Self> {
        let [s, ns] = names;
        let of = |name, unit_s| table.column(name).map(|at| Self { at, name, unit_s });
        of(s, 1.0).or_else(|| of(ns, 1e-9))
    }

    fn read(&self, line: usize, fields: &StringRecord) -> Result<Option<f64>, FileError> {
        let time_s = number(line, fields, Some(self.at), self.name)?.map(|t| t * self.unit_s);
        if time_s.is_some_and(|s| s.abs() > MOST_TIME_S) {
            return Err(FileError::Time {
                line,
                found: field(fields, Some(self.at)).unwrap_or_default().to_owned(),
            });
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
    fn fields_are_read_as_comma_separated_text_is_written() {
        // Commas within quotes, quotes within them, a mark of the octets' order, ends of lines of another system.
        let text =
            "\u{feff}time_s,track,x_m,y_m,label\r\n0,3,1,2,\"A,B\"\r\n1, 3 ,1,2,\"A\"\"B\"\r\n";
        let labels = |text| -> Vec<String> {
            tracks(text, None).expect("sound").into_iter().map(|r| r.label).collect()
        };
        assert_eq!(labels(text), ["A,B", "A\"B"]);
        let said = |text: &str| tracks(text, None).expect_err(text).to_string();
        // A quote that nobody closes would take all lines after it.
        assert!(
            said("time_s,track,x_m,y_m,label\n0,3,1,2,\"A\n1,3,1,2,B\n")
                .contains("line 2: a quote")
        );
        for number in ["-1", "1.7", "1e300", "T7", ""] {
            let said = said(&format!("time_s,track,x_m,y_m\n0,{number},1,2"));
            assert!(said.contains("line 2: track") && said.contains("whole number"), "{said}");
        }
        assert_eq!(tracks("time_s,track,x_m,y_m\n0,3.0,1,2", None).expect("sound")[0].track, 3);
    }

    #[test]
    fn a_state_without_a_velocity_has_that_of_its_neighbours_and_keeps_nobody_elses() {
        let text = "time_s,target,x_m,y_m,vx_ms,vy_ms\n0,A,0,0,11,0\n1,A,10,0,,\n2,A,20,0,,\n3,A,30,0,12,1\n";
        let path = &truth(text, None).expect("sound")[0].path;
        let found: Vec<(f64, f64)> =
            path.iter().map(|p| (p.velocity_mps.x, p.velocity_mps.y)).collect();
        assert_eq!(found, [(11.0, 0.0), (10.0, 0.0), (10.0, 0.0), (12.0, 1.0)]);
        // Heights above the ground go before altitudes.
        let text = "time_s,target,x_m,y_m,altitude_m,height_m\n0,A,0,0,432,0\n";
        assert_eq!(truth(text, None).expect("sound")[0].path[0].height_m, Some(0.0));
    }

    #[test]
    fn a_number_that_comes_again_is_another_track() {
        // 7 has its last message, 8 is silent for 31 s, 9 for 30 s; rows are in no order.
        let text = "time_s,track,x_m,y_m,status\n10,7,0,0,\n0,7,0,0,\n1,7,0,0,last\n0,8,0,0,\n31,8,0,0,\n0,9,0,0,\n30,9,0,0,\n";
        let mut found: Vec<(f64, u64)> = tracks(text, None)
            .expect("sound")
            .into_iter()
            .map(|r| (r.time.s().round(), r.track))
            .collect();
        found.sort_by(|a, b| a.1.cmp(&b.1).then(a.0.total_cmp(&b.0)));
        let expected = [(0.0, 7), (0.0, 8), (0.0, 9), (30.0, 9), (10.0, 10), (31.0, 11)];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_file_with_truth_and_tracks_is_read_as_either() {
        let text = "kind,id,name,utc,time_s,lat_deg,lon_deg,x_m,y_m,altitude_m,vx_ms,vy_ms,status\n\
                    track,7,SWR1,u,0,47,8,1,2,,3,4,confirmed\ntruth,1:1:1,SWR1,u,0,47,8,5,6,0.000,3,4,\n\
                    truth,1:1:2,,u,0,47,8,50,6,0.000,,,\ntruth,1:1:3,,u,0,47,8,90,6,0.000,,,\nplot,1,Radar,u,0,47,8,7,8,,,,\n";
        let reports = tracks(text, None).expect("metres do without an airport");
        let one = (reports.len(), reports[0].track, reports[0].label.as_str());
        assert_eq!(one, (1, 7, "SWR1"));
        assert_eq!(reports[0].position_m, Point2::new(1.0, 2.0));
        let targets = truth(text, None).expect("sound");
        let names: Vec<&str> = targets.iter().map(|t| t.name.as_str()).collect();
        assert_eq!(names, ["", "", "SWR1"], "who has no name is somebody yet");
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
    fn faults_are_named_with_their_own_line_whatever_is_before_it() {
        let before = ["", "# one", "# one\n\n", "\n\n\n", "#\"\n#\n\n# three", ",,,"];
        for (first, second) in before.iter().flat_map(|a| before.map(|b| (a, b))) {
            for (bad, said) in [("2,1,abc,0", "x_m: 'abc'"), ("2,1,3,\"4", "a quote is not closed")]
            {
                let text = format!(
                    "{first}\ntime_s,track,x_m,y_m\n{second}\n0,1,0,0\n{second}\n{bad}\n0,1,0,0\n"
                );
                // Commas alone are no heads.
                let due = 1 + text.lines().position(|l| l == bad).expect("there");
                for text in [text.clone(), text.replace('\n', "\r\n"), format!("\u{feff}{text}")] {
                    let told = tracks(&text, None).expect_err(&text).to_string();
                    assert!(told.starts_with(&format!("line {due}: {said}")), "{text:?}: {told}");
                }
            }
        }
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
