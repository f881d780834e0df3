//! What a launcher asks of an agent, and what it is answered.

use serde::{Deserialize, Serialize};

/// An agent serves all exercises; its own links are none of them.
pub(super) const EXERCISE: u8 = 0;

/// Where an agent is asked.
pub(super) const KEY: &str = "agent/do";

/// A question of the launcher whose run is `session`. The same question twice is answered the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Ask {
    /// Drawn by the launcher at its start.
    pub(super) session: u128,
    /// Its build.
    pub(super) build: String,
    /// What it wants.
    pub(super) what: What,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum What {
    /// Start a federate: the how manieth start of that name, its name and its command line without what is this host's own.
    Start { start: u32, name: String, arguments: Vec<String> },
    /// Let it end in order, or at once.
    End { name: String, at_once: bool },
    /// How all of this session do.
    Look,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Answer {
    Done,
    Refused(String),
    Processes(Vec<Process>),
}

/// A federate of a session as it was started last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Process {
    pub(super) name: String,
    pub(super) start: u32,
    /// Exit code (negative: ended by that signal); none while it runs.
    pub(super) ended: Option<i32>,
}
