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
//! | `alive/{name}/{inc}` | liveliness | a hint only |
//! | `obs/state` | may be lost, last value served | [`RunState`] |
//! | `obs/fed/{name}` | may be lost | [`FederateStatus`] |
//! | `obs/operation` | may be lost | [`Operation`], conductor: every command with its answer |
//! | `obs/foreign` | may be lost | [`ForeignReport`]s: tracks of somebody else's tracker |
//! | `obs/weather`, `obs/flights` | may be lost, last value served | [`WeatherNotice`], [`FlightNotice`]s |
//! | `obs/traffic` | may be lost, last value served | JSON: what flights that behave are about |
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

mod log;
mod notices;
mod scan;
mod seat;

use super::codec::encoded_size;
use super::life_cycle::Phase;
use serde::{Deserialize, Serialize};

pub use log::{LogAsk, LogPage, LogRecord};
pub use notices::{
    AdviceNotice, AlertMessage, CausedPlot, ClearanceNotice, FlightNotice, GivenNotice, Notice,
    PlotsNotice, SeatEvent, SeatMessage, TrackNotice, WantNotice, WeatherNotice,
};
pub use scan::{ForeignReport, LagMessage, PlotMessage, ScanReport, TrackMessage, TruthMessage};
pub use seat::{HANDOVER_SEAT, SeatAction, SeatAnswer, SeatInput, SeatOrder, SeatWords, seat_key};

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

/// All frames from `first` to `last` have been executed by the sender.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameEnds {
    /// Number of the run.
    pub run: u32,
    /// First frame of this message.
    pub first: Frame,
    /// Last frame of this message.
    pub last: Frame,
    /// Hashes of the PDUs of each frame that has any: (frame, hashes in ascending order).
    pub pdus: Vec<(Frame, Vec<u64>)>,
    /// Notices: in which frame each was made, in which it takes effect (that one or later), and the notice.
    pub notices: Vec<(Frame, Frame, Notice)>,
    /// Digest of the sender's state at `last`; none in a part that others follow.
    pub state: Option<u64>,
    /// Frame `last` goes on in the next report of the sender.
    pub goes_on: bool,
}

/// Octets of one report: a longer one is told in parts.
pub(super) const REPORT_OCTETS: usize = 192 << 10;

/// Octets of what one frame may consist of in all: 64 MiB, four million PDUs.
const FRAME_OCTETS: usize = 64 << 20;

impl FrameEnds {
    /// The same in reports of bounded length: cut between frames, and within one that is too long by itself.
    #[must_use]
    pub fn parts(self) -> Vec<Self> {
        if encoded_size(&self) <= REPORT_OCTETS {
            return vec![self];
        }
        if self.first >= self.last {
            return self.parts_of_a_frame();
        }
        let middle = self.first + (self.last - self.first) / 2;
        let Self { run, first, last, pdus, notices, state, goes_on } = self;
        let (pdus, later_pdus) = pdus.into_iter().partition(|(frame, _)| *frame <= middle);
        let (notices, later_notices) = notices.into_iter().partition(|(made, ..)| *made <= middle);
        let head = Self { run, first, last: middle, pdus, notices, state: None, goes_on: false };
        let (pdus, notices) = (later_pdus, later_notices);
        let tail = Self { run, first: middle + 1, last, pdus, notices, state, goes_on };
        [head.parts(), tail.parts()].concat()
    }

    fn parts_of_a_frame(self) -> Vec<Self> {
        let Self { run, first, last, pdus, notices, state, goes_on } = self;
        let part = || Self { run, first, last, goes_on: true, ..Self::default() };
        let mut parts = Vec::new();
        for (frame, hashes) in pdus {
            for chunk in hashes.chunks(REPORT_OCTETS / 16) {
                parts.push(Self { pdus: vec![(frame, chunk.to_vec())], ..part() });
            }
        }
        let mut octets = REPORT_OCTETS;
        for (made, effect, notice) in notices {
            for piece in notice.pieces() {
                let size = encoded_size(&piece);
                if octets + size > REPORT_OCTETS {
                    parts.push(part());
                    octets = 0;
                }
                octets += size;
                if let Some(last) = parts.last_mut() {
                    last.notices.push((made, effect, piece));
                }
            }
        }
        if let Some(last) = parts.last_mut() {
            (last.state, last.goes_on) = (state, goes_on);
        }
        parts
    }

    /// Adds the next part of the frame with which this ends.
    fn join(&mut self, next: Self) {
        for (frame, hashes) in next.pdus {
            match self.pdus.last_mut() {
                Some((last, known)) if *last == frame => known.extend(hashes),
                _ => self.pdus.push((frame, hashes)),
            }
        }
        for (made, effect, notice) in next.notices {
            match (self.notices.last_mut(), notice) {
                (Some((_, _, Notice::Flights(known))), Notice::MoreFlights(more)) => {
                    known.extend(more);
                }
                (_, notice) => self.notices.push((made, effect, notice)),
            }
        }
        (self.last, self.state, self.goes_on) = (next.last, next.state, next.goes_on);
    }
}

/// Puts frame ends that came in parts together again.
#[derive(Clone, Debug, Default)]
pub struct Joined {
    /// Number of the first part, and what came so far.
    open: Option<(u64, FrameEnds)>,
}

impl Joined {
    /// The next report of the stream, with its number: what is complete now, with the number of its first part.
    pub fn take(&mut self, seq: u64, ends: FrameEnds) -> Option<(u64, FrameEnds)> {
        let (seq, whole) = match self.open.take() {
            Some((first, mut open)) if (open.run, open.last) == (ends.run, ends.first) => {
                open.join(ends);
                (first, open)
            }
            _ => (seq, ends),
        };
        if !whole.goes_on {
            return Some((seq, whole));
        }
        // What no sender of ours would make is not kept: its frame never ends.
        if whole.octets() <= FRAME_OCTETS {
            self.open = Some((seq, whole));
        }
        None
    }
}

/// Ask for PDUs of a frame that did not arrive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repair {
    /// Number of the run.
    pub run: u32,
    /// (frame, hashes wanted).
    pub wanted: Vec<(Frame, Vec<u64>)>,
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

impl Weight for FrameEnds {
    fn octets(&self) -> usize {
        let hashes: usize = self.pdus.iter().map(|(_, hashes)| 16 + 8 * hashes.len()).sum();
        let notices = self.notices.iter().map(|(_, _, notice)| match notice {
            Notice::Flights(flights) | Notice::MoreFlights(flights) => 64 + 256 * flights.len(),
            Notice::Outsider { octets, .. } => 64 + octets.len(),
            Notice::Tracks(tracks) => 64 + 128 * tracks.len(),
            Notice::Clearances(all) => all.iter().map(|c| 128 + 16 * c.way_m.len()).sum(),
            Notice::Wants { wants, .. } => 64 + 64 * wants.len(),
            Notice::Plots(of) => 256 + 256 * of.plots.len(),
            Notice::Given(_) | Notice::Seat(_) => 256,
        });
        128 + hashes + notices.sum::<usize>()
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
    /// Named counters and measures.
    pub values: Vec<(String, f64)>,
}

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
