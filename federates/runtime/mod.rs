//! What every federate stands on: life cycle, time, messages, sockets, command line.
//!
//! Only here: sockets, zenoh, bincode and the wall clock. What any one federate does is not known here.

pub mod life_cycle;
pub mod messages;
