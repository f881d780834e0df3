//! One step along a way, under the authority.

use super::{ASK_M, Core, Direction, Phase, TAIL_M, Timing};
use crate::control::clearance::ClearanceKind;
use crate::draw::uniform;
use crate::traffic::profile::{stopping, stopping_speed_mps};
use crate::traffic::tractrix;
use crate::traffic::way::{Driving, Way};

/// Brakes build up so fast in a landing roll, m/s³ (assumed).
pub(super) const ROLL_JERK_MPS3: f64 = 2.0;

impl Core {
    /// One step along the way in use, under the authority.
    pub(super) fn drive(&mut self, m: usize) {
        self.take_ahead(m);
        let d = self.movers[m].driving;
        let authority = self.authority(m);
        let sight = self.wish_by_sight(m);
        let mover = &mut self.movers[m];
        let (s, v, a) = (mover.s, mover.v, mover.a);
        let wheelbase_m = self.flights[m].wheelbase_m;
        let (wish, acc) = wish_mps(&mover.way, &d, wheelbase_m, (s, v, mover.slip), authority);
        let stands = mover.holds || self.time_s < mover.stopped_until_s;
        let wish = if stands { 0.0 } else { wish };
        // Nobody creeps up by centimetres.
        let wish = if v == 0.0 && authority - s < 0.5 { 0.0 } else { wish };
        let wish = if mover.stopped { 0.0 } else { wish.min(mover.most_mps()) };
        let (wish, dec, jerk) = match sight {
            Some((most, hard)) if most < wish => (most, hard, 2.0),
            _ => (wish, d.dec_mps2, d.jerk_mps3),
        };
        // Stops are planned with 0.85 of the braking at most: so much is left of it in any case.
        let beside = mover.beside_mps2();
        let (acc, dec) = ((acc - beside).max(0.15 * d.acc_mps2), dec - beside.min(0.15 * dec));
        let limits = Tick { acc, dec, jerk, dt: self.step_s };
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, authority);
        self.follow(m, s);
        self.release_behind(m);
    }

    /// Takes the pieces ahead that it needs at its speed, as far as it may.
    pub(super) fn take_ahead(&mut self, m: usize) {
        let d = self.movers[m].driving;
        let (dec, jerk) = match self.movers[m].phase {
            Phase::Landing => (self.movers[m].off_mps2, ROLL_JERK_MPS3),
            _ => (d.dec_mps2, d.jerk_mps3),
        };
        loop {
            let mover = &self.movers[m];
            let authority = self.authority(m);
            let needed = stopping(mover.v, mover.a.max(0.0), 0.8 * dec, jerk, self.step_s).0
                + mover.v * self.step_s
                + ASK_M;
            let enough = needed <= authority - mover.s;
            if mover.next >= mover.way.pieces.len() || enough || mover.stopped {
                break;
            }
            let departure = self.flights[m].direction == Direction::Departure;
            // The rest of the runway is taken for the roll.
            if departure && mover.next == mover.roll_from {
                break;
            }
            let departs = departure && mover.next == mover.threshold as usize;
            let uncleared = self.enters_uncleared(m).filter(|_| departs);
            let follows = departs && self.may_follow(m);
            let may = !departs
                || (follows || !self.owned(m))
                    && self.may_line_up(m)
                    && self.lacks_runway_ahead(m).is_none()
                    && self.permitted(m, ClearanceKind::LineUp)
                    && !self.bar_sticks(self.flights[m].runway.0);
            let told = departs
                && self.movers[m].insisted.has(ClearanceKind::LineUp)
                && !self.bar_sticks(self.flights[m].runway.0);
            if uncleared.is_none() && !may && !told {
                let now = self.time_s;
                self.movers[m].waits_since_s.get_or_insert(now);
                self.movers[m].waits_for = self.kept_off_by(m);
                break;
            }
            if !self.take(m) {
                break;
            }
            if departs {
                self.used(m, ClearanceKind::LineUp);
                let r = self.flights[m].runway.0;
                if told && !may {
                    if self.owned(m) {
                        self.goes_by_sight(m);
                    }
                    self.joins_runway(m);
                } else if follows && uncleared.is_none() {
                    self.behind[r] = Some(m);
                } else {
                    self.owner[r] = Some(m);
                }
                match uncleared {
                    Some(failure) => self.begin_failure(failure),
                    None => self.clear(m, "LUP", self.end_name(m)),
                }
            }
        }
    }

    /// Gives back the pieces that its tail has left.
    pub(super) fn release_behind(&mut self, m: usize) {
        let behind = self.reach_m(m).1;
        loop {
            let mover = &self.movers[m];
            let i = mover.first_held;
            if i >= mover.next
                || i + 1 >= mover.way.pieces.len()
                || mover.s <= mover.way.ends_m[i] + behind
            {
                break;
            }
            let of = |k: usize| self.pieces.list[mover.way.pieces[k] as usize].strip;
            let (strip, then) = (of(i), of(i + 1));
            self.leave_first_held(m);
            if let Some(r) = strip.filter(|_| strip != then) {
                // Its own runway may adjoin another one's.
                self.is_off_runway(m, r);
                // Who departs may have its own runway before its tail is over one that it crosses.
                let lands = self.flights[m].direction == Direction::Arrival;
                if then.is_none() && (lands || r == self.flights[m].runway.0) {
                    self.vacate(m);
                    self.end_clearance(m, "LND");
                }
            }
        }
    }

    /// The tail of a landing is beyond the line of its runway: from now on it taxies in.
    fn is_off_runway(&mut self, m: usize, r: usize) {
        let (f, now) = (&self.flights[m], self.time_s);
        let measures = &mut self.movers[m].measures;
        if f.direction == Direction::Arrival
            && r == f.runway.0
            && measures.aldt_s.is_some()
            && measures.on_runway_s[1].is_none()
        {
            measures.on_runway_s[1] = Some(now);
            self.movers[m].taxi_from_s = now;
        }
    }

    /// The nose of a departure is over the line of its runway.
    fn comes_over_line(&mut self, m: usize) {
        let line = self.movers[m].threshold as usize;
        if self.movers[m].next <= line || self.movers[m].measures.on_runway_s[0].is_some() {
            return;
        }
        let hold_gap_m = self.movers[m].hold_gap_m;
        if self.movers[m].s > self.stop_before_m(m, line) + hold_gap_m {
            self.movers[m].measures.on_runway_s[0] = Some(self.time_s);
        }
    }

    /// Gives back the first piece that it holds; it has crossed the runways in whose strips, or over whose pavement, it holds no other.
    pub(super) fn leave_first_held(&mut self, m: usize) {
        let mover = &self.movers[m];
        let (i, of) =
            (mover.first_held, |k: usize| &self.pieces.list[mover.way.pieces[k] as usize]);
        let (z, roll) = (mover.way.pieces[i], mover.way.roll.contains(&i));
        let mut crossed: Vec<usize> = of(i).strip.into_iter().chain(of(i).over).collect();
        if !crossed.is_empty() {
            // Who leaves at a side from which he comes back over a runway may have taken that, too; his roll is cleared by itself.
            let ahead = (i + 1..mover.next).filter(|k| !mover.way.roll.contains(k)).map(of);
            let ahead: Vec<usize> = ahead.flat_map(|p| p.strip.into_iter().chain(p.over)).collect();
            crossed.retain(|r| !ahead.contains(r));
        }
        self.release(m, z, roll);
        self.movers[m].first_held += 1;
        crossed.into_iter().for_each(|r| self.end_crossing(m, r));
    }

    /// From a place of its way, a speed, an acceleration and a slip to standing at its end, alone, s: driven with the same
    /// wishes, in steps of [`DRY_S`].
    pub(super) fn driven_alone_s(&self, m: usize, from: (f64, f64, f64, f64)) -> f64 {
        let (mover, wheelbase_m) = (&self.movers[m], self.flights[m].wheelbase_m);
        let (way, d) = (&mover.way, &mover.driving);
        let ((mut s, mut v, mut a, mut slip), mut time_s) = (from, 0.0);
        while s < way.stop_m && time_s < MOST_DRY_S {
            let (wish, acc) = wish_mps(way, d, wheelbase_m, (s, v, slip), way.stop_m);
            let limits = Tick { acc, dec: d.dec_mps2, jerk: d.jerk_mps3, dt: DRY_S };
            let before = s;
            (s, v, a) = limits.tick(s, v, a, wish, way.stop_m);
            if s > before {
                let heading_rad = |ahead: f64| way.path.heading_rad(before + ahead);
                slip = tractrix::drawn_slip_rad(slip, s - before, wheelbase_m, heading_rad);
            }
            time_s += DRY_S;
            if v == 0.0 && a == 0.0 {
                break;
            }
        }
        time_s
    }

    /// Up to where the guided point may go.
    pub(super) fn authority(&self, m: usize) -> f64 {
        self.stop_before_m(m, self.movers[m].next)
    }

    /// Where the guided point stops while `next` is the first step that is not taken, m.
    pub(super) fn stop_before_m(&self, m: usize, next: usize) -> f64 {
        let mover = &self.movers[m];
        mover.way.stop_before_m(next, self.reach_m(m).0, mover.hold_gap_m)
    }

    /// Nose ahead of the guided point of a mover, and end of its tail behind it, m.
    pub(super) fn reach_m(&self, m: usize) -> (f64, f64) {
        let length_m = self.flights[m].size.length_m;
        (0.1 * length_m, 0.95 * length_m + TAIL_M)
    }

    /// The main gear is drawn behind.
    pub(super) fn follow(&mut self, m: usize, from: f64) {
        let wheelbase = self.flights[m].wheelbase_m;
        let mover = &mut self.movers[m];
        let ds = mover.s - from;
        if ds > 0.0 {
            let path = &mover.way.path;
            let heading_rad = |ahead: f64| path.heading_rad(from + ahead);
            mover.slip = tractrix::drawn_slip_rad(mover.slip, ds, wheelbase, heading_rad);
            mover.wander.bends(ds, heading_rad);
            self.wanders(m, ds);
        }
    }

    /// Nose, tail, and the gap that it keeps before strips, m.
    pub(super) fn body_m(&self, m: usize) -> (f64, f64, f64) {
        let (ahead_m, behind_m) = self.reach_m(m);
        (ahead_m, behind_m, self.movers[m].hold_gap_m)
    }

    pub(super) fn taxiing(&mut self, m: usize) {
        if self.movers[m].hand.is_some() {
            self.taxi_by_hand(m);
            return;
        }
        let mover = &self.movers[m];
        let departs = self.flights[m].direction == Direction::Departure;
        let at_line = departs && mover.v == 0.0 && mover.next == mover.threshold as usize;
        if at_line && self.turned_back_by_runway(m) {
            return;
        }
        self.drive(m);
        if departs {
            self.comes_over_line(m);
        }
        let mover = &self.movers[m];
        let to = mover.way.pieces.len().min(mover.roll_from);
        if mover.v != 0.0 || mover.next < to || mover.way.stop_m - mover.s > 0.6 {
            return;
        }
        let now = self.time_s;
        if self.flights[m].direction == Direction::Departure {
            let mut rng = self.rng(m, 3);
            let ready = 5.0 + 5.0 * uniform(&mut rng);
            let mover = &mut self.movers[m];
            mover.phase = Phase::LinedUp(now + ready);
            mover.measures.taxi_s = Some(now - mover.measures.aobt_s.unwrap_or(now));
            self.end_clearance(m, "TAX");
            return;
        }
        if self.is_vehicle(m) {
            self.arrives_to_stay(m);
            return;
        }
        // On its stand: keeps what is under it.
        let size = self.flights[m].size;
        let parked = self.pieces_of_stand(self.movers[m].stand, size);
        parked.iter().for_each(|z| self.hold(m, *z, false));
        self.release_held(m);
        let mover = &mut self.movers[m];
        mover.parked_pieces = parked;
        mover.phase = Phase::Docked;
        mover.timing = Timing::default();
        mover.measures.aibt_s = Some(now);
        mover.measures.taxi_s = Some(now - mover.taxi_from_s);
        self.end_clearance(m, "TAX");
    }
}

