//! DIS simulation management drives the run, and hears of it.
//!
//! Start/Resume, Stop/Freeze, Action Request, Set Data and Data Query PDUs from this host and those that `dis_managers` names, in both forms, become
//! commands, and those of others are counted; the answer goes out when the state is *reached*, and a repeated request gets the same answer. What is
//! about a single entity, or needs no command, is done at the desk. The station announces its own
//! transitions with the same PDUs, so that outsiders and recordings know when a run began and ended, and tells of
//! what happens in Event Reports.

use super::Event;
use super::actions::{self, Wanted, wanted};
use super::asked::{Answered, Asked, Form, Reply, RequestId, Taken, operator};
use super::created::Created;
use super::desk::{Desk, Enveloper, Out};
use crate::exchange::weather_pdu::WORLD_APPLICATION;
use crate::runtime::cli::NetworkArgs;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::dis_socket;
use crate::runtime::frame_time::FrameTime;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{Answer, Command, Frame};
use crate::runtime::senders::Managers;
use crate::runtime::threads::spawn_watched;
use crossbeam_channel::Sender;
use pdu::enumerations::DatumId;
use pdu::enumerations::{ResponseFlag, StopReason};
use pdu::management::{Comment, StartResume, StopFreeze};
use pdu::records::{ClockTime, EntityId, VariableDatum};
use pdu::{Body, EncodeError, Envelope};
use scenarios::Scene;
use std::collections::BTreeSet;
use std::net::IpAddr;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Sends a datagram.
type Post = Arc<dyn Fn(&[u8]) + Send + Sync>;

/// How often the desk looks at the clock.
const LOOK: Duration = Duration::from_millis(100);

/// The gateway between the conductor and simulation management PDUs.
pub struct Gateway {
    sender: Post,
    envelope: Enveloper,
    id: EntityId,
    desk: Arc<Mutex<Desk>>,
    time: FrameTime,
    scene: Arc<Scene>,
    seed: u64,
    refused: Arc<AtomicU64>,
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

struct Requests {
    sender: Post,
    envelope: Enveloper,
    id: EntityId,
    desk: Arc<Mutex<Desk>>,
    operator: Sender<Asked>,
    answered: Answered,
    /// Sites of other runs in this exercise that were told of.
    neighbours: BTreeSet<u16>,
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
        let sender = Mutex::new(sender);
        let sender: Post = Arc::new(move |octets: &[u8]| {
            let mut sender = sender.lock().unwrap_or_else(PoisonError::into_inner);
            if let Err(e) = sender.send(octets) {
                tracing::warn!("simulation management: {e}");
            }
        });
        let id = EntityId::new(scene.run.site, WORLD_APPLICATION, 0);
        let time = FrameTime::of(&scene.run);
        let envelope: Enveloper = Arc::new(move |frame| Envelope::new(exercise, time.stamp(frame)));
        let own = scene.traffic.entities.iter().map(|e| (e.application, e.number)).collect();
        let created = Created::new(scene.run.site, own);
        let desk = Arc::new(Mutex::new(Desk::new(id, Arc::clone(&envelope), created)));
        let answered = Answered::default();
        let mut requests = Requests {
            sender: Arc::clone(&sender),
            envelope: Arc::clone(&envelope),
            id,
            desk: Arc::clone(&desk),
            operator: operator(events.clone(), answered.clone(), replies(&sender, &envelope, id))?,
            answered,
            neighbours: BTreeSet::new(),
        };
        // DIS has no authentication: who commands beside this host is told.
        let mut managers = Managers::of(args, &scene.network, &config);
        let refused = managers.refused();
        let died = events.clone();
        spawn_watched(
            "the listener for DIS simulation management",
            move |why| drop(died.send(Event::Broken(why))),
            move || listen(receiver, &mut managers, exercise, &mut requests, &events),
        )?;
        let (clocked, send) = (Arc::clone(&desk), Arc::clone(&sender));
        std::thread::Builder::new().name("desk of DIS management".into()).spawn(move || {
            loop {
                std::thread::sleep(LOOK);
                let due = locked(&clocked).due(monotonic_ns());
                send_all(&send, due);
            }
        })?;
        Ok(Self { sender, envelope, id, desk, time, scene: Arc::clone(scene), seed, refused })
    }

