//! What an alert is: kind, stage, subjects; and its message type in ASTERIX category 004.

use super::clearance::ClearanceKind;
use crate::frames::Point2;
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::words::{Word, words};
use std::borrow::Cow;

/// How grave an alert is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// To be known.
    Information,
    /// To act upon.
    Alarm,
}

words! {
    "stage of an alert": Stage {
        Information = "information",
        Alarm = "alarm",
    }
}

/// What an alert is about (`docs/control.md`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlertKind {
    /// Traffic against each other on one runway.
    RunwayOpposite,
    /// Two that meet where runways cross.
    RunwayCrossing,
    /// Somebody ahead of a roll.
    RunwayRoll,
    /// Somebody on the runway of an arrival.
    RunwayArrival,
    /// Arrival to, or roll on, a closed runway.
    RunwayClosed,
    /// Two clearances that exclude each other.
    Conflicting(ClearanceKind, ClearanceKind),
    /// On a runway without clearance.
    NoRunwayClearance,
    /// Take-off without clearance.
    NoTakeOffClearance,
    /// Landing without clearance.
    NoLandingClearance,
    /// Push-back without clearance.
    NoPushClearance,
    /// Taxiing without clearance.
    NoTaxiClearance,
    /// Over a lit stop bar.
    StopBar,
    /// Off the cleared way.
    OffWay,
    /// Cleared for the runway, and does not move.
    NoMovement,
    /// Too fast on a taxiway.
    HighSpeed,
    /// In a protected area.
    Area,
    /// Way or runway too small for the type.
    TooSmall,
    /// The stand of an arrival is occupied.
    StandOccupied,
}

impl AlertKind {
    /// Its word ("RMCA_ARR", "CATC_CRO_TOF").
    #[must_use]
    pub fn word(self) -> String {
        let word = match self {
            Self::RunwayOpposite => "RMCA_OPP",
            Self::RunwayCrossing => "RMCA_CROSS",
            Self::RunwayRoll => "RMCA_ROLL",
            Self::RunwayArrival => "RMCA_ARR",
            Self::RunwayClosed => "RWY_CLOSED",
            Self::Conflicting(a, b) => {
                let (a, b) = (a.word(), b.word());
                return format!("CATC_{}_{}", a.min(b), a.max(b));
            }
            Self::NoRunwayClearance => "NOCLR_RWY",
            Self::NoTakeOffClearance => "NOCLR_TOF",
            Self::NoLandingClearance => "NOCLR_LND",
            Self::NoPushClearance => "NOCLR_PUSH",
            Self::NoTaxiClearance => "NOCLR_TAXI",
            Self::StopBar => "STOPBAR",
            Self::OffWay => "ROUTE_DEV",
            Self::NoMovement => "NOMOV",
            Self::HighSpeed => "HIGH_SPEED",
            Self::Area => "AREA",
            Self::TooSmall => "WRTY",
            Self::StandOccupied => "STOCC",
        };
        word.to_owned()
    }

    /// Whether it compares what is done with what was cleared: where nobody follows clearances, it says nothing.
    #[must_use]
    pub fn is_about_clearances(self) -> bool {
        matches!(
            self,
            Self::Conflicting(..)
                | Self::NoLandingClearance
                | Self::NoMovement
                | Self::NoPushClearance
                | Self::NoRunwayClearance
                | Self::NoTakeOffClearance
                | Self::NoTaxiClearance
                | Self::OffWay
                | Self::StopBar
        )
    }

