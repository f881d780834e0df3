//! Measures of the traffic of a run, from truth (traffic.md 10).

use super::core::{Core, Direction, Measures};
use super::delivered::{
    Separations, keeps_slot, keeps_start_up, of_landings, of_take_offs, take_off_delay_s,
};
use crate::score::robust::quantile;

/// A measure with its unit; empty for a count.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Its name; that of a runway's ends with the name of its end.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// Carbon dioxide of a kilogram of fuel, kg.
const CO2: f64 = 3.16;
/// The hour and the quarter of an hour in which most movements are counted, s.
const SPANS: [(&str, f64); 2] = [("peak_hour", 3600.0), ("peak_quarter", 900.0)];

/// What a core has done up to now: service, taxi times, stops, delays, slots kept, fuel, and by runway end movements, the most of them
/// within an hour and a quarter of one, how long a movement had it, and how far beyond what is needed one was behind the other. Means
/// are absent where nothing was measured.
#[must_use]
pub fn measured(core: &Core) -> Vec<Measured> {
    let mut out = Vec::new();
    let mut put = |name: &str, value: f64, unit: &'static str| {
        // The sum of no numbers is −0.
        out.push(Measured { name: name.to_owned(), value: value + 0.0, unit });
    };
    let flights: Vec<usize> = (0..core.flights().len())
        .filter(|f| core.flights()[*f].direction != Direction::Vehicle && !core.is_free_place(*f))
        .collect();
    let of = |direction: Direction| {
        let flights = flights.iter().copied();
        flights.filter(move |f| core.flights()[*f].direction == direction)
    };
    let [arrivals, departures] = [Direction::Arrival, Direction::Departure]
        .map(|direction| of(direction).map(|f| core.measures(f)).collect::<Vec<_>>());
    let all: Vec<_> = arrivals.iter().chain(&departures).copied().collect();
    put("served", core.measures_of_served() as f64, "");
    put("flights", flights.len() as f64, "");
    put("unexpected_deadlocks", core.unexpected_deadlocks() as f64, "");
    put("go_arounds", all.iter().map(|m| f64::from(m.go_arounds)).sum(), "");
    let fuel_kg: f64 = all.iter().map(|m| m.fuel_kg).sum();
    let leaving = || of(Direction::Departure).map(|f| (&core.flights()[f], core.measures(f)));
    let percent = |kept: bool| if kept { 100.0 } else { 0.0 };
    let kept = mean(leaving().filter_map(|(f, m)| keeps_slot(f, m)).map(percent));
    let take_off_delay = mean(leaving().filter_map(|(f, m)| take_off_delay_s(f, m)));
    let start_ups =
        mean(of(Direction::Departure).filter_map(|f| keeps_start_up(core, f)).map(percent));
    let added = |of: &[&Measures]| {
        let mut added: Vec<f64> = of.iter().filter_map(|m| m.additional_s()).collect();
        added.sort_by(f64::total_cmp);
        added
    };
    let [added_in, added_out] = [added(&arrivals), added(&departures)];
    let taxied = || all.iter().filter(|m| m.taxi_s.is_some());
    let means = [
        ("taxi_mean", mean(all.iter().filter_map(|m| m.taxi_s)), "s"),
        ("taxi_out_mean", mean(departures.iter().filter_map(|m| m.taxi_s)), "s"),
        ("taxi_in_mean", mean(arrivals.iter().filter_map(|m| m.taxi_s)), "s"),
        ("additional_mean", mean(all.iter().filter_map(|m| m.additional_s())), "s"),
        ("taxi_out_additional_mean", mean(added_out.iter().copied()), "s"),
        ("taxi_out_additional_95_percent", quantile(&added_out, 0.95), "s"),
        ("taxi_in_additional_mean", mean(added_in.iter().copied()), "s"),
        ("taxi_in_additional_95_percent", quantile(&added_in, 0.95), "s"),
        ("stops_mean", mean(taxied().map(|m| f64::from(m.stops))), ""),
        ("stopped_mean", mean(taxied().map(|m| m.stopped_s)), "s"),
        ("off_block_delay_mean", mean(delays_s(core, of(Direction::Departure), true)), "s"),
        ("take_off_delay_mean", take_off_delay, "s"),
        ("landing_delay_mean", mean(delays_s(core, of(Direction::Arrival), false)), "s"),
        ("slots_kept", kept, "%"),
        ("start_ups_kept", start_ups, "%"),
    ];
    for (name, value, unit) in means {
        if let Some(value) = value {
            put(name, value, unit);
        }
    }
    put("fuel", fuel_kg, "kg");
    put("co2", CO2 * fuel_kg, "kg");
    for (r, runway) in core.network().runways.iter().enumerate() {
        for (end, name) in runway.names.iter().enumerate() {
            let here = |f: &usize| core.flights()[*f].runway == (r, end);
            let landed =
                of(Direction::Arrival).filter(here).filter_map(|f| core.measures(f).aldt_s);
            let left =
                of(Direction::Departure).filter(here).filter_map(|f| core.measures(f).atot_s);
            let (landed, left) = (landed.collect::<Vec<_>>(), left.collect::<Vec<_>>());
            let on = |direction| of(direction).filter(here).collect::<Vec<_>>();
            if landed.is_empty() && left.is_empty() {
                continue;
            }
            put(&format!("landings {name}"), landed.len() as f64, "");
            put(&format!("take_offs {name}"), left.len() as f64, "");
            let mut times_s = [landed, left].concat();
            times_s.sort_by(f64::total_cmp);
            for (what, span_s) in SPANS {
                put(&format!("{what} {name}"), most_within(&times_s, span_s) as f64, "");
            }
            let separated = [
                ("landing", of_landings(core, &on(Direction::Arrival))),
                ("take_off", of_take_offs(core, &on(Direction::Departure))),
            ];
            for (what, found) in separated {
                let Some(Separations { mean_surplus_s, violations }) = found else { continue };
                put(&format!("{what}_surplus_mean {name}"), mean_surplus_s, "s");
                put(&format!("{what}s_too_close {name}"), violations as f64, "");
            }
            let kinds = [("landing", Direction::Arrival), ("take_off", Direction::Departure)];
            for (what, direction) in kinds {
                let occupied = of(direction).filter(here).filter_map(|f| occupied_s(core, f));
                if let Some(value) = mean(occupied) {
                    put(&format!("{what}_occupancy_mean {name}"), value, "s");
                }
            }
        }
    }
    out
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), v| (sum + v, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Off-block or landing after the time that was wanted, s.
fn delays_s(
    core: &Core,
    flights: impl Iterator<Item = usize>,
    departs: bool,
) -> impl Iterator<Item = f64> {
    flights.filter_map(move |f| {
        let m = core.measures(f);
        let actual = if departs { m.aobt_s } else { m.aldt_s };
        Some(actual? - core.flights()[f].time_s)
    })
}

/// How long a movement was on its runway, s: a landing from over the threshold until its tail was beyond the line, a departure from over
/// the line until it was airborne.
fn occupied_s(core: &Core, flight: usize) -> Option<f64> {
    let [from_s, to_s] = core.measures(flight).on_runway_s;
    Some(to_s? - from_s?)
}

/// The most of some ascending times within a span, s.
fn most_within(times_s: &[f64], span_s: f64) -> usize {
    let (mut first, mut most) = (0, 0);
    for (last, time_s) in times_s.iter().enumerate() {
        while time_s - times_s[first] >= span_s {
            first += 1;
        }
        most = most.max(last + 1 - first);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_the_most_in_any_span_that_begins_with_a_movement() {
        let times_s = [0.0, 100.0, 899.0, 900.0, 1000.0, 3599.0, 3600.0, 3700.0];
        for span_s in [1.0, 101.0, 900.0, 3600.0, 1e9] {
            let of =
                |from: &f64| times_s.iter().filter(|t| *t >= from && **t < from + span_s).count();
            let most = times_s.iter().map(of).max().unwrap_or(0);
            assert_eq!(most_within(&times_s, span_s), most, "{span_s} s");
        }
        assert_eq!(most_within(&[], 60.0), 0);
    }

    #[test]
    fn nothing_is_measured_as_nought_and_not_as_less() {
        use crate::airport::Airport;
        use crate::traffic::core::{Core, Policy};
        use crate::traffic::network::Network;
        use crate::traffic::pieces::Pieces;
        use std::sync::Arc;
        let network = Network::of(&Airport::default());
        let pieces = Pieces::of(&network, &Core::classes(&[]));
        let flights = Arc::new(Vec::new());
        let core = Core::new(Arc::new(network), Arc::new(pieces), flights, Policy::Planned, 7, 0.2);
        let found = measured(&core);
        assert!(found.iter().any(|m| m.name == "fuel") && found.len() > 3);
        for Measured { name, value, .. } in found {
            assert!(value.is_sign_positive(), "{name}: {value}");
        }
    }
}
