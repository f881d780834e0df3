//! The member `visitors`: lets outsiders in, each PDU stamped into a frame.
//!
//! It hears the UDP of everybody; what is not of the federation and about an entity of others waits at
//! the [`door`] for the next frame, and goes into it as an Event Report ([`stamp`]) with the time of
//! its arrival ([`pace`]). Consumers take outsiders from there and nowhere else: equal stamps give
//! equal runs, and a recording of them is the run. Plots of real sensors ([`plots`]) come in alike.

pub mod command;
pub mod door;
pub mod pace;
pub mod plots;
pub mod seats;

use crate::exchange::stamp::{self, Stamped};
use crate::exchange::{driven, handover};
use crate::runtime::clock::utc_ns;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FederateStatus, FinalReport, Frame, Kind, Notice, RunConfig};
use door::Door;
use pace::Pace;
use pdu::Envelope;
use pdu::exercise::Arrival;
use plots::PlotDoor;
use scenarios::Scene;
use seats::SeatDoor;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The federate's logic.
pub struct Visitors {
    scene: Arc<Scene>,
    exercise: u8,
    time: FrameTime,
    door: SharedDoor,
    plots: SharedPlots,
    seats: SharedSeats,
    pace: Pace,
    admitted: u64,
    /// UTC and what was refused when it was last said.
    said: (i64, u64),
}

/// The door for plots as the threads of the sockets and the federate share it.
#[derive(Clone)]
pub struct SharedPlots(Arc<Mutex<PlotDoor>>);

impl SharedPlots {
    /// The door, to knock at it.
    pub fn lock(&self) -> MutexGuard<'_, PlotDoor> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The door for people at seats, as the threads of the bus and the federate share it.
#[derive(Clone)]
pub struct SharedSeats(Arc<Mutex<SeatDoor>>);

impl SharedSeats {
    /// The door, to ask at it.
    pub fn lock(&self) -> MutexGuard<'_, SeatDoor> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The door as the thread of the socket and the federate share it.
#[derive(Clone)]
pub struct SharedDoor(Arc<Mutex<Door>>);

impl SharedDoor {
    /// The door, to knock at it.
    pub fn lock(&self) -> MutexGuard<'_, Door> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Visitors {
    /// The member of a scene.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8) -> Self {
        let own = scene.traffic.entities.iter().map(|e| (e.application, e.number)).collect();
        let door = Door::new(exercise, scene.run.site, own)
            .with_targets(scene.run.targets_max.unwrap_or(usize::MAX));
        Self {
            time: FrameTime::of(&scene.run),
            exercise,
            door: SharedDoor(Arc::new(Mutex::new(door))),
            plots: SharedPlots(Arc::new(Mutex::new(PlotDoor::new(&scene)))),
            seats: SharedSeats(Arc::new(Mutex::new(SeatDoor::new(&scene)))),
            pace: Pace::default(),
            admitted: 0,
            said: (0, 0),
            scene,
        }
    }

    /// Where datagrams are handed in.
    #[must_use]
    pub fn door(&self) -> SharedDoor {
        self.door.clone()
    }

    /// Where plots of real sensors are handed in.
    #[must_use]
    pub fn plots(&self) -> SharedPlots {
        self.plots.clone()
    }

    /// Where people at seats are heard.
    #[must_use]
    pub fn seats(&self) -> SharedSeats {
        self.seats.clone()
    }

