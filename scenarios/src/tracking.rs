//! `[tracking]` and `[accuracy]`: which rung of each ladder, and what error a user tolerates.

use crate::document::{Section, within};
use crate::error::ScenarioError;

/// `[tracking]` of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracking {
    /// A named choice of all rungs.
    pub profile: Profile,
}

/// A named choice of filter, gates, association and fusion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// As in the paper: three-state filter per axis, nearest neighbour.
    #[default]
    Paper,
    /// Smallest error.
    Accurate,
    /// Most targets.
    Bulk,
}

/// `[accuracy]` of a scene: what may be lost against everything simulated exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Position of a plot, m.
    pub position_m: f64,
    /// Probability of detection.
    pub detection: f64,
    /// Processor time for one scan of the whole sensor and fusion stage, µs, where it is limited.
    pub time_budget_us: Option<f64>,
}

/// Reads `[tracking]`.
pub(crate) fn read(root: &Section) -> Result<Tracking, ScenarioError> {
    let Some(section) = root.section("tracking", &["profile"])? else {
        return Ok(Tracking::default());
    };
    let profiles =
        [("paper", Profile::Paper), ("accurate", Profile::Accurate), ("bulk", Profile::Bulk)];
    Ok(Tracking { profile: section.choice("profile", &profiles)?.unwrap_or_default() })
}

/// Reads `[accuracy]`.
pub(crate) fn read_accuracy(root: &Section) -> Result<Accuracy, ScenarioError> {
    let section = root
        .section("accuracy", &["position_m", "detection", "time_budget_us"])?
        .unwrap_or_else(|| root.empty("accuracy"));
    Ok(Accuracy {
        position_m: section.number_or("position_m", 0.5, within(0.0, 1000.0, "m"))?,
        detection: section.number_or("detection", 0.01, within(0.0, 1.0, ""))?,
        time_budget_us: section.number("time_budget_us", within(1.0, 1e9, "µs"))?,
    })
}
