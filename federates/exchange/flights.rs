//! The flight data list as it travels: a line as a message, and the list that a receiver makes of them.

use crate::runtime::messages::FlightNotice;
use models::flight_list::{FlightEntry, FlightList};
use models::frames::Point2;
use models::plot::Callsign;
use models::time::SimTime;

/// A line of the flight list as a message.
#[must_use]
pub fn flight_notice(entry: &FlightEntry) -> FlightNotice {
    FlightNotice {
        callsign: entry.callsign.as_str().to_owned(),
        address: entry.address,
        type_designator: entry.type_designator.clone(),
        wake: entry.wake,
        movement: entry.movement,
        runway: entry.runway.clone(),
        stand: entry.stand.clone(),
        stand_m: entry.stand_m,
        eta_ctd_ns: entry.eta_ctd.0,
        off_block_ns: entry.off_block.map(|t| t.0),
        routing: entry.routing.clone(),
    }
}

/// The flight list that a notice carries; runways come from the scene of the receiver.
#[must_use]
pub fn flight_list(
    notices: &[FlightNotice],
    runways: Vec<(String, [Point2<f64>; 2])>,
) -> FlightList {
    let mut entries: Vec<FlightEntry> = notices
        .iter()
        .map(|n| FlightEntry {
            callsign: Callsign::new(&n.callsign),
            address: n.address,
            type_designator: n.type_designator.clone(),
            wake: n.wake,
            movement: n.movement,
            runway: n.runway.clone(),
            stand: n.stand.clone(),
            stand_m: n.stand_m,
            eta_ctd: SimTime(n.eta_ctd_ns),
            off_block: n.off_block_ns.map(SimTime),
            routing: n.routing.clone(),
        })
        .collect();
    entries.sort_by_key(|e| e.callsign);
    FlightList { entries, runways }
}
