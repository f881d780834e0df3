//! `[[building]]`: what stands on the airport, shadows targets and mirrors them.

use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use models::environment::surface::{MATERIALS, Material};
use models::frames::Point2;
use models::sensors::radar::shadow::Building;

/// Reads `[[building]]`. A footprint is a list of corners in order, each a place like that of a sensor.
pub(crate) fn read(root: &Section, airport: &AirportScene) -> Result<Vec<Building>, ScenarioError> {
    let facades: Vec<(&str, &'static Material)> = MATERIALS.iter().map(|m| (m.name, m)).collect();
    root.sections("building", &words(keys::BUILDING))?
        .iter()
        .map(|section| {
            let name = section.need_text("name", "a name for people")?.to_owned();
            let corners = section.sections("footprint", &keys::place_words())?;
            if !(3..=200).contains(&corners.len()) {
                let found = corners.len() as f64;
                let (low, high) = (3.0, 200.0);
                let problem = Problem::OutOfRange { found, low, high, unit: "corners" };
                return Err(section.refuse("footprint", problem));
            }
            let footprint_m: Vec<Point2<f64>> = corners
                .iter()
                .map(|corner| airport.site(corner).map(|place| place.xy()))
                .collect::<Result<_, _>>()?;
            if let Some((a, b)) = crossing(&footprint_m) {
                let problem = Problem::Crossing { first: a + 1, second: b + 1 };
                return Err(section.refuse("footprint", problem));
            }
            let building = Building {
                name,
                footprint_m,
                height_m: section.need_number("height_m", within(1.0, 500.0, "m"))?,
                facade: section
                    .choice("facade", &facades)?
                    .or_else(|| Material::named("concrete"))
                    .expect("concrete is a material"),
            };
            if building.area_m2() < 1.0 {
                let found = building.area_m2();
                let problem = Problem::OutOfRange { found, low: 1.0, high: 1e7, unit: "m²" };
                return Err(section.refuse("footprint", problem));
            }
            Ok(building)
        })
        .collect()
}

/// Two walls of a footprint that cross, by the places of their first corners.
fn crossing(corners: &[Point2<f64>]) -> Option<(usize, usize)> {
    let n = corners.len();
    let wall = |i: usize| (corners[i], corners[(i + 1) % n]);
    let side = |(a, b): (Point2<f64>, Point2<f64>), p: Point2<f64>| (b - a).perp(&(p - a));
    let cross = |i: usize, j: usize| {
        let (first, second) = (wall(i), wall(j));
        side(first, second.0) * side(first, second.1) < 0.0
            && side(second, first.0) * side(second, first.1) < 0.0
    };
    (0..n).find_map(|i| (i + 1..n).find(|&j| cross(i, j)).map(|j| (i, j)))
}
