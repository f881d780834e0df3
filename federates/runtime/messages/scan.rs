//! A scan as spectators get it: truth, plots, tracks, and the tracks of others.

use super::words;
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::{Point2, Point3};
use models::plot::SensorKind;
use models::track::{TrackStatus, TrackType};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A track as published (`TrackInfo`); airport frame, SI units, radians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackMessage {
    /// Track number, below 32 768.
    pub number: u16,
    /// Whether it is an aircraft or a vehicle of the flight data list.
    #[serde(with = "words")]
    pub track_type: TrackType,
    /// Where it is in its life.
    #[serde(with = "words")]
    pub status: TrackStatus,
    /// First message of this track.
    pub first: bool,
    /// Time of validity, ns of simulated time.
    pub time_ns: i64,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north.
    pub velocity_mps: [f64; 2],
    /// Covariance of the position, m²: ee, en, nn.
    pub cov_m2: [f64; 3],
    /// Acceleration, m/s² east and north.
    pub acceleration_ms2: [f64; 2],
    /// Covariance of the velocity, m²/s²: ee, en, nn.
    pub velocity_cov_m2s2: [f64; 3],
    /// Height above the aerodrome reference, m.
    pub altitude_m: Option<f64>,
    /// Time of the report that gave it, ns of simulated time.
    pub altitude_ns: Option<i64>,
    /// Course over ground, rad clockwise from north in [0, 2π).
    pub heading_rad: f64,
    /// A manoeuvre was marked.
    pub manoeuvre: bool,
    /// Call sign of the label; empty if none.
    pub callsign: String,
    /// Type designator; empty if none.
    pub type_designator: String,
    /// Wake category of the label.
    #[serde(with = "words::or_none")]
    pub wake: Option<WakeCategory>,
    /// What the label says that it is about.
    #[serde(with = "words::or_none")]
    pub movement: Option<MovementKind>,
    /// Runway and stand.
    pub runway_stand: String,
    /// CTD or ETA, ns of simulated time.
    pub ctd_eta_ns: Option<i64>,
    /// Taxiways of the clearance.
    pub routing: Vec<String>,
    /// Call sign that it more likely has than not, where that is too unsure for a label; empty if none.
    pub assumed: String,
    /// Probability of the label, or of what is assumed.
    pub label_p: Option<f64>,
    /// 24-bit address that the target itself reports.
    pub address: Option<u32>,
    /// Probability that there is a target at all, where lives go by it.
    pub existence_p: Option<f64>,
    /// More plots lay where it may be than it could be told from, in this scan.
    pub unresolved: bool,
    /// The publication before, revised by the plots of one more scan; absent in a track's first report.
    pub lag: Option<LagMessage>,
}

/// A track one scan ago, as it is known now; airport frame, SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LagMessage {
    /// Time of validity, ns of simulated time.
    pub time_ns: i64,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Its covariance, m²: ee, en, nn.
    pub cov_m2: [f64; 3],
    /// No plot came between: it is what was published then.
    pub coasted: bool,
    /// Distance from the entity that the track follows, m, where it follows one.
    pub error_m: Option<f64>,
}

/// A report of somebody else's track; airport frame, SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForeignReport {
    /// Who sent it: SAC/SIC.
    pub source: String,
    /// Its number there.
    pub track: u32,
    /// Time of validity, ns of simulated time.
    pub time_ns: i64,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north, where it is said.
    pub velocity_mps: Option<[f64; 2]>,
    /// Call sign; empty if none.
    pub callsign: String,
    /// Without a recent plot.
    pub coasting: bool,
    /// Its last message.
    pub last: bool,
    /// UTC of its arrival, ns since 1970.
    pub received_ns: i64,
}

