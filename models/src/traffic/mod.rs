//! Traffic that behaves: movers that share one ground network.
//!
//! ```text
//! airport files ─► network (repairs) ─► pieces ─┐
//!                       schedule ─► movers ─────┴─► Core: plan, tokens, steps ─► states of a frame
//! ```

pub mod ahead;
mod arcs;
pub mod check;
pub mod core;
mod delivered;
pub mod exact;
pub mod measured;
pub mod network;
pub mod ordered;
pub mod outline;
pub mod path;
pub mod pieces;
pub mod profile;
pub mod runway_roll;
pub mod tractrix;
pub mod way;
pub mod ways;
pub mod windows;
