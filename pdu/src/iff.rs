//! Transponders and interrogators: IFF, ATC and NAVAIDS, with their layers.

use crate::codec::{DecodeBody, EncodeBody};
use crate::emission::BeamData;
use crate::enumerations::{IffSystemMode, IffSystemName, IffSystemType, PduType};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{EntityId, EventId, IffRecord, SimulationAddress, Vector32};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// Layer 1: who transmits what. Source: IEEE 1278.1-2012, 7.6.5.2 and 6.2.39.
    IffBasic {
        /// Who emits.
        emitting_entity: EntityId,
        /// Number of the event.
        event_id: EventId,
        /// Antenna in the body axes, metres.
        antenna_m: Vector32,
        /// Kind of system: transponder, interrogator …
        system_type: IffSystemType,
        /// Name of the system.
        system_name: IffSystemName,
        /// Mode.
        system_mode: IffSystemMode,
        /// Change and options bits.
        change_options: u8,
        /// Number of the system at the entity.
        system_designator: u8,
        /// Depends on the system.
        system_specific: u8,
        /// Status bits: bit 0 on, bits 1 to 6 parameter not capable, bit 7 failed.
        status: u8,
        /// Depends on the system type (alternate parameter 4).
        data_field_1: u8,
        /// Which layers the system has: bit n for layer n.
        information_layers: u8,
        /// Depends on the system type (modifier).
        data_field_2: u8,
        /// Parameter 1: for a transponder, bits 0 to 5 mode 1 code, bit 13 on, bit 14 damaged, bit 15
        /// malfunction.
        parameter_1: u16,
        /// Parameter 2: mode 2, as mode 3.
        parameter_2: u16,
        /// Parameter 3: bits 0 to 11 mode 3/A code, bit 13 on; see [`Iff::mode_3a`].
        parameter_3: u16,
        /// Parameter 4: mode 4.
        parameter_4: u16,
        /// Parameter 5: mode C altitude in 100 feet; see [`Iff::mode_c_feet`].
        parameter_5: u16,
        /// Parameter 6: mode S, TCAS.
        parameter_6: u16,
    }
}

/// IFF (type 28): a transponder or interrogator. Source: IEEE 1278.1-2012, 7.6.5.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Iff<'a> {
    /// Layer 1.
    pub basic: IffBasic,
    /// The layers that follow, each with its own length.
    pub layers: List<'a, IffLayer<'a>>,
}

impl Iff<'_> {
    /// The mode 3/A code as four octal digits in a number (0 to 0o7777), if the mode is on.
    #[must_use]
    pub fn mode_3a(&self) -> Option<u16> {
        (self.basic.parameter_3 >> 13 & 1 == 1).then_some(self.basic.parameter_3 & 0o7777)
    }

    /// The mode C altitude in feet (negative below sea level), if the mode is on. Source:
    /// IEEE 1278.1-2012, B.2.34: bit 0 negative, bits 1 to 11 hundreds of feet, bit 13 on.
    #[must_use]
    pub fn mode_c_feet(&self) -> Option<i32> {
        let word = self.basic.parameter_5;
        let feet = i32::from(word >> 1 & 0x7ff) * 100;
        (word >> 13 & 1 == 1).then_some(if word & 1 == 1 { -feet } else { feet })
    }
}

impl<'a> DecodeBody<'a> for Iff<'a> {
    const PDU_TYPE: PduType = PduType::IFF;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let basic = reader.record()?;
        let layers = List::decode_rest(reader, "layers")?;
        Ok(Self { basic, layers })
    }
}

impl EncodeBody for Iff<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::IFF
    }
    fn body_len(&self) -> usize {
        IffBasic::SIZE + self.layers.octet_len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.basic);
        self.layers.encode(writer)
    }
}

