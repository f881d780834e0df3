//! Scoring: how good a set of tracks is, held against the truth.
//!
//! Pure functions over recorded or simulated truth and tracks; estimation never calls them.
//! [`recording`] is what was true and what was reported, [`areas`] the parts of an airport, [`run`]
//! holds the one against the other, [`requirements`] judges what was found, [`sets`] are distances
//! between sets.

pub mod areas;
pub mod recording;
pub mod requirements;
pub mod robust;
pub mod run;
pub mod sets;

pub use sets::{Gospa, gospa, ospa};
