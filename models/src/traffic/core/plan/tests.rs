//! Times brought up to date by what is kept are those of the plain rule, to the bit: on airports, demands and delays drawn at random.

use super::order::Ends;
use super::*;
use crate::airport::{Airport, Edge, EdgeDetail, Hold, Node, Runway, Stand};
use crate::flight_list::WakeCategory;
use crate::frames::Point2;
use crate::traffic::core::{ClearedBy, Flight, Notice, Order, Policy};
use crate::traffic::network::Network;
use crate::traffic::outline::Size;
use crate::traffic::pieces::Pieces;
use proptest::prelude::*;
use std::sync::Arc;

/// A runway with a taxiway beside it, and lanes with stands behind that; `cross`: entries as shares of the runway.
fn airport(columns: usize, entries: &[f64], lanes: usize) -> Airport {
    let mut a = Airport { icao: "XTST".into(), ..Airport::default() };
    let length = 2600.0;
    let ends_m = [Point2::new(0.0, 0.0), Point2::new(length, 0.0)];
    let names = ["09", "27"].map(String::from);
    a.runways.push(Runway { names, ends_m, thresholds_m: ends_m, width_m: 45.0 });
    let node = |a: &mut Airport, x: f64, y: f64| {
        let name = format!("n{}", a.nodes.len());
        a.nodes.push(Node { name, position_m: Point2::new(x, y), hold: Hold::None });
        a.nodes.len() - 1
    };
    let edge = |a: &mut Airport, from: usize, to: usize| {
        let e = Edge { from, to, two_way: true, runway: false, name: "T".into(), width_m: 23.0 };
        a.edges.push(e);
        a.details.edges.push(EdgeDetail { code: Some('E'), zones: Vec::new() });
    };
    let mut row = Vec::new();
    for k in 0..columns {
        row.push(node(&mut a, length * k as f64 / (columns - 1) as f64, 180.0));
        if k > 0 {
            edge(&mut a, row[k - 1], row[k]);
        }
    }
    let nearest = |share: f64| (share * (columns - 1) as f64).round() as usize;
    let mut places: Vec<usize> = entries.iter().map(|e| nearest(*e)).collect();
    places.extend([0, columns - 1]);
    places.sort_unstable();
    places.dedup();
    for k in places {
        let x = (length * k as f64 / (columns - 1) as f64).clamp(5.0, length - 5.0);
        let foot = node(&mut a, x, 0.0);
        edge(&mut a, row[k], foot);
    }
    // Lanes away from the taxiway, with stands on both sides, some of them joined at their far ends.
    let mut far: Option<usize> = None;
    for lane in 0..lanes {
        let k = 1 + lane * (columns - 2) / lanes;
        let x = length * k as f64 / (columns - 1) as f64;
        let mut at = row[k];
        for i in 0..4 {
            let y = 300.0 + 70.0 * i as f64;
            let next = node(&mut a, x, y);
            edge(&mut a, at, next);
            at = next;
            for side in [-1.0, 1.0] {
                let place = node(&mut a, x + 75.0 * side, y);
                edge(&mut a, next, place);
                a.stands.push(Stand {
                    name: format!("S{}", a.stands.len()),
                    position_m: Point2::new(x + 75.0 * side, y),
                    heading_rad: side * std::f64::consts::FRAC_PI_2,
                    node: Some(place),
                });
            }
        }
        if let Some(far) = far.filter(|_| lane % 2 == 1) {
            edge(&mut a, far, at);
        }
        far = Some(at);
    }
    a
}

