//! The stages of a scan, in the order in which they are run.
//!
//! batches (corrected) ─► identified ─► gated ─► assigned ─► updated ─► manoeuvres ─► initiated, batch by batch; then
//! life ─► labels ─► doubles ─► published. A stage knows the stages that it hands on to, never the pipeline ([`super::tracker`]).

pub(super) mod assigned;
pub(super) mod batches;
pub(super) mod doubles;
pub(super) mod existence;
pub(super) mod gated;
pub(super) mod identified;
pub(super) mod initiated;
pub(super) mod labels;
pub(super) mod life;
pub(super) mod manoeuvres;
pub(super) mod published;
pub(super) mod updated;
