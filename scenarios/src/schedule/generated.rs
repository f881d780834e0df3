//! Flights drawn by rates, with stands for all of them.

use super::rates::Rates;
use super::reach::{Ground, Reach, default_ends, end_named, lacks_m, needs_m};
use super::{ARE_LEFT_OUT, Wanted};
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use crate::types::TypeTable;
use models::airport::distance_to_segment_m;
use models::draw::{DrawKey, Purpose, exponential, normal_pair, uniform};
use models::frames::{Azimuth, Point2, Vector2, center};
use models::traffic::core::Direction;
use models::traffic::network::code_of_span;
use models::traffic::outline::{Rectangle, Size, distance_m, outline};
use std::collections::BTreeMap;

/// When a demand begins whose scene states no time: 2026-01-01T06:00:00Z (assumed).
pub(super) const GENERATED_START_NS: i64 = 1_767_247_200_000_000_000;

/// Types of a demand that names none, with weights, and what comes instead where the runways are too short for all of them.
const USUAL_MIX: [(&str, f64); 4] = [("A320", 5.0), ("B738", 4.0), ("E190", 2.0), ("A333", 1.0)];
const SMALLER_MIXES: [&[(&str, f64)]; 2] = [
    &[("AT75", 3.0), ("DH8D", 2.0), ("E145", 1.0), ("C550", 2.0)],
    &[("C550", 1.0), ("C172", 4.0)],
];

/// Types with weights.
type Mix = Vec<(String, f64)>;

fn owned(mix: &[(&str, f64)]) -> Mix {
    mix.iter().map(|(d, w)| ((*d).to_owned(), *w)).collect()
}

/// Flights by rates: draws belong to a flight's number, so that another rate keeps who they are.
pub(super) fn generated(
    section: &Section,
    run: &Run,
    ground: &Ground<'_>,
    (in_use, wind_mps): (&[Vec<String>; 2], Vector2<f64>),
    types: &TypeTable,
    remarks: &mut Vec<String>,
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
    }
    let drawn_mix = mix.iter().all(|m| m.1 <= 0.0);
    if drawn_mix {
        mix = owned(&USUAL_MIX);
    }
    let named = |key: &str, known: &[String]| -> Result<Vec<String>, ScenarioError> {
        let given: Vec<String> = section.texts(key)?.into_iter().map(|(n, _)| n).collect();
        Ok(if given.is_empty() { known.to_vec() } else { given })
    };
    let mut landing = named("arrival_runways", &in_use[0])?;
    let mut leaving = named("departure_runways", &in_use[1])?;
    if landing.is_empty() || leaving.is_empty() {
        let smaller = SMALLER_MIXES.map(owned);
        let mixes = std::iter::once(&mix).chain(smaller.iter().filter(|_| drawn_mix));
        let known = |(d, weight): &(String, f64)| Some((types.get(d)?, *weight));
        let mixes: Vec<Vec<_>> = mixes.map(|mix| mix.iter().filter_map(known).collect()).collect();
        let [lands, leaves] = default_ends(ground, wind_mps, [&landing, &leaving], &mixes);
        landing = if landing.is_empty() { lands } else { landing };
        leaving = if leaving.is_empty() { leaves } else { leaving };
    }
    let usable: Vec<usize> = (0..network.stands.len())
        .filter(|s| network.stands[*s].node.is_some_and(|n| network.nodes[n].used))
        .collect();
    let no_end = arrivals.any() && landing.is_empty() || departures.any() && leaving.is_empty();
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
            let none: &[String] = &[];
            let landing = if arrivals.any() { &landing } else { none };
            lacks_m(ground, row, landing, if departures.any() { &leaving } else { none })
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
        let ends: std::collections::BTreeSet<&str> =
            landing.iter().chain(&leaving).map(String::as_str).collect();
        let ends = ends.into_iter().collect::<Vec<_>>().join(", ");
        let found = format!(
            "{too_long}, each {least:.0} m or more short of exits and entries with a way to a stand"
        );
        let needed = format!("a mix with a type that runway {ends} is long enough for");
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
    let kinds =
        [(Direction::Arrival, &arrivals, landing), (Direction::Departure, &departures, leaving)];
    for (kind, (direction, rates, runways)) in kinds.into_iter().enumerate() {
        if !rates.any() {
            continue;
        }
        let mut time_s = if direction == Direction::Arrival { 260.0 } else { 30.0 };
        for number in 0..5000_u64 {
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
            drawn.push(Drawn {
                number,
                direction,
                time_s,
                designator: designator.to_owned(),
                runway: runways[number as usize % runways.len()].clone(),
                place,
                turn_round_s,
                other: uniform(&mut rng),
            });
        }
    }
    Ok(on_stands(section, ground, types, &usable, (drawn, &smaller), remarks))
}

