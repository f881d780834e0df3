//! Flights drawn by rates, with stands for all of them.

use super::Wanted;
use super::drawn::{Drawn, Mix, of_mix};
use super::ends::{Ends, by_the_wind};
use super::rates::Rates;
use super::reach::{Ground, end_named, lacks_m};
use super::stands::{Allotted, allotted};
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use crate::types::TypeTable;
use models::draw::{DrawKey, Purpose, exponential, normal_pair, uniform};
use models::traffic::core::Direction;
use models::traffic::network::code_of_span;

/// When a demand begins whose scene states no time: 2026-01-01T06:00:00Z (assumed).
pub(super) const GENERATED_START_NS: i64 = 1_767_247_200_000_000_000;

/// Types of a demand that names none, with weights, and what comes instead where the runways are too short for all of them.
const USUAL_MIX: [(&str, f64); 4] = [("A320", 5.0), ("B738", 4.0), ("E190", 2.0), ("A333", 1.0)];
const SMALLER_MIXES: [&[(&str, f64)]; 2] = [
    &[("AT75", 3.0), ("DH8D", 2.0), ("E145", 1.0), ("C550", 2.0)],
    &[("C550", 1.0), ("C172", 4.0)],
];

fn owned(mix: &[(&str, f64)]) -> Mix {
    mix.iter().map(|(d, w)| ((*d).to_owned(), *w)).collect()
}

