//! Radios: transmitters, signals, receivers.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{
    AntennaPatternType, CryptoSystem, InputSource, MajorModulation, ModulationSystem, PduType,
    ReceiverState, TdlType, TransmitState,
};
use crate::list::List;
use crate::reader::{BodyError, Reader};
use crate::records::{EntityId, EntityType, Location, TransmitterRecord, Vector32};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// Modulation. Source: IEEE 1278.1-2012, 6.2.59.
    #[derive(Eq)]
    Modulation {
        /// Spread spectrum bits: 0 frequency hopping, 1 pseudo noise, 2 time hopping.
        spread_spectrum: u16,
        /// Major modulation.
        major: MajorModulation,
        /// Detail: SISO-REF-010, UID 156 to 162 by the major modulation.
        detail: u16,
        /// System.
        system: ModulationSystem,
    }
}

record! {
    /// Everything of a Transmitter PDU before its parts of variable size.
    TransmitterFixed {
        /// The radio's entity.
        radio_entity: EntityId,
        /// Number of the radio at the entity.
        radio_number: u16,
        /// Type of the radio.
        radio_type: EntityType,
        /// Off, on, transmitting.
        transmit_state: TransmitState,
        /// Where the audio comes from.
        input_source: InputSource,
        /// Number of records; unused before DIS 7.
        number_of_records: u16,
        /// Antenna in world coordinates.
        antenna_location: Location,
        /// Antenna in body axes, metres.
        relative_antenna_m: Vector32,
        /// Kind of antenna pattern.
        antenna_pattern_type: AntennaPatternType,
        /// Octets of the antenna pattern.
        antenna_pattern_length: u16,
        /// Centre frequency, Hz.
        frequency_hz: u64,
        /// Bandwidth, Hz.
        bandwidth_hz: f32,
        /// Power, dBm.
        power_dbm: f32,
        /// Modulation.
        modulation: Modulation,
        /// Encryption.
        crypto_system: CryptoSystem,
        /// Key.
        crypto_key: u16,
        /// Octets of modulation parameters.
        modulation_parameters_length: u8,
        /// Unused.
        padding: [u8; 3],
    }
}

/// Transmitter (type 25): a radio that is on the air or could be. Source: IEEE 1278.1-2012, 7.7.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transmitter<'a> {
    /// The radio's entity.
    pub radio_entity: EntityId,
    /// Number of the radio at the entity.
    pub radio_number: u16,
    /// Type of the radio.
    pub radio_type: EntityType,
    /// Off, on, transmitting.
    pub transmit_state: TransmitState,
    /// Where the audio comes from.
    pub input_source: InputSource,
    /// Antenna in world coordinates.
    pub antenna_location: Location,
    /// Antenna in body axes, metres.
    pub relative_antenna_m: Vector32,
    /// Kind of antenna pattern.
    pub antenna_pattern_type: AntennaPatternType,
    /// Centre frequency, Hz.
    pub frequency_hz: u64,
    /// Bandwidth, Hz.
    pub bandwidth_hz: f32,
    /// Power, dBm.
    pub power_dbm: f32,
    /// Modulation.
    pub modulation: Modulation,
    /// Encryption.
    pub crypto_system: CryptoSystem,
    /// Key.
    pub crypto_key: u16,
    /// Unused.
    pub padding: [u8; 3],
    /// Modulation parameters, whose layout depends on the modulation system.
    pub modulation_parameters: &'a [u8],
    /// Antenna pattern, whose layout depends on its type; see [`BeamAntennaPattern`].
    pub antenna_pattern: &'a [u8],
    /// Variable transmitter parameters (DIS 7).
    pub records: List<'a, TransmitterRecord<'a>>,
    /// Before DIS 7, the unused word where the number of records is now.
    pub unused: u16,
}

