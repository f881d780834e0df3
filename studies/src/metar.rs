//! METAR reports as classes of weather for maps of a site.

use models::environment::Weather;
use std::collections::BTreeMap;

/// A kind of weather and how often it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// Its name.
    pub name: String,
    /// The weather.
    pub weather: Weather,
    /// Share of the reports.
    pub share: f64,
    /// Reports in all.
    pub of: u32,
}

/// Rain that stands for light, moderate and heavy, mm/h (assumed; reports state no rate), and the film of
/// water with it, mm (assumed).
const RAIN: [(f64, f64); 4] = [(0.0, 0.0), (1.0, 0.1), (5.0, 0.3), (20.0, 1.0)];
/// Steps of visibility, m: a report counts with the next lower one.
const VISIBILITY_M: [f64; 6] = [50.0, 150.0, 400.0, 1000.0, 3000.0, 10_000.0];

/// Lines that say something and are no report: [`classes`] passes them over.
#[must_use]
pub fn passed_over(text: &str) -> usize {
    text.lines().filter(|line| !line.trim().is_empty() && key(line).is_none()).count()
}

/// The classes of a text with one report a line, the most frequent first. A line that is no report is
/// passed over.
#[must_use]
pub fn classes(text: &str) -> Vec<Class> {
    let mut counts: BTreeMap<(usize, usize, i32), u32> = BTreeMap::new();
    let mut of = 0;
    for line in text.lines() {
        if let Some(key) = key(line) {
            *counts.entry(key).or_default() += 1;
            of += 1;
        }
    }
    let mut found: Vec<Class> = counts
        .into_iter()
        .map(|((rain, visibility, tens), n)| {
            let ((rain_mm_per_h, film_mm), visibility_m) = (RAIN[rain], VISIBILITY_M[visibility]);
            let clear = visibility + 1 == VISIBILITY_M.len();
            let weather = Weather {
                rain_mm_per_h,
                film_mm,
                visibility_m: if clear { f64::INFINITY } else { visibility_m },
                temperature_k: 273.15 + f64::from(10 * tens),
                ..Weather::default()
            };
            let name = format!("rain {rain_mm_per_h} visibility {visibility_m} {}C", 10 * tens);
            Class { name, weather, share: f64::from(n) / f64::from(of), of }
        })
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.name.cmp(&b.name)));
    found
}

fn digits(word: &str) -> bool {
    !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit())
}

/// Rain, visibility and tens of degrees of a report, which begins behind the time (ddhhmmZ): what is before it
/// are kind and station. `None` where it states no time, no visibility or no temperature.
fn key(line: &str) -> Option<(usize, usize, i32)> {
    let (mut rain, mut visibility_m, mut celsius) = (0, None, None);
    // Whole miles before a fraction of one.
    let mut whole = 0.0;
    let body = line.split(" RMK").next().unwrap_or(line);
    let body =
        ["TEMPO", "BECMG", "NOSIG"].iter().fold(body, |b, word| b.split(word).next().unwrap_or(b));
    let mut words = body.split_whitespace().map(|w| w.trim_end_matches('='));
    words.find(|w| w.len() == 7 && w.strip_suffix('Z').is_some_and(digits))?;
    for word in words {
        let miles_before = std::mem::take(&mut whole);
        // "NDV": the sensor knows no directions.
        let metres = word.strip_suffix("NDV").unwrap_or(word);
        if word == "CAVOK" || word == "P6SM" {
            visibility_m = visibility_m.or(Some(10_000.0));
        } else if metres.len() == 4 && digits(metres) {
            visibility_m = visibility_m.or(metres.parse().ok());
        } else if word.len() <= 2 && digits(word) {
            whole = word.parse().unwrap_or(0.0);
        } else if let Some(miles) = word.strip_suffix("SM") {
            let number = match miles.trim_start_matches(['P', 'M']).split_once('/') {
                Some((a, b)) => {
                    let parts = a.parse::<f64>().ok().zip(b.parse::<f64>().ok());
                    parts.map(|(a, b)| miles_before + a / b)
                }
                None => miles.trim_start_matches(['P', 'M']).parse().ok(),
            };
            visibility_m = visibility_m.or(number.map(|n: f64| 1609.344 * n));
        } else if let Some((t, dew)) = word.split_once('/') {
            let degrees = |s: &str| -> Option<i32> {
                let (sign, rest) = s.strip_prefix('M').map_or((1, s), |rest| (-1, rest));
                (rest.len() == 2 && digits(rest))
                    .then(|| rest.parse::<i32>().ok())
                    .flatten()
                    .map(|d| sign * d)
            };
            if degrees(dew).is_some() || dew == "//" {
                celsius = celsius.or(degrees(t));
            }
        } else if !word.starts_with("RE") {
            let (strength, phenomenon) = match word.as_bytes().first() {
                Some(b'-') => (1, &word[1..]),
                Some(b'+') => (3, &word[1..]),
                _ => (2, word),
            };
            let letters = phenomenon.bytes().all(|b| b.is_ascii_uppercase());
            let even = phenomenon.len().is_multiple_of(2) && phenomenon.len() <= 8;
            if letters && even && (phenomenon.contains("RA") || phenomenon.contains("DZ")) {
                let own = if phenomenon.contains("RA") { strength } else { 1 };
                rain = rain.max(own);
            }
        }
    }
    let visibility_m: f64 = visibility_m?;
    let step = VISIBILITY_M.iter().rposition(|v| visibility_m >= *v - 1.0).unwrap_or(0);
    Some((
        rain,
        step.max(usize::from(visibility_m >= 9999.0) * (VISIBILITY_M.len() - 1)),
        tens(celsius?),
    ))
}

