//! The plan of the sensors that targets carry, of multilateration, loops and fitted figures: bounds
//! from their parameters, the length of the run, and how fast and how far away the equipped targets are.
//!
//! What is rare (outages, failures, lost or late messages) is bounded by the probability that it
//! touches a report; what moves a report is bounded in metres. Draws are keyed by what they are for, so
//! leaving an effect out changes no other draw.

use super::choice::{Candidate, cheapest};
use super::{Ladder, Level, Loss, PlanRow, Rung, Tolerance};
use crate::frames::Vector3;
use crate::plot::SensorId;

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)+) => {
        /// An effect of a sensor other than a radar.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum PositioningEffect { $($(#[$doc])* $variant,)+ }

        impl PositioningEffect {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// Name in plans, reports and explanations.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }
        }
    };
}

effects! {
    /// Constellation and dilution; stations and dilution.
    Geometry = "geometry",
    /// No position: coverage, availability, satellites off, reports that do not come.
    HardFailures = "hard failures",
    /// A position far off: unreliable service, false ranges.
    SoftFailures = "soft failures",
    /// The reference station is out.
    ReferenceOutage = "reference station outage",
    /// Decorrelation with the distance from the reference station and with speed.
    CorrectionDistance = "correction distance",
    /// Age of the correction.
    CorrectionAge = "correction age",
    /// Errors of the reference station's own ranges.
    ReferenceErrors = "reference station errors",
    /// Clock, ephemeris, selective availability, ionosphere, troposphere.
    RangeErrors = "satellite and atmosphere errors",
    /// Multipath of a receiver, or late arrivals.
    Multipath = "multipath",
    /// What of the error lasts from report to report.
    Correlation = "correlated error",
    /// What of the error is new in every report.
    White = "white error",
    /// Messages that are not received, passages that are not detected.
    Reception = "reception",
    /// Delay between measuring and sending.
    Latency = "latency",
    /// Steps of the position format.
    Rounding = "position rounding",
    /// Range and blind sectors of stations.
    StationRange = "station range",
    /// Buildings between stations and targets.
    Sight = "line of sight",
    /// Errors of times of arrival.
    Timing = "timing error",
    /// Delay of a detection.
    Delay = "detection delay",
    /// Uncertainty of a target's edge over a loop.
    Edge = "edge error",
    /// Uncertainty of the distance between two loops.
    Spacing = "loop spacing",
    /// Passages of nobody.
    FalsePassages = "false passages",
    /// Scale error of an odometer.
    Scale = "odometer scale",
    /// Heading error and its growth.
    Heading = "heading error",
    /// Position error at the start and at known places.
    Start = "starting error",
}

impl PositioningEffect {
    /// Whether a sensor remembers what it did: then a report after a time without it differs by what
    /// was left out meanwhile.
    fn remembers(self) -> bool {
        matches!(
            self,
            Self::Multipath | Self::Correlation | Self::Scale | Self::Heading | Self::Start
        )
    }
}

const COUNT: usize = PositioningEffect::ALL.len();

/// A model that is planned: what its bounds read, and what its effects cost. It stands beside its physics.
#[derive(Debug)]
pub struct Model {
    /// Words for people, unique.
    pub name: &'static str,
    /// Whether a bound goes with the speed of targets.
    pub reads_speed: bool,
    /// Whether a bound goes with their distance from the reference.
    pub reads_distance: bool,
    /// Processor time per report that a level adds to a scan in which everything else is left out, ns: the least of many
    /// scans with it less the least of as many without, 1000 targets, a report of each in a scan. What is made once for
    /// all targets (the sky) is shared among them. `cargo bench -p models --bench positioning_costs` measures it again.
    pub costs: &'static [(PositioningEffect, Level, u32)],
}

impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name)
    }
}

impl Model {
    /// Time of one level of an effect per report, ns; 0 for what is skipped.
    #[must_use]
    pub fn cost_ns(&self, effect: PositioningEffect, level: Level) -> f64 {
        let here = |row: &&(PositioningEffect, Level, u32)| (row.0, row.1) == (effect, level);
        self.costs.iter().find(here).map_or(0.0, |row| f64::from(row.2))
    }
}

/// When and on what the costs were measured.
pub const MEASURED: &str = "2026-11-21, one core of a shared x86-64 server, release build";

/// How often each effect was evaluated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PositioningTally([u64; COUNT]);

impl PositioningTally {
    /// Counts one evaluation.
    pub fn count(&mut self, effect: PositioningEffect) {
        self.0[effect as usize] += 1;
    }

