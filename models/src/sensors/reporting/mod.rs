//! What sensors share whose targets report their own position: who is equipped, outages, errors that last, satellites.

pub mod bounds;
pub mod constellation;
pub mod cooperative;
pub mod gauss_markov;
pub mod ranging;
pub mod satellite_bounds;
pub mod service;
pub mod statistical;