record! {
    /// A beam as antenna pattern (type 1), 40 octets. Source: IEEE 1278.1-2012, 6.2.8.2.
    BeamAntennaPattern {
        /// Direction as Euler angles.
        direction: crate::records::Orientation,
        /// Width in azimuth at −3 dB, rad.
        azimuth_beamwidth_rad: f32,
        /// Width in elevation at −3 dB, rad.
        elevation_beamwidth_rad: f32,
        /// Against world (1) or body axes (2).
        reference_system: u8,
        /// Unused.
        padding1: [u8; 3],
        /// Magnitude of the field along z.
        e_z: f32,
        /// Magnitude of the field along x.
        e_x: f32,
        /// Phase between the two, rad.
        phase_rad: f32,
        /// Unused.
        padding2: u32,
    }
}

impl Transmitter<'_> {
    /// The antenna pattern as a beam, if it is one.
    #[must_use]
    pub fn beam(&self) -> Option<BeamAntennaPattern> {
        let fits = self.antenna_pattern_type == AntennaPatternType::BEAM
            && self.antenna_pattern.len() == BeamAntennaPattern::SIZE;
        fits.then(|| BeamAntennaPattern::get(self.antenna_pattern))
    }
}

impl<'a> DecodeBody<'a> for Transmitter<'a> {
    const PDU_TYPE: PduType = PduType::TRANSMITTER;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let version = reader.version();
        let fixed: TransmitterFixed = reader.record()?;
        let modulation_parameters =
            reader.take(fixed.modulation_parameters_length.into(), "modulation_parameters")?;
        let antenna_pattern =
            reader.take(fixed.antenna_pattern_length.into(), "antenna_pattern")?;
        let (count, unused) = match version {
            ..7 => (0, fixed.number_of_records),
            _ => (fixed.number_of_records, 0),
        };
        let records = List::decode(reader, count.into(), "records")?;
        Ok(Self {
            radio_entity: fixed.radio_entity,
            radio_number: fixed.radio_number,
            radio_type: fixed.radio_type,
            transmit_state: fixed.transmit_state,
            input_source: fixed.input_source,
            antenna_location: fixed.antenna_location,
            relative_antenna_m: fixed.relative_antenna_m,
            antenna_pattern_type: fixed.antenna_pattern_type,
            frequency_hz: fixed.frequency_hz,
            bandwidth_hz: fixed.bandwidth_hz,
            power_dbm: fixed.power_dbm,
            modulation: fixed.modulation,
            crypto_system: fixed.crypto_system,
            crypto_key: fixed.crypto_key,
            padding: fixed.padding,
            modulation_parameters,
            antenna_pattern,
            records,
            unused,
        })
    }
}

impl EncodeBody for Transmitter<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::TRANSMITTER
    }
    fn body_len(&self) -> usize {
        TransmitterFixed::SIZE
            + self.modulation_parameters.len()
            + self.antenna_pattern.len()
            + self.records.octet_len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let too_many = |field, count, max| EncodeError::TooMany { field, count, max };
        let records = self.records.len();
        let number_of_records = if records == 0 {
            self.unused
        } else {
            records.try_into().map_err(|_| too_many("records", records, 65535))?
        };
        let pattern = self.antenna_pattern.len();
        let parameters = self.modulation_parameters.len();
        writer.put(&TransmitterFixed {
            radio_entity: self.radio_entity,
            radio_number: self.radio_number,
            radio_type: self.radio_type,
            transmit_state: self.transmit_state,
            input_source: self.input_source,
            number_of_records,
            antenna_location: self.antenna_location,
            relative_antenna_m: self.relative_antenna_m,
            antenna_pattern_type: self.antenna_pattern_type,
            antenna_pattern_length: pattern
                .try_into()
                .map_err(|_| too_many("antenna_pattern", pattern, 65535))?,
            frequency_hz: self.frequency_hz,
            bandwidth_hz: self.bandwidth_hz,
            power_dbm: self.power_dbm,
            modulation: self.modulation,
            crypto_system: self.crypto_system,
            crypto_key: self.crypto_key,
            modulation_parameters_length: parameters
                .try_into()
                .map_err(|_| too_many("modulation_parameters", parameters, 255))?,
            padding: self.padding,
        });
        writer.octets(self.modulation_parameters);
        writer.octets(self.antenna_pattern);
        self.records.encode(writer)
    }
}

