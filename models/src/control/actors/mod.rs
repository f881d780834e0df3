//! People as models: controllers at their seats, pilots who ask, read back and act, frequencies as queues.
//!
//! Pure: what is wanted in a scan comes in, clearances with the time from which they are acted upon go out. A controller
//! does one thing at a time: he takes the gravest of what is wanted of him, thinks, speaks when his frequency is free,
//! and listens to the readback. A frequency carries one transmission at a time.

pub mod message;
pub mod people;
pub mod pilot;
pub mod reacts;
pub mod seats;
pub mod sight;

use super::clearance::ClearanceKind;
use crate::draw::{DrawKey, Purpose};
use message::{Message, MessageKind, Seat};
use pilot::{Habits, answer, lognormal_s};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Somebody who waits for a clearance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Flight, by index.
    pub flight: u32,
    /// Clearance.
    pub kind: ClearanceKind,
    /// Group of the runway concerned.
    pub group: u8,
}

/// A clearance and when it is acted upon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given {
    /// Who gave it.
    pub seat: Seat,
    /// Flight, by index.
    pub flight: u32,
    /// Clearance.
    pub kind: ClearanceKind,
    /// From then on, s.
    pub acts_s: f64,
    /// A person gave it.
    pub by_person: bool,
}

/// What a seat did in a minute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// End of the minute, s.
    pub time_s: f64,
    /// Whose.
    pub seat: Seat,
    /// Share of the last 60 s in which it thought, spoke or listened.
    pub busy: f64,
    /// How many wait for it.
    pub queue: u32,
    /// Seconds of its frequency in use since the begin.
    pub on_air_s: f64,
}

/// Order in which a controller takes what is wanted: go-around and cancelled take-off, hold position, landing, take-off, crossing, line-up, taxi, push.
#[must_use]
pub fn priority(kind: ClearanceKind) -> u8 {
    use ClearanceKind::{Cross, GoAround, Hold, Land, LineUp, Push, Revoke, TakeOff, Taxi};
    match kind {
        GoAround | Revoke => 1,
        Hold => 2,
        Land => 3,
        TakeOff => 4,
        Cross => 5,
        LineUp => 6,
        Taxi => 7,
        Push => 8,
        _ => 9,
    }
}

/// A workload above the first makes thinking slower by half, above the second low priorities wait.
const BUSY: f64 = 0.8;
const FULL: f64 = 0.95;
/// Time over which the workload counts, s.
const WORKLOAD_S: f64 = 60.0;
/// Messages that are kept at most; the oldest go.
const MOST_MESSAGES: usize = 4096;

/// A controller's seat and its frequency.
#[derive(Clone, Debug, Default)]
struct Position {
    /// Thinks, speaks or listens until, s.
    busy_until_s: f64,
    /// The frequency is in use until, s.
    on_air_until_s: f64,
    /// Spans in which it was busy, of the last minute.
    spans: VecDeque<(f64, f64)>,
    on_air_s: f64,
    queue: u32,
}

impl Position {
    /// Share of the last minute in which it was busy.
    fn workload(&self, now_s: f64) -> f64 {
        let from_s = now_s - WORKLOAD_S;
        let of = |(a, b): &(f64, f64)| (b.min(now_s) - a.max(from_s)).max(0.0);
        self.spans.iter().map(of).sum::<f64>() / WORKLOAD_S
    }

    /// Somebody speaks for so long as soon as the frequency is free after `from_s`; (begin, end), s.
    fn speak(&mut self, from_s: f64, for_s: f64) -> (f64, f64) {
        let begin_s = from_s.max(self.on_air_until_s);
        self.on_air_until_s = begin_s + for_s;
        self.on_air_s += for_s;
        (begin_s, self.on_air_until_s)
    }
}

/// What is under way between a flight and its controllers.
#[derive(Clone, Copy, Debug)]
struct Talk {
    kind: ClearanceKind,
    /// Wanted since, s; the request has been spoken then or later.
    since_s: f64,
    asked_s: f64,
    /// Said: not again before, s.
    said_until_s: f64,
}

