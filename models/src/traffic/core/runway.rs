//! Runways: who has them, wake, and when somebody may enter.

use super::plan::{CLEARED_BEFORE_S, LANDING_AHEAD_S, READY_S, UP_S};
use super::{Core, Direction, Flight, Phase, TAIL_M};
use crate::flight_list::WakeCategory;
use crate::traffic::network::Network;
#[cfg(test)]
use crate::traffic::runway_roll::NAUTICAL_MILE_M;
use crate::traffic::runway_roll::{TakeOff, approach_time_s, take_off_run};
use crate::wake::Wake;

/// Longest time for which somebody lines up behind one who is still on the runway, s (assumed; the safety net asks after 90 s).
const STANDS_LINED_UP_S: f64 = 75.0;

/// Who takes off towards somebody on final is in the air so much earlier than before another landing, s: it has to turn away. With this
/// the one lifts off a minute and a half before the other is over the threshold (assumed; `RMCA_OPP` looks a minute ahead).
const TURNED_AWAY_S: f64 = 45.0;

impl Core {
    /// Whether the directions of two runway ends enclose more than 120 degrees.
    fn head_on(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        let towards = |(r, end): (usize, usize)| {
            let ends_m = self.net.runways[r].ends_m;
            (ends_m[1 - end] - ends_m[end]).normalize()
        };
        towards(a).dot(&towards(b)) < -0.5
    }

    /// Whether a departure may go onto the runway now: wake, and airborne before the next arrival has to be cleared.
    pub(super) fn may_line_up(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        if self.car_blocks(r) {
            return false;
        }
        let next_s = self.movers.iter().enumerate().filter(|(o, other)| {
            let to_land = other.phase == Phase::Final && !other.cleared;
            to_land && self.crossing[r].contains(&self.flights[*o].runway.0)
        });
        let next_s = next_s.map(|(o, other)| {
            let towards = self.head_on(self.flights[m].runway, self.flights[o].runway);
            other.landing_s - self.time_s - if towards { TURNED_AWAY_S } else { 0.0 }
        });
        let next_s = next_s.fold(f64::INFINITY, f64::min);
        let (wake_s, run_s) = (self.wake_left_s(m), self.run_s(m));
        let need_s = |ready_s: f64| ready_s.max(wake_s) + run_s + UP_S + CLEARED_BEFORE_S;
        // Nobody is lined up at once: what the line-up takes is driven only where it decides.
        if next_s < need_s(READY_S) {
            return false;
        }
        let ready_s = self.lined_up_in_s(m) + READY_S;
        let need_s = need_s(ready_s);
        if wake_s >= ready_s.max(30.0) || next_s < need_s {
            return false;
        }
        // Behind one who is still on it: not before he is off.
        next_s > need_s + 120.0
            || next_s >= self.vacated_in_s(m, r) + run_s + UP_S + CLEARED_BEFORE_S
    }

    /// Until it is lined up when it has the runway now, s: from the holding position, or from where it still rolls towards it.
    fn lined_up_in_s(&self, m: usize) -> f64 {
        let mover = &self.movers[m];
        if mover.v == 0.0 || mover.phase != Phase::Taxiing {
            return mover.line_up_s;
        }
        let driven_s = self.driven_alone_s(m, (mover.s, mover.v, mover.a, mover.slip));
        let r = self.flights[m].runway.0;
        // Who comes to a stop at the holding position just now is taken to be lined up already, and so gets gaps in which one
        // who stands there would not fit: without that departures starve. A backtrack is too long for it.
        let begins = self.owner[r] != Some(m) && backtracked(&self.net, r);
        if begins { driven_s.max(mover.line_up_s) } else { driven_s }
    }

    /// From the holding position to being out of the way in the air, s: line-up (also a backtrack), pause, roll.
    pub(super) fn slot_s(&self, m: usize) -> f64 {
        self.movers[m].line_up_s + READY_S + self.run_s(m) + UP_S
    }

