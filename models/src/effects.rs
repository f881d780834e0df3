//! The effect plan: which physical effects a scene calls for, and at which level each is simulated.
//!
//! Every effect has an upper bound of what leaving it out, or taking a cheaper level, can change: in
//! decibels of signal to clutter and noise, in metres of a plot, in probability of detection. The
//! planner takes the cheapest set whose *sum* of bounds keeps the outcome within the tolerance. A
//! bound of NaN or infinity means "cannot tell" and is always simulated.
//!
//! Planning is pure and reads extents and sectors only; pairs of targets are tested in the scan.

pub mod costs;
pub mod positioning;
pub mod radar;

use crate::plot::SensorId;

/// What a user tolerates against everything simulated exactly, on the same draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Position of a plot that both runs have, m.
    pub position_m: f64,
    /// Probability of detection of a target in a scan.
    pub detection: f64,
    /// Where given: effects are also left out while the sum of their decibel bounds stays within this.
    pub sum_db: Option<f64>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { position_m: 0.5, detection: 0.01, sum_db: None }
    }
}

impl Tolerance {
    /// Nothing may be lost: every effect at its exact level.
    pub const EXACT: Self = Self { position_m: 0.0, detection: 0.0, sum_db: None };

    /// All tolerances times `factor`: to ask what a stricter or looser one would change.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            position_m: self.position_m * factor,
            detection: (self.detection * factor).min(1.0),
            sum_db: self.sum_db.map(|db| db * factor),
        }
    }
}

/// How an effect is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Not at all.
    Skipped,
    /// A constant, a line, an envelope.
    Cheap,
    /// The closed form of the textbook.
    Middle,
    /// The most exact form there is at plot level.
    Exact,
}

impl Level {
    /// Word for people and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Skipped => "skipped",
            Self::Cheap => "cheap",
            Self::Middle => "middle",
            Self::Exact => "exact",
        }
    }
}

/// What a level may change against the exact level, at most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// By how much it may show the signal to clutter and noise ratio too high, dB.
    pub raises_db: f64,
    /// By how much it may show it too low, dB.
    pub lowers_db: f64,
    /// Position of a plot, m.
    pub metres: f64,
    /// Probability of detection, or of a false plot.
    pub probability: f64,
}

impl Loss {
    /// Nothing.
    pub const NONE: Self = Self { raises_db: 0.0, lowers_db: 0.0, metres: 0.0, probability: 0.0 };

    /// Too high by at most `db`.
    #[must_use]
    pub fn raises(db: f64) -> Self {
        Self { raises_db: db, ..Self::NONE }
    }

    /// Too low by at most `db`.
    #[must_use]
    pub fn lowers(db: f64) -> Self {
        Self { lowers_db: db, ..Self::NONE }
    }

    /// Off by at most `db` either way.
    #[must_use]
    pub fn either_way(db: f64) -> Self {
        Self { raises_db: db, lowers_db: db, ..Self::NONE }
    }

    /// A plot moved by at most this.
    #[must_use]
    pub fn moves(metres: f64) -> Self {
        Self { metres, ..Self::NONE }
    }

    /// A plot lost or added with at most this probability.
    #[must_use]
    pub fn odds(probability: f64) -> Self {
        Self { probability, ..Self::NONE }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            raises_db: self.raises_db + other.raises_db,
            lowers_db: self.lowers_db + other.lowers_db,
            metres: self.metres + other.metres,
            probability: self.probability + other.probability,
        }
    }

    fn minus(self, other: Self) -> Self {
        Self {
            raises_db: self.raises_db - other.raises_db,
            lowers_db: self.lowers_db - other.lowers_db,
            metres: self.metres - other.metres,
            probability: self.probability - other.probability,
        }
    }

    /// The larger of the two decibel bounds.
    #[must_use]
    pub fn db(&self) -> f64 {
        // Not f64::max: it would hide a NaN.
        if self.raises_db > self.lowers_db || self.raises_db.is_nan() {
            self.raises_db
        } else {
            self.lowers_db
        }
    }

    fn is_known(&self) -> bool {
        [self.raises_db, self.lowers_db, self.metres, self.probability]
            .iter()
            .all(|x| x.is_finite())
    }

    /// The bound in the unit in which it says most, for people.
    #[must_use]
    pub fn shown(&self) -> (f64, &'static str) {
        if !self.is_known() {
            return (f64::INFINITY, "");
        }
        if self.metres > 0.0 {
            (self.metres, "m")
        } else if self.probability > 0.0 {
            (self.probability, "probability")
        } else {
            (self.db(), "dB")
        }
    }
}