    /// Requests of hosts that may not drive the run, so far.
    #[must_use]
    pub fn refused(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.refused)
    }

    /// Hears how the run stands.
    #[must_use]
    pub fn listener(&self) -> super::StateHook {
        let (desk, send) = (Arc::clone(&self.desk), Arc::clone(&self.sender));
        Box::new(move |state| {
            let news = locked(&desk).stated(monotonic_ns(), state);
            send_all(&send, news);
        })
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
            let now = (monotonic_ns(), crate::runtime::clock::utc_ns());
            let told = locked(&self.desk).reached(now, (phase, frame), reason.is_some());
            // Why a run stands is told with how it stands.
            send_all(&self.sender, told);
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

fn send(sender: &Post, octets: &[u8]) {
    sender(octets);
}

fn send_all(sender: &Post, out: Result<Out, EncodeError>) {
    match out {
        Ok(out) => out.iter().for_each(|octets| sender(octets)),
        Err(e) => tracing::warn!("simulation management: an answer was not sent: {e}"),
    }
}

fn locked(desk: &Mutex<Desk>) -> MutexGuard<'_, Desk> {
    desk.lock().unwrap_or_else(PoisonError::into_inner)
}

fn listen(
    mut receiver: datalink::Receiver,
    managers: &mut Managers,
    exercise: u8,
    requests: &mut Requests,
    events: &Sender<Event>,
) {
    loop {
        let received = receiver.receive(None, |arrival| {
            requests.hear(managers, exercise, arrival.from.ip(), arrival.payload);
        });
        if let Err(e) = received {
            let why = format!("DIS simulation management is no longer heard: {e}");
            let _ = events.send(Event::Broken(why));
            return;
        }
    }
}

impl Requests {
    /// A datagram of anybody: all of the data plane comes by here.
    fn hear(&mut self, managers: &mut Managers, exercise: u8, from: IpAddr, datagram: &[u8]) {
        let may = managers.may_command(from);
        for received in pdu::pdus(datagram).filter_map(Result::ok) {
            if received.header().exercise_id != exercise {
                continue;
            }
            if may {
                self.consider(received.body());
            } else if self.asks(received.body()) {
                managers.refuse(from);
            }
        }
    }

    /// Whether a PDU asks something of this run: what stations of other runs tell all does not.
    fn asks(&self, body: &Body<'_>) -> bool {
        let (from, to) = match body {
            Body::CreateEntity(b) => (b.originating_id, b.receiving_id),
            Body::CreateEntityR(b) => (b.originating_id, b.receiving_id),
            Body::RemoveEntity(b) => (b.originating_id, b.receiving_id),
            Body::RemoveEntityR(b) => (b.originating_id, b.receiving_id),
            _ => match wanted(body) {
                Some(wanted) => (wanted.request.from, wanted.to),
                None => return false,
            },
        };
        let station = from.application == WORLD_APPLICATION && from.entity == 0;
        !station && (to.addresses(self.id) || to.site == self.id.site)
    }

    fn consider(&mut self, body: &Body<'_>) {
        if let Some(out) = locked(&self.desk).consider(monotonic_ns(), body, &self.answered) {
            return send_all(&self.sender, out);
        }
        let Some(Wanted { request, to, commands, at_utc_ns }) = wanted(body) else { return };
        let from = request.from;
        if from == self.id || !to.addresses(self.id) {
            return;
        }
        // A station tells all what its own run has reached; that is no order to another run.
        if from.application == WORLD_APPLICATION && from.entity == 0 {
            if self.neighbours.insert(from.site) {
                tracing::warn!(
                    "a run of site {} is in the same DIS exercise: its entities are targets here too; --exercise N keeps runs apart",
                    from.site
                );
            }
            return;
        }
        let unable = ResponseFlag::UNABLE_TO_COMPLY;
        let possible = match body {
            Body::StartResume(s) => locked(&self.desk).starts_here(s.simulation_time),
            Body::StartResumeR(s) => locked(&self.desk).starts_here(s.simulation_time),
            Body::ActionRequest(a) => locked(&self.desk).takes_part(from, a.action_id),
            Body::ActionRequestR(a) => locked(&self.desk).takes_part(from, a.action_id),
            _ => true,
        };
        let commands = commands.filter(|_| possible);
        let ask = |commands| self.operator.send(Asked::new(request, commands, at_utc_ns)).is_ok();
        // How the run stands is told as it is now, however often it is asked.
        let told_anew = matches!(request.form, Form::Data | Form::DataR);
        let answer = match (self.answered.take(request), commands) {
            (Taken::UnderWay, _) => return,
            (Taken::Again(_), _) if told_anew => (!ask(vec![Command::Status])).then_some(unable),
            (Taken::Again(response), _) => response,
            (Taken::Busy, _) => Some(unable),
            (Taken::New, None) => {
                self.answered.settle(request, unable);
                Some(unable)
            }
            (Taken::New, Some(commands)) => (!ask(commands)).then_some(unable),
        };
        if let Some(response) = answer {
            reply(&self.sender, &*self.envelope, self.id, (request, response, None));
        }
    }
}

