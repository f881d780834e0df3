//! Fusion: plots of all sensors of one scan in, system tracks out.
//!
//! One update cycle ([`Tracker::scan`], written down in `tracker`) runs the stages of `stages` in their order: batches of one
//! sensor, corrected ─► identified ─► gated ─► assigned ─► updated, each at the plot's own time ─► manoeuvres ─► initiated;
//! then life ─► labels ─► published: a predicted copy of each track. Parts of it can be replaced ([`own`]).
//!
//! Nothing depends on the order in which plots arrived, and nothing here knows the truth.

mod budget;
mod buffers;
pub mod config;
pub mod consider;
mod doubt;
pub mod extent;
mod filter;
mod identity;
mod lag;
pub mod near_side;
mod numbers;
pub mod offline;
mod on_lanes;
pub mod own;
mod places;
pub mod reference;
pub mod registration;
mod rest;
mod resting;
mod ring;
pub mod shadow;
mod size;
mod stages;
mod state;
mod track_file;
mod tracker;
mod updates;
mod way;
mod weights;

pub use config::TrackingConfig;
pub use registration::SiteBias;
pub use shadow::{Shadow, Shadows};
pub use state::{Outcome, Statistics, Tracker};

#[cfg(test)]
mod tests;
