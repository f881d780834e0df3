//! What members tell the federation beside their PDUs, and spectators with it: flights, weather, tracks, clearances, alerts.

use super::{Frame, REPORT_OCTETS, SeatInput, words};
use crate::runtime::codec::encoded_size;
use models::control::actors::message::MessageKind;
use models::control::advice::{self, Became, Decision};
use models::control::alert::{AlertKind, Change, Stage};
use models::control::clearance::ClearanceKind;
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::Point2;
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;

/// What a member tells the federation beside its PDUs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Notice {
    /// The whole flight data list.
    Flights(Vec<FlightNotice>),
    /// More of the list before, on its way only: who reads it has it in one.
    MoreFlights(Vec<FlightNotice>),
    /// A PDU of an outsider, let in with the frame that carries it.
    Outsider {
        /// UTC of its arrival, ns since 1970.
        received_ns: i64,
        /// Who sent it.
        from: SocketAddr,
        /// One sound PDU.
        octets: Vec<u8>,
    },
    /// System tracks of a scan, for control.
    Tracks(Vec<TrackNotice>),
    /// Clearances that were given or ended.
    Clearances(Vec<ClearanceNotice>),
    /// What all flights of a generator's share wait for, for controllers on tracks: told when it changed.
    Wants {
        /// Share, from 1.
        share: u32,
        /// All of them, by flight.
        wants: Vec<WantNotice>,
    },
    /// What a person at a controller's seat does.
    Seat(SeatInput),
    /// What controllers on tracks cleared, read back: the traffic does it from the frame of its effect on.
    Given(GivenNotice),
    /// What sensors of another SMDFM saw in a scan, for the one that fuses them.
    Plots(PlotsNotice),
    /// Flights that have another stand than the flight data list says, or was told last.
    Stands(Vec<StandNotice>),
    /// The weather, when it changes: for control, which is sent no PDUs.
    Weather(WeatherNotice),
}

/// The stand of a flight from now on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StandNotice {
    /// Who.
    pub callsign: String,
    /// Where it is, m east and north.
    pub stand_m: Point2<f64>,
}

/// What one sensor saw in a scan; several in a row where one would be too long.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlotsNotice {
    /// Number of the sensor in the scene.
    pub sensor: u16,
    /// Looks at targets, for statistics of detection.
    pub looks: u64,
    /// Lines of its effect plan, where they are not those of its scan before.
    pub plan: Option<Vec<[String; 5]>>,
    /// Its plots, in its order.
    pub plots: Vec<CausedPlot>,
}

/// A plot to the bit, with what caused it; airport frame, SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CausedPlot {
    /// Time of validity, ns of simulated time.
    pub time_ns: i64,
    /// Number within the sensor and scan.
    pub sequence: u32,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// First direction of the error ellipse.
    pub axis: [f64; 2],
    /// Variances along and across it, m².
    pub variances_m2: [f64; 2],
    /// Height above the aerodrome reference, m.
    pub altitude_m: Option<f64>,
    /// Range, m, azimuth, rad, and their standard deviations: of a radar.
    pub polar: Option<[f64; 4]>,
    /// Second moments of its cells, m².
    pub extent_m2: Option<[f64; 3]>,
    /// Call sign that it reports,
    pub callsign: Option<String>,
    /// or 24-bit address.
    pub address: Option<u32>,
    /// Signal to clutter and noise, dB.
    pub scnr_db: Option<f64>,
    /// Key of the entity; none of a false plot.
    pub key: Option<u64>,
    /// Where that was, m east and north.
    pub truth_m: Option<Point2<f64>>,
    /// What each effect did, with its unit.
    pub effects: Vec<(String, f64, String)>,
}

/// What a flight waits for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WantNotice {
    /// Flight, counted in the scene from 0.
    pub flight: u32,
    /// For which clearance.
    #[serde(with = "words")]
    pub kind: ClearanceKind,
    /// Group of the runway: of those that cross.
    pub group: u8,
    /// Designator of one of its ends.
    pub runway: String,
    /// It asks for it; else only a person would clear it for that now.
    pub asks: bool,
}