    /// Counts several.
    pub fn add(&mut self, effect: PositioningEffect, times: u64) {
        self.0[effect as usize] += times;
    }

    /// Evaluations of one effect.
    #[must_use]
    pub fn of(&self, effect: PositioningEffect) -> u64 {
        self.0[effect as usize]
    }
}

/// Level of every effect of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositioningLevels([Level; COUNT]);

impl PositioningLevels {
    /// The most exact level of everything.
    pub const EXACT: Self = Self([Level::Exact; COUNT]);
    /// Nothing at all.
    pub const NOTHING: Self = Self([Level::Skipped; COUNT]);

    /// These levels with one effect at another level.
    #[must_use]
    pub fn with(mut self, effect: PositioningEffect, level: Level) -> Self {
        self.0[effect as usize] = level;
        self
    }

    /// The level of one effect.
    #[must_use]
    pub fn of(&self, effect: PositioningEffect) -> Level {
        self.0[effect as usize]
    }

    /// Whether an effect is simulated.
    #[must_use]
    pub fn on(&self, effect: PositioningEffect) -> bool {
        self.of(effect) != Level::Skipped
    }
}

/// What the bounds need to know of the equipped targets and of the sky, rounded outwards so that a plan
/// holds while it changes a little.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Whether there are any equipped targets.
    pub any: bool,
    /// Speed of the fastest, m/s.
    pub speed_mps: f64,
    /// Distance of the farthest from the reference station, or the middle of the stations, m.
    pub distance_m: f64,
    /// Largest horizontal dilution met so far.
    pub dilution: f64,
}

impl Conditions {
    /// Nobody is equipped.
    pub const NONE: Self = Self { any: false, speed_mps: 0.0, distance_m: 0.0, dilution: 0.0 };

    fn rounded(self) -> Self {
        let up = |value: f64, margin: f64, step: f64| {
            if value > 0.0 { ((value + margin) / step).ceil() * step } else { 0.0 }
        };
        Self {
            any: self.any,
            speed_mps: up(self.speed_mps, 1.0, 5.0),
            distance_m: up(self.distance_m, 50.0, 500.0),
            dilution: up(self.dilution, 0.0, 0.25),
        }
    }
}

/// What a plan is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositioningScene {
    /// The equipped targets and the sky.
    pub conditions: Conditions,
    /// Length of the run, s; infinite where it is not known.
    pub horizon_s: f64,
    /// What the user tolerates.
    pub tolerance: Tolerance,
}

/// An effect with its levels.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedEffect {
    /// Which one.
    pub effect: PositioningEffect,
    /// Its levels; the last one loses nothing.
    pub ladder: Ladder,
    /// Whether the scene gives its level: then it takes the last rung, and what that loses against a
    /// better model is shown and not counted.
    pub given: bool,
}

/// All effects of one sensor, in the order of its plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladders {
    /// The model, for costs.
    pub model: &'static Model,
    /// Its effects.
    pub effects: Vec<PlannedEffect>,
    /// A step of the position format, m: the least shift may carry a report into the next one.
    pub step_m: f64,
}

/// The plan of one sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct PositioningPlan {
    /// What is simulated, for targets within the conditions.
    pub levels: PositioningLevels,
    /// What was planned for.
    pub conditions: Conditions,
    /// The plan for people.
    pub rows: Vec<PlanRow>,
    /// The effects of the rows.
    pub effects: Vec<PositioningEffect>,
    /// Sum of what the plan may lose.
    pub total: Loss,
}

