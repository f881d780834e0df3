//! Accuracy against time: every rung of every model ladder on the same draws.
//!
//! [`run`] measures one or all groups ([`GROUPS`]) and gives a [`Report`] as a page (HTML), a table (CSV)
//! and one line of JSON. Nothing here enters a run of the federation; this crate reads the clock, to
//! measure. A new ladder is one function that fills [`Row`]s, and one line in [`GROUPS`].

pub mod advice;
mod arithmetic;
pub mod association;
mod bounds;
pub mod chain;
mod chart;
pub mod clearing;
mod clock;
pub mod control;
mod control_found;
mod control_picture;
pub mod crowds;
mod dead_reckoning;
pub mod effects;
mod effects_common;
mod effects_positioning;
pub mod effects_proof;
pub mod expected;
pub mod figures;
pub mod filters;
pub mod gates;
mod gnss;
pub mod life;
mod measure;
pub mod metar;
pub mod movers;
pub mod offline;
pub mod overview;
pub mod picture;
pub mod plot;
pub mod profiles;
pub mod radar;
pub mod reference;
pub mod reference_report;
mod report;
pub mod requirements;
pub mod scenes;
pub mod score;
pub mod score_alerts;
pub mod score_files;
pub mod sensor_advice;
pub mod siting;
pub mod siting_candidates;
pub mod siting_picture;
pub mod siting_rating;
#[cfg(test)]
mod tests;
pub mod traffic;
pub mod unseen;
pub mod watched;
pub mod zurich;

use serde::Serialize;

/// One rung of one ladder on one scene. `None` (null) where a measure does not apply.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// Ladder: "filters", "gates", "association", "sensors", "effects", ...
    pub group: String,
    /// Scene: "landing", "landing_arc", "takeoff", ...; with "/level" for another noise level.
    pub scene: String,
    /// Rung: "abg", "ca3", "imm3", ...
    pub rung: String,
    /// What this rung has that the others have not ("one second more", "a map", "all plots"); such rungs
    /// stand outside the Pareto front of the others.
    pub needs: Option<String>,
    /// Reduction of the position mean square error against the raw plots, %.
    pub mse_reduction_pct: Option<f64>,
    /// Standard error of the reduction over the runs, percentage points.
    pub reduction_se_pct: Option<f64>,
    /// Root mean square position error, m.
    pub rmse_m: Option<f64>,
    /// 95 % position error, m.
    pub p95_m: Option<f64>,
    /// Mean normalised estimation error squared of the position (2 is consistent).
    pub nees: Option<f64>,
    /// Share of scans whose mean NEES over the runs lies within its 95 % bounds, %.
    pub nees_in_bounds_pct: Option<f64>,
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
    /// Error against the most exact rung, in the ladder's own unit.
    pub error: Option<f64>,
    /// Unit of `error`.
    pub error_unit: Option<String>,
    /// Whether the requirement on this measure is met (position: 95 % within 7.5 m, EUROCAE ED-116).
    pub required: Option<bool>,
    /// Cost that is not time (network load).
    pub cost: Option<f64>,
    /// Unit of `cost`.
    pub cost_unit: Option<String>,
}

/// A line that no rung with the same knowledge can pass, or the raw plots.
#[derive(Clone, Debug, Serialize)]
pub struct Bound {
    /// Ladder.
    pub group: String,
    /// Scene.
    pub scene: String,
    /// What is assumed.
    pub label: String,
    /// Error, in the unit of the ladder's drawn error.
    pub error: f64,
    /// The same as a reduction of the mean squared error, %.
    pub mse_reduction_pct: Option<f64>,
}

/// A scene in words.
#[derive(Clone, Debug)]
pub struct SceneAbout {
    /// Its name in the rows.
    pub name: String,
    /// One line.
    pub about: String,
}

/// Which error of the rows a ladder draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Draws {
    /// Root mean square position error.
    #[default]
    Position,
    /// GOSPA.
    Gospa,
    /// `Row::error`.
    Other,
}

/// A ladder in words.
#[derive(Clone, Debug, Default)]
pub struct Ladder {
    /// Its name in the rows.
    pub group: String,
    /// Heading.
    pub title: String,
    /// How it was measured, and on what it was tuned.
    pub about: String,
    /// Axis of the drawn error, with unit.
    pub error_label: String,
    /// Which error is drawn.
    pub draws: Draws,
    /// Unit of the drawn error, for sentences; metres if empty.
    pub unit: String,
    /// Axis of the cost where it is not time.
    pub cost_label: Option<String>,
    /// Its scenes, in order.
    pub scenes: Vec<SceneAbout>,
    /// Names of the scenes that nothing was chosen on, where some are and some are not.
    pub held_out: Vec<String>,
}

