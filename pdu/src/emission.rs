//! Electromagnetic emissions and designators.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{
    BeamFunction, DeadReckoningAlgorithm, EmitterFunction, EmitterName, HighDensityTrackJam,
    PduType, StateUpdateIndicator,
};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{EntityId, EventId, Location, Vector32};
use crate::writer::{EncodeError, Writer};

/// Electromagnetic Emission (type 23). Source: IEEE 1278.1-2012, 7.6.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ElectromagneticEmission<'a> {
    /// Who emits.
    pub emitting_entity: EntityId,
    /// Number of the event.
    pub event_id: EventId,
    /// Whether only what changed is sent, or everything.
    pub state_update: StateUpdateIndicator,
    /// Unused.
    pub padding: u16,
    /// Emitter systems with their beams.
    pub systems: List<'a, EmitterSystem<'a>>,
}

impl<'a> DecodeBody<'a> for ElectromagneticEmission<'a> {
    const PDU_TYPE: PduType = PduType::ELECTROMAGNETIC_EMISSION;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let emitting_entity = reader.get("emitting_entity")?;
        let event_id = reader.get("event_id")?;
        let state_update = reader.get("state_update")?;
        let count: u8 = reader.get("number_of_systems")?;
        let padding = reader.get("padding")?;
        let systems = List::decode(reader, count.into(), "systems")?;
        Ok(Self { emitting_entity, event_id, state_update, padding, systems })
    }
}

impl EncodeBody for ElectromagneticEmission<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::ELECTROMAGNETIC_EMISSION
    }
    fn body_len(&self) -> usize {
        16 + self.systems.octet_len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.emitting_entity);
        writer.put(&self.event_id);
        writer.put(&self.state_update);
        writer.count::<u8>(self.systems.len(), "systems")?;
        writer.put(&self.padding);
        self.systems.encode(writer)
    }
}

/// An emitter system. Source: IEEE 1278.1-2012, 6.2.23.
///
/// Its length on the wire counts 32-bit words, 0 where that does not fit. A length beyond the beams
/// leaves `extra` octets, which are kept; one that ends inside them is an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmitterSystem<'a> {
    /// Unused.
    pub padding: u16,
    /// Name.
    pub name: EmitterName,
    /// What it does.
    pub function: EmitterFunction,
    /// Number of the system at the entity.
    pub number: u8,
    /// Where, in the body axes, metres.
    pub location_m: Vector32,
    /// Its beams.
    pub beams: List<'a, Beam<'a>>,
    /// Octets after the beams that the length includes.
    pub extra: &'a [u8],
}

/// A length in 32-bit words, or 0 where it does not fit.
fn words(octets: usize) -> u8 {
    u8::try_from(octets / 4).unwrap_or(0)
}

/// The octets that a length in words leaves after what was read since `start`.
fn extra<'a>(
    reader: &mut Reader<'a>,
    start: usize,
    words: u8,
    field: &'static str,
) -> Result<&'a [u8], BodyError> {
    if words == 0 {
        return Ok(&[]);
    }
    let used = reader.offset() - start;
    match (usize::from(words) * 4).checked_sub(used) {
        Some(more) => reader.take(more, field),
        None => Err(reader.bad_length(field, words.into())),
    }
}

impl<'a> Item<'a> for EmitterSystem<'a> {
    const FIXED: Option<usize> = None;

    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let start = reader.offset();
        let words: u8 = reader.get(field)?;
        let beams: u8 = reader.get(field)?;
        let padding = reader.get(field)?;
        let name = reader.get(field)?;
        let function = reader.get(field)?;
        let number = reader.get(field)?;
        let location_m = reader.get(field)?;
        let beams = List::decode(reader, beams.into(), "beams")?;
        let extra = extra(reader, start, words, "system_data_length")?;
        Ok(Self { padding, name, function, number, location_m, beams, extra })
    }

    fn item_len(&self) -> usize {
        20 + self.beams.octet_len() + self.extra.len()
    }

    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let octets = self.item_len();
        if !octets.is_multiple_of(4) {
            return Err(EncodeError::BadSize { field: "systems.extra", octets });
        }
        writer.put(&words(octets));
        writer.count::<u8>(self.beams.len(), "beams")?;
        writer.put(&self.padding);
        writer.put(&self.name);
        writer.put(&self.function);
        writer.put(&self.number);
        writer.put(&self.location_m);
        self.beams.encode(writer)?;
        writer.octets(self.extra);
        Ok(())
    }
}

