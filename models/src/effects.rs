//! The effect plan: which physical effects a scene calls for, and at which level each is simulated.
//!
//! An effect stands beside its physics: what calls for it, its levels, and what each may lose as a
//! vector ([`Loss`]). Here is what all of them share: the tolerance, the outcome of a sum of losses
//! ([`outcome`]) and the choice of the cheapest set that is tolerated ([`choice`]). A loss of NaN or
//! infinity means "cannot tell" and is always simulated.

pub mod choice;
pub mod outcome;
pub mod positioning;

use crate::plot::SensorId;

/// What a user tolerates against everything simulated exactly, on the same draws, for every target
/// while it is in one box of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Rms distance of plots that both runs have, m.
    pub position_m: f64,
    /// Share of these that may be farther apart than five times that.
    pub tail: f64,
    /// Share of scans in which only one run has the plot.
    pub detection: f64,
    /// Expected number, per scan and radar, of false plots and ghosts that only one run has.
    pub false_plots: f64,
    /// Rms shift of the published position of a steady filter, m, where asked for.
    pub track_m: Option<f64>,
    /// White jerk of that filter, m²/s⁵.
    pub jerk_m2_s5: f64,
    /// Time of a scan and radar by the table of costs, µs: then the tolerances are the unit of a factor
    /// and no limit.
    pub time_budget_us: Option<f64>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            position_m: 0.1,
            tail: 0.001,
            detection: 0.01,
            false_plots: 0.01,
            track_m: None,
            jerk_m2_s5: 0.3,
            time_budget_us: None,
        }
    }
}

impl Tolerance {
    /// Nothing may be lost: every effect at its exact level.
    pub const EXACT: Self = Self {
        position_m: 0.0,
        tail: 0.0,
        detection: 0.0,
        false_plots: 0.0,
        track_m: None,
        jerk_m2_s5: 0.3,
        time_budget_us: None,
    };

    /// All tolerances times `factor`: to ask what a stricter or looser one would change.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            position_m: self.position_m * factor,
            tail: (self.tail * factor).min(1.0),
            detection: (self.detection * factor).min(1.0),
            false_plots: self.false_plots * factor,
            track_m: self.track_m.map(|metres| metres * factor),
            ..self
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

/// What a level may change against the exact level, at most. No part is negative; NaN or infinity means
/// that it cannot be told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// By how much it may show the signal to clutter and noise ratio too high, dB.
    pub raises_db: f64,
    /// By how much it may show it too low, dB.
    pub lowers_db: f64,
    /// A systematic move of a plot, the same from scan to scan, m.
    pub fixed_m: f64,
    /// Mean square of a move by draws of its own, m².
    pub own_m2: f64,
    /// Change of the azimuth's deviation by the coupling of the reflection, rad.
    pub coupled_rad: f64,
    /// Probability, per scan, that a plot is in one run only.
    pub odds: f64,
    /// Expected number of false plots, per scan.
    pub false_plots: f64,
}

impl Loss {
    /// Nothing.
    pub const NONE: Self = Self {
        raises_db: 0.0,
        lowers_db: 0.0,
        fixed_m: 0.0,
        own_m2: 0.0,
        coupled_rad: 0.0,
        odds: 0.0,
        false_plots: 0.0,
    };

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

    /// A plot moved by at most this.
    #[must_use]
    pub fn moves(metres: f64) -> Self {
        Self { fixed_m: metres, ..Self::NONE }
    }

    /// A plot lost or added with at most this probability.
    #[must_use]
    pub fn odds(probability: f64) -> Self {
        Self { odds: probability, ..Self::NONE }
    }

    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            raises_db: self.raises_db + other.raises_db,
            lowers_db: self.lowers_db + other.lowers_db,
            fixed_m: self.fixed_m + other.fixed_m,
            own_m2: self.own_m2 + other.own_m2,
            coupled_rad: self.coupled_rad + other.coupled_rad,
            odds: self.odds + other.odds,
            false_plots: self.false_plots + other.false_plots,
        }
    }

    /// The worse of each part; not-a-number is the worst.
    #[must_use]
    pub fn worse(&self, other: &Self) -> Self {
        let worse = |a: f64, b: f64| if b > a || b.is_nan() { b } else { a };
        Self {
            raises_db: worse(self.raises_db, other.raises_db),
            lowers_db: worse(self.lowers_db, other.lowers_db),
            fixed_m: worse(self.fixed_m, other.fixed_m),
            own_m2: worse(self.own_m2, other.own_m2),
            coupled_rad: worse(self.coupled_rad, other.coupled_rad),
            odds: worse(self.odds, other.odds),
            false_plots: worse(self.false_plots, other.false_plots),
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

    /// Whether every part can be told.
    #[must_use]
    pub fn is_known(&self) -> bool {
        // A sum of parts that are not negative is finite only if all of them are.
        (self.raises_db
            + self.lowers_db
            + self.fixed_m
            + self.own_m2
            + self.coupled_rad
            + self.odds
            + self.false_plots)
            .is_finite()
    }

    /// The bound in the unit in which it says most, for people.
    #[must_use]
    pub fn shown(&self) -> (f64, &'static str) {
        if !self.is_known() {
            return (f64::INFINITY, "");
        }
        if self.fixed_m > 0.0 {
            (self.fixed_m, "m")
        } else if self.odds > 0.0 {
            (self.odds, "probability")
        } else {
            (self.db(), "dB")
        }
    }
}

impl choice::Sum for Loss {
    const NONE: Self = Self::NONE;

    fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    fn plus(&self, other: &Self) -> Self {
        Self::plus(*self, *other)
    }
}

/// One level of an effect with what it may lose and what it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// The level.
    pub level: Level,
    /// Against the exact level.
    pub loss: Loss,
    /// Time per target and scan, ns, as measured.
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

#[cfg(test)]
mod tests;
