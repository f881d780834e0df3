//! What travels on the synchronisation plane. Encoded by [`super::codec`], never by hand.
//!
//! Keys are `seeds/{exercise}/…`:
//!
//! | key | class | body |
//! |---|---|---|
//! | `ctl/join` | request | [`Hello`] → [`Welcome`] |
//! | `ctl/order` | must arrive | [`Numbered`] [`Order`], conductor to members |
//! | `ctl/beat`, `beat/{name}` | may be lost | [`Beat`], ten times a second |
//! | `log/conductor`, `log/{name}` | request | [`Fetch`] → [`Fetched`]: messages that were lost |
//! | `log/run` | request | [`LogAsk`] → [`LogPage`]: what the run cannot be made again without |
//! | `ctl/steps` | request, of a standby | [`StepsAsk`](super::succession::StepsAsk) → [`Steps`](super::succession::Steps): the journal of the station |
//! | `candidate/{name}` | request, of a station or standby | [`Candidacy`](super::succession::Candidacy) → [`Voted`](super::succession::Voted) |
//! | `ctl/lead` | may be lost, repeated | [`Leads`](super::succession::Leads), from the second epoch on |
//! | `ctl/command` | request | [`Command`] → [`Answer`], operator to conductor |
//! | `fed/{name}` | must arrive | [`Numbered`] [`Report`], member to conductor and consumers |
//! | `frames/{name}` | request | [`Repair`] → [`Repaired`], by the producer and by every consumer |
//! | `frames/conductor` | request | [`RepairOf`] → [`Repaired`], passed on to the producer by the conductor |
//! | `alive/{name}/{inc}` | liveliness | a hint only |
//! | `obs/state` | may be lost, last value served | [`RunState`] |
//! | `obs/fed/{name}` | may be lost | [`FederateStatus`] |
//! | `obs/operation` | may be lost | [`Operation`], conductor: every command with its answer |
//! | `obs/outcome` | must arrive | [`Outcome`], conductor: digests of a run that is closed |
//! | `obs/foreign` | may be lost | [`ForeignReport`]s: tracks of somebody else's tracker |
//! | `obs/weather`, `obs/flights` | may be lost, last value served | [`WeatherNotice`], [`FlightNotice`]s |
//! | `obs/traffic` | may be lost, last value served | JSON: what flights that behave are about |
//! | `obs/measures` | may be lost | JSON: measures of these flights so far by name and unit, every ten scans |
//! | `obs/driven` | may be lost, last value served | JSON: what people drive, ten times a second |
//! | `obs/inputs` | may be lost, repeated | [`SeatMessage`]s, what people who drive did in the last ten seconds, numbered |
//! | `tracks/1/scan` | may be lost | [`ScanReport`] |
//! | `control/1/alerts` | may be lost, repeated | [`AlertMessage`]s, what changed in the last two minutes, numbered |
//! | `control/1/seats` | may be lost, repeated | [`SeatMessage`]s, what controllers on tracks did in the last two minutes, numbered |
//! | `control/1/lights` | may be lost, last value served | JSON: stop bars, when one changed |
//! | `control/1/positions` | may be lost, last value served | JSON: seats, who waits, radio, answers, when one changed |
//! | `visitors/1/handover` | request | the same at the seat "handover": aircraft given and let go |
//! | `seat/{name}/say` | request | [`SeatOrder`] → [`SeatAnswer`], a person at a seat to the member `visitors` |
//! | `tracks/1/list` | request (`getTracksList`) | empty → [`ScanReport`] |

mod frame_ends;
mod join;
mod log;
mod notices;
mod scan;
mod seat;
mod state;
pub(crate) mod words;

use serde::{Deserialize, Serialize};

