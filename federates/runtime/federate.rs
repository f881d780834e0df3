//! What a federate's own logic is to the runtime: a state machine that executes frames.

use super::bus::Class;
use super::messages::{FederateStatus, FinalReport, Frame, Kind, Notice, RunConfig};
use std::sync::Arc;

/// A PDU in a frame: its octets are shared with the repair cache.
pub type Octets = Arc<[u8]>;

/// Everything that a step needs; the same for equal frames in every process layout.
#[derive(Clone, Debug, Default)]
pub struct FrameInputs {
    /// PDUs of the federation since the last step: (frame, octets), sorted by frame, then by octets.
    pub pdus: Vec<(Frame, Octets)>,
    /// PDUs of outsiders, in order of arrival, with the frame at which they arrived.
    pub outsiders: Vec<(Frame, Octets)>,
    /// Notices that take effect since the last step: (frame, notice), by frame, then by member.
    pub notices: Vec<(Frame, Notice)>,
}

/// What a step produces.
#[derive(Debug, Default)]
pub struct FrameOut {
    /// PDUs for everybody, made at the frame's time.
    pub pdus: Vec<Octets>,
    /// PDUs for those who look on, of no frame and in no digest.
    pub aside: Vec<Octets>,
    /// Notices for the federation, in effect from this frame on.
    pub notices: Vec<Notice>,
    /// Notices that take effect in a later frame: (frame, notice).
    pub later: Vec<(Frame, Notice)>,
    /// Messages for spectators and requests served from the last value: (key, class, body, retained).
    pub publish: Vec<Publication>,
}

/// A message for the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// Key.
    pub key: String,
    /// Whether it may be lost.
    pub class: Class,
    /// Octets.
    pub body: Vec<u8>,
    /// Key under which the last value is served to late joiners; none if not.
    pub retained: Option<String>,
}

/// What becomes of time, beside the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aside {
    /// It stands, and may stand for long: said at once and every few seconds.
    Stands,
    /// It goes on.
    GoesOn,
    /// The run is over.
    Over,
}

/// The logic of an essential federate. No I/O, no clock, no global random numbers.
pub trait Federate: Send {
    /// What it is.
    fn kind(&self) -> Kind;
    /// It executes frames that are multiples of this; 1 for producers.
    fn period(&self) -> Frame {
        1
    }
    /// Whether it needs the PDUs of the producers.
    fn consumes(&self) -> bool {
        false
    }
    /// Whether it takes the PDUs in; if not, of the producers only their notices.
    fn reads_pdus(&self) -> bool {
        self.consumes()
    }
    /// Frames that it may be ahead of a producer whose notices it waits for, because they take effect so much later;
    /// `None`: it reads nothing of this producer. Asked of those that need producers.
    fn ahead_of(&self, _producer: &str) -> Option<Frame> {
        Some(0)
    }
    /// Whether what a producer told is read in the log of the run where the run is made again: it is not made again here.
    fn logs(&self, _producer: &str) -> bool {
        false
    }
    /// Whether those who read its frames may be those whose frames it waits for: it keeps nobody waiting for a report.
    fn in_loop(&self) -> bool {
        false
    }
    /// Whether nobody can make its frames again: what outsiders do. The log of the run keeps its PDUs.
    fn live(&self) -> bool {
        false
    }
    /// Back to frame 0 of a run. What it makes at frame 0 goes out with frame 1's predecessor, frame 0.
    ///
    /// # Errors
    /// One sentence if the run cannot be done.
    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String>;
    /// Executes frame `k`.
    fn step(&mut self, k: Frame, inputs: &FrameInputs, out: &mut FrameOut);
    /// Digest of the state after the last step, as far as it is not told by what was made: the same in every
    /// process that executed the same frames.
    fn state(&self) -> u64 {
        0
    }
    /// Fills digests and counters at the end of a run.
    fn finish(&mut self, report: &mut FinalReport);
    /// PDUs for those who look on, of no frame and in no digest: what they see would move on while time stands.
    fn aside(&mut self, _what: Aside) -> Vec<Octets> {
        Vec::new()
    }
    /// Adds what it knows itself to its status (drops by reason).
    fn status(&self, _status: &mut FederateStatus) {}
}
