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

/// Most rain cells at a time: as many as the network carries.
pub const MOST_CELLS: usize = 100;
/// Cells that the wind has carried farther east or north than this are forgotten, m: no radar sees them.
const FARTHEST_M: f64 = 1e6;

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
        let last = notices.last().expect("there is one from the start");
        // What the wind has done since; cells that are told anew are where they are told.
        let mut before = last.weather.after(time.since_s(last.time));
        before.cells.retain(|cell| cell.centre_m.coords.amax() <= FARTHEST_M);
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
        let cells = entry.sections("cells", &words(keys::CELL))?;
        if cells.len() > MOST_CELLS {
            let (found, high) = (cells.len() as f64, MOST_CELLS as f64);
            let problem = Problem::OutOfRange { found, low: 0.0, high, unit: "cells" };
            return Err(entry.refuse("cells", problem));
        }
        weather.cells = cells
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn notices(timeline: &str) -> Result<Vec<WeatherNotice>, ScenarioError> {
        let text =
            format!("[run]\ntitle = \"w\"\nseed = 1\nduration_s = 86400\n[weather]\n{timeline}\n");
        let root = Section::parse(Path::new("w.toml"), &text)?;
        let run = crate::run::read(&root, |_| Ok(Some(0)))?;
        Ok(read(&root, &run)?.0)
    }

    const WINDY: &str = "wind_mps = 80, wind_from_deg = 270";

    #[test]
    fn cells_that_a_notice_leaves_as_they_were_are_where_the_wind_has_carried_them() {
        let cell =
            "cells = [{ east_m = -395, north_m = 1084, radius_m = 600, rain_mm_per_h = 100 }]";
        let found = notices(&format!(
            "timeline = [{{ at_s = 0, {WINDY}, {cell} }}, {{ at_s = 20, visibility_m = 9000 }},\n\
             {{ at_s = 50.5, wind_mps = 10, wind_from_deg = 180 }}, {{ at_s = 90, film_mm = 1 }},\n\
             {{ at_s = 100, {cell} }}, {{ at_s = 60000, {WINDY} }}, {{ at_s = 86000, film_mm = 0 }}]"
        ));
        let found = found.expect("a timeline");
        for pair in found[..5].windows(2).filter(|w| w[1].time.s() < 100.0) {
            let since_s = pair[1].time.since_s(pair[0].time);
            assert_eq!(pair[1].weather.cells, pair[0].weather.after(since_s).cells);
        }
        let place = |i: usize| found[i].weather.cells[0].centre_m;
        for (i, east_m, north_m) in [
            (1, -395.0 + 1600.0, 1084.0),
            (3, -395.0 + 80.0 * 50.5, 1084.0 + 395.0),
            (4, -395.0, 1084.0),
        ] {
            assert!((place(i) - Point2::new(east_m, north_m)).norm() < 1e-6, "{i}: {}", place(i));
        }
        // Farther than a weather of the network may say.
        assert_eq!((found[5].weather.cells.len(), found[6].weather.cells.len()), (1, 0));
    }

    #[test]
    fn no_more_cells_are_taken_than_the_network_carries() {
        let of = |count: usize| {
            let cell = "{ east_m = 0, north_m = 0, radius_m = 5, rain_mm_per_h = 9 }";
            let cells = vec![cell; count].join(", ");
            notices(&format!("timeline = [{{ at_s = 0, cells = [{cells}] }}]"))
        };
        assert_eq!(of(100).expect("as many as go")[0].weather.cells.len(), 100);
        let error = of(101).expect_err("one too many").to_string();
        assert!(error.contains("timeline[1].cells") && error.contains("0 to 100"), "{error}");
    }
}
