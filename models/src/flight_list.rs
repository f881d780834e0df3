//! The flight data list: what the operator knows of the expected movements, before any surveillance.

use crate::frames::Point2;
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::words::words;

/// Wake turbulence category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WakeCategory {
    /// Light.
    Light,
    /// Medium.
    Medium,
    /// Heavy.
    Heavy,
    /// Super (A388).
    Super,
}

/// Direction of a movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MovementKind {
    /// From the runway to a stand.
    Arrival,
    /// From a stand to the runway.
    Departure,
    /// A ground vehicle.
    Vehicle,
}

words! {
    "wake category": WakeCategory {
        Light = "L",
        Medium = "M",
        Heavy = "H",
        Super = "J",
    }
}

words! {
    "kind of a movement": MovementKind {
        Arrival = "arrival",
        Departure = "departure",
        Vehicle = "vehicle",
    }
}

/// One line of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightEntry {
    /// Call sign, or vehicle name.
    pub callsign: Callsign,
    /// 24-bit Mode S address, where known.
    pub address: Option<u32>,
    /// Type designator of `types.csv` ("A320", "FIRE").
    pub type_designator: String,
    /// Wake turbulence category; none for vehicles.
    pub wake: Option<WakeCategory>,
    /// Arrival, departure or vehicle.
    pub movement: MovementKind,
    /// Runway designator ("28"); empty for vehicles.
    pub runway: String,
    /// Stand name ("E_19").
    pub stand: String,
    /// Position of the stand, airport frame, m, where known.
    pub stand_m: Option<Point2<f64>>,
    /// Estimated time of arrival at the runway (arrival) or calculated time of departure (departure).
    pub eta_ctd: SimTime,
    /// Off-block time of a departure.
    pub off_block: Option<SimTime>,
    /// Names of the taxiways of the clearance, in order.
    pub routing: Vec<String>,
}

/// All lines, sorted by call sign.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightList {
    /// The entries, sorted by call sign.
    pub entries: Vec<FlightEntry>,
    /// Runways with their thresholds (airport frame, m) by designator, for labels of arrivals.
    pub runways: Vec<(String, [Point2<f64>; 2])>,
}

impl FlightList {
    /// The entry with this call sign; the list must be sorted.
    #[must_use]
    pub fn by_callsign(&self, callsign: Callsign) -> Option<&FlightEntry> {
        let found = self.entries.binary_search_by(|e| e.callsign.cmp(&callsign));
        found.ok().map(|index| &self.entries[index])
    }

    /// Whether the entries are sorted by call sign, as they must be.
    #[must_use]
    pub fn is_sorted(&self) -> bool {
        self.entries.is_sorted_by(|a, b| a.callsign <= b.callsign)
    }

    /// The same list, sorted by call sign.
    #[must_use]
    pub fn sorted(&self) -> Self {
        let mut list = self.clone();
        list.entries.sort_by_key(|e| e.callsign);
        list
    }

    /// The entry with this Mode S address.
    #[must_use]
    pub fn by_address(&self, address: u32) -> Option<&FlightEntry> {
        self.entries.iter().find(|e| e.address == Some(address))
    }
}
