//! What federates know of each other: the forms in which truth, weather, flights, outsiders and an operator's orders
//! travel. No federate imports another one; each reads and writes these.

pub mod asterix_file;
pub mod control_records;
pub mod dis_types;
pub mod driven;
pub mod entity_state;
pub mod flights;
pub mod handover;
pub mod operator;
pub mod repeated;
pub mod seats;
pub mod stamp;
pub mod stands;
pub mod weather_notice;
pub mod weather_pdu;

/// Begin of the name of a measure of joint association, which the last line gathers.
pub const ASSOCIATION: &str = "association_";

/// Begin of the name of a count of what the tracker did instead of its plain work, or refused; the last line gathers these.
pub const TRACKER: &str = "tracker_";