    /// Until who lands or rolls on a runway is off it, s; 0 if nobody does.
    fn vacated_in_s(&self, m: usize, r: usize) -> f64 {
        let Some(o) = self.owner[r].filter(|o| *o != m) else { return 0.0 };
        let other = &self.movers[o];
        match other.phase {
            Phase::Landing | Phase::Taxiing => {
                let exit = other.way.group_last.first().and_then(|k| other.way.ends_m.get(*k));
                let behind_m = 0.95 * self.flights[o].size.length_m + TAIL_M;
                let to_m = exit.map_or(other.s, |e| e + behind_m);
                other.way.alone_to(other.s, other.v, &other.driving, to_m).time_s(to_m)
            }
            Phase::Rolling => {
                self.run_s(o) * (1.0 - other.v / self.lift_off_mps(o)).max(0.0) + UP_S
            }
            _ => 0.0,
        }
    }

    /// Whether a departure may line up behind the one who has its runway: he lands or rolls, is past the place where it
    /// comes onto the runway, and nobody has a runway that crosses it.
    pub(super) fn may_follow(&self, m: usize) -> bool {
        let (r, end) = self.flights[m].runway;
        let Some(o) = self.owner[r].filter(|o| *o != m) else { return false };
        let alone = self.crossing[r].iter().all(|c| *c == r || self.owner[*c].is_none());
        let other = &self.movers[o];
        let same_end = self.flights[o].runway == (r, end);
        if !alone || !same_end || self.behind[r].is_some_and(|b| b != m) || other.v < 5.0 {
            return false;
        }
        if !matches!(other.phase, Phase::Landing | Phase::Rolling) {
            return false;
        }
        let runway = &self.net.runways[r];
        let along = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let theirs = self.state(o).map(|s| along(runway.place_m(s.position_m.xy()).0));
        let tail = 0.5 * self.flights[o].size.length_m + PASSED_M;
        // Who backtracks to his exit is on it for long: nobody stands lined up for that.
        theirs.is_some_and(|p| p - tail > along(self.entry_m(m, runway)))
            && self.vacated_in_s(m, r) < self.movers[m].line_up_s + STANDS_LINED_UP_S
    }

    /// Takes the rest of the runway for a roll: at once, if nobody has any of it. `anyway`: uncleared, whoever has it.
    ///
    /// Its place in the order it has had since the line-up: who holds a part of the strip now leaves it without taking anything.
    pub(super) fn take_roll(&mut self, m: usize, anyway: bool) -> bool {
        let mover = &self.movers[m];
        if mover.refused_at == Some(self.version) && !anyway {
            return false;
        }
        let rest: Vec<u32> = mover.way.pieces[mover.next..].to_vec();
        let behind = self.told_behind(m);
        let blocker = rest.iter().find_map(|z| self.blocker(m, *z, true, &behind));
        if let Some(blocker) = blocker.filter(|_| !anyway) {
            return self.refuse(m, Some(blocker));
        }
        rest.iter().for_each(|z| self.hold(m, *z, true));
        self.keep_for_roll(m, Vec::new());
        let mover = &mut self.movers[m];
        mover.next = mover.way.pieces.len();
        (mover.waits_since_s, mover.waits_for) = (None, None);
        true
    }

    /// Pieces of the roll over which somebody off the strip could go: taken with the line-up, so that who is lined up waits
    /// for nobody who could wait for him.
    pub(super) fn wanted_for_roll(&self, m: usize) -> Vec<u32> {
        let mover = &self.movers[m];
        let class = mover.class;
        let off_strip = |z: &&u32| {
            let conflicts = self.pieces.conflicts(**z as usize, class);
            conflicts.iter().any(|(o, _)| self.pieces.list[*o as usize].off_strip())
        };
        let roll = mover.way.pieces.iter().skip(mover.roll_from);
        roll.filter(off_strip).copied().collect()
    }

