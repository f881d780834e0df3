//! Requests of DIS simulation management on their way: one thread for all of them, however many there are.
//!
//! A request that names a time in the near future waits for it; one whose time has come is a command to the
//! conductor, and its answer goes out when the state is reached. At most [`PENDING`] are on their way at once; what
//! comes beyond is answered "unable" and may be asked again.

use super::Event;
use crate::runtime::clock::{monotonic_ns, utc_ns};
use crate::runtime::digest::pdu_hash;
use crate::runtime::messages::{Answer, Command};
use crate::runtime::threads::spawn_watched;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError, bounded};
use pdu::enumerations::{AcknowledgeFlag, RequestStatus, ResponseFlag};
use pdu::records::{ClockTime, EntityId};
use pdu::{Body, DisTime, Envelope};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Requests on their way at once, at most.
pub(super) const PENDING: usize = 64;

/// How long a state may take to be reached before the requester is told "unable".
const REACH_WITHIN_NS: u64 = 10_000_000_000;

/// Answers remembered for repeated requests.
const REMEMBERED: usize = 256;

/// How far ahead a time is honoured; farther away it is taken for a wrong clock, and the request for due.
const AHEAD_NS: i64 = 60_000_000_000;

/// How often answers that are awaited are looked for.
const LOOK: Duration = Duration::from_millis(2);

/// What tells one request from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RequestId {
    /// Who asks.
    pub(super) from: EntityId,
    /// Its number.
    pub(super) request_id: u32,
    /// A hash of all that it asks: tools that begin again, or never count, have used the number before.
    pub(super) asked: u64,
    /// How it is answered.
    pub(super) form: Form,
}

impl RequestId {
    /// Of a request as it came.
    pub(super) fn new(from: EntityId, request_id: u32, form: Form, body: &Body<'_>) -> Self {
        let (mut octets, mut body) = (Vec::new(), body.clone());
        // The time of sending is not what is asked.
        match &mut body {
            Body::StartResume(b) => b.real_world_time = ClockTime::default(),
            Body::StartResumeR(b) => b.real_world_time = ClockTime::default(),
            Body::StopFreeze(b) => b.real_world_time = ClockTime::default(),
            Body::StopFreezeR(b) => b.real_world_time = ClockTime::default(),
            _ => {}
        }
        // What was decoded can be encoded.
        let _ = Envelope::new(0, DisTime::default()).append(&body, &mut octets);
        Self { from, request_id, asked: pdu_hash(&octets), form }
    }

    /// What a repeated request has in common with the one before.
    pub(super) fn key(&self) -> Key {
        (self.from, self.request_id, self.asked)
    }
}

/// What tells one request from another: who asks, its number, and what it asks.
pub(super) type Key = (EntityId, u32, u64);

/// The PDU that answers a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Form {
    /// Acknowledge, as what.
    Acknowledge(AcknowledgeFlag),
    /// Acknowledge-R, as what.
    AcknowledgeR(AcknowledgeFlag),
    /// Action Response, with what it says where it is refused.
    Action(RequestStatus),
    /// Action Response-R, the same.
    ActionR(RequestStatus),
    /// Data.
    Data,
    /// Data-R.
    DataR,
    /// None is wanted.
    Silent,
}

/// Sends an answer: to which request, which, and how the run stands.
pub(super) type Reply = Box<dyn Fn(RequestId, ResponseFlag, Option<&Answer>) + Send>;

/// What was answered to whom.
#[derive(Clone, Default)]
pub(super) struct Answered(Arc<Mutex<Answers>>);

#[derive(Default)]
struct Answers {
    /// `None` while the answer is awaited.
    by_request: BTreeMap<Key, Option<ResponseFlag>>,
    /// Those that have an answer, the oldest first.
    settled: VecDeque<Key>,
    pending: usize,
}

/// What a request is to those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// Nobody asked this before; it counts as on its way from now on.
    New,
    /// It is on its way: no answer yet.
    UnderWay,
    /// It was asked before: the same answer.
    Again(Option<ResponseFlag>),
    /// Too many are on their way.
    Busy,
}

