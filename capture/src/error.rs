//! What can be wrong with a file, with the place where it is wrong.

use std::io;

/// Why a file could not be opened at all.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file system refused.
    #[error("{path}: {cause}")]
    Io {
        /// The file as named by the caller.
        path: String,
        /// What the system said.
        cause: io::Error,
    },
    /// The file is compressed.
    #[error("{path}: compressed with {with}; uncompress it first")]
    Compressed {
        /// The file as named by the caller.
        path: String,
        /// Name of the compression.
        with: &'static str,
    },
    /// The first octets are of no known kind.
    #[error(
        "{path}: neither pcap nor pcapng, and no DIS header at offset 0 (found octets {start})"
    )]
    Unknown {
        /// The file as named by the caller.
        path: String,
        /// The first octets, hexadecimal.
        start: String,
    },
    /// Nothing in the file.
    #[error("{path}: the file is empty")]
    Empty {
        /// The file as named by the caller.
        path: String,
    },
}

/// Something in a file that is not as it should be. Reading goes on behind it where it can.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The file ends inside a block, as after a crash of its writer. All before it was delivered.
    #[error("offset {offset}: last block cut, {bytes} bytes")]
    Cut {
        /// Where the cut block starts.
        offset: u64,
        /// Octets of it that are there.
        bytes: u64,
    },
    /// The recording lacks the mark that its recorder writes when it closes.
    #[error(
        "offset {offset}: the recording was not closed, what arrived after the last block is missing"
    )]
    NotClosed {
        /// End of the file.
        offset: u64,
    },
    /// A block whose own lengths or kind make no sense.
    #[error("offset {offset}: damaged block: {fault}; {skipped} bytes skipped")]
    Block {
        /// Where the block starts.
        offset: u64,
        /// What does not fit.
        fault: BlockFault,
        /// Octets passed over until the next sound block or the end.
        skipped: u64,
    },
    /// A frame that cannot be taken apart down to UDP.
    #[error("frame {frame}, offset {offset}: {fault}")]
    Frame {
        /// Number of the frame, from 1, as Wireshark counts.
        frame: u64,
        /// Where the frame's octets start in the file.
        offset: u64,
        /// What does not fit.
        fault: FrameFault,
    },
    /// The system could not read on.
    #[error("offset {offset}: {cause}")]
    Io {
        /// How far reading came.
        offset: u64,
        /// What the system said.
        cause: io::Error,
    },
}

/// What is wrong with a block of a capture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlockFault {
    /// A length below the fixed part, not a multiple of four, or beyond any sane size.
    #[error("length {0} makes no sense")]
    Length(u32),
    /// The two lengths of a pcapng block differ.
    #[error("length {leading} at the start, {trailing} at the end")]
    Lengths {
        /// Length before the body.
        leading: u32,
        /// Length behind the body.
        trailing: u32,
    },
    /// A packet of an interface that was never described.
    #[error("interface {0} was not described")]
    Interface(u32),
    /// A section whose octet order mark is unknown.
    #[error("octet order mark {0:#010x} is unknown")]
    OctetOrder(u32),
    /// More octets announced inside the block than it has.
    #[error("needs {needed} bytes, has {have}")]
    Short {
        /// Octets announced.
        needed: u64,
        /// Octets there.
        have: u64,
    },
}

/// What is wrong with a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameFault {
    /// A link layer that is not read here.
    #[error("link type {0} is not supported (Ethernet, Linux cooked, raw IP and loopback are)")]
    LinkType(u16),
    /// The frame ends inside the named header.
    #[error("{layer} header needs {needed} bytes, {have} left")]
    Short {
        /// Name of the header.
        layer: &'static str,
        /// Octets needed.
        needed: usize,
        /// Octets there.
        have: usize,
    },
    /// A header field with an impossible value.
    #[error("{field} = {value} is impossible")]
    Field {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: u32,
    },
    /// A packet that came in fragments and never became whole.
    #[error("fragments of IP packet {id} never became whole: {have} bytes of it came")]
    Unfinished {
        /// Identification field of the packet.
        id: u32,
        /// Octets that came.
        have: usize,
    },
}
