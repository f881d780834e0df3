//! Attribute PDUs: records that extend the PDUs of other types.

use crate::enumerations::{AttributeActionCode, DatumId, PduType, ProtocolVersion};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{AttributeRecord, EntityId, SimulationAddress};
use crate::writer::{EncodeError, Writer};

/// The records of one entity. Source: IEEE 1278.1-2012, 6.2.9.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AttributeRecordSet<'a> {
    /// The entity.
    pub entity_id: EntityId,
    /// Its records.
    pub records: List<'a, AttributeRecord<'a>>,
}

impl<'a> Item<'a> for AttributeRecordSet<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let entity_id = reader.get(field)?;
        let count: u16 = reader.get(field)?;
        let records = List::decode(reader, count.into(), "records")?;
        Ok(Self { entity_id, records })
    }
    fn item_len(&self) -> usize {
        8 + self.records.octet_len()
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.entity_id);
        writer.count::<u16>(self.records.len(), "records")?;
        self.records.encode(writer)
    }
}

body! {
    /// Attribute (type 72). Source: IEEE 1278.1-2012, 7.2.6.
    Attribute = ATTRIBUTE {
        /// Who sends.
        originating_simulation: SimulationAddress;
        /// Unused.
        padding1: [u8; 6];
        /// The type of PDU that the records extend.
        record_pdu_type: PduType;
        /// The version of that PDU.
        record_version: ProtocolVersion;
        /// The type of all records, if they have one type.
        master_record_type: DatumId;
        /// What the receiver shall do.
        action_code: AttributeActionCode;
        /// Unused.
        padding2: u8;
        count number_of_record_sets: u16 = record_sets;
        /// Records, by entity.
        list record_sets: AttributeRecordSet<'a>, number_of_record_sets;
    }
}
