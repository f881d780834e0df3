//! The desk of DIS simulation management: what needs no command to the conductor. Entities that others have created,
//! participants that are told of phases by themselves, queries that are answered again and again, and what is
//! worth an Event Report.
//!
//! No I/O and no clock: bodies and times in, octets out. It knows the run as the conductor last told it.

use super::asked::{Answered, Form, Key, RequestId, Taken};
use super::created::{self, Created};
use super::participants::Participants;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{Frame, RunState};
use pdu::enumerations::{
    AcknowledgeFlag, ActionId, DatumId, EventType, Reliability, ResponseFlag, StopReason,
};
use pdu::management::{Acknowledge, Data, EventReport};
use pdu::records::{ClockTime, EntityId, FixedDatum, VariableDatum};
use pdu::reliable::{AcknowledgeR, DataR, StartResumeR, StopFreezeR};
use pdu::{Body, EncodeBody, EncodeError, Envelope, List};
use std::collections::VecDeque;
use std::sync::Arc;

/// The head of a PDU of a frame.
pub(super) type Enveloper = Arc<dyn Fn(Frame) -> Envelope + Send + Sync>;

/// Queries that are answered again and again, at most; each for so long after it was last asked, and not more often.
const QUERIES: usize = 16;
const QUERY_FOR_NS: u64 = 600_000_000_000;
const QUERY_EVERY_NS: u64 = 200_000_000;

/// Answers to Set Data about an entity that are remembered for requests that are repeated.
const ECHOES: usize = 64;

/// Less than this share of the rate that was asked for, for so long, is late; from the second on it is not any more.
const LATE: f64 = 0.9;
const IN_TIME: f64 = 0.97;
const LATE_AFTER_NS: u64 = 3_000_000_000;

/// Reasons that are remembered as told.
const TOLD: usize = 64;

/// Numbers of own requests to participants begin here.
const OWN_REQUESTS: u32 = 0x8000_0000;

/// Datagrams to send.
pub(super) type Out = Vec<Vec<u8>>;

struct Query {
    request: RequestId,
    about: Option<EntityId>,
    wanted: Vec<DatumId>,
    every_ns: u64,
    next_ns: u64,
    until_ns: u64,
}

/// A request, whom it is addressed to, and what about an entity it asks for.
struct About<'a> {
    request: RequestId,
    to: EntityId,
    what: What<'a>,
}

enum What<'a> {
    Create,
    Remove,
    Freeze(bool),
    Set(&'a List<'a, FixedDatum>, &'a List<'a, VariableDatum<'a>>),
    Ask(&'a List<'a, DatumId>, u64),
}

/// The desk.
pub(super) struct Desk {
    id: EntityId,
    envelope: Enveloper,
    state: RunState,
    created: Created,
    participants: Participants,
    queries: Vec<Query>,
    echoes: VecDeque<(Key, Vec<u8>)>,
    next_request: u32,
    /// Reasons that were told of.
    told: Vec<String>,
    /// Since when the run is too slow, and whether that was told.
    slow: (Option<u64>, bool),
}

impl Desk {
    /// The desk of the station `id`.
    pub(super) fn new(id: EntityId, envelope: Enveloper, created: Created) -> Self {
        Self {
            id,
            envelope,
            state: RunState::default(),
            created,
            participants: Participants::default(),
            queries: Vec::new(),
            echoes: VecDeque::new(),
            next_request: OWN_REQUESTS,
            told: Vec::new(),
            slow: (None, false),
        }
    }

    fn step_s(&self) -> f64 {
        self.state.step_ns as f64 * 1e-9
    }

    fn encoded(&self, body: &impl EncodeBody) -> Result<Vec<u8>, EncodeError> {
        let mut octets = Vec::new();
        (self.envelope)(self.state.frame).append(body, &mut octets)?;
        Ok(octets)
    }