use frame_ends::REPORT_OCTETS;
pub use frame_ends::{FrameEnds, Joined, Used};
pub use join::{Accepted, Hello, ProducerAt, Return, Was, Welcome};
pub use log::{LogAsk, LogPage, LogRecord};
pub use notices::{
    AdviceNotice, AlertMessage, CausedPlot, ClearanceNotice, FlightNotice, GivenNotice, Notice,
    PlotsNotice, SeatEvent, SeatMessage, StandNotice, TrackNotice, WantNotice, WeatherNotice,
};
pub use scan::{ForeignReport, LagMessage, PlotMessage, ScanReport, TrackMessage, TruthMessage};
pub use seat::{HANDOVER_SEAT, SeatAction, SeatAnswer, SeatInput, SeatOrder, SeatWords, seat_key};
pub use state::{
    Answer, Command, FederateStatus, Health, MemberState, Operation, OperatorCommand, Outcome,
    RunState,
};

/// Number of a frame; frame 0 is the initial state, frame k ends at k · step.
pub type Frame = u64;

/// Members by name, each with its last frame that counts or is held; none if not even frame 0.
pub type Cuts = Vec<(String, Option<Frame>)>;

/// What kind of federate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Ground truth; several may share the traffic.
    TrafficGenerator,
    /// Weather and flight data.
    ExternalWorld,
    /// Sensors and data fusion.
    Smdfm,
    /// What outsiders send, let in by one member; the run goes on without it.
    Visitors,
    /// Page and log; a spectator.
    ViewerLogger,
    /// The conductor's own process.
    AdminStation,
    /// What others read in their own formats; a spectator.
    Gateway,
    /// The A-SMGCS functions on tracks; a member where the scene has them.
    Control,
}

impl Kind {
    /// The name of its executable.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TrafficGenerator => "traffic-generator",
            Self::ExternalWorld => "external-world",
            Self::Smdfm => "smdfm",
            Self::Visitors => "visitors",
            Self::ViewerLogger => "viewer-logger",
            Self::AdminStation => "admin-station",
            Self::Gateway => "gateway",
            Self::Control => "control",
        }
    }
    /// Whether it says ten times a second that it lives: members do, spectators do not.
    #[must_use]
    pub fn beats(self) -> bool {
        self.essential() || self == Self::Visitors
    }
    /// Whether it sends PDUs, and probes of the data plane; of the others only notices are read.
    #[must_use]
    pub fn sends_pdus(self) -> bool {
        matches!(self, Self::TrafficGenerator | Self::ExternalWorld | Self::Visitors)
    }
    /// Whether its process can take the place of a lost generator or of the external world.
    #[must_use]
    pub fn hosts(self) -> bool {
        matches!(self, Self::TrafficGenerator | Self::ExternalWorld)
    }
    /// Whether the run waits for it.
    #[must_use]
    pub fn essential(self) -> bool {
        matches!(self, Self::TrafficGenerator | Self::ExternalWorld | Self::Smdfm | Self::Control)
    }
}

/// A message of a stream: numbers count up by one, so a receiver knows what it lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbered<T> {
    /// Federation.
    pub fed: u128,
    /// Incarnation of the sender; 0 for the conductor.
    pub inc: u64,
    /// Number, from 1 for each incarnation; 0 outside the stream, for what is repeated anyway.
    pub seq: u64,
    /// The message.
    pub body: T,
}

/// Says that its sender lives, what it last said, and what it has heard.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beat {
    /// Federation.
    pub fed: u128,
    /// Number of the run.
    pub run: u32,
    /// Incarnation; 0 for the conductor.
    pub inc: u64,
    /// Number of the last message of its stream.
    pub last_seq: u64,
    /// Frame executed (conductor: granted).
    pub executed: Frame,
    /// The frame that is being executed, and for how long, ms.
    pub working: Option<(Frame, u64)>,
    /// Of each stream that it reads: sender, incarnation, and the number up to which it has all.
    pub seen: Vec<(String, u64, u64)>,
    /// UTC of the sender's host when it was sent, ns; 0: not told.
    pub utc_ns: i64,
}

