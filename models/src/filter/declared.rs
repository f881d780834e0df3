//! What the house knows of a rung of the filter ladder; each declares itself beside its filter.

use super::modes::Modes;
use super::{Estimator, FilterConfig, UpdateError};
use crate::plot::Plot;

/// A rung. Scene reader, reports, page, budget, laws of all rungs and studies read this.
#[derive(Debug)]
pub struct Declared {
    /// Its word in scenes, flags and reports.
    pub word: &'static str,
    /// What it does, for people.
    pub about: &'static str,
    /// Evaluations of one update: the times of all rungs measured in one run (`seeds accuracy --only filters`), with
    /// `imm3` as 27.
    pub cost: u64,
    /// The modes of motion that it switches between by default.
    pub modes: fn() -> Modes,
    /// Histories of modes that go on when slow errors of a sensor become states: 0 where modes are mixed, `None` where it
    /// knows one motion only.
    pub histories: Option<usize>,
    /// A new track's filter from its first plot.
    pub start: fn(&FilterConfig, &Plot) -> Result<Estimator, UpdateError>,
}