/// All controllers of an airport and those whom they talk to.
#[derive(Clone, Debug)]
pub struct Actors {
    habits: Habits,
    seed: u64,
    frame_s: f64,
    positions: BTreeMap<Seat, Position>,
    talks: BTreeMap<u32, Talk>,
    samples: Vec<Sample>,
    messages: VecDeque<Message>,
    sampled_s: f64,
    /// Messages in all.
    sent: u64,
    /// Seats with a person.
    taken: BTreeSet<Seat>,
    /// Flights that a person told something, until they act, s.
    told: BTreeMap<u32, f64>,
    said: u64,
    misheard: u64,
}

impl Actors {
    /// Nobody has said anything. `frame_s`: length of a frame, for the frames of messages.
    #[must_use]
    pub fn new(habits: Habits, seed: u64, frame_s: f64) -> Self {
        Self {
            habits,
            seed,
            frame_s,
            positions: BTreeMap::new(),
            talks: BTreeMap::new(),
            samples: Vec::new(),
            messages: VecDeque::new(),
            sampled_s: 0.0,
            sent: 0,
            taken: BTreeSet::new(),
            told: BTreeMap::new(),
            said: 0,
            misheard: 0,
        }
    }

    /// Every seat, once a minute.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The last messages, in the order in which they were begun.
    pub fn messages(&self) -> impl Iterator<Item = &Message> {
        self.messages.iter()
    }

    /// The messages after the first `known` of the run, as far as they are kept, and how many there are by now.
    #[must_use]
    pub fn messages_after(&self, known: u64) -> (Vec<Message>, u64) {
        let new = (self.sent.saturating_sub(known) as usize).min(self.messages.len());
        (self.messages.range(self.messages.len() - new..).copied().collect(), self.sent)
    }

    /// How many clearances were spoken, and how many of them misheard.
    #[must_use]
    pub fn spoken(&self) -> (u64, u64) {
        (self.said, self.misheard)
    }

    /// One scan: who wants what now, sorted by flight and each flight once. What is given, with its time.
    pub fn scan(&mut self, now_s: f64, wanted: &[Wanted]) -> Vec<Given> {
        self.scan_seen(now_s, wanted, &vec![true; wanted.len()])
    }

    /// The same where not everybody may be cleared as it looks: `may`, one for each that wants something.
    pub fn scan_seen(&mut self, now_s: f64, wanted: &[Wanted], may: &[bool]) -> Vec<Given> {
        self.hear(now_s, wanted);
        let mut given = Vec::new();
        let mut by_seat: BTreeMap<Seat, Vec<Wanted>> = BTreeMap::new();
        for (w, _) in wanted.iter().zip(may).filter(|(_, may)| **may) {
            by_seat.entry(Seat::of(w.kind, w.group)).or_default().push(*w);
        }
        for (seat, mut all) in by_seat {
            let position = self.positions.entry(seat).or_default();
            position.queue = all.len() as u32;
            let workload = position.workload(now_s);
            if position.busy_until_s > now_s || self.taken.contains(&seat) {
                continue;
            }
            let talk = |w: &Wanted| self.talks.get(&w.flight).copied();
            all.retain(|w| {
                let due = talk(w).is_some_and(|t| t.asked_s <= now_s && t.said_until_s <= now_s);
                due && (workload <= FULL || priority(w.kind) < 7)
            });
            let since = |w: &Wanted| talk(w).map_or(now_s, |t| t.since_s);
            all.sort_by(|a, b| {
                let key = |w: &Wanted| (priority(w.kind), since(w), w.flight);
                let ((pa, sa, fa), (pb, sb, fb)) = (key(a), key(b));
                pa.cmp(&pb).then(sa.total_cmp(&sb)).then(fa.cmp(&fb))
            });
            if let Some(next) = all.first() {
                given.extend(self.clear(now_s, seat, *next, Some(workload)).0);
            }
        }
        self.sample(now_s, wanted);
        given
    }

    /// Who wants something new asks for it when the frequency is free; who wants it no more is forgotten.
    fn hear(&mut self, now_s: f64, wanted: &[Wanted]) {
        self.talks.retain(|flight, talk| {
            let at = wanted.binary_search_by_key(flight, |w| w.flight);
            at.is_ok_and(|at| wanted[at].kind == talk.kind)
        });
        for w in wanted {
            if self.talks.contains_key(&w.flight) {
                continue;
            }
            // Those at a line or on the runway are seen; the others call.
            let calls =
                matches!(w.kind, ClearanceKind::Push | ClearanceKind::Taxi | ClearanceKind::Land);
            let mut asked_s = now_s;
            if calls {
                let seat = Seat::of(w.kind, w.group);
                let for_s = self.habits.speaks_s(MessageKind::Request, w.kind);
                asked_s = self.positions.entry(seat).or_default().speak(now_s, for_s).1;
                self.tell(Seat::Flight(w.flight), seat, asked_s, MessageKind::Request, w.kind);
            }
            let talk =
                Talk { kind: w.kind, since_s: now_s, asked_s, said_until_s: f64::NEG_INFINITY };
            self.talks.insert(w.flight, talk);
        }
    }

