//! The external world: the weather of the scene's timeline and the flight data list.
//!
//! Weather goes out as Environmental Process PDUs (the SMDFM reads those, so that a recording holds
//! all that it needs) and as notices for spectators; the flight list as a notice to the federation.

pub mod command;

use crate::exchange::flights::flight_notice;
use crate::exchange::weather_notice::notice_of;
use crate::exchange::weather_pdu;
use crate::federation::has_control;
use crate::runtime::bus::Class;
use crate::runtime::codec::encode;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Publication};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FinalReport, Frame, Kind, Notice, RunConfig};
use pdu::Envelope;
use scenarios::{Scene, WeatherNotice};
use std::sync::Arc;

/// The federate's logic.
pub struct ExternalWorld {
    scene: Arc<Scene>,
    exercise: u8,
    time: FrameTime,
    next_notice: usize,
    last_sent: Option<Frame>,
    sequence: u16,
}

/// Weather PDUs are repeated at this interval for late joiners, s: the notice as it was, with its age.
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
        let before = self.next_notice;
        self.next_notice = self.scene.weather.partition_point(|notice| notice.time <= now);
        let heartbeat = self
            .last_sent
            .is_some_and(|sent| now.since_s(self.time.time(sent)) >= WEATHER_HEARTBEAT_S);
        let changed = self.next_notice > before;
        if !changed && !heartbeat {
            return;
        }
        let Some(WeatherNotice { time: since, weather }) =
            self.next_notice.checked_sub(1).and_then(|last| self.scene.weather.get(last))
        else {
            return;
        };
        let since_s = now.since_s(*since);
        let process = weather_pdu::encode(weather, since_s, self.scene.run.site, self.sequence);
        self.sequence = self.sequence.wrapping_add(1);
        let mut octets = Vec::new();
        Envelope::new(self.exercise, self.time.stamp(frame))
            .append(&process.pdu(), &mut octets)
            .expect("a handful of rain cells fits a PDU: the scene allows 100");
        out.pdus.push(octets.into());
        out.publish.push(Publication {
            key: "obs/weather".into(),
            class: Class::Lossy,
            body: encode(&notice_of(weather, *since)),
            retained: Some("obs/weather/last".into()),
        });
        if changed && has_control(&self.scene) {
            out.notices.push(Notice::Weather(notice_of(weather, *since)));
        }
        self.last_sent = Some(frame);
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
