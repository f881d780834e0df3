//! What is legal in a scene and still silly: each with a number, the line, and what to do about it.
//!
//! `# seeds: allow W07` on the line of a warning silences it.

mod errors;
mod movers;
mod wind;

pub use errors::errors;

use crate::control::Sees;
use crate::document::Section;
use crate::error::ScenarioError;
use crate::{Scene, load_text};
use models::frames::Vector2;
use models::fusion::config::AssociationMethod;
use models::sensors::asde::{DetectionRule, Energy};
use models::sensors::radar::equation::Polarisation;
use std::path::Path;

/// One warning.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Its number, as `W07`; 0 for what the readers of single tables say.
    pub number: u8,
    /// Line of the scene, from 1; 0 for the scene as a whole.
    pub line: usize,
    /// The key that it is about.
    pub key: String,
    /// What is silly about it, and what to do.
    pub text: String,
}

impl Warning {
    /// `W07`; nothing for the readers' own.
    #[must_use]
    pub fn word(&self) -> String {
        if self.number == 0 { String::new() } else { format!("W{:02}", self.number) }
    }
}

/// Reads a scene and says what is silly in it.
///
/// # Errors
/// As [`crate::load_text`].
pub fn check(path: &Path, text: &str) -> Result<(Scene, Vec<Warning>), ScenarioError> {
    let scene = load_text(path, text)?;
    let root = Section::parse(path, text)?;
    let mut found = of(&scene, &root)?;
    let lines: Vec<&str> = text.lines().collect();
    found.retain(|warning| {
        let line = warning.line.checked_sub(1).and_then(|i| lines.get(i)).copied();
        let allowed = line.and_then(|line| line.split("# seeds: allow ").nth(1));
        !allowed.is_some_and(|words| words.split([' ', ',']).any(|w| w == warning.word()))
    });
    found.sort_by_key(|warning| (warning.line, warning.number));
    Ok((scene, found))
}

