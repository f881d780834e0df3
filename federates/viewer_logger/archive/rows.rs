//! Rows of the tables of a run as what they were when they were written, in databases of any version.

use crate::runtime::messages::{LagMessage, PlotMessage, TrackMessage, TruthMessage};
use models::frames::{Point2, Point3};
use models::words::Word;
use rusqlite::types::Type;
use rusqlite::{Connection, Error, Row, RowIndex};
use std::collections::{BTreeMap, BTreeSet};

/// The questions for the tables of this file: what an earlier version did not write is asked for as NULL.
#[derive(Debug)]
pub(super) struct Columns {
    pub(super) known: BTreeMap<String, BTreeSet<String>>,
    pub(super) truth: String,
    pub(super) tracks: String,
    pub(super) plots: String,
    pub(super) effects: String,
}

impl Columns {
    pub(super) fn of(database: &Connection) -> rusqlite::Result<Self> {
        let mut statement = database.prepare(
            "SELECT m.name, c.name FROM sqlite_master m, pragma_table_info(m.name) c WHERE m.type = 'table'",
        )?;
        let mut known: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let mut found = statement.query([])?;
        while let Some(row) = found.next()? {
            known.entry(row.get(0)?).or_default().insert(row.get(1)?);
        }
        let mut columns = Self {
            known,
            truth: String::new(),
            tracks: String::new(),
            plots: String::new(),
            effects: String::new(),
        };
        let of_scan = |columns: &Self, table: &str, names: &[&str], key: &str| {
            let order = if columns.has(table, "place") { "place" } else { key };
            format!("{} WHERE scan = ?1 ORDER BY {order}", columns.select(table, names))
        };
        columns.truth = of_scan(&columns, "truth", &TRUTH, "entity");
        columns.tracks = of_scan(&columns, "tracks", &TRACKS, "track");
        columns.plots = of_scan(&columns, "plots", &PLOTS, "sensor, sequence");
        columns.effects = of_scan(&columns, "plot_effects", &EFFECTS, "sensor, sequence");
        Ok(columns)
    }

    pub(super) fn has(&self, table: &str, column: &str) -> bool {
        self.known.get(table).is_some_and(|columns| columns.contains(column))
    }

    pub(super) fn select(&self, table: &str, names: &[&str]) -> String {
        let named = |name: &&str| {
            if self.has(table, name) { (*name).to_owned() } else { format!("NULL AS {name}") }
        };
        let list: Vec<String> = names.iter().map(named).collect();
        format!("SELECT {} FROM {table}", list.join(", "))
    }
}

pub(super) const TRUTH: [&str; 17] = [
    "entity",
    "callsign",
    "type",
    "x_m",
    "y_m",
    "altitude_m",
    "vx_ms",
    "vy_ms",
    "vz_ms",
    "heading_rad",
    "heading_deg",
    "length_m",
    "span_m",
    "aircraft",
    "ours",
    "track",
    "track_error_m",
];

pub(super) fn truth(row: &Row<'_>) -> rusqlite::Result<TruthMessage> {
    let entity = row.get::<_, i64>(0)? as u64;
    let track: Option<u16> = row.get(15)?;
    let error_m = real(row, 16)?;
    Ok(TruthMessage {
        id: [(entity >> 32) as u16, (entity >> 16) as u16, entity as u16],
        callsign: words(row, 1)?,
        address: None,
        type_designator: words(row, 2)?,
        position_m: Point3::new(real(row, 3)?, real(row, 4)?, real(row, 5)?),
        velocity_mps: [real(row, 6)?, real(row, 7)?, row.get::<_, Option<f64>>(8)?.unwrap_or(0.0)],
        heading_rad: angle(row, 9)?,
        // What the first version of the tables did not keep: an aircraft of no known size.
        size_m: [
            row.get::<_, Option<f64>>(11)?.unwrap_or(0.0),
            row.get::<_, Option<f64>>(12)?.unwrap_or(0.0),
        ],
        aircraft: row.get::<_, Option<bool>>(13)?.unwrap_or(true),
        ours: row.get::<_, Option<bool>>(14)?.unwrap_or(true),
        track: track.map(|number| (number, error_m)),
    })
}

