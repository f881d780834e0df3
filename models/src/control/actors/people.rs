//! People at controllers' seats: the model of a taken seat decides nothing, what its person says goes over the same
//! frequency and is read back by the same pilots.

use super::message::Seat;
use super::{Actors, Given, Wanted};

/// Why a clearance cannot be said now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unsaid {
    /// What was said to this flight before has not been acted upon.
    #[error("was told something just now: wait until it has read back and begun")]
    UnderWay,
    /// So much waits for its turn on the frequency.
    #[error("cannot be reached: the frequency is in use for another minute")]
    FrequencyFull,
}

/// Longest time that a clearance may wait for the frequency, s.
const MOST_AHEAD_S: f64 = 60.0;

impl Actors {
    /// A person sits down: from now on the model of this seat says nothing.
    pub fn take(&mut self, seat: Seat) {
        self.taken.insert(seat);
    }

    /// The model decides again.
    pub fn give_up(&mut self, seat: Seat) {
        self.taken.remove(&seat);
    }

    /// Whether the model of a seat says nothing: a person has it, or is awaited there.
    #[must_use]
    pub fn is_taken(&self, seat: Seat) -> bool {
        self.taken.contains(&seat)
    }

    /// What the person at a seat says at a time, s: spoken when the frequency is free, read back, acted upon. `None`: it was
    /// misheard and nobody noticed.
    ///
    /// # Errors
    /// Where it cannot be said now.
    pub fn say(&mut self, at_s: f64, seat: Seat, what: Wanted) -> Result<Option<Given>, Unsaid> {
        self.told.retain(|_, until_s| *until_s > at_s);
        // Said by the model before the person came: read back, not acted upon.
        let by_model = self.talks.get(&what.flight).map(|t| t.said_until_s - self.habits.again_s);
        if self.told.contains_key(&what.flight) || by_model.is_some_and(|until_s| until_s > at_s) {
            return Err(Unsaid::UnderWay);
        }
        let on_air = self.positions.get(&seat).map_or(at_s, |p| p.on_air_until_s);
        if on_air > at_s + MOST_AHEAD_S {
            return Err(Unsaid::FrequencyFull);
        }
        let (given, acts_s) = self.clear(at_s, seat, what, None);
        self.told.insert(what.flight, acts_s);
        Ok(given)
    }
}

#[cfg(test)]
mod tests {
    use super::super::pilot::Habits;
    use super::*;
    use crate::control::actors::message::MessageKind;
    use crate::control::clearance::ClearanceKind::{Push, Taxi};

    const FRAME_S: f64 = 0.05;

    fn wants(flight: u32) -> Wanted {
        Wanted { flight, kind: Taxi, group: 0 }
    }

    #[test]
    fn the_model_of_a_taken_seat_says_nothing_until_it_is_given_up() {
        let mut actors = Actors::new(Habits::default(), 5, FRAME_S);
        actors.take(Seat::Ground);
        let all = [Wanted { flight: 1, kind: Push, group: 0 }, wants(2)];
        let mut given = Vec::new();
        for second in 0..120 {
            given.extend(actors.scan(f64::from(second), &all));
        }
        assert!(!given.is_empty() && given.iter().all(|g| g.seat == Seat::Apron), "{given:?}");
        // Its pilots call it all the same.
        let calls = |m: &&super::super::Message| m.from == Seat::Flight(2);
        assert_eq!(actors.messages().filter(calls).count(), 1);
        actors.give_up(Seat::Ground);
        let later = (120..130).find_map(|s| actors.scan(f64::from(s), &all[1..]).first().copied());
        assert_eq!(later.map(|g| (g.seat, g.flight)), Some((Seat::Ground, 2)));
    }

    #[test]
    fn a_person_is_read_back_on_the_frequency_of_his_seat_and_repeats_nothing_meanwhile() {
        let mut actors = Actors::new(Habits::default(), 5, FRAME_S);
        actors.take(Seat::Ground);
        let first = actors.say(10.0, Seat::Ground, wants(1)).expect("said").expect("heard");
        assert_eq!(actors.say(11.0, Seat::Ground, wants(1)), Err(Unsaid::UnderWay));
        let second = actors.say(11.0, Seat::Ground, wants(2)).expect("said").expect("heard");
        // Two clearances and two readbacks of 5.7 s each, one after the other, and no time to think.
        assert!(first.acts_s > 10.0 + 11.4 && first.acts_s < 40.0, "{first:?}");
        assert!(second.acts_s > 10.0 + 22.8, "{second:?}");
        let kinds: Vec<MessageKind> = actors.messages().map(|m| m.kind).collect();
        assert_eq!(kinds[..2], [MessageKind::Clearance, MessageKind::Readback]);
        let until = first.acts_s;
        assert!(actors.say(until + 0.1, Seat::Ground, wants(1)).is_ok(), "he may say it again");
        // The frequency is no store.
        let refused = (3..40).map(|n| actors.say(until + 1.0, Seat::Ground, wants(n)));
        assert_eq!(refused.last(), Some(Err(Unsaid::FrequencyFull)));
    }
}
