//! Who leads a run that has a second station: a standby that holds the journal of the first.
//!
//! The station says nothing that its standby does not hold, so whoever leads next knows every word that anybody acts on. Two things are
//! left to agree on: that the standby leads, or that the station goes on without it. Each is the begin of an epoch, and takes the promises
//! of more than half of the voters: the essential members, the station and the standby. A voter promises an epoch to one of them only, so
//! never both (protocol-2.md 10). No order needs an epoch: the one who lost cannot say anything new.
//!
//! Pure: names, times and messages in, questions out.

mod commit;
mod contest;
mod standby;
mod voter;

use super::clock::WallNs;
use serde::{Deserialize, Serialize};

pub use commit::Commit;
pub use contest::{Candidate, Question};
pub use standby::Standby;
pub use voter::Voter;

/// The name of an administration station, and that of the standby of one.
pub const STATIONS: [&str; 2] = ["admin-station", "admin-station-standby"];

/// A station, or a standby, of which nothing was heard for so long is asked about, ns.
pub const SILENT_NS: WallNs = 1_500_000_000;

/// One whose connection stands may be silent for so long, ns.
pub const PAUSED_NS: WallNs = 3_000_000_000;

/// Octets by which two journals are compared.
pub const TAIL: u64 = 4096;

/// What a station asks a voter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Candidacy {
    /// The federation.
    pub fed: u128,
    /// Who asks, whichever process of it.
    pub who: u64,
    /// Its process.
    pub by: u128,
    /// The epoch of which it is; it asks for the next one.
    pub since: u32,
    /// Which time it asks for that.
    pub attempt: u32,
    /// What it wants.
    pub wants: Wants,
}

/// What a promise is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wants {
    /// To lead, which nobody allows who hears the station.
    Lead,
    /// To go on without the standby.
    GoOn,
    /// Nothing any more: the promise is given back.
    Nothing,
}

/// What a voter answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Voted {
    /// Who asked.
    pub by: u128,
    /// Which time.
    pub attempt: u32,
    /// The incarnation of the voter: that of a process that was replaced does not count.
    pub inc: u64,
    /// Its voice.
    pub voice: Voice,
}

/// The voice of a voter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Voice {
    /// This epoch is the asker's.
    Promised,
    /// A station is heard here.
    Beating,
    /// Another has the promise for this epoch.
    Another(u32),
    /// The promise is given back.
    Free,
}

/// Who may lead after a journal was written so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Led {
    /// The epoch.
    pub epoch: u32,
    /// Whether a standby is in, without whose word the station says nothing.
    pub standby: bool,
}

/// A station that leads, said with its beats from the second epoch on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leads {
    /// The federation.
    pub fed: u128,
    /// The epoch.
    pub epoch: u32,
}

/// A standby asks for the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepsAsk {
    /// Of which run: everything a conductor is begun with.
    pub run: String,
    /// Who asks, whichever process of it.
    pub who: u64,
    /// It holds all octets of the journal before this one.
    pub from: u64,
    /// The hash of the last of them, at most [`TAIL`].
    pub sum: u64,
}

/// What the station answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Steps {
    /// The next octets of the journal, perhaps none yet.
    Octets(Vec<u8>),
    /// What the standby holds is of another journal: begin anew.
    Anew,
    /// The run is over.
    Over,
    /// Not now, and why.
    Later(String),
    /// This standby is not wanted, and why.
    Refused(String),
}

#[cfg(test)]
mod tests;
