//! What the import did to a recording, by rule and number, and why it refuses one.

use std::collections::BTreeMap;

/// What was done to records, by rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// No sound time.
    NoTime,
    /// Not later than the record before.
    TimeOrder,
    /// No sound position.
    NoPosition,
    /// More than 60 km from the airport.
    OutOfReach,
    /// Sooner after the one before than anything needs.
    TooOften,
    /// Cannot be reached from its neighbours.
    Jump,
    /// A position repeated although the mover went on.
    NotRenewed,
    /// Far beside the path.
    BesidePath,
    /// Far from where the mover can have been at the time.
    OffTime,
    /// An altitude that cannot be flown.
    AltitudeSpike,
    /// The ground flag contradicts height and speed.
    GroundFlag,
    /// Beside the centreline in a run.
    Centreline,
}

impl Rule {
    /// One line for people.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NoTime => "rejected: time missing or not a number",
            Self::TimeOrder => "rejected: time not after the record before",
            Self::NoPosition => "filled: position missing or not a number",
            Self::OutOfReach => "rejected: position more than 60 km away",
            Self::TooOften => "left out: position less than 0.2 s after the one before",
            Self::Jump => "rejected: position cannot be reached from its neighbours",
            Self::NotRenewed => "rejected: position repeated, not renewed, while moving",
            Self::BesidePath => "rejected: position beside the path by more than 6 sigma + 5 m",
            Self::OffTime => "smoothed away: position along the path off by more than 4 sigma",
            Self::AltitudeSpike => "rejected: altitude cannot be flown",
            Self::GroundFlag => "ignored: ground flag contradicts height and speed",
            Self::Centreline => {
                "smoothed: position in a run moved 1 m or more towards the centreline"
            }
        }
    }
}

/// Counts of rules with the first line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally(BTreeMap<Rule, (usize, usize)>);

impl Tally {
    pub(in crate::truth) fn add(&mut self, rule: Rule, line: usize) {
        let entry = self.0.entry(rule).or_insert((0, line));
        entry.0 += 1;
        entry.1 = entry.1.min(line);
    }

    /// How often a rule was applied.
    #[must_use]
    pub fn count(&self, rule: Rule) -> usize {
        self.0.get(&rule).map_or(0, |e| e.0)
    }

    /// The rule applied most often, as the end of a sentence.
    pub(super) fn most(&self) -> String {
        let most = self.rows().max_by_key(|(rule, count, _)| (*count, std::cmp::Reverse(*rule)));
        let text = |(rule, count, _): (Rule, usize, usize)| format!(" ({count} {})", rule.text());
        most.map_or(String::new(), text)
    }

    /// Rules with count and first line.
    pub fn rows(&self) -> impl Iterator<Item = (Rule, usize, usize)> {
        self.0.iter().map(|(rule, (count, line))| (*rule, *count, *line))
    }
}

/// A limit of the type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Held {
    /// Speed on taxiways.
    TaxiSpeed,
    /// Acceleration on taxiways.
    TaxiAcceleration,
    /// Braking on taxiways.
    TaxiBraking,
    /// Speed on the ground in a take-off run.
    TakeoffSpeed,
    /// Speed on the ground in a landing run.
    LandingSpeed,
    /// Acceleration in a run and in the air.
    RunAcceleration,
    /// Braking in a run and in the air.
    RunBraking,
}

impl Held {
    /// Column of the table of types, and unit.
    #[must_use]
    pub fn column(self) -> (&'static str, &'static str) {
        match self {
            Self::TaxiSpeed => ("taxi_straight_max_ms", "m/s"),
            Self::TaxiAcceleration => ("taxi_acc_ms2", "m/s2"),
            Self::TaxiBraking => ("taxi_dec_ms2", "m/s2"),
            Self::TakeoffSpeed => ("liftoff_ms", "m/s"),
            Self::LandingSpeed => ("touchdown_ms", "m/s"),
            Self::RunAcceleration => ("takeoff_acc_ms2", "m/s2"),
            Self::RunBraking => ("braking_acc_ms2", "m/s2"),
        }
    }
}

/// For how long the truth was held to a limit of the type that the recording goes beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Holding {
    /// The limit.
    pub limit: Held,
    /// Its value, m/s or m/s².
    pub value: f64,
    /// How long the truth is at it, s.
    pub duration_s: f64,
    /// What the smoothed recording does at the most in that time: mean of 10 s, m/s or m/s².
    pub recorded: f64,
    /// Largest distance of used positions along the path in that time, m.
    pub along_m: f64,
}

