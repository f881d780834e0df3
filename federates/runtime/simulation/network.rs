//! The simulated network: messages and PDUs on their way, late, lost, twice or out of order.

use super::{LEASE_NS, PLACES, Simulation};
use crate::runtime::federate::Octets;
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{
    Beat, FetchOf, Fetched, Numbered, Order, Repair, RepairOf, Repaired, Report,
};
use crate::runtime::succession::{Candidacy, Steps, StepsAsk, Voted};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

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
    /// A beat of the conductor that its voice has heard before.
    LateBeat(Beat),
    Pdus(Vec<Octets>),
    Repair(String, Repair),
    /// By whom.
    Repaired(String, Repaired),
    /// By way of the station there: who asks, and what.
    RepairOf(String, RepairOf),
    RepairBy(usize, String, Repair),
    RepairedFor(String, Repaired),
    Fetch(String, FetchOf),
    Orders(Fetched<Order>),
    /// By whom.
    Reports(String, Fetched<Report>),
    Alive(String, u64, bool),
    /// Of which process, which one of it; no answer comes.
    StepsAsk(u64, u64, StepsAsk),
    Steps(u64, u64, Option<Steps>),
    /// Where the asker is.
    Candidacy(&'static str, Candidacy),
    Voted(String, Voted),
    Leads(u32),
    /// The connection to a station is there, or gone.
    Station(bool),
}

impl Parcel {
    /// What kind it is, and which one of it.
    fn mark(&self) -> u64 {
        match self {
            Self::Order(order) => 1 + (order.seq << 4),
            Self::Report(_, report) => 2 + (report.seq << 4),
            Self::Beat(_, beat) | Self::LateBeat(beat) => 3 + (beat.last_seq << 4),
            Self::Pdus(_) => 4,
            Self::Repair(..) | Self::RepairOf(..) | Self::RepairBy(..) => 5,
            Self::Repaired(..) | Self::RepairedFor(..) => 6,
            Self::Fetch(_, ask) => 7 + (ask.fetch.from << 4),
            Self::Orders(_) => 8,
            Self::Reports(..) => 9,
            Self::Alive(_, inc, _) => 10 + (inc << 4),
            Self::StepsAsk(..) => 11,
            Self::Steps(..) => 12,
            Self::Candidacy(..) | Self::Voted(..) => 13,
            Self::Leads(_) => 14,
            Self::Station(_) => 15,
        }
    }
}

