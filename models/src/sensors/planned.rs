//! Sensors whose effects are planned by [`crate::effects::positioning`].

use crate::effects::Tolerance;
use crate::effects::positioning::{Planning, PositioningLevels};
use crate::sensors::Sensor;

/// A sensor whose effects are planned so.
pub trait Planned: Sensor {
    /// Its planning: the plan in force and the counters.
    fn planning(&self) -> &Planning;

    /// Its planning, to choose how the effects are.
    fn planning_mut(&mut self) -> &mut Planning;

    /// The same sensor planned for a tolerance and a run of `horizon_s`.
    #[must_use]
    fn tolerating(mut self, tolerance: Tolerance, horizon_s: f64) -> Self
    where
        Self: Sized,
    {
        self.planning_mut().tolerate(tolerance, horizon_s);
        self
    }

    /// The same sensor with the level of every effect given and nothing planned.
    #[must_use]
    fn at_levels(mut self, levels: PositioningLevels) -> Self
    where
        Self: Sized,
    {
        self.planning_mut().fix(levels);
        self
    }
}

#[cfg(test)]
mod tests;
