//! What a report says first: whether the surveillance met its requirement, area by area; detection by area; where
//! everybody went, on the airport.

use crate::viewer_logger::drawing::view::{Fit, View};
use crate::viewer_logger::drawing::{Drawing, Shown, svg};
use crate::viewer_logger::picture::AirportMap;
use anyhow::Context;
use rusqlite::Connection;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Largest error that 95 % of the tracks may have on the movement area, m (EUROCAE ED-116/117, as in `docs/page.md`).
pub(super) const REQUIRED_M: f64 = 7.5;
/// Least share of targets that a track follows.
pub(super) const REQUIRED_TRACKED: f64 = 0.999;
/// Largest share of labels that name somebody else.
pub(super) const REQUIRED_WRONG: f64 = 1e-3;
/// Within so far of a stand a target counts as there, m.
const STAND_M: f64 = 45.0;
/// Higher ones are in the air, m.
const AIRBORNE_M: f64 = 15.0;
/// Fewer scans of targets say nothing.
const FEW: usize = 30;

/// A text as HTML has it.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Where a target is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Area {
    Runways,
    Taxiways,
    Stands,
    Air,
}

impl Area {
    const ALL: [Self; 4] = [Self::Runways, Self::Taxiways, Self::Stands, Self::Air];

    fn word(self) -> &'static str {
        match self {
            Self::Runways => "runways",
            Self::Taxiways => "taxiways and aprons",
            Self::Stands => "stands",
            Self::Air => "in the air",
        }
    }
}

/// Tells areas apart by the map.
pub(super) struct Areas<'a> {
    map: &'a AirportMap,
}

impl<'a> Areas<'a> {
    pub(super) fn of(map: &'a AirportMap) -> Self {
        Self { map }
    }

    pub(super) fn at(&self, [x, y]: [f64; 2], altitude_m: f64) -> Area {
        if altitude_m > AIRBORNE_M {
            return Area::Air;
        }
        let on = |r: &crate::viewer_logger::picture::RunwayShape| {
            let [a, b] = r.ends;
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let length = libm::hypot(dx, dy).max(1e-9);
            let along = ((x - a[0]) * dx + (y - a[1]) * dy) / length;
            let across = ((x - a[0]) * dy - (y - a[1]) * dx) / length;
            (0.0..=length).contains(&along) && across.abs() <= r.width_m / 2.0
        };
        if self.map.runways.iter().any(on) {
            return Area::Runways;
        }
        let near = |p: &[f64; 2]| libm::hypot(p[0] - x, p[1] - y) <= STAND_M;
        match self.map.stands.iter().any(|s| near(&s.position_m)) {
            true => Area::Stands,
            false => Area::Taxiways,
        }
    }
}

/// What was seen in one area.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    /// Scans of targets, and those with a track.
    looks: usize,
    tracked: usize,
    /// Errors of these tracks, m.
    errors_m: Vec<f32>,
    /// Tracks with a label, and with another's.
    labelled: usize,
    wrong: usize,
    /// By sensor: looks at targets that it ever saw, and those with a plot.
    sensors: BTreeMap<u16, (usize, usize)>,
}

impl Seen {
    fn error_m(&mut self, share: f64) -> Option<f64> {
        self.errors_m.sort_by(f32::total_cmp);
        let at = (share * self.errors_m.len() as f64).ceil() as usize;
        self.errors_m.get(at.checked_sub(1)?).map(|e| f64::from(*e))
    }

    fn rmse_m(&self) -> Option<f64> {
        let sum: f64 = self.errors_m.iter().map(|e| f64::from(*e) * f64::from(*e)).sum();
        (!self.errors_m.is_empty()).then(|| (sum / self.errors_m.len() as f64).sqrt())
    }
}