    /// Holds these pieces beside its way, and those no more that it has held so.
    pub(super) fn keep_for_roll(&mut self, m: usize, pieces: Vec<u32>) {
        pieces.iter().for_each(|z| self.hold(m, *z, false));
        let before = std::mem::replace(&mut self.movers[m].kept, pieces);
        before.iter().for_each(|z| self.release(m, *z, false));
    }

    /// Somebody lined up on a runway who rolls before `m` is over it, `need_s` from now.
    pub(super) fn rolls_before(&self, m: usize, r: usize, need_s: f64) -> Option<usize> {
        let lined_up = |o: &usize| {
            let ready = matches!(self.movers[*o].phase, Phase::LinedUp(_));
            *o != m && ready && self.wake_left_s(*o) < need_s
        };
        self.owner[r].into_iter().chain(self.behind[r]).find(lined_up)
    }

    /// Somebody on final who is not cleared yet and has to be within `need_s`, for a runway or one that crosses it.
    pub(super) fn arrival_before(&self, m: usize, r: usize, need_s: f64) -> Option<usize> {
        (0..self.movers.len()).find(|o| {
            let other = &self.movers[*o];
            let left = other.landing_s - LANDING_AHEAD_S - self.time_s;
            *o != m
                && other.phase == Phase::Final
                && !other.cleared
                && self.crossing[r].contains(&self.flights[*o].runway.0)
                && left < need_s
        })
    }

    /// Somebody cleared to land, or not yet off the strip after it, on a runway that `m` wants to cross, who has not passed
    /// the place: nobody is ahead of a roll in its strip, also not beyond its exit.
    pub(super) fn lands_towards(&self, m: usize, r: usize) -> Option<usize> {
        let o = self.owner[r].filter(|o| *o != m)?;
        let other = &self.movers[o];
        let rolls = match other.phase {
            Phase::Final => other.cleared,
            Phase::Landing => true,
            // One that waits itself may wait for `m`.
            Phase::Taxiing => {
                self.flights[o].direction == Direction::Arrival && other.waits_since_s.is_none()
            }
            _ => false,
        };
        if !rolls {
            return None;
        }
        let runway = &self.net.runways[r];
        let end = self.flights[o].runway.1;
        let along = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let theirs = self.state(o).map(|s| along(runway.place_m(s.position_m.xy()).0))?;
        let behind_m = theirs - along(self.entry_m(m, runway));
        (behind_m < 30.0).then_some(o)
    }

    /// Whether somebody else holds a part of the strip of a runway.
    pub(super) fn strip_held(&self, m: usize, r: usize) -> bool {
        let of_strip = |z: u32| {
            let piece = &self.pieces.list[z as usize];
            piece.strip == Some(r) || piece.runway == Some(r)
        };
        self.movers.iter().enumerate().any(|(o, other)| {
            let on_way = matches!(
                other.phase,
                Phase::Taxiing | Phase::Landing | Phase::LinedUp(_) | Phase::Rolling
            );
            let held = other.first_held..other.next.min(other.way.pieces.len());
            o != m && on_way && held.into_iter().any(|i| of_strip(other.way.pieces[i]))
        })
    }

    /// Gap between two landings that lets a departure of this runway, or of one that crosses it, out between them, s: the
    /// longest of those who will want it soon; 0 if nobody will.
    pub(super) fn departure_slot_s(&self, runway: (usize, usize)) -> f64 {
        let r = runway.0;
        let wants = |m: &usize| {
            let f = &self.flights[*m];
            let soon = match self.movers[*m].phase {
                Phase::Absent | Phase::Parked => (f.time_s - self.time_s).abs() < 300.0,
                Phase::Pushing | Phase::Starting(_) | Phase::Taxiing => true,
                _ => false,
            };
            soon && f.direction == Direction::Departure && self.crossing[r].contains(&f.runway.0)
        };
        let gap_s = |m: usize| {
            let towards = self.head_on(self.flights[m].runway, runway);
            // On the same runway it lines up behind the landed one, if he is off soon; else it waits until he is off.
            let off_s = self.occupied_s[r];
            let soon = off_s - PASSES_S < self.movers[m].line_up_s + STANDS_LINED_UP_S;
            let same = self.flights[m].runway.0 == runway.0 && soon && !towards;
            let line_up_s = self.movers[m].line_up_s + READY_S;
            let from_s = if same { (PASSES_S + line_up_s).max(off_s) } else { off_s + line_up_s };
            let away_s = if towards { TURNED_AWAY_S } else { 0.0 };
            from_s + self.run_s(m) + UP_S + CLEARED_BEFORE_S + SLACK_S + away_s
        };
        (0..self.movers.len()).filter(wants).map(gap_s).fold(0.0, f64::max)
    }

