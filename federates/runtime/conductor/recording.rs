//! What the log of a run keeps, and how far a member that returns finds its inputs there.
//!
//! A consumer that returns makes the run again from frame 0. PDUs of producers that can be made again are made in its
//! process; notices, and the PDUs of those that cannot, are read in the log. So the log has a frame of outsiders
//! before anybody may use it, and nobody returns beyond the frame up to which it has what he reads.

use super::{Conductor, Effect};
use crate::runtime::messages::{Frame, FrameEnds, Kind, LogRecord, Order};

/// Frames without anything to keep that one record may stand for.
const EMPTY_FRAMES: Frame = 200;

/// Octets of the PDUs of one record, about.
const RECORD_OCTETS: usize = 128 << 10;

/// Octets of PDUs whose frames have not ended, at most.
const WAITING_OCTETS: usize = 8 << 20;

impl Conductor {
    /// PDUs of frames that are about to end, of a producer whose frames nobody can make again.
    pub(super) fn take_whole(&mut self, from: &str, pdus: Vec<(Frame, Vec<u8>)>) {
        if !self.config.optional.iter().any(|name| name == from) {
            return;
        }
        let Some(member) = self.members.get_mut(from).filter(|m| m.alive) else { return };
        let octets = |pdus: &[(Frame, Vec<u8>)]| pdus.iter().map(|(_, o)| o.len()).sum::<usize>();
        if octets(&member.log.whole) + octets(&pdus) <= WAITING_OCTETS {
            member.log.whole.extend(pdus);
        }
    }

    /// Keeps what frames of a producer consist of, each once.
    pub(super) fn record(&mut self, from: &str, ends: FrameEnds, effects: &mut Vec<Effect>) {
        let live = self.config.optional.iter().any(|name| name == from);
        if !live && !self.config.producers.iter().any(|name| name == from) {
            return;
        }
        let Some(member) = self.members.get_mut(from) else { return };
        let (log, run, last) = (&mut member.log, ends.run, ends.last);
        // One that returned tells frames again: they are the same.
        let first = log.recorded.map_or(0, |recorded| recorded + 1);
        let mut whole = std::mem::take(&mut log.whole);
        whole.retain(|(frame, _)| (first..=last).contains(frame));
        let mut notices = ends.notices;
        notices.retain(|(made, ..)| *made >= first);
        let empty = whole.is_empty() && notices.is_empty();
        if last >= first && !(empty && last - first < EMPTY_FRAMES) {
            log.recorded = Some(last);
            let name = from.to_owned();
            let mut octets = 0;
            for pdus in whole.chunk_by(|_, (_, next)| {
                octets += next.len();
                let fits = octets <= RECORD_OCTETS;
                octets *= usize::from(fits);
                fits
            }) {
                let record = LogRecord::Whole { name: name.clone(), pdus: pdus.to_vec() };
                effects.push(Effect::Record(run, record));
            }
            let kept = FrameEnds { run, first, last, notices, ..FrameEnds::default() };
            for ends in kept.parts() {
                effects.push(Effect::Record(run, LogRecord::Ends { name: name.clone(), ends }));
            }
        }
        if live {
            self.say(Order::Logged { run, name: from.to_owned(), upto: last }, effects);
        }
    }

    /// Up to which frame the log has `producer`, and how far whoever reads it there may be ahead of it; none where a
    /// member of this kind does not read it there.
    fn logged(&self, reader: (&str, Kind), producer: &str) -> Option<(Option<Frame>, Frame)> {
        let closes = self.config.closes.as_ref().filter(|(by, _)| by == producer);
        let live = self.config.optional.iter().any(|name| name == producer);
        let fuser = self.config.front_ends.get(producer);
        let reads = match reader.1 {
            _ if fuser.is_some() => fuser.is_some_and(|fuser| fuser == reader.0),
            // What closes a loop is read by the generators that are made again with it.
            Kind::Smdfm | Kind::TrafficGenerator => live || closes.is_some(),
            _ => true,
        };
        let ahead = closes.map_or(0, |(_, ahead)| *ahead);
        reads.then(|| (self.members.get(producer).and_then(|m| m.executed), ahead))
    }

    /// Frames of `producer` that a consumer of this kind can make or read again.
    pub(super) fn made_again(
        &self,
        reader: (&str, Kind),
        producer: &str,
        made: Option<Frame>,
    ) -> Option<Frame> {
        if let Some((known, _)) = self.logged(reader, producer) {
            return made.min(known);
        }
        let generates =
            self.members.get(producer).is_some_and(|m| m.hello.kind == Kind::TrafficGenerator);
        let closer = self.config.closes.as_ref().filter(|_| generates);
        let known = closer.map(|(by, ahead)| {
            let known = self.members.get(by).and_then(|m| m.executed);
            Some(known.map_or(0, |known| known + 1) + ahead - 1)
        });
        known.map_or(made, |known| made.min(known))
    }

    /// The frame at which a lost member returns, no later than its cut: what it made up to there is known here, and
    /// its inputs are in the log. What it makes from there on is the same again.
    pub(super) fn returns_at(&self, name: &str, cut: Option<Frame>) -> Option<Frame> {
        let Some(member) = self.members.get(name) else { return cut };
        let mut upto = cut.min(member.executed);
        if !member.consumes {
            return upto;
        }
        for producer in self.producers().iter().filter(|p| *p != name) {
            let Some((known, ahead)) = self.logged((name, member.hello.kind), producer) else {
                continue;
            };
            let over = self.views.is_absent(producer)
                && self.views.cut(producer).is_some_and(|cut| known >= cut);
            if !over {
                // Frame 0 has no inputs of those that it may be ahead of.
                let bound = known.map(|known| known + ahead);
                upto = upto.min(bound.or(ahead.checked_sub(1)));
            }
        }
        let states = member.log.states.iter().rev().map(|(frame, _)| Some(*frame));
        states.into_iter().find(|frame| *frame <= upto).flatten()
    }
}
