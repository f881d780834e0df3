//! Flights with the wind from behind: ends that are named do not turn with it.

use crate::Scene;
use crate::schedule::TO_THE_END_S;
use models::frames::Azimuth;
use models::traffic::core::{Day, Direction};
use std::collections::BTreeMap;

/// Nobody wants more of the wind from behind, or from the side, m/s (`docs/traffic.md`; by type assumed equal).
const TAIL_MPS: f64 = 5.0;
const CROSS_MPS: f64 = 12.0;

/// What there is to say of the notice at a time, s: runway ends that flights use in its weather against the wind's limits.
pub(super) fn of(scene: &Scene, at_s: f64) -> Option<String> {
    let behaving = scene.traffic.behaving.as_ref()?;
    let index = scene.weather.iter().position(|n| n.time.s() == at_s)?;
    let until_s = scene.weather.get(index + 1).map_or(f64::INFINITY, |n| n.time.s());
    let day = Day::from(&scene.weather[index].weather);
    let mut ends: BTreeMap<&str, (usize, f64, f64)> = BTreeMap::new();
    for flight in behaving.flights.iter().filter(|f| f.direction != Direction::Vehicle) {
        let (r, end) = flight.runway;
        let runway = behaving.network.runways.get(r)?;
        let along = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]);
        let tail_mps = -day.head_mps(along);
        let cross_mps = (day.wind_mps.norm_squared() - tail_mps * tail_mps).max(0.0).sqrt();
        let beyond = tail_mps > TAIL_MPS || cross_mps > CROSS_MPS;
        let to_the_end_s =
            if flight.direction == Direction::Departure { TO_THE_END_S } else { 0.0 };
        if beyond && (at_s..until_s).contains(&(flight.time_s + to_the_end_s)) {
            ends.entry(&runway.names[end]).or_insert((0, tail_mps, cross_mps)).0 += 1;
        }
    }
    let told = ends.iter().map(|(end, (count, tail_mps, cross_mps))| {
        let (speed_mps, from) = match tail_mps > &TAIL_MPS {
            true => (tail_mps, "behind"),
            false => (cross_mps, "the side"),
        };
        format!("{count} flights use {end} with {speed_mps:.0} m/s from {from}")
    });
    let told = told.collect::<Vec<_>>().join(", ");
    (!told.is_empty()).then(|| {
        format!("{told}: ends that are named do not turn with the wind; leave arrival_runways and departure_runways out, or let this demand end and another begin, by rates of hours")
    })
}
