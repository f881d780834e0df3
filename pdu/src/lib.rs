//! pdu.
