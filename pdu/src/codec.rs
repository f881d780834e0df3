//! What the body of a PDU can do: be read, be written.

use crate::enumerations::PduType;
use crate::reader::{BodyError, Reader};
use crate::writer::{EncodeError, Writer};

/// A body that can be read: every PDU struct of this crate.
pub trait DecodeBody<'a>: Sized {
    /// The PDU's type.
    const PDU_TYPE: PduType;
    /// Reads the body.
    ///
    /// # Errors
    /// If the PDU ends inside it or a length contradicts its content.
    fn decode_body(reader: &mut Reader<'a>) -> Result<Self, BodyError>;
}

/// A body that can be written: every PDU struct of this crate, and [`crate::Body`] itself.
pub trait EncodeBody {
    /// The PDU's type.
    fn pdu_type(&self) -> PduType;
    /// Octets of the body, without header.
    fn body_len(&self) -> usize;
    /// Writes the body.
    ///
    /// # Errors
    /// If a list is longer than its count field can say.
    fn encode_body(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError>;
}
