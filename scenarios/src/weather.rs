//! `[weather]`: a timed list of notices; what a notice does not say stays as it was.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::run::Run;
use models::environment::{RainCell, Weather};
use models::frames::{Azimuth, Point2};
use models::time::SimTime;
use models::traffic::core::Day;
use std::sync::Arc;

/// The weather from a time on.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherNotice {
    /// When it begins.
    pub time: SimTime,
    /// What it is.
    pub weather: Weather,
}

/// What movers feel of it, each from a time on, s.
pub(crate) fn days(notices: &[WeatherNotice]) -> Arc<Vec<(f64, Day)>> {
    Arc::new(notices.iter().map(|n| (n.time.s(), Day::from(&n.weather))).collect())
}

/// Above this height of the field, m, a pressure that nobody says is told of: 7 % of the air are too much there.
const HIGH_M: f64 = 600.0;

/// Warns of an airport so high that the air of sea level, which is there where no notice says another pressure, is none of its own.
pub(crate) fn too_dense(notices: &[WeatherNotice], height_m: f64) -> Option<String> {
    let usual_hpa = Weather::default().pressure_hpa;
    let untold = notices.iter().all(|n| n.weather.pressure_hpa == usual_hpa);
    (untold && height_m > HIGH_M).then(|| {
        // The standard atmosphere (ICAO Doc 7488) below 11 km; its exponent is 5.256.
        let cooler = 1.0 - height_m / 44_330.77;
        let there_hpa = usual_hpa * cooler.powi(5) * cooler.sqrt().sqrt();
        format!(
            "weather.timeline.pressure_hpa: {usual_hpa} hPa are those of sea level; the field lies {height_m:.0} m high, where the \
             standard atmosphere has {there_hpa:.0} hPa"
        )
    })
}

/// Reads `[weather]`; without it the weather is clear and dry.
///
/// The second value warns of cells that are drier than what surrounds them: the heavier rain counts.
pub(crate) fn read(
    root: &Section,
    run: &Run,
) -> Result<(Vec<WeatherNotice>, Vec<String>), ScenarioError> {
    let mut warnings = Vec::new();
    let clear = WeatherNotice { time: SimTime::ZERO, weather: Weather::default() };
    let mut notices = vec![clear];
    let Some(section) = root.section("weather", &words(keys::WEATHER))? else {
        return Ok((notices, warnings));
    };
    let mut previous: Option<SimTime> = None;
    for entry in section.sections("timeline", &words(keys::NOTICE))? {
        let time = SimTime::from_s(entry.need_number("at_s", within(0.0, 86_400.0, "s"))?);
        let order = |needed| entry.refuse("at_s", Problem::Order { found: time.s(), needed });
        if previous.is_some_and(|p| time <= p) {
            return Err(order("a time after that of the entry before"));
        }
        if time > run.duration {
            return Err(order("a time within the run (run.duration_s)"));
        }
        previous = Some(time);
        let before = notices.last().expect("there is one from the start").weather.clone();
        let weather = notice(&entry, before)?;
        if time == SimTime::ZERO {
            notices.clear();
        }
        let around = weather.rain_mm_per_h;
        for cell in weather.cells.iter().filter(|c| c.rain_mm_per_h < around) {
            let key = if entry.has("cells") { "cells" } else { "rain_mm_per_h" };
            warnings.push(format!(
                "{}:{}: {}.{key}: a cell of {} mm/h in rain of {around} mm/h changes nothing: the \
                 heavier rain counts",
                entry.file().display(),
                entry.line_of(key),
                entry.path(),
                cell.rain_mm_per_h
            ));
        }
        notices.push(WeatherNotice { time, weather });
    }
    Ok((notices, warnings))
}

fn notice(entry: &Section, mut weather: Weather) -> Result<Weather, ScenarioError> {
    let change = |key, value: &mut f64, limits| -> Result<(), ScenarioError> {
        *value = entry.number_or(key, *value, limits)?;
        Ok(())
    };
    change("rain_mm_per_h", &mut weather.rain_mm_per_h, within(0.0, 1000.0, "mm/h"))?;
    change("visibility_m", &mut weather.visibility_m, within(10.0, f64::INFINITY, "m"))?;
    change("pressure_hpa", &mut weather.pressure_hpa, within(500.0, 1100.0, "hPa"))?;
    change("vapour_g_per_m3", &mut weather.vapour_g_per_m3, within(0.0, 60.0, "g/m³"))?;
    change("film_mm", &mut weather.film_mm, within(0.0, 20.0, "mm"))?;
    if let Some(celsius) = entry.number("temperature_c", within(-60.0, 60.0, "°C"))? {
        weather.temperature_k = celsius + 273.15;
    }
    if let Some(speed_mps) = entry.number("wind_mps", within(0.0, 80.0, "m/s"))? {
        let from_deg = entry.need_number("wind_from_deg", within(0.0, 360.0, "deg"))?;
        // Wind is named by where it comes from; the vector points to where it blows.
        weather.wind_mps = Azimuth::from_rad((from_deg + 180.0).to_radians()).unit() * speed_mps;
    }
    if entry.has("cells") {
        weather.cells = entry
            .sections("cells", &words(keys::CELL))?
            .iter()
            .map(|cell| {
                let place = within(-1e5, 1e5, "m");
                Ok(RainCell {
                    centre_m: Point2::new(
                        cell.need_number("east_m", place)?,
                        cell.need_number("north_m", place)?,
                    ),
                    radius_m: cell.need_number("radius_m", within(1.0, 1e5, "m"))?,
                    rain_mm_per_h: cell
                        .need_number("rain_mm_per_h", within(0.0, 1000.0, "mm/h"))?,
                })
            })
            .collect::<Result<_, ScenarioError>>()?;
    }
    Ok(weather)
}