/// Flights by rates: draws belong to a flight's number, so that another rate keeps who they are. Numbers go on from `first`, those
/// that sections before it have; with them those after it.
pub(super) fn generated(
    (section, first): (&Section, &mut u64),
    run: &Run,
    ground: &Ground<'_>,
    in_use: &[Vec<String>; 2],
    types: &TypeTable,
    (remarks, left_out): (&mut Vec<String>, &mut Vec<String>),
) -> Result<Vec<Wanted>, ScenarioError> {
    let network = ground.network;
    let seed = section.integer("seed", 0, i64::MAX)?.map_or(run.seed, |s| s as u64);
    let profiles =
        [("poisson", Profile::Drawn), ("even", Profile::Even), ("banks", Profile::Banks)];
    let profile = section.choice("profile", &profiles)?.unwrap_or(Profile::Drawn);
    let banks = profile == Profile::Banks;
    let arrivals = Rates::read(section, "arrivals_per_h", Direction::Arrival, banks)?;
    let departures = Rates::read(section, "departures_per_h", Direction::Departure, banks)?;
    let turnaround_min = section.number("turnaround_min", within(10.0, 1440.0, "min"))?;
    let mut mix: Vec<(String, f64)> = Vec::new();
    if let Some(table) = section.any_section("mix")? {
        for designator in table.keys() {
            let weight = table.need_number(designator, within(0.0, 1e6, ""))?;
            if types.get(designator).is_none_or(|t| !t.class.aircraft) {
                let allowed = types.designators().collect::<Vec<_>>().join(", ");
                let found = designator.into();
                return Err(table.refuse(designator, Problem::NotAllowed { found, allowed }));
            }
            mix.push((designator.to_owned(), weight));
        }
        if mix.iter().all(|m| m.1 <= 0.0) {
            let found = if mix.is_empty() { "no type" } else { "weights of 0 only" }.to_owned();
            let needed = "a type with a weight above 0; without the key, the usual mix".to_owned();
            return Err(section.refuse("mix", Problem::WrongKind { found, needed }));
        }
    }
    let drawn_mix = mix.is_empty();
    if drawn_mix {
        mix = owned(&USUAL_MIX);
    }
    let named = |key: &str, known: &[String]| -> Result<Vec<String>, ScenarioError> {
        let given: Vec<String> = section.texts(key)?.into_iter().map(|(n, _)| n).collect();
        if let Some(found) = given.iter().find(|n| end_named(network, n).is_none()) {
            let ends = network.runways.iter().flat_map(|r| r.names.iter().map(String::as_str));
            let allowed = crate::document::one_of(found, &ends.collect::<Vec<_>>());
            return Err(section.refuse(key, Problem::NotAllowed { found: found.clone(), allowed }));
        }
        Ok(if given.is_empty() { known.to_vec() } else { given })
    };
    let landing = named("arrival_runways", &in_use[0])?;
    let leaving = named("departure_runways", &in_use[1])?;
    let owned_smaller = SMALLER_MIXES.map(owned);
    let mixes = std::iter::once(&mix).chain(owned_smaller.iter().filter(|_| drawn_mix));
    let known = |(d, weight): &(String, f64)| Some((types.get(d)?, *weight));
    let mixes: Vec<Vec<_>> = mixes.map(|mix| mix.iter().filter_map(known).collect()).collect();
    let ends = by_the_wind(ground, [&landing, &leaving], &mixes, run.duration.s());
    let usable: Vec<usize> = (0..network.stands.len())
        .filter(|s| network.stands[*s].node.is_some_and(|n| network.nodes[n].used))
        .collect();
    let none = |of: fn(&Ends) -> &Vec<String>| ends.iter().any(|e| of(e).is_empty());
    let no_end = arrivals.any() && none(|e| &e.landing) || departures.any() && none(|e| &e.leaving);
    if no_end || usable.is_empty() {
        let runway = no_end.then_some("no runway with entries and exits");
        let stand = usable.is_empty().then_some("no stand with a way");
        let missing = runway.into_iter().chain(stand);
        let found = missing.chain(network.findings.iter().map(String::as_str));
        let found = found.collect::<Vec<_>>().join("; ");
        let needed = "a runway with entries and exits, and stands with a way".into();
        return Err(section.refuse("kind", Problem::WrongKind { found, needed }));
    }
    let lacks = |designator: &str| {
        types.get(designator).map_or(0.0, |row| {
            let of = |e: &Ends| {
                let none: &[String] = &[];
                let landing = if arrivals.any() { &e.landing } else { none };
                let leaving = if departures.any() { &e.leaving } else { none };
                lacks_m(&ground.in_wind_at(e.from_s), row, landing, leaving)
            };
            ends.iter().map(of).fold(0.0, f64::max)
        })
    };
    // Nobody asked for airliners: where none fits, smaller ones come; the smallest are those that are told of where nothing does.
    let fits =
        |mix: &[(String, f64)]| mix.iter().any(|m| types.get(&m.0).is_some() && lacks(&m.0) <= 0.0);
    if drawn_mix && !fits(&mix) {
        for smaller in SMALLER_MIXES {
            mix = owned(smaller);
            if fits(&mix) {
                break;
            }
        }
    }
    let too_long = mix.iter().filter(|m| lacks(&m.0) > 0.0).map(|m| m.0.clone());
    let too_long = too_long.collect::<Vec<_>>().join(", ");
    let least = mix.iter().map(|m| lacks(&m.0)).fold(f64::INFINITY, f64::min);
    if least > 0.0 {
        let names: std::collections::BTreeSet<&str> = ends
            .iter()
            .flat_map(|e| e.landing.iter().chain(&e.leaving))
            .map(String::as_str)
            .collect();
        let names = names.into_iter().collect::<Vec<_>>().join(", ");
        let found = format!(
            "{too_long}, each {least:.0} m or more short of exits and entries with a way to a stand"
        );
        let needed = format!("a mix with a type that runway {names} is long enough for");
        return Err(section.refuse("mix", Problem::WrongKind { found, needed }));
    }
    mix.retain(|m| (!drawn_mix || types.get(&m.0).is_some()) && lacks(&m.0) <= 0.0);
    if !too_long.is_empty() {
        remarks.push(format!(
            "{too_long}: left out, the runways are too short for them or too narrow to turn on"
        ));
    }
    let usable_mix = |mix: &[(String, f64)]| -> Vec<(String, f64)> {
        let fits = |m: &&(String, f64)| types.get(&m.0).is_some() && lacks(&m.0) <= 0.0;
        mix.iter().filter(fits).cloned().collect()
    };
    let smaller: Vec<Vec<(String, f64)>> = match drawn_mix {
        true => SMALLER_MIXES.iter().map(|mix| usable_mix(&owned(mix))).collect(),
        false => Vec::new(),
    };
    let mut drawn: Vec<Drawn> = Vec::new();
    for e in &ends[1..] {
        let both = [&e.landing, &e.leaving].map(|names| names.join(", "));
        remarks.push(format!(
            "the wind turns: from {:.0} s on landings on {}, take-offs from {}",
            e.from_s, both[0], both[1]
        ));
    }
    let both_ways = arrivals.any() && departures.any();
    for e in ends.iter().filter(|_| both_ways) {
        remarks.extend(e.head_on(network).into_iter().map(|[landing, leaving]| {
            format!(
                "opposite ends: landings on {landing} come towards take-offs from {leaving}, about half as many are served (from {:.0} s on)",
                e.from_s
            )
        }));
    }
    let kinds = [(Direction::Arrival, &arrivals), (Direction::Departure, &departures)];
    for (kind, (direction, rates)) in kinds.into_iter().enumerate() {
        if !rates.any() {
            continue;
        }
        let mut time_s = if direction == Direction::Arrival { 260.0 } else { 30.0 };
        for number in *first..MOST {
            let key = DrawKey { run_seed: seed, sensor: 1 + kind as u32, entity: number, scan: 0 };
            let mut rng = key.rng(Purpose::Mover);
            let gap = if profile == Profile::Even { 1.0 } else { exponential(&mut rng) };
            time_s = rates.after_s(time_s, gap, run.duration.s());
            if time_s > run.duration.s() {
                break;
            }
            let designator = of_mix(&mix, uniform(&mut rng)).unwrap_or("A320");
            let place = uniform(&mut rng);
            let code = types.get(designator).map(|t| code_of_span(t.class.span_m));
            let (mean_min, sigma_min, least_min) = match (turnaround_min, code) {
                (Some(mean_min), _) => (mean_min, 0.25 * mean_min, 0.7 * mean_min),
                (None, Some(0..=2) | None) => (48.0, 12.0, 35.0),
                (None, _) => (95.0, 15.0, 35.0),
            };
            let drawn_min: f64 = mean_min + sigma_min * normal_pair(&mut rng).0;
            let turn_round_s = 60.0 * drawn_min.max(least_min);
            let (runways, at_s) = match direction {
                Direction::Arrival => {
                    let (ends, at_s) = Ends::of_landing(&ends, time_s);
                    (&ends.landing, at_s)
                }
                _ => (&Ends::of_leaving(&ends, time_s).leaving, time_s),
            };
            drawn.push(Drawn {
                number,
                direction,
                time_s: at_s,
                designator: designator.to_owned(),
                runway: runways[(number - *first) as usize % runways.len()].clone(),
                place,
                turn_round_s,
                other: uniform(&mut rng),
            });
        }
    }
    for ((direction, rates), of) in kinds.into_iter().zip(["arrivals", "departures"]) {
        if rates.any() && *first >= MOST {
            left_out.push(format!(
                "{of} of a section are left out: none of {MOST} numbers is left behind those of the sections before"
            ));
        }
        if drawn.iter().any(|d| d.direction == direction && d.number + 1 == MOST) {
            left_out.push(format!("{of} after the first {MOST} are left out: no more are drawn"));
        }
    }
    *first = drawn.iter().map(|d| d.number + 1).max().unwrap_or(*first);
    let count = drawn.len();
    let allotted = allotted(ground, types, &usable, drawn, &smaller);
    let (wanted, none) = on_stands(section.line_of("kind"), ground, &allotted);
    if none > 0 {
        left_out.push(format!(
            "{none} of {count} drawn flights are left out: no stand is free for them"
        ));
    }
    Ok(wanted)
}

