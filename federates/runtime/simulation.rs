//! A whole federation in one thread over a simulated clock, bus and ether: the real [`Conductor`], the real
//! [`Member`]s and whatever federates are put in. Everything follows from one seed and a list of faults.

use super::conductor::{
    Again, ClosedRun, Conductor, ConductorConfig, Effect as Decision, Input, Step, Why,
};
use super::federate::{Federate, Octets};
use super::life_cycle::Phase;
use super::member::{CONDUCTOR, Effect, Member, Remake};
use super::messages::{
    Accepted, Beat, Command, FetchOf, Fetched, Frame, Hello, Kind, Numbered, Order, Repair,
    Repaired, Report, Was, Welcome,
};
use super::run_log::RunLog;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

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

/// What happens to a federation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// Its process dies, and its connection with it.
    Kill,
    /// It is not heard of any more, and nobody is told.
    Vanish,
    /// A new process of that name is started.
    Start,
    /// The process stands still for so long, ns.
    Pause(u64),
    /// Nothing passes to or from it for so long, ns.
    Cut(u64),
    /// Nothing passes to it for so long, ns.
    Deaf(u64),
    /// Nothing passes from it for so long, ns.
    Mute(u64),
    /// Its next frame takes so long, ns; it says so meanwhile.
    Slow(u64),
    /// An operator's command.
    Command(Command),
}

/// A fault at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// Simulated wall time, ns.
    pub at_ns: u64,
    /// Whom it befalls; empty for a command.
    pub who: String,
    /// What it is.
    pub what: What,
}

/// How the network behaves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// Longest delay of a message, ns; each one draws its own, so order is not kept.
    pub delay_ns: u64,
    /// Messages of the synchronisation plane that are lost, of a thousand.
    pub bus_loss: u64,
    /// PDUs that are lost, of a thousand.
    pub udp_loss: u64,
    /// Messages and PDUs that arrive twice, of a thousand.
    pub twice: u64,
}

enum Parcel {
    Order(Numbered<Order>),
    Report(String, Numbered<Report>),
    Beat(String, Beat),
    Pdus(Vec<Octets>),
    Repair(String, Repair),
    Repaired(Repaired),
    Fetch(String, FetchOf),
    Orders(Fetched<Order>),
    Reports(Fetched<Report>),
    Alive(String, u64, bool),
}

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
    /// When its connection to a station that was started again stands.
    finds_station: u64,
}

