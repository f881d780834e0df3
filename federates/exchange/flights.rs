//! The flight data list as it travels: a line as a message, and the list that a receiver makes of them.

use crate::runtime::messages::FlightNotice;
use models::flight_list::{FlightEntry, FlightList, MovementKind, WakeCategory};
use models::frames::Vector2;
use models::plot::Callsign;
use models::time::SimTime;

/// Letter of a wake category.
#[must_use]
pub fn wake_letter(wake: Option<WakeCategory>) -> &'static str {
    match wake {
        Some(WakeCategory::Light) => "L",
        Some(WakeCategory::Medium) => "M",
        Some(WakeCategory::Heavy) => "H",
        Some(WakeCategory::Super) => "J",
        None => "",
    }
}

/// Word of a movement.
#[must_use]
pub fn movement_word(movement: MovementKind) -> &'static str {
    match movement {
        MovementKind::Arrival => "arrival",
        MovementKind::Departure => "departure",
        MovementKind::Vehicle => "vehicle",
    }
}

/// A line of the flight list as a message.
#[must_use]
pub fn flight_notice(entry: &FlightEntry) -> FlightNotice {
    FlightNotice {
        callsign: entry.callsign.as_str().to_owned(),
        address: entry.address,
        type_designator: entry.type_designator.clone(),
        wake: wake_letter(entry.wake).to_owned(),
        movement: movement_word(entry.movement).to_owned(),
        runway: entry.runway.clone(),
        stand: entry.stand.clone(),
        stand_m: entry.stand_m.map(|p| [p.x, p.y]),
        eta_ctd_ns: entry.eta_ctd.0,
        off_block_ns: entry.off_block.map(|t| t.0),
        routing: entry.routing.clone(),
    }
}

/// The flight list that a notice carries; runways come from the scene of the receiver.
#[must_use]
pub fn flight_list(
    notices: &[FlightNotice],
    runways: Vec<(String, [Vector2<f64>; 2])>,
) -> FlightList {
    let mut entries: Vec<FlightEntry> = notices
        .iter()
        .map(|n| FlightEntry {
            callsign: Callsign::new(&n.callsign),
            address: n.address,
            type_designator: n.type_designator.clone(),
            wake: match n.wake.as_str() {
                "L" => Some(WakeCategory::Light),
                "M" => Some(WakeCategory::Medium),
                "H" => Some(WakeCategory::Heavy),
                "J" => Some(WakeCategory::Super),
                _ => None,
            },
            movement: match n.movement.as_str() {
                "arrival" => MovementKind::Arrival,
                "departure" => MovementKind::Departure,
                _ => MovementKind::Vehicle,
            },
            runway: n.runway.clone(),
            stand: n.stand.clone(),
            stand_m: n.stand_m.map(|p| Vector2::new(p[0], p[1])),
            eta_ctd: SimTime(n.eta_ctd_ns),
            off_block: n.off_block_ns.map(SimTime),
            routing: n.routing.clone(),
        })
        .collect();
    entries.sort_by_key(|e| e.callsign);
    FlightList { entries, runways }
}
