//! Aggregates, parts, ownership.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{
    AggregateFormation, AggregateKind, AggregateState as StateOfAggregate, Country, DatumId,
    ForceId, PartNature, PartPosition, PduType, Reliability, StationName, TransferType,
};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{
    AggregateMarking, EntityId, EntityType, Location, Orientation, VariableDatum, Vector32,
};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// Type of an aggregate. Source: IEEE 1278.1-2012, 6.2.5.
    #[derive(Eq)]
    AggregateType {
        /// Kind.
        kind: AggregateKind,
        /// Domain, as that of platforms.
        domain: u8,
        /// Country.
        country: Country,
        /// Category: SISO-REF-010, UID 207.
        category: u8,
        /// Subcategory: SISO-REF-010, UID 208.
        subcategory: u8,
        /// Specific: SISO-REF-010, UID 209.
        specific: u8,
        /// Anything more.
        extra: u8,
    }
}

record! {
    /// Aggregates of one type that do not send their state. Source: IEEE 1278.1-2012, 6.2.78.
    #[derive(Eq)]
    SilentAggregates {
        /// How many.
        count: u16,
        /// Unused.
        padding: u16,
        /// Of which type.
        aggregate_type: AggregateType,
    }
}

/// Entities of one type that do not send their state. Source: IEEE 1278.1-2012, 6.2.79.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SilentEntities<'a> {
    /// How many.
    pub count: u16,
    /// Of which type.
    pub entity_type: EntityType,
    /// Appearances of those that differ from the default.
    pub appearances: List<'a, u32>,
}

impl<'a> Item<'a> for SilentEntities<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let count = reader.get(field)?;
        let appearances: u16 = reader.get(field)?;
        let entity_type = reader.get(field)?;
        let appearances = List::decode(reader, appearances.into(), "appearances")?;
        Ok(Self { count, entity_type, appearances })
    }
    fn item_len(&self) -> usize {
        12 + self.appearances.octet_len()
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.count);
        writer.count::<u16>(self.appearances.len(), "appearances")?;
        writer.put(&self.entity_type);
        self.appearances.encode(writer)
    }
}

record! {
    /// What comes before the counts.
    AggregateFixed {
        /// The aggregate.
        aggregate_id: EntityId,
        /// Its force.
        force_id: ForceId,
        /// Aggregated, disaggregated …
        state: StateOfAggregate,
        /// Its type.
        aggregate_type: AggregateType,
        /// Formation.
        formation: AggregateFormation,
        /// Marking.
        marking: AggregateMarking,
        /// Extent along the axes, metres.
        dimensions_m: Vector32,
        /// Orientation.
        orientation: Orientation,
        /// Centre of mass, world coordinates.
        centre_of_mass: Location,
        /// Velocity, m/s, world axes.
        velocity_mps: Vector32,
    }
}

/// Aggregate State (type 33). Source: IEEE 1278.1-2012, 7.8.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AggregateState<'a> {
    /// The aggregate.
    pub aggregate_id: EntityId,
    /// Its force.
    pub force_id: ForceId,
    /// Aggregated, disaggregated …
    pub state: StateOfAggregate,
    /// Its type.
    pub aggregate_type: AggregateType,
    /// Formation.
    pub formation: AggregateFormation,
    /// Marking.
    pub marking: AggregateMarking,
    /// Extent along the axes, metres.
    pub dimensions_m: Vector32,
    /// Orientation.
    pub orientation: Orientation,
    /// Centre of mass, world coordinates.
    pub centre_of_mass: Location,
    /// Velocity, m/s, world axes.
    pub velocity_mps: Vector32,
    /// Aggregates that belong to it.
    pub aggregates: List<'a, EntityId>,
    /// Entities that belong to it.
    pub entities: List<'a, EntityId>,
    /// Unused octets to the next 32-bit boundary (only where the number of identifiers is odd).
    pub padding: u16,
    /// Aggregates that do not send their state.
    pub silent_aggregates: List<'a, SilentAggregates>,
    /// Entities that do not send their state.
    pub silent_entities: List<'a, SilentEntities<'a>>,
    /// More data.
    pub variable_datums: List<'a, VariableDatum<'a>>,
}

impl<'a> DecodeBody<'a> for AggregateState<'a> {
    const PDU_TYPE: PduType = PduType::AGGREGATE_STATE;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let fixed: AggregateFixed = reader.record()?;
        let [aggregates, entities, silent_aggregates, silent_entities] =
            reader.get::<[u16; 4]>("counts")?.map(usize::from);
        let odd = (aggregates + entities) % 2 == 1;
        let aggregates = List::decode(reader, aggregates, "aggregates")?;
        let entities = List::decode(reader, entities, "entities")?;
        let padding = if odd { reader.get("padding")? } else { 0 };
        let silent_aggregates = List::decode(reader, silent_aggregates, "silent_aggregates")?;
        let silent_entities = List::decode(reader, silent_entities, "silent_entities")?;
        let datums: u32 = reader.get("number_of_variable_datums")?;
        let variable_datums = List::decode(reader, datums as usize, "variable_datums")?;
        Ok(Self {
            aggregate_id: fixed.aggregate_id,
            force_id: fixed.force_id,
            state: fixed.state,
            aggregate_type: fixed.aggregate_type,
            formation: fixed.formation,
            marking: fixed.marking,
            dimensions_m: fixed.dimensions_m,
            orientation: fixed.orientation,
            centre_of_mass: fixed.centre_of_mass,
            velocity_mps: fixed.velocity_mps,
            aggregates,
            entities,
            padding,
            silent_aggregates,
            silent_entities,
            variable_datums,
        })
    }
}

