//! People at controllers' seats: who sits where, what they say to whom, and what came of it.
//!
//! Inputs come with the frame ends of the member `visitors` and count from their frame on, so equal inputs give equal runs.
//! Whoever is not heard of any more loses his seat to the model.

use super::look_ahead::LookAhead;
use crate::runtime::messages::{Frame, SeatAction, SeatEvent, SeatInput};
use models::control::actors::message::{Message, Seat};
use models::control::actors::{Actors, Given, Wanted};
use models::control::advice::{self, Advisor, Decision, Kind, Picture};
use models::control::clearance::ClearanceKind;
use scenarios::control::HumanSeats;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// A person of whom nothing is heard for so long has gone, s of simulated time. Who sits at a door that works is told of
/// every minute.
const SILENT_S: f64 = 150.0;
/// The model takes a person's seat that has been empty for so long, s.
const EMPTY_S: f64 = 30.0;
/// Inputs that wait for a scan at most.
const MOST_WAITING: usize = 4096;
/// Answers and messages that are shown.
const SHOWN: usize = 24;

/// Who has a seat.
#[derive(Clone, Debug)]
struct Holder {
    person: String,
    since_s: f64,
    heard_s: f64,
}

/// What became of an input.
#[derive(Clone, Debug)]
struct Answered {
    number: u64,
    person: String,
    seat: String,
    time_s: f64,
    accepted: bool,
    text: String,
}

/// What flights wait for now, and what those that wait for nothing could be cleared for; by flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked<'a> {
    pub(super) wanted: &'a [Wanted],
    pub(super) could: &'a [Wanted],
}

impl Asked<'_> {
    fn find(list: &[Wanted], flight: u32) -> Option<Wanted> {
        list.binary_search_by_key(&flight, |w| w.flight).ok().map(|at| list[at])
    }
}

/// Whom people at seats have to do with.
pub(super) struct With<'a> {
    pub(super) actors: &'a mut Actors,
    /// Where controllers are advised.
    pub(super) advisor: &'a mut Option<Advisor>,
    pub(super) look_ahead: &'a mut LookAhead,
    pub(super) picture: &'a Picture<'a>,
}

/// People at the seats of an airport.
#[derive(Debug, Default)]
pub(super) struct People {
    seats: Vec<Seat>,
    step_s: f64,
    holders: BTreeMap<Seat, Holder>,
    waiting: VecDeque<(Frame, SeatInput)>,
    answers: VecDeque<Answered>,
    radio: VecDeque<Message>,
    /// Since when each flight wants what it wants, s.
    since: BTreeMap<u32, (ClearanceKind, f64)>,
    /// Flights that have wanted something, and on which group of runways last.
    known: BTreeMap<u32, u8>,
    /// Flights that were told to hold, by a person or a model.
    held: BTreeSet<u32>,
    /// Seats that the scene leaves to people, and since when nobody sits there, s.
    expected: BTreeMap<Seat, Option<f64>>,
    /// The model takes one of these that has been empty for [`EMPTY_S`].
    fallback: bool,
    /// Told by people, until it is acted upon: clearance, seat, s.
    under_way: BTreeMap<u32, (ClearanceKind, Seat, f64)>,
    /// What was shown last, but for its time.
    shown: Value,
}

impl People {
    /// Nobody sits anywhere.
    pub(super) fn new(seats: Vec<Seat>, step_s: f64) -> Self {
        Self { seats, step_s, ..Self::default() }
    }

    /// The same where the scene leaves seats to people: no model decides there. `fallback`: until one has been empty for long.
    pub(super) fn expecting(mut self, human: &HumanSeats, actors: &mut Actors) -> Self {
        let of = |seat: &Seat| match seat {
            Seat::Apron => human.apron,
            Seat::Ground => human.ground,
            Seat::Tower(_) => human.tower,
            Seat::Flight(_) => false,
        };
        self.expected =
            self.seats.iter().copied().filter(of).map(|seat| (seat, Some(0.0))).collect();
        self.expected.keys().for_each(|seat| actors.take(*seat));
        self.fallback = human.fallback;
        self
    }

