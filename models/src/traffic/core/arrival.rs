//! Arrivals: final, landing, exit and way to the stand.

use super::closed::Closed;
use super::drive::ROLL_JERK_MPS3;
use super::failures::FailureKind;
use super::landing::{Flare, STOPS_SHARE, final_mps2, off_speed_mps};
use super::plan::{LANDING_AHEAD_S, Others, Rivals, Start};
use super::runway::arrival_gap_s;
use super::tow::TOWED_OFF_S;
use super::{Core, Direction, FINAL_M, Flight, Phase, Policy, RETRY_S, SLOPE, Timing};
use crate::draw::normal_pair;
use crate::frames::{Azimuth, wrap_pi};
use crate::traffic::runway_roll::{
    Exit, Landing, approach_airspeed_mps, approach_time_s, touchdown_zone,
};
use crate::traffic::way::{Arcs, Roll, Search, Way};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// At the begin of the loop of a turn pad, m/s (assumed).
const PAD_MPS: f64 = 8.0;
/// An exit at more than this turns back, degrees: a right angle, with room for how files place nodes (assumed).
const TURNS_BACK_DEG: f64 = 91.0;
/// A landing is planned for so many touchdowns, each nearer to the threshold.
const TOUCHDOWNS: usize = 4;
/// Who could not stop for any exit that is free for so long puts itself down earlier, s (assumed): until then a farther one may become free.
const KEEPS_DRAWN_S: f64 = 60.0;

/// Exits are for being fast within so much beside the centreline, m: the usual place of a holding position.
const OFF_M: f64 = 90.0;

/// So many stands are tried for an arrival, and for one who has found none for a minute.
const STANDS_TRIED: usize = 6;
/// And so many of them where the landing is put later.
const STANDS_TRIED_AGAIN: usize = 2;
const STANDS_TRIED_LATER: usize = 24;

/// What was found for an arrival at one time: ways by stand, and what the others use.
#[derive(Default)]
pub(super) struct Tried {
    searches: [Option<Searches>; 2],
    ways: BTreeMap<usize, Vec<Laid>>,
    others: Option<Others>,
    /// Arcs with which a way begins that makes the landing late at the first of the times.
    late: Vec<Vec<usize>>,
}

/// A way to a stand, with its times alone and, once they are wanted, what the others use on it.
type Laid = (super::Mover, Timing, Option<Rivals>);

/// Searches for ways to stands while nothing else changes.
pub(super) struct Searches {
    closed: Vec<bool>,
    opposed: Vec<bool>,
    /// Nobody drives: it is only looked for what stands there.
    only_looks: bool,
    /// By the arc of an exit.
    from: BTreeMap<usize, Search>,
    /// Arcs of the way that is laid already, and of those with which a landing would be late: not laid.
    known: Vec<usize>,
    late: Vec<Vec<usize>>,
}

/// Time to the threshold of one who comes with `v` m/s over the ground so far before it, against a head wind, in steps of
/// `dt`, s; `None` if he does not come there.
pub(super) fn time_to_threshold_s(
    out_m: f64,
    v: f64,
    (touchdown_mps, head_mps): (f64, f64),
    dt: f64,
) -> Option<f64> {
    let (mut left_m, mut v, mut a, mut steps) = (out_m, v, 0.0, 0_u32);
    while left_m > 0.0 {
        if v < 1.0 || steps > 100_000 {
            return None;
        }
        let wish = approach_airspeed_mps(left_m, touchdown_mps) - head_mps;
        a = final_mps2(wish, v, a, dt);
        left_m -= v * dt;
        v += a * dt;
        steps += 1;
    }
    Some(f64::from(steps) * dt)
}