pub(super) const TRACKS: [&str; 45] = [
    "track",
    "status",
    "type",
    "callsign",
    "x_m",
    "y_m",
    "vx_ms",
    "vy_ms",
    "heading_rad",
    "heading_deg",
    "altitude_m",
    "var_ee_m2",
    "var_en_m2",
    "var_nn_m2",
    "manoeuvre",
    "lag_time_ns",
    "lag_x_m",
    "lag_y_m",
    "lag_var_ee_m2",
    "lag_var_en_m2",
    "lag_var_nn_m2",
    "lag_coasted",
    "lag_error_m",
    "assumed",
    "label_p",
    "estimate_ns",
    "first",
    "designator",
    "wake",
    "movement",
    "runway_stand",
    "routing",
    "ctd_eta_ns",
    "ax_ms2",
    "ay_ms2",
    "vvar_ee",
    "vvar_en",
    "vvar_nn",
    "entity",
    "error_m",
    "speed_ms",
    "address",
    "existence_p",
    "unresolved",
    "altitude_ns",
];

pub(super) fn track(row: &Row<'_>, scan_time_ns: i64) -> rusqlite::Result<TrackMessage> {
    let lag_time: Option<i64> = row.get(15)?;
    let lag = match lag_time {
        Some(time_ns) => Some(LagMessage {
            time_ns,
            position_m: Point2::new(real(row, 16)?, real(row, 17)?),
            cov_m2: [real(row, 18)?, real(row, 19)?, real(row, 20)?],
            coasted: row.get::<_, Option<bool>>(21)?.unwrap_or(false),
            error_m: row.get(22)?,
        }),
        None => None,
    };
    Ok(TrackMessage {
        number: row.get(0)?,
        status: value(row, 1)?,
        track_type: value(row, 2)?,
        callsign: words(row, 3)?,
        position_m: Point2::new(real(row, 4)?, real(row, 5)?),
        velocity_mps: [real(row, 6)?, real(row, 7)?],
        heading_rad: angle(row, 8)?,
        altitude_m: row.get(10)?,
        altitude_ns: row.get(41)?,
        cov_m2: [real(row, 11)?, real(row, 12)?, real(row, 13)?],
        manoeuvre: row.get::<_, Option<bool>>(14)?.unwrap_or(false),
        lag,
        assumed: words(row, 23)?,
        label_p: row.get(24)?,
        time_ns: row.get::<_, Option<i64>>(25)?.unwrap_or(scan_time_ns),
        first: row.get::<_, Option<bool>>(26)?.unwrap_or(false),
        type_designator: words(row, 27)?,
        wake: value_or_none(row, 28)?,
        movement: value_or_none(row, 29)?,
        runway_stand: words(row, 30)?,
        routing: words(row, 31)?.split_whitespace().map(str::to_owned).collect(),
        ctd_eta_ns: row.get(32)?,
        acceleration_ms2: [real(row, 33)?, real(row, 34)?],
        velocity_cov_m2s2: [real(row, 35)?, real(row, 36)?, real(row, 37)?],
        address: row.get(41)?,
        existence_p: row.get(42)?,
        unresolved: row.get::<_, Option<bool>>(43)?.unwrap_or(false),
    })
}

pub(super) const PLOTS: [&str; 28] = [
    "sensor",
    "sequence",
    "kind",
    "time_ns",
    "x_m",
    "y_m",
    "var_ee_m2",
    "var_en_m2",
    "var_nn_m2",
    "range_m",
    "azimuth_rad",
    "azimuth_deg",
    "scnr_db",
    "identity",
    "track",
    "cause",
    "truth_x_m",
    "truth_y_m",
    "axis_e",
    "axis_n",
    "along_m2",
    "across_m2",
    "altitude_m",
    "sigma_range_m",
    "sigma_azimuth_rad",
    "error_m",
    "scan",
    "sensor",
];

