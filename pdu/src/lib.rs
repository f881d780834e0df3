//! Distributed Interactive Simulation (IEEE 1278.1), versions 5 to 7: octets to values and back.

#[macro_use]
mod wire;
mod body;
mod datagram;
mod header;
mod list;
mod reader;
mod time;
mod writer;

pub mod enumerations;
pub mod records;

pub mod dead_reckoning;
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

pub use body::{Body, EncodeBody, RawBody, TYPED};
pub use datagram::{Envelope, Filter, Frame, Frames, Pdu, Received, frames, pdus};
pub use entity_state::{EntityState, EntityStateUpdate};
pub use header::{HEADER_LEN, Header, Lvc, PduStatus, family_of};
pub use list::{Item, Iter, List};
pub use reader::{BodyError, DecodeError, Reader, Reason};
pub use time::{DisTime, NANOS_PER_HOUR};
pub use wire::{Part, Wire};
pub use writer::{EncodeError, Writer};
