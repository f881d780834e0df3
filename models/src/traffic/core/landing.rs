//! From the final to off the runway: final, go-around, landing roll and turn-off.

use super::drive::Tick;
use super::failures::FailureKind;
use super::{Core, Phase, SLOPE, Timing};
use crate::control::clearance::ClearanceKind;
use crate::frames::Azimuth;
use crate::traffic::path::Path;
use crate::traffic::profile::{stopping, stopping_speed_mps};
use crate::traffic::runway_roll::{NAUTICAL_MILE_M, approach_airspeed_mps};
use crate::traffic::way::{Driving, Roll, Way};

/// Brakes build up so fast in a landing roll, m/s³ (assumed).
pub(super) const ROLL_JERK_MPS3: f64 = 2.0;
/// Height at which the flare begins, m, and the sink that is left at its end, m/s (traffic.md 2.6).
const FLARE_M: f64 = 15.0;
const TOUCHES_MPS: f64 = 0.6;

/// Way over the ground on which the sink of the slope falls linearly to [`TOUCHES_MPS`], m: `T = 2 h/(c + 0.6)`.
pub(super) fn flare_m(touchdown_mps: f64) -> f64 {
    2.0 * FLARE_M / (SLOPE + TOUCHES_MPS / touchdown_mps.max(1.0))
}

/// Height on final so far before the touchdown, m: the slope down to the begin of the flare, then that.
pub(super) fn final_height_m(before_m: f64, flare_m: f64) -> f64 {
    if before_m >= flare_m {
        return FLARE_M + SLOPE * (before_m - flare_m);
    }
    // The slope falls linearly from the one to that of the end: h = g x + (s - g) x^2/(2 L), at x before the touchdown.
    let (x, end) = (before_m.max(0.0), 2.0 * FLARE_M / flare_m - SLOPE);
    end * x + (SLOPE - end) * x * x / (2.0 * flare_m)
}

/// Stops on an exit, and what lies behind it, are planned with this share of the braking (assumed).
pub(super) const STOPS_SHARE: f64 = 0.8;

/// Speed from which who leaves a runway stops within `stop_m`, m/s: with the braking of an exit for `off_m`, and from there on as
/// who taxies.
pub(super) fn off_speed_mps(d: &Driving, off_mps2: f64, (off_m, stop_m): (f64, f64)) -> f64 {
    let off_m = off_m.clamp(0.0, stop_m.max(0.0));
    let dec_mps2 = STOPS_SHARE * off_mps2;
    let taxies_mps =
        stopping_speed_mps(stop_m - off_m, STOPS_SHARE * d.dec_mps2, Some(d.jerk_mps3));
    // Brakes build up: so much of the way goes by before they do.
    let braked_m = (off_m - taxies_mps * dec_mps2 / (2.0 * ROLL_JERK_MPS3)).max(0.0);
    (taxies_mps * taxies_mps + 2.0 * dec_mps2 * braked_m).sqrt()
}

/// How somebody on final comes to the speed that he is to have, m/s².
pub(super) fn final_mps2(wish: f64, v: f64, a: f64, dt: f64) -> f64 {
    ((wish - v) / 1.0).clamp(-1.0, 0.5).clamp(a - dt, a + dt)
}