/// The type of a mix at a draw within 0 to 1; `None` of none.
fn of_mix(mix: &[(String, f64)], draw: f64) -> Option<&str> {
    let total: f64 = mix.iter().map(|m| m.1).sum();
    let mut left = draw * total;
    let at = mix.iter().find(|m| {
        left -= m.1;
        left <= 0.0
    });
    at.map(|m| m.0.as_str())
}

/// How times are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Profile {
    Drawn,
    Even,
    Banks,
}

/// Index of the code letter from which on a type is an airliner: C.
const AIRLINER_CODE: u8 = 2;

/// A flight by rates, before it has a stand.
#[derive(Clone)]
struct Drawn {
    number: u64,
    direction: Direction,
    time_s: f64,
    designator: String,
    runway: String,
    /// Draw for its stand.
    place: f64,
    /// Of an arrival: from its landing to its earliest off-block, s.
    turn_round_s: f64,
    /// Draw for its type where no stand is free for the first one.
    other: f64,
}

/// Stands for drawn flights: a departure is the turn-round of the first arrival that is ready, else of the first
/// population; nobody is put where somebody else is or beside whom there is no room. Who finds none comes as a type of the smaller
/// mixes, one after the other, where these get more flights onto stands, and is left out else.
fn on_stands(
    section: &Section,
    ground: &Ground<'_>,
    types: &TypeTable,
    usable: &[usize],
    (mut drawn, smaller): (Vec<Drawn>, &[Mix]),
    remarks: &mut Vec<String>,
) -> Vec<Wanted> {
    let network = ground.network;
    let size_of = |d: &Drawn| {
        let (length_m, span_m) =
            types.get(&d.designator).map_or((37.6, 35.8), |t| (t.class.length_m, t.class.span_m));
        Size { length_m, span_m, aircraft: true }
    };
    let heading = |s: usize| {
        let node = network.stands[s].node?;
        let edge = network.edges.iter().find(|e| e.nodes.contains(&node))?;
        let from = edge.nodes[usize::from(edge.nodes[0] == node)];
        let at_m = network.nodes[node].at_m;
        Some((at_m, Azimuth::of(at_m - network.nodes[from].at_m).rad()))
    };
    let poses: Vec<_> = (0..network.stands.len()).map(heading).collect();
    // Stands by runway end, type and direction: by exits and entries with enough of the runway, where there are such.
    let mut known: BTreeMap<(String, String, bool), [Vec<bool>; 2]> = BTreeMap::new();
    // Stands that are reached, and those of them that are reached without taxiing along another runway.
    let mut reach = |name: &str, designator: &str, arrival: bool| -> [Vec<bool>; 2] {
        let key = (name.to_owned(), designator.to_owned(), arrival);
        let found = known.entry(key).or_insert_with(|| {
            let (Some(end), Some(row)) = (end_named(network, name), types.get(designator)) else {
                return [(); 2].map(|()| vec![true; network.stands.len()]);
            };
            let (reach, code) = (Reach::of(ground, end, arrival), code_of_span(row.class.span_m));
            let least_m = needs_m(row, &reach, end.1) - 1.0;
            let stands = reach.stands(code, least_m);
            let (stands, least_m) = match stands.contains(&true) {
                true => (stands, least_m),
                false => (reach.stands(code, 0.0), 0.0),
            };
            [stands, reach.stands_off_runways(code, least_m)]
        });
        found.clone()
    };
    let widest_m = drawn.iter().map(|d| size_of(d).span_m).fold(36.0, f64::max);
    // Who leaves as whose turn-round: the first that is ready.
    let mut order: Vec<usize> = (0..drawn.len()).collect();
    order.sort_by(|a, b| drawn[*a].time_s.total_cmp(&drawn[*b].time_s).then(a.cmp(b)));
    let mut leaves_as: Vec<Option<usize>> = vec![None; drawn.len()];
    let mut comes_as: Vec<Option<usize>> = vec![None; drawn.len()];
    for d in order.iter().filter(|d| drawn[**d].direction == Direction::Departure) {
        let ready = order.iter().copied().find(|a| {
            drawn[*a].direction == Direction::Arrival
                && leaves_as[*a].is_none()
                && drawn[*a].time_s + 480.0 + drawn[*a].turn_round_s <= drawn[*d].time_s
        });
        if let Some(a) = ready {
            (leaves_as[a], comes_as[*d]) = (Some(*d), Some(a));
        }
    }
    // Whether somebody of a size on a stand leaves the lanes free.
    let taxiways = network.edges.iter().filter(|e| network.is_taxiway(e));
    let lanes: Vec<([Point2<f64>; 2], u8)> =
        taxiways.map(|e| (e.nodes.map(|n| network.nodes[n].at_m), e.code)).collect();
    let mut clear_of: BTreeMap<(usize, u64, u64), bool> = BTreeMap::new();
    let mut allot = |drawn: &[Drawn], order: &[usize]| -> Vec<Option<usize>> {
        // Occupied: stand, from, to, size.
        let mut taken: Vec<(usize, f64, f64, Size)> = Vec::new();
        let mut stand_of: Vec<Option<usize>> = vec![None; drawn.len()];
        for i in order.iter().copied() {
            let d = &drawn[i];
            let size = size_of(d);
            let (from, to) = match (d.direction, leaves_as[i]) {
                (Direction::Departure, _) => (d.time_s - 2400.0, d.time_s + 900.0),
                (_, Some(next)) => (d.time_s - 300.0, drawn[next].time_s + 900.0),
                _ => (d.time_s - 300.0, f64::INFINITY),
            };
            let free = |s: usize| {
                let Some((at_m, heading_rad)) = poses[s] else { return false };
                taken.iter().all(|(other, begin, end, theirs)| {
                    if *begin >= to || *end <= from {
                        return true;
                    }
                    let Some((there, towards)) = poses[*other] else { return true };
                    *other != s
                        && ((there - at_m).norm() > 120.0
                            || distance_m(
                                &outline(size, at_m, heading_rad),
                                &outline(*theirs, there, towards),
                            ) > 4.0)
                })
            };
            let need = code_of_span(size.span_m);
            let [mut reached, mut off_runways] =
                reach(&d.runway, &d.designator, d.direction == Direction::Arrival);
            if let Some(next) = leaves_as[i] {
                let [left, off] = reach(&drawn[next].runway, &d.designator, false);
                reached.iter_mut().zip(left).for_each(|(r, l)| *r &= l);
                off_runways.iter_mut().zip(off).for_each(|(r, l)| *r &= l);
            }
            let fits = |s: usize| network.stands[s].code >= need && reached[s];
            let mut fitting: Vec<usize> =
                usable.iter().copied().filter(|s| fits(*s) && free(*s)).collect();
            // Airliners stand among light aircraft and helicopters only where nothing else is left.
            let usual = |s: &usize| need < AIRLINER_CODE || !network.stands[*s].light;
            if fitting.iter().any(usual) {
                fitting.retain(usual);
            }
            // Nobody taxies along a runway on which others land or take off, where there is an elsewhere.
            if fitting.iter().any(|s| off_runways[*s]) {
                fitting.retain(|s| off_runways[*s]);
            }
            // Who would close a lane goes elsewhere, where there is an elsewhere.
            let mut clear = |s: &usize| {
                let key = (*s, size.length_m.to_bits(), size.span_m.to_bits());
                *clear_of.entry(key).or_insert_with(|| {
                    poses[*s].is_some_and(|(at_m, heading_rad)| {
                        clear_of_lanes(&lanes, &outline(size, at_m, heading_rad), widest_m)
                    })
                })
            };
            if fitting.iter().any(&mut clear) {
                fitting.retain(clear);
            }
            if fitting.is_empty() {
                continue;
            }
            let stand = fitting[(d.place * fitting.len() as f64) as usize % fitting.len()];
            taken.push((stand, from, to, size));
            stand_of[i] = Some(stand);
        }
        stand_of
    };
    let by_time: Vec<usize> = order.iter().copied().filter(|i| comes_as[*i].is_none()).collect();
    let (mut first, landing): (Vec<usize>, Vec<usize>) =
        by_time.iter().partition(|i| drawn[**i].direction == Direction::Departure);
    first.extend(landing);
    let directions: Vec<Direction> = drawn.iter().map(|d| d.direction).collect();
    // How many have a stand, and the share of the direction that has less.
    let served = |stand_of: &[Option<usize>]| -> (usize, f64) {
        let of = |direction: Direction| {
            let all = || (0..directions.len()).filter(|i| directions[*i] == direction);
            let some = all().filter(|i| stand_of[comes_as[*i].unwrap_or(*i)].is_some()).count();
            (some, some as f64 / all().count().max(1) as f64)
        };
        let [arrivals, departures] = [Direction::Arrival, Direction::Departure].map(of);
        (arrivals.0 + departures.0, arrivals.1.min(departures.1))
    };
    let mut stand_of = allot(&drawn, &first);
    let all = drawn.len();
    // Where stands are few, the first population would take all of them, and nobody could land.
    if served(&stand_of).0 < all {
        let other = allot(&drawn, &by_time);
        if served(&other) > served(&stand_of) {
            stand_of = other;
        }
    }
    for mix in smaller {
        if served(&stand_of).0 == all {
            break;
        }
        let mut others = drawn.clone();
        for (i, d) in others.iter_mut().enumerate() {
            if stand_of[comes_as[i].unwrap_or(i)].is_none()
                && let Some(designator) = of_mix(mix, d.other)
            {
                designator.clone_into(&mut d.designator);
            }
        }
        for order in [&first, &by_time] {
            let other = allot(&others, order);
            if served(&other) > served(&stand_of) {
                stand_of = other;
                drawn.clone_from(&others);
            }
        }
    }
    let mut wanted = Vec::new();
    let mut left_out = 0;
    let name = |d: &Drawn| {
        let letter = if d.direction == Direction::Arrival { "A" } else { "D" };
        format!("G{letter}{:04}", d.number + 1)
    };
    for (i, d) in drawn.iter().enumerate() {
        let aircraft = comes_as[i].unwrap_or(i);
        let Some(stand) = stand_of[aircraft] else {
            left_out += 1;
            continue;
        };
        let kind = u32::from(d.direction == Direction::Departure);
        wanted.push(Wanted {
            line: section.line_of("kind"),
            callsign: name(d),
            address: Some(0x50_0000 + kind * 0x1_0000 + d.number as u32 + 1),
            designator: drawn[aircraft].designator.clone(),
            direction: d.direction,
            runway: d.runway.clone(),
            stand: network.stands[stand].name.clone(),
            time_s: d.time_s,
            turnaround_of: comes_as[i].map(|a| name(&drawn[a])),
        });
    }
    if left_out > 0 {
        remarks.push(format!(
            "{left_out} of {} drawn flights {ARE_LEFT_OUT}no stand is free for them",
            drawn.len()
        ));
    }
    wanted
}

/// Whether the widest of the demand can pass a parked outline on every lane that is wide enough for it.
fn clear_of_lanes(
    lanes: &[([Point2<f64>; 2], u8)],
    parked: &[Rectangle; 2],
    widest_m: f64,
) -> bool {
    let middle = center(&parked[0].corners_m[0], &parked[0].corners_m[2]);
    lanes.iter().all(|([a, b], code)| {
        let (a, b) = (*a, *b);
        if distance_to_segment_m(middle, a, b) > 80.0 {
            return true;
        }
        let line = Rectangle { corners_m: [a, b, b, a] };
        let span_m = if *code >= code_of_span(widest_m) { widest_m } else { 36.0 };
        distance_m(parked, &[line; 2]) > 0.5 * span_m + 3.0
    })
}
