//! Return of a lost member: by keeping its state, or by making the run again from frame 0.

use super::name_frame;
use super::{Effect, Member};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
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
            && let Err(reason) = self.make_again(to, remake)
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
    fn make_again(&mut self, to: &Return, remake: Option<&Remake>) -> Result<(), String> {
        let consumes = self.federate.consumes();
        let mut makers = Makers::new();
        let read: Vec<ProducerAt> = to
            .producers
            .iter()
            .filter(|p| self.federate.ahead_of(&p.name).is_some())
            .cloned()
            .collect();
        let needed = |p: &&ProducerAt| p.made.is_some() && !p.empty;
        if consumes && read.iter().any(|p| needed(&p)) {
            let remake = remake.ok_or("nothing here can make the inputs again")?;
            makers = remake(&to.config)?;
        }
        let out = self.begin(to.config.clone())?;
        for at in read.iter().filter(needed) {
            let maker = makers.get_mut(&at.name);
            let maker =
                maker.ok_or_else(|| format!("frames of {} cannot be made again", at.name))?;
            let mut made = FrameOut::default();
            maker.configure(&to.config, &mut made)?;
            self.take_made(&at.name, 0, made);
        }
        let last = read.iter().filter_map(|p| p.made).max();
        let Some(upto) = to.upto else {
            self.zero = Some(out);
            self.make_inputs(&read, &mut makers, last.unwrap_or(0));
            return Ok(());
        };
        self.keep(0, &mut { out });
        for frame in 1..=upto {
            self.make_frame(&read, &mut makers, frame);
            let mut out = self.execute(frame);
            self.keep(frame, &mut out);
        }
        for frame in upto + 1..=last.unwrap_or(0) {
            self.make_frame(&read, &mut makers, frame);
        }
        for at in &read {
            if let Some(producer) = self.producers.get_mut(&at.name) {
                producer.ended = at.made;
            }
        }
        self.stand_at(upto);
        Ok(())
    }

    fn make_inputs(&mut self, producers: &[ProducerAt], makers: &mut Makers, last: Frame) {
        for frame in 1..=last {
            self.make_frame(producers, makers, frame);
        }
        for at in producers {
            let producer = self.producers.entry(at.name.clone()).or_default();
            producer.ended = at.made;
        }
    }

    fn make_frame(&mut self, producers: &[ProducerAt], makers: &mut Makers, frame: Frame) {
        for at in producers.iter().filter(|at| Some(frame) <= at.made) {
            let Some(maker) = makers.get_mut(&at.name) else { continue };
            let mut made = FrameOut::default();
            maker.step(frame, &FrameInputs::default(), &mut made);
            self.take_made(&at.name, frame, made);
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
