//! Schedules as tables (CSV).

use super::Wanted;
use crate::document::days_from_civil;
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use models::plot::Callsign;
use models::traffic::core::Direction;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A row with its cells by column and its time.
pub(super) struct CsvRow {
    line: usize,
    cells: BTreeMap<String, String>,
    pub(super) departs_ns: Option<i64>,
    pub(super) lands_ns: Option<i64>,
    /// Slot.
    slot_ns: Option<i64>,
}

impl CsvRow {
    fn cell(&self, name: &str) -> &str {
        self.cells.get(name).map_or("", String::as_str)
    }
}

/// The rows of a schedule, with their times.
pub(super) fn rows_of(file: &Path) -> Result<Vec<CsvRow>, ScenarioError> {
    let damaged = |line: usize, column: &str, found: String, needed: &'static str| {
        ScenarioError::new(file, line, column, Problem::Line { found, needed })
    };
    const TABLE: &str = "a comma-separated table with a header";
    let octets = crate::files::read_table(file, crate::LARGEST_DATA)
        .map_err(|e| damaged(1, "schedule", e.to_string(), TABLE))?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(octets.as_slice());
    let header =
        reader.headers().map_err(|e| damaged(1, "schedule", e.to_string(), TABLE))?.clone();
    let mut lines = crate::files::Lines::new(&octets, true);
    let first_line = lines.of(header.position());
    for needed in ["callsign", "type", "movement", "runway", "stand"] {
        if !header.iter().any(|h| h == needed) {
            return Err(damaged(first_line, "schedule", format!("no column {needed}"), TABLE));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record
            .map_err(|e| damaged(lines.of(e.position()), "schedule", e.to_string(), TABLE))?;
        let line = lines.of(record.position());
        let pairs = header.iter().zip(record.iter());
        let cells: BTreeMap<String, String> =
            pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        let mut row = CsvRow { line, cells, departs_ns: None, lands_ns: None, slot_ns: None };
        let time = |name: &'static str| -> Result<Option<i64>, ScenarioError> {
            let text = row.cell(name);
            if text.is_empty() {
                return Ok(None);
            }
            let ns = utc_ns(text);
            ns.map(Some).ok_or_else(|| {
                damaged(line, name, text.into(), "a UTC time like 2026-05-12T06:05:00Z")
            })
        };
        match row.cell("movement") {
            "departure" => {
                let times = [time("tobt")?, time("eobt")?, time("sobt")?];
                let departs = times.into_iter().flatten().next();
                let slot_ns = time("ctot")?;
                row.departs_ns = Some(departs.ok_or_else(|| {
                    damaged(line, "eobt", String::new(), "one of tobt, eobt, sobt")
                })?);
                row.slot_ns = slot_ns;
            }
            "arrival" => {
                let lands = time("eldt")?.or(time("sibt")?.map(|t| t - 480_000_000_000));
                row.lands_ns =
                    Some(lands.ok_or_else(|| {
                        damaged(line, "eldt", String::new(), "one of eldt, sibt")
                    })?);
            }
            other => {
                return Err(damaged(line, "movement", other.into(), "arrival or departure"));
            }
        }
        rows.push(row);
    }
    Ok(rows)
}

/// `2026-05-12T06:05:00Z`, nanoseconds since 1970; without seconds, with parts of them, or `+00:00` for `Z` as well.
pub(crate) fn utc_ns(text: &str) -> Option<i64> {
    let text = text.strip_suffix('Z').or_else(|| text.strip_suffix("+00:00"))?;
    let (date, clock) = text.split_once('T')?;
    let (clock, parts) = clock.split_once('.').unwrap_or((clock, "0"));
    let digits = !parts.is_empty() && parts.bytes().all(|b| b.is_ascii_digit());
    let parts_ns: i64 = format!("{:0<9.9}", parts).parse().ok().filter(|_| digits)?;
    let numbers = |text: &str, separator: char| -> Option<Vec<i64>> {
        text.split(separator).map(|p| p.parse().ok()).collect()
    };
    let (date, clock) = (numbers(date, '-')?, numbers(clock, ':')?);
    let [year, month, day] = date[..] else { return None };
    let [hour, minute, second] = match clock[..] {
        [hour, minute] if parts_ns == 0 => [hour, minute, 0],
        [hour, minute, second] => [hour, minute, second],
        _ => return None,
    };
    let sound = (1900..2200).contains(&year)
        && (1..=12).contains(&month)
        && (1..=days_of_month(year, month)).contains(&day)
        && (0..24).contains(&hour)
        && (0..60).contains(&minute)
        && (0..=60).contains(&second);
    let days = days_from_civil(year, month, day);
    sound.then(|| (((days * 24 + hour) * 60 + minute) * 60 + second) * 1_000_000_000 + parts_ns)
}