    /// Joins and resigns; true if that could be done.
    pub(super) fn takes_part(&mut self, from: EntityId, action: ActionId) -> bool {
        match action {
            ActionId::JOIN_EXERCISE => return self.participants.join(from),
            ActionId::RESIGN_EXERCISE => self.participants.resign(from),
            _ => {}
        }
        true
    }

    /// Whether a start at simulated time `simulation_time` is one from where the run stands; zero says nothing of it.
    pub(super) fn starts_here(&self, simulation_time: ClockTime) -> bool {
        let at_ns = self.state.start_utc_ns + self.state.frame as i64 * self.state.step_ns;
        let off_ns = i128::from(simulation_time.unix_nanos()) - i128::from(at_ns);
        let silent = simulation_time == ClockTime::default();
        let stands = matches!(self.state.phase, Phase::Configured | Phase::Frozen);
        silent || !stands || 2 * off_ns.abs() <= i128::from(self.state.step_ns)
    }

    /// A PDU that is about an entity, or a query that names what it wants; none if it is for the conductor.
    pub(super) fn consider(
        &mut self,
        now_ns: u64,
        body: &Body<'_>,
        answered: &Answered,
    ) -> Option<Result<Out, EncodeError>> {
        match body {
            Body::Acknowledge(a) => {
                return Some(self.acknowledged(a.originating_id, a.request_id, a.response_flag));
            }
            Body::AcknowledgeR(a) => {
                return Some(self.acknowledged(a.originating_id, a.request_id, a.response_flag));
            }
            _ => {}
        }
        let About { request, to, what } = about(body)?;
        if request.from == self.id {
            return None;
        }
        let (frame, step_s) = (self.state.frame, self.step_s());
        match what {
            What::Create if self.created.ours(to) || to == self.id => {
                let there = self.state.members.iter().any(|m| m.alive && m.name == "visitors");
                let phase = self.state.phase;
                let lives = matches!(phase, Phase::Configured | Phase::Running | Phase::Frozen);
                Some(self.once(request, answered, |desk| {
                    (there && lives && desk.created.create(to), Vec::new())
                }))
            }
            What::Remove if self.created.is_own(to) => {
                Some(self.once(request, answered, |_| (false, Vec::new())))
            }
            What::Remove => {
                let envelope = (self.envelope)(frame);
                let told = answered.knows(request);
                match self.created.remove(to, frame, (step_s, &envelope)) {
                    Some(Ok(last)) => Some(self.once(request, answered, |_| (true, last))),
                    Some(Err(e)) => Some(Err(e)),
                    // Removed before: the same answer. Others' entities are theirs to acknowledge.
                    None if told => Some(self.once(request, answered, |_| (false, Vec::new()))),
                    None => None,
                }
            }
            What::Freeze(_) if self.created.is_own(to) => {
                Some(self.once(request, answered, |_| (false, Vec::new())))
            }
            What::Freeze(frozen) if self.created.has(to) => {
                Some(self.once(request, answered, |desk| {
                    desk.created.freeze(to, frozen, frame, step_s);
                    (true, Vec::new())
                }))
            }
            What::Set(fixed, variable) if self.created.has(to) => {
                Some(self.set(request, to, fixed, variable))
            }
            What::Ask(wanted, every_ns) if self.created.has(to) => {
                Some(self.ask(now_ns, request, Some(to), (wanted.iter().collect(), every_ns)))
            }
            What::Ask(wanted, every_ns)
                if to.addresses(self.id) && (every_ns > 0 || !wanted.is_empty()) =>
            {
                Some(self.ask(now_ns, request, None, (wanted.iter().collect(), every_ns)))
            }
            _ => None,
        }
    }