    fn frame(&mut self, frame: Frame, now_utc_ns: i64, out: &mut FrameOut) {
        let time_ns = self.time.start_utc_ns.saturating_add(self.time.time(frame).0);
        self.pace.executed(time_ns, now_utc_ns);
        let rate = self.pace.at(now_utc_ns).map_or(1.0, |(_, rate)| rate);
        let said = {
            let mut seats = self.seats.lock();
            seats.paced(rate);
            seats.admit(frame, now_utc_ns)
        };
        for mut input in said {
            // What is driven moves a little later, so that nobody waits for this frame; who is handed over, likewise.
            let given = input.order.seat == handover::SEAT;
            if given {
                let now = time_ns;
                input.order.action = handover::timed(input.order.action, |utc_ns| {
                    let at_ns = self.pace.at(utc_ns).map_or(now, |(at_ns, _)| at_ns);
                    at_ns.saturating_sub(self.time.start_utc_ns)
                });
            }
            if given || driven::wheel_of(&self.scene, &input.order.seat).is_some() {
                let effect = frame + driven::delay_frames(&self.scene);
                out.later.push((effect, Notice::Seat(input)));
            } else {
                out.notices.push(Notice::Seat(input));
            }
        }
        let (admitted, refused) = {
            let mut door = self.door.lock();
            (door.admit(now_utc_ns), door.refused().values().sum::<u64>())
        };
        let (plots, plots_refused) = {
            let mut door = self.plots.lock();
            (door.admit(now_utc_ns), door.refused().values().sum::<u64>())
        };
        let refused = refused + plots_refused;
        let envelope = Envelope::new(self.exercise, self.time.stamp(frame));
        let arrival = |utc_ns: i64| {
            let (time_ns, rate) = self.pace.at(utc_ns).unwrap_or((time_ns, 1.0));
            Arrival { time_ns, utc_ns, rate }
        };
        for waiting in plots {
            let arrival = arrival(waiting.utc_ns);
            let stamped = waiting.stamped(arrival);
            if let Ok(octets) = stamp::encode_plots(self.scene.run.site, &envelope, &stamped) {
                out.pdus.push(octets.into());
            }
        }
        for waiting in admitted {
            let arrival = arrival(waiting.utc_ns);
            let stamped = Stamped { arrival, from: waiting.from, octets: waiting.octets };
            // The door lets nothing in that would not fit.
            if let Ok(octets) = stamp::encode(self.scene.run.site, &envelope, &stamped) {
                self.admitted += 1;
                out.pdus.push(octets.into());
            }
        }
        // A flood's own PDUs are a reason to speak; noise of every network is not.
        if refused > self.said.1 + 1000 && now_utc_ns > self.said.0 + 10_000_000_000 {
            let reasons = self.reasons();
            tracing::warn!("visitors: {} PDUs of outsiders refused so far: {reasons}", refused);
            self.said = (now_utc_ns, refused);
        }
    }

    fn reasons(&self) -> String {
        let (door, plots) = (self.door.lock(), self.plots.lock());
        let all = door.refused().iter().chain(plots.refused());
        all.map(|(reason, count)| format!("{count} {reason}")).collect::<Vec<_>>().join(", ")
    }
}

impl Federate for Visitors {
    fn kind(&self) -> Kind {
        Kind::Visitors
    }

    fn live(&self) -> bool {
        true
    }

    fn configure(&mut self, _config: &RunConfig, _out: &mut FrameOut) -> Result<(), String> {
        self.door.lock().clear();
        self.plots.lock().clear();
        self.seats.lock().clear();
        self.pace = Pace::default();
        self.admitted = 0;
        self.said = (0, 0);
        Ok(())
    }

    fn step(&mut self, frame: Frame, _inputs: &FrameInputs, out: &mut FrameOut) {
        self.frame(frame, utc_ns(), out);
    }

    fn finish(&mut self, report: &mut FinalReport) {
        let door = self.door.lock();
        report.values.push(("visitor_pdus_heard".into(), door.heard() as f64));
        report.values.push(("visitor_pdus_admitted".into(), self.admitted as f64));
        report.values.push(("plot_datagrams_heard".into(), self.plots.lock().heard() as f64));
    }

    fn status(&self, status: &mut FederateStatus) {
        let door = self.door.lock();
        status.pdus_in = door.heard();
        let plots = self.plots.lock();
        let refused = door.refused().iter().chain(plots.refused());
        status.dropped.extend(refused.map(|(reason, count)| ((*reason).to_owned(), *count)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pdu::records::EntityId;
    use pdu::{Body, DisTime, EntityState};

    #[test]
    fn what_arrives_is_in_the_next_frame_with_its_time() {
        let scene =
            Arc::new(scenarios::load_without_truth(&scenarios::locate("zurich")).expect("zurich"));
        let mut visitors = Visitors::new(Arc::clone(&scene), 1);
        let start = scene.run.start_utc_ns;
        let utc = |frame: i64| 1_700_000_000_000_000_000 + frame * 12_500_000;
        let mut octets = Vec::new();
        let guest = EntityState { entity_id: EntityId::new(9, 9, 9), ..EntityState::default() };
        Envelope::new(1, DisTime(1)).append(&guest, &mut octets).expect("fits");
        for frame in 1..200 {
            let mut out = FrameOut::default();
            if frame == 150 {
                let from = "10.0.0.1:3000".parse().expect("an address");
                visitors.door().lock().knock(utc(149) + 5_000_000, from, &octets);
            }
            visitors.frame(frame as Frame, utc(frame), &mut out);
            assert_eq!(out.pdus.len(), usize::from(frame == 150));
            for report in out.pdus {
                let received = pdu::pdus(&report).next().expect("one").expect("sound");
                let Body::EventReport(body) = received.body() else { panic!("a report") };
                let stamped = stamp::decode(body, scene.run.site).expect("stamped");
                assert_eq!(stamped.octets, octets);
                // Rate 4: 5 ms after frame 149 are 20 ms of the exercise.
                let expected = start + 149 * scene.run.frame.0 + 20_000_000;
                assert!((stamped.arrival.time_ns - expected).abs() < 100_000);
                assert!((stamped.arrival.rate - 4.0).abs() < 1e-3);
            }
        }
    }
}