impl Core {
    pub(super) fn appear_on_final(&mut self, m: usize, f: &Flight) {
        let head_mps = self.head_mps(m);
        let Some(time) = approach_time_s(f.landing.0, head_mps, 10.0) else {
            if self.movers[m].waits_since_s.is_none() {
                self.remark(format!(
                    "{}: {head_mps:.0} m/s of head wind on runway {} are more than it flies against",
                    f.callsign,
                    self.end_name(m)
                ));
            }
            self.movers[m].waits_since_s.get_or_insert(self.time_s);
            self.movers[m].next_try_s = self.time_s + RETRY_S;
            return;
        };
        let wanted = f.time_s.max(self.movers[m].landing_s);
        if self.time_s < wanted - time {
            return;
        }
        let r = f.runway.0;
        let departs_s = if self.mixed[r] { self.departure_slot_s(f.runway) } else { 0.0 };
        let least = departs_s.max(self.crossing_slot_s(r));
        let too_near = self.crossing[r].iter().any(|c| {
            let (last_s, wake) = self.last_landing[*c];
            let gap_s = arrival_gap_s(wake, f, head_mps).max(least).max(self.backtrack_gap_s(*c));
            self.time_s + time < last_s + gap_s || self.backtracks_for_s(*c) > time
        });
        if too_near || self.starves(m) {
            self.movers[m].next_try_s = self.time_s + RETRY_S;
            return;
        }
        let waited_s = self.movers[m].waits_since_s.map_or(0.0, |since| self.time_s - since);
        // The nearest may all lie in a corner that somebody closes.
        let most = if waited_s > 60.0 { STANDS_TRIED_LATER } else { STANDS_TRIED };
        let mut choices = self.free_stands(m, most);
        if choices.is_empty() {
            choices.extend(self.make_room(m));
        }
        let none = choices.is_empty();
        // Under a plan the landing may be put up to four minutes later: it enters final then, but has its times now.
        let latest = if self.policy == Policy::Planned { 8 } else { 0 };
        let mut chosen = None;
        let mut delay_s = 0.0;
        if self.policy == Policy::Planned {
            self.retime();
        }
        let mut tried = Tried::default();
        for k in 0..=latest {
            delay_s = 30.0 * f64::from(k);
            let most = if k == 0 { choices.len() } else { STANDS_TRIED_AGAIN };
            let some = choices.iter().take(most).cloned().collect();
            chosen = self.choose_stand(m, some, self.time_s + time + delay_s, &mut tried);
            if chosen.is_some() || none {
                break;
            }
        }
        let Some((stand, pieces)) = chosen else {
            if self.movers[m].waits_since_s.is_none() {
                let why = if none { "no free stand" } else { "no way to a free stand" };
                self.remark(format!(
                    "{}: {why} from runway {}, not released to final",
                    f.callsign,
                    self.end_name(m)
                ));
            }
            if let Some((stand, _)) = choices.first().filter(|_| waited_s > TOWED_OFF_S) {
                self.tow_off_way_to(m, *stand);
            }
            let now = self.time_s;
            self.movers[m].waits_since_s.get_or_insert(now);
            self.movers[m].next_try_s = now + 30.0;
            return;
        };
        if stand != f.stand {
            self.remark(format!(
                "{}: stand {} is not free, to {} instead",
                f.callsign, self.net.stands[f.stand].name, self.net.stands[stand].name
            ));
        }
        let entry_mps = approach_airspeed_mps(FINAL_M, f.landing.0) - head_mps;
        let out_m = FINAL_M + entry_mps * delay_s;
        self.enters_final(m, pieces, self.time_s + time + delay_s, out_m);
        self.draw_approach(m, f, out_m);
        if self.policy == Policy::Planned {
            self.book();
        }
    }