/// Plans one sensor: every effect at the cheapest level such that, against everything exact and on the
/// same draws, neither the share of reports nor their positions differ by more than the tolerance.
/// `spent` is what effects that were left out earlier have lost for good.
#[must_use]
pub fn plan(
    sensor: SensorId,
    mut ladders: Ladders,
    scene: &PositioningScene,
    spent: Loss,
) -> PositioningPlan {
    let tolerance = &scene.tolerance;
    for planned in &mut ladders.effects {
        for rung in &mut planned.ladder.rungs {
            rung.cost_ns = ladders.model.cost_ns(planned.effect, rung.level);
        }
        if !scene.conditions.any {
            "no equipped target".clone_into(&mut planned.ladder.called_for);
        }
    }
    let free: Vec<Ladder> =
        ladders.effects.iter().filter(|p| !p.given).map(|p| p.ladder.clone()).collect();
    let (chosen, total) = choose(&free, tolerance, |loss| {
        let loss = loss.plus(spent);
        let moved_m = if loss.fixed_m > 0.0 { loss.fixed_m + ladders.step_m } else { 0.0 };
        loss.odds <= tolerance.detection && moved_m <= tolerance.position_m
    });
    let mut chosen = chosen.into_iter();
    let mut levels = PositioningLevels::EXACT;
    let mut rows = Vec::with_capacity(ladders.effects.len());
    for planned in &ladders.effects {
        let ladder = &planned.ladder;
        let last = ladder.rungs.len() - 1;
        let index = if planned.given { last } else { chosen.next().unwrap_or(last) };
        let rung = &ladder.rungs[index];
        // Nobody to simulate anything for.
        let level = if scene.conditions.any { rung.level } else { Level::Skipped };
        levels = levels.with(planned.effect, level);
        let none = !scene.conditions.any;
        let (bound, unit) = if none { (0.0, "m") } else { ladder.rungs[0].loss.shown() };
        rows.push(PlanRow {
            sensor,
            effect: ladder.effect,
            called_for: ladder.called_for.clone(),
            bound,
            unit: if unit == "dB" { "m" } else { unit },
            level,
            loss: if none { Loss::NONE } else { rung.loss },
            cost_ns: if level == Level::Skipped { 0.0 } else { rung.cost_ns },
        });
    }
    PositioningPlan {
        levels,
        conditions: scene.conditions,
        rows,
        effects: ladders.effects.iter().map(|p| p.effect).collect(),
        total: total.plus(spent),
    }
}

/// The cheapest rung of each ladder such that `within` accepts the sum of all losses, and that sum.
fn choose(
    ladders: &[Ladder],
    tolerance: &Tolerance,
    within: impl Fn(&Loss) -> bool,
) -> (Vec<usize>, Loss) {
    let candidate = |r: &Rung| Candidate { cost_ns: r.cost_ns.max(0.0) as u32, loss: r.loss };
    let candidates: Vec<Vec<Candidate<Loss>>> =
        ladders.iter().map(|l| l.rungs.iter().map(candidate).collect()).collect();
    let part = |value: f64, limit: f64| if value == 0.0 { 0.0 } else { value / limit };
    let share = |loss: &Loss| {
        part(loss.fixed_m, tolerance.position_m).max(part(loss.odds, tolerance.detection))
    };
    match cheapest(&candidates, |loss| loss.is_known() && within(loss), share) {
        Some(choice) => (choice.chosen, choice.loss),
        // Not even nothing more is tolerated: what was left out before has used it up.
        None => (ladders.iter().map(|l| l.rungs.len() - 1).collect(), Loss::NONE),
    }
}

/// The planning of one sensor: what it has seen, its plan in force, and its counters.
#[derive(Clone, Debug)]
pub struct Planning {
    sensor: SensorId,
    model: &'static Model,
    tolerance: Tolerance,
    horizon_s: f64,
    fixed: Option<PositioningLevels>,
    seen: Conditions,
    /// Number of targets when they were last looked through.
    surveyed: Option<usize>,
    plan: Option<PositioningPlan>,
    spent: Loss,
    tally: PositioningTally,
    /// Reports of targets that the plan in force did not reckon with, simulated exactly.
    beyond: u64,
}

impl Planning {
    /// Nothing may be lost in a run of unknown length.
    #[must_use]
    pub fn new(sensor: SensorId, model: &'static Model) -> Self {
        Self {
            sensor,
            model,
            tolerance: Tolerance::EXACT,
            horizon_s: f64::INFINITY,
            fixed: None,
            seen: Conditions::NONE,
            surveyed: None,
            plan: None,
            spent: Loss::NONE,
            tally: PositioningTally::default(),
            beyond: 0,
        }
    }

    /// Plans whether there are targets or not: for what does not come from targets.
    #[must_use]
    pub(crate) fn always(mut self) -> Self {
        self.seen.any = true;
        self
    }

    /// Plans for a tolerance and a run of `horizon_s`.
    pub fn tolerate(&mut self, tolerance: Tolerance, horizon_s: f64) {
        (self.tolerance, self.horizon_s) = (tolerance, horizon_s);
        self.plan = None;
    }

    /// Fixes the level of every effect, for comparisons.
    pub fn fix(&mut self, levels: PositioningLevels) {
        self.fixed = Some(levels);
        self.plan = None;
    }

    /// The plan in force; `None` before the first scan.
    #[must_use]
    pub fn plan(&self) -> Option<&PositioningPlan> {
        self.plan.as_ref()
    }

    /// Rows of the plan in force.
    #[must_use]
    pub fn rows(&self) -> &[PlanRow] {
        self.plan.as_ref().map_or(&[], |p| &p.rows)
    }

