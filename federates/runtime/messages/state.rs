//! How a run stands, and what an operator asks of it.

use super::Frame;
use crate::runtime::life_cycle::Phase;
use serde::{Deserialize, Serialize};

/// What an operator may ask of the conductor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Command {
    /// Start, or resume after a freeze.
    Start,
    /// Stop granting time; all federates stop at one frame.
    Freeze,
    /// Execute `n` frames, then freeze again.
    Step {
        /// Frames.
        n: u64,
    },
    /// Close the run.
    Stop,
    /// Back to frame 0 with a new run number.
    Restart,
    /// Simulated seconds per wall second; infinite = as fast as possible.
    Rate {
        /// Factor.
        rate: f64,
    },
    /// Only ask how the run stands.
    Status,
    /// Let the place of a generator or of the external world be taken by another one's process, at a frame boundary.
    Move {
        /// Whose place.
        name: String,
        /// Whose process.
        to: String,
    },
    /// Go on without a federate that is lost and that time stands for.
    Without {
        /// Its name.
        name: String,
    },
}

/// A [`Command`] and where it came from, for the log of operations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatorCommand {
    /// `terminal`, `page`, …
    pub source: String,
    /// What is asked.
    pub command: Command,
}

/// The conductor's answer to a [`Command`], sent when the state is reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Whether the command was carried out.
    pub ok: bool,
    /// One sentence: the state reached, or why not and what is possible.
    pub text: String,
    /// How the run stands.
    pub state: RunState,
}

/// How the run stands, for spectators and operators.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunState {
    /// Title of the scene.
    pub scene: String,
    /// Number of the run.
    pub run: u32,
    /// Phase.
    pub phase: Phase,
    /// Lowest frame that every essential member has executed.
    pub frame: Frame,
    /// Last frame of the run.
    pub last_frame: Frame,
    /// Length of a frame, ns.
    pub step_ns: i64,
    /// UTC of frame 0, ns since 1970.
    pub start_utc_ns: i64,
    /// Seed.
    pub seed: u64,
    /// Rate asked for; infinite = as fast as possible.
    pub rate: f64,
    /// Rate achieved over the last seconds.
    pub achieved_rate: f64,
    /// Reasons for being degraded or frozen by a fault; empty when all is well.
    pub reasons: Vec<String>,
    /// Members and spectators that joined.
    pub members: Vec<MemberState>,
}

/// An operator's command and what became of it; for the log and the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Operation {
    /// Frame at which the run stood.
    pub frame: Frame,
    /// Simulated time of that frame, ns.
    pub time_ns: i64,
    /// Where it came from ("page", "admin-station", "DIS 1.2.3").
    pub source: String,
    /// What was asked ("freeze", "rate 2").
    pub command: String,
    /// Whether it was carried out.
    pub ok: bool,
    /// State reached, or the reason why not.
    pub text: String,
}

/// One member as the conductor sees it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MemberState {
    /// Name.
    pub name: String,
    /// Host.
    pub host: String,
    /// Process.
    pub pid: u32,
    /// Whether the run waits for it.
    pub essential: bool,
    /// Joined and alive.
    pub alive: bool,
    /// Last frame executed (essential members).
    pub frame: Frame,
    /// From a grant to the frame ends that answer it, smoothed over about a second, µs.
    pub latency_us: f64,
    /// How it does.
    pub health: Health,
    /// Wall time since it was last heard of, ms; none of spectators, which do not beat.
    pub heard_ms: Option<u64>,
    /// Frames that it may execute and has not.
    pub behind: Frame,
    /// Whether its place can be given to the process of another one of which this holds, by [`Command::Move`].
    pub movable: bool,
}

/// How a member does, as the conductor hears it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Health {
    /// Heard of, and going on.
    #[default]
    Alive,
    /// Heard of, and at one frame for more than two seconds that it could have finished.
    Late,
    /// Three beats are missing; it is not given up yet.
    Silent,
    /// Given up, or gone.
    Lost,
    /// A new process of it makes the run again.
    Returning,
}

impl Health {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Alive, Self::Late, Self::Silent, Self::Lost, Self::Returning];

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::Late => "late",
            Self::Silent => "silent",
            Self::Lost => "lost",
            Self::Returning => "returning",
        }
    }
}

/// Statistics of one federate, about once a second of wall time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FederateStatus {
    /// Name.
    pub name: String,
    /// Process.
    pub pid: u32,
    /// Host.
    pub host: String,
    /// Frame executed (or seen, for spectators).
    pub frame: Frame,
    /// Processor seconds used since the start.
    pub cpu_s: f64,
    /// Share of one core over the last interval, %.
    pub cpu_pct: f64,
    /// Resident memory, bytes.
    pub rss_bytes: u64,
    /// Share of all processors of its host over the last interval, by whoever uses them, %.
    pub host_busy_pct: f64,
    /// Processors of its host; 0 where it did not measure.
    pub host_cores: u32,
    /// PDUs received since the start.
    pub pdus_in: u64,
    /// PDUs sent since the start.
    pub pdus_out: u64,
    /// PDUs that did not arrive by themselves.
    pub lost: u64,
    /// PDUs fetched again from their producer.
    pub repaired: u64,
    /// Datagrams or PDUs dropped as unsound: (reason, count).
    pub dropped: Vec<(String, u64)>,
    /// Mean time to execute a frame (or a scan), µs.
    pub exec_us: f64,
    /// Longest time to execute one, µs.
    pub exec_max_us: f64,
    /// What a person should look after, in sentences; empty when all is well.
    pub alarms: Vec<String>,
    /// What the log keeps of it as facts of the run: (name, value).
    pub facts: Vec<(String, String)>,
}

/// What a run came to, once it is closed: facts that its logs keep in their table `run`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Number of the run.
    pub run: u32,
    /// (name, value): `digest`, `track_digest`, `foreign` where something came from outside.
    pub facts: Vec<(String, String)>,
}
