//! Records that several PDUs share.

use crate::enumerations::{
    Country, DatumId, EntityKind, MarkingCharacterSet, PlatformDomain, StationName,
    VariableParameterType,
};
use crate::list::Item;
use crate::reader::{BodyError, Reader};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};
use geodesy::{Ecef, Euler};

record! {
    /// Entity identifier. Source: IEEE 1278.1-2012, 6.2.28.
    #[derive(Eq, PartialOrd, Ord, Hash)]
    EntityId {
        /// Site.
        site: u16,
        /// Application at the site.
        application: u16,
        /// Entity of the application.
        entity: u16,
    }
}

impl EntityId {
    /// Everybody: receiving identifier of simulation management to all (site, application, entity
    /// 65535).
    pub const ALL: Self = Self { site: 0xffff, application: 0xffff, entity: 0xffff };
    /// Nobody: an identifier that says nothing.
    pub const NONE: Self = Self { site: 0, application: 0, entity: 0 };

    /// From its three numbers.
    #[must_use]
    pub const fn new(site: u16, application: u16, entity: u16) -> Self {
        Self { site, application, entity }
    }

    /// True if `self`, as a receiving identifier with its wildcards, addresses `id`.
    #[must_use]
    pub fn addresses(self, id: Self) -> bool {
        let fits = |wanted: u16, actual: u16| wanted == 0xffff || wanted == actual;
        fits(self.site, id.site)
            && fits(self.application, id.application)
            && fits(self.entity, id.entity)
    }
}

impl std::fmt::Display for EntityId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.site, self.application, self.entity)
    }
}

record! {
    /// Simulation address: site and application. Source: IEEE 1278.1-2012, 6.2.80.
    #[derive(Eq, PartialOrd, Ord, Hash)]
    SimulationAddress {
        /// Site.
        site: u16,
        /// Application at the site.
        application: u16,
    }
}

record! {
    /// Event identifier. Source: IEEE 1278.1-2012, 6.2.33.
    #[derive(Eq, PartialOrd, Ord, Hash)]
    EventId {
        /// Site.
        site: u16,
        /// Application at the site.
        application: u16,
        /// Event of the application.
        event: u16,
    }
}

record! {
    /// Entity type, seven numbers from coarse to fine. Source: IEEE 1278.1-2012, 6.2.30;
    /// SISO-REF-010, UID 30.
    #[derive(Eq, PartialOrd, Ord, Hash)]
    EntityType {
        /// Platform, munition, life form …
        kind: EntityKind,
        /// Land, air, surface … ([`PlatformDomain`] for platforms).
        domain: u8,
        /// Country of design.
        country: Country,
        /// Main category; see `LandCategory` and `AirCategory` for platforms.
        category: u8,
        /// Subcategory.
        subcategory: u8,
        /// Specific type.
        specific: u8,
        /// Anything more.
        extra: u8,
    }
}

impl EntityType {
    /// From its seven numbers.
    #[must_use]
    pub const fn new(
        kind: u8,
        domain: u8,
        country: u16,
        category: u8,
        subcategory: u8,
        specific: u8,
        extra: u8,
    ) -> Self {
        let (kind, country) = (EntityKind(kind), Country(country));
        Self { kind, domain, country, category, subcategory, specific, extra }
    }

    /// The domain as that of a platform.
    #[must_use]
    pub fn platform_domain(self) -> PlatformDomain {
        PlatformDomain(self.domain)
    }
}

impl std::fmt::Display for EntityType {
    /// The usual notation `1.2.225.57.1.2.0`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { kind, domain, country, category, subcategory, specific, extra } = self;
        write!(f, "{}.{domain}.{}.{category}.{subcategory}.{specific}.{extra}", kind.0, country.0)
    }
}

record! {
    /// Three 32-bit numbers: a velocity, an acceleration, a position relative to an entity …; units and
    /// axes are those of the field. Source: IEEE 1278.1-2012, 6.2.96.
    Vector32 {
        /// First component.
        x: f32,
        /// Second component.
        y: f32,
        /// Third component.
        z: f32,
    }
}

