//! What the database of a run holds beside its scans: weather, flights, files, operations, what was said.

use super::rows::{SensorRow, inflated, real, value, value_or_none};
use super::{Archive, MOST_ROWS};
use crate::runtime::messages::{FlightNotice, Operation, WeatherNotice};
use crate::viewer_logger::said::{AlertRow, Said, Topic};
use rusqlite::{Connection, params};
use std::sync::Arc;

impl Archive {
    /// The weather notices of the run, in the order of time.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn weather(&self) -> rusqlite::Result<Vec<WeatherNotice>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM weather ORDER BY time_ns")?;
        let found = statement.query_map([], |row| {
            let cells: String = row.get("cells_json")?;
            Ok(WeatherNotice {
                from_ns: row.get("time_ns")?,
                rain_mm_per_h: row.get("rain_mm_per_h")?,
                visibility_m: row.get::<_, Option<f64>>("visibility_m")?.unwrap_or(f64::INFINITY),
                temperature_k: row.get::<_, f64>("temperature_c")? + 273.15,
                pressure_hpa: row.get("pressure_hpa")?,
                vapour_g_per_m3: row.get("vapour_g_per_m3")?,
                wind_mps: [row.get("wind_east_ms")?, row.get("wind_north_ms")?],
                film_mm: row.get("film_mm")?,
                cells: serde_json::from_str(&cells).unwrap_or_default(),
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// The flight list as it stood last.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn flights(&self) -> rusqlite::Result<Vec<FlightNotice>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM flights")?;
        let found = statement.query_map([], |row| {
            let address: Option<String> = row.get("address")?;
            let routing: Option<String> = row.get("routing")?;
            let ns = |s: f64| (s * 1e9).round() as i64;
            Ok(FlightNotice {
                callsign: row.get("callsign")?,
                address: address.and_then(|a| u32::from_str_radix(&a, 16).ok()),
                type_designator: row.get("type")?,
                wake: value_or_none(row, "wake")?,
                movement: value(row, "movement")?,
                runway: row.get("runway")?,
                stand: row.get("stand")?,
                stand_m: None,
                eta_ctd_ns: ns(row.get("eta_ctd_s")?),
                off_block_ns: row.get::<_, Option<f64>>("off_block_s")?.map(ns),
                routing: routing
                    .unwrap_or_default()
                    .split_whitespace()
                    .map(str::to_owned)
                    .collect(),
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// What operators did.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn operations(&self) -> rusqlite::Result<Vec<Operation>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT * FROM operations ORDER BY wall_utc_ns")?;
        let found = statement.query_map([], |row| {
            Ok(Operation {
                frame: row.get::<_, i64>("frame")? as u64,
                time_ns: row.get("time_ns")?,
                source: row.get("source")?,
                command: row.get("command")?,
                ok: row.get("done")?,
                text: row.get("answer")?,
            })
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// Name and octets of the scene's text and of its files.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn files(&self) -> rusqlite::Result<Vec<(String, Vec<u8>)>> {
        if !self.columns.has("files", "octets") {
            return Ok(Vec::new());
        }
        let database = self.database();
        let mut statement = database.prepare("SELECT name, octets FROM files")?;
        let found = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        found.take(MOST_ROWS).collect()
    }

    /// What was said of a topic last, as of a time; `i64::MAX`: at the end.
    #[must_use]
    pub fn said(&self, topic: Topic, time_ns: i64) -> Option<Arc<str>> {
        if !self.columns.has("said", "octets") {
            return None;
        }
        let read = |database: &Connection| {
            database
                .prepare_cached(
                    "SELECT time_ns, octets FROM said WHERE topic = ?1 AND time_ns <= ?2 \
                     ORDER BY time_ns DESC LIMIT 1",
                )?
                .query_map(params![topic.word(), time_ns], |row| {
                    Ok((row.get::<_, i64>(0)?, row.get::<_, Vec<u8>>(1)?))
                })?
                .next()
                .transpose()
        };
        let (said_ns, octets) = self.or_empty(read(&self.database()))?;
        let holds = time_ns == i64::MAX || time_ns.saturating_sub(said_ns) <= topic.holds_ns();
        inflated(&octets).filter(|_| holds).map(Arc::from)
    }

    /// The alerts of the run, with who acknowledged them.
    #[must_use]
    pub fn alerts(&self) -> Said {
        let mut said = Said::default();
        if !self.columns.has("alerts", "id") {
            return said;
        }
        let read = |database: &Connection| {
            let question = "SELECT id, kind, subjects, time_ns, stage, end_ns, place_x_m, place_y_m \
                 FROM alerts ORDER BY id, time_ns";
            let mut statement = database.prepare_cached(question)?;
            let found = statement.query_map([], |row| {
                let alert = AlertRow {
                    kind: value(row, 1)?,
                    subjects: row.get(2)?,
                    stages: vec![(row.get(3)?, value(row, 4)?)],
                    end_ns: row.get(5)?,
                    place_m: [real(row, 6)?, real(row, 7)?],
                    acknowledged: None,
                };
                Ok((row.get(0)?, alert))
            })?;
            found.take(MOST_ROWS).collect::<rusqlite::Result<Vec<(u32, AlertRow)>>>()
        };
        for (id, row) in self.or_empty(read(&self.database())) {
            said.row(id, row);
        }
        for operation in self.or_empty(self.operations()) {
            said.operation(&operation);
        }
        said
    }

    /// Time of the last scan, s.
    #[must_use]
    pub fn sums_end_s(&self) -> Option<f64> {
        self.sums.last().map(|s| s.time.s())
    }

    /// The effect plan: the rows that stood at the end.
    ///
    /// # Errors
    /// If the database refuses.
    pub fn plan(&self) -> rusqlite::Result<Vec<[String; 5]>> {
        let database = self.database();
        let question = "SELECT sensor, effect, called_for_by, bound, decision, max(scan) FROM plan \
             GROUP BY sensor, effect ORDER BY rowid";
        let mut statement = database.prepare(question)?;
        let found = statement.query_map([], |row| {
            Ok([row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?])
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// Number, name, kind and site of each sensor.
    pub(in crate::viewer_logger) fn sensors(&self) -> rusqlite::Result<Vec<SensorRow>> {
        let database = self.database();
        let mut statement = database.prepare("SELECT sensor, name, kind, x_m, y_m FROM sensors")?;
        let found = statement.query_map([], |row| {
            let at: (Option<f64>, Option<f64>) = (row.get(3)?, row.get(4)?);
            Ok((row.get(0)?, row.get(1)?, row.get(2)?, at.0.zip(at.1).map(|(x, y)| [x, y])))
        })?;
        found.take(MOST_ROWS).collect()
    }

    /// West, south, east and north end of the truth, m.
    pub(in crate::viewer_logger) fn bounds(&self) -> rusqlite::Result<Option<[f64; 4]>> {
        let question = "SELECT min(x_m), min(y_m), max(x_m), max(y_m) FROM truth";
        self.database().query_row(question, [], |row| {
            let ends =
                (0..4).map(|i| row.get::<_, Option<f64>>(i)).collect::<Result<Vec<_>, _>>()?;
            Ok(match ends[..] {
                [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
                _ => None,
            })
        })
    }
}