    /// Carries a request out once; a repeated one gets the same acknowledgement.
    fn once(
        &mut self,
        request: RequestId,
        answered: &Answered,
        act: impl FnOnce(&mut Self) -> (bool, Out),
    ) -> Result<Out, EncodeError> {
        let mut out = Vec::new();
        let response = match answered.take(request) {
            Taken::UnderWay => return Ok(out),
            Taken::Again(response) => response,
            Taken::Busy => Some(ResponseFlag::UNABLE_TO_COMPLY),
            Taken::New => {
                let (able, sent) = act(self);
                out = sent;
                let response = match able {
                    true => ResponseFlag::ABLE_TO_COMPLY,
                    false => ResponseFlag::UNABLE_TO_COMPLY,
                };
                answered.settle(request, response);
                Some(response)
            }
        };
        if let Some(response) = response {
            out.extend(self.acknowledge(request, response)?);
        }
        Ok(out)
    }

    fn acknowledge(
        &self,
        request: RequestId,
        response_flag: ResponseFlag,
    ) -> Result<Option<Vec<u8>>, EncodeError> {
        let RequestId { from: receiving_id, request_id, form, .. } = request;
        let originating_id = self.id;
        let octets = match form {
            Form::Acknowledge(acknowledge_flag) => self.encoded(&Acknowledge {
                originating_id,
                receiving_id,
                acknowledge_flag,
                response_flag,
                request_id,
            })?,
            Form::AcknowledgeR(acknowledge_flag) => self.encoded(&AcknowledgeR {
                originating_id,
                receiving_id,
                acknowledge_flag,
                response_flag,
                request_id,
            })?,
            _ => return Ok(None),
        };
        Ok(Some(octets))
    }

    fn set(
        &mut self,
        request: RequestId,
        id: EntityId,
        fixed: &List<'_, FixedDatum>,
        variable: &List<'_, VariableDatum<'_>>,
    ) -> Result<Out, EncodeError> {
        let key = request.key();
        if let Some((_, octets)) = self.echoes.iter().find(|(of, _)| *of == key) {
            return Ok(vec![octets.clone()]);
        }
        self.echoes.retain(|(of, _)| (of.0, of.1) != (key.0, key.1));
        let at = (self.state.frame, self.step_s());
        let taken = self.created.set(id, at, fixed, variable);
        let octets = self.data(request, id, &taken)?;
        if let Some(octets) = &octets {
            if self.echoes.len() == ECHOES {
                self.echoes.pop_front();
            }
            self.echoes.push_back((key, octets.clone()));
        }
        Ok(octets.into_iter().collect())
    }

    /// Data about `id`, with a text that says of which frame they are.
    fn data(
        &self,
        request: RequestId,
        originating_id: EntityId,
        taken: &created::Taken,
    ) -> Result<Option<Vec<u8>>, EncodeError> {
        let text = format!("frame={} phase={}", self.state.frame, self.state.phase);
        let mut values = taken.variable.clone();
        // SISO-REF-010: datum identifiers of free text are the user's own; 0 says nothing.
        values.push((DatumId(0), text.into_bytes()));
        let variable: Vec<_> = values.iter().map(|(id, v)| VariableDatum::new(*id, v)).collect();
        let RequestId { from: receiving_id, request_id, form, .. } = request;
        match form {
            Form::Data => self
                .encoded(&Data {
                    originating_id,
                    receiving_id,
                    request_id,
                    fixed_datums: taken.fixed[..].into(),
                    variable_datums: variable[..].into(),
                    ..Data::default()
                })
                .map(Some),
            Form::DataR => self
                .encoded(&DataR {
                    originating_id,
                    receiving_id,
                    request_id,
                    fixed_datums: taken.fixed[..].into(),
                    variable_datums: variable[..].into(),
                    ..DataR::default()
                })
                .map(Some),
            _ => Ok(None),
        }
    }

