//! The columns of a movement: one dialect, with the names under which others write the same.
//!
//! `time_s` (or `timestamp_ms`) and a position, `lat_deg`, `lon_deg` or `x_m`, `y_m`, are needed; `callsign`, `address`,
//! `altitude_m` (or `altitude_ft`) and `on_ground` are not. Other columns are passed over.

use crate::airport::AirportScene;
use crate::schedule::table::utc_ns;
use csv::ByteRecord;
use models::frames::Point2;

/// What a column says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Says {
    /// Time, s; a UTC time like 2019-11-24T09:00:00Z is understood too.
    Seconds,
    Milliseconds,
    Latitude,
    Longitude,
    /// Both in one cell.
    LatitudeLongitude,
    East,
    North,
    Metres,
    Feet,
    Callsign,
    Address,
    OnGround,
    Type,
}

/// What a column says, and its names: ours first, as it is written, then others'. All in lower case.
const NAMES: &[(Says, &[&str])] = &[
    (Says::Milliseconds, &["timestamp_ms", "time_ms"]),
    (Says::Seconds, &["time_s", "time", "timestamp", "timestamp_s", "t_s", "t", "seconds"]),
    (Says::Latitude, &["latitude_deg", "lat_deg", "lat", "latitude"]),
    (Says::Longitude, &["longitude_deg", "lon_deg", "lon", "longitude", "lng", "long"]),
    (Says::LatitudeLongitude, &["position"]),
    (Says::East, &["x_m", "east_m", "x"]),
    (Says::North, &["y_m", "north_m", "y"]),
    (Says::Metres, &["altitude_m", "alt_m", "height_m"]),
    (Says::Feet, &["altitude_ft", "alt_ft"]),
    (Says::Callsign, &["callsign", "call_sign", "flight", "ident", "acid"]),
    (Says::Address, &["icao24", "address", "hex", "icao_address"]),
    (Says::OnGround, &["onground", "on_ground", "ground"]),
    (Says::Type, &["type", "typecode", "type_designator", "aircraft_type"]),
];

/// A column that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Column {
    says: Says,
    at: usize,
}

/// Where the columns of a file are.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    found: Vec<Column>,
    /// Commas of numbers are points: of files whose cells are parted by semicolons.
    pub(super) comma: bool,
}

/// A place as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// Latitude and longitude, deg.
    Degrees(f64, f64),
    /// East and north of the reference point, m.
    Metres(f64, f64),
}

impl Place {
    pub(super) fn local_m(self, airport: &AirportScene) -> Point2<f64> {
        match self {
            Self::Degrees(lat, lon) => airport.local_m(lat, lon),
            Self::Metres(x, y) => Point2::new(x, y),
        }
    }
}

