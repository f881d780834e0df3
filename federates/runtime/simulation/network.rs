//! The simulated network: messages and PDUs on their way, late, lost, twice or out of order.

use super::{LEASE_NS, Simulation};
use crate::runtime::conductor::Input;
use crate::runtime::federate::Octets;
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{Beat, FetchOf, Fetched, Numbered, Order, Repair, Repaired, Report};
use serde::{Deserialize, Serialize};

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

pub(super) enum Parcel {
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

impl Simulation {
    /// Puts a message on its way, if it gets on it.
    pub(super) fn post(&mut self, from: &str, to: &str, make: impl Fn() -> Parcel, loss: u64) {
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
    pub(super) fn apart(&self, from: &str, to: &str) -> bool {
        if self.station_dead && to == CONDUCTOR {
            return true;
        }
        let other = match (from, to) {
            ("", name) | (name, CONDUCTOR) => name,
            _ => return false,
        };
        self.nodes.get(other).is_some_and(|node| node.finds_station > self.now)
    }

    pub(super) fn put(&mut self, at: u64, to: &str, parcel: Parcel) {
        self.posted += 1;
        self.parcels.insert((at, self.posted), (to.to_owned(), parcel));
    }

    pub(super) fn deliver(&mut self, to: &str, parcel: Parcel) {
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
}
