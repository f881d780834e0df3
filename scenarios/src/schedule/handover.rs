//! `[[traffic]] kind = "handover"`: places for aircraft that other programs give to the traffic that behaves.

use super::{end_named, flight_of, stand_named, wake_of};
use crate::control::Separation;
use crate::document::Section;
use crate::entity::{Entity, PARTITIONS};
use crate::error::{Problem, ScenarioError};
use crate::types::TypeTable;
use models::plot::Callsign;
use models::traffic::core::{Flight, class_of};
use models::traffic::network::Network;
use models::traffic::pieces::Class;

/// Most places of a scene.
const MOST: i64 = 500;
/// Places of a scene that does not say how many.
const USUAL: usize = 20;
/// What a place is taken for before somebody is given.
const LIKE: &str = "A320";

/// What a scene says of it.
pub(crate) struct Places {
    pub(crate) count: usize,
    /// Ways are made for movers of this class, too.
    pub(crate) largest: Option<Class>,
}

/// Reads the section.
pub(crate) fn read(section: &Section, types: &TypeTable) -> Result<Places, ScenarioError> {
    let count = section.integer("count", 1, MOST)?.map_or(USUAL, |n| n as usize);
    let largest = match section.text("type")? {
        None => None,
        Some(designator) => {
            let row = types.get(designator).filter(|row| row.class.aircraft).ok_or_else(|| {
                let all: Vec<&str> = types.designators().collect();
                let allowed = crate::document::one_of(designator, &all);
                section.refuse("type", Problem::NotAllowed { found: designator.into(), allowed })
            })?;
            Some(class_of(flight_of(row).size))
        }
    };
    Ok(Places { count, largest })
}

/// The entity of place `n`, which is `index` among all; `None` without types.
pub(crate) fn entity(index: usize, n: usize, types: &TypeTable) -> Option<Entity> {
    let first = || types.designators().next().and_then(|d| types.get(d));
    let row = types.get(LIKE).or_else(first)?;
    Some(Entity {
        // Nobody who is given is called so.
        callsign: Callsign::new(&format!("PLACE#{}", n + 1)),
        address: None,
        class: row.class.clone(),
        application: 1 + (index as u16) % PARTITIONS,
        number: 1 + index as u16,
        trajectory: None,
        report: None,
    })
}

/// A flight of this type, as it is given; `None`: no such type of aircraft.
#[must_use]
pub fn flight(
    types: &TypeTable,
    wake: Separation,
    designator: &str,
    callsign: &str,
) -> Option<Flight> {
    let row = types.get(designator).filter(|row| row.class.aircraft)?;
    let wake = wake_of(row, wake);
    Some(Flight { callsign: callsign.to_owned(), wake, ..flight_of(row) })
}

/// A runway end by its name.
#[must_use]
pub fn runway(network: &Network, name: &str) -> Option<(usize, usize)> {
    end_named(network, name)
}

/// A stand by its name.
#[must_use]
pub fn stand(network: &Network, name: &str) -> Option<usize> {
    stand_named(network, name)
}