fn of(scene: &Scene, root: &Section) -> Result<Vec<Warning>, ScenarioError> {
    let mut found = Vec::new();
    let mut say = |number: u8, section: &Section, key: &str, text: String| {
        let place = if section.path().is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", section.path())
        };
        let line =
            if section.has(key) || !section.path().is_empty() { section.line_of(key) } else { 0 };
        found.push(Warning { number, line, key: place, text });
    };
    let all = |word: &'static str| {
        root.sections(
            word,
            &crate::keys::words(
                crate::keys::TABLES.iter().find(|t| t.word == word).map_or(&[], |t| t.keys),
            ),
        )
    };
    let (traffic, sensors) = (all("traffic")?, all("sensor")?);
    let duration_s = scene.run.duration.s();
    let empty = root.empty("run");
    let run = root.any_section("run")?.unwrap_or(empty);
    let mut stands: Vec<(&str, &Section)> = Vec::new();
    for section in &traffic {
        let kind = section.text("kind")?.unwrap_or("");
        if let (true, Some(stand)) = (kind == "parked", section.text("stand")?) {
            if let Some((_, first)) = stands.iter().find(|(name, _)| *name == stand) {
                let at = first.line_of("stand");
                say(
                    1,
                    section,
                    "stand",
                    format!(
                        "two stand on \"{stand}\" all the time (the other in line {at}): give one of them another stand"
                    ),
                );
            }
            stands.push((stand, section));
        }
        let start_s = section
            .number("start_s", crate::document::within(f64::NEG_INFINITY, f64::INFINITY, "s"))?;
        if let Some(start_s) = start_s.filter(|s| *s >= duration_s) {
            say(
                2,
                section,
                "start_s",
                format!(
                    "it begins at {start_s} s, after the end of the run at {duration_s} s: start it earlier or make run.duration_s longer"
                ),
            );
        }
        if ["parked", "recorded", "route", "driven"].contains(&kind) && !section.has("flight") {
            let name = section.text("callsign")?.unwrap_or("");
            say(
                3,
                section,
                "callsign",
                format!(
                    "nobody expects {name}: without `flight` its track gets no name from the flight list"
                ),
            );
        }
        if kind == "generated"
            && ["arrivals_per_h", "departures_per_h"].iter().all(|k| !section.has(k))
        {
            say(4, section, "kind", "generated traffic without a rate makes no flight: give arrivals_per_h or departures_per_h".into());
        }
    }
    if !run.has("seed") {
        say(
            5,
            &run,
            "seed",
            "no seed: 1 is taken; state it, so that a copy of the scene plays the same draws"
                .into(),
        );
    } else if scene.run.seed == 0 {
        say(
            5,
            &run,
            "seed",
            "seed 0 looks like a key that was forgotten: any other number says that it was meant"
                .into(),
        );
    }
    let scan_ns = scene.run.scan().0.max(1);
    if scene.run.duration.0 % scan_ns != 0 {
        say(
            6,
            &run,
            "duration_s",
            format!(
                "{duration_s} s is not a whole number of scans: what comes after the last whole one is simulated and not published"
            ),
        );
    }
    if let Some(weather) = root.any_section("weather")? {
        let notices = weather.sections("timeline", &crate::keys::words(crate::keys::NOTICE))?;
        for notice in &notices {
            let any = crate::document::within(f64::NEG_INFINITY, f64::INFINITY, "");
            if let Some(text) = wind::of(scene, notice.number_or("at_s", 0.0, any)?) {
                say(24, notice, "wind_mps", text);
            }
            let visibility_m = notice.number("visibility_m", any)?;
            if let Some(metres) = visibility_m.filter(|m| *m < 50.0 || *m > 100_000.0) {
                say(
                    7,
                    notice,
                    "visibility_m",
                    format!(
                        "a visibility of {metres} m is seldom meant: 50 to 100000 m; leave it out for clear air"
                    ),
                );
            }
            for cell in notice.sections("cells", &crate::keys::words(crate::keys::CELL))? {
                let of = |key: &str| cell.number_or(key, 0.0, any);
                let distance_m =
                    Vector2::new(of("east_m")?, of("north_m")?).norm() - of("radius_m")?;
                let calm = notice.number_or("wind_mps", 0.0, any)? == 0.0;
                if distance_m > scene.airport.radius_m && calm {
                    say(
                        8,
                        &cell,
                        "east_m",
                        format!(
                            "the cell ends {distance_m:.0} m from the reference point, outside the airport, and no wind moves it"
                        ),
                    );
                }
            }
        }
    }
    if scene.sensors.is_empty() {
        say(9, root, "sensor", "no sensor: there will be no plots and no tracks".into());
    } else if scene.sensors.iter().all(|s| !s.kind.carried)
        && scene.flight_list.entries.is_empty()
        && scene.traffic.behaving.is_none()
    {
        say(10, root, "sensor", "no sensor identifies anybody and the flight list is empty: tracks stay without names; add an adsb or mlat sensor, or flights".into());
    }
    for (sensor, section) in scene.sensors.iter().zip(&sensors) {
        let Some(radar) = &sensor.asde else { continue };
        let (range_m, radius_m) = (radar.parameters.range_max_m, scene.airport.radius_m);
        if range_m > 10.0 * radius_m {
            say(
                11,
                section,
                "parameters",
                format!(
                    "the radar shows {range_m} m, more than ten times the airport's {radius_m} m: set range_max_m in overrides"
                ),
            );
        }
    }
    if scene.traffic.entities.is_empty() {
        let text = match root.is_list("traffic") {
            true => "nobody moves: [[traffic]] is there, but nobody comes of it",
            false => "nobody moves: add [[traffic]]",
        };
        say(12, root, "traffic", text.into());
    }
    let count = scene.traffic.entities.len();
    if count > 1000 {
        say(
            13,
            root,
            "traffic",
            format!("{count} movers: more than the page draws smoothly; run it with --no-viewer"),
        );
    }
    if scene.accuracy.position_m == 0.0 && count > 100 {
        let accuracy = root.any_section("accuracy")?.unwrap_or_else(|| root.empty("accuracy"));
        say(
            14,
            &accuracy,
            "position_m",
            format!(
                "a tolerance of 0 simulates everything exactly for {count} movers: slow; 0.1 is the default"
            ),
        );
    }
    for (i, sensor) in scene.sensors.iter().enumerate() {
        let same = |other: &crate::SensorScene| {
            other.kind == sensor.kind
                && other.site_m == sensor.site_m
                && other.overrides_equal(sensor)
        };
        if let Some(first) = scene.sensors[..i].iter().position(same) {
            let at = sensors[first].line();
            say(
                15,
                &sensors[i],
                "name",
                format!(
                    "the same sensor as in line {at}: its plots are the same but for their draws"
                ),
            );
        }
    }
    let failures = movers::failures(scene, &all("failure")?)?;
    for (number, section, key, text) in
        failures.into_iter().chain(movers::of(scene, &traffic, &sensors)?)
    {
        say(number, &section, key, text);
    }
    for (section, key, holds) in idle(scene, root, &sensors)? {
        say(16, &section, key, format!("does nothing here: it holds {holds}"));
    }
    Ok(found)
}

