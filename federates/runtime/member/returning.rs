//! Return of a lost member: by keeping its state, or by making the run again from frame 0, with the log of the run.

use super::frames::name_frame;
use super::past::{Logged, Making, Pages, Past};
use super::{Effect, Member};
use crate::runtime::federate::{Federate, FrameOut};
use crate::runtime::messages::{
    Accepted, Frame, FrameEnds, ProducerAt, Report, Return, RunConfig, Standing,
};
use crate::runtime::stream::{Inbox, Outbox};
use std::collections::BTreeMap;

/// Makes the producers of the federation inside this process, by name, so that a consumer can make its
/// inputs again.
pub type Remake = Box<dyn Fn(&RunConfig) -> Result<Makers, String> + Send>;

/// Producers by name.
pub type Makers = BTreeMap<String, Box<dyn Federate>>;

impl Member {
    /// Joins again, in a run that is under way, and says how it stands at the frame that it was told to reach.
    pub fn enter(
        &mut self,
        accepted: &Accepted,
        remake: Option<&Remake>,
        pages: &mut Pages<'_>,
        effects: &mut Vec<Effect>,
    ) {
        let Accepted { fed, inc, orders, .. } = *accepted;
        (self.fed, self.inc) = (fed, inc);
        self.orders = Inbox::new(fed, 0, orders + 1);
        self.outbox = Outbox::new(fed, inc);
        self.outcast = false;
        self.holding = None;
        self.early.clear();
        let Some(to) = &accepted.enter else { return };
        if !(to.keep && self.can_keep(to))
            && let Err(reason) = self.make_again(to, remake, pages)
        {
            let text = format!("the run cannot be made again here: {reason}");
            return self.tell(Report::Failed { reason: text }, effects);
        }
        self.producers_at(&to.producers);
        let at = Some(self.standing(to.upto));
        let run = self.run();
        self.tell(Report::Ready { run, at }, effects);
    }

    /// Whether this member's state is one that the run can go on from.
    fn can_keep(&self, to: &Return) -> bool {
        let same_run = self.config.as_ref().is_some_and(|c| c.run == to.config.run) && !self.closed;
        // Frames that it neither has nor can be told are made again, and so are those that it should not have used.
        let behind = |p: &ProducerAt| {
            let settled = p.stream.is_some() || p.absent || Some(self.executed) <= p.made;
            settled && self.complete_of(&p.name) >= p.made
        };
        let read = |p: &&ProducerAt| self.federate.ahead_of(&p.name).is_some();
        let reaches = match to.upto {
            None => self.zero.is_some() || self.own.front().is_some_and(|o| o.frame == 0),
            Some(upto) => upto <= self.executed && self.zero.is_none(),
        };
        let standing = self.standing(to.upto);
        let known = to.upto.is_none() || self.own.iter().any(|o| Some(o.frame) == to.upto);
        let state = !self.federate.consumes() || standing.state.is_some();
        same_run && reaches && known && state && to.producers.iter().filter(read).all(behind)
    }

    fn standing(&self, frame: Option<Frame>) -> Standing {
        let made = self.own.iter().find(|o| Some(o.frame) == frame).map_or(0, |o| o.made);
        let state = self.states.iter().find(|(f, _)| Some(*f) == frame).map(|(_, state)| *state);
        let state = if frame.is_none() { Some(0) } else { state };
        Standing { frame, made, state }
    }

    fn producers_at(&mut self, producers: &[ProducerAt]) {
        for at in producers {
            let Some(producer) = self.producers.get_mut(&at.name) else { continue };
            if at.stream.is_none() {
                producer.ended = producer.ended.min(at.made);
            }
            producer.inc = at.stream.map(|(inc, _)| inc);
            producer.bound = None;
            producer.absent = at.absent;
            producer.logged = at.logged;
            producer.awaited = at.stream.is_none() && !at.absent;
            match at.stream {
                Some((inc, next)) => {
                    self.peers.insert(at.name.clone(), Inbox::new(self.fed, inc, next));
                }
                // A successor is heard from its first word on: if the answer was lost and asked for again, it is older
                // than what was heard meanwhile, and thrown away.
                None => drop(self.peers.remove(&at.name)),
            }
        }
    }

