//! Ground truth: movements as smooth functions of time, from recordings or along routes.
//!
//! ```text
//! recorded positions ─► reject (what cannot be true) ─────────────┐
//!                                                                 ├─► path + progress ─► Trajectory
//! route over the ground network ─► rounded corners ───────────────┘
//! ```
//!
//! A [`Trajectory`] is a smooth path over the ground and a smooth progress along it. Heading is the
//! direction of the path, so it is sound at standstill and in turns, and everything a federate asks
//! for is an exact derivative of two splines.

mod band;
mod dubins;
mod fit;
pub mod limits;
pub mod recorded;
pub mod route;
pub mod spline;
pub mod trajectory;

pub use limits::{Kinematics, Limits};
pub use trajectory::{Leg, Trajectory, TruthState};