/// A layer after the first.
#[derive(Clone, Debug, PartialEq)]
pub enum IffLayer<'a> {
    /// Layer 2: emissions.
    Emissions(Layer2<'a>),
    /// Layer 3: mode 5.
    Mode5(BasicDataLayer<'a, 16>),
    /// Layer 4: mode S.
    ModeS(BasicDataLayer<'a, 24>),
    /// A layer that is not known here, or whose content does not fit its layout.
    Other {
        /// Number of the layer.
        number: u8,
        /// Depends on the layer.
        specific: u8,
        /// Everything after the layer's header.
        content: &'a [u8],
    },
}

record! {
    /// A set of fundamental parameters of layer 2. Source: IEEE 1278.1-2012, 6.2.44.
    IffParameters {
        /// Effective radiated power, dBm.
        effective_power_dbm: f32,
        /// Frequency, Hz.
        frequency_hz: f32,
        /// Pulse group repetition frequency, Hz.
        group_repetition_hz: f32,
        /// Pulse width, µs.
        pulse_width_us: f32,
        /// Pulses of a burst.
        burst_length: u32,
        /// Modes: SISO-REF-010, UID 339.
        applicable_modes: u8,
        /// Depends on the system.
        system_specific: [u8; 3],
    }
}

/// Layer 2: emissions. Source: IEEE 1278.1-2012, 7.6.5.3.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer2<'a> {
    /// Layer-specific information.
    pub specific: u8,
    /// Direction and sweep of the beam.
    pub beam: BeamData,
    /// Secondary operational data, parameter 1.
    pub parameter_1: u8,
    /// Secondary operational data, parameter 2.
    pub parameter_2: u8,
    /// Fundamental parameters.
    pub parameters: List<'a, IffParameters>,
}

/// Layers 3 and 4: basic data of `N` octets and data records. Source: IEEE 1278.1-2012, 7.6.5.4 and
/// 7.6.5.5.
///
/// For layer 4 see [`ModeSTransponder`].
#[derive(Clone, Debug, PartialEq)]
pub struct BasicDataLayer<'a, const N: usize> {
    /// Layer-specific information.
    pub specific: u8,
    /// Who reports.
    pub reporting_simulation: SimulationAddress,
    /// Basic data of an interrogator or transponder, as the system type of layer 1 says.
    pub basic_data: [u8; N],
    /// Unused.
    pub padding: u16,
    /// Data records.
    pub records: List<'a, IffRecord<'a>>,
}

impl<const N: usize> Default for BasicDataLayer<'_, N> {
    fn default() -> Self {
        Self {
            specific: 0,
            reporting_simulation: SimulationAddress::default(),
            basic_data: [0; N],
            padding: 0,
            records: List::default(),
        }
    }
}

record! {
    /// Basic data of a Mode S transponder: the 24 octets of layer 4. Source: IEEE 1278.1-2012, B.2.41.
    ModeSTransponder {
        /// Squitter and report bits.
        status: u16,
        /// Levels of Mode S that are present.
        levels_present: u8,
        /// Whether the aircraft is on the ground: SISO-REF-010, UID 356.
        aircraft_present_domain: u8,
        /// Aircraft identification, eight characters.
        aircraft_identification: [u8; 8],
        /// The 24-bit address of ICAO.
        aircraft_address: u32,
        /// Kind of identification: SISO-REF-010, UID 357.
        identification_type: u8,
        /// Which downlinked parameters have records.
        dap_source: u8,
        /// Altitude.
        altitude: u16,
        /// Capability report: SISO-REF-010, UID 358.
        capability_report: u8,
        /// Unused, or the rest of the record.
        padding: [u8; 3],
    }
}

impl<const N: usize> BasicDataLayer<'_, N> {
    /// Layer 4 of a transponder: its basic data as fields.
    #[must_use]
    pub fn mode_s_transponder(&self) -> Option<ModeSTransponder> {
        (N == ModeSTransponder::SIZE).then(|| ModeSTransponder::get(&self.basic_data))
    }
}

