//! What requests of DIS simulation management ask for: commands to the conductor, and the form of their answer.

use super::asked::{Form, RequestId};
use crate::runtime::messages::{Answer, Command, RunState};
use pdu::Body;
use pdu::enumerations::{
    AcknowledgeFlag, ActionId, DatumId, Reliability, RequestStatus, ResponseFlag, StopReason,
};
use pdu::management::{Acknowledge, ActionResponse, Data};
use pdu::records::{EntityId, FixedDatum, VariableDatum};
use pdu::reliable::{AcknowledgeR, ActionResponseR, DataR};
use pdu::{EncodeError, Envelope, List};

/// A request as it came.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    /// Who asks, which request, and how it is answered.
    pub(super) request: RequestId,
    /// Whom.
    pub(super) to: EntityId,
    /// What it asks for, one after the other; none if that cannot be done here.
    pub(super) commands: Option<Vec<Command>>,
    /// When, UTC in ns since 1970; past times mean now.
    pub(super) at_utc_ns: i64,
}

/// Whether an answer is wanted, and in which form.
fn reliable(reliability: Reliability, form: Form) -> Form {
    if reliability == Reliability::ACKNOWLEDGED { form } else { Form::Silent }
}

/// What a PDU asks for; none if it asks for nothing that concerns the run.
pub(super) fn wanted(body: &Body<'_>) -> Option<Wanted> {
    let wanted = |from, request_id, form, to, commands, at_utc_ns| {
        let request = RequestId::new(from, request_id, form, body);
        Some(Wanted { request, to, commands, at_utc_ns })
    };
    const START: AcknowledgeFlag = AcknowledgeFlag::START_RESUME;
    const STOP: AcknowledgeFlag = AcknowledgeFlag::STOP_FREEZE;
    match body {
        Body::StartResume(s) => wanted(
            s.originating_id,
            s.request_id,
            Form::Acknowledge(START),
            s.receiving_id,
            Some(vec![Command::Start]),
            s.real_world_time.unix_nanos(),
        ),
        Body::StartResumeR(s) => wanted(
            s.originating_id,
            s.request_id,
            reliable(s.reliability, Form::AcknowledgeR(START)),
            s.receiving_id,
            Some(vec![Command::Start]),
            s.real_world_time.unix_nanos(),
        ),
        Body::StopFreeze(s) => wanted(
            s.originating_id,
            s.request_id,
            Form::Acknowledge(STOP),
            s.receiving_id,
            stop(s.reason, s.frozen_behaviour),
            s.real_world_time.unix_nanos(),
        ),
        Body::StopFreezeR(s) => wanted(
            s.originating_id,
            s.request_id,
            reliable(s.reliability, Form::AcknowledgeR(STOP)),
            s.receiving_id,
            stop(s.reason, s.frozen_behaviour),
            s.real_world_time.unix_nanos(),
        ),
        Body::ActionRequest(a) => wanted(
            a.originating_id,
            a.request_id,
            Form::Action(refusal(a.action_id, &a.fixed_datums)),
            a.receiving_id,
            action(a.action_id, &a.fixed_datums),
            0,
        ),
        Body::ActionRequestR(a) => wanted(
            a.originating_id,
            a.request_id,
            reliable(a.reliability, Form::ActionR(refusal(a.action_id, &a.fixed_datums))),
            a.receiving_id,
            action(a.action_id, &a.fixed_datums),
            0,
        ),
        Body::DataQuery(q) => wanted(
            q.originating_id,
            q.request_id,
            Form::Data,
            q.receiving_id,
            Some(vec![Command::Status]),
            0,
        ),
        Body::DataQueryR(q) => wanted(
            q.originating_id,
            q.request_id,
            reliable(q.reliability, Form::DataR),
            q.receiving_id,
            Some(vec![Command::Status]),
            0,
        ),
        Body::SetData(s) => wanted(
            s.originating_id,
            s.request_id,
            Form::Data,
            s.receiving_id,
            Some(set(&s.variable_datums)),
            0,
        ),
        Body::SetDataR(s) => wanted(
            s.originating_id,
            s.request_id,
            reliable(s.reliability, Form::DataR),
            s.receiving_id,
            Some(set(&s.variable_datums)),
            0,
        ),
        _ => None,
    }
}

fn stop(reason: StopReason, frozen_behaviour: u8) -> Option<Vec<Command>> {
    // Bit 0 of the frozen behaviour: go on with the clock. This federation cannot.
    if frozen_behaviour & 1 == 1 {
        return None;
    }
    Some(match reason {
        StopReason::TERMINATION => vec![Command::Stop],
        StopReason::STOP_FOR_RESET | StopReason::STOP_FOR_RESTART => {
            vec![Command::Freeze, Command::Restart]
        }
        _ => vec![Command::Freeze],
    })
}