/// Sends the answer to a request.
fn replies(sender: &Post, envelope: &Enveloper, id: EntityId) -> Reply {
    let (sender, envelope) = (Arc::clone(sender), Arc::clone(envelope));
    Box::new(move |request, response, answer| {
        reply(&sender, &*envelope, id, (request, response, answer));
    })
}

fn reply(
    sender: &Post,
    envelope: &(dyn Fn(Frame) -> Envelope + Send + Sync),
    id: EntityId,
    (request, response, answer): (RequestId, ResponseFlag, Option<&Answer>),
) {
    let envelope = envelope(answer.map_or(0, |answer| answer.state.frame));
    match actions::answer(&envelope, id, request, response, answer) {
        Ok(octets) if octets.is_empty() => {}
        Ok(octets) => send(sender, &octets),
        Err(e) => tracing::warn!("simulation management: an answer was not sent: {e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::RunState;

    /// What the station tells the exercise: a phase that is reached by a fault, and how the run stands, again and again.
    #[test]
    fn a_loss_is_told_once() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("a scene");
        let scene = Arc::new(scene);
        let sent = Arc::new(Mutex::new(Vec::<Vec<u8>>::new()));
        let to = Arc::clone(&sent);
        let time = FrameTime::of(&scene.run);
        let envelope: Enveloper = Arc::new(move |frame| Envelope::new(1, time.stamp(frame)));
        let id = EntityId::new(1, WORLD_APPLICATION, 0);
        let created = Created::new(1, std::collections::BTreeSet::new());
        let gateway = Gateway {
            sender: Arc::new(move |octets: &[u8]| {
                to.lock().unwrap_or_else(PoisonError::into_inner).push(octets.to_vec());
            }),
            desk: Arc::new(Mutex::new(Desk::new(id, Arc::clone(&envelope), created))),
            envelope,
            id,
            time: FrameTime::of(&scene.run),
            scene,
            seed: 1,
            refused: Arc::default(),
        };
        let (mut stated, reason) = (gateway.listener(), "smdfm is lost: it is gone");
        let mut reached = gateway.announcer();
        let state = |phase, reasons: &[&str]| RunState {
            phase,
            run: 1,
            frame: 40,
            step_ns: 50_000_000,
            reasons: reasons.iter().map(|r| (*r).to_owned()).collect(),
            ..RunState::default()
        };
        stated(&state(Phase::Running, &[]));
        stated(&state(Phase::Running, &[reason]));
        reached(Phase::Frozen, 40, Some(reason));
        (0..3).for_each(|_| stated(&state(Phase::Frozen, &[reason])));
        let sent = sent.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let of = |kind: &dyn Fn(&Body<'_>) -> bool| {
            let sound = sent.iter().flat_map(|octets| pdu::pdus(octets).filter_map(Result::ok));
            sound.filter(|received| kind(received.body())).count()
        };
        assert_eq!(of(&|body| matches!(body, Body::EventReport(_))), 1);
        assert_eq!(of(&|body| matches!(body, Body::StopFreeze(_))), 1, "and that time stands");
    }

    /// One that runs on this host sends from the interface of the federation, which need not be loopback; what others ask is counted, and nothing
    /// else that comes by.
    #[test]
    fn who_asks_and_may_not_is_counted() {
        let id = EntityId::new(1, WORLD_APPLICATION, 0);
        let envelope: Enveloper = Arc::new(|_| Envelope::new(1, pdu::DisTime::default()));
        let created = Created::new(1, BTreeSet::new());
        let (operator, asked) = crossbeam_channel::unbounded();
        let mut requests = Requests {
            sender: Arc::new(|_: &[u8]| {}),
            desk: Arc::new(Mutex::new(Desk::new(id, Arc::clone(&envelope), created))),
            envelope: Arc::clone(&envelope),
            id,
            operator,
            answered: Answered::default(),
            neighbours: BTreeSet::new(),
        };
        let ip = |text: &str| text.parse::<IpAddr>().expect("an address");
        let mut managers = Managers::new(Vec::new(), vec![ip("10.0.0.1")]);
        let refused = managers.refused();
        let mut stop = |from: EntityId, to, request_id, host| {
            let stop = StopFreeze {
                originating_id: from,
                receiving_id: to,
                reason: StopReason::RECESS,
                request_id,
                ..StopFreeze::default()
            };
            let mut octets = Vec::new();
            envelope(0).append(&stop, &mut octets).expect("of fixed size");
            requests.hear(&mut managers, 1, ip(host), &octets);
            let count = refused.load(std::sync::atomic::Ordering::Relaxed);
            (asked.try_iter().count(), count)
        };
        let (tool, all) = (EntityId::new(9, 7, 0), EntityId::ALL);
        assert_eq!(stop(tool, all, 1, "10.0.0.1"), (1, 0), "this host");
        assert_eq!(stop(tool, all, 2, "10.0.0.9"), (0, 1), "another one");
        assert_eq!(stop(tool, id, 3, "10.0.0.9"), (0, 2));
        let station = EntityId::new(2, WORLD_APPLICATION, 0);
        assert_eq!(stop(station, all, 4, "10.0.0.9"), (0, 2), "what another run tells");
        let other = EntityId::new(5, WORLD_APPLICATION, 0);
        assert_eq!(stop(tool, other, 5, "10.0.0.9"), (0, 2), "asked of another run");
    }

    /// A tool whose requests all have the number 1.
    #[test]
    fn what_is_asked_under_a_number_of_before_is_carried_out() {
        let id = EntityId::new(1, WORLD_APPLICATION, 0);
        let envelope: Enveloper = Arc::new(|_| Envelope::new(1, pdu::DisTime::default()));
        let created = Created::new(1, BTreeSet::new());
        let (operator, asked) = crossbeam_channel::unbounded();
        let mut requests = Requests {
            sender: Arc::new(|_: &[u8]| {}),
            desk: Arc::new(Mutex::new(Desk::new(id, Arc::clone(&envelope), created))),
            envelope,
            id,
            operator,
            answered: Answered::default(),
            neighbours: BTreeSet::new(),
        };
        let (originating_id, request_id) = (EntityId::new(9, 7, 0), 1);
        let stop = StopFreeze {
            originating_id,
            receiving_id: id,
            reason: StopReason::RECESS,
            request_id,
            ..StopFreeze::default()
        };
        let start = StartResume {
            originating_id,
            receiving_id: id,
            request_id,
            real_world_time: ClockTime::default(),
            simulation_time: ClockTime::default(),
        };
        let ended = StopFreeze { reason: StopReason::TERMINATION, ..stop };
        let bodies = [Body::from(stop), Body::from(start), Body::from(ended)];
        for body in bodies.iter().flat_map(|body| [(body, 1), (body, 0)]) {
            requests.consider(body.0);
            assert_eq!(asked.try_iter().count(), body.1, "{body:?}");
        }
    }

    #[test]
    fn only_this_host_commands() {
        for (from, may) in [
            ("127.0.0.1", true),
            ("127.3.2.1", true),
            ("::1", true),
            ("10.0.0.7", false),
            ("0.0.0.0", false),
            ("::ffff:10.0.0.7", false),
        ] {
            assert_eq!(
                Managers::default().may_command(from.parse().expect("an address")),
                may,
                "{from}"
            );
        }
    }
}
