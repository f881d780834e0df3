//! The simulated processes of members: started, joining, and what a member wants done.

use super::network::Parcel;
use super::station::Role;
use super::{DONE_WITHOUT, Event, HELLO_AGAIN_NS, LEFT_OUT, MS, Node, PLACES, Simulation};
use crate::runtime::federate::{Aside, Federate, FrameInputs, FrameOut, Octets};
use crate::runtime::member::{CONDUCTOR, Effect, Member, Remake};
use crate::runtime::messages::{
    Accepted, FinalReport, Frame, Hello, Kind, RepairOf, Report, RunConfig,
};
use crate::runtime::succession::Voter;
use std::sync::Arc;

impl Simulation {
    pub(super) fn start(&mut self, name: &str, kind: Kind) {
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
            finds_station: [0; 2],
            voter: Voter::default(),
            another: false,
        };
        self.nodes.insert(name.to_owned(), node);
    }

    pub(super) fn act(&mut self, name: &str, effects: Vec<Effect>) {
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
                    match report.body {
                        Report::Sealed { .. } => self.event(Event::Sealed),
                        Report::Held { .. } => self.event(Event::Held),
                        Report::Final(_) => self.event(Event::Final),
                        _ => {}
                    }
                    let parcel = || Parcel::Report(name.to_owned(), report.clone());
                    for to in PLACES {
                        self.post(name, to, parcel, loss);
                    }
                    for to in self.consumers().into_iter().filter(|to| to != name) {
                        self.post(name, &to, parcel, loss);
                    }
                }
                Effect::Repair { holder, of, repair } => {
                    self.note("PDUs asked for");
                    if holder == CONDUCTOR {
                        let ask = RepairOf { of, repair };
                        let parcel = || Parcel::RepairOf(name.into(), ask.clone());
                        PLACES.iter().for_each(|to| self.post(name, to, parcel, loss));
                    } else {
                        let parcel = || Parcel::Repair(name.into(), repair.clone());
                        self.post(name, &holder, parcel, loss);
                    }
                }
                Effect::Fetch { holder, ask } => {
                    self.note("messages asked for");
                    let parcel = || Parcel::Fetch(name.into(), ask.clone());
                    if holder == CONDUCTOR {
                        PLACES.iter().for_each(|to| self.post(name, to, parcel, loss));
                    } else {
                        self.post(name, &holder, parcel, loss);
                    }
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
                Effect::Dismissed(reason) => match self.nodes.get_mut(name) {
                    Some(node) if node.another => self.leaves(name, "another run was refused"),
                    Some(_) if reason.contains(DONE_WITHOUT) => self.leaves(name, LEFT_OUT),
                    _ => self.broken.push(format!("{name} was dismissed: {reason}")),
                },
                Effect::Yielded(_) => {
                    if let Some(node) = self.nodes.get_mut(name) {
                        node.dead = true;
                    }
                }
                Effect::Publish(_) | Effect::Exit(_) => {}
            }
        }
    }

    pub(super) fn ask_to_join(&mut self, name: &str) {
        let now = self.now;
        let Some(node) = self.nodes.get_mut(name) else { return };
        node.hello_at = Some(now + HELLO_AGAIN_NS);
        let Some(node) = self.nodes.get(name).filter(|node| node.mute_until <= now) else { return };
        let hello = self.hello_of(name, node);
        for at in 0..PLACES.len() {
            let leads = self.works(at) && self.hosts[at].deaf_until <= now;
            if leads && !self.apart(name, PLACES[at]) {
                self.hello(at, hello.clone());
            }
        }
    }

    /// What it asks with.
    pub(super) fn hello_of(&self, name: &str, node: &Node) -> Hello {
        let process = node.host.as_deref().unwrap_or(name);
        let pid = self.nodes.keys().position(|n| n == process).map_or(0, |at| at as u32 + 1);
        Hello {
            name: name.to_owned(),
            kind: node.kind,
            pid,
            host: "h".into(),
            version: self.config.version.clone(),
            scene_hash: self.config.scene_hash,
            instance: node.instance,
            was: node.was,
        }
    }

    /// Its process ends by itself, for the reason that is counted.
    pub(super) fn leaves(&mut self, name: &str, why: &'static str) {
        self.note(why);
        let Some(node) = self.nodes.get_mut(name) else { return };
        node.dead = true;
        let Some(inc) = node.member.as_ref().map(Member::inc) else { return };
        for place in PLACES {
            self.put(self.now + 8 * MS, place, Parcel::Alive(name.to_owned(), inc, false));
        }
    }

    /// It is to ask again soon.
    pub(super) fn hello_later(&mut self, name: &str) {
        let at = self.now + HELLO_AGAIN_NS / 5;
        if let Some(node) = self.nodes.get_mut(name) {
            node.hello_at = Some(at);
        }
    }

    /// The station there accepted it.
    pub(super) fn accepted(&mut self, at: usize, name: &str, accepted: &Accepted) {
        let make = Arc::clone(&self.make);
        let (made, producers) = (Arc::clone(&make), self.producers.clone());
        let remake: Remake =
            Box::new(move |_| Ok(producers.iter().map(|n| (n.clone(), made(n))).collect()));
        let Some(node) = self.nodes.get_mut(name) else { return };
        node.hello_at = None;
        node.was = None;
        node.voter.enrol(accepted.fed, accepted.inc, accepted.epoch);
        let mut effects = Vec::new();
        let again = node.member.is_some();
        let another = node.another;
        let made = || if another { Box::new(Another(make(name))) as _ } else { make(name) };
        let member = node.member.get_or_insert_with(|| Member::new(made(), name, accepted, || 0));
        if another && accepted.enter.is_none() {
            // It is there to return; nothing was made yet that it could differ from.
            return self.leaves(name, "another run did not begin");
        }
        if again || accepted.enter.is_some() {
            let run = accepted.enter.as_ref().map_or(0, |enter| enter.config.run);
            let Role::Leads(_, log) = &mut self.hosts[at].role else { return };
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
}

/// A federate of another build: what it makes is told apart by the digest of its state.
struct Another(Box<dyn Federate>);

impl Federate for Another {
    fn kind(&self) -> Kind {
        self.0.kind()
    }
    fn period(&self) -> Frame {
        self.0.period()
    }
    fn consumes(&self) -> bool {
        self.0.consumes()
    }
    fn reads_pdus(&self) -> bool {
        self.0.reads_pdus()
    }
    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        self.0.ahead_of(producer)
    }
    fn logs(&self, producer: &str) -> bool {
        self.0.logs(producer)
    }
    fn in_loop(&self) -> bool {
        self.0.in_loop()
    }
    fn live(&self) -> bool {
        self.0.live()
    }
    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        self.0.configure(config, out)
    }
    fn step(&mut self, k: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        self.0.step(k, inputs, out);
    }
    fn state(&self) -> u64 {
        !self.0.state()
    }
    fn finish(&mut self, report: &mut FinalReport) {
        self.0.finish(report);
    }
    fn aside(&mut self, what: Aside) -> Vec<Octets> {
        self.0.aside(what)
    }
}