    /// Gap between two landings that lets somebody over this runway, or one that crosses it, between them, s: the longest of
    /// those who want to cross soon; 0 if nobody does. Who lands goes first: without it who crosses would starve.
    pub(super) fn crossing_slot_s(&self, r: usize) -> f64 {
        let under_way = |m: &usize| {
            let phase = self.movers[*m].phase;
            matches!(phase, Phase::Pushing | Phase::Starting(_) | Phase::Taxiing)
        };
        let crosses = |m: usize| {
            let mover = &self.movers[m];
            let (way, takes_s) = (&mover.way, &mover.timing.take_s);
            let soon = move |k: usize| {
                let planned_s = takes_s.get(k).map_or(self.time_s, |take| *take);
                k == mover.next || k > mover.next && planned_s < self.time_s + CROSSES_SOON_S
            };
            let ahead =
                way.crossings.iter().filter(move |(k, c)| soon(*k) && self.crossing[r].contains(c));
            ahead.map(move |(k, _)| way.ends_m[way.group_last[*k]] - self.stop_before_m(m, *k))
        };
        let longest_m =
            (0..self.movers.len()).filter(under_way).flat_map(crosses).fold(0.0, f64::max);
        if longest_m == 0.0 {
            return 0.0;
        }
        self.occupied_s[r].min(MOST_PASSES_S) + over_s(longest_m) + LANDING_AHEAD_S + SLACK_S
    }

    /// Gap between two landings where they backtrack, s: the one before is off when the next one is to be cleared; else 0.
    pub(super) fn backtrack_gap_s(&self, r: usize) -> f64 {
        if backtracked(&self.net, r) {
            self.occupied_s[r] + CLEARED_BEFORE_S + SLACK_S
        } else {
            0.0
        }
    }

    /// Until a departure that has a runway on which one backtracks is out of the way of a landing, s: longer than a final
    /// takes, so that who is not on final yet counts too; else 0.
    pub(super) fn backtracks_for_s(&self, r: usize) -> f64 {
        let leaves = |o: &usize| {
            let ready = matches!(self.movers[*o].phase, Phase::Taxiing | Phase::LinedUp(_));
            ready && self.flights[*o].direction == Direction::Departure
        };
        let owner = self.owner[r].filter(|_| backtracked(&self.net, r)).filter(leaves);
        owner.map_or(0.0, |o| {
            let line_up_s = match self.movers[o].phase {
                Phase::Taxiing => self.lined_up_in_s(o),
                _ => 0.0,
            };
            line_up_s + READY_S + self.run_s(o) + UP_S + CLEARED_BEFORE_S + SLACK_S
        })
    }

    /// Whether somebody else has this runway or one that crosses it.
    pub(super) fn owned(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        self.crossing[r].iter().any(|c| self.owner[*c].is_some_and(|o| o != m))
    }

    /// For whom a departure waits that may not enter its runway: for who has it or one that crosses it, else for who lands
    /// there next.
    pub(super) fn kept_off_by(&self, m: usize) -> Option<usize> {
        let crossing = &self.crossing[self.flights[m].runway.0];
        let owner = crossing.iter().find_map(|c| self.owner[*c].filter(|o| *o != m));
        let lands = |o: &usize| {
            let other = &self.movers[*o];
            let to_land = other.phase == Phase::Final && !other.cleared;
            to_land && crossing.contains(&self.flights[*o].runway.0)
        };
        owner.or_else(|| {
            let next = (0..self.movers.len()).filter(lands);
            next.min_by(|a, b| self.movers[*a].landing_s.total_cmp(&self.movers[*b].landing_s))
        })
    }