    /// Answers a query now, and from now on if it says so; one with the interval 0 ends that.
    fn ask(
        &mut self,
        now_ns: u64,
        request: RequestId,
        about: Option<EntityId>,
        (wanted, every_ns): (Vec<DatumId>, u64),
    ) -> Result<Out, EncodeError> {
        let same = |q: &Query| {
            (q.request.from, q.request.request_id) == (request.from, request.request_id)
        };
        self.queries.retain(|query| !same(query));
        let every_ns = if every_ns == 0 { 0 } else { every_ns.max(QUERY_EVERY_NS) };
        let (next_ns, until_ns) = (now_ns + every_ns, now_ns + QUERY_FOR_NS);
        let query = Query { request, about, wanted, every_ns, next_ns, until_ns };
        let now = self.told_of(&query)?;
        if every_ns > 0 && self.queries.len() < QUERIES {
            self.queries.push(query);
        }
        Ok(now.into_iter().collect())
    }

    fn told_of(&self, query: &Query) -> Result<Option<Vec<u8>>, EncodeError> {
        let (frame, step_s) = (self.state.frame, self.step_s());
        let taken = match query.about {
            Some(id) => {
                let mut all = self.created.data(id, frame, step_s);
                if !query.wanted.is_empty() {
                    all.fixed.retain(|datum| query.wanted.contains(&datum.id));
                    all.variable.retain(|(id, _)| query.wanted.contains(id));
                }
                all
            }
            None => {
                let value = |id: &DatumId| figure(&self.state, *id);
                let fixed = query.wanted.iter().filter_map(value).collect();
                created::Taken { fixed, variable: Vec::new() }
            }
        };
        self.data(query.request, query.about.unwrap_or(self.id), &taken)
    }

    fn acknowledged(
        &mut self,
        from: EntityId,
        request_id: u32,
        response: ResponseFlag,
    ) -> Result<Out, EncodeError> {
        let what = self.participants.acknowledged(from, request_id);
        match what.filter(|_| response == ResponseFlag::UNABLE_TO_COMPLY) {
            Some(what) => Ok(vec![self.event(&format!("{from} is unable to comply with {what}"))?]),
            None => Ok(Vec::new()),
        }
    }

    /// An Event Report to all.
    pub(super) fn event(&self, what: &str) -> Result<Vec<u8>, EncodeError> {
        let text = format!("SEEDS {} at frame {}: {what}", self.state.phase, self.state.frame);
        let text = &text[..text.floor_char_boundary(1_000)];
        self.encoded(&EventReport {
            originating_id: self.id,
            receiving_id: EntityId::ALL,
            event_type: EventType::OTHER,
            variable_datums: vec![VariableDatum::new(DatumId(0), text.as_bytes())].into(),
            ..EventReport::default()
        })
    }

    /// A phase was reached: participants are told, each by itself.
    pub(super) fn reached(
        &mut self,
        (now_ns, utc_ns): (u64, i64),
        (phase, frame): (Phase, Frame),
        by_fault: bool,
    ) -> Result<Out, EncodeError> {
        let mut out = Vec::new();
        let news = phase != self.state.phase;
        (self.state.phase, self.state.frame) = (phase, frame);
        if phase == Phase::Configured {
            self.created.clear();
        }
        if news && matches!(phase, Phase::Init | Phase::Configured) {
            out.push(self.event("reached")?);
        }
        let real_world_time = ClockTime::from_unix_nanos(utc_ns);
        let simulated_ns = self.state.start_utc_ns + frame as i64 * self.state.step_ns;
        let all: Vec<EntityId> = self.participants.all().collect();
        for to in all {
            let request_id = self.next_request;
            let stop = |reason| StopFreezeR {
                originating_id: self.id,
                receiving_id: to,
                real_world_time,
                reason,
                reliability: Reliability::ACKNOWLEDGED,
                request_id,
                ..StopFreezeR::default()
            };
            let (what, octets) = match phase {
                Phase::Running => {
                    let start = StartResumeR {
                        originating_id: self.id,
                        receiving_id: to,
                        real_world_time,
                        simulation_time: ClockTime::from_unix_nanos(simulated_ns),
                        reliability: Reliability::ACKNOWLEDGED,
                        request_id,
                        ..StartResumeR::default()
                    };
                    ("Start/Resume-R", self.encoded(&start)?)
                }
                Phase::Frozen if by_fault => {
                    ("Stop/Freeze-R", self.encoded(&stop(StopReason::SYSTEM_FAILURE))?)
                }
                Phase::Frozen => ("Stop/Freeze-R", self.encoded(&stop(StopReason::RECESS))?),
                Phase::Stopped => ("Stop/Freeze-R", self.encoded(&stop(StopReason::TERMINATION))?),
                Phase::Init | Phase::Configured => continue,
            };
            self.next_request = self.next_request.checked_add(1).unwrap_or(OWN_REQUESTS);
            self.participants.sent(now_ns, (to, request_id), what, octets.clone());
            out.push(octets);
        }
        Ok(out)
    }

