//! Controllers at their seats: what flights wait for comes with the frame ends of the generators, what is cleared
//! goes out with one's own, each with the frame from which the traffic acts upon it.

use super::advice_words::Names;
use super::look_ahead::LookAhead;
use super::people::{Asked, People, With};
use crate::runtime::bus::Class;
use crate::runtime::federate::FrameOut;
use crate::runtime::federate::Publication;
use crate::runtime::messages::{Frame, GivenNotice, Notice, SeatEvent, SeatInput, WantNotice};
use models::control::actors::message::{Message, Seat};
use models::control::actors::pilot::Habits;
use models::control::actors::reacts::Reacts;
use models::control::actors::seats::group_named;
use models::control::actors::sight::{Sight, Waiting};
use models::control::actors::{Actors, Wanted};
use models::control::advice::{self, Advisor, Became, Departing, Picture};
use models::control::clearance::{Board, ClearanceKind};
use models::control::departures::Departures;
use models::control::safety_net::SafetyNet;
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::ahead::{Day, Flight, Known};
use models::traffic::network::Network;
use scenarios::control::HumanSeats;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;

/// From the clearance to take off to the lift-off, s (assumed).
const ROLL_S: f64 = 40.0;
/// Shares of generators that are listened to at most.
const MOST_SHARES: u32 = 64;

/// Tells the departure manager who asks and who is at his line; whom it holds may not be pushed by the model.
fn sequence(departures: &mut Departures, now_s: f64, wanted: &[Wanted], may: &mut [bool]) {
    use ClearanceKind::{LineUp, Push, TakeOff};
    for w in wanted {
        match w.kind {
            Push => departures.asks(w.flight, now_s),
            LineUp | TakeOff => departures.at_line(w.flight, now_s),
            _ => {}
        }
    }
    departures.scan(now_s);
    for (w, may) in wanted.iter().zip(may).filter(|(w, _)| w.kind == Push) {
        *may &= departures.may_push(w.flight, now_s);
    }
}

/// What is to be said because of alerts at seats whose models speak: a person decides himself, and what the flight wants of the others
/// is not put off for it.
fn by_models(says: Vec<Wanted>, is_taken: &dyn Fn(Seat) -> bool) -> Vec<Wanted> {
    says.into_iter().filter(|w| !is_taken(Seat::of(w.kind, w.group))).collect()
}

/// What is wanted, with what is said because of alerts in the place of what the same flight wants.
fn before_all(says: Vec<Wanted>, wanted: &[Wanted], may: &[bool]) -> (Vec<Wanted>, Vec<bool>) {
    let said = |w: &Wanted| says.iter().any(|s| s.flight == w.flight);
    let left = wanted.iter().zip(may).filter(|(w, _)| !said(w)).map(|(w, may)| (*w, *may));
    let mut all: Vec<(Wanted, bool)> = left.collect();
    all.extend(says.iter().map(|s| (*s, true)));
    all.sort_by_key(|(w, _)| w.flight);
    all.into_iter().unzip()
}

