//! `[[board]]`: plates by which the light of the eye's view is measured.

use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::error::ScenarioError;
use crate::keys::{self, words};
use models::frames::Point3;

/// A square plate that is turned to who looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    /// Name for people.
    pub name: String,
    /// Its centre, m.
    pub centre_m: Point3<f64>,
    /// Its side, m.
    pub size_m: f64,
    /// Its luminance, of that of the horizon.
    pub luminance_ratio: f64,
}

/// Reads `[[board]]`.
pub(crate) fn read(root: &Section, airport: &AirportScene) -> Result<Vec<Board>, ScenarioError> {
    let one = |section: &Section| {
        let height_m = section.need_number("centre_height_m", within(0.0, 5000.0, "m"))?;
        Ok(Board {
            name: section.need_text("name", "a name for people")?.to_owned(),
            centre_m: airport.place_above(section, height_m)?,
            size_m: section.need_number("size_m", within(0.01, 1000.0, "m"))?,
            luminance_ratio: section.need_number("luminance_ratio", within(0.0, 100.0, ""))?,
        })
    };
    root.sections("board", &words(keys::BOARD))?.iter().map(one).collect()
}
