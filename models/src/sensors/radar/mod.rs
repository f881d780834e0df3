//! What a radar is made of: antenna, echo, propagation, detection, cells; the kind itself is [`super::asde`].

pub mod antenna;
pub mod aspect;
pub mod costs;
pub mod detection;
pub mod effects;
pub mod equation;
pub mod extended;
pub mod geometry;
pub mod ghost;
pub mod levels;
pub(crate) mod parameters;
pub mod propagation;
pub mod radial;
#[cfg(test)]
pub(crate) mod sample_shapes;
pub mod shadow;
pub mod shape;
pub mod span;
pub mod video;
