//! Runways: who has them, wake, and when somebody may enter.

use super::plan::LANDING_AHEAD_S;
use super::{Core, Direction, Flight, Phase};
use crate::flight_list::WakeCategory;
#[cfg(test)]
use crate::traffic::runway_roll::NAUTICAL_MILE_M;
use crate::traffic::runway_roll::{TakeOff, approach_time_s, take_off_run};

impl Core {
    /// Whether a departure may go onto the runway now: wake and arrivals.
    pub(super) fn may_line_up(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        for (o, other) in self.movers.iter().enumerate() {
            let near =
                other.phase == Phase::Final && self.crossing[r].contains(&self.flights[o].runway.0);
            if near && !other.cleared && other.landing_s - self.time_s < 135.0 {
                return false;
            }
        }
        self.wake_left_s(m) < 30.0 && !self.car_blocks(r)
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

    /// Whether a departure of this runway or of one that crosses it will want it soon.
    pub(super) fn departures_wait(&self, r: usize) -> bool {
        (0..self.movers.len()).any(|m| {
            let f = &self.flights[m];
            let soon = match self.movers[m].phase {
                Phase::Absent | Phase::Parked => (f.time_s - self.time_s).abs() < 300.0,
                Phase::Pushing | Phase::Starting(_) | Phase::Taxiing => true,
                _ => false,
            };
            soon && f.direction == Direction::Departure && self.crossing[r].contains(&f.runway.0)
        })
    }

    /// Whether somebody else has this runway or one that crosses it.
    pub(super) fn owned(&self, m: usize) -> bool {
        let r = self.flights[m].runway.0;
        self.crossing[r].iter().any(|c| self.owner[*c].is_some_and(|o| o != m))
    }

    /// Off the runway: the next one may have it.
    pub(super) fn vacate(&mut self, m: usize) {
        for owner in &mut self.owner {
            if *owner == Some(m) {
                *owner = None;
            }
        }
    }

    pub(super) fn wake_left_s(&self, m: usize) -> f64 {
        let r = self.flights[m].runway.0;
        let behind = self.crossing[r].iter().filter_map(|c| self.last_take_off[*c]);
        let run_s = self.run_s(m);
        let left = behind.map(|before| {
            let gap_s = departure_gap_s(before.wake, self.flights[m].wake) - self.time_s;
            // From roll to roll and from lift-off to lift-off.
            (before.rolled_s + gap_s).max(before.airborne_s + gap_s - run_s)
        });
        left.fold(0.0, f64::max)
    }

    /// From the begin of a take-off run to the lift-off, s.
    pub(super) fn run_s(&self, m: usize) -> f64 {
        let run = take_off_run(&take_off_of(&self.flights[m]));
        SPOOL_S + run.map_or(40.0, |r| r.time_s)
    }

    pub(super) fn may_roll(&self, m: usize) -> bool {
        self.wake_left_s(m) <= 0.0 && !self.car_blocks(self.flights[m].runway.0)
    }
}

/// What the building-up of thrust adds to a take-off run, s.
const SPOOL_S: f64 = 2.5;

/// The last take-off on a runway.
#[derive(Clone, Copy, Debug)]
pub(super) struct TookOff {
    pub rolled_s: f64,
    pub airborne_s: f64,
    pub wake: WakeCategory,
}

/// The take-off run of a flight on a day without wind at sea level.
pub(super) fn take_off_of(f: &Flight) -> TakeOff {
    TakeOff {
        liftoff_mps: f.take_off.0,
        distance_m: f.take_off.1,
        density_ratio: 1.0,
        headwind_mps: 0.0,
        end_ratio: 0.75,
        thrust_exponent: 0.7,
        rolling_friction: 0.02,
    }
}

/// Time between departures on one runway, s (ICAO wake categories, at least 60 s).
#[must_use]
pub fn departure_gap_s(first: WakeCategory, then: WakeCategory) -> f64 {
    use WakeCategory::{Heavy as H, Light as L, Medium as M, Super as J};
    match (first, then) {
        (J, H) => 120.0,
        (J, M | L) => 180.0,
        (H, M | L) | (M, L) => 120.0,
        _ => 60.0,
    }
}

/// Time between arrivals on one runway, s: 3.8 NM at 70 m/s, light ones 6 NM (assumed), and at the follower's speed the
/// distance that its wake category wants behind the one before, with 0.3 NM of room.
pub(super) fn arrival_gap_s(first: WakeCategory, then: &Flight) -> f64 {
    let usual_s = if then.wake == WakeCategory::Light { 170.0 } else { 130.0 };
    let apart_nm = landing_gap_nm(first, then.wake) + 0.3;
    let wake_s = approach_time_s(then.landing.0, 0.0, apart_nm.max(4.0)).unwrap_or(usual_s);
    wake_s.max(usual_s)
}

/// Least distance between two landings on one runway, NM (ICAO wake categories, at least 3 NM; from memory).
#[must_use]
pub fn landing_gap_nm(first: WakeCategory, then: WakeCategory) -> f64 {
    use WakeCategory::{Heavy as H, Light as L, Medium as M, Super as J};
    match (first, then) {
        (J, J) | (H, J) | (M | L, J | H | M) | (L, L) => 3.0,
        (H, H) => 4.0,
        (J, H) | (H, M) | (M, L) => 5.0,
        (H, L) => 6.0,
        (J, M) => 7.0,
        (J, L) => 8.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_follower_of_a_super_keeps_seven_miles() {
        let follower = |wake, touchdown: f64| Flight {
            callsign: String::new(),
            size: crate::traffic::outline::Size { length_m: 40.0, span_m: 35.0, aircraft: true },
            direction: super::super::Direction::Arrival,
            runway: (0, 0),
            stand: 0,
            time_s: 0.0,
            turnaround_of: None,
            wake,
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
            let gap_s = arrival_gap_s(Super, &follower(Medium, touchdown));
            // Flown at the slowest speed of the approach it is at least the distance.
            assert!(gap_s * 82.5 > 7.0 * NAUTICAL_MILE_M, "{touchdown}: {gap_s}");
            assert!(gap_s < 7.0 * NAUTICAL_MILE_M / touchdown + 15.0, "{touchdown}: {gap_s}");
            assert_eq!(arrival_gap_s(Medium, &follower(Medium, touchdown)), 130.0);
        }
        assert!(arrival_gap_s(Super, &follower(Light, 50.0)) > 230.0);
    }
}