/// With which status an action is refused.
fn refusal(id: ActionId, datums: &List<'_, FixedDatum>) -> RequestStatus {
    match id {
        ActionId::TIME_ADVANCE if action(id, datums).is_none() => {
            RequestStatus::INVALID_TIME_PARAMETERS
        }
        ActionId::JOIN_EXERCISE => RequestStatus::JOIN_EXERCISE_REQUEST_REJECTED,
        _ => RequestStatus::REQUEST_REJECTED,
    }
}

fn action(id: ActionId, datums: &List<'_, FixedDatum>) -> Option<Vec<Command>> {
    match id {
        ActionId::RUN => Some(vec![Command::Start]),
        ActionId::TIME_ADVANCE => {
            // So many frames: the first datum; one where nothing is said.
            let n = datums.iter().next().map_or(1, |datum| u32::from_be_bytes(datum.value));
            (n > 0).then(|| vec![Command::Step { n: n.into() }])
        }
        ActionId::RECALL_INITIAL_PARAMETERS => Some(vec![Command::Freeze, Command::Restart]),
        ActionId::STATUS_REQUEST
        | ActionId::JOIN_EXERCISE
        | ActionId::RESIGN_EXERCISE
        | ActionId::WAKEUP_GET_READY_FOR_INITIALIZATION
        | ActionId::INITIALIZE_INTERNAL_PARAMETERS => Some(vec![Command::Status]),
        _ => None,
    }
}

/// What `rate=4` in a datum of text sets; the answer tells what is so, whatever was asked.
fn set(datums: &List<'_, VariableDatum<'_>>) -> Vec<Command> {
    let rate = |datum: VariableDatum<'_>| {
        let text = std::str::from_utf8(datum.value).ok()?.trim_end_matches('\0');
        let rate = text.strip_prefix("rate=")?;
        if rate == "fast" { Some(f64::INFINITY) } else { crate::runtime::cli::rate(rate).ok() }
    };
    let rates = datums.iter().filter_map(rate).map(|rate| Command::Rate { rate });
    rates.chain([Command::Status]).collect()
}

/// How the run stands, in one line of text.
fn told(state: &RunState) -> String {
    let members = state.members.iter().filter(|m| m.alive).map(|m| m.name.as_str());
    let mut text = format!(
        "phase={} run={} frame={} last_frame={} rate={} achieved_rate={:.3} seed={} members={}",
        state.phase,
        state.run,
        state.frame,
        state.last_frame,
        state.rate,
        state.achieved_rate,
        state.seed,
        members.collect::<Vec<_>>().join(","),
    );
    if !state.reasons.is_empty() {
        text += &format!(" reasons={}", state.reasons.join("; "));
    }
    text.truncate(text.floor_char_boundary(1_000));
    text
}