impl Answered {
    /// Takes a request.
    pub(super) fn take(&self, request: RequestId) -> Taken {
        let mut answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = request.key();
        match answers.by_request.get(&key) {
            Some(None) => Taken::UnderWay,
            Some(Some(response)) => Taken::Again(Some(*response)),
            None if answers.pending >= PENDING => Taken::Busy,
            None => {
                // What was answered under this number is over: asked again after this it is another request.
                let other = |of: &Key| (of.0, of.1) == (key.0, key.1);
                answers.by_request.retain(|of, answer| answer.is_none() || !other(of));
                answers.settled.retain(|of| !other(of));
                answers.pending += 1;
                answers.by_request.insert(key, None);
                Taken::New
            }
        }
    }

    /// Whether this was asked before.
    pub(super) fn knows(&self, request: RequestId) -> bool {
        let answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        answers.by_request.contains_key(&request.key())
    }

    /// Notes the answer to a request taken before.
    pub(super) fn settle(&self, request: RequestId, response: ResponseFlag) {
        let mut answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = request.key();
        if answers.by_request.insert(key, Some(response)) == Some(None) {
            answers.pending -= 1;
            answers.settled.push_back(key);
        }
        while answers.settled.len() > REMEMBERED {
            if let Some(oldest) = answers.settled.pop_front() {
                answers.by_request.remove(&oldest);
            }
        }
    }
}

/// A request on its way.
pub(super) struct Asked {
    request: RequestId,
    commands: VecDeque<Command>,
    due_utc_ns: i64,
    /// The answer awaited, and until when.
    awaited: Option<(Receiver<Answer>, u64)>,
    last: Option<Answer>,
}

impl Asked {
    /// A request for `commands`, one after the other, at the real-world time `at_utc_ns` if that is near.
    pub(super) fn new(request: RequestId, commands: Vec<Command>, at_utc_ns: i64) -> Self {
        let (commands, now) = (commands.into(), utc_ns());
        let ahead = (1..AHEAD_NS).contains(&at_utc_ns.saturating_sub(now));
        let due_utc_ns = if ahead { at_utc_ns } else { now };
        Self { request, commands, due_utc_ns, awaited: None, last: None }
    }

    /// Goes on; the response when there is nothing more to do.
    fn advance(&mut self, events: &Sender<Event>) -> Option<ResponseFlag> {
        if let Some((answer, until)) = &self.awaited {
            match answer.try_recv() {
                Ok(answer) => self.last = Some(answer),
                Err(TryRecvError::Empty) if monotonic_ns() < *until => return None,
                Err(_) => return Some(ResponseFlag::UNABLE_TO_COMPLY),
            }
            self.awaited = None;
        }
        let Some(command) = self.commands.pop_front() else {
            return Some(match &self.last {
                Some(answer) if answer.ok => ResponseFlag::ABLE_TO_COMPLY,
                _ => ResponseFlag::UNABLE_TO_COMPLY,
            });
        };
        let source = format!("DIS {}", self.request.from);
        tracing::info!("{source} asks: {}", format!("{command:?}").to_lowercase());
        let (answer, wait) = bounded(1);
        self.awaited = Some((wait, monotonic_ns() + REACH_WITHIN_NS));
        let sent = events.send(Event::Local(command, source, answer)).is_ok();
        if sent { None } else { Some(ResponseFlag::UNABLE_TO_COMPLY) }
    }
}

