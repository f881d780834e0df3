//! DIS simulation management drives the run, and hears of it.
//!
//! Start/Resume and Stop/Freeze PDUs from this host become commands; the Acknowledge goes out when the
//! state is *reached*, and a repeated request gets the same answer. The station announces its own
//! transitions with the same PDUs, so that outsiders and recordings know when a run began and ended.

use super::{Event, local};
use crate::external_world::weather_pdu::WORLD_APPLICATION;
use crate::runtime::cli::NetworkArgs;
use crate::runtime::dis_socket;
use crate::runtime::frame_time::FrameTime;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{Command, Frame};
use crate::runtime::threads::spawn_watched;
use crossbeam_channel::Sender;
use pdu::enumerations::DatumId;
use pdu::enumerations::{AcknowledgeFlag, ResponseFlag, StopReason};
use pdu::management::{Acknowledge, Comment, StartResume, StopFreeze};
use pdu::records::{ClockTime, EntityId, VariableDatum};
use pdu::{Body, Envelope};
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long a state may take to be reached before the requester is told "unable".
const REACH_WITHIN: Duration = Duration::from_secs(10);

/// Answers remembered for repeated requests.
const REMEMBERED: usize = 256;

/// The gateway between the conductor and simulation management PDUs.
pub struct Gateway {
    sender: Arc<Mutex<datalink::Sender>>,
    envelope: Arc<dyn Fn(Frame) -> Envelope + Send + Sync>,
    id: EntityId,
    time: FrameTime,
    scene: Arc<Scene>,
    seed: u64,
}

/// What the station says of a run in a Comment PDU when it begins, so that a recording explains itself.
fn comment(scene: &Scene, seed: u64) -> String {
    let (name, hash) = (&scene.name, scene.hash);
    format!("SEEDS scene={name} hash={hash:016x} seed={seed} version={}", env!("CARGO_PKG_VERSION"))
}

/// The seed in such a comment.
#[must_use]
pub fn seed_of(comment: &Comment<'_>) -> Option<u64> {
    comment.variable_datums.iter().find_map(|datum| {
        let text = std::str::from_utf8(datum.value).ok()?;
        let mut words = text.strip_prefix("SEEDS ")?.split_whitespace();
        words.find_map(|word| word.strip_prefix("seed="))?.parse().ok()
    })
}

/// What was answered to whom; `None` while the answer is awaited.
type Answered = Arc<Mutex<BTreeMap<(EntityId, u32), Option<ResponseFlag>>>>;

struct Requests {
    events: Sender<Event>,
    sender: Arc<Mutex<datalink::Sender>>,
    envelope: Arc<dyn Fn(Frame) -> Envelope + Send + Sync>,
    id: EntityId,
    answered: Answered,
    /// Sites of other runs in this exercise that were told of.
    neighbours: Arc<Mutex<BTreeSet<u16>>>,
}

impl Gateway {
    /// Opens the gateway's sockets and listens.
    ///
    /// # Errors
    /// If the data plane cannot be opened.
    pub fn open(
        args: &NetworkArgs,
        scene: &Arc<Scene>,
        exercise: u8,
        seed: u64,
        events: Sender<Event>,
    ) -> anyhow::Result<Self> {
        let config = dis_socket::link_config(args, &scene.network)?;
        let (sender, receiver) = datalink::Link::open(&config)?;
        let sender = Arc::new(Mutex::new(sender));
        let id = EntityId::new(scene.run.site, WORLD_APPLICATION, 0);
        let time = FrameTime::of(&scene.run);
        let envelope: Arc<dyn Fn(Frame) -> Envelope + Send + Sync> =
            Arc::new(move |frame| Envelope::new(exercise, time.stamp(frame)));
        let requests = Requests {
            events,
            sender: Arc::clone(&sender),
            envelope: Arc::clone(&envelope),
            id,
            answered: Arc::default(),
            neighbours: Arc::default(),
        };
        let died = requests.events.clone();
        spawn_watched(
            "the listener for DIS simulation management",
            move |why| drop(died.send(Event::Broken(why))),
            move || listen(receiver, exercise, &requests),
        )?;
        Ok(Self { sender, envelope, id, time, scene: Arc::clone(scene), seed })
    }

