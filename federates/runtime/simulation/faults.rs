//! What may happen to a federation, and what it does to the simulated one.

use super::network::Parcel;
use super::{LEASE_NS, MS, Node, PLACES, STRANGER, Simulation};
use crate::runtime::member::Member;
use crate::runtime::messages::Command;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// What a fault may be aimed at: something that the protocol does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// The station seals lost members.
    Seal,
    /// A member says how far it holds their frames.
    Sealed,
    /// The station says up to where they count.
    Cut,
    /// A member holds all frames up to there.
    Held,
    /// The loss is settled.
    View,
    /// One that was lost is let in again.
    Admit,
    /// The run is over.
    Finish,
    /// A member tells its results.
    Final,
    /// A station asks a voter.
    Candidacy,
    /// A station leads a new epoch.
    Leads,
}

impl Event {
    /// The row of what was seen that counts faults aimed at it.
    fn row(self) -> &'static str {
        match self {
            Self::Seal => "aimed at seal",
            Self::Sealed => "aimed at sealed",
            Self::Cut => "aimed at cut",
            Self::Held => "aimed at held",
            Self::View => "aimed at view",
            Self::Admit => "aimed at admit",
            Self::Finish => "aimed at finish",
            Self::Final => "aimed at results",
            Self::Candidacy => "aimed at candidacy",
            Self::Leads => "aimed at a new leader",
        }
    }
}

/// What happens to a federation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// This, so long after the event, ns, when that happens next; a start of the same one before that calls it off.
    Aimed(Event, u64, Box<What>),
    /// Nothing passes from it to that one for so long, ns, messages and PDUs alike.
    Burst(String, u64),
    /// The disk of the station there is full, until it is started again; what is being written ends in the middle.
    Full,
    /// A process of that name asks to join that is of another build, or has another scene.
    Stranger {
        /// Its build is another one, else its scene.
        build: bool,
    },
    /// A process of that name is started that makes another run of it than the one that was lost.
    Another,
    /// Whatever passes is followed by forged messages for so long, ns: of another federation, of another incarnation, what was said
    /// before, and octets of nobody.
    Intruder(u64),
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
    /// It and these have no connection to all others for so long, ns.
    Part(Vec<String>, u64),
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

impl Simulation {
    pub(super) fn befall(&mut self, fault: &Fault) {
        let hosted = |n: &Node| n.host.as_ref() == Some(&fault.who) && !n.dead;
        let beside: Vec<String> =
            self.nodes.iter().filter(|(_, n)| hosted(n)).map(|(name, _)| name.clone()).collect();
        self.befall_one(fault);
        // Of a process, not of a place in it.
        let all = matches!(
            fault.what,
            What::Kill
                | What::Vanish
                | What::Pause(_)
                | What::Cut(_)
                | What::Deaf(_)
                | What::Mute(_)
        );
        if all {
            for who in beside {
                self.befall_one(&Fault { who, ..fault.clone() });
            }
        }
    }

    fn befall_one(&mut self, fault: &Fault) {
        let (now, who) = (self.now, fault.who.clone());
        if fault.what == What::Start {
            self.traps.retain(|trap| trap.who != who);
        }
        match &fault.what {
            What::Command(command) => return self.command(command),
            What::Aimed(..) => return self.traps.push(fault.clone()),
            What::Burst(to, ns) => return self.bursts.push((who, to.clone(), now + ns)),
            What::Intruder(ns) => {
                self.note("intruder");
                self.intruder_until = self.intruder_until.max(now + ns);
                return;
            }
            What::Stranger { build } => return self.stranger(&who, *build),
            _ => {}
        }
        if let What::Part(others, ns) = &fault.what {
            let part = others.iter().cloned().chain([who]).collect();
            return self.part(part, *ns);
        }
        if let Some(at) = PLACES.iter().position(|place| *place == who) {
            return self.befall_station(at, &fault.what);
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
            What::Another if node.dead => {
                self.start(&who, kind);
                if let Some(node) = self.nodes.get_mut(&who) {
                    node.another = true;
                }
            }
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
            _ => {}
        }
        if let (Some((at, back)), Some(inc)) = (gone, inc)
            && back.is_none_or(|back| back > at)
        {
            for place in PLACES {
                self.put(at, place, Parcel::Alive(who.clone(), inc, false));
                if let Some(back) = back {
                    self.put(back, place, Parcel::Alive(who.clone(), inc, true));
                }
            }
        }
    }