fn flight(k: usize, direction: Direction, stand: usize, time_s: f64, end: usize) -> Flight {
    Flight {
        callsign: format!("F{k}"),
        size: Size { length_m: 37.57, span_m: 35.8, aircraft: true },
        direction,
        runway: (0, end),
        stand,
        time_s,
        ctot_s: None,
        turnaround_of: None,
        wake: WakeCategory::Medium.into(),
        taxi_mps: (15.4, 5.1),
        taxi_acc_mps2: (0.7, 0.7),
        take_off: (75.0, 1700.0),
        landing: (70.0, 1.5),
        wheelbase_m: 12.6,
        idle_kg_per_s: 0.2,
        key: k as u64 + 1,
    }
}

/// Planned pushback, takes and fronts of a mover.
type Plain = (f64, Vec<f64>, Vec<f64>);

/// Ends of uses by piece: mover, class and what ends them.
type Users = Vec<Vec<(usize, u8, Ends)>>;

fn ends_s(t: &Timing, (push_s, _, front_s): &Plain, ends: Ends) -> f64 {
    match ends.of_step() {
        None if ends == Ends::LEAVING => *push_s,
        None => push_s + t.push_s.1,
        Some(k) => t.release[k].map_or(f64::INFINITY, |(at, back_s)| front_s[at] - back_s),
    }
}

/// The rule as it is said: all takes in the order of their planned times, each after the ends of all uses before it, again and again
/// until nothing changes. `None`: it never ends.
fn plain(core: &Core) -> Option<Vec<Plain>> {
    let now = core.time_s;
    let mut times: Vec<Plain> = Vec::new();
    let (mut there, mut groups): (Users, Vec<(f64, usize, Option<usize>)>) =
        (vec![Vec::new(); core.pieces.list.len()], Vec::new());
    for (m, mover) in core.movers.iter().enumerate() {
        let t = &mover.timing;
        let mut mine = (t.push_take_s, t.take_s.clone(), t.front_s.clone());
        if t.planned {
            let open = core.open_steps(m);
            let mut put = |z: u32, ends: Ends| there[z as usize].push((m, mover.class, ends));
            match mover.phase {
                Phase::Parked => {
                    groups.push((t.push_take_s, m, None));
                    mover.parked_pieces.iter().for_each(|z| put(*z, Ends::LEAVING));
                }
                Phase::Pushing => {
                    mine.0 = now + (mover.push.stop_m - mover.s).max(0.0) / 1.5 - t.push_s.1;
                    let done = now + (mover.push.stop_m - mover.s).max(0.0) / 1.5;
                    mine.2[..t.pushed].fill(done + (t.push_s.0 - t.push_s.1));
                    mover.push.pieces.iter().for_each(|z| put(*z, Ends::PUSHED));
                    (t.first..open.start).for_each(|k| put(mover.way.pieces[k], Ends::step(k)));
                }
                phase => {
                    let from_s = match phase {
                        Phase::Starting(until) | Phase::LinedUp(until) => until.max(now),
                        _ => now,
                    };
                    if !(phase == Phase::Final && mover.next == 0) {
                        core.front_of_held(m, t, &mut mine.2, from_s);
                    }
                    (mover.first_held..open.start)
                        .for_each(|k| put(mover.way.pieces[k], Ends::step(k)));
                }
            }
            let mut k = open.start;
            while k < open.end {
                groups.push((t.order_s[k], m, Some(k)));
                k = mover.way.group_last[k].max(k) + 1;
            }
        }
        times.push(mine);
    }
    groups.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    for _ in 0..200 {
        let (mut users, old) = (there.clone(), times.clone());
        for (_, m, first) in &groups {
            let (m, mover) = (*m, &core.movers[*m]);
            let t = &mover.timing;
            let last = first.map(|k| mover.way.group_last[k].max(k));
            let uses: Vec<(u32, Ends)> = match (first, last) {
                (Some(k), Some(last)) => {
                    (*k..=last).map(|i| (mover.way.pieces[i], Ends::step(i))).collect()
                }
                _ => {
                    let under = t.first..t.pushed;
                    let over = mover.push.pieces.iter().map(|z| (*z, Ends::PUSHED));
                    over.chain(under.map(|i| (mover.way.pieces[i], Ends::step(i)))).collect()
                }
            };
            let mut take = now;
            for (z, _) in &uses {
                for (other, least) in core.pieces.conflicts(*z as usize, mover.class) {
                    for (o, class, ends) in &users[*other as usize] {
                        if *o != m && class >= least && core.in_order(*z, *other) {
                            let until_s = ends_s(&core.movers[*o].timing, &times[*o], *ends);
                            if until_s.is_finite() {
                                take = take.max(until_s + PAUSE_S);
                            }
                        }
                    }
                }
            }
            match (first, last) {
                (Some(k), Some(last)) => {
                    let lands = t.fixed && *k == mover.next && mover.phase == Phase::Final;
                    take = take.max(if *k == 0 || lands {
                        mover.landing_s - LANDING_AHEAD_S
                    } else {
                        times[m].2[k - 1]
                    });
                    let mut front = take;
                    for i in *k..=last {
                        front += t.pass_s[i];
                        (times[m].1[i], times[m].2[i]) = (take, front);
                    }
                }
                _ => {
                    take = take.max(core.flights[m].time_s);
                    times[m].0 = take;
                    times[m].1[..t.pushed].fill(take);
                    times[m].2[..t.pushed].fill(take + t.push_s.0);
                }
            }
            for (z, ends) in uses {
                users[z as usize].push((m, mover.class, ends));
            }
        }
        if times == old {
            return Some(times);
        }
    }
    None
}