fn tens(celsius: i32) -> i32 {
    (f64::from(celsius) / 10.0).round() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_fall_into_classes_of_rain_visibility_and_temperature() {
        let text = "METAR LSZH 241020Z 24008KT 9999 FEW030 12/07 Q1015 NOSIG=\n\
                    LSZH 241050Z 24008KT CAVOK 14/07 Q1015\n\
                    LSZH 241120Z 25015G27KT 3000 +SHRA BKN012 08/07 Q1009 TEMPO 1500 TSRA\n\
                    KBOS 241154Z 04012KT 1/2SM R04R/2400FT -RA FG OVC002 M02/M03 A2992 RMK AO2\n\
                    this is no report\n";
        let found = classes(text);
        let names: Vec<&str> = found.iter().map(|c| &*c.name).collect();
        assert_eq!(
            names,
            [
                "rain 0 visibility 10000 10C",
                "rain 1 visibility 400 0C",
                "rain 20 visibility 3000 10C"
            ]
        );
        assert_eq!((found[0].share, found[0].of), (0.5, 4));
        assert!(found[0].weather.visibility_m.is_infinite());
    }

    #[test]
    fn station_codes_are_no_weather_and_visibilities_are_read_in_all_their_forms() {
        for (line, name) in [
            ("METAR LIRA 241020Z 24008KT CAVOK 24/07 Q1015", "rain 0 visibility 10000 20C"),
            ("SPECI KDRA 241020Z AUTO 00000KT 10SM 24/07", "rain 0 visibility 10000 20C"),
            ("EDZO 241020Z 24008KT 9999NDV 24/07", "rain 0 visibility 10000 20C"),
            ("EDDM 241020Z AUTO 24008KT 4000NDV -DZ 04/02", "rain 1 visibility 3000 0C"),
            ("KBOS 241020Z 04012KT 1 1/2SM RA 04/02", "rain 5 visibility 1000 0C"),
            ("KBOS 241020Z 04012KT 2 1/4SM 04/02", "rain 0 visibility 3000 0C"),
            ("KBOS 241020Z 04012KT M1/4SM 04/02", "rain 0 visibility 400 0C"),
            ("KBOS 241020Z 04012KT P6SM 04/02", "rain 0 visibility 10000 0C"),
            ("KBOS 241020Z 04012KT 6SM 04/02", "rain 0 visibility 3000 0C"),
            ("EGLL 241020Z 04012KT 5000 +TSGRRA 14/12", "rain 20 visibility 3000 10C"),
        ] {
            let found = classes(line);
            assert_eq!(found.len(), 1, "{line}");
            assert_eq!(found[0].name, name, "{line}");
        }
        assert!(classes("LIRA 24008KT CAVOK 24/07").is_empty(), "of no time");
    }
}
