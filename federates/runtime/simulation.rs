//! A whole federation in one thread over a simulated clock, bus, ether and disk: the real [`Conductor`] with its journal, a standby
//! where one is started, the real [`Member`]s and whatever federates are put in. Everything follows from one seed and a list of faults.

mod faults;
mod intruder;
mod members;
mod network;
mod station;

use super::conductor::{ClosedRun, Conductor, ConductorConfig};
use super::federate::Federate;
use super::life_cycle::Phase;
use super::member::{CONDUCTOR, Member};
use super::messages::{Frame, Kind, Numbered, Order, Was};
use super::succession::Voter;
use network::Parcel;
use station::Host;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

pub use faults::{Event, Fault, What};
pub use network::Network;

/// The standby of the station, as a fault names it; there is one from its start on.
pub const STANDBY: &str = "standby";

/// What one is told that the run goes on without, and how that is counted.
const DONE_WITHOUT: &str = "the run goes on without";
const LEFT_OUT: &str = "left out by the run";

/// Where the station is, and its standby.
const PLACES: [&str; 2] = [CONDUCTOR, STANDBY];

/// What a process has drawn that is none of the federation.
const STRANGER: u128 = u128::MAX;

/// A millisecond in the simulated clock's nanoseconds.
pub const MS: u64 = 1_000_000;

/// How long a connection lives without a word, as the bus has it.
const LEASE_NS: u64 = 2_000 * MS;
/// A connection that is gone is tried anew as often at least.
const RECONNECT_NS: u64 = 4_000 * MS;
const BEAT_NS: u64 = 100 * MS;
const HELLO_AGAIN_NS: u64 = 500 * MS;

/// Makes the federate of a name.
pub type Make = Arc<dyn Fn(&str) -> Box<dyn Federate> + Send + Sync>;

struct Node {
    kind: Kind,
    instance: u128,
    member: Option<Member>,
    dead: bool,
    paused_until: u64,
    deaf_until: u64,
    mute_until: u64,
    busy_until: u64,
    busy_since: u64,
    next_beat: u64,
    hello_at: Option<u64>,
    was: Option<Was>,
    /// In whose process it is, if not in one of its own.
    host: Option<String>,
    /// When its connections to the stations stand that were started last.
    finds_station: [u64; 2],
    /// Its voice.
    voter: Voter,
    /// It makes another run of its place than those before it.
    another: bool,
}

/// The federation, its network and what became of it.
pub struct Simulation {
    /// Simulated wall time, ns.
    pub now: u64,
    /// Closed runs.
    pub closed: Vec<ClosedRun>,
    /// Phases reached: phase, frame, whether nobody asked for it.
    pub reached: Vec<(Phase, Frame, bool)>,
    /// Answers to commands.
    pub answers: Vec<(bool, String)>,
    /// Exit code, once the federation is over.
    pub exit: Option<u8>,
    /// Invariants that did not hold.
    pub broken: Vec<String>,
    /// How often what happened.
    pub seen: BTreeMap<&'static str, u64>,
    /// Digest of all that arrived, when and where: equal seeds and faults give equal ones.
    pub trace: u64,
    network: Network,
    random: u64,
    parcels: BTreeMap<(u64, u64), (String, Parcel)>,
    posted: u64,
    nodes: BTreeMap<String, Node>,
    /// The hosts of the station and of its standby.
    hosts: [Host; 2],
    /// When those two have a connection.
    stations_meet: u64,
    /// Processes of stations so far.
    processes: u64,
    /// Where a standby leads on that was not counted yet.
    leads_on: Option<usize>,
    /// Who led in which epoch.
    epochs: BTreeMap<u32, usize>,
    /// What was said to all, by number.
    said: BTreeMap<u64, Numbered<Order>>,
    /// Which of the two stand in a partition for want of voices, and whether that was counted.
    stands_parted: [bool; 2],
    stand_parted: bool,
    /// Who is apart from all others, until when.
    parts: Vec<(BTreeSet<String>, u64)>,
    /// From whom nothing passes to whom, until when.
    bursts: Vec<(String, String, u64)>,
    /// Faults that wait for what they are aimed at.
    traps: Vec<Fault>,
    /// Those that it has happened for, by their time.
    due: BTreeMap<(u64, u64), Fault>,
    /// Until when messages are forged, and what may be said again then.
    intruder_until: u64,
    overheard: VecDeque<Parcel>,
    /// What is said of a federation without a conductor.
    none: Conductor,
    make: Make,
    producers: Vec<String>,
    window: Frame,
    front_ends: BTreeSet<String>,
    /// The last grant that was looked at.
    granted: Frame,
    config: ConductorConfig,
    /// Members that are to leave for another process, by their incarnation.
    yielding: BTreeSet<(String, u64)>,
}