    /// Tells the exercise of phases that were reached.
    #[must_use]
    pub fn announcer(self) -> super::PhaseHook {
        let mut request_id = 0;
        Box::new(move |phase, frame, reason| {
            request_id += 1;
            let real_world_time = ClockTime::from_unix_nanos(crate::runtime::clock::utc_ns());
            let simulated = self.time.start_utc_ns + self.time.time(frame).0;
            let stop = |reason| StopFreeze {
                originating_id: self.id,
                receiving_id: EntityId::ALL,
                real_world_time,
                reason,
                request_id,
                ..StopFreeze::default()
            };
            let envelope = (self.envelope)(frame);
            let mut octets = Vec::new();
            let encoded = match (phase, reason) {
                (Phase::Running, _) => {
                    if frame == 0 {
                        let text = comment(&self.scene, self.seed);
                        // SISO-REF-010: datum identifiers of free text are the user's own; 0 says nothing.
                        let comment = Comment {
                            originating_id: self.id,
                            receiving_id: EntityId::ALL,
                            variable_datums: vec![VariableDatum::new(DatumId(0), text.as_bytes())]
                                .into(),
                            ..Comment::default()
                        };
                        let mut octets = Vec::new();
                        envelope.append(&comment, &mut octets).expect("one short line fits a PDU");
                        send(&self.sender, &octets);
                    }
                    let start = StartResume {
                        originating_id: self.id,
                        receiving_id: EntityId::ALL,
                        real_world_time,
                        simulation_time: ClockTime::from_unix_nanos(simulated),
                        request_id,
                    };
                    envelope.append(&start, &mut octets)
                }
                (Phase::Frozen, None) => envelope.append(&stop(StopReason::RECESS), &mut octets),
                (Phase::Frozen, Some(_)) => {
                    envelope.append(&stop(StopReason::SYSTEM_FAILURE), &mut octets)
                }
                (Phase::Stopped, _) => envelope.append(&stop(StopReason::TERMINATION), &mut octets),
                (Phase::Init | Phase::Configured, _) => return,
            };
            encoded.expect("simulation management PDUs are of fixed size");
            send(&self.sender, &octets);
        })
    }
}

fn send(sender: &Mutex<datalink::Sender>, octets: &[u8]) {
    let mut sender = sender.lock().unwrap_or_else(PoisonError::into_inner);
    if let Err(e) = sender.send(octets) {
        tracing::warn!("simulation management: {e}");
    }
}

fn listen(mut receiver: datalink::Receiver, exercise: u8, requests: &Requests) {
    loop {
        let received = receiver.receive(None, |arrival| {
            // DIS has no authentication: only this host commands.
            if !arrival.from.ip().is_loopback() {
                return;
            }
            for received in pdu::pdus(arrival.payload).filter_map(Result::ok) {
                if received.header().exercise_id == exercise {
                    requests.consider(received.body());
                }
            }
        });
        if let Err(e) = received {
            let why = format!("DIS simulation management is no longer heard: {e}");
            let _ = requests.events.send(Event::Broken(why));
            return;
        }
    }
}