    fn tell(&mut self, from: Seat, to: Seat, end_s: f64, kind: MessageKind, body: ClearanceKind) {
        if self.messages.len() >= MOST_MESSAGES {
            self.messages.pop_front();
        }
        self.sent += 1;
        let at_frame = libm::ceil(end_s / self.frame_s - 1e-9) as i64;
        self.messages.push_back(Message { from, to, at_frame, kind, body });
    }

    /// One clearance: thought of, spoken, read back, acted upon at a time, s. `None` if it was misheard and nobody noticed.
    /// `workload`: of a model; a person has thought before.
    fn clear(
        &mut self,
        now_s: f64,
        seat: Seat,
        w: Wanted,
        workload: Option<f64>,
    ) -> (Option<Given>, f64) {
        let habits = self.habits;
        self.said += 1;
        let key = DrawKey {
            run_seed: self.seed,
            sensor: 1,
            entity: u64::from(w.flight),
            scan: self.said,
        };
        let mut rng = key.rng(Purpose::Mover);
        let slower = workload.map_or(0.0, |busy| if busy > BUSY { 1.5 } else { 1.0 });
        let think_s = slower * lognormal_s(habits.think_s, &mut rng);
        let drawn = answer(&habits, &mut rng);
        let (clears_s, reads_s) = (
            habits.speaks_s(MessageKind::Clearance, w.kind),
            habits.speaks_s(MessageKind::Readback, w.kind),
        );
        let pilot = Seat::Flight(w.flight);
        let position = self.positions.entry(seat).or_default();
        let (_, cleared_s) = position.speak(now_s + think_s, clears_s);
        let (_, mut read_s) = position.speak(cleared_s + drawn.readback_after_s, reads_s);
        let mut said = vec![
            (seat, pilot, cleared_s, MessageKind::Clearance),
            (pilot, seat, read_s, MessageKind::Readback),
        ];
        if drawn.wrong == Some(true) {
            let for_s = habits.speaks_s(MessageKind::Correction, w.kind);
            let (_, corrected_s) = position.speak(read_s, for_s);
            read_s = position.speak(corrected_s + drawn.readback_after_s, reads_s).1;
            said.push((seat, pilot, corrected_s, MessageKind::Correction));
            said.push((pilot, seat, read_s, MessageKind::Readback));
        }
        position.busy_until_s = read_s;
        position.spans.push_back((now_s, read_s));
        for (from, to, end_s, kind) in said {
            self.tell(from, to, end_s, kind, w.kind);
        }
        self.misheard += u64::from(drawn.wrong.is_some());
        if let Some(talk) = self.talks.get_mut(&w.flight) {
            talk.said_until_s = read_s + habits.again_s;
        }
        let acts_s = read_s + drawn.acts_after_s;
        let by_person = workload.is_none();
        let given = Given { seat, flight: w.flight, kind: w.kind, acts_s, by_person };
        ((drawn.wrong != Some(false)).then_some(given), acts_s)
    }

    fn sample(&mut self, now_s: f64, wanted: &[Wanted]) {
        for (seat, position) in &mut self.positions {
            while position.spans.front().is_some_and(|(_, end)| *end < now_s - WORKLOAD_S) {
                position.spans.pop_front();
            }
            position.queue =
                wanted.iter().filter(|w| Seat::of(w.kind, w.group) == *seat).count() as u32;
        }
        if now_s < self.sampled_s + WORKLOAD_S {
            return;
        }
        self.sampled_s = now_s;
        let of = |(seat, p): (&Seat, &Position)| Sample {
            time_s: now_s,
            seat: *seat,
            busy: p.workload(now_s),
            queue: p.queue,
            on_air_s: p.on_air_s,
        };
        self.samples.extend(self.positions.iter().map(of));
    }
}

#[cfg(test)]
mod tests;