    /// Off the runway: the next one may have it.
    pub(super) fn vacate(&mut self, m: usize) {
        self.by_sight.retain(|o| *o != m);
        let r = self.flights[m].runway.0;
        if self.flights[m].direction == Direction::Arrival && self.owner[r] == Some(m) {
            let most_s = if backtracked(&self.net, r) { MOST_BACK_S } else { MOST_OFF_S };
            let took_s = (self.time_s - self.movers[m].landing_s).clamp(OFF_S, most_s);
            self.occupied_s[r] = 0.5 * (self.occupied_s[r] + took_s);
        }
        for (owner, behind) in self.owner.iter_mut().zip(&mut self.behind) {
            if *behind == Some(m) {
                *behind = None;
            }
            if *owner == Some(m) {
                *owner = behind.take();
            }
        }
    }

    pub(super) fn wake_left_s(&self, m: usize) -> f64 {
        let r = self.flights[m].runway.0;
        let behind = self.crossing[r].iter().filter_map(|c| self.last_take_off[*c]);
        let run_s = self.run_s(m);
        let left = behind.map(|before| {
            let gap_s = before.wake.departure_gap_s(self.flights[m].wake) - self.time_s;
            // From roll to roll and from lift-off to lift-off.
            (before.rolled_s + gap_s).max(before.airborne_s + gap_s - run_s)
        });
        left.fold(0.0, f64::max)
    }

    /// From the begin of a take-off run to the lift-off, s.
    pub(super) fn run_s(&self, m: usize) -> f64 {
        SPOOL_S + take_off_run(&self.take_off(m)).map_or(40.0, |r| r.time_s)
    }

    /// The take-off run of a flight on this day, m; without wind at sea level where it could not lift off.
    pub(super) fn run_m(&self, m: usize) -> f64 {
        let (f, head_mps) = (&self.flights[m], self.head_mps(m));
        f.run_m(self.day.density_ratio, head_mps).unwrap_or(f.take_off.1)
    }

    /// Over the ground at lift-off, m/s.
    pub(super) fn lift_off_mps(&self, m: usize) -> f64 {
        let day = self.take_off(m);
        let airspeed_mps = day.liftoff_mps / day.density_ratio.sqrt();
        (airspeed_mps - day.headwind_mps).max(1.0)
    }

    /// The take-off of a flight on this day.
    pub(super) fn take_off(&self, m: usize) -> TakeOff {
        self.flights[m].take_off_on(self.day.density_ratio, self.head_mps(m))
    }

    pub(super) fn may_roll(&self, m: usize) -> bool {
        self.wake_left_s(m) <= 0.0
            && !self.car_blocks(self.flights[m].runway.0)
            && (!self.owned(m) || self.waits_in_front(m) || self.goes_first(m))
    }

    /// Whether everybody who has a runway that crosses its own is lined up there and goes after it: he came later, or it stands in his way.
    /// Two that are lined up on crossing runways, one of them by mistake, would wait for each other.
    fn goes_first(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        let Phase::LinedUp(since_s) = self.movers[m].phase else { return false };
        let after = |o: usize| match self.movers[o].phase {
            Phase::LinedUp(then_s) => {
                let waits = self.movers[o].waits_for == Some(m);
                let blocked = self.movers[m].waits_for == Some(o);
                waits || !blocked && (since_s, m) < (then_s, o)
            }
            _ => false,
        };
        let others = self.crossing[r].iter().filter_map(|c| self.owner[*c].filter(|o| *o != m));
        self.owner[r] == Some(m) && others.into_iter().all(after)
    }
}
/// How far the tail of one who rolls is beyond an entry when somebody may line up there, m (assumed).
const PASSED_M: f64 = 60.0;
/// From the threshold to having passed an entry near it, and to being off the runway at least and at most, s (assumed, for
/// spacing: between, what the last landings took).
const PASSES_S: f64 = 12.0;
const OFF_S: f64 = 60.0;
const MOST_OFF_S: f64 = 200.0;
/// From the threshold to having passed who wants to cross, at most, s (assumed, for spacing).
const MOST_PASSES_S: f64 = 120.0;
/// The same where landings may have to backtrack, s, and how fast the runway is driven then before any did, m/s.
const MOST_BACK_S: f64 = 500.0;
const BACK_MPS: f64 = 14.0;

