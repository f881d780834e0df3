//! The synthetic environment: weather and other processes.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{EnvironmentModelType, EnvironmentRecordType, PduType};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{EntityId, EntityType};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// What comes before the records.
    ProcessFixed {
        /// The process.
        process_id: EntityId,
        /// Its type.
        environment_type: EntityType,
        /// The model behind it.
        model_type: EnvironmentModelType,
        /// Status bits.
        status: u8,
        /// Number of records.
        number_of_records: u16,
        /// Sequence number.
        sequence_number: u16,
    }
}

/// Environmental Process (type 41): a process of the environment and its geometry and state.
/// Source: IEEE 1278.1-2012, 7.10.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvironmentalProcess<'a> {
    /// The process.
    pub process_id: EntityId,
    /// Its type.
    pub environment_type: EntityType,
    /// The model behind it.
    pub model_type: EnvironmentModelType,
    /// Status: bit 0 last PDU of the process, bit 1 active.
    pub status: u8,
    /// Counts the PDUs of the process.
    pub sequence_number: u16,
    /// Geometry and state records.
    pub records: EnvironmentRecords<'a>,
}

/// The records of an Environmental Process. Senders disagree whether a record's length in bits
/// includes its own 8 octets of header (the standard: yes; VR-Forces of 2007: no); what fits the PDU
/// is taken, the standard's reading first.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRecords<'a> {
    /// Lengths include the record's header, as the standard says.
    Standard(List<'a, EnvironmentRecord<'a>>),
    /// Lengths count the content only.
    ContentOnly(List<'a, ContentOnlyRecord<'a>>),
}

impl Default for EnvironmentRecords<'_> {
    fn default() -> Self {
        Self::Standard(List::default())
    }
}

impl<'a> EnvironmentRecords<'a> {
    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Standard(list) => list.len(),
            Self::ContentOnly(list) => list.len(),
        }
    }

    /// True if there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The records, however their length was written.
    pub fn iter(&self) -> impl Iterator<Item = EnvironmentRecord<'a>> {
        let (standard, content_only) = match self {
            Self::Standard(list) => (Some(list.iter()), None),
            Self::ContentOnly(list) => (None, Some(list.iter().map(|record| record.0))),
        };
        standard.into_iter().flatten().chain(content_only.into_iter().flatten())
    }
}

impl<'a> From<&'a [EnvironmentRecord<'a>]> for EnvironmentRecords<'a> {
    fn from(records: &'a [EnvironmentRecord<'a>]) -> Self {
        Self::Standard(List::from(records))
    }
}

impl<'a> From<Vec<EnvironmentRecord<'a>>> for EnvironmentRecords<'a> {
    fn from(records: Vec<EnvironmentRecord<'a>>) -> Self {
        Self::Standard(List::from(records))
    }
}

/// A geometry or state record. Source: IEEE 1278.1-2012, 6.2.31.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EnvironmentRecord<'a> {
    /// What it is.
    pub record_type: EnvironmentRecordType,
    /// Number of the record in its process.
    pub index: u8,
    /// Unused.
    pub padding: u8,
    /// The content with its padding: a multiple of 8 octets.
    pub content: &'a [u8],
}

/// An [`EnvironmentRecord`] whose length field counts the content only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContentOnlyRecord<'a>(
    /// The record.
    pub EnvironmentRecord<'a>,
);

/// Octets of a record before its content.
const RECORD_HEADER: usize = 8;

impl<'a> EnvironmentRecord<'a> {
    fn read(
        reader: &mut Reader<'a>,
        field: &'static str,
        counted_header: usize,
    ) -> Result<Self, BodyError> {
        let record_type = reader.get(field)?;
        let bits: u16 = reader.get(field)?;
        let index = reader.get(field)?;
        let padding = reader.get(field)?;
        let octets = usize::from(bits).div_ceil(8);
        let Some(content) = octets.checked_sub(counted_header) else {
            return Err(reader.bad_length(field, u64::from(bits)));
        };
        let content = reader.take(content, field)?;
        Ok(Self { record_type, index, padding, content })
    }

    fn write(&self, writer: &mut Writer<'_>, counted_header: usize) -> Result<(), EncodeError> {
        let octets = self.content.len();
        if !octets.is_multiple_of(8) {
            return Err(EncodeError::BadSize { field: "environment_record.content", octets });
        }
        writer.put(&self.record_type);
        writer.count::<u16>((octets + counted_header) * 8, "environment_record.content")?;
        writer.put(&self.index);
        writer.put(&self.padding);
        writer.octets(self.content);
        Ok(())
    }
}

impl<'a> Item<'a> for EnvironmentRecord<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        Self::read(reader, field, RECORD_HEADER)
    }
    fn item_len(&self) -> usize {
        RECORD_HEADER + self.content.len()
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        self.write(writer, RECORD_HEADER)
    }
}

impl<'a> Item<'a> for ContentOnlyRecord<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        EnvironmentRecord::read(reader, field, 0).map(Self)
    }
    fn item_len(&self) -> usize {
        RECORD_HEADER + self.0.content.len()
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        self.0.write(writer, 0)
    }
}

impl<'a> DecodeBody<'a> for EnvironmentalProcess<'a> {
    const PDU_TYPE: PduType = PduType::ENVIRONMENTAL_PROCESS;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let fixed: ProcessFixed = reader.record()?;
        let count = usize::from(fixed.number_of_records);
        let mut standard = reader.clone();
        let result = List::decode(&mut standard, count, "records");
        let complete = result.is_ok() && standard.left() == 0;
        let mut other = reader.clone();
        let records = match result {
            // The standard's reading, if it fits, or if the other does not fit either.
            Ok(list) if complete => EnvironmentRecords::Standard(list),
            result => match List::decode(&mut other, count, "records") {
                Ok(list) if other.left() == 0 => {
                    standard = other;
                    EnvironmentRecords::ContentOnly(list)
                }
                _ => EnvironmentRecords::Standard(result?),
            },
        };
        *reader = standard;
        Ok(Self {
            process_id: fixed.process_id,
            environment_type: fixed.environment_type,
            model_type: fixed.model_type,
            status: fixed.status,
            sequence_number: fixed.sequence_number,
            records,
        })
    }
}

impl EncodeBody for EnvironmentalProcess<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::ENVIRONMENTAL_PROCESS
    }
    fn body_len(&self) -> usize {
        let records = match &self.records {
            EnvironmentRecords::Standard(list) => list.octet_len(),
            EnvironmentRecords::ContentOnly(list) => list.octet_len(),
        };
        ProcessFixed::SIZE + records
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let count = self.records.len();
        let too_many = EncodeError::TooMany { field: "records", count, max: 65535 };
        writer.put(&ProcessFixed {
            process_id: self.process_id,
            environment_type: self.environment_type,
            model_type: self.model_type,
            status: self.status,
            number_of_records: count.try_into().map_err(|_| too_many)?,
            sequence_number: self.sequence_number,
        });
        match &self.records {
            EnvironmentRecords::Standard(list) => list.encode(writer),
            EnvironmentRecords::ContentOnly(list) => list.encode(writer),
        }
    }
}