    /// Makes the run again from frame 0 to the frame that is to be reached; nothing is sent.
    fn make_again(
        &mut self,
        to: &Return,
        remake: Option<&Remake>,
        pages: &mut Pages<'_>,
    ) -> Result<(), String> {
        let config = &to.config;
        let own = |p: &&ProducerAt| self.federate.ahead_of(&p.name).is_some();
        let read: Vec<ProducerAt> = to.producers.iter().filter(own).cloned().collect();
        // PDUs are made again, where they can be; all else that was said is in the log.
        let reads_pdus = self.federate.reads_pdus();
        let is_made = |p: &&ProducerAt| {
            reads_pdus && !config.live.contains(&p.name) && !self.federate.logs(&p.name)
        };
        let needed: Vec<ProducerAt> = read.iter().filter(is_made).cloned().collect();
        let mut makers = Makers::new();
        if needed.iter().any(|p| p.made.is_some() && !p.empty) {
            let remake = remake.ok_or("nothing here can make the inputs again")?;
            makers = remake(config)?;
        }
        let mut making = Making::new(makers, &needed)?;
        let is_read = |p: &&ProducerAt| own(p) && !is_made(p) || making.reads(&p.name);
        let logged: Vec<ProducerAt> = to.producers.iter().filter(is_read).cloned().collect();
        let mut past = Past::new(pages, logged.iter().map(|p| p.name.clone()));
        let out = self.begin(config.clone())?;
        self.make_frame(config, &logged, &mut past, &mut making, 0)?;
        let upto = to.upto.unwrap_or(0);
        if to.upto.is_some() {
            self.keep(0, &mut { out });
        } else {
            self.zero = Some(out);
        }
        for frame in 1..=upto {
            self.make_frame(config, &logged, &mut past, &mut making, frame)?;
            let mut out = self.execute(frame);
            self.keep(frame, &mut out);
        }
        for frame in upto + 1..=read.iter().filter_map(|p| p.made).max().unwrap_or(0) {
            self.make_frame(config, &logged, &mut past, &mut making, frame)?;
        }
        for at in &read {
            if let Some(producer) = self.producers.get_mut(&at.name) {
                producer.ended = at.made;
            }
        }
        if to.upto.is_some() {
            self.stand_at(upto);
        }
        Ok(())
    }

    /// The inputs of a frame: what the log has of it is read, by those that are made again too, who then make theirs.
    fn make_frame(
        &mut self,
        config: &RunConfig,
        logged: &[ProducerAt],
        past: &mut Past<'_, '_>,
        making: &mut Making,
        frame: Frame,
    ) -> Result<(), String> {
        for at in logged {
            // Who is made again past the consumer's own frame hears what was said until then; the consumer is told that itself.
            let said = if at.absent { at.made } else { at.made.max(at.logged) };
            let Some(upto) = said.map(|said| said.min(frame)) else { continue };
            for told in past.read(&at.name, upto)? {
                making.hear(&at.name, &told);
                if Some(told.frame) <= at.made && self.producers.contains_key(&at.name) {
                    self.take_logged(&at.name, told);
                }
            }
        }
        for (name, made) in making.make(config, frame)? {
            self.take_made(&name, frame, made);
        }
        Ok(())
    }

    /// Inputs that are in the log.
    fn take_logged(&mut self, name: &str, told: Logged) {
        let Logged { frame, pdus, notices } = told;
        if self.federate.reads_pdus() && !pdus.is_empty() {
            self.ready.entry((frame, name.to_owned())).or_default().extend(pdus);
        }
        for (effect, notice) in notices {
            let notices = self.notices.entry((effect.max(frame), name.to_owned())).or_default();
            notices.push((frame, notice));
        }
    }

    /// Inputs made in this process.
    fn take_made(&mut self, name: &str, frame: Frame, made: FrameOut) {
        if !made.pdus.is_empty() {
            self.ready.insert((frame, name.to_owned()), made.pdus);
        }
        let now = made.notices.into_iter().map(|notice| (frame, notice));
        for (effect, notice) in now.chain(made.later) {
            let notices = self.notices.entry((effect.max(frame), name.to_owned())).or_default();
            notices.push((frame, notice));
        }
    }

    fn stand_at(&mut self, upto: Frame) {
        self.reported = Some(upto);
        let run = self.run();
        let next = upto + 1;
        self.unreported = FrameEnds { run, first: next, last: next, ..FrameEnds::default() };
        self.states.push_back((upto, self.federate.state()));
    }

    /// This incarnation is admitted: it tells again what the one before made from `from` on.
    pub(super) fn report_again(&mut self, from: Frame, effects: &mut Vec<Effect>) {
        if self.zero.is_some() || self.executed < from {
            return;
        }
        let run = self.run();
        let mut ends = FrameEnds { run, first: from, last: self.executed, ..FrameEnds::default() };
        for own in self.own.iter().filter(|own| own.frame >= from) {
            name_frame(own, &mut ends);
        }
        self.unreported = ends;
        self.report_ends(effects);
    }
}
