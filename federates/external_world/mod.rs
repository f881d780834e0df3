//! The external world: the weather of the scene's timeline and the flight data list.
//!
//! Weather goes out as Environmental Process PDUs (the SMDFM reads those, so that a recording holds
//! all that it needs) and as notices for spectators; the flight list as a notice to the federation.

pub mod weather_pdu;

use crate::runtime::bus::Class;
use crate::runtime::codec::encode;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Publication};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{
    FinalReport, FlightNotice, Frame, Kind, Notice, RunConfig, WeatherNotice,
};
use models::environment::Weather;
use models::flight_list::{FlightEntry, FlightList, MovementKind, WakeCategory};
use models::frames::Vector2;
use models::plot::Callsign;
use models::time::SimTime;
use pdu::Envelope;
use scenarios::Scene;
use std::sync::Arc;

/// The federate's logic.
pub struct ExternalWorld {
    scene: Arc<Scene>,
    exercise: u8,
    time: FrameTime,
    next_notice: usize,
    last_sent: Option<(Frame, Weather)>,
    sequence: u16,
}

/// Weather PDUs are repeated at this interval for late joiners, s.
const WEATHER_HEARTBEAT_S: f64 = 30.0;

impl ExternalWorld {
    /// The external world of a scene.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8) -> Self {
        let time = FrameTime::of(&scene.run);
        Self { scene, exercise, time, next_notice: 0, last_sent: None, sequence: 0 }
    }

    fn weather_due(&mut self, frame: Frame, out: &mut FrameOut) {
        let now = self.time.time(frame);
        let mut change = None;
        while let Some(notice) = self.scene.weather.get(self.next_notice) {
            if notice.time > now {
                break;
            }
            change = Some(notice.weather.clone());
            self.next_notice += 1;
        }
        let heartbeat = self
            .last_sent
            .as_ref()
            .is_some_and(|(sent, _)| now.since_s(self.time.time(*sent)) >= WEATHER_HEARTBEAT_S);
        let weather = match (change, heartbeat, &self.last_sent) {
            (Some(weather), _, _) => weather,
            (None, true, Some((_, weather))) => weather.clone(),
            _ => return,
        };
        let process = weather_pdu::encode(&weather, self.scene.run.site, self.sequence);
        self.sequence = self.sequence.wrapping_add(1);
        let mut octets = Vec::new();
        Envelope::new(self.exercise, self.time.stamp(frame))
            .append(&process.pdu(), &mut octets)
            .expect("a handful of rain cells fits a PDU: the scene allows 100");
        out.pdus.push(octets.into());
        out.publish.push(Publication {
            key: "obs/weather".into(),
            class: Class::Lossy,
            body: encode(&notice_of(&weather, now)),
            retained: Some("obs/weather/last".into()),
        });
        self.last_sent = Some((frame, weather));
    }
}

impl Federate for ExternalWorld {
    fn kind(&self) -> Kind {
        Kind::ExternalWorld
    }

    fn configure(&mut self, _config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        self.next_notice = 0;
        self.last_sent = None;
        self.sequence = 0;
        let flights: Vec<_> = self.scene.flight_list.entries.iter().map(flight_notice).collect();
        out.publish.push(Publication {
            key: "obs/flights".into(),
            class: Class::Lossy,
            body: encode(&flights),
            retained: Some("obs/flights/last".into()),
        });
        out.notices.push(Notice::Flights(flights));
        self.weather_due(0, out);
        Ok(())
    }

    fn step(&mut self, frame: Frame, _inputs: &FrameInputs, out: &mut FrameOut) {
        self.weather_due(frame, out);
    }

    fn finish(&mut self, report: &mut FinalReport) {
        report.values.push(("weather_changes".into(), self.next_notice as f64));
    }
}

/// A weather notice for spectators.
#[must_use]
pub fn notice_of(weather: &Weather, from: SimTime) -> WeatherNotice {
    WeatherNotice {
        from_ns: from.0,
        rain_mm_per_h: weather.rain_mm_per_h,
        visibility_m: weather.visibility_m,
        temperature_k: weather.temperature_k,
        pressure_hpa: weather.pressure_hpa,
        vapour_g_per_m3: weather.vapour_g_per_m3,
        wind_mps: [weather.wind_mps.x, weather.wind_mps.y],
        film_mm: weather.film_mm,
        cells: weather
            .cells
            .iter()
            .map(|c| [c.centre_m.x, c.centre_m.y, c.radius_m, c.rain_mm_per_h])
            .collect(),
    }
}

/// Letter of a wake category.
#[must_use]
pub fn wake_letter(wake: Option<WakeCategory>) -> &'static str {
    match wake {
        Some(WakeCategory::Light) => "L",
        Some(WakeCategory::Medium) => "M",
        Some(WakeCategory::Heavy) => "H",
        Some(WakeCategory::Super) => "J",
        None => "",
    }
}

/// Word of a movement.
#[must_use]
pub fn movement_word(movement: MovementKind) -> &'static str {
    match movement {
        MovementKind::Arrival => "arrival",
        MovementKind::Departure => "departure",
        MovementKind::Vehicle => "vehicle",
    }
}

/// A line of the flight list as a message.
#[must_use]
pub fn flight_notice(entry: &FlightEntry) -> FlightNotice {
    FlightNotice {
        callsign: entry.callsign.as_str().to_owned(),
        address: entry.address,
        type_designator: entry.type_designator.clone(),
        wake: wake_letter(entry.wake).to_owned(),
        movement: movement_word(entry.movement).to_owned(),
        runway: entry.runway.clone(),
        stand: entry.stand.clone(),
        stand_m: entry.stand_m.map(|p| [p.x, p.y]),
        eta_ctd_ns: entry.eta_ctd.0,
        off_block_ns: entry.off_block.map(|t| t.0),
        routing: entry.routing.clone(),
    }
}

/// The flight list that a notice carries; runways come from the scene of the receiver.
#[must_use]
pub fn flight_list(
    notices: &[FlightNotice],
    runways: Vec<(String, [Vector2<f64>; 2])>,
) -> FlightList {
    let mut entries: Vec<FlightEntry> = notices
        .iter()
        .map(|n| FlightEntry {
            callsign: Callsign::new(&n.callsign),
            address: n.address,
            type_designator: n.type_designator.clone(),
            wake: match n.wake.as_str() {
                "L" => Some(WakeCategory::Light),
                "M" => Some(WakeCategory::Medium),
                "H" => Some(WakeCategory::Heavy),
                "J" => Some(WakeCategory::Super),
                _ => None,
            },
            movement: match n.movement.as_str() {
                "arrival" => MovementKind::Arrival,
                "departure" => MovementKind::Departure,
                _ => MovementKind::Vehicle,
            },
            runway: n.runway.clone(),
            stand: n.stand.clone(),
            stand_m: n.stand_m.map(|p| Vector2::new(p[0], p[1])),
            eta_ctd: SimTime(n.eta_ctd_ns),
            off_block: n.off_block_ns.map(SimTime),
            routing: n.routing.clone(),
        })
        .collect();
    entries.sort_by_key(|e| e.callsign);
    FlightList { entries, runways }
}
