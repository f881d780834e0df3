//! Scoring: how good a set of tracks is, held against the truth.
//!
//! Pure functions over recorded or simulated truth and tracks; estimation never calls them.

pub mod sets;

pub use sets::{Gospa, gospa, ospa};
