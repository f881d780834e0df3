//! Simulation management with reliability: the -R forms, which are to be acknowledged and repeated
//! until they are.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{
    AcknowledgeFlag, ActionId, DatumId, EventType, PduType, Reliability, RequestStatus,
    ResponseFlag, StopReason,
};
use crate::list::List;
use crate::reader::{BodyError, Reader};
use crate::records::{ClockTime, EntityId, FixedDatum, VariableDatum};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// Create Entity-R (type 51). Source: IEEE 1278.1-2012, 7.11.2.
    CreateEntityR {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability,
        /// Unused.
        padding: [u8; 3],
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(CreateEntityR = CREATE_ENTITY_R);

record! {
    /// Remove Entity-R (type 52). Source: IEEE 1278.1-2012, 7.11.3.
    RemoveEntityR {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability,
        /// Unused.
        padding: [u8; 3],
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(RemoveEntityR = REMOVE_ENTITY_R);

record! {
    /// Start/Resume-R (type 53). Source: IEEE 1278.1-2012, 7.11.4.
    StartResumeR {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// When to start, in real time.
        real_world_time: ClockTime,
        /// The simulation time at the start.
        simulation_time: ClockTime,
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability,
        /// Unused.
        padding: [u8; 3],
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(StartResumeR = START_RESUME_R);

record! {
    /// Stop/Freeze-R (type 54). Source: IEEE 1278.1-2012, 7.11.5.
    StopFreezeR {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// When to stop, in real time.
        real_world_time: ClockTime,
        /// Why.
        reason: StopReason,
        /// What goes on while frozen: bit 0 the clock, bit 1 sending, bit 2 receiving.
        frozen_behaviour: u8,
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability,
        /// Unused.
        padding: u8,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(StopFreezeR = STOP_FREEZE_R);

record! {
    /// Acknowledge-R (type 55). Source: IEEE 1278.1-2012, 7.11.6.
    AcknowledgeR {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// What is acknowledged.
        acknowledge_flag: AcknowledgeFlag,
        /// Whether it will be done.
        response_flag: ResponseFlag,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(AcknowledgeR = ACKNOWLEDGE_R);

/// Action Request-R (type 56). Source: IEEE 1278.1-2012, 7.11.7.
///
/// Implementations disagree whether four unused octets stand before the counts (48 octets without
/// datums) or not (44). What fits the PDU's length is taken, the shorter form first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActionRequestR<'a> {
    /// Who asks.
    pub originating_id: EntityId,
    /// Who is asked.
    pub receiving_id: EntityId,
    /// Whether the PDU has to be acknowledged.
    pub reliability: Reliability,
    /// Unused.
    pub padding: [u8; 3],
    /// Number of the request.
    pub request_id: u32,
    /// The action.
    pub action_id: ActionId,
    /// The four unused octets of the longer form; `None` writes the shorter one.
    pub unused: Option<u32>,
    /// Data of fixed size.
    pub fixed_datums: List<'a, FixedDatum>,
    /// Data of variable size.
    pub variable_datums: List<'a, VariableDatum<'a>>,
}

record! {
    /// What both forms begin with.
    ActionRequestStart {
        /// Who asks.
        originating_id: EntityId,
        /// Who is asked.
        receiving_id: EntityId,
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability,
        /// Unused.
        padding: [u8; 3],
        /// Number of the request.
        request_id: u32,
        /// The action.
        action_id: ActionId,
    }
}

type Datums<'a> = (Option<u32>, List<'a, FixedDatum>, List<'a, VariableDatum<'a>>);

fn datums<'a>(reader: &mut Reader<'a>, long: bool) -> Result<Datums<'a>, BodyError> {
    let unused = if long { Some(reader.get("unused")?) } else { None };
    let fixed: u32 = reader.get("number_of_fixed_datums")?;
    let variable: u32 = reader.get("number_of_variable_datums")?;
    let fixed = List::decode(reader, fixed as usize, "fixed_datums")?;
    let variable = List::decode(reader, variable as usize, "variable_datums")?;
    reader.finish()?;
    Ok((unused, fixed, variable))
}

impl<'a> DecodeBody<'a> for ActionRequestR<'a> {
    const PDU_TYPE: PduType = PduType::ACTION_REQUEST_R;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let start: ActionRequestStart = reader.record()?;
        let read = datums(&mut reader.clone(), false);
        let read = read.or_else(|short| datums(&mut reader.clone(), true).map_err(|_| short));
        let (unused, fixed_datums, variable_datums) = read?;
        reader.take(reader.left(), "datums")?;
        let ActionRequestStart {
            originating_id,
            receiving_id,
            reliability,
            padding,
            request_id,
            action_id,
        } = start;
        Ok(Self {
            originating_id,
            receiving_id,
            reliability,
            padding,
            request_id,
            action_id,
            unused,
            fixed_datums,
            variable_datums,
        })
    }
}

impl EncodeBody for ActionRequestR<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::ACTION_REQUEST_R
    }
    fn body_len(&self) -> usize {
        let unused = if self.unused.is_some() { 4 } else { 0 };
        let datums = self.fixed_datums.octet_len() + self.variable_datums.octet_len();
        ActionRequestStart::SIZE + unused + 8 + datums
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let Self { originating_id, receiving_id, reliability, padding, .. } = *self;
        let Self { request_id, action_id, .. } = *self;
        writer.put(&ActionRequestStart {
            originating_id,
            receiving_id,
            reliability,
            padding,
            request_id,
            action_id,
        });
        if let Some(unused) = self.unused {
            writer.put(&unused);
        }
        writer.count::<u32>(self.fixed_datums.len(), "fixed_datums")?;
        writer.count::<u32>(self.variable_datums.len(), "variable_datums")?;
        self.fixed_datums.encode(writer)?;
        self.variable_datums.encode(writer)
    }
}

body! {
    /// Action Response-R (type 57). Source: IEEE 1278.1-2012, 7.11.8.
    ActionResponseR = ACTION_RESPONSE_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// How it went.
        request_status: RequestStatus;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Data Query-R (type 58). Source: IEEE 1278.1-2012, 7.11.9.
    DataQueryR = DATA_QUERY_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability;
        /// Unused.
        padding: [u8; 3];
        /// Number of the request.
        request_id: u32;
        /// Interval of repeated answers as timestamp units, 0 for one answer.
        time_interval: crate::DisTime;
        count number_of_fixed_datums: u32 = fixed_datum_ids;
        count number_of_variable_datums: u32 = variable_datum_ids;
        /// What is asked, of fixed size.
        list fixed_datum_ids: DatumId, number_of_fixed_datums;
        /// What is asked, of variable size.
        list variable_datum_ids: DatumId, number_of_variable_datums;
    }
}

body! {
    /// Set Data-R (type 59). Source: IEEE 1278.1-2012, 7.11.10.
    SetDataR = SET_DATA_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability;
        /// Unused.
        padding: [u8; 3];
        /// Number of the request.
        request_id: u32;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Data-R (type 60). Source: IEEE 1278.1-2012, 7.11.11.
    DataR = DATA_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability;
        /// Unused.
        padding: [u8; 3];
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Event Report-R (type 61). Source: IEEE 1278.1-2012, 7.11.12.
    EventReportR = EVENT_REPORT_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// What happened.
        event_type: EventType;
        /// Unused.
        padding: u32;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Comment-R (type 62). Source: IEEE 1278.1-2012, 7.11.13.
    CommentR = COMMENT_R {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}