    /// A person has left: the model decides again, at a seat that is a person's only after a while, if ever. Whose it is now.
    fn empty(&mut self, seat: Seat, now_s: f64, actors: &mut Actors) -> String {
        match self.expected.get_mut(&seat) {
            None => {
                actors.give_up(seat);
                format!("{} is the model's again", seat.name())
            }
            Some(since) => {
                *since = Some(now_s);
                format!("{} is nobody's", seat.name())
            }
        }
    }

    /// The model takes those that have been empty for long.
    fn fall_back(&mut self, now_s: f64, actors: &mut Actors) {
        for (seat, since) in self.expected.iter_mut().filter(|_| self.fallback) {
            if since.take_if(|since| now_s - *since >= EMPTY_S).is_some() {
                actors.give_up(*seat);
            }
        }
    }

    /// An input that counts from a frame on.
    pub(super) fn take(&mut self, frame: Frame, input: &SeatInput) {
        if self.waiting.len() < MOST_WAITING {
            self.waiting.push_back((frame, input.clone()));
        }
    }

    /// What was done since the last scan.
    pub(super) fn scan(
        &mut self,
        now_s: f64,
        asked: Asked<'_>,
        callsigns: &[String],
        with: With<'_>,
        (events, advised): (&mut Vec<SeatEvent>, &mut Vec<advice::Change>),
    ) -> Vec<Given> {
        let With { actors, advisor, look_ahead, picture } = with;
        let wanted = asked.wanted;
        for w in wanted.iter().chain(asked.could) {
            self.known.insert(w.flight, w.group);
        }
        // Who has taken off is told nothing on the ground any more.
        self.known.retain(|flight, _| !picture.has_taken_off(*flight as usize));
        self.held.retain(|flight| !picture.has_taken_off(*flight as usize));
        self.since.retain(|flight, (kind, _)| {
            let at = wanted.binary_search_by_key(flight, |w| w.flight);
            at.is_ok_and(|at| wanted[at].kind == *kind)
        });
        for w in wanted {
            self.since.entry(w.flight).or_insert((w.kind, now_s));
        }
        self.under_way.retain(|_, (_, _, until_s)| *until_s > now_s);
        let mut given = Vec::new();
        for (frame, input) in std::mem::take(&mut self.waiting) {
            let at_s = frame as f64 * self.step_s;
            let done = match &input.order.action {
                SeatAction::Decide { callsign, kind, accept } => {
                    let of = (callsign.as_str(), *kind, *accept);
                    let says = self.advised(at_s, &input, of, callsigns, advisor);
                    // Accepting it is saying it; what cannot be said leaves the advice as it is.
                    let said = says.and_then(|(flight, clearance)| {
                        let Some(clearance) = clearance else { return Ok((flight, None)) };
                        let mut said = input.clone();
                        let callsign = callsign.clone();
                        said.order.action = SeatAction::Say { callsign, clearance };
                        let said = self.done(at_s, &said, asked, callsigns, actors)?;
                        Ok((flight, Some(said)))
                    });
                    said.and_then(|(flight, said)| {
                        let (text, change) = decided(flight, of, advisor)?;
                        advised.push(change);
                        Ok(said.unwrap_or((text, None)))
                    })
                }
                SeatAction::WhatIf { callsign, change } => {
                    let held = self.held_by(at_s, &input.order.seat, &input.order.person);
                    let asks = (callsign.as_str(), change.as_str());
                    held.and_then(|_| look_ahead.ask(&input.order.person, asks, picture))
                        .map(|text| (text, None))
                }
                _ => self.done(at_s, &input, asked, callsigns, actors),
            };
            let (accepted, text) = match done {
                Ok((text, clearance)) => {
                    given.extend(clearance);
                    (true, text)
                }
                Err(text) => (false, text),
            };
            if !text.is_empty() {
                if self.answers.len() >= SHOWN {
                    self.answers.pop_front();
                }
                self.answers.push_back(Answered {
                    number: input.number,
                    person: input.order.person.clone(),
                    seat: input.order.seat.clone(),
                    time_s: at_s,
                    accepted,
                    text: text.clone(),
                });
            }
            events.push(SeatEvent::Input {
                frame,
                input,
                refused: if accepted { String::new() } else { text },
            });
        }
        let gone = |h: &Holder| now_s > h.heard_s + SILENT_S;
        let silent: Vec<Seat> =
            self.holders.iter().filter(|(_, h)| gone(h)).map(|(seat, _)| *seat).collect();
        for seat in silent {
            let Some(holder) = self.holders.remove(&seat) else { continue };
            self.empty(seat, now_s, actors);
            let frame = libm::round(now_s / self.step_s) as Frame;
            events.push(SeatEvent::Silent { frame, seat: seat.name(), person: holder.person });
        }
        self.fall_back(now_s, actors);
        given
    }