    /// Evaluations of each effect of the plan, in its order.
    #[must_use]
    pub fn evaluations(&self) -> Vec<(&'static str, u64)> {
        let effects = self.plan.as_ref().map_or(&[][..], |p| &p.effects);
        effects.iter().map(|&e| (e.name(), self.tally.of(e))).collect()
    }

    /// How often each effect was evaluated.
    #[must_use]
    pub fn tally(&self) -> &PositioningTally {
        &self.tally
    }

    /// Reports simulated exactly because their target was faster or farther away than planned for.
    #[must_use]
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    pub(crate) fn count(&mut self, effect: PositioningEffect) {
        self.tally.count(effect);
    }

    pub(crate) fn add(&mut self, effect: PositioningEffect, times: u64) {
        self.tally.add(effect, times);
    }

    /// Whether all targets have to be looked through: while there is nobody, and when some came or went.
    pub(crate) fn wants_survey(&mut self, targets: usize) -> bool {
        let wanted = self.surveyed != Some(targets) || !self.seen.any;
        self.surveyed = Some(targets);
        wanted
    }

    /// Whether there is anybody to simulate for.
    pub(crate) fn anybody(&self) -> bool {
        self.seen.any
    }

    /// An equipped target; `distance_m` from the reference.
    pub(crate) fn see(&mut self, velocity_mps: &Vector3<f64>, distance_m: f64) {
        let speed_mps = velocity_mps.xy().norm();
        self.seen.any = true;
        if self.model.reads_speed && speed_mps > self.seen.speed_mps {
            self.seen.speed_mps = speed_mps;
        }
        if self.model.reads_distance && distance_m > self.seen.distance_m {
            self.seen.distance_m = distance_m;
        }
    }

    /// A geometry that is in use.
    pub(crate) fn see_dilution(&mut self, dilution: f64) {
        if dilution > self.seen.dilution {
            self.seen.dilution = dilution;
        }
    }

    /// Plans again if what was seen calls for it.
    pub(crate) fn prepare(&mut self, ladders: impl FnOnce(&PositioningScene) -> Ladders) {
        let conditions = self.seen.rounded();
        if self.plan.as_ref().is_some_and(|p| p.conditions == conditions) {
            return;
        }
        let scene =
            PositioningScene { conditions, horizon_s: self.horizon_s, tolerance: self.tolerance };
        let ladders = ladders(&scene);
        let mut next = plan(self.sensor, ladders.clone(), &scene, self.spent);
        if let Some(old) = self.plan.take().filter(|old| old.conditions.any) {
            // What is simulated from now on has missed what went before.
            let mut spent = self.spent;
            for (&effect, row) in old.effects.iter().zip(&old.rows) {
                if effect.remembers() && row.is_skipped() && next.levels.on(effect) {
                    spent = spent.plus(row.loss);
                }
            }
            if spent != self.spent {
                self.spent = spent;
                next = plan(self.sensor, ladders, &scene, spent);
            }
        }
        if let Some(levels) = self.fixed {
            next.levels = levels;
            for (&effect, row) in next.effects.iter().zip(&mut next.rows) {
                row.level = levels.of(effect);
            }
        }
        self.plan = Some(next);
    }

    /// Levels for the whole of the sensor.
    pub(crate) fn levels(&self) -> PositioningLevels {
        self.plan.as_ref().map_or(PositioningLevels::EXACT, |p| p.levels)
    }

    /// Levels for the report of one target: the plan's, or exact ones if it did not reckon with it.
    pub(crate) fn levels_for(
        &mut self,
        velocity_mps: &Vector3<f64>,
        distance_m: impl FnOnce() -> f64,
    ) -> PositioningLevels {
        let Some(plan) = &self.plan else { return PositioningLevels::EXACT };
        if self.fixed.is_some() {
            return plan.levels;
        }
        let (speed, distance) = (self.model.reads_speed, self.model.reads_distance);
        let speed_ms2 = if speed { velocity_mps.xy().norm_squared() } else { 0.0 };
        let distance_m = if distance { distance_m() } else { 0.0 };
        let conditions = &plan.conditions;
        if conditions.any
            && speed_ms2 <= conditions.speed_mps * conditions.speed_mps
            && distance_m <= conditions.distance_m
        {
            return plan.levels;
        }
        self.beyond += 1;
        self.see(velocity_mps, distance_m);
        PositioningLevels::EXACT
    }
}

/// A rung whose cost is filled in by [`plan`].
#[must_use]
pub fn rung(level: Level, loss: Loss) -> Rung {
    Rung { level, loss, cost_ns: 0.0 }
}

#[cfg(test)]
mod tests;
