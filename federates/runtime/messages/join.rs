//! Who joins, as whom, and what it is told.

use super::{Frame, Kind, RunConfig};
use serde::{Deserialize, Serialize};

/// A federate asks to join.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Name within the federation ("traffic-generator-2").
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Process, for messages to people.
    pub pid: u32,
    /// Host name, for messages to people.
    pub host: String,
    /// Version of the build.
    pub version: String,
    /// Hash of the scene and its data.
    pub scene_hash: u64,
    /// Drawn when the process starts: a question that is asked again gets the same answer.
    pub instance: u128,
    /// What this process was before the federation went on without it.
    pub was: Option<Was>,
}

/// A lost incarnation whose process is still there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Was {
    /// Federation.
    pub fed: u128,
    /// Incarnation.
    pub inc: u64,
    /// Run.
    pub run: u32,
}

/// The conductor's answer to [`Hello`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Welcome {
    /// Joined.
    Accepted(Box<Accepted>),
    /// Not yet: ask again.
    Later(String),
    /// Not joined; the reason says what to do.
    Refused(String),
    /// Another spectator has this name: ask again with another one.
    NameTaken,
}

/// What a member begins with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// The federation, drawn by the conductor at its start; messages of another have no effect.
    pub fed: u128,
    /// Incarnation; every message of the member carries it.
    pub inc: u64,
    /// Number of the last order so far.
    pub orders: u64,
    /// A run that is under way, which the member is to reach by itself.
    pub enter: Option<Return>,
    /// Epoch of the station that says so: how often the lead has changed.
    pub epoch: u32,
}

/// Where a run stands that a lost member returns to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Return {
    /// The run.
    pub config: RunConfig,
    /// The frame to reach; none: not even frame 0 was made. The next one is the first that is awaited.
    pub upto: Option<Frame>,
    /// The process may keep its state and go back to that frame; otherwise it begins again at frame 0.
    pub keep: bool,
    /// The producers, for a consumer.
    pub producers: Vec<ProducerAt>,
}

/// Where a producer's frames come from for a consumer that returns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProducerAt {
    /// Name.
    pub name: String,
    /// Frames up to here the consumer makes itself.
    pub made: Option<Frame>,
    /// Incarnation whose reports hold the next frames, and the number of the first such report; none while it is lost.
    pub stream: Option<(u64, u64)>,
    /// Frames after `made` count as absent.
    pub absent: bool,
    /// It has made nothing so far: no PDU, no notice.
    pub empty: bool,
    /// Up to which frame the log of the run has it.
    pub logged: Option<Frame>,
}
