//! Vehicles of a demand by rates: how many of which type, and where each begins.

use super::flights::flight_of;
use crate::document::Section;
use crate::entity::{Entity, PARTITIONS};
use crate::error::{Problem, ScenarioError};
use crate::keys::MOST_VEHICLES;
use crate::types::TypeTable;
use models::draw::{DrawKey, Purpose, uniform};
use models::flight_list::{FlightEntry, MovementKind};
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::core::{Direction, Flight};
use models::traffic::network::Network;

/// Nobody drives faster on taxiways: 50 km/h (traffic.md 2.1).
const MOST_MPS: f64 = 50.0 / 3.6;
/// The first address of a vehicle, less one.
const ADDRESSES: u32 = 0x52_0000;

/// Types of the vehicles of a section, each as often as it is wanted.
pub(super) fn wanted(section: &Section, types: &TypeTable) -> Result<Vec<String>, ScenarioError> {
    let Some(table) = section.any_section("vehicles")? else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for designator in table.keys() {
        let count = table.integer(designator, 0, MOST_VEHICLES)?.unwrap_or(0);
        if types.get(designator).is_none_or(|t| t.class.aircraft) {
            let vehicle = |d: &&str| types.get(d).is_some_and(|t| !t.class.aircraft);
            let allowed = types.designators().filter(vehicle).collect::<Vec<_>>().join(", ");
            let found = designator.into();
            return Err(table.refuse(designator, Problem::NotAllowed { found, allowed }));
        }
        all.extend((0..count).map(|_| designator.to_owned()));
    }
    Ok(all)
}

/// A vehicle of a scene: what the core makes of it, its entity and its line of the flight list.
pub(super) type Vehicle = (Flight, Entity, FlightEntry);

/// Vehicles on stands where no flight is expected, as long as there are such: the first entity has number `first` (from 0).
pub(super) fn placed(
    designators: &[String],
    (network, flights): (&Network, &[Flight]),
    types: &TypeTable,
    (site, seed, first): (u16, u64, usize),
    left_out: &mut Vec<String>,
) -> Vec<Vehicle> {
    let is_used = |s: &usize| network.stands[*s].node.is_some_and(|n| network.nodes[n].used);
    let expected = |s: &usize| flights.iter().any(|f| f.stand == *s);
    let mut free: Vec<usize> =
        (0..network.stands.len()).filter(|s| is_used(s) && !expected(s)).collect();
    let mut all = Vec::new();
    for (n, designator) in designators.iter().enumerate() {
        let Some(row) = types.get(designator) else { continue };
        if free.is_empty() {
            break;
        }
        let key = DrawKey { run_seed: seed, sensor: 3, entity: n as u64, scan: 0 };
        let place = uniform(&mut key.rng(Purpose::Mover));
        let stand = free.remove((place * free.len() as f64) as usize % free.len());
        let index = first + all.len();
        let callsign = Callsign::new(&format!("GV{:04}", n + 1));
        let address = Some(ADDRESSES + n as u32 + 1);
        let entity = Entity {
            callsign,
            address,
            class: row.class.clone(),
            application: 1 + (index as u16) % PARTITIONS,
            number: 1 + index as u16,
            trajectory: None,
            report: None,
        };
        let entry = FlightEntry {
            callsign,
            address,
            type_designator: designator.clone(),
            wake: None,
            movement: MovementKind::Vehicle,
            runway: String::new(),
            stand: String::new(),
            stand_m: None,
            eta_ctd: SimTime::ZERO,
            off_block: None,
            routing: Vec::new(),
        };
        let flight = flight_of(row);
        let flight = Flight {
            taxi_mps: (flight.taxi_mps.0.min(MOST_MPS), flight.taxi_mps.1),
            callsign: callsign.to_string(),
            direction: Direction::Vehicle,
            stand,
            // They set off one after the other.
            time_s: 20.0 + 15.0 * n as f64,
            wheelbase_m: wheelbase_m(row.class.length_m),
            idle_kg_per_s: 0.0,
            key: entity.key(site),
            ..flight
        };
        all.push((flight, entity, entry));
    }
    if all.len() < designators.len() {
        left_out.push(format!(
            "{} of {} vehicles are left out: no stand is free of flights for them",
            designators.len() - all.len(),
            designators.len()
        ));
    }
    all
}

/// From front to rear axle, m: of cars 0.6, of trucks 0.5 of the length (traffic.md 2.2, assumed).
fn wheelbase_m(length_m: f64) -> f64 {
    if length_m < 6.0 { 0.6 * length_m } else { 0.5 * length_m }
}