fn days_of_month(year: i64, month: i64) -> i64 {
    let (next_year, next) = if month == 12 { (year + 1, 1) } else { (year, month + 1) };
    days_from_civil(next_year, next, 1) - days_from_civil(year, month, 1)
}

/// The flights of a table, and call signs of arrivals that are none of the run: what lies before its start is over.
pub(super) fn scheduled(
    file: &Path,
    run: &Run,
) -> Result<(Vec<Wanted>, Vec<String>), ScenarioError> {
    const DAY_NS: i64 = 86_400_000_000_000;
    /// A run that begins so shortly before the first flight has the days of the table, also where midnight lies between.
    const BEFORE_NS: i64 = 3_600_000_000_000;
    let rows = rows_of(file)?;
    let times = || rows.iter().filter_map(|r| r.departs_ns.or(r.lands_ns));
    let first_ns = times().min().unwrap_or(0);
    let shift_ns = match first_ns - run.start_utc_ns {
        0..=BEFORE_NS => 0,
        _ => (run.start_utc_ns.div_euclid(DAY_NS) - first_ns.div_euclid(DAY_NS)) * DAY_NS,
    };
    let mut names = BTreeSet::new();
    let (mut wanted, mut others) = (Vec::new(), Vec::new());
    for row in &rows {
        let Some(ns) = row.departs_ns.or(row.lands_ns) else { continue };
        let time_s = (ns + shift_ns - run.start_utc_ns) as f64 / 1e9;
        let departure = row.departs_ns.is_some();
        let callsign = row.cell("callsign").to_owned();
        if time_s < if departure { -900.0 } else { 0.0 } || time_s > run.duration.s() {
            if !departure {
                others.push(callsign);
            }
            continue;
        }
        let sound = Callsign::new(&callsign).as_str() == callsign && !callsign.is_empty();
        if !sound || !names.insert(callsign.clone()) {
            let needed = "1 to 11 upper-case letters, digits or signs, each once";
            let problem = Problem::Line { found: callsign, needed };
            return Err(ScenarioError::new(file, row.line, "callsign", problem));
        }
        let address = match row.cell("address") {
            "" => None,
            text => {
                let hex = text.strip_prefix("0x").unwrap_or(text);
                let sound = u32::from_str_radix(hex, 16).ok().filter(|a| *a <= 0xff_ffff);
                let needed = "an address of 24 bits in hexadecimal, like 4b1800, or nothing";
                let problem = || Problem::Line { found: text.into(), needed };
                Some(
                    sound
                        .ok_or_else(|| ScenarioError::new(file, row.line, "address", problem()))?,
                )
            }
        };
        let after = row.cell("turnaround_of");
        wanted.push(Wanted {
            line: row.line,
            callsign,
            address: address.filter(|a| *a > 0),
            designator: row.cell("type").into(),
            direction: if departure { Direction::Departure } else { Direction::Arrival },
            runway: row.cell("runway").into(),
            stand: row.cell("stand").replace(' ', "_"),
            time_s: time_s.max(0.0),
            ctot_s: row.slot_ns.map(|ns| (ns + shift_ns - run.start_utc_ns) as f64 / 1e9),
            turnaround_of: (!after.is_empty()).then(|| after.into()),
        });
    }
    Ok((wanted, others))
}