/// A clearance of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenNotice {
    /// Flight, counted in the scene from 0.
    pub flight: u32,
    /// Which clearance.
    #[serde(with = "words")]
    pub kind: ClearanceKind,
    /// Seat that gave it.
    pub seat: String,
    /// A person sits there: it is acted upon whatever the plan says.
    pub by_person: bool,
    /// Counted in the run from 1.
    pub number: u64,
}

/// What happened at a controller's seat: numbered, and told again for a while, because a message may be lost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeatMessage {
    /// Number of the run.
    pub run: u32,
    /// Counted in the run from 1.
    pub number: u64,
    /// What.
    pub event: SeatEvent,
}

/// What happens at a seat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SeatEvent {
    /// A clearance that the traffic acts upon from a frame on.
    Given(Frame, GivenNotice),
    /// A message on its frequency.
    Spoke {
        /// Time of its last word, ns of simulated time.
        time_ns: i64,
        /// Who spoke, and to whom.
        between: [String; 2],
        /// What it is.
        #[serde(with = "words")]
        kind: MessageKind,
        /// About which clearance.
        #[serde(with = "words")]
        clearance: ClearanceKind,
    },
    /// The last minute of a seat.
    Minute {
        /// End of the minute, ns of simulated time.
        time_ns: i64,
        /// Whose.
        seat: String,
        /// Share of it in which somebody thought, spoke or listened.
        busy: f64,
        /// How many waited at its end.
        queue: u32,
        /// Seconds on the air since the begin.
        on_air_s: f64,
    },
    /// What a person did there, from a frame on, and why not where it was refused.
    Input {
        /// The frame.
        frame: Frame,
        /// What.
        input: SeatInput,
        /// Why not; empty if it was done.
        refused: String,
    },
    /// Nothing was heard of a person for long: the model has the seat again, from a frame on.
    Silent {
        /// The frame.
        frame: Frame,
        /// Of which seat.
        seat: String,
        /// Who sat there.
        person: String,
    },
    /// What became of an advice.
    Advised(AdviceNotice),
    /// Counts since the begin.
    Counts {
        /// Clearances spoken.
        spoken: u64,
        /// Of these misheard.
        misheard: u64,
        /// On tracks: clearances given on a call alone, and seconds of runways that looked occupied.
        seen: Option<(u64, u64)>,
    },
}

/// An advice for a controller, as it stands after something became of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdviceNotice {
    /// Counted in the run from 1.
    pub id: u32,
    /// Frame of the change.
    pub frame: Frame,
    /// What became of it.
    #[serde(with = "words")]
    pub change: Became,
    /// What kind of advice.
    #[serde(with = "words")]
    pub kind: advice::Kind,
    /// For whom ("apron").
    pub seat: String,
    /// Call signs, with blanks between: who should do something, then whom it depends on.
    pub subjects: String,
    /// What to do, in words.
    pub text: String,
    /// What it is worth,
    pub value: f64,
    /// in this.
    pub unit: String,
    /// What happens otherwise.
    pub otherwise: String,
    /// Holds until, ns of simulated time.
    pub until_ns: i64,
    /// What was decided upon it,
    #[serde(with = "words")]
    pub decision: Decision,
    /// by a person; else by the model at the seat.
    pub by_person: bool,
}

/// A system track as control takes it; airport frame, SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackNotice {
    /// Track number, below 32 768.
    pub number: u16,
    /// Call sign of the label, else as the target reports it; empty if none.
    pub callsign: String,
    /// Type designator; empty if none.
    pub type_designator: String,
    /// What its label says that it is about.
    #[serde(with = "words::or_none")]
    pub movement: Option<MovementKind>,
    /// First message of this track.
    pub first: bool,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north.
    pub velocity_mps: [f64; 2],
    /// Height above the aerodrome reference, m.
    pub altitude_m: Option<f64>,
    /// Time of its last plot, ns of simulated time.
    pub last_plot_ns: i64,
}