/// Step, and longest time, of a drive that is only reckoned, s.
const DRY_S: f64 = 0.2;
const MOST_DRY_S: f64 = 900.0;

/// Speed that is wished at a place with a speed and a slip, m/s, and the acceleration that is left for it, m/s²: the way's
/// limits, the stop ahead, and what a body gains while it swings into line.
fn wish_mps(
    way: &Way,
    d: &Driving,
    wheelbase_m: f64,
    (s, v, slip): (f64, f64, f64),
    stop_m: f64,
) -> (f64, f64) {
    let wish = (0.98 * way.most_mps(s).min(way.most_mps(s + 0.4 * v))).min(stopping_speed_mps(
        stop_m - s,
        0.7 * d.dec_mps2,
        Some(d.jerk_mps3),
    ));
    let sin = libm::sin(slip).abs();
    let swing = v * v * sin * sin / wheelbase_m;
    let steady_mps = (0.85 * d.acc_mps2 * wheelbase_m).sqrt() / sin.max(1e-3);
    (wish.min(steady_mps), (d.acc_mps2 - swing).max(0.15 * d.acc_mps2))
}

/// One step of a speed that follows a wish with limited acceleration and jerk.
pub(super) struct Tick {
    pub(super) acc: f64,
    pub(super) dec: f64,
    pub(super) jerk: f64,
    pub(super) dt: f64,
}