/// What the import did, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Records in the file (after the cut).
    pub records: usize,
    /// Positions that the truth follows.
    pub used: usize,
    /// By rule and number.
    pub tally: Tally,
    /// Longest time without a used position, s, and the line after it.
    pub longest_gap: (f64, usize),
    /// Number of times without a used position for more than 2 s.
    pub gaps: usize,
    /// Standstills: number and duration in s.
    pub stands: (usize, f64),
    /// Legs driven backward.
    pub pushbacks: usize,
    /// Typical error of a position across the path, m.
    pub sigma_m: f64,
    /// Root mean square and largest distance of used positions across the path, m.
    pub across_m: (f64, f64),
    /// Root mean square and largest distance of used positions along the path, m.
    pub along_m: (f64, f64),
    /// Where recording and type contradict each other: the type has the last word.
    pub held: Vec<Holding>,
    /// Largest distance by which a position in a run was moved towards the centreline, m.
    pub centred_m: f64,
    /// Pressure altitude on the ground over the field elevation, m; removed.
    pub altitude_offset_m: Option<f64>,
    /// Lift-off and touchdown, s after the first record.
    pub liftoff_s: Option<f64>,
    /// Touchdown, s after the first record.
    pub touchdown_s: Option<f64>,
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} records, {} positions used", self.records, self.used)?;
        for (rule, count, line) in self.tally.rows() {
            writeln!(f, "  {count:5}  {} (first in line {line})", rule.text())?;
        }
        if self.centred_m > 0.0 {
            writeln!(
                f,
                "         in runs moved towards the centreline by up to {:.1} m",
                self.centred_m
            )?;
        }
        for held in &self.held {
            let (column, unit) = held.limit.column();
            writeln!(
                f,
                "{:5.0} s  held to {column} = {:.2} {unit}: the recording has {:.2} (mean of 10 s); leaves up to {:.0} m along the path",
                held.duration_s, held.value, held.recorded, held.along_m
            )?;
        }
        let (gap_s, gap_line) = self.longest_gap;
        writeln!(
            f,
            "  {:5}  filled: time without a position above 2 s; longest {gap_s:.1} s, to line {gap_line}",
            self.gaps
        )?;
        let (stands, stand_s) = self.stands;
        writeln!(
            f,
            "  {stands:5}  standstills, {:.0} s in all; backward legs: {}",
            stand_s + 0.0,
            self.pushbacks
        )?;
        writeln!(
            f,
            "         error of a position: sigma {:.1} m; left across the path rms {:.1} m, max {:.1} m; along it rms {:.1} m, max {:.1} m",
            self.sigma_m, self.across_m.0, self.across_m.1, self.along_m.0, self.along_m.1
        )?;
        if let Some(offset_m) = self.altitude_offset_m {
            writeln!(f, "         altitude offset removed: {offset_m:+.1} m")?;
        }
        let time = |t: Option<f64>| t.map_or("none".into(), |t| format!("{t:.1} s"));
        write!(
            f,
            "         lift-off {}, touchdown {}",
            time(self.liftoff_s),
            time(self.touchdown_s)
        )
    }
}

/// Why a recording cannot be repaired.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Hardly any sound positions.
    #[error(
        "only {left} of {records} positions are sound, needed are 10 and an eighth of all{why}"
    )]
    TooFew {
        /// Line to look at.
        line: usize,
        /// Sound positions.
        left: usize,
        /// Records.
        records: usize,
        /// The rule that most records fell to, for people; empty if none did.
        why: String,
    },
    /// Too long without a position while the mover went on.
    #[error(
        "no sound position for {gap_s:.0} s while it moved {moved_m:.0} m, allowed is {limit_s:.0} s"
    )]
    Gap {
        /// Line after the gap.
        line: usize,
        /// Duration.
        gap_s: f64,
        /// Distance.
        moved_m: f64,
        /// Limit.
        limit_s: f64,
    },
    /// Longer than anything on the surface.
    #[error("spans {span_s:.0} s, allowed is {limit_s:.0} s")]
    TooLong {
        /// Last line.
        line: usize,
        /// Duration.
        span_s: f64,
        /// Limit.
        limit_s: f64,
    },
    /// Farther than anything on the surface.
    #[error("goes {way_m:.0} m, allowed is {limit_m:.0} m")]
    TooFar {
        /// Last line.
        line: usize,
        /// Length of the way.
        way_m: f64,
        /// Limit.
        limit_m: f64,
    },
    /// The limits of the type do not allow anything near the positions.
    #[error(
        "the type cannot move like this: {off_m:.0} m off the recorded positions within its speeds and accelerations"
    )]
    BeyondType {
        /// Line of the largest distance.
        line: usize,
        /// Distance.
        off_m: f64,
    },
    /// Positions are sound, but no curve within the limits was found near them.
    #[error("no {what} within the limits of the type was found for the positions from line {from}")]
    NoFit {
        /// Last line of them.
        line: usize,
        /// First line of them.
        from: usize,
        /// What was not found: path or progress.
        what: &'static str,
    },
}

impl Refusal {
    /// Line of the file to look at.
    #[must_use]
    pub fn line(&self) -> usize {
        match self {
            Self::TooFew { line, .. }
            | Self::Gap { line, .. }
            | Self::TooLong { line, .. }
            | Self::TooFar { line, .. }
            | Self::BeyondType { line, .. }
            | Self::NoFit { line, .. } => *line,
        }
    }
}
