//! Gridded data: fields of the environment on a grid.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{ConstantGrid, GridCoordinateSystem, GridDataRepresentation, PduType};
use crate::list::{Item, List};
use crate::reader::{BodyError, Reader};
use crate::records::{ClockTime, EntityId, EntityType, Orientation};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

record! {
    /// What comes before the axes.
    GriddedFixed {
        /// The process.
        process_id: EntityId,
        /// Number of the field.
        field_number: u16,
        /// Number of this PDU of the field.
        pdu_number: u16,
        /// PDUs of the field.
        pdu_total: u16,
        /// Coordinate system.
        coordinate_system: GridCoordinateSystem,
        /// Number of axes.
        number_of_axes: u8,
        /// Whether the grid changes.
        constant_grid: ConstantGrid,
        /// Type of the environment.
        environment_type: EntityType,
        /// Orientation of the grid.
        orientation: Orientation,
        /// When the data were valid.
        sample_time: ClockTime,
        /// Values in all PDUs of the field.
        total_values: u32,
        /// Components of the data vector.
        vector_dimension: u8,
        /// Unused.
        padding: [u8; 3],
    }
}

/// Gridded Data (type 42). Source: IEEE 1278.1-2012, 7.10.3.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GriddedData<'a> {
    /// The process.
    pub process_id: EntityId,
    /// Number of the field.
    pub field_number: u16,
    /// Number of this PDU of the field.
    pub pdu_number: u16,
    /// PDUs of the field.
    pub pdu_total: u16,
    /// Coordinate system.
    pub coordinate_system: GridCoordinateSystem,
    /// Whether the grid changes.
    pub constant_grid: ConstantGrid,
    /// Type of the environment.
    pub environment_type: EntityType,
    /// Orientation of the grid.
    pub orientation: Orientation,
    /// When the data were valid.
    pub sample_time: ClockTime,
    /// Values in all PDUs of the field.
    pub total_values: u32,
    /// Unused.
    pub padding: [u8; 3],
    /// The axes of the grid.
    pub axes: List<'a, GridAxis<'a>>,
    /// The data, one element for each component.
    pub data: GridValues<'a>,
}

record! {
    /// What regular and irregular axes share. Source: IEEE 1278.1-2012, 6.2.41.
    GridAxisStart {
        /// Coordinate of the first point of the domain.
        initial: f64,
        /// Coordinate of the last point of the domain.
        last: f64,
        /// Points of the domain.
        points: u16,
        /// Interleaf factor.
        interleaf: u8,
        /// 0 regular, 1 irregular.
        axis_type: u8,
        /// Points in this PDU.
        points_here: u16,
        /// Index of the first of these.
        initial_index: u16,
    }
}

/// An axis of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridAxis<'a> {
    /// Domain and number of points.
    pub start: GridAxisStart,
    /// Coordinates, of an irregular axis (type 1).
    pub irregular: Option<IrregularAxis<'a>>,
}

/// Coordinates of an irregular axis: `scale · value + offset`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IrregularAxis<'a> {
    /// Scale.
    pub scale: f64,
    /// Offset.
    pub offset: f64,
    /// Coded coordinates; as many as the axis has points in this PDU.
    pub values: List<'a, u16>,
}

impl<'a> Item<'a> for GridAxis<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let start: GridAxisStart = reader.get(field)?;
        if start.axis_type != 1 {
            return Ok(Self { start, irregular: None });
        }
        let scale = reader.get(field)?;
        let offset = reader.get(field)?;
        let values: List<'a, u16> = List::decode(reader, start.points_here.into(), "axis_values")?;
        let used = values.octet_len();
        reader.take(used.next_multiple_of(8) - used, "axis_padding")?;
        Ok(Self { start, irregular: Some(IrregularAxis { scale, offset, values }) })
    }
    fn item_len(&self) -> usize {
        let irregular = self.irregular.as_ref();
        GridAxisStart::SIZE + irregular.map_or(0, |i| 16 + i.values.octet_len().next_multiple_of(8))
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let Some(irregular) = &self.irregular else {
            let axis_type = if self.start.axis_type == 1 { 0 } else { self.start.axis_type };
            writer.put(&GridAxisStart { axis_type, ..self.start });
            return Ok(());
        };
        let count = irregular.values.len();
        let too_many = EncodeError::TooMany { field: "axis_values", count, max: 65535 };
        let points_here = count.try_into().map_err(|_| too_many)?;
        writer.put(&GridAxisStart { axis_type: 1, points_here, ..self.start });
        writer.put(&irregular.scale);
        writer.put(&irregular.offset);
        irregular.values.encode(writer)?;
        let used = irregular.values.octet_len();
        writer.zeros(used.next_multiple_of(8) - used);
        Ok(())
    }
}

/// The data of the grid. Where they do not fit the layout below (its padding is in dispute between
/// implementations), they are kept as octets.
#[derive(Clone, Debug, PartialEq)]
pub enum GridValues<'a> {
    /// One element for each component of the data vector.
    Components(List<'a, GridComponent<'a>>),
    /// Octets of another layout.
    Raw {
        /// Components of the data vector, as the PDU says.
        vector_dimension: u8,
        /// Everything after the axes.
        octets: &'a [u8],
    },
}

impl Default for GridValues<'_> {
    fn default() -> Self {
        Self::Components(List::default())
    }
}

/// One component of the data vector at all points. Source: IEEE 1278.1-2012, 6.2.42.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridComponent<'a> {
    /// What is sampled: SISO-REF-010, UID 246.
    pub sample_type: u16,
    /// The values.
    pub samples: GridSamples<'a>,
}

