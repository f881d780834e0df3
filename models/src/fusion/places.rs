//! How well each sensor sees each part of the airport: counts on a grid, learnt from confirmed tracks.
//!
//! Beta-distributed: the sensor's stated probability counts as ten looks. One probability for all places ends tracks in
//! shadows and keeps dead ones alive in the open.

use crate::frames::Point2;
use crate::plot::SensorId;
use std::collections::BTreeMap;

/// A square of the grid, as a sensor sees it.
pub(super) type Place = (SensorId, [i32; 2]);

/// Side of a square, m.
const SIDE_M: f64 = 100.0;
/// Looks that what the sensor states counts for.
const PRIOR_LOOKS: f64 = 10.0;
/// Squares that are kept; those beyond count as stated.
const MOST_PLACES: usize = 65_536;
/// Nothing is seen for certain, and nothing is certainly not.
const LIMITS: [f64; 2] = [0.01, 0.999];

/// Looks with and without a plot, by place.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    counts: BTreeMap<Place, [f64; 2]>,
}

/// The square of a position.
pub(super) fn place_of(sensor: SensorId, position_m: Point2<f64>) -> Place {
    // Casts saturate: what is far off shares the last square.
    (sensor, [(position_m.x / SIDE_M).floor() as i32, (position_m.y / SIDE_M).floor() as i32])
}

impl Places {
    /// Probability of a plot there; `stated` by the sensor.
    pub(super) fn detection(&self, place: &Place, stated: f64) -> f64 {
        let [with, without] = self.counts.get(place).copied().unwrap_or_default();
        let [low, high] = LIMITS;
        ((PRIOR_LOOKS * stated + with) / (PRIOR_LOOKS + with + without)).clamp(low, high)
    }

    /// A look at a target that was there, with or without a plot.
    pub(super) fn learn(&mut self, place: Place, seen: bool) {
        let full = self.counts.len() >= MOST_PLACES;
        if full && !self.counts.contains_key(&place) {
            return;
        }
        self.counts.entry(place).or_default()[usize::from(!seen)] += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shadow_is_learnt_where_it_is_and_only_for_its_sensor() {
        let mut places = Places::default();
        let at = |x: f64| place_of(SensorId(1), Point2::new(x, 0.0));
        for _ in 0..200 {
            places.learn(at(50.0), false);
            places.learn(at(150.0), true);
        }
        assert!(places.detection(&at(99.0), 0.9) < 0.05);
        assert!(places.detection(&at(101.0), 0.9) > 0.99);
        assert_eq!(places.detection(&at(250.0), 0.9), 0.9);
        let other = place_of(SensorId(2), Point2::new(50.0, 0.0));
        assert_eq!(places.detection(&other, 0.9), 0.9);
    }

    #[test]
    fn no_more_squares_are_kept_than_there_is_room_for() {
        let mut places = Places::default();
        for n in 0..(MOST_PLACES + 500) {
            let far = Point2::new(n as f64 * SIDE_M, f64::from(u32::MAX) * 1e6);
            places.learn(place_of(SensorId(1), far), true);
        }
        assert_eq!(places.counts.len(), MOST_PLACES);
        // Those that are kept go on to learn.
        let first = place_of(SensorId(1), Point2::new(0.0, f64::from(u32::MAX) * 1e6));
        let before = places.detection(&first, 0.5);
        places.learn(first, false);
        assert!(places.detection(&first, 0.5) < before);
    }

    #[test]
    fn what_is_stated_counts_for_ten_looks() {
        let mut places = Places::default();
        let place = place_of(SensorId(1), Point2::new(-1.0, 100.0));
        assert_eq!(place, (SensorId(1), [-1, 1]));
        for seen in [true, true, false, true] {
            places.learn(place, seen);
        }
        assert_eq!(places.detection(&place, 0.8), 11.0 / 14.0);
        let [never, always] = [0.0, 1.0].map(|stated| Places::default().detection(&place, stated));
        assert_eq!((never, always), (0.01, 0.999));
    }
}
