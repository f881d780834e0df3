//! Recorded movements: one CSV file a flight, its columns by `movements/columns.rs`; [`import`] makes such files of others.
//!
//! A missing or damaged cell does not refuse the file: the import of the truth counts it. A file
//! without the columns for time and position, or of nothing but damage, is refused.

mod columns;
pub mod import;

use crate::airport::AirportScene;
use crate::error::{Problem, ScenarioError};
use crate::files::Lines;
use columns::{Columns, Says};
use models::truth::recorded::Record;
use std::path::{Path, PathBuf};

/// The records of one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    /// The file.
    pub file: PathBuf,
    /// Call sign in the file, where there is one.
    pub callsign: Option<String>,
    /// 24-bit address in the file, where there is a sound one.
    pub address: Option<u32>,
    /// Records in the order of the file.
    pub records: Vec<Record>,
}

/// Most records of one movement: 4 h at 10 a second.
const MOST_RECORDS: usize = 144_000;

/// Reads the records of a file from `from_s` to `to_s` seconds after its first time.
///
/// # Errors
/// If the file cannot be read, or lacks a column that is needed.
pub fn read(
    file: &Path,
    airport: &AirportScene,
    from_s: f64,
    to_s: f64,
) -> Result<Movement, ScenarioError> {
    let error = |line, problem| ScenarioError::new(file, line, "movement", problem);
    let octets = crate::files::read_table(file, crate::LARGEST_DATA)
        .map_err(|e| error(1, Problem::File { path: file.to_path_buf(), reason: e.to_string() }))?;
    let unreadable = |e: csv::Error| {
        let line = Lines::new(&octets, false).of(e.position());
        error(line, Problem::File { path: file.to_path_buf(), reason: e.to_string() })
    };
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(octets.as_slice());
    let columns = Columns::of(reader.byte_headers().map_err(unreadable)?)
        .map_err(|(name, needed)| ScenarioError::new(file, 1, name, Problem::Missing { needed }))?;
    let elevation_m = airport.reference.height_m;
    let mut movement =
        Movement { file: file.to_path_buf(), callsign: None, address: None, records: Vec::new() };
    let mut first_ms: Option<i64> = None;
    let (mut row, mut lines) = (csv::ByteRecord::new(), Lines::new(&octets, false));
    while reader.read_byte_record(&mut row).map_err(unreadable)? {
        let (time_ms, line) = (columns.time_ms(&row), lines.of(row.position()));
        if first_ms.is_none() {
            first_ms = time_ms;
        }
        let since_s = match (time_ms, first_ms) {
            (Some(ms), Some(first)) => ms.saturating_sub(first) as f64 * 1e-3,
            _ => from_s,
        };
        // Without a cut at the begin a record before the first one is for the import to reject.
        if (from_s > 0.0 && since_s < from_s) || since_s > to_s {
            continue;
        }
        if movement.address.is_none() {
            movement.address = columns.address(&row);
        }
        if movement.callsign.is_none() {
            let callsign = columns.text(&row, Says::Callsign);
            movement.callsign = (!callsign.is_empty()).then(|| callsign.to_owned());
        }
        if movement.records.len() == MOST_RECORDS {
            let found = format!("more than {MOST_RECORDS} records");
            return Err(error(line, Problem::Line { found, needed: "one movement, up to 4 h" }));
        }
        movement.records.push(Record {
            line,
            time_ms,
            position_m: columns.place(&row).map(|place| place.local_m(airport)),
            altitude_m: columns.altitude_m(&row).map(|m| m - elevation_m),
            on_ground: columns.on_ground(&row),
        });
    }
    if movement.records.is_empty() {
        let needed = "records within the cut";
        return Err(error(1, Problem::Line { found: "no record".into(), needed }));
    }
    Ok(movement)
}