/// Values of a component.
#[derive(Clone, Debug, PartialEq)]
pub enum GridSamples<'a> {
    /// Representation 0: octets.
    Octets(&'a [u8]),
    /// Representation 1: `scale · value + offset`.
    Scaled {
        /// Scale.
        scale: f32,
        /// Offset.
        offset: f32,
        /// Coded values.
        values: List<'a, u16>,
    },
    /// Representation 2: 32-bit floats.
    Floats(List<'a, f32>),
}

impl Default for GridSamples<'_> {
    fn default() -> Self {
        Self::Octets(&[])
    }
}

impl<'a> GridComponent<'a> {
    /// Octets before padding to 32 bits.
    fn unpadded(&self) -> usize {
        match &self.samples {
            GridSamples::Octets(octets) => 6 + octets.len(),
            GridSamples::Scaled { values, .. } => 14 + values.octet_len(),
            GridSamples::Floats(values) => 8 + values.octet_len(),
        }
    }
}

impl<'a> Item<'a> for GridComponent<'a> {
    const FIXED: Option<usize> = None;
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        let sample_type = reader.get(field)?;
        let representation: GridDataRepresentation = reader.get(field)?;
        let samples = match representation.0 {
            0 => {
                let count: u16 = reader.get(field)?;
                GridSamples::Octets(reader.take(count.into(), field)?)
            }
            1 => {
                let scale = reader.get(field)?;
                let offset = reader.get(field)?;
                let count: u16 = reader.get(field)?;
                let values = List::decode(reader, count.into(), field)?;
                GridSamples::Scaled { scale, offset, values }
            }
            2 => {
                let count: u16 = reader.get(field)?;
                let _padding: u16 = reader.get(field)?;
                GridSamples::Floats(List::decode(reader, count.into(), field)?)
            }
            other => return Err(reader.bad_length(field, other.into())),
        };
        let component = Self { sample_type, samples };
        reader.take(component.item_len() - component.unpadded(), field)?;
        Ok(component)
    }
    fn item_len(&self) -> usize {
        self.unpadded().next_multiple_of(4)
    }
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(&self.sample_type);
        match &self.samples {
            GridSamples::Octets(octets) => {
                writer.put(&0_u16);
                writer.count::<u16>(octets.len(), "samples")?;
                writer.octets(octets);
            }
            GridSamples::Scaled { scale, offset, values } => {
                writer.put(&1_u16);
                writer.put(scale);
                writer.put(offset);
                writer.count::<u16>(values.len(), "samples")?;
                values.encode(writer)?;
            }
            GridSamples::Floats(values) => {
                writer.put(&2_u16);
                writer.count::<u16>(values.len(), "samples")?;
                writer.zeros(2);
                values.encode(writer)?;
            }
        }
        writer.zeros(self.item_len() - self.unpadded());
        Ok(())
    }
}

impl<'a> DecodeBody<'a> for GriddedData<'a> {
    const PDU_TYPE: PduType = PduType::GRIDDED_DATA;
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
        let fixed: GriddedFixed = reader.record()?;
        let axes = List::decode(reader, fixed.number_of_axes.into(), "axes")?;
        let mut probe = reader.clone();
        let components = List::decode(&mut probe, fixed.vector_dimension.into(), "data");
        let octets = reader.take(reader.left(), "data")?;
        let data = match components {
            Ok(list) if probe.left() == 0 => GridValues::Components(list),
            _ => GridValues::Raw { vector_dimension: fixed.vector_dimension, octets },
        };
        Ok(Self {
            process_id: fixed.process_id,
            field_number: fixed.field_number,
            pdu_number: fixed.pdu_number,
            pdu_total: fixed.pdu_total,
            coordinate_system: fixed.coordinate_system,
            constant_grid: fixed.constant_grid,
            environment_type: fixed.environment_type,
            orientation: fixed.orientation,
            sample_time: fixed.sample_time,
            total_values: fixed.total_values,
            padding: fixed.padding,
            axes,
            data,
        })
    }
}

impl EncodeBody for GriddedData<'_> {
    fn pdu_type(&self) -> PduType {
        PduType::GRIDDED_DATA
    }
    fn body_len(&self) -> usize {
        let data = match &self.data {
            GridValues::Components(list) => list.octet_len(),
            GridValues::Raw { octets, .. } => octets.len(),
        };
        GriddedFixed::SIZE + self.axes.octet_len() + data
    }
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        let count = |field, count: usize| {
            u8::try_from(count).map_err(|_| EncodeError::TooMany { field, count, max: 255 })
        };
        let vector_dimension = match &self.data {
            GridValues::Components(list) => count("data", list.len())?,
            GridValues::Raw { vector_dimension, .. } => *vector_dimension,
        };
        writer.put(&GriddedFixed {
            process_id: self.process_id,
            field_number: self.field_number,
            pdu_number: self.pdu_number,
            pdu_total: self.pdu_total,
            coordinate_system: self.coordinate_system,
            number_of_axes: count("axes", self.axes.len())?,
            constant_grid: self.constant_grid,
            environment_type: self.environment_type,
            orientation: self.orientation,
            sample_time: self.sample_time,
            total_values: self.total_values,
            vector_dimension,
            padding: self.padding,
        });
        self.axes.encode(writer)?;
        match &self.data {
            GridValues::Components(list) => list.encode(writer),
            GridValues::Raw { octets, .. } => {
                writer.octets(octets);
                Ok(())
            }
        }
    }
}
