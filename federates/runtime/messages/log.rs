//! The log of a run: what a returning member cannot make again.

use super::{Frame, FrameEnds};
use serde::{Deserialize, Serialize};

/// What the log keeps of the frames of one producer, in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LogRecord {
    /// PDUs of frames that the next [`LogRecord::Ends`] of this producer ends.
    Whole {
        /// Producer.
        name: String,
        /// (frame, octets).
        pdus: Vec<(Frame, Vec<u8>)>,
    },
    /// Frames with their notices; hashes of PDUs are left out.
    Ends {
        /// Producer.
        name: String,
        /// The frames.
        ends: FrameEnds,
    },
}

/// Asks for a page of the log of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogAsk {
    /// Federation.
    pub fed: u128,
    /// Number of the run.
    pub run: u32,
    /// Page, from 0.
    pub page: u64,
}

/// A page of the log of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogPage {
    /// Encoded [`LogRecord`]s.
    pub records: Vec<Vec<u8>>,
    /// Whether pages follow.
    pub more: bool,
    /// Why there is no such log, for a person; empty if there is.
    pub lost: String,
}
