//! The bodies of PDUs: one variant a type, and raw octets for the rest.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::PduType;
use crate::reader::{BodyError, Reader};
use crate::writer::{EncodeError, Writer};

macro_rules! bodies {
    ($($variant:ident($t:ty) = $konst:ident $text:literal,)*) => {
        /// The content of a PDU.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Body<'a> {
            $(#[doc = $text] $variant($t),)*
            /// A type without typed fields here (or of a version before 5): its octets.
            Raw(RawBody<'a>),
        }

        impl<'a> Body<'a> {
            #[inline]
            pub(crate) fn decode(
                pdu_type: PduType,
                reader: &mut Reader<'a>,
            ) -> Result<Self, BodyError> {
                if !(5..=7).contains(&reader.version()) {
                    return Self::raw(pdu_type, reader);
                }
                if pdu_type == PduType::TRANSFER_OWNERSHIP && reader.version() < 7 {
                    return Self::transfer_before_dis_7(reader);
                }
                match pdu_type {
                    $(PduType::$konst => <$t>::decode_body(reader).map(Self::$variant),)*
                    _ => Self::raw(pdu_type, reader),
                }
            }
        }

        impl EncodeBody for Body<'_> {
            #[inline]
            fn pdu_type(&self) -> PduType {
                match self {
                    $(Self::$variant(body) => body.pdu_type(),)*
                    Self::Raw(raw) => raw.pdu_type,
                }
            }
            #[inline]
            fn body_len(&self) -> usize {
                match self {
                    $(Self::$variant(body) => body.body_len(),)*
                    Self::Raw(raw) => raw.octets.len(),
                }
            }
            #[inline]
            fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
                match self {
                    $(Self::$variant(body) => body.encode_body(writer),)*
                    Self::Raw(raw) => raw.encode_body(writer),
                }
            }
        }

        $(impl<'a> From<$t> for Body<'a> {
            fn from(body: $t) -> Self {
                Self::$variant(body)
            }
        })*
        impl<'a> From<RawBody<'a>> for Body<'a> {
            fn from(body: RawBody<'a>) -> Self {
                Self::Raw(body)
            }
        }

        /// The types that this crate reads and writes with typed fields.
        pub const TYPED: &[PduType] = &[$(PduType::$konst),*];
    };
}

impl<'a> Body<'a> {
    /// Before DIS 7 this was Transfer Control, whose layout implementations write differently: what
    /// does not fit the present layout is kept raw.
    #[cold]
    fn transfer_before_dis_7(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let mut probe = reader.clone();
        match crate::entity_management::TransferOwnership::decode_body(&mut probe) {
            Ok(body) if probe.left() == 0 => {
                *reader = probe;
                Ok(Self::TransferOwnership(body))
            }
            _ => Self::raw(PduType::TRANSFER_OWNERSHIP, reader),
        }
    }

    fn raw(pdu_type: PduType, reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let octets = reader.take(reader.left(), "body")?;
        Ok(Self::Raw(RawBody { pdu_type, octets }))
    }
}

/// The octets of a body whose fields are not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawBody<'a> {
    /// The type in the header.
    pub pdu_type: PduType,
    /// Everything after the header.
    pub octets: &'a [u8],
}

impl EncodeBody for RawBody<'_> {
    fn pdu_type(&self) -> PduType {
        self.pdu_type
    }
    fn body_len(&self) -> usize {
        self.octets.len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.octets(self.octets);
        Ok(())
    }
}