/// All seats of controllers.
#[derive(Debug)]
pub(super) struct Seats {
    actors: Actors,
    /// Call signs of the flights of the scene, in their order.
    callsigns: Vec<String>,
    /// What they see of the traffic on tracks; none where they know it.
    sight: Option<Sight>,
    people: People,
    /// Where controllers are advised.
    advisor: Option<Advisor>,
    /// Where departures leave their stands by a sequence.
    departures: Option<Departures>,
    /// What the models say because of alerts.
    reacts: Reacts,
    look_ahead: LookAhead,
    network: Arc<Network>,
    flights: Arc<Vec<Flight>>,
    /// Names of its runways and stands, as advice says them.
    runways: Vec<String>,
    stands: Vec<String>,
    /// UTC of the begin, ns.
    start_utc_ns: i64,
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
        (network, flights): (Arc<Network>, Arc<Vec<Flight>>),
        seed: u64,
        (step_s, start_utc_ns): (f64, i64),
        ahead: Frame,
        on_tracks: bool,
    ) -> Self {
        let seats = models::control::actors::seats::seats(&network);
        Self {
            callsigns: flights.iter().map(|f| f.callsign.clone()).collect(),
            actors: Actors::new(Habits::default(), seed, step_s),
            sight: on_tracks.then(Sight::default),
            people: People::new(seats, step_s),
            advisor: None,
            departures: None,
            reacts: Reacts::default(),
            look_ahead: LookAhead::new(Arc::clone(&network), Arc::clone(&flights), seed, on_tracks),
            runways: network.runways.iter().map(|r| r.names.join("/")).collect(),
            stands: network.stands.iter().map(|s| s.name.clone()).collect(),
            network,
            flights,
            start_utc_ns,
            wants: BTreeMap::new(),
            step_s,
            ahead,
            given: 0,
            messages: 0,
            samples: 0,
        }
    }

    /// The weather from now on: who looks ahead takes it to stay.
    pub(super) fn weather(&mut self, day: Day) {
        self.look_ahead.day = day;
    }

    /// The same with advice for these departures.
    pub(super) fn with_advice(self, seed: u64, departures: Vec<Departing>) -> Self {
        let advisor = Some(Advisor::new(advice::Habits::default(), seed, departures));
        Self { advisor, ..self }
    }

    /// The same with seats that are persons', and departures that leave their stands by a sequence.
    pub(super) fn with(mut self, human: &HumanSeats, departures: Option<Departures>) -> Self {
        self.people = self.people.expecting(human, &mut self.actors);
        Self { departures, ..self }
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
            let callsign = self.callsigns.get(w.flight as usize)?;
            Some(Waiting {
                wanted: Wanted { flight: w.flight, kind: w.kind, group: w.group },
                strip: board.find(Callsign::new(callsign)).map(|i| i as u32),
                runway: layout.runway(&w.runway).map(|r| r.0),
            })
        };
        let told = self.wants.values().flatten();
        let waiting_all: Vec<Waiting> = told.clone().filter_map(waiting).collect();
        let known = Known { board, surveillance: net.surveillance(), layout };
        let (network, flights) = (Arc::clone(&self.network), Arc::clone(&self.flights));
        let picture = Picture {
            known,
            network: &network,
            flights: &flights,
            waiting: &waiting_all,
            frame: (frame as i64, self.step_s),
        };
        let mut could: Vec<Wanted> =
            told.clone().filter(|w| !w.asks).filter_map(waiting).map(|w| w.wanted).collect();
        could.sort_by_key(|w| w.flight);
        let mut all: Vec<Waiting> = told.filter(|w| w.asks).filter_map(waiting).collect();
        all.sort_by_key(|w| w.wanted.flight);
        all.dedup_by_key(|w| w.wanted.flight);
        let mut may = match &mut self.sight {
            Some(sight) => sight.look(now.s(), &all, layout, net.surveillance()),
            None => vec![true; all.len()],
        };
        let wanted: Vec<Wanted> = all.iter().map(|w| w.wanted).collect();
        let mut events = Vec::new();
        let mut advised = Vec::new();
        let asked = Asked { wanted: &wanted, could: &could };
        let mut all = self.people.scan(
            now.s(),
            asked,
            &self.callsigns,
            With {
                actors: &mut self.actors,
                advisor: &mut self.advisor,
                look_ahead: &mut self.look_ahead,
                picture: &picture,
            },
            (&mut events, &mut advised),
        );
        if let Some(advisor) = &mut self.advisor {
            let taken = self.actors.is_taken(Seat::Apron);
            advised.extend(advisor.scan(now.s(), &wanted, taken, Some(&picture)));
            for (w, may) in wanted.iter().zip(&mut may) {
                *may &= w.kind != ClearanceKind::Push || advisor.may_push(w.flight);
            }
        }
        if let Some(departures) = &mut self.departures {
            sequence(departures, now.s(), &wanted, &mut may);
        }
        let flight = |callsign: Callsign| {
            let own = |c: &String| Callsign::new(c) == callsign;
            self.callsigns.iter().position(own).map(|m| m as u32)
        };
        let group = |r: usize| {
            let name = layout.runways.get(r).map_or("", |axis| axis.names[0].as_str());
            group_named(&network, name)
        };
        let says = self.reacts.look(now.s(), net, board, &flight, &group);
        let says = by_models(says, &|seat| self.actors.is_taken(seat));
        let (seen, may) = before_all(says, &wanted, &may);
        all.extend(self.actors.scan_seen(now.s(), &seen, &may));
        for given in all {
            self.reacts.given(now.s(), given.flight, given.kind, net);
            self.people.given(&given);
            match (given.kind, &mut self.departures) {
                (ClearanceKind::Push, Some(d)) => d.pushed(given.flight, given.acts_s),
                (ClearanceKind::TakeOff, Some(d)) => {
                    d.took_off(given.flight, given.acts_s + ROLL_S)
                }
                _ => {}
            }
            self.advisor.iter_mut().for_each(|advisor| advisor.given(&given));
            self.given += 1;
            let notice = GivenNotice {
                flight: given.flight,
                kind: given.kind,
                seat: given.seat.name(),
                by_person: given.by_person,
                number: self.given,
            };
            let acts = libm::ceil(given.acts_s / self.step_s) as Frame;
            let effect = acts.max(frame + self.ahead);
            out.later.push((effect, Notice::Given(notice.clone())));
            events.push(SeatEvent::Given(effect, notice));
        }
        let axes: Vec<String> = layout.runways.iter().map(|axis| axis.names.join("/")).collect();
        let names = self.names(&axes);
        let advised = advised.iter().map(|c| names.notice(frame, c.became(), c.advice()));
        events.extend(advised.map(SeatEvent::Advised));
        self.tell(&mut events);
        self.show(frame, now.s(), (asked, &axes), out);
        events
    }

    fn names<'a>(&'a self, axes: &'a [String]) -> Names<'a> {
        Names {
            callsigns: &self.callsigns,
            runways: &self.runways,
            axes,
            stands: &self.stands,
            start_utc_ns: self.start_utc_ns,
        }
    }

    fn name(callsigns: &[String], seat: Seat) -> String {
        match seat {
            Seat::Flight(flight) => callsigns.get(flight as usize).cloned().unwrap_or_default(),
            seat => seat.name(),
        }
    }

    /// Shows pages who sits where, who waits for what, and what was said.
    fn show(
        &mut self,
        frame: Frame,
        now_s: f64,
        (wanted, axes): (Asked<'_>, &[String]),
        out: &mut FrameOut,
    ) {
        let names = self.names(axes);
        let standing = self.advisor.iter().flat_map(Advisor::standing);
        let advice: Vec<serde_json::Value> = standing
            .map(|a| {
                let told = names.notice(frame, Became::Given, a);
                json!({
                    "id": told.id, "kind": told.kind.word(), "seat": told.seat, "subjects": told.subjects, "text": told.text,
                    "value": told.value, "unit": told.unit, "otherwise": told.otherwise,
                    "until_s": SimTime(told.until_ns).s(), "decision": told.decision.word(), "by_person": told.by_person,
                    "what_if": names.question(a, now_s),
                })
            })
            .collect();
        let callsigns = &self.callsigns;
        // Target times of those who have not been cleared to take off.
        let departures = self.departures.iter();
        let targets =
            departures.flat_map(|d| d.flights().filter_map(|f| Some((f, d.milestones(f)?))));
        let targets: Vec<serde_json::Value> = targets
            .map(|(flight, t)| {
                json!({
                    "callsign": Self::name(&self.callsigns, Seat::Flight(flight)), "tobt_s": t.tobt_s.round(),
                    "tsat_s": t.tsat_s.round(), "ttot_s": t.ttot_s.round(),
                })
            })
            .collect();
        let shown = (&advice[..], &self.look_ahead.told()[..], &targets[..]);
        let state = self.people.told(now_s, wanted, shown, &|seat| Self::name(callsigns, seat));
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
            kind: m.kind,
            clearance: m.body,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_person_is_to_say_because_of_an_alert_hides_nothing_that_a_flight_wants() {
        let of = |kind| Wanted { flight: 3, kind, group: 0 };
        let (says, wants) = (vec![of(ClearanceKind::Hold)], [of(ClearanceKind::Push)]);
        let all = |taken: bool| {
            let says = by_models(says.clone(), &|seat| taken && seat == Seat::Ground);
            before_all(says, &wants, &[true]).0
        };
        assert_eq!(all(true), wants, "the apron pushes him, ground is a person's");
        assert_eq!(all(false), says);
    }
}
