//! Accuracy against time: every rung of every model ladder on the same draws.
//!
//! Each study fills [`Row`]s; [`Row`] is one line of the JSON, CSV and HTML reports. Nothing here
//! enters a run; this crate reads the clock (to measure) and writes reports.

pub mod scenes;

use serde::Serialize;

/// One rung of one ladder on one scene. `None` (null) where a measure does not apply.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// Ladder: "filters", "gates", "association", "sensors", "effects", ...
    pub group: String,
    /// Scene: "landing", "landing_arc", "takeoff", ...
    pub scene: String,
    /// Rung: "abg", "ca3", "imm3", ...
    pub rung: String,
    /// Reduction of the position mean square error against the raw plots, %.
    pub mse_reduction_pct: Option<f64>,
    /// Root mean square position error, m.
    pub rmse_m: Option<f64>,
    /// 95 % position error, m.
    pub p95_m: Option<f64>,
    /// Mean normalised estimation error squared of the position (2 is consistent).
    pub nees: Option<f64>,
    /// Share of lost tracks, %.
    pub lost_pct: Option<f64>,
    /// Share of swapped tracks, %.
    pub swaps_pct: Option<f64>,
    /// Mean GOSPA, m.
    pub gospa: Option<f64>,
    /// Median time per update, ns.
    pub ns_per_update: Option<f64>,
    /// 99th percentile over blocks of 1 000 updates, ns.
    pub ns_p99: Option<f64>,
    /// Failures with their reasons; empty if none.
    pub failed: Vec<String>,
    /// Error against the most exact rung, in the ladder's own unit, for ladders that are not filters.
    pub error: Option<f64>,
    /// Unit of `error`.
    pub error_unit: Option<String>,
}