    /// How the run stands: what is new is told in Event Reports.
    pub(super) fn stated(&mut self, now_ns: u64, state: &RunState) -> Result<Out, EncodeError> {
        if state.run != self.state.run {
            self.created.clear();
        }
        self.state = state.clone();
        let mut out = Vec::new();
        // What is being worked on is said anew each second.
        let lasting = |r: &&String| !r.contains(" is working on frame ");
        let reasons: Vec<&String> = state.reasons.iter().filter(lasting).take(TOLD).collect();
        for reason in reasons.iter().filter(|reason| !self.told.contains(reason)) {
            out.push(self.event(reason)?);
        }
        for old in self.told.iter().filter(|old| !reasons.contains(old)) {
            out.push(self.event(&format!("over: {old}"))?);
        }
        self.told = reasons.into_iter().cloned().collect();
        let measured = state.phase == Phase::Running && state.rate.is_finite();
        let (rate, achieved) = (state.rate, state.achieved_rate);
        if !measured || achieved <= 0.0 || achieved >= LATE * rate {
            self.slow.0 = None;
        }
        if measured && achieved > 0.0 {
            let since = *self.slow.0.get_or_insert(now_ns);
            if achieved < LATE * rate && !self.slow.1 && now_ns >= since + LATE_AFTER_NS {
                self.slow.1 = true;
                let text = format!("late: {achieved:.2} of {rate} simulated seconds a second");
                out.push(self.event(&text)?);
            } else if achieved >= IN_TIME * rate && self.slow.1 {
                self.slow = (None, false);
                out.push(self.event("in time again")?);
            }
        }
        Ok(out)
    }

    /// What is due by the clock.
    pub(super) fn due(&mut self, now_ns: u64) -> Result<Out, EncodeError> {
        let (frame, step_s) = (self.state.frame, self.step_s());
        let envelope = (self.envelope)(frame);
        let mut out = self.created.due(now_ns, frame, (step_s, &envelope))?;
        let (again, silent) = self.participants.due(now_ns);
        out.extend(again);
        for what in silent {
            out.push(self.event(&what)?);
        }
        let mut queries = std::mem::take(&mut self.queries);
        let created = &self.created;
        queries.retain(|q| now_ns < q.until_ns && q.about.is_none_or(|id| created.has(id)));
        for query in queries.iter_mut().filter(|query| now_ns >= query.next_ns) {
            query.next_ns = (query.next_ns + query.every_ns).max(now_ns);
            out.extend(self.told_of(query)?);
        }
        self.queries = queries;
        Ok(out)
    }
}

