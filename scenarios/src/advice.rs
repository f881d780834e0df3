//! The departures of a scene as a planner of advice knows them: their flight plans.

use crate::control::Separation;
use crate::schedule::Behaving;
use models::control::advice::{Departing, expected_taxi_out_s};
use models::control::departures::{Departures, Habits};
use models::traffic::core::{Direction, Flight};

impl Behaving {
    /// The departure manager, where departures leave their stands by a sequence.
    #[must_use]
    pub fn departure_manager(&self) -> Option<Departures> {
        let icao = self.wake == Separation::Icao;
        let habits = Habits { shift: self.shift?, icao, ..Habits::default() };
        Some(Departures::new(habits, self.departing()))
    }

    /// The departures as their flight plans have them, for advice.
    #[must_use]
    pub fn departing(&self) -> Vec<Departing> {
        let departure = |(at, f): (usize, &Flight)| {
            let (runway, end) = f.runway;
            let stand_m = self.network.stands[f.stand].at_m;
            let begin_m = self.network.runways[runway].ends_m[end];
            let wants = |o: &&Flight| {
                o.direction == Direction::Arrival && o.stand == f.stand && o.time_s > f.time_s
            };
            let next = self.flights.iter().filter(wants).map(|o| o.time_s);
            Departing {
                flight: at as u32,
                runway,
                wake: f.wake,
                tobt_s: f.time_s,
                exot_s: expected_taxi_out_s((stand_m - begin_m).norm()),
                stand_wanted_s: next.reduce(f64::min),
                ctot_s: f.ctot_s,
            }
        };
        let all = self.flights.iter().enumerate();
        all.filter(|(_, f)| f.direction == Direction::Departure).map(departure).collect()
    }
}
