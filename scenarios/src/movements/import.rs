//! Movements out of somebody's table: one file of any of the known columns becomes one movement a call sign, in our dialect.

use super::MOST_RECORDS;
use super::columns::{Columns, Place, Says};
use crate::error::{Problem, ScenarioError};
use crate::files::Lines;
use csv::ByteRecord;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// A movement of the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// Call sign, as scenes write it.
    pub callsign: String,
    /// Type designator in the table, where there is one.
    pub designator: Option<String>,
    /// The file of the dialect.
    pub csv: String,
    /// Records that were taken.
    pub records: usize,
    /// Records that were not: the reason, how many, and the line of the first.
    pub damaged: Vec<(&'static str, usize, usize)>,
    /// Time of the first record, as the table counts, s.
    pub first_s: f64,
    /// From the first to the last record, s.
    pub lasts_s: f64,
}

/// One record that is sound.
#[derive(Clone, Copy, Debug)]
struct Row {
    line: usize,
    time_ms: i64,
    place: Place,
    altitude_m: Option<f64>,
    on_ground: Option<bool>,
}

#[derive(Debug, Default)]
struct Flight {
    rows: Vec<Row>,
    address: Option<u32>,
    designator: Option<String>,
    damaged: BTreeMap<&'static str, (usize, usize)>,
}

/// Movements of one table, at most.
const MOST_MOVEMENTS: usize = 10_000;
/// Fewer records are no movement.
const LEAST_RECORDS: usize = 2;
const TIME: &str = "no time that can be read";
const PLACE: &str = "no place that can be read";
const TWICE: &str = "a time that was there before";

/// The movements of a table, by call sign: those `wanted`, all where none is named. A table without a column of call signs is
/// one movement, of the one name wanted.
///
/// # Errors
/// With file and line: what cannot be read, is missing, or is none of the table's call signs.
pub fn import(file: &Path, wanted: &[String]) -> Result<Vec<Imported>, ScenarioError> {
    let error = |line, problem| ScenarioError::new(file, line, "movement", problem);
    let octets = crate::files::read_table(file, crate::LARGEST_DATA)
        .map_err(|e| error(0, Problem::Unreadable { reason: e.to_string() }))?;
    let first = octets.split(|o| *o == b'\n').next().unwrap_or(&[]);
    let count = |mark: u8| first.iter().filter(|o| **o == mark).count();
    // Of the marks that part cells the one that the header has most of.
    let parted = *[b',', b';', b'\t'].iter().max_by_key(|m| count(**m)).unwrap_or(&b',');
    let parted = if count(parted) == 0 { b',' } else { parted };
    let mut reader =
        csv::ReaderBuilder::new().flexible(true).delimiter(parted).from_reader(octets.as_slice());
    let unreadable = |e: csv::Error| {
        let line = Lines::new(&octets, false).of(e.position());
        error(line, Problem::Unreadable { reason: e.to_string() })
    };
    let header = reader.byte_headers().map_err(unreadable)?;
    let mut columns = Columns::of(header)
        .map_err(|(name, needed)| ScenarioError::new(file, 1, name, Problem::Missing { needed }))?;
    columns.comma = parted == b';';
    let only = match (columns.has(Says::Callsign), wanted) {
        (true, _) => None,
        (false, [one]) => Some(one.as_str()),
        (false, _) => {
            let needed = "a column callsign in the header, or one --callsign NAME that says whose movement it is";
            let problem = Problem::Missing { needed: needed.into() };
            return Err(ScenarioError::new(file, 1, "callsign", problem));
        }
    };
    let mut flights: BTreeMap<String, Flight> = BTreeMap::new();
    let (mut row, mut lines) = (ByteRecord::new(), Lines::new(&octets, false));
    let mut nobody = 0;
    while reader.read_byte_record(&mut row).map_err(unreadable)? {
        let line = lines.of(row.position());
        let callsign = match only {
            Some(name) => name.to_owned(),
            None => columns.text(&row, Says::Callsign).to_uppercase(),
        };
        if callsign.is_empty() {
            nobody += 1;
            continue;
        }
        if !wanted.is_empty() && !wanted.iter().any(|w| w.eq_ignore_ascii_case(&callsign)) {
            // Its name alone, for those who ask for another.
            if flights.len() < MOST_MOVEMENTS {
                flights.entry(callsign).or_default();
            }
            continue;
        }
        if flights.len() >= MOST_MOVEMENTS && !flights.contains_key(&callsign) {
            let found = format!("more than {MOST_MOVEMENTS} call signs");
            let needed = "fewer, or --callsign NAME for some of them";
            return Err(error(line, Problem::Line { found, needed }));
        }
        let flight = flights.entry(callsign).or_default();
        if flight.rows.len() == MOST_RECORDS {
            let found = format!("more than {MOST_RECORDS} records");
            return Err(error(line, Problem::Line { found, needed: "one movement, up to 4 h" }));
        }
        flight.take(&columns, &row, line);
    }
    let known: Vec<String> = flights.keys().take(12).cloned().collect();
    for name in wanted {
        if !flights.contains_key(&name.to_uppercase()) && only.is_none() {
            let more = flights.len().saturating_sub(known.len());
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let allowed = format!("{}{more}", known.join(", "));
            let problem = Problem::NotAllowed { found: name.clone(), allowed };
            return Err(ScenarioError::new(file, 1, "callsign", problem));
        }
    }
    let asked =
        |name: &str| wanted.is_empty() || wanted.iter().any(|w| w.eq_ignore_ascii_case(name));
    let chosen: Vec<(String, Flight)> = flights.into_iter().filter(|f| asked(&f.0)).collect();
    if chosen.is_empty() {
        let found = match nobody {
            0 => "no record".to_owned(),
            n => format!("{n} records without a call sign"),
        };
        let needed = "a record a line, each with its call sign";
        return Err(error(2, Problem::Line { found, needed }));
    }
    let degrees = !matches!(
        chosen.iter().find_map(|f| f.1.rows.first()),
        Some(Row { place: Place::Metres(..), .. })
    );
    chosen
        .into_iter()
        .map(|(callsign, flight)| {
            let line = flight.damaged.values().map(|d| d.1).min().unwrap_or(1);
            let count = flight.rows.len();
            let reasons: Vec<String> = flight
                .damaged
                .iter()
                .map(|(why, (n, line))| format!("{n} with {why}, first in line {line}"))
                .collect();
            if count < LEAST_RECORDS {
                let found = format!("{callsign}: {count} sound records; {}", reasons.join("; "));
                return Err(error(line, Problem::Line { found, needed: "two at least" }));
            }
            Ok(flight.written(callsign, degrees))
        })
        .collect()
}