impl Vector32 {
    /// Nearest 32-bit values.
    #[must_use]
    pub fn from_f64(v: [f64; 3]) -> Self {
        Self { x: v[0] as f32, y: v[1] as f32, z: v[2] as f32 }
    }
    /// As 64-bit values.
    #[must_use]
    pub fn to_f64(self) -> [f64; 3] {
        [f64::from(self.x), f64::from(self.y), f64::from(self.z)]
    }
}

record! {
    /// World coordinates: earth-centred, earth-fixed, metres. Source: IEEE 1278.1-2012, 6.2.97.
    Location {
        /// Towards 0° N 0° E, metres.
        x_m: f64,
        /// Towards 0° N 90° E, metres.
        y_m: f64,
        /// Towards the north pole, metres.
        z_m: f64,
    }
}

impl From<Ecef> for Location {
    fn from(p: Ecef) -> Self {
        Self { x_m: p.x_m, y_m: p.y_m, z_m: p.z_m }
    }
}
impl From<Location> for Ecef {
    fn from(p: Location) -> Self {
        Self { x_m: p.x_m, y_m: p.y_m, z_m: p.z_m }
    }
}

record! {
    /// Euler angles, radians. Source: IEEE 1278.1-2012, 6.2.32.
    Orientation {
        /// About z.
        psi_rad: f32,
        /// About y.
        theta_rad: f32,
        /// About x.
        phi_rad: f32,
    }
}

impl From<Euler> for Orientation {
    /// Nearest 32-bit values.
    fn from(e: Euler) -> Self {
        Self { psi_rad: e.psi_rad as f32, theta_rad: e.theta_rad as f32, phi_rad: e.phi_rad as f32 }
    }
}
impl From<Orientation> for Euler {
    fn from(o: Orientation) -> Self {
        Self {
            psi_rad: f64::from(o.psi_rad),
            theta_rad: f64::from(o.theta_rad),
            phi_rad: f64::from(o.phi_rad),
        }
    }
}

/// A text in a field of fixed size, padded with zeros; as on the wire, whatever that is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Text<const N: usize> {
    /// Character set.
    pub character_set: MarkingCharacterSet,
    /// The octets, padding included.
    pub octets: [u8; N],
}

/// Entity marking: a call sign or other label of at most 11 characters. Source: IEEE 1278.1-2012,
/// 6.2.29.
///
/// ```
/// use pdu::records::Marking;
/// assert_eq!(Marking::new("SWR 1234").unwrap().text(), "SWR 1234");
/// assert!(Marking::new("twelve chars").is_err()); // never cut in silence
/// ```
pub type Marking = Text<11>;

/// Marking of an aggregate, at most 31 characters. Source: IEEE 1278.1-2012, 6.2.4.
pub type AggregateMarking = Text<31>;

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self { character_set: MarkingCharacterSet::ASCII, octets: [0; N] }
    }
}

impl<const N: usize> Text<N> {
    /// An ASCII text, padded with zeros.
    ///
    /// # Errors
    /// If it is longer than the field or not ASCII.
    pub fn new(text: &str) -> Result<Self, EncodeError> {
        let mut octets = [0; N];
        match octets.get_mut(..text.len()) {
            Some(start) if text.is_ascii() => start.copy_from_slice(text.as_bytes()),
            _ => {
                let octets = text.len();
                return Err(EncodeError::TextTooLong { field: "marking", octets, max: N });
            }
        }
        Ok(Self { character_set: MarkingCharacterSet::ASCII, octets })
    }

    /// The text up to the first zero, without blanks at its end; octets that are no printable ASCII
    /// are shown as `?`.
    #[must_use]
    pub fn text(&self) -> String {
        let end = self.octets.iter().position(|&c| c == 0).unwrap_or(N);
        let show = |&c: &u8| if (b' '..=b'~').contains(&c) { c as char } else { '?' };
        let text: String = self.octets[..end].iter().map(show).collect();
        text.trim_end().to_owned()
    }
}

