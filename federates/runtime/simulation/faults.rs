//! What may happen to a federation, and what it does to the simulated one.

use super::network::Parcel;
use super::{LEASE_NS, MS, Node, Simulation};
use crate::runtime::conductor::Input;
use crate::runtime::member::{CONDUCTOR, Member};
use crate::runtime::messages::Command;
use serde::{Deserialize, Serialize};

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

impl Simulation {
    pub(super) fn befall(&mut self, fault: &Fault) {
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
}
