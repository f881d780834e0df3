//! Entity information: where an entity is, how it moves and what it looks like.

use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{DeadReckoningAlgorithm, ForceId, PduType};
use crate::list::List;
use crate::reader::{BodyError, Reader};
use crate::records::{
    EntityId, EntityType, Location, Marking, Orientation, VariableParameter, Vector32,
};
use crate::writer::{EncodeError, Writer};

/// Declares Entity State twice from one list of fields: as the caller sees it, and as the block of
/// fixed size that is read and written at one go.
macro_rules! entity_state {
    ($($(#[$m:meta])* $field:ident: $t:ty,)* ; $($(#[$m2:meta])* $field2:ident: $t2:ty,)*) => {
        /// Entity State (type 1): an entity, complete in every PDU. Source: IEEE 1278.1-2012, 7.2.2.
        ///
        /// ```
        /// use pdu::{DisTime, EntityState, Envelope, records::*};
        /// let state = EntityState {
        ///     entity_id: EntityId::new(1, 3, 42),
        ///     entity_type: EntityType::new(1, 2, 225, 57, 1, 2, 0),
        ///     marking: Marking::new("SWR8").unwrap(),
        ///     ..EntityState::default()
        /// };
        /// let mut datagram = Vec::new();
        /// Envelope::new(1, DisTime::absolute(0)).append(&state, &mut datagram).unwrap();
        /// assert_eq!(datagram.len(), 144);
        /// ```
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct EntityState<'a> {
            $($(#[$m])* pub $field: $t,)*
            $($(#[$m2])* pub $field2: $t2,)*
            /// Articulated and attached parts and other records of 16 octets.
            pub variable_parameters: List<'a, VariableParameter>,
        }

        record! {
            /// Everything between the header and the variable parameters.
            #[expect(unreachable_pub, reason = "the macro declares public records")]
            Fixed {
                $(/// As in Entity State.
                $field: $t,)*
                /// Number of variable parameters.
                number_of_variable_parameters: u8,
                $(/// As in Entity State.
                $field2: $t2,)*
            }
        }

        impl<'a> DecodeBody<'a> for EntityState<'a> {
            const PDU_TYPE: PduType = PduType::ENTITY_STATE;
            #[inline(always)]
            fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError> {
                let fixed: Fixed = reader.record()?;
                let count = usize::from(fixed.number_of_variable_parameters);
                let variable_parameters = List::decode(reader, count, "variable_parameters")?;
                Ok(Self {
                    $($field: fixed.$field,)*
                    $($field2: fixed.$field2,)*
                    variable_parameters,
                })
            }
        }

        impl EncodeBody for EntityState<'_> {
            #[inline]
            fn pdu_type(&self) -> PduType {
                PduType::ENTITY_STATE
            }
            #[inline]
            fn body_len(&self) -> usize {
                <Fixed as crate::wire::Wire>::SIZE + self.variable_parameters.octet_len()
            }
            #[inline]
            fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
                let count = self.variable_parameters.len();
                let too_many = EncodeError::TooMany { field: "variable_parameters", count, max: 255 };
                let fixed = Fixed {
                    $($field: self.$field,)*
                    number_of_variable_parameters: count.try_into().map_err(|_| too_many)?,
                    $($field2: self.$field2,)*
                };
                writer.put(&fixed);
                self.variable_parameters.encode(writer)
            }
        }

        impl EntityState<'_> {
            /// The same without a borrow; allocates only if there are variable parameters.
            #[must_use]
            pub fn into_owned(self) -> EntityState<'static> {
                EntityState {
                    $($field: self.$field,)*
                    $($field2: self.$field2,)*
                    variable_parameters: self.variable_parameters.into_owned(),
                }
            }
        }
    };
}

entity_state! {
    /// The entity.
    entity_id: EntityId,
    /// Its force.
    force_id: ForceId,
    ;
    /// Its type.
    entity_type: EntityType,
    /// The type that the other side believes it to be.
    alternative_entity_type: EntityType,
    /// Linear velocity, m/s: in world axes, or in body axes where the dead-reckoning model is one of
    /// body axes.
    linear_velocity_mps: Vector32,
    /// Location in world coordinates.
    location: Location,
    /// Orientation of the body axes against the world axes.
    orientation: Orientation,
    /// Appearance bits; see `AirAppearance` and `LandAppearance`.
    appearance: u32,
    /// Dead-reckoning model.
    dead_reckoning_algorithm: DeadReckoningAlgorithm,
    /// Other parameters of dead reckoning, 15 octets.
    dead_reckoning_parameters: [u8; 15],
    /// Linear acceleration, m/s², in the axes of the velocity.
    linear_acceleration_mps2: Vector32,
    /// Angular velocity, rad/s, about the body axes.
    angular_velocity_rad_s: Vector32,
    /// Marking, for instance a call sign.
    marking: Marking,
    /// Capability bits.
    capabilities: u32,
}

body! {
    /// Entity State Update (type 67): only what changes often. Source: IEEE 1278.1-2012, 7.2.5.
    EntityStateUpdate = ENTITY_STATE_UPDATE {
        /// The entity.
        entity_id: EntityId;
        /// Unused.
        padding: u8;
        count number_of_variable_parameters: u8 = variable_parameters;
        /// Linear velocity, m/s, axes as in Entity State.
        linear_velocity_mps: Vector32;
        /// Location in world coordinates.
        location: Location;
        /// Orientation of the body axes against the world axes.
        orientation: Orientation;
        /// Appearance bits.
        appearance: u32;
        /// Articulated and attached parts and other records of 16 octets.
        list variable_parameters: VariableParameter, number_of_variable_parameters;
    }
}
