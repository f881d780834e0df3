//! A system track as published: the paper's `TrackInfo`, with its accuracy.

use crate::flight_list::{MovementKind, WakeCategory};
use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::words::words;

/// What kind of target the label says it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrackType {
    /// No entry of the flight list is associated.
    #[default]
    NotAssociated,
    /// An aircraft of the flight list.
    Aircraft,
    /// A vehicle of the flight list.
    Vehicle,
}

/// Stage in the life of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrackStatus {
    /// Not yet confirmed; not published unless asked for.
    Tentative,
    /// Confirmed and updated.
    Confirmed,
    /// Confirmed, without an accepted plot in the last expected update.
    Coasting,
    /// Last message of this track.
    Last,
}

words! {
    "type of a track": TrackType {
        NotAssociated = "none",
        Aircraft = "aircraft",
        Vehicle = "vehicle",
    }
}

words! {
    "status of a track": TrackStatus {
        Tentative = "tentative",
        Confirmed = "confirmed",
        Coasting = "coasting",
        Last = "last",
    }
}

/// What the flight list adds to a track.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Call sign or vehicle name.
    pub callsign: Callsign,
    /// Type designator ("A320").
    pub type_designator: String,
    /// Wake turbulence category.
    pub wake: Option<WakeCategory>,
    /// Arrival, departure, vehicle.
    pub movement: MovementKind,
    /// Runway and stand, "28/E_19".
    pub runway_stand: String,
    /// Calculated time of departure or estimated time of arrival.
    pub ctd_eta: SimTime,
    /// Taxiways of the clearance.
    pub routing: Vec<String>,
}

/// One system track at one publication time. Airport frame, metres, seconds, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemTrack {
    /// Track number, below 32 768.
    pub number: u16,
    /// Associated with an aircraft, a vehicle, or nothing.
    pub track_type: TrackType,
    /// Life stage.
    pub status: TrackStatus,
    /// First message of this track.
    pub first: bool,
    /// Time of validity: the end of the scan.
    pub time: SimTime,
    /// Time of the last plot that updated it.
    pub last_plot: SimTime,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north.
    pub velocity_mps: Vector2<f64>,
    /// Acceleration, m/s² east and north.
    pub acceleration_ms2: Vector2<f64>,
    /// Covariance of the position, m².
    pub position_cov_m2: Matrix2<f64>,
    /// Covariance of the velocity, m²/s².
    pub velocity_cov_m2s2: Matrix2<f64>,
    /// Height above the aerodrome reference, m, as its last plot with one reported it, [`HEIGHT_KEPT_S`] ago or less.
    pub altitude_m: Option<f64>,
    /// Time of that report.
    pub altitude_at: Option<SimTime>,
    /// Course over ground, radians clockwise from north in [0, 2π); held below 1 m/s.
    pub heading_rad: f64,
    /// A manoeuvre was marked in this scan.
    pub manoeuvre: bool,
    /// Label from the flight list: given by the target's own name, or at least nine in ten sure.
    pub label: Option<Label>,
    /// The name that the target itself reports (ADS-B, DGPS), in the flight list or not.
    pub reported: Option<Callsign>,
    /// The line of the flight list that it more likely is than not, where that is too unsure for a label.
    pub assumed: Option<Callsign>,
    /// Probability of the label, or of what is assumed.
    pub label_p: Option<f64>,
    /// 24-bit address that the target itself reports.
    pub address: Option<u32>,
    /// Probability that there is a target at all, where lives go by it.
    pub existence_p: Option<f64>,
    /// More plots lay where it may be than it could be told from, in this scan.
    pub unresolved: bool,
    /// Where it was at the publication before, by the plots that came since; absent in its first report.
    pub second_ago: Option<SecondAgo>,
}

/// A track at the publication before, revised by the plots of one more scan: for a consumer that can wait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondAgo {
    /// Time of validity: the end of the scan before.
    pub time: SimTime,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Its covariance, m².
    pub cov_m2: Matrix2<f64>,
    /// No plot came between: it is what was published then.
    pub coasted: bool,
}

/// How long a track keeps a height that no plot repeats, s: two reports of a target that stands (assumed).
pub const HEIGHT_KEPT_S: f64 = 10.0;

impl SystemTrack {
    /// What the target is called: by its label, else by itself.
    #[must_use]
    pub fn callsign(&self) -> Option<Callsign> {
        self.label.as_ref().map(|label| label.callsign).or(self.reported)
    }

    /// Ground speed, m/s.
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        libm::hypot(self.velocity_mps.x, self.velocity_mps.y)
    }
}
