//! Which plot belongs to which track: gates, candidates, and the ladder of association methods.
//!
//! ```text
//! plots of one sensor and interval ─► grid (candidates) ─► gate (chi-square) ─► cluster
//!      ─► nearest | assignment, sparse (global nearest) | jpda (exact) | lbp (large clusters, with a certificate) ─► pairs
//!      ─► kinematic_gate, for the plots that the first gate refused
//! ```
//!
//! Nothing here knows a filter or a track's life; the inputs are innovations with their
//! covariances, the outputs are indices and weights.

pub mod amplitude;
pub mod assignment;
pub mod certificate;
pub mod cluster;
pub mod existence;
pub mod gate;
pub mod grid;
pub mod jpda;
pub mod kinematic_gate;
pub mod lbp;
pub mod nearest;
pub mod one_to_one;
pub mod sparse;