impl Flight {
    fn take(&mut self, columns: &Columns, row: &ByteRecord, line: usize) {
        if self.address.is_none() {
            self.address = columns.address(row);
        }
        let designator = columns.text(row, Says::Type);
        if self.designator.is_none() && !designator.is_empty() {
            self.designator = Some(designator.to_uppercase());
        }
        match (columns.time_ms(row), columns.place(row)) {
            (Some(time_ms), Some(place)) => self.rows.push(Row {
                line,
                time_ms,
                place,
                altitude_m: columns.altitude_m(row),
                on_ground: columns.on_ground(row),
            }),
            (None, _) => self.damage(TIME, line),
            (_, None) => self.damage(PLACE, line),
        }
    }

    fn damage(&mut self, why: &'static str, line: usize) {
        self.damaged.entry(why).or_insert((0, line)).0 += 1;
    }

    fn written(mut self, callsign: String, degrees: bool) -> Imported {
        self.rows.sort_by_key(|r| (r.time_ms, r.line));
        let mut rows: Vec<Row> = Vec::with_capacity(self.rows.len());
        for row in std::mem::take(&mut self.rows) {
            if rows.last().is_some_and(|r| r.time_ms == row.time_ms) {
                self.damage(TWICE, row.line);
            } else {
                rows.push(row);
            }
        }
        let place = if degrees { "lat_deg,lon_deg" } else { "x_m,y_m" };
        let mut csv = format!("time_s,callsign,{place},altitude_m,address,on_ground\n");
        let address = self.address.map_or_else(String::new, |a| format!("{a:06x}"));
        let name = match callsign.contains([',', '"', '\n', '\r']) {
            true => format!("\"{}\"", callsign.replace('"', "\"\"")),
            false => callsign.clone(),
        };
        for row in &rows {
            let sign = if row.time_ms < 0 { "-" } else { "" };
            let (seconds, ms) = (row.time_ms.abs() / 1000, row.time_ms.abs() % 1000);
            let _ = match row.place {
                Place::Degrees(lat, lon) => {
                    write!(csv, "{sign}{seconds}.{ms:03},{name},{lat:.7},{lon:.7},")
                }
                Place::Metres(x, y) => {
                    write!(csv, "{sign}{seconds}.{ms:03},{name},{x:.2},{y:.2},")
                }
            };
            let altitude = row.altitude_m.map_or_else(String::new, |m| format!("{m:.1}"));
            let ground = row.on_ground.map_or("", |g| if g { "true" } else { "false" });
            let _ = writeln!(csv, "{altitude},{address},{ground}");
        }
        let lasts_ms = rows.last().zip(rows.first()).map_or(0, |(b, a)| b.time_ms - a.time_ms);
        Imported {
            callsign,
            designator: self.designator,
            csv,
            records: rows.len(),
            damaged: self.damaged.iter().map(|(why, (n, line))| (*why, *n, *line)).collect(),
            first_s: rows.first().map_or(0.0, |r| r.time_ms as f64 * 1e-3),
            lasts_s: lasts_ms as f64 * 1e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, text: &str, wanted: &[&str]) -> Result<Vec<Imported>, String> {
        let file =
            std::env::temp_dir().join(format!("seeds-import-{}-{name}.csv", std::process::id()));
        std::fs::write(&file, text).expect("a file");
        let wanted: Vec<String> = wanted.iter().map(|w| (*w).to_owned()).collect();
        let result = import(&file, &wanted);
        let _ = std::fs::remove_file(&file);
        result.map_err(|e| e.to_string().replace(&file.display().to_string(), "FILE"))
    }

    #[test]
    fn a_strange_table_becomes_our_dialect() {
        // Semicolons and decimal commas, a mark of the coding, others' names, two flights in turn, a line twice, and damage.
        let text = "\u{feff}Timestamp;Flight;Latitude;Longitude;Alt_ft;Speed;Hex;Typecode\n\
            2019-11-24T09:00:00Z;swr1;47,4500000;8,5600000;1400;3;4b1800;a320\n\
            2019-11-24T09:00:00Z;BAW2;47,4600000;8,5500000;;;;\n\
            2019-11-24T09:00:02Z;SWR1;47,4500100;8,5600200;;;;\n\
            2019-11-24T09:00:01Z;SWR1;47,4500050;8,5600100;;;;\n\
            2019-11-24T09:00:01Z;SWR1;47,4500050;8,5600100;;;;\n\
            noon;SWR1;47,45;8,56;;;;\n\
            2019-11-24T09:00:03Z;SWR1;north;8,56;;;;\n\
            2019-11-24T09:00:04Z;BAW2;47,4600100;8,5500100;;;;\n";
        let found = of("strange", text, &[]).expect("understood");
        assert_eq!(found.iter().map(|f| &*f.callsign).collect::<Vec<_>>(), ["BAW2", "SWR1"]);
        let own = &found[1];
        assert_eq!(
            own.csv,
            "time_s,callsign,lat_deg,lon_deg,altitude_m,address,on_ground\n\
             1574586000.000,SWR1,47.4500000,8.5600000,426.7,4b1800,\n\
             1574586001.000,SWR1,47.4500050,8.5600100,,4b1800,\n\
             1574586002.000,SWR1,47.4500100,8.5600200,,4b1800,\n"
        );
        assert_eq!((own.designator.as_deref(), own.records, own.lasts_s), (Some("A320"), 3, 2.0));
        assert_eq!(own.damaged, [(TWICE, 1, 6), (PLACE, 1, 8), (TIME, 1, 7)]);
        // One of them, however it is written; and what we wrote is read again as the same.
        let one = of("one", text, &["Swr1"]).expect("one");
        assert_eq!(one, found[1..]);
        assert_eq!(of("again", &own.csv, &[]).expect("ours")[0].csv, own.csv);
    }

    /// A call sign with the mark that parts cells, and times before others: both are there again in what is written.
    #[test]
    fn what_is_written_is_read_again_as_it_was() {
        let text = "time,callsign,x,y\n100.25,\"A,\"\"1\"\"\",1,2\n101.25,\"A,\"\"1\"\"\",2,2\n-3.5,B,5,5\n-1.5,B,6,5\n";
        let found = of("quoted", text, &[]).expect("two");
        let first: Vec<(&str, f64)> = found.iter().map(|m| (&*m.callsign, m.first_s)).collect();
        assert_eq!(first, [("A,\"1\"", 100.25), ("B", -3.5)]);
        for movement in &found {
            let again = of("quoted-again", &movement.csv, &[]).expect("ours");
            assert_eq!(again, [Imported { designator: None, ..movement.clone() }]);
        }
    }

    #[test]
    fn metres_and_a_table_without_call_signs_are_understood() {
        let text = "t,x,y\n0,10,20\n0.5,11,20\n1,12.25,20\n";
        let found = of("metres", text, &["FOLLOW1"]).expect("one");
        assert!(found[0].csv.contains("\n0.500,FOLLOW1,11.00,20.00,,,\n"), "{}", found[0].csv);
        assert!(found[0].csv.starts_with("time_s,callsign,x_m,y_m,"));
        let tabs = "time\tcallsign\tposition\n10\tA1\t47.1,8.2\n11\tA1\t47.2,8.2\n";
        assert!(
            of("tabs", tabs, &[]).expect("tabs")[0].csv.contains("11.000,A1,47.2000000,8.2000000")
        );
    }

    /// Before zero, and UTC as others write it: with parts of seconds, without seconds, and no day that is none.
    #[test]
    fn times_keep_their_order_before_zero_and_their_parts_of_seconds() {
        let text = "t,x,y\n-1,10,20\n-0.5,11,20\n0,12,20\n0.5,13,20\n";
        let csv = &of("before", text, &["A1"]).expect("one")[0].csv;
        let times: Vec<&str> = csv.lines().skip(1).filter_map(|l| l.split(',').next()).collect();
        assert_eq!(times, ["-1.000", "-0.500", "0.000", "0.500"]);
        let text = "t,x,y\n2019-11-24 09:00:00.500+00:00,10,20\n2019-11-24T09:01Z,11,20\n\
            2019-02-29T09:00:00Z,12,20\n";
        let found = &of("utc", text, &["A1"]).expect("one")[0];
        let times: Vec<&str> =
            found.csv.lines().skip(1).filter_map(|l| l.split(',').next()).collect();
        assert_eq!(times, ["1574586000.500", "1574586060.000"]);
        assert_eq!(found.damaged, [(TIME, 1, 4)], "2019 had no 29 February");
    }

    #[test]
    fn what_cannot_be_taken_is_said_with_file_and_line() {
        for (name, text, wanted, expected) in [
            (
                "no",
                "",
                &[][..],
                "FILE:1: timestamp_ms: missing; needed is a column timestamp_ms in the header (or time_s), and one latitude_deg",
            ),
            (
                "half",
                "time_s,callsign,x_m\n1,A,2\n",
                &[],
                "FILE:1: y_m: missing; needed is a column y_m beside x_m",
            ),
            ("none", "time_s,callsign,lat,lon\n", &[], "FILE:2: movement: found \"no record\""),
            (
                "nobody",
                "time_s,lat,lon\n1,47,8\n",
                &[],
                "FILE:1: callsign: missing; needed is a column callsign in the header, or one --callsign NAME",
            ),
            (
                "other",
                "time_s,callsign,lat,lon\n1,A1,47,8\n2,B2,47,8\n",
                &["C3"],
                "FILE:1: callsign: found \"C3\", allowed is A1, B2",
            ),
            (
                "damage",
                "time_s,callsign,lat,lon\n1,A1,47,8\nx,A1,47,8\n2,A1,99,8\n",
                &[],
                "FILE:3: movement: found \"A1: 1 sound records; 1 with no place that can be read, first in line 4; 1 with ",
            ),
        ] {
            let error = of(name, text, wanted).expect_err(name);
            assert!(error.starts_with(expected), "{name}:\n{error}\n{expected}");
            assert!(!error.contains('\n'), "{error}");
        }
        let missing = import(Path::new("no/such.csv"), &[]).expect_err("none").to_string();
        assert!(missing.starts_with("movement no/such.csv: No such file"), "{missing}");
    }
}