    /// Is on final from now on, so far before its threshold, m; it keeps a stand.
    pub(super) fn enters_final(&mut self, m: usize, stand: Vec<u32>, landing_s: f64, out_m: f64) {
        let head_mps = self.head_mps(m);
        let f = &self.flights[m];
        self.last_landing[f.runway.0] = (landing_s, f.wake);
        let mover = &mut self.movers[m];
        mover.parked_pieces = stand;
        mover.landing_s = landing_s;
        mover.phase = Phase::Final;
        mover.waits_since_s = None;
        mover.cleared = false;
        (mover.first_held, mover.next, mover.slip, mover.a) = (0, 0, 0.0, 0.0);
        (mover.wander, mover.approach) = (mover.wander.anew(), Default::default());
        mover.v = approach_airspeed_mps(out_m.min(FINAL_M), f.landing.0) - head_mps;
        mover.s = mover.threshold - out_m;
        let behind_m = mover.touchdown - mover.threshold;
        mover.flare = Flare::of(f.landing.0 - head_mps, behind_m);
        // A step behind, as that of everybody on final: its first frame sinks as those after it.
        let before_m = mover.touchdown - mover.s + mover.v * self.step_s;
        mover.height_m = mover.flare.height_m(before_m);
        mover.climb_mps = -SLOPE * mover.v;
    }

    /// The first stand to which there is a way; under a plan also the times for it, and the next one where it
    /// would wait for more than two minutes. `tried`: what was found before, at the same time.
    pub(super) fn choose_stand(
        &mut self,
        m: usize,
        choices: Vec<(usize, Vec<u32>)>,
        landing_s: f64,
        tried: &mut Tried,
    ) -> Option<(usize, Vec<u32>)> {
        let planned = self.policy == Policy::Planned;
        let mut best: Option<(f64, (usize, Vec<u32>), super::Mover)> = None;
        let old = self.movers[m].landing_s;
        self.movers[m].landing_s = landing_s;
        let Tried { searches, ways, others, late } = tried;
        for (n, (stand, pieces)) in choices.into_iter().enumerate() {
            self.movers[m].stand = stand;
            self.movers[m].parked_pieces.clone_from(&pieces);
            if !planned {
                let searches = searches[0].get_or_insert_with(|| self.searches(m, Closed::Now));
                if self.plan_arrival(m, searches, &[]) {
                    self.draw_cleared_way(m);
                    return Some((stand, pieces));
                }
                continue;
            }
            let others = others.get_or_insert_with(|| self.others(m));
            // Only these are tried again at other times, at which the same ways need not be late.
            let again = n < STANDS_TRIED_AGAIN;
            let not = if again { &[][..] } else { &late[..] };
            let both = ways.entry(stand).or_insert_with(|| self.ways_to_stand(m, not, searches));
            for (way, timing, rivals) in both {
                std::mem::swap(&mut self.movers[m], way);
                self.movers[m].landing_s = landing_s;
                let from_s = landing_s - LANDING_AHEAD_S;
                let begins = self.late_with(m, timing, from_s, others);
                let found = begins.is_none() && {
                    let rivals = rivals.get_or_insert_with(|| self.rivals(m, timing, others));
                    self.plan_among(m, timing.clone(), from_s, rivals)
                };
                late.extend(begins);
                let end = self.planned_end_s(m);
                if found && best.as_ref().is_none_or(|b| end < b.0 - 30.0) {
                    best = Some((end, (stand, pieces.clone()), self.movers[m].clone()));
                }
                std::mem::swap(&mut self.movers[m], way);
            }
            if best.as_ref().is_some_and(|b| b.0 < landing_s + b.2.measures.unhindered_s + 240.0) {
                break;
            }
        }
        self.movers[m].parked_pieces.clear();
        self.movers[m].timing = Timing::default();
        self.movers[m].landing_s = old;
        let (_, choice, mover) = best?;
        self.movers[m] = mover;
        self.draw_cleared_way(m);
        Some(choice)
    }

