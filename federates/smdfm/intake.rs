//! What an SMDFM takes in with the frames: truth as PDUs, weather, and what outsiders brought.

use super::received_truth::ReceivedTruth;
use crate::exchange::{control_records, stamp, weather_pdu};
use crate::runtime::federate::{FrameInputs, Octets};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::Frame;
use models::environment::Weather;
use models::sensors::ScanInterval;
use models::time::SimTime;
use pdu::Body;
use scenarios::Scene;
use std::sync::Arc;

/// Truth and weather as received.
pub struct Intake {
    /// The truth that the sensors look at.
    pub truth: ReceivedTruth,
    time: FrameTime,
    site: u16,
    /// By the frame in which it came: the weather and since when it is in force.
    weather: Vec<(Frame, SimTime, Weather)>,
    /// PDUs that no frame end named and that did not come through the member `visitors`.
    unstamped: u64,
}

/// What came from outside with some frames, in the order in which it counts.
#[derive(Default)]
pub struct FromOutside {
    /// PDUs of visitors that were let in.
    pub visitors: usize,
    /// Plots of somebody else's sensors.
    pub plots: Vec<stamp::StampedPlots>,
}

impl Intake {
    /// Of a scene, before anything came.
    #[must_use]
    pub fn of(scene: &Arc<Scene>, exercise: u8) -> Self {
        Self {
            truth: ReceivedTruth::new(Arc::clone(scene), exercise),
            time: FrameTime::of(&scene.run),
            site: scene.run.site,
            weather: Vec::new(),
            unstamped: 0,
        }
    }

    /// The scan that ends with a frame, `period` frames after the one before.
    #[must_use]
    pub fn interval(&self, run_seed: u64, frame: Frame, period: Frame) -> ScanInterval {
        let (from, to) = (self.time.time(frame - period), self.time.time(frame));
        ScanInterval { run_seed, scan: frame / period, from, to }
    }

    /// Takes in the PDUs of the frames up to `now`.
    pub fn take_in(&mut self, inputs: &FrameInputs, now: Frame) -> FromOutside {
        // What our own told while time stood is of no frame, and nobody's visit.
        let strange = |octets: &Octets| match pdu::pdus(octets).next() {
            Some(Ok(received)) => match received.body() {
                Body::EntityState(state) => !self.truth.is_of_scene(state.entity_id),
                body => !control_records::is_of_control(body, self.site),
            },
            _ => true,
        };
        self.unstamped += inputs.outsiders.iter().filter(|(_, o)| strange(o)).count() as u64;
        let (mut stamped, mut plots) = (Vec::new(), Vec::new());
        for (frame, octets) in &inputs.pdus {
            let frame = *frame;
            // The runtime has checked that these octets are one sound PDU.
            let Some(Ok(received)) = pdu::pdus(octets).next() else { continue };
            match received.body() {
                Body::EntityState(state) => self.truth.take(frame, now, state),
                Body::Iff(iff) => self.truth.take_answer(frame, now, iff),
                Body::EnvironmentalProcess(process) => {
                    if let Some((weather, since_s)) = weather_pdu::decode(process) {
                        let since = self.time.time(frame).plus_s(-since_s);
                        self.weather.push((frame, since, weather));
                    }
                }
                Body::EventReport(report) => {
                    stamped.extend(stamp::decode(report, self.site).map(|s| (frame, s)));
                    plots.extend(stamp::decode_plots(report, self.site).map(|s| (frame, s)));
                }
                _ => {}
            }
        }
        stamped.sort_by(|(f, a), (g, b)| {
            let key = |s: &stamp::Stamped| (s.arrival.utc_ns, s.from.ip(), s.from.port());
            f.cmp(g).then(key(a).cmp(&key(b))).then_with(|| a.octets.cmp(&b.octets))
        });
        plots.sort_by(|(f, a), (g, b)| {
            let key =
                |s: &stamp::StampedPlots| (s.arrival.utc_ns, s.sensor, s.from.ip(), s.from.port());
            f.cmp(g).then(key(a).cmp(&key(b))).then_with(|| a.octets.cmp(&b.octets))
        });
        let visitors = stamped.iter().filter(|(_, s)| self.truth.take_visitor(s)).count();
        FromOutside { visitors, plots: plots.into_iter().map(|(_, plots)| plots).collect() }
    }

    /// The weather of a scan: what was in force when it began, its cells moved by the wind since.
    pub fn weather_at(&mut self, from: Frame) -> Weather {
        let current = self.weather.iter().rposition(|(frame, ..)| *frame <= from).unwrap_or(0);
        self.weather.drain(..current);
        self.weather.first().map_or_else(Weather::default, |(_, since, weather)| {
            weather.after(self.time.time(from).since_s(*since).max(0.0))
        })
    }

    /// What was not let in, by reason.
    #[must_use]
    pub fn refused(&self) -> Vec<(String, u64)> {
        let mut refused: Vec<_> = self.truth.refused().into_iter().collect();
        if self.unstamped > 0 {
            let reason = "PDU of an outsider, not let in by the member visitors";
            refused.push((reason.into(), self.unstamped));
        }
        refused
    }
}