impl Simulation {
    /// Puts a message on its way, if it gets on it.
    pub(super) fn post(&mut self, from: &str, to: &str, make: impl Fn() -> Parcel, loss: u64) {
        // Who follows a station does not hear what members tell it.
        let place = |name: &str| PLACES.iter().position(|place| *place == name);
        let follows = place(to).is_some_and(|at| self.hosts[at].lead().is_none());
        if self.silenced(from, to) || (follows && place(from).is_none()) {
            if self.in_burst(from, to) {
                self.note("messages lost in a burst");
            }
            return;
        }
        if self.intruder_until > self.now {
            self.intrude(to, make());
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

    /// Whether nothing gets on its way from one to the other.
    pub(super) fn silenced(&self, from: &str, to: &str) -> bool {
        let muted = match PLACES.iter().position(|place| *place == from) {
            Some(at) => self.hosts[at].mute_until > self.now,
            None => self.nodes.get(from).is_some_and(|n| n.dead || n.mute_until > self.now),
        };
        muted || self.apart(from, to) || self.in_burst(from, to)
    }

    fn in_burst(&self, from: &str, to: &str) -> bool {
        let on = |(a, b, until): &(String, String, u64)| *until > self.now && a == from && b == to;
        self.bursts.iter().any(on)
    }

    /// Whether a partition is between the two.
    pub(super) fn parted(&self, one: &str, two: &str) -> bool {
        let between = |(part, until): &(BTreeSet<String>, u64)| {
            *until > self.now && part.contains(one) != part.contains(two)
        };
        self.parts.iter().any(between)
    }

    /// Whether one of the two is a station that is gone, or to which the other has no connection yet, or a partition is between them.
    pub(super) fn apart(&self, from: &str, to: &str) -> bool {
        let place = |name: &str| PLACES.iter().position(|place| *place == name);
        let found = |name: &str, at: usize| {
            self.nodes.get(name).is_none_or(|node| node.finds_station[at] <= self.now)
        };
        let connected = match (place(from), place(to)) {
            (Some(_), Some(_)) => self.stations_meet <= self.now,
            (Some(at), None) => found(to, at),
            (None, Some(at)) => !self.hosts[at].dead && found(from, at),
            (None, None) => true,
        };
        !connected || self.parted(from, to)
    }

    pub(super) fn put(&mut self, at: u64, to: &str, parcel: Parcel) {
        self.posted += 1;
        self.parcels.insert((at, self.posted), (to.to_owned(), parcel));
    }

    pub(super) fn deliver(&mut self, to: &str, mut parcel: Parcel) {
        let now = self.now;
        let heard = to.bytes().fold(now, |sum, b| sum.rotate_left(5) ^ u64::from(b));
        self.trace = (self.trace ^ heard ^ parcel.mark() << 40).wrapping_mul(0x0100_0000_01b3);
        if let Some(at) = PLACES.iter().position(|place| *place == to) {
            return self.deliver_to_station(at, parcel);
        }
        let Some(node) = self.nodes.get_mut(to).filter(|n| !n.dead && n.deaf_until <= now) else {
            return;
        };
        if node.paused_until <= now {
            // Voices are given beside the loop, which may be at a heavy frame.
            match parcel {
                Parcel::Beat(from, beat) if from == CONDUCTOR => {
                    node.voter.beat(now);
                    parcel = Parcel::LateBeat(beat);
                }
                Parcel::Candidacy(asker, question) => {
                    if let Some(voted) = node.voter.asked(now, &question) {
                        self.reply(to, asker, Parcel::Voted(to.to_owned(), voted));
                    }
                    return;
                }
                other => parcel = other,
            }
        }
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
            Parcel::LateBeat(beat) => member.hear_beat(now, CONDUCTOR, &beat),
            Parcel::Pdus(pdus) => member.pdus(now, pdus, &mut effects),
            Parcel::Repaired(by, repaired) => member.repaired(now, &by, repaired, &mut effects),
            Parcel::Orders(fetched) => member.fetched_orders(now, fetched, &mut effects),
            Parcel::Reports(by, fetched) => member.fetched(now, &by, fetched, &mut effects),
            Parcel::Repair(from, repair) => {
                answer = Some((from, Parcel::Repaired(to.to_owned(), member.repair(&repair))));
            }
            Parcel::RepairBy(at, from, repair) => {
                let repaired = Parcel::RepairedFor(from, member.repair(&repair));
                answer = Some((PLACES[at].to_owned(), repaired));
            }
            Parcel::Fetch(from, ask) => {
                answer = Some((from, Parcel::Reports(to.to_owned(), member.fetch(&ask))));
            }
            _ => {}
        }
        let executed = member.executed();
        let granted = self.hosts.iter().filter_map(|host| Some(host.lead()?.conductor().granted()));
        let granted = granted.max().unwrap_or(0);
        if executed > granted && self.conductor().phase() == Phase::Running {
            self.broken.push(format!("{to} executed frame {executed}, which was not granted"));
        }
        self.act(to, effects);
        if let Some((from, parcel)) = answer {
            self.reply(to, &from, parcel);
        }
    }

    /// An answer, which is lost as any message is.
    pub(super) fn reply(&mut self, from: &str, to: &str, parcel: Parcel) {
        if !self.silenced(from, to) && !self.chance(self.network.bus_loss) {
            let at = self.now + 10_000 + self.draw(self.network.delay_ns.max(1));
            self.put(at, to, parcel);
        }
    }
}