/// Holds what is kept against the plain rule.
fn held_to_it(core: &Core, what: &str) -> Result<bool, TestCaseError> {
    let wanted = plain(core);
    let mut kept = core.clone();
    let before: Vec<Timing> = kept.movers.iter().map(|m| m.timing.clone()).collect();
    let settled = kept.retime();
    prop_assert_eq!(settled, wanted.is_some(), "{} at {} s", what, core.time_s);
    for (m, mover) in kept.movers.iter().enumerate().filter(|(_, m)| m.timing.planned) {
        let t = &mover.timing;
        let old = &before[m];
        let (push_s, take_s, front_s) = wanted.as_ref().map_or_else(
            || (old.push_take_s, old.take_s.clone(), old.front_s.clone()),
            |wanted| wanted[m].clone(),
        );
        let at =
            format!("{what} at {} s: {} {:?}", core.time_s, core.flights[m].callsign, mover.phase);
        prop_assert_eq!(t.push_take_s.to_bits(), push_s.to_bits(), "{}", &at);
        prop_assert_eq!(&t.take_s, &take_s, "{}", &at);
        prop_assert_eq!(&t.front_s, &front_s, "{}", &at);
        if wanted.is_some() {
            prop_assert_eq!(&t.order_s, &take_s, "{}", &at);
        }
    }
    // What stands in the order lists is what is planned and not taken.
    let mut lists: Vec<Vec<Booking>> = vec![Vec::new(); core.pieces.list.len()];
    for (m, mover) in kept.movers.iter().enumerate().filter(|(_, m)| m.timing.planned) {
        let mut put =
            |z: u32, taken: Ends| lists[z as usize].push(Booking { mover: m as u32, taken });
        if mover.phase == Phase::Parked {
            mover.push.pieces.iter().for_each(|z| put(*z, Ends::PUSHED));
            let t = &mover.timing;
            (t.first..t.pushed).for_each(|k| put(mover.way.pieces[k], Ends::step(k)));
        }
        kept.open_steps(m).for_each(|k| put(mover.way.pieces[k], Ends::step(k)));
    }
    let plain: Vec<Vec<_>> =
        lists.iter().map(|l| l.iter().map(|b| (b.mover, b.taken)).collect()).collect();
    let there: Vec<Vec<_>> =
        kept.books.iter().map(|l| l.iter().map(|b| (b.mover, b.taken)).collect()).collect();
    prop_assert!(plain == there, "{what}: order lists at {} s", core.time_s);
    Ok(settled)
}