/// Everything by area, out of the tables.
pub(super) fn seen(
    database: &Connection,
    map: &AirportMap,
) -> anyhow::Result<BTreeMap<Area, Seen>> {
    let mut plotted: BTreeMap<u16, BTreeSet<(i64, String)>> = BTreeMap::new();
    let mut known: BTreeMap<u16, BTreeSet<String>> = BTreeMap::new();
    let mut statement = database
        .prepare("SELECT DISTINCT sensor, scan, cause FROM plots WHERE cause IS NOT NULL")?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        let (sensor, scan, cause): (u16, i64, String) = (row.get(0)?, row.get(1)?, row.get(2)?);
        known.entry(sensor).or_default().insert(cause.clone());
        plotted.entry(sensor).or_default().insert((scan, cause));
    }
    let areas = Areas::of(map);
    let mut all: BTreeMap<Area, Seen> = BTreeMap::new();
    let mut statement = database.prepare(
        "SELECT t.scan, t.callsign, t.x_m, t.y_m, t.altitude_m, t.track_error_m, k.callsign, k.entity \
         FROM truth t LEFT JOIN tracks k ON k.scan = t.scan AND k.track = t.track",
    )?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        let (scan, callsign): (i64, String) = (row.get(0)?, row.get(1)?);
        let figure = |at: usize| row.get::<_, Option<f64>>(at);
        let (Some(x), Some(y)) = (figure(2)?, figure(3)?) else { continue };
        let seen = all.entry(areas.at([x, y], figure(4)?.unwrap_or(0.0))).or_default();
        seen.looks += 1;
        if let Some(error_m) = figure(5)? {
            seen.tracked += 1;
            seen.errors_m.push(error_m as f32);
        }
        let label: Option<String> = row.get(6)?;
        if let Some(label) = label.filter(|l| !l.is_empty()) {
            seen.labelled += 1;
            seen.wrong += usize::from(label != callsign);
        }
        for (sensor, names) in &known {
            if names.contains(&callsign) {
                let (looks, found) = seen.sensors.entry(*sensor).or_default();
                *looks += 1;
                *found += usize::from(plotted[sensor].contains(&(scan, callsign.clone())));
            }
        }
    }
    Ok(all)
}

/// The verdict: one sentence and a table by area.
pub(super) fn verdict(all: &mut BTreeMap<Area, Seen>) -> String {
    let mut body = String::new();
    let (mut failed, mut met, mut few) = (Vec::new(), 0, 0);
    for area in Area::ALL {
        let Some(seen) = all.get_mut(&area) else { continue };
        let p95 = seen.error_m(0.95);
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
        let (tracked, wrong) = (share(seen.tracked, seen.looks), share(seen.wrong, seen.labelled));
        let mut why = Vec::new();
        if tracked < REQUIRED_TRACKED {
            why.push("tracked");
        }
        if p95.is_some_and(|e| e > REQUIRED_M) {
            why.push("error");
        }
        if wrong > REQUIRED_WRONG {
            why.push("labels");
        }
        // In the air the requirement of the surface does not hold.
        let judged = area != Area::Air && seen.looks >= FEW;
        let says = match (judged, why.is_empty()) {
            (false, _) if area == Area::Air => "not asked here".to_owned(),
            (false, _) => "too few to say".to_owned(),
            (true, true) => "met".to_owned(),
            (true, false) => format!("missed: {}", why.join(", ")),
        };
        match (judged, why.is_empty()) {
            (true, true) => met += 1,
            (true, false) => failed.push(area.word()),
            (false, _) => few += usize::from(area != Area::Air),
        }
        let metres = |m: Option<f64>| m.map_or("–".to_owned(), |m| format!("{m:.2}"));
        let _ = write!(
            body,
            "<tr><td>{}</td><td>{}</td><td>{:.2}</td><td>{}</td><td>{}</td><td>{} of {}</td><td>{says}</td></tr>",
            area.word(),
            seen.looks,
            100.0 * tracked,
            metres(p95),
            metres(seen.rmse_m()),
            seen.wrong,
            seen.labelled
        );
    }
    let sentence = match (met, few) {
        _ if all.is_empty() => "Nothing was seen.".to_owned(),
        _ if !failed.is_empty() => format!("The requirement is missed: {}.", failed.join("; ")),
        (0, 0) => "The requirement is not judged: nothing was on the surface.".to_owned(),
        (0, _) => format!(
            "The requirement is not judged: no area of the surface has {FEW} scans of targets."
        ),
        (_, 0) => "The requirement is met in every area.".to_owned(),
        _ => "The requirement is met in every area with enough scans of targets.".to_owned(),
    };
    format!(
        "<p class=\"verdict\">{sentence}</p><table><thead><tr><th>Area</th><th>scans of targets</th><th>tracked, %</th><th>error, 95 %, m</th><th>error (rms), m</th><th>wrong labels</th><th>verdict</th></tr></thead><tbody>{body}</tbody></table>\
         <p class=\"key\">Asked on the surface, by limits of this report: {} % of the scans of a target with a track, 95 % of the errors at most {REQUIRED_M} m, wrong labels at most 1 in 1 000.</p>",
        100.0 * REQUIRED_TRACKED
    )
}