impl AggregateState<'_> {
    fn is_padded(&self) -> bool {
        (self.aggregates.len() + self.entities.len()) % 2 == 1
    }
}

impl EncodeBody for AggregateState<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::AGGREGATE_STATE
    }
    fn body_len(&self) -> usize {
        AggregateFixed::SIZE
            + 8
            + self.aggregates.octet_len()
            + self.entities.octet_len()
            + if self.is_padded() { 2 } else { 0 }
            + self.silent_aggregates.octet_len()
            + self.silent_entities.octet_len()
            + 4
            + self.variable_datums.octet_len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&AggregateFixed {
            aggregate_id: self.aggregate_id,
            force_id: self.force_id,
            state: self.state,
            aggregate_type: self.aggregate_type,
            formation: self.formation,
            marking: self.marking,
            dimensions_m: self.dimensions_m,
            orientation: self.orientation,
            centre_of_mass: self.centre_of_mass,
            velocity_mps: self.velocity_mps,
        });
        writer.count::<u16>(self.aggregates.len(), "aggregates")?;
        writer.count::<u16>(self.entities.len(), "entities")?;
        writer.count::<u16>(self.silent_aggregates.len(), "silent_aggregates")?;
        writer.count::<u16>(self.silent_entities.len(), "silent_entities")?;
        self.aggregates.encode(writer)?;
        self.entities.encode(writer)?;
        if self.is_padded() {
            writer.put(&self.padding);
        }
        self.silent_aggregates.encode(writer)?;
        self.silent_entities.encode(writer)?;
        writer.count::<u32>(self.variable_datums.len(), "variable_datums")?;
        self.variable_datums.encode(writer)
    }
}

record! {
    /// IsPartOf (type 36): an entity as part of another. Source: IEEE 1278.1-2012, 7.8.5.
    IsPartOf {
        /// Who says so: the whole.
        originating_id: EntityId,
        /// The part.
        receiving_id: EntityId,
        /// Nature of the relationship.
        nature: PartNature,
        /// Where the part is.
        position: PartPosition,
        /// Where exactly, in the body axes of the whole, metres.
        location_m: Vector32,
        /// Station name.
        station_name: StationName,
        /// Station number.
        station_number: u16,
        /// Type of the part.
        part_type: EntityType,
    }
}
fixed_body!(IsPartOf = IS_PART_OF);

/// Records of one kind and length. Source: IEEE 1278.1-2012, 6.2.73.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordSet<'a> {
    /// What the records are: SISO-REF-010, UID 66.
    pub record_id: DatumId,
    /// Serial number of the set.
    pub serial_number: u32,
    /// Unused.
    pub padding: u32,
    /// Bits of one record.
    pub record_bits: u16,
    /// The records one after the other, without the padding to 64 bits at the end.
    pub records: &'a [u8],
}

impl<'a> Item<'a> for RecordSet<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let record_id = reader.get(field)?;
        let serial_number = reader.get(field)?;
        let padding = reader.get(field)?;
        let record_bits: u16 = reader.get(field)?;
        let count: u16 = reader.get(field)?;
        let octets = (usize::from(record_bits) * usize::from(count)).div_ceil(8);
        let records = reader.take(octets, field)?;
        reader.take(octets.next_multiple_of(8) - octets, field)?;
        Ok(Self { record_id, serial_number, padding, record_bits, records })
    }
    fn item_len(&self) -> usize {
        16 + self.records.len().next_multiple_of(8)
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let octets = self.records.len();
        let bits = usize::from(self.record_bits);
        let count = (octets * 8).checked_div(bits).unwrap_or(0);
        if (count * bits).div_ceil(8) != octets {
            return Err(EncodeError::BadSize { field: "record_sets.records", octets });
        }
        writer.put(&self.record_id);
        writer.put(&self.serial_number);
        writer.put(&self.padding);
        writer.put(&self.record_bits);
        writer.count::<u16>(count, "record_sets.records")?;
        writer.octets(self.records);
        writer.zeros(octets.next_multiple_of(8) - octets);
        Ok(())
    }
}

body! {
    /// Transfer Ownership (type 35): an entity changes its simulator. Source: IEEE 1278.1-2012, 7.8.4.
    TransferOwnership = TRANSFER_OWNERSHIP {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// Whether the PDU has to be acknowledged.
        reliability: Reliability;
        /// Kind of transfer.
        transfer_type: TransferType;
        /// The entity.
        transfer_entity: EntityId;
        count number_of_record_sets: u32 = record_sets;
        /// What the new owner needs to know.
        list record_sets: RecordSet<'a>, number_of_record_sets;
    }
}