/// Whether flights backtrack on a runway.
fn backtracked(net: &Network, r: usize) -> bool {
    net.runways[r].turn_pads.contains(&true)
}

/// What a landing is taken to need on a runway before one did, s.
pub(super) fn occupied_first_s(net: &Network, r: usize) -> f64 {
    let back_s = net.runways[r].length_m / BACK_MPS;
    OFF_S + if backtracked(net, r) { back_s } else { 0.0 }
}
/// Who is to cross a runway within this time is given room for it, s (assumed; more keeps landings off busy runways).
const CROSSES_SOON_S: f64 = 120.0;

/// From a holding position over a runway, so far to where the body is beyond it, s (assumed).
pub(super) fn over_s(length_m: f64) -> f64 {
    15.0 + 0.16 * length_m
}

/// Room in the gap between two landings, s (assumed).
const SLACK_S: f64 = 12.0;

/// What the building-up of thrust adds to a take-off run, s.
const SPOOL_S: f64 = 2.5;

/// The last take-off on a runway.
#[derive(Clone, Copy, Debug)]
pub(super) struct TookOff {
    pub rolled_s: f64,
    pub airborne_s: f64,
    pub wake: Wake,
}

/// Time between arrivals on one runway, s: 3.8 NM at 70 m/s, light ones 6 NM (assumed), and at the follower's speed the
/// distance that its wake category wants behind the one before, with 0.3 NM of room.
pub(super) fn arrival_gap_s(first: Wake, then: &Flight, head_mps: f64) -> f64 {
    let usual_s = if then.wake.icao == WakeCategory::Light { 170.0 } else { 130.0 };
    let apart_nm = first.landing_gap_nm(then.wake) + 0.3;
    let wake_s = approach_time_s(then.landing.0, head_mps, apart_nm.max(4.0)).unwrap_or(usual_s);
    wake_s.max(usual_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_follower_of_a_super_keeps_seven_miles() {
        let follower = |wake: WakeCategory, touchdown: f64| Flight {
            callsign: String::new(),
            size: crate::traffic::outline::Size { length_m: 40.0, span_m: 35.0, aircraft: true },
            direction: super::super::Direction::Arrival,
            runway: (0, 0),
            stand: 0,
            time_s: 0.0,
            ctot_s: None,
            turnaround_of: None,
            wake: wake.into(),
            taxi_mps: (15.0, 5.0),
            taxi_acc_mps2: (0.7, 0.7),
            take_off: (85.0, 1600.0),
            landing: (touchdown, 1.2),
            wheelbase_m: 12.0,
            idle_kg_per_s: 0.2,
            key: 1,
        };
        use WakeCategory::{Light, Medium, Super};
        for touchdown in [62.0, 70.0, 78.0] {
            let gap_s = arrival_gap_s(Super.into(), &follower(Medium, touchdown), 0.0);
            // Flown at the slowest speed of the approach it is at least the distance.
            assert!(gap_s * 82.5 > 7.0 * NAUTICAL_MILE_M, "{touchdown}: {gap_s}");
            assert!(gap_s < 7.0 * NAUTICAL_MILE_M / touchdown + 15.0, "{touchdown}: {gap_s}");
            assert_eq!(arrival_gap_s(Medium.into(), &follower(Medium, touchdown), 0.0), 130.0);
        }
        assert!(arrival_gap_s(Super.into(), &follower(Light, 50.0), 0.0) > 230.0);
    }
}