impl Ladder {
    /// The drawn error of a row.
    #[must_use]
    pub fn error(&self, row: &Row) -> Option<f64> {
        match self.draws {
            Draws::Position => row.rmse_m,
            Draws::Gospa => row.gospa,
            Draws::Other => row.error,
        }
    }

    /// The drawn cost of a row: its time, or what the ladder names.
    #[must_use]
    pub fn cost(&self, row: &Row) -> Option<f64> {
        if self.cost_label.is_some() { row.cost } else { row.ns_per_update }
    }
}

/// What one group measured.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// In words.
    pub ladder: Ladder,
    /// Scene by scene, rung by rung from cheap to exact.
    pub rows: Vec<Row>,
    /// Lines to draw.
    pub bounds: Vec<Bound>,
    /// Pictures of its own (SVG), shown after the charts.
    pub pictures: Vec<String>,
    /// Requirements held against one run of each of these rungs.
    pub verdicts: Vec<(String, Vec<models::score::requirements::Verdict>)>,
    /// Tables of its own.
    pub tables: Vec<Table>,
    /// What it found, in place of the sentence that is made of rungs.
    pub said: Option<String>,
}

/// A table with heads of its own, beside the rows.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// Name of its file, without `.csv`.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Names of the columns, with units.
    pub heads: Vec<String>,
    /// Cells, as many a row as heads; empty where a measure does not apply.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// One line a row, with a head line.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let line = |cells: &Vec<String>| {
            cells.iter().map(|c| report::quoted(c)).collect::<Vec<_>>().join(",") + "\n"
        };
        std::iter::once(&self.heads).chain(&self.rows).map(line).collect()
    }
}

/// What to measure.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Fewer runs and scenes: a minute instead of several.
    pub quick: bool,
    /// Seed of all draws.
    pub seed: u64,
    /// One group only.
    pub only: Option<String>,
    /// Random scenes of the group `effects`, where another number is asked for.
    pub scenes: Option<u64>,
    /// Scenes drawn from the seed that the group `filters` is measured on beside its own, where another number is asked for.
    pub unseen: Option<u32>,
    /// What to recommend rungs for: µs for a target and scan, targets.
    pub budget: Option<(f64, u64)>,
    /// The machine, for the head of the report.
    pub machine: String,
    /// The commit, for the head of the report.
    pub commit: String,
}

/// How far a group is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// The group.
    pub group: &'static str,
    /// What was measured last.
    pub what: String,
    /// Steps done.
    pub done: usize,
    /// Steps in all.
    pub total: usize,
}

/// Measures one ladder.
pub type Study = fn(&Options, &mut dyn FnMut(Progress)) -> Outcome;

/// The ladders by name, in the order of the report.
pub const GROUPS: &[(&str, Study)] = &[
    ("filters", filters::run),
    ("gates", gates::run),
    ("association", association::run),
    ("profiles", profiles::run),
    ("sensors", radar::run),
    ("positioning", gnss::run),
    ("effects", effects::run),
    ("dead_reckoning", dead_reckoning::thresholds),
    ("time_step", dead_reckoning::steps),
    ("polar", arithmetic::polar),
    ("precision", arithmetic::precision),
    ("figures", figures::study),
    ("traffic", traffic::run),
    ("control", control::run),
];

/// A refused study.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// No such group.
    #[error("no group \"{asked}\"; there are: {known}")]
    UnknownGroup {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
}

/// Everything that was measured.
#[derive(Clone, Debug)]
pub struct Report {
    /// The machine.
    pub machine: String,
    /// The commit.
    pub commit: String,
    /// Seed of the draws.
    pub seed: u64,
    /// Fewer runs and scenes.
    pub quick: bool,
    /// What to recommend rungs for, where it was asked.
    pub budget: Option<(f64, u64)>,
    /// Group by group.
    pub outcomes: Vec<Outcome>,
}

/// Measures the groups that `options` asks for; `progress` is called after every step.
///
/// # Errors
/// If there is no group of the name asked for.
pub fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Result<Report, StudyError> {
    let asked = |name: &str| options.only.as_deref().is_none_or(|only| only == name);
    let outcomes: Vec<Outcome> = GROUPS
        .iter()
        .filter(|(name, _)| asked(name))
        .map(|(_, study)| study(options, progress))
        .collect();
    if outcomes.is_empty() {
        let known: Vec<&str> = GROUPS.iter().map(|(name, _)| *name).collect();
        return Err(StudyError::UnknownGroup {
            asked: options.only.clone().unwrap_or_default(),
            known: known.join(", "),
        });
    }
    let Options { machine, commit, seed, quick, budget, .. } = options.clone();
    Ok(Report { machine, commit, seed, quick, budget, outcomes })
}

impl Report {
    /// All rows.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.outcomes.iter().flat_map(|o| &o.rows)
    }

    /// All tables of their own.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.outcomes.iter().flat_map(|o| &o.tables)
    }
}
