//! Frames are executed, kept and told.

use super::{Effect, KEPT_FRAMES, Member, Own, WHOLE_OCTETS};
use crate::runtime::digest::{content, pdu_hash};
use crate::runtime::federate::FrameOut;
use crate::runtime::messages::{Frame, FrameEnds, Report};

impl Member {
    pub(super) fn advance(&mut self, effects: &mut Vec<Effect>) {
        if self.config.is_none() || self.closed || self.outcast {
            return;
        }
        // Frame 0 of every producer must have been seen before frame 1 is due.
        let Some(complete) = self.complete() else { return };
        let upto = self.granted.min(complete);
        let before = self.executed;
        while self.executed < upto {
            let frame = self.executed + 1;
            let out = self.execute(frame);
            self.emit(frame, out, effects);
        }
        let reported = self.reported.unwrap_or(0);
        // Report at the horizon and often enough before it that the conductor can move it.
        let stands = self.executed == self.granted
            || self.federate.in_loop()
            || self.producers.values().any(|p| p.awaited);
        if self.executed > before && (stands || self.executed - reported >= self.window) {
            self.report_ends(effects);
        }
    }

    pub(super) fn execute(&mut self, frame: Frame) -> FrameOut {
        self.executed = frame;
        let mut out = FrameOut::default();
        if frame.is_multiple_of(self.federate.period()) {
            let inputs = self.inputs_up_to(frame);
            let started = (self.microseconds)();
            self.pulse.begin(frame, started);
            self.federate.step(frame, &inputs, &mut out);
            self.pulse.end();
            let took = (self.microseconds)().saturating_sub(started);
            self.exec.steps += 1;
            self.exec.sum_us += took;
            self.exec.max_us = self.exec.max_us.max(took);
        }
        out
    }

    /// Keeps what a frame consists of.
    pub(super) fn keep(&mut self, frame: Frame, out: &mut FrameOut) {
        let mut pdus: Vec<_> = out.pdus.iter().map(|o| (pdu_hash(o), o.clone())).collect();
        pdus.sort_by_key(|(hash, _)| *hash);
        let now = out.notices.drain(..).map(|notice| (frame, notice));
        let later = out.later.drain(..).map(|(effect, notice)| (effect.max(frame), notice));
        let notices: Vec<_> = now.chain(later).collect();
        out.pdus.iter().for_each(|octets| self.made.add(frame, octets));
        self.counters.sent += out.pdus.len() as u64;
        self.content = self.content.wrapping_add(content(
            frame,
            pdus.iter().map(|(hash, _)| *hash),
            notices.iter().map(|(effect, notice)| (*effect, notice)),
        ));
        self.own.push_back(Own { frame, pdus, notices, made: self.content });
        while self.own.len() > KEPT_FRAMES {
            self.own.pop_front();
        }
    }

    pub(super) fn emit(&mut self, frame: Frame, mut out: FrameOut, effects: &mut Vec<Effect>) {
        self.keep(frame, &mut out);
        self.unreported.last = frame;
        if let Some(own) = self.own.back() {
            name_frame(own, &mut self.unreported);
        }
        if !out.pdus.is_empty() {
            effects.push(Effect::Send(out.pdus));
        }
        if !out.aside.is_empty() {
            effects.push(Effect::Send(out.aside));
        }
        effects.extend(out.publish.into_iter().map(Effect::Publish));
    }

    pub(super) fn report_ends(&mut self, effects: &mut Vec<Effect>) {
        let next = self.executed + 1;
        let run = self.unreported.run;
        let empty = FrameEnds { run, first: next, last: next, ..FrameEnds::default() };
        let mut ends = std::mem::replace(&mut self.unreported, empty);
        self.reported = Some(ends.last);
        let state = self.federate.state();
        ends.state = Some(state);
        self.states.push_back((ends.last, state));
        while self.states.len() > KEPT_FRAMES {
            self.states.pop_front();
        }
        if self.federate.live() {
            self.tell_whole(ends.first, effects);
        }
        for part in ends.parts() {
            self.tell(Report::Ends(part), effects);
        }
    }

    /// The PDUs of frames from `first` on, for the log.
    fn tell_whole(&mut self, first: Frame, effects: &mut Vec<Effect>) {
        let run = self.run();
        let frames = self.own.iter().filter(|own| own.frame >= first);
        let all = frames.flat_map(|own| own.pdus.iter().map(|(_, octets)| (own.frame, octets)));
        let (mut parts, mut octets) = (Vec::<Vec<(Frame, Vec<u8>)>>::new(), usize::MAX);
        for (frame, pdu) in all {
            if octets.saturating_add(pdu.len()) > WHOLE_OCTETS {
                parts.push(Vec::new());
                octets = 0;
            }
            octets += pdu.len();
            if let Some(part) = parts.last_mut() {
                part.push((frame, pdu.to_vec()));
            }
        }
        for pdus in parts {
            self.tell(Report::Whole { run, pdus }, effects);
        }
    }
}

/// Adds a frame to a report.
pub(super) fn name_frame(own: &Own, ends: &mut FrameEnds) {
    if !own.pdus.is_empty() {
        ends.pdus.push((own.frame, own.pdus.iter().map(|(hash, _)| *hash).collect()));
    }
    ends.notices.extend(own.notices.iter().map(|(effect, n)| (own.frame, *effect, n.clone())));
}