/// Ask for messages of a stream that did not arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fetch {
    /// Federation.
    pub fed: u128,
    /// Incarnation of the sender.
    pub inc: u64,
    /// First number wanted.
    pub from: u64,
    /// Last number wanted.
    pub to: u64,
}

/// A question for messages of `of`, whoever is asked.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FetchOf {
    /// Sender of the stream; the conductor is `conductor`.
    pub of: String,
    /// What is wanted.
    pub fetch: Fetch,
}

/// The messages asked for, as far as they are remembered and fit one answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fetched<T> {
    /// Sender of the stream.
    pub of: String,
    /// Messages, ascending.
    pub items: Vec<Numbered<T>>,
    /// What came before this number is forgotten.
    pub gone_before: u64,
}

/// What the conductor tells all members, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Order {
    /// Who is there? Members answer with [`Report::Present`]; repeated until all hear each other.
    Muster,
    /// Reset to frame 0 of this run and report ready.
    Configure(RunConfig),
    /// Frames up to `upto` may be executed.
    Grant {
        /// Number of the run.
        run: u32,
        /// Last frame that may be executed.
        upto: Frame,
    },
    /// Accept nothing more of these incarnations; answer with [`Report::Sealed`].
    Seal {
        /// Number of the run.
        run: u32,
        /// Number of the view that is being settled.
        view: u32,
        /// The lost members and their incarnations.
        lost: Vec<(String, u64)>,
    },
    /// Fetch what is lacking up to these frames of the lost members; answer with [`Report::Held`].
    Cut {
        /// Number of the run.
        run: u32,
        /// Number of the view.
        view: u32,
        /// Last frame of each that counts; none if not even frame 0 does. Nobody acts on it before the view.
        cuts: Cuts,
    },
    /// All survivors hold every frame up to the cuts: from now on they count.
    View {
        /// Number of the run.
        run: u32,
        /// Number of the view.
        view: u32,
        /// Last frame of each lost member that counts.
        cuts: Cuts,
        /// Those whose frames after the cut count as absent. Those of the others are awaited.
        absent: Vec<String>,
    },
    /// A lost member is back: its frames from this one on are those of the new incarnation.
    Admit {
        /// Number of the run.
        run: u32,
        /// The member.
        name: String,
        /// Its new incarnation.
        inc: u64,
        /// The first frame that it makes.
        from: Frame,
    },
    /// The process of a member is to make a lost one again: it joins in that one's place.
    Host {
        /// Number of the run.
        run: u32,
        /// Who is lost.
        name: String,
        /// Whose process.
        by: String,
    },
    /// This incarnation cannot be a member: its process ends.
    Dismiss {
        /// The member.
        name: String,
        /// Its incarnation.
        inc: u64,
        /// Why, for a person.
        reason: String,
    },
    /// The place of this incarnation goes to another process: it leaves, and its process ends when it has no other member.
    Yield {
        /// The member.
        name: String,
        /// Its incarnation.
        inc: u64,
        /// Whose process takes its place.
        to: String,
    },
    /// The run is closed at this frame; answer with [`Report::Final`].
    Finish {
        /// Number of the run.
        run: u32,
        /// Last frame.
        frame: Frame,
    },
    /// Leave and end the process with this code.
    Exit {
        /// Exit code.
        code: u8,
    },
    /// Time stands until more frames are granted.
    Stand {
        /// Number of the run.
        run: u32,
    },
    /// The frames of a producer that nobody can make again are in the log up to this one: now they may be used.
    Logged {
        /// Number of the run.
        run: u32,
        /// The producer.
        name: String,
        /// Its last frame that is logged.
        upto: Frame,
    },
}

/// What all federates of a run agree on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunConfig {
    /// Number of the run, from 1; a restart counts it up.
    pub run: u32,
    /// Seed.
    pub seed: u64,
    /// Members that make PDUs, sorted by name.
    pub producers: Vec<String>,
    /// Those of them whose frames nobody can make again, sorted by name.
    pub live: Vec<String>,
    /// Members that read them, sorted by name.
    pub consumers: Vec<String>,
    /// Incarnation of each member.
    pub incs: Vec<(String, u64)>,
    /// Number of traffic generators.
    pub generators: u32,
    /// Last frame of the run.
    pub last_frame: Frame,
}

