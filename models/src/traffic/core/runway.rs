//! Runways: who has them, wake, and when somebody may enter.

use super::plan::LANDING_AHEAD_S;
use super::{Core, Direction, Phase};
use crate::flight_list::WakeCategory;

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
        let left = behind
            .map(|(time, wake)| time + departure_gap_s(wake, self.flights[m].wake) - self.time_s);
        left.fold(0.0, f64::max)
    }

    pub(super) fn may_roll(&self, m: usize) -> bool {
        self.wake_left_s(m) <= 0.0 && !self.car_blocks(self.flights[m].runway.0)
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

/// Time between arrivals on one runway, s: 3.8 NM at 70 m/s, light ones 6 NM (assumed in place of a table of
/// pairs).
pub(super) fn arrival_gap_s(wake: WakeCategory) -> f64 {
    if wake == WakeCategory::Light { 170.0 } else { 130.0 }
}