/// A plot as the evaluation sees it: with its cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlotMessage {
    /// Sensor number.
    pub sensor: u16,
    /// Kind of the sensor.
    #[serde(with = "words")]
    pub kind: SensorKind,
    /// Time of the measurement, ns of simulated time.
    pub time_ns: i64,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Covariance, m²: ee, en, nn.
    pub cov_m2: [f64; 3],
    /// First direction of the error ellipse (unit vector, east and north), variance along and across it, m².
    pub ellipse: [f64; 4],
    /// Height above the aerodrome reference, m, where the sensor reports it.
    pub altitude_m: Option<f64>,
    /// Velocity as the target reported it, m/s east and north, in the steps of its squitter on the ground or in the air; ADS-B only.
    pub velocity_mps: Option<[f64; 2]>,
    /// Slant range m, azimuth rad, and the standard deviations of both, radars only.
    pub polar: Option<[f64; 4]>,
    /// SCNR, dB, radars only.
    pub scnr_db: Option<f64>,
    /// Identity as reported: the call sign, where there is none the address in six hexadecimal digits; empty if none.
    pub identity: String,
    /// 24-bit address that was reported with it; the log does not keep it.
    pub address: Option<u32>,
    /// Entity that caused it (call sign), for evaluation; empty for false alarms.
    pub cause: String,
    /// True position at the time of the measurement, m east and north; none for false alarms.
    pub truth_m: Option<Point2<f64>>,
    /// Number within the sensor and scan; with scan and sensor it names the plot.
    pub sequence: u32,
    /// Track that took it.
    pub track: Option<u16>,
    /// What each simulated effect did: (effect, value, unit).
    pub effects: Vec<(String, f64, String)>,
}

/// An entity as the SMDFM received it, at the end of the scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthMessage {
    /// DIS identifier: site, application, entity.
    pub id: [u16; 3],
    /// Marking.
    pub callsign: String,
    /// 24-bit address of its transponder, where it has one; the log does not keep it.
    pub address: Option<u32>,
    /// Type designator, where known.
    pub type_designator: String,
    /// Aircraft or vehicle.
    pub aircraft: bool,
    /// Length and span, m.
    pub size_m: [f64; 2],
    /// Position, m east, north, up.
    pub position_m: Point3<f64>,
    /// Velocity, m/s east, north, up.
    pub velocity_mps: [f64; 3],
    /// Where the nose points, rad clockwise from north.
    pub heading_rad: f64,
    /// Whether it belongs to the federation (false: an outsider's entity).
    pub ours: bool,
    /// Number of the track that follows it and the distance to it, m.
    pub track: Option<(u16, f64)>,
}

/// One scan of the SMDFM: tracks, plots and truth of the same second.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScanReport {
    /// Number of the run.
    pub run: u32,
    /// Number of the scan, from 1.
    pub scan: u64,
    /// Time of publication, ns of simulated time.
    pub time_ns: i64,
    /// Published tracks, by number.
    pub tracks: Vec<TrackMessage>,
    /// Plots of the scan.
    pub plots: Vec<PlotMessage>,
    /// Truth as received.
    pub truth: Vec<TruthMessage>,
    /// Measures since the start: (name, value): "pd_asde", "raw_rmse_m", "rmse_m", "tracks_confirmed", …
    pub measures: Vec<(String, f64)>,
    /// The effect plan: rows of (sensor, effect, called for by, bound, decision).
    pub plan: Vec<[String; 5]>,
    /// Time that the scan took, µs of wall time.
    pub took_us: u64,
}

impl ScanReport {
    /// For each track that follows an entity: index of its truth in the scan, and the distance in m.
    #[must_use]
    pub fn followed(&self) -> BTreeMap<u16, (usize, f64)> {
        let truth = self.truth.iter().enumerate();
        truth.filter_map(|(i, t)| t.track.map(|(number, error_m)| (number, (i, error_m)))).collect()
    }
}

impl PlotMessage {
    /// The call sign that was reported; empty where none was, or an address alone.
    #[must_use]
    pub fn callsign(&self) -> &str {
        match self.address {
            Some(address) if self.identity == format!("{address:06X}") => "",
            _ => &self.identity,
        }
    }
}

impl TruthMessage {
    /// The DIS identifier as one number.
    #[must_use]
    pub fn key(&self) -> u64 {
        let [site, application, entity] = self.id.map(u64::from);
        site << 32 | application << 16 | entity
    }
}