/// Who goes first over a centreline and in strips is not in the order: whoever takes a piece there leaves without taking more. It is
/// against all that lies off the strips, as taxiways beside the ends of runways do.
#[test]
fn a_centreline_is_in_the_order_against_off_strip_pieces_only() {
    let network = Network::of(&airport(9, &[0.5], 1));
    let flights = vec![flight(0, Direction::Departure, 0, 0.0, 0)];
    let pieces = Pieces::of(&network, &Core::classes(&flights));
    let (network, pieces) = (Arc::new(network), Arc::new(pieces));
    let core = Core::new(network, pieces, Arc::new(flights), Policy::Planned, 7, 0.2);
    let find = |runway: bool, strip: bool| {
        let is = |z: &u32| {
            let piece = &core.pieces.list[*z as usize];
            piece.runway.is_some() == runway && (runway || piece.strip.is_some() == strip)
        };
        (0..core.pieces.list.len() as u32).find(is).expect("one of each kind")
    };
    let (centreline, strip, off) = (find(true, false), find(false, true), find(false, false));
    let kinds = [
        (off, off, true),
        (off, strip, true),
        (off, centreline, true),
        (strip, strip, true),
        (strip, centreline, false),
        (centreline, centreline, false),
    ];
    for (a, b, ordered) in kinds {
        assert_eq!(core.in_order(a, b), ordered, "{a} against {b}");
        assert_eq!(core.in_order(b, a), ordered, "{b} against {a}");
    }
}

