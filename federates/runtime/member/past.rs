//! What a member that returns reads in the log of the run, and the producers that it makes again.

use crate::runtime::codec::decode;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Octets};
use crate::runtime::messages::{Frame, Joined, LogPage, LogRecord, Notice, ProducerAt, RunConfig};
use std::collections::BTreeMap;

/// Reads a page of the log of the run.
pub type Pages<'a> = dyn FnMut(u64) -> Result<LogPage, String> + 'a;

/// What a frame of a producer consists of: of what is in the log.
pub(super) struct Logged {
    pub(super) frame: Frame,
    pub(super) pdus: Vec<Octets>,
    /// Each with the frame of its effect.
    pub(super) notices: Vec<(Frame, Notice)>,
}

/// One producer's part of the log, as far as it is read and not used.
#[derive(Default)]
struct Stream {
    joined: Joined,
    ended: Option<Frame>,
    pdus: BTreeMap<Frame, Vec<Octets>>,
    notices: BTreeMap<Frame, Vec<(Frame, Notice)>>,
}

/// The log, read forward as far as it is needed.
pub(super) struct Past<'a, 'b> {
    pages: &'a mut Pages<'b>,
    next: Option<u64>,
    streams: BTreeMap<String, Stream>,
}

impl<'a, 'b> Past<'a, 'b> {
    /// Of these producers.
    pub(super) fn new(pages: &'a mut Pages<'b>, of: impl Iterator<Item = String>) -> Self {
        let streams = of.map(|name| (name, Stream::default())).collect();
        Self { pages, next: Some(0), streams }
    }

    /// Frames of a producer up to `upto` that have anything and were not read before.
    pub(super) fn read(&mut self, name: &str, upto: Frame) -> Result<Vec<Logged>, String> {
        while self.streams.get(name).is_some_and(|s| s.ended < Some(upto))
            && let Some(page) = self.next
        {
            self.read_page(page)?;
        }
        let Some(stream) = self.streams.get_mut(name) else { return Ok(Vec::new()) };
        let later = stream.pdus.split_off(&(upto + 1));
        let mut pdus = std::mem::replace(&mut stream.pdus, later);
        let later = stream.notices.split_off(&(upto + 1));
        let mut notices = std::mem::replace(&mut stream.notices, later);
        let mut frames: Vec<Frame> = pdus.keys().chain(notices.keys()).copied().collect();
        frames.sort_unstable();
        frames.dedup();
        let logged = |frame| Logged {
            frame,
            pdus: pdus.remove(&frame).unwrap_or_default(),
            notices: notices.remove(&frame).unwrap_or_default(),
        };
        Ok(frames.into_iter().map(logged).collect())
    }

    fn read_page(&mut self, page: u64) -> Result<(), String> {
        let told = (self.pages)(page)?;
        if !told.lost.is_empty() {
            return Err(told.lost);
        }
        self.next = told.more.then_some(page + 1);
        for record in &told.records {
            let record: LogRecord = decode(record).map_err(|e| e.to_string())?;
            match record {
                LogRecord::Whole { name, pdus } => {
                    let Some(stream) = self.streams.get_mut(&name) else { continue };
                    for (frame, octets) in pdus {
                        stream.pdus.entry(frame).or_default().push(octets.into());
                    }
                }
                LogRecord::Ends { name, ends } => {
                    let Some(stream) = self.streams.get_mut(&name) else { continue };
                    let Some((_, ends)) = stream.joined.take(0, ends) else { continue };
                    stream.ended = Some(ends.last);
                    for (made, effect, notice) in ends.notices {
                        stream.notices.entry(made).or_default().push((effect, notice));
                    }
                }
            }
        }
        Ok(())
    }
}

/// A producer that is made again, with what it will read.
struct Maker {
    federate: Box<dyn Federate>,
    made: Option<Frame>,
    /// Notices by the frame of their effect and their producer.
    notices: BTreeMap<(Frame, String), Vec<Notice>>,
}

/// The producers that are made again in this process.
#[derive(Default)]
pub(super) struct Making(BTreeMap<String, Maker>);

impl Making {
    /// Of those among `makers` that are needed.
    pub(super) fn new(
        mut makers: BTreeMap<String, Box<dyn Federate>>,
        needed: &[ProducerAt],
    ) -> Result<Self, String> {
        let mut making = BTreeMap::new();
        for at in needed.iter().filter(|at| at.made.is_some() && !at.empty) {
            let federate = makers.remove(&at.name);
            let federate =
                federate.ok_or_else(|| format!("frames of {} cannot be made again", at.name))?;
            let maker = Maker { federate, made: at.made, notices: BTreeMap::new() };
            making.insert(at.name.clone(), maker);
        }
        Ok(Self(making))
    }

    /// Whether one of them reads a producer.
    pub(super) fn reads(&self, producer: &str) -> bool {
        self.0.values().any(|m| m.reads(producer))
    }

    /// What a producer said, for those that read it.
    pub(super) fn hear(&mut self, producer: &str, logged: &Logged) {
        for maker in self.0.values_mut().filter(|m| m.reads(producer)) {
            for (effect, notice) in &logged.notices {
                let key = ((*effect).max(logged.frame), producer.to_owned());
                maker.notices.entry(key).or_default().push(notice.clone());
            }
        }
    }

    /// What they make in a frame.
    pub(super) fn make(
        &mut self,
        config: &RunConfig,
        frame: Frame,
    ) -> Result<Vec<(String, FrameOut)>, String> {
        let mut all = Vec::new();
        for (name, maker) in self.0.iter_mut().filter(|(_, m)| Some(frame) <= m.made) {
            let mut out = FrameOut::default();
            if frame == 0 {
                maker.federate.configure(config, &mut out)?;
            } else if frame.is_multiple_of(maker.federate.period()) {
                let inputs = maker.inputs(frame);
                maker.federate.step(frame, &inputs, &mut out);
            }
            all.push((name.clone(), out));
        }
        Ok(all)
    }
}

impl Maker {
    fn reads(&self, producer: &str) -> bool {
        self.federate.consumes() && self.federate.ahead_of(producer).is_some()
    }

    fn inputs(&mut self, frame: Frame) -> FrameInputs {
        let later = self.notices.split_off(&(frame + 1, String::new()));
        let mut inputs = FrameInputs::default();
        for ((effect, _), notices) in std::mem::replace(&mut self.notices, later) {
            inputs.notices.extend(notices.into_iter().map(|notice| (effect, notice)));
        }
        inputs
    }
}
