//! Physics and estimation of SEEDS: pure functions and plain structs, no I/O, no clock, no threads.
//!
//! The modules stand in the order in which data flows:
//!
//! ```text
//! truth ─┐      ┌─ environment (weather)        flight_list
//!        ▼      ▼                                   │
//!      sensors (which effects: effects) ─► plot ─► filter ─► association ─► fusion ─► track ─► score, control
//! ```
//!
//! Everything runs on whole nanoseconds ([`time::SimTime`]), in metres east, north, up at the
//! aerodrome reference point, and on named random draws ([`draw::DrawKey`]): the same inputs give
//! the same bits in every process.

pub mod airport;
pub mod draw;
pub mod frames;
pub mod keys;
pub mod special;
pub mod time;
pub mod words;

pub mod traffic;
pub mod truth;

pub mod environment;

pub mod effects;
pub mod sensors;

pub mod kind;
pub mod plot;

pub mod filter;

pub mod association;

pub mod flight_list;
pub mod fusion;
pub mod track;
pub mod wake;

pub mod score;

pub mod control;
