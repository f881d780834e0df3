//! A member of the federation as a state machine: orders, reports, beats and datagrams in; reports,
//! datagrams, requests and publications out. It executes frame k when k is granted and every input of k
//! is complete, never because a timer fired.

mod contact;
mod frames;
mod inputs;
mod orders;
mod past;
mod returning;
mod streams;

use super::clock::WallNs;
use super::digest::Digest;
use super::federate::{Aside, Federate, FrameOut, Octets, Publication};
use super::hearing::Hearing;
use super::messages::{
    Accepted, Cuts, FetchOf, Frame, FrameEnds, Joined, Notice, Numbered, Order, Repair, Report,
    RunConfig, Was,
};
use super::stream::{Inbox, Outbox};
use contact::Contact;
use inputs::{Incomplete, Producer};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

pub use past::Pages;
pub use returning::{Makers, Remake};

/// How the conductor is called where messages of streams are asked for.
pub const CONDUCTOR: &str = "conductor";

/// Frames of own PDUs kept for repair and return: far more than any grant horizon.
const KEPT_FRAMES: usize = 512;

/// Octets of PDUs told whole in one report.
const WHOLE_OCTETS: usize = 128 << 10;

/// PDUs waiting for the frame end that names them, at most; beyond, the oldest go.
const MAX_WAITING: usize = 200_000;

/// What a member wants done.
#[derive(Debug)]
pub enum Effect {
    /// Send PDUs to the data plane.
    Send(Vec<Octets>),
    /// Tell conductor and consumers.
    Report(Numbered<Report>),
    /// Ask somebody who may have them for PDUs.
    Repair {
        /// Whom; the conductor passes it on.
        holder: String,
        /// Who made them.
        of: String,
        /// What is missing.
        repair: Repair,
    },
    /// Ask somebody who may have them for messages of a stream.
    Fetch {
        /// Whom.
        holder: String,
        /// What is missing.
        ask: FetchOf,
    },
    /// Publish on the bus.
    Publish(Publication),
    /// The federation goes on without this incarnation: join again.
    Rejoin(Was),
    /// Take the place of a lost member beside this one.
    Host {
        /// Its name.
        name: String,
        /// Number of traffic generators of the run.
        generators: u32,
    },
    /// The federation does not take this process back.
    Dismissed(String),
    /// The process of this one takes its place: leave.
    Yielded(String),
    /// Leave with this exit code.
    Exit(u8),
}

/// Counters of the data plane as this member saw it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinkCounters {
    /// PDUs that arrived and belong to a frame of the federation.
    pub received: u64,
    /// PDUs of the federation that did not arrive before their frame was repaired.
    pub lost: u64,
    /// PDUs fetched by request.
    pub repaired: u64,
    /// PDUs sent.
    pub sent: u64,
    /// PDUs of outsiders handed to the federate.
    pub outsiders: u64,
}

/// What is being executed, for the thread that says so while the federate is at it.
#[derive(Debug, Default)]
pub struct Pulse {
    /// Frame + 1; 0 while nothing is executed.
    frame: AtomicU64,
    since_us: AtomicU64,
}

impl Pulse {
    fn begin(&self, frame: Frame, now_us: u64) {
        self.since_us.store(now_us, Ordering::Relaxed);
        self.frame.store(frame + 1, Ordering::Relaxed);
    }

    fn end(&self) {
        self.frame.store(0, Ordering::Relaxed);
    }

    /// The frame that is being executed, and for how long, ms.
    #[must_use]
    pub fn working(&self, now_us: u64) -> Option<(Frame, u64)> {
        let frame = self.frame.load(Ordering::Relaxed).checked_sub(1)?;
        Some((frame, now_us.saturating_sub(self.since_us.load(Ordering::Relaxed)) / 1000))
    }
}

/// How often it is said that time stands: others forget an entity after 12 s of silence.
const STANDS_EVERY_NS: WallNs = 4_000_000_000;

/// What this member made in a frame.
#[derive(Debug)]
struct Own {
    frame: Frame,
    pdus: Vec<(u64, Octets)>,
    notices: Vec<(Frame, Notice)>,
    /// Digest of all that it made up to and in this frame.
    made: u64,
}

/// The state machine around a [`Federate`].
pub struct Member {
    federate: Box<dyn Federate>,
    name: String,
    fed: u128,
    inc: u64,
    orders: Inbox<Order>,
    outbox: Outbox<Report>,
    peers: BTreeMap<String, Inbox<Report>>,
    /// Producers that were asked since they were heard.
    contacts: BTreeMap<String, Contact>,
    config: Option<RunConfig>,
    heard: BTreeSet<String>,
    granted: Frame,
    /// Frame executed; `None` before configuration.
    executed: Frame,
    /// Frame up to which ends were reported.
    reported: Option<Frame>,
    unreported: FrameEnds,
    producers: BTreeMap<String, Producer>,
    /// Frame ends that came in parts, by producer, of an incarnation.
    joined: BTreeMap<String, (u64, Joined)>,
    /// Frame ends that may not be used yet: of an incarnation that is not admitted, or that is being sealed.
    early: BTreeMap<String, Vec<(u64, FrameEnds)>>,
    incomplete: BTreeMap<(Frame, String), Incomplete>,
    /// Arrived PDUs that no frame end has named yet: hash → (octets, arrival number).
    waiting: BTreeMap<u64, (Octets, u64)>,
    waiting_order: VecDeque<(u64, u64, Frame)>,
    arrivals: u64,
    /// Inputs by frame and producer.
    ready: BTreeMap<(Frame, String), Vec<Octets>>,
    /// Notices by the frame of their effect and producer, each with the frame in which it was made.
    notices: BTreeMap<(Frame, String), Vec<(Frame, Notice)>>,
    /// First frame whose inputs no step has used yet.
    unused: Frame,
    /// Inputs of the latest frames executed, for other consumers that lack them.
    eaten: VecDeque<(Frame, Vec<Octets>)>,
    /// The view whose cuts are to be held: number, last frame of each lost member.
    holding: Option<(u32, Cuts)>,
    /// The federation goes on without this incarnation.
    outcast: bool,
    own: VecDeque<Own>,
    /// Digests of the federate's state at the ends of the latest reports.
    states: VecDeque<(Frame, u64)>,
    /// Digest of all that was made.
    content: u64,
    closed: bool,
    /// Time stands: when that is said again.
    stands: Option<WallNs>,
    /// What frame 0 consists of, until time is granted.
    zero: Option<FrameOut>,
    made: Digest,
    counters: LinkCounters,
    window: Frame,
    microseconds: fn() -> u64,
    exec: ExecTimes,
    pulse: Arc<Pulse>,
    hearing: Hearing,
}