/// Landings that are called late for their time cannot be planned for it, nor can any others whose ways begin alike; and most of
/// those that cannot be planned are called so.
#[test]
fn who_is_called_late_before_the_rest_is_planned_cannot_be_planned() {
    let (mut called, mut planned, mut impossible, mut alike) = (0, 0, 0, 0);
    for (draw, entries) in [&[0.5][..], &[0.3, 0.6], &[0.8], &[0.4, 0.5, 0.7]].iter().enumerate() {
        let network = Network::of(&airport(11, entries, 3));
        let stands = network.stands.len();
        let kinds = [Direction::Departure, Direction::Arrival];
        let flights = (0..stands).map(|k| {
            let direction = kinds[(k + draw) % 2];
            flight(k, direction, k, 40.0 * k as f64, draw % 2)
        });
        let flights: Vec<Flight> = flights.collect();
        let pieces = Pieces::of(&network, &Core::classes(&flights));
        let (network, pieces, flights) = (Arc::new(network), Arc::new(pieces), Arc::new(flights));
        let mut core = Core::new(network, pieces, flights, Policy::Planned, 7, 0.2);
        core.cleared_by = ClearedBy::Plan;
        for frame in 1..=5000_i64 {
            core.step(frame);
            let lands = |m: &usize| {
                core.movers[*m].phase == Phase::Absent
                    && core.flights[*m].direction == Direction::Arrival
            };
            let next = (0..core.movers.len()).find(lands).filter(|_| frame % 500 == 250);
            let Some(m) = next else { continue };
            let mut core = core.clone();
            let others = core.others(m);
            let (mut searches, mut laid) = ([None, None], Vec::new());
            for stand in (0..stands).step_by(3) {
                core.movers[m].stand = stand;
                laid.extend(core.ways_to_stand(m, &[], &mut searches));
            }
            for ahead_s in [0.0, 30.0, 75.0, 130.0, 200.0] {
                let from_s = core.time_s + ahead_s;
                let (mut found, mut begins) = (Vec::new(), Vec::new());
                for (way, timing, _) in &laid {
                    core.movers[m] = way.clone();
                    core.movers[m].landing_s = from_s + LANDING_AHEAD_S;
                    let late = core.late_with(m, timing, from_s, &others);
                    let rivals = core.rivals(m, timing, &others);
                    let can = core.schedule(m, timing.clone(), from_s, &rivals).is_some();
                    assert!(!(can && late.is_some()), "{draw}: frame {frame}, {ahead_s} s ahead");
                    called += usize::from(late.is_some());
                    impossible += usize::from(!can);
                    planned += usize::from(can);
                    begins.extend(late);
                    found.push((way.way.arcs.clone(), can));
                }
                for (arcs, can) in &found {
                    let others = begins.iter().filter(|b| arcs.starts_with(b));
                    let shared = others.count();
                    assert!(!(*can && shared > 0), "{draw}: frame {frame}, begins alike");
                    alike += usize::from(shared > 1);
                }
            }
        }
    }
    assert!(planned > 20 && impossible > 20 && alike > 20, "{planned} {impossible} {alike}");
    assert!(2 * called > impossible, "{called} of {impossible}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Half an hour of up to forty flights that stop at random, looked at every twenty seconds, also with somebody's plan gone, and
    /// with a landing put first.
    #[test]
    fn what_is_kept_gives_the_times_of_the_plain_rule(
        columns in 9_usize..14,
        entries in prop::collection::vec(0.1..0.9_f64, 1..4),
        lanes in 1_usize..4,
        end in 0_usize..2,
        draws in prop::collection::vec((0.0..1.0_f64, prop::bool::ANY, 0.0..1500.0_f64, 0.0..1.0_f64), 12..40),
    ) {
        let network = Network::of(&airport(columns, &entries, lanes));
        let stands = network.stands.len();
        let mut flights = Vec::new();
        let mut taken = vec![false; stands];
        for (k, (stand, arrives, time_s, _)) in draws.iter().enumerate() {
            let stand = (stand * stands as f64) as usize % stands;
            let direction = if *arrives { Direction::Arrival } else { Direction::Departure };
            if direction == Direction::Departure && std::mem::replace(&mut taken[stand], true) {
                continue;
            }
            flights.push(flight(k, direction, stand, *time_s, end));
        }
        let pieces = Pieces::of(&network, &Core::classes(&flights));
        let count = flights.len();
        let (step_s, flights) = (0.2, Arc::new(flights));
        let mut core = Core::new(Arc::new(network), Arc::new(pieces), flights, Policy::Planned, 7, step_s);
        core.cleared_by = ClearedBy::Plan;
        for (f, (.., share)) in draws.iter().enumerate().take(count) {
            let at_s = core.flights[f].time_s + 100.0 + 400.0 * share;
            core.notice(Notice {
                effect_frame: (at_s / step_s) as i64,
                source: "stops".into(),
                sequence: f as u64,
                flight: f,
                order: Order::Stop(20.0 + 160.0 * share),
            });
        }
        let mut looked = 0;
        for frame in 1..=9000_i64 {
            core.step(frame);
            if frame % 100 != 37 {
                continue;
            }
            held_to_it(&core, "as it is")?;
            let planned: Vec<usize> = (0..count).filter(|m| core.movers[*m].timing.planned).collect();
            looked += planned.len();
            let Some(m) = planned.get(looked % planned.len().max(1)).copied() else { continue };
            // Its plan goes, and comes back.
            let mut without = core.clone();
            let old = std::mem::take(&mut without.movers[m].timing);
            without.book();
            held_to_it(&without, "without one")?;
            without.movers[m].timing = old;
            held_to_it(&without, "back again")?;
            if let Some(m) = planned.iter().find(|m| core.movers[**m].phase == Phase::Final) {
                let mut first = core.clone();
                let (next, way) = (first.movers[*m].next, &first.movers[*m].way);
                let last = way.group_last[next];
                first.movers[*m].timing.order_s[next..=last].fill(core.time_s - 1.0);
                first.replaced(*m);
                held_to_it(&first, "landing first")?;
            }
        }
        prop_assert!(looked > 0, "nobody was planned");
    }
}
