//! The A-SMGCS functions of an airport: surveillance, control (alerts), guidance, planning, and the people.
//!
//! ```text
//! tracks ─► situation ─┐
//! clearances (board) ──┼─► runway, clearance, conformance alerts ─► safety_net: raised, changed, ended
//! stop bars, areas ────┘
//! ```
//!
//! Nothing here knows truth: a [`situation::Target`] is a track. What has to be scored gets exact
//! positions in the same form.

pub mod actors;
pub mod advice;
pub mod alert;
mod cells;
pub mod clearance;
mod clearance_alerts;
mod conformance;
pub mod departure_sequence;
pub mod departures;
pub mod layout;
pub mod lights;
pub mod parameters;
pub mod pre_departure;
mod runway_alerts;
pub mod runway_choice;
pub mod safety_net;
pub mod scoring;
pub mod situation;
pub mod widths;