/// Starts the thread that carries requests out; requests go into the sender returned.
///
/// # Errors
/// If the system gives no thread.
pub(super) fn operator(
    events: Sender<Event>,
    answered: Answered,
    reply: Reply,
) -> std::io::Result<Sender<Asked>> {
    let (send, receive) = bounded::<Asked>(PENDING);
    let died = events.clone();
    let broken = move |why| drop(died.send(Event::Broken(why)));
    spawn_watched("the operator of DIS simulation management", broken, move || {
        let mut pending: Vec<Asked> = Vec::new();
        loop {
            let waking = match pending.iter().map(|asked| asked.due_utc_ns).min() {
                None => receive.recv().map_err(|_| RecvTimeoutError::Disconnected),
                Some(due) => {
                    let ahead = Duration::from_nanos((due - utc_ns()).max(0) as u64);
                    receive.recv_timeout(ahead.max(LOOK))
                }
            };
            match waking {
                Ok(asked) => pending.push(asked),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let now = utc_ns();
            pending.retain_mut(|asked| {
                if asked.due_utc_ns > now {
                    return true;
                }
                let Some(response) = asked.advance(&events) else { return true };
                answered.settle(asked.request, response);
                reply(asked.request, response, asked.last.as_ref());
                false
            });
        }
    })?;
    Ok(send)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam_channel::unbounded;

    fn request(number: u32) -> RequestId {
        RequestId {
            from: EntityId::new(77, 1, 0),
            request_id: number,
            asked: 0,
            form: Form::Acknowledge(AcknowledgeFlag::STOP_FREEZE),
        }
    }

    fn threads() -> usize {
        std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
    }

    #[test]
    fn twenty_thousand_dated_stops_take_one_thread_and_sixty_four_places() {
        let (events, _conductor) = unbounded();
        let answered = Answered::default();
        let before = threads();
        let operator =
            operator(events, answered.clone(), Box::new(|_, _, _| {})).expect("a thread");
        let soon = utc_ns() + 50_000_000_000;
        let mut refused = 0;
        for number in 0..20_000 {
            match answered.take(request(number)) {
                Taken::New => {
                    operator.send(Asked::new(request(number), vec![Command::Stop], soon)).unwrap();
                }
                Taken::Busy => refused += 1,
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(refused, 20_000 - PENDING);
        // Other tests of this process have threads of their own.
        assert!(threads() < before + 500, "{} threads", threads());
    }

    #[test]
    fn a_dated_request_waits_and_an_answer_frees_its_place() {
        let (events, conductor) = unbounded();
        let answered = Answered::default();
        let (told, hear) = unbounded();
        let reply: Reply = Box::new(move |request, response, _| {
            told.send((request.request_id, response)).expect("told");
        });
        let operator = operator(events, answered.clone(), reply).expect("a thread");
        let later = utc_ns() + 200_000_000;
        for (number, at) in [(1, later), (2, 0)] {
            assert_eq!(answered.take(request(number)), Taken::New);
            assert_eq!(answered.take(request(number)), Taken::UnderWay);
            let commands = vec![Command::Freeze, Command::Restart];
            operator.send(Asked::new(request(number), commands, at)).expect("sent");
        }
        let able = Answer { ok: true, text: String::new(), state: Default::default() };
        let mut order = Vec::new();
        for _ in 0..4 {
            match conductor.recv_timeout(Duration::from_secs(20)).expect("a command") {
                Event::Local(command, source, answer) => {
                    assert_eq!(source, "DIS 77:1:0");
                    order.push(command);
                    answer.send(able.clone()).expect("answered");
                }
                _ => panic!("another event"),
            }
        }
        assert!(utc_ns() >= later, "the dated one waited");
        assert_eq!(order, [Command::Freeze, Command::Restart, Command::Freeze, Command::Restart]);
        for number in [2, 1] {
            let heard = hear.recv_timeout(Duration::from_secs(20)).expect("an answer");
            assert_eq!(heard, (number, ResponseFlag::ABLE_TO_COMPLY));
            let again = answered.take(request(number));
            assert_eq!(again, Taken::Again(Some(ResponseFlag::ABLE_TO_COMPLY)));
        }
        // Answers are forgotten one day; their places are free.
        for number in 100..1_000 {
            assert_eq!(answered.take(request(number)), Taken::New, "{number}");
            answered.settle(request(number), ResponseFlag::UNABLE_TO_COMPLY);
        }
        assert_eq!(answered.take(request(1)), Taken::New);
    }
}