bodies! {
    EntityState(crate::EntityState<'a>) = ENTITY_STATE "Entity State.",
    CreateEntity(crate::management::CreateEntity) = CREATE_ENTITY "Create Entity.",
    RemoveEntity(crate::management::RemoveEntity) = REMOVE_ENTITY "Remove Entity.",
    StartResume(crate::management::StartResume) = START_RESUME "Start/Resume.",
    StopFreeze(crate::management::StopFreeze) = STOP_FREEZE "Stop/Freeze.",
    Acknowledge(crate::management::Acknowledge) = ACKNOWLEDGE "Acknowledge.",
    ActionRequest(crate::management::ActionRequest<'a>) = ACTION_REQUEST "Action Request.",
    ActionResponse(crate::management::ActionResponse<'a>) = ACTION_RESPONSE "Action Response.",
    DataQuery(crate::management::DataQuery<'a>) = DATA_QUERY "Data Query.",
    SetData(crate::management::SetData<'a>) = SET_DATA "Set Data.",
    Data(crate::management::Data<'a>) = DATA "Data.",
    EventReport(crate::management::EventReport<'a>) = EVENT_REPORT "Event Report.",
    Comment(crate::management::Comment<'a>) = COMMENT "Comment.",
    EnvironmentalProcess(crate::environment::EnvironmentalProcess<'a>) = ENVIRONMENTAL_PROCESS
        "Environmental Process.",
    EntityStateUpdate(crate::EntityStateUpdate<'a>) = ENTITY_STATE_UPDATE "Entity State Update.",
    Fire(crate::interaction::Fire) = FIRE "Fire.",
    Detonation(crate::interaction::Detonation<'a>) = DETONATION "Detonation.",
    Collision(crate::interaction::Collision) = COLLISION "Collision.",
    CollisionElastic(crate::interaction::CollisionElastic) = COLLISION_ELASTIC "Collision-Elastic.",
    ElectromagneticEmission(crate::emission::ElectromagneticEmission<'a>) =
        ELECTROMAGNETIC_EMISSION "Electromagnetic Emission.",
    Designator(crate::emission::Designator) = DESIGNATOR "Designator.",
    Transmitter(crate::radio::Transmitter<'a>) = TRANSMITTER "Transmitter.",
    Signal(crate::radio::Signal<'a>) = SIGNAL "Signal.",
    Receiver(crate::radio::Receiver) = RECEIVER "Receiver.",
    Iff(crate::iff::Iff<'a>) = IFF "IFF.",
    AggregateState(crate::entity_management::AggregateState<'a>) = AGGREGATE_STATE
        "Aggregate State.",
    TransferOwnership(crate::entity_management::TransferOwnership<'a>) = TRANSFER_OWNERSHIP
        "Transfer Ownership.",
    IsPartOf(crate::entity_management::IsPartOf) = IS_PART_OF "IsPartOf.",
    GriddedData(crate::gridded::GriddedData<'a>) = GRIDDED_DATA "Gridded Data.",
    CreateEntityR(crate::reliable::CreateEntityR) = CREATE_ENTITY_R "Create Entity-R.",
    RemoveEntityR(crate::reliable::RemoveEntityR) = REMOVE_ENTITY_R "Remove Entity-R.",
    StartResumeR(crate::reliable::StartResumeR) = START_RESUME_R "Start/Resume-R.",
    StopFreezeR(crate::reliable::StopFreezeR) = STOP_FREEZE_R "Stop/Freeze-R.",
    AcknowledgeR(crate::reliable::AcknowledgeR) = ACKNOWLEDGE_R "Acknowledge-R.",
    ActionRequestR(crate::reliable::ActionRequestR<'a>) = ACTION_REQUEST_R "Action Request-R.",
    ActionResponseR(crate::reliable::ActionResponseR<'a>) = ACTION_RESPONSE_R
        "Action Response-R.",
    DataQueryR(crate::reliable::DataQueryR<'a>) = DATA_QUERY_R "Data Query-R.",
    SetDataR(crate::reliable::SetDataR<'a>) = SET_DATA_R "Set Data-R.",
    DataR(crate::reliable::DataR<'a>) = DATA_R "Data-R.",
    EventReportR(crate::reliable::EventReportR<'a>) = EVENT_REPORT_R "Event Report-R.",
    CommentR(crate::reliable::CommentR<'a>) = COMMENT_R "Comment-R.",
    Attribute(crate::attribute::Attribute<'a>) = ATTRIBUTE "Attribute.",
}
