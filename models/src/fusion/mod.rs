//! Fusion: plots of all sensors of one scan in, system tracks out.
//!
//! One update cycle ([`Tracker::scan`]): plots by (time, sensor, sequence) ─► batches of one sensor
//! (`tracker`) ─► gates and association (`associate`, [`crate::association`]) ─► each plot updates its track at the
//! plot's own time (`track_file`) ─► starts ─► confirm, coast, delete (`life`) ─► labels (`labels`)
//! ─► a predicted copy of each track is published.
//!
//! Nothing depends on the order in which plots arrived, and nothing here knows the truth.

mod associate;
mod budget;
pub mod config;
pub mod consider;
mod filter;
mod gate;
mod identity;
mod labels;
mod lag;
mod life;
pub mod near_side;
mod numbers;
pub mod offline;
pub mod registration;
mod ring;
pub mod shadow;
mod spread;
mod track_file;
mod tracker;

pub use config::TrackingConfig;
pub use registration::SiteBias;
pub use shadow::{Shadow, Shadows};
pub use tracker::{Outcome, Statistics, Tracker};

#[cfg(test)]
mod tests;