/// A clearance that was given, or, with `until_ns`, ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearanceNotice {
    /// Who.
    pub callsign: String,
    /// Which.
    #[serde(with = "words")]
    pub kind: ClearanceKind,
    /// An end of a runway, or both; empty off the runways.
    pub runway: String,
    /// Holds from, ns of simulated time.
    pub from_ns: i64,
    /// Ended, ns of simulated time.
    pub until_ns: Option<i64>,
    /// Place along the runway from its first end, m.
    pub place_m: Option<f64>,
    /// Cleared way, m east and north; empty where it is no way.
    pub way_m: Vec<Point2<f64>>,
}

/// What happened to a control alert in a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AlertMessage {
    /// Number of the run.
    pub run: u32,
    /// Time of the scan, ns of simulated time.
    pub time_ns: i64,
    /// What happened to it.
    #[serde(with = "words")]
    pub change: Change,
    /// Number of the alert within the run.
    pub id: u32,
    /// What it is about.
    #[serde(with = "words")]
    pub kind: AlertKind,
    /// How grave it is.
    #[serde(with = "words")]
    pub stage: Stage,
    /// Call signs, else track numbers, separated by blanks.
    pub subjects: String,
    /// Raised at, ns of simulated time.
    pub since_ns: i64,
    /// Message type in ASTERIX category 004.
    pub asterix: u8,
    /// Where, m east and north.
    pub place_m: Point2<f64>,
    /// Counted in the run from 1: told again for a while, because a message may be lost. 0: not counted.
    pub number: u64,
}

impl Notice {
    /// The same in pieces that fit a report.
    pub(super) fn pieces(self) -> Vec<Self> {
        let Self::Flights(flights) = self else { return vec![self] };
        let mut pieces = vec![Vec::new()];
        let mut octets = 0;
        for flight in flights {
            let size = encoded_size(&flight);
            if octets + size > REPORT_OCTETS / 2 {
                pieces.push(Vec::new());
                octets = 0;
            }
            octets += size;
            if let Some(piece) = pieces.last_mut() {
                piece.push(flight);
            }
        }
        let mut pieces = pieces.into_iter();
        let first = pieces.next().map(Self::Flights);
        first.into_iter().chain(pieces.map(Self::MoreFlights)).collect()
    }
}

/// One line of the flight data list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlightNotice {
    /// Call sign or vehicle name.
    pub callsign: String,
    /// 24-bit Mode S address.
    pub address: Option<u32>,
    /// Type designator.
    pub type_designator: String,
    /// Wake category; none of vehicles.
    #[serde(with = "words::or_none")]
    pub wake: Option<WakeCategory>,
    /// What it is about.
    #[serde(with = "words")]
    pub movement: MovementKind,
    /// Runway designator; empty for vehicles.
    pub runway: String,
    /// Stand.
    pub stand: String,
    /// Position of the stand, m east and north, where known.
    pub stand_m: Option<Point2<f64>>,
    /// Estimated time of arrival or calculated time of departure, ns of simulated time.
    pub eta_ctd_ns: i64,
    /// Off-block time of a departure, ns of simulated time.
    pub off_block_ns: Option<i64>,
    /// Taxiways of the clearance.
    pub routing: Vec<String>,
}

/// The weather from a time on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeatherNotice {
    /// From when on, ns of simulated time.
    pub from_ns: i64,
    /// Uniform rain rate, mm/h.
    pub rain_mm_per_h: f64,
    /// Visibility, m; infinite when clear.
    pub visibility_m: f64,
    /// Temperature, K.
    pub temperature_k: f64,
    /// Pressure, hPa.
    pub pressure_hpa: f64,
    /// Water vapour, g/m³.
    pub vapour_g_per_m3: f64,
    /// Wind, m/s east and north.
    pub wind_mps: [f64; 2],
    /// Water film on pavement, mm.
    pub film_mm: f64,
    /// Cells: east m, north m, radius m, rain mm/h.
    pub cells: Vec<[f64; 4]>,
}
