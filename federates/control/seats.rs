//! Controllers at their seats: what flights wait for comes with the frame ends of the generators, what is cleared
//! goes out with one's own, each with the frame from which the traffic acts upon it.

use super::people::{Asked, People};
use crate::runtime::bus::Class;
use crate::runtime::federate::FrameOut;
use crate::runtime::federate::Publication;
use crate::runtime::messages::{Frame, GivenNotice, Notice, SeatEvent, SeatInput, WantNotice};
use models::control::actors::message::{Message, Seat};
use models::control::actors::pilot::Habits;
use models::control::actors::sight::{Sight, Waiting};
use models::control::actors::{Actors, Wanted};
use models::control::clearance::{Board, ClearanceKind};
use models::control::safety_net::SafetyNet;
use models::plot::Callsign;
use models::time::SimTime;
use std::collections::BTreeMap;

/// Shares of generators that are listened to at most.
const MOST_SHARES: u32 = 64;

/// All seats of controllers.
#[derive(Debug)]
pub(super) struct Seats {
    actors: Actors,
    /// Call signs of the flights of the scene, in their order.
    callsigns: Vec<String>,
    /// What they see of the traffic on tracks; none where they know it.
    sight: Option<Sight>,
    people: People,
    wants: BTreeMap<u32, Vec<WantNotice>>,
    step_s: f64,
    ahead: Frame,
    given: u64,
    messages: u64,
    samples: usize,
}

impl Seats {
    /// Nobody has said anything; what is said takes effect `ahead` frames later at the earliest.
    pub(super) fn new(
        callsigns: Vec<String>,
        seats: Vec<Seat>,
        seed: u64,
        step_s: f64,
        ahead: Frame,
        on_tracks: bool,
    ) -> Self {
        Self {
            callsigns,
            actors: Actors::new(Habits::default(), seed, step_s),
            sight: on_tracks.then(Sight::default),
            people: People::new(seats, step_s),
            wants: BTreeMap::new(),
            step_s,
            ahead,
            given: 0,
            messages: 0,
            samples: 0,
        }
    }

    /// The controllers and pilots.
    pub(super) fn actors(&self) -> &Actors {
        &self.actors
    }

    /// What somebody does at a seat, from a frame on.
    pub(super) fn input(&mut self, frame: Frame, input: &SeatInput) {
        self.people.take(frame, input);
    }

    /// What the flights of a share wait for from now on.
    pub(super) fn take(&mut self, share: u32, wants: &[WantNotice]) {
        if share <= MOST_SHARES {
            self.wants.insert(share, wants.to_vec());
        }
    }

    /// One scan, after the safety net has looked at its tracks: what is cleared goes into `out`; what happened.
    pub(super) fn scan(
        &mut self,
        frame: Frame,
        now: SimTime,
        net: &SafetyNet,
        board: &Board,
        out: &mut FrameOut,
    ) -> Vec<SeatEvent> {
        let layout = net.layout();
        let waiting = |w: &WantNotice| {
            let kind = ClearanceKind::of(&w.kind)?;
            let callsign = self.callsigns.get(w.flight as usize)?;
            Some(Waiting {
                wanted: Wanted { flight: w.flight, kind, group: w.group },
                strip: board.find(Callsign::new(callsign)).map(|i| i as u32),
                runway: layout.runway(&w.runway).map(|r| r.0),
            })
        };
        let told = self.wants.values().flatten();
        let mut could: Vec<Wanted> =
            told.clone().filter(|w| !w.asks).filter_map(waiting).map(|w| w.wanted).collect();
        could.sort_by_key(|w| w.flight);
        let mut all: Vec<Waiting> = told.filter(|w| w.asks).filter_map(waiting).collect();
        all.sort_by_key(|w| w.wanted.flight);
        all.dedup_by_key(|w| w.wanted.flight);
        let may = match &mut self.sight {
            Some(sight) => sight.look(now.s(), &all, layout, net.surveillance()),
            None => vec![true; all.len()],
        };
        let wanted: Vec<Wanted> = all.iter().map(|w| w.wanted).collect();
        let mut events = Vec::new();
        let (actors, callsigns) = (&mut self.actors, &self.callsigns);
        let asked = Asked { wanted: &wanted, could: &could };
        let mut all = self.people.scan(now.s(), asked, callsigns, actors, &mut events);
        all.extend(actors.scan_seen(now.s(), &wanted, &may));
        for given in all {
            self.given += 1;
            let notice = GivenNotice {
                flight: given.flight,
                kind: given.kind.word().to_owned(),
                seat: given.seat.name(),
                by_person: given.by_person,
                number: self.given,
            };
            let acts = libm::ceil(given.acts_s / self.step_s) as Frame;
            let effect = acts.max(frame + self.ahead);
            out.later.push((effect, Notice::Given(notice.clone())));
            events.push(SeatEvent::Given(effect, notice));
        }
        self.tell(&mut events);
        self.show(now.s(), asked, out);
        events
    }

    fn name(callsigns: &[String], seat: Seat) -> String {
        match seat {
            Seat::Flight(flight) => callsigns.get(flight as usize).cloned().unwrap_or_default(),
            seat => seat.name(),
        }
    }

    /// Shows pages who sits where, who waits for what, and what was said.
    fn show(&mut self, now_s: f64, wanted: Asked<'_>, out: &mut FrameOut) {
        let callsigns = &self.callsigns;
        let state = self.people.told(now_s, wanted, &|seat| Self::name(callsigns, seat));
        out.publish.extend(state.map(|state| Publication {
            key: "control/1/positions".into(),
            class: Class::Lossy,
            body: state.to_string().into_bytes(),
            retained: Some("control/1/positions/last".into()),
        }));
    }

    /// What was said, and every seat's last minute.
    fn tell(&mut self, events: &mut Vec<SeatEvent>) {
        let name = |seat: Seat| Self::name(&self.callsigns, seat);
        let (messages, told) = self.actors.messages_after(self.messages);
        self.people.heard(&messages);
        events.extend(messages.into_iter().map(|m: Message| SeatEvent::Spoke {
            time_ns: SimTime::from_s(m.at_frame as f64 * self.step_s).0,
            between: [name(m.from), name(m.to)],
            kind: m.kind.word().to_owned(),
            clearance: m.body.word().to_owned(),
        }));
        self.messages = told;
        let samples = &self.actors.samples()[self.samples..];
        if samples.is_empty() {
            return;
        }
        events.extend(samples.iter().map(|s| SeatEvent::Minute {
            time_ns: SimTime::from_s(s.time_s).0,
            seat: s.seat.name(),
            busy: s.busy,
            queue: s.queue,
            on_air_s: s.on_air_s,
        }));
        self.samples += samples.len();
        let (spoken, misheard) = self.actors.spoken();
        let seen = self.sight.as_ref().map(Sight::cost);
        events.push(SeatEvent::Counts { spoken, misheard, seen });
    }
}