/// Share of looks with a plot, by sensor and area.
pub(super) fn detection(all: &BTreeMap<Area, Seen>, names: &BTreeMap<u16, String>) -> String {
    let sensors: BTreeSet<u16> = all.values().flat_map(|s| s.sensors.keys().copied()).collect();
    if sensors.is_empty() {
        return "<p>none</p>".to_owned();
    }
    let mut out = "<table><thead><tr><th>Sensor</th>".to_owned();
    for area in Area::ALL {
        let _ = write!(out, "<th>{}, %</th>", area.word());
    }
    out += "</tr></thead><tbody>";
    for sensor in sensors {
        let name = names.get(&sensor).cloned().unwrap_or_else(|| format!("sensor {sensor}"));
        let _ = write!(out, "<tr><td>{}</td>", escaped(&name));
        for area in Area::ALL {
            let found = all.get(&area).and_then(|s| s.sensors.get(&sensor));
            let _ = match found.filter(|f| f.0 >= FEW) {
                Some((looks, plots)) => {
                    write!(out, "<td>{:.1}</td>", 100.0 * *plots as f64 / *looks as f64)
                }
                None => write!(out, "<td>–</td>"),
            };
        }
        out += "</tr>";
    }
    out + "</tbody></table><p class=\"key\">Scans with a plot, of all scans of the targets that the sensor saw at least once: one that looks less often than once a scan has no more than its looks, however sure it detects. The share of its looks is in the measures of the run.</p>"
}