impl Requests {
    fn consider(&self, body: &Body<'_>) {
        let (from, to, request_id, flag, wanted) = match body {
            Body::StartResume(s) => {
                let at = s.real_world_time.unix_nanos();
                let wanted = Ok((vec![Command::Start], at));
                (
                    s.originating_id,
                    s.receiving_id,
                    s.request_id,
                    AcknowledgeFlag::START_RESUME,
                    wanted,
                )
            }
            Body::StopFreeze(s) => {
                let commands = match s.reason {
                    StopReason::TERMINATION => vec![Command::Stop],
                    StopReason::STOP_FOR_RESET | StopReason::STOP_FOR_RESTART => {
                        vec![Command::Freeze, Command::Restart]
                    }
                    _ => vec![Command::Freeze],
                };
                // Bit 0 of the frozen behaviour: go on with the clock. This federation cannot.
                let wanted = if s.frozen_behaviour & 1 == 1 {
                    Err(())
                } else {
                    Ok((commands, s.real_world_time.unix_nanos()))
                };
                (
                    s.originating_id,
                    s.receiving_id,
                    s.request_id,
                    AcknowledgeFlag::STOP_FREEZE,
                    wanted,
                )
            }
            _ => return,
        };
        if from == self.id || !to.addresses(self.id) {
            return;
        }
        // A station tells all what its own run has reached; that is no order to another run.
        if from.application == WORLD_APPLICATION && from.entity == 0 {
            if self.neighbours.lock().unwrap_or_else(PoisonError::into_inner).insert(from.site) {
                tracing::warn!(
                    "a run of site {} is in the same DIS exercise: its entities are targets here too; --exercise N keeps runs apart",
                    from.site
                );
            }
            return;
        }
        let key = (from, request_id);
        {
            let mut answered = self.answered.lock().unwrap_or_else(PoisonError::into_inner);
            match answered.get(&key) {
                // Under way, or asked again: the same answer.
                Some(None) => return,
                Some(Some(response)) => {
                    let response = *response;
                    drop(answered);
                    self.acknowledge(from, request_id, flag, response, 0);
                    return;
                }
                None => {
                    if answered.len() >= REMEMBERED {
                        answered.pop_first();
                    }
                    answered.insert(key, None);
                }
            }
        }
        let this = Self {
            events: self.events.clone(),
            sender: Arc::clone(&self.sender),
            envelope: Arc::clone(&self.envelope),
            id: self.id,
            answered: Arc::clone(&self.answered),
            neighbours: Arc::clone(&self.neighbours),
        };
        std::thread::spawn(move || {
            let (response, frame) = match wanted {
                Err(()) => (ResponseFlag::UNABLE_TO_COMPLY, 0),
                Ok((commands, at_utc_ns)) => this.carry_out(commands, at_utc_ns, from),
            };
            let mut answered = this.answered.lock().unwrap_or_else(PoisonError::into_inner);
            answered.insert(key, Some(response));
            drop(answered);
            this.acknowledge(from, request_id, flag, response, frame);
        });
    }

    fn carry_out(
        &self,
        commands: Vec<Command>,
        at_utc_ns: i64,
        from: EntityId,
    ) -> (ResponseFlag, Frame) {
        // A real-world time in the near future is honoured.
        let ahead_ns = at_utc_ns.saturating_sub(crate::runtime::clock::utc_ns());
        if (1..60_000_000_000).contains(&ahead_ns) {
            std::thread::sleep(Duration::from_nanos(ahead_ns as u64));
        }
        let source = format!("DIS {from}");
        let mut last = None;
        for command in commands {
            tracing::info!("{source} asks: {}", format!("{command:?}").to_lowercase());
            last = local(&self.events, command, &source, REACH_WITHIN);
        }
        match last {
            Some(answer) if answer.ok => (ResponseFlag::ABLE_TO_COMPLY, answer.state.frame),
            Some(answer) => (ResponseFlag::UNABLE_TO_COMPLY, answer.state.frame),
            None => (ResponseFlag::UNABLE_TO_COMPLY, 0),
        }
    }

    fn acknowledge(
        &self,
        to: EntityId,
        request_id: u32,
        acknowledge_flag: AcknowledgeFlag,
        response_flag: ResponseFlag,
        frame: Frame,
    ) {
        let acknowledge = Acknowledge {
            originating_id: self.id,
            receiving_id: to,
            acknowledge_flag,
            response_flag,
            request_id,
        };
        let mut octets = Vec::new();
        (self.envelope)(frame)
            .append(&acknowledge, &mut octets)
            .expect("an Acknowledge is of fixed size");
        send(&self.sender, &octets);
    }
}