/// The PDU that answers a request, if one is wanted.
pub(super) fn answer(
    envelope: &Envelope,
    originating_id: EntityId,
    request: RequestId,
    response_flag: ResponseFlag,
    answer: Option<&Answer>,
) -> Result<Vec<u8>, EncodeError> {
    let RequestId { from: receiving_id, request_id, form, .. } = request;
    let able = response_flag == ResponseFlag::ABLE_TO_COMPLY;
    let request_status = match form {
        _ if able => RequestStatus::COMPLETE,
        Form::Action(refused) | Form::ActionR(refused) => refused,
        _ => RequestStatus::REQUEST_REJECTED,
    };
    let text = answer.map(|answer| told(&answer.state)).unwrap_or_default();
    // SISO-REF-010: datum identifiers of free text are the user's own; 0 says nothing.
    let datum = [VariableDatum::new(DatumId(0), text.as_bytes())];
    let variable_datums = || List::from(if text.is_empty() { &[][..] } else { &datum[..] });
    let mut octets = Vec::new();
    match form {
        Form::Silent => return Ok(octets),
        Form::Acknowledge(acknowledge_flag) => envelope.append(
            &Acknowledge {
                originating_id,
                receiving_id,
                acknowledge_flag,
                response_flag,
                request_id,
            },
            &mut octets,
        ),
        Form::AcknowledgeR(acknowledge_flag) => envelope.append(
            &AcknowledgeR {
                originating_id,
                receiving_id,
                acknowledge_flag,
                response_flag,
                request_id,
            },
            &mut octets,
        ),
        Form::Action(_) => envelope.append(
            &ActionResponse {
                originating_id,
                receiving_id,
                request_id,
                request_status,
                variable_datums: variable_datums(),
                ..ActionResponse::default()
            },
            &mut octets,
        ),
        Form::ActionR(_) => envelope.append(
            &ActionResponseR {
                originating_id,
                receiving_id,
                request_id,
                request_status,
                variable_datums: variable_datums(),
                ..ActionResponseR::default()
            },
            &mut octets,
        ),
        Form::Data => envelope.append(
            &Data {
                originating_id,
                receiving_id,
                request_id,
                variable_datums: variable_datums(),
                ..Data::default()
            },
            &mut octets,
        ),
        Form::DataR => envelope.append(
            &DataR {
                originating_id,
                receiving_id,
                request_id,
                variable_datums: variable_datums(),
                ..DataR::default()
            },
            &mut octets,
        ),
    }?;
    Ok(octets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::life_cycle::Phase;
    use pdu::DisTime;
    use pdu::management::{ActionRequest, SetData};
    use pdu::reliable::{ActionRequestR, StartResumeR};

    const ME: EntityId = EntityId { site: 77, application: 1, entity: 0 };

    fn commands(body: Body<'_>) -> Option<Vec<Command>> {
        wanted(&body).expect("a request").commands
    }

    #[test]
    fn actions_are_commands_or_refused() {
        let asked = |action_id, datums: &[u32]| {
            let datum = |n: &u32| FixedDatum::from_u32(DatumId(0), *n);
            let datums: Vec<_> = datums.iter().map(datum).collect();
            commands(Body::ActionRequest(ActionRequest {
                originating_id: ME,
                action_id,
                fixed_datums: datums.into(),
                ..ActionRequest::default()
            }))
        };
        assert_eq!(asked(ActionId::RUN, &[]), Some(vec![Command::Start]));
        assert_eq!(asked(ActionId::TIME_ADVANCE, &[20]), Some(vec![Command::Step { n: 20 }]));
        assert_eq!(asked(ActionId::TIME_ADVANCE, &[]), Some(vec![Command::Step { n: 1 }]));
        assert_eq!(asked(ActionId::TIME_ADVANCE, &[0]), None);
        assert_eq!(asked(ActionId::MOUNT, &[]), None);
        let restart = Some(vec![Command::Freeze, Command::Restart]);
        assert_eq!(asked(ActionId::RECALL_INITIAL_PARAMETERS, &[]), restart);
    }

    #[test]
    fn a_rate_is_set_by_a_text_and_nothing_else_is() {
        let asked = |text: &str| {
            let datums = vec![VariableDatum::new(DatumId(0), text.as_bytes())];
            commands(Body::SetData(SetData {
                variable_datums: datums.into(),
                ..SetData::default()
            }))
        };
        let status = Command::Status;
        assert_eq!(asked("rate=4"), Some(vec![Command::Rate { rate: 4.0 }, status.clone()]));
        for wrong in ["rate=-1", "rate=", "rate=NaN", "seed=7", ""] {
            assert_eq!(asked(wrong), Some(vec![status.clone()]), "{wrong}");
        }
    }

    #[test]
    fn each_form_is_answered_in_its_own_and_the_silent_one_not_at_all() {
        let envelope = Envelope::new(1, DisTime::relative(0));
        let state = RunState { phase: Phase::Frozen, frame: 70, ..RunState::default() };
        let told = Answer { ok: true, text: String::new(), state };
        let able = ResponseFlag::ABLE_TO_COMPLY;
        let answered = |body: Body<'_>| {
            let request = wanted(&body).expect("a request").request;
            answer(&envelope, ME, request, able, Some(&told)).expect("it fits")
        };
        let start = |reliability| {
            answered(Body::StartResumeR(StartResumeR {
                originating_id: ME,
                reliability,
                request_id: 5,
                ..StartResumeR::default()
            }))
        };
        let octets = start(Reliability::ACKNOWLEDGED);
        let received = pdu::pdus(&octets).next().expect("one").expect("sound");
        assert!(matches!(received.body(), Body::AcknowledgeR(a) if a.request_id == 5
            && a.acknowledge_flag == AcknowledgeFlag::START_RESUME && a.response_flag == able));
        assert!(start(Reliability::UNACKNOWLEDGED).is_empty());
        let octets = answered(Body::ActionRequestR(ActionRequestR {
            action_id: ActionId::STATUS_REQUEST,
            request_id: 6,
            ..ActionRequestR::default()
        }));
        let received = pdu::pdus(&octets).next().expect("one").expect("sound");
        let Body::ActionResponseR(response) = received.body() else { panic!("{received:?}") };
        assert_eq!(response.request_status, RequestStatus::COMPLETE);
        let text = response.variable_datums.iter().next().expect("a text");
        let text = String::from_utf8_lossy(text.value).into_owned();
        assert!(text.starts_with("phase=FROZEN run=0 frame=70 "), "{text}");
    }
}