impl Core {
    pub(super) fn on_final(&mut self, m: usize) {
        let f = self.flights[m].clone();
        let (dt, head_mps) = (self.step_s, self.head_mps(m));
        let mover = &mut self.movers[m];
        let distance = (mover.threshold - mover.s).max(0.0);
        let over = (mover.s - mover.threshold) / (mover.touchdown - mover.threshold).max(1.0);
        let before_m = mover.touchdown - mover.s;
        let wish = if over > 0.0 {
            f.landing.0 * (1.03 - 0.03 * over.min(1.0))
        } else {
            approach_airspeed_mps(distance, f.landing.0)
        };
        let a = final_mps2(wish - head_mps, mover.v, mover.a, dt);
        let joined = mover.join.as_ref().is_some_and(|join| join.ends_s() <= self.time_s);
        if joined {
            mover.join = None;
        }
        mover.s += mover.v * dt;
        mover.v += a * dt;
        mover.a = a;
        if mover.s >= mover.threshold && mover.measures.on_runway_s[0].is_none() {
            mover.measures.on_runway_s[0] = Some(self.time_s);
        }
        let before = mover.height_m;
        mover.height_m = final_height_m(before_m, mover.flare_m);
        mover.climb_mps = (mover.height_m - before) / dt;
        let (cleared, down) = (mover.cleared, mover.s >= mover.touchdown);
        // It calls at four miles; what it is told holds from when the runway is its own.
        let told =
            !cleared && distance < 4.0 * NAUTICAL_MILE_M && self.permitted(m, ClearanceKind::Land);
        if !cleared && distance < 2.0 * NAUTICAL_MILE_M {
            // Taken at once: the landing group, if the runway is free and the exit beyond it.
            let r = self.flights[m].runway.0;
            let free = !self.owned(m) && !self.car_blocks(r) && !self.strip_held(m, r);
            if told && free && self.take_landing(m) {
                self.used(m, ClearanceKind::Land);
                self.owner[r] = Some(m);
                self.movers[m].cleared = true;
                match self.failing(m, FailureKind::ForgetLandingClearance) {
                    Some(failure) => self.begin_failure(failure),
                    None => self.clear(m, "LND", self.end_name(m)),
                }
                self.clear_against(m);
            } else if distance < self.decides_at_m(m)
                && self.movers[m].insisted.has(ClearanceKind::Land)
                && self.take_told(m)
            {
                // A person's word, whoever has the runway.
                self.used(m, ClearanceKind::Land);
                self.joins_runway(m);
                self.goes_by_sight(m);
                self.movers[m].cleared = true;
                self.clear(m, "LND", self.end_name(m));
            } else if distance < self.decides_at_m(m) {
                let waits_for = self.movers[m].waits_for;
                let owner =
                    self.crossing[r].iter().find_map(|c| self.owner[*c].filter(|o| *o != m));
                let name = |o: usize| match self.movers.get(o) {
                    Some(other) => format!("{} ({:?})", self.flights[o].callsign, other.phase),
                    None => self.name_of(o).to_owned(),
                };
                let why = match (owner, waits_for) {
                    (Some(o), _) => format!("runway taken by {}", name(o)),
                    (None, Some(o)) => format!("in the way: {}", name(o)),
                    (None, None) => "others could not finish".into(),
                };
                self.go_around(m, &why);
                return;
            }
        }
        let r = self.flights[m].runway.0;
        if cleared && distance > 0.0 && distance < NAUTICAL_MILE_M && self.car_blocks(r) {
            self.give_up_landing(m, "a vehicle is on the runway");
            return;
        }
        if let Some(o) = self.seen_on_runway(m).filter(|_| cleared) {
            let why = format!("{} is on the runway", self.name_of(o));
            self.give_up_landing(m, &why);
            return;
        }
        if down {
            let now = self.time_s;
            let mover = &mut self.movers[m];
            (mover.height_m, mover.climb_mps) = (0.0, 0.0);
            mover.phase = Phase::Landing;
            mover.measures.aldt_s = Some(now);
            mover.ready_s = now + 2.0;
        }
    }

    /// Distance from the threshold at which an arrival that is not cleared goes around, m: a mile, and before it would be
    /// without clearance half a minute from the threshold. For what nobody has cleared, a mile.
    fn decides_at_m(&self, m: usize) -> f64 {
        let known = !self.car_blocks(self.flights[m].runway.0)
            && self.failing(m, FailureKind::ForgetLandingClearance).is_none();
        let half_minute_m = if known { 31.0 * self.movers[m].v } else { 0.0 };
        half_minute_m.max(NAUTICAL_MILE_M)
    }

    pub(super) fn go_around(&mut self, m: usize, why: &str) {
        self.remark(format!("{} goes around: {why}", self.flights[m].callsign));
        let mover = &mut self.movers[m];
        mover.phase = Phase::GoAround;
        mover.measures.go_arounds += 1;
        mover.wants = None;
        (mover.waits_since_s, mover.waits_for) = (None, None);
        mover.parked_pieces.clear();
        mover.timing = Timing::default();
        (mover.granted, mover.insisted) = Default::default();
        // Straight on over the runway.
        let here = mover.way.path.at(mover.s);
        let ahead = here.at_m + Azimuth::from_rad(here.heading_rad).unit() * 30_000.0;
        let (path, _) = Path::over(&[here.at_m, ahead], |_, _| 0.0);
        mover.way = Way::straight(path);
        // The threshold stays where it is: it flies on beside the line as it did.
        mover.threshold -= mover.s;
        (mover.s, mover.next, mover.first_held) = (0.0, 0, 0);
        self.book();
        self.clear(m, "GOA", self.end_name(m));
    }