impl<const N: usize> std::fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

impl<const N: usize> Wire for Text<N> {
    const SIZE: usize = 1 + N;
    #[inline(always)]
    fn get(octets: &[u8]) -> Self {
        let mut text = [0; N];
        text.copy_from_slice(&octets[1..]);
        Self { character_set: MarkingCharacterSet(octets[0]), octets: text }
    }
    #[inline(always)]
    fn put(&self, octets: &mut [u8]) {
        octets[0] = self.character_set.0;
        octets[1..].copy_from_slice(&self.octets);
    }
}

record! {
    /// Clock time: whole hours since 1 January 1970 UTC and a time past the hour. Source:
    /// IEEE 1278.1-2012, 6.2.16.
    #[derive(Eq)]
    ClockTime {
        /// Hours since 1 January 1970, 0 h UTC.
        hour: i32,
        /// Time past that hour.
        past_hour: crate::DisTime,
    }
}

impl ClockTime {
    /// From nanoseconds since 1 January 1970 UTC (also of simulated time), nearest unit.
    #[must_use]
    pub fn from_unix_nanos(nanos: i64) -> Self {
        let hour_ns = crate::time::NANOS_PER_HOUR as i64;
        let past = nanos.rem_euclid(hour_ns);
        let past_hour = crate::DisTime::absolute(past as u64);
        // Rounded up into the next hour?
        let carry = i64::from(past > hour_ns / 2 && past_hour.units() == 0);
        Self { hour: (nanos.div_euclid(hour_ns) + carry) as i32, past_hour }
    }

    /// Nanoseconds since 1 January 1970 UTC. The field reaches ±245 000 years, 64 bits of nanoseconds
    /// 292: what lies beyond is the first or last moment that they can say.
    #[must_use]
    pub fn unix_nanos(self) -> i64 {
        let hours = i128::from(self.hour) * i128::from(crate::time::NANOS_PER_HOUR);
        let nanos = hours + i128::from(self.past_hour.nanos_past_hour());
        nanos.clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }
}

record! {
    /// Fixed datum: an identifier and 32 bits. Source: IEEE 1278.1-2012, 6.2.37.
    #[derive(Eq)]
    FixedDatum {
        /// What it is.
        id: DatumId,
        /// The value's octets, big-endian.
        value: [u8; 4],
    }
}

impl FixedDatum {
    /// A datum of an unsigned number.
    #[must_use]
    pub fn from_u32(id: DatumId, value: u32) -> Self {
        Self { id, value: value.to_be_bytes() }
    }
    /// A datum of a 32-bit float.
    #[must_use]
    pub fn from_f32(id: DatumId, value: f32) -> Self {
        Self { id, value: value.to_be_bytes() }
    }
    /// The value as an unsigned number.
    #[must_use]
    pub fn as_u32(self) -> u32 {
        u32::from_be_bytes(self.value)
    }
    /// The value as a 32-bit float.
    #[must_use]
    pub fn as_f32(self) -> f32 {
        f32::from_be_bytes(self.value)
    }
}

/// Variable datum: an identifier and any number of bits, padded to 64. Source: IEEE 1278.1-2012,
/// 6.2.93.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VariableDatum<'a> {
    /// What it is.
    pub id: DatumId,
    /// The value's octets, without padding. A length that is no multiple of 8 bits (`bits`) leaves
    /// the low bits of the last octet unused.
    pub value: &'a [u8],
    /// Unused low bits of the last octet, 0 to 7.
    pub unused_bits: u8,
}

impl<'a> VariableDatum<'a> {
    /// A datum of whole octets.
    #[must_use]
    pub fn new(id: DatumId, value: &'a [u8]) -> Self {
        Self { id, value, unused_bits: 0 }
    }
}