/// A figure of the run as a fixed datum.
fn figure(state: &RunState, id: DatumId) -> Option<FixedDatum> {
    let step_s = state.step_ns as f64 * 1e-9;
    let elapsed_s = state.frame as f64 * step_s;
    Some(match id {
        DatumId::EXERCISE_STATE => FixedDatum::from_u32(
            id,
            match state.phase {
                Phase::Init => 0,
                Phase::Configured => 1,
                Phase::Running => 2,
                Phase::Frozen => 3,
                Phase::Stopped => 4,
            },
        ),
        DatumId::SIMULATION_RATE => FixedDatum::from_f32(id, state.rate as f32),
        DatumId::TIME_RATE => FixedDatum::from_f32(id, state.achieved_rate as f32),
        DatumId::SIMULATION_TIMESTEP => FixedDatum::from_f32(id, step_s as f32),
        DatumId::EXERCISE_ELAPSED_TIME => FixedDatum::from_f32(id, elapsed_s as f32),
        _ => return None,
    })
}

/// What a PDU asks for that this desk may answer.
fn about<'a>(body: &'a Body<'a>) -> Option<About<'a>> {
    const CREATE: AcknowledgeFlag = AcknowledgeFlag::CREATE_ENTITY;
    const REMOVE: AcknowledgeFlag = AcknowledgeFlag::REMOVE_ENTITY;
    const START: AcknowledgeFlag = AcknowledgeFlag::START_RESUME;
    const STOP: AcknowledgeFlag = AcknowledgeFlag::STOP_FREEZE;
    let r = |reliability, form| match reliability {
        Reliability::ACKNOWLEDGED => form,
        _ => Form::Silent,
    };
    let ack = Form::AcknowledgeR;
    let (from, request_id, form, to, what) = match body {
        Body::CreateEntity(b) => (
            b.originating_id,
            b.request_id,
            Form::Acknowledge(CREATE),
            b.receiving_id,
            What::Create,
        ),
        Body::CreateEntityR(b) => {
            let form = r(b.reliability, ack(CREATE));
            (b.originating_id, b.request_id, form, b.receiving_id, What::Create)
        }
        Body::RemoveEntity(b) => (
            b.originating_id,
            b.request_id,
            Form::Acknowledge(REMOVE),
            b.receiving_id,
            What::Remove,
        ),
        Body::RemoveEntityR(b) => {
            let form = r(b.reliability, ack(REMOVE));
            (b.originating_id, b.request_id, form, b.receiving_id, What::Remove)
        }
        Body::StartResume(b) => {
            let what = What::Freeze(false);
            (b.originating_id, b.request_id, Form::Acknowledge(START), b.receiving_id, what)
        }
        Body::StartResumeR(b) => {
            let form = r(b.reliability, ack(START));
            (b.originating_id, b.request_id, form, b.receiving_id, What::Freeze(false))
        }
        Body::StopFreeze(b) => {
            let what = What::Freeze(true);
            (b.originating_id, b.request_id, Form::Acknowledge(STOP), b.receiving_id, what)
        }
        Body::StopFreezeR(b) => {
            let form = r(b.reliability, ack(STOP));
            (b.originating_id, b.request_id, form, b.receiving_id, What::Freeze(true))
        }
        Body::SetData(b) => {
            let what = What::Set(&b.fixed_datums, &b.variable_datums);
            (b.originating_id, b.request_id, Form::Data, b.receiving_id, what)
        }
        Body::SetDataR(b) => {
            let what = What::Set(&b.fixed_datums, &b.variable_datums);
            (b.originating_id, b.request_id, r(b.reliability, Form::DataR), b.receiving_id, what)
        }
        Body::DataQuery(b) => {
            let what = What::Ask(&b.fixed_datum_ids, b.time_interval.nanos_past_hour());
            (b.originating_id, b.request_id, Form::Data, b.receiving_id, what)
        }
        Body::DataQueryR(b) => {
            let what = What::Ask(&b.fixed_datum_ids, b.time_interval.nanos_past_hour());
            (b.originating_id, b.request_id, r(b.reliability, Form::DataR), b.receiving_id, what)
        }
        _ => return None,
    };
    Some(About { request: RequestId::new(from, request_id, form, body), to, what })
}

#[cfg(test)]
mod tests;
