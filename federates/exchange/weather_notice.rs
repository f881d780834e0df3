//! Weather as spectators hear it; receivers that compute with it read the PDU ([`super::weather_pdu`]).

use crate::runtime::messages::WeatherNotice;
use models::environment::Weather;
use models::time::SimTime;

/// A weather notice for spectators.
#[must_use]
pub fn notice_of(weather: &Weather, from: SimTime) -> WeatherNotice {
    WeatherNotice {
        from_ns: from.0,
        rain_mm_per_h: weather.rain_mm_per_h,
        visibility_m: weather.visibility_m,
        temperature_k: weather.temperature_k,
        pressure_hpa: weather.pressure_hpa,
        vapour_g_per_m3: weather.vapour_g_per_m3,
        wind_mps: [weather.wind_mps.x, weather.wind_mps.y],
        film_mm: weather.film_mm,
        cells: weather
            .cells
            .iter()
            .map(|c| [c.centre_m.x, c.centre_m.y, c.radius_m, c.rain_mm_per_h])
            .collect(),
    }
}