    /// Somebody, also a model, has cleared a flight: who sits down later can let taxi whom the model held.
    pub(super) fn given(&mut self, given: &Given) {
        self.was_told(given.flight, given.kind);
    }

    fn was_told(&mut self, flight: u32, kind: ClearanceKind) {
        match kind {
            ClearanceKind::Hold => drop(self.held.insert(flight)),
            ClearanceKind::Taxi => drop(self.held.remove(&flight)),
            _ => {}
        }
    }

    /// What an input does: words for its person, and a clearance that goes to the traffic.
    fn done(
        &mut self,
        at_s: f64,
        input: &SeatInput,
        asked: Asked<'_>,
        callsigns: &[String],
        actors: &mut Actors,
    ) -> Result<(String, Option<Given>), String> {
        let order = &input.order;
        let known = Seat::named(&order.seat).filter(|seat| self.seats.contains(seat));
        let seat = known.ok_or_else(|| format!("there is no seat {:?}", order.seat))?;
        if let Some(other) = self.holders.get(&seat).filter(|h| h.person != order.person) {
            return Err(format!("{} is taken by {}", order.seat, other.person));
        }
        if order.action == SeatAction::Take {
            let person = order.person.clone();
            let holder = Holder { person, since_s: at_s, heard_s: at_s };
            self.holders.entry(seat).or_insert(holder).heard_s = at_s;
            actors.take(seat);
            self.expected.entry(seat).and_modify(|since| *since = None);
            return Ok((format!("{} is yours", order.seat), None));
        }
        let Some(holder) = self.holders.get_mut(&seat) else {
            return Err(format!("nobody sits at {}: take it first", order.seat));
        };
        holder.heard_s = at_s;
        match &order.action {
            SeatAction::Leave => {
                self.holders.remove(&seat);
                Ok((self.empty(seat, at_s, actors), None))
            }
            SeatAction::Say { callsign, clearance: kind } => {
                let (kind, word) = (*kind, kind.word());
                let flight = callsigns.iter().position(|c| c == callsign);
                let flight = flight.ok_or_else(|| format!("there is no flight {callsign:?}"))?;
                let what = self.possible(flight as u32, callsign, kind, asked)?;
                let whose = Seat::of(kind, what.group);
                if whose != seat {
                    return Err(format!("{word} for {callsign} is given by {}", whose.name()));
                }
                let given =
                    actors.say(at_s, seat, what).map_err(|why| format!("{callsign} {why}"))?;
                self.was_told(what.flight, kind);
                if let Some(given) = &given {
                    self.under_way.insert(what.flight, (kind, seat, given.acts_s));
                }
                Ok((format!("{callsign}: {word}"), given))
            }
            SeatAction::Here
            | SeatAction::Take
            | SeatAction::Decide { .. }
            | SeatAction::WhatIf { .. }
            | SeatAction::Drive { .. }
            | SeatAction::Give { .. }
            | SeatAction::Release { .. } => Ok((String::new(), None)),
        }
    }