impl<'a> Item<'a> for VariableDatum<'a> {
    const FIXED: Option<usize> = None;

    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let id = reader.get(field)?;
        let bits: u32 = reader.get(field)?;
        let octets = bits.div_ceil(8) as usize;
        let value = reader.take(octets, field)?;
        // Some senders leave out the padding of the last datum.
        if reader.left() > 0 {
            reader.take(octets.next_multiple_of(8) - octets, field)?;
        }
        Ok(Self { id, value, unused_bits: (octets as u64 * 8 - u64::from(bits)) as u8 })
    }

    fn item_len(&self) -> usize {
        8 + self.value.len().next_multiple_of(8)
    }

    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let octets = self.value.len();
        let bits = (octets * 8).checked_sub(usize::from(self.unused_bits));
        let Some(bits) = bits.filter(|_| self.unused_bits < 8) else {
            return Err(EncodeError::BadSize { field: "variable_datum.unused_bits", octets });
        };
        writer.put(&self.id);
        writer.count::<u32>(bits, "variable_datum.value")?;
        writer.octets(self.value);
        writer.zeros(octets.next_multiple_of(8) - octets);
        Ok(())
    }
}

record! {
    /// An articulated part and one of its metrics. Source: IEEE 1278.1-2012, 6.2.94.2.
    ArticulatedPart {
        /// Counts changes of the part.
        change: u8,
        /// The part it is attached to, 0 for the entity.
        attached_to: u16,
        /// Type class plus type metric: SISO-REF-010, UID 58 and 59.
        parameter_type: u32,
        /// The metric's value: radians, metres, or per second of these.
        value: f32,
        /// Unused.
        padding: u32,
    }
}

record! {
    /// A removable part, and what is attached to the station. Source: IEEE 1278.1-2012, 6.2.94.3.
    AttachedPart {
        /// 0 attached, 1 detached.
        detached: u8,
        /// The part it is attached to, 0 for the entity.
        attached_to: u16,
        /// The station: SISO-REF-010, UID 57.
        station: crate::enumerations::AttachedPartStation,
        /// What is attached.
        part_type: EntityType,
    }
}

record! {
    /// An entity has separated from another. Source: IEEE 1278.1-2012, 6.2.94.6.
    Separation {
        /// Why: SISO-REF-010, UID 282.
        reason: u8,
        /// Whether the entity existed before: SISO-REF-010, UID 283.
        pre_entity: u8,
        /// Unused.
        padding1: u8,
        /// The entity it was part of.
        parent: EntityId,
        /// Unused.
        padding2: u16,
        /// Station name.
        station_name: StationName,
        /// Station number.
        station_number: u16,
    }
}

record! {
    /// A type that differs from that of the PDU. Source: IEEE 1278.1-2012, 6.2.94.5.
    EntityTypeParameter {
        /// Counts changes.
        change: u8,
        /// The type.
        entity_type: EntityType,
        /// Unused.
        padding: [u8; 6],
    }
}

record! {
    /// An association with another entity without attachment. Source: IEEE 1278.1-2012, 6.2.94.4.
    EntityAssociation {
        /// Counts changes.
        change: u8,
        /// Status: SISO-REF-010, UID 319.
        status: u8,
        /// Type: SISO-REF-010, UID 323.
        association_type: u8,
        /// The other entity.
        entity: EntityId,
        /// Station at the own entity.
        own_station: StationName,
        /// Physical connection: SISO-REF-010, UID 324.
        connection: u8,
        /// Group member type: SISO-REF-010, UID 321.
        member_type: u8,
        /// Group number.
        group: u16,
    }
}

/// A variable parameter of an Entity State PDU, 16 octets. Source: IEEE 1278.1-2012, 6.2.94.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VariableParameter {
    /// An articulated part.
    Articulated(ArticulatedPart),
    /// An attached part.
    Attached(AttachedPart),
    /// A separation.
    Separation(Separation),
    /// Another entity type.
    EntityType(EntityTypeParameter),
    /// An association.
    Association(EntityAssociation),
    /// A kind that is not known here: its number and its octets.
    Other {
        /// The record type.
        record_type: VariableParameterType,
        /// The other 15 octets.
        octets: [u8; 15],
    },
}