impl Columns {
    /// The columns of a header.
    ///
    /// # Errors
    /// The first one that is needed and missing, and all that are, in words.
    pub(super) fn of(header: &ByteRecord) -> Result<Self, (&'static str, String)> {
        let names: Vec<String> = header
            .iter()
            .map(|cell| String::from_utf8_lossy(cell).trim_matches(strange).to_lowercase())
            .collect();
        let mut found = Vec::new();
        for (says, known) in NAMES {
            // Our own name goes before another's where both are there.
            let at = known.iter().find_map(|k| names.iter().position(|n| n == k));
            found.extend(at.map(|at| Column { says: *says, at }));
        }
        let has = |says: Says| found.iter().any(|c: &Column| c.says == says);
        let mut missing: Vec<(&'static str, &str)> = Vec::new();
        if !has(Says::Milliseconds) && !has(Says::Seconds) {
            missing.push(("timestamp_ms", "timestamp_ms in the header (or time_s)"));
        }
        let metres = [Says::East, Says::North].map(has);
        if !has(Says::LatitudeLongitude) && metres != [true; 2] {
            if metres.contains(&true) {
                let (name, words) =
                    if metres[0] { ("y_m", "y_m beside x_m") } else { ("x_m", "x_m beside y_m") };
                missing.push((name, words));
            } else {
                if !has(Says::Latitude) {
                    missing
                        .push(("latitude_deg", "latitude_deg in the header (or lat_deg; or x_m)"));
                }
                if !has(Says::Longitude) {
                    let words = "longitude_deg in the header (or lon_deg; or y_m)";
                    missing.push(("longitude_deg", words));
                }
            }
        }
        match missing.first() {
            None => Ok(Self { found, comma: false }),
            Some((first, _)) => {
                let words: Vec<&str> = missing.iter().map(|m| m.1).collect();
                Err((first, format!("a column {}", words.join(", and one "))))
            }
        }
    }

    /// Whether there is such a column.
    pub(super) fn has(&self, says: Says) -> bool {
        self.found.iter().any(|c| c.says == says)
    }

    /// The text of a cell; empty where there is none.
    pub(super) fn text<'a>(&self, row: &'a ByteRecord, says: Says) -> &'a str {
        let column = self.found.iter().find(|c| c.says == says);
        let cell = column.and_then(|c| row.get(c.at));
        cell.and_then(|c| std::str::from_utf8(c).ok()).map_or("", str::trim)
    }

    fn number_of(&self, text: &str) -> Option<f64> {
        let found = if self.comma { text.replace(',', ".").parse() } else { text.parse() };
        found.ok().filter(|n: &f64| n.is_finite())
    }

    fn number(&self, row: &ByteRecord, says: Says) -> Option<f64> {
        self.number_of(self.text(row, says))
    }

    /// The time of a row, ms: since 1970, or since whatever the file counts from.
    pub(super) fn time_ms(&self, row: &ByteRecord) -> Option<i64> {
        if self.has(Says::Milliseconds) {
            return self.text(row, Says::Milliseconds).parse().ok();
        }
        let text = self.text(row, Says::Seconds);
        if let Some(seconds) = self.number_of(text) {
            let ms = (1000.0 * seconds).round();
            return (ms.abs() < 1e17).then_some(ms as i64);
        }
        let utc = text.replacen(' ', "T", 1);
        let utc = utc.strip_suffix("+00:00").map_or_else(|| utc.clone(), |t| format!("{t}Z"));
        utc_ns(&utc).map(|ns| ns / 1_000_000)
    }

    /// The place of a row; none where it is missing, no number, or on no globe.
    pub(super) fn place(&self, row: &ByteRecord) -> Option<Place> {
        let degrees = |lat: f64, lon: f64| {
            (lat.abs() <= 90.0 && lon.abs() <= 180.0).then_some(Place::Degrees(lat, lon))
        };
        if self.has(Says::Latitude) && self.has(Says::Longitude) {
            return degrees(self.number(row, Says::Latitude)?, self.number(row, Says::Longitude)?);
        }
        if self.has(Says::LatitudeLongitude) {
            let (lat, lon) = self.text(row, Says::LatitudeLongitude).split_once([',', ' ', ';'])?;
            let part = |text: &str| text.trim().parse().ok().filter(|n: &f64| n.is_finite());
            return degrees(part(lat)?, part(lon)?);
        }
        let (x, y) = (self.number(row, Says::East)?, self.number(row, Says::North)?);
        Some(Place::Metres(x, y))
    }

    /// Altitude of a row, m.
    pub(super) fn altitude_m(&self, row: &ByteRecord) -> Option<f64> {
        if self.has(Says::Metres) {
            return self.number(row, Says::Metres);
        }
        self.number(row, Says::Feet).map(|feet| feet * FOOT_M)
    }

    /// The sound 24-bit address of a row.
    pub(super) fn address(&self, row: &ByteRecord) -> Option<u32> {
        let hex = u32::from_str_radix(self.text(row, Says::Address), 16).ok();
        hex.filter(|a| (1..0x100_0000).contains(a))
    }

    /// Whether the row says that it is on the ground.
    pub(super) fn on_ground(&self, row: &ByteRecord) -> Option<bool> {
        match self.text(row, Says::OnGround) {
            "true" | "True" | "TRUE" | "1" => Some(true),
            "false" | "False" | "FALSE" | "0" => Some(false),
            _ => None,
        }
    }
}

/// What stands round a name and is none of it: blanks, quotation marks, the mark of a file's coding.
fn strange(c: char) -> bool {
    c.is_whitespace() || matches!(c, '"' | '\'' | '\u{feff}')
}

const FOOT_M: f64 = 0.3048;