/// The federation, its network and what became of it.
pub struct Simulation {
    /// Simulated wall time, ns.
    pub now: u64,
    /// The conductor.
    pub conductor: Conductor,
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
    network: Network,
    random: u64,
    parcels: BTreeMap<(u64, u64), (String, Parcel)>,
    posted: u64,
    nodes: BTreeMap<String, Node>,
    conductor_beat: u64,
    make: Make,
    producers: Vec<String>,
    window: Frame,
    front_ends: BTreeSet<String>,
    /// The last grant that was looked at.
    granted: Frame,
    config: ConductorConfig,
    log: RunLog,
    /// The journal of the station.
    steps: Vec<Step>,
    /// There is no station.
    station_dead: bool,
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
            conductor: Conductor::new(config.clone()),
            closed: Vec::new(),
            reached: Vec::new(),
            answers: Vec::new(),
            exit: None,
            broken: Vec::new(),
            seen: BTreeMap::new(),
            network,
            random: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            parcels: BTreeMap::new(),
            posted: 0,
            nodes: BTreeMap::new(),
            conductor_beat: 0,
            make,
            producers,
            window,
            granted: 0,
            config,
            log: RunLog::default(),
            steps: Vec::new(),
            station_dead: false,
            yielding: BTreeSet::new(),
        };
        for (name, kind) in kinds {
            simulation.start(name, *kind);
        }
        simulation
    }

    fn start(&mut self, name: &str, kind: Kind) {
        let node = Node {
            kind,
            instance: u128::from(self.draw(u64::MAX)) + 1,
            member: None,
            dead: false,
            paused_until: 0,
            deaf_until: 0,
            mute_until: 0,
            busy_until: 0,
            busy_since: 0,
            next_beat: self.now,
            hello_at: Some(self.now),
            was: None,
            host: None,
            finds_station: 0,
        };
        self.nodes.insert(name.to_owned(), node);
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

    /// Puts a message on its way, if it gets on it.
    fn post(&mut self, from: &str, to: &str, make: impl Fn() -> Parcel, loss: u64) {
        if self.nodes.get(from).is_some_and(|n| n.dead || n.mute_until > self.now) {
            return;
        }
        if self.apart(from, to) {
            return;
        }
        for _ in 0..1 + u64::from(self.chance(self.network.twice)) {
            if self.chance(loss) {
                self.note("messages lost");
            } else {
                let at = self.now + 10_000 + self.draw(self.network.delay_ns.max(1));
                self.put(at, to, make());
            }
        }
    }

    /// Whether one of the two is a station that is gone, or to which the other has no connection yet.
    fn apart(&self, from: &str, to: &str) -> bool {
        if self.station_dead && to == CONDUCTOR {
            return true;
        }
        let other = match (from, to) {
            ("", name) | (name, CONDUCTOR) => name,
            _ => return false,
        };
        self.nodes.get(other).is_some_and(|node| node.finds_station > self.now)
    }

    fn put(&mut self, at: u64, to: &str, parcel: Parcel) {
        self.posted += 1;
        self.parcels.insert((at, self.posted), (to.to_owned(), parcel));
    }

    fn consumers(&self) -> Vec<String> {
        let consumes = |n: &Node| n.member.as_ref().is_some_and(|m| m.federate().consumes());
        self.nodes.iter().filter(|(_, n)| consumes(n)).map(|(name, _)| name.clone()).collect()
    }

    /// Tells the conductor, and its journal first.
    fn tell(&mut self, input: Input) -> Vec<Decision> {
        let mut decisions = Vec::new();
        self.steps.push(Step::Told(self.now, input.clone()));
        self.conductor.take(self.now, input, &mut decisions);
        decisions
    }

    /// A station is started in place of one that died: of all that the one before knew it has the journal only.
    fn start_station(&mut self) {
        if !std::mem::take(&mut self.station_dead) {
            return;
        }
        self.note("station made again");
        let mut names: Vec<String> = self.nodes.keys().cloned().collect();
        while let Some(name) = names.pop() {
            let within = self.draw(RECONNECT_NS);
            if let Some(node) = self.nodes.get_mut(&name) {
                node.finds_station = self.now + within;
            }
        }
        let mut log = RunLog::default();
        let steps = std::mem::take(&mut self.steps);
        let Again { conductor, now, effects } =
            Conductor::again(self.config.clone(), steps.clone(), |run, record| {
                log.append(run, record);
            });
        let was = std::mem::replace(&mut self.conductor, conductor);
        if format!("{was:?}") != format!("{:?}", self.conductor) || now > self.now {
            self.broken.push("the journal made another conductor".to_owned());
        }
        (self.log, self.steps) = (log, steps);
        self.closed_again(effects);
        // For the conductor no time passed; the simulation has one clock, so it is told of a pause.
        let decisions = self.tell(Input::Resumed);
        self.decide(decisions);
    }

    /// What the station before decided at last is carried out again, as nobody knows whether it was.
    fn closed_again(&mut self, effects: Vec<Decision>) {
        let twice = |d: &Decision| matches!(d, Decision::Closed(_) | Decision::Reached { .. });
        self.decide(effects.into_iter().filter(|d| !twice(d)).collect());
    }

    fn decide(&mut self, decisions: Vec<Decision>) {
        let loss = self.network.bus_loss;
        for decision in decisions {
            match decision {
                Decision::Order(order) => {
                    if let Order::Grant { upto, .. } = order.body
                        && self.conductor.state().rate.is_infinite()
                        && upto > self.conductor.frame() + self.window
                        && upto > std::mem::replace(&mut self.granted, upto)
                    {
                        let frame = self.conductor.frame();
                        self.broken.push(format!("granted {upto} while all stand at {frame}"));
                    }
                    self.note(match &order.body {
                        Order::Seal { .. } => "seal",
                        Order::Cut { .. } => "cut",
                        Order::View { absent, .. } if absent.is_empty() => "view that waits",
                        Order::View { .. } => "view that goes on",
                        Order::Admit { .. } => "admit",
                        Order::Dismiss { .. } => "dismiss",
                        Order::Yield { .. } => "place given by command",
                        _ => "other orders",
                    });
                    if let Order::Yield { name, inc, .. } = &order.body {
                        self.yielding.insert((name.clone(), *inc));
                    }
                    let names: Vec<String> = self.nodes.keys().cloned().collect();
                    for name in names {
                        self.post("", &name, || Parcel::Order(order.clone()), loss);
                    }
                }
                Decision::Fetch { holder, ask } => {
                    self.note("reports asked for");
                    let parcel = || Parcel::Fetch(CONDUCTOR.to_owned(), ask.clone());
                    self.post("", &holder, parcel, loss);
                }
                Decision::Record(run, record) => self.log.append(run, &record),
                Decision::Closed(run) => self.closed.push(*run),
                Decision::Reached { phase, frame, why } => {
                    if matches!(why, Some(Why::Given(_))) {
                        self.note("stood for a move");
                    }
                    self.reached.push((phase, frame, why.is_some()));
                    if phase == Phase::Frozen {
                        self.check_frozen(frame, why.is_some());
                    }
                }
                Decision::Answer(_, answer) => self.answers.push((answer.ok, answer.text)),
                Decision::Exit(code) => self.exit = Some(code),
                Decision::Welcome(..) | Decision::State(_) => {}
            }
        }
    }

    /// By command all stand at exactly this frame, by a fault all consumers where nothing is left out.
    fn check_frozen(&mut self, frame: Frame, by_fault: bool) {
        let stand = if by_fault { self.conductor.stand() } else { frame };
        let state = self.conductor.state();
        for (name, node) in &self.nodes {
            let Some(member) = node.member.as_ref().filter(|_| !node.dead) else { continue };
            let alive = state.members.iter().any(|m| m.name == *name && m.alive);
            let counts = alive && (!by_fault || member.federate().consumes());
            let at = member.executed();
            // In a closed loop some may be ahead of him who closes it, and some do not read him.
            let most = match by_fault {
                true => self.conductor.stand_of(|p| member.federate().ahead_of(p)),
                false => stand,
            };
            // One that tells its frames to one other alone is a producer: it may have gone on to what was granted.
            let front_end = by_fault && self.front_ends.contains(name);
            if counts && !(stand..=most).contains(&at) && !(front_end && at > stand) {
                let text =
                    format!("FROZEN at {frame}: {name} stands at {at}, not {stand} to {most}");
                self.broken.push(text);
            }
        }
        self.note(if by_fault { "frozen by a fault" } else { "frozen by command" });
    }

    fn act(&mut self, name: &str, effects: Vec<Effect>) {
        let (loss, udp) = (self.network.bus_loss, self.network.udp_loss);
        for effect in effects {
            match effect {
                Effect::Send(pdus) => {
                    for octets in pdus {
                        for to in self.consumers() {
                            self.post(name, &to, || Parcel::Pdus(vec![Arc::clone(&octets)]), udp);
                        }
                    }
                }
                Effect::Report(report) => {
                    let parcel = || Parcel::Report(name.to_owned(), report.clone());
                    self.post(name, CONDUCTOR, parcel, loss);
                    for to in self.consumers().into_iter().filter(|to| to != name) {
                        self.post(name, &to, parcel, loss);
                    }
                }
                Effect::Repair { name: holder, repair } => {
                    self.note("PDUs asked for");
                    self.post(name, &holder, || Parcel::Repair(name.into(), repair.clone()), loss);
                }
                Effect::Fetch { holder, ask } => {
                    self.note("messages asked for");
                    self.post(name, &holder, || Parcel::Fetch(name.into(), ask.clone()), loss);
                }
                Effect::Rejoin(was) => {
                    self.note("outcast");
                    let now = self.now;
                    if let Some(node) = self.nodes.get_mut(name) {
                        node.was = Some(was);
                        node.hello_at = Some(now);
                    }
                }
                Effect::Host { name: lost, .. } => {
                    self.note("taken over");
                    let can = |who: &str| self.nodes.get(who).is_some_and(|node| node.kind.hosts());
                    if !can(name) || !can(&lost) {
                        self.broken.push(format!("{name} is asked to take the place of {lost}"));
                    }
                    // One that has not heard yet that it is to leave does so when it hears it: nothing that it says counts.
                    let leaves = |n: &Node| {
                        let inc = n.member.as_ref().map(Member::inc);
                        inc.is_some_and(|inc| self.yielding.contains(&(lost.clone(), inc)))
                    };
                    let free = self.nodes.get(&lost).filter(|n| n.dead || leaves(n));
                    let free = free.map(|n| n.kind);
                    if let Some(kind) = free {
                        self.start(&lost, kind);
                        if let Some(node) = self.nodes.get_mut(&lost) {
                            node.host = Some(name.to_owned());
                        }
                    }
                }
                Effect::Dismissed(reason) => {
                    self.broken.push(format!("{name} was dismissed: {reason}"));
                }
                Effect::Yielded(_) => {
                    if let Some(node) = self.nodes.get_mut(name) {
                        node.dead = true;
                    }
                }
                Effect::Publish(_) | Effect::Exit(_) => {}
            }
        }
    }

    fn ask_to_join(&mut self, name: &str) {
        let now = self.now;
        let Some(node) = self.nodes.get_mut(name) else { return };
        node.hello_at = Some(now + HELLO_AGAIN_NS);
        let (muted, deaf) = (node.mute_until > now, node.deaf_until > now);
        let process = node.host.as_deref().unwrap_or(name).to_owned();
        let pid = self.nodes.keys().position(|n| *n == process).map_or(0, |at| at as u32 + 1);
        let Some(node) = self.nodes.get(name) else { return };
        let hello = Hello {
            name: name.to_owned(),
            kind: node.kind,
            pid,
            host: "h".into(),
            version: self.config.version.clone(),
            scene_hash: self.config.scene_hash,
            instance: node.instance,
            was: node.was,
        };
        if muted {
            return;
        }
        if self.station_dead || self.apart(name, CONDUCTOR) {
            return;
        }
        let decisions = self.tell(Input::Hello(hello, 0));
        let welcome = decisions.iter().find_map(|d| match d {
            Decision::Welcome(_, welcome) => Some(welcome.clone()),
            _ => None,
        });
        self.decide(decisions);
        if deaf || self.chance(self.network.bus_loss) {
            return self.note("answers to a hello lost");
        }
        match welcome {
            Some(Welcome::Accepted(accepted)) => self.accepted(name, &accepted),
            Some(Welcome::Later(_)) | None => {
                if let Some(node) = self.nodes.get_mut(name) {
                    node.hello_at = Some(now + HELLO_AGAIN_NS / 5);
                }
            }
            Some(Welcome::NameTaken) => self.note("refused"),
            Some(Welcome::Refused(why)) => {
                // Another process of that name lives, as far as the conductor knows: later perhaps not.
                self.note("refused");
                if !why.contains("already running") {
                    self.broken.push(format!("{name} was refused: {why}"));
                }
            }
        }
    }

    fn accepted(&mut self, name: &str, accepted: &Accepted) {
        let make = Arc::clone(&self.make);
        let (made, producers) = (Arc::clone(&make), self.producers.clone());
        let remake: Remake =
            Box::new(move |_| Ok(producers.iter().map(|n| (n.clone(), made(n))).collect()));
        let Some(node) = self.nodes.get_mut(name) else { return };
        node.hello_at = None;
        node.was = None;
        let mut effects = Vec::new();
        let again = node.member.is_some();
        let member =
            node.member.get_or_insert_with(|| Member::new(make(name), name, accepted, || 0));
        if again || accepted.enter.is_some() {
            let run = accepted.enter.as_ref().map_or(0, |enter| enter.config.run);
            let log = &mut self.log;
            let mut pages = |page| Ok(log.page(run, page));
            member.enter(accepted, Some(&remake), &mut pages, &mut effects);
        }
        self.note(match accepted.enter.as_ref().map(|e| e.keep) {
            Some(true) => "return that may keep its state",
            Some(false) => "return that makes the run again",
            None => "join",
        });
        self.act(name, effects);
    }

    fn befall(&mut self, fault: &Fault) {
        let hosted = |n: &Node| n.host.as_ref() == Some(&fault.who) && !n.dead;
        let beside: Vec<String> =
            self.nodes.iter().filter(|(_, n)| hosted(n)).map(|(name, _)| name.clone()).collect();
        self.befall_one(fault);
        if !matches!(fault.what, What::Start | What::Command(_) | What::Slow(_)) {
            for who in beside {
                self.befall_one(&Fault { who, ..fault.clone() });
            }
        }
    }

    fn befall_one(&mut self, fault: &Fault) {
        let (now, who) = (self.now, fault.who.clone());
        if let What::Command(command) = &fault.what {
            if self.station_dead {
                return self.note("commands to no station");
            }
            let decisions = self.tell(Input::Command(command.clone(), 9));
            return self.decide(decisions);
        }
        if who == CONDUCTOR {
            match fault.what {
                What::Kill | What::Vanish => self.station_dead = true,
                What::Start => self.start_station(),
                _ => {}
            }
            return;
        }
        let Some(node) = self.nodes.get_mut(&who) else { return };
        let (inc, kind) = (node.member.as_ref().map(Member::inc), node.kind);
        let mut gone = None;
        match fault.what {
            What::Kill => {
                node.dead = true;
                gone = Some((now + 8 * MS, None));
            }
            What::Vanish => node.dead = true,
            What::Start if node.dead => self.start(&who, kind),
            What::Start | What::Command(_) => {}
            What::Pause(ns) => {
                node.paused_until = node.paused_until.max(now + ns);
                gone = Some((now + LEASE_NS, Some(now + ns)));
            }
            What::Cut(ns) => {
                node.deaf_until = node.deaf_until.max(now + ns);
                node.mute_until = node.mute_until.max(now + ns);
                gone = Some((now + LEASE_NS, Some(now + ns)));
            }
            What::Deaf(ns) => node.deaf_until = node.deaf_until.max(now + ns),
            What::Mute(ns) => node.mute_until = node.mute_until.max(now + ns),
            What::Slow(ns) => {
                node.busy_since = now;
                node.busy_until = node.busy_until.max(now + ns);
            }
        }
        if let (Some((at, back)), Some(inc)) = (gone, inc)
            && back.is_none_or(|back| back > at)
        {
            self.put(at, CONDUCTOR, Parcel::Alive(who.clone(), inc, false));
            if let Some(back) = back {
                self.put(back, CONDUCTOR, Parcel::Alive(who, inc, true));
            }
        }
    }

    fn deliver(&mut self, to: &str, parcel: Parcel) {
        let now = self.now;
        if to == CONDUCTOR {
            return self.deliver_to_conductor(parcel);
        }
        let Some(node) = self.nodes.get_mut(to).filter(|n| !n.dead && n.deaf_until <= now) else {
            return;
        };
        let rests_until = node.paused_until.max(node.busy_until);
        if rests_until > now {
            // What waits for a process that stands still for long is lost with its connection.
            if node.paused_until <= now + LEASE_NS {
                self.put(rests_until, to, parcel);
            }
            return;
        }
        let Some(member) = &mut node.member else { return };
        let mut effects = Vec::new();
        let mut answer = None;
        match parcel {
            Parcel::Order(order) => member.order(now, order, &mut effects),
            Parcel::Report(from, report) => member.report(now, &from, report, &mut effects),
            Parcel::Beat(from, beat) => member.hear_beat(now, &from, &beat),
            Parcel::Pdus(pdus) => member.pdus(now, pdus, &mut effects),
            Parcel::Repaired(repaired) => member.repaired(now, repaired, &mut effects),
            Parcel::Orders(fetched) => member.fetched_orders(now, fetched, &mut effects),
            Parcel::Reports(fetched) => member.fetched(now, fetched, &mut effects),
            Parcel::Repair(from, repair) => {
                answer = Some((from, Parcel::Repaired(member.repair(&repair))));
            }
            Parcel::Fetch(from, ask) => answer = Some((from, Parcel::Reports(member.fetch(&ask)))),
            Parcel::Alive(..) => {}
        }
        let executed = member.executed();
        if executed > self.conductor.granted() && self.conductor.phase() == Phase::Running {
            self.broken.push(format!("{to} executed frame {executed}, which was not granted"));
        }
        self.act(to, effects);
        if let Some((from, parcel)) = answer {
            self.reply(to, &from, parcel);
        }
    }

    /// An answer, which is lost as any message is.
    fn reply(&mut self, from: &str, to: &str, parcel: Parcel) {
        let muted = self.nodes.get(from).is_some_and(|n| n.dead || n.mute_until > self.now);
        if !muted && !self.apart(from, to) && !self.chance(self.network.bus_loss) {
            let at = self.now + 10_000 + self.draw(self.network.delay_ns.max(1));
            self.put(at, to, parcel);
        }
    }

    fn deliver_to_conductor(&mut self, parcel: Parcel) {
        if self.station_dead {
            return;
        }
        let input = match parcel {
            Parcel::Report(from, report) => Input::Report(from, report),
            Parcel::Beat(from, beat) => Input::Beat(from, beat),
            Parcel::Reports(fetched) => Input::Fetched(fetched),
            Parcel::Alive(name, inc, alive) => Input::Alive(name, inc, alive),
            Parcel::Fetch(from, ask) if ask.of == CONDUCTOR => {
                let fetched = self.conductor.fetch_orders(&ask);
                return self.reply("", &from, Parcel::Orders(fetched));
            }
            Parcel::Fetch(from, ask) => {
                let fetched = self.conductor.fetch_reports(&ask);
                return self.reply("", &from, Parcel::Reports(fetched));
            }
            _ => return,
        };
        let decisions = self.tell(input);
        self.decide(decisions);
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
        let conductor = match self.station_dead {
            true => [u64::MAX; 2],
            false => [self.conductor.deadline(self.now), self.conductor_beat],
        };
        nodes.chain(parcels).chain(conductor).min().unwrap_or(self.now)
    }

    /// Runs until a run is closed, the federation is over or `until`, with `faults` at their times.
    pub fn run_to_close(&mut self, until: u64, faults: &[Fault]) {
        self.run_while(until, faults, |simulation| simulation.closed.is_empty());
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
        if self.station_dead {
            return;
        }
        if now >= self.conductor_beat {
            self.conductor_beat = now + BEAT_NS;
            let beat = self.conductor.own_beat();
            for name in &names {
                let parcel = || Parcel::Beat(CONDUCTOR.to_owned(), beat.clone());
                self.post("", name, parcel, self.network.bus_loss);
            }
        }
        let mut decisions = Vec::new();
        self.steps.push(Step::Tick(now));
        self.conductor.tick(now, &mut decisions);
        self.decide(decisions);
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
                for to in others.iter().map(String::as_str).chain([CONDUCTOR]) {
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
