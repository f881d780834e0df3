//! The effect plan of a surface movement radar: which effects are simulated for which target.
//!
//! Read in this order: `boxes` (where a target is), `class` (what it is), `bounds` and `reflection` (what
//! leaving an effect out changes there; `disc` and `coefficient` enclose the surface), `outcome` (what that does to plots), `planned` (the choice),
//! `planner` (boxes met since the weather notice), `rows` (the plan for people).

pub mod bounds;
pub mod boxes;
pub mod class;
mod coefficient;
pub mod disc;
mod fault;
pub mod outcome;
pub mod planned;
pub mod planner;
pub mod reflection;
mod rows;

pub use boxes::Key;
pub use fault::Fault;
pub use planned::{BoxEffect, BoxPlan, Kind};
pub use planner::{Fitted, PlannedBox, Planner};
pub(super) use rows::rows;

#[cfg(test)]
mod tests;
