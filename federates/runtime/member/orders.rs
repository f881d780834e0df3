//! What the conductor orders, and what a member does about it.

use super::inputs::Producer;
use super::{Effect, LinkCounters, Member};
use crate::runtime::clock::WallNs;
use crate::runtime::digest::Digest;
use crate::runtime::federate::{Aside, FrameOut};
use crate::runtime::messages::{
    FinalReport, Frame, FrameEnds, Numbered, Order, Report, RunConfig, Was,
};

impl Member {
    /// An order of the conductor.
    pub fn order(&mut self, now: WallNs, order: Numbered<Order>, effects: &mut Vec<Effect>) {
        if order.fed != self.fed || order.inc != 0 {
            return;
        }
        if order.seq == 0 {
            return self.carry_out(now, order.body, effects);
        }
        for order in self.orders.take(now, order) {
            self.carry_out(now, order, effects);
        }
    }

    fn carry_out(&mut self, now: WallNs, order: Order, effects: &mut Vec<Effect>) {
        let run = self.run();
        match order {
            Order::Muster => {
                let hears = self.heard.iter().cloned().collect();
                let consumes = self.federate.consumes();
                let present = self.outbox.loose(Report::Present { hears, consumes });
                effects.push(Effect::Report(present));
            }
            Order::Configure(config) => self.configure(config, effects),
            Order::Grant { run: of, upto } if of == run && !self.closed => {
                if self.stands.take().is_some() {
                    self.aside(Aside::GoesOn, effects);
                }
                self.granted = self.granted.max(upto);
                // Every member is ready now, so frame 0 finds all its consumers.
                if let Some(out) = self.zero.take() {
                    self.emit(0, out, effects);
                    self.report_ends(effects);
                }
                self.advance(effects);
            }
            // Frozen before the first grant: nobody has been told of anybody yet, and frame 0 is still to come.
            Order::Stand { run: of } if of == run && !self.closed && self.zero.is_none() => {
                self.stands = Some(now);
                self.stand(now, effects);
            }
            Order::Seal { run: of, view, lost } if of == run => self.seal(view, &lost, effects),
            Order::Cut { run: of, view, cuts } if of == run => {
                self.holding = Some((view, cuts));
                self.take_early(now);
                self.hold(now, effects);
            }
            Order::View { run: of, cuts, absent, .. } if of == run => {
                self.view(&cuts, &absent);
                self.advance(effects);
                if self.reported.is_some_and(|reported| self.executed > reported) {
                    self.report_ends(effects);
                }
            }
            Order::Admit { run: of, name, inc, from } if of == run => {
                if name == self.name {
                    self.report_again(from, effects);
                } else {
                    self.admit(now, &name, inc, from);
                    self.advance(effects);
                }
            }
            Order::Finish { run: of, frame } if of == run && !self.closed => {
                self.closed = true;
                let mut report =
                    FinalReport { run, name: self.name.clone(), frame, ..Default::default() };
                let c = &self.counters;
                report.values = vec![
                    ("pdus_sent".into(), c.sent as f64),
                    ("pdus_received".into(), c.received as f64),
                    ("pdus_lost".into(), c.lost as f64),
                    ("pdus_repaired".into(), c.repaired as f64),
                    ("outsiders".into(), c.outsiders as f64),
                ];
                report.digests.push(("pdus".into(), self.made.0));
                self.federate.finish(&mut report);
                self.tell(Report::Final(Box::new(report)), effects);
                self.stands = None;
                self.aside(Aside::Over, effects);
            }
            Order::Logged { run: of, name, upto } if of == run => {
                if let Some(producer) = self.producers.get_mut(&name) {
                    producer.logged = producer.logged.max(Some(upto));
                    self.advance(effects);
                }
            }
            Order::Host { run: of, name, by } if of == run && by == self.name => {
                let generators = self.config.as_ref().map_or(1, |c| c.generators);
                effects.push(Effect::Host { name, generators });
            }
            Order::Dismiss { name, inc, reason } if name == self.name && inc == self.inc => {
                effects.push(Effect::Dismissed(reason));
            }
            Order::Yield { name, inc, to } if name == self.name && inc == self.inc => {
                effects.push(Effect::Yielded(to));
            }
            Order::Exit { code } => effects.push(Effect::Exit(code)),
            // Orders of another run: the federation went on without them.
            _ => {}
        }
    }