/// What a member tells the conductor and its consumers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// Answer to [`Order::Muster`].
    Present {
        /// Members whose answers the sender has heard itself, sorted; only consumers listen.
        hears: Vec<String>,
        /// Whether the sender needs to hear all producers.
        consumes: bool,
    },
    /// Configured for this run, or back in it.
    Ready {
        /// Number of the run.
        run: u32,
        /// Of a member that returns: how it stands at the frame that it was told to reach.
        at: Option<Standing>,
    },
    /// Frames executed.
    Ends(FrameEnds),
    /// Answer to [`Order::Seal`].
    Sealed {
        /// Number of the run.
        run: u32,
        /// Number of the view.
        view: u32,
        /// Of each lost member that this one consumes: the highest frame up to which all is complete here
        /// and granted; none if not even frame 0 is.
        holds: Cuts,
    },
    /// Answer to [`Order::Cut`], once every frame up to the cuts is complete here.
    Held {
        /// Number of the run.
        run: u32,
        /// Number of the view.
        view: u32,
    },
    /// Counters and digests at the end of the run.
    Final(Box<FinalReport>),
    /// The member cannot go on.
    Failed {
        /// Why, for a person.
        reason: String,
    },
    /// PDUs of the frames that end with the next report, whole: of a member whose frames nobody can make again.
    Whole {
        /// Number of the run.
        run: u32,
        /// (frame, octets).
        pdus: Vec<(Frame, Vec<u8>)>,
    },
}

/// How a member stands at a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Standing {
    /// The frame; none before frame 0.
    pub frame: Option<Frame>,
    /// Digest of all that it made up to this frame.
    pub made: u64,
    /// Digest of its state; none if it is not known at this frame any more.
    pub state: Option<u64>,
}

/// Ask for PDUs of a frame that did not arrive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repair {
    /// Number of the run.
    pub run: u32,
    /// (frame, hashes wanted).
    pub wanted: Vec<(Frame, Vec<u64>)>,
}

/// The same by way of the conductor, which hears a producer that the asker does not hear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RepairOf {
    /// Who made them.
    pub of: String,
    /// What is missing.
    pub repair: Repair,
}

/// The PDUs asked for, as far as the producer still has them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repaired {
    /// Number of the run.
    pub run: u32,
    /// (frame, PDU octets).
    pub pdus: Vec<(Frame, Vec<u8>)>,
}

/// What a message costs to keep, octets, roughly.
pub trait Weight {
    /// Octets.
    fn octets(&self) -> usize;
}

impl Weight for Order {
    fn octets(&self) -> usize {
        match self {
            Self::Configure(config) => 1024 + 64 * config.incs.len(),
            _ => 256,
        }
    }
}

impl Weight for Report {
    fn octets(&self) -> usize {
        match self {
            Self::Ends(ends) => ends.octets(),
            Self::Whole { pdus, .. } => 64 + pdus.iter().map(|(_, o)| 16 + o.len()).sum::<usize>(),
            _ => 1024,
        }
    }
}

/// Counters of a member at the end of a run; each kind fills what it has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FinalReport {
    /// Number of the run.
    pub run: u32,
    /// Name of the member.
    pub name: String,
    /// Frame at which it stands.
    pub frame: Frame,
    /// Sum of the digests of PDUs made (truth or weather), one number per purpose.
    pub digests: Vec<(String, u64)>,
    /// Named counters and measures; a name that begins with [`FAULT`] is a fault of what is simulated, its value since when, s.
    pub values: Vec<(String, f64)>,
}

/// How the name of a value begins that tells a fault.
pub const FAULT: &str = "fault ";
/// The same of a measure of the traffic.
pub const MEASURE: &str = "measure ";
