//! By which categories a scene separates its aircraft, and which a type is in.

use crate::control::Separation;
use crate::types::TypeRow;
use models::flight_list::WakeCategory;
use models::wake::{Recat, Wake};

/// Its wake, and the category by which a scene separates it.
pub(crate) fn wake_of(row: &TypeRow, by: Separation) -> Wake {
    let icao = row.wake.unwrap_or(WakeCategory::Medium);
    let known = || recat_of(&row.class.designator).unwrap_or_else(|| Recat::like(icao));
    Wake { icao, recat: (by == Separation::RecatEu).then(known) }
}

/// European wake category of a type (RECAT-EU 1.1, from memory).
fn recat_of(designator: &str) -> Option<Recat> {
    Some(match designator {
        "A388" => Recat::A,
        "A332" | "A333" | "A359" | "B744" | "B77W" | "B788" | "B789" => Recat::B,
        "B763" => Recat::C,
        "A319" | "A20N" | "A320" | "A321" | "B737" | "B738" | "B38M" | "B752" => Recat::D,
        "E190" | "CRJ9" | "E145" | "AT75" | "DH8D" => Recat::E,
        "C550" | "C172" => Recat::F,
        _ => return None,
    })
}
