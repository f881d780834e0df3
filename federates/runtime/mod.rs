//! What every federate stands on: life cycle, time, messages, sockets, command line.
//!
//! Only here: sockets, zenoh, bincode and the wall clock. What any one federate does is not known here.

pub mod life_cycle;
pub mod messages;

pub mod bus;
pub mod codec;
pub mod local_bus;
pub mod zenoh_bus;

pub mod clock;
pub mod conductor;
pub mod data_plane;
pub mod digest;
pub mod federate;
pub mod member;
pub mod member_driver;
pub mod process;