/// Flights that are drawn of a direction, at most: a scene has as many movers.
const MOST: u64 = 60_000;

/// How times are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Profile {
    Drawn,
    Even,
    Banks,
}

/// The flights that have a stand, and how many have none.
fn on_stands(
    line: usize,
    ground: &Ground<'_>,
    Allotted { drawn, comes_as, stand_of }: &Allotted,
) -> (Vec<Wanted>, usize) {
    let name = |d: &Drawn| {
        let letter = if d.direction == Direction::Arrival { "A" } else { "D" };
        format!("G{letter}{:04}", d.number + 1)
    };
    let wanted = drawn.iter().enumerate().filter_map(|(i, d)| {
        let aircraft = comes_as[i].unwrap_or(i);
        let kind = u32::from(d.direction == Direction::Departure);
        Some(Wanted {
            line,
            callsign: name(d),
            address: Some(0x50_0000 + kind * 0x1_0000 + d.number as u32 + 1),
            designator: drawn[aircraft].designator.clone(),
            direction: d.direction,
            runway: d.runway.clone(),
            stand: ground.network.stands[stand_of[aircraft]?].name.clone(),
            time_s: d.time_s,
            ctot_s: None,
            turnaround_of: comes_as[i].map(|a| name(&drawn[a])),
        })
    });
    let wanted: Vec<Wanted> = wanted.collect();
    let left_out = drawn.len() - wanted.len();
    (wanted, left_out)
}
