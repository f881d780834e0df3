//! The five federates of SEEDS and the runtime that they share.
//!
//! Data flows in the order of the modules: the traffic generator makes truth, the external world
//! weather and flight data, the SMDFM turns both into plots and system tracks, the viewer-logger
//! shows and keeps everything, the administration station runs the whole.

pub mod traffic_generator;

pub mod external_world;

pub mod smdfm;

pub mod control;

pub mod visitors;

pub mod viewer_logger;

pub mod admin_station;

pub mod gateway;

pub mod exchange;
pub mod federation;
pub mod runtime;

pub mod seeds;
mod take_over;
