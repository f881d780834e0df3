//! Weather as an Environmental Process PDU: one private state record of big-endian doubles.
//!
//! Content of the record (type [`RECORD`]): rain mm/h, visibility m (infinite when clear), temperature K,
//! dry pressure hPa, water vapour g/m³, wind m/s east and north, water film mm, number of cells, then
//! per cell east m, north m, radius m, rain mm/h, and where cells are repeated the seconds since they were there.
//! All doubles, so that a recording repeats a run exactly; cells stay where the notice said and the receiver moves
//! them from then on, so that whoever hears any of the repetitions has the same bits.

use models::environment::{RainCell, Weather};
use models::frames::{Point2, Vector2};
use pdu::enumerations::EnvironmentRecordType;
use pdu::environment::{EnvironmentRecord, EnvironmentRecords, EnvironmentalProcess};
use pdu::records::{EntityId, EntityType};

/// Number of the private record: "SEED".
pub const RECORD: u32 = 0x5345_4544;

/// DIS application number of the external world and the administration station.
pub const WORLD_APPLICATION: u16 = 65_000;

/// Most cells that a PDU carries.
const MAX_CELLS: usize = scenarios::weather::MOST_CELLS;

/// Values before those of the cells.
const FIXED: usize = 9;

/// An encoded weather, ready to be borrowed by a PDU.
#[derive(Clone, Debug)]
pub struct EncodedWeather {
    content: Vec<u8>,
    site: u16,
    sequence: u16,
}

/// The content of the record for `weather`, whose cells were where it says `since_s` ago. Cells beyond
/// the most that a PDU carries are left out: no scene has them.
#[must_use]
pub fn encode(weather: &Weather, since_s: f64, site: u16, sequence: u16) -> EncodedWeather {
    let cells = &weather.cells[..weather.cells.len().min(MAX_CELLS)];
    let fixed: [f64; FIXED] = [
        weather.rain_mm_per_h,
        weather.visibility_m,
        weather.temperature_k,
        weather.pressure_hpa,
        weather.vapour_g_per_m3,
        weather.wind_mps.x,
        weather.wind_mps.y,
        weather.film_mm,
        cells.len() as f64,
    ];
    let of_cells =
        cells.iter().flat_map(|c| [c.centre_m.x, c.centre_m.y, c.radius_m, c.rain_mm_per_h]);
    // Nothing but cells moves: a weather without any is the same at any age, and so are its octets.
    let since = (since_s > 0.0 && !cells.is_empty()).then_some(since_s);
    let content =
        fixed.into_iter().chain(of_cells).chain(since).flat_map(f64::to_be_bytes).collect();
    EncodedWeather { content, site, sequence }
}

impl EncodedWeather {
    /// The PDU's body.
    #[must_use]
    pub fn pdu(&self) -> EnvironmentalProcess<'_> {
        let record = EnvironmentRecord {
            record_type: EnvironmentRecordType(RECORD),
            index: 0,
            padding: 0,
            content: &self.content,
        };
        EnvironmentalProcess {
            process_id: EntityId::new(self.site, WORLD_APPLICATION, 1),
            // Kind 4, environmental; domain 2, air.
            environment_type: EntityType::new(4, 2, 0, 0, 0, 0, 0),
            status: 2,
            sequence_number: self.sequence,
            records: EnvironmentRecords::Standard(vec![record].into()),
            ..EnvironmentalProcess::default()
        }
    }
}

/// The weather in a PDU and how long ago its cells were where it says, s, if it has our record and every value is
/// sound.
#[must_use]
pub fn decode(process: &EnvironmentalProcess<'_>) -> Option<(Weather, f64)> {
    let record = process.records.iter().find(|r| r.record_type.0 == RECORD)?;
    let mut values = record
        .content
        .chunks_exact(8)
        .map(|octets| f64::from_be_bytes(octets.try_into().expect("chunks of eight")));
    let mut within = |low: f64, high: f64| values.next().filter(|v| (low..=high).contains(v));
    let rain_mm_per_h = within(0.0, 1000.0)?;
    let visibility_m = within(1.0, f64::INFINITY)?;
    let temperature_k = within(150.0, 350.0)?;
    let pressure_hpa = within(500.0, 1200.0)?;
    let vapour_g_per_m3 = within(0.0, 100.0)?;
    let wind_mps = Vector2::new(within(-150.0, 150.0)?, within(-150.0, 150.0)?);
    let film_mm = within(0.0, 100.0)?;
    let count = within(0.0, MAX_CELLS as f64)? as usize;
    let mut cells = Vec::with_capacity(count);
    for _ in 0..count {
        cells.push(RainCell {
            centre_m: Point2::new(within(-1e6, 1e6)?, within(-1e6, 1e6)?),
            radius_m: within(0.0, 1e6)?,
            rain_mm_per_h: within(0.0, 1000.0)?,
        });
    }
    // A record that ends here was told when it began.
    let told = record.content.len() / 8 > FIXED + 4 * count;
    let since_s = if told { within(0.0, 1e9)? } else { 0.0 };
    let weather = Weather {
        rain_mm_per_h,
        visibility_m,
        temperature_k,
        pressure_hpa,
        vapour_g_per_m3,
        wind_mps,
        film_mm,
        cells,
    };
    Some((weather, since_s))
}