impl Tick {
    /// Place, speed and acceleration after the step; never beyond `stop`, where standing is exact.
    pub(super) fn tick(&self, s: f64, v: f64, a: f64, wish: f64, stop: f64) -> (f64, f64, f64) {
        let Self { acc, dec, jerk, dt } = *self;
        if v == 0.0 && wish == 0.0 {
            return (s, 0.0, 0.0);
        }
        let gap = stop - s;
        if v < 0.05 && gap < 0.15 {
            return (s, 0.0, 0.0);
        }
        let error = wish - v;
        let reach = |e: f64| {
            let half = 0.5 * jerk * dt;
            ((half * half + 2.0 * jerk * e).sqrt() - half).max(0.0)
        };
        let mut want = if error >= 0.0 { reach(error).min(acc) } else { -(reach(-error).min(dec)) };
        let towards = |want: f64| want.clamp(a - jerk * dt, a + jerk * dt).clamp(-dec, acc);
        // Braking begins where the stop with the jerk limit needs it: the acceleration has to come down first. What counts is
        // where this step would lead: one more step of gaining speed can cost more way than is left.
        let ahead = towards(want);
        let then_mps = (v + 0.5 * (a + ahead) * dt).max(0.0);
        let gone_m = 0.5 * (v + then_mps) * dt;
        if gap > 0.0 && gone_m + stopping(then_mps, ahead, 0.85 * dec, jerk, 0.0).0 >= gap {
            want = -dec;
        }
        let next = towards(want);
        let faster = v + 0.5 * (a + next) * dt;
        if faster <= 0.0 {
            let moved = if v > 0.0 { 0.5 * v * dt } else { 0.0 };
            return ((s + moved).min(stop.max(s)), 0.0, 0.0);
        }
        let moved = 0.5 * (v + faster) * dt;
        if moved >= gap {
            return (stop.max(s), 0.0, 0.0);
        }
        (s + moved, faster, next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From standing to a stop a few metres ahead: never a step that brakes harder than the type, also not the last one, by
    /// which the naive rule (brake when the stop of *this* moment needs it) stood still at once from up to 0.2 m/s.
    #[test]
    fn a_crawl_ends_without_a_jolt() {
        let limits = Tick { acc: 0.7, dec: 0.7, jerk: 0.6, dt: 0.05 };
        for decimetres in 5..400 {
            let stop = f64::from(decimetres) * 0.1;
            let (mut s, mut v, mut a, mut steps) = (0.0, 0.0, 0.0, 0);
            while s < stop - 0.15 {
                let wish = stopping_speed_mps(stop - s, 0.7 * limits.dec, Some(limits.jerk));
                let before = v;
                (s, v, a) = limits.tick(s, v, a, wish.min(5.0), stop);
                let braking = (before - v) / limits.dt;
                assert!(braking < 1.0, "{stop} m: {braking} m/s2 at {s} m");
                steps += 1;
                assert!(steps < 1000, "{stop} m: at {s} m after {steps} steps");
                if v == 0.0 && before > 0.0 {
                    break;
                }
            }
            assert!((stop - s).abs() < 0.6, "{stop} m: stands at {s} m");
        }
    }
}