    fn befall_station(&mut self, at: usize, what: &What) {
        let now = self.now;
        let host = &mut self.hosts[at];
        match *what {
            What::Start => self.start_station(at),
            _ if host.dead => {}
            What::Kill | What::Vanish => {
                host.dead = true;
                let closes = if *what == What::Kill { 8 * MS } else { LEASE_NS };
                self.put(now + closes, PLACES[1 - at], Parcel::Station(false));
            }
            What::Pause(ns) => {
                host.paused_until = host.paused_until.max(now + ns);
                self.connection_ends(at, ns);
            }
            What::Cut(ns) => {
                host.deaf_until = host.deaf_until.max(now + ns);
                host.mute_until = host.mute_until.max(now + ns);
                self.connection_ends(at, ns);
                let names: Vec<String> = self.nodes.keys().cloned().collect();
                names.iter().for_each(|name| self.token_ends(name, at, ns));
            }
            What::Deaf(ns) => host.deaf_until = host.deaf_until.max(now + ns),
            What::Mute(ns) => host.mute_until = host.mute_until.max(now + ns),
            What::Full => host.fill_disk(),
            _ => {}
        }
    }

    /// Faults that are aimed at this befall whom they are for.
    pub(super) fn event(&mut self, event: Event) {
        let hit = |trap: &Fault| matches!(&trap.what, What::Aimed(at, ..) if *at == event);
        let (hit, left) = std::mem::take(&mut self.traps).into_iter().partition(hit);
        self.traps = left;
        let hit: Vec<Fault> = hit;
        for Fault { who, what, .. } in hit {
            let What::Aimed(_, late_ns, what) = what else { continue };
            self.note(event.row());
            let at_ns = self.now + late_ns;
            self.posted += 1;
            self.due.insert((at_ns, self.posted), Fault { at_ns, who, what: *what });
        }
    }

    /// Faults that were aimed at something which has happened.
    pub(super) fn befall_due(&mut self) {
        while let Some(entry) = self.due.first_entry() {
            if entry.key().0 > self.now {
                break;
            }
            let fault = entry.remove();
            self.befall(&fault);
        }
    }

    /// One that is none of the federation asks to be let in.
    fn stranger(&mut self, name: &str, build: bool) {
        let Some(node) = self.nodes.get(name) else { return };
        let mut hello = self.hello_of(name, node);
        hello.instance = STRANGER;
        match build {
            true => hello.version += ", another build",
            false => hello.scene_hash ^= 1,
        }
        for at in 0..PLACES.len() {
            if self.works(at) {
                self.hello(at, hello.clone());
            }
        }
    }

    /// The other station sees that the connection of this one is gone for so long.
    fn connection_ends(&mut self, at: usize, ns: u64) {
        if ns > LEASE_NS {
            self.put(self.now + LEASE_NS, PLACES[1 - at], Parcel::Station(false));
            self.put(self.now + ns, PLACES[1 - at], Parcel::Station(true));
        }
    }

    /// A station sees that the connection of a member is gone for so long.
    fn token_ends(&mut self, name: &str, at: usize, ns: u64) {
        let member = self.nodes.get(name).filter(|node| !node.dead);
        let inc = member.and_then(|node| node.member.as_ref()).map(Member::inc);
        if let Some(inc) = inc.filter(|_| ns > LEASE_NS) {
            let alive = |alive| Parcel::Alive(name.to_owned(), inc, alive);
            self.put(self.now + LEASE_NS, PLACES[at], alive(false));
            self.put(self.now + ns, PLACES[at], alive(true));
        }
    }

    fn part(&mut self, mut part: BTreeSet<String>, ns: u64) {
        let with = |n: &&Node| n.host.as_ref().is_some_and(|host| part.contains(host));
        let beside = self.nodes.iter().filter(|(_, n)| with(n)).map(|(name, _)| name.clone());
        let beside: Vec<String> = beside.collect();
        part.extend(beside);
        for (at, place) in PLACES.iter().enumerate() {
            let names = self.nodes.keys().filter(|n| part.contains(*n) != part.contains(*place));
            let names: Vec<String> = names.cloned().collect();
            names.iter().for_each(|name| self.token_ends(name, at, ns));
        }
        if part.contains(PLACES[0]) != part.contains(PLACES[1]) {
            (0..PLACES.len()).for_each(|at| self.connection_ends(at, ns));
        }
        self.parts.push((part, self.now + ns));
    }
}