    pub(super) fn going_around(&mut self, m: usize) {
        let dt = self.step_s;
        let mover = &mut self.movers[m];
        mover.s += mover.v * dt;
        mover.a *= 0.9;
        mover.v += mover.a * dt;
        mover.climb_mps = (mover.climb_mps + 1.5 * dt).min(0.0875 * mover.v);
        mover.height_m += mover.climb_mps * dt;
        if mover.height_m >= 900.0 {
            let again = self.time_s + 600.0;
            let mover = &mut self.movers[m];
            mover.phase = Phase::Absent;
            mover.landing_s = again;
            mover.way = Way::default();
            self.end_clearance(m, "GOA");
        }
    }

    /// The landing roll, and the exit as long as it is faster there than it taxies.
    pub(super) fn landing(&mut self, m: usize) {
        let now = self.time_s;
        let mover = &self.movers[m];
        let off = mover.s >= mover.way.turns_off_m().unwrap_or(mover.way.stop_m);
        if off {
            // Where there is no room between the strip of another runway and that of its own, its landing takes it off both.
            for r in std::mem::take(&mut self.movers[m].way.lands_over) {
                self.clear(m, "CRO", self.net.runways[r].names.join("/"));
            }
            self.take_ahead(m);
            if self.taxies_now(m) {
                self.movers[m].phase = Phase::Taxiing;
                self.drives_by_day(m);
                let (net, pieces) = (self.net.clone(), self.pieces.clone());
                let mover = &mut self.movers[m];
                mover.way.limit(&net, &pieces, &mover.driving, &Roll::NONE);
                self.clear(m, "TAX", String::new());
                self.taxiing(m);
                return;
            }
        }
        let mover = &self.movers[m];
        let end = if off { self.authority(m) } else { mover.way.stop_m };
        let dec = if off { mover.off_mps2 } else { (1.2 * mover.braking).min(mover.most_mps2) };
        let wish = if now < mover.ready_s {
            mover.v
        } else {
            mover.way.most_mps(mover.s + 0.3 * mover.v).min(mover.v.max(15.0)).min(mover.most_mps())
        };
        let ahead_m = (mover.off_to_m - mover.s, end - mover.s);
        let stop_mps = off_speed_mps(&mover.driving, mover.off_mps2, ahead_m);
        let wish = if off { wish.min(stop_mps) } else { wish };
        let wish = if mover.stopped { 0.0 } else { wish };
        let (wish, dec) = match self.wish_by_sight(m) {
            Some((most, hard)) if most < wish => (most, hard),
            _ => (wish, dec),
        };
        let limits = Tick { acc: 0.5, dec, jerk: ROLL_JERK_MPS3, dt: self.step_s };
        let mover = &mut self.movers[m];
        let (s, v, a) = (mover.s, mover.v, mover.a);
        (mover.s, mover.v, mover.a) = limits.tick(s, v, a, wish, end);
        self.follow(m, s);
        self.release_behind(m);
    }

    /// Whether somebody on his exit is as slow as who taxies, and can stop for what is not his own as such a one does.
    fn taxies_now(&self, m: usize) -> bool {
        let (mover, d) = (&self.movers[m], &self.movers[m].driving);
        let stops_m = stopping(mover.v, 0.0, 0.9 * d.dec_mps2, d.jerk_mps3, 0.0).0;
        let dec_mps2 = STOPS_SHARE * d.dec_mps2;
        let meets = mover.way.meets((mover.s, mover.off_to_m + mover.v), mover.v, dec_mps2);
        let stops = mover.v == 0.0 || meets && stops_m <= self.authority(m) - mover.s;
        mover.v <= d.straight_mps && stops
    }
}
