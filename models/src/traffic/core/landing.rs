//! From the final to off the runway: final, go-around, landing roll and turn-off.

use super::drive::{ROLL_JERK_MPS3, Tick};
use super::failures::FailureKind;
use super::{Core, Phase, SLOPE, Timing};
use crate::control::clearance::ClearanceKind;
use crate::frames::Azimuth;
use crate::traffic::path::Path;
use crate::traffic::profile::{stopping, stopping_speed_mps};
use crate::traffic::runway_roll::{NAUTICAL_MILE_M, approach_airspeed_mps};
use crate::traffic::way::{Driving, Roll, Way};

/// Height over the threshold, and at which a flare begins at the earliest, m, and the sink that is left at its end, m/s
/// (traffic.md 2.6).
const FLARE_M: f64 = 15.0;
const TOUCHES_MPS: f64 = 0.6;
/// A flare takes so long at least, s (assumed).
const SHORTEST_S: f64 = 6.0;

/// The last of a final over a runway: the slope, a flare over which its sink falls linearly to [`TOUCHES_MPS`], and a float with that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Flare {
    /// Way of the flare, m.
    flare_m: f64,
    /// Way from its end to the touchdown, m.
    float_m: f64,
    /// Height lost on a metre of that.
    end: f64,
}

impl Flare {
    /// Of somebody who touches down with this speed over the ground so far behind the threshold: as high over that as
    /// [`FLARE_M`], by a later flare or a float; who comes down nearer than the slope and the latest flare let crosses it lower, who
    /// floats for ever higher.
    pub(super) fn of(touchdown_mps: f64, behind_m: f64) -> Self {
        let end = (TOUCHES_MPS / touchdown_mps.max(1.0)).min(0.8 * SLOPE);
        let usual_m = 2.0 * FLARE_M / (SLOPE + end);
        let shortest_m = (SHORTEST_S * touchdown_mps).min(usual_m);
        if behind_m <= usual_m {
            let longer = 2.0 / (SLOPE + end) - 1.0 / SLOPE;
            let from_m = ((behind_m - FLARE_M / SLOPE) / longer).min(FLARE_M);
            let flare_m = (2.0 * from_m / (SLOPE + end)).max(shortest_m);
            return Self { flare_m, float_m: 0.0, end };
        }
        let flare_m = 2.0 * (FLARE_M - end * behind_m) / (SLOPE - end);
        let flare_m = flare_m.clamp(shortest_m, usual_m);
        let most_m = (FLARE_M - 0.5 * (SLOPE + end) * flare_m) / end;
        Self { flare_m, float_m: (behind_m - flare_m).min(most_m), end }
    }

    /// Height so far before the touchdown, m.
    pub(super) fn height_m(self, before_m: f64) -> f64 {
        let Self { flare_m, float_m, end } = self;
        let floats_m = before_m.clamp(0.0, float_m);
        let flares_m = (before_m - float_m).clamp(0.0, flare_m);
        let slopes_m = (before_m - float_m - flare_m).max(0.0);
        let steeper = (SLOPE - end) / (2.0 * flare_m.max(1e-9));
        end * floats_m + (end + steeper * flares_m) * flares_m + SLOPE * slopes_m
    }
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
        mover.height_m = mover.flare.height_m(before_m);
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
            mover.measures.head_mps = head_mps;
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
        mover.measures.on_runway_s = [None; 2];
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
                self.movers[m].taxi_from_s = now;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever comes down wherever: the slope and its sink without a jump, 0.6 m/s at the touchdown, and as high over the threshold as
    /// the slope puts him, but for who comes down nearer than he can from there.
    #[test]
    fn a_flare_ends_a_slope_of_fifteen_metres_over_the_threshold() {
        for mps in [14.0, 22.0, 29.0, 40.0, 55.0, 70.0, 80.0] {
            for behind_m in [150.0, 220.0, 290.0, 330.0, 420.0, 500.0, 640.0, 900.0] {
                let flare = Flare::of(mps, behind_m);
                let over_m = flare.height_m(behind_m);
                // The nearest at which the latest flare ends from the full height.
                let end = 0.6 / mps;
                let latest_m = (0.5 * (SLOPE + end) * SHORTEST_S * mps).min(FLARE_M);
                let nearest_m = (FLARE_M - latest_m) / SLOPE + 2.0 * latest_m / (SLOPE + end);
                let what = format!("{mps} m/s, {behind_m} m: {over_m} m, {flare:?}");
                let shortest_m = (SHORTEST_S * mps).min(2.0 * FLARE_M / (SLOPE + end));
                if behind_m < shortest_m {
                    // It crosses the threshold in its flare.
                    let steeper = (SLOPE - end) / (2.0 * shortest_m);
                    let expected_m = (end + steeper * behind_m) * behind_m;
                    assert!((over_m - expected_m).abs() < 0.2, "{what}, {expected_m} m");
                } else if behind_m < nearest_m {
                    let lower_m = SLOPE * (nearest_m - behind_m);
                    assert!((over_m - (FLARE_M - lower_m)).abs() < 0.2, "{what}, {lower_m} m");
                } else if 0.5 * (SLOPE - end) * shortest_m + end * behind_m <= FLARE_M {
                    assert!((over_m - FLARE_M).abs() < 1e-6, "{what}");
                } else {
                    assert!((FLARE_M - 1e-6..45.0).contains(&over_m), "{what}");
                }
                let sink_mps = |m: f64| (flare.height_m(m + 0.01) - flare.height_m(m)) / 0.01 * mps;
                assert!((sink_mps(0.0) - 0.6).abs() < 0.02, "{what}: {}", sink_mps(0.0));
                assert!((sink_mps(1500.0) - SLOPE * mps).abs() < 1e-6, "{what}");
                for k in 0..1500 {
                    let (now, then) = (sink_mps(f64::from(k)), sink_mps(f64::from(k + 1)));
                    assert!(then >= now - 1e-6 && then - now < 0.06, "{what}: {now} {then} at {k}");
                }
            }
        }
    }
}
