//! What every federate stands on: life cycle, time, messages, sockets, command line.
//!
//! Only here: sockets, zenoh, bincode and the wall clock. What any one federate does is not known here.

pub mod access;
pub mod access_list;
pub mod build;
pub mod bus;
pub mod certs;
pub mod cli;
pub mod clock;
pub mod clock_watch;
pub mod codec;
pub mod conductor;
pub(crate) mod connections;
pub mod data_plane;
pub mod digest;
pub mod dis_socket;
pub mod federate;
pub mod follower;
pub mod frame_time;
pub mod grace;
pub mod hearing;
pub mod journal;
pub mod lead;
pub mod life_cycle;
pub mod local_bus;
pub mod member;
pub mod member_driver;
pub mod member_process;
pub mod messages;
pub mod overflow;
pub mod process;
pub mod run_log;
pub mod senders;
pub mod simulation;
pub mod spectator;
pub mod stream;
pub mod succession;
pub mod threads;
pub mod views;
pub mod zenoh_bus;

#[cfg(test)]
mod core_tests;
#[cfg(test)]
mod intruder_tests;
#[cfg(test)]
mod return_tests;
#[cfg(test)]
mod simulated_network_tests;
#[cfg(test)]
mod spectator_tests;