/// One level of an effect with what it may lose and what it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// The level.
    pub level: Level,
    /// Against the exact level.
    pub loss: Loss,
    /// Time per target and scan, ns, as measured (see [`costs`]).
    pub cost_ns: f64,
}

/// An effect with its levels, from skipped to exact (which loses nothing).
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// Name of the effect.
    pub effect: &'static str,
    /// What in the scene calls for it.
    pub called_for: String,
    /// The levels.
    pub rungs: Vec<Rung>,
}

/// One line of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRow {
    /// Which sensor.
    pub sensor: SensorId,
    /// Name of the effect.
    pub effect: &'static str,
    /// What in the scene calls for it.
    pub called_for: String,
    /// What skipping it could change at most.
    pub bound: f64,
    /// Unit of `bound`: "dB", "m", "probability", or empty where it cannot be told.
    pub unit: &'static str,
    /// The decision.
    pub level: Level,
    /// What the chosen level may still lose.
    pub loss: Loss,
    /// Time of the chosen level per target and scan, ns.
    pub cost_ns: f64,
}

impl PlanRow {
    /// Whether the effect is left out.
    #[must_use]
    pub fn is_skipped(&self) -> bool {
        self.level == Level::Skipped
    }
}

/// An effect whose level differs between two plans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Which sensor.
    pub sensor: SensorId,
    /// Which effect.
    pub effect: &'static str,
    /// Its level in the first plan.
    pub from: Level,
    /// Its level in the second plan.
    pub to: Level,
}

/// Effects whose level differs between two plans of the same sensors.
#[must_use]
pub fn changes(from: &[PlanRow], to: &[PlanRow]) -> Vec<Change> {
    let pairs = from.iter().filter_map(|a| {
        let b = to.iter().find(|b| b.sensor == a.sensor && b.effect == a.effect)?;
        (a.level != b.level).then_some(Change {
            sensor: a.sensor,
            effect: a.effect,
            from: a.level,
            to: b.level,
        })
    });
    pairs.collect()
}

/// Chooses a rung for each ladder: starting from everything exact, the changes with the smallest
/// bounds first, each kept only while `within` accepts the sum of all losses.
///
/// Returns the index of the rung of each ladder and the sum.
pub fn choose(
    ladders: &[Ladder],
    tolerance: &Tolerance,
    within: impl Fn(&Loss) -> bool,
) -> (Vec<usize>, Loss) {
    let mut chosen: Vec<usize> = ladders.iter().map(|l| l.rungs.len() - 1).collect();
    let mut candidates: Vec<(f64, usize, usize)> = Vec::with_capacity(3 * ladders.len());
    for (l, ladder) in ladders.iter().enumerate() {
        for (r, rung) in ladder.rungs.iter().enumerate().take(ladder.rungs.len() - 1) {
            if rung.loss.is_known() {
                candidates.push((size(&rung.loss, tolerance), l, r));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.2.cmp(&a.2)).then(a.1.cmp(&b.1)));
    let mut total = Loss::NONE;
    for (_, l, r) in candidates {
        let (now, next) = (&ladders[l].rungs[chosen[l]], &ladders[l].rungs[r]);
        if next.cost_ns > now.cost_ns {
            continue;
        }
        let sum = total.minus(now.loss).plus(next.loss);
        if within(&sum) {
            total = sum;
            chosen[l] = r;
        }
    }
    (chosen, total)
}

/// One number to sort losses by: the share of the tolerance that each part takes.
fn size(loss: &Loss, tolerance: &Tolerance) -> f64 {
    let share = |value: f64, limit: f64| if value == 0.0 { 0.0 } else { value / limit };
    share(loss.metres, tolerance.position_m)
        + share(loss.probability, tolerance.detection)
        + loss.raises_db
        + loss.lowers_db
}

#[cfg(test)]
mod tests;