impl From<ModeSTransponder> for BasicDataLayer<'_, 24> {
    fn from(data: ModeSTransponder) -> Self {
        let mut layer = Self::default();
        data.put(&mut layer.basic_data);
        layer
    }
}

/// Octets of a layer's header: number, specific information, length.
const LAYER_HEADER: usize = 4;

impl<'a> Layer2<'a> {
    fn read(specific: u8, mut reader: Reader<'a>) -> Result<Self, BodyError> {
        let beam = reader.get("layers.beam")?;
        let parameter_1 = reader.get("layers.parameter_1")?;
        let parameter_2 = reader.get("layers.parameter_2")?;
        let count: u16 = reader.get("layers.number_of_parameters")?;
        let parameters = List::decode(&mut reader, count.into(), "layers.parameters")?;
        reader.finish()?;
        Ok(Self { specific, beam, parameter_1, parameter_2, parameters })
    }
}

impl<'a, const N: usize> BasicDataLayer<'a, N> {
    fn read(specific: u8, mut reader: Reader<'a>) -> Result<Self, BodyError> {
        let reporting_simulation = reader.get("layers.reporting_simulation")?;
        let mut basic_data = [0; N];
        basic_data.copy_from_slice(reader.take(N, "layers.basic_data")?);
        let padding = reader.get("layers.padding")?;
        let count: u16 = reader.get("layers.number_of_records")?;
        let records = List::decode(&mut reader, count.into(), "layers.records")?;
        reader.finish()?;
        Ok(Self { specific, reporting_simulation, basic_data, padding, records })
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.reporting_simulation);
        writer.octets(&self.basic_data);
        writer.put(&self.padding);
        writer.count::<u16>(self.records.len(), "layers.records")?;
        self.records.encode(writer)
    }
}

impl<'a> Item<'a> for IffLayer<'a> {
    const FIXED: Option<usize> = None;

    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let number: u8 = reader.get(field)?;
        let specific = reader.get(field)?;
        let length: u16 = reader.get(field)?;
        let Some(octets) = usize::from(length).checked_sub(LAYER_HEADER) else {
            return Err(reader.bad_length(field, length.into()));
        };
        let part = reader.clone().part(octets, field)?;
        let content = reader.take(octets, field)?;
        let typed = match number {
            2 => Layer2::read(specific, part).map(Self::Emissions).ok(),
            3 => BasicDataLayer::read(specific, part).map(Self::Mode5).ok(),
            4 => BasicDataLayer::read(specific, part).map(Self::ModeS).ok(),
            _ => None,
        };
        Ok(typed.unwrap_or(Self::Other { number, specific, content }))
    }

    fn item_len(&self) -> usize {
        LAYER_HEADER
            + match self {
                Self::Emissions(layer) => BeamData::SIZE + 4 + layer.parameters.octet_len(),
                Self::Mode5(layer) => 24 + layer.records.octet_len(),
                Self::ModeS(layer) => 32 + layer.records.octet_len(),
                Self::Other { content, .. } => content.len(),
            }
    }

    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let (number, specific) = match self {
            Self::Emissions(layer) => (2, layer.specific),
            Self::Mode5(layer) => (3, layer.specific),
            Self::ModeS(layer) => (4, layer.specific),
            Self::Other { number, specific, .. } => (*number, *specific),
        };
        writer.put(&number);
        writer.put(&specific);
        writer.count::<u16>(self.item_len(), "layers")?;
        match self {
            Self::Emissions(layer) => {
                writer.put(&layer.beam);
                writer.put(&layer.parameter_1);
                writer.put(&layer.parameter_2);
                writer.count::<u16>(layer.parameters.len(), "layers.parameters")?;
                layer.parameters.encode(writer)
            }
            Self::Mode5(layer) => layer.write(writer),
            Self::ModeS(layer) => layer.write(writer),
            Self::Other { content, .. } => {
                writer.octets(content);
                Ok(())
            }
        }
    }
}