    /// The flight of an advice for one's own seat, and the clearance that accepting it is; `None` where it is none, or is so decided.
    fn advised(
        &mut self,
        at_s: f64,
        input: &SeatInput,
        (callsign, kind, accept): (&str, Kind, bool),
        callsigns: &[String],
        advisor: &Option<Advisor>,
    ) -> Result<(u32, Option<ClearanceKind>), String> {
        let seat = self.held_by(at_s, &input.order.seat, &input.order.person)?;
        let advisor =
            advisor.as_ref().ok_or("this scene gives no advice: [control] advice = true")?;
        let flight = callsigns.iter().position(|c| c == callsign);
        let flight = flight.ok_or_else(|| format!("there is no flight {callsign:?}"))? as u32;
        let advice = advisor.of(kind, flight);
        if let Some(other) = advice.filter(|a| a.seat != seat) {
            return Err(format!("the advice for {callsign} is for {}", other.seat.name()));
        }
        let open = advice.filter(|a| accept && a.decision.0 != Decision::Accepted);
        Ok((flight, open.and_then(|a| a.what.clearance())))
    }

    /// The seat of a name, where this person has it; he is heard of.
    fn held_by(&mut self, at_s: f64, seat: &str, person: &str) -> Result<Seat, String> {
        let known = Seat::named(seat).filter(|seat| self.seats.contains(seat));
        let known = known.ok_or_else(|| format!("there is no seat {seat:?}"))?;
        let holder = self.holders.get_mut(&known).filter(|h| h.person == person);
        let holder = holder.ok_or_else(|| format!("{seat} is not yours: take it first"))?;
        holder.heard_s = at_s;
        Ok(known)
    }

    /// What can be said to a flight: what it asks for, or could do though nobody would ask for it; hold position, and taxi again
    /// after it; go around on final.
    fn possible(
        &self,
        flight: u32,
        callsign: &str,
        kind: ClearanceKind,
        asked: Asked<'_>,
    ) -> Result<Wanted, String> {
        let wants = Asked::find(asked.wanted, flight);
        let could = Asked::find(asked.could, flight);
        if let Some(what) = wants.into_iter().chain(could).find(|w| w.kind == kind) {
            return Ok(what);
        }
        let group = self.known.get(&flight).copied();
        let Some(group) = group else {
            return Err(format!("{callsign} has not called yet"));
        };
        let again = kind == ClearanceKind::Taxi && self.held.contains(&flight);
        let lands = wants.or(could).is_some_and(|w| w.kind == ClearanceKind::Land);
        if kind == ClearanceKind::Hold || again || (kind == ClearanceKind::GoAround && lands) {
            return Ok(Wanted { flight, kind, group });
        }
        Err(match (wants, could) {
            (Some(w), _) => {
                format!("{callsign} waits for {}, not for {}", w.kind.word(), kind.word())
            }
            (None, Some(w)) => {
                format!("{callsign} could do {} now, not {}", w.kind.word(), kind.word())
            }
            (None, None) => format!("{callsign} waits for no clearance now"),
        })
    }

    /// Messages that were spoken.
    pub(super) fn heard(&mut self, messages: &[Message]) {
        self.radio.extend(messages.iter().copied());
        self.radio.drain(..self.radio.len().saturating_sub(SHOWN));
    }