impl Default for VariableParameter {
    fn default() -> Self {
        Self::Articulated(ArticulatedPart::default())
    }
}

impl Wire for VariableParameter {
    const SIZE: usize = 16;

    #[inline]
    fn get(octets: &[u8]) -> Self {
        let rest = &octets[1..16];
        match octets[0] {
            0 => Self::Articulated(Wire::get(rest)),
            1 => Self::Attached(Wire::get(rest)),
            2 => Self::Separation(Wire::get(rest)),
            3 => Self::EntityType(Wire::get(rest)),
            4 => Self::Association(Wire::get(rest)),
            other => {
                Self::Other { record_type: VariableParameterType(other), octets: Wire::get(rest) }
            }
        }
    }

    #[inline]
    fn put(&self, octets: &mut [u8]) {
        let (kind, rest) = octets.split_at_mut(1);
        kind[0] = match self {
            Self::Articulated(part) => {
                part.put(rest);
                0
            }
            Self::Attached(part) => {
                part.put(rest);
                1
            }
            Self::Separation(part) => {
                part.put(rest);
                2
            }
            Self::EntityType(part) => {
                part.put(rest);
                3
            }
            Self::Association(part) => {
                part.put(rest);
                4
            }
            Self::Other { record_type, octets } => {
                octets.put(rest);
                record_type.0
            }
        };
    }
}

/// A record with its type and its length in octets, padded to `ALIGN` octets; the length says the
/// padding too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TypedRecord<'a, const ALIGN: usize> {
    /// Type of the record: SISO-REF-010, UID 66.
    pub record_type: DatumId,
    /// The content. Decoded, it has the padding at its end; to be encoded, padding is added.
    pub content: &'a [u8],
}

/// Attribute record of an Attribute PDU. Source: IEEE 1278.1-2012, 6.2.10.
pub type AttributeRecord<'a> = TypedRecord<'a, 8>;
/// Variable transmitter parameter. Source: IEEE 1278.1-2012, 6.2.95.
pub type TransmitterRecord<'a> = TypedRecord<'a, 8>;
/// Data record of an IFF layer. Source: IEEE 1278.1-2012, 6.2.43.
pub type IffRecord<'a> = TypedRecord<'a, 4>;

/// Octets of type and length before the content.
const TYPED_RECORD_HEADER: usize = 6;

impl<'a, const ALIGN: usize> Item<'a> for TypedRecord<'a, ALIGN> {
    const FIXED: Option<usize> = None;

    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let record_type = reader.get(field)?;
        let length: u16 = reader.get(field)?;
        let Some(content) = usize::from(length).checked_sub(TYPED_RECORD_HEADER) else {
            return Err(reader.bad_length(field, u64::from(length)));
        };
        Ok(Self { record_type, content: reader.take(content, field)? })
    }

    fn item_len(&self) -> usize {
        (TYPED_RECORD_HEADER + self.content.len()).next_multiple_of(ALIGN)
    }

    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.record_type);
        writer.count::<u16>(self.item_len(), "record.content")?;
        writer.octets(self.content);
        writer.zeros(self.item_len() - TYPED_RECORD_HEADER - self.content.len());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_hour_of_the_wire_has_a_time() {
        let at = |hour| ClockTime { hour, past_hour: crate::DisTime(1) }.unix_nanos();
        assert_eq!((at(i32::MIN), at(i32::MAX)), (i64::MIN, i64::MAX));
        // The last whole hour of 64 bits, and the next.
        assert_eq!(at(2_562_047), 2_562_047 * 3_600_000_000_000);
        assert_eq!(at(2_562_048), i64::MAX);
    }
}