    /// Ways to its stand with their times alone: past all that is closed now, and past what stands without end, where that is
    /// another one; without those that begin with arcs of `late`.
    pub(super) fn ways_to_stand(
        &mut self,
        m: usize,
        late: &[Vec<usize>],
        searches: &mut [Option<Searches>; 2],
    ) -> Vec<Laid> {
        let mut ways: Vec<Laid> = Vec::new();
        for (past, searches) in [Closed::Now, Closed::Lasting].into_iter().zip(searches) {
            let searches = searches.get_or_insert_with(|| self.searches(m, past));
            searches.known.clear();
            searches.known.extend(ways.iter().flat_map(|w| &w.0.way.arcs));
            searches.late.clear();
            searches.late.extend_from_slice(late);
            if self.plan_arrival(m, searches, &[])
                && ways.iter().all(|w| w.0.way.arcs != self.movers[m].way.arcs)
            {
                ways.push((self.movers[m].clone(), self.timing(m, Start::Final), None));
            }
        }
        ways
    }

    pub(super) fn searches(&self, m: usize, past: Closed) -> Searches {
        let closed = match past {
            Closed::Now => self.closed(m),
            Closed::Lasting => self.closed_for_ever(m),
            Closed::Narrow => self.narrow(m),
        };
        let only_looks = past == Closed::Narrow;
        let (opposed, from) = (self.opposed(m), BTreeMap::new());
        Searches { closed, opposed, only_looks, from, known: Vec::new(), late: Vec::new() }
    }

    /// Exit and way to the stand.
    ///
    /// `left_out`: exits, as the arcs by which one leaves the runway, that are not taken.
    pub(super) fn plan_arrival(
        &mut self,
        m: usize,
        searches: &mut Searches,
        left_out: &[usize],
    ) -> bool {
        let (r, end) = self.flights[m].runway;
        let runway = &self.net.runways[r];
        let zone = touchdown_zone(runway.length_m - runway.displaced_m[end]);
        let (least_m, most_m) = zone.within_m;
        let drawn = normal_pair(&mut self.rng(m, 4)).0;
        let mut touchdown_m = (zone.mean_m + zone.sigma_m * drawn).clamp(least_m, most_m);
        let since_s = self.movers[m].waits_since_s;
        let waits = since_s.is_some_and(|since_s| self.time_s - since_s > KEEPS_DRAWN_S);
        for _ in 0..if waits { TOUCHDOWNS } else { 1 } {
            match self.plan_landing(m, searches, left_out, touchdown_m) {
                Ok(planned) => return planned,
                Err(before_m) if before_m < touchdown_m && touchdown_m > least_m => {
                    touchdown_m = before_m.max(least_m);
                }
                Err(_) => return false,
            }
        }
        false
    }

