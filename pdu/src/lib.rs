//! Distributed Interactive Simulation (DIS, IEEE 1278.1): octets to values and back.
//!
//! Reads versions 5, 6 and 7, writes 6 and 7. No I/O, no clock, no threads; no allocation to decode or
//! to encode; no panic on any input.
//!
//! # Receiving
//!
//! A datagram may hold several PDUs. [`pdus`] walks it by each header's length and gives every sound
//! PDU, and for each damaged one an error with its index, offset, field and reason:
//!
//! ```
//! use pdu::{Body, pdus};
//!
//! fn on_datagram(datagram: &[u8]) {
//!     for received in pdus(datagram) {
//!         match received {
//!             Ok(received) => match received.body() {
//!                 Body::EntityState(state) => println!("{} {}", state.entity_id, state.marking.text()),
//!                 Body::Raw(raw) => println!("type {}: {} octets", raw.pdu_type, raw.octets.len()),
//!                 other => println!("{other:?}"),
//!             },
//!             // Entity State PDU 0 at octet 0, octet 16, field `entity_id.entity`: needs 2 octets, 1 left
//!             Err(damaged) => eprintln!("{damaged}"),
//!         }
//!     }
//! }
//! # on_datagram(&[7, 1, 1, 1, 0, 0, 0, 0, 0, 17, 0, 0, 0, 1, 0, 2, 0]);
//! ```
//!
//! Values borrow from the datagram. [`frames`] cuts without decoding, [`Filter`] decides by the first 16
//! octets, and [`Frame::decode_as`] decodes one wanted type. [`EntityState::into_owned`] keeps a state
//! beyond its datagram.
//!
//! # Sending
//!
//! A PDU struct is filled in, an [`Envelope`] says version, exercise and time; lengths, family, type,
//! counts and padding are computed, and a text or list that does not fit its field is an error:
//!
//! ```
//! use geodesy::{Attitude, Geodetic, LocalFrame};
//! use pdu::{DisTime, EntityState, Envelope};
//! use pdu::enumerations::{AirAppearance, DeadReckoningAlgorithm};
//! use pdu::records::{EntityId, EntityType, Marking, Vector32};
//!
//! let place = LocalFrame::at(Geodetic::from_degrees(47.4581, 8.5481, 432.0));
//! let attitude = Attitude { heading_rad: 2.74, ..Attitude::default() };
//! let state = EntityState {
//!     entity_id: EntityId::new(1, 1, 42),
//!     entity_type: EntityType::new(1, 2, 71, 57, 1, 0, 0),
//!     location: place.origin().into(),
//!     orientation: place.euler(attitude).into(),
//!     linear_velocity_mps: Vector32::from_f64(place.vector_to_ecef([3.0, -7.0, 0.0])),
//!     dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
//!     appearance: AirAppearance::default().with_power_plant(true).0,
//!     marking: Marking::new("SWR8")?,
//!     ..EntityState::default()
//! };
//! let mut datagram = Vec::with_capacity(1400);
//! Envelope::new(1, DisTime::absolute(12_345_000_000)).append(&state, &mut datagram)?;
//! # assert_eq!(datagram.len(), 144);
//! # Ok::<(), pdu::EncodeError>(())
//! ```
//!
//! [`publishing`] decides when a state is due again, [`dead_reckoning`] says where an entity is in
//! between, [`smoothing`] shows it without jumps. [`exercise`] puts all of it together: datagrams of
//! everybody in, entities at any time out, and own entities to PDUs. `examples/send_aircraft.rs` and
//! `examples/listen.rs` do it over UDP.
//!
//! # What is kept
//!
//! Decoding keeps the octets: unused fields, padding, unknown enumerations, NaN payloads, a family that
//! does not belong to the type. A decoded PDU encodes to exactly what came. Types without typed fields
//! here, and versions before 5 or after 7, come as [`Body::Raw`]. [`TYPED`] lists the types with fields.
//!
//! Where implementations disagree about a layout, what fits the PDU's length is taken: Action
//! Request-R of 44 and of 48 octets, environment records whose length does or does not count their
//! header, datums and signals without their last padding. Transfer Control of DIS 6 and gridded data
//! of another layout are kept raw.
//!
//! # What is checked
//!
//! A length below the header, beyond the datagram or not fitting the body is an error, never a guess.
//! Values are not judged: positions may be NaN or inside the earth; look at them before use.

#[macro_use]
mod wire;
mod body;
mod codec;
mod datagram;
mod header;
mod list;
mod reader;
mod time;
mod writer;

pub mod enumerations;
pub mod records;

pub mod dead_reckoning;
pub mod exercise;
pub mod publishing;
pub mod smoothing;

pub mod attribute;
pub mod emission;
pub mod entity_management;
mod entity_state;
pub mod environment;
pub mod gridded;
pub mod iff;
pub mod interaction;
pub mod management;
pub mod radio;
pub mod reliable;

pub use body::{Body, RawBody, TYPED};
pub use codec::{DecodeBody, EncodeBody};
pub use datagram::{Envelope, Filter, Frame, Frames, Pdu, Received, frames, pdus};
pub use entity_state::{EntityState, EntityStateUpdate};
pub use header::{HEADER_LEN, Header, Lvc, PduStatus, family_of};
pub use list::{Item, Iter, List};
pub use reader::{BodyError, DecodeError, Reader, Reason};
pub use time::{DisTime, NANOS_PER_HOUR};
pub use wire::{Part, Wire};
pub use writer::{EncodeError, Writer};