impl Simulation {
    /// A federation whose members all start at time 1; `kinds` says what each member is.
    #[must_use]
    pub fn new(
        seed: u64,
        config: ConductorConfig,
        kinds: &[(String, Kind)],
        make: Make,
        network: Network,
    ) -> Self {
        let (producers, window) = (config.producers.clone(), config.window);
        let front_ends = config.front_ends.keys().cloned().collect();
        let mut simulation = Self {
            front_ends,
            now: 1,
            closed: Vec::new(),
            reached: Vec::new(),
            answers: Vec::new(),
            exit: None,
            broken: Vec::new(),
            seen: BTreeMap::new(),
            trace: 0,
            network,
            random: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            parcels: BTreeMap::new(),
            posted: 0,
            nodes: BTreeMap::new(),
            hosts: [Host::new(), Host::new()],
            stations_meet: 0,
            processes: 0,
            leads_on: None,
            epochs: BTreeMap::new(),
            said: BTreeMap::new(),
            stands_parted: [false; 2],
            stand_parted: false,
            parts: Vec::new(),
            bursts: Vec::new(),
            traps: Vec::new(),
            due: BTreeMap::new(),
            intruder_until: 0,
            overheard: VecDeque::new(),
            none: Conductor::new(config.clone()),
            make,
            producers,
            window,
            granted: 0,
            config,
            yielding: BTreeSet::new(),
        };
        simulation.start_station(0);
        simulation.hosts[0].started = 0;
        for (name, kind) in kinds {
            simulation.start(name, *kind);
        }
        simulation
    }

    /// The member of a name, if its process lives and has joined.
    #[must_use]
    pub fn member(&self, name: &str) -> Option<&Member> {
        self.nodes.get(name).filter(|n| !n.dead).and_then(|n| n.member.as_ref())
    }