/// The data of a signal: any number of bits, padded to 32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SignalData<'a> {
    octets: &'a [u8],
    unused_bits: u8,
    /// The padding as it came; `None` is computed.
    padding: Option<&'a [u8]>,
}

impl<'a> SignalData<'a> {
    /// Whole octets.
    #[must_use]
    pub fn new(octets: &'a [u8]) -> Self {
        Self { octets, unused_bits: 0, padding: None }
    }

    /// The octets, without padding.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// Number of bits; the low bits of the last octet may be unused.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.octets.len() * 8 - usize::from(self.unused_bits)
    }

    fn padding_len(&self) -> usize {
        self.padding.map_or(self.octets.len().next_multiple_of(4) - self.octets.len(), <[u8]>::len)
    }
}

/// Signal (type 26): what is on the air. Source: IEEE 1278.1-2012, 7.7.3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signal<'a> {
    /// The radio's entity.
    pub radio_entity: EntityId,
    /// Number of the radio at the entity.
    pub radio_number: u16,
    /// Encoding: bits 14 and 15 class (0 audio, 1 raw, 2 application, 3 data base), rest type or
    /// number of messages.
    pub encoding: u16,
    /// Tactical data link.
    pub tdl_type: TdlType,
    /// Samples per second, or bits per second.
    pub sample_rate: u32,
    /// Number of samples.
    pub samples: u16,
    /// The data.
    pub data: SignalData<'a>,
}

impl<'a> DecodeBody<'a> for Signal<'a> {
    const PDU_TYPE: PduType = PduType::SIGNAL;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let radio_entity = reader.get("radio_entity")?;
        let radio_number = reader.get("radio_number")?;
        let encoding = reader.get("encoding")?;
        let tdl_type = reader.get("tdl_type")?;
        let sample_rate = reader.get("sample_rate")?;
        let bits: u16 = reader.get("data_length")?;
        let samples = reader.get("samples")?;
        let octets = reader.take(usize::from(bits).div_ceil(8), "data")?;
        // Some senders leave out the padding; more than it needs is an error.
        let padding = reader.left().min(octets.len().next_multiple_of(4) - octets.len());
        let padding = Some(reader.take(padding, "padding")?);
        let unused_bits = (octets.len() * 8 - usize::from(bits)) as u8;
        let data = SignalData { octets, unused_bits, padding };
        Ok(Self { radio_entity, radio_number, encoding, tdl_type, sample_rate, samples, data })
    }
}

impl EncodeBody for Signal<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::SIGNAL
    }
    fn body_len(&self) -> usize {
        20 + self.data.octets.len() + self.data.padding_len()
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.radio_entity);
        writer.put(&self.radio_number);
        writer.put(&self.encoding);
        writer.put(&self.tdl_type);
        writer.put(&self.sample_rate);
        writer.count::<u16>(self.data.bits(), "data")?;
        writer.put(&self.samples);
        writer.octets(self.data.octets);
        match self.data.padding {
            Some(padding) => writer.octets(padding),
            None => writer.zeros(self.data.padding_len()),
        }
        Ok(())
    }
}

record! {
    /// Receiver (type 27): what a radio hears. Source: IEEE 1278.1-2012, 7.7.4.
    Receiver {
        /// The radio's entity.
        radio_entity: EntityId,
        /// Number of the radio at the entity.
        radio_number: u16,
        /// Off, on, receiving.
        receiver_state: ReceiverState,
        /// Unused.
        padding: u16,
        /// Received power, dBm.
        received_power_dbm: f32,
        /// The entity of the transmitter that is heard.
        transmitter_entity: EntityId,
        /// The number of its radio.
        transmitter_radio_number: u16,
    }
}
fixed_body!(Receiver = RECEIVER);