/// Keys that are given where another key's value leaves them nothing to do, and where they hold.
fn idle(
    scene: &Scene,
    root: &Section,
    sensors: &[Section],
) -> Result<Vec<(Section, &'static str, &'static str)>, ScenarioError> {
    let mut found = Vec::new();
    let mut note = |section: &Section, rows: &[(bool, &'static str, &'static str)]| {
        let given = rows.iter().filter(|(idle, key, _)| *idle && section.has(key));
        found.extend(given.map(|(_, key, holds)| (section.clone(), *key, *holds)));
    };
    if let Some(tracking) = root.any_section("tracking")? {
        let joint = matches!(scene.tracking.config.association, AssociationMethod::Joint { .. });
        note(&tracking, &[(!joint, "joint_limit", "with association = \"joint\"")]);
    }
    if let Some(control) = root.any_section("control")? {
        let nothing = scene.control.sees != Sees::Tracks;
        let with = "with sees = \"tracks\"";
        let bars = !scene.control.stop_bars;
        // Recorded movements go where they went.
        let recorded = scene.traffic.behaving.is_none();
        let behaves = "with [[traffic]] of kind \"generated\" or \"schedule\"";
        note(
            &control,
            &[
                (nothing, "confirm_scans", with),
                (nothing, "strip_margin_m", with),
                (scene.control.shift.is_none(), "shift", "with sequence = \"cps\""),
                (!scene.control.seats.any(), "fallback", "with a seat that is \"human\""),
                (nothing || bars, "bar_margin_m", "with sees = \"tracks\" and stop_bars = true"),
                (recorded, "policy", behaves),
                (recorded, "greens", behaves),
                (recorded, "sequence", behaves),
                (recorded, "wake", behaves),
                (recorded, "seats", behaves),
            ],
        );
    }
    for (sensor, section) in scene.sensors.iter().zip(sensors) {
        let Some(radar) = &sensor.asde else { continue };
        let Some(overrides) = section.any_section("overrides")? else { continue };
        let of = &radar.parameters;
        let linear = of.polarisation != Polarisation::Circular;
        let circular = "with polarisation = \"circular\"";
        note(
            &overrides,
            &[
                (of.detection != DetectionRule::Threshold, "pd", "with detection = \"threshold\""),
                (of.energy == Energy::SinglePulse, "dwell_factor", "with energy = \"dwell\""),
                (of.frequency_agile, "rain_spread_mps", "with frequency_agile = false"),
                (linear, "axial_ratio_db", circular),
                (linear, "circular_target_loss_db", circular),
            ],
        );
    }
    Ok(found)
}
