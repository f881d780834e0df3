//! Weather as spectators hear it; receivers that compute with it read the PDU ([`super::weather_pdu`]).

use crate::runtime::messages::WeatherNotice;
use models::environment::Weather;
use models::frames::Vector2;
use models::time::SimTime;
use models::traffic::core::Day;

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

/// What movers feel of a weather that was told.
#[must_use]
pub fn day_of(notice: &WeatherNotice) -> Day {
    Day::from(&Weather {
        visibility_m: notice.visibility_m,
        temperature_k: notice.temperature_k,
        pressure_hpa: notice.pressure_hpa,
        wind_mps: Vector2::new(notice.wind_mps[0], notice.wind_mps[1]),
        film_mm: notice.film_mm,
        ..Weather::default()
    })
}