    /// The kind of a word; none where there is no such kind.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        if let Some((a, b)) = word.strip_prefix("CATC_").and_then(|pair| pair.split_once('_')) {
            return Some(Self::Conflicting(ClearanceKind::of(a)?, ClearanceKind::of(b)?));
        }
        Self::ALONE.into_iter().find(|kind| kind.word() == word)
    }

    /// All kinds but those of pairs of clearances.
    const ALONE: [Self; 17] = [
        Self::RunwayOpposite,
        Self::RunwayCrossing,
        Self::RunwayRoll,
        Self::RunwayArrival,
        Self::RunwayClosed,
        Self::NoRunwayClearance,
        Self::NoTakeOffClearance,
        Self::NoLandingClearance,
        Self::NoPushClearance,
        Self::NoTaxiClearance,
        Self::StopBar,
        Self::OffWay,
        Self::NoMovement,
        Self::HighSpeed,
        Self::Area,
        Self::TooSmall,
        Self::StandOccupied,
    ];

    /// Message type in ASTERIX category 004 (I004/000); of a roll towards one who crosses see [`Condition::asterix`].
    #[must_use]
    pub fn asterix(self) -> u8 {
        match self {
            Self::RunwayOpposite => 11,
            Self::RunwayCrossing => 30,
            Self::RunwayRoll => 12,
            Self::RunwayArrival => 9,
            Self::RunwayClosed => 10,
            Self::Conflicting(..) => 38,
            Self::NoRunwayClearance
            | Self::NoTakeOffClearance
            | Self::NoLandingClearance
            | Self::NoPushClearance => 39,
            Self::NoTaxiClearance => 15,
            Self::StopBar => 16,
            Self::OffWay => 2,
            Self::NoMovement => 40,
            Self::HighSpeed => 29,
            Self::Area => 32,
            Self::TooSmall => 42,
            Self::StandOccupied => 43,
        }
    }
}

/// Who an alert belongs to: a track, or, of conflicting clearances, a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Number of a track.
    Track(u16),
    /// Index of a strip of the board.
    Strip(u32),
}

/// A condition that holds in one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// What.
    pub kind: AlertKind,
    /// Who; the smaller first.
    pub subjects: (Subject, Option<Subject>),
    /// How grave.
    pub stage: Stage,
    /// Runway concerned.
    pub runway: Option<usize>,
    /// Where: the first subject, m.
    pub place_m: Point2<f64>,
    /// Who is in the way of a roll crosses the runway.
    pub crosses: bool,
}

impl Condition {
    /// Message type in ASTERIX category 004 (I004/000): a roll with a crosser is 13.
    #[must_use]
    pub fn asterix(&self) -> u8 {
        match self.kind {
            AlertKind::RunwayRoll if self.crosses => 13,
            kind => kind.asterix(),
        }
    }

    /// What conditions of successive scans are told apart by.
    #[must_use]
    pub fn key(&self) -> (AlertKind, Subject, Option<Subject>) {
        (self.kind, self.subjects.0, self.subjects.1)
    }
}

impl Word for AlertKind {
    const WHAT: &'static str = "kind of an alert";

    fn words() -> Vec<Cow<'static, str>> {
        let clearances = ClearanceKind::ALL.into_iter().enumerate();
        let pairs = clearances.flat_map(|(n, a)| {
            ClearanceKind::ALL.into_iter().skip(n).map(move |b| Self::Conflicting(a, b))
        });
        Self::ALONE.into_iter().chain(pairs).map(|kind| kind.said()).collect()
    }

    fn said(&self) -> Cow<'static, str> {
        self.word().into()
    }

    fn named(word: &str) -> Option<Self> {
        Self::of(word)
    }
}

/// What happened to an alert in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Raised.
    Raised,
    /// Its stage or the name of a subject changed.
    Changed,
    /// Ended.
    Ended,
}

words! {
    "change of an alert": Change {
        Raised = "raised",
        Changed = "changed",
        Ended = "ended",
    }
}

/// An alert.
#[derive(Clone, Debug, PartialEq)]
pub struct Alert {
    /// Number, counting up from 1.
    pub id: u32,
    /// The condition, as it was last.
    pub condition: Condition,
    /// Call signs of the subjects, where known, in the order of the subjects.
    pub names: (Option<Callsign>, Option<Callsign>),
    /// Raised at.
    pub since: SimTime,
    /// Stage since.
    pub stage_since: SimTime,
}

impl Alert {
    /// What people call the subjects: call signs, else track numbers, sorted, separated by blanks.
    #[must_use]
    pub fn subjects(&self) -> String {
        let name = |subject: Subject, callsign: Option<Callsign>| match (callsign, subject) {
            (Some(callsign), _) => callsign.as_str().to_owned(),
            (None, Subject::Track(number)) => number.to_string(),
            (None, Subject::Strip(index)) => format!("strip {index}"),
        };
        let (first, second) = self.condition.subjects;
        let mut names = vec![name(first, self.names.0)];
        names.extend(second.map(|s| name(s, self.names.1)));
        names.sort();
        names.join(" ")
    }
}