/// Where everybody went, with the airport and names.
pub(super) fn map(database: &Connection, map: &AirportMap) -> anyhow::Result<String> {
    let mut truth: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    let mut tracks: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    for (question, into) in [
        ("SELECT callsign, x_m, y_m FROM truth ORDER BY entity, scan", &mut truth),
        ("SELECT CAST(track AS TEXT), x_m, y_m FROM tracks ORDER BY track, scan", &mut tracks),
    ] {
        let mut statement = database.prepare(question).context("reading where everybody went")?;
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            let at: (Option<f64>, Option<f64>) = (row.get(1)?, row.get(2)?);
            if let (Some(x), Some(y)) = at
                && x.abs() < 1e6
                && y.abs() < 1e6
            {
                into.entry(row.get(0)?).or_default().push([x, y]);
            }
        }
    }
    let mut view = View::new([1160.0, 760.0]);
    view.day = true;
    view.layers.remove("stands");
    view.fit = Fit::Given;
    view.camera.fit(&map.points(), 30.0);
    let scan = crate::runtime::messages::ScanReport::default();
    let shown = Shown {
        map,
        scan: &scan,
        trails: &[],
        weather: None,
        alerts: &[],
        caption: "grey: truth; blue: system tracks; at the end of each way its name",
    };
    let ground = svg::write(&Drawing::of(&shown, &view));
    let mut over = String::new();
    let mut line = |points: &[[f64; 2]], style: &str| {
        let mut path = String::new();
        let mut last: Option<[f64; 2]> = None;
        for point in points {
            let [x, y] = view.camera.to_screen(*point);
            if !((-500.0..1700.0).contains(&x) && (-500.0..1300.0).contains(&y)) {
                last = None;
                continue;
            }
            // A jump (a number used again) begins a new line; a pixel is enough.
            let near = last.map(|[a, b]| libm::hypot(a - x, b - y));
            if near.is_some_and(|d| d < 0.7) {
                continue;
            }
            let step = if near.is_some_and(|d| d < 300.0 * view.camera.scale) { 'L' } else { 'M' };
            let _ = write!(path, "{step}{x:.1} {y:.1}");
            last = Some([x, y]);
        }
        let _ = write!(over, "<path fill=\"none\" {style} d=\"{path}\"/>");
    };
    truth
        .values()
        .for_each(|way| line(way, "stroke=\"#5a686d\" stroke-width=\"4\" stroke-opacity=\".45\""));
    tracks.values().for_each(|way| line(way, "stroke=\"#1f6fd1\" stroke-width=\"1.2\""));
    for (name, way) in &truth {
        let Some([x, y]) = way.last().map(|p| view.camera.to_screen(*p)) else { continue };
        if (0.0..1160.0).contains(&x) && (0.0..760.0).contains(&y) {
            let name = escaped(name);
            let _ = write!(
                over,
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"#1d2a2f\" font-weight=\"700\">{name}</text>",
                x + 5.0,
                y - 5.0
            );
        }
    }
    Ok(ground.replace("</svg>", &format!("{over}</svg>")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::picture::{NamedPoint, RunwayShape};

    fn airport() -> AirportMap {
        let runway = RunwayShape {
            designators: ["09".into(), "27".into()],
            ends: [[0.0, 0.0], [3000.0, 0.0]],
            width_m: 45.0,
        };
        let stand = NamedPoint { name: "A1".into(), position_m: [500.0, 400.0] };
        AirportMap { runways: vec![runway], stands: vec![stand], ..AirportMap::default() }
    }

    #[test]
    fn areas_are_told_apart_by_the_map() {
        let map = airport();
        let areas = Areas::of(&map);
        assert_eq!(areas.at([1500.0, 22.0], 0.0), Area::Runways);
        assert_eq!(areas.at([1500.0, 23.0], 0.0), Area::Taxiways);
        assert_eq!(areas.at([-1.0, 0.0], 0.0), Area::Taxiways, "before the threshold");
        assert_eq!(areas.at([1500.0, 0.0], 16.0), Area::Air);
        assert_eq!(areas.at([500.0, 444.0], 0.0), Area::Stands);
    }

    #[test]
    fn the_verdict_names_the_area_that_misses_and_what() {
        let good = Seen {
            looks: 1000,
            tracked: 1000,
            errors_m: vec![1.0; 1000],
            labelled: 1000,
            ..Seen::default()
        };
        let mut bad = good.clone();
        bad.errors_m = (0..1000).map(|i| if i < 940 { 1.0 } else { 9.0 }).collect();
        bad.wrong = 2;
        let mut all = BTreeMap::from([(Area::Runways, good.clone()), (Area::Stands, good)]);
        assert!(verdict(&mut all).contains("met in every area"));
        all.insert(Area::Taxiways, bad);
        let text = verdict(&mut all);
        assert!(text.contains("missed: taxiways and aprons."), "{text}");
        assert!(text.contains("missed: error, labels"), "{text}");
        let mut few = BTreeMap::from([(Area::Stands, Seen { looks: 3, ..Seen::default() })]);
        assert!(verdict(&mut few).contains("too few to say"));
    }

    #[test]
    fn a_requirement_that_nothing_was_held_against_is_not_met() {
        let good = Seen { looks: 1000, tracked: 1000, labelled: 1000, ..Seen::default() };
        let few = Seen { looks: FEW - 1, tracked: FEW - 1, ..Seen::default() };
        let sentence = |areas: &[(Area, &Seen)]| {
            let mut all = areas.iter().map(|(area, seen)| (*area, (*seen).clone())).collect();
            let text = verdict(&mut all);
            text.split("</p>").next().map(str::to_owned).expect("a sentence")
        };
        for areas in [&[(Area::Air, &good)][..], &[(Area::Stands, &few)], &[(Area::Air, &few)]] {
            let text = sentence(areas);
            assert!(text.contains("not judged") && !text.contains("met"), "{text}");
        }
        let text = sentence(&[(Area::Runways, &good), (Area::Stands, &few)]);
        assert!(text.contains("met in every area with enough"), "{text}");
        assert!(sentence(&[(Area::Runways, &good)]).contains("met in every area."));
    }
}