pub(super) fn plot(row: &Row<'_>) -> rusqlite::Result<PlotMessage> {
    let range: Option<f64> = row.get(9)?;
    let polar = match range {
        Some(range_m) => Some([range_m, angle(row, 10)?, real(row, 23)?, real(row, 24)?]),
        None => None,
    };
    let truth: (Option<f64>, Option<f64>) = (row.get(16)?, row.get(17)?);
    Ok(PlotMessage {
        sensor: row.get(0)?,
        sequence: row.get(1)?,
        kind: value(row, 2)?,
        time_ns: row.get(3)?,
        position_m: Point2::new(real(row, 4)?, real(row, 5)?),
        cov_m2: [real(row, 6)?, real(row, 7)?, real(row, 8)?],
        polar,
        scnr_db: row.get(12)?,
        identity: words(row, 13)?,
        address: None,
        track: row.get(14)?,
        cause: words(row, 15)?,
        truth_m: truth.0.zip(truth.1).map(|(x, y)| Point2::new(x, y)),
        ellipse: [real(row, 18)?, real(row, 19)?, real(row, 20)?, real(row, 21)?],
        altitude_m: row.get(22)?,
        velocity_mps: None, // of no frame
        effects: Vec::new(),
    })
}

/// Name, value and unit.
pub(super) type Effect = (String, f64, String);
/// Number, name, kind and site, m.
pub(super) type SensorRow = (u16, String, String, Option<[f64; 2]>);

pub(super) const EFFECTS: [&str; 5] = ["sensor", "sequence", "effect", "value", "unit"];

pub(super) fn rows<T>(
    database: &Connection,
    question: &str,
    scan: i64,
    read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
) -> rusqlite::Result<Vec<T>> {
    database.prepare_cached(question)?.query_map([scan], read)?.collect()
}

/// A text out of the table `said`; none where it is damaged or longer than any that is written.
pub(super) fn inflated(octets: &[u8]) -> Option<String> {
    use std::io::Read as _;
    let mut text = String::new();
    let decoder = flate2::read::ZlibDecoder::new(octets).take(MOST_TEXT);
    std::io::BufReader::new(decoder).read_to_string(&mut text).ok()?;
    Some(text)
}

/// A figure; NULL is what was not a number.
pub(super) fn real(row: &Row<'_>, at: usize) -> rusqlite::Result<f64> {
    Ok(row.get::<_, Option<f64>>(at)?.unwrap_or(f64::NAN))
}

pub(super) fn words(row: &Row<'_>, at: usize) -> rusqlite::Result<String> {
    Ok(row.get::<_, Option<String>>(at)?.unwrap_or_default())
}

/// The value of a word.
pub(super) fn value<T: Word>(row: &Row<'_>, at: impl RowIndex) -> rusqlite::Result<T> {
    let word: String = row.get(at)?;
    let column = at.idx(row.as_ref())?;
    let why =
        || format!("{:?} is not a valid {}", word.chars().take(32).collect::<String>(), T::WHAT);
    T::named(&word).ok_or_else(|| Error::FromSqlConversionFailure(column, Type::Text, why().into()))
}

/// The value of a word, where there is one.
pub(super) fn value_or_none<T: Word>(
    row: &Row<'_>,
    at: impl RowIndex,
) -> rusqlite::Result<Option<T>> {
    let word: Option<String> = row.get(at)?;
    if word.is_none_or(|word| word.is_empty()) { Ok(None) } else { value(row, at).map(Some) }
}

/// An angle in radians, or out of the column of degrees behind it, where an earlier version wrote only that.
pub(super) fn angle(row: &Row<'_>, at: usize) -> rusqlite::Result<f64> {
    Ok(match row.get::<_, Option<f64>>(at)? {
        Some(rad) => rad,
        None => real(row, at + 1)?.to_radians(),
    })
}

/// Longest text that is read, octets.
const MOST_TEXT: u64 = 8 << 20;
