//! Requirement values of surface movement guidance, as data.

use models::score::requirements::{Measure, Requirement, areas_of};
use serde::Deserialize;

/// The values and where they come from.
const TEXT: &str = include_str!("../data/asmgcs_requirements.json");

#[derive(Deserialize)]
struct File {
    source: String,
    rows: Vec<Line>,
}

#[derive(Deserialize)]
struct Line {
    standard: String,
    area: String,
    metric: String,
    kind: String,
    prob: f64,
    prob_is: String,
    threshold: Option<f64>,
    update_interval_s: Option<f64>,
    gap_s: Option<f64>,
}

/// Limits of the course where the file has none: those of the tool that it comes from.
const COURSE_DEG: (f64, f64) = (15.0, 30.0);

/// Rows about single fields of a transponder, which no score measures: the Mode 3/A code and the address
/// (ED-117A). The identification that it sends (MSID) is the call sign, which labels are held against.
const FIELDS: [&str; 2] = [" MA", " MSAD"];

/// The requirements on ground areas, in the order of the file; identification only where it is of the
/// target as a whole or of its call sign (not of the single fields Mode 3/A code and address).
///
/// # Panics
/// Never: the data is part of the program and a test reads it.
#[must_use]
pub fn all() -> Vec<Requirement> {
    let file: File = serde_json::from_str(TEXT).expect("the data of the program is sound");
    file.rows.iter().filter_map(requirement).collect()
}

/// Where the values come from.
///
/// # Panics
/// Never, as [`all`].
#[must_use]
pub fn source() -> String {
    serde_json::from_str::<File>(TEXT).expect("the data of the program is sound").source
}

fn requirement(line: &Line) -> Option<Requirement> {
    let at_least = line.prob_is == "at least";
    let (stand, other) = (COURSE_DEG.1, COURSE_DEG.0);
    let measure = match (line.kind.as_str(), at_least) {
        ("Detection", _) if line.gap_s.is_some() => Measure::Gaps,
        ("Detection", _) => Measure::Report,
        ("PositionDistance", true) => Measure::Position,
        ("PositionDistance", false) => Measure::FalseReports,
        ("Speed", _) => Measure::Speed,
        ("TrackAngle", _) => Measure::Course,
        ("IdentificationCorrect", _) => Measure::Identified,
        ("IdentificationFalse", _) => Measure::Misidentified,
        _ => return None,
    };
    let of_field = FIELDS.iter().any(|field| line.metric.ends_with(field));
    if areas_of(&line.area).is_empty() || (measure == Measure::Identified && of_field) {
        return None;
    }
    let course = if line.area.to_ascii_lowercase().contains("stand") { stand } else { other };
    Some(Requirement {
        standard: line.standard.clone(),
        area: line.area.clone(),
        name: line.metric.replace("Propability", "Probability"),
        measure,
        probability: line.prob,
        at_least,
        threshold: line.threshold.unwrap_or(if measure == Measure::Course { course } else { 0.0 }),
        interval_s: line.update_interval_s.unwrap_or(1.0),
        gap_s: line.gap_s.unwrap_or(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_values_are_whole_and_know_their_source() {
        let rows = all();
        // 94 lines, three of them about the air, two about single fields of a transponder.
        assert_eq!(rows.len(), 89);
        let identified: Vec<&str> = rows
            .iter()
            .filter(|r| r.standard == "ED-117A" && r.measure == Measure::Identified)
            .map(|r| r.name.as_str())
            .collect();
        assert_eq!(identified, ["Probability of Identification MSID"]);
        assert!(source().contains("COMPASS"));
        let position =
            rows.iter().find(|r| r.standard == "ED-116" && r.measure == Measure::Position);
        let position = position.expect("there");
        assert_eq!((position.threshold, position.probability), (7.5, 0.95));
        assert!(rows.iter().all(|r| r.measure != Measure::Gaps || r.gap_s >= 3.0));
    }
}