    /// The same for a touchdown so far behind the threshold. An error if no exit can be braked for from there: the farthest touchdown
    /// from which one might be, m.
    fn plan_landing(
        &mut self,
        m: usize,
        searches: &mut Searches,
        left_out: &[usize],
        touchdown_m: f64,
    ) -> Result<bool, f64> {
        let f = self.flights[m].clone();
        let net = Arc::clone(&self.net);
        let (r, end) = f.runway;
        let runway = &net.runways[r];
        let Some(node) = net.stands[self.movers[m].stand].node else { return Ok(false) };
        let Searches { closed, opposed, only_looks, from, known, late: too_late } = searches;
        let most_mps2 = self.day.exit_braking_mps2();
        let landing = Landing {
            touchdown_mps: f.landing.0 - self.head_mps(m),
            touchdown_m,
            delay_s: 2.0,
            nominal_mps2: f.landing.1,
            greatest_mps2: most_mps2,
        };
        // Brakes build up.
        let late = Landing { delay_s: 2.0 + 0.5 * most_mps2 / ROLL_JERK_MPS3, ..landing };
        let mut before_m = f64::NEG_INFINITY;
        let direction = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]).rad();
        let along = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let mut spine: Vec<(f64, usize)> =
            runway.spine.iter().map(|(p, n)| (along(*p), *n)).collect();
        if end == 1 {
            spine.reverse();
        }
        let threshold = runway.displaced_m[end];
        let mut exits: Vec<(Exit, usize)> = Vec::new();
        for (place, n) in &spine {
            for arc in self.arcs.leaving(*n) {
                let edge = &net.edges[arc / 2];
                let turn = wrap_pi(self.arcs.heading_rad(*arc) - direction).abs().to_degrees();
                let off = edge.runway.is_none() && edge.strip == Some(r) && turn <= 115.0;
                if !off || left_out.contains(arc) {
                    continue;
                }
                let speed_mps = if edge.backtrack {
                    PAD_MPS
                } else if turn <= 35.0 {
                    25.7
                } else if turn <= 60.0 {
                    12.9
                } else {
                    7.7
                };
                let speed_mps = speed_mps * self.day.exit_share();
                exits.push((Exit { place_m: place - threshold, speed_mps }, *arc));
            }
        }
        exits.sort_by(|a, b| a.0.place_m.total_cmp(&b.0.place_m).then(a.1.cmp(&b.1)));
        let mut left: Vec<(Exit, usize)> = exits;
        // Exits from which the way leads back over the runway, where the next one lands: only where there is no other, or only
        // one that turns back.
        let mut back: Vec<(Exit, usize)> = Vec::new();
        let mut any = false;
        while !left.is_empty() || !back.is_empty() {
            if left.is_empty() {
                (left, any) = (std::mem::take(&mut back), true);
            }
            let places: Vec<Exit> = left.iter().map(|e| e.0).collect();
            let chosen = landing.exit(&places).unwrap_or(left.len() - 1);
            let (exit, arc) = left.remove(chosen);
            let is_closed = |e: usize| closed[e] || net.edges[e].runway == Some(r);
            let goal = |a: usize| Arcs::to(&net, a) == node;
            let search = from.entry(arc).or_insert_with(|| Search::new(&self.arcs));
            let found = self.arcs.quickest_to(&net, search, arc, node, is_closed, |a| opposed[a]);
            let Some(found) = found else { continue };
            let in_strip = |a: &usize| net.edges[a / 2].strip == Some(r);
            let leads_back = found.arcs.iter().skip_while(|a| in_strip(a)).any(in_strip);
            let turn = wrap_pi(self.arcs.heading_rad(arc) - direction).abs().to_degrees();
            if !any && (leads_back || !back.is_empty() && turn > TURNS_BACK_DEG) {
                back.push((exit, arc));
                continue;
            }
            // Braking harder than anybody does: not this exit.
            let Some(needed) = landing.needed_mps2(exit).filter(|a| *a <= most_mps2) else {
                before_m = before_m.max(late.latest_m(exit));
                continue;
            };
            let at = spine
                .iter()
                .position(|(p, _)| (p - threshold - exit.place_m).abs() < 0.01)
                .unwrap_or(0);
            let arcs: Vec<usize> =
                spine[..=at].windows(2).filter_map(|w| self.arc_between(w[0].1, w[1].1)).collect();
            if arcs.is_empty() {
                continue;
            }
            let on_runway: usize = arcs.iter().map(|a| self.pieces.of_edge[a / 2].1).sum();
            let short_m = self.short_of_node_m(self.movers[m].stand, f.size);
            let guided = 0.4 * f.size.length_m - short_m;
            let over = |arcs: &[usize]| {
                Way::over(&net, &self.pieces, arcs, self.movers[m].class, (0.0, 60.0), guided)
            };
            let all = [&arcs[..], &found.arcs[..]].concat();
            let turns = self.failing(m, FailureKind::WrongTurn).filter(|_| !*only_looks);
            if turns.is_none() && (all == *known || too_late.iter().any(|l| all.starts_with(l))) {
                return Ok(false);
            }
            let cleared = over(&all);
            // Begins on the runway, before the turn to the exit.
            let begin_m = (cleared.ends_m[on_runway - 1] - 400.0).max(0.0);
            let detour = turns.and_then(|_| self.detour(&found.arcs, &goal, &is_closed));
            let turned = turns.filter(|_| detour.is_some());
            let mut drawn = None;
            let mut way = match &detour {
                Some(detour) => {
                    drawn = Some(Self::line_of(&cleared, begin_m));
                    over(&[&arcs[..], detour].concat())
                }
                None => cleared,
            };
            way.roll = 0..on_runway;
            way.group_crossings(&self.pieces, f.size.length_m + 10.0, 0..on_runway);
            // Landing: the runway up to the exit with the exit beyond the holding position.
            let exit_end = way
                .crossings
                .iter()
                .find(|c| c.0 == on_runway)
                .map_or(on_runway, |_| way.group_last[on_runway]);
            let touching: Vec<(usize, usize)> =
                way.crossings.iter().copied().filter(|c| c.0 == on_runway && c.1 != r).collect();
            way.crossings.retain(|c| c.0 != on_runway);
            way.hold_before(None);
            way.group(0, exit_end.min(way.pieces.len() - 1));
            let crossings = way.crossings.iter().map(|c| c.0);
            let firsts: Vec<usize> = std::iter::once(0).chain(crossings).collect();
            way.clear_strips(&self.pieces, &firsts, usize::MAX, self.body_m(m));
            // What its landing takes of other runways' strips it crosses with that.
            let landing_last = way.group_last[0];
            let taken = way.crossings.iter().filter(|c| c.0 <= landing_last);
            way.lands_over = touching.iter().chain(taken).map(|c| c.1).collect();
            way.crossings.retain(|c| c.0 > landing_last);
            let free_to = way.turns_off_m().unwrap_or(way.ends_m[on_runway - 1]);
            let mut braking = (1.15 * needed.max(0.5)).max(f.landing.1.min(1.6)).min(most_mps2);
            let driving = self.movers[m].driving;
            // It comes to its exit as fast as it chose it for, and so that it could stop behind its strip.
            let off_to_m = match net.edges[arc / 2].backtrack {
                true => free_to,
                false => self.leaves_strip_m(&way, r, (free_to, on_runway..landing_last + 1)),
            };
            let off_mps2 = self.day.off_braking_mps2();
            let (ahead_m, _, hold_gap_m) = self.body_m(m);
            let stop_m = way.stop_before_m(landing_last + 1, ahead_m, hold_gap_m);
            let stop_mps =
                off_speed_mps(&driving, off_mps2, (off_to_m - free_to, stop_m - free_to));
            let exit_mps = exit.speed_mps.min(stop_mps);
            let roll = |dec_mps2| Roll {
                free_to_m: free_to,
                dec_mps2,
                exit_mps,
                off_to_m,
                off_dec_mps2: STOPS_SHARE * off_mps2,
            };
            way.limit(&net, &self.pieces, &driving, &roll(braking));
            // What lies behind the exit may want it slower, its arc begins before it, and brakes build up.
            let speed_mps = way.most_mps(free_to);
            let to = Exit { place_m: free_to - threshold, speed_mps };
            let Some(needed) = late.needed_mps2(to).filter(|a| *a <= most_mps2) else {
                before_m = before_m.max(late.latest_m(to));
                continue;
            };
            if needed > braking {
                braking = needed;
                way.limit(&net, &self.pieces, &driving, &roll(braking));
            }
            let own = |k: &usize| self.pieces.list[way.pieces[*k] as usize].strip == Some(r);
            let last = (0..=landing_last).rev().find(own).unwrap_or(exit_end);
            let vacated_m = (way.ends_m[last] + self.body_m(m).1).min(way.stop_m);
            if let Some(failure) = turned {
                self.begin_failure(failure);
            }
            let mover = &mut self.movers[m];
            mover.cleared_from_m = drawn.is_none().then_some(begin_m);
            mover.cleared_way_m = drawn.unwrap_or_default();
            mover.cleared_arcs = if turned.is_some() { all } else { Vec::new() };
            // It taxies from where its tail is beyond the line: a backtrack is no delay.
            mover.measures.unhindered_s =
                way.alone(vacated_m, way.most_mps(vacated_m), &driving).time_s(way.stop_m);
            mover.threshold = threshold;
            mover.touchdown = threshold + touchdown_m;
            mover.braking = braking;
            (mover.most_mps2, mover.off_mps2, mover.off_to_m) = (most_mps2, off_mps2, off_to_m);
            mover.way = way;
            mover.beside_m *= 0.0;
            return Ok(true);
        }
        Err(before_m)
    }

    /// Where an exit, from its begin on, is beyond the strip of its runway or [`OFF_M`] beside the centreline, m.
    fn leaves_strip_m(&self, way: &Way, r: usize, (from_m, steps): (f64, Range<usize>)) -> f64 {
        let strip = |k: &usize| self.pieces.list[way.pieces[*k] as usize].strip == Some(r);
        let end_m = steps.rev().find(strip).map_or(from_m, |k| way.ends_m[k]);
        let places = (0..).map(|k| from_m + 4.0 * f64::from(k)).take_while(|place| *place < end_m);
        let beside_m = |place: f64| self.net.runways[r].place_m(way.path.at(place).at_m).1.abs();
        let mut beyond = places.skip_while(|place| beside_m(*place) < OFF_M);
        beyond.next().unwrap_or(end_m).max(from_m)
    }

    pub(super) fn take_landing(&mut self, m: usize) -> bool {
        // Its own promised stand is not in its way.
        let before = self.movers[m].phase;
        self.movers[m].phase = Phase::Landing;
        let mut taken = self.take(m);
        // The world has changed since the way was planned: another exit or way may do.
        if !taken && self.time_s >= self.movers[m].next_try_s {
            self.movers[m].next_try_s = self.time_s + 3.0;
            if self.policy == Policy::Planned {
                return self.land_otherwise(m, before);
            }
            let old = self.movers[m].clone();
            let mut searches = self.searches(m, Closed::Now);
            if self.plan_arrival(m, &mut searches, &[]) && self.movers[m].way.arcs != old.way.arcs {
                self.draw_cleared_way(m);
                self.movers[m].refused_at = None;
                taken = self.take(m);
            } else {
                self.movers[m] = old;
            }
        }
        self.movers[m].phase = before;
        taken
    }

    /// A landing that its place in the order holds up: first at its exit, else by another way.
    fn land_otherwise(&mut self, m: usize, before: Phase) -> bool {
        self.movers[m].phase = before;
        let first = self.land_first(m);
        self.movers[m].phase = Phase::Landing;
        self.movers[m].refused_at = None;
        if first && self.take(m) {
            self.movers[m].phase = before;
            return true;
        }
        self.movers[m].phase = before;
        self.retime();
        let old = self.movers[m].clone();
        let mut taken = false;
        let mut left_out = Vec::new();
        let mut searches = self.searches(m, Closed::Lasting);
        while !taken && self.plan_arrival(m, &mut searches, &left_out) {
            if self.plan(m, Start::Final, self.time_s) {
                self.book();
                self.movers[m].refused_at = None;
                self.movers[m].phase = Phase::Landing;
                taken = self.take(m);
                self.movers[m].phase = before;
            }
            let in_way = self.movers[m].waits_for.filter(|o| self.stands_at_hold(*o));
            match self.exit_of(m).filter(|_| in_way.is_some()) {
                Some(exit) => left_out.push(exit),
                None => break,
            }
        }
        if taken {
            self.draw_cleared_way(m);
        } else {
            self.movers[m] = old;
            self.book();
        }
        taken
    }

    /// Whether this is a departure that stands on its way to the runway: it stays in an exit that it has, until others landed.
    fn stands_at_hold(&self, o: usize) -> bool {
        let departs = self.flights.get(o).is_some_and(|f| f.direction == Direction::Departure);
        departs && self.movers[o].phase == Phase::Taxiing && self.movers[o].v == 0.0
    }

    /// The arc by which the way of a landing leaves the runway.
    fn exit_of(&self, m: usize) -> Option<usize> {
        let off = |a: &&usize| self.net.edges[**a / 2].runway.is_none();
        self.movers[m].way.arcs.iter().find(off).copied()
    }
}