record! {
    /// Fundamental parameters of a beam. Source: IEEE 1278.1-2012, 6.2.22.
    FundamentalParameters {
        /// Centre frequency, Hz.
        frequency_hz: f32,
        /// Bandwidth, Hz.
        frequency_range_hz: f32,
        /// Effective radiated power, dBm.
        effective_power_dbm: f32,
        /// Pulse repetition frequency, Hz.
        pulse_repetition_hz: f32,
        /// Pulse width, µs.
        pulse_width_us: f32,
    }
}

record! {
    /// Where a beam points. Source: IEEE 1278.1-2012, 6.2.11.
    BeamData {
        /// Centre of the sweep in azimuth, rad, body axes.
        azimuth_centre_rad: f32,
        /// Half of the sweep in azimuth, rad.
        azimuth_sweep_rad: f32,
        /// Centre of the sweep in elevation, rad.
        elevation_centre_rad: f32,
        /// Half of the sweep in elevation, rad.
        elevation_sweep_rad: f32,
        /// Share of the pattern that is done, percent.
        sweep_sync_percent: f32,
    }
}

record! {
    /// A target that a beam tracks or jams. Source: IEEE 1278.1-2012, 6.2.90.
    TrackJam {
        /// The target.
        entity: EntityId,
        /// Emitter number, where an emitter is jammed.
        emitter: u8,
        /// Beam number, where an emitter is jammed.
        beam: u8,
    }
}

/// A beam of an emitter system. Source: IEEE 1278.1-2012, 7.6.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beam<'a> {
    /// Number of the beam in the system.
    pub number: u8,
    /// Index into a data base of parameters.
    pub parameter_index: u16,
    /// Frequency, power, pulses.
    pub parameters: FundamentalParameters,
    /// Direction and sweep.
    pub data: BeamData,
    /// What the beam does.
    pub function: BeamFunction,
    /// Whether there are more targets than listed.
    pub high_density: HighDensityTrackJam,
    /// Bit 0: deactivated (DIS 7; unused before).
    pub status: u8,
    /// Jamming technique: kind, category, subcategory, specific.
    pub jamming_technique: [u8; 4],
    /// The targets.
    pub targets: List<'a, TrackJam>,
    /// Octets after the targets that the length includes.
    pub extra: &'a [u8],
}

impl<'a> Item<'a> for Beam<'a> {
    const FIXED: Option<usize> = None;

    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let start = reader.offset();
        let words: u8 = reader.get(field)?;
        let number = reader.get(field)?;
        let parameter_index = reader.get(field)?;
        let parameters = reader.get("beams.parameters")?;
        let data = reader.get("beams.data")?;
        let function = reader.get(field)?;
        let targets: u8 = reader.get(field)?;
        let high_density = reader.get(field)?;
        let status = reader.get(field)?;
        let jamming_technique = reader.get("beams.jamming_technique")?;
        let targets = List::decode(reader, targets.into(), "targets")?;
        let extra = extra(reader, start, words, "beam_data_length")?;
        Ok(Self {
            number,
            parameter_index,
            parameters,
            data,
            function,
            high_density,
            status,
            jamming_technique,
            targets,
            extra,
        })
    }

    fn item_len(&self) -> usize {
        52 + self.targets.octet_len() + self.extra.len()
    }

    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let octets = self.item_len();
        if !octets.is_multiple_of(4) {
            return Err(EncodeError::BadSize { field: "beams.extra", octets });
        }
        writer.put(&words(octets));
        writer.put(&self.number);
        writer.put(&self.parameter_index);
        writer.put(&self.parameters);
        writer.put(&self.data);
        writer.put(&self.function);
        writer.count::<u8>(self.targets.len(), "targets")?;
        writer.put(&self.high_density);
        writer.put(&self.status);
        writer.put(&self.jamming_technique);
        self.targets.encode(writer)?;
        writer.octets(self.extra);
        Ok(())
    }
}

record! {
    /// Designator (type 24): a laser spot. Source: IEEE 1278.1-2012, 7.6.3.
    Designator {
        /// Who designates.
        designating_entity: EntityId,
        /// System name: SISO-REF-010, UID 80.
        system_name: u16,
        /// What is designated.
        designated_entity: EntityId,
        /// Code.
        code: u16,
        /// Power, W.
        power_w: f32,
        /// Wavelength, µm.
        wavelength_um: f32,
        /// The spot in the body axes of the designated entity, metres.
        spot_in_entity_m: Vector32,
        /// The spot in world coordinates.
        spot: Location,
        /// Dead reckoning of the spot.
        dead_reckoning_algorithm: DeadReckoningAlgorithm,
        /// Unused.
        padding: [u8; 3],
        /// Acceleration of the spot, m/s², world axes.
        acceleration_mps2: Vector32,
    }
}
fixed_body!(Designator = DESIGNATOR);