/// Execution times of steps, µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExecTimes {
    /// Steps timed.
    pub steps: u64,
    /// Sum.
    pub sum_us: u64,
    /// Longest.
    pub max_us: u64,
}

impl Member {
    /// A member called `name`, as the conductor accepted it. `microseconds` reads a monotonic clock for
    /// statistics and beats only; tests pass `|| 0`.
    #[must_use]
    pub fn new(
        federate: Box<dyn Federate>,
        name: &str,
        accepted: &Accepted,
        microseconds: fn() -> u64,
    ) -> Self {
        let Accepted { fed, inc, orders, .. } = *accepted;
        Self {
            federate,
            name: name.to_owned(),
            fed,
            inc,
            orders: Inbox::new(fed, 0, orders + 1),
            outbox: Outbox::new(fed, inc),
            peers: BTreeMap::new(),
            contacts: BTreeMap::new(),
            config: None,
            heard: BTreeSet::new(),
            granted: 0,
            executed: 0,
            reported: None,
            unreported: FrameEnds::default(),
            producers: BTreeMap::new(),
            joined: BTreeMap::new(),
            early: BTreeMap::new(),
            incomplete: BTreeMap::new(),
            waiting: BTreeMap::new(),
            waiting_order: VecDeque::new(),
            arrivals: 0,
            ready: BTreeMap::new(),
            notices: BTreeMap::new(),
            unused: 0,
            eaten: VecDeque::new(),
            holding: None,
            outcast: false,
            own: VecDeque::new(),
            states: VecDeque::new(),
            content: 0,
            closed: false,
            stands: None,
            zero: None,
            made: Digest::default(),
            counters: LinkCounters::default(),
            window: 10,
            microseconds,
            exec: ExecTimes::default(),
            pulse: Arc::default(),
            hearing: Hearing::default(),
        }
    }

    /// What it hears of its producers on the data plane.
    pub fn hearing(&mut self) -> &mut Hearing {
        &mut self.hearing
    }

    /// Frame executed.
    #[must_use]
    pub fn executed(&self) -> Frame {
        self.executed
    }

    /// Incarnation.
    #[must_use]
    pub fn inc(&self) -> u64 {
        self.inc
    }

    /// Counters of the data plane.
    #[must_use]
    pub fn counters(&self) -> &LinkCounters {
        &self.counters
    }

    /// Execution times since the last call.
    pub fn take_exec(&mut self) -> ExecTimes {
        std::mem::take(&mut self.exec)
    }

    /// The logic inside.
    #[must_use]
    pub fn federate(&self) -> &dyn Federate {
        &*self.federate
    }

    /// What is being executed.
    #[must_use]
    pub fn pulse(&self) -> Arc<Pulse> {
        Arc::clone(&self.pulse)
    }

    fn run(&self) -> u32 {
        self.config.as_ref().map_or(0, |c| c.run)
    }

    /// A part of this process cannot go on.
    pub fn fail(&mut self, reason: String, effects: &mut Vec<Effect>) {
        self.tell(Report::Failed { reason }, effects);
    }

    /// Says that time stands, where it is due and there is something to say.
    fn stand(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        if self.stands.is_some_and(|due| now >= due) {
            let told = self.aside(Aside::Stands, effects);
            self.stands = told.then_some(now + STANDS_EVERY_NS);
        }
    }

    /// Sends what belongs to no frame; says whether there was any.
    fn aside(&mut self, what: Aside, effects: &mut Vec<Effect>) -> bool {
        let pdus = self.federate.aside(what);
        let any = !pdus.is_empty();
        if any {
            effects.push(Effect::Send(pdus));
        }
        any
    }

    fn tell(&mut self, report: Report, effects: &mut Vec<Effect>) {
        effects.push(Effect::Report(self.outbox.push(report)));
    }

    /// What it waits for, for people: each producer whose frames it lacks, and what is known of them.
    #[must_use]
    pub fn waits_for(&self) -> Vec<String> {
        let next = self.executed + 1;
        let lacks = |(name, producer): (&String, &Producer)| {
            let complete = self.complete_of(name);
            (!producer.absent && complete < Some(next)).then(|| {
                let (inc, ended, bound) = (producer.inc, producer.ended, producer.bound);
                let stream = self.peers.get(name).map(|i| (i.inc(), i.seen()));
                format!(
                    "frame {next} of {name}: complete to {complete:?}, ended {ended:?}, incarnation {inc:?}, bound {bound:?}, awaited {}, reports {stream:?}",
                    producer.awaited
                )
            })
        };
        self.producers.iter().filter_map(lacks).collect()
    }
}
