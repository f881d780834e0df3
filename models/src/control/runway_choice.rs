//! Which runway ends are in use, by the wind.

use crate::frames::Vector2;

/// A configuration of an airport: directions in which it lands and departs.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// Directions of take-offs and landings, unit vectors.
    pub directions: Vec<Vector2<f64>>,
}

/// Limits of the choice (assumed; free to be set).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindLimits {
    /// Largest tail wind, m/s.
    pub tail_mps: f64,
    /// Largest cross wind, m/s.
    pub cross_mps: f64,
    /// Least time between two changes, s.
    pub hold_s: f64,
}

impl Default for WindLimits {
    fn default() -> Self {
        Self { tail_mps: 2.5, cross_mps: 12.0, hold_s: 1800.0 }
    }
}

/// The configuration to use: of those within the limits in all directions the one with the largest least head
/// wind. The present one stays for `hold_s` after a change while it is within the limits, and always if no other is.
/// `wind_mps`: where the air goes, east and north.
#[must_use]
pub fn choose(
    configurations: &[Configuration],
    wind_mps: Vector2<f64>,
    present: Option<(usize, f64)>,
    limits: &WindLimits,
) -> Option<usize> {
    let worst = |c: &Configuration| {
        let head = c.directions.iter().map(|d| -wind_mps.dot(d)).fold(f64::INFINITY, f64::min);
        let cross = c.directions.iter().map(|d| wind_mps.perp(d).abs()).fold(0.0, f64::max);
        (head, cross)
    };
    let within = |i: usize| {
        let (head, cross) = worst(&configurations[i]);
        head >= -limits.tail_mps && cross <= limits.cross_mps
    };
    let present = present.filter(|(i, _)| *i < configurations.len());
    if let Some((i, since_s)) = present
        && since_s < limits.hold_s
        && within(i)
    {
        return Some(i);
    }
    let head = |i: usize| worst(&configurations[i]).0;
    let mut best: Option<usize> = None;
    for i in (0..configurations.len()).filter(|i| within(*i)) {
        // The present one wins a tie.
        let tie = best.is_some_and(|b| head(i) == head(b)) && present.is_some_and(|(p, _)| p == i);
        if best.is_none_or(|b| head(i) > head(b)) || tie {
            best = Some(i);
        }
    }
    best.or(present.map(|(i, _)| i))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_wind_decides_and_a_change_waits() {
        let of = |x: f64, y: f64| Configuration { directions: vec![Vector2::new(x, y)] };
        let both = [of(1.0, 0.0), of(-1.0, 0.0)];
        let limits = WindLimits::default();
        let east = Vector2::new(6.0, 0.0);
        for (name, wind, present, expected) in [
            ("air goes east: take off towards west", east, None, Some(1)),
            ("calm keeps the present one", Vector2::zeros(), Some((1, 4000.0)), Some(1)),
            (
                "a little tail wind soon after a change",
                Vector2::new(2.0, 0.0),
                Some((0, 60.0)),
                Some(0),
            ),
            ("and later", Vector2::new(2.0, 0.0), Some((0, 1900.0)), Some(1)),
            ("too much tail wind at once", east, Some((0, 60.0)), Some(1)),
            (
                "cross wind beyond the limits of all: stay",
                Vector2::new(0.0, 20.0),
                Some((0, 60.0)),
                Some(0),
            ),
            ("and nothing to stay with", Vector2::new(0.0, 20.0), None, None),
        ] {
            assert_eq!(choose(&both, wind, present, &limits), expected, "{name}");
        }
    }
}