    fn draw(&mut self, below: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) % below
    }

    fn chance(&mut self, of_thousand: u64) -> bool {
        self.draw(1000) < of_thousand
    }

    fn note(&mut self, what: &'static str) {
        *self.seen.entry(what).or_default() += 1;
    }

    fn consumers(&self) -> Vec<String> {
        let consumes = |n: &Node| n.member.as_ref().is_some_and(|m| m.federate().consumes());
        self.nodes.iter().filter(|(_, n)| consumes(n)).map(|(name, _)| name.clone()).collect()
    }

    /// When the next thing happens.
    fn next(&self) -> u64 {
        let parcels = self.parcels.keys().next().map(|(at, _)| *at);
        let nodes = self.nodes.values().filter(|n| !n.dead).flat_map(|n| {
            let rests = n.paused_until.max(n.busy_until);
            let deadline = n.member.as_ref().and_then(Member::deadline);
            let wakes = [deadline, n.hello_at].into_iter().flatten().map(move |at| at.max(rests));
            wakes.chain([n.next_beat.max(n.paused_until)])
        });
        let hosts = self.hosts.iter().map(|host| host.next(self.now));
        let due = self.due.keys().next().map(|(at, _)| *at);
        nodes.chain(parcels).chain(hosts).chain(due).min().unwrap_or(self.now)
    }

    /// Runs until a run is closed, the federation is over or `until`, with `faults` at their times.
    pub fn run_to_close(&mut self, until: u64, faults: &[Fault]) {
        self.run_while(until, faults, |simulation| simulation.closed.is_empty());
    }

    /// Runs until a run is closed at its last frame, the federation is over or `until`, with `faults` at their times.
    pub fn run_to_end(&mut self, until: u64, faults: &[Fault]) {
        let last = self.config.last_frame;
        let whole = |simulation: &Self| simulation.closed.last().is_some_and(|c| c.frame >= last);
        self.run_while(until, faults, |simulation| !whole(simulation));
    }

    /// Runs until the federation is over or `until`, with `faults` at their times.
    pub fn run(&mut self, until: u64, faults: &[Fault]) {
        self.run_while(until, faults, |_| true);
    }

    fn run_while(&mut self, until: u64, faults: &[Fault], goes_on: impl Fn(&Self) -> bool) {
        let mut faults: Vec<&Fault> = faults.iter().collect();
        faults.sort_by_key(|f| std::cmp::Reverse(f.at_ns));
        while self.now < until && self.exit.is_none() && goes_on(self) {
            let next_fault = faults.last().map_or(u64::MAX, |f| f.at_ns);
            self.now = self.next().min(next_fault).max(self.now + 1);
            while faults.last().is_some_and(|f| f.at_ns <= self.now) {
                if let Some(fault) = faults.pop() {
                    self.befall(fault);
                }
            }
            self.befall_due();
            self.pass();
        }
    }

    /// Everything that is due now.
    fn pass(&mut self) {
        let now = self.now;
        while let Some(entry) = self.parcels.first_entry() {
            if entry.key().0 > now {
                break;
            }
            let (to, parcel) = entry.remove();
            self.deliver(&to, parcel);
        }
        let names: Vec<String> = self.nodes.keys().cloned().collect();
        for name in &names {
            self.pass_node(name);
        }
        for at in 0..PLACES.len() {
            self.pass_station(at);
        }
    }

    fn pass_node(&mut self, name: &str) {
        let now = self.now;
        let Some(node) = self.nodes.get_mut(name).filter(|n| !n.dead && n.paused_until <= now)
        else {
            return;
        };
        let busy = node.busy_until > now;
        if now >= node.next_beat {
            node.next_beat = now + BEAT_NS;
            if let Some(member) = &node.member {
                let mut beat = member.beat();
                if busy {
                    beat.working = Some((member.executed() + 1, (now - node.busy_since) / MS));
                }
                let loss = self.network.bus_loss;
                let mut others: Vec<String> = self.nodes.keys().cloned().collect();
                others.retain(|n| n != name);
                for to in others.iter().map(String::as_str).chain(PLACES) {
                    self.post(name, to, || Parcel::Beat(name.to_owned(), beat.clone()), loss);
                }
            }
        }
        if busy {
            return;
        }
        let Some(node) = self.nodes.get_mut(name) else { return };
        if node.hello_at.is_some_and(|at| now >= at) {
            return self.ask_to_join(name);
        }
        let mut effects = Vec::new();
        if let Some(member) = &mut node.member {
            member.tick(now, &mut effects);
        }
        self.act(name, effects);
    }

    /// The sum of a figure over the reports of a closed run.
    #[must_use]
    pub fn value(&self, run: usize, key: &str) -> f64 {
        let values = self.closed[run].reports.iter().flat_map(|r| &r.values);
        values.filter(|(k, _)| k == key).map(|(_, v)| v).sum()
    }

    /// The digests of a closed run, by member and name.
    #[must_use]
    pub fn digests(&self, run: usize) -> Vec<(String, String, u64)> {
        let reports = self.closed[run].reports.iter();
        reports
            .flat_map(|r| r.digests.iter().map(|(k, d)| (r.name.clone(), k.clone(), *d)))
            .collect()
    }
}