    /// Accepts nothing more of the lost, and says how far it holds their frames.
    fn seal(&mut self, view: u32, lost: &[(String, u64)], effects: &mut Vec<Effect>) {
        self.holding = None;
        let mut holds = Vec::new();
        for (name, inc) in lost {
            self.outbox.forget(name);
            if *name == self.name && *inc == self.inc {
                return self.cast_out(effects);
            }
            if !self.federate.consumes() {
                continue;
            }
            // No further than granted: what nobody may use yet, nobody has used.
            let complete = self.complete_of(name).map(|c| c.min(self.granted));
            let complete = self.in_log(name, complete);
            if let Some(producer) = self.producers.get_mut(name) {
                producer.bound = Some(complete);
                holds.push((name.clone(), complete));
            }
        }
        let run = self.run();
        self.tell(Report::Sealed { run, view, holds }, effects);
    }

    /// The others go on without this incarnation: it stops, and joins again.
    pub(super) fn cast_out(&mut self, effects: &mut Vec<Effect>) {
        if !self.outcast {
            self.outcast = true;
            let run = self.run();
            effects.push(Effect::Rejoin(Was { fed: self.fed, inc: self.inc, run }));
        }
    }

    /// Says that every frame up to the cuts is here, once it is; asks others for what the lost no longer give.
    pub(super) fn hold(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let Some((view, cuts)) = self.holding.take() else { return };
        let mut lacks = false;
        for (name, cut) in &cuts {
            let consumed = self.federate.consumes() && self.producers.contains_key(name);
            if consumed && self.complete_of(name) < *cut {
                lacks = true;
                if self.producers.get(name).is_some_and(|p| p.ended < *cut)
                    && let Some(inbox) = self.peers.get_mut(name)
                {
                    inbox.told(now, inbox.seen() + 1);
                }
            }
        }
        if lacks {
            self.holding = Some((view, cuts));
        } else {
            let run = self.run();
            self.tell(Report::Held { run, view }, effects);
        }
    }

    /// Frames up to the cuts count for everybody, later ones of the lost for nobody.
    fn view(&mut self, cuts: &[(String, Option<Frame>)], absent: &[String]) {
        self.holding = None;
        if !self.federate.consumes() {
            return;
        }
        let stepped = self.executed - self.executed % self.federate.period();
        let used = Some(stepped).filter(|frame| *frame > 0);
        for (name, cut) in cuts {
            let Some(producer) = self.producers.get_mut(name) else { continue };
            // One that is lost itself may have used more than the others hold: a successor makes the same again.
            let used = used.filter(|_| !absent.contains(name)).min(producer.ended);
            let kept = (*cut).max(used);
            producer.ended = producer.ended.min(kept);
            self.contacts.remove(name);
            producer.bound = None;
            producer.inc = None;
            producer.absent = absent.contains(name);
            producer.awaited = !producer.absent;
            let counts = |frame: Frame| Some(frame) <= kept;
            self.ready.retain(|(frame, of), _| of != name || counts(*frame));
            for ((_, of), notices) in &mut self.notices {
                if of == name {
                    notices.retain(|(made, _)| counts(*made));
                }
            }
            self.incomplete.retain(|(frame, of), _| of != name || counts(*frame));
        }
    }

    pub(super) fn configure(&mut self, config: RunConfig, effects: &mut Vec<Effect>) {
        match self.begin(config) {
            Ok(out) => {
                self.zero = Some(out);
                let run = self.run();
                self.tell(Report::Ready { run, at: None }, effects);
            }
            Err(reason) => self.tell(Report::Failed { reason }, effects),
        }
    }

    /// Back to frame 0 of a run.
    pub(super) fn begin(&mut self, config: RunConfig) -> Result<FrameOut, String> {
        let mut out = FrameOut::default();
        let inc = |name: &String| config.incs.iter().find(|(n, _)| n == name).map(|(_, inc)| *inc);
        let live = |name: &String| config.live.contains(name);
        let producer =
            |name: &String| Producer { inc: inc(name), live: live(name), ..Producer::default() };
        // One that makes notices for other consumers does not wait for itself.
        let reads = |n: &&String| **n != self.name && self.federate.ahead_of(n).is_some();
        let others = config.producers.iter().filter(reads);
        self.producers = others.map(|n| (n.clone(), producer(n))).collect();
        self.granted = 0;
        self.executed = 0;
        self.reported = None;
        self.closed = false;
        self.stands = None;
        self.made = Digest::default();
        self.content = 0;
        self.early.clear();
        self.contacts.clear();
        self.incomplete.clear();
        self.hearing.configure(config.run, self.producers.keys());
        self.ready.clear();
        self.notices.clear();
        self.eaten.clear();
        self.holding = None;
        self.own.clear();
        self.states.clear();
        self.zero = None;
        self.counters = LinkCounters::default();
        if self.config.is_some() {
            self.waiting.clear();
            self.waiting_order.clear();
        }
        self.unused = 0;
        self.unreported = FrameEnds { run: config.run, ..FrameEnds::default() };
        let configured = self.federate.configure(&config, &mut out);
        self.config = Some(config);
        configured.map(|()| out)
    }
}