    /// How the seats stand (JSON), where something changed.
    pub(super) fn told(
        &mut self,
        now_s: f64,
        asked: Asked<'_>,
        (advice, what_if, targets): (&[Value], &[Value], &[Value]),
        name: &dyn Fn(Seat) -> String,
    ) -> Option<Value> {
        let round = |s: f64| (10.0 * s).round() / 10.0;
        let wants = |seat: Seat| -> Vec<Value> {
            let own = asked.wanted.iter().filter(|w| Seat::of(w.kind, w.group) == seat);
            own.map(|w| {
                let since_s = self.since.get(&w.flight).map_or(now_s, |(_, s)| *s);
                json!({"callsign": name(Seat::Flight(w.flight)), "clearance": w.kind.word(), "since_s": round(since_s)})
            })
            .collect()
        };
        let could = |seat: Seat| -> Vec<Value> {
            let own = asked.could.iter().filter(|w| Seat::of(w.kind, w.group) == seat);
            own.map(
                |w| json!({"callsign": name(Seat::Flight(w.flight)), "clearance": w.kind.word()}),
            )
            .collect()
        };
        let seat = |seat: &Seat| {
            let holder = self.holders.get(seat);
            json!({
                "name": seat.name(), "by": holder.map(|h| h.person.as_str()),
                "since_s": holder.map(|h| round(h.since_s)), "wants": wants(*seat),
                "could": could(*seat),
            })
        };
        let pending = |(flight, (kind, seat, until_s)): (&u32, &(ClearanceKind, Seat, f64))| {
            json!({
                "callsign": name(Seat::Flight(*flight)), "clearance": kind.word(), "seat": seat.name(), "until_s": round(*until_s),
            })
        };
        let radio = |m: &Message| {
            json!({
                "time_s": round(m.at_frame as f64 * self.step_s), "from": name(m.from), "to": name(m.to),
                "kind": m.kind.word(), "clearance": m.body.word(),
            })
        };
        let answer = |a: &Answered| {
            json!({
                "number": a.number, "person": a.person, "seat": a.seat, "time_s": round(a.time_s), "accepted": a.accepted,
                "text": a.text,
            })
        };
        let held: Vec<String> = self.held.iter().map(|f| name(Seat::Flight(*f))).collect();
        let mut state = json!({
            "seats": self.seats.iter().map(seat).collect::<Vec<_>>(),
            "pending": self.under_way.iter().map(pending).collect::<Vec<_>>(),
            "held": held,
            "advice": advice,
            "what_if": what_if,
            "targets": targets,
            "radio": self.radio.iter().map(radio).collect::<Vec<_>>(),
            "answers": self.answers.iter().map(answer).collect::<Vec<_>>(),
        });
        if state == self.shown {
            return None;
        }
        self.shown = state.clone();
        state["time_s"] = now_s.into();
        Some(state)
    }
}

/// Decides upon the advice of a flight: words, and what became of it.
fn decided(
    flight: u32,
    (callsign, kind, accept): (&str, Kind, bool),
    advisor: &mut Option<Advisor>,
) -> Result<(String, advice::Change), String> {
    let advisor = advisor.as_mut().ok_or("this scene gives no advice: [control] advice = true")?;
    let decision = if accept { Decision::Accepted } else { Decision::Refused };
    let change =
        advisor.decide(kind, flight, decision, true).map_err(|why| format!("{callsign}: {why}"))?;
    Ok((format!("{callsign}: {} {}", kind.word(), decision.word()), change))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whom_the_model_held_a_person_can_let_taxi() {
        let mut people = People::new(vec![Seat::Ground], 0.05);
        people.known.insert(4, 0);
        let nobody = Asked { wanted: &[], could: &[] };
        let may = |people: &People| people.possible(4, "AB1", ClearanceKind::Taxi, nobody).is_ok();
        assert!(!may(&people), "he holds for nobody");
        let said =
            |kind| Given { seat: Seat::Ground, flight: 4, kind, acts_s: 1.0, by_person: false };
        people.given(&said(ClearanceKind::Hold));
        assert!(may(&people));
        people.given(&said(ClearanceKind::Taxi));
        assert!(!may(&people), "he taxies");
    }
}
